"""The linear response as a point of the torus: exact where no flank parts or closes at any phase.

The linear response keeps as many harmonics and combinations as its own truncation residual asks for, far more than a
balance of contact can afford with two mesh frequencies.  Where contact is the same at every phase and tangents are
those of the linear system, it is the motion itself; elsewhere it tells what the rows of the balance miss of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...questions.response.excitation import Shaft
from ...questions.response.measures import mean_square
from ...questions.response.response import Block, Response, respond, unstable_speeds
from ...questions.response.waveform import alias_free_samples, force_signal, whole_mesh_signal
from ...system.system import Array, ComplexArray
from .corrector import linear_start
from .lattice_points import PlacedLine, Size, mesh_points
from .outputs import TorusOutputs, torus_outputs
from .problem import Problem, dynamic_size, evaluate, problem
from .rows import line_gaps
from .shaft_orders import SuperposedLine, superposition_is_exact
from .torus import Torus, TorusPoint

__all__ = ["LinearMotion", "linear_error", "linear_motion", "unchanging_lines"]

# Relative residual of the linear response, as of the linear steady state, and the largest that is no failure.
_TOLERANCE, _ACCEPTED = 1e-6, 1e-4
# Samples of a mesh phase, by the number of mesh tones: a parabola through the largest one is then within 1e-4 of the
# largest force (145 samples of two phases were 5e-3 away).
_WANTED = {1: 512, 2: 256}
# Doubles on a grid of all mesh phases, at most: 1 GB.
_MOST = 2**27


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearMotion:
    """The linear response at one speed, mesh orders as a point of the torus.

    rms : (w,) of the force of every whole mesh with all shaft lines, lines of equal frequency added first [N].
    unchanging : whether each loaded flank of `point` presses at every phase and no far one does, with the tangents of
        the linear system.
    """

    block: Block
    point: TorusPoint
    rms: Array
    unchanging: bool


def linear_motion(given: Torus, speed: float) -> LinearMotion | None:
    """The linear response at a relative speed; None where there is none, or laws have tangents that vary."""
    ready = given.ready
    asked = np.array([speed])
    if unstable_speeds(ready, asked)[0]:
        return None
    shaft_orders = bool(given.shaft_lines)
    block = next(respond(ready, asked, tolerance=_TOLERANCE, shaft_orders=shaft_orders))
    if not block.residual[0] <= _ACCEPTED or block.uncertainty[0] > _ACCEPTED:
        return None
    balance = _problem(ready, block)
    if balance is None or not balance.rows.parametric:
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
            calls=block.mesh.calls,
        ),
        rms=np.sqrt(mean_square(whole_mesh_signal(force_signal(ready, block), given.face))[:, 0]),
        unchanging=state.unchanging and bool(np.all(state.touching == (balance.rows.sense > 0))),
    )


def unchanging_lines(given: Torus, found: LinearMotion) -> list[SuperposedLine] | None:
    """The shaft lines of a linear motion; None where a flank parts or closes at any phase of them."""
    if not found.unchanging:
        return None
    lines = [_line(given.ready, found, place, shaft) for place, shaft in enumerate(given.shaft_lines)]
    return lines if superposition_is_exact(given.mesh_orders_only, found.point, lines) else None


def linear_error(given: Torus, found: LinearMotion, size: Size, counts: Sequence[int]) -> tuple[float, float]:
    """What rows of a size miss of the linear response: of the RMS, and of the largest force per largest (derived here).

    Both are the worst of all whole meshes, mesh orders alone.

    Parameters
    ----------
    counts : (D,) samples of the mesh phases with which the rows were solved.
    """
    exact, ready = found.point, given.ready
    mesh = size._replace(orders=())
    balance = problem(ready, mesh_points(mesh), ready.omega, tuple(counts), _mesh_lines(ready))
    state = evaluate(balance, linear_start(balance, exact.state.speed), exact.state.speed)
    coarse = TorusPoint(
        problem=balance,
        state=state,
        size=mesh,
        converged=True,
        residual=state.norm / dynamic_size(state.y),
        truncation=np.zeros(1),
        calls=0,
    )
    one, other = (torus_outputs(given.mesh_orders_only, point) for point in (exact, coarse))
    return _relative(one.rms, other.rms), _relative(_largest(one), _largest(other))


def _largest(found: TorusOutputs) -> Array:
    """Largest size of the force of every whole mesh, (w,) [N]."""
    size: Array = np.maximum(found.peak, -found.minimum)
    return size


def _relative(exact: Array, other: Array) -> float:
    """Largest difference of (w,) per value; meshes of next to none are compared with the largest."""
    least = 1e-3 * float(exact.max(initial=0.0))
    return float((np.abs(other - exact) / np.maximum(exact, max(least, np.finfo(float).tiny))).max(initial=0.0))


def _problem(ready: Response, block: Block) -> Problem | None:
    """The balance of mesh orders with the rows of a linear response; None where its grid would be too large."""
    samples = _samples(ready, block)
    if samples is None:
        return None
    counts = (samples,) * len(ready.lines.tones)
    points = ready.kernel(block.truncation, shifted=False).lattice.points
    return problem(ready, points, ready.omega, counts, _mesh_lines(ready))


def _samples(ready: Response, block: Block) -> int | None:
    """Samples of every mesh phase; None where those that resolve the force are too many."""
    D, flanks = len(ready.lines.tones), ready.modal.gaps.shape[0] + ready.system.far_flanks.mesh.size
    least = alias_free_samples(ready, max(block.truncation))
    # what a phase holds: forces and tangents of all flanks, and complex stretches, forces and motions of every line
    held = 4 * flanks + len(ready.lines.shaft) * (4 * flanks + 2 * ready.modal.squared.size)
    most = int((_MOST / held) ** (1 / D))
    return None if most < least else min(most, max(_WANTED.get(D, 0), least))


def _mesh_lines(ready: Response) -> list[PlacedLine]:
    """Mesh lines as `problem` takes them."""
    return [(point, False, line) for point, line in ready.lines.mesh]


def _line(ready: Response, found: LinearMotion, place: int, shaft: Shaft) -> SuperposedLine:
    """Response to one group of shaft lines over the grid of mesh phases, of flanks that keep their contact."""
    solved, point = found.block.shaft, found.point
    assert solved is not None
    balance, rows = point.problem, point.problem.rows
    F, orders = rows.count, ready.kernel(found.block.truncation, shifted=True).lattice.points
    y: ComplexArray = solved.y[place, 0] + 1j * solved.y[place, 1]
    stretch = y @ rows.gaps[:F].T
    at = {tuple(order): i for i, order in enumerate(orders.tolist())}
    for order, conjugate, line in shaft.members:
        error = line_gaps(ready, rows, line)[:F]
        here = at[tuple(-a for a in order) if conjugate else order]
        stretch[here] -= error.conj() if conjugate else error
    counts = balance.grid.counts
    delta = _over_phases(stretch, orders, counts)
    force = point.state.tangent[:, :F] * delta
    if rows.damping.any():
        rate = _over_phases(1j * solved.frequency[place][:, None] * stretch, orders, counts)
        force += np.where(point.state.touching, rows.damping, 0.0) * rate
    return SuperposedLine(
        shaft=shaft,
        stretch=delta,
        force=force,
        motion=_over_phases(y @ ready.modal.shapes.T, orders, counts),
        error=0.0,
    )


def _over_phases(amplitude: ComplexArray, orders: np.ndarray, counts: tuple[int, ...]) -> ComplexArray:
    """Sum of amplitudes (K, c) exp(2 pi i a . theta) at orders a (K, D) over a grid of phases, (N, c)."""
    box = np.zeros((*counts, amplitude.shape[1]), complex)
    box[tuple((orders % np.array(counts)).T)] = amplitude
    values: ComplexArray = np.fft.ifftn(box, axes=range(len(counts)), norm="forward").reshape(-1, amplitude.shape[1])
    return values
