"""Harmonic balance of flanks that part and touch: residual, Jacobian, lattices of mesh and shaft tones.

In energy-weighted modal coordinates (see `analyses.modes.basis`) the residual at lattice points a is

    R = y + D^-1 [couple y + pulls^T {f(delta) - k0 B^T q - c0 (B^T q)'} - b],   D = omega_r^2 - w^2 + i w d_r

with w = s a . w_tone.  The force f is sampled over a grid of the tone phases and transformed back [cameron1989;
krack2019], with several incommensurate tones over the torus of their phases [lau1983].  No matrix is assembled: a
Jacobian-vector product is the same operation with the tangents of f.

ModalFlanks: every mesh row on its loaded flank, and on its far flank where the backlash is finite.  All follow one law,
f = k(theta) delta + c delta' where delta > 0, else nothing [kahraman1990].  The mean system holds k0 and c of the
loaded flanks.  A far flank is a row of its own, because its normal is not the opposite of the loaded one, and is open
by the backlash (docs/conventions.md).

Shapes: J lattice points, n modal coordinates, R flanks, N samples, D phases.  A motion y is (2, J, n), real and
imaginary parts, the mean first, in roots of energy; rows of a gap or a force are (2 J, R).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...system.faces import Faces, faces
from ...system.system import Array, ComplexArray, Line
from ..modes.basis import Modal
from ..steady.lattice import Point, kept_points
from ..steady.response import FrameSpeed, Response
from .transforms import Transforms, grid

__all__ = [
    "ModalFlanks",
    "PlacedLine",
    "Problem",
    "Size",
    "State",
    "dynamic_size",
    "embedded",
    "evaluate",
    "flank_force",
    "flanks",
    "gap_rows",
    "half_lattice",
    "jacobian",
    "mesh_points",
    "mesh_problem",
    "order_weight",
    "placed_line",
    "problem",
    "prolonged",
    "rate_rows",
    "speed_derivative",
    "torus_points",
    "unknowns",
]


Index = NDArray[np.int64]
PlacedLine = tuple[Point, bool, Line]
"""A line at a lattice point, and whether its conjugate counts there."""

# Samples of a mesh cycle per harmonic where the caller names no number: contact that opens and closes has slow series,
# so the 2 per harmonic of the sampling theorem would alias the force.
_SAMPLES = 8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModalFlanks:
    """R flanks: the loaded ones of the m mesh rows, then the far ones.

    gaps, pulls : (R, n) as of `Modal`.  linear, drag : (R,) stiffness [N/m] and damping [N s/m] in the mean system.
    stiffness, damping : (R,) mean of the law [N/m, N s/m].  variation : (R, L) per mean, as of `MeshRows`.
    axis : (R,) the mesh tone.  mesh : (R,) the mesh row.  sense : (R,) +1 loaded, -1 far flank.
    opening : (R,) backlash of a far flank [m], else 0.
    """

    gaps: Array
    pulls: Array
    linear: Array
    drag: Array
    stiffness: Array
    damping: Array
    variation: ComplexArray
    axis: NDArray[np.int64]
    mesh: NDArray[np.int64]
    sense: Array
    opening: Array


def flanks(ready: Response) -> ModalFlanks:
    """The R flanks of a System ready for its response."""
    modal, meshes, far = ready.modal, ready.system.meshes, ready.system.far_flanks
    m, own = len(meshes.name), far.mesh
    gaps, pulls = far.B.T @ modal.shapes, (modal.forces @ far.B).T
    gaps[:, modal.rigid] = pulls[:, modal.rigid] = 0.0
    nothing = np.zeros(own.size)
    return ModalFlanks(
        gaps=np.concatenate([modal.gaps, gaps]),
        pulls=np.concatenate([modal.pulls, pulls]),
        linear=np.concatenate([meshes.stiffness, nothing]),
        drag=np.concatenate([meshes.damping, nothing]),
        stiffness=np.concatenate([meshes.stiffness, meshes.stiffness[own]]),
        damping=np.concatenate([meshes.damping, meshes.damping[own]]),
        variation=np.concatenate([meshes.variation, far.variation]),
        axis=np.concatenate([ready.lines.axis, ready.lines.axis[own]]),
        mesh=np.concatenate([np.arange(m), own]),
        sense=np.concatenate([np.ones(m), -np.ones(own.size)]),
        opening=np.concatenate([np.zeros(m), meshes.backlash[own]]),
    )


class Size(NamedTuple):
    """Rows of a torus: harmonics of each mesh tone, order of their combinations, highest order of each shaft tone."""

    harmonics: tuple[int, ...]
    cross: int
    orders: tuple[int, ...]


def mesh_points(size: Size) -> Index:
    """Lattice points (J, D) of the D mesh tones alone."""
    return torus_points(size._replace(orders=()))


def torus_points(size: Size) -> Index:
    """Lattice points (J, D) of mesh and shaft tones, one of a and -a, the origin first.

    Mesh points as of `kept_points`, each with all shaft orders |s_1| / H_1 + |s_2| / H_2 + .. <= 1 (derived here).
    """
    mesh = kept_points(size.harmonics, size.cross, mirrored=False).points.tolist()
    reach = product(*(range(-order, order + 1) for order in size.orders))
    of_shafts = [orders for orders in reach if order_weight(orders, size.orders) <= 1]
    every = [(*a, *s) for a in mesh for s in of_shafts]
    return half_lattice(every)


def order_weight(point: tuple[int, ...], orders: tuple[int, ...]) -> float:
    """|s_1| / H_1 + |s_2| / H_2 + .. of shaft orders (S,) and their highest (S,), without its rounding."""
    return round(sum(abs(s) / order for s, order in zip(point, orders, strict=True)), 9)


def half_lattice(points: Sequence[Point]) -> Index:
    """The points (J, D) of a lattice that stand for a real signal: one of a and -a, the origin first."""
    leading = [point for point in points if _leads(point)]
    return np.array(sorted(leading, key=lambda point: (any(point), point)), dtype=np.int64)


def placed_line(point: Point, line: Line) -> PlacedLine:
    """A line at the point a, or as its conjugate at -a, whichever half of the lattice holds."""
    leads = _leads(point)
    return point if leads else tuple(-a for a in point), not leads, line


def _leads(point: Point) -> bool:
    """Whether a stands for itself and -a: its first order that is not 0 is positive."""
    return next((a for a in point if a), 1) > 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Problem:
    """The balance of one System on one lattice: all that neither the motion nor the speed changes.

    grid : lattice points and samples.  omega : (J,) a . w_tone at s = 1 [rad/s].
    error : (2 J, R) rows of e of every flank, the backlash in the mean [m].
    force : (3, 2, J, n) external modal forces for s^0, s^1, s^2.  stiffness : (N, R) of every flank [N/m].
    tones : (D,) angular frequencies of the phases of `grid` at s = 1 [rad/s].
    cycles : mesh cycles in a period, of which `omega` and the phases of `grid` are.
    face : the whole meshes of the rows.
    """

    modal: Modal
    flanks: ModalFlanks
    face: Faces
    grid: Transforms
    omega: Array
    error: Array
    force: Array
    stiffness: Array
    tones: Array
    frame_speed: FrameSpeed = "kinematic"
    cycles: int = 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class State:
    """A motion at a relative speed, with its residual and its contact.

    y : (2, J, n).  speed : s.  residual : (2, J, n) R.  inverse : D^-1 as of `_inverse`.
    touching : (N, R) whether each flank presses.  norm : |R|.
    acting : (N, R) part of its sample in which each damper acts.  edge : (N, R) how that part rises with the gap, times
        the gap rate [1/s]; both None without dampers of meshes.
    """

    y: Array
    speed: float
    residual: Array
    inverse: tuple[Array, Array]
    touching: NDArray[np.bool_]
    norm: float
    acting: Array | None = None
    edge: Array | None = None

    @property
    def unchanging(self) -> bool:
        """Whether every flank touches all the time or never."""
        return bool(np.all(self.touching == self.touching[0]))


def unknowns(problem: Problem) -> tuple[int, int, int]:
    """Shape (2, J, n) of a motion."""
    return 2, len(problem.omega), problem.modal.squared.size


def dynamic_size(y: Array) -> float:
    """Norm of the part of a motion (2, J, n) that varies, at least 1e-6 of the whole."""
    varying = float(np.linalg.norm(y[:, 1:]))
    return max(varying, 1e-6 * float(np.linalg.norm(y)), np.finfo(float).tiny)


def prolonged(given: Problem, other: Problem, y: Array) -> Array:
    """A motion (2, J, n) of one problem on the J' points of another, (2, J', n): zero where the first has no point.

    The other period is as long, or holds the first a whole number of times.
    """
    return embedded(given.grid.points, y, other, cycles=given.cycles)


def embedded(points: Index, y: Array, given: Problem, *, cycles: int = 1) -> Array:
    """A motion (2, J, n) at points (J, D') on the lattice of a problem, (2, J', n).

    Points of fewer phases count as of order 0 in the others.  Points that the problem lacks are left out; points that
    the motion lacks are 0.

    Parameters
    ----------
    cycles : mesh cycles in the period of the motion, a divisor of those of the problem.
    """
    times, D = given.cycles // cycles, given.grid.points.shape[1]
    place = {tuple(point): i for i, point in enumerate(given.grid.points.tolist())}
    padding = (0,) * (D - points.shape[1])
    at = np.array([place.get((*(times * order for order in point), *padding), -1) for point in points.tolist()])
    result = np.zeros(unknowns(given))
    result[:, at[at >= 0]] = y[:, at >= 0]
    return result


def mesh_problem(
    ready: Response,
    *,
    harmonics: int | tuple[int, ...],
    cross: int = 0,
    samples: int | None = None,
    cycles: int = 1,
) -> Problem:
    """The balance of mesh orders: multiples of every tone up to `harmonics`, combinations up to `cross`.

    Parameters
    ----------
    harmonics : of every tone, or of each (D,).  samples : of the mesh cycle of each tone; None takes 8 per harmonic.
    cycles : mesh cycles of a period; more than one for motions that repeat after as many, with fractional orders.
    """
    tones = len(ready.lines.tones)
    kept = (harmonics,) * tones if isinstance(harmonics, int) else harmonics
    points = kept_points(tuple(cycles * each for each in kept), cross, mirrored=True).points
    counts = tuple(cycles * (samples or _SAMPLES * each) for each in kept)
    lines = [(tuple(cycles * order for order in point), False, line) for point, line in ready.lines.mesh]
    return problem(ready, points, ready.omega / cycles, counts, lines, cycles=cycles)


def problem(
    ready: Response,
    points: Index,
    tones: Array,
    counts: tuple[int, ...],
    lines: Sequence[PlacedLine],
    *,
    cycles: int = 1,
) -> Problem:
    """The balance on given lattice points.

    Parameters
    ----------
    points : (J, D), one of a and -a, the origin first.
    tones : (D,) at s = 1 [rad/s], the mesh tones first, then the shaft tones.
    counts : (D,) samples of each phase.  lines : (point, whether the conjugate counts there, line).
    cycles : mesh cycles in a period of `tones`.
    """
    flank, net = flanks(ready), grid(points, counts)
    error, force = _excitation(ready, points, flank, lines)
    return Problem(
        modal=ready.modal,
        flanks=flank,
        face=faces(ready.system.meshes),
        grid=net,
        omega=points @ tones,
        error=error,
        force=force,
        stiffness=_stiffness(flank, cycles * net.phases),
        tones=tones,
        frame_speed=ready.frame_speed,
        cycles=cycles,
    )


def _stiffness(flank: ModalFlanks, phases: Array) -> Array:
    """Stiffness of every flank (N, R) [N/m] at phases (N, D) of the tones [cycles]."""
    result = np.empty((len(phases), flank.mesh.size))
    orders = np.arange(1, flank.variation.shape[1] + 1)
    for axis in np.unique(flank.axis):
        mine = flank.axis == axis
        wave = np.exp(2j * np.pi * np.outer(phases[:, axis], orders))
        result[:, mine] = flank.stiffness[mine] * (1 + (wave @ flank.variation[mine].T).real)
    return result


def _excitation(ready: Response, points: Index, flank: ModalFlanks, lines: Sequence[PlacedLine]) -> tuple[Array, Array]:
    """Errors of the flanks (2 J, R) [m] and external modal forces (3, 2, J, n) at points (J, D)."""
    system, place = ready.system, {tuple(point): i for i, point in enumerate(points.tolist())}
    error = np.zeros((len(points), flank.mesh.size), complex)
    force = np.zeros((3, len(points), system.force.size), complex)
    force[0, 0] = system.force
    for point, conjugate, line in lines:
        at, gap, push = place[point], system.flank_gaps(line), line.force
        error[at] += gap.conj() if conjugate else gap
        force[:, at] += push.conj() if conjugate else push
    error[0] += flank.opening
    error[0], force[:, 0] = error[0].real, force[:, 0].real
    modal_force = force @ ready.modal.forces.T
    return np.concatenate([error.real, error.imag]), np.stack([modal_force.real, modal_force.imag], axis=1)


def evaluate(given: Problem, y: Array, speed: float, *, touching: NDArray[np.bool_] | None = None) -> State:
    """Residual of a motion y (2, J, n) at relative speed s.

    Parameters
    ----------
    touching : (N, R) or what broadcasts to it, the contact to assume; None: flanks touch where their gap is closed.
    """
    w = speed * given.omega
    inverse = _inverse(given.modal, w)
    gap = gap_rows(given, y)
    law = _contact_law(given, gap - given.error, speed, touching)
    unbalanced = _couple(given, y, speed) + _pull(given, _excess_rows(given, law.force, gap, w)) - _force(given, speed)
    residual = y + _times(inverse, unbalanced)
    return State(
        y=y,
        speed=speed,
        residual=residual,
        inverse=inverse,
        touching=law.touching,
        norm=float(np.linalg.norm(residual)),
        acting=law.acting,
        edge=law.edge,
    )


def jacobian(given: Problem, at: State) -> Callable[[Array], Array]:
    """The Jacobian of the residual as an operator on steps (2, J, n) -> (2, J, n) [knoll2004].

    ModalFlanks that add nothing to it are left out of the transforms.
    """
    flank, w = given.flanks, at.speed * given.omega
    tangent, drag = np.where(at.touching, given.stiffness, 0.0) - flank.linear, None
    if at.acting is not None and at.edge is not None:
        # where the contact opens or closes within a sample, c delta' a rises with both: a = 1/2 + delta / (|delta'| h)
        rate = np.where((at.acting > 0) & (at.acting < 1), 0.5, at.acting)
        tangent = tangent + flank.damping * at.edge
        drag = flank.damping * rate - flank.drag
    live = _columns(tangent.any(axis=0) if drag is None else tangent.any(axis=0) | drag.any(axis=0))
    gaps, pulls = np.ascontiguousarray(flank.gaps[live].T), flank.pulls[live]
    tangent, drag = tangent[:, live], None if drag is None else drag[:, live]

    def apply(step: Array) -> Array:
        """Jacobian-vector product of a step (2, J, n)."""
        gap = step.reshape(-1, step.shape[2]) @ gaps
        force = given.grid.values(gap)
        force *= tangent
        if drag is not None:
            force += drag * given.grid.values(rate_rows(gap, w))
        pulled = _couple(given, step, at.speed)
        pulled += (given.grid.rows(force) @ pulls).reshape(step.shape)
        return step + _times(at.inverse, pulled)

    return apply


def speed_derivative(given: Problem, at: State) -> Array:
    """dR/ds (2, J, n) with the motion held, at a state whose residual is zero."""
    y, s, omega, modal = at.y, at.speed, given.omega, given.modal
    w = s * omega
    turned = np.stack([-y[1], y[0]])
    moved = (-2 * w * omega)[:, None] * y + (omega[:, None] * modal.damping) * turned
    rate = 2 * s if given.frame_speed == "kinematic" else 1.0
    frame = 1.0 if given.frame_speed == "kinematic" else 0.0
    factors = {"G": rate * omega, "C": omega, "Kg": frame * 2 * s, "Cskew": frame}
    for name, matrix in modal.coupling.items():
        factor = np.asarray(factors[name])
        part = turned if name in ("G", "C") else y
        moved += (factor[..., None] * part if factor.ndim else factor * part) @ matrix
    moved -= given.force[1] + 2 * s * given.force[2]
    flank = given.flanks
    if at.acting is not None:
        gap = gap_rows(given, y)
        damper = at.acting * flank.damping * given.grid.values(rate_rows(gap - given.error, omega))
        damper -= flank.drag * given.grid.values(rate_rows(gap, omega))
        moved += _pull(given, given.grid.rows(damper))
    return _times(at.inverse, moved)


def flank_force(given: Problem, at: State) -> Array:
    """Force of every flank over the grid of phases, (N, R) [N]."""
    gap = gap_rows(given, at.y) - given.error
    return _contact_law(given, gap, at.speed, None).force


class _ContactLaw(NamedTuple):
    """Forces of the flanks (N, R) [N] with contact and damper shares as of `State`."""

    force: Array
    touching: NDArray[np.bool_]
    acting: Array | None
    edge: Array | None


def _contact_law(given: Problem, opened: Array, speed: float, pattern: NDArray[np.bool_] | None) -> _ContactLaw:
    """Contact law k delta + c delta' where delta > 0, or where a pattern (N, R) says, from rows (2 J, R) of delta [m].

    A damper that acts at once would make the force jump where teeth meet, and the sum over samples with it.  The damper
    acts for the part of its sample in which the gap, continued linearly, is closed: the force stays continuous (derived
    here).
    """
    near = _columns(_reaching(opened) if pattern is None else pattern.any(axis=0))
    delta, force = given.grid.values(opened[:, near]), np.zeros_like(given.stiffness)
    touching, pressed = np.zeros(force.shape, bool), delta > 0 if pattern is None else pattern[:, near]
    touching[:, near] = pressed
    pushed = np.where(pressed, given.stiffness[:, near] * delta, 0.0)
    if not given.flanks.damping.any():
        force[:, near] = pushed
        return _ContactLaw(force, touching, None, None)
    rate = given.grid.values(rate_rows(opened[:, near], speed * given.omega))
    part, rise = pressed.astype(float), np.zeros_like(delta)
    if pattern is None:
        sample = (2 * np.pi / (speed * given.tones * given.grid.counts))[given.flanks.axis[near]]
        travel = np.abs(rate) * sample
        place = np.divide(delta, travel, out=np.full_like(delta, np.inf), where=travel > 0)
        inside = np.abs(place) < 0.5
        part = np.where(inside, 0.5 + np.where(inside, place, 0.0), part)
        rise = np.where(inside, np.sign(rate) / sample, 0.0)
    acting, edge = np.zeros_like(force), np.zeros_like(force)
    acting[:, near], edge[:, near] = part, rise
    force[:, near] = pushed + given.flanks.damping[near] * rate * part
    return _ContactLaw(force, touching, acting, edge)


def _excess_rows(given: Problem, force: Array, gap: Array, w: Array) -> Array:
    """Rows (2 J, R) [N] of flank forces (N, R) less what the mean system holds, of gap rows (2 J, R) [m]."""
    flank, live = given.flanks, _columns(force.any(axis=0))
    rows = np.zeros_like(gap)
    rows[:, live] = given.grid.rows(force[:, live])
    rows -= flank.linear * gap
    if flank.drag.any():
        rows -= flank.drag * rate_rows(gap, w)
    return rows


def _columns(chosen: NDArray[np.bool_] | np.bool_) -> slice | Index:
    """Places of chosen columns (R,): a slice, of which numpy makes no copy, where they stand together."""
    places = np.flatnonzero(chosen)
    together = places.size == 0 or places[-1] - places[0] + 1 == places.size
    return slice(*(places[[0, -1]] + [0, 1])) if together and places.size else places


def _reaching(opened: Array) -> NDArray[np.bool_]:
    """ModalFlanks (R,) whose delta, of rows (2 J, R), can rise above 0 at all: its mean and all amplitudes."""
    J = len(opened) // 2
    reach: Array = opened[0] + np.hypot(opened[1:J], opened[J + 1 :]).sum(axis=0)
    return reach > 0


def rate_rows(rows: Array, w: Array) -> Array:
    """Rows (2 J, c) of the time derivative i w x of rows (2 J, c), at frequencies w (J,) [rad/s]."""
    J = w.size
    return np.concatenate([-w[:, None] * rows[J:], w[:, None] * rows[:J]])


def gap_rows(given: Problem, y: Array) -> Array:
    """Rows (2 J, R) of B^T q [m], the gap of every flank before errors, of a motion (2, J, n)."""
    gap: Array = y.reshape(-1, y.shape[2]) @ given.flanks.gaps.T
    return gap


def _pull(given: Problem, rows: Array) -> Array:
    """Modal forces (2, J, n) of rows of flank forces (2 J, R) [N]."""
    return (rows @ given.flanks.pulls).reshape(unknowns(given))


def _force(given: Problem, speed: float) -> Array:
    """External modal forces (2, J, n) at a relative speed."""
    force: Array = given.force[0] + speed * (given.force[1] + speed * given.force[2])
    return force


def _couple(given: Problem, y: Array, speed: float) -> Array:
    """Coupling of modes (2, J, n) by G, Kg, Cskew and the dampers off the diagonal, at a relative speed."""
    frame = speed if given.frame_speed == "kinematic" else 1.0
    w = speed * given.omega[:, None]
    result = np.zeros_like(y)
    for name, matrix in given.modal.coupling.items():
        if name in ("G", "C"):
            factor = w * (frame if name == "G" else 1.0)
            result += np.stack([-factor * y[1], factor * y[0]]) @ matrix
        else:
            result += (frame**2 if name == "Kg" else frame) * (y @ matrix)
    return result


def _inverse(modal: Modal, w: Array) -> tuple[Array, Array]:
    """D^-1 at w (J,) [rad/s]: factors (J, n) of y and (2, J, n) of its rotated copy (-im, re); 0 for a rigid mean."""
    w = w[:, None]
    real, imag = modal.squared - w**2, w * modal.damping
    size = real**2 + imag**2
    size[size == 0] = np.inf
    turn = imag / size
    return real / size, np.stack([turn, -turn])


def _times(factor: tuple[Array, Array], y: Array) -> Array:
    """Product (2, J, n) of factors as of `_inverse` and y (2, J, n)."""
    out = factor[0] * y
    out += factor[1] * y[::-1]
    return out
