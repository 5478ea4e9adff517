"""Mesh phases of a stage: leads, assembly condition, nearest buildable angles, hunting period, clearance of neighbours.

A stage is given by its gears and, in the order of the power path, its meshes.  At time zero the first mesh of branch 1
is in contact at its pitch point.  Branch 1 determines the tooth phases of the central gears; in the other branches
every mesh with a central gear follows that gear, and so has its own phase even where the branch cannot be assembled.
Leads agree with the published relations [parker2004] up to the sign of docs/conventions.md, Phases.

    gears = (ToothedGear(name="sun", teeth=23, central=True), ToothedGear(name="planet", teeth=17),
             ToothedGear(name="ring", teeth=57, central=True, internal=True))
    angles = (Fraction(0), Fraction(1, 3), Fraction(2, 3))                       # turns
    meshes = (ToothMesh(pair="sun-planet", a="sun", b="planet", directions=angles, flank=1),
              ToothMesh(pair="planet-ring", a="planet", b="ring", directions=angles, flank=-1))
    phases = stage_leads(gears, meshes, sense=1)
    phases.lead["sun-planet"]        # (0, 1/3, 2/3)
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..gears.phasing import Angle, Phase, contact_of_mate, contact_place, driver_tooth, mate_tooth, shift_term

__all__ = [
    "StagePhases",
    "ToothMesh",
    "ToothedGear",
    "chain_flanks",
    "disc_gaps",
    "flank_of_torque",
    "stage_leads",
    "staggered",
]

Number = Fraction | float
ASSEMBLY_TOLERANCE = 1e-3  # [pitches] angles given with a few decimals count as buildable: far below any backlash


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothedGear:
    """One gear of a stage, as data of its phases.

    name : unique in the stage.  teeth : positive.  internal : a ring.
    central : one for all branches; else there is one in each branch.
    profile_shift : coefficient [1], positive lengthens the addendum, of a ring too.
    on : the gear of the same branch whose shaft it sits on.
    clocking : angle from a tooth centre of that gear to a tooth centre of this one, one per branch [turns];
        None = "fit", each shaft clocked as its place demands (then it always assembles).
    """

    name: str
    teeth: int
    internal: bool = False
    central: bool = False
    profile_shift: float = 0.0
    on: str | None = None
    clocking: tuple[Angle, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothMesh:
    """One pair of gears, in every branch.

    pair : its name.  a, b : names of gears, `a` nearer the sun along the power path, in a ring mesh the planet gear.
    directions : polar angle of e (from the centre of a to the pitch point), one per branch [turns]; Fractions stay
        exact, a `Phase` keeps an irrational part apart (the angle by which a second planet gear stands ahead).
    flank : d, +1 where a's teeth push b along z cross e, else -1.
    normal_angle, transverse_angle : pressure angles of the tool [rad]; working_angle : transverse, of this mesh [rad].
        Only profile shift and a working angle that differs from the transverse one make them matter.
    """

    pair: str
    a: str
    b: str
    directions: tuple[Angle, ...]
    flank: int
    normal_angle: float = 0.0
    transverse_angle: float = 0.0
    working_angle: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StagePhases:
    """Mesh phases of a stage.

    lead : gamma of every pair, one per branch, in [0, 1) [mesh cycles], Fraction where rational.
    sense : D of every pair; place of the contact sigma(t) = D (f t + gamma).
    mismatch : of the teeth of each branch, in [-1/2, 1/2) [pitches], the largest of its loops; exact where rational.
    assembles : no mismatch exceeds the tolerance.
    step : buildable angles from branch 1 are its multiples [turns]; None = any angle can be built.
    nearest_angles : buildable angle of each branch (of its first mesh) nearest to the given one, branch 1 kept [turns].
    hunting_period : cycles of the first mesh after which every gear repeats its position relative to the carrier.
    clocking : of every planet gear on the shaft of another, least angle between tooth centres of the two [turns].
    """

    lead: Mapping[str, tuple[Number, ...]]
    sense: Mapping[str, int]
    mismatch: tuple[Number, ...]
    assembles: bool
    step: Fraction | None
    nearest_angles: tuple[Number, ...]
    hunting_period: int
    clocking: Mapping[str, tuple[Number, ...]]


def flank_of_torque(torque_on_b: float, *, internal: bool) -> int:
    """Flank d of a mesh from the torque [N m] its teeth put on b: the mean mesh force is positive (+1 for 0)."""
    along = torque_on_b if internal else -torque_on_b
    return -1 if along < 0 else 1


def chain_flanks(gears: Sequence[ToothedGear], meshes: Sequence[tuple[str, str]], first: int) -> tuple[int, ...]:
    """Flank d of every mesh (a, b) of a chain without torques, from that of its first mesh.

    Along a branch d alternates at every external gear (docs/conventions.md, The mesh row).

    Raises
    ------
    ModelError : a mesh without a gear in common with those before it.
    """
    return tuple(_senses(gears, meshes, first))


def stage_leads(
    gears: Sequence[ToothedGear], meshes: Sequence[ToothMesh], *, sense: int, tolerance: float = ASSEMBLY_TOLERANCE
) -> StagePhases:
    """Phase leads of all meshes of a stage, and whether its branches can be assembled.

    sense : g, sign of the speed of gear a of the first mesh (the sun) relative to the carrier; +1 where not known.
    tolerance : largest mismatch that can be assembled [pitches].

    Raises
    ------
    ModelError : meshes that name no gear, differ in their number of branches, or are not connected.
    """
    table = _checked(gears, meshes)
    count = len(meshes[0].directions)
    senses = _senses(gears, [(m.a, m.b) for m in meshes], sense)
    drives = {m.pair: m.flank * s for m, s in zip(meshes, senses, strict=True)}
    branches = [_branch_phases(table, meshes, 0, {})]
    anchors = {m.pair: branches[0].place[m.pair] for m in meshes if table[m.a].central or table[m.b].central}
    branches += [_branch_phases(table, meshes, i, anchors) for i in range(1, count)]
    mismatch = tuple(_largest_mismatch(phases.mismatches) for phases in branches)
    step = _buildable_step(
        _branch_phases(table, meshes, 0, anchors).mismatches,
        _branch_phases(table, meshes, 0, anchors, turns=1).mismatches,
    )
    return StagePhases(
        lead={m.pair: tuple((drives[m.pair] * w.place[m.pair] % 1).value for w in branches) for m in meshes},
        sense=drives,
        mismatch=mismatch,
        assembles=all(abs(float(miss)) <= tolerance for miss in mismatch),
        step=step,
        nearest_angles=tuple(_nearest_buildable(meshes[0], i, step) for i in range(count)),
        hunting_period=_hunting_period(table, meshes),
        clocking={
            g.name: tuple(_fitted_clocking(table, g, w) for w in branches) for g in gears if g.on and not g.central
        },
    )


def staggered(lead: Number, stagger: Number, sense: int) -> Number:
    """Lead of the right half: gamma + g stagger, mod 1 (exact where both are).

    stagger : turn of the right half of every gear in tooth pitches, in the sense it turns when the sun turns ccw.
    """
    return ((Phase.of(lead) + sense * Phase.of(stagger)) % 1).value


def disc_gaps(centres: NDArray[np.float64], tips: NDArray[np.float64]) -> NDArray[np.float64]:
    """Clearance of the tip circles of every two gears, (n, n) [m], inf on the diagonal; negative where they overlap.

    centres : (n, 2) [m].  tips : (n,) tip radii [m].
    """
    gaps = np.linalg.norm(centres[:, None] - centres[None], axis=-1) - tips[:, None] - tips[None]
    np.fill_diagonal(gaps, np.inf)
    return np.asarray(gaps)


@dataclass(frozen=True, slots=True)
class _BranchPhases:
    """Phases of one branch: places of contact [base pitches], mismatch of each closed loop with its period [pitches],
    and tooth phases of the gears."""

    place: dict[str, Phase]
    mismatches: list[tuple[Phase, Fraction]]
    teeth: dict[str, _ToothPhase]


@dataclass(frozen=True, slots=True)
class _ToothPhase:
    """Tooth phase of a gear modulo `period` [pitches] (below 1 where any tooth of the other gear of a shaft fits)."""

    phase: Phase
    period: Fraction = Fraction(1)


def _branch_phases(
    table: Mapping[str, ToothedGear],
    meshes: Sequence[ToothMesh],
    branch: int,
    anchors: Mapping[str, Phase],
    turns: int = 0,
) -> _BranchPhases:
    """Phases along the meshes of one branch, rotated by whole `turns` (unreduced, which yields their slope).

    anchors : place of the contact in branch 1 of the pairs with a central gear; empty in branch 1 itself.
    """
    phases = _BranchPhases({}, [], {})
    teeth = phases.teeth
    for mesh in meshes:
        direction = Phase.of(mesh.directions[branch]) + turns
        reached = _known_places(table, mesh, direction, teeth)
        if mesh.pair in anchors:
            offset = direction - Phase.of(mesh.directions[0])
            reached.insert(0, _ToothPhase(anchors[mesh.pair] + _place_per_turn(table, mesh) * offset))
        place = reached[0] if reached else _ToothPhase(Phase())
        phases.mismatches.extend((r.phase - place.phase, _common(r.period, place.period)) for r in reached[1:])
        phases.place[mesh.pair] = place.phase
        _set_tooth_phases(table, mesh, direction, place, teeth, centrals=not anchors)
        _carry_along_shafts(table, branch, teeth)
    return phases


def _place_per_turn(table: Mapping[str, ToothedGear], mesh: ToothMesh) -> int:
    """Change of the place per turn of the direction while the central gear stands."""
    if table[mesh.a].central:
        return -mesh.flank * table[mesh.a].teeth
    return mesh.flank * table[mesh.b].teeth * (-1 if table[mesh.b].internal else 1)


def _known_places(
    table: Mapping[str, ToothedGear], mesh: ToothMesh, direction: Phase, teeth: Mapping[str, _ToothPhase]
) -> list[_ToothPhase]:
    """Places of the contact that follow from known tooth phases [base pitches], that of a central gear first."""
    found: list[_ToothPhase] = []
    for gear in sorted((table[mesh.a], table[mesh.b]), key=lambda g: not g.central):
        if gear.name not in teeth:
            continue
        tooth, shift = teeth[gear.name], _shift(mesh, gear)
        if gear.name == mesh.a:
            place = contact_place(tooth.phase, direction, teeth=gear.teeth, flank=mesh.flank, shift=shift)
        else:
            place = contact_of_mate(
                tooth.phase, direction, teeth=gear.teeth, flank=mesh.flank, shift=shift, internal=gear.internal
            )
        found.append(_ToothPhase(place, tooth.period))
    return found


def _set_tooth_phases(
    table: Mapping[str, ToothedGear],
    mesh: ToothMesh,
    direction: Phase,
    place: _ToothPhase,
    teeth: dict[str, _ToothPhase],
    *,
    centrals: bool,
) -> None:
    """Set the tooth phases of both gears of a mesh where they are not known (central gears: in branch 1 only)."""
    a, b = table[mesh.a], table[mesh.b]
    if a.name not in teeth and (centrals or not a.central):
        phase = driver_tooth(place.phase, direction, teeth=a.teeth, flank=mesh.flank, shift=_shift(mesh, a))
        teeth[a.name] = _ToothPhase(phase, place.period)
    if b.name not in teeth and (centrals or not b.central):
        phase = mate_tooth(
            place.phase, direction, teeth=b.teeth, flank=mesh.flank, shift=_shift(mesh, b), internal=b.internal
        )
        teeth[b.name] = _ToothPhase(phase, place.period)


def _carry_along_shafts(table: Mapping[str, ToothedGear], branch: int, teeth: dict[str, _ToothPhase]) -> None:
    """Set the tooth phases of gears on shafts whose clocking is given."""
    for gear in table.values():
        if gear.on is None or gear.clocking is None:
            continue
        other, angle = table[gear.on], Phase.of(gear.clocking[branch])
        if other.name in teeth and gear.name not in teeth:
            known, scale = teeth[other.name], Fraction(gear.teeth, other.teeth)
            teeth[gear.name] = _ToothPhase(
                scale * known.phase + gear.teeth * angle, _common(scale * known.period, Fraction(1))
            )
        elif gear.name in teeth and other.name not in teeth:
            known, scale = teeth[gear.name], Fraction(other.teeth, gear.teeth)
            teeth[other.name] = _ToothPhase(
                scale * known.phase - other.teeth * angle, _common(scale * known.period, Fraction(1))
            )


def _fitted_clocking(table: Mapping[str, ToothedGear], gear: ToothedGear, phases: _BranchPhases) -> Number:
    """Least angle between tooth centres of a gear and of the gear on whose shaft it sits [turns]."""
    other = table[gear.on or ""]
    per_tooth = Fraction(1, gear.teeth), Fraction(1, other.teeth)
    angle = per_tooth[0] * phases.teeth[gear.name].phase - per_tooth[1] * phases.teeth[other.name].phase
    return (angle % _common(*per_tooth)).value


def _shift(mesh: ToothMesh, gear: ToothedGear) -> float:
    return shift_term(
        teeth=gear.teeth,
        profile_shift=gear.profile_shift,
        normal_angle=mesh.normal_angle,
        transverse_angle=mesh.transverse_angle,
        working_angle=mesh.working_angle,
        internal=gear.internal,
    )


def _largest_mismatch(mismatches: Sequence[tuple[Phase, Fraction]]) -> Number:
    values: list[Number] = [miss.nearest(period).value for miss, period in mismatches]
    return max(values, key=lambda value: abs(float(value)), default=Fraction(0))


def _buildable_step(
    here: Sequence[tuple[Phase, Fraction]], turned: Sequence[tuple[Phase, Fraction]]
) -> Fraction | None:
    """Least angle by which a branch that assembles can be moved and assembled again [turns], None = any."""
    step: Fraction | None = None
    for (miss, period), (moved, _) in zip(here, turned, strict=True):
        slope = abs((moved - miss).exact)
        if slope:
            one = period / slope
            step = one if step is None else _multiple(step, one)
    return step


def _nearest_buildable(mesh: ToothMesh, branch: int, step: Fraction | None) -> Number:
    """Buildable angle nearest to the given one [turns]; of two equally near the smaller: opposite planets stay so."""
    first, given = Phase.of(mesh.directions[0]), Phase.of(mesh.directions[branch])
    if step is None:
        return given.value
    between = (given - first).value
    return (first + math.ceil(between / step - Fraction(1, 2)) * step).value


def _hunting_period(table: Mapping[str, ToothedGear], meshes: Sequence[ToothMesh]) -> int:
    turns = {meshes[0].a: Fraction(1, table[meshes[0].a].teeth)}  # of each gear per cycle of the first mesh
    for a, b, ratio in _edges(table, [(m.a, m.b) for m in meshes]):
        turns.setdefault(b, turns[a] * abs(ratio))
    return math.lcm(*(turn.denominator for turn in turns.values()))


def _senses(gears: Sequence[ToothedGear], pairs: Sequence[tuple[str, str]], first: int) -> list[int]:
    """Sense of gear a of every pair, from that of the first one: external gears alternate, shafts and rings keep it."""
    table = {gear.name: gear for gear in gears}
    sense = {pairs[0][0]: first}
    for a, b, ratio in _edges(table, pairs):
        sense.setdefault(b, sense[a] if ratio > 0 else -sense[a])
    return [sense[a] for a, _ in pairs]


def _edges(table: Mapping[str, ToothedGear], pairs: Sequence[tuple[str, str]]) -> list[tuple[str, str, Fraction]]:
    """(known gear, new gear, speed ratio) in an order that starts at the first gear and reaches all of them."""
    joints = [(a, b, Fraction(table[a].teeth, table[b].teeth) * (1 if table[b].internal else -1)) for a, b in pairs]
    joints += [(gear.on, gear.name, Fraction(1)) for gear in table.values() if gear.on is not None]
    joints += [(b, a, 1 / ratio) for a, b, ratio in joints]
    reached, found = {pairs[0][0]}, list[tuple[str, str, Fraction]]()
    while new := next((j for j in joints if j[0] in reached and j[1] not in reached), None):
        reached.add(new[1])
        found.append(new)
    lost = sorted({name for pair in pairs for name in pair} - reached)
    if lost:
        raise ModelError(
            "no chain of meshes and shafts leads there from the first gear", path=lost[0], given=pairs[0][0]
        )
    return found


def _checked(gears: Sequence[ToothedGear], meshes: Sequence[ToothMesh]) -> dict[str, ToothedGear]:
    table = {gear.name: gear for gear in gears}
    if not meshes:
        raise ModelError("a stage needs a mesh", path="meshes", given=[], allowed="at least one pair of gears")
    count = len(meshes[0].directions)
    for mesh in meshes:
        for name in (mesh.a, mesh.b):
            if name not in table:
                raise ModelError("no such gear", path=mesh.pair, given=name, allowed=", ".join(table))
        if len(mesh.directions) != count or not count:
            raise ModelError("one direction per branch", path=mesh.pair, given=len(mesh.directions), allowed=str(count))
    for gear in gears:
        if gear.clocking is not None and len(gear.clocking) != count:
            raise ModelError(
                "one angle per branch", path=f"{gear.name}.clocking", given=len(gear.clocking), allowed=str(count)
            )
    return table


def _common(a: Fraction, b: Fraction) -> Fraction:
    """Greatest number of which both are multiples."""
    return Fraction(math.gcd(a.numerator * b.denominator, b.numerator * a.denominator), a.denominator * b.denominator)


def _multiple(a: Fraction, b: Fraction) -> Fraction:
    """Least common multiple of two positive fractions."""
    return a * b / _common(a, b)
