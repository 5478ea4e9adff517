"""Largest value of a sum of slow waves over their phases: independent ones by amplitude, tied ones on a grid.

Waves turn at exact frequencies.  Two whose ratio p : q is of small integers meet in few relative phases only; the
others come as close to every combination as 1 - cos(pi / |(p, q)|) of an amplitude, which is below 1 %: they are taken
as independent.  Tied ones have one common phase t and orders n, Re sum a exp(j n t).  Derived here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, hypot, lcm

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray

__all__ = ["SlowPhases", "phase_points", "slow_phases", "units_of_largest"]

# |(p, q)| from which two waves count as independent: 1 - cos(pi / 23) is 0.9 %.
_TIED = 23.0
# Largest order of tied waves that a grid resolves; beyond it even three waves come within 4 % of every combination.
_MOST_ORDER = 256
# Grid points in the shortest wave, of which the best is then refined by Newton steps: a wrong peak loses a few 1e-3.
_POINTS, _STEPS = 10, 3
# Complex numbers of one piece of the grid.
_PIECE = 500_000


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowPhases:
    """Sets of tied waves, each a tuple of (place among the G frequencies, order of their common phase)."""

    sets: tuple[tuple[tuple[int, int], ...], ...]


def slow_phases(frequency: Sequence[Fraction]) -> SlowPhases:
    """Sets of waves with one common phase each, of exact frequencies (G,) above zero [Hz]."""
    sets: list[list[int]] = []
    for place, own in enumerate(frequency):
        tied = [part for part in sets if any(_tied(own, frequency[other]) for other in part)]
        joined = sorted([place, *(other for part in tied for other in part)])
        if max(_orders([frequency[i] for i in joined])) > _MOST_ORDER:
            # too many common phases to resolve: with the one set that it is tied to most closely, or alone
            joined, tied = [place], []
        sets = [part for part in sets if part not in tied] + [joined]
    return SlowPhases(
        sets=tuple(tuple(zip(part, _orders([frequency[i] for i in part]), strict=True)) for part in sorted(sets))
    )


def _tied(a: Fraction, b: Fraction) -> bool:
    """Whether two frequencies are as small integers."""
    ratio = a / b
    return hypot(ratio.numerator, ratio.denominator) < _TIED


def _orders(frequency: Sequence[Fraction]) -> tuple[int, ...]:
    """Orders of exact frequencies, multiples of their greatest common frequency."""
    unit = lcm(*(f.denominator for f in frequency))
    whole = [int(f * unit) for f in frequency]
    common = gcd(*whole)
    return tuple(n // common for n in whole)


def units_of_largest(phases: SlowPhases, amplitude: ComplexArray) -> ComplexArray:
    """Units u = exp(j theta) (G, ...) at which Re sum a u is largest, of amplitudes a (G, ...)."""
    unit = np.empty_like(amplitude)
    for part in phases.sets:
        places = [place for place, _ in part]
        if len(part) == 1:
            a = amplitude[places[0]]
            size = np.abs(a)
            with np.errstate(divide="ignore", invalid="ignore"):
                unit[places[0]] = np.where(size > 0, a.conj() / size, 1.0)
        else:
            orders = np.array([order for _, order in part])
            t = _common_phase(amplitude[places].reshape(len(part), -1), orders)
            unit[places] = np.exp(1j * np.multiply.outer(orders, t)).reshape(amplitude[places].shape)
    return unit


def _common_phase(amplitude: ComplexArray, orders: NDArray[np.int64]) -> Array:
    """Common phase t (P,) [rad] of the largest Re sum a exp(j n t), amplitudes (g, P)."""
    count = int(_POINTS * orders.max())
    grid = 2 * np.pi * np.arange(count) / count
    wave = np.exp(1j * np.multiply.outer(orders, grid))
    table = np.concatenate([wave.real, -wave.imag])
    a = amplitude.T
    parts = np.hstack([a.real, a.imag])
    step = max(1, _PIECE // count)
    best = [np.argmax(parts[i : i + step] @ table, axis=1) for i in range(0, len(parts), step)]
    t = grid[np.concatenate([np.zeros(0, np.int64), *best])]
    n = orders[:, None]
    for _ in range(_STEPS):
        value = amplitude * np.exp(1j * n * t)
        slope, bend = -(n * value.imag).sum(axis=0), -(n**2 * value.real).sum(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            move = np.where(bend < 0, -slope / bend, 0.0)
        t = t + np.clip(move, -np.pi / count, np.pi / count)
    return t


def phase_points(phases: SlowPhases, count: int) -> ComplexArray:
    """Units exp(j theta) (count, G) that fill the phases evenly: an additive sequence, equidistant where one set turns.

    One point where nothing turns.
    """
    sets = phases.sets
    if not sets:
        return np.ones((1, 0), complex)
    d = len(sets)
    root = 2.0  # x^(d+1) = x + 1: its powers fill the cube most evenly, the golden ratio where d = 1
    for _ in range(60):
        root = (1 + root) ** (1 / (d + 1))
    step = np.array([1 / count]) if d == 1 else root ** -np.arange(1.0, d + 1)
    t = 2 * np.pi * np.mod(np.multiply.outer(np.arange(count) + 0.5, step), 1.0)
    unit = np.empty((count, sum(map(len, sets))), complex)
    for column, part in enumerate(sets):
        for place, order in part:
            unit[:, place] = np.exp(1j * order * t[:, column])
    return unit
