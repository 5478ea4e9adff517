"""Coupling along the face: Green's function of a tooth as a clamped plate with free ends.

Along its width a load per length p twists and bends a tooth like a beam on an elastic foundation (derived here),

    kappa^4 lambda^4 u'''' - lambda^2 u'' + u = q p,    u'' = 0 and kappa^4 lambda^2 u''' = u' at both ends

The second derivative is torsion about an axis along the face; the fourth is bending along the face, which spreads the
load of a point and lets the free ends tilt.  Green's function G is symmetric and positive definite, and its integral
over the face is 1: a uniform load has the plane compliance.  With the roots r of kappa^4 r^4 - r^2 + 1 = 0 it is a sum
of exp(-r |z - s|/lambda), one wide and one local, and of what both ends return.

A thin cantilever plate of height h that deflects over its height like a beam under an end load has lambda = 0.71 h and
kappa = 0.75 (nu = 0.3).  A tooth is as thick as it is high and stands on an elastic body: `face_decay`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["face_coupling", "face_decay"]

Array = NDArray[np.float64]

# Fitted to finite elements of teeth on gear bodies (docs/theory/teeth/face.json, table in docs/theory/contact.md):
# lambda per height, its powers of the depth of the body and of the thickness of the tooth, each per height, and
# kappa.  A deep body spreads the load further; a thick tooth yields more by shear and by its body than by bending.
_PER_HEIGHT, _BODY, _THICKNESS, _BENDING = 0.65, 0.12, -0.37, 0.6

_ROOTS = np.sqrt((1 + np.array([-1, 1]) * math.sqrt(1 - 4 * _BENDING**4)) / (2 * _BENDING**4))
# of the endless face: G = sum of _SHARES exp(-_ROOTS |z - s|/lambda)/lambda
_SHARES = np.array([1, -1]) / (2 * _BENDING**4 * (_ROOTS[1] ** 2 - _ROOTS[0] ** 2) * _ROOTS)

# A face narrower than this many lambda tilts by less than 4e-3 of its deflection; a wider lambda changes nothing there,
# and the waves of both ends would cancel with the fourth power.
_NARROW = 0.2
# Below this the mean over the own segment cancels; the series to the fourth power is exact to rounding.
_SHORT = 1e-3


def face_decay(height: float, thickness: float, body: float, width: float) -> float:
    """Decay length lambda of a tooth along its face [m]; fitted to finite elements in three dimensions.

    lambda^2 goes with the torsional stiffness of the tooth, a bar whose section is a rectangle of width and thickness.

    Parameters
    ----------
    height : of the tooth above its critical section [m].  thickness : there [m].  body : depth of the gear body, from
        the root circle to where it is held [m].  width : of the face [m].
    """
    shape = (body / height) ** _BODY * (thickness / height) ** _THICKNESS
    return float(_PER_HEIGHT * height * shape * math.sqrt(_torsion_share(width / thickness)))


def face_coupling(zeta: Array, width: float, decay: float, lengths: Array) -> Array:
    """Coupling matrix K: mean of G over pairs of segments of the face, (n, n) [1/m], symmetric, positive definite.

    Under loads P_j = p_j l_j on segments of plane compliance q [m^2/N] the mean deflection is u_i = q K_ij P_j.  Where
    the segments cover the face, K l = 1.  Derived here.

    Parameters
    ----------
    zeta : (n,) middles of the segments from the middle of the face [m].  lengths : (n,) of the segments, within the
        face and disjoint [m].  width : of the face [m].  decay : lambda [m].
    """
    decay = min(decay, width / _NARROW)
    total = width / decay
    length = np.asarray(lengths, dtype=float) / decay
    edge = 0.5 * (total - length)
    place = np.minimum(np.maximum(np.asarray(zeta, dtype=float) / decay, -edge), edge)
    half = 0.5 * length
    apart = np.maximum(np.abs(place[:, None] - place) - (half[:, None] + half), 0.0)
    mean, own = _segment_means(_ROOTS[:, None] * length)
    found = np.zeros(apart.shape)
    for share, root, ends, at in zip(_SHARES, _ROOTS, mean, own, strict=True):
        term = np.exp(-root * apart)
        term *= share * ends[:, None]
        term *= ends
        term.flat[:: len(ends) + 1] = share * at
        found += term
    mean *= 0.5
    right, left = (np.exp(_ROOTS[:, None] * gap) * mean for gap in (place - edge, -place - edge))
    for returned, waves in zip(_returned(total), (right + left, right - left), strict=True):
        found += waves.T @ returned @ waves
    found += found.T.copy()
    found *= 0.5 / decay
    return found


def _returned(total: float) -> Array:
    """Amplitudes of the free waves that make both ends free, per wave of the load at the ends, (2, 2, 2) [1].

    Even waves (first) are cosh(r z), odd ones sinh(r z), both over exp(r W/2); total : W, lengths in lambda.
    Both conditions at the end, moment and shear, read r^2 and 1/r of a wave (kappa^4 r^2 - 1 = -1/r^2).
    """
    found = np.empty((2, 2, 2))
    (a, b), (share_a, share_b) = _ROOTS.tolist(), _SHARES.tolist()
    for returned, sign in zip(found, (1, -1), strict=True):
        # Cramer's rule in plain numbers: arrays of two are all overhead
        moment_a, moment_b = (0.5 * root**2 * (1 + sign * math.exp(-root * total)) for root in (a, b))
        shear_a, shear_b = (-0.5 / root * (1 - sign * math.exp(-root * total)) for root in (a, b))
        scale = -1 / (moment_a * shear_b - moment_b * shear_a)
        returned[0] = (a**2 * shear_b - moment_b / a) * share_a, (b**2 * shear_b - moment_b / b) * share_b
        returned[1] = (moment_a / a - a**2 * shear_a) * share_a, (moment_a / b - b**2 * shear_a) * share_b
        returned *= scale
    return found


def _segment_means(x: Array) -> tuple[Array, Array]:
    """Means of exp(-s) over 0 <= s <= x and of exp(-|s - t|) over 0 <= s, t <= x (...) [1]."""
    safe = np.maximum(x, _SHORT)
    fallen = np.expm1(-safe)
    single, double = fallen / -safe, 2 * (safe + fallen) / safe**2
    short = x < _SHORT
    if short.any():
        single = np.where(short, 1 - x / 2 * (1 - x / 3 * (1 - x / 4)), single)
        double = np.where(short, 1 - x / 3 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6))), double)
    return single, double


def _torsion_share(ratio: float) -> float:
    """Torsional stiffness of a bar of rectangular section b, t over that of a thin one, b t^3/3 [1]; ratio : b/t.

    Saint-Venant's series: 1 - 0.63 t/b for b > 2 t.
    """
    if ratio < 1:
        return ratio**2 * _torsion_share(1 / ratio)
    n = np.arange(1, 20, 2)
    return float(1 - 192 / (math.pi**5 * ratio) * np.sum(np.tanh(0.5 * math.pi * n * ratio) / n**5))
