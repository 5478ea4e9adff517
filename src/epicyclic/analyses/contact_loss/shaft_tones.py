"""Shaft tones: the few frequencies whose small multiples, with mesh orders, are all the shaft lines.

Frequencies are exact fractions, so every line is a multiple of one very low frequency, of an order that no lattice
could hold.  Wanted is a small set of tones of which each line is a combination with orders up to 4, modulo the mesh
frequencies (derived here; the torus of several tones as of [lau1983]).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np

from ...questions.response.excitation import LineExcitation, Shaft
from ...questions.response.lattice import Point
from ...questions.response.response import Response
from .lattice_points import PlacedLine, placed_line

__all__ = ["ShaftTones", "shaft_tones"]

# Highest order of a shaft tone that a line may stand on: a lattice of orders up to 4 still holds it.
_ORDER = 4
# Highest order of a mesh tone that a line may have beside its shaft tones; chosen, a group is named by its lowest line.
_MESH_ORDER = 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShaftTones:
    """Shaft lines on a lattice of mesh tones and shaft tones.

    tones : exact frequencies [Hz] at the operating speed.  highest : largest order of each that a line stands on.
    lines : placed on (mesh orders, shaft orders).  superposed : groups of lines for which there was no tone left.
    """

    tones: tuple[Fraction, ...]
    highest: tuple[int, ...]
    lines: tuple[PlacedLine, ...]
    superposed: tuple[Shaft, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Place:
    """A group whose frequency is mesh . mesh tones + orders . shaft tones."""

    shaft: Shaft
    mesh: Point
    orders: Point


def shaft_tones(ready: Response, groups: Sequence[Shaft], *, most: int) -> ShaftTones:
    """Shaft tones for groups of shaft lines, the strongest first; groups beyond `most` tones are superposed."""
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
    padded = [(*place.orders, *(0,) * (width - len(place.orders))) for place in places]
    return ShaftTones(
        tones=tuple(tones),
        highest=tuple(max(abs(point[i]) for point in padded) for i in range(width)),
        lines=tuple(
            line for place, point in zip(places, padded, strict=True) for line in _lines(place.shaft, place.mesh, point)
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


def _placed(lines: LineExcitation, tones: list[Fraction], shaft: Shaft) -> _Place | None:
    """The combination of least order that has the frequency of a group, None where none of small order has."""
    reach = range(-_ORDER, _ORDER + 1)
    every = sorted(product(reach, repeat=len(tones)), key=lambda orders: (sum(map(abs, orders)), [-a for a in orders]))
    for orders in every:
        rest = shaft.frequency - sum((a * tone for a, tone in zip(orders, tones, strict=True)), Fraction(0))
        mesh = _multiple(lines.tones, rest)
        if mesh is not None and any(orders) and sum(map(abs, orders)) <= _ORDER:
            return _Place(shaft=shaft, mesh=mesh, orders=orders)
    return None


def _multiple(tones: tuple[Fraction, ...], frequency: Fraction) -> Point | None:
    """The multiple of one mesh tone that a frequency is, of orders up to 2, None where it is none."""
    for axis, tone in enumerate(tones):
        order = frequency / tone
        if order.denominator == 1 and abs(order) <= _MESH_ORDER:
            return tuple(int(order) if j == axis else 0 for j in range(len(tones)))
    return None


def _divided(tones: list[Fraction], places: list[_Place], shaft: Shaft) -> tuple[list[Fraction], list[_Place]] | None:
    """A tone divided so that a group becomes a small multiple of it, as all that stand on it already."""
    for i, tone in enumerate(tones):
        ratio = shaft.frequency / tone
        parts, orders = ratio.denominator, [abs(place.orders[i]) for place in places if len(place.orders) > i]
        if max(ratio.numerator, parts * max(orders, default=0)) <= _ORDER:
            finer = [value / parts if j == i else value for j, value in enumerate(tones)]
            moved = [
                _Place(
                    shaft=place.shaft,
                    mesh=place.mesh,
                    orders=tuple(a * parts if j == i else a for j, a in enumerate(place.orders)),
                )
                for place in places
            ]
            return finer, moved
    return None


def _lines(shaft: Shaft, mesh: Point, own: Point) -> list[PlacedLine]:
    """Every line of a group at its point: a . f + base, or a . f - base as its conjugate."""
    placed: list[PlacedLine] = []
    for orders, minus, line in shaft.members:
        sign = -1 if minus else 1
        point = (*(a + sign * b for a, b in zip(orders, mesh, strict=True)), *(sign * s for s in own))
        placed.append(placed_line(point, line))
    return placed
