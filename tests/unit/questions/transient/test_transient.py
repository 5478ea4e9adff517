"""The verb: scenarios, starts, methods, runs that are stopped and go on, wrong options."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.engine import run_folder
from epicyclic.errors import ModelError
from epicyclic.questions.transient import scenario as run_module
from epicyclic.questions.transient.scenario import History, Scenario, scenario_motion
from epicyclic.system.system import System

Drive = Callable[..., System]
TONE = 100 / (2 * np.pi) * 24 * 72 / 96


@pytest.fixture(scope="module")
def document(torsional_set: Callable[..., dict[str, Any]]) -> dict[str, Any]:
    """With constant meshes unless asked for: quick, and its forces are known in closed form."""
    return torsional_set(modal=0.05)


@pytest.fixture(scope="module")
def drive(document: dict[str, Any]) -> Drive:
    def build(swing: float = 0.0, **overrides: Any) -> System:
        meshes = "stages.main.meshes.sun-planet"
        wave = {f"{meshes}.variation": {"cosine": [swing, swing / 4]}} if swing else {}
        return epicyclic.assemble(epicyclic.load(document, overrides=wave | overrides))

    return build


@pytest.fixture(scope="module")
def swinging(drive: Drive) -> System:
    return drive(0.3)


def test_it_stays_where_nothing_changes(drive: Drive) -> None:
    found = epicyclic.transient(drive(), cycles=20)
    radius = 0.024 * np.cos(np.radians(20))
    force = found.mesh_force.sel(mesh="main/sun-planet/1").values
    # torque / (planets base radius): start and forces are exact to the start's residual, 1e-11
    np.testing.assert_allclose(force, 300 / (3 * 2 * radius), rtol=1e-8)
    assert found.status.item() == "ok"
    assert not found.contact_lost.any()
    assert found.attrs["verb"] == "transient"
    assert found.time.attrs["units"] == "s"
    assert float(found.mesh_frequency[0]) == pytest.approx(TONE, rel=1e-12)


def test_methods_agree(swinging: System) -> None:
    rk4, dop853, radau = (
        epicyclic.transient(swinging, cycles=0.1, method=method, initial="rest", samples=40).mesh_force.values
        for method in ("rk4", "dop853", "radau")
    )
    top = np.abs(dop853).max()
    assert np.abs(radau - dop853).max() < 1e-7 * top  # tolerances 1e-8, a few steps across contact
    # teeth that meet set the highest mode moving: its phase errs by 0.35^4 / 120 per radian, over some radians
    assert 1e-6 * top < np.abs(rk4 - dop853).max() < 2e-3 * top


def test_a_run_goes_on_from_the_end_of_another(swinging: System) -> None:
    whole = epicyclic.transient(swinging, cycles=6, initial="rest")
    first = epicyclic.transient(swinging, cycles=3, initial="rest")
    second = epicyclic.transient(swinging, cycles=3, initial=first)
    # the phase is carried on as a number of seconds: rounding, 1e-12 of the stiffness
    np.testing.assert_allclose(second.mesh_force, whole.mesh_force[:, 96:], rtol=1e-8)
    assert float(second.end_phase) == pytest.approx(6 / TONE, rel=1e-12)
    with pytest.raises(ModelError, match="not a transient of this train"):
        epicyclic.transient(swinging, initial=epicyclic.modes(swinging))


def test_decimation_keeps_every_so_many(swinging: System) -> None:
    every = epicyclic.transient(swinging, cycles=4)
    few = epicyclic.transient(swinging, cycles=4, decimate=16)
    assert few.sizes["time"] == 9
    assert np.array_equal(few.mesh_force, every.mesh_force[:, ::16])  # the same steps: the same bits


def test_a_torque_step_and_a_start_up(swinging: System, drive: Drive) -> None:
    system = drive()
    step = epicyclic.transient(system, cycles=200, torque_step=(1.5, 20 / TONE), decimate=32)
    force = step.mesh_force[0].values
    every = epicyclic.transient(system, cycles=30, torque_step=(1.5, 20 / TONE))
    at = 300 / (3 * 0.048 * np.cos(np.radians(20)))
    np.testing.assert_allclose(force[:20], at, rtol=1e-8)
    np.testing.assert_allclose(force[-10:], 1.5 * at, rtol=1e-3)  # 5 % damping for 180 cycles
    assert every.mesh_force[0].max() > 1.6 * at  # it overshoots
    ramp = epicyclic.transient(system, cycles=200, torque_ramp=100 / TONE, decimate=32)
    np.testing.assert_allclose(ramp.mesh_force[0].values[[50, -1]], [at / 2, at], rtol=1e-2)
    assert abs(ramp.mesh_force[0].values[0]) < 1e-6 * at  # nothing presses at the very beginning


def history(**torque: Any) -> History:
    return History(time=np.array([0.0, 0.02, 0.05]), torque={k: np.array(v) for k, v in torque.items()}, where="abc")


@pytest.mark.parametrize("member", ["sun", "main.sun", "main/sun", "carrier"])
def test_a_history_is_balanced_by_the_other_member(member: str, drive: Drive) -> None:
    size = -1200.0 if member == "carrier" else 300.0  # ratio 1 + 72/24, reversed
    found = epicyclic.transient(drive(), history=history(**{member: [size, 2 * size, 2 * size]}), decimate=8)
    assert float(found.time[-1]) == pytest.approx(0.05, abs=0.001)
    at = 300 / (3 * 0.048 * np.cos(np.radians(20)))
    force, middle = found.mesh_force[0].values, int(found.sizes["time"] * 0.2)
    assert force[0] == pytest.approx(at, rel=1e-8)
    assert force[middle] == pytest.approx(1.5 * at, rel=2e-2)  # the ramp excites the modes a little
    assert force[-1] == pytest.approx(2 * at, rel=2e-2)


def test_both_torques_given_must_balance(drive: Drive) -> None:
    good = history(sun=[300.0, 600.0, 600.0], carrier=[-1200.0, -2400.0, -2400.0])
    bad = history(sun=[300.0, 600.0, 600.0], carrier=[-1200.0, -2400.0, -2300.0])
    one = epicyclic.transient(drive(), history=history(sun=[300.0, 600.0, 600.0]), decimate=8)
    two = epicyclic.transient(drive(), history=good, decimate=8)
    np.testing.assert_allclose(one.mesh_force, two.mesh_force, rtol=1e-7)
    with pytest.raises(ModelError, match=r"c = sun 600 N m, carrier -2300 N m: .*balance"):
        epicyclic.transient(drive(), history=bad)


def test_spinning_up_needs_the_torque_of_its_inertia(drive: Drive) -> None:
    """The sun drives harder by 2 T s' / w_s, and every mesh carries what lies behind it: closed form."""
    system, seconds = drive(), 0.1
    found = epicyclic.transient(system, mesh_frequency=(0.5 * TONE, TONE), duration=seconds, decimate=16)
    rise = 0.5 / seconds
    radius = 0.048 * np.cos(np.radians(20))
    sun, carrier, planet = 100.0, 25.0, -50.0  # rad/s: 1/4 of the sun; (w_p - w_c) 24 = -(w_s - w_c) 24
    inertia = 0.05 + 3 * 1.5 * 0.096**2  # the planets at their pins
    twice = 0.002 * sun**2 + inertia * carrier**2 + 3 * 0.003 * planet**2
    torque = 300 + twice * rise / sun
    first = (torque - 0.002 * sun * rise) / (3 * radius)
    second = first + 0.003 * planet * rise / radius
    # torsional: no other coordinate moves, and the start is in equilibrium with the acceleration
    for pair, force in (("sun-planet", first), ("planet-ring", second)):
        np.testing.assert_allclose(found.mesh_force.sel(mesh=f"main/{pair}/2"), force, rtol=1e-8)
    assert abs(first / (300 / (3 * radius)) - 1) > 0.01  # there is something to see
    np.testing.assert_allclose(found.relative_speed, 0.5 + rise * found.time, rtol=1e-12)


def test_a_start_up_from_standstill_has_no_meshing(drive: Drive) -> None:
    found = epicyclic.transient(drive(0.3), mesh_frequency=(0.0, TONE), duration=0.2)
    assert float(found.relative_speed[0]) == 0
    assert np.isfinite(found.mesh_force).all()


# stopped and taken up ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def never_stopped(swinging: System) -> Callable[[Any], xr.Dataset]:
    """A run by each method that is never stopped, in pieces of the ordinary length."""
    return cache(lambda method: epicyclic.transient(swinging, cycles=0.5, initial="rest", method=method))


@pytest.fixture
def small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_module, "_STEPS", 15)
    monkeypatch.setattr(run_folder, "_EVERY", 0.0)


@pytest.mark.usefixtures("small_pieces")
@pytest.mark.parametrize("method", ["rk4", "dop853"])
@pytest.mark.parametrize("stop", [0.2, 0.55])
def test_a_stopped_run_continues_to_the_same_bits(
    tmp_path: Path, swinging: System, never_stopped: Callable[[Any], xr.Dataset], method: Any, stop: float
) -> None:
    def interrupt(done: float) -> None:
        if done > stop:
            raise KeyboardInterrupt

    options: dict[str, Any] = {"cycles": 0.5, "initial": "rest", "method": method}
    whole = never_stopped(method)
    folder = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        epicyclic.transient(swinging, **options, folder=folder, progress=interrupt)
    kept = len(list(folder.glob("*.kept")))
    assert kept >= 1
    with pytest.raises(ModelError, match="an interrupted run lies there"):
        epicyclic.transient(swinging, **options, folder=folder)
    seen: list[float] = []
    again = epicyclic.transient(swinging, **options, folder=folder, resume=True, progress=seen.append)
    assert seen[0] > stop  # it did not begin anew
    xr.testing.assert_identical(again, whole)
    third = epicyclic.transient(swinging, **options, folder=folder, resume=True, progress=seen.append)
    xr.testing.assert_identical(third, whole)


@pytest.mark.usefixtures("small_pieces")
def test_nothing_half_written_is_taken(tmp_path: Path, swinging: System) -> None:
    folder = tmp_path / "run"
    epicyclic.transient(swinging, cycles=4, folder=folder)
    with pytest.raises(ModelError, match=r"other options \(duration\)"):
        epicyclic.transient(swinging, cycles=5, folder=folder, resume=True)
    last = max(folder.glob("*.kept"))
    (folder / "000099.kept.part").write_bytes(b"rest of a segment that was never finished")
    last.write_bytes(last.read_bytes()[:-8])
    with pytest.raises(ModelError, match="not a segment"):
        epicyclic.transient(swinging, cycles=4, folder=folder, resume=True)
    (folder / "run.json").write_text("{}")
    with pytest.raises(ModelError, match="not a run that can be continued"):
        epicyclic.transient(swinging, cycles=4, folder=folder, resume=True)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "letter.txt").write_text("")
    for place in (tmp_path / "other", tmp_path / "other" / "letter.txt"):
        with pytest.raises(ModelError, match="is no folder of a run"):
            epicyclic.transient(swinging, cycles=4, folder=place)
    with pytest.raises(ModelError, match="cannot be written"):
        epicyclic.transient(swinging, cycles=4, folder=tmp_path / "none" / "run")


RUN = """
import sys, json
import epicyclic
from epicyclic.engine import run_folder
from epicyclic.questions.transient import scenario as run
run._STEPS, run_folder._EVERY = 1000, 0.0
train = epicyclic.load(json.loads(sys.argv[1]))
epicyclic.transient(train, cycles=200, initial="rest", folder=sys.argv[2], resume=True)
"""


def test_a_killed_run_continues_to_the_same_bits(
    tmp_path: Path, document: dict[str, Any], drive: Drive, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("numba")
    with subprocess.Popen([sys.executable, "-c", RUN, json.dumps(document), str(tmp_path / "a")]) as process:
        until = time.monotonic() + 60
        while not (tmp_path / "a" / "000000.kept").is_file() and time.monotonic() < until:
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    kept = len(list((tmp_path / "a").glob("*.kept")))
    monkeypatch.setattr(run_module, "_STEPS", 1000)
    monkeypatch.setattr(run_folder, "_EVERY", 0.0)
    options: dict[str, Any] = {"cycles": 200, "initial": "rest"}
    again = epicyclic.transient(epicyclic.load(document), **options, folder=tmp_path / "a", resume=True)
    assert 1 <= kept < len(list((tmp_path / "a").glob("*.kept")))
    assert again.mesh_force.values.tobytes() == epicyclic.transient(drive(), **options).mesh_force.values.tobytes()


# wrong options -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"duration": -1.0}, "duration = -1.0: out of range"),
        ({"duration": np.nan}, "duration"),
        ({"duration": 1.0, "cycles": 3}, "not both"),
        ({"cycles": 0}, "cycles"),
        ({"mesh_frequency": -5.0}, "mesh_frequency"),
        ({"mesh_frequency": (0.0, 0.0)}, "mesh_frequency"),
        ({"mesh_frequency": (1.0, 2.0, 3.0)}, "mesh_frequency"),
        ({"samples": 0}, "samples"),
        ({"decimate": 0}, "decimate"),
        ({"cycles": 1e7}, "decimate = 1: would need some 58.9 GB"),
        ({"method": "euler"}, "method"),
        ({"contact": "glue"}, "contact"),
        ({"initial": "anywhere"}, "initial"),
        ({"initial": np.zeros(3)}, "not a state"),
        ({"initial": np.full((2, 5), np.inf)}, "initial = inf: out of range"),
        ({"torque_step": (1.5, 1e9)}, "torque step is out of range"),
        ({"torque_step": (np.nan, 0.001)}, "torque_step"),
        ({"torque_step": (1.5, np.inf)}, "torque_step"),
        ({"torque_ramp": -1.0}, "torque_ramp"),
        ({"torque_ramp": 1.0, "torque_step": (2.0, 0.0)}, "give one of"),
        ({"history": history(moon=[1.0, 2.0, 3.0])}, "no member of that name"),
        (
            {"history": History(time=np.array([0.0, 1, 2]), torque={"sun": np.ones(3), "main.sun": np.ones(3)})},
            "two col",
        ),
    ],
)
def test_wrong_options(options: dict[str, Any], said: str, drive: Drive) -> None:
    with pytest.raises(ModelError, match=said):
        epicyclic.transient(drive(), **options)


def test_without_speed_or_torque(drive: Drive) -> None:
    with pytest.raises(ModelError, match="mesh frequency above zero"):
        epicyclic.transient("lin1999-n3")
    with pytest.raises(ModelError, match="which member drives"):
        epicyclic.transient(drive(**{"operation.torque.sun": 0}), mesh_frequency=(100.0, 200.0))


def test_an_unstable_run_is_said_to_be(drive: Drive) -> None:
    swing = drive(0.95, **{"damping.modal": 1e-6})
    natural = epicyclic.modes(swing).frequency.values[-1]
    found = epicyclic.transient(swing, mesh_frequency=2 * natural, cycles=40_000, contact="linear", decimate=3200)
    assert found.status.item().startswith("not finite after")
    assert np.isnan(found.mesh_force.values[:, -1]).all()
    assert np.isfinite(found.mesh_force.values[:, 0]).all()
    assert "grows without bound" in found.attrs["warnings"]
    assert np.isfinite(found.end_displacement).all()
    assert np.isfinite(found.wind_up).all()


def test_a_jump_falls_on_a_step(drive: Drive) -> None:
    found = scenario_motion(drive(), Scenario(duration=1.0, step=(2.0, 0.1234)), contact="unilateral", step=0.01)
    assert found.program.time.tolist() == pytest.approx([-1.0, 0.0, 0.12, 0.12, 1.0, 2.0], abs=1e-15)
    assert found.program.level[:, 0].tolist() == [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    assert found.program.phase[1] == 0.0


def test_a_mass_that_makes_the_run_endless_is_named(tmp_path: Path, document: dict[str, Any]) -> None:
    # the sun alone vibrates against what holds it, so that its frequency goes as 1 / sqrt(inertia)
    tiny = epicyclic.load(document, overrides={"stages.main.sun.inertia": "1e-18 kg m^2"})
    system = epicyclic.assemble(tiny)
    highest = float(epicyclic.modes(system).frequency.max())
    with pytest.raises(ModelError, match="would take some") as refused:
        epicyclic.transient(system, cycles=1000)
    assert refused.value.path == "duration"
    given = str(refused.value.given)
    assert "(main/sun)" in given
    assert float(given.split(" at ")[1].split(" Hz")[0]) == pytest.approx(highest, rel=1e-3)
    assert "folder" in str(refused.value.allowed)
    with pytest.raises(ModelError, match="30 days") as longer:
        epicyclic.transient(system, cycles=10_000_000, folder=tmp_path, decimate=1000)
    assert "folder" not in str(longer.value.allowed)
