"""Rows of link groups: one or two rows a group (x and y of a bearing, or one direction), side by side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

__all__ = ["GroupRows"]

Array = NDArray[np.float64]
_T = TypeVar("_T", bound=np.generic)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroupRows:
    """R rows of G groups: first (G,) row of each group, owner (R,) group of each row."""

    first: NDArray[np.int64]
    owner: NDArray[np.int64]

    @property
    def pair(self) -> NDArray[np.bool_]:
        """Whether a group has two rows (G,); else one."""
        two: NDArray[np.bool_] = np.diff(np.append(self.first, self.owner.size)) == 2
        return two

    def spread(self, values: NDArray[_T]) -> NDArray[_T]:
        """Values of groups (..., G) at each row (..., R)."""
        result: NDArray[_T] = values[..., self.owner]
        return result

    def dot(self, a: Array, b: Array) -> Array:
        """Scalar products (..., G) of the parts of each group in a and b (..., R)."""
        return np.add.reduceat(a * b, self.first, axis=-1) if self.first.size else a[..., :0]

    def size(self, rows: Array) -> Array:
        """Euclidean length (..., G) of the part of each group in rows (..., R), in their unit."""
        return np.sqrt(self.dot(rows, rows))

    def blocks(self, unit: Array, *, along: Array, across: Array) -> Array:
        """Blocks along n n' + across (1 - n n') (..., R, R) [N/m], unit vectors n (..., R); along, across (..., G)."""
        same = self.owner[:, None] == self.owner
        dyad = self.spread(along - across)[..., :, None] * unit[..., :, None] * unit[..., None, :]
        result: Array = np.where(same, dyad, 0.0)
        rows = np.arange(self.owner.size)
        result[..., rows, rows] += self.spread(across)
        return result
