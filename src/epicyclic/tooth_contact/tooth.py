"""Compliance of a tooth over the height of the load, by the potential-energy method, with the gear body under it.

The load of one length of contact line acts along the normal of the flank and meets the middle of the tooth at a depth
h below the flank [weber1953].  From there to the root the tooth is a beam of variable section in plane strain with
bending, shear (6/5) and compression.  It is clamped in the critical section of [iso6336] part 3, where the tangent of
the fillet is at 30 deg to the middle line (of a ring at 60 deg); below it `foundation` is the compliance of the gear
body, which couples neighbouring teeth.  The deformation between flank and middle is that of the line contact, `hertz`,
whose depth is h.

Helical teeth: the normal section of the virtual spur gear, per length of contact line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from ..errors import ModelError
from ..gears import geometry
from ..gears.outline import GearForm, Outline, tooth_outline
from ..warning_codes import CodedText
from . import foundation
from .kernel import face_decay

__all__ = ["NEIGHBOURS", "ComplianceParts", "ToothCompliance", "tooth_compliance"]

Array = NDArray[np.float64]

NEIGHBOURS = 4  # pitches over which the body couples teeth; those in contact together are nearer
_KNOTS = 64
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(48)
_SHEAR = 6 / 5
_LEAN, _LEAN_RING = math.radians(30), math.radians(60)  # of the tangent in the critical section


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ComplianceParts:
    """Compliance of a tooth by cause, each (...) [m^2/N]: displacement along the normal per load per length."""

    bending: Array
    shear: Array
    compression: Array
    body: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ToothCompliance:
    """Compliance of a tooth against the radius of the load on the gear itself (not on its virtual gear).

    knots : (n,) rising radii from the start of the involute to the tip (of a ring from the tip outward) [m].
    table : over them bending, shear, compression [m^2/N], depth [m], and the load of 1 N/m on the root (3,) in the
        components of `foundation`.  roots : (NEIGHBOURS + 1, 3, 3) compliance of the roots, see `root_compliance`.
    shared : winding of the body, common to all teeth of the gear and part of the body compliance [m^2/N].
    height : of the tooth above its critical section [m].  thickness : of the tooth there [m].
    warnings : of formulas outside their limits.
    """

    gear: GearForm
    outline: Outline
    knots: Array
    table: CubicSpline
    roots: Array
    shared: float
    height: float
    thickness: float
    warnings: tuple[CodedText, ...]

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest radius of the involute [m]."""
        return float(self.knots[0]), float(self.knots[-1])

    def face_decay(self, width: float) -> float:
        """Decay length of the coupling along the face, along the tooth [m], see `kernel`.

        width : of the face along the tooth [m].  Load spreads along the axis: on an inclined tooth it reaches further.
        """
        gear = self.gear
        slant = math.cos(geometry.base_helix_angle(gear.pressure_angle, gear.helix_angle))
        return face_decay(self.height, self.thickness, abs(gear.bore - gear.root), width) / slant

    def bending(self, radius: ArrayLike) -> Array:
        """Whole compliance q of the tooth and its body, without contact, (...) [m^2/N] at radii (...) [m].

        Beyond the involute the value at its end.
        """
        found = self.parts(radius)
        return found.bending + found.shear + found.compression + found.body

    def parts(self, radius: ArrayLike) -> ComplianceParts:
        """Compliance of the tooth by cause, (...) [m^2/N] at radii (...) [m]."""
        at = self._at(radius)
        under = np.einsum("...i,ij,...j->...", at[..., 4:], self.roots[0], at[..., 4:])
        return ComplianceParts(bending=at[..., 0], shear=at[..., 1], compression=at[..., 2], body=under)

    def depth(self, radius: ArrayLike) -> Array:
        """Distance (...) [m] from the flank to the middle of the tooth along the normal, at radii (...) [m]."""
        return np.asarray(self._at(radius)[..., 3])

    def cross(self, radius: ArrayLike, other: ArrayLike, ahead: ArrayLike) -> Array:
        """Cross compliance of the body (...) [m^2/N]: motion of a tooth at `radius` per load per length at `other`.

        radius, other : (...) [m].  ahead : (...) whole pitches, of any sign, by which the loaded tooth is ahead on the
            side that the loaded flanks face; 0 is the same tooth; beyond NEIGHBOURS as there.  With flanks that face
            the push (gear a of a pair) the pair at sigma + 1 is one pitch ahead, else (gear b) one behind.
        """
        count = np.clip(np.asarray(ahead, dtype=np.int64), -NEIGHBOURS, NEIGHBOURS)
        moved, loaded = self._at(radius)[..., 4:], self._at(other)[..., 4:]
        found = np.zeros(np.broadcast_shapes(moved.shape[:-1], loaded.shape[:-1], count.shape))
        # one matrix for each number of pitches: no array of matrices, of which there are as many as results
        for pitches in range(int(count.min()), int(count.max()) + 1):
            turned = moved @ (self.roots[pitches] if pitches >= 0 else self.roots[-pitches].T)
            work = turned[..., 0] * loaded[..., 0] + turned[..., 1] * loaded[..., 1] + turned[..., 2] * loaded[..., 2]
            np.copyto(found, work, where=count == pitches)
        return found

    def _at(self, radius: ArrayLike) -> Array:
        """Columns of the table (..., 7) at radii (...) [m]."""
        return np.asarray(self.table(np.clip(radius, *self.limits)))


def tooth_compliance(gear: GearForm, *, under: Literal["ring", "fit"] = "ring", path: str = "") -> ToothCompliance:
    """Compliance of the teeth of a gear by the potential-energy method.

    under : gear body as an elastic ring, or by the published fit [sainsot2004] (external teeth; neighbours uncoupled).
    path : of the gear in the model file, for the message.

    Raises
    ------
    ModelError : pointed or undercut teeth, no body under them (see `outline.tooth_outline`), a fit for a ring.
    """
    shape = tooth_outline(gear, path=path)
    low, high = sorted((shape.form_radius, shape.tip))
    radius = low + (high - low) * 0.5 * (1 - np.cos(np.pi * np.arange(_KNOTS) / (_KNOTS - 1)))
    psi, gamma = shape.flank_angle(radius)
    half, along = radius * np.sin(psi), radius * np.cos(psi)
    crossing = along + half * np.tan(gamma) * (1 if shape.internal else -1)  # of the load and the middle of the tooth
    section = _critical(shape)
    root = _root(gear, shape, section)
    roots, shared, messages = _body(gear, shape, root, under, path)
    load = np.stack([-np.cos(gamma), np.sin(gamma) * (1 if shape.internal else -1)], axis=1)
    moment = load[:, 0] * (crossing - root.middle)
    beam = _beam(shape, crossing, gamma, section, gear)
    table = np.column_stack([*beam, half / np.cos(gamma), load, moment])
    knots = radius - gear.to_virtual
    return ToothCompliance(
        gear=gear,
        outline=shape,
        knots=knots,
        table=CubicSpline(knots, table),
        roots=roots,
        shared=shared,
        height=float(shape.depth[section]),
        thickness=root.thickness,
        warnings=messages,
    )


def _critical(shape: Outline) -> int:
    """Index of the critical section, in which the tooth is clamped [iso6336]."""
    lean = _LEAN_RING if shape.internal else _LEAN
    return int(shape.form + np.searchsorted(shape.slope[shape.form :], lean))


def _root(gear: GearForm, shape: Outline, section: int) -> foundation.ToothRoot:
    """Root of the tooth on the body of the virtual gear, whose radii have the ratios of those of the gear."""
    return foundation.ToothRoot(
        circle=float(shape.radius[section]),
        held=gear.bore * shape.root / gear.root,
        thickness=2 * float(shape.x[section]),
        pitch=2 * shape.half_pitch,
    )


def _body(
    gear: GearForm, shape: Outline, root: foundation.ToothRoot, under: str, path: str
) -> tuple[Array, float, tuple[CodedText, ...]]:
    """Compliance of the roots (NEIGHBOURS + 1, 3, 3), of the winding [m^2/N], and warnings."""
    E, nu = gear.youngs_modulus, gear.poisson
    shared = foundation.torsional_compliance(root, shape.base, youngs_modulus=E, poisson=nu)
    if under == "ring":
        return foundation.root_compliance(root, NEIGHBOURS, youngs_modulus=E, poisson=nu), shared, ()
    if shape.internal:
        raise ModelError("the fit is for external teeth", path=path, given=under, allowed="ring")
    own, messages = foundation.sainsot_compliance(root, youngs_modulus=E)
    return np.concatenate([own[None], np.zeros((NEIGHBOURS, 3, 3))]), shared, messages


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
