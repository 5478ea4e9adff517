"""Variance shares against responses whose shares are known."""

from __future__ import annotations

import numpy as np
import pytest
from floating_sun import FloatingSun
from scipy.special import ndtri

from epicyclic.engine.plan import SamplingPlan
from epicyclic.questions.tolerance.effects import variance_shares

PLAN = SamplingPlan(samples=2**13, scrambles=1, rows=2**13, seed=1, sampler="sobol")


def test_a_linear_response_has_its_squared_coefficients() -> None:
    coefficient = np.array([3.0, -2.0, 1.0, 0.5])
    found = variance_shares(lambda u: ndtri(u) @ coefficient, np.arange(4), PLAN, groups=4)
    expected = coefficient**2 / np.sum(coefficient**2)
    assert found.first.value == pytest.approx(expected, abs=2e-3)
    assert found.total.value == pytest.approx(expected, abs=2e-3)


def test_one_mesh_force_shares_its_variance_by_squared_coefficients() -> None:
    drawn = FloatingSun(5, (1.0, 0.5, 2.0, 0.2, 0.7), together=False)
    # slope of the force of the first mesh in each standard number, from the map itself
    step = np.eye(5)
    high, low = (np.full(5, 0.5) + sign * 0.1 * step for sign in (1, -1))
    slope = (drawn.forces(high)[:, 0] - drawn.forces(low)[:, 0]) / (2 * ndtri(0.6))
    expected = slope**2 / np.sum(slope**2)
    found = variance_shares(lambda u: drawn.forces(u)[:, 0], drawn.dimension_entry, PLAN, groups=5)
    assert found.first.value == pytest.approx(expected, abs=3e-3)
    assert found.total.value == pytest.approx(expected, abs=3e-3)


def test_the_largest_of_four_pins_hardly_has_first_order_shares() -> None:
    apart = FloatingSun(4, together=False)
    found = variance_shares(lambda u: apart.evaluate(u).k, apart.dimension_entry, PLAN, groups=4)
    assert found.first.value.shape == (2, 1, 4)
    assert found.first.value[0, 0] == pytest.approx(0.055, abs=0.01)
    assert found.total.value[0, 0] == pytest.approx(0.48, abs=0.02)
    together = FloatingSun(4)
    grouped = variance_shares(lambda u: together.evaluate(u).k, together.dimension_entry, PLAN, groups=1)
    assert grouped.first.value == pytest.approx(1.0, abs=0.01)
    assert grouped.total.value == pytest.approx(1.0, abs=0.01)


def test_groups_without_effect_and_interactions() -> None:
    # x y + 2 z: first order 0, 0, 4/5 and total 1/5, 1/5, 4/5; a fourth does nothing
    def response(u: np.ndarray) -> np.ndarray:
        x = ndtri(u)
        return np.asarray(x[:, 0] * x[:, 1] + 2 * x[:, 2])

    found = variance_shares(response, np.arange(4), PLAN, groups=4)
    assert found.first.value == pytest.approx([0, 0, 0.8, 0], abs=0.02)
    assert found.total.value == pytest.approx([0.2, 0.2, 0.8, 0], abs=0.02)
    assert (found.first.value[3], found.total.value[3]) == pytest.approx((0, 0), abs=1e-15)


def test_no_variance_has_no_shares() -> None:
    found = variance_shares(lambda u: np.full(len(u), 1.0), np.arange(2), PLAN, groups=2)
    assert np.isnan(found.first.value).all()
    assert np.isnan(found.total.value).all()
