"""Outputs of motions with contact loss: forces of flanks, rows and whole meshes, their statistics, amplitudes.

Shapes: R flanks, m mesh rows, w whole meshes, n coordinates, N samples, D phases.  A force on the far flank is
negative (docs/conventions.md).  On the torus, means are over all phases, or along one super-period where that is
short, and extremes are over all relative phases (derived here).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...system.gaps import net_force
from ...system.system import Array, ComplexArray, System, faces
from ..response.spectra import peak
from .problem import Problem, State, flank_force, gap_rows, rate_rows

if TYPE_CHECKING:
    from .shaft_orders import SuperposedLine
    from .torus import Torus, TorusPoint

Number = TypeVar("Number", bound=np.inexact)

# Instants of a super-period that are looked at one by one, at most; a longer one fills the torus evenly enough.
_INSTANTS = 8192
# Phases in one product with the lattice points: bounds the memory of a (phases, 2 J) matrix.
_BATCH = 2048


def flank_force_at(balance: Problem, at: State, phases: Array) -> Array:
    """Force of every flank at phases (T, D) of the tones [cycles], (T, F) [N]."""
    rows, points, w = balance.rows, balance.grid.points, at.speed * balance.omega
    gap = (gap_rows(balance, at.y) - balance.error)[:, : rows.count]
    rate, batches = rate_rows(gap, w), list[Array]()
    for part in np.array_split(phases, -(-len(phases) // _BATCH)):
        angle = 2 * np.pi * part @ points.T
        wave = np.concatenate([np.cos(angle), -np.sin(angle)], axis=1)
        delta, laws = wave @ gap, rows.at(balance.cycles * part)
        force = laws.evaluate(delta)[0]
        if rows.damping.any():
            force = force + rows.damping * (wave @ rate)
        batches.append(np.where(delta > laws.touch, force, 0.0))
    return np.concatenate(batches)


def row_force(system: System, force: NDArray[Number]) -> NDArray[Number]:
    """Force of every mesh row (N, m) from that of the flanks (N, R): the loaded flank less the far one [N]."""
    return net_force(force, system.far_flanks.mesh[: force.shape[1] - len(system.meshes.name)])


def mesh_force(system: System, force: NDArray[Number]) -> NDArray[Number]:
    """Force of every whole mesh (N, w) from that of the flanks (N, R), far flanks negative [N]."""
    total: NDArray[Number] = faces(system.meshes).total(row_force(system, force), axis=1)
    return total


def super_period_phases(tones: tuple[Fraction, ...], samples: int) -> Array | None:
    """Phases (T, D) along one super-period [cycles], None where it is so long that its path fills the torus.

    On a short one phases recur together, so that averages over it are not those over all phases.

    Parameters
    ----------
    tones : (D,) exact.  samples : of a cycle of the first tone, at least.
    """
    unit = lcm(*(tone.denominator for tone in tones))
    whole = [int(tone * unit) for tone in tones]
    turns = [value // np.gcd.reduce(whole) for value in whole]
    count = max(turns) * samples
    if count > _INSTANTS:
        return None
    path: Array = np.outer(np.arange(count) / count, turns) % 1.0
    return path


def grid_maximum(values: Array) -> Array:
    """Largest value over a grid of phases (N_1, .., N_D, c) -> (c,), with a parabola along every axis."""
    columns = values.shape[-1]
    flat = values.reshape(-1, columns)
    place = np.unravel_index(flat.argmax(axis=0), values.shape[:-1])
    top: Array = flat.max(axis=0)
    total, every = top.copy(), np.arange(columns)
    for axis, count in enumerate(values.shape[:-1]):
        sides = []
        for step in (-1, 1):
            moved = list(place)
            moved[axis] = (moved[axis] + step) % count
            sides.append(values[(*moved, every)])
        bend = 2 * top - sides[0] - sides[1]
        with np.errstate(all="ignore"):
            total += np.where(bend > 0, (sides[1] - sides[0]) ** 2 / (8 * bend), 0.0)
    return total


# --- periodic motions and records -------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Measures:
    """Measures of a motion.

    rms, highest, lowest : (w,) of the force of every whole mesh [N], its far flank negative.
    open : (w,) part of the time in which no flank of it touches.
    amplitude : (n,) half the distance between extremes of a coordinate [m; rz as radius times angle].
    flank : (F,) largest force of every flank [N].
    """

    rms: Array
    highest: Array
    lowest: Array
    open: Array
    amplitude: Array
    flank: Array


def force_level(system: System, balance: Problem, state: State) -> Array:
    """RMS of the dynamic force of every whole mesh, (w,) [N]."""
    level: Array = mesh_force(system, flank_force(balance, state)).std(axis=0)
    return level


def periodic_measures(system: System, balance: Problem, state: State) -> Measures:
    """Measures of a periodic motion over the samples of its period."""
    motion = balance.grid.values(state.y.reshape(-1, state.y.shape[2])) @ balance.modal.shapes.T
    return _measures(system, flank_force(balance, state), state.touching, motion, smooth=len(balance.grid.counts) == 1)


def record_measures(system: System, force: Array, motion: Array) -> Measures:
    """Measures of a record of flank forces (N, R) [N] and coordinates (N, n) [m] over time."""
    return _measures(system, force, force != 0, motion, smooth=False)


def _measures(system: System, force: Array, touching: np.ndarray, motion: Array, *, smooth: bool) -> Measures:
    """Measures of flank forces (N, R) [N], contact (N, R) and coordinates (N, n) [m].

    smooth : whether extremes are refined by parabolas through the samples.
    """
    face, net = faces(system.meshes), mesh_force(system, force)
    m = len(system.meshes.name)
    any_row = touching[:, :m].copy()
    for column, mesh in enumerate(system.far_flanks.mesh[: force.shape[1] - m].tolist()):
        any_row[:, mesh] |= touching[:, m + column]
    closed = face.total(any_row.astype(float), axis=1) > 0
    q = motion.T
    highest, lowest = net.max(axis=0), net.min(axis=0)
    if smooth:
        # a force of exactly 0 is a flank apart: no parabola goes below it
        highest, lowest = peak(net.T), np.where(lowest == 0, 0.0, -peak(-net.T))
    reach = (peak(q) + peak(-q)) / 2 if smooth else (q.max(axis=1) - q.min(axis=1)) / 2
    return Measures(
        rms=net.std(axis=0),
        highest=highest,
        lowest=lowest,
        open=1 - closed.mean(axis=0),
        amplitude=system.dofs.radius * reach,
        flank=force.max(axis=0),
    )


# --- the torus --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TorusOutputs:
    """Forces of whole meshes (w,) and of their rows (m,), slices where a mesh is cut; on the loaded flank positive.

    force : (N, w), row_force : (N, m) over the phases of the grid, mean over the lines that are superposed [N].
    reach : (N, w) by how much these change it at most [N].
    rms : (w,) of the part that varies, over all time [N].
    peak, minimum : (w,), row_peak : (m,) largest and least over all relative phases [N].
    open : (w,) share of time in which no flank of the mesh touches, loaded or far, of any slice.
    row_open : (m,) in which the loaded flank of a row does not.
    far : (w,) share of time in which a far flank touches.
    flank : (F,) largest force of every flank [N].
    """

    force: Array
    row_force: Array
    reach: Array
    rms: Array
    peak: Array
    minimum: Array
    row_peak: Array
    open: Array
    row_open: Array
    far: Array
    flank: Array


def torus_outputs(torus: Torus, point: TorusPoint, lines: Sequence[SuperposedLine] = ()) -> TorusOutputs:
    """Statistics of a point of the torus.

    Lines superposed add their mean square to the RMS and their amplitude to the extremes.  A mesh whose far flank stays
    away has no force below those at the samples and 0, whatever they add: teeth do not pull.
    """
    system, rows, face, balance = torus.ready.system, len(torus.face.row), torus.face, point.problem
    flank = flank_force(balance, point.state)
    of_rows = row_force(system, flank)
    force = face.total(of_rows, axis=1)
    row_lines = [row_force(system, line.force) for line in lines]
    mesh_lines = [face.total(amplitude, axis=1) for amplitude in row_lines]
    counts, touching = balance.grid.counts, point.state.touching
    loaded, far = touching[:, :rows], touching[:, rows:]
    # the whole mesh of every flank: in which share of time a far one of it touches, and in which none at all
    owner, far_share = face.row[balance.rows.flanks.mesh], np.zeros(len(face.name))
    for mesh in np.unique(owner[rows:][far.any(axis=0)]):
        far_share[mesh] = far[:, owner[rows:] == mesh].any(axis=1).mean()
    apart = [1.0 - touching[:, owner == mesh].any(axis=1).mean() for mesh in range(len(face.name))]
    least = np.where(far_share == 0, np.minimum(force.min(axis=0), 0.0), -np.inf)
    return TorusOutputs(
        force=force,
        row_force=of_rows,
        reach=_reach(mesh_lines, len(force)) if mesh_lines else np.zeros_like(force),
        rms=np.sqrt(_variance(torus, point, force, lines, mesh_lines)),
        peak=_with_lines(force, mesh_lines, counts),
        minimum=np.maximum(-_with_lines(-force, mesh_lines, counts), least),
        row_peak=_with_lines(of_rows, row_lines, counts),
        open=np.array(apart),
        row_open=1.0 - loaded.mean(axis=0),
        far=far_share,
        flank=_with_lines(flank, [line.force for line in lines], counts),
    )


def _with_lines(values: Array, amplitudes: Sequence[ComplexArray], counts: tuple[int, ...]) -> Array:
    """Largest value (c,) over all phases of values (N, c) and of lines of amplitudes (Nm, c) over mesh phases."""
    if amplitudes:
        values = values + _reach(amplitudes, len(values))
    return grid_maximum(values.reshape(*counts, -1))


def _reach(amplitudes: Sequence[ComplexArray], samples: int) -> Array:
    """Sum of the magnitudes of lines (Nm, c) over all samples of the torus, (N, c)."""
    reach: Array = np.sum([np.abs(amplitude) for amplitude in amplitudes], axis=0)
    return np.repeat(reach, samples // len(reach), axis=0)


def _variance(
    torus: Torus, point: TorusPoint, force: Array, lines: Sequence[SuperposedLine], amplitudes: Sequence[ComplexArray]
) -> Array:
    """Mean square of what varies, (w,) [N^2]: over one super-period, or over the torus that a long one fills.

    amplitudes : (Nm, w) of the lines.
    """
    balance, mesh, D = point.problem, torus.ready.lines.tones, len(point.problem.grid.counts)
    of_shafts = torus.shaft_tones.tones[: D - len(mesh)]
    tones: tuple[Fraction, ...] = (*mesh, *of_shafts, *(line.shaft.frequency for line in lines))
    path = None
    if len(tones) > 1 and (len(mesh) == 1 or not lines):
        path = super_period_phases(tones, balance.grid.counts[0])
    if path is None:
        square = sum(((np.abs(amplitude) ** 2).mean(axis=0) / 2 for amplitude in amplitudes), np.zeros(force.shape[1]))
        return np.asarray(force.var(axis=0) + square)
    total = mesh_force(torus.ready.system, flank_force_at(balance, point.state, path[:, :D]))
    for amplitude, phase in zip(amplitudes, path.T[D:], strict=True):
        # between samples of the mesh phase by Fourier sums
        count = len(amplitude)
        wave = np.exp(2j * np.pi * np.outer(path[:, 0], np.fft.fftfreq(count, 1 / count)))
        along = wave @ (np.fft.fft(amplitude, axis=0) / count)
        total += (along * np.exp(2j * np.pi * phase)[:, None]).real
    return np.asarray(total.var(axis=0))


def torus_amplitudes(torus: Torus, point: TorusPoint, lines: Sequence[SuperposedLine] = ()) -> Array:
    """Half the distance between extremes of every coordinate over all phases, (n,) [m; rz as radius times angle]."""
    balance, modal = point.problem, torus.ready.modal
    q = balance.grid.values(point.state.y.reshape(-1, modal.squared.size) @ modal.shapes.T)
    motions = [line.motion for line in lines]
    high, low = (_with_lines(values, motions, balance.grid.counts) for values in (q, -q))
    amplitude: Array = torus.ready.system.dofs.radius * (high + low) / 2
    return amplitude
