"""Prescribed speed, the phase that follows from it, and levels of loads over time; piecewise linear."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...errors import ModelError
from ...system.system import Array

__all__ = ["Program", "constant", "phase_at", "program", "speed_at"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Program:
    """Lines between knots; two knots at one time are a jump.

    time : (K,) [s], never falling.  speed : (K,) s, speed per operating speed.
    phase : (K,) integral of s dt, the time at the operating speed that every exponential counts in [s].
    level : (K, C) factors of C loads [1].
    """

    time: Array
    speed: Array
    phase: Array
    level: Array

    @property
    def steady(self) -> bool:
        """Whether the speed never changes."""
        return bool(np.all(self.speed == self.speed[0]))


def constant(speed: float = 1.0, *, phase: float = 0.0) -> Program:
    """One speed for ever, no further loads."""
    return program([0.0, 1.0], [speed, speed], phase=phase)


def program(time: ArrayLike, speed: ArrayLike, level: ArrayLike | None = None, *, phase: float = 0.0) -> Program:
    """Knots of the speed s and of load levels; the last line goes on beyond the last knot.

    Parameters
    ----------
    time, speed : (K,) [s], [1].  level : (K, C); none where None.  phase : at the first knot [s].

    Raises
    ------
    ModelError : times that fall or are not finite; a speed that is negative or jumps.
    """
    t, s = np.asarray(time, dtype=float), np.asarray(speed, dtype=float)
    levels = np.zeros((t.size, 0)) if level is None else np.asarray(level, dtype=float)
    if t.size < 2 or not (np.all(np.isfinite(t)) and np.all(np.diff(t) >= 0) and t[-1] > t[-2]):
        raise ModelError("times must be finite and rise", path="time", given=_few(t), allowed="two or more")
    if not (np.all(np.isfinite(s)) and np.all(s >= 0)):
        raise ModelError("a relative speed is out of range", path="speed", given=_few(s), allowed="zero or above")
    if np.any((np.diff(t) == 0) & (np.diff(s) != 0)):
        raise ModelError("the speed cannot jump", path="speed", given=_few(s), allowed="a ramp")
    if not np.all(np.isfinite(levels)):
        raise ModelError("a load is not a finite number", path="level")
    passed = np.concatenate([[0.0], np.cumsum(np.diff(t) * (s[1:] + s[:-1]) / 2)])
    return Program(time=t, speed=s, phase=phase + passed, level=levels)


def _few(values: Array) -> Sequence[float]:
    """The first values, for error messages, (6,) at most."""
    return [float(value) for value in values[:6]]


def _segment(given: Program, time: Array) -> tuple[np.ndarray, Array, Array]:
    """Knot before each time (T,) [s], time since [s], and the rate of the speed there [1/s]."""
    at = np.clip(np.searchsorted(given.time, time, side="right") - 1, 0, given.time.size - 2)
    span = given.time[at + 1] - given.time[at]
    rise = np.where(span > 0, (given.speed[at + 1] - given.speed[at]) / np.where(span > 0, span, 1.0), 0.0)
    return at, time - given.time[at], rise


def speed_at(given: Program, time: Array) -> Array:
    """Relative speed s at times (T,) [s], (T,) [1]."""
    at, since, rise = _segment(given, time)
    speed: Array = given.speed[at] + rise * since
    return speed


def phase_at(given: Program, time: Array) -> Array:
    """Integral of s dt at times (T,) [s], (T,) [s]; exact."""
    at, since, rise = _segment(given, time)
    phase: Array = given.phase[at] + since * (given.speed[at] + rise * since / 2)
    return phase
