"""The batch of `balance` compiled: one point after another, each with all its vectors in the cache.  Needs numba.

The equation, its preconditioner, GMRES and the residuals are those of `balance` and `gmres`, for one mesh frequency.
One thing is done otherwise: G, Kg, Cskew and dampers act on the few coordinates that they touch, entry by entry, so
that a product with the operator is two small matrix products: y -> gaps and touched coordinates -> forces on y.

A point holds y as (2 J, n), real parts over imaginary ones.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from .touched import Shared

__all__ = ["solve_points"]

Index = NDArray[np.int64]
F = TypeVar("F", bound=Callable[..., object])
_TINY = 1e-300
# vectors before a restart, and how often to restart, as in `gmres`
_BASIS, _RESTARTS = 60, 6


def _compiled(function: F) -> F:
    """Compiled on first use and kept on disk; sums in any order, numbers that are not finite stay as they are."""
    return cast(F, numba.njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})(function))


class _Scratch(NamedTuple):
    """Room for one point: values read and forces (m + r, 2 J), their work on y (2 J, n), entries at this speed (e,),
    1/D (2, J, n), the Krylov vectors (K + 1, 2 J n), triangle (K, K), rotations (2, K) and right side (K + 1,)."""

    values: Array
    forces: Array
    work: Array
    stiff: Array
    rate: Array
    inverse: Array
    vectors: Array
    triangle: Array
    rotations: Array
    projected: Array


def solve_points(
    shared: Shared,
    frequency: Array,
    frame: Array,
    right: Array,
    *,
    start: tuple[Array, Array] | None,
    tolerance: float,
    mean: bool,
) -> tuple[Array, Array, Array, int]:
    """Solve a batch.

    Parameters
    ----------
    frequency : (P, J) [rad/s].  frame : (P,).  right : (P, 2, J, n).
    start : solution to start from (P, 2, J, n) and its scale (P,); None starts from the diagonal alone.
    mean : whether row 0 is a mean, which is no part of the scale.

    Returns
    -------
    (y (P, 2, J, n), residual (P,) relative to the scale, scale (P,), largest count of operator calls).
    """
    (P, J), n = frequency.shape, shared.squared.size
    y, known = (np.zeros((P, 2 * J, n)), np.zeros(P)) if start is None else (start[0].copy(), start[1].copy())
    y = y.reshape(P, 2 * J, n)
    left, calls = np.empty(P), np.empty(P, np.int64)
    flat = np.ascontiguousarray(right).reshape(P, 2 * J, n)
    _solve_all(shared, frequency, np.ascontiguousarray(frame), flat, y, known, left, calls, tolerance, mean)
    return y.reshape(right.shape), left / known, known, int(calls.max(initial=0))


@_compiled
def _solve_all(
    shared: Shared,
    frequency: Array,
    frame: Array,
    right: Array,
    y: Array,
    scale: Array,
    left: Array,
    calls: Index,
    tolerance: float,
    mean: bool,
) -> None:
    J, n, c = frequency.shape[1], shared.squared.size, shared.read.shape[0]
    scratch = _Scratch(
        np.empty((c, 2 * J)),
        np.empty((c, 2 * J)),
        np.empty((2 * J, n)),
        np.empty(shared.row.size),
        np.empty(shared.row.size),
        np.empty((2, J, n)),
        np.empty((_BASIS + 1, 2 * J * n)),
        np.empty((_BASIS, _BASIS)),
        np.empty((2, _BASIS)),
        np.empty(_BASIS + 1),
    )
    first = np.empty((2 * J, n))
    for p in range(frequency.shape[0]):
        _prepare(shared, scratch, frequency[p], frame[p])
        _precondition(scratch.inverse, right[p], first)
        blank = scale[p] == 0
        if blank:
            y[p] = first
        residual = _residual(shared, scratch, frequency[p], first, y[p])
        if blank:
            scale[p] = _scale(first, residual, mean)
        left[p], calls[p] = _gmres(shared, scratch, frequency[p], first, y[p], residual, tolerance * scale[p])


@_compiled
def _prepare(shared: Shared, scratch: _Scratch, frequency: Array, frame: float) -> None:
    """1/D, 0 for the mean of a rigid mode, and the entries at this speed."""
    for a in range(frequency.size):
        w = frequency[a]
        for r in range(shared.squared.size):
            real, imag = shared.squared[r] - w * w, w * shared.damping[r]
            size = real * real + imag * imag
            over = 0.0 if size == 0 else 1 / size
            scratch.inverse[0, a, r], scratch.inverse[1, a, r] = real * over, imag * over
    scratch.stiff[:] = frame * frame * shared.stiff[0] + frame * shared.stiff[1]
    scratch.rate[:] = frame * shared.rate[0] + shared.rate[1]


@_compiled
def _precondition(inverse: Array, given: Array, out: Array) -> None:
    J = inverse.shape[1]
    for a in range(J):
        for r in range(given.shape[1]):
            real, imag = given[a, r], given[J + a, r]
            out[a, r] = inverse[0, a, r] * real + inverse[1, a, r] * imag
            out[J + a, r] = inverse[0, a, r] * imag - inverse[1, a, r] * real


@_compiled
def _apply(shared: Shared, scratch: _Scratch, frequency: Array, y: Array, out: Array) -> None:
    """out = y + D^-1 coupling y."""
    values, forces, work, J, m = scratch.values, scratch.forces, scratch.work, frequency.size, shared.own.shape[0]
    np.dot(shared.read, y.T, values)
    forces[:] = 0.0
    for k in range(m):
        for a in range(2 * J):
            gap = values[k, a]
            for b in range(2 * J):
                forces[k, b] += gap * shared.own[k, a, b]
    for e in range(shared.row.size):
        i, j, stiff, rate = shared.row[e], shared.column[e], scratch.stiff[e], scratch.rate[e]
        for a in range(J):
            forces[i, a] += stiff * values[j, a] - rate * frequency[a] * values[j, J + a]
        for a in range(J):
            forces[i, J + a] += stiff * values[j, J + a] + rate * frequency[a] * values[j, a]
    np.dot(forces.T, shared.push, work)
    for a in range(J):
        for r in range(y.shape[1]):
            extra = frequency[a] * shared.diagonal[r]
            real, imag = work[a, r] + extra * y[J + a, r], work[J + a, r] - extra * y[a, r]
            out[a, r] = y[a, r] + scratch.inverse[0, a, r] * real + scratch.inverse[1, a, r] * imag
            out[J + a, r] = y[J + a, r] + scratch.inverse[0, a, r] * imag - scratch.inverse[1, a, r] * real


@_compiled
def _residual(shared: Shared, scratch: _Scratch, frequency: Array, first: Array, y: Array) -> Array:
    out = np.empty_like(y)
    _apply(shared, scratch, frequency, y, out)
    for a in range(y.shape[0]):
        for r in range(y.shape[1]):
            out[a, r] = first[a, r] - out[a, r]
    return out


@_compiled
def _scale(first: Array, residual: Array, mean: bool) -> float:
    """As `balance._scale`."""
    total = np.sum(first * first)
    still = np.sum(first[0] * first[0]) if mean else 0.0
    size = np.sqrt(max(max(total - still, 0.0) + np.sum(residual * residual), 1e-12 * total))
    return 1.0 if size == 0 else size


@_compiled
def _gmres(
    shared: Shared, scratch: _Scratch, frequency: Array, first: Array, y: Array, residual: Array, target: float
) -> tuple[float, int]:
    """Improve y until the true residual norm is at the target: (that norm, operator calls)."""
    norm, calls = np.sqrt(np.sum(residual * residual)), 1
    for _ in range(_RESTARTS):
        if not norm > target:
            break
        step, used = _cycle(shared, scratch, frequency, residual, norm, target)
        trial = y + step.reshape(y.shape)
        left = _residual(shared, scratch, frequency, first, trial)
        calls += used + 1
        last, norm = norm, np.sqrt(np.sum(left * left))
        if norm >= last:  # a singular point may come out worse than it went in: keep what it had
            return last, calls
        y[:], residual = trial, left
        if not norm < 0.9 * last:
            break
    return norm, calls


@_compiled
def _cycle(
    shared: Shared, scratch: _Scratch, frequency: Array, residual: Array, norm: float, target: float
) -> tuple[Array, int]:
    """One Arnoldi cycle with classical Gram-Schmidt: (step (2 J n,), operator calls)."""
    V, R, turn, g, shape = scratch.vectors, scratch.triangle, scratch.rotations, scratch.projected, residual.shape
    V[0] = residual.reshape(-1) / max(norm, _TINY)
    g[0] = norm
    k = 0
    while k < _BASIS:
        new = V[k + 1]
        _apply(shared, scratch, frequency, V[k].reshape(shape), new.reshape(shape))
        along = np.dot(V[: k + 1], new)
        new -= np.dot(along, V[: k + 1])
        left = np.sqrt(np.dot(new, new))
        new *= 1 / max(left, _TINY)
        _rotate(R, turn, g, k, along, left)
        k += 1
        if not abs(g[k]) > 0.5 * target:
            break
    for i in range(k - 1, -1, -1):
        g[i] = (g[i] - np.dot(R[i, i + 1 : k], g[i + 1 : k])) / (1.0 if R[i, i] == 0 else R[i, i])
    return np.dot(g[:k], V[:k]), k


@_compiled
def _rotate(R: Array, turn: Array, g: Array, k: int, along: Array, below: float) -> None:
    """Column k of the triangle from the components of a new vector, by Givens rotations, and the right side with it."""
    for i in range(k + 1):
        R[i, k] = along[i]
    for i in range(k):
        upper, lower = R[i, k], R[i + 1, k]
        R[i, k], R[i + 1, k] = turn[0, i] * upper + turn[1, i] * lower, turn[0, i] * lower - turn[1, i] * upper
    length = max(np.hypot(R[k, k], below), _TINY)
    turn[0, k], turn[1, k] = R[k, k] / length, below / length
    R[k, k] = length
    g[k + 1], g[k] = -turn[1, k] * g[k], turn[0, k] * g[k]
