"""Formulas of teeth that the package itself does not need: tests compare its results with them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from epicyclic.teeth import geometry
from epicyclic.teeth.geometry import involute

__all__ = ["contact_line_length", "tip_thickness"]

Array = NDArray[np.float64]


def tip_thickness(
    teeth: int,
    module: float,
    pressure_angle: float,
    helix_angle: float,
    *,
    tip_radius: float,
    profile_shift: float = 0.0,
    internal: bool = False,
) -> float:
    """Transverse tooth thickness on the tip circle, as an arc [m]; negative where the flanks cross below the tip.

    Half the tooth spans (pi/2 + 2 x tan alpha_n)/z +- (inv alpha_t - inv alpha_a) [iso21771]; + outside.
    A ring tip inside the base circle counts as lying on it: there is no involute further in.
    """
    base = geometry.base_radius(teeth, module, pressure_angle, helix_angle)
    at_reference = involute(geometry.transverse_pressure_angle(pressure_angle, helix_angle))
    at_tip = involute(math.acos(min(1.0, base / tip_radius)))
    half = (0.5 * math.pi + 2.0 * profile_shift * math.tan(pressure_angle)) / teeth
    return 2.0 * tip_radius * (half + (at_tip - at_reference if internal else at_reference - at_tip))


def contact_line_length(
    sigma: ArrayLike,
    limits: tuple[float, float],
    overlap_ratio: float,
    *,
    face_width: float = 1.0,
    base_helix_angle: float = 0.0,
) -> Array:
    """Length of all contact lines of one helix, by counting the tooth pairs in contact [m].

    sigma : place of any one pair at mid-face [base pitches], any shape; the others stand whole pitches before and
    behind.  limits : (sigma_min, sigma_max); overlap_ratio [1]; face_width [m]; base_helix_angle [rad].
    Returns the shape of sigma.
    """
    place = np.asarray(sigma, dtype=float)
    window = max(overlap_ratio, 1e-12)  # spur: a step, halved where a pair stands exactly at a limit
    first = math.floor(limits[0] - 0.5 * window) - 1
    pairs = np.arange(first, math.ceil(limits[1] + 0.5 * window) + 2)
    pair = (place - np.floor(place))[..., np.newaxis] + pairs
    before, after = (np.clip((limit - pair) / window + 0.5, 0.0, 1.0) for limit in limits)
    return np.asarray((after - before).sum(axis=-1) * face_width / math.cos(base_helix_angle))
