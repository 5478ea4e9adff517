"""One whole branch over a range of speeds, with its folds and its highest point found, not stepped over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from .continuation import Measure, PathPoint, Stepping, follow, start_of_path, step_from
from .corrector import solve
from .problem import Problem, State
from .refinement import Levels

__all__ = ["branch", "folds", "folds_of_speed", "peak_of"]

# A fold is found when ds/d(length) is below this; so many steps at most.
_FLAT, _TRIES = 1e-3, 12
# Times the interval about the highest point is halved.
_HALVED = 3
# Folds closer than this part of the speed are asked again with twice the samples (0.1 Hz at 1.3 kHz).
_CLOSE = 8e-5

Score = Callable[[State, Problem], float]
Stop = Callable[[PathPoint], bool]


def branch(
    levels: Levels,
    given: Problem,
    harmonics: int,
    start: State,
    *,
    low: float,
    high: float,
    unit: Measure,
    stepping: Stepping,
    score: Score,
    stop: Stop | None = None,
) -> list[PathPoint]:
    """Points of the branch through a solved state, going up in speed, folds and the highest score among them.

    Parameters
    ----------
    score : what has a peak that must not be missed.  stop : ends the branch at a point before it leaves [low, high].
    """
    points = []
    for point in follow(start_of_path(given, start, unit), low, high, unit=unit, stepping=stepping):
        points.append(point)
        if stop is not None and stop(point):
            break
    points = _confirmed(levels, harmonics, points, unit)
    points = _with_folds(points, unit)
    return _with_peak(points, unit, score)


def folds(points: list[PathPoint]) -> list[int]:
    """Places where the branch turns back or on: of a pair with opposite signs the one where it is flatter."""
    onward = np.array([point.onward for point in points])
    places = np.flatnonzero(np.sign(onward[1:]) != np.sign(onward[:-1]))
    return [int(i if abs(onward[i]) <= abs(onward[i + 1]) else i + 1) for i in places]


def folds_of_speed(speeds: list[float]) -> list[float]:
    """Speeds at which a rising or falling row of speeds turns round."""
    rise = np.diff(np.array(speeds))
    places = np.flatnonzero(np.sign(rise[1:]) != np.sign(rise[:-1])) + 1
    return [float(speeds[int(place)]) for place in places]


def _with_folds(points: list[PathPoint], unit: Measure) -> list[PathPoint]:
    """A point at every fold."""
    result = points[:1]
    for before, after in pairwise(points):
        if np.sign(before.onward) != np.sign(after.onward) and before.given is after.given:
            at = _fold(before, after, unit)
            result += [] if at is None else [at]
        result.append(after)
    return result


def _fold(before: PathPoint, after: PathPoint, unit: Measure) -> PathPoint | None:
    """Where ds/d(length) = 0 between two points, None where no step from the first gets there."""
    low, high, ends = 0.0, after.length - before.length, [before.onward, after.onward]
    best: PathPoint | None = None
    for count in range(_TRIES):
        size = low + (high - low) * ends[0] / (ends[0] - ends[1]) if count % 3 else (low + high) / 2
        trial = step_from(before, size, unit)
        if trial is None:
            return best
        best = trial[0]
        if abs(best.onward) < _FLAT:
            break
        if np.sign(best.onward) == np.sign(ends[0]):
            low, ends[0] = size, best.onward
        else:
            high, ends[1] = size, best.onward
    return best


def peak_of(points: list[PathPoint], score: Score) -> int:
    """Place of the highest score."""
    return int(np.argmax([score(point.state, point.given) for point in points]))


def _with_peak(points: list[PathPoint], unit: Measure, score: Score) -> list[PathPoint]:
    """More points about the highest score, halving the steps there."""
    points = list(points)
    for _ in range(_HALVED):
        top = peak_of(points, score)
        for place in (top, top - 1):
            if 0 <= place < len(points) - 1:
                half = (points[place + 1].length - points[place].length) / 2
                middle = step_from(points[place], half, unit) if half > 0 else None
                points[place + 1 : place + 1] = [] if middle is None else [middle[0]]
    return points


def _confirmed(levels: Levels, harmonics: int, points: list[PathPoint], unit: Measure) -> list[PathPoint]:
    """Pairs of folds so close that the samples may have made them, walked again with twice the samples."""
    turns = folds(points)
    for first, second in pairwise(turns):
        speeds = [points[i].state.speed for i in (first, second)]
        if abs(speeds[1] - speeds[0]) > _CLOSE * speeds[0]:
            continue
        a, b = max(first - 2, 0), min(second + 2, len(points) - 1)
        again = _again(levels, harmonics, points[a], points[b], unit)
        if again is None:
            return points
        rest = _confirmed(levels, harmonics, points[b + 1 :], unit)
        return [*points[:a], *again, *rest]
    return points


def _again(levels: Levels, harmonics: int, first: PathPoint, last: PathPoint, unit: Measure) -> list[PathPoint] | None:
    """The branch between two points with twice the samples, None where it does not get there."""
    given = levels.problem(harmonics, cycles=first.given.cycles, samples=2 * levels.samples(harmonics))
    found = solve(given, first.state.y, first.state.speed)
    if not found.converged or last.length <= first.length:
        return None
    start = replace(start_of_path(given, found.state, unit, upward=first.onward > 0), length=first.length)
    step = (last.length - first.length) / 16
    points = []
    for point in follow(
        start, 0.0, np.inf, unit=unit, stepping=Stepping(first=step, longest=4 * step, shortest=step / 256)
    ):
        points.append(point)
        if point.length > last.length:
            break
    return points if points[-1].length >= last.length else None
