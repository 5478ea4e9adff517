"""Condensed operators of the compiled solver: frame and damper matrices on the few coordinates where they act."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...questions.modes.basis import Modal
from ...system.system import Array, System
from .kernel import Kernel

__all__ = ["CondensedOperators", "Workspace", "condensed_operators", "workspace"]

Index = NDArray[np.int64]


class CondensedOperators(NamedTuple):
    """Operators that all points of a batch share, of one mesh frequency.

    read : (m + r, n) gaps of the meshes, then the r coordinates condensed to, of y.  push : (n, m + r) forces there on
        y.
    own : (m, 2 J, 2 J) products with k(t) - k0, force = own @ gap [N/m].  tail : (m, 2 J, 2 T), gap @ tail = force.
    row, column : (e,) indices 0 .. m + r of entries.  stiff : (2, e) of Kg and Cskew.  rate : (2, e) of G and C.
    diagonal : (n,) modal diagonal of the dampers [1/s]: `damping` holds it, and the entries of C hold it again.
    squared [rad^2/s^2], damping [1/s] : (n,) of `Modal`.
    """

    read: Array
    push: Array
    own: Array
    tail: Array
    row: Index
    column: Index
    stiff: Array
    rate: Array
    diagonal: Array
    squared: Array
    damping: Array


class Workspace(NamedTuple):
    """Arrays for one group of speeds side by side, 8 lanes: H = 8 J, X = 2 H, K Krylov vectors.

    values, forces : (m + r, X).  work : (n, X).
    stiffness_factor : (2, H) frame^2 and frame, of Kg and Cskew.  rate_factor : (2, H) w frame and w, of G and C
        [rad/s].
    inverse : (2, n, H) 1/D.  vectors : (K + 1, n, X).  rows : (K, X).  triangle : (K, K, 8).  rotations : (2, K, 8).
    projected : (K + 1, 8) right side.  along : (K + 2, 8).  used : (8,) vectors of each lane.
    """

    values: Array
    forces: Array
    work: Array
    stiffness_factor: Array
    rate_factor: Array
    inverse: Array
    vectors: Array
    rows: Array
    triangle: Array
    rotations: Array
    projected: Array
    along: Array
    used: Index


def workspace(operators: CondensedOperators, J: int, *, lanes: int, basis: int) -> Workspace:
    """Workspace for J harmonics and `basis` Krylov vectors, in the precision of the operators."""
    (c, n), half, kind = operators.read.shape, J * lanes, operators.read.dtype
    return Workspace(
        values=np.empty((c, 2 * half), kind),
        forces=np.empty((c, 2 * half), kind),
        work=np.empty((n, 2 * half), kind),
        stiffness_factor=np.empty((2, half), kind),
        rate_factor=np.empty((2, half), kind),
        inverse=np.empty((2, n, half), kind),
        vectors=np.empty((basis + 1, n, 2 * half), kind),
        rows=np.empty((basis + 1, 2 * half), kind),
        triangle=np.empty((basis, basis, lanes)),
        rotations=np.empty((2, basis, lanes)),
        projected=np.empty((basis + 1, lanes)),
        along=np.empty((basis + 2, lanes)),
        used=np.empty(lanes, np.int64),
    )


def condensed_operators(system: System, modal: Modal, kernel: Kernel) -> CondensedOperators:
    """Condense G, Kg, Cskew and the dampers to the coordinates where they act, of one mesh frequency.

    Derived here: the modal operator of `balance` as read, entries and push; equal up to rounding.
    """
    m, rest = len(system.meshes.name), "C" in modal.coupling
    C = system.C if rest else np.zeros_like(system.C)
    matrices = (system.Kg, system.Cskew, system.G, C)
    acting = sum((matrix != 0 for matrix in matrices), np.zeros(C.shape, dtype=bool))
    where = np.flatnonzero(acting.any(axis=0) | acting.any(axis=1))
    row, column = np.nonzero(acting[np.ix_(where, where)])
    entries = np.array([matrix[where[row], where[column]] for matrix in matrices])
    if rest:
        # a mesh damper acts between its gap and its force
        entries = np.hstack([entries, np.array([0.0, 0.0, 0.0, 1.0])[:, None] * system.meshes.damping])
        row, column = (np.concatenate([at + m, np.arange(m)]) for at in (row, column))
    else:
        row, column = row + m, column + m
    omega = np.sqrt(modal.squared)
    return CondensedOperators(
        read=np.concatenate([modal.gaps, modal.shapes[where]]),
        push=np.concatenate([modal.pulls.T, modal.forces[:, where]], axis=1),
        own=np.ascontiguousarray(kernel.axes[0].own_product.swapaxes(1, 2)),
        tail=kernel.axes[0].own_tail,
        row=row,
        column=column,
        stiff=entries[:2],
        rate=entries[2:],
        diagonal=modal.damping - 2 * (system.zeta or 0.0) * omega if rest else np.zeros(omega.size),
        squared=modal.squared,
        damping=modal.damping,
    )
