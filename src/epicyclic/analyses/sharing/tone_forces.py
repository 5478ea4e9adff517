"""The mesh forces of a record by mesh frequency: meshes that share one, in their own mesh cycles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...questions.response.periodic import periodic_by_tone, superposed
from ...statics.equilibrium import closed_force
from ...statics.quasi_static import HeldTrain, balanced, held_train, settled
from ...statics.record import (
    MeshGroup,
    excitation_at,
    hunting_cycles,
    parallel_meshes,
    positive_count,
    reference_tone,
    samples_per_cycle,
)
from ...statics.static import free_position_warnings
from ...statics.unheld import standing_load
from ...system.system import Array, System, faces
from ...warning_codes import CodedText
from .outputs import require_speed
from .waves import Waves, cycle_forces, far_waves, force_bound, line_phases, periodic_waves, static_waves

__all__ = ["Method", "ToneForces", "mean_force", "tone_forces"]

Method = Literal["steady", "superposition", "static"]
Index = NDArray[np.int64]

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ToneForces:
    """Forces of the whole meshes of one mesh frequency; slices are summed.

    tone : that frequency [Hz at the operating speed].  meshes : (m_j,) their indices.
    members : their groups, as places in `meshes`.
    force, own : cycles of the tone (c,) -> forces (c, m or m_j, samples) [N] of all meshes of the train, or of these.
    by_phase : phases (c, L) [turns] at the start of cycles -> forces (c, m_j, samples) [N].
    ratios : (L,) frequencies of these phases per tone, exact.  period : cycles after which all repeats.
    mean, bound : (m_j,) [N], the bound nan where not known, and `unknown` says why.  samples : of a cycle.
    affordable : cycles a record may have by default.
    least_slice : cycles -> smallest force of any slice of each mesh (m_j,) [N]; None where no mesh is cut.
    """

    tone: Fraction
    meshes: Index
    members: list[MeshGroup]
    force: Callable[[Index], Array]
    own: Callable[[Index], Array]
    by_phase: Callable[[Array], Array]
    ratios: tuple[Fraction, ...]
    period: int
    mean: Array
    bound: Array
    samples: int
    affordable: int
    least_slice: Callable[[Index], Array] | None = None
    unknown: str = ""


def tone_forces(
    system: System, method: str, *, samples: int | None, relative_speed: float
) -> tuple[tuple[ToneForces, ...], list[CodedText]]:
    """Forces by mesh frequency, that of the first mesh first, and warnings of the method.

    Raises
    ------
    ModelError, ConvergenceError : no such method, or what the method raises.
    """
    if method in ("steady", "superposition"):
        return _steady_by_tone(system, method, samples, relative_speed), []
    if method != "static":
        raise ModelError("no such method", path="method", given=method, allowed="steady, superposition, static")
    require_speed(relative_speed)
    train = held_train(system)
    tones = tuple(dict.fromkeys(system.tones[i] for i in system.meshes.tone)) if system.tones else ()
    # without a speed time is counted in mesh cycles, and all meshes follow the one tone of that
    moving = zip(system.meshes.tone, system.meshes.variation, strict=True) if system.tones else ()
    varying = {system.tones[i] for i, variation in moving if variation.any()}
    found = []
    for tone in tones or (reference_tone(system),):
        build = _static_by_lines if len(tones) < 2 or varying <= {tone} else _static_by_instants
        fitting = samples_per_cycle(system.meshes, _members(system, tone)[0], 64)
        found.append(build(system, train, tone, positive_count("samples", samples, fitting)))
    return tuple(found), free_position_warnings(system, train.loaded.free)


def _steady_by_tone(system: System, method: str, samples: int | None, relative_speed: float) -> tuple[ToneForces, ...]:
    """Forces of the periodic response, with every frequency alone on the mean system for ``superposition``."""
    solvable = system if method == "steady" else superposed(system, relative_speed)
    solutions = periodic_by_tone(solvable, relative_speed=relative_speed, samples=samples)
    return tuple(
        _forces_from_waves(system, solution.tone, periodic_waves(solution), bound=solution.bound)
        for solution in solutions
    )


def _members(system: System, tone: Fraction) -> tuple[Index, list[MeshGroup]]:
    """Whole meshes (m_j,) of one tone and their groups among themselves; all of them where there are no tones."""
    own = [not system.tones or system.tones[i] == tone for i in system.meshes.tone[faces(system.meshes).first]]
    meshes = np.flatnonzero(own)
    place = {int(mesh): i for i, mesh in enumerate(meshes)}
    found = [group for group in parallel_meshes(system.meshes) if int(group[0]) in place]
    return meshes, [np.array([place[int(i)] for i in group]) for group in found]


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
    source : phases (c, L) [turns] -> forces of all mesh rows (c, m, samples) [N].
    """
    (meshes, members), face = _members(system, tone), faces(system.meshes)
    summed = replace(waves, mean=face.total(waves.mean), amplitude=face.total(waves.amplitude, axis=1))
    mine = summed if len(meshes) == len(summed.mean) else summed.subset(meshes)
    affordable = _RECORD // mine.mean.size // max(1, len(waves.ratios) // _LINES)
    if source is not None:
        first = cycle_forces(waves, line_phases(waves.ratios, np.arange(_FIRST)))
        affordable = min(affordable, _SOLVED * _FIRST // max(1, int(np.sum(np.any(first < 0, axis=1)))))

    def rows(phases: Array) -> Array:
        """Forces of all mesh rows, phases (c, L) [turns] -> (c, m, samples) [N]."""
        return cycle_forces(waves, phases) if source is None else source(phases)

    def least_slice(cycles: Index) -> Array:
        """Smallest force of any slice of each mesh over the cycles (c,), (m_j,) [N]."""
        return face.least(rows(line_phases(waves.ratios, cycles)).min(axis=(0, 2)))[meshes]

    def whole(phases: Array) -> Array:
        """Forces of all whole meshes, phases (c, L) [turns] -> (c, w, samples) [N]."""
        return cycle_forces(summed, phases) if source is None else face.total(source(phases), axis=1)

    def mine_at(phases: Array) -> Array:
        """Forces of the meshes of this tone, phases (c, L) [turns] -> (c, m_j, samples) [N]."""
        return cycle_forces(mine, phases) if source is None else whole(phases)[:, meshes]

    return ToneForces(
        tone=tone,
        meshes=meshes,
        members=members,
        force=lambda cycles: whole(line_phases(waves.ratios, cycles)),
        own=lambda cycles: mine_at(line_phases(waves.ratios, cycles)),
        by_phase=mine_at,
        ratios=waves.ratios,
        period=hunting_cycles(waves.ratios),
        mean=mine.mean.mean(axis=1),
        bound=force_bound(mine) if bound is None else bound[meshes],
        samples=waves.samples,
        affordable=max(1, affordable),
        least_slice=least_slice if face.cut.any() else None,
    )


def _static_by_lines(system: System, train: HeldTrain, tone: Fraction, samples: int) -> ToneForces:
    """Static mesh forces where stiffness follows one tone at most: linear in the lines while loaded flanks press."""
    waves, reach = static_waves(system, train.loaded, tone, samples), far_waves(system, train, tone, samples)
    found = _forces_from_waves(system, tone, waves, _unilateral(system, train, tone, (waves, reach)))
    if reach is None:
        return found
    return replace(found, bound=np.full(len(found.meshes), np.nan), unknown=_FAR_FLANKS)


def _unilateral(
    system: System, train: HeldTrain, tone: Fraction, both: tuple[Waves, Waves | None]
) -> Callable[[Array], Array]:
    """Static mesh forces, phases (c, L) [turns] -> (c, m, samples) [N]: linear while all loaded flanks press, alone.

    Instants at which one would pull, or a far flank press, are solved anew.  both : waves of the forces, and of how far
    far flanks reach beyond first touch, where any does.
    """
    waves, reach = both
    theta = np.arange(waves.samples) / waves.samples
    ratios = [line.frequency / tone for line in system.lines]
    slow = [i for i, ratio in enumerate(ratios) if ratio.denominator != 1]
    turning = np.array([float(ratio) for ratio in ratios])

    def source(phases: Array) -> Array:
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
            here = excitation_at(system, np.exp(2j * np.pi * angle), mesh, links=False)
            result[c, :, j] = train.net_force(settled(train, here))
        return result

    return source


def mean_force(system: System, train: HeldTrain | None = None) -> Array:
    """Forces of the mesh rows (m,) [N] under what stands still, all loaded flanks closed, tension allowed.

    Raises
    ------
    ModelError : a load that nothing balances.
    """
    train = held_train(system) if train is None else train
    still = [line for line in system.lines if line.frequency == 0]
    load = standing_load(system)
    gap = sum((line.gap.real for line in still), np.zeros(len(system.meshes.name)))
    balanced(train, load[None])
    flexible = train.loaded
    force: Array = closed_force(flexible, flexible.stiffness[None], gap[None], load[None])[0][0]
    return force


def _static_by_instants(system: System, train: HeldTrain, tone: Fraction, samples: int) -> ToneForces:
    """Static mesh forces where the stiffness follows several tones: every instant solved by itself."""
    (meshes, members), face = _members(system, tone), faces(system.meshes)
    mean = mean_force(system, train)

    lines, tones = system.lines, system.tones
    ratios = (*(line.frequency / tone for line in lines), *(other / tone for other in tones))
    within = np.outer(np.arange(samples) / samples, [float(ratio) for ratio in ratios])

    def rows(phases: Array) -> Array:
        """Forces of all mesh rows, phases (c, L) [turns] -> (c, m, samples) [N]."""
        turns = (phases[:, None] + within).reshape(-1, len(ratios))
        waves = np.exp(2j * np.pi * turns[:, : len(lines)])
        here = excitation_at(system, waves, turns[:, len(lines) :], links=False)
        balanced(train, here.force)
        return train.net_force(settled(train, here)).reshape(len(phases), samples, -1).transpose(0, 2, 1)

    def least_slice(cycles: Index) -> Array:
        """Smallest force of any slice of each mesh over the cycles (c,), (m_j,) [N]."""
        return face.least(rows(line_phases(ratios, cycles)).min(axis=(0, 2)))[meshes]

    def by_phase(phases: Array) -> Array:
        """Forces of all whole meshes, phases (c, L) [turns] -> (c, w, samples) [N]."""
        return face.total(rows(phases), axis=1)

    def force(cycles: Index) -> Array:
        """Forces of all whole meshes in the cycles (c,), (c, w, samples) [N]."""
        return by_phase(line_phases(ratios, cycles))

    return ToneForces(
        tone=tone,
        meshes=meshes,
        members=members,
        force=force,
        own=lambda cycles: force(cycles)[:, meshes],
        by_phase=lambda phases: by_phase(phases)[:, meshes],
        ratios=ratios,
        period=hunting_cycles(ratios),
        mean=face.total(mean)[meshes],
        bound=np.full(len(meshes), np.nan),
        samples=samples,
        affordable=max(1, _SOLVED // samples // 4),
        least_slice=least_slice if face.cut.any() else None,
        unknown=_SEVERAL_TONES,
    )
