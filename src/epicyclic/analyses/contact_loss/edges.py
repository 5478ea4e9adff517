"""Edges of contact: samples of a cycle about an instant at which a flank meets or leaves its mate.

Between the samples before and after, the gap changes by d- and d+.  About a sample it runs through a width w around its
value delta above first touch: the flank is closed for the part a = 1/2 + delta / w of it, all or none beyond, with the
mean penetration d = a w / 2, delta where it is closed throughout:

    f = a f(d) - k w B(delta / w) / 24,    w^2 = (d-^2 + d+^2) / 2

Taken at samples alone, the force would have a corner in the motion wherever first touch passes a sample, and a damper a
jump; so its derivative is continuous, also where a gap only grazes first touch.  The means over the width of all
samples sum to k w^2 / 24 more than the integral of a force of tangent k at first touch: that is taken off again, in
parts B, the quadratic B-spline, over the three samples nearest to first touch.  Away from edges the force is that of
the sample (derived here).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array

__all__ = ["Edges", "WidthTangents", "edges"]

Index = NDArray[np.int64]

# Half the support of the spline B, in widths.
_REACH = 1.5


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

    def forces(self, gap: Array) -> Array:
        """Changes of the forces at the edges (E,) [N] with gaps (N, R) [m]."""
        change: Array = (self.tangent * gap[self.samples, self.at[1]]).sum(axis=0)
        return change


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Edges:
    """Edges among the samples of some flanks.

    at : (E,) sample and (E,) column.  samples : (3, E) before, at and after it.  width : w (E,) [m].
    place : delta / w (E,).  share : a (E,).  inside : (E,) whether first touch is within the width.
    turn : (3, E) change of the width with the gaps of the samples.  spline, slope : (E,) B and its derivative.
    """

    at: tuple[Index, Index]
    samples: Index
    width: Array
    place: Array
    share: Array
    inside: NDArray[np.bool_]
    turn: Array
    spline: Array
    slope: Array

    def enter_penetration(self, delta: Array, closed: Array) -> None:
        """Enter the mean penetration into gaps (N, c) [m]; closed : (N, c) above first touch."""
        rise = self.width * self.share / 2 - closed[self.at]
        delta[self.at] += np.where(self.inside, rise, 0.0)

    def enter_means(self, force: Array, tangent: Array, first: Array) -> Array:
        """Enter mean forces [N] and tangents [N/m] into those at the mean penetration (N, c).

        first : (N, c) tangents at first touch [N/m].  Returns the change of the forces with the width (E,) [N/m].
        """
        f, k, a, w, excess = force[self.at], tangent[self.at], self.share, self.width, first[self.at] / 24
        force[self.at] = a * f - excess * w * self.spline
        tangent[self.at] = np.where(self.inside, f / w + a * k / 2, k) - excess * self.slope
        by_width = np.where(self.inside, a * k / 4 - (a - 0.5) * f / w, 0.0)
        change: Array = by_width - excess * (self.spline - self.place * self.slope)
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
    far = closed * closed
    far *= 2 / _REACH**2
    flat, c = np.flatnonzero(_squared_run(closed, counts, axis) > far), closed.shape[1]
    if not flat.size:
        return None
    sample, column = np.divmod(flat, c)
    at = sample, column
    before, after = (side[at] for side in _beside(counts, tuple(axis.tolist())))
    middle = closed[at]
    fall, rise = middle - closed.take(before), closed.take(after) - middle
    width = np.sqrt((fall * fall + rise * rise) / 2)
    fall, rise = fall / (2 * width), rise / (2 * width)
    place = middle / width
    inside = np.abs(place) < 0.5
    outer = np.abs(place) - _REACH
    return Edges(
        at=at,
        samples=np.stack([before // c, sample, after // c]),
        width=width,
        place=place,
        share=np.clip(0.5 + place, 0.0, 1.0),
        inside=inside,
        turn=np.stack([-fall, fall - rise, rise]),
        spline=np.where(inside, 0.75 - place * place, outer * outer / 2),
        slope=np.where(inside, -2 * place, np.sign(place) * outer),
    )


def _squared_run(closed: Array, counts: tuple[int, ...], axis: Index) -> Array:
    """d-^2 + d+^2 (N, c) [m^2] along the phase of each column."""
    box = closed.reshape(*counts, -1)
    if np.all(axis == axis[:1]):
        return _squared_run_along(box, int(axis[0]) if axis.size else 0).reshape(closed.shape)
    result = np.empty_like(box)
    for phase in range(len(counts)):
        result[..., axis == phase] = _squared_run_along(box[..., axis == phase], phase)
    return result.reshape(closed.shape)


def _squared_run_along(box: Array, phase: int) -> Array:
    """The same of (..., c) along one of its axes."""
    square = np.roll(box, -1, axis=phase)
    square -= box
    square *= square
    square += np.roll(square, 1, axis=phase)
    return square


@lru_cache(maxsize=64)
def _beside(counts: tuple[int, ...], axis: tuple[int, ...]) -> tuple[Index, Index]:
    """Flat places in (N, c) of the samples before and after each, along the phase of each column."""
    samples, c = np.arange(int(np.prod(counts))).reshape(counts), len(axis)
    both = np.empty((2, samples.size, c), np.int64)
    for column, phase in enumerate(axis):
        for place, shift in enumerate((1, -1)):
            both[place, :, column] = np.roll(samples, shift, axis=phase).ravel() * c + column
    return both[0], both[1]
