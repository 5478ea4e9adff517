"""Between amplitudes on lattice points and values on a grid of phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from .separable import Separable, phases_of, separable

__all__ = ["Grid", "Transforms", "grid"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grid:
    """Values x = Re sum_a X_a exp(2 pi i a theta) over N samples of one phase; rows (2 J, columns) hold re, then im.

    points : (J, 1), the origin first.  counts : (1,) samples, above twice the orders.
    wave : (N, 2 J), back : (2 J, N).
    """

    points: NDArray[np.int64]
    counts: tuple[int, ...]
    wave: Array
    back: Array

    @property
    def phases(self) -> Array:
        """Phases of every sample, (N, 1)."""
        return phases_of(self.counts)

    def values(self, rows: Array) -> Array:
        """(2 J, c) -> (N, c)."""
        sampled: Array = self.wave @ rows
        return sampled

    def rows(self, values: Array) -> Array:
        """(N, c) -> (2 J, c), orders beyond the points dropped."""
        projected: Array = self.back @ values
        return projected


Transforms = Grid | Separable
"""Of one phase, or of several."""


def grid(points: NDArray[np.int64], counts: tuple[int, ...]) -> Transforms:
    """The transforms of lattice points (J, D) on a grid of phases."""
    if len(counts) > 1:
        return separable(points, counts)
    angle = 2 * np.pi * np.outer(np.arange(counts[0]) / counts[0], points[:, 0])
    wave = np.concatenate([np.cos(angle), -np.sin(angle)], axis=1)
    back = np.ascontiguousarray(wave.T) * (2 / counts[0])
    back[0] /= 2
    back[len(points)] = 0
    return Grid(points=points, counts=counts, wave=wave, back=back)
