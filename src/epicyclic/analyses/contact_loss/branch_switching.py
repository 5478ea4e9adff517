"""What takes the place of an unstable periodic motion: another branch, a motion of two cycles.

Which one is looked for follows from how the motion is left.  Each search is a few solutions of the same balance, and
ends with a verdict of its own: what comes back is stable.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...system.system import Array
from .corrector import solve
from .floquet import disturbance
from .problem import Problem
from .refinement import Levels, carried
from .solution import Kind, Solution, apart, judged, solution

__all__ = ["broken_symmetry", "searched", "two_cycles"]

# A small error of every pitch at the lowest orders, as a part of the dynamic gap; removed in these parts.
_PITCH, _ORDERS, _PARTS = 0.2, 2, (1.0, 0.5, 0.2, 0.05, 0.0)
# Kicks along the most unstable disturbance, per the whole size of the motion: what parts teeth is as large as the load.
_KICKS = (1.0, 2.0, 0.5, 4.0, 0.25)


def broken_symmetry(levels: Levels, at: Solution, *, seeds: int = 3) -> Iterator[Solution]:
    """Stable motions with less symmetry: a small random pitch error, both signs, taken away again by homotopy.

    Where that finds none, kicks along the growing disturbance are tried.
    """
    given, found = at.given, list[Solution]()
    for start in _without_pitch_error(given, at, seeds):
        other = _new(levels, at, start, given, found, kind="symmetry broken")
        if other is not None:
            found.append(other)
            yield other
    if found:
        return
    kick = _kick(levels, at, given)
    for size in (*_KICKS, *(-size for size in _KICKS)):
        other = _new(levels, at, at.state.y + size * kick, given, found, kind="symmetry broken")
        if other is not None:
            found.append(other)
            yield other


def _without_pitch_error(given: Problem, at: Solution, seeds: int) -> Iterator[Array]:
    """Motions that are left when a random pitch error of either sign has been taken away."""
    for seed in range(seeds):
        pitch = _pitch_error(given, at, seed)
        for sign in (1.0, -1.0):
            y, converged = at.state.y, True
            for part in _PARTS:
                trial = solve(replace(given, error=given.error + sign * part * pitch), y, at.state.speed)
                y, converged = trial.state.y, trial.converged
                if not converged:
                    break
            if converged:
                yield y


def _pitch_error(given: Problem, at: Solution, seed: int) -> Array:
    """Random amplitudes (2 J, R) at the lowest orders [m]."""
    random = np.random.default_rng(seed)
    J = len(given.omega)
    rows = np.r_[1 : 1 + _ORDERS, J + 1 : J + 1 + _ORDERS]
    gap = at.state.y.reshape(-1, at.state.y.shape[2]) @ given.flanks.gaps.T
    size = _PITCH * float(np.abs(gap[np.r_[1:J, J + 1 : 2 * J]]).max(initial=0.0))
    result = np.zeros_like(given.error)
    result[rows] = size * random.standard_normal((rows.size, given.error.shape[1]))
    return result


def two_cycles(levels: Levels, at: Solution) -> Iterator[Solution]:
    """Stable motions that repeat after two mesh cycles, from kicks at half orders along the growing disturbance."""
    given = levels.problem(at.harmonics, cycles=2 * at.given.cycles)
    y, kick, found = carried(at.given, given, at.state.y), _kick(levels, at, given), list[Solution]()
    for size in _KICKS:
        other = _new(levels, at, y + size * kick, given, found, kind="period 2")
        if other is not None:
            found.append(other)
            yield other


def _kick(levels: Levels, at: Solution, given: Problem) -> Array:
    """The growing disturbance as a motion at the lowest order of a problem, of the size of the whole motion."""
    position, rate = disturbance(levels, at.given, at.harmonics, at.state)
    kick = np.zeros((2, len(given.omega), position.size))
    kick[0, 1], kick[1, 1] = position, -rate / (at.state.speed * float(given.omega[1]))
    result: Array = kick * float(np.linalg.norm(at.state.y) / np.linalg.norm(kick))
    return result


def searched(levels: Levels, at: Solution, *, cycles: int = 1, tries: int = 20, seed: int = 0) -> list[Solution]:
    """Stable motions other than the given one reached from random kicks; isolated ones are found only so.

    Parameters
    ----------
    cycles : mesh cycles of a period, 1 or 2.  tries : number of kicks, of the size of the motion.
    """
    random, found = np.random.default_rng(seed), list[Solution]()
    given = levels.problem(at.harmonics, cycles=cycles)
    y = carried(at.given, given, at.state.y)
    size = float(np.linalg.norm(y))
    for _ in range(tries):
        kick = np.zeros_like(y)
        kick[:, : 2 * cycles + 1] = random.standard_normal(kick[:, : 2 * cycles + 1].shape)
        kick[1, 0] = 0.0
        kick *= size * random.uniform(0.3, 3.0) / float(np.linalg.norm(kick))
        other = _new(levels, at, y + kick, given, found, kind="period 2" if cycles > 1 else "periodic")
        if other is not None:
            found.append(other)
    return found


def _new(
    levels: Levels, at: Solution, start: Array, given: Problem, known: list[Solution], *, kind: Kind
) -> Solution | None:
    """What Newton's method reaches, if it is stable and none of those known."""
    other = solution(levels, start, at.state.speed, given=given, harmonics=at.harmonics, kind=kind)
    if other is None or not apart(at, other) or any(not apart(each, other) for each in known):
        return None
    other = judged(levels, other)
    return other if other.stable else None
