"""What is reported of a motion with contact loss: forces of meshes, ways of coordinates, how long teeth are apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...system.faces import faces
from ...system.system import Array, System
from ..steady.waveform import peak
from .problem import Problem, State, flank_force

__all__ = ["Measures", "force_level", "measured", "net_force", "of_record"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Measures:
    """What is reported.

    rms, highest, lowest : (w,) of the force of every whole mesh [N], its far flank negative.
    open : (w,) part of the time in which no flank of it touches.  amplitude : (n,) half the way of a coordinate [m].
    """

    rms: Array
    highest: Array
    lowest: Array
    open: Array
    amplitude: Array


def net_force(system: System, force: Array) -> Array:
    """Forces of whole meshes (N, w) from those of flanks (N, R), far flanks counted negative."""
    m = len(system.meshes.name)
    net = force[:, :m].copy()
    np.subtract.at(net.T, system.far_flanks.mesh[: force.shape[1] - m], force[:, m:].T)
    total: Array = faces(system.meshes).total(net, axis=1)
    return total


def force_level(system: System, given: Problem, state: State) -> Array:
    """RMS of the dynamic force of every whole mesh, (w,) [N]."""
    level: Array = net_force(system, flank_force(given, state)).std(axis=0)
    return level


def measured(system: System, given: Problem, state: State) -> Measures:
    """Measures of a periodic motion."""
    motion = given.grid.values(state.y.reshape(-1, state.y.shape[2])) @ given.modal.shapes.T
    return _measures(system, flank_force(given, state), state.touching, motion, smooth=len(given.grid.counts) == 1)


def of_record(system: System, force: Array, motion: Array) -> Measures:
    """Measures of a record of flank forces (N, R) and coordinates (N, n) over time."""
    return _measures(system, force, force != 0, motion, smooth=False)


def _measures(system: System, force: Array, touching: np.ndarray, motion: Array, *, smooth: bool) -> Measures:
    face, net = faces(system.meshes), net_force(system, force)
    m = len(system.meshes.name)
    any_row = touching[:, :m].copy()
    for column, mesh in enumerate(system.far_flanks.mesh[: force.shape[1] - m].tolist()):
        any_row[:, mesh] |= touching[:, m + column]
    closed = face.total(any_row.astype(float), axis=1) > 0
    way = motion.T
    highest, lowest = net.max(axis=0), net.min(axis=0)
    if smooth:
        # a force of exactly 0 is a flank apart: no parabola goes below it
        highest, lowest = peak(net.T), np.where(lowest == 0, 0.0, -peak(-net.T))
    reach = (peak(way) + peak(-way)) / 2 if smooth else (way.max(axis=1) - way.min(axis=1)) / 2
    return Measures(
        rms=net.std(axis=0),
        highest=highest,
        lowest=lowest,
        open=1 - closed.mean(axis=0),
        amplitude=system.dofs.radius * reach,
    )
