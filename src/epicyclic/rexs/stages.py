"""A REXS file asked by what its components are to each other, and its planetary stages.

What was asked of it is kept: the rest is dropped.  Support vectors in nested reference frames become points and axes of
the gear unit.  Of the stages: which gears are sun, planets and ring, and which of them mesh; couplings and bearings
between shafts, plates and the casing, and which parts turn as one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic, NamedTuple, TypeVar

from ..errors import ModelError
from .file import Component, Number, Relation, RexsFile, Value, number_in, number_of, shown

Vector = tuple[float, float, float]
_Index = Mapping[int, Sequence[int]]
_MOST_FRAMES = 50  # references nested deeper than any gear unit: a loop


def along(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return math.fsum(x * y for x, y in zip(a, b, strict=True))


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a: Vector, b: Vector) -> Vector:
    """Difference."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@dataclass(frozen=True, slots=True)
class PartFrame:
    """A place [m] and the axes u, v, w of a component, in the frame of the gear unit."""

    place: Vector
    u: Vector
    v: Vector
    w: Vector

    def turned(self, vector: Vector) -> Vector:
        """A vector given along the axes."""
        u, v, w = self.u, self.v, self.w
        x, y, z = vector
        return (
            x * u[0] + y * v[0] + z * w[0],
            x * u[1] + y * v[1] + z * w[1],
            x * u[2] + y * v[2] + z * w[2],
        )


_UNIT = PartFrame((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


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


@dataclass(slots=True, kw_only=True)
class View:
    """A REXS file with the values of one load case, and the list of what was read, assumed and lost.

    components : by id, attributes of the load case laid over.  types : ids by type, ascending.
    assembled : assembly -> its parts.  assemblies : part -> what it is assembled to.
    references : origin -> referenced.  flanks : gear -> left and right flank.  by_type : relations by their type.
    entries, assumptions, losses : each entry once, in the order of the questions.
    asked : component -> attributes that were asked for.  frames : of components, found when asked.
    unread : stages without planets, which are not read -> their two gears.
    """

    file: RexsFile
    components: Mapping[int, Component]
    types: Mapping[str, Sequence[int]]
    assembled: _Index
    assemblies: _Index
    references: _Index
    flanks: _Index
    by_type: Mapping[str, Sequence[Relation]]
    entries: dict[Entry, None] = field(default_factory=dict)
    assumptions: dict[Entry, None] = field(default_factory=dict)
    losses: dict[Entry, None] = field(default_factory=dict)
    asked: dict[int, dict[str, None]] = field(default_factory=dict)
    frames: dict[int, PartFrame | None] = field(default_factory=dict)
    unread: dict[int, tuple[int, int]] = field(default_factory=dict)

    def of_type(self, *types: str) -> list[Component]:
        """Components of some types, by id."""
        return [self.components[i] for i in sorted(i for kind in types for i in self.types.get(kind, ()))]

    def relations(self, *types: str) -> Iterable[Relation]:
        """Relations of some types, in the order of the file."""
        return (relation for kind in types for relation in self.by_type.get(kind, ()))

    def shafts(self, relation: str, stage: int) -> list[int]:
        """Shafts that relations of a type join to a planetary stage, each once."""
        return list(_index_of(self.relations(relation), "planetary_stage", "shaft").get(stage, ()))

    def parts(self, assembly: int, *types: str) -> list[int]:
        """Parts of an assembly, of some component types or of all."""
        return [p for p in self.assembled.get(assembly, ()) if not types or self.components[p].type in types]

    def shaft_of(self, part: int) -> int | None:
        """Shaft a gear or load is assembled to, None where there is none."""
        return next((a for a in self.assemblies.get(part, ()) if self.components[a].type == "shaft"), None)

    def referenced(self, origin: int) -> list[Component]:
        """What a component refers to: material, tool, flank modification."""
        return [self.components[part] for part in self.references.get(origin, ())]

    def flanks_of(self, gear: int) -> list[Component]:
        """Left and right flank of a gear, those that are given."""
        return [self.components[part] for part in self.flanks.get(gear, ())]

    def number(self, component: int, name: str, kind: str) -> Number | None:
        """A number of a component; None where it is not given. Raises ModelError as of `number_of`."""
        self.asked.setdefault(component, {})[name] = None
        return number_of(self.components[component], name, kind)

    def value(self, component: int, name: str) -> Value:
        """A value of a component as it stands; None where it is not given."""
        self.asked.setdefault(component, {})[name] = None
        attribute = self.components[component].attributes.get(name)
        return None if attribute is None else attribute.value

    def read(self, component: int, attribute: str, path: str, text: object) -> None:
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
        if isinstance(reference, (int, float)) and not isinstance(reference, bool) and int(reference) != component:
            if int(reference) in self.components:
                base = self.frame(int(reference), depth=depth + 1) or _UNIT
        frame = None
        if place is not None:
            u = self._axis(component, "u_axis_vector", (1.0, 0.0, 0.0))
            w = self._axis(component, "w_axis_vector", (0.0, 0.0, 1.0))
            origin, absolute = base.place, base.turned(place)
            axis, third = base.turned(u), base.turned(w)
            centre = (origin[0] + absolute[0], origin[1] + absolute[1], origin[2] + absolute[2])
            frame = PartFrame(centre, axis, cross(third, axis), third)
        self.frames[component] = frame
        return frame

    def on_shaft(self, component: int, shaft: int, coordinate: str) -> Vector | None:
        """Place of what sits on a shaft: its own, else its coordinate along the shaft."""
        frame = self.frame(component)
        if frame is not None:
            return frame.place
        base, distance = self.frame(shaft), self.number(component, coordinate, "length")
        if base is None or distance is None:
            return None if base is None else base.place  # where along the shaft is not said
        (x, y, z), u, length = base.place, base.u, distance.si
        return (x + u[0] * length, y + u[1] * length, z + u[2] * length)

    def gear_place(self, gear: int, shaft: int | None) -> Vector | None:
        """Centre of a gear: its own place, else that on its shaft."""
        if shaft is not None:
            return self.on_shaft(gear, shaft, "u_coordinate_on_shaft")
        frame = self.frame(gear)
        return None if frame is None else frame.place

    def _vector(self, component: int, name: str) -> Vector | None:
        """A vector attribute as lengths in SI; None where it is not given."""
        value = self.value(component, name)
        if value is None:
            return None
        where = f"component {self.label(component)}, {name}"
        shown = list(value) if isinstance(value, tuple) else value
        if not isinstance(value, tuple) or len(value) != 3:
            raise ModelError("not a vector", path=where, given=shown, allowed="an array of three numbers")
        unit = self.components[component].attributes[name].unit
        numbers = []
        for entry in value:
            if entry is None:
                raise ModelError("not a vector", path=where, given=shown, allowed="an array of three numbers")
            numbers.append(number_in(entry, unit, "length", where).si)
        return (numbers[0], numbers[1], numbers[2])

    def _axis(self, component: int, name: str, default: Vector) -> Vector:
        """A direction of length 1; its unit means nothing."""
        vector = self._vector(component, name)
        if vector is None:
            return default
        size = math.sqrt(along(vector, vector))
        if not size > 1e-30:
            raise ModelError("a direction of length 0", path=f"component {self.label(component)}, {name}")
        return (vector[0] / size, vector[1] / size, vector[2] / size)


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
        for over in case.components:
            if (base := components.get(over.id)) is not None:
                components[over.id] = replace(base, attributes={**base.attributes, **over.attributes})
    types: dict[str, list[int]] = {}
    for number in sorted(components):
        types.setdefault(components[number].type, []).append(number)
    by_type: dict[str, list[Relation]] = {}
    for relation in file.relations:
        by_type.setdefault(relation.type, []).append(relation)
    assemblies = [*by_type.get("assembly", ()), *by_type.get("ordered_assembly", ())]
    references = [*by_type.get("reference", ()), *by_type.get("ordered_reference", ())]
    flanks: dict[int, list[int]] = {}
    for relation in by_type.get("flank", ()):
        gear, sides = relation.part("gear"), (relation.part("left"), relation.part("right"))
        if gear is not None:
            flanks.setdefault(gear, [side for side in sides if side is not None])
    return View(
        file=file,
        components=components,
        types=types,
        assembled=_index_of(assemblies, "assembly", "part"),
        assemblies=_index_of(assemblies, "part", "assembly"),
        references=_index_of(references, "origin", "referenced"),
        flanks=flanks,
        by_type=by_type,
    )


def _index_of(relations: Iterable[Relation], key: str, value: str) -> _Index:
    """Components in one role by that in another, each once."""
    index: dict[int, dict[int, None]] = {}
    for relation in relations:
        a, b = relation.part(key), relation.part(value)
        if a is not None and b is not None:
            index.setdefault(a, {})[b] = None
    return {a: tuple(parts) for a, parts in index.items()}


# joints ---------------------------------------------------------------------------------------------------------------

# Stiffness from which on a joint is rigid: "rigid" of the programs is 1e20 N/m and more, real joints stay below 1e13.
RIGID = 1e16
_BEARINGS = (
    "concept_bearing",
    "rolling_bearing_with_catalog_geometry",
    "rolling_bearing_with_detailed_geometry",
    "slide_bearing",
    "hydrodynamic_radial_plain_bearing",
)
_KINDS = {
    "radial_stiffness": "stiffness",
    "axial_stiffness": "stiffness",
    "bending_stiffness": "torsional_stiffness",
    "rotational_stiffness": "torsional_stiffness",
}


@dataclass(frozen=True, slots=True)
class Joint:
    """A bearing or coupling between two parts.

    id : of its component.  inner, outer : ids of the parts.  bearing : turns freely about its axis.
    radial, axial, tilt, turn : stiffness, None where not given; infinite where rigid, 0 where it holds nothing.
    """

    id: int
    inner: int
    outer: int
    bearing: bool
    radial: Number | None
    axial: Number | None
    tilt: Number | None
    turn: Number | None

    @property
    def rigid(self) -> bool:
        """Whether it lets nothing move."""
        stiffnesses = (self.radial, self.axial, self.tilt, self.turn)
        return not self.bearing and all(number is None or number.si >= RIGID for number in stiffnesses)

    @property
    def holds_turn(self) -> bool:
        """Whether a torque passes through it."""
        return not self.bearing and (self.turn is None or self.turn.si > 0)


def joints_of(view: View) -> list[Joint]:
    """Bearings and couplings of a file, engaged ones, by id. Raises ModelError for a stiffness without its unit."""
    joints = []
    for relation in view.relations("side", "coupling", "connection"):
        joint, inner, outer = relation.part("assembly"), relation.part("inner_part"), relation.part("outer_part")
        if joint is None or inner is None or outer is None:
            sides = [part for role, part in relation.refs if role not in ("assembly", "coupling", "connection")]
            joint = joint if joint is not None else relation.part("coupling") or relation.part("connection")
            if joint is None:
                continue
            if len(sides) != 2:
                view.lose(joint, "side", "not between two parts")
                continue
            inner, outer = sides
        if _engaged(view, view.components[joint]):
            joints.append(_joint(view, view.components[joint], inner, outer))
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


def _joint(view: View, component: Component, inner: int, outer: int) -> Joint:
    """A joint with its stiffnesses; what a bearing does not take up is 0."""
    bearing = component.type in _BEARINGS
    radial, axial, tilt, turn = (view.number(component.id, name, kind) for name, kind in _KINDS.items())
    if bearing:
        if radial is None:
            radial = _at_operating_point(view, component)
        if view.value(component.id, "radial_force_absorption") is False:
            radial = Number(0.0, "0")
        absorbed = view.value(component.id, "axial_force_absorption")
        if absorbed == "no_direction":
            axial = Number(0.0, "0")
        elif isinstance(absorbed, str) and absorbed != "both_directions" and (axial is None or axial.si > 0):
            reason = f"{absorbed}: holds in both directions"
            view.assume(component.id, "axial_force_absorption", "", reason)
    return Joint(component.id, inner, outer, bearing, radial, axial, tilt, turn)


def _at_operating_point(view: View, component: Component) -> Number | None:
    """Radial stiffness of a bearing from that at its operating point: the mean of both directions."""
    names = [f"operating_point_stiffness_f_{axis}_d_{axis}" for axis in ("v", "w")]
    both = [view.number(component.id, name, "stiffness") for name in names]
    stiffnesses = [number.si for number in both if number is not None]
    if not stiffnesses:
        return None
    mean = sum(stiffnesses) / len(stiffnesses)
    view.assume(component.id, "operating_point_stiffness", "", "mean of both radial directions, without cross terms")
    return Number(mean, f"{shown(mean)} N/m")


Id = TypeVar("Id", int, str)


@dataclass(slots=True)
class Parts(Generic[Id]):
    """Which parts are one: a union of sets of ids, or of names."""

    _above: dict[Id, Id] = field(default_factory=dict)

    def root(self, part: Id) -> Id:
        """The part that stands for all that are one with this."""
        path = []
        while (above := self._above.get(part, part)) != part:
            path.append(part)
            part = above
        for passed in path:
            self._above[passed] = part
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
            parts.join([joint.inner, joint.outer])
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
    central : member -> gear (the left one of a herringbone gear).  kinds : member -> sun, ring or planet.
    planets : members of a branch.  branches : in the order of the file.  carrier : of a planet_carrier, or None.
    meshes : pair of members -> cylindrical stages of the branches, in their order.
    twins : gear -> the gear of opposite hand beside it, of herringbone gears.
    """

    id: int
    name: str
    central: Mapping[str, int]
    kinds: Mapping[str, str]
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


class _Mesh(NamedTuple):
    """A cylindrical stage with its two gears."""

    stage: int
    a: int
    b: int


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
    meshes = []
    for relation in view.relations("stage"):
        stage, a, b = (relation.part(role) for role in ("stage", "gear_1", "gear_2"))
        if stage is not None and a is not None and b is not None:
            meshes.append(_Mesh(stage, a, b))
    names = ["main"] if len(components) == 1 else [f"stage{i + 1}" for i in range(len(components))]
    stages = tuple(_stage(view, component.id, name, meshes) for component, name in zip(components, names, strict=True))
    planets = {gear for stage in stages for branch in stage.branches for gear in branch.gears}
    planets |= {stage.twins[gear] for stage in stages for gear in planets & stage.twins.keys()}
    for mesh in meshes:
        if not {mesh.a, mesh.b} & planets:
            view.lose(mesh.stage, "stage", f"gears {mesh.a} and {mesh.b} are in no planetary stage")
            view.unread[mesh.stage] = (mesh.a, mesh.b)
    return stages


def _stage(view: View, stage: int, name: str, meshes: Sequence[_Mesh]) -> StageParts:
    """One stage. Raises ModelError as of `planetary_stages`."""
    where = f"component {view.label(stage)}"
    on_shaft = {shaft: view.parts(shaft, *_GEARS) for shaft in view.shafts("planet_shaft", stage)}
    if not 1 <= len(on_shaft) <= _MOST_PLANETS or not all(on_shaft.values()):
        counts = {shaft: len(gears) for shaft, gears in on_shaft.items()}
        allowed = f"1 to {_MOST_PLANETS} relations planet_shaft, each shaft with a gear assembled to it"
        raise ModelError("no planets", path=where, given=counts, allowed=allowed)
    planet_gears = {gear for gears in on_shaft.values() for gear in gears}
    of_stage = [mesh for mesh in meshes if {mesh.a, mesh.b} & planet_gears]
    for mesh in of_stage:
        if {mesh.a, mesh.b} <= planet_gears:
            pair = sorted((mesh.a, mesh.b))
            raise ModelError("planets that mesh with each other are not read", path=where, given=pair)
    central = list(dict.fromkeys(gear for m in of_stage for gear in (m.a, m.b) if gear not in planet_gears))
    if not central:
        allowed = "relations stage with gear_1, gear_2"
        raise ModelError("no gear that meshes with the planets", path=where, allowed=allowed)
    by_shaft: dict[int | None, list[int]] = {}
    for gear in central:
        by_shaft.setdefault(view.shaft_of(gear), []).append(gear)
    by_shaft.pop(None, None)
    twins = _twins(view, [*on_shaft.values(), *by_shaft.values()])
    right = set(twins.values())
    members: dict[str, int] = {}
    kinds: dict[str, str] = {}
    for gear in sorted(set(central) - right, key=lambda g: (view.components[g].type, g)):
        kind = "ring" if view.components[gear].type == "ring_gear" else "sun"
        count = sum(one == kind for one in kinds.values())
        member = f"{kind}{count + 1}" if count else kind
        members[member], kinds[member] = gear, kind
    suns = {gear for gear in central if view.components[gear].type == "cylindrical_gear"}
    with_sun = {gear for mesh in of_stage if {mesh.a, mesh.b} & suns for gear in (mesh.a, mesh.b)}
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
        kinds=kinds | dict.fromkeys(planets, "planet"),
        planets=planets,
        branches=tuple(branches),
        carrier=carriers[0] if carriers else None,
        meshes=_pairs(members, planets, branches, of_stage),
        twins=twins,
    )


def _twins(view: View, groups: Sequence[Sequence[int]]) -> dict[int, int]:
    """Left gear -> right gear of two on one shaft that are alike but for their hand: halves of a herringbone gear."""
    twins = {}
    for group in groups:
        if len(group) != 2:
            continue
        helix = [view.number(gear, "helix_angle_reference_diameter", "angle") for gear in group]
        teeth = [view.value(gear, "number_of_teeth") for gear in group]
        if teeth[0] != teeth[1] or helix[0] is None or helix[1] is None or helix[0].si * helix[1].si >= 0:
            continue
        frames = [view.frame(gear) for gear in group]
        if frames[0] is None or frames[1] is None:
            continue
        order = along(minus(frames[1].place, frames[0].place), frames[0].u) >= 0
        left, right = group if order else (group[1], group[0])
        twins[left] = right
    return twins


def _pairs(
    members: Mapping[str, int], planets: Sequence[str], branches: Sequence[Branch], meshes: Sequence[_Mesh]
) -> dict[str, tuple[int, ...]]:
    """Pairs of members that mesh, with the cylindrical stage of each branch where it has one."""
    by_gears = {frozenset((mesh.a, mesh.b)): mesh.stage for mesh in meshes}
    pairs: dict[str, tuple[int, ...]] = {}
    for member, gear in members.items():
        for place, planet in enumerate(planets):
            stages = [by_gears.get(frozenset((gear, branch.gears[place]))) for branch in branches]
            of_pair = tuple(stage for stage in stages if stage is not None)
            if of_pair:
                name = f"{planet}-{member}" if member.startswith("ring") else f"{member}-{planet}"
                pairs[name] = of_pair
    return pairs
