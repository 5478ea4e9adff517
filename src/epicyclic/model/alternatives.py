"""Alternatives (rule 3): two ways to say the same are an error in one layer; a later layer replaces."""

from __future__ import annotations

from itertools import permutations

from ..errors import ModelError
from .tables import REMOVE, Table, leaves

__all__ = ["ALTERNATIVES", "check_alternatives", "replace_alternatives"]

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


def check_alternatives(layer: Table) -> None:
    """Raise ModelError where one layer says the same in two ways."""
    _check(layer, "")
    operation = layer.get("operation")
    if isinstance(operation, dict):
        torques = _given(operation.get("torque"))
        for member in _given(operation.get("power")) & torques:
            _clash(f"operation.power.{member}", "torque", ("torque", "power"))


def replace_alternatives(base: Table, layer: Table) -> Table:
    """Return `base` without what `layer` says in another way."""
    result = _replace(base, layer)
    before, after = result.get("operation"), layer.get("operation")
    if isinstance(before, dict) and isinstance(after, dict):
        operation = dict(before)
        for mine, other in permutations(_OPERATION):
            for member in _given(after.get(mine)) & _given(operation.get(other)):
                operation[other] = _without(operation[other], tuple(member.split(".")))
        result["operation"] = operation
    return result


def _check(table: Table, path: str) -> None:
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


def _replace(base: Table, layer: Table) -> Table:
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


def _without(table: Table, path: tuple[str, ...]) -> Table:
    """Return a table without the value at a path, nor tables that empties."""
    if len(path) == 1:
        return {k: v for k, v in table.items() if k != path[0]}
    inner = _without(table[path[0]], path[1:])
    return {**table, path[0]: inner} if inner else {k: v for k, v in table.items() if k != path[0]}
