"""Mesh stiffness by potential energy: tooth pairs side by side, coupled by the bodies under them.

Where pairs j touch at a place sigma + j, a load p_j per length of contact line moves them by

    sum_k [ delta_jk (beam_a + beam_b + contact) + body_a(j, k) + body_b(j, k) ] p_k = d,     k(sigma) = sum p / d

all at the radius of the load, contact as the tangent of Hertz and Weber's line contact at a nominal load.  This is a
plane section.  A helical face is cut into such sections, each at its own sigma, that do not hold on to each other: the
usual energy method.  The sum over the face is then the mean of k over the overlap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..gears import geometry
from ..gears.series import ComplexArray
from ..gears.stiffness import DEFAULT_HARMONICS
from . import hertz
from .tooth import ToothCompliance

__all__ = ["MeshedTeeth", "energy_series", "interference_warnings", "section_stiffness"]

Array = NDArray[np.float64]

# How far a tip may reach below the involute of its mate [modules]: up to the first without a word, since the fillet
# leaves the involute smoothly; up to the second it is told; beyond, the fillet is in the way of the tip.
_TOLD, _DIG = 0.02, 0.1
_POINTS = 24  # of Gauss' rule between two jumps, and two more for every order


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshedTeeth:
    """Two gears in mesh, a external.

    working_angle : transverse [rad].  limits : (sigma_min, sigma_max) between which a pair of teeth touches.
    """

    a: ToothCompliance
    b: ToothCompliance
    working_angle: float
    limits: tuple[float, float]

    @property
    def base_helix(self) -> float:
        """Base helix angle, magnitude [rad]."""
        return abs(geometry.base_helix_angle(self.a.gear.pressure_angle, self.a.gear.helix_angle))

    def rolled(self, sigma: Array) -> tuple[Array, Array]:
        """Distances of the contact from the points where the line of action leaves the base circles [m]."""
        tangent = math.tan(self.working_angle)
        gear = self.a.gear
        along = sigma * geometry.base_pitch(gear.module, gear.pressure_angle, gear.helix_angle)
        side = 1.0 if self.b.gear.internal else -1.0
        return _base(self.a) * tangent + along, _base(self.b) * tangent + side * along

    def radii(self, sigma: Array) -> tuple[Array, Array]:
        """Radii of the contact on a and b at places sigma [m]."""
        on_a, on_b = self.rolled(sigma)
        return np.hypot(_base(self.a), on_a), np.hypot(_base(self.b), on_b)


def section_stiffness(mesh: MeshedTeeth, sigma: Array, load: float) -> Array:
    """Stiffness along the normal per length of contact line of one plane section [N/m^2], at places sigma (n,).

    load : per length of contact line, at which the contact is taken [N/m].  Zero where no pair touches.

    Raises
    ------
    ModelError : a load that is not positive.
    """
    if not (load > 0 and math.isfinite(load)):
        raise ModelError("is no load per length of contact line", given=load, allowed="above 0 N/m")
    low, high = mesh.limits
    first = math.floor(low - float(np.max(sigma)))
    pairs = np.arange(float(first), math.ceil(high - float(np.min(sigma))) + 1)
    place = np.asarray(sigma, dtype=float)[:, None] + pairs
    on = (place >= low) & (place <= high)
    at: Array = np.clip(place, low, high)
    radius_a, radius_b = mesh.radii(at)
    own = _beams(mesh.a, radius_a) + _beams(mesh.b, radius_b) + _contact(mesh, at, radius_a, radius_b, load)
    ahead = pairs[None, :] - pairs[:, None]
    whole = mesh.a.cross(radius_a[:, :, None], radius_a[:, None, :], ahead)
    whole = whole + mesh.b.cross(radius_b[:, :, None], radius_b[:, None, :], -ahead)
    index = np.arange(len(pairs))
    whole[:, index, index] += own
    both = on[:, :, None] & on[:, None, :]
    scale = own.max()
    matrix = np.where(both, whole / scale, np.eye(len(pairs)))
    shares = np.linalg.solve(matrix, on[:, :, None].astype(float))[:, :, 0]
    return np.asarray(shares.sum(axis=1) / scale)


def energy_series(
    mesh: MeshedTeeth, load: float, *, harmonics: int = DEFAULT_HARMONICS, path: str = ""
) -> tuple[float, ComplexArray]:
    """Mean stiffness of a plane section over a mesh cycle [N/m^2] and its relative coefficients v_l (L,) over sigma.

    The stiffness jumps where a pair comes or goes; between the jumps it is integrated by Gauss' rule.
    path : of the mesh in the model file, for the message.

    Raises
    ------
    ModelError : a load that is not positive, a contact ratio below 1, tips that interfere (see `interference_warnings`).
    """
    low, high = mesh.limits
    if not high - low >= 1:
        given = f"contact ratio {high - low:.3g}"
        raise ModelError("contact is lost between tooth pairs", path=path, given=given, allowed="1 or more")
    interference_warnings(mesh, path=path)
    jumps = np.unique(np.concatenate([[0.0, 1.0], np.mod([low, high], 1.0)]))
    middle, half = 0.5 * (jumps[1:] + jumps[:-1]), 0.5 * np.diff(jumps)
    points, weights = np.polynomial.legendre.leggauss(_POINTS + 2 * harmonics)
    sigma = (middle[:, None] + half[:, None] * points).ravel()
    weight = (half[:, None] * weights).ravel()
    stiffness = section_stiffness(mesh, sigma, load) * weight
    mean = float(stiffness.sum())
    order = np.arange(1, harmonics + 1)
    turns = np.exp(-2j * np.pi * np.outer(order, sigma))
    return mean, np.asarray(2 / mean * (turns @ stiffness), dtype=np.complex128)


def _base(tooth: ToothCompliance) -> float:
    gear = tooth.gear
    return geometry.base_radius(gear.teeth, gear.module, gear.pressure_angle, gear.helix_angle)


def _beams(tooth: ToothCompliance, radius: Array) -> Array:
    parts = tooth.parts(radius)
    return parts.bending + parts.shear + parts.compression


def _contact(mesh: MeshedTeeth, sigma: Array, radius_a: Array, radius_b: Array, load: float) -> Array:
    """Tangent of the approach of two flanks at a load, du/dp [m^2/N]."""
    on_a, on_b = mesh.rolled(sigma)
    # at the very end of an involute the curvature is endless; there the tooth is thicker than any contact is wide
    on_a, on_b = np.maximum(on_a, 1e-3 * mesh.a.gear.module), np.maximum(on_b, 1e-3 * mesh.a.gear.module)
    relative = 1 / on_a + (-1 / on_b if mesh.b.gear.internal else 1 / on_b)
    line = hertz.line_contact(
        1 / (relative * math.cos(mesh.base_helix)),
        mesh.a.depth(radius_a),
        mesh.b.depth(radius_b),
        youngs_modulus=(mesh.a.gear.youngs_modulus, mesh.b.gear.youngs_modulus),
        poisson=(mesh.a.gear.poisson, mesh.b.gear.poisson),
    )
    return np.asarray(line.A * (line.B - math.log(load) - 1))


def interference_warnings(mesh: MeshedTeeth, *, path: str = "") -> tuple[str, ...]:
    """What is to be told of tips that reach below the involute of their mate.

    path : of the mesh in the model file, for the message.

    Raises
    ------
    ModelError : a tip that digs into the fillet.
    """
    ends = np.array(mesh.limits)
    depths = [
        np.max(_below(tooth, radius, rolled))
        for tooth, radius, rolled in zip((mesh.a, mesh.b), mesh.radii(ends), mesh.rolled(ends), strict=True)
    ]
    told = []
    for depth, mate, tooth in zip(depths, ("second", "first"), (mesh.b, mesh.a), strict=True):
        text = f"the tips of the {mate} gear reach {depth * 1e3:.3g} mm below the involute of their mate"
        if depth > _DIG * tooth.gear.module:
            given = f"tip radius {tooth.gear.tip * 1e3:.5g} mm"
            allowed = "a shorter tip, or another profile shift"
            raise ModelError(f"{text}: they interfere", path=path, given=given, allowed=allowed)
        if depth > _TOLD * tooth.gear.module:
            told.append(f"{text}; the fillet is taken as involute there")
    return tuple(told)


def _below(tooth: ToothCompliance, radius: Array, rolled: Array) -> Array:
    """How far below its involute a tooth is touched [m]; past the base circle by how far the contact has left it."""
    if tooth.gear.internal:
        return radius - tooth.limits[1]
    return np.where(rolled > 0, tooth.limits[0] - radius, tooth.limits[0] - _base(tooth) - rolled)
