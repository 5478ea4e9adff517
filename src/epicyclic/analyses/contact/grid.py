"""Between amplitudes on lattice points and values on a grid of phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ...system.system import Array

__all__ = ["Grid", "grid"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grid:
    """Values x = Re sum_a X_a exp(2 pi i a . theta) over N = N_1 .. N_D phases; rows (2 J, columns) hold re, then im.

    points : (J, D), one of a and -a, the origin first.  counts : (D,) samples of each phase, above twice the orders.
    wave : (N, 2 J), back : (2 J, N) of one phase; None of several, which go through the fast transform.
    """

    points: NDArray[np.int64]
    counts: tuple[int, ...]
    wave: Array | None
    back: Array | None

    @property
    def phases(self) -> Array:
        """Phases of every sample, (N, D), last axis fastest."""
        axes = np.meshgrid(*(np.arange(count) / count for count in self.counts), indexing="ij")
        return np.stack([axis.ravel() for axis in axes], axis=1)

    def values(self, rows: Array) -> Array:
        """(2 J, c) -> (N, c)."""
        if self.wave is not None:
            sampled: Array = self.wave @ rows
            return sampled
        J, columns = len(self.points), rows.shape[1]
        box = np.zeros((*self.counts, columns), complex)
        box[tuple(self.points.T)] = rows[:J] + 1j * rows[J:]
        every = fft.ifftn(box, axes=range(len(self.counts)), norm="forward", overwrite_x=True)
        result: Array = every.real.reshape(-1, columns)
        return result

    def rows(self, values: Array) -> Array:
        """(N, c) -> (2 J, c), orders beyond the points dropped."""
        if self.back is not None:
            projected: Array = self.back @ values
            return projected
        columns = values.shape[1]
        every = fft.fftn(values.reshape(*self.counts, columns), axes=range(len(self.counts)), norm="forward")
        found = 2 * every[tuple(self.points.T)]
        found[0] /= 2
        return np.concatenate([found.real, found.imag])


def grid(points: NDArray[np.int64], counts: tuple[int, ...]) -> Grid:
    """The transforms of lattice points (J, D) on a grid of phases."""
    wave = back = None
    if len(counts) == 1:
        angle = 2 * np.pi * np.outer(np.arange(counts[0]) / counts[0], points[:, 0])
        wave = np.concatenate([np.cos(angle), -np.sin(angle)], axis=1)
        back = np.ascontiguousarray(wave.T) * (2 / counts[0])
        back[0] /= 2
        back[len(points)] = 0
    return Grid(points=points, counts=counts, wave=wave, back=back)
