"""The JSON Schema: well formed, takes the good files as they are written, refuses wrong ones."""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from epicyclic.document.document import read
from epicyclic.document.writer import json_schema, json_schema_text

FILES = Path(__file__).parents[2] / "files"
GOOD = sorted((FILES / "good").glob("*.toml"))
SCHEMA = json_schema()
TYPES: dict[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "number": (int, float),
    "integer": (int,),
    "boolean": (bool,),
}
REFUSED = set(
    """
no-format older-format newer-format format-text format-true format-zero no-title title-number title-date
unknown-table no-stages stages-number nan deep stage-name member-name unknown-key unknown-stage-key
unknown-member negative-teeth half-teeth teeth-true teeth-text teeth-huge zero-planets unknown-kind
hand split-text module-true module-table support-number unknown-direction friction-law
bolts-no-angle bolts-no-radius bolts-none bolts-half bolts-unknown bolts-number bolts-lists
body-frame-number slices-none slices-half slices-text slices-many slices-of-side coupling-number
held-text deviation-unknown profile-order error-turns-with error-sense
no-unit wrong-unit no-number comma endless-power degrees-bare hertz per-second torque-in-N inertia-unit
bolts-torsion mesh-word module-inf module-list module-zero load-zero
tolerance-text tolerance-unknown tolerance-phase tolerance-price
both-vectors shorthand-and-long torque-and-power two-ways
""".split()
)  # by name in tests/files/corpus.py
KNOWN = {
    "$ref", "anyOf", "type", "const", "enum", "properties", "additionalProperties", "propertyNames", "pattern",
    "required", "items", "minItems", "minimum", "maximum", "description", "title", "$schema", "$defs",
    "maxItems", "prefixItems", "examples",
}  # fmt: skip


def load_corpus() -> ModuleType:
    """The module of broken files; test folders are no packages."""
    spec = spec_from_file_location("broken_files_of_the_schema", FILES / "corpus.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def table_of(text: str) -> dict[str, Any]:
    """The tables of a TOML text; of one that is none the file that every broken one is made from."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError):
        return tomllib.loads(load_corpus().BASE)


def fits(value: Any, schema: Any) -> bool:
    """Say whether a value fits a schema: the part of draft 2020-12 that the schema uses."""
    if isinstance(schema, bool):
        return schema
    assert set(schema) <= KNOWN, set(schema) - KNOWN
    if "$ref" in schema and not fits(value, SCHEMA["$defs"][schema["$ref"].removeprefix("#/$defs/")]):
        return False
    if "anyOf" in schema and not any(fits(value, s) for s in schema["anyOf"]):
        return False
    types = schema.get("type", list(TYPES))
    names = [types] if isinstance(types, str) else types
    if not any(isinstance(value, TYPES[t]) and (isinstance(value, bool) == (t == "boolean")) for t in names):
        return False
    if ("const" in schema and value != schema["const"]) or ("enum" in schema and value not in schema["enum"]):
        return False
    if isinstance(value, dict):
        return fits_table(value, schema)
    if isinstance(value, list):
        return len(value) >= schema.get("minItems", 0) and all(fits(v, schema.get("items", True)) for v in value)
    if isinstance(value, str):
        return re.search(schema.get("pattern", ""), value) is not None
    return bool(schema.get("minimum", value) <= value <= schema.get("maximum", value))


def fits_table(value: dict[str, Any], schema: Any) -> bool:
    properties = schema.get("properties", {})
    other = schema.get("additionalProperties", True)
    return (
        set(schema.get("required", ())) <= set(value)
        and all(fits(v, properties.get(k, other)) for k, v in value.items())
        and all(fits(k, schema.get("propertyNames", True)) for k in value)
    )


def subschemas(schema: Any) -> Iterator[dict[str, Any]]:
    """The schema and every schema in it."""
    if not isinstance(schema, dict):
        return
    yield schema
    for name in ("properties", "$defs"):
        for inner in schema.get(name, {}).values():
            yield from subschemas(inner)
    for name in ("additionalProperties", "propertyNames", "items"):
        yield from subschemas(schema.get(name))
    for name in ("anyOf", "prefixItems"):
        for inner in schema.get(name, ()):
            yield from subschemas(inner)


def test_it_is_a_json_schema() -> None:
    assert json.loads(json_schema_text()) == SCHEMA
    assert SCHEMA["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    for schema in subschemas(SCHEMA):
        assert set(schema) <= KNOWN
        if "$ref" in schema:
            assert schema["$ref"].removeprefix("#/$defs/") in SCHEMA["$defs"]
        types = schema.get("type", [])
        assert {types} if isinstance(types, str) else set(types) <= set(TYPES)
        re.compile(schema.get("pattern", ""))
        assert isinstance(schema.get("description", ""), str)
        assert set(schema.get("required", ())) <= {*schema.get("properties", {})} or "additionalProperties" in schema


def test_every_table_is_reached() -> None:
    used = {schema["$ref"].removeprefix("#/$defs/") for schema in subschemas(SCHEMA) if "$ref" in schema}
    assert used == set(SCHEMA["$defs"])
    assert not [name for name in SCHEMA["$defs"] if name.endswith("Table")]  # a word of the code


def test_broken_files_do_not_fit() -> None:
    """Of the files that reading refuses; what is wrong with the others is a unit, a name or a rule between keys."""
    assert {case.name for case in load_corpus().CASES if not fits(table_of(case.text), SCHEMA)} == REFUSED


@pytest.mark.parametrize("path", GOOD, ids=lambda p: p.stem)
def test_good_files_fit_as_written_and_as_read(path: Path) -> None:
    assert fits(tomllib.loads(path.read_text()), SCHEMA)
    assert fits(read(path).data, SCHEMA)


@pytest.mark.parametrize(
    "change",
    [
        {"format": 1},
        {"title": 3},
        {"operatoin": {}},
        {"damping": {"modl": 0.1}},
        {"damping": 0.1},
        {"stages": {"main": {"sun": {"tooth": 3}}}},
        {"stages": {"main": {"sun": {"teeth": "3"}}}},
        {"stages": {"main": {"sun": {"teeth": 2}}}},
        {"stages": {"main": {"other": {"teeth": 30}}}},
        {"stages": {"main": {"modul": "3 mm"}}},
        {"stages": {"main": {"module": True}}},
        {"stages": {"main": {"module": [1, 2]}}},
        {"stages": {"ma.in": {}}},
        {"stages": {"main": {"sun": {"hand": "up"}}}},
        {"stages": {"main": {"meshes": {"sun": {}}}}},
        {"stages": {"main": {"meshes": {"sun-planet": {"variation": "some"}}}}},
        {"couplings": {"a": {"rz": 1}}},
        {"bodies": {"a": {"teeth": 3}}},
        {"operation": {"held": "ring"}},
        {"operation": {"speed": True}},
        {"operation": {"ripple": {"sun": [{"ordre": 2}]}}},
        {"operation": {"ripple": {"sun": 3}}},
        {"loads": {"a": {"on": "sun", "force": 3}}},
        {"deviations": {"sun": 3}},
        {"deviations": {"sun": {"run_out": {"amp": 3}}}},
    ],
)
def test_wrong_files_do_not_fit(change: dict[str, Any]) -> None:
    base = {"format": 2, "title": "x", "stages": {"main": {"sun": {"teeth": 30}}}}
    assert fits(base, SCHEMA)
    assert not fits({**base, **change}, SCHEMA)


def test_every_key_says_what_it_is() -> None:
    for name, table in SCHEMA["$defs"].items():
        for key, value in table.get("properties", {}).items():
            text = value.get("description", "") + json.dumps(SCHEMA["$defs"].get(value.get("$ref", "")[8:], {}))
            assert len(text) > 2, f"{name}.{key}"
    gear = SCHEMA["$defs"]["Member"]["properties"]
    assert gear["mass"]["description"].endswith(": mass [kg], 0 or more")
    assert gear["inertia"]["description"].endswith(": moment of inertia [kg m^2] or mass [kg], 0 or more")
    assert "stiffness per face width [N/m^2]" in SCHEMA["$defs"]["Mesh"]["properties"]["stiffness"]["description"]


def undescribed(node: Any, path: str = "") -> list[str]:
    """Keys without a description of a word or more beside its unit, and definitions without any.

    A key that refers to a table may leave the description to it; the key's own says what the table is for.
    """
    found: list[str] = []
    if isinstance(node, list):
        return [name for i, entry in enumerate(node) for name in undescribed(entry, f"{path}/{i}")]
    if not isinstance(node, dict):
        return found
    for group in ("properties", "$defs"):
        for name, entry in node.get(group, {}).items():
            words = re.sub(r":.*\[.*\].*$", "", entry.get("description", "")).split(";")[0]
            if len(words) < 4 or words.startswith("default"):
                found.append(f"{path}/{group}/{name}")
    return found + [name for key, value in node.items() for name in undescribed(value, f"{path}/{key}")]


def test_every_node_has_a_description() -> None:
    assert undescribed(SCHEMA) == []


def test_a_node_without_description_is_seen() -> None:
    assert undescribed({"properties": {"x": {"type": "number"}, "y": {"description": "default 3"}}}) == [
        "/properties/x",
        "/properties/y",
    ]
    assert undescribed({"properties": {"x": {"description": "length [m]"}}}) == []


def test_descriptions_name_units_and_defaults() -> None:
    """Of every quantity with a unit its unit, of every key with a default that default."""
    defs = SCHEMA["$defs"]
    assert defs["ProfileError"]["properties"]["order"]["description"].endswith("; default 1")
    assert "default linear" in defs["Relief"]["properties"]["shape"]["description"]
    assert defs["Stage"]["properties"]["face_width"]["description"] == ("face width of one helix: length [m], above 0")
    for name, table in defs.items():
        for key, entry in table.get("properties", {}).items():
            refs = {form.get("$ref", "").rpartition("/")[2] for form in (entry, *entry.get("anyOf", []))}
            quantities = [ref for ref in refs if ref in defs and defs[ref].get("type") == "string" and ref != "ratio"]
            if quantities and "Distribution" not in "".join(quantities):
                assert "[" in entry["description"], (name, key)
