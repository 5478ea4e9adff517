"""Modes followed: a veering in closed form, and the planetary set, where symmetry decides what crosses."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.questions.modes.campbell import (
    LocusEvent,
    ModeSet,
    locus_events,
    match_modes,
    repeated_loci,
    track_modes,
)
from epicyclic.questions.modes.eigen import classify_modes, eigen
from epicyclic.system.system import System

Array = NDArray[np.float64]


def two(value: float, coupling: float) -> tuple[Array, Array]:
    """Two oscillators of unequal mass, one of them tuned, joined by a spring."""
    M = np.diag([1.0, 2.0])
    K = np.array([[100.0 + 7.0 * value, -coupling], [-coupling, 240.0]])
    return K, M


def state(K: Array, M: Array, value: float) -> ModeSet:
    root = np.sqrt(np.diag(M))
    squared, shapes = np.linalg.eigh(K / np.outer(root, root))
    return ModeSet(value=value, omega_squared=squared, vectors=shapes / root[:, None], M=M)


def tuned(coupling: float, points: int = 11) -> tuple[list[ModeSet], list[LocusEvent]]:
    path = track_modes(lambda value: state(*two(value, coupling), value), np.linspace(-6, 12, points).tolist())
    return path, locus_events(path, lambda _: (np.diag([7.0, 0.0]), np.zeros((2, 2))))


@pytest.mark.parametrize("coupling", [3.0, 0.3, 1e-3])
def test_two_coupled_oscillators_veer_in_closed_form(coupling: float) -> None:
    """lambda = mean +- sqrt((7 p - 20)^2 / 4 + c^2 / 2): closest at p = 20/7, sqrt(2) c apart, shapes half and half."""
    path, (event,) = tuned(coupling)
    assert event.kind == "veering"
    assert event.value == pytest.approx(20 / 7, abs=1e-3 * coupling)  # found by parabolas to 1e-3 of the width
    assert event.gap == pytest.approx(np.sqrt(2) * coupling, rel=1e-5)  # flat at the least: the square of that
    assert event.coupling == pytest.approx(7 / 2, rel=1e-5)  # phi_1' K' phi_2 with equal halves
    assert event.index == pytest.approx(1.0, abs=1e-5)
    squared = np.array([one.omega_squared for one in path])
    assert (squared[:, 0] < squared[:, 1]).all()  # the loci never meet
    start, end = path[0].vectors[:, 0], path[-1].vectors[:, 0]
    assert abs(start[0]) > abs(start[1])
    assert abs(end[1]) > abs(end[0])  # and have exchanged their shapes


def test_without_coupling_they_cross() -> None:
    path, (event,) = tuned(0.0)
    assert (event.kind, event.first, event.second) == ("crossing", (0,), (1,))
    assert event.value == pytest.approx(20 / 7, rel=1e-8)  # linear: one chord
    assert event.coupling == pytest.approx(0.0, abs=1e-12)
    assert event.index == pytest.approx(0.0, abs=1e-12)
    assert path[-1].omega_squared[0] > path[-1].omega_squared[1]


def test_a_double_root_is_turned_to_what_went_before() -> None:
    draw = np.random.default_rng(0)
    turn, _ = np.linalg.qr(draw.normal(size=(2, 2)))
    M = np.eye(3)
    before = ModeSet(value=0.0, omega_squared=np.array([1.0, 1.0, 4.0]), vectors=np.eye(3), M=M)
    vectors = np.eye(3)
    vectors[:2, :2] = turn
    here, correlation = match_modes(
        before, ModeSet(value=1.0, omega_squared=np.array([2.0, 2.0, 4.0]), vectors=vectors, M=M)
    )
    assert here.vectors == pytest.approx(np.eye(3), abs=1e-12)
    assert correlation == pytest.approx(1.0)
    assert repeated_loci(np.array([before.omega_squared, here.omega_squared])) == [(0, 1), (2,)]


@cache
def over_pins(build: Any, mistuned: tuple[float, float]) -> tuple[list[ModeSet], list[LocusEvent], tuple[str, ...]]:
    """Four planets, over the pin stiffness; two meshes stiffer by the parts `mistuned`."""

    def system(value: float) -> System:
        made: System = build.planar(mesh=(5e8, 6e8), lateral=(1e8, 1e8, 1e8, value)).system()
        stiffness = made.meshes.stiffness.copy()
        stiffness[1:3] *= 1 + np.array(mistuned)
        return replace(made, meshes=replace(made.meshes, stiffness=stiffness))

    def at(value: float) -> ModeSet:
        made = system(value)
        modes = eigen(made)
        return ModeSet(value=value, omega_squared=modes.omega_squared, vectors=modes.vectors, M=made.M)

    def slope(value: float) -> tuple[Array, Array]:
        high, low = system(1.001 * value), system(0.999 * value)
        return (high.K - low.K) / (0.002 * value), np.zeros_like(high.K)

    path = track_modes(at, np.geomspace(3e7, 1e9, 13).tolist())
    first = system(3e7)
    return path, locus_events(path, slope), classify_modes(first, path[0].omega_squared, path[0].vectors).kind


def test_modes_of_different_kinds_cross_and_of_one_kind_veer(build: Any) -> None:
    """Symmetry keeps the kinds apart whatever the pins; two rotational modes are nothing apart [lin2001]."""
    path, met, kinds = over_pins(build, (0.0, 0.0))
    kind_of = {event: (kinds[event.first[0]], kinds[event.second[0]]) for event in met}
    crossing = [event for event in met if event.kind == "crossing"]
    veering = [event for event in met if event.kind == "veering"]
    assert len(crossing) >= 2
    assert veering
    for event in crossing:
        assert len(set(kind_of[event])) == 2
        assert event.index < 1e-9  # symmetry, to rounding
    for event in veering:
        assert len(set(kind_of[event])) == 1
        assert event.index > 0.5
    assert {len(group) for group in repeated_loci(np.array([one.omega_squared for one in path]))} == {1, 2}


def test_mistuned_planets_turn_crossings_into_veerings(build: Any) -> None:
    """One planet alone leaves a mirror: of each double root one mode still crosses; two unequal ones leave nothing."""
    _, tuned_met, _ = over_pins(build, (0.0, 0.0))
    crossings = [event.value for event in tuned_met if event.kind == "crossing"]
    for mistuned, left in (((0.02, 0.0), 1), ((0.02, 0.012), 0)):
        _, met, _ = over_pins(build, mistuned)
        for value in crossings:
            near = [event for event in met if abs(event.value / value - 1) < 0.02]
            assert sum(event.kind == "crossing" for event in near) == left
            # where three loci turn at once, the gap of two of them need not be least there
            assert not left or sum(event.kind == "veering" and event.index > 0.99 for event in near) == 1
        assert sum(event.kind == "veering" for event in met) >= 3
