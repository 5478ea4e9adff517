"""Nested tables of plain values: clean, merge, walk, and written as TOML.

Own writer, because a model file is read by people: small tables stand in braces and lists on one line, where `tomli_w`
gives every table a heading and every entry of a list a line.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

from ..errors import ModelError

PlainTable = dict[str, Any]
MAX_DEPTH = 24
# points of one dotted key: tomllib takes time as the square of their number, and there are 24 levels at most
_MAX_POINTS = 300
# segment of a key, a text (to the end of the line where it does not end there), a point, or what ends a key
_TOKEN = re.compile(r"""(?P<segment>[\w-]+|"(?:[^"\\]|\\.)*(?:"|\\?$)|'[^']*(?:'|$))|(?P<point>\.)|(?P<end>[^ \t])""")
# no line of text needs them, and a terminal takes them as orders
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]")
# numbers above are no input; in a message or a file Python takes long over their digits, or refuses
_MAX_BITS = 1024


class _Remove:
    """What an empty override stands for: the key goes."""

    def __repr__(self) -> str:
        return "(nothing)"


REMOVE: Final = _Remove()


def clean(value: object, path: str = "", depth: int = 0) -> Any:
    """Return a value as plain JSON: tables with text keys, lists, texts, numbers; infinity as "inf".

    numpy scalars and arrays become numbers and lists. Raises ModelError for anything else, nan, numbers of hundreds of
    digits, control characters in texts, and deep nesting.
    """
    if depth > MAX_DEPTH:
        raise ModelError("nested too deeply", path=path[:80], allowed=f"at most {MAX_DEPTH} levels")
    if isinstance(value, str):
        return _clean_text(value, path)
    if value is REMOVE or isinstance(value, bool):
        return value
    if isinstance(value, int):
        if value.bit_length() > _MAX_BITS:
            raise ModelError("too large", path=path, given="a number of hundreds of digits", allowed="a number")
        return int(value)  # not the mark of a number typed on the command line
    if isinstance(value, float):
        if math.isnan(value):
            raise ModelError("not a number", path=path, given="nan", allowed="a number")
        return ("inf" if value > 0 else "-inf") if math.isinf(value) else float(value)
    if isinstance(value, Mapping):
        return {
            _clean_text(str(k), path): clean(v, f"{path}.{k}" if path else str(k), depth + 1)
            for k, v in value.items()
            if v is not None
        }
    if isinstance(value, (list, tuple)):
        return [clean(v, path, depth + 1) for v in value]
    if hasattr(value, "tolist"):
        return clean(value.tolist(), path, depth + 1)
    kinds = "a text, a number, true or false, a list or a table"
    raise ModelError(f"a {type(value).__name__} cannot stand here", path=path, given=value, allowed=kinds)


def _clean_text(text: str, path: str) -> str:
    """Return a text without control characters but tab and line breaks."""
    found = _CONTROL.search(text)
    if found is not None:
        problem = f"holds a control character, U+{ord(found[0]):04X}"
        raise ModelError(problem, path=path, given=ascii(text), allowed="a text")
    return text


def dotted_line(text: str) -> int | None:
    """Return the number of the first line of a TOML text with a dotted key of more points than a parser can bear."""
    for number, line in enumerate(text.splitlines(), start=1):
        if line.count(".") > _MAX_POINTS and _most_points(line) > _MAX_POINTS:
            return number
    return None


def _most_points(line: str) -> int:
    """Points of the longest dotted key of a line."""
    most = points = 0
    before = "end"
    for token in _TOKEN.finditer(line):
        kind = str(token.lastgroup)
        if kind == "end" or kind == before == "segment":
            points = 0
        elif kind == "point":
            points += 1
        most, before = max(most, points), kind
    return most


def split_path(text: str, *, path: str = "") -> tuple[str, ...]:
    """Return the segments of a path; quotes round a segment are dropped.

    Raises ModelError for an empty one, and for more than any table has levels.
    """
    if text.count(".") > MAX_DEPTH:
        raise ModelError("nested too deeply", path=path[:80], given=text, allowed=f"at most {MAX_DEPTH} levels")
    segments = tuple(part.strip().strip("\"'").strip() for part in text.replace('"', "").split("."))
    if not all(segments):
        raise ModelError("not a path", path=path, given=text, allowed="names joined by points, stages.main.sun.mass")
    return segments


def nested(path: tuple[str, ...], value: Any) -> Any:
    """Return tables inside each other that hold `value` at `path`."""
    for name in reversed(path):
        value = {name: value}
    return value


def union(first: PlainTable, second: PlainTable, path: str) -> PlainTable:
    """Return two tables of one layer as one. Raises ModelError where both give the same key."""
    result = dict(first)
    for name, value in second.items():
        where = f"{path}.{name}" if path else name
        if name not in result:
            result[name] = value
        elif isinstance(value, dict) and isinstance(result[name], dict):
            result[name] = union(result[name], value, where)
        elif value is not REMOVE or result[name] is not REMOVE:  # removed twice, by two spellings, is removed
            raise ModelError("given twice", path=where, given=value, allowed="one of the two")
    return result


def merge(base: PlainTable, layer: PlainTable, path: str = "") -> PlainTable:
    """Return `layer` laid over `base`: tables entry by entry, all else replaced, `REMOVE` removes.

    Raises ModelError where there is nothing to remove.
    """
    result = dict(base)
    for name, value in layer.items():
        where = f"{path}.{name}" if path else name
        if value is REMOVE:
            if name not in result:
                allowed = f"one of {', '.join(base)}" if base else "nothing: the file has none"
                raise ModelError("nothing there to remove", path=where, allowed=allowed)
            del result[name]
        elif isinstance(value, dict):
            below = result.get(name)
            result[name] = merge(below if isinstance(below, dict) else {}, value, where)
        else:
            result[name] = value
    return result


def value_at(table: object, path: Iterable[str]) -> Any:
    """Return what stands at the names of a path in nested tables, None where nothing does."""
    for name in path:
        table = table.get(name) if isinstance(table, Mapping) else None
    return table


def leaves(table: PlainTable, path: str = "") -> Iterator[tuple[str, object]]:
    """Yield the path and value of everything that is no table, and of empty tables."""
    for name, value in table.items():
        where = f"{path}.{name}" if path else name
        if isinstance(value, dict) and value:
            yield from leaves(value, where)
        else:
            yield where, value


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
