"""Corrector and continuation of the harmonic balance with contact loss.

Newton corrector of the balance at a fixed speed: preconditioned GMRES [knoll2004; saad1986], and a line search.

The preconditioner holds what contact changes, exactly where the train is soft against it.  Without what couples modes
the linearised balance is y + D^-1 pulls^T T gaps y = r, T the sampled tangents less k0.  Its inverse is
y = r - D^-1 pulls^T (I + T P)^-1 T gaps r with P = gaps D^-1 pulls^T, the receptance of the meshes (Woodbury's
identity).  P is one small matrix at every lattice point.  T couples the points: of amplitudes X_b of a gap it makes

    Y_a = sum_b (T_{a-b} X_b + T_{a+b} conj X_b),    Y_0 = Re sum_b T_{-b} X_b

with the amplitudes T_c exp(2 pi i c . theta) of the tangent.  Where P T is small T is left out; at the other points
that matrix is factored, and where they are many, T is its mean at the stiffer ones, which couples none (derived here).
Preconditioned GMRES then takes a third of the products that the mean at every point would leave it.

The truncation residual is that of forces of flanks and links on the orders that the grid resolves and the lattice
drops.  It is exact, because the grid of phases holds the whole force (derived here).  Each dropped row is turned into a
motion by D^-1, so that a force far above all modes counts for little.

Branches of periodic motions over speed: pseudo-arclength continuation through folds [keller1977; seydel2010].

Lengths are measured in (|dy| / motion, ds / speed); both units belong to the path.  A step is taken along the
tangent and corrected at right angles to it, the pair (y, s) by one bordered GMRES.  Newton's method may converge to
another branch with a residual as clean as ever.  Therefore a step also fails where the corrector moves far or the
tangent turns much (derived here).

Folds and the highest point of a branch are located, not stepped over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.linalg.lapack import dgetrf, dgetrs

from ...engine.run_folder import KeptPart, RunFolder
from ...system.gaps import contiguous
from ...system.system import Array, ComplexArray, Index
from ..response.balance import gmres
from .problem import Problem, State, balanced_forces, dynamic_size, evaluate, jacobian, speed_derivative, unknowns

Operator = Callable[[Array], Array]
NewtonStep = Callable[[Problem, State, Array, float], tuple[Array, int]]
"""Solves the linearised balance for a right side to a target, and counts the products."""

# |R| per dynamic size that is a solution: far below what truncation leaves (`solutions`, `truncation_residual`).
TOLERANCE = 1e-6
# Jacobian-vector products before a point counts as lost: three times what the hardest that succeed take.
WORK = 300
# Newton steps before a point counts as lost; halvings of one step, down to 1/32 of it.
_STEPS, _HALVINGS = 20, 6
# Part of the promised decrease that a step must bring: a sufficient decrease, as of Armijo.
_DECREASE = 0.1
# Part of the residual wanted below which GMRES need not solve: the last Newton step is no better for it.
_TARGET = 0.1
# Residual of the GMRES of a step per residual now: each step of a torus is worth about one more digit; mesh orders are
# cheap enough to solve each linear system to three.
_FORCING, _MESH_FORCING = 1e-2, 1e-3
# Change of the tangent, per k0, and receptance times tangent of a point, below which they do nothing.  Only the number
# of products depends on them (ren2021, 3000 bordered solves: 22.5 products with no point coupled, 7.0 from 0.2, 6.3
# from 0.1, 5.9 from 0.05, whose matrices take twice as long).
_SAME, _SOFT = 1e-3, 0.1
# Unknowns of the matrix that couples points: its factors take a millisecond, as long as 20 products.  Over several
# phases no points are coupled: those few save less than they cost (bench56 with two shaft tones: 1.50 s with, 1.40 s).
_MOST = 300
# Products of one solution up to which the preconditioner of another state is kept: a new one costs as many.
_KEPT = 7
# Rounding of a sum of shaft orders per highest order, which is 1 at the edge of the lattice, and of a bound of some
# hundred terms, with a wide margin.
_ROUNDING = 1e-9


class NewtonResult(NamedTuple):
    """Where Newton's method ended.

    state : the last motion.  converged : whether |R| <= tolerance of the dynamic part.
    calls : Jacobian-vector products.
    """

    state: State
    converged: bool
    calls: int


def solve(
    balance: Problem,
    start: Array,
    speed: float,
    *,
    tolerance: float = TOLERANCE,
    steps: int = _STEPS,
    work: int = WORK,
    step: NewtonStep | None = None,
) -> NewtonResult:
    """Newton's method from a motion (2, J, n) at relative speed s.

    Parameters
    ----------
    tolerance : of |R| per dynamic size.  steps : Newton steps at most.  work : Jacobian-vector products at most.
    step : how a Newton step is solved; None: GMRES to 1e-3.
    """
    state, calls = evaluate(balance, start, speed), 0
    advance = step or newton_step(forcing=_MESH_FORCING, restarts=3)
    for count in range(steps + 1):
        if not np.isfinite(state.norm):
            break
        size = dynamic_size(state.y)
        if state.norm <= tolerance * size:
            return NewtonResult(state=state, converged=True, calls=calls)
        if count == steps or calls > work:
            break
        move, used = advance(balance, state, state.residual, _TARGET * tolerance * size)
        calls += used
        lower = _line_search(balance, state, move)
        if lower is None:
            break
        state = lower
    return NewtonResult(state=state, converged=False, calls=calls)


def _line_search(balance: Problem, state: State, move: Array) -> State | None:
    """The first of the halved steps along a move (2, J, n) that lowers |R|, None where none does."""
    factor = 1.0
    for _ in range(_HALVINGS):
        trial = evaluate(balance, state.y - factor * move, state.speed)
        if trial.norm < (1 - _DECREASE * factor) * state.norm:
            return trial
        factor /= 2
    return None


def linear_start(balance: Problem, speed: float, touching: NDArray[np.bool_] | None = None) -> Array:
    """The linear motion (2, J, n) in which flanks touch all the time or never, to 1e-3: a start for Newton's method.

    Parameters
    ----------
    touching : (F,) the flanks that touch; None: every loaded flank and no far flank.
    """
    pattern = balance.rows.flanks.sense > 0 if touching is None else touching
    state = evaluate(balance, np.zeros(unknowns(balance)), speed, touching=pattern)
    return -newton_step(forcing=_MESH_FORCING, restarts=3)(balance, state, state.residual, 0.0)[0]


def newton_step(*, forcing: float = _FORCING, restarts: int = 2) -> NewtonStep:
    """A Newton step solved by GMRES to `forcing` of the norm of its right side, or to the target if that is larger.

    Steps that follow one another share their preconditioner while it serves.
    """
    kept = KeptPreconditioner()

    def step(balance: Problem, at: State, right: Array, target: float) -> tuple[Array, int]:
        """The step (2, J, n) for a right side (2, J, n), and the Jacobian-vector products it took."""
        inverse, product, shape = kept.at(balance, at), jacobian(balance, at), right.shape
        start = inverse(right)
        size = float(np.linalg.norm(start))
        x, _, kept.calls = gmres(
            lambda x: inverse(product(x.reshape(shape))).reshape(x.shape),
            start.reshape(1, -1),
            target=np.array([max(forcing * size, target)]),
            restarts=restarts,
            checked=False,
        )
        return x.reshape(shape), kept.calls

    return step


# --- preconditioner ---------------------------------------------------------------------------------------------------


@dataclass(slots=True, kw_only=True)
class KeptPreconditioner:
    """The preconditioner of a state nearby, as long as GMRES takes few products with it.

    balance, inverse : of which balance it is, and itself; None before the first.
    calls : products of the last solution.
    """

    balance: Problem | None = None
    inverse: Operator | None = None
    calls: int = 0

    def at(self, balance: Problem, state: State) -> Operator:
        """The one that is kept, else that of a state: an operator on (2, J, n)."""
        if self.inverse is None or self.balance is not balance or self.calls > _KEPT:
            self.balance, self.inverse = balance, preconditioner(balance, state)
        return self.inverse


def preconditioner(balance: Problem, at: State) -> Operator:
    """The approximate inverse of the Jacobian at a state, an operator on (2, J, n)."""
    rows, face, m = balance.rows, balance.face, len(balance.face.row)
    links = at.tangent[:, rows.count :] - rows.linear[rows.count :]
    tangent = np.concatenate([face.total(at.tangent[:, :m] - rows.linear[:m], axis=1), links], axis=1)
    size = np.abs(tangent).max(axis=0)
    largest = float(np.abs(rows.linear[rows.count :]).max(initial=0.0))
    if np.all(size <= _SAME * np.concatenate([face.total(rows.linear[:m]), np.full(links.shape[1], largest)])):
        return lambda right: right
    (gaps, pulls), w = _meshes(balance), at.speed * balance.omega
    mean = tangent.mean(axis=0)
    drag = face.total((at.touching[:, :m].mean(axis=0) - 1.0) * rows.drag[:m])
    rate = np.multiply.outer(w, np.concatenate([drag, rows.lag[rows.count :] * mean[len(drag) :]]))
    points, receptance, loop = _soft_points(at, gaps, pulls, np.hypot(size, rate))
    order = np.argsort(-loop, kind="stable")
    most = _MOST // (2 * len(size)) if len(balance.grid.counts) == 1 else 0
    coupled, alone = (np.sort(part) for part in np.split(order, [most]))
    forces = list[tuple[Index, Operator]]()
    if coupled.size:
        place = points[coupled]
        forces.append((place, _factored(_coupling(balance, place, tangent, rate[place]), receptance[coupled])))
    if alone.size:
        place = points[alone]
        forces.append((place, _alone(mean + 1j * rate[place], receptance[alone])))
    # with D^-1 as of `State.inverse` at those lattice points
    parts = list[tuple[slice | Index, Operator, Array, Array]]()
    for place, force in forces:
        some = contiguous(place)
        parts.append((some, force, at.inverse[0][some], np.ascontiguousarray(at.inverse[1][:, some])))
    from_mode = np.ascontiguousarray(gaps.T)

    def apply(right: Array) -> Array:
        """Product (2, J, n) with the approximate inverse."""
        result = right.copy()
        for some, force, straight, turned in parts:
            pulled = force(right[:, some] @ from_mode) @ pulls
            result[:, some] -= straight * pulled + turned * pulled[::-1]
        return result

    return apply


def _meshes(balance: Problem) -> tuple[Array, Array]:
    """Gaps and pulls (w, n) of whole meshes, their slices weighted by their stiffness k0, and of link rows."""
    rows, face, m = balance.rows, balance.face, len(balance.face.row)
    share = (rows.linear[:m] / face.total(rows.linear[:m])[face.row])[:, None]
    gaps, pulls = face.total(share * rows.gaps[:m]), face.total(share * rows.pulls[:m])
    if rows.links is None:
        return gaps, pulls
    return np.concatenate([gaps, rows.gaps[rows.count :]]), np.concatenate([pulls, rows.pulls[rows.count :]])


def _soft_points(at: State, gaps: Array, pulls: Array, T: Array) -> tuple[Index, ComplexArray, Array]:
    """Lattice points (k,) at which receptance times tangent T (J, w) matters.

    With them the receptance there (k, w, w) [m/N] and its largest product with T (k,).
    """
    real, imag = at.inverse[0], -at.inverse[1][0]
    # no product is above the sum over modes of its largest factors: most points are left out by that
    most = np.abs(gaps).max(axis=0) * np.abs(pulls).max(axis=0)
    bound = (np.hypot(real, imag) @ most) * T.max(axis=1)
    near = np.flatnonzero(bound > _SOFT * (1 - _ROUNDING))
    factor = np.stack([real[near], imag[near]])[:, :, None, :]
    real, imag = ((factor * gaps).reshape(-1, gaps.shape[1]) @ pulls.T).reshape(2, near.size, len(gaps), len(pulls))
    receptance = real + 1j * imag
    loop = (np.abs(receptance) * T[near][:, None, :]).max(axis=(1, 2))
    soft = loop > _SOFT
    return near[soft], receptance[soft], loop[soft]


def _coupling(balance: Problem, points: Index, tangent: Array, rate: Array) -> Array:
    """Amplitudes of the force per amplitude of the gap of every row: (2, k, 2, k, w) [N/m] for k lattice points.

    tangent : (N, w) over the samples.  rate : (k, w) dampers i w c of their mean [N/m].
    """
    order, counts = balance.grid.points[points], balance.grid.counts
    waves = np.fft.fftn(tangent.reshape(*counts, -1), axes=range(len(counts))) / len(tangent)

    def at(orders: Index) -> ComplexArray:
        """Amplitudes (k, k, w) of the tangent at orders (k, k, D), aliased as the samples alias them."""
        return np.asarray(waves[tuple(np.moveaxis(orders % np.array(counts), -1, 0))])

    less, more = at(order[:, None] - order), at(order[:, None] + order)
    result = np.empty((2, len(points), 2, len(points), tangent.shape[1]))
    result[0, :, 0], result[0, :, 1] = less.real + more.real, more.imag - less.imag
    result[1, :, 0], result[1, :, 1] = less.imag + more.imag, less.real - more.real
    origin = ~order.any(axis=1)
    result[0, origin] /= 2
    result[1, origin], result[:, :, 1, origin] = 0.0, 0.0
    place = np.arange(len(rate))
    result[0, place, 1, place] -= rate
    result[1, place, 0, place] += rate
    return result


def _factored(matrix: Array, receptance: ComplexArray) -> Operator:
    """(I + T P)^-1 T of a matrix T (2, k, 2, k, w) and receptances P (k, w, w): an operator on rows (2, k, w)."""
    k, c = receptance.shape[:2]
    real = np.array([[receptance.real, -receptance.imag], [receptance.imag, receptance.real]])
    whole = np.einsum("xapbm,pqbmn->xamqbn", matrix, real, optimize=True).reshape(2 * k * c, 2 * k * c)
    whole[np.diag_indices(2 * k * c)] += 1
    factors, pivots, _ = dgetrf(whole, overwrite_a=True)
    tangent = np.ascontiguousarray(matrix.reshape(2 * k, 2 * k, c).transpose(2, 0, 1))

    def force(gap: Array) -> Array:
        """Forces (2, k, w) of gaps (2, k, w)."""
        pressed = np.matmul(tangent, gap.reshape(2 * k, c).T[:, :, None])[:, :, 0].T
        return np.asarray(dgetrs(factors, pivots, pressed.ravel())[0].reshape(2, k, c))

    return force


def _alone(tangent: ComplexArray, receptance: ComplexArray) -> Operator:
    """(I + T P)^-1 T of tangents T (k, w) that couple no points: an operator on rows (2, k, w)."""
    k, c = tangent.shape
    small = np.linalg.solve(np.eye(c) + tangent[:, :, None] * receptance, tangent[:, :, None] * np.eye(c))
    # real form (k, 2 w, 2 w) of the complex matrices, for real and imaginary parts one after the other
    real = np.concatenate(
        [np.concatenate([small.real, -small.imag], axis=2), np.concatenate([small.imag, small.real], axis=2)], axis=1
    )

    def force(gap: Array) -> Array:
        """Forces (2, k, w) of gaps (2, k, w)."""
        pressed: Array = np.matmul(real, gap.transpose(1, 0, 2).reshape(k, 2 * c, 1))
        return pressed.reshape(k, 2, c).transpose(1, 0, 2)

    return force


# --- truncation -------------------------------------------------------------------------------------------------------


class TruncatedOrders(NamedTuple):
    """Orders of a grid, half of them along its last axis, that are no lattice points.

    place : (T,) which of them.  omega : (T,) at s = 1 [rad/s].  weight : (T,) of their squared amplitudes.
    kind : (T,) each mesh tone, combinations of mesh tones, each shaft tone.  kinds : how many of these.
    """

    place: Index
    omega: Array
    weight: Array
    kind: Index
    kinds: int


def truncated_orders(balance: Problem, tones: Array, *, mesh: int, orders: tuple[int, ...]) -> TruncatedOrders:
    """The orders that a balance drops.

    Parameters
    ----------
    tones : (D,) at s = 1 [rad/s], of which `mesh` are mesh tones.  orders : highest of each shaft tone.
    """
    counts, points = balance.grid.counts, balance.grid.points
    D = len(counts)
    axes = [np.rint(np.fft.fftfreq(count, 1 / count)).astype(np.int64) for count in counts]
    axes[-1] = np.arange(counts[-1] // 2 + 1)
    every = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, D)
    kept = np.zeros(tuple(axis.size for axis in axes), bool)
    for signed in (points, -points):
        half = signed[signed[:, -1] >= 0]
        kept[tuple((half % np.array(counts)).T)] = True
    place = np.flatnonzero(~kept.ravel())
    dropped = every[place]
    # the mesh tone, combination or shaft tone that leaves the lattice
    of_mesh = np.abs(dropped[:, :mesh])
    kind = np.where(np.count_nonzero(of_mesh, axis=1) > 1, mesh, np.argmax(of_mesh, axis=1))
    if orders:
        share = np.abs(dropped[:, mesh:]) / np.array(orders)
        kind = np.where(share.sum(axis=1) > 1 + _ROUNDING, mesh + 1 + np.argmax(share, axis=1), kind)
    return TruncatedOrders(
        place=place,
        omega=dropped @ tones[:D],
        weight=np.where(dropped[:, -1] > 0, 4.0, 2.0),
        kind=kind,
        kinds=mesh + 1 + len(orders),
    )


def truncation_residual(balance: Problem, at: State, truncated: TruncatedOrders) -> Array:
    """Norm of the motion that the forces would put on the orders dropped, by kind (kinds,) [root of energy]."""
    force, modal, rows = balanced_forces(balance, at), balance.modal, balance.rows
    live = force.any(axis=0)
    if not live.any():  # no row presses at any phase
        return np.zeros(truncated.kinds)
    box = force[:, live].reshape(*balance.grid.counts, -1)
    D = len(balance.grid.counts)
    dropped = fft.rfftn(box, axes=range(D), norm="forward").reshape(-1, box.shape[-1])[truncated.place]
    w = at.speed * truncated.omega[:, None]
    if rows.lag.any():
        dropped = dropped * (1 + 1j * w * rows.lag[live])
    square = np.abs(dropped @ rows.pulls[live]) ** 2
    square /= np.maximum((modal.squared - w**2) ** 2 + (w * modal.damping) ** 2, np.finfo(float).tiny)
    each = truncated.weight * square.sum(axis=1)
    return np.sqrt(np.bincount(truncated.kind, weights=each, minlength=truncated.kinds))


# A step fails when the corrector moves more than this part of it, or the tangent turns more than this (cosine): without
# these guards large steps jump over whole resonances with a clean residual (benchmarks/contact.py).
_FAR, _TURN = 0.5, float(np.cos(np.radians(30.0)))
# A step grows by this after so few Newton steps and so small a move, as a part of it.
_GROW, _QUICK, _NEAR = 1.4, 3, 0.2
# Newton steps of a corrector; residual of the GMRES of a bordered step per right side.
_NEWTON, _BORDERED_FORCING = 10, 1e-3
# A fold is found when ds/d(length) is below this; so many steps at most, every third of which halves the interval.
_FLAT, _TRIES, _BISECT = 1e-3, 12, 3
# Times the interval about the highest point is halved.
_HALVED = 3

Score = Callable[[State, Problem], float]
"""What a branch has a peak of, such as a force [N]."""
Stop = Callable[["PathPoint"], bool]
"""Whether a branch ends at a point."""


class ArclengthUnit(NamedTuple):
    """Units of length of a path: motion [root of energy, as y], speed [relative]."""

    motion: float
    speed: float


class Stepping(NamedTuple):
    """Lengths of steps along a path: first, longest and shortest.

    guarded : whether far moves and sharp turns fail a step.  points : number after which a path ends.
    """

    first: float = 0.25
    longest: float = 0.5
    shortest: float = 1e-5
    guarded: bool = True
    points: int = 4000


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """What the points of a path share: the balance that they solve, units of length, and the preconditioner."""

    balance: Problem
    unit: ArclengthUnit
    kept: KeptPreconditioner


class Tangent(NamedTuple):
    """d(y / motion) (2, J, n) and d(s / speed) per length of a path, together of norm 1."""

    motion: Array
    speed: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PathPoint:
    """A point of a branch of solutions.

    state : the motion.  length : of the path up to here.  steps : Newton steps it took.
    """

    path: Path
    state: State
    tangent: Tangent
    length: float
    steps: int


def arclength_unit(low: float, high: float, motion: Array) -> ArclengthUnit:
    """Units of length for speeds in [low, high] about a motion (2, J, n).

    A sixteenth of the middle speed; a fifth of the mean motion, or of its dynamic size where the mean is zero.
    """
    size = float(np.linalg.norm(motion[:, 0])) or dynamic_size(motion)
    return ArclengthUnit(motion=size / 5, speed=float(np.sqrt(low * high)) / 16)


def start_of_path(balance: Problem, state: State, unit: ArclengthUnit) -> PathPoint:
    """The first point of a path: a solved state and its tangent, up in speed."""
    path = Path(balance, unit, KeptPreconditioner())
    tangent = _tangent(path, state, Tangent(np.zeros_like(state.y), 1.0))
    return PathPoint(path=path, state=state, tangent=tangent, length=0.0, steps=0)


def follow(
    start: PathPoint, low: float, high: float, *, stepping: Stepping, kept: KeptPart | None = None
) -> Iterator[PathPoint]:
    """Points of a branch from its start until it leaves [low, high] (the last may lie outside) or no step succeeds.

    kept : keeps the points, and has those from which a branch that was stopped goes on: with a preconditioner of its
        own, so that what follows agrees to the tolerance of a step.
    """
    at, size = start, stepping.first
    kept = kept or RunFolder().part("")
    yield at
    for number in range(stepping.points):
        if number in kept.known:
            y, speed, own, size = kept.known[number]
            after: PathPoint | None = PathPoint(path=at.path, state=evaluate(at.path.balance, y, speed), **own)
        else:
            after, size = _advance(at, size, stepping)
            if after is not None:
                own = {name: getattr(after, name) for name in ("tangent", "length", "steps")}
                kept.add(number, (after.state.y, after.state.speed, own, size))
        if after is None:
            return
        at = after
        yield at
        if not low <= at.state.speed <= high:
            return


def _advance(at: PathPoint, size: float, stepping: Stepping) -> tuple[PathPoint | None, float]:
    """The next point, None where even the shortest step fails, and the length of the step after it."""
    while size >= stepping.shortest:
        trial = step_from(at, size, guarded=stepping.guarded)
        if trial is not None:
            point, moved = trial
            quick = point.steps <= _QUICK and (moved < _NEAR * size or not stepping.guarded)
            return point, min(size * _GROW, stepping.longest) if quick else size
        size /= 2
    return None, size


def step_from(at: PathPoint, size: float, *, guarded: bool = True) -> tuple[PathPoint, float] | None:
    """One predictor-corrector step of a given length and how far its corrector moved, None where it fails."""
    unit = at.path.unit
    y = at.state.y + size * unit.motion * at.tangent.motion
    speed = at.state.speed + size * unit.speed * at.tangent.speed
    if speed <= 0:
        return None
    most = _FAR * size if guarded else np.inf
    solved = _corrected(at.path, y, speed, at.tangent, far=most)
    if solved is None:
        return None
    state, steps = solved
    moved = float(np.hypot(np.linalg.norm(state.y - y) / unit.motion, (state.speed - speed) / unit.speed))
    if guarded and moved > most:
        return None
    tangent = _tangent(at.path, state, at.tangent)
    turned = float(np.vdot(tangent.motion, at.tangent.motion)) + tangent.speed * at.tangent.speed
    if guarded and turned < _TURN:
        return None
    return PathPoint(path=at.path, state=state, tangent=tangent, length=at.length + size, steps=steps), moved


def _corrected(path: Path, y: Array, speed: float, tangent: Tangent, *, far: float) -> tuple[State, int] | None:
    """The solution on the plane through (y, s) normal to a tangent, by Newton's method.

    Parameters
    ----------
    far : length of the correction beyond which the step is given up.

    Returns
    -------
    (state, Newton steps), None where Newton's method fails.
    """
    balance, unit = path.balance, path.unit
    state, moved_y, moved_s = evaluate(balance, y, speed), np.zeros_like(y), 0.0
    for count in range(_NEWTON + 1):
        if not np.isfinite(state.norm):
            return None
        size = dynamic_size(state.y)
        if state.norm <= TOLERANCE * size:
            return state, count
        target = _TARGET * TOLERANCE * size / unit.motion
        step, ds = _bordered(path, state, tangent, state.residual / unit.motion, 0.0, target)
        moved_y, moved_s = moved_y + step, moved_s + ds
        if np.hypot(np.linalg.norm(moved_y), moved_s) > 2 * far or speed - moved_s * unit.speed <= 0:
            return None
        state = evaluate(balance, y - unit.motion * moved_y, speed - moved_s * unit.speed)
    return None


def _tangent(path: Path, state: State, side: Tangent) -> Tangent:
    """Unit tangent of the branch at a solved state, on the side of another one."""
    step, ds = _bordered(path, state, side, np.zeros_like(state.y), 1.0, 0.0)
    size = float(np.hypot(np.linalg.norm(step), ds))
    return Tangent(step / size, ds / size)


def _bordered(path: Path, at: State, tangent: Tangent, right: Array, last: float, target: float) -> tuple[Array, float]:
    """Solve [R_y R_s; tangent] (y, s) = (right, last) in scaled unknowns, to 1e-3 of the right side.

    right : (2, J, n).  target : norm of the residual that is enough.  Returns (y (2, J, n), s).
    """
    balance, unit, kept = path.balance, path.unit, path.kept
    shape, border = at.y.shape, tangent.motion.ravel()
    inverse, product = kept.at(balance, at), jacobian(balance, at)
    by_speed = (inverse(speed_derivative(balance, at)) * (unit.speed / unit.motion)).ravel()

    def apply(x: Array) -> Array:
        """Product (1, 2 J n + 1) with the preconditioned bordered matrix."""
        step, ds, out = x[0, :-1], float(x[0, -1]), np.empty_like(x)
        np.add(inverse(product(step.reshape(shape))).ravel(), ds * by_speed, out=out[0, :-1])
        out[0, -1] = border @ step + tangent.speed * ds
        return out

    whole = np.append(inverse(right).ravel(), last)
    wanted = max(_BORDERED_FORCING * float(np.linalg.norm(whole)), target)
    (x,), _, kept.calls = gmres(apply, whole[None], target=np.array([wanted]), restarts=3, checked=False)
    return x[:-1].reshape(shape), float(x[-1])


def branch(
    balance: Problem,
    start: State,
    *,
    low: float,
    high: float,
    unit: ArclengthUnit,
    stepping: Stepping,
    score: Score,
    stop: Stop | None = None,
    kept: KeptPart | None = None,
) -> list[PathPoint]:
    """Points of the branch through a solved state, up in speed, with its folds and its highest score among them.

    Parameters
    ----------
    score : what has a peak that must not be missed.  stop : ends the branch at a point before it leaves [low, high].
    kept : as of `follow`.
    """
    points = list[PathPoint]()
    for point in follow(start_of_path(balance, start, unit), low, high, stepping=stepping, kept=kept):
        points.append(point)
        if stop is not None and stop(point):
            break
    return _with_peak(_with_folds(points), score)


def folds_of_speed(speeds: list[float]) -> list[float]:
    """Speeds at which a rising or falling row of speeds turns round."""
    rise = np.diff(np.array(speeds))
    places = np.flatnonzero(np.sign(rise[1:]) != np.sign(rise[:-1])) + 1
    return [float(speeds[int(place)]) for place in places]


def _with_folds(points: list[PathPoint]) -> list[PathPoint]:
    """The points, with one more at every fold, where ds/d(length) is zero."""
    result = points[:1]
    for before, after in pairwise(points):
        if np.sign(before.tangent.speed) != np.sign(after.tangent.speed):
            fold = located(
                before, after, lambda point: point.tangent.speed, tolerance=_FLAT, tries=_TRIES, bisect=_BISECT
            )
            result += [] if fold is None else [fold]
        result.append(after)
    return result


def located(
    before: PathPoint,
    after: PathPoint,
    value: Callable[[PathPoint], float],
    *,
    tolerance: float,
    tries: int,
    bisect: int = 0,
) -> PathPoint | None:
    """The point between two of a branch at which a value is zero, by false position over the length of one step.

    Parameters
    ----------
    tolerance : |value| at which the point is found; after so many `tries` the last point stands.
    bisect : every so many tries the interval is halved instead, from the first one on; 0: never.

    Returns
    -------
    The last point reached, None where no step from the first one succeeds.
    """
    low, high, ends = 0.0, after.length - before.length, [value(before), value(after)]
    best: PathPoint | None = None
    for count in range(tries):
        halve = bisect > 0 and count % bisect == 0
        size = (low + high) / 2 if halve else low + (high - low) * ends[0] / (ends[0] - ends[1])
        trial = step_from(before, size)
        if trial is None:
            return best
        best, reached = trial[0], value(trial[0])
        if abs(reached) < tolerance:
            break
        if np.sign(reached) == np.sign(ends[0]):
            low, ends[0] = size, reached
        else:
            high, ends[1] = size, reached
    return best


def peak_of(points: list[PathPoint], score: Score) -> int:
    """Place of the highest score."""
    return int(np.argmax([score(point.state, point.path.balance) for point in points]))


def _with_peak(points: list[PathPoint], score: Score) -> list[PathPoint]:
    """The points, with more about the highest score, the steps there halved."""
    points = list(points)
    for _ in range(_HALVED):
        top = peak_of(points, score)
        for place in (top, top - 1):
            if 0 <= place < len(points) - 1:
                half = (points[place + 1].length - points[place].length) / 2
                middle = step_from(points[place], half) if half > 0 else None
                points[place + 1 : place + 1] = [] if middle is None else [middle[0]]
    return points
