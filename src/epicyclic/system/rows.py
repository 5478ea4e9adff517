"""Rows of gaps: a unit vector at a point becomes six columns of a body (docs/conventions.md)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["gap_rows"]

Array = NDArray[np.float64]


def gap_rows(normal: Array, point: Array, axes: Array, *, rotation: NDArray[np.bool_]) -> Array:
    """The six coefficients a gap row has in one body.

    A force along the unit vector n at the point r of a body does the work n . (u + theta x r), so the row is
    [n, r x n]; a moment along n gives [0, n].

    Parameters
    ----------
    normal : (R, 3) unit vectors in frame axes.
    point : (R, 3) from the body's origin, in frame axes [m].
    axes : (R,) polar angle of the body's own x axis in frame axes [rad].
    rotation : (R,) True where the row is an angle (rx, ry, rz), not a displacement.

    Returns
    -------
    (R, 6) in the body's own axes, order x y z rx ry rz.
    """
    moment = np.empty_like(normal)
    moment[:, 0] = point[:, 1] * normal[:, 2] - point[:, 2] * normal[:, 1]
    moment[:, 1] = point[:, 2] * normal[:, 0] - point[:, 0] * normal[:, 2]
    moment[:, 2] = point[:, 0] * normal[:, 1] - point[:, 1] * normal[:, 0]
    turned = rotation[:, None]
    rows = np.hstack([np.where(turned, 0.0, normal), np.where(turned, normal, moment)])
    c, s = np.cos(axes), np.sin(axes)
    for i in (0, 3):
        x, y = rows[:, i].copy(), rows[:, i + 1].copy()
        rows[:, i], rows[:, i + 1] = c * x + s * y, c * y - s * x
    return rows
