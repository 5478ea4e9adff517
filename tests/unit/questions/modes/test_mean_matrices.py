"""Matrices for other programs: reopened by SciPy and NumPy, they move as the package's own linear systems do."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.io import loadmat
from scipy.signal import StateSpace, lsim

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.results.files import save_matrices


@pytest.fixture(scope="module")
def system() -> epicyclic.System:
    """A herringbone train with constant mesh stiffness: its own answers are those of the mean linear system."""
    found = epicyclic.assemble(epicyclic.load("ren2021", overrides={"damping.mesh": 0.002}))
    found = replace(found, zeta=0.03)  # of a file one or the other
    still = np.zeros((len(found.meshes.name), 0), complex)
    return replace(found, meshes=replace(found.meshes, variation=still), far=None)


@pytest.fixture(scope="module")
def result(system: epicyclic.System) -> xr.Dataset:
    return epicyclic.matrices(system)


@pytest.fixture(scope="module")
def mat(result: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The file as SciPy opens it."""
    found: dict[str, Any] = loadmat(save_matrices(result, tmp_path_factory.mktemp("mat") / "train.mat"))
    return found


def state_space(mat: dict[str, Any], inputs: Any) -> StateSpace:
    """Loads on the right side through `inputs` (n, u) -> gaps of the meshes and their rates, (2 m,)."""
    n, solve = len(mat["M"]), np.linalg.solve
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-solve(mat["M"], mat["K"]), -solve(mat["M"], mat["C"] + mat["G"])]])
    B = np.vstack([np.zeros_like(inputs), solve(mat["M"], inputs)])
    out = np.zeros_like(mat["B"].T)
    gaps = np.block([[mat["B"].T, out], [out, mat["B"].T]])
    return StateSpace(A, B, gaps, np.zeros((len(gaps), inputs.shape[1])))


def test_files_hold_the_dataset(result: xr.Dataset, mat: dict[str, Any], tmp_path: Path) -> None:
    with np.load(save_matrices(result, tmp_path / "train.npz")) as arrays:  # without pickle
        assert set(map(str, result.variables)) <= set(arrays.files)
        for name in map(str, result.variables):
            values = result[name].values
            assert np.array_equal(arrays[name], values if values.dtype.kind in "fc" else values.astype(str))
    for name in map(str, result.data_vars):
        if result[name].dtype.kind in "fc":
            assert np.array_equal(mat[name].reshape(result[name].shape), result[name].values)
            assert mat[name].ndim == 2
    assert [str(cell[0]) for cell in mat["dof"].ravel()] == list(result["dof"].values)
    assert str(mat["title"][0]) == result.attrs["title"]
    names = [name for name in mat if not name.startswith("__")]
    assert all(re.fullmatch(r"[A-Za-z]\w{0,62}", name) for name in names)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["train.npz"]
    with pytest.raises(ModelError, match=r"\.mat or \.npz"):
        save_matrices(result, tmp_path / "train.m")


def test_shapes_and_units(result: xr.Dataset) -> None:
    n, bodies = result.sizes["dof"], result.sizes["body"]
    assert {result[name].shape for name in "MCGK"} == {(n, n)}
    assert result["T"].shape == (6 * bodies, n)
    assert result["B"].shape == (n, result.sizes["mesh_row"])
    units = dict(zip(result["coordinate_direction"].values, result["coordinate_unit"].values, strict=True))
    assert units == {"x": "m", "y": "m", "z": "m", "rz": "rad"}
    # a torque on a body through T is one at its port
    ports = [list(result["full_coordinate"].values).index(port) for port in result["port"].values]
    assert np.array_equal(result["T"].values[ports].T, result["F"].values)
    assert np.allclose(result["F"].values @ result["port_torque"].values, result["load"].values)


def stepped(mat: dict[str, Any], place: int, count: int) -> tuple[Any, Any]:
    """Mesh forces (count + 1, m) [N] over a period of a line of excitation as SciPy steps them, and the instants."""
    frequency, load = mat["excitation_frequency"].ravel()[place], mat["excitation"][:, place]
    stiffness, damping, m = mat["mesh_stiffness"].ravel(), mat["mesh_damping"].ravel(), mat["B"].shape[1]
    omega = 2 * np.pi * frequency
    model = state_space(mat, np.stack([load.real, load.imag], axis=1))
    state = np.linalg.solve(1j * omega * np.eye(len(model.A)) - model.A, model.B @ [1, 1j])
    wave = np.exp(1j * omega * (time := np.linspace(0, 1 / frequency, count + 1)))
    _, gaps, _ = lsim(model, np.stack([wave.real, -wave.imag], axis=1), time, X0=state.real)
    error = mat["gap_error"][:, place] * wave[:, None]
    force = stiffness * (gaps[:, :m] - error.real) + damping * (gaps[:, m:] - (1j * omega * error).real)
    return force, wave


def test_harmonic_response_is_the_packages_own(system: epicyclic.System, mat: dict[str, Any]) -> None:
    own = epicyclic.steady(system)
    frequencies = mat["excitation_frequency"].ravel()
    assert system.zeta
    assert mat["mesh_damping"].all()
    assert np.count_nonzero(frequencies) == 4
    largest = np.abs(own["line_force"].values).max()
    for place in np.flatnonzero(frequencies).tolist():
        at = np.flatnonzero(own["line_frequency"].values == frequencies[place])
        amplitude = own["line_force"][:, at[0], 0] if at.size else own["mesh_force_harmonic"].sel(harmonic=1)
        force, wave = stepped(mat, place, 4000)
        expected = (amplitude.values * wave[:, None]).real
        # both per the largest amplitude of all lines, as the residual of the balance
        assert force[0] == pytest.approx(expected[0], abs=1e-8 * largest)
        # the load is a straight line between two of the 4000 instants: of second order
        assert np.abs(force - expected).max() < 1e-4 * largest


def test_a_torque_step_is_that_of_transient(system: epicyclic.System) -> None:
    quiet = replace(system, lines=())
    instant = 1 / float(system.tones[0]) / 128
    options: dict[str, Any] = {"cycles": 0.5, "contact": "linear", "samples": 128, "method": "dop853"}
    own = epicyclic.transient(quiet, torque_step=(1.5, 8 * instant), **options)
    arrays = {str(name): one.values for name, one in epicyclic.matrices(quiet).variables.items()}
    model = state_space(arrays, 0.5 * arrays["load"][:, None])
    time = own["time"].values
    _, gaps, _ = lsim(model, np.ones_like(time), time)
    m = len(arrays["mesh_stiffness"])
    force = gaps[:, :m] * arrays["mesh_stiffness"] + gaps[:, m:] * arrays["mesh_damping"]
    found = own["mesh_force"].transpose("time", "mesh").values
    expected = found[8:] - found[0]
    assert np.ptp(expected, axis=0).min() > 1e4
    # tolerance of the package's integrator
    assert np.abs(force[: len(expected)] - expected).max() < 1e-6 * np.abs(expected).max()


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_eigenvalues_are_those_of_modes(system: epicyclic.System, speed: float) -> None:
    found = epicyclic.matrices(system, relative_speed=speed)
    one = state_space({str(name): found[name].values for name in found.variables}, found["F"].values)
    damped = np.sort(np.abs(np.linalg.eigvals(one.A).imag))[::-1][::2] / (2 * np.pi)
    own = np.sort(epicyclic.modes(system, relative_speed=speed, damped=True)["frequency"].values)[::-1]
    assert damped[: len(own) - 1] == pytest.approx(own[:-1], rel=1e-6)
