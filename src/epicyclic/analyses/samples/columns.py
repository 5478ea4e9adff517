"""Unit excitations solved side by side at one speed: the columns of a linear map."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...errors import ModelError
from ...system.system import ComplexArray
from ..steady.balance import Batch, HarmonicSolution, solve
from ..steady.response import Block, Response, Truncation, initial_truncation, largest_truncation, truncation_increment

__all__ = ["UnitLoads", "checked_speed", "column_block", "solve_columns", "solve_refined"]

# Doubles solved for at once, as in a sweep.
_BATCH = 60_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UnitLoads:
    """Excitations of one kind, mesh orders or one shaft group.

    error : (m, P, J) [m].  force : (P, J, n) [N].  shaft : number of the group, None of mesh orders.
    """

    error: ComplexArray
    force: ComplexArray
    shaft: int | None


def checked_speed(relative_speed: float) -> float:
    """A speed above zero.

    Raises
    ------
    ModelError : it is not.
    """
    if not (np.isfinite(relative_speed) and relative_speed > 0):
        raise ModelError("out of range", path="relative_speed", given=relative_speed, allowed="a number above zero")
    return float(relative_speed)


def solve_columns(
    ready: Response, truncation: Truncation, speed: float, unit: UnitLoads, *, tolerance: float
) -> HarmonicSolution:
    """Every column (P,) of a unit; residuals relative to the dynamic part of each."""
    shifted = unit.shaft is not None
    at, truncated_frequency = (
        values[unit.shaft or 0] * speed for values in ready.frequency(truncation, shifted=shifted)
    )
    frame = speed if ready.frame_speed == "kinematic" else 1.0
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
                    frame=np.full(part.size, frame),
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
    """Columns as the points of a block, for what reads blocks."""
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
    """What `find` solves with so many rows that each column drops little enough, as in a sweep."""
    start, limit = initial_truncation(ready), largest_truncation(ready, np.array([speed]))[0]
    truncation: Truncation = tuple(start.tolist())
    while True:
        solved = find(truncation)
        truncation_residual = np.concatenate([each.truncation_residual for each in solved])
        more = truncation_increment(
            truncation_residual, truncation, np.tile(limit, (len(truncation_residual), 1)), tolerance
        ).max(axis=0)
        if not more.any():
            return truncation, solved
        truncation = tuple((np.array(truncation) + more).tolist())
