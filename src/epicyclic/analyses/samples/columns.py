"""Unit excitations solved side by side at one speed: the columns of a linear map."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...system.system import ComplexArray
from ..steady.balance import Batch, HarmonicSolution, solve
from ..steady.response import Block, Response, Truncation, initial_truncation, largest_truncation, truncation_increment

__all__ = ["UnitLoads", "column_block", "solve_columns", "solve_refined"]

# Doubles solved for at once, as in a sweep.
_BATCH = 60_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UnitLoads:
    """P excitations of one kind, mesh orders or one shaft group.

    error : (m, P, J) [m].  force : (P, J, n) [N, N m].  shaft : index of the group, None of mesh orders.
    """

    error: ComplexArray
    force: ComplexArray
    shaft: int | None


def solve_columns(
    ready: Response, truncation: Truncation, speed: float, unit: UnitLoads, *, tolerance: float
) -> HarmonicSolution:
    """Harmonic solution of every column (P,) at one relative speed; residuals relative to the dynamic part of each."""
    shifted = unit.shaft is not None
    at, truncated_frequency = (
        values[unit.shaft or 0] * speed for values in ready.frequency(truncation, shifted=shifted)
    )
    P, J, n = unit.force.shape
    parts = np.array_split(np.arange(P), max(1, -(-2 * P * J * n // _BATCH)))
    with np.errstate(all="ignore"):
        solved = [
            solve(
                ready.system,
                ready.modal,
                ready.kernel(truncation, shifted=shifted),
                Batch(
                    frequency=np.tile(at, (part.size, 1)),
                    truncated_frequency=np.tile(truncated_frequency, (part.size, 1)),
                    frame=ready.frame_factor(np.full(part.size, speed)),
                    error=unit.error[:, part],
                    force=unit.force[part],
                ),
                tolerance=tolerance,
            )
            for part in parts
        ]
    return HarmonicSolution(
        y=np.concatenate([each.y for each in solved]),
        gap=np.concatenate([each.gap for each in solved], axis=1),
        frequency=np.concatenate([each.frequency for each in solved]),
        residual=np.concatenate([each.residual for each in solved]),
        truncation_residual=np.concatenate([each.truncation_residual for each in solved]),
        scale=np.concatenate([each.scale for each in solved]),
        calls=max(each.calls for each in solved),
    )


def column_block(truncation: Truncation, speed: float, solved: HarmonicSolution, *, shifted: bool) -> Block:
    """Columns as the speeds of a block, for functions that read blocks."""
    P = solved.residual.size
    return Block(
        index=np.arange(P),
        speed=np.full(P, speed),
        truncation=truncation,
        mesh=solved,
        shaft=solved if shifted else None,
        residual=solved.residual,
    )


def solve_refined(
    ready: Response, speed: float, find: Callable[[Truncation], list[HarmonicSolution]], *, tolerance: float
) -> tuple[Truncation, list[HarmonicSolution]]:
    """Solve columns by `find` with so many harmonics that the truncation of each is small enough, as in a sweep.

    Returns
    -------
    (truncation, solutions).  speed : relative.  tolerance : relative residual [1].
    """
    start, limit = initial_truncation(ready), largest_truncation(ready, np.array([speed]))[0]
    truncation: Truncation = tuple(start.tolist())
    while True:
        solved = find(truncation)
        found = np.concatenate([each.truncation_residual for each in solved])
        more = truncation_increment(found, truncation, np.tile(limit, (len(found), 1)), tolerance).max(axis=0)
        if not more.any():
            return truncation, solved
        truncation = tuple((np.array(truncation) + more).tolist())
