"""Integration of the equation of motion: classical Runge-Kutta steps of fixed length, or SciPy's adaptive integrators.

The Runge-Kutta steps [hairer1993, sec. II.1] are compiled where numba is installed and every law has a compiled form,
else the same steps in NumPy.  Sliders of Coulomb friction stand still within a step, whose forces follow from where the
slider would be, and are moved at its end (derived here): along a straight pull that is exact at any length of step; a
pull that turns round within a step h is missed by its acceleration times h^2 / 8 at most.

Extremes of mesh forces, time apart and impacts are tallied over every step: an impact lasts a few of them, and samples
kept at some instants of a mesh cycle pass over it.  A step is tallied with the forces at its beginning, which the
integrator has worked out anyway; the end of a run is one of its samples.

The reference of the compiled steps, and slow.  Products do without BLAS, so that sums have one order whatever the
number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.integrate import DOP853, Radau

from ...errors import ConvergenceError, ModelError
from ...machine_code import numba_available
from ...statics.equilibrium import compliance, equilibrium
from ...system.gaps import FlanksAt
from ...system.link_laws import Laws
from ...system.system import Array, elastic_rows
from .equation import Motion, Steps, from_modal, highest_rate, phase_at, phases_at, tangent_series, times, to_modal

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
    stiff : (n, n) transposed, what the speed and links that pass a body add to the stiffness [1/s^2].
    """

    speed: float
    rise: float
    flanks: FlanksAt
    k: Array
    error: Array
    error_rate: Array
    push: Array
    stiff: Array


def instant_terms(moving: Motion, t: float, middle: float) -> InstantTerms:
    """Coefficients and loads at time t [s].

    On the line of the program that holds at time `middle` (one side of a jump).
    """
    N, program = moving.numbers, moving.numbers.program
    at = min(max(int(np.searchsorted(program.time, middle, side="right")) - 1, 0), program.time.size - 2)
    span, since = program.time[at + 1] - program.time[at], t - program.time[at]
    rise = float((program.speed[at + 1] - program.speed[at]) / span)
    s = float(program.speed[at] + rise * since)
    tau = program.phase[at] + since * (program.speed[at] + rise * since / 2)
    level = program.level[at] + (program.level[at + 1] - program.level[at]) * (since / span)
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
    stiff = s * s * N.stiff[0] + s * N.stiff[1] + rise * N.stiff[2]
    for frequency, real, imaginary in zip(N.wave_at, *N.wave, strict=True):
        stiff += np.cos(2 * np.pi * frequency * tau) * real - np.sin(2 * np.pi * frequency * tau) * imaginary
    return InstantTerms(s, rise, moving.flanks.at(phases_at(moving, turned)), k, error, rate, push, stiff)


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
        sliders = N.link.anchor if slider is None else slider
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
    return laws.rows.spread(reach / np.where(size > 0, size, 1.0)) * speed


def group_gaps(moving: Motion, at: InstantTerms, y: Array) -> Array:
    """Stretch less error (R,) [m] of the rows of groups, from modal coordinates y (n,)."""
    F = moving.numbers.drag.size
    return times(y, moving.numbers.gaps[:, F:]) - at.error[F:]


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
    force[F:] += times(stretch[F:], N.link.tangent)
    result: Array = at.push - N.squared * y - N.rate * v + times(force, N.pulls)
    result -= times(v, N.damp[0] + at.speed * N.damp[1])
    result -= times(y, at.stiff)
    return result, press


# --- states to begin from --------------------------------------------------------------------------------------------


def at_rest(moving: Motion) -> Array:
    """Nothing displaced, nothing moving relative to the nominal motion, (2, n) [m, rad], [m/s, rad/s]."""
    return np.zeros((2, moving.numbers.squared.size))


def at_equilibrium(moving: Motion, *, slider: Array | None = None) -> Array:
    """The state (2, n) in which nothing moves and nothing accelerates at time 0, centrifugal terms included.

    The static equilibrium of what is loaded then is the first guess; Newton steps add what depends on the speed.
    Dampers act through the rate of the errors.  Motions that nothing holds are left alone.

    Parameters
    ----------
    slider : (R,) of Coulomb friction before it [m]; where the mean load has put them where None.

    Raises
    ------
    ModelError, ConvergenceError : there is no such state, or it was not found.
    """
    N, at = moving.numbers, instant_terms(moving, 0.0, 0.0)
    before = N.link.anchor if slider is None else slider
    y = _first_guess(moving, at, before)
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
    return 1.0 / np.sqrt(np.where(squared > 0, squared, max(float(squared.max(initial=0.0)), 1.0)))


def _first_guess(moving: Motion, at: InstantTerms, slider: Array) -> Array:
    """Modal coordinates (n,) of the static equilibrium under the load at time 0; those of closed meshes if none."""
    N, m = moving.numbers, len(moving.system.meshes.name)
    if N.pull:
        return np.zeros(N.squared.size)
    load = np.asarray(np.linalg.solve(moving.shapes.T, at.push), dtype=np.float64)
    phases = phases_at(moving, phase_at(moving.program, np.zeros(1)))
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
    return np.asarray(to_modal(moving, balance.displacement[:1])[0])


def _newton_step(moving: Motion, at: InstantTerms, y: Array, left: Array, slider: Array) -> Array:
    """A Newton step (n,) with the tangents of the laws, from the acceleration `left` (n,)."""
    N = moving.numbers
    F, stretch = N.drag.size, y @ N.gaps
    tangent = np.zeros((stretch.size, stretch.size))
    tangent[:F, :F] = np.diag(at.k if N.pull else at.flanks.evaluate((stretch - at.error)[None, :F])[1][0])
    if stretch.size > F:
        tangent[F:, F:] = moving.laws.tangent(group_gaps(moving, at, y), slider if slider.size else None)
    mean = np.zeros_like(tangent)
    mean[:F, :F] = np.diag(N.linear)
    mean[F:, F:] = N.link.tangent
    stiff = np.diag(N.squared) + (N.gaps @ (tangent - mean) @ N.pulls).T
    stiff += at.stiff.T
    scale = _scale(moving)
    return scale * np.linalg.lstsq(scale[:, None] * stiff * scale, scale * left, rcond=_FREE)[0]


Adaptive = Literal["dop853", "radau"]
TOLERANCE = 1e-8
_SCIPY = {"dop853": DOP853, "radau": Radau}
# Absolute tolerance per relative one, in the scale of a mode: of modes that hardly move.
_ABSOLUTE = 1e-3
# Places within an adaptive step at which the way of a slider is looked at: a step that is repeated ends before the
# place where the way turns, so that 4 repetitions find it to 16^-4.
_PLACES = 16
# Least part of the interval that a repeated step may have: below it, the way of a slider is rounding.
_LEAST_STEP = 1e-12
# Step times highest rate: the phase of the highest mode is then right to 0.35^4 / 120 = 1.3e-4, of one at half of that
# to 8e-6; stable up to 2.7.
_STEP_RATE = 0.35
# Columns of `Tally.mesh`.
LEAST, LEAST_AT, MOST, MOST_AT, APART, FAR, IMPACTS, TOUCHED = range(8)


# --- tally of all steps ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tally:
    """What the steps of a run have met; both arrays are filled in place.

    mesh : (w, 8) of the w whole meshes: least force [N], when [s], largest force [N], when [s], time in which no flank
        presses [s], time in which a far flank presses [s], how often a flank presses again, and whether one did at the
        last step, -1 before the first.
    flank : (F, 2) largest force of every flank [N], and the time in which it is not above zero [s].

    A flank presses where its law does, also where its damper pulls more than that.
    """

    mesh: Array
    flank: Array

    def flat(self) -> Array:
        """All numbers in a row, (8 w + 2 F,)."""
        return np.concatenate([self.mesh.ravel(), self.flank.ravel()])

    def of(self, flat: Array) -> Tally:
        """A tally of the same shape from its numbers in a row."""
        first = self.mesh.size
        return Tally(mesh=flat[:first].reshape(self.mesh.shape), flank=flat[first:].reshape(self.flank.shape))


def empty_tally(moving: Motion) -> Tally:
    """The tally of a run before its first step."""
    N = moving.numbers
    mesh = np.zeros((int(N.whole.max(initial=-1)) + 1, 8))
    mesh[:, LEAST], mesh[:, MOST], mesh[:, TOUCHED] = np.inf, -np.inf, -1.0
    return Tally(mesh=mesh, flank=np.zeros((N.whole.size, 2)))


def note(moving: Motion, tally: Tally, force: Array, moment: float, span: float) -> None:
    """Add the forces of all flanks (F,) [N] at the beginning of a step, at a moment [s], of a length span [s].

    As `compiled._note`.  Forces that are not finite are left out.
    """
    N, mesh, flank = moving.numbers, tally.mesh, tally.flank
    if not np.isfinite(force).all():
        return
    far, presses = np.arange(force.size) >= N.loaded, force != 0
    total, state = np.zeros(len(mesh)), np.zeros((2, len(mesh)), bool)
    np.add.at(total, N.whole, np.where(far, -force, force))
    np.logical_or.at(state[0], N.whole, presses)
    np.logical_or.at(state[1], N.whole, presses & far)
    flank[:, 0] = np.maximum(flank[:, 0], force)
    flank[:, 1] += np.where(force > 0, 0.0, span)
    less, more = total < mesh[:, LEAST], total > mesh[:, MOST]
    mesh[less, LEAST], mesh[less, LEAST_AT] = total[less], moment
    mesh[more, MOST], mesh[more, MOST_AT] = total[more], moment
    mesh[:, APART] += np.where(state[0], 0.0, span)
    mesh[:, FAR] += np.where(state[1], span, 0.0)
    mesh[:, IMPACTS] += state[0] & (mesh[:, TOUCHED] == 0)
    mesh[:, TOUCHED] = state[0]


# --- steps of fixed length -------------------------------------------------------------------------------------------


def steps_for(moving: Motion, interval: float, *, rate: float = _STEP_RATE) -> int:
    """Steps that an interval [s] needs, from the highest rate of the motion; rate : that times the step."""
    return max(1, math.ceil(interval * highest_rate(moving) / rate))


def integrate(
    moving: Motion,
    state: Array,
    *,
    slider: Array | None = None,
    start: float = 0.0,
    stop: float,
    steps: int | None = None,
    keep: int = 1,
) -> tuple[Array, Array]:
    """Integrate from one time to another in equal steps.

    Parameters
    ----------
    moving : as `motion` makes it, at one speed or under a program.
    state : (2, n) q [m, rad] and q' at the start.
    slider : (R,) of Coulomb friction at the start [m]; where the mean load has put them where None.
    start, stop : times [s]; at relative speed s a mesh cycle takes 1 / (s tone).
    steps : number of steps in all; what `steps_for` says where None.  keep : every how many a state is kept, a divisor.

    Returns
    -------
    ((1 + steps / keep, 2, n) states, (1 + steps / keep, R) sliders [m]), the first ones included; nan from where the
    motion is no longer finite, no columns of sliders without a memory.

    Raises
    ------
    ModelError : an interval, number of steps or state that is none.
    """
    whole = math.isfinite(start) and math.isfinite(stop) and stop > start
    count = steps_for(moving, stop - start) if steps is None and whole else steps or 0
    if not whole or count < 1 or keep < 1 or count % keep:
        raise ModelError(
            "nothing to integrate",
            path="start, stop, steps, keep",
            given=f"{start}, {stop}, {steps}, {keep}",
            allowed="stop > start, and keep a divisor of steps",
        )
    if np.shape(state) != (2, moving.numbers.squared.size):
        raise ModelError("a state is (2, n)", path="state", given=str(np.shape(state)))
    begin = to_modal(moving, np.asarray(state, dtype=float))
    before = starting_slider(moving, begin, slider=slider, start=start)
    equal = Steps(begin=start, step=(stop - start) / count, first=0, keep=keep, samples=count // keep)
    states, sliders = rk4_states(moving, begin, before, equal)
    return from_modal(moving, np.concatenate([begin[None], states])), np.concatenate([before[None], sliders])


def starting_slider(moving: Motion, state: Array, *, slider: Array | None = None, start: float = 0.0) -> Array:
    """Sliders (R,) [m] at the start, from the modal state (2, n) there; (0,) without a memory.

    Parameters
    ----------
    slider : (R,) before it [m]; where the mean load has put them where None.  start : time [s].
    """
    anchor = moving.numbers.link.anchor
    if not anchor.size:
        return anchor
    before = anchor if slider is None else np.asarray(slider, dtype=float)
    return moved_slider(moving, instant_terms(moving, start, start), state[0], before)


def rk4_states(
    moving: Motion, state: Array, slider: Array, steps: Steps, tally: Tally | None = None
) -> tuple[Array, Array]:
    """Modal states (samples, 2, n) and sliders (samples, R) after every `keep` steps; nan once not finite.

    Parameters
    ----------
    state : (2, n) and slider : (R,) at the first of the steps.  tally : to which all steps are added in place.
    """
    tally = tally or empty_tally(moving)
    if moving.compiled and numba_available():
        from .compiled import advance

        return advance(moving.numbers, state, slider, steps, mesh=tally.mesh, flank=tally.flank)
    begin, step, first, keep, samples = steps
    out = np.full((samples, 2, state.shape[1]), np.nan)
    sliders = np.full((samples, slider.size), np.nan)
    (y, v), s = state, slider
    for sample in range(samples):
        with np.errstate(over="ignore", invalid="ignore"):
            for index in range(first + sample * keep, first + (sample + 1) * keep):
                moments = begin + index * step, begin + (index + 0.5) * step, begin + (index + 1) * step
                y, v, s = _rk4_step(moving, tally, moments, step, (y, v, s))
        if not (np.isfinite(y).all() and np.isfinite(v).all()):
            break
        out[sample], sliders[sample] = (y, v), s
    return out, sliders


def _rk4_step(
    moving: Motion,
    tally: Tally,
    moments: tuple[float, float, float],
    h: float,
    state: tuple[Array, Array, Array],
) -> tuple[Array, Array, Array]:
    """One Runge-Kutta step h [s] of y, v (n,) and sliders (R,) over its three moments [s] [hairer1993, sec. II.1]."""
    (t, middle, end), (y, v, s) = moments, state
    at = instant_terms(moving, t, middle)
    a1, force = acceleration_and_force(moving, at, y, v, s)
    note(moving, tally, force, t, h)
    at = instant_terms(moving, middle, middle)
    v2 = v + h / 2 * a1
    a2 = acceleration(moving, at, y + h / 2 * v, v2, s)
    v3 = v + h / 2 * a2
    a3 = acceleration(moving, at, y + h / 2 * v2, v3, s)
    at = instant_terms(moving, end, middle)
    v4 = v + h * a3
    a4 = acceleration(moving, at, y + h * v3, v4, s)
    y, v = y + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return y, v, moved_slider(moving, at, y, s)


# --- adaptive steps --------------------------------------------------------------------------------------------------


def _modal_scale(moving: Motion) -> Array:
    """Size of modal coordinates and rates, (2, n): what the load at the start gives the mode it moves most."""
    N = moving.numbers
    at = instant_terms(moving, float(N.program.time[0]), float(N.program.time[0]))
    F = N.drag.size
    k = moving.flanks.tangent.at(phases_at(moving, N.program.phase[:1])).stiffness[0]
    push = np.abs(at.push) + times(k * np.abs(at.error[:F]), np.abs(N.pulls[:F]))
    elastic = N.squared > 0
    lowest = np.min(N.squared[elastic]) if elastic.any() else 1.0
    omega = np.sqrt(np.where(elastic, N.squared, lowest))
    rate = max(float(np.max(push / omega, initial=0.0)), 1e-12)
    return np.stack([rate / omega, np.full(omega.size, rate)])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Stretch:
    """A stretch of the program without a jump inside, and how it is integrated.

    start, stop : its ends [s].  last : time up to which its program holds, just before a jump at the stop [s].
    tally : to which its steps are added in place.  options : tolerances, as scipy has them.
    """

    moving: Motion
    tally: Tally
    start: float
    stop: float
    last: float
    method: Adaptive
    options: Mapping[str, Any]

    def instant(self, t: float) -> InstantTerms:
        """What holds at a time [s]."""
        return instant_terms(self.moving, t, min(t, self.last))

    def slope(self, slider: Array) -> Callable[[float, Array], Array]:
        """Rates (2n,) of the flat modal state (2n,) at a time [s], with sliders (R,) [m] held."""
        n = self.moving.numbers.squared.size

        def slope(t: float, flat: Array) -> Array:
            """Rates (2n,) at time t [s]."""
            at = self.instant(t)
            return np.concatenate([flat[n:], acceleration(self.moving, at, flat[:n], flat[n:], slider)])

        return slope

    def note_step(self, y: Array, slider: Array, t: float, end: float) -> None:
        """Add a step from the flat state y (2n,) and sliders (R,) at t [s] to its end [s] to the tally."""
        n = self.moving.numbers.squared.size
        force = acceleration_and_force(self.moving, self.instant(t), y[:n], y[n:], slider)[1]
        note(self.moving, self.tally, force, t, end - t)


def adaptive_states(
    moving: Motion,
    state: Array,
    times: Array,
    *,
    slider: Array | None = None,
    method: Adaptive,
    tolerance: float = TOLERANCE,
    tally: Tally | None = None,
) -> tuple[Array, Array]:
    """Modal states (T - 1, 2, n) and sliders (T - 1, R) at times[1:] (T,) [s]; nan from where it fails.

    Integration begins anew at times[0] and at every jump of the program.

    Parameters
    ----------
    state : (2, n) and slider : (R,) at times[0]; sliders where the mean load has put them where None.
    tolerance : relative [1].  tally : to which all steps of the integrator are added in place.
    """
    tally = tally or empty_tally(moving)
    n, out, sliders = moving.numbers.squared.size, [], []
    knots = moving.program.time
    jumps = knots[:-1][np.diff(knots) == 0]
    bounds = [times[0], *np.unique(jumps[(jumps > times[0]) & (jumps < times[-1])]), times[-1]]
    y = state.ravel()
    s = starting_slider(moving, state, start=float(times[0])) if slider is None else slider
    options = {"rtol": tolerance, "atol": tolerance * _ABSOLUTE * _modal_scale(moving).ravel()}
    for low, high in pairwise(bounds):
        stretch = _Stretch(
            moving=moving,
            tally=tally,
            start=low,
            stop=high,
            last=np.nextafter(high, low),  # what holds up to the jump, not behind it
            method=method,
            options=options,
        )
        wanted = times[(times > low) & (times <= high)]
        moments = wanted if wanted.size and wanted[-1] == high else np.append(wanted, high)
        with np.errstate(over="ignore", invalid="ignore"):
            run = _with_sliders if s.size else _without_sliders
            block, slid = run(stretch, y, s, moments)
        y, s = block[-1], slid[-1]
        out.append(block[: wanted.size])
        sliders.append(slid[: wanted.size])
        if not np.isfinite(y).all():
            left = times.size - 1 - sum(map(len, out))
            out.append(np.full((left, 2 * n), np.nan))
            sliders.append(np.full((left, s.size), np.nan))
            break
    return np.concatenate(out).reshape(-1, 2, n), np.concatenate(sliders)


def _without_sliders(stretch: _Stretch, y: Array, s: Array, moments: Array) -> tuple[Array, Array]:
    """Flat states (T, 2n) at the moments (T,) [s] of one stretch of the program, and no sliders.

    What `scipy.integrate.solve_ivp` does, which shows no steps where it is asked for moments.
    """
    block, done = np.full((moments.size, y.size), np.nan), 0
    solver = _SCIPY[stretch.method](stretch.slope(s), stretch.start, y, stretch.stop, **stretch.options)
    while solver.status == "running":
        t, before = float(solver.t), solver.y
        solver.step()
        if solver.status == "failed":
            break
        stretch.note_step(before, s, t, float(solver.t))
        ready = int(np.searchsorted(moments, solver.t, side="right"))
        if ready > done:
            block[done:ready], done = solver.dense_output()(moments[done:ready]).T, ready
    return block, np.zeros((moments.size, 0))


def _with_sliders(stretch: _Stretch, y: Array, s: Array, moments: Array) -> tuple[Array, Array]:
    """Flat states (T, 2n) and sliders (T, R) at the moments (T,) [s] of one stretch of the program.

    A step whose end gives other sliders than its way, place by place, is repeated up to the last place where both
    agree, to the tolerance times the slip start: it passes over a turn (derived here).  The step control of the
    integrator itself sees no sliders.
    """
    t, high, laws = stretch.start, stretch.stop, stretch.moving.laws
    block, sliders = np.full((moments.size, y.size), np.nan), np.full((moments.size, s.size), np.nan)
    near = stretch.options["rtol"] * float(np.min(laws.slip_start[laws.memory]))
    least, done, length = _LEAST_STEP * (high - t), 0, None
    while done < moments.size:
        solver = _SCIPY[stretch.method](stretch.slope(s), t, y, high, first_step=length, **stretch.options)
        solver.step()
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            break
        dense, end = solver.dense_output(), float(solver.t)
        inside = moments[(moments > t) & (moments < end)]
        places = np.union1d(np.append(np.linspace(t, end, _PLACES + 1)[1:], inside), [end])
        ways, agree = _ways(stretch, s, places, dense, near)
        if not agree.all() and end - t > least:
            length = max(float(places[max(int(np.argmin(agree)) - 1, 0)]) - t, least)
            continue
        stretch.note_step(y, s, t, end)
        kept = np.searchsorted(places, np.append(inside, end))
        reached = moments[done : done + inside.size + 1]
        for moment, place in zip(reached, kept, strict=False):
            if moment <= end:
                block[done], sliders[done] = dense(moment), ways[place]
                done += 1
        t, y, s = end, solver.y, ways[-1]
        length = min(float(solver.h_abs), high - t) if high > t else None
    return block, sliders


def _ways(
    stretch: _Stretch, slider: Array, places: Array, dense: Callable[[float], Array], near: float
) -> tuple[Array, Array]:
    """Sliders (J, R) [m] moved from place to place (J,) [s] of a step, and whether one move to each agrees (J,)."""
    moving, n = stretch.moving, stretch.moving.numbers.squared.size
    gaps = [group_gaps(moving, stretch.instant(t), dense(t)[:n]) for t in map(float, places)]
    ways, s = [], slider
    for gap in gaps:
        s = moving.laws.slide(gap, s)
        ways.append(s)
    at_once = moving.laws.slide(np.array(gaps), slider)
    return np.array(ways), np.abs(np.array(ways) - at_once).max(axis=1) <= near
