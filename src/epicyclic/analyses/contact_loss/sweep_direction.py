"""Sweep direction: the motions that a slow run-up and a slow coast-down reach, each begun where the last one was.

A motion goes on along its branch while that is stable.  Where the branch turns back or loses its stability, the next
motion follows from how it was left: by branch switching, or as the attractor of integration in time.  With two mesh
tones no branch is switched to: the nearest stable motion of the branch set takes its place, else the attractor.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...system.system import Array
from .branch_switching import (
    IntegratedMotion,
    attractor,
    initial_state,
    period_doubled_motions,
    symmetry_broken_motions,
)
from .problem import State
from .refinement import Refinement, Solution, distance, distinct, solution, with_stability

if TYPE_CHECKING:
    from .branch_set import BranchSet, Crossing

__all__ = ["Reached", "Unstable", "sweep_direction", "switched", "switched_ahead"]

Unstable = Literal["replace", "report", "ignore"]
"""What becomes of an unstable motion: another replaces it, it is reported, or stability is ignored."""

# Perturbation of every coordinate, per its own size, from which an unstable motion is left: one that grows 1 % a cycle
# is left within the cycles run.
_PERTURBATION = 0.05
# Change of speed, as a part of it, that leaves hardly a transient of a motion over time.
_NEAR = 0.02
# What is looked for in place of a motion, by how it is left.
_SEARCH: dict[str, Callable[[Refinement, Solution], Iterator[Solution]]] = {
    "symmetry breaking": symmetry_broken_motions,
    "period doubling": period_doubled_motions,
}
# Harmonics of the attractor of a motion that is not periodic, of one mesh tone and of each of two.
_HARMONICS, _HARMONICS_OF_TWO = 16, 8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reached:
    """What is reached at one speed.

    motion : None where nothing was found.  part : of the branch set it lies on, or stands in for, else None.
    instability : how the periodic motion of the branch is left there, empty where it is stable or there is none.
    jumped : whether the branch of the speed before had ended.
    """

    motion: Solution | IntegratedMotion | None
    part: int | None
    instability: str = ""
    jumped: bool = False


def sweep_direction(
    refinement: Refinement, branches: BranchSet, *, upward: bool, unstable: Unstable = "replace"
) -> Iterator[tuple[int, Reached]]:
    """The speeds of a branch set in turn, rising or falling, by place, and what is reached at each."""
    rising = range(len(branches.crossings))
    reached = Reached(motion=None, part=None)
    for place in rising if upward else reversed(rising):
        speed, choices = float(branches.speeds[place]), branches.crossings[place]
        reached = _reached_at(refinement, speed, reached, choices if upward else choices[::-1], unstable)
        yield place, reached


def _reached_at(
    refinement: Refinement, speed: float, before: Reached, choices: list[Crossing], unstable: Unstable
) -> Reached:
    """What is reached at a speed after what was reached before; `choices` are the crossings there."""
    last = before.motion
    if unstable == "replace" and len(refinement.ready.lines.tones) > 1:
        return _of_two_tones(refinement, speed, before, choices)
    if last is None:
        return _on_branch(refinement, speed, None, choices[0], unstable) if choices else Reached(motion=None, part=None)
    mine = [each for each in choices if each.part == before.part]
    if mine:
        return _on_branch(refinement, speed, last, mine[0], unstable)
    if unstable != "replace":
        return _nearest(refinement, last, choices, unstable)
    return _off_branch(refinement, speed, before, last, choices)


def _of_two_tones(refinement: Refinement, speed: float, before: Reached, choices: list[Crossing]) -> Reached:
    """What replaces an unstable motion of two mesh tones, and the end of a branch.

    The nearest stable motion of the branch set, else the attractor of a start from the motion at hand.
    """
    last = before.motion
    judged = [replace(each, solution=with_stability(refinement, each.solution)) for each in choices]
    here = next((each for each in judged if last is None or each.part == before.part), None)
    if here is not None and here.solution.stable:
        return Reached(motion=here.solution, part=here.part)
    instability = here.solution.stability.kind if here is not None and here.solution.stability else ""
    jumped = here is None and last is not None
    stable = [each for each in judged if each.solution.stable]
    if stable:
        near = last if isinstance(last, Solution) else (here.solution if here is not None else None)
        best = stable[0] if near is None else min(stable, key=lambda each: distance(each.solution, near))
        return Reached(motion=best.solution, part=best.part, instability=instability, jumped=jumped)
    if here is None and last is None:
        return Reached(motion=None, part=None)
    start, harmonics = _start_beside(here, last)
    found = attractor(refinement, start, speed, harmonics=harmonics, settled=_settled(last, speed))
    return Reached(motion=found, part=None if here is None else here.part, instability=instability, jumped=jumped)


def _start_beside(here: Crossing | None, last: Solution | IntegratedMotion | None) -> tuple[Array, int]:
    """A state (2, n) to integrate from, and the harmonics of the motion looked for.

    The end of the last record; else a little off the unstable motion at hand, or off the last one.
    """
    if isinstance(last, IntegratedMotion):
        return last.last, _HARMONICS_OF_TWO
    at = here.solution if here is not None else last
    assert at is not None
    return _perturbed(initial_state(at)), at.harmonics


def _on_branch(
    refinement: Refinement, speed: float, last: Solution | IntegratedMotion | None, at: Crossing, unstable: Unstable
) -> Reached:
    """The branch goes on: its motion where it is stable, else what takes its place."""
    here = _stability_unless_ignored(refinement, at.solution, unstable)
    instability = here.stability.kind if here.stability else ""
    if unstable != "replace":
        return Reached(motion=here, part=at.part, instability=instability)
    kept = _beside_branch(refinement, speed, last, here)
    if kept is not None:
        return Reached(motion=kept, part=at.part, instability=instability)
    if here.stability is None or here.stable:
        return Reached(motion=here, part=at.part, instability=instability)
    other: Solution | IntegratedMotion | None = switched(refinement, here)
    if other is None:
        start = last.last if isinstance(last, IntegratedMotion) else _perturbed(initial_state(here))
        other = attractor(refinement, start, speed, harmonics=here.harmonics, settled=_settled(last, speed))
        if isinstance(other, Solution) and other.kind == "periodic" and instability == "symmetry breaking":
            other = replace(other, kind="symmetry broken")
    return Reached(motion=other, part=at.part, instability=instability)


def _beside_branch(
    refinement: Refinement, speed: float, last: Solution | IntegratedMotion | None, here: Solution
) -> Solution | None:
    """The motion that had taken the branch's place, continued to this speed while distinct and stable."""
    if not isinstance(last, Solution) or last.kind == "periodic":
        return None
    found = _continued(refinement, speed, last)
    return found if found is not None and distinct(found, here) else None


def _continued(refinement: Refinement, speed: float, last: Solution) -> Solution | None:
    """The stable motion that Newton's method reaches at a speed from the one before."""
    found = solution(refinement, last.state.y, speed, given=last.given, harmonics=last.harmonics, kind=last.kind)
    found = None if found is None else with_stability(refinement, found)
    return found if found is not None and found.stable else None


def switched(refinement: Refinement, here: Solution) -> Solution | None:
    """The stable motion of the balance that takes the place of an unstable one, None where none is found."""
    if here.state in refinement.switched:
        return refinement.switched[here.state]
    kind = here.stability.kind if here.stability else ""
    return next(_SEARCH[kind](refinement, here), None) if kind in _SEARCH else None


def switched_ahead(refinement: Refinement, branches: BranchSet) -> list[Solution]:
    """Solutions for which both directions are sure to ask `switched`, unless a motion found before goes on.

    A direction stays on the part on which it begins as far as that goes.
    """
    found = dict[State, Solution]()
    for upward in (True, False):
        part = None
        for choices in branches.crossings if upward else branches.crossings[::-1]:
            part = (choices[0] if upward else choices[-1]).part if part is None and choices else part
            mine = [each.solution for each in (choices if upward else choices[::-1]) if each.part == part]
            if part is not None and not mine:
                break
            here = with_stability(refinement, mine[0]) if mine else None
            if here is not None and here.stability is not None and here.stability.kind in _SEARCH:
                found[here.state] = here
    return list(found.values())


def _off_branch(
    refinement: Refinement, speed: float, before: Reached, last: Solution | IntegratedMotion, choices: list[Crossing]
) -> Reached:
    """The branch has ended before this speed, or was left: the attractor of a start from the last motion."""
    free, found = before.part is None, None
    if free and isinstance(last, Solution):
        found = _continued(refinement, speed, last)
    if found is not None:
        return _on_branch_set(refinement, found, choices, jumped=False)
    start = last.last if isinstance(last, IntegratedMotion) else initial_state(last)
    harmonics = _HARMONICS if isinstance(last, IntegratedMotion) else last.harmonics
    reached = attractor(refinement, start, speed, harmonics=harmonics, settled=_settled(last, speed))
    return _on_branch_set(refinement, reached, choices, jumped=True)


def _on_branch_set(
    refinement: Refinement, found: Solution | IntegratedMotion, choices: list[Crossing], *, jumped: bool
) -> Reached:
    """The motion found, on the part of the branch set that holds it."""
    if isinstance(found, Solution):
        for each in choices:
            if not distinct(each.solution, found):
                return Reached(motion=with_stability(refinement, each.solution), part=each.part, jumped=jumped)
    return Reached(motion=found, part=None, jumped=jumped)


def _nearest(
    refinement: Refinement, last: Solution | IntegratedMotion, choices: list[Crossing], unstable: Unstable
) -> Reached:
    """The solution of the branch set most like the last one, of stable ones if there are: no branch switching."""
    if not choices:
        return Reached(motion=None, part=None)
    candidates = [
        replace(each, solution=_stability_unless_ignored(refinement, each.solution, unstable)) for each in choices
    ]
    best = next((each for each in candidates if each.solution.stable), candidates[0])
    if isinstance(last, Solution):
        best = min(
            candidates,
            key=lambda each: (best.solution.stable and not each.solution.stable, distance(each.solution, last)),
        )
    found = best.solution
    return Reached(
        motion=found, part=best.part, instability=found.stability.kind if found.stability else "", jumped=True
    )


def _stability_unless_ignored(refinement: Refinement, at: Solution, unstable: Unstable) -> Solution:
    """The same with its Floquet stability, unless that is ignored."""
    return at if unstable == "ignore" else with_stability(refinement, at)


def _settled(last: Solution | IntegratedMotion | None, speed: float) -> bool:
    """Whether the last motion is a record at a speed so near that its end is as good as on the attractor."""
    return isinstance(last, IntegratedMotion) and abs(last.speed - speed) < _NEAR * speed


def _perturbed(start: Array) -> Array:
    """A state (2, n) a little off a start, reproducibly."""
    noise = np.random.default_rng(0).standard_normal(start.shape)
    perturbed: Array = start * (1 + _PERTURBATION * noise)
    return perturbed
