"""The JSON Schema of a model file as it is written: unit texts, shorthands, free member names."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from typing import Any

from .deviations import MemberDeviationsTable, MeshDeviationsTable, bare_keys
from .distributions import EXAMPLES, PHASES, distribution_pattern, form_texts
from .schema import KIND_BY_NAME, SIDES, VARIATIONS, ModelFile
from .schema_fields import DisplacementForceTable, MeshForceTable, TiltMomentTable, TurnMomentTable, Unit
from .units import KINDS, list_pattern, number_pattern

Schema = dict[str, Any]
_NAME = "^[A-Za-z0-9_]{1,60}$"
_LINK_NAME = "^[A-Za-z0-9_-]{1,60}$"
_LINKS = ("Link", "Support", "Solid", "Coupling", "LinkDamping")
_FORCES = {
    table.__name__.removesuffix("Table")
    for table in (DisplacementForceTable, MeshForceTable, TiltMomentTable, TurnMomentTable)
}


def json_schema() -> Schema:
    """Return the JSON Schema (draft 2020-12) of a model file; units and kinds of quantity stand in `description`."""
    raw = ModelFile.model_json_schema(mode="validation")
    raw = json.loads(re.sub(r'(?<=[/"])([A-Za-z]+)Table(?=")', r"\1", json.dumps(raw)))  # names without `Table`
    forces: Schema = {}
    raw = _referring(raw, _force_table, forces)
    defs: Schema = raw.pop("$defs") | forces
    _as_written(raw, defs)
    texts: Schema = {}
    raw, defs = _referring(raw, _text_with_unit, texts), _referring(defs, _text_with_unit, texts) | texts
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "epicyclic model file",
        **_tidy({k: v for k, v in raw.items() if k != "title"}),
        "$defs": {name: _tidy(table) for name, table in sorted(defs.items())},
    }


def json_schema_text() -> str:
    """Return the schema as text, as `epicyclic schema` writes it."""
    return json.dumps(json_schema(), indent=1, ensure_ascii=False) + "\n"


def _as_written(root: Schema, defs: Schema) -> None:
    """Turn the schema of the normalised document into that of the file."""
    _stage(defs["Stage"], defs)
    _links(defs)
    _deviations(defs)
    _operation(defs["Operation"])
    variation = defs["Variation"]
    del variation["properties"]["form"], variation["required"]
    defs["Variation"] = _either({"enum": list(VARIATIONS)}, variation)
    for name in ("stages", "bodies"):
        root["properties"][name]["propertyNames"] = {"pattern": _NAME}
    for name in ("couplings", "loads"):
        root["properties"][name]["propertyNames"] = {"pattern": _LINK_NAME}
    root["properties"]["assumed"]["additionalProperties"] = {"type": ["string", "object"]}
    _tolerances(root["properties"], defs)
    root["required"] = ["format", "title", "stages"]


def _referring(schema: Any, named: Callable[[Schema], tuple[str, Schema] | None], found: Schema) -> Any:
    """Return a schema that refers to `found`, which is filled, where `named` names a part: it stands in many places."""
    if isinstance(schema, list):
        return [_referring(entry, named, found) for entry in schema]
    if not isinstance(schema, dict):
        return schema
    if (part := named(schema)) is not None:
        name, table = part
        found[name] = table
        return {"$ref": f"#/$defs/{name}"}
    return {key: _referring(value, named, found) for key, value in schema.items()}


def _force_table(schema: Schema) -> tuple[str, Schema] | None:
    """Return name and schema of a table of force."""
    name = schema.get("title")
    return (name, schema) if isinstance(name, str) and name in _FORCES else None


def _text_with_unit(schema: Schema) -> tuple[str, Schema] | None:
    """Return name and schema of the texts with units that `schema_fields.text_form` stands for."""
    name = schema.get("x-texts")
    if not isinstance(name, str):
        return None
    kind = name.removesuffix("_list").removesuffix("_or_inf")
    pattern = list_pattern if name.endswith("_list") else number_pattern
    words = f"{KINDS[kind].name}, {KINDS[kind].spellings}" if KINDS[kind].unit else KINDS[kind].name
    return name, {
        "type": "string",
        "pattern": pattern(kind, inf="_or_inf" in name),
        "description": f"a list of {words}" if name.endswith("_list") else words,
    }


def _stage(stage: Schema, defs: Schema) -> None:
    """Put the members among the keys: known names as they are, any other with its kind."""
    member = defs["Member"]
    defs["NamedMember"] = {**member, "required": ["kind"], "description": "A member of any name, with its kind."}
    member.pop("required", None)
    known = {
        name: {"$ref": "#/$defs/Member", "description": f"the {name}: a {kind} of the stage"}
        for name, kind in KIND_BY_NAME.items()
    }
    stage["properties"] = {k: v for k, v in stage["properties"].items() if k != "members"} | known
    stage["additionalProperties"] = {"$ref": "#/$defs/NamedMember"}
    stage["properties"]["meshes"]["propertyNames"] = {"pattern": "^[A-Za-z0-9_]+-[A-Za-z0-9_]+$"}


def _links(defs: Schema) -> None:
    """Add the shorthands of links, and bearings of any name."""
    for name in _LINKS:
        keys = defs[name]["properties"]
        keys["radial"] = {**keys["x"], "description": _both(keys["x"])}
        keys["tilt"] = {**keys["rx"], "description": _both(keys["rx"])}
        if name != "LinkDamping":
            keys["damping"] = {
                **_either({"anyOf": Unit("damping").forms("damping")}, keys["damping"]),
                "x-quantity": "damping [N s/m]",
            }
    support = defs["Support"]
    support["properties"].pop("bearings")
    support["additionalProperties"] = {"$ref": "#/$defs/Link", "description": "one of several bearings"}


def _both(one: Schema) -> str:
    """Return the description of a key that stands for x and y alike, from that of x."""
    words = str(one["description"]).partition(" (")[0].replace(" x", " x and y alike")
    rest = str(one["description"]).partition("; ")[2]
    return f"{words}; {rest}" if rest and "; " not in words else words


def _deviations(defs: Schema) -> None:
    """Nest deviations by stage, member and mesh; a bare number or text is the amplitude."""
    member, mesh = defs["MemberDeviations"], defs["MeshDeviations"]
    meshes = {
        "description": "deviations of meshes, by `A-B`",
        "type": "object",
        "additionalProperties": {"$ref": "#/$defs/MeshDeviations"},
    }
    for table, kinds, ref in (
        (member, bare_keys(MemberDeviationsTable), "MemberDeviations"),
        (mesh, bare_keys(MeshDeviationsTable), "MeshDeviations"),
    ):
        for name, amplitude in kinds.items():
            long = table["properties"][name]
            reference = next(form["$ref"] for form in long["anyOf"] if "$ref" in form)
            own = defs[reference.rpartition("/")[2]]["properties"][amplitude]
            table["properties"][name] = _either({k: v for k, v in own.items() if k != "description"}, long)
        for side in SIDES:
            words = f"deviations of the {side} side that differ"
            table["properties"][side] = {"$ref": f"#/$defs/{ref}", "description": words}
    mesh["properties"]["errors"]["propertyNames"] = {"pattern": _LINK_NAME}
    # a stage's members, or a member (or body) itself: its keys are no names of members
    defs["DeviationsOf"] = {
        "description": "deviations of a member or body, or of the members of a stage",
        "properties": {**member["properties"], "meshes": meshes},
        "type": "object",
        "additionalProperties": {"$ref": "#/$defs/MemberDeviations"},
    }
    defs["Deviations"] = {
        "description": "Deviations from nominal, by member; the stage may be left out where there is only one.",
        "type": "object",
        "properties": {"meshes": meshes},
        "additionalProperties": {"$ref": "#/$defs/DeviationsOf"},
    }


def _tolerances(root: Schema, defs: Schema) -> None:
    """State what stands at the paths of `[tolerance]`: texts of distributions, own and common, prices, correlations."""
    text = {"$ref": "#/$defs/DistributionText"}
    defs["DistributionText"] = {
        "type": "string",
        "pattern": distribution_pattern(),
        "description": f"a distribution or a grade: {', '.join(form_texts())}",
        "examples": list(EXAMPLES),
    }
    shared = {
        "type": "object",
        "properties": {
            "own": {**text, "description": "each planet, or each mesh of a pair, draws for itself"},
            "common": {**text, "description": "one draw for all planets, added"},
            "phase": {"enum": list(PHASES), "description": "phase of a run-out at assembly; marked: the same in all"},
        },
        "additionalProperties": False,
    }

    def nested(name: str) -> Schema:
        """Keys joined by points, written as tables in each other."""
        return {"type": "object", "additionalProperties": {"$ref": f"#/$defs/{name}"}}

    defs["Toleranced"] = {
        "description": "distribution of the number or vector at this path; own and common draws apart",
        "anyOf": [text, shared, nested("Toleranced")],
    }
    prices = {"type": "object", "propertyNames": text, "additionalProperties": {"type": "number", "minimum": 0}}
    defs["Prices"] = {
        "description": "grades or distributions of the entry at this path, each with its price [any currency]",
        "anyOf": [prices, nested("Prices")],
    }
    numbers = {"type": "object", "additionalProperties": {"type": "number", "minimum": -1, "maximum": 1}}
    tables = {
        "cost": {**nested("Prices"), "description": "by path: grades or distributions, and their prices"},
        "correlation": {
            "type": "object",
            "additionalProperties": numbers,
            "description": "by path: paths, and the correlation of their own draws with its own",
        },
    }
    root["tolerance"] |= {"properties": tables, "additionalProperties": {"$ref": "#/$defs/Toleranced"}}


def _operation(operation: Schema) -> None:
    """Nest speeds, torques and powers by stage, member and side."""
    for name in ("speed", "torque", "power"):
        table = operation["properties"][name]
        value = table["additionalProperties"]
        side = {"type": "object", "additionalProperties": value}
        member = {"anyOf": [*value["anyOf"], side]}
        table["additionalProperties"] = {
            "anyOf": [*value["anyOf"], {"type": "object", "additionalProperties": member}],
            "x-quantity": value.get("x-quantity", ""),
        }
    gravity = operation["properties"]["gravity"]
    operation["properties"]["gravity"] = _either({"type": "boolean"}, gravity)


def _either(first: Schema, second: Schema) -> Schema:
    """Return a schema that takes either, with the description of the second."""
    inner = {k: v for k, v in second.items() if k not in ("description", "default")}
    return {"anyOf": [first, inner], **({"description": second["description"]} if "description" in second else {})}


def _tidy(schema: Any) -> Any:
    """Return a schema with quantities in descriptions, without nulls, generated titles and defaults."""
    if isinstance(schema, list):
        return [_tidy(v) for v in schema]
    if not isinstance(schema, dict):
        return schema
    schema = _flat(schema)
    words = " or ".join(f'"{w}"' for w in schema.get("x-words", ()))
    quantity = " or ".join(part for part in (schema.get("x-quantity", ""), words) if part)
    dropped = ("default", "x-quantity", "x-words")
    result = {
        k: {name: _tidy(v) for name, v in value.items()} if k == "properties" else _tidy(value)
        for k, value in schema.items()
        if k not in dropped and not (k == "title" and isinstance(value, str))
    }
    default = _default(schema)
    if default:
        result["description"] = f"{result.get('description', '')}; {default}".removeprefix("; ")
    if quantity:
        result["description"] = f"{result['description']}: {quantity}" if "description" in result else quantity
    return result


def _default(schema: Schema) -> str:
    """Return the default of a key in words; "" where there is none, or the description states it."""
    value = schema.get("default")
    told = "default" in str(schema.get("description", ""))
    if told or value in (None, "") or isinstance(value, list | dict):
        return ""
    return f"default {value:g}" if isinstance(value, float) else f"default {value}"


def _flat(schema: Schema) -> Schema:
    """Return a schema with nested `anyOf` joined and null left out; a file has no null."""
    forms = schema.get("anyOf")
    if forms is None:
        return schema
    flat: list[Schema] = []
    found: Schema = {}
    for form in (_flat(f) for f in forms):
        found |= {k: v for k, v in form.items() if k.startswith("x-")}
        flat += form["anyOf"] if "anyOf" in form else [form] if form.get("type") != "null" else []
    rest = {k: v for k, v in schema.items() if k != "anyOf"}
    if len(flat) == 1:
        return {**flat[0], **found, **rest}
    return {"anyOf": [f for i, f in enumerate(flat) if f not in flat[:i]], **found, **rest}
