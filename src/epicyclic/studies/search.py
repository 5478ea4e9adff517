"""Genetic search over a unit cube with a record on disk: one objective by a genetic algorithm, several by NSGA-II.

The search follows from its seed alone, so that the record holds what was evaluated, not the state of the algorithm: to
go on, the search is run again from its seed with the recorded answers, which takes no evaluation, and then continues to
the bits of a search that was never stopped.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..results.whole_file import write_text

__all__ = ["Found", "search"]

Array = NDArray[np.float64]

_FORMAT = 1
# What stands for an objective that could not be computed: worse than all that can.
_WORST = 1e30


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Found:
    """All that was evaluated, in order.

    place : (E, v) in the unit cube.  objective : (E, o), nan where it could not be computed.
    generation : (E,) from 0.  best : positions among E of the answer, one or the Pareto set.  stopped : by Ctrl-C.
    """

    place: Array
    objective: Array
    generation: NDArray[np.int64]
    best: NDArray[np.int64]
    stopped: bool


def search(
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
) -> Found:
    """Look for the least of one objective, or for the Pareto set of several.

    Parameters
    ----------
    evaluate : places (P, v) in the unit cube -> objectives (P, o), nan where there is none.
    population, generations : P and how many of them.  seed : the search is the same for the same seed.
    start : (k, v) places to begin with, beside those drawn at random.
    record : file that holds what was evaluated after every generation; where it is there already it is gone on with.
    problem : what a record must say to belong to this search.  progress : called with the share done.

    Ctrl-C ends the search with what has been found, once a generation is done.

    Raises
    ------
    ModelError : a record of another search; no pymoo; numbers out of range.
    """
    for name, number, least in (("population", population, 4), ("generations", generations, 1), ("seed", seed, 0)):
        if not number >= least:
            raise ModelError("out of range", path=name, given=number, allowed=f"{least} or more")
    identity = {"format": _FORMAT, "problem": problem, "seed": seed, "population": population}
    known = [] if record is None else _read(record, identity)
    done: list[tuple[Array, Array]] = []
    algorithm = _algorithm(_first(variables, population, seed, start), variables, objectives, seed)
    stopped = False
    try:
        for at in range(generations):
            asked = algorithm.ask()
            if asked is None or not len(asked):
                break  # nothing left that has not been looked at
            place = np.array(asked.get("X"), dtype=float)
            if at < len(known):
                _same(place, known[at][0], record)
                value = known[at][1]
            else:
                value = np.asarray(evaluate(place), dtype=float).reshape(len(place), objectives)
            done.append((place, value))
            if record is not None and at >= len(known):
                _write(record, identity, done)
            _tell(algorithm, asked, value)
            if progress is not None:
                progress((at + 1) / generations)
    except KeyboardInterrupt:
        if not done:
            raise
        stopped = True
    objective = np.concatenate([value for _, value in done])
    return Found(
        place=np.concatenate([place for place, _ in done]),
        objective=objective,
        generation=np.repeat(np.arange(len(done)), [len(place) for place, _ in done]),
        best=_best(objective),
        stopped=stopped,
    )


def _first(variables: int, population: int, seed: int, start: Array | None) -> Array:
    """A Latin hypercube (P, v), its first places taken by what is given."""
    random = np.random.default_rng(seed)
    stratum = np.stack([random.permutation(population) for _ in range(variables)], axis=1)
    place: Array = (stratum + random.random((population, variables))) / population
    if start is not None:
        place[: len(start)] = start[:population]
    return place


def _algorithm(first: Array, variables: int, objectives: int, seed: int) -> Any:
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


def _tell(algorithm: Any, asked: Any, value: Array) -> None:
    from pymoo.core.evaluator import Evaluator
    from pymoo.problems.static import StaticProblem

    told = np.where(np.isfinite(value), value, _WORST)
    Evaluator().eval(StaticProblem(algorithm.problem, F=told), asked)
    algorithm.tell(infills=asked)


def _best(objective: Array) -> NDArray[np.int64]:
    """Positions of what nothing else beats, each place in the space of objectives once, the first objective rising."""
    good = np.flatnonzero(np.isfinite(objective).all(axis=1))
    if not good.size:
        return good
    _, unique = np.unique(objective[good], axis=0, return_index=True)  # sorted by the first objective, then the next
    rows = good[unique]
    values = objective[rows]
    kept: list[int] = []
    for i, row in enumerate(values):
        beaten = (values <= row).all(axis=1) & (values < row).any(axis=1)
        if not beaten.any():
            kept.append(i)
    return rows[kept]


# record --------------------------------------------------------------------------------------------------------------


def _read(record: Path, identity: dict[str, Any]) -> list[tuple[Array, Array]]:
    if not record.exists():
        return []
    try:
        data = json.loads(record.read_text(encoding="utf-8"))
        said = {name: data[name] for name in identity}
        done = [(np.array(one["place"], float), np.array(one["objective"], float)) for one in data["generations"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ModelError(f"not the record of a search: {error!r}", path=str(record)) from None
    for name, value in identity.items():
        if said[name] != value:
            raise ModelError(
                f"the record of another search: its {name} differs", path=str(record), given=said[name], allowed=value
            )
    return done


def _write(record: Path, identity: dict[str, Any], done: list[tuple[Array, Array]]) -> None:
    """Write what was evaluated; the file is replaced as a whole.  Numbers are read back to the bit."""
    generations = [{"place": place.tolist(), "objective": value.tolist()} for place, value in done]
    write_text(record, json.dumps({**identity, "generations": generations}))


def _same(place: Array, known: Array, record: Path | None) -> None:
    if place.shape != known.shape or not np.array_equal(place, known):
        raise ModelError(
            "the record does not follow from its seed: made by another version of pymoo?",
            path=str(record),
            allowed="a new record",
        )
