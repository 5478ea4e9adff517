"""The train from the side: axial section, gears to scale, helices, shafts, couplings, supports, what is held."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .parts import matings
from .section_layout import (
    AIR,
    BODY,
    LANE,
    MARGIN,
    PLATE,
    SEGMENT,
    Column,
    Coupling,
    Group,
    Layout,
    SectionLink,
    layout_of,
    text_width,
)
from .series import Array, compact, engineering, numbers
from .style import INK, PALE, WARNING, figure, kind_colour, note, tint

__all__ = ["train_section", "widths_given"]

_DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
_UNITS = ("N/m", "N/m", "N/m", "N m/rad", "N m/rad", "N m/rad")
_SYMBOLS = {
    "elastic support or bearing": {"symbol": "square-x-open", "color": INK},
    "rigid support or bearing": {"symbol": "square-x", "color": "#9AA5B1"},
}
Key = tuple[str, str, int]


def train_section(check: xr.Dataset) -> go.Figure:
    """Axial section [mm] through the axis and branch 1, branches turned into the plane, stages in series.

    Gears end at their pitch circles, face widths and radii to scale; shafts, couplings and what lies between the
    stages are a scheme.  A half section, or both halves where a branch has planets on two axes.

    Parameters
    ----------
    check : Dataset of `check`: what `section_layout.layout_of` reads.
    """
    layout = layout_of(check)
    given = widths_given(check)
    title = "Axial section, gears to scale" if given else "Axial section, radii to scale (face widths are not given)"
    drawn = figure(title, y="distance from the axis [mm]")
    for column in layout.columns:
        drawn.add_traces(_shafts(column, layout))
    drawn.add_traces(_couplings(layout))
    for column in layout.columns:
        for group in column.groups:
            drawn.add_traces(_solid(group, column, layout))
        drawn.add_traces(_pins(column, layout))
    drawn.add_traces(_meshes(check, layout))
    drawn.add_traces(_supports(layout))
    _names(drawn, layout)
    _frame(drawn, layout)
    return drawn


def widths_given(check: xr.Dataset) -> bool:
    """Whether every gear has its face width from the model."""
    return "gear" not in check.dims or bool(np.isfinite(numbers(check, "face_width", "gear")).all())


def _trace(z: Sequence[float] | Array, r: Sequence[float] | Array, options: Mapping[str, Any]) -> go.Scatter:
    """A line through z, r (k,) [m], drawn in [mm]."""
    plain = {"mode": "lines", "hoverinfo": "skip", "showlegend": False}
    return go.Scatter(x=compact(1e3 * np.asarray(z)), y=compact(1e3 * np.asarray(r)), **{**plain, **options})


def _box(along: tuple[float, float], radii: tuple[float, float], look: Mapping[str, Any]) -> go.Scatter:
    (left, right), (low, high) = along, radii
    return _trace([left, right, right, left, left], [low, low, high, high, low], look)


def _boxes(
    along: tuple[float, float], radii: tuple[float, float], group: Group, layout: Layout, look: Mapping[str, Any]
) -> list[go.Scatter]:
    """A box above the axis, below it, or both where the group turns about the axis."""
    return [_box(along, (sign * radii[0], sign * radii[1]), look) for sign in _signs(group, layout)]


def _signs(group: Group, layout: Layout) -> tuple[int, ...]:
    if group.first.branch:
        return (group.half,)
    return (1, -1) if layout.both and group.first.radius < 1e-9 else (1,)


def _look(group: Group, white: float = 0.62) -> dict[str, Any]:
    """Opaque in a tint of its colour, and what a pointer over it says."""
    colour, first = kind_colour(group.kind), group.first
    teeth = f"<br>{first.form.teeth} teeth" if first.form else ""
    wide = f"<br>face width {engineering(1e3 * first.width)} mm" if first.form else ""
    mass = f"<br>{engineering(first.mass)} kg" if np.isfinite(first.mass) and first.mass > 0 else ""
    held = "<br>held" if group.held else ""
    return {
        "line": {"color": colour, "width": 1.3},
        "fill": "toself",
        "fillcolor": tint(colour, white),
        "hoverinfo": "text",
        "hoveron": "fills",
        "text": f"<b>{first.short}</b>{teeth}{wide}{mass}{held}",
    }


def _lane(number: int, layout: Layout) -> tuple[float, float]:
    """Radii of a shaft [m]; that in lane 0 is solid."""
    return layout.length(LANE * number + 1.0) if number else 0.0, layout.length(LANE * (number + 1) - 1.0)


def _lane_of(group: Group, column: Column, side: str) -> int:
    """Lane of its shaft on a side; a lone body stands on the shafts that pass under it."""
    stack = column.left if side == "left" else column.right
    return column.passing + (stack.index(group.key) if group.key in stack and not column.lone else 0)


def _base(group: Group, column: Column, layout: Layout) -> float:
    """Inner radius of a member about the axis [m]."""
    sides = [side for side, stack in (("left", column.left), ("right", column.right)) if group.key in stack]
    number = min((_lane_of(group, column, side) for side in sides), default=column.passing)
    return _lane(number, layout)[0]


def _edge(column: Column, side: str) -> float:
    return (column.low if side == "left" else column.high) + column.shift


def _out(column: Column, side: str, pixels: float, layout: Layout) -> float:
    """Place so many pixels beyond the gears [m]."""
    return _edge(column, side) + (-1 if side == "left" else 1) * layout.length(pixels)


def _end(group: Group, column: Column, side: str, layout: Layout) -> float:
    """End of its shaft: the nearer the axis, the further out [m]."""
    if column.lone:
        return _out(column, side, BODY / 2, layout)
    stack = column.left if side == "left" else column.right
    return _out(column, side, 4 * PLATE + SEGMENT * (len(stack) - stack.index(group.key)), layout)


def _shafts(column: Column, layout: Layout) -> list[go.Scatter]:
    """Shafts of the members about the axis; a gear on an axis of its own has one through it."""
    found = []
    for group in column.groups:
        look = _look(group, 0.75)
        if not group.first.branch and group.first.radius > 1e-9:
            around = (group.first.radius - layout.length(LANE / 2), group.first.radius + layout.length(LANE / 2))
            stations = [link.station for link in layout.links if link.first in {part.name for part in group.bodies}]
            ends = [_out(column, side, SEGMENT, layout) for side in ("left", "right")]
            reach = [station + column.shift + way * layout.length(12) for station in stations for way in (-1, 1)]
            found.append(_box((min([ends[0], *reach]), max([ends[1], *reach])), around, look))
        for side, stack in (("left", column.left), ("right", column.right)):
            if group.key in stack and not column.lone:
                start = _edge(column, side) if group.first.form else _cheek(column, side, layout)[0]
                if group.internal:
                    start = _disc(column, side, layout)[0]
                radii = _lane(_lane_of(group, column, side), layout)
                found += _boxes((start, _end(group, column, side, layout)), radii, group, layout, look)
    return found


def _cheek(column: Column, side: str, layout: Layout) -> tuple[float, float]:
    """Axial ends of a carrier's cheek [m]."""
    return _out(column, side, 0.4 * PLATE, layout), _out(column, side, 1.4 * PLATE, layout)


def _disc(column: Column, side: str, layout: Layout) -> tuple[float, float]:
    """Axial ends of the disc that carries a turning ring [m]."""
    return _out(column, side, 2.2 * PLATE, layout), _out(column, side, 3.2 * PLATE, layout)


def _solid(group: Group, column: Column, layout: Layout) -> list[go.Scatter]:
    if group.first.form is not None:
        return _gear(group, column, layout)
    if _carried(group, column):
        return _carrier(group, column, layout)
    half, middle = layout.length(BODY / 2), group.first.station + column.shift
    radii = (_base(group, column, layout), _height(column, layout))
    return _boxes((middle - half, middle + half), radii, group, layout, _look(group))


def _height(column: Column, layout: Layout) -> float:
    """Radius of a lone body, which has none of its own [m]."""
    return max(0.3 * layout.top, _lane(column.passing + 2, layout)[1])


def _gear(group: Group, column: Column, layout: Layout) -> list[go.Scatter]:
    form, look, shift = group.first.form, _look(group), column.shift
    assert form is not None
    low = _base(group, column, layout) if not group.internal and group.first.radius < 1e-9 else group.low
    traces = []
    for one, other in zip(group.faces, group.faces[1:], strict=False):
        along = (one[1] + shift, other[0] + shift)
        if web := _web(group, low, layout):
            traces += _boxes(along, web, group, layout, _look(group, 0.75))
    for left, right, hand in group.faces:
        traces += _boxes((left + shift, right + shift), (low, group.high), group, layout, look)
        if hand:
            traces += _helix(group, (left + shift, right + shift), (low, group.high), hand, layout)
    for side, stack in (("left", column.left), ("right", column.right)):
        if group.internal and group.key in stack:
            disc, rim = _disc(column, side, layout), (form.root_radius, group.high)
            floor = _lane(_lane_of(group, column, side), layout)[0]
            traces += _boxes((_edge(column, side), disc[1]), rim, group, layout, look)
            traces += _boxes(disc, (floor, group.high), group, layout, look)
    return traces


def _web(group: Group, low: float, layout: Layout) -> tuple[float, float] | None:
    """What joins two helices: the body of one gear, a neck between two, nothing between two that are apart."""
    form = group.first.form
    assert form is not None
    thick = 0.82 if len(group.bodies) == 1 else 0.5
    if len(group.bodies) > 1 and not any(_between(link, group) for link in layout.links):
        return None
    if group.internal:
        return group.high - thick * (group.high - group.low), group.high
    if group.first.radius < 1e-9:
        return low, max(low, thick * group.high)
    middle = group.first.radius
    return max(0.0, middle - thick * (middle - group.low)), middle + thick * (group.high - middle)


def _between(link: SectionLink, group: Group) -> bool:
    names = {part.name for part in group.bodies}
    return link.first in names and link.second in names


def _helix(
    group: Group, along: tuple[float, float], radii: tuple[float, float], hand: int, layout: Layout
) -> list[go.Scatter]:
    """Three tooth traces on the side of the gear that looks at the viewer: of a right hand they fall to the right."""
    left, right = along
    slope = -hand * math.tan(group.first.helix_angle)
    z: list[float] = []
    r: list[float] = []
    for share in (0.2, 0.5, 0.8):
        middle, centre = radii[0] + share * (radii[1] - radii[0]), (left + right) / 2
        reach = min(0.40 * (right - left), 0.12 * (radii[1] - radii[0]) / max(abs(slope), 1e-9))
        z += [centre - reach, centre + reach, math.nan]
        r += [middle - slope * reach, middle + slope * reach, math.nan]
    look = {"line": {"color": kind_colour(group.kind), "width": 1}}
    return [_trace(z, [sign * one for one in r], look) for sign in _signs(group, layout)]


def _carried(group: Group, column: Column) -> list[Group]:
    """The planets of a carrier."""
    names = {part.name for part in group.bodies}
    return [other for other in column.groups if other.first.carried_by in names]


def _carrier(group: Group, column: Column, layout: Layout) -> list[go.Scatter]:
    """A cheek on either side of the planets, down to its shaft where it has one there."""
    traces, look = [], _look(group)
    pins = _carried(group, column)
    for side, stack in (("left", column.left), ("right", column.right)):
        floor = _lane(column.passing + len(stack), layout)[0] + layout.length(AIR)
        for sign in _signs(group, layout):
            radii = [pin.first.radius for pin in pins if pin.half == sign] or [pin.first.radius for pin in pins]
            low = _lane(_lane_of(group, column, side), layout)[0] if group.key in stack else max(floor, 0.5 * radii[0])
            top = max(radii) + max(layout.length(2 * PLATE), 0.12 * radii[0])
            traces.append(_box(_cheek(column, side, layout), (sign * low, sign * top), look))
    return traces


def _pins(column: Column, layout: Layout) -> list[go.Scatter]:
    """Pins of planets: from cheek to cheek of their carrier, or from wall to wall of the housing."""
    traces = []
    carriers = {part.name: group for group in column.groups for part in group.bodies}
    for axis in {(group.first.radius, group.half, group.first.carried_by) for group in column.groups if group.first.branch}:
        radius, half, carrier = axis
        look = _look(carriers[carrier]) if carrier in carriers else _housing()
        ends = [_cheek(column, side, layout)[1] for side in ("left", "right")]
        if carrier in carriers:
            ends = [_cheek(column, side, layout)[0] for side in ("left", "right")]
        thick = layout.length(0.5 * LANE)
        traces.append(_box((ends[0], ends[1]), (half * radius - thick, half * radius + thick), look))
    return traces


def _housing() -> dict[str, Any]:
    return {"line": {"color": INK, "width": 1}, "fill": "toself", "fillcolor": tint(INK, 0.8)}


def _meshes(check: xr.Dataset, layout: Layout) -> list[go.Scatter]:
    """A line along the face at the pitch point of every mesh whose gears stand in one plane."""
    where = {part.name: (group, part, column) for column in layout.columns for group in column.groups for part in group.bodies}
    z: list[float] = []
    r: list[float] = []
    for one in matings(check):
        if one.a not in where or one.b not in where:
            continue
        (a, first, column), (b, second, _) = where[one.a], where[one.b]
        ends = {round(edge, 9) for edge in (a.low, a.high)} | {round(edge, 9) for edge in (b.low, b.high)}
        gap = min(abs(a.high - b.low), abs(b.high - a.low), abs(a.high - b.high))
        if a.first.branch and b.first.branch or gap > 0.2 * max(ends):
            continue
        level = min(
            ((abs(one_edge - other), (one_edge + other) / 2) for one_edge in (a.low, a.high) for other in (b.low, b.high)),
        )[1]
        for left, right in _overlaps(a, b, first.name, second.name):
            for sign in set(_signs(a, layout)) & set(_signs(b, layout)):
                z += [left + column.shift, right + column.shift, math.nan]
                r += [sign * level, sign * level, math.nan]
    look = {"line": {"color": WARNING, "width": 3}, "name": "meshes", "showlegend": True}
    return [_trace(z, r, look)] if z else []


def _overlaps(a: Group, b: Group, first: str, second: str) -> list[tuple[float, float]]:
    """Where faces of two gears lie over each other [m]."""
    found = set()
    for left, right, _ in a.faces:
        for start, stop, _ in b.faces:
            if min(right, stop) > max(left, start):
                found.add((max(left, start), min(right, stop)))
    return sorted(found)


def _couplings(layout: Layout) -> list[go.Scatter]:
    """Shaft ends with facing flanges, and what is elastic between them; shafts that pass a stage."""
    columns = {group.key: (group, column) for column in layout.columns for group in column.groups}
    places = [column.place for column in layout.columns]
    traces: list[go.Scatter] = []
    z: list[float] = []
    r: list[float] = []
    for one in layout.couplings:
        (left, at_left), (right, at_right) = columns[one.left], columns[one.right]
        before = layout.columns[places.index(at_right.place) - 1]
        start, stop = _end(left, at_left, "right", layout), _end(right, at_right, "left", layout)
        lanes = [_lane(number, layout) for number in _levels(one, left, at_left, right, at_right)]
        bound = max(start, _out(before, "right", before.room_right, layout)) if before is not at_left else start
        middle, air = (bound + stop) / 2, layout.length(3)
        flange = layout.length(4)
        for sign in (1, -1) if layout.both else (1,):
            runs = (
                ((start, middle - air), lanes[0] if one.lane < 0 else lanes[1], left),
                ((middle + air, stop), lanes[2], right),
            )
            for along, radii, group in runs:
                traces.append(_box(along, (sign * radii[0], sign * radii[1]), _look(group, 0.75)))
            if one.lane >= 0 and lanes[0] != lanes[1]:
                step = (min(lanes[0][0], lanes[1][0]), max(lanes[0][1], lanes[1][1]))
                traces.append(_box((start - flange, start), (sign * step[0], sign * step[1]), _look(left, 0.75)))
            reach = (min(lanes[1][0], lanes[2][0]), max(lanes[1][1], lanes[2][1]) + layout.length(7))
            hover = {"hoverinfo": "text", "hoveron": "fills", "text": _spring(_link(one.name, layout))}
            plate = {"fill": "toself", "fillcolor": INK, "line": {"color": INK, "width": 1}, **hover}
            for near, far in ((middle - air - flange, middle - air), (middle + air, middle + air + flange)):
                traces.append(_box((near, far), (sign * reach[0], sign * reach[1]), plate))
            z += [middle, middle, math.nan]
            r += [sign * reach[0], sign * reach[1], math.nan]
    look = {"line": {"color": INK, "width": 2, "dash": "dot"}, "name": "couplings", "showlegend": True}
    return [*traces, _trace(z, r, look)] if z else []


def _levels(one: Coupling, left: Group, at_left: Column, right: Group, at_right: Column) -> tuple[int, int, int]:
    """Lanes where a coupling begins, runs and ends; a lone body takes a shaft where it comes."""
    begin, end = _lane_of(left, at_left, "right"), _lane_of(right, at_right, "left")
    if one.lane >= 0:
        begin, end = (one.lane if at_left.lone else begin), (one.lane if at_right.lone else end)
        return begin, one.lane, end
    if at_left.lone and not at_right.lone:
        begin = end
    if at_right.lone:
        end = begin
    return begin, begin, end


def _link(name: str, layout: Layout) -> SectionLink:
    return next(link for link in layout.links if link.name == name)


def _supports(layout: Layout) -> list[go.Scatter]:
    """Bearings and supports where they stand, and the housing that they, pins and held members stand in."""
    where = {part.name: (group, part, column) for column in layout.columns for group in column.groups for part in group.bodies}
    marks: dict[tuple[float, float], list[SectionLink]] = {}
    walls: set[tuple[float, float, str]] = set()
    stems: list[tuple[float, float, float]] = []
    for link in layout.links:
        ends = [where[name] for name in (link.first, link.second) if name in where]
        if link.kind not in ("support", "bearing") or not ends:
            continue
        group, part, column = next((one for one in ends if one[0].first.branch), ends[0])
        if not (link.radial or link.axial or link.turning):
            continue
        for sign in _signs(group, layout):
            z, r = _seat(link, group, column, layout)
            fixed = not link.second and (group.held or link.turning) and not group.first.branch
            if group.internal:
                top = group.high + layout.length(20)
                walls.add((round(z, 9), sign * top, "up" if sign > 0 else "down"))
                stems.append((z, sign * group.high, sign * top))
                r = group.high + layout.length(10)
            if fixed and not group.internal and group.key in (*column.left, *column.right) and not column.lone:
                side = "left" if group.key in column.left else "right"
                end = _end(group, column, side, layout)
                walls.add((round(end, 9), sign * _lane(_lane_of(group, column, side), layout)[1] / 2, side))
            if not (fixed and group.internal) and (link.radial or link.axial):
                marks.setdefault((round(z, 9), sign * r), []).append(link)
    walls |= _pin_walls(layout)
    stem = {"line": {"color": INK, "width": 1.6}}
    lines = [_trace([z, z], [low, high], stem) for z, low, high in dict.fromkeys(stems)]
    return [*lines, *_grounds(walls, layout), *_marked(marks, layout)]


def _pin_walls(layout: Layout) -> set[tuple[float, float, str]]:
    """Where pins of planets that no carrier holds stand in the housing."""
    return {
        (round(_cheek(column, side, layout)[1], 9), group.half * group.first.radius, side)
        for column in layout.columns
        for group in column.groups
        if group.first.branch and not group.first.carried_by
        for side in ("left", "right")
    }


def _seat(link: SectionLink, group: Group, column: Column, layout: Layout) -> tuple[float, float]:
    """Place of a support or bearing [m]: its station; of one in the middle of its member, the shaft that shows."""
    station = link.station if np.isfinite(link.station) else group.first.station
    if group.first.branch:
        return station + column.shift, group.first.radius
    if group.internal:
        return station + column.shift, group.high
    if group.first.radius > 1e-9:
        lumped = column.low <= station <= column.high
        place = _out(column, "left", 0.5 * SEGMENT, layout) if lumped else station + column.shift
        return place, group.first.radius
    if column.lone:
        return station + column.shift, _base(group, column, layout) + layout.length(LANE)
    sides = [side for side, stack in (("left", column.left), ("right", column.right)) if group.key in stack]
    if not sides:
        return station + column.shift, _base(group, column, layout) + layout.length(LANE / 2)
    side = "right" if "right" in sides and station > (column.low + column.high) / 2 else sides[0]
    low, high = _lane(_lane_of(group, column, side), layout)
    if column.low <= station <= column.high:
        out = SEGMENT / 2 if not group.held else 0.7 * SEGMENT
        inward = -1 if side == "right" else 1
        return _end(group, column, side, layout) + inward * layout.length(out), (low + high) / 2
    return station + column.shift, (low + high) / 2


def _marked(marks: Mapping[tuple[float, float], Sequence[SectionLink]], layout: Layout) -> list[go.Scatter]:
    """Symbols of supports and bearings: elastic or rigid; with bars on both sides where they hold axially."""
    found: list[go.Scatter] = []
    for name, look in _SYMBOLS.items():
        rigid = name.startswith("rigid")
        own = {at: links for at, links in marks.items() if any(link.radial for link in links)}
        own = {at: links for at, links in own.items() if all(math.isinf(max(k.stiffness[:2])) for k in links) == rigid}
        if own:
            words = ["<br>".join(map(_spring, links)) for links in own.values()]
            marker = {**look, "size": 11, "line": {"width": 1.4, "color": INK}}
            shown = {"mode": "markers", "marker": marker, "hoverinfo": "text", "text": words, "name": name}
            found.append(_trace([z for z, _ in own], [r for _, r in own], {**shown, "showlegend": True}))
    axial = [at for at, links in marks.items() if any(link.axial for link in links)]
    if axial:
        z = [one[0] + way * layout.length(9) for one in axial for way in (-1, 1)]
        bar = {"symbol": "line-ns-open", "size": 13, "color": INK, "line": {"width": 1.8, "color": INK}}
        shown = {"mode": "markers", "marker": bar, "name": "holds axially", "showlegend": True}
        found.append(_trace(z, [one[1] for one in axial for _ in (0, 1)], shown))
    return found


def _grounds(walls: Iterable[tuple[float, float, str]], layout: Layout) -> list[go.Scatter]:
    """The housing: a line with oblique strokes behind it."""
    z: list[float] = []
    r: list[float] = []
    half, deep = layout.length(10), layout.length(5)
    for at, height, way in sorted(walls):
        along = np.linspace(-half, half, 5)
        upright = way in ("left", "right")
        sign = 1 if way in ("up", "right") else -1
        places = [(0.0, one) for one in (-half, half)] if upright else [(one, 0.0) for one in (-half, half)]
        strokes = [places]
        for one in along:
            strokes.append([(0.0, one), (sign * deep, one - deep)] if upright else [(one, 0.0), (one - deep, sign * deep)])
        for stroke in strokes:
            z += [*(at + dz for dz, _ in stroke), math.nan]
            r += [*(height + dr for _, dr in stroke), math.nan]
    look = {"line": {"color": INK, "width": 1.3}, "name": "housing", "showlegend": True}
    return [_trace(z, r, look)] if z else []


def _spring(link: SectionLink) -> str:
    """The stiffness of a link (6,) [N/m, N m/rad] in words."""
    rows = [
        f"{direction}: {'rigid' if np.isinf(value) else f'{engineering(float(value))} {unit}'}"
        for direction, unit, value in zip(_DIRECTIONS, _UNITS, link.stiffness, strict=True)
        if value > 0
    ]
    return "<br>".join([f"<b>{link.name}</b>", *rows])


def _names(drawn: go.Figure, layout: Layout) -> None:
    """Names in the gears where they fit, else beside them; of rings and lone bodies above, with the stage's name."""
    several = sum(not column.lone for column in layout.columns) > 1
    for column in layout.columns:
        middle = (column.low + column.high) / 2 + column.shift
        for group in column.groups:
            if column.lone:
                words = group.word + (f"<br>{_power(group)}" if group.power else "")
                _write(drawn, words, middle, _height(column, layout), yanchor="bottom", yshift=3)
            elif not group.internal:
                _name(drawn, group, column, layout)
        rings = [group for group in column.groups if group.internal]
        words = ", ".join(group.word + (" (held)" if group.held else "") for group in rings)
        title = f"<b>{column.place}</b>" if several and not column.lone else ""
        if (said := "<br>".join(text for text in (title, words) if text)) and not column.lone:
            over = rings[0].faces if len(rings) == 1 else [(column.low, column.high, 0)]
            middle = (over[0][0] + over[-1][1]) / 2 + column.shift
            _write(drawn, said, middle, column.top, yanchor="bottom", yshift=30 if rings else 4)
        for side, stack in (("left", column.left), ("right", column.right)):
            for key in stack:
                group = next(one for one in column.groups if one.key == key)
                if group.power and not column.lone:
                    _port(drawn, group, column, side, layout)


def _write(drawn: go.Figure, text: str, z: float, r: float, **options: Any) -> None:
    note(drawn, text, x=round(1e3 * z, 3), y=round(1e3 * r, 3), font={"size": 12, "color": INK}, **options)


def _power(group: Group) -> str:
    size, way = abs(group.power), "in" if group.power > 0 else "out"
    return f"{engineering(size / 1e6)} MW {way}" if size >= 1e6 else f"{engineering(size / 1e3)} kW {way}"


def _floats(group: Group, layout: Layout) -> bool:
    """Whether nothing holds a member about the axis radially."""
    names = {part.name for part in group.bodies}
    mine = [link for link in layout.links if link.kind == "support" and link.first in names]
    return not group.first.branch and not any(link.radial for link in mine)


def _name(drawn: go.Figure, group: Group, column: Column, layout: Layout) -> None:
    words = group.word + (" (held)" if group.held else "")
    if group.first.form is None:
        pin = _carried(group, column)[0]
        z = _out(column, "right", 2.0 * PLATE, layout)
        side = "left" if _crowded(column, "right") else "right"
        if side == "left":
            z = _out(column, "left", 2.0 * PLATE, layout)
        anchor = {"xanchor": "left" if side == "right" else "right"}
        _write(drawn, words, z, pin.half * 1.05 * pin.first.radius, yanchor="middle", **anchor)
        return
    if _floats(group, layout):
        words += ", floats"
    left, right = (one + column.shift for one in (group.faces[0][0], group.faces[-1][1]))
    top = group.high
    low = group.first.radius + layout.length(8) if group.first.radius > 1e-9 else _base(group, column, layout)
    wide, tall = (right - left) * layout.scale, (top - low) * layout.scale
    middle, level = (left + right) / 2, group.half * (low + top) / 2
    look = {"bgcolor": _look(group)["fillcolor"], "borderpad": 1}
    for text in dict.fromkeys((words, words.replace(", ", "<br>").replace(" (", "<br>("))):
        lines = text.count("<br>") + 1
        if text_width(text) + 4 <= wide and 15 * lines + 3 <= tall:
            return _write(drawn, text, middle, level, yanchor="middle", **look)
        if text_width(text) + 4 <= tall and 15 * lines + 3 <= wide:
            return _write(drawn, text, middle, level, textangle=-90, **look)
    discs = {side for side in ("left", "right") if _crowded(column, side)}
    side = "right" if "left" in discs and "right" not in discs else "left"
    beyond = _out(column, side, (4.5 * PLATE if side in discs else 1.8 * PLATE) if group.first.branch else 4, layout)
    anchor = "right" if side == "left" else "left"
    return _write(drawn, words, beyond, level, xanchor=anchor, yanchor="middle", bgcolor="white")


def _crowded(column: Column, side: str) -> bool:
    """Whether the disc of a ring stands on that side of the gears."""
    stack = column.left if side == "left" else column.right
    return any(group.internal and group.key in stack for group in column.groups)


def _port(drawn: go.Figure, group: Group, column: Column, side: str, layout: Layout) -> None:
    """Power at the end of a shaft, with the way it goes."""
    if any(one.left == group.key or one.right == group.key for one in layout.couplings):
        return
    into = group.power > 0
    low, high = _lane(_lane_of(group, column, side), layout)
    outwards = "→" if side == "right" else "←"
    inwards = "←" if side == "right" else "→"
    arrow = inwards if into else outwards
    words = f"{arrow} {_power(group)}" if side == "right" else f"{_power(group)} {arrow}"
    anchor = {"xanchor": "left" if side == "right" else "right", "xshift": 6 if side == "right" else -6}
    at = _end(group, column, side, layout)
    _write(drawn, words, at, (low + high) / 2, yanchor="middle", bgcolor="white", **anchor)


def _frame(drawn: go.Figure, layout: Layout) -> None:
    """Axis, scale bar, and a range in which everything has room."""
    first, last = layout.columns[0], layout.columns[-1]
    low = _out(first, "left", first.room_left + MARGIN, layout)
    high = _out(last, "right", last.room_right + MARGIN, layout)
    top = layout.top + layout.length(66)
    bottom = -top if layout.both else -layout.length(44)
    drawn.add_trace(_trace([low, high], [0, 0], {"line": {"color": PALE, "width": 1.2, "dash": "longdashdot"}}))
    bar = _round(0.16 * (high - low))
    level = bottom + layout.length(14)
    ends = [low, low, low + bar, low + bar], [level + layout.length(4), level, level, level + layout.length(4)]
    drawn.add_trace(_trace(*ends, {"line": {"color": INK, "width": 1.6}}))
    _write(drawn, f"{engineering(1e3 * bar)} mm", low + bar, level, xanchor="left", xshift=6, yanchor="middle")
    quiet = {"showgrid": False, "showticklabels": False, "ticks": "", "showline": False, "constrain": "domain"}
    drawn.update_xaxes(range=[1e3 * low, 1e3 * high], **quiet)
    drawn.update_yaxes(range=[1e3 * bottom, 1e3 * top], scaleanchor="x", constrain="domain", showgrid=False)
    drawn.update_layout(height=round((top - bottom) * layout.scale * min(1.0, 812 / ((high - low) * layout.scale)) + 130))
    drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.03, "yanchor": "top"})


def _round(length: float) -> float:
    """The next smaller 1, 2 or 5 times a power of ten [m]."""
    power = 10.0 ** math.floor(math.log10(length))
    return next(step * power for step in (5.0, 2.0, 1.0) if step * power <= length * (1 + 1e-9))
