"""Between amplitudes on lattice points and values on a grid of phases.

---

Transforms between lattice points and a grid of several phases, one axis after the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array

__all__ = ["Grid", "Separable", "Transforms", "grid", "phases_of", "separable"]

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grid:
    """Values x = Re sum_a X_a exp(2 pi i a theta) over N samples of one phase; rows (2 J, columns) hold re, then im.

    points : (J, 1), the origin first.  counts : (1,) samples, above twice the orders.
    wave : (N, 2 J), back : (2 J, N).
    """

    points: Index
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Separable:
    """The transforms of `Grid` for several phases: matrices along the first axis, and along all others together.

    points : (J, D), the first order of none below 0, the origin first.  counts : (D,) samples of each phase.
    take : (J,) place of each point in a box of S rests (orders of the other axes) times H + 1 first orders.
    turn : (2 Ns, 2 S), unturn : (2 S, 2 Ns) between rests and the Ns phases of the other axes, re and im apart.
    wave : (N_1, 2 H + 2), back : (2 H + 2, N_1) along the first axis.
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
        """Phases of every sample, (N, D), last axis fastest."""
        return phases_of(self.counts)

    def values(self, rows: Array) -> Array:
        """(2 J, c) -> (N, c)."""
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
        """(N, c) -> (2 J, c), orders beyond the points dropped."""
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
"""Of one phase, or of several."""


def grid(points: Index, counts: tuple[int, ...]) -> Transforms:
    """The transforms of lattice points (J, D) on a grid of phases."""
    if len(counts) > 1:
        return separable(points, counts)
    angle = 2 * np.pi * np.outer(np.arange(counts[0]) / counts[0], points[:, 0])
    wave = np.concatenate([np.cos(angle), -np.sin(angle)], axis=1)
    back = np.ascontiguousarray(wave.T) * (2 / counts[0])
    back[0] /= 2
    back[len(points)] = 0
    return Grid(points=points, counts=counts, wave=wave, back=back)


def separable(points: Index, counts: tuple[int, ...]) -> Separable:
    """Prepare the transforms of lattice points (J, D), D > 1."""
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
    """Phases of every sample of a grid, (N, D), last axis fastest."""
    axes = np.meshgrid(*(np.arange(count) / count for count in counts), indexing="ij")
    return np.stack([axis.ravel() for axis in axes], axis=1)
