"""What a slow run-up and a slow coast-down meet: one motion after another, each begun where the last one was.

A motion goes on along its branch while that is stable.  Where the branch turns back or loses its stability the next
motion is what follows from how it was left: another branch of the balance, found and judged, or what integration in
time from there settles on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...system.system import Array
from .branch_set import Crossing, Route
from .branch_switching import Record, broken_symmetry, instant, settled, two_cycles
from .refinement import Levels, Solution, apart, distance, judged, solution

__all__ = ['Met', 'Unstable', 'walk']

Unstable = Literal["replace", "tell", "ignore"]
"""What becomes of a motion that is not stable: another takes its place, it is said, or stability is not asked for."""

# A push along every coordinate, per its own size, that lets an unstable motion go: one that grows 1 % a cycle has
# done so within the cycles run.
_PUSH = 0.05
# Harmonics of what is settled on from a motion that is not periodic.
_HARMONICS = 16


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Met:
    """What is met at one speed.

    motion : None where nothing was found.  run : part of the way it lies on, or stands in for; None apart from it.
    left : how the periodic motion of the branch is left there, empty where it is stable or there is none.
    jumped : whether the branch of the speed before had ended.
    """

    motion: Solution | Record | None
    run: int | None
    left: str = ""
    jumped: bool = False


def walk(levels: Levels, way: Route, *, upward: bool, unstable: Unstable = "replace") -> Iterator[tuple[int, Met]]:
    """The speeds asked for in turn, rising or falling, and what is met at each; `way` : its speeds rise."""
    rising = range(len(way.crossings))
    met = Met(motion=None, run=None)
    for place in rising if upward else reversed(rising):
        speed, choices = float(way.speeds[place]), way.crossings[place]
        met = _next(levels, speed, met, choices if upward else choices[::-1], unstable)
        yield place, met


def _next(levels: Levels, speed: float, before: Met, choices: list[Crossing], unstable: Unstable) -> Met:
    """What follows at a speed after what was met before."""
    last = before.motion
    if last is None:
        return _along(levels, speed, None, choices[0], unstable) if choices else Met(motion=None, run=None)
    mine = [each for each in choices if each.run == before.run]
    if mine:
        return _along(levels, speed, last, mine[0], unstable)
    if unstable != "replace" or len(levels.ready.lines.tones) > 1:
        return _nearest(levels, last, choices, unstable)
    return _apart_from_way(levels, speed, before, last, choices)


def _along(levels: Levels, speed: float, last: Solution | Record | None, at: Crossing, unstable: Unstable) -> Met:
    """The branch goes on: its motion where it is stable, else what takes its place."""
    here = _said(levels, at.solution, unstable)
    left = here.verdict.kind if here.verdict else ""
    if unstable != "replace":
        return Met(motion=here, run=at.run, left=left)
    kept = _kept(levels, speed, last, here)
    if kept is not None:
        return Met(motion=kept, run=at.run, left=left)
    if here.verdict is None or here.stable:
        return Met(motion=here, run=at.run, left=left)
    other: Solution | Record | None = next(_instead(levels, here), None)
    if other is None:
        start = last.last if isinstance(last, Record) else instant(here)
        other = settled(levels, _pushed(start), speed, harmonics=here.harmonics)
        if isinstance(other, Solution) and other.kind == "periodic" and left == "symmetry breaking":
            other = replace(other, kind="symmetry broken")
    return Met(motion=other, run=at.run, left=left)


def _kept(levels: Levels, speed: float, last: Solution | Record | None, here: Solution) -> Solution | None:
    """The motion that had taken the branch's place, gone on to this speed, while it is one of its own and stable."""
    if not isinstance(last, Solution) or last.kind == "periodic":
        return None
    found = _continued(levels, speed, last)
    return found if found is not None and apart(found, here) else None


def _continued(levels: Levels, speed: float, last: Solution) -> Solution | None:
    """The stable motion that Newton's method reaches at a speed from the one before."""
    found = solution(levels, last.state.y, speed, given=last.given, harmonics=last.harmonics, kind=last.kind)
    found = None if found is None else judged(levels, found)
    return found if found is not None and found.stable else None


def _instead(levels: Levels, here: Solution) -> Iterator[Solution]:
    """Stable motions of the balance that take the place of an unstable one."""
    kind = here.verdict.kind if here.verdict else ""
    search: dict[str, Callable[[Levels, Solution], Iterator[Solution]]] = {
        "symmetry breaking": broken_symmetry,
        "period doubling": two_cycles,
    }
    if kind in search:
        yield from search[kind](levels, here)


def _apart_from_way(levels: Levels, speed: float, before: Met, last: Solution | Record, choices: list[Crossing]) -> Met:
    """The branch has ended before this speed, or was left for a motion of its own: where a start from there goes."""
    free, found = before.run is None, None
    if free and isinstance(last, Solution):
        found = _continued(levels, speed, last)
    if found is not None:
        return _on_way(levels, found, choices, jumped=False)
    start = last.last if isinstance(last, Record) else instant(last)
    harmonics = _HARMONICS if isinstance(last, Record) else last.harmonics
    reached = settled(levels, start, speed, harmonics=harmonics)
    return _on_way(levels, reached, choices, jumped=True)


def _on_way(levels: Levels, found: Solution | Record, choices: list[Crossing], *, jumped: bool) -> Met:
    """The motion found, on the part of the way that holds it."""
    if isinstance(found, Solution):
        for each in choices:
            if not apart(each.solution, found):
                return Met(motion=judged(levels, each.solution), run=each.run, jumped=jumped)
    return Met(motion=found, run=None, jumped=jumped)


def _nearest(levels: Levels, last: Solution | Record, choices: list[Crossing], unstable: Unstable) -> Met:
    """The solution of the way most like the last one, of stable ones if there are: all that nothing is run for."""
    if not choices:
        return Met(motion=None, run=None)
    said = [replace(each, solution=_said(levels, each.solution, unstable)) for each in choices]
    best = next((each for each in said if each.solution.stable), said[0])
    if isinstance(last, Solution):
        best = min(
            said, key=lambda each: (best.solution.stable and not each.solution.stable, distance(each.solution, last))
        )
    found = best.solution
    return Met(motion=found, run=best.run, left=found.verdict.kind if found.verdict else "", jumped=True)


def _said(levels: Levels, at: Solution, unstable: Unstable) -> Solution:
    return at if unstable == "ignore" else judged(levels, at)


def _pushed(start: Array) -> Array:
    """A start a little off."""
    push = np.random.default_rng(0).standard_normal(start.shape)
    pushed: Array = start * (1 + _PUSH * push)
    return pushed
