"""Coulomb friction with a memory in motion: sliders that move, against closed forms, histories and fine steps."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from epicyclic.questions.transient import TransientOptions, integrators
from epicyclic.questions.transient import scenario as run_module
from epicyclic.questions.transient.equation import constant, from_modal, motion, program, to_modal
from epicyclic.questions.transient.integrators import AHEAD, adaptive_states, at_equilibrium, at_rest, integrate
from epicyclic.questions.transient.transient import group_force, group_stretch, transient
from epicyclic.statics.record import record_of
from epicyclic.statics.static import held_train, quasi_static
from epicyclic.system.link_laws import Law, LawGroup, stacked
from epicyclic.system.system import Line, System

Array = NDArray[np.float64]
K, FRICTION, CLEARANCE = 1e6, 20.0, 1e-4
TONE = Fraction(100)  # that of the systems of the fixture
START = FRICTION / K


def group(B: Array, *, lag: float = 0.0, name: str = "main/0/spline", **law: Any) -> LawGroup:
    numbers = {"stiffness": K, "clearance": CLEARANCE, "friction": FRICTION, "memory": True} | law
    return LawGroup(
        name=name,
        kind="coupling",
        rows=tuple(f"{name}/{x}" for x in "xy"[: B.shape[1]]),
        B=B,
        law=Law(**numbers),
        damping=np.zeros(B.shape[1]),
        lag=lag,
    )


def oscillator(made: Any, *, amplitude: float = 0.0, force: float = 0.0, soft: float = 2e5, c: float = 0.0) -> System:
    """1 kg on a spring and a spline under a harmonic force at 100 Hz; a flank that is never touched."""
    one = np.ones((1, 1))
    push = np.zeros((3, 1), complex)
    push[0, 0] = amplitude
    line = Line(frequency=TONE, gap=np.zeros(1, complex), link_gap=np.zeros(0, complex),
                force=push, group_gap=np.zeros(1, complex))  # fmt: skip
    system: System = made.system(
        one, soft * one, 0 * one, np.array([1e6]), force=np.array([force]), lines=(line,), groups=(group(one),),
        C=c * one,
    )  # fmt: skip
    return system


def plane(made: Any, *, lag: float = 0.0, clearance: float = CLEARANCE) -> System:
    """A mass in x and y on a spline, pushed round and along."""
    two = np.eye(2)
    push = np.zeros((3, 2), complex)
    push[0] = [60.0, 35j]
    slow = np.zeros((3, 2), complex)
    slow[0] = [25.0, -20.0]
    none = np.zeros(0, complex)
    lines = (
        Line(frequency=TONE, gap=np.zeros(1, complex), link_gap=none, force=push, group_gap=np.array([3e-6, 2e-6j])),
        Line(frequency=TONE / 3, gap=np.zeros(1, complex), link_gap=none, force=slow),
    )
    system: System = made.system(
        two, 2e5 * two, np.zeros((2, 1)), np.array([1e6]), force=np.array([10.0, 0.0]), lines=lines,
        groups=(group(two, lag=lag, clearance=clearance),), C=50.0 * two,
    )  # fmt: skip
    return system


@pytest.mark.parametrize("lag", [0.0, 2e-5])
@pytest.mark.parametrize("clearance", [CLEARANCE, 1.5e-5])
def test_compiled_sliders_are_the_law(lag: float, clearance: float) -> None:
    """Force and slider of one group after another, one row and two, in stick, slip and at the stop."""
    pytest.importorskip("numba")
    from epicyclic.questions.transient import compiled

    rng = np.random.default_rng(5)
    held: Any = compiled._held
    slid: Any = compiled._slid
    for rows in (1, 2):
        one = group(np.eye(2)[:, :rows], lag=lag, clearance=clearance)
        laws = stacked([one])
        numbers = np.array([0, rows, K, -FRICTION, START, START + clearance, K, 1.0, lag, clearance])
        seen = set()
        for _ in range(200):
            delta, rate = rng.normal(size=rows) * 10 ** rng.uniform(-6, -4), rng.normal(size=rows)
            anchor = rng.normal(size=rows)
            anchor *= clearance * rng.choice([1.0, rng.random()]) / np.linalg.norm(anchor)
            ahead = delta + AHEAD * START * rate / np.linalg.norm(rate)
            force = laws.force(delta, anchor) + lag * laws.tangent(ahead, anchor) @ rate
            place = laws.slide(delta, anchor)
            full = [np.append(each, 0.0)[:2] for each in (delta, rate, anchor)]
            found = held(numbers, *full[0], *full[1], *full[2], rows == 2)
            *moved, _ = slid(numbers, *full[0], *full[2], rows == 2)
            np.testing.assert_allclose(moved[:rows], place, rtol=1e-12, atol=1e-12 * clearance)
            # the tangent at the stop divides by what may be small: a part of 1e-12 times lag k
            np.testing.assert_allclose(found[:rows], force, rtol=1e-10, atol=1e-11 * (FRICTION + lag * K))
            seen.add(int(laws.state(delta, anchor)[0]))
        assert seen == {1, 2, 3}


@pytest.mark.parametrize("lag", [0.0, 2e-5])
@pytest.mark.parametrize("clearance", [CLEARANCE, 2e-5])
def test_compiled_steps_equal_numpy(made: Any, monkeypatch: pytest.MonkeyPatch, lag: float, clearance: float) -> None:
    pytest.importorskip("numba")
    moving = motion(plane(made, lag=lag, clearance=clearance), program=constant(0.9))
    fast, sliders = integrate(moving, at_rest(moving), stop=0.025, steps=150, keep=3)
    monkeypatch.setattr(integrators, "numba_available", lambda: False)
    slow, other = integrate(moving, at_rest(moving), stop=0.025, steps=150, keep=3)
    # the same steps with sums in another order: rounding, grown over 150 steps
    np.testing.assert_allclose(fast, slow, rtol=1e-9, atol=1e-11 * np.abs(slow).max())
    np.testing.assert_allclose(sliders, other, rtol=1e-9, atol=1e-10 * clearance)
    assert np.ptp(sliders, axis=0).min() > 0.1 * clearance
    stretch = group_stretch(moving, np.linspace(0, 0.025, 51), fast)
    states = set(np.ravel(moving.laws.state(stretch, sliders)).tolist())
    assert states >= ({1, 3} if clearance < CLEARANCE else {1})


def slow_cycles(made: Any, X: float, *, cycles: int = 2, steps: int = 20_000) -> tuple[Array, Array]:
    """Stretch and force of the spline over the last of some slow cycles between -X and X."""
    soft = 2e8  # a spring that carries nearly all of the load: the stretch is prescribed
    system = oscillator(made, amplitude=soft * X, soft=soft, c=2 * np.sqrt(soft))
    moving = motion(system, program=constant(0.02))
    stop = cycles / 2.0
    start = at_equilibrium(moving)
    states, sliders = integrate(moving, start, stop=stop, steps=cycles * steps, keep=steps // 1000)
    times = np.linspace(0, stop, len(states))
    stretch = group_stretch(moving, times, states)
    force = moving.laws.force(stretch, sliders)
    np.testing.assert_allclose(np.abs(force[:, 0]), group_force(moving, times, states, sliders)[0])
    last = slice(-1001, None)
    return stretch[last, 0], force[last, 0]


def test_area_of_the_hysteresis_loop(made: Any) -> None:
    """4 F_m (X - S_1) a cycle of prescribed amplitude, in slip without the stop."""
    for X in (3e-5, 8e-5):
        x, f = slow_cycles(made, X)
        amplitude = np.ptp(x) / 2
        area = float(np.abs(trapezoid(f, x)))
        # 1000 samples a cycle: corners of the loop between samples
        assert area == pytest.approx(4 * FRICTION * (amplitude - START), rel=1e-4)
        assert amplitude == pytest.approx(X, rel=0.01)
        assert np.abs(f).max() == pytest.approx(FRICTION, rel=1e-9)
    x, f = slow_cycles(made, 0.9 * START)
    assert float(np.abs(trapezoid(f, x))) < 1e-9 * FRICTION * START  # sticks: no loop


def reference(system: System, speed: float, stop: float, steps: int) -> tuple[Array, Array]:
    """Semi-implicit steps of the one-mass oscillator with its slider in closed form, written out; first order."""
    k, soft, c = K, float(system.K[0, 0]), float(system.C[0, 0])
    h, turn = stop / steps, 2 * np.pi * 100.0 * speed
    x = v = s = 0.0
    found = np.empty((steps + 1, 2))
    found[0] = x, s
    for i in range(steps):
        push = system.force[0] + system.lines[0].force[0, 0].real * np.cos(turn * i * h)
        v += h * (push - soft * x - c * v - k * (x - s))
        x += h * v
        s = min(max(min(max(s, x - START), x + START), -CLEARANCE), CLEARANCE)
        found[i + 1] = x, s
    return found[:, 0], found[:, 1]


def test_a_friction_oscillator_under_a_harmonic_force(made: Any) -> None:
    """Against small steps of another method, whose error halves with the step."""
    system = oscillator(made, amplitude=60.0, c=40.0)
    stop, speed = 0.05, 1.1
    moving = motion(system, program=constant(speed))
    # without a mean load the slider starts in the middle
    found, sliders = integrate(moving, np.zeros((2, 1)), stop=stop, steps=20_000, keep=200)
    far = []
    for steps in (50_000, 100_000):
        x, s = reference(system, speed, stop, steps)
        x, s = x[:: steps // 100], s[:: steps // 100]
        size = np.abs(x).max()
        far.append(max(np.abs(found[:, 0, 0] - x).max(), np.abs(sliders[:, 0] - s).max()) / size)
    assert far[1] < 1e-3
    assert far[0] / far[1] == pytest.approx(2.0, rel=0.1)
    assert np.ptp(sliders) > START
    held = motion(replace(system, groups=(group(np.ones((1, 1)), friction=1e9),)), program=constant(speed))
    stuck = integrate(held, np.zeros((2, 1)), stop=stop, steps=20_000, keep=200)[0]
    assert np.abs(stuck[:, 0, 0] - found[:, 0, 0]).max() > 0.1 * size  # a slider that stays put is seen


def test_order_of_fixed_steps(made: Any) -> None:
    moving = motion(oscillator(made, amplitude=60.0, c=40.0), program=constant(1.1))
    counts = [400, 800, 1600, 3200]
    exact = integrate(moving, np.zeros((2, 1)), stop=0.05, steps=200_000, keep=200_000)[0][-1, 0, 0]
    errors = []
    for count in counts:
        # where in its step a pull turns round is chance: the mean of neighbours
        near = [count + 7 * i for i in range(8)]
        found = [integrate(moving, np.zeros((2, 1)), stop=0.05, steps=c, keep=c)[0] for c in near]
        errors.append(np.mean([abs(states[-1, 0, 0] - exact) for states in found]))
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert 1.7 < slope < 2.7


@pytest.mark.parametrize("method", ["dop853", "radau"])
def test_adaptive_methods_move_the_sliders(made: Any, method: Any) -> None:
    """Both rows of a line and of a plane against fine fixed steps; the tolerance is felt."""
    moving = motion(oscillator(made, amplitude=60.0, c=40.0), program=constant(1.1))
    times, start = np.linspace(0, 0.006, 7), np.zeros((2, 1))
    exact, sliders = integrate(moving, start, stop=0.006, steps=60_000, keep=10_000)
    begin, far = to_modal(moving, start), []
    for tolerance in (1e-5, 1e-8) if method == "dop853" else (1e-6,):
        found, slid = adaptive_states(moving, begin, times, method=method, tolerance=tolerance)
        states = from_modal(moving, found)
        far.append(np.abs(states[:, 0] - exact[1:, 0]).max() / np.abs(exact[:, 0]).max())
        # errors of single steps add up, across kinks of the force a hundred times the tolerance
        np.testing.assert_allclose(slid, sliders[1:], atol=200 * tolerance * np.ptp(sliders))
        assert far[-1] < 200 * tolerance
    assert far[0] > 30 * far[-1] or len(far) == 1


def test_energy_of_a_cycle(made: Any) -> None:
    """Work of the force goes into springs, dampers and the slip F_m |ds|; what is stored comes back."""
    system = oscillator(made, amplitude=60.0, c=40.0)
    moving = motion(system, program=constant(1.1))
    stop, steps = 0.1, 200_000
    states, sliders = integrate(moving, np.zeros((2, 1)), stop=stop, steps=steps)
    x, v, s = states[:, 0, 0], states[:, 1, 0], sliders[:, 0]
    times = np.linspace(0, stop, steps + 1)
    push = 60.0 * np.cos(2 * np.pi * 110.0 * times)
    stored = v**2 / 2 + 2e5 * x**2 / 2 + K * (x - s) ** 2 / 2
    power = push * v - 40.0 * v**2
    work = np.sum((power[1:] + power[:-1]) / 2 * np.diff(times))
    slip = FRICTION * np.abs(np.diff(s)).sum()
    assert slip > 0.2 * abs(work)
    assert stored[-1] - stored[0] == pytest.approx(work - slip, abs=1e-5 * slip)


def test_a_very_slow_run_is_the_static_history(made: Any) -> None:
    """The same way of the sliders as a record of quasi-static states, one behind the other."""
    system = plane(made)
    quick = replace(system, lines=system.lines[:1], C=200.0 * np.eye(2))
    speed, samples = 1e-3, 500
    moving, cycle = motion(quick, program=constant(speed)), 1 / (speed * 100.0)
    # a cycle of warm-up, as the static record has it
    states, sliders = integrate(moving, at_equilibrium(moving), stop=2 * cycle, steps=100_000, keep=100)
    record = record_of(quick, cycles=1, turns=None, of=None, samples=samples, most=samples)
    pieces = list(quasi_static(held_train(quick), record))
    still = np.concatenate([piece.state.displacement for piece in pieces])
    before = np.concatenate([piece.anchor for piece in pieces if piece.anchor is not None])
    # steps of both are of first order where the pull turns; the run lags by its dampers, 1e-3 of the way
    np.testing.assert_allclose(states[samples:-1, 0], still, atol=2e-3 * np.ptp(still))
    np.testing.assert_allclose(sliders[samples - 1 : -2], before, atol=2e-3 * np.ptp(before))
    assert np.ptp(sliders, axis=0).min() > START
    stuck = replace(quick, groups=(group(np.eye(2), friction=1e9),))
    elastic = integrate(
        motion(stuck, program=constant(speed)), np.zeros((2, 2)), stop=2 * cycle, steps=100_000, keep=100
    )[0]
    assert np.abs(elastic[samples:-1, 0] - still).max() > 0.1 * np.ptp(still)


def test_equilibrium_with_a_slider_that_has_slipped(made: Any) -> None:
    """A load above the friction at rest: the slider goes along, and stays."""
    system = oscillator(made, force=30.0)
    moving = motion(system)
    start = at_equilibrium(moving)
    assert start[0, 0] == pytest.approx((30.0 - FRICTION) / 2e5, rel=1e-9)
    states, sliders = integrate(moving, start, stop=0.05, steps=1000, keep=10)
    np.testing.assert_allclose(states[:, 0, 0], start[0, 0], rtol=1e-9)
    np.testing.assert_allclose(sliders, start[0, 0] - START, rtol=1e-8)
    other = at_equilibrium(moving, slider=np.array([8e-5]))
    assert other[0, 0] == pytest.approx((30.0 + K * 8e-5) / (2e5 + K), rel=1e-9)  # stuck at the other slider


def test_a_run_of_two_halves_is_the_run(made: Any) -> None:
    system = replace(plane(made), meshes=replace(plane(made).meshes, tone=np.zeros(1, np.int64)))
    whole = transient(system, TransientOptions(cycles=6, initial="rest"))
    first = transient(system, TransientOptions(cycles=3, initial="rest"))
    second = transient(system, TransientOptions(cycles=3, initial=first))
    assert first.end_slider.dims == ("group_row",)
    assert first.end_slider.attrs["units"] == "m"
    count = second.sizes["time"]
    np.testing.assert_allclose(second.group_force, whole.group_force[:, -count:], rtol=1e-6, atol=1e-6 * FRICTION)
    np.testing.assert_allclose(second.end_slider, whole.end_slider, rtol=1e-7)
    lost = first.drop_vars("end_slider")
    other = transient(system, TransientOptions(cycles=3, initial=lost))
    assert float(np.abs(other.group_force - second.group_force.values).max()) > 1e-2 * FRICTION
    assert "sticks" not in whole.attrs["warnings"]


@pytest.mark.parametrize("method", ["rk4", "dop853"])
def test_a_stopped_run_continues_to_the_same_bits(
    made: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: Any
) -> None:
    monkeypatch.setattr(run_module, "_STEPS", 10)
    monkeypatch.setattr(run_module, "_PIECES", 2)

    def interrupt(done: float) -> None:
        if done > 0.4:
            raise KeyboardInterrupt

    system = oscillator(made, amplitude=60.0, c=40.0)
    options: dict[str, Any] = {"cycles": 1, "start": "rest", "method": method}
    whole = transient(system, TransientOptions(**options))
    with pytest.raises(KeyboardInterrupt):
        transient(system, TransientOptions(**options, folder=tmp_path / "run"), progress=interrupt)
    seen: list[float] = []
    again = transient(system, TransientOptions(**options, folder=tmp_path / "run", resume=True), progress=seen.append)
    assert seen[0] > 0.4
    assert np.array_equal(again.group_force, whole.group_force)
    assert np.array_equal(again.end_slider, whole.end_slider)


def test_jumps_of_the_program_with_sliders(made: Any) -> None:
    """A load that jumps: adaptive steps begin anew there, with the sliders as they are."""
    given = program([0.0, 0.005, 0.005, 0.02], [1.0, 1.0, 1.0, 1.0], [[0.0], [0.0], [1.0], [1.0]])
    moving = motion(oscillator(made, c=400.0), program=given, loads=np.array([[45.0]]))
    times = np.linspace(0, 0.02, 9)
    exact, sliders = integrate(moving, np.zeros((2, 1)), stop=0.02, steps=80_000, keep=10_000)
    begin = np.zeros((2, 1))
    found, slid = adaptive_states(moving, begin, times, method="dop853")
    states = from_modal(moving, found)
    np.testing.assert_allclose(states[:, 0], exact[1:, 0], atol=1e-6 * np.abs(exact[:, 0]).max())
    np.testing.assert_allclose(slid, sliders[1:], atol=1e-6 * np.ptp(sliders))
    assert np.ptp(sliders) > START
