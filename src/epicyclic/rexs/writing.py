"""A REXS file as bytes: XML, JSON or a zip of XML; the same bytes from the same file, read back with equal values."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from ..errors import ModelError
from .file import MAX_BYTES, MAX_MARKS, Attribute, Component, RexsFile, Value, plain_text

_ENCODINGS = {
    ".rexs.xml": "xml",
    ".rexs.json": "json",
    ".rexs.zip": "zip",
    ".rexs": "xml",
    ".rexsj": "json",
    ".rexsz": "zip",
}
# a zip knows no dates before this one; it is the same in every file, so that the bytes are
_ZIP_DATE = (1980, 1, 1, 0, 0, 0)
# attributes whose type in JSON does not show in their value: the id of a component, a word of a list
_REFERENCES = frozenset({"reference_component_for_position"})
_ENUMS = frozenset({"axial_force_absorption", "shape_of_relief", "datum_face_orientation"})


def encoding_of(path: str | Path) -> str:
    """``xml``, ``json`` or ``zip`` by the end of a file name. Raises ModelError for another end."""
    name = str(path).lower()
    encoding = next((kind for end, kind in _ENCODINGS.items() if name.endswith(end)), None)
    if encoding is None or Path(path).name.lower() in _ENCODINGS:
        raise ModelError("not the name of a REXS file", path=str(path), allowed=f"NAME with {', '.join(_ENCODINGS)}")
    return encoding


def rexs_bytes(file: RexsFile, encoding: str, *, name: str = "model.rexs") -> bytes:
    """A file in an encoding: plain arrays, numbers with all of their digits.

    Parameters
    ----------
    file : components and relations, load cases where there are some.  encoding : ``xml``, ``json`` or ``zip``.
    name : of the XML file within a zip.

    Raises
    ------
    ModelError : a number that is not finite; a relation of a component that is not there; an id that stands twice; more
        than a reader takes.
    """
    types = {component.id: component.type for component in file.components}
    if len(types) != len(file.components):
        ids = [component.id for component in file.components]
        twice = next(i for i in ids if ids.count(i) > 1)
        raise ModelError("two components with one id", path=f"component {twice}", allowed="each id once")
    for relation in file.relations:
        for role, part in relation.refs:
            if part not in types:
                raise ModelError("no such component", path=f"relation {relation.id}, {role}", given=part)
    if encoding == "json":
        raw = _json(file, types)
        marks = sum(map(raw.count, (b"{", b"[", b":")))
    else:
        raw = _xml(file, types)
        marks = max(raw.count(b"<"), raw.count(b"="))
    if len(raw) > MAX_BYTES or marks > MAX_MARKS:
        problem = f"{len(raw)} bytes with {marks} elements"
        raise ModelError(problem, path="components", allowed=f"at most {MAX_BYTES} bytes and {MAX_MARKS} elements")
    if encoding != "zip":
        return raw
    packed = io.BytesIO()
    entry = zipfile.ZipInfo(name, _ZIP_DATE)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr(entry, raw)
    return packed.getvalue()


def _heads(file: RexsFile) -> dict[str, str]:
    """Attributes of the root, in the order of the standard's examples."""
    return {
        "version": plain_text(file.version),
        "applicationId": plain_text(file.application),
        "applicationVersion": plain_text(file.application_version),
        "date": plain_text(file.date),
    }


def _shape(value: Value) -> tuple[str, list[tuple[Value, ...]]]:
    """Shape of a value, ``scalar``, ``array``, ``matrix`` or ``array_of_arrays``, and its rows."""
    if not isinstance(value, tuple):
        return "scalar", [(value,)]
    if not any(isinstance(entry, tuple) for entry in value):
        return "array", [value]
    rows = [entry if isinstance(entry, tuple) else (entry,) for entry in value]
    return "matrix" if len({len(row) for row in rows}) == 1 else "array_of_arrays", rows


def _scalar(value: Value, where: str) -> str | float | None:
    """A scalar, its text plain. Raises ModelError for a number that is not finite, or a table."""
    if isinstance(value, str):
        return plain_text(value)
    if isinstance(value, tuple) or (isinstance(value, float) and not math.isfinite(value)):
        raise ModelError("not a finite number", path=where, given=str(value))
    return value


# XML ------------------------------------------------------------------------------------------------------------------


def _xml(file: RexsFile, types: Mapping[int, str]) -> bytes:
    """The file in XML; types : of the components by id, which relations repeat as hints."""
    heads = " ".join(f"{key}={quoteattr(text)}" for key, text in _heads(file).items())
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f"<model {heads}>", "  <relations>"]
    for relation in file.relations:
        order = "" if relation.order is None else f' order="{relation.order}"'
        lines.append(f'    <relation id="{relation.id}" type={_quoted(relation.type)}{order}>')
        for role, part in relation.refs:
            lines.append(f'      <ref id="{part}" role={_quoted(role)} hint={_quoted(types[part])}/>')
        lines.append("    </relation>")
    lines += ["  </relations>", "  <components>", *_xml_components(file.components, "    "), "  </components>"]
    if file.load_cases or file.accumulations:
        lines.append('  <load_spectrum id="1">')
        for case in file.load_cases:
            lines.append(f'    <load_case id="{case.id}">')
            lines += [*_xml_components(case.components, "      "), "    </load_case>"]
        if file.accumulations:
            lines += ["    <accumulation>", *_xml_components(file.accumulations, "      "), "    </accumulation>"]
        lines.append("  </load_spectrum>")
    return "\n".join([*lines, "</model>", ""]).encode("utf-8")


def _quoted(text: str) -> str:
    return quoteattr(plain_text(text))


def _xml_components(components: Iterable[Component], indent: str) -> Iterator[str]:
    """Lines of components with their attributes."""
    for component in components:
        head = f'<component id="{component.id}" type={_quoted(component.type)} name={_quoted(component.name)}>'
        yield f"{indent}{head}"
        for attribute in component.attributes.values():
            head = f"<attribute id={_quoted(attribute.id)} unit={_quoted(attribute.unit)}>"
            value = _xml_value(attribute.value, f"component {component.id}, {attribute.id}")
            yield f"{indent}  {head}{value}</attribute>"
        yield f"{indent}</component>"


def _xml_value(value: Value, where: str) -> str:
    """A value as text or elements. Raises ModelError for a number that is not finite."""

    def text(cell: Value) -> str:
        plain = _scalar(cell, where)
        if plain is None:
            return ""
        if isinstance(plain, bool):
            return "true" if plain else "false"
        return escape(plain) if isinstance(plain, str) else repr(plain)

    shape, rows = _shape(value)
    if shape == "scalar":
        return text(value)
    tag = "r" if shape == "matrix" else "array"
    arrays = "".join(f"<{tag}>{''.join(f'<c>{text(cell)}</c>' for cell in row)}</{tag}>" for row in rows)
    return arrays if shape == "array" else f"<{shape}>{arrays}</{shape}>"


# JSON -----------------------------------------------------------------------------------------------------------------


def _json(file: RexsFile, types: Mapping[int, str]) -> bytes:
    """The file in JSON; types : of the components by id, which relations repeat as hints."""
    model: dict[str, Any] = {**_heads(file), "relations": []}
    for relation in file.relations:
        refs = [{"id": part, "role": plain_text(role), "hint": plain_text(types[part])} for role, part in relation.refs]
        order = {} if relation.order is None else {"order": relation.order}
        model["relations"].append({"id": relation.id, "type": plain_text(relation.type), **order, "refs": refs})
    model["components"] = _json_components(file.components)
    if file.load_cases or file.accumulations:
        cases = [{"id": case.id, "components": _json_components(case.components)} for case in file.load_cases]
        spectrum: dict[str, Any] = {"id": 1, "load_cases": cases}
        if file.accumulations:
            spectrum["accumulation"] = {"components": _json_components(file.accumulations)}
        model["load_spectrum"] = spectrum
    return (json.dumps({"model": model}, ensure_ascii=False, indent=1, allow_nan=False) + "\n").encode("utf-8")


def _json_components(components: Iterable[Component]) -> list[dict[str, Any]]:
    """Components with their attributes, each value beside the key that names its type."""
    tables = []
    for component in components:
        attributes = []
        for attribute in component.attributes.values():
            entry: dict[str, Any] = {"id": plain_text(attribute.id), "unit": plain_text(attribute.unit)}
            if attribute.value is not None:
                key, value = _json_value(attribute, f"component {component.id}, {attribute.id}")
                entry[key] = value
            attributes.append(entry)
        name = {"name": plain_text(component.name)} if component.name else {}
        tables.append({"id": component.id, "type": plain_text(component.type), **name, "attributes": attributes})
    return tables


def _json_value(attribute: Attribute, where: str) -> tuple[str, object]:
    """The key that names the type of a value, and the value. Raises ModelError for a number that is not finite."""
    shape, rows = _shape(attribute.value)
    cells = [cell for row in rows for cell in row]
    if attribute.id in _REFERENCES:
        kind = "reference_component"
    elif cells and all(isinstance(cell, bool) for cell in cells):
        kind = "boolean"
    elif any(isinstance(cell, str) for cell in cells):
        kind = "enum" if attribute.id in _ENUMS else "string"
    else:
        kind = "integer" if cells and all(isinstance(cell, int) for cell in cells) else "floating_point"
    plain = [[_scalar(cell, where) for cell in row] for row in rows]
    if shape == "scalar":
        return kind, plain[0][0]
    if shape == "array":
        return f"{kind}_array", plain[0]
    return f"{kind}_matrix" if shape == "matrix" else f"array_of_{kind}_arrays", plain
