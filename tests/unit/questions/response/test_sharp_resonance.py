"""Resonances of light damping: against a dense solution, and refused where they have no number."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.questions.response import SteadyOptions, SweepOptions
from epicyclic.questions.response.balance import sharpened
from epicyclic.questions.response.steady import steady, sweep
from epicyclic.system.system import System

Array = NDArray[np.float64]


def light(case: Any, zeta: float, **changes: Any) -> System:
    """The pair of gears with modal damping alone."""
    pair: System = case.pair(zeta=zeta, mesh_damping=0.0, free=False, **changes)
    return replace(pair, C=np.zeros_like(pair.C), Cskew=np.zeros_like(pair.Cskew))


def natural(system: System) -> tuple[Array, Array]:
    """Angular natural frequencies of the mean system, and modes of unit mass."""
    squared, modes = scipy.linalg.eigh(system.mean_stiffness, system.M)
    return np.sqrt(squared), modes


def dense_rms(system: System, speed: float, harmonics: int) -> Array:
    """RMS of the mesh forces without their mean, by elimination in the coordinates of the bodies."""
    omega, modes = natural(system)
    n, w = len(omega), 2 * np.pi * float(system.tones[0]) * speed
    H, count = harmonics, 2 * harmonics + 1
    damper = system.M @ modes * (2 * (system.zeta or 0.0) * omega) @ modes.T @ system.M + speed * system.G
    meshes = system.meshes
    series = np.zeros((len(meshes.name), 2 * count + 1), complex)  # of k(t), from -count to count
    series[:, count] = meshes.stiffness
    for order, value in enumerate((meshes.stiffness[:, None] * meshes.variation / 2).T, start=1):
        series[:, count + order], series[:, count - order] = value, value.conj()
    waves = np.array([scipy.linalg.toeplitz(row[count : 2 * count], row[count::-1][:count]) for row in series])
    rows = np.einsum("iR,RhH,jR->hiHj", meshes.B, waves, meshes.B)
    error, force = np.zeros((count, len(meshes.name)), complex), np.zeros((count, n), complex)
    force[H] += system.force
    for line in system.lines:
        order, push = round(line.frequency / system.tones[0]), np.array([1.0, speed, speed**2]) @ line.force
        for sign in (1, -1) if order else (1,):
            share = 0.5 if order else 1.0
            error[H + sign * order] += share * (line.gap if sign > 0 else line.gap.conj())
            force[H + sign * order] += share * (push if sign > 0 else push.conj())
    for h in range(count):
        a = (h - H) * w
        rows[h, :, h] += system.K + speed**2 * system.Kg - a**2 * system.M + 1j * a * damper
    force += np.einsum("RhH,HR->hR", waves, error) @ meshes.B.T
    motion = np.linalg.solve(rows.reshape(count * n, -1), force.ravel()).reshape(count, n)
    mesh = np.einsum("RhH,HR->hR", waves, motion @ meshes.B - error)
    return np.asarray(np.sqrt(np.sum(np.abs(np.delete(mesh, H, axis=0)) ** 2, axis=0)))


@pytest.mark.parametrize("offset", [0.0, 1e-15, 1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("zeta", [1e-13, 1e-8])
def test_at_a_natural_frequency_of_the_mean_system(case: Any, zeta: float, offset: float) -> None:
    """Varying stiffness and gyroscopic terms move the resonance: at the mean one the response stays finite."""
    system = light(case, zeta)
    speed = natural(system)[0][2] / (2 * np.pi * float(system.tones[0])) * (1 + offset)
    found = sweep(system, SweepOptions(relative_speed=[speed]))
    assert found.status.values[0] == "ok"
    expected = dense_rms(system, speed, int(found.harmonics.values[0]) + 6)
    np.testing.assert_allclose(found.mesh_force_rms.values[:, 0], expected, rtol=2e-4)


def test_resonance_of_a_constant_stiffness(case: Any) -> None:
    """At its top in closed form while double precision knows the natural frequency, else nan and why."""
    made = {zeta: light(case, zeta, swing=0.0, turning=0.0) for zeta in (1e-7, 1e-15)}
    speed = natural(made[1e-7])[0][2] / (2 * np.pi * float(made[1e-7].tones[0]))
    found = sweep(made[1e-7], SweepOptions(relative_speed=[speed]))
    assert found.status.values[0] == "ok"
    np.testing.assert_allclose(found.mesh_force_rms.values[:, 0], dense_rms(made[1e-7], speed, 4), rtol=1e-6)
    for offset in (0.0, 1e-14):
        refused = sweep(made[1e-15], SweepOptions(relative_speed=[speed * (1 + offset)]))
        assert refused.status.values[0] == "resonance too sharp for double precision"
        assert np.isnan(refused.mesh_force_rms.values).all()
    with pytest.raises(ConvergenceError, match="so sharp that double precision"):
        steady(made[1e-15], SteadyOptions(relative_speed=speed))


def test_a_small_residual_in_a_resonant_coordinate_is_resolved() -> None:
    """A residual that is small beside the whole motion is a large error of a resonance that is hardly excited."""
    rng = np.random.default_rng(3)
    modes, frequency = np.array([1.0, 2.0, 5.0]) * 1e3, np.array([0.0, 2e3])
    modal: Any = SimpleNamespace(squared=modes**2, damping=2e-9 * modes, rigid=np.zeros(3, dtype=bool))
    resonant = [1 * 3 + 1, 3 * 3 + 1]  # real and imaginary part of the second mode at the second frequency
    matrix = np.eye(12) + 1e-3 * rng.normal(size=(12, 12))
    matrix[:, resonant] *= 1e-9
    matrix[resonant, resonant] = 1e-6
    true = rng.normal(size=12)
    rough = true + np.where(np.isin(np.arange(12), resonant), 1e-3, 0.0)
    right = (matrix @ true)[None]
    before = np.linalg.norm(right - rough @ matrix.T)
    found, left, bound = sharpened(
        modal, lambda x: x @ matrix.T, right, rough.reshape(1, 2, 2, 3), frequency, mean=False, tolerance=1e-6
    )
    error = np.linalg.norm(found.ravel() - true) / np.linalg.norm(true)
    assert before < 1e-8
    assert left < before
    assert error <= bound < 1e-4


def test_zero_damping_is_no_damping(case: Any) -> None:
    for zeta in (0.0, None):
        with pytest.raises(ModelError, match="damping") as caught:
            steady(replace(light(case, 0.0), zeta=zeta), SteadyOptions())
        assert caught.value.path == "damping"
