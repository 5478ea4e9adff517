"""The tables of a REXS file in JSON, as its structure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ..errors import ModelError
from .parts import Gathered, add_attribute, checked_id, gathered_file, is_custom, referred
from .structure import Attribute, Component, LoadCase, Relation, RexsFile, Value
from .values import decoded, plain_text, scalar

__all__ = ["json_file"]


def json_file(tables: object) -> RexsFile:
    """The structure of nested tables.

    Raises
    ------
    ModelError : no REXS, or a part without what the standard demands of it.
    """
    model = tables.get("model") if isinstance(tables, Mapping) else None
    if not isinstance(model, Mapping):
        raise ModelError("not a REXS file", path="model", allowed='a JSON file with the table "model"')
    gathered = Gathered()
    for one in _tables(model, "components"):
        gathered.add(_component(one, gathered.notes))
    for spectrum in _tables(model, "load_spectrum"):
        for one in _tables(spectrum, "load_cases"):
            parts = tuple(_component(c, gathered.notes) for c in _tables(one, "components"))
            gathered.load_cases.append(LoadCase(checked_id(one.get("id"), "load case"), parts))
        for one in _tables(spectrum, "accumulation"):
            gathered.accumulations += [_component(c, gathered.notes) for c in _tables(one, "components")]
    gathered.relations = [read for one in _tables(model, "relations") if (read := _relation(one, gathered)) is not None]
    heads = {key: str(model.get(key, "")) for key in ("version", "applicationId", "applicationVersion", "date")}
    return gathered_file(gathered, heads, encoding="json")


def _tables(table: Mapping[str, Any], key: str) -> Iterable[Mapping[str, Any]]:
    """The tables of a list, of a single table, or none. Raises ModelError for anything else."""
    found = table.get(key)
    if found is None:
        return ()
    entries = found if isinstance(found, list) else [found]
    for entry in entries:
        if not isinstance(entry, Mapping):
            raise ModelError("not a table", path=key, given=entry, allowed="a list of tables")
    return entries


def _text(table: Mapping[str, Any], key: str, *, otherwise: str = "") -> str:
    """A text of a table; numbers and truth values as text."""
    value = table.get(key)
    return plain_text(str(value)) if isinstance(value, (str, int, float)) else otherwise


def _component(table: Mapping[str, Any], notes: list[str]) -> Component:
    """A component with its attributes."""
    number = checked_id(table.get("id"), "component")
    attributes: dict[str, Attribute] = {}
    for one in _tables(table, "attributes"):
        name = _text(one, "id")
        if is_custom(name):
            notes.append(f"component {number}: {name}")
            continue
        where = f"component {number}, {name}"
        add_attribute(
            attributes, Attribute(name, _value(one, where, name), _text(one, "unit", otherwise="none")), where
        )
    return Component(number, _text(table, "type"), _text(table, "name"), attributes)


def _value(table: Mapping[str, Any], where: str, name: str) -> Value:
    """Value of an attribute: what stands beside its id and unit, by the key that names its type."""
    keys = [key for key in table if key not in ("id", "unit") and not is_custom(key)]
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
    if not isinstance(value, list):
        return _scalar(value, where, name)
    return tuple(
        tuple(_scalar(cell, where, name) for cell in entry) if isinstance(entry, list) else _scalar(entry, where, name)
        for entry in value
    )


def _scalar(value: object, where: str, name: str) -> Value:
    """One value; an error names the component too."""
    try:
        return scalar(value, name)
    except ModelError as error:
        raise error.at(where) from None


def _relation(table: Mapping[str, Any], gathered: Gathered) -> Relation | None:
    """A relation; None for one of the user's own."""
    refs = [(_text(one, "role"), one.get("id")) for one in _tables(table, "refs")]
    number = checked_id(table.get("id"), "relation")
    return referred(number, _text(table, "type"), table.get("order"), refs, gathered)
