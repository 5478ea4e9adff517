"""Propagation over many steps of flow and kick: parts that nothing couples, and each as a product in few operations.

Three things make a product of thousands of steps cheap, none of which changes it but for rounding; derived here.

- Coordinates that no mesh and no mean term couples at any instant are propagated apart, as the symmetric and the
  antisymmetric motions of a herringbone train whose sides mesh in phase.  Work goes with the cube of the size.
- The kicks of a part act through as many combinations of its gaps as its mesh rows have rank, however many rows there
  are: both sides of a herringbone mesh are one where nothing tilts.
- Steps are taken several at a time.  The gaps met by the kicks of such a group follow from its first state and the
  impulses before, by small matrices; the large ones are multiplied once a group.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ...system.system import Array

__all__ = ["independent_parts", "kick_maps", "monodromy"]

Index = NDArray[np.int64]

# Couplings below this part of the product of the natural frequencies are rounding: that of gaps of close modes reaches
# 1e-13, the least couplings of trains are 1e-10.
_COUPLED = 1e-12
# Combinations of gaps this small beside the largest are rounding of mesh rows that depend on each other.
_RANK = 1e-12
# Steps of a group at most: beyond it the large products are no longer what costs.
_GROUP = 12
# Doubles of the matrices of groups multiplied side by side: they and their products stay in the second cache.
_BATCH = 100_000


def independent_parts(
    generator: Array, rows: Array, weight: Array, *, stiffness: Array, damping: Array | None
) -> list[Index]:
    """Coordinates (n,) of each part of a linear flow that no other part acts on at any step.

    Parameters
    ----------
    generator : (k + n, k + n) of the mean system, state (y, u), y of the last k coordinates [1/s].
    rows : (m, n) gap rate of u.  weight : (n,) of y [rad/s].
    stiffness, damping : (m, N) changes of the meshes at N steps [N/m], [N s/m].
    """
    n = len(weight)
    k, root = len(generator) - n, np.sqrt(weight)
    coupling = np.abs(generator[k:, k:]) / np.outer(root, root)
    coupling[:, n - k :] = np.maximum(coupling[:, n - k :], np.abs(generator[k:, :k]) / weight[:, None])
    for change, scaled in ((stiffness, rows / weight), (damping, rows / root)):
        if change is not None:
            coupling = np.maximum(coupling, _largest_coupling(change, scaled))
    joined = (coupling > _COUPLED) | (coupling.T > _COUPLED) | np.eye(n, dtype=bool)
    reached = 0
    while np.count_nonzero(joined) > reached:
        reached, numbers = int(np.count_nonzero(joined)), joined.astype(float)
        joined = numbers @ numbers > 0
    first = np.argmax(joined, axis=1)
    return [np.flatnonzero(first == one) for one in np.unique(first)]


def _largest_coupling(change: Array, rows: Array) -> Array:
    """Root mean square over the steps of what rows (m, n) with factors (m, N) couple, (n, n)."""
    m, n = rows.shape
    # of all the steps only the triangle of their QR counts, in which small differences of rows are not squared
    triangle = np.linalg.qr(change.T, mode="r") / np.sqrt(change.shape[1])
    pairs = triangle @ (rows[:, :, None] * rows[:, None, :]).reshape(m, -1)
    result: Array = np.linalg.norm(pairs, axis=0).reshape(n, n)
    return result


def kick_maps(stiffness: Array, damping: Array | None, mass: Array, step: float) -> Array:
    """Impulses [N s] per gap, and per gap rate where damping changes, of steps of a length [s]: (S, r, r or 2 r).

    With the double commutator of the splitting; the rate decays while it is kicked: the implicit midpoint of that.

    Parameters
    ----------
    stiffness, damping : (S, r, r) of the gaps at each step, less their means [N/m], [N s/m].
    mass : (r, r) B^T M^-1 B [1/kg].
    """
    force: Array = stiffness - (step**2 / 12) * ((stiffness @ mass) @ stiffness)
    if damping is None:
        return step * force
    held = np.eye(len(mass)) + (step / 2) * (damping @ mass)
    result: Array = step * np.linalg.solve(held, np.concatenate([force, damping], axis=2))
    return result


def monodromy(
    generator: Array, gaps: Array, rows: Array, *, stiffness: Array, damping: Array | None, step: float
) -> Array:
    """Flow after kick over all steps, (k + n, k + n).

    Parameters
    ----------
    generator, rows, stiffness, damping : as of `independent_parts`.  gaps : (m, k) gap of y.  step : [s].
    """
    flow = scipy.linalg.expm(generator * step)
    combined = _combinations(gaps)
    r, count = combined.shape[1], stiffness.shape[1]
    if not r:
        result: Array = np.linalg.matrix_power(flow, count)
        return result
    gaps, rows = combined.T @ gaps, combined.T @ rows
    sensed = scipy.linalg.block_diag(gaps, rows) if damping is not None else np.pad(gaps, ((0, 0), (0, rows.shape[1])))
    size = _group_size(len(flow), len(sensed), r, count)
    group = _group(flow, sensed, rows, size)
    pairs = (combined[:, :, None] * combined[:, None, :]).reshape(len(combined), -1)
    mass, whole = rows @ rows.T, np.eye(len(flow))
    batch = size * max(2, _BATCH // (2 * flow.size + size * r * len(flow)))
    for first in range(0, count, batch):
        part = slice(first, min(first + batch, count))
        springs = (stiffness.T[part] @ pairs).reshape(-1, r, r)
        dampers = None if damping is None else (damping.T[part] @ pairs).reshape(-1, r, r)
        maps = kick_maps(springs, dampers, mass, step)
        left = len(maps) % size
        if len(maps) > left:
            whole = _group_product(group, maps[: len(maps) - left]) @ whole
        if left:
            whole = _group_product(_shorter(group, flow, left), maps[len(maps) - left :]) @ whole
    return whole


def _combinations(gaps: Array) -> Array:
    """Orthonormal combinations (m, r) of mesh rows, gap of y (m, k), through which all of them act."""
    left, sizes, _ = np.linalg.svd(gaps, full_matrices=False)
    rank = int(np.sum(sizes > _RANK * np.max(sizes, initial=0.0)))
    # all of them are independent: themselves
    return np.eye(len(gaps)) if rank == len(gaps) else left[:, :rank]


def _group_size(size: int, sensed: int, rank: int, count: int) -> int:
    """Steps of a group with the least operations, of a state of `size`."""
    # sensed rank size (g - 1) of the gaps within a group, 2 size^3 / g of its product with the others, a step
    best = max(1, min(round(size * sqrt(2 / (sensed * rank))), _GROUP))
    # as equal as can be, of few steps
    return ceil(count / ceil(count / best))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Group:
    """Tables of g steps from one state, of length N.

    first : (g, s, N) gaps met by each kick without those before.
    later : (s, (g - 1) r) of the impulses before a kick, of the earliest one first: the last j r columns of kick j.
    flow : (N, N).  pushes : (N, g r) of the state after the group by its impulses.
    """

    first: Array
    later: Array
    flow: Array
    pushes: Array


def _group(flow: Array, sensed: Array, rows: Array, size: int) -> _Group:
    """Tables of `size` steps: flow (N, N) of one step, sensed (s, N) gaps of a state, rows (r, n) pushing its rates."""
    push = np.zeros((len(flow), len(rows)))
    push[len(flow) - rows.shape[1] :] = rows.T
    first, pushed = [sensed], [push]
    for _ in range(size - 1):
        first.append(first[-1] @ flow)
    for _ in range(size):
        pushed.append(flow @ pushed[-1])
    pushes = -np.hstack(pushed[:0:-1])
    return _Group(
        first=np.stack(first),
        later=sensed @ pushes[:, len(rows) :],
        flow=np.linalg.matrix_power(flow, size),
        pushes=pushes,
    )


def _shorter(group: _Group, flow: Array, size: int) -> _Group:
    """Tables of the first `size` steps of a group; flow (N, N) of one step."""
    r = group.pushes.shape[1] // len(group.first)
    return _Group(
        first=group.first[:size],
        later=group.later[:, group.later.shape[1] - (size - 1) * r :],
        flow=np.linalg.matrix_power(flow, size),
        pushes=group.pushes[:, group.pushes.shape[1] - size * r :],
    )


def _group_product(group: _Group, maps: Array) -> Array:
    """Product of Q groups of g steps, (N, N); maps : (Q g, r, s) of `kick_maps`.

    Groups are multiplied in pairs, pairs in pairs: every level is one product of many small matrices side by side.
    """
    g, s, N = group.first.shape
    r, count = maps.shape[1], len(maps) // g
    maps = maps.reshape(count, g, r, s)
    impulses, met = np.empty((g * r, count, N)), np.empty((s, count, N))
    for j in range(g):
        out = impulses[j * r : (j + 1) * r].transpose(1, 0, 2)
        if j:
            later = group.later[:, group.later.shape[1] - j * r :]
            np.matmul(later, impulses[: j * r].reshape(j * r, -1), out=met.reshape(s, -1))
            met += group.first[j][:, None]
            np.matmul(maps[:, j], met.transpose(1, 0, 2), out=out)
        else:
            np.matmul(maps[:, 0], group.first[0], out=out)
    whole = (group.pushes @ impulses.reshape(g * r, -1)).reshape(N, count, N)
    whole += group.flow[:, None]
    here, there = whole.transpose(1, 0, 2), np.empty((N, (count + 1) // 2, N)).transpose(1, 0, 2)
    while count > 1:
        pairs = count // 2
        np.matmul(here[1 : 2 * pairs : 2], here[: 2 * pairs : 2], out=there[:pairs])
        if count % 2:
            there[pairs] = here[count - 1]
        here, there, count = there, here, pairs + count % 2
    result: Array = here[0]
    return result
