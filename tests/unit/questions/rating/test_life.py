"""Life of rolling bearings: forces, speeds and races of a planetary set by hand, Miner's sum, laws by their parts."""

from __future__ import annotations

import json
import re
from math import pi
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.bearings.rolling_bearing import (
    RollingBearing,
    basic_life,
    displacement,
    distributed_life,
    equivalent_load,
    life_modification,
    static_rating,
)
from epicyclic.errors import ModelError
from epicyclic.questions.rating.views import life_findings as findings
from epicyclic.questions.rating.views import life_key_figures as key_figures
from epicyclic.questions.rating.views import life_tables as tables
from epicyclic.statics.record import record_of
from epicyclic.statics.static import held_train, quasi_static
from epicyclic.statics.tangent import _slow_forces, linear
from epicyclic.system.assembly import assemble
from epicyclic.train.resolution import load

TEETH, MODULE, TORQUE, RPM = (24, 30, 84), 4e-3, 3000.0, 60.0
ARM = MODULE * (TEETH[0] + TEETH[1]) / 2
PARTS = {
    "type": "cylindrical roller",
    "elements": 14,
    "element_diameter": "12 mm",
    "element_length": "16 mm",
    "pitch_diameter": "70 mm",
    "internal_clearance": "30 um",
}
BEARING = RollingBearing(
    type="cylindrical roller",
    elements=14,
    element_diameter=12e-3,
    element_length=16e-3,
    pitch_diameter=70e-3,
    clearance=30e-6,
)


def train(**bearing: Any) -> dict[str, Any]:
    """Three equal planets on rollers, the carrier turns; no errors and no weight."""
    members = {
        name: {"teeth": z, "mass": "1 kg", "inertia": "1 kg"}
        for name, z in zip(("sun", "ring"), TEETH[::2], strict=True)
    }
    return {
        "format": 2,
        "title": "three planets on rollers",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                "planets": 3,
                "module": f"{MODULE} m",
                "face_width": "30 mm",
                **members,
                "planet": {"teeth": TEETH[1], "mass": "1 kg", "inertia": "1 kg", "bearing": {**PARTS, **bearing}},
                "carrier": {"mass": "5 kg", "inertia": "5 kg"},
                "meshes": {name: {"stiffness": "4e8 N/m"} for name in ("sun-planet", "planet-ring")},
            }
        },
        "operation": {"held": ["ring"], "speed": {"carrier": f"{RPM} rpm"}, "torque": {"carrier": f"{TORQUE} N m"}},
    }


def test_the_life_of_planet_bearings_by_hand() -> None:
    """F = T/(3 a) at the pin; the planet turns at z_r/z_p times the carrier against it, and so does its outer race."""
    result = epicyclic.life(train(), instants=16)
    force, speed = TORQUE / 3 / ARM, RPM / 60 * TEETH[2] / TEETH[1]
    assert result.bearing.values.tolist() == [f"main/planet/{i}/bearing" for i in (1, 2, 3)]
    np.testing.assert_allclose(result.bearing_load, force, rtol=1e-6)
    np.testing.assert_allclose(result.race_speed, 2 * pi * speed, rtol=1e-12)
    assert set(result.turning_race.values.ravel()) == {"outer"}
    basic = float(basic_life(BEARING, force))
    np.testing.assert_allclose(result.bearing_life_basic, basic * 1e6 / speed, rtol=1e-5)
    exact = float(distributed_life(BEARING, displacement(BEARING, [force]), turning="outer"))
    np.testing.assert_allclose(result.bearing_life_reference, exact * 1e6 / speed, rtol=5e-3)
    np.testing.assert_allclose(result.bearing_duty_life_reference, result.bearing_life_reference[:, 0], rtol=1e-12)
    assert np.isnan(result.bearing_life_modified).all()
    Z, gamma = 14, 12 / 70
    np.testing.assert_allclose(result.outer_race_frequency, Z * speed * (1 - gamma) / 2, rtol=1e-12)
    np.testing.assert_allclose(result.inner_race_frequency, Z * speed * (1 + gamma) / 2, rtol=1e-12)
    loads = result.element_load.values[0, 0]
    assert loads @ np.cos(result.element_angle.values[0, 0] - result.element_angle.values[0, 0, 0]) == pytest.approx(
        force, rel=0.03
    )  # of 14 true elements


def test_the_law_of_the_link_is_that_of_its_elements() -> None:
    """Static displacement of a pin under its force, by the table of the link and by the elements themselves."""
    made = load(train())
    (link,) = [one for one in made.links if one.name == "main/planet/1/bearing"]
    curve = dict(link.curves)[0]
    assert curve.deflection[0] == pytest.approx(15e-6, rel=1e-3)  # half of the internal clearance
    for force in (200.0, 3000.0, 12000.0):
        exact = displacement(BEARING, [force])[0]
        assert float(curve.inverse([force])[0][0]) == pytest.approx(exact, rel=2e-3)
    result = epicyclic.static(made, cycles=1)
    force = TORQUE / 3 / ARM
    np.testing.assert_allclose(result.group_force.sel(group="main/planet/1/bearing"), force, rtol=1e-6)
    stretch = result.group_stretch.sel(group="main/planet/1/bearing").values
    np.testing.assert_allclose(stretch, displacement(BEARING, [force])[0], rtol=2e-3)


def test_a_stiffness_by_hand_stays_and_the_parts_are_for_the_life() -> None:
    made = load(train(radial="2e8 N/m"))
    (link,) = [one for one in made.links if one.name == "main/planet/1/bearing"]
    assert (link.stiffness[:2], link.curves) == ((2e8, 2e8), ())
    by_hand, by_parts = (epicyclic.life(train(**one), instants=16) for one in ({"radial": "2e8 N/m"}, {}))
    np.testing.assert_allclose(by_hand.bearing_life_reference, by_parts.bearing_life_reference, rtol=1e-4)


def test_ratings_of_the_catalogue_and_the_oil() -> None:
    plain = epicyclic.life(train(), instants=16)
    rating = 1.2 * float(plain.bearing_rating[0])
    oiled = {"viscosity_ratio": 0.8, "contamination": 0.4}
    stated = epicyclic.life(train(rating=f"{rating} N", **oiled), instants=16)
    np.testing.assert_allclose(stated.bearing_rating, rating, rtol=1e-12)
    np.testing.assert_allclose(stated.bearing_life_basic, 1.2 ** (10 / 3) * plain.bearing_life_basic, rtol=1e-9)
    (factor,) = set((stated.bearing_life_modified / stated.bearing_life_reference).values.ravel().round(12))
    one = RollingBearing(**{**{name: getattr(BEARING, name) for name in BEARING.__slots__}, "rating": rating})
    speed = float(stated.race_speed[0, 0]) / 2 / pi
    load_of_life = equivalent_load(one, float(stated.bearing_life_reference[0, 0]) * speed / 1e6)
    assert factor == pytest.approx(float(life_modification(one, load_of_life, kappa=0.8, contamination=0.4)), rel=1e-9)


def test_cases_are_summed_by_miner() -> None:
    model = train()
    model["cases"] = {
        "low": {"share": 0.7, "torque": {"carrier": "2000 N m"}},
        "high": {"share": 0.3, "torque": {"carrier": "5000 N m"}, "speed": {"carrier": "30 rpm"}},
    }
    result = epicyclic.life(model, overrides={"case": "all"}, instants=16)
    each = result.bearing_life_reference.sel(case=["low", "high"]).values
    damage = np.array([0.7, 0.3]) / each
    np.testing.assert_allclose(result.bearing_duty_life_reference, 1 / damage.sum(axis=1), rtol=1e-12)
    np.testing.assert_allclose(result.damage_share, damage / damage.sum(axis=1, keepdims=True), rtol=1e-12)
    high = epicyclic.life(model, overrides={"case": "high"}, instants=16)
    np.testing.assert_allclose(high.bearing_life_reference[:, 0], each[:, 1], rtol=1e-12)
    (finding,) = findings(result, {})
    assert "most of its damage in high" in finding.text
    (figure,) = key_figures(result)
    assert figure[0] in finding.text
    assert tables(result)[1].columns["case"] == ["low", "high"] * 3
    drawn = epicyclic.plot("load-zones", result).data[0]
    assert drawn.y[list(drawn.x).index(0)] == max(drawn.y) > 0
    assert drawn.name.endswith("high")


def drum(held: bool = False, **more: Any) -> dict[str, Any]:
    """A drum of 50 kg in a bearing of its own, driven by the carrier or held."""
    model = {**train(), **more}
    model["bodies"] = {"drum": {"mass": "50 kg", "inertia": "1 kg m^2", "support": {**PARTS, "internal_clearance": 0}}}
    if held:
        model["operation"]["held"] = ["ring", "drum"]
    else:
        model["couplings"] = {"shaft": {"between": ["main.carrier", "drum"], "rz": "1e6 N m/rad"}}
    return model


def test_a_weight_stands_in_the_housing_and_an_unbalance_turns_with_the_shaft() -> None:
    """Under the weight the outer race stands and the inner one turns, under a load that goes round the outer one."""
    model = drum()
    model["operation"]["gravity"] = True
    hung = epicyclic.life(model, instants=64).sel(bearing="drum/support")
    assert hung.bearing_load.item() == pytest.approx(50 * 9.81, rel=1e-4)
    assert hung.turning_race.item() == "inner"
    model = drum(loads={"pull": {"on": "drum", "force": {"x": "500 N"}, "frame": "member"}})
    swung = epicyclic.life(model, instants=64).sel(bearing="drum/support")
    assert swung.bearing_load.item() == pytest.approx(500, rel=1e-4)
    assert swung.turning_race.item() == "outer"


def test_races_that_stand_are_told() -> None:
    result = epicyclic.life(drum(held=True, loads={"pull": {"on": "drum", "force": {"x": "500 N"}}}), instants=64)
    assert np.isinf(result.bearing_life_reference.sel(bearing="drum/support")).all()
    assert "races of drum/support do not turn" in " ".join(json.loads(result.attrs["warnings"]))


def test_a_contact_angle_makes_a_law_of_five_rows() -> None:
    """Static motion of helical planets on tapered rollers in O against the equilibrium of the elements alone."""
    tapered = {"type": "tapered roller", "contact_angle": "14 deg", "rows": 2, "row_distance": "30 mm"}
    model = train(**tapered)
    model["stages"]["main"]["helix_angle"] = "12 deg"
    made = load(model)
    (link,) = [one for one in made.links if one.name == "main/planet/2/bearing"]
    assert link.rolling is not None
    assert link.contacts is not None
    system = assemble(made)
    record = record_of(system, cycles=1, turns=None, of=None, samples=4, most=4)
    (piece,) = quasi_static(held_train(system), record)
    rows = [row for group in system.groups for row in group.rows]
    own = [rows.index(f"{link.name}/{axis}") for axis in ("x", "y", "z", "rx", "ry")]
    force, motion = piece.state.group_force[:, own], piece.state.group_stretch[:, own]
    assert np.abs(force[:, 3:]).min(axis=0).max() > 1.0  # the thrusts of sun and ring tilt the planet
    exact = displacement(link.rolling, force, places=36, laminae=3)
    np.testing.assert_allclose(motion, exact, rtol=1e-6, atol=1e-6 * np.abs(exact).max())
    result = epicyclic.life(model, instants=16)
    assert np.isnan(result.bearing_life_basic).all()
    radial = epicyclic.life(train(**{**tapered, "radial": "1e9 N/m", "tilt": 0}), instants=16)
    assert (result.bearing_life_reference.values < radial.bearing_life_reference.values).all()


def test_balls_whose_z_has_a_stiffness_live_under_the_thrust() -> None:
    """Of the sun of three equal planets thrust is all that its bearing carries: T/r tan(helix)."""
    ball = RollingBearing(
        type="deep groove ball", elements=9, element_diameter=15e-3, pitch_diameter=58e-3, clearance=20e-6
    )
    stated = {"elements": 9, "element_diameter": "15 mm", "pitch_diameter": "58 mm", "internal_clearance": "20 um"}
    model = train()
    model["stages"]["main"]["helix_angle"] = "12 deg"
    model["stages"]["main"]["sun"]["support"] = {"type": ball.type, **stated, "z": "1e8 N/m", "tilt": 0}
    result = epicyclic.life(model, instants=8)
    thrust = TORQUE / (1 + TEETH[2] / TEETH[0]) / (MODULE * TEETH[0] / 2) * np.sin(np.radians(12))
    life = distributed_life(ball, displacement(ball, [[0.0, 0.0, thrust]]), turning="inner")
    found = result.sel(bearing="main/sun/support")
    turn = 1e6 * 2 * np.pi / found.race_speed
    np.testing.assert_allclose(found.bearing_life_reference, life * turn, rtol=2e-2)  # some 0.2 % of it is radial
    assert np.isnan(found.bearing_life_basic)
    np.testing.assert_allclose(found.bearing_load, equivalent_load(ball, found.bearing_life_reference / turn))
    assert "main/sun/support" not in result.attrs["warnings"]
    model["stages"]["main"]["sun"]["support"] = {**PARTS, "z": "1e8 N/m", "tilt": 0}  # rollers do not carry it
    assert "main/sun/support" in epicyclic.life(model, instants=8).attrs["warnings"]


def test_two_bearings_at_a_distance_carry_the_moment_of_helical_teeth() -> None:
    """Front and rear of a planet: their difference times half of the distance is the moment of the two thrusts."""
    one = {**PARTS, "internal_clearance": 0}
    model = train()
    model["stages"]["main"]["helix_angle"] = "12 deg"
    model["stages"]["main"]["planet"]["bearing"] = {"front": {**one, "at": "-12 mm"}, "rear": {**one, "at": "12 mm"}}
    made = load(model)
    result = epicyclic.life(made, instants=8)
    system = assemble(made)
    (piece,) = quasi_static(held_train(system), record_of(system, cycles=1, turns=None, of=None, samples=2, most=2))
    rows = [row for group in system.groups for row in group.rows]
    forces = {row: piece.state.group_force[0, i] for i, row in enumerate(rows)}
    radial = [forces[f"main/planet/1/bearing/{end}/x"] for end in ("front", "rear")]  # along the centre line
    moment = TORQUE / 3 / ARM * np.tan(np.radians(12)) * MODULE * TEETH[1] / 2 * np.cos(np.radians(12))
    assert 0.94 * moment < abs(radial[0] - radial[1]) * 12e-3 < moment  # slices of the teeth take the rest
    assert "thrust-not-counted" not in result.attrs["warnings"]  # the thrusts of both meshes cancel
    model["stages"]["main"]["sun"]["support"] = one
    assert "main/sun/support: helical teeth push" in epicyclic.life(model, instants=8).attrs["warnings"]
    model["stages"]["main"]["planet"]["bearing"] = one
    single = epicyclic.life(model, instants=8)
    assert "rx or ry hold rigidly" in single.attrs["warnings"]


def test_pressed_rollers_and_two_rows() -> None:
    """Below zero the clearance presses: the curve begins at the centre with a slope."""
    (pressed,) = [one for one in load(train(internal_clearance="-10 um")).links if one.name == "main/planet/1/bearing"]
    curve = dict(pressed.curves)[0]
    assert (curve.deflection[0], curve.force[0], curve.slope[0] > 1e8) == (0.0, 0.0, True)
    (rows,) = [one for one in load(train(rows=2)).links if one.name == "main/planet/1/bearing"]
    assert rows.contacts is not None
    assert (rows.stiffness[2], rows.stiffness[3] > 0) == (np.inf, True)
    assert rows.rolling is not None
    assert rows.rolling.row_distance == pytest.approx(16e-3)
    o, x = (load(train(type="tapered roller", contact_angle="14 deg", rows=2, arrangement=one)) for one in "OX")
    stiff, soft = (next(one.stiffness[3] for one in made.links if one.contacts) for made in (o, x))
    assert stiff > 2 * soft


def test_a_force_that_changes_over_the_turn_is_summed_by_miner() -> None:
    """A planet of 300 kg goes round in its weight: 1/L is the mean of 1/L(F) of the forces at the pin."""
    model = train()
    model["stages"]["main"]["planet"]["mass"] = "300 kg"
    model["operation"]["gravity"] = True
    result = epicyclic.life(model, instants=64).isel(bearing=0, case=0)
    force = epicyclic.static(model, turns=1, of="main/carrier", samples=64).group_force.isel(group=0).values
    lives = distributed_life(BEARING, displacement(BEARING, force[:, None]), turning="outer")
    speed = RPM / 60 * TEETH[2] / TEETH[1]
    assert result.bearing_life_reference.item() == pytest.approx(1e6 / speed / np.mean(1 / lives), rel=0.02)
    assert result.bearing_load.item() == pytest.approx(np.mean(force ** (10 / 3)) ** 0.3, rel=0.01)
    assert lives.max() > 2.5 * lives.min()


@pytest.mark.parametrize(("drive", "sense"), [("planetary", 1), ("star", -1)])
def test_the_inner_race_is_on_the_pin(drive: str, sense: int) -> None:
    """Of a planet on a carrier the first body is the carrier, of one on a pin in the housing the planet."""
    model = train(type="tapered roller", contact_angle="14 deg")
    if drive == "star":
        del model["stages"]["main"]["carrier"]
        model["operation"] = {"speed": {"sun": f"{RPM} rpm"}, "torque": {"sun": "100 N m"}}
    (link,) = [one for one in load(model).links if one.name == "main/planet/1/bearing"]
    assert (link.second is None) == (drive == "star")
    assert link.contacts is not None
    thrust = np.array(link.contacts.normals)[:, 2]
    np.testing.assert_allclose(thrust, sense * np.sin(np.radians(14)), rtol=1e-9)


def test_a_direction_by_hand_stands_beside_the_law_of_the_parts() -> None:
    """The parts hold what is not stated: x and y of one row, x, y and tilt of two tapered ones whose z is stated."""
    (one,) = [link for link in load(train(z="1e8 N/m")).links if link.name == "main/planet/1/bearing"]
    (plain,) = [link for link in load(train()).links if link.name == "main/planet/1/bearing"]
    assert one.curves == plain.curves != ()
    assert one.stiffness[2] == 1e8
    tapered = {"type": "tapered roller", "contact_angle": "14 deg", "rows": 2}
    (free,) = [link for link in load(train(**tapered, z=0)).links if link.name == "main/planet/1/bearing"]
    assert free.contacts is not None
    assert not np.array(free.contacts.normals)[:, 2].any()
    assert free.stiffness[2] == 0
    assert min(free.stiffness[0], free.stiffness[3]) > 0


def test_a_case_that_fails_is_left_out_and_a_train_that_stands_is_refused() -> None:
    model = train()
    model["cases"] = {
        "run": {"share": 0.5},
        "stand": {"share": 0.5, "speed": {"carrier": "0 rpm"}},
    }
    result = epicyclic.life(model, overrides={"case": "all"}, instants=16)
    assert result.case.values.tolist() == ["run"]
    assert result.case_share.values.tolist() == [0.5]
    alone = epicyclic.life(model, overrides={"case": "run"}, instants=16)
    np.testing.assert_allclose(result.bearing_duty_life_reference, 2 * alone.bearing_duty_life_reference, rtol=1e-12)
    assert (
        "stand is left out, its share of the time is without load: cases.stand.speed: nothing turns"
        in result.attrs["warnings"]
    )
    with pytest.raises(ModelError, match=r"cases\.stand\.speed: nothing turns"):
        epicyclic.life(model, overrides={"case": "stand"})
    model["operation"]["speed"] = model["cases"]["stand"].pop("speed")
    with pytest.raises(ModelError, match=r"operation\.speed: nothing turns"):
        epicyclic.life(model, overrides={"case": "stand"})


def test_a_bearing_without_load_lives_for_ever() -> None:
    result = epicyclic.life(drum(), instants=16).sel(bearing="drum/support")
    assert np.isinf(result.bearing_life_reference).all()


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "no parts": ({"elements": None}, r"planet\.bearing.*a cylindrical roller bearing without elements"),
    "no length": ({"element_length": None}, r"without element_length"),
    "clearance": ({"clearance": "15 um"}, r"clearance beside a rolling bearing; allowed: internal_clearance"),
    "bolts": (
        {"bolts": {"count": 12, "radius": "60 mm"}},
        r"planet\.bearing\.bolts: bolts beside a rolling bearing; allowed: one of them",
    ),
    "length of a ball": ({"type": "deep groove ball"}, r"planet\.bearing\.element_length: of a ball"),
    "arrangement of one row": (
        {"type": "tapered roller", "contact_angle": "14 deg", "arrangement": "O"},
        r"planet\.bearing\.arrangement = O: no effect; allowed: no such key, or an angular contact or tapered",
    ),
    "arrangement without angle": ({"rows": 2, "arrangement": "X"}, r"planet\.bearing\.arrangement = X: no effect"),
    "overlap": ({"elements": 30}, r"planet\.bearing\.element_diameter.*overlap"),
    "rating": ({"rating": "1 MN"}, r"planet\.bearing\.rating"),
    "no type": ({"type": None}, r"elements without type"),
    "other type": ({"type": "plain"}, r"planet\.bearing\.type"),
    "clearance of the parts": ({"internal_clearance": "5 mm"}, r"planet\.bearing\.internal_clearance"),
    "half of a stiffness": (
        {"y": "1e9 N/m"},
        r"only one of x and y beside a rolling bearing.*; allowed: radial, or both x and y",
    ),
    "half of the oil": ({"contamination": 0.5}, r"half of the oil; allowed: viscosity_ratio and contamination"),
    "angle": ({"contact_angle": "15 deg"}, r"planet\.bearing\.contact_angle"),
}


@pytest.mark.parametrize("name", BAD)
def test_parts_that_do_not_fit_are_named(name: str) -> None:
    changes, words = BAD[name]
    parts = {key: value for key, value in {**PARTS, **changes}.items() if value is not None}
    model = train()
    model["stages"]["main"]["planet"]["bearing"] = parts
    with pytest.raises(ModelError, match=words):
        load(model)


def test_a_drawing_without_parts_says_what_is_missing() -> None:
    with pytest.raises(
        ModelError, match=r"no bearing is stated by its parts; allowed: .cylindrical roller. or another"
    ):
        epicyclic.life("ren2021")


def test_a_thrust_beside_the_law_is_no_error_of_its_tangent() -> None:
    """The warning sets forces along x and y against each other; z of the balls is linear in both."""
    model = train()
    main = model["stages"]["main"]
    main["helix_angle"], model["deviations"] = "12 deg", {"planet": {"run_out": ["5 um", 0, 0]}}
    parts = {"elements": 9, "element_diameter": "15 mm", "pitch_diameter": "58 mm", "internal_clearance": 0}
    main["sun"]["support"] = {"type": "deep groove ball", **parts, "z": "1e8 N/m", "tilt": 0}
    (text,) = [one for one in json.loads(epicyclic.steady(model).attrs["warnings"]) if "[law-over-turn]" in one]
    law, tangent = map(float, re.findall(r"main/sun/support (\S+) kN by the law, (\S+) kN by the tangent", text)[0])
    assert tangent < law < 1.0  # the thrust is 2.9 kN
    assert "(100 % of the largest)" in text


def test_a_load_that_dents_the_races_is_named_with_its_safety() -> None:
    """P_0 = Z Q/5 of the most loaded element, more than the radial force where clearance narrows the zone."""
    model = train()
    model["operation"]["torque"] = {"carrier": "60 kN m"}
    result = epicyclic.life(model, instants=8)
    most = result.element_load.max("element").values[:, 0]
    safety = static_rating(BEARING) / (BEARING.elements * most / 5)
    np.testing.assert_allclose(result.static_safety.values[:, 0], safety, rtol=1e-9)
    assert (safety < 1).all()
    for one in (result, epicyclic.check(model), epicyclic.static(model, cycles=1)):
        assert "main/planet/3/bearing" in one.attrs["warnings"]
        assert "[races-dented]" in one.attrs["warnings"]
    assert "[races-dented]" not in epicyclic.check(train()).attrs["warnings"]


def test_the_warning_sets_forces_of_five_rows_against_forces_without_their_moments() -> None:
    model = train(type="tapered roller", contact_angle="14 deg", rows=2, z="1e8 N/m")
    model["stages"]["main"]["helix_angle"] = "12 deg"
    lawful = assemble(load(model))
    tangent = linear(lawful)
    record = record_of(tangent, cycles=1, turns=None, of=None, samples=2, most=2)
    found = _slow_forces(tangent, lawful, record)[:, -len(lawful.groups) :]
    (piece,) = quasi_static(held_train(tangent), record)
    rows = tangent.links.stiffness * piece.link_deflection + tangent.links.preload
    names = list(tangent.links.name)
    for place, group in enumerate(lawful.groups):
        own = [names.index(f"{group.name}/{axis}") for axis in ("radial", "tangential")]  # z is beside the law
        np.testing.assert_allclose(found[:, place], np.hypot(*rows[:, own].T), rtol=1e-12)
        assert np.abs(rows[:, names.index(f"{group.name}/ry")]).max() > 1.0  # the thrusts tilt the planet
