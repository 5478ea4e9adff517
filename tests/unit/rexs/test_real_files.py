"""Real REXS files: the planetary stage of the FVA and a cylindrical gear unit, against numbers worked by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.rexs.encodings import read_rexs_file
from epicyclic.rexs.import_train import read_rexs

Find = Callable[[str], Path]
XML, ZIP, DAMAGED, SECOND = "gearing_1.1.rexs", "gearing_1.1.rexsz", "gearing_1.1.rexsj", "gearing_1.1_vers2.rexsj"


def test_geometry_torque_and_held_ring(real: Find) -> None:
    document: Any = read_rexs(real(XML)).document
    stage = document["stages"]["main"]
    assert [stage[name]["teeth"] for name in ("sun", "planet", "ring")] == [17, 22, 61]
    assert stage["centre_distance"] == "78 mm"
    assert (stage["module"], stage["face_width"], stage["pressure_angle"]) == ("4 mm", "50 mm", "20 deg")
    assert "helix_angle" not in stage  # 0 and -0
    assert stage["planet_angles"] == "[0, 240, 120] deg"
    operation = document["operation"]
    assert operation == {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "1591.5494309189535 N m"}}
    assert float(operation["torque"]["sun"].split()[0]) * 1500 * math.pi / 30 == pytest.approx(250e3, rel=1e-12)


def test_reaction_and_speed_of_the_carrier_by_hand(real: Find) -> None:
    """The file does not give the output torque: with the ring held it is -(1 + 61/17) times that of the sun."""
    kinematics = epicyclic.load(real(XML)).kinematics
    assert kinematics.torque is not None
    assert kinematics.speed is not None
    assert kinematics.torque["main.carrier"] == pytest.approx(-1591.5494309189535 * (1 + 61 / 17), rel=1e-12)
    assert kinematics.torque["main.ring"] == pytest.approx(1591.5494309189535 * 61 / 17, rel=1e-12)
    assert float(kinematics.speed["main.carrier"]) == pytest.approx(1500 * 17 / (17 + 61), rel=1e-12)


def test_angles_and_their_sense_by_hand(real: Find) -> None:
    """Support vectors of the planets, turned about +u by hand: w towards -v is positive."""
    file = read_rexs_file(real(XML))
    parts = {component.id: component for component in file.components}
    places: list[Any] = [parts[i].attributes["support_vector"].value for i in (247, 248, 249)]
    # u = (1, 0, 0), w = (0, 0, 1), v = w x u = (0, 1, 0); turning w by +90 deg about u gives u x w = -v
    angles = [math.degrees(math.atan2(-v, w)) % 360 for _, v, w in places]
    assert angles == pytest.approx([0, 240, 120], abs=1e-9)
    stated: list[Any] = [parts[i].attributes["rotating_angle_around_neg_u_axis"].value for i in (211, 212, 213)]
    assert [-angle % 360 for angle in stated] == pytest.approx([0, 240, 120], abs=1e-9)
    train = epicyclic.load(real(XML))
    # psi about +z = +u; a sun that turns positive relative to the carrier leads by -z_s psi / 2 pi
    leads = [mesh.lead for mesh in train.meshes if "sun-planet" in mesh.name]
    expected = [(-17 * angle / 360) % 1 for angle in (0, 240, 120)]
    assert [float(lead) % 1 for lead in leads] == pytest.approx(expected, abs=1e-12)


def test_mesh_forces_by_hand(real: Find) -> None:
    even = {f"stages.main.meshes.{pair}.variation": "none" for pair in ("sun-planet", "planet-ring")}
    forces = epicyclic.static(real(XML), overrides=even).mesh_force
    varying = epicyclic.static(real(XML)).mesh_force
    # T = 3 F r_b, r_b = m z cos(alpha) / 2; the planet is in balance, so the ring mesh carries the same
    expected = 1591.5494309189535 / (3 * 0.004 * 17 / 2 * math.cos(math.radians(20)))
    assert expected == pytest.approx(16604.8, abs=0.1)
    assert forces.values == pytest.approx(expected, rel=1e-9)
    for pair in ("sun-planet", "planet-ring"):  # one planet has more, another less, while the stiffness varies
        three = varying.sel(mesh=[f"main/{pair}/{i}" for i in (1, 2, 3)])
        assert three.sum("mesh").values == pytest.approx(3 * expected, rel=1e-9)


def test_stiffness_and_masses_by_hand(real: Find) -> None:
    stage: Any = read_rexs(real(XML)).document["stages"]["main"]  # type: ignore[index]
    meshes = stage["meshes"]
    assert {meshes[pair]["stiffness"] for pair in ("sun-planet", "planet-ring")} == {"20 N/(mm um)"}
    train = epicyclic.load(real(XML))
    masses = {body.name: body.mass for body in train.bodies}
    quarter = 7850 * math.pi / 4
    assert masses["main/sun"] == pytest.approx(quarter * (0.034**2 * 0.15 + (0.068**2 - 0.034**2) * 0.05), rel=1e-8)
    planet = quarter * (0.058**2 - 0.057**2 + 0.088**2 - 0.058**2) * 0.05
    assert masses["main/planet/1"] == pytest.approx(planet, rel=1e-8)
    ring = quarter * (0.28**2 - 0.265**2 + 0.265**2 - 0.244**2) * 0.05
    assert masses["main/ring"] == pytest.approx(ring, rel=1e-8)
    plates = (0.219**2 - 0.08**2) * 0.008 + (0.219**2 - 0.099**2) * 0.008
    shafts = (0.08**2 - 0.06**2) * 0.1 + (0.099**2 - 0.088**2) * 0.008 + (0.16425**2 - 0.1095**2) * 0.05
    assert masses["main/carrier"] == pytest.approx(quarter * (plates + shafts + 3 * 0.0432**2 * 0.066), rel=1e-8)


def test_rigid_bearings_and_their_places(real: Find) -> None:
    stage: Any = read_rexs(real(XML)).document["stages"]["main"]  # type: ignore[index]
    rigid = {"radial": math.inf, "tilt": 0}
    assert stage["sun"]["support"] == {
        "bearing36": {"at": "50 mm", "z": math.inf, **rigid},
        "bearing37": {"at": "102.5 mm", "z": 0, **rigid},
    }
    assert [one["at"] for one in stage["planet"]["bearing"].values()] == ["-12.5 mm", "12.5 mm"]
    assert [one["at"] for one in stage["carrier"]["support"].values()] == ["-100 mm", "-50 mm"]


def test_xml_and_zip_are_equal(real: Find) -> None:
    one, other = read_rexs(real(XML)), read_rexs(real(ZIP))
    assert one.document == other.document
    assert set(one.read) == set(other.read)
    assert set(one.assumed) == set(other.assumed)
    assert {e.component for e in one.dropped} == {e.component for e in other.dropped}
    files = [read_rexs_file(real(end)) for end in (XML, ZIP)]
    assert {c.id: c for c in files[0].components} == {c.id: c for c in files[1].components}
    assert (len(files[0].components), len(files[0].relations)) == (97, 140)


def test_every_component_is_told_of(real: Find) -> None:
    """What has attributes is read, assumed or dropped: nothing vanishes without a word."""
    found = read_rexs(real(XML))
    told = {entry.component for entry in (*found.read, *found.assumed, *found.dropped)}
    joined = {248, 249, 261, 265, 266, 267, 268, 269, 270, 271, 272}  # sections and planets that their shaft tells of
    silent = {c.id for c in found.file.components if c.attributes} - told - joined
    types = {c.id: c.type for c in found.file.components}
    assert {types[i] for i in silent} <= {"shaft", "shaft_section", "side_plate"}
    lubricant = next(e for e in found.dropped if e.component == 91)
    assert lubricant.text == "no lubricant in the model"


def test_the_damaged_file_is_refused_with_what_is_lost(real: Find) -> None:
    with pytest.raises(ModelError) as caught:
        read_rexs(real(DAMAGED))
    text = str(caught.value)
    for name, count in (("support_vector", 41), ("u_axis_vector", 41), ("w_axis_vector", 41), ("is_engaged", 2)):
        assert f"{name} ({count} times" in text
    for name in ("axial_force_absorption", "material_designation", "kind", "name"):
        assert name in text


def test_the_second_json_is_read_and_its_false_texts_are_listed(real: Find) -> None:
    found = read_rexs(real(SECOND))
    stage: Any = found.document["stages"]["main"]  # type: ignore[index]
    assert [stage[name]["teeth"] for name in ("sun", "planet", "ring")] == [17, 22, 61]
    assert stage["planet_angles"] == "[0, 240, 120] deg"
    assert found.document["operation"] == {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "power": {"sun": "100 kW"}}
    false = {entry.component for entry in found.assumed if "stands as false" in entry.text}
    assert {36, 37, 46, 47, 48, 49, 50, 51, 59, 60} <= false  # axial_force_absorption of every bearing
    assert stage["sun"]["flank"]["crown"] == "0.004999999999999999 mm"
    told = {entry.component: entry.text for entry in found.dropped}
    assert "profile crowning" in told[1000041]
    assert epicyclic.load(real(SECOND)).title.startswith("Gear unit [1] (REXS 1.4")


def test_a_file_without_planetary_stage_is_refused_with_that_reason(real: Find) -> None:
    with pytest.raises(ModelError, match=r"REXS 1\.0 has no planetary stage"):
        epicyclic.load(real("gearbox_1.0.rexs"))
    raw = real("gearbox_1.0.rexs").read_bytes().replace(b'version="1.0"', b'version="1.1"')
    with pytest.raises(ModelError, match=r"no planetary stage \(stages in it: cylindrical_stage\)"):
        read_rexs(raw)
