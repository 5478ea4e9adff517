"""Forces of flanks, meshes, links and groups at many instants at once, from states."""

from __future__ import annotations

import numpy as np

from ...system.gaps import net_force
from ...system.system import Array, ComplexArray
from .motion import Motion, phases_at, tangent_series
from .products import per_instant
from .program import phase_at, speed_at

__all__ = ["flank_force", "group_force", "group_stretch", "link_force", "mesh_force", "mesh_total"]

# Instants whose laws are asked at a time: a table holds two numbers a row, load and instant.
_BLOCK = 1024


def mesh_force(moving: Motion, times: Array, states: Array) -> Array:
    """Force of every mesh row, (m, T) [N]: on the loaded flank positive, on the far one negative.

    Parameters
    ----------
    times : (T,) [s].  states : (T, 2, n) q [m, rad], q' [m/s, rad/s] as `integrate` returns them.
    """
    return mesh_total(moving, flank_force(moving, times, states))


def mesh_total(moving: Motion, force: Array) -> Array:
    """Force of every mesh row (m, T) [N], far flanks counted against loaded ones, from those of all flanks (F, T)."""
    return net_force(force.T, moving.flanks.mesh[len(moving.system.meshes.name) :]).T


def flank_force(moving: Motion, times: Array, states: Array) -> Array:
    """Force of every flank, loaded ones first, (F, T) [N]; times (T,) [s], states (T, 2, n)."""
    parts = [_pressed(moving, times[i : i + _BLOCK], states[i : i + _BLOCK]) for i in range(0, len(times), _BLOCK)]
    return np.concatenate([np.zeros((0, moving.numbers.drag.size)), *parts]).T


def _pressed(moving: Motion, times: Array, states: Array) -> Array:
    """Force of every flank (T, F) [N]."""
    N = moving.numbers
    F, speed, tau = N.drag.size, speed_at(moving.program, times), phase_at(moving.program, times)
    error, rate = _line_sum(N.gap_at, N.gap[0, :, :F] + 1j * N.gap[1, :, :F], speed, tau)
    moves = per_instant(states, moving.rows[:, :F])
    gap, laws = moves[:, 0] - error - N.opening, moving.flanks.at(phases_at(moving, tau))
    if N.pull:
        force, pressed = tangent_series(moving, tau) * gap, np.ones_like(gap, dtype=bool)
    else:
        force, pressed = laws.evaluate(gap)[0], gap > laws.touch
    if N.drag.any():
        force += np.where(pressed, N.drag * (moves[:, 1] - rate), 0.0)
    return force


def _line_sum(frequency: Array, amplitude: ComplexArray, speed: Array, tau: Array) -> tuple[Array, Array]:
    """Re sum a exp(2 pi i f tau) and its rate, (T, rows), for amplitudes a (J, rows) at frequencies (J,) [Hz]."""
    wave = np.exp(2j * np.pi * np.multiply.outer(tau, frequency))
    both = np.stack([wave, 2j * np.pi * frequency * speed[:, None] * wave], axis=1)
    sums = np.real(per_instant(both, amplitude))
    return sums[:, 0], sums[:, 1]


def link_force(moving: Motion, times: Array, states: Array) -> Array:
    """Force k (B^T q - e) + c d/dt(...) + s skew B^T q + preload of every linear link row, (p, T) [N, N m]."""
    links, lines = moving.system.links, moving.system.lines
    frequency = np.array([float(line.frequency) for line in lines])
    error = np.array([line.link_gap for line in lines], complex).reshape(len(lines), len(links.name))
    speed, tau = speed_at(moving.program, times), phase_at(moving.program, times)
    e, rate = _line_sum(frequency, error, speed, tau)
    moves = per_instant(states, links.B)
    force: Array = links.stiffness * (moves[:, 0] - e) + links.damping * (moves[:, 1] - rate)
    if links.skew.size:
        force += speed[:, None] * per_instant(moves, links.skew.T)[:, 0]
    if links.preload.size:
        force += links.preload
    return force.T


def group_stretch(moving: Motion, times: Array, states: Array) -> Array:
    """Stretch less error of every row of the groups, (T, R) [m]."""
    N, F = moving.numbers, moving.numbers.drag.size
    speed, tau = speed_at(moving.program, times), phase_at(moving.program, times)
    error, _ = _line_sum(N.gap_at, N.gap[0, :, F:] + 1j * N.gap[1, :, F:], speed, tau)
    stretch: Array = per_instant(states, moving.rows[:, F:])[:, 0] - error
    return stretch


def group_force(moving: Motion, times: Array, states: Array, sliders: Array) -> Array:
    """Size of the force of every group, its dampers left out, (G, T) [N].

    Parameters
    ----------
    sliders : (T, R) of Coulomb friction [m], no columns without a memory.
    """
    force = moving.laws.force(group_stretch(moving, times, states), sliders if sliders.size else None)
    size: Array = moving.laws.rows.size(force).T
    return size
