"""From solved rows to what happens in time: mesh forces and displacements over the mesh phase."""

from __future__ import annotations

import numpy as np

from ..system.system import Array, ComplexArray, System
from .harmonic import Kernel, Solved, envelope
from .response import Block, Response

__all__ = [
    "displacements",
    "mesh_forces",
    "mesh_stiffness",
    "peak",
    "samples_needed",
    "shaft_displacements",
    "shaft_forces",
    "shaft_power",
]


def mesh_stiffness(system: System, theta: Array) -> Array:
    """k_m at mesh phases theta (Nt,) of the tone, (m, Nt) [N/m]."""
    orders = np.arange(1, system.meshes.variation.shape[1] + 1)
    wave = np.exp(2j * np.pi * orders[:, None] * theta)
    value: Array = system.meshes.stiffness[:, None] * (1 + (system.meshes.variation @ wave).real)
    return value


def mesh_forces(ready: Response, block: Block, theta: Array) -> Array:
    """Mesh force at mesh orders, k(t) (B^T q - e) + c d/dt(...), (m, P, Nt) [N]."""
    return _forces(ready, block.mesh, ready.kernel(block.harmonics, shifted=False), theta)


def shaft_forces(ready: Response, block: Block, theta: Array) -> ComplexArray:
    """Envelopes A_s of the mesh force of every shaft line, (m, P, S, Nt) complex [N]; S = 0 without lines."""
    m, P = block.mesh.gap.shape[:2]
    if block.shaft is None:
        return np.zeros((m, P, 0, theta.size), complex)
    both = _forces(ready, block.shaft, ready.kernel(block.harmonics, shifted=True), theta)
    return _complex(both).reshape(m, P, -1, theta.size)


def _forces(ready: Response, solved: Solved, kernel: Kernel, theta: Array) -> Array:
    meshes = ready.system.meshes
    stiffness = mesh_stiffness(ready.system, theta)
    copies = 2 if kernel.shifted else 1
    force = envelope(kernel, solved.gap, theta) * np.tile(stiffness, copies)[:, None]
    if meshes.damping.any():
        force += meshes.damping[:, None, None] * envelope(kernel, _rate(solved), theta)
    return force


def _rate(solved: Solved) -> Array:
    J = solved.frequency.shape[1]
    return np.concatenate([-solved.frequency * solved.gap[..., J:], solved.frequency * solved.gap[..., :J]], axis=-1)


def displacements(ready: Response, block: Block, theta: Array) -> Array:
    """Coordinates at mesh orders, (n, P, Nt) [m, rad]."""
    return envelope(ready.kernel(block.harmonics, shifted=False), _coordinates(ready, block.mesh), theta)


def shaft_displacements(ready: Response, block: Block, theta: Array) -> ComplexArray:
    """Envelopes of the coordinates of every shaft line, (n, P, S, Nt) complex [m, rad]; S = 0 without lines."""
    n, P = ready.modal.squared.size, block.speed.size
    if block.shaft is None:
        return np.zeros((n, P, 0, theta.size), complex)
    both = envelope(ready.kernel(block.harmonics, shifted=True), _coordinates(ready, block.shaft), theta)
    return _complex(both).reshape(n, P, -1, theta.size)


def _coordinates(ready: Response, solved: Solved) -> Array:
    P, _, J, n = solved.y.shape
    q: Array = (ready.modal.shapes @ solved.y.reshape(-1, n).T).reshape(n, P, 2 * J)
    return q


def _complex(both: Array) -> ComplexArray:
    half = both.shape[-1] // 2
    value: ComplexArray = both[..., :half] + 1j * both[..., half:]
    return value


def samples_needed(ready: Response, harmonics: int) -> int:
    """Samples of a mesh cycle that hold the force and its square without aliasing."""
    return 2 * (harmonics + int(ready.system.meshes.variation.shape[1])) + 1


def shaft_power(ready: Response, envelopes: ComplexArray, theta: Array) -> Array:
    """Mean square over all time that the shaft lines add, (..., S, Nt) envelopes -> (...), by Parseval.

    A line at half a mesh order comes back to itself after two cycles, and its square keeps a mean of its own.
    """
    square: Array = np.mean(np.abs(envelopes) ** 2, axis=-1).sum(axis=-1) / 2
    for place, shaft in enumerate(ready.lines.shaft):
        twice = 2 * shaft.frequency / ready.lines.tone
        if twice.denominator == 1:
            turning = envelopes[..., place, :] ** 2 * np.exp(2j * np.pi * int(twice) * theta)
            square = square + turning.real.mean(axis=-1) / 2
    return square


def peak(values: Array) -> Array:
    """Largest value of a periodic signal (..., Nt) -> (...), with a parabola through the largest sample."""
    place = np.argmax(values, axis=-1)[..., None]
    count = values.shape[-1]
    before, top, after = (np.take_along_axis(values, (place + step) % count, axis=-1)[..., 0] for step in (-1, 0, 1))
    bend = 2 * top - before - after
    with np.errstate(all="ignore"):
        rise = np.where(bend > 0, (after - before) ** 2 / (8 * bend), 0.0)
    result: Array = top + rise
    return result
