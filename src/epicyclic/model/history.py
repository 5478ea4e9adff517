"""Torque histories: a CSV file with one column of time and one for each member, units in the header."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path

from ..errors import ModelError
from ..input_files import read_text
from .units import COMMON, KINDS, factor

__all__ = ["TorqueTable", "read_history"]

_HEADER = re.compile(r"\s*(?P<name>[^\[\]]+?)\s*\[\s*(?P<unit>[^\[\]]+?)\s*\]\s*")
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
        if match is None:
            raise ModelError("a column needs a name and a unit", path=where, given=cell, allowed="time [s], sun [N m]")
        name, unit = match["name"], match["unit"]
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
