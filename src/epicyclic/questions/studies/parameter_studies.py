"""What a number of the model file moves: loci of natural frequencies, the map of instability, and any quantity.

The parameter is a value in the model file, or a factor of the assembled train.

Mode tracking: loci of the natural frequencies along a parameter, crossings and veerings.  Where two loci approach, a
crossing and a veering differ in the coupling of the two modes [perkins1986, lin2001, dubois2011]; `questions.modes`
follows the modes and finds these events.

Stability maps: Floquet growth rates over mesh frequency and a second parameter, with the averaged boundaries.

`vary` takes any path and any quantity; load sharing over support stiffness and run-out has its points on several cores.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from ...document.units import written
from ...engine.plan import require_time
from ...engine.points import along, attempt, columns, failures, numbers, outcomes
from ...engine.run_folder import RunFolder
from ...engine.source import Source, StudyAxis, system_of, written_labels
from ...errors import ModelError
from ...results.dataset import dataset
from ...statics.tangent import flank_warnings
from ...system.assembly import assemble, train_provenance
from ...system.system import Array, System
from ...train.resolution import load
from ...train.train import Train
from ...user_input import checked
from ...warning_codes import placed
from ..modes.campbell import LocusEvent, ModeSet, locus_events, repeated_loci, track_modes
from ..modes.eigen import classify_modes, eigen
from ..response.response import FrameSpeed
from ..sharing import SharingOptions
from ..sharing.sharing import sharing
from ..stability.stability import (
    Combination,
    FloquetScan,
    ParametricSystem,
    combination_name,
    floquet_scan,
    parametric_system,
    predicted_combinations,
    scan_warnings,
    speed_columns,
)
from . import TrackOptions
from .sensitivity import Parameter, parameter_at

# Ratio of the limits above which the first values lie in equal ratios.
_WIDE_RANGE = 10


def track(train: Train, options: TrackOptions, *, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """Loci of the natural frequencies along one number of the model file, with their crossings and veerings.

    Parameters
    ----------
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
    over, points, modes = options.over, options.points, options.modes
    parameter = parameter_at(train, over)
    low, high = _limits(parameter, options.start, options.stop)
    first = parameter.system_at(train.document, low)
    assembled = [0]

    @cache
    def system(value: float) -> System:
        assembled[0] += 1
        if progress is not None:
            progress(min(0.95, assembled[0] / (4 * points)))
        return parameter.system_at(train.document, value)

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

    # evenly spaced, over a wide range in equal ratios
    wide = low * high > 0 and max(low / high, high / low) > _WIDE_RANGE
    spaced = np.geomspace(low, high, points) if wide else np.linspace(low, high, points)
    loci = track_modes(modes_at, [low, *spaced[1:-1].tolist(), high])
    crossings_and_veerings = locus_events(loci, matrix_derivatives)
    start_modes = modes_at(low)
    kinds = classify_modes(first, start_modes.omega_squared, start_modes.vectors).kind
    return _labelled(train, parameter, loci, crossings_and_veerings, kinds, modes or len(kinds))


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
    return dataset(
        {
            "frequency": (("mode", "parameter"), hertz[:modes]),
            "mode_kind": ("mode", np.array(kinds[:modes], object)),
            "multiplicity": ("mode", np.array([multiplicity[i] for i in range(len(kinds))][:modes])),
            "event_kind": ("event", np.array([event.kind for event in events], object)),
            "event_value": ("event", np.array([event.value for event in events])),
            "event_frequency": ("event", event_hertz),
            "event_first": ("event", np.array([_mode_numbers(event.first) for event in events], object)),
            "event_second": ("event", np.array([_mode_numbers(event.second) for event in events], object)),
            "event_gap": ("event", event_gap),
            "coupling_factor": ("event", np.array([abs(e.coupling * e.value) / (2 * e.omega_squared) for e in events])),
            "veering_index": ("event", np.array([event.index for event in events])),
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

# Cells of a map, whose multipliers take 1 kB each, and the time of one, as measured on trains of 30 coordinates [s].
_CELLS, _CELL = 1_000_000, 0.05


class _MapRow(NamedTuple):
    """Results at one value of the parameter: the prepared System, its scan over speed, its predicted combinations."""

    ready: ParametricSystem
    scan: FloquetScan
    ranges: list[Combination]


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
    labels, unit = written_labels(values)
    axis = StudyAxis(name="value", changes=tuple({path: value} for value in values), labels={"value": (labels, {})})
    rows: list[_MapRow | None] = []
    reasons: list[str] = []
    for i, change in enumerate(axis.changes):
        prepared = attempt(partial(_prepared, source, overrides or {}, frame_speed), change)
        reasons.append(prepared.reason)
        if prepared.value is None:
            rows.append(None)
            continue
        share = None if progress is None else lambda done, _, i=i: progress(i * frequency.size + done, cells)
        done = None if kept is None else kept.part(f"value {i}")
        scan = floquet_scan(prepared.value, frequency, progress=share, kept=done)
        rows.append(_MapRow(prepared.value, scan, predicted_combinations(prepared.value, frequency)))
    known = [row for row in rows if row is not None]
    if not known:
        raise ModelError(reasons[0])
    whole = along((axis,), [None if row is None else xr.Dataset(speed_columns(frequency, *row)) for row in rows])
    whole["stable"] = whole.instability == "stable"  # of a value that fails nothing is known
    whole["status"] = whole.status.where(whole.status != "", np.array(reasons, dtype=object)[:, None])
    ready = known[0].ready
    ranges = _joined_ranges(rows)
    result = dataset(
        columns(whole.drop_vars("period_steps")) | columns(ranges),
        {
            "value": labels,
            "speed": frequency / float(ready.tones[0]),
            "mesh_frequency": ("speed", frequency),
            "resonance": ranges.resonance.values.tolist(),
        },
        verb="stability",
        options={"over": path, "values": list(values), "frame_speed": frame_speed},
        provenance=ready.system.provenance,
        warnings=[*ready.system.warnings, *failures(reasons, "values"), *scan_warnings([row.scan for row in known])],
        units={"speed": "1", "value": unit},  # speed relative to the operating speed
    )
    return result.assign_attrs(over=path)


def _prepared(
    source: Source, overrides: Mapping[str, Any], frame_speed: FrameSpeed, change: Mapping[str, Any]
) -> ParametricSystem:
    """The System at one value of the path, or with a factor of `FACTORS`."""
    ((path, value),) = change.items()
    if path not in FACTORS:
        return parametric_system(system_of(source, overrides={**overrides, **change}), frame_speed=frame_speed)
    try:
        factor = float(value)
    except (TypeError, ValueError):
        raise ModelError("not a factor", path=path, given=value, allowed="a number of 0 or more") from None
    return parametric_system(system_of(source), frame_speed=frame_speed, **{path: factor})


def _joined_ranges(rows: Sequence[_MapRow | None]) -> xr.Dataset:
    """Boundaries [Hz] and growth rates [1/s] of all combinations (value, resonance), nan where a range is closed.

    Combinations of one name are one; where one has two ranges, these are their outer ends.  The widest stands first.
    """
    names = ["value", "resonance", "low", "high", "growth", "first", "second", "order"]
    table = pd.DataFrame(
        [
            (i, combination_name(each, len(row.ready.tones) > 1), *(getattr(each, name) for name in names[2:]))
            for i, row in enumerate(rows)
            if row is not None
            for each in row.ranges
        ],
        columns=names,
    )
    widest = table.iloc[np.argsort((table.low - table.high).to_numpy(float), kind="stable")].drop_duplicates(
        "resonance"
    )
    ends = table.groupby(["value", "resonance"]).agg({"low": "min", "high": "max", "growth": "max"}).astype(float)
    joined: xr.Dataset = ends.to_xarray().reindex(value=range(len(rows)), resonance=widest.resonance.to_numpy(object))
    joined = joined.assign({name: ("resonance", widest[name].to_numpy(np.int64)) for name in names[5:]})
    return joined.rename({name: f"resonance_{name}" for name in joined.data_vars})


Progress = Callable[[float], None] | None
# Mesh cycles of a record where links or meshes have laws, each instant of which is an equilibrium of its own.
_CYCLES = 64


def largest_sharing(system: System) -> float:
    """Load-sharing coefficient of the train [1] by the first definition of `sharing`, peak per mesh cycle."""

    return float(sharing(system, SharingOptions()).system_load_sharing[0])


def worst_sharing(system: System) -> float:
    """Static load-sharing coefficient of the train [1], peaks per mesh cycle, worst case over the hunting period.

    To keep a study of many points short, several varying mesh frequencies are replaced by the mean stiffness, and
    where links or meshes have laws the coefficient is the largest of 64 mesh cycles.
    """

    varying = {int(tone) for tone, row in zip(system.meshes.tone, system.meshes.variation, strict=True) if row.any()}
    if len(varying) > 1:
        far = None if system.far is None else replace(system.far, variation=system.far.variation[:, :0])
        system = replace(system, meshes=replace(system.meshes, variation=system.meshes.variation[:, :0]), far=far)
    lawful = _has_laws(system)
    coefficients = sharing(system, SharingOptions(method="static", cycles=_CYCLES if lawful else 1)).system_load_sharing
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
    changes = [dict(zip(path_values, values, strict=True)) for values in zip(*path_values.values(), strict=True)]
    at_point = partial(_quantity_at, source, overrides or {}, quantity)
    found = outcomes(at_point, changes, workers=False, progress=progress)
    quantities, status = numbers(found, (len(changes),))
    return dataset(
        {"quantity": ("point", quantities), "status": ("point", status)},
        coords={
            "point": np.arange(status.size),
            **{path: ("point", list(values)) for path, values in path_values.items()},
        },
        verb="vary",
        options={"paths": list(path_values), "overrides": dict(overrides or {})},
        units={"quantity": unit},
        warnings=failures([outcome.reason for outcome in found]),
    )


def _quantity_at(
    source: str | Path | Mapping[str, Any],
    overrides: Mapping[str, Any],
    quantity: Callable[[System], float],
    changes: Mapping[str, Any],
) -> float:
    """A quantity of the System with some changes of the model."""
    return float(quantity(assemble(load(source, overrides={**overrides, **changes}))))


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
        if link.kind == "support"
        and "/bolts/" not in link.name
        and np.isfinite(link.stiffness[:2]).all()
        and min(link.stiffness[:2]) > 0
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
    found = outcomes(partial(_quantity_at, train.document, {}, worst_sharing), points, progress=progress)
    coefficient, status = numbers(found, (len(changes), len(values)))
    if all(outcome.error for outcome in found):
        raise ModelError(found[0].reason)
    coordinate, title = words
    dims = ("member", coordinate)
    result = dataset(
        {"system_load_sharing": (dims, coefficient), "status": (dims, status)},
        coords={
            # ``main.sun`` of ``stages.main.sun.support`` or ``deviations.main.sun.run_out``
            "member": [".".join(p for p in path.split(".")[1:] if p not in ("support", "run_out")) for path in changes],
            coordinate: values,
        },
        verb="vary",
        options={"definition": "cycle-peak" if _has_laws(assemble(train)) else "worst-case", "method": "static"},
        warnings=[placed(title, text) for text in failures([outcome.reason for outcome in found])],
        provenance=train_provenance(train),
    )
    return result.assign_attrs(study=title)


def _has_laws(system: System) -> bool:
    """Whether any link or mesh follows a law, which decides the definition of `worst_sharing`."""
    return bool(system.groups or system.meshes.laws)
