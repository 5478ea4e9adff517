"""Parts of slices: the mean over a part of a slice from the means over cells, and the load of a part on them.

Along the face the deflection is known as means over even cells, several to a slice.  The parabola with the means of a
cell and of its neighbours gives the mean over any part of the cell, to third order in its width (derived here).  With
the weights W of that mean, W C W' is the compliance between parts: W takes displacement to the parts and, transposed,
their loads to the cells with the same work, resultant and moment.  It is as positive as C, and exact for whole slices.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["CELLS", "between_parts", "part_weights"]

Array = NDArray[np.float64]

CELLS = 4
# a shorter part, in cells, is as good as a point: its own length would round
_POINT = 1e-9


def part_weights(middle: Array, length: Array, count: int) -> Array:
    """Weights (..., C) [1] of the means over C cells in the mean over a part of the face.

    Parameters
    ----------
    middle, length : (...) of the part, from the left end of the face, in widths of a cell [1].  count : C.
    """
    half = 0.5 * np.maximum(length, _POINT)
    middle = np.clip(middle, half, count - half)
    cell = np.arange(count, dtype=float)
    start = np.maximum((middle - half)[..., None], cell)
    end = np.minimum((middle + half)[..., None], cell + 1)
    share = np.maximum(end - start, 0.0)
    offset = np.where(share > 0, 0.5 * (start + end) - cell - 0.5, 0.0)
    share = share / share.sum(axis=-1, keepdims=True)
    return _of_cells(share, offset, np.maximum(end - start, 0.0))


def _of_cells(share: Array, offset: Array, length: Array) -> Array:
    """Weights of the cells and their neighbours.

    share : (..., C) of the part in each cell [1].  offset, length : (..., C) of the middle of that piece from the
    middle of the cell, and its length, in widths of a cell [1].
    """
    curved = 0.5 * (offset**2 + (length**2 - 1.0) / 12)
    weight = share * (1.0 - 2.0 * curved)
    before, behind = share * (curved - 0.5 * offset), share * (curved + 0.5 * offset)
    # at a free end the curvature vanishes (`kernel`): the cell beyond continues the slope of the last two
    weight[..., :-1] += before[..., 1:]
    weight[..., 0] += 2 * before[..., 0]
    weight[..., 1] -= before[..., 0]
    weight[..., 1:] += behind[..., :-1]
    weight[..., -1] += 2 * behind[..., -1]
    weight[..., -2] -= behind[..., -1]
    return weight


def between_parts(coupling: Array, weight: Array) -> Array:
    """Coupling (T, n, n) between parts, of that between cells (C, C), in its unit; weight : (T, n, C)."""
    T, n, C = weight.shape
    return np.asarray((weight.reshape(-1, C) @ coupling).reshape(T, n, C) @ weight.transpose(0, 2, 1))
