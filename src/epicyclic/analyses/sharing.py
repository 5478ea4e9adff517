"""Load sharing between branches, by named definitions, over the exact hunting period."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import reduce
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..errors import ModelError
from ..system.faces import Faces, faces
from ..system.system import Array, System
from .definitions import DEFINITIONS, Group, Tally, coefficients, groups, merge, simultaneous, tally
from .equilibrium import Compliance, compliance, equilibrium
from .record import hunting_cycles, mesh_stiffness, positive, reference_tone
from .static import OPEN, free_position_warnings
from .waves import Waves, bound, forces, line_phases, periodic_waves, static_waves
from .worst import Source, worst_case

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Method", "sharing"]

Method = Literal["steady", "static"]

# numbers worked on at once (8 bytes each), and over the whole record: about 2 MB, and some seconds
_PIECE, _RECORD = 250_000, 300_000_000
# instants with open meshes that a record may have by default, each some 50 us
_SOLVED = 100_000
_STORED = 64


def sharing(
    system: System,
    *,
    method: Method = "steady",
    cycles: int | None = None,
    samples: int | None = None,
    relative_speed: float = 1.0,
    stored_cycles: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Load-sharing coefficients of every mesh by every definition of `definitions`, and of the train (the largest).

    Meshes of one pair and side share the load; of a mesh in slices their sum counts.  ``steady`` takes the vibrating
    train with linear contact; ``static`` the equilibrium at each instant with meshes that open.

    Parameters
    ----------
    cycles : mesh cycles of the record; the exact hunting period where None and affordable.  The worst case is always
        over the hunting period.
    samples : instants per mesh cycle; None: what `periodic` takes, 64 for ``static``.
    relative_speed : speed per operating speed [1].
    stored_cycles : cycles kept of the forces and of the simultaneous ratio, 64 at most where None.
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : an option out of range, several mesh frequencies, no load, or what the method raises.
    ConvergenceError : the method did not converge.
    """
    rows, by_row, tone, notes = _source(system, method, samples, relative_speed)
    face, members = faces(system.meshes), groups(system.meshes)
    waves = replace(rows, mean=face.total(rows.mean), amplitude=face.total(rows.amplitude, axis=1))

    def source(phases: Array) -> Array:
        return face.total(by_row(phases), axis=1)

    loaded = _loaded(waves, members)
    period = hunting_cycles(waves.ratios)
    affordable = _affordable(rows, method)
    cycles = positive("cycles", cycles, min(period, affordable))
    stored = min(positive("stored_cycles", stored_cycles, _STORED), cycles)
    record = _walk(by_row, rows, face, members, cycles, progress)
    points = min(65_536, max(64, affordable // 8))
    worst, how = _worst(source, waves, members, record, points, cycles >= period)
    values = np.where(loaded, coefficients(record, worst, members), np.nan)
    history = source(line_phases(waves.ratios, np.arange(stored)))
    options: dict[str, object] = {
        "method": method,
        "cycles": cycles,
        "samples": waves.samples,
        "relative_speed": relative_speed,
        "hunting_period": period,
        "worst_case": how,
    }
    lost = record.least <= (OPEN * float(record.peak.max()) if method == "static" else 0.0)
    notes += _notes(face.name, method, lost, loaded, cycles, period)
    largest = np.where(lost & (method == "static"), np.nan, bound(waves))
    frequency = float(tone) * relative_speed
    return _dataset(system, face.name, values, history, lost, largest, frequency, members, options, notes)


def _source(
    system: System, method: str, samples: int | None, relative_speed: float
) -> tuple[Waves, Source, Fraction, list[str]]:
    """Waves, the forces they give (with open meshes solved for), mesh frequency and warnings of a method."""
    if method == "steady":
        from .steady import periodic

        solution = periodic(system, relative_speed=relative_speed, samples=samples)
        waves = periodic_waves(solution)
        return waves, lambda phases: forces(waves, phases), solution.tone, []
    if method != "static":
        raise ModelError("no such method", path="method", given=method, allowed="steady, static")
    if not relative_speed > 0:
        raise ModelError("must be above zero", path="relative_speed", given=relative_speed, allowed="> 0")
    if len({system.tones[tone] for tone in system.meshes.tone} if system.tones else ()) > 1:
        raise ModelError(
            "load sharing per mesh cycle needs one mesh frequency, and this train has several",
            allowed="`static` or `transient`, which give the mesh forces themselves",
        )
    tone = reference_tone(system)
    flexible = compliance(system.K, system.meshes.B, system.meshes.stiffness)
    waves = static_waves(system, flexible, tone, positive("samples", samples, 64))
    return waves, _unilateral(system, flexible, tone, waves), tone, free_position_warnings(system, flexible.free)


def _unilateral(system: System, flexible: Compliance, tone: Fraction, waves: Waves) -> Source:
    """Static mesh forces: linear while all meshes press, solved anew at the instants where one would pull."""
    k = mesh_stiffness(system, tone, np.arange(waves.samples), waves.samples)
    theta = np.arange(waves.samples) / waves.samples
    ratios = [line.frequency / tone for line in system.lines]
    slow = [i for i, ratio in enumerate(ratios) if ratio.denominator != 1]
    turning = np.array([float(ratio) for ratio in ratios])
    gaps = np.array([line.gap for line in system.lines]).reshape(len(ratios), len(system.meshes.name))
    loads = np.array([line.force[0] for line in system.lines]).reshape(len(ratios), len(system.force))

    def source(phases: Array) -> Array:
        result = forces(waves, phases)
        cycle, instant = np.nonzero(np.any(result < 0, axis=1))
        for first in range(0, len(cycle), 2048):
            c, j = cycle[first : first + 2048], instant[first : first + 2048]
            angle = np.outer(theta[j], turning)
            angle[:, slow] += phases[c]
            wave = np.exp(2j * np.pi * angle)
            gap, force = (wave @ gaps).real, system.force + (wave @ loads).real
            result[c, :, j] = equilibrium(flexible, stiffness=k[j], gap=gap, force=force).mesh_force
        return result

    return source


def _affordable(waves: Waves, method: str) -> int:
    """Mesh cycles a record may have by default: some seconds of work, judged by its first cycles."""
    cycles = _RECORD // waves.mean.size
    if method == "static":
        first = forces(waves, line_phases(waves.ratios, np.arange(_STORED)))
        instants = int(np.sum(np.any(first < 0, axis=1)))
        cycles = min(cycles, _SOLVED * _STORED // max(1, instants))
    return max(1, cycles)


def _loaded(waves: Waves, members: list[Group]) -> np.ndarray:
    """Meshes of groups that carry load in the mean, (m,).

    Raises
    ------
    ModelError : none does.
    """
    mean = waves.mean.mean(axis=1)
    # an idle group beside loaded ones carries rounding
    least = 1e-9 * float(np.max(np.abs(mean), initial=0.0))
    loaded = np.zeros(len(mean), dtype=bool)
    for group in members:
        loaded[group] = mean[group].sum() > least
    if not loaded.any():
        raise ModelError(
            "load sharing needs a load, and no mesh carries any", path="operation.torque", allowed="a torque"
        )
    return loaded


def _walk(
    by_row: Source,
    waves: Waves,
    face: Faces,
    members: list[Group],
    cycles: int,
    progress: Callable[[float], None] | None,
) -> Tally:
    """Extremes over the record, the smallest force of any slice; waves and by_row of every row."""
    piece = max(1, _PIECE // waves.mean.size)
    pieces = []
    for first in range(0, cycles, piece):
        index = np.arange(first, min(first + piece, cycles), dtype=np.int64)
        force = by_row(line_phases(waves.ratios, index))
        whole = tally(face.total(force, axis=1), members)
        pieces.append(replace(whole, least=face.least(force.min(axis=(0, 2)))))
        if progress is not None:
            progress((index[-1] + 1) / cycles)
    return reduce(merge, pieces)


def _worst(
    source: Source, waves: Waves, members: list[Group], record: Tally, points: int, whole: bool
) -> tuple[Array, str]:
    """Worst cycle-peak coefficients (m,) over the hunting period, and how they were found."""
    seen = 1.0 + np.maximum(record.ratio_high - 1.0, 1.0 - record.ratio_low)
    if whole:
        return seen, "every cycle of the hunting period"
    worst, every = worst_case(source, waves.ratios, members, meshes=len(seen), points=points)
    how = "every cycle of the hunting period" if every else "refined grid over the slow phases"
    return np.maximum(worst, seen), how


def _notes(
    meshes: tuple[str, ...], method: str, open_: np.ndarray, loaded: np.ndarray, cycles: int, period: int
) -> list[str]:
    notes = []
    if cycles < period:
        notes.append(f"record of {cycles} mesh cycles is shorter than the hunting period of {period}")
    lost = _names(meshes, open_)
    if lost and method == "steady":
        notes.append(f"linear model invalid: mesh force falls below zero in {lost}; try method static")
    elif lost:
        notes.append(f"meshes open: {lost}")
    if not loaded.all():
        notes.append(f"no load, hence no load sharing, in {_names(meshes, ~loaded)}")
    return notes


def _names(meshes: tuple[str, ...], chosen: np.ndarray) -> str:
    return ", ".join(name for name, yes in zip(meshes, chosen, strict=True) if yes)


def _dataset(
    system: System,
    meshes: tuple[str, ...],
    values: Array,
    history: Array,
    lost: np.ndarray,
    largest: Array,
    frequency: float,
    members: list[Group],
    options: dict[str, object],
    notes: list[str],
) -> xr.Dataset:
    from ..results import dataset

    stored, m, samples = history.shape
    ratio = np.empty_like(history)
    for group in members:
        ratio[:, group] = simultaneous(history[:, group])
    result = dataset(
        {
            "load_sharing": (("definition", "mesh"), values),
            "system_load_sharing": ("definition", np.nanmax(values, axis=1)),
            "load_sharing_history": (("mesh", "time"), ratio.transpose(1, 0, 2).reshape(m, -1)),
            "mesh_force": (("mesh", "time"), history.transpose(1, 0, 2).reshape(m, -1)),
            "mesh_force_bound": ("mesh", largest),
            "contact_lost": ("mesh", lost),
        },
        {
            "definition": np.array(DEFINITIONS, dtype=object),
            "mesh": np.array(meshes, dtype=object),
            "time": np.arange(stored * samples) / samples / frequency,
        },
        verb="sharing",
        options=options,
        provenance=system.provenance,
        warnings=[*system.warnings, *notes],
    )
    result["time"].attrs.update({"units": "s" if system.tones else "mesh cycles", "long_name": "time"})
    # a netCDF attribute holds 64 bits
    result.attrs.update({name: str(v) if isinstance(v, int) and v >= 2**63 else v for name, v in options.items()})
    result.attrs["groups"] = json.dumps([[meshes[i] for i in group] for group in members])
    return result
