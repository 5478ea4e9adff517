"""Harmonic balance of flanks that part and touch: residual and Jacobian.

In energy-weighted modal coordinates (see `questions.modes.eigen`) the residual at lattice points a is

    R = y + D^-1 [couple y + pulls^T {f(delta) - k0 B^T q - c0 (B^T q)'} - b],   D = omega_r^2 - w^2 + i w d_r

with w = s a . w_tone.  The force f is sampled over a grid of the tone phases and transformed back [cameron1989;
krack2019], with several incommensurate tones over the torus of their phases [lau1983].  No matrix is assembled: a
Jacobian-vector product is the same operation with the tangents of f.

Rows and laws: see `rows`.  A flank has f(delta, theta) + c delta' where delta is above first touch, else nothing
[kahraman1990]; the mean system holds k0 and c of the loaded flanks.  A link row has (1 + lag d/dt) f(delta); the mean
system holds its tangent at the mean load.

Shapes: J lattice points, n modal coordinates, F flanks, R rows of gaps, N samples, D phases.  A motion y is (2, J, n),
real and imaginary parts, the mean first, in roots of energy; rows of a gap or a force are (2 J, R).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...system.gaps import contiguous
from ...system.system import Array, Faces, Index, LinkRows, faces
from ..modes.eigen import Modal
from ..response.balance import diagonal_inverse, diagonal_product
from ..response.lattice import kept_points
from ..response.response import FrameSpeed, Response
from ..response.spectra import PlacedLine, placed
from .rows import (
    GapRows,
    Grid,
    GridLaws,
    WidthTangents,
    edges,
    gap_rows_of,
    grid,
    grid_laws,
    line_gaps,
    phases_of,
)

# Samples of a mesh cycle per harmonic where the caller names no number: contact that opens and closes has slow series,
# so the 2 per harmonic of the sampling theorem would alias the force.
_SAMPLES = 8
# Length within which a gap stands at first touch [m]: the rounding of displacements of millimetres.  Teeth that nothing
# presses together touch there by rule, not by the last bit.
_ROUNDING = 1e-18
# Part of the largest tangent of link rows within which one is constant: its rounding.
_CONSTANT = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Problem:
    """The balance of one System on one lattice: all that neither the motion nor the speed changes.

    grid : lattice points and samples.  omega : (J,) a . w_tone at s = 1 [rad/s].
    error : (2 J, R) of e in every row, the backlash in the mean [m].
    link_error : (2 J, p) of e in every linear link row [m, rad].
    force : (3, 2, J, n) external modal forces for s^0, s^1, s^2.
    laws : of the flanks over the grid.  tangent : (N, R) where contact is assumed: stiffness of a flank that touches,
        at the operating load, and of link rows [N/m].
    tones : (D,) angular frequencies of the phases of `grid` at s = 1 [rad/s].
    cycles : mesh cycles in a period, of which `omega` and the phases of `grid` are.
    face : the whole meshes of the rows.
    """

    modal: Modal
    rows: GapRows
    face: Faces
    grid: Grid
    omega: Array
    error: Array
    link_error: Array
    force: Array
    laws: GridLaws
    tangent: Array
    tones: Array
    frame_speed: FrameSpeed = "kinematic"
    cycles: int = 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class State:
    """A motion at a relative speed, with its residual and its contact.

    y : (2, J, n).  speed : s.  residual : (2, J, n) R.  inverse : D^-1, factors (J, n) of y and (2, J, n)
        of its rotated copy (-im, re); 0 for a rigid mean.
    touching : (N, F) whether each flank presses.  norm : |R|.  tangent : (N, R) of every row there [N/m].
    unchanging : whether tangents keep one value at each phase: the motion is that of a linear system.
    acting : (N, F) part of its sample in which each damper acts.  edge : (N, F) how that part rises with the gap, times
        the gap rate [1/s]; both None without dampers of meshes.
    width : tangents of samples at an edge of contact, by their width; None where there is none.
    """

    y: Array
    speed: float
    residual: Array
    inverse: tuple[Array, Array]
    touching: NDArray[np.bool_]
    tangent: Array
    unchanging: bool
    norm: float
    acting: Array | None = None
    edge: Array | None = None
    width: WidthTangents | None = None


def unknowns(problem: Problem) -> tuple[int, int, int]:
    """Shape (2, J, n) of a motion."""
    return 2, len(problem.omega), problem.modal.squared.size


def dynamic_size(y: Array) -> float:
    """Norm of the part of a motion (2, J, n) that varies, at least 1e-6 of the whole."""
    varying = float(np.linalg.norm(y[:, 1:]))
    return max(varying, 1e-6 * float(np.linalg.norm(y)), np.finfo(float).tiny)


def prolonged(balance: Problem, other: Problem, y: Array) -> Array:
    """A motion (2, J, n) of one problem on the J' points of another, (2, J', n): zero where the first has no point.

    The other period is as long, or holds the first a whole number of times.
    """
    return embedded(balance.grid.points, y, other, cycles=balance.cycles)


def embedded(points: Index, y: Array, balance: Problem, *, cycles: int = 1) -> Array:
    """A motion (2, J, n) at points (J, D') on the lattice of a problem, (2, J', n).

    Points of fewer phases count as of order 0 in the others.  Points that the problem lacks are left out; points that
    the motion lacks are 0.

    Parameters
    ----------
    cycles : mesh cycles in the period of the motion, a divisor of those of the problem.
    """
    times, D = balance.cycles // cycles, balance.grid.points.shape[1]
    places = {tuple(point): i for i, point in enumerate(balance.grid.points.tolist())}
    padding = (0,) * (D - points.shape[1])
    at = np.array([places.get((*(times * order for order in point), *padding), -1) for point in points.tolist()])
    result = np.zeros(unknowns(balance))
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
    kept = (harmonics,) * len(ready.lines.tones) if isinstance(harmonics, int) else harmonics
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
    rows, net = gap_rows_of(ready), grid(points, counts)
    error, link_error, force = _excitation(ready, points, rows, lines)
    # of flanks at the operating load, of link rows at the mean load
    phases = cycles * phases_of(counts)
    tangent = np.tile(rows.linear, (len(phases), 1))
    tangent[:, : rows.count] = rows.flanks.tangent.at(phases[:, rows.phases]).stiffness
    return Problem(
        modal=ready.modal,
        rows=rows,
        face=faces(ready.system.meshes),
        grid=net,
        omega=points @ tones,
        error=error,
        link_error=link_error,
        force=force,
        laws=grid_laws(rows, counts, cycles=cycles),
        tangent=tangent,
        tones=tones,
        frame_speed=ready.frame_speed,
        cycles=cycles,
    )


def _excitation(
    ready: Response, points: Index, rows: GapRows, lines: Sequence[PlacedLine]
) -> tuple[Array, Array, Array]:
    """Errors of the rows (2 J, R) and of links (2 J, p) [m], external modal forces (3, 2, J, n) at points (J, D)."""
    system = ready.system
    (error,) = placed(points, [lines], rows.linear.shape, lambda line: line_gaps(ready, rows, line))
    (link_error,) = placed(points, [lines], (len(system.links.name),), lambda line: line.link_gap)
    (force,) = placed(points, [lines], (3, system.force.size), lambda line: line.force)
    error[0, : rows.count] += rows.flanks.opening
    force[0, 0] += system.force
    error[0], link_error[0], force[0] = error[0].real, link_error[0].real, force[0].real
    modal_force = force.transpose(1, 0, 2) @ ready.modal.forces.T
    return (
        np.concatenate([error.real, error.imag]),
        np.concatenate([link_error.real, link_error.imag]),
        np.stack([modal_force.real, modal_force.imag], axis=1),
    )


def evaluate(balance: Problem, y: Array, speed: float, *, touching: NDArray[np.bool_] | None = None) -> State:
    """Residual of a motion y (2, J, n) at relative speed s.

    Parameters
    ----------
    touching : (N, F) or what broadcasts to it, the contact to assume, with the tangents of the problem; None: flanks
        and links follow their laws.
    """
    w = speed * balance.omega
    along, turn = diagonal_inverse(balance.modal, w[None])
    inverse = along[0, 0], turn[0]
    gap = gap_rows(balance, y)
    opened = gap - balance.error
    force, contact = _forces(balance, opened, speed) if touching is None else _assumed(balance, opened, speed, touching)
    excess = _excess_rows(balance, force, gap, opened, w)
    residual = y + diagonal_product(
        inverse, _couple(balance, y, speed) + _pull(balance, excess) - _force(balance, speed)
    )
    return State(
        y=y,
        speed=speed,
        residual=residual,
        inverse=inverse,
        norm=float(np.linalg.norm(residual)),
        **contact._asdict(),
    )


def jacobian(balance: Problem, at: State) -> Callable[[Array], Array]:
    """The Jacobian of the residual as an operator on steps (2, J, n) -> (2, J, n) [knoll2004].

    Rows that add nothing to it are left out of the transforms.  Laws are not asked: their tangents stand in the state.
    """
    rows, w = balance.rows, at.speed * balance.omega
    tangent, drag = at.tangent - rows.linear, None
    if at.acting is not None and at.edge is not None:
        # where contact opens or closes within a sample, its part closed rises with the gap
        tangent[:, : rows.count] += rows.damping * at.edge
        drag = np.zeros_like(tangent)
        drag[:, : rows.count] = rows.damping * at.acting - rows.drag
    live = contiguous(tangent.any(axis=0) if drag is None else tangent.any(axis=0) | drag.any(axis=0))
    pulls, lag = rows.pulls[live], rows.lag[live]
    tangent, drag = np.ascontiguousarray(tangent[:, live]), None if drag is None else drag[:, live]
    # one product takes a step to its gaps and to the couplings of modes
    still, turning = _coupling(balance, at.speed)
    n, R = at.y.shape[2], len(pulls)
    parts = [np.ascontiguousarray(rows.gaps[live].T), *(part for part in (still, turning) if part is not None)]
    matrix = np.concatenate(parts, axis=1)
    values, back, J = balance.grid.values, balance.grid.rows, w.size
    width = None
    if at.width is not None:
        # of every row its place among the live ones
        places = np.full(len(rows.linear), -1)
        places[live] = np.arange(R)
        sample, row = at.width.at
        width = replace(at.width, at=(sample, places[row]))
    column = w[:, None]

    def apply(step: Array) -> Array:
        """Jacobian-vector product of a step (2, J, n)."""
        product = step.reshape(-1, n) @ matrix
        gap = product[:, :R]
        force = values(gap)
        if width is None:
            force *= tangent
        else:
            edges_alone = width.forces(force)
            force *= tangent
            force[width.at] += edges_alone
        if drag is not None:
            force += drag * values(rate_rows(gap, w))
        pulled = _lagged(back(force), lag, w) @ pulls
        if still is not None:
            pulled += product[:, R : R + n]
        if turning is not None:
            turned = product[:, -n:]
            pulled[:J] -= column * turned[J:]
            pulled[J:] += column * turned[:J]
        return step + diagonal_product(at.inverse, pulled.reshape(step.shape))

    return apply


def speed_derivative(balance: Problem, at: State) -> Array:
    """dR/ds (2, J, n) with the motion held, at a state whose residual is zero."""
    y, s, omega, modal = at.y, at.speed, balance.omega, balance.modal
    w = s * omega
    turned = np.stack([-y[1], y[0]])
    moved = (-2 * w * omega)[:, None] * y + (omega[:, None] * modal.damping) * turned
    rate = 2 * s if balance.frame_speed == "kinematic" else 1.0
    frame = 1.0 if balance.frame_speed == "kinematic" else 0.0
    factors = {"G": rate * omega, "C": omega, "Kg": frame * 2 * s, "Cskew": frame}
    for name, matrix in modal.coupling.items():
        factor = np.asarray(factors[name])
        part = turned if name in ("G", "C") else y
        moved += (factor[..., None] * part if factor.ndim else factor * part) @ matrix
    moved -= balance.force[1] + 2 * s * balance.force[2]
    rows, gap = balance.rows, gap_rows(balance, y)
    if at.acting is not None:
        flanks = gap[:, : rows.count]
        opened = flanks - balance.error[:, : rows.count]
        damper = at.acting * rows.damping * balance.grid.values(rate_rows(opened, omega))
        damper -= rows.drag * balance.grid.values(rate_rows(flanks, omega))
        moved += (balance.grid.rows(damper) @ rows.pulls[: rows.count]).reshape(y.shape)
    if rows.lag.any():
        opened = gap - balance.error
        links = _link_excess(balance, balance.grid.rows(_forces(balance, opened, s)[0]), opened)
        lagging = rate_rows(rows.lag[rows.count :] * links, omega)
        moved += (lagging @ rows.pulls[rows.count :]).reshape(y.shape)
    return diagonal_product(at.inverse, moved)


def balanced_forces(balance: Problem, at: State) -> Array:
    """Force of every row in the balance (N, R) [N]: about edges of contact the share of a sample in the integral."""
    return _forces(balance, gap_rows(balance, at.y) - balance.error, at.speed)[0]


def gap_forces(balance: Problem, at: State) -> Array:
    """Forces of flanks and link rows at the samples (N, F + L) [N], the dampers of links left out."""
    opened, F = gap_rows(balance, at.y) - balance.error, balance.rows.count
    force = elastic_forces(balance, balance.grid.values(opened))
    if at.acting is not None:
        rate = rate_rows(opened[:, :F], at.speed * balance.omega)
        force[:, :F] += balance.rows.damping * balance.grid.values(rate) * at.touching
    return force


def link_rows(balance: Problem, links: LinkRows, y: Array, speed: float) -> Array:
    """Rows (2 J, p) of the forces of linear link rows [N, N m], dampers included, of a motion (2, J, n).

    As `questions.response.spectra.link_signal`.
    """
    w, gaps = speed * balance.omega, links.B.T @ balance.modal.shapes
    gaps[:, balance.modal.rigid] = 0.0
    moves: Array = y.reshape(-1, y.shape[2]) @ gaps.T
    stretch = moves - balance.link_error
    force = links.stiffness * stretch + rate_rows(links.damping * stretch, w)
    if links.skew.size:
        force += (speed if balance.frame_speed == "kinematic" else 1.0) * moves @ links.skew.T
    if links.preload.size:
        force[0] += links.preload
    return force


def flank_force(balance: Problem, at: State) -> Array:
    """Force of every flank over the grid of phases, (N, F) [N]."""
    return gap_forces(balance, at)[:, : balance.rows.count]


def elastic_forces(balance: Problem, delta: Array) -> Array:
    """Forces of flanks and link rows (N, F + L) [N] by their laws at gaps (N, R) [m], all dampers left out."""
    rows, F = balance.rows, balance.rows.count
    force, _ = balance.laws.evaluate(delta[:, :F])
    if rows.links is None:
        return force
    return np.concatenate([force, rows.links.force(delta[:, F : F + rows.links.rows.size])], axis=1)


def linearised_residual(balance: Problem, at: State, other: Problem) -> Array:
    """Residual (2, J, n) of another problem at the motion of a state, with forces linearised about that state.

    The problems differ in their errors and external forces alone.
    """
    rows, w, moved = balance.rows, at.speed * balance.omega, balance.error - other.error
    F = rows.count
    sampled = balance.grid.values(moved)
    force = at.tangent * sampled
    if at.acting is not None:
        force[:, :F] += at.acting * rows.damping * balance.grid.values(rate_rows(moved[:, :F], w))
    if at.width is not None:
        force[at.width.at] += at.width.forces(sampled)
    back = _lagged(balance.grid.rows(force), rows.lag, w)
    # the mean system holds the tangents of link rows, whose errors are forces on it
    back[:, F:] -= _lagged(rows.linear[F:] * moved[:, F:], rows.lag[F:], w)
    pushed = _force(other, at.speed) - _force(balance, at.speed)
    return at.residual + diagonal_product(at.inverse, _pull(balance, back) - pushed)


# --- forces of a motion -----------------------------------------------------------------------------------------------


class _Contact(NamedTuple):
    """Contact, tangents and damper shares as of `State`."""

    tangent: Array
    touching: NDArray[np.bool_]
    unchanging: bool
    acting: Array | None
    edge: Array | None
    width: WidthTangents | None


def _forces(balance: Problem, opened: Array, speed: float) -> tuple[Array, _Contact]:
    """Forces of the rows (N, R) [N] by the laws, from rows (2 J, R) of delta [m].

    Samples at an edge of contact as of `edges`.
    """
    rows = balance.rows
    F, last, J = rows.count, rows.count + (0 if rows.links is None else rows.links.rows.size), len(opened) // 2
    # a gap cannot rise above its mean and all amplitudes: far flanks mostly stay away
    reach = opened[0, :F] + np.hypot(opened[1:J, :F], opened[J + 1 :, :F]).sum(axis=0)
    reaching = reach > balance.laws.least_touch - _ROUNDING
    near, laws, damping = contiguous(reaching), balance.laws.of(reaching), rows.damping[reaching]
    delta = balance.grid.values(opened[:, near])
    force, tangent = np.zeros((2, len(delta), len(rows.linear)))
    if rows.links is not None:
        force[:, F:last], tangent[:, F:] = rows.links.evaluate(balance.grid.values(opened[:, F:last]))
    closed = laws.opening(delta)
    idle = lift_idle(delta, closed)
    pressed = np.zeros((len(delta), F), bool)
    pressed[:, near] = closed > 0
    edge = edges(closed, balance.grid.counts, rows.axis[near])
    if edge is not None:
        edge.enter_penetration(delta, closed)
    flank, slope = laws.evaluate(delta)
    flank[idle] = 0.0
    change = None if edge is None else edge.enter_means(flank, slope, laws.first_tangent)
    unchanging = edge is None and bool(np.all(pressed == pressed[:1]))
    if unchanging and not rows.parametric:
        unchanging = laws.constant(delta.min(axis=0), delta.max(axis=0))
    change_of_links = np.ptp(tangent[:, F:], axis=0)
    unchanging &= bool(np.all(change_of_links <= _CONSTANT * np.abs(rows.linear).max(initial=0.0)))
    acting, rise = None, None
    if rows.damping.any():  # the mean system has its dampers also where no flank is near
        rate = balance.grid.values(rate_rows(opened[:, near], speed * balance.omega))
        share, growth = pressed[:, near].astype(float), np.zeros_like(rate)
        if edge is not None and change is not None:
            share[edge.at], growth[edge.at] = edge.share, np.where(edge.inside, rate[edge.at] / edge.width, 0.0)
            change -= damping[edge.at[1]] * growth[edge.at] * (edge.share - 0.5)
        flank += damping * rate * share
        acting, rise = np.zeros((2, len(delta), F))
        acting[:, near], rise[:, near] = share, growth
    force[:, :F][:, near], tangent[:, :F][:, near] = flank, slope
    width = None if edge is None or change is None else edge.tangents(change, np.flatnonzero(reaching))
    return force, _Contact(tangent, pressed, unchanging, acting, rise, width)


def lift_idle(delta: Array, closed: Array) -> NDArray[np.bool_]:
    """Gaps within rounding of first touch, which are lifted to just above it: such flanks touch, without a force.

    Parameters
    ----------
    delta, closed : (..., F) gaps and what of them is above first touch [m], both changed.
    """
    idle: NDArray[np.bool_] = np.abs(closed) <= _ROUNDING
    if idle.any():
        delta[idle] += _ROUNDING - closed[idle]
        closed[idle] = _ROUNDING
    return idle


def _assumed(balance: Problem, opened: Array, speed: float, pattern: NDArray[np.bool_]) -> tuple[Array, _Contact]:
    """Forces of assumed contact (N, F) with the tangents of the problem, from rows (2 J, R) of delta [m]."""
    rows = balance.rows
    F, N = rows.count, len(balance.tangent)
    tangent = balance.tangent.copy()
    tangent[:, :F] = np.where(pattern, balance.tangent[:, :F], 0.0)
    live = contiguous(tangent.any(axis=0))
    force = np.zeros_like(tangent)
    force[:, live] = tangent[:, live] * balance.grid.values(opened[:, live])
    touching = np.broadcast_to(pattern, (N, F)).copy()
    if rows.links is not None:
        # the law at the mean load and the tangent from there on
        force[:, F : F + rows.links.rows.size] += rows.links.offset
    if not rows.damping.any():
        return force, _Contact(tangent, touching, True, None, None, None)
    rate = balance.grid.values(rate_rows(opened[:, :F], speed * balance.omega))
    acting = touching.astype(float)
    force[:, :F] += np.where(touching, rows.damping * rate, 0.0)
    return force, _Contact(tangent, touching, True, acting, np.zeros_like(acting), None)


# --- rows and products ------------------------------------------------------------------------------------------------


def _excess_rows(balance: Problem, force: Array, gap: Array, opened: Array, w: Array) -> Array:
    """Rows (2 J, R) [N] of forces (N, R) less what the mean system holds, of rows (2 J, R) of B^T q and delta [m]."""
    rows, live = balance.rows, contiguous(force.any(axis=0))
    back = np.zeros_like(gap)
    back[:, live] = balance.grid.rows(force[:, live])
    F = rows.count
    if rows.links is not None:
        back[:, F:] = _lagged(_link_excess(balance, back, opened), rows.lag[F:], w)
    back[:, :F] -= rows.linear[:F] * gap[:, :F]
    if rows.drag.any():
        back[:, :F] -= rows.drag * rate_rows(gap[:, :F], w)
    return back


def _link_excess(balance: Problem, back: Array, opened: Array) -> Array:
    """Forces of link rows (2 J, R - F) [N] less those of their tangents at the mean load, of forces and delta (2 J, R).

    The force of the mean system is that of the law at the mean load.
    """
    rows = balance.rows
    assert rows.links is not None
    excess: Array = back[:, rows.count :] - rows.linear[rows.count :] * opened[:, rows.count :]
    excess[0, : rows.links.rows.size] -= rows.links.offset
    return excess


def _lagged(rows: Array, lag: Array, w: Array) -> Array:
    """(1 + lag d/dt) of rows (2 J, c) at frequencies w (J,) [rad/s]; lag : (c,) [s]."""
    return rows + rate_rows(lag * rows, w) if lag.any() else rows


def rate_rows(rows: Array, w: Array) -> Array:
    """Rows (2 J, c) of the time derivative i w x of rows (2 J, c), at frequencies w (J,) [rad/s]."""
    J = w.size
    return np.concatenate([-w[:, None] * rows[J:], w[:, None] * rows[:J]])


def gap_rows(balance: Problem, y: Array) -> Array:
    """Rows (2 J, R) of B^T q [m], the gap of every row before errors, of a motion (2, J, n)."""
    return y.reshape(-1, y.shape[2]) @ balance.rows.gaps.T


def _pull(balance: Problem, rows: Array) -> Array:
    """Modal forces (2, J, n) of rows of forces (2 J, R) [N]."""
    return (rows @ balance.rows.pulls).reshape(unknowns(balance))


def _force(balance: Problem, speed: float) -> Array:
    """External modal forces (2, J, n) at a relative speed."""
    return np.asarray(balance.force[0] + speed * (balance.force[1] + speed * balance.force[2]))


def _couple(balance: Problem, y: Array, speed: float) -> Array:
    """Coupling of modes (2, J, n) by G, Kg, Cskew and the dampers off the diagonal, at a relative speed."""
    still, turning = _coupling(balance, speed)
    result: Array = np.zeros_like(y) if still is None else y @ still
    if turning is not None:
        turned = y @ turning
        w = speed * balance.omega[:, None]
        result[0] -= w * turned[1]
        result[1] += w * turned[0]
    return result


def _coupling(balance: Problem, speed: float) -> tuple[Array | None, Array | None]:
    """Matrices (n, n) that couple modes at a relative speed: by their amplitudes, and by their rates; None: nothing."""
    frame = speed if balance.frame_speed == "kinematic" else 1.0
    factors = {"G": frame, "C": 1.0, "Kg": frame**2, "Cskew": frame}
    matrices = balance.modal.coupling

    def together(*names: str) -> Array | None:
        parts = [factors[name] * matrices[name] for name in names if name in matrices]
        return reduce(np.add, parts) if parts else None

    return together("Kg", "Cskew"), together("G", "C")
