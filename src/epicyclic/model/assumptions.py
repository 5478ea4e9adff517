"""`[assumed]`: its paths must exist."""

from __future__ import annotations

from collections.abc import Iterable

from ..errors import ModelError
from .names import nearest
from .tables import PlainTable, leaves

__all__ = ["check_assumed", "still_assumed"]


def check_assumed(layer: PlainTable, data: PlainTable) -> None:
    """Raise ModelError for an assumed path that is not in `data`, with the nearest one that is."""
    for path, reason in _entries(layer):
        if _find(data, path) is None:
            near = nearest(path, (p for p, _ in leaves(data)))
            allowed = "a path of this file"
            raise ModelError(f"no such path{near}", path=f"assumed.{path}", given=reason, allowed=allowed)


def still_assumed(data: PlainTable, overridden: Iterable[str]) -> PlainTable:
    """Return the document without assumptions about values that an override has set or removed."""
    gone = frozenset(overridden)

    def stands(path: str) -> bool:
        found = _find(data, path)
        below = {p for p, _ in leaves({path: found})} if found is not None else set()
        return f"assumed.{path}" in gone or not below <= gone

    if not isinstance(data.get("assumed"), dict):
        return data
    return data | {"assumed": {path: reason for path, reason in data["assumed"].items() if stands(path)}}


def _entries(data: PlainTable) -> list[tuple[str, object]]:
    """Return path and reason of every assumption."""
    table = data.get("assumed")
    return list(table.items()) if isinstance(table, dict) else []


def _find(data: PlainTable, path: str) -> object | None:
    """Return what stands at a path, None where nothing does."""
    here: object = data
    for part in path.split("."):
        if not isinstance(here, dict) or part not in here:
            return None
        here = here[part]
    return here
