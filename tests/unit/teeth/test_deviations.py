"""Deviations: vectors of a body, profile errors, measured pitches."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from epicyclic.teeth import geometry as d


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("order", [1, 3])
def test_identical_teeth_follow_the_mesh_phase(sense: int, order: int) -> None:
    lead = Fraction(2, 3)
    amplitude = d.profile_amplitude(8e-6, order, lead=lead)
    for cycles in (0.0, 0.21, 1.37):
        sigma = sense * (cycles + float(lead))
        now = (amplitude * np.exp(2j * np.pi * order * cycles)).real
        assert now == pytest.approx(8e-6 * math.cos(2 * math.pi * order * sigma), abs=1e-19)  # rounding of 8e-6


def test_given_phase_is_absolute() -> None:
    amplitude = d.profile_amplitude(8e-6, 2, 0.7, lead=Fraction(1, 3))
    assert amplitude == pytest.approx(8e-6 * np.exp(0.7j), abs=1e-20)
    assert d.profile_amplitude(8e-6, 2, 0.0, lead=Fraction(1, 3)) == 8e-6


def test_random_phases_repeat_with_their_seed() -> None:
    first, again, other = d.random_phases(50, 2), d.random_phases(50, 2), d.random_phases(50, 3)
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
    assert first.min() >= 0.0
    assert first.max() < 2 * math.pi
    assert np.ptp(first) > 5.0  # spread over the turn, not over one radian


_tables = st.lists(st.floats(-30e-6, 30e-6), min_size=5, max_size=60)


@given(_tables)
def test_pitch_lines_join_the_teeth_by_straight_lines(table: list[float]) -> None:
    teeth = len(table)
    orders, coefficients = d.pitch_lines(table, highest_order=200 * teeth)
    tau = np.linspace(-teeth, 2 * teeth, 101)
    expected = np.interp(tau % teeth, np.arange(teeth + 1), [*table, table[0]])
    # Bends up to 120 um per pitch in each of z teeth; the tail of a bend s is s z/(pi^2 L) pitches, L = 200 z.
    bound = 120e-6 * teeth / (math.pi**2 * 200 * teeth) * 1.05
    series = (np.exp(2j * np.pi / teeth * np.outer(tau, orders)) @ coefficients).real
    np.testing.assert_allclose(series, expected, rtol=0, atol=bound * math.sqrt(teeth))


def test_eccentric_pitch_deviations_are_one_shaft_order() -> None:
    teeth = 23
    tooth = np.arange(teeth)
    orders, coefficients = d.pitch_lines(10e-6 * np.cos(2 * np.pi * tooth / teeth - 0.3))
    np.testing.assert_array_equal(orders, np.arange(teeth))
    expected = np.zeros(teeth, complex)
    # Linear interpolation takes sinc^2(1/z) off the wave and puts a trace of it, (1/(z-1))^2 as much, at order z - 1.
    expected[1] = 10e-6 * np.exp(-0.3j) * np.sinc(1 / teeth) ** 2
    expected[teeth - 1] = 10e-6 * np.exp(0.3j) * np.sinc(1 - 1 / teeth) ** 2
    np.testing.assert_allclose(coefficients, expected, rtol=0, atol=1e-19)  # rounding of 10e-6


def test_equal_deviations_are_a_constant_gap_and_leave_the_mesh_frequency_alone() -> None:
    orders, coefficients = d.pitch_lines([5e-6] * 17, highest_order=40)
    np.testing.assert_allclose(coefficients[orders == 0], 5e-6, rtol=1e-15)
    np.testing.assert_allclose(coefficients[orders > 0], 0.0, atol=1e-20)  # rounding of 5e-6


def test_tooth_phase_counts_teeth_against_the_rotation() -> None:
    # A gear of 20 teeth turned counter-clockwise by one pitch meets with the tooth clockwise of tooth 1: number 20.
    assert d.tooth_phase(20, 0.5, 0.5) == 0.0
    assert d.tooth_phase(20, 0.0, 2 * math.pi / 20) == pytest.approx(-1.0, abs=1e-15)
    # Seen from the gear the mesh one pitch counter-clockwise of x meets tooth 2.
    assert d.tooth_phase(20, 2 * math.pi / 20, 0.0) == pytest.approx(1.0, abs=1e-15)
