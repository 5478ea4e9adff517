"""Shaft orders on motions of mesh orders: superposed lines, and the torus where these part or close a flank.

A superposed line responds alone, linearly, to flanks that touch when they do without it.  That is exact as long as no
flank parts or closes because of the lines, whatever their number and that of the mesh tones.  Where one does, it is
the answer to first order for lines that are small (derived here).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...questions.response.excitation import Shaft
from ...system.system import Array, ComplexArray
from .corrector import newton_step
from .lattice_points import half_lattice, mesh_points, placed_line
from .outputs import Measures, torus_amplitudes, torus_outputs
from .problem import Problem, dynamic_size, elastic_forces, embedded, evaluate, gap_rows, problem, rate_rows
from .refinement import Solution
from .torus import Torus, TorusPoint, memory, respond_torus

__all__ = [
    "NEGLIGIBLE",
    "MeshOrders",
    "ShaftResponse",
    "SuperposedLine",
    "integrated_with_shaft_orders",
    "mesh_orders",
    "shaft_response",
    "superposed_lines",
    "superposition_is_an_answer",
    "superposition_is_exact",
]

Index = NDArray[np.int64]

# Samples of the phase of a line: the linear response has its order 1 alone, and four make its quadratures differences.
_SAMPLES = 4
# Relative residual of the linear solution, as of the linear response of `analyses.steady`.
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SuperposedLine:
    """Response to the lines of one group, Re(amplitude exp(i w_s t)), amplitudes over N phases of the mesh tones.

    shaft : the lines.  stretch : (N, R) of delta of every flank [m].  force : (N, R) of its force [N].
    motion : (N, n) of every coordinate [m].  error : RMS of what the law makes of the stretch otherwise, per the force.
    """

    shaft: Shaft
    stretch: ComplexArray
    force: ComplexArray
    motion: ComplexArray
    error: float


def superposed_lines(given: Torus, point: TorusPoint) -> list[SuperposedLine]:
    """The linear response of every group of lines that is not on the torus."""
    return [_line_response(given, point, shaft) for shaft in given.shaft_tones.superposed]


def superposition_is_exact(given: Torus, point: TorusPoint, lines: Sequence[SuperposedLine]) -> bool:
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
    values: Array = balance.grid.values(gap_rows(balance, y) - balance.error)
    return values


def _line_response(given: Torus, point: TorusPoint, shaft: Shaft) -> SuperposedLine:
    """The linear response to one group of lines, of flanks that touch when they do at a point."""
    balance, speed = _problem(given, point, shaft), point.state.speed
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
    return SuperposedLine(
        shaft=shaft,
        stretch=stretch[:, :F],
        force=force,
        motion=_amplitude(balance, y.reshape(-1, y.shape[2]) @ given.ready.modal.shapes.T),
        error=_superposition_error(point, stretch, elastic),
    )


def _superposition_error(point: TorusPoint, stretch: ComplexArray, force: ComplexArray) -> float:
    """RMS of what the laws add to or take from the forces of a line over all phases, relative to those forces.

    stretch, force : (N, R) amplitudes [m, N].
    """
    delta = _gap_values(point)
    before, repeats = elastic_forces(point.problem, delta), len(delta) // len(stretch)
    wrong = right = 0.0
    for turn in (1.0, 1j, -1.0, -1j):
        linear = _forces_of_line(point, np.repeat((turn * force).real, repeats, axis=0))
        after = elastic_forces(point.problem, delta + np.repeat((turn * stretch).real, repeats, axis=0))
        wrong += float(((after - before - linear) ** 2).sum())
        right += float((linear**2).sum())
    return float(np.sqrt(wrong / max(right, np.finfo(float).tiny)))


def _forces_of_line(point: TorusPoint, force: Array) -> Array:
    """Forces of flanks and link rows (N, F + L) [N] from those of all rows (N, R), diagonal ones put on their x, y."""
    rows = point.problem.rows
    if rows.links is None:
        return force
    last = rows.count + rows.links.rows.size
    result = force[:, :last].copy()
    for side in rows.links.pairs.T:
        result[:, rows.count + side] += force[:, last:]
    return result


def _amplitude(balance: Problem, rows: Array) -> ComplexArray:
    """Complex amplitude (N, c) at order 1 of the line's phase, of rows (2 J, c)."""
    values = balance.grid.values(rows).reshape(-1, _SAMPLES, rows.shape[1])
    amplitude = np.empty(values[:, 0].shape, complex)
    amplitude.real, amplitude.imag = (values[:, 0] - values[:, 2]) / 2, (values[:, 3] - values[:, 1]) / 2
    return amplitude


def _problem(given: Torus, point: TorusPoint, shaft: Shaft) -> Problem:
    """The balance of mesh orders around the frequency of the lines alone.

    Tangents are means over the shaft phases of the torus; backlash and steady forces belong to the mean alone.
    """
    ready, D = given.ready, given.mesh_tones
    points = [(*a, s) for a in mesh_points(point.size).tolist() for s in (-1, 0, 1)]
    lines = [placed_line((*orders, -1 if minus else 1), line) for orders, minus, line in shaft.members]
    balance = problem(
        ready,
        half_lattice(points),
        np.append(given.tones[:D], 2 * np.pi * float(shaft.frequency)),
        (*point.problem.grid.counts[:D], _SAMPLES),
        lines,
    )
    along = point.state.tangent
    mean = along.reshape(len(balance.tangent) // _SAMPLES, -1, along.shape[1]).mean(axis=1)
    error, force = balance.error.copy(), balance.force.copy()
    error[0], force[:, :, 0] = 0.0, 0.0  # backlash and steady forces belong to the mean
    return replace(balance, error=error, force=force, tangent=np.repeat(mean, _SAMPLES, axis=0))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShaftResponse:
    """One motion of mesh orders with shaft orders.

    measures : None where it failed.  status : ``ok``, ``coarse``, or how it failed.
    truncation_residual : as of `TorusPoint`.
    superposed_error : largest error of a line superposed on flanks that part, relative to its own force (RMS).
    harmonics : of the mesh tones.  residual : of the rows kept.
    """

    measures: Measures | None
    status: str
    truncation_residual: float = np.nan
    superposed_error: float = 0.0
    harmonics: int = 0
    residual: float = np.nan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshOrders:
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
    def key(self) -> tuple[object, ...]:
        """The same of equal motions, bit by bit."""
        return self.speed, self.cycles, self.stable, self.y.tobytes()


def mesh_orders(at: Solution) -> MeshOrders:
    """The motion of a solution."""
    return MeshOrders(
        points=at.given.grid.points,
        y=at.state.y,
        speed=at.state.speed,
        cycles=at.given.cycles,
        stable=at.stability is None or at.stable,
    )


def integrated_with_shaft_orders() -> ShaftResponse:
    """What is known of shaft orders on a motion that is integrated."""
    return ShaftResponse(measures=None, status="shaft orders are not known of a motion that is integrated")


def shaft_response(given: Torus, at: MeshOrders) -> ShaftResponse:
    """A motion with shaft orders next to one of mesh orders; where there is none, why."""
    if at.cycles > 1:
        return ShaftResponse(measures=None, status="shaft orders are not known of a motion of two mesh cycles")
    if not at.stable:
        return ShaftResponse(measures=None, status="shaft orders are not known of a motion that is not stable")
    mesh_point = respond_torus(given.mesh_orders_only, at.speed, start=(at.points, at.y))
    if not mesh_point.converged or _distance_from(at, mesh_point) > _NEAR:
        return ShaftResponse(measures=None, status="the torus left the motion of mesh orders")
    lines = superposed_lines(given.mesh_orders_only, mesh_point)
    if superposition_is_exact(given.mesh_orders_only, mesh_point, lines):
        return _torus_response(given.mesh_orders_only, mesh_point, lines)
    needed, large = memory(given, at.speed)
    if large:
        status = f"the torus of shaft orders would take {needed / 1e9:.0f} GB"
        return ShaftResponse(measures=None, status=status)
    point = respond_torus(given, at.speed, start=(mesh_point.problem.grid.points, mesh_point.state.y))
    if not point.converged:
        status = f"the torus of shaft orders: {point.status}"
        return ShaftResponse(measures=None, status=status, residual=point.residual)
    lines = superposed_lines(given, point)
    if not superposition_is_an_answer(point, lines):
        return ShaftResponse(
            measures=None,
            status="the torus of shaft orders has no tone left for lines that move links through their play",
            residual=point.residual,
        )
    return _torus_response(given, point, lines)


def _distance_from(at: MeshOrders, mesh_point: TorusPoint) -> float:
    """Distance of the torus's mesh orders from those of a motion, per its dynamic size."""
    y = embedded(at.points, at.y, mesh_point.problem, cycles=at.cycles)
    return float(np.linalg.norm(mesh_point.state.y - y)) / dynamic_size(at.y)


def _torus_response(given: Torus, point: TorusPoint, lines: list[SuperposedLine]) -> ShaftResponse:
    """Measures of a point of the torus and of the lines superposed on it."""
    found = torus_outputs(given, point, lines)
    error = max((line.error for line in lines), default=0.0)
    return ShaftResponse(
        measures=Measures(
            rms=found.rms,
            highest=found.peak,
            lowest=found.minimum,
            open=np.maximum(found.open - found.far, 0.0),
            amplitude=torus_amplitudes(given, point, lines),
            flank=found.flank,
        ),
        status=point.status,
        truncation_residual=point.truncation_residual,
        superposed_error=error if error > NEGLIGIBLE else 0.0,
        harmonics=max(point.size.harmonics),
        residual=point.residual,
    )
