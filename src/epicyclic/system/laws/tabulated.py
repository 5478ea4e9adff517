"""Law of meshes whose force is tabulated over the gap and the phase of the mesh cycle.

Gaps of equal force and slopes are monotone cubics of the phase [fritsch1980]; between forces a rising cubic has the
tabulated slopes: the derivatives are continuous.  Beyond the last force the law continues along its tangent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Curves", "TabulatedLaw", "curves_at"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TabulatedLaw:
    """Tabulated law of mesh rows that differ in their phases alone.

    rows : (c,) their numbers.  lead, sense : (c,) sigma = sense (cycles + lead).
    force : (L,) from zero up [N].  gap : (S, L) B'q - e at sigma = 0, 1/S, ... [m].  slope : (S, L) [N/m].
    """

    rows: NDArray[np.int64]
    lead: Array
    sense: Array
    force: Array
    gap: Array
    slope: Array

    def __repr__(self) -> str:
        """One line: number of rows, size of the table and largest force."""
        phases, loads = self.gap.shape
        return f"TabulatedLaw({len(self.rows)} rows, {phases} phases x {loads} loads up to {self.force[-1]:.4g} N)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curves:
    """The tabulated rows (c,) at T instants: gap, force and slope at the knots, (T, c, L) each."""

    rows: NDArray[np.int64]
    gap: Array
    force: Array
    slope: Array

    def at(self, chosen: NDArray[np.generic]) -> Curves:
        """Curves at the chosen ones of the T instants."""
        return Curves(rows=self.rows, gap=self.gap[chosen], force=self.force[chosen], slope=self.slope[chosen])

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and its derivative [N/m] at gaps (T, c) [m]."""
        last = self.gap.shape[2] - 1
        cell = np.clip((delta[:, :, None] >= self.gap).sum(axis=2) - 1, 0, last - 1)

        def ends(values: Array) -> tuple[Array, Array]:
            low = np.take_along_axis(values, cell[:, :, None], axis=2)[:, :, 0]
            return low, np.take_along_axis(values, cell[:, :, None] + 1, axis=2)[:, :, 0]

        (x0, x1), (f0, f1), (k0, k1) = ends(self.gap), ends(self.force), ends(self.slope)
        h = x1 - x0
        t = np.clip((delta - x0) / h, 0.0, 1.0)
        value = f0 * (1 + 2 * t) * (1 - t) ** 2 + f1 * t**2 * (3 - 2 * t)
        value += h * (k0 * t * (1 - t) ** 2 + k1 * t**2 * (t - 1))
        rate = 6 * t * (1 - t) * (f1 - f0) / h + k0 * (1 - t) * (1 - 3 * t) + k1 * t * (3 * t - 2)
        beyond = np.maximum(delta - self.gap[:, :, -1], 0.0)
        open_ = delta <= self.gap[:, :, 0]
        force = np.where(open_, 0.0, value + beyond * self.slope[:, :, -1])
        return force, np.where(open_, 0.0, rate)


def curves_at(tables: Sequence[TabulatedLaw], cycles: Array) -> Curves | None:
    """Force curves (T, c, L) at times (T, m) counted in cycles of each mesh row; None without tables."""
    if not tables:
        return None
    parts = [_interpolated(table, cycles) for table in tables]
    force = [np.broadcast_to(table.force, gap.shape) for table, (gap, _) in zip(tables, parts, strict=True)]
    return Curves(
        rows=np.concatenate([table.rows for table in tables]),
        gap=np.concatenate([gap for gap, _ in parts], axis=1),
        force=np.concatenate(force, axis=1),
        slope=np.concatenate([slope for _, slope in parts], axis=1),
    )


def _interpolated(table: TabulatedLaw, cycles: Array) -> tuple[Array, Array]:
    """Gaps (T, c, L) [m] and slopes (T, c, L) [N/m] at the knots; cycles : (T, m) [mesh cycles]."""
    from scipy.interpolate import PchipInterpolator  # half a second, for tables alone

    sigma = np.mod(table.sense * (cycles[:, table.rows] + table.lead), 1.0)
    L = len(table.force)
    # first touch and the increments of the gap from load to load: increments that are positive stay positive
    steps = np.hstack([table.gap[:, :1], np.diff(table.gap, axis=1), table.slope])
    S = len(steps)
    wrapped = PchipInterpolator(np.arange(-3, S + 4) / S, steps[np.arange(-3, S + 4) % S])(sigma)
    return np.cumsum(wrapped[..., :L], axis=-1), wrapped[..., L:]
