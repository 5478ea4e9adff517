"""Nested tables to TOML text.

Own writer, because a model file is read by people: small tables stand in braces and lists on one line, where `tomli_w`
gives every table a heading and every entry of a list a line.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping

__all__ = ["key_text", "to_toml", "value_text"]

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_WIDTH = 100  # tables of plain values are written in braces where they fit on so long a line


def to_toml(data: Mapping[str, object]) -> str:
    """Return nested tables of texts, numbers, truth values and lists as TOML, in their order.

    Reading the text gives the same tables back.
    """
    lines = _lines(data, ())
    return "\n".join(lines).strip("\n") + "\n"


def _lines(table: Mapping[str, object], path: tuple[str, ...]) -> list[str]:
    """Return the lines of one table: its values first, then the tables in it."""
    values = [f"{key_text(k)} = {value_text(v)}" for k, v in table.items() if _is_value(v)]
    tables = {k: v for k, v in table.items() if isinstance(v, Mapping) and not _is_value(v)}
    heading = ["", f"[{'.'.join(key_text(p) for p in path)}]"] if path and (values or not tables) else []
    below = [line for k, v in tables.items() for line in _lines(v, (*path, k))]
    return heading + values + below


def _is_value(value: object) -> bool:
    """Return whether a value is written on one line: no table, or a small one of plain values."""
    if not isinstance(value, Mapping):
        return True
    return (
        0 < len(value) and not any(isinstance(v, Mapping) for v in value.values()) and len(value_text(value)) <= _WIDTH
    )


def key_text(name: str) -> str:
    """Return a key, quoted where it must be."""
    return name if _BARE_KEY.fullmatch(name) else _text(name)


def value_text(value: object) -> str:
    """Return one value in TOML."""
    if hasattr(value, "tolist"):  # a number or array of numpy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(value_text(v) for v in value)}]"
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key_text(k)} = {value_text(v)}' for k, v in value.items())} }}" if value else "{}"
    return repr(float(value)) if isinstance(value, float) else str(value)


def _text(text: str) -> str:
    """Return a basic TOML string; JSON's escapes are TOML's, but for DEL, which TOML wants escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")
