"""Lattice points to phases and back, slow tones, and where points end."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from epicyclic.questions.contact_loss.rows import grid, phases_of
from epicyclic.questions.contact_loss.shaft_orders import grid_maximum, super_period_phases
from epicyclic.questions.contact_loss.torus import shaft_tones, torus_of
from epicyclic.questions.response.response import response
from epicyclic.system.system import System

F = Fraction
Train = Callable[..., System]


@pytest.mark.parametrize("counts", [(12,), (12, 7), (12, 6, 5)])
def test_transforms_are_the_sums_they_stand_for(counts: tuple[int, ...]) -> None:
    reach = [range(-4, 5), range(-2, 3), range(-2, 3)][: len(counts)]
    leading = [p for p in product(*reach) if next((a for a in p if a), 1) > 0]
    points = np.array(sorted(leading, key=lambda p: (any(p), p)), dtype=np.int64)
    made, J = grid(points, counts), len(points)
    rows = np.random.default_rng(1).normal(size=(2 * J, 3))
    rows[J] = 0.0
    values = made.values(rows)
    sums = ((rows[:J] + 1j * rows[J:]).T @ np.exp(2j * np.pi * points @ phases_of(made.counts).T)).real.T
    # rounding of sums of some hundred terms of size 1
    assert np.abs(values - sums).max() < 1e-12
    assert np.abs(made.rows(values) - rows).max() < 1e-12
    assert made.values(rows[:, :0]).shape == (len(sums), 0)
    assert made.rows(values[:, :0]).shape == (2 * J, 0)


@pytest.mark.parametrize(
    ("parts", "most", "tones", "left"),
    [
        ((F(1, 27), F(2, 27), F(26, 27)), 2, 1, 0),  # orders 1 and 2, and 1 before the mesh frequency
        ((F(2, 27), F(3, 27)), 1, 1, 0),  # a third tone of which they are 2 and 3
        ((F(1, 27), F(1, 31), F(1, 27) + F(1, 31)), 2, 2, 0),  # the last one is their sum
        ((F(1, 27), F(1, 31), F(1, 89)), 2, 2, 1),
        ((F(1, 27), F(1, 31), F(1, 89)), 3, 3, 0),
    ],
)
def test_shaft_tones_place_every_line_exactly(
    train: Train, parts: tuple[Fraction, ...], most: int, tones: int, left: int
) -> None:
    system = train(slow=[(part, 5e-6 + 1e-6j * i) for i, part in enumerate(parts)])
    ready = response(system)
    found = shaft_tones(ready, ready.lines.shaft, most=most)
    assert (len(found.tones), len(found.superposed)) == (tones, left)
    every = (*ready.lines.tones, *found.tones)
    for point, conjugate, line in found.lines:
        frequency = sum((a * tone for a, tone in zip(point, every, strict=True)), F(0))
        assert (-frequency if conjugate else frequency) == line.frequency
    assert len(found.lines) == len(parts) - left


def test_the_strongest_line_gets_the_tone(train: Train) -> None:
    system = train(slow=[(F(1, 27), 1e-6), (F(1, 31), 9e-6)])
    given = torus_of(response(system), most=1)
    assert given.shaft_tones.tones == (1000 * F(1, 31),)
    assert [shaft.frequency for shaft in given.shaft_tones.superposed] == [1000 * F(1, 27)]


def test_without_shaft_orders_none_count(train: Train) -> None:
    given = torus_of(response(train(slow=[(F(1, 27), 1e-6)])), shaft_orders=False)
    assert given.shaft_tones.tones == ()
    assert given.shaft_tones.superposed == ()
    assert given.shaft_lines == ()


def test_path_of_a_short_super_period_and_none_of_a_long_one() -> None:
    path = super_period_phases((F(1000), F(1000, 3)), 4)
    assert path is not None
    assert path.shape == (12, 2)
    # after one mesh cycle of four samples the slow phase is a third
    np.testing.assert_allclose(path[4], [0.0, 1 / 3], atol=1e-15)
    assert super_period_phases((F(1000), F(1000, 27 * 31 * 89)), 64) is None


def test_summit_between_samples() -> None:
    theta, phi = np.meshgrid(np.arange(16) / 16, np.arange(12) / 12, indexing="ij")
    wave = np.cos(2 * np.pi * (theta - 0.03)) + np.cos(2 * np.pi * (phi - 0.02))
    top = grid_maximum(wave[..., None])
    # a parabola through samples 1/12 apart is right to fourth order, 1e-3 here; the largest sample alone is 0.026 low
    assert top[0] == pytest.approx(2.0, abs=2e-3)
    assert wave.max() < 1.98
