"""Masses and inertias of shafts, plates and gear bodies from their sections: solids of revolution, derived here."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

__all__ = ["Inertia", "SolidSection", "inertia_of"]

# Gauss points and weights of order 3 on [0, 1]: exact for polynomials of degree 5; those here have degree 4
_POINTS = tuple((0.5 + 0.5 * x, w / 18) for x, w in ((-math.sqrt(0.6), 5), (0.0, 8), (math.sqrt(0.6), 5)))


@dataclass(frozen=True, slots=True)
class SolidSection:
    """A hollow cone about an axis parallel to z.

    start, length : along z from the centre of the member [m].  outer, inner : diameters at both ends [m].
    density : [kg/m^3].  off_axis : distance of its axis from that of the member [m].
    """

    start: float
    length: float
    outer: tuple[float, float]
    inner: tuple[float, float]
    density: float
    off_axis: float = 0.0


@dataclass(frozen=True, slots=True)
class Inertia:
    """mass [kg]; about z and about a diameter through the centre of the member [kg m^2]."""

    mass: float
    polar: float
    tilt: float


def inertia_of(sections: Iterable[SolidSection]) -> Inertia:
    """Mass and inertias of sections together; those off the axis stand evenly around it."""
    mass = polar = tilt = 0.0
    for section in sections:
        for share, weight in _POINTS:
            z = section.start + share * section.length
            outer, inner = (_at(pair, share) / 2 for pair in (section.outer, section.inner))
            slab = section.density * section.length * weight * math.pi
            area, second = outer**2 - inner**2, (outer**4 - inner**4) / 2
            mass += slab * area
            polar += slab * (second + area * section.off_axis**2)
            # evenly around the axis, each stands on average for half of its distance squared
            tilt += slab * (second / 2 + area * (z**2 + section.off_axis**2 / 2))
    return Inertia(mass, polar, tilt)


def _at(pair: tuple[float, float], share: float) -> float:
    return pair[0] + (pair[1] - pair[0]) * share
