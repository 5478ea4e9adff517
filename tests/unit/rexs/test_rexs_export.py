"""A train as a REXS file: values by hand, round trips of every kind of train, K_gamma, what is refused and listed."""

from __future__ import annotations

import copy
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import epicyclic
from epicyclic.bearings.rolling_bearing import contact_set, displacement, static_rating
from epicyclic.cli.main import app
from epicyclic.errors import ModelError
from epicyclic.rexs.encodings import read_rexs_file
from epicyclic.rexs.export import rexs_of, write_rexs
from epicyclic.rexs.file import Component, RexsFile
from epicyclic.rexs.import_train import import_file, read_rexs
from epicyclic.train.train import Train

STIFFNESS = "mean_mesh_stiffness_for_transverse_load_iso_6336_2019"
FACTOR = "mesh_load_factor_iso_6336_2019"
SPUR: dict[str, Any] = {
    "format": 2,
    "title": "Spur stage",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "face_width": "50 mm",
            "sun": {
                "teeth": 20,
                "mass": "10 kg",
                "inertia": "0.02 kg m^2",
                "tilt_inertia": "0.03 kg m^2",
                "support": {"radial": "5e7 N/m"},
            },
            "planet": {
                "teeth": 20,
                "mass": "8 kg",
                "inertia": "0.01 kg m^2",
                "tilt_inertia": "0.02 kg m^2",
                "bearing": {"radial": "4e8 N/m", "z": "1e8 N/m"},
            },
            "ring": {
                "teeth": 60,
                "mass": "20 kg",
                "inertia": "0.4 kg m^2",
                "tilt_inertia": "0.3 kg m^2",
                "support": {"radial": "1e9 N/m", "rz": "2e7 N m/rad"},
            },
            "carrier": {
                "mass": "40 kg",
                "inertia": "0.5 kg m^2",
                "tilt_inertia": "0.3 kg m^2",
                "support": {
                    "front": {"at": "-60 mm", "radial": "1e9 N/m"},
                    "rear": {"at": "60 mm", "radial": "2e9 N/m", "z": 0},
                },
            },
            "meshes": {
                "sun-planet": {"stiffness": "5e8 N/m", "backlash": "0.2 mm"},
                "planet-ring": {"stiffness": "6e8 N/m"},
            },
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
}
# the same stage as one would write it from the drawing: a = 4 (20 + 20) / 2 = 80 mm; u is z, w is x, v is -y
BY_HAND = """<?xml version="1.0" encoding="UTF-8"?>
<model version="1.7" applicationId="hand" applicationVersion="1" date="2024-01-01T00:00:00+00:00"><relations/>
<components>
<component id="1" type="cylindrical_gear" name="main.sun">
 <attribute id="number_of_teeth" unit="none">20</attribute>
 <attribute id="normal_module" unit="mm">4</attribute>
 <attribute id="helix_angle_reference_diameter" unit="deg">0</attribute>
 <attribute id="face_width" unit="mm">50</attribute>
 <attribute id="tip_diameter" unit="mm">88</attribute>
 <attribute id="root_diameter" unit="mm">70</attribute>
 <attribute id="support_vector" unit="mm"><array><c>0</c><c>0</c><c>0</c></array></attribute>
</component>
<component id="2" type="ring_gear" name="main.ring">
 <attribute id="number_of_teeth" unit="none">60</attribute>
 <attribute id="tip_diameter" unit="mm">232</attribute>
 <attribute id="root_diameter" unit="mm">250</attribute>
</component>
<component id="3" type="cylindrical_gear" name="main.planet 1">
 <attribute id="support_vector" unit="mm"><array><c>0</c><c>0</c><c>80</c></array></attribute>
</component>
<component id="4" type="cylindrical_gear" name="main.planet 2">
 <attribute id="support_vector" unit="mm"><array><c>0</c><c>-69.28203230275508</c><c>-40</c></array></attribute>
</component>
<component id="5" type="cylindrical_gear" name="main.planet 3">
 <attribute id="support_vector" unit="mm"><array><c>0</c><c>69.28203230275508</c><c>-40</c></array></attribute>
</component>
<component id="6" type="cylindrical_gear_flank" name="main.planet 2 left flank">
 <attribute id="normal_pressure_angle" unit="deg">20</attribute>
 <attribute id="addendum_modification_coefficient" unit="none">0</attribute>
</component>
<component id="7" type="cylindrical_stage" name="main/sun-planet/2">
 <attribute id="center_distance" unit="mm">80</attribute>
 <attribute id="rotating_angle_around_neg_u_axis" unit="deg">240</attribute>
 <attribute id="common_face_width" unit="mm">50</attribute>
 <attribute id="mean_mesh_stiffness_for_transverse_load_iso_6336_2019" unit="N / (mm mum)">10</attribute>
 <attribute id="minimum_normal_backlash" unit="mm">0.2</attribute>
</component>
<component id="8" type="cylindrical_stage" name="main/planet-ring/2">
 <attribute id="center_distance" unit="mm">80</attribute>
 <attribute id="rotating_angle_around_neg_u_axis" unit="deg">60</attribute>
 <attribute id="mean_mesh_stiffness_for_transverse_load_iso_6336_2019" unit="N / (mm mum)">12</attribute>
</component>
<component id="9" type="concept_bearing" name="main/planet/2/bearing">
 <attribute id="radial_stiffness" unit="N / m">4e8</attribute>
 <attribute id="axial_stiffness" unit="N / m">1e8</attribute>
 <attribute id="bending_stiffness" unit="N mm / rad">1e20</attribute>
 <attribute id="axial_force_absorption" unit="none">both_directions</attribute>
</component>
<component id="10" type="concept_bearing" name="main/carrier/support/rear">
 <attribute id="radial_stiffness" unit="N / m">2e9</attribute>
 <attribute id="axial_stiffness" unit="N / m">0</attribute>
 <attribute id="axial_force_absorption" unit="none">no_direction</attribute>
 <attribute id="support_vector" unit="mm"><array><c>60</c><c>0</c><c>0</c></array></attribute>
</component>
<component id="11" type="coupling" name="main/ring/support">
 <attribute id="radial_stiffness" unit="N / m">1e9</attribute>
 <attribute id="rotational_stiffness" unit="N mm / rad">2e10</attribute>
</component>
<component id="12" type="shaft" name="main.carrier">
 <attribute id="rotational_speed" unit="1 / min">375</attribute>
 <attribute id="defines_speed" unit="none">false</attribute>
</component>
<component id="13" type="external_load" name="main.carrier torque">
 <attribute id="torque_around_u_axis" unit="N m">-3200</attribute>
 <attribute id="defines_torque" unit="none">false</attribute>
</component>
<component id="14" type="external_load" name="main.sun torque">
 <attribute id="torque_around_u_axis" unit="N m">800</attribute>
 <attribute id="defines_torque" unit="none">true</attribute>
</component>
<component id="15" type="additional_mass" name="main.planet 3 mass">
 <attribute id="mass" unit="kg">8</attribute>
 <attribute id="moment_of_inertia_u_axis" unit="kg m^2">0.01</attribute>
 <attribute id="moment_of_inertia_w_axis" unit="kg m^2">0.02</attribute>
</component>
</components></model>"""


def changed(**paths: Any) -> dict[str, Any]:
    """The stage with values put at paths, None removing one; dots of the path as double underscores."""
    model = copy.deepcopy(SPUR)
    for path, value in paths.items():
        *above, last = path.split("__")
        table = model
        for part in above:
            table = table.setdefault(part, {})
        if value is None:
            del table[last]
        else:
            table[last] = value
    return model


def named(file: RexsFile) -> dict[tuple[str, str], Component]:
    return {(component.type, component.name): component for component in file.components}


def test_values_by_hand() -> None:
    hand = read_rexs_file(BY_HAND.encode())
    found = named(rexs_of(epicyclic.load(SPUR)).file)
    for key, component in named(hand).items():
        for name, attribute in component.attributes.items():
            ours = found[key].attributes[name]
            assert ours.unit == attribute.unit, (key, name)
            expected = attribute.value
            if isinstance(expected, (str, bool)):
                assert ours.value == expected, (key, name)
            else:
                assert ours.value == pytest.approx(expected, rel=1e-12, abs=1e-12), (key, name)


def test_relations_of_the_standard() -> None:
    file = rexs_of(epicyclic.load(SPUR)).file
    kinds = [relation.type for relation in file.relations]
    counts = {"planet_shaft": 3, "planet_pin": 3, "planet_carrier_shaft": 1, "central_shaft": 2, "stage": 6,
              "stage_gear_data": 12, "flank": 5, "side": 3 + 1 + 2 + 1}  # fmt: skip
    assert {kind: kinds.count(kind) for kind in counts} == counts
    types = {component.id: component.type for component in file.components}
    roles = {"planet_shaft": ("planetary_stage", "shaft"), "stage": ("stage", "gear_1", "gear_2"),
             "side": ("assembly", "inner_part", "outer_part"), "flank": ("gear", "left", "right"),
             "stage_gear_data": ("stage", "gear", "stage_gear_data")}  # fmt: skip
    for relation in file.relations:
        if relation.type in roles:
            assert tuple(role for role, _ in relation.refs) == roles[relation.type]
        if relation.type == "stage_gear_data":
            assert types[relation.part("stage_gear_data") or 0] == "cylindrical_stage_gear_data"
    assert types[1] == "gear_unit"
    drives = [c.attributes["is_driving_gear"].value for c in file.components if c.type == "cylindrical_stage_gear_data"]
    assert drives == [True, False] * 6  # from the sun to the planet to the ring


def _stepped() -> dict[str, Any]:
    model = changed(
        stages__main__planet2={"kind": "planet", "teeth": 16, "on": "planet", "station": "70 mm", "mass": "0 kg",
                               "inertia": "0 kg m^2", "tilt_inertia": "0 kg m^2"},
        stages__main__ring__teeth=56,
        stages__main__ring__station="70 mm",
    )  # fmt: skip
    meshes = {"sun-planet": {"stiffness": "5e8 N/m"}, "planet2-ring": {"stiffness": "6e8 N/m"}}
    model["stages"]["main"]["meshes"] = meshes
    return model


def _two() -> dict[str, Any]:
    """Two stages with an elastic shaft between the sun of the first and the carrier of the second."""
    model = changed()
    stage = model["stages"].pop("main")
    model["stages"] = {"low": copy.deepcopy(stage), "high": stage}
    model["stages"]["low"]["helix_angle"] = "12 deg"
    model["couplings"] = {"mid": {"between": ["low.sun", "high.carrier"], "rz": "1e6 N m/rad"}}
    model["operation"] = {"held": ["low.ring", "high.ring"], "speed": {"low": {"carrier": "20 rpm"}},
                          "torque": {"low": {"carrier": "5 kN m"}}}  # fmt: skip
    return model


TRAINS = {
    "planetary": changed(),
    "backwards": changed(operation__speed__sun="-1500 rpm"),
    "star": changed(operation__held=["carrier"], stages__main__ring__support__rz=None),
    "no carrier": changed(operation__held=None, stages__main__carrier=None, stages__main__ring__support__rz=None),
    "differential": changed(
        operation__held=None,
        operation__speed={"sun": "1500 rpm", "ring": "100 rpm"},
        stages__main__ring__support__rz=None,
    ),
    "herringbone": changed(
        stages__main__herringbone=True,
        stages__main__helix_angle="25 deg",
        stages__main__gap="20 mm",
        stages__main__sun__hand="left",
    ),
    "unequal places": changed(stages__main__planets=None, stages__main__planet_angles="[0, 117, 249] deg"),
    "profile shift": changed(
        stages__main__sun__profile_shift=0.3,
        stages__main__planet__profile_shift=-0.1,
        stages__main__centre_distance="80.7 mm",
    ),
    "relief": changed(
        stages__main__flank={"tip_relief": {"amount": "15 um", "length": "1 mm", "shape": "parabolic"}, "crown": "5 um"}
    ),
    "stepped": _stepped(),
    "two stages": _two(),
    "material": changed(material={"density": "7800 kg/m^3", "youngs_modulus": "200 GPa", "poisson_ratio": 0.28}),
}


def facts(train: Train) -> dict[str, list[Any]]:
    """What a REXS file carries of a train, without names."""
    kinematics = train.kinematics
    assert kinematics.speed is not None
    assert kinematics.torque is not None

    def digits(*values: float) -> tuple[float, ...]:
        return tuple(float(f"{value:.11g}") if abs(value) > 1e-13 else 0.0 for value in values)

    return {
        "speeds": sorted(kinematics.speed.values()),
        "torques": sorted(digits(*kinematics.torque.values())),
        "bodies": sorted(digits(b.mass, b.inertia, b.tilt_inertia, *b.centre, b.station) for b in train.bodies),
        "gears": sorted(
            digits(g.teeth, g.module, g.hand * g.helix_angle, g.pressure_angle, g.profile_shift, g.tip_radius,
                   g.root_radius, g.base_radius, g.face_width or 0.0)
            for b in train.bodies if (g := b.gear) is not None
        ),
        "links": sorted((digits(*link.centre, link.station), link.stiffness) for link in train.links),
        "meshes": sorted(
            (*digits(m.stiffness, float(m.lead) % 1, m.pressure_angle, m.backlash, m.contact_ratio), m.hand, m.flank)
            for m in train.meshes
        ),
        "flanks": sorted(str((m.teeth.flank_a, m.teeth.flank_b)) for m in train.meshes if m.teeth is not None),
    }  # fmt: skip


@pytest.mark.parametrize("name", TRAINS)
def test_a_train_written_and_read_is_the_same(name: str, tmp_path: Path) -> None:
    path = tmp_path / "train.rexs"
    write_rexs(TRAINS[name], path)
    before, after = epicyclic.load(TRAINS[name]), epicyclic.load(path)
    mine, theirs = facts(before), facts(after)
    for key, values in mine.items():
        assert theirs[key] == values or key == "links", key
    # a member that stands rigidly has a rigid bearing in the file, and none in the model
    assert {str(one) for one in mine["links"]} <= {str(one) for one in theirs["links"]} or name == "stepped"


def test_gears_on_parallel_axes_are_of_no_planetary_stage(tmp_path: Path) -> None:
    """Read again, the planetary stage carries its torque to the shaft of the wheel, which takes the balance."""
    gear = {"mass": "10 kg", "inertia": "0.1 kg m^2", "tilt_inertia": "0.1 kg m^2", "support": {"radial": "1e9 N/m"}}
    fast = {"module": "4 mm", "face_width": "40 mm", "wheel": {"teeth": 50, **gear}, "pinion": {"teeth": 20, **gear}}
    model = changed()
    model["stages"]["fast"] = fast
    model["couplings"] = {"shaft": {"between": ["main.sun", "fast.wheel"], "rz": "1e6 N m/rad"}}
    model["operation"] = {
        "held": ["main.ring"],
        "speed": {"main": {"carrier": "300 rpm"}},
        "torque": {"main": {"carrier": "3200 N m"}, "fast": {"pinion": "balance"}},
    }
    path = tmp_path / "wind.rexs"
    written = write_rexs(model, path)
    assert ["stages.fast"] == [entry.path for entry in written.dropped if "reads planetary stages alone" in entry.text]
    text = path.read_text()
    assert text.count('type="planetary_stage"') == 1
    assert text.count('type="cylindrical_stage"') == 7
    before, after = epicyclic.load(model), epicyclic.load(path)
    assert list(after.planets) == ["main"]
    assert set(before.planets) == {"main", "fast"}
    (end,) = [body for body in after.torques if body not in ("main/carrier", "main/ring")]
    assert abs(after.torques[end]) == pytest.approx(3200 * 20 / 80, rel=1e-9)
    result = epicyclic.static(after)
    assert result.sizes["mesh"] == 6
    told = f"1 gear stage without planets is not read: the train ends at {end} [rexs-stages-unread]"
    assert told in json.loads(result.attrs["warnings"])
    reasons = {(e.component, e.text) for e in read_rexs(path).dropped}
    apart = [c.id for c in written.file.components if c.name.startswith("fast.pinion")]
    apart += [c.id for c in written.file.components if c.type == "cylindrical_gear" and c.name == "fast.wheel"]
    assert {one for one, text in reasons if text == "of no planetary stage"} >= set(apart) != set()


@pytest.mark.parametrize(
    ("changes", "thin"),
    [
        ({"rim": "3 mm"}, True),
        ({"rim": "3 mm", "mass": "9 kg", "inertia": "0.3 kg m^2", "tilt_inertia": "0.2 kg m^2"}, True),
        ({"outer_diameter": "320 mm", "mass": None, "inertia": None, "tilt_inertia": None}, False),
        ({"rim": "3 mm", "mass": "0.1 kg"}, None),
    ],
)
def test_the_rim_of_a_ring(changes: dict[str, Any], thin: bool | None, tmp_path: Path) -> None:
    """A section of its shaft from the pitch circle out has the rim; the additional mass what is left of the mass."""
    model = changed(**{f"stages__main__ring__{key}": value for key, value in changes.items() if value is not None})
    for key in [key for key, value in changes.items() if value is None]:
        model["stages"]["main"]["ring"].pop(key, None)
    path = tmp_path / "rim.rexs"
    written = write_rexs(model, path)
    before, after = epicyclic.load(model), epicyclic.load(path)
    mine, theirs = (next(b for b in train.bodies if b.kind == "ring") for train in (before, after))
    masses = [(b.mass, b.inertia, b.tilt_inertia) for b in (mine, theirs)]
    assert masses[1] == pytest.approx(masses[0], rel=1e-8)
    if thin is None:  # more than all of the mass stated: no rim in the file
        assert theirs.outer_radius != mine.outer_radius
        assert "stages.main.ring.rim" in [entry.path for entry in written.dropped]
        return
    assert theirs.outer_radius == pytest.approx(mine.outer_radius, rel=1e-9)
    assert any("[thin-rim]" in text for text in before.warnings) is thin
    assert any("[thin-rim]" in text for text in after.warnings) is thin
    assert not any(entry.path.startswith("stages.main.ring") for entry in written.dropped)


def test_reasons_of_what_an_import_drops() -> None:
    """Masses of planets 2 and 3 are read with planet 1; the mass of a shaft without sections is no section's."""
    file = rexs_of(epicyclic.load(SPUR)).file
    ids = {(c.type, c.name): c.id for c in file.components}
    found = import_file(file)
    for i in (2, 3):
        lines = {
            e.attribute: e.text for e in found.dropped if e.component == ids["additional_mass", f"main.planet {i} mass"]
        }
        assert (
            lines["mass, moment_of_inertia_u_axis, moment_of_inertia_v_axis, moment_of_inertia_w_axis"]
            == "equal to planet 1"
        )
    assert {e.attribute for e in found.read if e.path == "stages.main.sun.mass"} == {"additional_mass"}
    heavier = [
        replace(c, attributes={**c.attributes, "mass": replace(c.attributes["mass"], value=9.0)})
        if c.name == "main.planet 3 mass" else c for c in file.components
    ]  # fmt: skip
    dropped = import_file(replace(file, components=tuple(heavier))).dropped
    text = next(
        e.text for e in dropped if e.component == ids["additional_mass", "main.planet 3 mass"] and e.attribute == "mass"
    )
    assert text == f"component {ids['additional_mass', 'main.planet 1 mass']}, of planet 1, counts for all planets"


def test_natural_frequencies_of_a_ready_drive(tmp_path: Path) -> None:
    path = tmp_path / "wind.rexsz"
    write_rexs("wind-five", path)
    before, after = (epicyclic.modes(source).frequency.values for source in ("wind-five", path))
    assert after == pytest.approx(before, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("end", [".rexs", ".rexsj", ".rexsz"])
def test_every_encoding_is_the_same_file(end: str, tmp_path: Path) -> None:
    found = write_rexs(SPUR, tmp_path / f"a{end}")
    read = read_rexs_file(tmp_path / f"a{end}")
    assert (read.components, read.relations, read.version) == (found.file.components, found.file.relations, "1.7")
    write_rexs(SPUR, tmp_path / f"b{end}")
    one, other = ((tmp_path / f"{name}{end}").read_bytes() for name in "ab")
    assert one == other or end == ".rexsz"  # a zip has the name of the file in it


def test_a_file_read_and_written_again_keeps_its_model() -> None:
    once = import_file(rexs_of(epicyclic.load(SPUR)).file)
    again = import_file(rexs_of(epicyclic.load(dict(once.document))).file)
    stages: list[dict[str, Any]] = [one.document["stages"]["main"] for one in (once, again)]  # type: ignore[index]
    assert stages[0].keys() == stages[1].keys()
    for key in ("planets", "centre_distance", "module", "face_width", "pressure_angle", "meshes"):
        assert stages[0][key] == stages[1][key], key
    assert {**once.document["operation"]} == {**again.document["operation"]}  # type: ignore[dict-item]


def test_mesh_load_factor_is_that_of_sharing() -> None:
    model = changed(
        stages__main__planets=4,
        deviations={"planet": {"position": {"y": "[20, 0, 0, 0] um"}}},
    )
    train = epicyclic.load(model)
    file = rexs_of(train).file
    coefficients = epicyclic.sharing(train, method="static", cycles=1).load_sharing.sel(definition="mean-load")
    for pair in ("sun-planet", "planet-ring"):
        largest = max(float(coefficients.sel(mesh=f"main/{pair}/{i}")) for i in range(1, 5))
        assert largest > 1.01
        for i in range(1, 5):
            written = named(file)["cylindrical_stage", f"main/{pair}/{i}"].attributes[FACTOR].value
            assert written == pytest.approx(largest, rel=1e-9)


@pytest.mark.parametrize(
    ("model", "reason"),
    [
        (SPUR, "states no deviations"),
        (changed(operation__torque=None, deviations={"planet": {"position": {"y": "[20, 0, 0] um"}}}), "no torque"),
    ],
)
def test_no_mesh_load_factor_where_there_is_none(model: dict[str, Any], reason: str) -> None:
    found = rexs_of(epicyclic.load(model))
    assert not any(FACTOR in component.attributes for component in found.file.components)
    assert any(entry.path == "K_gamma" and reason in entry.text for entry in found.dropped)


def test_stiffness_is_transverse_and_per_width() -> None:
    model = changed(stages__main__helix_angle="20 deg", stages__main__planet__face_width="45 mm")
    train = epicyclic.load(model)
    base = math.asin(math.sin(math.radians(20)) * math.cos(math.radians(20)))  # sin beta_b = sin beta cos alpha_n
    found = named(rexs_of(train).file)["cylindrical_stage", "main/sun-planet/1"].attributes
    assert found[STIFFNESS].value == pytest.approx(5e8 * math.cos(base) ** 2 / 0.045 / 1e9, rel=1e-12)
    assert found["common_face_width"].value == 45.0


@pytest.mark.parametrize(
    ("source", "problem"),
    [("yue2014-i", "planets that mesh with each other"), ("lin1999-n4", "do not fit their places")],
)
def test_what_would_be_another_train_is_refused(source: str, problem: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=problem):
        write_rexs(source, tmp_path / "a.rexs")
    assert list(tmp_path.iterdir()) == []


def test_what_is_not_carried_is_listed() -> None:
    model = changed(
        notes="of a test",
        stages__main__sun__bore="30 mm",
        stages__main__planet__bearing__clearance="20 um",
        stages__main__flank={"root_relief": {"amount": "10 um", "length": "1 mm"}},
        stages__main__sun__support={"x": "5e7 N/m", "y": "7e7 N/m"},
        deviations={"sun": {"run_out": "10 um"}},
        operation={"held": ["carrier"]},
    )
    del model["stages"]["main"]["ring"]["support"]["rz"]
    del model["stages"]["main"]["planet"]["bearing"]["z"]
    found = rexs_of(epicyclic.load(model))
    paths = {entry.path for entry in found.dropped}
    assert {"notes", "damping.modal", "stages.main.sun.bore", "stages.main.planet.bearing.clearance",
            "stages.main.sun.flank.root_relief", "deviations.main.sun.run_out", "stages.main.sun.support",
            "K_gamma"} <= paths  # fmt: skip
    bearing = named(found.file)["concept_bearing", "main/sun/support"]
    assert bearing.attributes["radial_stiffness"].value == 6e7


def test_a_bearing_by_its_parts_says_where_its_stiffness_holds() -> None:
    """One row at half of its static rating, as its tangent there; of two rows x and y are the same but for rounding."""
    parts: dict[str, Any] = {
        "type": "cylindrical roller",
        "elements": 13,
        "element_diameter": "10 mm",
        "element_length": "16 mm",
    }
    parts |= {"pitch_diameter": "56 mm"}
    clearance = {"initial": "40 um", "bore": "40 mm", "inner_fit": "5 um"}
    model = changed(stages__main__planet__bearing={**parts, "internal_clearance": clearance})
    found, train = rexs_of(epicyclic.load(model)), epicyclic.load(model)
    said = {entry.path: entry.text for entry in found.dropped}
    rolling = next(link.rolling for link in train.links if link.rolling)
    load = static_rating(rolling) / 2
    written = named(found.file)["concept_bearing", "main/planet/1/bearing"].attributes["radial_stiffness"].value
    slope = contact_set(rolling).tangent(displacement(rolling, [load]))[0, 0]
    assert written == pytest.approx(slope, rel=1e-3)  # of the curve by points
    where = "stages.main.planet.bearing"
    assert said[where] == f"law of its parts: the stiffness at a radial force of {load / 1e3:.4g} kN is written"
    assert said[f"{where}.internal_clearance.bore"] == "play has no place"

    two = changed(stages__main__planet__bearing={**parts, "rows": 2, "row_distance": "17 mm"})
    texts = [entry.text for entry in rexs_of(epicyclic.load(two)).dropped if entry.path == where]
    (link, *_) = (link for link in epicyclic.load(two).links if link.contacts)
    assert link.contacts is not None
    force = f"contact forces of {link.contacts.load / 1e3:.4g} kN in sum, alike all round"
    assert texts == [f"law of its parts: the stiffness under {force} is written"]


def test_gravity_points_down_in_the_axes_of_the_unit() -> None:
    model = changed(operation__gravity="[0, -9.81, 0] m/s^2")
    unit = rexs_of(epicyclic.load(model)).file.components[0]
    values = [unit.attributes[f"direction_vector_gravity_{axis}"].value for axis in "uvw"]
    assert values == pytest.approx([0, 1, 0])  # v is -y
    assert unit.attributes["gravitational_acceleration"].value == pytest.approx(9.81)


def test_the_command(tmp_path: Path) -> None:
    target = tmp_path / "ren.rexsj"
    result = CliRunner().invoke(app, ["export", "ren2021", "-o", str(target)])
    assert result.exit_code == 0, result.output
    assert "stages.main.ring.split: halves without a neck: one rigid shaft in the file" in result.output
    again = CliRunner().invoke(app, ["export", "ren2021", "-o", str(target), "--json"])
    listed = json.loads(again.stdout)
    assert listed["version"] == "1.7"
    assert {"path": "doi", "text": "a text of the model file"} in listed["dropped"]
    assert [path.name for path in tmp_path.iterdir()] == ["ren.rexsj"]


def test_other_names_and_models_are_refused(tmp_path: Path) -> None:
    for words in (["wind-five", "-o", str(tmp_path / "a.toml")], ["no-such", "-o", str(tmp_path / "a.rexs")]):
        result = CliRunner().invoke(app, ["export", *words])
        assert result.exit_code == 2, result.output
    assert list(tmp_path.iterdir()) == []
