"""What a sweep with contact loss that was stopped goes on from: solutions without their problems, and where it stood.

A problem is made anew from its size.  A sweep direction goes on from a motion that stands for all that was before: the
motion itself and the part of the branch set it lies on.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields, replace
from typing import Any

from .branch_set import BranchSet, Crossing
from .problem import Problem
from .refinement import PeriodicMotion, ProblemSize, Refinement, Solution
from .shaft_orders import MeshOrders
from .sweep_direction import Reached, Unstable


def problem_key(refinement: Refinement, value: object) -> ProblemSize | None:
    """Size of a problem of the refinement, None of anything else."""
    if not isinstance(value, Problem):
        return None
    return next((key for key, problem in refinement.problems.items() if problem is value), None)


def problem_of(refinement: Refinement, key: ProblemSize) -> Problem:
    """The problem of a size."""
    return refinement.lattice(*key)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Begin:
    """A place of a sweep direction from which it goes on.

    motion : reached there.  size : of its balance.  part : of the branch set, on which it stands.
    """

    place: int
    motion: PeriodicMotion
    size: ProblemSize
    part: int


def begin_of(refinement: Refinement, place: int, reached: Reached, unstable: Unstable) -> Begin | None:
    """Where a direction goes on after what was reached, None where that takes more than a motion and its part.

    A motion that was integrated in time, and one on no part of the branch set, follow from the speeds before.
    """
    motion, part = reached.motion, reached.part
    if not isinstance(motion, Solution) or part is None or (unstable == "replace" and not motion.stable):
        return None
    size = problem_key(refinement, motion.given)
    return None if size is None else Begin(place=place, motion=PeriodicMotion(**_known(motion)), size=size, part=part)


def _known(motion: PeriodicMotion) -> dict[str, Any]:
    """What is known of a motion, its balance left out."""
    return {field.name: getattr(motion, field.name) for field in fields(PeriodicMotion)}


def continued_branches(
    refinement: Refinement, branches: BranchSet, begin: Begin, *, upward: bool
) -> tuple[BranchSet, int]:
    """The branch set from a place on, with the motion reached there alone at it, and its first place.

    A direction begins with the motion at its first speed where that is stable or may stay: it then stands as it stood.
    """
    place = begin.place
    motion = Solution(given=problem_of(refinement, begin.size), **_known(begin.motion))
    alone = [Crossing(solution=motion, part=begin.part)]
    if upward:
        crossings, speeds = [alone, *branches.crossings[place + 1 :]], branches.speeds[place:]
    else:
        crossings, speeds = [*branches.crossings[:place], alone], branches.speeds[: place + 1]
    return replace(branches, speeds=speeds, crossings=crossings), place if upward else 0


def motion_digest(at: MeshOrders) -> str:
    """The same of equal motions, bit by bit, in few letters."""
    return hashlib.sha256(repr(at.key[:3]).encode() + at.y.tobytes()).hexdigest()
