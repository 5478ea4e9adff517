"""A stage of the document: members, pairs that mesh, chains, axes, branch angles; keys they inherit, their material.

Keys are inherited: a side's own, else of its member or mesh, else of the stage, else of the file.  Every key that may
stand at several levels of the file is read through this module.  So is the material of a gear or coupling; what no
level states is that of steel.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from operator import add
from typing import Any, Literal, NamedTuple

from ..document.schema import SIDES, MemberTable, MeshTable, ModelFile, StageTable, implied_pairs
from ..document.tables import key_path
from ..errors import ModelError
from ..teeth.mesh_stiffness import STEEL_MODULUS
from .kinematics import merged, spread
from .train import Number, ResolutionLog, turns_of

LevelName = Literal["side", "member", "mesh", "stage", "file"]


class Level(NamedTuple):
    """A table that may state a key: which level of the file it is, its path, and the table, None where it is absent."""

    name: LevelName
    path: str
    table: object | None


Levels = tuple[Level, ...]  # nearest first


def _levels(name: LevelName, path: str, table: object, side: str | None) -> Levels:
    """A table, and before it that of one of its sides."""
    own = (Level("side", f"{path}.{side}", getattr(table, side, None)),) if side else ()
    return (*own, Level(name, path, table))


class Stated(NamedTuple):
    """A value the file states: the value in SI, the level and the path of its key."""

    value: Any
    level: LevelName
    path: str


def stated(levels: Levels, key: str) -> Stated | None:
    """Value of a key in the nearest table that states it; None where none does."""
    for level in levels:
        value = getattr(level.table, key, None)
        if value is not None:
            return Stated(value, level.name, key_path(level.path, key))
    return None


def stated_value(levels: Levels, key: str, default: Any) -> Any:
    """Value of a key in the nearest table that states it, else `default`."""
    statement = stated(levels, key)
    return default if statement is None else statement.value


def subtables(levels: Levels, key: str) -> Levels:
    """The tables under one key at each level, so that each of their own keys is inherited by itself."""
    return tuple(Level(level.name, key_path(level.path, key), getattr(level.table, key, None)) for level in levels)


def overlaid(levels: Levels, key: str) -> tuple[Any, str]:
    """The tables under one key laid over each other, nearest on top, and the path of the nearest one.

    Without any table None, and the path at the farthest level.
    """
    present = [level for level in subtables(levels, key) if level.table is not None]
    if not present:
        return None, key_path(levels[-1].path, key)
    table: Any = present[-1].table
    for level in reversed(present[:-1]):
        nearer: Any = level.table
        table = table.model_copy(update={name: getattr(nearer, name) for name in nearer.model_fields_set})
    return table, present[0].path


def origin_of(statement: Stated | None) -> str:
    """Origin of an inherited value as `Derived.origin` names it: given, stage or default."""
    if statement is None:
        return "default"
    return "stage" if statement.level == "stage" else "given"


# members, pairs, branches ---------------------------------------------------------------------------------------------

FAR = 10**6


_OF_BODIES = frozenset({"mass", "inertia", "tilt_inertia", "support", "bearing"})


@dataclass(frozen=True, slots=True, kw_only=True)
class GearPair:
    """Two gears of a stage that mesh: `a` nearer the sun along the power path, in a ring mesh the planet gear."""

    name: str
    stage: str
    a: str
    b: str
    internal: bool
    keys: MeshTable

    @property
    def path(self) -> str:
        """Its table in the file."""
        return f"stages.{self.stage}.meshes.{self.name}"

    def levels(self, side: str | None) -> Levels:
        """The tables that may state a key of one side of the mesh, nearest first."""
        return _levels("mesh", self.path, self.keys, side)


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A stage before any number is known.

    gears : toothed members in file order; carrier : its name, None where the axes stand in the housing.
    pairs : in the order of the power path.  chains : number of the chain of meshing gears each gear belongs to.
    axis : gear -> first gear on the same shaft.  branches : 0 without planets.
    angles : polar angle of every branch [turns], one entry (0) without planets.  loaded : torque or power is given.
    """

    name: str
    stage: StageTable
    gears: Mapping[str, MemberTable]
    carrier: str | None
    pairs: tuple[GearPair, ...]
    chains: Mapping[str, int]
    axis: Mapping[str, str]
    branches: int
    angles: tuple[Number, ...]
    loaded: bool

    @property
    def path(self) -> str:
        """Its table in the file."""
        return f"stages.{self.name}"

    def member_path(self, member: str) -> str:
        """A member's table in the file."""
        return f"stages.{self.name}.{member}"

    @cached_property
    def _tables(self) -> Mapping[tuple[str, str | None], Levels]:
        """Tables of every member and side with that of the stage: each key of a member asks for them."""
        stage = Level("stage", self.path, self.stage)
        return {
            (member, side): (*_levels("member", self.member_path(member), table, side), stage)
            for member, table in self.stage.members.items()
            for side in (None, *SIDES)
        }

    def member_levels(self, member: str, side: str | None = None) -> Levels:
        """The tables of a side and of its member, nearest first."""
        return self._tables[member, side][:-1]

    def levels(self, member: str, side: str | None = None) -> Levels:
        """The tables that may state a key of a member, or of a side of it, nearest first."""
        return self._tables[member, side]

    def central(self, member: str) -> bool:
        """Whether there is one of it for all branches."""
        return self.stage.members[member].kind != "planet"

    def branches_of(self, pair: GearPair) -> int:
        """Number of meshes of a pair on one side: one for each planet, one alone of two central gears."""
        return 1 if self.central(pair.a) and self.central(pair.b) else len(self.angles)

    def two_sided(self, member: str) -> bool:
        """Whether it has a left and a right half, in one body or two."""
        return self.split(member) or self.herringbone(member)

    def split(self, member: str) -> bool:
        """Whether its halves are bodies of their own."""
        return self.stage.members[member].neck is not None or bool(stated_value(self.levels(member), "split", False))

    def herringbone(self, member: str) -> bool:
        """Whether it carries two helices."""
        return bool(stated_value(self.levels(member), "herringbone", False))


def sides_of(plan: Plan, member: str) -> tuple[str | None, ...]:
    """Sides that are bodies of their own: left and right, or None."""
    return SIDES if plan.split(member) else (None,)


def gear_below(member: MemberTable) -> str | None:
    """Gear on whose shaft a gear sits, by its name in the stage; None for a gear on its own axis."""
    return None if member.on is None else member.on.split(".")[-1]


def plan_stages(model: ModelFile, log: ResolutionLog) -> tuple[Plan, ...]:
    """Plan every stage.

    Raises
    ------
    ModelError : two carriers, shafts in a circle, meshes to be named, a gear that meshes with nothing.
    """
    loaded = any(value != 0 for value in (*model.operation.torque.values(), *model.operation.power.values()))
    return tuple(_plan(name, stage, loaded, log) for name, stage in model.stages.items())


def _plan(name: str, stage: StageTable, loaded: bool, log: ResolutionLog) -> Plan:
    """Plan of one stage. Raises ModelError for what `plan_stages` names."""
    path = f"stages.{name}"
    carriers = [m for m, member in stage.members.items() if member.kind == "carrier"]
    gears = {m: member for m, member in stage.members.items() if member.kind != "carrier"}
    if len(carriers) > 1:
        raise ModelError(
            "a stage has one carrier", path=path, given=carriers, allowed="one; split = true for its halves"
        )
    for m, member in gears.items():
        below = gear_below(member)
        if below is not None and (gears[below].kind == "planet") != (member.kind == "planet"):
            raise ModelError("a planet gear and a central gear on one shaft", path=f"{path}.{m}.on", given=member.on)
        log.note(f"{path}.{m}.teeth", member.teeth)
    axis = {m: _shaft_root(m, gears) for m in gears}
    pairs = _pairs(name, stage, gears)
    branches, angles = _branches(path, stage, gears, log)
    plan = Plan(
        name=name,
        stage=stage,
        gears=gears,
        carrier=carriers[0] if carriers else None,
        pairs=_ordered(pairs, gears, axis),
        chains=_chains(pairs, gears, path),
        axis=axis,
        branches=branches,
        angles=angles,
        loaded=loaded,
    )
    _check_sides(plan)
    return plan


def _check_sides(plan: Plan) -> None:
    """Raise ModelError for a side of a gear that has none, and for what a half has that is no body of its own."""
    for name, member in plan.stage.members.items():
        for side in SIDES:
            path, given = f"{plan.member_path(name)}.{side}", getattr(member, side)
            if given is None or plan.split(name) or not given.model_fields_set:
                continue
            if not plan.two_sided(name):
                raise ModelError("is a side of a member in one piece", path=path, allowed="the member, or split = true")
            for key in sorted(given.model_fields_set & _OF_BODIES):
                raise ModelError(
                    "is of a half, and both helices are one body", path=f"{path}.{key}", allowed="the member, or split"
                )


def _shaft_root(name: str, gears: Mapping[str, MemberTable]) -> str:
    """Gear at the root of the shaft a gear sits on. Raises ModelError for shafts in a circle."""
    seen = [name]
    while (below := gear_below(gears[seen[-1]])) is not None:
        seen.append(below)
        if len(seen) > len(gears):
            raise ModelError("shafts in a circle", path="on", given=seen)
    return seen[-1]


def _branches(
    path: str, stage: StageTable, gears: Mapping[str, MemberTable], log: ResolutionLog
) -> tuple[int, tuple[Number, ...]]:
    """Number of branches, 0 without planets, and their polar angles [turns]. Raises ModelError."""
    if all(member.kind != "planet" for member in gears.values()):
        return 0, (Fraction(0),)
    if stage.planet_angles is None:
        count = stage.branches
        log.note(f"{path}.planets", count)
        log.note(f"{path}.planet_angles", [math.tau * i / count for i in range(count)], "rad", "equal spacing")
        return count, tuple(Fraction(i, count) for i in range(count))
    log.note(f"{path}.planet_angles", list(stage.planet_angles), "rad")
    angles = tuple(turns_of(angle) for angle in stage.planet_angles)
    if len({round(float(angle) % 1, 9) for angle in angles}) < len(angles):
        raise ModelError("two planets at one place", path=f"{path}.planet_angles", given=list(stage.planet_angles))
    return len(angles), angles


def _pairs(stage_name: str, stage: StageTable, gears: Mapping[str, MemberTable]) -> list[GearPair]:
    """The pairs that mesh: named ones, and those that a single planet gear or two fixed gears leave no doubt about."""
    implied = implied_pairs({name: member.kind for name, member in gears.items()})
    tables = {frozenset((a, b)): (f"{a}-{b}", MeshTable()) for a, b in implied}
    tables |= {frozenset(key.split("-")): (key, keys) for key, keys in stage.meshes.items()}
    meshing = [_pair(stage_name, key, keys, gears) for key, keys in tables.values()]
    if not meshing:
        problem = "these gears do not say which of them mesh"
        allowed = "a table with every mesh, e.g. meshes.sun-p, meshes.p-d, meshes.d-ring"
        raise ModelError(problem, path=f"stages.{stage_name}.meshes", given=list(gears), allowed=allowed)
    return meshing


def _pair(stage: str, key: str, keys: MeshTable, gears: Mapping[str, MemberTable]) -> GearPair:
    """Pair of a key `A-B`, in a ring mesh the planet gear first. Raises ModelError."""
    a, b = sorted(key.split("-"), key=lambda name: gears[name].kind == "ring")
    if gears[a].kind == "ring":
        raise ModelError("two rings do not mesh", path=f"stages.{stage}.meshes.{key}", given=key)
    return GearPair(name=key, stage=stage, a=a, b=b, internal=gears[b].kind == "ring", keys=keys)


def _ordered(
    pairs: Sequence[GearPair], gears: Mapping[str, MemberTable], axis: Mapping[str, str]
) -> tuple[GearPair, ...]:
    """Turn every pair so that `a` is nearer the sun, and sort them along the power path."""
    joints = [(p.a, p.b) for p in pairs] + [(g, axis[g]) for g in gears if axis[g] != g]
    suns = [g for g, m in gears.items() if m.kind == "sun"] or [g for g, m in gears.items() if m.kind == "gear"][:1]
    if suns:
        far = _distances(suns, joints)
    else:
        far = {g: -d for g, d in _distances([g for g, m in gears.items() if m.kind == "ring"], joints).items()}
    turned = []
    for p in pairs:
        swap = not p.internal and far.get(p.b, FAR) < far.get(p.a, FAR)
        turned.append(replace(p, a=p.b, b=p.a) if swap else p)
    return tuple(sorted(turned, key=lambda p: (far.get(p.a, FAR), p.internal)))


def _distances(roots: Iterable[str], joints: Sequence[tuple[str, str]]) -> dict[str, int]:
    """Number of joints from the nearest root, by gear."""
    both = [*joints, *((b, a) for a, b in joints)]
    return spread(dict.fromkeys(roots, 0), [(a, b, 1) for a, b in both], add)


def _chains(pairs: Sequence[GearPair], gears: Mapping[str, MemberTable], path: str) -> dict[str, int]:
    """Number of the chain of meshing gears, by gear. Raises ModelError for a gear that meshes with nothing."""
    meshing = {name for p in pairs for name in (p.a, p.b)}
    for name in gears:
        if name not in meshing:
            allowed = f"a mesh in {path}.meshes with one of {', '.join(g for g in gears if g != name)}"
            raise ModelError("meshes with nothing", path=f"{path}.{name}", allowed=allowed)
    return merged({name: i for i, name in enumerate(gears)}, ((p.a, p.b) for p in pairs))


# material -------------------------------------------------------------------------------------------------------------

STEEL_DENSITY = 7850.0  # [kg/m^3]
STEEL_POISSON = 0.3


def file_material(model: ModelFile) -> Levels:
    """The `material` table of the file."""
    return subtables((Level("file", "", model),), "material")


def member_material(plan: Plan, member: str, model: ModelFile) -> Levels:
    """The `material` tables of a member, its stage and the file, nearest first."""
    return (*subtables(plan.levels(member), "material"), *file_material(model))


def density_of(material: Levels) -> float:
    """Density [kg/m^3]."""
    return float(stated_value(material, "density", STEEL_DENSITY))


def elastic_constants(material: Levels) -> tuple[float, float]:
    """Young's modulus [Pa] and Poisson's ratio [1]."""
    modulus = stated_value(material, "youngs_modulus", STEEL_MODULUS)
    return float(modulus), float(stated_value(material, "poisson_ratio", STEEL_POISSON))
