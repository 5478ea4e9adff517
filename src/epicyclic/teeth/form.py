"""Form of one tooth: its outline in the normal section, and the micro-geometry of its flanks.

The outline goes from tip to root: involute and fillet, external and of a ring.  The normal section of a helical tooth
is that of the virtual spur gear of z_n = z/(cos^2 beta_b cos beta) teeth [iso21771]; a point of the flank keeps its
distance from the reference circle.  The tooth points along +y from the centre of the gear (of a ring along -y, from its
rim inward).  x is half the thickness, psi half the angle it spans.

Micro-geometry of a flank is profile and lead modifications as material missing along the tooth normal.  Lengths along
the profile are radial heights of the tooth, from the tip circle inward (of a ring outward) or from the lowest point of
contact with the mate."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ModelError, in_mm
from . import geometry
from .path_of_contact import Array, PlaneOfAction

_ROUNDING = 0.38  # of the standard rack, per module [iso53]
# An undercut less deep than this [modules] leaves the flank practically whole: 17 teeth of 20 deg count as free of it.
_UNDERCUT = 0.02
# Points of the flank, of the fillet and of the root circle.
_FLANK, _FILLET, _FLOOR = 400, 400, 20
# Root finding to rounding: the least relative tolerance that `brentq` takes, and as much of the bracket.
_XTOL, _RTOL = 1e-16, 4 * np.finfo(float).eps


@dataclass(frozen=True, slots=True, kw_only=True)
class GearForm:
    """Form of the teeth and of the body of a gear; lengths [m], angles [rad], coefficients per normal module [1].

    module, pressure_angle : normal.  profile_shift : positive lengthens the addendum, of a ring too.
    tip_rounding : radius of the rack's tip (ring: of the fillet); None: 0.38 [iso53], or a full round if that does not
    fit.  tip_radius : None: from the addendum.  bore : radius at which the body is held, of a ring the outer radius of
    its rim.  youngs_modulus : [Pa].  bends : highest order of waves of a ring that its own coordinates have; its body
    under the teeth has the others, with a free rim.  0: the rim is held.
    """

    teeth: int
    module: float
    pressure_angle: float
    helix_angle: float = 0.0
    profile_shift: float = 0.0
    addendum: float = 1.0
    dedendum: float = 1.25
    tip_rounding: float | None = None
    tip_radius: float | None = None
    internal: bool = False
    bore: float
    youngs_modulus: float = 206e9
    poisson: float = 0.3
    bends: int = 0

    @property
    def virtual_teeth(self) -> float:
        """z_n = z/(cos^2 beta_b cos beta) of the normal section [1] [iso21771]."""
        beta_b = geometry.base_helix_angle(self.pressure_angle, self.helix_angle)
        return self.teeth / (math.cos(beta_b) ** 2 * math.cos(self.helix_angle))

    @property
    def to_virtual(self) -> float:
        """Reference radius of the virtual gear less that of the gear itself [m], the offset of every radius."""
        reference = geometry.reference_radius(self.teeth, self.module, self.helix_angle)
        return 0.5 * self.module * self.virtual_teeth - reference

    @property
    def tip(self) -> float:
        """Tip radius of the gear itself [m]."""
        if self.tip_radius is not None:
            return self.tip_radius
        return geometry.tip_radius(
            self.teeth,
            self.module,
            self.helix_angle,
            internal=self.internal,
            profile_shift=self.profile_shift,
            addendum=self.addendum,
        )

    @property
    def root(self) -> float:
        """Root radius of the gear itself [m]."""
        return geometry.root_radius(
            self.teeth,
            self.module,
            self.helix_angle,
            internal=self.internal,
            profile_shift=self.profile_shift,
            dedendum=self.dedendum,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outline:
    """Half of the outline of a tooth of the virtual gear, from the tip to the middle of the tooth space; lengths [m].

    radius, psi : (m,) polar coordinates, psi from the middle of the tooth [rad].  slope : (m,) angle of the tangent
        against the middle line, positive where the tooth thickens towards its root [rad].  form : index of the first
        point of the fillet.  base, tip, root, form_radius, reference : radii of the virtual gear [m].
    half_pitch : pi/z_n [rad].  half_angle : half the angle of the tooth on the reference circle [rad].
    """

    radius: Array
    psi: Array
    slope: Array
    form: int
    base: float
    tip: float
    root: float
    form_radius: float
    half_pitch: float
    internal: bool
    reference: float
    half_angle: float

    @property
    def x(self) -> Array:
        """Half the thickness of the tooth (m,) [m]."""
        return self.radius * np.sin(self.psi)

    @property
    def depth(self) -> Array:
        """Distance along the middle line (m,), from the tip circle towards the root [m]."""
        along = self.radius * np.cos(self.psi)
        return along - self.tip if self.internal else self.tip - along

    def flank_angle(self, radius: Array) -> tuple[Array, Array]:
        """psi (m,) of the involute at radii (m,) [m], and the angle (m,) of its normal to the cross line [rad]."""
        pressure = np.arccos(np.minimum(1.0, self.base / np.asarray(radius)))
        turned = np.asarray(geometry.involute(pressure)) - geometry.involute(math.acos(self.base / self.reference))
        psi = self.half_angle + turned if self.internal else self.half_angle - turned
        return psi, pressure + psi if self.internal else pressure - psi


def tooth_outline(gear: GearForm, *, path: str = "") -> Outline:
    """Outline of a tooth: involute and the fillet that a rack with a rounded tip cuts [iso53]; of a ring an arc.

    path : of the gear in the model file, for the message.

    Raises
    ------
    ModelError : a pointed or undercut tooth, a tip beyond the root, a fillet that does not fit the gap.
    """
    z, m, alpha = gear.virtual_teeth, gear.module, gear.pressure_angle
    reference = 0.5 * m * z
    shape = Outline(
        radius=np.zeros(0),
        psi=np.zeros(0),
        slope=np.zeros(0),
        form=0,
        base=reference * math.cos(alpha),
        tip=gear.tip + gear.to_virtual,
        root=gear.root + gear.to_virtual,
        form_radius=math.nan,
        half_pitch=math.pi / z,
        internal=gear.internal,
        reference=reference,
        half_angle=(0.5 * math.pi + 2.0 * gear.profile_shift * math.tan(alpha)) / z,
    )
    _check(gear, shape, path)
    fillet = _ring_fillet(gear, shape, path) if gear.internal else _rack_fillet(gear, shape, path)
    return _joined(shape, *fillet)


def _check(gear: GearForm, shape: Outline, path: str) -> None:
    height = shape.root - shape.tip if gear.internal else shape.tip - shape.root
    if height <= 0:
        raise ModelError("the tip lies beyond the root: no tooth is left", path=path, given=in_mm(gear.tip, 4))
    if shape.root <= 0 or (gear.internal and shape.tip < shape.base):
        word = "the tip of the ring lies inside its base circle, where there is no involute"
        raise ModelError(word if gear.internal else "leaves no tooth", path=path, given=in_mm(gear.tip, 4))
    psi = float(shape.flank_angle(np.array([shape.tip]))[0][0])
    if psi <= 0:
        raise ModelError(
            "the tooth is pointed: its flanks cross below the tip circle",
            path=path,
            given=f"tip radius {in_mm(gear.tip, 4)}, profile shift {gear.profile_shift:.3g}",
            allowed="a smaller tip diameter, addendum or profile shift",
        )
    if gear.bore <= gear.root if gear.internal else gear.bore >= gear.root:
        raise ModelError(
            "leaves no body under the teeth",
            path=path,
            given=f"held at a radius of {in_mm(gear.bore, 4)}",
            allowed=f"{'more' if gear.internal else 'less'} than the root radius {in_mm(gear.root, 4)}",
        )


# external: envelope of the rack's rounded corner ---------------------------------------------------------------------


def _rack_fillet(gear: GearForm, shape: Outline, path: str) -> tuple[Array, Array]:
    """Fillet of an external gear, radius (m,) [m] and psi (m,) [rad], from the flank to the root circle.

    Envelope of the rounded corner of the rack, derived here from the law of gearing: the common normal passes through
    the pitch point.  At an angle theta of that normal against the pitch line the corner, whose centre lies a below the
    pitch line and b from the middle of the rack tooth, touches at a/sin theta + rho from the pitch point, and the rack
    has moved by s = a/tan theta - b.
    """
    m, alpha = gear.module, gear.pressure_angle
    rho, b = _rack_rounding(gear, path)
    a = m * (gear.dedendum - gear.profile_shift) - rho
    depth = a + rho * math.sin(alpha)  # of the end of the rack's straight flank
    cut = depth / m - 0.5 * gear.virtual_teeth * math.sin(alpha) ** 2
    if cut > _UNDERCUT:
        raise ModelError(
            f"the tool undercuts the teeth by {cut:.2g} modules",
            path=path,
            given=f"{gear.teeth} teeth, profile shift {gear.profile_shift:.3g}",
            allowed=f"a profile shift of {gear.profile_shift + cut:.3g} or more",
        )
    theta = np.linspace(alpha, 0.5 * math.pi, _FILLET)
    reach = a / np.sin(theta) + rho
    x, y = reach * np.cos(theta), shape.reference - reach * np.sin(theta)
    turned = (a / np.tan(theta) - b) / shape.reference  # the rack has moved by s, the gear turned by s/r
    gap = np.arctan2(x, y) - turned  # angle from the middle of the gap
    return np.hypot(x, y), shape.half_pitch - gap


def _rack_rounding(gear: GearForm, path: str) -> tuple[float, float]:
    """Radius of the tip corner of the rack, and distance of its centre from the middle of the rack tooth [m]."""
    alpha = gear.pressure_angle
    tip = 0.25 * math.pi - gear.dedendum * math.tan(alpha)  # half width of the sharp tip
    per_radius = (1 - math.sin(alpha)) / math.cos(alpha)
    largest = tip / per_radius
    if tip <= 0:
        raise ModelError(
            "the rack is pointed before it reaches the root",
            path=path,
            given=f"dedendum {gear.dedendum:.4g}",
            allowed=f"less than {0.25 * math.pi / math.tan(alpha):.3g}",
        )
    if gear.tip_rounding is not None and gear.tip_rounding > largest * (1 + 1e-9):
        raise ModelError(
            "does not fit the tip of the rack", path=path, given=gear.tip_rounding, allowed=f"up to {largest:.3g}"
        )
    rounding = min(_ROUNDING, largest) if gear.tip_rounding is None else gear.tip_rounding
    return rounding * gear.module, (tip - rounding * per_radius) * gear.module


# ring: an arc that touches flank and root circle ---------------------------------------------------------------------


def _ring_fillet(gear: GearForm, shape: Outline, path: str) -> tuple[Array, Array]:
    """Fillet of a ring, an arc from the flank to the root circle: radius (m,) [m] and psi (m,) [rad]."""
    rho = gear.module * (_ROUNDING if gear.tip_rounding is None else gear.tip_rounding)
    touch, angle, pushed = _arc(shape, rho)
    if pushed > shape.half_pitch:
        if gear.tip_rounding is not None:
            raise ModelError("does not fit the gap of the ring", path=path, given=gear.tip_rounding)
        from scipy.optimize import brentq  # heavy, and needed by rings alone

        # a full round: the centre of the arc stands in the middle of the gap
        if _arc(shape, 0.0)[2] > shape.half_pitch:
            raise ModelError(
                "the gap of the ring is closed at its root", path=path, allowed="thinner teeth, less shift"
            )
        rho = brentq(lambda radius: _arc(shape, radius)[2] - shape.half_pitch, 0.0, rho, xtol=_XTOL * rho, rtol=_RTOL)
        touch, angle, pushed = _arc(shape, rho)
    if touch <= shape.tip:
        raise ModelError("the fillet of the ring leaves no flank", path=path, given=rho / gear.module)
    centre = (shape.root - rho) * np.array([math.sin(pushed), math.cos(pushed)])
    turn = np.linspace(angle, 0.5 * math.pi - pushed, _FILLET)
    x, y = centre[0] + rho * np.cos(turn), centre[1] + rho * np.sin(turn)
    return np.hypot(x, y), np.arctan2(x, y)


def _arc(shape: Outline, rho: float) -> tuple[float, float, float]:
    """Point at which an arc of radius rho [m] touches the flank: radius [m], polar angle from the centre of the arc
    [rad], and psi of that centre [rad].

    The centre lies rho off the flank along the normal, away from the tooth, and rho inside the root circle.  A curve
    parallel to an involute is one of the same base circle, whose roll length is less by rho; derived here.
    """
    reach = (shape.root - rho) ** 2 - shape.base**2
    roll = rho + math.sqrt(reach) if reach > 0 else 0.0
    # beyond an end of the flank the arc touches none, which the caller refuses
    radius = min(max(math.hypot(shape.base, roll), shape.base, shape.tip * 0.5), shape.root)
    psi, normal = (float(v[0]) for v in shape.flank_angle(np.array([radius])))
    x, y = radius * math.sin(psi) + rho * math.cos(normal), radius * math.cos(psi) - rho * math.sin(normal)
    return radius, math.pi - normal, math.atan2(x, y)


# both ----------------------------------------------------------------------------------------------------------------


def _joined(shape: Outline, fillet_radius: Array, fillet_psi: Array) -> Outline:
    """Outline of flank and fillet (m,) [m], [rad]; the flank ends where the fillet leaves it or cuts it."""
    start = 0
    if not shape.internal:  # the last point of the fillet on or inside the flank; the first without undercut
        involute = shape.flank_angle(np.maximum(fillet_radius, shape.base))[0]
        inside = (fillet_radius > shape.base) & (fillet_psi < involute - 1e-12)
        start = int(np.flatnonzero(inside)[-1]) if inside.any() else 0
    form = fillet_radius[start]
    left = shape.half_pitch - fillet_psi[-1]  # of the root circle
    floor = fillet_psi[-1] + left * np.linspace(0, 1, _FLOOR + 1)[1:] if left > 1e-9 else np.zeros(0)
    flank = np.linspace(shape.tip, form, _FLANK)
    radius = np.concatenate([flank, fillet_radius[start + 1 :], np.full(len(floor), shape.root)])
    psi = np.concatenate([shape.flank_angle(flank)[0], fillet_psi[start + 1 :], floor])
    psi[_FLANK - 1] = fillet_psi[start]
    x, y = radius * np.sin(psi), radius * np.cos(psi) * (1 if shape.internal else -1)
    slope = np.arctan2(np.gradient(x), np.gradient(y))
    return replace(shape, radius=radius, psi=psi, slope=slope, form=_FLANK - 1, form_radius=form)


# micro-geometry ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class Relief:
    """Tip, root or end relief: amount at the edge [m], length over which it fades [m], linear or parabolic."""

    amount: float
    length: float
    shape: Literal["linear", "parabolic"] = "linear"


@dataclass(frozen=True, slots=True, kw_only=True)
class Wave:
    """Profile waviness A cos(2 pi n sigma + phase): A [m], n waves a base pitch, phase at the pitch point [rad]."""

    amplitude: float
    order: int = 1
    phase: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Flank:
    """Micro-geometry of one flank of a gear; positive = material missing, lengths [m].

    tip_relief : height from the tip circle.  root_relief : height from the lowest point of contact with the mate.
    end_relief : length along the axis from either end of the face.  crown : lead crowning, missing at both ends of the
    face, parabolic, none at mid-face.  slope : lead slope over the face width, half of it missing at the right end and
    half of it in excess at the left.  profile : measured deviation at heights below the tip circle,
    ((height, missing), ...), linear between, constant beyond.  waves : waviness along the path of contact.
    pitch : cumulative deviation of each tooth, or empty.
    """

    tip_relief: Relief | None = None
    root_relief: Relief | None = None
    end_relief: Relief | None = None
    crown: float = 0.0
    slope: float = 0.0
    profile: tuple[tuple[float, float], ...] = ()
    waves: tuple[Wave, ...] = ()
    pitch: tuple[float, ...] = ()


PLAIN = Flank()


def profile_modification(flank: Flank, *, below_tip: ArrayLike, above_root: ArrayLike, sigma: ArrayLike) -> Array:
    """Profile modification: material missing over the profile [m], of the common shape (...) of its arguments.

    below_tip : (...) height below the tip circle [m].  above_root : (...) height above the lowest point of contact
    with the mate [m].  sigma : (...) place on the path of contact [base pitches].
    """
    depth, height = np.asarray(below_tip, dtype=float), np.asarray(above_root, dtype=float)
    missing = _relieved(flank.tip_relief, depth) + _relieved(flank.root_relief, height)
    if flank.profile:
        at, value = np.array(flank.profile).T
        missing = missing + np.interp(depth, at, value)
    for wave in flank.waves:
        turn = 2 * np.pi * wave.order * np.asarray(sigma) + wave.phase
        missing = missing + wave.amplitude * np.cos(turn)
    return np.asarray(missing)


def lead_modification(flank: Flank, zeta: ArrayLike, face: tuple[float, float]) -> Array:
    """Lead modification: material missing over the face [m], of the shape (...) of zeta.

    zeta : (...) place along the axis [m].  face : left and right end of the face of the gear itself [m].
    """
    left, right = face
    along = np.asarray(zeta, dtype=float)
    part = (2 * along - left - right) / (right - left)
    ends = _relieved(flank.end_relief, np.minimum(along - left, right - along))
    return np.asarray(flank.crown * part**2 + 0.5 * flank.slope * part + ends)


def _relieved(relief: Relief | None, distance: Array) -> Array:
    """Depth (...) of a relief at a distance (...) from its edge [m]; beyond the edge that of the edge."""
    if relief is None or relief.amount == 0.0:
        return np.zeros_like(distance)
    part = np.clip(1 - distance / relief.length, 0.0, 1.0)
    return np.asarray(relief.amount * (part**2 if relief.shape == "parabolic" else part))


def check_flank(flank: Flank, *, height: float, width: float, teeth: int, path: str = "") -> None:
    """Refuse micro-geometry that does not fit a flank.

    height : of the active flank [m].  width : of the face [m].  path : of the flank in the model file.

    Raises
    ------
    ModelError : a relief without length or longer than the flank (end relief: than half the face), a negative or
        infinite amount or one above the height, heights of a profile that do not rise, pitch deviations of another
        number than teeth.
    """
    for name, most in (("tip_relief", height), ("root_relief", height), ("end_relief", width / 2)):
        _check_relief(getattr(flank, name), most, f"{path}.{name}" if path else name)
    for name in ("crown", "slope"):
        if not math.isfinite(getattr(flank, name)):
            raise ModelError("is no finite length", path=f"{path}.{name}", given=getattr(flank, name))
    for name, size in amounts(flank):
        if abs(size) > height:
            raise ModelError(
                "more than the height of the flank: no micro-geometry",
                path=f"{path}.{name}" if path else name,
                given=in_mm(size),
                allowed=f"at most {in_mm(height, 5)}",
            )
    heights = [at for at, _ in flank.profile]
    if any(b <= a for a, b in itertools.pairwise(heights)) or not np.isfinite(flank.profile).all():
        raise ModelError("heights below the tip must rise", path=f"{path}.profile", given=heights)
    if flank.pitch and len(flank.pitch) != teeth:
        raise ModelError("one deviation a tooth", path=f"{path}.pitch", given=len(flank.pitch), allowed=str(teeth))


def check_flanks(
    plane: PlaneOfAction, flanks: tuple[Flank, Flank], teeth: tuple[int, int], paths: tuple[str, str]
) -> None:
    """Refuse micro-geometry that does not fit the flank of either gear of a pair, as `check_flank`."""
    sides = (plane.radius_a, plane.face_a), (plane.radius_b, plane.face_b)
    for flank, (radius, face), number, path in zip(flanks, sides, teeth, paths, strict=True):
        height = abs(float(radius(plane.limits[1]) - radius(plane.limits[0])))
        check_flank(flank, height=height, width=face[1] - face[0], teeth=number, path=path)


def amounts(flank: Flank) -> Iterator[tuple[str, float]]:
    """Yield name and size [m] of everything that takes material off, or leaves it."""
    yield from (("crown", flank.crown), ("slope", flank.slope))
    for name in ("tip_relief", "root_relief", "end_relief"):
        if (relief := getattr(flank, name)) is not None:
            yield f"{name}.amount", relief.amount
    yield from (("profile.missing", missing) for _, missing in flank.profile)
    yield from (("wave.amplitude", wave.amplitude) for wave in flank.waves)


def _check_relief(relief: Relief | None, most: float, path: str) -> None:
    if relief is None:
        return
    if not 0 <= relief.amount < math.inf:
        raise ModelError("takes material off", path=f"{path}.amount", given=relief.amount, allowed="0 or more [m]")
    if relief.amount and not 0 < relief.length <= most * (1 + 1e-9):
        raise ModelError(
            "does not fit the flank",
            path=f"{path}.length",
            given=in_mm(relief.length, 5),
            allowed=f"more than 0, at most {in_mm(most, 5)}",
        )
