"""The compiled path: the same numbers as numpy to the tolerance, the same residual tests, and nothing without numba."""

from __future__ import annotations

import sys
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import xarray as xr

from epicyclic.errors import ModelError
from epicyclic.questions.response import balance
from epicyclic.questions.response import response as engine
from epicyclic.questions.response.response import respond, response
from epicyclic.questions.response.steady import SweepOptions, sweep
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

SPEEDS = np.linspace(0.3, 2.5, 13)
CURVES = ("mesh_force_rms", "mesh_force_peak", "mesh_force_minimum", "amplitude")


@pytest.fixture(scope="module")
def system(case: Any) -> System:
    """All kinds of terms: G, Kg, Cskew, dampers off the diagonal, mesh dampers, modal damping, shaft orders."""
    lines = (
        case.line(Fraction(0), [2e-6, -1e-6]),
        case.line(Fraction(137), [3e-6, 2e-6j], push=40),
        case.line(Fraction(274, 7), [5e-6, 4e-6j], push=60, cause="deviations.a"),
        case.line(Fraction(137, 2), [2e-6j, 1e-6], cause="deviations.half"),
    )
    made: System = case.pair(lines=lines)
    return made


def assert_same(left: xr.Dataset, right: xr.Dataset, *, rtol: float) -> None:
    for name in CURVES:
        size = float(np.abs(left[name]).max())
        np.testing.assert_allclose(left[name], right[name], rtol=0, atol=rtol * size, err_msg=name)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
def test_numba_and_numpy_give_the_same_numbers(system: System, tolerance: float) -> None:
    pytest.importorskip("numba")
    numpy, numba = (
        sweep(system, SweepOptions(relative_speed=SPEEDS, tolerance=tolerance, compiled=c)) for c in (False, True)
    )
    # both leave a residual below the tolerance; near a resonance of 3 % damping the response is 1/(2 zeta) = 17 times
    # as large as the residual, which is relative to the response: 20 times the tolerance holds everywhere
    assert_same(numpy, numba, rtol=20 * tolerance)
    assert list(numpy.harmonics.values) == list(numba.harmonics.values)
    assert numba.residual.max() <= 30 * tolerance


def test_a_ready_drive_with_run_outs_too() -> None:
    pytest.importorskip("numba")
    train = assemble(load("ren2021"))
    speeds = np.linspace(20, 600, 4)
    numpy, numba = (
        sweep(train, SweepOptions(mesh_frequency=speeds, tolerance=1e-10, compiled=c)) for c in (False, True)
    )
    # rounding is relative to the mean torque, some 1e-12 after cancellation; the residual of 1e-10 is what is left
    assert_same(numpy, numba, rtol=1e-9)


def test_raised_harmonics_start_from_the_solution_with_fewer(case: Any) -> None:
    pytest.importorskip("numba")
    orders = np.arange(1, 31)
    saw = np.tile(0.5 * np.sinc(0.6 * orders) * np.exp(1j * orders), (2, 1))
    base = case.pair(swing=0.2)
    sharp = replace(base, meshes=replace(base.meshes, variation=saw))
    numpy, numba = (
        sweep(sharp, SweepOptions(relative_speed=[0.1, 3.0], tolerance=1e-9, compiled=c)) for c in (False, True)
    )
    assert numba.harmonics.values[0] > numba.harmonics.values[1]
    assert_same(numpy, numba, rtol=2e-8)


def test_points_do_not_know_of_each_other_and_bad_ones_harm_none(system: System) -> None:
    pytest.importorskip("numba")
    speeds = [1.0, np.nan, 0.0, 1e200, 1.5]
    result = sweep(system, SweepOptions(relative_speed=speeds, compiled=True))
    assert list(result.status.values)[2:4] == ["speed is not a number above zero", "not finite"]
    for place in (0, 4):
        alone = sweep(system, SweepOptions(relative_speed=[speeds[place]], compiled=True))
        # the same solution; the RMS of a batch is one matrix product, summed in an order of its own
        np.testing.assert_allclose(result.mesh_force_rms[:, place], alone.mesh_force_rms[:, 0], rtol=1e-14)


def test_the_residual_reported_is_the_true_one(system: System) -> None:
    pytest.importorskip("numba")
    ready = response(system, compiled=True)
    loose = next(respond(ready, np.array([1.0]), tolerance=1e-3))
    tight = next(respond(ready, np.array([1.0]), tolerance=1e-11))
    rows = loose.mesh.y.shape[2]
    gap = np.linalg.norm(loose.mesh.y - tight.mesh.y[:, :, :rows]) / loose.mesh.scale[0]
    # the error is the residual seen through the inverse of an operator near the identity
    assert 0.1 * loose.mesh.residual[0] < gap < 30 * loose.mesh.residual[0]


@pytest.fixture
def without_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.delitem(sys.modules, "epicyclic.questions.response.compiled", raising=False)


@pytest.mark.usefixtures("without_numba")
def test_without_numba_everything_works_and_asking_for_it_is_refused(
    system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine, "_WORTH", 0)
    plain = sweep(system, SweepOptions(relative_speed=[1.0]))
    np.testing.assert_array_equal(
        plain.mesh_force_rms, sweep(system, SweepOptions(relative_speed=[1.0], compiled=False)).mesh_force_rms
    )
    with pytest.raises(ModelError, match=r"epicyclic\[fast\]"):
        sweep(system, SweepOptions(relative_speed=[1.0], compiled=True))


def test_large_jobs_are_compiled_and_small_ones_not(system: System, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("numba")
    seen = []

    def spy(*given: Any, **options: Any) -> Any:
        seen.append(options["operators"] is not None)
        return balance.solve(*given, **options)

    monkeypatch.setattr(engine, "solve", spy)
    sweep(system, SweepOptions(relative_speed=[1.0, 1.1]))
    assert set(seen) == {False}
    seen.clear()
    monkeypatch.setattr(engine, "_WORTH", 100)
    sweep(system, SweepOptions(relative_speed=[1.0, 1.1]))
    assert set(seen) == {True}


def test_points_unconverged_in_single_go_on_in_double(system: System, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("numba")
    from epicyclic.questions.response import compiled

    solve = compiled.solve_points

    def early(*given: Any, **options: Any) -> Any:
        return solve(*given, **options | {"tolerance": 1e-2})

    whole = sweep(system, SweepOptions(relative_speed=SPEEDS, tolerance=1e-10, compiled=True))
    monkeypatch.setattr(compiled, "solve_points", early)
    result = sweep(system, SweepOptions(relative_speed=SPEEDS, tolerance=1e-10, compiled=True))
    assert set(result.status.values) == {"ok"}
    # residuals of 1e-10, at most 1/(2 zeta) = 17 times that in the response
    assert_same(whole, result, rtol=2e-9)
