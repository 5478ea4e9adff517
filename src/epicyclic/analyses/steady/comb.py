"""Exact frequencies of the rows of a spectrum, and which rows are one line because their frequencies are equal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray

__all__ = ["Comb", "Integers", "comb", "row_steps", "unit_of"]

Index = NDArray[np.int64]
Integers = NDArray[np.object_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Comb:
    """The frequencies of R rows, of mesh orders and then of every shaft line, at the operating speed.

    omega : (R,) signed [rad/s].  unit : frequencies are whole multiples of 1/unit Hz.
    distinct : (F,) sizes of the different ones in that unit, exact, rising.  line : (R,) which of them each row has.
    backwards : (R,) its frequency is minus that.  merged : whether several rows have the same.
    """

    omega: Array
    unit: int
    distinct: Integers
    line: Index
    backwards: NDArray[np.bool_]
    merged: bool

    @property
    def still(self) -> NDArray[np.bool_]:
        """(R,) rows of frequency 0, which make up the mean."""
        found: NDArray[np.bool_] = (self.distinct == 0).astype(bool)[self.line]
        return found

    def places(self, frequencies: Sequence[Fraction]) -> Index:
        """Where in `distinct` each frequency [Hz] stands, -1 where it is not among them."""
        wanted = [frequency * self.unit for frequency in frequencies]
        known = {int(step): i for i, step in enumerate(self.distinct)}
        return np.array([known.get(int(f), -1) if f.denominator == 1 else -1 for f in wanted], dtype=np.int64)

    def folded(self, values: ComplexArray) -> ComplexArray:
        """Amplitudes (..., R) with those of equal frequency added, (..., F): value = Re sum A_f exp(i w_f t)."""
        lines = np.zeros((*values.shape[:-1], self.distinct.size), complex)
        turned = np.where(self.backwards, values.conj(), values)
        np.add.at(np.moveaxis(lines, -1, 0), self.line, np.moveaxis(turned, -1, 0))
        return lines


def comb(steps: Integers, unit: int) -> Comb:
    """The comb of rows whose frequencies are `steps` (R,), whole multiples of 1/unit Hz."""
    distinct, line = np.unique(np.abs(steps), return_inverse=True)
    return Comb(
        omega=2 * np.pi * (steps / unit).astype(float),
        unit=unit,
        distinct=distinct,
        line=line,
        backwards=(steps < 0).astype(bool),
        merged=distinct.size < steps.size,
    )


def unit_of(tones: Sequence[Fraction], shafts: Sequence[Fraction]) -> int:
    """The unit in which all combinations of the tones and shaft frequencies are whole numbers."""
    return lcm(*(f.denominator for f in (*tones, *shafts)))


def row_steps(points: Index, tones: Sequence[Fraction], shifts: Sequence[Fraction], unit: int) -> Integers:
    """Frequencies a . tones + shift of points (K, D), (S, K) whole multiples of 1/unit Hz; one shift of 0 for none."""
    at = points.astype(object) @ np.array([int(tone * unit) for tone in tones], dtype=object)
    steps: Integers = np.add.outer(np.array([int(f * unit) for f in shifts], dtype=object), at)
    return steps
