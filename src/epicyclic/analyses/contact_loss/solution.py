"""A periodic motion with all that is said of it: solved with enough harmonics, judged, tried again where it failed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...system.system import Array
from .corrector import Found, dynamic_size, linear_start, solve
from .floquet import Verdict, verdict
from .problem import Problem, State
from .refinement import LEVELS, Levels, carried

__all__ = ["ACCURACY", "Kind", "Solution", "apart", "distance", "judged", "rescued", "solution"]

Kind = Literal["periodic", "symmetry broken", "period 2"]

# Residual seen with twice the harmonics and samples at which there are enough of them: RMS right to about as much.
ACCURACY = 3e-4
# Parts of the varying load in turn, where neither Newton's method nor a start from closed flanks works.
_LOADS = (0.25, 0.5, 0.75, 0.9, 1.0)
# Two motions are the same within this part of their dynamic size: far above what is left of a residual.
_SAME = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """state : of `given`, with so many harmonics.  residual : with twice as many.  verdict : None where not asked for.

    kind : what sort of motion.  backward : whether its branch goes back in speed there.
    """

    given: Problem
    harmonics: int
    state: State
    residual: float
    kind: Kind = "periodic"
    verdict: Verdict | None = None
    backward: bool = False

    @property
    def stable(self) -> bool:
        """Whether it is known to be stable."""
        return self.verdict is not None and self.verdict.stable


def solution(
    levels: Levels,
    start: Array,
    speed: float,
    *,
    given: Problem,
    harmonics: int,
    fixed: bool = False,
    kind: Kind = "periodic",
    backward: bool = False,
) -> Solution | None:
    """The motion that Newton's method reaches from a start, with more harmonics until they are enough, else None.

    Parameters
    ----------
    start : (2, J, n) on the points of `given`, which has so many harmonics.  fixed : keep that number.
    """
    found = solve(given, start, speed)
    if not found.converged:
        return None
    at = Solution(
        given=given,
        harmonics=harmonics,
        state=found.state,
        residual=levels.residual(given, found.state, harmonics),
        kind=kind,
        backward=backward,
    )
    more = [] if fixed else [level for level in LEVELS if level > harmonics]
    for level in more:
        if at.residual <= ACCURACY:
            break
        finer = _raised(levels, at, level)
        if finer is None:
            break
        at = finer
    return at


def _raised(levels: Levels, at: Solution, harmonics: int) -> Solution | None:
    given = levels.problem(harmonics, cycles=at.given.cycles)
    found = solve(given, carried(at.given, given, at.state.y), at.state.speed)
    if not found.converged:
        return None
    residual = levels.residual(given, found.state, harmonics)
    return replace(at, given=given, harmonics=harmonics, state=found.state, residual=residual)


def judged(levels: Levels, at: Solution) -> Solution:
    """The same with its stability, worked out once; unchanged where it cannot be said (several mesh frequencies)."""
    if at.verdict is not None or len(levels.ready.lines.tones) > 1:
        return at
    key = at.state, at.backward
    if key not in levels.judged:
        levels.judged[key] = verdict(levels, at.given, at.harmonics, at.state, backward=at.backward)
    return replace(at, verdict=levels.judged[key])


def apart(one: Solution, other: Solution) -> bool:
    """Whether two motions of one speed differ, also after a shift by whole mesh cycles."""
    return distance(one, other) > _SAME


def distance(one: Solution, other: Solution) -> float:
    """Difference of two motions at whichever mesh cycle it is least, relative to the dynamic size of the larger one."""
    a, b = (one, other) if len(one.given.omega) >= len(other.given.omega) else (other, one)
    y = carried(b.given, a.given, b.state.y)
    orders = a.given.grid.points.sum(axis=1)
    apart_by = []
    for shift in range(a.given.cycles):
        turn = np.exp(2j * np.pi * orders * shift / a.given.cycles)[:, None]
        moved = (y[0] + 1j * y[1]) * turn - (a.state.y[0] + 1j * a.state.y[1])
        apart_by.append(float(np.linalg.norm(moved)))
    return min(apart_by) / max(dynamic_size(a.state.y), dynamic_size(y))


def rescued(levels: Levels, speed: float, *, harmonics: int) -> Found:
    """A solution from nothing: from closed flanks, then with the varying load brought up in parts."""
    given = levels.problem(harmonics)
    found = solve(given, linear_start(given, speed), speed)
    if found.converged:
        return found
    y = found.state.y
    for part in _LOADS:
        error, force = given.error.copy(), given.force.copy()
        J = len(given.omega)
        moving = np.r_[1:J, J + 1 : 2 * J]
        error[moving] *= part
        force[:, :, 1:] *= part
        mean = np.asarray(given.flanks.stiffness)
        eased = replace(given, error=error, force=force, stiffness=mean + part * (given.stiffness - mean))
        found = solve(eased, y if part > _LOADS[0] else linear_start(eased, speed), speed)
        if not found.converged:
            break
        y = found.state.y
    return found
