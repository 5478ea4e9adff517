"""Where everything of an axial section stands: stages and lone bodies in series, shafts in lanes about the axis.

Boxes of bodies, springs of bearings and supports and the housing share places about a column: lanes of shafts, cheeks,
discs, ends.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..series import grouped, numbers, texts
from .bodies import DrawnTrain, Part, faces, pitch_radius

WIDE = 800.0  # of the drawing in a figure of 900 px [px]
TALL = 400.0  # at most, of radii [px]
SEGMENT = 34.0  # a length of shaft that shows: room for a bearing, and for the end of the shaft around it [px]
LANE = 11.0  # thickness of a shaft [px]
PLATE = 9.0  # thickness of a carrier's cheek, of the disc of a ring [px]
BODY = 34.0  # width of a body without teeth [px]
AIR = 8.0  # between things that do not touch [px]
MARGIN = 26.0  # beside the drawing [px]
SIDES = ("left", "right")
Ends = tuple[float, float]
Key = tuple[str, str, int]
"""Place, member and branch of a group."""


class SectionLink(NamedTuple):
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

    key: Key
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
    left: Key
    right: Key
    lane: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A stage, or a body without teeth that carries nothing.

    low, high : axial ends of its gears [m].  shift : added to z.  passing : shafts that go through under it.
    stacks : side -> groups whose shafts leave there, from the axis outwards.  rooms : side -> beside the gears [px].
    """

    place: str
    groups: tuple[Group, ...]
    low: float
    high: float
    shift: float = 0.0
    passing: int = 0
    stacks: Mapping[str, tuple[Key, ...]] = field(default_factory=dict)
    rooms: Mapping[str, float] = field(default_factory=dict)

    def sides_of(self, group: Group) -> list[str]:
        """Sides on which the shaft of a group leaves."""
        return [side for side in SIDES if group.key in self.stacks[side]]

    def edge(self, side: str) -> float:
        """Axial end of its gears where it stands [m]."""
        return (self.low if side == "left" else self.high) + self.shift

    @property
    def middle(self) -> float:
        return (self.low + self.high) / 2 + self.shift

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

    def lane(self, number: int) -> Ends:
        """Radii of a shaft [m]; that in lane 0 is solid."""
        return self.length(LANE * number + 1.0) if number else 0.0, self.length(LANE * (number + 1) - 1.0)

    def beyond(self, column: Column, side: str, pixels: float) -> float:
        """Place so many pixels beyond the gears [m]."""
        return column.edge(side) + (-1 if side == "left" else 1) * self.length(pixels)

    def cheek(self, column: Column, side: str) -> Ends:
        """Axial ends of a carrier's cheek [m]."""
        return self.beyond(column, side, 0.4 * PLATE), self.beyond(column, side, 1.4 * PLATE)

    @property
    def seats(self) -> list[Seat]:
        return [Seat(group, column, self) for column in self.columns for group in column.groups]

    @property
    def seat_of(self) -> dict[str, Seat]:
        """Body -> where its group stands."""
        return {part.name: seat for seat in self.seats for part in seat.group.bodies}


class Seat(NamedTuple):
    """A group where it stands; lengths [m]."""

    group: Group
    column: Column
    layout: SectionLayout

    @property
    def signs(self) -> tuple[int, ...]:
        """1 where it is drawn above the axis, -1 below it; both where it turns about the axis of a whole section."""
        if self.group.first.branch:
            return (self.group.half,)
        return (1, -1) if self.layout.both and self.central else (1,)

    @property
    def central(self) -> bool:
        """Whether it stands on the axis of the section."""
        return self.group.first.radius < 1e-9

    @property
    def sides(self) -> list[str]:
        """Sides on which its shaft leaves."""
        return self.column.sides_of(self.group)

    def lane(self, side: str) -> int:
        """Lane of its shaft on a side; a lone body stands on the shafts that pass under it."""
        stack, key = self.column.stacks[side], self.group.key
        return self.column.passing + (stack.index(key) if key in stack and not self.column.lone else 0)

    def shaft(self, side: str) -> Ends:
        """Radii of its shaft on a side."""
        return self.layout.lane(self.lane(side))

    @property
    def base(self) -> float:
        """Inner radius of a member about the axis."""
        return self.layout.lane(min((self.lane(side) for side in self.sides), default=self.column.passing))[0]

    @property
    def height(self) -> float:
        """Radius of a lone body, which has none of its own."""
        return max(0.3 * self.layout.top, self.layout.lane(self.column.passing + 2)[1])

    @property
    def carried(self) -> list[Group]:
        """The planets of a carrier."""
        names = {part.name for part in self.group.bodies}
        return [other for other in self.column.groups if other.first.carried_by in names]

    def beyond(self, side: str, pixels: float) -> float:
        """Place so many pixels beyond the gears."""
        return self.layout.beyond(self.column, side, pixels)

    def end(self, side: str) -> float:
        """End of its shaft: the nearer the axis, the further out."""
        stack = self.column.stacks[side]
        out = BODY / 2 if self.column.lone else 4 * PLATE + SEGMENT * (len(stack) - stack.index(self.group.key))
        return self.beyond(side, out)

    def disc(self, side: str) -> Ends:
        """Axial ends of the disc that carries a turning ring."""
        return self.beyond(side, 2.2 * PLATE), self.beyond(side, 3.2 * PLATE)


def text_width(text: str) -> float:
    """About what a text takes in 12 px [px]."""
    return 6.9 * max(len(line) for line in text.split("<br>"))


def layout_of(check: xr.Dataset, train: DrawnTrain) -> SectionLayout:
    """Stages in the order of the file or of their stations, lone bodies between what they couple.

    Parameters
    ----------
    check : Dataset of `check`: link_first, link_second, link_kind, link_station [m] (link), link_stiffness (link,
        direction) [N/m, N m/rad], power (body) [W].
    train : of the same.
    """
    links = _links(check)
    groups = _groups(check, train)
    ends = {body.name: group for group in groups for body in group.bodies}
    coupled = _coupled(links, ends)
    columns = _sided(_ordered(groups, coupled), coupled)
    places = {column.place: place for place, column in enumerate(columns)}
    found = _lanes(coupled, places)
    for place, column in enumerate(columns):
        lanes = [one.lane for one in found if one.lane >= 0 and places[one.left[0]] < place < places[one.right[0]]]
        passing = max(lanes, default=-1) + 1
        columns[place] = replace(column, passing=passing, rooms={side: _room(column, side) for side in SIDES})
    top = max(column.top for column in columns if not column.lone or len(columns) == 1)
    both = any(group.half < 0 for group in groups)
    scale = _scale(columns, top, both)
    return SectionLayout(
        columns=tuple(_shifted(columns, scale)), couplings=tuple(found), links=links, scale=scale, top=top, both=both
    )


_KINDS = ("support", "bearing", "neck", "shaft")


def _links(check: xr.Dataset) -> tuple[SectionLink, ...]:
    if "link" not in check.dims:
        return ()
    names, kinds, *ends = (texts(check, name, "link") for name in ("link", "link_kind", "link_first", "link_second"))
    # a result file that is older than the variable has the kind in the name alone
    kinds = [
        kind or next((word for word in _KINDS if f"/{word}" in name), "coupling")
        for name, kind in zip(names, kinds, strict=True)
    ]
    stiffness = map(tuple, check["link_stiffness"].transpose("link", "direction").values.tolist())
    return tuple(map(SectionLink, names, kinds, *ends, numbers(check, "link_station", "link").tolist(), stiffness))


def _groups(check: xr.Dataset, train: DrawnTrain) -> list[Group]:
    shown = [part for part in train.parts if part.branch in (0, 1)]
    members = grouped(((part.place, part.member, part.branch) for part in shown), shown)
    power = dict(zip(texts(check, "body"), np.nan_to_num(numbers(check, "power", "body")), strict=True))
    edges, halves = _edges(train), _halves(members)
    return [
        Group(
            key=key,
            place=key[0],
            bodies=tuple(sorted(own, key=lambda part: part.station)),
            **_reach(own, edges),
            half=halves.get(key, 1),
            held=any(part.name in train.still for part in own),
            power=float(sum(power[part.name] for part in own)),
        )
        for key, own in members.items()
    ]


def _halves(members: Mapping[Key, Sequence[Part]]) -> dict[Key, int]:
    """Axes of branch 1 of a stage, the first above, the second below, ... : each plane holds one of them."""
    found: dict[Key, int] = {}
    axes: dict[str, list[tuple[float, float]]] = {}
    for key, own in members.items():
        if own[0].branch:
            at = (round(own[0].x, 6), round(own[0].y, 6))
            known = axes.setdefault(key[0], [])
            if at not in known:
                known.append(at)
            found[key] = 1 - 2 * (known.index(at) % 2)
    return found


def _edges(train: DrawnTrain) -> dict[str, list[float]]:
    """Distances of the pitch points of every gear from the axis [m], where both gears stand in one plane."""
    place = {part.name: part for part in train.parts}
    found: dict[str, list[float]] = {}
    for one in train.meshes:
        a, b = place[one.a], place[one.b]
        if a.form is None or b.form is None or not _in_plane(a, b):
            continue
        for part, other in ((a, b), (b, a)):
            assert part.form is not None
            outwards = other.form is not None and (other.form.internal or other.radius > part.radius)
            sign = 1 if outwards or part.form.internal else -1
            found.setdefault(part.name, []).append(part.radius + sign * pitch_radius(part, one))
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
    return {"low": max(0.0, low), "high": high}


def _coupled(links: Iterable[SectionLink], ends: Mapping[str, Group]) -> list[tuple[str, Group, Group]]:
    """Links between members of different places that turn about the axis."""
    pairs = [(link.name, ends.get(link.first), ends.get(link.second)) for link in links]
    return [
        (name, one, other)
        for name, one, other in pairs
        if one and other and one.place != other.place and not one.first.branch and not other.first.branch
    ]


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
    towards: dict[Key, set[str]] = {}
    for _, one, other in coupled:
        for group, far in ((one, other), (other, one)):
            side = "right" if places[far.place] > places[group.place] else "left"
            towards.setdefault(group.key, set()).add(side)
    return [_sides_of(column, towards) for column in columns]


_RANK = {"sun": 0, "gear": 1, "body": 1, "carrier": 2, "ring": 3}


def _sides_of(column: Column, towards: Mapping[Key, set[str]]) -> Column:
    central = [group for group in column.groups if not group.first.branch and group.first.radius < 1e-9]
    chosen: dict[Key, set[str]] = {}
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
    return replace(column, stacks={at: tuple(key for key, sides in chosen.items() if at in sides) for at in SIDES})


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
    stack = column.stacks[side]
    shafts = 4 * PLATE + SEGMENT * len(stack)
    ports = any(group.key in stack and group.power for group in column.groups)
    words = text_width("9999 kW out") + AIR if ports else 0.0
    central = [group for group in column.groups if not group.first.branch and not group.internal]
    named = [text_width(group.word) + 3 * PLATE + AIR for group in central if side == "right"]
    return max([shafts + words, *named])


def _scale(columns: Sequence[Column], top: float, both: bool) -> float:
    """Pixels per metre such that the drawing fills the width, or its radii the height."""
    across = sum(column.high - column.low for column in columns)
    spent = sum(sum(column.rooms.values()) + AIR for column in columns) + 2 * MARGIN
    tall = TALL / (2 if both else 1) / top
    least = 0.25 * WIDE / across if across > 0 else tall  # a crowded series is drawn wider than the page is
    return min(tall, max((WIDE - spent) / across, least)) if across > 0 else tall


def _shifted(columns: Sequence[Column], scale: float) -> list[Column]:
    """Columns one behind the other: where they stand, or further right where they would meet."""
    result: list[Column] = []
    behind = -math.inf
    for column in columns:
        shift = max(0.0, behind - (column.low - column.rooms["left"] / scale))
        result.append(replace(column, shift=shift))
        behind = column.high + shift + (column.rooms["right"] + AIR) / scale
    return result
