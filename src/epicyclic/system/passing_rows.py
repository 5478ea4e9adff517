"""Rows of links that pass a body: their mean stiffness as rows that stand, and rows of what varies beside it.

Bolts in the housing stand at evenly spaced places of the body (`train.rings.PassingLinks`), and so do their mean and
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

from ..train.rings import PassingLinks
from .link_rows import ElasticPart, LinkRow, link_matrix
from .system import Array, ComplexArray

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
