"""Involute geometry of one cylindrical gear and of one pair of gears [iso21771], phases of its teeth, its
deviations.

Numbers of teeth are positive, of a ring too; ``internal=True`` marks a ring (of a pair: gear b).  A positive profile
shift lengthens the addendum, of a ring too.  Gear a of a pair is external.  The place of contact sigma counts from the
pitch point along the push of a on b, in base pitches (docs/conventions.md, Phases).  No function of a pair raises: one
that cannot exist returns nan or a negative clearance, and the caller names the entry of the model file.  The involute
function and its inverse hold to the last digits also where tan(angle) - angle cancels.

Tooth phases are the position of a tooth, and of its contact on the line of action.  Angles are in turns, phases in
tooth pitches (docs/conventions.md, Phases).  tau = teeth x (polar angle of a tooth centre) is the tooth phase of a
gear.  P is the polar angle of e, from the centre of A to the pitch point.  d = +1 where A pushes B along z cross e.
sigma is the place of the contact from the pitch point along the line of action, in base pitches.  From the half tooth
angle at the base circle, (pi/2 + 2 x tan alpha_n)/z + inv alpha_t, the involute gives

    A                 sigma = d (tau_A - z_A P) + 1/4 + c_A
    external mate B   tau_B = z_B (P + 1/2) - d (sigma + 1/4 + c_B)
    ring B            tau_B = z_B P + d (sigma + 1/4 + c_B)
    c = x tan(alpha_n)/pi + z (inv alpha_t - inv alpha_w)/(2 pi),   z < 0 for a ring

c is zero without profile shift, and all phases are rational: `Phase` keeps the rational part exact.  Derived here, in
agreement with the published mesh phasing relations [parker2004].

Grades of tolerances are of a gear (ISO 1328-1:2013) and of a size (ISO 286-1:2010), and deviations have spectral lines.
ISO 1328-1:2013 states formulas, here with its rounding; the tolerances of ISO 286-1 are the values of its table, which
its formulas i = 0.45 D^(1/3) + 0.001 D meet but for a few old preferred numbers.

A spectral line of a profile or pitch deviation is Re(amplitude exp(2 pi i f t)).  A positive deviation is missing
material and opens the gap (docs/conventions.md, Forces, stiffness, errors).
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, overload

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# tan a - a = a^3/3 + 2 a^5/15 + ...; below _SMALL the first omitted term is 3e-18 of the first.
_SERIES = (
    1 / 3,
    2 / 15,
    17 / 315,
    62 / 2835,
    1382 / 155925,
    21844 / 6081075,
    929569 / 638512875,
    6404582 / 10854718875,
)
_SMALL = 0.1


# involute function ---------------------------------------------------------------------------------------------------


@overload
def involute(angle: float) -> float: ...
@overload
def involute(angle: Array) -> Array: ...
def involute(angle: float | Array) -> float | Array:
    """Involute function inv a = tan a - a [iso21771], by its series where the difference cancels.

    angle : pressure angle, |angle| < pi/2, a float or of shape (...) [rad].  Returns the same shape [rad].
    """
    values = np.asarray(angle, dtype=float)
    square = np.minimum(values**2, _SMALL**2)
    series = values * square * np.polynomial.polynomial.polyval(square, _SERIES)
    return _like(angle, np.where(np.abs(values) < _SMALL, series, np.tan(values) - values))


@overload
def inverse_involute(value: float) -> float: ...
@overload
def inverse_involute(value: Array) -> Array: ...
def inverse_involute(value: float | Array) -> float | Array:
    """Inverse involute function: pressure angle whose involute is `value`, within 1e-14 rad.

    value : a float or of shape (...) [rad]; negative values give negative angles, nan gives nan.  Returns the same
    shape [rad].  Newton's method on the whole array: from a start above or near the root it needs no bracket, and the
    last digits of every working pressure angle are those of this iteration.
    """
    values = np.asarray(value, dtype=float)
    size = np.abs(values)
    root = np.cbrt(3.0 * size)
    # u = tan(angle) solves u - atan u = value: u ~ root + root^3/5 near zero, u < value + pi/2 always.
    tangent = np.minimum(root + root**3 / 5.0, size + 0.5 * np.pi)
    angle = np.arctan(tangent)
    for _ in range(8):
        slope = np.maximum(np.tan(angle) ** 2, np.finfo(float).tiny)
        angle = np.clip(angle - (np.asarray(involute(angle)) - size) / slope, 0.0, 0.5 * np.pi)
    return _like(value, np.copysign(angle, values))


def _like(model: float | Array, values: Array) -> float | Array:
    """Values (...) [rad] as a float where the argument was one."""
    return values if isinstance(model, np.ndarray) else float(values)


# one gear ------------------------------------------------------------------------------------------------------------


def transverse_module(module: float, helix_angle: float) -> float:
    """Transverse module m_t = m_n / cos beta [m] from normal module [m] and helix angle [rad] [iso21771]."""
    return module / math.cos(helix_angle)


def transverse_pressure_angle(pressure_angle: float, helix_angle: float) -> float:
    """Transverse pressure angle, tan alpha_t = tan alpha_n / cos beta [rad] [iso21771]."""
    return math.atan(math.tan(pressure_angle) / math.cos(helix_angle))


def base_helix_angle(pressure_angle: float, helix_angle: float) -> float:
    """Base helix angle, sin beta_b = sin beta cos alpha_n [rad], alpha_n the normal pressure angle [iso21771]."""
    return math.asin(math.sin(helix_angle) * math.cos(pressure_angle))


def reference_radius(teeth: int, module: float, helix_angle: float) -> float:
    """Reference radius r = z m_t / 2 [m] [iso21771]."""
    return 0.5 * teeth * transverse_module(module, helix_angle)


def base_radius(teeth: int, module: float, pressure_angle: float, helix_angle: float) -> float:
    """Base circle radius r_b = r cos alpha_t [m]; normal module [m] and normal pressure angle [rad] [iso21771]."""
    return reference_radius(teeth, module, helix_angle) * math.cos(
        transverse_pressure_angle(pressure_angle, helix_angle)
    )


def base_pitch(module: float, pressure_angle: float, helix_angle: float) -> float:
    """Transverse base pitch p_bt = pi m_t cos alpha_t [m] [iso21771]."""
    return (
        math.pi
        * transverse_module(module, helix_angle)
        * math.cos(transverse_pressure_angle(pressure_angle, helix_angle))
    )


def tip_radius(
    teeth: int,
    module: float,
    helix_angle: float,
    *,
    internal: bool = False,
    profile_shift: float = 0.0,
    addendum: float = 1.0,
) -> float:
    """Tip radius r +- m (h_a + x) [m], + external, - of a ring, without tip shortening [iso21771].

    profile_shift x, addendum h_a : coefficients per normal module [1].
    """
    height = module * (addendum + profile_shift)
    return reference_radius(teeth, module, helix_angle) + (-height if internal else height)


def root_radius(
    teeth: int,
    module: float,
    helix_angle: float,
    *,
    internal: bool = False,
    profile_shift: float = 0.0,
    dedendum: float = 1.25,
) -> float:
    """Root radius r -+ m (h_f - x) [m], - external, + of a ring [iso21771]; coefficients as of `tip_radius`."""
    depth = module * (dedendum - profile_shift)
    return reference_radius(teeth, module, helix_angle) + (depth if internal else -depth)


# a pair --------------------------------------------------------------------------------------------------------------


def reference_centre_distance(
    teeth_a: int, teeth_b: int, module: float, helix_angle: float, *, internal: bool = False
) -> float:
    """Centre distance without shift, (z_b +- z_a) m_t / 2 [m], - for a ring b [iso21771]."""
    return 0.5 * _teeth_sum(teeth_a, teeth_b, internal) * transverse_module(module, helix_angle)


def working_pressure_angle(
    teeth_a: int,
    teeth_b: int,
    pressure_angle: float,
    helix_angle: float,
    *,
    shift_a: float = 0.0,
    shift_b: float = 0.0,
    internal: bool = False,
) -> float:
    """Working transverse pressure angle of a pair without backlash from its profile shifts [rad]; nan if none exists.

    inv alpha_w = inv alpha_t +- 2 tan alpha_n (x_a + x_b)/(z_b +- z_a) [iso21771], lower signs for a ring b: its
    positive shift narrows the tooth spaces and draws the planet inward.  pressure_angle : normal [rad].
    """
    reference = transverse_pressure_angle(pressure_angle, helix_angle)
    change = 2.0 * math.tan(pressure_angle) * (shift_a + shift_b) / _teeth_sum(teeth_a, teeth_b, internal)
    if change == 0.0:
        return reference  # exactly, so that an unshifted pair works at its reference distance to the last digit
    value = involute(reference) + (-change if internal else change)
    return inverse_involute(value) if value >= 0.0 else math.nan


def centre_distance(
    teeth_a: int,
    teeth_b: int,
    module: float,
    helix_angle: float,
    *,
    pressure_angle: float,
    working_pressure_angle: float,
    internal: bool = False,
) -> float:
    """Centre distance at which a pair works at a given angle, a = a_0 cos alpha_t / cos alpha_w [m] [iso21771].

    pressure_angle : normal; working_pressure_angle : transverse [rad].
    """
    reference = reference_centre_distance(teeth_a, teeth_b, module, helix_angle, internal=internal)
    ratio = math.cos(transverse_pressure_angle(pressure_angle, helix_angle)) / math.cos(working_pressure_angle)
    return reference * ratio


def working_pressure_angle_at(
    centre_distance: float, base_radius_a: float, base_radius_b: float, *, internal: bool = False
) -> float:
    """Working transverse pressure angle at a centre distance, cos alpha_w = (r_bB +- r_bA)/a [rad] [iso21771].

    nan where the base circles leave no common tangent.
    """
    between = base_radius_b - base_radius_a if internal else base_radius_b + base_radius_a
    return math.acos(between / centre_distance) if 0.0 < between <= centre_distance else math.nan


def shift_sum(
    teeth_a: int,
    teeth_b: int,
    pressure_angle: float,
    helix_angle: float,
    *,
    working_pressure_angle: float,
    internal: bool = False,
) -> float:
    """Sum of the shifts x_a + x_b with which a pair works at a given angle without backlash [1] [iso21771].

    +-(z_b +- z_a)(inv alpha_w - inv alpha_t)/(2 tan alpha_n), lower signs for a ring b.  pressure_angle : normal;
    working_pressure_angle : transverse [rad].
    """
    change = involute(working_pressure_angle) - involute(transverse_pressure_angle(pressure_angle, helix_angle))
    total = _teeth_sum(teeth_a, teeth_b, internal) * change / (2.0 * math.tan(pressure_angle))
    return -total if internal else total


def contact_limits(
    base_radius_a: float,
    tip_radius_a: float,
    base_radius_b: float,
    tip_radius_b: float,
    *,
    working_pressure_angle: float,
    base_pitch: float,
    internal: bool = False,
) -> tuple[float, float]:
    """Ends (sigma_min, sigma_max) of the path of contact, from the pitch point [base pitches].

    The tip of a ends the path at sigma_max, the tip of b at sigma_min.  Radii and base pitch p_bt [m], working
    transverse pressure angle [rad].  A tip inside its base circle counts as lying on it.  Derived here from the line of
    action [iso21771].
    """
    far = _beyond_pitch_point(base_radius_a, tip_radius_a, working_pressure_angle) / base_pitch
    near = _beyond_pitch_point(base_radius_b, tip_radius_b, working_pressure_angle) / base_pitch
    return (near if internal else -near), far


def transverse_contact_ratio(limits: tuple[float, float]) -> float:
    """Transverse contact ratio eps_alpha = sigma_max - sigma_min [1] from `contact_limits` [iso21771]."""
    return limits[1] - limits[0]


def overlap_ratio(face_width: float, helix_angle: float, module: float) -> float:
    """Overlap ratio eps_beta = b sin|beta| / (pi m_n) [1] of one helix of width b [m] [iso21771]."""
    return face_width * math.sin(abs(helix_angle)) / (math.pi * module)


# clearances ----------------------------------------------------------------------------------------------------------


def radial_clearance(centre_distance: float, radius_a: float, radius_b: float, *, internal: bool = False) -> float:
    """Radial clearance of two circles at a centre distance [m]; negative where they overlap.

    External: a - r_a - r_b (tip against root of the mate, tips of neighbouring planets).
    ``internal``: circle a inside circle b, r_b - a - r_a (planet tip in ring root, planet root in ring tip).
    """
    return radius_b - centre_distance - radius_a if internal else centre_distance - radius_a - radius_b


def _teeth_sum(teeth_a: int, teeth_b: int, internal: bool) -> int:
    return teeth_b - teeth_a if internal else teeth_b + teeth_a


def _beyond_pitch_point(base: float, tip: float, working: float) -> float:
    """Distance along the line of action from the pitch point to the tip circle [m]; negative for a ring."""
    return math.sqrt(max(0.0, tip**2 - base**2)) - base * math.tan(working)


# phases --------------------------------------------------------------------------------------------------------------

QUARTER = Fraction(1, 4)
HALF = Fraction(1, 2)
SAME_ANGLE = 1e-12  # [rad] working and reference angle this close are one angle computed twice


@dataclass(frozen=True, slots=True)
class Phase:
    """A phase [pitches] or an angle [turns]: a rational part and an irrational rest.

    exact : rational part [1].  rest : irrational part [1]; 0.0 where the whole is rational.
    """

    exact: Fraction = Fraction(0)
    rest: float = 0.0

    @classmethod
    def of(cls, value: Angle) -> Phase:
        """A Phase of a Fraction or an integer (exact) or of a float (not)."""
        if isinstance(value, Phase):
            return value
        return cls(rest=value) if isinstance(value, float) else cls(Fraction(value))

    @property
    def value(self) -> Fraction | float:
        """The number itself, exact where it is rational."""
        return self.exact if self.rest == 0.0 else float(self.exact) + self.rest

    def __add__(self, other: Angle) -> Phase:
        """Sum; rational parts stay exact."""
        that = Phase.of(other)
        return Phase(self.exact + that.exact, self.rest + that.rest)

    def __sub__(self, other: Angle) -> Phase:
        """Difference; equal rests cancel to an exact number."""
        that = Phase.of(other)
        return Phase(self.exact - that.exact, self.rest - that.rest)

    def __neg__(self) -> Phase:
        """The opposite phase."""
        return Phase(-self.exact, -self.rest)

    def __mul__(self, factor: int | Fraction) -> Phase:
        """Scaled by a rational number."""
        return Phase(self.exact * factor, self.rest * float(factor))

    __rmul__ = __mul__

    def __mod__(self, period: int | Fraction) -> Phase:
        """The same phase with its value in [0, period)."""
        if self.rest == 0.0:
            return Phase(self.exact % period)
        turned = Phase(self.exact - period * math.floor(float(self.value) / float(period)), self.rest)
        # A rest smaller than the rounding of the sum must not leave the interval.
        return turned if 0.0 <= float(turned.value) < float(period) else Phase()

    def nearest(self, period: int | Fraction = 1) -> Phase:
        """The same phase with its value in [-period/2, period/2)."""
        half = Fraction(period) / 2
        return (self + half) % period - half


Angle = Phase | Fraction | int | float


def shift_term(
    *,
    teeth: int,
    profile_shift: float,
    normal_angle: float,
    transverse_angle: float,
    working_angle: float,
    internal: bool = False,
) -> float:
    """Phase c of a gear in one mesh from its profile shift and the working pressure angle of the mesh [pitches].

    normal_angle, transverse_angle : pressure angles of the tool [rad].  working_angle : transverse, of this mesh [rad].
    Exactly zero where there is no shift and both angles agree.  The terms of two gears in mesh without backlash cancel.
    """
    turn = 0.0
    if abs(transverse_angle - working_angle) > SAME_ANGLE:
        signed = -teeth if internal else teeth
        turn = signed * (involute(transverse_angle) - involute(working_angle)) / math.tau
    return profile_shift * math.tan(normal_angle) / math.pi + turn


def driver_tooth(place: Phase, direction: Phase, *, teeth: int, flank: int, shift: float = 0.0) -> Phase:
    """Tooth phase of gear A [pitches] from the place of its contact [base pitches].

    direction : P [turns].  flank : d.  shift : `shift_term` of A in this mesh [pitches].
    """
    return teeth * direction + flank * (place - QUARTER - shift)


def mate_tooth(
    place: Phase, direction: Phase, *, teeth: int, flank: int, shift: float = 0.0, internal: bool = False
) -> Phase:
    """Tooth phase of gear B [pitches] from the place of its contact [base pitches].

    direction : P [turns].  flank : d of the mesh.  shift : `shift_term` of B in this mesh [pitches].
    internal : B is a ring.
    """
    if internal:
        return teeth * direction + flank * (place + QUARTER + shift)
    return teeth * (direction + HALF) - flank * (place + QUARTER + shift)


ComplexArray = NDArray[np.complex128]

_RELATIVE = 1e-9  # a size of 0.05 m is 50 mm, whatever its rounding in binary digits

# grades of flanks ----------------------------------------------------------------------------------------------------

FLANK_GRADES = range(1, 12)
"""Grades (flank tolerance classes) of ISO 1328-1:2013."""

_DIAMETERS = (5e-3, 15.0)  # reference diameters that ISO 1328-1:2013 covers [m]
_MODULES = (0.5e-3, 70e-3)  # normal modules [m]


def in_flank_range(diameter: float, module: float) -> bool:
    """Whether ISO 1328-1:2013 covers a reference diameter and a normal module [m]."""
    return _DIAMETERS[0] <= diameter <= _DIAMETERS[1] and _MODULES[0] <= module <= _MODULES[1]


def run_out_width(diameter: float, module: float, grade: int) -> float:
    """Run-out tolerance F_rT [m], 0.9 F_pT, of a reference diameter and a normal module [m] [iso1328, annex]."""
    return _rounded(0.9 * _cumulative(diameter, module) * _step(grade))


def profile_width(diameter: float, module: float, grade: int) -> float:
    """Total profile tolerance F_alphaT [m] of a reference diameter and a normal module [m] [iso1328]."""
    slope = 0.4 * module * 1e3 + 1e-3 * diameter * 1e3 + 4
    form = 0.55 * module * 1e3 + 5
    return _rounded(math.hypot(slope, form) * _step(grade))


def _cumulative(diameter: float, module: float) -> float:
    """F_pT of grade 5 before rounding [um]."""
    d, m = diameter * 1e3, module * 1e3
    return 0.002 * d + 0.55 * math.sqrt(d) + 0.7 * m + 12


def _step(grade: int) -> float:
    """Ratio of a grade to grade 5; widths double every two grades. Raises ValueError for a grade that is none."""
    if grade not in FLANK_GRADES:
        raise ValueError(f"grade {grade} is none of 1 to 11")
    return math.sqrt(2.0) ** (grade - 5)


def _rounded(width: float) -> float:
    """Width [m] of one in um: above 10 um to whole ones, from 5 um to halves, below to tenths."""
    step = 1.0 if width > 10 else 0.5 if width >= 5 else 0.1
    # a half is rounded up, as on paper, also one that binary digits have just below it
    return math.floor(width / step + 0.5 + _RELATIVE) * step * 1e-6


# grades of sizes -----------------------------------------------------------------------------------------------------

SIZE_GRADES = range(5, 12)
"""Grades IT5 to IT11 of ISO 286-1."""

# upper end of each step of sizes [mm], the lower one excluded, and IT5 to IT11 there [um]; ISO 286-1:2010, table 1
_SIZES: dict[float, tuple[int, ...]] = {
    3: (4, 6, 10, 14, 25, 40, 60),
    6: (5, 8, 12, 18, 30, 48, 75),
    10: (6, 9, 15, 22, 36, 58, 90),
    18: (8, 11, 18, 27, 43, 70, 110),
    30: (9, 13, 21, 33, 52, 84, 130),
    50: (11, 16, 25, 39, 62, 100, 160),
    80: (13, 19, 30, 46, 74, 120, 190),
    120: (15, 22, 35, 54, 87, 140, 220),
    180: (18, 25, 40, 63, 100, 160, 250),
    250: (20, 29, 46, 72, 115, 185, 290),
    315: (23, 32, 52, 81, 130, 210, 320),
    400: (25, 36, 57, 89, 140, 230, 360),
    500: (27, 40, 63, 97, 155, 250, 400),
    630: (32, 44, 70, 110, 175, 280, 440),
    800: (36, 50, 80, 125, 200, 320, 500),
    1000: (40, 56, 90, 140, 230, 360, 560),
    1250: (47, 66, 105, 165, 260, 420, 660),
    1600: (55, 78, 125, 195, 310, 500, 780),
    2000: (65, 92, 150, 230, 370, 600, 920),
    2500: (78, 110, 175, 280, 440, 700, 1100),
    3150: (96, 135, 210, 330, 540, 860, 1350),
}
_ENDS = tuple(_SIZES)


def size_width(size: float, grade: int) -> float:
    """Standard tolerance ITn [m] of a nominal size [m] [iso286].

    Raises ValueError for a grade other than 5 to 11, and for a size that is not above 0 and at most 3150 mm.
    """
    millimetres = size * 1e3
    if grade not in SIZE_GRADES:
        raise ValueError(f"grade IT{grade} is none of IT5 to IT11")
    if not 0 < millimetres <= _ENDS[-1] * (1 + _RELATIVE):
        raise ValueError(f"{millimetres:.6g} mm is no size of ISO 286-1, which ends at {_ENDS[-1]} mm")
    end = _ENDS[bisect_left(_ENDS, millimetres * (1 - _RELATIVE))]
    return _SIZES[end][grade - SIZE_GRADES.start] * 1e-6


# spectral lines of deviations ----------------------------------------------------------------------------------------


def profile_amplitude(
    amplitude: float,
    order: int,
    phase: float | Literal["identical"] = "identical",
    *,
    lead: Fraction | float = 0,
) -> complex:
    """Complex amplitude of the profile error of one mesh at `order` times its mesh frequency [m].

    phase : ``identical`` for teeth that are all alike, e = E cos(2 pi l sigma) with sigma = +-(f t + lead)
    (docs/conventions.md, Phases): the error follows the phase of its mesh, and the cosine is even in the sense.
    A number [rad] gives e = E cos(2 pi l f t + phase) at any mesh phase (given angles, or those of `random_phases`).

    amplitude E [m].  order : l >= 1.  lead : [mesh cycles], exact where rational.
    """
    if phase == "identical":
        return amplitude * mesh_phasor(order, lead)
    return complex(amplitude * np.exp(1j * phase))


def mesh_phasor(order: int, lead: Fraction | float) -> complex:
    """Phasor exp(2 pi i order lead) [1], whole cycles removed before rounding; lead [mesh cycles]."""
    return complex(np.exp(2j * np.pi * float(order * lead % 1)))


def random_phases(count: int, seed: int) -> Array:
    """Phases (count,) uniform in [0, 2 pi) [rad], one a mesh, reproducible by the seed."""
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, count)


def tooth_phase(teeth: int, mesh_direction: float, gear_angle: float) -> float:
    """Tooth phase tau of a gear at a mesh [pitches]: integer k where tooth k + 1 carries at the pitch point.

    Teeth are numbered counter-clockwise as seen from the right end.  The loaded flank of tooth 1 crosses the x axis of
    the body.  mesh_direction : polar angle of the pitch point from the centre of the gear [rad].  gear_angle : polar
    angle of the x axis of the gear [rad].  With gear_angle = g0 + w t the tooth phase is
    tooth_phase(z, direction, g0) - z w t / 2 pi.  Derived here.
    """
    return teeth * (mesh_direction - gear_angle) / (2.0 * np.pi)


def pitch_lines(
    deviations: Sequence[float] | Array, *, highest_order: int | None = None
) -> tuple[NDArray[np.int64], ComplexArray]:
    """Shaft orders j (J,) and amplitudes c_j (J,) [m] of the gap that measured pitch deviations of a gear leave.

    e(tau) = Re sum_j c_j exp(2 pi i j tau / z) has the period of z pitches.  It equals deviation k + 1 at tau = k and
    is linear from tooth to tooth: the error of a mesh is the mean of the tooth pairs in contact weighted by their share
    of the load, and the hat function 1 - |tau - k| stands for that share.  Hence c_j = (2/z) DFT_j sinc^2(j/z), c_0 is
    the mean, and orders that are multiples of z (the mesh frequency) vanish.  Derived here.

    deviations : (z,) cumulative, tooth 1 first, positive = material missing on the driven flank [m].
    highest_order : default z - 1, all below the mesh frequency; each order above is at most a twentieth of the
    deviation.  The caller inserts tau(t) = tau_0 + rate t of `tooth_phase`.
    """
    samples = np.asarray(deviations, dtype=float)
    teeth = samples.size
    order = np.arange(0, teeth if highest_order is None else highest_order + 1)
    weight = np.sinc(order / teeth) ** 2 * np.where(order == 0, 1.0, 2.0) / teeth
    return order, np.asarray(weight * np.fft.fft(samples)[order % teeth], dtype=np.complex128)
