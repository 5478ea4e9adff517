"""Layers of a document: overrides as a layer laid over the file, and alternative keys (rule 3).

Alternatives of one key are an error in one layer; a later layer replaces them.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from itertools import permutations

from ..errors import ModelError
from .bare_numbers import is_typed, typed
from .names import nearest
from .tables import REMOVE, PlainTable, clean, dotted_line, leaves, nested, split_path, union

__all__ = [
    "ALTERNATIVES",
    "check_alternatives",
    "layer_of",
    "parse_setting",
    "replace_alternatives",
    "settings_of",
    "stepwise",
]

_NAMED = ("stages", "bodies", "couplings", "loads")  # tables whose entries an override changes but does not invent


def parse_setting(text: str) -> tuple[str, object]:
    """Return path and value of a `PATH=VALUE` from the command line: a TOML value, else a text; None where it is empty.

    Numbers are marked as typed, so that a quantity without its unit is told or refused.

    Raises ModelError without `=`.
    """
    path, equals, value = text.partition("=")
    if not equals or not path.strip():
        raise ModelError(
            "not a setting", path="overrides", given=text, allowed="PATH=VALUE, stages.main.sun.mass=750 kg"
        )
    value = value.strip()
    return path.strip(), typed(_toml_value(value)) if value else None


def _toml_value(text: str) -> object:
    """Return a TOML value, or the text itself where it is none."""
    if "\n" in text or len(text) > 100_000 or dotted_line(text) is not None:
        return text
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if len(table) == 1 else text


def stepwise(overrides: Mapping[str, object]) -> list[dict[str, object]]:
    """Return the overrides as layers, in the order in which they are laid; the last one has all that are no step.

    A table that others reach into is removed before they fill it, and after what they remove of it.
    """
    paths = {text: split_path(str(text), path=str(text)) for text in overrides}
    removed = {text: path for text, path in paths.items() if _removes(overrides[text])}
    above = {text: sum(path[: len(p)] == p != path for p in removed.values()) for text, path in removed.items()}
    emptied = {text for text, path in removed.items() if any(p[: len(path)] == path != p for p in paths.values())}
    steps = [
        {text: overrides[text] for text in removed if above[text] == level and (level or text in emptied)}
        for level in range(max(above.values(), default=0), -1, -1)
    ]
    done = {text for step in steps for text in step}
    return [*steps, {text: value for text, value in overrides.items() if text not in done}]


def _removes(value: object) -> bool:
    return value is None or (isinstance(value, str) and not value.strip())


def layer_of(overrides: Mapping[str, object], base: PlainTable) -> PlainTable:
    """Return overrides as one layer; None or an empty text removes the key.

    Raises ModelError where one reaches into a stage, body, coupling or load that the file does not have, and where an
    empty table is laid over one that is not empty.
    """
    layer: PlainTable = {}
    for text, value in overrides.items():
        path = split_path(str(text), path=str(text))
        _check_known(path, value, base)
        if isinstance(value, Mapping) and not value and _table_at(base, path):
            raise ModelError(
                "an empty table changes nothing", path=str(text), given="{}", allowed=f"{text}= removes it"
            )
        layer = union(layer, nested(path, REMOVE if _removes(value) else clean(value, str(text))), "")
    return layer


def _table_at(base: PlainTable, path: tuple[str, ...]) -> object:
    """What stands at a path, None where nothing does."""
    found: object = base
    for name in path:
        found = found.get(name) if isinstance(found, dict) else None
    return found


def settings_of(overrides: Mapping[str, object]) -> PlainTable:
    """Return the overrides with numbers that a person typed, as a table."""
    table: PlainTable = {}
    for text, value in overrides.items():
        if is_typed(value):
            table = union(table, nested(split_path(str(text), path=str(text)), clean(value, str(text))), "")
    return table


def _check_known(path: tuple[str, ...], value: object, base: PlainTable) -> None:
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


# alternatives ---------------------------------------------------------------------------------------------------------

# groups of keys of which only one stands in a table; no other table has keys of two groups of one line
ALTERNATIVES: tuple[tuple[tuple[str, ...], ...], ...] = (
    (("planets",), ("planet_angles",)),
    (("module",), ("transverse_module",)),
    (("amplitude", "phase"), ("x", "y")),
    (("diameter", "bore"), ("torsional_rigidity",)),
    (("cosine", "sine"), ("values",)),
    (("rim",), ("outer_diameter",)),
    (("modal",), ("mass", "stiffness"), ("mesh",)),
    (("force",), ("coefficient", "radius")),
    (("count",), ("angles",)),
)
_OPERATION = ("torque", "power")


def check_alternatives(layer: PlainTable) -> None:
    """Raise ModelError where one layer says the same in two ways."""
    _check(layer, "")
    operation = layer.get("operation")
    if isinstance(operation, dict):
        torques = _given(operation.get("torque"))
        for member in _given(operation.get("power")) & torques:
            _clash(f"operation.power.{member}", "torque", ("torque", "power"))


def replace_alternatives(base: PlainTable, layer: PlainTable) -> PlainTable:
    """Return `base` without the keys that `layer` states by an alternative."""
    result = _replace(base, layer)
    before, after = result.get("operation"), layer.get("operation")
    if isinstance(before, dict) and isinstance(after, dict):
        operation = dict(before)
        for mine, other in permutations(_OPERATION):
            stated = after.get(other)
            removed = {path for path, _ in leaves(stated)} if isinstance(stated, dict) else set()
            for member in _given(after.get(mine)) & _given(operation.get(other)) - removed:
                operation[other] = _without(operation[other], tuple(member.split(".")))
        result["operation"] = operation
    return result


def _check(table: PlainTable, path: str) -> None:
    """Check one table and those in it."""
    keys = {k for k, v in table.items() if v is not REMOVE}
    for groups in ALTERNATIVES:
        found = [k for group in groups for k in group if k in keys]
        used = [group for group in groups if keys & set(group)]
        if len(used) > 1:
            _clash(f"{path}.{found[-1]}" if path else found[-1], found[0], tuple(found))
    for name, value in table.items():
        if isinstance(value, dict):
            _check(value, f"{path}.{name}" if path else name)


def _clash(path: str, other: str, both: tuple[str, ...]) -> None:
    raise ModelError(f"says the same as {other}, which is given too", path=path, allowed=f"one of {', '.join(both)}")


def _replace(base: PlainTable, layer: PlainTable) -> PlainTable:
    """Drop the keys of other groups from one table and those in it."""
    given = {k for k, v in layer.items() if v is not REMOVE}
    gone = {
        k
        for groups in ALTERNATIVES
        for mine, other in permutations(groups, 2)
        if given & set(mine)
        for k in other
        if k not in layer
    }
    kept = {k: v for k, v in base.items() if k not in gone}
    return {
        k: _replace(v, layer[k]) if isinstance(v, dict) and isinstance(layer.get(k), dict) else v
        for k, v in kept.items()
    }


def _given(table: object) -> set[str]:
    """Return the paths of the values in a table that are given."""
    return {path for path, value in leaves(table) if value is not REMOVE} if isinstance(table, dict) else set()


def _without(table: PlainTable, path: tuple[str, ...]) -> PlainTable:
    """Return a table without the value at a path, nor tables that empties."""
    if len(path) == 1:
        return {k: v for k, v in table.items() if k != path[0]}
    inner = _without(table[path[0]], path[1:])
    return {**table, path[0]: inner} if inner else {k: v for k, v in table.items() if k != path[0]}
