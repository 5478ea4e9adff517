"""Integrators show their order: errors fall with the step, or with the tolerance, as theory says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from epicyclic.questions.transient.equation import Motion, from_modal, motion, program, to_modal
from epicyclic.questions.transient.integrators import acceleration, adaptive_states, instant_terms, integrate
from epicyclic.system.system import Dofs, Line, LinkRows, MeshRows, System

Array = NDArray[np.float64]
START, STOP = np.array([[1e-5, -2e-5], [0.01, 0.02]]), 0.01


def two_masses() -> System:
    """Two masses with one mesh whose stiffness and error wave, gyroscopic terms and dampers; smooth in time."""
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    row = np.array([[1.0], [-0.7]])
    tone = Fraction(180)
    line = Line(
        frequency=2 * tone,
        gap=np.array([4e-6j]),
        link_gap=np.zeros(0, complex),
        force=np.array([[5.0, 0.0], [0.0, 3j], [1j, 0.0]]),
        ramp_force=np.array([2.0, 1j]),
    )
    return System(
        dofs=Dofs(
            names=("a/x", "b/x"), body=("a", "b"), direction=("x", "x"), radius=np.ones(2), bodies=("a", "b"),
            expand=np.zeros((12, 2)),
        ),
        M=np.diag([1.0, 1.4]), C=np.diag([20.0, 5.0]), G=30 * turn, K=np.diag([3e5, 2e5]), Kg=-1e4 * np.eye(2),
        Cskew=2e3 * turn, euler=15 * turn,
        meshes=MeshRows(
            name=("a-b",), pair=("a-b",), stage=("main",), branch=(0,), side=("",), B=row, stiffness=np.array([8e5]),
            variation=np.array([[0.3, 0.1j]]), tone=np.zeros(1, np.int64), damping=np.array([30.0]),
            backlash=np.full(1, np.inf), cos_base_helix=np.ones(1),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((2, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=np.array([60.0, -40.0]), tones=(tone,), lines=(line,),
    )  # fmt: skip


@pytest.fixture(scope="module")
def moving() -> Motion:
    """A ramp of the speed and a load that jumps at half time, on a step of every run."""
    given = program([0.0, STOP / 2, STOP / 2, STOP], [0.5, 0.8, 0.8, 1.1], [[0.0], [0.2], [1.0], [0.5]])
    return motion(two_masses(), program=given, contact="linear", loads=np.array([[30.0, 10.0]]))


@pytest.fixture(scope="module")
def exact(moving: Motion) -> Array:
    return adaptive(moving, "dop853", 1e-13)


def adaptive(moving: Motion, method: Any, tolerance: float) -> Array:
    begin, times = to_modal(moving, START), np.array([0.0, STOP / 2, STOP])
    found, _ = adaptive_states(
        moving,
        begin,
        times,
        method=method,
        tolerance=tolerance,
    )
    return from_modal(moving, found[-1])


def slope(error: Callable[[float], float], sizes: list[float]) -> float:
    return float(np.polyfit(np.log(sizes), np.log([error(size) for size in sizes]), 1)[0])


def size_of(difference: Array, exact: Array) -> float:
    return float((np.abs(difference).max(axis=1) / np.abs(exact).max(axis=1)).max())


def test_runge_kutta_has_order_four(moving: Motion, exact: Array) -> None:
    def error(step: float) -> float:
        return size_of(integrate(moving, START, stop=STOP, steps=round(STOP / step))[0][-1] - exact, exact)

    assert abs(slope(error, [STOP / count for count in (60, 120, 240, 480)]) - 4) < 0.2


def test_a_jump_beside_the_steps_costs_the_order(moving: Motion, exact: Array) -> None:
    """Why a torque step is moved to a step of the run: an odd number of them has the jump in the middle of one."""

    def error(step: float) -> float:
        return size_of(integrate(moving, START, stop=STOP, steps=round(STOP / step))[0][-1] - exact, exact)

    assert slope(error, [STOP / count for count in (61, 121, 241, 481)]) < 2.5


@pytest.mark.parametrize(("method", "order", "steps"), [("DOP853", 8, (6, 8, 10, 12)), ("Radau", 5, (40, 57, 80, 113))])
def test_adaptive_methods_have_their_order_on_this_equation(
    moving: Motion, method: str, order: int, steps: tuple[int, ...]
) -> None:
    """With steps held at one length, over the first half, which is smooth."""
    n, stop = 2, STOP / 2
    begin = to_modal(moving, START).ravel()

    def run(count: int, name: str, **options: float) -> Array:
        def equation(t: float, flat: Array) -> Array:
            at = instant_terms(moving, t, min(t, 0.999 * stop))
            return np.concatenate([flat[n:], acceleration(moving, at, flat[:n], flat[n:])])

        step = stop / count
        limits = {"max_step": step, "first_step": step, "rtol": 1e3, "atol": 1e3} | options
        return np.asarray(solve_ivp(equation, (0, stop), begin, method=name, **limits).y[:, -1].reshape(2, n))

    known = run(4, "DOP853", max_step=np.inf, rtol=1e-13, atol=1e-18)
    # a loose tolerance lets the Newton iteration of an implicit method stop too early
    more = {"rtol": 1e-3, "atol": 1e-12} if method == "Radau" else {}
    found = slope(
        lambda step: size_of(run(round(stop / step), method, **more) - known, known), [stop / c for c in steps]
    )
    assert abs(found - order) < 0.2 if method == "DOP853" else found > order - 0.5


# DOP853 estimates its error in the order it has; Radau estimates h^4 and errs by h^5.
@pytest.mark.parametrize(("method", "rate"), [("dop853", 1.0), ("radau", 1.25)])
def test_errors_follow_the_tolerance(moving: Motion, exact: Array, method: str, rate: float) -> None:
    tolerances = [1e-4, 1e-5, 1e-6, 1e-7]
    found = slope(lambda tolerance: size_of(adaptive(moving, method, tolerance) - exact, exact), tolerances)
    assert abs(found - rate) < 0.2


@pytest.mark.parametrize(("damper", "order"), [(0.0, 2.0), (200.0, 1.0)])
def test_order_across_contact(damper: float, order: float) -> None:
    """Teeth that meet inside a step: the force has a kink there, or with a damper of the contact a jump."""
    system = two_masses()
    system = replace(system, meshes=replace(system.meshes, damping=np.array([damper])))
    moving = motion(system, program=program([0.0, 1.0], [1.0, 1.0]))
    start = np.array([[-1e-5, 2e-5], [0.5, -0.2]])
    exact = integrate(moving, start, stop=STOP, steps=200_000, keep=200_000)[0][-1]
    # where in its step a kink falls is chance: the mean of neighbours, many of them
    sizes, means = [100, 200, 400, 800, 1600, 3200], []
    for size in sizes:
        counts = [size + 7 * i for i in range(12)]
        errors = [size_of(integrate(moving, start, stop=STOP, steps=c, keep=c)[0][-1] - exact, exact) for c in counts]
        means.append(float(np.mean(errors)))
    found = -float(np.polyfit(np.log(np.array(sizes) + 38), np.log(means), 1)[0])
    assert abs(found - order) < 0.2
    gap = integrate(moving, start, stop=STOP, steps=2000)[0][:, 0] @ np.array([1.0, -0.7])
    assert (gap < -1e-5).any()
    assert (gap > 1e-5).any()
