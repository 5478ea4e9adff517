"""Figures from specs: curves, bars, stems, heat maps and marks, in one panel or in several.

    chart("Force over speed", Panel([Curve(x, y, name="sun"), Mark(y=0)], y="force [kN]"), x="speed [%]")

A spec says what is drawn; `chart` makes the axes, one entry of the legend a name, and what stands under the pointer,
with the units that the titles of the axes have.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import ArrayLike

from ...limits import RESONANCE_BAND
from ..series import Array, Series, compact, thinned
from .style import DASHES, INK, OUTSIDE, PALETTE, branch_colour, figure, note, panels, translucent

Look = Mapping[str, Any]
Trace = dict[str, Any]
FROM_ZERO: Look = MappingProxyType({"rangemode": "tozero"})
"""An axis that has zero on it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layer:
    """What all that lies in a panel is given.

    name : in the legend once; without one it has no entry.  group : of the legend, else that of the name.
    key : whether it has an entry.  colour : else the next of the palette.
    text : of each point or bar.  hover : what stands under the pointer, a plotly template; the usual where empty,
    nothing where None.  look : anything else, as of the plotly trace.
    """

    name: str = ""
    group: str = ""
    key: bool = True
    colour: Any = None
    text: Sequence[Any] = ()
    hover: str | None = ""
    look: Look = field(default_factory=dict)

    def traces(self, units: tuple[str, str]) -> Iterator[Trace]:
        """Plotly traces; units of x and y with a space before them."""
        raise NotImplementedError

    def said(self, usual: str) -> Trace:
        """Texts, what stands under the pointer, and what else is given."""
        words = self.hover or usual
        hover = {"hovertemplate": words if "<extra>" in words else f"{words}<extra></extra>"}
        texts = {"text": list(self.text)} if len(self.text) else {}
        return {**texts, **({"hoverinfo": "skip"} if self.hover is None else hover), **self.look}


@dataclass(frozen=True, slots=True, eq=False)
class Curve(Layer):
    """y over x (k,) as a line, as points, or both.

    width, dash, shape : of the line, none of width 0 where there are points.  points, symbol, outline : sizes and forms
    of the points, none of size 0.  digits : significant ones of x and of y.
    """

    x: Any
    y: Any
    _: KW_ONLY
    width: float = 1.8
    dash: str | None = None
    shape: str | None = None
    points: Any = 0
    symbol: str | None = None
    outline: float = 0
    digits: tuple[int, int] = (5, 5)

    @property
    def line(self) -> Trace:
        """Its line, as of plotly."""
        return {"color": self.colour, "width": self.width, "dash": self.dash, "shape": self.shape}

    @property
    def marker(self) -> Trace:
        """Its points, as of plotly."""
        outline = {"line": {"width": self.outline}} if self.outline else {}
        look = {"color": self.colour, "size": self.points, "symbol": self.symbol}
        return {**look, **outline, **self.look.get("marker", {})}

    def traces(self, units: tuple[str, str]) -> Iterator[Trace]:
        """One trace."""
        usual = f"{f'{self.name}: ' if self.name else ''}%{{y:.4g}}{units[1]} at %{{x:.5g}}{units[0]}"
        looks = {"markers": {"marker": self.marker}} if np.any(self.points) else {}
        if self.width or not looks:  # the edge of a filled area is a line of no width
            looks = {"lines": {"line": self.line}, **looks}
        x, y = (compact(one, digits=digits) for one, digits in zip((self.x, self.y), self.digits, strict=True))
        trace = {"type": "scatter", "x": x, "y": y, "mode": "+".join(looks), **self.said(usual)}
        yield {**trace, **{name: look for one in looks.values() for name, look in one.items()}}


def points(x: ArrayLike, y: ArrayLike, size: Any = 6, **more: Any) -> Curve:
    """Points without a line; more : as of a `Curve`."""
    return Curve(x, y, width=0, points=size, **more)


@dataclass(frozen=True, slots=True, eq=False)
class Stems(Curve):
    """Strokes from `foot` up to y over x (k,), or along x where they are level, with points as heads."""

    _: KW_ONLY
    foot: float = 0.0
    level: bool = False

    def traces(self, units: tuple[str, str]) -> Iterator[Trace]:
        """Strokes, which have no entry in the legend, and heads."""
        x, y = ([value for one in values for value in (one, one, None)] for values in (self.x, self.y))
        (x if self.level else y)[::3] = [self.foot] * len(self.x)
        silent = {"showlegend": False, "hoverinfo": "skip"}
        yield {"type": "scatter", "x": x, "y": y, "mode": "lines", "line": self.line, **silent}
        heads = {"x": self.x, "y": self.y, "mode": "markers", **self.said("%{text}")}
        yield {"type": "scatter", **heads, "marker": self.marker}


@dataclass(frozen=True, slots=True, eq=False)
class Bars(Layer):
    """Bars of `values` (k,) at `at` (k,), upright or level ones, their texts behind them.

    colour : one, or one of each.  base : where they begin.
    """

    at: Sequence[Any]
    values: Sequence[float | None]
    _: KW_ONLY
    level: bool = False
    base: float | Sequence[float] = 0.0

    def ends(self) -> Array:
        """Where they begin and end, (2, k)."""
        values = np.array(self.values, dtype=np.float64)
        return np.array([values * 0 + self.base, values + self.base])

    def traces(self, units: tuple[str, str]) -> Iterator[Trace]:
        """One trace."""
        ways = {"y": self.at, "x": self.values, "orientation": "h"} if self.level else {"x": self.at, "y": self.values}
        outside = OUTSIDE if len(self.text) else {}
        said = self.said(f"%{{{'y' if self.level else 'x'}}}: %{{text}}")
        yield {"type": "bar", **ways, "base": self.base or None, "marker": {"color": self.colour}, **outside, **said}


@dataclass(frozen=True, slots=True, eq=False)
class Heat(Layer):
    """Rows of values (y, x) as colours, y numbers or names; `look` has their scale, as of a plotly heat map.

    digits : significant ones of x and of y, and of the values.
    """

    x: Any
    y: Any
    rows: Array
    _: KW_ONLY
    digits: tuple[int, int] = (5, 4)

    def traces(self, units: tuple[str, str]) -> Iterator[Trace]:
        """One trace."""
        named = isinstance(self.y[0], str)
        x, y = (compact(one, digits=self.digits[0]) for one in (self.x, () if named else self.y))
        rows = [compact(row, digits=self.digits[1]) for row in self.rows]
        said = self.said(f"%{{x:.4g}}{units[0]}, %{{y:.4g}}{units[1]}")
        yield {"type": "heatmap", "x": x, "y": self.y if named else y, "z": rows, **said}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mark(Layer):
    """A straight line across the panel at x or at y, or a band from x `to` another x.

    below : behind the curves, as bands are.  words : written on it, `where` as of a plotly annotation.
    """

    x: float | None = None
    y: float | None = None
    to: float | None = None
    colour: str = INK
    width: float = 1.2
    dash: str | None = None
    below: bool = False
    words: str = ""
    where: Look = field(default_factory=dict)

    @property
    def line(self) -> Trace:
        """Its line, as of plotly."""
        return {"color": self.colour, "width": self.width, "dash": self.dash}

    def traces(self, units: tuple[str, str]) -> Iterator[Trace]:
        """What stands for it in the legend."""
        square = {"mode": "markers", "marker": {"color": self.colour, "size": 12, "symbol": "square"}}
        look = square if self.to is not None else {"mode": "lines", "line": self.line}
        yield {"type": "scatter", "x": [None], "y": [None], "showlegend": None, **look}

    def shape(self, x: str, y: str) -> Trace:
        """As a plotly shape over the axes x and y."""
        look = {"type": "line", "line": self.line, **({"layer": "below"} if self.below else {})}
        if self.y is not None:
            return {**look, "x0": 0, "x1": 1, "xref": f"{x} domain", "y0": self.y, "y1": self.y, "yref": y}
        if self.to is not None:
            look = {"type": "rect", "fillcolor": self.colour, "line": {"width": 0}, "layer": "below"}
        last = self.x if self.to is None else self.to
        return {**look, "x0": self.x, "x1": last, "xref": x, "y0": 0, "y1": 1, "yref": f"{y} domain"}


OPERATING_BAND = Mark(x=100 * (1 - RESONANCE_BAND), to=100 * (1 + RESONANCE_BAND), colour=translucent(PALETTE[0], 0.08))
"""The speeds [%] about operation."""


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """Layers over one pair of axes.

    title : of the panel.  x, y : titles of the axes with their units.  x_ends, y_ends : their ranges.
    x_axis, y_axis : more, as of a plotly axis.
    """

    layers: Sequence[Layer]
    title: str = ""
    _: KW_ONLY
    x: str = ""
    y: str = ""
    x_ends: tuple[float, float] | None = None
    y_ends: tuple[float, float] | None = None
    x_axis: Look = field(default_factory=dict)
    y_axis: Look = field(default_factory=dict)


def chart(
    title: str,
    *shown: Panel,
    x: str = "",
    y: str = "",
    x_ends: tuple[float, float] | None = None,
    marks: Sequence[Mark] = (),
    height: float = 420,
    columns: int = 1,
    gap: float | None = None,
    space: Look = MappingProxyType({}),
    **layout: Any,
) -> go.Figure:
    """A figure of its panels, row by row.

    Parameters
    ----------
    title : what the figure shows.  x, y : title of the axis that all panels share, with its unit.  x_ends : its range.
    marks : through every panel, their words in the first.  height : [px].  columns : panels side by side.
    gap : between panels, per the figure.  space : more, as of plotly's `make_subplots`.  layout : as of plotly.
    """
    if len(shown) == 1 and not shown[0].title:
        drawn = figure(title, height=round(height))
    else:
        apart = {f"{'vertical' if columns == 1 else 'horizontal'}_spacing": gap, "shared_xaxes": bool(x)}
        options = {**apart, "shared_yaxes": bool(y), "columns": columns, **space}
        drawn = panels(title, [one.title for one in shown], height=round(height), **options)
    traces: list[tuple[Layer, Trace]] = []
    shapes: list[Trace] = []
    lines: dict[str, Mark] = {}
    for place, panel in enumerate(shown):
        number = str(place + 1) if place else ""
        last, first = place + columns >= len(shown), place % columns == 0
        for axis, words, ends, look in (
            ("x", panel.x or (x if last else ""), panel.x_ends or x_ends, panel.x_axis),
            ("y", panel.y or (y if first else ""), panel.y_ends, panel.y_axis),
        ):
            own = {"title_text": words or None, "range": ends}
            drawn.update_layout({f"{axis}axis{number}": {key: one for key, one in own.items() if one} | dict(look)})
        units = (_unit(panel.x or x), _unit(panel.y or y))
        for layer in (*panel.layers, *marks):
            if isinstance(layer, Mark):
                lines.setdefault(layer.name, layer)
                shapes.append(layer.shape(f"x{number}", f"y{number}"))
                if layer.words and (place == 0 or layer not in marks):
                    where = {"x": layer.x, "y": layer.y, "xref": f"x{number}", "yref": f"y{number}", **layer.where}
                    note(drawn, layer.words, **where)
            else:
                axes = {"xaxis": f"x{number}", "yaxis": f"y{number}"}
                traces += [(layer, {**axes, **one}) for one in layer.traces(units)]
    traces += [(mark, one) for name, mark in lines.items() if name for one in mark.traces(("", ""))]
    drawn.add_traces(_with_legend(traces))
    return drawn.update_layout(shapes=shapes, **layout)


def _with_legend(traces: Sequence[tuple[Layer, Trace]]) -> list[Trace]:
    """Traces with their names, each once in the legend; what has one name is shown and hidden together."""
    count = Counter(layer.name for layer, _ in traces)
    seen: set[str] = set()
    found = []
    for layer, trace in traces:
        group = layer.group or (layer.name if count[layer.name] > 1 else "")
        first = bool(layer.name) and layer.key and layer.name not in seen
        found.append({"name": layer.name or None, "legendgroup": group or None, "showlegend": first, **trace})
        seen |= {layer.name} if found[-1]["showlegend"] else set()
    return found


def _unit(title: str) -> str:
    """Unit in the title of an axis behind a space; "" of none and of 1."""
    unit = re.search(r"\[([^]]*)\]", title)
    return f" {unit[1]}" if unit and unit[1] not in ("-", "1") else ""


def cycled(place: int, dashes: int = len(PALETTE)) -> Trace:
    """Colour and dash of a `Curve` by its place among others; dashes : curves after which the dash changes."""
    return {"colour": PALETTE[place % len(PALETTE)], "dash": DASHES[place // dashes % len(DASHES)]}


def pair_panels(
    groups: Mapping[str, Sequence[Series]], x: Array, y: str, *, most: int = 1200, **look: Any
) -> list[Panel]:
    """A panel a pair of gears, a curve a branch, those of the right helix dashed.

    Parameters
    ----------
    groups : of `by_panel`, values in the unit of y.  x : (k,).  y : title of the ordinates with their unit.
    most : samples of a curve.  look : of all curves, as of `Curve`.
    """
    shown = []
    for title, series in groups.items():
        curves = []
        for one in series:
            fewer, values = thinned(x, one.values, most=most)
            own: Trace = {"name": one.label, "colour": branch_colour(one.branch), "dash": DASHES[one.side == "right"]}
            curves.append(Curve(fewer, values, **own, **look))
        shown.append(Panel(curves, title=title, y=y))
    return shown


def level_bars(
    title: str,
    names: Sequence[str],
    *shown: Panel,
    row: float = 34,
    room: float = 0.3,
    nothing: str = "",
    **layout: Any,
) -> go.Figure:
    """Level bars of the names from the top, panels side by side, with room for their texts.

    Where some fall below zero there is a line.

    Parameters
    ----------
    title : what the figure shows.  shown : `Bars` over the names.  row : height of a name [px].
    room : for texts, per what the bars take.  nothing : said where there is no name.  layout : as of plotly.
    """
    order = {"categoryorder": "array", "categoryarray": [*names][::-1], "showgrid": False}
    filled = []
    for panel in shown:
        ends = np.hstack([np.zeros((2, 1)), *(layer.ends() for layer in panel.layers if isinstance(layer, Bars))])
        low, high = float(np.nanmin(ends)), float(np.nanmax(ends))
        span = room * ((high - low) or 1.0)
        reach = (low - span if low < 0 else 0.0, high + span * (1.0 if high > 0 or low == 0 else 0.1))
        zero = [Mark(x=0)] if low < 0 else []
        filled.append(replace(panel, layers=[*panel.layers, *zero], x_ends=reach, y_axis=order))
    space = {"shared_yaxes": True, "horizontal_spacing": 0.05}
    look = {"height": 150 + row * max(len(names), 1), "columns": len(shown), "bargap": 0.3, "space": space}
    drawn = chart(title, *filled, **{**look, **layout})
    if not names and nothing:
        note(drawn, nothing, x=0.5, xref="paper", y=0.5, yref="paper")
    return drawn
