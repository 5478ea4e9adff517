"""Where the linear response is the solution: every loaded flank pressed all the time, no far one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from ..harmonic.response import Kept, Response, respond
from .balance import State, evaluate
from .levels import Levels
from .newton import dynamic_size
from .solution import Solution

__all__ = ["Scan", "closed", "scanned"]

# Relative residual of the linear response, as of the linear sweep, and the largest that is no failure.
_LINEAR, _ACCEPTED = 1e-6, 1e-4
# Speeds looked at besides those asked for, at most.
_MOST = 600


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scan:
    """speeds : (Q,) rising.  asked : (Q,) place among the speeds asked for, -1 of one between.

    solutions : with all teeth closed, None where they part.  harmonics : (Q,) that the linear response needs.
    """

    speeds: Array
    asked: NDArray[np.int64]
    solutions: list[Solution | None]
    harmonics: NDArray[np.int64]


def scanned(levels: Levels, speeds: Array) -> Scan:
    """The linear response at distinct speeds (P,) and at enough between them to see every resonance."""
    between = np.setdiff1d(_between(levels.ready, speeds.min(), speeds.max()), speeds)
    every = np.concatenate([speeds, between])
    order = np.argsort(every)
    asked = np.where(order < speeds.size, order, -1)
    found = list[Solution | None]([None] * every.size)
    harmonics = np.zeros(every.size, np.int64)
    rank = np.argsort(order)
    for block in respond(levels.ready, every, tolerance=_LINEAR, shaft_orders=False):
        for at, place in enumerate(rank[block.index].tolist()):
            harmonics[place] = block.harmonics
            if block.residual[at] <= _ACCEPTED:
                speed, residual = float(block.speed[at]), float(block.residual[at])
                found[place] = _closed(levels, block.mesh.y[at], speed, block.kept, residual)
    return Scan(speeds=every[order], asked=asked, solutions=found, harmonics=harmonics)


def _between(ready: Response, low: float, high: float) -> Array:
    """Speeds in steps of the smallest damping ratio."""
    elastic = ~ready.modal.rigid
    ratio = ready.modal.damping[elastic] / (2 * np.sqrt(ready.modal.squared[elastic]))
    least = max(float(np.min(ratio, initial=1.0)), 1e-4)
    count = min(int(np.log(high / low) / least), _MOST) if high > low else 0
    return np.geomspace(low, high, count + 2)[1:-1] if count else np.zeros(0)


def _closed(levels: Levels, y: Array, speed: float, kept: Kept, residual: float) -> Solution | None:
    """The linear solution if no tooth of it parts or strikes the other flank."""
    harmonics = max(kept[:-1])
    given = levels.lattice(kept[:-1], kept[-1], 1, levels.samples(harmonics))
    state = evaluate(given, y, speed)
    if not closed(given.flanks.sense, state):
        return None
    residual = max(residual, state.norm / dynamic_size(y))
    return Solution(given=given, harmonics=harmonics, state=state, residual=residual)


def closed(sense: Array, state: State) -> bool:
    """Whether every loaded flank touches all the time and no far one ever; sense : (R,) as of `Flanks`."""
    return bool(np.all(state.touching == (sense > 0)))
