"""Forces of flanks, meshes, links and groups at many instants at once, from states."""

from __future__ import annotations

import numpy as np

from ...system.system import Array, ComplexArray
from .motion import Motion
from .program import phase_at, speed_at

__all__ = ["flank_force", "group_force", "link_force", "mesh_force"]


def mesh_force(moving: Motion, times: Array, states: Array) -> Array:
    """Force of every mesh row, (m, T) [N]: on the loaded flank positive, on the far one negative.

    Parameters
    ----------
    times : (T,) [s].  states : (T, 2, n) q [m, rad], q' [m/s, rad/s] as `integrate` returns them.
    """
    force = flank_force(moving, times, states)
    m = len(moving.system.meshes.name)
    total = force[:m].copy()
    far = moving.system.far_flanks.mesh[: len(force) - m]
    np.subtract.at(total, far, force[m:])
    return total


def flank_force(moving: Motion, times: Array, states: Array) -> Array:
    """Force of every flank, loaded ones first, (F, T) [N]; times (T,) [s], states (T, 2, n)."""
    N = moving.numbers
    F, speed, tau = N.mean.size, speed_at(moving.program, times), phase_at(moving.program, times)
    far = F - len(moving.system.meshes.name)
    B = np.concatenate([moving.system.meshes.B, moving.system.far_flanks.B[:, :far]], axis=1)
    error, rate = _line_sum(N.gap_at, N.gap[0, :, :F] + 1j * N.gap[1, :, :F], speed, tau)
    gap = B.T @ states[:, 0].T - error - N.opening[:, None]
    force: Array = _stiffness(moving, tau) * gap
    if N.drag.any():
        force += N.drag[:, None] * (B.T @ states[:, 1].T - rate)
    return force if N.pull else np.where(gap > 0, force, 0.0)


def _stiffness(moving: Motion, tau: Array) -> Array:
    """k of every flank (F, T) [N/m]."""
    N = moving.numbers
    k = np.ones((N.mean.size, tau.size))
    for order in range(N.wave.shape[2]):
        wave = np.exp(2j * np.pi * (order + 1) * np.multiply.outer(N.tones, tau))[N.tone]
        k += N.wave[0, :, order, None] * wave.real - N.wave[1, :, order, None] * wave.imag
    return N.mean[:, None] * k


def _line_sum(frequency: Array, amplitude: ComplexArray, speed: Array, tau: Array) -> tuple[Array, Array]:
    """Re sum a exp(2 pi i f tau) and its rate, (rows, T), for amplitudes a (J, rows) at frequencies (J,) [Hz]."""
    wave = np.exp(2j * np.pi * np.multiply.outer(frequency, tau))
    value = (amplitude.T @ wave).real
    rate = (amplitude.T @ (2j * np.pi * frequency[:, None] * speed * wave)).real
    return value, rate


def link_force(moving: Motion, times: Array, states: Array) -> Array:
    """Force k (B^T q - e) + c d/dt(...) + s skew B^T q + preload of every linear link row, (p, T) [N, N m]."""
    links, lines = moving.system.links, moving.system.lines
    frequency = np.array([float(line.frequency) for line in lines])
    error = np.array([line.link_gap for line in lines], complex).reshape(len(lines), len(links.name))
    speed, tau = speed_at(moving.program, times), phase_at(moving.program, times)
    e, rate = _line_sum(frequency, error, speed, tau)
    stretch, moves = links.B.T @ states[:, 0].T, links.B.T @ states[:, 1].T - rate
    force: Array = links.stiffness[:, None] * (stretch - e) + links.damping[:, None] * moves
    if links.skew.size:
        force += speed * (links.skew @ stretch)
    if links.preload.size:
        force += links.preload[:, None]
    return force


def group_force(moving: Motion, times: Array, states: Array) -> Array:
    """Size of the force of every group, its dampers left out, (G, T) [N]."""
    N, system, laws = moving.numbers, moving.system, moving.system.laws
    F, R = N.mean.size, system.group_rows.shape[1]
    speed, tau = speed_at(moving.program, times), phase_at(moving.program, times)
    error, _ = _line_sum(N.gap_at, N.gap[0, :, F : F + R] + 1j * N.gap[1, :, F : F + R], speed, tau)
    stretch = (system.group_rows.T @ states[:, 0].T - error).T
    sticks = laws.rows.spread(laws.memory)
    held = laws.row_stiffness * (stretch - N.anchor)
    size: Array = laws.rows.size(np.where(sticks, held, laws.force(stretch))).T
    return size
