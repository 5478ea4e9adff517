"""Inheritance of keys: a side, else its member or mesh, else the stage, else the file.

Every key that may stand at several levels of the file is read through this module.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

__all__ = ["Level", "Levels", "Stated", "origin_of", "overlaid", "stated", "stated_value", "subtables"]

LevelName = Literal["side", "member", "mesh", "stage", "file"]


class Level(NamedTuple):
    """A table that may state a key: which level of the file it is, its path, and the table, None where it is absent."""

    name: LevelName
    path: str
    table: object | None


Levels = tuple[Level, ...]  # nearest first


class Stated(NamedTuple):
    """A value the file states: the value in SI, the level and the path of its key."""

    value: Any
    level: LevelName
    path: str


def stated(levels: Levels, key: str) -> Stated | None:
    """Value of a key in the nearest table that states it; None where none does."""
    for level in levels:
        value = getattr(level.table, key, None)
        if value is not None:
            return Stated(value, level.name, _below(level.path, key))
    return None


def stated_value(levels: Levels, key: str, default: Any) -> Any:
    """Value of a key in the nearest table that states it, else `default`."""
    found = stated(levels, key)
    return default if found is None else found.value


def subtables(levels: Levels, key: str) -> Levels:
    """The tables under one key at each level, so that each of their own keys is inherited by itself."""
    return tuple(Level(level.name, _below(level.path, key), getattr(level.table, key, None)) for level in levels)


def overlaid(levels: Levels, key: str) -> tuple[Any, str]:
    """The tables under one key laid over each other, nearest on top, and the path of the nearest one.

    Without any table None, and the path at the farthest level.
    """
    present = [level for level in subtables(levels, key) if level.table is not None]
    if not present:
        return None, _below(levels[-1].path, key)
    table: Any = present[-1].table
    for level in reversed(present[:-1]):
        nearer: Any = level.table
        table = table.model_copy(update={name: getattr(nearer, name) for name in nearer.model_fields_set})
    return table, present[0].path


def origin_of(found: Stated | None) -> str:
    """Origin of an inherited value as `Derived.origin` names it: given, stage or default."""
    if found is None:
        return "default"
    return "stage" if found.level == "stage" else "given"


def _below(path: str, key: str) -> str:
    """Path of a key in the table at `path`, "" for the file itself."""
    return f"{path}.{key}" if path else key
