"""Shapes of an axial section: boxes of bodies, springs of bearings and supports, the housing.

They share places about a column: lanes of shafts, cheeks, discs, ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from ..charts.style import INK, kind_colour, tint
from ..series import Array, compact, engineering
from .section_layout import BODY, LANE, PLATE, SEGMENT, Column, Group, SectionLayout, SectionLink


def where_of(layout: SectionLayout) -> dict[str, tuple[Group, Column]]:
    """Body -> its group and column."""
    return {part.name: (group, column) for column in layout.columns for group in column.groups for part in group.bodies}


def trace(z: Sequence[float] | Array, r: Sequence[float] | Array, options: Mapping[str, Any]) -> go.Scatter:
    """A line through z, r (k,) [m], drawn in [mm]."""
    plain = {"mode": "lines", "hoverinfo": "skip", "showlegend": False}
    return go.Scatter(x=compact(1e3 * np.asarray(z)), y=compact(1e3 * np.asarray(r)), **{**plain, **options})


def box(along: tuple[float, float], radii: tuple[float, float], look: Mapping[str, Any]) -> go.Scatter:
    (left, right), (low, high) = along, radii
    return trace([left, right, right, left, left], [low, low, high, high, low], look)


def boxes(
    along: tuple[float, float], radii: tuple[float, float], group: Group, layout: SectionLayout, look: Mapping[str, Any]
) -> list[go.Scatter]:
    """A box above the axis, below it, or both where the group turns about the axis."""
    return [box(along, (sign * radii[0], sign * radii[1]), look) for sign in signs(group, layout)]


def signs(group: Group, layout: SectionLayout) -> tuple[int, ...]:
    if group.first.branch:
        return (group.half,)
    return (1, -1) if layout.both and group.first.radius < 1e-9 else (1,)


def appearance(group: Group, white: float = 0.62) -> dict[str, Any]:
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


def lane_radii(number: int, layout: SectionLayout) -> tuple[float, float]:
    """Radii of a shaft [m]; that in lane 0 is solid."""
    return layout.length(LANE * number + 1.0) if number else 0.0, layout.length(LANE * (number + 1) - 1.0)


def lane_of(group: Group, column: Column, side: str) -> int:
    """Lane of its shaft on a side; a lone body stands on the shafts that pass under it."""
    stack = column.left if side == "left" else column.right
    return column.passing + (stack.index(group.key) if group.key in stack and not column.lone else 0)


def base_of(group: Group, column: Column, layout: SectionLayout) -> float:
    """Inner radius of a member about the axis [m]."""
    sides = [side for side, stack in (("left", column.left), ("right", column.right)) if group.key in stack]
    number = min((lane_of(group, column, side) for side in sides), default=column.passing)
    return lane_radii(number, layout)[0]


def edge_of(column: Column, side: str) -> float:
    return (column.low if side == "left" else column.high) + column.shift


def beyond(column: Column, side: str, pixels: float, layout: SectionLayout) -> float:
    """Place so many pixels beyond the gears [m]."""
    return edge_of(column, side) + (-1 if side == "left" else 1) * layout.length(pixels)


def end_of(group: Group, column: Column, side: str, layout: SectionLayout) -> float:
    """End of its shaft: the nearer the axis, the further out [m]."""
    if column.lone:
        return beyond(column, side, BODY / 2, layout)
    stack = column.left if side == "left" else column.right
    return beyond(column, side, 4 * PLATE + SEGMENT * (len(stack) - stack.index(group.key)), layout)


def cheek(column: Column, side: str, layout: SectionLayout) -> tuple[float, float]:
    """Axial ends of a carrier's cheek [m]."""
    return beyond(column, side, 0.4 * PLATE, layout), beyond(column, side, 1.4 * PLATE, layout)


def disc(column: Column, side: str, layout: SectionLayout) -> tuple[float, float]:
    """Axial ends of the disc that carries a turning ring [m]."""
    return beyond(column, side, 2.2 * PLATE, layout), beyond(column, side, 3.2 * PLATE, layout)


_DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
_UNITS = ("N/m", "N/m", "N/m", "N m/rad", "N m/rad", "N m/rad")
_SYMBOLS = {
    "elastic support or bearing": {"symbol": "square-x-open", "color": INK},
    "rigid support or bearing": {"symbol": "square-x", "color": "#9AA5B1"},
}


def supports(layout: SectionLayout) -> list[go.Scatter]:
    """Bearings and supports where they stand, and the housing that they, pins and held members stand in."""
    where = where_of(layout)
    marks: dict[tuple[float, float], list[SectionLink]] = {}
    walls: set[tuple[float, float, str]] = set()
    stems: list[tuple[float, float, float]] = []
    for link in layout.links:
        ends = [where[name] for name in (link.first, link.second) if name in where]
        if link.kind not in ("support", "bearing") or not ends:
            continue
        group, column = next((one for one in ends if one[0].first.branch), ends[0])
        if not (link.radial or link.axial or link.turning):
            continue
        for sign in signs(group, layout):
            z, r = _seat(link, group, column, layout)
            fixed = not link.second and (group.held or link.turning) and not group.first.branch
            if group.internal:
                top = group.high + layout.length(20)
                walls.add((round(z, 9), sign * top, "up" if sign > 0 else "down"))
                stems.append((z, sign * group.high, sign * top))
                r = group.high + layout.length(10)
            if fixed and not group.internal and group.key in (*column.left, *column.right) and not column.lone:
                side = "left" if group.key in column.left else "right"
                end = end_of(group, column, side, layout)
                walls.add((round(end, 9), sign * lane_radii(lane_of(group, column, side), layout)[1] / 2, side))
            if not (fixed and group.internal) and (link.radial or link.axial):
                marks.setdefault((round(z, 9), sign * r), []).append(link)
    walls |= _pin_walls(layout)
    stem = {"line": {"color": INK, "width": 1.6}}
    lines = [trace([z, z], [low, high], stem) for z, low, high in dict.fromkeys(stems)]
    return [*lines, *_grounds(walls, layout), *_marked(marks, layout)]


def _pin_walls(layout: SectionLayout) -> set[tuple[float, float, str]]:
    """Where pins of planets that no carrier holds stand in the housing."""
    return {
        (round(cheek(column, side, layout)[1], 9), group.half * group.first.radius, side)
        for column in layout.columns
        for group in column.groups
        if group.first.branch and not group.first.carried_by
        for side in ("left", "right")
    }


def _seat(link: SectionLink, group: Group, column: Column, layout: SectionLayout) -> tuple[float, float]:
    """Place of a support or bearing [m]: its station; of one in the middle of its member, the shaft that shows."""
    station = link.station if np.isfinite(link.station) else group.first.station
    if group.first.branch:
        return station + column.shift, group.first.radius
    if group.internal:
        return station + column.shift, group.high
    if group.first.radius > 1e-9:
        lumped = column.low <= station <= column.high
        place = beyond(column, "left", 0.5 * SEGMENT, layout) if lumped else station + column.shift
        return place, group.first.radius
    if column.lone:
        return station + column.shift, base_of(group, column, layout) + layout.length(LANE)
    sides = [side for side, stack in (("left", column.left), ("right", column.right)) if group.key in stack]
    if not sides:
        return station + column.shift, base_of(group, column, layout) + layout.length(LANE / 2)
    side = "right" if "right" in sides and station > (column.low + column.high) / 2 else sides[0]
    low, high = lane_radii(lane_of(group, column, side), layout)
    if column.low <= station <= column.high:
        out = SEGMENT / 2 if not group.held else 0.7 * SEGMENT
        inward = -1 if side == "right" else 1
        return end_of(group, column, side, layout) + inward * layout.length(out), (low + high) / 2
    return station + column.shift, (low + high) / 2


def _marked(marks: Mapping[tuple[float, float], Sequence[SectionLink]], layout: SectionLayout) -> list[go.Scatter]:
    """Symbols of supports and bearings: elastic or rigid; with bars on both sides where they hold axially."""
    found: list[go.Scatter] = []
    for name, look in _SYMBOLS.items():
        rigid = name.startswith("rigid")
        own = {at: links for at, links in marks.items() if any(link.radial for link in links)}
        own = {at: links for at, links in own.items() if all(math.isinf(max(k.stiffness[:2])) for k in links) == rigid}
        if own:
            words = ["<br>".join(map(spring, links)) for links in own.values()]
            marker = {**look, "size": 11, "line": {"width": 1.4, "color": INK}}
            words_of = {"hoverinfo": "text", "text": words, "name": name, "showlegend": True}
            found.append(
                trace([z for z, _ in own], [r for _, r in own], {"mode": "markers", "marker": marker, **words_of})
            )
    axial = [at for at, links in marks.items() if any(link.axial for link in links)]
    if axial:
        z = [one[0] + way * layout.length(9) for one in axial for way in (-1, 1)]
        bar = {"symbol": "line-ns-open", "size": 13, "color": INK, "line": {"width": 1.8, "color": INK}}
        shown = {"mode": "markers", "marker": bar, "name": "holds axially", "showlegend": True}
        found.append(trace(z, [one[1] for one in axial for _ in (0, 1)], shown))
    return found


def _grounds(walls: Iterable[tuple[float, float, str]], layout: SectionLayout) -> list[go.Scatter]:
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
            end = (sign * deep, one - deep) if upright else (one - deep, sign * deep)
            strokes.append([(0.0, one) if upright else (one, 0.0), end])
        for stroke in strokes:
            z += [*(at + dz for dz, _ in stroke), math.nan]
            r += [*(height + dr for _, dr in stroke), math.nan]
    look = {"line": {"color": INK, "width": 1.3}, "name": "housing", "showlegend": True}
    return [trace(z, r, look)] if z else []


def spring(link: SectionLink) -> str:
    """The stiffness of a link (6,) [N/m, N m/rad] in words."""
    rows = [
        f"{direction}: {'rigid' if np.isinf(value) else f'{engineering(float(value))} {unit}'}"
        for direction, unit, value in zip(_DIRECTIONS, _UNITS, link.stiffness, strict=True)
        if value > 0
    ]
    return "<br>".join([f"<b>{link.name}</b>", *rows])
