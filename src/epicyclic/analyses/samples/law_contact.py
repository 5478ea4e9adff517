"""Contact of samples of a train with laws: play, rolling elements and splines of links, tables of meshes.

Each sample at each phase is an instant of the batched equilibrium of `analyses.static`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...system.flank_laws import LinearAt
from ...system.gaps import FlanksAt, flanks, net_force
from ...system.system import Array, ComplexArray, Line, System
from ..static.both_flanks import HeldTrain, held_train, settled
from ..static.record import RecordExcitation, group_gap
from .load_map import LineMap, line_map

__all__ = ["LawMap", "law_forces", "law_map"]

# Phases of the mesh cycle over which the force of a table is averaged; tables follow some twelve orders, whose aliases
# in the mean begin at this one.
_MESH_PHASES = 16


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawMap:
    """Excitation of a train with laws as a linear function of its deviations.

    system : with mean mesh stiffness.  train : seen from its rows.
    excitation : of the errors of loaded flanks (m), rows of groups (R), far flanks (c) [m] and the force (n) [N, N m].
    """

    system: System
    train: HeldTrain
    excitation: LineMap


def law_map(system: System, columns: Sequence[Line] = (), *, tables: bool = False) -> LawMap:
    """The excitation of a System with laws.

    Parameters
    ----------
    columns : lines per unit of what varies between samples.  tables : whether those of meshes are asked; else their
        tangents, as linear analyses take them.
    """
    meshes, far = system.meshes, system.far_flanks
    even = replace(
        system,
        meshes=replace(meshes, variation=np.zeros_like(meshes.variation), laws=meshes.laws if tables else ()),
        far=None
        if system.far is None
        else replace(far, variation=np.zeros_like(far.variation), laws=far.laws if tables else ()),
    )
    m, R = len(meshes.name), system.group_rows.shape[1]

    def value(line: Line) -> ComplexArray:
        """Errors and force at rest of one line, (m + R + c + n,)."""
        gaps = system.flank_gaps(line)[: m + far.mesh.size]
        return np.concatenate([gaps[:m], group_gap(line, R), gaps[m:], line.force[0]])

    gaps = np.concatenate([np.zeros(m + R), meshes.backlash[far.mesh]])
    return LawMap(
        system=even,
        train=held_train(even),
        excitation=line_map(
            system,
            columns,
            value,
            constant=np.concatenate([gaps, np.zeros(len(system.force))]),
            torque=np.concatenate([np.zeros_like(gaps), system.force]),
        ),
    )


def law_forces(given: LawMap, values: Array, stiffness: Array | None) -> tuple[Array, NDArray[np.bool_]]:
    """Forces of the mesh rows (T, m) [N], negative on far flanks, of meshes with a table their mean over a mesh cycle.

    With them whether each was found (T,).

    Parameters
    ----------
    values : (T, m + R + c + n) excitation.  stiffness : (T, m) of the mesh rows without a table; None: the mean.
    """
    T, m = len(values), len(given.system.meshes.name)
    k = np.tile(given.system.meshes.stiffness, (T, 1)) if stiffness is None else stiffness
    phases = _mesh_phases(given.system)
    force, found = np.zeros((T, m)), np.ones(T, bool)
    for phase in phases:
        here = _excitation(given, values, k, phase)
        net, known = _settled(given, here)
        force += net / len(phases)
        found &= known
    return force, found


def _mesh_phases(system: System) -> Array:
    """Phases (P, tones) of the mesh frequencies [turns]; one where no mesh has a table."""
    count = max(1, len(system.tones))
    if not system.meshes.laws:
        return np.zeros((1, count))
    # several tones: a lattice that fills all combinations evenly
    step = np.mod(np.cumprod(np.r_[1, np.full(count - 1, 5)]), _MESH_PHASES)
    phases: Array = np.mod(np.outer(np.arange(_MESH_PHASES) / _MESH_PHASES, step), 1.0)
    return phases


def _excitation(given: LawMap, values: Array, stiffness: Array, phase: Array) -> RecordExcitation:
    """Excitation of T instants at one phase (tones,) of the mesh cycle [turns]."""
    system = given.system
    m, R, c = len(system.meshes.name), system.group_rows.shape[1], system.far_flanks.mesh.size
    gap, far, force = np.split(values, [m + R, m + R + c], axis=1)
    if system.meshes.laws:
        laws = flanks(system).at(np.tile(phase, (len(values), 1)))
    else:
        both = np.hstack([stiffness, stiffness[:, system.far_flanks.mesh]])
        laws = FlanksAt(parts=((LinearAt(stiffness=both), slice(0, m + c)),), count=m + c)
    return RecordExcitation(
        stiffness=stiffness,
        gap=gap,
        link_gap=np.zeros((len(values), 0)),
        force=force,
        flanks=laws.rows(slice(0, m)),
        far_gap=far if c else None,
        both=laws if c else None,
    )


def _settled(given: LawMap, here: RecordExcitation) -> tuple[Array, NDArray[np.bool_]]:
    """Net forces (T, m) [N] at T instants and whether each was found; one without does not stop the others."""
    T = len(here.gap)
    try:
        state = settled(given.train, here, given.system.laws)
    except (ModelError, ConvergenceError):
        if T == 1:
            return np.full((1, here.stiffness.shape[1]), np.nan), np.zeros(1, bool)
        halves = [_settled(given, here.at(part)) for part in np.array_split(np.arange(T), 2)]
        return np.concatenate([half[0] for half in halves]), np.concatenate([half[1] for half in halves])
    far = given.train.far.mesh[: state.far_force.shape[1]]
    return net_force(np.hstack([state.mesh_force, state.far_force]), far), np.ones(T, bool)
