"""Branches of periodic motions over speed: pseudo-arclength continuation through folds [keller1977; seydel2010].

Lengths are measured in (|dy| / motion, ds / speed); both units are given with the path.  A step is taken along the
tangent and corrected at right angles to it, the pair (y, s) by one bordered GMRES.  Newton's method may converge to
another branch with a residual as clean as ever.  Therefore a step also fails where the corrector moves far or the
tangent turns much (derived here).

Folds and the highest point of a branch are located, not stepped over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...system.system import Array
from ..response.gmres import gmres_of_one
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PathPoint:
    """A point of a branch of solutions of `given`.

    state : the motion.  tangent : (2, J, n) and tangent_speed : d(y / motion) and d(s / speed) per length, together of
        norm 1.
    length : of the path up to here.  steps, calls : Newton steps and Jacobian-vector products it took.
    kept : the preconditioner that points of one path share.
    """

    given: Problem
    state: State
    tangent: Array
    tangent_speed: float
    length: float
    steps: int
    calls: int
    kept: KeptPreconditioner


def arclength_unit(low: float, high: float, motion: Array) -> ArclengthUnit:
    """Units of length for speeds in [low, high] about a motion (2, J, n).

    A sixteenth of the middle speed; a fifth of the mean motion, or of its dynamic size where the mean is zero.
    """
    size = float(np.linalg.norm(motion[:, 0])) or dynamic_size(motion)
    return ArclengthUnit(motion=size / 5, speed=float(np.sqrt(low * high)) / 16)


def start_of_path(given: Problem, state: State, unit: ArclengthUnit, *, upward: bool = True) -> PathPoint:
    """The first point of a path: a solved state and its tangent, up or down in speed."""
    kept = KeptPreconditioner()
    tangent, tangent_speed, calls = _tangent(given, state, np.zeros_like(state.y), 1.0 if upward else -1.0, unit, kept)
    return PathPoint(
        given=given,
        state=state,
        tangent=tangent,
        tangent_speed=tangent_speed,
        length=0.0,
        steps=0,
        calls=calls,
        kept=kept,
    )


def follow(
    start: PathPoint, low: float, high: float, *, unit: ArclengthUnit, stepping: Stepping
) -> Iterator[PathPoint]:
    """Points of a branch from its start until it leaves [low, high] (the last may lie outside) or no step succeeds."""
    at, size = start, stepping.first
    yield at
    for _ in range(stepping.points):
        found, size = _advance(at, size, unit, stepping)
        if found is None:
            return
        at, size = found, size
        yield at
        if not low <= at.state.speed <= high:
            return


def _advance(at: PathPoint, size: float, unit: ArclengthUnit, stepping: Stepping) -> tuple[PathPoint | None, float]:
    """The next point, None where even the shortest step fails, and the length of the step after it."""
    while size >= stepping.shortest:
        trial = step_from(at, size, unit, guarded=stepping.guarded)
        if trial is not None:
            point, moved = trial
            quick = point.steps <= _QUICK and (moved < _NEAR * size or not stepping.guarded)
            return point, min(size * _GROW, stepping.longest) if quick else size
        size /= 2
    return None, size


def step_from(
    at: PathPoint, size: float, unit: ArclengthUnit, *, guarded: bool = True
) -> tuple[PathPoint, float] | None:
    """One predictor-corrector step of a given length and how far its corrector moved, None where it fails."""
    given = at.given
    y = at.state.y + size * unit.motion * at.tangent
    speed = at.state.speed + size * unit.speed * at.tangent_speed
    if speed <= 0:
        return None
    most = _FAR * size if guarded else np.inf
    found = corrected(given, y, speed, at.tangent, at.tangent_speed, unit, far=most, kept=at.kept)
    if found is None:
        return None
    state, steps, calls = found
    moved = float(np.hypot(np.linalg.norm(state.y - y) / unit.motion, (state.speed - speed) / unit.speed))
    if guarded and moved > most:
        return None
    tangent, tangent_speed, used = _tangent(given, state, at.tangent, at.tangent_speed, unit, at.kept)
    turned = float(np.vdot(tangent, at.tangent)) + tangent_speed * at.tangent_speed
    if guarded and turned < _TURN:
        return None
    point = PathPoint(
        given=given,
        state=state,
        tangent=tangent,
        tangent_speed=tangent_speed,
        length=at.length + size,
        steps=steps,
        calls=calls + used,
        kept=at.kept,
    )
    return point, moved


def corrected(
    given: Problem,
    y: Array,
    speed: float,
    tangent: Array,
    tangent_speed: float,
    unit: ArclengthUnit,
    *,
    far: float = np.inf,
    kept: KeptPreconditioner | None = None,
) -> tuple[State, int, int] | None:
    """The solution on the plane through (y, s) normal to a tangent (2, J, n), by Newton's method.

    Parameters
    ----------
    far : length of the correction beyond which the step is given up.  kept : of the path, None: one of its own.

    Returns
    -------
    (state, Newton steps, Jacobian-vector products), None where Newton's method fails.
    """
    state, moved_y, moved_s, calls = evaluate(given, y, speed), np.zeros_like(y), 0.0, 0
    kept = kept or KeptPreconditioner()
    for count in range(_NEWTON + 1):
        if not np.isfinite(state.norm):
            return None
        size = dynamic_size(state.y)
        if state.norm <= TOLERANCE * size:
            return state, count, calls
        target = _TARGET * TOLERANCE * size / unit.motion
        step, ds, used = _bordered(
            given, state, tangent, tangent_speed, unit, state.residual / unit.motion, 0.0, target, kept
        )
        moved_y, moved_s, calls = moved_y + step, moved_s + ds, calls + used
        if np.hypot(np.linalg.norm(moved_y), moved_s) > 2 * far or speed - moved_s * unit.speed <= 0:
            return None
        state = evaluate(given, y - unit.motion * moved_y, speed - moved_s * unit.speed)
    return None


def _tangent(
    given: Problem, state: State, tangent: Array, tangent_speed: float, unit: ArclengthUnit, kept: KeptPreconditioner
) -> tuple[Array, float, int]:
    """Unit tangent (2, J, n) and (1,) of the branch at a solved state, on the side of a given one."""
    step, ds, calls = _bordered(given, state, tangent, tangent_speed, unit, np.zeros_like(state.y), 1.0, 0.0, kept)
    size = float(np.hypot(np.linalg.norm(step), ds))
    return step / size, ds / size, calls


def _bordered(
    given: Problem,
    at: State,
    tangent: Array,
    tangent_speed: float,
    unit: ArclengthUnit,
    right: Array,
    last: float,
    target: float,
    kept: KeptPreconditioner,
) -> tuple[Array, float, int]:
    """Solve [R_y R_s; tangent tangent_speed] (y, s) = (right, last) in scaled unknowns, to 1e-3 of the right side.

    right : (2, J, n).  target : norm of the residual that is enough.  Returns (y (2, J, n), s, products).
    """
    shape, border = at.y.shape, tangent.ravel()
    inverse, product = kept.at(given, at), jacobian(given, at)
    by_speed = (inverse(speed_derivative(given, at)) * (unit.speed / unit.motion)).ravel()

    def apply(x: Array) -> Array:
        """Product (2 J n + 1,) with the preconditioned bordered matrix."""
        out = np.empty_like(x)
        step, ds = x[:-1], float(x[-1])
        np.add(inverse(product(step.reshape(shape))).ravel(), ds * by_speed, out=out[:-1])
        out[-1] = border @ step + tangent_speed * ds
        return out

    whole = np.append(inverse(right).ravel(), last)
    wanted = max(_FORCING * float(np.linalg.norm(whole)), target)
    found, _, calls = gmres_of_one(apply, whole, target=wanted, restarts=3)
    kept.calls = calls
    return found[:-1].reshape(shape), float(found[-1]), calls


def branch(
    given: Problem,
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
    for point in follow(start_of_path(given, start, unit), low, high, unit=unit, stepping=stepping):
        points.append(point)
        if stop is not None and stop(point):
            break
    return _with_peak(_with_folds(points, unit), unit, score)


def folds(points: list[PathPoint]) -> list[int]:
    """Places of folds among points: of a pair whose tangents differ in direction of speed the flatter one."""
    tangent_speed = np.array([point.tangent_speed for point in points])
    places = np.flatnonzero(np.sign(tangent_speed[1:]) != np.sign(tangent_speed[:-1]))
    return [int(i if abs(tangent_speed[i]) <= abs(tangent_speed[i + 1]) else i + 1) for i in places]


def folds_of_speed(speeds: list[float]) -> list[float]:
    """Speeds at which a rising or falling row of speeds turns round."""
    rise = np.diff(np.array(speeds))
    places = np.flatnonzero(np.sign(rise[1:]) != np.sign(rise[:-1])) + 1
    return [float(speeds[int(place)]) for place in places]


def _with_folds(points: list[PathPoint], unit: ArclengthUnit) -> list[PathPoint]:
    """The points, with one more at every fold."""
    result = points[:1]
    for before, after in pairwise(points):
        if np.sign(before.tangent_speed) != np.sign(after.tangent_speed):
            at = located(before, after, _slope, unit=unit, tolerance=_FLAT, tries=_TRIES, bisect=_BISECT)
            result += [] if at is None else [at]
        result.append(after)
    return result


def _slope(point: PathPoint) -> float:
    """ds/d(length), zero at a fold."""
    return point.tangent_speed


def located(
    before: PathPoint,
    after: PathPoint,
    value: Callable[[PathPoint], float],
    *,
    unit: ArclengthUnit,
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
        trial = step_from(before, size, unit)
        if trial is None:
            return best
        best, here = trial[0], value(trial[0])
        if abs(here) < tolerance:
            break
        if np.sign(here) == np.sign(ends[0]):
            low, ends[0] = size, here
        else:
            high, ends[1] = size, here
    return best


def peak_of(points: list[PathPoint], score: Score) -> int:
    """Place of the highest score."""
    return int(np.argmax([score(point.state, point.given) for point in points]))


def _with_peak(points: list[PathPoint], unit: ArclengthUnit, score: Score) -> list[PathPoint]:
    """The points, with more about the highest score, the steps there halved."""
    points = list(points)
    for _ in range(_HALVED):
        top = peak_of(points, score)
        for place in (top, top - 1):
            if 0 <= place < len(points) - 1:
                half = (points[place + 1].length - points[place].length) / 2
                middle = step_from(points[place], half, unit) if half > 0 else None
                points[place + 1 : place + 1] = [] if middle is None else [middle[0]]
    return points
