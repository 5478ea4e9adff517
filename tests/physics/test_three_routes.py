"""Harmonic balance, integration in time and the transition matrix of one mesh cycle find the same forces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

import epicyclic
from epicyclic.questions.response.measures import Periodic, periodic
from epicyclic.questions.transient.equation import constant, from_modal, motion, to_modal
from epicyclic.questions.transient.integrators import adaptive_states
from epicyclic.questions.transient.transient import link_force, mesh_force
from epicyclic.system.system import System

Array = NDArray[np.float64]
MESHES = "stages.main.meshes"
# name: (overrides, mesh frequency [Hz])
DRIVES: dict[str, tuple[dict[str, Any], float]] = {
    "ren2021": ({}, 212.0),  # a resonance
    "xu2020": ({}, 700.0),
    "yue2014-i": (  # its damping is that of the meshes; the rounded radii would not balance
        {
            **{f"stages.main.{gear}.base_radius": "" for gear in ("sun", "p", "d", "ring")},
            "operation.speed.sun": "1000 rpm",
            "operation.torque.sun": "43 N m",
            **{f"{MESHES}.{pair}.variation": {"cosine": [0.2], "sine": [0.1]} for pair in ("sun-p", "p-d", "d-ring")},
        },
        420.0,
    ),
}


def at_mesh_orders(name: str) -> tuple[System, float]:
    """A ready drive with the lines that are multiples of the mesh frequency, and its relative speed."""
    overrides, frequency = DRIVES[name]
    system = epicyclic.assemble(epicyclic.load(name, overrides=overrides))
    tone = system.tones[0]
    lines = tuple(line for line in system.lines if (line.frequency / tone).denominator == 1)
    return replace(system, lines=lines), frequency / float(tone)


class Linear:
    """x' = A(t) x + b(t) for x = (q, q'), written out from the System; half a step by commutator-free exponentials."""

    def __init__(self, system: System, speed: float) -> None:
        self.system, self.speed = system, speed
        lower = np.linalg.cholesky(system.M)
        half = np.linalg.inv(lower)
        squared, vectors = np.linalg.eigh(half @ system.mean_stiffness @ half.T)
        omega = np.sqrt(np.where(squared > 1e-11 * squared[-1], squared, 0.0))
        shapes = lower @ vectors
        self.inverse = np.linalg.inv(system.M)
        self.damping = system.C + speed * system.G + (shapes * (2 * (system.zeta or 0.0) * omega)) @ shapes.T
        self.stiffness = system.K + speed**2 * system.Kg + speed * system.Cskew
        self.unit = float(np.sqrt(squared[-1]))

    def laws(self, t: float) -> tuple[Array, Array, Array, Array]:
        meshes, s, turn = self.system.meshes, self.speed, 2j * np.pi * self.speed
        tone = float(self.system.tones[0])
        orders = np.arange(1, meshes.variation.shape[1] + 1)
        k = meshes.stiffness * (1 + (meshes.variation @ np.exp(turn * tone * orders * t)).real)
        e, rate, push = np.zeros(k.size), np.zeros(k.size), self.system.force.copy()
        for line in self.system.lines:
            wave = np.exp(turn * float(line.frequency) * t)
            e += (line.gap * wave).real
            rate += (turn * float(line.frequency) * line.gap * wave).real
            push += ((line.force[0] + s * line.force[1] + s**2 * line.force[2]) * wave).real
        return k, e, rate, push

    def generator(self, t: float) -> Array:
        """A(t) with b(t) as a last column, rates divided by `unit`."""
        n, B, c = len(self.system.force), self.system.meshes.B, self.system.meshes.damping
        k, e, rate, push = self.laws(t)
        A = np.zeros((2 * n + 1, 2 * n + 1))
        A[:n, n : 2 * n] = self.unit * np.eye(n)
        A[n : 2 * n, :n] = -self.inverse @ (self.stiffness + (B * k) @ B.T) / self.unit
        A[n : 2 * n, n : 2 * n] = -self.inverse @ (self.damping + (B * c) @ B.T)
        A[n : 2 * n, -1] = self.inverse @ (push + B @ (k * e + c * rate)) / self.unit
        return A

    def cycle(self, steps: int) -> list[Array]:
        """States (2 n,) q, q' / unit over the periodic mesh cycle, the last one as the first."""
        h = 1 / (self.speed * float(self.system.tones[0]) * steps)
        a, b = 0.25 + np.sqrt(3) / 6, 0.25 - np.sqrt(3) / 6  # of order four [blanes2006]
        flows = []
        for i in range(steps):
            first, second = (self.generator((i + 0.5 + place) * h) for place in (-np.sqrt(3) / 6, np.sqrt(3) / 6))
            late, early = (
                scipy.linalg.expm(h * (b * first + a * second)),
                scipy.linalg.expm(h * (a * first + b * second)),
            )
            flows.append(late @ early)
        whole = np.eye(len(flows[0]))
        for flow in flows:
            whole = flow @ whole
        # where the train stands in its turn is open: the least of all
        found = np.linalg.lstsq(np.eye(len(whole) - 1) - whole[:-1, :-1], whole[:-1, -1], rcond=1e-10)[0]
        x = np.append(found, 1.0)
        states = [x[:-1]]
        for flow in flows:
            x = flow @ x
            states.append(x[:-1])
        return states


def told(found: Periodic, times: Array) -> Array:
    """Mesh forces (m, T) of a steady response, all lines included."""
    count = found.theta.size
    theta = np.outer(np.fft.fftfreq(count, 1 / count), times * float(found.tone) * found.relative_speed)
    wave = np.exp(2j * np.pi * theta)
    total = (np.fft.fft(found.force) / count @ wave).real
    for line in found.lines:
        carrier = np.exp(2j * np.pi * float(line.frequency) * found.relative_speed * times)
        total += (np.fft.fft(line.force) / count @ wave * carrier).real
    return np.asarray(total)


@pytest.mark.parametrize("name", DRIVES)
def test_three_routes_meet(name: str) -> None:
    system, speed = at_mesh_orders(name)
    balance = periodic(system, relative_speed=speed)
    linear, steps = Linear(system, speed), 192
    states = linear.cycle(steps)
    n = len(system.force)
    period = 1 / (speed * float(system.tones[0]))
    times = period * np.arange(steps + 1) / steps
    shooting = np.empty((len(system.meshes.name), steps + 1))
    for i, (t, x) in enumerate(zip(times, states, strict=True)):
        k, e, rate, _ = linear.laws(t)
        gaps = system.meshes.B.T @ np.stack([x[:n], x[n:] * linear.unit], axis=1)
        shooting[:, i] = k * (gaps[:, 0] - e) + system.meshes.damping * (gaps[:, 1] - rate)
    moving = motion(system, program=constant(speed), contact="linear")
    start = to_modal(moving, np.stack([states[0][:n], states[0][n:] * linear.unit]))
    found, _ = adaptive_states(moving, start, times[::16], method="dop853")
    integrated = mesh_force(moving, times[::16], from_modal(moving, np.concatenate([start[None], found])))
    size = shooting.std(axis=1).max()
    assert size > 0.01 * shooting.mean()  # it vibrates
    # harmonic balance at its tolerance, exponentials of order four at 192 steps, dop853 at 1e-8
    assert np.abs(told(balance, times) - shooting).max() < 2e-5 * size
    assert np.abs(integrated - shooting[:, ::16]).max() < 2e-5 * size
    assert np.abs(integrated - told(balance, times[::16])).max() < 2e-5 * size


@pytest.mark.parametrize(("name", "speed"), [("ren2021", 7.0), ("encased-differential", 1.0), ("dong2019", 0.6)])
def test_a_run_settles_to_the_steady_response(name: str, speed: float) -> None:
    """All lines, two mesh frequencies in two of them: the verb's own default steps, from equilibrium."""
    system = epicyclic.assemble(epicyclic.load(name))
    known = periodic(system, relative_speed=speed)
    omega = 2 * np.pi * epicyclic.modes(system).frequency.values
    settle = 12 / ((system.zeta or np.nan) * omega[omega > 1].min())
    frequency = speed * float(known.tone)
    found = epicyclic.transient(system, mesh_frequency=frequency, duration=settle + 5 / frequency, contact="linear")
    late = found.time.values > settle
    exact = told(known, found.time.values[late])
    size = np.abs(exact - exact.mean(axis=1, keepdims=True)).max()
    steady = epicyclic.steady(system, relative_speed=speed)
    reach = 1e-3 * steady.link_force_peak_to_peak.max() + 1e-9 * steady.link_force_peak.max()
    links = found.link_force[:, late]
    # the peak is a bound over all phases of the shafts, which five mesh cycles do not reach
    assert (abs(links).max("time") <= steady.link_force_peak + reach).all()
    assert (links.max("time") - links.min("time") <= steady.link_force_peak_to_peak + 2 * reach).all()
    # what is left of the transient, e^-12 = 6e-6 of it, and fixed steps: 0.35^4 / 120 at the highest mode
    assert np.abs(found.mesh_force.values[:, late] - exact).max() < 3e-4 * size


def test_a_slow_ramp_follows_the_sweep() -> None:
    """RMS of mesh 1 within each 10 Hz of a ramp, as in a sweep; twice as slow, half as far from it."""
    system, _ = at_mesh_orders("ren2021")
    low, high = 190.0, 240.0
    centres = np.arange(low + 15, high - 5, 10)
    known = epicyclic.sweep(system, start=low, stop=high, points=101)
    steady = np.interp(centres, known.mesh_frequency, known.mesh_force_rms[0])
    far = []
    for duration in (2.0, 8.0):
        found = epicyclic.transient(system, mesh_frequency=(low, high), duration=duration, contact="linear", samples=16)
        force, frequency = found.mesh_force[0].values, found.mesh_frequency.values
        rms = [float(force[np.abs(frequency - centre) < 1].std()) for centre in centres]
        far.append(float(np.abs(np.array(rms) / steady - 1).max()))
    assert far[1] < 0.03  # the curve bends within the 2 Hz of a window
    assert far[0] > 1.5 * far[1]


def test_link_forces_of_a_state_are_those_of_the_steady_response() -> None:
    system, speed = at_mesh_orders("xu2020")
    known = epicyclic.steady(system, relative_speed=speed, samples=64)
    place = known.displacement.values / system.dofs.radius[:, None]
    orders = np.fft.fftfreq(64, 1 / 64)
    rates = np.fft.ifft(np.fft.fft(place) * 2j * np.pi * orders * speed * float(system.tones[0])).real
    moving = motion(system, program=constant(speed), contact="linear")
    times = np.arange(64) / (64 * speed * float(system.tones[0]))
    found = link_force(moving, times, np.stack([place.T, rates.T], axis=1))
    # the same sums from samples and from harmonics
    np.testing.assert_allclose(found, known.link_force.values, rtol=1e-9, atol=1e-9 * np.abs(found).max())
