"""Bearings by their parts in `check` and `static`: nominal forces by hand and by equilibrium, one table."""

from __future__ import annotations

import json
from math import pi, radians, tan
from typing import Any

import numpy as np
import pytest
from tests.unit.questions.rating.test_life import ARM, BEARING, MODULE, PARTS, RPM, TEETH, TORQUE, train

import epicyclic
from epicyclic.bearings.rolling_bearing import contact_set, displacement, load_zone, passing_frequencies, static_safety
from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.questions.check.check import nominal_forces
from epicyclic.questions.check.views import check_tables
from epicyclic.show.brief_check import brief_tables
from epicyclic.statics.views import tables as static_tables
from epicyclic.train.resolution import load

FORCE = TORQUE / 3 / ARM
STATES = (
    *("bearing_force_peak", "race_speed", "element_load", "element_pressure", "load_zone_extent", "bearing_stiffness"),
    *("static_safety", "cage_frequency", "outer_race_frequency", "inner_race_frequency", "element_frequency"),
)


def helical_pair(**second: Any) -> dict[str, Any]:
    """Two helical gears on fixed axes, each between two roller bearings, one of them beside its gear."""
    front = {**PARTS, "internal_clearance": 0, "at": "-40 mm"}
    seats = {"front": front, "rear": {**front, "at": "60 mm"}}
    gear = {"mass": "5 kg", "inertia": "5 kg", "support": seats}
    return {
        "format": 2,
        "title": "a pair on four bearings",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                "planets": 1,
                "module": "4 mm",
                "face_width": "30 mm",
                "helix_angle": "12 deg",
                "pinion": {**gear, "teeth": 24, "hand": "right"},
                "wheel": {**gear, "teeth": 60},
                "meshes": {"pinion-wheel": {"stiffness": "4e8 N/m"}},
            }
        },
        "operation": {"speed": {"pinion": "900 rpm"}, "torque": {"pinion": "300 N m"}},
    }


def test_check_has_the_bearings_under_the_nominal_torques_by_hand() -> None:
    """F = T/(3 a); load zone, stiffness, safety and frequencies are those of the bearing alone."""
    result = epicyclic.check(train())
    np.testing.assert_allclose(result.bearing_force_peak, FORCE, rtol=1e-9)
    q = displacement(BEARING, [FORCE])
    zone = load_zone(BEARING, q)
    np.testing.assert_allclose(result.element_load.max("element"), zone.load.max(), rtol=1e-6)
    np.testing.assert_allclose(result.element_pressure, zone.pressure, rtol=1e-6)
    np.testing.assert_allclose(result.load_zone_extent, zone.extent, rtol=1e-6)
    np.testing.assert_allclose(result.static_safety, static_safety(BEARING, zone), rtol=1e-6)
    np.testing.assert_allclose(result.bearing_stiffness, contact_set(BEARING).tangent(q)[0, 0], rtol=1e-6)
    carrier = RPM / 60
    planet = carrier * (1 - TEETH[2] / TEETH[1])  # absolute, turning back
    found = [float(result[name][0]) for name in STATES[-4:]]
    assert found == pytest.approx(list(map(abs, passing_frequencies(BEARING, carrier, planet))), rel=1e-12)
    shown = {table.title: table for table in check_tables(result)}
    assert shown["Loads of bearings"].columns["clearance in operation [µm]"] == pytest.approx([30.0] * 3)
    assert shown["Loads of bearings"].columns["load zone [deg]"][0] == pytest.approx(
        2 * np.degrees(np.arccos(1 - 2 * zone.extent))
    )
    assert "Loads of bearings" in {table.title for table in brief_tables(result)}


def test_three_verbs_show_one_bearing() -> None:
    """Without errors and weight `check`, `static` and `life` have the same states, and two have the same table."""
    model = train()
    check, static = epicyclic.check(model), epicyclic.static(model, cycles=1)
    life = epicyclic.life(model, instants=8).isel(case=0)
    for name in STATES:
        np.testing.assert_allclose(static[name].values, life[name].values, rtol=1e-6, err_msg=name)
        np.testing.assert_allclose(check[name].values, life[name].values, rtol=1e-3, err_msg=name)
    titles = [[table.title for table in tables] for tables in (check_tables(check), static_tables(static))]
    assert all({"Loads of bearings", "Frequencies of bearings"} <= set(own) for own in titles)
    assert "main/planet/1/bearing" in static_tables(static)[-3].columns["link"]  # forces of links with a law, too
    drawn = epicyclic.plot("load-zones", static).data
    assert max(drawn[0].y) == pytest.approx(float(static.element_load.max()) / 1e3, rel=1e-4)


def test_nominal_forces_of_shafts_are_those_of_levers() -> None:
    """Front and rear of each shaft take the mesh force and its thrust moment by their distances, as statics finds."""
    model = helical_pair()
    check, static = epicyclic.check(model), epicyclic.static(model, cycles=1)
    names = [f"main/{gear}/support/{end}" for gear in ("pinion", "wheel") for end in ("front", "rear")]
    assert check.bearing.values.tolist() == static.bearing.values.tolist() == names
    forces = check.bearing_force_peak.values
    np.testing.assert_allclose(forces, static.bearing_force_peak, rtol=0.03)  # slices of the teeth hold some tilt
    radius = MODULE * 24 / 2 / np.cos(radians(12))
    tangential = 300 / radius
    alpha = np.arctan(tan(radians(20)) / np.cos(radians(12)))
    separating, thrust = tangential * tan(alpha), tangential * tan(radians(12))
    for sense in (1, -1):
        rear = np.hypot(tangential * 0.4, separating * 0.4 + sense * thrust * radius / 0.1)
        if rear == pytest.approx(forces[1], rel=1e-6):
            break
    else:
        raise AssertionError(forces)
    front = np.hypot(tangential * 0.6, separating * 0.6 - sense * thrust * radius / 0.1)
    assert forces[0] == pytest.approx(front, rel=1e-6)


def test_bearings_that_hold_a_moment_by_distance_and_rows_share_it_by_least_squares() -> None:
    """Two bearings of two rows, d apart: 2 F^2 + 2 (m/r)^2 is least for F d + 2 m = M, r the pitch radius."""
    model, distance, r = train(), 60e-3, 35e-3
    model["stages"]["main"]["helix_angle"] = "12 deg"
    two = {**PARTS, "rows": 2, "row_distance": "20 mm"}
    model["stages"]["main"]["planet"]["bearing"] = {"a": {**two, "at": "-30 mm"}, "b": {**two, "at": "30 mm"}}
    rows = nominal_forces(load(model))
    moment = FORCE * tan(radians(12)) * MODULE * TEETH[1] / 2
    couple = moment * distance / 4 / (distance**2 / 4 + r**2)
    a, b = (rows[f"main/planet/1/bearing/{name}/x"].item() for name in "ab")  # the thrust moment is along the radius
    assert abs(a - b) / 2 == pytest.approx(couple, rel=1e-6)
    held = [rows[f"main/planet/1/bearing/{name}/ry"].item() for name in "ab"]
    assert sum(map(abs, held)) == pytest.approx(moment - couple * distance, rel=1e-6)


def test_three_bearings_share_as_equal_springs_on_a_rigid_shaft_also_where_it_bends() -> None:
    """F_i = W (1/3 + (a - m)(z_i - m) / sum (z_j - m)^2) of a spur mesh at a = 0, m the mean of the places z_i."""
    model = helical_pair()
    stage = model["stages"]["main"]
    del stage["helix_angle"], stage["pinion"]["hand"]
    places = np.array([-0.25, 0.23, 0.42])
    seat = stage["pinion"]["support"]["front"]
    ends = zip(("front", "middle", "rear"), places.tolist(), strict=True)
    stage["pinion"]["support"] = {name: {**seat, "at": place} for name, place in ends}
    total = 300 / (MODULE * 24 / 2) / np.cos(radians(20))
    mean = places.mean()
    share = 1 / 3 - mean * (places - mean) / ((places - mean) ** 2).sum()
    for sections in (
        {},
        {"shaft_sections": [{"from": -0.3, "to": 0.1, "diameter": 0.03}, {"to": 0.5, "diameter": 0.05}]},
    ):
        stage["pinion"] |= sections
        rows = nominal_forces(load(model))
        found = [[rows[f"main/pinion/support/{name}/{d}"].item() for d in "xy"] for name in ("front", "middle", "rear")]
        np.testing.assert_allclose(np.hypot(*np.transpose(found)), total * share, rtol=1e-6)


def test_what_the_file_does_not_state_is_named() -> None:
    """Without torque no loads, without speed no frequencies; neither fails."""
    for missing, empty, there in (
        ("torque", "element_load", "cage_frequency"),
        ("speed", "race_speed", "element_load"),
    ):
        model = train()
        del model["operation"][missing]
        result = epicyclic.check(model)
        assert result[empty].isnull().all()
        assert result[there].notnull().any()
        table = next(one for one in check_tables(result) if one.title == "Loads of bearings")
        assert f"needs operation.{missing}" in table.lead
    model = train()
    del model["operation"]["speed"]
    still = epicyclic.static(model, cycles=1)
    np.testing.assert_allclose(still.bearing_force_peak, FORCE, rtol=1e-6)
    assert np.isnan(still.race_speed).all()


def test_a_bearing_that_cannot_carry_the_nominal_thrust_is_named_and_check_goes_on() -> None:
    model = train()
    model["stages"]["main"]["helix_angle"] = "12 deg"
    model["stages"]["main"]["sun"]["support"] = {
        **PARTS,
        "type": "tapered roller",
        "contact_angle": "14 deg",
        "internal_clearance": 0,
    }
    senses = []
    for sense in ("14 deg", "-14 deg"):
        model["stages"]["main"]["sun"]["support"]["contact_angle"] = sense
        result = epicyclic.check(model)
        said = [
            text
            for text in json.loads(result.attrs["warnings"])
            if "main/sun/support: the bearing does not carry" in text
        ]
        of_sun = result.sel(bearing="main/sun/support")
        assert (
            bool(np.isnan(of_sun.element_pressure)) is bool(said) is (sense == "14 deg")
        )  # as of the equilibrium below
        if not said:
            thrust = TORQUE * TEETH[0] / (TEETH[0] + TEETH[2]) / (MODULE * TEETH[0] / 2 / np.cos(radians(12)))
            load = of_sun.element_load.sum().item()
            assert load * np.sin(radians(14)) == pytest.approx(thrust * tan(radians(12)), rel=1e-3)
        senses.append(bool(said))
    assert sorted(senses) == [False, True]


def test_of_a_planet_on_a_pin_in_the_housing_the_force_is_that_on_its_inner_race() -> None:
    """A star whose planets have two tapered rows in X: of each row sum Q sin alpha is the thrust that statics finds."""
    one = {**PARTS, "type": "tapered roller", "internal_clearance": 0}
    model = train()
    del model["stages"]["main"]["carrier"]
    model["stages"]["main"]["helix_angle"] = "12 deg"
    model["stages"]["main"]["planet"]["bearing"] = {
        "front": {**one, "contact_angle": "-14 deg", "at": "-30 mm"},
        "rear": {**one, "contact_angle": "14 deg", "at": "30 mm"},
    }
    model["operation"] = {"speed": {"sun": f"{RPM} rpm"}, "torque": {"sun": "300 N m"}}
    static = epicyclic.static(model, cycles=1)
    for name in static.bearing.values:
        thrust = np.abs(static.group_row_force.sel(group_row=f"{name}/z")).max().item()
        loads = static.element_load.sel(bearing=name).sum().item()
        assert loads * np.sin(radians(14)) == pytest.approx(thrust, rel=0.02)
    np.testing.assert_allclose(static.race_speed, 2 * pi * RPM / 60 * TEETH[0] / TEETH[1], rtol=1e-9)


@pytest.mark.parametrize(("verb", "options"), [("static", {"cycles": 1}), ("life", {"instants": 8}), ("modes", {})])
def test_one_row_that_carries_thrust_in_one_sense_alone_is_named(verb: str, options: dict[str, Any]) -> None:
    """No equilibrium of the sense that `check` refuses; two bearings of opposite angles have one."""
    model = train()
    model["stages"]["main"]["helix_angle"] = "12 deg"
    single = {**PARTS, "type": "tapered roller", "contact_angle": "14 deg", "internal_clearance": 0}
    model["stages"]["main"]["sun"]["support"] = single
    with pytest.raises(ConvergenceError, match=r"in one sense alone is carried by main/sun/support: a second row"):
        getattr(epicyclic, verb)(model, **options)
    model["stages"]["main"]["sun"]["support"] = {
        "front": {**single, "at": "-30 mm"},
        "rear": {**single, "contact_angle": "-14 deg", "at": "30 mm"},
    }
    getattr(epicyclic, verb)(model, **options)


def test_a_bearing_beyond_the_root_circle_of_its_gear_is_refused() -> None:
    """A planet of 30 teeth of 4 mm has its roots at 110 mm; beside the face the bearing may be larger."""
    large = {"pitch_diameter": "100 mm", "elements": 20}
    with pytest.raises(ModelError, match=r"planet\.bearing\.pitch_diameter.*112 mm, beyond the root circle.*110 mm"):
        load(train(**large))
    load(train(**large, at="16 mm"))
    load(train(**{**large, "pitch_diameter": "97 mm"}))


def test_rows_beside_their_gear_are_told_and_two_bearings_at_one_place_refused() -> None:
    """The face is 30 mm wide, that of two helices 10 mm apart 70 mm: two rows may be as far apart."""

    def told(distance: str, **more: Any) -> list[str]:
        model = train(rows=2, row_distance=distance)
        model["stages"]["main"] |= more
        return [text for text in load(model).warnings if "[rows-beside-gear]" in text]

    (text,) = told("31 mm")
    assert "planet.bearing: rows 31 mm apart in a gear 30 mm wide" in text
    helices = {"herringbone": True, "helix_angle": "20 deg", "gap": "10 mm"}
    assert not told("29 mm")
    assert not told("69 mm", **helices)
    assert told("71 mm", **helices)
    named = train()
    parts = named["stages"]["main"]["planet"].pop("bearing")
    rear = {**parts, "at": "1 mm"}
    named["stages"]["main"]["planet"]["bearing"] = {"front": parts, "rear": rear}
    load(named)
    rear["at"] = 0
    with pytest.raises(ModelError, match=r"bearing\.rear\.at: two rolling bearings at one place, front and"):
        load(named)
