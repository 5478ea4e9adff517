"""Figures from specs, curves, bars, stems, heat maps and marks in panels; and the look of all: one colour-blind safe
palette, one template, titles of axes with their units.

    chart("Force over speed", Panel([Curve(x, y, name="sun"), Mark(y=0)], y="force [kN]"), x="speed [%]")

A spec says what is drawn; `chart` makes the axes, one entry of the legend a name, and what stands under the pointer,
with the units that the titles of the axes have.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import ArrayLike
from plotly.subplots import make_subplots

from ...limits import RESONANCE_BAND
from ..series import Array, Series, compact, thinned

# Okabe and Ito's colour-blind safe set, its yellow (unreadable on white) replaced by violet and grey.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#5B3F8C", "#7A7A7A")
# Of branches.  As of bodies below and loads in `flanks`, none is blue, which on the page is what can be clicked; three
# to one on white; the first four apart for eyes without red or green too, by their lightness (CIE76 21 at the least).
BRANCHES = ("#D55E00", "#00855F", "#D669A3", "#6A1B55", "#7C838A", "#9A7B00", "#8C1D18", "#3F5A00")
DASHES = ("solid", "dash", "dot", "dashdot")
INK, PALE, GRID, WARNING = "#1F2933", "#66727F", "#E3E7EB", "#B42318"
FONT = "'Segoe UI', 'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif"
KIND_COLOURS = {
    "sun": "#B07A00",
    "planet": "#A8527F",
    "ring": "#009E73",
    "carrier": "#7A7A7A",
    "gear": "#7A7F1A",
    "body": "#8A5A3C",
}
MODE_COLOURS = {
    "rigid": "#7A7A7A",
    "rotational": "#D55E00",
    "translational": "#0072B2",
    "planet": "#009E73",
    "ring": "#B07A00",
    "mixed": "#5B3F8C",
}
_SYMBOLS = ("x", "circle", "diamond", "square", "hexagon", "star")
MODE_SYMBOLS = dict(zip(MODE_COLOURS, _SYMBOLS, strict=True))

SPEED_TITLE = f"speed (shaded: operation ± {100 * RESONANCE_BAND:.0f} %) [% of the operating speed]"
# A name to the right of the plot.
BESIDE = {"xref": "paper", "x": 1.005, "xanchor": "left", "yanchor": "middle"}
# Of bars: their numbers stand behind them, also beyond the axes.
OUTSIDE = {"textposition": "outside", "cliponaxis": False}

_AXIS = {
    "showgrid": True,
    "gridcolor": GRID,
    "zeroline": False,
    "linecolor": "#9AA5B1",
    "showline": True,
    "ticks": "outside",
    "ticklen": 5,
    "tickcolor": "#9AA5B1",
    "automargin": True,
    "exponentformat": "none",
    "separatethousands": True,
    "title": {"standoff": 10, "font": {"size": 13}},
    "tickfont": {"size": 12},
}


@cache
def template() -> go.layout.Template:
    """The one template of all figures; each takes a copy."""
    layout = {
        "font": {"family": FONT, "size": 13, "color": INK},
        "title": {
            **{"x": 0, "xref": "container", "xanchor": "left", "y": 1, "yref": "container", "yanchor": "top"},
            **{"pad": {"l": 12, "t": 14}, "font": {"size": 16}},
        },
        "separators": ".\u2009",
        "colorway": list(PALETTE),
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "margin": {"l": 64, "r": 24, "t": 56, "b": 56},
        "legend": {"x": 1.02, "xanchor": "left", "y": 1, "yanchor": "top", "font": {"size": 12}},
        "hoverlabel": {"font": {"family": FONT, "size": 12}, "bgcolor": "white", "bordercolor": "#9AA5B1"},
        "xaxis": _AXIS,
        "yaxis": _AXIS,
        "annotationdefaults": {"font": {"size": 12, "color": INK}},
    }
    return go.layout.Template(layout=layout)


def figure(title: str, *, x: str = "", y: str = "", height: int = 420) -> go.Figure:
    """An empty figure in the house style.

    Parameters
    ----------
    title : what the figure shows.  x, y : titles of the axes, with units.  height : [px].
    """
    axes = {name: {"title": {"text": text}} for name, text in (("xaxis", x), ("yaxis", y)) if text}
    return go.Figure(layout={"template": template(), "title": {"text": title}, "height": height, **axes})


def panels(title: str, names: Sequence[str], *, height: int, columns: int = 1, **options: Any) -> go.Figure:
    """An empty figure of several panels, named.

    Parameters
    ----------
    title : what the figure shows.  names : one per panel, row by row.  height : [px].  columns : panels side by side.
    options : as of plotly's `make_subplots`.
    """
    rows = -(-len(names) // columns)
    drawn = make_subplots(rows=rows, cols=columns, subplot_titles=list(names), **options)
    drawn.update_layout(template=template(), title={"text": title}, height=height)
    drawn.update_annotations(font={"size": 13, "color": PALE})
    return drawn


def level_legend(y: float, *, x: float = 0, **look: Any) -> dict[str, Any]:
    """A legend in a row below the plot (y < 0) or above it, at its left end (x = 0) or at its right one (1)."""
    anchors = {"xanchor": "right" if x else "left", "yanchor": "top" if y < 0 else "bottom"}
    return {"orientation": "h", "x": x, "y": y, **anchors, **look}


def note(drawn: go.Figure, text: str, **where: Any) -> None:
    """Write a plain text without an arrow into the figure; `where` as of a plotly annotation."""
    drawn.add_annotation({"text": text, "showarrow": False, "font": {"size": 12, "color": PALE}, **where})


def wide_height(across: float, tall: float) -> int:
    """Height [px] of a drawing to scale that takes the whole width of the page."""
    return round(min(640.0, max(380.0, 900.0 * tall / across + 170.0)))


def beside(letters: int) -> int:
    """Right margin [px] for names of so many letters of 12 px beside a plot."""
    return round(24 + 7.4 * letters)


def kind_colour(kind: str) -> str:
    """Colour of a kind of body."""
    return KIND_COLOURS.get(kind, KIND_COLOURS["body"])


def mode_colour(kind: str) -> str:
    """Colour of a kind of mode; kinds not known by name share that of mixed modes."""
    return MODE_COLOURS.get(_mode_key(kind), MODE_COLOURS["mixed"])


def mode_symbol(kind: str) -> str:
    """Marker of a kind of mode."""
    return MODE_SYMBOLS.get(_mode_key(kind), MODE_SYMBOLS["mixed"])


def branch_colour(branch: int) -> str:
    """Colour of a branch, 1 the first; meshes without a branch have the last colour."""
    return BRANCHES[(branch - 1) % len(BRANCHES)]


def translucent(colour: str, alpha: float) -> str:
    """``#rrggbb`` with an opacity, as CSS."""
    red, green, blue = (int(colour[place : place + 2], 16) for place in (1, 3, 5))
    return f"rgba({red},{green},{blue},{alpha:g})"


def tint(colour: str, white: float) -> str:
    """``#rrggbb`` mixed with so much white (0..1), opaque."""
    mixed = [int(colour[place : place + 2], 16) for place in (1, 3, 5)]
    return "#" + "".join(f"{round(value + (255 - value) * white):02x}" for value in mixed)


def _mode_key(kind: str) -> str:
    return next((key for key in MODE_COLOURS if kind.startswith(key)), "mixed")


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


def band(x: Array, rows: Sequence[Array], name: str, **look: Any) -> list[Layer]:
    """Mean with its name in the band between least and most, `rows` (3, k) over x (k,); look : as of a `Curve`."""
    least, most, mean = rows
    edge: Trace = {**look, "width": 0, "hover": None}
    fill = {"fill": "tonexty", "fillcolor": translucent(look["colour"], 0.22)}
    return [Curve(x, least, **edge), Curve(x, most, look=fill, **edge), Curve(x, mean, width=2, name=name, **look)]


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
