"""What a balance drops: the forces of the flanks on the orders that the grid knows and the lattice has not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ...system.system import Array
from .problem import Problem, State, flank_force

__all__ = ["TruncatedOrders", "truncated_orders", "truncation_residual"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TruncatedOrders:
    """Orders of a grid, half of them along its last axis, that are no lattice points.

    place : (T,) which of them.  omega : (T,) at s = 1 [rad/s].  weight : (T,) of their squared amplitudes.
    kind : (T,) each mesh tone, combinations of mesh tones, each slow tone.  kinds : how many of these.
    """

    place: NDArray[np.int64]
    omega: Array
    weight: Array
    kind: NDArray[np.int64]
    kinds: int


def truncated_orders(given: Problem, tones: Array, *, mesh: int, orders: tuple[int, ...]) -> TruncatedOrders:
    """The orders dropped by a balance on `mesh` tones and slow tones with their highest orders; tones (D,) [rad/s]."""
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
    own = np.argmax(np.abs(found[:, :mesh]), axis=1)
    kind = np.where(np.count_nonzero(found[:, :mesh], axis=1) > 1, mesh, own)
    if orders:
        share = np.abs(found[:, mesh:]) / np.array(orders)
        kind = np.where(share.sum(axis=1) > 1 + 1e-9, mesh + 1 + np.argmax(share, axis=1), kind)
    return kind


def truncation_residual(given: Problem, at: State, truncated: TruncatedOrders) -> Array:
    """Size of the motion that the forces would put on the orders dropped, (kinds,)."""
    force, modal = flank_force(given, at), given.modal
    live = force.any(axis=0)
    box = force[:, live].reshape(*given.grid.counts, -1)
    D = len(given.grid.counts)
    rows = fft.rfftn(box, axes=range(D), norm="forward").reshape(-1, box.shape[-1])[truncated.place]
    w = at.speed * truncated.omega[:, None]
    square = np.abs(rows @ given.flanks.pulls[live]) ** 2
    square /= np.maximum((modal.squared - w**2) ** 2 + (w * modal.damping) ** 2, np.finfo(float).tiny)
    each = truncated.weight * square.sum(axis=1)
    size: Array = np.sqrt(np.bincount(truncated.kind, weights=each, minlength=truncated.kinds))
    return size
