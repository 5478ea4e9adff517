"""One pair of gears on one helix as loaded contact sees it: plane of action, compliance, micro-geometry, line contact;
and its mesh stiffness without tooth contact: the potential-energy method, and Ishikawa's tooth.

The line contact of two cylinders is the approach against the load per length, and its inverse [weber1953],

    u = A p (B - ln p),   A = (1 - nu_1^2)/(pi E_1) + (1 - nu_2^2)/(pi E_2),   p load per length [N/m]

between the middles of the two teeth, h_1 and h_2 below the surface.  u rises with p up to exp(B - 1), far above any
load of a tooth.

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
from functools import cache, lru_cache
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ModelError, in_mm
from ..warning_codes import CodedText, coded
from . import geometry
from .compliance import ToothCompliance, tooth_compliance
from .form import PLAIN, Flank, check_flanks
from .mesh_stiffness import DEFAULT_HARMONICS, ComplexArray, ToothPair
from .path_of_contact import Array, Index, PlaneOfAction, pair_places

# Most Newton steps of `load`; they stop at rounding.  From below they converge for every approach in the range.
_STEPS = 40


# line contact --------------------------------------------------------------------------------------------------------


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

    def at(self, index: Index) -> LineContact:
        """The line contact at some of the places, an index of their first axis."""
        return LineContact(A=self.A, B=self.B[index], radius=self.radius[index])


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


# pair ----------------------------------------------------------------------------------------------------------------


class ElasticTooth(Protocol):
    """Compliance of the teeth of one gear; `compliance.ToothCompliance` implements it, tests use closed forms.

    shared : compliance common to all teeth, the winding of the body [m^2/N].
    """

    @property
    def shared(self) -> float: ...

    def face_decay(self, width: float) -> float:
        """Decay length of the coupling along a face of a width [m] (`compliance`)."""
        ...

    def bending(self, radius: ArrayLike) -> Array:
        """Compliance of tooth and body per load per length (...) [m^2/N] at radii of the load (...) [m]."""
        ...

    def depth(self, radius: ArrayLike) -> Array:
        """Distance (...) [m] from the flank to the middle of the tooth along the normal, at radii (...) [m]."""
        ...

    def body_factors(self, radius: ArrayLike, tooth: ArrayLike) -> tuple[Array, Array]:
        """Cross compliance of the body L C L' (..., n, n) [m^2/N]: motion of a contact per load per length at another.

        L (..., n, r), C (r, r).  radius : (..., n) of the contacts [m].  tooth : (..., n) of each the number of its
        tooth from 0 on, which rises to the side that the loaded flanks face.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Torsion:
    """Twist of the body of a gear along its face under its own load.

    rigidity : G I_p [N m^2].  end : end of the face at which the torque leaves the body.
    """

    rigidity: float
    end: Literal["left", "right"]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshWave:
    """Gap A cos(2 pi order sigma + phase) of all pairs of teeth in mesh alike: A [m], phase [rad].

    order : waves a mesh cycle, not whole where it turns with a gear.  sigma : of one pair of teeth at mid-face, counted
    on from cycle to cycle.
    """

    amplitude: float
    order: float
    phase: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactPair:
    """One pair of gears on one helix, the model of a loaded tooth contact analysis.

    plane : plane of action.  tooth_a, tooth_b : compliance.  flank_a, flank_b : micro-geometry of the loaded flanks.
    youngs_modulus [Pa], poisson [1] : of a and b.  teeth : numbers of teeth, for pitch deviations.
    misalignment : gap per length along the axis, about the middle of the mesh [1], positive opens the right end.
    gap : further gap over the face, ((zeta, gap), ...) from left to right, linear between [m].
    pair_gaps : further gap of pairs of teeth by their number, from `first_pair` on [m]; pairs beyond either end have
        the gap of that end.
    waves : further gap of all pairs in mesh alike, over the phase.
    torsion_a, torsion_b : twist of the bodies along the face; None: rigid.
    slices : segments of the face.  linear_at : load per length [N/m] whose secant replaces the line contact at every
        load; None: Hertzian.  corner : corner contact, tips bear beyond the path of contact.
    """

    plane: PlaneOfAction
    tooth_a: ElasticTooth
    tooth_b: ElasticTooth
    flank_a: Flank = PLAIN
    flank_b: Flank = PLAIN
    youngs_modulus: tuple[float, float] = (206e9, 206e9)
    poisson: tuple[float, float] = (0.3, 0.3)
    teeth: tuple[int, int] = (1, 1)
    misalignment: float = 0.0
    gap: tuple[tuple[float, float], ...] = ()
    pair_gaps: tuple[float, ...] = ()
    first_pair: int = 0
    waves: tuple[MeshWave, ...] = ()
    torsion_a: Torsion | None = None
    torsion_b: Torsion | None = None
    slices: int = 20
    linear_at: float | None = None
    corner: bool = False


def drawn_pair(
    teeth: ToothPair, *, base_helix: float, lean: int, slides: tuple[float, float] = (0.0, 0.0)
) -> ContactPair:
    """Contact pair as drawn: nominal alignment, gear bodies rigid along the face.

    Parameters
    ----------
    teeth, base_helix : as of `Mesh` [rad].  lean : d h of gear a.  slides : axial offsets of both gears [m].

    Raises
    ------
    ModelError : pointed or undercut teeth, no body under them.
    """
    paths = tuple(path.removesuffix(".flank") for path in teeth.paths)
    return ContactPair(
        plane=teeth.plane(base_helix=base_helix, lean=lean, slides=slides),
        tooth_a=_tooth(teeth.form_a, path=paths[0]),
        tooth_b=_tooth(teeth.form_b, path=paths[1]),
        flank_a=teeth.flank_a,
        flank_b=teeth.flank_b,
        youngs_modulus=(teeth.form_a.youngs_modulus, teeth.form_b.youngs_modulus),
        poisson=(teeth.form_a.poisson, teeth.form_b.poisson),
        teeth=(teeth.form_a.teeth, teeth.form_b.teeth),
    )


_tooth = lru_cache(maxsize=64)(tooth_compliance)


def check_pair(pair: ContactPair, *, path: str = "", paths: tuple[str, str] = ("a.flank", "b.flank")) -> None:
    """Refuse a pair that does not mesh.

    path : of the mesh in the model file.  paths : of the flanks of a and b.

    Raises
    ------
    ModelError : faces that do not overlap, a contact ratio below 1, contact inside a base circle, micro-geometry that
        does not fit (`flank.check_flank`), no slices.
    """
    plane = pair.plane
    if not plane.width > 0:
        raise ModelError(
            "the faces do not overlap", path=path or "face_width", given=in_mm(plane.width, 4), allowed="> 0"
        )
    ratio = plane.limits[1] - plane.limits[0]
    if not ratio >= 1:
        raise ModelError("the teeth do not keep contact", path=path, given=f"contact ratio {ratio:.4g}", allowed=">= 1")
    for name, roll in (
        ("a", plane.roll_a(plane.limits[0])),
        ("b", plane.roll_b(plane.limits[0 if plane.internal else 1])),
    ):
        if float(roll) < -1e-9 * plane.base_pitch:
            raise ModelError(f"interference: the mate's tip reaches inside the base circle of gear {name}", path=path)
    if pair.slices < 1:
        raise ModelError("pieces of the face", path=path, given=pair.slices, allowed="1 or more")
    check_flanks(plane, (pair.flank_a, pair.flank_b), pair.teeth, paths)


def uniform_along_face(pair: ContactPair) -> bool:
    """Whether nothing varies along the face, so that one segment is exact."""
    plane = pair.plane
    even = all(
        flank.crown == 0 and flank.slope == 0 and flank.end_relief is None for flank in (pair.flank_a, pair.flank_b)
    )
    same = plane.base_helix == 0 and plane.face_a == plane.face_b
    stiff = pair.torsion_a is None and pair.torsion_b is None
    return even and same and stiff and pair.misalignment == 0 and not pair.gap


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


def meshed_teeth(pair: ContactPair) -> MeshedTeeth:
    """The two gears of a contact pair as drawn, whose teeth are elastic."""
    a, b = pair.tooth_a, pair.tooth_b
    assert isinstance(a, ToothCompliance)
    assert isinstance(b, ToothCompliance)
    return MeshedTeeth(a=a, b=b, working_angle=pair.plane.pressure_angle, limits=pair.plane.limits)


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
    place = pair_places(np.asarray(sigma, dtype=float), mesh.limits)
    on = (place >= low) & (place <= high)
    at: Array = np.clip(place, low, high)
    radius_a, radius_b = mesh.radii(at)
    beams = _beams(mesh.a, radius_a) + _beams(mesh.b, radius_b) + _contact(mesh, at, radius_a, radius_b, load)
    index = np.arange(place.shape[1])
    whole = mesh.a.cross(radius_a, index) + mesh.b.cross(radius_b, index[::-1])
    whole[:, index, index] += beams
    both = on[:, :, None] & on[:, None, :]
    scale = beams.max()
    matrix = np.where(both, whole / scale, np.eye(len(index)))
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
    mesh: MeshedTeeth, stiffness_at: Callable[[Array], Array], *, harmonics: int = DEFAULT_HARMONICS, path: str = ""
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
    turns = np.exp(-2j * np.pi * np.outer(np.arange(1, harmonics + 1), sigma))
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
    line = line_contact(
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
        text = f"the tips of {mate} reach {in_mm(depth, 3)} below the involute of {reached}"
        if depth > _REFUSED * tooth.gear.module:
            reached_radius = f"tip radius {in_mm(tooth.gear.tip, 5)}"
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
    at = pair_places(np.asarray(sigma, dtype=float), mesh.limits)
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
