"""A REXS file in XML, JSON or a zip of one: read into `RexsFile` whatever it holds, safe, bounded, with reasons; and
written, the same bytes from the same file, read back with equal values.

What the readers of XML and JSON have in common stands first: ids that are numbers, attributes once each, relations of
components that exist.
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
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal
from xml.etree.ElementTree import Element
from xml.sax.saxutils import escape, quoteattr

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from ..errors import ModelError
from ..user_input import read_bytes
from .file import (
    MAX_BYTES,
    MAX_DEPTH,
    MAX_MARKS,
    MAX_RATIO,
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

_ID = re.compile(r"[0-9]{1,15}")


Read = Callable[[str, str], Value]
"""Value of an attribute, of the place in the file and the id, which an error names."""


@dataclass(slots=True)
class _Gathered:
    """Parts of a file while it is read.

    notes : what is the user's own and left out.  custom : ids of components left out.
    """

    components: dict[int, Component] = field(default_factory=dict)
    relations: list[Relation] = field(default_factory=list)
    load_cases: list[LoadCase] = field(default_factory=list)
    accumulations: list[Component] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    custom: set[int] = field(default_factory=set)

    def component(self, number: int, kind: str, name: str, attributes: Iterable[tuple[str, str, Read]]) -> Component:
        """A component of attributes: id, unit and how the value is read.

        Raises
        ------
        ModelError : an attribute without id, two of the same id, and as of their values.
        """
        values: dict[str, Attribute] = {}
        for key, unit, read in attributes:
            where = f"component {number}, {key}"
            if _is_custom(key):
                self.notes.append(f"component {number}: {key}")
                continue
            value = read(where, key)
            if not key:
                raise ModelError("an attribute without id", path=where)
            if key in values:
                raise ModelError("stands twice", path=where, allowed="each attribute once")
            values[key] = Attribute(key, value, unit)
        return Component(number, kind, name, values)

    def add(self, component: Component) -> None:
        """Take a component. Raises ModelError for a second one of the same id, or one without type."""
        where = f"component {component.id}"
        if component.id in self.components or component.id in self.custom:
            raise ModelError("two components with one id", path=where, allowed="each id once")
        if not component.type:
            raise ModelError("missing", path=f"{where}, type", allowed="a type of the standard")
        if _is_custom(component.type):
            self.custom.add(component.id)
            self.notes.append(f"component {component.id}: {component.type}")
            return
        self.components[component.id] = component

    def relate(self, number: int, kind: str, order: object, refs: Iterable[tuple[str, object]]) -> None:
        """Take a relation of components that exist; none where it, or a component in it, is the user's own.

        Raises
        ------
        ModelError : no type, an order that is no number, a component that is not there.
        """
        where = f"relation {number}"
        if _is_custom(kind):
            self.notes.append(f"{where}: {kind}")
            return
        if not kind:
            raise ModelError("missing", path=f"{where}, type", allowed="a type of the standard")
        parts = [(role, _checked_id(part, where)) for role, part in refs if not _is_custom(role)]
        if any(part in self.custom for _, part in parts):
            return
        for role, part in parts:
            if part not in self.components:
                raise ModelError(
                    "no such component", path=f"{where}, {role}", given=part, allowed="an id of a component"
                )
        place = None if order is None or order == "" else _checked_id(order, f"{where}, order")
        self.relations.append(Relation(number, kind, place, tuple(parts)))

    def file(self, head: Callable[[str], object], encoding: Literal["xml", "json"]) -> RexsFile:
        """The file of what was gathered; head : attribute of its root -> value."""
        return RexsFile(
            version=plain_text(str(head("version"))),
            application=plain_text(str(head("applicationId"))),
            application_version=plain_text(str(head("applicationVersion"))),
            date=plain_text(str(head("date"))),
            components=tuple(self.components.values()),
            relations=tuple(self.relations),
            load_cases=tuple(self.load_cases),
            accumulations=tuple(self.accumulations),
            encoding=encoding,
            notes=tuple(self.notes),
        )


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


# JSON -----------------------------------------------------------------------------------------------------------------


def _json_file(tables: object) -> RexsFile:
    """The structure of nested tables.

    Raises
    ------
    ModelError : no REXS, or a part without what the standard demands of it.
    """
    model = tables.get("model") if isinstance(tables, Mapping) else None
    if not isinstance(model, Mapping):
        raise ModelError("not a REXS file", path="model", allowed='a JSON file with the table "model"')
    gathered = _Gathered()
    for component in _json_components(model, gathered):
        gathered.add(component)
    for spectrum in _tables(model, "load_spectrum"):
        for case in _tables(spectrum, "load_cases"):
            parts = tuple(_json_components(case, gathered))
            gathered.load_cases.append(LoadCase(_checked_id(case.get("id"), "load case"), parts))
        for accumulation in _tables(spectrum, "accumulation"):
            gathered.accumulations += _json_components(accumulation, gathered)
    for relation in _tables(model, "relations"):
        refs = [(_text(ref, "role"), ref.get("id")) for ref in _tables(relation, "refs")]
        number = _checked_id(relation.get("id"), "relation")
        gathered.relate(number, _text(relation, "type"), relation.get("order"), refs)
    return gathered.file(lambda key: model.get(key, ""), "json")


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


def _json_components(table: Mapping[str, Any], gathered: _Gathered) -> Iterator[Component]:
    """Components of a table, one after the other. Raises ModelError as of `_Gathered.component`."""
    for component in _tables(table, "components"):
        number = _checked_id(component.get("id"), "component")
        attributes = (
            (_text(attribute, "id"), _text(attribute, "unit", otherwise="none"), partial(_json_value, attribute))
            for attribute in _tables(component, "attributes")
        )
        yield gathered.component(number, _text(component, "type"), _text(component, "name"), attributes)


def _json_value(table: Mapping[str, Any], where: str, name: str) -> Value:
    """Value of an attribute: what stands beside its id and unit, by the key that names its type."""
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


def _xml_file(root: Element) -> RexsFile:
    """The structure of a tree.

    Raises
    ------
    ModelError : no REXS, or a part without what the standard demands of it.
    """
    if _tag(root) != "model":
        raise ModelError("not a REXS file", path=f"<{_tag(root)[:40]}>", allowed="an XML file with the root <model>")
    gathered = _Gathered()
    relations: list[Element] = []
    for part in root:
        match _tag(part):
            case "components":
                for component in _xml_components(part, gathered):
                    gathered.add(component)
            case "relations":
                relations += _all(part, "relation")
            case "load_spectrum":
                for case in _all(part, "load_case"):
                    parts = tuple(_xml_components(case, gathered))
                    gathered.load_cases.append(LoadCase(_checked_id(case.get("id"), "load_case"), parts))
                for accumulation in _all(part, "accumulation"):
                    gathered.accumulations += _xml_components(accumulation, gathered)
    for relation in relations:
        number = _checked_id(relation.get("id"), "relation")
        refs = [(plain_text(ref.get("role", "")), ref.get("id")) for ref in _all(relation, "ref")]
        gathered.relate(number, plain_text(relation.get("type", "")), relation.get("order"), refs)
    return gathered.file(lambda key: root.get(key, ""), "xml")


def _tag(element: Element) -> str:
    """Name of an element without its name space."""
    return element.tag.rpartition("}")[2]


def _all(element: Element, tag: str) -> Iterable[Element]:
    """The children of one name."""
    return (child for child in element if _tag(child) == tag)


def _xml_components(element: Element, gathered: _Gathered) -> Iterator[Component]:
    """Components of an element, one after the other. Raises ModelError as of `_Gathered.component`."""
    for component in _all(element, "component"):
        number = _checked_id(component.get("id"), "component")
        attributes = (
            (
                plain_text(attribute.get("id", "")),
                plain_text(attribute.get("unit", "none")),
                partial(_xml_value, attribute),
            )
            for attribute in _all(component, "attribute")
        )
        yield gathered.component(
            number, plain_text(component.get("type", "")), plain_text(component.get("name", "")), attributes
        )


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

_VERSIONS = ("1.1", "1.2", "1.3", "1.4", "1.5", "1.6", "1.7", "2.0", "2.0.0")
_ALLOWED = "a REXS file in XML (.rexs), JSON (.rexsj) or a zip of one of them (.rexsz)"
_BOM = b"\xef\xbb\xbf"
_WIDE = (b"\xff\xfe", b"\xfe\xff")  # UTF-16


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
        where = f"{name}, {error.path}" if error.path else name
        raise error.at(where) from None
    return file


def _parsed(raw: bytes, name: str, *, zipped: bool) -> RexsFile:
    """The file of bytes of any encoding. Raises ModelError as of `read_rexs_file`."""
    if len(raw) > MAX_BYTES:
        raise ModelError("too large", path=name, allowed=f"at most {MAX_BYTES} bytes")
    if raw.startswith(b"PK") and not zipped:
        return _parsed(_unzipped(raw, name), name, zipped=True)
    start = raw.removeprefix(_BOM)[:200].lstrip()
    if start.startswith(b"<") or raw.startswith(_WIDE):
        return _xml_file(_tree(raw, name))
    if start.startswith((b"{", b"[")):
        return _json_file(_json(raw.removeprefix(_BOM), name))
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
    except (
        zipfile.BadZipFile,
        zlib.error,
        struct.error,
        EOFError,
        OSError,
        ValueError,
        RuntimeError,
        OverflowError,
    ) as e:
        if isinstance(e, ModelError):
            raise
        raise ModelError(f"a damaged zip ({e})", path=name, allowed=allowed) from None
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
        raw = _json_bytes(file, types)
        marks = sum(map(raw.count, (b"{", b"[", b":")))
    else:
        raw = _xml_bytes(file, types)
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


def _xml_bytes(file: RexsFile, types: Mapping[int, str]) -> bytes:
    """The file in XML; types : of the components by id, which relations repeat as hints."""
    heads = " ".join(f"{key}={quoteattr(text)}" for key, text in _heads(file).items())
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f"<model {heads}>", "  <relations>"]
    for relation in file.relations:
        order = "" if relation.order is None else f' order="{relation.order}"'
        lines.append(f'    <relation id="{relation.id}" type={_quoted(relation.type)}{order}>')
        for role, part in relation.refs:
            lines.append(f'      <ref id="{part}" role={_quoted(role)} hint={_quoted(types[part])}/>')
        lines.append("    </relation>")
    lines += ["  </relations>", "  <components>", *_xml_lines(file.components, "    "), "  </components>"]
    if file.load_cases or file.accumulations:
        lines.append('  <load_spectrum id="1">')
        for case in file.load_cases:
            lines.append(f'    <load_case id="{case.id}">')
            lines += [*_xml_lines(case.components, "      "), "    </load_case>"]
        if file.accumulations:
            lines += ["    <accumulation>", *_xml_lines(file.accumulations, "      "), "    </accumulation>"]
        lines.append("  </load_spectrum>")
    return "\n".join([*lines, "</model>", ""]).encode("utf-8")


def _quoted(text: str) -> str:
    return quoteattr(plain_text(text))


def _xml_lines(components: Iterable[Component], indent: str) -> Iterator[str]:
    """Lines of components with their attributes."""
    for component in components:
        head = f'<component id="{component.id}" type={_quoted(component.type)} name={_quoted(component.name)}>'
        yield f"{indent}{head}"
        for attribute in component.attributes.values():
            head = f"<attribute id={_quoted(attribute.id)} unit={_quoted(attribute.unit)}>"
            value = _xml_text(attribute.value, f"component {component.id}, {attribute.id}")
            yield f"{indent}  {head}{value}</attribute>"
        yield f"{indent}</component>"


def _xml_text(value: Value, where: str) -> str:
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


def _json_bytes(file: RexsFile, types: Mapping[int, str]) -> bytes:
    """The file in JSON; types : of the components by id, which relations repeat as hints."""
    model: dict[str, Any] = {**_heads(file), "relations": []}
    for relation in file.relations:
        refs = [{"id": part, "role": plain_text(role), "hint": plain_text(types[part])} for role, part in relation.refs]
        order = {} if relation.order is None else {"order": relation.order}
        model["relations"].append({"id": relation.id, "type": plain_text(relation.type), **order, "refs": refs})
    model["components"] = _json_lists(file.components)
    if file.load_cases or file.accumulations:
        cases = [{"id": case.id, "components": _json_lists(case.components)} for case in file.load_cases]
        spectrum: dict[str, Any] = {"id": 1, "load_cases": cases}
        if file.accumulations:
            spectrum["accumulation"] = {"components": _json_lists(file.accumulations)}
        model["load_spectrum"] = spectrum
    return (json.dumps({"model": model}, ensure_ascii=False, indent=1, allow_nan=False) + "\n").encode("utf-8")


def _json_lists(components: Iterable[Component]) -> list[dict[str, Any]]:
    """Components with their attributes, each value beside the key that names its type."""
    tables = []
    for component in components:
        attributes = []
        for attribute in component.attributes.values():
            entry: dict[str, Any] = {"id": plain_text(attribute.id), "unit": plain_text(attribute.unit)}
            if attribute.value is not None:
                key, value = _json_entry(attribute, f"component {component.id}, {attribute.id}")
                entry[key] = value
            attributes.append(entry)
        name = {"name": plain_text(component.name)} if component.name else {}
        tables.append({"id": component.id, "type": plain_text(component.type), **name, "attributes": attributes})
    return tables


def _json_entry(attribute: Attribute, where: str) -> tuple[str, object]:
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
