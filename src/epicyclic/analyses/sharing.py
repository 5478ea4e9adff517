"""Load sharing between branches, by named definitions, over the exact hunting period."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from functools import reduce
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..errors import ModelError
from ..system.system import Array, System
from .definitions import DEFINITIONS, Group, Tally, coefficients, groups, merge, simultaneous, tally
from .equilibrium import Compliance, compliance_of, equilibrium
from .linear import linearised
from .record import hunting_cycles, mesh_stiffness, positive, record_of, reference_tone
from .recorded import carries_load, recorded, require_speed, share_notes, total
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
    turns: int | None = None,
    of: str | None = None,
    samples: int | None = None,
    relative_speed: float = 1.0,
    stored_cycles: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Load-sharing coefficients of every mesh by every definition of `definitions`, and of the train (the largest).

    Meshes of one pair and side share the load.  ``steady`` takes the vibrating train with linear contact;
    ``static`` the equilibrium at each instant with meshes that open and links that follow their laws.

    Parameters
    ----------
    cycles : mesh cycles of the record; the exact hunting period where None and affordable.  The worst case is always
        over the hunting period.
    turns : of ``static``, instead, turns of the body `of` (``main/sun``); `of` alone: the common period in its turns.
    samples : instants per mesh cycle or turn; None: what `periodic` takes, 64 for ``static``, 32 with laws, several
        mesh frequencies or turns.
    relative_speed : speed per operating speed [1].
    stored_cycles : cycles kept of the forces and of the simultaneous ratio, 64 at most where None.
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : an option out of range, several mesh frequencies in ``steady``, no load, or what the method raises.
    ConvergenceError : the method did not converge.
    """
    if method == "static" and (turns is not None or of is not None or system.groups or _tones(system) > 1):
        require_speed(relative_speed)
        return recorded(
            system,
            record=record_of(
                system,
                cycles=cycles,
                turns=turns,
                of=of,
                samples=positive("samples", samples, 32),
                most=_SOLVED,
                slow=True,
            ),
            relative_speed=relative_speed,
            stored=stored_cycles,
            progress=progress,
        )
    if turns is not None or of is not None:
        raise ModelError("a record in turns is static", path="turns, of", allowed='method = "static", or cycles')
    system = linearised(system)
    waves, source, tone, notes = _source(system, method, samples, relative_speed)
    members = groups(system.meshes)
    loaded = carries_load(waves.mean.mean(axis=1), members)
    period = hunting_cycles(waves.ratios)
    affordable = _affordable(waves, method)
    cycles = positive("cycles", cycles, min(period, affordable))
    stored = min(positive("stored_cycles", stored_cycles, _STORED), cycles)
    record = _walk(source, waves, members, cycles, progress)
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
    notes += _notes(system, method, lost, loaded, cycles, period)
    largest = np.where(lost & (method == "static"), np.nan, bound(waves))
    return _dataset(system, values, history, lost, largest, float(tone) * relative_speed, members, options, notes)


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
    require_speed(relative_speed)
    tone = reference_tone(system)
    flexible = compliance_of(system)
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


def _walk(
    source: Source, waves: Waves, members: list[Group], cycles: int, progress: Callable[[float], None] | None
) -> Tally:
    """Extremes over the record."""
    piece = max(1, _PIECE // waves.mean.size)
    pieces = []
    for first in range(0, cycles, piece):
        index = np.arange(first, min(first + piece, cycles), dtype=np.int64)
        pieces.append(tally(source(line_phases(waves.ratios, index)), members))
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


def _notes(system: System, method: str, open_: np.ndarray, loaded: np.ndarray, cycles: int, period: int) -> list[str]:
    notes = []
    if cycles < period:
        notes.append(f"record of {cycles} mesh cycles is shorter than the hunting period of {period}")
    lost = _names(system, open_)
    if lost and method == "steady":
        notes.append(f"linear model invalid: mesh force falls below zero in {lost}; try method static")
        open_ = np.zeros_like(open_)
    return notes + share_notes(system, open_, loaded)


def _tones(system: System) -> int:
    """Number of mesh frequencies."""
    return len({system.tones[tone] for tone in system.meshes.tone} if system.tones else ())


def _names(system: System, chosen: np.ndarray) -> str:
    return ", ".join(name for name, yes in zip(system.meshes.name, chosen, strict=True) if yes)


def _dataset(
    system: System,
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
            "system_load_sharing": ("definition", total(values)),
            "load_sharing_history": (("mesh", "time"), ratio.transpose(1, 0, 2).reshape(m, -1)),
            "mesh_force": (("mesh", "time"), history.transpose(1, 0, 2).reshape(m, -1)),
            "mesh_force_bound": ("mesh", largest),
            "contact_lost": ("mesh", lost),
        },
        {
            "definition": np.array(DEFINITIONS, dtype=object),
            "mesh": np.array(system.meshes.name, dtype=object),
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
    result.attrs["groups"] = json.dumps([[system.meshes.name[i] for i in group] for group in members])
    return result
