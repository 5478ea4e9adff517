"""Newton steps for flanks that part: at every lattice point the mean tangent stands for the closed flanks.

Without what couples lattice points and modes the linearised balance is y + D^-1 pulls^T T gaps y = r, T the mean
tangent less k0.  Its inverse is y = r - D^-1 pulls^T T (I + P T)^-1 gaps r, P = gaps D^-1 pulls^T the receptance of the
meshes: a small matrix at every point.  So preconditioned GMRES needs about as many products as with closed flanks.


---

One point of the balance with contact loss: Newton steps by GMRES, a line search, and what to try when they fail."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray
from ..steady.gmres import gmres
from .problem import Problem, State, dynamic_size, evaluate, jacobian, unknowns

__all__ = [
    "TOLERANCE",
    "WORK",
    "NewtonResult",
    "NewtonStep",
    "dynamic_size",
    "linear_start",
    "newton_step",
    "preconditioner",
    "solve",
]

NewtonStep = Callable[[Problem, State, Array, float], tuple[Array, int]]
"""Solves the linearised balance for a right side to a target, and counts the products."""

# Residual of the GMRES of a step per residual now: each step of a torus is worth about one more digit.
_FORCING = 1e-2
# Change of the mean tangent, per k0, and receptance times tangent of a point, below which they do nothing.
_SAME, _STIFF = 1e-3, 0.05


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Meshes:
    """Whole meshes, their slices moving as one.

    gaps, pulls : (w, n).  receptance : (J, w, w) [m/N].
    """

    gaps: Array
    pulls: Array
    receptance: ComplexArray


def newton_step(*, forcing: float = _FORCING, restarts: int = 2) -> NewtonStep:
    """A Newton step to `forcing` of its right side."""

    def step(given: Problem, at: State, right: Array, target: float) -> tuple[Array, int]:
        inverse, product, shape = preconditioner(given, at), jacobian(given, at), right.shape
        start = inverse(right)
        size = float(np.linalg.norm(start))
        found, _, calls = gmres(
            lambda x: inverse(product(x.reshape(shape))).reshape(1, -1),
            start.reshape(1, -1),
            target=np.array([max(forcing * size, target)]),
            restarts=restarts,
        )
        return found.reshape(shape), calls

    return step


def _meshes(given: Problem, at: State) -> _Meshes:
    made, face, m = given.flanks, given.face, len(given.face.row)
    share = (made.linear[:m] / face.total(made.linear[:m])[face.row])[:, None]
    gaps, pulls = face.total(share * made.gaps[:m]), face.total(share * made.pulls[:m])
    inverse = at.inverse[0] - 1j * at.inverse[1][0]
    scaled = (inverse[:, None, :] * gaps).reshape(-1, inverse.shape[1])
    return _Meshes(gaps=gaps, pulls=pulls, receptance=(scaled @ pulls.T).reshape(len(inverse), len(gaps), -1))


def preconditioner(given: Problem, at: State) -> Callable[[Array], Array]:
    """The approximate inverse of the derivative at a state, for steps (2, J, n)."""
    made, face, m = given.flanks, given.face, len(given.face.row)
    touching, held = at.touching[:, :m], made.linear[:m]
    tangent = face.total(np.einsum("nr,nr->r", touching, given.stiffness[:, :m]) / len(touching) - held)
    if np.all(np.abs(tangent) <= _SAME * face.total(held)):
        return lambda right: right
    meshes = _meshes(given, at)
    drag = face.total((touching.mean(axis=0) - 1.0) * made.drag[:m])
    T = tangent + 1j * np.multiply.outer(at.speed * given.omega, drag)
    loop = meshes.receptance * T[:, None, :]
    soft = np.flatnonzero(np.abs(loop).max(axis=(1, 2)) > _STIFF)
    small = T[soft][:, :, None] * np.linalg.inv(np.eye(len(tangent)) + loop[soft])

    def apply(right: Array) -> Array:
        gap = right[:, soft] @ meshes.gaps.T
        force = np.matmul(small, (gap[0] + 1j * gap[1])[:, :, None])[:, :, 0]
        pulled = np.stack([force.real, force.imag]) @ meshes.pulls
        result = right.copy()
        result[:, soft] -= at.inverse[0][soft] * pulled + at.inverse[1][:, soft] * pulled[::-1]
        return result

    return apply


TOLERANCE = 1e-6
# Newton steps before a point counts as lost; halvings of one step.
_STEPS, _HALVINGS = 20, 6
# Residual of the GMRES of a step per residual now.
_NEWTON_STEP = newton_step(forcing=1e-3, restarts=3)
# Products with the derivative before a point counts as lost: three times what the hardest that succeed take.
WORK = 300


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NewtonResult:
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
    step: NewtonStep | None = None,
) -> NewtonResult:
    """Newton's method from a motion (2, J, n) at relative speed s, with at most so many steps and products."""
    state, calls = evaluate(given, start, speed), 0
    for count in range(steps + 1):
        if not np.isfinite(state.norm):
            break
        size = dynamic_size(state.y)
        if state.norm <= tolerance * size:
            return NewtonResult(state=state, converged=True, steps=count, calls=calls)
        if count == steps or calls > work:
            break
        move, used = (step or _NEWTON_STEP)(given, state, state.residual, 0.1 * tolerance * size)
        calls += used
        lower = _line_search(given, state, move)
        if lower is None:
            break
        state = lower
    return NewtonResult(state=state, converged=False, steps=count, calls=calls)


def _line_search(given: Problem, state: State, move: Array) -> State | None:
    """The first of the halved steps that lowers |R|, None where none does."""
    factor = 1.0
    for _ in range(_HALVINGS):
        trial = evaluate(given, state.y - factor * move, state.speed)
        if trial.norm < (1 - 0.1 * factor) * state.norm:
            return trial
        factor /= 2
    return None


def linear_start(given: Problem, speed: float, touching: NDArray[np.bool_] | None = None) -> Array:
    """The motion (2, J, n) in which flanks (R,) touch all the time or never, to 1e-3: where to begin.

    touching : None: every loaded flank and no far flank.
    """
    pattern = given.flanks.sense > 0 if touching is None else touching
    state = evaluate(given, np.zeros(unknowns(given)), speed, touching=np.broadcast_to(pattern, given.stiffness.shape))
    return -_NEWTON_STEP(given, state, state.residual, 0.0)[0]
