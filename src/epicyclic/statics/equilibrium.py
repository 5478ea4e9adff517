"""Equilibrium under unilateral contact, and the line search on its energy.

Minimum of a convex function along lines, in batches: its slope rises, with kinks at known places.

The root of the slope is bracketed between kinks by bisection over their order, then found by regula falsi with the
Illinois modification [dowell1971].  SciPy's root finders of the oldest supported version take one function at a time;
a batch asks the laws of thousands of instants at once.

Static equilibrium with unilateral meshes and laws: the least energy, by Newton steps with a line search, in batches.

    E(q) = q'Kq/2 - F'q + sum_f Phi_f(B'q - e) + sum_g phi_g(B'q - e)

with Phi_f the energy of a flank and phi_g that of a bearing with play or a spline, all convex (`system.flank_laws`,
`system.link_laws`).  The problem is condensed to the rows B of flanks and groups; derived here.  With H = K + B
diag(k0) B' (all meshes closed, all groups at their nominal stiffness), A = H^+ B, S = B'A and the pull p = k0 w - f of
each row, q = H^+ F + A p, w = B'q, and the residual in row forces is r = p - k0 w + f(w - e).  This holds for any k0 >=
0: far flanks, which are open in the mean, have k0 = 0 and p = -f.

H is never formed.  Its rows W' = [sqrt(k) b'] (`stiffness_rows`), columns scaled and motions that strain no row
left out, are factorised as W' = Q R with q = T c, T = R^-1 and strains sqrt(k) b'q = Q c.  With the rows sorted by
length and columns pivoted, the error of Householder's method is small beside each row, not only beside the largest
[higham2002, sec. 19.4]: forces of meshes are right beside the softest support.

The iteration ends.  A full Newton step stands only where the residual falls to a tenth of the least one of any full
step before, so there are finitely many; all others go to the least energy along a Newton direction, and E is convex
with bounded curvature, so these converge to its minimum [nocedal2006, sec. 3.2].  The balance of every body is checked
at the end with the forces of the rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ..errors import ConvergenceError, ModelError
from ..system.gaps import FlanksAt, linear_flanks
from ..system.link_laws import ContactSetLaw, Laws, stacked
from ..system.system import Array, System, elastic_rows, free_motions
from .record import contradicting_radii, unheld, unheld_error

Slope = Callable[[Array, NDArray[np.int64]], Array]
"""(lengths (t,), instants (t,) of the batch) -> slope at those lengths."""

# Slope at the place found, per slope at the start: a longer search changes the next Newton step by less than that.
_SLOPE_TOLERANCE = 1e-3
# Doublings of an interval without upper end; halvings of one that secants do not close.
_DOUBLINGS, _HALVINGS = 200, 100


def line_minimum(slope: Slope, kinks: Array, start: Array) -> Array:
    """Length (T,) of least value along each line of a batch.

    Between kinks the slope is near linear, so that the secant through two points is exact for a piecewise quadratic.

    Parameters
    ----------
    slope : rising function.  kinks : (T, J) candidate places in any order; only those above zero and finite count.
    start : (T,) slope at zero, negative.

    Raises
    ------
    ConvergenceError : the slope stays negative however far one goes.
    """
    count, J = kinks.shape
    here = np.arange(count, dtype=np.int64)
    places = np.sort(np.where(np.isfinite(kinks) & (kinks > 0), kinks, np.inf), axis=1)
    before, after = np.full(count, -1), np.sum(np.isfinite(places), axis=1)
    low, high = np.zeros(count), np.full(count, np.inf)
    slope_low, slope_high = start.copy(), np.full(count, np.inf)
    for _ in range(J.bit_length() + 1):
        open_ = after - before > 1
        if not open_.any():
            break
        middle = np.clip((before + after) // 2, 0, max(J - 1, 0))
        place = np.where(open_, places[here, middle], low)
        value = slope(place, here)
        falling, rising = open_ & (value <= 0), open_ & (value > 0)
        before, after = np.where(falling, middle, before), np.where(rising, middle, after)
        low, slope_low = np.where(falling, place, low), np.where(falling, value, slope_low)
        high, slope_high = np.where(rising, place, high), np.where(rising, value, slope_high)
    high, slope_high = _bracketed(slope, low, high, slope_high)
    return _regula_falsi(slope, (low, slope_low), (high, slope_high), -_SLOPE_TOLERANCE * start)


def _bracketed(slope: Slope, low: Array, high: Array, slope_high: Array) -> tuple[Array, Array]:
    """Upper ends (T,) of all intervals and the slopes there, which are positive; open intervals are doubled."""
    high, slope_high = high.copy(), slope_high.copy()
    length = np.maximum(low, 1.0)
    for _ in range(_DOUBLINGS):
        endless = np.flatnonzero(~np.isfinite(high)).astype(np.int64)
        if not endless.size:
            return high, slope_high
        place = low[endless] + length[endless]
        value = slope(place, endless)
        rises = value > 0
        high[endless[rises]], slope_high[endless[rises]] = place[rises], value[rises]
        length[endless] *= 2
    raise ConvergenceError("the energy falls without end along a motion; something holds too weakly or not at all")


def _regula_falsi(slope: Slope, lower: tuple[Array, Array], upper: tuple[Array, Array], level: Array) -> Array:
    """A place (T,) inside each interval where the slope is within `level` (T,) of zero.

    Illinois method [dowell1971].
    """
    (low, slope_low), (high, slope_high) = lower, upper
    place = low.copy()
    todo = np.flatnonzero(-slope_low > level).astype(np.int64)
    # an end that stays is given half its slope (Illinois), so that both ends move
    side = np.zeros(len(low), dtype=np.int64)
    for _ in range(_HALVINGS):
        if not todo.size:
            break
        a, b, fa, fb = low[todo], high[todo], slope_low[todo], slope_high[todo]
        trial = a - fa * (b - a) / (fb - fa)
        value = slope(trial, todo)
        place[todo] = trial
        falls = value <= 0
        low[todo[falls]], slope_low[todo[falls]] = trial[falls], value[falls]
        high[todo[~falls]], slope_high[todo[~falls]] = trial[~falls], value[~falls]
        stale = np.where(falls, 1, -1)
        again = stale == side[todo]
        slope_high[todo[again & falls]] /= 2
        slope_low[todo[again & ~falls]] /= 2
        side[todo] = stale
        narrow = high[todo] - low[todo] <= 4 * np.finfo(float).eps * high[todo]
        todo = todo[(np.abs(value) > level[todo]) & ~narrow]
    return place


Values = NDArray[Any]  # real or complex

# Part of a unit motion that is rounding of the null space; 1e-14 is seen.
_NULL_ROUNDING = 1e-10
# Load along a free motion, per the sum of the sizes of its terms; torques that balance do so to rounding.
_BALANCE = 1e-9
# Rounding of a free motion, per the largest load.
_NOISE = 1e-12
# Stiffness an open mesh keeps in the Newton matrix (not in the forces), so that a body whose meshes are all open does
# not make it singular; 1e-12 of a mesh is below any support, so the steps stay Newton steps.
_OPEN = 1e-12
# The same of a group in its clearance.  Less leaves an unloaded body that just touches swinging round its clearance
# with steps so long that the touch itself is not resolved; 1e-3 costs two steps more.
_FLOATING = 1e-6
# Residual of row forces, relative to the largest, to which the iteration goes, and its most steps.
_TOLERANCE, _STEPS = 1e-10, 60
# Rounding of the residual, per row and per its largest term.
_ROUNDING = 1e-15
# Drop of the residual below the least of any full step before that lets one stand without a line search.
_DROP = 0.1
# Stiffness of flanks along a direction, per that of all closed ones, that is rounding.
_FLAT = 1e-12
# Strain of links, per motion, that is rounding: what a direction leaves of flanks in it is `_OPEN` of the motion.
_UNSTRAINED = 1e-9
# Force on a body that may be left, per load.
LEFT = 1e-9
# Arm of the rows of flanks, per the largest, that is rounding: of modes by a text of matrices 1e-8 is seen.
_NO_ARM = 1e-6
# Rounding of the same per pull of the rows, 1.8e-14 is seen, and the part of a light load that it may be.
_PLAY_ROUNDING, _LIGHT = 1e-13, 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Compliance:
    """The train seen from its rows: F flanks, then the R rows of groups (M = F + R together).

    The flanks are the loaded ones of the m meshes, and behind them the far ones where those are asked for.

    stiffness : (M,) k0 [N/m].  rows : (n, M) B.  elastic : (n, R) sqrt(k) b of what K holds [sqrt(N/m)].
    motion : (n, h) T with q = T c, c [sqrt(N m)] of the h motions that are held.  gap : (M, h) B'T.
    strain : (R, h) Q of what K holds.  free : (n, r) unit motions that strain no row.
    scale : (n,) that gives H a unit diagonal [m/sqrt(N m)].
    inverse : (n, n) H^+ [m/N].  to_body : (n, M) A [m/N].  to_mesh : (M, M) S [m/N].  gap_of_force : (M, n) B'H^+
        [m/N].  elastic_pull : (M, M) S - S diag(k0) S, twice the energy of K per pulls [m/N].
    """

    stiffness: Array
    rows: Array
    elastic: Array
    motion: Array
    gap: Array
    strain: Array
    free: Array
    scale: Array
    inverse: Array
    to_body: Array
    to_mesh: Array
    gap_of_force: Array
    elastic_pull: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Equilibrium:
    """Static state at T instants.

    displacement : (T, n) [m, rad], without any part along free motions.
    mesh_force : (T, m) of the loaded flanks [N], >= 0.
    far_force : (T, c) of the far flanks, c = 0 where they are left out [N], >= 0.
    iterations : (T,) Newton steps.
    group_stretch, group_force : (T, R) of the rows of groups [m], [N].
    approach : (T, M) B'q of all flanks and the rows of groups [m].
    """

    displacement: Array
    mesh_force: Array
    far_force: Array
    iterations: np.ndarray
    group_stretch: Array
    group_force: Array
    approach: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Rows:
    """Laws of the rows at T instants: F flanks, errors (T, M) [m], laws and sliders (T, R) [m] of groups."""

    flanks: FlanksAt
    gap: Array
    laws: Laws
    anchor: Array | None

    def at(self, chosen: np.ndarray) -> _Rows:
        """The same at the instants `chosen` (t,)."""
        anchor = None if self.anchor is None else self.anchor[chosen]
        return _Rows(flanks=self.flanks.instants(chosen), gap=self.gap[chosen], laws=self.laws, anchor=anchor)

    @property
    def F(self) -> int:
        """Number of flanks."""
        return self.flanks.count

    def force(self, approach: Array) -> Array:
        """Force of every row at B'q, (T, M) [N]."""
        return self.force_and_tangent(approach)[0]

    def force_and_tangent(self, approach: Array) -> tuple[Array, Array]:
        """Force of every row at B'q (T, M) [N], and the tangents of the flanks (T, F) [N/m]."""
        opening, F = approach - self.gap, self.F
        contact, tangent = self.flanks.evaluate(opening[:, :F])
        return np.hstack([contact, self.laws.force(opening[:, F:], self.anchor)]), tangent

    def newton(self, approach: Array, flexible: Compliance, residual: Array) -> Array:
        """Newton step (T, M) [N] of the pull: -r by its derivative 1 - A S, A = k0 - tangent, S = gap gap^T.

        With fewer coordinates h than rows M by 1 - gap^T A gap, (T, h, h).
        """
        opening, F, k0, gap = approach - self.gap, self.F, flexible.stiffness, flexible.gap
        soft = np.tile(k0, (len(opening), 1))
        soft[:, :F] -= np.maximum(self.flanks.evaluate(opening[:, :F])[1], _OPEN * k0[:F])
        soft[:, F:] *= 1.0 - _FLOATING
        few = gap.shape[1] < len(k0)
        seen = gap if few else flexible.to_mesh
        softer: Array = soft[:, :, None] * seen
        softer[:, F:] -= self.laws.tangent(opening[:, F:], self.anchor) @ seen[F:]
        if not few:
            return np.asarray(np.linalg.solve(softer - np.eye(len(k0)), residual[:, :, None])[:, :, 0])
        matrix = np.eye(gap.shape[1]) - gap.T @ softer
        moved = np.linalg.solve(matrix, (residual @ gap)[:, :, None])
        return np.asarray(-residual - (softer @ moved)[:, :, 0])

    def kinks(self, opening: Array, closing: Array) -> Array:
        """Step lengths (T, J) [1] at which the force of a row has a kink; those of flanks first, of groups behind them.

        From gaps `opening` along `closing` (T, M) [m]; nan or negative where there is none.
        """
        F = self.F
        return np.hstack(
            [self.flank_kinks(opening, closing), self.laws.kinks(opening[:, F:], closing[:, F:], self.anchor)]
        )

    def flank_kinks(self, opening: Array, closing: Array) -> Array:
        """The same of the flanks alone, (T, F K) [1]."""
        step = closing[:, : self.F, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            lengths = np.where(step != 0, (self.flanks.kinks - opening[:, : self.F, None]) / step, -1.0)
        return lengths.reshape(len(lengths), -1)


def compliance(elastic: Array, B: Array, stiffness: Array) -> Compliance:
    """Compliance of the train with all meshes closed; rows that strain nothing decide what is free, not their size.

    Parameters
    ----------
    elastic : (n, R) rows sqrt(k) b of what K holds [sqrt(N/m)].  B : (n, M).  stiffness : (M,) mean [N/m].
    """
    closed = stiffness > 0
    rows = np.hstack([elastic, B[:, closed] * np.sqrt(stiffness[closed])])
    diagonal = np.sum(rows**2, axis=1)
    scale: Array = 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    free = _free_unit_motions(rows)
    basis, _ = np.linalg.qr(free / scale[:, None], mode="complete")
    held = scale[:, None] * basis[:, free.shape[1] :]
    strain, motion = _factorised(rows.T @ held, held)
    gap = B.T @ motion
    gap[closed] = strain[elastic.shape[1] :] / np.sqrt(stiffness[closed])[:, None]
    strain = strain[: elastic.shape[1]]
    pulled = strain @ gap.T
    return Compliance(
        stiffness=stiffness,
        rows=B,
        elastic=elastic,
        motion=motion,
        gap=gap,
        strain=strain,
        # a line may load nothing but what does not move here: against rounding it would not balance
        free=np.where(np.abs(free) > _NULL_ROUNDING, free, 0.0),
        scale=scale,
        inverse=motion @ motion.T,
        to_body=motion @ gap.T,
        to_mesh=gap @ gap.T,
        gap_of_force=gap @ motion.T,
        elastic_pull=pulled.T @ pulled,
    )


def _free_unit_motions(rows: Array) -> Array:
    """Unit motions (n, r) that strain no row (n, R), by their geometry alone."""
    length = np.linalg.norm(rows, axis=0)
    unit = rows[:, length > 0] / length[length > 0]
    size = np.linalg.norm(unit, axis=1)
    scale = 1.0 / np.where(size > 0, size, 1.0)
    free = scale[:, None] * free_motions(scale[:, None] * unit)[0]
    return np.asarray(free / np.maximum(np.linalg.norm(free, axis=0), np.finfo(float).tiny))


def _factorised(weighted: Array, held: Array) -> tuple[Array, Array]:
    """Q (R, h) of W' = Q R and T = basis R^-1 (n, h), of rows W' (R, h) in the basis of held motions (n, h)."""
    order = np.argsort(-np.linalg.norm(weighted, axis=1), kind="stable")
    ordered, triangle, pivot = scipy.linalg.qr(weighted[order], mode="economic", pivoting=True)
    strain = np.empty_like(ordered)
    strain[order] = ordered
    motion = scipy.linalg.solve_triangular(triangle, held[:, pivot].T, trans="T").T
    return strain, np.ascontiguousarray(motion)


@lru_cache(maxsize=4)  # one analysis after the other asks of the same train
def compliance_of(system: System) -> Compliance:
    """Compliance of a train seen from the loaded flanks of its meshes and the rows of its groups."""
    B = np.hstack([system.meshes.B, system.group_rows])
    return compliance(elastic_rows(system), B, np.concatenate([system.meshes.stiffness, system.laws.row_stiffness]))


def require_balance(free: Array, force: Array, system: System) -> None:
    """Check that no load (T, n) [N, N m] works on a free motion (n, r) of a train.

    Raises
    ------
    ModelError : one does; names the coordinate to hold, or of a torque about the axes the one that contributes most.
    """
    work = force @ free
    # of several free motions one may meet no load but the rounding of another
    noise = _NOISE * np.max(np.abs(force), initial=0.0)
    excess = np.abs(work) - np.maximum(_BALANCE * (np.abs(force) @ np.abs(free)), noise)
    if not np.any(excess > 0):
        return
    instant, motion = np.unravel_index(int(np.argmax(excess)), work.shape)
    names = system.dofs.names
    if coordinates := unheld(free, force[instant], names):
        raise unheld_error(coordinates, system)
    worst = int(np.argmax(np.abs(force[instant] * free[:, motion])))
    raise ModelError(
        "the load does not balance along a motion that nothing holds",
        path=names[worst],
        given=float(force[instant, worst]),
        allowed="; ".join(filter(None, ("loads in equilibrium, or a support", contradicting_radii(system)))),
    )


def closed_state(
    flexible: Compliance, stiffness: Array, gap: Values, load: Values
) -> tuple[Values, Values, Array, Array]:
    """Stretches [m] and forces [N] (..., T, M) of rows that may all pull, and their `imbalance`, twice (..., T) [N].

    Parameters
    ----------
    stiffness : (T, M), 0 of an open row [N/m].  gap : (..., T, M) errors e [m], real or complex.
    load : (..., T, n) F [N, N m].
    """
    free_gap = load @ flexible.gap_of_force.T
    pull = _closed_pull(flexible, stiffness, gap, free_gap)
    approach = free_gap + pull @ flexible.to_mesh
    force: Values = flexible.stiffness * approach - pull
    return approach - gap, force, *imbalance(flexible, load, pull, force)


def _closed_pull(flexible: Compliance, stiffness: Array, gap: Values, free_gap: Values) -> Values:
    """p = k0 w - k (w - e) with w = B'H^+ F + S p, (..., T, m) [N]."""
    soft = flexible.stiffness - stiffness
    matrix = soft[:, :, None] * -flexible.to_mesh
    diagonal = np.arange(len(flexible.stiffness))
    matrix[:, diagonal, diagonal] += 1
    return np.linalg.solve(matrix, (soft * free_gap + stiffness * gap)[..., None])[..., 0]


def equilibrium(
    flexible: Compliance,
    *,
    stiffness: Array,
    gap: Array,
    force: Array,
    flanks: FlanksAt | None = None,
    laws: Laws | None = None,
    anchor: Array | None = None,
    start: Array | None = None,
) -> Equilibrium:
    """Equilibrium at T instants, meshes pulling nothing, groups following their laws.

    Parameters
    ----------
    stiffness : (T, m) k of the loaded flanks, that the first state takes [N/m].
    gap : (T, M) e of flanks and rows of groups [m], of far flanks with their backlash.  force : (T, n) load [N, N m].
    flanks : laws of the F flanks; None: the loaded ones alone, linear with that stiffness.
    laws : of the groups, where there are any.  anchor : (T, R) sliders before this step, for laws with a memory [m];
        without it they follow the radial law.
    start : (T, M) approach B'q to start from [m]; all loaded flanks closed, and the far ones open, where None.

    Raises
    ------
    ModelError : the load drives bodies apart and nothing holds them.
    ConvergenceError : not converged in so many steps, or forces on a body that do not balance.
    """
    k0, S = flexible.stiffness, flexible.to_mesh
    laws = stacked(()) if laws is None else laws
    rows = _Rows(flanks=linear_flanks(stiffness) if flanks is None else flanks, gap=gap, laws=laws, anchor=anchor)
    free_gap = force @ flexible.gap_of_force.T
    m = stiffness.shape[1]
    if start is None:
        nominal = np.tile(k0, (len(gap), 1))
        nominal[:, :m] = stiffness
        nominal[:, m : rows.F] = 0.0
        pull = _closed_pull(flexible, nominal, gap, free_gap)
    else:
        pull = k0 * start - rows.force(start)
    iterations = np.zeros(len(gap), dtype=np.int64)
    least, best, solution = np.full(len(gap), np.inf), np.full(len(gap), np.inf), pull.copy()
    polished = ~np.any(force != 0, axis=1)  # without a load all forces are rounding
    todo = np.arange(len(gap))
    for _ in range(_STEPS + 1):
        here = rows.at(todo)
        residual, limit, exact = _residual(S, k0, pull[todo], free_gap[todo], here)
        left = np.max(np.abs(residual), axis=1, initial=0.0)
        within = (left <= limit) & (left < best[todo])
        best[todo[within]], solution[todo[within]] = left[within], pull[todo[within]]
        # rounding of large errors beside a small load: one step more brings what double precision has, unless it ends
        # on the other side of a kink
        unfinished = np.isinf(best[todo]) | ((left > exact) & ~polished[todo])
        polished[todo] |= within
        todo = todo[unfinished]
        if not todo.size:
            return _result(flexible, solution, free_gap, rows, force, iterations, m)
        if iterations[todo[0]] >= _STEPS:
            break
        step, least[todo] = _newton_step(
            flexible, residual[unfinished], least[todo], pull[todo], free_gap[todo], here.at(unfinished)
        )
        pull[todo] += step
        iterations[todo] += 1
    raise ConvergenceError(
        f"no static equilibrium after {_STEPS} steps at {todo.size} of {len(gap)} instants; "
        "check that supports and meshes can carry the load"
    )


@contextmanager
def thrust_named(system: System) -> Iterator[None]:
    """Name the bearings that carry thrust in one sense alone in the error of a train without equilibrium."""
    try:
        yield
    except ConvergenceError as error:
        seats: dict[str, dict[str, Array]] = {}
        for group in system.groups:
            if isinstance(group.law, ContactSetLaw) and f"{group.name}/z" in group.rows:
                thrust = group.law.contacts.normals[:, group.rows.index(f"{group.name}/z")]
                seats.setdefault(group.name.partition(f"/{group.kind}")[0], {})[group.name] = np.sign(thrust)
        alone = [", ".join(own) for own in seats.values() if len(np.unique(np.concatenate([*own.values()]))) == 1]
        if not alone:
            raise
        needs = "a second row (rows = 2) or bearing, of the opposite contact angle, has to carry the other sense"
        text = f"{error}; thrust in one sense alone is carried by {', '.join(alone)}: {needs}"
        raise ConvergenceError(text) from error


def _residual(S: Array, k0: Array, pull: Array, free_gap: Array, rows: _Rows) -> tuple[Array, Array, Array]:
    """r = p - k0 w + f(w - e) (T, M) [N], its convergence limit (T,) [N], and that without rounding (T,) [N]."""
    w = free_gap + pull @ S
    contact, tangent = rows.force_and_tangent(w)
    stiff, far = k0, np.flatnonzero(k0[: rows.F] == 0)
    if far.size:  # a far flank has k0 = 0, and rounds with its own stiffness where it presses
        stiff = np.tile(k0, (len(w), 1))
        stiff[:, far] = tangent[:, far]
    sizes = np.maximum(np.abs(pull), stiff * (np.abs(w) + np.abs(rows.gap)))
    terms = np.max(sizes, axis=1, initial=np.finfo(float).tiny)
    exact = _TOLERANCE * np.max(np.abs(contact), axis=1, initial=0.0)
    return pull - k0 * w + contact, exact + _ROUNDING * len(k0) * terms, exact


def _newton_step(
    flexible: Compliance, residual: Array, least: Array, pull: Array, free_gap: Array, rows: _Rows
) -> tuple[Array, Array]:
    """Newton step of the pull times its length, (T, M) [N], and the least residual of any full step (T,) [N].

    Full where it brings the residual to a part of that of all full steps before (T,), else of least energy.
    """
    k0, S = flexible.stiffness, flexible.to_mesh
    approach = free_gap + pull @ S
    direction = rows.newton(approach, flexible, residual)
    after = np.max(np.abs(_residual(S, k0, pull + direction, free_gap, rows)[0]), axis=1)
    before = np.minimum(least, np.max(np.abs(residual), axis=1))
    search = ~(after <= _DROP * before)
    length = np.ones(len(pull))
    if search.any():
        length[search] = _step_length(flexible, pull[search], direction[search], free_gap[search], rows.at(search))
    return length[:, None] * direction, np.where(search, least, after)


def _step_length(flexible: Compliance, pull: Array, direction: Array, free_gap: Array, rows: _Rows) -> Array:
    """Length (T,) [1] of least energy along a direction (T, M) of the pull [N].

    The energy is convex along it with slope(a) = rest + curvature a + d . f(w + a d), d = S direction, so that the
    best length is safe in flat directions, where a full step would be far too long.  Rest and curvature are those of
    K and the load alone, from the strains of K: no difference of large numbers.

    Raises
    ------
    ModelError : the energy falls without end.
    """
    k0 = flexible.stiffness
    approach, closing = free_gap + pull @ flexible.to_mesh, direction @ flexible.to_mesh
    resisting = direction @ flexible.elastic_pull
    rest = np.sum(resisting * pull, axis=1) - np.sum(closing * k0 * free_gap, axis=1)
    curvature = np.sum(resisting * direction, axis=1)
    start = rest + np.sum(closing * rows.force(approach), axis=1)
    flat, slope_there = _behind_the_kinks(rest, closing, k0, approach, rows)
    endless = np.flatnonzero(flat & (slope_there < 0))
    if np.any(_unstrained(flexible, direction[endless])):
        raise ModelError(
            "the load drives meshing bodies apart and nothing holds them",
            path="operation.torque",
            allowed="torques that press the meshes, or supports that hold every body",
        )
    # a slope that is not falling at the start is rounding at the solution: a plain Newton step
    falling = np.flatnonzero(start < 0)
    length = np.ones(len(start))
    if falling.size:
        here, d = rows.at(falling), closing[falling]

        def slope(a: Array, instants: np.ndarray) -> Array:
            """Slope of the energy at lengths a (t,) [1] along the directions of the given instants (t,), (t,) [N m]."""
            w = approach[falling[instants]] + a[:, None] * d[instants]
            rising = curvature[falling[instants]] * a
            value: Array = rest[falling[instants]] + rising + np.sum(d[instants] * here.at(instants).force(w), axis=1)
            return value

        kinks = here.kinks(approach[falling] - here.gap, d)
        length[falling] = line_minimum(slope, kinks, start[falling])
    return length


def _behind_the_kinks(
    rest: Array, closing: Array, k0: Array, approach: Array, rows: _Rows
) -> tuple[NDArray[np.bool_], Array]:
    """Whether no flank or group resists a direction behind the last kink (T,), and there the slope (T,) [N m].

    The slope leaves out what grows with the stiffness of K: it is that of the energy where that is zero.
    """
    F = rows.F
    kinks = rows.flank_kinks(approach - rows.gap, closing)
    last = np.max(np.where(np.isfinite(kinks), kinks, 0.0), axis=1, initial=0.0)
    # a tangent may begin at zero: well behind the kink, and at least a Newton length away, it does not
    force, tangent = rows.force_and_tangent(approach + (2.0 * last + 1.0)[:, None] * closing)
    final = np.sum(tangent * closing[:, :F] ** 2, axis=1) + np.sum(k0[F:] * closing[:, F:] ** 2, axis=1)
    slope: Array = rest + np.sum(closing * force, axis=1)
    return final <= _FLAT * np.sum(k0 * closing**2, axis=1), slope


def _unstrained(flexible: Compliance, direction: Array) -> NDArray[np.bool_]:
    """Whether motions by pulls (T, M) [N] strain no link, however soft; lengths of rows do not count (T,)."""
    motion = direction @ flexible.to_body.T
    unit = flexible.elastic / np.max(np.abs(flexible.elastic), axis=0, initial=np.finfo(float).tiny)
    strain = np.max(np.abs(motion @ unit), axis=1, initial=0.0)
    return np.asarray(strain <= _UNSTRAINED * np.max(np.abs(motion), axis=1, initial=0.0))


def imbalance(flexible: Compliance, load: Values, pull: Values, contact: Values) -> tuple[Array, Array]:
    """Largest force that K q + B f - F leaves on a body (..., T) [N], and that of load and rows (..., T) [N].

    The size of a light load is raised where the rest is rounding of play times stiffness.

    Moments count by the largest arm of a row; what works on free motions is left out.

    Parameters
    ----------
    load : (..., T, n) F [N, N m].  pull, contact : (..., T, M) p, f of all rows [N].
    """
    elastic = (load @ flexible.motion + pull @ flexible.gap) @ flexible.strain.T
    left = elastic @ flexible.elastic.T + contact @ flexible.rows.T - load
    if flexible.free.size:
        across, _ = np.linalg.qr(flexible.free / flexible.scale[:, None])
        left = left - ((left * flexible.scale) @ across) @ across.T / flexible.scale
    arm = np.max(np.abs(flexible.rows), axis=1, initial=0.0)
    arm[arm <= _NO_ARM * np.max(arm, initial=0.0)] = 1.0  # no flank moves it, but for rounding
    size = np.maximum(np.max(np.abs(load) / arm, axis=-1, initial=0.0), np.max(np.abs(contact), axis=-1, initial=0.0))
    # forces of rows are differences of stiffness times play, which a light load is small beside
    play = _PLAY_ROUNDING / LEFT * np.max(np.abs(pull), axis=-1, initial=0.0)
    size = np.maximum(size, np.minimum(play, _LIGHT / LEFT * size))
    return np.asarray(np.max(np.abs(left) / arm, axis=-1, initial=0.0)), np.asarray(size)


def require_forces(left: Array, size: Array) -> None:
    """Check what is left on a body (T,) [N] against load and forces (T,) [N], as of `imbalance`.

    Raises
    ------
    ConvergenceError : what is left is above a part of the load.
    """
    if np.any(unbalanced := ~(left <= LEFT * size)):
        raise ConvergenceError(
            f"forces on a body do not balance to {LEFT:g} of the load at {np.count_nonzero(unbalanced)} of "
            f"{unbalanced.size} instants: stiffnesses or errors too far apart for double precision"
        )


def _result(
    flexible: Compliance, pull: Array, free_gap: Array, rows: _Rows, force: Array, iterations: np.ndarray, m: int
) -> Equilibrium:
    """The state at pulls (T, M) [N] that solve the condensed problem, expanded to all coordinates; m loaded flanks."""
    approach, F = free_gap + pull @ flexible.to_mesh, rows.F
    contact = rows.force(approach)
    left, size = imbalance(flexible, force, pull, contact)
    # without a load all forces are rounding
    require_forces(np.where(np.any(force != 0, axis=1), left, 0.0), size)
    return Equilibrium(
        displacement=force @ flexible.inverse + pull @ flexible.to_body.T,
        mesh_force=contact[:, :m],
        far_force=contact[:, m:F],
        iterations=iterations,
        group_stretch=(approach - rows.gap)[:, F:],
        group_force=contact[:, F:],
        approach=approach,
    )
