"""The whole way from the lowest to the highest speed: closed teeth where they stay closed, branches where they part.

From the last speed before teeth part, the branch is followed through its folds until it is back on closed teeth and
going up; there the next stretch of closed teeth begins.  Where a branch ends before that, the way begins anew.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ...system.system import Array
from .closed_teeth import REACH, Scan, scanned
from .continuation import Measure, PathPoint, Stepping, branch, measure, step_from
from .corrector import dynamic_size, solve
from .outputs import force_level
from .problem import Problem, State
from .refinement import Levels, Solution, apart, carried, fitting, rescued, solution

__all__ = ['Crossing', 'Route', 'Stretch', 'route']

# A branch has at least so many harmonics, of one mesh frequency and of each of two.
_LEAST = {1: 16, 2: 8}
# A solution at a speed belongs between two points of the branch when it is this near to them, per their distance.
_BETWEEN = 1.0
_SECANTS = 6
# Rise of the speed with the length of a branch at which a point is a fold.
_FLAT = 0.01


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Crossing:
    """A solution at a speed asked for.

    run : number of the part of the way it lies on; parts end where the speed turns, or where the way is broken.
    """

    solution: Solution
    run: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stretch:
    """A part of the way as solutions, in order.  points : of a branch, else none.  runs : (K,) of each solution."""

    solutions: list[Solution]
    runs: list[int]
    branch: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Route:
    """speeds : (P,) asked for, relative.  stretches : the whole way in order.  crossings : of every speed asked for.

    broken : speeds where a branch ended before it was through.
    """

    speeds: Array
    stretches: list[Stretch]
    crossings: list[list[Crossing]]
    broken: list[float]


@dataclass(slots=True, kw_only=True)
class _Way:
    """What has been walked so far."""

    levels: Levels
    scan: Scan
    fixed: int | None
    stepping: Stepping
    crossings: list[list[Crossing]]
    stretches: list[Stretch] = field(default_factory=list)
    broken: list[float] = field(default_factory=list)
    run: int = 0


def route(levels: Levels, speeds: Array, *, harmonics: int | None = None, stepping: Stepping | None = None) -> Route:
    """Walk from the lowest to the highest of distinct speeds (P,).

    Parameters
    ----------
    harmonics : of every point with contact loss; None: as many as each needs.  stepping : of branches.
    """
    way = _Way(
        levels=levels,
        scan=scanned(levels, speeds),
        fixed=harmonics,
        stepping=stepping or Stepping(),
        crossings=[[] for _ in speeds],
    )
    place = 0
    while place < way.scan.speeds.size:
        place = _closed_leg(way, place)
        if place < way.scan.speeds.size:
            place = _open_leg(way, place)
    return Route(speeds=speeds, stretches=way.stretches, crossings=way.crossings, broken=way.broken)


def _closed_leg(way: _Way, place: int) -> int:
    """Take the linear solutions from a scanned speed on; returns where teeth part."""
    found = list[Solution]()
    while place < way.scan.speeds.size:
        at, asked = way.scan.solutions[place], int(way.scan.asked[place])
        if at is None:
            break
        if asked >= 0:
            way.crossings[asked].append(Crossing(solution=at, run=way.run))
            found.append(at)
        place += 1
    if found:
        way.stretches.append(Stretch(solutions=found, runs=[way.run] * len(found), branch=False))
    return place


def _open_leg(way: _Way, place: int) -> int:
    """Follow the branch from where teeth part at a scanned speed; returns the first scanned speed behind it."""
    scan = way.scan
    before = scan.solutions[place - 1] if place else None
    least = _LEAST[len(way.levels.ready.lines.tones)]
    H = way.fixed or fitting(max(least, int(scan.harmonics[max(place - 1, 0)])))
    given = way.levels.problem(H)
    speed = float(scan.speeds[place - 1 if before is not None else place])
    if before is not None:
        start = solve(given, carried(before.given, given, before.state.y), speed)
    if before is None or not start.converged:
        asked = int(scan.asked[place])
        if asked < 0 or way.crossings[asked]:
            return place + 1
        speed = float(scan.speeds[place])
        start = rescued(way.levels, speed, harmonics=H)
        way.run += 1
        if not start.converged:
            way.broken.append(speed)
            return place + 1
    points = _followed(way, given, H, start.state)
    behind = _recorded(way, points, H)
    return max(behind, place + 1)


def _followed(way: _Way, given: Problem, harmonics: int, start: State) -> list[PathPoint]:
    scan = way.scan

    def back(point: PathPoint) -> bool:
        """Going up with flanks that touch always or never, as in the linear solution at the next scanned speed."""
        ahead = int(np.searchsorted(scan.speeds, point.state.speed))
        linear = scan.solutions[ahead] if ahead < scan.speeds.size else None
        if linear is None or point.onward <= 0 or point.length <= 0 or point.state.speed <= start.speed * (1 + 1e-9):
            return False
        return bool(np.all(point.state.touching == linear.state.touching[0]))

    system = way.levels.ready.system
    return branch(
        way.levels,
        given,
        harmonics,
        start,
        low=REACH * float(scan.speeds[0]),
        high=float(scan.speeds[-1]),
        unit=_unit(start),
        stepping=way.stepping,
        score=lambda state, problem: float(force_level(system, problem, state).max()),
        stop=back,
    )


def _unit(start: State) -> Measure:
    return measure(start.speed, start.speed, start.y)


def _recorded(way: _Way, points: list[PathPoint], harmonics: int) -> int:
    """Enter the solutions of a branch at every speed asked for; returns the first scanned speed behind it."""
    scan, runs = way.scan, [way.run]
    for before, after in pairwise(points):
        if np.sign(before.onward) != np.sign(after.onward):
            way.run += 1
        runs.append(way.run)
        _crossed(way, before, after, runs[-2] if abs(before.onward) > abs(after.onward) else runs[-1], harmonics)
    found = [_as_solution(way.levels, point, harmonics) for point in points]
    _begun(way, found[0], runs[0])
    way.stretches.append(Stretch(solutions=found, runs=runs, branch=True))
    last = points[-1].state.speed
    behind = int(np.searchsorted(scan.speeds, last, side="right"))
    through = points[-1].onward > 0 and (last > scan.speeds[-1] or points[-1].state.unchanging)
    if not through:
        way.broken.append(last)
        way.run += 1
        behind = int(np.searchsorted(scan.speeds, max(point.state.speed for point in points), side="right"))
    _other_linear(way, behind)
    return behind


def _begun(way: _Way, first: Solution, run: int) -> None:
    """The start of a branch that no closed stretch leads to, where it lies at a speed asked for."""
    place = int(np.searchsorted(way.scan.speeds, first.state.speed))
    asked = int(way.scan.asked[place]) if place < way.scan.speeds.size else -1
    if asked >= 0 and way.scan.speeds[place] == first.state.speed and not way.crossings[asked]:
        way.crossings[asked].append(Crossing(solution=first, run=run))


def _crossed(way: _Way, before: PathPoint, after: PathPoint, run: int, harmonics: int) -> None:
    """The solutions at the speeds asked for between two points of a branch."""
    low, high = sorted((before.state.speed, after.state.speed))
    speeds = way.scan.speeds
    for place in range(int(np.searchsorted(speeds, low)), int(np.searchsorted(speeds, high, side="right"))):
        asked = int(way.scan.asked[place])
        if asked >= 0 and speeds[place] != before.state.speed:
            found = _between(way, before, after, float(speeds[place]), harmonics)
            if found is not None:
                way.crossings[asked].append(Crossing(solution=found, run=run))


def _between(way: _Way, before: PathPoint, after: PathPoint, speed: float, harmonics: int) -> Solution | None:
    """The solution of a branch at a speed between two of its points."""
    a, b = before.state, after.state
    part = (speed - a.speed) / (b.speed - a.speed)
    guess = a.y + part * (b.y - a.y)
    backward = before.onward + after.onward < 0
    fixed = way.fixed is not None
    given = before.given
    found = solution(way.levels, guess, speed, given=given, harmonics=harmonics, fixed=fixed, backward=backward)
    far = _BETWEEN * max(float(np.linalg.norm(a.y - b.y)), 1e-3 * dynamic_size(a.y))
    if found is not None and _distance(found, given, guess) <= far:
        return found
    near = _secant(before, after, speed)
    if near is None:
        return None
    return solution(way.levels, near.y, speed, given=given, harmonics=harmonics, fixed=True, backward=backward)


def _distance(found: Solution, given: Problem, y: Array) -> float:
    return float(np.linalg.norm(found.state.y - carried(given, found.given, y)))


def _secant(before: PathPoint, after: PathPoint, speed: float) -> State | None:
    """A point of the branch next to a speed, by steps along it."""
    unit = _unit(before.state)
    low, high = 0.0, after.length - before.length
    ends = [before.state.speed - speed, after.state.speed - speed]
    best: State | None = None
    for _ in range(_SECANTS):
        size = low + (high - low) * ends[0] / (ends[0] - ends[1])
        trial = step_from(before, size, unit)
        if trial is None:
            return best
        best = trial[0].state
        if abs(best.speed - speed) < 1e-9 * speed:
            break
        if np.sign(best.speed - speed) == np.sign(ends[0]):
            low, ends[0] = size, best.speed - speed
        else:
            high, ends[1] = size, best.speed - speed
    return best


def _as_solution(levels: Levels, point: PathPoint, harmonics: int) -> Solution:
    residual = levels.residual(point.given, point.state, harmonics)
    return Solution(
        given=point.given,
        harmonics=harmonics,
        state=point.state,
        residual=residual,
        backward=point.onward < _FLAT,
    )


def _other_linear(way: _Way, behind: int) -> None:
    """Closed solutions at speeds that a branch has passed without meeting them: parts of their own."""
    for place in range(behind):
        at, asked = way.scan.solutions[place], int(way.scan.asked[place])
        if at is None or asked < 0:
            continue
        known = way.crossings[asked]
        if not any(not apart(each.solution, at) for each in known):
            known.append(Crossing(solution=at, run=-1 - asked))
