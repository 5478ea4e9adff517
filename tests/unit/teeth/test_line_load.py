"""Loads as means over a length of contact line: by quadrature, and converged where a line begins at a corner."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from epicyclic.teeth.gear_pair import ContactPair
from epicyclic.teeth.loaded_contact import loaded_contact
from epicyclic.teeth.path_of_contact import averaging_length, contact_lines, corner_phases, graded_phases, line_windows

Build = Callable[..., ContactPair]


def test_the_length_is_about_a_module(pair_of: Build) -> None:
    pair = pair_of(helix=15.0)
    transverse = pair.plane.base_pitch * math.cos(pair.plane.base_helix) / math.pi
    assert averaging_length(pair.plane) == pytest.approx(transverse, rel=1e-12)
    narrow = replace(pair.plane, face_a=(-1e-4, 1e-4), face_b=(-1e-4, 1e-4))
    assert averaging_length(narrow) == pytest.approx(2e-4 / math.cos(pair.plane.base_helix))


def test_means_are_those_of_quadrature(pair_of: Build) -> None:
    plane = pair_of(helix=15.0, width=40e-3).plane
    lines = contact_lines(plane, np.arange(5) / 5 + 0.013, 17)
    windows, length = line_windows(plane, lines), averaging_length(plane)
    force = np.random.default_rng(3).random(lines.length.shape) * (lines.length > 0)
    found = windows.mean(force)
    slant = math.cos(plane.base_helix)
    for t, j in np.ndindex(*lines.length.shape[:2]):
        on = np.flatnonzero(lines.length[t, j] > 0)
        if not len(on):
            continue
        half = 0.5 * lines.length[t, j, on] * slant
        start, end = lines.zeta[t, j, on] - half, lines.zeta[t, j, on] + half
        whole = (end[-1] - start[0]) / slant
        for k in on:
            reach = 0.5 * min(length, whole) * slant
            low = np.clip(lines.zeta[t, j, k], start[0] + reach, end[-1] - reach) - reach
            part = np.clip(np.minimum(end, low + 2 * reach) - np.maximum(start, low), 0, None) / (end - start)
            assert found[t, j, k] == pytest.approx((part * force[t, j, on]).sum() / length, rel=1e-9, abs=1e-9)


def test_an_even_load_is_its_own_mean(pair_of: Build) -> None:
    found = loaded_contact(pair_of(slices=6), [9e3], [0.02])  # spur: uniform along the face but for its ends
    mean = 9e3 / 30e-3
    assert found.mean_load[found.mean_load > 0] == pytest.approx(mean, rel=0.01)


def test_the_load_at_a_corner_converges(pair_of: Build) -> None:
    pair = pair_of(helix=15.0, width=40e-3)
    phases = graded_phases(corner_phases(pair.plane), 32)
    found = [loaded_contact(replace(pair, slices=n), [8e3], phases) for n in (10, 20, 40, 80)]
    largest = np.array([one.largest_load[0] for one in found])
    assert largest == pytest.approx(largest[-1], rel=0.01)
    pressure = np.array([one.largest_pressure[0] for one in found])
    assert pressure == pytest.approx(pressure[-1], rel=0.01)
    # a value at a point does not: the shorter the line, the larger
    lengths = [np.maximum(one.segments.lines.length, 1e-12) for one in found]
    points = np.array([(one.force / length).max() for one, length in zip(found, lengths, strict=True)])
    assert points[-1] > 1.3 * largest[-1]
