"""The adjoint of the harmonic-balance operator: the same operator of another modal form, so that one solver does both.

With weights 2 on the mean of a real signal and 1 on every other row (its power, doubled), <x, y> = sum W Re(x^H y),
a product with k(t) is its own adjoint, i w G of a skew G too, dampers change sign and everything else is transposed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from ..modes.basis import Modal
from ..steady.kernel import Gather, Kernel

__all__ = ["adjoint", "row_weights", "tail_adjoint"]

_SIGN = {"G": -1.0, "C": -1.0, "Kg": 1.0, "Cskew": 1.0}


def adjoint(modal: Modal) -> Modal:
    """The modal form whose harmonic-balance operator is the adjoint: of factors i w of both signs, C^T and G^T change
    sign; the energy weights of forces and motions change places."""
    omega = np.sqrt(modal.squared)
    soft = np.min(omega[~modal.rigid], initial=1.0 if modal.rigid.all() else np.inf)
    weight = np.where(modal.rigid, soft, omega) ** 2
    turned = {
        name: np.ascontiguousarray(_SIGN[name] * matrix.T * weight / weight[:, None])
        for name, matrix in modal.coupling.items()
    }
    return replace(modal, damping=-modal.damping, coupling=turned)


def row_weights(kernel: Kernel) -> Array:
    """W of every row kept, (J,): 2 for the mean of a real signal."""
    points = kernel.lattice.points
    return np.where(kernel.lattice.mirrored & ~points.any(axis=1), 2.0, 1.0)


def tail_adjoint(kernel: Kernel, force: Array) -> Array:
    """Transpose of `kernel.tail`: forces on the points dropped (m, P, 2 T) to gap rows kept (m, P, 2 J), unweighted."""
    if len(kernel.axes) == 1:
        only: Array = np.matmul(force, kernel.axes[0].own_tail.transpose(0, 2, 1))
        return only
    out = np.zeros((*force.shape[:2], 2 * len(kernel.lattice.points)))
    for axis in kernel.axes:
        m, P = len(axis.meshes), force.shape[1]
        sizes = [axis.own_tail.shape[2], axis.every.place.shape[0] * axis.line_tail.shape[2]]
        slots = _scattered(force[axis.meshes], axis.tail_back, sum(sizes))
        own = slots[:, :, : sizes[0]] @ axis.own_tail.transpose(0, 2, 1)
        lines = slots[:, :, sizes[0] :].reshape(m, -1, axis.line_tail.shape[2]) @ axis.line_tail.transpose(0, 2, 1)
        size = out.shape[2]
        out[axis.meshes] += _scattered(own, axis.own, size) + _scattered(lines.reshape(m, P, -1), axis.every, size)
    return out


def _scattered(rows: Array, gather: Gather, size: int) -> Array:
    """Transpose of a gather: rows (m, P, ..) put back into `size` columns; the padding column falls away."""
    place: NDArray[np.int64] = gather.place.ravel()
    out = np.zeros((*rows.shape[:2], size + 1))
    out[:, :, place] = rows * gather.sign.ravel()  # a column is gathered once, but for the padding
    return out[:, :, :size]
