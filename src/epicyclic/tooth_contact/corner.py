"""Corner contact: the edge of a tip on the flank of the mate, before and behind the path of contact.

Before the path of contact the tip of b approaches the flank of a; behind it the tip of a leaves that of b.  Their
separation follows from the involutes alone at any distance, and grows near the ends as the square of the distance
(derived here).  The deflection of the pairs in mesh closes it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .lines import PlaneOfAction

__all__ = ["corner_reach", "tip_separation"]

Array = NDArray[np.float64]


def tip_separation(plane: PlaneOfAction, sigma: ArrayLike) -> Array:
    """Separation of a tip and the flank of the mate along the tooth normal, beyond the path of contact (...) [m].

    sigma : (...) place on the continued path of contact [base pitches].  0 on the path itself, inf where the mate has
    no flank.
    """
    place = np.asarray(sigma, dtype=float)
    total = np.zeros_like(place)
    for past, tip_of_b in ((plane.limits[0] - place, True), (place - plane.limits[1], False)):
        apart = _of_tip(plane, np.maximum(past, 0.0), tip_of_b=tip_of_b)
        total = np.where(past > 0, np.maximum(apart, 0.0), total)  # rounding may leave a negative separation
    return np.asarray(total * math.cos(plane.base_helix))


def corner_reach(plane: PlaneOfAction, gap: float) -> tuple[float, float]:
    """Distances beyond both ends of the path of contact at which the separation reaches a gap [m] [base pitches].

    At most one base pitch.
    """
    # Bisection stays: the separation is infinite where a tip has left the flank, and a secant step would stop there.
    found = []
    for edge, away in ((plane.limits[0], -1.0), (plane.limits[1], 1.0)):
        low, high = 0.0, 1.0
        for _ in range(50):  # to rounding of one base pitch
            middle = 0.5 * (low + high)
            low, high = (middle, high) if float(tip_separation(plane, edge + away * middle)) < gap else (low, middle)
        found.append(high)
    return found[0], found[1]


def _of_tip(plane: PlaneOfAction, past: Array, *, tip_of_b: bool) -> Array:
    """Transverse separation (...) [m] at distances (...) past the end of the path [base pitches].

    Axes e and t of docs/conventions.md (The mesh row) as a complex plane, with d = +1.
    """
    alpha, base_a, base_b = plane.pressure_angle, plane.base_a, plane.base_b
    centre = complex((base_b - base_a) * -1 if plane.internal else base_a + base_b) / math.cos(alpha)
    edge = plane.limits[0] if tip_of_b else plane.limits[1]
    point = base_a / math.cos(alpha) + edge * plane.base_pitch * complex(math.sin(alpha), math.cos(alpha))
    turned = past * plane.base_pitch
    sense = 1.0 if plane.internal else -1.0
    if tip_of_b:  # b turns back by the distance past the end; its tip meets the flank of a
        moved = centre + (point - centre) * np.exp(-1j * sense * turned / base_b)
        flank = _flank(moved, base_a, alpha, edge - past, plane.base_pitch)
        return np.asarray(base_a * (np.angle(moved) - flank))
    moved = point * np.exp(1j * turned / base_a)
    seen = moved - centre
    if plane.internal:
        flank = _flank(seen, base_b, alpha, edge + past, plane.base_pitch)
        return np.asarray(base_b * (flank - np.angle(seen)))
    # in the axes of b the geometry is the same, rotated by half a turn, and sigma has the opposite sense
    flank = _flank(-seen, base_b, alpha, -(edge + past), plane.base_pitch)
    return np.asarray(base_b * (np.angle(-seen) - flank))


def _flank(point: NDArray[np.complex128], base: float, alpha: float, sigma: Array, pitch: float) -> Array:
    """Polar angle (...) of the involute through sigma at the radius of points (...) [rad]; -inf in the base circle."""
    start = math.tan(alpha) + sigma * pitch / base - alpha
    radius = np.abs(point)
    angle = np.arccos(np.minimum(1.0, base / radius))
    return np.asarray(np.where(radius > base, start - (np.tan(angle) - angle), -np.inf))
