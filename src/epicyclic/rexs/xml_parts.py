"""The tree of a REXS file in XML, as its structure."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element

from ..errors import ModelError
from .parts import Gathered, add_attribute, checked_id, gathered_file, is_custom, referred
from .structure import Attribute, Component, LoadCase, Relation, RexsFile, Value
from .values import decoded, plain_text, text_value

__all__ = ["xml_file"]


def xml_file(root: Element) -> RexsFile:
    """The structure of a tree.

    Raises
    ------
    ModelError : no REXS, or a part without what the standard demands of it.
    """
    if _tag(root) != "model":
        raise ModelError("not a REXS file", path=f"<{_tag(root)[:40]}>", allowed="an XML file with the root <model>")
    gathered = Gathered()
    relations: list[Element] = []
    for part in root:
        match _tag(part):
            case "components":
                for one in _all(part, "component"):
                    gathered.add(_component(one, gathered.notes))
            case "relations":
                relations += _all(part, "relation")
            case "load_spectrum":
                for one in _all(part, "load_case"):
                    cases = tuple(_component(c, gathered.notes) for c in _all(one, "component"))
                    gathered.load_cases.append(LoadCase(checked_id(one.get("id"), "load_case"), cases))
                for one in _all(part, "accumulation"):
                    gathered.accumulations += [_component(c, gathered.notes) for c in _all(one, "component")]
    gathered.relations = [read for one in relations if (read := _relation(one, gathered)) is not None]
    heads = {key: root.get(key, "") for key in ("version", "applicationId", "applicationVersion", "date")}
    return gathered_file(gathered, heads, encoding="xml")


def _tag(element: Element) -> str:
    """Name of an element without its name space."""
    return element.tag.rpartition("}")[2]


def _all(element: Element, tag: str) -> Iterable[Element]:
    """The children of one name."""
    return (child for child in element if _tag(child) == tag)


def _component(element: Element, notes: list[str]) -> Component:
    """A component with its attributes."""
    number = checked_id(element.get("id"), "component")
    kind = plain_text(element.get("type", ""))
    attributes: dict[str, Attribute] = {}
    for one in _all(element, "attribute"):
        name = plain_text(one.get("id", ""))
        if is_custom(name):
            notes.append(f"component {number}: {name}")
            continue
        where = f"component {number}, {name}"
        attribute = Attribute(name, _value(one, where, name), plain_text(one.get("unit", "none")))
        add_attribute(attributes, attribute, where)
    return Component(number, kind, plain_text(element.get("name", "")), attributes)


def _value(element: Element, where: str, name: str) -> Value:
    """Value of an attribute: text, array, matrix, array of arrays."""
    for child in element:
        match _tag(child):
            case "array":
                return _array(child, where, name)
            case "matrix":
                if child.get("code"):
                    return decoded(
                        child.get("code"), child.text or "", (child.get("rows"), child.get("columns")), where
                    )
                return tuple(_cells(row, name) for row in _all(child, "r"))
            case "array_of_arrays":
                return tuple(_array(row, where, name) for row in _all(child, "array"))
    return text_value(element.text or "", name)


def _array(element: Element, where: str, name: str) -> Value:
    """Values of an array, plain or coded."""
    if element.get("code"):
        return decoded(element.get("code"), element.text or "", None, where)
    return _cells(element, name)


def _cells(element: Element, name: str) -> tuple[Value, ...]:
    """Values of the cells of an array or row."""
    return tuple(text_value(cell.text or "", name) for cell in _all(element, "c"))


def _relation(element: Element, gathered: Gathered) -> Relation | None:
    """A relation; None for one of the user's own."""
    number = checked_id(element.get("id"), "relation")
    kind = plain_text(element.get("type", ""))
    refs = [(plain_text(one.get("role", "")), one.get("id")) for one in _all(element, "ref")]
    return referred(number, kind, element.get("order"), refs, gathered)
