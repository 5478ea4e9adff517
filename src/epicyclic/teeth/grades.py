"""Grades of tolerances of a gear (ISO 1328-1:2013) and of a size (ISO 286-1:2010), and spectral lines of deviations.

ISO 1328-1:2013 states formulas, here with its rounding; the tolerances of ISO 286-1 are the values of its table, which
its formulas i = 0.45 D^(1/3) + 0.001 D meet but for a few old preferred numbers.

A spectral line of a profile or pitch deviation is Re(amplitude exp(2 pi i f t)).  A positive deviation is missing
material and opens the gap (docs/conventions.md, Forces, stiffness, errors).
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .mesh_stiffness import mesh_phasor

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_RELATIVE = 1e-9  # a size of 0.05 m is 50 mm, whatever its rounding in binary digits

# flanks --------------------------------------------------------------------------------------------------------------

FLANK_GRADES = range(1, 12)
"""Grades (flank tolerance classes) of ISO 1328-1:2013."""

_DIAMETERS = (5e-3, 15.0)  # reference diameters that ISO 1328-1:2013 covers [m]
_MODULES = (0.5e-3, 70e-3)  # normal modules [m]
_FACE_WIDTHS = (4e-3, 1.2)  # face widths [m]


def in_flank_range(diameter: float, module: float, face_width: float | None = None) -> bool:
    """Whether ISO 1328-1:2013 covers a reference diameter, a normal module and a face width [m], None = not used."""
    pairs = [(diameter, _DIAMETERS), (module, _MODULES)]
    pairs += [] if face_width is None else [(face_width, _FACE_WIDTHS)]
    return all(low <= value <= high for value, (low, high) in pairs)


def single_pitch_width(diameter: float, module: float, grade: int) -> float:
    """Single pitch tolerance f_pT [m] of a reference diameter and a normal module [m] [iso1328]."""
    return _rounded((1e-3 * diameter * 1e3 + 0.4 * module * 1e3 + 5) * _step(grade))


def cumulative_pitch_width(diameter: float, module: float, grade: int) -> float:
    """Total cumulative pitch tolerance F_pT [m] of a reference diameter and a normal module [m] [iso1328]."""
    return _rounded(_cumulative(diameter, module) * _step(grade))


def run_out_width(diameter: float, module: float, grade: int) -> float:
    """Run-out tolerance F_rT [m], 0.9 F_pT, of a reference diameter and a normal module [m] [iso1328, annex]."""
    return _rounded(0.9 * _cumulative(diameter, module) * _step(grade))


def profile_width(diameter: float, module: float, grade: int) -> float:
    """Total profile tolerance F_alphaT [m] of a reference diameter and a normal module [m] [iso1328]."""
    slope = 0.4 * module * 1e3 + 1e-3 * diameter * 1e3 + 4
    form = 0.55 * module * 1e3 + 5
    return _rounded(math.hypot(slope, form) * _step(grade))


def helix_width(diameter: float, face_width: float, grade: int) -> float:
    """Total helix tolerance F_betaT [m] of a reference diameter and a face width [m] [iso1328]."""
    root_d, root_b = math.sqrt(diameter * 1e3), math.sqrt(face_width * 1e3)
    slope = 0.05 * root_d + 0.35 * root_b + 4
    form = 0.07 * root_d + 0.45 * root_b + 4
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


# sizes ---------------------------------------------------------------------------------------------------------------

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
