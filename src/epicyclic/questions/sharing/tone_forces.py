"""The mesh forces of a record: by mesh frequency, in mesh cycles of their own; or from static equilibria, one by one.

Those that share a mesh frequency stand together.  A record of equilibria is taken with laws of links or meshes, or in
turns of a body.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...statics.equilibrium import closed_state
from ...statics.record import (
    MeshGroup,
    Record,
    excitation_at,
    hunting_cycles,
    parallel_meshes,
    reference_tone,
    samples_per_cycle,
    standing_excitation,
)
from ...statics.static import (
    HeldTrain,
    RecordPiece,
    balanced,
    contact_shares,
    flank_contact,
    free_position_warnings,
    group_columns,
    held_train,
    law_attributes,
    mesh_contact,
    quasi_static,
    rounding_of,
    settled,
)
from ...system.gaps import flanks, groups_past_the_end, past_the_end
from ...system.system import Array, Faces, Index, System, faces
from ...warning_codes import CodedText
from ..response.measures import periodic_by_tone, superposed
from .definitions import (
    Extremes,
    ForceRecord,
    Waves,
    cycle_forces,
    extremes,
    far_waves,
    force_bound,
    line_phases,
    meshes_with_load,
    periodic_waves,
    require_speed,
    static_waves,
)

Method = Literal["steady", "superposition", "static"]

# Numbers worked on at once (8 bytes each): about 2 MB.
_PIECE = 250_000
# Numbers over the whole record: some seconds of work.
_RECORD = 300_000_000
# Lines of a record beyond which its work grows with their number.
_LINES = 16
# Instants with open meshes that a record may have by default, each some 50 us.
_SOLVED = 100_000
# Cycles from which the share of instants with open meshes is estimated.
_FIRST = 64
# Why the largest force over all phases is not known.
_FAR_FLANKS = "far flanks may touch while all loaded ones do"
_SEVERAL_TONES = "the stiffness follows several mesh frequencies, and each instant is solved by itself"
_PART = "the record is shorter than the common period"
# Instants of a record of equilibria stored by default: a few MB.
_STORED = 20_000


# --- by mesh frequency -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ToneForces:
    """Forces of the whole meshes of one mesh frequency; slices are summed.

    tone : that frequency [Hz at the operating speed].  meshes : (m_j,) their indices.
    members : their groups, as places in `meshes`.  face : the whole meshes of the train, with their rows.
    rows : phases (c, L) [turns] at the start of cycles -> forces (c, m, samples) [N] of the mesh rows.
    ratios : (L,) frequencies of these phases per tone, exact.  samples : of a cycle.
    mean, bound : (m_j,) [N], the bound nan where not known, and `unknown` says why.
    affordable : cycles a record may have by default.
    waves : of the whole meshes, where their forces are sums of lines at every instant.
    """

    tone: Fraction
    meshes: Index
    members: list[MeshGroup]
    face: Faces
    rows: Callable[[Array], Array]
    ratios: tuple[Fraction, ...]
    samples: int
    mean: Array
    bound: Array
    affordable: int
    unknown: str = ""
    waves: Waves | None = None

    @property
    def period(self) -> int:
        """Cycles after which all repeats."""
        return hunting_cycles(self.ratios)

    def whole(self, phases: Array) -> Array:
        """Forces of all whole meshes of the train, phases (c, L) [turns] -> (c, w, samples) [N]."""
        if self.waves is not None:
            return cycle_forces(self.waves, phases)
        return self.face.total(self.rows(phases), axis=1)

    def by_phase(self, phases: Array) -> Array:
        """Forces of the meshes of this tone, phases (c, L) [turns] -> (c, m_j, samples) [N]."""
        if len(self.meshes) == len(self.face.name):
            return self.whole(phases)
        if self.waves is not None:
            return cycle_forces(self.waves.subset(self.meshes), phases)
        return self.whole(phases)[:, self.meshes]

    def force(self, cycles: Index) -> Array:
        """Forces of all whole meshes of the train in cycles (c,) of the tone, (c, w, samples) [N]."""
        return self.whole(line_phases(self.ratios, cycles))

    def pieces(self, cycles: Index | range) -> Iterator[tuple[Index, Array]]:
        """Forces of the meshes of this tone (c, m_j, samples) [N], some MB at a time, and in which of the cycles."""
        step = max(1, _PIECE // (len(self.meshes) * self.samples))
        for first in range(0, len(cycles), step):
            index = np.asarray(cycles[first : first + step], np.int64)
            yield index, self.by_phase(line_phases(self.ratios, index))

    def least_slice(self, cycles: Index) -> Array:
        """Smallest force of any slice of each mesh over cycles (c,), (m_j,) [N]."""
        return self.face.least(self.rows(line_phases(self.ratios, cycles)).min(axis=(0, 2)))[self.meshes]


def tone_forces(
    system: System, method: str, *, samples: int | None, relative_speed: float
) -> tuple[tuple[ToneForces, ...], list[CodedText]]:
    """Forces by mesh frequency, that of the first mesh first, and warnings of the method.

    Raises
    ------
    ModelError, ConvergenceError : no such method, or what the method raises.
    """
    if method in ("steady", "superposition"):
        solvable = system if method == "steady" else superposed(system, relative_speed)
        return tuple(
            _forces_from_waves(system, solution.tone, periodic_waves(solution), bound=solution.bound)
            for solution in periodic_by_tone(solvable, relative_speed=relative_speed, samples=samples)
        ), []
    if method != "static":
        raise ModelError("no such method", path="method", given=method, allowed="steady, superposition, static")
    require_speed(relative_speed)
    train = held_train(system)
    tones = tuple(dict.fromkeys(system.tones[i] for i in system.meshes.tone)) if system.tones else ()
    # without a speed time is counted in mesh cycles, and all meshes follow the one tone of that
    moving = zip(system.meshes.tone, system.meshes.variation, strict=True) if system.tones else ()
    varying = {system.tones[i] for i, variation in moving if variation.any()}
    by_tone = []
    for tone in tones or (reference_tone(system),):
        build = _static_by_lines if len(tones) < 2 or varying <= {tone} else _static_by_instants
        fitting = samples_per_cycle(system.meshes, _members(system, tone)[0], 64)
        by_tone.append(build(system, train, tone, samples or fitting))
    return tuple(by_tone), free_position_warnings(system, train.loaded.free)


def _members(system: System, tone: Fraction) -> tuple[Index, list[MeshGroup]]:
    """Whole meshes (m_j,) of one tone and their groups among themselves; all of them where there are no tones."""
    of_tone = [not system.tones or system.tones[i] == tone for i in system.meshes.tone[faces(system.meshes).first]]
    meshes = np.flatnonzero(of_tone)
    groups = [group for group in parallel_meshes(system.meshes) if int(group[0]) in meshes]
    return meshes, [np.searchsorted(meshes, group) for group in groups]


def _forces_from_waves(
    system: System,
    tone: Fraction,
    waves: Waves,
    source: Callable[[Array], Array] | None = None,
    *,
    bound: Array | None = None,
) -> ToneForces:
    """Forces of a record that is a sum of lines; `source` where instants with open meshes are solved anew.

    bound : (w,) largest forces of all whole meshes [N]; None: of the sum of the lines.  Harmonics of another mesh
        frequency are lines here whose phases are tied: their sum would be too large.
    source : as of `ToneForces.rows`.
    """
    (meshes, members), face = _members(system, tone), faces(system.meshes)
    summed = replace(waves, mean=face.total(waves.mean), amplitude=face.total(waves.amplitude, axis=1))
    affordable = _RECORD // (len(meshes) * waves.samples) // max(1, len(waves.ratios) // _LINES)
    if source is not None:
        first = cycle_forces(waves, line_phases(waves.ratios, np.arange(_FIRST)))
        affordable = min(affordable, _SOLVED * _FIRST // max(1, int(np.sum(np.any(first < 0, axis=1)))))
    return ToneForces(
        tone=tone,
        meshes=meshes,
        members=members,
        face=face,
        rows=partial(cycle_forces, waves) if source is None else source,
        ratios=waves.ratios,
        samples=waves.samples,
        mean=summed.mean.mean(axis=1)[meshes],
        bound=(force_bound(summed) if bound is None else bound)[meshes],
        affordable=max(1, affordable),
        waves=summed if source is None else None,
    )


def _static_by_lines(system: System, held: HeldTrain, tone: Fraction, samples: int) -> ToneForces:
    """Static mesh forces where stiffness follows one tone at most: linear in the lines while loaded flanks alone press.

    Instants at which one would pull, or a far flank press, are solved anew.
    """
    waves, reach = static_waves(system, held.loaded, tone, samples), far_waves(system, held, tone, samples)
    theta = np.arange(samples) / samples
    ratios = [line.frequency / tone for line in system.lines]
    slow = [i for i, ratio in enumerate(ratios) if ratio.denominator != 1]
    turning = np.array([float(ratio) for ratio in ratios])

    def rows(phases: Array) -> Array:
        """Forces of all mesh rows, phases (c, L) [turns] -> (c, m, samples) [N]."""
        result = cycle_forces(waves, phases)
        leaves = np.any(result < 0, axis=1)
        if reach is not None:
            leaves |= np.any(cycle_forces(reach, phases) > 0, axis=1)
        cycle, instant = np.nonzero(leaves)
        for first in range(0, len(cycle), 2048):
            c, j = cycle[first : first + 2048], instant[first : first + 2048]
            angle = np.outer(theta[j], turning)
            angle[:, slow] += phases[c]
            # only this tone varies the stiffness: the phases of others do not matter
            mesh = np.tile(theta[j, None], (1, max(1, len(system.tones))))
            excited = excitation_at(system, np.exp(2j * np.pi * angle), mesh)
            result[c, :, j] = held.net_force(settled(held, excited))
        return result

    forces = _forces_from_waves(system, tone, waves, rows)
    if reach is None:
        return forces
    return replace(forces, bound=np.full(len(forces.meshes), np.nan), unknown=_FAR_FLANKS)


def mean_force(system: System, held: HeldTrain | None = None) -> Array:
    """Forces of the mesh rows (m,) [N] under what stands still, all loaded flanks closed, tension allowed.

    Raises
    ------
    ModelError : a load that nothing balances.
    """
    held = held_train(system) if held is None else held
    excited, k = standing_excitation(system)[None], held.loaded.stiffness[None]
    gap, load = excited[:, : k.size], excited[:, -len(system.force) :]
    balanced(held, load)
    return np.asarray(closed_state(held.loaded, k, gap, load)[1][0])


def _static_by_instants(system: System, held: HeldTrain, tone: Fraction, samples: int) -> ToneForces:
    """Static mesh forces where the stiffness follows several tones: every instant solved by itself."""
    (meshes, members), face = _members(system, tone), faces(system.meshes)
    mean = mean_force(system, held)

    lines, tones = system.lines, system.tones
    ratios = (*(line.frequency / tone for line in lines), *(other / tone for other in tones))
    within = np.outer(np.arange(samples) / samples, [float(ratio) for ratio in ratios])

    def rows(phases: Array) -> Array:
        """Forces of all mesh rows, phases (c, L) [turns] -> (c, m, samples) [N]."""
        turns = (phases[:, None] + within).reshape(-1, len(ratios))
        waves = np.exp(2j * np.pi * turns[:, : len(lines)])
        excited = excitation_at(system, waves, turns[:, len(lines) :])
        balanced(held, excited.force)
        return held.net_force(settled(held, excited)).reshape(len(phases), samples, -1).transpose(0, 2, 1)

    return ToneForces(
        tone=tone,
        meshes=meshes,
        members=members,
        face=face,
        rows=rows,
        ratios=ratios,
        samples=samples,
        mean=face.total(mean)[meshes],
        bound=np.full(len(meshes), np.nan),
        affordable=max(1, _SOLVED // samples // 4),
        unknown=_SEVERAL_TONES,
    )


# --- from static equilibria ------------------------------------------------------------------------------------------


def forces_of_equilibria(
    system: System, record: Record, stored: int | None, progress: Callable[[float], None] | None = None
) -> ForceRecord:
    """Mesh forces over a record of static equilibria.

    A mesh cycle is that of the group's own mesh frequency; where fewer instants than one fall into a cycle, each is
    its own peak.  The worst case is known where the record covers the common period of all lines, else it is nan.
    Meshes of a group that carries its mean load on the far flanks share that load: their coefficients take the force
    on the far flanks as positive, ``mesh_force`` does not.

    Parameters
    ----------
    stored : units kept of forces and ratios, all up to 20 000 instants where None.

    Raises
    ------
    ModelError : no load, or a load that nothing balances or holds.  ConvergenceError : no equilibrium.
    """
    kept = stored or max(1, min(record.count, _STORED // record.samples))
    train = held_train(system)
    forces: list[tuple[Array, Array]] = []
    pieces: list[RecordPiece] = []
    links: list[Array] = []
    for piece in quasi_static(train, record, progress):
        if sum(len(loaded) for loaded, _ in forces) < kept * record.samples:
            pieces.append(piece)
        forces.append((piece.state.mesh_force, piece.state.far_force))
        links.append(system.laws.rows.size(piece.state.group_force).max(axis=0, initial=0.0))
    contact = flank_contact(system, forces)
    members, face = parallel_meshes(system.meshes), faces(system.meshes)
    net = face.total(contact.force, axis=1)
    mean, sign = net.mean(axis=0), np.ones(len(face.name))
    for group in members:
        sign[group] = -1.0 if mean[group].sum() < 0 else 1.0
    force, touching = sign * net, mesh_contact(face, contact)
    loaded = meshes_with_load(sign * mean, members, most=np.abs(force).max(axis=0), rounding=rounding_of(system))
    over = record_extremes(force, members, [cycle_starts(system, group, record) for group in members])
    whole, last = record.count >= record.period, min(kept, record.count) * record.samples
    notes = [*free_position_warnings(system, train.loaded.free), *past_the_end(system, flanks(system), contact.largest)]
    notes += groups_past_the_end(system, np.max(links, axis=0))
    return ForceRecord(
        record=record,
        over=over,
        worst=over.cycle_peak if whole else np.full(len(mean), np.nan),
        mean=sign * mean,
        sign=sign,
        loaded=loaded,
        lost=face.any(np.asarray(~contact.loaded.all(axis=0))),
        parted=np.asarray(~touching.all(axis=0)),
        far=face.any(np.asarray(contact.far.any(axis=0))),
        bound=np.where(whole, net.max(axis=0), np.nan),
        unknown=[_PART] * len(mean),
        history=force[:last].T,
        options={
            "record": f"{record.count} {record.name}, {record.instants} instants",
            "common_period": record.period,
            "worst_case": "every cycle of the common period" if whole else "not known",
        },
        notes=notes,
        columns={
            "mesh_contact": (("mesh", "time"), touching[:last].T),
            **contact_shares(system, face, contact),
            **{name: (dims, array[:, :last]) for name, (dims, array) in group_columns(system, pieces).items()},
        },
        provenance=law_attributes(system, record),
    )


def record_extremes(force: Array, members: Sequence[MeshGroup], starts: Sequence[NDArray[np.int64]]) -> Extremes:
    """Extremes over a record (T, m) [N] whose mesh cycles start at given instants (cycles,), for each group its own."""
    over = np.empty((len(Extremes._fields), force.shape[1]))
    for group, start in zip(members, starts, strict=True):
        # a cycle of fewer instants than another repeats its last one
        end = np.append(start[1:], len(force))[:, None]
        instant = np.minimum(start[:, None] + np.arange(np.max(end[:, 0] - start)), end - 1)
        in_cycles = force[:, group][instant].transpose(0, 2, 1)
        over[:, group] = extremes(in_cycles, [np.arange(len(group))])
    return Extremes(*over)


def cycle_starts(system: System, group: MeshGroup, record: Record) -> NDArray[np.int64]:
    """First instant of every mesh cycle of a group that holds any, (cycles,), exact."""
    tone = system.tones[int(system.meshes.tone[faces(system.meshes).first[group[0]]])] if system.tones else Fraction(1)
    ratio = tone / record.unit / record.samples
    cycle = np.arange(record.instants, dtype=object) * ratio.numerator // ratio.denominator
    changed = np.flatnonzero(np.diff(cycle.astype(np.int64))) + 1
    return np.concatenate([[0], changed]).astype(np.int64)
