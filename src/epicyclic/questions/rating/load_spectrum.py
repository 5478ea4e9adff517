"""A history of torque and speed as load cases: a CSV file, an Excel table or columns, as a person has them.

The load spectrum is time, revolutions and equivalent torque in bins of signed torque and speed, and rainflow of the
torque.  Damage is by Miner's rule with one exponent of the torque: n cycles of T count as n |T|^p.  The equivalent
torque of a bin does with its cycles the damage of all its rows,

    T_eq = (sum n_i |T_i|^p / sum n_i)^(1/p)

with the sign of the bin and n_i the revolutions of a row; its time where the bin does not turn.  p = 6.61 is that of
pitting of case-carburised and of through-hardened flanks, half the exponent 13.22 of the stress, whose square goes with
the load [iso63366]; p = 3 of ball, 10/3 of roller bearings [iso281].  Cycles of the torque are counted by rainflow,
full and half ones [astm1985, 5.4.4].
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.document import CsvTable, read_sheet, read_table
from ...document.schema import collect, reference
from ...document.tables import nested
from ...document.units import COMMON, shown
from ...document.writer import fragment_text, quantity_text
from ...errors import ModelError
from ...results.dataset import dataset
from ...system.assembly import train_provenance
from ...train.train import Train
from . import Bins, SpectrumOptions

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
    return np.asarray((np.append(steps, 0.0) + np.append(0.0, steps)) / 2)


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


RPM = COMMON["rpm"][0]
Columns = dict[str, tuple[Any, Any]]  # name -> dims and values
Speeds = dict[str, tuple[float, float]]  # member -> speed in the housing and in the frame of its stage
_LEAST_RANGE = 0.2  # of the largest value, that is cut into bins: a speed that hardly varies is one bin, or two
_MOST_BINS = 1000
_NOTHING = 1e-100  # a width of bins that is none


def load_spectrum(history: LoadHistory, train: Train | None, options: SpectrumOptions) -> xr.Dataset:
    """Load cases of a history, turns of the members, and cycles of the torque where its rows follow each other.

    train : whose members turn with the member of the options; None for that member alone.

    Returns
    -------
    Dataset : of each bin that holds time (case), by torque and speed rising: case_torque, case_speed, ...;
        edges of the bins; of each member its turns; of each range and mean (cycle) its count.

    Raises
    ------
    ModelError : edges that do not reach all values; no such member, or the speeds of the others do not follow from it.
    """
    name = options.member or ""
    member, speeds = (name, {name: (1.0, 1.0)}) if train is None else _speeds(train, name)
    torque_edge = bin_edges(history.torque, options.torque_bins, "torque_bins")
    rates = options.speed_bins if isinstance(options.speed_bins, int) else [edge / RPM for edge in options.speed_bins]
    speed_edge = bin_edges(history.speed / RPM, rates, "speed_bins")
    columns = _cases(history, torque_edge, speed_edge, options.exponent) | _turns(history, speeds)
    if history.in_time:
        columns |= _cycles(history, options.exponent)
    cases = columns["torque_bin"][1].size
    names = [f"bin_{place:0{max(2, len(str(cases)))}d}" for place in range(1, cases + 1)]
    given = {one.name: getattr(options, one.name) for one in fields(options) if one.name != "train"}
    about = {"history_member": member, **({} if train is None else train_provenance(train))}
    edges = {"torque_edge": torque_edge, "speed_edge": speed_edge}
    labels: dict[Any, Any] = {"case": names, "member": list(speeds), **edges}
    return dataset(columns, labels, verb="spectrum", options=given, provenance=about)


def equivalent(size: Array, weight: Array, exponent: float, case: NDArray[np.int64], cases: int) -> Array:
    """Equivalent value (sum w x^p / sum w)^(1/p) of the sizes x (N,) >= 0 in each case, (cases,).

    weight : (N,) w, 0 or more, not all 0 in a case.  case : (N,) which each is of.
    """
    top = np.zeros(cases)
    np.maximum.at(top, case, size)
    relative = np.divide(size, top[case], out=np.zeros_like(size), where=top[case] > 0)  # powers stay within a float
    sums = np.bincount(case, weight * relative**exponent, cases) / np.bincount(case, weight, cases)
    return top * sums ** (1 / exponent)


def bin_edges(values: Array, bins: Bins, path: str) -> Array:
    """Edges of bins of values (N,), rising; zero is one of them where values of both signs are.

    bins : about how many, of one width, 1, 2 or 5 times a power of ten; or edges.

    Raises
    ------
    ModelError : edges that do not reach all values, another number of bins than 1 to 1000.
    """
    low, high = float(values.min()), float(values.max())
    if not isinstance(bins, int):
        edges = np.unique([*bins, 0.0] if len(bins) and min(bins) < 0 < max(bins) else bins)
        if len(edges) < 2 or low < edges[0] - _near(edges) or high > edges[-1] + _near(edges):
            allowed = f"edges from {low:.6g} or less to {high:.6g} or more"
            raise ModelError("do not reach all values", path=path, given=f"{edges.tolist()}", allowed=allowed)
        return edges
    if not 1 <= bins <= _MOST_BINS:
        raise ModelError("out of range", path=path, given=bins, allowed=f"1 to {_MOST_BINS}, or edges")
    least = max(high - low, _LEAST_RANGE * max(-low, high)) / bins
    least = least if least > _NOTHING else 1.0
    power = 10.0 ** np.floor(np.log10(least))
    step = power * min(one for one in (1, 2, 5, 10) if one * power >= least * (1 - _ROUNDING))
    first = np.floor(low / step + _ROUNDING)
    return np.asarray(step * np.arange(first, max(np.ceil(high / step - _ROUNDING), first + 1) + 1))


def _near(edges: Array) -> float:
    return _ROUNDING * float(np.abs(edges).max())


def _bins(values: Array, edges: Array) -> NDArray[np.int64]:
    """Which bin each value is in, (N,): its lower edge belongs to it, of the last one the upper edge too."""
    found = np.searchsorted(edges, values + _near(edges), side="right") - 1
    return np.clip(found, 0, len(edges) - 2)


def _cases(history: LoadHistory, torque_edge: Array, speed_edge: Array, exponent: float) -> Columns:
    """What is in every bin that holds time; torque_edge [N m], speed_edge [rpm]."""
    torque, speed, duration = history.torque, history.speed / RPM, history.duration
    columns = len(speed_edge) - 1
    place, case = np.unique(_bins(torque, torque_edge) * columns + _bins(speed, speed_edge), return_inverse=True)
    turns, cases = np.abs(speed) * duration / 60, len(place)
    each = (duration, turns, speed * duration)
    time, revolutions, way = (np.bincount(case, one, cases).astype(np.float64) for one in each)
    weight = np.where(revolutions[case] > 0, turns, duration)
    size = equivalent(np.abs(torque), weight, exponent, case, cases)
    counted = revolutions if revolutions.any() else time
    whole = equivalent(size, counted, exponent, np.zeros_like(place), 1)[0]
    damage = counted * (size / (whole or 1.0)) ** exponent
    return {
        "case_torque": ("case", np.where(torque_edge[place // columns + 1] <= _near(torque_edge), -size, size)),
        "case_speed": ("case", way / time),
        "case_hours": ("case", time / 3600),
        "case_share": ("case", time / time.sum()),
        "case_revolutions": ("case", revolutions),
        "case_damage": ("case", damage / (damage.sum() or 1.0)),
        "torque_bin": ("case", place // columns),
        "speed_bin": ("case", place % columns),
        "equivalent_torque": ((), whole),
    }


def _turns(history: LoadHistory, speeds: Speeds) -> Columns:
    """Speeds, revolutions and hours of members by their speeds per speed of that of the history."""
    housing, frame = np.array(list(speeds.values())).T
    turns = float(np.abs(history.speed) @ history.duration) / (2 * np.pi)
    hours = float(history.duration[history.speed != 0].sum()) / 3600
    return {
        "member_speed_ratio": ("member", housing),
        "member_revolutions": ("member", turns * np.abs(housing)),
        "member_frame_revolutions": ("member", turns * np.abs(frame)),
        "member_hours": ("member", hours * (frame != 0)),
    }


def _speeds(train: Train, name: str) -> tuple[str, Speeds]:
    """Path of a member, and speeds of every member per speed of it: a carrier has that in the housing in both."""
    names, kinematics = collect(dict(train.document)), train.kinematics
    if not name:
        problem = "is missing: it says whose torque and speed the history has"
        raise ModelError(problem, path="member", allowed=", ".join(names.members))
    member = reference(name.removeprefix("stages."), names, path="member", sides=False)
    if len(kinematics.freedoms) != 1:
        free = ", ".join(kinematics.freedoms)
        raise ModelError("several speeds are free", path="train", given=free, allowed="a train where one decides all")
    speed = {one: ratio[kinematics.freedoms[0]] for one, ratio in kinematics.ratio.items()}
    if not speed[member]:
        raise ModelError("does not turn", path="member", given=name, allowed="a member whose speed decides all")
    carriers = {frame.name: frame.carrier for frame in train.frames}
    around = {body.member: speed.get(carriers.get(body.frame) or "", 0) for body in train.bodies}
    own = around | dict.fromkeys(filter(None, carriers.values()), 0)
    per = {one: (rate / speed[member], (rate - own.get(one, 0)) / speed[member]) for one, rate in speed.items()}
    return member, {one: (float(housing), float(frame)) for one, (housing, frame) in per.items()}


def _cycles(history: LoadHistory, exponent: float) -> Columns:
    """Ranges and means of the torque by rainflow with their counts, the largest range first, equal ones together."""
    import rainflow

    series = history.torque.tolist()
    series = series if len(series) > 2 else [series[0], *series]  # the package sees no reversal in two values
    cycles = [cycle[:3] for cycle in rainflow.extract_cycles(series) if cycle[0]]
    found = np.array(cycles, dtype=np.float64).reshape(-1, 3)
    pairs, place = np.unique(found[:, 0] + 1j * found[:, 1], return_inverse=True)
    size, mean = pairs.real[::-1].copy(), pairs.imag[::-1].copy()
    count = history.repeats * np.bincount(place, found[:, 2], len(pairs))[::-1].astype(np.float64)
    one = np.zeros(len(pairs), dtype=np.int64)
    return {
        "cycle_range": ("cycle", size),
        "cycle_mean": ("cycle", mean),
        "cycle_count": ("cycle", count),
        "equivalent_range": ((), equivalent(size, count, exponent, one, 1)[0] if len(pairs) else 0.0),
    }


def cases_text(result: xr.Dataset) -> str:
    """Load cases of a result as tables ``[cases.NAME]`` of a model file: speed, torque and duration of the member.

    Raises
    ------
    ModelError : the result names no member.
    """
    member = str(result.attrs["history_member"])
    if not member:
        problem = "is missing: it says whose torque and speed the load cases have"
        raise ModelError(problem, path="member", allowed="a member of the model, e.g. main.carrier")
    path, cases, comments = tuple(member.split(".")), dict[str, Mapping[str, Any]](), dict[str, str]()
    for case in map(str, result["case"].values):
        row = {str(name): float(one) for name, one in result.sel(case=case).data_vars.items() if not one.ndim}
        time = f"{_short(row['case_hours'])} h" if row["case_hours"] >= 1 else f"{_short(3600 * row['case_hours'])} s"
        speed, torque = f"{_short(row['case_speed'])} rpm", quantity_text(float(_short(row["case_torque"])), "torque")
        cases[case] = {"speed": nested(path, speed), "torque": nested(path, torque), "duration": time}
        comments[f"cases.{case}"] = f"{row['case_share']:.2%} of the time, {row['case_damage']:.2%} of the damage"
    exponent = json.loads(result.attrs["options"])["exponent"]
    head = f"Load cases of {member} by epicyclic spectrum; torque equivalent by the exponent {exponent:g}."
    return fragment_text({"cases": cases}, head=(head,), comments=comments)


def _short(value: float) -> str:
    """A number in seven digits, without an exponent where a person would write none."""
    return shown(float(f"{value:.7g}"))
