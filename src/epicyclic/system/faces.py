"""Whole meshes and their slices: names, and sums over the face."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .system import Array, MeshRows

__all__ = ["Faces", "faces"]

Number = TypeVar("Number", bound=np.inexact)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Faces:
    """The w whole meshes of a System with m mesh rows.

    name : (w,) of each.  row : (m,) mesh of each row.  first : (w,) first row of each, whose labels are those of the
    mesh.  count : (w,) rows of each, 1 without slices.
    """

    name: tuple[str, ...]
    row: NDArray[np.int64]
    first: NDArray[np.int64]
    count: NDArray[np.int64]

    @property
    def cut(self) -> NDArray[np.bool_]:
        """(m,) rows that are slices of a mesh."""
        return np.asarray(self.count[self.row] > 1, bool)

    def total(self, values: NDArray[Number], axis: int = 0) -> NDArray[Number]:
        """Sums (..., w, ...) over the rows of each mesh of values (..., m, ...), in their unit, along `axis`."""
        if len(self.first) == len(self.row):
            return values
        summed: NDArray[Number] = np.add.reduceat(values, self.first, axis=axis)
        return summed

    def least(self, values: Array, axis: int = 0) -> Array:
        """Smallest value (..., w, ...) of the rows of each mesh, of values (..., m, ...), in their unit."""
        lowest: Array = np.minimum.reduceat(values, self.first, axis=axis)
        return lowest

    def any(self, values: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(w,) meshes of which any row (m,) is true."""
        found: NDArray[np.bool_] = np.logical_or.reduceat(values, self.first)
        return found


def faces(meshes: MeshRows) -> Faces:
    """Whole meshes of mesh rows; the slices of one mesh are adjacent."""
    number = meshes.slice or (0,) * len(meshes.name)
    names = [name.rpartition("/")[0] if k else name for name, k in zip(meshes.name, number, strict=True)]
    whole = {name: i for i, name in enumerate(dict.fromkeys(names))}
    row = np.array([whole[name] for name in names], np.int64)
    return Faces(
        name=tuple(whole),
        row=row,
        first=np.flatnonzero(np.diff(row, prepend=-1)),
        count=np.bincount(row, minlength=len(whole)),
    )
