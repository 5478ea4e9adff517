"""One point of the balance with contact loss: Newton steps by GMRES, a line search, and what to try when they fail."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from .preconditioner import Step, preconditioned
from .problem import Problem, State, evaluate, unknowns

__all__ = ["TOLERANCE", "WORK", "Found", "dynamic_size", "linear_start", "solve"]

TOLERANCE = 1e-6
# Newton steps before a point counts as lost; halvings of one step.
_STEPS, _HALVINGS = 20, 6
# Residual of the GMRES of a step per residual now.
_STEP = preconditioned(forcing=1e-3, restarts=3)
# Products with the derivative before a point counts as lost: three times what the hardest that succeed take.
WORK = 300


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
    work: int = WORK,
    step: Step | None = None,
) -> Found:
    """Newton's method from a motion (2, J, n) at relative speed s, with at most so many steps and products."""
    state, calls = evaluate(given, start, speed), 0
    for count in range(steps + 1):
        if not np.isfinite(state.norm):
            break
        size = dynamic_size(state.y)
        if state.norm <= tolerance * size:
            return Found(state=state, converged=True, steps=count, calls=calls)
        if count == steps or calls > work:
            break
        move, used = (step or _STEP)(given, state, state.residual, 0.1 * tolerance * size)
        calls += used
        lower = _lowered(given, state, move)
        if lower is None:
            break
        state = lower
    return Found(state=state, converged=False, steps=count, calls=calls)


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


def linear_start(given: Problem, speed: float, touching: NDArray[np.bool_] | None = None) -> Array:
    """The motion (2, J, n) in which flanks (R,) touch all the time or never, to 1e-3: where to begin.

    touching : None: every loaded flank and no far flank.
    """
    pattern = given.flanks.sense > 0 if touching is None else touching
    state = evaluate(given, np.zeros(unknowns(given)), speed, touching=np.broadcast_to(pattern, given.stiffness.shape))
    return -_STEP(given, state, state.residual, 0.0)[0]
