"""The same balance with more or fewer harmonics, samples and cycles: problems made once, motions carried over."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...system.system import Array
from ..steady.response import Response
from .corrector import dynamic_size
from .problem import Problem, State, evaluate, mesh_problem

__all__ = ["LEVELS", "Levels", "carried", "fitting"]

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
