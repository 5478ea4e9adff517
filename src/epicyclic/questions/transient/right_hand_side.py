"""The equation of motion in NumPy, which asks the laws, and the states a run begins from: rest, or an equilibrium.

The reference of the compiled steps, and slow.  Products do without BLAS, so that sums have one order whatever the
number of threads.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...errors import ConvergenceError, ModelError
from ...statics.equilibrium import compliance, equilibrium
from ...system.gaps import FlanksAt
from ...system.link_laws import Laws
from ...system.system import Array, elastic_rows
from .equation import Motion, from_modal, phases_at, tangent_series, to_modal
from .program import phase_at, times

# Part of the slip start by which a tangent is taken ahead of the motion: far above rounding, far below what is seen.
AHEAD = 1e-6
# Newton steps; each either changes the set of flanks in contact or is the last, and splines need a few more.
_STEPS = 40
# Residual acceleration per the largest term of it: rounding of sums over all modes is 1e-13.
_TOLERANCE = 1e-11
# Singular values below this part of the largest belong to motions that nothing holds.
_FREE = 1e-12
# Halvings of a Newton step that does not make the residual smaller: curved laws want a few.
_HALVINGS = 8


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
        sliders = N.anchor if slider is None else slider
        anchor = sliders if sliders.size else None
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


# --- states to begin from --------------------------------------------------------------------------------------------


def at_rest(moving: Motion) -> Array:
    """Nothing displaced, nothing moving relative to the nominal motion, (2, n) [m, rad], [m/s, rad/s]."""
    return np.zeros((2, moving.numbers.squared.size))


def at_equilibrium(moving: Motion, *, start: float = 0.0, slider: Array | None = None) -> Array:
    """The state (2, n) in which nothing moves and nothing accelerates at one instant, centrifugal terms included.

    The static equilibrium of what is loaded then is the first guess; Newton steps add what depends on the speed.
    Dampers act through the rate of the errors.  Motions that nothing holds are left alone.

    Parameters
    ----------
    start : the instant [s].  slider : (R,) of Coulomb friction before it [m]; where the mean load has put them where
        None.

    Raises
    ------
    ModelError, ConvergenceError : there is no such state, or it was not found.
    """
    N, at = moving.numbers, instant_terms(moving, start, start)
    before = N.anchor if slider is None else slider
    y = _first_guess(moving, at, start, before)
    still, left, scale = np.zeros_like(y), _residual(moving, at, y, before), _scale(moving)
    F = N.drag.size
    for _ in range(_STEPS):
        stretch = np.abs(y @ N.gaps)
        size = np.abs(at.push) + N.squared * np.abs(y) + (N.linear * stretch[:F]) @ np.abs(N.pulls[:F])
        if np.all(np.abs(left) <= _TOLERANCE * (size + np.max(size, initial=0.0))):
            return from_modal(moving, np.stack([y, still]))
        step, length = _newton_step(moving, at, y, left, before), 1.0
        trial = _residual(moving, at, y + step, before)
        for _ in range(_HALVINGS):
            if np.linalg.norm(scale * trial) < np.linalg.norm(scale * left):
                break
            length /= 2
            trial = _residual(moving, at, y + length * step, before)
        else:  # a kink: the whole step finds the other side
            length, trial = 1.0, _residual(moving, at, y + step, before)
        y, left = y + length * step, trial
    raise ConvergenceError("no equilibrium found to start from: start from rest, or from a state")


def _residual(moving: Motion, at: InstantTerms, y: Array, slider: Array) -> Array:
    """Acceleration (n,) of a state that does not move, without motions that nothing holds."""
    left = acceleration(moving, at, y, np.zeros_like(y), slider)
    left[moving.rigid] = 0.0  # nothing holds these, and the loads balance on them
    return left


def _scale(moving: Motion) -> Array:
    """Modal displacement per root of the strain energy (n,)."""
    squared = moving.numbers.squared
    scale: Array = 1.0 / np.sqrt(np.where(squared > 0, squared, max(float(squared.max(initial=0.0)), 1.0)))
    return scale


def _first_guess(moving: Motion, at: InstantTerms, start: float, slider: Array) -> Array:
    """Modal coordinates (n,) of the static equilibrium under the load of an instant; those of closed meshes if none."""
    N, m = moving.numbers, len(moving.system.meshes.name)
    if N.pull:
        return np.zeros(N.squared.size)
    load = np.asarray(np.linalg.solve(moving.shapes.T, at.push), dtype=np.float64)
    phases = phases_at(moving, phase_at(moving.program, np.array([start])))
    stiffness = np.concatenate([moving.flanks.linear, moving.laws.row_stiffness])
    try:
        balance = equilibrium(
            compliance(elastic_rows(moving.system), moving.rows, stiffness),
            stiffness=moving.flanks.tangent.at(phases).stiffness[:, :m],
            gap=at.error[None],
            force=load[None],
            flanks=at.flanks,
            laws=moving.laws,
            anchor=slider[None] if slider.size else None,
        )
    except ModelError:  # without what depends on the speed the load may part bodies that it holds together
        return np.zeros(N.squared.size)
    state: Array = to_modal(moving, balance.displacement[:1])[0]
    return state


def _newton_step(moving: Motion, at: InstantTerms, y: Array, left: Array, slider: Array) -> Array:
    """A Newton step (n,) with the tangents of the laws, from the acceleration `left` (n,)."""
    N = moving.numbers
    F, s = N.drag.size, at.speed
    stretch = y @ N.gaps
    tangent = np.zeros((stretch.size, stretch.size))
    tangent[:F, :F] = np.diag(at.k if N.pull else at.flanks.evaluate((stretch - at.error)[None, :F])[1][0])
    if stretch.size > F:
        tangent[F:, F:] = moving.laws.tangent(group_gaps(moving, at, y), slider if slider.size else None)
    mean = np.zeros_like(tangent)
    mean[:F, :F] = np.diag(N.linear)
    mean[F:, F:] = N.block
    stiff = np.diag(N.squared) + (N.gaps @ (tangent - mean) @ N.pulls).T
    stiff += (s * s * N.stiff[0] + s * N.stiff[1] + at.rise * N.stiff[2]).T
    scale = _scale(moving)
    step: Array = scale * np.linalg.lstsq(scale[:, None] * stiff * scale, scale * left, rcond=_FREE)[0]
    return step
