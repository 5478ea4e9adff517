"""A train that is held so that no member turns: angles, play and stiffness by hand, its modes, what it refuses."""

from __future__ import annotations

import json
from copy import deepcopy
from math import atan, cos, radians, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.check.views import check_headline
from epicyclic.show.brief_check import brief_tables
from epicyclic.statics.sample_loads import mean_loads
from epicyclic.statics.views import key_figures, tables
from epicyclic.system.gaps import flanks
from epicyclic.verbs.record import run_report, verbs

ARCMIN = np.pi / 180 / 60
TEETH = {"sun": 24, "planet": 30, "ring": 84}
RATIO = 1 + 84 / 24  # sun per carrier, ring held
SHAFT = 3e4  # [N m/rad]
SUN, RING = 2e8, 3e8  # stiffness of the meshes [N/m]
BACKLASH = {"first": (60e-6, 80e-6), "second": (90e-6, 50e-6)}  # of the sun and ring meshes [m]
MODULE = {"first": "2 mm", "second": "3 mm"}
HELIX = {"first": 0.0, "second": 15.0}
PLANETS = {"first": 3, "second": 4}


def stage(name: str) -> dict[str, Any]:
    sun, ring = BACKLASH[name]
    return {
        "planets": PLANETS[name],
        "module": MODULE[name],
        "helix_angle": f"{HELIX[name]} deg",
        "face_width": "20 mm",
        "meshes": {
            "sun-planet": {"stiffness": f"{SUN} N/m", "backlash": f"{sun * 1e6} um"},
            "planet-ring": {"stiffness": f"{RING} N/m", "backlash": f"{ring * 1e6} um"},
        },
        **{gear: {"teeth": teeth, "inertia": "1 kg", "mass": "1 kg"} for gear, teeth in TEETH.items()},
        "carrier": {"mass": "1 kg", "inertia": "0.001 kg m^2"},
    }


def two_stages(torque: dict[str, str] | None = None, held: tuple[str, ...] = ("second.carrier",)) -> dict[str, Any]:
    return {
        "format": 2,
        "title": "two stages in series",
        "stages": {"first": stage("first"), "second": stage("second")},
        "couplings": {"shaft": {"between": ["first.carrier", "second.sun"], "rz": f"{SHAFT} N m/rad"}},
        "operation": {"held": ["first.ring", "second.ring", *held], "torque": torque or {"first.sun": "40 N m"}},
    }


def one_stage(torque: float = 12.0) -> dict[str, Any]:
    return {
        "format": 2,
        "title": "carrier locked",
        "stages": {"first": stage("first")},
        "operation": {"held": ["ring", "carrier"], "torque": {"sun": f"{torque!r} N m"}},
    }


def arm(name: str) -> float:
    """Arm of the tooth normal at the sun [m]: base radius times cos beta_b."""
    beta, normal = radians(HELIX[name]), radians(20)
    transverse = atan(tan(normal) / cos(beta))
    size = float(MODULE[name].split()[0]) * 1e-3
    return TEETH["sun"] * size / 2 / cos(beta) * cos(transverse) * sqrt(1 - (sin(beta) * cos(normal)) ** 2)


def compliance(name: str) -> float:
    """Of a stage at its sun, carrier and ring held [rad/(N m)]: meshes of a planet in series, planets in parallel."""
    return (1 / SUN + 1 / RING) / PLANETS[name] / arm(name) ** 2


def half_play(name: str) -> float:
    """Of a stage at its sun [rad]."""
    return sum(BACKLASH[name]) / 2 / arm(name)


def at(result: xr.Dataset, name: str, body: str) -> float:
    values = result[name].sel(body=body).values
    np.testing.assert_allclose(values, values.flat[0], rtol=1e-9)  # constant stiffness: the same wherever it is locked
    return float(values.flat[0])


@pytest.mark.parametrize("torque", [40.0, -40.0])
def test_two_stages_are_a_chain_of_springs(torque: float) -> None:
    result = epicyclic.static(two_stages({"first.sun": f"{torque} N m"}))
    sense = np.sign(torque)
    second = RATIO * torque * compliance("second")
    middle = second + RATIO * torque / SHAFT
    first = torque * compliance("first") + RATIO * middle
    play = half_play("first") + RATIO * half_play("second")
    assert at(result, "angle", "first/sun") == pytest.approx(first + sense * play, rel=1e-9)
    assert at(result, "angle", "first/carrier") == pytest.approx(middle + sense * half_play("second"), rel=1e-9)
    assert at(result, "angle", "second/sun") == pytest.approx(second + sense * half_play("second"), rel=1e-9)
    assert at(result, "play", "first/sun") == pytest.approx(2 * play, rel=1e-9)
    assert at(result, "play", "second/sun") == pytest.approx(2 * half_play("second"), rel=1e-9)
    assert "second/carrier" not in result.body.values
    (stiffness, _), (travel, _) = key_figures(result)
    assert float(stiffness.split()[0]) == pytest.approx(torque / first * ARCMIN, rel=1e-3)
    assert float(travel.split()[0]) == pytest.approx(2 * play / ARCMIN, rel=1e-3)


def test_the_loaded_output_with_the_input_held_is_the_same_chain() -> None:
    result = epicyclic.static(two_stages({"second.carrier": "-2000 N m"}, ("first.sun",)))
    at_input = compliance("first") + RATIO**2 * (1 / SHAFT + compliance("second"))
    play = (half_play("first") + RATIO * half_play("second")) / RATIO**2
    assert at(result, "angle", "second/carrier") == pytest.approx(-2000 * at_input / RATIO**4 - play, rel=1e-9)
    assert at(result, "play", "second/carrier") == pytest.approx(2 * play, rel=1e-9)


def test_two_ways_to_the_housing_bear_one_after_the_other() -> None:
    """The shaft between the stages is loaded, both ends are held: each stage bears behind a play of its own."""
    springs = {
        half_play("second"): 1 / compliance("second"),
        half_play("first") / RATIO: 1 / (1 / SHAFT + compliance("first") / RATIO**2),
    }
    (near, stiff), (far, behind) = sorted(springs.items())
    for torque in (0.5 * stiff * (far - near), 3 * stiff * (far - near)):
        model = two_stages({"second.sun": f"{torque!r} N m"}, ("first.sun", "second.carrier"))
        result = epicyclic.static(model)
        angle = near + torque / stiff
        if angle > far:
            angle = (torque + stiff * near + behind * far) / (stiff + behind)
        assert at(result, "angle", "second/sun") == pytest.approx(angle, rel=1e-9)
        assert at(result, "play", "second/sun") == pytest.approx(2 * near, rel=1e-9)
        # the map of many samples finds the same meshes loaded, all planets alike
        mapped = mean_loads(epicyclic.assemble(epicyclic.load(model)))
        bears = result.mesh_force.values[:, 0] > 0
        np.testing.assert_allclose(mapped, np.where(bears, 1.0, np.nan) * np.ones((2, 1)), rtol=1e-9)


def test_the_angle_is_play_and_elastic_part_through_zero_torque() -> None:
    half, elastic = half_play("first"), compliance("first")
    torques = [1.0, 0.1, 1e-3, 1e-9, 1e-16, 1e-30]  # the last are what an even division of -1 to 1 has in place of zero
    for torque in torques:
        ahead, back = (epicyclic.static(one_stage(sense * torque)) for sense in (1, -1))
        angle = at(ahead, "angle", "first/sun")
        assert angle == pytest.approx(half + torque * elastic, rel=1e-12)
        assert angle - half == pytest.approx(torque * elastic, abs=1e-12 * half)
        assert at(back, "angle", "first/sun") == pytest.approx(-angle, rel=1e-12)
        assert at(back, "play", "first/sun") == pytest.approx(2 * half, rel=1e-9)
    assert abs(at(epicyclic.static(one_stage(0.0)), "angle", "first/sun")) < 1e-12 * half
    # displacements count from there too
    u = epicyclic.static(one_stage(1.0)).displacement.sel(dof="first/sun/rz").values
    np.testing.assert_allclose(u, (half + elastic) * arm("first"), rtol=1e-12)


def test_deviations_of_a_locked_train() -> None:
    torque, half, elastic = 12.0, half_play("first"), compliance("first")
    thin = one_stage(torque) | {"deviations": {"meshes": {"sun-planet": {"gap": "20 um"}}}}
    result = epicyclic.static(thin)  # thin teeth: so much more backlash, on both sides alike
    assert at(result, "play", "first/sun") == pytest.approx(2 * half + 20e-6 / arm("first"), rel=1e-9)
    expected = half + 10e-6 / arm("first") + torque * elastic
    assert at(result, "angle", "first/sun") == pytest.approx(expected, rel=1e-9)
    moved = one_stage(torque) | {"deviations": {"planet": {"position": {"y": "15 um"}, "run_out": "9 um"}}}
    result = epicyclic.static(moved)  # all pins along the circle: the middle of the play moves, and nothing else does
    assert "deviation-without-speed" not in result.attrs["warnings"]
    assert at(result, "play", "first/sun") == pytest.approx(2 * half, rel=1e-6)
    assert at(result, "angle", "first/sun") == pytest.approx(half + torque * elastic, rel=1e-6)
    u = result.displacement.sel(dof="first/sun/rz").values[0]
    assert abs(u - (half + torque * elastic) * arm("first")) > 10e-6


def on_bearings(**bearing: Any) -> dict[str, Any]:
    """One stage, its planets on bearings, its sun afloat."""
    model = one_stage()
    model["stages"]["first"]["sun"]["support"] = {"radial": 0}
    model["stages"]["first"]["planet"]["bearing"] = {"radial": "1e8 N/m", **bearing}
    return model


def test_the_angle_ends_at_the_play_where_a_seat_is_displaced() -> None:
    """One pin along the circle: the sun centres itself, and turns by a third of 2 e cos(alpha) / r."""
    model, error = on_bearings(), 15e-6
    model["deviations"] = {"planet": {"position": {"y": f"[{error * 1e6}, 0, 0] um"}}}
    half, turned = half_play("first"), 2 * error * cos(radians(20)) / 3 / arm("first")
    for torque in (1e-3, -1e-3):
        result = epicyclic.static(model, overrides={"operation.torque.sun": torque})
        # a planet pushes its pin with 2 F cos(alpha), and moves sun and ring mesh by cos(alpha) each
        bearing = 4 * cos(radians(20)) ** 2 / 1e8 / 3 / arm("first") ** 2
        expected = np.sign(torque) * half + torque * (compliance("first") + bearing)
        assert at(result, "angle", "first/sun") == pytest.approx(expected, rel=1e-9)
        assert at(result, "play", "first/sun") == pytest.approx(2 * half, rel=1e-9)
        u = result.displacement.sel(dof="first/sun/rz").values[0]
        assert u == pytest.approx((expected + turned) * arm("first"), rel=1e-9)
    still = epicyclic.static(model, overrides={"operation.torque.sun": 0.0})
    assert abs(at(still, "play", "first/sun") / (2 * half) - 1) < 1e-9
    assert not still.mesh_force.values.any()


def test_clearance_of_the_planet_bearings_is_play() -> None:
    result = epicyclic.static(on_bearings(clearance="10 um"))
    expected = 2 * half_play("first") + 2 * 2 * 10e-6 * cos(radians(20)) / arm("first")
    assert at(result, "play", "first/sun") == pytest.approx(expected, rel=1e-5)


def test_both_senses_of_a_torque_meet_the_same_places_of_the_mesh() -> None:
    model = one_stage()
    model["stages"]["first"]["meshes"]["sun-planet"]["variation"] = {"cosine": [0.2], "sine": [0.1]}
    ahead, back = (epicyclic.static(model, overrides={"operation.torque.sun": torque}) for torque in (9.0, -9.0))
    angle = ahead.angle.sel(body="first/sun").values
    assert np.ptp(angle) > 1e-6
    np.testing.assert_allclose(back.angle.sel(body="first/sun").values, -angle, rtol=1e-9)


def test_flanks_of_a_locked_train_are_open_by_half_the_backlash_each() -> None:
    for held, loaded, far in ((["ring", "carrier"], 30e-6, 30e-6), (["ring"], 0.0, 60e-6)):
        system = epicyclic.assemble(epicyclic.load(one_stage() | {"operation": {"held": held, "torque": {"sun": 9.0}}}))
        count = len(system.meshes.name)
        assert system.flank_opening[0] == pytest.approx(loaded, rel=1e-12)
        assert system.flank_opening[count] == pytest.approx(far, rel=1e-12)
        np.testing.assert_array_equal(flanks(system).opening, system.flank_opening)


def test_without_backlash_there_is_no_play() -> None:
    model = one_stage()
    del model["stages"]["first"]["meshes"]["planet-ring"]["backlash"]
    result = epicyclic.static(model)
    assert "play" not in result.variables
    assert "no backlash is given in first.meshes.planet-ring" in result.attrs["warnings"]
    expected = 12 * compliance("first") + BACKLASH["first"][0] / 2 / arm("first")
    assert at(result, "angle", "first/sun") == pytest.approx(expected, rel=1e-9)
    assert "first touch" in tables(result)[0].title


def test_a_train_that_turns_has_no_angles() -> None:
    result = epicyclic.static(one_stage() | {"operation": {"held": ["ring"], "torque": {"sun": "12 N m"}}})
    assert not {"angle", "play", "torque", "body"} & set(result.variables)
    assert result.displacement.sel(dof="first/sun/rz").values.max() < 1e-6  # from first touch of the loaded flanks


def test_modes_of_a_locked_train() -> None:
    """Sun and planets on rigid pins: sum of k (u_s + u_p)^2 + k u_p^2 in base-circle displacements."""
    n = PLANETS["first"]
    K, M = np.zeros((1 + n, 1 + n)), np.eye(1 + n)  # every gear has J/r^2 = 1 kg
    for planet in range(1, 1 + n):
        K[np.ix_([0, planet], [0, planet])] += SUN
        K[planet, planet] += RING
    expected = np.sqrt(np.linalg.eigvalsh(np.linalg.solve(M, K))) / (2 * np.pi)
    for torque in (12.0, -12.0):
        found = epicyclic.modes(one_stage(torque)).frequency.values
        np.testing.assert_allclose(found, expected, rtol=1e-10)
    assert found[0] > 100  # none is rigid


TURNING = ("campbell", "detune", "efficiency", "modulation", "sharing", "stability", "steady", "sweep", "transient")


def test_verbs_that_need_speeds_refuse() -> None:
    model = one_stage()  # no damping either, which is not what it lacks
    check = epicyclic.check(model)
    needs = dict(zip(check.verb_name.values.tolist(), check.verb_needs.values.tolist(), strict=True))
    for name in TURNING:
        with pytest.raises(ModelError, match="the train is locked: no member turns") as caught:
            verbs()[name].run(model)
        assert caught.value.path == "operation.held"
        assert "the train is locked" in needs[name]
    with pytest.raises(ModelError, match="the train is locked"):
        epicyclic.sensitivity(model | {"damping": {"modal": 0.03}}, of="force")
    assert not needs["static"]
    assert not needs["modes"]
    sharing = epicyclic.sharing(model, method="static")
    np.testing.assert_allclose(sharing.load_sharing.values, 1, rtol=1e-9)


def test_check_says_what_it_is() -> None:
    check = epicyclic.check(two_stages())
    headline = check_headline(check)
    assert headline.startswith("Locked: no member turns; loaded first.sun (40 N m), held first.ring (140 N m), ")
    assert "second.carrier (-810 N m)" in headline
    assert brief_tables(check)[0].lead == headline.split("; first: ")[0] + "."
    assert not np.isfinite(check.hunting_period.values).any()
    assert json.loads(check.attrs["locked"]) == ["first.ring", "second.ring", "second.carrier"]
    turning = epicyclic.check(one_stage() | {"operation": {"held": ["ring"], "torque": {"sun": "12 N m"}}})
    assert json.loads(turning.attrs["locked"]) == []


def test_the_report_of_a_locked_train_has_its_angles() -> None:
    found = run_report(one_stage())
    assert "angle" in found["static"].variables
    assert "campbell" not in found


@pytest.mark.parametrize(
    ("operation", "path", "words"),
    [
        ({"torque": {}}, "operation.held", "the train is locked"),
        ({"speed": {"sun": "100 rpm"}}, "operation.held", "the train is locked"),
        ({"torque": {"ring": "5 N m"}}, "operation.torque.main.ring", "held"),
        ({"torque": {"sun": "12 N m", "planet": "balance"}}, "operation.torque.main.planet", "locked"),
    ],
)
def test_what_a_locked_train_may_not_say(operation: dict[str, Any], path: str, words: str) -> None:
    model = deepcopy(one_stage())
    model["stages"] = {"main": model["stages"]["first"]}
    model["operation"] |= operation
    with pytest.raises(ModelError) as caught:
        epicyclic.load(model)
    assert caught.value.path == path
    assert words in str(caught.value)
    no_speed = one_stage()
    no_speed["operation"]["speed"] = {"sun": 0}
    assert epicyclic.load(no_speed).kinematics.locked  # a speed of 0 is what it has


@pytest.mark.parametrize("torque", [1.0, -100.0])
def test_play_of_a_servo_reducer_on_its_bearings(torque: float) -> None:
    # the carrier is loaded, sun and ring are held: its play is j / (r_pin cos alpha) of the backlash j of both meshes
    seat = {"support": {"radial": "3e8 N/m"}}
    model = {
        "format": 2,
        "title": "Servo reducer",
        "stages": {
            "main": {
                "planets": 3,
                "module": "2 mm",
                "face_width": "34 mm",
                "sun": {"teeth": 21, "support": {"radial": "6.8e6 N/m"}},
                "planet": {"teeth": 39, "bearing": {"radial": "3.4e8 N/m"}},
                "ring": {"teeth": 99, **seat},
                "carrier": {"mass": "3 kg", "inertia": "0.01 kg m^2", **seat},
                "meshes": {pair: {"backlash": "49.2 um"} for pair in ("sun-planet", "planet-ring")},
            }
        },
        "operation": {"held": ["ring", "sun"], "torque": {"carrier": torque}},
    }
    result = epicyclic.static(model)
    play = float(result["play"].sel(body="main/carrier"))
    assert play == pytest.approx(49.2e-6 / (60e-3 * cos(radians(20))), rel=1e-6)
