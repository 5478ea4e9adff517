"""What the compiled path leaves on the rows dropped, as `balance` finds it for a whole batch.  Needs numba."""

from __future__ import annotations

import numpy as np

from ...system.system import Array
from ..fast import compiled
from .condensed import Shared

__all__ = ["dropped_size"]


@compiled
def dropped_size(shared: Shared, beyond: Array, gap: Array) -> Array:
    """Size of what the forces put on the rows dropped (P,); beyond : (P, T) [rad/s], gap : (m, P, 2 J) [m]."""
    m, P, J2 = gap.shape
    T, n = beyond.shape[1], shared.squared.size
    result, forces, pulled = np.zeros(P), np.empty((m, 2 * T)), np.empty((n, 2 * T))
    pull = np.ascontiguousarray(shared.push[:, :m])
    for p in range(P):
        forces[:] = 0.0
        for k in range(m):
            for a in range(J2):
                for t in range(2 * T):
                    forces[k, t] += gap[k, p, a] * shared.tail[k, a, t]
        np.dot(pull, forces, pulled)
        total = 0.0
        for r in range(n):
            for t in range(T):
                w = beyond[p, t]
                real, imag = shared.squared[r] - w * w, w * shared.damping[r]
                size = real * real + imag * imag
                if size != 0:
                    total += (pulled[r, t] ** 2 + pulled[r, T + t] ** 2) / size
        result[p] = np.sqrt(total)
    return result
