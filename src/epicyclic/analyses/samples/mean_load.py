"""Load sharing without mesh-frequency content: `mean-load` and `mean-load-turning`, of many samples at once.

    mean-load          per pair and side the largest N F_i / sum F, F averaged over the hunting period
    mean-load-turning  the largest of that over the hunting period, F then the mean of a mesh cycle

F is the quasi-static force at mean mesh stiffness.  While contact stays, what turns averages out of the first.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray
from ..static.record import MeshGroup
from .phases import SlowPhases, any_tied, largest_sum, units_of_largest

__all__ = [
    "MEAN_LOADS",
    "closed_loads",
    "falls_below",
    "largest_of_groups",
    "least_forces",
    "loads_at_phases",
    "shares",
]

MEAN_LOADS = ("mean-load", "mean-load-turning")
# A sum of forces that turns by less than this part of itself is constant: rounding.
_CONSTANT = 1e-12
# Dinkelbach steps, each quadratic; more than six are never seen.
_STEPS = 12


def closed_loads(force: Array, wave: ComplexArray, members: Sequence[MeshGroup], phases: SlowPhases) -> Array:
    """N F_i / sum F (2, S, w) [1] while contact stays, by `MEAN_LOADS`; inf where the sum may be zero or less.

    Parameters
    ----------
    force : (S, w) what stands still [N].  wave : (G, S, w) amplitudes of what turns [N].
    """
    loads = np.empty((2, *force.shape))
    for group in members:
        own, turning = force[:, group], wave[:, :, group]
        total, swing = own.sum(axis=1, keepdims=True), turning.sum(axis=2, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(total > 0, own / total, np.inf)
        loads[0][:, group] = len(group) * share
        loads[1][:, group] = len(group) * _largest_share(share, total, own, (turning, swing), phases)
    return loads


def _largest_share(
    share: Array, total: Array, own: Array, waves: tuple[ComplexArray, ComplexArray], phases: SlowPhases
) -> Array:
    """Largest F_i / sum F (S, N) over the slow phases, both turning: Dinkelbach's iteration.

    The largest of F_i - lambda sum F over the phases gives the next lambda, which rises to the largest ratio.

    share : (S, N) without what turns.  total : (S, 1) and own : (S, N) [N].  waves : of own (G, S, N), of total
    (G, S, 1) [N].
    """
    turning, swing = waves
    if not len(turning):
        return share
    with np.errstate(divide="ignore", invalid="ignore"):
        if not np.any(np.abs(swing) > _CONSTANT * np.abs(total)):
            return np.where(total > 0, (own + largest_sum(phases, turning)) / total, np.inf)
        least = total - largest_sum(phases, -swing)
        for _ in range(_STEPS):
            unit = units_of_largest(phases, turning - share * swing)
            found = (own + _summed(turning, unit)) / (total + _summed(np.broadcast_to(swing, turning.shape), unit))
            higher = np.maximum(share, found)
            if np.all(higher <= share * (1 + _CONSTANT)):
                break
            share = higher
    return np.where(least > 0, share, np.inf)


def _summed(wave: ComplexArray, unit: ComplexArray) -> Array:
    """Re sum a u over the G waves of (G, S, N), (S, N)."""
    result: Array = np.einsum("gsn,gsn->sn", wave.real, unit.real) - np.einsum("gsn,gsn->sn", wave.imag, unit.imag)
    return result


def least_forces(force: Array, wave: ComplexArray, phases: SlowPhases) -> Array:
    """Least force (S, w) [N] over the slow phases, of forces (S, w) and waves (G, S, w) [N]."""
    if not len(wave):
        return force
    return force - largest_sum(phases, -wave)


def falls_below(force: Array, wave: ComplexArray, phases: SlowPhases, limit: Array) -> NDArray[np.bool_]:
    """Samples (S,) of which any value (S, M) is below a limit (S, 1) at some slow phases, of waves (G, S, M)."""
    below: NDArray[np.bool_] = (force - np.abs(wave).sum(axis=0) < limit).any(axis=1)
    if any_tied(phases) and below.any():  # tied waves reach less
        at = np.flatnonzero(below)
        below[at] = (least_forces(force[at], wave[:, at], phases) < limit[at]).any(axis=1)
    return below


def loads_at_phases(force: Array, mean: Array, members: Sequence[MeshGroup]) -> Array:
    """N F_i / sum F (2, S, w) [1] by `MEAN_LOADS`; inf where the sum is zero or less.

    Parameters
    ----------
    force : (S, T, w) at T slow phases, the worst among them [N].  mean : (S, w) over all slow phases [N].
    """
    return np.stack([shares(mean[:, None], members)[:, 0], shares(force, members).max(axis=1)])


def shares(force: Array, members: Sequence[MeshGroup]) -> Array:
    """N F_i / sum F (S, T, w) [1] of forces (S, T, w) [N]; inf where the sum is zero or less."""
    found = np.empty_like(force)
    for group in members:
        own = force[:, :, group]
        total = own.sum(axis=2, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            found[:, :, group] = np.where(total > 0, len(group) * own / total, np.inf)
    return found


def largest_of_groups(loads: Array, members: Sequence[MeshGroup]) -> Array:
    """Coefficient of every group (..., g) from loads of the meshes (..., w) [1]."""
    return np.stack([loads[..., group].max(axis=-1) for group in members], axis=-1)
