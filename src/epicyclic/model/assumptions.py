"""`[assumed]` and `[tolerance]`: their paths must exist."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from ..errors import ModelError
from .names import Names, nearest
from .shorthand import expand
from .tables import PlainTable, leaves, merge, nested

__all__ = ["check_assumed", "check_tolerance", "still_assumed"]

_DISTRIBUTION = re.compile(r"\s*(normal|uniform)\([^(),]{1,40},[^(),]{1,40}\)\s*")


def check_assumed(layer: PlainTable, data: PlainTable) -> None:
    """Raise ModelError for an assumed path that is not in `data`, with the nearest one that is."""
    for path, reason in _entries(layer, "assumed"):
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


def check_tolerance(data: PlainTable, names: Names, validate: Callable[[PlainTable], object]) -> None:
    """Raise ModelError for a tolerance that is no distribution, or whose path is neither given nor could be.

    validate : raises ModelError for a document with a key it does not know.
    """
    for path, text in _entries(data, "tolerance"):
        where, allowed = f"tolerance.{path}", '"normal(mean, deviation)" or "uniform(low, high)"'
        if not isinstance(text, str) or not _DISTRIBUTION.fullmatch(text):
            raise ModelError("not a distribution", path=where, given=text, allowed=allowed)
        if _find(data, path) is None:
            trial = merge(data, expand(nested(tuple(path.split(".")), 0.0), names))
            try:
                validate({k: v for k, v in trial.items() if k != "tolerance"})
            except ModelError as error:
                allowed = "a path a number can stand at"
                raise ModelError(f"no such path ({error.problem})", path=where, given=text, allowed=allowed) from None


def _entries(data: PlainTable, name: str) -> list[tuple[str, object]]:
    """Return path and text of one of the two tables."""
    table = data.get(name)
    return list(table.items()) if isinstance(table, dict) else []


def _find(data: PlainTable, path: str) -> object | None:
    """Return what stands at a path, None where nothing does."""
    here: object = data
    for part in path.split("."):
        if not isinstance(here, dict) or part not in here:
            return None
        here = here[part]
    return here
