"""Extremes, time apart and impacts over every step of a run, whatever samples are kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.questions.transient import TransientOptions, integrators
from epicyclic.questions.transient.integrators import steps_for
from epicyclic.questions.transient.scenario import Scenario, scenario_motion
from epicyclic.questions.transient.transient import transient as unbounded
from epicyclic.questions.transient.views import tables
from epicyclic.system.system import System

OVER_ALL = ("mesh_force_peak", "mesh_force_peak_time", "mesh_force_minimum", "mesh_force_minimum_time")
CONTACT = ("contact_lost", "open_share", "far_share", "impacts")
STEP: dict[str, Any] = {"cycles": 2, "torque_step": (-0.5, 0.002)}


@pytest.fixture(scope="module")
def system(torsional_set: Callable[..., dict[str, Any]]) -> System:
    """A set whose torque turns round: teeth cross their backlash and strike the other flank."""
    meshes: dict[str, Any] = {"sun_planet": {"backlash": 2e-5, "damping": 2e3}, "planet_ring": {"backlash": 2e-5}}
    return epicyclic.assemble(epicyclic.load(torsional_set(modal=0.02, **meshes)))


@pytest.fixture(scope="module")
def every_step(system: System) -> xr.Dataset:
    """So many samples that each is one step."""
    found = epicyclic.transient(system, **STEP, samples=768)
    scenario = Scenario(duration=float(found.time[-1]), speed=(1.0, 1.0))
    assert steps_for(scenario_motion(system, scenario, contact="unilateral", step=1e-5), float(found.time[1])) == 1
    return found


@pytest.mark.parametrize("numba", [True, False], ids=["compiled", "numpy"])
def test_steps_between_samples_count(
    monkeypatch: pytest.MonkeyPatch, system: System, every_step: xr.Dataset, numba: bool
) -> None:
    if not numba:
        monkeypatch.setattr(integrators, "numba_available", lambda: False)
    few = epicyclic.transient(system, **STEP, samples=768, decimate=96)
    force = every_step.mesh_force
    assert np.array_equal(few.mesh_force[:, 0], force[:, 0])
    # an impact stands between the samples: without it the extremes were those of the samples
    assert (few.mesh_force_minimum < few.mesh_force.min("time") - 100).all()
    # the forces of the samples come from the laws, those of the steps from the integrator: two routes
    np.testing.assert_allclose(few.mesh_force_minimum, force.min("time"), rtol=1e-9)
    np.testing.assert_allclose(few.mesh_force_peak, force.max("time"), rtol=1e-9)
    at = every_step.time[force.argmin("time")]
    np.testing.assert_allclose(few.mesh_force_minimum_time, at, rtol=1e-9)
    steps = force.values[:, :-1]
    apart = steps == 0
    np.testing.assert_allclose(few.open_share, apart.mean(axis=1), atol=1e-9)
    np.testing.assert_allclose(few.far_share, (steps < 0).mean(axis=1), atol=2e-3)  # a damper pulls for a step
    assert few.impacts.values.tolist() == (apart[:, :-1] & ~apart[:, 1:]).sum(axis=1).tolist()
    assert few.impacts.values.min() >= 1
    assert few.contact_lost.all()


def test_compiled_and_numpy_tallies_agree(monkeypatch: pytest.MonkeyPatch, system: System) -> None:
    pytest.importorskip("numba")
    fast = epicyclic.transient(system, **STEP, decimate=32)
    monkeypatch.setattr(integrators, "numba_available", lambda: False)
    slow = epicyclic.transient(system, **STEP, decimate=32)
    for name in (*OVER_ALL, *CONTACT):
        np.testing.assert_allclose(fast[name], slow[name], rtol=1e-6, atol=1e-12, err_msg=name)


def test_extremes_of_adaptive_steps(system: System) -> None:
    fixed = epicyclic.transient(system, **STEP, samples=768, decimate=96)
    adaptive = epicyclic.transient(system, **STEP, method="dop853", samples=16)
    assert (adaptive.mesh_force_minimum < adaptive.mesh_force.min("time") - 100).all()
    # steps of the two stand elsewhere on the impact
    np.testing.assert_allclose(adaptive.mesh_force_minimum, fixed.mesh_force_minimum, rtol=0.05)
    np.testing.assert_allclose(adaptive.open_share, fixed.open_share, rtol=0.05)
    assert adaptive.impacts.values.tolist() == fixed.impacts.values.tolist()


def test_a_linear_model_has_no_impacts(system: System) -> None:
    found = epicyclic.transient(system, **STEP, contact="linear", decimate=32)
    assert "impacts" not in found
    assert "open_share" not in found
    assert found.contact_lost.all()


def test_nothing_parts_in_a_steady_run(system: System) -> None:
    found = epicyclic.transient(system, cycles=3)
    for name in ("contact_lost", "open_share", "far_share", "impacts"):
        assert not found[name].any(), name
    np.testing.assert_allclose(found.mesh_force_peak, found.mesh_force.max("time"), rtol=1e-12)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("factor", [1000.0])
def test_no_warnings_of_numpy_reach_a_user(system: System, factor: float) -> None:
    found = unbounded(system, TransientOptions(cycles=2, torque_step=(factor, 0.001)))  # the verb refuses such a factor
    columns = tables(found)[0].columns
    assert max(columns["most [N]"]) > 1e5
