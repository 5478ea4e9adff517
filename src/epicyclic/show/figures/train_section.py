"""The train from the side: axial half section to scale, helices, supports and bearings as symbols."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .parts import Part, faces, parts
from .series import Array, compact, engineering, numbers, texts
from .style import INK, PALE, figure, kind_colour, tint, translucent, wide_height

__all__ = ["train_section", "widths_given"]

_DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
_UNITS = ("N/m", "N/m", "N/m", "N m/rad", "N m/rad", "N m/rad")


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """What one stage shows: its bodies turned into the plane of the drawing; axial ends of its gears and its place [m].

    low, high : ends of the gears.  reach : length of a stub shaft.  shift : added to z.
    """

    shown: tuple[Part, ...]
    low: float
    high: float
    reach: float
    shift: float

    @property
    def top(self) -> float:
        """Largest radius [m]."""
        return max(part.radius + part.outer for part in self.shown)


def train_section(check: xr.Dataset) -> go.Figure:
    """Axial half section to scale [mm] through the axis and branch 1, branches turned into the plane.

    Parameters
    ----------
    check : Dataset of `check`: what `parts.parts` reads (body), (gear); link_stiffness (link, direction) [N/m, N
        m/rad], link_first, link_second (link).
    """
    title = "Axial section, to scale" if widths_given(check) else "Axial section (face widths are not given)"
    drawn = figure(title, x="z [mm]", y="radius [mm]", height=620)
    columns = _columns(parts(check))
    for column in columns:
        drawn.add_traces([trace for part in column.shown for trace in _stub(part, column)])
        order = sorted(column.shown, key=lambda part: part.form is None)
        drawn.add_traces([trace for part in order for trace in _solid(part, column)])
    for column in columns:
        drawn.add_traces(_symbols(check, column, first=column is columns[0]))
    drawn.add_traces([*_couplings(check, columns), _names(columns)])
    _frame(drawn, columns)
    return drawn


def widths_given(check: xr.Dataset) -> bool:
    """Whether every gear has its face width from the model."""
    return "gear" not in check.dims or bool(np.isfinite(numbers(check, "face_width", "gear")).all())


def _columns(found: Sequence[Part]) -> list[Column]:
    """Stages and lone bodies where they stand; where they would lie over each other, one behind the other."""
    result: list[Column] = []
    for place in dict.fromkeys(part.place for part in found):
        shown = tuple(part for part in found if part.place == place and part.branch in (0, 1))
        ends = [end for part in shown for end in _ends(part)]
        top = max(part.radius + part.outer for part in shown)
        column = Column(shown=shown, low=min(ends), high=max(ends), reach=0.10 * top, shift=0.0)
        behind = _right(result[-1]) + 0.55 * min(top, result[-1].top) if result else -math.inf
        shift = max(0.0, behind - (column.low - 2 * column.reach))
        result.append(Column(shown=shown, low=column.low, high=column.high, reach=column.reach, shift=shift))
    return result


def _right(column: Column) -> float:
    return column.high + 2 * column.reach + column.shift


def _ends(part: Part) -> tuple[float, float]:
    """Axial ends of a body [m]; a body without teeth is a thin disc."""
    if part.form is None:
        return part.station - 0.3 * part.width, part.station + 0.3 * part.width
    extent = faces(part)
    return extent[0][0], extent[-1][1]


def _pins(part: Part, column: Column) -> list[Part]:
    return [other for other in column.shown if other.carried_by == part.name]


def _trace(z: Sequence[float] | Array, r: Sequence[float] | Array, options: Mapping[str, Any]) -> go.Scatter:
    """A line through z, r (k,) [m], drawn in [mm]."""
    plain = {"mode": "lines", "hoverinfo": "skip", "showlegend": False}
    return go.Scatter(x=compact(1e3 * np.asarray(z)), y=compact(1e3 * np.asarray(r)), **{**plain, **options})


def _box(along: tuple[float, float], radii: tuple[float, float], look: Mapping[str, Any]) -> go.Scatter:
    (left, right), (low, high) = along, radii
    return _trace([left, right, right, left, left], [low, low, high, high, low], look)


def _look(part: Part) -> dict[str, Any]:
    colour = kind_colour(part.kind)
    held = " (held)" if part.speed == 0 else ""
    mass = f"<br>{engineering(part.mass)} kg" if np.isfinite(part.mass) and part.mass > 0 else ""
    wide = f"<br>face width {engineering(1e3 * part.width)} mm" if part.form else ""
    return {
        "line": {"color": colour, "width": 1.3},
        "fill": "toself",
        "fillcolor": translucent(colour, 0.30) if part.form else tint(colour, 0.6),
        "hoverinfo": "text",
        "hoveron": "fills",
        "text": f"<b>{part.short}</b>{held}{wide}{mass}",
    }


def _solid(part: Part, column: Column) -> list[go.Scatter]:
    if part.form is not None:
        return _gear(part, column.shift)
    pins = _pins(part, column)
    if pins:
        return _carrier(part, pins, column)
    left, right = _ends(part)
    return [_box((left + column.shift, right + column.shift), (0.0, part.outer), _look(part))]


def _gear(part: Part, shift: float) -> list[go.Scatter]:
    assert part.form is not None
    form, look = part.form, _look(part)
    low = form.tip_radius if form.internal else max(0.0, part.radius - form.tip_radius)
    high = part.outer if form.internal else part.radius + form.tip_radius
    extent, traces = faces(part), []
    if len(extent) == 2:
        web = (form.root_radius, high) if form.internal else (_floor(part), part.radius + 0.97 * form.root_radius)
        traces.append(_box((extent[0][1] + shift, extent[1][0] + shift), web, look))
    for left, right, hand in extent:
        traces.append(_box((left + shift, right + shift), (low, high), look))
        if hand:
            traces.append(_helix(part, (left + shift, right + shift), (low, high), hand))
    return traces


def _floor(part: Part) -> float:
    assert part.form is not None
    return max(0.0, part.radius - 0.97 * part.form.root_radius)


def _helix(part: Part, along: tuple[float, float], radii: tuple[float, float], hand: int) -> go.Scatter:
    """Three tooth traces on the side of the gear that looks at the viewer: of a right hand they fall to the right."""
    left, right = along
    slope = -hand * math.tan(part.helix_angle)
    z: list[float] = []
    r: list[float] = []
    for share in (0.2, 0.5, 0.8):
        middle, centre = radii[0] + share * (radii[1] - radii[0]), (left + right) / 2
        reach = min(0.40 * (right - left), 0.12 * (radii[1] - radii[0]) / max(abs(slope), 1e-9))
        z += [centre - reach, centre + reach, math.nan]
        r += [middle - slope * reach, middle + slope * reach, math.nan]
    return _trace(z, r, {"line": {"color": kind_colour(part.kind), "width": 1}})


def _carrier(part: Part, pins: Sequence[Part], column: Column) -> list[go.Scatter]:
    """A plate on either side of the planets, the right one down to its shaft, and the pins between them."""
    look, shift, thick = _look(part), column.shift, 0.35 * column.reach
    left, right = column.low - 0.4 * thick + shift, column.high + 0.4 * thick + shift
    top, floor = max(pin.radius for pin in pins) + 0.12 * pins[0].radius, 0.5 * pins[0].radius
    traces = [_box((left - thick, left), (floor, top), look), _box((right, right + thick), (0.0, top), look)]
    for radius in {round(pin.radius, 9) for pin in pins}:
        size = 0.16 * min((pin.form.root_radius for pin in pins if pin.form), default=0.2 * radius)
        traces.append(_box((left, right), (radius - size, radius + size), look))
    return traces


def _stub(part: Part, column: Column) -> list[go.Scatter]:
    """Shaft of a central member: to the left, of a carrier to the right."""
    if part.branch or (part.form is not None and part.form.internal) or (part.form is None and not _pins(part, column)):
        return []
    half = 0.22 * min((one.form.root_radius for one in column.shown if one.form), default=part.outer)
    right = part.form is None
    start = column.high if right else column.low - 1.6 * column.reach
    stop = column.high + 1.6 * column.reach if right else _ends(part)[0]
    return [_box((start + column.shift, stop + column.shift), (0.0, half), _look(part))]


def _seat(part: Part, column: Column) -> tuple[float, float]:
    """Where a body is held: a planet on its pin, a ring above its rim, a central member at the end of its shaft [m]."""
    if part.branch:
        return part.station + column.shift, part.radius
    if part.form is not None and part.form.internal:
        return part.station + column.shift, part.outer + 0.5 * column.reach
    if part.form is None and not _pins(part, column):
        return part.station + column.shift, 0.0
    end = column.high + 1.6 * column.reach if part.form is None else column.low - 1.6 * column.reach
    return end + column.shift, 0.0


def _symbols(check: xr.Dataset, column: Column, *, first: bool) -> list[go.Scatter]:
    """Bearings of planets and supports of central members."""
    if "link" not in check.dims:
        return []
    place = {part.name: part for part in column.shown}
    stiffness = check["link_stiffness"].transpose("link", "direction").values
    held: dict[str, list[tuple[float, float, str]]] = {"pin bearings": [], "supports": []}
    stems: list[go.Scatter] = []
    rows = zip(texts(check, "link"), texts(check, "link_first"), texts(check, "link_second"), stiffness, strict=True)
    for name, one, other, values in rows:
        part = place[other] if other in place and place[other].branch else place.get(one)
        if part is None or not np.any(values > 0) or (not part.branch and other):
            continue
        z, r = _seat(part, column)
        held["pin bearings" if part.branch else "supports"].append((z, r, _spring(name, values)))
        if r > part.outer and not part.branch:
            stems.append(_trace([z, z], [part.outer, r], {"line": {"color": INK, "width": 1.5}}))
    return [*stems, *(_marks(name, found, first) for name, found in held.items() if found)]


def _marks(name: str, found: Sequence[tuple[float, float, str]], first: bool) -> go.Scatter:
    symbol = {"pin bearings": "circle-x-open", "supports": "square-x-open"}[name]
    z, r = [one[0] for one in found], [one[1] for one in found]
    look = {"symbol": symbol, "size": 12, "color": INK, "line": {"width": 1.6}}
    words = {"hoverinfo": "text", "text": [one[2] for one in found], "name": name}
    return _trace(z, r, {"mode": "markers", "marker": look, **words, "showlegend": first, "legendgroup": name})


def _spring(name: str, values: Array) -> str:
    """The stiffness of a link (6,) [N/m, N m/rad] in words."""
    rows = [
        f"{direction}: {'rigid' if np.isinf(value) else f'{engineering(float(value))} {unit}'}"
        for direction, unit, value in zip(_DIRECTIONS, _UNITS, values, strict=True)
        if value > 0
    ]
    return "<br>".join([f"<b>{name}</b>", *rows])


def _names(columns: Sequence[Column]) -> go.Scatter:
    """Names beside the drawing: of gears to the left at their height, of carriers to the right, of others above."""
    z: list[float] = []
    r: list[float] = []
    words, places = [], []
    for column in columns:
        for part in (one for one in column.shown if one.side != "right" or f"{one.name[:-5]}left" not in _all(column)):
            where, height, place = _label(part, column)
            z.append(where + column.shift)
            r.append(height)
            words.append(part.short.removesuffix(" 1") + (" (held)" if part.speed == 0 else ""))
            places.append(place)
    look = {"textposition": places, "textfont": {"size": 12, "color": INK}}
    return _trace(z, r, {"mode": "text", "text": words, **look})


def _all(column: Column) -> set[str]:
    return {part.name for part in column.shown}


def _label(part: Part, column: Column) -> tuple[float, float, str]:
    if part.form is None and not _pins(part, column):
        return part.station, part.outer + 0.3 * column.reach, "top center"
    left, right = column.low - 0.9 * column.reach, column.high + 0.9 * column.reach
    if part.form is None:
        return right, _pins(part, column)[0].radius, "middle right"
    if part.form.internal:
        return left, (part.form.tip_radius + part.outer) / 2, "middle left"
    return left, part.radius if part.branch else 0.5 * part.form.reference_radius, "middle left"


def _couplings(check: xr.Dataset, columns: Sequence[Column]) -> list[go.Scatter]:
    """Links between central bodies of different stages, as a dashed line from one to the other."""
    if "link" not in check.dims:
        return []
    place = {part.name: (part, column) for column in columns for part in column.shown if not part.branch}
    z: list[float] = []
    r: list[float] = []
    for ends in zip(texts(check, "link_first"), texts(check, "link_second"), strict=True):
        if all(end in place for end in ends) and place[ends[0]][1] is not place[ends[1]][1]:
            for part, column in (place[end] for end in ends):
                ring = part.form is not None and part.form.internal
                z.append(part.station + column.shift)
                r.append(part.outer if ring else 0.5 * part.outer)
            z.append(math.nan)
            r.append(math.nan)
    line = {"color": INK, "width": 1.6, "dash": "dash"}
    return [_trace(z, r, {"line": line, "name": "couplings", "showlegend": True})] if z else []


def _frame(drawn: go.Figure, columns: Sequence[Column]) -> None:
    """Axis line, and a range in which the names beside the drawing have room."""
    low = min((column.low - 2 * column.reach + column.shift for column in columns), default=-1.0)
    high = max((_right(column) for column in columns), default=1.0)
    top = 1.14 * max((column.top for column in columns), default=1.0)
    needed = max(high - low + 0.4 * top, 1.05 * top)
    low, high = (low + high - needed) / 2, (low + high + needed) / 2
    drawn.add_trace(_trace([low, high], [0, 0], {"line": {"color": PALE, "width": 1.2, "dash": "longdashdot"}}))
    drawn.update_xaxes(range=[1e3 * low, 1e3 * high], constrain="domain", showgrid=False)
    drawn.update_yaxes(range=[-0.06e3 * top, 1e3 * top], scaleanchor="x", constrain="domain", showgrid=False)
    if len(columns) > 1:
        drawn.update_layout(height=wide_height(needed, 1.06 * top))
    drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.13, "yanchor": "top"})
