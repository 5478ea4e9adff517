"""What the body under a tooth gives: the tilt and shift of its root, per length of contact line.

    delta = q p,   q = cos^2 gamma / E [ L (u/S)^2 + M u/S + P (1 + Q tan^2 gamma) ]

gamma angle of the load against the cross line of the tooth, u distance from the root to where the line of load meets
the middle of the tooth, S thickness of the root.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["BODY_LIMITS", "Foundation", "half_plane", "held_at_bore", "winding"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Foundation:
    """Factors L, M, P [1/Pa], Q [1] of the deflection, and the thickness S of the root [m]."""

    L: float
    M: float
    P: float
    Q: float
    thickness: float

    def compliance(self, u: Array, gamma: Array) -> Array:
        """q [m^2/N] of loads at a distance u from the root [m] and an angle gamma [rad]."""
        ratio = u / self.thickness
        value = self.L * ratio**2 + self.M * ratio + self.P * (1 + self.Q * np.tan(gamma) ** 2)
        return np.asarray(np.cos(gamma) ** 2 * value)


# Rows L, M, P, Q of X = A/theta^2 + B h^2 + C h/theta + D/theta + E h + F [sainsot2004, table 1]: theta half the angle
# that the root spans, h = r_f/r_int.
_SAINSOT = (
    (-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045),
    (60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086),
    (-50.952e-5, 185.50e-3, 0.0538e-4, 53.300e-3, 0.2895, 0.9236),
    (-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904),
)
BODY_LIMITS = {"r_f/r_int": (1.4, 7.0), "theta_f": (0.01, 0.12)}


def held_at_bore(
    root: float, bore: float, thickness: float, *, youngs_modulus: float
) -> tuple[Foundation, tuple[str, ...]]:
    """Foundation of a tooth on a ring held at its bore, with what lies outside the limits [sainsot2004, eq. 5].

    root : radius of the root circle; bore : radius of the bore; thickness : of the tooth at its root [m].
    """
    ratio, theta = root / bore, 0.5 * thickness / root
    terms = (theta**-2, ratio**2, ratio / theta, 1 / theta, ratio, 1.0)
    L, M, P, Q = (math.fsum(c * t for c, t in zip(row, terms, strict=True)) for row in _SAINSOT)
    messages = tuple(
        f"gear body: {name} {value:.3g} is outside {low:g} .. {high:g} (Sainsot, Velex & Duverger 2004)"
        for (name, (low, high)), value in zip(BODY_LIMITS.items(), (ratio, theta), strict=True)
        if not low <= value <= high
    )
    E = youngs_modulus
    return Foundation(L=L / E, M=M / E, P=P / E, Q=Q, thickness=thickness), messages


def half_plane(thickness: float, *, youngs_modulus: float, poisson: float) -> Foundation:
    """Foundation of a tooth on a half plane in plane strain [weber1953].

    18/pi (u/S)^2 + 2 (1 - 2 nu)/(1 - nu) u/S + 4.8/pi (1 + (1 - nu)/2.4 tan^2 gamma), times (1 - nu^2)/E.
    """
    nu = poisson
    scale = (1 - nu**2) / youngs_modulus
    return Foundation(
        L=scale * 18 / math.pi,
        M=scale * 2 * (1 - 2 * nu) / (1 - nu),
        P=scale * 4.8 / math.pi,
        Q=(1 - nu) / 2.4,
        thickness=thickness,
    )


def winding(base: float, inner: float, outer: float, *, youngs_modulus: float, poisson: float) -> float:
    """How a ring in torsion, held at one circle, moves along the line of action [m^2/N].

    A moment p r_b turns the circle r_i against r_o by p r_b/(4 pi G) (1/r_i^2 - 1/r_o^2) (shear p r_b/(2 pi r^2)).
    """
    G = youngs_modulus / (2 * (1 + poisson))
    return base**2 / (4 * math.pi * G) * (inner**-2 - outer**-2)
