"""Modes far slower than the fastest: rigid is what strains no row, and a soft spring makes a mode that is not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

import epicyclic
from epicyclic.questions.modes.eigen import damping_ratios, eigen, mean_modes, whirl
from epicyclic.questions.modes.modal import modal
from epicyclic.system.system import System, free_motions, stiffness_rows
from epicyclic.train.train import Train

Array = NDArray[np.float64]


def held_softly(build: Any, spring: float, **more: Any) -> System:
    """Lin & Parker's set whose carrier is held against rotation by a spring [N/m] at its radius."""
    system: System = build.planar(torsion=(0.0, 1e9, spring), **more).system()
    return system


def rayleigh(system: System, spring: float, radius: float) -> float:
    """omega^2 of the rotation that strains nothing but one soft spring: its energy over the inertia of the motion."""
    rows = np.concatenate([system.meshes.B, system.links.B[:, system.links.stiffness > 1e5]], axis=1)
    motion = scipy.linalg.null_space((rows / np.linalg.norm(rows, axis=0)).T, rcond=1e-9)
    assert motion.shape[1] == 1
    turn = motion[system.dofs.names.index("main/carrier/rz"), 0] * radius
    return float(spring * turn**2 / (motion[:, 0] @ system.M @ motion[:, 0]))


@pytest.mark.parametrize("spring", [1e2, 1e-2, 1e-6, 1e-10])
def test_a_soft_spring_is_no_rigid_motion(build: Any, spring: float) -> None:
    system = held_softly(build, spring)
    squared = eigen(system).omega_squared
    assert squared[0] == pytest.approx(rayleigh(system, spring, 0.0884), rel=1e-5)
    assert squared[1] > 1e-4 * squared[-1]
    free = eigen(held_softly(build, 0.0))
    assert free.omega_squared[0] == 0.0
    # the others do not know of the spring
    np.testing.assert_allclose(squared[1:], free.omega_squared[1:], rtol=1e-5)


def test_two_soft_motions_stay_two(build: Any) -> None:
    """Frequencies 1e4 apart, both lost in rounding of the largest omega^2: shapes, kinds and energies are their own."""
    system = held_softly(build, 1e-6, lateral=(1e-2, 1e-2, 1e-2, 1e8))
    result = modal(system)
    frequency, energy = result.frequency.values, result.strain_energy_share
    assert frequency[0] > 0.0
    np.testing.assert_allclose(frequency[1], frequency[2], rtol=1e-6)
    assert frequency[1] > 100 * frequency[0]
    assert list(result.mode_kind.values[:3]) == ["rotational", "translational", "translational"]
    assert float(energy.sel(connection="main/carrier/support")[0]) == pytest.approx(1.0, abs=1e-6)
    assert frequency[3] == pytest.approx(frequency[4], rel=1e-6)
    gram = eigen(system).vectors.T @ system.M @ eigen(system).vectors
    np.testing.assert_allclose(gram, np.eye(len(gram)), atol=1e-10)


def test_what_else_the_stiffness_holds_counts(build: Any) -> None:
    """A stiffness that is no link, as of a System written by hand, holds a motion too."""
    system = held_softly(build, 0.0)
    place = system.dofs.names.index("main/carrier/rz")
    K = system.K.copy()
    K[place, place] += 1e-2
    rows = stiffness_rows(replace(system, K=K))
    assert rows is not None
    np.testing.assert_allclose(rows @ rows.T, replace(system, K=K).mean_stiffness, rtol=0, atol=1e-6 * K.max())
    free, _ = free_motions(np.concatenate([system.meshes.B, system.links.B[:, system.links.stiffness > 0]], axis=1))
    assert free.shape[1] == 1
    assert np.abs(system.meshes.B.T @ free).max() < 1e-12
    negative = replace(system, links=replace(system.links, stiffness=-system.links.stiffness))
    assert stiffness_rows(negative) is None


def test_damping_and_whirl_of_a_soft_mode(build: Any) -> None:
    spring = 1e-2
    system = replace(held_softly(build, spring), zeta=0.02)
    modes = eigen(system)
    assert damping_ratios(system, modes)[0] == pytest.approx(0.02)
    slow = whirl(system, relative_speed=0.0, damped=True).mu[0]
    assert abs(slow) == pytest.approx(float(modes.omega[0]), rel=1e-3)


def test_a_spread_beyond_double_precision_is_warned_of(build: Any) -> None:
    wide, usual = modal(held_softly(build, 1e-16)), modal(held_softly(build, 1e2))
    assert "double precision has them right to" in str(wide.attrs["warnings"])
    assert "double precision" not in str(usual.attrs["warnings"])


def on_a_soft_shaft(stiffness: str) -> Train:
    """A ready drive with a flywheel at its sun."""
    wheel = {"mass": "1 kg", "inertia": "500 kg m^2"}
    coupling = {"between": ["main.sun", "wheel"], "rz": stiffness}
    return epicyclic.load("lin1999-n4", overrides={"bodies.wheel": wheel, "couplings.soft": coupling})


def test_a_train_on_a_soft_coupling_has_its_mode() -> None:
    """A flywheel on a shaft a billion times softer than a mesh: f = sqrt(k / I) / 2 pi beside the train's inertia."""
    train = on_a_soft_shaft("1e-4 N m/rad")
    result = epicyclic.modes(train)
    frequency = result.frequency.values
    assert np.count_nonzero(frequency == 0) == 1
    squared, _ = mean_modes(epicyclic.assemble(train))
    assert np.count_nonzero(squared == 0) == 1
    stiffer = epicyclic.modes(on_a_soft_shaft("4e-4 N m/rad"))
    assert stiffer.frequency.values[1] == pytest.approx(2 * frequency[1], rel=1e-5)
    found = epicyclic.sensitivity(train, paths=["stages.main.planet.mass"])
    np.testing.assert_allclose(found.frequency.values, frequency, rtol=1e-9)
    assert list(found.ranked_by.values[:3]) == [False, True, False]  # by the lowest elastic mode
