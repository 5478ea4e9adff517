"""Unilateral contact of segments that share a compliance: exact, many phases at once.

Segments i carry forces P_i >= 0 with an own approach u_i(P_i) and a shared compliance C:

    u + C P + g - d = 0 where P > 0,   g + C P - d >= 0 where P = 0,   sum P = F

with either F or d given: the minimum of a convex energy, hence a unique solution.  A linear law is solved by active
sets: with the right sides 1 and g, segments in tension leave the set and segments that overlap enter it; where the sets
cycle, principal pivoting exchanges one segment at a time.  A Hertzian law is solved by Newton's method for
the approach u of every segment, whose load P(u+) is smooth; scaling by D^1/2 keeps the matrix symmetric.  Derived here.

Principal pivoting follows linear contact one segment at a time as the approach rises, exactly over any range of loads:

    w = C P + g - d >= 0,   P >= 0,   w P = 0

is a linear complementarity problem with the parameter d (derived here).  Of every segment either P or w is zero, the
nonbasic one.  The basic ones are linear in d; where one would turn negative it is exchanged by one pivot of the table.
Forces and load are piecewise linear in d, so that one pass reaches every load.

The matrices of a mesh cycle are symmetric and positive definite, several phases may share one, and all together are
hundreds of megabytes.  They are taken a few at a time, so that what is made of them stays in the cache, and factorised
by Cholesky's method, which reads one triangle and takes half the operations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotrs

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.int64]
Law = Callable[[Array, Index], tuple[Array, Array]]
"""Own approach u (t, n) [m] at phases (t,) -> force (t, n) [N] and its slope (t, n) [N/m]; zero where u <= 0."""

# Matrix entries at work at once: 1 MB, a share of the cache of one core.
_ENTRIES = 131_072
# Share of the rows of a large matrix below which the rows that count are gathered, which costs a copy.
_FEW = 0.95
# Most changes of the active set, Newton steps, and halvings of one of these.
_SWEEPS, _STEPS, _HALVINGS = 40, 60, 30
# Force sums and gaps, relative to the load and to the approach.
_TOLERANCE = 1e-12
# Steps after another that leave this share of a residual, itself above that of rounding, until a phase is given up:
# its law bears no more, each further step costs all halvings.
_STALLED, _SLOW, _FAR = 6, 0.999, 1e-6
_FAILED = 1e-8  # a larger residual exceeds the rounding of the worst conditioned compliance: not converged


# products and systems with many matrices -----------------------------------------------------------------------------


def taken(index: Index, n: int) -> Iterator[tuple[slice, Index]]:
    """Parts of an index (t,) of matrices (n, n) that are worked on at once, with their place among the t."""
    size = max(1, _ENTRIES // max(n * n, 1))
    for first in range(0, len(index), size):
        at = slice(first, first + size)
        yield at, index[at]


def products(matrix: Array, index: Index, vector: Array) -> Array:
    """Products (t, n) of the matrices (P, n, n) of an index (t,) with vectors (t, n)."""
    product = np.empty_like(vector)
    for at, part in taken(index, matrix.shape[1]):
        if len(part) == 1:
            np.dot(matrix[part[0]], vector[at.start], out=product[at.start])
        else:
            product[at] = np.matmul(matrix[part], vector[at, :, None])[:, :, 0]
    return product


def solved(matrix: Array, right: Array) -> Array:
    """Solutions (t, n, k) of matrices (t, n, n) that are symmetric and positive definite; `matrix` is overwritten.

    A matrix that rounding leaves indefinite is solved by Gauss's method.
    """
    solution = np.empty_like(right)
    diagonal = matrix.reshape(len(matrix), -1)[:, :: matrix.shape[1] + 1].copy()
    for i, single in enumerate(matrix):
        factor, info = dpotrf(single.T, lower=1, clean=0, overwrite_a=1)
        if info == 0:
            solution[i] = dpotrs(factor, right[i], lower=1)[0]
            continue
        # the factor has taken the place of one triangle and of the diagonal
        whole = np.tril(single, -1)
        solution[i] = np.linalg.solve(whole + whole.T + np.diag(diagonal[i]), right[i])
    return solution


def scaled_solution(matrix: Array, index: Index, root: Array, right: Array) -> Array:
    """Solutions (t, n, k) of (1 + D^1/2 C D^1/2) x = right, C the matrices (P, n, n) of an index (t,).

    root : (t, n) D^1/2; where it is zero the solution is the right side.  right : (t, n, k).
    """
    n = matrix.shape[1]
    solution = np.empty_like(right)
    for at, part in taken(index, n):
        if len(part) == 1:
            i = at.start
            solution[i] = _one_solution(matrix[part[0]], root[i], right[i])
            continue
        whole = matrix[part]
        whole *= root[at, :, None]
        whole *= root[at, None, :]
        whole.reshape(len(part), -1)[:, :: n + 1] += 1.0
        solution[at] = solved(whole, right[at])
    return solution


def _one_solution(matrix: Array, root: Array, right: Array) -> Array:
    """As `scaled_solution` of one matrix (n, n), without the rows that are not loaded."""
    on = np.flatnonzero(root)
    if len(on) > _FEW * len(root):
        whole = matrix * root
        whole *= root[:, None]
        whole.reshape(-1)[:: len(root) + 1] += 1.0
        return np.asarray(solved(whole[None], right[None])[0])
    solution = right.copy()
    if len(on):
        part = matrix[np.ix_(on, on)]
        part *= root[on]
        part *= root[on, None]
        part.reshape(-1)[:: len(on) + 1] += 1.0
        solution[on] = solved(part[None], right[None, on])[0]
    return solution


# principal pivoting --------------------------------------------------------------------------------------------------


def principal_pivoting(compliance: Array, gap: Array, loads: Array, approaches: Array) -> tuple[Array, Array]:
    """Linear contact of n segments at L loads or approaches in rising order.

    Parameters
    ----------
    compliance : (n, n) C, symmetric positive definite [m/N].  gap : (n,) g [m].
    loads : (L,) [N], nan where the approach is given.  approaches : (L,) d [m].

    Returns
    -------
    Forces (L, n) [N] and approaches (L,) [m].
    """
    n, count = len(gap), len(loads)
    # basic variable i = table[i] . nonbasic + level[i] + rate[i] d
    table, level, rate = compliance.copy(), gap.copy(), -np.ones(n)
    pressed = np.zeros(n, dtype=np.bool_)
    force, approach = np.zeros((count, n)), np.zeros(count)
    at, done = -np.inf, 0
    for _ in range(20 * n + 1):
        first, following = -1, np.inf
        for i in range(n):
            if rate[i] < 0.0 and -level[i] / rate[i] < following:
                first, following = i, -level[i] / rate[i]
        following = max(following, at)
        base, slope = 0.0, 0.0
        for i in range(n):
            if pressed[i]:
                base, slope = base + level[i], slope + rate[i]
        while done < count:
            wanted = approaches[done]
            if not np.isnan(loads[done]):
                wanted = (loads[done] - base) / slope if slope > 0 else (following if loads[done] <= 0 else np.inf)
            if wanted > following:
                break
            approach[done] = wanted
            for i in range(n):
                if pressed[i]:
                    force[done, i] = max(level[i] + rate[i] * wanted, 0.0)
            done += 1
        if done == count or first < 0:
            break
        at = following
        # exchange P and w of the segment whose basic variable reaches zero
        pivot = table[first, first]
        row = table[first] / pivot
        column = table[:, first].copy()
        for i in range(n):
            if i != first:
                table[i] -= column[i] * row
                level[i] -= column[i] * level[first] / pivot
                rate[i] -= column[i] * rate[first] / pivot
        table[:, first] = column / pivot
        table[first] = -row
        table[first, first] = 1.0 / pivot
        level[first], rate[first] = -level[first] / pivot, -rate[first] / pivot
        pressed[first] = not pressed[first]
    return force, approach


# active sets ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactSolution:
    """Contact at T phases of n segments.

    force : (T, n) [N].  approach : (T,) d [m].  active : (T, n) segments in contact.
    residual : (T,) largest violation: gap over the approach, force over the load.  status : (T,) "" where solved.
    """

    force: Array
    approach: Array
    active: Mask
    residual: Array
    status: NDArray[np.object_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Matrices:
    """Linear compliances of T phases: the shared ones (P, n, n) at places `phase` (T,), and own ones (T, n) or None."""

    shared: Array
    phase: Index
    own: Array | None

    def whole(self, t: int) -> Array:
        """Compliance of one phase (n, n) [m/N]."""
        matrix = self.shared[self.phase[t]]
        return np.asarray(matrix if self.own is None else matrix + np.diag(self.own[t]))

    def opened(self, index: Index, force: Array) -> Array:
        """Deflections (t, n) [m] under forces (t, n) [N] at phases (t,)."""
        shared = products(self.shared, self.phase[index], force)
        return shared if self.own is None else shared + self.own[index] * force


def solve_linear(
    compliance: Array,
    gap: Array,
    valid: Mask,
    load: Array | None,
    *,
    approach: Array | None = None,
    own: Array | None = None,
    phase: Index | None = None,
) -> ContactSolution:
    """Contact with a linear compliance, own and shared together, by active sets.

    Parameters
    ----------
    compliance : (T, n, n) [m/N], symmetric positive definite on the valid segments.  gap : (T, n) g [m].
    valid : (T, n) segments that exist in a phase.  load : (T,) F >= 0 [N], or None and approach : (T,) d [m].
    own : (T, n) compliance of every segment beside the shared one [m/N]; None: it is in `compliance`.
    phase : (T,) places of the matrices in `compliance` (P, n, n), which several T may share; None: each its own.
    """
    load, d = _load_or_approach(len(gap), load, approach)
    T, n = gap.shape
    matrices = _Matrices(shared=compliance, phase=np.arange(T) if phase is None else phase, own=own)
    held = np.isnan(load)
    active = valid.copy()
    force = np.zeros((T, n))
    _set_first_touch(gap, valid, load, d)
    todo = np.flatnonzero(valid.any(axis=1) & ~(load <= 0))
    for _ in range(_SWEEPS):
        if not todo.size:
            break
        on = active[todo]
        force[todo], d[todo] = _active_set_solution(
            matrices, todo, gap[todo], on, np.where(held[todo], np.nan, load[todo]), d[todo]
        )
        # segments of the set in tension leave it, segments beside it that overlap enter
        apart = matrices.opened(todo, np.maximum(force[todo], 0.0)) + gap[todo] - d[todo][:, None]
        slack = _TOLERANCE * np.maximum(np.abs(d[todo]), np.abs(gap[todo]).max(axis=1))[:, None]
        pulls, overlaps = on & (force[todo] < 0), valid[todo] & ~on & (apart < -slack)
        changed = (on & ~pulls) | overlaps
        active[todo] = changed
        todo = todo[(changed != on).any(axis=1) & (changed.any(axis=1) | held[todo])]
    for t in todo:  # the sets cycle: one segment at a time, from first touch on
        have = np.flatnonzero(valid[t])
        pivoted = principal_pivoting(
            matrices.whole(int(t))[np.ix_(have, have)], gap[t, have], load[t : t + 1], d[t : t + 1]
        )
        force[t] = 0.0
        force[t, have], d[t] = pivoted[0][0], pivoted[1][0]
    pressed = None if own is None else own * force
    return with_residuals(compliance, gap, valid, load, force, d, own=pressed, phase=phase)


def _load_or_approach(count: int, load: Array | None, approach: Array | None) -> tuple[Array, Array]:
    """Loads, nan where the approach is given, and approaches, nan where the load is; (T,) each."""
    nothing = np.full(count, np.nan)
    return (
        nothing if load is None else np.array(np.broadcast_to(load, (count,)), dtype=float),
        nothing.copy() if approach is None else np.array(np.broadcast_to(approach, (count,)), dtype=float),
    )


def _set_first_touch(gap: Array, valid: Mask, load: Array, d: Array) -> None:
    """Set the approach d (T,) [m] of phases without load to that of first touch, in place."""
    idle = load <= 0
    d[idle] = np.where(valid[idle], gap[idle], np.inf).min(axis=1, initial=np.inf)


def _active_set_solution(
    matrices: _Matrices, index: Index, gap: Array, on: Mask, load: Array, d: Array
) -> tuple[Array, Array]:
    """Forces (t, n) [N] on the active set, tension included, and approach (t,) [m], at phases (t,)."""
    n = on.shape[1]
    right = np.stack([on.astype(float), np.where(on, gap, 0.0)], axis=2)
    solution = np.empty_like(right)
    for at, part in taken(index, n):
        matrix = np.where(on[at, :, None] & on[at, None, :], matrices.shared[matrices.phase[part]], 0.0)
        own = 0.0 if matrices.own is None else matrices.own[part]
        matrix.reshape(len(part), -1)[:, :: n + 1] += np.where(on[at], own, 1.0)
        solution[at] = solved(matrix, right[at])
    unit, held = np.moveaxis(solution, 2, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        whole = (load + held.sum(axis=1)) / unit.sum(axis=1)
    d = np.where(np.isnan(load), d, whole)
    return np.where(on, unit * d[:, None] - held, 0.0), d


# Newton's method -----------------------------------------------------------------------------------------------------


def solve_hertzian(
    compliance: Array,
    gap: Array,
    valid: Mask,
    load: Array | None,
    law: Law,
    *,
    approach: Array | None = None,
    start: Array | None = None,
    inverse: Callable[[Array], Array] | None = None,
    phase: Index | None = None,
) -> ContactSolution:
    """Contact with a load-dependent law of every segment beside the shared compliance, by Newton's method.

    Parameters
    ----------
    compliance : (T, n, n) shared [m/N].  gap : (T, n) [m].  valid : (T, n).
    load : (T,) F >= 0 [N], or None and approach : (T,) d [m].
    law : own approach and phases (t,) -> forces and slopes.  start : (T, n) own approaches of a near load or phase.
    inverse : forces (T, n) [N] -> own approaches (T, n) [m] of the law, for the first estimate under a load.
    phase : (T,) places of the matrices in `compliance` (P, n, n), which several T may share; None: each its own.
    """
    load, approaches = _load_or_approach(len(gap), load, approach)
    problem = _Problem(compliance, np.arange(len(gap)) if phase is None else phase, gap, valid, load, law)
    u, d = _first_estimate(problem, approaches, start, inverse)
    todo = np.flatnonzero(valid.any(axis=1) & ~(load <= 0))
    at = _estimate(problem, u[todo], d[todo], todo)
    stalled = np.zeros(len(load), dtype=int)
    for _ in range(_STEPS):
        left = (at.merit > _TOLERANCE) & (stalled[todo] < _STALLED)
        todo = todo[left]
        if not todo.size:
            break
        before = at.take(left)
        at = _newton_step(problem, before, todo)
        u[todo], d[todo] = at.u, at.d
        slow = (at.merit > _FAR) & (at.merit > _SLOW * before.merit)
        stalled[todo] = np.where(slow, stalled[todo] + 1, 0)
    todo = np.flatnonzero((stalled >= _STALLED) | np.isin(np.arange(len(load)), todo))
    _set_first_touch(gap, valid, load, d)
    idle = load <= 0
    u[idle] = d[idle, None] - gap[idle]
    force = np.where(valid & ~idle[:, None], law(u, np.arange(len(load)))[0], 0.0)
    return with_residuals(
        compliance, gap, valid, load, force, d, own=np.where(idle[:, None], 0.0, u), todo=todo, phase=phase
    )


class _Problem(NamedTuple):
    """What `solve_hertzian` is given, the same for all phases: loads (T,) are nan where the approach is given."""

    compliance: Array
    phase: Index
    gap: Array
    valid: Mask
    load: Array
    law: Law


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Estimate:
    """A Newton estimate: u (t, n) and d (t,) [m], slopes (t, n) [N/m], residuals of gaps `miss` (t, n) [m] and of load
    `short` (t,) [N], and their relative size `merit` (t,) [1]."""

    u: Array
    d: Array
    slope: Array
    miss: Array
    short: Array
    merit: Array

    def take(self, keep: Mask) -> _Estimate:
        return _Estimate(**{name: getattr(self, name)[keep] for name in self.__dataclass_fields__})


def _estimate(problem: _Problem, u: Array, d: Array, index: Index) -> _Estimate:
    """Residuals of an estimate u (t, n), d (t,) [m] at the phases `index` (t,)."""
    force, slope = problem.law(u, index)
    on, gap, wanted = problem.valid[index], problem.gap[index], problem.load[index]
    force, slope = np.where(on, force, 0.0), np.where(on, slope, 0.0)
    shared = products(problem.compliance, problem.phase[index], force)
    miss = np.where(on, u + shared + gap - d[:, None], 0.0)
    held = np.isnan(wanted)
    short = np.where(held, 0.0, wanted - force.sum(axis=1))
    size = np.maximum(np.abs(d), np.abs(np.where(on, gap, 0.0)).max(axis=1))
    merit = np.maximum(
        np.abs(miss).max(axis=1) / np.where(size > 0, size, 1.0), np.abs(short) / np.where(held, 1.0, wanted)
    )
    return _Estimate(u=u, d=d, slope=slope, miss=miss, short=short, merit=merit)


def _newton_step(problem: _Problem, at: _Estimate, index: Index) -> _Estimate:
    """Estimate after one Newton step, halved until the residual falls."""
    compliance, phase = problem.compliance, problem.phase[index]
    root = np.sqrt(at.slope)
    right = np.stack([root, root * at.miss], axis=2)
    unit, miss = np.moveaxis(scaled_solution(compliance, phase, root, right), 2, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        dd = (at.short + (root * miss).sum(axis=1)) / (root * unit).sum(axis=1)
    dd = np.where(np.isnan(problem.load[index]), 0.0, dd)
    pressed = root * (unit * dd[:, None] - miss)
    du = np.where(problem.valid[index], dd[:, None] - at.miss - products(compliance, phase, pressed), 0.0)
    factor, waiting = np.ones(len(dd)), np.arange(len(dd))
    for _ in range(_HALVINGS):
        u = at.u[waiting] + factor[waiting, None] * du[waiting]
        d = at.d[waiting] + factor[waiting] * dd[waiting]
        trial = _estimate(problem, u, d, index[waiting])
        accepted = trial.merit <= (1 - 1e-4 * factor[waiting]) * at.merit[waiting]
        if accepted.all() and len(waiting) == len(dd):
            return trial
        waiting = waiting[~accepted]
        if not waiting.size:
            break
        factor[waiting] /= 2
    u, d = at.u + factor[:, None] * du, at.d + factor * dd
    return _estimate(problem, u, d, index)


def _first_estimate(
    problem: _Problem, d: Array, start: Array | None, inverse: Callable[[Array], Array] | None
) -> tuple[Array, Array]:
    """First estimate u (T, n), d (T,) [m]: linear contact with the secant of an evenly shared load."""
    compliance, phase, gap, valid, load, law = problem
    held = np.isnan(load)
    # No segment bears more than the whole load.  An estimate beyond the largest approach of the law, where its force
    # no longer rises, is one that no Newton step leaves.
    most = np.full(gap.shape, np.inf) if inverse is None else inverse(np.broadcast_to(load[:, None], gap.shape))
    if start is not None:
        start = np.fmin(start, most)
        # the approach that belongs to it: mean over the segments, weighted by their forces
        force = np.where(valid, law(start, np.arange(len(start)))[0], 0.0)
        level = start + gap + products(compliance, phase, force)
        weight = np.where(force > 0, force, 0.0) + np.where(valid, 1e-300, 0.0)
        return start, np.where(held, d, (weight * level).sum(axis=1) / weight.sum(axis=1))
    T, n = gap.shape
    way = d[:, None] - gap
    if held.all():  # half of it in the flanks
        return np.where(way > 0, way / 2, way), d
    count = np.maximum(valid.sum(axis=1), 1)
    mean = np.maximum(load, np.finfo(float).tiny) / count
    even = np.broadcast_to(mean[:, None], (T, n))
    assert inverse is not None
    linear = solve_linear(compliance, gap, valid, load, own=inverse(even) / even, phase=phase)
    u = linear.approach[:, None] - gap - products(compliance, phase, linear.force)
    return np.fmin(u, most), linear.approach


# of both laws --------------------------------------------------------------------------------------------------------


def with_residuals(
    compliance: Array,
    gap: Array,
    valid: Mask,
    load: Array,
    force: Array,
    d: Array,
    *,
    own: Array | None = None,
    todo: Index | None = None,
    phase: Index | None = None,
) -> ContactSolution:
    """Solution with the residuals of the contact conditions and a status a phase.

    load : (T,) [N], nan where the approach was given.  force : (T, n) [N].  d : (T,) [m].  own : (T, n) own approaches
    [m]; None: they are in the compliance.  todo : phases that did not converge.  phase : (T,) places of the matrices in
    `compliance`; None: each its own.
    """
    shared = products(compliance, np.arange(len(force)) if phase is None else phase, force)
    level = shared + gap - d[:, None] + (0.0 if own is None else np.maximum(own, 0.0))
    active = valid & (force > 0)
    size = np.maximum(np.abs(d), np.abs(np.where(valid, gap, 0.0)).max(axis=1, initial=0.0))
    size = np.where(size > 0, size, 1.0)
    with np.errstate(invalid="ignore"):
        gaps = np.where(active, np.abs(level), np.where(valid, np.maximum(-level, 0.0), 0.0)).max(axis=1) / size
        sums = np.abs(force.sum(axis=1) - load) / np.where(load > 0, load, 1.0)
        sums = np.where(np.isnan(load), 0.0, sums)
    status = np.full(len(load), "", dtype=object)
    status[[] if todo is None else todo] = "not converged"
    status[~valid.any(axis=1)] = "no tooth in contact"
    status[(force < 0).any(axis=1)] = "not converged"
    status[np.maximum(gaps, sums) > _FAILED] = "not converged"
    return ContactSolution(force=force, approach=d, active=active, residual=np.maximum(gaps, sums), status=status)


def tangent_stiffness(
    compliance: Array, active: Mask, slope: Array | None = None, *, phase: Index | None = None
) -> Array:
    """Tangent stiffness dF/dd of a contact, (T,) [N/m]: 1' C_t^-1 1 over the segments in contact.

    compliance : (T, n, n) [m/N].  active : (T, n).  slope : (T, n) of the own law [N/m]; None where `compliance` is the
    whole compliance.  phase : (T,) places of the matrices in `compliance` (P, n, n); None: each its own.
    """
    index = np.arange(len(active)) if phase is None else phase
    if slope is None:
        matrices = _Matrices(shared=compliance, phase=index, own=None)
        pressed, each = np.ones(len(active)), np.arange(len(active))  # forces under an approach of 1
        unit, _ = _active_set_solution(matrices, each, np.zeros(active.shape), active, np.nan * pressed, pressed)
        return np.asarray(unit.sum(axis=1))
    root = np.sqrt(np.where(active, slope, 0.0))
    solution = scaled_solution(compliance, index, root, root[:, :, None])[:, :, 0]
    return np.asarray((root * solution).sum(axis=1))
