"""Grades of standards: widths of the tolerances of a gear (ISO 1328-1:2013) and of a size (ISO 286-1:2010).

ISO 1328-1:2013 states formulas, here with its rounding; the tolerances of ISO 286-1 are the values of its table, which
its formulas i = 0.45 D^(1/3) + 0.001 D meet but for a few old preferred numbers.
"""

from __future__ import annotations

import math
from bisect import bisect_left

__all__ = [
    "FLANK_GRADES",
    "SIZE_GRADES",
    "cumulative_pitch_width",
    "helix_width",
    "in_flank_range",
    "profile_width",
    "run_out_width",
    "single_pitch_width",
    "size_width",
]

_RELATIVE = 1e-9  # a size of 0.05 m is 50 mm, whatever its rounding in binary digits

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
