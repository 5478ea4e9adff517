"""A ring that bends in every verb: linear and nonlinear answers are those of one train, as of rigid bodies."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

import epicyclic
from epicyclic.train.train import Train

WIND = {"stages.main.ring.elastic": {"modes": 6}, "damping.modal": 0.06}
PLAIN: dict[str, object] = {
    **WIND,
    "deviations": None,
    "tolerance": None,
    "loads": None,
    "operation.gravity": False,
}
SLOW = PLAIN | {"operation.speed.carrier": "0.015 rpm", "stages.main.helix_angle": "0 deg"}
BENT = [f"main/ring/{part}{n}" for n in range(2, 7) for part in "ab"]


@cache
def stage() -> Train:
    return epicyclic.load("wind-stage", PLAIN)


def lines(waves: Any, samples: int) -> NDArray[np.complex128]:
    """Amplitudes of the first mesh orders of waves (.., samples) over one mesh cycle."""
    return np.asarray(np.fft.rfft(np.asarray(waves)[:, -samples:], axis=1)[:, :9] / samples)


def test_steady_at_a_thousandth_of_the_speed_is_static() -> None:
    # of spur teeth the stiffness varies most
    slow = epicyclic.load("wind-stage", SLOW)
    steady, static = epicyclic.steady(slow), epicyclic.static(slow, cycles=1, samples=64)
    for name, at in (("mesh_force", {}), ("displacement", {"dof": BENT})):
        one, other = (lines(result[name].sel(at).values, 64) for result in (steady, static))
        varies = np.abs(other[:, 1:]).max()
        assert varies > 3e-4 * np.abs(other).max()
        np.testing.assert_allclose(one, other, atol=3e-3 * varies)  # harmonics left out


def test_motion_in_time_and_contact_loss_are_the_steady_response() -> None:
    steady = epicyclic.steady(stage())
    run = epicyclic.transient(stage(), cycles=50, samples=64).isel(time=slice(None, -1))
    loss = epicyclic.steady(stage(), contact_loss=True)
    runs = [("mesh_force", {}, run), ("displacement", {"dof": BENT}, run), ("mesh_force", {}, loss)]
    for name, at, result in runs:
        wanted, samples = np.abs(lines(steady[name].sel(at).values, 64)), loss.sizes["mesh_phase"]
        found = np.abs(lines(result[name].sel(at).values, samples if result is loss else 64))
        np.testing.assert_allclose(found[:, 1:], wanted[:, 1:], atol=1e-4 * wanted[:, 1:].max())
        np.testing.assert_allclose(found[:, 0], wanted[:, 0], atol=1e-6 * wanted.max())


def test_matrices_reproduce_the_modes_at_speed_and_energies_sum_to_one() -> None:
    modes, matrices = epicyclic.modes(stage(), relative_speed=1.0), epicyclic.matrices(stage())
    M, G, K = (matrices[name].values for name in ("M", "G", "K"))
    zero, one = np.zeros_like(M), np.eye(len(M))
    state = np.block([[zero, one], [-scipy.linalg.solve(M, K), -scipy.linalg.solve(M, G)]])
    found = np.sort(np.abs(np.linalg.eigvals(state).imag))[::2] / (2 * np.pi)
    np.testing.assert_allclose(found[1:], np.sort(modes.frequency.values)[1:], rtol=1e-7)
    assert [str(name) for name in matrices.full_coordinate.values[-10:]] == BENT
    np.testing.assert_allclose(modes.kinetic_energy_share.sum("body"), 1.0, rtol=1e-12)
    elastic = modes.frequency > 0
    np.testing.assert_allclose(modes.strain_energy_share.sum("connection")[elastic], 1.0, rtol=1e-12)
    assert modes.kinetic_energy_share.sel(body="main/ring").max() > 0.99


def test_the_rim_moves_frequencies_as_its_derivative_says() -> None:
    found = epicyclic.sensitivity(stage(), paths=["stages.main.ring.rim"]).isel(path=0)
    assert found.parameter_unit == "mm"
    up, down = (
        epicyclic.modes(epicyclic.load("wind-stage", PLAIN | {"stages.main.ring.rim": f"{130 + step} mm"}))
        for step in (0.05, -0.05)
    )
    moved = (up.frequency.values - down.frequency.values) / 0.1
    assert np.abs(moved).max() > 1
    np.testing.assert_allclose(found.derivative.values, moved, atol=1e-5 * np.abs(moved).max())


def test_a_toleranced_train_is_the_train_that_it_draws(tmp_path: Path) -> None:
    found = epicyclic.tolerance(
        epicyclic.load("wind-stage", WIND), samples=256, effects="none", worst=tmp_path / "worst"
    )
    first = sorted((tmp_path / "worst").iterdir())[0]
    assert any(body.elastic for body in epicyclic.load(first).bodies)
    sharing = epicyclic.sharing(first, method="static", cycles=1, samples=2).sel(definition="mean-load")
    assert float(sharing.system_load_sharing) == pytest.approx(float(found.worst_k_gamma[0]), rel=1e-9)
    np.testing.assert_allclose(sharing.load_sharing.values, found.worst_load_sharing[0].values, rtol=1e-9)


def test_a_soft_ring_shares_the_load_better() -> None:
    """What the pin is off bends the ring in place of loading one mesh."""
    rigid, bent = (
        epicyclic.sharing(epicyclic.load("wind-stage", over), method="static", cycles=1, samples=2)
        for over in (
            {"stages.main.ring.support.radial": "inf"},
            WIND | {"stages.main.ring.support.radial": "inf", "stages.main.ring.rim": "40 mm"},
        )
    )
    worst = [float(one.system_load_sharing.sel(definition="mean-load")) for one in (rigid, bent)]
    assert worst[1] - 1 < 0.9 * (worst[0] - 1)
