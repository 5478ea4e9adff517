"""The published JSON Schema: up to date, takes the good files as they are written, refuses wrong ones."""

from __future__ import annotations

import json
import re
import tomllib
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from epicyclic.model.json_schema import json_schema, json_schema_text
from epicyclic.model.toml import read

GOOD = sorted((Path(__file__).parents[2] / "files" / "good").glob("*.toml"))
SCHEMA = json_schema()
TYPES: dict[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "number": (int, float),
    "integer": (int,),
    "boolean": (bool,),
}
KNOWN = {
    "$ref", "anyOf", "type", "const", "enum", "properties", "additionalProperties", "propertyNames", "pattern",
    "required", "items", "minItems", "minimum", "maximum", "description", "title", "$schema", "$defs",
    "maxItems", "prefixItems",
}  # fmt: skip


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


def test_published_copy_is_up_to_date() -> None:
    text = resources.files("epicyclic.model").joinpath("model.schema.json").read_text(encoding="utf-8")
    assert text == json_schema_text(), (
        "run python -m epicyclic.model.json_schema > src/epicyclic/model/model.schema.json"
    )
    assert json.loads(text) == SCHEMA


@pytest.mark.parametrize("path", GOOD, ids=lambda p: p.stem)
def test_good_files_fit_as_written_and_as_read(path: Path) -> None:
    assert fits(tomllib.loads(path.read_text()), SCHEMA)
    assert fits(read(path).data, SCHEMA)


@pytest.mark.parametrize(
    "change",
    [
        {"format": 2},
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
        {"loads": {"a": {"on": "sun", "force": 3}}},
        {"deviations": {"sun": 3}},
        {"deviations": {"sun": {"run_out": {"amp": 3}}}},
    ],
)
def test_wrong_files_do_not_fit(change: dict[str, Any]) -> None:
    base = {"format": 1, "title": "x", "stages": {"main": {"sun": {"teeth": 30}}}}
    assert fits(base, SCHEMA)
    assert not fits({**base, **change}, SCHEMA)


def test_every_key_says_what_it_is() -> None:
    for name, table in SCHEMA["$defs"].items():
        for key, value in table.get("properties", {}).items():
            text = value.get("description", "") + json.dumps(SCHEMA["$defs"].get(value.get("$ref", "")[8:], {}))
            assert len(text) > 2, f"{name}.{key}"
    gear = SCHEMA["$defs"]["Member"]["properties"]
    assert gear["mass"]["description"].endswith("mass [kg]")
    assert gear["inertia"]["description"].endswith("moment of inertia [kg m^2] or mass [kg]")
    assert "stiffness per face width [N/m^2]" in SCHEMA["$defs"]["MeshKeys"]["properties"]["stiffness"]["description"]
