"""Floquet multipliers of the linear system whose meshes change periodically in any way, over any period.

A step is the exact flow of the mean system (gyroscopic, centripetal and off-diagonal damping terms included) and a
kick of rank m by the deviation of the meshes from their mean over the period.  The kick carries the double commutator
of the splitting: D - h^2/12 D S D in place of D, S = B^T M^-1 B [takahashi1984].  One step is then a processed method
of fourth order: its error of second order is a change of coordinates, periodic like the meshes, which no multiplier
feels [hairer2006, sec. V.3.3].  Without damping a step is symplectic: multipliers stay on the unit circle to rounding
until they meet.

The mean system is a state z = (y, u) in mass-normalised modal coordinates x (q = Phi x) with rates u = x' and
y = weight x, whose square is twice the energy.  Positions of neutral motions (free rotation) enter no force and are
left out: what is left has no defective double multiplier at 1 that rounding would scatter to 1e-8.

Three things make a product of thousands of steps cheap, none of which changes it but for rounding; derived here.

- Coordinates that no mesh and no mean term couples at any instant are propagated apart, as the symmetric and the
  antisymmetric motions of a herringbone train whose sides mesh in phase.  Work goes with the cube of the size.
- The kicks of a part act through as many combinations of its gaps as its mesh rows have rank, however many rows there
  are: both sides of a herringbone mesh are one where nothing tilts.
- Steps are taken several at a time.  The gaps met by the kicks of such a group follow from its first state and the
  impulses before, by small matrices; the large ones are multiplied once a group.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray, Index
from ..modes.eigen import Modal, modal_weights, neutral_basis

# Kinds of loss of stability, by where the largest multiplier leaves the unit circle; one vocabulary for all analyses.
# At +1 a linear system has one word, divergence.  With teeth that part the branch of the motion tells two of its forms
# apart: a fold, where it turns back, and symmetry breaking, where another one with less symmetry leaves it.
STABLE = "stable"
DIVERGENCE, DOUBLING, QUASI_PERIODIC = "divergence", "period doubling", "quasi-periodic"
FOLD, BREAKING = "fold", "symmetry breaking"
KINDS = (STABLE, DIVERGENCE, DOUBLING, QUASI_PERIODIC)

# A multiplier this much above 1 is growth.  Without damping multipliers lie on the circle; two that coincide separate
# by the root of the rounding.  With constant contact more steps change them by no more than 1e-12.
CIRCLE = 1e-7
# Least steps of a mesh cycle, and of a cycle of the highest mode.
_STEPS_PER_CYCLE, _STEPS_PER_MODE_CYCLE = 24.0, 4.0
# A constant of the motion is one if what would change it is rounding beside the matrices' own size.
_CONSERVED = 1e-9
# Couplings below this part of the product of the natural frequencies are rounding: that of gaps of close modes reaches
# 1e-13, the least couplings of trains are 1e-10.
_COUPLED = 1e-12
# Combinations of gaps this small beside the largest are rounding of mesh rows that depend on each other.
_RANK = 1e-12
# Steps of a group at most: beyond it the large products are no longer what costs.
_GROUP = 12
# Doubles of the matrices of groups multiplied side by side: they and their products stay in the second cache.
_BATCH = 100_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Floquet:
    """Propagation of a small disturbance over one period.

    multipliers : (2n,) complex, largest magnitude first, then those of free motions.
    free : (2n,) whether it is that of a free motion: of its position (exactly 1) or its momentum (1 to rounding).
    position, rate : (n, 2n) complex, eigenvectors in the coordinates y of `Modal` and their y' [1/s] at the first
        instant, to O(h^2), of unit energy norm |y|^2 + |x'|^2, without the position of free motions, on which nothing
        depends; None where not asked for.
    """

    multipliers: ComplexArray
    free: NDArray[np.bool_]
    position: ComplexArray | None = None
    rate: ComplexArray | None = None

    @property
    def largest(self) -> complex:
        """The largest multiplier, free motions apart; 0 where there is none."""
        bound = self.multipliers[~self.free]
        return complex(bound[0]) if bound.size else 0j


def steps_needed(modal: Modal, *, period: float, cycle: float, harmonics: int = 0) -> int:
    """Steps of a period that hold the motion between kicks: 24 a mesh cycle, 4 a cycle of the highest mode.

    Kicks repeat with the step's frequency; it is kept so high that no sum of two natural frequencies meets it.

    Parameters
    ----------
    period : [s].  cycle : shortest mesh cycle [s].  harmonics : of the mesh stiffness, per mesh cycle.
    """
    highest = float(np.sqrt(modal.squared.max(initial=0.0))) / (2 * np.pi)
    clear = 2 * highest + (harmonics + 1) / cycle
    return int(np.ceil(period * max(_STEPS_PER_CYCLE / cycle, _STEPS_PER_MODE_CYCLE * highest, clear) - 1e-9))


def multiplier_kind(multiplier: complex, *, real: float) -> str:
    """Kind of loss of stability of the largest multiplier [1].

    Stable within 1 + `CIRCLE`, real within `real` of its size.

    Near +1 ``divergence``, growth at mesh orders; near -1 ``period doubling``, at half orders; else
    ``quasi-periodic``, two modes together.
    """
    if abs(multiplier) <= 1 + CIRCLE:
        return STABLE
    if abs(multiplier.imag) > real * abs(multiplier):
        return QUASI_PERIODIC
    return DIVERGENCE if multiplier.real > 0 else DOUBLING


def floquet(
    modal: Modal,
    stiffness: Array,
    *,
    period: float,
    frame: float = 1.0,
    damping: Array | None = None,
    gaps: Array | None = None,
    vectors: bool = False,
) -> Floquet:
    """Multipliers of one period, and the motions they belong to.

    Parameters
    ----------
    stiffness : (m, N) tangent of every mesh row less the mean stiffness that `modal` holds [N/m], at N equal steps of
        the period; -k0 where teeth are parted.  N : see `steps_needed`.
    period : [s]; of one mesh cycle, or of as many as the motion needs.  frame : factor of G and Cskew, squared of Kg.
    damping : (m, N) mesh damping less what `modal` holds [N s/m]; its varying part is followed to second order.
    gaps : (m, n) gap of y of the rows that change, where these are others, or more, than the meshes of `modal`.
    vectors : whether the eigenvectors are wanted.

    Raises
    ------
    numpy.linalg.LinAlgError : a number that is not finite, or eigenvalues that did not converge.
    """
    mean_k, mean_c = stiffness.mean(axis=1), np.zeros(len(stiffness)) if damping is None else damping.mean(axis=1)
    start = _mean_flow(modal, frame=frame, stiffness=mean_k, damping=mean_c, gaps=gaps)
    change_c = None if damping is None or not np.ptp(damping, axis=1).any() else damping - mean_c[:, None]
    change_k, step = stiffness - mean_k[:, None], period / stiffness.shape[1]
    multipliers, columns = list[ComplexArray](), list[ComplexArray]()
    for states, whole in _monodromies(start, change_k, change_c, step):
        if not np.isfinite(whole).all():
            raise np.linalg.LinAlgError("the motion over a period is not finite")
        if not vectors:
            multipliers.append(scipy.linalg.eigvals(whole, check_finite=False))
            continue
        mu, motions = scipy.linalg.eig(whole, check_finite=False)
        multipliers.append(mu)
        columns.append(np.zeros((len(start.generator), mu.size), complex))
        columns[-1][states] = motions
    mu = np.concatenate(multipliers)
    order, free = _sorted(mu, start)
    mu = np.concatenate([mu, np.ones(start.neutral)])[order]
    if not vectors:
        return Floquet(multipliers=mu, free=free)
    # in the middle of the first kick
    z = np.concatenate(columns, axis=1)
    (impulses,) = _impulses(start, change_k[:, :1], None if change_c is None else change_c[:, :1], step / 2)
    z[start.gaps.shape[1] :] -= start.rows.T @ (impulses @ z[: impulses.shape[1]])
    position, rate = _motions(start, z)
    return Floquet(multipliers=mu, free=free, position=position[:, order], rate=rate[:, order])


def _monodromies(
    start: _MeanFlow, stiffness: Array, damping: Array | None, step: float
) -> Iterator[tuple[NDArray[np.int64], Array]]:
    """States and monodromy matrix of every independent part; changes (m, N) less their means, a step of length [s]."""
    k = start.gaps.shape[1]
    for part in independent_parts(start.generator, start.rows, start.weight, stiffness=stiffness, damping=damping):
        held = part[part >= start.neutral] - start.neutral
        states = np.concatenate([held, k + part])
        yield (
            states,
            monodromy(
                start.generator[np.ix_(states, states)],
                start.gaps[:, held],
                start.rows[:, part],
                stiffness=stiffness,
                damping=damping,
                step=step,
            ),
        )


def _motions(start: _MeanFlow, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """(n, 2n) position y and rate y' in the order of the modes, the motions left out as the last columns."""
    k, n, r = start.gaps.shape[1], len(start.weight), start.neutral
    x, u = np.zeros((n, k + n + r), complex), np.zeros((n, k + n + r), complex)
    x[r:, : k + n] = z[:k] / start.weight[r:, None]
    u[:, : k + n] = z[k:]
    x[:r, k + n :] = np.diag(1 / start.weight[:r])
    x, u, weight = start.turn @ x, start.turn @ u, (start.turn**2) @ start.weight
    size = np.sqrt((np.abs(weight[:, None] * x) ** 2 + np.abs(u) ** 2).sum(axis=0))
    return weight[:, None] * x / size, weight[:, None] * u / size


def _sorted(mu: ComplexArray, start: _MeanFlow) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Order (2n,) of the multipliers with those left out behind them, and which are of free motions.

    As many as there are conserved momenta are exactly 1 but for rounding: the nearest ones.
    """
    momenta = np.argsort(np.abs(mu - 1), kind="stable")[: start.conserved]
    size = np.concatenate([np.abs(mu), np.ones(start.neutral)])
    free = np.zeros(size.size, bool)
    free[momenta] = free[len(mu) :] = True
    order = np.lexsort((-size, free))
    return order, free[order]


# --- the mean system --------------------------------------------------------------------------------------------------


class _MeanFlow(NamedTuple):
    """The mean system as a linear flow: z' = generator z less the push of changed meshes.

    generator : (k + n, k + n) of z = (y (k,), u (n,)) [1/s].
    gaps : (m, k) gap of y [m].  rows : (m, n) B^T Phi: gap rate of u, and transposed the push of mesh forces on u.
    turn : (n, n) orthogonal, x = turn (x_neutral, x_rest).  weight : (n,) in the order of the turned coordinates
        [rad/s].
    neutral : positions left out, n - k of them, each a multiplier 1.  conserved : multipliers 1 among the others.
    """

    generator: Array
    gaps: Array
    rows: Array
    turn: Array
    weight: Array
    neutral: int
    conserved: int


def _mean_flow(modal: Modal, *, frame: float, stiffness: Array, damping: Array, gaps: Array | None = None) -> _MeanFlow:
    """The mean system with other mean meshes.

    Parameters
    ----------
    frame : factor of G and Cskew, squared of Kg.
    stiffness, damping : (m,) mean of each mesh less what `modal` holds [N/m], [N s/m].
    gaps : (m, n) gap of y of those rows; the meshes of `modal` where None.
    """
    weight = modal_weights(modal.squared, modal.rigid)
    rows = (modal.gaps if gaps is None else gaps) * weight
    # rates and positions in mass-normalised modal coordinates
    C, K = np.diag(modal.damping), np.diag(modal.squared)
    for name, factor, target in (("G", frame, C), ("C", 1.0, C), ("Kg", frame**2, K), ("Cskew", frame, K)):
        if name in modal.coupling:
            target += factor * modal.coupling[name].T * weight / weight[:, None]
    C += (rows.T * damping) @ rows
    K += (rows.T * stiffness) @ rows
    turn, neutral, conserved = np.eye(len(weight)), 0, 0
    rigid = np.flatnonzero(modal.rigid)
    if rigid.size:
        turn, neutral = neutral_basis(K, rigid)
        C, K, rows, weight = turn.T @ C @ turn, turn.T @ K @ turn, rows @ turn, (turn**2).T @ weight
        conserved = _conserved(K, C, rigid.size, neutral)
    n, k = len(weight), len(weight) - neutral
    generator = np.zeros((k + n, k + n))
    generator[:k, k + neutral :] = np.diag(weight[neutral:])
    generator[k:, :k] = -K[:, neutral:] / weight[neutral:]
    generator[k:, k:] = -C
    return _MeanFlow(
        generator=generator,
        gaps=np.ascontiguousarray(rows[:, neutral:] / weight[neutral:]),
        rows=rows,
        turn=turn,
        weight=weight,
        neutral=neutral,
        conserved=conserved,
    )


def _conserved(K: Array, C: Array, rigid: int, neutral: int) -> int:
    """Number of momenta of the `rigid` first coordinates that nothing changes.

    No position, no rate of a neutral motion.

    K [1/s^2] and C [1/s] are (n, n) with the neutral coordinates first.
    """
    tiny = np.finfo(float).tiny
    held = K[:rigid] / max(float(np.abs(K - np.diag(np.diag(K))).max(initial=0.0)), tiny)
    dragged = C[:rigid, :neutral] / max(float(np.abs(C).max(initial=0.0)), tiny)
    changed = np.linalg.svd(np.concatenate([held, dragged], axis=1), compute_uv=False)
    return rigid - int(np.sum(changed > _CONSERVED))


# --- flow and kicks where no period ends them -------------------------------------------------------------------------


class VariationalFlow(NamedTuple):
    """Flow and kicks of a linear system whose meshes change in any way, for some disturbances side by side.

    mean : the mean system.  stiffness, damping : (m,) of the rows in it, less what `Modal` holds [N/m], [N s/m].
    joined : (N, N + m) one step of the flow from states and impulses.  step : [s].
    """

    mean: _MeanFlow
    stiffness: Array
    damping: Array | None
    joined: Array
    step: float

    @property
    def size(self) -> int:
        """Length N of a state, without the positions of free motions."""
        return len(self.mean.generator)

    def propagated(self, start: Array, stiffness: Array, damping: Array | None) -> Array:
        """States (N, k) after S steps from (N, k); stiffness, damping : (m, S) as of `floquet`."""
        change = None if damping is None or self.damping is None else damping - self.damping[:, None]
        stiffness, N = stiffness - self.stiffness[:, None], self.size
        both = np.zeros((self.joined.shape[1], start.shape[1]))
        both[:N] = start
        size = max(2, _BATCH // (N * len(stiffness) + 1))
        for first in range(0, stiffness.shape[1], size):
            part = slice(first, first + size)
            damping = None if change is None else change[:, part]
            for impulses in _impulses(self.mean, stiffness[:, part], damping, self.step):
                both[N:] = impulses @ both[: impulses.shape[1]]
                both[:N] = self.joined @ both
        return both[:N]


def variational_flow(
    modal: Modal, stiffness: Array, *, step: float, frame: float, damping: Array | None, gaps: Array
) -> VariationalFlow:
    """The flow of the mean system that the kicks of `floquet` go with, where no period ends them.

    Parameters
    ----------
    stiffness, damping : (m,) means of what changes, less what `modal` holds [N/m], [N s/m]; None where it stays.
    step : [s].  frame, gaps : as of `floquet`.
    """
    held = np.zeros(len(stiffness)) if damping is None else damping
    mean = _mean_flow(modal, frame=frame, stiffness=stiffness, damping=held, gaps=gaps)
    flow = scipy.linalg.expm(mean.generator * step)
    joined = np.hstack([flow, -flow[:, mean.gaps.shape[1] :] @ mean.rows.T])
    return VariationalFlow(mean=mean, stiffness=stiffness, damping=damping, joined=joined, step=step)


def _impulses(mean: _MeanFlow, stiffness: Array, damping: Array | None, step: float) -> Array:
    """Impulse of every mesh row per state in some steps of a length [s] [N s].

    (steps, m, k) of the positions y; (steps, m, k + n) of the whole state where damping changes.

    Parameters
    ----------
    stiffness, damping : (m, steps) changes less their means [N/m], [N s/m].
    """
    # S = B^T M^-1 B of the elastic modes [1/kg]
    mass = mean.rows @ mean.rows.T
    m, each = len(mass), np.eye(len(mass))
    dampers = None if damping is None else damping.T[:, :, None] * each
    maps = kick_maps(stiffness.T[:, :, None] * each, dampers, mass, step)
    if dampers is None:
        return maps @ mean.gaps
    return np.concatenate([maps[:, :, :m] @ mean.gaps, maps[:, :, m:] @ mean.rows], axis=2)


# --- a product of many steps ------------------------------------------------------------------------------------------


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
    from scipy.sparse.csgraph import connected_components  # only here: 20 ms

    n = len(weight)
    k, root = len(generator) - n, np.sqrt(weight)
    coupling = np.abs(generator[k:, k:]) / np.outer(root, root)
    coupling[:, n - k :] = np.maximum(coupling[:, n - k :], np.abs(generator[k:, :k]) / weight[:, None])
    for change, scaled in ((stiffness, rows / weight), (damping, rows / root)):
        if change is not None:
            coupling = np.maximum(coupling, _largest_coupling(change, scaled))
    count, group = connected_components(coupling > _COUPLED, directed=False)
    return [np.flatnonzero(group == number) for number in range(count)]


def _largest_coupling(change: Array, rows: Array) -> Array:
    """Root mean square over the steps of what rows (m, n) with factors (m, N) couple, (n, n)."""
    m, n = rows.shape
    # of all the steps only the triangle of their QR counts, in which small differences of rows are not squared
    triangle = np.linalg.qr(change.T, mode="r") / np.sqrt(change.shape[1])
    pairs = triangle @ (rows[:, :, None] * rows[:, None, :]).reshape(m, -1)
    return np.asarray(np.linalg.norm(pairs, axis=0).reshape(n, n))


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
    return step * np.linalg.solve(held, np.concatenate([force, damping], axis=2))


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
        return np.asarray(np.linalg.matrix_power(flow, count))
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
        grouped = len(maps) - len(maps) % size
        if grouped:
            whole = _group_product(group, maps[:grouped]) @ whole
        for impulses in maps[grouped:]:
            whole[-rows.shape[1] :] -= rows.T @ (impulses @ (sensed @ whole))
            whole = flow @ whole
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


class _Group(NamedTuple):
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
    return np.asarray(here[0])
