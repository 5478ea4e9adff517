"""GMRES on many linear systems at once: one array, one operator call an iteration [saad1986].

One system alone has a form of its own: its arrays are so small that calls of NumPy are what it costs.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot

import numpy as np

from ...system.system import Array

__all__ = ["gmres", "gmres_of_one"]

_TINY = 1e-300


def gmres(
    apply: Callable[[Array], Array], right: Array, *, target: Array, basis: int = 60, restarts: int = 6
) -> tuple[Array, Array, int]:
    """Solve A_p x_p = b_p for every p, from x = 0, until |b_p - A_p x_p| <= target_p, by restarted GMRES [saad1986].

    Parameters
    ----------
    apply : (P, N) -> (P, N), the operator of every system; it must not mix systems.
    right : (P, N), in the precision to work in.  target : (P,) absolute residual wanted, in the unit of `right`.
    basis : vectors before a restart.  restarts : largest number of cycles.

    Returns
    -------
    (x (P, N), true residual norm (P,), operator calls).  A system whose numbers are not finite ends with a
    residual that is not finite and leaves the others unchanged.
    """
    x = np.zeros_like(right)
    residual, norm = right, _norm(right)
    calls = 0
    for _ in range(restarts):
        if not np.any(norm > target):
            break
        step, used = _cycle(apply, residual, norm, target=target, basis=basis)
        trial = x + step
        left = right - apply(trial)
        calls += used + 1
        last, new = norm, _norm(left)
        # a singular system may come out worse than it went in: keep what it had (not finite is kept, to be seen)
        worse = (new >= last)[:, None]
        x, residual, norm = np.where(worse, x, trial), np.where(worse, residual, left), np.where(new >= last, last, new)
        if not np.any((norm > target) & (norm < 0.9 * last)):
            break
    return x, norm, calls


def _cycle(
    apply: Callable[[Array], Array], residual: Array, norm: Array, *, target: Array, basis: int
) -> tuple[Array, int]:
    """One Arnoldi cycle with classical Gram-Schmidt from a residual (P, N) of given norm (P,).

    The rotations are kept as one small orthogonal matrix a system.  Returns (step (P, N), vectors used).
    """
    P, N = residual.shape
    V = np.empty((basis + 1, P, N), residual.dtype)
    V[0] = residual / np.maximum(norm, _TINY)[:, None]
    R = np.zeros((P, basis, basis))
    Q = np.broadcast_to(np.eye(basis + 1), (P, basis + 1, basis + 1)).copy()
    g = np.zeros((P, basis + 1))
    g[:, 0] = norm
    k = 0
    while k < basis:
        h, V[k + 1] = _orthogonal(apply(V[k]), V[: k + 1])
        rotated = np.matmul(Q[:, : k + 1, : k + 1], h[:, : k + 1, None])[:, :, 0]
        R[:, :k, k] = rotated[:, :k]
        R[:, k, k] = _rotate(Q, g, k, rotated[:, k], h[:, k + 1])
        k += 1
        if not np.any(np.abs(g[:, k]) > 0.5 * target):
            break
    return _combine(V[:k], R[:, :k, :k], g[:, :k]), k


def gmres_of_one(
    apply: Callable[[Array], Array], right: Array, *, target: float, basis: int = 60, restarts: int = 6
) -> tuple[Array, float, int]:
    """Solve A x = b (N,), from x = 0, until |b - A x| <= target: `gmres` for one system.

    Parameters
    ----------
    apply : (N,) -> (N,).  right, target, basis, restarts : as of `gmres`.

    Returns
    -------
    (x (N,), true residual norm, operator calls); not finite where the numbers of the system are not.
    """
    x, residual, norm, calls = np.zeros_like(right), right, _length(right), 0
    for _ in range(restarts):
        if not norm > target:
            break
        step, used = _cycle_of_one(apply, residual, norm, target=target, basis=basis)
        trial = x + step
        left = right - apply(trial)
        calls += used + 1
        last, new = norm, _length(left)
        if not new >= last:
            x, residual, norm = trial, left, new
        if not target < norm < 0.9 * last:
            break
    return x, norm, calls


def _cycle_of_one(
    apply: Callable[[Array], Array], residual: Array, norm: float, *, target: float, basis: int
) -> tuple[Array, int]:
    """One Arnoldi cycle with classical Gram-Schmidt from a residual (N,): step (N,) and vectors used."""
    V = np.empty((basis + 1, residual.size))
    V[0] = residual / max(norm, _TINY)
    R, g = np.zeros((basis, basis)), np.zeros(basis + 1)
    rotations, last, k = list[tuple[float, float]](), norm, 0
    while k < basis:
        w = apply(V[k])
        known = V[: k + 1]
        along = known @ w
        w = w - along @ known
        left = _length(w)
        np.divide(w, max(left, _TINY), out=V[k + 1])
        column: list[float] = along.tolist()
        for i, (c, s) in enumerate(rotations):
            column[i], column[i + 1] = c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]
        length = max(hypot(column[k], left), _TINY)
        c, s = column[k] / length, left / length
        rotations.append((c, s))
        column[k], g[k], last = length, c * last, -s * last
        R[: k + 1, k] = column
        k += 1
        if not abs(last) > 0.5 * target:
            break
    y = np.zeros(k)
    for i in reversed(range(k)):
        y[i] = (g[i] - R[i, i + 1 : k] @ y[i + 1 :]) / (R[i, i] or 1.0)
    return y @ V[:k], k


def _length(x: Array) -> float:
    """Euclidean norm of x (N,)."""
    return float(np.sqrt(x @ x))


def _orthogonal(w: Array, V: Array) -> tuple[Array, Array]:
    """Components of w (P, N) along V (k, P, N) with the remaining norm appended, (P, k + 1), and the new unit vector
    (P, N).
    """
    basis = V.transpose(1, 0, 2)
    along = np.matmul(basis, w[:, :, None])[:, :, 0]
    w = w - np.matmul(along[:, None, :], basis)[:, 0]
    left = _norm(w)
    return np.concatenate([along, left[:, None]], axis=1), w / np.maximum(left, _TINY)[:, None]


def _rotate(Q: Array, g: Array, k: int, diagonal: Array, below: Array) -> Array:
    """Rotate `below` (P,) into the diagonal by a Givens rotation, in Q and g too; returns the new diagonal (P,)."""
    length = np.maximum(np.hypot(diagonal, below), _TINY)
    c, s = diagonal / length, below / length
    upper = Q[:, k, : k + 2].copy()
    Q[:, k, : k + 2] = c[:, None] * upper + s[:, None] * Q[:, k + 1, : k + 2]
    Q[:, k + 1, : k + 2] = c[:, None] * Q[:, k + 1, : k + 2] - s[:, None] * upper
    g[:, k + 1] = -s * g[:, k]
    g[:, k] = c * g[:, k]
    return length


def _combine(V: Array, R: Array, g: Array) -> Array:
    """V (k, P, N) times the solution of R y = g, R (P, k, k) upper triangular and g (P, k): (P, N)."""
    y = np.zeros_like(g)
    for i in reversed(range(g.shape[1])):
        rest = g[:, i] - np.sum(R[:, i, i + 1 :] * y[:, i + 1 :], axis=1)
        y[:, i] = rest / np.where(R[:, i, i] == 0, 1.0, R[:, i, i])
    step: Array = np.matmul(y[:, None, :].astype(V.dtype), V.transpose(1, 0, 2))[:, 0]
    return step


def _norm(x: Array) -> Array:
    """Euclidean norm of every row, (P, N) to (P,)."""
    norm: Array = np.sqrt(np.einsum("pn,pn->p", x, x))
    return norm
