"""One equation, written twice (NumPy and numba), and cases known in closed form."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.transient import integrators
from epicyclic.questions.transient.equation import (
    constant,
    from_modal,
    highest_rate,
    in_modes_of_its_speed,
    motion,
    phase_at,
    program,
    speed_at,
    to_modal,
)
from epicyclic.questions.transient.integrators import (
    acceleration,
    adaptive_states,
    at_equilibrium,
    at_rest,
    instant_terms,
    integrate,
    row_force,
    steps_for,
)
from epicyclic.questions.transient.transient import flank_force, mesh_force
from epicyclic.system.assembly import assemble
from epicyclic.system.link_laws import Law, LawGroup
from epicyclic.system.system import System
from epicyclic.train.resolution import load

Array = NDArray[np.float64]
RAMP = program([0.0, 0.004, 0.004, 0.02], [0.4, 0.6, 0.6, 1.1], [[0.0], [0.3], [-0.2], [0.0]])


def equation(system: System, t: float, q: Array, v: Array, *, speed: float = 1.0, tau: float | None = None) -> Array:
    """M^-1 (all terms) in the coordinates of the System, mesh by mesh; no groups."""
    s, turn = speed, 2j * np.pi
    tau = t * speed if tau is None else tau
    meshes, far = system.meshes, system.far_flanks
    push = system.force - (system.C + s * system.G) @ v - (system.K + s**2 * system.Kg + s * system.Cskew) @ q
    root = np.sqrt(np.diag(system.M))
    squared, shapes = np.linalg.eigh(system.mean_stiffness / np.outer(root, root))
    push -= (root[:, None] * shapes * (2 * (system.zeta or 0) * np.sqrt(squared))) @ (shapes.T @ (root * v))
    flanks = [(j, 1.0, meshes.B[:, j], meshes.variation[j]) for j in range(len(meshes.name))]
    flanks += [(j, -1.0, far.B[:, i], far.variation[i]) for i, j in enumerate(far.mesh)]
    for place, (j, sense, row, wave) in enumerate(flanks):
        k = meshes.stiffness[j] * (
            1 + sum((w * np.exp(turn * order * 100 * tau)).real for order, w in enumerate(wave, 1))
        )
        gap, rate = row @ q, row @ v
        for line in system.lines:
            error = system.flank_gaps(line)[place] * np.exp(turn * float(line.frequency) * tau)
            gap, rate = gap - error.real, rate - (turn * float(line.frequency) * s * error).real
        gap -= meshes.backlash[j] if sense < 0 else 0.0
        if gap > 0:
            push -= row * (k * gap + meshes.damping[j] * rate)
    for line in system.lines:
        wave = np.exp(turn * float(line.frequency) * tau)
        push += ((line.force[0] + s * line.force[1] + s**2 * line.force[2]) * wave).real
    return np.asarray(np.linalg.solve(system.M, push))


@pytest.mark.parametrize("state", ["pressed", "parted", "far"])
def test_the_right_hand_side_is_the_equation(made: Any, state: str) -> None:
    system = made.rich()
    moving = motion(system, program=constant(0.7))
    size = {"pressed": [3e-4, 1e-4, -2e-4], "parted": [-2e-5, 0.0, 1e-5], "far": [-4e-4, 1e-4, 3e-4]}[state]
    q, v, t = np.array(size), np.array([0.02, -0.03, 0.01]), 0.00123
    y, u = to_modal(moving, np.stack([q, v]))
    N = moving.numbers
    found = moving.shapes @ acceleration(moving, instant_terms(moving, t, t), y, u)
    # both are sums of some ten terms
    np.testing.assert_allclose(found, equation(system, t, q, v, speed=0.7), rtol=1e-10)
    touching = row_force(moving, instant_terms(moving, t, t), y @ N.gaps, u @ N.gaps) != 0
    assert touching.tolist() == {"pressed": [1, 1, 0, 0], "parted": [0, 0, 0, 0], "far": [0, 0, 1, 1]}[state]


@pytest.mark.parametrize("contact", ["unilateral", "linear"])
def test_numbers_of_every_train_have_one_layout(made: Any, contact: Any) -> None:
    """Of another layout, or read-only, the compiled functions would be compiled once more, which takes 17 s."""
    for system in (made.rich(), made.rich(groups=True), assemble(load("ren2021")), assemble(load("wind-stage"))):
        numbers = in_modes_of_its_speed(motion(system, contact=contact)).numbers
        parts = (numbers, numbers.flank, numbers.link, numbers.program)
        named = [entry for part in parts for entry in part._asdict().items()]
        arrays = {name: one for name, one in named if isinstance(one, np.ndarray)}
        assert [name for name, one in arrays.items() if not one.flags.c_contiguous or not one.flags.writeable] == []


@pytest.mark.parametrize("groups", [False, True])
def test_modes_of_a_speed_hold_the_same_equation(made: Any, groups: bool) -> None:
    bend = np.array([[-3.0, 1.0, 0.5], [1.0, -2.0, 0.2], [0.5, 0.2, -1.0]])
    system = replace(made.rich(groups=groups), Cskew=np.zeros((3, 3)), Kg=1e5 * bend)
    plain = motion(system, program=constant(0.7))
    turned = in_modes_of_its_speed(plain)
    assert plain.numbers.stiff.any()
    assert not turned.numbers.stiff.any()
    q, v, t = np.array([3e-4, 1e-4, -2e-4]), np.array([0.02, -0.03, 0.01]), 0.00123
    found = []
    for moving in (plain, turned):
        y, u = to_modal(moving, np.stack([q, v]))
        np.testing.assert_allclose(from_modal(moving, np.stack([y, u])), np.stack([q, v]), rtol=1e-12)
        found.append(moving.shapes @ acceleration(moving, instant_terms(moving, t, t), y, u))
    np.testing.assert_allclose(found[1], found[0], rtol=1e-10)
    if not groups:
        np.testing.assert_allclose(found[1], equation(system, t, q, v, speed=0.7), rtol=1e-10)


def test_modes_of_a_speed_are_left_where_they_couple(made: Any) -> None:
    """By an unsymmetric stiffness or at a speed that changes."""
    system = made.rich()
    for moving in (motion(system, program=constant(0.7)), motion(system, program=RAMP, loads=np.zeros((1, 3)))):
        assert in_modes_of_its_speed(moving) is moving
    symmetric = motion(replace(system, Cskew=np.zeros((3, 3))), program=RAMP, loads=np.zeros((1, 3)))
    assert in_modes_of_its_speed(symmetric) is symmetric


def both(monkeypatch: pytest.MonkeyPatch, run: Any) -> tuple[Any, Any]:
    pytest.importorskip("numba")
    compiled = run()
    with monkeypatch.context() as patch:
        patch.setattr(integrators, "numba_available", lambda: False)
        return compiled, run()


@pytest.mark.parametrize("contact", ["unilateral", "linear"])
@pytest.mark.parametrize("given", [constant(0.8), RAMP], ids=["constant", "ramp"])
@pytest.mark.parametrize("groups", [False, True])
def test_compiled_steps_equal_numpy(
    made: Any, monkeypatch: pytest.MonkeyPatch, contact: Any, given: Any, groups: bool
) -> None:
    system = made.rich(groups=groups, load=60.0)
    loads = np.array([[200.0, 0.0, -100.0]])[: given.level.shape[1]]
    moving = motion(system, program=given, contact=contact, loads=loads)
    fast, slow = both(monkeypatch, lambda: integrate(moving, at_rest(moving), stop=0.01, steps=400, keep=20)[0])
    # the same steps with sums in another order: rounding, grown over 400 steps
    np.testing.assert_allclose(fast, slow, rtol=1e-9, atol=1e-11 * np.abs(slow).max())
    assert np.isfinite(fast).all()
    assert np.abs(fast[-1, 0]).max() > 1e-5


@pytest.mark.parametrize("name", ["rich", "ren2021"])
def test_compiled_steps_in_modes_of_a_speed_equal_numpy(made: Any, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """3 modes and 28: rows taken one by one, and by fours."""
    system = replace(made.rich(), Cskew=np.zeros((3, 3))) if name == "rich" else assemble(load(name))
    moving = in_modes_of_its_speed(motion(system, program=constant(0.8)))
    assert not moving.numbers.stiff.any()
    assert moving.numbers.damp.any()
    fast, slow = both(monkeypatch, lambda: integrate(moving, at_rest(moving), stop=0.01, steps=200, keep=20)[0])
    np.testing.assert_allclose(fast, slow, rtol=1e-9, atol=1e-11 * np.abs(slow).max())
    assert np.abs(fast[-1, 0]).max() > 1e-5


def test_what_is_not_finite_stays_so(made: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    moving = motion(made.rich())
    fast, slow = both(monkeypatch, lambda: integrate(moving, at_rest(moving), stop=10.0, steps=200, keep=2)[0])
    for found in (fast, slow):
        finite = np.isfinite(found).all(axis=(1, 2))
        assert finite[0]
        assert not finite[-1]  # steps of 50 ms are far beyond the limit of stability
        assert not finite[int(np.argmin(finite)) :].any()


def test_a_bouncing_mass(made: Any) -> None:
    """Falls from h under F, presses the flank for a while, is back at h: in closed form."""
    force, height, omega = 50.0, 2e-4, 1e3
    moving = motion(made.mass(force=force))
    fall, hit = np.sqrt(2 * height / force), np.sqrt(2 * height * force)
    # x = F/k (1 - cos wt) + v/w sin wt is back at zero at wt = 2 pi - 2 arctan(v w / F ..)
    touch = 2 * (np.pi - np.arctan2(hit, force / omega)) / omega
    period = 2 * fall + touch
    start = np.array([[-height], [0.0]])
    deepest = force / omega**2 + np.hypot(force / omega**2, hit / omega)
    found = integrate(moving, start, stop=period, steps=20_000, keep=100)[0]
    # a step over the instant of contact is first order in the force there: h^2 of the motion, 1e-7
    np.testing.assert_allclose(found[-1, 0], -height, rtol=1e-6)
    assert abs(found[-1, 1, 0]) < 1e-6 * hit
    assert found[:, 0].max() == pytest.approx(deepest, rel=1e-3)  # 200 samples
    times = np.linspace(0, period, 41)
    begin = to_modal(moving, start)
    states, _ = adaptive_states(moving, begin, times, method="dop853", tolerance=1e-10)
    fine = from_modal(moving, states)
    np.testing.assert_allclose(fine[-1, 0], -height, rtol=1e-7)  # of the tolerance, 1e3 for steps across the contact


def test_the_highest_rate_is_that_of_the_stiffest_instant(made: Any) -> None:
    one = np.ones((1, 1))
    swinging = made.system(one, 0 * one, one, np.array([1e6]), force=np.ones(1), variation=0.44 * one)
    assert highest_rate(motion(swinging)) == pytest.approx(1.2e3, rel=1e-12)
    damped = replace(swinging, C=50.0 * one)  # beside it the whole rate of decay, by the triangle inequality
    assert highest_rate(motion(damped)) == pytest.approx(1.25e3, rel=1e-12)


@pytest.mark.parametrize("force", [1.0, 100.0], ids=["in its clearance", "pressed"])
def test_the_highest_rate_is_that_of_a_pressed_link(made: Any, force: float) -> None:
    one = np.ones((1, 1))
    law = Law(stiffness=3e6, clearance=5e-6)
    stop = LawGroup(name="main/0/support", kind="support", rows=("x",), B=one, law=law, damping=np.zeros(1), lag=0.0)
    system = made.system(one, 0 * one, one, np.array([1e6]), force=np.array([force]), groups=(stop,))
    assert highest_rate(motion(system)) == pytest.approx(2e3, rel=1e-9)


def test_the_highest_rate_of_several_meshes_bounds_every_instant(made: Any) -> None:
    system = made.rich(damped=False)
    still = replace(system, G=0 * system.G, Kg=0 * system.Kg, euler=np.zeros(0), far=None, lines=())
    still = replace(still, meshes=replace(still.meshes, backlash=np.full(2, np.inf)))
    meshes, root = still.meshes, np.sqrt(np.diag(still.M))
    rates = []
    for cycle in np.arange(64) / 64:
        k = meshes.stiffness * (1 + (meshes.variation @ np.exp(2j * np.pi * cycle * np.arange(1, 3))).real)
        stiff = (still.K + (meshes.B * k) @ meshes.B.T) / np.outer(root, root)
        rates.append(np.sqrt(np.linalg.eigvalsh(stiff)[-1]))
    # the orders of the stiffness are not in phase, nor are the meshes
    assert max(rates) < highest_rate(motion(still)) < 1.1 * max(rates)


def test_steps_hold_the_phase_of_the_fastest_mode(made: Any) -> None:
    """Free vibration at 1000 rad/s: fourth-order steps of at most 0.35 rad, whose lag is known in closed form."""
    moving = motion(made.mass(force=0.0), contact="linear")
    angle = 20 * np.pi
    stop = angle / 1e3
    steps = steps_for(moving, stop)
    x, v = integrate(moving, np.array([[1e-5], [0.0]]), stop=stop, steps=steps)[0][-1, :, 0]
    assert 0.34 < angle / steps <= 0.35
    z = 1j * angle / steps
    one = 1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24
    lag = float(np.arctan2(v / 1e3, x))
    assert lag == pytest.approx(steps * (z.imag - np.angle(one)), rel=1e-6)
    assert 0.9e-4 < lag / angle < 1.3e-4  # as the bound of the steps says


def test_a_mass_between_two_flanks(made: Any) -> None:
    """Without a load: half a vibration on each flank, free flight between them."""
    backlash, speed, omega = 1e-4, 0.05, 1e3
    moving = motion(made.mass(force=0.0, backlash=backlash))
    period = 2 * backlash / speed + 2 * np.pi / omega
    found = integrate(moving, np.array([[-backlash / 2], [speed]]), stop=period, steps=20_000, keep=100)[0]
    np.testing.assert_allclose(found[-1, :, 0], [-backlash / 2, speed], rtol=1e-6)  # as above
    times = np.linspace(0, period, len(found))
    force = mesh_force(moving, times, found)[0]
    top = 1e6 * speed / omega
    assert force.max() == pytest.approx(top, rel=1e-3)
    assert force.min() == pytest.approx(-top, rel=1e-3)


@pytest.mark.parametrize("contact", ["unilateral", "linear"])
def test_energy_is_accounted_for(made: Any, contact: Any) -> None:
    """Work of loads, of k' delta^2 / 2 and of -f e' goes into energy and dampers, with parting teeth too."""
    system = replace(made.rich(load=100.0), Cskew=np.zeros((3, 3)), zeta=None)
    moving = motion(system, contact=contact)
    T, steps = 0.01, 20_000
    times = np.linspace(0, T, steps + 1)
    states = integrate(moving, at_rest(moving), stop=T, steps=steps)[0]
    q, v = states[:, 0].T, states[:, 1].T
    m, far = system.meshes, system.far_flanks
    rows = np.hstack([m.B, far.B]) if contact == "unilateral" else m.B
    count = rows.shape[1]
    k0, c = np.tile(m.stiffness, 2)[:count, None], np.tile(m.damping, 2)[:count, None]
    orders = 2j * np.pi * 100 * np.arange(1, 3)
    wave = np.exp(np.multiply.outer(orders, times))
    variation = np.concatenate([m.variation, far.variation])[:count]
    k, dk = k0 * (1 + (variation @ wave).real), k0 * ((variation * orders) @ wave).real
    e, de = np.zeros((count, times.size)), np.zeros((count, times.size))
    push = np.tile(system.force[:, None], times.size)
    for line in system.lines:
        turn = 2j * np.pi * float(line.frequency)
        signal = np.exp(turn * times)
        e += np.outer(system.flank_gaps(line)[:count], signal).real
        de += np.outer(turn * system.flank_gaps(line)[:count], signal).real
        push += np.outer(line.force.sum(axis=0), signal).real
    e[2:] += m.backlash[0]
    gap, rate = rows.T @ q - e, rows.T @ v - de
    closed = (gap > 0) | (contact == "linear")
    stored = ((v * (system.M @ v)).sum(axis=0) + (q * ((system.K + system.Kg) @ q)).sum(axis=0)) / 2
    stored = stored + (closed * k * gap**2 / 2).sum(axis=0)
    power = (push * v).sum(axis=0) - (v * (system.C @ v)).sum(axis=0)
    power = power + (closed * (dk * gap**2 / 2 - k * gap * de - c * rate * (rate + de))).sum(axis=0)
    balance = stored - stored[0] - np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(times))])
    size = np.abs(power).sum() * T / steps
    # trapezoidal sums over 20 000 samples; dampers make the power jump where teeth meet
    assert np.abs(balance).max() < 2e-5 * size
    assert closed.all() == (contact == "linear")


def test_forces_of_samples_are_those_of_the_steps(made: Any) -> None:
    system = made.rich(load=60.0)
    moving = motion(system, program=RAMP, loads=np.array([[200.0, 0.0, -100.0]]))
    states = integrate(moving, at_rest(moving), stop=0.01, steps=400, keep=8)[0]
    times = np.linspace(0, 0.01, 51)
    N = moving.numbers
    for i, force in enumerate(flank_force(moving, times, states).T):
        y, v = to_modal(moving, states[i])
        np.testing.assert_allclose(
            force,
            row_force(moving, instant_terms(moving, times[i], times[i]), y @ N.gaps, v @ N.gaps),
            rtol=1e-9,
            atol=1e-9,
        )


def test_phase_is_the_integral_of_the_speed() -> None:
    times = np.linspace(-0.01, 0.05, 60_001)
    speed, phase = speed_at(RAMP, times), phase_at(RAMP, times)
    summed = np.concatenate([[0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(times))])
    np.testing.assert_allclose(phase - phase[0], summed, atol=1e-9)  # of 60 000 trapezes over one kink
    assert phase_at(RAMP, np.zeros(1))[0] == 0


def test_equilibrium_neither_moves_nor_accelerates(made: Any) -> None:
    for groups in (False, True):
        system = made.rich(groups=groups, swing=0.0)
        still = replace(system, lines=())
        moving = motion(still, program=constant(0.9))
        start = at_equilibrium(moving)
        states = integrate(moving, start, stop=0.05, steps=2000, keep=100)[0]
        # residual 1e-11 of the load on the softest mode
        np.testing.assert_allclose(states[:, 0], np.tile(start[0], (21, 1)), rtol=1e-8, atol=1e-12)
        assert np.abs(start[0]).max() > 1e-5


def test_wrong_arguments(made: Any) -> None:
    system = made.rich()
    moving = motion(system)
    wrongs: tuple[dict[str, Any], ...] = (
        {"stop": 0.0},
        {"stop": np.nan},
        {"stop": 1.0, "steps": 10, "keep": 3},
        {"stop": 1.0, "keep": 0},
    )
    for wrong in wrongs:
        with pytest.raises(ModelError, match="nothing to integrate"):
            integrate(moving, at_rest(moving), **wrong)[0]
    with pytest.raises(ModelError, match="state"):
        integrate(moving, np.zeros((2, 7)), stop=1.0)[0]
    with pytest.raises(ModelError, match="contact = 'sticky'"):
        epicyclic.transient(system, contact="sticky")  # type: ignore[arg-type]
    for time, speed, said in (
        ([0.0, 0.0], [1.0, 1.0], "rise"),
        ([0.0, np.nan], [1.0, 1.0], "rise"),
        ([1.0, 0.0], [1.0, 1.0], "rise"),
        ([0.0, 1.0], [1.0, -1.0], "out of range"),
        ([0.0, 1.0, 1.0, 2.0], [1.0, 1.0, 2.0, 2.0], "cannot jump"),
    ):
        with pytest.raises(ModelError, match=said):
            program(time, speed)
