"""Sliding along the path of contact, loss factor of a mesh, and the mean coefficient of friction of its teeth.

At the distance s from the pitch point the teeth of a pair slide on each other with v_s = |s| (w_a + w_b), in a ring
|s| (w_a - w_b), across the plane of action; w are speeds in the frame of the carrier.  The normal force F_n transmits
the power F_n cos beta_b v with v = w_a r_ba = w_b r_bb, so that of a power P the friction takes mu H_V P with

    H_V = 2 pi / cos beta_b |1/z_a +- 1/z_b| <|sigma|>        - for a ring b, s = sigma p_bt, r_b = z p_bt / 2 pi

where <|sigma|> is the mean of |sigma| over mesh cycle and contact lines, weighted with the load on them.  Derived here.
With uniform load per length of contact line every spur pair in contact bears the same, and between contact ratios of 1
and 2 this is pi (u + 1)/(z_a u) (1 - eps + eps_1^2 + eps_2^2) [ohlendorf1958].  Places sigma count from the pitch point
in base pitches, as of `geometry.contact_limits`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Limits = tuple[float, float]

# Nodes of Gauss and Legendre between two corners of contact: the integrand, a quadratic over a linear function, is
# then exact to rounding unless contact is all but lost.
_NODES = 24
# Below this overlap ratio teeth count as spur: what the helix changes is then below rounding.
_SPUR = 1e-9
# Length of contact line [base pitches of overlap] that counts as none: rounding.
_NONE = 1e-12


def loss_factor(teeth_a: int, teeth_b: int, base_helix: float, distance: float, *, internal: bool = False) -> float:
    """Loss factor H_V of a mesh [1]; derived here.

    Parameters
    ----------
    base_helix : beta_b [rad].  distance : <|sigma|>, as of `sliding_distance` [base pitches].  internal : b is a ring.
    """
    slide = 1 / teeth_a - 1 / teeth_b if internal else 1 / teeth_a + 1 / teeth_b
    return math.tau / math.cos(base_helix) * abs(slide) * distance


def touches_always(limits: Limits, overlap: float) -> bool:
    """Whether some contact line bears at every instant; overlap : overlap ratio [1]."""
    if overlap <= _SPUR:
        return limits[1] - limits[0] >= 1 - _NONE
    return bool(_line_length(_corners(limits, overlap), limits, overlap).min() > _NONE)


def sliding_distance(limits: Limits, overlap: float = 0.0) -> float:
    """Mean distance <|sigma|> of the load from the pitch point with uniform load per length of contact line [1].

    Parameters
    ----------
    limits : (sigma_min, sigma_max) of the path of contact [base pitches].  overlap : overlap ratio of one helix [1].
        Contact must not be lost (`touches_always`).
    """
    # integral over the phase from corner to corner of contact
    corners = _corners(limits, overlap)
    node, share = np.polynomial.legendre.leggauss(_NODES)
    half = np.diff(corners)[:, None] / 2
    middle = corners[:-1, None] + half
    phase, weight = (middle + half * node).ravel(), (half * share).ravel()
    places = _places(phase, limits, overlap)
    if overlap <= _SPUR:
        on = (places >= limits[0]) & (places <= limits[1])
        moment, length = np.where(on, np.abs(places), 0.0).sum(axis=1), on.sum(axis=1)
    else:
        low, high = _on_path(places, limits, overlap)
        moment = np.where(high > low, high * np.abs(high) - low * np.abs(low), 0.0).sum(axis=1) / 2
        length = np.maximum(high - low, 0.0).sum(axis=1)
    return float(weight @ (moment / length))


def path_load(limits: Limits, overlap: float, sigma: ArrayLike) -> Array:
    """Mesh force per base pitch at places of the path of contact, per mesh force (n,) [1]; uniform load per length.

    Mean over mesh cycle and face; of spur teeth the share of a pair in contact there.  Its integral over the path is 1.
    sigma : (n,) [base pitches].  limits, overlap : as of `sliding_distance`.
    """
    at = np.atleast_1d(np.asarray(sigma, dtype=float))
    inside = (at >= limits[0]) & (at <= limits[1])
    if overlap <= _SPUR:
        places = _places(at, limits, 0.0)
        count = ((places >= limits[0] - _NONE) & (places <= limits[1] + _NONE)).sum(axis=1)
        return np.where(inside, 1 / np.maximum(count, 1), 0.0)
    # a place is passed by the contact line at phases sigma .. sigma + overlap, from one end of the face to the other
    return np.where(inside, _inverse_length(at + overlap, limits, overlap) - _inverse_length(at, limits, overlap), 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rolling:
    """Motion of two flanks along the path of contact, at the places sigma (n,) [base pitches].

    speed_a, speed_b : of the flanks across the line of contact [m/s], one sign where both roll one way.
    """

    speed_a: Array
    speed_b: Array

    @classmethod
    def of(
        cls,
        sigma: ArrayLike,
        *,
        base_a: float,
        base_b: float,
        pressure_angle: float,
        base_pitch: float,
        base_speed: float,
        internal: bool,
    ) -> Rolling:
        """Rolling of the flanks of a pair.

        Parameters
        ----------
        base_a, base_b : base radii [m].  pressure_angle : working transverse [rad].  base_pitch : transverse [m].
        base_speed : of the base circles in the frame of the carrier, w_a r_ba [m/s].  internal : b is a ring.
        """
        along = np.asarray(sigma, dtype=float) * base_pitch
        roll_a = base_a * math.tan(pressure_angle) + along
        roll_b = base_b * math.tan(pressure_angle) + (along if internal else -along)
        return cls(speed_a=base_speed * roll_a / base_a, speed_b=base_speed * roll_b / base_b)

    @property
    def sliding(self) -> Array:
        """Sliding speed, flank of a less flank of b (n,) [m/s]."""
        return self.speed_a - self.speed_b

    @property
    def specific_a(self) -> Array:
        """Specific sliding of a, sliding speed per speed of its flank (n,) [1]; infinite at the base tangent point."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.sliding / self.speed_a)

    @property
    def specific_b(self) -> Array:
        """Specific sliding of b (n,) [1], as of a."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(-self.sliding / self.speed_b)


def mean_friction(
    load_per_width: float, sum_speed: float, curvature_radius: float, viscosity: float, roughness: float
) -> float:
    """Mean coefficient of friction of lubricated teeth [1] [iso14179], with the lubricant factor 1 of mineral oils.

    0.048 (F_bt/b / (v_sigma rho))^0.2 eta^-0.05 Ra^0.25 in N/mm, m/s, mm, mPa s and um; meant for loads of 150 N/mm and
    more and pitch-line speeds up to 50 m/s.

    Parameters
    ----------
    load_per_width : F_bt / b, transverse normal force per face width [N/m].
    sum_speed : sum of the speeds of both flanks at the pitch point [m/s].
    curvature_radius : relative, there, in the normal plane [m].
    viscosity : dynamic, of the oil in the mesh [Pa s].  roughness : mean Ra of both flanks [m].
    """
    load = load_per_width * 1e-3 / (sum_speed * curvature_radius * 1e3)
    return float(0.048 * load**0.2 * (viscosity * 1e3) ** -0.05 * (roughness * 1e6) ** 0.25)


def _corners(limits: Limits, overlap: float) -> Array:
    """Phases in [0, 1] between which the contact lines change smoothly, rising, with both ends."""
    passed = [end + shift for end in (*limits, 0.0) for shift in (0.0, overlap)]
    return np.unique(np.concatenate([[0.0, 1.0], np.mod(passed, 1.0)]))


def _places(phase: Array, limits: Limits, overlap: float) -> Array:
    """Places (m, J) of the leading end of every contact line that may touch, at phases (m,) [base pitches]."""
    first, last = math.floor(limits[0] - phase.max()), math.ceil(limits[1] + overlap - phase.min())
    return phase[:, None] + np.arange(first, last + 1)


def _on_path(places: Array, limits: Limits, overlap: float) -> tuple[Array, Array]:
    """Ends (low, high) of the part of every contact line on the path; low >= high where there is none."""
    return np.maximum(places - overlap, limits[0]), np.minimum(places, limits[1])


def _line_length(phase: Array, limits: Limits, overlap: float) -> Array:
    """Length of all contact lines (m,) at phases (m,), in base pitches along the path."""
    low, high = _on_path(_places(phase, limits, overlap), limits, overlap)
    return np.asarray(np.maximum(high - low, 0.0).sum(axis=1))


def _inverse_length(phase: Array, limits: Limits, overlap: float) -> Array:
    """Integral of 1 / `_line_length` from 0 to phases (n,) [1]."""
    corners = _corners(limits, overlap)
    length = _line_length(corners, limits, overlap)
    piece = np.diff(corners) / _log_mean(length[:-1], length[1:])
    before = np.concatenate([[0.0], np.cumsum(piece)])
    turn, part = np.floor(phase), np.mod(phase, 1.0)
    at = np.clip(np.searchsorted(corners, part, side="right") - 1, 0, len(piece) - 1)
    step = part - corners[at]
    reached = length[at] + (length[at + 1] - length[at]) * step / (corners[at + 1] - corners[at])
    return np.asarray(turn * before[-1] + before[at] + step / _log_mean(length[at], reached))


def _log_mean(one: Array, other: Array) -> Array:
    """Logarithmic mean (n,), whose inverse is the mean of 1/x of a linear x from one to the other."""
    apart = (other - one) / one
    varies = apart != 0
    safe = np.where(varies, apart, 1.0)
    return np.asarray(one * np.where(varies, safe / np.log1p(safe), 1.0))
