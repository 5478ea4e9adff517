"""Classical Runge-Kutta steps of fixed length: compiled where numba is installed, else the same steps in NumPy."""

from __future__ import annotations

import math
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np

from ...errors import ModelError
from ...system.system import Array
from .motion import Motion, Numbers, from_modal, highest_rate, to_modal
from .right_hand_side import acceleration, drive

__all__ = ["compiled_available", "integrate", "march", "steps_for"]

# Step times highest rate: the phase of the highest mode is then right to 0.35^4 / 120 = 1.3e-4, of one at half of that
# to 8e-6; stable up to 2.7.
_REACH = 0.35


def compiled_available() -> bool:
    """Whether numba is installed."""
    return find_spec("numba") is not None


def steps_for(moving: Motion, interval: float) -> int:
    """Steps that an interval [s] needs."""
    return max(1, math.ceil(interval * highest_rate(moving) / _REACH))


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
    found = march(
        moving.numbers, begin, first=0, begin=start, step=(stop - start) / count, keep=keep, samples=count // keep
    )
    return from_modal(moving, np.concatenate([begin[None], found]))


def march(N: Numbers, state: Array, *, first: int, begin: float, step: float, keep: int, samples: int) -> Array:
    """Modal states (samples, 2, n) after every `keep` steps from the one at step `first`.

    The time of a step is counted from `begin`, so that where a run is cut does not change it.
    """
    run: Callable[..., Array] = _numpy
    if compiled_available():
        from .compiled import advance as run
    return run(N, state, first=first, begin=begin, step=step, keep=keep, samples=samples)


def _numpy(N: Numbers, state: Array, *, first: int, begin: float, step: float, keep: int, samples: int) -> Array:
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
    """One step."""
    h = end - t
    at = drive(N, t, middle)
    a1 = acceleration(N, at, y, v)
    at = drive(N, middle, middle)
    v2 = v + h / 2 * a1
    a2 = acceleration(N, at, y + h / 2 * v, v2)
    v3 = v + h / 2 * a2
    a3 = acceleration(N, at, y + h / 2 * v2, v3)
    at = drive(N, end, middle)
    v4 = v + h * a3
    a4 = acceleration(N, at, y + h * v3, v4)
    return y + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
