"""A REXS file asked by what its components are to each other, and its planetary stages.

What was asked of it is kept: the rest is dropped.  Support vectors in nested reference frames become points and axes of
the gear unit.  Of the stages: which gears are sun, planets and ring, and which of them mesh; couplings and bearings
between shafts, plates and the casing, and which parts turn as one.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from .file import (
    BEARINGS,
    HELIX,
    QUANTITIES,
    RELATIONS,
    ROW,
    Component,
    LoadCase,
    Number,
    RexsFile,
    RexsRow,
    Value,
    number_in,
    number_of,
    rows_of,
    shown,
)

Table = dict[str, object]
Vector = NDArray[np.float64]  # (3,)
_Roles = tuple[int | None, ...]
_ORDERED = {"ordered_assembly": "assembly", "ordered_reference": "reference"}
_MOST_FRAMES = 50  # references nested deeper than any gear unit: a loop


class PartFrame(NamedTuple):
    """A place [m] and the axes u, v, w of a component, in the frame of the gear unit."""

    place: Vector
    u: Vector
    v: Vector
    w: Vector

    def turned(self, vector: Vector) -> Vector:
        """A vector given along the axes."""
        return np.asarray(vector @ np.array(self[1:]))


_UNIT = PartFrame(np.zeros(3), *np.eye(3))


Group = TypeVar("Group", bound=Hashable)
Grouped = TypeVar("Grouped", bound=Hashable)


def grouped(pairs: Iterable[tuple[Group, Grouped]]) -> dict[Group, tuple[Grouped, ...]]:
    """What belongs to each group, each once, in order."""
    groups: dict[Group, dict[Grouped, None]] = {}
    for group, one in pairs:
        groups.setdefault(group, {})[one] = None
    return {group: tuple(members) for group, members in groups.items()}


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of what an import did.

    component : id of the component, None where it is of the whole file.  attribute : which, or several.
    path : in the model file, empty where it went nowhere.  text : value, or reason.
    """

    component: int | None
    attribute: str
    path: str
    text: str

    @property
    def where(self) -> str:
        """What became of it, in words."""
        return f"{self.path} = {self.text}" if self.path and self.text else self.path or self.text


@dataclass(slots=True, kw_only=True)
class View:
    """A REXS file with the values of one load case, and the list of what was read, assumed and lost.

    components : by id, attributes of the load case laid over.  types : ids by type, ascending.
    related : parts of the relations of a type, in the order of its roles.  roles : of those with a part in a role.
    entries, assumptions, losses : each entry once, in the order of the questions.
    asked : component -> attributes that were asked for.  frames : of components, found when asked.
    unread : stages without planets, which are not read -> their two gears.
    """

    file: RexsFile
    components: Mapping[int, Component]
    types: Mapping[str, Sequence[int]]
    related: Mapping[str, Sequence[_Roles]]
    roles: Mapping[tuple[str, int, int], Sequence[_Roles]]
    entries: dict[Entry, None] = field(default_factory=dict)
    assumptions: dict[Entry, None] = field(default_factory=dict)
    losses: dict[Entry, None] = field(default_factory=dict)
    asked: dict[int, dict[str, None]] = field(default_factory=dict)
    frames: dict[int, PartFrame | None] = field(default_factory=dict)
    unread: dict[int, tuple[int, int]] = field(default_factory=dict)

    def of_type(self, *types: str) -> list[Component]:
        """Components of some types, by id."""
        return [self.components[i] for i in sorted(i for kind in types for i in self.types.get(kind, ()))]

    def joined(self, relation: str, part: int, role: int = 0, other: int = 1) -> list[int]:
        """Components in another role of the relations of a type with a part in a role, each once."""
        relations = self.roles.get((relation, role, part), ())
        return list(dict.fromkeys(number for parts in relations if (number := parts[other]) is not None))

    def parts(self, assembly: int, *types: str) -> list[int]:
        """Parts of an assembly, of some component types or of all."""
        return [p for p in self.joined("assembly", assembly) if not types or self.components[p].type in types]

    def shaft_of(self, part: int) -> int | None:
        """Shaft a gear or load is assembled to, None where there is none."""
        assemblies = self.joined("assembly", part, 1, 0)
        return next((a for a in assemblies if self.components[a].type == "shaft"), None)

    def referenced(self, origin: int) -> list[Component]:
        """What a component refers to: material, tool, flank modification."""
        return [self.components[part] for part in self.joined("reference", origin)]

    def flanks_of(self, gear: int) -> list[Component]:
        """Left and right flank of a gear, those that are given."""
        _, *sides = next(iter(self.roles.get(("flank", 0, gear), ())), (gear,))
        return [self.components[side] for side in sides if side is not None]

    def number(self, component: int, name: str) -> Number | None:
        """A number of a component; None where it is not given. Raises ModelError as of `number_of`."""
        self.asked.setdefault(component, {})[name] = None
        return number_of(self.components[component], name, QUANTITIES[ROW[name].unit])

    def value(self, component: int, name: str) -> Value:
        """A value of a component as it stands; None where it is not given."""
        self.asked.setdefault(component, {})[name] = None
        attribute = self.components[component].attributes.get(name)
        return None if attribute is None else attribute.value

    def si(self, component: int, name: str, otherwise: float = 0.0) -> float:
        """A number in SI, another where it is not given. Raises ModelError as of `number_of`."""
        number = self.number(component, name)
        return otherwise if number is None else number.si

    def mean(self, component: int, rows: Iterable[RexsRow]) -> float | None:
        """Mean in SI of those of some attributes that are given; None of none. Raises ModelError as of `number_of`."""
        numbers = [self.number(component, row.id) for row in rows]
        given = [number.si for number in numbers if number is not None]
        return sum(given) / len(given) if given else None

    def read(self, component: int | None, attribute: str, path: str, text: object) -> None:
        """Note that an attribute became what stands at a path."""
        self.entries[Entry(component, attribute, path, str(text))] = None

    def assume(self, component: int | None, attribute: str, path: str, reason: str) -> None:
        """Note what the file does not say and what was taken."""
        self.assumptions[Entry(component, attribute, path, reason)] = None

    def lose(self, component: int | None, attribute: str, reason: str) -> None:
        """Note what was asked and cannot be carried."""
        self.losses[Entry(component, attribute, "", reason)] = None

    def label(self, component: int) -> str:
        """``53 (cylindrical_gear)``."""
        return f"{component} ({self.components[component].type})"

    def frame(self, component: int, *, depth: int = 0) -> PartFrame | None:
        """Frame of a component; None where the file gives no place.  depth : of references up to it.

        Raises
        ------
        ModelError : no vector of three numbers, axes without direction, references in a circle.
        """
        if component in self.frames:
            return self.frames[component]
        if depth > _MOST_FRAMES:
            raise ModelError("references of position in a circle", path=f"component {self.label(component)}")
        place = self._vector(component, "support_vector")
        base = _UNIT
        reference = self.value(component, "reference_component_for_position")
        if isinstance(reference, (int, float)) and not isinstance(reference, bool):
            if int(reference) != component and int(reference) in self.components:
                base = self.frame(int(reference), depth=depth + 1) or _UNIT
        frame = None
        if place is not None:
            u = base.turned(self._axis(component, "u_axis_vector", _UNIT.u))
            w = base.turned(self._axis(component, "w_axis_vector", _UNIT.w))
            frame = PartFrame(base.place + base.turned(place), u, np.cross(w, u), w)
        self.frames[component] = frame
        return frame

    def place(self, component: int) -> Vector | None:
        """Place that a component itself has, None where the file gives none."""
        frame = self.frame(component)
        return None if frame is None else frame.place

    def on_shaft(self, component: int, shaft: int, coordinate: str) -> Vector | None:
        """Place of what sits on a shaft: its own, else its coordinate along the shaft."""
        if (place := self.place(component)) is not None:
            return place
        base, distance = self.frame(shaft), self.number(component, coordinate)
        # where along the shaft may not be said
        return None if base is None else base.place + base.u * (distance.si if distance is not None else 0.0)

    def gear_place(self, gear: int, shaft: int | None = None) -> Vector | None:
        """Centre of a gear: its own place, else that on its shaft.  shaft : of a planet, else found."""
        shaft = self.shaft_of(gear) if shaft is None else shaft
        return self.place(gear) if shaft is None else self.on_shaft(gear, shaft, "u_coordinate_on_shaft")

    def _vector(self, component: int, name: str) -> Vector | None:
        """A vector attribute as lengths in SI; None where it is not given."""
        value = self.value(component, name)
        if value is None:
            return None
        where = f"component {self.label(component)}, {name}"
        if not isinstance(value, tuple) or len(value) != 3 or None in value:
            given = list(value) if isinstance(value, tuple) else value
            raise ModelError("not a vector", path=where, given=given, allowed="an array of three numbers")
        unit = self.components[component].attributes[name].unit
        return np.array([number_in(entry, unit, "length", where).si for entry in value])

    def _axis(self, component: int, name: str, default: Vector) -> Vector:
        """A direction of length 1; its unit means nothing."""
        vector = self._vector(component, name)
        if vector is None:
            return default
        length = float(np.linalg.norm(vector))
        if not length > 1e-30:
            raise ModelError("a direction of length 0", path=f"component {self.label(component)}, {name}")
        return vector / length


def laid_over(components: Mapping[int, Component], case: LoadCase) -> dict[int, Component]:
    """Components by id with the attributes of a load case in place of their own, or beside them."""
    over = {one.id: components[one.id] for one in case.components if one.id in components}
    for one in case.components:
        if (base := over.get(one.id)) is not None:
            over[one.id] = replace(base, attributes={**base.attributes, **one.attributes})
    return {**components, **over}


def view_of(file: RexsFile, load_case: int | None) -> View:
    """The view of a file, with the attributes of a load case laid over.

    Raises
    ------
    ModelError : a load case that is not there.
    """
    components = {component.id: component for component in file.components}
    if load_case is not None:
        case = next((case for case in file.load_cases if case.id == load_case), None)
        if case is None:
            ids = ", ".join(str(c.id) for c in file.load_cases[:20]) or "none in this file"
            raise ModelError("no such load case", path="load_case", given=load_case, allowed=ids)
        components = laid_over(components, case)
    # those with an order say the same, and stand behind
    relations = sorted(file.relations, key=lambda relation: relation.type in _ORDERED)
    stated = [(_ORDERED.get(relation.type, relation.type), relation) for relation in relations]
    parts = [(kind, tuple(map(relation.part, RELATIONS.get(kind, ())))) for kind, relation in stated]
    roles = (((kind, role, part), ids) for kind, ids in parts for role, part in enumerate(ids) if part is not None)
    return View(
        file=file,
        components=components,
        types=grouped((components[number].type, number) for number in sorted(components)),
        related=grouped(parts),
        roles=grouped(roles),
    )


# joints ---------------------------------------------------------------------------------------------------------------

# Stiffness from which on a joint is rigid: "rigid" of the programs is 1e20 N/m and more, real joints stay below 1e13.
RIGID = 1e16
STIFFNESSES = [row for row in rows_of("coupling") if row.key]


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """A bearing or coupling between two parts, equal to itself alone.

    id : of its component.  ends : ids of the inner and the outer part.  bearing : turns freely about its axis.
    stiffness : by key of a link, None where not given; infinite where rigid, 0 where it holds nothing.
    """

    id: int
    ends: tuple[int, int]
    bearing: bool
    stiffness: Mapping[str, Number | None]

    @property
    def rigid(self) -> bool:
        """Whether it lets nothing move."""
        return not self.bearing and all(n is None or n.si >= RIGID for n in self.stiffness.values())

    @property
    def holds_turn(self) -> bool:
        """Whether a torque passes through it."""
        turn = self.stiffness["rz"]
        return not self.bearing and (turn is None or turn.si > 0)


def joints_of(view: View) -> list[Joint]:
    """Bearings and couplings of a file, engaged ones, by id. Raises ModelError for a stiffness without its unit."""
    joints = []
    kinds = ("side", "coupling", "connection")
    for relation in sorted((r for r in view.file.relations if r.type in kinds), key=lambda r: kinds.index(r.type)):
        joint, *sides = (relation.part(role) for role in RELATIONS["side"])
        if joint is None or None in sides:
            sides = [part for role, part in relation.refs if role not in ("assembly", "coupling", "connection")]
            joint = next((p for kind in ("assembly", *kinds[1:]) if (p := relation.part(kind)) is not None), None)
            if joint is None:
                continue
            if len(sides) != 2:
                view.lose(joint, "side", "not between two parts")
                continue
        inner, outer = (side for side in sides if side is not None)
        if _engaged(view, view.components[joint]):
            joints.append(Joint(joint, (inner, outer), *_held(view, view.components[joint])))
    return sorted(joints, key=lambda engaged: engaged.id)


def _engaged(view: View, component: Component) -> bool:
    """Whether a coupling is engaged in the gear that is shifted."""
    if component.type != "switchable_coupling":
        return True
    value = view.value(component.id, "is_engaged")
    if isinstance(value, tuple):
        units = view.of_type("gear_unit")
        shifted = view.value(units[0].id, "gear_shift_index") if units else 1
        index = int(shifted) - 1 if isinstance(shifted, (int, float)) and 1 <= shifted <= len(value) else 0
        value = value[index] if value else None
    if value is None:
        view.assume(component.id, "is_engaged", "", "not said whether it is engaged: taken as engaged")
    if value is False:
        view.lose(component.id, "is_engaged", "a coupling that is not engaged")
    return value is not False


def _held(view: View, component: Component) -> tuple[bool, dict[str, Number | None]]:
    """Whether a joint is a bearing, and its stiffnesses; what a bearing does not take up is 0."""
    stiffness = {row.key: view.number(component.id, row.id) for row in STIFFNESSES}
    if component.type not in BEARINGS:
        return False, stiffness
    if stiffness["radial"] is None:
        mean = view.mean(component.id, rows_of("concept_bearing", "radial"))
        if mean is not None:
            reason = "mean of both radial directions, without cross terms"
            view.assume(component.id, "operating_point_stiffness", "", reason)
            stiffness["radial"] = Number(mean, f"{shown(mean)} N/m")
    if view.value(component.id, "radial_force_absorption") is False:
        stiffness["radial"] = Number(0.0, "0")
    absorbed, axial = view.value(component.id, "axial_force_absorption"), stiffness["z"]
    if absorbed == "no_direction":
        stiffness["z"] = Number(0.0, "0")
    elif isinstance(absorbed, str) and absorbed != "both_directions" and (axial is None or axial.si > 0):
        view.assume(component.id, "axial_force_absorption", "", f"{absorbed}: holds in both directions")
    return True, stiffness


Id = TypeVar("Id", int, str)


@dataclass(slots=True)
class Parts(Generic[Id]):
    """Which parts are one: a union of sets of ids, or of names."""

    _above: dict[Id, Id] = field(default_factory=dict)

    def root(self, part: Id) -> Id:
        """The part that stands for all that are one with this."""
        while (above := self._above.get(part, part)) != part:
            self._above[part] = part = self._above.get(above, above)  # halves the way of the next question
        return part

    def join(self, parts: Iterable[Id]) -> None:
        """Make parts one; the least id stands for them."""
        roots = sorted({self.root(part) for part in parts})
        for root in roots[1:]:
            self._above[root] = roots[0]


def rigid_parts(view: View, joints: Iterable[Joint]) -> Parts[int]:
    """The parts that move as one: what is assembled in a planet carrier, a gear and its shaft, rigid joints."""
    parts = Parts[int]()
    for carrier in view.of_type("planet_carrier"):
        parts.join([carrier.id, *view.parts(carrier.id, "shaft", "side_plate")])
    for shaft in view.of_type("shaft"):
        parts.join([shaft.id, *view.parts(shaft.id, "cylindrical_gear", "ring_gear", "sleeve")])
    for joint in joints:
        if joint.rigid:
            parts.join(joint.ends)
    return parts


# stages ---------------------------------------------------------------------------------------------------------------

_GEARS = ("cylindrical_gear", "ring_gear")
_MOST_PLANETS = 100  # as many as a model file may have
_MOST_STAGES = 50


@dataclass(frozen=True, slots=True)
class Branch:
    """One planet position: its shaft and its gears in the order of the members of the stage."""

    shaft: int
    gears: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class StageParts:
    """A planetary stage by ids.

    id : of the component.  name : in the model file.
    central : member -> gear (the left one of a herringbone gear).
    planets : members of a branch.  branches : in the order of the file.  carrier : of a planet_carrier, or None.
    meshes : pair of members -> cylindrical stages of the branches, in their order.
    twins : gear -> the gear of opposite hand beside it, of herringbone gears.
    """

    id: int
    name: str
    central: Mapping[str, int]
    planets: tuple[str, ...]
    branches: tuple[Branch, ...]
    carrier: int | None
    meshes: Mapping[str, tuple[int, ...]]
    twins: Mapping[int, int]

    @property
    def gears(self) -> dict[str, int]:
        """Gear of each member, of planets that of branch 1."""
        return {**self.central, **dict(zip(self.planets, self.branches[0].gears, strict=True))}

    def mates(self, planet: str) -> list[str]:
        """Members that mesh with a planet."""
        pairs = [pair.split("-") for pair in self.meshes]
        return [member for pair in pairs if planet in pair for member in pair if member != planet]


_Meshes = Sequence[tuple[int, tuple[int, int]]]  # a cylindrical stage and its two gears


def planetary_stages(view: View) -> tuple[StageParts, ...]:
    """The planetary stages of a file.

    Raises
    ------
    ModelError : none, one without planets or gears, planets that mesh with each other, planets that differ.
    """
    components = view.of_type("planetary_stage")
    if not components:
        kinds = sorted({c.type for c in view.components.values() if c.type.endswith("_stage")})
        problem = f"no planetary stage (stages in it: {', '.join(kinds) or 'none'})"
        raise ModelError(problem, path="components", allowed="a gear unit with a planetary stage")
    if len(components) > _MOST_STAGES:
        raise ModelError(f"{len(components)} planetary stages", path="components", allowed=f"at most {_MOST_STAGES}")
    related = view.related.get("stage", ())
    meshes = [(stage, (a, b)) for stage, a, b in related if stage is not None and a is not None and b is not None]
    names = ["main"] if len(components) == 1 else [f"stage{i + 1}" for i in range(len(components))]
    stages = tuple(_stage(view, component.id, name, meshes) for component, name in zip(components, names, strict=True))
    planets = {gear for stage in stages for branch in stage.branches for gear in branch.gears}
    planets |= {stage.twins[gear] for stage in stages for gear in planets & stage.twins.keys()}
    for mesh, (a, b) in meshes:
        if not {a, b} & planets:
            view.lose(mesh, "stage", f"gears {a} and {b} are in no planetary stage")
            view.unread[mesh] = (a, b)
    return stages


def _stage(view: View, stage: int, name: str, meshes: _Meshes) -> StageParts:
    """One stage. Raises ModelError as of `planetary_stages`."""
    where = f"component {view.label(stage)}"
    on_shaft = {shaft: view.parts(shaft, *_GEARS) for shaft in view.joined("planet_shaft", stage)}
    if not 1 <= len(on_shaft) <= _MOST_PLANETS or not all(on_shaft.values()):
        counts = {shaft: len(gears) for shaft, gears in on_shaft.items()}
        allowed = f"1 to {_MOST_PLANETS} relations planet_shaft, each shaft with a gear assembled to it"
        raise ModelError("no planets", path=where, given=counts, allowed=allowed)
    planet_gears = {gear for gears in on_shaft.values() for gear in gears}
    of_stage = [(mesh, pair) for mesh, pair in meshes if planet_gears.intersection(pair)]
    for _, pair in of_stage:
        if planet_gears.issuperset(pair):
            raise ModelError("planets that mesh with each other are not read", path=where, given=sorted(pair))
    central = list(dict.fromkeys(gear for _, pair in of_stage for gear in pair if gear not in planet_gears))
    if not central:
        allowed = "relations stage with gear_1, gear_2"
        raise ModelError("no gear that meshes with the planets", path=where, allowed=allowed)
    by_shaft = grouped((shaft, gear) for gear in central if (shaft := view.shaft_of(gear)) is not None)
    twins = dict(_twins(view, [*on_shaft.values(), *by_shaft.values()]))
    right = set(twins.values())
    members: dict[str, int] = {}
    for gear in sorted(set(central) - right, key=lambda g: (view.components[g].type, g)):
        kind = "ring" if view.components[gear].type == "ring_gear" else "sun"
        count = sum(member.startswith(kind) for member in members)
        members[f"{kind}{count + 1}" if count else kind] = gear
    suns = {gear for gear in central if view.components[gear].type == "cylindrical_gear"}
    with_sun = {gear for _, pair in of_stage if suns.intersection(pair) for gear in pair}
    branches = [  # the gear that meshes with a sun first
        Branch(shaft, tuple(sorted(set(gears) - right, key=lambda gear: (gear not in with_sun, gear))))
        for shaft, gears in on_shaft.items()
    ]
    teeth = [[view.value(gear, "number_of_teeth") for gear in branch.gears] for branch in branches]
    if any(one != teeth[0] for one in teeth):
        raise ModelError("planets that differ in their teeth", path=where, given=teeth, allowed="equal planets")
    if len(branches[0].gears) > 2:
        raise ModelError("more than two gears on a planet shaft", path=where, given=list(branches[0].gears))
    planets = ("planet", "planet2")[: len(branches[0].gears)]
    carriers = view.parts(stage, "planet_carrier")
    return StageParts(
        id=stage,
        name=name,
        central=members,
        planets=planets,
        branches=tuple(branches),
        carrier=carriers[0] if carriers else None,
        meshes=dict(_pairs(members, planets, branches, of_stage)),
        twins=twins,
    )


def _twins(view: View, groups: Sequence[Sequence[int]]) -> Iterator[tuple[int, int]]:
    """Left gear -> right gear of two on one shaft that are alike but for their hand: halves of a herringbone gear."""
    for group in groups:
        if len(group) != 2:
            continue
        helix = [view.number(gear, HELIX) for gear in group]
        teeth = [view.value(gear, "number_of_teeth") for gear in group]
        if teeth[0] != teeth[1] or helix[0] is None or helix[1] is None or helix[0].si * helix[1].si >= 0:
            continue
        frames = [view.frame(gear) for gear in group]
        if frames[0] is None or frames[1] is None:
            continue
        order = (frames[1].place - frames[0].place) @ frames[0].u >= 0
        yield (group[0], group[1]) if order else (group[1], group[0])


def _pairs(
    members: Mapping[str, int], planets: Sequence[str], branches: Sequence[Branch], meshes: _Meshes
) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Pairs of members that mesh, with the cylindrical stage of each branch where it has one."""
    by_gears = {frozenset(pair): mesh for mesh, pair in meshes}
    for member, gear in members.items():
        for place, planet in enumerate(planets):
            stages = [by_gears.get(frozenset((gear, branch.gears[place]))) for branch in branches]
            of_pair = tuple(stage for stage in stages if stage is not None)
            if of_pair:
                name = f"{planet}-{member}" if member.startswith("ring") else f"{member}-{planet}"
                yield name, of_pair
