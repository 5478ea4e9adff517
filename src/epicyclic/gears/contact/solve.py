"""Unilateral contact of pieces that share a compliance: exact, many phases at once.

Pieces i bear forces P_i >= 0 with an own approach u_i(P_i) and a shared compliance C:

    u + C P + g - d = 0 where P > 0,   g + C P - d >= 0 where P = 0,   sum P = F

with either F or d given: the least of a convex energy, so there is one answer.  A linear law goes through the active set: solved with the right
sides 1 and g, pieces that pull are taken out, pieces that overlap are taken in.  A Hertzian law is solved for the
approach u of every piece, whose load P(u+) is smooth, by Newton's method: y = D^1/2 keeps the matrix symmetric.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Loaded", "hertzian", "linear", "tangent_stiffness"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.int64]
Law = Callable[[Array, Index], tuple[Array, Array]]
"""Own approach u (t, n) [m] at phases (t,) -> force (t, n) [N] and its slope [N/m]; zero where u <= 0."""

_SWEEPS, _STEPS, _HALVINGS = 200, 60, 30
# Force sums and gaps, relative to the load and to the approach.
_TOLERANCE = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loaded:
    """Contact at T phases of n pieces.

    force : (T, n) [N].  approach : (T,) d [m].  active : (T, n) pieces that bear load.
    residual : (T,) largest violation: gap over the approach, force over the load.  status : (T,) "" where solved.
    """

    force: Array
    approach: Array
    active: Mask
    residual: Array
    status: NDArray[np.object_]


def linear(compliance: Array, gap: Array, valid: Mask, load: Array) -> Loaded:
    """Contact with a linear compliance, own and shared together.

    Parameters
    ----------
    compliance : (T, n, n) [m/N], symmetric positive definite on the valid pieces.  gap : (T, n) g [m].
    valid : (T, n) pieces that exist in a phase.  load : (T,) F >= 0 [N].
    """
    T, n = gap.shape
    eye = np.eye(n)
    active = valid.copy()
    force, d = np.zeros((T, n)), np.full(T, np.nan)
    todo = np.flatnonzero(valid.any(axis=1))
    for _ in range(_SWEEPS):
        if not todo.size:
            break
        on = active[todo]
        matrix = np.where(on[:, :, None] & on[:, None, :], compliance[todo], eye)
        right = np.stack([on.astype(float), np.where(on, gap[todo], 0.0)], axis=2)
        unit, held = np.moveaxis(np.linalg.solve(matrix, right), 2, 0)
        d[todo] = (load[todo] + held.sum(axis=1)) / unit.sum(axis=1)
        found = unit * d[todo, None] - held
        force[todo] = np.where(on, found, 0.0)
        open_ = np.einsum("tij,tj->ti", compliance[todo], force[todo]) + gap[todo] - d[todo, None]
        slack = _TOLERANCE * np.maximum(np.abs(d[todo]), np.abs(gap[todo]).max(axis=1))[:, None]
        pulls = on & (found < 0)
        overlaps = valid[todo] & ~on & (open_ < -slack)
        changed = (on & ~pulls) | overlaps
        active[todo] = changed
        todo = todo[(changed != on).any(axis=1) & changed.any(axis=1)]
    return _judged(compliance, gap, valid, load, force, d, own=None, todo=todo)


def hertzian(
    compliance: Array, gap: Array, valid: Mask, load: Array, law: Law, *, start: Array | None = None
) -> Loaded:
    """Contact with a load-dependent law of every piece beside the shared compliance.

    Parameters
    ----------
    compliance : (T, n, n) shared [m/N].  gap : (T, n) [m].  valid : (T, n).  load : (T,) F >= 0 [N].
    law : own approach and phases (t,) -> forces and slopes.  start : (T, n) own approaches of a near load or phase.
    """
    u, d = _begin(compliance, gap, valid, load, law, start)
    todo = np.flatnonzero(valid.any(axis=1) & (load > 0))
    for _ in range(_STEPS):
        at = _at(compliance, gap, valid, load, law, u[todo], d[todo], todo)
        left = at.merit > _TOLERANCE
        todo = todo[left]
        if not todo.size:
            break
        u[todo], d[todo] = _descended(compliance, gap, valid, load, law, at.take(left), todo)
    idle = np.flatnonzero(load <= 0)
    d[idle] = np.where(valid[idle], gap[idle], np.inf).min(axis=1, initial=np.inf)  # the first piece just touches
    u[idle] = d[idle, None] - gap[idle]
    every = np.arange(len(load))
    force = np.where(valid, law(u, every)[0], 0.0)
    return _judged(compliance, gap, valid, load, force, d, own=u, todo=todo)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Point:
    """An estimate: u (t, n), d (t,), slopes of the law, gaps missed (t, n), load missed (t,), and their size."""

    u: Array
    d: Array
    slope: Array
    miss: Array
    short: Array
    merit: Array

    def take(self, keep: Mask) -> _Point:
        return _Point(**{name: getattr(self, name)[keep] for name in self.__dataclass_fields__})


def _at(compliance: Array, gap: Array, valid: Mask, load: Array, law: Law, u: Array, d: Array, index: Index) -> _Point:
    force, slope = law(u, index)
    on = valid[index]
    force, slope = np.where(on, force, 0.0), np.where(on, slope, 0.0)
    shared = np.matmul(compliance[index], force[:, :, None])[:, :, 0]
    miss = np.where(on, u + shared + gap[index] - d[:, None], 0.0)
    short = load[index] - force.sum(axis=1)
    size = np.maximum(np.abs(d), np.abs(np.where(on, gap[index], 0.0)).max(axis=1))
    merit = np.maximum(np.abs(miss).max(axis=1) / size, np.abs(short) / load[index])
    return _Point(u=u, d=d, slope=slope, miss=miss, short=short, merit=merit)


def _descended(
    compliance: Array, gap: Array, valid: Mask, load: Array, law: Law, at: _Point, index: Index
) -> tuple[Array, Array]:
    """One Newton step, halved until what is missed shrinks."""
    root = np.sqrt(at.slope)
    C = compliance[index]
    matrix = root[:, :, None] * C * root[:, None, :] + np.eye(root.shape[1])
    right = np.stack([root, root * at.miss], axis=2)
    one, miss = np.moveaxis(np.linalg.solve(matrix, right), 2, 0)
    dd = (at.short + (root * miss).sum(axis=1)) / (root * one).sum(axis=1)
    pressed = root * (one * dd[:, None] - miss)
    du = np.where(valid[index], dd[:, None] - at.miss - np.matmul(C, pressed[:, :, None])[:, :, 0], 0.0)
    factor, waiting = np.ones(len(dd)), np.arange(len(dd))
    for _ in range(_HALVINGS):
        u = at.u[waiting] + factor[waiting, None] * du[waiting]
        d = at.d[waiting] + factor[waiting] * dd[waiting]
        trial = _at(compliance, gap, valid, load, law, u, d, index[waiting])
        waiting = waiting[~(trial.merit <= (1 - 1e-4 * factor[waiting]) * at.merit[waiting])]
        if not waiting.size:
            break
        factor[waiting] /= 2
    return at.u + factor[:, None] * du, at.d + factor * dd


def _begin(
    compliance: Array, gap: Array, valid: Mask, load: Array, law: Law, start: Array | None
) -> tuple[Array, Array]:
    """Where to begin: the linear contact whose pieces have the secant of an evenly shared load."""
    if start is not None:
        return start.copy(), _approach_of(compliance, gap, valid, law, start)
    T, n = gap.shape
    count = np.maximum(valid.sum(axis=1), 1)
    even = np.broadcast_to((np.maximum(load, np.finfo(float).tiny) / count)[:, None], (T, n))
    own = _inverse(law, even)
    rows = np.arange(n)
    whole = compliance.copy()
    whole[:, rows, rows] += own / even
    found = linear(whole, gap, valid, load)
    u = found.approach[:, None] - gap - np.matmul(compliance, found.force[:, :, None])[:, :, 0]
    return u, found.approach.copy()


def _approach_of(compliance: Array, gap: Array, valid: Mask, law: Law, u: Array) -> Array:
    force = np.where(valid, law(u, np.arange(len(u)))[0], 0.0)
    level = u + gap + np.matmul(compliance, force[:, :, None])[:, :, 0]
    weight = np.where(force > 0, force, 0.0) + np.where(valid, 1e-300, 0.0)
    result: Array = (weight * level).sum(axis=1) / weight.sum(axis=1)
    return result


def _inverse(law: Law, force: Array) -> Array:
    """Own approach at which the law gives a force, by doubling and halving, (T, n)."""
    index = np.arange(len(force))
    low, high = np.zeros_like(force), np.full_like(force, 1e-9)
    for _ in range(60):
        short = law(high, index)[0] < force
        if not short.any():
            break
        low, high = np.where(short, high, low), np.where(short, 2 * high, high)
    for _ in range(12):  # a start needs three digits
        middle = (low + high) / 2
        short = law(middle, index)[0] < force
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return (low + high) / 2


def _judged(
    compliance: Array, gap: Array, valid: Mask, load: Array, force: Array, d: Array, *, own: Array | None, todo: Index
) -> Loaded:
    """Residuals of what was found, and a word on what was not."""
    shared = np.matmul(compliance, force[:, :, None])[:, :, 0]
    level = shared + gap - d[:, None] + (0.0 if own is None else np.maximum(own, 0.0))
    active = valid & (force > 0)
    size = np.maximum(np.abs(d), np.abs(np.where(valid, gap, 0.0)).max(axis=1, initial=0.0))
    size = np.where(size > 0, size, 1.0)
    with np.errstate(invalid="ignore"):
        gaps = np.where(active, np.abs(level), np.where(valid, np.maximum(-level, 0.0), 0.0)).max(axis=1) / size
        sums = np.abs(force.sum(axis=1) - load) / np.where(load > 0, load, 1.0)
    status = np.full(len(load), "", dtype=object)
    status[todo] = "not converged"
    status[~valid.any(axis=1)] = "no tooth in contact"
    status[(force < 0).any(axis=1)] = "not converged"
    return Loaded(force=force, approach=d, active=active, residual=np.maximum(gaps, sums), status=status)


def tangent_stiffness(compliance: Array, active: Mask, slope: Array | None = None) -> Array:
    """dF/dd at a contact, (T,) [N/m]: 1' C_t^-1 1 over the pieces that bear load.

    slope : (T, n) of the own law [N/m]; None where `compliance` holds everything.
    """
    one = active.astype(float)
    if slope is None:
        matrix = np.where(active[:, :, None] & active[:, None, :], compliance, np.eye(active.shape[1]))
        closed: Array = np.einsum("ti,ti->t", one, np.linalg.solve(matrix, one[:, :, None])[:, :, 0])
        return closed
    root = np.sqrt(np.where(active, slope, 0.0))
    matrix = root[:, :, None] * compliance * root[:, None, :] + np.eye(active.shape[1])
    result: Array = np.einsum("ti,ti->t", root, np.linalg.solve(matrix, root[:, :, None])[:, :, 0])
    return result
