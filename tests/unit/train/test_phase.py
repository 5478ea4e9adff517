"""Phases as exact and inexact parts."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from epicyclic.teeth.geometry import Phase, shift_term

EXACT = st.fractions(-50, 50, max_denominator=200)
REST = st.floats(-20, 20, allow_subnormal=False)


@given(EXACT, EXACT, st.integers(-30, 30))
def test_rational_phases_stay_rational(a: Fraction, b: Fraction, factor: int) -> None:
    assert (Phase(a) + b).value == a + b
    assert (Phase(a) - Phase(b)).value == a - b
    assert (factor * Phase(a)).value == (Phase(a) * factor).value == factor * a
    assert (-Phase(a)).value == -a
    assert (Phase(a) % 1).value == a % 1
    assert (Phase(a) % Fraction(1, 22)).value == a % Fraction(1, 22)


@given(EXACT, EXACT, REST, st.integers(1, 30))
def test_equal_rests_cancel_exactly(a: Fraction, b: Fraction, rest: float, factor: int) -> None:
    difference = factor * Phase(a, rest) - factor * Phase(b, rest)
    assert difference.value == factor * (a - b)


@given(EXACT, REST, st.sampled_from([Fraction(1), Fraction(1, 22), Fraction(7, 3)]))
def test_values_lie_within_one_period(a: Fraction, rest: float, period: Fraction) -> None:
    value = float((Phase(a, rest) % period).value)
    assert 0 <= value < float(period)
    turns = (float(a) + rest - value) / float(period)
    assert turns == pytest.approx(round(turns), abs=1e-10)  # rounding of sums below 100 over periods above 1/22
    nearest = float(Phase(a, rest).nearest(period).value)
    assert abs(nearest) <= (float(period) / 2) * (1 + 1e-14)  # rounding of the sum of both parts


def test_a_rest_below_rounding_does_not_leave_the_interval() -> None:
    assert (Phase(Fraction(0), -1e-20) % 1).value == 0
    assert Phase(Fraction(1, 2)).nearest().value == Fraction(-1, 2)
    assert Phase.of(0.25) == Phase(Fraction(0), 0.25)
    assert Phase.of(3) == Phase(Fraction(3))


def test_shift_terms_of_a_pair_without_backlash_cancel() -> None:
    normal, transverse = math.radians(20), math.radians(21.3)
    assert shift_term(teeth=23, profile_shift=0.0, normal_angle=normal, transverse_angle=0.4, working_angle=0.4) == 0.0
    for other in (40, -70):  # an external mate and a ring
        working, x = math.radians(23.0), 0.3
        gain = (math.tan(working) - working) - (math.tan(transverse) - transverse)
        x_other = (23 + other) * gain / (2 * math.tan(normal)) - x
        terms = [
            shift_term(
                teeth=abs(z),
                profile_shift=shift,
                normal_angle=normal,
                transverse_angle=transverse,
                working_angle=working,
                internal=z < 0,
            )
            for z, shift in ((23, x), (other, x_other))
        ]
        assert terms[0] == pytest.approx(-terms[1], abs=1e-14)  # rounding of numbers of order 0.1
        assert abs(terms[0]) > 0.01
