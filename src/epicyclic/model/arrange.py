"""The expanded document put in the order of the schema: values by full member path, lists as tuples, tables read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import ModelError
from .names import SIDES, Names, mesh_name, nearest
from .tables import Table
from .units import factor

__all__ = ["arrange"]

STANDARD_GRAVITY = 9.81  # m/s^2
_MEMBER_DEVIATIONS = ("run_out", "bearing_run_out", "position", "tilt", "pitch", "unbalance")


def arrange(data: Table, names: Names, folder: Path | None) -> Table:
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


def _operation(table: Table, names: Names) -> Table:
    """Flatten speeds, torques and powers to full member paths."""
    result: Table = _tuple(table, "held")
    for name in ("speed", "torque", "power"):
        if isinstance(table.get(name), dict):
            result = result | {name: _by_member(table[name], names, f"operation.{name}", sides=name != "speed")}
    if isinstance(gravity := table.get("gravity"), bool):
        result = result | {"gravity": (0.0, -STANDARD_GRAVITY, 0.0) if gravity else None}
    return result


def _by_member(table: Table, names: Names, path: str, *, sides: bool) -> Table:
    """Return {full path: value} of nested stage, member and side tables."""
    flat: Table = {}
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


def _sides(member: str, value: Any, path: str, sides: bool) -> Table:
    """Return {member: value}, or one entry for each side."""
    if not isinstance(value, dict):
        return {member: value}
    for side, entry in value.items():
        if not sides or side not in SIDES:
            raise ModelError("no such side", path=f"{path}.{side}", given=entry, allowed=" or ".join(SIDES))
    return {f"{member}.{side}": entry for side, entry in value.items()}


def _deviations(table: Table, names: Names, folder: Path | None) -> Table:
    """Flatten deviations to full member and mesh paths."""
    members: Table = {}
    meshes: Table = {}
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


def _member_deviations(member: str, value: Any, folder: Path | None, *, gear: bool) -> Table:
    """Return the deviations of a member, and of its sides where it has them, by path."""
    path = f"deviations.{member}"
    table = _table(value, path, f"a table of {', '.join(_MEMBER_DEVIATIONS)}")
    sides = {k: v for k, v in table.items() if gear and k in SIDES}
    own = {k: v for k, v in table.items() if k not in sides}
    result = {member: own} if own or not sides else {}
    result |= {f"{member}.{side}": _table(v, f"{path}.{side}", "a table") for side, v in sides.items()}
    return {k: v | {"pitch": _pitch(v["pitch"], k, folder)} if "pitch" in v else v for k, v in result.items()}


def _mesh_deviations(table: Table, stage: str, names: Names) -> Table:
    """Return the deviations of the meshes of one stage, and of their sides, by path."""
    result: Table = {}
    for name, value in table.items():
        path = f"{stage}.meshes.{name}"
        mesh_name(name, stage, names, path=f"deviations.{path}")
        entry = _table(value, f"deviations.{path}", "a table of profile and gap")
        sides = {k: v for k, v in entry.items() if k in SIDES}
        own = {k: v for k, v in entry.items() if k not in sides}
        result |= ({path: own} if own or not sides else {}) | {f"{path}.{k}": v for k, v in sides.items()}
    return result


def _pitch(value: Any, member: str, folder: Path | None) -> tuple[tuple[float, ...], ...]:
    """Return pitch deviations [m], one tuple per planet or one for all."""
    path = f"deviations.{member}.pitch"
    allowed = "a list [m], a CSV file, or a list of either, one per planet"
    several = isinstance(value, list) and value and all(isinstance(v, (list, str)) for v in value)
    found = tuple(_pitch_one(v, path, allowed, folder) for v in (value if several else [value]))
    return found


def _pitch_one(value: Any, path: str, allowed: str, folder: Path | None) -> tuple[float, ...]:
    """Return one list of pitch deviations [m]."""
    if isinstance(value, str):
        return _read_csv(value, path, folder)
    if not isinstance(value, list) or not value:
        raise ModelError("not a list of pitch deviations", path=path, given=value, allowed=allowed)
    if not all(isinstance(v, (int, float)) and not isinstance(v, bool) and abs(v) < 1 for v in value):
        raise ModelError("not lengths in m", path=path, given=value, allowed="numbers in m, below 1 m")
    return tuple(float(v) for v in value)


def _read_csv(name: str, path: str, folder: Path | None) -> tuple[float, ...]:
    """Return the last column of a CSV file [m]; a heading like `pitch [um]` names its unit."""
    allowed = "a CSV file beside the model file: one tooth a line, heading `pitch [um]` for a unit other than m"
    try:
        lines = ((folder or Path()) / name).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        raise ModelError("cannot be read", path=path, given=name, allowed=allowed) from None
    cells = [line.split(",")[-1].strip() for line in lines if line.strip() and not line.startswith("#")]
    scale: float | None = 1.0
    if cells and cells[0].endswith("]") and "[" in cells[0]:
        scale = factor(cells[0].rpartition("[")[2][:-1].strip(), "m")
        cells = cells[1:]
    try:
        numbers = [float(cell) for cell in cells]
    except ValueError:
        raise ModelError("not a table of numbers", path=path, given=name, allowed=allowed) from None
    if scale is None or not numbers or not all(abs(v * scale) < 1 for v in numbers):
        raise ModelError("not lengths", path=path, given=name, allowed=allowed)
    return tuple(v * scale for v in numbers)


def _table(value: Any, path: str, allowed: str) -> Table:
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
