"""Arrangements beside the plain stage: herringbone, stepped planets, two stages, star; and what is told of the rest."""

from __future__ import annotations

import math
from typing import Any

import pytest
from tests.unit.rexs.imports import imported, lines, stage_of, value_of

import epicyclic


def test_a_herringbone_stage_of_two_gears_each(draft: Any) -> None:
    """Two gears of opposite hand on each shaft, 60 mm apart: one helix of 50 mm each side of a gap of 10 mm."""
    for gear, stages in ((11, ()), (21, ()), (101, (105, 106)), (201, (205, 206)), (301, (305, 306))):
        kind, name, values = draft.components[gear]
        helix = values["helix_angle_reference_diameter"][0]
        u, v, w = values["support_vector"][0]
        left = {**values, "support_vector": ([u - 30.0, v, w], "mm")}
        draft.components[gear] = (kind, name, left)
        right = {
            **values,
            "support_vector": ([u + 30.0, v, w], "mm"),
            "helix_angle_reference_diameter": (-helix, "deg"),
        }
        draft.components[gear + 5000] = (kind, name, right)
        shaft = next(r[1]["assembly"] for r in draft.relations if r[0] == "assembly" and r[1]["part"] == gear)
        draft.relate("assembly", assembly=shaft, part=gear + 5000)
        for stage in stages:
            draft.components[stage + 5000] = draft.components[stage]
            mates = next(r[1] for r in draft.relations if r[0] == "stage" and r[1]["stage"] == stage)
            draft.relate("stage", **{role: n + 5000 for role, n in mates.items()})
    stage = stage_of(imported(draft))
    assert (stage["herringbone"], stage["gap"], stage["face_width"]) == (True, "10 mm", "50 mm")
    assert stage["sun"]["hand"] == "right"  # of its left helix
    assert [stage[name]["teeth"] for name in ("sun", "planet", "ring")] == [24, 30, 84]
    assert "station" not in stage["sun"]
    epicyclic.load(dict(imported(draft).document))
    for gear in (11, 21, 101, 201, 301):  # the halves the other way round: the left one counts, not the first id
        left, right = draft.values(gear), draft.values(gear + 5000)
        left["support_vector"], right["support_vector"] = right["support_vector"], left["support_vector"]
    assert stage_of(imported(draft))["sun"]["hand"] == "left"


def test_stepped_planets(draft: Any) -> None:
    """The planets carry a second, smaller gear that meshes with the ring."""
    for i in (1, 2, 3):
        n = 100 * i
        kind, name, values = draft.components[n + 1]
        u, v, w = values["support_vector"][0]
        second = {**values, "number_of_teeth": (20, "none"), "support_vector": ([u + 70.0, v, w], "mm")}
        draft.components[n + 51] = (kind, name, second)
        draft.relate("assembly", assembly=n, part=n + 51)
        for relation in draft.relations:
            if relation[1].get("stage") == n + 6:
                relation[1]["gear_1"] = n + 51
    draft.values(21)["number_of_teeth"] = (74, "none")
    draft.values(21)["support_vector"] = ([170.0, 0.0, 0.0], "mm")
    stage = stage_of(imported(draft))
    assert stage["planet2"]["on"] == "planet"
    assert (stage["planet2"]["station"], stage["ring"]["station"]) == ("70 mm", "70 mm")
    assert set(stage["meshes"]) == {"sun-planet", "planet2-ring"}
    assert stage["planet2"]["kind"] == "planet"
    train = epicyclic.load(dict(imported(draft).document))
    assert len(train.meshes) == 6


def test_each_chain_of_stepped_planets_has_its_hand(draft: Any) -> None:
    test_stepped_planets(draft)
    for i in (1, 2, 3):
        draft.values(100 * i + 51)["helix_angle_reference_diameter"] = (15.0, "deg")
    draft.values(21)["helix_angle_reference_diameter"] = (15.0, "deg")
    stage = stage_of(imported(draft))
    assert (stage["sun"]["hand"], stage["planet2"]["hand"]) == ("right", "right")
    assert "hand" not in stage["planet"]


def test_a_stage_that_is_not_planetary_is_told(draft: Any) -> None:
    draft.add(700, "cylindrical_gear", "Wheel", **draft.values(11))
    draft.add(701, "cylindrical_gear", "Pinion", **draft.values(11))
    draft.add(702, "cylindrical_stage", "Output stage", center_distance=(200.0, "mm"))
    draft.relate("stage", stage=702, gear_1=700, gear_2=701)
    assert "gears 700 and 701 are in no planetary stage" in lines(imported(draft).dropped, 702)


def test_a_place_on_a_shaft_where_the_gear_has_none(draft: Any) -> None:
    plain = imported(draft).document
    for i in (1, 2, 3):
        del draft.values(100 * i + 1)["support_vector"]
        draft.values(100 * i + 1)["u_coordinate_on_shaft"] = (25.0, "mm")
    assert imported(draft).document == plain


def test_a_gear_without_any_place_stands_where_its_shaft_does(draft: Any) -> None:
    for i in (1, 2, 3):
        del draft.values(100 * i + 1)["support_vector"]
    assert stage_of(imported(draft))["planet_angles"] == "[0, 240, 120] deg"


def test_a_bearing_of_one_part_is_told(draft: Any) -> None:
    draft.relate("side", inner_part=30, assembly=33)
    assert "not between two parts" in lines(imported(draft).dropped, 33)


def test_two_stages_on_one_shaft(draft: Any) -> None:
    """A second stage whose sun sits on the carrier shaft of the first."""
    second = {}
    for number_, (kind, name, values) in list(draft.components.items()):
        if number_ in (1, 2, 90):
            continue
        copied = dict(values)
        if "support_vector" in copied:
            u, v, w = copied["support_vector"][0]
            copied["support_vector"] = ([u - 500.0, v, w], "mm")
        if number_ in (13, 10, 30, 32):
            for key in ("torque_around_u_axis", "rotational_speed", "defines_speed", "defines_torque"):
                copied.pop(key, None)
        second[number_ + 10_000] = (kind, name, copied)
    draft.components.update(second)
    for kind, roles in list(draft.relations):
        draft.relate(kind, **{role: n if n in (1, 2, 90) else n + 10_000 for role, n in roles.items()})
    draft.add(
        9,
        "coupling",
        "Joint",
        **{
            name: (1e20, unit)
            for name, unit in (
                ("radial_stiffness", "N / m"),
                ("axial_stiffness", "N / m"),
                ("bending_stiffness", "N mm / rad"),
                ("rotational_stiffness", "N mm / rad"),
            )
        },
    )
    draft.relate("side", inner_part=30, outer_part=10_010, assembly=9)
    found = imported(draft)
    assert list(found.document["stages"]) == ["stage1", "stage2"]  # type: ignore[call-overload]
    couplings: Any = found.document["couplings"]
    assert [one["between"] for one in couplings.values()] == [["stage1.carrier", "stage2.sun"]]
    operation: Any = found.document["operation"]
    assert operation["held"] == ["stage1.ring", "stage2.ring"]
    assert operation["speed"] == {"stage1.sun": "1500 rpm"}
    assert stage_of(found, "stage2")["sun"]["station"] == "-500 mm"
    epicyclic.load(dict(found.document))
    draft.values(9)["rotational_stiffness"] = (4e9, "N mm / rad")
    couplings = imported(draft).document["couplings"]
    assert couplings == {"coupling9": {"between": ["stage1.carrier", "stage2.sun"], "rz": "4e6 N m/rad"}}


def test_a_shaft_between_elastic_couplings_is_a_body(draft: Any) -> None:
    """The output torque acts on a flange that an elastic coupling joins to the carrier."""
    draft.add(40, "shaft", "flange", u_axis_vector=([-1.0, 0.0, 0.0], "mm"), support_vector=([-80.0, 0.0, 0.0], "mm"))
    draft.add(41, "shaft_section", "", length=(20.0, "mm"), outer_diameter_begin=(200.0, "mm"))
    draft.add(42, "coupling", "toothed", rotational_stiffness=(4e9, "N mm / rad"), radial_stiffness=(0.0, "N / m"))
    draft.add(43, "external_load", "", torque_around_u_axis=(900.0, "N m"), defines_torque=(True, "none"))
    draft.relate("assembly", assembly=40, part=41)
    draft.relate("assembly", assembly=40, part=43)
    draft.relate("reference", origin=40, referenced=90)
    draft.relate("side", inner_part=30, outer_part=40, assembly=42)
    draft.values(13).pop("defines_torque")
    found = imported(draft)
    mass = 7800 * math.pi / 4 * 0.2**2 * 0.02
    flange = found.document["bodies"]["flange"]  # type: ignore[index]
    assert value_of(flange["mass"]) == pytest.approx(mass, rel=1e-8)
    assert value_of(flange["inertia"]) == pytest.approx(mass * 0.2**2 / 8, rel=1e-8)
    couplings: Any = found.document["couplings"]
    assert couplings == {"toothed": {"between": ["main.carrier", "flange"], "rz": "4e6 N m/rad"}}
    operation: Any = found.document["operation"]
    assert operation["torque"] == {"flange": "-900 N m", "sun": "balance"}  # its u axis is against z
    train = epicyclic.load(dict(found.document))
    assert any(body.name == "flange" for body in train.bodies)
    # of two ends that take up what is left, none is the balance
    draft.values(32)["torque_around_u_axis"] = (-100.0, "N m")
    operation = imported(draft).document["operation"]
    assert operation["torque"] == {"flange": "-900 N m"}


def test_a_star_has_its_carrier_in_the_casing(draft: Any) -> None:
    draft.relations = [r for r in draft.relations if r[1].get("assembly") not in (23,)]
    draft.add(25, "coupling", "", rotational_stiffness=(1e20, "N mm / rad"))
    draft.relate("side", inner_part=30, outer_part=2, assembly=25)
    found = imported(draft)
    assert found.document["operation"]["held"] == ["carrier"]  # type: ignore[index]
    train = epicyclic.load(dict(found.document))
    assert len(train.meshes) == 6
