"""`stiffness`: phases and means of the mesh stiffness over a mesh cycle."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.flanks.contact_resolution import stiffness_history


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return epicyclic.stiffness("ren2021", samples=240)


def test_mean(result: xr.Dataset) -> None:
    mean = result.mesh_stiffness.mean("mesh_phase")
    # harmonics below the 240th average out to rounding
    np.testing.assert_allclose(mean, result.mean_mesh_stiffness, rtol=1e-12)


def test_phase_is_a_lead(result: xr.Dataset) -> None:
    first = result.mesh_stiffness.sel(mesh="main/sun-planet/1/left").values
    second = result.mesh_stiffness.sel(mesh="main/sun-planet/2/left").values
    lead = float(result.phase_lead.sel(mesh="main/sun-planet/2/left"))
    assert lead == pytest.approx(1 / 3, abs=1e-15)  # a float next to 1/3
    # k_2(t) = k_1(t + lead T): what 1 does later, 2 does now; the other sense differs by a third of the variation
    np.testing.assert_allclose(second, np.roll(first, -80), rtol=1e-12)
    assert np.abs(second - np.roll(first, 80)).max() > 0.1 * np.ptp(first)


def test_series_of_one_mesh() -> None:
    mesh = epicyclic.load("ren2021").meshes[0]
    phase = np.array([0.0, 0.25])
    order = np.arange(1, len(mesh.variation) + 1)
    expected = [
        mesh.stiffness * (1 + sum((mesh.variation * np.exp(2j * np.pi * order * mesh.sense * t)).real)) for t in phase
    ]
    np.testing.assert_allclose(stiffness_history(mesh, phase), expected, rtol=1e-13)  # rounding of the sum


def test_more_samples_than_memory_holds_are_refused() -> None:
    with pytest.raises(ModelError, match="would need some") as error:
        epicyclic.stiffness("ren2021", samples=2_000_000_000)
    assert error.value.path == "samples"
    assert "at most" in error.value.allowed
