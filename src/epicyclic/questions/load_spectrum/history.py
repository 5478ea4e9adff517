"""A load history as a person has it, a CSV file, an Excel table or columns, to torque, speed and time of every row."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...document.document import CsvTable, read_sheet, read_table
from ...errors import ModelError
from . import SpectrumOptions

Array = NDArray[np.float64]

_HEADING = "time [s], torque [kN m], speed [rpm]; of bins duration [h], or share [%], in place of the time"
_MOST_BYTES = 1_000_000_000
_USUAL = {"torque": ("torque",), "speed": ("speed",), "time": ("time",), "weight": ("duration", "hours", "share")}
_PARENTHESES = re.compile(r"([^\[\]]*)\(([^()]*)\)")
_SHARES = {"": 1.0, "1": 1.0, "%": 0.01}
_WHOLE = 0.01  # what shares may miss of their sum: rounding of a printed table
_GAP = 10.0  # steps of time
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadHistory:
    """What stands in the rows of a history.

    torque (N,) [N m], speed (N,) [rad/s] : signed.  duration (N,) : time that each row stands for, above 0 [s].
    repeats : how often the history comes in its life.  in_time : whether its rows follow each other.
    """

    torque: Array
    speed: Array
    duration: Array
    repeats: float
    in_time: bool


def read_load_history(source: object, options: SpectrumOptions) -> LoadHistory:
    """Read a history.

    Of a history in time a row stands for half the time since the row before and half of that to the next: sums over
    rows are integrals by the trapezoidal rule.  Of a table of bins it stands for its duration, or share of the life.

    source : a file .csv, .xlsx, or heading with unit -> values.

    Raises
    ------
    ModelError : no such file or column, no unit, a cell that is no finite number, times that do not rise, a gap in
        time, a negative duration, shares that do not sum to 1 or stand without a life; with the line of the file.
    """
    table = _table(source)
    columns = _columns(table, options)
    torque, speed = (np.array(table.quantities(columns[one], one, allowed=_HEADING)) for one in ("torque", "speed"))
    in_time = "time" in columns
    duration = _sampled(table, columns["time"], options.gap) if in_time else _weighed(table, columns["weight"], options)
    if not (whole := float(duration.sum())) > 0:
        raise ModelError("lasts no time", path=table.name, given=f"{whole:g} s", allowed="a duration above 0")
    repeats = 1.0 if options.life is None else options.life / whole
    torque, speed, duration = (values[duration > 0] for values in (torque, speed, duration * repeats))
    return LoadHistory(torque=torque, speed=speed, duration=duration, repeats=repeats, in_time=in_time)


def _table(source: object) -> CsvTable:
    """Cells of a source, units in brackets; columns are counted from line 1 behind their heading."""
    if isinstance(source, Mapping):
        columns = [list(map(str, np.ravel(values).tolist())) for values in source.values()]
        if len({len(column) for column in columns}) != 1:
            raise ModelError("columns of several lengths", path="source", given=list(map(len, columns)), allowed="one")
        heading, rows = list(map(str, source)), list(zip(*columns, strict=True))
        table = CsvTable(name="source", path="", heading=heading, rows=rows, lines=range(len(rows) + 1))
    elif isinstance(source, str | Path):
        read = read_sheet if Path(source).suffix.lower() in (".xlsx", ".xlsm") else read_table
        table = read(source, most=_MOST_BYTES, allowed=_HEADING)
    else:
        raise ModelError("no history", path="source", given=source, allowed="a file .csv or .xlsx, or columns")
    if not table.rows:
        raise ModelError("too few rows", path=table.name, given=0, allowed="one or more below the heading")
    return replace(table, heading=[_PARENTHESES.sub(r"\1[\2]", cell) for cell in table.heading])


def _columns(table: CsvTable, options: SpectrumOptions) -> dict[str, int]:
    """Place of the columns of torque, speed, and of either time or weight."""
    names = [name.lower() for name, _ in table.columns]
    wanted = {role: getattr(options, role) for role in _USUAL}
    found = {
        role: [at for at, one in enumerate(names) if one in ((name.strip().lower(),) if name else _USUAL[role])]
        for role, name in wanted.items()
    }
    needed = {role for role, name in wanted.items() if name} | {"torque", "speed"}
    wrong = [role for role, there in found.items() if len(there) > 1 or (role in needed and not there)]
    if wrong or bool(found["time"]) == bool(found["weight"]):
        problem = f"not one column {wanted[wrong[0]] or wrong[0]!r}" if wrong else "not one column of time or weight"
        raise table.error(table.lines[0], problem, given=", ".join(table.heading), allowed=_HEADING)
    return {role: there[0] for role, there in found.items() if there}


def _sampled(table: CsvTable, column: int, gap: float | None) -> Array:
    """Time of each row of a history in time [s]."""
    time = table.quantities(column, "time", allowed=_HEADING)
    if len(time) < 2:
        raise ModelError("too few rows", path=table.name, given=len(time), allowed="two or more of a history in time")
    table.check_rising(time)
    steps = np.diff(time)
    most = _GAP * float(np.median(steps)) if gap is None else gap
    late = steps > most * (1 + _ROUNDING)
    if late.any():
        at, allowed = int(late.argmax()), f"at most {most:g} s between two rows, or a longer gap"
        raise table.error(table.lines[at + 2], "a gap in time", given=f"{steps[at]:g} s", allowed=allowed)
    whole: Array = (np.append(steps, 0.0) + np.append(0.0, steps)) / 2
    return whole


def _weighed(table: CsvTable, column: int, options: SpectrumOptions) -> Array:
    """Time of each row of a table of bins [s]."""
    name, unit = table.columns[column]
    is_share = unit in _SHARES and (unit != "" or name.lower() == "share")
    values = np.array(table.numbers(column) if is_share else table.quantities(column, "time", allowed=_HEADING))
    if (values < 0).any():
        at = int((values < 0).argmax())
        raise table.error(table.lines[at + 1], f"{name} is negative", given=table.rows[at][column], allowed="0 or more")
    if is_share and abs(values.sum() * _SHARES[unit] - 1) > _WHOLE:
        raise ModelError(
            f"{name} does not sum to 1", path=table.name, given=f"{values.sum():g} {unit}", allowed="1, or 100 %"
        )
    if is_share and options.life is None:
        raise ModelError("is missing: the life that shares are of", path="life", allowed='a time, e.g. "20000 h"')
    return values
