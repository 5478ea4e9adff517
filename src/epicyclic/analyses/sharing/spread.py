"""Load sharing at rest, quickly: mesh cycles spread over the hunting period, without the search for its worst case.

Of one line of frequency p/q per mesh frequency the mesh cycles 0, d, 2 d ... take every phase in turn where d and q
share no factor.  The step d is the first from an even division of the period on that shares no factor with the period,
so that the cycles are even in time and the phases of every line are too, whatever the tooth numbers (a step that
divides the period would leave some lines at one phase).  Derived here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...statics.quasi_static import balanced, held_train, quasi_static, settled
from ...statics.record import MeshGroup, Record, excitation, parallel_meshes, record_of
from ...statics.static import flank_contact, rounding_of
from ...system.system import Array, Faces, System, faces
from .definitions import cycle_peak_ratio
from .outputs import known_mean_loads, meshes_with_load
from .sharing import record_samples, solved_by_tone
from .static_record import cycle_starts
from .tone_forces import ToneForces, tone_forces

__all__ = ["SpreadSharing", "spread_cycles", "spread_sharing"]

# Seconds that a record of the length affordable by default takes where instants are solved one by one.
_AFFORDABLE = 5.0
# Instants solved in a second where laws of links are asked, and where those of meshes are tables.
_LAWS, _TABLES = 15_000.0, 3_000.0
# Instants counted from the first of a period stay exact below.
_EXACT = 2**62
# Forces worked on at once (8 bytes each): about 2 MB.
_PIECE = 250_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpreadSharing:
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
        result = np.full((len(self.mesh), parts), -np.inf)
        part = np.minimum((self.place * parts).astype(np.int64), parts - 1)
        for row in np.flatnonzero(self.loaded):
            np.maximum.at(result[row], part[row], self.ratio[row])
        return np.where(np.isneginf(result), np.nan, result)


def spread_cycles(period: int, count: int) -> NDArray[np.int64]:
    """At most `count` mesh cycles of a hunting period, rising, at phases of all lines as even as may be, (c,)."""
    if period <= count:
        return np.arange(period, dtype=np.int64)
    step = -(-period // count)
    while math.gcd(step, period) > 1:  # next to any number there is a coprime one within a few steps
        step += 1
    # Python's integers: period times count may be beyond 64 bits
    return np.array(sorted(place * step % period for place in range(count)), dtype=np.int64)


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
    if cycles < 1:
        raise ModelError("must be at least 1", path="cycles", given=cycles, allowed=">= 1")
    if not 0 < patience < math.inf:
        raise ModelError("must be above zero", path="patience", given=patience, allowed="> 0")
    mean_load, _ = known_mean_loads(system)
    face, members = faces(system.meshes), parallel_meshes(system.meshes)
    quick = solved_by_tone(system)
    if quick:
        mean, peak, place, ratio, period = _by_tones(system, face, cycles, patience)
    else:
        mean, peak, place, ratio, period = _by_record(system, face, members, patience)
    loaded = meshes_with_load(mean, members, most=np.abs(peak), rounding=rounding_of(system))
    ratio = np.where(loaded[:, None], ratio, np.nan)
    with np.errstate(invalid="ignore"):
        most = 1.0 + np.max(np.abs(ratio - 1.0), axis=1)
    return SpreadSharing(
        mesh=face.name,
        groups=tuple(members),
        loaded=loaded,
        mean=mean,
        mean_load=np.where(loaded, mean_load, np.nan),
        peak=peak,
        cycle_peak=most,
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
        total, peaks = _peaks(part, index)
        # of a period shorter than that the cycles are repeated: whole periods, and a part of one, change no maximum
        wide = np.resize(np.arange(len(index)), count)
        wide.sort()
        mean[part.meshes], peak[part.meshes] = total, peaks.max(axis=0)
        place[part.meshes] = (index / part.period)[wide]
        ratio[part.meshes] = cycle_peak_ratio(peaks, part.members)[wide].T
    return mean, peak, place, ratio, parts[0].period


def _peaks(part: ToneForces, index: NDArray[np.int64]) -> tuple[Array, Array]:
    """Mean force (m_j,) over cycles (c,), and the peak of each of them (c, m_j) [N]."""
    piece = max(1, _PIECE // (len(part.meshes) * part.samples))
    peaks, total = [], np.zeros(len(part.meshes))
    for first in range(0, len(index), piece):
        force = part.own(index[first : first + piece])
        total += force.sum(axis=(0, 2))
        peaks.append(force.max(axis=2))
    return total / (len(index) * part.samples), np.concatenate(peaks)


def _by_record(
    system: System, face: Faces, members: list[MeshGroup], patience: float
) -> tuple[Array, Array, Array, Array, int]:
    """The same where laws are asked, every instant solved by itself: few cycles, (w,) and (w, c)."""
    samples = record_samples(system)
    cycles = max(1, int(patience * (_TABLES if system.meshes.laws else _LAWS)) // samples)
    record = record_of(system, cycles=cycles, turns=None, of=None, samples=samples, most=1)
    spread = len(set(system.meshes.tone.tolist())) == 1 and not system.laws.memory.any()
    apart = spread and record.period < _EXACT // samples
    forces = _apart(system, record, samples) if apart else _in_a_row(system, record)
    contact = flank_contact(system, [forces])
    force = face.total(contact.force, axis=1)
    turned = np.ones(len(face.name))
    for group in members:
        turned[group] = -1.0 if force[:, group].mean(axis=0).sum() < 0 else 1.0
    force = force * turned
    place, ratio = _cycle_ratios(system, members, record, force)
    if apart:
        place = np.tile(spread_cycles(record.period, record.count) / record.period, (len(place), 1))
    return force.mean(axis=0), force.max(axis=0), place, ratio, record.period


def _apart(system: System, record: Record, samples: int) -> tuple[Array, Array]:
    """Forces (T, m) on the loaded and (T, c) on the far flanks [N] in as many cycles spread over the period."""
    train = held_train(system)
    index = (spread_cycles(record.period, record.count)[:, None] * samples + np.arange(samples)).ravel()
    here = excitation(system, record.unit, index, samples)
    balanced(train, here.force)
    state = settled(train, here)
    return state.mesh_force, state.far_force


def _in_a_row(system: System, record: Record) -> tuple[Array, Array]:
    """The same of a record, whose laws may have a memory or whose mesh cycles are of several lengths."""
    states = [piece.state for piece in quasi_static(held_train(system), record)]
    return np.concatenate([one.mesh_force for one in states]), np.concatenate([one.far_force for one in states])


def _cycle_ratios(system: System, members: list[MeshGroup], record: Record, force: Array) -> tuple[Array, Array]:
    """Place in the record and cycle-peak ratio (w, c) [1] of forces (T, w) [N]; of fewer cycles repeated."""
    starts = [cycle_starts(system, group, record) for group in members]
    count = max(len(start) for start in starts)
    place, ratio = np.empty((force.shape[1], count)), np.empty((force.shape[1], count))
    for group, start in zip(members, starts, strict=True):
        wide = np.arange(count) * len(start) // count
        found = cycle_peak_ratio(np.maximum.reduceat(force[:, group], start, axis=0), [np.arange(len(group))])
        place[group], ratio[group] = (start / record.instants)[wide], found[wide].T
    return place, ratio
