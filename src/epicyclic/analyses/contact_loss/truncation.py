"""Truncation residual: forces of flanks and links on the orders that the grid resolves and the lattice drops.

It is exact, because the grid of phases holds the whole force (derived here).  Each dropped row is turned into a motion
by D^-1, so that a force far above all modes counts for little.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ...system.system import Array
from .problem import Problem, State, balanced_forces

__all__ = ["TruncatedOrders", "truncated_orders", "truncation_residual"]

# Rounding of a sum of shaft orders per highest order, which is 1 at the edge of the lattice.
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TruncatedOrders:
    """Orders of a grid, half of them along its last axis, that are no lattice points.

    place : (T,) which of them.  omega : (T,) at s = 1 [rad/s].  weight : (T,) of their squared amplitudes.
    kind : (T,) each mesh tone, combinations of mesh tones, each shaft tone.  kinds : how many of these.
    """

    place: NDArray[np.int64]
    omega: Array
    weight: Array
    kind: NDArray[np.int64]
    kinds: int


def truncated_orders(given: Problem, tones: Array, *, mesh: int, orders: tuple[int, ...]) -> TruncatedOrders:
    """The orders that a balance drops.

    Parameters
    ----------
    tones : (D,) at s = 1 [rad/s], of which `mesh` are mesh tones.  orders : highest of each shaft tone.
    """
    counts, points = given.grid.counts, given.grid.points
    D = len(counts)
    axes = [np.rint(np.fft.fftfreq(count, 1 / count)).astype(np.int64) for count in counts]
    axes[-1] = np.arange(counts[-1] // 2 + 1)
    every = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, D)
    shape = tuple(axis.size for axis in axes)
    kept = np.zeros(shape, bool)
    for signed in (points, -points):
        here = signed[signed[:, -1] >= 0]
        kept[tuple((here % np.array(counts)).T)] = True
    out = np.flatnonzero(~kept.ravel())
    found = every[out]
    return TruncatedOrders(
        place=out,
        omega=found @ tones[:D],
        weight=np.where(found[:, -1] > 0, 4.0, 2.0),
        kind=_kind(found, mesh, orders),
        kinds=mesh + 1 + len(orders),
    )


def _kind(found: NDArray[np.int64], mesh: int, orders: tuple[int, ...]) -> NDArray[np.int64]:
    """Kind (T,) of dropped orders (T, D): the mesh tone, combination or shaft tone that leaves the lattice."""
    own = np.argmax(np.abs(found[:, :mesh]), axis=1)
    kind = np.where(np.count_nonzero(found[:, :mesh], axis=1) > 1, mesh, own)
    if orders:
        share = np.abs(found[:, mesh:]) / np.array(orders)
        kind = np.where(share.sum(axis=1) > 1 + _ROUNDING, mesh + 1 + np.argmax(share, axis=1), kind)
    return kind


def truncation_residual(given: Problem, at: State, truncated: TruncatedOrders) -> Array:
    """Norm of the motion that the forces would put on the orders dropped, by kind (kinds,) [root of energy]."""
    force, modal, rows = balanced_forces(given, at), given.modal, given.rows
    live = force.any(axis=0)
    if not live.any():  # no row presses at any phase
        return np.zeros(truncated.kinds)
    box = force[:, live].reshape(*given.grid.counts, -1)
    D = len(given.grid.counts)
    dropped = fft.rfftn(box, axes=range(D), norm="forward").reshape(-1, box.shape[-1])[truncated.place]
    w = at.speed * truncated.omega[:, None]
    if rows.lag.any():
        dropped = dropped * (1 + 1j * w * rows.lag[live])
    square = np.abs(dropped @ rows.pulls[live]) ** 2
    square /= np.maximum((modal.squared - w**2) ** 2 + (w * modal.damping) ** 2, np.finfo(float).tiny)
    each = truncated.weight * square.sum(axis=1)
    size: Array = np.sqrt(np.bincount(truncated.kind, weights=each, minlength=truncated.kinds))
    return size
