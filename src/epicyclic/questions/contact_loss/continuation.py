"""Branches of periodic motions over speed: pseudo-arclength continuation through folds [keller1977; seydel2010].

Lengths are measured in (|dy| / motion, ds / speed); both units belong to the path.  A step is taken along the
tangent and corrected at right angles to it, the pair (y, s) by one bordered GMRES.  Newton's method may converge to
another branch with a residual as clean as ever.  Therefore a step also fails where the corrector moves far or the
tangent turns much (derived here).

Folds and the highest point of a branch are located, not stepped over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...system.system import Array
from ..response.balance import gmres_of_one
from .corrector import TOLERANCE, KeptPreconditioner
from .problem import Problem, State, dynamic_size, evaluate, jacobian, speed_derivative

# A step fails when the corrector moves more than this part of it, or the tangent turns more than this (cosine): without
# these guards large steps jump over whole resonances with a clean residual (benchmarks/contact.py).
_FAR, _TURN = 0.5, float(np.cos(np.radians(30.0)))
# A step grows by this after so few Newton steps and so small a move, as a part of it.
_GROW, _QUICK, _NEAR = 1.4, 3, 0.2
# Newton steps of a corrector; residual of the GMRES of a bordered step per right side, and the part of the residual
# wanted below which it need not solve.
_NEWTON, _FORCING, _TARGET = 10, 1e-3, 0.1
# A fold is found when ds/d(length) is below this; so many steps at most, every third of which halves the interval.
_FLAT, _TRIES, _BISECT = 1e-3, 12, 3
# Times the interval about the highest point is halved.
_HALVED = 3

Score = Callable[[State, Problem], float]
"""What a branch has a peak of, such as a force [N]."""
Stop = Callable[["PathPoint"], bool]
"""Whether a branch ends at a point."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArclengthUnit:
    """Units of length of a path: motion [root of energy, as y], speed [relative]."""

    motion: float
    speed: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Stepping:
    """Lengths of steps along a path: first, longest and shortest.

    guarded : whether far moves and sharp turns fail a step.  points : number after which a path ends.
    """

    first: float = 0.25
    longest: float = 0.5
    shortest: float = 1e-5
    guarded: bool = True
    points: int = 4000


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """What the points of a path share: the balance that they solve, units of length, and the preconditioner."""

    balance: Problem
    unit: ArclengthUnit
    kept: KeptPreconditioner


class Tangent(NamedTuple):
    """d(y / motion) (2, J, n) and d(s / speed) per length of a path, together of norm 1."""

    motion: Array
    speed: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PathPoint:
    """A point of a branch of solutions.

    state : the motion.  length : of the path up to here.
    steps, calls : Newton steps and Jacobian-vector products it took.
    """

    path: Path
    state: State
    tangent: Tangent
    length: float
    steps: int
    calls: int


def arclength_unit(low: float, high: float, motion: Array) -> ArclengthUnit:
    """Units of length for speeds in [low, high] about a motion (2, J, n).

    A sixteenth of the middle speed; a fifth of the mean motion, or of its dynamic size where the mean is zero.
    """
    size = float(np.linalg.norm(motion[:, 0])) or dynamic_size(motion)
    return ArclengthUnit(motion=size / 5, speed=float(np.sqrt(low * high)) / 16)


def start_of_path(balance: Problem, state: State, unit: ArclengthUnit, *, upward: bool = True) -> PathPoint:
    """The first point of a path: a solved state and its tangent, up or down in speed."""
    path = Path(balance, unit, KeptPreconditioner())
    tangent, calls = _tangent(path, state, Tangent(np.zeros_like(state.y), 1.0 if upward else -1.0))
    return PathPoint(path=path, state=state, tangent=tangent, length=0.0, steps=0, calls=calls)


def follow(start: PathPoint, low: float, high: float, *, stepping: Stepping) -> Iterator[PathPoint]:
    """Points of a branch from its start until it leaves [low, high] (the last may lie outside) or no step succeeds."""
    at, size = start, stepping.first
    yield at
    for _ in range(stepping.points):
        after, size = _advance(at, size, stepping)
        if after is None:
            return
        at = after
        yield at
        if not low <= at.state.speed <= high:
            return


def _advance(at: PathPoint, size: float, stepping: Stepping) -> tuple[PathPoint | None, float]:
    """The next point, None where even the shortest step fails, and the length of the step after it."""
    while size >= stepping.shortest:
        trial = step_from(at, size, guarded=stepping.guarded)
        if trial is not None:
            point, moved = trial
            quick = point.steps <= _QUICK and (moved < _NEAR * size or not stepping.guarded)
            return point, min(size * _GROW, stepping.longest) if quick else size
        size /= 2
    return None, size


def step_from(at: PathPoint, size: float, *, guarded: bool = True) -> tuple[PathPoint, float] | None:
    """One predictor-corrector step of a given length and how far its corrector moved, None where it fails."""
    unit = at.path.unit
    y = at.state.y + size * unit.motion * at.tangent.motion
    speed = at.state.speed + size * unit.speed * at.tangent.speed
    if speed <= 0:
        return None
    most = _FAR * size if guarded else np.inf
    solved = _corrected(at.path, y, speed, at.tangent, far=most)
    if solved is None:
        return None
    state, steps, calls = solved
    moved = float(np.hypot(np.linalg.norm(state.y - y) / unit.motion, (state.speed - speed) / unit.speed))
    if guarded and moved > most:
        return None
    tangent, used = _tangent(at.path, state, at.tangent)
    turned = float(np.vdot(tangent.motion, at.tangent.motion)) + tangent.speed * at.tangent.speed
    if guarded and turned < _TURN:
        return None
    length = at.length + size
    return PathPoint(path=at.path, state=state, tangent=tangent, length=length, steps=steps, calls=calls + used), moved


def _corrected(path: Path, y: Array, speed: float, tangent: Tangent, *, far: float) -> tuple[State, int, int] | None:
    """The solution on the plane through (y, s) normal to a tangent, by Newton's method.

    Parameters
    ----------
    far : length of the correction beyond which the step is given up.

    Returns
    -------
    (state, Newton steps, Jacobian-vector products), None where Newton's method fails.
    """
    balance, unit = path.balance, path.unit
    state, moved_y, moved_s, calls = evaluate(balance, y, speed), np.zeros_like(y), 0.0, 0
    for count in range(_NEWTON + 1):
        if not np.isfinite(state.norm):
            return None
        size = dynamic_size(state.y)
        if state.norm <= TOLERANCE * size:
            return state, count, calls
        target = _TARGET * TOLERANCE * size / unit.motion
        step, ds, used = _bordered(path, state, tangent, state.residual / unit.motion, 0.0, target)
        moved_y, moved_s, calls = moved_y + step, moved_s + ds, calls + used
        if np.hypot(np.linalg.norm(moved_y), moved_s) > 2 * far or speed - moved_s * unit.speed <= 0:
            return None
        state = evaluate(balance, y - unit.motion * moved_y, speed - moved_s * unit.speed)
    return None


def _tangent(path: Path, state: State, side: Tangent) -> tuple[Tangent, int]:
    """Unit tangent of the branch at a solved state, on the side of another one, and the products it took."""
    step, ds, calls = _bordered(path, state, side, np.zeros_like(state.y), 1.0, 0.0)
    size = float(np.hypot(np.linalg.norm(step), ds))
    return Tangent(step / size, ds / size), calls


def _bordered(
    path: Path, at: State, tangent: Tangent, right: Array, last: float, target: float
) -> tuple[Array, float, int]:
    """Solve [R_y R_s; tangent] (y, s) = (right, last) in scaled unknowns, to 1e-3 of the right side.

    right : (2, J, n).  target : norm of the residual that is enough.  Returns (y (2, J, n), s, products).
    """
    balance, unit, kept = path.balance, path.unit, path.kept
    shape, border = at.y.shape, tangent.motion.ravel()
    inverse, product = kept.at(balance, at), jacobian(balance, at)
    by_speed = (inverse(speed_derivative(balance, at)) * (unit.speed / unit.motion)).ravel()

    def apply(x: Array) -> Array:
        """Product (2 J n + 1,) with the preconditioned bordered matrix."""
        out = np.empty_like(x)
        step, ds = x[:-1], float(x[-1])
        np.add(inverse(product(step.reshape(shape))).ravel(), ds * by_speed, out=out[:-1])
        out[-1] = border @ step + tangent.speed * ds
        return out

    whole = np.append(inverse(right).ravel(), last)
    wanted = max(_FORCING * float(np.linalg.norm(whole)), target)
    x, _, calls = gmres_of_one(apply, whole, target=wanted, restarts=3)
    kept.calls = calls
    return x[:-1].reshape(shape), float(x[-1]), calls


def branch(
    balance: Problem,
    start: State,
    *,
    low: float,
    high: float,
    unit: ArclengthUnit,
    stepping: Stepping,
    score: Score,
    stop: Stop | None = None,
) -> list[PathPoint]:
    """Points of the branch through a solved state, up in speed, with its folds and its highest score among them.

    Parameters
    ----------
    score : what has a peak that must not be missed.  stop : ends the branch at a point before it leaves [low, high].
    """
    points = list[PathPoint]()
    for point in follow(start_of_path(balance, start, unit), low, high, stepping=stepping):
        points.append(point)
        if stop is not None and stop(point):
            break
    return _with_peak(_with_folds(points), score)


def folds(points: list[PathPoint]) -> list[int]:
    """Places of folds among points: of a pair whose tangents differ in direction of speed the flatter one."""
    slope = np.array([point.tangent.speed for point in points])
    places = np.flatnonzero(np.sign(slope[1:]) != np.sign(slope[:-1]))
    return [int(i if abs(slope[i]) <= abs(slope[i + 1]) else i + 1) for i in places]


def folds_of_speed(speeds: list[float]) -> list[float]:
    """Speeds at which a rising or falling row of speeds turns round."""
    rise = np.diff(np.array(speeds))
    places = np.flatnonzero(np.sign(rise[1:]) != np.sign(rise[:-1])) + 1
    return [float(speeds[int(place)]) for place in places]


def _with_folds(points: list[PathPoint]) -> list[PathPoint]:
    """The points, with one more at every fold, where ds/d(length) is zero."""
    result = points[:1]
    for before, after in pairwise(points):
        if np.sign(before.tangent.speed) != np.sign(after.tangent.speed):
            fold = located(
                before, after, lambda point: point.tangent.speed, tolerance=_FLAT, tries=_TRIES, bisect=_BISECT
            )
            result += [] if fold is None else [fold]
        result.append(after)
    return result


def located(
    before: PathPoint,
    after: PathPoint,
    value: Callable[[PathPoint], float],
    *,
    tolerance: float,
    tries: int,
    bisect: int = 0,
) -> PathPoint | None:
    """The point between two of a branch at which a value is zero, by false position over the length of one step.

    Parameters
    ----------
    tolerance : |value| at which the point is found; after so many `tries` the last point stands.
    bisect : every so many tries the interval is halved instead, from the first one on; 0: never.

    Returns
    -------
    The last point reached, None where no step from the first one succeeds.
    """
    low, high, ends = 0.0, after.length - before.length, [value(before), value(after)]
    best: PathPoint | None = None
    for count in range(tries):
        halve = bisect > 0 and count % bisect == 0
        size = (low + high) / 2 if halve else low + (high - low) * ends[0] / (ends[0] - ends[1])
        trial = step_from(before, size)
        if trial is None:
            return best
        best, reached = trial[0], value(trial[0])
        if abs(reached) < tolerance:
            break
        if np.sign(reached) == np.sign(ends[0]):
            low, ends[0] = size, reached
        else:
            high, ends[1] = size, reached
    return best


def peak_of(points: list[PathPoint], score: Score) -> int:
    """Place of the highest score."""
    return int(np.argmax([score(point.state, point.path.balance) for point in points]))


def _with_peak(points: list[PathPoint], score: Score) -> list[PathPoint]:
    """The points, with more about the highest score, the steps there halved."""
    points = list(points)
    for _ in range(_HALVED):
        top = peak_of(points, score)
        for place in (top, top - 1):
            if 0 <= place < len(points) - 1:
                half = (points[place + 1].length - points[place].length) / 2
                middle = step_from(points[place], half) if half > 0 else None
                points[place + 1 : place + 1] = [] if middle is None else [middle[0]]
    return points
