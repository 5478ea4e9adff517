"""The small unit as a model: what stands where, in which sense, and what is told.  Numbers are worked by hand here."""

from __future__ import annotations

import itertools
import json
import math
from typing import Any

import numpy as np
import pytest
from tests.unit.rexs.imports import imported, lines, stage_of, value_of

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.rexs.import_train import read_rexs

A = 2 * 54 / math.cos(math.radians(15))  # centre distance 4 (24 + 30) / 2 / cos 15 deg [mm]
RHO = 7800.0


def test_xml_and_json_give_the_same_document(draft: Any) -> None:
    other = read_rexs(draft.json().encode())
    assert imported(draft).document == other.document
    assert imported(draft).dropped == other.dropped


def test_geometry(draft: Any) -> None:
    stage = stage_of(imported(draft))
    assert stage["planet_angles"] == "[0, 240, 120] deg"
    assert stage["centre_distance"] == f"{A!r} mm"
    assert (stage["module"], stage["helix_angle"], stage["pressure_angle"]) == ("4 mm", "15 deg", "20 deg")
    assert [stage[name]["teeth"] for name in ("sun", "planet", "ring")] == [24, 30, 84]  # of a ring without its sign
    assert stage["sun"]["hand"] == "right"
    assert stage["planet"]["profile_shift"] == 0.1
    assert stage["ring"]["outer_diameter"] == "420 mm"
    assert stage["planet"]["bore"] == "60 mm"


def test_the_model_says_what_the_file_says(draft: Any) -> None:
    train = epicyclic.load(dict(imported(draft).document))
    values = {value.path: value.value for value in train.values}
    assert values["stages.main.sun.profile_shift"] == pytest.approx(-0.1, abs=1e-9)  # x_s + x_p = 0 at reference
    assert values["stages.main.ring.profile_shift"] == pytest.approx(-0.1, abs=1e-9)  # x_p + x_r = 0 too
    assert train.kinematics.speed is not None
    assert float(train.kinematics.speed["main.carrier"]) == pytest.approx(1500 * 24 / (24 + 84), rel=1e-12)  # [rev/min]


def test_left_hand_is_negative(draft: Any) -> None:
    for number in (11, 21, 101, 201, 301):
        value, unit = draft.values(number)["helix_angle_reference_diameter"]
        draft.values(number)["helix_angle_reference_diameter"] = (-value, unit)
    assert stage_of(imported(draft))["sun"]["hand"] == "left"


def test_signs_of_helix_that_do_not_fit_are_told(draft: Any) -> None:
    draft.values(101)["helix_angle_reference_diameter"] = (15.0, "deg")
    draft.values(21)["helix_angle_reference_diameter"] = (15.0, "deg")
    found = imported(draft)
    assert stage_of(found)["sun"]["hand"] == "right"
    assert "does not fit that of sun" in lines(found.assumed, 101)
    assert "ring has the hand of its planets" in lines(found.assumed, 21)


def test_angles_agree_with_the_stated_ones_about_minus_u(draft: Any) -> None:
    assert "agrees with the places" in lines(imported(draft).read, 105)
    for i, angle in enumerate((0, 240, 120)):  # counted about +u instead
        draft.values(100 * (i + 1) + 5)["rotating_angle_around_neg_u_axis"] = (float(angle), "deg")
    found = imported(draft)
    assert stage_of(found)["planet_angles"] == "[0, 240, 120] deg"
    assert "counts the other way round" in lines(found.assumed, 105)
    draft.values(205)["rotating_angle_around_neg_u_axis"] = (17.0, "deg")
    assert "differs from the places" in lines(imported(draft).assumed, 105)


def test_angles_without_places_are_the_stated_ones_turned(draft: Any) -> None:
    for component in list(draft.components):
        draft.values(component).pop("support_vector", None)
    stage = stage_of(imported(draft))
    assert stage["planet_angles"] == "[0, 240, 120] deg"  # -0, -(-240), -(-120) about +u
    for number in (105, 205, 305):
        del draft.values(number)["rotating_angle_around_neg_u_axis"]
    found = imported(draft)
    assert stage_of(found)["planets"] == 3
    assert found.document["assumed"]["stages.main.planets"].startswith("no places")  # type: ignore[index]


def test_unequal_angles(draft: Any) -> None:
    angle = math.radians(121.5)
    for number in (300, 301, 303, 304):
        vector = draft.values(number)["support_vector"][0]
        vector[1:] = [-A * math.sin(angle), A * math.cos(angle)]
    assert stage_of(imported(draft))["planet_angles"] == "[0, 240, 121.5] deg"


def test_nested_frames_of_position(draft: Any) -> None:
    """Places in the frame of a component that is itself displaced and turned give the same model."""
    plain = imported(draft).document
    draft.components[5] = ("assembly_group", "Frame", {
        "support_vector": ([7.0, -3.0, 2.0], "mm"),
        "u_axis_vector": ([0.0, 0.0, 2.0], "mm"),
        "w_axis_vector": ([0.0, 5.0, 0.0], "mm"),
    })  # fmt: skip
    for number in draft.components:
        if "reference_component_for_position" in draft.values(number) and number != 1:
            draft.values(number)["reference_component_for_position"] = (5, "none")
    assert imported(draft).document == plain


def test_a_place_in_a_displaced_frame(draft: Any) -> None:
    draft.add(5, "assembly_group", "Frame", support_vector=([-200.0, 0.0, 0.0], "mm"))
    draft.values(33)["support_vector"] = ([150.0, 0.0, 0.0], "mm")  # at u = -50 mm, as before
    draft.values(33)["reference_component_for_position"] = (5, "none")
    assert stage_of(imported(draft))["carrier"]["support"]["bearing33"]["at"] == "-150 mm"


def test_references_in_a_circle_are_refused(draft: Any) -> None:
    draft.values(10)["reference_component_for_position"] = (11, "none")
    draft.values(11)["reference_component_for_position"] = (10, "none")
    with pytest.raises(ModelError, match="in a circle"):
        imported(draft)


def test_sense_of_speed_and_torque(draft: Any) -> None:
    """The sun shaft has its u axis against z: its speed and torque about u are negative about z."""
    draft.values(10)["u_axis_vector"] = ([-1.0, 0.0, 0.0], "mm")
    operation: Any = imported(draft).document["operation"]
    assert operation["speed"] == {"sun": "-1500 rpm"}
    assert operation["torque"] == {"sun": "-800 N m"}
    turned = imported(draft)
    # sections lie along u: 25 .. 175 mm from u = 0 are now at -25 .. -175 mm, the gear at 100 mm
    shaft = RHO * math.pi / 4 * 0.04**2 * 0.15
    gear = RHO * math.pi / 4 * ((24 * 0.004 / math.cos(math.radians(15))) ** 2 - 0.04**2) * 0.05
    assert value_of(stage_of(turned)["sun"]["mass"]) == pytest.approx(
        shaft + RHO * math.pi / 4 * (24 * 0.004 / math.cos(math.radians(15))) ** 2 * 0.05, rel=1e-8
    )
    assert gear > 0


def test_masses_by_hand(draft: Any) -> None:
    stage = stage_of(imported(draft))
    cos = math.cos(math.radians(15))
    area = math.pi / 4
    sun = RHO * area * (0.04**2 * 0.15 + ((0.096 / cos) ** 2 - 0.04**2) * 0.05)
    assert value_of(stage["sun"]["mass"]) == pytest.approx(sun, rel=1e-8)
    planet = RHO * area * ((0.12 / cos) ** 2 - 0.06**2) * 0.05  # gear and the sleeve of its shaft are one solid
    assert value_of(stage["planet"]["mass"]) == pytest.approx(planet, rel=1e-8)
    assert value_of(stage["planet"]["inertia"]) == pytest.approx(planet * ((0.12 / cos) ** 2 + 0.06**2) / 8, rel=1e-8)
    ring = RHO * area * ((0.42**2 - 0.37**2) + (0.37**2 - (0.336 / cos) ** 2)) * 0.05
    assert value_of(stage["ring"]["mass"]) == pytest.approx(ring, rel=1e-8)
    plate = RHO * area * (0.3**2 - 0.06**2) * 0.02
    assert value_of(stage["carrier"]["mass"]) == pytest.approx(plate, rel=1e-8)
    # the plate lies from 50 to 70 mm, the planets at 100 mm: its middle 40 mm from the centre of the carrier
    tilt = plate * ((0.3**2 + 0.06**2) / 16 + 0.02**2 / 12 + 0.04**2)
    assert value_of(stage["carrier"]["tilt_inertia"]) == pytest.approx(tilt, rel=1e-8)


def test_a_tapered_shaft_against_z(draft: Any) -> None:
    """A cone of the sun shaft, thick at its begin: along -z that end is at the gear."""
    draft.values(10)["u_axis_vector"] = ([-1.0, 0.0, 0.0], "mm")
    draft.values(10)["support_vector"] = ([200.0, 0.0, 0.0], "mm")
    draft.components[12] = ("shaft_section", "", {
        "length": (60.0, "mm"),
        "outer_diameter_begin": (60.0, "mm"),
        "outer_diameter_end": (0.0, "mm"),
        "u_coordinate_on_shaft": (100.0, "mm"),
    })  # fmt: skip
    sun = stage_of(imported(draft))["sun"]
    cone = RHO * math.pi * 0.06**2 / 12 * 0.06
    reference = 0.096 / math.cos(math.radians(15))
    gear = RHO * math.pi / 4 * (reference**2 - 0.06**2) * 0.05
    assert value_of(sun["mass"]) == pytest.approx(cone + gear, rel=1e-8)
    # about its base, which is at the middle of the gear: a cone has m (3 r^2 / 20 + h^2 / 10)
    tilt = cone * (3 * 0.03**2 / 20 + 0.06**2 / 10)
    tilt += gear * (3 * (reference**2 + 0.06**2) / 4 + 0.05**2) / 12
    assert value_of(sun["tilt_inertia"]) == pytest.approx(tilt, rel=1e-7)


def test_pins_and_density_that_is_not_given(draft: Any) -> None:
    for i in (1, 2, 3):
        draft.add(100 * i + 9, "shaft_section", "", length=(80.0, "mm"), outer_diameter_begin=(50.0, "mm"))
        draft.relate("assembly", assembly=100 * i + 3, part=100 * i + 9)
    found = imported(draft)
    pin = 7850 * math.pi / 4 * 0.05**2 * 0.08  # pins refer to no material
    plate = RHO * math.pi / 4 * (0.3**2 - 0.06**2) * 0.02
    carrier = stage_of(found)["carrier"]
    assert value_of(carrier["mass"]) == pytest.approx(plate + 3 * pin, rel=1e-8)
    inertia = plate * (0.3**2 + 0.06**2) / 8 + 3 * pin * (0.05**2 / 8 + (A / 1000) ** 2)
    assert value_of(carrier["inertia"]) == pytest.approx(inertia, rel=1e-8)
    assert "no density given: steel, 7850 kg/m^3" in lines(found.assumed, 103)


def test_a_gear_on_two_sections_has_the_narrower_bore(draft: Any) -> None:
    for i in (100, 200, 300):  # they meet at the middle of the gear
        draft.values(i + 2).update(length=(25.0, "mm"), u_coordinate_on_shaft=(0.0, "mm"))
        other = {**draft.values(i + 2), "u_coordinate_on_shaft": (25.0, "mm")}
        other |= {f"inner_diameter_{end}": (40.0, "mm") for end in ("begin", "end")}
        draft.add(i + 9, "shaft_section", "", **other)
        draft.relate("assembly", assembly=i, part=i + 9)
    assert stage_of(imported(draft))["planet"]["bore"] == "40 mm"


def test_a_carrier_without_plates_is_assumed(draft: Any) -> None:
    draft.relations = [r for r in draft.relations if r[1] != {"assembly": 4, "part": 31}]
    found = imported(draft)
    discs = 7850 * math.pi / 4 * ((2 * A + 60 / math.cos(math.radians(15))) / 1000) ** 2 * 0.025
    assert value_of(stage_of(found)["carrier"]["mass"]) == pytest.approx(discs, rel=1e-6)
    assert "two steel discs" in found.document["assumed"]["stages.main.carrier.mass"]  # type: ignore[index]


def test_additional_masses(draft: Any) -> None:
    before = stage_of(imported(draft))["sun"]
    draft.add(
        15,
        "additional_mass",
        "Hub",
        mass=(3.0, "kg"),
        moment_of_inertia_u_axis=(0.02, "kg m^2"),
        moment_of_inertia_v_axis=(0.01, "kg m^2"),
        moment_of_inertia_w_axis=(0.01, "kg m^2"),
    )
    draft.relate("assembly", assembly=10, part=15)
    after = stage_of(imported(draft))["sun"]
    added = [value_of(after[key]) - value_of(before[key]) for key in ("mass", "inertia", "tilt_inertia")]
    assert added == pytest.approx([3.0, 0.02, 0.01], abs=1e-7)


def test_bearings_and_couplings(draft: Any) -> None:
    found = imported(draft)
    stage = stage_of(found)
    assert stage["carrier"]["support"] == {
        "bearing33": {"at": "-150 mm", "radial": "6e8 N/m", "z": "3e8 N/m", "tilt": 0},
        "bearing34": {"at": "-60 mm", "radial": "6e8 N/m", "z": 0, "tilt": 0},  # takes up no axial force
    }
    assert stage["planet"]["bearing"] == {
        "radial": ["4e8 N/m", "4.1e8 N/m", "4.2e8 N/m"],
        "z": math.inf,
        "tilt": "1e6 N m/rad",
    }
    ring = {"at": "10 mm", "radial": "1e9 N/m", "z": "2e9 N/m", "tilt": "5e6 N m/rad", "rz": "3e7 N m/rad"}
    assert stage["ring"]["support"] == ring
    assert found.document["operation"]["held"] == ["ring"]  # type: ignore[index]
    assert stage["sun"]["support"] == {"radial": 0}
    assert "floats" in found.document["assumed"]["stages.main.sun.support.radial"]  # type: ignore[index]


def test_the_ring_is_held_rigidly_or_not_at_all(draft: Any) -> None:
    for name in ("radial_stiffness", "axial_stiffness", "bending_stiffness", "rotational_stiffness"):
        draft.values(23)[name] = (1e20, draft.values(23)[name][1])
    stage = stage_of(imported(draft))
    assert "support" not in stage["ring"]
    draft.components[23] = ("switchable_coupling", "", {**draft.values(23), "is_engaged": ([False, True], "none")})
    draft.values(1)["gear_shift_index"] = (2, "none")
    assert imported(draft).document["operation"]["held"] == ["ring"]  # type: ignore[index]
    draft.values(1)["gear_shift_index"] = (1, "none")
    found = imported(draft)
    assert "held" not in found.document["operation"]  # type: ignore[operator]
    assert "not engaged" in lines(found.dropped, 23)


def test_rigid_from_1e16_on(draft: Any) -> None:
    draft.values(33)["radial_stiffness"] = (1e16, "N / m")
    draft.values(34)["radial_stiffness"] = (9.9e15, "N / m")
    support = stage_of(imported(draft))["carrier"]["support"]
    assert (support["bearing33"]["radial"], support["bearing34"]["radial"]) == (math.inf, "9.9e15 N/m")


def test_stiffness_at_the_operating_point_and_what_is_missing(draft: Any) -> None:
    values = draft.values(33)
    del values["radial_stiffness"], values["axial_stiffness"], values["bending_stiffness"]
    values["operating_point_stiffness_f_v_d_v"] = (2e8, "N / m")
    values["operating_point_stiffness_f_w_d_w"] = (4e8, "N / m")
    found = imported(draft)
    bearing = stage_of(found)["carrier"]["support"]["bearing33"]
    assert bearing == {"at": "-150 mm", "radial": "3e8 N/m", "z": math.inf, "tilt": 0}
    told = lines(found.assumed, 33)
    assert all(words in told for words in ("mean of both", "axial_stiffness:  not given: rigid", "free to tilt"))


def test_mesh_stiffness_and_backlash(draft: Any) -> None:
    for number_ in (105, 205, 305):
        draft.values(number_)["mean_mesh_stiffness_for_transverse_load_iso_6336_2019"] = (20.0, "N / (mm mum)")
        draft.values(number_)["minimum_normal_backlash"] = (0.1, "mm")
        draft.values(number_)["maximum_normal_backlash"] = (0.14, "mm")
    found = imported(draft)
    mesh = stage_of(found)["meshes"]["sun-planet"]
    assert (mesh["stiffness"], mesh["direction"], mesh["backlash"]) == ("20 N/(mm um)", "transverse", "0.12 mm")
    train = epicyclic.load(dict(found.document))
    stiff = [mesh.stiffness for mesh in train.meshes if mesh.name == "main/sun-planet/1"]
    base = math.asin(math.sin(math.radians(15)) * math.cos(math.radians(20)))
    # 20 N/(mm um) times 50 mm across the teeth, along the normal by cos^2 of the base helix angle
    assert np.ravel(np.asarray(stiff[0], dtype=float))[0] == pytest.approx(1e9 / math.cos(base) ** 2, rel=1e-9)
    draft.values(105)["common_face_width"] = (40.0, "mm")
    assert stage_of(imported(draft))["meshes"]["sun-planet"]["stiffness"] == "8e8 N/m"
    draft.values(205)["mean_mesh_stiffness_for_transverse_load_iso_6336_2019"] = (19.0, "N / (mm mum)")
    assert "differs from that of component 105" in lines(imported(draft).dropped, 205)


@pytest.mark.parametrize("change", [-0.5, 0.5])
def test_a_centre_distance_that_differs_is_told(draft: Any, change: float) -> None:
    value, unit = draft.values(105)["center_distance"]
    assert "center_distance" not in lines(imported(draft).dropped, 205)
    draft.values(205)["center_distance"] = (value + change, unit)
    told = lines(imported(draft).dropped, 205)
    assert "center_distance" in told
    assert "differs from" in told


def test_flank_modifications(draft: Any) -> None:
    draft.values(101)["tip_diameter"] = (132.0, "mm")
    draft.add(
        400,
        "tip_relief",
        "",
        tip_relief_depth=(20.0, "mum"),
        tip_relief_datum_diameter=(128.0, "mm"),
        shape_of_relief=("linear", "none"),
    )
    draft.add(
        401,
        "helix_crowning",
        "",
        helix_crowning_amount_datum_face=(5.0, "mum"),
        helix_crowning_amount_non_datum_face=(5.0, "mum"),
    )
    draft.add(402, "profile_crowning", "", profile_crowning_at_tip=(3.0, "mum"))
    for flank, part in itertools.product((107, 108), (400, 401, 402)):
        draft.relate("reference", origin=flank, referenced=part)
    found = imported(draft)
    flank = stage_of(found)["planet"]["flank"]
    assert flank == {"tip_relief": {"amount": "20 um", "length": "2 mm", "shape": "linear"}, "crown": "5 um"}
    assert "no profile crowning" in lines(found.dropped, 402)
    draft.relations = [r for r in draft.relations if r[1] != {"origin": 108, "referenced": 400}]
    assert "left and right flank differ" in lines(imported(draft).assumed, 107)


def test_tools_give_dedendum_and_rounding(draft: Any) -> None:
    draft.add(
        500,
        "rack_shaped_tool",
        "",
        addendum_coefficient_reference_profile=(1.4, "none"),
        tip_radius_factor=(0.39, "none"),
    )
    draft.relate("manufacturing_step", workpiece=107, tool=500)
    planet = stage_of(imported(draft))["planet"]
    assert (planet["dedendum"], planet["tip_rounding"]) == (1.4, 0.39)


def test_profile_shifts_that_nothing_says(draft: Any) -> None:
    for number_ in (107, 108, 207, 208, 307, 308):
        del draft.values(number_)["addendum_modification_coefficient"]
    found = imported(draft)
    assert stage_of(found)["planet"]["profile_shift"] == 0.0
    assert "profile_shift" not in stage_of(found)["sun"]
    assert "not in the file: 0" in found.document["assumed"]["stages.main.planet.profile_shift"]  # type: ignore[index]


def test_load_cases(draft: Any) -> None:
    del (
        draft.values(10)["rotational_speed"],
        draft.values(30)["rotational_speed"],
        draft.values(13)["torque_around_u_axis"],
    )
    draft.load_cases = {
        4: {10: {"rotational_speed": (1200.0, "1 / min")}, 13: {"torque_around_u_axis": (500.0, "N m")}},
        8: {10: {"rotational_speed": (600.0, "1 / min")}, 13: {"power": (30.0, "kW")}},
    }
    first = imported(draft)
    assert first.document["operation"]["torque"] == {"sun": "500 N m"}  # type: ignore[index]
    assert "load case 4, the first" in lines(first.assumed, None)
    assert "of load cases, times, speeds and torques are carried" in lines(first.dropped, None)
    assert first.document["cases"] == {"case8": {"speed": {"sun": "600 rpm"}, "power": {"sun": "30 kW"}}}
    eight: Any = imported(draft, load_case=8).document["operation"]
    assert (eight["speed"], eight["power"]) == ({"sun": "600 rpm"}, {"sun": "30 kW"})
    with pytest.raises(ModelError, match="no such load case"):
        imported(draft, load_case=5)


def test_loads_that_balance_are_stated_once(draft: Any) -> None:
    draft.values(32)["torque_around_u_axis"] = (-3600.0, "N m")
    assert imported(draft).document["operation"]["torque"] == {"sun": "800 N m"}  # type: ignore[index]
    draft.values(32)["defines_torque"] = (True, "none")
    found = imported(draft)
    assert found.document["operation"]["torque"] == {"sun": "800 N m"}  # type: ignore[index]
    assert "takes the balance" in lines(found.assumed, 32)


def test_power_that_is_not_torque_times_speed_is_told(draft: Any) -> None:
    draft.values(13)["power"] = (800 * 1500 * math.pi / 30 / 1000, "kW")
    assert "torque times speed" in lines(imported(draft).read, 13)
    draft.values(13)["power"] = (100.0, "kW")
    assert "is not torque times speed" in lines(imported(draft).assumed, 13)


def test_gravity_is_left_out_and_the_line_told(draft: Any) -> None:
    draft.values(1).update(
        account_for_gravity=(True, "none"),
        direction_vector_gravity_u=(0.0, "none"),
        direction_vector_gravity_v=(2.0, "none"),
        direction_vector_gravity_w=(0.0, "none"),
    )
    # x through planet 1 is w, z is u, so y = z x x is -v: gravity along v is along -y
    assert 'operation.gravity = "[0, -9.81, 0] m/s^2" adds it' in lines(imported(draft).dropped, 1)


def test_every_attribute_is_read_or_dropped(draft: Any) -> None:
    draft.add(600, "lubricant", "Oil", basis=("mineral oil", "none"))
    draft.values(11)["custom_mark"] = (1, "none")
    found = imported(draft)
    assert "no lubricant in the model" in lines(found.dropped, 600)
    assert "component 11: custom_mark" in lines(found.dropped, None)
    spare = {(e.component, name) for e in found.dropped for name in e.attribute.split(", ")}
    assert (13, "torque_around_u_axis") not in spare
    assert (32, "transmits_torque") in spare


def test_reasons_stand_under_assumed(draft: Any) -> None:
    found = imported(draft)
    paths = {entry.path for entry in found.assumed if entry.path}
    assert set(found.document["assumed"]) == paths  # type: ignore[call-overload]


@pytest.mark.parametrize(
    ("change", "says", "where"),
    [
        (lambda d: d.values(11).pop("number_of_teeth"), "missing", "component 11 (cylindrical_gear), number_of_teeth"),
        (lambda d: d.values(11).update(number_of_teeth=(17.5, "none")), "not a number of teeth", "component 11"),
        (lambda d: d.values(11).update(number_of_teeth=(-24, "none")), "negative, of external teeth", "component 11"),
        (lambda d: d.values(21).pop("normal_module"), "missing", "component 21 (ring_gear), normal_module"),
        (lambda d: d.values(11).update(face_width=(50, "cubit")), "unit not known", "_gear), face_width"),
        (lambda d: d.values(11).update(helix_angle_reference_diameter=(80.0, "deg")), "out of range", "component 11"),
        (lambda d: d.values(11).update(support_vector=([1.0, 2.0], "mm")), "not a vector", ", support_vector"),
        (lambda d: d.values(30).update(u_axis_vector=([0.0, 1.0, 0.0], "mm")), "not parallel", "30 (shaft), u_"),
        (lambda d: d.values(10).update(u_axis_vector=([0.0, 0.0, 0.0], "mm")), "length 0", "component 10"),
        (lambda d: d.values(101).update(support_vector=([100.0, 0.0, 0.0], "mm")), "on the axis", "component 100"),
        (lambda d: d.values(201).update(number_of_teeth=(31, "none")), "differ in their teeth", "component 3"),
        (lambda d: d.components.update({3: ("cylindrical_stage", "", {})}), "no planetary stage", "components"),
        (lambda d: d.relations.clear(), "no planets", "component 3 (planetary_stage)"),
        (lambda d: d.relate("stage", stage=105, gear_1=101, gear_2=201), "mesh with each other", "component 3"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_by_name(draft: Any, change: Any, says: str, where: str) -> None:
    change(draft)
    with pytest.raises(ModelError, match=says) as caught:
        imported(draft)
    assert where in caught.value.path


def test_errors_of_the_model_name_the_component(draft: Any, tmp_path: Any) -> None:
    draft.values(13)["torque_around_u_axis"] = (1e25, "N m")
    file = tmp_path / "unit.rexs"
    file.write_text(draft.xml(), encoding="utf-8")
    with pytest.raises(ModelError, match=r"operation\.torque.* \(component 13, torque_around_u_axis\)"):
        epicyclic.load(file)


def test_texts_that_a_writer_lost(draft: Any) -> None:
    draft.values(34)["axial_force_absorption"] = (False, "none")
    found = read_rexs(draft.json().encode())
    assert "stands as false where a text belongs" in lines(found.assumed, 34)
    assert stage_of(found)["carrier"]["support"]["bearing34"]["z"] == math.inf  # as its stiffness says


def test_arrays_that_a_writer_lost(draft: Any) -> None:
    draft.values(11)["support_vector"] = (False, "mm")
    draft.values(101)["support_vector"] = (False, "mm")
    with pytest.raises(ModelError, match=r"damaged.*support_vector \(2 times, first in component 11\)"):
        read_rexs(draft.json().encode())


def test_every_verb_takes_the_file_and_says_what_was_assumed(draft: Any, tmp_path: Any) -> None:
    file = tmp_path / "unit.rexsj"
    file.write_text(draft.json(), encoding="utf-8")
    result = epicyclic.modes(str(file))
    told = [text for text in json.loads(result.attrs["warnings"]) if "read from a REXS file" in text]
    assert len(told) == 1
    assert f"`epicyclic import {file}` lists them [rexs-assumed]" in told[0]
    same = epicyclic.modes(dict(imported(draft).document))
    np.testing.assert_array_equal(result.frequency.values, same.frequency.values)
    stiffer = epicyclic.modes(str(file), overrides={"stages.main.sun.support.radial": "1e9 N/m"})
    assert not np.allclose(stiffer.frequency.values, same.frequency.values)


def test_planets_at_different_places_of_their_shafts_are_told(draft: Any) -> None:
    for gear, place in ((101, 25.0), (201, 25.0), (301, 26.0)):
        for name in ("support_vector", "u_axis_vector", "w_axis_vector", "reference_component_for_position"):
            draft.values(gear).pop(name)
        draft.values(gear)["u_coordinate_on_shaft"] = (place, "mm")
    found = imported(draft)
    assert "differs" not in lines(found.dropped, 201)
    assert lines(found.dropped, 301).startswith("u_coordinate_on_shaft:  differs from that of component 101")


def test_a_right_flank_of_another_pressure_angle_is_told(draft: Any) -> None:
    draft.values(108)["normal_pressure_angle"] = (21.0, "deg")
    found = imported(draft)
    assert "differs from that of the left flank, which counts" in lines(found.dropped, 108)
    assert lines(found.dropped, 107) == ""
    assert stage_of(found)["planet"]["pressure_angle"] == "20 deg"
