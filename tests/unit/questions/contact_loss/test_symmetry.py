"""Motions with less symmetry than their train are named so, however a sweep has come to them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.questions.contact_loss.branch_set import BranchSet, branch_set
from epicyclic.questions.contact_loss.solutions import Refinement, Solution, symmetry_is_broken
from epicyclic.questions.contact_loss.sweep import contact_sweep
from epicyclic.questions.contact_loss.sweep_direction import initial_state, sweep_direction
from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.response import response
from epicyclic.system.system import System
from epicyclic.train.resolution import load

TRAIN = """
format = 2
title = "a set"
damping.modal = {damping}
[stages.main]
planets = {planets}
module = "3 mm"
face_width = "75 mm"
[stages.main.sun]
teeth = {sun}
support.radial = "1.5e7 N/m"
[stages.main.planet]
teeth = 21
bore = "37 mm"
bearing.radial = "7.5e8 N/m"
[stages.main.ring]
teeth = {ring}
rim = "12 mm"
addendum = 0.9
support.radial = "3.8e9 N/m"
[stages.main.carrier]
mass = "7.77 kg"
inertia = "0.0474 kg m^2"
support.radial = "7.5e8 N/m"
[stages.main.meshes]
sun-planet.backlash = "100 um"
planet-ring.backlash = "100 um"
[operation]
held = ["ring"]
speed.sun = "3000 rpm"
power.sun = "20 kW"
"""


def train(tmp_path: Path, *, planets: int = 3, sun: int = 30, damping: float = 0.02, more: str = "") -> System:
    """A set with equal branches whose planets mesh in phase where N divides the teeth of its sun."""
    path = tmp_path / "train.toml"
    text = TRAIN.format(planets=planets, sun=sun, ring=sun + 42, damping=damping)
    path.write_text(text + more, encoding="utf-8")
    return epicyclic.assemble(load(path))


@pytest.fixture(scope="module")
def through_1880(tmp_path_factory: pytest.TempPathFactory) -> tuple[System, NDArray[np.float64], Refinement, BranchSet]:
    """A train, speeds below and above 1880 Hz, and its branches there."""
    system = train(tmp_path_factory.mktemp("train"))
    speeds = np.array([1805.35, 1879.49, 1956.69]) / float(system.tones[0])
    refinement = Refinement(ready=response(system, asks_laws=True))
    return system, speeds, refinement, branch_set(refinement, speeds)


@pytest.mark.parametrize("unstable", ["replace", "report"])
def test_equal_meshes_with_unequal_forces_are_a_broken_symmetry(through_1880: Any, made: Any, unstable: Any) -> None:
    """A coast-down through 1880 Hz, where the symmetric motion grows quasi-periodically."""
    if unstable == "replace":
        pytest.importorskip("numba")
    system, speeds, refinement, branches = through_1880
    found = contact_sweep(system, SweepOptions(relative_speed=speeds, unstable=unstable))
    sun = found.mesh_force_rms.values[:, :3]
    unequal = np.ptp(sun, axis=1) > 1e-2 * sun.max(axis=1)
    np.testing.assert_array_equal(found.motion.values == "symmetry broken", unequal)
    assert unequal.any() == (unstable == "replace")
    reached = dict(sweep_direction(refinement, branches, upward=False, unstable=unstable))
    at = reached[1].motion
    assert isinstance(at, Solution)
    assert (at.kind == "symmetry broken") == (unstable == "replace")
    # its image, turned by one branch of a train in phase, comes back after a cycle of the equation integrated
    equation, (symmetry,) = made.equation(system, float(speeds[1])), system.symmetries
    start = (initial_state(at) @ symmetry.operator.T).ravel()
    end = equation.run(start, 1, rtol=1e-8, atol=1e-13)[:, -1]
    n = len(system.M)
    if at.stable:
        assert np.abs(end - start)[:n].max() < 1e-3 * np.abs(start[:n]).max()


@pytest.mark.parametrize(("planets", "sun"), [(3, 30), (4, 21), (4, 23), (5, 24)])
def test_branches_in_turn_keep_their_symmetry(tmp_path: Path, planets: int, sun: int) -> None:
    """Phases of whole parts of a cycle: forces of equal meshes are the same, one after the other."""
    system = train(tmp_path, planets=planets, sun=sun, damping=0.05)
    assert system.symmetries[0].holds
    refinement = Refinement(ready=response(system, asks_laws=True))
    (crossing,) = branch_set(refinement, np.array([1.3])).crossings[0]
    assert not symmetry_is_broken(refinement, crossing.solution)
    # moved at random, branches are no longer images of each other
    state = crossing.solution.state
    shaken = state.y.copy()
    shaken[:, 1] += 1e-2 * np.linalg.norm(shaken[:, 1:]) * np.random.default_rng(0).standard_normal(shaken.shape[2])
    other = replace(crossing.solution, state=replace(state, y=shaken), residual=1.0)
    assert symmetry_is_broken(refinement, other)


def test_a_pin_off_its_place_breaks_the_train_and_not_the_motion(tmp_path: Path) -> None:
    system = train(tmp_path, damping=0.05, more='[deviations]\nplanet.position.y = "[20, 0, 0] um"\n')
    refinement = Refinement(ready=response(system, asks_laws=True))
    (crossing,) = branch_set(refinement, np.array([1.3])).crossings[0]
    assert not symmetry_is_broken(refinement, crossing.solution)
    found = contact_sweep(system, SweepOptions(relative_speed=[1.3], unstable="report", shaft_orders=False))
    force = found.mesh_force_peak.values[0, :3, 0]
    assert np.ptp(force) > 1e-2 * force.max()
    assert set(found.motion.values.ravel()) == {"periodic"}
