"""Transforms of the alternating frequency/time method: amplitudes at lattice points, values on a grid of phases.

A real signal of D phases is x(theta) = Re sum_a X_a exp(2 pi i a . theta) over lattice points a [cameron1989;
krack2019].  Amplitudes stand as real rows (2 J, c): real parts of J points, then imaginary parts, the mean first.
Values stand as (N, c) over the samples of the grid, the last phase fastest.

Edges of contact are samples of a cycle about an instant at which a flank meets or leaves its mate.  Between the samples
before and after, the gap changes by d- and d+.  About a sample it runs through a width w around its value delta above
first touch: the flank is closed for the part a = 1/2 + delta / w of it, all or none beyond, with the mean penetration
d = a w / 2, delta where it is closed throughout:

    f = a f(d) - k w B(delta / w) / 24,    w^2 = (d-^2 + d+^2) / 2

Taken at samples alone, the force would have a corner in the motion wherever first touch passes a sample, and a damper a
jump; so its derivative is continuous, also where a gap only grazes first touch.  The means over the width of all
samples sum to k w^2 / 24 more than the integral of a force of tangent k at first touch: that is taken off again, in
parts B, the quadratic B-spline, over the three samples nearest to first touch.  Away from edges the force is that of
the sample (derived here).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, Line
from ..response.lattice import Point, kept_points, leads

Index = NDArray[np.int64]
PlacedLine = tuple[Point, bool, Line]
"""A line at a lattice point, and whether its conjugate counts there."""

# Half the support of the spline B, in widths.
_REACH = 1.5


# --- lattice points ---------------------------------------------------------------------------------------------------


class Size(NamedTuple):
    """Rows of a torus: harmonics of each mesh tone, order of their combinations, highest order of each shaft tone."""

    harmonics: tuple[int, ...]
    cross: int
    orders: tuple[int, ...]


def mesh_points(size: Size) -> Index:
    """Lattice points (J, D) of the D mesh tones alone."""
    return torus_points(size._replace(orders=()))


def torus_points(size: Size) -> Index:
    """Lattice points (J, D) of mesh and shaft tones, one of a and -a, the origin first.

    Mesh points as of `kept_points`, each with all shaft orders |s_1| / H_1 + |s_2| / H_2 + .. <= 1 (derived here).
    """
    mesh = kept_points(size.harmonics, size.cross, mirrored=False).points.tolist()
    reach = product(*(range(-order, order + 1) for order in size.orders))
    of_shafts = [orders for orders in reach if order_weight(orders, size.orders) <= 1]
    every = [(*a, *s) for a in mesh for s in of_shafts]
    return half_lattice(every)


def order_weight(point: tuple[int, ...], orders: tuple[int, ...]) -> float:
    """|s_1| / H_1 + |s_2| / H_2 + .. of shaft orders (S,) and their highest (S,), without its rounding."""
    return round(sum(abs(s) / order for s, order in zip(point, orders, strict=True)), 9)


def half_lattice(points: Sequence[Point]) -> Index:
    """The points (J, D) of a lattice that stand for a real signal: one of a and -a, the origin first."""
    leading = [point for point in points if leads(point)]
    return np.array(sorted(leading, key=lambda point: (any(point), point)), dtype=np.int64)


def placed_line(point: Point, line: Line) -> PlacedLine:
    """A line at the point a, or as its conjugate at -a, whichever half of the lattice holds."""
    return (point, False, line) if leads(point) else (tuple(-a for a in point), True, line)


# --- transforms -------------------------------------------------------------------------------------------------------


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
        projected: Array = box[:, self.take]
        projected[0, 0] /= 2
        projected[1, 0] = 0
        return projected.reshape(-1, columns)


Transforms = Grid | Separable
"""Transforms of one phase, or of several."""


def grid(points: Index, counts: tuple[int, ...]) -> Transforms:
    """Transforms of lattice points (J, D) on a grid of (D,) samples."""
    if len(counts) > 1:
        return _separable(points, counts)
    angle = 2 * np.pi * np.outer(np.arange(counts[0]) / counts[0], points[:, 0])
    wave = np.concatenate([np.cos(angle), -np.sin(angle)], axis=1)
    back = np.ascontiguousarray(wave.T) * (2 / counts[0])
    back[0] /= 2
    back[len(points)] = 0
    return Grid(points=points, counts=counts, wave=wave, back=back)


def _separable(points: Index, counts: tuple[int, ...]) -> Separable:
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


# --- edges of contact -------------------------------------------------------------------------------------------------


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
