"""Transforms of the alternating frequency/time method: amplitudes at lattice points, values on a grid of phases.

A real signal of D phases is x(theta) = Re sum_a X_a exp(2 pi i a . theta) over lattice points a [cameron1989;
krack2019].  Amplitudes stand as real rows (2 J, c): real parts of J points, then imaginary parts, the mean first.
Values stand as (N, c) over the samples of the grid, the last phase fastest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array

__all__ = ["Grid", "Separable", "Transforms", "contiguous", "grid", "phases_of", "separable"]

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grid:
    """Transforms of one phase, as two matrices.

    points : (J, 1) orders, the origin first.  counts : (1,) samples, more than twice the highest order.
    wave : (N, 2 J) from rows to values.  back : (2 J, N) from values to rows.
    """

    points: Index
    counts: tuple[int, ...]
    wave: Array
    back: Array

    @property
    def phases(self) -> Array:
        """Phases (N, 1) of the samples [cycles]."""
        return phases_of(self.counts)

    def values(self, rows: Array) -> Array:
        """Values (N, c) of rows (2 J, c)."""
        sampled: Array = self.wave @ rows
        return sampled

    def rows(self, values: Array) -> Array:
        """Rows (2 J, c) of values (N, c); orders that are no lattice points are dropped."""
        projected: Array = self.back @ values
        return projected


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Separable:
    """Transforms of several phases: one matrix along the first phase, one along all others together.

    points : (J, D) orders, the first one never below 0, the origin first.  counts : (D,) samples of each phase.
    take : (J,) place of each point in a box of S rests (orders of the other phases) times H + 1 first orders.
    turn : (2 Ns, 2 S), unturn : (2 S, 2 Ns) between rests and the Ns samples of the other phases, re and im apart.
    wave : (N_1, 2 H + 2), back : (2 H + 2, N_1) along the first phase.
    """

    points: Index
    counts: tuple[int, ...]
    take: Index
    turn: Array
    unturn: Array
    wave: Array
    back: Array

    @property
    def phases(self) -> Array:
        """Phases (N, D) of the samples [cycles], the last one fastest."""
        return phases_of(self.counts)

    def values(self, rows: Array) -> Array:
        """Values (N, c) of rows (2 J, c)."""
        orders, columns = self.wave.shape[1] // 2, rows.shape[1]
        if not columns:
            return np.zeros((len(self.wave) * len(self.turn) // 2, 0))
        box = np.zeros((2, len(self.unturn) // 2 * orders, columns))
        box[:, self.take] = rows.reshape(2, -1, columns)
        turned = self.turn @ box.reshape(self.turn.shape[1], -1)
        folded = turned.reshape(-1, 2, orders, columns).transpose(1, 2, 0, 3).reshape(2 * orders, -1)
        sampled: Array = (self.wave @ folded).reshape(-1, columns)
        return sampled

    def rows(self, values: Array) -> Array:
        """Rows (2 J, c) of values (N, c); orders that are no lattice points are dropped."""
        orders, columns = self.wave.shape[1] // 2, values.shape[1]
        if not columns:
            return np.zeros((2 * len(self.points), 0))
        along = self.back @ values.reshape(len(self.wave), -1)
        turned = along.reshape(2, orders, -1, columns).transpose(2, 0, 1, 3).reshape(self.turn.shape[0], -1)
        box = (self.unturn @ turned).reshape(2, -1, columns)
        found: Array = box[:, self.take]
        found[0, 0] /= 2
        found[1, 0] = 0
        return found.reshape(-1, columns)


Transforms = Grid | Separable
"""Transforms of one phase, or of several."""


def grid(points: Index, counts: tuple[int, ...]) -> Transforms:
    """Transforms of lattice points (J, D) on a grid of (D,) samples."""
    if len(counts) > 1:
        return separable(points, counts)
    angle = 2 * np.pi * np.outer(np.arange(counts[0]) / counts[0], points[:, 0])
    wave = np.concatenate([np.cos(angle), -np.sin(angle)], axis=1)
    back = np.ascontiguousarray(wave.T) * (2 / counts[0])
    back[0] /= 2
    back[len(points)] = 0
    return Grid(points=points, counts=counts, wave=wave, back=back)


def separable(points: Index, counts: tuple[int, ...]) -> Separable:
    """Transforms of lattice points (J, D), D > 1, on a grid of (D,) samples."""
    rests, which = np.unique(points[:, 1:], axis=0, return_inverse=True)
    highest = int(points[:, 0].max(initial=0))
    angle = 2 * np.pi * phases_of(counts[1:]) @ rests.T
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.stack([np.hstack([cos, -sin]), np.hstack([sin, cos])], axis=1).reshape(2 * len(angle), -1)
    fast = 2 * np.pi * np.outer(np.arange(counts[0]) / counts[0], np.arange(highest + 1))
    wave = np.concatenate([np.cos(fast), -np.sin(fast)], axis=1)
    total = counts[0] * len(angle)
    return Separable(
        points=points,
        counts=counts,
        take=which.ravel() * (highest + 1) + points[:, 0],
        turn=turn,
        unturn=np.ascontiguousarray(turn.T) * (2 / total),
        wave=wave,
        back=np.ascontiguousarray(wave.T),
    )


def phases_of(counts: tuple[int, ...]) -> Array:
    """Phases (N, D) of the samples of a grid [cycles], the last one fastest."""
    axes = np.meshgrid(*(np.arange(count) / count for count in counts), indexing="ij")
    return np.stack([axis.ravel() for axis in axes], axis=1)


def contiguous(places: Index) -> slice | Index:
    """Rising places (k,): a slice, of which numpy makes no copy, where they stand together."""
    whole = places.size > 0 and places[-1] - places[0] + 1 == places.size
    return slice(int(places[0]), int(places[-1]) + 1) if whole else places
