"""What a motion on the torus means for the teeth: RMS, extremes over all phases, and how long they are apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray
from .forces import flank_force_at, mesh_total, net_force, path_phases, summit
from .problem import flank_force
from .superposed import Superposed
from .torus import Torus, TorusPoint

__all__ = ["Outcome", "outcome", "strokes"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outcome:
    """Forces of whole meshes (w,) and of their rows (m,), slices where a mesh is cut; on the loaded flank positive.

    force : (N, w), row_force : (N, m) over the phases of the grid, mean over the lines that are superposed [N].
    reach : (N, w) by how much these change it at most [N].
    rms : (w,) of the part that varies, over all time [N].
    peak, minimum : (w,), row_peak : (m,) largest and least over all relative phases [N].
    open : (w,) share of time in which no slice of the mesh touches, row_open : (m,) of each.
    far : (w,) share of time in which a far flank touches.
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


def outcome(given: Torus, point: TorusPoint, lines: Sequence[Superposed] = ()) -> Outcome:
    """Statistics of a point; lines superposed add their mean square to the RMS and their amplitude to the extremes."""
    rows, face, made = len(given.face.row), given.face, point.problem
    row_force = net_force(made, flank_force(made, point.state), rows)
    force = mesh_total(face, row_force)
    each = [net_force(made, line.force, rows) for line in lines]
    extra = [mesh_total(face, amplitude) for amplitude in each]
    counts, touching = made.grid.counts, point.state.touching
    own, far = touching[:, :rows], touching[:, rows:]
    high, low, row_high = (
        _with_lines(values, amplitudes, counts)
        for values, amplitudes in ((force, extra), (-force, extra), (row_force, each))
    )
    return Outcome(
        force=force,
        row_force=row_force,
        reach=_reach(extra, len(force)) if extra else np.zeros_like(force),
        rms=np.sqrt(_variance(given, point, force, lines, extra)),
        peak=high,
        minimum=-low,
        row_peak=row_high,
        open=1.0 - np.logical_or.reduceat(own, face.first, axis=1).mean(axis=0),
        row_open=1.0 - own.mean(axis=0),
        far=_far(given, point, far),
    )


def _with_lines(values: Array, amplitudes: Sequence[ComplexArray], counts: tuple[int, ...]) -> Array:
    """Largest value (c,) over all phases of values (N, c) and of lines, whose amplitudes (Nm, c) know mesh phases."""
    if amplitudes:
        values = values + _reach(amplitudes, len(values))
    return summit(values.reshape(*counts, -1))


def _reach(amplitudes: Sequence[ComplexArray], samples: int) -> Array:
    """Sum of the magnitudes of lines (Nm, c) over all samples of the torus, (N, c)."""
    reach: Array = np.sum([np.abs(amplitude) for amplitude in amplitudes], axis=0)
    return np.repeat(reach, samples // len(reach), axis=0)


def _variance(
    given: Torus, point: TorusPoint, force: Array, lines: Sequence[Superposed], extra: Sequence[ComplexArray]
) -> Array:
    """Mean square of what varies, (w,): over one super-period, or over the torus that a long one fills."""
    made, mesh = point.problem, given.ready.lines.tones
    slow = given.slow.tones[: len(made.grid.counts) - len(mesh)]
    tones: tuple[Fraction, ...] = (*mesh, *slow, *(line.shaft.frequency for line in lines))
    path = path_phases(tones, made.grid.counts[0]) if len(tones) > 1 and (len(mesh) == 1 or not lines) else None
    if path is None:
        square = sum(((np.abs(amplitude) ** 2).mean(axis=0) / 2 for amplitude in extra), np.zeros(force.shape[1]))
        variance: Array = force.var(axis=0) + square
        return variance
    flanks = flank_force_at(made, point.state, path[:, : len(made.grid.counts)])
    total = mesh_total(given.face, net_force(made, flanks, len(given.face.row)))
    for amplitude, phase in zip(extra, path.T[len(made.grid.counts) :], strict=True):
        total += (_along(amplitude, path[:, 0]) * np.exp(2j * np.pi * phase)[:, None]).real
    variance = total.var(axis=0)
    return variance


def _along(amplitude: ComplexArray, theta: Array) -> ComplexArray:
    """Values over one phase (N, c) at phases theta (T,), between samples by Fourier sums."""
    count = len(amplitude)
    orders = np.fft.fftfreq(count, 1 / count)
    values: ComplexArray = np.exp(2j * np.pi * np.outer(theta, orders)) @ (np.fft.fft(amplitude, axis=0) / count)
    return values


def _far(given: Torus, point: TorusPoint, far: NDArray[np.bool_]) -> Array:
    """Share of time in which a far flank of each whole mesh touches."""
    face, owner = given.face, given.face.row[point.problem.flanks.mesh[len(given.face.row) :]]
    share = np.zeros(len(face.name))
    for mesh in np.unique(owner[far.any(axis=0)]):
        share[mesh] = far[:, owner == mesh].any(axis=1).mean()
    return share


def strokes(given: Torus, point: TorusPoint, lines: Sequence[Superposed] = ()) -> Array:
    """Half of the way from least to most of every coordinate over all phases, (n,) [m; rz as radius times angle]."""
    made, modal = point.problem, given.ready.modal
    q = made.grid.values(point.state.y.reshape(-1, modal.squared.size) @ modal.shapes.T)
    more = [line.motion for line in lines]
    high, low = (_with_lines(values, more, made.grid.counts) for values in (q, -q))
    way: Array = given.ready.system.dofs.radius * (high + low) / 2
    return way
