"""The equation of motion in NumPy: right-hand side and row forces; slow, and the reference of the compiled one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...system.system import Array
from .motion import Numbers

__all__ = ["InstantTerms", "acceleration", "instant_terms", "row_force"]


class InstantTerms(NamedTuple):
    """Coefficients and loads of the equation at one instant, independent of the motion.

    speed, rise : s [1], s' [1/s].  k : (F,) [N/m].  error, error_rate : (M,) [m], [m/s], the backlash in it.
    push : (n,) modal force.
    """

    speed: float
    rise: float
    k: Array
    error: Array
    error_rate: Array
    push: Array


def instant_terms(N: Numbers, t: float, middle: float) -> InstantTerms:
    """Coefficients and loads at time t [s].

    On the line of the program that holds at time `middle` (one side of a jump).
    """
    at = int(np.clip(np.searchsorted(N.time, middle, side="right") - 1, 0, N.time.size - 2))
    span, since = N.time[at + 1] - N.time[at], t - N.time[at]
    rise = float((N.speed[at + 1] - N.speed[at]) / span)
    s = float(N.speed[at] + rise * since)
    tau = N.phase[at] + since * (N.speed[at] + rise * since / 2)
    level = N.level[at] + (N.level[at + 1] - N.level[at]) * (since / span)
    orders = np.arange(1, N.wave.shape[2] + 1)
    angle = 2 * np.pi * tau * N.tones[N.tone][:, None] * orders
    k = N.mean * (1 + (N.wave[0] * np.cos(angle) - N.wave[1] * np.sin(angle)).sum(axis=1))
    c, w = np.cos(2 * np.pi * N.gap_at * tau), np.sin(2 * np.pi * N.gap_at * tau)
    turn = 2 * np.pi * s * N.gap_at
    error = c @ N.gap[0] - w @ N.gap[1]
    error[: N.opening.size] += N.opening
    rate = -(turn * w) @ N.gap[0] - (turn * c) @ N.gap[1]
    c, w = np.cos(2 * np.pi * N.force_at * tau), np.sin(2 * np.pi * N.force_at * tau)
    powers = np.array([1.0, s, s * s, rise])
    push = N.steady + level @ N.load + rise * N.spin
    push = push + powers @ (c @ N.force[0] - w @ N.force[1])
    return InstantTerms(s, rise, k, error, rate, push)


def row_force(N: Numbers, at: InstantTerms, stretch: Array, rate: Array) -> Array:
    """Force of every row (M,) [N] from stretch B^T q (M,) [m] and rate B^T q' (M,) [m/s]."""
    gap, speed = stretch - at.error, rate - at.error_rate
    F = N.mean.size
    force = np.zeros(gap.size)
    force[:F] = at.k * gap[:F] + N.drag * speed[:F]
    if not N.pull:
        force[:F][gap[:F] <= 0.0] = 0.0
    for law in N.laws:
        rows = slice(F + int(law[0]), F + int(law[0] + law[1]))
        anchor = N.anchor[int(law[0]) : int(law[0] + law[1])]
        force[rows] = _law_force(law, gap[rows], speed[rows], anchor)
    return force


def _law_force(law: Array, gap: Array, speed: Array, anchor: Array) -> Array:
    """Force (r,) [N] of one group at gaps (r,) [m]: radial law, or the spring of a slider at rest.

    Damping per tangent.
    """
    _, _, k, friction, start, stop, coefficient, exponent, lag = law
    if friction < 0.0:
        held: Array = k * (gap - anchor) + lag * k * speed
        return held
    rho = float(np.sqrt(gap @ gap))
    beyond = rho - stop
    value, slope = min(k * rho, friction), k if rho < start else 0.0
    if beyond >= 0.0:
        value += coefficient * beyond**exponent
        slope += coefficient * exponent * beyond ** (exponent - 1.0)
    secant = value / rho if rho > 0.0 else slope
    force: Array = secant * gap
    if lag > 0.0:
        along = gap @ speed / (rho * rho) * gap if rho > 0.0 else np.zeros_like(gap)
        force = force + lag * (slope * along + secant * (speed - along))
    return force


def acceleration(N: Numbers, at: InstantTerms, y: Array, v: Array) -> Array:
    """y'' (n,) of a modal state y, v (n,)."""
    F = N.mean.size
    stretch = y @ N.gaps
    force = -row_force(N, at, stretch, v @ N.gaps)
    force[:F] += N.linear * stretch[:F]
    force[F:] += N.block @ stretch[F:]
    s = at.speed
    result: Array = at.push - N.squared * y - N.rate * v + force @ N.pulls
    result -= v @ (N.damp[0] + s * N.damp[1])
    result -= y @ (s * s * N.stiff[0] + s * N.stiff[1] + at.rise * N.stiff[2])
    return result
