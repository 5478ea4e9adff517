"""Mesh stiffness of one pair of gears: Fourier series, ISO 6336-1, the teeth as drawn, tables and curves of force.

A variation over a mesh cycle is a relative Fourier series, complex coefficients v_l (L,) over the place sigma of the
contact.  sigma counts base pitches from the pitch point at mid-face and has the period 1 (docs/conventions.md, Phases):

    value(sigma) = mean (1 + Re sum_l v_l exp(2 pi i l sigma)),    l = 1 .. L.

The mean value is that of ISO 6336-1 [iso6336], or of tooth contact.  Of the latter a train holds data alone: the teeth
of one pair as drawn, `ToothPair`, and the table of their force, `ContactTable`.

A measured or computed curve of force over deflection is zero up to first touch, then a monotone cubic through its
points [fritsch1980]; behind the last point it goes on along its last tangent.  Two points give a straight line,
exactly.  Curves at several phases make a table.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from ..warning_codes import CodedText, coded
from .form import PLAIN, Flank, GearForm
from .path_of_contact import Array, PlaneOfAction

ComplexArray = NDArray[np.complex128]

# Orders kept by default.  A spur series falls as 1/l only, so no number makes the rest negligible: 12 orders hold 95 %
# of the variance of a spur mesh (what is dropped has an RMS of 5 .. 8 % of the mean stiffness, above the modes that
# matter in a usual sweep); from an overlap ratio of 0.25 on the dropped part is below 0.4 % of the mean.
DEFAULT_HARMONICS = 12

# Least last slope per last secant: the three-point slope of data that flatten may be zero, and a law that goes on along
# a last tangent of zero holds no load more.
_LAST = 0.5
# Force of a table at common loads less that of the curves it is made from, per largest force, at the probes: below
# 1e-4 everywhere, less than any measurement.
_ACCURACY = 5e-5
# Loads of a table to begin with: as many as of tabulated tooth contact.
_LOADS = 20
# Forces nearer to each other than this part of the largest are one load: rounding of one number.
_SAME = 1e-12
# Forces up to this part of the last one are no touch: what an FE run returns of teeth apart.
_APART = 1e-9
# Series and errors below this part are rounding of a straight line.
_ROUNDING = 1e-12
# Newton steps or halvings until a place in a cell is found to rounding.
_SEARCH, _PLACE = 60, 1e-14
# Places within a cell at which a table is compared with its curves.
_PROBES = np.array([0.1, 0.3, 0.5, 0.7, 0.9])


# Fourier series over a mesh cycle ------------------------------------------------------------------------------------


def fourier_series(cosine: Sequence[float], sine: Sequence[float] = ()) -> ComplexArray:
    """Coefficients v_l = a_l - i b_l (L,) of sum_l a_l cos(2 pi l sigma) + b_l sin(2 pi l sigma) [1].

    cosine, sine : relative to the mean, from l = 1; the shorter is padded with zeros.
    """
    series = np.zeros(max(len(cosine), len(sine)), dtype=np.complex128)
    series[: len(cosine)] += np.asarray(cosine, dtype=float)
    series[: len(sine)] -= 1j * np.asarray(sine, dtype=float)
    return series


def table_series(values: Sequence[float] | Array) -> tuple[float, ComplexArray]:
    """Mean of equally spaced samples over one mesh cycle, and their relative Fourier coefficients.

    values : (n,) at sigma = 0, 1/n, ... (the end of the cycle is not repeated).  Returns the mean [unit of values]
    and v (n//2,) [1] of the interpolating trigonometric polynomial.

    Raises
    ------
    ModelError : no samples, or a mean that is not positive.
    """
    samples = np.asarray(values, dtype=float)
    if samples.size == 0 or not samples.mean() > 0.0:
        raise ModelError("a table over one mesh cycle needs a positive mean", given=list(samples))
    spectrum = np.fft.rfft(samples) / samples.size
    mean, series = float(spectrum[0].real), 2.0 * spectrum[1:]
    if samples.size % 2 == 0:
        series[-1] *= 0.5  # the highest order of an even table has no partner at the negative side
    return mean, np.asarray(series / mean, dtype=np.complex128)


def evaluate_series(coefficients: ArrayLike, sigma: ArrayLike) -> Array:
    """Value 1 + Re sum_l v_l exp(2 pi i l sigma) [1] of coefficients (L,) at sigma (...) [base pitches]."""
    series = np.asarray(coefficients, dtype=np.complex128)
    angle = 2j * np.pi * np.asarray(sigma, dtype=float)[..., np.newaxis] * np.arange(1, series.size + 1)
    return np.asarray(1.0 + (np.exp(angle) @ series).real)


def series_in_time(coefficients: ArrayLike, *, lead: Fraction | float, sense: int) -> ComplexArray:
    """Coefficients w_l (L,) over time, value = mean (1 + Re sum_l w_l exp(2 pi i l f t)) [1].

    With sigma = sense (f t + lead) (docs/conventions.md, Phases), w_l = v_l exp(2 pi i l lead), v_l conjugated where
    sense is -1.  coefficients : (L,) over sigma.  lead : [mesh cycles], exact where rational.  sense : D = +1 or -1.
    """
    series = np.asarray(coefficients, dtype=np.complex128)
    orders = range(1, series.size + 1)
    if isinstance(lead, Fraction):  # integers: fractions reduce what is divided here once
        numerator, denominator = lead.numerator, lead.denominator
        cycles = [order * numerator % denominator / denominator for order in orders]
    else:
        cycles = [order * lead % 1 for order in orders]
    return np.asarray((series if sense > 0 else series.conj()) * np.exp(2j * np.pi * np.array(cycles)))


# mean value, ISO 6336-1 ----------------------------------------------------------------------------------------------

STEEL_MODULUS = 206e9  # Young's modulus of the steel the coefficients below were fitted for [Pa]

# q' [mm um / N] = C1 + C2/z_n1 + C3/z_n2 + C4 x1 + C5 x1/z_n1 + C6 x2 + C7 x2/z_n2 + C8 x1^2 + C9 x2^2
# [iso6336, method B: minimum flexibility of a tooth pair].  Limits of validity: LIMITS.
_FLEXIBILITY = (0.04723, 0.15551, 0.25791, -0.00635, -0.11654, -0.00193, -0.24188, 0.00529, 0.00182)
_CORRECTION = 0.8  # C_M, from theory to measured solid discs
_PER_WIDTH = 1e9  # 1 N/(mm um) = 1e9 N/m per metre of width


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """Range of validity of a formula: lowest <= quantity <= highest; unit and source for the message."""

    quantity: str
    lowest: float
    highest: float
    source: str
    unit: str = ""


LIMITS: tuple[Limit, ...] = (
    Limit(quantity="sum of profile shifts", lowest=-0.5, highest=2.0, source="ISO 6336-1, c' of method B"),
    Limit(quantity="profile shift x1 - x2", lowest=0.0, highest=math.inf, source="ISO 6336-1, c' of method B"),
    Limit(quantity="helix angle", lowest=0.0, highest=30.0, unit="deg", source="ISO 6336-1, c_gamma"),
    Limit(quantity="transverse contact ratio", lowest=1.2, highest=math.inf, source="ISO 6336-1, c_gamma"),
    # Steel pairs lie between 10 and 25 N/(mm um); a value far outside is rather a wrong unit than a soft tooth.
    Limit(
        quantity="mesh stiffness per width",
        lowest=5.0,
        highest=50.0,
        unit="N/(mm um)",
        source="steel teeth, ISO 6336-1",
    ),
)


def outside_limits(values: Mapping[str, float]) -> tuple[CodedText, ...]:
    """Warnings for values outside `LIMITS`.

    values : name of the quantity in `LIMITS` -> value in the unit there; nan is not compared.
    """
    slack = 1e-9  # a sum of shifts typed as decimals may miss a limit by rounding
    return tuple(
        coded(
            "formula-outside-limits",
            f"{limit.quantity} {values[limit.quantity]:.4g} {limit.unit}".rstrip()
            + f" is outside {limit.lowest:g} .. {limit.highest:g} ({limit.source})",
        )
        for limit in LIMITS
        if limit.quantity in values
        and (values[limit.quantity] < limit.lowest - slack or values[limit.quantity] > limit.highest + slack)
    )


def iso6336_single_stiffness(
    teeth_a: int,
    teeth_b: int,
    pressure_angle: float,
    helix_angle: float,
    *,
    internal: bool = False,
    shift_a: float = 0.0,
    shift_b: float = 0.0,
    dedendum_a: float = 1.25,
    dedendum_b: float = 1.25,
    youngs_modulus_a: float = STEEL_MODULUS,
    youngs_modulus_b: float = STEEL_MODULUS,
) -> tuple[float, tuple[CodedText, ...]]:
    """Single stiffness c' of a tooth pair per face width, transverse [N/m^2], with warnings outside its limits.

    c' = C_M C_R C_B cos beta / q', C_M = 0.8, C_R = 1 (solid), z_n = z/(cos^2 beta_b cos beta), ring z_n = inf
    [iso6336].  Gear a has the index 1: the pinion of the standard, the gear nearer the sun of docs/conventions.md.
    Loads above 100 N per mm of face width are assumed.

    pressure_angle : normal [rad]; helix_angle [rad]; shift_*, dedendum_* (basic rack) : coefficients [1];
    youngs_modulus_* [Pa], scaled by 2 E_a E_b/(E_a + E_b) over that of steel.
    """
    beta = abs(helix_angle)
    squared = 1.0 - (math.sin(beta) * math.cos(pressure_angle)) ** 2  # cos^2 beta_b
    per_tooth_a = squared * math.cos(beta) / teeth_a
    per_tooth_b = 0.0 if internal else squared * math.cos(beta) / teeth_b
    flexibility = _flexibility(per_tooth_a, per_tooth_b, shift_a, shift_b)
    rack = 0.5 * (_rack_factor(dedendum_a, pressure_angle) + _rack_factor(dedendum_b, pressure_angle))
    modulus = 2.0 * youngs_modulus_a * youngs_modulus_b / (youngs_modulus_a + youngs_modulus_b) / STEEL_MODULUS
    stiffness = _PER_WIDTH * _CORRECTION * rack * modulus * math.cos(beta) / flexibility
    values = {
        "sum of profile shifts": shift_a + shift_b,
        # the standard numbers the pinion 1; a ring has no such order
        "profile shift x1 - x2": math.nan if internal else shift_a - shift_b,
        "helix angle": math.degrees(beta),
    }
    return stiffness, outside_limits(values)


def iso6336_mesh_stiffness(single_stiffness: float, contact_ratio: float) -> tuple[float, tuple[CodedText, ...]]:
    """Mean mesh stiffness c_gamma_alpha = c' (0.75 eps_alpha + 0.25) per face width [N/m^2], with warnings [iso6336].

    single_stiffness : c' [N/m^2].  contact_ratio : transverse [1].  In the transverse plane: see
    `normal_from_transverse`.
    """
    mean = single_stiffness * (0.75 * contact_ratio + 0.25)
    return mean, outside_limits({"transverse contact ratio": contact_ratio})


def normal_from_transverse(stiffness: float, base_helix_angle: float) -> float:
    """Stiffness along the tooth normal from that in the transverse plane, k = k_t / cos^2 beta_b [same unit].

    docs/conventions.md, Forces, stiffness, errors.  base_helix_angle : beta_b [rad].
    """
    return stiffness / math.cos(base_helix_angle) ** 2


def _flexibility(per_tooth_1: float, per_tooth_2: float, x1: float, x2: float) -> float:
    """Minimum flexibility q' of a tooth pair [mm um / N] [iso6336]; per_tooth : 1/z_n [1], x : profile shifts [1]."""
    terms = (1.0, per_tooth_1, per_tooth_2, x1, x1 * per_tooth_1, x2, x2 * per_tooth_2, x1**2, x2**2)
    return math.fsum(c * term for c, term in zip(_FLEXIBILITY, terms, strict=True))


def _rack_factor(dedendum: float, pressure_angle: float) -> float:
    """Basic rack factor C_B of one gear [1] [iso6336]; a pair has the mean of both."""
    return (1.0 + 0.5 * (1.2 - dedendum)) * (1.0 - 0.02 * (20.0 - math.degrees(pressure_angle)))


# variation over a mesh cycle -----------------------------------------------------------------------------------------


def contact_line_series(
    limits: tuple[float, float], overlap_ratio: float, *, harmonics: int = DEFAULT_HARMONICS
) -> ComplexArray:
    """Relative series v_l (L,) [1] of a mesh stiffness proportional to the length of the contact lines [maatar1996].

    One pair is in contact over a window of width eps_alpha centred between the limits.  A helical face convolves it
    with a window of width eps_beta centred on mid-face: v_l = 2 sinc(l eps_alpha) sinc(l eps_beta)
    exp(-2 pi i l centre).  The mean length is eps_alpha b / cos beta_b.

    limits : (sigma_min, sigma_max) of `geometry.contact_limits`; overlap_ratio [1], 0 for spur teeth.
    """
    order = np.arange(1, harmonics + 1)
    size = 2.0 * np.sinc(order * (limits[1] - limits[0]))
    return face_average(size * np.exp(-1j * np.pi * order * (limits[0] + limits[1])), overlap_ratio)


def face_average(series: ComplexArray, overlap_ratio: float) -> ComplexArray:
    """Series (L,) [1] averaged over a helical face from that of a narrow slice, v_l sinc(l eps_beta) [maatar1996]."""
    order = np.arange(1, np.size(series) + 1)
    return np.asarray(series * np.sinc(order * overlap_ratio), dtype=np.complex128)


# tooth contact as data of a train ------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothPair:
    """Teeth of one mesh of one helix, as tooth contact needs them.

    form_a, form_b : form of teeth and body of the gears.  base_a, base_b : base radii of the teeth themselves [m].
    pressure_angle : working transverse pressure angle of the teeth [rad].  base_pitch : transverse [m].
    limits : (sigma_min, sigma_max) of the path of contact [base pitches].
    face_a, face_b : ends (left, right) of the faces along the axis, from the station of the mesh [m].
    flank_a, flank_b : micro-geometry.  paths : of both flanks in the model file.
    """

    form_a: GearForm
    form_b: GearForm
    base_a: float
    base_b: float
    pressure_angle: float
    base_pitch: float
    limits: tuple[float, float]
    face_a: tuple[float, float]
    face_b: tuple[float, float]
    flank_a: Flank = PLAIN
    flank_b: Flank = PLAIN
    paths: tuple[str, str] = ("", "")

    def plane(
        self, *, base_helix: float = 0.0, lean: int = 0, slides: tuple[float, float] = (0.0, 0.0)
    ) -> PlaneOfAction:
        """Plane of action, as of `PlaneOfAction`; slides : axial offsets of both gears [m]."""
        return PlaneOfAction(
            base_a=self.base_a,
            base_b=self.base_b,
            internal=self.form_b.internal,
            pressure_angle=self.pressure_angle,
            base_helix=base_helix,
            base_pitch=self.base_pitch,
            limits=self.limits,
            lean=lean,
            face_a=(self.face_a[0] + slides[0], self.face_a[1] + slides[0]),
            face_b=(self.face_b[0] + slides[1], self.face_b[1] + slides[1]),
        )

    def __repr__(self) -> str:
        """One line: teeth and contact ratio."""
        ring = " ring" if self.form_b.internal else ""
        ratio = self.limits[1] - self.limits[0]
        return f"ToothPair({self.form_a.teeth}/{self.form_b.teeth}{ring}, contact ratio {ratio:.4g})"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactTable:
    """Tabulated contact of a helix at S phases of a mesh cycle and L loads, the first of them zero.

    load : operating load [N].  stiffness : mean tangent stiffness there [N/m].  variation : (H,) relative series
    of the tangent over sigma [1].  error : complex one-sided amplitudes of the error e over sigma, at most H orders,
    the mean first [m].  force : (L,) [N].  gap : (S, L) d - e at sigma = 0, 1/S, ... [m]; the first column is first
    touch.  slope : (S, L) dF/dd [N/m].  last : force up to which all phases have data, where less than the largest [N].
    """

    load: float
    stiffness: float
    variation: ComplexArray
    error: ComplexArray
    force: Array
    gap: Array
    slope: Array
    last: float = np.inf

    @property
    def approach(self) -> Array:
        """d (S, L) [m]: the gap without the error of the linear model taken off."""
        return np.asarray(self.gap + error_samples(self.error, len(self.gap)))

    def __repr__(self) -> str:
        """One line: size of the table, operating load and mean tangent."""
        phases, loads = self.gap.shape
        return f"ContactTable({phases} phases x {loads} loads, {self.load:.4g} N, {self.stiffness:.4g} N/m)"


def error_samples(error: ComplexArray, samples: int) -> Array:
    """Error e (S, 1) [m] at S places sigma = 0, 1/S, ..., of its one-sided amplitudes [m], the mean first."""
    wave = np.exp(2j * np.pi * np.outer(np.arange(samples) / samples, np.arange(len(error))))
    return np.asarray((wave @ error).real[:, None])


# curves of force over deflection -------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceCurve:
    """Force over deflection from first touch on.

    deflection : (L,) rising, of first touch first [m, rad].  force : (L,) rising, 0 first [N, N m].
    slope : (L,) there [N/m, N m/rad].
    """

    deflection: tuple[float, ...]
    force: tuple[float, ...]
    slope: tuple[float, ...]

    def __repr__(self) -> str:
        """One line: points, last deflection and force."""
        return f"ForceCurve({len(self.force)} points up to {self.deflection[-1]:.4g}, {self.force[-1]:.4g})"

    @property
    def stiffness(self) -> float:
        """Slope at half of the last force [N/m, N m/rad]."""
        return float(self.inverse([self.force[-1] / 2])[1][0])

    def scaled(self, *, deflection: float = 1.0, force: float = 1.0) -> ForceCurve:
        """The curve with deflections and forces times two factors above zero."""
        return ForceCurve(
            deflection=tuple(value * deflection for value in self.deflection),
            force=tuple(value * force for value in self.force),
            slope=tuple(value * (force / deflection) for value in self.slope),
        )

    def at(self, deflection: Array) -> Array:
        """Force [N, N m] at deflections (...) [m, rad]."""
        x, f, k = (np.array(values) for values in (self.deflection, self.force, self.slope))
        cell = np.clip(np.searchsorted(x, deflection, side="right") - 1, 0, len(x) - 2)
        h = x[cell + 1] - x[cell]
        t = np.clip((deflection - x[cell]) / h, 0.0, 1.0)
        force = _cubic((f[cell], f[cell + 1]), (k[cell], k[cell + 1]), h, t)[0]
        return np.asarray(force + k[-1] * np.maximum(deflection - x[-1], 0.0))

    def inverse(self, force: ArrayLike) -> tuple[Array, Array]:
        """Deflection [m, rad] and slope [N/m, N m/rad] at forces (P,) from 0 up, each (P,)."""
        forces = np.asarray(force, dtype=float)
        x, f, k = (np.array(values) for values in (self.deflection, self.force, self.slope))
        cell = np.clip(np.searchsorted(f, forces, side="right") - 1, 0, len(f) - 2)
        h, f0, f1, k0, k1 = x[cell + 1] - x[cell], f[cell], f[cell + 1], k[cell], k[cell + 1]
        low, high = np.zeros_like(forces), np.ones_like(forces)
        t = np.clip((forces - f0) / (f1 - f0), 0.0, 1.0)
        for _ in range(_SEARCH):
            value, rate = _cubic((f0, f1), (k0, k1), h, t)
            low, high = np.where(value < forces, t, low), np.where(value < forces, high, t)
            trial = t - (value - forces) / np.where(rate > 0, h * rate, 1.0)
            trial = np.where((rate > 0) & (trial >= low) & (trial <= high), trial, (low + high) / 2)
            change, t = np.abs(trial - t).max(initial=0.0), trial
            if change <= _PLACE:
                break
        t = np.where(forces <= f0, 0.0, np.where(forces >= f1, 1.0, t))
        slope = np.where(forces >= f[-1], k[-1], _cubic((f0, f1), (k0, k1), h, t)[1])
        return x[cell] + t * h + np.maximum(forces - f[-1], 0.0) / k[-1], slope


def force_curve(deflection: Sequence[float], force: Sequence[float]) -> ForceCurve:
    """Curve through points whose forces are zero at first and rise from the last zero on.

    Parameters
    ----------
    deflection : (L,) rising [m, rad].  force : (L,) [N, N m].
    """
    from scipy.interpolate import PchipInterpolator  # half a second, for tables alone

    touch = sum(value <= _APART * force[-1] for value in force) - 1
    x, f = np.array(deflection[touch:], dtype=float), np.array((0.0, *force[touch + 1 :]))
    slope = PchipInterpolator(x, f).derivative()(x)
    slope[-1] = max(slope[-1], _LAST * (f[-1] - f[-2]) / (x[-1] - x[-2]))
    return ForceCurve(deflection=tuple(x.tolist()), force=tuple(f.tolist()), slope=tuple(slope.tolist()))


@lru_cache(maxsize=64)
def given_table(curves: tuple[ForceCurve, ...], load: float) -> ContactTable:
    """Table of a mesh from its curves at S phases sigma = 0, 1/S, ... of the mesh cycle; kept, as sides share it.

    The tangent at the load and the error e = d - F/k that belongs to it are those of `loaded_contact`.

    Parameters
    ----------
    load : operating load [N].
    """
    places, tangents = np.array([curve.inverse([load]) for curve in curves])[:, :, 0].T
    mean, series = table_series(tangents)
    series = np.where(np.abs(series) > _ROUNDING, series, 0.0)[: DEFAULT_HARMONICS if np.any(series) else 0]
    sigma = np.arange(len(curves)) / len(curves)
    # a truncated series may dip below the least of the tangents it is made of
    linear = mean * np.maximum(evaluate_series(series, sigma), tangents.min() / mean)
    rest = places - load / linear
    rest = np.where(np.abs(rest) > _ROUNDING * places.max(), rest, 0.0)
    count = min(len(series), (len(curves) - 1) // 2)
    error = 2 * np.fft.rfft(rest)[: count + 1] / len(curves)
    error[0] /= 2
    forces = _common_forces(curves, load)
    gap, slope = (np.array(values) for values in zip(*(curve.inverse(forces) for curve in curves), strict=True))
    return ContactTable(
        load=load,
        stiffness=mean,
        variation=series,
        error=error,
        force=forces,
        gap=gap - error_samples(error, len(curves)),
        slope=slope,
        last=min(curve.force[-1] for curve in curves),
    )


def _common_forces(curves: Sequence[ForceCurve], load: float) -> Array:
    """Loads (L,) [N] at which all curves together make a table; forces between them are right to `_ACCURACY`.

    load : operating load [N], one of them, unless all curves have the same forces.

    A cubic cut at a load stays itself, so that all forces of all curves make an exact table; a few of them to begin
    with, and then one more in every cell that misses a curve.
    """
    if all(curve.force == curves[0].force for curve in curves):
        return np.array(curves[0].force)
    forces = np.concatenate([curve.force for curve in curves])
    every: Array = np.unique([*forces, min(load, forces.max())])
    every = every[np.concatenate([[True], np.diff(every) > _SAME * every[-1]])]
    first = np.linspace(0, len(every) - 1, _LOADS + 1).astype(int)
    chosen = np.unique([*first, np.argmin(np.abs(every - load))])
    while True:
        missed = np.max([_deviations(curve, every[chosen]) for curve in curves], axis=0)
        wide = (missed > _ACCURACY * every[-1]) & (np.diff(chosen) > 1)
        if not wide.any():
            return np.asarray(every[chosen])
        chosen = np.unique(np.concatenate([chosen, ((chosen[:-1] + chosen[1:]) // 2)[wide]]))


def _deviations(curve: ForceCurve, forces: Array) -> Array:
    """Largest force (L - 1,) [N] by which cubics between loads (L,) miss a curve whose points they have."""
    x, k = curve.inverse(forces)
    h = np.diff(x)
    probed = _cubic((forces[:-1], forces[1:]), (k[:-1], k[1:]), h, _PROBES[:, None])[0]
    return np.asarray(np.abs(probed - curve.at(x[:-1] + _PROBES[:, None] * h)).max(axis=0))


def _cubic(force: tuple[Array, Array], slope: tuple[Array, Array], width: Array, t: Array) -> tuple[Array, Array]:
    """Force [N] and slope [N/m] at the place t (0 .. 1) of a cell, from those at both ends of it."""
    (f0, f1), (k0, k1) = force, slope
    rest = 1 - t
    value = f0 * (1 + 2 * t) * rest**2 + f1 * t**2 * (3 - 2 * t) + width * (k0 * t * rest**2 - k1 * t**2 * rest)
    rate = 6 * t * rest * (f1 - f0) / width + k0 * rest * (1 - 3 * t) + k1 * t * (3 * t - 2)
    return value, rate
