"""Integration of the equation of motion: classical Runge-Kutta steps of fixed length, or SciPy's adaptive integrators.

The Runge-Kutta steps [hairer1993, sec. II.1] are compiled where numba is installed, else the same steps in NumPy.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.integrate import solve_ivp

from ...errors import ModelError
from ...system.system import Array
from ..fast import numba_available
from .motion import Motion, Numbers, from_modal, highest_rate, to_modal
from .right_hand_side import acceleration, instant_terms

__all__ = ["TOLERANCE", "Adaptive", "adaptive_states", "integrate", "modal_scale", "rk4_states", "steps_for"]

Adaptive = Literal["dop853", "radau"]
TOLERANCE = 1e-8
_SCIPY_NAME = {"dop853": "DOP853", "radau": "Radau"}
# Absolute tolerance per relative one, in the scale of a mode: of modes that hardly move.
_ABSOLUTE = 1e-3

# Step times highest rate: the phase of the highest mode is then right to 0.35^4 / 120 = 1.3e-4, of one at half of that
# to 8e-6; stable up to 2.7.
_STEP_RATE = 0.35


def steps_for(moving: Motion, interval: float) -> int:
    """Steps that an interval [s] needs, from the highest rate of the motion."""
    return max(1, math.ceil(interval * highest_rate(moving) / _STEP_RATE))


def integrate(
    moving: Motion, state: Array, *, start: float = 0.0, stop: float, steps: int | None = None, keep: int = 1
) -> Array:
    """Integrate from one time to another in equal steps.

    Parameters
    ----------
    moving : as `motion` makes it, at one speed or under a program.
    state : (2, n) q [m, rad] and q' at the start.
    start, stop : times [s]; at relative speed s a mesh cycle takes 1 / (s tone).
    steps : number of steps in all; what `steps_for` says where None.  keep : every how many a state is kept, a divisor.

    Returns
    -------
    (1 + steps / keep, 2, n) states, the first one included; nan from where the motion is no longer finite.

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
    found = rk4_states(
        moving.numbers, begin, first=0, begin=start, step=(stop - start) / count, keep=keep, samples=count // keep
    )
    return from_modal(moving, np.concatenate([begin[None], found]))


def rk4_states(N: Numbers, state: Array, *, first: int, begin: float, step: float, keep: int, samples: int) -> Array:
    """Modal states (samples, 2, n) after every `keep` steps from the state (2, n) at step `first`.

    The time of a step is counted from `begin` [s], so that where a run is cut does not change it.  step : [s].
    """
    run: Callable[..., Array] = _numpy
    if numba_available():
        from .compiled import advance as run
    return run(N, state, first=first, begin=begin, step=step, keep=keep, samples=samples)


def _numpy(N: Numbers, state: Array, *, first: int, begin: float, step: float, keep: int, samples: int) -> Array:
    """`rk4_states` in NumPy, (samples, 2, n); nan once not finite."""
    out = np.full((samples, 2, N.squared.size), np.nan)
    y, v = state
    for sample in range(samples):
        with np.errstate(over="ignore", invalid="ignore"):
            for index in range(first + sample * keep, first + (sample + 1) * keep):
                y, v = _one(N, begin + index * step, begin + (index + 0.5) * step, begin + (index + 1) * step, y, v)
        if not (np.isfinite(y).all() and np.isfinite(v).all()):
            break
        out[sample] = y, v
    return out


def _one(N: Numbers, t: float, middle: float, end: float, y: Array, v: Array) -> tuple[Array, Array]:
    """One Runge-Kutta step of y, v (n,) from t to `end` [s] [hairer1993, sec. II.1]."""
    h = end - t
    at = instant_terms(N, t, middle)
    a1 = acceleration(N, at, y, v)
    at = instant_terms(N, middle, middle)
    v2 = v + h / 2 * a1
    a2 = acceleration(N, at, y + h / 2 * v, v2)
    v3 = v + h / 2 * a2
    a3 = acceleration(N, at, y + h / 2 * v2, v3)
    at = instant_terms(N, end, middle)
    v4 = v + h * a3
    a4 = acceleration(N, at, y + h * v3, v4)
    return y + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


def modal_scale(moving: Motion) -> Array:
    """Size of modal coordinates and rates, (2, n): what the load at the start gives the mode it moves most."""
    N = moving.numbers
    at = instant_terms(N, float(N.time[0]), float(N.time[0]))
    F = N.mean.size
    push = np.abs(at.push) + np.abs((at.k * np.abs(at.error[:F])) @ np.abs(N.pulls[:F]))
    elastic = N.squared > 0
    lowest = np.min(N.squared[elastic]) if elastic.any() else 1.0
    omega = np.sqrt(np.where(elastic, N.squared, lowest))
    rate = max(float(np.max(push / omega, initial=0.0)), 1e-12)
    return np.stack([rate / omega, np.full(omega.size, rate)])


def adaptive_states(
    N: Numbers, state: Array, times: Array, *, method: Adaptive, scale: Array, tolerance: float = TOLERANCE
) -> Array:
    """Modal states (T - 1, 2, n) at times[1:] (T,) [s] from the state (2, n) at times[0]; nan from where it fails.

    Integration begins anew at times[0] and at every jump of the program.

    Parameters
    ----------
    scale : (2, n) of `modal_scale`, of the absolute tolerance.  tolerance : relative [1].
    """
    n, out = N.squared.size, []
    jumps = N.time[:-1][np.diff(N.time) == 0]
    bounds = [times[0], *np.unique(jumps[(jumps > times[0]) & (jumps < times[-1])]), times[-1]]
    y = state.ravel()
    for low, high in pairwise(bounds):
        before = np.nextafter(high, low)  # what holds up to the jump, not behind it

        def slope(t: float, flat: Array, last: float = before) -> Array:
            """Rates (2n,) of the flat modal state (2n,) at time t [s]."""
            return np.concatenate([flat[n:], acceleration(N, instant_terms(N, t, min(t, last)), flat[:n], flat[n:])])

        wanted = times[(times > low) & (times <= high)]
        moments = wanted if wanted.size and wanted[-1] == high else np.append(wanted, high)
        with np.errstate(over="ignore", invalid="ignore"):
            found = solve_ivp(
                slope,
                (low, high),
                y,
                method=_SCIPY_NAME[method],
                t_eval=moments,
                rtol=tolerance,
                atol=tolerance * _ABSOLUTE * scale.ravel(),
            )
        block = np.full((moments.size, 2 * n), np.nan)
        block[: found.y.shape[1]] = found.y.T
        y = block[-1]
        out.append(block[: wanted.size])
        if not np.isfinite(y).all():
            out.append(np.full((times.size - 1 - sum(map(len, out)), 2 * n), np.nan))
            break
    return np.concatenate(out).reshape(-1, 2, n)
