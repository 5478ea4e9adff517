"""Rows of links before their reduction, coefficients of gaps on all coordinates of all bodies; also of links that pass.

A force along the unit vector n at the point r of a body does the work n . (u + theta x r), hence the row [n, r x n]; a
moment along n has the row [0, n] (docs/conventions.md, The mesh row).

Links that pass a body have their mean stiffness as rows that stand, and beside it rows of what varies.  Bolts in the
housing stand at evenly spaced places of the body (`train.elastic_bodies.PassingLinks`), and so do their mean and
what varies.  Between two bodies each link stands at all places of the one; of all links the sum is taken, matrices K_0
of the mean and K_l of each order on the coordinates of both, and rows are their eigenvectors.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bodies.elastic_body import ElasticBody, about_z
from ..train.elastic_bodies import PassingLinks
from ..train.train import DIRECTIONS, Link
from .system import Array, ComplexArray


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
    matrix[np.arange(len(body))[:, None], 6 * body[:, None] + np.arange(6)] = six
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


# Parts of a sum over all links and places that are its rounding, per stiffness of the mean.
_ROUND = 1e-11


class PassingRow(NamedTuple):
    """A row whose stiffness varies about its mean.

    link : ``main/ring/support/bolts``.  drawn : name of a link of the train.  tone : exact [rev/s].
    wave : (L,) of its stiffness, Re sum_l wave_l exp(2 pi i l tone t) [N/m].
    """

    link: str
    drawn: str
    tone: Fraction
    wave: ComplexArray


def passing_rows(
    groups: Sequence[PassingLinks], index: dict[str, int], origins: Array, axes: Array, elastic: Sequence[ElasticPart]
) -> tuple[list[LinkRow], Array, tuple[PassingRow, ...], Array]:
    """Link rows of the mean with their matrix (p, N), and rows of what varies with theirs (q, N).

    index : number of each body.  origins : (nb, 3) [m] and axes : (nb,) [rad] of the bodies.
    """
    size = 6 * axes.size + sum(len(part.elastic.names) for part in elastic)
    means, varying = list[LinkRow](), list[PassingRow]()
    mean_rows, varying_rows = [np.zeros((0, size))], [np.zeros((0, size))]
    for group in groups:
        placed = list(_placed(group, index))
        rows, series = [row for row, _ in placed], [wave for _, wave in placed]
        matrix = link_matrix(rows, origins, axes, elastic)
        waves = np.array([row.stiffness for row in rows])[:, None] * np.array(series)
        varied, step = matrix, 1
        if group.links[0].second is not None:
            rows, matrix, waves, varied = _summed(rows, matrix, waves)
            step = math.gcd(*(np.flatnonzero(waves.any(axis=0)) + 1).tolist()) or 1
        means += rows
        mean_rows.append(matrix)
        varying_rows.append(varied)
        name, drawn = _place_of(group.links[0].name), group.links[0].name
        varying += [PassingRow(name, drawn, step * group.tone, wave[step - 1 :: step]) for wave in waves]
    return means, np.concatenate(mean_rows), tuple(varying), np.concatenate(varying_rows)


def _place_of(name: str) -> str:
    """``main/ring/support/bolts/1`` -> ``main/ring/support/bolts``."""
    return name.rpartition("/")[0] if "/bolts/" in name else name


def _placed(group: PassingLinks, index: dict[str, int]) -> Iterator[tuple[LinkRow, ComplexArray]]:
    """Rows of links at all places of the body that they pass, and the series of their stiffness (L,) [1].

    Bolts in the housing share the places.  A share of a link has the force of a whole one.
    """
    one = group.links[0]
    links, share = (
        (group.links, 1 / group.places) if one.second is not None else ([one], len(group.links) / group.places)
    )
    for link in links:
        second = -1 if link.second is None else index[link.second]
        for number, series in enumerate(group.series):
            turn = math.tau * number / group.places
            centre, angle = complex(*link.centre) * cmath.exp(1j * turn), (link.angle + turn) % math.tau
            name = f"{_place_of(link.name)}/{round(math.degrees(angle), 1):g} deg"
            placed = replace(link, name=name, centre=(centre.real, centre.imag), angle=angle)
            ends = (replace(link, name=name), placed) if group.second else (placed, link)
            for direction, (k, c) in enumerate(zip(link.stiffness, link.damping, strict=True)):
                if k != 0.0 or c != 0.0:
                    first = index[link.first]
                    yield LinkRow(ends[0], direction, first, second, False, None, link.name, share, ends[1]), series


def _summed(
    rows: list[LinkRow], matrix: Array, waves: ComplexArray
) -> tuple[list[LinkRow], Array, ComplexArray, Array]:
    """The sum of many rows (p, N) as few: rows of the mean, their matrix, waves (q, L) and the rows (q, N) of these."""
    one, stiffness = rows[0], np.array([row.stiffness for row in rows])
    mean = (matrix.T * stiffness) @ matrix
    scale = np.sqrt(np.diag(mean))
    scale[scale == 0] = np.inf
    kept, weight = _patterns(mean, scale)
    name, still = _place_of(one.drawn), (0.0,) * 6
    link = replace(one.link, name=name, stiffness=still, damping=still)
    means = [
        LinkRow(link, 0, one.first, one.second, False, (f"pattern {number}", value), one.drawn)
        for number, value in enumerate(weight.tolist(), start=1)
    ]
    varied, amplitudes = [np.zeros((0, matrix.shape[1]))], list[ComplexArray]()
    for order, wave in enumerate(waves.T):
        for part, unit in ((wave.real, 1.0), (wave.imag, 1j)):
            found, values = _patterns((matrix.T * part) @ matrix, scale)
            varied.append(found)
            amplitudes += [unit * value * np.eye(waves.shape[1])[order] for value in values]
    return means, kept, np.array(amplitudes).reshape(-1, waves.shape[1]), np.concatenate(varied)


def _patterns(matrix: Array, scale: Array) -> tuple[Array, Array]:
    """Rows b (r, N), largest coefficient 1, and weights w (r,) [N/m]: a symmetric matrix (N, N) = sum w b b'.

    scale : (N,) roots of the stiffness of the coordinates, inf where there is none.
    """
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    kept = np.abs(values) > _ROUND * len(values)
    rows = (np.where(np.isfinite(scale), scale, 0.0)[:, None] * vectors[:, kept]).T
    largest = np.abs(rows).max(axis=1, initial=0.0)
    return rows / largest[:, None], values[kept] * largest**2
