"""Sweep direction: the motions that a slow run-up and a slow coast-down reach, each begun where the last one was.

A motion goes on along its branch while that is stable.  Where the branch turns back or loses its stability, the next
motion follows from how it was left: by branch switching, or as the attractor of integration in time.  A record of
integration goes on as long as it settles on no branch, also beside motions that are stable.  With two mesh tones no
branch is switched to: the nearest stable motion of the branch set takes its place, else the attractor.
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
    state_at_start,
    symmetry_broken_motions,
)
from .corrector import linear_start
from .refinement import Refinement, Solution, distance, distinct, solution, with_stability
from .symmetry import with_kind

if TYPE_CHECKING:
    from .branch_set import BranchSet, Crossing

__all__ = ["Reached", "Unstable", "sweep_direction", "switched"]

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
# Harmonics of the attractor of a motion that is not periodic where no branch goes on, of one mesh tone and of each of
# two.
_HARMONICS = {1: 16, 2: 8}


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
        if isinstance(reached.motion, Solution):
            reached = replace(reached, motion=with_kind(refinement, reached.motion))
        yield place, reached


def _reached_at(
    refinement: Refinement, speed: float, before: Reached, choices: list[Crossing], unstable: Unstable
) -> Reached:
    """What is reached at a speed after what was reached before; `choices` are the crossings there."""
    last = before.motion
    if unstable == "replace" and isinstance(last, IntegratedMotion):
        return _run_on(refinement, speed, before, last, choices)
    if unstable == "replace" and len(refinement.ready.lines.tones) > 1:
        return _of_two_tones(refinement, speed, before, choices)
    if last is None and not choices:
        return _begun(refinement, speed) if unstable == "replace" else Reached(motion=None, part=None)
    if last is None:
        return _on_branch(refinement, speed, None, choices[0], unstable)
    assert isinstance(last, Solution)
    mine = [each for each in choices if each.part == before.part]
    if mine:
        return _on_branch(refinement, speed, last, mine[0], unstable)
    if unstable != "replace":
        return _nearest(refinement, last, choices, unstable)
    return _off_branch(refinement, speed, before, last, choices)


def _begun(refinement: Refinement, speed: float) -> Reached:
    """The attractor of a start on the linear motion of closed teeth, where the branch set has nothing yet."""
    harmonics = _HARMONICS[len(refinement.ready.lines.tones)]
    given = refinement.problem(harmonics)
    start = state_at_start(given, linear_start(given, speed), speed)
    return Reached(motion=attractor(refinement, start, speed, harmonics=harmonics), part=None)


def _run_on(
    refinement: Refinement, speed: float, before: Reached, last: IntegratedMotion, choices: list[Crossing]
) -> Reached:
    """The attractor from the end of a record at the speed before; instability is that of the branch it stands in for.

    A slow sweep stays on its attractor: a motion of the branch set that is stable beside it is not jumped to.
    """
    mine = next((each for each in choices if each.part == before.part), None)
    here = None if mine is None else with_stability(refinement, mine.solution)
    harmonics = here.harmonics if here is not None else _HARMONICS[len(refinement.ready.lines.tones)]
    settled = abs(last.speed - speed) < _NEAR * speed
    found = attractor(refinement, last.last, speed, harmonics=harmonics, settled=settled)
    if here is not None and here.stable and _linear(found, here):
        # the record has not yet come to the one stable motion of a linear system
        found = here
    reached = _on_branch_set(refinement, found, choices, jumped=mine is None and before.part is not None)
    if here is None or reached.part is not None:
        return reached
    instability = here.stability.kind if here.stability else ""
    return replace(reached, motion=_named(found, instability), part=before.part, instability=instability)


def _of_two_tones(refinement: Refinement, speed: float, before: Reached, choices: list[Crossing]) -> Reached:
    """What replaces an unstable motion of two mesh tones, and the end of a branch.

    The nearest stable motion of the branch set, else the attractor of a start a little off the motion at hand.
    """
    last = before.motion
    assert not isinstance(last, IntegratedMotion)
    judged = [replace(each, solution=with_stability(refinement, each.solution)) for each in choices]
    here = next((each for each in judged if last is None or each.part == before.part), None)
    if here is not None and here.solution.stable:
        return Reached(motion=here.solution, part=here.part)
    instability = here.solution.stability.kind if here is not None and here.solution.stability else ""
    jumped = here is None and last is not None
    stable = [each for each in judged if each.solution.stable]
    if stable:
        near = last or (here.solution if here is not None else None)
        best = stable[0] if near is None else min(stable, key=lambda each: distance(each.solution, near))
        return Reached(motion=best.solution, part=best.part, instability=instability, jumped=jumped)
    at = here.solution if here is not None else last
    if at is None:
        return _begun(refinement, speed)
    found = attractor(refinement, _perturbed(initial_state(at)), speed, harmonics=at.harmonics)
    return Reached(motion=found, part=None if here is None else here.part, instability=instability, jumped=jumped)


def _linear(found: Solution | IntegratedMotion, here: Solution) -> bool:
    """Whether an attractor is a record without a change of contact, by linear laws, as a motion of the branch is."""
    linear = here.state.unchanging and here.given.rows.parametric
    return linear and isinstance(found, IntegratedMotion) and found.unchanging


def _on_branch(
    refinement: Refinement, speed: float, last: Solution | None, at: Crossing, unstable: Unstable
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
        found = attractor(refinement, _perturbed(initial_state(here)), speed, harmonics=here.harmonics)
        other = _named(found, instability)
    return Reached(motion=other, part=at.part, instability=instability)


def _named(found: Solution | IntegratedMotion, instability: str) -> Solution | IntegratedMotion:
    """An attractor, named after how the motion is left that it takes the place of."""
    if isinstance(found, Solution) and found.kind == "periodic" and instability == "symmetry breaking":
        return replace(found, kind="symmetry broken")
    return found


def _beside_branch(refinement: Refinement, speed: float, last: Solution | None, here: Solution) -> Solution | None:
    """The motion that had taken the branch's place, continued to this speed while distinct and stable."""
    if last is None or last.kind == "periodic":
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
    kind = here.stability.kind if here.stability else ""
    return next(_SEARCH[kind](refinement, here), None) if kind in _SEARCH else None


def _off_branch(
    refinement: Refinement, speed: float, before: Reached, last: Solution, choices: list[Crossing]
) -> Reached:
    """The branch has ended before this speed, or was left: the attractor of a start from the last motion."""
    found = _continued(refinement, speed, last) if before.part is None else None
    if found is not None:
        return _on_branch_set(refinement, found, choices, jumped=False)
    reached = attractor(refinement, initial_state(last), speed, harmonics=last.harmonics)
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


def _nearest(refinement: Refinement, last: Solution, choices: list[Crossing], unstable: Unstable) -> Reached:
    """The solution of the branch set most like the last one, of stable ones if there are: no branch switching."""
    if not choices:
        return Reached(motion=None, part=None)
    candidates = [
        replace(each, solution=_stability_unless_ignored(refinement, each.solution, unstable)) for each in choices
    ]
    best = min(candidates, key=lambda each: (not each.solution.stable, distance(each.solution, last)))
    found = best.solution
    return Reached(
        motion=found, part=best.part, instability=found.stability.kind if found.stability else "", jumped=True
    )


def _stability_unless_ignored(refinement: Refinement, at: Solution, unstable: Unstable) -> Solution:
    """The same with its Floquet stability, unless that is ignored."""
    return at if unstable == "ignore" else with_stability(refinement, at)


def _perturbed(start: Array) -> Array:
    """A state (2, n) a little off a start, reproducibly."""
    noise = np.random.default_rng(0).standard_normal(start.shape)
    perturbed: Array = start * (1 + _PERTURBATION * noise)
    return perturbed
