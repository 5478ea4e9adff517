"""Linear contact at all loads by principal pivoting, compiled.

Importing it needs numba, so that `loaded_contact` does so only where it is asked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..machine_code import machine_code
from .contact_solver import principal_pivoting

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_pivoting = machine_code(principal_pivoting)


@machine_code
def principal_pivoting_batch(compliance: Array, gap: Array, count: Index, loads: Array) -> tuple[Array, Array]:
    """Contact at L rising loads in T phases, of which the first `count` segments exist.

    compliance : (T, n, n) [m/N].  gap : (T, n) [m].  count : (T,).  loads : (L,) [N].
    Returns forces (L, T, n) [N] and approaches (L, T) [m].
    """
    T, n = gap.shape
    force, approach = np.zeros((len(loads), T, n)), np.full((len(loads), T), np.nan)
    no_approaches = np.full(len(loads), np.nan)
    for t in range(T):
        m = count[t]
        if m > 0:
            P, d = _pivoting(compliance[t, :m, :m], gap[t, :m], loads, no_approaches)
            force[:, t, :m] = P
            approach[:, t] = d
    return force, approach
