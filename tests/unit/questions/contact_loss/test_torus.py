"""Contact loss on the torus of phases against time integration over a super-period, and what it leaves unchanged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.questions.contact_loss import torus as room
from epicyclic.questions.contact_loss.continuation import newton_step, solve
from epicyclic.questions.contact_loss.problem import Problem, State, elastic_forces, gap_forces, jacobian
from epicyclic.questions.contact_loss.rows import Size, edges
from epicyclic.questions.contact_loss.shaft_orders import (
    MeshOrders,
    shaft_response,
    superposed_lines,
    superposition_is_exact,
    torus_outputs,
)
from epicyclic.questions.contact_loss.steady import steady_motion
from epicyclic.questions.contact_loss.torus import (
    TRUNCATION_TOLERANCE,
    Torus,
    TorusPoint,
    memory,
    respond_torus,
    torus_of,
)
from epicyclic.questions.response.balance import gmres
from epicyclic.questions.response.response import response
from epicyclic.questions.transient.equation import constant, motion
from epicyclic.questions.transient.integrators import integrate
from epicyclic.questions.transient.transient import mesh_force
from epicyclic.system.system import System

Array = NDArray[np.float64]
F = Fraction
Train = Callable[..., System]


def integrated(given: Torus, point: TorusPoint, *, cycles: int, settle: int, steps: int = 128) -> tuple[Array, float]:
    """Mesh forces (m, T) over a super-period by Runge-Kutta steps, and what the state changes over it.

    It starts from the solution and runs `settle` mesh cycles first, so that a wrong or unstable one is left.
    """
    w, speed = point.state.speed * point.problem.omega, point.state.speed
    y = point.state.y
    start = np.stack([y[0].sum(axis=0), -(w[:, None] * y[1]).sum(axis=0)]) @ given.ready.modal.shapes.T
    moving, tone = motion(given.ready.system, program=constant(speed)), float(given.ready.lines.tone) * speed
    begin, end = settle / tone, (settle + cycles) / tone
    state = integrate(moving, start, stop=begin, steps=settle * steps, keep=settle * steps)[0][-1]
    states = integrate(moving, state, start=begin, stop=end, steps=cycles * steps)[0]
    times = np.linspace(begin, end, len(states))
    change = float(np.abs(states[-1] - states[0]).max() / np.abs(states).max())
    return mesh_force(moving, times[:-1], states[:-1]), change


# speed; what the train is; super-period in cycles of the first mesh
CASES = [
    pytest.param(2.3, {"slow": [(F(1, 27), 6e-6)]}, 27, id="one slow tone"),
    pytest.param(1.8, {"slow": [(F(1, 13), 5e-6), (F(1, 9), 4e-6)]}, 117, id="two slow tones"),
    pytest.param(2.4, {"slow": [(F(1, 27), 4e-6)], "backlash": 3e-6}, 27, id="one slow tone, both flanks"),
    pytest.param(2.0, {"ratio": F(31, 97)}, 97, id="two mesh tones"),
    pytest.param(1.8, {"ratio": F(5, 13), "mesh_damping": 400.0}, 13, id="two mesh tones in a short ratio, dampers"),
]


@pytest.mark.parametrize(("speed", "options", "cycles"), CASES)
def test_torus_is_time_integration(train: Train, speed: float, options: dict[str, object], cycles: int) -> None:
    pytest.importorskip("numba")
    given = torus_of(response(train(**options)))
    point = respond_torus(given, speed)
    assert point.status == "ok"
    outputs = torus_outputs(given, point)
    found = outputs.measures
    assert found.open.max() > 0.01  # teeth part: else the linear response would do
    assert (outputs.far.max() > 0.2) == ("backlash" in options)  # and cross a backlash that is small
    force, change = integrated(given, point, cycles=cycles, settle=cycles * max(1, 270 // cycles))
    assert change < 1e-4  # settled on a stable motion
    rms = force.std(axis=1)
    # what the method is used for; the steps of the integration are worth 2e-5 (found with four times as many)
    assert np.abs(found.rms - rms).max() < 3e-4 * rms.max()
    # a bound over all phases is above what this path reaches, and by no more than it leaves out
    assert np.all(found.highest > force.max(axis=1) - 0.02 * rms)
    assert np.all(found.lowest < force.min(axis=1) + 0.02 * rms)
    assert np.abs(found.highest - force.max(axis=1)).max() < 0.1 * rms.max()


def test_what_is_dropped_is_the_error_of_an_instant(train: Train) -> None:
    """The residual beyond the lattice against the difference to a lattice that holds it."""
    given = torus_of(response(train(slow=[(F(1, 13), 5e-6), (F(1, 9), 4e-6)])))
    small, large = (_at_size(given, 2.0, Size((12,), 0, (order, order))) for order in (1, 4))
    place = {tuple(p): i for i, p in enumerate(large.problem.grid.points.tolist())}
    at = [place[tuple(p)] for p in small.problem.grid.points.tolist()]
    error = large.state.y.copy()
    error[:, at] -= small.state.y
    size = float(np.linalg.norm(error)) / float(np.linalg.norm(large.state.y[:, 1:]))
    stated = float(np.linalg.norm(small.truncation))
    # the rows kept change too, by the coupling; a factor of two covers it
    assert 0.5 * size < stated < 2.0 * size
    assert np.linalg.norm(large.truncation) < 0.2 * stated


def _at_size(given: Torus, speed: float, size: Size) -> TorusPoint:
    """A point with rows as stated, without raising them."""
    made = given.prepared(size)
    start = respond_torus(given.mesh_orders_only, speed)
    from epicyclic.questions.contact_loss.torus import _solve_size

    point = _solve_size(given, size, speed, start.problem.grid.points, start.state.y)
    assert point.converged
    assert point.problem is made.coarse
    assert made.truncated_orders.kinds == len(point.truncation)
    return point


def plain_step(given: Problem, at: State, right: Array, target: float) -> tuple[Array, int]:
    """A Newton step without a preconditioner, to a thousandth of its right side."""
    product, wanted = jacobian(given, at), max(1e-3 * float(np.linalg.norm(right)), target)
    found, _, calls = gmres(
        lambda x: product(x.reshape(right.shape)).reshape(1, -1),
        right.reshape(1, -1),
        target=np.array([wanted]),
        restarts=3,
    )
    return found.reshape(right.shape), calls


def test_the_preconditioner_changes_nothing_but_the_work(train: Train) -> None:
    given = torus_of(response(train(slow=[(F(1, 27), 6e-6)])))
    point = respond_torus(given, 2.3)
    made, y = point.problem, point.state.y
    # a tenth of everything that moves off the solution
    start = y * np.where(np.arange(y.shape[1]) == 0, 1.0, 0.97)[:, None]
    with_it = solve(made, start, 2.3, step=newton_step(), tolerance=1e-9)
    without = solve(made, start, 2.3, step=plain_step, tolerance=1e-9)
    assert with_it.converged
    assert without.converged
    # both stop at 1e-9 of the residual, which the inverse of the derivative, some tens here, makes larger
    size = np.linalg.norm(y[:, 1:])
    assert np.linalg.norm(with_it.state.y - without.state.y) < 1e-6 * size
    # 56 products against 138 here, where the teeth are apart for a fifth of the time
    assert with_it.calls < 0.6 * without.calls


def test_closed_flanks_superpose_exactly(train: Train) -> None:
    """Where nothing parts, lines beside the torus are as good as phases of it."""
    system = train(slow=[(F(1, 27), 6e-6), (F(1, 31), 3e-6)], load=4000.0)
    given = torus_of(response(system))
    point, flat = respond_torus(given, 1.2), respond_torus(given.mesh_orders_only, 1.2)
    lines = superposed_lines(given.mesh_orders_only, flat)
    assert superposition_is_exact(flat, lines)
    # nothing is neglected, so nothing but rounding is stated
    assert max(line.error for line in lines) < 1e-9
    one = torus_outputs(given, point).measures
    other = torus_outputs(given.mesh_orders_only, flat, lines).measures
    # tolerances of the two solutions, 1e-6 of the motion
    np.testing.assert_allclose(one.rms, other.rms, rtol=1e-5)
    # the superposed extremes add amplitudes, which phases of incommensurate lines reach; both are refined samples
    np.testing.assert_allclose(one.highest, other.highest, rtol=1e-3)
    np.testing.assert_allclose(one.lowest, other.lowest, rtol=1e-3)


def test_an_open_flank_is_not_exact_and_says_by_how_much(train: Train) -> None:
    stated = []
    for size in (2e-6, 0.5e-6):
        given = torus_of(response(train(slow=[(F(3, 7), size)])))
        flat, point = respond_torus(given.mesh_orders_only, 2.0), respond_torus(given, 2.0)
        lines = superposed_lines(given.mesh_orders_only, flat)
        assert not superposition_is_exact(flat, lines)
        stated.append(lines[0].error)
        both = torus_outputs(given, point), torus_outputs(given.mesh_orders_only, flat, lines)
        true, ours = (found.measures.rms for found in both)
        without = torus_outputs(given.mesh_orders_only, flat).measures.rms
        # what the line adds to the RMS of the first mesh, a square, is wrong by no more than twice what its force is
        assert abs(true[0] - ours[0]) < 2 * stated[-1] * abs(ours[0] - without[0])
        for found in both:
            assert found.measures.open[0] > 0
            assert found.far[0] == 0
            # teeth that part do not pull, in no sample and not between samples
            assert found.measures.lowest[0] == 0
    # it is wrong for the share of time in which the line decides who touches, which is first order; its RMS the root
    assert 1.7 < stated[0] / stated[1] < 2.4


def test_it_starts_from_what_it_is_given(train: Train) -> None:
    """A motion near another solution leads to that one: branches are followed from speed to speed."""
    given = torus_of(response(train(slow=[(F(1, 27), 3e-6)])))
    found = []
    for path in (np.arange(1.9, 2.01, 0.05), np.arange(2.4, 1.99, -0.1)):
        point = respond_torus(given, path[0])
        for speed in path[1:]:
            point = respond_torus(given, speed, start=(point.problem.grid.points, point.state.y))
        assert point.status == "ok"
        assert point.state.speed == pytest.approx(2.0)
        found.append(torus_outputs(given, point).measures.rms[0])
    # the softening peak hangs over: two motions at one speed, 471 and 832 N
    assert found[1] > 1.5 * found[0]


def test_a_speed_that_fails_says_so_and_raises_nothing(train: Train) -> None:
    given = torus_of(response(train(slow=[(F(1, 27), 6e-6)])))
    lost = respond_torus(given, float("nan"))
    assert lost.status == "not finite"
    assert not lost.converged
    # and leaves the next one alone
    assert respond_torus(given, 1.0).status == "ok"


def test_too_few_rows_are_called_coarse(train: Train) -> None:
    given = torus_of(response(train(slow=[(F(1, 13), 5e-6)])))
    point = respond_torus(given, 2.0)
    assert point.status == "ok"
    assert replace(point, truncation=np.array([2 * TRUNCATION_TOLERANCE, 0.0, 0.0])).status == "coarse"
    assert replace(point, converged=False).status == "not converged"


def test_states_know_which_flanks_touch(train: Train) -> None:
    """Far flanks out of reach are skipped; the answer is that of looking at them."""
    given = torus_of(response(train(slow=[(F(1, 27), 6e-6)])))
    point = respond_torus(given, 2.3)
    made = point.problem
    y, rows = point.state.y, made.rows
    delta = made.grid.values(y.reshape(-1, y.shape[2]) @ rows.gaps.T - made.error)
    np.testing.assert_array_equal(point.state.touching, delta > 0)
    edge = edges(delta, made.grid.counts, rows.axis)
    assert edge is not None
    assert 0 < edge.width.size < 0.1 * delta.size
    inside = np.ones(delta.shape, bool)
    inside[edge.at] = False
    found, looked_at = gap_forces(made, point.state), elastic_forces(made, delta)
    assert point.state.acting is None
    np.testing.assert_allclose(found[inside], looked_at[inside], atol=1e-9 * looked_at.max())


def test_a_grid_too_large_is_not_made(train: Train, monkeypatch: pytest.MonkeyPatch) -> None:
    given = torus_of(response(train(slow=[(F(1, 27), 6e-6)])))
    needed, large = memory(given, 2.3)
    problem = given.prepared(room._first_size(given, 2.3)).fine
    values = int(np.prod(problem.grid.counts)) * len(problem.rows.linear)
    assert (needed, large) == (8.0 * room._HELD * values, False)
    with monkeypatch.context() as patch:
        patch.setattr(room, "TRUNCATION_TOLERANCE", 1e-6)
        grown = respond_torus(given, 2.3)
        # room for the first size alone: rows are not raised
        patch.setattr(room, "_VALUES", values)
        kept = respond_torus(given, 2.3)
    assert kept.size == room._first_size(given, 2.3)
    assert grown.size.harmonics > kept.size.harmonics
    assert kept.truncation_residual > grown.truncation_residual
    # none for the shaft tone: it is superposed, and a sweep says why it has no number
    monkeypatch.setattr(room, "_VALUES", values - 1)
    used, point, lines = steady_motion(given, 2.3)
    assert used.shaft_tones.tones == ()
    assert point.converged
    assert lines
    mesh = respond_torus(given.mesh_orders_only, 2.3)
    at = MeshOrders(points=mesh.problem.grid.points, y=mesh.state.y, speed=2.3, cycles=1, stable=True)
    found = shaft_response(given, at)
    assert found.measures is None
    assert found.status == f"the torus of shaft orders would take {needed / 1e9:.0f} GB"
