"""The branch set of a sweep: closed teeth where they stay closed, continued branches where they part.

Teeth are closed at speeds at which a linear response is the solution, every flank pressed all the time or never.
Mostly all loaded flanks are pressed and no far one.  Where the mean load leaves some open for good, as a slide of a
herringbone sun does, the motion is linear without these.

From the last speed before teeth part, the branch is followed through its folds until it is back on closed teeth and
going up.  There the next segment of closed teeth begins.  Where a branch ends before that, the set begins anew at the
next speed asked for.

In ranges of chaotic motions a branch may wind through hundreds of folds without a stable motion.  It is cut there, and
the next branch begins at a stable motion; in between stands one motion at every speed asked for.

A force on the far flank is negative (docs/conventions.md).  Shapes of measures: R flanks, m mesh rows, w whole meshes,
n coordinates, N samples.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Literal, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...engine.run_folder import RunFolder
from ...system.gaps import net_force
from ...system.system import Array, System, faces
from ..response.response import Response, Truncation, respond
from ..response.spectra import peak
from .continuation import NewtonResult, PathPoint, Stepping, arclength_unit, branch, linear_start, located, solve
from .problem import Problem, State, dynamic_size, evaluate, flank_force, prolonged
from .solutions import Refinement, Solution, distinct, harmonics_for, load_continuation, solution, with_stability

# Relative residual of the linear response, as of the linear sweep, and the largest that is no failure.
_LINEAR, _ACCEPTED = 1e-6, 1e-4
# Part of the lowest speed down to which a branch set may begin, and branches may turn back.
REACH = 0.4
# Speeds looked at besides those asked for, at most, in steps of at least this damping ratio.
_MOST, _LEAST_RATIO = 600, 1e-4
# Part of the dynamic size by which a motion with varying tangents may be away from the linear one, or a branch from a
# motion of closed teeth: on a fold of it, the two are as far apart as they are large.
NEAR = 0.3
# Times flanks are opened and closed until those that touch in the mean are those that press; least harmonics then.
_ROUNDS, _LEAST_OF_CLOSED_TEETH = 8, 16
# A branch has at least so many harmonics, of one mesh frequency and of each of two.
_LEAST = {1: 16, 2: 8}
# A solution at a speed belongs between two points of the branch when it is this near to their interpolation, per their
# distance, which counts as at least such a part of the dynamic size.
_BETWEEN, _LEAST_DISTANCE = 1.0, 1e-3
# Steps along the branch to a speed between two points, and the part of the speed at which it is reached: its rounding.
_SECANTS, _AT_SPEED = 6, 1e-9
# Parts between folds, one after the other, without a stable motion after which a branch is cut: resonances have two to
# four, and what is stable again later is found anew.
_UNSTABLE_PARTS = 16
# Rise of the speed with the length of a branch below which a point is on a fold, or between two.
_FLAT = 0.01

Number = TypeVar("Number", bound=np.inexact)
_End = Literal["through", "cut", "lost"]
"""How a branch ends: on closed teeth or behind the range, cut where it winds unstably, or where no step succeeds."""


# --- closed teeth -----------------------------------------------------------------------------------------------------


class Scan(NamedTuple):
    """Linear responses over speed.

    speeds : (Q,) relative, rising.  asked : (Q,) index among the speeds asked for, -1 of one between.
    solutions : (Q,) in which no flank changes its contact, None where one does.
    harmonics : (Q,) that the linear response needs.
    """

    speeds: Array
    asked: NDArray[np.int64]
    solutions: list[Solution | None]
    harmonics: NDArray[np.int64]


def scan_closed_teeth(refinement: Refinement, speeds: Array) -> Scan:
    """The linear response at distinct relative speeds (P,) and at enough between them to see every resonance.

    Where contact changes at the lowest one, speeds below it down to the first with closed teeth come along: a branch
    needs a beginning.
    """
    low = float(speeds.min())
    between = np.setdiff1d(_speeds_between(refinement.ready, low, float(speeds.max())), speeds)
    scanned = np.union1d(speeds, between)
    solutions, harmonics = _linear_solutions(refinement, scanned)
    if solutions[0] is None:
        below = _speeds_between(refinement.ready, REACH * low, low)
        solutions_below, harmonics_below = _linear_solutions(refinement, below)
        last = next((i for i in reversed(range(below.size)) if solutions_below[i] is not None), None)
        if last is not None:
            scanned = np.concatenate([below[last:], scanned])
            solutions = [*solutions_below[last:], *solutions]
            harmonics = np.concatenate([harmonics_below[last:], harmonics])
    asked = np.full(scanned.size, -1, np.int64)
    asked[np.searchsorted(scanned, speeds)] = np.arange(speeds.size)
    return Scan(speeds=scanned, asked=asked, solutions=solutions, harmonics=harmonics)


def _linear_solutions(refinement: Refinement, speeds: Array) -> tuple[list[Solution | None], NDArray[np.int64]]:
    """Solutions and harmonics (Q,), as of `Scan`, at rising relative speeds (Q,)."""
    solutions = list[Solution | None]([None] * speeds.size)
    harmonics = np.zeros(speeds.size, np.int64)
    if speeds.size:
        for block in respond(refinement.ready, speeds, tolerance=_LINEAR, shaft_orders=False):
            for at, index in enumerate(block.index.tolist()):
                harmonics[index] = block.harmonics
                if block.residual[at] <= _ACCEPTED:
                    speed, residual = float(block.speed[at]), float(block.residual[at])
                    solutions[index] = _closed(refinement, block.mesh.y[at], speed, block.truncation, residual)
        # linear solutions in which flanks left open by the mean load never touch
        one_tone = len(refinement.ready.lines.tones) == 1
        missing = [index for index, found in enumerate(solutions) if found is None] if one_tone else []
        pressed = _pressed(refinement, float(speeds[missing[0]]), int(harmonics[missing[0]])) if missing else None
        for index in missing if pressed is not None else ():
            H = harmonics_for(max(_LEAST_OF_CLOSED_TEETH, int(harmonics[index])))
            balance, speed = refinement.problem(H), float(speeds[index])
            start = linear_start(balance, speed, pressed)
            if np.all(evaluate(balance, start, speed).touching == pressed):
                open_apart = solution(refinement, start, speed, balance=balance, harmonics=H)
                if open_apart is not None and np.all(open_apart.state.touching == pressed):
                    solutions[index] = open_apart
    return solutions, harmonics


def _speeds_between(ready: Response, low: float, high: float) -> Array:
    """Relative speeds (Q,) between two others, in steps of the smallest damping ratio."""
    elastic = ~ready.modal.rigid
    ratio = ready.modal.damping[elastic] / (2 * np.sqrt(ready.modal.squared[elastic]))
    least = max(float(np.min(ratio, initial=1.0)), _LEAST_RATIO)
    count = min(int(np.log(high / low) / least), _MOST) if high > low else 0
    return np.geomspace(low, high, count + 2)[1:-1] if count else np.zeros(0)


def _closed(refinement: Refinement, y: Array, speed: float, kept: Truncation, residual: float) -> Solution | None:
    """The linear motion (2, J, n) as a solution, None where a tooth of it parts or strikes the other flank."""
    harmonics = max(kept[:-1])
    balance = refinement.lattice(kept[:-1], kept[-1], 1, refinement.samples(harmonics))
    state = evaluate(balance, y, speed)
    if not balance.rows.parametric:
        return _closed_by_law(refinement, balance, y, speed, harmonics)
    if not np.all(state.touching == (balance.rows.flanks.sense > 0)):
        return None
    residual = max(residual, state.norm / dynamic_size(y))
    return Solution(balance=balance, harmonics=harmonics, state=state, residual=residual)


def _closed_by_law(refinement: Refinement, balance: Problem, y: Array, speed: float, harmonics: int) -> Solution | None:
    """The motion that Newton's method reaches from the linear one (2, J, n), teeth closed and tangents as they vary.

    None where a tooth parts, and where the motion is no longer near the linear one: several may exist there, and the
    branch from the speeds before leads to them.
    """
    H = harmonics_for(max(_LEAST_OF_CLOSED_TEETH, harmonics))
    finer = refinement.problem(H)
    at = solution(refinement, prolonged(balance, finer, y), speed, balance=finer, harmonics=H)
    if at is None or not np.all(at.state.touching == (at.balance.rows.flanks.sense > 0)):
        return None
    linear = prolonged(balance, at.balance, y)
    moved = float(np.linalg.norm((at.state.y - linear)[:, 1:]))
    return at if moved <= NEAR * dynamic_size(linear) else None


def _pressed(refinement: Refinement, speed: float, harmonics: int) -> NDArray[np.bool_] | None:
    """Flanks (R,) that press in the mean of a linear motion with these alone, None where they are those loaded."""
    balance = refinement.problem(harmonics_for(max(_LEAST_OF_CLOSED_TEETH, harmonics)))
    loaded = pressed = balance.rows.flanks.sense > 0
    for _ in range(_ROUNDS):
        motion, F = linear_start(balance, speed, pressed)[0, 0], balance.rows.count
        mean = (balance.rows.gaps @ motion - balance.error[0])[:F]
        if np.array_equal(mean > 0, pressed):
            return None if np.array_equal(pressed, loaded) else pressed
        pressed = mean > 0
    return None


# --- branches ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Crossing:
    """A solution of the branch set at a speed asked for.

    part : number of the part it lies on; parts end where the speed turns, or where a branch has ended.
    """

    solution: Solution
    part: int


class Segment(NamedTuple):
    """A segment of the branch set, its solutions in order.

    parts : (K,) number of the part of each solution.  branch : whether it was continued; else teeth are closed.
    """

    solutions: list[Solution]
    parts: list[int]
    branch: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BranchSet:
    """All that lies between the lowest and the highest speed.

    speeds : (P,) asked for, relative, rising.  segments : in order.  crossings : of every speed asked for.
    ended : speeds where a branch ended before it was through.  cut : speeds where one was cut that winds unstably.
    """

    speeds: Array
    segments: list[Segment]
    crossings: list[list[Crossing]]
    ended: list[float]
    cut: list[float] = field(default_factory=list)


@dataclass(slots=True, kw_only=True)
class _Trace:
    """The branch set as far as it has been followed, `branches`.

    fixed : number of harmonics, None for as many as needed.  part : number of the part at hand.
    winding : whether the branch before was cut.  kept : keeps the points of every branch.
    """

    refinement: Refinement
    scan: Scan
    fixed: int | None
    stepping: Stepping
    branches: BranchSet
    part: int = 0
    winding: bool = False
    kept: RunFolder = field(default_factory=RunFolder)


def branch_set(
    refinement: Refinement,
    speeds: Array,
    *,
    harmonics: int | None = None,
    stepping: Stepping | None = None,
    kept: RunFolder | None = None,
) -> BranchSet:
    """Follow the branches from the lowest to the highest of distinct rising relative speeds (P,).

    Parameters
    ----------
    harmonics : of every point with contact loss; None: as many as each needs.  stepping : of branches.
    kept : keeps closed teeth, the points of a branch, and the branches that have been followed.
    """
    kept = kept or RunFolder()
    trace = _Trace(
        refinement=refinement,
        scan=kept.made("closed teeth", partial(scan_closed_teeth, refinement, speeds)),
        fixed=harmonics,
        stepping=stepping or Stepping(),
        branches=BranchSet(speeds=speeds, segments=[], crossings=[[] for _ in speeds], ended=[]),
        kept=kept,
    )
    index = 0
    if (followed := kept.value("followed")) is not None:
        index, trace.branches, trace.part, trace.winding = followed
    while index < trace.scan.speeds.size:
        index = _closed_segment(trace, index)
        if index < trace.scan.speeds.size:
            index = _branch_segment(trace, index)
            kept.keep_value("followed", (index, _as_it_is(trace.branches), trace.part, trace.winding))
    return trace.branches


def _as_it_is(branches: BranchSet) -> BranchSet:
    """The branch set as it is now, which what is entered later does not change."""
    return replace(
        branches,
        segments=list(branches.segments),
        crossings=[list(crossings) for crossings in branches.crossings],
        ended=list(branches.ended),
        cut=list(branches.cut),
    )


def _closed_segment(trace: _Trace, index: int) -> int:
    """Enter the linear solutions from a scanned speed on; returns the index of that at which teeth part."""
    closed = list[Solution]()
    while index < trace.scan.speeds.size:
        at, asked = trace.scan.solutions[index], int(trace.scan.asked[index])
        if at is None:
            break
        if asked >= 0:
            trace.branches.crossings[asked].append(Crossing(solution=at, part=trace.part))
            closed.append(at)
        index += 1
    if closed:
        trace.branches.segments.append(Segment(solutions=closed, parts=[trace.part] * len(closed), branch=False))
    return index


def _branch_segment(trace: _Trace, index: int) -> int:
    """Follow the branch from where teeth part at a scanned speed; returns the first scanned speed behind it."""
    scan = trace.scan
    before = scan.solutions[index - 1] if index else None
    least = _LEAST[len(trace.refinement.ready.lines.tones)]
    H = trace.fixed or harmonics_for(max(least, int(scan.harmonics[max(index - 1, 0)])))
    balance = trace.refinement.problem(H)
    speed = float(scan.speeds[index - 1 if before is not None else index])
    if before is not None:
        start = solve(balance, prolonged(before.balance, balance, before.state.y), speed)
    if before is None or not start.converged:
        asked = int(scan.asked[index])
        if asked < 0 or trace.branches.crossings[asked]:
            return index + 1
        speed = float(scan.speeds[index])
        start = _begun_anew(trace, balance, H, speed, index)
        trace.part += 1
        if not start.converged:
            # behind a branch that was cut no motion is looked for but stable ones
            if not trace.winding:
                trace.branches.ended.append(speed)
            return index + 1
        if trace.winding:
            residual = trace.refinement.residual(balance, start.state, H)
            alone = Solution(balance=balance, harmonics=H, state=start.state, residual=residual)
            alone = with_stability(trace.refinement, alone)
            if not alone.stable:
                trace.branches.crossings[asked].append(Crossing(solution=alone, part=trace.part))
                return index + 1
    points, end = _followed(trace, balance, H, start.state)
    trace.winding = end == "cut"
    return max(_enter_branch(trace, points, H, end), index + 1)


def _begun_anew(trace: _Trace, balance: Problem, harmonics: int, speed: float, index: int) -> NewtonResult:
    """A solution at a scanned speed: behind a branch that was cut from the speed before, else by the load."""
    asked = int(trace.scan.asked[index])
    if trace.winding and asked > 0 and trace.branches.crossings[asked - 1]:
        last = trace.branches.crossings[asked - 1][-1].solution
        solved = solve(balance, prolonged(last.balance, balance, last.state.y), speed)
        if solved.converged:
            return solved
    return load_continuation(trace.refinement, speed, harmonics=harmonics)


def _followed(trace: _Trace, balance: Problem, harmonics: int, start: State) -> tuple[list[PathPoint], _End]:
    """Points of the branch from a solved state, until teeth are closed again or the range of speeds is left.

    With them how it ends.
    """
    scan, winding = trace.scan, _Winding(trace=trace, harmonics=harmonics)

    def back(point: PathPoint) -> bool:
        """Whether the speed rises with the contact of the linear solution at the next scanned speed."""
        ahead = int(np.searchsorted(scan.speeds, point.state.speed))
        linear = scan.solutions[ahead] if ahead < scan.speeds.size else None
        if (
            linear is None
            or point.tangent.speed <= 0
            or point.length <= 0
            or point.state.speed <= start.speed * (1 + _AT_SPEED)
        ):
            return False
        if not np.all(point.state.touching == linear.state.touching[0]):
            return False
        # with tangents that vary it has to be on the motions of closed teeth, too
        y = prolonged(linear.balance, point.path.balance, linear.state.y)
        near = float(np.linalg.norm((point.state.y - y)[:, 1:])) <= NEAR * dynamic_size(y)
        return point.path.balance.rows.parametric or near

    system = trace.refinement.ready.system

    def returned(point: PathPoint) -> bool:
        """Whether the branch goes down on closed teeth: it came from there."""
        return point.state.unchanging and point.tangent.speed < 0 and point.length > 0

    points = branch(
        balance,
        start,
        low=REACH * float(scan.speeds[0]),
        high=float(scan.speeds[-1]),
        unit=arclength_unit(start.speed, start.speed, start.y),
        stepping=trace.stepping,
        score=lambda state, problem: float(force_level(system, problem, state).max()),
        stop=lambda point: back(point) or returned(point) or winding.unstable(point),
        kept=trace.kept.part(f"branch {len(trace.branches.segments)}"),
    )
    last = points[-1]
    if last.state.unchanging or back(last) or (last.tangent.speed > 0 and last.state.speed > scan.speeds[-1]):
        return points, "through"
    return points, "cut" if winding.count >= _UNSTABLE_PARTS else "lost"


@dataclass(slots=True, kw_only=True)
class _Winding:
    """Unstable parts of a branch between folds, one after the other, up to the last point.

    part : points since the last fold.
    """

    trace: _Trace
    harmonics: int
    part: list[PathPoint] = field(default_factory=list)
    count: int = 0

    def unstable(self, point: PathPoint) -> bool:
        """Whether the branch is cut at its next point."""
        if self.part and np.sign(point.tangent.speed) != np.sign(self.part[-1].tangent.speed):
            refinement, middle = self.trace.refinement, self.part[len(self.part) // 2]
            stable = with_stability(refinement, _as_solution(refinement, middle, self.harmonics)).stable
            self.count = 0 if stable else self.count + 1
            self.part = []
        if not self.part or point is not self.part[-1]:
            self.part.append(point)
        return self.count >= _UNSTABLE_PARTS


def _enter_branch(trace: _Trace, points: list[PathPoint], harmonics: int, end: _End) -> int:
    """Enter the solutions of a branch at every speed asked for; returns the first scanned speed behind it."""
    scan, parts = trace.scan, [trace.part]
    for before, after in pairwise(points):
        if np.sign(before.tangent.speed) != np.sign(after.tangent.speed):
            trace.part += 1
        parts.append(trace.part)
        part = parts[-2] if abs(before.tangent.speed) > abs(after.tangent.speed) else parts[-1]
        low, high = sorted((before.state.speed, after.state.speed))
        for index in range(int(np.searchsorted(scan.speeds, low)), int(np.searchsorted(scan.speeds, high, "right"))):
            speed, asked = float(scan.speeds[index]), int(scan.asked[index])
            if asked >= 0 and speed != before.state.speed:
                at = _between(trace, before, after, speed, harmonics)
                if at is not None:
                    trace.branches.crossings[asked].append(Crossing(solution=at, part=part))
    solutions = [_as_solution(trace.refinement, point, harmonics) for point in points]
    # a start that no closed segment leads to, where it lies at a speed asked for
    begin = points[0].state.speed
    at_begin = int(np.searchsorted(scan.speeds, begin))
    asked = int(scan.asked[at_begin]) if at_begin < scan.speeds.size and scan.speeds[at_begin] == begin else -1
    if asked >= 0 and not trace.branches.crossings[asked]:
        trace.branches.crossings[asked].append(Crossing(solution=solutions[0], part=parts[0]))
    trace.branches.segments.append(Segment(solutions=solutions, parts=parts, branch=True))
    last = points[-1].state.speed
    behind = int(np.searchsorted(scan.speeds, last, side="right"))
    if end != "through":
        (trace.branches.cut if end == "cut" else trace.branches.ended).append(last)
    if end != "through" or points[-1].tangent.speed < 0:
        trace.part += 1
        behind = int(np.searchsorted(scan.speeds, max(point.state.speed for point in points), side="right"))
    # closed solutions at speeds that the branch has passed without reaching them: parts of their own
    for closed, asked in zip(scan.solutions[:behind], scan.asked[:behind].tolist(), strict=True):
        if closed is None or asked < 0:
            continue
        known = trace.branches.crossings[asked]
        if all(distinct(each.solution, closed) for each in known):
            known.append(Crossing(solution=closed, part=-1 - asked))
    return behind


def _between(trace: _Trace, before: PathPoint, after: PathPoint, speed: float, harmonics: int) -> Solution | None:
    """The solution of a branch at a speed between two of its points, None where Newton's method fails.

    A solution far from their interpolation belongs to another branch: the speed is then approached along this one.
    """
    a, b, path = before.state, after.state, before.path
    guess = a.y + (speed - a.speed) / (b.speed - a.speed) * (b.y - a.y)
    solved = partial(
        solution,
        trace.refinement,
        speed=speed,
        balance=path.balance,
        harmonics=harmonics,
        backward=before.tangent.speed + after.tangent.speed < 0,
    )
    at = solved(guess, fixed=trace.fixed is not None)
    far = _BETWEEN * max(float(np.linalg.norm(a.y - b.y)), _LEAST_DISTANCE * dynamic_size(a.y))
    if at is not None and float(np.linalg.norm(at.state.y - prolonged(path.balance, at.balance, guess))) <= far:
        return at
    near = located(before, after, lambda point: point.state.speed - speed, tolerance=_AT_SPEED * speed, tries=_SECANTS)
    return None if near is None else solved(near.state.y, fixed=True)


def _as_solution(refinement: Refinement, point: PathPoint, harmonics: int) -> Solution:
    """A point of a branch as a solution, with its residual at twice the harmonics."""
    balance, state = point.path.balance, point.state
    residual, backward = refinement.residual(balance, state, harmonics), point.tangent.speed < _FLAT
    return Solution(balance=balance, harmonics=harmonics, state=state, residual=residual, backward=backward)


# --- measures of its motions ------------------------------------------------------------------------------------------


def row_force(system: System, force: NDArray[Number]) -> NDArray[Number]:
    """Force of every mesh row (N, m) from that of the flanks (N, R): the loaded flank less the far one [N]."""
    return net_force(force, system.far_flanks.mesh[: force.shape[1] - len(system.meshes.name)])


def mesh_force(system: System, force: NDArray[Number]) -> NDArray[Number]:
    """Force of every whole mesh (N, w) from that of the flanks (N, R), far flanks negative [N]."""
    return faces(system.meshes).total(row_force(system, force), axis=1)


def touching_meshes(system: System, touching: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whole meshes (N, w) of which any of the flanks (N, R) touches."""
    m, far = len(system.meshes.name), system.far_flanks.mesh
    rows = touching[:, :m].copy()
    rows[:, far[: touching.shape[1] - m]] |= touching[:, m:]
    return np.asarray(faces(system.meshes).total(rows.astype(float), axis=1) > 0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Measures:
    """Measures of a motion.

    rms, highest, lowest : (w,) of the force of every whole mesh [N], its far flank negative.
    open : (w,) part of the time in which no flank of it touches.
    amplitude : (n,) half the distance between extremes of a coordinate [m; rz as radius times angle].
    flank : (F,) largest force of every flank [N].
    links : by the names of their variables, of link rows (p,) and bearings (k,) [N, N m].
    """

    rms: Array
    highest: Array
    lowest: Array
    open: Array
    amplitude: Array
    flank: Array
    links: dict[str, Array] = field(default_factory=dict)


def force_level(system: System, balance: Problem, state: State) -> Array:
    """RMS of the dynamic force of every whole mesh, (w,) [N]."""
    return np.asarray(mesh_force(system, flank_force(balance, state)).std(axis=0))


def periodic_measures(system: System, balance: Problem, state: State) -> Measures:
    """Measures of a periodic motion over the samples of its period."""
    motion = balance.grid.values(state.y.reshape(-1, state.y.shape[2])) @ balance.modal.shapes.T
    return _measures(system, flank_force(balance, state), state.touching, motion, smooth=len(balance.grid.counts) == 1)


def record_measures(system: System, force: Array, motion: Array) -> Measures:
    """Measures of a record of flank forces (N, R) [N] and coordinates (N, n) [m] over time."""
    return _measures(system, force, force != 0, motion, smooth=False)


def _measures(system: System, force: Array, touching: np.ndarray, motion: Array, *, smooth: bool) -> Measures:
    """Measures of flank forces (N, R) [N], contact (N, R) and coordinates (N, n) [m].

    smooth : whether extremes are refined by parabolas through the samples.
    """
    net, q = mesh_force(system, force), motion.T
    highest, lowest = net.max(axis=0), net.min(axis=0)
    if smooth:
        # a force of exactly 0 is a flank apart: no parabola goes below it
        highest, lowest = peak(net.T), np.where(lowest == 0, 0.0, -peak(-net.T))
    reach = (peak(q) + peak(-q)) / 2 if smooth else (q.max(axis=1) - q.min(axis=1)) / 2
    return Measures(
        rms=net.std(axis=0),
        highest=highest,
        lowest=lowest,
        open=1 - touching_meshes(system, touching).mean(axis=0),
        amplitude=system.dofs.radius * reach,
        flank=force.max(axis=0),
    )
