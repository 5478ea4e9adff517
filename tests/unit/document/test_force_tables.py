"""Tables of force over deflection in the file: forms, CSV files, errors, overrides, and the way back to a file."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from epicyclic.document.document import read
from epicyclic.document.overrides import parse_setting
from epicyclic.document.schema_fields import DisplacementForceTable, MeshForceTable, TurnMomentTable
from epicyclic.document.writer import model_text
from epicyclic.errors import ModelError

FILES = Path(__file__).parents[2] / "files" / "tables"
MESH = "stages.main.meshes.sun-planet.stiffness"
BASE = """
format = 2
title = "x"
[stages.main]
planets = 3
module = "4 mm"
sun = { teeth = 24 }
planet = { teeth = 30 }
ring = { teeth = 84 }
carrier = {}
"""


def document(**tables: Any) -> dict[str, Any]:
    data = tomllib.loads(BASE)
    data["stages"]["main"] |= tables
    return data


def mesh(table: Any) -> dict[str, Any]:
    return document(meshes={"sun-planet": {"stiffness": table}})


def given(table: Any, overrides: dict[str, object] | None = None) -> MeshForceTable:
    value = read(mesh(table), overrides).model.stages["main"].meshes["sun-planet"].stiffness
    assert isinstance(value, MeshForceTable)
    return value


def test_units_and_phases() -> None:
    one = given({"deflection": "[0, 5, 10] um", "force": ["0 N", "1 kN", "3 kN"], "load": "2 kN"})
    assert one.curves == (((0.0, 5e-6, 1e-5), (0.0, 1e3, 3e3)),)
    assert one.load == 2e3
    assert given({"deflection": [0, 5e-6, 1e-5], "force": [0, 1e3, 3e3]}).curves == one.curves
    common = given({"deflection": "[0, 5, 10] um", "force": ["[0, 1, 3] kN", [0, 0, 2e3]]})
    assert common.curves == (one.curves[0], ((0.0, 5e-6, 1e-5), (0.0, 0.0, 2e3)))
    loads = given({"deflection": ["[0, 5] um", "[1, 7] um"], "force": "[0, 1] kN"})
    assert loads.curves == (((0.0, 5e-6), (0.0, 1e3)), ((1e-6, 7e-6), (0.0, 1e3)))
    own = given({"deflection": ["[0, 5] um", "[1, 7, 9] um"], "force": ["[0, 1] kN", "[0, 1, 2] kN"]})
    assert [len(x) for x, _ in own.curves] == [2, 3]


def test_shorthands_and_quantities_of_links() -> None:
    radial = {"deflection": "[0, 10] um", "force": "[0, 1] kN"}
    turn = {"deflection": "[0, 1] deg", "force": "[0, 1] kN m"}
    stage = document(sun={"teeth": 24, "support": {"radial": radial, "rz": turn, "tilt": turn}})
    support = read(stage).model.stages["main"].members["sun"].support
    assert support is not None
    assert isinstance(support.x, DisplacementForceTable)
    assert support.x == support.y
    assert isinstance(support.rz, TurnMomentTable)
    assert (support.rz.unit, support.rz.curves[0][1]) == ("N m/rad", (0.0, 1e3))
    stage = document(sun={"teeth": 24, "support": {"rz": radial}})
    rz = read(stage).model.stages["main"].members["sun"].support.rz  # type: ignore[union-attr]
    assert isinstance(rz, TurnMomentTable)
    assert rz.unit == "N/m"


# CSV files ------------------------------------------------------------------------------------------------------------


def write(folder: Path, text: str, table: str = '{ file = "t.csv" }') -> Path:
    (folder / "t.csv").write_text(text, encoding="utf-8")
    path = folder / "model.toml"
    path.write_text(f"{BASE}\nmeshes.sun-planet.stiffness = {table}\n", encoding="utf-8")
    return path


def test_a_file_becomes_numbers_of_the_document(tmp_path: Path) -> None:
    text = "# rig 3\nforce [kN]; deflection 0.00 [um]; deflection 0.50 [um]\n\n0; 0; 1.5\n1; 5; 7\n"
    found = read(write(tmp_path, text))
    table = found.model.stages["main"].meshes["sun-planet"].stiffness
    assert isinstance(table, MeshForceTable)
    assert table.curves == (((0.0, 5e-6), (0.0, 1e3)), ((1.5e-6, 7e-6), (0.0, 1e3)))
    # the document holds the numbers, not the name: it is read without the file
    assert "t.csv" not in str(found.data)
    (tmp_path / "t.csv").unlink()
    assert read(found.data).model == found.model


def test_a_file_of_the_layer_above(tmp_path: Path) -> None:
    path = write(tmp_path, "deflection [um], force [N]\n0, 0\n10, 500\n", '"5e8 N/m"')
    for overrides in ({f"{MESH}.file": "t.csv"}, {MESH: {"file": "t.csv", "load": 100}}):
        table = read(path, overrides).model.stages["main"].meshes["sun-planet"].stiffness
        assert isinstance(table, MeshForceTable)
        assert table.curves == (((0.0, 1e-5), (0.0, 500.0)),)
    assert read(path).model.stages["main"].meshes["sun-planet"].stiffness.value == 5e8  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "t.csv: holds no line"),
        ("# nothing\n\n", "holds no line"),
        ("deflection [um], force [N]\n", "too few rows"),
        ("deflection [um], force [N]\n0, 0\n", "too few rows"),
        ("0, 0\n1, 2\n", "t.csv, line 1: no heading of a column"),
        ("deflection, force\n0, 0\n1, 2\n", "no heading of a column"),
        ("deflection [um], moment [N m]\n0, 0\n1, 2\n", "no heading of a column"),
        ("deflection [um]\n0\n1\n", "1 columns of deflections and 0 of forces"),
        ("deflection [um], deflection [um], force [N], force [N], force [N]\n0,0,0,0,0\n", "2 columns of deflections"),
        ("deflection [um], force [N]\n0, 0\n1\n", "line 3: another number of columns"),
        ("deflection [um], force [N]\n0, 0\n1, nan\n", "line 3: force is not a finite number"),
        ("deflection [um], force [N]\n0, 0\n1, \n", "line 3: no value of force"),
        ("deflection [um], force [N]\n0, 0\n1, 1_0\n", "line 3: force is not a finite number"),
        ("deflection [um], force [N]\n0, 0\n# pause\n2, 200\n4, 150\n", "line 5, column 2: force falls"),
        ("force [N], force 2 [N], deflection [um]\n0, 0, 0\n3, 3, 2\n4, 2, 4\n", "line 4, column 2: force falls"),
        ("deflection [um], force [N]\n-1, 0\n1, 10\n", "line 2, column 1: deflection is negative"),
        ("deflection [um], force [N]\n0, 1\n1, 10\n", "line 2, column 2: force is not 0"),
        ("deflection [ ], force [N]\n0, 0\n1, 10\n", "no heading of a column"),
        ("deflection [um], force [N]\n0, 0\n1, " + "1" * 200_000, "t.csv, line 3: no row of a table"),
        ("deflection [N], force [N]\n0, 0\n1, 10\n", "unit not known or of another kind"),
        ("deflection [um], force [um]\n0, 0\n1, 10\n", "unit not known or of another kind"),
    ],
)
def test_a_wrong_file(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ModelError, match=re.escape(said.removeprefix("t.csv: "))) as error:
        read(write(tmp_path, text))
    assert str(error.value).startswith(MESH)
    assert "\n" not in str(error.value)


def test_no_such_file_and_a_file_beside_numbers(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=rf"{MESH}\.file = none\.csv: cannot be read") as error:
        read(write(tmp_path, "", '{ file = "none.csv" }'))
    assert "beside the model file" in str(error.value)
    (tmp_path / "t.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ModelError, match="not a text file"):
        read(tmp_path / "model.toml", {f"{MESH}.file": "t.csv"})
    with pytest.raises(ModelError, match="stands beside force"):
        read(write(tmp_path, "", '{ file = "t.csv", force = "[0, 1] N" }'))


# errors ---------------------------------------------------------------------------------------------------------------

X = "[0, 5, 10] um"


@pytest.mark.parametrize(
    ("table", "path", "said"),
    [
        ({"deflection": X, "force": "[0, 3, 2] kN"}, ".force", "2000 N: point 3: falls; allowed: more than 3000"),
        ({"deflection": X, "force": ["[0, 1, 2] kN", "[0, 2, 1] kN"]}, ".force", "point 3 of phase 2: falls"),
        ({"deflection": X, "force": "[0, 3, 3] kN"}, ".force", "point 3: does not rise"),
        ({"deflection": X, "force": "[1, 2, 3] kN"}, ".force", "point 1: is not 0"),
        ({"deflection": X, "force": "[0, -2, 3] kN"}, ".force", "point 2: falls"),
        ({"deflection": X, "force": "[0, 0, 0] kN"}, ".force", "point 3: is 0 as all before it"),
        ({"deflection": "[-1, 5, 10] um", "force": "[0, 2, 3] kN"}, ".deflection", "point 1: is negative"),
        ({"deflection": "[0, 5, 5] um", "force": "[0, 2, 3] kN"}, ".deflection", "point 3: does not rise"),
        ({"deflection": X, "force": "[0, 2] kN"}, ".force", "another number of points; allowed: 3, one for each"),
        ({"deflection": X, "force": ["[0, 2, 3] kN", "[0, 2] kN"]}, ".force", "another number of points of phase 2"),
        ({"deflection": [X, X], "force": ["[0, 1, 2] N"] * 3}, ".force", "lists of another number of phases"),
        ({"deflection": "[0] um", "force": "[0] N"}, ".deflection", "too few points"),
        ({"deflection": X, "force": "[0, nan, 3] kN"}, ".force", "not a number with a unit"),
        ({"deflection": X, "force": [0, float("inf"), 3]}, ".force", "must be finite"),
        ({"deflection": X, "force": "[0, 1, 2] mm"}, ".force", "unit not known or of another kind of quantity"),
        ({"deflection": "[0, 1, 2] deg", "force": "[0, 1, 2] N"}, ".deflection", "unit not known or of another kind"),
        ({"deflection": X, "force": 3}, ".force", "a list is needed"),
        ({"deflection": X, "force": []}, ".force", "an empty list"),
        ({"deflection": X}, "", "without force; allowed: deflection and force, or file"),
        ({"force": X}, "", ".force"),
        ({}, "", "without deflection"),
        ({"deflection": X, "forse": X}, ".forse", "unknown key; did you mean 'force'"),
        ({"file": 3}, ".file", "not a text"),
        ({"deflection": X, "force": "[0, 1, 2] N", "load": "0 N"}, ".load", "out of range"),
        ({"deflection": [0.0] * 1001, "force": [0.0] * 1001}, ".force", "too many points"),
    ],
)
def test_a_wrong_table_of_a_mesh(table: Any, path: str, said: str) -> None:
    with pytest.raises(ModelError, match=re.escape(said)) as error:
        read(mesh(table))
    assert str(error.value).startswith(f"{MESH}{path}")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("support", "said"),
    [
        ({"x": {"deflection": X, "force": ["[0, 1, 2] N"] * 2}}, "lists of several phases"),
        ({"x": {"deflection": X, "force": "[0, 1, 2] N", "load": 1}}, "unknown key"),
        ({"x": {"deflection": X, "force": "[0, 1, 2] N"}, "clearance": "1 um"}, "clearance beside a table of force"),
        ({"rx": {"deflection": X, "force": "[0, 1, 2] N"}}, "unit not known or of another kind"),
        ({"rz": {"deflection": X, "force": "[0, 1, 2] N m"}}, "another kind of quantity than the deflections"),
    ],
)
def test_a_wrong_table_of_a_link(support: Any, said: str) -> None:
    with pytest.raises(ModelError, match=re.escape(said)) as error:
        read(document(sun={"teeth": 24, "support": support}))
    assert str(error.value).startswith("stages.main.sun.support")


# overrides ------------------------------------------------------------------------------------------------------------


def test_overrides_replace_a_list_the_load_and_the_whole() -> None:
    table = {"deflection": X, "force": "[0, 1, 3] kN"}
    path, value = parse_setting(f"{MESH}.force=[0, 2, 6] kN")
    assert given(table, {path: value}).curves[0][1] == (0.0, 2e3, 6e3)
    assert given(table, {f"{MESH}.load": "1 kN"}).load == 1e3
    whole: dict[str, object] = {MESH: {"deflection": X, "force": "[0, 4, 9] N"}}
    assert given("5e8 N/m", whole).curves[0][1] == (0.0, 4.0, 9.0)
    number = read(mesh(table), {MESH: "5e8 N/m"}).model.stages["main"].meshes["sun-planet"].stiffness
    assert number.value == 5e8  # type: ignore[union-attr]
    with pytest.raises(ModelError, match="point 2: falls"):
        given(table, {f"{MESH}.force": "[0, -1, 3] kN"})


def test_one_number_of_a_table_is_a_parameter() -> None:
    from epicyclic.questions.studies.sensitivity import all_parameters, parameter_at
    from epicyclic.train.resolution import load

    train = load(FILES / "model.toml")
    path = "couplings.output.rz.force"
    third = parameter_at(train, f"{path}[3]")
    assert (third.value, third.unit) == (5.0, "kN m")
    changed = load(FILES / "model.toml", third.at(6.0))
    (link,) = (link for link in changed.links if link.name == "output")
    assert dict(link.curves)[5].force == (0.0, 2e3, 6e3)
    # by themselves the points of a table are not parameters, nor is the stiffness that they make
    names = [one.path for one in all_parameters(train)]
    assert not [name for name in names if ".force" in name or ".deflection" in name]
    assert f"{MESH}.load" in names
    assert MESH not in names


# back to a file -------------------------------------------------------------------------------------------------------


def test_a_resolved_train_is_written_and_read_again(tmp_path: Path) -> None:
    from epicyclic.train.resolution import load, resolved_document

    transverse = {"stages.main.meshes.planet-ring.direction": "transverse", "stages.main.helix_angle": "12 deg"}
    train = load(FILES / "model.toml", transverse)
    path = tmp_path / "resolved.toml"
    path.write_text(model_text(resolved_document(train)), encoding="utf-8")
    again = load(path)
    for one, other in zip(train.meshes, again.meshes, strict=True):
        assert one.table is not None
        assert other.table is not None
        assert one.table.load == pytest.approx(other.table.load, rel=1e-15)
        for name in ("gap", "force", "slope", "error", "variation"):
            np.testing.assert_allclose(getattr(one.table, name), getattr(other.table, name), rtol=1e-12)
    assert [link.curves for link in train.links] == [link.curves for link in again.links]
    assert sum(bool(link.curves) for link in train.links) == 1 + 3 + 1 + 6 + 1 + 1 + 1
    assert again.document["stages"]["main"]["meshes"]["sun-planet"]["stiffness"]["load"] == "4000 N"  # type: ignore[index]


def test_the_schema_knows_the_tables() -> None:
    from epicyclic.document.writer import json_schema

    defs = json_schema()["$defs"]
    refs = [form.get("$ref") for form in defs["Mesh"]["properties"]["stiffness"]["anyOf"]]
    assert "#/$defs/MeshForce" in refs
    assert set(defs["MeshForce"]["properties"]) == {"deflection", "force", "file", "load"}
    for key, name in (("x", "DisplacementForce"), ("radial", "DisplacementForce"), ("rz", "TurnMoment")):
        assert f"#/$defs/{name}" in [form.get("$ref") for form in defs["Support"]["properties"][key]["anyOf"]]
