"""REXS files written and read again: every encoding equal, with all digits, the same bytes each time."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import pytest

from epicyclic.errors import ModelError
from epicyclic.rexs import encodings
from epicyclic.rexs.encodings import encoding_of, read_rexs_file, rexs_bytes
from epicyclic.rexs.file import Attribute, Component, LoadCase, Relation, RexsFile

ENCODINGS = ("xml", "json", "zip")
VALUES = {
    "support_vector": Attribute("support_vector", (0.1, -1 / 3, 1e-300), "mm"),
    "is_engaged": Attribute("is_engaged", (True, False), "none"),
    "number_of_teeth": Attribute("number_of_teeth", 17, "none"),
    "axial_stiffness": Attribute("axial_stiffness", 9.999999999999999e22, "N / m"),
    "name": Attribute("name", "1.6580", "none"),
    "a_text": Attribute("a_text", "a <b> & \"c\" 'd' \u00b0 =cmd()", "none"),
    "helix_angle": Attribute("helix_angle", -0.0, "\u00b0"),
    "empty": Attribute("empty", None, "none"),
    "no_entries": Attribute("no_entries", (), "mm"),
    "matrix": Attribute("matrix", ((1.0, 2.5), (3.0, 4.0)), "mm"),
    "rows": Attribute("rows", ((1, 2), (3,)), "none"),
    "defines_speed": Attribute("defines_speed", True, "none"),
    "axial_force_absorption": Attribute("axial_force_absorption", "no_direction", "none"),
    "reference_component_for_position": Attribute("reference_component_for_position", 1, "none"),
}
FILE = RexsFile(
    version="1.7",
    application="test & more",
    application_version="1",
    date="2024-01-01T00:00:00+00:00",
    components=(Component(1, "shaft", "Shaft <1>", VALUES), Component(7, "shaft")),
    relations=(Relation(1, "assembly", None, (("assembly", 1), ("part", 7))), Relation(2, "x", 3, (("a", 7),))),
    load_cases=(LoadCase(4, (Component(1, "shaft", "", {"a": Attribute("a", 1.5, "N m")}),)),),
    accumulations=(Component(1, "shaft", "", {"b": Attribute("b", 2.5, "none")}),),
)


def plain(file: RexsFile) -> RexsFile:
    return replace(file, encoding="xml", notes=())


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_what_is_written_is_read(encoding: str) -> None:
    read = read_rexs_file(rexs_bytes(FILE, encoding))
    assert plain(read) == plain(FILE)
    assert read.encoding == ("json" if encoding == "json" else "xml")
    assert rexs_bytes(read, encoding) == rexs_bytes(FILE, encoding)


@pytest.mark.parametrize("end", ["1.1.rexs", "1.1.rexsz"])
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_the_real_file_is_the_same_in_every_encoding(end: str, encoding: str, real: Callable[[str], Path]) -> None:
    file = read_rexs_file(real(end))
    assert (len(file.components), len(file.relations)) == (97, 140)
    assert plain(read_rexs_file(rexs_bytes(file, encoding))) == plain(file)


def test_a_zip_has_one_file_and_no_clock() -> None:
    with zipfile.ZipFile(BytesIO(rexs_bytes(FILE, "zip", name="unit.rexs"))) as archive:
        (member,) = archive.infolist()
        assert (member.filename, member.date_time[0]) == ("unit.rexs", 1980)
        assert archive.read(member) == rexs_bytes(FILE, "xml")


def test_types_in_json() -> None:
    text = rexs_bytes(FILE, "json").decode()
    for key in ('"enum": "no_direction"', '"reference_component": 1', '"integer": 17', '"floating_point_matrix"',
                '"array_of_integer_arrays"', '"boolean_array"', '"hint": "shaft"'):  # fmt: skip
        assert key in text, key


@pytest.mark.parametrize("encoding", ["xml", "json"])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), (1.0, float("inf")), ((1.0,), (float("nan"),))])
def test_numbers_that_are_not_finite_are_refused(encoding: str, value: object) -> None:
    bad = Component(3, "shaft", "", {"mass": Attribute("mass", value, "kg")})  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="not a finite number") as error:
        rexs_bytes(replace(FILE, components=(*FILE.components, bad)), encoding)
    assert error.value.path == "component 3, mass"


def test_files_that_no_reader_takes_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    lost = replace(FILE, relations=(Relation(5, "assembly", None, (("part", 99),)),))
    with pytest.raises(ModelError, match="no such component"):
        rexs_bytes(lost, "xml")
    with pytest.raises(ModelError, match="two components"):
        rexs_bytes(replace(FILE, components=(*FILE.components, Component(7, "shaft"))), "json")
    monkeypatch.setattr(encodings, "MAX_MARKS", 1000)
    many = tuple(Component(i, "shaft") for i in range(10, 1010))
    with pytest.raises(ModelError, match="and 1000 elements"):
        rexs_bytes(replace(FILE, components=(*FILE.components, *many)), "xml")


@pytest.mark.parametrize(
    ("name", "encoding"),
    [("a.rexs", "xml"), ("a.REXSJ", "json"), ("b.rexs.zip", "zip"), ("b.rexs.json", "json"), ("b.rexsz", "zip")],
)
def test_names(name: str, encoding: str) -> None:
    assert encoding_of(name) == encoding


@pytest.mark.parametrize("name", ["a.toml", "rexs", ".rexs", "a.rexs.toml"])
def test_other_names_are_refused(name: str) -> None:
    with pytest.raises(ModelError, match="not the name of a REXS file"):
        encoding_of(name)
