"""From a motion on the torus of phases to forces: at any phases, over time, and their extremes."""

from __future__ import annotations

from fractions import Fraction
from math import lcm
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ...system.faces import Faces
from ...system.system import Array
from .problem import Problem, State

__all__ = ["flank_force_at", "mesh_total", "net_force", "path_phases", "summit"]

Number = TypeVar("Number", bound=np.inexact)

# Instants of a super-period that are looked at one by one; a longer one fills the torus evenly enough.
_INSTANTS = 8192
# Phases in one product with the lattice points.
_BATCH = 2048


def flank_force_at(given: Problem, at: State, phases: Array) -> Array:
    """Force of every flank at phases (T, D) of the tones, (T, R) [N]."""
    made, points, w = given.flanks, given.grid.points, at.speed * given.omega
    gap = at.y.reshape(-1, at.y.shape[2]) @ made.gaps.T - given.error
    J = len(points)
    rate = np.concatenate([-w[:, None] * gap[J:], w[:, None] * gap[:J]])
    parts = [_at(made.damping, gap, rate, points, part) for part in np.array_split(phases, -(-len(phases) // _BATCH))]
    delta, drag = (np.concatenate([part[i] for part in parts]) for i in range(2))
    orders = np.arange(1, made.variation.shape[1] + 1)
    wave = np.exp(2j * np.pi * phases[:, made.axis, None] * orders)
    stiffness = made.stiffness * (1 + np.einsum("trl,rl->tr", wave, made.variation).real)
    force: Array = np.where(delta > 0, stiffness * delta + drag, 0.0)
    return force


def _at(damping: Array, gap: Array, rate: Array, points: NDArray[np.int64], phases: Array) -> tuple[Array, Array]:
    angle = 2 * np.pi * phases @ points.T
    wave = np.concatenate([np.cos(angle), -np.sin(angle)], axis=1)
    delta = wave @ gap
    return delta, damping * (wave @ rate) if damping.any() else np.zeros_like(delta)


def net_force(given: Problem, force: NDArray[Number], rows: int) -> NDArray[Number]:
    """Force of every mesh row (N, m) from that of the flanks (N, R): the loaded flank less the far one [N]."""
    net = force[:, :rows].copy()
    far = given.flanks.mesh[rows:]
    if force[:, rows:].any():
        np.subtract.at(net.T, far, force[:, rows:].T)
    return net


def mesh_total(face: Faces, rows: NDArray[Number]) -> NDArray[Number]:
    """Force of whole meshes (N, w) from that of their rows (N, m)."""
    total: NDArray[Number] = face.total(rows, axis=1)
    return total


def path_phases(tones: tuple[Fraction, ...], samples: int) -> Array | None:
    """Phases (T, D) along one super-period, None where it is so long that its path fills the torus.

    On a short one phases recur together, so that averages over it are not those over all phases.

    Parameters
    ----------
    tones : exact.  samples : of a cycle of the first tone, at least.
    """
    unit = lcm(*(tone.denominator for tone in tones))
    whole = [int(tone * unit) for tone in tones]
    turns = [value // np.gcd.reduce(whole) for value in whole]
    count = max(turns) * samples
    if count > _INSTANTS:
        return None
    path: Array = np.outer(np.arange(count) / count, turns) % 1.0
    return path


def summit(values: Array) -> Array:
    """Largest value over a grid of phases (N_1, .., N_D, c) -> (c,), with a parabola along every axis."""
    columns = values.shape[-1]
    flat = values.reshape(-1, columns)
    place = np.unravel_index(flat.argmax(axis=0), values.shape[:-1])
    top: Array = flat.max(axis=0)
    total, own = top.copy(), np.arange(columns)
    for axis, count in enumerate(values.shape[:-1]):
        sides = []
        for step in (-1, 1):
            moved = list(place)
            moved[axis] = (moved[axis] + step) % count
            sides.append(values[(*moved, own)])
        bend = 2 * top - sides[0] - sides[1]
        with np.errstate(all="ignore"):
            total += np.where(bend > 0, (sides[1] - sides[0]) ** 2 / (8 * bend), 0.0)
    return total
