"""Products and systems with many symmetric positive definite matrices, of which several rows may share one.

The matrices of a mesh cycle are hundreds of megabytes.  They are taken a few at a time, so that what is made of them
stays in the cache, and factorised by Cholesky's method, which reads one triangle and takes half the operations.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotrs

__all__ = ["products", "scaled_solution", "solved", "taken"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.int64]

# Matrix entries at work at once: 1 MB, a share of the cache of one core.
_ENTRIES = 131_072
# Share of the rows of a large matrix below which the rows that count are gathered, which costs a copy.
_FEW = 0.95


def taken(index: Index, n: int) -> Iterator[tuple[slice, Index]]:
    """Parts of an index (t,) of matrices (n, n) that are worked on at once, with their place among the t."""
    size = max(1, _ENTRIES // max(n * n, 1))
    for first in range(0, len(index), size):
        at = slice(first, first + size)
        yield at, index[at]


def products(matrix: Array, index: Index, vector: Array) -> Array:
    """Products (t, n) of the matrices (P, n, n) of an index (t,) with vectors (t, n)."""
    found = np.empty_like(vector)
    for at, part in taken(index, matrix.shape[1]):
        if len(part) == 1:
            np.dot(matrix[part[0]], vector[at.start], out=found[at.start])
        else:
            found[at] = np.matmul(matrix[part], vector[at, :, None])[:, :, 0]
    return found


def solved(matrix: Array, right: Array) -> Array:
    """Solutions (t, n, k) of matrices (t, n, n) that are symmetric and positive definite; `matrix` is overwritten.

    A matrix that rounding leaves indefinite is solved by Gauss's method.
    """
    found = np.empty_like(right)
    diagonal = matrix.reshape(len(matrix), -1)[:, :: matrix.shape[1] + 1].copy()
    for i, one in enumerate(matrix):
        factor, info = dpotrf(one.T, lower=1, clean=0, overwrite_a=1)
        if info == 0:
            found[i] = dpotrs(factor, right[i], lower=1)[0]
            continue
        # the factor has taken the place of one triangle and of the diagonal
        whole = np.tril(one, -1)
        found[i] = np.linalg.solve(whole + whole.T + np.diag(diagonal[i]), right[i])
    return found


def scaled_solution(matrix: Array, index: Index, root: Array, right: Array) -> Array:
    """Solutions (t, n, k) of (1 + D^1/2 C D^1/2) x = right, C the matrices (P, n, n) of an index (t,).

    root : (t, n) D^1/2; where it is zero the solution is the right side.  right : (t, n, k).
    """
    n = matrix.shape[1]
    found = np.empty_like(right)
    for at, part in taken(index, n):
        if len(part) == 1:
            i = at.start
            found[i] = _one_solution(matrix[part[0]], root[i], right[i])
            continue
        whole = matrix[part]
        whole *= root[at, :, None]
        whole *= root[at, None, :]
        whole.reshape(len(part), -1)[:, :: n + 1] += 1.0
        found[at] = solved(whole, right[at])
    return found


def _one_solution(matrix: Array, root: Array, right: Array) -> Array:
    """As `scaled_solution` of one matrix (n, n), without the rows that are not loaded."""
    on = np.flatnonzero(root)
    if len(on) > _FEW * len(root):
        whole = matrix * root
        whole *= root[:, None]
        whole.reshape(-1)[:: len(root) + 1] += 1.0
        return np.asarray(solved(whole[None], right[None])[0])
    found = right.copy()
    if len(on):
        part = matrix[np.ix_(on, on)]
        part *= root[on]
        part *= root[on, None]
        part.reshape(-1)[:: len(on) + 1] += 1.0
        found[on] = solved(part[None], right[None, on])[0]
    return found
