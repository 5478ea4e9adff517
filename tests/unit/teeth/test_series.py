"""Series over a mesh cycle: tables, cosine and sine lists, and their place in time."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from epicyclic.errors import ModelError
from epicyclic.teeth.geometry import mesh_phasor
from epicyclic.teeth.mesh_stiffness import evaluate_series, fourier_series, series_in_time, table_series


@given(st.lists(st.floats(0.5, 2.0), min_size=1, max_size=33))
def test_table_series_passes_through_its_samples(values: list[float]) -> None:
    mean, series = table_series(values)
    assert series.shape == (len(values) // 2,)
    sigma = np.arange(len(values)) / len(values)
    # Rounding of a transform of 33 numbers of order 1.
    np.testing.assert_allclose(mean * evaluate_series(series, sigma), values, rtol=0, atol=1e-13)


def test_table_series_of_a_known_wave() -> None:
    sigma = np.arange(16) / 16
    mean, series = table_series(4e8 * (1 + 0.3 * np.cos(2 * np.pi * sigma) + 0.1 * np.sin(6 * np.pi * sigma)))
    assert mean == pytest.approx(4e8, rel=1e-14)  # rounding
    expected = np.zeros(8, complex)
    expected[0], expected[2] = 0.3, -0.1j
    np.testing.assert_allclose(series, expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("values", [[], [0.0, 0.0], [-1.0, 0.5], [float("nan")]])
def test_table_without_a_positive_mean_is_refused(values: list[float]) -> None:
    with pytest.raises(ModelError, match="positive mean"):
        table_series(values)


def test_fourier_series_is_the_sum_of_its_waves() -> None:
    sigma = np.linspace(-1, 1, 41)
    turn = 2 * np.pi * sigma
    expected = 1 + 0.2 * np.cos(turn) + 0.05 * np.cos(2 * turn) - 0.1 * np.sin(turn) + 0.03 * np.sin(3 * turn)
    series = fourier_series([0.2, 0.05], [-0.1, 0.0, 0.03])
    np.testing.assert_allclose(evaluate_series(series, sigma), expected, rtol=0, atol=1e-14)  # rounding
    assert fourier_series([]).shape == (0,)
    np.testing.assert_array_equal(evaluate_series([], sigma), np.ones(41))


@given(st.lists(st.complex_numbers(max_magnitude=1.0), max_size=6), st.fractions(0, 1), st.sampled_from([1, -1]))
def test_series_in_time_is_the_series_at_sigma_of_t(values: list[complex], lead: Fraction, sense: int) -> None:
    cycles = np.linspace(0.0, 2.0, 17)
    over_time = evaluate_series(series_in_time(values, lead=lead, sense=sense), cycles)
    over_sigma = evaluate_series(values, sense * (cycles + float(lead)))
    np.testing.assert_allclose(over_time, over_sigma, rtol=0, atol=1e-12)  # rounding of sigma, 40 turns at order 6


def test_mesh_phasor_takes_whole_cycles_off_exactly() -> None:
    assert mesh_phasor(3 * 10**18, Fraction(1, 3)) == 1.0
    # 10^18 + 1 leads of 1/3 are whole cycles and 2/3; a float of the product has no digits left behind the point.
    assert mesh_phasor(10**18 + 1, Fraction(1, 3)) == pytest.approx(np.exp(4j * np.pi / 3), abs=1e-15)
    assert mesh_phasor(1, Fraction(3, 4)) == pytest.approx(-1j, abs=1e-15)
