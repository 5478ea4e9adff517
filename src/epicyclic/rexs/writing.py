"""A REXS file as bytes: XML, JSON or a zip of XML; the same bytes from the same file, read back with equal values."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from ..errors import ModelError
from .file import MAX_BYTES, MAX_MARKS, Attribute, Component, Relation, RexsFile, Value, plain_text

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
    found = next((kind for end, kind in _ENCODINGS.items() if name.endswith(end)), None)
    if found is None or Path(path).name.lower() in _ENCODINGS:
        raise ModelError("not the name of a REXS file", path=str(path), allowed=f"NAME with {', '.join(_ENCODINGS)}")
    return found


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
    _check(file)
    raw = _json(file) if encoding == "json" else _xml(file)
    marks = max(raw.count(b"<"), raw.count(b"=")) if encoding != "json" else sum(map(raw.count, (b"{", b"[", b":")))
    if len(raw) > MAX_BYTES or marks > MAX_MARKS:
        problem = f"{len(raw)} bytes with {marks} elements"
        raise ModelError(problem, path="components", allowed=f"at most {MAX_BYTES} bytes and {MAX_MARKS} elements")
    return _zipped(raw, name) if encoding == "zip" else raw


def _check(file: RexsFile) -> None:
    """Raise ModelError for ids that are not there, or twice."""
    ids = [component.id for component in file.components]
    if len(set(ids)) != len(ids):
        twice = next(i for i in ids if ids.count(i) > 1)
        raise ModelError("two components with one id", path=f"component {twice}", allowed="each id once")
    known = set(ids)
    for relation in file.relations:
        for role, part in relation.refs:
            if part not in known:
                raise ModelError("no such component", path=f"relation {relation.id}, {role}", given=part)


def _zipped(raw: bytes, name: str) -> bytes:
    """A zip of one file, with a fixed date."""
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


def _xml(file: RexsFile) -> bytes:
    """The file in XML."""
    heads = " ".join(f"{key}={quoteattr(text)}" for key, text in _heads(file).items())
    types = {component.id: component.type for component in file.components}
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f"<model {heads}>", "  <relations>"]
    for relation in file.relations:
        lines += _xml_relation(relation, types)
    lines += ["  </relations>", "  <components>"]
    for component in file.components:
        lines += _xml_component(component, "    ")
    lines.append("  </components>")
    if file.load_cases or file.accumulations:
        lines.append('  <load_spectrum id="1">')
        for case in file.load_cases:
            lines.append(f'    <load_case id="{case.id}">')
            for component in case.components:
                lines += _xml_component(component, "      ")
            lines.append("    </load_case>")
        if file.accumulations:
            lines.append("    <accumulation>")
            for component in file.accumulations:
                lines += _xml_component(component, "      ")
            lines.append("    </accumulation>")
        lines.append("  </load_spectrum>")
    return "\n".join([*lines, "</model>", ""]).encode("utf-8")


def _xml_relation(relation: Relation, types: Mapping[int, str]) -> list[str]:
    order = "" if relation.order is None else f' order="{relation.order}"'
    refs = [
        f'      <ref id="{part}" role={quoteattr(plain_text(role))} hint={quoteattr(plain_text(types[part]))}/>'
        for role, part in relation.refs
    ]
    head = f'    <relation id="{relation.id}" type={quoteattr(plain_text(relation.type))}{order}>'
    return [head, *refs, "    </relation>"]


def _xml_component(component: Component, indent: str) -> list[str]:
    kind, name = quoteattr(plain_text(component.type)), quoteattr(plain_text(component.name))
    head = f'{indent}<component id="{component.id}" type={kind} name={name}>'
    lines = [f"{indent}  {_xml_attribute(one, component)}" for one in component.attributes.values()]
    return [head, *lines, f"{indent}</component>"]


def _xml_attribute(attribute: Attribute, component: Component) -> str:
    head = f"<attribute id={quoteattr(plain_text(attribute.id))} unit={quoteattr(plain_text(attribute.unit))}>"
    where = f"component {component.id}, {attribute.id}"
    value = attribute.value
    if not isinstance(value, tuple):
        return f"{head}{_text(value, where)}</attribute>"
    if not any(isinstance(entry, tuple) for entry in value):
        return f"{head}{_cells(value, where, 'array')}</attribute>"
    rows = [entry if isinstance(entry, tuple) else (entry,) for entry in value]
    if len({len(row) for row in rows}) == 1:
        return f"{head}<matrix>{''.join(_cells(row, where, 'r') for row in rows)}</matrix></attribute>"
    inner = "".join(_cells(row, where, "array") for row in rows)
    return f"{head}<array_of_arrays>{inner}</array_of_arrays></attribute>"


def _cells(values: tuple[Value, ...], where: str, tag: str) -> str:
    return f"<{tag}>{''.join(f'<c>{_text(value, where)}</c>' for value in values)}</{tag}>"


def _text(value: Value, where: str) -> str:
    """A scalar as text. Raises ModelError for a number that is not finite, or a table."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return escape(plain_text(value))
    if isinstance(value, tuple) or not math.isfinite(value):
        raise ModelError("not a finite number", path=where, given=str(value))
    return repr(value)


def _json(file: RexsFile) -> bytes:
    """The file in JSON."""
    types = {component.id: component.type for component in file.components}
    model: dict[str, Any] = {**_heads(file)}
    model["relations"] = [_json_relation(relation, types) for relation in file.relations]
    model["components"] = [_json_component(component) for component in file.components]
    if file.load_cases or file.accumulations:
        spectrum: dict[str, Any] = {"id": 1}
        spectrum["load_cases"] = [
            {"id": case.id, "components": [_json_component(c) for c in case.components]} for case in file.load_cases
        ]
        if file.accumulations:
            spectrum["accumulation"] = {"components": [_json_component(c) for c in file.accumulations]}
        model["load_spectrum"] = spectrum
    return (json.dumps({"model": model}, ensure_ascii=False, indent=1, allow_nan=False) + "\n").encode("utf-8")


def _json_relation(relation: Relation, types: Mapping[int, str]) -> dict[str, Any]:
    refs = [{"id": part, "role": plain_text(role), "hint": plain_text(types[part])} for role, part in relation.refs]
    order = {} if relation.order is None else {"order": relation.order}
    return {"id": relation.id, "type": plain_text(relation.type), **order, "refs": refs}


def _json_component(component: Component) -> dict[str, Any]:
    attributes = []
    for one in component.attributes.values():
        entry: dict[str, Any] = {"id": plain_text(one.id), "unit": plain_text(one.unit)}
        if one.value is not None:
            entry |= _json_value(one, f"component {component.id}, {one.id}")
        attributes.append(entry)
    name = {"name": plain_text(component.name)} if component.name else {}
    return {"id": component.id, "type": plain_text(component.type), **name, "attributes": attributes}


def _json_value(attribute: Attribute, where: str) -> dict[str, Any]:
    """A value beside the key that names its type."""
    value = attribute.value
    if not isinstance(value, tuple):
        return {_type(attribute, (value,)): _plain(value, where)}
    if not any(isinstance(entry, tuple) for entry in value):
        return {f"{_type(attribute, value)}_array": [_plain(entry, where) for entry in value]}
    rows = [entry if isinstance(entry, tuple) else (entry,) for entry in value]
    kind = _type(attribute, tuple(cell for row in rows for cell in row))
    key = f"{kind}_matrix" if len({len(row) for row in rows}) == 1 else f"array_of_{kind}_arrays"
    return {key: [[_plain(cell, where) for cell in row] for row in rows]}


def _type(attribute: Attribute, values: tuple[Value, ...]) -> str:
    """Type in JSON of scalars."""
    if attribute.id in _REFERENCES:
        return "reference_component"
    if all(isinstance(value, bool) for value in values) and values:
        return "boolean"
    if any(isinstance(value, str) for value in values):
        return "enum" if attribute.id in _ENUMS else "string"
    return "integer" if values and all(isinstance(value, int) for value in values) else "floating_point"


def _plain(value: Value, where: str) -> Value:
    """A scalar of JSON. Raises ModelError for a number that is not finite."""
    if isinstance(value, str):
        return plain_text(value)
    if isinstance(value, tuple) or (isinstance(value, float) and not math.isfinite(value)):
        raise ModelError("not a finite number", path=where, given=str(value))
    return value
