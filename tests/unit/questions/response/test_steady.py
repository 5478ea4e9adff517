"""The periodic response against time integration, a dense harmonic balance and its own balances."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.questions.modes.eigen import mean_modes
from epicyclic.questions.response import SteadyOptions
from epicyclic.questions.response.measures import Periodic, periodic
from epicyclic.questions.response.steady import steady
from epicyclic.system.system import Line, System

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def rate(values: NDArray[Any], omega: float) -> NDArray[Any]:
    """Time derivative of samples over one mesh cycle."""
    orders = np.fft.fftfreq(values.shape[-1], 1 / values.shape[-1])
    slope = np.fft.ifft(1j * omega * orders * np.fft.fft(values))
    return slope.real if np.isrealobj(values) else slope


def at(values: NDArray[Any], theta: Array) -> ComplexArray:
    """Trigonometric interpolation of samples over one cycle, (..., T)."""
    count = values.shape[-1]
    orders = np.fft.fftfreq(count, 1 / count)
    return np.asarray(np.fft.fft(values) / count @ np.exp(2j * np.pi * np.outer(orders, theta)))


def record(found: Periodic, times: Array, what: str) -> Array:
    """The whole signal at `times`: mesh orders and every shaft line."""
    s, tone = found.relative_speed, float(found.tone)
    total = at(getattr(found, what), tone * s * times).real
    for line in found.lines:
        carrier = np.exp(2j * np.pi * s * float(line.frequency) * times)
        total = total + (at(getattr(line, what), tone * s * times) * carrier).real
    return np.asarray(total)


def start(found: Periodic) -> tuple[Array, Array]:
    """Coordinates and velocities at t = 0."""
    omega = 2 * np.pi * float(found.tone) * found.relative_speed
    q, v = found.displacement[:, 0].copy(), rate(found.displacement, omega)[:, 0]
    for line in found.lines:
        turn = 2j * np.pi * found.relative_speed * float(line.frequency)
        q += line.displacement[:, 0].real
        v = v + (rate(line.displacement, omega) + turn * line.displacement)[:, 0].real
    return q, v


def assert_agrees(case: Any, system: System, speed: float, *, cycles: int) -> None:
    """Integration started on the periodic solution stays on it for so many mesh cycles."""
    found = periodic(system, relative_speed=speed, samples=128)
    times = np.linspace(0, cycles / (float(found.tone) * speed), 40 * cycles + 1)
    q, force = case.motion(system, speed).integrate(times, *start(found), rtol=1e-9)
    expected = record(found, times, "force")
    # rtol 1e-9 leaves about 1e-8; 1e-6 of the signal is the accuracy asked for
    assert np.abs(force - expected).max() < 1e-6 * np.abs(expected).max()
    moved = record(found, times, "displacement")
    assert np.abs(q - moved).max(axis=1) == pytest.approx(0, abs=1e-6 * np.abs(moved).max())


@pytest.mark.parametrize("free", [True, False])
@pytest.mark.parametrize("speed", [0.4, 1.0, 1.9])
def test_integration_stays_on_the_periodic_solution(case: Any, free: bool, speed: float) -> None:
    assert_agrees(case, case.pair(free=free), speed, cycles=2)


def test_integration_from_rest_joins_the_periodic_solution(case: Any) -> None:
    system = case.pair()
    found = periodic(system)
    omega = np.sqrt(mean_modes(system)[0])
    settle = 10 / (0.03 * omega[omega > 0][0])  # e^-10 of the slowest mode is left
    first = np.ceil(settle * 137) / 137
    times = np.concatenate([[0.0], first + np.linspace(0, 1 / 137, 65)])
    still = np.zeros(6)
    force = case.motion(system, 1.0).integrate(times, still, still, rtol=1e-7)[1][:, 1:]
    expected = record(found, times[1:], "force")
    # the transient is gone to e^-10 = 5e-5
    assert np.abs(force - expected).max() < 1e-4 * found.force.mean()


def shafts(case: Any) -> tuple[Line, ...]:
    """Sevenths of the mesh frequency: the record closes after seven cycles."""
    return (
        case.line(Fraction(137), [3e-6, 2e-6j]),
        case.line(Fraction(274, 7), [5e-6, 4e-6j], push=60, cause="deviations.a"),
        case.line(Fraction(137 * 8, 7), [2e-6j, 1e-6], push=25j, cause="deviations.b"),
    )


@pytest.mark.parametrize("speed", [1.0, 1.35])
def test_shaft_lines_agree_with_integration_over_a_super_period(case: Any, speed: float) -> None:
    system = case.pair(lines=shafts(case))
    assert len(periodic(system, relative_speed=speed).lines) == 2
    assert_agrees(case, system, speed, cycles=7)


def test_shaft_lines_that_mesh_orders_couple_stand_together(case: Any) -> None:
    lines = (*shafts(case), case.line(Fraction(137 * 5, 7), [1e-6j, 3e-6 + 1e-6j], push=10, cause="deviations.c"))
    lines += (case.line(Fraction(137, 2), [2e-6, 1e-6j], cause="deviations.half"),)
    system = case.pair(lines=lines)
    found = periodic(system)
    assert [line.frequency for line in found.lines] == [Fraction(274, 7), Fraction(137, 2), Fraction(137 * 8, 7)]
    assert found.lines[0].causes == ("deviations.a", "deviations.c")
    assert_agrees(case, system, 1.0, cycles=3)


def dense(case: Any, system: System, speed: float, harmonics: int) -> ComplexArray:
    """Two-sided harmonics (n, 2 H + 1) of q by one dense solve in physical coordinates, k(t) by sampled transforms."""
    meshes, n = system.meshes, system.M.shape[0]
    omega, count = 2 * np.pi * float(system.tones[0]) * speed, 8 * harmonics + 8
    orders = np.arange(-harmonics, harmonics + 1)
    motion = case.motion(system, speed)
    laws = [motion.laws(t) for t in np.arange(count) / count * 2 * np.pi / omega]
    into = np.exp(-2j * np.pi * np.outer(orders, np.arange(count)) / count) / count
    k, e, slope, force = (np.array([law[i] for law in laws]) for i in range(4))
    steps = np.eye(orders.size)
    A = np.zeros((orders.size, n, orders.size, n), complex)
    for i, h in enumerate(orders):
        w = h * omega
        damper = case.damping(system) + speed * system.G + (meshes.B * meshes.damping) @ meshes.B.T
        A[i, :, i, :] = system.K + speed**2 * system.Kg + speed * system.Cskew - w**2 * system.M + 1j * w * damper
    for row, column, stiffness in zip(meshes.B.T, k.T, meshes.stiffness, strict=True):
        product = into @ (column[:, None] * np.exp(2j * np.pi * np.outer(np.arange(count), orders) / count))
        assert product[0, 0] == pytest.approx(stiffness)
        A += np.einsum("ij,a,b->iajb", product, row, row)
    push = (into @ (force + (k * e + meshes.damping * slope) @ meshes.B.T)).ravel()
    flat = A.reshape(push.size, push.size)
    flat = flat + np.kron(np.diag(steps[harmonics]), np.outer(*[_free(system)] * 2))
    return np.asarray(np.linalg.solve(flat, push).reshape(orders.size, n).T)


def _free(system: System) -> Array:
    """A stiffness on the mean of the rigid mode, which moves nothing else: M phi, zero where there is none."""
    squared, modes = mean_modes(system)
    shape: Array = system.M @ modes[:, 0] if squared[0] == 0 else np.zeros(modes.shape[0])
    return shape * 1e3


@given(
    speed=st.floats(0.2, 3.0),
    swing=st.floats(0.0, 0.4),
    free=st.booleans(),
    turning=st.floats(-1.5, 1.5),
    mesh_damping=st.sampled_from([0.0, 300.0]),
)
@settings(max_examples=25, deadline=None)
def test_dense_harmonic_balance_gives_the_same(
    case: Any, speed: float, swing: float, free: bool, turning: float, mesh_damping: float
) -> None:
    system = case.pair(free=free, swing=swing, turning=turning, mesh_damping=mesh_damping)
    found = periodic(system, relative_speed=speed, samples=128, tolerance=1e-10)
    H = found.harmonics
    harmonics = np.fft.fft(found.displacement)[:, np.arange(-H, H + 1)] / 128
    expected = dense(case, system, speed, H)
    # residual 1e-10 against the dynamic part, times the amplification of a resonance (1 / 2 zeta)
    assert np.abs(harmonics - expected).max() < 1e-7 * np.abs(expected).max()


@pytest.mark.parametrize("speed", [0.5, 1.0, 1.7])
def test_forces_balance_in_the_mean_and_power_over_a_cycle(case: Any, speed: float) -> None:
    system = case.pair(free=False)
    found = periodic(system, relative_speed=speed, samples=256)
    static = (system.K + speed**2 * system.Kg + speed * system.Cskew) @ found.displacement.mean(axis=1)
    left = static + system.meshes.B @ found.force.mean(axis=1) - system.force
    assert np.abs(left).max() < 1e-8 * np.abs(system.force).max()  # tolerance of the solver
    v = rate(found.displacement, 2 * np.pi * 137 * speed)
    power = np.einsum("it,ij,jt->t", v, case.damping(system), v).mean()
    power += speed * np.einsum("it,ij,jt->t", v, system.Cskew, found.displacement).mean()
    mesh = np.mean(np.sum((system.meshes.B.T @ v) * found.force, axis=0))
    # external forces of the line at the mesh frequency do work too
    t = found.theta / (137 * speed)
    given = np.array([case.motion(system, speed).laws(x)[3] for x in t]).T
    assert power + mesh == pytest.approx(np.mean(np.sum(v * given, axis=0)), abs=1e-6 * power)


def test_response_is_affine_in_the_errors(case: Any) -> None:
    def force(scale: float) -> Array:
        lines = tuple(replace(line, gap=scale * line.gap, force=scale * line.force) for line in shafts(case))
        found = periodic(case.pair(lines=lines), samples=64)
        return np.concatenate([found.force, *(line.force.real for line in found.lines)])

    none, one, three = force(0.0), force(1.0), force(3.0)
    # each of the three is solved to 1e-8
    assert np.abs(three - none - 3 * (one - none)).max() < 1e-7 * np.abs(three).max()


def test_steady_reports_the_same_solution_with_units(case: Any) -> None:
    system = case.pair(lines=shafts(case))
    found, result = periodic(system, samples=64), steady(system, SteadyOptions(samples=64))
    np.testing.assert_allclose(result.mesh_force, found.force)
    np.testing.assert_allclose(result.displacement, found.displacement * system.dofs.radius[:, None])
    assert list(result.line.values) == ["deviations.a", "deviations.b"]
    np.testing.assert_allclose(result.line_force[:, 1], found.lines[1].force)
    wave = np.exp(2j * np.pi * np.outer(result.harmonic, found.theta))
    rebuilt = (result.mesh_force_harmonic.values @ wave).real
    assert np.abs(rebuilt - found.force).max() < 1e-6 * np.abs(found.force).max()  # harmonics above the last are cut
    assert result.mesh_force.attrs["units"] == "N"
    times = np.arange(7 * 64) / (64 * 137)
    signal = record(found, times, "force")
    np.testing.assert_allclose(result.mesh_force_rms, signal.std(axis=1), rtol=1e-6)
    assert np.all(result.mesh_force_bound >= signal.max(axis=1))
    assert np.all(result.mesh_force_minimum <= signal.min(axis=1))


def test_tensile_mesh_force_is_a_warning(case: Any) -> None:
    loud = case.pair(lines=(case.line(Fraction(137), [2e-3, 2e-3]),))
    assert "tensile mesh force" in steady(loud, SteadyOptions()).attrs["warnings"]
    assert "tensile" not in steady(case.pair(), SteadyOptions()).attrs["warnings"]


def refusal(case: Any, **changes: Any) -> str:
    with pytest.raises(ModelError) as caught:
        periodic(replace(case.pair(), **changes))
    return str(caught.value)


def test_no_damping_is_refused_with_how_to_give_it(case: Any) -> None:
    meshes = replace(case.pair().meshes, damping=np.zeros(2))
    text = refusal(case, zeta=None, C=np.zeros((6, 6)), meshes=meshes)
    assert "no damping" in text
    assert 'modal = "3 %"' in text


def test_no_speed_is_refused(case: Any) -> None:
    assert "operation.speed" in refusal(case, tones=())


def test_torques_out_of_balance_are_refused(case: Any) -> None:
    force = case.pair().force
    assert "do not balance" in refusal(case, force=force * np.array([1, 1, 1.001, 1, 1, 1]))
    held = replace(case.pair(free=False), force=force * np.array([1, 1, 1.001, 1, 1, 1]))
    assert periodic(held).residual < 1e-6  # a support takes the rest


@pytest.mark.parametrize(("name", "value"), [("relative_speed", 0.0), ("relative_speed", np.nan)])
def test_options_out_of_range_are_refused(case: Any, name: str, value: float) -> None:
    run: Any = periodic
    with pytest.raises(ModelError, match=name):
        run(case.pair(), **{name: value})


def test_the_mass_of_every_coordinate_is_needed(case: Any) -> None:
    M = case.pair().M.copy()
    M[2, 2] = 0.0
    with pytest.raises(ModelError, match="main/a/rz"):
        periodic(replace(case.pair(), M=M))


def test_numbers_too_large_end_in_a_convergence_error(case: Any) -> None:
    with pytest.raises(ConvergenceError, match="mesh frequency"):
        periodic(case.pair(), relative_speed=1e200)


def test_more_samples_than_memory_holds_are_refused() -> None:
    with pytest.raises(ModelError, match="would need some") as error:
        epicyclic.steady("dong2019", samples=20_000_000)
    assert error.value.path == "samples"
    assert "at most" in error.value.allowed
