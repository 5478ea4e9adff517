"""Rows of links before their reduction: coefficients of gaps on all coordinates of all bodies.

A force along the unit vector n at the point r of a body does the work n . (u + theta x r), hence the row [n, r x n]; a
moment along n has the row [0, n] (docs/conventions.md, The mesh row).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bodies.elastic_body import ElasticBody, about_z
from ..train.train import DIRECTIONS, Link
from .system import Array


class ElasticPart(NamedTuple):
    """A body that bends.  body : its index.  columns : its coordinates beside the six, in those of all bodies."""

    body: int
    columns: slice
    elastic: ElasticBody

    @property
    def all_columns(self) -> NDArray[np.int64]:
        """Its six coordinates, then the others (6 + e,)."""
        six = np.arange(6 * self.body, 6 * self.body + 6)
        return np.concatenate([six, np.arange(self.columns.start, self.columns.stop)])


class LinkRow(NamedTuple):
    """One direction of one link, or a spring of a body that bends.

    first, second : body indices, -1 = the frame.  law : it has one, see `law_groups`.  spring : name and stiffness
    [N/m] of a spring by which a body bends or a foundation holds it.  drawn : name of the link in the train.
    Of links that pass a body: share : how many stand at its place in the mean.  seat : the link at the second body.
    """

    link: Link
    direction: int
    first: int
    second: int
    law: bool
    spring: tuple[str, float] | None = None
    drawn: str = ""
    share: float = 1.0
    seat: Link | None = None

    @property
    def name(self) -> str:
        """``main/sun/support/x``."""
        return f"{self.link.name}/{DIRECTIONS[self.direction] if self.spring is None else self.spring[0]}"

    @property
    def stiffness(self) -> float:
        """Of this direction, inf = rigid [N/m, N m/rad]."""
        return self.link.stiffness[self.direction] / self.share if self.spring is None else self.spring[1]

    @property
    def damping(self) -> float:
        """Of this direction [N s/m, N m s/rad]."""
        return self.link.damping[self.direction] / self.share

    @property
    def to_housing(self) -> bool:
        """Whether what stands on the other side is no body."""
        return self.second < 0


def link_matrix(rows: list[LinkRow], origins: Array, axes: Array, elastic: Sequence[ElasticPart]) -> Array:
    """Rows (p, N) of links; origins : (nb, 3) [m] and axes : (nb,) [rad] of the bodies."""
    direction = np.array([row.direction for row in rows], np.int64)

    def side(some: list[int], links: Sequence[Link], body: NDArray[np.int64]) -> Array:
        """Rows of some links at one of their bodies."""
        angle, axis = np.array([link.angle for link in links]), direction[some] % 3
        normal, (c, s) = np.zeros((len(links), 3)), (np.cos(angle), np.sin(angle))
        normal[:, 0] = np.where(axis == 0, c, np.where(axis == 1, -s, 0.0))
        normal[:, 1] = np.where(axis == 0, s, np.where(axis == 1, c, 0.0))
        normal[:, 2] = axis == 2
        point = np.array([(*link.centre, link.station) for link in links]).reshape(-1, 3)
        return body_rows(body, normal, point - origins[body], axes, elastic, direction[some] >= 3)

    every, joins = list(range(len(rows))), [i for i, row in enumerate(rows) if row.second >= 0]
    own = side(every, [row.link for row in rows], np.array([row.first for row in rows], np.int64))
    second = np.array([rows[i].second for i in joins], np.int64)
    own[joins] -= side(joins, [rows[i].seat or rows[i].link for i in joins], second)
    # a share of a spring has the force of a whole one: its row, and so its load, is the share
    own *= np.array([row.share for row in rows])[:, None]
    return own


def body_rows(
    body: NDArray[np.int64],
    normal: Array,
    point: Array,
    axes: Array,
    elastic: Sequence[ElasticPart],
    rotation: NDArray[np.bool_],
) -> Array:
    """Coefficients (R, N) of gap rows on one body each, those by which it bends among them; axes : (nb,).

    Other arguments as of `gap_rows`.
    """
    six = gap_rows(normal, point, axes[body], rotation=rotation)
    matrix = np.zeros((len(body), 6 * axes.size + sum(len(part.elastic.names) for part in elastic)))
    np.put_along_axis(matrix, 6 * body[:, None] + np.arange(6), six, axis=1)
    for part in elastic:
        rows = np.flatnonzero(body == part.body)
        n, P = (about_z(vectors[rows], -axes[part.body]) for vectors in (normal, point))
        moved = part.elastic.shape(P)
        moved = np.where(rotation[rows, None, None], moved[:, 3:], moved[:, :3])
        matrix[rows, part.columns] = np.einsum("ra,rae->re", n, moved)
    return matrix


def gap_rows(normal: Array, point: Array, axes: Array, *, rotation: NDArray[np.bool_]) -> Array:
    """Six coefficients [n, r x n] or [0, n] of R gap rows in their bodies (docs/conventions.md, The mesh row).

    Parameters
    ----------
    normal : (R, 3) unit vectors in frame axes.
    point : (R, 3) from the body's origin, in frame axes [m].
    axes : (R,) polar angle of the body's own x axis in frame axes [rad].
    rotation : (R,) True where the row is an angle (rx, ry, rz), not a displacement.

    Returns
    -------
    (R, 6) in the body's own axes, order x y z rx ry rz.
    """
    turned = rotation[:, None]
    parts = np.where(turned, 0.0, normal), np.where(turned, normal, np.cross(point, normal))
    return np.hstack([about_z(part, -axes) for part in parts])
