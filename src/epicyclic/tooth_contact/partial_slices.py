"""Parts of slices: the mean over a part of a slice from the means over cells, and the load of a part on them.

Along the face the deflection is known as means over even cells, several to a slice.  The parabola with the means of a
cell and of its neighbours gives the mean over any part of the cell, to third order in its width (derived here).  With
the weights W of that mean, W C W' is the compliance between parts: W takes displacement to the parts and, transposed,
their loads to the cells with the same work, resultant and moment.  It is as positive as C, and exact for whole slices.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["CELLS", "FaceParts", "between_parts", "face_parts", "part_weights"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceParts:
    """Parts of K slices at T phases, n in each: nearly all are whole slices, so few differ.

    slices : K.  weight : (R, C) of the cells in every different part [1], the K whole slices first.  row : (T, n) of
    each part among those.  column : (T, m) indices among the n of the parts that are cut, padded with n.
    """

    slices: int
    weight: Array
    row: Index
    column: Index


def face_parts(slices: int, place: Index, middle: Array, length: Array) -> FaceParts:
    """Parts of the slices of a face.

    Parameters
    ----------
    slices : K.  place : (T, n) slice of each part.  middle, length : (T, n) of the part, from the left end of the face,
        in widths of a cell [1]; a length of zero is none, and counts as a whole slice.
    """
    cells = slices * CELLS
    cut = (length > 0) & (length < CELLS - _POINT)
    edge = CELLS * (np.arange(slices) + 0.5)
    middles, lengths = np.append(edge, middle[cut]), np.append(np.full(slices, float(CELLS)), length[cut])
    row = place.astype(np.int64)
    row[cut] = slices + np.arange(int(cut.sum()))
    most = int(cut.sum(axis=1).max(initial=0))
    column = np.argsort(~cut, axis=1, kind="stable")[:, :most]
    column = np.where(np.take_along_axis(cut, column, axis=1), column, place.shape[1])
    return FaceParts(slices=slices, weight=part_weights(middles, lengths, cells), row=row, column=column)


def between_parts(coupling: Array, parts: FaceParts) -> Iterator[Array]:
    """Coupling (n, n) between the parts of each phase in turn, W C W' of that between cells (C, C), in its unit."""
    K, n = parts.slices, parts.row.shape[1]
    moved = parts.weight @ coupling
    # of every different part with the whole slices, which are nearly all
    sliced = moved @ parts.weight[:K].T
    for row, column in zip(parts.row, parts.column, strict=True):
        found = np.take(sliced[row], np.minimum(row, K - 1), axis=1)
        at = column[column < n]
        if at.size:
            found[:, at] = found[at].T
            found[np.ix_(at, at)] = moved[row[at]] @ parts.weight[row[at]].T
        yield found
