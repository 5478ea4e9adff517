"""Finalists of a coarse search, solved again with phases and slices that hold within a tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ..contact_resolution import Resolution, resolution
from .objectives import ContactSettings, HelixContact, ReliefProblem, with_resolution
from .search import SearchResult, non_dominated
from .variables import FlankSettings, settings_of

__all__ = ["Finalists", "verified"]

Array = NDArray[np.float64]

# Best candidates of a search with one objective that are solved again, each at the cost of a coarse generation.
_FINALISTS = 4
# Most times that phases and slices are chosen anew for a new answer; a third one has not been seen.
_ROUNDS = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Finalists:
    """Solutions of a search as finally solved.

    problem : with the phases and slices of this answer.  resolution : these, and the error they leave.
    candidates : (k, v) in the unit cube, the one answer or the Pareto set.  objectives : (k, o).
    answer : index of the answer.
    """

    problem: ReliefProblem
    resolution: Resolution
    candidates: Array
    objectives: Array
    answer: int

    @property
    def settings(self) -> dict[str, dict[str, float | str]]:
        """Flank settings of the answer."""
        return settings_of(self.problem.variables, self.problem.fixed, self.candidates[self.answer])


def verified(
    problem: ReliefProblem,
    result: SearchResult,
    settings: ContactSettings,
    *,
    tolerance: float,
    pick: int | None,
    drawn: Array | None,
) -> Finalists:
    """Best candidates of a search, solved with phases and slices that hold for the answer among them.

    Parameters
    ----------
    drawn : (v,) candidate of the flanks as drawn, which the answer has to beat; None where the bounds exclude it.
    settings : of the contact; given phases and slices are kept.  tolerance : as of `contact` [1].
    pick : index of the solution that is the answer; None: the nearest to the best of each objective.

    Raises
    ------
    ModelError : no such solution.
    """
    if _given(problem, settings):
        kept = result.best
        answer = _answer(result.objectives[kept], pick)
        return Finalists(
            problem=problem,
            resolution=_resolution(problem, result.candidates[kept[answer]], settings, tolerance),
            candidates=result.candidates[kept],
            objectives=result.objectives[kept],
            answer=answer,
        )
    chosen = _chosen(problem, result)
    if drawn is not None:
        same = np.flatnonzero((result.candidates == drawn).all(axis=1))[:1]
        chosen = np.unique(np.concatenate([chosen, same]))
    candidates, values = result.candidates[chosen], result.objectives[chosen]
    front = non_dominated(values)
    answer = int(front[_answer(values[front], pick)])
    best: Resolution | None = None
    for _ in range(_ROUNDS):
        needed = _resolution(problem, candidates[answer], settings, tolerance)
        if best is not None and needed.samples <= best.samples and needed.slices <= best.slices:
            break
        problem = with_resolution(problem, settings, needed)
        best = problem.resolution
        values = problem(candidates)
        front = non_dominated(values)
        if not front.size:
            raise ModelError("no candidate could be computed", path="vary", given=[v.name for v in problem.variables])
        answer = int(front[_answer(values[front], pick)])
    assert best is not None
    return Finalists(
        problem=problem,
        resolution=best,
        candidates=candidates[front],
        objectives=values[front],
        answer=int(np.flatnonzero(front == answer)[0]),
    )


def _given(problem: ReliefProblem, settings: ContactSettings) -> bool:
    """Whether phases and slices are given, or one slice is exact."""
    exact = all(helix.segments.pair.slices == 1 for helices in problem.meshes for helix in helices)
    return settings.samples is not None and (settings.slices is not None or exact)


def _chosen(problem: ReliefProblem, result: SearchResult) -> NDArray[np.int64]:
    """Evaluations (k,) to solve again: the Pareto set, or the best of one objective, equal flanks once."""
    if len(problem.objectives) > 1:
        return result.best
    order = np.argsort(result.objectives[:, 0], kind="stable")
    kept: dict[str, int] = {}
    for i in order[np.isfinite(result.objectives[order, 0])].tolist():
        kept.setdefault(repr(settings_of(problem.variables, problem.fixed, result.candidates[i])), i)
        if len(kept) == _FINALISTS:
            break
    return np.array([*kept.values()], dtype=np.int64)


def _answer(values: Array, pick: int | None) -> int:
    """Index of the answer among the objectives (k, o) of a front: the picked one, else the nearest to the ideal point.

    The distance is Euclidean, each objective scaled by its range over the Pareto set.
    """
    if pick is not None:
        if not 0 <= pick < len(values):
            raise ModelError("no such solution", path="pick", given=pick, allowed=f"0 .. {len(values) - 1}")
        return pick
    span = np.ptp(values, axis=0)
    distance = (values - values.min(axis=0)) / np.where(span > 0, span, 1.0)
    return int(np.argmin((distance**2).sum(axis=1)))


def _resolution(problem: ReliefProblem, candidate: Array, settings: ContactSettings, tolerance: float) -> Resolution:
    """The finest that any mesh needs for the flanks of a candidate (v,), with the phases of all meshes."""
    flanks = settings_of(problem.variables, problem.fixed, candidate)
    each = [_of_mesh(helices, flanks, settings, tolerance) for helices in problem.meshes]
    return replace(
        each[0],
        samples=max(one.samples for one in each),
        slices=max(one.slices for one in each),
        error=np.max([one.error for one in each], axis=0),
    )


def _of_mesh(
    helices: Sequence[HelixContact], flanks: Mapping[str, FlankSettings], settings: ContactSettings, tolerance: float
) -> Resolution:
    return resolution(
        [helix.mesh for helix in helices],
        [helix.modified_pair(flanks) for helix in helices],
        helices[0].force,
        tolerance=tolerance,
        samples=settings.samples,
        slices=settings.slices,
    )
