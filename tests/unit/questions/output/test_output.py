"""The gearbox at its output: stiffness, play, hysteresis, lost motion, inertia and starting torque, by hand."""

from __future__ import annotations

import json
from copy import deepcopy
from math import pi
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import trapezoid
from tests.unit.statics.test_locked import (
    BACKLASH,
    PLANETS,
    RATIO,
    SHAFT,
    TEETH,
    arm,
    compliance,
    half_play,
    stage,
    two_stages,
)

import epicyclic
from epicyclic.engine.plan import sampling_plan, scramble_uniforms
from epicyclic.errors import ModelError
from epicyclic.questions.output.output import locked_train, output_shaft, sampled_loops
from epicyclic.questions.output.views import findings, key_figures, tables
from epicyclic.questions.tolerance.tolerance_map import tolerance_map
from epicyclic.statics.signals import near_lines
from epicyclic.system.assembly import assemble
from epicyclic.train.resolution import load

ARCMIN = pi / 180 / 60
CLEARANCE, BEARING = 7e-6, 8e7  # of a planet bearing, radial [m], [N/m]
PITCH = 0.024  # pitch radius of the first sun [m]


def one_stage(**bearing: str) -> dict[str, Any]:
    """A reducer with the ring held: sun in, carrier out."""
    model = {
        "format": 2,
        "title": "a planetary reducer",
        "stages": {"first": stage("first")},
        "operation": {"held": ["ring"], "speed": {"sun": "900 rpm"}, "torque": {"sun": "40 N m"}},
    }
    if bearing:
        model["stages"]["first"]["planet"]["bearing"] = {"radial": f"{BEARING} N/m", **bearing}  # type: ignore[index]
    return model


def turning(model: dict[str, Any]) -> dict[str, Any]:
    """Two stages in series that turn, the input driven."""
    held = {"held": ["first.ring", "second.ring"], "speed": {"first.sun": "900 rpm"}}
    return model | {"operation": {**held, "torque": {"first.sun": "40 N m"}}}


def mean(result: xr.Dataset, name: str) -> float:
    values = result[name].values
    np.testing.assert_allclose(values, values[0], rtol=1e-9)  # constant stiffness: the same wherever it is locked
    return float(values[0])


def at_first_sun() -> float:
    """Compliance of both stages and the shaft at the first sun [rad/(N m)]."""
    return compliance("first") + RATIO**2 * (1 / SHAFT + compliance("second"))


@pytest.mark.parametrize("torque", ["40 N m", "-40 N m"])
def test_one_stage_is_the_spring_of_its_meshes(torque: str) -> None:
    model = one_stage()
    model["operation"]["torque"]["sun"] = torque
    result = epicyclic.output(model, shaft="carrier", phases=3)
    assert (result.attrs["shaft"], result.attrs["locked_shafts"]) == ("first.carrier", "first.ring, first.sun")
    stiffness = RATIO**2 / compliance("first")
    for name in ("shaft_secant_stiffness", "shaft_fitted_stiffness"):
        assert mean(result, name) == pytest.approx(stiffness, rel=1e-8)
    np.testing.assert_allclose(result.shaft_tangent_stiffness, stiffness, rtol=1e-6)
    assert float(result.rated_torque) == pytest.approx(40 * RATIO, rel=1e-12)
    assert float(result.shaft_play) == pytest.approx(2 * half_play("first") / RATIO, rel=1e-8)
    assert not result.hysteresis_energy.values.any()


def test_two_stages_are_a_chain_of_springs_at_either_end() -> None:
    ahead = epicyclic.output(turning(two_stages()), shaft="first.sun", rated=30.0, phases=2)
    behind = epicyclic.output(turning(two_stages()), phases=2)
    play = half_play("first") + RATIO * half_play("second")
    assert mean(ahead, "shaft_secant_stiffness") == pytest.approx(1 / at_first_sun(), rel=1e-8)
    assert mean(behind, "shaft_secant_stiffness") == pytest.approx(RATIO**4 / at_first_sun(), rel=1e-8)
    assert mean(ahead, "lost_motion") == pytest.approx(2 * (play + 0.03 * 30 * at_first_sun()), rel=1e-8)
    assert mean(ahead, "shaft_backlash") == pytest.approx(2 * (play + 0.005 * 30 * at_first_sun()), rel=1e-8)
    elastic = 0.03 * 40 * RATIO**2 * at_first_sun() / RATIO**4
    assert mean(behind, "lost_motion") == pytest.approx(2 * (play / RATIO**2 + elastic), rel=1e-8)


def test_lost_motion_is_backlash_and_the_clearance_of_the_bearings() -> None:
    """The torque on the sun bears on a planet pin with 2 T / (N r), whose way turns the sun by 2 y / r."""
    result = epicyclic.output(one_stage(clearance=f"{CLEARANCE} m"), shaft="sun", share=0.1, phases=2)
    pin = 2 * 0.1 * 40 / (PLANETS["first"] * PITCH)
    ways = half_play("first") + 0.1 * 40 * compliance("first") + 2 / PITCH * (CLEARANCE + pin / BEARING)
    assert mean(result, "lost_motion") == pytest.approx(2 * ways, rel=1e-8)
    assert float(result.shaft_play) == pytest.approx(2 * (half_play("first") + 2 / PITCH * CLEARANCE), rel=1e-6)
    spring = compliance("first") + (2 / PITCH) ** 2 / (PLANETS["first"] * BEARING)
    assert mean(result, "shaft_secant_stiffness") == pytest.approx(1 / spring, rel=1e-8)
    assert not result.hysteresis_energy.values.any()


def test_the_curve_is_odd_and_rises_through_zero() -> None:
    result = epicyclic.output(one_stage(clearance=f"{CLEARANCE} m"), phases=2)
    angle, torque = result.angle_rising.values, result.shaft_torque.values
    np.testing.assert_allclose(angle, -angle[:, ::-1], rtol=1e-8)
    np.testing.assert_allclose(torque, -torque[::-1], rtol=1e-14)
    assert (np.diff(angle, axis=1) > 0).all()
    np.testing.assert_array_equal(result.angle_falling, result.angle_rising)
    # without play the curve goes through zero itself
    model = one_stage()
    for mesh in model["stages"]["first"]["meshes"].values():
        mesh["backlash"] = "0 m"
    tight = epicyclic.output(model, phases=2)
    np.testing.assert_allclose(
        tight.angle_rising, tight.shaft_torque.values / RATIO**2 * np.full((2, 1), compliance("first")), rtol=1e-8
    )


def friction_loop(points: int = 40) -> tuple[xr.Dataset, float]:
    """A reducer whose planet bearings slide with friction, at the sun; and the friction force [N]."""
    slip = 0.3125 * 40  # between two of 40 torques, so that the trapezoids of the loop lose nothing
    force = 2 * slip / (PLANETS["first"] * PITCH)
    bearing = {"clearance": f"{CLEARANCE} m", "friction": {"force": f"{force!r} N", "law": "coulomb"}}
    return epicyclic.output(one_stage(**bearing), shaft="sun", phases=2, points=points), force  # type: ignore[arg-type]


def test_friction_of_the_seats_makes_a_loop_of_known_area() -> None:
    result, force = friction_loop()
    area = PLANETS["first"] * 4 * CLEARANCE * force  # from stop to stop and back against the friction
    assert mean(result, "hysteresis_energy") == pytest.approx(area, rel=1e-8)
    # the other route: the area between the branches
    torque, up, down = result.shaft_torque.values, result.angle_rising.values[0], result.angle_falling.values[0]
    assert trapezoid(torque, up) - trapezoid(torque, down) == pytest.approx(area, rel=1e-6)
    # branches lie two clearances apart until the friction is overcome, and are one beyond
    apart = np.where(np.abs(torque) < 0.3125 * 40, 2 * CLEARANCE * 2 / PITCH, 0.0)
    np.testing.assert_allclose(down - up, apart, atol=1e-9 * apart.max())
    spring = compliance("first") + (2 / PITCH) ** 2 / (PLANETS["first"] * BEARING)
    assert mean(result, "lost_motion") == pytest.approx(2 * (half_play("first") + 0.03 * 40 * spring), rel=1e-8)


def test_friction_without_a_memory_has_no_loop() -> None:
    bearing = {"clearance": f"{CLEARANCE} m", "friction": {"force": "300 N", "law": "holonomic"}}
    result = epicyclic.output(one_stage(**bearing), shaft="sun", phases=2)  # type: ignore[arg-type]
    assert not result.hysteresis_energy.values.any()
    np.testing.assert_array_equal(result.angle_falling, result.angle_rising)


def own_inertia(name: str) -> float:
    """Inertia of a stage at its sun, ring held [kg m^2]: gears of 1 kg at their base radius, planets of 1 kg."""
    base = {gear: arm(name) * teeth / TEETH["sun"] for gear, teeth in TEETH.items()}
    if name == "second":  # arms are along the normal of helical teeth
        module = 3e-3 / np.cos(np.radians(15))
        pressure = np.arctan(np.tan(np.radians(20)) / np.cos(np.radians(15)))
        base = {gear: module * teeth / 2 * np.cos(pressure) for gear, teeth in TEETH.items()}
    module = {"first": 2e-3, "second": 3e-3 / np.cos(np.radians(15))}[name]
    orbit = module * (TEETH["sun"] + TEETH["planet"]) / 2 / RATIO
    spin = 1 / RATIO - (1 - 1 / RATIO) * TEETH["sun"] / TEETH["planet"]
    planets = PLANETS[name] * (orbit**2 + base["planet"] ** 2 * spin**2)
    return float(base["sun"] ** 2 + planets + 0.001 / RATIO**2)


def test_inertia_is_reflected_with_the_square_of_the_ratio() -> None:
    one = epicyclic.output(one_stage(), phases=1, points=4).reflected_inertia
    assert float(one.sel(port="first.sun")) == pytest.approx(own_inertia("first"), rel=1e-9)
    assert float(one.sel(port="first.carrier")) == pytest.approx(own_inertia("first") * RATIO**2, rel=1e-9)
    assert np.isnan(one.sel(port="first.ring"))
    two = epicyclic.output(turning(two_stages()), phases=1, points=4).reflected_inertia
    whole = own_inertia("first") + own_inertia("second") / RATIO**2
    assert float(two.sel(port="first.sun")) == pytest.approx(whole, rel=1e-9)
    assert float(two.sel(port="second.carrier")) == pytest.approx(whole * RATIO**4, rel=1e-9)


def test_the_starting_torque_is_the_loss_per_speed() -> None:
    result = epicyclic.output(one_stage(), friction=0.06, phases=1, points=4)
    loss = float(epicyclic.efficiency(one_stage(), friction=0.06).power_loss)
    speed = 900 * 2 * pi / 60
    assert float(result.starting_torque.sel(port="first.sun")) == pytest.approx(loss / speed, rel=1e-9)
    assert float(result.starting_torque.sel(port="first.carrier")) == pytest.approx(RATIO * loss / speed, rel=1e-9)
    without = epicyclic.output(one_stage(), phases=1, points=4)
    assert np.isnan(without.starting_torque).all()
    assert without.attrs["starting_torque_reason"] == "no friction of the teeth is given"


def test_a_train_without_backlash_has_stiffness_and_no_lost_motion() -> None:
    model = one_stage()
    for mesh in model["stages"]["first"]["meshes"].values():
        del mesh["backlash"]
    result = epicyclic.output(model, phases=2)
    assert mean(result, "shaft_secant_stiffness") == pytest.approx(RATIO**2 / compliance("first"), rel=1e-8)
    angle = result.shaft_torque.values * compliance("first") / RATIO**2
    np.testing.assert_allclose(result.angle_rising, np.tile(angle, (2, 1)), rtol=1e-8)
    assert np.isnan([result.lost_motion.values, result.shaft_backlash.values]).all()
    assert "no-backlash" in result.attrs["warnings"]
    curve = epicyclic.plot("torque-angle", result).data[0]
    assert [one is None for one in curve.x].index(True) == np.searchsorted(result.shaft_torque, 0)  # no line joins them
    assert len(key_figures(result)) == 1
    model["stages"]["first"]["planet"]["bearing"] = {
        "radial": f"{BEARING} N/m",
        "clearance": "7 um",
        "friction": {"force": "300 N", "law": "coulomb"},
    }
    with pytest.raises(ModelError, match=r"stages.first.meshes.sun-planet.backlash: is missing"):
        epicyclic.output(model)


def test_stiffness_over_the_mesh_cycle_is_that_of_static() -> None:
    """The other route: `static` of the file that holds the other shafts, at the same places of its mesh cycle."""
    model = one_stage()
    model["stages"]["first"]["meshes"]["sun-planet"]["variation"] = {"cosine": [0.3]}
    result = epicyclic.output(model, phases=5)
    locked = {"held": ["ring", "sun"]}
    angle = [
        epicyclic.static(
            {**model, "operation": {**locked, "torque": {"carrier": f"{torque} N m"}}}, samples=5, cycles=1
        )
        .angle.sel(body="first/carrier")
        .values
        for torque in (-180, -90)
    ]
    each = -90 / (angle[0] - angle[1])
    np.testing.assert_allclose(result.shaft_secant_stiffness, [each.mean(), each.min(), each.max()], rtol=1e-8)
    np.testing.assert_allclose(result.angle_rising.sel(shaft_torque=-180), angle[0], rtol=1e-8)
    assert np.ptp(each) > 0.02 * each.mean()


def test_the_rated_torque_is_stated_by_the_file_or_its_case() -> None:
    model = one_stage()
    assumed, words = (
        epicyclic.output(model, phases=1, points=4),
        "No rated torque is given: it is the torque of operation.",
    )
    assert assumed.attrs["rated_by"] == "operation"
    assert words in tables(assumed)[0].lead
    model["operation"]["rated"] = {"carrier": "100 N m"}
    model["cases"] = {"low": {"rated": {"carrier": "50 N m"}}, "high": {"torque": {"sun": "80 N m"}}}
    stated = epicyclic.output(model, phases=1, points=4)
    assert float(stated.rated_torque) == 100
    assert words not in tables(stated)[0].lead
    assert float(epicyclic.output(model, rated="70 N m", phases=1, points=4).rated_torque) == 70
    both = epicyclic.output(model, overrides={"case": "all"}, phases=1, points=4)
    assert both.rated_torque.sel(case=["low", "high"]).values.tolist() == [50, 100]
    with pytest.raises(ModelError, match=r"rated.first.sunn = 5 N m: no such member"):
        epicyclic.output(model, overrides={"operation.rated.sunn": "5 N m"})


def test_the_lost_motion_of_a_drawing_follows_its_tolerances() -> None:
    """A gap of the sun meshes that all planets share opens the play: the quantiles are those of the gap."""
    model = one_stage()
    model["tolerance"] = {
        "deviations.meshes.sun-planet.gap": {"own": "uniform(0 um, 0 um)", "common": "uniform(0 um, 20 um)"},
        "operation.torque.sun": "uniform(30 N m, 50 N m)",  # of the operation, not of the bench
    }
    result = epicyclic.output(model, phases=1, samples=2048)  # of each scramble one in 128 parts of the range
    elastic = 0.03 * 40 / RATIO * compliance("first")
    gap = np.array([0.5, 0.95, 0.99]) * 20e-6
    lost = (2 * half_play("first") + gap / arm("first")) / RATIO + 2 * elastic
    np.testing.assert_allclose(result.lost_motion_quantile, lost, rtol=1e-3)
    assert float(result.lost_motion_mean) == pytest.approx(lost[0], rel=1e-3)
    assert mean(result, "lost_motion") == pytest.approx(2 * half_play("first") / RATIO + 2 * elastic, rel=1e-8)
    (drawn,) = [table for table in tables(result) if "tolerances" in table.title]
    assert drawn.columns["99 % at most"][drawn.columns[""].index("lost motion")] == pytest.approx(
        lost[2] / ARCMIN, rel=1e-3
    )


def test_each_sample_is_the_train_that_its_overrides_make() -> None:
    """The other route: the trains of single samples, loaded anew, with clearances and displaced pins."""
    model = one_stage(clearance=f"{CLEARANCE} m")
    model["tolerance"] = {
        "deviations.planet.position": "disc(30 um)",
        "stages.first.meshes.sun-planet.stiffness": "uniform(1e8 N/m, 3e8 N/m)",
    }
    train = epicyclic.load(model)
    shaft = output_shaft(train, "carrier", None, None)
    locked = locked_train(train, shaft)
    lost, _ = sampled_loops(locked, (0.03, 0.005), 256, 1)
    plan, drawn = sampling_plan(256, seed=1), tolerance_map(locked)
    known = np.flatnonzero(~np.isnan(lost[:, 0]))
    assert known.size > 0.95 * len(lost)
    for number in known[[0, 17, 200]].tolist():
        scramble, row = divmod(number, plan.rows)
        overrides = drawn.overrides(scramble_uniforms(plan, scramble, drawn.dimension_entry.size)[row])
        one = epicyclic.output({**model, "tolerance": {}}, shaft="carrier", overrides=overrides, phases=1)
        assert lost[number, 0] == pytest.approx(mean(one, "lost_motion"), rel=1e-6)
        assert lost[number, 2] == pytest.approx(mean(one, "shaft_secant_stiffness"), rel=1e-6)
    assert np.ptp(lost[known, 0]) > 0.1 * lost[known, 0].mean()


def test_a_study_takes_its_numbers() -> None:
    job = {
        "verb": "output",
        "model": one_stage(),
        "options": {"phases": 1, "points": 4},
        "grid": {"stages.first.meshes.sun-planet.backlash": ["0 um", "60 um"]},
        "keep": ["lost_motion"],
    }
    lost = epicyclic.study(job).lost_motion.values[:, 0]
    assert lost[1] - lost[0] == pytest.approx(BACKLASH["first"][0] / arm("first") / RATIO, rel=1e-8)


def differential() -> dict[str, Any]:
    model = one_stage()
    model["operation"] = {
        "speed": {"sun": "900 rpm", "ring": "100 rpm"},
        "torque": {"sun": "40 N m", "carrier": "balance", "ring": "balance"},
    }
    return model


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"shaft": "planet"}, "shaft = first.planet: turns about an axis of its own"),
        ({"shaft": "carrierr"}, "shaft = carrierr: no such member.*carrier"),
        ({"held": ["sun", "carrier"]}, "held = first.carrier: is the shaft that is seen"),
        ({"held": []}, "held = first.ring: leaves first.carrier free to turn.*also first.sun"),
        ({"share": 0.01, "backlash_share": 0.02}, "backlash_share = 0.02: out of range"),
        ({"shaft": "ring", "rated": "-3 N m"}, "rated"),
    ],
)
def test_what_cannot_be_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        epicyclic.output(one_stage(), **options)


def test_a_differential_needs_both_other_shafts_locked() -> None:
    model = differential()
    with pytest.raises(
        ModelError, match=r"held = first.sun: leaves first.carrier free to turn; allowed: also first.ring"
    ):
        epicyclic.output(model, shaft="carrier", held=["sun"])
    result = epicyclic.output(model, shaft="carrier", phases=1)
    assert set(result.attrs["locked_shafts"].split(", ")) == {"first.sun", "first.ring"}
    assert mean(result, "shaft_secant_stiffness") == pytest.approx(RATIO**2 / compliance("first"), rel=1e-8)
    with pytest.raises(ModelError, match=r"shaft: power leaves by several shafts|operation.torque: no torque says"):
        epicyclic.output({**model, "operation": {"speed": model["operation"]["speed"]}})


def test_a_shaft_that_the_file_locks_is_let_go_and_a_locked_file_is_taken() -> None:
    ring = epicyclic.output(one_stage(), shaft="ring", rated=50.0, phases=1)
    assert set(ring.attrs["locked_shafts"].split(", ")) == {"first.sun", "first.carrier"}
    assert mean(ring, "shaft_secant_stiffness") == pytest.approx(
        (TEETH["ring"] / TEETH["sun"]) ** 2 / compliance("first")
    )
    locked = epicyclic.output(two_stages(), phases=1)
    assert locked.attrs["shaft"] == "first.sun"
    assert mean(locked, "shaft_secant_stiffness") == pytest.approx(1 / at_first_sun(), rel=1e-8)
    assert np.isnan(locked.reflected_inertia).all()


def test_without_a_torque_the_rated_one_is_asked_for() -> None:
    model = deepcopy(one_stage())
    del model["operation"]["torque"]
    with pytest.raises(ModelError, match=r"rated: first.carrier has no rated torque"):
        epicyclic.output(model, shaft="carrier")
    assert mean(epicyclic.output(model, shaft="carrier", rated=9.0, phases=1), "shaft_secant_stiffness") > 0


def test_a_shaft_coupled_to_what_is_held_cannot_turn() -> None:
    model = one_stage()
    model["bodies"] = {"brake": {"mass": "1 kg", "inertia": "0.01 kg m^2"}, "arm": {"inertia": "0.01 kg m^2"}}
    model["couplings"] = {"c": {"between": ["brake", "arm"], "rz": "1e5 N m/rad"}}
    model["operation"]["held"] = ["ring", "brake"]
    with pytest.raises(ModelError, match=r"shaft = arm: cannot turn: held are first.ring, brake"):
        epicyclic.output(model, shaft="arm", rated=5.0)


def test_tables_and_the_figure_say_the_numbers() -> None:
    result, _ = friction_loop(8)
    text = json.dumps([table.columns for table in tables(result)], default=str)
    assert "lost motion" in text
    assert "positive. Lost motion at 3 %, backlash at 0.5 % of the rated torque" in tables(result)[0].lead
    (stiffness, _), (lost, _) = key_figures(result)
    assert float(stiffness.split()[0]) == pytest.approx(mean(result, "shaft_secant_stiffness") * ARCMIN, rel=1e-3)
    assert float(lost.split()[0]) == pytest.approx(mean(result, "lost_motion") / ARCMIN, rel=1e-3)
    (finding,) = findings(result, {})
    assert (finding.tone, lost in finding.text) == ("", True)
    figure = epicyclic.plot("torque-angle", result)
    (marked,) = [trace for trace in figure.data if trace.name.startswith("lost motion")]
    assert np.diff(marked.x)[0] * ARCMIN == pytest.approx(mean(result, "lost_motion"), rel=1e-4)
    assert [shape.y0 for shape in figure.layout.shapes] == pytest.approx([-1.2, 1.2, -40, 40])


def eccentric(run_out: float, **sun: Any) -> dict[str, Any]:
    """A reducer whose sun is eccentric."""
    model = one_stage()
    model["stages"]["first"]["sun"] |= sun
    model["deviations"] = {"sun": {"run_out": f"{run_out} um"}}
    return model


def test_an_eccentric_sun_that_is_held_turns_the_carrier_by_its_nearest_planet() -> None:
    """Hardly loaded, the planet with the least gap carries: the error is the least of three cosines, E / r_b.

    It repeats thrice in a turn of the sun in the carrier, 3 (i - 1) times in a turn of the carrier.
    """
    result = epicyclic.output(eccentric(30), share=1e-3, backlash_share=1e-4, phases=1, points=4)
    size = 30e-6 / arm("first") / RATIO
    assert float(result.kinematic_error_peak_to_peak) == pytest.approx(size / 2, rel=0.02)  # kinks between instants
    order = result.shaft_order.values
    np.testing.assert_array_equal(order, 3 * (RATIO - 1) * np.arange(1, order.size + 1))
    n = 3 * np.arange(1, 5)
    waves = size * 3 / pi * (np.sin((n - 1) * pi / 3) / (n - 1) + np.sin((n + 1) * pi / 3) / (n + 1))
    np.testing.assert_allclose(result.kinematic_error_order[:4], np.abs(waves), rtol=0.02)
    assert float(result.shaft_turn[-1]) > 1.99  # the sun is back after two turns of the carrier
    assert result.kinematic_error.values.mean() == pytest.approx(0, abs=1e-9 * size)


def test_an_eccentric_sun_that_floats_or_is_well_loaded_turns_the_carrier_evenly() -> None:
    """The three errors add up to nothing: a floating sun follows them, and so do three meshes that all carry."""
    floating = epicyclic.output(
        eccentric(30, support={"radial": 0}), share=1e-3, backlash_share=1e-4, phases=1, points=4
    )
    loaded = epicyclic.output(eccentric(1), share=1.0, phases=1, points=4)
    for result in (floating, loaded):
        assert float(result.kinematic_error_peak_to_peak) < 1e-9 * 30e-6 / arm("first")
        assert not result.shaft_order.size


def pair(pinion: int, wheel: int) -> dict[str, Any]:
    """A pinion that is eccentric by 12 um, and its wheel."""
    return {
        "format": 2,
        "title": "a pair",
        "stages": {
            "main": {
                "module": "2 mm",
                "face_width": "20 mm",
                "pinion": {"teeth": pinion, "inertia": "1 kg", "mass": "1 kg"},
                "wheel": {"teeth": wheel, "inertia": "1 kg", "mass": "1 kg"},
                "meshes": {"pinion-wheel": {"stiffness": "2e8 N/m", "backlash": "50 um"}},
            }
        },
        "operation": {"speed": {"pinion": "900 rpm"}, "torque": {"pinion": "10 N m"}},
        "deviations": {"pinion": {"run_out": "12 um"}},
    }


def test_orders_that_a_record_does_not_part_are_exact() -> None:
    """199 turns are a common period, 6 are solved: between the steps of their spectrum 1 and 211/199 are one."""
    model = pair(199, 211)
    model["deviations"]["wheel"] = {"run_out": "7 um"}
    result = epicyclic.output(model, phases=1, points=4)
    assert result.sizes["shaft_turn"] < 7 * 12 * 211
    np.testing.assert_allclose(result.shaft_order, [1, 211 / 199], rtol=1e-12)
    base = 0.211 * np.cos(np.radians(20))
    np.testing.assert_allclose(result.kinematic_error_order, np.array([7e-6, 12e-6]) / base, rtol=1e-7)
    assert result.shaft_order_cause.values.tolist() == [
        "deviations.main.wheel.run_out",
        "deviations.main.pinion.run_out",
    ]
    assert any("the common period has 199" in one for one in json.loads(result.attrs["warnings"]))


def test_of_lines_within_a_step_those_of_the_lowest_mesh_order_are_taken() -> None:
    """Turns of the pinion and of the wheel stand at 211 and 199 beats of the pair, and again at every mesh order."""
    model = pair(199, 211)
    model["deviations"]["wheel"] = {"run_out": "7 um"}
    system = assemble(load(model))
    (tone,) = system.tones
    wheel, pinion = (line.frequency for line in system.lines)
    assert set(near_lines(system, wheel, pinion - wheel)) == {wheel, pinion}
    assert set(near_lines(system, tone / 2, tone / 2)) == {0, wheel, pinion}  # and not tone less wheel
    assert near_lines(system, tone + wheel, wheel / 1000) == [tone + wheel]
    assert near_lines(system, tone / 3, wheel / 1000) == [tone / 3]


def test_an_eccentric_pair_is_a_sine() -> None:
    """One mesh: E / r_b of the wheel at the order of the pinion, the ratio of the teeth."""
    model = pair(20, 50)
    result = epicyclic.output(model, phases=1, points=4)
    base = 0.05 * np.cos(np.radians(20))
    assert float(result.kinematic_error_peak_to_peak) == pytest.approx(2 * 12e-6 / base, rel=1e-3)
    assert result.shaft_order.values.tolist() == [2.5]
    assert float(result.kinematic_error_order[0]) == pytest.approx(12e-6 / base, rel=1e-9)
    drawn = epicyclic.output(
        {**model, "tolerance": {"deviations.pinion.run_out": "uniform(4 um, 20 um)"}}, phases=1, points=4, samples=256
    )
    spread = 2 * np.array([0.5, 0.95, 0.99]) * 16e-6 / base + 2 * 4e-6 / base
    np.testing.assert_allclose(drawn.kinematic_error_quantile, spread, rtol=0.03)  # of 64 trains
    assert float(drawn.kinematic_error_mean) == pytest.approx(spread[0], rel=0.02)
    assert float(drawn.shaft_backlash_mean) == pytest.approx(
        float(drawn.shaft_backlash.sel(over_phases="mean")), rel=0.1
    )
    driving = epicyclic.output(model, shaft="pinion", phases=1, points=4)
    assert driving.attrs["kinematic_error_reason"] == "main.pinion is what drives"
    assert "kinematic_error" not in driving
    assert "No kinematic error" in tables(driving)[-1].lead
    assert epicyclic.plot("kinematic-error", result).data[0].y[0] is not None


def test_a_bearing_of_rolling_elements_stiffens_with_the_torque() -> None:
    """Angle c T + 2 y / r with W = C y^n on a pin: secant, tangent and least squares of this curve."""
    n, load = 1.5, 500.0
    bearing = {"exponent": n, "load": f"{load} N"}
    result = epicyclic.output(one_stage(**bearing), shaft="sun", phases=1, points=200)  # type: ignore[arg-type]
    factor = (BEARING / (n * load ** ((n - 1) / n))) ** n

    def angle(torque: Any) -> Any:
        """Behind the play [rad]."""
        pin = 2 * torque / (PLANETS["first"] * PITCH)
        return torque * compliance("first") + 2 / PITCH * (pin / factor) ** (1 / n)

    torque = result.shaft_torque.values[result.shaft_torque.values > 0]
    np.testing.assert_allclose(
        result.angle_rising.values[0, -torque.size :], angle(torque) + half_play("first"), rtol=1e-8
    )
    assert mean(result, "shaft_secant_stiffness") == pytest.approx(20 / (angle(40) - angle(20)), rel=1e-8)
    upper = torque[torque >= 20 * (1 - 1e-9)]
    centred = upper - upper.mean()
    fitted = (centred @ centred) / (centred @ angle(upper))
    assert mean(result, "shaft_fitted_stiffness") == pytest.approx(fitted, rel=1e-8)
    slope = compliance("first") + 2 / PITCH * angle_of_pin_slope(torque, factor, n)
    inside = slice(-150, -1)
    np.testing.assert_allclose(
        result.shaft_tangent_stiffness.values[0, -torque.size :][inside], 1 / slope[inside], rtol=1e-4
    )


def angle_of_pin_slope(torque: Any, factor: float, n: float) -> Any:
    """Way of a pin per torque on the sun [m/(N m)]."""
    per_torque = 2 / (PLANETS["first"] * PITCH)
    return (per_torque / factor) ** (1 / n) * torque ** (1 / n - 1) / n


@pytest.mark.parametrize("rated", ["0.02 N m", "1 N m"])
def test_a_torque_that_is_small_beside_the_play_is_solved(rated: str) -> None:
    """Forces are differences of stiffness times play there; lost motion is the play and next to nothing."""
    result = epicyclic.output(one_stage(), shaft="carrier", rated=rated, phases=2, points=8)
    size = float(rated.split()[0])
    elastic = 2 * 0.03 * size / RATIO**2 * compliance("first")
    assert mean(result, "lost_motion") == pytest.approx(2 * half_play("first") / RATIO + elastic, rel=1e-5)


def test_members_that_turn_as_one_have_no_kinematic_error() -> None:
    result = epicyclic.output("examples/models/ravigneaux.toml", overrides={"case": "third"}, phases=1, points=4)
    assert "kinematic_error" not in result
    assert result.attrs["kinematic_error_reason"].startswith("members turn as one")
    assert np.isfinite(result.shaft_secant_stiffness).all()


def test_a_ripple_of_the_operation_is_no_kinematic_error() -> None:
    model = eccentric(30)
    plain = epicyclic.output(model, phases=1, points=4)
    model["operation"]["ripple"] = {"sun": [{"order": 2, "torque": "30 N m"}]}
    rippled = epicyclic.output(model, phases=1, points=4)
    np.testing.assert_array_equal(rippled.kinematic_error, plain.kinematic_error)


def test_a_planet_is_no_shaft_that_can_be_locked() -> None:
    with pytest.raises(ModelError, match=r"held = first.planet: turns about an axis of its own.*first.sun"):
        epicyclic.output(one_stage(), shaft="carrier", held=["planet"])
