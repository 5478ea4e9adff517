"""Mesh stiffness by the potential-energy method: tooth pairs in parallel, coupled by the gear bodies.

Pairs j in contact at the places sigma + j under loads p_j per length of contact line deflect by

    sum_k [ delta_jk (beam_a + beam_b + contact) + body_a(j, k) + body_b(j, k) ] p_k = d,     k(sigma) = sum p / d

each at the radius of its load; contact is the tangent of the line contact of Hertz and Weber [weber1953] at a nominal
load.  This is one plane section.  A helical face is cut into such sections, each at its own sigma and without coupling
between them: the usual energy method.  The sum over the face is the mean of k over the overlap.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..gears import geometry
from ..gears.series import ComplexArray
from ..gears.stiffness import DEFAULT_HARMONICS
from ..warning_codes import CodedText, coded
from . import hertz
from .tooth import ToothCompliance

__all__ = ["MeshedTeeth", "cycle_series", "energy_series", "interference_warnings", "section_stiffness"]

Array = NDArray[np.float64]

# Depth of a tip below the involute of its mate [modules]: below the first limit the fillet is as good as the involute,
# which it leaves smoothly; up to the second a warning is given; beyond, the tip interferes with the fillet.
_WARNED, _REFUSED = 0.02, 0.1
_POINTS = 24  # of Gauss' rule between two jumps, and two more for every order


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshedTeeth:
    """Two elastic gears in mesh, a external.

    working_angle : transverse [rad].  limits : (sigma_min, sigma_max) of the path of contact [base pitches].
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
        """Lengths of roll on a and b: distances (n,) of the contact from the tangent points of the base circles [m].

        sigma : (n,) [base pitches].
        """
        tangent = math.tan(self.working_angle)
        gear = self.a.gear
        along = sigma * geometry.base_pitch(gear.module, gear.pressure_angle, gear.helix_angle)
        side = 1.0 if self.b.gear.internal else -1.0
        return _base(self.a) * tangent + along, _base(self.b) * tangent + side * along

    def radii(self, sigma: Array) -> tuple[Array, Array]:
        """Radii (n,) of the contact on a and b [m] at places sigma (n,) [base pitches]."""
        on_a, on_b = self.rolled(sigma)
        return np.hypot(_base(self.a), on_a), np.hypot(_base(self.b), on_b)


def section_stiffness(mesh: MeshedTeeth, sigma: Array, load: float) -> Array:
    """Stiffness (n,) along the normal per length of contact line of one plane section [N/m^2].

    sigma : (n,) [base pitches].  load : per length of contact line, at which the line contact is linearised [N/m].
    Zero where no pair is in contact.

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
    """Mean stiffness of a plane section over a mesh cycle [N/m^2] and its relative series v_l (L,) over sigma [1].

    load : per length of contact line [N/m].  path : of the mesh in the model file, for the message.

    Raises
    ------
    ModelError : a load that is not positive, and as of `cycle_series`.
    """
    return cycle_series(mesh, lambda sigma: section_stiffness(mesh, sigma, load), harmonics=harmonics, path=path)


def cycle_series(
    mesh: MeshedTeeth, stiffness_at: Callable[[Array], Array], *, harmonics: int, path: str = ""
) -> tuple[float, ComplexArray]:
    """Mean over a mesh cycle [N/m^2] and relative series v_l (L,) over sigma [1] of the stiffness of a plane section.

    The stiffness jumps where a pair enters or leaves; between the jumps Gauss' rule integrates it.
    stiffness_at : places sigma (n,) [base pitches] -> stiffness (n,) [N/m^2].  path : of the mesh in the model file.

    Raises
    ------
    ModelError : a contact ratio below 1, tips that interfere (`interference_warnings`).
    """
    low, high = mesh.limits
    if not high - low >= 1:
        given = f"contact ratio {high - low:.3g}"
        raise ModelError("contact is lost between tooth pairs", path=path, given=given, allowed="1 or more")
    interference_warnings(mesh, path=path)
    jumps = np.unique(np.concatenate([[0.0, 1.0], np.mod([low, high], 1.0)]))
    middle, half = 0.5 * (jumps[1:] + jumps[:-1]), 0.5 * np.diff(jumps)
    points, weights = _gauss_rule(_POINTS + 2 * harmonics)
    sigma = (middle[:, None] + half[:, None] * points).ravel()
    weight = (half[:, None] * weights).ravel()
    stiffness = stiffness_at(sigma) * weight
    mean = float(stiffness.sum())
    order = np.arange(1, harmonics + 1)
    turns = np.exp(-2j * np.pi * np.outer(order, sigma))
    return mean, np.asarray(2 / mean * (turns @ stiffness), dtype=np.complex128)


@cache
def _gauss_rule(count: int) -> tuple[Array, Array]:
    """Points and weights (count,) of Gauss' rule over -1..1; made once, its eigenvalues cost as much as a mesh."""
    points, weights = np.polynomial.legendre.leggauss(count)
    return points, weights


def _base(tooth: ToothCompliance) -> float:
    gear = tooth.gear
    return geometry.base_radius(gear.teeth, gear.module, gear.pressure_angle, gear.helix_angle)


def _beams(tooth: ToothCompliance, radius: Array) -> Array:
    """Compliance (...) of the tooth itself as a beam at radii (...) [m], without its body [m^2/N]."""
    parts = tooth.parts(radius)
    return parts.bending + parts.shear + parts.compression


def _contact(mesh: MeshedTeeth, sigma: Array, radius_a: Array, radius_b: Array, load: float) -> Array:
    """Tangent compliance du/dp (n, J) of the line contact at a load per length [N/m] [m^2/N] [weber1953]."""
    on_a, on_b = mesh.rolled(sigma)
    # at the base circle the curvature is infinite; the tooth there is thicker than any contact is wide
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


def interference_warnings(
    mesh: MeshedTeeth, *, path: str = "", names: tuple[str, str] = ("the first gear", "the second gear")
) -> tuple[CodedText, ...]:
    """Warnings about tips that reach below the involute of their mate.

    path : of the mesh in the model file, names : of its gears a and b, for the message.

    Raises
    ------
    ModelError : a tip that interferes with the fillet of its mate.
    """
    ends = np.array(mesh.limits)
    depths = [
        np.max(_below(tooth, radius, rolled))
        for tooth, radius, rolled in zip((mesh.a, mesh.b), mesh.radii(ends), mesh.rolled(ends), strict=True)
    ]
    warnings = []
    for depth, (reached, mate), tooth in zip(depths, (names, names[::-1]), (mesh.b, mesh.a), strict=True):
        text = f"the tips of {mate} reach {depth * 1e3:.3g} mm below the involute of {reached}"
        if depth > _REFUSED * tooth.gear.module:
            given = f"tip radius {tooth.gear.tip * 1e3:.5g} mm"
            allowed = "a shorter tip, or another profile shift"
            raise ModelError(f"{text}: they interfere", path=path, given=given, allowed=allowed)
        if depth > _WARNED * tooth.gear.module:
            warnings.append(coded("tips-below-involute", f"{text}; the fillet is taken as involute there"))
    return tuple(warnings)


def _below(tooth: ToothCompliance, radius: Array, rolled: Array) -> Array:
    """Depth (n,) of the contact below the involute of a tooth [m]; past the base circle the distance from it."""
    if tooth.gear.internal:
        return radius - tooth.limits[1]
    return np.where(rolled > 0, tooth.limits[0] - radius, tooth.limits[0] - _base(tooth) - rolled)
