"""The equation of motion in NumPy, which asks the laws: the reference of the compiled steps, and slow.

Products do without BLAS, so that sums have one order whatever the number of threads.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...system.gaps import FlanksAt
from ...system.group_laws import Laws
from ...system.system import Array
from .motion import Motion, phases_at, tangent_series
from .products import times

__all__ = [
    "AHEAD",
    "InstantTerms",
    "acceleration",
    "acceleration_and_force",
    "group_gaps",
    "instant_terms",
    "moved_slider",
    "row_force",
]


# Part of the slip start by which a tangent is taken ahead of the motion: far above rounding, far below what is seen.
AHEAD = 1e-6


class InstantTerms(NamedTuple):
    """Coefficients and loads of the equation at one instant, independent of the motion.

    speed, rise : s [1], s' [1/s].  flanks : laws at the phases of the instant, P = 1.
    k : (F,) of flanks that pull too [N/m]; (0,) where laws hold.
    error, error_rate : (M,) [m], [m/s], the backlash in it.  push : (n,) modal force.
    """

    speed: float
    rise: float
    flanks: FlanksAt
    k: Array
    error: Array
    error_rate: Array
    push: Array


def instant_terms(moving: Motion, t: float, middle: float) -> InstantTerms:
    """Coefficients and loads at time t [s].

    On the line of the program that holds at time `middle` (one side of a jump).
    """
    N = moving.numbers
    at = int(np.clip(np.searchsorted(N.time, middle, side="right") - 1, 0, N.time.size - 2))
    span, since = N.time[at + 1] - N.time[at], t - N.time[at]
    rise = float((N.speed[at + 1] - N.speed[at]) / span)
    s = float(N.speed[at] + rise * since)
    tau = N.phase[at] + since * (N.speed[at] + rise * since / 2)
    level = N.level[at] + (N.level[at + 1] - N.level[at]) * (since / span)
    c, w = np.cos(2 * np.pi * N.gap_at * tau), np.sin(2 * np.pi * N.gap_at * tau)
    turn = 2 * np.pi * s * N.gap_at
    error = times(c, N.gap[0]) - times(w, N.gap[1])
    error[: N.opening.size] += N.opening
    rate = -times(turn * w, N.gap[0]) - times(turn * c, N.gap[1])
    c, w = np.cos(2 * np.pi * N.force_at * tau), np.sin(2 * np.pi * N.force_at * tau)
    powers = np.array([1.0, s, s * s, rise])
    push = N.steady + times(level, N.load) + rise * N.spin
    push = push + np.einsum("p,pjn,j->n", powers, N.force[0], c) - np.einsum("p,pjn,j->n", powers, N.force[1], w)
    turned = np.atleast_1d(tau)
    k = tangent_series(moving, turned)[0] if N.pull else np.zeros(0)
    return InstantTerms(s, rise, moving.flanks.at(phases_at(moving, turned)), k, error, rate, push)


def row_force(moving: Motion, at: InstantTerms, stretch: Array, rate: Array, slider: Array | None = None) -> Array:
    """Force of every row (M,) [N] from stretch B^T q (M,) [m] and rate B^T q' (M,) [m/s].

    slider : (R,) before the step, of Coulomb friction [m]; where the mean load has put it where None.
    """
    N, laws = moving.numbers, moving.laws
    gap, speed = stretch - at.error, rate - at.error_rate
    F = N.drag.size
    force = np.empty(gap.size)
    if N.pull:
        force[:F] = at.k * gap[:F] + N.drag * speed[:F]
    else:
        pressed = gap[:F] > at.flanks.touch[0]
        force[:F] = at.flanks.evaluate(gap[None, :F])[0][0] + np.where(pressed, N.drag * speed[:F], 0.0)
    if gap.size > F:
        anchor = _anchor(moving, slider)
        force[F:] = laws.force(gap[F:], anchor)
        lag = np.array([group.lag for group in moving.system.groups])
        if lag.any():
            tangent = laws.tangent(gap[F:] + _ahead(laws, speed[F:]), anchor)
            force[F:] += laws.rows.spread(lag) * times(speed[F:], tangent)
    return force


def _ahead(laws: Laws, speed: Array) -> Array:
    """A step (R,) [m] of groups with a memory along their rate (R,) [m/s]; none of others.

    A slider that has moved leaves its group at the edge of slip, where the tangents of both sides differ and rounding
    would choose: its damper has the tangent of the side that it goes to.
    """
    size = laws.rows.size(speed)
    reach = np.where(laws.memory, AHEAD * laws.slip_start, 0.0)
    step: Array = laws.rows.spread(reach / np.where(size > 0, size, 1.0)) * speed
    return step


def _anchor(moving: Motion, slider: Array | None) -> Array | None:
    """Sliders (R,) [m] as the laws take them, None without a memory."""
    given = moving.numbers.anchor if slider is None else slider
    return given if given.size else None


def group_gaps(moving: Motion, at: InstantTerms, y: Array) -> Array:
    """Stretch less error (R,) [m] of the rows of groups, from modal coordinates y (n,)."""
    F = moving.numbers.drag.size
    gap: Array = times(y, moving.numbers.gaps[:, F:]) - at.error[F:]
    return gap


def moved_slider(moving: Motion, at: InstantTerms, y: Array, slider: Array) -> Array:
    """Sliders (R,) [m] after a step that ends at modal coordinates y (n,); themselves without a memory."""
    return moving.laws.slide(group_gaps(moving, at, y), slider) if slider.size else slider


def acceleration(moving: Motion, at: InstantTerms, y: Array, v: Array, slider: Array | None = None) -> Array:
    """y'' (n,) of a modal state y, v (n,), with the sliders of the beginning of the step (R,) [m]."""
    return acceleration_and_force(moving, at, y, v, slider)[0]


def acceleration_and_force(
    moving: Motion, at: InstantTerms, y: Array, v: Array, slider: Array | None = None
) -> tuple[Array, Array]:
    """As `acceleration`, with the forces of all flanks (F,) [N]."""
    N = moving.numbers
    F = N.drag.size
    stretch = times(y, N.gaps)
    force = -row_force(moving, at, stretch, times(v, N.gaps), slider)
    press = -force[:F]
    force[:F] += N.linear * stretch[:F]
    force[F:] += times(stretch[F:], N.block)
    s = at.speed
    result: Array = at.push - N.squared * y - N.rate * v + times(force, N.pulls)
    result -= times(v, N.damp[0] + s * N.damp[1])
    result -= times(y, s * s * N.stiff[0] + s * N.stiff[1] + at.rise * N.stiff[2])
    return result, press
