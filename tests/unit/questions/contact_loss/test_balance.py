"""The balance of flanks that part: its derivatives, its linear limit, dampers of the contact, several tones."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.unit.system.test_flank_laws import composite

import epicyclic
from epicyclic.questions.contact_loss.continuation import linear_start, solve, truncated_orders, truncation_residual
from epicyclic.questions.contact_loss.problem import (
    Problem,
    State,
    evaluate,
    flank_force,
    jacobian,
    mesh_problem,
    prolonged,
    speed_derivative,
    unknowns,
)
from epicyclic.questions.contact_loss.rows import GridLaws
from epicyclic.questions.response.response import FrameSpeed, respond, response
from epicyclic.statics.tangent import linear


def solved(given: Problem, speed: float) -> State:
    """A solution to rounding, from closed flanks."""
    found = solve(given, linear_start(given, speed), speed, tolerance=1e-13, steps=60)
    assert found.state.norm < 1e-11 * np.linalg.norm(found.state.y)
    return found.state


@pytest.mark.parametrize("tones", [1, 2])
@pytest.mark.parametrize("frame", ["kinematic", "operating"])
def test_the_jacobian_is_the_derivative_along_a_motion(made: Any, tones: int, frame: FrameSpeed) -> None:
    given = mesh_problem(response(made.coupled(tones=tones), frame_speed=frame), harmonics=4, cross=3)
    random = np.random.default_rng(0)
    y = 0.3 * linear_start(given, 0.9)
    y += 0.3 * np.abs(y).max() * random.standard_normal(unknowns(given))
    step = random.standard_normal(unknowns(given))
    y[1, 0] = step[1, 0] = 0.0  # the mean has no imaginary part
    at = evaluate(given, y, 0.9)
    h = 1e-9 * np.linalg.norm(y)
    ahead, behind = (evaluate(given, y + sign * h * step, 0.9) for sign in (1, -1))
    # no sample may change its contact in between: there the balance is a polygon with a corner
    assert np.array_equal(ahead.touching, behind.touching)
    assert 0.05 < at.touching.mean() < 0.95
    differences = (ahead.residual - behind.residual) / (2 * h)
    # linear between corners: what is left is rounding over the step, 1e-16 / 1e-9
    np.testing.assert_allclose(jacobian(given, at)(step), differences, atol=1e-7 * np.abs(differences).max())


# Speeds [Hz] near which teeth part; play and rolling elements: tangents of a link along x, y and x + y.
LINKS = {
    "stages.main.sun.support.clearance": "20 um",
    "stages.main.planet.bearing.clearance": "10 um",
    "stages.main.planet.bearing.exponent": 1.111,
    "stages.main.planet.bearing.load": "50 kN",
}
DRIVES: dict[str, tuple[str, float, dict[str, object]]] = {
    "ren2021": ("ren2021", 445.0, {}),
    "ren2021 with mesh dampers": ("ren2021", 445.0, {"damping.mesh": 0.02}),
    "ren2021 with laws of links": ("ren2021", 200.0, LINKS),
    "xu2020": ("xu2020", 1580.0, {}),
    "xu2020 with mesh dampers": ("xu2020", 1580.0, {"damping.mesh": 0.02}),
}


@pytest.mark.parametrize("name", DRIVES)
def test_the_jacobian_of_a_drive_is_the_derivative_at_edges_of_contact(name: str) -> None:
    drive, frequency, overrides = DRIVES[name]
    system = epicyclic.assemble(epicyclic.load(drive, overrides))
    given, speed = mesh_problem(response(system, asks_laws=True), harmonics=8), frequency / float(system.tones[0])
    y = linear_start(given, speed)
    y[:, 1:] *= 2.0  # twice the vibration of closed teeth: they part
    step = np.random.default_rng(1).standard_normal(y.shape)
    step[1, 0] = 0.0  # the mean has no imaginary part
    step *= np.linalg.norm(y[:, 1:]) / np.linalg.norm(step)
    at = evaluate(given, y, speed)
    assert 0.05 < at.touching.mean() < 0.95
    assert at.width is not None
    assert at.width.at[0].size > 5
    assert (at.acting is not None) == ("damping.mesh" in overrides)
    h = 1e-5
    ahead, behind = (evaluate(given, y + sign * h * step, speed) for sign in (1, -1))
    differences = (ahead.residual - behind.residual) / (2 * h)
    # 2e-10 .. 2e-9: h^2 of a third derivative, and rounding 1e-16 / h
    np.testing.assert_allclose(jacobian(given, at)(step), differences, atol=1e-8 * np.abs(differences).max(), rtol=0)


@pytest.mark.parametrize("apart", [0.0, 1e-3])
def test_the_jacobian_where_loaded_flanks_or_all_are_away(made: Any, apart: float) -> None:
    """The loaded flanks, the first rows, are left out of the laws, and where they stay apart [m] the far ones too."""
    given = mesh_problem(response(made.coupled()), harmonics=4)
    rows, random = given.rows, np.random.default_rng(0)
    far = rows.count // 2
    mean = given.error[0, : rows.count] - np.repeat([1e-3, apart], far)  # open by a millimetre; just touching, or too
    y = np.zeros(unknowns(given))
    y[0, 0] = np.linalg.lstsq(rows.gaps[: rows.count], mean, rcond=None)[0]
    y[:, 1:] = 2e-5 * random.standard_normal(y[:, 1:].shape)
    step = random.standard_normal(y.shape)
    step[1, 0] = 0.0
    at = evaluate(given, y, 0.9)
    assert not at.touching[:, :far].any()
    assert at.touching.any() == (apart == 0.0)
    assert apart or (at.width is not None and at.width.at[1].min() >= far)
    assert rows.drag.any()
    h = 1e-5 * np.linalg.norm(y[:, 1:])
    ahead, behind = (evaluate(given, y + sign * h * step, 0.9) for sign in (1, -1))
    differences = (ahead.residual - behind.residual) / (2 * h)
    np.testing.assert_allclose(jacobian(given, at)(step), differences, atol=1e-7 * np.abs(differences).max(), rtol=0)


@pytest.mark.parametrize("axes", [(0,), (0, 1)])
def test_laws_of_some_flanks_are_those_of_all_at_their_columns(axes: tuple[int, ...]) -> None:
    """Linear flanks and tables, all along one phase or some along another; and with a part of their curvature."""
    whole, counts = composite(), (12, 5)[: len(axes)]
    parts = []
    for axis, columns in zip(axes, np.array_split(np.arange(7), len(axes)), strict=True):
        phases = np.zeros((counts[axis], 2))
        phases[:, axis] = np.arange(counts[axis]) / counts[axis]
        parts.append((whole.at(phases).rows(columns), columns, axis))
    laws, chosen = GridLaws(parts=tuple(parts), counts=counts, count=7), np.array([0, 1, 0, 1, 0, 0, 1], bool)
    delta = np.random.default_rng(1).uniform(-8e-6, 2e-5, (np.prod(counts), 7))
    for every in (laws, laws.eased(np.full(7, 4e8), 0.5)):
        for some, one in zip(every.of(chosen).evaluate(delta[:, chosen]), every.evaluate(delta), strict=True):
            np.testing.assert_allclose(some, one[:, chosen], rtol=1e-12, atol=1e-12 * one.max())
        np.testing.assert_array_equal(every.of(chosen).opening(delta[:, chosen]), every.opening(delta)[:, chosen])
    presses = np.array([laws.evaluate(laws.least_touch + gap + 0 * delta)[0].any(axis=0) for gap in (-1e-12, 1e-12)])
    assert not presses[0].any()
    assert presses[1].all()


def test_truncation_residual_is_the_residual_on_the_orders_dropped(made: Any) -> None:
    """Of the same motion in a balance with all orders of the grid."""
    ready = response(made.coupled())
    small, large = (mesh_problem(ready, harmonics=harmonics, samples=49) for harmonics in (4, 24))
    state = solved(small, 1.1)
    assert 0.05 < state.touching.mean() < 0.95
    dropped = truncated_orders(small, np.array([float(ready.omega[0])]), mesh=1, orders=())
    found = evaluate(large, prolonged(small, large, state.y), 1.1)
    exact = np.linalg.norm(found.residual[:, 5:])
    assert exact > 3e-4 * np.linalg.norm(state.y)
    assert np.linalg.norm(truncation_residual(small, state, dropped)) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("frame", ["kinematic", "operating"])
def test_derivative_with_the_speed(made: Any, frame: FrameSpeed) -> None:
    given = mesh_problem(response(made.coupled(), frame_speed=frame), harmonics=8)
    at = solved(given, 1.1)
    assert 0.05 < at.touching.mean() < 0.95
    h = 1e-6
    ahead, behind = (evaluate(given, at.y, 1.1 + sign * h) for sign in (1, -1))
    differences = (ahead.residual - behind.residual) / (2 * h)
    # central differences: h^2 of a third derivative, and rounding 1e-16 / h
    np.testing.assert_allclose(speed_derivative(given, at), differences, atol=1e-7 * np.abs(differences).max())


@pytest.mark.parametrize("tones", [1, 2])
def test_without_parting_it_is_the_linear_response(made: Any, tones: int) -> None:
    system = made.coupled(tones=tones, load=3000.0, far=False)
    ready = response(system)
    block = next(respond(ready, np.array([0.8]), tolerance=1e-12))
    given = mesh_problem(ready, harmonics=tuple(block.truncation[:-1]), cross=block.truncation[-1])
    state = evaluate(given, block.mesh.y[0], 0.8)
    assert state.touching.all()
    # the linear solver's own residual 1e-12, and sums over samples that its convolutions do without
    assert state.norm < 1e-10 * np.linalg.norm(state.y)


def test_assumed_contact_of_a_drive_with_laws_of_links_is_its_tangents() -> None:
    """The linear response of the System with tangents in place of all laws, preload and all, by the linear solver."""
    system = epicyclic.assemble(epicyclic.load("ren2021", LINKS))
    system = replace(system, lines=tuple(one for one in system.lines if one.frequency % system.tones[0] == 0))
    assert system.groups
    assert any(one.group_gap.any() for one in system.lines)
    tangents = response(linear(system, floating=True))
    block = next(respond(tangents, np.array([20.0]), tolerance=1e-12))
    sizes: dict[str, Any] = {"harmonics": tuple(block.truncation[:-1]), "cross": block.truncation[-1]}
    y = block.mesh.y[0]
    by_tangents = mesh_problem(tangents, **sizes)
    assert evaluate(by_tangents, y, 20.0, touching=by_tangents.rows.flanks.sense > 0).norm < 1e-10 * np.linalg.norm(y)
    given = mesh_problem(response(system, asks_laws=True), **sizes)
    at = evaluate(given, y, 20.0, touching=given.rows.flanks.sense > 0)
    # rounding of modes of two Systems
    assert at.norm < 1e-9 * np.linalg.norm(y)
    assert given.rows.links is not None
    assert np.abs(given.rows.links.offset).max() > 1e-3 * np.abs(system.force).max()


def test_dampers_act_with_the_contact_alone(made: Any) -> None:
    given = mesh_problem(response(made.coupled()), harmonics=8)
    state = solved(given, 1.1)
    force = flank_force(given, state)
    distinct = ~(state.touching | np.roll(state.touching, 1, axis=0) | np.roll(state.touching, -1, axis=0))
    assert distinct.any()
    assert np.all(force[distinct] == 0)
    # where it touches the force is k delta + c delta', and the damper is a fair part of it
    without = flank_force(mesh_problem(response(made.coupled(drag=0.0)), harmonics=8), state)
    assert np.abs(force - without)[state.touching].max() > 0.02 * np.abs(force).max()


def test_two_cycles_hold_the_motion_of_one(made: Any) -> None:
    ready = response(made.coupled())
    one, two = mesh_problem(ready, harmonics=6), mesh_problem(ready, harmonics=6, cycles=2)
    state = solved(one, 1.1)
    y = np.zeros(unknowns(two))
    y[:, ::2] = state.y
    assert evaluate(two, y, 1.1).norm < 1e-11 * np.linalg.norm(y)
    # an error at another place of the period is seen
    y[:, 1] += 0.01 * y[:, 2]
    assert evaluate(two, y, 1.1).norm > 1e-3 * np.linalg.norm(y[:, 1])
