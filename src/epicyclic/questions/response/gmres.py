"""GMRES [saad1986], and the refinement of a response near a resonance of light damping as far as numbers allow.

Many linear systems are solved at once: one array, one operator call an iteration.  One system alone has a form of its
own: its arrays are so small that calls of NumPy are what it costs.

A residual r of the balance A y = b is an error A^-1 r, which a sharp resonance amplifies.  The amplification is found
by solving for a unit force on the coordinates that are near resonance.  Besides r, double precision itself perturbs A:
a natural frequency is known to about eps max(omega^2), so that a resonance narrower than that has no number.
Derived here.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from ..modes.eigen import Modal

_TINY = 1e-300
# Least |D| of the preconditioner, per omega_r^2.  At a resonance of the mean system without damping D is 0 although the
# varying stiffness and the gyroscopic terms leave the system regular: 1/D would make the right side, and with it the
# scale of residuals, as large as one likes.  D stays above this from a damping ratio of 5e-5 on.
FLOOR = 1e-4
# Damping ratio below which a resonance is asked: above, it amplifies a residual less than 5000 times, and the
# tolerances hold.
_LIGHT = 1e-4
# Distance from a natural frequency, of omega^2, below which a harmonic may be resonant: gyroscopic and varying terms
# shift the resonances of the mean system by a few per cent.
_NEAR = 0.1
# Residual of the solution for the amplification: its size is wanted, not its digits.
_PROBE = 1e-2
# Refinements at most; each gains at least three digits or none.
_ROUNDS = 3


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
        known, w = V[: k + 1].transpose(1, 0, 2), apply(V[k])
        along = np.matmul(known, w[:, :, None])[:, :, 0]
        w = w - np.matmul(along[:, None, :], known)[:, 0]
        left = _norm(w)
        V[k + 1] = w / np.maximum(left, _TINY)[:, None]
        rotated = np.matmul(Q[:, : k + 1, : k + 1], along[:, :, None])[:, :, 0]
        R[:, :k, k] = rotated[:, :k]
        R[:, k, k] = _rotate(Q, g, k, rotated[:, k], left)
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


def near_sharp_resonance(modal: Modal, frequency: Array) -> NDArray[np.bool_]:
    """Points (P,) with a harmonic near the natural frequency of a mode of light damping.

    frequency : (P, J) [rad/s].
    """
    light = _lightly_damped(modal)
    if not np.any(light):
        return np.zeros(len(frequency), dtype=bool)
    squared = modal.squared[light]
    near: NDArray[np.bool_] = np.any(np.abs(squared - frequency[:, :, None] ** 2) < _NEAR * squared, axis=(1, 2))
    return near


def sharpened(
    modal: Modal,
    rows: Callable[[Array], Array],
    right: Array,
    y: Array,
    frequency: Array,
    *,
    mean: bool,
    tolerance: float,
) -> tuple[Array, float, float]:
    """Solution of one point refined until its error is below the tolerance, or as far as double precision goes.

    Parameters
    ----------
    rows : (1, 2 J n) -> (1, 2 J n), the preconditioned operator.  right : (1, 2 J n), its right side.
    y : (1, 2, J, n) solution so far.  frequency : (J,) [rad/s].  mean : whether harmonic 0 is a mean.
    tolerance : error wanted, relative to the dynamic part [1].

    Returns
    -------
    (y (1, 2, J, n), norm of its residual, bound of its relative error; inf where the resonance cannot be resolved).
    """
    shape, y = y.shape, y.reshape(1, -1)
    amplification, noise = _amplification(modal, rows, frequency)
    dynamic, left = 1.0, np.inf
    for _ in range(_ROUNDS + 1):
        residual = right - rows(y)
        left = float(np.linalg.norm(residual))
        moving = y.reshape(shape)[:, :, 1:] if mean else y
        dynamic = float(np.linalg.norm(moving)) or 1.0
        wanted = tolerance * dynamic / amplification
        if left <= wanted or not np.isfinite(amplification):
            break
        step, rest, _ = gmres(rows, residual, target=np.array([0.5 * wanted]))
        if not rest[0] < left:
            break
        y = y + step
    error = amplification * (left / dynamic + noise)
    return y.reshape(shape), left, error if np.isfinite(error) else np.inf


def _amplification(modal: Modal, rows: Callable[[Array], Array], frequency: Array) -> tuple[float, float]:
    """Largest error per residual [1], and the part of y that rounding of natural frequencies leaves as a residual [1].

    inf where the resonance is narrower than rounding.
    """
    distance = np.abs(modal.squared - frequency[:, None] ** 2)
    near = (distance < _NEAR * modal.squared) & _lightly_damped(modal)
    # the signs are fixed and without pattern, so that the unit forces do not cancel along a resonant motion
    signs = np.random.default_rng(1).choice([-1.0, 1.0], size=(2, *near.shape))
    force = np.where(near, signs, 0.0).reshape(1, -1)
    answer, left, _ = gmres(rows, force, target=np.array([_PROBE]))
    # rounding of omega^2 against the least that P, floored, can be
    least = np.min(np.where(near, np.maximum(distance, FLOOR * modal.squared), np.inf))
    noise = np.finfo(float).eps * float(modal.squared.max(initial=0.0)) / float(least)
    if not left[0] <= _PROBE:
        return np.inf, noise
    return max(1.0, float(np.linalg.norm(answer))), noise


def _lightly_damped(modal: Modal) -> NDArray[np.bool_]:
    """Elastic modes (n,) whose damping ratio is so small that their resonance is asked."""
    light: NDArray[np.bool_] = (modal.damping**2 < 4 * _LIGHT**2 * modal.squared) & ~modal.rigid
    return light
