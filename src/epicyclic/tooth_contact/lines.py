"""Contact lines of one helix: pairs of teeth and segments of the face on the plane of action.

Pair j at zeta along the face is in contact at sigma + j + d h zeta/p_x base pitches from the pitch point while that
place is on the path of contact (docs/conventions.md, Phases).  A segment cut by the end of the path keeps the part on
the path, so that the length of all lines is exact at every phase; its mean is eps_alpha b/cos beta_b [maatar1996].
Spur teeth are in contact over the whole face at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["ContactLines", "PlaneOfAction", "contact_lines"]

Array = NDArray[np.float64]

# The radius of curvature vanishes at a base circle: a length of roll below this part of a base pitch counts as this.
_LEAST_ROLL = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneOfAction:
    """Plane of action of one helix; lengths [m], angles [rad].

    base_a, base_b : base radii.  internal : b is a ring.  pressure_angle : working transverse.  base_helix : beta_b,
    magnitude.  base_pitch : transverse p_bt.  limits : (sigma_min, sigma_max) of the path of contact [1].
    lean : d h of gear a, +1 or -1, 0 for spur teeth.  face_a, face_b : ends (left, right) of the faces along the axis,
    from the middle of the mesh, axial offsets of the gears included.
    """

    base_a: float
    base_b: float
    internal: bool = False
    pressure_angle: float
    base_helix: float = 0.0
    base_pitch: float
    limits: tuple[float, float]
    lean: int = 0
    face_a: tuple[float, float]
    face_b: tuple[float, float]

    @property
    def face(self) -> tuple[float, float]:
        """Overlap of both faces, (left, right) [m]."""
        return max(self.face_a[0], self.face_b[0]), min(self.face_a[1], self.face_b[1])

    @property
    def width(self) -> float:
        """Width of the overlap of both faces [m]."""
        return self.face[1] - self.face[0]

    @property
    def per_pitch(self) -> float:
        """d h/p_x, the shift of the contact per length along the face [base pitches/m]; 0 for spur teeth."""
        return self.lean * math.tan(self.base_helix) / self.base_pitch

    def roll_a(self, sigma: ArrayLike) -> Array:
        """Length of roll on a (...) [m]: from its base tangent point to the contact at sigma (...) [base pitches]."""
        return self.base_a * math.tan(self.pressure_angle) + np.asarray(sigma) * self.base_pitch

    def roll_b(self, sigma: ArrayLike) -> Array:
        """Length of roll on b (...) [m]: from its base tangent point to the contact at sigma (...) [base pitches]."""
        along = np.asarray(sigma) * (self.base_pitch if self.internal else -self.base_pitch)
        return self.base_b * math.tan(self.pressure_angle) + along

    def radius_a(self, sigma: ArrayLike) -> Array:
        """Radius (...) of the contact on gear a [m] at sigma (...) [base pitches]."""
        return np.hypot(self.base_a, self.roll_a(sigma))

    def radius_b(self, sigma: ArrayLike) -> Array:
        """Radius (...) of the contact on gear b [m] at sigma (...) [base pitches]."""
        return np.hypot(self.base_b, self.roll_b(sigma))

    def curvature_radius(self, sigma: ArrayLike) -> Array:
        """Relative radius of curvature (...) in the normal plane [m] at sigma (...), transverse over cos beta_b."""
        least = _LEAST_ROLL * self.base_pitch
        a, b = np.maximum(self.roll_a(sigma), least), np.maximum(self.roll_b(sigma), least)
        between = 1 / a + (-1 / b if self.internal else 1 / b)
        return np.asarray(1 / (between * math.cos(self.base_helix)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactLines:
    """Contact lines at T phases: J pairs of teeth, K segments of the face from left to right.

    zeta : (T, J, K) middle of the part of each segment on the path of contact, along the axis [m].  sigma : (T, J, K)
    its place on that path [base pitches].  length : (T, J, K) of contact line [m], 0 out of contact.
    pair : (T, J) number of the pair of teeth, one more for each that enters as sigma rises.
    centre, span : (K,) middles and (,) width of the segments along the axis [m].
    """

    zeta: Array
    sigma: Array
    length: Array
    pair: NDArray[np.int64]
    centre: Array
    span: float


def contact_lines(
    plane: PlaneOfAction, sigma: ArrayLike, slices: int, *, beyond: tuple[float, float] = (0.0, 0.0)
) -> ContactLines:
    """Contact lines at T places of one pair of teeth at mid-face.

    Parameters
    ----------
    sigma : (T,) [base pitches].  slices : K.  beyond : path of contact added before and behind its ends [base pitches].
    """
    place = np.atleast_1d(np.asarray(sigma, dtype=float))
    low, high = plane.limits[0] - beyond[0], plane.limits[1] + beyond[1]
    span = plane.width / slices
    centre: Array = plane.face[0] + span * (np.arange(slices, dtype=np.float64) + 0.5)
    lead = plane.per_pitch * centre
    half = 0.5 * abs(plane.per_pitch) * span
    first = math.floor(low - 1.0 - float(lead.max()) - half)
    last = math.ceil(high - float(lead.min()) + half)
    whole = np.floor(place)
    pairs = np.arange(first, last + 1)
    middle = (place - whole)[:, None, None] + pairs[:, None] + lead
    if half > 0:
        start, end = np.clip(middle - half, low, high), np.clip(middle + half, low, high)
        part = (end - start) / (2 * half)
        along = 0.5 * (start + end)
    else:
        part = ((middle >= low) & (middle < high)).astype(float)
        along = np.clip(middle, low, high)
    touched = part > 0
    inside = np.where(touched, along, middle)
    zeta = centre + (inside - middle) / plane.per_pitch if half > 0 else np.broadcast_to(centre, middle.shape)
    seen = np.flatnonzero(touched.any(axis=(0, 2)))
    kept = slice(int(seen[0]), int(seen[-1]) + 1) if seen.size else slice(0, 1)
    return ContactLines(
        zeta=zeta[:, kept],
        sigma=inside[:, kept],
        length=part[:, kept] * span / math.cos(plane.base_helix),
        pair=(whole[:, None] - pairs[None, kept]).astype(np.int64),
        centre=centre,
        span=span,
    )
