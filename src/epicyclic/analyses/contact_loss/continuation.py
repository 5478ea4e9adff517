"""A branch of periodic motions followed over speed by pseudo-arclength, through folds, with guards.

Lengths are measured in (|dy| / motion, ds / speed): both units are given with the path.  A step is taken along the
tangent and corrected at right angles to it, the pair (y, s) by one bordered GMRES.  Newton's method may converge to
another branch, its residual as clean as ever: therefore a step also counts as failed when the corrector moves far or
the tangent turns much.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...system.system import Array
from ..steady.gmres import gmres
from .corrector import TOLERANCE, dynamic_size
from .preconditioner import nearly_inverse
from .problem import Problem, State, derivative, evaluate, linearised

__all__ = ["Measure", "PathPoint", "Stepping", "corrected", "follow", "measure", "start_of_path", "step_from"]

# A step fails when the corrector moves more than this part of it, or the tangent turns more than this (cosine).
_FAR, _TURN = 0.5, float(np.cos(np.radians(30.0)))
# It grows by this after so few Newton steps and so small a move.
_GROW, _QUICK, _NEAR = 1.4, 3, 0.2
_NEWTON = 10
_FORCING = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """Units of length of a path: motion [root of energy, as y], speed [relative]."""

    motion: float
    speed: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Stepping:
    """Lengths of steps: first, longest and shortest.

    guarded : whether far moves and sharp turns fail a step.  points : after so many a path ends.
    """

    first: float = 0.25
    longest: float = 0.5
    shortest: float = 1e-3
    guarded: bool = True
    points: int = 4000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PathPoint:
    """A point of a branch of solutions of `given`.

    state : the motion.  along : (2, J, n) and onward : how y / motion and s / speed go on, together of length 1.
    length : of the path up to here.  steps, calls : Newton steps and products with the derivative it took.
    """

    given: Problem
    state: State
    along: Array
    onward: float
    length: float
    steps: int
    calls: int


def measure(low: float, high: float, motion: Array) -> Measure:
    """Units for a range of speeds: a sixteenth of its middle speed, a fifth of the mean of a motion (2, J, n)."""
    size = float(np.linalg.norm(motion[:, 0])) or dynamic_size(motion)
    return Measure(motion=size / 5, speed=float(np.sqrt(low * high)) / 16)


def start_of_path(given: Problem, state: State, unit: Measure, *, upward: bool = True) -> PathPoint:
    """The first point of a path: a solved state, going up or down in speed."""
    along, onward, calls = _tangent(given, state, np.zeros_like(state.y), 1.0 if upward else -1.0, unit)
    return PathPoint(given=given, state=state, along=along, onward=onward, length=0.0, steps=0, calls=calls)


def follow(start: PathPoint, low: float, high: float, *, unit: Measure, stepping: Stepping) -> Iterator[PathPoint]:
    """Points of a branch from the start until it leaves [low, high] (the last one may lie outside) or no step works."""
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


def _advance(at: PathPoint, size: float, unit: Measure, stepping: Stepping) -> tuple[PathPoint | None, float]:
    """The next point, None where even the shortest step fails, and the length of the step after it."""
    while size >= stepping.shortest:
        # a corner of the sampled contact turns at any length: at the shortest, the turn alone fails no step
        cornering = size < 2 * stepping.shortest
        trial = step_from(at, size, unit, guarded=stepping.guarded, cornering=cornering)
        if trial is not None:
            point, moved = trial
            quick = point.steps <= _QUICK and (moved < _NEAR * size or not stepping.guarded)
            return point, min(size * _GROW, stepping.longest) if quick else size
        size /= 2
    return None, size


def step_from(
    at: PathPoint, size: float, unit: Measure, *, guarded: bool = True, cornering: bool = False
) -> tuple[PathPoint, float] | None:
    """One step of a given length and how far its corrector moved, None where it fails.

    cornering : any turn below a right angle is allowed.
    """
    given = at.given
    y = at.state.y + size * unit.motion * at.along
    speed = at.state.speed + size * unit.speed * at.onward
    if speed <= 0:
        return None
    found = corrected(given, y, speed, at.along, at.onward, unit, far=_FAR * size if guarded else np.inf)
    if found is None:
        return None
    state, steps, calls = found
    moved = float(np.hypot(np.linalg.norm(state.y - y) / unit.motion, (state.speed - speed) / unit.speed))
    if guarded and moved > _FAR * size:
        return None
    along, onward, used = _tangent(given, state, at.along, at.onward, unit)
    turned = float(np.vdot(along, at.along)) + onward * at.onward
    if guarded and turned < (0.0 if cornering else _TURN):
        return None
    point = PathPoint(
        given=given,
        state=state,
        along=along,
        onward=onward,
        length=at.length + size,
        steps=steps,
        calls=calls + used,
    )
    return point, moved


def corrected(
    given: Problem, y: Array, speed: float, along: Array, onward: float, unit: Measure, *, far: float = np.inf
) -> tuple[State, int, int] | None:
    """The solution on the plane through (y, s) at right angles to a direction; None where Newton's method fails.

    far : distance at which it is given up.
    """
    state, moved_y, moved_s, calls = evaluate(given, y, speed), np.zeros_like(y), 0.0, 0
    for count in range(_NEWTON + 1):
        if not np.isfinite(state.norm):
            return None
        size = dynamic_size(state.y)
        if state.norm <= TOLERANCE * size:
            return state, count, calls
        target = 0.1 * TOLERANCE * size / unit.motion
        step, ds, used = _bordered(given, state, along, onward, unit, state.residual / unit.motion, 0.0, target)
        moved_y, moved_s, calls = moved_y + step, moved_s + ds, calls + used
        if np.hypot(np.linalg.norm(moved_y), moved_s) > 2 * far or speed - moved_s * unit.speed <= 0:
            return None
        state = evaluate(given, y - unit.motion * moved_y, speed - moved_s * unit.speed)
    return None


def _tangent(given: Problem, state: State, along: Array, onward: float, unit: Measure) -> tuple[Array, float, int]:
    """Unit direction of the branch, on the side of the given one."""
    step, ds, calls = _bordered(given, state, along, onward, unit, np.zeros_like(state.y), 1.0, 0.0)
    size = float(np.hypot(np.linalg.norm(step), ds))
    return step / size, ds / size, calls


def _bordered(
    given: Problem,
    at: State,
    along: Array,
    onward: float,
    unit: Measure,
    right: Array,
    last: float,
    target: float,
) -> tuple[Array, float, int]:
    """Solve [R_y R_s; along onward] (y, s) = (right, last) in scaled unknowns, to 1e-3 of the right side."""
    shape, border = at.y.shape, along.ravel()
    inverse, product = nearly_inverse(given, at), linearised(given, at)
    by_speed = (inverse(derivative(given, at)) * (unit.speed / unit.motion)).ravel()

    def apply(x: Array) -> Array:
        out = np.empty_like(x)
        step, ds = x[0, :-1], x[0, -1]
        out[0, :-1] = inverse(product(step.reshape(shape))).ravel() + ds * by_speed
        out[0, -1] = border @ step + onward * ds
        return out

    whole = np.append(inverse(right).ravel(), last)
    wanted = max(_FORCING * float(np.linalg.norm(whole)), target)
    found, _, calls = gmres(apply, whole[None], target=np.array([wanted]), restarts=3)
    return found[0, :-1].reshape(shape), float(found[0, -1]), calls
