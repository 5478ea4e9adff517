"""Largest and smallest values of signals over all phases of their tones and shaft lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from .waveform import Signal, Spectrum, on_torus, own_waves, peak, valley

__all__ = ["Range", "force_extremes", "grid_counts", "largest", "ranges"]

Index = NDArray[np.int64]

# Phases of each tone on the grid: least, by the number of tones.
_GRID = {1: 128, 2: 48, 3: 32}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Range:
    """Smallest and largest value of every row (rows, P), and largest length of pairs of rows (pairs, P)."""

    low: Array
    high: Array
    length: Array


def force_extremes(force: Signal, *, axis: Index) -> tuple[Array, Array]:
    """Smallest and largest mesh force over the torus of the tone phases with all shaft lines at their worst, (m, P).

    max over theta_1 .. theta_D of f + sum |A_s|: reached if the tones and lines take all combinations of phases.
    axis : (m,) the tone each force follows.
    """
    value, reach = _waves(force)
    if isinstance(reach, float) and value.ndim == 3:
        return valley(value), peak(value)
    return -largest(axis, reach - value), largest(axis, reach + value)


def largest(own: Index, values: Array) -> Array:
    """Largest over the torus (m, P, N_1, .., N_D) -> (m, P), refined along the tone of each mesh."""
    if values.ndim == 3:
        return peak(values)
    result = np.empty(values.shape[:2])
    for axis in range(values.ndim - 2):
        mine = own == axis
        others = tuple(2 + other for other in range(values.ndim - 2) if other != axis)
        result[mine] = peak(values[mine].max(axis=others))
    return result


def ranges(signal: Signal, pairs: Index | None = None) -> Range:
    """Smallest and largest value of every row, shaft lines at their worst, and largest length of pairs of rows (k, 2).

    Over the phase of one tone exact but for the shaft lines, of which each takes its worst phase.  Several tones add
    their largest values, combinations and shaft lines the sum of their amplitudes: a bound.
    """
    pairs = np.zeros((0, 2), np.int64) if pairs is None else pairs
    if signal.orders.points.shape[1] == 1:
        value, reach = _waves(signal)
        sides = [np.abs(value[side]) + (reach if isinstance(reach, float) else reach[side]) for side in pairs.T]
        length = peak(np.hypot(*sides))
        if isinstance(reach, float):
            return Range(low=valley(value), high=peak(value), length=length)
        return Range(low=-peak(reach - value), high=peak(reach + value), length=length)
    low, high = _added(signal)
    most = np.maximum(-low, high)
    return Range(low=low, high=high, length=np.hypot(most[pairs[:, 0]], most[pairs[:, 1]]))


def _waves(signal: Signal) -> tuple[Array, Array | float]:
    """Value of the tones over the grid of their phases (rows, P, N_1, ..), and what shaft lines may add to it."""
    counts = grid_counts(signal.orders)
    value: Array = on_torus(signal.orders, counts, signal.cross)[:, :, 0]
    if signal.lines is None:
        return value, 0.0
    return value, np.abs(on_torus(signal.lines, counts, signal.cross)).sum(axis=2)


def _added(signal: Signal) -> tuple[Array, Array]:
    """Smallest and largest values of the tones one by one, added, with everything else at its worst, (rows, P)."""
    orders = signal.orders
    combined = np.count_nonzero(orders.points, axis=1) > 1
    other: Array = np.abs(orders.amplitude[..., combined]).sum(axis=(2, 3))
    if signal.lines is not None:
        other = other + np.abs(signal.lines.amplitude).sum(axis=(2, 3))
    low, high = -other, other
    for axis, count in enumerate(grid_counts(orders)):
        own = own_waves(orders, axis, np.arange(count) / count, mean=axis == 0)[:, :, 0]
        low, high = low + valley(own), high + peak(own)
    return low, high


def grid_counts(orders: Spectrum) -> list[int]:
    """Grid points of every tone's phase: enough for the harmonics of the tone, with one tone four times that."""
    points = orders.points
    D = points.shape[1]
    own = np.count_nonzero(points, axis=1) <= 1
    least, times = _GRID.get(D, 16), 4 if D == 1 else 1
    return [max(least, times * (2 * int(np.abs(points[own, j]).max(initial=0)) + 1)) for j in range(D)]
