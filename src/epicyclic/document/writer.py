"""A model document as a file, numbers with the units a drawing has that load to the same bits; and its JSON Schema.

`commented_text` writes the file as a person would, where `tomli_w` gives every table a heading and every entry of a
list a line: sections in order, short tables in braces, comments, reasons last.  The spelling of the document stays
(`radial`, `run_out = "20 um"`, a member without its stage), because a person goes on with the file.  `model_text`
writes a document whole, shorthands expanded.

The JSON Schema is that of a model file as it is written: unit texts, shorthands, free member names.
"""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from decimal import Decimal
from typing import Any, NamedTuple

from .deviations import (
    EXAMPLES,
    PHASES,
    MemberDeviationsTable,
    MeshDeviationsTable,
    bare_keys,
    distribution_pattern,
    form_texts,
)
from .schema import BY_MEMBER, FORMAT, KIND_BY_NAME, SIDES, VARIATIONS, ModelFile, collect
from .schema_fields import DisplacementForceTable, MeshForceTable, TiltMomentTable, TurnMomentTable, Unit
from .tables import PlainTable, as_written, clean, expand, key_path, key_text, paths, value_text
from .units import COMMON, KINDS, Bounds, list_pattern, number_pattern, read_quantity, shown
from .validation import bare_numbers

_MOST = 10_000  # from there on a number with its unit is no longer short
# units tried in this order: the first in which a number lies between 1 and _MOST; SI where none does
_DRAWN = {
    "m": ("mm", "um"),
    "N/m": ("N/m",),
    "N": ("N", "kN"),
    "Pa": ("GPa", "MPa"),
    "N m": ("N m", "kN m"),
    "W": ("W", "kW", "MW"),
}
_ANGLES = ("deg", "rpm")  # no power of ten: only where a short number in them has the same bits


def model_text(data: Mapping[str, Any]) -> str:
    """Return a model document as TOML, shorthands expanded.

    Numbers without a unit get one; reading the text gives the same bits. Raises ModelError for a document that is none.
    """
    plain = clean(data)
    return commented_text(expand(plain, collect(plain)))


def unit_text(value: Any, kinds: tuple[str, ...]) -> Any:
    """Return a value as a text with its unit; of a list of numbers as one text."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return quantity_text(float(value), kinds[0])
    if isinstance(value, str):  # a list without a unit behind the bracket
        return f"{value} {KINDS[kinds[0]].unit}"
    if all(isinstance(entry, (int, float)) for entry in value):
        values, kind = [float(entry) for entry in value], kinds[0]
        size = max(map(abs, values))
        for unit in _DRAWN.get(KINDS[kind].unit, ()):
            texts = [shown(float(_moved(number, unit))) for number in values]
            same = all(_reads(text, unit, kind, number) for text, number in zip(texts, values, strict=True))
            if same and 1 <= abs(_moved(size, unit)) < _MOST:
                return f"[{', '.join(texts)}] {unit}"
        return f"[{', '.join(map(shown, values))}] {KINDS[kind].unit}"
    return [entry if isinstance(entry, str) and "[" not in entry else unit_text(entry, kinds) for entry in value]


def quantity_text(value: float, kind: str) -> str:
    """Return one number in SI with the unit in which it is short, and from which it is read with the same bits."""
    for unit in _DRAWN.get(KINDS[kind].unit, ()):
        number = _moved(value, unit)
        if 1 <= abs(number) < _MOST and _reads(text := f"{number:f}", unit, kind, value):
            return f"{text} {unit}"
    for unit in _ANGLES:
        if COMMON[unit][1] == KINDS[kind].unit and _reads(text := f"{value / COMMON[unit][0]:.10g}", unit, kind, value):
            return f"{text} {unit}"
    return f"{shown(value)} {KINDS[kind].unit}"


def _moved(value: float, unit: str) -> Decimal:
    """Return the number of a value in SI in a unit that is a power of ten of it: no digit changes."""
    return (Decimal(repr(value)) / Decimal(repr(COMMON[unit][0]))).normalize()


def _reads(text: str, unit: str, kind: str, value: float) -> bool:
    """Return whether a text with a unit is read as a value to the bit."""
    return read_quantity(f"{text} {unit}", (kind,), Bounds(inf=True)) == value


# the file -------------------------------------------------------------------------------------------------------------

_ORDER = (
    *("format", "title", "doi", "notes", "case", "material", "damping", "stages", "bodies", "couplings"),
    *("operation", "loads", "cases", "sensors", "deviations", "limits", "tolerance", "assumed"),
)
_WIDTH = 120  # of a line with its comment; what is longer stands above
_LONGEST_KEY = 40  # keys up to this length have their = in one column
_BRACES = 80  # tables of plain values are written in braces where they fit on so long a line
# a heading for each entry; all else stands on a line of the table it is in
_HEADED = ("stages", "bodies", "couplings", "loads", "cases", "sensors")
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\u2028\u2029]")
_NO_MODEL = ("assumed", "tolerance")  # tables of paths and texts: no number without a unit stands there


class _Line(NamedTuple):
    """One key and its value in TOML, with its comment."""

    key: str
    value: str
    comment: str


def commented_text(document: Mapping[str, Any], *, head: Sequence[str] = (), comments: Mapping[str, str] = {}) -> str:
    """A model document as a TOML text that a person reads and goes on with.

    Reading the text gives the same model as reading the document, to the bit.

    document : nested tables, spelled as in a file; numbers of quantities with a dimension are texts with units, or SI.
    head : lines of comment ahead of all.
    comments : by path as the document spells it (``"stages.main.module"``), of a value or a table; behind it, or above
        where that would be too long.  Those of a path that is not there stand at the nearest table above it.

    Raises
    ------
    ModelError : tables that are no plain ones, references to nothing.
    """
    plain = _with_units(clean(document))
    ordered = {name: plain[name] for name in (*_ORDER, *plain) if name in plain}
    return fragment_text(ordered, head=head, comments=comments)


def fragment_text(tables: PlainTable, *, head: Sequence[str] = (), comments: Mapping[str, str] = {}) -> str:
    """Tables of a model document as a TOML text, to go on with in a model file; numbers are texts with units.

    head, comments : as of `commented_text`.
    """
    notes = _placed(comments, tables)
    top = "\n".join([*_comment_lines("\n".join(head)), "", ""]) if head else ""
    return top + "\n".join(_section(tables, "", "", notes)).strip("\n") + "\n"


def _with_units(plain: PlainTable) -> PlainTable:
    """The document with a unit at every number that wants one, its spelling kept."""
    plain = {"format": FORMAT, **plain}
    names = collect(plain)
    expanded = expand(plain, names)
    bare = {path: error.kinds for path, error in bare_numbers(expanded, names).items()}
    model = {name: table for name, table in plain.items() if name not in _NO_MODEL} if bare else {}
    kinds = {path: bare[full] for path, full in as_written(model, bare, names)}
    return dict(_spelled(plain, "", kinds))


def _spelled(table: PlainTable, path: str, kinds: Mapping[str, tuple[str, ...]]) -> Iterator[tuple[str, Any]]:
    """A table with a unit at the numbers of the paths in `kinds`."""
    for name, value in table.items():
        where = key_path(path, name)
        if isinstance(value, dict) and where not in kinds:
            value = dict(_spelled(value, where, kinds))
        yield name, unit_text(value, kinds[where]) if where in kinds else value


def _placed(comments: Mapping[str, str], document: PlainTable) -> dict[str, str]:
    """Comments by paths that are there."""
    there = set(paths(document))
    placed: dict[str, str] = {}
    for path, text in comments.items():
        here = path
        while here and here not in there:
            here = here.rpartition(".")[0]
        said = str(text) if here == path else f"{path.removeprefix(here).lstrip('.')}: {text}"
        here = here or "title"
        placed[here] = f"{placed[here]}\n{said}" if here in placed else said
    return placed


def _section(table: PlainTable, path: str, heading: str, notes: Mapping[str, str]) -> Iterator[str]:
    """Lines of a table under its heading, then of those in it that have a heading of their own."""
    headed = {name: value for name, value in table.items() if _has_heading(value, path, name, notes)}
    rows = [
        row
        for name, value in table.items()
        if name not in headed
        for row in _rows(key_text(name), value, key_path(path, name), notes)
    ]
    if heading and (rows or not headed or path in notes):  # [stages] alone says nothing
        said, line = _comment_lines(notes.get(path, "")), f"[{heading}]"
        if len(said) == 1 and len(line) + 2 + len(said[0]) <= _WIDTH:
            said, line = [], f"{line}  {said[0]}"
        yield from ("", *said, line)
    yield from _aligned(rows)
    for name, value in headed.items():
        yield from _section(value, key_path(path, name), ".".join(filter(None, (heading, key_text(name)))), notes)


def _has_heading(value: object, path: str, name: str, notes: Mapping[str, str]) -> bool:
    """Whether a table of the section at `path` gets a heading."""
    if not isinstance(value, dict) or not value:
        return False
    if not path:
        return name not in ("damping", "material")
    parts = path.split(".")
    if parts[0] == "stages":
        return len(parts) == 1 or (len(parts) == 2 and name not in ("flank", "material")) or parts[2:] == ["meshes"]
    if parts[0] == "tolerance":
        if name in ("cost", "correlation"):
            return True
        return len(parts) == 2 and not _in_braces(value, key_path(path, name), notes)
    return len(parts) == 1 and parts[0] in _HEADED


def _rows(key: str, value: object, path: str, notes: Mapping[str, str]) -> Iterator[_Line]:
    """Lines of one entry: a value, a table in braces, or one line for each of its values."""
    if isinstance(value, dict) and value and not _in_braces(value, path, notes):
        for name, inner in value.items():
            rows = list(_rows(f"{key}.{key_text(name)}", inner, key_path(path, name), notes))
            if path in notes and name == next(iter(value)):  # what is said of the table stands at its first line
                said = "\n".join(filter(None, (notes[path], rows[0].comment)))
                rows[0] = rows[0]._replace(comment=said)
            yield from rows
    else:
        text = value_text(value)
        if isinstance(value, str) and "\n" in value:  # a text of several lines in lines of its own, quotes escaped
            text = "\n".join(['"""', *(value_text(line)[1:-1] for line in value.split("\n"))]) + '"""'
        yield _Line(key=key, value=text, comment=notes.get(path, ""))


def _in_braces(value: Mapping[str, object], path: str, notes: Mapping[str, str]) -> bool:
    """Whether a table stands in braces: short, of several plain values or of distributions, none with a comment."""
    if any(isinstance(inner, Mapping) or key_path(path, name) in notes for name, inner in value.items()):
        return False
    return (len(value) > 1 or path.startswith("tolerance.")) and len(value_text(value)) <= _BRACES


def _aligned(rows: Sequence[_Line]) -> Iterator[str]:
    """Lines with their = below each other, and comments behind them where there is room."""
    column = max((len(row.key) for row in rows if len(row.key) <= _LONGEST_KEY), default=0)
    texts = [f"{row.key:<{column}} = {row.value}" for row in rows]
    behind = [bool(row.comment) and "\n" not in row.comment for row in rows]
    behind = [is_behind and len(text) <= _WIDTH // 2 for is_behind, text in zip(behind, texts, strict=True)]
    place = max((len(text) for text, is_behind in zip(texts, behind, strict=True) if is_behind), default=0) + 2
    for row, text, is_behind in zip(rows, texts, behind, strict=True):
        said = _comment_lines(row.comment)
        if is_behind and len(said) == 1 and place + len(said[0]) <= _WIDTH:
            yield f"{text:<{place}}{said[0]}"
        else:
            yield from (*said, text)


def _comment_lines(text: str) -> list[str]:
    """Lines of a comment; what no comment may hold is a blank."""
    wrapper = textwrap.TextWrapper(_WIDTH - 2, break_long_words=False, break_on_hyphens=False)
    return [f"# {line}" for whole in text.splitlines() for line in wrapper.wrap(_CONTROL.sub(" ", whole))]


# the schema -----------------------------------------------------------------------------------------------------------

Schema = dict[str, Any]
_NAME = "^[A-Za-z0-9_]{1,60}$"
_LINK_NAME = "^[A-Za-z0-9_-]{1,60}$"
_LINKS = ("Bearing", "Support", "Solid", "Coupling", "LinkDamping")
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
    for table in ("Member", "Body"):
        sections = defs[table]["properties"]["shaft_sections"]
        sections |= _either({"type": "array", "items": sections.pop("additionalProperties")}, {**sections})
        sections.pop("type")
    _operation(defs["Operation"])
    _operation(defs["Case"])
    variation = defs["Variation"]
    del variation["properties"]["form"], variation["required"]
    words: Schema = {"enum": [*VARIATIONS]}
    for name, form in (("Variation", words), ("Elastic", {"const": True}), ("Reduced", {"type": "string"})):
        defs[name] = _either(form, defs[name])
    for name in ("stages", "bodies"):
        root["properties"][name]["propertyNames"] = {"pattern": _NAME}
    for name in ("couplings", "loads", "cases", "sensors"):
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
    support["additionalProperties"] = {"$ref": "#/$defs/Bearing", "description": "one of several bearings"}


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
    for name in BY_MEMBER:
        table = operation["properties"][name]
        value = table["additionalProperties"]
        member = {"anyOf": [*value["anyOf"], {"type": "object", "additionalProperties": value}]}
        table["additionalProperties"] = {
            "anyOf": [*value["anyOf"], {"type": "object", "additionalProperties": member}],
            "x-quantity": value.get("x-quantity", ""),
        }
    ripple = operation["properties"]["ripple"]  # of a body, or of members of a stage; components by name, or a list
    component = ripple["additionalProperties"].pop("additionalProperties")
    parts = {"anyOf": [{"type": "object", "additionalProperties": component}, {"type": "array", "items": component}]}
    ripple["additionalProperties"] = {"anyOf": [*parts["anyOf"], {"type": "object", "additionalProperties": parts}]}
    operation["properties"]["gravity"] = _either({"type": "boolean"}, operation["properties"]["gravity"])


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
