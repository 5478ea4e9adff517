"""Widths of grades: worked by hand, and ISO 286 by its formulas as a second route."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from epicyclic.teeth.geometry import (
    FLANK_GRADES,
    SIZE_GRADES,
    in_flank_range,
    profile_width,
    run_out_width,
    size_width,
)

UM = 1e-6


@pytest.mark.parametrize(
    ("width", "grade", "expected"),
    # d = 100 mm, m_n = 4 mm, before rounding: F_r 18.45, F_alpha 9.183
    [
        (run_out_width(0.1, 0.004, 5), 5, 18),
        (run_out_width(0.1, 0.004, 6), 6, 26),  # 26.09
        (profile_width(0.1, 0.004, 5), 5, 9.0),  # 9.18
        (profile_width(0.1, 0.004, 6), 6, 13),  # 12.99
        (profile_width(0.1, 0.004, 1), 1, 2.3),  # 2.296 to tenths
        (profile_width(0.1, 0.004, 4), 4, 6.5),  # 6.494 to halves
    ],
)
def test_flank_tolerances_by_hand(width: float, grade: int, expected: float) -> None:
    assert grade in FLANK_GRADES
    assert width == pytest.approx(expected * UM, rel=1e-9)


def test_flank_tolerances_double_every_two_grades() -> None:
    for fine, coarse in ((5, 7), (7, 9), (9, 11)):
        for width in (run_out_width, profile_width):
            ratio = width(0.6, 0.02, coarse) / width(0.6, 0.02, fine)
            assert ratio == pytest.approx(2, abs=0.06)  # both are rounded to whole um


def test_beyond_the_standard() -> None:
    assert in_flank_range(0.1, 0.004)
    assert not in_flank_range(20.0, 0.02)
    assert not in_flank_range(0.1, 0.1)
    for grade in (0, 12):
        with pytest.raises(ValueError, match="1 to 11"):
            run_out_width(0.1, 0.004, grade)
    for grade in (4, 12):
        with pytest.raises(ValueError, match="IT5 to IT11"):
            size_width(0.1, grade)
    for size in (0.0, -0.1, 3.2, math.nan, math.inf):
        with pytest.raises(ValueError, match="no size"):
            size_width(size, 6)


@pytest.mark.parametrize(
    ("size", "grade", "expected"),
    [
        (30, 6, 13),  # a step ends with its upper size
        (30.001, 6, 16),
        (40, 6, 16),
        (50, 6, 16),
        (100, 7, 35),
        (120, 7, 35),
        (400, 6, 36),
        (605.2, 7, 70),
        (706, 6, 50),
        (3150, 11, 1350),
        (2, 5, 4),
    ],
)
def test_sizes_by_hand(size: float, grade: int, expected: float) -> None:
    assert size_width(size * 1e-3, grade) == pytest.approx(expected * UM, rel=1e-9)


ENDS = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150)
FACTORS = {5: 7, 6: 10, 7: 16, 8: 25, 9: 40, 10: 64, 11: 100}


@pytest.mark.parametrize("grade", SIZE_GRADES)
def test_sizes_follow_the_formula(grade: int) -> None:
    """i = 0.45 D^(1/3) + 0.001 D up to 500 mm, I = 0.004 D + 2.1 above, D the geometric mean of the step."""
    for low, high in pairwise(ENDS[2:]):  # from 10 mm on; below, the table is further from its formula
        d = math.sqrt(low * high)
        unit = 0.45 * d ** (1 / 3) + 0.001 * d if high <= 500 else 0.004 * d + 2.1
        difference = size_width(high * 1e-3, grade) / UM - FACTORS[grade] * unit
        # rounding to whole um, and the old preferred numbers: 36, 400, 32; neighbours in the table differ by 10 %
        assert abs(difference) <= 0.5 + 0.04 * FACTORS[grade] * unit, (low, high)


def test_sizes_rise_with_the_grade_and_the_size() -> None:
    table = [[size_width(end * 1e-3, grade) for grade in SIZE_GRADES] for end in ENDS]
    assert all(a < b for row in table for a, b in pairwise(row))
    assert all(a < b for first, second in pairwise(table) for a, b in zip(first, second, strict=True))
