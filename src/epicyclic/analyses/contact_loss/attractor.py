"""Where a start ends at one speed: integration in time, and the periodic motion it settles on, if it does."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...system.system import Array, System
from ..transient.motion import motion
from ..transient.outputs import flank_force
from ..transient.program import constant
from ..transient.rk4 import integrate, steps_for
from .corrector import dynamic_size
from .measures import Measures, of_record
from .refinement import Levels, carried
from .solution import Solution, judged, solution

__all__ = ["Record", "instant", "settled"]

# Mesh cycles run before each look at where the motion is, and the most of them.
_CYCLES, _LOOKS = 60, 6
# A motion found by the balance is the one that was run to when it is this near, per dynamic size.
_NEAR = 0.1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Record:
    """A motion that settled on none of one or two cycles.

    speed : relative.  last : (2, n) q and q' at its end, a whole number of cycles after the start.
    measures : of its last cycles.
    """

    speed: float
    last: Array
    measures: Measures


def instant(at: Solution) -> Array:
    """(2, n) q and q' where a cycle begins."""
    y, w = at.state.y, at.state.speed * at.given.omega
    both = np.stack([y[0].sum(axis=0), -(w @ y[1])])
    result: Array = both @ at.given.modal.shapes.T
    return result


def settled(levels: Levels, start: Array, speed: float, *, harmonics: int) -> Solution | Record:
    """The stable motion of one or two cycles that a start (2, n) ends on, or a record of what it does instead.

    A start on an unstable motion leaves it only as fast as rounding grows: give it a push first.
    """
    system = _alone(levels, speed)
    moving = motion(system, program=constant(speed))
    cycle = 1.0 / (speed * float(levels.ready.lines.tone))
    samples = 4 * harmonics
    steps = -(-steps_for(moving, cycle) // samples) * samples
    state, record = start, np.zeros((0, 2, len(start[0])))
    for _ in range(_LOOKS):
        record = integrate(moving, state, stop=_CYCLES * cycle, steps=_CYCLES * steps, keep=steps // samples)
        if not np.isfinite(record).all():
            break
        state = record[-1]
        for cycles in (1, 2):
            part = cycles * samples
            y = _without_drift(levels, record[-1 - 2 * part :, 0])
            if _repeats(y):
                found = _periodic(levels, y[part:], speed, cycles, harmonics)
                if found is not None:
                    return found
    times = cycle * np.arange(len(record)) / samples
    force = flank_force(moving, times, record).T
    return Record(speed=speed, last=state, measures=of_record(system, force, record[:, 0]))


def _without_drift(levels: Levels, q: Array) -> Array:
    """Coordinates y (N, n) of a record q (N + 1, n); what turns freely and drifts comes back to where it began."""
    modal = levels.ready.modal
    y = q @ np.linalg.inv(modal.shapes).T
    drift = np.where(modal.rigid, y[-1] - y[0], 0.0)
    result: Array = (y - np.outer(np.linspace(0, 1, len(y)), drift))[:-1]
    return result


def _repeats(y: Array) -> bool:
    """Whether the second half of a record (N, n) is nearly the first."""
    one, two = np.split(y, 2)
    return bool(np.linalg.norm(one - two) < _NEAR * np.linalg.norm(two - two.mean(axis=0)))


def _alone(levels: Levels, speed: float) -> System:
    """The system with mesh orders only, and a frame that turns as the balance has it."""
    ready = levels.ready
    system = replace(ready.system, lines=tuple(line for _, line in ready.lines.mesh))
    if ready.frame_speed == "kinematic":
        return system
    return replace(system, G=system.G / speed, Kg=system.Kg / speed**2, Cskew=system.Cskew / speed)


def _periodic(levels: Levels, record: Array, speed: float, cycles: int, harmonics: int) -> Solution | None:
    """The stable solution next to the last cycles (N, n) of a motion, None where there is none."""
    given = levels.problem(harmonics, cycles=cycles)
    amplitude = 2 * np.fft.rfft(record, axis=0)[: len(given.omega)] / len(record)
    amplitude[0] /= 2
    y = np.stack([amplitude.real, amplitude.imag])
    y[1, 0] = 0.0
    y[:, 0, given.modal.rigid] = 0.0
    found = solution(levels, y, speed, given=given, harmonics=harmonics, kind="period 2" if cycles == 2 else "periodic")
    if found is None:
        return None
    reached = carried(found.given, given, found.state.y)
    if np.linalg.norm(reached - y) > _NEAR * dynamic_size(y):
        return None
    found = judged(levels, found)
    return found if found.stable else None
