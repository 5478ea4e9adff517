"""A pair of teeth in contact, cut into pieces: what they have in common, how far they are apart, how they give way.

Displacement along the normal of a piece i under forces P_k of all pieces in mesh:

    own approach u_i(P_i/l_i) of the two flanks [weber1953]
    + sum over both gears: [b_ik + r_ik] G(zeta_i, zeta_k) P_k + s P_k/L

b is the compliance of the tooth itself, (b_i b_k)^1/2 along one tooth, none between two; r what the body under the
teeth gives, from one to another too, without the winding s that all teeth share over the length L of the face; G says
how a load on one place of the face deflects another.  With b, r and G the compliance is symmetric positive definite.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from ..gears.flank import PLAIN, Flank, check_flank, lead_missing, profile_missing
from . import hertz
from .corner import reach, separation
from .kernel import PLATE_DECAY, coupling
from .lines import Lines, Plane, contact_lines

__all__ = ["Pair", "Pieces", "Tooth", "Torsion", "check_pair", "missing", "pieces_of", "reshaped"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Corner contact is looked for until tip and flank are this far apart, in modules of the base pitch: far above what
# teeth give way.
_CORNER = 0.02


class Tooth(Protocol):
    """Compliance of the teeth of one gear, as `tooth.tooth_compliance` gives it.

    height : of the tooth [m].  shared : what every tooth gets from the load of one, of its compliance [m^2/N].
    """

    @property
    def height(self) -> float: ...

    @property
    def shared(self) -> float: ...

    def bending(self, radius: ArrayLike) -> Array:
        """Compliance of tooth and body per load per length at radii of the load [m^2/N]."""
        ...

    def depth(self, radius: ArrayLike) -> Array:
        """From the flank to the middle of the tooth along the normal [m]."""
        ...

    def cross(self, radius: ArrayLike, other: ArrayLike, ahead: ArrayLike) -> Array:
        """What the body gives a tooth per load per length on another, `ahead` pitches on; 0 is itself [m^2/N]."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Torsion:
    """Twist of the body of a gear along its face, under the load it carries itself.

    rigidity : G I_p [N m^2].  end : where the torque leaves it.
    """

    rigidity: float
    end: Literal["left", "right"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pair:
    """One pair of gears on one helix, as far as its teeth are concerned.

    plane : geometry.  tooth_a, tooth_b : compliance.  flank_a, flank_b : micro-geometry of the flanks that touch.
    youngs_modulus [Pa], poisson [1] : of a and b.  teeth : numbers of teeth, for pitch deviations.
    misalignment : gap per length along the axis, about the middle of the mesh [1], positive opens the right end.
    gap : further gap over the face, ((zeta, gap), ...) from left to right, linear between [m].
    torsion_a, torsion_b : twist of the bodies along the face; None: rigid.
    slices : pieces of the face.  linear_at : load per length [N/m] whose secant stands for the contact of the flanks
        at every load; None: Hertz.  corner : let tips bear beyond the path of contact.
    """

    plane: Plane
    tooth_a: Tooth
    tooth_b: Tooth
    flank_a: Flank = PLAIN
    flank_b: Flank = PLAIN
    youngs_modulus: tuple[float, float] = (206e9, 206e9)
    poisson: tuple[float, float] = (0.3, 0.3)
    teeth: tuple[int, int] = (1, 1)
    misalignment: float = 0.0
    gap: tuple[tuple[float, float], ...] = ()
    torsion_a: Torsion | None = None
    torsion_b: Torsion | None = None
    slices: int = 20
    linear_at: float | None = None
    corner: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pieces:
    """The pieces that can touch at T phases, n at most in one of them; what stands behind `valid` is padding.

    sigma : (T,) of the phases.  lines : all pieces, (T, J, K).  index : (T, n) of a piece among those J K.
    valid : (T, n).  zeta, length : (T, n) [m].  gap : (T, n) material missing [m].
    compliance : (T, n, n) shared between pieces [m/N]; with a linear law all of it.  line : own law, None where linear.
    contact : Hertz contact at every piece, for pressures.
    """

    pair: Pair
    sigma: Array
    lines: Lines
    index: Index
    valid: NDArray[np.bool_]
    zeta: Array
    length: Array
    gap: Array
    compliance: Array
    line: hertz.Line | None
    contact: hertz.Line

    @property
    def no_load(self) -> Array:
        """Approach at which the flanks first touch, (T,) [m]."""
        return np.asarray(np.where(self.valid, self.gap, np.inf).min(axis=1))

    def law(self, approach: Array, phases: Index) -> tuple[Array, Array]:
        """Force [N] and slope [N/m] at own approaches (t, n) [m] at phases (t,), as `solve.hertzian` asks."""
        own = self.contact
        p, slope = hertz.load(hertz.Line(A=own.A, B=own.B[phases], radius=own.radius[phases]), approach)
        return p * self.length[phases], slope * self.length[phases]

    def spread(self, values: Array) -> Array:
        """Values (..., T, n) of the pieces at their places among all, (..., T, J, K); 0 elsewhere."""
        shape = self.lines.length.shape
        flat = np.zeros((*values.shape[:-1], shape[1] * shape[2] + 1))
        at = np.where(self.valid, self.index, shape[1] * shape[2])
        np.put_along_axis(flat, np.broadcast_to(at, values.shape), np.where(self.valid, values, 0.0), axis=-1)
        return flat[..., :-1].reshape(*values.shape[:-1], shape[1], shape[2])


def pieces_of(pair: Pair, sigma: ArrayLike) -> Pieces:
    """Pieces of a pair at places (T,) of one pair of teeth at mid-face [base pitches].

    Raises
    ------
    ModelError : what cannot be built or does not mesh, see `check_pair`.
    """
    check_pair(pair)
    beyond = reach(pair.plane, _CORNER * pair.plane.base_pitch / math.pi) if pair.corner else (0.0, 0.0)
    lines = contact_lines(pair.plane, sigma, pair.slices, beyond=beyond)
    index, valid = _gathered(lines)

    def take(values: Array) -> Array:
        return np.take_along_axis(values.reshape(len(index), -1), index, axis=1)

    place, zeta = take(lines.sigma), take(lines.zeta)
    length = np.where(valid, take(lines.length), 1.0)
    contact = _contact(pair, place)
    compliance = _shared_compliance(pair, lines, index, place)
    if pair.linear_at is not None:
        n = index.shape[1]
        secant = contact.A * (contact.B - math.log(pair.linear_at))
        compliance[:, np.arange(n), np.arange(n)] += secant / length
    return Pieces(
        pair=pair,
        sigma=np.atleast_1d(np.asarray(sigma, dtype=float)),
        lines=lines,
        index=index,
        valid=valid,
        zeta=zeta,
        length=length,
        gap=np.where(valid, take(missing(pair, lines)), 0.0),
        compliance=compliance,
        line=contact if pair.linear_at is None else None,
        contact=contact,
    )


def reshaped(pieces: Pieces, pair: Pair) -> Pieces:
    """The same pieces of a pair that differs in its gaps alone: micro-geometry, misalignment, given gaps.

    Raises
    ------
    ModelError : as of `check_pair`.
    """
    check_pair(pair)
    gap = missing(pair, pieces.lines).reshape(len(pieces.index), -1)
    there = np.take_along_axis(gap, pieces.index, axis=1)
    return replace(pieces, pair=pair, gap=np.where(pieces.valid, there, 0.0))


def _gathered(lines: Lines) -> tuple[Index, NDArray[np.bool_]]:
    touched = (lines.length > 0).reshape(len(lines.length), -1)
    most = max(1, int(touched.sum(axis=1).max()))
    index = np.argsort(~touched, axis=1, kind="stable")[:, :most]
    return index, np.take_along_axis(touched, index, axis=1)


def _contact(pair: Pair, place: Array) -> hertz.Line:
    plane = pair.plane
    on = np.clip(place, *plane.limits)
    return hertz.line_contact(
        plane.curvature_radius(on),
        pair.tooth_a.depth(plane.radius_a(on)),
        pair.tooth_b.depth(plane.radius_b(on)),
        youngs_modulus=pair.youngs_modulus,
        poisson=pair.poisson,
    )


def _shared_compliance(pair: Pair, lines: Lines, index: Index, place: Array) -> Array:
    """What the load of one piece gives another, (T, n, n) [m/N]."""
    plane, count = pair.plane, lines.length.shape[2]
    slant = math.cos(plane.base_helix)
    on = np.clip(place, *plane.limits)
    tooth, piece = index // count, index % count
    ahead = tooth[:, None, :] - tooth[:, :, None]
    along, across = piece[:, :, None], piece[:, None, :]
    whole = np.zeros(ahead.shape)
    for gear, face, radius, sense in (
        (pair.tooth_a, plane.face_a, plane.radius_a(on), 1),
        (pair.tooth_b, plane.face_b, plane.radius_b(on), -1),
    ):
        width = (face[1] - face[0]) / slant
        middle = (lines.centre - 0.5 * (face[0] + face[1])) / slant
        spans = np.full(count, lines.span / slant)
        kernel = coupling(middle, width, PLATE_DECAY * gear.height, spans)
        body = gear.cross(radius[:, :, None], radius[:, None, :], sense * ahead)
        # at the root of a ring there is no tooth left between the load and the body
        root = np.sqrt(np.maximum(gear.bending(radius) - np.diagonal(body, axis1=1, axis2=2), 0.0))
        own = np.where(ahead == 0, root[:, :, None] * root[:, None, :], 0.0)
        whole += (own + body - gear.shared) * kernel[along, across] + gear.shared / width
    twist = _twisted(pair, lines)
    if twist is not None:
        whole += twist[along, across]
    return whole


def _twisted(pair: Pair, lines: Lines) -> Array | None:
    """Compliance of pieces of the face by the twist of both bodies, (K, K) [m/N]; None where both are rigid."""
    plane, whole = pair.plane, None
    for torsion, face, base in (
        (pair.torsion_a, plane.face_a, plane.base_a),
        (pair.torsion_b, plane.face_b, plane.base_b),
    ):
        if torsion is None:
            continue
        away = lines.centre - face[0] if torsion.end == "left" else face[1] - lines.centre
        lever = (base * math.cos(plane.base_helix)) ** 2 / torsion.rigidity
        own = lever * np.minimum(away[:, None], away[None, :])
        whole = own if whole is None else whole + own
    return whole


def missing(pair: Pair, lines: Lines) -> Array:
    """Gap between the flanks from all that is missing on either, misalignment and given gaps, (T, J, K) [m]."""
    plane = pair.plane
    on = np.clip(lines.sigma, *plane.limits)
    total = pair.misalignment * lines.zeta + separation(plane, lines.sigma) * (pair.corner)
    if pair.gap:
        total = total + np.interp(lines.zeta, *np.array(pair.gap).T)
    for flank, gear, radius in ((pair.flank_a, 0, plane.radius_a), (pair.flank_b, 1, plane.radius_b)):
        tip, root = (plane.limits[1], plane.limits[0]) if gear == 0 else plane.limits
        at = radius(on)
        height = np.abs(at - radius(tip)), np.abs(at - radius(root))
        total = total + profile_missing(flank, below_tip=height[0], above_root=height[1], sigma=lines.sigma)
        total = total + lead_missing(flank, lines.zeta, (plane.face_a, plane.face_b)[gear])
        if flank.pitch:
            total = total + np.asarray(flank.pitch)[lines.pair % pair.teeth[gear]][:, :, None]
    return np.asarray(total)


def check_pair(pair: Pair, *, path: str = "", paths: tuple[str, str] = ("a.flank", "b.flank")) -> None:
    """Refuse a pair that does not mesh.

    path : of the mesh in the model file; paths : of the flanks of a and b.

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
