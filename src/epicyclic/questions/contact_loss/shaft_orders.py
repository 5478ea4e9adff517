"""Shaft orders on motions of mesh orders: superposed lines, and the torus where these part or close a flank.

A superposed line responds alone, linearly, to flanks that touch when they do without it.  That is exact as long as no
flank parts or closes because of the lines, whatever their number and that of the mesh tones.  Where one does, it is
the answer to first order for lines that are small (derived here).

The linear response is a point of the torus too, exact where no flank parts or closes at any phase.  It keeps as many
harmonics and combinations as its own truncation residual asks for, far more than a balance of contact can afford with
two mesh frequencies.  Where contact is the same at every phase and tangents are those of the linear system, it is the
motion itself; elsewhere it tells what the rows of the balance miss of it.

Outputs of the torus: forces of flanks, rows and whole meshes, their statistics, amplitudes.  Means are over all phases,
or along one super-period where that is short, and extremes are over all relative phases (derived here).  Shapes: R
flanks, m mesh rows, w whole meshes, n coordinates, N samples, D phases.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import lcm, prod
from typing import NamedTuple

import numpy as np

from ...statics.signals import peaks_to_peaks
from ...system.system import Array, ComplexArray, Index, faces
from ..response.measures import Range, held_pairs, link_statistics, mean_square
from ..response.response import Block, Response, respond, unstable_speeds
from ..response.spectra import (
    Shaft,
    alias_free_samples,
    force_signal,
    lateral_pairs,
    link_spectrum,
    motion_spectrum,
    peak,
    placed,
    strained,
    whole_mesh_signal,
)
from .branch_set import Measures, mesh_force, row_force, touching_meshes
from .continuation import linear_start, newton_step
from .problem import (
    Problem,
    State,
    dynamic_size,
    elastic_forces,
    embedded,
    evaluate,
    flank_force,
    gap_forces,
    gap_rows,
    link_rows,
    problem,
    rate_rows,
)
from .rows import Size, half_lattice, line_gaps, mesh_points, placed_line, reported_links, with_diagonals
from .solutions import Solution
from .torus import Torus, TorusPoint, memory, respond_torus

# Samples of the phase of a line: the linear response has its order 1 alone, and four make its quadratures differences.
_SAMPLES = 4
# Relative residual of the linear solution, as of the linear response of `questions.response`.
_TOLERANCE = 1e-8
# Part of the dynamic size that the torus's own mesh orders may be away from the motion reached; farther is another
# branch.
_NEAR = 0.02
# Part of its own force (RMS) that a line superposed on varying tangents may miss: as good as the refinement.
_CURVED = 1e-3
# Error of a line superposed on laws of links or tables, per its own force (RMS), from which it is no answer.
_MEANINGLESS = 0.5
# An error of a superposed line below this is none: rounding.
NEGLIGIBLE = 1e-9
# Relative residual of the linear response, as of the linear steady state, and the largest that is no failure.
_LINEAR_TOLERANCE, _ACCEPTED = 1e-6, 1e-4
# Samples of a mesh phase, by the number of mesh tones: a parabola through the largest one is then within 1e-4 of the
# largest force (145 samples of two phases were 5e-3 away).
_WANTED = {1: 512, 2: 256}
# Doubles on a grid of all mesh phases, at most: 1 GB.
_MOST = 2**27

# Directions [rad] along which the largest lateral force of a link is looked for, a parabola between them: 1e-5.
_TOWARDS = 2 * np.pi * np.arange(48) / 48
# Instants of a super-period that are looked at one by one, at most; a longer one fills the torus evenly enough.
_INSTANTS = 8192

# --- superposed lines -------------------------------------------------------------------------------------------------


class SuperposedLine(NamedTuple):
    """Response to the lines of one group, Re(amplitude exp(i w_s t)), amplitudes over N phases of the mesh tones.

    shaft : the lines.  stretch : (N, R) of delta of every flank [m].  force : (N, R) of its force [N].
    motion : (N, n) of every coordinate [m].  links : (N, p) of the force of every link row [N, N m].
    error : RMS of what the law makes of the stretch otherwise, per the force.
    """

    shaft: Shaft
    stretch: ComplexArray
    force: ComplexArray
    motion: ComplexArray
    links: ComplexArray
    error: float


def superposed_lines(torus: Torus, point: TorusPoint) -> list[SuperposedLine]:
    """The linear response of every group of lines that is not on the torus."""
    return [_line_response(torus, point, shaft) for shaft in torus.shaft_tones.superposed]


def superposition_is_exact(point: TorusPoint, lines: Sequence[SuperposedLine]) -> bool:
    """Whether no flank of a motion of mesh orders parts or closes whatever the phases of the lines.

    With laws whose tangents vary: and what the lines miss of their own forces is below 1e-3.
    """
    balance, delta = point.problem, _gap_values(point)[:, : point.problem.rows.count]
    reach = sum((np.abs(line.stretch) for line in lines), np.zeros_like(delta))
    touching, opening = point.state.touching, balance.laws.opening(delta)
    always, never = touching.all(axis=0), ~touching.any(axis=0)
    kept = np.where(always, (opening > reach).all(axis=0), never & (opening < -reach).all(axis=0))
    if balance.rows.parametric or not kept.all():
        return bool(kept.all())
    return max((line.error for line in lines), default=0.0) <= _CURVED


def superposition_is_an_answer(point: TorusPoint, lines: Sequence[SuperposedLine]) -> bool:
    """Whether lines superposed on laws of links or tables are an answer to first order.

    They are none where a line moves a link through its play.  Of linear flanks that part the error is stated.
    """
    worst = max((line.error for line in lines), default=0.0)
    return point.problem.rows.parametric or worst <= _MEANINGLESS


def _gap_values(point: TorusPoint) -> Array:
    """delta of every row over the grid, (N, R) [m]."""
    balance, y = point.problem, point.state.y
    return balance.grid.values(gap_rows(balance, y) - balance.error)


def _line_response(torus: Torus, point: TorusPoint, shaft: Shaft) -> SuperposedLine:
    """The linear response to one group of lines, of flanks that touch when they do at a point."""
    balance, speed = _problem(torus, point, shaft), point.state.speed
    F = balance.rows.count
    closed = balance.tangent[:, :F] > 0
    state = evaluate(balance, np.zeros_like(balance.force[0]), speed, touching=closed)
    move, _ = newton_step(forcing=_TOLERANCE)(balance, state, state.residual, 0.0)
    y = -move
    opened = gap_rows(balance, y) - balance.error
    stretch = _amplitude(balance, opened)
    tangent: Array = balance.tangent.reshape(len(stretch), _SAMPLES, -1)[:, 0]
    elastic: ComplexArray = tangent * stretch
    force = elastic[:, :F].copy()
    if balance.rows.damping.any():
        rate = rate_rows(opened[:, :F], speed * balance.omega)
        force += balance.rows.damping * _amplitude(balance, rate)
    reported, follows = reported_links(torus.ready)
    links = _amplitude(balance, link_rows(balance, reported.links, y, speed))
    links[:, follows] = with_diagonals(balance.rows, elastic)[:, F:]
    return SuperposedLine(
        shaft=shaft,
        stretch=stretch[:, :F],
        force=force,
        motion=_amplitude(balance, y.reshape(-1, y.shape[2]) @ torus.ready.modal.shapes.T),
        links=links,
        error=_superposition_error(point, stretch, elastic),
    )


def _superposition_error(point: TorusPoint, stretch: ComplexArray, force: ComplexArray) -> float:
    """RMS of what the laws add to or take from the forces of a line over all phases, relative to those forces.

    stretch, force : (N, R) amplitudes [m, N].
    """
    delta, rows = _gap_values(point), point.problem.rows
    before, repeats = elastic_forces(point.problem, delta), len(delta) // len(stretch)
    wrong = right = 0.0
    for turn in (1.0, 1j, -1.0, -1j):
        linear = np.repeat((turn * force).real, repeats, axis=0)
        linear = with_diagonals(rows, linear)
        after = elastic_forces(point.problem, delta + np.repeat((turn * stretch).real, repeats, axis=0))
        wrong += float(((after - before - linear) ** 2).sum())
        right += float((linear**2).sum())
    return float(np.sqrt(wrong / max(right, np.finfo(float).tiny)))


def _amplitude(balance: Problem, rows: Array) -> ComplexArray:
    """Complex amplitude (N, c) at order 1 of the line's phase, of rows (2 J, c)."""
    values = balance.grid.values(rows)
    values = values.reshape(len(values) // _SAMPLES, _SAMPLES, rows.shape[1])
    amplitude = np.empty(values[:, 0].shape, complex)
    amplitude.real, amplitude.imag = (values[:, 0] - values[:, 2]) / 2, (values[:, 3] - values[:, 1]) / 2
    return amplitude


def _problem(torus: Torus, point: TorusPoint, shaft: Shaft) -> Problem:
    """The balance of mesh orders around the frequency of the lines alone.

    Tangents are means over the shaft phases of the torus; backlash and steady forces belong to the mean alone.
    """
    ready, D = torus.ready, torus.mesh_tones
    points = [(*a, s) for a in mesh_points(point.size).tolist() for s in (-1, 0, 1)]
    lines = [placed_line((*orders, -1 if minus else 1), line) for orders, minus, line in shaft.members]
    balance = problem(
        ready,
        half_lattice(points),
        np.append(torus.tones[:D], 2 * np.pi * float(shaft.frequency)),
        (*point.problem.grid.counts[:D], _SAMPLES),
        lines,
    )
    along = point.state.tangent
    mean = along.reshape(len(balance.tangent) // _SAMPLES, -1, along.shape[1]).mean(axis=1)
    error, link_error, force = balance.error.copy(), balance.link_error.copy(), balance.force.copy()
    error[0], link_error[0], force[:, :, 0] = 0.0, 0.0, 0.0
    return replace(balance, error=error, link_error=link_error, force=force, tangent=np.repeat(mean, _SAMPLES, axis=0))


# --- shaft orders on a motion -----------------------------------------------------------------------------------------


class ShaftResponse(NamedTuple):
    """One motion of mesh orders with shaft orders.

    measures : None where it failed.  status : ``ok``, ``coarse``, or how it failed.
    truncation_residual : as of `TorusPoint`.
    superposed_error : largest error of a line superposed on flanks that part, relative to its own force (RMS).
    harmonics : of the mesh tones.  residual : of the rows kept.
    """

    status: str
    measures: Measures | None = None
    truncation_residual: float = np.nan
    superposed_error: float = 0.0
    harmonics: int = 0
    residual: float = np.nan


class MeshOrders(NamedTuple):
    """A motion of mesh orders, all that shaft orders on it follow from.

    points : (J, D) lattice points.  y : (2, J, n).  speed : relative.  cycles : mesh cycles of a period.
    stable : False where it is known not to be.
    """

    points: Index
    y: Array
    speed: float
    cycles: int
    stable: bool

    @property
    def digest(self) -> str:
        """The same of equal motions, bit by bit."""
        return hashlib.sha256(repr((self.speed, self.cycles, self.stable)).encode() + self.y.tobytes()).hexdigest()


def mesh_orders(at: Solution) -> MeshOrders:
    """The motion of a solution."""
    return MeshOrders(
        points=at.balance.grid.points,
        y=at.state.y,
        speed=at.state.speed,
        cycles=at.balance.cycles,
        stable=at.stability is None or at.stable,
    )


def shaft_response(torus: Torus, at: MeshOrders) -> ShaftResponse:
    """A motion with shaft orders next to one of mesh orders; where there is none, why."""
    if at.cycles > 1:
        return ShaftResponse(status="shaft orders are not known of a motion of two mesh cycles")
    if not at.stable:
        return ShaftResponse(status="shaft orders are not known of a motion that is not stable")
    mesh_point = respond_torus(torus.mesh_orders_only, at.speed, start=(at.points, at.y))
    y = embedded(at.points, at.y, mesh_point.problem, cycles=at.cycles)
    if not mesh_point.converged or float(np.linalg.norm(mesh_point.state.y - y)) / dynamic_size(at.y) > _NEAR:
        return ShaftResponse(status="the torus left the motion of mesh orders")
    lines = superposed_lines(torus.mesh_orders_only, mesh_point)
    if superposition_is_exact(mesh_point, lines):
        return _torus_response(torus.mesh_orders_only, mesh_point, lines)
    needed, large = memory(torus, at.speed)
    if large:
        return ShaftResponse(status=f"the torus of shaft orders would take {needed / 1e9:.0f} GB")
    point = respond_torus(torus, at.speed, start=(mesh_point.problem.grid.points, mesh_point.state.y))
    if not point.converged:
        status = f"the torus of shaft orders: {point.status}"
        return ShaftResponse(status=status, residual=point.residual)
    lines = superposed_lines(torus, point)
    if not superposition_is_an_answer(point, lines):
        status = "the torus of shaft orders has no tone left for lines that move links through their play"
        return ShaftResponse(status=status, residual=point.residual)
    return _torus_response(torus, point, lines)


def _torus_response(torus: Torus, point: TorusPoint, lines: list[SuperposedLine]) -> ShaftResponse:
    """Measures of a point of the torus and of the lines superposed on it."""
    error = max((line.error for line in lines), default=0.0)
    return ShaftResponse(
        measures=torus_outputs(torus, point, lines).measures,
        status=point.status,
        truncation_residual=point.truncation_residual,
        superposed_error=error if error > NEGLIGIBLE else 0.0,
        harmonics=max(point.size.harmonics),
        residual=point.residual,
    )


# --- the linear response ----------------------------------------------------------------------------------------------


class LinearMotion(NamedTuple):
    """The linear response at one speed, mesh orders as a point of the torus.

    rms : (w,) of the force of every whole mesh with all shaft lines, lines of equal frequency added first [N].
    unchanging : whether each loaded flank of `point` presses at every phase and no far one does, with the tangents of
        the linear system.
    """

    block: Block
    point: TorusPoint
    rms: Array
    unchanging: bool


def linear_motion(torus: Torus, speed: float) -> LinearMotion | None:
    """The linear response at a relative speed; None where there is none, or laws have tangents that vary."""
    ready = torus.ready
    asked = np.array([speed])
    if unstable_speeds(ready, asked)[0]:
        return None
    shaft_orders = bool(torus.shaft_lines)
    block = next(respond(ready, asked, tolerance=_LINEAR_TOLERANCE, shaft_orders=shaft_orders))
    if not block.residual[0] <= _ACCEPTED or block.uncertainty[0] > _ACCEPTED:
        return None
    samples = _samples(ready, block)
    if samples is None:
        return None
    points = ready.kernel(block.truncation, shifted=False).lattice.points
    balance = problem(
        ready, points, ready.omega, (samples,) * len(ready.lines.tones), *ready.lines.solved_together(shifted=False)
    )
    if not balance.rows.parametric:
        return None
    y, size = block.mesh.y[0], dynamic_size(block.mesh.y[0])
    state = evaluate(balance, y, speed)
    return LinearMotion(
        block=block,
        point=TorusPoint(
            problem=balance,
            state=state,
            size=Size(block.truncation[:-1], block.truncation[-1], ()),
            converged=True,
            residual=max(float(block.mesh.residual[0]), state.norm / size),
            truncation=block.mesh.truncation_residual[0],
        ),
        rms=np.sqrt(mean_square(whole_mesh_signal(force_signal(ready, block), faces(ready.system.meshes)))[:, 0]),
        unchanging=state.unchanging and bool(np.all(state.touching == (balance.rows.flanks.sense > 0))),
    )


def unchanging_lines(torus: Torus, linear: LinearMotion) -> list[SuperposedLine] | None:
    """The shaft lines of a linear motion; None where a flank parts or closes at any phase of them."""
    if not linear.unchanging:
        return None
    lines = [_line(torus.ready, linear, place, shaft) for place, shaft in enumerate(torus.shaft_lines)]
    return lines if superposition_is_exact(linear.point, lines) else None


def linear_error(torus: Torus, linear: LinearMotion, size: Size, counts: Sequence[int]) -> tuple[float, float]:
    """What rows of a size miss of the linear response: of the RMS, and of the largest force per largest (derived here).

    Both are the worst of all whole meshes, mesh orders alone.

    Parameters
    ----------
    counts : (D,) samples of the mesh phases with which the rows were solved.
    """
    exact, ready = linear.point, torus.ready
    balance = problem(ready, mesh_points(size), ready.omega, tuple(counts), *ready.lines.solved_together(shifted=False))
    state = evaluate(balance, linear_start(balance, exact.state.speed), exact.state.speed)
    coarse = replace(exact, problem=balance, state=state)
    both = [torus_outputs(torus.mesh_orders_only, point).measures for point in (exact, coarse)]
    return _relative(*(one.rms for one in both)), _relative(*(np.maximum(one.highest, -one.lowest) for one in both))


def _relative(exact: Array, other: Array) -> float:
    """Largest difference of (w,) per value; meshes of next to none are compared with the largest."""
    least = 1e-3 * float(exact.max(initial=0.0))
    return float((np.abs(other - exact) / np.maximum(exact, max(least, np.finfo(float).tiny))).max(initial=0.0))


def _samples(ready: Response, block: Block) -> int | None:
    """Samples of every mesh phase; None where those that resolve the force are too many."""
    D, flanks = len(ready.lines.tones), ready.modal.gaps.shape[0] + ready.system.far_flanks.mesh.size
    least = alias_free_samples(ready, max(block.truncation))
    # what a phase holds: forces and tangents of all flanks, and complex stretches, forces and motions of every line
    held = 4 * flanks + len(ready.lines.shaft) * (4 * flanks + 2 * ready.modal.squared.size)
    most = int((_MOST / held) ** (1 / D))
    return None if most < least else min(most, max(_WANTED.get(D, 0), least))


def _line(ready: Response, linear: LinearMotion, place: int, shaft: Shaft) -> SuperposedLine:
    """Response to one group of shaft lines over the grid of mesh phases, of flanks that keep their contact."""
    block, solved, point = linear.block, linear.block.shaft, linear.point
    assert solved is not None
    rows, counts = point.problem.rows, point.problem.grid.counts
    F, orders = rows.count, ready.kernel(block.truncation, shifted=True).lattice.points
    stretch = (solved.y[place, 0] + 1j * solved.y[place, 1]) @ rows.gaps[:F].T
    lines = ready.lines.solved_together(shifted=True)[place : place + 1]
    stretch -= placed(orders, lines, (F,), lambda line: line_gaps(ready, rows, line)[:F])[0]
    delta = _over_phases(stretch, orders, counts)
    force = point.state.tangent[:, :F] * delta
    if rows.damping.any():
        rate = _over_phases(1j * solved.frequency[place][:, None] * stretch, orders, counts)
        force += np.where(point.state.touching, rows.damping, 0.0) * rate
    motion, links = (spectrum(ready, block, shifted=True).amplitude for spectrum in (motion_spectrum, link_spectrum))
    return SuperposedLine(
        shaft=shaft,
        stretch=delta,
        force=force,
        motion=_over_phases(motion[:, 0, place].T, orders, counts),
        links=_over_phases(links[:, 0, place].T, orders, counts),
        error=0.0,
    )


def _over_phases(amplitude: ComplexArray, orders: np.ndarray, counts: tuple[int, ...]) -> ComplexArray:
    """Sum of amplitudes (K, c) exp(2 pi i a . theta) at orders a (K, D) over a grid of phases, (N, c)."""
    box = np.zeros((*counts, amplitude.shape[1]), complex)
    box[tuple((orders % np.array(counts)).T)] = amplitude
    values: ComplexArray = np.fft.ifftn(box, axes=range(len(counts)), norm="forward")
    return values.reshape(prod(counts), amplitude.shape[1])


# --- the torus --------------------------------------------------------------------------------------------------------


def flank_force_at(balance: Problem, at: State, phases: Array) -> Array:
    """Force of every flank at phases (T, D) of the tones [cycles], (T, F) [N]."""
    rows, grid = balance.rows, balance.grid
    gap = (gap_rows(balance, at.y) - balance.error)[:, : rows.count]
    delta, laws = grid.at(phases, gap), rows.at(balance.cycles * phases)
    force = laws.evaluate(delta)[0]
    if rows.damping.any():
        force = force + rows.damping * grid.at(phases, rate_rows(gap, at.speed * balance.omega))
    return np.where(delta > laws.touch, force, 0.0)


def super_period_phases(tones: tuple[Fraction, ...], samples: int) -> Array | None:
    """Phases (T, D) along one super-period [cycles], None where it is so long that its path fills the torus.

    On a short one phases recur together, so that averages over it are not those over all phases.

    Parameters
    ----------
    tones : (D,) exact.  samples : of a cycle of the first tone, at least.
    """
    unit = lcm(*(tone.denominator for tone in tones))
    whole = [int(tone * unit) for tone in tones]
    turns = [value // np.gcd.reduce(whole) for value in whole]
    count = max(turns) * samples
    if count > _INSTANTS:
        return None
    return np.outer(np.arange(count) / count, turns) % 1.0


def grid_maximum(values: Array) -> Array:
    """Largest value over a grid of phases (N_1, .., N_D, c) -> (c,), with a parabola along every axis."""
    *counts, columns = values.shape
    flat = values.reshape(prod(counts), columns)
    place = np.unravel_index(flat.argmax(axis=0), counts)
    top: Array = flat.max(axis=0)
    total = top
    for axis in range(len(counts)):
        others = (*place[:axis], *place[axis + 1 :], np.arange(columns))
        total = total + peak(np.moveaxis(values, axis, 0)[:, *others].T) - top
    return total


class TorusOutputs(NamedTuple):
    """Forces of whole meshes (w,) and of their rows (m,), slices where a mesh is cut; on the loaded flank positive.

    measures : over all time and all relative phases, slices and both flanks of a mesh together.
    force : (N, w), row_force : (N, m) over the phases of the grid, mean over the lines that are superposed [N].
    reach : (N, w) by how much these change it at most [N].
    row_peak : (m,) largest over all relative phases [N].
    row_open : (m,) share of time in which the loaded flank of a row does not touch.
    far : (w,) share of time in which a far flank touches.
    link_force : (N, p) of link rows, error : (N, k) of transmission, over the phases of the grid [N, N m; m, rad].
    """

    measures: Measures
    force: Array
    row_force: Array
    reach: Array
    row_peak: Array
    row_open: Array
    far: Array
    link_force: Array
    error: Array


def torus_outputs(torus: Torus, point: TorusPoint, lines: Sequence[SuperposedLine] = ()) -> TorusOutputs:
    """Statistics of a point of the torus.

    Lines superposed add their mean square to the RMS and their amplitude to the extremes.  A mesh whose far flank stays
    away has no force below those at the samples and 0, whatever they add: teeth do not pull.
    """
    system, face, balance = torus.ready.system, faces(torus.ready.system.meshes), point.problem
    rows = len(face.row)
    flank = flank_force(balance, point.state)
    of_rows = row_force(system, flank)
    force = face.total(of_rows, axis=1)
    row_lines = [row_force(system, line.force) for line in lines]
    mesh_lines = [face.total(amplitude, axis=1) for amplitude in row_lines]
    counts, touching = balance.grid.counts, point.state.touching
    far = touching.copy()
    far[:, :rows] = False
    far_share = touching_meshes(system, far).mean(axis=0)
    least = np.where(far_share == 0, np.minimum(force.min(axis=0), 0.0), -np.inf)
    tones = (*torus.ready.lines.tones, *torus.shaft_tones.tones)
    link_force, error, links = link_outputs(torus.ready, balance, point.state, tones, lines)
    lowest, highest = _ends(force, mesh_lines, counts)
    motion = balance.grid.values(point.state.y.reshape(-1, system.force.size) @ balance.modal.shapes.T)
    low, most = _ends(motion, [line.motion for line in lines], counts)
    return TorusOutputs(
        measures=Measures(
            rms=np.sqrt(_variance(torus, point, force, lines, mesh_lines)),
            highest=highest,
            lowest=np.maximum(lowest, least),
            open=1.0 - touching_meshes(system, touching).mean(axis=0),
            amplitude=system.dofs.radius * (most - low) / 2,
            flank=_with_lines(flank, [line.force for line in lines], counts),
            links=links,
        ),
        force=force,
        row_force=of_rows,
        reach=_reach(mesh_lines, len(force)) if mesh_lines else np.zeros_like(force),
        row_peak=_with_lines(of_rows, row_lines, counts),
        row_open=1.0 - touching[:, :rows].mean(axis=0),
        far=far_share,
        link_force=link_force,
        error=error,
    )


def link_outputs(
    ready: Response,
    balance: Problem,
    at: State,
    tones: Sequence[Fraction],
    lines: Sequence[SuperposedLine] = (),
) -> tuple[Array, Array, dict[str, Array]]:
    """Forces of link rows (N, p) [N, N m] and transmission errors (N, k) [m, rad] over the phases of a motion.

    With them the measures of links and the ranges of errors, over all phases.  Linear rows have their dampers; rows of
    groups follow their laws, without dampers.  Lines superposed count as of `torus_outputs`.

    tones : exact, of the phases of the balance.
    """
    system, follows = reported_links(ready)
    force = balance.grid.values(link_rows(balance, system.links, at.y, at.speed))
    force[:, follows] = gap_forces(balance, at)[:, balance.rows.count :]
    pairs, counts, every = lateral_pairs(system), balance.grid.counts, [line.links for line in lines]
    x, y = pairs.T
    lateral, reach = force[:, x] + 1j * force[:, y], [(amplitude[:, x], amplitude[:, y]) for amplitude in every]
    # the largest length is that of the largest part along any direction
    parts = [
        _with_lines(
            (lateral * np.exp(-1j * angle)).real, [np.cos(angle) * a + np.sin(angle) * b for a, b in reach], counts
        )
        for angle in (_TOWARDS if reach else ())
    ]
    length = grid_maximum(np.array(parts)) if parts else _with_lines(np.abs(lateral), (), counts)
    span = Range(*_ends(force, every, counts), length)
    square = sum(((np.abs(amplitude) ** 2).mean(axis=0) / 2 for amplitude in every), force.var(axis=0))
    held = held_pairs(pairs, system.links.turn)
    standing = [
        _standing_force(balance, force[:, pairs[i]], tones, lines, pairs[i], system.links.turn[x[i]]) for i in held
    ]
    errors = ready.system.errors
    wave = balance.grid.values(at.y.reshape(-1, at.y.shape[2]) @ strained(ready, ready.system.error_rows).T)
    least, most = _ends(wave, [line.motion @ ready.system.error_rows for line in lines], counts)
    ranges = peaks_to_peaks(errors, most - least)
    measures = link_statistics(span, force.mean(axis=0), square, pairs, held, np.array(standing))
    return force, wave, measures | {name: values for name, (_, values) in ranges.items()}


def _standing_force(
    balance: Problem,
    force: Array,
    tones: Sequence[Fraction],
    lines: Sequence[SuperposedLine],
    pair: Index,
    turn: Fraction,
) -> float:
    """Length [N] of the part of a lateral force (N, 2) in a frame of so many turns that stands still in the housing."""
    J, amplitude = len(balance.grid.points), np.zeros(2, complex)
    rows = balance.grid.rows(force)
    for j, point in enumerate(balance.grid.points.tolist()):
        frequency = sum((a * tone for a, tone in zip(point, tones, strict=False)), Fraction(0))
        if abs(frequency) == abs(turn):
            both = rows[j] + 1j * rows[J + j]
            amplitude += both if frequency > 0 else both.conj()
    for line in lines:
        if line.shaft.frequency == abs(turn):
            amplitude += line.links[:, pair].mean(axis=0)
    x, y = amplitude
    return float(abs(x - 1j * y if turn > 0 else x + 1j * y)) / 2


def _with_lines(values: Array, amplitudes: Sequence[ComplexArray], counts: tuple[int, ...]) -> Array:
    """Largest value (c,) over all phases of values (N, c) and of lines of amplitudes (Nm, c) over mesh phases."""
    if amplitudes:
        values = values + _reach(amplitudes, len(values))
    return grid_maximum(values.reshape(*counts, values.shape[1]))


def _ends(values: Array, amplitudes: Sequence[ComplexArray], counts: tuple[int, ...]) -> tuple[Array, Array]:
    """Smallest and largest value (c,), as of `_with_lines`."""
    return -_with_lines(-values, amplitudes, counts), _with_lines(values, amplitudes, counts)


def _reach(amplitudes: Sequence[ComplexArray], samples: int) -> Array:
    """Sum of the magnitudes of lines (Nm, c) over all samples of the torus, (N, c)."""
    reach: Array = np.sum([np.abs(amplitude) for amplitude in amplitudes], axis=0)
    return np.repeat(reach, samples // len(reach), axis=0)


def _variance(
    torus: Torus, point: TorusPoint, force: Array, lines: Sequence[SuperposedLine], amplitudes: Sequence[ComplexArray]
) -> Array:
    """Mean square of what varies, (w,) [N^2]: over one super-period, or over the torus that a long one fills.

    amplitudes : (Nm, w) of the lines.
    """
    balance, mesh, D = point.problem, torus.ready.lines.tones, len(point.problem.grid.counts)
    of_shafts = torus.shaft_tones.tones[: D - len(mesh)]
    tones: tuple[Fraction, ...] = (*mesh, *of_shafts, *(line.shaft.frequency for line in lines))
    path = None
    if len(tones) > 1 and (len(mesh) == 1 or not lines):
        path = super_period_phases(tones, balance.grid.counts[0])
    if path is None:
        square = sum(((np.abs(amplitude) ** 2).mean(axis=0) / 2 for amplitude in amplitudes), np.zeros(force.shape[1]))
        return np.asarray(force.var(axis=0) + square)
    total = mesh_force(torus.ready.system, flank_force_at(balance, point.state, path[:, :D]))
    for amplitude, phase in zip(amplitudes, path.T[D:], strict=True):
        # between samples of the mesh phase by Fourier sums
        count = len(amplitude)
        wave = np.exp(2j * np.pi * np.outer(path[:, 0], np.fft.fftfreq(count, 1 / count)))
        along = wave @ (np.fft.fft(amplitude, axis=0) / count)
        total += (along * np.exp(2j * np.pi * phase)[:, None]).real
    return np.asarray(total.var(axis=0))
