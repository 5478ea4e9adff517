"""Coupling along the face: Green's function of a tooth as a clamped plate with free ends.

Along its width a load per length p deflects a tooth like a beam on an elastic foundation,

    -lambda^2 u'' + u = q p,   u' = 0 at both ends
    G(z, s) = cosh(z/lambda) cosh((W - s)/lambda)/(lambda sinh(W/lambda)),   0 <= z <= s <= W

G is symmetric and positive, and its integral over the face is 1: a uniform load has the plane compliance.  At the free
edge of a long cantilever plate of height c a single load P deflects its own place by 0.1665 P c^2/D (0.168 is printed
[timoshenko1959, art. 49]) and a line load p by p c^3/(3 D), so that G(0) = 1/(2 lambda) asks for lambda = c.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["PLATE_DECAY", "face_coupling"]

Array = NDArray[np.float64]

# lambda over the height of a long cantilever plate (nu = 0.3) loaded at its free edge
PLATE_DECAY = 1 / (6 * 0.1665)

# Below this share of the decay length a segment counts as a point: the closed mean over it would cancel.
_POINT = 1e-6


def face_coupling(zeta: Array, width: float, decay: float, lengths: Array) -> Array:
    """Coupling matrix K: mean of G over pairs of segments of the face, (n, n) [1/m], symmetric, positive definite.

    Under loads P_j = p_j l_j on segments of plane compliance q [m^2/N] the mean deflection is u_i = q K_ij P_j.  Where
    the segments cover the face, K l = 1.  Derived here from the plate of [timoshenko1959].

    Parameters
    ----------
    zeta : (n,) middles of the segments from the middle of the face [m].  lengths : (n,) of the segments, within the
        face and disjoint [m].  width : of the face [m].  decay : lambda [m].
    """
    half = np.asarray(lengths, dtype=float) / (2 * decay)
    total = width / decay
    place = np.clip(np.asarray(zeta, dtype=float) / decay + total / 2, 0.0, total)
    low = np.minimum(place[:, None], place[None, :])
    high = np.maximum(place[:, None], place[None, :])
    spread = _log_mean_cosh(half)
    matrix = _product(low, total - high, total, spread[:, None] + spread[None, :])
    own = np.diag(_own(place, half, total) - np.diag(matrix))
    return np.asarray((matrix + own) / decay, dtype=np.float64)


def _own(place: Array, half: Array, total: float) -> Array:
    """Diagonal (n,) of lambda K [1]: 1 less the deflection that the load of a segment causes elsewhere.

    place, half, total : centres (n,), half lengths (n,) and width of the face, in decay lengths [1].
    """
    point = 2 * half < _POINT
    wide = np.where(point, 1.0, half)
    spread = _log_mean_cosh(wide)
    before = _ratio(place - wide, total - place, total, spread)
    behind = _ratio(total - place - wide, place, total, spread)
    return np.where(point, _product(place, total - place, total, 0.0), (1 - before - behind) / (2 * wide))


def _log_mean_cosh(half: Array) -> Array:
    """Logarithm (n,) [1] of the mean of cosh(c + t) over |t| <= half (n,), relative to cosh c."""
    wide = np.maximum(half, 1e-3)
    return np.asarray(np.where(half > 1e-3, wide + np.log(-np.expm1(-2 * wide) / (2 * wide)), half**2 / 6))


def _product(a: Array, b: Array, total: float, more: Array | float) -> Array:
    """cosh a cosh b / sinh(total) exp(more) (...) [1] for a, b >= 0 (...), bounded against overflow."""
    scale = np.exp(np.minimum(a + b - total + more, 0.0)) / (2 * -np.expm1(-2 * total))
    return np.asarray(scale * (1 + np.exp(-2 * a)) * (1 + np.exp(-2 * b)))


def _ratio(a: Array, b: Array, total: float, more: Array) -> Array:
    """sinh a cosh b / sinh(total) exp(more) (...) [1] for b >= 0 (...), bounded against overflow; 0 where a <= 0."""
    a = np.maximum(a, 0.0)
    scale = np.exp(np.minimum(a + b - total + more, 0.0)) / (2 * -np.expm1(-2 * total))
    return np.asarray(scale * -np.expm1(-2 * a) * (1 + np.exp(-2 * b)))
