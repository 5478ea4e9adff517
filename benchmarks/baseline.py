"""What the solver is measured against: `solve_ivp` with DOP853, and a shooting solution as reference for both.

Nothing here uses the package's solver; the equation of motion is written out from the System.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from epicyclic.system.system import System

Array = NDArray[np.float64]
# loosest first; where no atol helps, the relative tolerance has to go down
TOLERANCES = [(rtol, atol) for rtol in (1e-4, 3e-5, 1e-5, 1e-6) for atol in (1e-5, 1e-6, 1e-7, 1e-8, 1e-9)]
SAMPLES = 128


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Equation:
    """q'' = rest q + rate q' + pull (mesh forces) + push, at mesh orders only, at one mesh frequency."""

    system: System
    rest: Array
    rate: Array
    pull: Array
    push: Array
    orders: Array
    stiffness: NDArray[np.complex128]
    errors: NDArray[np.complex128]
    omega: float
    settle: float

    def laws(self, t: float) -> tuple[Array, Array]:
        """Mesh stiffness and error at time t, (m,) each."""
        wave = np.exp(1j * self.omega * t * self.orders)
        return (self.stiffness @ wave).real, (self.errors @ wave).real

    def slope(self, t: float, state: Array) -> Array:
        n = self.push.size
        q, v = state[:n], state[n:]
        k, e = self.laws(t)
        gaps = self.system.meshes.B.T @ q
        return np.concatenate([v, self.push + self.rest @ q + self.rate @ v - self.pull @ (k * (gaps - e))])

    def force(self, times: Array, q: Array) -> Array:
        """Mesh forces (m, T) for coordinates (n, T)."""
        laws = [self.laws(t) for t in times]
        k, e = np.array([law[0] for law in laws]).T, np.array([law[1] for law in laws]).T
        force: Array = k * (self.system.meshes.B.T @ q - e)
        return force


def equation(system: System, frequency: float) -> Equation:
    """The equation at a mesh frequency [Hz]; lines that are no mesh order are left out."""
    meshes, tone = system.meshes, float(system.tones[0])
    if meshes.damping.any():
        raise ValueError("the baseline is written for trains without mesh dampers")
    s, m = frequency / tone, len(meshes.name)
    inverse = np.linalg.inv(system.M)
    C, settle = _damping(system)
    length = max([meshes.variation.shape[1], *(int(line.frequency / tone) for line in system.lines)])
    stiffness, errors = np.zeros((m, length + 1), complex), np.zeros((m, length + 1), complex)
    stiffness[:, 0] = meshes.stiffness
    stiffness[:, 1 : meshes.variation.shape[1] + 1] = meshes.stiffness[:, None] * meshes.variation
    push = system.force.copy()
    for line in system.lines:
        order = line.frequency / system.tones[0]
        if order.denominator == 1:
            errors[:, int(order)] += line.gap
            if line.frequency == 0:
                push += (line.force[0] + s * line.force[1] + s**2 * line.force[2]).real
    return Equation(
        system=system,
        rest=-inverse @ (system.K + s**2 * system.Kg + s * system.Cskew),
        rate=-inverse @ (C + s * system.G),
        pull=inverse @ meshes.B,
        push=inverse @ push,
        orders=np.arange(length + 1),
        stiffness=stiffness,
        errors=errors,
        omega=2 * np.pi * frequency,
        settle=settle,
    )


def _damping(system: System) -> tuple[Array, float]:
    """C with the modal ratio written out, and the transient rule 10 / (zeta omega) of the slowest mode [s]."""
    lower = np.linalg.cholesky(system.M)
    half = np.linalg.inv(lower)
    squared, vectors = np.linalg.eigh(half @ system.mean_stiffness @ half.T)
    omega = np.sqrt(np.where(squared > 1e-9 * squared[-1], squared, 0.0))
    shapes = lower @ vectors
    C = system.C + (shapes * (2 * (system.zeta or 0.0) * omega)) @ shapes.T
    rates = np.diag(vectors.T @ half @ C @ half.T @ vectors) / 2
    return C, 10 / float(rates[omega > 0].min())


def integrate(motion: Equation, *, rtol: float, atol: float) -> tuple[Array, float]:
    """RMS of the dynamic mesh forces (m,) after the transient, and CPU seconds."""
    n = motion.push.size
    mean = motion.rest - motion.pull @ (motion.system.meshes.stiffness[:, None] * motion.system.meshes.B.T)
    begin = np.concatenate([-np.linalg.lstsq(mean, motion.push, rcond=1e-12)[0], np.zeros(n)])
    period = 2 * np.pi / motion.omega
    first = np.ceil(motion.settle / period) * period
    times = first + period * np.arange(SAMPLES) / SAMPLES
    clock = time.process_time()
    found = solve_ivp(motion.slope, (0, first + period), begin, method="DOP853", t_eval=times, rtol=rtol, atol=atol)
    spent = time.process_time() - clock
    return motion.force(times, found.y[:n]).std(axis=1), spent


def fair(motions: list[Equation], references: list[Array], *, limit: float) -> tuple[list[float], float, str]:
    """(CPU seconds at each speed, largest error, setting) of the loosest setting that meets the limit everywhere."""
    for rtol, atol in TOLERANCES:
        seconds: list[float] = []
        errors: list[float] = []
        for motion, reference in zip(motions, references, strict=True):
            rms, spent = integrate(motion, rtol=rtol, atol=atol)
            seconds.append(spent)
            errors.append(relative(rms, reference))
            if errors[-1] > limit:
                break
        else:
            return seconds, max(errors), f"rtol {rtol:g} atol {atol:g}"
    raise RuntimeError("no tolerance of the baseline meets the limit")


def shooting(motion: Equation, *, rtol: float = 1e-9) -> Array:
    """RMS of the dynamic mesh forces (m,) of the exact periodic solution, from the transition matrix of one cycle."""
    n, period = motion.push.size, 2 * np.pi / motion.omega
    B = motion.system.meshes.B.T
    mean = motion.rest - motion.pull @ (motion.system.meshes.stiffness[:, None] * B)
    unit = float(np.sqrt(np.abs(np.diag(mean)).max()))

    def slope(t: float, flat: Array) -> Array:
        state = flat.reshape(2 * n, -1)
        q, v = state[:n], state[n:]
        k, e = motion.laws(t)
        accel = motion.rest @ q + motion.rate @ v - motion.pull @ (k[:, None] * (B @ q))
        accel[:, -1] += motion.push + motion.pull @ (k * e)
        return np.concatenate([v, accel]).ravel()

    scale = np.concatenate([np.full(n, 1 / unit), np.ones(n)])
    begin = np.hstack([np.diag(scale), np.zeros((2 * n, 1))])
    size = np.abs(motion.push).max() / unit
    end = solve_ivp(
        slope, (0, period), begin.ravel(), method="DOP853", rtol=rtol, atol=rtol * 1e-3 * min(1 / unit, size)
    )
    last = end.y[:, -1].reshape(2 * n, -1) / scale[:, None]
    start = np.linalg.lstsq(np.eye(2 * n) - last[:, :-1], last[:, -1], rcond=1e-10)[0] * scale
    times = period * np.arange(SAMPLES) / SAMPLES
    found = solve_ivp(
        motion.slope,
        (0, period),
        start,
        method="DOP853",
        t_eval=times,
        rtol=rtol,
        atol=rtol * np.abs(start).max() * 1e-3,
    )
    rms: Array = motion.force(times, found.y[:n]).std(axis=1)
    return rms


def relative(rms: Array, reference: Array) -> float:
    """Largest error over the meshes in the largest RMS."""
    return float(np.abs(rms - reference).max() / reference.max())
