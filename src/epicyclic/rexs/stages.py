"""The planetary stages of a REXS file, and what joins their parts.

Which gears are sun, planets and ring, and which of them mesh; couplings and bearings between shafts, plates and the
casing, and which parts turn as one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from ..errors import ModelError
from .file import Component, Number, shown
from .view import View, along, minus

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
        return not self.bearing and all(
            n is None or n.si >= RIGID for n in (self.radial, self.axial, self.tilt, self.turn)
        )

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
            if joint is None or len(sides) != 2:
                for part in [joint] if joint is not None else []:
                    view.lose(part, "side", "not between two parts")
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
    both = [
        view.number(component.id, f"operating_point_stiffness_f_{axis}_d_{axis}", "stiffness") for axis in ("v", "w")
    ]
    stiffnesses = [number.si for number in both if number is not None]
    if not stiffnesses:
        return None
    mean = sum(stiffnesses) / len(stiffnesses)
    view.assume(component.id, "operating_point_stiffness", "", "mean of both radial directions, without cross terms")
    return Number(mean, f"{shown(mean)} N/m")


@dataclass(slots=True)
class Parts:
    """Which parts are one: a union of sets of ids."""

    _above: dict[int, int] = field(default_factory=dict)

    def root(self, part: int) -> int:
        """The part that stands for all that are one with this."""
        path = []
        while (above := self._above.get(part, part)) != part:
            path.append(part)
            part = above
        for passed in path:
            self._above[passed] = part
        return part

    def join(self, parts: Iterable[int]) -> None:
        """Make parts one; the least id stands for them."""
        roots = sorted({self.root(part) for part in parts})
        for root in roots[1:]:
            self._above[root] = roots[0]


def rigid_parts(view: View, joints: Iterable[Joint]) -> Parts:
    """The parts that move as one: what is assembled in a planet carrier, a gear and its shaft, rigid joints."""
    parts = Parts()
    for carrier in view.of_type("planet_carrier"):
        parts.join([carrier.id, *view.parts(carrier.id, "shaft", "side_plate")])
    for shaft in view.of_type("shaft"):
        parts.join([shaft.id, *view.parts(shaft.id, "cylindrical_gear", "ring_gear", "sleeve")])
    for joint in joints:
        if joint.rigid:
            parts.join([joint.inner, joint.outer])
    return parts


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
