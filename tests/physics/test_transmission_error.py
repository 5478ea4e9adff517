"""Transmission errors of meshes and shafts: by hand, against integration, at slow speed, over the common period."""

from __future__ import annotations

from fractions import Fraction
from math import atan, ceil, cos, radians, tan
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.statics.signals import _largest_ranges, error_ranges, error_waves, ranges_of_lines

KINDS = ("rotation", "approach", "shaft")
MESH = 4e8  # [N/m]
TORQUE = 100.0  # at the first gear [N m]
ECCENTRIC = 10e-6  # run-out [m]
BASE = {name: 2.5e-3 * teeth / 2 * cos(radians(20)) for name, teeth in (("first", 20), ("second", 31))}


def pair(mesh: dict[str, Any] | None = None, **deviations: Any) -> dict[str, Any]:
    """Two spur gears on fixed axes, the first driving."""
    return {
        "format": 2,
        "title": "a pair",
        "stages": {
            "main": {
                "module": "2.5 mm",
                "first": {"kind": "gear", "teeth": 20, "mass": "1 kg", "inertia": "0.002 kg m^2"},
                "second": {"kind": "gear", "teeth": 31, "mass": "2 kg", "inertia": "0.01 kg m^2"},
                "meshes": {"first-second": {"stiffness": f"{MESH} N/m", **(mesh or {})}},
            }
        },
        "damping": {"modal": "5 %"},
        "deviations": {"main": deviations},
        "operation": {"speed": {"first": "600 rpm"}, "torque": {"first": f"{TORQUE} N m"}},
    }


def planetary(support: str = "inf", **deviations: Any) -> dict[str, Any]:
    """Three planets, ring held, sun driving."""
    gear = {"mass": "1 kg", "inertia": "0.001 kg m^2"}
    return {
        "format": 2,
        "title": "a planetary set",
        "stages": {
            "main": {
                "planets": 3,
                "module": "2 mm",
                "sun": {"teeth": 24, **gear, "support": {"radial": support}},
                "planet": {"teeth": 30, **gear, "bearing": {"radial": "1e9 N/m"}},
                "ring": {"teeth": 84, **gear},
                "carrier": gear,
                "meshes": {"sun-planet": {"stiffness": "2e8 N/m"}, "planet-ring": {"stiffness": "3e8 N/m"}},
            }
        },
        "damping": {"modal": "4 %"},
        "deviations": {"main": deviations},
        "operation": {"held": ["main.ring"], "speed": {"sun": "900 rpm"}, "torque": {"sun": "40 N m"}},
    }


VARYING = {"variation": {"cosine": [0.2, 0.05], "sine": [0.1, 0.0]}}


def waves(result: Any) -> dict[str, Any]:
    return {kind: result[f"transmission_error_{kind}"].values for kind in KINDS}


@pytest.mark.parametrize("verb", [epicyclic.static, epicyclic.steady])
@pytest.mark.parametrize("teeth", [{}, {"helix_angle": "20 deg"}, {"helix_angle": "20 deg", "slices": 3}])
def test_all_kinds_are_one_where_centres_stand(verb: Any, teeth: dict[str, Any]) -> None:
    model = pair(VARYING, first={"run_out": f"{ECCENTRIC} m"})
    stage = model["stages"]["main"]
    stage |= {key: value for key, value in teeth.items() if key != "slices"}
    if "slices" in teeth:
        stage["face_width"] = "25 mm"
        stage["meshes"]["first-second"]["slices"] = teeth["slices"]
    result = verb(model)
    wave = waves(result)
    np.testing.assert_allclose(wave["rotation"], wave["approach"], rtol=1e-12)
    assert list(result["shaft"].values) == ["main.second by main.first"]
    tooth = radians(20) if teeth else 0.0
    base = 2.5e-3 / cos(tooth) * 31 / 2 * cos(atan(tan(radians(20)) / cos(tooth)))
    lag = base * (wave["shaft"] + result["wind_up"].values[:, None])
    np.testing.assert_allclose(lag, wave["rotation"], rtol=1e-9, atol=1e-15)


def test_an_eccentric_gear_by_hand() -> None:
    result = epicyclic.static(pair(first={"run_out": f"{ECCENTRIC} m"}), turns=31, of="main.first", samples=1024)
    deflection = TORQUE / BASE["first"] / MESH
    assert result["transmission_error_rotation"].values.mean() == pytest.approx(deflection, rel=1e-9)
    assert result["wind_up"].values[0] == pytest.approx(deflection / BASE["second"], rel=1e-9)
    ranges = result["transmission_error_shaft_range"].sel(shaft="main.second by main.first")
    for period in ("turn of main.first", "turn of main.second", "common period"):
        assert float(ranges.sel(period=period)) == pytest.approx(2 * ECCENTRIC / BASE["second"], rel=1e-5), period
    assert float(ranges.sel(period="mesh cycle")) < 1e-12
    (only,) = result["error_line"].values
    assert only == "deviations.main.first.run_out"
    assert result["error_line_frequency"].values[0] == pytest.approx(10.0)
    assert result["transmission_error_rotation_line"].values[0, 0] == pytest.approx(ECCENTRIC, rel=1e-9)


def by_its_output() -> dict[str, Any]:
    """A set whose speed is that of the driven shaft."""
    model = planetary("1e8 N/m")
    model["operation"]["speed"] = {"carrier": "200 rpm"}
    return model


@pytest.mark.parametrize(
    "model", [pair(), planetary("1e8 N/m"), by_its_output(), "encased-differential", "wind-five", "xu2020"]
)
def test_a_rigid_motion_makes_no_error(model: Any) -> None:
    train = epicyclic.load(model)
    system = epicyclic.assemble(train)
    for freedom in train.kinematics.freedoms:
        turn = {body.name: float(train.kinematics.ratio[body.member][freedom]) for body in train.bodies}
        full = np.zeros((len(train.bodies), 6))
        full[:, 5] = list(turn.values())
        place = {body.name: i for i, body in enumerate(train.bodies)}
        for i, body in enumerate(train.bodies):
            if body.carried_by is not None:  # the carrier takes the planet along
                angle = body.angle - train.bodies[place[body.carried_by]].angle
                assert abs(angle - np.arctan2(body.centre[1], body.centre[0])) % (2 * np.pi) < 1e-9
                full[i, 1] = np.hypot(*body.centre) * turn[body.carried_by]
        q = np.linalg.lstsq(system.dofs.expand, full.ravel(), rcond=None)[0]
        if np.allclose(system.dofs.expand @ q, full.ravel()):
            assert np.abs(system.errors.B.T @ q).max() < 1e-9 * np.abs(full).max()
            return
    raise AssertionError("no rigid motion was tried")


@pytest.mark.parametrize(
    "model", [pair(VARYING, second={"run_out": "8 um"}), planetary("2e8 N/m", sun={"run_out": "9 um"})]
)
def test_slow_speed_is_static(model: dict[str, Any]) -> None:
    slow = epicyclic.steady(model, relative_speed=1e-4)
    still = epicyclic.static(
        model, cycles=int(epicyclic.sharing(model, method="static").attrs["hunting_period"]), samples=32
    )
    for kind in KINDS:
        name = f"transmission_error_{kind}_range"
        shared = [one for one in slow["period"].values if one in still["period"].values]
        assert "common period" in shared
        a, b = (np.sort(one[name].sel(period="common period").values) for one in (slow, still))
        np.testing.assert_allclose(a, b, rtol=2e-3, atol=1e-12)


def test_harmonic_balance_is_integration() -> None:
    model = planetary("2e8 N/m", sun={"run_out": "9 um"}, planet={"run_out": "5 um"})
    balance = epicyclic.steady(model)
    # 40 mesh cycles to settle, then one common period
    period = int(epicyclic.sharing(model).attrs["hunting_period"])
    run = epicyclic.transient(model, cycles=60 + 2 * period, samples=96, contact="linear")
    late = run["time"].values > run["time"].values[-1] - 1.02 * period / run["mesh_frequency"].values[0]
    for kind in KINDS:
        wave = run[f"transmission_error_{kind}"].values[:, late]
        expected = balance[f"transmission_error_{kind}_range"].sel(period="common period").values
        np.testing.assert_allclose(np.ptp(wave, axis=1), expected, rtol=2e-3, atol=1e-12)


def test_common_period_of_lines_by_brute_force() -> None:
    system = epicyclic.assemble(epicyclic.load(planetary()))
    tone = system.tones[0]
    frequency = [Fraction(0), tone, 2 * tone, tone * Fraction(5, 12), tone * Fraction(7, 20)]
    generator = np.random.default_rng(3)
    k = system.errors.B.shape[1]
    amplitude = generator.normal(size=(k, 5)) + 1j * generator.normal(size=(k, 5))
    amplitude[:, 0] = amplitude[:, 0].real
    ranges = ranges_of_lines(system, amplitude, frequency, np.zeros(k))
    period = Fraction(60) / tone
    t = np.linspace(0, float(period), 120_001)
    wave = (amplitude @ np.exp(2j * np.pi * np.outer([float(one) for one in frequency], t))).real
    np.testing.assert_allclose(ranges["common period"], np.ptp(wave, axis=1), rtol=2e-3)
    for shaft, turn in system.errors.turn.items():
        size = round(float(1 / abs(turn)) / t[1])
        both = np.hstack([wave[:, :-1]] * 2) if size < len(t) else wave
        windows = [np.ptp(both[:, at : at + size + 1], axis=1) for at in range(0, len(t), 500)]
        assert np.all(ranges[f"turn of {shaft}"] >= np.max(windows, axis=0) * (1 - 2e-3))
        np.testing.assert_allclose(ranges[f"turn of {shaft}"], np.max(windows, axis=0), rtol=0.02)
    cycle = (amplitude[:, :3] @ np.exp(2j * np.pi * np.outer([0, 1, 2], np.linspace(0, 1, 4001)))).real
    np.testing.assert_allclose(ranges["mesh cycle"], np.ptp(cycle, axis=1), rtol=5e-3)


def test_turns_do_not_wrap_in_a_part_of_the_period() -> None:
    system = epicyclic.assemble(epicyclic.load(planetary()))
    turn = abs(system.errors.turn["main.sun"])
    ramp = np.tile(np.linspace(0.0, 4.0, 4001), (system.errors.B.shape[1], 1))
    ranges = error_ranges(system, ramp, 4 / turn, part="record")
    np.testing.assert_allclose(ranges["turn of main.sun"], 1.0, rtol=2e-3)
    np.testing.assert_allclose(ranges["record"], 4.0)
    assert "turn of main.carrier" not in ranges  # longer than the record


@pytest.mark.parametrize(
    ("record", "periods"),
    [
        ({"cycles": 64, "samples": 8}, ["turn of main.sun", "64 mesh cycles"]),
        ({"cycles": 3, "samples": 8}, ["3 mesh cycles"]),
        ({"turns": 2, "of": "main.sun"}, ["turn of main.sun", "2 turns of main.sun"]),
        ({"samples": 2}, ["turn of main.sun", "turn of main.carrier", "common period"]),
        ({"samples": 8}, ["mesh cycle", "turn of main.sun", "turn of main.carrier", "common period"]),
    ],
)
def test_ranges_of_a_record_are_named_after_it(record: dict[str, Any], periods: list[str]) -> None:
    """Of 24 mesh cycles, which are common to all; two samples of a cycle do not show its range."""
    result = epicyclic.static(planetary("2e8 N/m", sun={"run_out": "9 um"}), **record)
    assert result["period"].values.tolist() == periods
    for kind in KINDS:
        whole = np.ptp(result[f"transmission_error_{kind}"].values, axis=1)
        np.testing.assert_allclose(result[f"transmission_error_{kind}_range"].isel(period=-1), whole, atol=1e-15)


def test_the_mean_wind_up_of_a_motion_that_is_lost_is_that_before() -> None:
    system = epicyclic.assemble(epicyclic.load(planetary()))
    wave = np.tile([1.0, 3.0, np.nan, np.nan], (system.errors.B.shape[1], 1))
    columns = error_waves(system.errors, wave, "time")
    assert columns["wind_up"][1] == pytest.approx(2.0)
    np.testing.assert_allclose(columns["transmission_error_shaft"][1][0], [-1, 1, np.nan, np.nan])


@pytest.mark.parametrize("model", [pair(VARYING), planetary("2e8 N/m", planet={"run_out": "6 um"})])
def test_a_sweep_has_the_range_of_steady(model: dict[str, Any]) -> None:
    swept = epicyclic.sweep(model, relative_speed=[0.4, 1.0])
    for place, speed in enumerate((0.4, 1.0)):
        alone = epicyclic.steady(model, relative_speed=speed)
        for kind in KINDS:
            most = swept[f"transmission_error_{kind}_peak_to_peak"].isel(speed=place).values
            span = alone[f"transmission_error_{kind}_range"].isel(period=-1).values
            assert np.all(most >= span * (1 - 2e-3) - 1e-15)  # a bound over all phases
            np.testing.assert_allclose(most, span, rtol=0.05, atol=1e-12)
            orders = swept[f"transmission_error_{kind}_order"].isel(speed=place).values
            mesh = (
                alone["error_line"].values.tolist().index("1 x main mesh")
                if "1 x main mesh" in alone["error_line"].values
                else None
            )
            if mesh is not None:
                line = alone[f"transmission_error_{kind}_line"].isel(error_line=mesh).values
                np.testing.assert_allclose(orders[:, 0], line, rtol=1e-5, atol=1e-14)


def test_with_contact_loss_as_without_where_teeth_stay() -> None:
    model = planetary("2e8 N/m", sun={"run_out": "2 um"})
    model["stages"]["main"]["meshes"]["sun-planet"] |= VARYING
    free, bound = epicyclic.steady(model, contact_loss=True), epicyclic.steady(model)
    swept = epicyclic.sweep(model, relative_speed=[1.0], contact_loss=True)
    linear = epicyclic.sweep(model, relative_speed=[1.0])
    assert not free["contact_lost"].values.any()
    for kind in KINDS:
        name = f"transmission_error_{kind}"
        scale = np.abs(bound[name].values).max()
        np.testing.assert_allclose(free[name].values[:, 0], bound[name].values[:, 0], rtol=2e-3, atol=1e-3 * scale)
        expected = linear[f"{name}_peak_to_peak"].values[:, 0]
        np.testing.assert_allclose(free[f"{name}_peak_to_peak"].values, expected, rtol=5e-3, atol=1e-12)
        for direction in ("up", "down"):
            reached = swept[f"{name}_peak_to_peak"].sel(direction=direction).values[:, 0]
            np.testing.assert_allclose(reached, expected, rtol=5e-3, atol=1e-12)


def test_teeth_that_part_move_as_in_time() -> None:
    model = pair({**VARYING, "backlash": "100 um"})
    model["operation"]["torque"]["first"] = "5 N m"
    model["stages"]["main"]["meshes"]["first-second"]["variation"]["cosine"] = [0.6]
    model["stages"]["main"]["meshes"]["first-second"]["variation"]["sine"] = [0.0]
    system = epicyclic.assemble(epicyclic.load(model))
    natural = np.sqrt(MESH * float(np.sum(system.meshes.B[:, 0] ** 2 / np.diag(system.M)))) / (2 * np.pi)
    speed = 0.9 * natural / float(system.tones[0])
    free = epicyclic.steady(model, relative_speed=speed, contact_loss=True)
    assert free["contact_lost"].values.all()
    run = epicyclic.transient(model, mesh_frequency=speed * float(system.tones[0]), cycles=400, samples=128)
    late = run.isel(time=slice(-1281, None))
    for kind in KINDS:
        name = f"transmission_error_{kind}"
        range_ = np.ptp(late[name].values, axis=1)
        np.testing.assert_allclose(free[f"{name}_peak_to_peak"].values, range_, rtol=0.01)


def test_orders_are_those_of_the_mesh_frequency_of_each_stage() -> None:
    name, speed = "encased-differential", 0.5
    swept = epicyclic.sweep(name, relative_speed=[speed])
    alone = epicyclic.steady(name, relative_speed=speed)
    tones = epicyclic.load(name).kinematics.mesh_frequency or {}
    assert len(tones) == 2
    for mesh in alone["mesh"].values:
        stage = str(mesh).split("/")[0]
        line = alone.sel(error_line=f"1 x {stage} mesh")
        assert float(line["error_line_frequency"]) == pytest.approx(speed * float(tones[stage]))
        for kind in ("rotation", "approach"):
            order = swept[f"transmission_error_{kind}_order"].sel(mesh=mesh, order=1).item()
            assert order == pytest.approx(float(line[f"transmission_error_{kind}_line"].sel(mesh=mesh)), rel=1e-5)


@pytest.mark.parametrize(
    ("shares", "periodic"), [([1 / 3, 0.03, 2.5, 1.0, 0.05], True), ([0.6], True), ([1.0, 0.2], False), ([], True)]
)
def test_the_largest_range_is_that_of_the_window_with_the_most(shares: list[float], periodic: bool) -> None:
    wave = np.random.default_rng(3).normal(size=(2, 90)).cumsum(axis=1)
    long = np.tile(wave, 4) if periodic else wave
    found = _largest_ranges(wave, shares, periodic=periodic)
    assert found.shape == (len(shares), 2)
    for share, one in zip(shares, found, strict=True):
        size = min(ceil(share * 90) + 1, long.shape[1])
        starts = range(90 if periodic else 91 - size)
        windows = [np.ptp(long[:, start : start + size], axis=1) for start in starts]
        np.testing.assert_array_equal(one, np.max(windows, axis=0))
