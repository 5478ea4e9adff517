"""Sensitivities by paths of a model file against differences of the whole answer, from the file on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.modes.modal import modal
from epicyclic.questions.studies.sensitivity import _aligned, all_parameters, parameter_at
from epicyclic.system.assembly import assemble

Array = NDArray[np.float64]
# Both sides are differences: five-point ones of the answer with a step of 2e-4 leave some 1e-12 of truncation and, of
# forces solved to 1e-11, 1e-8 of rounding.  Frequencies bend little and are known to 1e-13: two points are enough.
AGREE = 1e-6


def slope(answer: Callable[[float], Array], value: float) -> Array:
    """Derivative by the central difference."""
    h = 1e-4 * value
    return np.asarray((answer(value + h) - answer(value - h)) / (2 * h))


def difference(answer: Callable[[float], Array], value: float) -> Array:
    """Derivative by the five-point formula."""
    h = 2e-4 * value
    near, far = (answer(value + k * h) - answer(value - k * h) for k in (1, 2))
    return np.asarray((8 * near - far) / (12 * h))


def frequencies(drive: Any, path: str) -> Callable[[float], Array]:
    parameter = parameter_at(epicyclic.load(drive), path)
    return lambda value: natural(drive, parameter.at(value))


def natural(drive: Any, overrides: dict[str, object], *, relative_speed: float = 0.0) -> Array:
    """Natural frequencies [Hz] alone, without the resonances and their forces that the verb adds."""
    system = epicyclic.assemble(epicyclic.load(drive, overrides=overrides))
    return np.asarray(modal(system, relative_speed=relative_speed).frequency.values)


def forces(drive: Any, path: str, relative_speed: float) -> Callable[[float], Array]:
    parameter = parameter_at(epicyclic.load(drive), path)

    def answer(value: float) -> Array:
        swept = epicyclic.sweep(drive, overrides=parameter.at(value), relative_speed=[relative_speed], tolerance=1e-11)
        return np.asarray(swept.mesh_force_rms.values[:, 0])

    return answer


def assert_close(found: Array, wanted: Array, *, rounding: float = 0.0) -> None:
    """rounding : 1e-12 of the answer over a step of 2e-4, where what is asked for moves the answer very little."""
    assert np.abs(found - wanted).max() <= AGREE * np.abs(wanted).max() + rounding


@pytest.mark.parametrize(
    ("drive", "path"),
    [
        ("lin1999-n4", "stages.main.sun.support.radial"),
        ("lin1999-n4", "stages.main.meshes.sun-planet.pressure_angle"),
        ("lin1999-n5", "stages.main.planet.mass"),
        ("ren2021", "stages.main.pressure_angle"),
        ("ren2021", "stages.main.helix_angle"),
        ("ren2021", "stages.main.face_width"),
        ("xu2020", "stages.main.planet.bore"),
        ("xu2020", "stages.main.sun.neck.torsional_rigidity"),
        ("encased-differential", "couplings.g1-f1.rz"),
        ("encased-differential", "stages.encased.meshes.planet-ring.stiffness"),
    ],
)
def test_frequencies(drive: str, path: str) -> None:
    found = epicyclic.sensitivity(drive, paths=[path])
    elastic = found.frequency.values > 0
    wanted = slope(frequencies(drive, path), float(found.parameter_value[0]))
    assert_close(found.derivative.values[0, elastic], wanted[elastic])


@pytest.mark.parametrize(
    ("drive", "path", "speed"),
    [
        ("ren2021", "stages.main.planet.bearing.radial", 1.0),
        ("ren2021", "stages.main.pressure_angle", 1.0),
        ("ren2021", "stages.main.module", 3.3),
        ("ren2021", "damping.modal", 3.3),
        ("ren2021", "deviations.main.sun.run_out.amplitude", 1.0),
        ("ren2021", "operation.torque.main.sun", 1.0),
        ("ren2021", "operation.speed.main.sun", 1.0),
        ("ren2021", "stages.main.carrier.inertia", 3.3),
        ("ren2021", "stages.main.meshes.sun-planet.stiffness", 3.3),
        ("xu2020", "stages.main.planet.bearing.radial", 2.0),
        ("xu2020", "operation.power.main.carrier", 2.0),
        ("xu2020", "operation.speed.main.carrier", 2.0),
    ],
)
def test_forces(drive: str, path: str, speed: float) -> None:
    found = epicyclic.sensitivity(drive, of="force", paths=[path], relative_speed=speed)
    assert_close(found.derivative.values[0], difference(forces(drive, path, speed), float(found.parameter_value[0])))


@pytest.mark.parametrize(
    "path", ["stages.main.meshes.sun-planet.stiffness[2]", "stages.main.sun.support.x", "stages.main.planet.mass"]
)
def test_repeated_roots_split_into_the_set_told(path: str) -> None:
    """Upwards the split roots rise in order, downwards in the opposite one: the eigenvalues on the eigenspace."""
    drive = "lin1999-n4"
    found = epicyclic.sensitivity(drive, paths=[path])
    value, base = float(found.parameter_value[0]), found.frequency.values
    answer = frequencies(drive, path)
    groups = [np.flatnonzero(np.abs(base - one) < 1e-6 * one) for one in dict.fromkeys(base.round(3)) if one > 0]
    assert max(group.size for group in groups) == 2

    def mirrored(at: Array, group: NDArray[np.int64], up: bool) -> Array:
        return at[group] if up else at[group][::-1]

    h = 1e-4 * value
    above, below = answer(value + h), answer(value - h)
    for group in groups:
        wanted = (mirrored(above, group, True) - mirrored(below, group, False)) / (2 * h)
        mine = found.derivative.values[0, group]
        assert np.all(np.diff(mine) >= 0)
        assert np.abs(mine - wanted).max() <= AGREE * np.abs(found.derivative.values[0]).max()


@pytest.mark.parametrize("path", ["stages.main.planet.bearing.radial", "stages.main.planet.mass"])
def test_gyroscopic_frequencies(path: str) -> None:
    speed = 20.0
    found = epicyclic.sensitivity("ren2021", paths=[path], relative_speed=speed)
    parameter = parameter_at(epicyclic.load("ren2021"), path)

    def answer(value: float) -> Array:
        return natural("ren2021", parameter.at(value), relative_speed=speed)

    elastic = found.frequency.values > 0
    assert np.isnan(found.derivative.values[0, ~elastic]).all()
    wanted = slope(answer, parameter.value)
    assert_close(found.derivative.values[0, elastic], wanted[elastic])
    still = epicyclic.sensitivity("ren2021", paths=[path]).derivative.values[0]
    assert np.abs(still - found.derivative.values[0])[elastic].max() > 1e-3 * np.abs(still).max()  # the speed matters


def test_a_spring_on_a_rigid_mode_has_no_slope_and_the_others_have() -> None:
    found = epicyclic.sensitivity("ren2021", paths=["stages.main.sun.support.rz", "stages.main.sun.support.radial"])
    torsional = found.sel(path="stages.main.sun.support.rz")
    rigid = found.frequency.values == 0
    assert np.isnan(torsional.derivative.values[rigid]).all()
    assert np.isfinite(torsional.derivative.values[~rigid]).all()
    assert np.abs(torsional.derivative.values[~rigid]).max() > 0
    assert np.isnan(torsional.sensitivity.values).all()  # of a value of 0 there is no percent
    held = epicyclic.sensitivity("ren2021", of="force", paths=["stages.main.sun.support.rz"])
    assert "motion that is free" in held.status.item()
    assert np.isnan(held.derivative.values).all()
    radial = found.sel(path="stages.main.sun.support.radial")
    assert (radial.derivative.values[rigid] == 0).all()


@pytest.mark.parametrize(
    ("overrides", "path"),
    [
        ({"stages.main.meshes.sun-planet.slices": 3}, "stages.main.face_width"),
        ({"stages.main.planet.bearing.clearance": "20 um"}, "stages.main.planet.bearing.clearance"),
        ({"deviations.main.planet.run_out.amplitude": "[30, 0, 10] um"}, "deviations.main.planet.run_out.amplitude[1]"),
        ({"damping": "", "damping.mesh": 0.05}, "damping.mesh"),
    ],
)
def test_slices_laws_planets_and_dampers(overrides: dict[str, Any], path: str) -> None:
    train = epicyclic.load("ren2021", overrides=overrides)
    found = epicyclic.sensitivity(train, of="force", paths=[path])
    value = float(found.parameter_value[0])
    wanted = difference(forces(dict(train.document), path, 1.0), value)
    assert_close(found.derivative.values[0], wanted, rounding=1e-8 * float(found.mesh_force_rms.max()) / value)


def test_the_drawing_is_asked_and_ranked() -> None:
    found = epicyclic.sensitivity("ren2021", of="force")
    chosen = found.ranked_by.values.astype(bool)
    force = found.mesh_force_rms.values
    assert np.flatnonzero(chosen).tolist() == [
        np.flatnonzero(force > (1 - 1e-9) * force.max())[0]
    ]  # of equal ones the first
    size = np.abs(found.sensitivity.values[:, chosen]).ravel()
    assert np.all(np.diff(size[np.isfinite(size)]) <= 0)
    names = set(map(str, found.path.values))
    assert {"stages.main.planet.bearing.radial", "stages.main.pressure_angle", "damping.modal"} <= names
    assert not {name for name in names if name.endswith(("teeth", "planets"))}
    # the response is linear in torque and errors together, its amplitude is their sum: percents add up to 1
    loads = [name for name in names if name.startswith(("deviations.", "operation.torque"))]
    total = found.sensitivity.sel(path=loads).sum("path").values
    assert total == pytest.approx(np.ones(total.size), abs=1e-6)


def test_a_value_the_model_can_not_go_below() -> None:
    train = epicyclic.load("ren2021", overrides={"deviations.main.sun.run_out.amplitude": "0 um"})
    found = epicyclic.sensitivity(train, of="force", paths=["deviations.main.sun.run_out.amplitude"])
    # the square of an amplitude has no slope at 0 where nothing else stands at its frequency
    assert np.abs(found.derivative.values).max() <= 1e-6 * float(found.mesh_force_rms.max())
    gap = epicyclic.sensitivity(train, paths=["stages.main.gap"])
    assert (gap.derivative.values == 0).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"paths": ["stages.main.sun.mas"]}, "did you mean 'stages.main.sun.mass'"),
        ({"paths": ["stages.main.sun.teeth"]}, "whole number"),
        ({"paths": ["stages.main.planets"]}, "whole number"),
        ({"paths": ["title"]}, "not a number"),
        ({"paths": ["stages.main.ring.split"]}, "not a number"),
        ({"paths": ["stages.main.sun.support.rx"]}, "rigid"),
        ({"paths": ["stages.main.meshes.sun-planet.stiffness[9]"]}, "no such entry"),
        ({"paths": []}, "no path given"),
        ({"mode": 99}, "no such mode"),
        ({"mode": 0}, "no such mode"),
        ({"of": "stress"}, "allowed: 'frequency' or 'force'"),
        ({"mesh": "main/sun-planet/1/left"}, "goes with forces"),
        ({"of": "force", "mode": 1}, "goes with frequencies"),
        ({"of": "force", "mesh": "main/sun-planet/9/left"}, "no such mesh; did you mean"),
        ({"of": "force", "harmonic": 0}, "harmonic = 0: out of range"),
        ({"of": "force", "mesh_frequency": 20.0, "relative_speed": 1.0}, "not both"),
    ],
)
def test_bad_input(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        epicyclic.sensitivity("ren2021", **options)


@pytest.mark.parametrize("options", [{"mode": 99}, {"of": "force", "mesh": "main/sun-planet/9/left"}])
def test_what_is_not_there_is_refused_before_anything_is_differentiated(
    options: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "epicyclic.questions.studies.sensitivity.system_derivatives", lambda *_, **__: pytest.fail("differentiated")
    )
    with pytest.raises(ModelError, match="no such"):
        epicyclic.sensitivity("ren2021", **options)


def test_forces_without_damping() -> None:
    with pytest.raises(ModelError, match="no damping"):
        epicyclic.sensitivity("lin1999-n4", of="force", paths=["stages.main.sun.mass"])


def test_every_number_of_a_file_is_read_and_written_back() -> None:
    """Put back unchanged, in the words of the file, nothing changes."""
    train = epicyclic.load("encased-differential")
    overrides: dict[str, object] = {}
    for parameter in all_parameters(train):
        if parameter.unit and not parameter.path.endswith("]") and not parameter.path.endswith("_inertia"):
            overrides |= parameter.at(parameter.value)
    assert (natural(dict(train.document), overrides) == natural(dict(train.document), {})).all()
    assert len(all_parameters(train)) > 60


def test_track() -> None:
    path = "stages.main.planet.bearing.radial"
    found = epicyclic.track("lin1999-n4", over=path, start="2e7 N/m", stop="1e9 N/m", points=13, modes=14)
    kinds = dict(zip(found.mode.values.tolist(), found.mode_kind.values, strict=True))
    assert {"crossing", "veering"} == set(found.event_kind.values)
    for event in found.event.values:
        here = found.sel(event=event)
        pair = {kinds[int(str(here[name].item()).split(",")[0])] for name in ("event_first", "event_second")}
        assert (len(pair) == 1) == (here.event_kind == "veering")
    last = epicyclic.modes("lin1999-n4", overrides={path: "1e9 N/m"}).frequency.values
    ends = np.sort(found.frequency.sel(parameter=1e9).values)
    assert np.abs(ends[:, None] - last).min(axis=1).max() <= 1e-9 * last.max()  # the same matrices, in another order
    values = found.parameter.values
    assert np.all(np.diff(values) > 0)
    assert values.size > 13  # looked closer where modes meet


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"over": "stages.main.sun.teeth"}, "whole number"),
        ({"over": "stages.main.sun.mass", "start": "1 m"}, "not a value of this parameter"),
        ({"over": "stages.main.sun.mass", "start": "1 kg", "stop": "1 kg"}, "range is empty"),
        ({"over": "stages.main.sun.mass", "start": "-1 kg"}, "out of range"),
        ({"over": "stages.main.sun.mass", "points": 2}, "points = 2: out of range; allowed: 3 to"),
    ],
)
def test_track_bad_input(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        epicyclic.track("lin1999-n4", **options)


@pytest.mark.parametrize("spring", [1.0, 1e-6])
def test_a_soft_spring_has_its_sensitivity(spring: float) -> None:
    """A train held against rotation by one spring: its frequency is as the root of the stiffness, however soft."""
    gears = {name: {"teeth": teeth} for name, teeth in (("sun", 24), ("planet", 30), ("ring", 84))}
    stage = {
        **gears,
        "planets": 3,
        "module": "4 mm",
        "face_width": "40 mm",
        "carrier": {"mass": "9 kg", "inertia": 0.1},
    }
    stage["sun"] = {"teeth": 24, "support": {"rz": f"{spring} N m/rad"}}
    stage["planet"] = {"teeth": 30, "bearing": {"radial": "4e8 N/m"}}
    model = {"format": 2, "title": "soft", "stages": {"main": stage}, "operation": {"held": ["ring"]}}
    found = epicyclic.sensitivity(model, paths=["stages.main.sun.support.rz"])
    # beside bearings of 4e8 N/m, in whose rounding a step of it is lost
    np.testing.assert_allclose(found.sensitivity.values[0, 0], 0.5, rtol=1e-5)


def test_lines_that_meet_beside_a_speed_have_no_derivative() -> None:
    system = assemble(epicyclic.load("ren2021"))
    faster = replace(system, tones=tuple(2 * tone for tone in system.tones))
    _aligned(faster, system, system)
    for other in (
        replace(faster, lines=system.lines[:-1]),
        replace(faster, tones=(*faster.tones, faster.tones[0] / 3)),
    ):
        with pytest.raises(ModelError, match="frequencies meet or part"):
            _aligned(other, system, system)
