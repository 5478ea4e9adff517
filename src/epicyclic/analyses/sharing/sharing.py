"""Load sharing between branches, by named definitions, over the exact hunting period."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from ...engine.cost import MOST_NUMBERS, require_memory, require_time
from ...errors import ModelError
from ...statics.record import (
    changing,
    parallel_meshes,
    period_name,
    positive_count,
    record_of,
    samples_per_cycle,
    short_record,
)
from ...statics.static import OPEN_RATIO, rounding_of
from ...statics.tangent import linear
from ...system.system import Array, System, faces
from ...warning_codes import CodedText, coded
from .definitions import DEFINITIONS, Extremes, coefficients, extremes, instant_ratio, merge_extremes
from .outputs import (
    bound_warnings,
    far_warnings,
    force_columns,
    known_mean_loads,
    labelled,
    meshes_with_load,
    require_speed,
    sharing_warnings,
)
from .static_record import sharing_of_record
from .tone_forces import Method, ToneForces, mean_force, tone_forces
from .worst_case import worst_case

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["record_samples", "sharing", "solved_by_tone"]

# Numbers worked on at once (8 bytes each): about 2 MB.
_PIECE = 250_000
_STORED = 64
# Forces of a record worked out in a second, and the longest time that one may take [s]: whoever asks for more has
# mistaken an order of magnitude, or wants the hunting period again and again.
_RATE, _LONGEST = 2e7, 4 * 3600.0
# Instants with laws that a record may have by default, each some 50 us.
_SOLVED = 100_000
# Least points of the grid that the search for the worst case begins with, where each is solved anew: half a second.
_LEAST_POINTS = 512
# Instants per mesh cycle or turn of a record that is solved instant by instant.
_INSTANTS = 32


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
        branches, 32 with laws or turns, with tables a multiple of the branches.
    relative_speed : speed per operating speed [1].
    stored_cycles : cycles kept of the forces and of the simultaneous ratio, 64 at most where None.
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : an option out of range, no load, or what the method raises.
    ConvergenceError : the method did not converge.
    """
    if method == "static" and (turns is not None or of is not None or not solved_by_tone(system)):
        require_speed(relative_speed)
        count = positive_count("samples", samples, record_samples(system))
        window = record_of(system, cycles=cycles, turns=turns, of=of, samples=count, most=_SOLVED, slow=True)
        return sharing_of_record(
            system, record=window, relative_speed=relative_speed, stored=stored_cycles, progress=progress
        )
    if turns is not None or of is not None:
        raise ModelError("a record in turns is static", path="turns, of", allowed='method = "static", or cycles')
    mean_load, mean_notes = known_mean_loads(system)
    if method != "static":  # at rest the laws of flanks are asked; links without laws are here in either case
        system = linear(system)
    if samples is not None:  # the waves of every line
        waves = len(system.meshes.name) * max(1, len(system.lines))
        allowed = f"1 to {MOST_NUMBERS // (2 * waves)}"
        require_memory(2.0 * samples * waves, path="samples", given=samples, allowed=allowed)
    by_tone, notes = tone_forces(system, method, samples=samples, relative_speed=relative_speed)
    notes = [*notes, *mean_notes]
    reference, names = by_tone[0], faces(system.meshes).name
    mean, largest = np.empty(len(names)), np.empty(len(names))
    for part in by_tone:
        mean[part.meshes], largest[part.meshes] = part.mean, part.bound
    loaded = meshes_with_load(mean, parallel_meshes(system.meshes), most=largest, rounding=rounding_of(system))
    given = None if cycles is None else positive_count("cycles", cycles, 1)
    share = max(1, reference.affordable // len(by_tone)) if len(by_tone) > 1 else reference.affordable
    cycles = min(reference.period, share) if given is None else given
    stored = min(positive_count("stored_cycles", stored_cycles, _STORED), cycles)
    numbers = reference.samples * len(names)
    longest = f"at most {int(_LONGEST * _RATE / numbers)}, and {reference.period} are the hunting period"
    require_time(cycles * numbers / _RATE, _LONGEST, path="cycles", given=cycles, allowed=longest)
    most = f"at most {MOST_NUMBERS // (2 * numbers)}"
    require_memory(2.0 * stored * numbers, path="stored_cycles", given=stored, allowed=most)
    values = np.full((len(DEFINITIONS), len(names)), np.nan)
    least, top, bottom, largest = (np.full(len(names), np.nan) for _ in range(4))
    how, unknown = "", np.full(len(names), "", dtype=object)
    for done, part in enumerate(by_tone):
        own = _tone_cycles(part, reference, cycles)
        record, slices, average = _record_extremes(part, own, _share_of(progress, done, len(by_tone)))
        worst, how = _worst_case(part, record, own)
        values[:, part.meshes] = coefficients(record, worst, mean_load[:, part.meshes], part.members)
        least[part.meshes], top[part.meshes], largest[part.meshes] = slices, record.peak, part.bound
        bottom[part.meshes], unknown[part.meshes] = record.least, part.unknown
        if method == "static":
            # stiffness that follows several tones, and teeth that part, move the mean from that of the mean stiffness
            mean[part.meshes] = average
    values[:, ~loaded] = np.nan
    options: dict[str, object] = {
        "method": method,
        "cycles": cycles,
        "samples": reference.samples,
        "relative_speed": relative_speed,
        "hunting_period": reference.period,
        "worst_case": how,
    }
    touch = OPEN_RATIO * float(top.max()) if method == "static" else 0.0
    lost, behind = least <= touch, (least < -touch) & (method == "static")
    notes += _short_warnings(system, cycles, reference.period, (bottom, top))
    notes += _validity_warnings(names, method, (lost, behind), loaded)
    parted = lost & (method == "static")
    largest = np.where(parted, np.nan, largest)
    notes += bound_warnings(names, largest, np.where(loaded, np.where(parted, "teeth part", unknown), "").tolist())
    history = reference.force(np.arange(stored))
    ratio = np.empty_like(history)
    for group in parallel_meshes(system.meshes):
        ratio[:, group] = instant_ratio(history[:, group])
    return labelled(
        system,
        coefficients=values,
        ratio=ratio.transpose(1, 0, 2).reshape(len(names), -1),
        force=history.transpose(1, 0, 2).reshape(len(names), -1),
        bound=largest,
        columns={"contact_lost": ("mesh", lost), **force_columns(mean, top, bottom)},
        time=np.arange(stored * history.shape[2]) / history.shape[2] / (float(reference.tone) * relative_speed),
        options=options,
        provenance=system.provenance,
        warnings=notes,
    )


def solved_by_tone(system: System) -> bool:
    """Whether static mesh forces are sought by mesh frequency, linear in the lines while all loaded flanks press.

    Not where a law of a link or a mesh is not linear, nor where the mean load of a group is on its far flanks.
    """
    if system.groups or system.meshes.laws:
        return False
    if not system.far_flanks.mesh.size:
        return True
    mean = faces(system.meshes).total(mean_force(system))
    # an idle group carries rounding
    least = -1e-9 * float(np.max(np.abs(mean), initial=0.0))
    return all(mean[group].sum() >= least for group in parallel_meshes(system.meshes))


def record_samples(system: System) -> int:
    """Instants per mesh cycle or turn of a record that is solved instant by instant.

    Where tables follow the mesh cycle equal branches get equal peaks.
    """
    meshes = system.meshes
    if not meshes.laws:
        return _INSTANTS
    first = faces(meshes).first
    own = np.flatnonzero(meshes.tone[first] == meshes.tone[first[0]])
    return samples_per_cycle(meshes, own, _INSTANTS)


def _tone_cycles(part: ToneForces, reference: ToneForces, cycles: int) -> int:
    """Cycles of a mesh frequency that take at least as long as so many of the reference."""
    return cycles if part is reference else math.ceil(cycles * part.tone / reference.tone)


def _share_of(progress: Callable[[float], None] | None, done: int, count: int) -> Callable[[float], None] | None:
    """Progress of one mesh frequency of several, as a share of the whole."""
    return None if progress is None else lambda share: progress((done + share) / count)


def _record_extremes(
    part: ToneForces, cycles: int, progress: Callable[[float], None] | None
) -> tuple[Extremes, Array, Array]:
    """Extremes (m_j,) over the record, a few MB of forces at a time.

    With them the least force of any slice of each mesh, and the mean of each (m_j,) [N].
    """
    piece = max(1, _PIECE // (len(part.meshes) * part.samples))
    pieces, slices, total = [], [], np.zeros(len(part.meshes))
    for first in range(0, cycles, piece):
        index = np.arange(first, min(first + piece, cycles), dtype=np.int64)
        force = part.own(index)
        total += force.sum(axis=(0, 2))
        pieces.append(extremes(force, part.members))
        slices.append(pieces[-1].least if part.least_slice is None else part.least_slice(index))
        if progress is not None:
            progress((index[-1] + 1) / cycles)
    return reduce(merge_extremes, pieces), reduce(np.minimum, slices), total / (cycles * part.samples)


def _worst_case(part: ToneForces, record: Extremes, cycles: int) -> tuple[Array, str]:
    """Worst cycle-peak coefficients (m_j,) [1] over the hunting period, and the kind of search that found them."""
    seen = record.cycle_peak
    if cycles >= part.period:
        return seen, "every cycle of the hunting period"
    points = min(65_536, max(_LEAST_POINTS, part.affordable // 8))
    worst, every = worst_case(part.by_phase, part.ratios, part.members, meshes=len(seen), points=points)
    how = "every cycle of the hunting period" if every else "refined grid over the slow phases"
    return np.maximum(worst, seen), how


def _short_warnings(system: System, cycles: int, period: int, extremes_: tuple[Array, Array]) -> list[CodedText]:
    """A warning of a record of fewer cycles than the period, where the forces change; their least and most (m,) [N]."""
    short = cycles < period and changing(*extremes_)
    return [short_record(cycles, "mesh cycles", period_name(system), period)] if short else []


def _validity_warnings(
    meshes: tuple[str, ...],
    method: str,
    contact: tuple[np.ndarray, np.ndarray],
    loaded: np.ndarray,
) -> list[CodedText]:
    """Warnings of a linear model pulled open, of meshes that open and of those without load.

    contact : whether each mesh opens (m,), and whether it rests on its far flank (m,).  loaded : (m,).
    """
    notes: list[CodedText] = []
    open_, far = contact
    lost = _names(meshes, open_ & loaded)
    if lost and method != "static":
        text = (
            f"linear model invalid: mesh force falls below zero in {lost}; "
            "teeth may part at rest with --method static, in vibration with steady --contact-loss"
        )
        notes.append(coded("tension-in-teeth", text))
        open_ = np.zeros_like(open_)
    notes += sharing_warnings(meshes, open_, loaded)
    return notes + far_warnings(meshes, far)


def _names(meshes: tuple[str, ...], chosen: np.ndarray) -> str:
    """Names of the chosen meshes (m,)."""
    return ", ".join(name for name, yes in zip(meshes, chosen, strict=True) if yes)
