"""Run-up and coast-down with contact loss against time integration that is carried from speed to speed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import epicyclic
from epicyclic.engine import workers
from epicyclic.errors import ModelError
from epicyclic.questions.contact_loss import solutions as refinement_module
from epicyclic.questions.contact_loss.branch_set import branch_set, periodic_measures
from epicyclic.questions.contact_loss.continuation import linear_start
from epicyclic.questions.contact_loss.solutions import (
    Refinement,
    Solution,
    Stability,
    floquet_stability,
    solution,
    with_stability,
)
from epicyclic.questions.contact_loss.sweep import _several_motions, contact_sweep
from epicyclic.questions.contact_loss.sweep_direction import initial_state
from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.response import critical_speed, response
from epicyclic.questions.response.steady import sweep as linear_sweep
from epicyclic.results.dataset import load_result, save_result, to_json
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System, faces
from epicyclic.train.resolution import load

Array = NDArray[np.float64]
SPEEDS = np.array([0.75, 0.82, 0.9])


def spur_like(made: Any) -> System:
    """A pair whose stiffness jumps between one and two pairs of teeth, with pitch errors, on the edge of parting."""
    system: System = made.single(variation=(0.2, 0.08j, -0.03), error={1: -1e-6}, zeta=0.08, load=2000.0, backlash=1e-4)
    return system


def integrated_on(made: Any, system: System, speeds: Array) -> Iterator[float]:
    """RMS of the mesh force at one speed after another, each run from where the last one ended."""
    state = np.array([1e-5, 0.0])
    for speed in speeds:
        equation = made.equation(system, float(speed))
        # disturbances decay by exp(-0.5) a cycle of the natural frequency: 16 mesh cycles leave less than 4e-4
        state = equation.run(state, 16, rtol=1e-6, atol=1e-11)[:, -1]
        yield float(equation.force(equation.run(state, 1, samples=256, rtol=1e-6, atol=1e-11)).std())


@pytest.fixture(scope="module")
def swept(made: Any) -> xr.Dataset:
    return contact_sweep(spur_like(made), SweepOptions(relative_speed=SPEEDS))


def test_run_up_and_coast_down_are_what_time_integration_says(made: Any, swept: xr.Dataset) -> None:
    system = spur_like(made)
    rms = swept.mesh_force_rms.values[:, 0]
    up = np.array(list(integrated_on(made, system, SPEEDS)))
    down = np.array(list(integrated_on(made, system, SPEEDS[::-1])))[::-1]
    # 16 to 48 harmonics are right to 3e-4, the transient left to 4e-4, of an RMS of the size of the load
    np.testing.assert_allclose(rms[0], up, rtol=3e-3)
    np.testing.assert_allclose(rms[1], down, rtol=3e-3)
    # between the folds they differ by far more than that
    assert np.max(np.abs(rms[0] - rms[1]) / rms[1]) > 0.5
    assert swept.stable.values.all()
    assert swept.jumped.sum() >= 2
    assert (swept.status == "ok").all()


def test_the_way_holds_every_branch(swept: xr.Dataset) -> None:
    assert swept.sizes["fold"] == 2
    low, high = sorted(swept.fold_frequency.values)
    unstable = ~swept.path_stable.values
    inside = swept.path_frequency.values[unstable]
    assert inside.size > 3
    assert np.all((inside > low - 1) & (inside < high + 1))
    assert set(swept.path_instability.values[unstable]) == {"fold"}
    at = swept.path_frequency.values
    middle = (low + high) / 2
    assert np.count_nonzero(np.diff(np.sign(at - middle))) == 3


def test_closed_teeth_are_the_linear_sweep(made: Any) -> None:
    system = made.bench(scale=1.0)
    speeds = [0.6, 0.75, 3.5]
    ours, linear = (
        contact_sweep(system, SweepOptions(relative_speed=speeds)),
        linear_sweep(system, SweepOptions(relative_speed=speeds)),
    )
    assert not ours.contact_open.any()
    for name in ("mesh_force_rms", "mesh_force_peak", "mesh_force_minimum", "amplitude"):
        for direction in ("up", "down"):
            here = ours[name].sel(direction=direction).values
            # both to 1e-6 of the dynamic part; extremes by a parabola through samples, 128 of a cycle or more
            np.testing.assert_allclose(here, linear[name].values, atol=2e-4 * np.abs(here).max(), rtol=0)


def test_speeds_in_any_order_and_wrong_ones_do_not_poison(made: Any, swept: xr.Dataset) -> None:
    order = np.array([0.9, np.nan, 0.75, -1.0, 0.82, 0.82])
    mixed = contact_sweep(spur_like(made), SweepOptions(relative_speed=order, harmonics=16))
    assert list(mixed.status.sel(direction="up").values) == [
        "ok",
        "speed is not a number above zero",
        "ok",
        "speed is not a number above zero",
        "ok",
        "ok",
    ]
    assert np.isnan(mixed.mesh_force_rms.values[:, 0, [1, 3]]).all()
    at = [int(np.flatnonzero(SPEEDS == speed)[0]) for speed in (0.9, 0.75)]
    # 16 harmonics everywhere against as many as needed
    np.testing.assert_allclose(
        mixed.mesh_force_rms.values[0, 0, [0, 2]], swept.mesh_force_rms.values[0, 0, at], rtol=3e-3
    )


def test_without_stability_a_run_follows_its_branch(made: Any) -> None:
    quick = contact_sweep(spur_like(made), SweepOptions(relative_speed=SPEEDS, unstable="ignore"))
    assert np.isnan(quick.largest_multiplier).all()
    assert (quick.motion == "periodic").all()
    assert np.isfinite(quick.mesh_force_rms).all()


SLID = {"stages.main.sun.support.z": "inf", "stages.main.planet.bearing.z": "inf", "deviations.sun.position.z": "1 mm"}


def test_unstable_motions_are_reported() -> None:
    reported = epicyclic.sweep("xu2020", mesh_frequency=[1500.0, 3000.0, 3600.0], contact_loss=True, unstable="report")
    linear = epicyclic.stability("xu2020", mesh_frequency=[1500.0, 3000.0, 3600.0])
    assert list(reported.motion.values.ravel()) == ["periodic"] * 6
    at = reported.sel(direction="up")
    assert not at.contact_open.values[:, 2].any()
    assert at.stable.values[2] == linear.stable.values[2] == np.False_
    assert at.branch_instability.values[2] == linear.instability.values[2] == "quasi-periodic"
    # closed teeth are the linear system: the same 24 steps, summed in another order
    assert at.largest_multiplier.values[2] == pytest.approx(linear.largest_multiplier.values[2], rel=1e-9)
    assert at.branch_instability.values[1] == ""


def test_stability_of_a_point_is_computed_once(made: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def counted(refinement: Refinement, at: Solution) -> Stability:
        asked.append(at.state)
        return floquet_stability(refinement, at)

    monkeypatch.setattr(refinement_module, "floquet_stability", counted)
    contact_sweep(spur_like(made), SweepOptions(relative_speed=SPEEDS, unstable="report"))
    assert len(set(asked)) == len(asked) > len(SPEEDS)


def test_a_side_that_stays_open_needs_no_branch() -> None:
    """A slide of 1 mm opens the left teeth of the sun: a linear motion of all others, which the torus solver finds."""
    slid = epicyclic.sweep(
        "xu2020", overrides=SLID, mesh_frequency=[300.0, 500.0], contact_loss=True, unstable="report"
    )
    left = np.array(["sun" in str(name) and str(name).endswith("left") for name in slid.mesh.values])
    assert (slid.contact_open.values[:, left] == 1).all()
    assert (slid.contact_open.values[:, ~left] == 0).all()
    assert (slid.sizes["fold"], slid.sizes["path"]) == (0, 2)  # the two linear motions, no branch between
    other = epicyclic.steady("xu2020", overrides=SLID, contact_loss=True, relative_speed=500 / (95 * 17.3 / 60))
    # both are right to 1e-6 of the dynamic part, and 3e-4 of it with the harmonics each keeps
    np.testing.assert_allclose(
        slid.mesh_force_rms.values[0, :, 1], other.mesh_force_rms, atol=3e-4 * float(other.mesh_force_rms.max())
    )


def test_a_branch_that_begins_at_a_speed_asked_for(made: Any) -> None:
    system = made.single(variation=(0.2,), zeta=0.05, load=2000.0)
    one = contact_sweep(system, SweepOptions(relative_speed=[1.0], unstable="ignore"))
    assert one.status.values.tolist() == [["ok"], ["ok"]]
    assert one.contact_open.max() > 0.05


def test_it_is_saved_and_loaded(swept: xr.Dataset, tmp_path: Any) -> None:
    xr.testing.assert_identical(load_result(save_result(swept, tmp_path / "a.nc")), swept)


def test_a_ready_drive_that_parts_is_what_time_integration_says(made: Any) -> None:
    """Steadily, at a stable point: DOP853 from its state is back after a cycle, with the same mesh forces."""
    system = assemble(load("xu2020"))
    refinement = Refinement(ready=response(system))
    given, tone = refinement.problem(32), float(system.tones[0])
    y = linear_start(given, 1600.0 / tone)
    for frequency in (1600.0, 1580.0, 1560.0, 1540.0):
        speed = frequency / tone
        at = solution(refinement, y, speed, balance=given, harmonics=32, fixed=True)
        assert at is not None
        y = at.state.y
    assert at is not None
    at = with_stability(refinement, at)
    assert at.stable
    measures = periodic_measures(system, at.balance, at.state)
    assert measures.open.max() > 0.05
    equation = made.equation(system, speed)
    start = initial_state(at).ravel()
    states = equation.run(start, 1, samples=at.balance.grid.counts[0], rtol=1e-6, atol=1e-11)
    force = faces(system.meshes).total(equation.force(states))
    # 32 harmonics of a force with corners
    assert force.std(axis=1) == pytest.approx(measures.rms, rel=2e-3)


def test_no_backlash_on_the_far_side_is_fine(made: Any) -> None:
    one = contact_sweep(made.single(variation=(0.2,), zeta=0.05, load=2000.0), SweepOptions(relative_speed=[0.8, 1.0]))
    assert (one.status == "ok").all()
    assert (one.mesh_force_minimum > -1e-9).all()
    assert one.contact_open.max() > 0.05


@pytest.mark.parametrize(
    ("system", "options", "path"),
    [
        ({"zeta": None}, {"relative_speed": [1.0]}, "damping"),
        ({}, {"relative_speed": []}, "mesh_frequency"),
        ({}, {"relative_speed": [1.0], "mesh_frequency": [1000.0]}, ""),
        ({}, {"relative_speed": [1.0], "harmonics": 0}, "harmonics"),
        ({}, {"relative_speed": [1.0], "frame_speed": "fast"}, "frame_speed"),
        ({}, {"relative_speed": [1.0], "unstable": "hide"}, "unstable"),
    ],
)
def test_wrong_input_is_refused(made: Any, system: dict[str, Any], options: dict[str, Any], path: str) -> None:
    with pytest.raises(ModelError) as caught:
        epicyclic.sweep(made.single(**system), contact_loss=True, **options)
    assert path in str(caught.value)


def test_motions_found_ahead_on_several_cores_have_the_bits_of_one(made: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    # a pair near twice its natural frequency, where its stiffness shakes it most
    system = made.single(variation=(0.045,), zeta=0.008, load=1130.0, backlash=5e-5)
    speeds = np.array([1.99, 2.0, 2.01])
    one = contact_sweep(system, SweepOptions(relative_speed=speeds))
    assert (one.motion == "period 2").any()
    monkeypatch.setenv("EPICYCLIC_JOBS", "2")
    monkeypatch.setattr(workers, "_WORTH", {"fork": 0.0, "spawn": 0.0})
    steps = list[tuple[int, int]]()
    two = contact_sweep(system, SweepOptions(relative_speed=speeds), progress=lambda *step: steps.append(step))
    assert to_json(one) == to_json(two)
    assert steps == [(count + 1, 6) for count in range(6)]


def test_a_speed_without_a_steady_motion_holds_nan_and_a_warning_says_so(made: Any) -> None:
    system = made.coupled(far=False, load=3000.0)
    system = made.replace(system, Kg=-2e5 * np.eye(6))
    critical = critical_speed(response(system))[0]
    found = contact_sweep(system, SweepOptions(relative_speed=[0.5 * critical, 3.0 * critical]))
    for direction in found.status.values:
        assert list(direction) == ["ok", "mean system unstable"]
    assert np.isnan(found.mesh_force_rms.values[..., 1]).all()
    assert np.isfinite(found.mesh_force_rms.values[..., 0]).all()
    assert "the centripetal terms exceed" in str(found.attrs["warnings"])


def test_a_direction_that_fell_among_several_stable_motions_says_so(made: Any) -> None:
    """A softening oscillator has two stable motions between its folds at 755 and 978 Hz, and one elsewhere."""
    system = made.single(variation=(0.045,), zeta=0.008, load=1130.0, backlash=5e-5)
    curves: dict[str, Any] = {"motion": np.full((2, 4), "periodic", object), "jumped": np.zeros((2, 4), bool)}
    refinement = Refinement(ready=response(system))
    branches = branch_set(refinement, np.array([0.7, 0.9, 0.94, 1.1]))
    curves["jumped"][1, 3] = True
    (text,) = _several_motions(refinement, branches, curves)
    assert "direction down" in text
    assert "at 2 points from 900 to 940 Hz up to 2 stable motions" in text
    curves["jumped"][1] = [True, False, False, False]
    assert not _several_motions(refinement, branches, curves)
