"""One pair of gears on one helix as loaded contact sees it: plane of action, compliance, micro-geometry, line contact.

The line contact of two cylinders is the approach against the load per length, and its inverse [weber1953],

    u = A p (B - ln p),   A = (1 - nu_1^2)/(pi E_1) + (1 - nu_2^2)/(pi E_2),   p load per length [N/m]

between the middles of the two teeth, h_1 and h_2 below the surface.  u rises with p up to exp(B - 1), far above any
load of a tooth.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from .compliance import ToothCompliance, tooth_compliance
from .form import PLAIN, Flank, GearForm, check_flank
from .mesh_stiffness import ToothPair
from .path_of_contact import PlaneOfAction

Array = NDArray[np.float64]
Index = NDArray[np.int64]

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

    def cross(self, radius: ArrayLike, other: ArrayLike, ahead: ArrayLike) -> Array:
        """Cross compliance of the body (...) [m^2/N]: motion of a tooth per load per length on another.

        radius, other : (...) of the moved and of the loaded contact [m].  ahead : (...) pitches from the moved to the
        loaded tooth, 0 = the same.
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
    teeth: ToothPair, *, internal: bool, base_helix: float, lean: int, slides: tuple[float, float] = (0.0, 0.0)
) -> ContactPair:
    """Contact pair as drawn: nominal alignment, gear bodies rigid along the face.

    Parameters
    ----------
    teeth, internal, base_helix : as of `Mesh` [rad].  lean : d h of gear a.  slides : axial offsets of both gears [m].

    Raises
    ------
    ModelError : pointed or undercut teeth, no body under them.
    """
    paths = tuple(path.removesuffix(".flank") for path in teeth.paths)
    return ContactPair(
        plane=PlaneOfAction(
            base_a=teeth.base_a,
            base_b=teeth.base_b,
            internal=internal,
            pressure_angle=teeth.pressure_angle,
            base_helix=base_helix,
            base_pitch=teeth.base_pitch,
            limits=teeth.limits,
            lean=lean,
            face_a=(teeth.face_a[0] + slides[0], teeth.face_a[1] + slides[0]),
            face_b=(teeth.face_b[0] + slides[1], teeth.face_b[1] + slides[1]),
        ),
        tooth_a=_tooth(teeth.form_a, paths[0]),
        tooth_b=_tooth(teeth.form_b, paths[1]),
        flank_a=teeth.flank_a,
        flank_b=teeth.flank_b,
        youngs_modulus=(teeth.form_a.youngs_modulus, teeth.form_b.youngs_modulus),
        poisson=(teeth.form_a.poisson, teeth.form_b.poisson),
        teeth=(teeth.form_a.teeth, teeth.form_b.teeth),
    )


@lru_cache(maxsize=64)
def _tooth(form: GearForm, path: str) -> ToothCompliance:
    return tooth_compliance(form, path=path)


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
            "the faces do not overlap", path=path or "face_width", given=f"{plane.width * 1e3:.4g} mm", allowed="> 0"
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
    for flank, radius, face, teeth, where in (
        (pair.flank_a, plane.radius_a, plane.face_a, pair.teeth[0], paths[0]),
        (pair.flank_b, plane.radius_b, plane.face_b, pair.teeth[1], paths[1]),
    ):
        height = abs(float(radius(plane.limits[1]) - radius(plane.limits[0])))
        check_flank(flank, height=height, width=face[1] - face[0], teeth=teeth, path=where)


def uniform_along_face(pair: ContactPair) -> bool:
    """Whether nothing varies along the face, so that one segment is exact."""
    plane = pair.plane
    even = all(
        flank.crown == 0 and flank.slope == 0 and flank.end_relief is None for flank in (pair.flank_a, pair.flank_b)
    )
    same = plane.base_helix == 0 and plane.face_a == plane.face_b
    stiff = pair.torsion_a is None and pair.torsion_b is None
    return even and same and stiff and pair.misalignment == 0 and not pair.gap
