"""Newton corrector of the balance at a fixed speed: GMRES with a preconditioner [knoll2004], and a line search.

Preconditioner: at every lattice point the mean tangent stands for the sampled contact.  Without what couples lattice
points and modes the linearised balance is y + D^-1 pulls^T T gaps y = r, T the mean tangent less k0.  Its inverse is
y = r - D^-1 pulls^T T (I + P T)^-1 gaps r with P = gaps D^-1 pulls^T, the receptance of the meshes: a small matrix at
every point (Woodbury's identity).  Preconditioned GMRES [saad1986] then needs about as many products as with closed
flanks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray
from ..steady.gmres import gmres_of_one
from .problem import Problem, State, dynamic_size, evaluate, jacobian, unknowns

__all__ = [
    "TOLERANCE",
    "WORK",
    "NewtonResult",
    "NewtonStep",
    "linear_start",
    "newton_step",
    "preconditioner",
    "solve",
]

Index = NDArray[np.int64]
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
# Change of the mean tangent, per k0, and receptance times tangent of a point, below which they do nothing.  Only
# the number of products depends on them.
_SAME, _STIFF = 1e-3, 0.05
# Rounding of a bound of some hundred terms, with a wide margin.
_ROUNDING = 1e-9


def newton_step(*, forcing: float = _FORCING, restarts: int = 2) -> NewtonStep:
    """A Newton step solved by GMRES to `forcing` of the norm of its right side, or to the target if that is larger."""

    def step(given: Problem, at: State, right: Array, target: float) -> tuple[Array, int]:
        """The step (2, J, n) for a right side (2, J, n), and the Jacobian-vector products it took."""
        inverse, product, shape = preconditioner(given, at), jacobian(given, at), right.shape
        start = inverse(right)
        size = float(np.linalg.norm(start))
        found, _, calls = gmres_of_one(
            lambda x: inverse(product(x.reshape(shape))).ravel(),
            start.ravel(),
            target=max(forcing * size, target),
            restarts=restarts,
        )
        return found.reshape(shape), calls

    return step


def _meshes(given: Problem) -> tuple[Array, Array]:
    """Gaps and pulls (w, n) of whole meshes, their slices weighted by their stiffness k0, and of link rows."""
    rows, face, m = given.rows, given.face, len(given.face.row)
    share = (rows.linear[:m] / face.total(rows.linear[:m])[face.row])[:, None]
    gaps, pulls = face.total(share * rows.gaps[:m]), face.total(share * rows.pulls[:m])
    if rows.links is None:
        return gaps, pulls
    return np.concatenate([gaps, rows.gaps[rows.count :]]), np.concatenate([pulls, rows.pulls[rows.count :]])


def _soft_points(at: State, gaps: Array, pulls: Array, T: ComplexArray) -> tuple[Index, ComplexArray]:
    """Lattice points (k,) at which receptance times tangent T (J, w) matters, and that product there (k, w, w)."""
    real, imag = at.inverse[0], -at.inverse[1][0]
    # no product is above the sum over modes of its largest factors: most points are left out by that
    most = np.abs(gaps).max(axis=0) * np.abs(pulls).max(axis=0)
    bound = (np.hypot(real, imag) @ most) * np.abs(T).max(axis=1)
    near = np.flatnonzero(bound > _STIFF * (1 - _ROUNDING))
    factor = np.stack([real[near], imag[near]])[:, :, None, :]
    real, imag = ((factor * gaps).reshape(-1, gaps.shape[1]) @ pulls.T).reshape(2, near.size, len(gaps), len(pulls))
    loop = (real + 1j * imag) * T[near][:, None, :]
    soft = np.abs(loop).max(axis=(1, 2)) > _STIFF
    return near[soft], loop[soft]


def preconditioner(given: Problem, at: State) -> Callable[[Array], Array]:
    """The approximate inverse of the Jacobian at a state, an operator on (2, J, n)."""
    rows, face, m = given.rows, given.face, len(given.face.row)
    touching, held = at.touching[:, :m], rows.linear[:m]
    tangent = face.total(at.tangent[:, :m].mean(axis=0) - held)
    links = at.tangent[:, rows.count :].mean(axis=0) - rows.linear[rows.count :]
    if np.all(np.abs(tangent) <= _SAME * face.total(held)) and np.all(np.abs(links) <= _SAME * _largest(rows.linear)):
        return lambda right: right
    (gaps, pulls), w = _meshes(given), at.speed * given.omega
    drag = face.total((touching.mean(axis=0) - 1.0) * rows.drag[:m])
    tangent, drag = np.concatenate([tangent, links]), np.concatenate([drag, rows.lag[rows.count :] * links])
    T = tangent + 1j * np.multiply.outer(w, drag)
    soft, loop = _soft_points(at, gaps, pulls, T)
    small = T[soft][:, :, None] * np.linalg.inv(np.eye(len(tangent)) + loop)
    # real form (k, 2 w, 2 w) of the complex matrices, for real and imaginary parts one after the other
    real = np.concatenate(
        [np.concatenate([small.real, -small.imag], axis=2), np.concatenate([small.imag, small.real], axis=2)], axis=1
    )
    from_mode, to_mode = np.ascontiguousarray(gaps.T), pulls
    inverse = at.inverse[0][soft], np.ascontiguousarray(at.inverse[1][:, soft])
    every = slice(None) if soft.size == len(w) else soft
    k, c = soft.size, len(tangent)

    def apply(right: Array) -> Array:
        """Product (2, J, n) with the approximate inverse."""
        gap = (right[:, every] @ from_mode).transpose(1, 0, 2).reshape(k, 2 * c, 1)
        force = np.matmul(real, gap).reshape(k, 2, c).transpose(1, 0, 2)
        pulled = force @ to_mode
        result = right.copy()
        result[:, every] -= inverse[0] * pulled + inverse[1] * pulled[::-1]
        return result

    return apply


def _largest(values: Array) -> float:
    """Largest magnitude of values (R,), in their unit."""
    return float(np.abs(values).max(initial=0.0))


# The step of mesh orders, cheap enough to solve each linear system to three digits.
_NEWTON_STEP = newton_step(forcing=1e-3, restarts=3)


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
    for count in range(steps + 1):
        if not np.isfinite(state.norm):
            break
        size = dynamic_size(state.y)
        if state.norm <= tolerance * size:
            return NewtonResult(state=state, converged=True, steps=count, calls=calls)
        if count == steps or calls > work:
            break
        move, used = (step or _NEWTON_STEP)(given, state, state.residual, _TARGET * tolerance * size)
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
    return -_NEWTON_STEP(given, state, state.residual, 0.0)[0]
