"""Stability over speed and a second parameter: a value in the model file, or one factor of the assembled train."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from ..analyses.stability.combinations import Combination
from ..analyses.stability.scan import (
    FloquetScan,
    ParametricSystem,
    floquet_scan,
    parametric_system,
    predicted_combinations,
)
from ..analyses.stability.stability import combination_name, combination_names, resonance_columns, scan_warnings
from ..errors import ConvergenceError, ModelError
from ..results.dataset import dataset

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..analyses.steady.response import FrameSpeed
    from ..system.system import System
    from ..train.train import Train

    Source = str | Path | Mapping[str, Any] | Train | System

__all__ = ["FACTORS", "stability_map"]

FACTORS = ("variation", "damping")
"""What is varied without assembling again: the variation of all mesh stiffness, and all damping, by a factor."""

_NUMBER = r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
_UNIT = r"([A-Za-z%°µ].*?)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Row:
    """One value of the parameter; nothing found where it failed."""

    status: str
    ready: ParametricSystem | None = None
    found: FloquetScan | None = None
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
) -> xr.Dataset:
    """Growth rates over mesh frequency and a parameter, with the boundaries that averaging predicts.

    Parameters
    ----------
    path : in the model file, whose train is assembled again for each value, or one of `FACTORS`.
    values : as an override would say them, with units or without.  mesh_frequency : of the first mesh [Hz].
    progress : called with (cells done, cells).

    Raises
    ------
    ModelError : no values, no speeds, or no value that the model takes.
    A value or a speed that fails holds nan, and ``status`` says why.
    """
    if not len(values) or not len(mesh_frequency):
        raise ModelError("nothing to go over", path=path, given=f"{len(values)} values, {len(mesh_frequency)} speeds")
    from .source import system_of

    if path in FACTORS:  # assembled once for all of them
        source, overrides = system_of(source, overrides=overrides), None
    frequency = np.asarray(mesh_frequency, dtype=float)
    rows = []
    for i, value in enumerate(values):
        done = _partly(progress, i * frequency.size, len(values) * frequency.size)
        rows.append(_row(source, {path: value}, overrides or {}, frequency, frame_speed, done))
    if all(row.found is None for row in rows):
        raise ModelError(rows[0].status)
    return _labelled(path, values, frequency, rows, frame_speed)


def _partly(progress: Callable[[int, int], None] | None, before: int, whole: int) -> Callable[[int, int], None] | None:
    return None if progress is None else lambda done, _: progress(before + done, whole)


def _row(
    source: Source,
    here: Mapping[str, Any],
    overrides: Mapping[str, Any],
    frequency: NDArray[np.float64],
    frame_speed: FrameSpeed,
    progress: Callable[[int, int], None] | None,
) -> _Row:
    from .source import system_of

    try:
        ((path, value),) = here.items()
        if path in FACTORS:
            ready = parametric_system(system_of(source), frame_speed=frame_speed, **{path: _factor(path, value)})
        else:
            ready = parametric_system(system_of(source, overrides={**overrides, **here}), frame_speed=frame_speed)
    except (ModelError, ConvergenceError) as error:
        return _Row(status=str(error))
    found = floquet_scan(ready, frequency, progress=progress)
    return _Row(status="ok", ready=ready, found=found, ranges=tuple(predicted_combinations(ready, frequency)))


def _factor(path: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ModelError("not a factor", path=path, given=value, allowed="a number of 0 or more") from None


def _labelled(
    path: str, values: Sequence[Any], frequency: NDArray[np.float64], rows: Sequence[_Row], frame_speed: str
) -> xr.Dataset:
    ready = next(row.ready for row in rows if row.ready is not None)
    several = len(ready.tones) > 1
    found = [row.found for row in rows]
    numbers, unit = _numbers(values)
    status = [
        np.full(frequency.size, row.status, dtype=object) if row.found is None else row.found.status for row in rows
    ]
    kinds = _stacked([None if one is None else one.kind for one in found], np.full(frequency.size, "", dtype=object))
    taking = [
        [""] * frequency.size if row.found is None else combination_names(row.found, row.ranges, frequency, several)
        for row in rows
    ]
    cells, blank = ("value", "speed"), np.full(frequency.size, np.nan)
    result = dataset(
        {
            "largest_multiplier": (cells, _stacked([None if one is None else one.largest for one in found], blank)),
            "growth_rate": (cells, _stacked([None if one is None else one.growth for one in found], blank)),
            "stable": (cells, kinds == "stable"),
            "instability": (cells, kinds),
            "taking_part": (cells, np.array(taking, dtype=object)),
            "status": (cells, np.array(status, dtype=object)),
            **_ranges(rows, several),
        },
        {
            "value": numbers,
            "speed": frequency / float(ready.tones[0]),
            "mesh_frequency": ("speed", frequency),
            "resonance": [combination_name(one, several) for one in _keys(rows)],
        },
        verb="stability",
        options={"over": path, "values": list(values), "frame_speed": frame_speed},
        provenance=ready.system.provenance,
        warnings=[*ready.system.warnings, *_notes(rows)],
        units={"speed": "1", "value": unit},  # speed relative to the operating speed
    )
    return result.assign_attrs(over=path)


def _stacked(rows: Sequence[Any], blank: Any) -> Any:
    return np.array([blank if row is None else row for row in rows], dtype=blank.dtype)


def _numbers(values: Sequence[Any]) -> tuple[Any, str]:
    """Values as numbers with their unit where all are numbers of one unit, else as texts."""
    split = [re.fullmatch(rf"\s*{_NUMBER}\s*{_UNIT}?\s*", str(value)) for value in values]
    units = {part[2] or "" for part in split if part}
    if all(split) and len(units) == 1:
        return [float(part[1]) for part in split if part], units.pop()
    return [str(value) for value in values], ""


def _same(one: Combination) -> tuple[int, int, int, str]:
    return one.first, one.second, one.order, one.stage


def _keys(rows: Sequence[_Row]) -> list[Combination]:
    """One of each combination that grows at any value, by its modes and order, widest first."""
    widest: dict[tuple[int, int, int, str], Combination] = {}
    for one in (one for row in rows for one in row.ranges):
        kept = widest.get(_same(one))
        if kept is None or one.high - one.low > kept.high - kept.low:
            widest[_same(one)] = one
    return sorted(widest.values(), key=lambda one: one.low - one.high)


def _ranges(rows: Sequence[_Row], several: bool) -> dict[str, tuple[Sequence[str], Any]]:
    """Boundaries of every combination at every value, nan where it is closed; of two ranges of one the outer ends."""
    keys = _keys(rows)
    place = {_same(one): i for i, one in enumerate(keys)}
    low, high, rate = (np.full((len(rows), len(keys)), np.nan) for _ in range(3))
    for i, row in enumerate(rows):
        for one in row.ranges:
            j = place[_same(one)]
            low[i, j], high[i, j] = np.fmin(low[i, j], one.low), np.fmax(high[i, j], one.high)
            rate[i, j] = np.fmax(rate[i, j], one.growth)
    dims = ("value", "resonance")
    columns = resonance_columns(keys)
    fixed = {name: values for name, values in columns.items() if name.removeprefix("resonance_") in _FIXED}
    return {"resonance_low": (dims, low), "resonance_high": (dims, high), "resonance_growth": (dims, rate), **fixed}


_FIXED = ("first", "second", "order")


def _notes(rows: Sequence[_Row]) -> list[str]:
    failed = [row.status for row in rows if row.found is None]
    notes = [f"{len(failed)} of {len(rows)} values failed: {failed[0]}"] if failed else []
    cells = [row.found for row in rows if row.found is not None]
    whole = FloquetScan(
        multipliers=np.zeros((0, 0), complex),
        largest=np.concatenate([one.largest for one in cells]),
        growth=np.concatenate([one.growth for one in cells]),
        kind=np.concatenate([one.kind for one in cells]),
        steps=np.concatenate([one.steps for one in cells]),
        status=np.concatenate([one.status for one in cells]),
    )
    return notes + scan_warnings(whole)
