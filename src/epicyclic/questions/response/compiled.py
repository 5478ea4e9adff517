"""The harmonic balance of a batch compiled by numba: eight speeds side by side, all their vectors in the cache.

The equation, its preconditioner, GMRES [saad1986] and the residuals are those of `balance`, for one mesh
frequency.  G, Kg, Cskew and dampers act on the few coordinates of `CondensedOperators`, entry by entry, so that a
product with the operator is two small matrix products: y -> gaps and condensed coordinates -> forces on y.

Krylov vectors are single precision: a cycle gains six digits, and the next starts from the true residual in double
precision, as the solution is.  Points that do not reach the tolerance go on in `balance`.

Eight points are one lane each: y is (n, X), X = 2 J 8, real parts of all harmonics and lanes before the imaginary ones.
Lanes are independent: each keeps the vectors up to its own convergence, whatever the others still need.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...machine_code import compiled
from ...system.system import Array
from .balance import CondensedOperators

Index = NDArray[np.int64]
_LANES = 8
_TINY = 1e-300
# Vectors before a restart, how often to restart, and what a cycle in single precision may gain.
_BASIS, _RESTARTS, _GAIN = 60, 4, 1e-6


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


def solve_points(
    operators: CondensedOperators,
    frequency: Array,
    frame: Array,
    right: Array,
    *,
    start: tuple[Array, Array] | None,
    tolerance: float,
    mean: bool,
) -> tuple[Array, Array, Array, int]:
    """Solve a batch of P points.

    Parameters
    ----------
    frequency : (P, J) [rad/s].  frame : (P,) [1].  right : (P, 2, J, n).
    start : solution to start from (P, 2, J, n) and its scale (P,); None starts from the diagonal alone.
    mean : whether harmonic 0 is a mean, which is no part of the scale.

    Returns
    -------
    (y (P, 2, J, n), residual (P,) relative to the scale, scale (P,), largest count of operator calls).
    """
    (P, J), n = frequency.shape, operators.squared.size
    y, scale = (np.zeros((P, 2 * J, n)), np.zeros(P)) if start is None else (start[0].copy(), start[1].copy())
    y, flat = y.reshape(P, 2 * J, n), np.ascontiguousarray(right).reshape(P, 2 * J, n)
    left, calls = np.empty(P), np.empty(P, np.int64)
    single = CondensedOperators._make(each.astype(np.float32) if each.dtype == float else each for each in operators)
    spaces = workspace(operators, J, lanes=_LANES, basis=0), workspace(single, J, lanes=_LANES, basis=_BASIS)
    fixed = operators, single, *spaces, frequency, np.ascontiguousarray(frame), flat
    _solve_all(*fixed, y, scale, left, calls, start is None, tolerance, mean)
    return y.reshape(right.shape), left / scale, scale, int(calls.max(initial=0))


@compiled
def _solve_all(
    operators: CondensedOperators,
    single: CondensedOperators,
    space: Workspace,
    single_space: Workspace,
    frequency: Array,
    frame: Array,
    right: Array,
    y: Array,
    scale: Array,
    left: Array,
    calls: Index,
    from_diagonal: bool,
    tolerance: float,
    mean: bool,
) -> None:
    """Solve all points in groups of eight, into y (P, 2 J, n), scale, left (residual norm) and calls (P,).

    frequency : (P, J) [rad/s].  frame : (P,) [1].  right : (P, 2 J, n).  tolerance : relative to the scale [1].
    """
    (P, J), n = frequency.shape, operators.squared.size
    first, guess, norm = np.empty((n, 2 * J * _LANES)), np.empty((n, 2 * J * _LANES)), np.empty(_LANES)
    size = np.empty(_LANES)
    for start in range(0, P, _LANES):
        _prepare(operators, space, frequency, frame, start)
        _copy(space, single_space)
        _load(right, start, guess)
        _precondition(space.inverse, guess, first)
        if from_diagonal:
            guess = first.copy()
        else:
            _load(y, start, guess)
        residual = _residual(operators, space, first, guess, norm)
        for q in range(_LANES):
            p = min(start + q, P - 1)
            size[q] = _scale(first, norm, q, J, mean) if from_diagonal else scale[p]
        count = _gmres(operators, space, single, single_space, first, guess, residual, norm, tolerance * size)
        for q in range(min(_LANES, P - start)):
            scale[start + q], left[start + q], calls[start + q] = size[q], norm[q], count
            for r in range(n):
                for a in range(2 * J):
                    y[start + q, a, r] = guess[r, a * _LANES + q]


@compiled
def _copy(space: Workspace, single_space: Workspace) -> None:
    """Frame factors, frequencies and 1/D in single precision.  Loops: slices would make numba compile an error text."""
    for i in range(2):
        for x in range(single_space.stiffness_factor.shape[1]):
            single_space.stiffness_factor[i, x] = space.stiffness_factor[i, x]
            single_space.rate_factor[i, x] = space.rate_factor[i, x]
            for r in range(single_space.inverse.shape[1]):
                single_space.inverse[i, r, x] = space.inverse[i, r, x]


@compiled
def _load(points: Array, start: int, out: Array) -> None:
    """Points (P, 2 J, n) from `start` on as lanes (n, X); the last point fills lanes beyond it."""
    P, J2, n = points.shape
    for q in range(_LANES):
        p = min(start + q, P - 1)
        for a in range(J2):
            for r in range(n):
                out[r, a * _LANES + q] = points[p, a, r]


@compiled
def _prepare(operators: CondensedOperators, space: Workspace, frequency: Array, frame: Array, start: int) -> None:
    """Frame factors (P,), frequencies (P, J) [rad/s] and 1/D of all lanes; 1/D is 0 for the mean of a rigid mode."""
    P, J = frequency.shape
    for a in range(J):
        for q in range(_LANES):
            p = min(start + q, P - 1)
            x = a * _LANES + q
            space.stiffness_factor[0, x], space.stiffness_factor[1, x] = frame[p] * frame[p], frame[p]
            space.rate_factor[0, x], space.rate_factor[1, x] = frequency[p, a] * frame[p], frequency[p, a]
    for r in range(operators.squared.size):
        for x in range(J * _LANES):
            w = space.rate_factor[1, x]
            real, imag = operators.squared[r] - w * w, w * operators.damping[r]
            size = real * real + imag * imag
            over = 0.0 if size == 0 else 1 / size
            space.inverse[0, r, x], space.inverse[1, r, x] = real * over, imag * over


@compiled
def _precondition(inverse: Array, values: Array, out: Array) -> None:
    """out = D^-1 values, both (n, X), 1/D as (2, n, H)."""
    half = inverse.shape[2]
    for r in range(values.shape[0]):
        for x in range(half):
            real, imag = values[r, x], values[r, half + x]
            out[r, x] = inverse[0, r, x] * real + inverse[1, r, x] * imag
            out[r, half + x] = inverse[0, r, x] * imag - inverse[1, r, x] * real


@compiled
def _apply(operators: CondensedOperators, space: Workspace, y: Array, out: Array) -> None:
    """out = y + D^-1 coupling y, both (n, X)."""
    values, forces, rate_factor = space.values, space.forces, space.rate_factor
    m, J2 = operators.own.shape[0], operators.own.shape[1]
    np.dot(operators.read, y, values)
    for k in range(m):
        np.dot(operators.own[k], values[k].reshape(J2, _LANES), forces[k].reshape(J2, _LANES))
    forces[m:] = 0.0
    for e in range(operators.row.size):
        value, force = values[operators.column[e]], forces[operators.row[e]]
        _entry(operators.stiff[:, e], operators.rate[:, e], space.stiffness_factor, rate_factor, value, force)
    np.dot(operators.push, forces, space.work)
    for r in range(y.shape[0]):
        _finish(
            space.work[r], y[r], rate_factor[1], operators.diagonal[r], space.inverse[0, r], space.inverse[1, r], out[r]
        )


@compiled
def _entry(stiff: Array, rate: Array, stiffness_factor: Array, rate_factor: Array, values: Array, out: Array) -> None:
    """Add one entry of the operators to a force (X,): out += (stiffness + i rate) values."""
    half = stiffness_factor.shape[1]
    s0, s1, r0, r1 = stiff[0], stiff[1], rate[0], rate[1]
    f2, f1, wf, w = stiffness_factor[0], stiffness_factor[1], rate_factor[0], rate_factor[1]
    real, imag = values[:half], values[half:]
    out_real, out_imag = out[:half], out[half:]
    for x in range(half):
        k, c = s0 * f2[x] + s1 * f1[x], r0 * wf[x] + r1 * w[x]
        out_real[x] += k * real[x] - c * imag[x]
        out_imag[x] += k * imag[x] + c * real[x]


@compiled
def _finish(work: Array, y: Array, rate_factor: Array, diagonal: float, re: Array, im: Array, out: Array) -> None:
    """out = y + D^-1 (work without the diagonal of the dampers, which D holds), of one mode (X,)."""
    half = rate_factor.size
    work_real, work_imag = work[:half], work[half:]
    y_real, y_imag = y[:half], y[half:]
    out_real, out_imag = out[:half], out[half:]
    for x in range(half):
        extra = rate_factor[x] * diagonal
        a, b = work_real[x] + extra * y_imag[x], work_imag[x] - extra * y_real[x]
        out_real[x] = y_real[x] + re[x] * a + im[x] * b
        out_imag[x] = y_imag[x] + re[x] * b - im[x] * a


@compiled
def _products(rows: Array, vectors: Array, y: Array, out: Array) -> None:
    """Scalar products (k, 8) of k vectors (k, n, X) with y (n, X), lane by lane."""
    k, n, X = vectors.shape
    rows[:k] = 0.0
    for r in range(n):
        y_row = y[r]
        for i in range(k):
            row, vector = rows[i], vectors[i, r]
            for x in range(X):
                row[x] += vector[x] * y_row[x]
    for i in range(k):
        out[i] = 0.0
        for a in range(X // _LANES):
            for q in range(_LANES):
                out[i, q] += rows[i, a * _LANES + q]


@compiled
def _combine(rows: Array, factors: Array, vectors: Array, y: Array) -> None:
    """y (n, X) += sum of factors (k, 8) times vectors (k, n, X), lane by lane."""
    k, n, X = vectors.shape
    for i in range(k):
        for a in range(X // _LANES):
            for q in range(_LANES):
                rows[i, a * _LANES + q] = factors[i, q]
    for r in range(n):
        y_row = y[r]
        for i in range(k):
            row, vector = rows[i], vectors[i, r]
            for x in range(X):
                y_row[x] += row[x] * vector[x]


@compiled
def _stretch(rows: Array, factor: Array, values: Array, out: Array) -> None:
    """out (n, X) = factor (8,) times values, lane by lane."""
    row = rows[0]
    for a in range(row.size // _LANES):
        for q in range(_LANES):
            row[a * _LANES + q] = factor[q]
    for r in range(values.shape[0]):
        for x in range(row.size):
            out[r, x] = row[x] * values[r, x]


@compiled
def _residual(operators: CondensedOperators, space: Workspace, first: Array, y: Array, norm: Array) -> Array:
    """first - A y (n, X), and its size (8,)."""
    out = np.empty_like(y)
    _apply(operators, space, y, out)
    for r in range(y.shape[0]):
        for x in range(y.shape[1]):
            out[r, x] = first[r, x] - out[r, x]
    norm[:] = 0.0
    for r in range(y.shape[0]):
        for a in range(y.shape[1] // _LANES):
            for q in range(_LANES):
                norm[q] += out[r, a * _LANES + q] ** 2
    for q in range(_LANES):
        norm[q] = np.sqrt(norm[q])
    return out


@compiled
def _scale(first: Array, norm: Array, q: int, J: int, mean: bool) -> float:
    """Size of the dynamic part of lane q, as `balance._scale`: first (n, X), norm (8,)."""
    total, mean_part = 0.0, 0.0
    for r in range(first.shape[0]):
        for a in range(2 * J):
            total += first[r, a * _LANES + q] ** 2
        if mean:
            mean_part += first[r, q] ** 2
    size = np.sqrt(max(max(total - mean_part, 0.0) + norm[q] * norm[q], 1e-12 * total))
    return 1.0 if size == 0 else size


@compiled
def _gmres(
    operators: CondensedOperators,
    space: Workspace,
    single: CondensedOperators,
    single_space: Workspace,
    first: Array,
    y: Array,
    residual: Array,
    norm: Array,
    target: Array,
) -> int:
    """Improve y (n, X) until the true residual norms (8,) reach their targets (8,) or stall; returns operator calls."""
    calls, active, better, last = 1, norm > target, np.empty(_LANES, np.bool_), np.empty(_LANES)
    for _ in range(_RESTARTS):
        if not active.any():
            break
        trial = y.copy()
        calls += 1 + _cycle(single, single_space, residual, norm, np.maximum(target, 2 * _GAIN * norm), active, trial)
        left = _residual(operators, space, first, trial, last)
        for q in range(_LANES):
            # a singular point may come out worse than it went in: keep what it had (not finite is kept, to be seen)
            if active[q] and not last[q] >= norm[q]:
                active[q] = last[q] > target[q] and last[q] < 0.9 * norm[q]
                norm[q] = last[q]
                better[q] = True
            else:
                active[q], better[q] = False, False
        _take(better, trial, y)
        _take(better, left, residual)
    return calls


@compiled
def _take(which: NDArray[np.bool_], values: Array, out: Array) -> None:
    """Copy the lanes `which` (8,) of (n, X)."""
    for r in range(out.shape[0]):
        for a in range(out.shape[1] // _LANES):
            for q in range(_LANES):
                if which[q]:
                    out[r, a * _LANES + q] = values[r, a * _LANES + q]


@compiled
def _cycle(
    operators: CondensedOperators,
    space: Workspace,
    residual: Array,
    norm: Array,
    target: Array,
    active: NDArray[np.bool_],
    y: Array,
) -> int:
    """One Arnoldi cycle with classical Gram-Schmidt from a residual (n, X), its step added to y; returns operator
    calls.
    """
    V, g, along, used, one = space.vectors, space.projected, space.along, space.used, np.empty(_LANES)
    for q in range(_LANES):
        one[q] = 1 / max(norm[q], _TINY) if active[q] else 0.0
        g[0, q], used[q] = norm[q] if active[q] else 0.0, 0
    _stretch(space.rows, one, residual, V[0])
    k, going = 0, True
    while k < _BASIS and going:
        new = V[k + 1]
        _apply(operators, space, V[k], new)
        _products(space.rows, V[: k + 1], new, along)
        _combine(space.rows, -along[: k + 1], V[: k + 1], new)
        _products(space.rows, V[k + 1 : k + 2], new, along[k + 1 :])
        going = False
        for q in range(_LANES):
            below = np.sqrt(along[k + 1, q])
            one[q] = 1 / max(below, _TINY)
            _rotate(space, k, q, below)
            if active[q] and used[q] == 0:
                if abs(g[k + 1, q]) > 0.5 * target[q] and k + 1 < _BASIS:
                    going = True
                else:
                    used[q] = k + 1
        _stretch(space.rows, one, new, new)
        k += 1
    _back(space, k)
    _combine(space.rows, along[:k], V[:k], y)
    return k


@compiled
def _back(space: Workspace, k: int) -> None:
    """Factors of the first k vectors into `along`: triangle of each lane solved with the vectors that lane used."""
    R, g, along = space.triangle, space.projected, space.along
    along[:k] = 0.0
    for q in range(_LANES):
        for i in range(space.used[q] - 1, -1, -1):
            rest = g[i, q]
            for j in range(i + 1, space.used[q]):
                rest -= R[i, j, q] * along[j, q]
            along[i, q] = rest / (1.0 if R[i, i, q] == 0 else R[i, i, q])


@compiled
def _rotate(space: Workspace, k: int, q: int, below: float) -> None:
    """Column k of the triangle of lane q by Givens rotations, and its right side with it; below : subdiagonal."""
    R, turn, g = space.triangle, space.rotations, space.projected
    for i in range(k + 1):
        R[i, k, q] = space.along[i, q]
    for i in range(k):
        upper, lower = R[i, k, q], R[i + 1, k, q]
        R[i, k, q] = turn[0, i, q] * upper + turn[1, i, q] * lower
        R[i + 1, k, q] = turn[0, i, q] * lower - turn[1, i, q] * upper
    length = max(np.hypot(R[k, k, q], below), _TINY)
    turn[0, k, q], turn[1, k, q] = R[k, k, q] / length, below / length
    R[k, k, q] = length
    g[k + 1, q], g[k, q] = -turn[1, k, q] * g[k, q], turn[0, k, q] * g[k, q]


@compiled
def truncation_size(operators: CondensedOperators, truncated_frequency: Array, gap: Array) -> Array:
    """Size of the response to forces on the truncated harmonics (P,), as `balance._truncation_residual`.

    truncated_frequency : (P, T) [rad/s].  gap : (m, P, 2 J) [m].
    """
    m, P, J2 = gap.shape
    T, n = truncated_frequency.shape[1], operators.squared.size
    result, forces, pulled = np.zeros(P), np.empty((m, 2 * T)), np.empty((n, 2 * T))
    pull = np.ascontiguousarray(operators.push[:, :m])
    for p in range(P):
        forces[:] = 0.0
        for k in range(m):
            for a in range(J2):
                for t in range(2 * T):
                    forces[k, t] += gap[k, p, a] * operators.tail[k, a, t]
        np.dot(pull, forces, pulled)
        total = 0.0
        for r in range(n):
            for t in range(T):
                w = truncated_frequency[p, t]
                real, imag = operators.squared[r] - w * w, w * operators.damping[r]
                size = real * real + imag * imag
                if size != 0:
                    total += (pulled[r, t] ** 2 + pulled[r, T + t] ** 2) / size
        result[p] = np.sqrt(total)
    return result
