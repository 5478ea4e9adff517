"""A REXS file in XML, JSON or a zip of one: read into `RexsFile` whatever it holds, safe, bounded, with reasons; and
written, the same bytes from the same file, read back with equal values.

XML and JSON hold the same tables: XML is read into those of JSON, and written from them.  Ids in them are numbers,
attributes stand once each, components of relations exist.  A file has bounds of size, depth and count, so that none
costs long or much memory.
"""

from __future__ import annotations

import io
import json
import math
import re
import struct
import xml.etree.ElementTree as ElementTree
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal
from xml.etree.ElementTree import Element
from xml.sax.saxutils import escape, quoteattr

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from ..errors import ModelError
from ..user_input import read_bytes
from .file import (
    REFERENCES,
    ROW,
    SUFFIXES,
    WORDS,
    Attribute,
    Component,
    LoadCase,
    Relation,
    RexsFile,
    Value,
    decoded,
    plain_text,
    scalar,
    text_value,
)

_HEADS = dict(  # keys of the root: fields of `RexsFile`
    version="version", applicationId="application", applicationVersion="application_version", date="date"
)
_MARKS = ("id", "type", "role", "hint", "order", "name", "unit")  # what stands in a tag
_ID = re.compile(r"[0-9]{1,15}")


_Table = Mapping[str, Any]


def _file(model: object, encoding: Literal["xml", "json"]) -> RexsFile:
    """The file of its tables.

    Raises
    ------
    ModelError : no REXS, or a part without what the standard demands of it.
    """
    if not isinstance(model, Mapping):
        raise ModelError("not a REXS file", path="model", allowed='a JSON file with the table "model"')
    notes: list[str] = []  # what is the user's own and left out
    components: list[Component] = []
    for component in _components(model, notes):
        if not component.type:
            raise ModelError("missing", path=f"component {component.id}, type", allowed="a type of the standard")
        if _is_custom(component.type):
            notes.append(f"component {component.id}: {component.type}")
        components.append(component)
    spectra = _tables(model, "load_spectrum")
    cases = [case for spectrum in spectra for case in _tables(spectrum, "load_cases")]
    load_cases = [LoadCase(_checked_id(c.get("id"), "load case"), tuple(_components(c, notes))) for c in cases]
    whole = [accumulation for spectrum in spectra for accumulation in _tables(spectrum, "accumulation")]
    accumulations = [component for accumulation in whole for component in _components(accumulation, notes)]
    own = {component.id for component in components if _is_custom(component.type)}
    relations = [r for r in _relations(model, notes) if not own.intersection(part for _, part in r.refs)]
    _check_ids(components, relations)
    return RexsFile(
        **{field: plain_text(str(model.get(key, ""))) for key, field in _HEADS.items()},
        components=tuple(component for component in components if component.id not in own),
        relations=tuple(relations),
        load_cases=tuple(load_cases),
        accumulations=tuple(accumulations),
        encoding=encoding,
        notes=tuple(notes),
    )


def _check_ids(components: Iterable[Component], relations: Iterable[Relation]) -> None:
    """Raise ModelError for an id that two components have, or a relation of a component that is not there."""
    ids: set[int] = set()
    for component in components:
        if component.id in ids:
            raise ModelError("two components with one id", path=f"component {component.id}", allowed="each id once")
        ids.add(component.id)
    for relation in relations:
        for role, part in relation.refs:
            if part not in ids:
                where = f"relation {relation.id}, {role}"
                raise ModelError("no such component", path=where, given=part, allowed="an id of a component")


def _components(table: _Table, notes: list[str]) -> Iterator[Component]:
    """Components of a table, one after the other.

    Raises
    ------
    ModelError : an attribute without id, two of the same id, and as of their values.
    """
    for component in _tables(table, "components"):
        number = _checked_id(component.get("id"), "component")
        values: dict[str, Attribute] = {}
        for attribute in _tables(component, "attributes"):
            key = _text(attribute, "id")
            where = f"component {number}, {key}"
            if _is_custom(key) and key not in ROW:
                notes.append(f"component {number}: {key}")
                continue
            value = _value(attribute, where, key)
            if not key:
                raise ModelError("an attribute without id", path=where)
            if key in values:
                raise ModelError("stands twice", path=where, allowed="each attribute once")
            values[key] = Attribute(key, value, _text(attribute, "unit", otherwise="none"))
        yield Component(number, _text(component, "type"), _text(component, "name"), values)


def _relations(model: _Table, notes: list[str]) -> Iterator[Relation]:
    """Relations of the standard. Raises ModelError for one without type, and an order that is no number."""
    for table in _tables(model, "relations"):
        refs = [(_text(ref, "role"), ref.get("id")) for ref in _tables(table, "refs")]
        number, kind, order = _checked_id(table.get("id"), "relation"), _text(table, "type"), table.get("order")
        where = f"relation {number}"
        if _is_custom(kind):
            notes.append(f"{where}: {kind}")
            continue
        if not kind:
            raise ModelError("missing", path=f"{where}, type", allowed="a type of the standard")
        parts = tuple((role, _checked_id(part, where)) for role, part in refs if not _is_custom(role))
        place = None if order is None or order == "" else _checked_id(order, f"{where}, order")
        yield Relation(number, kind, place, parts)


def _is_custom(name: str) -> bool:
    """Whether a name is the user's own, which the standard leaves to him."""
    return name.startswith("custom_")


def _checked_id(value: object, what: str) -> int:
    """An id as a number. Raises ModelError where it is none."""
    if isinstance(value, str) and _ID.fullmatch(value.strip()):
        return int(value)
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 10**15:
        return value
    if isinstance(value, float) and value.is_integer() and 0 <= value < 10**15:
        return int(value)
    raise ModelError("not an id", path=f"{what}, id", given=value, allowed="a whole number")


def _tables(table: Mapping[str, Any], key: str) -> Iterable[Mapping[str, Any]]:
    """The tables of a list, of a single table, or none. Raises ModelError for anything else."""
    value = table.get(key)
    if value is None:
        return ()
    entries = value if isinstance(value, list) else [value]
    for entry in entries:
        if not isinstance(entry, Mapping):
            raise ModelError("not a table", path=key, given=entry, allowed="a list of tables")
    return entries


def _text(table: Mapping[str, Any], key: str, *, otherwise: str = "") -> str:
    """A text of a table; numbers and truth values as text."""
    value = table.get(key)
    return plain_text(str(value)) if isinstance(value, (str, int, float)) else otherwise


def _value(table: _Table, where: str, name: str) -> Value:
    """Value of an attribute: what stands beside its id and unit, in JSON by the key that names its type."""
    if isinstance(element := table.get("value"), Element):
        return _xml_value(element, where, name)
    keys = [key for key in table if key not in ("id", "unit") and not _is_custom(key)]
    if len(keys) > 1:
        raise ModelError("several values", path=where, given=keys, allowed="one")
    if not keys:
        return None
    key, value = keys[0], table[keys[0]]
    if key.endswith("_coded"):
        if not isinstance(value, Mapping):
            raise ModelError("not a table", path=where, given=value, allowed="a table with code and value")
        shape = (value.get("rows"), value.get("columns")) if "matrix" in key else None
        return decoded(value.get("code"), value.get("value"), shape, where)
    try:
        if not isinstance(value, list):
            return scalar(value, name)
        return tuple(
            tuple(scalar(cell, name) for cell in entry) if isinstance(entry, list) else scalar(entry, name)
            for entry in value
        )
    except ModelError as error:  # names the component too
        raise error.at(where) from None


# XML ------------------------------------------------------------------------------------------------------------------


def _xml_model(root: Element) -> _Table:
    """The tables of a tree, values of attributes as their elements. Raises ModelError for another root than a model."""
    if _tag(root) != "model":
        raise ModelError("not a REXS file", path=f"<{_tag(root)[:40]}>", allowed="an XML file with the root <model>")

    def components(part: Element) -> list[_Table]:
        return [
            {**entry.attrib, "attributes": [{**a.attrib, "value": a} for a in _all(entry, "attribute")]}
            for entry in _all(part, "component")
        ]

    def cases(spectrum: Element, tag: str) -> list[_Table]:
        return [{**case.attrib, "components": components(case)} for case in _all(spectrum, tag)]

    return {
        **root.attrib,
        "components": [entry for part in _all(root, "components") for entry in components(part)],
        "relations": [
            {**relation.attrib, "refs": [ref.attrib for ref in _all(relation, "ref")]}
            for part in _all(root, "relations")
            for relation in _all(part, "relation")
        ],
        "load_spectrum": [
            {"load_cases": cases(part, "load_case"), "accumulation": cases(part, "accumulation")}
            for part in _all(root, "load_spectrum")
        ],
    }


def _tag(element: Element) -> str:
    """Name of an element without its name space."""
    return element.tag.rpartition("}")[2]


def _all(element: Element, tag: str) -> Iterable[Element]:
    """The children of one name."""
    return (child for child in element if _tag(child) == tag)


def _xml_value(element: Element, where: str, name: str) -> Value:
    """Value of an attribute: text, array, matrix, array of arrays."""

    def cells(row: Element) -> Value:
        return tuple(text_value(cell.text or "", name) for cell in _all(row, "c"))

    def array(row: Element) -> Value:
        return decoded(row.get("code"), row.text or "", None, where) if row.get("code") else cells(row)

    for child in element:
        match _tag(child):
            case "array":
                return array(child)
            case "matrix":
                if child.get("code"):
                    shape = child.get("rows"), child.get("columns")
                    return decoded(child.get("code"), child.text or "", shape, where)
                return tuple(cells(row) for row in _all(child, "r"))
            case "array_of_arrays":
                return tuple(array(row) for row in _all(child, "array"))
    return text_value(element.text or "", name)


# the file -------------------------------------------------------------------------------------------------------------

# A gear unit of 100 components is 0.1 MB; 16 MB leaves room for long load spectra and is parsed in a few seconds.
MAX_BYTES = 16_000_000
# Tags, attributes of tags, braces and keys: each becomes an object of up to 400 bytes. A file then stays below
# 250 MB and 3 s.
MAX_MARKS = 400_000
# model / load_spectrum / load_case / component / attribute / matrix / r / c is 8 deep.
MAX_DEPTH = 16
# The real files shrink to 1/17; a file of nothing but blanks and repeated tags to about 1/100.
MAX_RATIO = 300
_VERSIONS = ("1.1", "1.2", "1.3", "1.4", "1.5", "1.6", "1.7", "2.0", "2.0.0")
_ALLOWED = "a REXS file in XML (.rexs), JSON (.rexsj) or a zip of one of them (.rexsz)"
_BOM = b"\xef\xbb\xbf"
_WIDE = (b"\xff\xfe", b"\xfe\xff")  # UTF-16
# what reading a zip raises
_DAMAGED = (zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, ValueError, RuntimeError, OverflowError)


def read_rexs_file(source: str | Path | bytes) -> RexsFile:
    """Read a REXS file by its content: XML, JSON, or a zip with one of them.

    Parameters
    ----------
    source : path of a file of at most 16 MB, or its bytes.

    Raises
    ------
    ModelError : no such file, none of these encodings, cut short or damaged, a document type, an entity or a reference
        to another file, more than the limits of `file`, another version than 1.1 to 1.7 and 2.0.0.
    """
    raw = source if isinstance(source, bytes) else read_bytes(source, most=MAX_BYTES, allowed=_ALLOWED)
    name = "REXS file" if isinstance(source, bytes) else str(source)
    try:
        file = _parsed(raw, name, zipped=False)
        if file.version == "1.0":
            problem = "REXS 1.0 has no planetary stage (nor ring gear, planet carrier, side plate, coupling)"
            raise ModelError(problem, path="version", given="1.0", allowed="a planetary gear unit in REXS 1.1 or later")
        if file.version not in _VERSIONS:
            allowed = ", ".join(_VERSIONS)
            raise ModelError("not a version that is read", path="version", given=file.version, allowed=allowed)
    except ModelError as error:
        if error.path.startswith(name):
            raise
        raise error.at(f"{name}, {error.path}" if error.path else name) from None
    return file


def _parsed(raw: bytes, name: str, *, zipped: bool) -> RexsFile:
    """The file of bytes of any encoding. Raises ModelError as of `read_rexs_file`."""
    if len(raw) > MAX_BYTES:
        raise ModelError("too large", path=name, allowed=f"at most {MAX_BYTES} bytes")
    if raw.startswith(b"PK") and not zipped:
        return _parsed(_unzipped(raw, name), name, zipped=True)
    start = raw.removeprefix(_BOM)[:200].lstrip()
    if start.startswith(b"<") or raw.startswith(_WIDE):
        return _file(_xml_model(_tree(raw, name)), "xml")
    if start.startswith((b"{", b"[")):
        tables = _json(raw.removeprefix(_BOM), name)
        return _file(tables.get("model") if isinstance(tables, Mapping) else None, "json")
    raise ModelError("empty" if not raw.strip() else "not a REXS file", path=name, allowed=_ALLOWED)


def _unzipped(raw: bytes, name: str) -> bytes:
    """The one file of a zip, unpacked in memory.

    Raises
    ------
    ModelError : no zip, not exactly one file in it, encrypted, packed by another method than deflate, a name that
        leaves its folder, unpacked larger than the limits of size and ratio.
    """
    allowed = "a zip of one REXS file, packed with deflate"
    # each entry of the directory is an object: more than a few are refused before the directory is read
    if raw.count(b"PK\x01\x02") > 50:
        raise ModelError("a zip of many files", path=name, allowed=allowed)
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            members = [member for member in archive.infolist() if not member.filename.endswith("/")]
            if len(members) != 1:
                raise ModelError(f"a zip of {len(members)} files", path=name, allowed=allowed)
            _check_member(members[0], name, allowed)
            with archive.open(members[0]) as opened:
                content = opened.read(MAX_BYTES + 1)
    except ModelError:
        raise
    except _DAMAGED as error:
        raise ModelError(f"a damaged zip ({error})", path=name, allowed=allowed) from None
    if len(content) > MAX_BYTES:
        raise ModelError("unpacked too large", path=name, allowed=f"at most {MAX_BYTES} bytes")
    return content


def _check_member(member: zipfile.ZipInfo, name: str, allowed: str) -> None:
    """Raise ModelError for a member of a zip that is not unpacked."""
    parts = member.filename.replace("\\", "/").split("/")
    problem = ""
    if ".." in parts or parts[0] == "" or ":" in parts[0]:
        problem = "a name in the zip that leaves its folder"
    elif member.flag_bits & 0x1:
        problem = "an encrypted zip"
    elif member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        problem = "a zip packed by another method"
    elif member.file_size > MAX_BYTES:
        problem = f"unpacked too large ({member.file_size} bytes)"
    elif member.file_size > MAX_RATIO * max(member.compress_size, 1):
        problem = f"unpacked more than {MAX_RATIO} times as large: a zip bomb"
    if problem:
        raise ModelError(problem, path=name, given=member.filename, allowed=allowed)


class _BoundedTree(ElementTree.TreeBuilder):
    """Builder of an XML tree that stops where it is deeper than any REXS file."""

    def __init__(self) -> None:
        super().__init__()
        self._depth = 0

    def start(self, tag: str, attrs: dict[str, str], /) -> ElementTree.Element:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise ModelError("nested too deeply", allowed=f"at most {MAX_DEPTH} levels")
        return super().start(tag, attrs)

    def end(self, tag: str, /) -> ElementTree.Element:
        self._depth -= 1
        return super().end(tag)


def _tree(raw: bytes, name: str) -> ElementTree.Element:
    """The XML tree of bytes. Raises ModelError for what is no XML, too much, or refers to anything outside."""
    _check_marks(raw.count(b"<"), name)
    _check_marks(raw.count(b"="), name)
    parser = DefusedXMLParser(target=_BoundedTree(), forbid_dtd=True, forbid_entities=True, forbid_external=True)
    try:
        parser.feed(raw)
        root: ElementTree.Element = parser.close()
    except ModelError as error:
        raise error.at(name) from None
    except DefusedXmlException:
        problem = "a document type, an entity or a reference to another file in the XML"
        raise ModelError(problem, path=name, allowed="plain XML") from None
    except (ElementTree.ParseError, ValueError, LookupError, AssertionError) as error:
        raise ModelError(f"not XML: {error}", path=name, allowed=_ALLOWED) from None
    return root


def _json(raw: bytes, name: str) -> object:
    """The tables of JSON bytes. Raises ModelError for what is no JSON or too much."""
    _check_marks(sum(raw.count(mark) for mark in (b"{", b"[", b":")), name)
    try:
        return json.loads(raw.decode("utf-8"), parse_constant=str)
    except RecursionError:
        raise ModelError("nested too deeply", path=name, allowed=f"at most {MAX_DEPTH} levels") from None
    except UnicodeDecodeError as error:
        raise ModelError(f"not UTF-8 (byte {error.start})", path=name, allowed=_ALLOWED) from None
    except ValueError as error:
        raise ModelError(f"not JSON: {error}", path=name, allowed=_ALLOWED) from None


def _check_marks(count: int, name: str) -> None:
    """Raise ModelError for more elements than a REXS file may have."""
    if count > MAX_MARKS:
        raise ModelError(f"more than {MAX_MARKS} elements", path=name, allowed="a file of one gear unit")


# writing --------------------------------------------------------------------------------------------------------------

_ENCODINGS = dict(zip(SUFFIXES, ("xml", "json", "zip") * 2, strict=True))
# a zip knows no dates before this one; it is the same in every file, so that the bytes are
_ZIP_DATE = (1980, 1, 1, 0, 0, 0)


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
    _check_ids(file.components, file.relations)
    model = _model_tables(file)
    if encoding == "json":
        raw = (json.dumps({"model": model}, ensure_ascii=False, indent=1, allow_nan=False) + "\n").encode("utf-8")
        marks = sum(map(raw.count, (b"{", b"[", b":")))
    else:
        raw = _xml_bytes(model)
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


def _model_tables(file: RexsFile) -> dict[str, Any]:
    """The tables of a file; relations repeat the types of their components as hints."""
    types = {component.id: component.type for component in file.components}
    model: dict[str, Any] = {key: plain_text(getattr(file, field)) for key, field in _HEADS.items()}
    model["relations"] = []
    for relation in file.relations:
        refs = [{"id": part, "role": plain_text(role), "hint": plain_text(types[part])} for role, part in relation.refs]
        order = {} if relation.order is None else {"order": relation.order}
        model["relations"].append({"id": relation.id, "type": plain_text(relation.type), **order, "refs": refs})
    model["components"] = _component_tables(file.components)
    if file.load_cases or file.accumulations:
        cases = [{"id": case.id, "components": _component_tables(case.components)} for case in file.load_cases]
        model["load_spectrum"] = {"id": 1, "load_cases": cases}
        if file.accumulations:
            model["load_spectrum"]["accumulation"] = {"components": _component_tables(file.accumulations)}
    return model


def _component_tables(components: Iterable[Component]) -> list[dict[str, Any]]:
    """Components with their attributes, each value beside the key that names its type."""
    tables = []
    for component in components:
        attributes = [
            {"id": plain_text(a.id), "unit": plain_text(a.unit), **_typed(a, f"component {component.id}, {a.id}")}
            for a in component.attributes.values()
        ]
        name = {"name": plain_text(component.name)} if component.name else {}
        tables.append({"id": component.id, "type": plain_text(component.type), **name, "attributes": attributes})
    return tables


def _typed(attribute: Attribute, where: str) -> dict[str, object]:
    """A value by the key that names its type, empty of none. Raises ModelError for a number that is not finite."""
    value, form = attribute.value, "{}"
    if value is None:
        return {}
    rows: list[tuple[Value, ...]] = [value if isinstance(value, tuple) else (value,)]
    if isinstance(value, tuple):
        form = "{}_array"
        if any(isinstance(entry, tuple) for entry in value):
            rows = [entry if isinstance(entry, tuple) else (entry,) for entry in value]
            form = "{}_matrix" if len({len(row) for row in rows}) == 1 else "array_of_{}_arrays"
    cells = [cell for row in rows for cell in row]
    if attribute.id in REFERENCES:
        kind = "reference_component"
    elif cells and all(isinstance(cell, bool) for cell in cells):
        kind = "boolean"
    elif any(isinstance(cell, str) for cell in cells):
        kind = "enum" if attribute.id in WORDS else "string"
    else:
        kind = "integer" if cells and all(isinstance(cell, int) for cell in cells) else "floating_point"
    plain = [[_scalar(cell, where) for cell in row] for row in rows]
    return {form.format(kind): plain[0][0] if form == "{}" else plain[0] if form == "{}_array" else plain}


def _scalar(value: Value, where: str) -> str | float | None:
    """A scalar, its text plain. Raises ModelError for a number that is not finite, or a table."""
    if isinstance(value, str):
        return plain_text(value)
    if isinstance(value, tuple) or (isinstance(value, float) and not math.isfinite(value)):
        raise ModelError("not a finite number", path=where, given=str(value))
    return value


def _xml_bytes(model: _Table) -> bytes:
    """The tables of a file in XML."""
    heads = "".join(f" {key}={quoteattr(model[key])}" for key in _HEADS)
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f"<model{heads}>"]
    for part in ("relations", "components"):
        lines += [f"  <{part}>", *_xml_lines(part, model[part], "    "), f"  </{part}>"]
    if "load_spectrum" in model:
        lines += _xml_lines("load_spectrum", [model["load_spectrum"]], "  ")
    return "\n".join([*lines, "</model>", ""]).encode("utf-8")


_LISTS = ("refs", "attributes", "components", "load_cases", "accumulation")


def _xml_lines(part: str, tables: Iterable[_Table], indent: str) -> Iterator[str]:
    """Lines of tables with what is in them; part : key of the list that they are."""
    tag = part.removesuffix("s")
    for table in tables:
        heads = {"name": "", **table} if tag == "component" else table
        head = "".join(f" {key}={quoteattr(str(heads[key]))}" for key in _MARKS if key in heads)
        if tag == "ref":
            yield f"{indent}<ref{head}/>"
        elif tag == "attribute":
            value = next(((key, value) for key, value in table.items() if key not in _MARKS), ("", None))
            yield f"{indent}<attribute{head}>{_xml_text(*value)}</attribute>"
        else:
            yield f"{indent}<{tag}{head}>"
            for key in (key for key in _LISTS if key in table):
                yield from _xml_lines(key, table[key] if isinstance(table[key], list) else [table[key]], f"{indent}  ")
            yield f"{indent}</{tag}>"


def _xml_text(kind: str, value: object, tag: str = "array") -> str:
    """A value as text or elements; kind : the key that names its type in JSON.  tag : of one row."""
    if isinstance(value, list):
        if value and isinstance(value[0], list):
            shape, tag = ("matrix", "r") if kind.endswith("_matrix") else ("array_of_arrays", "array")
            return f"<{shape}>{''.join(_xml_text(kind, row, tag) for row in value)}</{shape}>"
        return f"<{tag}>{''.join(f'<c>{_xml_text(kind, cell)}</c>' for cell in value)}</{tag}>"
    if value is None or isinstance(value, str):
        return escape(value or "")
    return repr(value).lower() if isinstance(value, bool) else repr(value)
