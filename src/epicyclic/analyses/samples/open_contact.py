"""Contact that opens, of many samples at once: active sets, grouped by the rows that differ from the closed train.

A row whose stiffness is kappa instead of k0 adds the pull y = (k0 - kappa) g to the closed stretches, g = g0 + S y
(`load_map`).  Samples with one set of such rows share one small inverse.  All rows change at first that contradict
their state, a Newton step of the contact problem; samples that still change after some steps go on with the first
contradicting row alone, which ends where S is that of a train that is held [murty1974].  A set that contradicts none
of its rows is the equilibrium; stretches that do not solve its equations to `_CONSISTENT` are not found, nor are those
whose rows would press otherwise by `LEFT` of the largest force.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from ..static.equilibrium import LEFT
from .load_map import LoadMap

__all__ = ["net_forces"]

# Steps with all rows at once, and altogether: one row at a time needs about as many as there are rows.
_NEWTON, _STEPS = 12, 120
# Part of its stiffness that an open row keeps while sets are sought, so that a body all of whose meshes are open
# does not make the set singular; the forces of the set that is found are without it.
_OPEN = 1e-9
# Stretch that is neither open nor closed, per the largest of the sample: rounding.
_ROUNDING = 1e-12
# Part of the largest closed stretch of a sample that a solution of its set may miss: not of the stretches of the set,
# which rounding alone may be, where a branch is open on both sides and its gaps are not unique.
_CONSISTENT = 1e-9
# Numbers of one batch of matrices.
_BATCH = 4_000_000


def net_forces(
    given: LoadMap, closed: Array, rows: NDArray[np.int64] | None = None, stiffness: Array | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """Forces of the mesh rows (T, m) [N], negative on far flanks, and whether each was found (T,).

    Parameters
    ----------
    closed : (T, M) stretches with the stiffness of the map in all rows, loaded flanks closed [m].
    rows, stiffness : (V,) mesh rows and links with a stiffness of their own, and that (T, V) [N/m].
    """
    pressing = _pressing(given, len(closed), rows, stiffness)
    F = given.mesh_count + given.far.size
    state = np.tile(given.flexible.stiffness[:F] > 0, (len(closed), 1))
    found = np.zeros(len(closed), bool)
    stretch = np.empty_like(closed)
    size = _ROUNDING * np.abs(closed).max(axis=1, initial=0.0)
    todo = np.arange(len(closed))
    same = rows is None
    for step in range(_STEPS):
        own = pressing if same else pressing[todo]
        g, regular = _stretch_of(given, closed[todo], state[todo], own, open_part=_OPEN, same=same)
        wrong = (g[:, :F] > 0) != state[todo]
        wrong &= np.abs(g[:, :F]) > size[todo, None]
        wrong[~regular] = False
        found[todo] = ~wrong.any(axis=1) & regular
        if step >= _NEWTON:  # the first alone
            wrong &= np.cumsum(wrong, axis=1) == 1
        state[todo] ^= wrong
        todo = todo[wrong.any(axis=1)]
        if not todo.size:
            break
    stretch, regular = _stretch_of(given, closed, state, pressing, open_part=0.0, same=same)
    found &= np.asarray(regular & np.isfinite(stretch.sum(axis=1)))
    force = stretch[:, :F] * np.where(state, pressing[..., :F], 0.0)
    net = force[:, : given.mesh_count].copy()
    net[:, given.far] -= force[:, given.mesh_count :]
    return net, np.asarray(found, bool)


def _pressing(given: LoadMap, count: int, rows: NDArray[np.int64] | None, stiffness: Array | None) -> Array:
    """Stiffness of every row that presses [N/m], (M,) of all samples or (T, M)."""
    k = given.flexible.stiffness.copy()
    m, c = given.mesh_count, given.far.size
    k[m : m + c] = given.far_stiffness
    if rows is None or stiffness is None:
        return k
    own = np.tile(k, (count, 1))
    own[:, rows] = stiffness
    own[:, m : m + c] = own[:, given.far]
    return own


def _stretch_of(
    given: LoadMap, closed: Array, state: NDArray[np.bool_], pressing: Array, *, open_part: float, same: bool
) -> tuple[Array, NDArray[np.bool_]]:
    """Stretches (T, M) [m] of given sets, and whether the train is held in each (T,).

    state : (T, F) flanks that press.  pressing : (M,) or (T, M) stiffness of those [N/m].  same : of all samples.
    """
    T, M = closed.shape
    F, k0, S = state.shape[1], given.flexible.stiffness, given.flexible.to_mesh
    stretch, regular = closed.copy(), np.ones(T, bool)
    if not same:
        kappa = pressing.copy()
        kappa[:, :F] = np.where(state, pressing[:, :F], open_part * k0[:F])
        for first in range(0, T, max(1, _BATCH // M**2)):
            part = slice(first, first + max(1, _BATCH // M**2))
            matrix = np.eye(M) - S * (k0 - kappa[part])[:, None, :]
            stretch[part], regular[part] = _solved(matrix, closed[part])
            if not open_part:
                missed = (matrix @ stretch[part, :, None])[..., 0] - closed[part]
                regular[part] &= _consistent(missed, closed[part])
                regular[part] &= _balanced(np.maximum(k0, kappa[part]) * missed, kappa[part] * stretch[part])
        return stretch, regular
    for at in _alike(state, np.flatnonzero((state != (k0[:F] > 0)).any(axis=1))):
        kappa = k0.copy()
        kappa[:F] = np.where(state[at[0]], pressing[:F], open_part * k0[:F])
        differs = np.flatnonzero(k0 != kappa)
        D = (k0 - kappa)[differs]
        matrix = np.eye(differs.size) - S[np.ix_(differs, differs)] * D
        right = closed[np.ix_(at, differs)]
        own, regular[at] = _solved(matrix[None], right.T[None])
        if not open_part:
            regular[at] &= _consistent((matrix @ own[0]).T - right, closed[at])
        stretch[at] = closed[at] + (own[0].T * D) @ S[:, differs].T
        if not open_part:
            missed = stretch[np.ix_(at, differs)] - own[0].T
            regular[at] &= _balanced(np.maximum(k0, kappa)[differs] * missed, kappa * stretch[at])
    return stretch, regular


def _alike(state: NDArray[np.bool_], chosen: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The chosen samples in groups of one set of rows each."""
    if not chosen.size:
        return []
    packed = np.packbits(state[chosen], axis=1)
    order = np.lexsort(packed.T)
    new = np.any(np.diff(packed[order], axis=0) != 0, axis=1)
    return np.split(chosen[order], np.flatnonzero(new) + 1)


def _solved(matrix: Array, right: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Solutions of batched linear equations and whether each matrix is regular."""
    vector = right.ndim == 2
    try:
        found = np.linalg.solve(matrix, right[..., None] if vector else right)
        return np.asarray(found[..., 0] if vector else found), np.ones(len(matrix), bool)
    except np.linalg.LinAlgError:
        if len(matrix) == 1:
            return _of_least_size(matrix, right)
        halves = [_solved(*each) for each in zip(np.array_split(matrix, 2), np.array_split(right, 2), strict=True)]
        solution: Array = np.concatenate([half[0] for half in halves])
        return solution, np.concatenate([half[1] for half in halves])


def _of_least_size(matrix: Array, right: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The solution of least size of one singular equation (1, n, n), and whether it is one.

    A branch that is open on both sides turns freely: the gaps of its rows are not unique, all forces are.
    """
    found = np.linalg.lstsq(matrix[0], right[0], rcond=None)[0]
    return found[None], _consistent((matrix[0] @ found - right[0]).reshape(1, -1), right.reshape(1, -1))


def _consistent(missed: Array, closed: Array) -> NDArray[np.bool_]:
    """Whether what equations miss (T, n) [m] is rounding beside the closed stretches (T, M) [m], each sample (T,)."""
    size = np.max(np.abs(closed), axis=1, initial=0.0)
    agree: NDArray[np.bool_] = np.max(np.abs(missed), axis=1, initial=0.0) <= _CONSISTENT * size
    return agree


def _balanced(missed: Array, force: Array) -> NDArray[np.bool_]:
    """Whether forces that rows miss (T, n) [N] are rounding beside those of all rows (T, M) [N], each sample (T,)."""
    left = np.max(np.abs(missed), axis=1, initial=0.0)
    largest = np.max(np.abs(force), axis=1, initial=0.0)
    return np.asarray((left <= LEFT * largest) | (largest == 0))
