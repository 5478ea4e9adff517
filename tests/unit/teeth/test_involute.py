"""The involute function and its inverse."""

from __future__ import annotations

import math
from decimal import Decimal, getcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from epicyclic.teeth.geometry import inverse_involute, involute


def _exact(angle: float) -> float:
    # tan a - a with 60 digits, tan as the quotient of the Taylor series of sine and cosine.
    getcontext().prec = 60
    x = Decimal(angle)
    sine = cosine = Decimal(0)
    term = Decimal(1)
    for n in range(60):
        part = term if n % 4 < 2 else -term
        sine, cosine = (sine + part, cosine) if n % 2 else (sine, cosine + part)
        term = term * x / (n + 1)
    return float(sine / cosine - x)


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 0.01, 0.0999999, 0.1, 0.35, 1.0, 1.5])
def test_involute_matches_sixty_digits(angle: float) -> None:
    # 4e-14: just above the change from series to tan a - a (0.1 rad) three digits cancel; elsewhere it is 1e-15.
    assert involute(angle) == pytest.approx(_exact(angle), rel=4e-14)


def test_involute_of_twenty_degrees_is_the_tabulated_value() -> None:
    # Every gear handbook prints inv 20 deg = 0.014904 (six decimals).
    assert involute(math.radians(20.0)) == pytest.approx(0.014904, abs=5e-7)


@given(st.floats(0.0, 1.57))
def test_round_trip_from_the_angle(angle: float) -> None:
    # The promise of the docstring: 1e-14 rad.
    assert abs(inverse_involute(involute(angle)) - angle) < 1e-14


@given(st.floats(1e-12, 1e3))
def test_round_trip_from_the_value(value: float) -> None:
    # Near 90 deg one unit in the last place of the angle moves the value by 1e-16 value^2.
    assert involute(inverse_involute(value)) == pytest.approx(value, rel=1e-13 + 1e-15 * value)


def test_arrays_keep_their_shape_and_negative_angles_their_sign() -> None:
    angles = np.array([[-0.5, 0.0, 0.05], [0.2, 0.4, 1.2]])
    back = inverse_involute(involute(angles))
    assert back.shape == angles.shape
    np.testing.assert_allclose(back, angles, rtol=0, atol=1e-14)  # the promise of the docstring
