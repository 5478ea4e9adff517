"""Closed teeth: speeds at which a linear response is the solution, every flank pressed all the time or never.

Mostly all loaded flanks are pressed and no far one.  Where the mean load leaves some open for good, as a slide of a
herringbone sun does, the motion is linear without these.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...questions.response.response import Response, Truncation, respond
from ...system.system import Array
from .corrector import linear_start
from .problem import Problem, dynamic_size, evaluate, prolonged
from .refinement import Refinement, Solution, harmonics_for, solution

__all__ = ["NEAR", "REACH", "Scan", "scan_closed_teeth"]

# Relative residual of the linear response, as of the linear sweep, and the largest that is no failure.
_LINEAR, _ACCEPTED = 1e-6, 1e-4
# Part of the lowest speed down to which a branch set may begin, and branches may turn back.
REACH = 0.4
# Speeds looked at besides those asked for, at most, in steps of at least this damping ratio.
_MOST, _LEAST_RATIO = 600, 1e-4
# Part of the dynamic size by which a motion with varying tangents may be away from the linear one, or a branch from a
# motion of closed teeth: on a fold of it, the two are as far apart as they are large.
NEAR = 0.3
# Times flanks are opened and closed until those that touch in the mean are those that press; least harmonics then.
_ROUNDS, _LEAST = 8, 16


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scan:
    """Linear responses over speed.

    speeds : (Q,) relative, rising.  asked : (Q,) place among the speeds asked for, -1 of one between.
    solutions : (Q,) in which no flank changes its contact, None where one does.
    harmonics : (Q,) that the linear response needs.
    """

    speeds: Array
    asked: NDArray[np.int64]
    solutions: list[Solution | None]
    harmonics: NDArray[np.int64]


def scan_closed_teeth(refinement: Refinement, speeds: Array) -> Scan:
    """The linear response at distinct relative speeds (P,) and at enough between them to see every resonance.

    Where contact changes at the lowest one, speeds below it down to the first with closed teeth come along: a branch
    needs a beginning.
    """
    low = float(speeds.min())
    between = np.setdiff1d(_between(refinement.ready, low, float(speeds.max())), speeds)
    found = _looked(refinement, np.union1d(speeds, between))
    if found.solutions[0] is None:
        below = _looked(refinement, _between(refinement.ready, REACH * low, low))
        last = next((i for i in reversed(range(below.speeds.size)) if below.solutions[i] is not None), None)
        found = found if last is None else _joined(below, last, found)
    places = np.searchsorted(found.speeds, speeds)
    asked = np.full(found.speeds.size, -1, np.int64)
    asked[places] = np.arange(speeds.size)
    return replace(found, asked=asked)


def _joined(below: Scan, first: int, above: Scan) -> Scan:
    """Two scans as one, the lower one from a place on."""
    return Scan(
        speeds=np.concatenate([below.speeds[first:], above.speeds]),
        asked=np.concatenate([below.asked[first:], above.asked]),
        solutions=[*below.solutions[first:], *above.solutions],
        harmonics=np.concatenate([below.harmonics[first:], above.harmonics]),
    )


def _looked(refinement: Refinement, speeds: Array) -> Scan:
    """The linear response at rising relative speeds (Q,), none of them asked for."""
    found = list[Solution | None]([None] * speeds.size)
    harmonics = np.zeros(speeds.size, np.int64)
    if speeds.size:
        for block in respond(refinement.ready, speeds, tolerance=_LINEAR, shaft_orders=False):
            for at, place in enumerate(block.index.tolist()):
                harmonics[place] = block.harmonics
                if block.residual[at] <= _ACCEPTED:
                    speed, residual = float(block.speed[at]), float(block.residual[at])
                    found[place] = _closed(refinement, block.mesh.y[at], speed, block.truncation, residual)
        if len(refinement.ready.lines.tones) == 1:
            _without_open_flanks(refinement, speeds, found, harmonics)
    return Scan(speeds=speeds, asked=np.full(speeds.size, -1), solutions=found, harmonics=harmonics)


def _between(ready: Response, low: float, high: float) -> Array:
    """Relative speeds (Q,) between two others, in steps of the smallest damping ratio."""
    elastic = ~ready.modal.rigid
    ratio = ready.modal.damping[elastic] / (2 * np.sqrt(ready.modal.squared[elastic]))
    least = max(float(np.min(ratio, initial=1.0)), _LEAST_RATIO)
    count = min(int(np.log(high / low) / least), _MOST) if high > low else 0
    return np.geomspace(low, high, count + 2)[1:-1] if count else np.zeros(0)


def _closed(refinement: Refinement, y: Array, speed: float, kept: Truncation, residual: float) -> Solution | None:
    """The linear motion (2, J, n) as a solution, None where a tooth of it parts or strikes the other flank."""
    harmonics = max(kept[:-1])
    given = refinement.lattice(kept[:-1], kept[-1], 1, refinement.samples(harmonics))
    state = evaluate(given, y, speed)
    if not given.rows.parametric:
        return _closed_by_law(refinement, given, y, speed, harmonics)
    if not np.all(state.touching == (given.rows.sense > 0)):
        return None
    residual = max(residual, state.norm / dynamic_size(y))
    return Solution(given=given, harmonics=harmonics, state=state, residual=residual)


def _closed_by_law(refinement: Refinement, given: Problem, y: Array, speed: float, harmonics: int) -> Solution | None:
    """The motion that Newton's method reaches from the linear one (2, J, n), teeth closed and tangents as they vary.

    None where a tooth parts, and where the motion is no longer near the linear one: several may exist there, and the
    branch from the speeds before leads to them.
    """
    H = harmonics_for(max(_LEAST, harmonics))
    finer = refinement.problem(H)
    at = solution(refinement, prolonged(given, finer, y), speed, given=finer, harmonics=H)
    if at is None or not np.all(at.state.touching == (at.given.rows.sense > 0)):
        return None
    linear = prolonged(given, at.given, y)
    moved = float(np.linalg.norm((at.state.y - linear)[:, 1:]))
    return at if moved <= NEAR * dynamic_size(linear) else None


def _without_open_flanks(
    refinement: Refinement, speeds: Array, found: list[Solution | None], harmonics: NDArray[np.int64]
) -> None:
    """Enter linear solutions at speeds (Q,) in which flanks left open by the mean load never touch."""
    missing = [place for place, at in enumerate(found) if at is None]
    if not missing:
        return
    pressed = _pressed(refinement, float(speeds[missing[0]]), int(harmonics[missing[0]]))
    if pressed is None:
        return
    for place in missing:
        H = harmonics_for(max(_LEAST, int(harmonics[place])))
        given, speed = refinement.problem(H), float(speeds[place])
        start = linear_start(given, speed, pressed)
        if np.all(evaluate(given, start, speed).touching == pressed):
            at = solution(refinement, start, speed, given=given, harmonics=H)
            found[place] = at if at is not None and np.all(at.state.touching == pressed) else None


def _pressed(refinement: Refinement, speed: float, harmonics: int) -> NDArray[np.bool_] | None:
    """Flanks (R,) that press in the mean of a linear motion with these alone, None where they are those loaded."""
    given = refinement.problem(harmonics_for(max(_LEAST, harmonics)))
    loaded = pressed = given.rows.sense > 0
    for _ in range(_ROUNDS):
        motion, F = linear_start(given, speed, pressed)[0, 0], given.rows.count
        mean = (given.rows.gaps @ motion - given.error[0])[:F]
        if np.array_equal(mean > 0, pressed):
            return None if np.array_equal(pressed, loaded) else pressed
        pressed = mean > 0
    return None
