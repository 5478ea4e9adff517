"""Names, numbers and records on their way into a figure."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from epicyclic.show.series import compact, engineering, merged, short_names, thinned


def test_short_names_leave_the_only_stage_out() -> None:
    assert short_names(["main/sun-planet/2/left", "main/planet-ring/1", "main/sun/support"]) == [
        "sun-planet 2 L",
        "planet-ring 1",
        "sun/support",
    ]
    assert short_names(["low/sun-planet/2", "high/sun-planet/2"]) == ["low sun-planet 2", "high sun-planet 2"]


def test_a_narrow_curve_is_no_staircase() -> None:
    """1.0031 to 1.0032 in five digits would be two levels; what is rounding alone stays one."""
    wave = np.asarray(1.00315 + 5e-5 * np.sin(np.linspace(0, 7, 200)), dtype=np.float64)
    shown = np.array(compact(wave), dtype=float)
    assert len(set(shown)) > 100
    np.testing.assert_allclose(shown, wave, rtol=0, atol=5e-3 * np.ptp(wave))
    level = np.asarray(1.0 + 1e-15 * np.arange(5), dtype=np.float64)
    assert set(compact(level)) == {1.0}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (27.3125, "27.31"),
        (-347.826, "-347.8"),
        (1e10, "1e10"),
        (2.85e9, "2.85e9"),
        (22287.0, "22287"),
        (4.5e-4, "4.5e-4"),
        (math.nan, ""),
        (math.inf, "∞"),
    ],
)
def test_engineering(value: float, text: str) -> None:
    assert engineering(value) == text


@given(st.floats(-1e12, 1e12))
def test_engineering_reads_back(value: float) -> None:
    # four significant digits
    assert float(engineering(value)) == pytest.approx(value, rel=5.1e-4, abs=1e-300)


def test_coinciding_sides_become_one_curve() -> None:
    names = ["m/a-b/1/left", "m/a-b/1/right", "m/a-b/2/left", "m/a-b/2/right"]
    values = np.array([[1.0, 2.0], [1.0, 2.0], [1.0, 2.0], [1.0, 3.0]])
    found = merged(names, values)
    assert [one.label for one in found] == ["branch 1 L, R", "branch 2 L", "branch 2 R"]
    assert [one.branch for one in found] == [1, 2, 2]


@given(hnp.arrays(np.float64, st.integers(1, 7000), elements=st.floats(-1e6, 1e6)))
def test_thinning_keeps_the_extremes(y: NDArray[np.float64]) -> None:
    x = np.arange(len(y), dtype=np.float64)
    kept_x, kept_y = thinned(x, y)
    assert len(kept_x) <= 1200 + 2 * len(y) // 1200 + 2
    assert (kept_y.min(), kept_y.max()) == (y.min(), y.max())
    assert np.all(np.diff(kept_x) >= 0)


@given(hnp.arrays(np.float64, 20, elements=st.floats(-1e9, 1e9)))
def test_compact_keeps_five_digits_of_the_largest(values: NDArray[np.float64]) -> None:
    given_back = np.array(compact(values), dtype=np.float64)
    assert np.abs(given_back - values).max() <= 1e-4 * np.abs(values).max() + 1e-200


def test_compact_turns_gaps_into_none() -> None:
    assert compact(np.array([1.0, math.nan, 2.0])) == [1.0, None, 2.0]
