"""Where everything of an axial section stands: stages and lone bodies in series, shafts in lanes about the axis.

Boxes of bodies, springs of bearings and supports and the housing share places about a column: lanes of shafts, cheeks,
discs, ends.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..charts.style import INK, kind_colour, tint
from ..series import Array, compact, engineering, numbers, texts
from .bodies import Part, faces, matings, parts

WIDE = 800.0  # of the drawing in a figure of 900 px [px]
TALL = 400.0  # at most, of radii [px]
SEGMENT = 34.0  # a length of shaft that shows: room for a bearing, and for the end of the shaft around it [px]
LANE = 11.0  # thickness of a shaft [px]
PLATE = 9.0  # thickness of a carrier's cheek, of the disc of a ring [px]
BODY = 34.0  # width of a body without teeth [px]
AIR = 8.0  # between things that do not touch [px]
MARGIN = 26.0  # beside the drawing [px]


@dataclass(frozen=True, slots=True, kw_only=True)
class SectionLink:
    """A bearing, support, neck, shaft or coupling: bodies by name, axial place [m], stiffness (6,) [N/m, N m/rad]."""

    name: str
    kind: str
    first: str
    second: str
    station: float
    stiffness: tuple[float, ...]

    @property
    def radial(self) -> bool:
        return max(self.stiffness[:2]) > 0

    @property
    def axial(self) -> bool:
        return self.stiffness[2] > 0

    @property
    def turning(self) -> bool:
        return self.stiffness[5] > 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Bodies that are one member of one branch; radii from the axis of the stage [m].

    low, high : what it takes of the radius, to the pitch point of a mesh where there is one in the plane.
    half : 1 drawn above the axis, -1 below it.  held : it does not turn.  power : into the train, of all bodies [W].
    """

    key: tuple[str, str, int]
    place: str
    bodies: tuple[Part, ...]
    low: float
    high: float
    half: int
    held: bool
    power: float

    @property
    def first(self) -> Part:
        return self.bodies[0]

    @property
    def kind(self) -> str:
        return self.first.kind

    @property
    def internal(self) -> bool:
        return self.first.form is not None and self.first.form.internal

    @property
    def word(self) -> str:
        """Its name on the drawing."""
        return self.first.short.removesuffix(" 1") if self.first.branch else self.first.short

    @property
    def faces(self) -> list[tuple[float, float, int]]:
        """(from, to, hand) of every helix, left to right [m]."""
        return sorted(face for body in self.bodies for face in faces(body))


class Coupling(NamedTuple):
    """Two groups in two columns that a link couples, the left one first; `lane` of a shaft that passes others."""

    name: str
    left: tuple[str, str, int]
    right: tuple[str, str, int]
    lane: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A stage, or a body without teeth that carries nothing.

    low, high : axial ends of its gears [m].  shift : added to z.  passing : shafts that go through under it.
    left, right : groups whose shafts leave on that side, from the axis outwards.
    room_left, room_right : beside the gears [px].
    """

    place: str
    groups: tuple[Group, ...]
    low: float
    high: float
    shift: float = 0.0
    passing: int = 0
    left: tuple[tuple[str, str, int], ...] = ()
    right: tuple[tuple[str, str, int], ...] = ()
    room_left: float = 0.0
    room_right: float = 0.0

    def sides_of(self, group: Group) -> list[str]:
        """Sides on which the shaft of a group leaves."""
        return [side for side, stack in (("left", self.left), ("right", self.right)) if group.key in stack]

    @property
    def lone(self) -> bool:
        return all(group.first.form is None for group in self.groups)

    @property
    def top(self) -> float:
        """Largest radius of what has teeth or carries some [m]."""
        return max(group.high for group in self.groups)


@dataclass(frozen=True, slots=True, kw_only=True)
class SectionLayout:
    """The whole section.  scale : [px/m] in a figure of 900 px.  both : drawn above and below the axis."""

    columns: tuple[Column, ...]
    couplings: tuple[Coupling, ...]
    links: tuple[SectionLink, ...]
    scale: float
    top: float
    both: bool

    def length(self, pixels: float) -> float:
        """Pixels as a length [m]."""
        return pixels / self.scale


def text_width(text: str) -> float:
    """About what a text takes in 12 px [px]."""
    return 6.9 * max(len(line) for line in text.split("<br>"))


def layout_of(check: xr.Dataset) -> SectionLayout:
    """Stages in the order of the file or of their stations, lone bodies between what they couple.

    Parameters
    ----------
    check : Dataset of `check`: what `parts.parts` and `parts.matings` read; link_first, link_second, link_kind,
        link_station [m] (link), link_stiffness (link, direction) [N/m, N m/rad], power (body) [W].
    """
    links = _links(check)
    groups = _groups(check, links)
    ends = {body.name: group for group in groups for body in group.bodies}
    coupled = _coupled(links, ends)
    columns = _sided(_ordered(groups, coupled), coupled)
    places = {column.place: place for place, column in enumerate(columns)}
    found = _lanes(coupled, places)
    for place, column in enumerate(columns):
        lanes = [one.lane for one in found if one.lane >= 0 and places[one.left[0]] < place < places[one.right[0]]]
        passing = max(lanes, default=-1) + 1
        columns[place] = replace(
            column, passing=passing, room_left=_room(column, "left"), room_right=_room(column, "right")
        )
    top = max(column.top for column in columns if not column.lone or len(columns) == 1)
    both = any(group.half < 0 for group in groups)
    scale = _scale(columns, top, both)
    return SectionLayout(
        columns=tuple(_shifted(columns, scale)), couplings=tuple(found), links=links, scale=scale, top=top, both=both
    )


def _links(check: xr.Dataset) -> tuple[SectionLink, ...]:
    if "link" not in check.dims:
        return ()
    stiffness = check["link_stiffness"].transpose("link", "direction").values
    words = [texts(check, name, "link") for name in ("link", "link_kind", "link_first", "link_second")]
    rows = zip(*words, numbers(check, "link_station", "link"), stiffness, strict=True)
    return tuple(
        SectionLink(
            name=name,
            # a result file that is older than the variable has the kind in the name alone
            kind=kind
            or next((word for word in ("support", "bearing", "neck", "shaft") if f"/{word}" in name), "coupling"),
            first=first,
            second=second,
            station=float(station),
            stiffness=tuple(map(float, k)),
        )
        for name, kind, first, second, station, k in rows
    )


def _groups(check: xr.Dataset, links: Sequence[SectionLink]) -> list[Group]:
    members: dict[tuple[str, str, int], list[Part]] = {}
    for part in parts(check):
        if part.branch in (0, 1):
            members.setdefault((part.place, part.member, part.branch), []).append(part)
    power = dict(zip(texts(check, "body"), np.nan_to_num(numbers(check, "power", "body")), strict=True))
    still = {link.first for link in links if not link.second and math.isinf(link.stiffness[5])}
    edges, halves = _edges(check), _halves(members)
    return [
        Group(
            key=key,
            place=key[0],
            bodies=tuple(sorted(own, key=lambda part: part.station)),
            **_reach(own, edges),
            half=halves.get(key, 1),
            held=own[0].speed == 0 or any(part.name in still for part in own),
            power=float(sum(power[part.name] for part in own)),
        )
        for key, own in members.items()
    ]


def _halves(members: Mapping[tuple[str, str, int], Sequence[Part]]) -> dict[tuple[str, str, int], int]:
    """Axes of branch 1 of a stage, the first above, the second below, ... : each plane holds one of them."""
    found: dict[tuple[str, str, int], int] = {}
    axes: dict[str, list[tuple[float, float]]] = {}
    for key, own in members.items():
        if own[0].branch:
            at = (round(own[0].x, 6), round(own[0].y, 6))
            known = axes.setdefault(key[0], [])
            if at not in known:
                known.append(at)
            found[key] = 1 - 2 * (known.index(at) % 2)
    return found


def _edges(check: xr.Dataset) -> dict[str, list[float]]:
    """Distances of the pitch points of every gear from the axis [m], where both gears stand in one plane."""
    place = {part.name: part for part in parts(check)}
    found: dict[str, list[float]] = {}
    for one in matings(check):
        a, b = place[one.a], place[one.b]
        if a.form is None or b.form is None or not _in_plane(a, b):
            continue
        cosine = math.cos(one.pressure_angle) if np.isfinite(one.pressure_angle) else math.nan
        for part, other in ((a, b), (b, a)):
            form = part.form
            assert form is not None
            radius = form.base_radius / cosine if np.isfinite(cosine) else form.reference_radius
            outwards = other.form is not None and (other.form.internal or other.radius > part.radius)
            sign = 1 if outwards or form.internal else -1
            found.setdefault(part.name, []).append(part.radius + sign * radius)
    return found


def _in_plane(a: Part, b: Part) -> bool:
    """Whether a plane through the axis holds both centres, on one side of it."""
    across = a.x * b.y - a.y * b.x
    return min(a.radius, b.radius) < 1e-9 or (abs(across) < 1e-6 * a.radius * b.radius and a.x * b.x + a.y * b.y > 0)


def _reach(own: Sequence[Part], edges: Mapping[str, Sequence[float]]) -> dict[str, float]:
    first = own[0]
    found = [edge for part in own for edge in edges.get(part.name, ())]
    if first.form is None:
        return {"low": 0.0, "high": first.outer}
    if first.form.internal:
        return {"low": min(found, default=first.form.reference_radius), "high": max(part.outer for part in own)}
    tip = first.form.tip_radius
    high = max((edge for edge in found if edge > first.radius), default=first.radius + tip)
    low = min((edge for edge in found if edge < first.radius), default=first.radius - tip)
    return {"low": max(0.0, low if first.radius > 0 else 0.0), "high": high}


def _coupled(links: Iterable[SectionLink], ends: Mapping[str, Group]) -> list[tuple[str, Group, Group]]:
    """Links between members of different places that turn about the axis."""
    found = []
    for link in links:
        one, other = ends.get(link.first), ends.get(link.second)
        if one and other and one.place != other.place and not one.first.branch and not other.first.branch:
            found.append((link.name, one, other))
    return found


def _ordered(groups: Sequence[Group], coupled: Sequence[tuple[str, Group, Group]]) -> list[Column]:
    """Stages by station, else as they are written; lone bodies where couplings become shortest."""
    columns: dict[str, Column] = {}
    for place in dict.fromkeys(group.place for group in groups):
        own = tuple(group for group in groups if group.place == place)
        ends = [end for group in own if group.first.form is not None for face in group.faces for end in face[:2]]
        ends = ends or [group.first.station for group in own]
        columns[place] = Column(place=place, groups=own, low=min(ends), high=max(ends))
    order = [place for place, column in columns.items() if not column.lone]
    waiting = [place for place, column in columns.items() if column.lone]
    pairs = [(one.place, other.place) for _, one, other in coupled]
    while waiting:
        near = (place for place in waiting if any(place in pair and set(pair) & set(order) for pair in pairs))
        place = next(near, waiting[0])
        waiting.remove(place)
        tries = [[*order[:at], place, *order[at:]] for at in range(len(order), -1, -1)]
        order = min(tries, key=lambda places: _span(places, pairs))
    middle = {place: round((column.low + column.high) / 2, 6) for place, column in columns.items()}
    return [columns[place] for place in sorted(order, key=lambda place: middle[place])]


def _span(order: Sequence[str], pairs: Iterable[tuple[str, str]]) -> int:
    at = {place: number for number, place in enumerate(order)}
    return sum(abs(at[one] - at[other]) for one, other in pairs if one in at and other in at)


def _sided(columns: Sequence[Column], coupled: Sequence[tuple[str, Group, Group]]) -> list[Column]:
    """Each shaft to the side of what it is coupled to; else the sun to its loaded end or left, a carrier opposite."""
    places = {column.place: number for number, column in enumerate(columns)}
    towards: dict[tuple[str, str, int], set[str]] = {}
    for _, one, other in coupled:
        for group, far in ((one, other), (other, one)):
            side = "right" if places[far.place] > places[group.place] else "left"
            towards.setdefault(group.key, set()).add(side)
    return [_sides_of(column, towards) for column in columns]


_RANK = {"sun": 0, "gear": 1, "body": 1, "carrier": 2, "ring": 3}


def _sides_of(column: Column, towards: Mapping[tuple[str, str, int], set[str]]) -> Column:
    central = [group for group in column.groups if not group.first.branch and group.first.radius < 1e-9]
    chosen: dict[tuple[str, str, int], set[str]] = {}
    for group in sorted(central, key=lambda one: (_RANK.get(one.kind, 1), one.high)):
        own = towards.get(group.key)
        if own is None and not column.lone and not (group.internal and (group.held or not group.power)):
            free = Counter(side for sides in chosen.values() for side in sides)
            loaded = [part.side for part in group.bodies if part.side and abs(np.nan_to_num(part.torque)) > 0]
            prefer = loaded[0] if len(loaded) == 1 else "left" if _RANK.get(group.kind, 1) < 2 else "right"
            other = "left" if prefer == "right" else "right"
            own = {other if len(loaded) != 1 and free[prefer] > free[other] else prefer}
        if own:
            chosen[group.key] = own
    # sorted by rank: from the axis outwards
    left, right = (tuple(key for key, sides in chosen.items() if side in sides) for side in ("left", "right"))
    return replace(column, left=left, right=right)


def _lanes(coupled: Sequence[tuple[str, Group, Group]], places: Mapping[str, int]) -> list[Coupling]:
    """Couplings from left to right; those that pass a column get a lane of their own about the axis."""
    found: list[Coupling] = []
    taken: list[tuple[int, int, int]] = []
    for name, one, other in coupled:
        a, b = sorted((one, other), key=lambda group: places[group.place])
        first, last = places[a.place], places[b.place]
        lane = -1
        if last > first + 1:
            used = {which for which, start, stop in taken if start < last and stop > first}
            lane = next(number for number in range(len(taken) + 1) if number not in used)
            taken.append((lane, first, last))
        found.append(Coupling(name=name, left=a.key, right=b.key, lane=lane))
    return found


def _room(column: Column, side: str) -> float:
    """What a column needs beside its gears [px]: discs, shafts, names."""
    if column.lone:
        names = [f"{group.word}<br>{'9999 kW out' if group.power else ''}" for group in column.groups]
        return max(BODY, *map(text_width, names)) / 2 + AIR / 2
    stack = column.left if side == "left" else column.right
    shafts = 4 * PLATE + SEGMENT * len(stack)
    ports = [group for group in column.groups if group.key in stack and group.power]
    words = max((text_width("9999 kW out") + AIR for _ in ports), default=0.0)
    central = [group for group in column.groups if not group.first.branch and not group.internal]
    named = max((text_width(group.word) + 3 * PLATE + AIR for group in central), default=0.0)
    named = named if side == "right" else 0.0
    return max(shafts + words, named)


def _scale(columns: Sequence[Column], top: float, both: bool) -> float:
    """Pixels per metre such that the drawing fills the width, or its radii the height."""
    across = sum(column.high - column.low for column in columns)
    spent = sum(column.room_left + column.room_right + AIR for column in columns) + 2 * MARGIN
    tall = TALL / (2 if both else 1) / top
    least = 0.25 * WIDE / across if across > 0 else tall  # a crowded series is drawn wider than the page is
    return min(tall, max((WIDE - spent) / across, least)) if across > 0 else tall


def _shifted(columns: Sequence[Column], scale: float) -> list[Column]:
    """Columns one behind the other: where they stand, or further right where they would meet."""
    result: list[Column] = []
    behind = -math.inf
    for column in columns:
        shift = max(0.0, behind - (column.low - column.room_left / scale))
        result.append(replace(column, shift=shift))
        behind = column.high + shift + (column.room_right + AIR) / scale
    return result


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
    number = min((lane_of(group, column, side) for side in column.sides_of(group)), default=column.passing)
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
            if fixed and not group.internal and column.sides_of(group) and not column.lone:
                side = column.sides_of(group)[0]
                end = end_of(group, column, side, layout)
                walls.add((round(end, 9), sign * lane_radii(lane_of(group, column, side), layout)[1] / 2, side))
            if not (fixed and group.internal) and (link.radial or link.axial):
                marks.setdefault((round(z, 9), sign * r), []).append(link)
    for column in layout.columns:  # pins of planets that no carrier holds stand in the housing
        for group in column.groups:
            if group.first.branch and not group.first.carried_by:
                height = group.half * group.first.radius
                walls |= {(round(cheek(column, side, layout)[1], 9), height, side) for side in ("left", "right")}
    stem = {"line": {"color": INK, "width": 1.6}}
    lines = [trace([z, z], [low, high], stem) for z, low, high in dict.fromkeys(stems)]
    return [*lines, *_grounds(walls, layout), *_marked(marks, layout)]


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
    sides = column.sides_of(group)
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
        radial = {at: links for at, links in marks.items() if any(link.radial for link in links)}
        own = {at: k for at, k in radial.items() if all(math.isinf(max(one.stiffness[:2])) for one in k) == rigid}
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
        sign = 1 if way in ("up", "right") else -1
        # of an upright wall; the others are these with their axes exchanged
        strokes = [[(0.0, -half), (0.0, half)]]
        strokes += [[(0.0, one), (sign * deep, one - deep)] for one in np.linspace(-half, half, 5)]
        for stroke in strokes:
            ends = stroke if way in ("left", "right") else [end[::-1] for end in stroke]
            z += [*(at + dz for dz, _ in ends), math.nan]
            r += [*(height + dr for _, dr in ends), math.nan]
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
