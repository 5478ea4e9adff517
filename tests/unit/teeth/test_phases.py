"""Phases at the corners of contact, and means and harmonics over uneven phases."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from epicyclic.teeth.gear_pair import ContactPair
from epicyclic.teeth.loaded_contact import harmonics, loaded_contact
from epicyclic.teeth.path_of_contact import contact_lines, corner_phases, cycle_harmonics, cycle_mean, graded_phases

Build = Callable[..., ContactPair]


def test_lines_change_their_number_at_the_corners(pair_of: Build) -> None:
    for helix in (0.0, 15.0):
        plane = pair_of(helix=helix, width=37e-3).plane
        phases = graded_phases(corner_phases(plane), 8)
        corners = np.sort(np.mod(corner_phases(plane), 1.0))
        start, length = phases[:-1], np.diff(phases)
        start, length = start[length > 1e-8], length[length > 1e-8]  # not between the two sides of a jump
        inside = np.concatenate([start + 0.01 * length, start + 0.99 * length])
        lines = [(contact_lines(plane, one, 40).length > 0).any(axis=2).sum() for one in inside]
        half = len(inside) // 2
        assert lines[:half] == lines[half:]  # the same number at the beginning and at the end of every piece
        assert np.isin(corners, phases).all()
        assert phases[0] == 0


def test_a_jump_is_seen_from_both_sides(pair_of: Build) -> None:
    pair = pair_of(slices=1)
    phases = graded_phases(corner_phases(pair.plane), 32)
    fine = np.arange(5_000) / 5_000
    swing, exact = (np.ptp(loaded_contact(pair, [9e3], at).approach[0]) for at in (phases, fine))
    even = np.ptp(loaded_contact(pair, [9e3], np.arange(32) / 32).approach[0])
    assert swing == pytest.approx(exact, rel=1e-3)
    assert abs(even - exact) > 5e-3 * exact


def test_means_and_harmonics_over_uneven_phases() -> None:
    rng = np.random.default_rng(2)
    phase = np.unique(np.concatenate([[0.0], rng.random(400)]))
    wave = 3 + 2 * np.cos(2 * np.pi * phase + 0.4) - np.sin(6 * np.pi * phase)
    found = cycle_harmonics(wave, phase, 5)
    assert cycle_mean(wave, phase) == pytest.approx(3.0, abs=1e-3)
    assert found[0] == pytest.approx(3.0, abs=1e-3)
    assert found[1] == pytest.approx(2 * np.exp(0.4j), abs=2e-3)
    assert found[3] == pytest.approx(1j, abs=2e-3)
    # a saw with a jump taken from both sides: c_l = i/(pi l), which even samples have at first order only
    phase = np.array([0.0, 0.1, 0.35, 0.6 - 1e-9, 0.6 + 1e-9, 0.8])
    saw = np.mod(phase - 0.6, 1.0)
    exact = 1j / (np.pi * np.arange(1, 5)) * np.exp(-2j * np.pi * 0.6 * np.arange(1, 5))
    assert cycle_harmonics(saw, phase, 4)[1:] == pytest.approx(exact, abs=1e-7)
    assert cycle_mean(saw, phase) == pytest.approx(0.5, abs=1e-7)
    many = np.arange(64) / 64
    assert harmonics(np.mod(many - 0.6, 1.0), 4)[1] != pytest.approx(exact[0], abs=1e-3)
