"""The planetary stages of a REXS file: which gears are sun, planets and ring, and which of them mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..errors import ModelError
from .places import Places, along, minus
from .view import View

__all__ = ["Branch", "StageParts", "planetary_stages"]

_GEARS = ("cylindrical_gear", "ring_gear")
_MOST_PLANETS = 100  # as many as a model file may have
_MOST_STAGES = 50
_MOST_CENTRAL = 10  # central gears of a stage: more than two suns and two rings, each in two halves


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


@dataclass(frozen=True, slots=True)
class _Mesh:
    """A cylindrical stage with its two gears."""

    stage: int
    a: int
    b: int


def planetary_stages(view: View, places: Places) -> tuple[StageParts, ...]:
    """The planetary stages of a file.

    Raises
    ------
    ModelError : none, one without planets or gears, planets that mesh with each other, planets that differ.
    """
    found = view.of_type("planetary_stage")
    if not found:
        kinds = sorted({c.type for c in view.components.values() if c.type.endswith("_stage")})
        problem = f"no planetary stage (stages in it: {', '.join(kinds) or 'none'})"
        raise ModelError(problem, path="components", allowed="a gear unit with a planetary stage")
    if len(found) > _MOST_STAGES:
        raise ModelError(f"{len(found)} planetary stages", path="components", allowed=f"at most {_MOST_STAGES}")
    meshes = _meshes(view)
    names = ["main"] if len(found) == 1 else [f"stage{i + 1}" for i in range(len(found))]
    stages = tuple(_stage(view, places, one.id, name, meshes) for one, name in zip(found, names, strict=True))
    planets = {gear for stage in stages for branch in stage.branches for gear in branch.gears}
    planets |= {stage.twins[gear] for stage in stages for gear in planets & stage.twins.keys()}
    for mesh in meshes:
        if not {mesh.a, mesh.b} & planets:
            view.lose(mesh.stage, "stage", f"gears {mesh.a} and {mesh.b} are in no planetary stage")
            view.unread[mesh.stage] = (mesh.a, mesh.b)
    return stages


def _meshes(view: View) -> list[_Mesh]:
    """All pairs of gears that mesh."""
    found = []
    for relation in view.relations("stage"):
        parts = [relation.part(role) for role in ("stage", "gear_1", "gear_2")]
        if all(part is not None and part in view.components for part in parts):
            stage, a, b = (int(part) for part in parts if part is not None)
            found.append(_Mesh(stage, a, b))
    return found


def _stage(view: View, places: Places, stage: int, name: str, meshes: Sequence[_Mesh]) -> StageParts:
    """One stage. Raises ModelError as of `planetary_stages`."""
    where = f"component {view.label(stage)}"
    shafts = [
        shaft
        for relation in view.relations("planet_shaft")
        if relation.part("planetary_stage") == stage and (shaft := relation.part("shaft")) is not None
    ]
    shafts = list(dict.fromkeys(shafts))
    on_shaft = {shaft: view.parts(shaft, *_GEARS) for shaft in shafts}
    if not shafts or any(not gears for gears in on_shaft.values()) or len(shafts) > _MOST_PLANETS:
        given = {shaft: len(gears) for shaft, gears in on_shaft.items()}
        allowed = f"1 to {_MOST_PLANETS} relations planet_shaft, each shaft with a gear assembled to it"
        raise ModelError("no planets", path=where, given=given, allowed=allowed)
    planet_gears = {gear for gears in on_shaft.values() for gear in gears}
    own = [mesh for mesh in meshes if {mesh.a, mesh.b} & planet_gears]
    if any({mesh.a, mesh.b} <= planet_gears for mesh in own):
        pair = next(sorted((m.a, m.b)) for m in own if {m.a, m.b} <= planet_gears)
        raise ModelError("planets that mesh with each other are not read", path=where, given=pair)
    central = list(dict.fromkeys(gear for m in own for gear in (m.a, m.b) if gear not in planet_gears))
    if not central:
        raise ModelError(
            "no gear that meshes with the planets", path=where, allowed="relations stage with gear_1, gear_2"
        )
    twins = _twins(view, places, [*on_shaft.values(), *_on_one_shaft(view, central)])
    central = [gear for gear in central if gear not in twins.values()]
    kinds: dict[str, str] = {}
    members = {_named(view, gear, kinds): gear for gear in sorted(central, key=lambda g: (view.components[g].type, g))}
    branches = [
        _branch(view, shaft, [g for g in gears if g not in twins.values()], own) for shaft, gears in on_shaft.items()
    ]
    _check_alike(view, branches, where)
    planets = tuple("planet" if i == 0 else f"planet{i + 1}" for i in range(len(branches[0].gears)))
    kinds |= dict.fromkeys(planets, "planet")
    carriers = view.parts(stage, "planet_carrier")
    return StageParts(
        id=stage,
        name=name,
        central=members,
        kinds=kinds,
        planets=planets,
        branches=tuple(branches),
        carrier=carriers[0] if carriers else None,
        meshes=_pairs(members, planets, branches, own),
        twins=twins,
    )


def _named(view: View, gear: int, kinds: dict[str, str]) -> str:
    """Name of a central gear, noted with its kind."""
    kind = "ring" if view.components[gear].type == "ring_gear" else "sun"
    count = sum(one == kind for one in kinds.values())
    name = kind if not count else f"{kind}{count + 1}"
    kinds[name] = kind
    return name


def _on_one_shaft(view: View, gears: Sequence[int]) -> list[list[int]]:
    """Central gears by the shaft they are assembled to."""
    shafts: dict[int | None, list[int]] = {}
    for gear in gears:
        shafts.setdefault(view.shaft_of(gear), []).append(gear)
    return [found for shaft, found in shafts.items() if shaft is not None]


def _twins(view: View, places: Places, groups: Sequence[Sequence[int]]) -> dict[int, int]:
    """Left gear -> right gear of two on one shaft that are alike but for their hand: halves of a herringbone gear."""
    found = {}
    for group in groups:
        if len(group) != 2:
            continue
        helix = [view.number(gear, "helix_angle_reference_diameter", "angle") for gear in group]
        teeth = [view.value(gear, "number_of_teeth") for gear in group]
        if teeth[0] != teeth[1] or helix[0] is None or helix[1] is None or helix[0].si * helix[1].si >= 0:
            continue
        frames = [places.frame(gear) for gear in group]
        if frames[0] is None or frames[1] is None:
            continue
        order = along(minus(frames[1].place, frames[0].place), frames[0].u) >= 0
        left, right = group if order else (group[1], group[0])
        found[left] = right
    return found


def _branch(view: View, shaft: int, gears: Sequence[int], meshes: Sequence[_Mesh]) -> Branch:
    """A branch with its gears, the one that meshes with a sun first."""

    def with_sun(gear: int) -> bool:
        mates = {m.b if m.a == gear else m.a for m in meshes if gear in (m.a, m.b)}
        return any(view.components[mate].type == "cylindrical_gear" for mate in mates)

    return Branch(shaft, tuple(sorted(gears, key=lambda gear: (not with_sun(gear), gear))))


def _check_alike(view: View, branches: Sequence[Branch], where: str) -> None:
    """Raise ModelError where the planets of a stage differ in gears or teeth."""
    teeth = [[view.value(gear, "number_of_teeth") for gear in branch.gears] for branch in branches]
    if any(one != teeth[0] for one in teeth):
        raise ModelError("planets that differ in their teeth", path=where, given=teeth, allowed="equal planets")
    if len(branches[0].gears) > 2:
        raise ModelError("more than two gears on a planet shaft", path=where, given=list(branches[0].gears))


def _pairs(
    members: Mapping[str, int], planets: Sequence[str], branches: Sequence[Branch], meshes: Sequence[_Mesh]
) -> dict[str, tuple[int, ...]]:
    """Pairs of members that mesh, with the cylindrical stage of each branch where it has one."""
    by_gears = {frozenset((mesh.a, mesh.b)): mesh.stage for mesh in meshes}
    found: dict[str, tuple[int, ...]] = {}
    for member, gear in members.items():
        for place, planet in enumerate(planets):
            stages = [by_gears.get(frozenset((gear, branch.gears[place]))) for branch in branches]
            given = tuple(stage for stage in stages if stage is not None)
            if given:
                name = f"{planet}-{member}" if member.startswith("ring") else f"{member}-{planet}"
                found[name] = given
    return found
