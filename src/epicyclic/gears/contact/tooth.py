"""Compliance of a tooth over the height of the load, by potential energy, with the body under it.

The load of one length of contact line acts along the normal of the flank; it meets the middle of the tooth at a depth
h below the flank [weber1953].  From there to the root the tooth is a beam of variable section, wide enough for plane
strain: bending, shear (6/5) and compression.  Below the root the body tilts and shifts.  What happens between flank and
middle is contact, and not in here: see `hertz`, which takes h as its depth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from . import body
from .outline import GearForm, Outline, tooth_outline

__all__ = ["Parts", "ToothCompliance", "tooth_compliance"]

Array = NDArray[np.float64]

_KNOTS = 64
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(48)
_SHEAR = 6 / 5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Parts:
    """Compliance of a tooth by cause, all of one shape [m^2/N]: displacement along the normal per load per length."""

    bending: Array
    shear: Array
    compression: Array
    body: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ToothCompliance:
    """Compliance of a tooth against the radius of the load; of the gear itself, not of its virtual one.

    radius : (n,) knots, rising, from where the involute begins to the tip (of a ring from the tip outward) [m].
    table : (n, 5) bending, shear, compression, body [m^2/N] and depth to the middle of the tooth [m] at them.
    shared : what every tooth of the gear gives when one is loaded, because the body winds up; part of `body` [m^2/N].
    height : of the tooth above its root [m].  warnings : what lies outside the limits of a formula.
    """

    gear: GearForm
    outline: Outline
    radius: Array
    table: Array
    shared: float
    height: float
    warnings: tuple[str, ...]

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest radius of the involute [m]."""
        return float(self.radius[0]), float(self.radius[-1])

    def bending(self, radius: ArrayLike) -> Array:
        """Whole compliance q of the tooth and its body, without contact [m^2/N], at radii of any shape [m].

        Beyond the involute the value at its end.
        """
        return np.asarray(self._at(radius)[..., :4].sum(axis=-1))

    def parts(self, radius: ArrayLike) -> Parts:
        """The same by cause."""
        return Parts(
            **dict(zip(Parts.__dataclass_fields__, np.moveaxis(self._at(radius)[..., :4], -1, 0), strict=True))
        )

    def depth(self, radius: ArrayLike) -> Array:
        """From the flank to the middle of the tooth along the normal [m]."""
        return np.asarray(self._at(radius)[..., 4])

    def _at(self, radius: ArrayLike) -> Array:
        return np.asarray(CubicSpline(self.radius, self.table)(np.clip(radius, *self.limits)))


def tooth_compliance(gear: GearForm, *, path: str = "") -> ToothCompliance:
    """Compliance of the teeth of a gear.

    path : of the gear in the model file, for the message.

    Raises
    ------
    ModelError : pointed or undercut teeth, no body under them (see `outline.tooth_outline`).
    """
    shape = tooth_outline(gear, path=path)
    low, high = sorted((shape.form_radius, shape.tip))
    virtual = low + (high - low) * 0.5 * (1 - np.cos(np.pi * np.arange(_KNOTS) / (_KNOTS - 1)))
    psi, gamma = shape.flank_angle(virtual)
    half = virtual * np.sin(psi)
    along = virtual * np.cos(psi)
    place = (along - shape.tip if shape.internal else shape.tip - along) + half * np.tan(gamma)
    root = _root(shape)
    beam = _beam(shape, place, gamma, root, gear)
    foundation, shared, messages = _foundation(gear, shape, root)
    under = foundation.compliance(shape.depth[root] - place, gamma) + (shared if shape.internal else 0.0)
    table = np.column_stack([*beam, under, half / np.cos(gamma)])
    return ToothCompliance(
        gear=gear,
        outline=shape,
        radius=virtual - gear.to_virtual,
        table=table,
        shared=shared,
        height=float(shape.depth[root]),
        warnings=messages,
    )


def _root(shape: Outline) -> int:
    """Index of the section in which the tooth is held: where its tangent leaves the middle line by 30 deg (ring 60)."""
    angle = math.radians(60 if shape.internal else 30)
    return int(shape.form + np.searchsorted(shape.slope[shape.form :], angle))


def _beam(shape: Outline, place: Array, gamma: Array, root: int, gear: GearForm) -> tuple[Array, Array, Array]:
    """Bending, shear and compression (n,) of the beam between places on the middle line and the root [m^2/N]."""
    nu, plane = gear.poisson, gear.youngs_modulus / (1 - gear.poisson**2)
    G = gear.youngs_modulus / (2 * (1 + nu))
    length = np.maximum(shape.depth[root] - place, 0.0)
    arm = length[:, None] * 0.5 * (_POINTS + 1)
    weight = length[:, None] * 0.5 * _WEIGHTS
    thick = 2 * np.interp(place[:, None] + arm, shape.depth[: root + 1], shape.x[: root + 1])
    across, down = np.cos(gamma) ** 2, np.sin(gamma) ** 2
    bending = across * (12 * arm**2 / thick**3 * weight).sum(axis=1) / plane
    stretched = (weight / thick).sum(axis=1)
    return bending, _SHEAR * across * stretched / G, down * stretched / plane


def _foundation(gear: GearForm, shape: Outline, root: int) -> tuple[body.Foundation, float, tuple[str, ...]]:
    thickness = 2 * float(shape.x[root])
    E, nu = gear.youngs_modulus, gear.poisson
    bore, base = gear.bore + gear.to_virtual, shape.base
    inner, outer = (shape.root, bore) if shape.internal else (bore, shape.root)
    shared = body.winding(base, inner, outer, youngs_modulus=E, poisson=nu)
    if shape.internal:
        return body.half_plane(thickness, youngs_modulus=E, poisson=nu), shared, ()
    held, messages = body.held_at_bore(shape.root, bore, thickness, youngs_modulus=E)
    return held, shared, messages
