"""Edges of contact: samples of a cycle in which a flank touches for a part only.

A sample stands for its part of the cycle.  In it the gap runs through a width w about its value delta above first
touch; the flank is closed for the part a = 1/2 + delta / w, with the mean penetration d = a w / 2:

    f = a f(d),    w^2 = ((delta+ - delta-) / 2)^2 + ((delta+ - 2 delta + delta-) / 2)^2

with the samples before and after.  Taken at samples alone, the force would have a corner in the motion wherever first
touch passes a sample, and a damper a jump; so its derivative is continuous, also where a gap only grazes first touch.
Away from edges the force is that of the sample (derived here).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array

__all__ = ["Edges", "WidthTangents", "edges"]

Index = NDArray[np.int64]

# Part of the second difference in the width: half of what a parabola about first touch opens.
_BEND = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WidthTangents:
    """How forces at the edges depend on the gaps of three samples by the width.

    at : (E,) sample and (E,) row of each edge.  samples : (3, E) before, at and after it.  tangent : (3, E) [N/m].
    """

    at: tuple[Index, Index]
    samples: Index
    tangent: Array

    def of_rows(self, place: Index) -> WidthTangents:
        """The same for rows that stand at other places (R,)."""
        return replace(self, at=(self.at[0], place[self.at[1]]))

    def add(self, force: Array, gap: Array) -> None:
        """Add what gaps (N, R) [m] change of forces (N, R) [N]."""
        rows = self.at[1]
        force[self.at] += (self.tangent * gap[self.samples, rows]).sum(axis=0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Edges:
    """Edges among the samples of some flanks.

    at : (E,) sample and (E,) column.  samples : (3, E) before, at and after it.  width : w (E,) [m].
    share : a (E,).  turn : (3, E) change of the width with the gaps of the samples.
    """

    at: tuple[Index, Index]
    samples: Index
    width: Array
    share: Array
    turn: Array

    def enter_penetration(self, delta: Array, closed: Array) -> None:
        """Enter the mean penetration into gaps (N, c) [m]; closed : (N, c) above first touch."""
        delta[self.at] += self.width * self.share / 2 - closed[self.at]

    def enter_means(self, force: Array, tangent: Array) -> Array:
        """Enter mean forces [N] and tangents [N/m] into those at the mean penetration (N, c).

        Returns the change of the forces with the width (E,) [N/m].
        """
        f, k, a, w = force[self.at], tangent[self.at], self.share, self.width
        force[self.at], tangent[self.at] = a * f, f / w + a * k / 2
        change: Array = a * k / 4 - (a - 0.5) * f / w
        return change

    def tangents(self, change: Array, columns: Index) -> WidthTangents:
        """Tangents by the width, from the change of forces with it (E,) [N/m]; columns : (c,) row of each column."""
        return WidthTangents(at=(self.at[0], columns[self.at[1]]), samples=self.samples, tangent=change * self.turn)


def edges(closed: Array, counts: tuple[int, ...], axis: Index) -> Edges | None:
    """Edges of gaps above first touch (N, c) [m] over a grid, the last phase fastest; None where there is none.

    Parameters
    ----------
    counts : (D,) samples of each phase.  axis : (c,) phase that each column follows.
    """
    before, after = _beside(counts, tuple(axis.tolist()))
    low, high = closed.take(before), closed.take(after)
    slope, bend = (high - low) / 2, _BEND * (high - 2 * closed + low)
    width = np.sqrt(slope * slope + bend * bend)
    sample, column = np.nonzero(np.abs(closed) < width / 2)
    if not sample.size:
        return None
    at = sample, column
    w, c = width[at], closed.shape[1]
    slope, bend = slope[at] / (2 * w), _BEND * bend[at] / w
    return Edges(
        at=at,
        samples=np.stack([before[at] // c, at[0], after[at] // c]),
        width=w,
        share=0.5 + closed[at] / w,
        turn=np.stack([bend - slope, -2 * bend, bend + slope]),
    )


@lru_cache(maxsize=64)
def _beside(counts: tuple[int, ...], axis: tuple[int, ...]) -> tuple[Index, Index]:
    """Flat places in (N, c) of the samples before and after each, along the phase of each column."""
    samples, c = np.arange(int(np.prod(counts))).reshape(counts), len(axis)
    both = np.empty((2, samples.size, c), np.int64)
    for column, phase in enumerate(axis):
        for place, shift in enumerate((1, -1)):
            both[place, :, column] = np.roll(samples, shift, axis=phase).ravel() * c + column
    return both[0], both[1]
