"""Path of contact of one helix: contact lines on the plane of action, corner contact, sliding and loss factor.

Pair j at zeta along the face is in contact at sigma + j + d h zeta/p_x base pitches from the pitch point while that
place is on the path of contact (docs/conventions.md, Phases).  A segment cut by the end of the path keeps the part on
the path, so that the length of all lines is exact at every phase; its mean is eps_alpha b/cos beta_b [maatar1996].
Spur teeth are in contact over the whole face at once.

Load per length is a mean over a stated length of the line.  A line that begins at a corner of an unmodified flank bears
on a tooth that is not yet deflected.  As its length goes to zero, its load per length rises to what the line contact
alone needs for the whole approach, under a force of zero: a value at a point grows with every refinement.  The line
contact [weber1953] is plane between the flank and the middle of the tooth, a depth of almost a module, and has no
meaning over shorter lengths.  The mean over a length of that size is what the theory can state, and it converges
(derived here).

Phases of a mesh cycle are evenly spaced, and at the corners of contact.  The state of contact has a kink, of spur teeth
a jump, where the end of a contact line passes a corner of the flank.  Between corners it is smooth, so that the
extremes over the cycle converge with the second order in the distance of the phases once the corners are among them; a
jump is taken from both sides.  Means and harmonics are those of values linear between the phases.

In corner contact the edge of a tip bears on the flank of the mate, before and behind the path of contact: before it the
tip of b approaches the flank of a, behind it the tip of a leaves that of b.  Their separation follows from the
involutes alone at any distance, and grows near the ends as the square of the distance (derived here).  The deflection
of the pairs in mesh closes it.

At the distance s from the pitch point the teeth of a pair slide on each other with v_s = |s| (w_a + w_b), in a ring
|s| (w_a - w_b), across the plane of action; w are speeds in the frame of the carrier.  The normal force F_n transmits
the power F_n cos beta_b v with v = w_a r_ba = w_b r_bb, so that of a power P the friction takes mu H_V P with

    H_V = 2 pi / cos beta_b |1/z_a +- 1/z_b| <|sigma|>        - for a ring b, s = sigma p_bt, r_b = z p_bt / 2 pi

where <|sigma|> is the mean of |sigma| over mesh cycle and contact lines, weighted with the load on them.  Derived here.
With uniform load per length of contact line every spur pair in contact bears the same, and between contact ratios of 1
and 2 this is pi (u + 1)/(z_a u) (1 - eps + eps_1^2 + eps_2^2) [ohlendorf1958].  Places sigma count from the pitch point
in base pitches, as of `geometry.contact_limits`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# The radius of curvature vanishes at a base circle: a length of roll below this part of a base pitch counts as this.
_LEAST_ROLL = 1e-3
# Distance of the two sides of a jump [base pitches]: far above the rounding of a place on the path, far below any
# distance that matters.
_SIDE = 1e-9

END_PART = 0.1
"""Part of a face over which the largest load per width is a mean [1].  At an end that is not relieved the load per
width grows with the logarithm of the slices; over a tenth of the face it changes by 4e-4 from 20 slices to 80."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneOfAction:
    """Plane of action of one helix; lengths [m], angles [rad].

    base_a, base_b : base radii.  internal : b is a ring.  pressure_angle : working transverse.  base_helix : beta_b,
    magnitude.  base_pitch : transverse p_bt.  limits : (sigma_min, sigma_max) of the path of contact [1].
    lean : d h of gear a, +1 or -1, 0 for spur teeth.  face_a, face_b : ends (left, right) of the faces along the axis,
    from the middle of the mesh, axial offsets of the gears included.
    """

    base_a: float
    base_b: float
    internal: bool = False
    pressure_angle: float
    base_helix: float = 0.0
    base_pitch: float
    limits: tuple[float, float]
    lean: int = 0
    face_a: tuple[float, float]
    face_b: tuple[float, float]

    @property
    def face(self) -> tuple[float, float]:
        """Overlap of both faces, (left, right) [m]."""
        return max(self.face_a[0], self.face_b[0]), min(self.face_a[1], self.face_b[1])

    @property
    def width(self) -> float:
        """Width of the overlap of both faces [m]."""
        return self.face[1] - self.face[0]

    def cells(self, count: int) -> Array:
        """Middles (count,) of even cells of the overlap along the axis [m]."""
        return np.asarray(self.face[0] + self.width / count * (np.arange(count) + 0.5))

    @property
    def per_pitch(self) -> float:
        """d h/p_x, the shift of the contact per length along the face [base pitches/m]; 0 for spur teeth."""
        return self.lean * math.tan(self.base_helix) / self.base_pitch

    def roll_a(self, sigma: ArrayLike) -> Array:
        """Length of roll on a (...) [m]: from its base tangent point to the contact at sigma (...) [base pitches]."""
        return self.base_a * math.tan(self.pressure_angle) + np.asarray(sigma) * self.base_pitch

    def roll_b(self, sigma: ArrayLike) -> Array:
        """Length of roll on b (...) [m]: from its base tangent point to the contact at sigma (...) [base pitches]."""
        along = np.asarray(sigma) * (self.base_pitch if self.internal else -self.base_pitch)
        return self.base_b * math.tan(self.pressure_angle) + along

    def radius_a(self, sigma: ArrayLike) -> Array:
        """Radius (...) of the contact on gear a [m] at sigma (...) [base pitches]."""
        return np.hypot(self.base_a, self.roll_a(sigma))

    def radius_b(self, sigma: ArrayLike) -> Array:
        """Radius (...) of the contact on gear b [m] at sigma (...) [base pitches]."""
        return np.hypot(self.base_b, self.roll_b(sigma))

    def curvature_radius(self, sigma: ArrayLike) -> Array:
        """Relative radius of curvature (...) in the normal plane [m] at sigma (...), transverse over cos beta_b."""
        least = _LEAST_ROLL * self.base_pitch
        a, b = np.maximum(self.roll_a(sigma), least), np.maximum(self.roll_b(sigma), least)
        between = 1 / a + (-1 / b if self.internal else 1 / b)
        return np.asarray(1 / (between * math.cos(self.base_helix)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactLines:
    """Contact lines at T phases: J pairs of teeth, K segments of the face from left to right.

    zeta : (T, J, K) middle of the part of each segment on the path of contact, along the axis [m].  sigma : (T, J, K)
    its place on that path [base pitches].  length : (T, J, K) of contact line [m], 0 out of contact.
    pair : (T, J) number of the pair of teeth, one more for each that enters as sigma rises.
    centre, span : (K,) middles and (,) width of the segments along the axis [m].
    """

    zeta: Array
    sigma: Array
    length: Array
    pair: Index
    centre: Array
    span: float


def contact_lines(
    plane: PlaneOfAction, sigma: ArrayLike, slices: int, *, beyond: tuple[float, float] = (0.0, 0.0)
) -> ContactLines:
    """Contact lines at T places of one pair of teeth at mid-face.

    Parameters
    ----------
    sigma : (T,) [base pitches].  slices : K.  beyond : path of contact added before and behind its ends [base pitches].
    """
    place = np.atleast_1d(np.asarray(sigma, dtype=float))
    low, high = plane.limits[0] - beyond[0], plane.limits[1] + beyond[1]
    span, centre = plane.width / slices, plane.cells(slices)
    lead = plane.per_pitch * centre
    half = 0.5 * abs(plane.per_pitch) * span
    first = math.floor(low - 1.0 - float(lead.max()) - half)
    last = math.ceil(high - float(lead.min()) + half)
    whole = np.floor(place)
    pairs = np.arange(first, last + 1)
    middle = (place - whole)[:, None, None] + pairs[:, None] + lead
    if half > 0:
        start, end = np.clip(middle - half, low, high), np.clip(middle + half, low, high)
        part = (end - start) / (2 * half)
        along = 0.5 * (start + end)
    else:
        part = ((middle >= low) & (middle < high)).astype(float)
        along = np.clip(middle, low, high)
    touched = part > 0
    inside = np.where(touched, along, middle)
    zeta = centre + (inside - middle) / plane.per_pitch if half > 0 else np.broadcast_to(centre, middle.shape)
    seen = np.flatnonzero(touched.any(axis=(0, 2)))
    kept = slice(int(seen[0]), int(seen[-1]) + 1) if seen.size else slice(0, 1)
    return ContactLines(
        zeta=zeta[:, kept],
        sigma=inside[:, kept],
        length=part[:, kept] * span / math.cos(plane.base_helix),
        pair=(whole[:, None] - pairs[None, kept]).astype(np.int64),
        centre=centre,
        span=span,
    )


# load per length -----------------------------------------------------------------------------------------------------


def largest_part_mean(force: Array) -> Array:
    """Largest force per slice (...) [N], as the mean over any `END_PART` of the face, of forces (..., K) of K slices.

    With fewer slices than parts it is that of the largest slice.  A load that is linear over the face, 1 + a at its
    end, gives 1 + 0.9 a.
    """
    count = force.shape[-1]
    edges = np.arange(count + 1) / count
    # the mean is linear between places where either end of the window is at the edge of a slice
    begin = np.unique(np.clip(np.concatenate([edges, edges - END_PART]), 0.0, 1.0 - END_PART))
    summed = np.concatenate([np.zeros((*force.shape[:-1], 1)), np.cumsum(force, axis=-1)], axis=-1)

    def up_to(place: Array) -> Array:
        at = np.minimum((place * count).astype(np.int64), count - 1)
        return np.asarray(summed[..., at] + (place * count - at) * force[..., at])

    part = up_to(begin + END_PART) - up_to(begin)
    return np.asarray(part.max(axis=-1) / (END_PART * count))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineWindows:
    """A window on the contact line about every segment, moved to lie within the line.

    length : of all windows along the line [m].  sigma : (T, J, K) place of their middles [base pitches].
    first, last : (T, J, K) slices in which they begin and end.  before, within : (T, J, K) shares of the forces of
    these slices that lie before the beginning, and before the end [1].
    """

    length: float
    sigma: Array
    first: Index
    last: Index
    before: Array
    within: Array

    def mean(self, force: Array) -> Array:
        """Mean load per length (..., T, J, K) [N/m] of forces on the segments (..., T, J, K) [N]."""
        summed = np.cumsum(force, axis=-1) - force

        def up_to(slices: Index, share: Array) -> Array:
            at = np.broadcast_to(slices, force.shape)
            return np.take_along_axis(summed, at, -1) + share * np.take_along_axis(force, at, -1)

        return np.asarray((up_to(self.last, self.within) - up_to(self.first, self.before)) / self.length)


def averaging_length(plane: PlaneOfAction) -> float:
    """Length of contact line over which loads are averaged [m]: normal base pitch over pi, m_n cos alpha_n.

    At most the width of the face.
    """
    slant = math.cos(plane.base_helix)
    return min(plane.base_pitch * slant / math.pi, plane.width / slant)


def line_windows(plane: PlaneOfAction, lines: ContactLines) -> LineWindows:
    """Windows of `averaging_length` on contact lines; a shorter line is averaged over that length all the same."""
    slant, length = math.cos(plane.base_helix), averaging_length(plane)
    touched = lines.length > 0
    half = 0.5 * lines.length * slant
    start, end = lines.zeta - half, lines.zeta + half
    left = np.where(touched, start, np.inf).min(axis=2, keepdims=True)
    right = np.where(touched, end, -np.inf).max(axis=2, keepdims=True)
    reach = np.minimum(0.5 * length * slant, 0.5 * np.maximum(right - left, 0.0))
    with np.errstate(invalid="ignore"):
        middle = np.where(touched, np.clip(lines.zeta, left + reach, right - reach), lines.zeta)
    reach = np.where(touched, reach, 0.0)

    def located(place: Array) -> tuple[Index, Array]:
        """Slice of each place (T, J, K) [m], and share of its part that lies before the place."""
        slices = np.clip(np.floor((place - plane.face[0]) / lines.span).astype(np.int64), 0, lines.zeta.shape[2] - 1)
        begin, size = np.take_along_axis(start, slices, 2), np.take_along_axis(2 * half, slices, 2)
        share = (place - begin) / np.where(size > 0, size, 1.0)
        return slices, np.clip(np.where(size > 0, share, 0.0), 0.0, 1.0)

    first, before = located(middle - reach)
    last, within = located(middle + reach)
    sigma = lines.sigma + (middle - lines.zeta) * plane.per_pitch
    return LineWindows(length=length, sigma=sigma, first=first, last=last, before=before, within=within)


# phases --------------------------------------------------------------------------------------------------------------


def corner_phases(plane: PlaneOfAction) -> Array:
    """Places sigma in [0, 1) of one pair of teeth at mid-face, at which a contact line passes a corner of the flank.

    Of helical teeth also those at which a line that begins or ends at a corner has the length over which loads are
    averaged, where their mean is largest; of spur teeth both sides of the jumps.
    """
    low, high = plane.limits
    if plane.per_pitch == 0:
        return np.mod([low - _SIDE, low + _SIDE, high - _SIDE, high + _SIDE], 1.0)
    ends = np.array(plane.face) * plane.per_pitch
    part = averaging_length(plane) * math.cos(plane.base_helix) * abs(plane.per_pitch)
    passed = [limit - end for limit in (low, high) for end in ends]
    return np.mod([*passed, low - ends.max() + part, high - ends.min() - part], 1.0)


def graded_phases(corners: ArrayLike, count: int) -> Array:
    """Phases (T,) of a cycle, rising from 0: `count` even ones and the corners (C,), each once."""
    phase = np.unique(np.concatenate([np.arange(count) / count, np.mod(np.asarray(corners, dtype=float), 1.0)]))
    apart = np.diff(phase, append=phase[0] + 1.0)
    return np.asarray(phase[apart > 0.1 * _SIDE])


def _pieces(values: Array, phase: Array) -> tuple[Array, Array, Array, Array]:
    """Lengths (T,) and middles (T,) of the pieces of a cycle, means and differences (..., T) of their end values."""
    length = np.diff(phase, append=phase[0] + 1.0)
    following = np.roll(values, -1, axis=-1)
    return length, phase + 0.5 * length, 0.5 * (values + following), following - values


def cycle_mean(values: Array, phase: Array) -> Array:
    """Mean over the cycle (...) of values (..., T) at rising phases (T,), linear between them, in their unit."""
    length, _, mean, _ = _pieces(values, phase)
    return np.asarray(mean @ length)


def cycle_harmonics(values: Array, phase: Array, count: int) -> NDArray[np.complex128]:
    """One-sided complex amplitudes c_l (..., count + 1) as of `loaded_contact.harmonics`, of uneven phases (T,).

    Those of the values linear between the phases, exactly (derived here): a piece of length h about m adds
    h exp(-i w m) [mean j_0(w h/2) - i/2 difference j_1(w h/2)], w = 2 pi l.
    """
    from scipy.special import spherical_jn  # slow to import, and a train that is only resolved does without

    length, middle, mean, difference = _pieces(values, phase)
    order = np.arange(count + 1)
    angle = np.pi * np.outer(order, length)
    turn = length * np.exp(-2j * np.pi * np.outer(order, middle))
    even, odd = turn * spherical_jn(0, angle), turn * spherical_jn(1, angle)
    amplitudes = mean @ even.T - 0.5j * (difference @ odd.T)
    amplitudes[..., 1:] *= 2
    return np.asarray(amplitudes, dtype=np.complex128)


# corner contact ------------------------------------------------------------------------------------------------------


def tip_separation(plane: PlaneOfAction, sigma: ArrayLike) -> Array:
    """Separation of a tip and the flank of the mate along the tooth normal, beyond the path of contact (...) [m].

    sigma : (...) place on the continued path of contact [base pitches].  0 on the path itself, inf where the mate has
    no flank.
    """
    place = np.asarray(sigma, dtype=float)
    total = np.zeros_like(place)
    for past, tip_of_b in ((plane.limits[0] - place, True), (place - plane.limits[1], False)):
        apart = _of_tip(plane, np.maximum(past, 0.0), tip_of_b=tip_of_b)
        total = np.where(past > 0, np.maximum(apart, 0.0), total)  # rounding may leave a negative separation
    return np.asarray(total * math.cos(plane.base_helix))


def corner_reach(plane: PlaneOfAction, gap: float) -> tuple[float, float]:
    """Distances beyond both ends of the path of contact at which the separation reaches a gap [m] [base pitches].

    At most one base pitch.
    """
    # Bisection stays: the separation is infinite where a tip has left the flank, and a secant step would stop there.
    distances = []
    for edge, away in ((plane.limits[0], -1.0), (plane.limits[1], 1.0)):
        low, high = 0.0, 1.0
        for _ in range(50):  # to rounding of one base pitch
            middle = 0.5 * (low + high)
            low, high = (middle, high) if float(tip_separation(plane, edge + away * middle)) < gap else (low, middle)
        distances.append(high)
    return distances[0], distances[1]


def _of_tip(plane: PlaneOfAction, past: Array, *, tip_of_b: bool) -> Array:
    """Transverse separation (...) [m] at distances (...) past the end of the path [base pitches].

    Axes e and t of docs/conventions.md (The mesh row) as a complex plane, with d = +1.
    """
    alpha, base_a, base_b = plane.pressure_angle, plane.base_a, plane.base_b
    centre = complex((base_b - base_a) * -1 if plane.internal else base_a + base_b) / math.cos(alpha)
    edge = plane.limits[0] if tip_of_b else plane.limits[1]
    point = base_a / math.cos(alpha) + edge * plane.base_pitch * complex(math.sin(alpha), math.cos(alpha))
    turned = past * plane.base_pitch
    sense = 1.0 if plane.internal else -1.0
    if tip_of_b:  # b turns back by the distance past the end; its tip meets the flank of a
        moved = centre + (point - centre) * np.exp(-1j * sense * turned / base_b)
        flank = _flank(moved, base_a, alpha, edge - past, plane.base_pitch)
        return np.asarray(base_a * (np.angle(moved) - flank))
    moved = point * np.exp(1j * turned / base_a)
    seen = moved - centre
    if plane.internal:
        flank = _flank(seen, base_b, alpha, edge + past, plane.base_pitch)
        return np.asarray(base_b * (flank - np.angle(seen)))
    # in the axes of b the geometry is the same, rotated by half a turn, and sigma has the opposite sense
    flank = _flank(-seen, base_b, alpha, -(edge + past), plane.base_pitch)
    return np.asarray(base_b * (np.angle(-seen) - flank))


def _flank(point: NDArray[np.complex128], base: float, alpha: float, sigma: Array, pitch: float) -> Array:
    """Polar angle (...) of the involute through sigma at the radius of points (...) [rad]; -inf in the base circle."""
    start = math.tan(alpha) + sigma * pitch / base - alpha
    radius = np.abs(point)
    angle = np.arccos(np.minimum(1.0, base / radius))
    return np.asarray(np.where(radius > base, start - (np.tan(angle) - angle), -np.inf))


# sliding and loss factor ---------------------------------------------------------------------------------------------

Limits = tuple[float, float]

# Nodes of Gauss and Legendre between two corners of contact: the integrand, a quadratic over a linear function, is
# then exact to rounding unless contact is all but lost.
_NODES = 24
# Below this overlap ratio teeth count as spur: what the helix changes is then below rounding.
_SPUR = 1e-9
# Length of contact line [base pitches of overlap] that counts as none: rounding.
_NONE = 1e-12


def loss_factor(teeth_a: int, teeth_b: int, base_helix: float, distance: float, *, internal: bool = False) -> float:
    """Loss factor H_V of a mesh [1]; derived here.

    Parameters
    ----------
    base_helix : beta_b [rad].  distance : <|sigma|>, as of `sliding_distance` [base pitches].  internal : b is a ring.
    """
    slide = 1 / teeth_a - 1 / teeth_b if internal else 1 / teeth_a + 1 / teeth_b
    return math.tau / math.cos(base_helix) * abs(slide) * distance


def touches_always(limits: Limits, overlap: float) -> bool:
    """Whether some contact line bears at every instant; overlap : overlap ratio [1]."""
    if overlap <= _SPUR:
        return limits[1] - limits[0] >= 1 - _NONE
    return bool(_line_length(_corners(limits, overlap), limits, overlap).min() > _NONE)


def sliding_distance(limits: Limits, overlap: float = 0.0) -> float:
    """Mean distance <|sigma|> of the load from the pitch point with uniform load per length of contact line [1].

    Parameters
    ----------
    limits : (sigma_min, sigma_max) of the path of contact [base pitches].  overlap : overlap ratio of one helix [1].
        Contact must not be lost (`touches_always`).
    """
    # integral over the phase from corner to corner of contact
    corners = _corners(limits, overlap)
    node, share = np.polynomial.legendre.leggauss(_NODES)
    half = np.diff(corners)[:, None] / 2
    middle = corners[:-1, None] + half
    phase, weight = (middle + half * node).ravel(), (half * share).ravel()
    places = pair_places(phase, limits, overlap)
    if overlap <= _SPUR:
        on = (places >= limits[0]) & (places <= limits[1])
        moment, length = np.where(on, np.abs(places), 0.0).sum(axis=1), on.sum(axis=1)
    else:
        low, high = _on_path(places, limits, overlap)
        moment = np.where(high > low, high * np.abs(high) - low * np.abs(low), 0.0).sum(axis=1) / 2
        length = np.maximum(high - low, 0.0).sum(axis=1)
    return float(weight @ (moment / length))


def path_load(limits: Limits, overlap: float, sigma: ArrayLike) -> Array:
    """Mesh force per base pitch at places of the path of contact, per mesh force (n,) [1]; uniform load per length.

    Mean over mesh cycle and face; of spur teeth the share of a pair in contact there.  Its integral over the path is 1.
    sigma : (n,) [base pitches].  limits, overlap : as of `sliding_distance`.
    """
    at = np.atleast_1d(np.asarray(sigma, dtype=float))
    inside = (at >= limits[0]) & (at <= limits[1])
    if overlap <= _SPUR:
        places = pair_places(at, limits)
        count = ((places >= limits[0] - _NONE) & (places <= limits[1] + _NONE)).sum(axis=1)
        return np.where(inside, 1 / np.maximum(count, 1), 0.0)
    # a place is passed by the contact line at phases sigma .. sigma + overlap, from one end of the face to the other
    return np.where(inside, _inverse_length(at + overlap, limits, overlap) - _inverse_length(at, limits, overlap), 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rolling:
    """Motion of two flanks along the path of contact, at the places sigma (n,) [base pitches].

    speed_a, speed_b : of the flanks across the line of contact [m/s], one sign where both roll one way.
    """

    speed_a: Array
    speed_b: Array

    @classmethod
    def of(cls, plane: PlaneOfAction, sigma: ArrayLike, base_speed: float) -> Rolling:
        """Rolling of the flanks of a pair.

        base_speed : of the base circles in the frame of the carrier, w_a r_ba [m/s].
        """
        speed_a, speed_b = base_speed / plane.base_a, base_speed / plane.base_b
        return cls(speed_a=speed_a * plane.roll_a(sigma), speed_b=speed_b * plane.roll_b(sigma))

    @property
    def sliding(self) -> Array:
        """Sliding speed, flank of a less flank of b (n,) [m/s]."""
        return self.speed_a - self.speed_b

    @property
    def specific_a(self) -> Array:
        """Specific sliding of a, sliding speed per speed of its flank (n,) [1]; infinite at the base tangent point."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.sliding / self.speed_a)

    @property
    def specific_b(self) -> Array:
        """Specific sliding of b (n,) [1], as of a."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(-self.sliding / self.speed_b)


def mean_friction(
    load_per_width: float, sum_speed: float, curvature_radius: float, viscosity: float, roughness: float
) -> float:
    """Mean coefficient of friction of lubricated teeth [1] [iso14179], with the lubricant factor 1 of mineral oils.

    0.048 (F_bt/b / (v_sigma rho))^0.2 eta^-0.05 Ra^0.25 in N/mm, m/s, mm, mPa s and um; meant for loads of 150 N/mm and
    more and pitch-line speeds up to 50 m/s.

    Parameters
    ----------
    load_per_width : F_bt / b, transverse normal force per face width [N/m].
    sum_speed : sum of the speeds of both flanks at the pitch point [m/s].
    curvature_radius : relative, there, in the normal plane [m].
    viscosity : dynamic, of the oil in the mesh [Pa s].  roughness : mean Ra of both flanks [m].
    """
    load = load_per_width * 1e-3 / (sum_speed * curvature_radius * 1e3)
    return float(0.048 * load**0.2 * (viscosity * 1e3) ** -0.05 * (roughness * 1e6) ** 0.25)


def _corners(limits: Limits, overlap: float) -> Array:
    """Phases in [0, 1] between which the contact lines change smoothly, rising, with both ends."""
    passed = [end + shift for end in (*limits, 0.0) for shift in (0.0, overlap)]
    return np.unique(np.concatenate([[0.0, 1.0], np.mod(passed, 1.0)]))


def pair_places(phase: Array, limits: Limits, overlap: float = 0.0) -> Array:
    """Places (m, J) of the leading end of every contact line that may touch, at phases (m,) [base pitches]."""
    first, last = math.floor(limits[0] - phase.max()), math.ceil(limits[1] + overlap - phase.min())
    return phase[:, None] + np.arange(first, last + 1)


def _on_path(places: Array, limits: Limits, overlap: float) -> tuple[Array, Array]:
    """Ends (low, high) of the part of every contact line on the path; low >= high where there is none."""
    return np.maximum(places - overlap, limits[0]), np.minimum(places, limits[1])


def _line_length(phase: Array, limits: Limits, overlap: float) -> Array:
    """Length of all contact lines (m,) at phases (m,), in base pitches along the path."""
    low, high = _on_path(pair_places(phase, limits, overlap), limits, overlap)
    return np.asarray(np.maximum(high - low, 0.0).sum(axis=1))


def _inverse_length(phase: Array, limits: Limits, overlap: float) -> Array:
    """Integral of 1 / `_line_length` from 0 to phases (n,) [1]."""
    corners = _corners(limits, overlap)
    length = _line_length(corners, limits, overlap)
    piece = np.diff(corners) / _log_mean(length[:-1], length[1:])
    before = np.concatenate([[0.0], np.cumsum(piece)])
    turn, part = np.floor(phase), np.mod(phase, 1.0)
    at = np.clip(np.searchsorted(corners, part, side="right") - 1, 0, len(piece) - 1)
    step = part - corners[at]
    reached = length[at] + (length[at + 1] - length[at]) * step / (corners[at + 1] - corners[at])
    return np.asarray(turn * before[-1] + before[at] + step / _log_mean(length[at], reached))


def _log_mean(first: Array, last: Array) -> Array:
    """Logarithmic mean (n,), whose inverse is the mean of 1/x of a linear x from one to the other."""
    apart = (last - first) / first
    varies = apart != 0
    safe = np.where(varies, apart, 1.0)
    return np.asarray(first * np.where(varies, safe / np.log1p(safe), 1.0))
