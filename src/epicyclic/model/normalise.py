"""Normalisation of the expanded document: values by full member path, lists as tuples, CSV files read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import ModelError
from .deviations import MemberDeviationsTable, MeshDeviationsTable, kind_of
from .names import SIDES, Names, mesh_name, nearest
from .tables import PlainTable

__all__ = ["normalise"]

STANDARD_GRAVITY = 9.81  # m/s^2


def normalise(data: PlainTable, names: Names, folder: Path | None) -> PlainTable:
    """Return the expanded document as `ModelFile` takes it. `folder` is where CSV files are looked for.

    Raises ModelError for a reference to nothing.
    """
    result = dict(data)
    if isinstance(operation := data.get("operation"), dict):
        result["operation"] = _operation(operation, names)
    if isinstance(deviations := data.get("deviations"), dict):
        result["deviations"] = _deviations(deviations, names, folder)
    if isinstance(couplings := data.get("couplings"), dict):
        result["couplings"] = {k: _tuple(v, "between") for k, v in couplings.items()}
    return result


def _tuple(table: Any, name: str) -> Any:
    """Return a table with one of its lists as a tuple."""
    if isinstance(table, dict) and isinstance(table.get(name), list):
        return {**table, name: tuple(table[name])}
    return table


def _operation(table: PlainTable, names: Names) -> PlainTable:
    """Flatten speeds, torques and powers to full member paths."""
    result: PlainTable = _tuple(table, "held")
    for name in ("speed", "torque", "power"):
        if isinstance(table.get(name), dict):
            result = result | {name: _by_member(table[name], names, f"operation.{name}", sides=name != "speed")}
    if isinstance(gravity := table.get("gravity"), bool):
        result = result | {"gravity": f"[0, {-STANDARD_GRAVITY}, 0] m/s^2" if gravity else None}
    return result


def _by_member(table: PlainTable, names: Names, path: str, *, sides: bool) -> PlainTable:
    """Return {full path: value} of nested stage, member and side tables."""
    flat: PlainTable = {}
    for first, value in table.items():
        where = f"{path}.{first}"
        if first in names.stages:
            for member, entry in _table(value, where, "a table of members").items():
                _known(member, names.stages[first], f"{where}.{member}", entry)
                flat |= _sides(f"{first}.{member}", entry, f"{where}.{member}", sides)
        else:
            _known(first, (*names.bodies, *names.stages), where, value)
            flat[first] = value
    return flat


def _sides(member: str, value: Any, path: str, sides: bool) -> PlainTable:
    """Return {member: value}, or one entry for each side."""
    if not isinstance(value, dict):
        return {member: value}
    for side, entry in value.items():
        if not sides or side not in SIDES:
            raise ModelError("no such side", path=f"{path}.{side}", given=entry, allowed=" or ".join(SIDES))
    return {f"{member}.{side}": entry for side, entry in value.items()}


def _deviations(table: PlainTable, names: Names, folder: Path | None) -> PlainTable:
    """Flatten deviations to full member and mesh paths."""
    members: PlainTable = {}
    meshes: PlainTable = {}
    for first, value in table.items():
        where = f"deviations.{first}"
        if first in names.stages:
            for name, entry in _table(value, where, "a table of members, and meshes").items():
                if name == "meshes":
                    meshes |= _mesh_deviations(_table(entry, f"{where}.meshes", "a table of meshes"), first, names)
                else:
                    _known(name, (*names.stages[first], "meshes"), f"{where}.{name}", entry)
                    members |= _member_deviations(f"{first}.{name}", entry, folder, gear=True)
        else:
            _known(first, (*names.bodies, *names.stages), where, value)
            members |= _member_deviations(first, value, folder, gear=False)
    return {"members": members, "meshes": meshes}


def _member_deviations(member: str, value: Any, folder: Path | None, *, gear: bool) -> PlainTable:
    """Return the deviations of a member, and of its sides where it has them, by path."""
    path = f"deviations.{member}"
    table = _table(value, path, f"a table of {', '.join(MemberDeviationsTable.model_fields)}")
    sides = {k: v for k, v in table.items() if gear and k in SIDES}
    own = {k: v for k, v in table.items() if k not in sides}
    result = {member: own} if own or not sides else {}
    result |= {f"{member}.{side}": _table(v, f"{path}.{side}", "a table") for side, v in sides.items()}
    return {member: _read_kinds(entry, member, folder) for member, entry in result.items()}


def _read_kinds(table: PlainTable, member: str, folder: Path | None) -> PlainTable:
    """Return the deviations of one member with the kinds read that have a form of their own in the file."""
    kinds = {name: kind_of(MemberDeviationsTable, name) for name in MemberDeviationsTable.model_fields}
    return table | {k: kind.read(table[k], member, folder) for k, kind in kinds.items() if kind.read and k in table}


def _mesh_deviations(table: PlainTable, stage: str, names: Names) -> PlainTable:
    """Return the deviations of the meshes of one stage, and of their sides, by path."""
    result: PlainTable = {}
    for name, value in table.items():
        path = f"{stage}.meshes.{name}"
        mesh_name(name, stage, names, path=f"deviations.{path}")
        entry = _table(value, f"deviations.{path}", f"a table of {', '.join(MeshDeviationsTable.model_fields)}")
        sides = {k: v for k, v in entry.items() if k in SIDES}
        own = {k: v for k, v in entry.items() if k not in sides}
        result |= ({path: own} if own or not sides else {}) | {f"{path}.{k}": v for k, v in sides.items()}
    return result


def _table(value: Any, path: str, allowed: str) -> PlainTable:
    """Return a table. Raises ModelError for anything else."""
    if not isinstance(value, dict):
        raise ModelError("not a table", path=path, given=value, allowed=allowed)
    return value


def _known(name: str, known: Any, path: str, value: object) -> None:
    """Raise ModelError for a name that is none of those known."""
    if name not in known:
        words = tuple(known)
        allowed = f"one of {', '.join(words)}"
        raise ModelError(f"no such member{nearest(name, words)}", path=path, given=value, allowed=allowed)
