"""What is told of a response at many speeds: pure functions of signals, whatever solved for them.

A linear sweep, one with contact loss, or samples of an integration hand over `Signal`s (complex amplitudes and exact
frequencies; `waveform.sampled` makes one of samples); `measured` makes the columns of the one table of `table` of them.

With F(t) the force of a mesh and F_m its mean over time, what the mesh transmits,

    K_v = max F / F_m        RMS^2 = mean of (F - F_m)^2 = sum |A_f|^2 / 2        peak to peak = max F - min F

K_v is (F_m + dynamic increment) / F_m as in [iso6336, 6], for each mesh of a train.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from .extremes import force_extremes, ranges
from .waveform import Signal

__all__ = [
    "Layout",
    "Signals",
    "dynamic_factor",
    "line_amplitudes",
    "link_measures",
    "mean",
    "mean_square",
    "measured",
    "order_amplitudes",
]

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layout:
    """What the rows of the signals are.

    axis : (w,) the tone each whole mesh follows.  radius : (n,) of the coordinates [m].
    translation : (nb, 3, n) displacement of the centre of every body per coordinate.
    pairs : (k, 2) link rows that are the two lateral directions of one link.
    orders : highest mesh order told.  frequencies : of the other lines told, exact [Hz at the operating speed].
    """

    axis: Index
    radius: Array
    translation: Array
    pairs: Index
    orders: int
    frequencies: tuple[Fraction, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Signals:
    """A response at P relative speeds (P,): forces of whole meshes [N], motion [m, rad], forces of links [N, N m].

    What is None is not told.
    """

    speed: Array
    force: Signal
    motion: Signal | None = None
    links: Signal | None = None


def measured(signals: Signals, layout: Layout) -> dict[str, Array]:
    """Every measure by name: rows first, then orders or lines where there are, speeds last."""
    found = _of_meshes(signals.force, layout)
    if signals.motion is not None:
        found |= _of_motion(signals.motion, signals.speed, layout)
    if signals.links is not None:
        found |= link_measures(signals.links, layout.pairs)
    return found


def _of_meshes(force: Signal, layout: Layout) -> dict[str, Array]:
    low, high = force_extremes(force, axis=layout.axis)
    still = mean(force)
    return {
        "mesh_force_mean": still,
        "mesh_force_rms": np.sqrt(mean_square(force)),
        "mesh_force_peak": high,
        "mesh_force_minimum": low,
        "mesh_force_peak_to_peak": high - low,
        "dynamic_factor": dynamic_factor(high, still),
        "mesh_force_order": order_amplitudes(force, layout.axis, layout.orders),
        "mesh_force_line": line_amplitudes(force, layout.frequencies),
    }


def _of_motion(motion: Signal, speed: Array, layout: Layout) -> dict[str, Array]:
    """Half the way every coordinate goes, and root mean squares of accelerations in the frame of the coordinates."""
    span = ranges(motion)
    return {
        "amplitude": layout.radius[:, None] * (span.high - span.low) / 2,
        "acceleration_rms": speed**2 * np.sqrt(mean_square(motion, derivative=2)),
        "body_acceleration_rms": speed**2 * np.sqrt(_translation_square(motion, layout.translation)),
    }


def link_measures(links: Signal, pairs: Index) -> dict[str, Array]:
    """Measures of the link rows, and of the lateral force of the links whose two rows are `pairs` (k, 2)."""
    span, still, square = ranges(links, pairs), mean(links), mean_square(links)
    x, y = pairs.T
    return {
        "link_force_mean": still,
        "link_force_rms": np.sqrt(square),
        "link_force_peak": np.maximum(span.high, -span.low),
        "link_force_peak_to_peak": span.high - span.low,
        "bearing_force_mean": np.hypot(still[x], still[y]),
        "bearing_force_rms": np.sqrt(square[x] + square[y]),
        "bearing_force_peak": span.length,
    }


def dynamic_factor(largest: Array, transmitted: Array) -> Array:
    """K_v = largest / mean force of a mesh [1]; nan where it transmits none, or pulls."""
    loaded = transmitted > 0
    factor: Array = np.where(loaded, largest, np.nan) / np.where(loaded, transmitted, 1.0)
    return factor


def mean(signal: Signal) -> Array:
    """Mean over all time, (rows, P)."""
    still = signal.comb.still
    total: Array = signal.values[..., still].real.sum(axis=-1)
    return total


def mean_square(signal: Signal, *, derivative: int = 0) -> Array:
    """Mean square over all time without the mean, by Parseval, (rows, P).

    Amplitudes of exactly equal frequency are one line.
    derivative : of the time derivative so often, at relative speed 1; at speed s times s^(2 derivative).
    """
    comb, values = signal.comb, signal.values
    if comb.merged:
        values, omega = comb.folded(values), 2 * np.pi * (comb.distinct / comb.unit).astype(float)
    else:
        omega = np.abs(comb.omega)
    weight = np.where(omega > 0, omega ** (2 * derivative), 0.0)
    square: Array = (values.real**2 + values.imag**2) @ weight / 2
    return square


def _translation_square(motion: Signal, translation: Array) -> Array:
    """Mean square of the acceleration of every body's centre, (nb, P), at relative speed 1."""
    comb, values = motion.comb, motion.values
    nb, _, n = translation.shape
    used = np.flatnonzero(translation.any(axis=2))
    moved = (translation.reshape(-1, n)[used] @ values.reshape(n, -1)).reshape(used.size, *values.shape[1:])
    if comb.merged:
        moved, omega = comb.folded(moved), 2 * np.pi * (comb.distinct / comb.unit).astype(float)
    else:
        omega = comb.omega
    square = np.zeros((3 * nb, values.shape[1]))
    square[used] = (moved.real**2 + moved.imag**2) @ omega**4 / 2
    total: Array = square.reshape(nb, 3, -1).sum(axis=1)
    return total


def order_amplitudes(force: Signal, axis: Index, orders: int) -> Array:
    """Amplitude of every mesh force at multiples 1 .. orders of its own tone (m, orders, P); 0 beyond those kept."""
    points, amplitude = force.orders.points, force.orders.amplitude[:, :, 0]
    found = np.zeros((amplitude.shape[0], orders, amplitude.shape[1]))
    for tone in range(points.shape[1]):
        mine = np.flatnonzero(axis == tone)
        alone = np.count_nonzero(np.delete(points, tone, axis=1), axis=1) == 0
        place = np.flatnonzero(alone & (points[:, tone] > 0) & (points[:, tone] <= orders))
        size = np.abs(amplitude[mine][..., place])
        found[np.ix_(mine, points[place, tone] - 1)] = size.transpose(0, 2, 1)
    return found


def line_amplitudes(signal: Signal, frequencies: Sequence[Fraction]) -> Array:
    """Amplitude at exact frequencies [Hz at the operating speed] (rows, L, P), all rows of one frequency added."""
    comb, amplitude = signal.comb, signal.values
    told = comb.places(frequencies)
    wanted = np.full(comb.distinct.size + 1, -1)
    wanted[told] = np.arange(len(told))
    wanted[-1] = -1
    rows = np.flatnonzero(wanted[comb.line] >= 0)
    values = np.where(comb.backwards[rows], amplitude[..., rows].conj(), amplitude[..., rows])
    found = np.zeros((len(told), *amplitude.shape[:2]), complex)
    np.add.at(found, wanted[comb.line[rows]], np.moveaxis(values, -1, 0))
    size: Array = np.abs(found).transpose(1, 0, 2)
    return size
