"""Sweeps: the same numbers as one speed at a time, and one bad point never poisons the others."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import xarray as xr

from epicyclic.errors import ModelError
from epicyclic.questions.response import SteadyOptions, SweepOptions
from epicyclic.questions.response.measures import periodic
from epicyclic.questions.response.response import respond, response
from epicyclic.questions.response.steady import steady, sweep
from epicyclic.results.dataset import to_json
from epicyclic.system.system import System

SPEEDS = np.linspace(0.3, 2.5, 23)


@pytest.fixture(scope="module")
def system(case: Any) -> System:
    lines = (
        case.line(Fraction(137), [3e-6, 2e-6j], push=40),
        case.line(Fraction(274, 7), [5e-6, 4e-6j], push=60, cause="deviations.a"),
        case.line(Fraction(137 * 5, 7), [2e-6, 1e-6j], cause="deviations.b"),
        case.line(Fraction(137, 2), [2e-6j, 1e-6], cause="deviations.half"),
    )
    made: System = case.pair(lines=lines)
    return made


def test_a_sweep_is_one_steady_response_after_another(system: System) -> None:
    result = sweep(system, SweepOptions(relative_speed=SPEEDS))
    assert set(result.status.values) == {"ok"}
    for i in (0, 9, 22):
        alone = steady(system, SteadyOptions(relative_speed=SPEEDS[i]))
        # the sweep drops harmonics below 1e-4 of the dynamic part, which its RMS feels squared and its peak directly
        np.testing.assert_allclose(result.mesh_force_rms[:, i], alone.mesh_force_rms, rtol=1e-6)
        np.testing.assert_allclose(result.mesh_force_peak[:, i], alone.mesh_force_bound, rtol=1e-4)
        np.testing.assert_allclose(result.mesh_force_minimum[:, i], alone.mesh_force_minimum, rtol=1e-4)
    np.testing.assert_allclose(result.mesh_frequency, 137 * SPEEDS)


def test_without_shaft_orders_only_the_mesh_orders_count(system: System) -> None:
    result = sweep(system, SweepOptions(relative_speed=[1.0], shaft_orders=False))
    found = periodic(system, samples=4096)
    np.testing.assert_allclose(result.mesh_force_rms[:, 0], found.force.std(axis=1), rtol=1e-6)
    # the harmonics dropped, 1e-4 of the dynamic part, show directly in a peak
    np.testing.assert_allclose(result.mesh_force_peak[:, 0], found.force.max(axis=1), rtol=1e-4)
    np.testing.assert_allclose(result.mesh_force_minimum[:, 0], found.force.min(axis=1), rtol=1e-4)
    stroke = np.ptp(found.displacement, axis=1) / 2 * system.dofs.radius
    np.testing.assert_allclose(result.amplitude[:, 0], stroke, rtol=1e-4)


def test_peaks_with_shaft_orders_bound_the_whole_record(case: Any, system: System) -> None:
    result = sweep(system, SweepOptions(relative_speed=[1.0]))
    found = periodic(system, samples=128)
    times = np.arange(14 * 128) / (137 * 128)
    phases = np.arange(14 * 128) % 128
    signal, moved = found.force[:, phases], found.displacement[:, phases]
    for line in found.lines:
        carrier = np.exp(2j * np.pi * float(line.frequency) * times)
        signal = signal + (line.force[:, phases] * carrier).real
        moved = moved + (line.displacement[:, phases] * carrier).real
    # fourteen cycles are the whole period: the RMS of all time is exact up to the harmonics dropped
    np.testing.assert_allclose(result.mesh_force_rms[:, 0], signal.std(axis=1), rtol=1e-6)
    assert np.all(result.mesh_force_peak[:, 0] >= signal.max(axis=1))
    assert np.all(result.mesh_force_minimum[:, 0] <= signal.min(axis=1))
    half = np.ptp(moved, axis=1) / 2 * system.dofs.radius
    # the rigid rotation is driven slowly and far by the shaft lines: the bound is close, never below
    assert np.all(result.amplitude[:, 0] >= half * (1 - 1e-6))


def test_frame_speed_fixed_at_operation_differs_away_from_it(system: System) -> None:
    turning = sweep(system, SweepOptions(relative_speed=[1.0, 2.2], shaft_orders=False))
    fixed = sweep(system, SweepOptions(relative_speed=[1.0, 2.2], shaft_orders=False, frame_speed="operating"))
    np.testing.assert_allclose(turning.mesh_force_rms[:, 0], fixed.mesh_force_rms[:, 0], rtol=1e-9)
    assert np.abs(turning.mesh_force_rms / fixed.mesh_force_rms - 1)[:, 1].max() > 1e-3
    frozen = replace(system, G=system.G / 2.2, Kg=system.Kg / 2.2**2, Cskew=system.Cskew / 2.2)
    same = sweep(frozen, SweepOptions(relative_speed=[2.2], shaft_orders=False))
    np.testing.assert_allclose(same.mesh_force_rms[:, 0], fixed.mesh_force_rms[:, 1], rtol=1e-6)


def test_points_that_fail_hold_nan_and_a_status_and_the_rest_goes_on(system: System) -> None:
    speeds = [1.0, np.nan, 0.0, 1e200, -1.0, 1.5]
    result = sweep(system, SweepOptions(relative_speed=speeds))
    status = list(result.status.values)
    assert status[0] == status[5] == "ok"
    assert status[1] == status[2] == status[4] == "speed is not a number above zero"
    assert status[3] == "not finite"
    assert "no motion was found at 1 of 6 speeds" in result.attrs["warnings"]
    assert np.isnan(result.mesh_force_rms.values[:, 1:5]).all()
    np.testing.assert_allclose(
        result.mesh_force_rms[:, [0, 5]],
        sweep(system, SweepOptions(relative_speed=[1.0, 1.5])).mesh_force_rms,
        rtol=1e-9,
    )


def test_the_residual_reported_is_the_true_one(system: System) -> None:
    ready = response(system)
    loose, tight = (next(respond(ready, np.array([1.0]), tolerance=tolerance)) for tolerance in (1e-3, 1e-11))
    rows = loose.mesh.y.shape[2]
    gap = np.linalg.norm(loose.mesh.y - tight.mesh.y[:, :, :rows]) / loose.mesh.scale[0]
    # the error is the residual seen through the inverse of an operator near the identity
    assert 0.1 * loose.mesh.residual[0] < gap < 30 * loose.mesh.residual[0]


def test_raised_harmonics_end_where_more_of_them_begin(case: Any) -> None:
    """Of a saw-tooth stiffness a slow speed needs more harmonics; what they start from leaves no trace."""
    orders = np.arange(1, 31)
    saw = np.tile(0.5 * np.sinc(0.6 * orders) * np.exp(1j * orders), (2, 1))
    base = case.pair(swing=0.2)
    sharp = replace(base, meshes=replace(base.meshes, variation=saw))
    raised, direct = (
        sweep(sharp, SweepOptions(relative_speed=[0.1, 3.0], tolerance=tolerance)) for tolerance in (1e-9, 1e-12)
    )
    assert raised.harmonics.values[0] > raised.harmonics.values[1]
    np.testing.assert_allclose(raised.mesh_force_rms, direct.mesh_force_rms, rtol=2e-8)


def test_progress_counts_every_point_and_an_interrupt_passes(system: System) -> None:
    seen: list[tuple[int, int]] = []
    sweep(system, SweepOptions(relative_speed=SPEEDS), progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (23, 23)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)

    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(system, SweepOptions(relative_speed=SPEEDS), progress=stop)


def test_the_default_range_covers_every_natural_frequency(system: System) -> None:
    # without centripetal terms, which make the pair whirl far above its operating speed
    result = sweep(replace(system, Kg=np.zeros_like(system.Kg)), SweepOptions(shaft_orders=False))
    assert result.sizes["speed"] == 200
    assert set(result.status.values) == {"ok"}
    assert result.mesh_frequency.values[0] < 137 < result.mesh_frequency.values[-1]


def test_harmonics_rise_where_the_stiffness_needs_them(case: Any) -> None:
    orders = np.arange(1, 31)
    saw = np.tile(0.5 * np.sinc(0.6 * orders) * np.exp(1j * orders), (2, 1))
    base = case.pair(swing=0.2)
    sharp = replace(base, meshes=replace(base.meshes, variation=saw))
    result = sweep(sharp, SweepOptions(relative_speed=[0.1, 3.0], shaft_orders=False))
    assert result.harmonics.values[0] > result.harmonics.values[1] >= 8
    fine = [periodic(sharp, relative_speed=s, tolerance=1e-11).force.std(axis=1) for s in (0.1, 3.0)]
    np.testing.assert_allclose(result.mesh_force_rms.values.T, fine, rtol=1e-5)


def test_a_result_goes_through_json(system: System) -> None:
    result = sweep(system, SweepOptions(relative_speed=SPEEDS[:3]))
    again = xr.Dataset.from_dict(json.loads(to_json(result)))
    np.testing.assert_array_equal(again.mesh_force_peak, result.mesh_force_peak)
    assert list(again.status.values) == ["ok"] * 3


def test_options_that_contradict_or_do_not_exist_are_refused(system: System) -> None:
    with pytest.raises(ModelError, match="not both"):
        sweep(system, SweepOptions(relative_speed=[1.0], mesh_frequency=[100.0]))
    meshes = replace(system.meshes, damping=np.zeros(2))
    bare = replace(system, zeta=None, C=np.zeros((6, 6)), meshes=meshes)
    with pytest.raises(ModelError, match="no damping"):
        sweep(bare, SweepOptions(relative_speed=[1.0]))


def test_tensile_mesh_force_names_the_meshes(case: Any) -> None:
    loud = case.pair(lines=(case.line(Fraction(137), [2e-3, 2e-3]),))
    warnings = sweep(loud, SweepOptions(relative_speed=[0.5, 1.0])).attrs["warnings"]
    assert "tensile mesh force" in warnings
    assert "main/a-b/1" in warnings
