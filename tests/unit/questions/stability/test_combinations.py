"""Boundaries by averaging: closed forms, and against Floquet multipliers as the variation of the stiffness shrinks."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import scipy.optimize

from epicyclic.questions.modes.eigen import modal_form
from epicyclic.questions.response.spectra import mesh_tones
from epicyclic.questions.stability.stability import (
    Combination,
    combinations,
    floquet_scan,
    half_width,
    parametric_system,
    resonances,
)
from epicyclic.system.system import System

SUM = 3.3  # w1 + w2 of `two`, to 2 %


def predicted(system: System, low: float, high: float, **options: Any) -> list[Combination]:
    return combinations(
        system, modal_form(system), tuple(map(float, mesh_tones(system))), low=low, high=high, **options
    )


def rate(system: System, frequency: float) -> float:
    return float(floquet_scan(parametric_system(system), np.array([frequency])).growth[0])


def at_sum(system: System) -> Combination:
    (found,) = (one for one in predicted(system, 0.5, 6.0) if (one.first, one.second, one.order) == (1, 2, 1))
    return found


def growth(strength: float, *, detuning: float = 0.0, first: float, second: float) -> float:
    """Growth rate of two modes coupled by a mesh order, from their decay and how far the order is from their sum."""
    split = complex((first - second) / 2, detuning / 2)
    return float((np.sqrt(split**2 + strength**2)).real - (first + second) / 2)


def test_closed_forms() -> None:
    assert growth(2.0, first=1.0, second=1.0) == pytest.approx(1.0)
    assert growth(2.0, detuning=2.0, first=0.5, second=0.5) == pytest.approx(np.sqrt(3) - 0.5)
    assert half_width(2.0, first=0.0, second=0.0) == pytest.approx(4.0)
    assert half_width(2.0, first=1.0, second=1.0) == pytest.approx(2 * np.sqrt(3))
    assert half_width(1.0, first=2.0, second=0.6) == 0.0
    for pair in ((0.3, 0.3), (0.1, 1.9), (1e-3, 1.5)):
        edge = half_width(1.7, first=pair[0], second=pair[1])
        assert growth(1.7, detuning=edge, first=pair[0], second=pair[1]) == pytest.approx(0.0, abs=1e-12)
    # unequal damping widens
    assert half_width(1.7, first=0.1, second=0.5) > half_width(1.7, first=0.3, second=0.3)
    assert half_width(1.7, first=0.0, second=1.0) == np.inf


@pytest.mark.parametrize("pair", [(2.0, 2.0), (0.3, 0.5), (1.0, 9.0)])
def test_a_range_opens_where_growth_begins(pair: tuple[float, float]) -> None:
    decay = {"first": pair[0], "second": pair[1]}
    below, above = (part * np.sqrt(pair[0] * pair[1]) for part in (0.999, 1.001))
    assert growth(below, **decay) < 0 < growth(above, **decay)
    assert half_width(below, **decay) == 0
    assert half_width(above, **decay) > 0


def test_the_ranges_are_those_of_the_closed_form(case: Any) -> None:
    system = case.two(0.5, zeta=0.004)
    modal = modal_form(system)
    found = at_sum(system)
    omega = np.sqrt(modal.squared)
    gaps = (modal.gaps * omega)[0]
    strength = 0.5 * system.meshes.stiffness[0] * abs(gaps[0] * gaps[1]) / (4 * np.sqrt(omega.prod()))
    first, second = modal.damping / 2
    width = half_width(strength, first=first, second=second) / (2 * np.pi)
    assert found.high - found.low == pytest.approx(2 * width, rel=1e-6)
    assert found.centre == pytest.approx(omega.sum() / (2 * np.pi), rel=1e-4)
    assert found.growth == pytest.approx(growth(strength, first=first, second=second), rel=1e-6)
    assert found.threshold == pytest.approx(np.sqrt(first * second) / strength, rel=1e-9)
    # it closes where it says it opens
    for factor, count in ((0.98, 0), (1.02, 1)):
        scaled = parametric_system(system, variation=factor * found.threshold).system
        assert sum((one.first, one.second) == (1, 2) for one in predicted(scaled, 0.5, 6.0)) == count


def test_fastest_growth_converges_to_that_of_floquet(case: Any) -> None:
    swings = np.array([0.4, 0.2, 0.1, 0.05])
    error = []
    for swing in swings:
        system = case.two(swing)
        found = at_sum(system)
        best = scipy.optimize.minimize_scalar(
            lambda f, system=system: -rate(system, f), bounds=(found.low, found.high), options={"xatol": 1e-9}
        )
        error.append(abs(-best.fun - found.growth) / found.growth)
    # the rate itself is of first order and the next term of third: relative error of second order
    assert np.polyfit(np.log(swings), np.log(error), 1)[0] == pytest.approx(2, abs=0.2)
    assert error[-1] < 1e-3


def test_boundaries_converge_to_those_of_floquet(case: Any) -> None:
    swings = np.array([0.4, 0.2, 0.1, 0.05])
    error = []
    for swing in swings:
        system = case.two(swing, zeta=1e-3 * swing)  # damping as small as the variation
        found = at_sum(system)
        reach = found.high - found.low
        edges = [
            scipy.optimize.brentq(
                lambda f, system=system: rate(system, f), edge - 0.3 * reach, edge + 0.3 * reach, xtol=1e-10
            )
            for edge in (found.low, found.high)
        ]
        error.append(np.abs(np.array(edges) - (found.low, found.high)).max())
    # first order is exact, so what is left is of second
    assert np.polyfit(np.log(swings), np.log(error), 1)[0] == pytest.approx(2, abs=0.2)


def test_sum_grows_and_difference_does_not(case: Any) -> None:
    system = case.two(0.4)
    omega = np.sqrt(modal_form(system).squared) / (2 * np.pi)
    around = np.linspace(-0.05, 0.05, 41)
    assert np.nanmax(floquet_scan(parametric_system(system), omega.sum() * (1 + around)).growth) > 0.05
    # a symmetric stiffness, however it swings: difference type closed, undamped multipliers stay on the circle
    difference = floquet_scan(parametric_system(system), np.diff(omega)[0] * (1 + around))
    assert np.abs(difference.largest - 1).max() < 1e-7
    assert all(kind == "stable" for kind in difference.kind)
    assert not any(abs(one.centre - np.diff(omega)[0]) < 0.05 for one in predicted(system, 0.5, 6.0))


def test_a_motion_of_negative_energy_opens_the_difference_type(case: Any) -> None:
    """A rotor above its critical speed, seen from its own axes: w0 + s and s - w0, the second of negative energy."""
    omega, turn = 2 * np.pi, 2 * np.pi * 1.7
    K, row = omega**2 * np.eye(2), np.array([[1.0], [0.0]])
    k = 0.1 * omega**2
    G, Kg = 2 * turn * np.array([[0.0, -1.0], [1.0, 0.0]]), -(turn**2) * np.eye(2)
    system = case.system(np.eye(2), K - k * row @ row.T, row, [k], [[0.5]], G=G, Kg=Kg)
    ready = parametric_system(system, frame_speed="operating")
    at = floquet_scan(ready, np.linspace(1.9, 2.1, 41))  # (w0 + s) - (s - w0) = 2 w0
    best = int(np.argmax(at.growth))
    # each of the two has half of the swing along x: D / 2 in the rate D / (4 w0) of a principal resonance
    assert at.growth[best] == pytest.approx(0.5 * k / (8 * omega), rel=1e-3)
    reference = np.linalg.eigvals(_turning(case, system, 1 / np.linspace(1.9, 2.1, 41)[best]))
    assert at.largest[best] == pytest.approx(np.abs(reference).max(), rel=1e-6)


@pytest.mark.parametrize("left_out", ["Kg", "Cskew"])
def test_centripetal_and_housing_terms_move_the_boundaries(case: Any, left_out: str) -> None:
    """Two modes of equal frequency, all terms as small as the variation: what averaging leaves is of second order."""
    angles = 2 * np.pi * np.arange(3) / 3
    rows = np.array([np.cos(angles), np.sin(angles)])
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    error, apart = [], 0.0
    for swing in (0.2, 0.1, 0.05):
        terms = {"Kg": -swing * np.diag([1.0, 0.4]), "Cskew": 0.5 * swing * turn}
        variation = swing * np.exp(1j * angles)[:, None]
        system = case.system(np.eye(2), 20 * np.eye(2), rows, [10.0] * 3, variation, zeta=0.015 * swing, **terms)
        found = predicted(system, 1.0, 3.0)
        low, high = min(one.low for one in found), max(one.high for one in found)
        reach = 0.2 * (high - low)
        edges = [
            scipy.optimize.brentq(lambda f, system=system: rate(system, f), edge - reach, edge + reach, xtol=1e-10)
            for edge in (low, high)
        ]
        error.append(np.abs(np.array(edges) - (low, high)).max())
        bare = predicted(replace(system, **{left_out: 0 * turn}), 1.0, 3.0)
        apart = max(abs(min(one.low for one in bare) - edges[0]), abs(max(one.high for one in bare) - edges[1]))
    assert error[-1] < error[0] / 8
    assert apart > 5 * error[-1]


def _turning(case: Any, system: System, period: float) -> Any:
    """Monodromy at relative speed 1 of the frame, the mesh at another frequency."""
    k, swing = system.meshes.stiffness, system.meshes.variation[:, 0]
    return case.monodromy(
        system, 1.0, period, stiffness=lambda t: k * (1 + (swing * np.exp(2j * np.pi * t / period)).real)
    )


def test_equal_frequencies_are_taken_together(case: Any) -> None:
    # three springs at 120 degrees in phase one after another: two modes of equal frequency, coupled by a turning wave
    angles = 2 * np.pi * np.arange(3) / 3
    rows = np.array([np.cos(angles), np.sin(angles)])
    swing = 0.3 * np.exp(1j * angles)[:, None]
    for G in (0.0, 0.2):
        system = case.system(
            np.eye(2), 20 * np.eye(2), rows, [10.0] * 3, swing, zeta=1e-3, G=G * np.array([[0.0, -1.0], [1.0, 0.0]])
        )
        (found,) = predicted(system, 1.0, 3.0)
        grid = np.linspace(found.low - 0.05, found.high + 0.05, 201)
        grows = grid[floquet_scan(parametric_system(system), grid).growth > 0]
        # first order in a variation of 0.3 of half the stiffness: 5 % of the width
        assert grows.min() == pytest.approx(found.low, abs=0.05 * (found.high - found.low))
        assert grows.max() == pytest.approx(found.high, abs=0.05 * (found.high - found.low))


def test_several_mesh_frequencies_each_for_itself(case: Any) -> None:
    system = case.two(0.5)
    meshes = system.meshes
    other = replace(
        system,
        tones=(Fraction(1), Fraction(2, 3)),
        meshes=replace(meshes, tone=np.array([1]), stage=("second",)),
    )
    one, two = at_sum(system), predicted(other, 0.5, 6.0)
    assert one.stage == "stage0"
    (same,) = (found for found in two if (found.first, found.second) == (1, 2))
    # the mesh follows the only tone that is used, which is then the first
    assert same.low == pytest.approx(one.low)
    assert same.stage == "second"


def test_the_strongest_come_first_and_rigid_modes_take_no_part(case: Any) -> None:
    system = case.system(np.eye(3), np.diag([0.0, 0.0, 30.0]), [[1.0], [-1.0], [0.3]], [40.0], [[0.7, 0.2]], zeta=1e-4)
    modal = modal_form(system)
    found = resonances(system, modal, (1.0,))
    assert modal.rigid.sum() == 1
    assert all(0 not in one.first and 0 not in one.second for one in found)
    assert [one.strength - one.damping_limit for one in found] == sorted(
        [one.strength - one.damping_limit for one in found], reverse=True
    )
    assert {one.order for one in found} == {1, 2}
