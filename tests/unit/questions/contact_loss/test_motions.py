"""Motions with contact loss: against time integration, their energy, their stability and what replaces them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.questions.contact_loss.branch_set import BranchSet, Crossing, mesh_force, periodic_measures
from epicyclic.questions.contact_loss.continuation import linear_start
from epicyclic.questions.contact_loss.solutions import Refinement, Solution, distinct, solution, with_stability
from epicyclic.questions.contact_loss.sweep_direction import (
    IntegratedMotion,
    Reached,
    _reached_at,
    attractor,
    initial_state,
    isolated_motions,
    period_doubled_motions,
    sweep_direction,
    symmetry_broken_motions,
)
from epicyclic.questions.response.response import response
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

Array = NDArray[np.float64]


def found(system: System, speed: float, *, harmonics: int = 32) -> tuple[Refinement, Solution]:
    """The motion that Newton's method reaches from closed teeth, with its Floquet stability."""
    refinement = Refinement(ready=response(system))
    given = refinement.problem(harmonics)
    at = solution(refinement, linear_start(given, speed), speed, balance=given, harmonics=harmonics, fixed=True)
    assert at is not None
    return refinement, with_stability(refinement, at)


def force_over_cycle(system: System, at: Solution) -> Array:
    """Mesh forces over the samples of the period, (m, N)."""
    from epicyclic.questions.contact_loss.problem import flank_force

    return mesh_force(system, flank_force(at.balance, at.state)).T


def test_a_train_that_parts_is_what_time_integration_says(made: Any) -> None:
    system = made.bench()
    _, at = found(system, 1.3, harmonics=48)
    assert at.stable
    assert periodic_measures(system, at.balance, at.state).open.max() > 0.2
    equation, count = made.equation(system, 1.3), at.balance.grid.counts[0]
    start = initial_state(at).ravel()
    states = equation.run(start, 1, samples=count, rtol=1e-7, atol=1e-12)
    force, ours = equation.force(states), force_over_cycle(system, at)
    # 48 harmonics leave 3e-4 of a mesh force with its corners; a wrong term is off by far more
    assert np.abs(force - ours).max() < 1e-3 * np.abs(ours).max()
    assert force.std(axis=1) == pytest.approx(periodic_measures(system, at.balance, at.state).rms, rel=5e-4)
    end = equation.run(start, 1, rtol=1e-7, atol=1e-12)[:, -1]
    assert np.abs(end - start)[:56].max() < 1e-3 * np.abs(start[:56]).max()


def test_every_term_of_the_equation_is_what_time_integration_says(made: Any) -> None:
    system = made.coupled()
    _, at = found(system, 1.1, harmonics=48)
    touching = at.state.touching.mean(axis=0)
    assert np.any((touching > 0) & (touching < 1))
    equation, count = made.equation(system, 1.1), at.balance.grid.counts[0]
    force = equation.force(equation.run(initial_state(at).ravel(), 1, samples=count))
    ours = force_over_cycle(system, at)
    # dampers jump where teeth meet: 48 harmonics and samples of 1/768 cycle hold such a force to a few 1e-3
    assert np.abs(force - ours).mean() < 2e-3 * np.abs(ours).max()


def test_energy_of_a_cycle(made: Any) -> None:
    """Work of loads, of the varying stiffness and of the errors is what modal damping takes, teeth parted or not.

    d/dt [T + V + sum k delta^2 / 2] = push q' + sum (k' delta^2 / 2 - f e') - dissipation, over one period zero.
    """
    system = made.bench()
    _, at = found(system, 1.3, harmonics=48)
    given, state = at.balance, at.state
    w, N = state.speed * given.omega, given.grid.counts[0]
    time = np.arange(N) / N
    rows = state.y.reshape(-1, state.y.shape[2])
    rate_rows = np.concatenate([-w[:, None] * state.y[1], w[:, None] * state.y[0]])
    delta = given.grid.values(rows @ given.rows.gaps.T - given.error)
    J = len(w)
    error_rate = given.grid.values(np.concatenate([-w[:, None] * given.error[J:], w[:, None] * given.error[:J]]))
    orders = np.arange(1, 9)
    turn = 2j * np.pi * 1000 * state.speed * orders
    wave = np.exp(2j * np.pi * np.outer(time, orders)) * turn
    stiffness_rate = given.rows.flanks.stiffness * (wave @ given.rows.flanks.variation.T).real
    pressed = delta > 0
    force = np.where(pressed, given.tangent * delta, 0.0)
    parametric = (np.where(pressed, stiffness_rate * delta**2 / 2, 0.0)).mean(axis=0).sum()
    of_errors = -(force * error_rate).mean(axis=0).sum()
    velocity = given.grid.values(rate_rows) @ given.modal.shapes.T
    of_loads = float((velocity @ system.force).mean())
    lost = float(np.einsum("ti,ij,tj->t", velocity, made.equation(system, state.speed).dampers(), velocity).mean())
    gained = parametric + of_errors + of_loads
    assert abs(parametric) > 0.05 * lost
    assert abs(of_errors) > 0.05 * lost
    # the sums over 768 samples of a force with corners, and 48 harmonics of the motion
    assert gained == pytest.approx(lost, rel=2e-3)


def test_a_broken_symmetry(made: Any) -> None:
    system = made.bench()
    refinement, at = found(system, 2.11)
    assert at.stability is not None
    assert at.stability.kind == "symmetry breaking"
    assert periodic_measures(system, at.balance, at.state).rms.max() == pytest.approx(963, rel=2e-3)
    other = next(symmetry_broken_motions(refinement, at))
    assert other.kind == "symmetry broken"
    assert other.stable
    # the known values have three and four figures
    assert periodic_measures(system, other.balance, other.state).rms.max() == pytest.approx(1129, rel=2e-3)
    # time integration from the unstable motion, a little off, goes there
    pytest.importorskip("numba")
    random = np.random.default_rng(1)
    start = initial_state(at)
    reached = attractor(refinement, start * (1 + 0.05 * random.standard_normal(start.shape)), 2.11, harmonics=16)
    assert isinstance(reached, Solution)
    assert periodic_measures(system, reached.balance, reached.state).rms.max() == pytest.approx(1129, rel=2e-3)


def half_order_pair(made: Any) -> System:
    """A pair near twice its natural frequency, where its stiffness shakes it most."""
    system: System = made.single(variation=(0.045,), zeta=0.008, load=1130.0, backlash=5e-5)
    return system


def test_two_cycles_near_twice_the_natural_frequency(made: Any) -> None:
    system = half_order_pair(made)
    refinement, at = found(system, 2.0, harmonics=16)
    assert at.stability is not None
    assert at.stability.kind == "period doubling"
    assert at.stability.multiplier.real < -1
    small = periodic_measures(system, at.balance, at.state).rms.max()
    other = next(period_doubled_motions(refinement, at))
    assert other.kind == "period 2"
    assert other.stable
    large = periodic_measures(system, other.balance, other.state).rms.max()
    assert large > 15 * small
    # DOP853 over two cycles from its state comes back to it, and to no such place after one
    equation = made.equation(system, 2.0)
    start = initial_state(other).ravel()
    once, twice = (equation.run(start, cycles)[:, -1] for cycles in (1, 2))
    scale = np.abs(start)
    assert np.all(np.abs(twice - start) < 2e-3 * scale.max() + 2e-3 * scale)
    assert np.abs(once - start)[0] > 0.5 * scale[0]


def test_multipliers_are_those_of_a_disturbed_run(made: Any) -> None:
    system: System = made.single(variation=(0.3,), zeta=0.05, load=2000.0, backlash=5e-5)
    _, at = found(system, 0.95)
    assert 0 < periodic_measures(system, at.balance, at.state).open.max() < 1
    assert at.stability is not None
    equation, start = made.equation(system, 0.95), initial_state(at).ravel()
    size = np.array([1e-7, 1e-7 * 2 * np.pi * 1000])
    columns = []
    for place in range(2):
        step = np.zeros(2)
        step[place] = size[place]
        ends = [equation.run(start + sign * step, 1, rtol=1e-10, atol=1e-16)[:, -1] for sign in (1, -1)]
        columns.append((ends[0] - ends[1]) / 2 / size[place])
    ours = np.linalg.eigvals(np.array(columns).T)
    # 48 steps a cycle, where the contact changes within a step: 2e-3
    assert max(abs(ours)) == pytest.approx(abs(at.stability.multiplier), rel=4e-3)


def test_kicks_find_what_is_not_connected(made: Any) -> None:
    system = half_order_pair(made)
    refinement, at = found(system, 1.9, harmonics=16)
    assert at.stable  # the small motion is stable here, and the large one is there too
    others = isolated_motions(refinement, at, cycles=2, tries=12)
    assert len(others) == 1  # shifted by a cycle it is the same
    assert others[0].stable
    assert distinct(at, others[0])
    small, large = (periodic_measures(system, each.balance, each.state).rms.max() for each in (at, others[0]))
    assert large > 10 * small


def test_a_motion_that_never_repeats_is_recorded(made: Any) -> None:
    pytest.importorskip("numba")
    system = made.bench()
    refinement = Refinement(ready=response(system))
    given = refinement.problem(16)
    start = linear_start(given, 1.46)
    shapes = given.modal.shapes
    state = np.stack([start[0].sum(axis=0), -(1.46 * given.omega) @ start[1]]) @ shapes.T
    reached = attractor(refinement, state, 1.46, harmonics=16)
    assert isinstance(reached, IntegratedMotion)
    # the periodic motion has 1715 N there and is unstable
    assert 1500 < reached.measures.rms.max() < 1800


def test_a_train_that_turns_freely_and_drifts_settles(made: Any) -> None:
    pytest.importorskip("numba")
    system = assemble(load("xu2020"))
    speed = 1700.0 / float(system.tones[0])
    refinement, at = found(system, speed, harmonics=16)
    modal = refinement.ready.modal
    assert modal.rigid.sum() == 1
    start = initial_state(at)
    # every gear gains a little speed: nothing is stretched by it, and nothing holds it
    start[1] += 200 * np.abs(start[0]).max() * modal.shapes[:, modal.rigid][:, 0] / np.abs(modal.shapes).max()
    reached = attractor(refinement, start, speed, harmonics=16)
    assert isinstance(reached, Solution)
    assert not distinct(at, reached)


def reached_from(refinement: Refinement, at: Solution, last: Array) -> Reached:
    """What a sweep direction reaches where a record has ended in a state (2, n) beside a motion of the branch set."""
    measures = periodic_measures(refinement.ready.system, at.balance, at.state)
    record = IntegratedMotion(speed=at.state.speed, last=last, measures=measures, unchanging=False)
    choices = [Crossing(solution=at, part=3)]
    return _reached_at(refinement, at.state.speed, Reached(motion=record, part=3), choices, "replace")


def test_a_record_goes_on_beside_a_stable_motion(made: Any) -> None:
    pytest.importorskip("numba")
    refinement, small = found(half_order_pair(made), 1.9, harmonics=16)
    assert small.stable
    (large,) = isolated_motions(refinement, small, cycles=2, tries=12)
    reached = reached_from(refinement, small, initial_state(large))
    assert isinstance(reached.motion, Solution)
    assert reached.motion.kind == "period 2"
    assert not distinct(reached.motion, large)
    assert (reached.part, reached.jumped, reached.instability) == (3, False, "")
    back = reached_from(refinement, small, initial_state(small))
    assert isinstance(back.motion, Solution)
    assert not distinct(back.motion, small)
    assert back.part == 3


def test_a_record_of_closed_teeth_is_the_motion_it_decays_to(made: Any) -> None:
    """A disturbance that 80 cycles do not damp: no periodic motion is seen yet, and there is one alone."""
    pytest.importorskip("numba")
    refinement, at = found(made.single(variation=(0.1,), zeta=2e-4, load=2000.0), 0.7, harmonics=8)
    assert at.stable
    start = initial_state(at)
    reached = reached_from(refinement, at, start * np.array([[1.3], [1.0]]))
    assert reached.motion is at
    # one that parts the teeth at first has still parted them when it ends, and stays a record
    parting = reached_from(refinement, at, start * np.array([[6.0], [1.0]]))
    assert isinstance(parting.motion, IntegratedMotion)
    assert not parting.motion.unchanging
    assert parting.motion.measures.open.max() > 0


def test_a_direction_without_a_branch_begins_on_the_attractor_of_closed_teeth(made: Any) -> None:
    pytest.importorskip("numba")
    refinement, at = found(made.single(variation=(0.1,), zeta=0.05, load=2000.0), 0.7, harmonics=16)
    nothing = BranchSet(speeds=np.array([0.7]), segments=[], crossings=[[]], ended=[0.7])
    ((place, reached),) = sweep_direction(refinement, nothing, upward=True)
    assert (place, reached.part, reached.jumped) == (0, None, False)
    assert isinstance(reached.motion, Solution)
    assert not distinct(reached.motion, at)
    ((_, left),) = sweep_direction(refinement, nothing, upward=True, unstable="report")
    assert left.motion is None
