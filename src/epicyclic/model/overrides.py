"""Overrides: paths and values to a layer that is laid over the file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping

from ..errors import ModelError
from .names import nearest
from .tables import REMOVE, Table, clean, nested, split_path, union

__all__ = ["layer_of", "parse_setting", "stepwise"]

_NAMED = ("stages", "bodies", "couplings", "loads")  # tables whose entries an override changes but does not invent


def parse_setting(text: str) -> tuple[str, object]:
    """Return path and value of a `PATH=VALUE` from the command line: a TOML value, else a text; None where it is empty.

    Raises ModelError without `=`.
    """
    path, equals, value = text.partition("=")
    if not equals or not path.strip():
        raise ModelError("not a setting", path="--set", given=text, allowed="PATH=VALUE, stages.main.sun.mass=750 kg")
    value = value.strip()
    return path.strip(), _toml_value(value) if value else None


def _toml_value(text: str) -> object:
    """Return a TOML value, or the text itself where it is none."""
    if "\n" in text or len(text) > 100_000:
        return text
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if len(table) == 1 else text


def stepwise(overrides: Mapping[str, object]) -> tuple[dict[str, object], dict[str, object]]:
    """Return the overrides that empty a table which others fill anew, and those others: two layers, in this order."""
    paths = {text: split_path(str(text), path=str(text)) for text in overrides}
    emptied = {
        text
        for text, path in paths.items()
        if _removes(overrides[text]) and any(p[: len(path)] == path != p for p in paths.values())
    }
    first = {text: value for text, value in overrides.items() if text in emptied}
    return first, {text: value for text, value in overrides.items() if text not in emptied}


def _removes(value: object) -> bool:
    return value is None or (isinstance(value, str) and not value.strip())


def layer_of(overrides: Mapping[str, object], base: Table) -> Table:
    """Return overrides as one layer; None or an empty text removes the key.

    Raises ModelError where one reaches into a stage, body, coupling or load that the file does not have.
    """
    layer: Table = {}
    for text, value in overrides.items():
        path = split_path(str(text), path=str(text))
        _check_known(path, value, base)
        layer = union(layer, nested(path, REMOVE if _removes(value) else clean(value, str(text))), "")
    return layer


def _check_known(path: tuple[str, ...], value: object, base: Table) -> None:
    """Raise ModelError for a path through a table the file does not have; a whole table may be added."""
    known = base.get(path[0], {})
    if path[0] not in _NAMED or len(path) < 2 or not isinstance(known, dict):
        return
    if path[1] in known or (len(path) == 2 and isinstance(value, Mapping)):
        return
    raise ModelError(
        f"no '{path[1]}' in {path[0]}{nearest(path[1], known)}",
        path=".".join(path),
        given="(nothing)" if value is None else value,
        allowed=f"one of {', '.join(known)}" if known else f"a whole table, {path[0]}.{path[1]} = {{...}}",
    )
