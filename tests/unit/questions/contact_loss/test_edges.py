"""Forces about edges of contact: their sums against integrals, their derivative, grids of two phases."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad

from epicyclic.questions.contact_loss.rows import edges

Array = NDArray[np.float64]
# Gaps that part for two fifths of a cycle, and touch for a fifth of it; [1].
MEANS = {"parts": 0.3, "touches": -0.8}


def forces(gap: Array, counts: tuple[int, ...], axis: NDArray[np.int64] | None = None) -> Array:
    """Forces (N, c) of a unit stiffness at gaps (N, c), as the balance has them."""
    columns = np.zeros(gap.shape[1], np.int64) if axis is None else axis
    found, delta = edges(gap, counts, columns), gap.copy()
    if found is not None:
        found.enter_penetration(delta, gap)
    force, tangent = np.maximum(delta, 0.0), np.where(delta > 0, 1.0, 0.0)
    if found is not None:
        found.enter_means(force, tangent, np.ones_like(gap))
    return force


def gap_over_cycle(mean: float, samples: int, begins: Array) -> Array:
    """Gaps (N, c) of a cycle that begins at some phases (c,)."""
    return mean + np.cos(2 * np.pi * (np.arange(samples)[:, None] / samples + begins))


@pytest.mark.parametrize("name", MEANS)
def test_their_sum_is_the_integral(name: str) -> None:
    mean, samples = MEANS[name], 32
    exact = quad(lambda t: max(mean + np.cos(2 * np.pi * t), 0.0), 0, 1, points=[0.25, 0.5, 0.75], limit=200)[0]
    gap = gap_over_cycle(mean, samples, np.linspace(0, 1 / samples, 41))
    ours = forces(gap, (samples,)).mean(axis=0) - exact
    alone = np.maximum(gap, 0.0).mean(axis=0) - exact
    # samples alone err by up to w^2 / 12 at every edge; what is left here is the curvature of the gap
    assert np.abs(alone).max() > 1e-4
    assert np.abs(ours).max() < np.abs(alone).max() / 6
    assert abs(ours.mean()) < 5e-5


def test_force_and_tangent_have_no_jump_where_first_touch_passes_a_sample() -> None:
    begins = np.linspace(0, 1 / 16, 4001)
    force = forces(gap_over_cycle(0.3, 32, begins), (32,))
    slope = np.diff(force, axis=1) / np.diff(begins)
    # the change of slope over a step, of a corner it is 2 pi sin as a whole
    assert np.abs(np.diff(slope, axis=1)).max() < 0.02 * np.abs(slope).max()


def test_columns_of_a_grid_follow_their_own_phase() -> None:
    first, second = gap_over_cycle(0.3, 24, np.zeros(1))[:, 0], gap_over_cycle(0.1, 20, np.zeros(1))[:, 0]
    spread = np.stack(np.broadcast_arrays(first[:, None], second), axis=-1).reshape(-1, 2)
    found = forces(spread, (24, 20), np.array([0, 1])).reshape(24, 20, 2)
    alone = forces(first[:, None], (24,)), forces(second[:, None], (20,))
    np.testing.assert_allclose(found[:, 0, 0], alone[0][:, 0], atol=1e-15)
    np.testing.assert_allclose(found[0, :, 1], alone[1][:, 0], atol=1e-15)
    assert np.ptp(found[:, :, 0], axis=1).max() == 0
    both = forces(spread[:, :1], (24, 20), np.zeros(1, np.int64)).reshape(24, 20)
    np.testing.assert_allclose(both[:, 3], alone[0][:, 0], atol=1e-15)
