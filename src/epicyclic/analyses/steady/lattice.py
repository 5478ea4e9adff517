"""Lattice of the mesh frequencies: the combinations kept in the balance, and their exact frequencies.

A point a = (a_1 .. a_D) stands for the frequency a . f.  A mesh depends on one tone, so its stiffness couples points
along that one axis: the lattice is a bundle of independent lines.  Points of equal frequency (tones in the ratio 3/7,
say) stay apart: the equation is linear on the torus of the tone phases, and theta = f t is one path on that torus
whatever the ratio.  Sums over time, as an RMS, add amplitudes of equal frequency first; frequencies are compared as
fractions (docs/design.md, exact frequencies).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product as combinations
from math import lcm

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray

__all__ = [
    "Bundle",
    "Integers",
    "Lattice",
    "LineFrequencies",
    "Point",
    "bundle",
    "frequency_unit",
    "integer_frequencies",
    "kept_points",
    "line_frequencies",
    "on_axis",
]

Index = NDArray[np.int64]
Point = tuple[int, ...]
Integers = NDArray[np.object_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lattice:
    """Lattice points kept.

    points : (J, D); of a real signal (`mirrored`) one of a and -a only, the origin first.
    own : of each axis (2 H + 1,) or, mirrored, (H + 1,): indices in `points` of the multiples of its tone, rising.
    """

    points: Index
    mirrored: bool
    own: tuple[Index, ...]

    @property
    def tones(self) -> int:
        """Number of tones D."""
        return int(self.points.shape[1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bundle:
    """Lines of lattice points along one axis that do not pass through the origin.

    rests : (lines, D) orders that the points of a line share, 0 along the axis.
    several : number of lines with more than one point; they come first.
    take : (lines, W) index of the point at -W/2 .. W/2 along the line, J where none is kept.
    mirror : (lines, W) -1 where the point is kept as its conjugate at -a, else 1.
    """

    rests: Index
    several: int
    take: Index
    mirror: Index


def kept_points(harmonics: tuple[int, ...], cross: int, *, mirrored: bool) -> Lattice:
    """Lattice of the multiples of each tone up to its harmonics, and of combinations up to a cross order.

    harmonics : highest multiple of each tone (D,).  cross : largest |a_1| + .. + |a_D| of a combination.
    """
    D = len(harmonics)
    if D == 1:
        orders = np.arange(0 if mirrored else -harmonics[0], harmonics[0] + 1, dtype=np.int64)
        return Lattice(points=orders[:, None], mirrored=mirrored, own=(np.arange(orders.size, dtype=np.int64),))
    points = [_on_axis(j, a, D) for j, H in enumerate(harmonics) for a in range(-H, H + 1)]
    points += _combined(D, cross)
    if mirrored:
        points = [point for point in points if _leads(point)]
    ordered = sorted(set(points), key=lambda p: (any(p) if mirrored else False, p))
    place = {point: i for i, point in enumerate(ordered)}
    own = tuple(
        np.array([place[_on_axis(j, a, D)] for a in range(0 if mirrored else -H, H + 1)], dtype=np.int64)
        for j, H in enumerate(harmonics)
    )
    return Lattice(points=np.array(ordered, dtype=np.int64).reshape(-1, D), mirrored=mirrored, own=own)


def on_axis(points: Index, axis: int) -> NDArray[np.bool_]:
    """Which lattice points (K, D) are multiples of the tone of one axis alone, the origin included, (K,)."""
    alone: NDArray[np.bool_] = np.count_nonzero(np.delete(points, axis, axis=1), axis=1) == 0
    return alone


def _combined(D: int, cross: int) -> list[Point]:
    """Combinations of two or more of D tones up to |a_1| + .. + |a_D| = cross."""
    reach = range(-cross, cross + 1)
    return [p for p in combinations(reach, repeat=D) if sum(map(abs, p)) <= cross and sum(map(bool, p)) > 1]


def _on_axis(axis: int, order: int, D: int) -> Point:
    """The multiple `order` of one tone as a lattice point of D axes."""
    return (*(0,) * axis, order, *(0,) * (D - axis - 1))


def _leads(point: Iterable[int]) -> bool:
    """Whether a point represents itself and its mirror image: its first order that is not 0 is positive."""
    return next((a for a in point if a), 1) > 0


def bundle(lattice: Lattice, axis: int) -> Bundle:
    """Lines of a lattice along an axis, all padded to one odd width W."""
    lines: dict[Point, list[tuple[int, int, int]]] = {}
    for place, point in enumerate(lattice.points if lattice.tones > 1 else ()):
        rest = point.copy()
        rest[axis] = 0
        if rest.any():
            # the mirror image of a line is the line of the mirrored rest: each is counted once
            sign = 1 if not lattice.mirrored or _leads(rest) else -1
            lines.setdefault(tuple(sign * rest), []).append((place, int(sign * point[axis]), sign))
    order = sorted(lines, key=lambda rest: (len(lines[rest]) == 1, rest))
    half = max((abs(a) for members in lines.values() for _, a, _ in members), default=0)
    take = np.full((len(order), 2 * half + 1), len(lattice.points), dtype=np.int64)
    mirror = np.ones_like(take)
    for i, rest in enumerate(order):
        for place, a, sign in lines[rest]:
            take[i, half + a], mirror[i, half + a] = place, sign
    return Bundle(
        rests=np.array(order, dtype=np.int64).reshape(-1, lattice.tones),
        several=sum(len(members) > 1 for members in lines.values()),
        take=take,
        mirror=mirror,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineFrequencies:
    """Exact frequencies of R harmonics, of mesh orders and then of every shaft line, at the operating speed.

    omega : (R,) signed [rad/s].  unit : frequencies are whole multiples of 1/unit Hz.
    distinct : (F,) distinct magnitudes in that unit, exact, rising.  line : (R,) index in `distinct` of each harmonic.
    negative : (R,) the frequency is minus that of its line.  first : (F,) the first harmonic of each line.
    shared : (E,) harmonics that share a line with others, line by line; starts : (G,) where each of these lines starts.
    """

    omega: Array
    unit: int
    distinct: Integers
    line: Index
    negative: NDArray[np.bool_]
    first: Index
    shared: Index
    starts: Index

    @property
    def coincident(self) -> bool:
        """Whether several harmonics share a line."""
        return self.shared.size > 0

    @property
    def constant(self) -> NDArray[np.bool_]:
        """Harmonics of frequency 0 (R,), which make up the mean."""
        found: NDArray[np.bool_] = (self.distinct == 0).astype(bool)[self.line]
        return found

    def index_of(self, frequencies: Sequence[Fraction]) -> Index:
        """Index in `distinct` of each frequency [Hz] (L,), -1 where no harmonic has it."""
        wanted = [frequency * self.unit for frequency in frequencies]
        steps = np.array([int(f) for f in wanted], dtype=object)
        place = np.minimum(np.searchsorted(self.distinct, steps), max(self.distinct.size - 1, 0))
        known = [f.denominator == 1 and self.distinct[i] == f for f, i in zip(wanted, place, strict=True)]
        return np.where(np.array(known, dtype=bool), place, -1)

    def merged(self, values: ComplexArray) -> ComplexArray:
        """Amplitudes (..., R) with those of equal frequency added, (..., F): value = Re sum A_f exp(i w_f t)."""
        lines: ComplexArray = values[..., self.first]
        lines.imag *= np.where(self.negative[self.first], -1.0, 1.0)
        if self.coincident:
            lines[..., self.line[self.shared[self.starts]]] = self.merged_shared(values)
        return lines

    def merged_shared(self, values: ComplexArray) -> ComplexArray:
        """`merged` of the lines that several harmonics share alone, (..., R) to (..., G)."""
        shared = values[..., self.shared]
        shared.imag *= np.where(self.negative[self.shared], -1.0, 1.0)
        lines: ComplexArray = np.add.reduceat(shared, self.starts, axis=-1)
        return lines

    def power(self, values: ComplexArray, weight: Array) -> Array:
        """Sum of |A_f|^2 weight_f over the lines, weight (F,), amplitudes (..., R) of equal frequency added: (...)."""
        own = weight[self.line]
        own[self.shared] = 0.0
        total: Array = (values.real**2 + values.imag**2) @ own
        if self.coincident:
            lines = self.merged_shared(values)
            total += (lines.real**2 + lines.imag**2) @ weight[self.line[self.shared[self.starts]]]
        return total


def line_frequencies(steps: Integers, unit: int) -> LineFrequencies:
    """Lines of harmonics whose frequencies are `steps` (R,), whole multiples of 1/unit Hz."""
    distinct, first, line, count = np.unique(np.abs(steps), return_index=True, return_inverse=True, return_counts=True)
    order = np.argsort(line, kind="stable")
    shared = order[count[line[order]] > 1]
    return LineFrequencies(
        omega=2 * np.pi * (steps / unit).astype(float),
        unit=unit,
        distinct=distinct,
        line=line,
        negative=(steps < 0).astype(bool),
        first=first,
        shared=shared,
        starts=np.flatnonzero(np.diff(line[shared], prepend=-1)),
    )


def frequency_unit(tones: Sequence[Fraction], shafts: Sequence[Fraction]) -> int:
    """Least u such that all tones and shaft frequencies [Hz] are whole multiples of 1/u Hz."""
    return lcm(*(f.denominator for f in (*tones, *shafts)))


def integer_frequencies(points: Index, tones: Sequence[Fraction], shifts: Sequence[Fraction], unit: int) -> Integers:
    """Frequencies a . tones + shift of points (K, D): (S, K) whole multiples of 1/unit Hz.

    tones, shifts : (D,) and (S,) [Hz]; one shift of 0 for mesh orders.
    """
    at = points.astype(object) @ np.array([int(tone * unit) for tone in tones], dtype=object)
    steps: Integers = np.add.outer(np.array([int(f * unit) for f in shifts], dtype=object), at)
    return steps
