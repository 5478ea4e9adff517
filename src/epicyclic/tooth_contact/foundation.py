"""Compliance of the gear body under the teeth (foundation): an elastic ring held at its bore, loaded at tooth roots.

A ring gear is held at its rim.  The root of a tooth loads the arc it spans: a cross force and a normal force evenly, a
moment linearly distributed [sainsot2004].  Plane strain of the ring is solved exactly, harmonic by harmonic, with the
potentials of Kolosov and Muskhelishvili (derived here).  The motion of a root is the work conjugate of the same
distribution of load, so that the compliance is symmetric.  The displacement field reaches the neighbouring teeth and
couples them.  The teeth do not stiffen the ring.

The published fit [sainsot2004, eq. 5] is the same ring with the motion read at the middle of the root, which gives 10
to 30 % more; it is kept for comparison, with its limits of validity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..warning_codes import CodedText, coded

__all__ = ["FIT_LIMITS", "ToothRoot", "root_compliance", "sainsot_compliance", "torsional_compliance"]

Array = NDArray[np.float64]

# Orders up to _ORDERS/theta: what is dropped goes with their square and is 2e-4 of the whole.
_ORDERS = 80
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(96)


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothRoot:
    """Root of a tooth on the gear body; lengths [m].

    circle : radius of the loaded circle through the roots.  held : radius at which the body is held, inside or outside
    that circle.  thickness : of the tooth at its root.  pitch : angle between neighbouring teeth [rad].
    """

    circle: float
    held: float
    thickness: float
    pitch: float

    @property
    def theta(self) -> float:
        """Half the angle of the arc of the root, theta_f [rad] [sainsot2004]."""
        return math.asin(0.5 * self.thickness / self.circle)

    @property
    def middle(self) -> float:
        """Radius of the centroid of the arc, the reference point of the moment [m]."""
        return self.circle * math.sin(self.theta) / self.theta


def root_compliance(root: ToothRoot, neighbours: int, *, youngs_modulus: float, poisson: float) -> Array:
    """Compliance of the roots: motion of one per load on another, (neighbours + 1, 3, 3), plane strain, per length.

    First axis: the loaded tooth is 0, 1, ... pitches from the moved one, clockwise.  Loads and motions of a tooth that
    points along y: along x, along y [m^2/N], and about the centroid of the root, clockwise [1/N].
    youngs_modulus : [Pa].  poisson : [1].  Derived here.
    """
    theta, R = root.theta, root.circle
    outward = 1.0 if root.held < R else -1.0
    orders = np.arange(int(_ORDERS / theta) + 1)
    angle, length = theta * _POINTS, theta * R * _WEIGHTS
    even, odd = _components(angle, length, R)
    cos, sin = np.cos(np.outer(orders, angle)) * length, np.sin(np.outer(orders, angle)) * length
    # of the tractions (radial, tangential) on the circle, cos and sin parts of every order: two families that a quarter
    # of a wave turns into each other, (U cos, V sin) and (-U sin, V cos)
    first = np.stack([even @ cos.T, odd @ sin.T], axis=-1)
    second = np.stack([-even @ sin.T, odd @ cos.T], axis=-1)
    norm = np.where(orders == 0, 0.5, 1.0) / (np.pi * R) * outward
    C = _harmonics(orders[-1], root.held / R, youngs_modulus, poisson) * (R * norm)[:, None, None]
    # work of the first family on itself and of one on the other: a load turned by s is cos(ns) of its own family and
    # sin(ns) of the other
    own = np.einsum("ina,nab,jnb->nij", first, C, first) + np.einsum("ina,nab,jnb->nij", second, C, second)
    mixed = np.einsum("ina,nab,jnb->nij", first, C, second) - np.einsum("ina,nab,jnb->nij", second, C, first)
    turned = np.outer(np.arange(neighbours + 1) * root.pitch, orders)
    return np.asarray(np.einsum("sn,nij->sij", np.cos(turned), own) + np.einsum("sn,nij->sij", np.sin(turned), mixed))


def _components(angle: Array, length: Array, radius: float) -> tuple[Array, Array]:
    """Radial and tangential tractions (3, points) [1/m] of unit loads: uniform along x, uniform along y, linear over x.

    angle : (points,) clockwise from y [rad].  length : (points,) quadrature weights along the arc [m].
    """
    x = radius * np.sin(angle)
    across = np.full_like(angle, 1 / length.sum())
    tilt = -x / np.sum(length * x**2)
    zero = np.zeros_like(angle)
    tx, ty = np.stack([across, zero, zero]), np.stack([zero, across, tilt])
    radial, tangent = (np.sin(angle), np.cos(angle)), (np.cos(angle), -np.sin(angle))
    return tx * radial[0] + ty * radial[1], tx * tangent[0] + ty * tangent[1]


def _harmonics(highest: int, held: float, E: float, nu: float) -> Array:
    """Motion (U, V) per stress (radial, shear) on a circle of radius 1, orders 0 .. highest, (orders, 2, 2) [1/Pa].

    u_r = U cos n t, u_t = V sin n t; the circle of radius `held` is fixed.
    """
    kappa, mu = 3 - 4 * nu, E / (2 * (1 + nu))
    n = np.arange(1.0, highest + 1)
    loaded, fixed = (_fields(n, r, kappa, (min(1.0, held), max(1.0, held))) for r in (1.0, held))
    # order 1 carries a resultant force: a logarithm takes the place of one of its two rigid motions
    loaded[0, :, 1], fixed[0, :, 1] = _source(1.0, kappa), _source(held, kappa)
    system = np.concatenate([loaded[:, 2:], fixed[:, :2]], axis=1)
    right = np.zeros((len(n), 4, 2))
    right[:, 0, 0] = right[:, 1, 1] = 1.0
    found = np.zeros((highest + 1, 2, 2))
    found[1:] = loaded[:, :2] @ np.linalg.solve(system, right)
    lame = np.linalg.solve([[2.0, 1.0], [held * (kappa - 1), -1 / held]], [1.0, 0.0])
    found[0] = np.diag([(kappa - 1) * lame[0] - lame[1], held**-2 - 1])  # breathing, and winding: a ring in torsion
    return found / (2 * mu)


def _fields(n: Array, r: float, kappa: float, circles: tuple[float, float]) -> Array:
    """2 mu (U, V) and (radial stress, shear) at a radius, of the four elementary solutions of order n, (orders, 4, 4).

    phi = z^(1 + n), z^(1 - n), then psi = z^(n - 1), z^(-n - 1), each scaled to 1 where it is largest in the ring.
    """
    columns = []
    for k, sense in ((1 + n, 1.0), (1 - n, -1.0)):
        x = (r / np.where(k > 0, circles[1], circles[0])) ** k
        columns.append([x * (kappa - k), sense * x * (kappa + k), x * k * (3 - k) / r, sense * x * k * (k - 1) / r])
    for k, sense in ((n - 1, 1.0), (-n - 1, -1.0)):
        x = (r / np.where(k > 0, circles[1], circles[0])) ** k
        columns.append([-x, sense * x, -k * x / r, sense * k * x / r])
    return np.moveaxis(np.array(columns), 2, 0).swapaxes(1, 2).copy()


def _source(r: float, kappa: float) -> Array:
    """2 mu (U, V) and (radial stress, shear), (4,), of phi = log z, psi = -kappa log z, which is single-valued."""
    log = 2 * kappa * math.log(r)
    return np.array([log - 1, -log - 1, (3 + kappa) / r, (1 - kappa) / r])


def torsional_compliance(root: ToothRoot, base: float, *, youngs_modulus: float, poisson: float) -> float:
    """Compliance of the ring in torsion along the line of action, common to all teeth [m^2/N].

    A moment p r_b causes the shear stress p r_b/(2 pi r^2) and turns the loaded circle by
    p r_b/(4 pi G) |1/r_i^2 - 1/r_o^2|.  base : base radius r_b [m].  Derived here.
    """
    G = youngs_modulus / (2 * (1 + poisson))
    return base**2 / (4 * math.pi * G) * abs(root.held**-2 - root.circle**-2)


# the published fit ---------------------------------------------------------------------------------------------------

# Rows L, M, P, Q of X = A/theta^2 + B h^2 + C h/theta + D/theta + E h + F, h = r_f/r_int [sainsot2004, table 1].
_FIT = (
    (-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045),
    (60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086),
    (-50.952e-5, 185.50e-3, 0.0538e-4, 53.300e-3, 0.2895, 0.9236),
    (-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904),
)
FIT_LIMITS = {"r_f/r_int": (1.4, 7.0), "theta_f": (0.01, 0.12)}


def sainsot_compliance(root: ToothRoot, *, youngs_modulus: float) -> tuple[Array, tuple[CodedText, ...]]:
    """Compliance of a root (3, 3) [m^2/N] as of `root_compliance`, by the published fit, with warnings on its limits.

    cos^2 g/E [L (u/S)^2 + M u/S + P (1 + Q tan^2 g)] [sainsot2004, eq. 5] at an angle g and a distance u is linear in
    force and moment.
    """
    ratio, theta = root.circle / root.held, root.theta
    terms = (theta**-2, ratio**2, ratio / theta, 1 / theta, ratio, 1.0)
    L, M, P, Q = (math.fsum(c * t for c, t in zip(row, terms, strict=True)) for row in _FIT)
    S = root.thickness
    motion = np.array([[P, 0.0, 0.5 * M / S], [0.0, P * Q, 0.0], [0.5 * M / S, 0.0, L / S**2]])
    messages = tuple(
        coded(
            "formula-outside-limits",
            f"gear body: {name} {value:.3g} is outside {low:g} .. {high:g} (Sainsot, Velex & Duverger 2004)",
        )
        for (name, (low, high)), value in zip(FIT_LIMITS.items(), (ratio, theta), strict=True)
        if not low <= value <= high
    )
    return motion / youngs_modulus, messages
