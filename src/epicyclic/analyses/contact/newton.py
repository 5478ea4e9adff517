"""One point of the balance with contact loss: Newton steps by GMRES, a line search, and what to try when they fail."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...system.system import Array
from ..harmonic.gmres import gmres
from .balance import Problem, State, evaluate, slope, unknowns

__all__ = ["TOLERANCE", "Found", "Step", "dynamic_size", "linear_start", "solve", "solve_step"]

TOLERANCE = 1e-6
Step = Callable[[Problem, State, Array, float], tuple[Array, int]]
"""Solves the linearised balance for a right side to a target, and counts the products."""
# Newton steps before a point counts as lost; halvings of one step; residual of its GMRES per residual now.
_STEPS, _HALVINGS, _FORCING = 20, 6, 1e-3
# Products with the derivative before a point counts as lost: three times what the hardest that succeed take.
_WORK = 300


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Found:
    """What became of a point.

    state : where it ended.  converged : whether |R| <= tolerance of the dynamic part.  steps : Newton steps.
    calls : products with the derivative.
    """

    state: State
    converged: bool
    steps: int
    calls: int


def solve(
    given: Problem,
    start: Array,
    speed: float,
    *,
    tolerance: float = TOLERANCE,
    steps: int = _STEPS,
    step: Step | None = None,
) -> Found:
    """Newton's method from a motion (2, J, n) at relative speed s, with `solve_step` or another one."""
    state, calls = evaluate(given, start, speed), 0
    for count in range(steps + 1):
        if not np.isfinite(state.norm):
            break
        size = dynamic_size(state.y)
        if state.norm <= tolerance * size:
            return Found(state=state, converged=True, steps=count, calls=calls)
        if count == steps or calls > _WORK:
            break
        move, used = (step or _step)(given, state, state.residual, 0.1 * tolerance * size)
        calls += used
        lower = _lowered(given, state, move)
        if lower is None:
            break
        state = lower
    return Found(state=state, converged=False, steps=count, calls=calls)


def _step(given: Problem, at: State, right: Array, target: float) -> tuple[Array, int]:
    return solve_step(given, at, right, target=target)


def solve_step(given: Problem, at: State, right: Array, *, target: float = 0.0) -> tuple[Array, int]:
    """Solve the linearised balance for a right side (2, J, n), to 1e-3 of it or the target."""
    shape = unknowns(given)

    def apply(x: Array) -> Array:
        return slope(given, at, x.reshape(shape)).reshape(1, -1)

    size = float(np.linalg.norm(right))
    found, _, calls = gmres(apply, right.reshape(1, -1), target=np.array([max(_FORCING * size, target)]), restarts=3)
    return found.reshape(shape), calls


def _lowered(given: Problem, state: State, move: Array) -> State | None:
    """The first of the halved steps that lowers |R|, None where none does."""
    factor = 1.0
    for _ in range(_HALVINGS):
        trial = evaluate(given, state.y - factor * move, state.speed)
        if trial.norm < (1 - 0.1 * factor) * state.norm:
            return trial
        factor /= 2
    return None


def dynamic_size(y: Array) -> float:
    """Size of the part of a motion that varies, at least 1e-6 of the whole."""
    varying = float(np.linalg.norm(y[:, 1:]))
    return max(varying, 1e-6 * float(np.linalg.norm(y)), np.finfo(float).tiny)


def linear_start(given: Problem, speed: float) -> Array:
    """The motion (2, J, n) with every loaded flank closed and no far flank, to 1e-3: where to begin."""
    zero, closed = np.zeros(unknowns(given)), np.broadcast_to(given.flanks.sense > 0, given.stiffness.shape)
    state = evaluate(given, zero, speed, touching=closed)
    return zero - solve_step(given, state, state.residual)[0]
