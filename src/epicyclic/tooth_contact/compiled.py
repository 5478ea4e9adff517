"""Linear contact compiled: all loads by principal pivoting, or one load by active sets.

Needs numba, so the importing function imports this module.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

from .pivoting import principal_pivoting

__all__ = ["active_set_batch", "principal_pivoting_batch"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]
F = TypeVar("F", bound=Callable[..., object])


def _compiled(function: F) -> F:
    return cast(F, numba.njit(cache=True, error_model="numpy")(function))


_climb = _compiled(principal_pivoting)


@_compiled
def principal_pivoting_batch(compliance: Array, gap: Array, count: Index, loads: Array) -> tuple[Array, Array]:
    """Contact at L rising loads in T phases, of which the first `count` segments exist.

    compliance : (T, n, n) [m/N].  gap : (T, n) [m].  count : (T,).  loads : (L,) [N].
    Returns forces (L, T, n) [N] and approaches (L, T) [m].
    """
    T, n = gap.shape
    force, approach = np.zeros((len(loads), T, n)), np.full((len(loads), T), np.nan)
    given = np.full(len(loads), np.nan)
    for t in range(T):
        m = count[t]
        if m > 0:
            P, d = _climb(compliance[t, :m, :m], gap[t, :m], loads, given)
            force[:, t, :m] = P
            approach[:, t] = d
    return force, approach


@_compiled
def _factor(A: Array) -> None:
    """Lower Cholesky factor of a matrix (n, n) in place, row by row."""
    n = len(A)
    for i in range(n):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            if i == j:
                A[i, i] = np.sqrt(total)
            else:
                A[i, j] = total / A[j, j]


@_compiled
def _backsolve(L: Array, x: Array) -> None:
    """Solve L L' x = b, (n, n) and (n,), in place."""
    n = len(L)
    for i in range(n):
        total = x[i]
        for k in range(i):
            total -= L[i, k] * x[k]
        x[i] = total / L[i, i]
    for i in range(n - 1, -1, -1):
        x[i] /= L[i, i]
        for k in range(i):
            x[k] -= L[i, k] * x[i]


@_compiled
def active_set_batch(
    compliance: Array, gap: Array, count: Index, load: Array, start: NDArray[np.bool_], sweeps: int
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Contact at one load a phase by active sets: forces (T, n) [N], approaches (T,) [m], convergence (T,).

    compliance : (T, n, n) [m/N].  gap : (T, n) [m].  count : (T,) segments that exist.  load : (T,) [N].
    start : (T, n) first active set.  sweeps : most changes of the set.
    """
    T, n = gap.shape
    force, approach = np.zeros((T, n)), np.full(T, np.nan)
    settled = np.zeros(T, dtype=np.bool_)
    for t in range(T):
        m = count[t]
        on = start[t, :m].copy()
        for _ in range(sweeps):
            held = np.flatnonzero(on)
            size = len(held)
            if size == 0:
                break
            matrix = np.empty((size, size))
            one, back = np.ones(size), np.empty(size)
            for i in range(size):
                back[i] = gap[t, held[i]]
                for j in range(i + 1):
                    matrix[i, j] = compliance[t, held[i], held[j]]
            _factor(matrix)
            _backsolve(matrix, one)
            _backsolve(matrix, back)
            d = (load[t] + back.sum()) / one.sum()
            force[t, :m] = 0.0
            same = True
            for i in range(size):
                p = one[i] * d - back[i]
                force[t, held[i]] = p
                if p < 0:
                    same = False
            slack = 1e-12 * max(abs(d), np.abs(gap[t, :m]).max())
            for i in range(m):
                if on[i]:
                    on[i] = force[t, i] >= 0
                else:
                    apart = gap[t, i] - d
                    for k in range(size):
                        apart += compliance[t, i, held[k]] * max(force[t, held[k]], 0.0)
                    if apart < -slack:
                        on[i] = True
                        same = False
            approach[t] = d
            if same:
                settled[t] = True
                break
    return force, approach, settled
