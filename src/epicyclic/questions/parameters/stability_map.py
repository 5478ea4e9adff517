"""Stability maps: Floquet growth rates over mesh frequency and a second parameter, with the averaged boundaries.

The parameter is a value in the model file, or a factor of the assembled train.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from ...engine.plan import require_time
from ...engine.source import Source, system_of
from ...errors import ConvergenceError, ModelError
from ...results.dataset import dataset
from ...warning_codes import CodedText, coded
from ..stability.stability import (
    Combination,
    FloquetScan,
    ParametricSystem,
    combination_name,
    combination_names,
    floquet_scan,
    parametric_system,
    predicted_combinations,
    resonance_columns,
    scan_warnings,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ...engine.run_folder import KeptPart, RunFolder
    from ..response.response import FrameSpeed

FACTORS = ("variation", "damping")
"""Factors of the assembled train: of the variation of every mesh stiffness, and of all damping."""

_NUMBER = r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
_UNIT = r"([A-Za-z%°µ].*?)"
# Variables of a combination that do not depend on the value.
_FIXED = ("resonance_first", "resonance_second", "resonance_order")
# Cells of a map, whose multipliers take 1 kB each, and the time of one, as measured on trains of 30 coordinates [s].
_CELLS, _CELL = 1_000_000, 0.05


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _MapRow:
    """Results at one value of the parameter: the prepared System, its scan over speed, its predicted combinations.

    status : "ok", or why there are none.
    """

    status: str
    ready: ParametricSystem | None = None
    floquet: FloquetScan | None = None
    ranges: tuple[Combination, ...] = ()


def stability_map(
    source: Source,
    path: str,
    values: Sequence[Any],
    mesh_frequency: Sequence[float],
    *,
    overrides: Mapping[str, Any] | None = None,
    frame_speed: FrameSpeed = "kinematic",
    progress: Callable[[int, int], None] | None = None,
    kept: RunFolder | None = None,
) -> xr.Dataset:
    """Growth rates over mesh frequency and a parameter, with the boundaries that averaging predicts.

    A value or a speed that fails holds nan, and ``status`` the reason.

    Parameters
    ----------
    path : in the model file, whose train is assembled again for each value, or one of `FACTORS`.
    values : V values as overrides, with units or without.  mesh_frequency : (P,) of the first mesh [Hz].
    frame_speed : as of `stability`.  progress : called with (cells done, cells).
    kept : keeps the cells that are done.

    Returns
    -------
    Dataset : largest_multiplier [1], growth_rate [1/s], stable, instability, taking_part, status (value, speed), and
        resonance_low, resonance_high [Hz], resonance_growth [1/s] (value, resonance), nan where a range is closed.

    Raises
    ------
    ModelError : no values, no speeds, or no value that the model takes.
    """
    if not len(values) or not len(mesh_frequency):
        raise ModelError("nothing to go over", path=path, given=f"{len(values)} values, {len(mesh_frequency)} speeds")
    cells = len(values) * len(mesh_frequency)
    require_time(
        _CELL * cells,
        _CELL * _CELLS,
        path="value_points, points",
        given=f"{len(values)} values of {len(mesh_frequency)} speeds",
        allowed=f"at most {_CELLS} cells in all",
    )
    if path in FACTORS:  # assembled once for all of them
        source, overrides = system_of(source, overrides=overrides), None
    frequency = np.asarray(mesh_frequency, dtype=float)
    rows = []
    for i, value in enumerate(values):
        share = None if progress is None else partial(_row_progress, progress, i * frequency.size, cells)
        done = None if kept is None else kept.part(f"value {i}")
        rows.append(_row(source, {path: value}, overrides or {}, frequency, frame_speed, share, done))
    if all(row.floquet is None for row in rows):
        raise ModelError(rows[0].status)
    return _labelled(path, values, frequency, rows, frame_speed)


def _row_progress(progress: Callable[[int, int], None], before: int, whole: int, done: int, _: int) -> None:
    """Progress of one row in cells of the whole map."""
    progress(before + done, whole)


def _row(
    source: Source,
    setting: Mapping[str, Any],
    overrides: Mapping[str, Any],
    frequency: NDArray[np.float64],
    frame_speed: FrameSpeed,
    progress: Callable[[int, int], None] | None,
    kept: KeptPart | None,
) -> _MapRow:
    """Growth rates (P,) and predicted combinations at one value, setting : path -> value."""
    try:
        ((path, value),) = setting.items()
        if path in FACTORS:
            ready = parametric_system(system_of(source), frame_speed=frame_speed, **{path: _factor(path, value)})
        else:
            ready = parametric_system(system_of(source, overrides={**overrides, **setting}), frame_speed=frame_speed)
    except (ModelError, ConvergenceError) as error:
        return _MapRow(status=str(error))
    floquet = floquet_scan(ready, frequency, progress=progress, kept=kept)
    return _MapRow(status="ok", ready=ready, floquet=floquet, ranges=tuple(predicted_combinations(ready, frequency)))


def _factor(path: str, value: Any) -> float:
    """Factor [1] of variation or damping, refused where it is no number."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ModelError("not a factor", path=path, given=value, allowed="a number of 0 or more") from None


def _labelled(
    path: str, values: Sequence[Any], frequency: NDArray[np.float64], rows: Sequence[_MapRow], frame_speed: str
) -> xr.Dataset:
    """Dataset of the map: V values, frequency : (P,) of the first mesh [Hz], rows : one a value."""
    ready = next(row.ready for row in rows if row.ready is not None)
    several = len(ready.tones) > 1
    scans = [row.floquet for row in rows]
    numbers, unit = _value_axis(values)
    status = [
        np.full(frequency.size, row.status, dtype=object) if row.floquet is None else row.floquet.status for row in rows
    ]
    unknown = np.full(frequency.size, "", dtype=object)
    kinds = _stacked([None if scan is None else scan.kind for scan in scans], unknown)
    names = [
        [""] * frequency.size if row.floquet is None else combination_names(row.floquet, row.ranges, frequency, several)
        for row in rows
    ]
    cells, blank = ("value", "speed"), np.full(frequency.size, np.nan)
    result = dataset(
        {
            "largest_multiplier": (cells, _stacked([None if scan is None else scan.largest for scan in scans], blank)),
            "growth_rate": (cells, _stacked([None if scan is None else scan.growth for scan in scans], blank)),
            "stable": (cells, kinds == "stable"),
            "instability": (cells, kinds),
            "taking_part": (cells, np.array(names, dtype=object)),
            "status": (cells, np.array(status, dtype=object)),
            **_resonance_ranges(rows),
        },
        {
            "value": numbers,
            "speed": frequency / float(ready.tones[0]),
            "mesh_frequency": ("speed", frequency),
            "resonance": [combination_name(combination, several) for combination in _widest_combinations(rows)],
        },
        verb="stability",
        options={"over": path, "values": list(values), "frame_speed": frame_speed},
        provenance=ready.system.provenance,
        warnings=[*ready.system.warnings, *_warnings(rows)],
        units={"speed": "1", "value": unit},  # speed relative to the operating speed
    )
    return result.assign_attrs(over=path)


def _stacked(rows: Sequence[Any], blank: Any) -> Any:
    """Rows (P,) as (V, P), `blank` in place of a row that failed."""
    return np.array([blank if row is None else row for row in rows], dtype=blank.dtype)


def _value_axis(values: Sequence[Any]) -> tuple[Any, str]:
    """Coordinate of the values and its unit: numbers where all have one unit, else texts."""
    split = [re.fullmatch(rf"\s*{_NUMBER}\s*{_UNIT}?\s*", str(value)) for value in values]
    units = {part[2] or "" for part in split if part}
    if all(split) and len(units) == 1:
        return [float(part[1]) for part in split if part], units.pop()
    return [str(value) for value in values], ""


def _identity(combination: Combination) -> tuple[int, int, int, str]:
    """Modes, order and stage, by which combinations at different values are one."""
    return combination.first, combination.second, combination.order, combination.stage


def _widest_combinations(rows: Sequence[_MapRow]) -> list[Combination]:
    """Every combination that grows at any value, at the value of its widest range, widest first."""
    widest: dict[tuple[int, int, int, str], Combination] = {}
    for combination in (combination for row in rows for combination in row.ranges):
        kept = widest.setdefault(_identity(combination), combination)
        if combination.high - combination.low > kept.high - kept.low:
            widest[_identity(combination)] = combination
    return sorted(widest.values(), key=lambda combination: combination.low - combination.high)


def _resonance_ranges(rows: Sequence[_MapRow]) -> dict[str, tuple[Sequence[str], Any]]:
    """Boundaries [Hz] and growth rates [1/s] of C combinations (V, C), nan where a range is closed.

    Where a combination has two ranges, these are their outer ends.
    """
    combinations = _widest_combinations(rows)
    column = {_identity(combination): j for j, combination in enumerate(combinations)}
    low, high, rate = (np.full((len(rows), len(combinations)), np.nan) for _ in range(3))
    for i, row in enumerate(rows):
        for combination in row.ranges:
            j = column[_identity(combination)]
            low[i, j], high[i, j] = np.fmin(low[i, j], combination.low), np.fmax(high[i, j], combination.high)
            rate[i, j] = np.fmax(rate[i, j], combination.growth)
    dims = ("value", "resonance")
    fixed = {name: values for name, values in resonance_columns(combinations).items() if name in _FIXED}
    return {"resonance_low": (dims, low), "resonance_high": (dims, high), "resonance_growth": (dims, rate), **fixed}


def _warnings(rows: Sequence[_MapRow]) -> list[CodedText]:
    """Number of failed values, and the warnings of all scans as of one."""
    failed = [row.status for row in rows if row.floquet is None]
    messages = [coded("points-failed", f"{len(failed)} of {len(rows)} values failed: {failed[0]}")] if failed else []
    scans = [row.floquet for row in rows if row.floquet is not None]
    whole = FloquetScan(
        multipliers=np.zeros((0, 0), complex),
        largest=np.concatenate([scan.largest for scan in scans]),
        growth=np.concatenate([scan.growth for scan in scans]),
        kind=np.concatenate([scan.kind for scan in scans]),
        steps=np.concatenate([scan.steps for scan in scans]),
        status=np.concatenate([scan.status for scan in scans]),
        alone=np.concatenate([scan.alone for scan in scans]),
    )
    return messages + scan_warnings(whole)
