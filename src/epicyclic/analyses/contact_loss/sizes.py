"""How many rows a torus has, and which lattice points they are."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..steady.lattice import kept_points

__all__ = ["Size", "mesh_points", "points_of", "weight"]

Index = NDArray[np.int64]


class Size(NamedTuple):
    """Harmonics of each mesh tone, cross order of their combinations, highest order of each slow tone."""

    harmonics: tuple[int, ...]
    cross: int
    orders: tuple[int, ...]


def mesh_points(size: Size) -> Index:
    """Points of the mesh tones alone."""
    return points_of(size._replace(orders=()))


def points_of(size: Size) -> Index:
    """Points kept, (J, D): one of a and -a, the first order of none below 0, the origin first."""
    mesh = kept_points(size.harmonics, size.cross, mirrored=False).points.tolist()
    reach = product(*(range(-order, order + 1) for order in size.orders))
    slow = [orders for orders in reach if weight(orders, size.orders) <= 1]
    every = [(*a, *s) for a in mesh for s in slow]
    leading = [point for point in every if next((a for a in point if a), 1) > 0]
    return np.array(sorted(leading, key=lambda point: (any(point), point)), dtype=np.int64)


def weight(slow: tuple[int, ...], orders: tuple[int, ...]) -> float:
    """|s_1| / H_1 + |s_2| / H_2 + .., without its rounding."""
    return round(sum(abs(s) / order for s, order in zip(slow, orders, strict=True)), 9)
