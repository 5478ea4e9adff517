"""Mesh phases of a stage: leads, assembly condition, nearest buildable angles, clearance of neighbours.

A stage is given by its gears and, in the order of the power path, its meshes.  At time zero the first mesh of branch 1
is in contact at its pitch point.  Two gears mesh where a whole combination of their angles, teeth by teeth, is a phase
modulo one pitch: the positions at which all meshes of a branch meet form a lattice, and the loops of meshes (whole
combinations of the rows in which no gear is left) decide whether there is one.  Branch 1 turns every gear, the central
ones too; in the other branches every mesh with a central gear follows that gear, and so has its own phase even where
the branch cannot be assembled.  Whatever tooth of a stepped shaft branch 1 takes, the others can take the like.
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
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from operator import mul

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..teeth.geometry import Angle, Phase, driver_tooth, mate_tooth, shift_term
from .kinematics import merged, spread, whole_solution

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
    mismatch : of the teeth of each branch [pitches], the largest of its loops; exact where rational.  Of branch 1 in
        itself, of the others against the central gears that branch 1 sets.
    assembles : no mismatch exceeds the tolerance.  closes : nor does that of branch 1 in itself.
    step : buildable angles from branch 1 are its multiples [turns]; None = any angle can be built.
    nearest_angles : buildable angle of each branch (of its first mesh) nearest to the given one, branch 1 kept
        [turns]; None where the clocking of its shafts fits at no angle.
    clocking : of every planet gear on the shaft of another, least angle between tooth centres of the two [turns].
    """

    lead: Mapping[str, tuple[Number, ...]]
    sense: Mapping[str, int]
    mismatch: tuple[Number, ...]
    assembles: bool
    closes: bool
    step: Fraction | None
    nearest_angles: tuple[Number | None, ...]
    clocking: Mapping[str, tuple[Number, ...]]


def flank_of_torque(torque_on_b: float, *, internal: bool) -> int:
    """Flank d of a mesh from the torque [N m] its teeth put on b: the mean mesh force is positive (+1 for 0)."""
    return -1 if (torque_on_b if internal else -torque_on_b) < 0 else 1


def stage_leads(gears: Sequence[ToothedGear], meshes: Sequence[ToothMesh], *, sense: int) -> StagePhases:
    """Phase leads of all meshes of a stage, at least one, and whether its branches can be assembled.

    sense : g, sign of the speed of gear a of the first mesh (the sun) relative to the carrier; +1 where not known.

    Raises
    ------
    ModelError : meshes that are not connected.
    """
    table = {gear.name: gear for gear in gears}
    count = len(meshes[0].directions)
    senses = chain_signs(gears, [(m.a, m.b) for m in meshes], sense)
    drives = {m.pair: m.flank * s for m, s in zip(meshes, senses, strict=True)}
    points = [{m.pair: _pitch_point(table, m, i) for m in meshes} for i in range(count)]
    first = _first_branch(table, meshes, points[0])
    lattice = _Lattice.of(*_rows(table, meshes, [g.name for g in gears if not g.central]))
    turns = [Phase.of(angle) - Phase.of(meshes[0].directions[0]) for angle in meshes[0].directions]
    # what every mesh of a branch misses when its planet gears stand in it as those of branch 1 in theirs [pitches]
    rights = [
        [
            points[i][mesh.pair].sum - points[0][mesh.pair].sum - sum(row) * turns[i]
            for mesh, row in zip(meshes, lattice.rows, strict=True)
        ]
        for i in range(count)
    ]
    branches = [first]
    for i in range(1, count):
        branches.append(_other_branch(table, meshes, lattice, first, (points[0], points[i]), i, turns[i], rights[i]))
    mismatch = tuple(_largest_mismatch(meshes, branch.gaps) for branch in branches)
    _, centrals = _rows(table, meshes, [g.name for g in gears if g.central])
    step, nearest = _buildable_angles(meshes, lattice, [sum(row) for row in centrals], rights)
    return StagePhases(
        lead={m.pair: tuple((drives[m.pair] * b.place[m.pair] % 1).value for b in branches) for m in meshes},
        sense=drives,
        mismatch=mismatch,
        assembles=all(abs(float(miss)) <= ASSEMBLY_TOLERANCE for miss in mismatch),
        closes=abs(float(mismatch[0])) <= ASSEMBLY_TOLERANCE,
        step=step,
        nearest_angles=nearest,
        clocking={
            g.name: tuple(_fitted_clocking(table, g, b) for b in branches) for g in gears if g.on and not g.central
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
class _Lattice:
    """Where teeth meet: rows of whole teeth, one a mesh, times angles of solids [turns] = phases, modulo 1.

    solids : what turns as one, by the gear at its root.  inverse, kernel : see `whole_solution`.
    """

    solids: Sequence[str]
    rows: Sequence[Sequence[int]]
    inverse: Sequence[Sequence[Fraction]]
    kernel: Sequence[Sequence[int]]

    @classmethod
    def of(cls, solids: Sequence[str], rows: Sequence[Sequence[int]]) -> _Lattice:
        """The lattice of some rows."""
        return cls(solids, rows, *whole_solution(rows, len(solids)))

    def met(self, right: Sequence[Phase]) -> tuple[list[Phase], list[Phase]]:
        """Phases that rows meet, and what misses in each [pitches]: 0 but in the last row of each loop, the least."""
        gap = [Phase()] * len(self.rows)
        for loop in reversed(self.kernel):
            last = max(k for k, times in enumerate(loop) if times)
            miss = _total(loop, [a - b for a, b in zip(right, gap, strict=True)]).nearest()
            gap[last] = Fraction(1, loop[last]) * miss
        return [a - b for a, b in zip(right, gap, strict=True)], gap

    def tooth(self, solid: str, teeth: int, met: Sequence[Phase]) -> Phase:
        """teeth x angle of a solid where the rows are met [pitches]."""
        return _total([teeth * weight for weight in self.inverse[self.solids.index(solid)]], met)


@dataclass(frozen=True, slots=True)
class _PitchPoint:
    """teeth x angle of the solids of both gears of a mesh with its contact at the pitch point [pitches].

    sum : what the row of the mesh must be, tau_A + tau_B of external gears and tau_A - tau_B with a ring.
    """

    a: Phase
    b: Phase
    sum: Phase


@dataclass(frozen=True, slots=True)
class _Branch:
    """Places of contact of every pair [base pitches], gaps of every mesh [pitches], tooth centres of gears [turns]."""

    place: Mapping[str, Phase]
    gaps: Sequence[Phase]
    angle: Mapping[str, Phase]


def _total(weights: Iterable[int | Fraction], phases: Iterable[Phase]) -> Phase:
    return sum((weight * phase for weight, phase in zip(weights, phases, strict=True) if weight), Phase())


def _solid(table: Mapping[str, ToothedGear], name: str, branch: int = 0) -> tuple[str, Phase]:
    """Gear at the root of what a gear turns with as one, and its angle from there [turns]; fitted shafts part here."""
    gear, angle = table[name], Phase()
    while gear.on is not None and gear.clocking is not None:
        angle += Phase.of(gear.clocking[0 if gear.central else branch])
        gear = table[gear.on]
    return gear.name, angle


def _sign(table: Mapping[str, ToothedGear], mesh: ToothMesh) -> int:
    return -1 if table[mesh.b].internal else 1


def _pitch_point(table: Mapping[str, ToothedGear], mesh: ToothMesh, branch: int) -> _PitchPoint:
    a, b = table[mesh.a], table[mesh.b]
    direction = Phase.of(mesh.directions[branch])
    driver = driver_tooth(Phase(), direction, teeth=a.teeth, flank=mesh.flank, shift=shift_of(mesh, a))
    mate = mate_tooth(Phase(), direction, teeth=b.teeth, flank=mesh.flank, shift=shift_of(mesh, b), internal=b.internal)
    driver -= a.teeth * _solid(table, a.name, branch)[1]
    mate -= b.teeth * _solid(table, b.name, branch)[1]
    return _PitchPoint(driver, mate, driver + _sign(table, mesh) * mate)


def _rows(
    table: Mapping[str, ToothedGear], meshes: Sequence[ToothMesh], names: Sequence[str]
) -> tuple[list[str], list[list[int]]]:
    """The solids of some gears, and the teeth by which they stand in the row of every mesh."""
    solids = list(dict.fromkeys(_solid(table, name)[0] for name in names))
    rows = [[0] * len(solids) for _ in meshes]
    for row, mesh in zip(rows, meshes, strict=True):
        for name, sign in ((mesh.a, 1), (mesh.b, _sign(table, mesh))):
            if (solid := _solid(table, name)[0]) in solids:
                row[solids.index(solid)] += sign * table[name].teeth
    return solids, rows


def _starts(table: Mapping[str, ToothedGear], meshes: Sequence[ToothMesh]) -> list[ToothMesh]:
    """The first mesh of each set of solids that meshes tie together."""
    pairs = [(_solid(table, mesh.a)[0], _solid(table, mesh.b)[0]) for mesh in meshes]
    group = merged({name: name for pair in pairs for name in pair}, pairs)
    first: dict[str, ToothMesh] = {}
    for (a, _), mesh in zip(pairs, meshes, strict=True):
        first.setdefault(group[a], mesh)
    return list(first.values())


def _first_branch(
    table: Mapping[str, ToothedGear], meshes: Sequence[ToothMesh], points: Mapping[str, _PitchPoint]
) -> _Branch:
    """Branch 1 and the central gears, turned until all meshes meet, the first one at its pitch point.

    Each further set of solids that only fitted shafts tie to the others has its first mesh at its pitch point too.
    """
    solids, rows = _rows(table, meshes, list(table))
    starts = _starts(table, meshes)
    begin = [[table[mesh.a].teeth if solid == _solid(table, mesh.a)[0] else 0 for solid in solids] for mesh in starts]
    lattice = _Lattice.of(solids, [*begin, *rows])
    right = [*(points[mesh.pair].a for mesh in starts), *(points[mesh.pair].sum for mesh in meshes)]
    met, gaps = lattice.met(right)
    place = {
        m.pair: m.flank * (lattice.tooth(_solid(table, m.a)[0], table[m.a].teeth, met) - points[m.pair].a)
        for m in meshes
    }
    angle = {name: lattice.tooth(s, 1, met) + ahead for name in table for s, ahead in [_solid(table, name)]}
    return _Branch(place, gaps[len(starts) :], angle)


def _other_branch(
    table: Mapping[str, ToothedGear],
    meshes: Sequence[ToothMesh],
    lattice: _Lattice,
    first: _Branch,
    points: tuple[Mapping[str, _PitchPoint], Mapping[str, _PitchPoint]],
    branch: int,
    turn: Phase,
    right: Sequence[Phase],
) -> _Branch:
    """A branch (1 ..) as its planet gears fit the central gears that branch 1 has set.

    A mesh with a central gear follows that gear, where the branch cannot be assembled too.
    lattice : of the planet gears.  points : of branch 1 and of this one.  turn : from branch 1 [turns].
    right : what its rows miss before its planet gears turn [pitches].
    """
    met, gaps = lattice.met(right)
    place = {}
    for m in meshes:
        start, now = points[0][m.pair], points[1][m.pair]
        if table[m.a].central:
            move = m.flank * (start.a - now.a)
        elif table[m.b].central:
            move = m.flank * _sign(table, m) * (now.b - start.b)
        else:
            teeth, solid = table[m.a].teeth, _solid(table, m.a)[0]
            move = m.flank * (lattice.tooth(solid, teeth, met) + teeth * turn - (now.a - start.a))
        place[m.pair] = first.place[m.pair] + move
    angle = {}
    for name in first.angle:
        solid, ahead = _solid(table, name, branch)
        if solid in lattice.solids:
            angle[name] = first.angle[solid] + turn + lattice.tooth(solid, 1, met) + ahead
    return _Branch(place, gaps, angle)


def _fitted_clocking(table: Mapping[str, ToothedGear], gear: ToothedGear, branch: _Branch) -> Number:
    """Least angle between tooth centres of a gear and of the gear on whose shaft it sits [turns]."""
    other = table[gear.on or ""]
    # both may turn by a tooth: what is left is known up to the greatest angle of which both pitches are multiples
    common = Fraction(math.gcd(other.teeth, gear.teeth), gear.teeth * other.teeth)
    return ((branch.angle[gear.name] - branch.angle[other.name]) % common).value


def shift_of(mesh: ToothMesh, gear: ToothedGear) -> float:
    """Phase c of a gear in one of its meshes [pitches], see `teeth.geometry`."""
    return shift_term(
        teeth=gear.teeth,
        profile_shift=gear.profile_shift,
        normal_angle=mesh.normal_angle,
        transverse_angle=mesh.transverse_angle,
        working_angle=mesh.working_angle,
        internal=gear.internal,
    )


def _largest_mismatch(meshes: Sequence[ToothMesh], gaps: Sequence[Phase]) -> Number:
    """Largest gap of a branch, as the place from a less the place from b [pitches]."""
    values = [(-mesh.flank * gap).nearest().value for mesh, gap in zip(meshes, gaps, strict=True)]
    return max(values, key=lambda value: abs(float(value)))


def _buildable_angles(
    meshes: Sequence[ToothMesh], lattice: _Lattice, slopes: Sequence[int], rights: Sequence[Sequence[Phase]]
) -> tuple[Fraction | None, tuple[Number | None, ...]]:
    """Step of the buildable angles, and for every branch the one nearest to its own [turns]; see `StagePhases`.

    Moving a branch by t adds slopes x t to its rows: kernel @ (right + slopes t) must be whole.
    slopes : whole numbers, one per mesh.  rights : of every branch.
    """
    per_turn = [[sum(y * slope for y, slope in zip(loop, slopes, strict=True))] for loop in lattice.kernel]
    inverse, fixed = whole_solution(per_turn, 1)
    step = Fraction(1, math.gcd(*(row[0] for row in per_turn))) if any(row[0] for row in per_turn) else None
    nearest: list[Number | None] = []
    for given, right in zip(meshes[0].directions, rights, strict=True):
        miss = [_total(loop, right) for loop in lattice.kernel]
        stuck = any(abs(float(_total(loop, miss).nearest().value)) > ASSEMBLY_TOLERANCE for loop in fixed)
        # Of two equally near the smaller: opposite planets stay so.
        move = Phase() if step is None else (-_total(inverse[0], miss)).nearest(step)
        nearest.append(None if stuck else (Phase.of(given) + move).value)
    return step, tuple(nearest)


def chain_signs(gears: Sequence[ToothedGear], pairs: Sequence[tuple[str, str]], first: int) -> tuple[int, ...]:
    """Sign of every mesh (a, b) of a chain, from that of its first mesh: flank d without torques, or sense of gear a.

    Along a branch it alternates at every external gear (docs/conventions.md, The mesh row); shafts and rings keep it.

    Raises
    ------
    ModelError : a mesh without a gear in common with those before it.
    """
    table = {gear.name: gear for gear in gears}
    speeds = _speeds(table, pairs)
    return tuple(first if speeds[a] > 0 else -first for a, _ in pairs)


def _speeds(table: Mapping[str, ToothedGear], pairs: Sequence[tuple[str, str]]) -> dict[str, Fraction]:
    """Speed of every gear relative to the carrier per that of the first one."""
    joints = [(a, b, Fraction(table[a].teeth, table[b].teeth) * (1 if table[b].internal else -1)) for a, b in pairs]
    joints += [(gear.on, gear.name, Fraction(1)) for gear in table.values() if gear.on is not None]
    joints += [(b, a, 1 / ratio) for a, b, ratio in joints]
    speeds = spread({pairs[0][0]: Fraction(1)}, joints, mul)
    lost = sorted({name for pair in pairs for name in pair} - speeds.keys())
    if lost:
        raise ModelError(
            "no chain of meshes and shafts leads there from the first gear", path=lost[0], given=pairs[0][0]
        )
    return speeds
