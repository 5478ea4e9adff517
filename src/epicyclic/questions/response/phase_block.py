"""Preconditioner of the balance where links pass a body: the system solved at each phase of their tone, held still.

Along the axis of that tone the varying stiffness is a product with K(phi) at every phase phi.  Where the tone is slow
beside the others the points of a line of the lattice have nearly one frequency w, so that

    x(phi) = (K(phi) + i w C + .. - w^2 M)^-1 f(phi)

solves the whole line: a transform, one matrix a phase, and a transform back.  The shift of the frequencies along the
line is what GMRES has left to do.  It is also well conditioned where the links are stiff beside what they hold, where
the mean stiffness is none of any instant.  Derived here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...system.system import Array, ComplexArray, Index, System
from ..modes.eigen import Modal
from .lattice import Kernel, bundle, stiffness_series

# Matrices of all lines and phases at most [complex numbers]: half a gigabyte.
_MOST = 30_000_000


def phase_block(
    system: System, modal: Modal, kernel: Kernel, frequency: Array, frame: float
) -> Callable[[Array], Array]:
    """Preconditioner (1 + D^-1 coupling)^-1 of one point by the phases of the tone of links that pass a body.

    frequency : (J,) of every harmonic [rad/s].  frame : factor of G and Cskew, squared of Kg.

    Returns
    -------
    A function (1, 2 J n) -> (1, 2 J n) of the preconditioned rows of the balance.
    """
    axis = next(j for j, one in enumerate(kernel.axes) if one.meshes.size and one.meshes[0] >= len(system.meshes.name))
    take, sign, centre = _lines(kernel, axis, frequency)
    J, n, (count, width) = frequency.size, modal.squared.size, take.shape
    lines = min(count, max(1, _MOST // (width * n * n)))
    inverse = _inverses(system, modal, kernel.axes[axis].meshes, centre[:lines], width, frame)
    order = np.arange(width) - width // 2
    turn = np.exp(2j * np.pi * np.outer(np.arange(width), order) / width)
    kept, at = take[:lines] < J, take[:lines]
    D = modal.squared - frequency[:, None] ** 2 + 1j * frequency[:, None] * modal.damping
    D[:, modal.rigid] = 1.0

    def solve(x: Array) -> Array:
        """All lines solved phase by phase, (1, 2 J n)."""
        parts = x.reshape(2, J, n)
        value = np.concatenate([(parts[0] + 1j * parts[1]) * D, np.zeros((1, n))])
        line = value[at]
        np.conjugate(line, out=line, where=(sign[:lines] < 0)[:, :, None])
        if kernel.lattice.mirrored:
            line[0, width // 2] *= 2.0  # the mean, beside the halves of both sides
        solved = np.matmul(inverse, (turn @ line)[..., None])[..., 0]
        line = (turn.conj().T / width) @ solved
        np.conjugate(line, out=line, where=(sign[:lines] < 0)[:, :, None])
        if kernel.lattice.mirrored:
            line[0, width // 2] = line[0, width // 2].real / 2
        out = parts[0] + 1j * parts[1]
        out[at[kept]] = line[kept]
        return np.stack([out.real, out.imag]).reshape(1, -1)

    return solve


def _lines(kernel: Kernel, axis: int, frequency: Array) -> tuple[Index, Index, Array]:
    """Points (lines, W) along an axis, J where none is kept, their signs, and the frequency at order 0 [rad/s]."""
    lattice, several = kernel.lattice, bundle(kernel.lattice, axis)
    J, own = len(lattice.points), lattice.own[axis]
    if lattice.mirrored:
        own = np.concatenate([own[:0:-1], own])
    reach, wide = own.size // 2, several.take.shape[1] // 2
    half = max(reach, wide)
    take = np.full((1 + several.several, 2 * half + 1), J, dtype=np.int64)
    sign = np.ones_like(take)
    take[0, half - reach : half + reach + 1] = own
    sign[0, :half] = -1 if lattice.mirrored else 1
    take[1:, half - wide : half + wide + 1] = several.take[: several.several]
    sign[1:, half - wide : half + wide + 1] = several.mirror[: several.several]
    first = np.argmax(take < J, axis=1)
    row, step = np.arange(len(take)), frequency[own[-1]] - frequency[own[-2]]
    centre = sign[row, first] * frequency[take[row, first]] - (first - half) * step
    return take, sign, centre


def _inverses(system: System, modal: Modal, rows: Index, centre: Array, width: int, frame: float) -> ComplexArray:
    """(lines, W, n, n) inverses at each phase of the tone and the frequencies (lines,) of order 0 [rad/s].

    Rigid modes stay apart: what they do hangs on the frequency alone.
    """
    varying = system.varying
    L = varying.wave.shape[1]
    series, phase = stiffness_series(varying, rows, L, reach=L), 2j * np.pi * np.arange(width) / width
    change = (series @ np.exp(np.outer(np.arange(-L, L + 1), phase))).real
    pulls, gaps = modal.pulls[rows], modal.gaps[rows]
    stiffness = np.einsum("rn,rp,rm->pnm", pulls, change, gaps, optimize=True)
    stiffness += np.diag(modal.squared)
    rate = np.diag(modal.damping).astype(float)
    for name, factor, target in (
        ("G", frame, rate),
        ("C", 1.0, rate),
        ("Kg", frame**2, stiffness),
        ("Cskew", frame, stiffness),
    ):
        if name in modal.coupling:
            target += factor * modal.coupling[name].T
    apart = modal.rigid | modal.rigid[:, None]
    made = np.empty((len(centre), width, *rate.shape), complex)
    for line, w in zip(made, centre.tolist(), strict=True):
        matrix = np.where(apart, np.eye(len(rate)), stiffness + 1j * w * rate - w**2 * np.eye(len(rate)))
        line[:] = np.linalg.inv(matrix)
    return made
