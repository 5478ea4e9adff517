"""Integer combinations of several mesh frequencies: which are kept, and how a mesh of one of them sees the others.

A point a = (a_1 .. a_D) stands for the frequency a . f.  A mesh depends on one tone, so its stiffness couples points
along that one axis: the whole lattice is a bundle of independent lines.  Points that happen to have the same frequency
(tones in the ratio 3/7, say) stay apart: the equation is linear on the torus of the tone phases, and theta = f t is one
path on it whatever the ratio; only sums over time, as an RMS, must add their amplitudes first.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product as combinations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Bundle", "Lattice", "Point", "bundle", "kept_points"]

Index = NDArray[np.int64]
Point = tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lattice:
    """Points kept.

    points : (J, D), of a real signal (`mirrored`) one of a and -a only, the origin first.
    own : of each axis, rising from 0 or from -H, the places in `points` of the multiples of its tone alone.
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
    """Lines of points along one axis that do not pass through the origin.

    rests : (lines, D) what the points of a line share, 0 along the axis.
    several : how many of the lines, the first ones, hold more than one point.
    take : (lines, W) place of the point at -W/2 .. W/2 along the line, J where none is kept.
    mirror : (lines, W) -1 where it stands there as its conjugate, at -a, else 1.
    """

    rests: Index
    several: int
    take: Index
    mirror: Index


def kept_points(harmonics: tuple[int, ...], cross: int, *, mirrored: bool) -> Lattice:
    """Multiples of each tone up to its harmonics, and combinations of several up to |a_1| + .. + |a_D| = cross."""
    D = len(harmonics)
    points = [_on_axis(j, a, D) for j, H in enumerate(harmonics) for a in range(-H, H + 1)]
    if D > 1:
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


def _combined(D: int, cross: int) -> list[Point]:
    reach = range(-cross, cross + 1)
    return [p for p in combinations(reach, repeat=D) if sum(map(abs, p)) <= cross and sum(map(bool, p)) > 1]


def _on_axis(axis: int, order: int, D: int) -> Point:
    return (*(0,) * axis, order, *(0,) * (D - axis - 1))


def _leads(point: Iterable[int]) -> bool:
    """Whether a point stands for itself and its mirror image: its first order that is not 0 is positive."""
    return next((a for a in point if a), 1) > 0


def bundle(lattice: Lattice, axis: int) -> Bundle:
    """The lines along an axis, all of one odd width W."""
    lines: dict[Point, list[tuple[int, int, int]]] = {}
    for place, point in enumerate(lattice.points):
        rest = point.copy()
        rest[axis] = 0
        if rest.any():
            # the mirror image of a line is the line of the mirrored rest: each is told once
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
