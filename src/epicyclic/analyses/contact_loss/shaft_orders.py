"""Shaft lines beside the torus: each responds alone, linearly, to flanks that touch when they do without it.

That is exact as long as no flank parts or closes because of them, and then any number of lines and mesh tones is no
matter; where one does, it is the answer to first order for lines that are small.


---

Shaft orders on top of what a sweep has met: the torus that begins at a motion of mesh orders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...system.system import Array, ComplexArray
from ..steady.excitation import Shaft
from .branch_switching import Record
from .corrector import dynamic_size, preconditioned
from .outputs import Measures, outcome, strokes
from .problem import Placed, Problem, State, evaluate, mesh_points, problem
from .refinement import Solution
from .torus import Torus, TorusPoint, embedded, respond_torus

__all__ = ['Joined', 'ShaftOrders', 'Superposed', 'exact', 'superposed']

# Samples of the phase of a line: the linear response has its order 1 alone.
_SAMPLES = 4
# Relative residual of the linear solution.
_TOLERANCE = 1e-8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Superposed:
    """Response to the lines of one group, Re(amplitude exp(i w_s t)), amplitudes over N phases of the mesh tones.

    shaft : the lines.  stretch : (N, R) of delta of every flank [m].  force : (N, R) of its force [N].
    motion : (N, n) of every coordinate.  error : RMS of what the law makes of the stretch otherwise, per the force.
    """

    shaft: Shaft
    stretch: ComplexArray
    force: ComplexArray
    motion: ComplexArray
    error: float


def superposed(given: Torus, point: TorusPoint) -> list[Superposed]:
    """The response of every group of lines that is not on the torus."""
    return [_one(given, point, shaft) for shaft in given.slow.left]


def exact(given: Torus, point: TorusPoint, lines: Sequence[Superposed]) -> bool:
    """Whether all flanks that touch, or not, at a point of mesh orders do so whatever the phases of the lines."""
    delta = _opened(point)
    reach = sum((np.abs(line.stretch) for line in lines), np.zeros_like(delta))
    touching = point.state.touching
    always, never = touching.all(axis=0), ~touching.any(axis=0)
    settled = np.where(always, (delta > reach).all(axis=0), never & (delta < -reach).all(axis=0))
    return bool(settled.all())


def _opened(point: TorusPoint) -> Array:
    """delta of every flank over the grid, (N, R) [m]."""
    made, y = point.problem, point.state.y
    values: Array = made.grid.values(y.reshape(-1, y.shape[2]) @ made.flanks.gaps.T - made.error)
    return values


def _one(given: Torus, point: TorusPoint, shaft: Shaft) -> Superposed:
    made, speed = _problem(given, point, shaft), point.state.speed
    closed = np.broadcast_to(made.stiffness > 0, made.stiffness.shape)
    state = evaluate(made, np.zeros_like(made.force[0]), speed, touching=closed)
    move, _ = preconditioned(forcing=_TOLERANCE)(made, state, state.residual, 0.0)
    y = -move
    opened = y.reshape(-1, y.shape[2]) @ made.flanks.gaps.T - made.error
    stretch = _amplitude(made, opened)
    tangent: Array = made.stiffness.reshape(len(stretch), _SAMPLES, -1)[:, 0]
    force: ComplexArray = tangent * stretch
    if made.flanks.damping.any():
        w, J = speed * made.omega[:, None], len(made.omega)
        rate = np.concatenate([-w * opened[J:], w * opened[:J]])
        force += made.flanks.damping * _amplitude(made, rate)
    return Superposed(
        shaft=shaft,
        stretch=stretch,
        force=force,
        motion=_amplitude(made, y.reshape(-1, y.shape[2]) @ given.ready.modal.shapes.T),
        error=_error(point, stretch, tangent * stretch),
    )


def _error(point: TorusPoint, stretch: ComplexArray, force: ComplexArray) -> float:
    """RMS of what the law adds to or takes from the force of a line over all phases, relative to that force."""
    delta = _opened(point).reshape(len(stretch), -1, stretch.shape[1])
    stiffness = point.problem.stiffness.reshape(delta.shape)
    before = stiffness * np.maximum(delta, 0.0)
    wrong = right = 0.0
    for turn in (1.0, 1j, -1.0, -1j):
        after = stiffness * np.maximum(delta + (turn * stretch).real[:, None], 0.0)
        linear = (turn * force).real[:, None]
        wrong += float(((after - before - linear) ** 2).sum())
        right += float((linear**2).sum()) * delta.shape[1]
    return float(np.sqrt(wrong / max(right, np.finfo(float).tiny)))


def _amplitude(made: Problem, rows: Array) -> ComplexArray:
    """Amplitude (N, c) at order 1 of the line's phase, of rows (2 J, c)."""
    values = made.grid.values(rows).reshape(-1, _SAMPLES, rows.shape[1])
    amplitude = np.empty(values[:, 0].shape, complex)
    amplitude.real, amplitude.imag = (values[:, 0] - values[:, 2]) / 2, (values[:, 3] - values[:, 1]) / 2
    return amplitude


def _problem(given: Torus, point: TorusPoint, shaft: Shaft) -> Problem:
    """The balance of mesh orders around the frequency of the lines alone, with mean tangents over the slow phases."""
    ready, D = given.ready, given.mesh_tones
    points = [(*a, s) for a in mesh_points(point.size).tolist() for s in (-1, 0, 1)]
    leading = [p for p in points if next((a for a in p if a), 1) > 0]
    lines: list[Placed] = []
    for orders, minus, line in shaft.members:
        at = (*orders, -1 if minus else 1)
        leads = next(a for a in at if a) > 0
        lines.append((at if leads else tuple(-a for a in at), not leads, line))
    made = problem(
        ready,
        np.array(sorted(leading, key=lambda p: (any(p), p)), dtype=np.int64),
        np.append(given.tones[:D], 2 * np.pi * float(shaft.frequency)),
        (*point.problem.grid.counts[:D], _SAMPLES),
        lines,
    )
    touching = point.state.touching
    share = touching.reshape(len(made.stiffness) // _SAMPLES, -1, touching.shape[1]).mean(axis=1)
    error, force = made.error.copy(), made.force.copy()
    error[0], force[:, :, 0] = 0.0, 0.0  # backlash and steady forces belong to the mean
    return replace(made, error=error, force=force, stiffness=made.stiffness * np.repeat(share, _SAMPLES, axis=0))


# Part of the dynamic size that the torus's own mesh orders may be away from the motion met; farther is another branch.
_NEAR = 0.02
# Errors of superposed lines below this are none.
_NOTHING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Joined:
    """What became of one motion with shaft orders.

    measures : None where it failed.  status : ``ok``, ``coarse``, or why.  dropped : as of `TorusPoint`, its size.
    off : largest error of a line that is superposed on flanks that part, relative to its own force (RMS).
    harmonics : of the mesh tones.  residual : of the rows kept.
    """

    measures: Measures | None
    status: str
    dropped: float = np.nan
    off: float = 0.0
    harmonics: int = 0
    residual: float = np.nan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShaftOrders:
    """Puts shaft orders on motions of mesh orders, each once."""

    given: Torus
    made: dict[State, Joined] = field(default_factory=dict)

    def joined(self, at: Solution | Record) -> Joined:
        """The motion with shaft orders next to one of mesh orders."""
        if isinstance(at, Record):
            return Joined(measures=None, status="shaft orders are not known of a motion that is integrated")
        if at.state not in self.made:
            self.made[at.state] = self._joined(at)
        return self.made[at.state]

    def _joined(self, at: Solution) -> Joined:
        if at.given.cycles > 1:
            return Joined(measures=None, status="shaft orders are not known of a motion of two mesh cycles")
        if at.verdict is not None and not at.stable:
            return Joined(measures=None, status="shaft orders are not known of a motion that is not stable")
        flat = respond_torus(self.given.flat, at.state.speed, start=(at.given.grid.points, at.state.y))
        if not flat.converged or _away(at, flat) > _NEAR:
            return Joined(measures=None, status="the torus left the motion of mesh orders")
        lines = superposed(self.given.flat, flat)
        if exact(self.given, flat, lines):
            return _told(self.given.flat, flat, lines)
        point = respond_torus(self.given, at.state.speed, start=(flat.problem.grid.points, flat.state.y))
        if not point.converged:
            return Joined(measures=None, status=f"the torus of shaft orders: {point.status}", residual=point.residual)
        return _told(self.given, point, superposed(self.given, point))


def _away(at: Solution, flat: TorusPoint) -> float:
    """Distance of the torus's mesh orders from those of a motion, per its dynamic size."""
    y = embedded(flat.problem, at.given.grid.points, at.state.y)
    return float(np.linalg.norm(flat.state.y - y)) / dynamic_size(at.state.y)


def _told(given: Torus, point: TorusPoint, lines: list[Superposed]) -> Joined:
    found = outcome(given, point, lines)
    error = max((line.error for line in lines), default=0.0)
    return Joined(
        measures=Measures(
            rms=found.rms,
            highest=found.peak,
            lowest=found.minimum,
            open=np.maximum(found.open - found.far, 0.0),
            amplitude=strokes(given, point, lines),
        ),
        status=point.status,
        dropped=float(np.linalg.norm(point.dropped)),
        off=error if error > _NOTHING else 0.0,
        harmonics=max(point.size.harmonics),
        residual=point.residual,
    )
