"""Shaft orders on top of what a sweep has met: the torus that begins at a motion of mesh orders."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .attractor import Record
from .corrector import dynamic_size
from .measures import Measures
from .outcome import outcome, strokes
from .problem import State
from .solution import Solution
from .superposed import Superposed, exact, superposed
from .torus import Torus, TorusPoint, embedded, respond_torus

__all__ = ["Joined", "ShaftOrders"]

# Part of the dynamic size that the torus's own mesh orders may be away from the motion met; farther is another branch.
_NEAR = 0.02
# Errors of superposed lines below this are none.
_NOTHING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Joined:
    """What became of one motion with shaft orders.

    measures : None where it failed.  status : ``ok``, ``coarse``, or why.  dropped : as of `TorusPoint`, its size.
    off : largest error of a line that is superposed on flanks that part, relative to its own force (RMS).
    harmonics : of the mesh tones.  residual : of the rows kept.
    """

    measures: Measures | None
    status: str
    dropped: float = np.nan
    off: float = 0.0
    harmonics: int = 0
    residual: float = np.nan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShaftOrders:
    """Puts shaft orders on motions of mesh orders, each once."""

    given: Torus
    made: dict[State, Joined] = field(default_factory=dict)

    def joined(self, at: Solution | Record) -> Joined:
        """The motion with shaft orders next to one of mesh orders."""
        if isinstance(at, Record):
            return Joined(measures=None, status="shaft orders are not known of a motion that is integrated")
        if at.state not in self.made:
            self.made[at.state] = self._joined(at)
        return self.made[at.state]

    def _joined(self, at: Solution) -> Joined:
        if at.given.cycles > 1:
            return Joined(measures=None, status="shaft orders are not known of a motion of two mesh cycles")
        if at.verdict is not None and not at.stable:
            return Joined(measures=None, status="shaft orders are not known of a motion that is not stable")
        flat = respond_torus(self.given.flat, at.state.speed, start=(at.given.grid.points, at.state.y))
        if not flat.converged or _away(at, flat) > _NEAR:
            return Joined(measures=None, status="the torus left the motion of mesh orders")
        lines = superposed(self.given.flat, flat)
        if exact(self.given, flat, lines):
            return _told(self.given.flat, flat, lines)
        point = respond_torus(self.given, at.state.speed, start=(flat.problem.grid.points, flat.state.y))
        if not point.converged:
            return Joined(measures=None, status=f"the torus of shaft orders: {point.status}", residual=point.residual)
        return _told(self.given, point, superposed(self.given, point))


def _away(at: Solution, flat: TorusPoint) -> float:
    """Distance of the torus's mesh orders from those of a motion, per its dynamic size."""
    y = embedded(flat.problem, at.given.grid.points, at.state.y)
    return float(np.linalg.norm(flat.state.y - y)) / dynamic_size(at.state.y)


def _told(given: Torus, point: TorusPoint, lines: list[Superposed]) -> Joined:
    found = outcome(given, point, lines)
    error = max((line.error for line in lines), default=0.0)
    return Joined(
        measures=Measures(
            rms=found.rms,
            highest=found.peak,
            lowest=found.minimum,
            open=np.maximum(found.open - found.far, 0.0),
            amplitude=strokes(given, point, lines),
        ),
        status=point.status,
        dropped=float(np.linalg.norm(point.dropped)),
        off=error if error > _NOTHING else 0.0,
        harmonics=max(point.size.harmonics),
        residual=point.residual,
    )
