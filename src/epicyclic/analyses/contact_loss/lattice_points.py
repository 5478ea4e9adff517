"""Lattice points of the balance: orders of mesh and shaft tones, one of a and -a."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...questions.response.lattice import Point, kept_points
from ...system.system import Line

__all__ = [
    "PlacedLine",
    "Size",
    "half_lattice",
    "mesh_points",
    "order_weight",
    "placed_line",
    "torus_points",
]

Index = NDArray[np.int64]
PlacedLine = tuple[Point, bool, Line]
"""A line at a lattice point, and whether its conjugate counts there."""


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
    leading = [point for point in points if _leads(point)]
    return np.array(sorted(leading, key=lambda point: (any(point), point)), dtype=np.int64)


def placed_line(point: Point, line: Line) -> PlacedLine:
    """A line at the point a, or as its conjugate at -a, whichever half of the lattice holds."""
    leads = _leads(point)
    return point if leads else tuple(-a for a in point), not leads, line


def _leads(point: Point) -> bool:
    """Whether a stands for itself and -a: its first order that is not 0 is positive."""
    return next((a for a in point if a), 1) > 0
