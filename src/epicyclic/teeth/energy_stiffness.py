"""Mesh stiffness of teeth without tooth contact: the potential-energy method, and Ishikawa's tooth.

By the potential-energy method tooth pairs are in parallel, coupled by the gear bodies.  Pairs j in contact at the
places sigma + j under loads p_j per length of contact line deflect by

    sum_k [ delta_jk (beam_a + beam_b + contact) + body_a(j, k) + body_b(j, k) ] p_k = d,     k(sigma) = sum p / d

each at the radius of its load; contact is the tangent of the line contact of Hertz and Weber [weber1953] at a nominal
load.  This is one plane section.  A helical face is cut into such sections, each at its own sigma and without coupling
between them: the usual energy method.  The sum over the face is the mean of k over the overlap.

Ishikawa's tooth is a trapezoid on a rectangle, clamped in the root section [ishikawa1957].  The root section is the
critical one, where the fillet leans by 30 degrees (of a ring 60).  The tooth is a rectangle of its thickness s_F from
there to the beginning of the involute, and above it a trapezoid to the chord s_K of the tip; h_i is the height at which
its sides would meet.  A load F per width b under the angle w to the cross line, on the flank at the height h_x, moves
its point along its own line by

    rectangle   12 F cos^2 w/(E b s_F^3) [h_x h_r (h_x - h_r) + h_r^3/3]
    trapezoid   6 F cos^2 w/(E b s_F^3) (h_i - h_r)^3 [u (4 - u) - 2 ln u - 3],   u = (h_i - h_x)/(h_i - h_r)
    shear       2 (1 + nu) F cos^2 w/(E b s_F) [h_r + (h_i - h_r) ln(1/u)]
    root        24 F h_x^2 cos^2 w/(pi E b s_F^2), the tilt of the elastic root
    contact     2 F/(pi b) [(1 - nu_a^2)/E_a + (1 - nu_b^2)/E_b], of a pair

in plane stress.  Every height is along the centre line of the tooth from the middle of the root section; h_x is that of
the point of the flank that touches, not of where the line of the load crosses the centre line; of h_r no more than h_x
counts.  Pairs of teeth are springs in parallel: the gear bodies do not couple them.  A ring tooth has the same shape,
its tip inside.  Helical teeth: the normal section, per length of contact line, without coupling along the face.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from ..warning_codes import CodedText, coded
from . import gear_pair, geometry
from .compliance import ToothCompliance
from .mesh_stiffness import DEFAULT_HARMONICS, ComplexArray

Array = NDArray[np.float64]

# Depth of a tip below the involute of its mate [modules]: below the first limit the fillet is as good as the involute,
# which it leaves smoothly; up to the second a warning is given; beyond, the tip interferes with the fillet.
_WARNED, _REFUSED = 0.02, 0.1
_POINTS = 24  # of Gauss' rule between two jumps, and two more for every order


# potential-energy method ---------------------------------------------------------------------------------------------


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
    beams = _beams(mesh.a, radius_a) + _beams(mesh.b, radius_b) + _contact(mesh, at, radius_a, radius_b, load)
    ahead = pairs[None, :] - pairs[:, None]
    whole = mesh.a.cross(radius_a[:, :, None], radius_a[:, None, :], ahead)
    whole = whole + mesh.b.cross(radius_b[:, :, None], radius_b[:, None, :], -ahead)
    index = np.arange(len(pairs))
    whole[:, index, index] += beams
    both = on[:, :, None] & on[:, None, :]
    scale = beams.max()
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
        ratio = f"contact ratio {high - low:.3g}"
        raise ModelError("contact is lost between tooth pairs", path=path, given=ratio, allowed="1 or more")
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
    line = gear_pair.line_contact(
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
            reached_radius = f"tip radius {tooth.gear.tip * 1e3:.5g} mm"
            allowed = "a shorter tip, or another profile shift"
            raise ModelError(f"{text}: they interfere", path=path, given=reached_radius, allowed=allowed)
        if depth > _WARNED * tooth.gear.module:
            warnings.append(coded("tips-below-involute", f"{text}; the fillet is taken as involute there"))
    return tuple(warnings)


def _below(tooth: ToothCompliance, radius: Array, rolled: Array) -> Array:
    """Depth (n,) of the contact below the involute of a tooth [m]; past the base circle the distance from it."""
    if tooth.gear.internal:
        return radius - tooth.limits[1]
    return np.where(rolled > 0, tooth.limits[0] - radius, tooth.limits[0] - _base(tooth) - rolled)


# Ishikawa's tooth ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class IshikawaParts:
    """Compliance of a tooth by cause, each (...) [m^2/N]: displacement along the load per load per length."""

    rectangle: Array
    trapezoid: Array
    shear: Array
    root: Array

    @property
    def whole(self) -> Array:
        """Sum of all parts (...) [m^2/N]."""
        return self.rectangle + self.trapezoid + self.shear + self.root


@dataclass(frozen=True, slots=True, kw_only=True)
class IshikawaTooth:
    """Rectangle and trapezoid; lengths [m].

    thickness : s_F.  tip_thickness : s_K.  rectangle : height h_r.  height : h of the tip above the root section.
    youngs_modulus : [Pa].
    """

    thickness: float
    tip_thickness: float
    rectangle: float
    height: float
    youngs_modulus: float
    poisson: float

    @property
    def apex(self) -> float:
        """Height h_i at which the sides of the trapezoid would meet [m]."""
        s, k = self.thickness, self.tip_thickness
        return (self.height * s - self.rectangle * k) / (s - k)

    def parts(self, height: ArrayLike, angle: ArrayLike) -> IshikawaParts:
        """Compliance under loads at heights h_x (...) above the root section [m], at angles w (...) [rad]."""
        at, across = np.asarray(height, dtype=float), np.cos(angle) ** 2
        E, s, low = self.youngs_modulus, self.thickness, np.minimum(self.rectangle, height)
        over = self.apex - low
        u = (self.apex - at) / over
        return IshikawaParts(
            rectangle=12 * across / (E * s**3) * (at * low * (at - low) + low**3 / 3),
            trapezoid=6 * across / (E * s**3) * over**3 * (u * (4 - u) - 2 * np.log(u) - 3),
            shear=2 * (1 + self.poisson) * across / (E * s) * (low - over * np.log(u)),
            root=24 * at**2 * across / (math.pi * E * s**2),
        )


def ishikawa_tooth(tooth: ToothCompliance) -> IshikawaTooth:
    """Ishikawa's tooth of the normal section of a gear."""
    shape = tooth.outline
    return IshikawaTooth(
        thickness=tooth.thickness,
        tip_thickness=2 * float(shape.x[0]),
        rectangle=tooth.height - float(shape.depth[shape.form]),
        height=tooth.height - float(shape.depth[0]),
        youngs_modulus=tooth.gear.youngs_modulus,
        poisson=tooth.gear.poisson,
    )


def ishikawa_stiffness(mesh: MeshedTeeth, sigma: ArrayLike) -> Array:
    """Stiffness (n,) along the normal per length of contact line of one plane section [N/m^2], pairs in parallel.

    sigma : (n,) [base pitches].  Zero where no pair is in contact.
    """
    low, high = mesh.limits
    place = np.asarray(sigma, dtype=float)
    pairs = np.arange(math.floor(low - float(place.max())), math.ceil(high - float(place.min())) + 1)
    at = place[:, None] + pairs
    on = (at >= low) & (at <= high)
    gears = mesh.a.gear, mesh.b.gear
    contact = 2 / math.pi * sum((1 - gear.poisson**2) / gear.youngs_modulus for gear in gears)
    whole = np.full(at.shape, contact)
    for tooth, radius in zip((mesh.a, mesh.b), mesh.radii(np.clip(at, low, high)), strict=True):
        virtual = radius + tooth.gear.to_virtual
        psi, gamma = tooth.outline.flank_angle(virtual)
        height = tooth.height - np.abs(tooth.outline.tip - virtual * np.cos(psi))
        whole = whole + ishikawa_tooth(tooth).parts(height, gamma).whole
    return np.asarray(np.where(on, 1 / whole, 0.0).sum(axis=1))


def ishikawa_series(
    mesh: MeshedTeeth, *, harmonics: int = DEFAULT_HARMONICS, path: str = ""
) -> tuple[float, ComplexArray]:
    """Mean stiffness of a plane section over a mesh cycle [N/m^2] and its relative series v_l (L,) over sigma [1].

    path : of the mesh in the model file, for the message.

    Raises
    ------
    ModelError : as of `cycle_series`.
    """
    return cycle_series(mesh, lambda sigma: ishikawa_stiffness(mesh, sigma), harmonics=harmonics, path=path)
