"""The steady response with contact loss as a Dataset: against the linear one, with slices, from the command line."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import xarray as xr
from known import sliced_xu2020
from numpy.typing import NDArray
from typer.testing import CliRunner

import epicyclic
from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.questions.contact_loss.steady import contact_steady
from epicyclic.questions.contact_loss.sweep import contact_sweep
from epicyclic.questions.contact_loss.torus import respond_torus
from epicyclic.questions.response import SteadyOptions, SweepOptions
from epicyclic.questions.response.steady import steady
from epicyclic.questions.transient import TransientOptions
from epicyclic.questions.transient.equation import constant, motion
from epicyclic.questions.transient.integrators import integrate
from epicyclic.questions.transient.transient import mesh_force, transient
from epicyclic.show.elements import force_table
from epicyclic.system.system import System, faces

F = Fraction
Train = Callable[..., System]


def at(system: System, frequency: float) -> float:
    """Relative speed at a mesh frequency [Hz]."""
    return frequency / float(system.tones[0])


def test_a_ready_drive_that_stays_in_contact_is_the_linear_response() -> None:
    linear, ours = epicyclic.steady("ren2021"), epicyclic.steady("ren2021", contact_loss=True)
    # tolerances of both, 1e-8 and 1e-6 of the motion
    np.testing.assert_allclose(ours.mesh_force_rms, linear.mesh_force_rms, rtol=1e-5)
    # extremes are samples refined by parabolas in both
    np.testing.assert_allclose(ours.mesh_force_bound, linear.mesh_force_bound, rtol=1e-4)
    np.testing.assert_allclose(ours.mesh_force_minimum, linear.mesh_force_minimum, rtol=1e-4)
    assert not ours.contact_lost.any()
    assert not ours.open_share.any()
    assert not ours.far_share.any()
    assert ours.status.item() == "ok"
    wave = linear.mesh_force.interp(mesh_phase=ours.mesh_phase.values[:-8])
    # linear interpolation between 64 samples of a cycle
    np.testing.assert_allclose(ours.mesh_force[:, :-8], wave, rtol=2e-3)


def _two_tones(train: Train, load: float, slow: Sequence[tuple[Fraction, complex]] = ()) -> System:
    """Two mesh frequencies whose response needs more combinations than a balance of contact keeps."""
    system = train(ratio=F(3, 7), slow=slow, load=load, swing=0.4)
    meshes = replace(system.meshes, stiffness=system.meshes.stiffness * [1.0, 30.0])
    return replace(system, zeta=0.01, meshes=meshes)


def test_two_mesh_frequencies_in_contact_are_the_linear_response(train: Train) -> None:
    system = _two_tones(train, 2e4, [(F(1, 31), 1e-6)])
    linear, ours = (
        steady(system, SteadyOptions(relative_speed=0.3)),
        contact_steady(system, SteadyOptions(relative_speed=0.3)),
    )
    # truncation residual of the linear response; the torus is 9e-3 away
    np.testing.assert_allclose(ours.mesh_force_rms, linear.mesh_force_rms, rtol=1e-4)
    # one looks at 256 samples of a phase, the other at 45; the torus is 2e-2 away
    np.testing.assert_allclose(ours.mesh_force_bound, linear.mesh_force_bound, rtol=5e-3)
    assert ours.residual_dropped.item() < 1e-4
    assert not ours.contact_lost.any()
    assert json.loads(ours.attrs["warnings"]) == []


def _integrated(system: System, speed: float, *, steps: int, settle: int) -> NDArray[np.float64]:
    """Force of every mesh (w, N) [N] over 7 cycles, a common period of both mesh frequencies, after 7 x settle."""
    tone, cycles = float(system.tones[0]) * speed, 7
    moving, begin = motion(system, program=constant(speed)), 7 * settle
    state = integrate(moving, np.zeros((2, 5)), stop=begin / tone, steps=begin * steps, keep=begin * steps)[0][-1]
    states = integrate(moving, state, start=begin / tone, stop=(begin + cycles) / tone, steps=cycles * steps)[0]
    return mesh_force(moving, np.linspace(begin / tone, (begin + cycles) / tone, len(states))[:-1], states[:-1])


def test_two_mesh_frequencies_in_contact_are_time_integration(train: Train) -> None:
    pytest.importorskip("numba")
    system = _two_tones(train, 2e4)
    force, ours = (
        _integrated(system, 0.3, steps=512, settle=20),
        contact_steady(system, SteadyOptions(relative_speed=0.3)),
    )
    np.testing.assert_allclose(ours.mesh_force_rms, force.std(axis=1), rtol=1e-3)
    # every instant lies between the extremes over all phases
    assert np.all(force.max(axis=1) <= ours.mesh_force_bound.values * 1.001)


def test_rows_dropped_are_measured_on_the_linear_response(train: Train) -> None:
    pytest.importorskip("numba")
    system = _two_tones(train, 600.0)
    result = contact_steady(system, SteadyOptions(relative_speed=1.5))
    assert result.contact_lost.any()
    (warning,) = [text for text in json.loads(result.attrs["warnings"]) if text.startswith("rows dropped")]
    rms, largest = (float(value) for value in re.findall(r"up to ([0-9.e-]+) in .* and ([0-9.e-]+) in", warning)[0])
    assert rms >= 0.99 * float(result.residual_dropped)  # two digits are printed
    assert largest > 2 * rms
    # integration bears both out: 6.6e-3 and 3.8e-2
    force = _integrated(system, 1.5, steps=256, settle=60)
    assert np.abs(result.mesh_force_rms.values / force.std(axis=1) - 1).max() == pytest.approx(rms, rel=0.5)
    assert np.abs(result.mesh_force_bound.values / force.max(axis=1) - 1).max() == pytest.approx(largest, rel=0.5)


def test_shares_of_contact_are_those_of_the_sweep_and_of_integration(train: Train) -> None:
    """Teeth that fly between both flanks: apart means on neither, in every verb."""
    pytest.importorskip("numba")
    system = train(load=30.0, backlash=3e-6)
    ours = contact_steady(system, SteadyOptions(relative_speed=2.3))
    tone = 2.3 * float(system.tones[0])
    settled = transient(system, TransientOptions(cycles=200, mesh_frequency=tone, samples=64))
    moved = transient(system, TransientOptions(cycles=50, mesh_frequency=tone, samples=64, initial=settled))
    swept = contact_sweep(system, SweepOptions(relative_speed=[2.3], unstable="report"))
    # one sample of 192, of 64, of 256; steps of the integration tally the same
    np.testing.assert_allclose(ours.open_share, moved.open_share, atol=2e-2)
    np.testing.assert_allclose(ours.far_share, moved.far_share, atol=2e-2)
    np.testing.assert_allclose(ours.open_share, swept.contact_open.values[0, :, 0], atol=1e-2)
    assert (ours.open_share > 0.05).all()
    assert (ours.far_share > 0.3).all()
    assert (ours.contact_lost & moved.contact_lost).all()


def test_what_parts_is_said_and_saved(train: Train, tmp_path: Any) -> None:
    system = train(slow=[(F(1, 13), 5e-6), (F(1, 9), 4e-6)], load=600.0)
    result = contact_steady(system, SteadyOptions(relative_speed=2.0))
    assert result.open_share.values[0] > 0.05
    assert result.contact_lost.values[0]
    assert np.all(result.mesh_force_least <= result.mesh_force + 1e-9)
    assert np.all(result.mesh_force <= result.mesh_force_most + 1e-9)
    assert np.all(result.mesh_force_bound >= result.mesh_force_most.max("mesh_phase") - 1e-9)
    # the mean load is what the torque asks for: 600 N on the first mesh, whatever parts (Newton's tolerance)
    assert result.mesh_force[0].mean().item() == pytest.approx(600.0, rel=1e-5)
    labels = [str(label) for label in result.combination.values]
    assert labels[0] == "mean"
    assert "+1 main" in labels
    amplitude = result.combination_force.values
    assert amplitude[0, labels.index("mean")].real == pytest.approx(600.0, rel=1e-5)
    # the mean over the slow phases holds the mesh orders alone, at their phases
    wave = 2 * np.fft.rfft(result.mesh_force.values[0]) / result.sizes["mesh_phase"]
    assert amplitude[0, labels.index("+1 main")] == pytest.approx(wave[1], rel=1e-3)
    spectrum = 0.5 * (np.abs(amplitude[0, 1:]) ** 2).sum()
    # Parseval: the lattice points hold all but what was dropped
    assert np.sqrt(spectrum) == pytest.approx(result.mesh_force_rms.values[0], rel=1e-2)
    path = tmp_path / "steady.nc"
    epicyclic.save_result(result, path)
    xr.testing.assert_allclose(epicyclic.load_result(path), result)


def test_lines_that_found_no_phase_are_named(train: Train) -> None:
    system = train(slow=[(F(1, 27), 1e-6), (F(3, 7), 1e-6)])
    both = contact_steady(system, SteadyOptions(relative_speed=2.0))
    one = contact_steady(system, SteadyOptions(relative_speed=2.0, shaft_tones=1))
    assert json.loads(one.attrs["options"])["shaft_tones"] == 1
    assert json.loads(both.attrs["warnings"]) == []
    (warning,) = json.loads(one.attrs["warnings"])
    assert "run-out" in warning
    assert "superposed" in warning
    # which the answer bears out: 1 um is a fifth of the deflection under load
    np.testing.assert_allclose(one.mesh_force_rms, both.mesh_force_rms, rtol=0.02)
    none = contact_steady(system, SteadyOptions(relative_speed=2.0, shaft_orders=False))
    assert json.loads(none.attrs["warnings"]) == []


def test_contact_is_lost_where_a_superposed_line_pulls(train: Train) -> None:
    """The motion of mesh orders parts the first mesh alone; a line of 0.1 mm has more force than the other carries."""
    for size, pulls in ((1e-6, False), (1e-4, True)):
        found = contact_steady(train(slow=[(F(1, 27), size)]), SteadyOptions(relative_speed=2.0, shaft_tones=0))
        table = force_table(found).columns
        np.testing.assert_allclose(table["least [N]"], found.mesh_force_least.min("mesh_phase"))
        assert (table["least [N]"][1] < 0) == pulls
        assert table["contact lost"] == ["yes", "yes" if pulls else "no"]
        assert (found.open_share.values > 0).tolist() == [True, False]
        assert ("transient or static shows them" in found.attrs["warnings"]) == pulls


@pytest.mark.parametrize("options", [{"relative_speed": 0.0}, {"relative_speed": np.nan}, {"shaft_tones": 4}])
def test_options_out_of_range(train: Train, options: dict[str, Any]) -> None:
    with pytest.raises(ModelError, match="out of range"):
        epicyclic.steady(train(), contact_loss=True, **options)


def test_without_damping_it_is_refused(train: Train) -> None:
    with pytest.raises(ModelError, match="damping"):
        contact_steady(replace(train(), zeta=None), SteadyOptions())


def test_no_solution_is_an_error(train: Train, monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*given: Any, **options: Any) -> Any:
        return replace(respond_torus(*given, **options), converged=False)

    monkeypatch.setattr("epicyclic.questions.contact_loss.steady.respond_torus", lost)
    with pytest.raises(ConvergenceError, match="2000 Hz"):
        contact_steady(train(slow=[(F(1, 13), 5e-6)]), SteadyOptions(relative_speed=2.0))


def test_a_torus_that_is_not_found_leaves_its_lines_superposed(train: Train, monkeypatch: pytest.MonkeyPatch) -> None:
    """No Newton steps on the torus: the mesh orders stand, and the lines say what they are worth."""
    system = train(slow=[(F(1, 27), 1e-6), (F(3, 7), 1e-6)])
    right = contact_steady(system, SteadyOptions(relative_speed=2.0))
    monkeypatch.setattr("epicyclic.questions.contact_loss.torus._STEPS", 0)
    result = contact_steady(system, SteadyOptions(relative_speed=2.0))
    warnings = json.loads(result.attrs["warnings"])
    assert len(warnings) == 2
    assert all("superposed" in text for text in warnings)
    np.testing.assert_allclose(result.mesh_force_rms, right.mesh_force_rms, rtol=0.02)


def test_slices_converge_and_add_up() -> None:
    """8 slices within 0.5 % of 32, where teeth part; one row of a mesh in one piece is 2e-3 away."""
    eight, many = (
        contact_steady(system, SteadyOptions(relative_speed=at(system, 1200.0)))
        for system in (sliced_xu2020(8), sliced_xu2020(32))
    )
    assert eight.open_share.max() > 0.1
    np.testing.assert_allclose(eight.mesh_force_rms, many.mesh_force_rms, rtol=5e-3)
    np.testing.assert_allclose(eight.mesh_force_bound, many.mesh_force_bound, rtol=5e-3)
    summed = faces(sliced_xu2020(8).meshes).total(eight.slice_force.values)
    # sums of eight numbers
    np.testing.assert_allclose(summed, eight.mesh_force, rtol=1e-9, atol=1e-6)


def test_a_tilt_loads_one_end_of_the_face() -> None:
    straight, tilted = (
        contact_steady(system, SteadyOptions(relative_speed=at(system, 800.0)))
        for system in (sliced_xu2020(8), sliced_xu2020(8, **{"deviations.sun.tilt": {"x": "2 mrad"}}))
    )
    for result in (straight, tilted):
        assert np.all(result.face_load_factor >= 1 - 1e-9)
        assert np.all(result.dynamic_face_load_factor >= result.face_load_factor)
    assert tilted.face_load_factor.max() > 1.2 * straight.face_load_factor.max()
    assert tilted.slice_open_share.max() > straight.slice_open_share.max()
    # which end is open: the tilt turns the sun's face against every planet's, so of a cut face the ends differ most
    force = tilted.slice_force.mean("mesh_phase").values.reshape(-1, 8)
    worst = force[np.argmax(tilted.face_load_factor.values)]
    assert np.argmax(worst) in (0, 7)


def test_command_line(tmp_path: Any) -> None:
    from epicyclic.cli.main import app

    run = CliRunner().invoke(app, ["steady", "ren2021", "--contact-loss", "--json"])
    assert run.exit_code == 0
    data = json.loads(run.stdout)
    assert {"open_share", "mesh_force_most", "status"} <= set(data["data_vars"])
    table = CliRunner().invoke(app, ["steady", "ren2021", "--contact-loss"])
    assert table.exit_code == 0
    assert "apart" in table.stdout


def test_a_motion_that_no_train_stays_on_is_named() -> None:
    """ren2021 at 38.75 times its speed: time integration leaves the periodic motion."""
    found = epicyclic.steady("ren2021", contact_loss=True, relative_speed=38.75)
    assert found.status.item() == "unstable"
    assert found.instability.item() == "quasi-periodic"
    assert found.largest_multiplier.item() == pytest.approx(1.51, abs=0.02)
    assert sum("this motion is not stable" in text for text in json.loads(found.attrs["warnings"])) == 1


def test_stability_is_that_of_the_sweep() -> None:
    found = epicyclic.steady("ren2021", contact_loss=True, relative_speed=5.75, shaft_orders=False)
    swept = epicyclic.sweep(
        "ren2021", contact_loss=True, relative_speed=[5.0, 5.75], unstable="report", shaft_orders=False
    )
    assert found.status.item() == "ok"
    assert found.largest_multiplier.item() == pytest.approx(swept.largest_multiplier.values[0, 1], rel=1e-4)
