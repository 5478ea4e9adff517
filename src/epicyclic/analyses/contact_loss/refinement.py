"""The same balance with more or fewer harmonics, samples and cycles: problems made once, motions carried over.

---

A periodic motion with all that is said of it: solved with enough harmonics, judged, tried again where it failed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from ...system.system import Array
from ..steady.response import Response
from .corrector import Found, dynamic_size, linear_start, solve
from .floquet import Verdict, verdict
from .problem import Problem, State, evaluate, mesh_problem

__all__ = ['ACCURACY', 'Kind', 'LEVELS', 'Levels', 'Solution', 'apart', 'carried', 'distance', 'fitting', 'judged', 'rescued', 'solution']

# Numbers of harmonics tried in turn.
LEVELS = (8, 12, 16, 24, 32, 48)

# Samples of a mesh cycle per harmonic: of one mesh frequency, and of each of two, whose grid is their product.
_SAMPLES = {1: 16, 2: 4}

_Key = tuple[tuple[int, ...], int, int, int]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Levels:
    """Problems of one System with one or two mesh frequencies.  cross : order of their combinations kept.

    judged : what has been said of states, by whoever judges them.
    """

    ready: Response
    cross: int = 10
    made: dict[_Key, Problem] = field(default_factory=dict)
    judged: dict[tuple[State, bool], Any] = field(default_factory=dict)

    def problem(self, harmonics: int, *, cycles: int = 1, samples: int = 0) -> Problem:
        """The balance with so many harmonics of each mesh frequency.

        Parameters
        ----------
        samples : of a mesh cycle, 0 the usual number.
        """
        tones = len(self.ready.lines.tones)
        return self.lattice((harmonics,) * tones, self.cross, cycles, samples or self.samples(harmonics))

    def lattice(self, harmonics: tuple[int, ...], cross: int, cycles: int, samples: int) -> Problem:
        """The balance with so many harmonics of each mesh frequency, combinations and samples."""
        key = (harmonics, cross, cycles, samples)
        if key not in self.made:
            self.made[key] = mesh_problem(self.ready, harmonics=harmonics, cross=cross, samples=samples, cycles=cycles)
        return self.made[key]

    def samples(self, harmonics: int) -> int:
        """The usual number of samples of a mesh cycle."""
        return harmonics * _SAMPLES[len(self.ready.lines.tones)]

    def residual(self, given: Problem, state: State, harmonics: int) -> float:
        """Residual of a solution seen with twice the harmonics and samples, relative to its dynamic part.

        What was dropped, and what the sampling of contacts that open and close has cost.
        """
        fine = self.problem(2 * harmonics, cycles=given.cycles)
        seen = evaluate(fine, carried(given, fine, state.y), state.speed)
        return seen.norm / dynamic_size(state.y)


def carried(given: Problem, other: Problem, y: Array) -> Array:
    """A motion (2, J, n) of one problem on the points of another, zero where there was none.

    The other period is as long, or holds the first a whole number of times.
    """
    times = other.cycles // given.cycles
    place = {tuple(point): i for i, point in enumerate(other.grid.points.tolist())}
    found = [place.get(tuple(times * order for order in point), -1) for point in given.grid.points.tolist()]
    at = np.array(found)
    result = np.zeros((2, len(other.omega), y.shape[2]))
    result[:, at[at >= 0]] = y[:, at >= 0]
    return result


def fitting(harmonics: int) -> int:
    """The least level of at least so many harmonics, the last one where none is."""
    return next((level for level in LEVELS if level >= harmonics), LEVELS[-1])


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
