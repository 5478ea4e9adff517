"""CSV files of force over deflection: read into the tables of the document that name them.

A column of deflections and one of forces, units in the heading; of a mesh one column for each phase, of either or both.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..errors import ModelError
from ..input_files import read_text
from .force_tables import curve_fault
from .tables import PlainTable

__all__ = ["with_files"]

_MAX_BYTES = 4_000_000  # as of a model file
_COLUMNS = ("deflection", "force")
# a word of another spelling is no label: "forces [N]" is refused
_HEADER = re.compile(r"\s*(?P<name>deflection|force)(?:[^A-Za-z\[\]][^\[\]]*)?\[\s*(?P<unit>[^\[\]]+?)\s*\]\s*")
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
    columns = _heading(_cells(heading, separator), name, path, number)
    table = [_numbers(_cells(line, separator), len(columns), name, path, at) for at, line in lines[1:]]
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
    text = read_text(file, most=_MAX_BYTES, path=path, given=name, allowed=allowed)
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1)]
    kept = [(number, line) for number, line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not kept:
        raise ModelError("holds no line", path=path, given=name, allowed=allowed)
    return kept


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]


def _heading(cells: list[str], name: str, path: str, number: int) -> list[tuple[str, str]]:
    """Return key and unit of every column."""
    columns = []
    for cell in cells:
        match = _HEADER.fullmatch(cell)
        if match is None:
            raise ModelError(f"{name}, line {number}: no heading of a column", path=path, given=cell, allowed=_HEADING)
        columns.append((match["name"], match["unit"]))
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
