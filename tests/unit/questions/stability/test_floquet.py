"""Floquet multipliers against integration of the equation itself, closed forms and invariants."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.special
from numpy.typing import NDArray

from epicyclic.questions.modes.eigen import Modal, modal_form, whirl
from epicyclic.questions.stability.floquet import Floquet, floquet, steps_needed, variational_flow
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

Array = NDArray[np.float64]


def multipliers(*args: Any, **options: Any) -> NDArray[Any]:
    """Multipliers of one period alone."""
    return floquet(*args, **options).multipliers


def change(case: Any, system: System, *, speed: float, steps: int, period: float) -> Array:
    """Stiffness less its mean at so many equal steps, (m, N)."""
    law = case.stiffness(system, speed)
    values = np.array([law(t) for t in np.arange(steps) * period / steps]).T
    return np.asarray(values - system.meshes.stiffness[:, None])


def found(
    case: Any, system: System, *, speed: float = 1.0, steps: int = 48, period: float | None = None
) -> NDArray[Any]:
    T = 1 / float(system.tones[0]) / speed if period is None else period
    modal = modal_form(system)
    return multipliers(modal, change(case, system, speed=speed, steps=steps, period=T), period=T, frame=speed)


def mathieu(case: Any, a: float, q: float) -> System:
    """x'' + (a - 2 q cos 2 t) x = 0, the mesh frequency in units of 1 / pi Hz as 318310 uHz / 1e6."""
    tone = Fraction(1 / np.pi)
    return case.system([[1.0]], [[0.0]], [[1.0]], [a], [[-2 * q / a]], tones=(tone,))  # type: ignore[no-any-return]


# q: characteristic values b1, a1, b2, a2 as tabulated by Ince, in Abramowitz and Stegun's table 20.1
INCE = {1.0: (-0.11024882, 1.85910807, 3.91702477, 4.37130098), 5.0: (-5.79008060, 1.85818754, 2.09946045, 7.44910974)}


@pytest.mark.parametrize("q", INCE)
def test_boundaries_of_the_ince_strutt_diagram(case: Any, q: float) -> None:
    _, a1, b2, a2 = INCE[q]
    exact = [
        float(scipy.special.mathieu_a(1, q)),
        float(scipy.special.mathieu_b(2, q)),
        float(scipy.special.mathieu_a(2, q)),
    ]
    np.testing.assert_allclose(exact, [a1, b2, a2], atol=6e-9)  # tabulated to 8 decimals
    for a, trace in zip(exact, (-2.0, 2.0, 2.0), strict=True):
        # on a boundary both multipliers are +-1, a double root: their sum is told to the error of the method, 1e-8 here
        assert found(case, mathieu(case, a, q), steps=400).sum() == pytest.approx(trace, abs=1e-7)


@pytest.mark.parametrize(
    ("a", "q", "outside"), [(1.0, 0.3, True), (0.6, 0.3, False), (4.2, 1.0, True), (3.7, 1.0, False)]
)
def test_inside_and_outside_of_its_tongues(case: Any, a: float, q: float, outside: bool) -> None:
    size = np.abs(found(case, mathieu(case, a, q)))
    assert bool(size[0] > 1.001) is outside
    assert size.prod() == pytest.approx(1.0, abs=1e-10)  # no damping: the product is exactly 1


@pytest.mark.parametrize("speed", [0.37, 1.0, 2.9])
def test_against_integration_with_gyroscopic_terms(case: Any, speed: float) -> None:
    system = replace(case.two(0.8, zeta=0.02, G=3.0), Kg=-np.eye(2), C=np.array([[0.4, 0.1], [0.1, 0.2]]))
    reference = np.linalg.eigvals(case.monodromy(system, speed, 1 / speed))
    # fourth order: 2e-9 with 192 steps of the slowest mesh cycle
    assert case.apart(found(case, system, speed=speed, steps=192), reference) < 1e-7
    without = replace(system, G=0 * system.G)
    assert case.apart(found(case, without, speed=speed, steps=192), reference) > 1e-2  # the terms are felt
    without = replace(system, Kg=0 * system.Kg)
    assert case.apart(found(case, without, speed=speed, steps=192), reference) > 1e-4


def test_damping_terms_of_every_kind(case: Any) -> None:
    skew = np.array([[0.0, -0.9], [0.9, 0.0]])
    system = replace(case.two(0.8, zeta=0.02), C=np.array([[0.4, 0.3], [0.3, 0.2]]), Cskew=skew)
    system = replace(system, meshes=replace(system.meshes, damping=np.array([0.15])))
    reference = np.linalg.eigvals(case.monodromy(system, 1.3, 1 / 1.3))
    assert case.apart(found(case, system, speed=1.3, steps=192), reference) < 1e-7
    for bare in (replace(system, C=np.diag(np.diag(system.C))), replace(system, Cskew=0 * skew)):
        assert case.apart(found(case, bare, speed=1.3, steps=192), reference) > 1e-4  # each is felt


def test_constant_stiffness_is_exp_of_the_eigenvalues(case: Any) -> None:
    system = replace(case.two(0.0, zeta=0.03, G=2.0), Kg=-np.eye(2))
    mu = whirl(system, relative_speed=1.4, damped=True).mu
    expected = np.exp(np.concatenate([mu, mu.conj()]) / 1.4)
    assert case.apart(found(case, system, speed=1.4, steps=24), expected) < 1e-12


def test_product_of_the_multipliers_is_exp_of_the_trace_of_the_damping(case: Any) -> None:
    system = replace(case.two(0.9, zeta=0.05, G=2.0), C=np.array([[0.4, 0.3], [0.3, 0.2]]))
    trace = np.trace(np.linalg.solve(system.M, case.rates(system)))
    for steps in (7, 24):  # kicks keep volumes whatever the step
        assert found(case, system, steps=steps).prod() == pytest.approx(np.exp(-trace), rel=1e-11)


@pytest.mark.parametrize("G", [0.0, 3.0])
def test_without_damping_multipliers_come_in_reciprocal_pairs(case: Any, G: float) -> None:
    for speed in (1.0, 3.3, 4.6):  # 3.3: w1 + w2, unstable
        mu = found(case, case.two(0.8, G=G), speed=speed, steps=24)
        assert case.apart(mu, 1 / mu.conj()) < 1e-9  # symplectic at any step; 1e-9 for roots that nearly meet
    assert np.abs(found(case, case.two(0.8), speed=3.3, steps=24))[0] > 1.01


def test_order_of_the_splitting(case: Any) -> None:
    system = case.two(0.9, zeta=0.02, G=3.0)
    reference = np.linalg.eigvals(case.monodromy(system, 0.7, 1 / 0.7, rtol=1e-13))
    steps = np.array([24, 32, 48, 64, 96])
    error = [case.apart(found(case, system, speed=0.7, steps=int(N)), reference) for N in steps]
    assert np.polyfit(np.log(steps), np.log(error), 1)[0] == pytest.approx(-4, abs=0.2)


def _dragged(case: Any, system: System, modal: Modal, steps: int, *, vectors: bool = False) -> Floquet:
    """Multipliers with a mesh damping that goes with the stiffness, c(t) = 0.3 k(t) / k0."""
    law = change(case, system, speed=1.0, steps=steps, period=1.0)
    drag = 0.3 * (1 + law / system.meshes.stiffness[:, None])
    return floquet(modal, law, period=1.0, damping=drag, vectors=vectors)


def _dragged_monodromy(case: Any, system: System) -> Array:
    """States after one period from unit states, by integration, with the mesh damping of `_dragged`."""
    law, B, rates = case.stiffness(system, 1.0), system.meshes.B, case.rates(system)

    def slope(t: float, state: Array) -> Array:
        z = state.reshape(4, 4)
        k = law(t)
        push = system.K @ z[:2] + rates @ z[2:] + (B * k) @ B.T @ z[:2]
        push += (B * 0.3 * k / system.meshes.stiffness) @ B.T @ z[2:]
        return np.concatenate([z[2:], -push]).ravel()

    ran = scipy.integrate.solve_ivp(slope, (0, 1), np.eye(4).ravel(), method="DOP853", rtol=1e-12, atol=1e-14)
    whole: Array = ran.y[:, -1].reshape(4, 4)
    return whole


def test_varying_mesh_damping(case: Any) -> None:
    system = case.two(0.9, zeta=0.02)
    reference = np.linalg.eigvals(_dragged_monodromy(case, system))
    modal, steps = modal_form(system), np.array([48, 96, 192, 384])
    error = [case.apart(_dragged(case, system, modal, int(N)).multipliers, reference) for N in steps]
    assert np.polyfit(np.log(steps), np.log(error), 1)[0] == pytest.approx(-2, abs=0.2)
    assert error[0] < 1e-3


def test_eigenvectors_with_varying_mesh_damping(case: Any) -> None:
    system = case.two(0.9, zeta=0.02)
    modal = modal_form(system)
    one = _dragged(case, system, modal, 384, vectors=True)
    assert one.position is not None
    assert one.rate is not None
    z = np.vstack([modal.shapes @ one.position, modal.shapes @ one.rate])
    left = np.abs(_dragged_monodromy(case, system) @ z - z * one.multipliers).max(axis=0)
    # of second order in the step
    assert (left / np.abs(z).max(axis=0)).max() < 3e-4


def test_states_side_by_side_go_by_the_same_steps(case: Any) -> None:
    """Where no period ends them, unit states after all steps have the multipliers of the period."""
    system = case.two(0.9, zeta=0.02)
    modal, law = modal_form(system), change(case, system, speed=1.0, steps=96, period=1.0)
    drag = 0.3 * (1 + law / system.meshes.stiffness[:, None])
    for damping in (None, drag):
        flow = variational_flow(
            modal,
            law.mean(axis=1),
            step=1 / 96,
            frame=1.0,
            damping=None if damping is None else damping.mean(axis=1),
            gaps=modal.gaps,
        )
        mu = np.linalg.eigvals(flow.propagated(np.eye(flow.size), law, damping))
        assert case.apart(mu, multipliers(modal, law, period=1.0, damping=damping)) < 1e-12


def _free(case: Any, *, drag: float = 0.0) -> System:
    """Two inertias that turn freely, joined by a mesh; one of them carries an oscillator across a gyroscopic term."""
    M = np.diag([1.0, 2.0, 0.5])
    K = np.diag([0.0, 0.0, 30.0])
    G = np.zeros((3, 3))
    G[0, 2], G[2, 0] = -0.7, 0.7
    C = np.diag([drag, 2 * drag, 0.0])
    return case.system(M, K, [[1.0], [-1.0], [0.3]], [40.0], [[0.7]], zeta=0.02, G=G, C=C)  # type: ignore[no-any-return]


def test_free_rotation_is_told_apart(case: Any) -> None:
    system = _free(case)
    modal = modal_form(system)
    assert modal.rigid.sum() == 1
    law = change(case, system, speed=1.0, steps=96, period=1.0)
    one = floquet(modal, law, period=1.0, frame=1.0)
    assert one.free.sum() == 2
    np.testing.assert_allclose(one.multipliers[one.free], 1.0, atol=1e-12)  # no defective pair scatters
    reference = np.linalg.eigvals(case.monodromy(system, 1.0, 1.0))
    rest = reference[np.argsort(np.abs(reference - 1))[2:]]
    assert case.apart(one.multipliers[~one.free], rest) < 1e-6


def test_a_damped_rotation_keeps_only_its_position_free(case: Any) -> None:
    system = _free(case, drag=0.5)
    law = change(case, system, speed=1.0, steps=96, period=1.0)
    one = floquet(modal_form(system), law, period=1.0, frame=1.0)
    assert one.free.sum() == 1
    reference = np.linalg.eigvals(case.monodromy(system, 1.0, 1.0))
    assert case.apart(one.multipliers, reference) < 1e-6


def test_eigenvectors_return_multiplied(case: Any) -> None:
    for system in (case.two(0.8, zeta=0.01, G=2.0), _free(case)):
        modal, N = modal_form(system), 384
        one = floquet(modal, change(case, system, speed=1.0, steps=N, period=1.0), period=1.0, vectors=True)
        assert one.position is not None
        assert one.rate is not None
        z = np.vstack([modal.shapes @ one.position, modal.shapes @ one.rate])
        after = case.monodromy(system, 1.0, 1.0, start=np.hstack([z.real, z.imag]))
        after = after[:, : z.shape[1]] + 1j * after[:, z.shape[1] :]
        left = (
            scipy.linalg.block_diag(modal.forces, modal.forces)
            @ np.kron(np.eye(2), system.M)
            @ (after - z * one.multipliers)
        )
        left[: len(modal.rigid)][modal.rigid] = 0.0  # free positions are left out
        # of second order in the step, 2 pi / 384 of the mesh cycle
        assert np.abs(left)[:, ~one.free].max() < 3e-4


def test_two_periods_square_the_multipliers(case: Any) -> None:
    system = case.two(0.8, zeta=0.02, G=2.0)
    modal = modal_form(system)
    law = change(case, system, speed=1.0, steps=48, period=1.0)
    twice = multipliers(modal, np.tile(law, 2), period=2.0)
    assert case.apart(twice, multipliers(modal, law, period=1.0) ** 2) < 1e-12


def test_teeth_that_part(case: Any) -> None:
    system = case.two(0.0, zeta=0.02, cross=-0.6)
    modal, k = modal_form(system), system.meshes.stiffness
    # always parted: the system without the mesh, whatever mean it was prepared with
    bare = replace(system, zeta=None, C=case.rates(system), meshes=replace(system.meshes, stiffness=0 * k))
    mu = whirl(bare, relative_speed=1.0, damped=True).mu
    parted = multipliers(modal, np.full((1, 24), -k[0]), period=1.0)
    assert case.apart(parted, np.exp(np.concatenate([mu, mu.conj()]))) < 1e-12
    # parted for the second half of the period: two exact flows; kicks jump there, so the error is of second order
    A = [_generator(case, system, stiffness) for stiffness in (k, 0 * k)]
    reference = np.linalg.eigvals(scipy.linalg.expm(A[1] / 2) @ scipy.linalg.expm(A[0] / 2))
    errors = []
    for N in (48, 96, 192):
        law = np.where((np.arange(N) + 0.5) / N < 0.5, 0.0, -k[0])[None]
        errors.append(case.apart(multipliers(modal, law, period=1.0), reference))
    assert errors[0] < 2e-3
    assert errors[2] < errors[0] / 12


def _generator(case: Any, system: System, k: Array) -> Array:
    B, n = system.meshes.B, len(system.M)
    A = np.zeros((2 * n, 2 * n))
    A[:n, n:], A[n:, :n], A[n:, n:] = np.eye(n), -(system.K + (B * k) @ B.T), -case.rates(system)
    return A


def test_other_rows_than_the_meshes(case: Any) -> None:
    system = case.two(0.8, zeta=0.02)
    modal = modal_form(system)
    law = change(case, system, speed=1.0, steps=48, period=1.0)
    # a second row that never pushes changes nothing; one that does the half of the first, as much again, does
    both = np.vstack([modal.gaps, modal.gaps])
    same = multipliers(modal, law, period=1.0)
    assert case.apart(multipliers(modal, np.vstack([law / 2, law / 2]), period=1.0, gaps=both), same) < 1e-12


def test_steps() -> None:
    modal = Modal(
        squared=np.array([(2 * np.pi * 100) ** 2]),
        rigid=np.zeros(1, bool),
        shapes=np.eye(1),
        forces=np.eye(1),
        gaps=np.eye(1),
        pulls=np.eye(1),
        damping=np.zeros(1),
        coupling={},
    )
    assert steps_needed(modal, period=0.1, cycle=0.1) == 40  # four a cycle of the mode
    assert steps_needed(modal, period=0.01, cycle=0.01) == 24
    assert steps_needed(modal, period=0.02, cycle=0.01) == 48
    assert steps_needed(modal, period=0.01, cycle=0.01, harmonics=40) == 43


@pytest.mark.parametrize("frequency", [2300.0, 3620.0])
def test_a_ready_drive_against_integration(case: Any, frequency: float) -> None:
    system = assemble(load("xu2020"))
    speed = frequency / float(system.tones[0])
    modal = modal_form(system)
    steps = 2 * steps_needed(modal, period=1 / frequency, cycle=1 / frequency, harmonics=8)
    law = change(case, system, speed=speed, steps=steps, period=1 / frequency)
    one = floquet(modal, law, period=1 / frequency, frame=speed)
    reference = np.linalg.eigvals(case.monodromy(system, speed, 1 / frequency, rtol=1e-8))
    assert np.abs(reference).max() > 1.02  # unstable, as printed with its 3 % damping
    # positions and momentum of the free rotation are a defective pair in the reference: 1e-5 is the root of its error
    assert case.apart(one.multipliers, reference) < 1e-4
    assert np.abs(one.multipliers[0]) == pytest.approx(np.abs(reference).max(), abs=1e-6)
