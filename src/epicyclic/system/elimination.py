"""Rigid connections by elimination: A q = eps becomes q = T p + S eps, exactly, without penalty springs.

Gauss-Jordan elimination with prescribed pivots, derived here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .system import Array

__all__ = ["eliminate"]

# Entries below this share of the largest one in a row are rounding of earlier eliminations.
_NEGLIGIBLE = 1e-12


def eliminate(constraints: Array, pivots: NDArray[np.int64]) -> tuple[Array, Array, NDArray[np.int64]]:
    """Solve the constraints for as many coordinates as their rank.

    Parameters
    ----------
    constraints : (c, N) rows A of A q = eps, in units that make their entries comparable.
    pivots : (c,) the coordinate for which each row is solved if its coefficient is not negligible.

    Returns
    -------
    T : (N, n) so that q = T p satisfies A q = 0; columns of kept coordinates are unit at that coordinate.
    S : (N, c) so that q = T p + S eps satisfies A q = eps, as far as the rows are independent.
    kept : (n,) the coordinates that remain.
    """
    count, size = constraints.shape
    A = constraints.copy()
    S = np.zeros((size, count))
    active = np.ones(size, bool)
    pending = np.ones(count, bool)
    scale = np.abs(A).max(axis=1, initial=0.0)
    pending &= scale > 0
    # Rows with one free coordinate determine it, many in a pass; that may leave other rows with one.
    while True:
        live = ((np.abs(A) > _NEGLIGIBLE * scale[:, None]) & active).sum(axis=1)
        pending &= live > 0
        single = np.flatnonzero(pending & (live == 1))
        if not single.size:
            break
        columns, first = np.unique(np.abs(A[single] * active).argmax(axis=1), return_index=True)
        rows = single[first]
        right = -A[rows] @ S
        right[np.arange(rows.size), rows] += 1.0
        S[columns] = right / A[rows, columns][:, None]
        active[columns] = False
        pending[rows] = False
    T = np.zeros((size, size))
    T[active, active] = 1.0
    for row in np.flatnonzero(pending).tolist():
        _solve_row(A[row], row, int(pivots[row]), T, S, float(scale[row]))
    kept = np.flatnonzero(T.any(axis=0))
    return T[:, kept], S, kept


def _solve_row(a: Array, row: int, pivot: int, T: Array, S: Array, scale: float) -> None:
    """Solve one row a (N,) for `pivot`, or its largest coefficient; change T (N, N) and S (N, c) in place."""
    reduced = a @ T
    if abs(reduced[pivot]) <= _NEGLIGIBLE * scale:
        pivot = int(np.argmax(np.abs(reduced)))
        if abs(reduced[pivot]) <= _NEGLIGIBLE * scale:
            return
    right = -(a @ S)
    right[row] += 1.0
    column = T[:, pivot].copy()
    S += np.outer(column, right / reduced[pivot])
    T -= np.outer(column, reduced / reduced[pivot])
    T[:, pivot] = 0.0
