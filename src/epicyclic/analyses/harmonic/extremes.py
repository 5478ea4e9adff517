"""Largest and smallest values of a steady response over all phases of its tones and shaft lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from .response import Block, Kept, Response
from .waveform import Spectrum, on_torus, own_waves, peak, samples_needed, valley

__all__ = ["force_extremes", "grid_of", "largest", "strokes"]

# Phases of each tone on the grid: least, by the number of tones.
_GRID = {1: 128, 2: 48, 3: 32}


def force_extremes(
    ready: Response, block: Block, force: Spectrum, shafts: Spectrum | None, *, axis: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Smallest and largest mesh force over the torus of the tone phases with all shaft lines at their worst, (m, P).

    max over theta_1 .. theta_D of f + sum |A_s|: reached if the tones and lines take all combinations of phases.
    axis : (m,) the tone each force follows.
    """
    counts = grid_of(ready, block.kept)
    value = on_torus(force, counts, block.kept[-1])[:, :, 0]
    if shafts is None and value.ndim == 3:
        return valley(value), peak(value)
    reach = 0.0 if shafts is None else np.abs(on_torus(shafts, counts, block.kept[-1])).sum(axis=2)
    return -largest(axis, reach - value), largest(axis, reach + value)


def largest(own: NDArray[np.int64], values: Array) -> Array:
    """Largest over the torus (m, P, N_1, .., N_D) -> (m, P), refined along the tone of each mesh."""
    if values.ndim == 3:
        return peak(values)
    result = np.empty(values.shape[:2])
    for axis in range(values.ndim - 2):
        mine = own == axis
        others = tuple(2 + other for other in range(values.ndim - 2) if other != axis)
        result[mine] = peak(values[mine].max(axis=others))
    return result


def strokes(ready: Response, block: Block, motion: Spectrum, shafts: Spectrum | None) -> Array:
    """Half the way every coordinate goes at most, (n, P): over the phase of one tone exact.

    Several tones add their ways, combinations and their shaft lines the sum of their amplitudes: a bound.
    """
    counts = grid_of(ready, block.kept)
    if len(counts) == 1:
        value: Array = on_torus(motion, counts, 0)[:, :, 0]
        if shafts is None:
            way: Array = (peak(value) - valley(value)) / 2
            return way
        reach = np.abs(on_torus(shafts, counts, 0)).sum(axis=2)
        return (peak(value + reach) + peak(reach - value)) / 2
    combined = np.count_nonzero(motion.points, axis=1) > 1
    total: Array = np.abs(motion.amplitude[..., combined]).sum(axis=(2, 3))
    if shafts is not None:
        total = total + np.abs(shafts.amplitude).sum(axis=(2, 3))
    for axis, count in enumerate(counts):
        own = own_waves(motion, axis, np.arange(count) / count)[:, :, 0]
        total = total + (peak(own) - valley(own)) / 2
    return total


def grid_of(ready: Response, kept: Kept) -> list[int]:
    """Grid points of every tone's phase, (D,)."""
    *harmonics, _ = kept
    D = len(harmonics)
    least, times = _GRID.get(D, 16), 4 if D == 1 else 1
    return [max(least, times * samples_needed(ready, H)) for H in harmonics]
