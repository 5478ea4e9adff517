"""CSV files that a document names: forces over deflection, and torques over time.

CSV files of force over deflection: read into the tables of the document that name them.

A column of deflections and one of forces, units in the heading; of a mesh one column for each phase, of either or both.

Torque histories: a CSV file with one column of time and one for each member, units in the header.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import ModelError
from ..input_files import read_text
from .schema_fields import curve_fault
from .tables import PlainTable
from .units import COMMON, KINDS, factor

_MAX_FORCE_BYTES = 4_000_000  # as of a model file
_COLUMNS = ("deflection", "force")
# a word of another spelling is no label: "forces [N]" is refused
_FORCE_HEADER = re.compile(r"(?P<name>deflection|force)(?:[^A-Za-z\[\]][^\[\]]*)?\[(?P<unit>[^\[\]]+)\]")
_HEADING = "deflection [um], force [kN]; of several phases one column each: deflection [um], force 1 [kN], ..."


def with_files(data: PlainTable, folder: Path | None) -> PlainTable:
    """Return a document with the numbers of the CSV files that its tables of force name, in place of the names.

    folder : where the files are looked for.  Raises ModelError with path, file and line.
    """
    parts = ("stages", "bodies", "couplings")
    return {name: _embedded(value, name, folder) if name in parts else value for name, value in data.items()}


def _embedded(value: Any, path: str, folder: Path | None) -> Any:
    if not isinstance(value, dict):
        return value
    if isinstance(name := value.get("file"), str):
        if beside := [column for column in _COLUMNS if column in value]:
            raise ModelError(f"stands beside {beside[0]}", path=f"{path}.file", given=name, allowed="one of the two")
        rest = {other: entry for other, entry in value.items() if other != "file"}
        return {**_columns_of(name, f"{path}.file", folder), **rest}
    return {name: _embedded(entry, f"{path}.{name}", folder) for name, entry in value.items()}


def _columns_of(name: str, path: str, folder: Path | None) -> dict[str, object]:
    """Return deflections and forces of a CSV file as a model file states them. Raises ModelError."""
    lines = _lines(name, path, folder)
    number, heading = lines[0]
    separator = ";" if ";" in heading else ","
    columns = _heading(_cells(heading, separator, f"{path}, {name}, line {number}"), name, path, number)
    table = []
    for at, line in lines[1:]:
        cells = _cells(line, separator, f"{path}, {name}, line {at}")
        table.append(_numbers(cells, len(columns), name, path, at))
    if len(table) < 2:
        raise ModelError(f"{name}: too few rows", path=path, given=len(table), allowed="two or more")
    values = list(zip(*table, strict=True))
    _check_columns(columns, values, [at for at, _ in lines[1:]], name, path)
    found: dict[str, object] = {}
    for key in _COLUMNS:
        mine = [i for i, (own, _) in enumerate(columns) if own == key]
        lists = [f"[{', '.join(values[i])}] {columns[i][1]}" for i in mine]
        found[key] = lists if len(lists) > 1 else lists[0]
    return found


def _lines(name: str, path: str, folder: Path | None) -> list[tuple[int, str]]:
    """Return the lines of a file with their numbers, empty and # lines left out."""
    file = (folder or Path()) / name
    allowed = f"a CSV file beside the model file: {_HEADING}"
    text = read_text(file, most=_MAX_FORCE_BYTES, path=path, given=name, allowed=allowed)
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1)]
    kept = [(number, line) for number, line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not kept:
        raise ModelError("holds no line", path=path, given=name, allowed=allowed)
    return kept


def _heading(cells: list[str], name: str, path: str, number: int) -> list[tuple[str, str]]:
    """Return key and unit of every column."""
    columns = []
    for cell in cells:
        match = _FORCE_HEADER.fullmatch(cell)
        if match is None or not match["unit"].strip():
            raise ModelError(f"{name}, line {number}: no heading of a column", path=path, given=cell, allowed=_HEADING)
        columns.append((match["name"], match["unit"].strip()))
    count = {key: sum(own == key for own, _ in columns) for key in _COLUMNS}
    if not all(count.values()) or (min(count.values()) > 1 and len(set(count.values())) > 1):
        problem = f"{name}, line {number}: {count['deflection']} columns of deflections and {count['force']} of forces"
        raise ModelError(problem, path=path, given=", ".join(cells), allowed=_HEADING)
    return columns


def _numbers(cells: list[str], count: int, name: str, path: str, number: int) -> tuple[str, ...]:
    """Return the cells of one row, each a finite number."""
    where = f"{name}, line {number}"
    if len(cells) != count:
        raise ModelError(
            f"{where}: another number of columns than the heading", path=path, given=len(cells), allowed=str(count)
        )
    for cell in cells:
        try:
            finite = math.isfinite(float(cell))
        except ValueError:
            finite = False
        if not finite or "_" in cell:
            raise ModelError(f"{where}: not a finite number", path=path, given=cell, allowed="a number in every column")
    return tuple(repr(float(cell)) for cell in cells)


def _check_columns(
    columns: Sequence[tuple[str, str]], values: Sequence[Sequence[str]], lines: Sequence[int], name: str, path: str
) -> None:
    """Raise ModelError with the line of a point that no curve may have."""
    places = {key: [i for i, (own, _) in enumerate(columns) if own == key] for key in _COLUMNS}
    for phase in range(max(map(len, places.values()))):
        at = {key: mine[phase if len(mine) > 1 else 0] for key, mine in places.items()}
        x, f = ([float(cell) for cell in values[at[key]]] for key in _COLUMNS)
        if (found := curve_fault(x, f)) is not None:
            key, point, problem, allowed = found
            where = f"{name}, line {lines[point]}, column {at[key] + 1}: {key} {problem}"
            given = f"{values[at[key]][point]} {columns[at[key]][1]}"
            raise ModelError(where, path=path, given=given, allowed=allowed)


_HEADER = re.compile(r"(?P<name>[^\[\]]+)\[(?P<unit>[^\[\]]+)\]")
_MAX_BYTES = 200_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueTable:
    """Rows of a history: time [s], member -> torque [N m], and the line of the file each row stands in."""

    time: tuple[float, ...]
    torque: dict[str, tuple[float, ...]]
    line: tuple[int, ...]


def read_history(path: str | Path) -> TorqueTable:
    """Read ``time [s], sun [N m], ...``, comma or semicolon between, decimal points; empty and # lines are passed over.

    Raises
    ------
    ModelError : no such file, a header without time, names or units, a hole, a text that is no finite number, times
        that do not rise, fewer than two rows; with the number of the line.
    """
    text = read_text(path, most=_MAX_BYTES)
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if _counts(line)]
    if not lines:
        raise ModelError("holds no line", path=str(path), allowed="time [s], sun [N m]")
    header, *rows = lines
    separator = ";" if ";" in header[1] else ","
    columns = _columns(_cells(header[1], separator, f"{path}, line {header[0]}"), f"{path}, line {header[0]}")
    places = [f"{path}, line {number}" for number, _ in rows]
    table = [
        _row(_cells(line, separator, place), columns, place) for (_, line), place in zip(rows, places, strict=True)
    ]
    if len(table) < 2:
        raise ModelError("too few rows", path=str(path), given=len(table), allowed="two or more")
    names = [name for name, _ in columns]
    at = names.index("time")
    for (number, _), before, row in zip(rows[1:], table[:-1], table[1:], strict=True):
        if not row[at] > before[at]:
            raise ModelError(
                "times must rise", path=f"{path}, line {number}", given=row[at], allowed=f"more than {before[at]:g} s"
            )
    values = dict(zip(names, zip(*table, strict=True), strict=True))
    return TorqueTable(time=values.pop("time"), torque=values, line=tuple(number for number, _ in rows))


def _counts(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _cells(line: str, separator: str, where: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]
    except csv.Error as error:  # a cell of more than 131072 characters
        raise ModelError(f"no row of a table: {error}", path=where) from None


def _columns(cells: list[str], where: str) -> list[tuple[str, float]]:
    """Name and factor to SI of every column."""
    found: list[tuple[str, float]] = []
    for cell in cells:
        match = _HEADER.fullmatch(cell)
        name, unit = (match["name"].strip(), match["unit"].strip()) if match else ("", "")
        if not name or not unit:
            raise ModelError("a column needs a name and a unit", path=where, given=cell, allowed="time [s], sun [N m]")
        target = "s" if name == "time" else "N m"
        scale, base = COMMON.get(unit, (0.0, ""))
        scaled = scale if base == target else factor(unit, target)
        if scaled is None:
            raise ModelError("not a unit of " + ("time" if target == "s" else "torque"), path=where, given=cell)
        found.append((name, scaled))
    names = [name for name, _ in found]
    if "time" not in names or len(names) < 2:
        raise ModelError(
            "a history needs a column of time and one of a member", path=where, given=", ".join(names),
            allowed="time [s], sun [N m]",
        )  # fmt: skip
    if len(set(names)) < len(names):
        raise ModelError("a name stands in two columns", path=where, given=", ".join(names))
    return found


def _row(cells: list[str], columns: list[tuple[str, float]], where: str) -> tuple[float, ...]:
    if len(cells) != len(columns):
        raise ModelError(
            "another number of columns than the header", path=where, given=len(cells), allowed=str(len(columns))
        )
    values = []
    for cell, (name, scale) in zip(cells, columns, strict=True):
        if not cell:
            raise ModelError(f"no value of {name}", path=where, allowed="a number in every column")
        try:
            value = float(cell) * scale
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise ModelError(f"{name} is not a finite number", path=where, given=cell)
        limit = KINDS["time" if name == "time" else "torque"]
        if abs(value) > limit.limit:
            raise ModelError(
                f"{name} is out of range", path=where, given=cell, allowed=f"<= {limit.limit:g} {limit.unit}"
            )
        values.append(value)
    return tuple(values)
