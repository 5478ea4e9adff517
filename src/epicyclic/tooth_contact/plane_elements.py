"""Plane strain by finite elements: nine-noded cells on structured grids, stiffness and load vectors.

Lagrange's biquadratic element with Gauss' rule of 3 x 3 points.  Young's modulus is 1: stresses under
given forces do not depend on it, displacements are inverse to it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

__all__ = ["edge_values", "grid_cells", "merged_nodes", "stiffness_matrix"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


def grid_cells(numbers: Index) -> Index:
    """Cells (m, 9) of a grid of node numbers (2 a + 1, 2 b + 1), nodes of a cell row by row."""
    rows, columns = numbers.shape
    at = [numbers[i : rows - 2 + i : 2, j : columns - 2 + j : 2].ravel() for i in range(3) for j in range(3)]
    return np.stack(at, axis=1)


def merged_nodes(points: Array, apart: float) -> tuple[Array, Index]:
    """Points (k, 2) of which no two are nearer than `apart`, and the number (n,) among them of each of (n, 2) [m]."""
    from scipy.spatial import cKDTree  # heavy, and needed where grids meet alone

    target = np.arange(len(points))
    for i, j in sorted(cKDTree(points).query_pairs(apart)):
        target[j] = target[i]
    kept, number = np.unique(target, return_inverse=True)
    return points[kept], number.astype(np.int64)


def edge_values(place: Array) -> tuple[Array, Array]:
    """Shape functions of an edge of three nodes and their derivatives, (..., 3) each, at places (...) in -1 .. 1."""
    t = np.asarray(place, dtype=float)
    value = np.stack([0.5 * t * (t - 1), 1 - t**2, 0.5 * t * (t + 1)], axis=-1)
    slope = np.stack([t - 0.5, -2 * t, t + 0.5], axis=-1)
    return value, slope


def stiffness_matrix(points: Array, cells: Index, poisson: float) -> sparse.csc_matrix:
    """Stiffness (2 n, 2 n) of unit thickness in plane strain with E = 1; unknowns x and y of each node in turn [1].

    points : (n, 2) [m].  cells : (m, 9) of `grid_cells`.  poisson : [1].
    """
    value, slope = edge_values(_GAUSS)
    # shape functions are products of those of an edge, rows first
    by_row = np.einsum("ai,bj->abij", slope, value).reshape(9, 9)
    by_column = np.einsum("ai,bj->abij", value, slope).reshape(9, 9)
    local = np.stack([by_row, by_column])  # (direction, Gauss point, node)
    weight = np.outer(_WEIGHTS, _WEIGHTS).ravel()
    jacobian = np.einsum("dgn,mnx->mgdx", local, points[cells])
    size = jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0]
    gradient = np.linalg.solve(jacobian, np.broadcast_to(local.transpose(1, 0, 2), (*jacobian.shape[:2], 2, 9)))
    factor = 1 / ((1 + poisson) * (1 - 2 * poisson))
    D = factor * np.array([[1 - poisson, poisson, 0], [poisson, 1 - poisson, 0], [0, 0, 0.5 - poisson]])
    B = np.zeros((*jacobian.shape[:2], 3, 18))
    B[..., 0, 0::2] = B[..., 2, 1::2] = gradient[..., 0, :]
    B[..., 1, 1::2] = B[..., 2, 0::2] = gradient[..., 1, :]
    own = np.einsum("mgai,ab,mgbj,mg->mij", B, D, B, np.abs(size) * weight, optimize=True)
    freedom = (2 * cells[:, :, None] + np.arange(2)).reshape(len(cells), 18)
    row, column = np.repeat(freedom, 18, axis=1).ravel(), np.tile(freedom, (1, 18)).ravel()
    count = 2 * len(points)
    return sparse.csc_matrix((own.ravel(), (row, column)), shape=(count, count))
