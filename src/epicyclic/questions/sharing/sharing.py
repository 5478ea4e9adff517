"""Load sharing between branches, by named definitions, over the exact hunting period; and at rest, quickly.

Quickly: mesh cycles spread over the hunting period (`spread_cycles`), without the search for its worst case.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import reduce
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.plan import MOST_NUMBERS, require_memory, require_time
from ...errors import ModelError
from ...options import Progress
from ...statics import StaticOptions
from ...statics.record import (
    MeshGroup,
    Record,
    parallel_meshes,
    period_name,
    record_of,
    samples_per_cycle,
    shares,
    spread_cycles,
)
from ...statics.static import OPEN_RATIO, rounding_of, static
from ...statics.tangent import linear
from ...system.system import Array, Faces, System, faces
from ..response import SteadyOptions
from ..response.steady import steady
from . import SharingOptions
from .definitions import (
    Extremes,
    ForceRecord,
    extremes,
    known_mean_loads,
    labelled,
    merge_extremes,
    meshes_with_load,
    require_speed,
    sharing_meshes,
    worst_case,
)
from .tone_forces import ToneForces, cycle_starts, forces_of_equilibria, mean_force, tone_forces

# Mesh cycles whose forces are kept by default.
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
# Seconds that a record of the length affordable by default takes where instants are solved one by one.
_AFFORDABLE = 5.0
# Instants solved in a second where laws of links are asked, and where those of meshes are tables.
_LAWS, _TABLES = 15_000.0, 3_000.0
# Instants counted from the first of a period stay exact below.
_EXACT = 2**62


# --- by definition ---------------------------------------------------------------------------------------------------


def sharing(system: System, options: SharingOptions, *, progress: Progress | None = None) -> xr.Dataset:
    """Load-sharing coefficients of every mesh by every definition of `definitions`, and of the train (the largest).

    Meshes of one pair and side share the load; of a mesh in slices their sum counts.  ``steady`` takes the vibrating
    train with linear contact, ``superposition`` the same with every frequency alone on the mean system (see
    `superposed`), ``static`` the equilibrium at each instant with meshes that open and links that follow their laws.
    A mesh cycle is that of the mesh's own frequency.

    Ranges and lines of transmission errors are those of ``static``, over at most 64 mesh cycles, or ``steady``.

    The worst case is over the hunting period; the attribute ``worst_case`` says how far it was searched.  Instants per
    mesh cycle or turn are those that `periodic` takes unless given, some 64 for ``static``, a multiple of the branches,
    32 with laws or turns, with tables a multiple of the branches.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : an option out of range, no load, or what the method raises.
    ConvergenceError : the method did not converge.
    """
    method, turns, of, relative_speed = options.method, options.turns, options.of, options.relative_speed
    if method == "static" and (turns is not None or of is not None or not solved_by_tone(system)):
        require_speed(relative_speed)
        count = options.samples or record_samples(system)
        window = record_of(system, cycles=options.cycles, turns=turns, of=of, samples=count, most=_SOLVED, slow=True)
        solved, forces = system, forces_of_equilibria(system, window, options.stored_cycles, progress)
    elif turns is not None or of is not None:
        raise ModelError("a record in turns is static", path="turns, of", allowed='method = "static", or cycles')
    else:
        # at rest the laws of flanks are asked; links without laws are here in either case
        solved = system if method == "static" else linear(system)
        forces = _forces_by_tone(solved, options, progress)
    mean_load = known_mean_loads(system)
    result = labelled(solved, forces, mean_load, method=method, relative_speed=relative_speed, limit=options.limit)
    if not system.errors.mesh:
        return result
    if method == "static":
        cycles = options.cycles and min(options.cycles, _STORED)  # the errors say of how many they are
        moved = static(system, StaticOptions(cycles=cycles, turns=turns, of=of, samples=options.samples))
    else:
        how: Literal["exact", "superposition"] = "superposition" if method == "superposition" else "exact"
        moved = steady(solved, SteadyOptions(relative_speed=relative_speed, method=how))
    errors = [name for name, values in moved.data_vars.items() if {"period", "error_line"} & {*values.dims}]
    return result.assign({name: moved[name] for name in errors})


def _forces_by_tone(system: System, options: SharingOptions, progress: Progress | None) -> ForceRecord:
    """Mesh forces over a record of mesh cycles of each mesh frequency."""
    method, samples = options.method, options.samples
    if samples is not None:  # the waves of every line
        waves = len(system.meshes.name) * max(1, len(system.lines))
        allowed = f"1 to {MOST_NUMBERS // (2 * waves)}"
        require_memory(2.0 * samples * waves, path="samples", given=samples, allowed=allowed)
    by_tone, notes = tone_forces(system, method, samples=samples, relative_speed=options.relative_speed)
    reference, w = by_tone[0], len(faces(system.meshes).name)
    mean, bound, unknown = np.empty(w), np.empty(w), np.full(w, "", dtype=object)
    for part in by_tone:
        mean[part.meshes], bound[part.meshes], unknown[part.meshes] = part.mean, part.bound, part.unknown
    loaded = meshes_with_load(mean, parallel_meshes(system.meshes), most=bound, rounding=rounding_of(system))
    share = max(1, reference.affordable // len(by_tone)) if len(by_tone) > 1 else reference.affordable
    cycles = options.cycles or min(reference.period, share)
    stored = min(options.stored_cycles or _STORED, cycles)
    numbers = reference.samples * w
    longest = f"at most {int(_LONGEST * _RATE / numbers)}, and {reference.period} are the hunting period"
    require_time(cycles * numbers / _RATE, _LONGEST, path="cycles", given=cycles, allowed=longest)
    most = f"at most {MOST_NUMBERS // (2 * numbers)}"
    require_memory(2.0 * stored * numbers, path="stored_cycles", given=stored, allowed=most)
    columns, how = np.empty((len(Extremes._fields) + 3, w)), ""
    for done, part in enumerate(by_tone):
        # so many as take at least as long as those of the reference
        lasting = cycles if part is reference else math.ceil(cycles * part.tone / reference.tone)
        over, slices, average = _record_extremes(part, lasting, _share_of(progress, done, len(by_tone)))
        worst, how = _worst_case(part, over, lasting)
        columns[:, part.meshes] = [*over, worst, slices, average]
    over, (worst, slices, average) = Extremes(*columns[:-3]), columns[-3:]
    static = method == "static"
    touch = OPEN_RATIO * float(over.peak.max()) if static else 0.0
    lost = slices <= touch
    parted = lost & static
    return ForceRecord(
        record=Record(
            unit=reference.tone,
            name="mesh cycles",
            count=cycles,
            samples=reference.samples,
            period=reference.period,
            period_name=period_name(system),
        ),
        over=over,
        worst=worst,
        # stiffness that follows several tones, and teeth that part, move the mean from that of the mean stiffness
        mean=average if static else mean,
        sign=np.ones(w),
        loaded=loaded,
        lost=lost,
        parted=lost,
        far=(slices < -touch) & static,
        bound=np.where(parted, np.nan, bound),
        unknown=np.where(loaded, np.where(parted, "teeth part", unknown), "").tolist(),
        history=reference.force(np.arange(stored)).transpose(1, 0, 2).reshape(w, -1),
        options={"hunting_period": reference.period, "worst_case": how},
        notes=notes,
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
    of_first = np.flatnonzero(meshes.tone[first] == meshes.tone[first[0]])
    return samples_per_cycle(meshes, of_first, _INSTANTS)


def _share_of(progress: Progress | None, done: int, count: int) -> Progress | None:
    """Progress of one mesh frequency of several, as a share of the whole."""
    return None if progress is None else lambda share: progress((done + share) / count)


def _record_extremes(part: ToneForces, cycles: int, progress: Progress | None) -> tuple[Extremes, Array, Array]:
    """Extremes (m_j,) over the record, a few MB of forces at a time.

    With them the least force of any slice of each mesh, and the mean of each (m_j,) [N].
    """
    pieces, slices, total = [], [], np.zeros(len(part.meshes))
    for index, force in part.pieces(range(cycles)):
        total += force.sum(axis=(0, 2))
        pieces.append(extremes(force, part.members))
        slices.append(part.least_slice(index) if part.face.cut.any() else pieces[-1].least)
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


# --- at rest, quickly ------------------------------------------------------------------------------------------------


class SpreadSharing(NamedTuple):
    """Load sharing of the w whole meshes at rest.

    mesh : (w,) names.  groups : indices of those that share a load.  loaded : (w,) whether they carry any.
    mean : (w,) mean force [N].  mean_load : (2, w) by `MEAN_LOADS` [1], as `sharing` gives them; nan where unknown.
    peak : (w,) largest force [N].  cycle_peak : (w,) 1 + max abs(b - 1) over the cycles [1], at most that of `sharing`.
    place : (w, c) where each cycle is in the hunting period, 0 .. 1, rising.  ratio : (w, c) cycle-peak ratio b [1].
    period : hunting period [mesh cycles of the first mesh].  quick : whether no instant had to be solved by itself.
    """

    mesh: tuple[str, ...]
    groups: tuple[MeshGroup, ...]
    loaded: NDArray[np.bool_]
    mean: Array
    mean_load: Array
    peak: Array
    cycle_peak: Array
    place: Array
    ratio: Array
    period: int
    quick: bool

    def over_period(self, parts: int) -> Array:
        """Largest ratio b in each of so many parts of the hunting period, (w, parts) [1]; nan of parts without one."""
        result = np.full((len(self.mesh), parts), np.nan)
        part = np.minimum((self.place * parts).astype(np.int64), parts - 1)
        np.fmax.at(result, (np.arange(len(part))[:, None], part), self.ratio)
        return result


def spread_sharing(system: System, *, cycles: int = 1024, patience: float = 0.1) -> SpreadSharing:
    """Load sharing of a train at rest from mesh cycles spread over the hunting period.

    Where laws of links or meshes have to be asked the cycles are few; with a memory, or cycles of several lengths, they
    stand in a row from the first on.

    Parameters
    ----------
    cycles : of each mesh frequency, at most.  patience : time that may be taken where instants have to be solved one
        by one, about [s].

    Raises
    ------
    ModelError : no load, or what the static method raises.  ConvergenceError : no equilibrium.
    """
    mean_load, _ = known_mean_loads(system)
    face, members = faces(system.meshes), parallel_meshes(system.meshes)
    quick = solved_by_tone(system)
    if quick:
        mean, peak, place, ratio, period = _by_tones(system, face, cycles, patience)
    else:
        mean, peak, place, ratio, period = _by_record(system, face, members, patience)
    loaded = meshes_with_load(mean, members, most=np.abs(peak), rounding=rounding_of(system))
    loaded = sharing_meshes(loaded, mean_load)
    ratio = np.where(loaded[:, None], ratio, np.nan)
    return SpreadSharing(
        mesh=face.name,
        groups=tuple(members),
        loaded=loaded,
        mean=mean,
        mean_load=np.where(loaded, mean_load, np.nan),
        peak=peak,
        cycle_peak=1.0 + np.abs(ratio - 1.0).max(axis=1),
        place=place,
        ratio=ratio,
        period=period,
        quick=quick and ratio.shape[1] == cycles,
    )


def _by_tones(system: System, face: Faces, cycles: int, patience: float) -> tuple[Array, Array, Array, Array, int]:
    """Mean and largest force (w,) [N], place in the period and ratio (w, c) [1], period; linear while flanks press."""
    parts, _ = tone_forces(system, "static", samples=None, relative_speed=1.0)
    # one number of cycles for all tones, so that the rows are of one length
    count = min(cycles, *(max(1, int(part.affordable * patience / _AFFORDABLE)) for part in parts))
    w = len(face.name)
    mean, peak = np.empty(w), np.empty(w)
    place, ratio = np.empty((w, count)), np.empty((w, count))
    for part in parts:
        index = spread_cycles(part.period, count)
        total, pieces = np.zeros(len(part.meshes)), []
        for _, force in part.pieces(index):
            total += force.sum(axis=(0, 2))
            pieces.append(force.max(axis=2))
        peaks = np.concatenate(pieces)
        # of a period shorter than that the cycles are repeated: whole periods, and a part of one, change no maximum
        wide = np.arange(count) * len(index) // count
        mean[part.meshes], peak[part.meshes] = total / (len(index) * part.samples), peaks.max(axis=0)
        place[part.meshes] = (index / part.period)[wide]
        ratio[part.meshes] = shares(peaks, part.members)[wide].T
    return mean, peak, place, ratio, parts[0].period


def _by_record(
    system: System, face: Faces, members: list[MeshGroup], patience: float
) -> tuple[Array, Array, Array, Array, int]:
    """The same where laws are asked, every instant solved by itself: few cycles, (w,) and (w, c)."""
    samples = record_samples(system)
    cycles = max(1, int(patience * (_TABLES if system.meshes.laws else _LAWS)) // samples)
    record = record_of(system, cycles=cycles, turns=None, of=None, samples=samples, most=1)
    # laws may have a memory, mesh cycles several lengths
    spread = len(set(system.meshes.tone.tolist())) == 1 and not system.laws.memory.any()
    if spread and record.period < _EXACT // samples:
        record = replace(record, spread=True, count=min(record.count, record.period))
    forces = forces_of_equilibria(system, record, record.count)
    force = forces.history.T
    starts = [cycle_starts(system, group, record) for group in members]
    count, span = max(len(start) for start in starts), record.period if record.spread else record.count
    place, ratio = np.empty((len(face.name), count)), np.empty((len(face.name), count))
    for group, start in zip(members, starts, strict=True):
        wide = np.arange(count) * len(start) // count  # of fewer cycles some are repeated
        peaks = np.maximum.reduceat(force[:, group], start, axis=0)
        place[group] = (record.index[start] / (record.samples * span))[wide]
        ratio[group] = shares(peaks, [np.arange(len(group))])[wide].T
    return forces.mean, forces.over.peak, place, ratio, record.period
