"""Load sharing between branches, by named definitions, over the exact hunting period."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from ...errors import ModelError
from ...system.faces import faces
from ...system.system import Array, System
from ..static.record import positive, record_of
from ..static.static import OPEN
from ..static.tangent import linearised
from .definitions import DEFINITIONS, Tally, coefficients, groups, merge, simultaneous, tally
from .static_record import carries_load, recorded, require_speed, share_notes, total
from .tone_forces import Method, Part, parts
from .worst_case import worst_case

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["sharing"]

# numbers worked on at once (8 bytes each): about 2 MB
_PIECE = 250_000
_STORED = 64
# instants with laws that a record may have by default, each some 50 us
_SOLVED = 100_000


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

    Meshes of one pair and side share the load; of a mesh in slices their sum counts.  ``steady`` takes the vibrating
    train with linear contact, ``superposition`` the same with every frequency alone on the mean system (see
    `superposed`), ``static`` the equilibrium at each instant with meshes that open and links that follow their laws.
    A mesh cycle is that of the mesh's own frequency.

    Parameters
    ----------
    cycles : mesh cycles of the first mesh in the record; the exact hunting period where None and affordable.  The
        worst case is over the hunting period; the attribute ``worst_case`` says how far it was searched.
    turns : of ``static``, instead, turns of the body `of` (``main/sun``); `of` alone: the common period in its turns.
    samples : instants per mesh cycle or turn; None: what `periodic` takes, some 64 for ``static``, a multiple of the
        branches, 32 with laws or turns.
    relative_speed : speed per operating speed [1].
    stored_cycles : cycles kept of the forces and of the simultaneous ratio, 64 at most where None.
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : an option out of range, no load, or what the method raises.
    ConvergenceError : the method did not converge.
    """
    if method == "static" and (turns is not None or of is not None or system.groups):
        require_speed(relative_speed)
        count = positive("samples", samples, 32)
        window = record_of(system, cycles=cycles, turns=turns, of=of, samples=count, most=_SOLVED, slow=True)
        return recorded(system, record=window, relative_speed=relative_speed, stored=stored_cycles, progress=progress)
    if turns is not None or of is not None:
        raise ModelError("a record in turns is static", path="turns, of", allowed='method = "static", or cycles')
    system = linearised(system)
    told, notes = parts(system, method, samples=samples, relative_speed=relative_speed)
    reference, names = told[0], faces(system.meshes).name
    mean = np.empty(len(names))
    for part in told:
        mean[part.meshes] = part.mean
    loaded = carries_load(mean, groups(system.meshes))
    given = None if cycles is None else positive("cycles", cycles, 1)
    share = max(1, reference.affordable // len(told)) if len(told) > 1 else reference.affordable
    cycles = min(reference.period, share) if given is None else given
    stored = min(positive("stored_cycles", stored_cycles, _STORED), cycles)
    values = np.full((len(DEFINITIONS), len(names)), np.nan)
    least, top, largest = (np.full(len(names), np.nan) for _ in range(3))
    how = ""
    for done, part in enumerate(told):
        own = _part_cycles(part, reference, cycles)
        record = _walk(part, own, _shared(progress, done, len(told)))
        worst, how = _worst(part, record, own)
        values[:, part.meshes] = coefficients(record, worst, part.members)
        least[part.meshes], top[part.meshes], largest[part.meshes] = record.least, record.peak, part.bound
    values[:, ~loaded] = np.nan
    options: dict[str, object] = {
        "method": method,
        "cycles": cycles,
        "samples": reference.samples,
        "relative_speed": relative_speed,
        "hunting_period": reference.period,
        "worst_case": how,
    }
    lost = least <= (OPEN * float(top.max()) if method == "static" else 0.0)
    notes += _notes(names, method, lost, loaded, cycles, reference.period)
    largest = np.where(lost & (method == "static"), np.nan, largest)
    history = reference.force(np.arange(stored))
    return _dataset(
        system, names, values, history, lost, largest, float(reference.tone) * relative_speed, options, notes
    )


def _part_cycles(part: Part, reference: Part, cycles: int) -> int:
    """Cycles of a part's mesh frequency that take at least as long as so many of the reference."""
    return cycles if part is reference else math.ceil(cycles * part.tone / reference.tone)


def _shared(progress: Callable[[float], None] | None, done: int, count: int) -> Callable[[float], None] | None:
    return None if progress is None else lambda share: progress((done + share) / count)


def _walk(part: Part, cycles: int, progress: Callable[[float], None] | None) -> Tally:
    """Extremes over the record."""
    piece = max(1, _PIECE // (len(part.meshes) * part.samples))
    pieces = []
    for first in range(0, cycles, piece):
        index = np.arange(first, min(first + piece, cycles), dtype=np.int64)
        here = tally(part.own(index), part.members)
        pieces.append(here if part.least_slice is None else replace(here, least=part.least_slice(index)))
        if progress is not None:
            progress((index[-1] + 1) / cycles)
    return reduce(merge, pieces)


def _worst(part: Part, record: Tally, cycles: int) -> tuple[Array, str]:
    """Worst cycle-peak coefficients (m_j,) over the hunting period, and how they were found."""
    seen = 1.0 + np.maximum(record.ratio_high - 1.0, 1.0 - record.ratio_low)
    if cycles >= part.period:
        return seen, "every cycle of the hunting period"
    points = min(65_536, max(64, part.affordable // 8))
    worst, every = worst_case(part.by_phase, part.ratios, part.members, meshes=len(seen), points=points)
    how = "every cycle of the hunting period" if every else "refined grid over the slow phases"
    return np.maximum(worst, seen), how


def _notes(
    meshes: tuple[str, ...], method: str, open_: np.ndarray, loaded: np.ndarray, cycles: int, period: int
) -> list[str]:
    notes = []
    if cycles < period:
        notes.append(f"record of {cycles} mesh cycles is shorter than the hunting period of {period}")
    lost = _names(meshes, open_)
    if lost and method != "static":
        notes.append(f"linear model invalid: mesh force falls below zero in {lost}; try method static")
        open_ = np.zeros_like(open_)
    return notes + share_notes(meshes, open_, loaded)


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
    options: dict[str, object],
    notes: list[str],
) -> xr.Dataset:
    from ...results.dataset import dataset

    stored, m, samples = history.shape
    ratio, members = np.empty_like(history), groups(system.meshes)
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
