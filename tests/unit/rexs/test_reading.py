"""REXS files read: the same structure from every encoding, versions, arrays, and what is refused."""

from __future__ import annotations

import base64
import io
import json
import struct
import zipfile
from typing import Any

import pytest

from epicyclic.errors import ModelError
from epicyclic.rexs.encodings import MAX_BYTES, MAX_MARKS, read_rexs_file
from epicyclic.rexs.file import Attribute, Component, LoadCase, Relation, is_rexs_name


def xml(inside: str, *, version: str = "1.6", head: str = "") -> bytes:
    return f'{head}<model version="{version}" applicationId="a" date="d">{inside}</model>'.encode()


def component(inside: str, number: int = 1) -> str:
    return f'<components><component id="{number}" type="shaft">{inside}</component></components>'


def zipped(content: bytes, *names: str) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in names or ("model.rexs",):
            archive.writestr(name, content)
    return packed.getvalue()


def value_of(raw: bytes) -> Any:
    return read_rexs_file(raw).components[0].attributes["x"].value


def test_xml_json_and_zip_say_the_same(draft: Any) -> None:
    draft.load_cases = {7: {10: {"rotational_speed": (900.0, "1 / min")}}}
    files = [
        read_rexs_file(raw)
        for raw in (
            draft.xml().encode(),
            draft.json().encode(),
            zipped(draft.xml().encode()),
            zipped(draft.json().encode(), "m.rexsj"),
            b"\xef\xbb\xbf" + draft.xml().encode(),
            b"\xef\xbb\xbf" + draft.json().encode(),
            draft.xml().replace("UTF-8", "UTF-16").encode("utf-16"),
        )
    ]
    assert all(file.components == files[0].components for file in files)
    assert all(file.relations == files[0].relations for file in files)
    assert all(file.load_cases == files[0].load_cases for file in files)
    assert [file.encoding for file in files[:2]] == ["xml", "json"]
    assert len(files[0].components) == len(draft.components)


def test_structure_by_hand() -> None:
    raw = xml(
        '<relations><relation id="5" type="ordered_reference" order="2"><ref id="1" role="origin" hint="shaft"/>'
        '<ref id="1" role="referenced"/></relation></relations>'
        + component('<attribute id="length" unit="mm"> 4.0 </attribute><attribute id="empty"/>')
        + '<load_spectrum id="1"><load_case id="3"><component id="1" type="shaft"><attribute id="rotational_speed" '
        'unit="1 / min">7</attribute></component></load_case><accumulation><component id="1" type="shaft"/>'
        "</accumulation></load_spectrum>"
    )
    file = read_rexs_file(raw)
    one = Component(
        1, "shaft", "", {"length": Attribute("length", 4.0, "mm"), "empty": Attribute("empty", None, "none")}
    )
    assert file.components == (one,)
    assert file.relations == (Relation(5, "ordered_reference", 2, (("origin", 1), ("referenced", 1))),)
    speed = Attribute("rotational_speed", 7, "1 / min")
    assert file.load_cases == (LoadCase(3, (Component(1, "shaft", "", {"rotational_speed": speed}),)),)
    assert file.accumulations == (Component(1, "shaft", "", {}),)
    assert (file.version, file.application, file.date) == ("1.6", "a", "d")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("17", 17),
        ("1.5E3", 1500.0),
        ("-0.0", -0.0),
        ("true", True),
        ("false", False),
        ("c25", "c25"),
        ("  ", None),
        ("NaN", "NaN"),
        ("1e999", "1e999"),  # no float: nothing computes with it by accident
        ("9" * 400, "9" * 400),
        ("<array><c>1</c><c>2.5</c></array>", (1, 2.5)),
        ("<matrix><r><c>1</c><c>2</c></r><r><c>3</c><c>4</c></r></matrix>", ((1, 2), (3, 4))),
        ("<array_of_arrays><array><c>1</c></array><array/></array_of_arrays>", ((1,), ())),
    ],
)
def test_values_of_xml(text: str, value: object) -> None:
    read = value_of(xml(component(f'<attribute id="x">{text}</attribute>')))
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    ("key", "given", "value"),
    [
        ("floating_point", 4.0, 4.0),
        ("integer", 17, 17),
        ("boolean", False, False),
        ("string", "c25", "c25"),
        ("enum", "7", 7),  # as in XML, which has no types
        ("string", "", None),
        ("floating_point", None, None),
        ("floating_point_array", [1.0, 2.0], (1.0, 2.0)),
        ("integer_matrix", [[1, 2], [3, 4]], ((1, 2), (3, 4))),
        ("integer", 10**400, "inf"),
    ],
)
def test_values_of_json(key: str, given: object, value: object) -> None:
    model = {"version": "1.6", "components": [{"id": 1, "type": "shaft", "attributes": [{"id": "x", key: given}]}]}
    assert value_of(json.dumps({"model": model}).encode()) == value


def test_names_stay_texts() -> None:
    read = read_rexs_file(xml(component('<attribute id="material_designation">1.6580</attribute>')))
    assert read.components[0].attributes["material_designation"].value == "1.6580"


@pytest.mark.parametrize(("code", "form"), [("float64", "d"), ("float32", "f"), ("int32", "i")])
def test_coded_arrays_and_matrices(code: str, form: str) -> None:
    numbers = (1, -2, 3, 40, 5, 6)
    text = base64.b64encode(struct.pack(f"<6{form}", *numbers)).decode()
    array = xml(component(f'<attribute id="x"><array code="{code}">\n {text[:9]}\n{text[9:]} </array></attribute>'))
    assert value_of(array) == numbers
    rows = f'<attribute id="x"><matrix code="{code}" rows="2" columns="3">{text}</matrix></attribute>'
    assert value_of(xml(component(rows))) == (numbers[:3], numbers[3:])
    for shape in ({"rows": 2, "columns": 3}, {"rows": 2}, {"columns": 3}):
        given = {"id": "x", "floating_point_matrix_coded": {"code": code, "value": text, **shape}}
        model = {"version": "1.6", "components": [{"id": 1, "type": "shaft", "attributes": [given]}]}
        assert value_of(json.dumps({"model": model}).encode()) == (numbers[:3], numbers[3:])
    four = base64.b64encode(struct.pack(f"<4{form}", *numbers[:4])).decode()
    square = xml(component(f'<attribute id="x"><matrix code="{code}">{four}</matrix></attribute>'))
    assert value_of(square) == (numbers[:2], numbers[2:4])


@pytest.mark.parametrize(
    ("inside", "says"),
    [
        ('<array code="float16">AAAA</array>', "unknown code"),
        ('<array code="float64">AAAA</array>', "whole number of values"),
        ('<array code="float64">!!!!</array>', "no Base64"),
        ('<matrix code="int32" rows="3" columns="5">AAAAAAAAAAA=</matrix>', "do not fill"),
        ('<matrix code="int32" rows="-1" columns="-2">AAAAAAAAAAA=</matrix>', "do not fill"),
        ('<matrix code="int32" rows="x">AAAAAAAAAAA=</matrix>', "do not fill"),
        ('<matrix code="int32">AAAAAAAAAAA=</matrix>', "do not fill"),
    ],
)
def test_bad_coded_arrays_name_component_and_attribute(inside: str, says: str) -> None:
    with pytest.raises(ModelError, match=says) as caught:
        read_rexs_file(xml(component(f'<attribute id="x">{inside}</attribute>', 12)))
    assert "component 12, x" in str(caught.value)


def test_names_of_the_user_are_left_out_and_told() -> None:
    raw = xml(
        '<relations><relation id="1" type="custom_r"><ref id="1" role="a"/></relation><relation id="2" type="side">'
        '<ref id="1" role="inner_part"/><ref id="2" role="assembly"/></relation><relation id="3" type="side">'
        '<ref id="1" role="inner_part"/><ref id="77" role="custom_part"/></relation></relations>'
        '<components><component id="1" type="shaft"><attribute id="custom_a">1</attribute></component>'
        '<component id="2" type="custom_c"/></components>'
    )
    file = read_rexs_file(raw)
    assert [one.id for one in file.components] == [1]
    assert file.components[0].attributes == {}
    assert [one.id for one in file.relations] == [3]  # 2 is of a component that is left out
    assert file.relations[0].refs == (("inner_part", 1),)
    assert file.notes == ("component 1: custom_a", "component 2: custom_c", "relation 1: custom_r")


@pytest.mark.parametrize("version", ["1.1", "1.2", "1.3", "1.4", "1.5", "1.6", "1.7", "2.0.0"])
def test_versions(version: str) -> None:
    assert read_rexs_file(xml("", version=version)).version == version


@pytest.mark.parametrize(
    ("version", "says"), [("1.0", "1.0 has no planetary stage"), ("1.8", "not a version"), ("", "not a version")]
)
def test_other_versions_are_refused(version: str, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        read_rexs_file(xml("", version=version))


ENTITY = '<!DOCTYPE model [<!ENTITY a "b">]>'
LAUGHS = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 10))
BOMB = f'<!DOCTYPE model [<!ENTITY l0 "lol">{LAUGHS}]>'
OUTSIDE = '<!DOCTYPE model [<!ENTITY x SYSTEM "file:///etc/passwd">]>'


@pytest.mark.parametrize("head", [ENTITY, BOMB, OUTSIDE, '<!DOCTYPE model SYSTEM "http://example.org/x.dtd">'])
def test_document_types_and_entities_are_refused(head: str) -> None:
    inside = component('<attribute id="name">&l9;</attribute>') if head is BOMB else ""
    with pytest.raises(ModelError, match="document type, an entity or a reference"):
        read_rexs_file(xml(inside, head=head))


@pytest.mark.parametrize(
    ("raw", "says"),
    [
        (b"", "empty"),
        (b" \n ", "empty"),
        (b"\x7fELF\x00\x00", "not a REXS file"),
        (b"format = 2", "not a REXS file"),
        (b"<html></html>", "not a REXS file"),
        (b"<model", "not XML"),
        (b'<model version="1.6"><components>', "not XML"),
        (b'<?xml version="1.0" encoding="klingon"?><model version="1.6"/>', "not XML"),
        (b"{", "not JSON"),
        (b"[]", "not a REXS file"),
        (b'{"model": 3}', "not a REXS file"),
        (b'{"model": {"version": "1.6", "components": [3]}}', "not a table"),
        (b'{"model": {"version": "1.6", "components": "x"}}', "not a table"),
        (b'{"model": {"version": "1.6"}} \xff', "not UTF-8"),
        (b"<a>" * 40 + b"</a>" * 40, "nested too deeply"),
        (b'{"model": ' + b"[" * 100_000, "nested too deeply"),
        (b'{"a": ' * 100_000, "nested too deeply"),
        (b"<a/>" * (MAX_MARKS + 1), "more than"),
        (b"[1:" * (MAX_MARKS // 2 + 1), "more than"),
        (b"<m" + b' a="1"' * (MAX_MARKS + 1) + b"/>", "more than"),
        (b"<" + b" " * MAX_BYTES, "too large"),
        (b'{"model": {"version": ' + b"1" * 10_000 + b"}}", "not JSON"),
    ],
)
def test_what_is_no_rexs_file_is_refused(raw: bytes, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        read_rexs_file(raw)


@pytest.mark.parametrize(
    ("raw", "says"),
    [
        (xml(component("", 1) + component("", 1)), "two components with one id"),
        (xml('<components><component type="shaft"/></components>'), "not an id"),
        (xml('<components><component id="-1" type="shaft"/></components>'), "not an id"),
        (xml('<components><component id="1"/></components>'), "missing"),
        (xml(component('<attribute id="x">1</attribute><attribute id="x">2</attribute>')), "stands twice"),
        (xml(component("<attribute>1</attribute>")), "without id"),
        (
            xml('<relations><relation id="1" type="side"><ref id="9" role="a"/></relation></relations>'),
            "no such component",
        ),
        (xml('<relations><relation id="1"/></relations>'), "missing"),
    ],
)
def test_parts_without_what_the_standard_demands_are_refused(raw: bytes, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        read_rexs_file(raw)


def test_zips_that_are_refused() -> None:
    small = xml("")
    cases = {
        "a zip of 2 files": zipped(small, "a.rexs", "b.rexs"),
        "leaves its folder": zipped(small, "../../model.rexs"),
        "a name in the zip": zipped(small, "/etc/model.rexs"),
        "unpacked too large": zipped(b" " * (MAX_BYTES + 1)),
        "a zip bomb": zipped(b"<model>" + b" " * (MAX_BYTES // 2)),
        "damaged zip": zipped(small)[:-30],
        "a zip of 0 files": zipped(b"", "folder/"),
        "not a REXS file": zipped(zipped(small)),
        "many files": zipped(small, *map(str, range(60))),
    }
    for says, raw in cases.items():
        with pytest.raises(ModelError, match=says):
            read_rexs_file(raw)


def test_a_zip_that_lies_about_its_size_is_refused() -> None:
    raw = bytearray(zipped(b"<model>" + b" " * (MAX_BYTES // 2)))
    for signature, place in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        start = raw.index(signature)
        raw[start + place : start + place + 4] = struct.pack("<I", 100)
    with pytest.raises(ModelError):
        read_rexs_file(bytes(raw))


def test_errors_name_the_file(tmp_path: Any) -> None:
    file = tmp_path / "unit.rexs"
    file.write_bytes(xml(component("<attribute>1</attribute>")))
    with pytest.raises(ModelError) as caught:
        read_rexs_file(file)
    assert str(caught.value).startswith(str(file))
    with pytest.raises(ModelError, match="cannot be read"):
        read_rexs_file(tmp_path / "none.rexs")
    with pytest.raises(ModelError, match="is a folder"):
        read_rexs_file(tmp_path)


def test_control_characters_do_not_pass() -> None:
    model = {"version": "1.6", "components": [{"id": 1, "type": "shaft", "name": "a\u0000b\u001b[31m\ud800"}]}
    name = read_rexs_file(json.dumps({"model": model}).encode()).components[0].name
    assert name == "a b [31m"


def test_names_of_files() -> None:
    assert all(map(is_rexs_name, ("a.rexs", "a.REXS", "a.rexsj", "a.rexsz", "a.rexs.xml", "a.rexs.json", "a.rexs.zip")))
    assert not any(map(is_rexs_name, ("a.toml", "rexs", "a.json", "rexs.toml")))


@pytest.mark.parametrize("size", ['rows="1000000000"', 'columns="1000000000"', 'rows="1000000000" columns="0"'])
def test_a_matrix_of_many_empty_rows_is_refused(size: str) -> None:
    raw = (
        '<model version="1.6"><relations/><components><component id="1" type="shaft">'
        f'<attribute id="a" unit="mm"><matrix code="int32" {size}></matrix></attribute></component>'
        "</components></model>"
    )
    with pytest.raises(ModelError, match="do not fill"):
        read_rexs_file(raw.encode())
