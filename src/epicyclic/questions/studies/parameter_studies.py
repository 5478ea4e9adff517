"""What a number of the model file moves: loci of natural frequencies, the map of instability, and any quantity.

The parameter is a value in the model file, or a factor of the assembled train.

Mode tracking: loci of the natural frequencies along a parameter, crossings and veerings.  Where two loci approach, a
crossing and a veering differ in the coupling of the two modes [perkins1986, lin2001, dubois2011]; `questions.modes`
follows the modes and finds these events.

Stability maps: Floquet growth rates over mesh frequency and a second parameter, with the averaged boundaries.

`vary` takes any path and any quantity; load sharing over support stiffness and run-out has its points on several cores.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.units import written
from ...engine.plan import require_time
from ...engine.source import Source, system_of
from ...engine.workers import each
from ...errors import ConvergenceError, ModelError
from ...results.dataset import dataset
from ...statics.tangent import flank_warnings, linear
from ...system.assembly import assemble, train_provenance
from ...system.system import System
from ...train.resolution import load
from ...train.train import Train
from ...user_input import checked
from ...warning_codes import CodedText, coded
from ..modes.campbell import LocusEvent, ModeSet, locus_events, repeated_loci, track_modes
from ..modes.eigen import classify_modes, eigen
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
from .derivatives import Parameter, parameter_at

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from ...engine.run_folder import KeptPart, RunFolder
    from ...system.system import System
    from ...train.train import Train
    from ..response.response import FrameSpeed

Array = NDArray[np.float64]
# Ratio of the limits above which the first values lie in equal ratios.
_WIDE_RANGE = 10


def track(
    train: Train,
    *,
    over: str,
    start: str | float | None = None,
    stop: str | float | None = None,
    points: int = 41,
    modes: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Loci of the natural frequencies along one number of the model file, with their crossings and veerings.

    Parameters
    ----------
    over : path of the number, ``PATH[2]`` for one entry of a list.
    start, stop : values as the file writes them ("1e8 N/m"), or numbers in the unit written there; None: half and
        twice the value.
    points : initial values; more are inserted where shapes change quickly, cross or veer.
    modes : number of loci in the result, from the lowest at the start; None: all.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : frequency [Hz] (mode, parameter), mode_kind and multiplicity (mode) at the start, and event_kind,
        event_value, event_frequency [Hz], event_gap [Hz], coupling_factor, veering_index [1] (event): crossings of
        uncoupled shapes, and veerings [dubois2011].

    Raises
    ------
    ModelError : a path that is not there or no number, an empty range, a value the model cannot have.
    """
    parameter = parameter_at(train, over)
    low, high = _limits(parameter, start, stop)
    first = _system(train, parameter, low)
    assembled = [0]

    @cache
    def system(value: float) -> System:
        assembled[0] += 1
        if progress is not None:
            progress(min(0.95, assembled[0] / (4 * points)))
        return _system(train, parameter, value)

    def modes_at(value: float) -> ModeSet:
        here = system(value)
        if here.dofs.names != first.dofs.names:
            raise ModelError("another number of motions at this value", path=over, given=value)
        solved = eigen(here)
        return ModeSet(value=value, omega_squared=solved.omega_squared, vectors=solved.vectors, M=here.M)

    def matrix_derivatives(value: float) -> tuple[Array, Array]:
        """Derivatives (n, n) of mean stiffness and mass along the parameter, by central differences."""
        step = 1e-4 * (high - low)
        above, below = system(value + step), system(value - step)
        stiffness, mass = above.mean_stiffness - below.mean_stiffness, above.M - below.M
        return stiffness / (2 * step), mass / (2 * step)

    loci = track_modes(modes_at, _initial_values(low, high, points))
    crossings_and_veerings = locus_events(loci, matrix_derivatives)
    start_modes = modes_at(low)
    kinds = classify_modes(first, start_modes.omega_squared, start_modes.vectors).kind
    return _labelled(train, parameter, loci, crossings_and_veerings, kinds, modes or len(kinds))


def _initial_values(low: float, high: float, points: int) -> list[float]:
    """Values from `low` to `high`, evenly spaced, over a wide range in equal ratios."""
    wide = low * high > 0 and max(low / high, high / low) > _WIDE_RANGE
    spaced = np.geomspace(low, high, points) if wide else np.linspace(low, high, points)
    return [low, *spaced[1:-1].tolist(), high]


def _system(train: Train, parameter: Parameter, value: float) -> System:
    """Linearised System with the parameter at a value."""
    return linear(assemble(load(train.document, overrides=parameter.at(value))), asks_laws=True)


def _limits(parameter: Parameter, start: str | float | None, stop: str | float | None) -> tuple[float, float]:
    """Limits of the range, in the unit of the file; half and twice the value where not given."""
    if parameter.value == 0 and (start is None or stop is None):
        raise ModelError("the value is 0: say from where to where", path="start, stop", allowed="two values")
    low = parameter.value / 2 if start is None else _read(start, parameter, "start")
    high = parameter.value * 2 if stop is None else _read(stop, parameter, "stop")
    if not np.isfinite(high - low) or high == low:
        raise ModelError(
            "the range is empty", path="start, stop", given=f"{low:g} to {high:g}", allowed="two values that differ"
        )
    return low, high


def _read(text: str | float, parameter: Parameter, option: str) -> float:
    """Limit in the unit of the parameter, from a number or a text in that unit.

    Raises
    ------
    ModelError : no single number, or another unit.
    """
    number = written(float(text) if isinstance(text, (int, float)) else text)
    if number is None and isinstance(text, str):
        with suppress(ValueError):
            number = written(float(text))
    if isinstance(text, str) and number is not None and not number.unit and parameter.unit and number.values != (0.0,):
        raise ModelError(f'a number without a unit: "{text} {parameter.unit}"?', path=option, given=text)
    if number is None or number.many or number.unit not in ("", parameter.unit):
        unit = f" in {parameter.unit}, as the file says it" if parameter.unit else " without a unit"
        raise ModelError("not a value of this parameter", path=option, given=text, allowed=f"a number{unit}")
    return number.values[0]


def _labelled(
    train: Train,
    parameter: Parameter,
    loci: list[ModeSet],
    events: list[LocusEvent],
    kinds: tuple[str, ...],
    modes: int,
) -> xr.Dataset:
    """Dataset of the lowest loci and of the events among them; kinds : (n,) of the modes at the start."""
    squared = np.array([state.omega_squared for state in loci])
    hertz = np.sqrt(squared).T / (2 * np.pi)
    multiplicity = {i: len(group) for group in repeated_loci(squared) for i in group}
    values = np.array([state.value for state in loci])
    events = [event for event in events if min(event.first) < modes and min(event.second) < modes]
    event_hertz = np.array([np.sqrt(event.omega_squared) / (2 * np.pi) for event in events])
    # hertz from a difference of omega^2: it is 8 pi^2 f times that of f
    event_gap = np.array([event.gap for event in events]) / (8 * np.pi**2 * np.where(event_hertz > 0, event_hertz, 1))
    columns: dict[str, tuple[str, Any]] = {
        "event_kind": ("event", np.array([event.kind for event in events], object)),
        "event_value": ("event", np.array([event.value for event in events])),
        "event_frequency": ("event", event_hertz),
        "event_first": ("event", np.array([_mode_numbers(event.first) for event in events], object)),
        "event_second": ("event", np.array([_mode_numbers(event.second) for event in events], object)),
        "event_gap": ("event", event_gap),
        "coupling_factor": ("event", np.array([abs(e.coupling * e.value) / (2 * e.omega_squared) for e in events])),
        "veering_index": ("event", np.array([event.index for event in events])),
    }
    return dataset(
        {
            "frequency": (("mode", "parameter"), hertz[:modes]),
            "mode_kind": ("mode", np.array(kinds[:modes], object)),
            "multiplicity": ("mode", np.array([multiplicity[i] for i in range(len(kinds))][:modes])),
            **columns,
        },
        {"mode": np.arange(1, len(kinds) + 1)[:modes], "parameter": values, "event": np.arange(1, len(events) + 1)},
        verb="track",
        options={"over": parameter.path, "value": parameter.value, "unit": parameter.unit},
        provenance=train_provenance(train),
        # of the tangents at the value of the file; along the parameter they are taken anew
        warnings=[*train.warnings, *flank_warnings(assemble(train))],
        units={"parameter": parameter.unit or "SI", "event_value": parameter.unit or "SI"},
    )


def _mode_numbers(loci: tuple[int, ...]) -> str:
    """Numbers of the modes at the start, from 1: ``4, 5``."""
    return ", ".join(str(i + 1) for i in loci)


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
        rows.append(_row(source, path, value, overrides or {}, frequency, frame_speed, share, done))
    if all(row.floquet is None for row in rows):
        raise ModelError(rows[0].status)
    return _labelled_map(path, values, frequency, rows, frame_speed)


def _row_progress(progress: Callable[[int, int], None], before: int, whole: int, done: int, _: int) -> None:
    """Progress of one row in cells of the whole map."""
    progress(before + done, whole)


def _row(
    source: Source,
    path: str,
    value: Any,
    overrides: Mapping[str, Any],
    frequency: NDArray[np.float64],
    frame_speed: FrameSpeed,
    progress: Callable[[int, int], None] | None,
    kept: KeptPart | None,
) -> _MapRow:
    """Growth rates (P,) and predicted combinations at one value of the path."""
    try:
        if path in FACTORS:
            ready = parametric_system(system_of(source), frame_speed=frame_speed, **{path: _factor(path, value)})
        else:
            ready = parametric_system(system_of(source, overrides={**overrides, path: value}), frame_speed=frame_speed)
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


def _labelled_map(
    path: str, values: Sequence[Any], frequency: NDArray[np.float64], rows: Sequence[_MapRow], frame_speed: str
) -> xr.Dataset:
    """Dataset of the map: V values, frequency : (P,) of the first mesh [Hz], rows : one a value."""
    ready = next(row.ready for row in rows if row.ready is not None)
    several = len(ready.tones) > 1
    numbers, unit = _value_axis(values)
    status = [
        np.full(frequency.size, row.status, dtype=object) if row.floquet is None else row.floquet.status for row in rows
    ]
    unknown = np.full(frequency.size, "", dtype=object)
    kinds = _stacked(rows, "kind", unknown)
    names = [
        [""] * frequency.size if row.floquet is None else combination_names(row.floquet, row.ranges, frequency, several)
        for row in rows
    ]
    cells, blank = ("value", "speed"), np.full(frequency.size, np.nan)
    result = dataset(
        {
            "largest_multiplier": (cells, _stacked(rows, "largest", blank)),
            "growth_rate": (cells, _stacked(rows, "growth", blank)),
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


def _stacked(rows: Sequence[_MapRow], name: str, blank: Any) -> Any:
    """One array (P,) of the scans as (V, P), `blank` in place of a row that failed."""
    return np.array([blank if row.floquet is None else getattr(row.floquet, name) for row in rows], dtype=blank.dtype)


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


Progress = Callable[[float], None] | None
# Mesh cycles of a record where links or meshes have laws, each instant of which is an equilibrium of its own.
_CYCLES = 64


def largest_sharing(system: System) -> float:
    """Load-sharing coefficient of the train [1] by the first definition of `sharing`, peak per mesh cycle."""
    from ..sharing.sharing import sharing

    return float(sharing(system).system_load_sharing[0])


def worst_sharing(system: System) -> float:
    """Static load-sharing coefficient of the train [1], peaks per mesh cycle, worst case over the hunting period.

    To keep a study of many points short, several varying mesh frequencies are replaced by the mean stiffness, and
    where links or meshes have laws the coefficient is the largest of 64 mesh cycles.
    """
    from ..sharing.sharing import sharing

    varying = {int(tone) for tone, row in zip(system.meshes.tone, system.meshes.variation, strict=True) if row.any()}
    if len(varying) > 1:
        far = None if system.far is None else replace(system.far, variation=system.far.variation[:, :0])
        system = replace(system, meshes=replace(system.meshes, variation=system.meshes.variation[:, :0]), far=far)
    lawful = _has_laws(system)
    coefficients = sharing(system, method="static", cycles=_CYCLES if lawful else 1).system_load_sharing
    return float(coefficients.sel(definition="cycle-peak" if lawful else "worst-case"))


@checked
def vary(
    source: str | Path | Mapping[str, Any],
    path_values: Mapping[str, Sequence[Any]],
    *,
    quantity: Callable[[System], float] = largest_sharing,
    overrides: Mapping[str, Any] | None = None,
    unit: str = "1",
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """A quantity of the System over values in the model file; several paths take their values together.

    A point that fails holds nan, its ``status`` the message; the other points are computed.

    Parameters
    ----------
    source, overrides : as of `load`; the model file that the values override.
    path_values : path in the file -> its value at each of P points.
    quantity : function of the System of each point.  unit : of its value.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : quantity (point), status (point) ("ok" or the message); the values as coordinates named by their paths.

    Raises
    ------
    ModelError : no path, or not the same number of values for every path.
    """
    counts = {path: len(values) for path, values in path_values.items()}
    if len(set(counts.values())) != 1:
        raise ModelError("needs the same number of values for each path", path="path_values", given=counts)
    count = next(iter(counts.values()))
    quantities, status = np.full(count, np.nan), np.full(count, "ok", dtype=object)
    for point in range(count):
        values = {path: values[point] for path, values in path_values.items()}
        try:
            quantities[point] = _evaluate(source, {**(overrides or {}), **values}, quantity)
        except (ModelError, ConvergenceError) as error:
            status[point] = str(error)
        if progress is not None:
            progress((point + 1) / count)
    return dataset(
        {"quantity": ("point", quantities), "status": ("point", status)},
        coords={"point": np.arange(count), **{path: ("point", list(values)) for path, values in path_values.items()}},
        verb="vary",
        options={"paths": list(path_values), "overrides": dict(overrides or {})},
        units={"quantity": unit},
        warnings=[coded("points-failed", f"{int(np.sum(status != 'ok'))} of {count} points failed")]
        if np.any(status != "ok")
        else (),
    )


def _evaluate(
    source: str | Path | Mapping[str, Any], overrides: Mapping[str, Any], quantity: Callable[[System], float]
) -> float:
    from ...train.resolution import load

    return float(quantity(assemble(load(source, overrides=overrides))))


def support_study(train: Train, *, points: int = 9, progress: Progress = None) -> xr.Dataset:
    """Static load sharing over the lateral support stiffness of one member after the other.

    Parameters
    ----------
    points : stiffnesses in equal ratios, from a thirtieth of the smallest given to ten times the largest.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : system_load_sharing [1] and status (member, support_stiffness [N/m]); the other members as drawn.

    Raises
    ------
    ModelError : no member has an elastic lateral support, or no point could be computed.
    """
    given = {
        link.path: link.stiffness[0]
        for link in train.links
        if link.kind == "support" and np.isfinite(link.stiffness[:2]).all() and min(link.stiffness[:2]) > 0
    }
    if not given:
        raise ModelError("no member has an elastic lateral support", path="stages", allowed="support.radial")
    values = np.geomspace(min(given.values()) / 30, max(given.values()) * 10, points)
    changes = {path: (f"{path}.x", f"{path}.y") for path in given}
    return _sharing_study(
        train, changes, values, ("support_stiffness", "Load sharing over lateral support stiffness"), progress
    )


def run_out_study(train: Train, *, points: int = 5, progress: Progress = None) -> xr.Dataset:
    """Static load sharing over the run-out of one member after the other.

    Parameters
    ----------
    points : run-outs, evenly spaced from zero to four times the largest given.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : system_load_sharing [1] and status (member, run_out [um]); the other members as drawn.

    Raises
    ------
    ModelError : the model has no run-out, or no point could be computed.
    """
    given = {d.path: float(np.abs(d.vector[:2]).max()) for d in train.displacements if d.cause == "run_out"}
    if not given:
        raise ModelError("no member has a run-out", path="deviations", allowed='run_out = "20 um"')
    values = np.linspace(0.0, 4 * max(given.values()), points)
    changes = {path: (path,) for path in given}
    result = _sharing_study(train, changes, values, ("run_out", "Load sharing over run-out"), progress)
    return result.assign_coords(run_out=result.run_out.copy(data=values * 1e6))  # um, as on drawings


def _sharing_study(
    train: Train,
    changes: Mapping[str, Sequence[str]],
    values: NDArray[np.float64],
    words: tuple[str, str],
    progress: Progress,
) -> xr.Dataset:
    """Sharing (member, value) of one curve per entry of `changes`.

    Parameters
    ----------
    changes : path of a member -> paths that take each value together.  values : (P,) in SI.
    words : name of the coordinate of the values, and title of the study.
    """
    points = [dict.fromkeys(paths, float(value)) for paths in changes.values() for value in values]
    arrived: list[int] = []

    def count(place: int, _: tuple[float, str]) -> None:
        arrived.append(place)
        if progress is not None:
            progress(len(arrived) / len(points))

    coefficients, texts = zip(*each(partial(_sharing_point, train.document), points, arrived=count), strict=True)
    shape = len(changes), len(values)
    sharing = np.array(coefficients).reshape(shape)
    status = np.array(texts, dtype=object).reshape(shape)
    failed = int((status != "ok").sum())
    if failed == status.size:
        raise ModelError(str(status.flat[0]))
    coordinate, title = words
    dims = "member", coordinate
    result = dataset(
        {"system_load_sharing": (dims, sharing), "status": (dims, status)},
        coords={"member": [_member_name(path) for path in changes], coordinate: values},
        verb="vary",
        options={"definition": "cycle-peak" if _has_laws(assemble(train)) else "worst-case", "method": "static"},
        warnings=[coded("points-failed", f"{title}: {failed} of {status.size} points failed")] if failed else (),
        provenance=train_provenance(train),
    )
    return result.assign_attrs(study=title)


def _sharing_point(document: Mapping[str, Any], values: Mapping[str, float]) -> tuple[float, str]:
    """`worst_sharing` [1] with values in place of those of a document, and "ok"; nan and the message where it fails."""
    try:
        return _evaluate(document, values, worst_sharing), "ok"
    except (ModelError, ConvergenceError) as error:
        return float("nan"), str(error)


def _has_laws(system: System) -> bool:
    """Whether any link or mesh follows a law, which decides the definition of `worst_sharing`."""
    return bool(system.groups or system.meshes.laws)


def _member_name(path: str) -> str:
    """``main.sun`` of ``stages.main.sun.support`` or ``deviations.main.sun.run_out``."""
    return ".".join(part for part in path.split(".")[1:] if part not in ("support", "run_out"))
