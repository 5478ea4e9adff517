"""The train from the side: axial section, gears to scale, helices, shafts, couplings, supports, what is held."""

from __future__ import annotations

import math
from itertools import pairwise, product
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..charts.style import INK, PALE, WARNING, figure, kind_colour, note, tint
from ..series import engineering, numbers, texts
from .bodies import matings
from .section_layout import (
    AIR,
    BODY,
    LANE,
    MARGIN,
    PLATE,
    SEGMENT,
    WIDE,
    Column,
    Coupling,
    Group,
    SectionLayout,
    appearance,
    base_of,
    beyond,
    box,
    boxes,
    cheek,
    disc,
    edge_of,
    end_of,
    lane_of,
    lane_radii,
    layout_of,
    signs,
    spring,
    supports,
    text_width,
    trace,
    where_of,
)


def train_section(check: xr.Dataset) -> go.Figure:
    """Axial section [mm] through the axis and branch 1, branches turned into the plane, stages in series.

    Gears end at their pitch circles, face widths and radii to scale; shafts, couplings and what lies between the
    stages are a scheme.  A half section, or both halves where a branch has planets on two axes.

    Parameters
    ----------
    check : Dataset of `check`: what `section_layout.layout_of` reads.
    """
    layout = layout_of(check)
    # whether every gear has its face width from the model
    given = "gear" not in check.dims or bool(np.isfinite(numbers(check, "face_width", "gear")).all())
    title = "Axial section, gears to scale" if given else "Axial section, radii to scale (face widths are not given)"
    several = len({part.split("/")[0] for part in texts(check, "gear")}) > 1
    drawn = figure(
        title + "; stages in series, what lies between is a scheme" * several, y="distance from the axis [mm]"
    )
    for column in layout.columns:
        drawn.add_traces(_shafts(column, layout))
    drawn.add_traces(_couplings(layout))
    for column in layout.columns:
        for group in column.groups:
            if group.first.form is not None:
                drawn.add_traces(_gear(group, column, layout))
            elif _carried(group, column):
                drawn.add_traces(_carrier(group, column, layout))
            else:
                half, middle = layout.length(BODY / 2), group.first.station + column.shift
                radii = (base_of(group, column, layout), _height(column, layout))
                drawn.add_traces(boxes((middle - half, middle + half), radii, group, layout, appearance(group)))
        drawn.add_traces(_pins(column, layout))
    drawn.add_traces(_meshes(check, layout))
    drawn.add_traces(supports(layout))
    _names(drawn, layout)
    _frame(drawn, layout)
    return drawn


def _shafts(column: Column, layout: SectionLayout) -> list[go.Scatter]:
    """Shafts of the members about the axis; a gear on an axis of its own has one through it."""
    found = []
    for group in column.groups:
        look = appearance(group, 0.75)
        if not group.first.branch and group.first.radius > 1e-9:
            around = (group.first.radius - layout.length(LANE / 2), group.first.radius + layout.length(LANE / 2))
            stations = [link.station for link in layout.links if link.first in {part.name for part in group.bodies}]
            ends = [beyond(column, side, SEGMENT, layout) for side in ("left", "right")]
            reach = [station + column.shift + way * layout.length(12) for station in stations for way in (-1, 1)]
            found.append(box((min([ends[0], *reach]), max([ends[1], *reach])), around, look))
        for side in [] if column.lone else column.sides_of(group):
            start = edge_of(column, side) if group.first.form else cheek(column, side, layout)[0]
            if group.internal:
                start = disc(column, side, layout)[0]
            radii = lane_radii(lane_of(group, column, side), layout)
            found += boxes((start, end_of(group, column, side, layout)), radii, group, layout, look)
    return found


def _height(column: Column, layout: SectionLayout) -> float:
    """Radius of a lone body, which has none of its own [m]."""
    return max(0.3 * layout.top, lane_radii(column.passing + 2, layout)[1])


def _gear(group: Group, column: Column, layout: SectionLayout) -> list[go.Scatter]:
    form, look, shift = group.first.form, appearance(group), column.shift
    assert form is not None
    low = base_of(group, column, layout) if not group.internal and group.first.radius < 1e-9 else group.low
    traces = []
    for one, other in pairwise(group.faces):
        along = (one[1] + shift, other[0] + shift)
        if web := _web(group, low, layout):
            traces += boxes(along, web, group, layout, appearance(group, 0.75))
    for left, right, hand in group.faces:
        traces += boxes((left + shift, right + shift), (low, group.high), group, layout, look)
        # three tooth traces on the side of the gear that looks at the viewer: of a right hand they fall to the right
        slope, tall = -hand * math.tan(group.first.helix_angle), group.high - low
        z: list[float] = []
        r: list[float] = []
        for share in (0.2, 0.5, 0.8) if hand else ():
            middle, centre = low + share * tall, (left + shift + (right + shift)) / 2
            reach = min(0.40 * (right + shift - (left + shift)), 0.12 * tall / max(abs(slope), 1e-9))
            z += [centre - reach, centre + reach, math.nan]
            r += [middle - slope * reach, middle + slope * reach, math.nan]
        thin = {"line": {"color": kind_colour(group.kind), "width": 1}}
        traces += [trace(z, [sign * one for one in r], thin) for sign in signs(group, layout) if hand]
    for side in column.sides_of(group) if group.internal else ():
        plate, rim = disc(column, side, layout), (form.root_radius, group.high)
        floor = lane_radii(lane_of(group, column, side), layout)[0]
        traces += boxes((edge_of(column, side), plate[1]), rim, group, layout, look)
        traces += boxes(plate, (floor, group.high), group, layout, look)
    return traces


def _web(group: Group, low: float, layout: SectionLayout) -> tuple[float, float] | None:
    """What joins two helices: the body of one gear, a neck between two, nothing between two that are apart."""
    form = group.first.form
    assert form is not None
    thick = 0.82 if len(group.bodies) == 1 else 0.5
    names = {part.name for part in group.bodies}
    if len(group.bodies) > 1 and not any({link.first, link.second} <= names for link in layout.links):
        return None
    if group.internal:
        return group.high - thick * (group.high - group.low), group.high
    if group.first.radius < 1e-9:
        return low, max(low, thick * group.high)
    middle = group.first.radius
    return max(0.0, middle - thick * (middle - group.low)), middle + thick * (group.high - middle)


def _carried(group: Group, column: Column) -> list[Group]:
    """The planets of a carrier."""
    names = {part.name for part in group.bodies}
    return [other for other in column.groups if other.first.carried_by in names]


def _carrier(group: Group, column: Column, layout: SectionLayout) -> list[go.Scatter]:
    """A cheek on either side of the planets, down to its shaft where it has one there."""
    traces, look = [], appearance(group)
    pins = _carried(group, column)
    for side, stack in (("left", column.left), ("right", column.right)):
        floor = lane_radii(column.passing + len(stack), layout)[0] + layout.length(AIR)
        for sign in signs(group, layout):
            radii = [pin.first.radius for pin in pins if pin.half == sign] or [pin.first.radius for pin in pins]
            own = lane_radii(lane_of(group, column, side), layout)[0]
            low = own if group.key in stack else max(floor, 0.5 * radii[0])
            top = max(radii) + max(layout.length(2 * PLATE), 0.12 * radii[0])
            traces.append(box(cheek(column, side, layout), (sign * low, sign * top), look))
    return traces


def _pins(column: Column, layout: SectionLayout) -> list[go.Scatter]:
    """Pins of planets: from cheek to cheek of their carrier, or from wall to wall of the housing."""
    traces = []
    carriers = {part.name: group for group in column.groups for part in group.bodies}
    pins = [group for group in column.groups if group.first.branch]
    for radius, half, carrier in sorted({(pin.first.radius, pin.half, pin.first.carried_by) for pin in pins}):
        held = carrier in carriers
        housing = {"line": {"color": INK, "width": 1}, "fill": "toself", "fillcolor": tint(INK, 0.8)}
        look = appearance(carriers[carrier]) if held else housing
        ends = [cheek(column, side, layout)[0 if held else 1] for side in ("left", "right")]
        thick = layout.length(0.5 * LANE)
        traces.append(box((ends[0], ends[1]), (half * radius - thick, half * radius + thick), look))
    return traces


def _meshes(check: xr.Dataset, layout: SectionLayout) -> list[go.Scatter]:
    """A line along the face at the pitch point of every mesh whose gears stand in one plane."""
    where = where_of(layout)
    z: list[float] = []
    r: list[float] = []
    for one in matings(check):
        if one.a not in where or one.b not in where:
            continue
        (a, column), (b, _) = where[one.a], where[one.b]
        apart, level = min(
            (abs(mine - other), (mine + other) / 2) for mine in (a.low, a.high) for other in (b.low, b.high)
        )
        if (a.first.branch and b.first.branch) or apart > 0.2 * max(a.high, b.high):
            continue  # two planets of a branch mesh beside the plane
        over = {(max(one[0], two[0]), min(one[1], two[1])) for one, two in product(a.faces, b.faces)}
        for left, right in sorted(span for span in over if span[1] > span[0]):
            for sign in sorted(set(signs(a, layout)) & set(signs(b, layout))):
                z += [left + column.shift, right + column.shift, math.nan]
                r += [sign * level, sign * level, math.nan]
    look = {"line": {"color": WARNING, "width": 3}, "name": "meshes", "showlegend": True}
    return [trace(z, r, look)] if z else []


def _couplings(layout: SectionLayout) -> list[go.Scatter]:
    """Shaft ends with facing flanges, and what is elastic between them; shafts that pass a stage."""
    columns = {group.key: (group, column) for column in layout.columns for group in column.groups}
    places = [column.place for column in layout.columns]
    traces: list[go.Scatter] = []
    z: list[float] = []
    r: list[float] = []
    for one in layout.couplings:
        (left, at_left), (right, at_right) = columns[one.left], columns[one.right]
        before = layout.columns[places.index(at_right.place) - 1]
        start, stop = end_of(left, at_left, "right", layout), end_of(right, at_right, "left", layout)
        lanes = [lane_radii(number, layout) for number in _levels(one, left, at_left, right, at_right)]
        bound = max(start, beyond(before, "right", before.room_right, layout)) if before is not at_left else start
        middle, air = (bound + stop) / 2, layout.length(3)
        flange, link = layout.length(4), next(link for link in layout.links if link.name == one.name)
        for sign in (1, -1) if layout.both else (1,):
            runs = (
                ((start, middle - air), lanes[0] if one.lane < 0 else lanes[1], left),
                ((middle + air, stop), lanes[2], right),
            )
            for along, radii, group in runs:
                traces.append(box(along, (sign * radii[0], sign * radii[1]), appearance(group, 0.75)))
            if one.lane >= 0 and lanes[0] != lanes[1]:
                step = (min(lanes[0][0], lanes[1][0]), max(lanes[0][1], lanes[1][1]))
                traces.append(box((start - flange, start), (sign * step[0], sign * step[1]), appearance(left, 0.75)))
            reach = (min(lanes[1][0], lanes[2][0]), max(lanes[1][1], lanes[2][1]) + layout.length(7))
            hover = {"hoverinfo": "text", "hoveron": "fills", "text": spring(link)}
            plate = {"fill": "toself", "fillcolor": INK, "line": {"color": INK, "width": 1}, **hover}
            for near, far in ((middle - air - flange, middle - air), (middle + air, middle + air + flange)):
                traces.append(box((near, far), (sign * reach[0], sign * reach[1]), plate))
            z += [middle, middle, math.nan]
            r += [sign * reach[0], sign * reach[1], math.nan]
    look = {"line": {"color": INK, "width": 2, "dash": "dot"}, "name": "couplings", "showlegend": True}
    return [*traces, trace(z, r, look)] if z else []


def _levels(one: Coupling, left: Group, at_left: Column, right: Group, at_right: Column) -> tuple[int, int, int]:
    """Lanes where a coupling begins, runs and ends; a lone body takes a shaft where it comes."""
    begin, end = lane_of(left, at_left, "right"), lane_of(right, at_right, "left")
    if one.lane >= 0:
        begin, end = (one.lane if at_left.lone else begin), (one.lane if at_right.lone else end)
        return begin, one.lane, end
    if at_left.lone and not at_right.lone:
        begin = end
    if at_right.lone:
        end = begin
    return begin, begin, end


def _names(drawn: go.Figure, layout: SectionLayout) -> None:
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
        title = f"<b>{column.place}</b>" if several and not column.lone else ""
        if not column.lone:
            _rings(drawn, title, column, layout)
        for side, stack in (("left", column.left), ("right", column.right)):
            for key in stack:
                group = next(one for one in column.groups if one.key == key)
                if group.power and not column.lone:
                    _port(drawn, group, column, side, layout)


def _write(drawn: go.Figure, text: str, z: float, r: float, *, size: float = 12, **options: Any) -> None:
    note(drawn, text, x=round(1e3 * z, 3), y=round(1e3 * r, 3), font={"size": size, "color": INK}, **options)


def _rings(drawn: go.Figure, title: str, column: Column, layout: SectionLayout) -> None:
    """Names of the rings above them, each over its own where they have room side by side; the name of the stage."""
    rings = [group for group in column.groups if group.internal]
    texts = [group.word + (" (held)" if group.held else "") for group in rings]
    middles = [(group.faces[0][0] + group.faces[-1][1]) / 2 + column.shift for group in rings]
    if len(rings) > 1:
        places = sorted(zip(middles, texts, strict=True))
        room = [
            (far - near) * layout.scale - (text_width(one) + text_width(other)) / 2
            for (near, one), (far, other) in pairwise(places)
        ]
        if min(room) < AIR:
            middles, texts = [sum(middles) / len(middles)], [", ".join(texts)]
    if title and len(texts) == 1:
        texts = [f"{title}<br>{texts[0]}"]
    elif title or not texts:
        middles, texts = [*middles, (column.low + column.high) / 2 + column.shift], [*texts, title]
    for middle, text in zip(middles, texts, strict=True):
        lift = (46 if len(texts) > 1 and text == title else 30) if rings else 4
        if text:
            _write(drawn, text, middle, column.top, yanchor="bottom", yshift=lift)


def _power(group: Group) -> str:
    size, way = abs(group.power), "in" if group.power > 0 else "out"
    return f"{engineering(size / 1e6)} MW {way}" if size >= 1e6 else f"{engineering(size / 1e3)} kW {way}"


def _name(drawn: go.Figure, group: Group, column: Column, layout: SectionLayout) -> None:
    words = group.word + (" (held)" if group.held else "")
    if group.first.form is None:
        pins = _carried(group, column)
        level = pins[0].half * 1.05 * pins[0].first.radius if pins else _height(column, layout)
        side, towards = ("left", "right") if _crowded(column, "right") else ("right", "left")
        return _write(drawn, words, beyond(column, side, 2.0 * PLATE, layout), level, yanchor="middle", xanchor=towards)
    names = {part.name for part in group.bodies}
    held = any(link.radial for link in layout.links if link.kind == "support" and link.first in names)
    if not group.first.branch and not held:
        words += ", floats"
    left, right = (one + column.shift for one in (group.faces[0][0], group.faces[-1][1]))
    top = group.high
    low = group.first.radius + layout.length(8) if group.first.radius > 1e-9 else base_of(group, column, layout)
    wide, tall = (right - left) * layout.scale, (top - low) * layout.scale
    middle, level = (left + right) / 2, group.half * (low + top) / 2
    look = {"bgcolor": appearance(group)["fillcolor"], "borderpad": 1}
    broken = words.replace(", ", "<br>").replace(" (", "<br>(")
    for text, size in ((words, 12), (broken, 12), (words, 10), (broken, 10)):
        long, high = text_width(text) * size / 12 + 4, 1.25 * size * (text.count("<br>") + 1) + 3
        if long <= wide and high <= tall:
            return _write(drawn, text, middle, level, size=size, yanchor="middle", **look)
        if long <= tall and high <= wide:
            return _write(drawn, text, middle, level, size=size, textangle=-90, **look)
    discs = {side for side in ("left", "right") if _crowded(column, side)}
    side = "right" if "left" in discs and "right" not in discs else "left"
    beside = beyond(column, side, (4.5 * PLATE if side in discs else 1.8 * PLATE) if group.first.branch else 4, layout)
    anchor = "right" if side == "left" else "left"
    return _write(drawn, words, beside, level, xanchor=anchor, yanchor="middle", bgcolor="white")


def _crowded(column: Column, side: str) -> bool:
    """Whether the disc of a ring stands on that side of the gears."""
    return any(group.internal and side in column.sides_of(group) for group in column.groups)


def _port(drawn: go.Figure, group: Group, column: Column, side: str, layout: SectionLayout) -> None:
    """Power at the end of a shaft, with the way it goes."""
    if any(one.left == group.key or one.right == group.key for one in layout.couplings):
        return
    low, high = lane_radii(lane_of(group, column, side), layout)
    arrow = "←" if (group.power > 0) == (side == "right") else "→"
    words = f"{arrow} {_power(group)}" if side == "right" else f"{_power(group)} {arrow}"
    towards, shift = ("left", 6) if side == "right" else ("right", -6)
    at, stack = end_of(group, column, side, layout), column.left if side == "left" else column.right
    look: dict[str, Any] = {"xanchor": towards, "xshift": shift, "bgcolor": "white"}
    if stack.index(group.key):  # another shaft comes out of this one: above it
        return _write(drawn, words, at, high, yanchor="bottom", **look)
    return _write(drawn, words, at, (low + high) / 2, yanchor="middle", **look)


def _frame(drawn: go.Figure, layout: SectionLayout) -> None:
    """Axis, scale bar, and a range in which everything has room."""
    first, last = layout.columns[0], layout.columns[-1]
    low = beyond(first, "left", first.room_left + MARGIN, layout)
    high = beyond(last, "right", last.room_right + MARGIN, layout)
    top = layout.top + layout.length(66)
    bottom = -top if layout.both else -layout.length(44)
    drawn.add_trace(trace([low, high], [0, 0], {"line": {"color": PALE, "width": 1.2, "dash": "longdashdot"}}))
    longest = 0.16 * (high - low)  # the bar is the next smaller 1, 2 or 5 times a power of ten
    power = 10.0 ** math.floor(math.log10(longest))
    bar = next(step * power for step in (5.0, 2.0, 1.0) if step * power <= longest * (1 + 1e-9))
    level = bottom + layout.length(14)
    ends = [low, low, low + bar, low + bar], [level + layout.length(4), level, level, level + layout.length(4)]
    drawn.add_trace(trace(*ends, {"line": {"color": INK, "width": 1.6}}))
    _write(drawn, f"{engineering(1e3 * bar)} mm", low + bar, level, xanchor="left", xshift=6, yanchor="middle")
    quiet = {"showgrid": False, "showticklabels": False, "ticks": "", "showline": False, "constrain": "domain"}
    drawn.update_xaxes(range=[1e3 * low, 1e3 * high], **quiet)
    drawn.update_yaxes(range=[1e3 * bottom, 1e3 * top], scaleanchor="x", constrain="domain", showgrid=False)
    shrunk = min(1.0, WIDE / ((high - low) * layout.scale))  # a crowded series does not fit as it was laid out
    drawn.update_layout(height=round((top - bottom) * layout.scale * shrunk + 130))
    drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.03, "yanchor": "top"})
