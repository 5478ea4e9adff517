"""Cyclic symmetry of a stage: the operator that rotates it by one branch (cyclic modes: [lin1999])."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .system import Array

# Angles and stiffnesses of a drawing carry about 1e-12 of rounding; a real asymmetry is far above.
_TOLERANCE = 1e-9


def turn_operator(count: int, *, moves: Sequence[tuple[int, int]], turned: Sequence[int], angle: float) -> Array:
    """Operator that rotates the displacements of a stage by one branch.

    Parameters
    ----------
    count : number of bodies.
    moves : (from, to) indices of the bodies on branches; their own axes rotate with them.
    turned : bodies on the axis, whose x y and rx ry rotate by `angle` [rad].

    Returns
    -------
    (6 count, 6 count) [1]; identity on all other bodies.
    """
    R = np.eye(6 * count)
    for source, _ in moves:
        R[6 * source : 6 * source + 6] = 0.0
    for source, target in moves:
        R[6 * target : 6 * target + 6] = 0.0
        R[6 * target : 6 * target + 6, 6 * source : 6 * source + 6] = np.eye(6)
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[c, -s], [s, c]])
    for body in turned:
        for i in (6 * body, 6 * body + 3):
            R[i : i + 2, i : i + 2] = rotation
    return R


def reduced_operator(R: Array, expand: Array) -> Array | None:
    """Operator R (6 nb, 6 nb) on the reduced coordinates, (n, n) [1]; None where rigid connections break the symmetry.

    expand : (6 nb, n), q_full = expand @ q.
    """
    moved = R @ expand
    # every column has a unit entry of its own, so the normal equations are well conditioned; the residual is checked
    reduced = np.linalg.solve(expand.T @ expand, expand.T @ moved)
    off = np.abs(expand @ reduced - moved).max(initial=0.0)
    return np.asarray(reduced, np.float64) if off <= _TOLERANCE * max(1.0, np.abs(expand).max(initial=1.0)) else None


def commutes(R: Array, matrix: Array) -> bool:
    """Whether R' matrix R = matrix within rounding, (n, n), entry by entry on the scale of the diagonal."""
    diagonal = np.sqrt(np.abs(np.diag(matrix)))
    scale = np.maximum(np.outer(diagonal, diagonal), 1e-12 * float(np.max(diagonal, initial=0.0)) ** 2)
    difference = np.abs(R.T @ matrix @ R - matrix)
    return bool(np.all(difference <= _TOLERANCE * np.where(scale > 0, scale, 1.0)))
