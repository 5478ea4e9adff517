"""Newton corrector of the balance at a fixed speed: preconditioned GMRES [knoll2004; saad1986], and a line search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...questions.response.gmres import gmres_of_one
from ...system.system import Array
from .preconditioner import KeptPreconditioner
from .problem import Problem, State, dynamic_size, evaluate, jacobian, unknowns

__all__ = [
    "TOLERANCE",
    "WORK",
    "NewtonResult",
    "NewtonStep",
    "linear_start",
    "newton_step",
    "solve",
]

NewtonStep = Callable[[Problem, State, Array, float], tuple[Array, int]]
"""Solves the linearised balance for a right side to a target, and counts the products."""

# |R| per dynamic size that is a solution: far below what truncation leaves (`refinement`, `truncation`).
TOLERANCE = 1e-6
# Jacobian-vector products before a point counts as lost: three times what the hardest that succeed take.
WORK = 300
# Newton steps before a point counts as lost; halvings of one step, down to 1/32 of it.
_STEPS, _HALVINGS = 20, 6
# Part of the promised decrease that a step must bring: a sufficient decrease, as of Armijo.
_DECREASE = 0.1
# Part of the residual wanted below which GMRES need not solve: the last Newton step is no better for it.
_TARGET = 0.1
# Residual of the GMRES of a step per residual now: each step of a torus is worth about one more digit.
_FORCING = 1e-2


def newton_step(*, forcing: float = _FORCING, restarts: int = 2) -> NewtonStep:
    """A Newton step solved by GMRES to `forcing` of the norm of its right side, or to the target if that is larger.

    Steps that follow one another share their preconditioner while it serves.
    """
    kept = KeptPreconditioner()

    def step(given: Problem, at: State, right: Array, target: float) -> tuple[Array, int]:
        """The step (2, J, n) for a right side (2, J, n), and the Jacobian-vector products it took."""
        inverse, product, shape = kept.at(given, at), jacobian(given, at), right.shape
        start = inverse(right)
        size = float(np.linalg.norm(start))
        found, _, calls = gmres_of_one(
            lambda x: inverse(product(x.reshape(shape))).ravel(),
            start.ravel(),
            target=max(forcing * size, target),
            restarts=restarts,
        )
        kept.calls = calls
        return found.reshape(shape), calls

    return step


def _mesh_step() -> NewtonStep:
    """The step of mesh orders, cheap enough to solve each linear system to three digits."""
    return newton_step(forcing=1e-3, restarts=3)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NewtonResult:
    """Where Newton's method ended.

    state : the last motion.  converged : whether |R| <= tolerance of the dynamic part.  steps : Newton steps.
    calls : Jacobian-vector products.
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
    step: NewtonStep | None = None,
) -> NewtonResult:
    """Newton's method from a motion (2, J, n) at relative speed s.

    Parameters
    ----------
    tolerance : of |R| per dynamic size.  steps : Newton steps at most.  work : Jacobian-vector products at most.
    step : how a Newton step is solved; None: GMRES to 1e-3.
    """
    state, calls = evaluate(given, start, speed), 0
    advance = step or _mesh_step()
    for count in range(steps + 1):
        if not np.isfinite(state.norm):
            break
        size = dynamic_size(state.y)
        if state.norm <= tolerance * size:
            return NewtonResult(state=state, converged=True, steps=count, calls=calls)
        if count == steps or calls > work:
            break
        move, used = advance(given, state, state.residual, _TARGET * tolerance * size)
        calls += used
        lower = _line_search(given, state, move)
        if lower is None:
            break
        state = lower
    return NewtonResult(state=state, converged=False, steps=count, calls=calls)


def _line_search(given: Problem, state: State, move: Array) -> State | None:
    """The first of the halved steps along a move (2, J, n) that lowers |R|, None where none does."""
    factor = 1.0
    for _ in range(_HALVINGS):
        trial = evaluate(given, state.y - factor * move, state.speed)
        if trial.norm < (1 - _DECREASE * factor) * state.norm:
            return trial
        factor /= 2
    return None


def linear_start(given: Problem, speed: float, touching: NDArray[np.bool_] | None = None) -> Array:
    """The linear motion (2, J, n) in which flanks touch all the time or never, to 1e-3: a start for Newton's method.

    Parameters
    ----------
    touching : (F,) the flanks that touch; None: every loaded flank and no far flank.
    """
    pattern = given.rows.sense > 0 if touching is None else touching
    state = evaluate(given, np.zeros(unknowns(given)), speed, touching=pattern)
    return -_mesh_step()(given, state, state.residual, 0.0)[0]
