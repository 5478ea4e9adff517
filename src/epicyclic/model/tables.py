"""Nested tables of plain values: clean, merge, walk."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

from ..errors import ModelError

__all__ = ["REMOVE", "PlainTable", "clean", "leaves", "merge", "nested", "split_path", "union"]

PlainTable = dict[str, Any]
MAX_DEPTH = 24


class _Remove:
    """What an empty override stands for: the key goes."""

    def __repr__(self) -> str:
        return "(nothing)"


REMOVE: Final = _Remove()


def clean(value: object, path: str = "", depth: int = 0) -> Any:
    """Return a value as plain JSON: tables with text keys, lists, texts, numbers; infinity as "inf".

    numpy scalars and arrays become numbers and lists. Raises ModelError for anything else, nan, and deep nesting.
    """
    if depth > MAX_DEPTH:
        raise ModelError("nested too deeply", path=path[:80], allowed=f"at most {MAX_DEPTH} levels")
    if value is REMOVE or isinstance(value, (bool, str)):
        return value
    if isinstance(value, int):
        return int(value)  # not the mark of a number typed on the command line
    if isinstance(value, float):
        return _clean_float(value, path)
    if isinstance(value, Mapping):
        return {
            str(k): clean(v, f"{path}.{k}" if path else str(k), depth + 1) for k, v in value.items() if v is not None
        }
    if isinstance(value, (list, tuple)):
        return [clean(v, path, depth + 1) for v in value]
    if hasattr(value, "tolist"):
        return clean(value.tolist(), path, depth + 1)
    kinds = "a text, a number, true or false, a list or a table"
    raise ModelError(f"a {type(value).__name__} cannot stand here", path=path, given=value, allowed=kinds)


def _clean_float(value: float, path: str) -> float | str:
    """Return a plain float, "inf" for infinity."""
    if math.isnan(value):
        raise ModelError("not a number", path=path, given="nan", allowed="a number")
    return ("inf" if value > 0 else "-inf") if math.isinf(value) else float(value)


def split_path(text: str, *, path: str = "") -> tuple[str, ...]:
    """Return the segments of a path; quotes round a segment are dropped. Raises ModelError for an empty one."""
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
        else:
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
                raise ModelError("nothing there to remove", path=where, allowed=f"one of {', '.join(base)}")
            del result[name]
        elif isinstance(value, dict):
            below = result.get(name)
            result[name] = merge(below if isinstance(below, dict) else {}, value, where)
        else:
            result[name] = value
    return result


def leaves(table: PlainTable, path: str = "") -> Iterator[tuple[str, object]]:
    """Yield the path and value of everything that is no table, and of empty tables."""
    for name, value in table.items():
        where = f"{path}.{name}" if path else name
        if isinstance(value, dict) and value:
            yield from leaves(value, where)
        else:
            yield where, value
