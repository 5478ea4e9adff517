"""A preconditioner for flanks that part: at every lattice point the mean tangent in place of the closed flanks.

Without coupling of lattice points and of modes the balance is y + D^-1 pulls^T T gaps y = r with T = mean tangent - k0;
its inverse is that of I + P T, P = gaps D^-1 pulls^T the receptance of the flanks, a small matrix at every point.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...system.system import Array, ComplexArray
from .balance import Problem, State

__all__ = ["preconditioner", "receptance"]


def receptance(given: Problem, at: State) -> ComplexArray:
    """P of the flanks that the mean system holds, (J, m, m) [m/N]."""
    made = given.flanks
    held = made.sense > 0
    real, turned = at.inverse
    inverse = real - 1j * turned[0]
    scaled = (inverse[:, None, :] * made.gaps[held]).reshape(-1, inverse.shape[1])
    found: ComplexArray = (scaled @ made.pulls[held].T).reshape(len(inverse), -1, int(held.sum()))
    return found


def preconditioner(given: Problem, at: State, compliance: ComplexArray) -> Callable[[Array], Array]:
    """The approximate inverse of the derivative at a state, for steps (2, J, n)."""
    made = given.flanks
    held = made.sense > 0
    share = at.touching[:, held].mean(axis=0)
    less = np.einsum("nr,nr->r", at.touching[:, held], given.stiffness[:, held]) / len(at.touching) - made.linear[held]
    drag = (share - 1.0) * made.drag[held]
    T = less + 1j * np.multiply.outer(at.speed * given.omega, drag)
    small = np.linalg.inv(np.eye(less.size) + compliance * T[:, None, :]) * T[:, :, None]
    gaps, pulls, inverse = np.ascontiguousarray(made.gaps[held].T), made.pulls[held], at.inverse

    def apply(r: Array) -> Array:
        J = r.shape[1]
        gap = (r.reshape(-1, r.shape[2]) @ gaps).reshape(2, J, -1)
        force = np.matmul(small, (gap[0] + 1j * gap[1])[:, :, None])[:, :, 0]
        pulled = np.stack([force.real, force.imag]) @ pulls
        result: Array = r - (inverse[0] * pulled + inverse[1] * pulled[::-1])
        return result

    return apply
