"""Linear unilateral contact one segment at a time, as the approach rises: exact over any range of loads.

    w = C P + g - d >= 0,   P >= 0,   w P = 0

This linear complementarity problem with the parameter d is solved by principal pivoting (derived here).  Of every
segment either P or w is zero, the nonbasic one.  The basic ones are linear in d; where one would turn negative it is
exchanged by one pivot of the table.  Forces and load are piecewise linear in d, so that one pass reaches every load.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["principal_pivoting"]

Array = NDArray[np.float64]


def principal_pivoting(compliance: Array, gap: Array, loads: Array, approaches: Array) -> tuple[Array, Array]:
    """Linear contact of n segments at L loads or approaches in rising order.

    Parameters
    ----------
    compliance : (n, n) C, symmetric positive definite [m/N].  gap : (n,) g [m].
    loads : (L,) [N], nan where the approach is given.  approaches : (L,) d [m].

    Returns
    -------
    Forces (L, n) [N] and approaches (L,) [m].
    """
    n, count = len(gap), len(loads)
    # basic variable i = table[i] . nonbasic + level[i] + rate[i] d
    table, level, rate = compliance.copy(), gap.copy(), -np.ones(n)
    pressed = np.zeros(n, dtype=np.bool_)
    force, approach = np.zeros((count, n)), np.zeros(count)
    at, done = -np.inf, 0
    for _ in range(20 * n + 1):
        first, following = -1, np.inf
        for i in range(n):
            if rate[i] < 0.0 and -level[i] / rate[i] < following:
                first, following = i, -level[i] / rate[i]
        following = max(following, at)
        base, slope = 0.0, 0.0
        for i in range(n):
            if pressed[i]:
                base, slope = base + level[i], slope + rate[i]
        while done < count:
            wanted = approaches[done]
            if not np.isnan(loads[done]):
                wanted = (loads[done] - base) / slope if slope > 0 else (following if loads[done] <= 0 else np.inf)
            if wanted > following:
                break
            approach[done] = wanted
            for i in range(n):
                if pressed[i]:
                    force[done, i] = max(level[i] + rate[i] * wanted, 0.0)
            done += 1
        if done == count or first < 0:
            break
        at = following
        # exchange P and w of the segment whose basic variable reaches zero
        pivot = table[first, first]
        row = table[first] / pivot
        column = table[:, first].copy()
        for i in range(n):
            if i != first:
                table[i] -= column[i] * row
                level[i] -= column[i] * level[first] / pivot
                rate[i] -= column[i] * rate[first] / pivot
        table[:, first] = column / pivot
        table[first] = -row
        table[first, first] = 1.0 / pivot
        level[first], rate[first] = -level[first] / pivot, -rate[first] / pivot
        pressed[first] = not pressed[first]
    return force, approach
