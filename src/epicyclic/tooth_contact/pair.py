"""One pair of gears on one helix as loaded contact sees it: plane of action, compliance, micro-geometry."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from ..gears.flank import PLAIN, Flank, check_flank
from ..gears.outline import GearForm
from ..gears.tooth_pair import ToothPair
from .lines import PlaneOfAction
from .tooth import ToothCompliance, tooth_compliance

__all__ = ["ContactPair", "ElasticTooth", "MeshWave", "Torsion", "check_pair", "drawn_pair", "uniform_along_face"]

Array = NDArray[np.float64]


class ElasticTooth(Protocol):
    """Compliance of the teeth of one gear; `tooth.ToothCompliance` implements it, tests use closed forms.

    shared : compliance common to all teeth, the winding of the body [m^2/N].
    """

    @property
    def shared(self) -> float: ...

    def face_decay(self, width: float) -> float:
        """Decay length of the coupling along a face of a width [m] (`kernel`)."""
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
    even = all(flank.crown == 0 and flank.slope == 0 and flank.end_relief is None for flank in _flanks(pair))
    same = plane.base_helix == 0 and plane.face_a == plane.face_b
    stiff = pair.torsion_a is None and pair.torsion_b is None
    return even and same and stiff and pair.misalignment == 0 and not pair.gap


def _flanks(pair: ContactPair) -> tuple[Flank, Flank]:
    return pair.flank_a, pair.flank_b
