"""Shaft lines as slow tones: the few frequencies whose small multiples, with mesh orders, are all the lines.

Frequencies are exact, so every line is a multiple of one very low frequency, of an order no lattice could hold.  What
is wanted is a small set of tones of which each line is a combination with orders up to 4, modulo the mesh frequencies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np

from ..steady.excitation import Excitation, Shaft
from ..steady.lattice import Point
from ..steady.response import Response
from .problem import PlacedLine, placed_line

__all__ = ["ShaftTones", "shaft_tones"]

# Highest order of a slow tone that a line may stand on: a lattice of Hs = 4 still holds it.
_ORDER = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShaftTones:
    """Shaft lines on a lattice of mesh tones and slow tones.

    tones : exact frequencies [Hz at the operating speed].  highest : largest order of each that a line stands on.
    lines : placed on (mesh orders, slow orders).  left : groups of lines for which there was no tone left.
    """

    tones: tuple[Fraction, ...]
    highest: tuple[int, ...]
    lines: tuple[PlacedLine, ...]
    superposed: tuple[Shaft, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Place:
    """A group whose frequency is mesh . tones + slow . slow tones."""

    shaft: Shaft
    mesh: Point
    slow: Point


def shaft_tones(ready: Response, groups: Sequence[Shaft], *, most: int) -> ShaftTones:
    """Slow tones for groups of shaft lines, strongest first; those of more than `most` tones are left."""
    lines = ready.lines
    tones: list[Fraction] = []
    places: list[_Place] = []
    superposed: list[Shaft] = []
    for shaft in sorted(groups, key=lambda shaft: -_strength(ready, shaft)):
        found = _placed(lines, tones, shaft)
        if found is None:
            divided = _divided(tones, places, shaft)
            if divided is not None:
                tones, places = divided
            elif len(tones) < most:
                tones.append(shaft.frequency)
            else:
                superposed.append(shaft)
                continue
            found = _placed(lines, tones, shaft)
        if found is not None:
            places.append(found)
    width = len(tones)
    slow = [(*place.slow, *(0,) * (width - len(place.slow))) for place in places]
    return ShaftTones(
        tones=tuple(tones),
        highest=tuple(max(abs(point[i]) for point in slow) for i in range(width)),
        lines=tuple(
            line for place, point in zip(places, slow, strict=True) for line in _lines(place.shaft, place.mesh, point)
        ),
        superposed=tuple(superposed),
    )


def _strength(ready: Response, shaft: Shaft) -> float:
    """Root of the strain energy that the lines of a group would bring at rest."""
    modal, meshes = ready.modal, ready.system.meshes
    force = sum(
        (line.gap * meshes.stiffness) @ modal.pulls + modal.forces @ line.force.sum(axis=0)
        for _, _, line in shaft.members
    )
    return float(np.linalg.norm(force / np.where(modal.rigid, np.inf, modal.squared)))


def _placed(lines: Excitation, tones: list[Fraction], shaft: Shaft) -> _Place | None:
    """A combination of least order that has the frequency of a group, None where there is none of small order."""
    reach = range(-_ORDER, _ORDER + 1)
    every = sorted(product(reach, repeat=len(tones)), key=lambda slow: (sum(map(abs, slow)), [-a for a in slow]))
    for slow in every:
        rest = shaft.frequency - sum((a * tone for a, tone in zip(slow, tones, strict=True)), Fraction(0))
        mesh = _multiple(lines.tones, rest)
        if mesh is not None and any(slow) and sum(map(abs, slow)) <= _ORDER:
            return _Place(shaft=shaft, mesh=mesh, slow=slow)
    return None


def _multiple(tones: tuple[Fraction, ...], frequency: Fraction) -> Point | None:
    """The multiple of one mesh tone that a frequency is, of orders up to 2."""
    for axis, tone in enumerate(tones):
        order = frequency / tone
        if order.denominator == 1 and abs(order) <= 2:
            return tuple(int(order) if j == axis else 0 for j in range(len(tones)))
    return None


def _divided(tones: list[Fraction], places: list[_Place], shaft: Shaft) -> tuple[list[Fraction], list[_Place]] | None:
    """A tone divided so that a group becomes a small multiple of it, as all that stand on it already."""
    for i, tone in enumerate(tones):
        ratio = shaft.frequency / tone
        parts, orders = ratio.denominator, [abs(place.slow[i]) for place in places if len(place.slow) > i]
        if max(ratio.numerator, parts * max(orders, default=0)) <= _ORDER:
            finer = [value / parts if j == i else value for j, value in enumerate(tones)]
            moved = [
                _Place(
                    shaft=place.shaft,
                    mesh=place.mesh,
                    slow=tuple(a * parts if j == i else a for j, a in enumerate(place.slow)),
                )
                for place in places
            ]
            return finer, moved
    return None


def _lines(shaft: Shaft, mesh: Point, slow: Point) -> list[PlacedLine]:
    """Every line of a group at its point: a . f + base, or a . f - base as its conjugate."""
    placed: list[PlacedLine] = []
    for orders, minus, line in shaft.members:
        sign = -1 if minus else 1
        point = (*(a + sign * b for a, b in zip(orders, mesh, strict=True)), *(sign * s for s in slow))
        placed.append(placed_line(point, line))
    return placed
