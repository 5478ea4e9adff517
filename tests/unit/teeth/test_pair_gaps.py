"""Pitch errors as gaps of pairs of teeth, against springs in parallel."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from epicyclic.teeth.form import Flank, Wave
from epicyclic.teeth.gear_pair import ContactPair, MeshWave
from epicyclic.teeth.loaded_contact import loaded_contact

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Spring:
    """A tooth of one compliance at every height, on a rigid body."""

    compliance: float = 1e-11
    shared: float = 0.0

    def face_decay(self, width: float) -> float:
        return 1e-2

    def bending(self, radius: ArrayLike) -> Array:
        return np.full(np.shape(radius), self.compliance)

    def depth(self, radius: ArrayLike) -> Array:
        return np.full(np.shape(radius), 4e-3)

    def body_factors(self, radius: ArrayLike, tooth: ArrayLike) -> tuple[Array, Array]:
        return np.zeros((*np.shape(radius), 1)), np.zeros((1, 1))


@pytest.mark.parametrize("step", [3e-6, 40e-6, -3e-6, -40e-6])
def test_a_step_between_two_pairs(pair_of: Callable[..., ContactPair], step: float) -> None:
    # constant springs k a pair of teeth: alone d = F/k + gap; two of gaps g, h share where they both touch,
    # d = (F/k + g + h)/2, else the one of the smaller gap bears alone
    pair = pair_of(tooth_a=Spring(), tooth_b=Spring(), slices=1, linear_at=1e5)
    force = 12e3
    low, high = pair.plane.limits
    sigma = np.linspace(low + 1e-6, high + 1 - 1e-6, 200)
    late = replace(pair, pair_gaps=(0.0, step), first_pair=0)  # pairs from number 1 on
    found = loaded_contact(late, [force], sigma).approach[0]
    gaps = {n: step if n > 0 else 0.0 for n in range(-2, 5)}
    # each pair by itself: the others a metre off
    away = {n: replace(pair, pair_gaps=(1.0, 0.0, 1.0), first_pair=n - 1) for n in gaps}
    alone = {n: loaded_contact(one, [force], sigma).approach[0] / force for n, one in away.items()}
    for i, place in enumerate(sigma):
        bearing = [n for n in gaps if low <= place - n < high]
        assert 1 <= len(bearing) <= 2
        springs = np.array([1 / alone[n][i] for n in bearing])
        own = np.array([gaps[n] for n in bearing])
        together = (force + springs @ own) / springs.sum()
        expected = together if together > own.max() else float(np.min(own + force / springs))
        assert found[i] == pytest.approx(expected, rel=1e-9)


def test_gaps_of_pairs_are_pitch_deviations(pair_of: Callable[..., ContactPair]) -> None:
    pair = pair_of(slices=2)
    sigma = np.arange(64) / 16 - 1
    gaps = (2e-6, -5e-6, 7e-6, 0.0, 3e-6, 1e-6)
    one = loaded_contact(replace(pair, pair_gaps=gaps, first_pair=-2), [9e3], sigma)
    pitch = np.zeros(pair.teeth[0])
    pitch[np.arange(-2, 4) % len(pitch)] = gaps
    pitch[np.arange(4, 8)] = gaps[-1]
    pitch[np.arange(-5, -2)] = gaps[0]
    other = loaded_contact(replace(pair, flank_a=Flank(pitch=tuple(pitch))), [9e3], sigma)
    np.testing.assert_allclose(one.approach, other.approach, rtol=1e-12)
    assert np.ptp(one.approach) > np.ptp(loaded_contact(pair, [9e3], sigma).approach)


def test_a_whole_order_opens_all_pairs_alike(pair_of: Callable[..., ContactPair]) -> None:
    pair = pair_of(slices=2)
    sigma = np.arange(32) / 32
    wave = Wave(amplitude=4e-6, order=2, phase=0.7)
    plain = loaded_contact(pair, [9e3], sigma)
    waved = loaded_contact(replace(pair, flank_a=Flank(waves=(wave,))), [9e3], sigma)
    added = 4e-6 * np.cos(4 * math.pi * sigma + 0.7)
    np.testing.assert_allclose(waved.approach[0], plain.approach[0] + added, rtol=1e-9)
    np.testing.assert_allclose(waved.force, plain.force, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("helix", [0.0, 15.0])
def test_a_wave_of_the_mesh_opens_all_pairs_alike(pair_of: Callable[..., ContactPair], helix: float) -> None:
    # of an order that is not whole, over several cycles: what turns with a gear
    pair = pair_of(helix=helix, slices=5)
    sigma = np.linspace(-1.3, 2.6, 40)
    plain = loaded_contact(pair, [9e3], sigma)
    wave = MeshWave(amplitude=6e-6, order=3 / 21, phase=0.4)
    waved = loaded_contact(replace(pair, waves=(wave,)), [9e3], sigma)
    added = 6e-6 * np.cos(2 * math.pi * 3 / 21 * sigma + 0.4)
    np.testing.assert_allclose(waved.approach[0], plain.approach[0] + added, rtol=1e-8)
    np.testing.assert_allclose(waved.force, plain.force, rtol=1e-5, atol=1e-5)
