"""Tabulated teeth that part: balance, integration, multipliers and statics are routes to one answer.

Every route is that of its verb; the reference is the equation of motion written out below, with `solve_ivp`.  Each
comparison must fail by ten tolerances where the tangents at the operating load stand in place of the tables.

At 30 % of the operating torque teeth part for a share of the mesh cycle: ren2021 at mesh frequencies of 140 and 340 Hz,
xu2020 at 1180 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import epicyclic
from epicyclic.questions.contact_loss.branch_set import mesh_force
from epicyclic.questions.contact_loss.continuation import solve
from epicyclic.questions.contact_loss.problem import flank_force, gap_rows, prolonged
from epicyclic.questions.contact_loss.solutions import (
    Refinement,
    Solution,
    floquet_multipliers,
    load_continuation,
    solution,
    with_stability,
)
from epicyclic.questions.contact_loss.sweep_direction import initial_state
from epicyclic.questions.response.response import Response, response
from epicyclic.questions.transient.equation import constant, motion
from epicyclic.questions.transient.integrators import integrate, steps_for
from epicyclic.questions.transient.transient import flank_force as record_force
from epicyclic.statics.tangent import linear
from epicyclic.system.gaps import flanks
from epicyclic.system.system import System
from epicyclic.train.resolution import load

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
TABLES = {f"stages.main.meshes.{pair}.stiffness": "contact" for pair in ("sun-planet", "planet-ring")}
PARTED = [("ren2021", 140.0), ("ren2021", 340.0), ("xu2020", 1180.0)]
TORQUE = 0.3


@lru_cache(maxsize=4)
def drive(name: str) -> System:
    """A drive with both pairs tabulated, at a part of its torque, mesh orders alone."""
    system = epicyclic.assemble(load(name, overrides=TABLES))
    whole = {order * system.tones[0] for order in range(64)}
    lines = tuple(line for line in system.lines if line.frequency in whole)
    return replace(system, force=TORQUE * system.force, lines=lines)


def tangents(system: System) -> System:
    """The system with the tangents at the operating load in place of the tables."""
    far = None if system.far is None else replace(system.far, laws=())
    return replace(system, meshes=replace(system.meshes, laws=()), far=far)


@dataclass(frozen=True)
class Found:
    ready: Response
    at: Solution
    speed: float

    @property
    def force(self) -> Array:
        """(N, w) [N]"""
        return np.asarray(mesh_force(self.ready.system, flank_force(self.at.balance, self.at.state)))


def balance(system: System, frequency: float) -> Found:
    ready = response(system)
    refinement, speed = Refinement(ready=ready), frequency / float(ready.lines.tone)
    start = load_continuation(refinement, speed, harmonics=16)
    assert start.converged
    at = solution(refinement, start.state.y, speed, balance=refinement.problem(16), harmonics=16)
    assert at is not None
    return Found(ready, with_stability(refinement, at), speed)


@lru_cache(maxsize=8)
def tabulated(name: str, frequency: float) -> Found:
    return balance(drive(name), frequency)


@lru_cache(maxsize=8)
def by_tangents(name: str, frequency: float) -> Found:
    return balance(tangents(drive(name)), frequency)


class Equation:
    """M q'' + (C + s G) q' + (K + s Cskew + s^2 Kg) q + B f = F, modal damping of the mean system, one mesh tone."""

    def __init__(self, system: System, speed: float) -> None:
        self.system, self.speed, self.flanks = system, speed, flanks(system)
        self.tone, self.rows = float(system.tones[0]), system.group_rows
        self.turn = 2j * np.pi * speed * np.array([float(line.frequency) for line in system.lines])
        power = speed ** np.arange(3)
        self.gap = np.array([system.flank_gaps(line) for line in system.lines])
        self.push = np.array([power @ line.force for line in system.lines])
        self.group_gap = np.array([line.group_gap for line in system.lines if line.group_gap.size])
        self.group_turn = self.turn[[bool(line.group_gap.size) for line in system.lines]]
        squared, shapes = np.linalg.eigh(np.linalg.solve(*self._halves(system)))
        L = np.linalg.cholesky(system.M)
        modes = np.linalg.solve(L.T, shapes)
        ratio = 2 * (system.zeta or 0.0) * np.sqrt(np.maximum(squared, 0.0))
        damping = system.M @ modes @ np.diag(ratio) @ modes.T @ system.M
        self.C = damping + system.C + speed * system.G
        self.K = system.K + speed * system.Cskew + speed**2 * system.Kg
        self.inverse = np.linalg.inv(system.M)
        self.rigid = modes[:, squared < 1e-9 * squared.max()]

    @staticmethod
    def _halves(system: System) -> tuple[Array, Array]:
        L = np.linalg.cholesky(system.M)
        # modal damping is of the mean system, which has the tangents of links
        half = np.linalg.solve(L, np.linalg.solve(L, linear(system).mean_stiffness).T)
        return np.eye(len(L)), (half + half.T) / 2

    def excitation(self, t: float) -> tuple[Array, Array]:
        """Errors (F,) [m] and forces (n,) [N] at a time [s]."""
        phase = np.exp(self.turn * t)
        return self.flanks.opening + (phase @ self.gap).real, self.system.force + (phase @ self.push).real

    def law(self, t: float, q: Array) -> tuple[Array, Array, Array]:
        """Forces of flanks (F,) [N], their tangents (F,) [N/m], and loads (n,) [N] less forces of links."""
        error, load = self.excitation(t)
        phases = np.array([[self.speed * self.tone * t % 1.0]])
        force, tangent = self.flanks.at(phases).evaluate((self.flanks.B.T @ q - error)[None])
        return force[0], tangent[0], load - self.rows @ self.system.laws.force(self.stretch(t, q))

    def stretch(self, t: float, q: Array) -> Array:
        """Stretch (R,) [m] of the rows of link groups."""
        stretch = self.rows.T @ q
        if self.group_gap.size:
            stretch -= (np.exp(self.group_turn * t) @ self.group_gap).real
        return np.asarray(stretch)

    def rate(self, t: float, z: Array) -> Array:
        n = len(self.K)
        q, v = z[:n], z[n:]
        force, _, load = self.law(t, q)
        left = load - self.C @ v - self.K @ q - self.flanks.B @ force
        left -= self.system.M @ (self.rigid @ (self.rigid.T @ left))  # what nothing holds is left alone
        return np.concatenate([v, self.inverse @ left])

    def jacobian(self, tangent: Array, links: Array) -> Array:
        """Of the variational equation, (2n, 2n), for tangents (F,) of flanks and (R, R) of links [N/m]."""
        n = len(self.K)
        stiff = self.K + (self.flanks.B * tangent) @ self.flanks.B.T + self.rows @ links @ self.rows.T
        return np.block([[np.zeros((n, n)), np.eye(n)], [-self.inverse @ stiff, -self.inverse @ self.C]])


def integrated_rms(found: Found, system: System, *, cycles: int = 2) -> Array:
    """RMS of the mesh forces over the last of a few cycles from the state of the balance, by `solve_ivp`, (w,) [N].

    A tolerance of 3e-6 leaves 5e-6 of the RMS, a hundredth of the closest comparison.
    """
    equation, period = Equation(system, found.speed), 1 / (found.speed * float(system.tones[0]))
    times = period * (cycles - 1 + np.arange(256) / 256)
    start = initial_state(found.at).ravel()
    run = solve_ivp(equation.rate, (0, cycles * period), start, "DOP853", times, rtol=3e-6, atol=1e-13)
    n = len(equation.K)
    force = np.array([equation.law(t, z[:n])[0] for t, z in zip(times, run.y.T, strict=True)])
    return np.asarray(mesh_force(system, force).std(axis=0))


@pytest.mark.parametrize(("name", "frequency"), PARTED)
def test_teeth_part_and_the_motion_is_stable(name: str, frequency: float) -> None:
    found = tabulated(name, frequency)
    assert found.at.stable
    assert (1 - found.at.state.touching.mean(axis=0)).max() > 0.05


@pytest.mark.parametrize(("name", "frequency"), PARTED)
def test_balance_is_the_integrated_motion(name: str, frequency: float) -> None:
    """RMS to 1e-3, and by tangents off by ten times that."""
    found = tabulated(name, frequency)
    reference = integrated_rms(found, drive(name))
    assert np.abs(found.force.std(axis=0) / reference - 1).max() < 1e-3
    assert np.abs(by_tangents(name, frequency).force.std(axis=0) / reference - 1).max() > 1e-2


@pytest.mark.parametrize(("name", "frequency"), PARTED)
def test_compiled_steps_are_the_balance(name: str, frequency: float) -> None:
    """Runge-Kutta steps of the transient from the state of the balance: RMS over the last of 20 cycles to 1e-3."""
    found, system = tabulated(name, frequency), drive(name)
    moving = motion(system, program=constant(found.speed))
    period, cycles, samples = 1 / (found.speed * float(system.tones[0])), 20, 128
    steps = -(-steps_for(moving, period) // samples) * samples
    states = integrate(
        moving, initial_state(found.at), stop=cycles * period, steps=cycles * steps, keep=steps // samples
    )[0]
    times = period * np.arange(len(states)) / samples
    force = record_force(moving, times[-samples:], states[-samples:]).T
    rms = mesh_force(system, force).std(axis=0)
    assert np.abs(found.force.std(axis=0) / rms - 1).max() < 1e-3
    assert np.abs(by_tangents(name, frequency).force.std(axis=0) / rms - 1).max() > 1e-2


@pytest.mark.parametrize(("name", "frequency"), PARTED)
def test_multipliers_are_those_of_the_variational_equation(name: str, frequency: float) -> None:
    """All multipliers of the motion to 1e-3; with tangents of the operating load off by ten times that."""
    found, system = tabulated(name, frequency), drive(name)
    reference = _integrated_multipliers(found, system)
    refinement = Refinement(ready=found.ready)
    ours = floquet_multipliers(refinement, found.at, steps=384)
    assert _apart(ours, reference) < 1e-3
    other = by_tangents(name, frequency)
    wrong = floquet_multipliers(Refinement(ready=other.ready), other.at)
    assert _apart(wrong, reference) > 1e-2


def _integrated_multipliers(found: Found, system: System) -> ComplexArray:
    """Multipliers (2n,) of the variational equation along the motion of the balance, by 1500 Runge-Kutta steps.

    A step turns the phase of the highest mode by 0.03: its error is below 1e-6.
    """
    equation, given, state = Equation(system, found.speed), found.at.balance, found.at.state
    gap = gap_rows(given, state.y) - given.error
    orders, period = given.grid.points[:, 0], 1 / (found.speed * float(system.tones[0]))
    steps = 1500
    phases = np.arange(2 * steps + 1) / (2 * steps)  # both ends and the middle of every step
    angle = 2 * np.pi * np.outer(phases, orders)
    delta = np.concatenate([np.cos(angle), -np.sin(angle)], axis=1) @ gap
    F = equation.flanks.mesh.size
    _, tangent = equation.flanks.at(phases[:, None] % 1.0).evaluate(delta[:, :F])
    links = system.laws.tangent(delta[:, F : F + equation.rows.shape[1]])
    h, Z = period / steps, np.eye(2 * len(equation.K))
    for step in range(steps):
        first, middle, last = (equation.jacobian(tangent[i], links[i]) for i in range(2 * step, 2 * step + 3))
        one = first @ Z
        two = middle @ (Z + h / 2 * one)
        three = middle @ (Z + h / 2 * two)
        Z = Z + h / 6 * (one + 2 * two + 2 * three + last @ (Z + h * three))
    return np.asarray(np.linalg.eigvals(Z))


def _apart(one: ComplexArray, other: ComplexArray) -> float:
    """Largest distance of a multiplier of either set (k,), (l,) from the nearest of the other set."""
    far = np.abs(one[:, None] - other)
    return float(max(far.min(axis=1).max(), far.min(axis=0).max()))


@pytest.mark.parametrize("name", ["ren2021", "xu2020"])
def test_static_is_the_balance_at_a_thousandth_of_the_speed(name: str) -> None:
    """Without deviations, to 1e-6 of the largest force at every instant; by tangents off by ten times that.

    With as many samples as unknowns a harmonic the balance holds at every instant, nothing is truncated.
    """
    system = epicyclic.assemble(replace(load(name, overrides=TABLES), displacements=()))
    contact = {order * system.tones[0] for order in range(13)}
    assert {line.frequency for line in system.lines} <= contact  # the errors of the tangents alone
    # modal damping of 3 % leaves 1.2e-5 at a thousandth of the speed, with linear meshes too
    system = replace(system, force=TORQUE * system.force, zeta=1e-3)
    harmonics, samples = 50, 101
    found = _slow(system, harmonics, samples)
    static = epicyclic.static(system, cycles=1, samples=samples).mesh_force.values.T
    largest = np.abs(static).max()
    assert np.abs(found - static).max() < 1e-6 * largest
    assert np.abs(_slow(tangents(system), harmonics, samples) - static).max() > 1e-5 * largest


def _slow(system: System, harmonics: int, samples: int) -> Array:
    """Mesh forces (N, w) [N] of the balance at a thousandth of the operating speed."""
    ready = response(system)
    refinement = Refinement(ready=ready)
    given = refinement.problem(harmonics, samples=samples)
    start = load_continuation(refinement, 1e-3, harmonics=16)
    y = prolonged(refinement.problem(16), given, start.state.y)
    found = solve(given, y, 1e-3, tolerance=1e-10)
    assert found.converged
    return np.asarray(mesh_force(system, flank_force(given, found.state)))


# links ----------------------------------------------------------------------------------------------------------------

LINKS: dict[str, tuple[float, dict[str, object]]] = {
    "play and rolling elements": (
        200.0,
        {
            "stages.main.sun.support.clearance": "20 um",
            "stages.main.planet.bearing.clearance": "10 um",
            "stages.main.planet.bearing.exponent": 1.111,
            "stages.main.planet.bearing.load": "50 kN",
        },
    ),
    "spline": (
        120.0,
        {"stages.main.sun.support.clearance": "20 um", "stages.main.sun.support.friction": {"force": "400 N"}},
    ),
}


@lru_cache(maxsize=4)
def linked(name: str) -> System:
    """A drive with laws of links, mesh orders alone."""
    system = epicyclic.assemble(load("ren2021", overrides=LINKS[name][1]))
    whole = {order * system.tones[0] for order in range(64)}
    return replace(system, lines=tuple(line for line in system.lines if line.frequency in whole))


@pytest.mark.parametrize("name", LINKS)
def test_links_by_their_law(name: str) -> None:
    """Balance against `solve_ivp` and Runge-Kutta steps, RMS to 1e-3; multipliers to 1e-3; tangents are off by ten."""
    system, frequency = linked(name), LINKS[name][0]
    assert system.groups
    found, plain = balance(system, frequency), balance(linear(system), frequency)
    reference = integrated_rms(found, system)
    rms = found.force.std(axis=0)
    assert np.abs(rms / reference - 1).max() < 1e-3
    assert np.abs(plain.force.std(axis=0) / reference - 1).max() > 1e-2
    multipliers = _integrated_multipliers(found, system)
    refinement = Refinement(ready=found.ready)
    ours = floquet_multipliers(refinement, found.at, steps=384)
    assert _apart(ours, multipliers) < 1e-3
    wrong = floquet_multipliers(Refinement(ready=plain.ready), plain.at, steps=384)
    assert _apart(wrong, multipliers) > 1e-2


# first touch ----------------------------------------------------------------------------------------------------------


def test_first_touch_is_one_gap_in_every_route() -> None:
    """Static record, grid of the balance and compiled rows begin to press at one gap, to 1e-12 m."""
    from epicyclic.questions.transient.compiled import _phase, _tabulated  # the compiled row itself
    from epicyclic.statics.record import mesh_phases

    system = drive("ren2021")
    samples = 64
    phases = mesh_phases(system, system.tones[0], np.arange(samples), samples)
    statics = flanks(system).at(phases).touch
    assert np.abs(statics).min() > 1e-11  # tangents touch at 0
    given = Refinement(ready=response(system)).problem(16, samples=samples)
    zero = np.zeros_like(statics)
    np.testing.assert_allclose(-given.laws.opening(zero), statics, rtol=0, atol=1e-12)
    N = motion(system).numbers
    for f in range(statics.shape[1]):
        for i in range(0, samples, 9):
            x, row = _phase(N.flank, N.tone, N.tones, f, i / samples / float(system.tones[0]))

            def presses(gap: float, f: int = f, x: float = x, row: int = row) -> bool:
                return bool(_tabulated(N.flank, f, x, row, gap)[1])

            low, high = statics[i, f] - 1e-6, statics[i, f] + 1e-6
            assert presses(high)
            assert not presses(low)
            while high - low > 1e-14:
                middle = (low + high) / 2
                low, high = (low, middle) if presses(middle) else (middle, high)
            assert high == pytest.approx(statics[i, f], abs=1e-12)


# far flanks -----------------------------------------------------------------------------------------------------------


def test_far_flanks_by_their_table() -> None:
    """Teeth that strike their other flank behind 20 um of backlash, both flanks tabulated, ren2021 at 140 Hz."""
    gap = {f"stages.main.meshes.{pair}.backlash": "20 um" for pair in ("sun-planet", "planet-ring")}
    system = epicyclic.assemble(load("ren2021", overrides={**TABLES, **gap}))
    assert system.far is not None
    assert len(system.far.laws) == len(system.meshes.laws)
    whole = {order * system.tones[0] for order in range(64)}
    # without the centrifugal load: at this speed of a slow drive it throws the planets into the ring, both flanks shut
    at_rest = np.array([[1.0], [1.0], [0.0]])
    lines = tuple(replace(line, force=line.force * at_rest) for line in system.lines if line.frequency in whole)
    system = replace(system, force=TORQUE * system.force, lines=lines)
    found, m = balance(system, 140.0), len(system.meshes.name)
    assert found.at.stable
    assert found.at.state.touching[:, m:].mean(axis=0).max() > 0.1
    reference = integrated_rms(found, system)
    assert np.abs(found.force.std(axis=0) / reference - 1).max() < 5e-4
    plain = balance(tangents(system), 140.0)
    assert np.abs(plain.force.std(axis=0) / reference - 1).max() > 5e-3
