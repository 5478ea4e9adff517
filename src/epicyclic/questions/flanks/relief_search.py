"""Genetic search over the unit cube with a record on disk, and its finalists solved again.

One objective is minimised by a genetic algorithm, several by NSGA-II [deb2002], both those of pymoo [blank2020].  The
search follows from its seed alone, so the record holds evaluations and not the state of the algorithm.  A resumed
search is repeated from its seed with the recorded objectives, which takes no evaluation, and continues to the bits of
an uninterrupted search.

The search is on few phases and slices; its finalists are solved again with those that hold within a tolerance.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...results.files import require_writable, write_text
from ...user_input import read_text
from .contact_resolution import Resolution, resolution
from .relief_objectives import ReliefProblem, with_resolution

Array = NDArray[np.float64]

_FORMAT = 1
# 100 bytes of each of a million candidates with ten variables are 1 GB
_MAX_BYTES = 1_000_000_000
# objective of a candidate that could not be computed: worse than any that could, and finite, as pymoo needs
_PENALTY = 1e30
# Best candidates of a search with one objective that are solved again, each at the cost of a coarse generation.
_FINALISTS = 4
# Most times that phases and slices are chosen anew for a new answer; a third one has not been seen.
_ROUNDS = 3


# search ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SearchResult:
    """Evaluations of a search, in order.

    candidates : (E, v) points of the unit cube [1].  objectives : (E, o), nan where one could not be computed.
    generation : (E,) from 0.  best : indices among E of the least objective or of the Pareto set, empty where no
    candidate could be computed.  stopped : whether Ctrl-C ended the search.
    """

    candidates: Array
    objectives: Array
    generation: NDArray[np.int64]
    best: NDArray[np.int64]
    stopped: bool


def genetic_search(
    evaluate: Callable[[Array], Array],
    variables: int,
    objectives: int,
    *,
    population: int,
    generations: int,
    seed: int,
    start: Array | None = None,
    record: Path | None = None,
    problem: str = "",
    progress: Callable[[float], None] | None = None,
) -> SearchResult:
    """Minimise one objective, or find the Pareto set of several [deb2002].

    Ctrl-C ends the search with the evaluations of the completed generations.

    Parameters
    ----------
    evaluate : candidates (P, v) in the unit cube -> objectives (P, o), nan where one could not be computed.
    variables, objectives : v and o.  population, generations : P and their number.
    seed : equal seeds give equal searches.
    start : (k, v) candidates of the first generation; a Latin hypercube gives the others.
    record : file of the evaluations, written after every generation; an existing one is resumed.
    problem : fingerprint that a record must bear.  progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : a record of another search; pymoo not installed; numbers out of range.
    """
    for name, number, least in (("population", population, 4), ("generations", generations, 1), ("seed", seed, 0)):
        if not number >= least:
            raise ModelError("out of range", path=name, given=number, allowed=f"{least} or more")
    identity = {"format": _FORMAT, "problem": problem, "seed": seed, "population": population}
    recorded = [] if record is None else _read_record(record, identity)
    if record is not None:
        require_writable(record)
    evaluated: list[tuple[Array, Array]] = []
    algorithm = _algorithm(_first_generation(variables, population, seed, start), variables, objectives, seed)
    stopped = False
    try:
        for generation in range(generations):
            offspring = algorithm.ask()
            if offspring is None or not len(offspring):
                break  # no candidate left that is not a duplicate
            candidates = np.array(offspring.get("X"), dtype=float)
            if generation < len(recorded):
                follows, values = recorded[generation]
                if not np.array_equal(candidates, follows):
                    raise ModelError(
                        "the record does not follow from its seed: made by another version of pymoo?",
                        path=str(record),
                        allowed="a new record",
                    )
                if values.shape != (len(candidates), objectives):
                    raise ModelError("not the record of a search: other objectives", path=str(record))
            else:
                values = np.asarray(evaluate(candidates), dtype=float).reshape(len(candidates), objectives)
            evaluated.append((candidates, values))
            if record is not None and generation >= len(recorded):
                rows = [{"place": place.tolist(), "objective": objective.tolist()} for place, objective in evaluated]
                write_text(record, json.dumps({**identity, "generations": rows}))  # numbers are read back exactly
            _assign(algorithm, offspring, values)
            if progress is not None:
                progress((generation + 1) / generations)
    except KeyboardInterrupt:
        if not evaluated:
            raise
        stopped = True
    values = np.concatenate([values for _, values in evaluated])
    return SearchResult(
        candidates=np.concatenate([candidates for candidates, _ in evaluated]),
        objectives=values,
        generation=np.repeat(np.arange(len(evaluated)), [len(candidates) for candidates, _ in evaluated]),
        best=non_dominated(values),
        stopped=stopped,
    )


def _first_generation(variables: int, population: int, seed: int, start: Array | None) -> Array:
    """Latin hypercube (P, v) [mckay1979] whose first candidates are replaced by the given ones (k, v)."""
    random = np.random.default_rng(seed)
    stratum = np.stack([random.permutation(population) for _ in range(variables)], axis=1)
    candidates: Array = (stratum + random.random((population, variables))) / population
    if start is not None:
        candidates[: len(start)] = start[:population]
    return candidates


def _algorithm(first: Array, variables: int, objectives: int, seed: int) -> Any:
    """GA, or NSGA-II of several objectives, of pymoo [blank2020] with its first generation (P, v)."""
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.algorithms.soo.nonconvex.ga import GA
        from pymoo.core.problem import Problem
    except ImportError as error:
        raise ModelError(
            f"the search needs pymoo, which is not installed ({error})",
            path="relief",
            allowed="pip install 'epicyclic[optimise]'",
        ) from None
    problem = Problem(n_var=variables, n_obj=objectives, xl=np.zeros(variables), xu=np.ones(variables))
    algorithm = (GA if objectives == 1 else NSGA2)(pop_size=len(first), sampling=first)
    algorithm.setup(problem, termination=("n_gen", 10**9), seed=seed, verbose=False)
    return algorithm


def _assign(algorithm: Any, offspring: Any, values: Array) -> None:
    """Give the algorithm the objectives (P, o) of its offspring, the penalty in place of nan."""
    from pymoo.core.evaluator import Evaluator
    from pymoo.problems.static import StaticProblem

    penalised = np.where(np.isfinite(values), values, _PENALTY)
    Evaluator().eval(StaticProblem(algorithm.problem, F=penalised), offspring)
    algorithm.tell(infills=offspring)


def non_dominated(values: Array) -> NDArray[np.int64]:
    """Indices of the Pareto set of objectives (E, o), equal rows once, the first objective rising."""
    finite = np.flatnonzero(np.isfinite(values).all(axis=1))
    if not finite.size:
        return finite
    # np.unique sorts by the first objective, then by the next
    _, unique = np.unique(values[finite], axis=0, return_index=True)
    rows = finite[unique]
    ordered = values[rows]
    kept: list[int] = []
    for i, row in enumerate(ordered):
        dominating = (ordered <= row).all(axis=1) & (ordered < row).any(axis=1)
        if not dominating.any():
            kept.append(i)
    return rows[kept]


def _read_record(record: Path, identity: dict[str, Any]) -> list[tuple[Array, Array]]:
    """Candidates (P, v) and objectives (P, o) of every recorded generation; none where there is no file.

    Raises
    ------
    ModelError : not a record, or that of another search.
    """
    if not record.exists():
        return []
    try:
        data = json.loads(read_text(record, most=_MAX_BYTES))
        stored = {name: data[name] for name in identity}
        evaluated = [(np.array(one["place"], float), np.array(one["objective"], float)) for one in data["generations"]]
    except ModelError:
        raise
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise ModelError(f"not the record of a search: {error!r}", path=str(record)) from None
    for name, value in identity.items():
        if stored[name] != value:
            raise ModelError(
                f"the record of another search: its {name} differs", path=str(record), given=stored[name], allowed=value
            )
    return evaluated


# finalists ------------------------------------------------------------------------------------------------------------


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
        return self.problem.settings(self.candidates[self.answer])


def verified(
    problem: ReliefProblem, result: SearchResult, *, tolerance: float, pick: int | None, drawn: Array | None
) -> Finalists:
    """Best candidates of a search, solved with phases and slices that hold for the answer among them.

    Parameters
    ----------
    problem : phases and slices that its contact states are kept.  tolerance : as of `contact` [1].
    drawn : (1, v) candidate of the flanks as drawn, which the answer has to beat; None where the bounds exclude it.
    pick : index of the solution that is the answer; None: the nearest to the best of each objective.

    Raises
    ------
    ModelError : no such solution.
    """
    exact_slices = all(helix.segments.pair.slices == 1 for helices in problem.meshes for helix in helices)
    if problem.contact.samples is not None and (problem.contact.slices is not None or exact_slices):
        kept = result.best  # what is given needs no second solution
        answer = _answer(result.objectives[kept], pick)
        return Finalists(
            problem=problem,
            resolution=_resolution(problem, result.candidates[kept[answer]], tolerance),
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
        needed = _resolution(problem, candidates[answer], tolerance)
        if best is not None and needed.samples <= best.samples and needed.slices <= best.slices:
            break
        problem = with_resolution(problem, needed)
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


def _chosen(problem: ReliefProblem, result: SearchResult) -> NDArray[np.int64]:
    """Evaluations (k,) to solve again: the Pareto set, or the best of one objective, equal flanks once."""
    if len(problem.objectives) > 1:
        return result.best
    order = np.argsort(result.objectives[:, 0], kind="stable")
    kept: dict[str, int] = {}
    for i in order[np.isfinite(result.objectives[order, 0])].tolist():
        kept.setdefault(repr(problem.settings(result.candidates[i])), i)
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


def _resolution(problem: ReliefProblem, candidate: Array, tolerance: float) -> Resolution:
    """The finest that any mesh needs for the flanks of a candidate (v,), with the phases of all meshes."""
    flanks = problem.settings(candidate)
    each = [
        resolution(
            [helix.mesh for helix in helices],
            [helix.modified_pair(flanks) for helix in helices],
            helices[0].force,
            tolerance=tolerance,
            samples=problem.contact.samples,
            slices=problem.contact.slices,
        )
        for helices in problem.meshes
    ]
    return replace(
        each[0],
        samples=max(cut.samples for cut in each),
        slices=max(cut.slices for cut in each),
        error=np.max([cut.error for cut in each], axis=0),
    )
