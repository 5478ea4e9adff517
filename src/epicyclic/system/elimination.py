"""Rank of rows: rigid connections eliminated, and motions that strain no row.

A q = eps of rigid connections becomes q = T p + S eps, exactly, without penalty springs, by Gauss-Jordan elimination
with prescribed pivots (derived here).

With the rows of the mean stiffness weighted by the roots of stiffness, W = [sqrt(k) b], it is W W^T.  A rigid motion
strains no mesh and no link, whatever their stiffness: kinematics tells it by the rank of the rows (derived here), the
size of an eigenvalue does not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError

if TYPE_CHECKING:
    from .system import System

Array = NDArray[np.float64]

# Entries below this share of the largest one in a row are rounding of eliminations.
NEGLIGIBLE = 1e-12
# Singular values of rows of unit length that are zero: rounding of rows is 1e-15, and radii printed to eight digits fit
# one centre distance to 1e-8; rows that hold a motion on purpose have 1e-3 (a narrow face against tilt) and more.
_RANK = 1e-8
# What K has beside its links, per geometric mean of its diagonal: rounding of the sum.
REST = 1e-12


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
    scale = np.abs(A).max(axis=1, initial=0.0)
    pending = scale > 0
    # Rows with one free coordinate determine it, many in a pass; that may leave other rows with one.
    while True:
        live = ((np.abs(A) > NEGLIGIBLE * scale[:, None]) & active).sum(axis=1)
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
        reduced, pivot, least = A[row] @ T, int(pivots[row]), NEGLIGIBLE * scale[row]
        if abs(reduced[pivot]) <= least:
            pivot = int(np.argmax(np.abs(reduced)))
        if abs(reduced[pivot]) <= least:
            continue
        right = -(A[row] @ S)
        right[row] += 1.0
        column = T[:, pivot].copy()
        S += np.outer(column, right / reduced[pivot])
        T -= np.outer(column, reduced / reduced[pivot])
        T[:, pivot] = 0.0
    kept = np.flatnonzero(T.any(axis=0))
    return T[:, kept], S, kept


def stiffness_rows(system: System) -> Array | None:
    """Rows W (n, R) [sqrt(N/m)] with W W^T the mean stiffness: meshes, links, and what else K holds.

    None where a part of it is negative.
    """
    meshes, k = system.meshes, system.links.stiffness
    linear = np.isfinite(k) & (k != 0)
    if np.any(k[linear] < 0) or np.any(meshes.stiffness < 0):
        return None
    elastic = _elastic(system, linear)
    return None if elastic is None else np.concatenate([meshes.B * np.sqrt(meshes.stiffness), elastic], axis=1)


def elastic_rows(system: System, without: NDArray[np.int64] | None = None) -> Array:
    """Rows W (n, R) [sqrt(N/m)] with W W^T = K: links, those `without` left out of it, and what else K holds.

    Raises
    ------
    ModelError : K is negative along some motion.
    """
    k = system.links.stiffness
    linear = np.isfinite(k) & (k > 0)
    elastic = _elastic(system, linear)
    if elastic is None:
        raise ModelError("the stiffness of links is negative along some motion", path="stages", allowed="0 or more")
    if without is None or not without.size:
        return elastic
    return np.delete(elastic, np.flatnonzero(np.isin(np.flatnonzero(linear), without)), axis=1)


def _elastic(system: System, linear: NDArray[np.bool_]) -> Array | None:
    """Rows (n, R) of the linear links and of what else K holds; None where that is negative."""
    links = system.links
    rows = links.B[:, linear] * np.sqrt(links.stiffness[linear])
    rest = system.K - rows @ rows.T
    size = np.sqrt(np.maximum(np.diag(system.K), 0.0))
    rest[np.abs(rest) <= REST * np.outer(size, size)] = 0.0
    further = _factor((rest + rest.T) / 2)
    return None if further is None else np.concatenate([rows, further], axis=1)


def _factor(matrix: Array) -> Array | None:
    """F (n, r) with F F^T a symmetric matrix (n, n) without negative eigenvalues; None where it has some."""
    if not matrix.any():
        return np.zeros((len(matrix), 0))
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    scale = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    limit = REST * len(values) * float(np.abs(values).max())
    if values[0] < -limit:
        return None
    kept = values > limit
    factor: Array = scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])
    return factor


def free_motions(rows: Array) -> tuple[Array, Array]:
    """Orthonormal bases of the motions that strain no row, (n, r), and of the others, (n, n - r).

    rows : (n, R) in comparable coordinates, as those of unit mass; their lengths do not count.
    """
    length = np.linalg.norm(rows, axis=0)
    left, size, _ = np.linalg.svd(rows[:, length > 0] / length[length > 0])
    rank = int(np.count_nonzero(size > _RANK * float(size.max(initial=0.0))))
    return left[:, rank:], left[:, :rank]
