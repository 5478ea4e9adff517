"""Compliance of a tooth: coupling along the face, the gear body under it, and the tooth over the height of the load.

Along its width a load per length p twists and bends a tooth, a clamped plate with free ends, like a beam on an elastic
foundation (derived here),

    kappa^4 lambda^4 u'''' - lambda^2 u'' + u = q p,    u'' = 0 and kappa^4 lambda^2 u''' = u' at both ends

where q is the compliance of the plane section.  The second derivative is torsion about an axis along the face; the
fourth is bending along the face, which spreads the load of a point and lets the free ends tilt.  Green's function G is
symmetric and positive definite, and its integral over the face is 1: a uniform load has the plane compliance.  With the
roots r of kappa^4 r^4 - r^2 + 1 = 0 it is a sum of exp(-r |z - s|/lambda), one wide and one local, and of what both
ends return.  A thin cantilever plate of height h that deflects over its height like a beam under an end load has
lambda = 0.71 h and kappa = 0.75 (nu = 0.3).  A tooth is as thick as it is high and stands on an elastic body:
`face_decay`.

The gear body is an elastic ring held at its bore, of a ring gear at its rim, and loaded at tooth roots.  The root of a
tooth loads the arc it spans: a cross force and a normal force evenly, a moment linearly distributed [sainsot2004].
Plane strain of the ring is solved exactly, harmonic by harmonic, with the potentials of Kolosov and Muskhelishvili
(derived here).  The motion of a root is the work conjugate of the same distribution of load, so that the compliance is
symmetric.  The displacement field reaches the neighbouring teeth and couples them.  The teeth do not stiffen the ring.
The published fit [sainsot2004, eq. 5] is the same ring with the motion read at the middle of the root, which gives 10
to 30 % more.

The tooth is taken by the potential-energy method.  The load of one length of contact line acts along the normal of the
flank and meets the middle of the tooth at a depth h below the flank [weber1953].  From there to the root the tooth is a
beam of variable section in plane strain with bending, shear (6/5) and compression.  It is clamped in the critical
section of [iso6336] part 3, where the tangent of the fillet is at 30 deg to the middle line (of a ring at 60 deg);
below it stands the gear body.  The deformation between flank and middle is that of the line contact, whose depth is h.
Helical teeth: the normal section of the virtual spur gear, per length of contact line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import geometry
from .form import GearForm, Outline, tooth_outline

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

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

# Orders up to _ORDERS/theta: what is dropped goes with their square and is 2e-4 of the whole.
_ORDERS = 80
_ANGLE_POINTS, _ANGLE_WEIGHTS = np.polynomial.legendre.leggauss(96)

NEIGHBOURS = 4  # pitches over which the body couples teeth; those in contact together are nearer
_KNOTS = 64
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(48)
_SHEAR = 6 / 5
_LEAN, _LEAN_RING = math.radians(30), math.radians(60)  # of the tangent in the critical section


# along the face ------------------------------------------------------------------------------------------------------


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
    mean, own_mean = _segment_means(_ROOTS[:, None] * length)
    coupling = np.zeros(apart.shape)
    for share, root, ends, at in zip(_SHARES, _ROOTS, mean, own_mean, strict=True):
        term = np.exp(-root * apart)
        term *= share * ends[:, None]
        term *= ends
        term.flat[:: len(ends) + 1] = share * at
        coupling += term
    mean *= 0.5
    right, left = (np.exp(_ROOTS[:, None] * gap) * mean for gap in (place - edge, -place - edge))
    for returned, waves in zip(_returned(total), (right + left, right - left), strict=True):
        coupling += waves.T @ returned @ waves
    coupling += coupling.T.copy()
    coupling *= 0.5 / decay
    return coupling


def _returned(total: float) -> Array:
    """Amplitudes of the free waves that make both ends free, per wave of the load at the ends, (2, 2, 2) [1].

    Even waves (first) are cosh(r z), odd ones sinh(r z), both over exp(r W/2); total : W, lengths in lambda.
    Both conditions at the end, moment and shear, read r^2 and 1/r of a wave (kappa^4 r^2 - 1 = -1/r^2).
    """
    amplitudes = np.empty((2, 2, 2))
    (a, b), (share_a, share_b) = _ROOTS.tolist(), _SHARES.tolist()
    for returned, sign in zip(amplitudes, (1, -1), strict=True):
        # Cramer's rule in plain numbers: arrays of two are all overhead
        moment_a, moment_b = (0.5 * root**2 * (1 + sign * math.exp(-root * total)) for root in (a, b))
        shear_a, shear_b = (-0.5 / root * (1 - sign * math.exp(-root * total)) for root in (a, b))
        scale = -1 / (moment_a * shear_b - moment_b * shear_a)
        returned[0] = (a**2 * shear_b - moment_b / a) * share_a, (b**2 * shear_b - moment_b / b) * share_b
        returned[1] = (moment_a / a - a**2 * shear_a) * share_a, (moment_a / b - b**2 * shear_a) * share_b
        returned *= scale
    return amplitudes


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


# gear body -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothRoot:
    """Root of a tooth on the gear body; lengths [m].

    circle : radius of the loaded circle through the roots.  held : radius at which the body is held, inside or outside
    that circle.  thickness : of the tooth at its root.  pitch : angle between neighbouring teeth [rad].  bends : orders
    2 .. of a ring with a free rim that are left out, as of `GearForm`.
    """

    circle: float
    held: float
    thickness: float
    pitch: float
    bends: int = 0

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
    angle, length = theta * _ANGLE_POINTS, theta * R * _ANGLE_WEIGHTS
    even, odd = _components(angle, length, R)
    cos, sin = np.cos(np.outer(orders, angle)) * length, np.sin(np.outer(orders, angle)) * length
    # of the tractions (radial, tangential) on the circle, cos and sin parts of every order: two families that a quarter
    # of a wave turns into each other, (U cos, V sin) and (-U sin, V cos)
    first = np.stack([even @ cos.T, odd @ sin.T], axis=-1)
    second = np.stack([-even @ sin.T, odd @ cos.T], axis=-1)
    norm = np.where(orders == 0, 0.5, 1.0) / (np.pi * R) * outward
    C = _harmonics(orders[-1], root.held / R, youngs_modulus, poisson, bends=root.bends) * (R * norm)[:, None, None]
    # work of the first family on itself and of one on the other: a load turned by s is cos(ns) of its own family and
    # sin(ns) of the other
    same_family = np.einsum("ina,nab,jnb->nij", first, C, first) + np.einsum("ina,nab,jnb->nij", second, C, second)
    mixed = np.einsum("ina,nab,jnb->nij", first, C, second) - np.einsum("ina,nab,jnb->nij", second, C, first)
    turned = np.outer(np.arange(neighbours + 1) * root.pitch, orders)
    return np.asarray(
        np.einsum("sn,nij->sij", np.cos(turned), same_family) + np.einsum("sn,nij->sij", np.sin(turned), mixed)
    )


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


def _harmonics(highest: int, held: float, E: float, nu: float, *, bends: int = 0) -> Array:
    """Motion (U, V) per stress (radial, shear) on a circle of radius 1, orders 0 .. highest, (orders, 2, 2) [1/Pa].

    u_r = U cos n t, u_t = V sin n t; the circle of radius `held` is fixed.  bends : where not 0 it is free for orders
    from 2, and those up to this one are left out.
    """
    kappa, mu = 3 - 4 * nu, E / (2 * (1 + nu))
    n = np.arange(1.0, highest + 1)
    loaded, fixed = (_fields(n, r, kappa, (min(1.0, held), max(1.0, held))) for r in (1.0, held))
    # order 1 carries a resultant force: a logarithm takes the place of one of its two rigid motions
    loaded[0, :, 1], fixed[0, :, 1] = _source(1.0, kappa), _source(held, kappa)
    far = np.where((bends > 0) & (n > 1), 1, 0)[:, None, None]
    system = np.concatenate([loaded[:, 2:], np.where(far, fixed[:, 2:], fixed[:, :2])], axis=1)
    right = np.zeros((len(n), 4, 2))
    right[:, 0, 0] = right[:, 1, 1] = 1.0
    motion = np.zeros((highest + 1, 2, 2))
    motion[1:] = loaded[:, :2] @ np.linalg.solve(system, right)
    motion[2 : bends + 1] = 0.0
    lame = np.linalg.solve([[2.0, 1.0], [held * (kappa - 1), -1 / held]], [1.0, 0.0])
    motion[0] = np.diag([(kappa - 1) * lame[0] - lame[1], held**-2 - 1])  # breathing, and winding: a ring in torsion
    return motion / (2 * mu)


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


# tooth ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ComplianceParts:
    """Compliance of a tooth by cause, each (...) [m^2/N]: displacement along the normal per load per length."""

    bending: Array
    shear: Array
    compression: Array
    body: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class ToothCompliance:
    """Compliance of a tooth against the radius of the load on the gear itself (not on its virtual gear).

    knots : (n,) rising radii from the start of the involute to the tip (of a ring from the tip outward) [m].
    table : (n, 7) over them bending, shear, compression [m^2/N], depth [m], and the load of 1 N/m on the root (3,) in
        the components of the gear body.  roots : (NEIGHBOURS + 1, 3, 3) compliance of the roots, see `root_compliance`.
    shared : winding of the body, common to all teeth of the gear and part of the body compliance [m^2/N].
    height : of the tooth above its critical section [m].  thickness : of the tooth there [m].
    """

    gear: GearForm
    outline: Outline
    knots: Array
    table: Array
    roots: Array
    shared: float
    height: float
    thickness: float

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest radius of the involute [m]."""
        return float(self.knots[0]), float(self.knots[-1])

    def face_decay(self, width: float) -> float:
        """Decay length of the coupling along the face, along the tooth [m], see `face_decay`.

        width : of the face along the tooth [m].  Load spreads along the axis: on an inclined tooth it reaches further.
        """
        gear = self.gear
        slant = math.cos(geometry.base_helix_angle(gear.pressure_angle, gear.helix_angle))
        return face_decay(self.height, self.thickness, abs(gear.bore - gear.root), width) / slant

    def bending(self, radius: ArrayLike) -> Array:
        """Whole compliance q of the tooth and its body, without contact, (...) [m^2/N] at radii (...) [m].

        Beyond the involute the value at its end.
        """
        parts = self.parts(radius)
        return parts.bending + parts.shear + parts.compression + parts.body

    def parts(self, radius: ArrayLike) -> ComplianceParts:
        """Compliance of the tooth by cause, (...) [m^2/N] at radii (...) [m]."""
        at = self._at(radius)
        under = np.einsum("...i,ij,...j->...", at[..., 4:], self.roots[0], at[..., 4:])
        return ComplianceParts(bending=at[..., 0], shear=at[..., 1], compression=at[..., 2], body=under)

    def depth(self, radius: ArrayLike) -> Array:
        """Distance (...) [m] from the flank to the middle of the tooth along the normal, at radii (...) [m]."""
        return np.asarray(self._at(radius)[..., 3])

    def body_factors(self, radius: ArrayLike, tooth: ArrayLike) -> tuple[Array, Array]:
        """Cross compliance of the body L C L' (..., n, n) [m^2/N], in factors L (..., n, 3 J) and C (3 J, 3 J).

        It is the motion of one contact per load per length at another: of the load on the root and of the compliance
        between the roots of J neighbouring teeth.

        radius : (..., n) of the contacts [m].  tooth : (..., n) of each the tooth, 0 .. J - 1, which rises to the side
            that the loaded flanks face; beyond NEIGHBOURS pitches teeth count as there.  With flanks that face the push
            (gear a of a pair) the tooth of the pair at sigma + 1 is the next one, else (gear b) the one before.
        """
        count = int(np.max(tooth)) + 1
        ahead = np.arange(count) - np.arange(count)[:, None]
        roots = self.roots[np.minimum(np.abs(ahead), NEIGHBOURS)]
        roots = np.where((ahead < 0)[:, :, None, None], roots.swapaxes(2, 3), roots)
        return columns_of_teeth(self._at(radius)[..., 4:], tooth), roots.swapaxes(1, 2).reshape(3 * count, 3 * count)

    def cross(self, radius: ArrayLike, tooth: ArrayLike) -> Array:
        """Cross compliance of the body (..., n, n) [m^2/N]: motion of a contact per load per length at another.

        radius, tooth : as of `body_factors`.
        """
        loads, roots = self.body_factors(radius, tooth)
        return np.asarray(loads @ roots @ loads.swapaxes(-1, -2))

    @cached_property
    def _spline(self) -> CubicSpline:
        from scipy.interpolate import CubicSpline  # a sixth of the start of a command that asks no tooth

        return CubicSpline(self.knots, self.table)

    def _at(self, radius: ArrayLike) -> Array:
        """Columns of the table (..., 7) at radii (...) [m]."""
        return np.asarray(self._spline(np.clip(radius, *self.limits)))


def columns_of_teeth(values: Array, tooth: ArrayLike) -> Array:
    """Values (..., n, k) in k columns for each of J teeth, (..., n, k J): on the tooth (..., n) of each, else zero."""
    on = np.asarray(tooth)[..., None] == np.arange(int(np.max(tooth)) + 1)
    spread = on[..., None] * values[..., None, :]
    return np.asarray(spread.reshape(*spread.shape[:-2], -1))


def tooth_compliance(gear: GearForm, *, path: str = "") -> ToothCompliance:
    """Compliance of the teeth of a gear by the potential-energy method, on an elastic ring.

    path : of the gear in the model file, for the message.

    Raises
    ------
    ModelError : pointed or undercut teeth, no body under them (see `outline.tooth_outline`).
    """
    shape = tooth_outline(gear, path=path)
    low, high = sorted((shape.form_radius, shape.tip))
    radius = low + (high - low) * 0.5 * (1 - np.cos(np.pi * np.arange(_KNOTS) / (_KNOTS - 1)))
    psi, gamma = shape.flank_angle(radius)
    half, along = radius * np.sin(psi), radius * np.cos(psi)
    crossing = along + half * np.tan(gamma) * (1 if shape.internal else -1)  # of the load and the middle of the tooth
    # the tooth is clamped in the critical section [iso6336]
    lean = _LEAN_RING if shape.internal else _LEAN
    section = int(shape.form + np.searchsorted(shape.slope[shape.form :], lean))
    # on the body of the virtual gear, whose radii have the ratios of those of the gear
    root = ToothRoot(
        circle=float(shape.radius[section]),
        held=gear.bore * shape.root / gear.root,
        thickness=2 * float(shape.x[section]),
        pitch=2 * shape.half_pitch,
        bends=gear.bends,
    )
    elastic = {"youngs_modulus": gear.youngs_modulus, "poisson": gear.poisson}
    load = np.stack([-np.cos(gamma), np.sin(gamma) * (1 if shape.internal else -1)], axis=1)
    moment = load[:, 0] * (crossing - root.middle)
    beam = _beam(shape, crossing, gamma, section, gear)
    table = np.column_stack([*beam, half / np.cos(gamma), load, moment])
    knots = radius - gear.to_virtual
    return ToothCompliance(
        gear=gear,
        outline=shape,
        knots=knots,
        table=table,
        roots=root_compliance(root, NEIGHBOURS, **elastic),
        shared=torsional_compliance(root, shape.base, **elastic),
        height=float(shape.depth[section]),
        thickness=root.thickness,
    )


def _beam(shape: Outline, crossing: Array, gamma: Array, section: int, gear: GearForm) -> tuple[Array, Array, Array]:
    """Bending, shear and compression (n,) [m^2/N] of the beam from crossings (n,) [m] to the section.

    gamma : (n,) angle of the load against the cross line [rad].
    """
    nu, plane = gear.poisson, gear.youngs_modulus / (1 - gear.poisson**2)
    G = gear.youngs_modulus / (2 * (1 + nu))
    place = crossing - shape.tip if shape.internal else shape.tip - crossing
    length = np.maximum(shape.depth[section] - place, 0.0)
    arm = length[:, None] * 0.5 * (_POINTS + 1)
    weight = length[:, None] * 0.5 * _WEIGHTS
    thick = 2 * np.interp(place[:, None] + arm, shape.depth[: section + 1], shape.x[: section + 1])
    across, down = np.cos(gamma) ** 2, np.sin(gamma) ** 2
    bending = across * (12 * arm**2 / thick**3 * weight).sum(axis=1) / plane
    stretched = (weight / thick).sum(axis=1)
    return bending, _SHEAR * across * stretched / G, down * stretched / plane
