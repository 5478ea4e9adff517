"""Line contact of two cylinders: approach against load per length, and its inverse [weber1953].

    u = A p (B - ln p),   A = (1 - nu_1^2)/(pi E_1) + (1 - nu_2^2)/(pi E_2),   p load per length [N/m]

between the middles of the two teeth, h_1 and h_2 below the surface.  u rises with p up to exp(B - 1), far above any
load of a tooth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["LineContact", "approach", "half_width", "largest_load", "line_contact", "load", "pressure"]

Array = NDArray[np.float64]

# Most Newton steps; they stop at rounding.  From below they converge for every approach in the range.
_STEPS = 40


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineContact:
    """Line contact at places of any shape (...).

    A : [m^2/N] and B : (...) [1] of the approach u = A p (B - ln p).  radius : (...) relative radius of curvature [m].
    """

    A: float
    B: Array
    radius: Array

    @property
    def compliance(self) -> float:
        """Compliance 1/E* = sum (1 - nu^2)/E of both bodies [1/Pa]."""
        return np.pi * self.A


def line_contact(
    radius: Array, depth_a: Array, depth_b: Array, *, youngs_modulus: tuple[float, float], poisson: tuple[float, float]
) -> LineContact:
    """Constants of the line contact of two bodies [weber1953].

    Parameters
    ----------
    radius : (...) relative radius of curvature [m].  depth_a, depth_b : (...) from the contact to the middle of each
        tooth, along the common normal [m].  youngs_modulus [Pa], poisson [1] : of each.
    """
    each = [(1 - nu**2) / (np.pi * E) for E, nu in zip(youngs_modulus, poisson, strict=True)]
    A = sum(each)
    # half width a^2 = 4 A p rho; each body gives (1 - nu^2)/(pi E) p [2 ln(2 h / a) - nu/(1 - nu)]
    shares = [value / A for value in each]
    constant = sum(share * nu / (1 - nu) for share, nu in zip(shares, poisson, strict=True))
    logs = 2 * (shares[0] * np.log(2 * depth_a) + shares[1] * np.log(2 * depth_b))
    return LineContact(A=A, B=logs - np.log(4 * A * radius) - constant, radius=np.asarray(radius, dtype=float))


def approach(line: LineContact, p: Array) -> Array:
    """Approach u (...) [m] at loads per length p >= 0 (...) [N/m] [weber1953]."""
    with np.errstate(divide="ignore", invalid="ignore"):
        value = line.A * p * (line.B - np.log(p))
    return np.where(p > 0, value, 0.0)


def largest_load(line: LineContact) -> Array:
    """Load per length (...) [N/m] up to which the approach rises with the load, by [weber1953].

    There the contact is so wide that a body of the depth of the tooth gives no more: the formula holds far below it.
    """
    return np.asarray(np.exp(line.B - 1))


def load(line: LineContact, u: Array) -> tuple[Array, Array]:
    """Load per length p (...) [N/m] and slope dp/du (...) [N/m^2] at approaches u (...) [m]; 0 where u <= 0.

    ln(p) - B is Lambert's W_-1.  Newton's method on the whole array stays: it is the innermost loop of loaded contact,
    and SciPy's `lambertw` is complex.
    """
    pressed = np.maximum(u, 0.0)
    y = np.minimum(pressed / line.A * np.exp(-line.B), (1 - 1e-9) / np.e)
    # p = exp(B) x with x (-ln x) = y: Newton on the logarithm l = ln x < -1, where g = l + ln(-l) - ln y rises
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        target = np.log(y)
        ell = target - np.log(-target)
        for _ in range(_STEPS):
            step = (ell + np.log(-ell) - target) / (1 + 1 / ell)
            ell = np.minimum(ell - step, -1 - 1e-12)
            if np.nanmax(np.abs(np.where(pressed > 0, step, 0.0)), initial=0.0) < 1e-14:
                break
        p = np.exp(line.B + ell)
        slope = 1 / (line.A * (-ell - 1))
    return np.where(pressed > 0, p, 0.0), np.where(pressed > 0, slope, 0.0)


def half_width(line: LineContact, p: Array) -> Array:
    """Half the width of the contact a = sqrt(4 p rho / (pi E*)) (...) [m] at loads per length p (...) [N/m]."""
    return np.sqrt(4 * line.A * np.maximum(p, 0.0) * line.radius)


def pressure(line: LineContact, p: Array) -> Array:
    """Largest contact pressure 2 p / (pi a) (...) [Pa] at loads per length p (...) [N/m]."""
    width = half_width(line, p)
    return np.where(width > 0, 2 * p / (np.pi * np.where(width > 0, width, 1.0)), 0.0)
