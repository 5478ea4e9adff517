"""Optimisation of tip, root and end relief, crown and slope of one mesh of a train or of several, and its Dataset.

Genetic search over the unit cube whose generations are kept, and its finalists solved again.

One objective is minimised by a genetic algorithm, several by NSGA-II [deb2002], both those of pymoo [blank2020].  The
search follows from its seed alone, so its folder holds evaluations and not the state of the algorithm.  A resumed
search is repeated from its seed with the objectives kept, which takes no evaluation, and continues to the bits of an
uninterrupted search.

The search is on few phases and slices; its finalists are solved again with those that hold within a tolerance.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.run_folder import KeptPart, RunFolder, run_folder
from ...engine.source import Drive
from ...errors import ModelError
from ...results.dataset import dataset
from ...system.assembly import assemble, train_provenance
from ...system.system import Array, System
from ...teeth.form import Flank
from ...teeth.gear_pair import check_pair
from ...train.resolution import load
from ...train.train import Mesh, Train
from ...warning_codes import CodedText, coded
from . import ContactOptions, ReliefOptions
from .contact_resolution import Resolution, check_tolerance, resolution
from .pair_contact import PairContact, flank_columns, helices_of, mesh_name, normal_force, solved_pair, unresolved
from .relief_objectives import (
    DYNAMIC,
    OBJECTIVES,
    FlankSettings,
    ReliefProblem,
    force_curves,
    objectives_of,
    overrides_of,
    read_variables,
    relative_speeds,
)

Columns = dict[str, tuple[Any, Any]]

# loads of the Harris maps before and after, relative to the operating one
_MAP_LOADS = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
# places along the path of contact
_PATH_POINTS = 161
# evaluations kept in a result, so that its file stays below some ten megabytes
_MOST_EVALUATIONS = 200_000
# shares of the work once generations are through, and once the best are solved again, as spur teeth take it
_SEARCHED, _VERIFIED = 0.5, 0.8
# part of a range from its bound within which an answer counts as on it: a short search comes that close
_AT_BOUND = 1e-2


def relief(drive: Drive, options: ReliefOptions, *, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """Optimal micro-geometry: one objective by a genetic algorithm, the Pareto set of several by NSGA-II.

    Ctrl-C ends the search with the best candidates so far; the attribute ``stopped`` says so.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : design variables of every solution (solution, variable), objectives (solution, objective), before and
        after (objective), loaded contact before and after (state, relieved_mesh, ...), forces over speed of dynamic
        objectives (state, speed), and the evaluations (evaluation, ...).  Attributes ``overrides`` and
        ``relieved_model``: the answer as overrides and as a model.

    Raises
    ------
    ModelError : wrong model, name, bounds or folder; a relief that does not fit its flank; pymoo not installed.
    """
    train, objectives, torque = drive.train, options.objectives, options.torque
    loads = [float(load) for load in options.loads]
    shared = ("samples", "slices", "tolerance", "corner", "misalignment", "torque")
    settings = ContactOptions(**{name: getattr(options, name) for name in shared})
    _check_options(options, loads)
    meshes = _meshes(train, options.mesh)
    flanks: dict[str, Flank] = {}
    for helix in chain(*meshes):
        assert helix.teeth is not None
        flanks.update(zip(helix.teeth.paths, (helix.teeth.flank_a, helix.teeth.flank_b), strict=True))
    variables, fixed = read_variables(options.vary, flanks)
    forces = [[(helix, normal_force(train, helices, torque)) for helix in helices] for helices in meshes]
    dynamic = any(name in DYNAMIC for name in objectives)
    system = assemble(train) if dynamic else None
    # of dynamic forces, both or none [Hz]
    speeds = tuple(one for one in (options.start, options.stop) if one is not None)
    if len(speeds) == 1:
        raise ModelError("go together", path="start, stop", allowed='two mesh frequencies, "200 Hz" and "2 kHz"')
    problem = ReliefProblem(
        objectives=tuple(objectives),
        variables=variables,
        fixed=fixed,
        contact=settings,
        loaded=forces,
        factors=np.array(loads, dtype=float),
        train=train,
        system=system,
        speeds=None if system is None else relative_speeds(system, speeds, options.points),
    ).cut()
    for corner_of_bounds in (np.zeros(len(variables)), np.ones(len(variables))):  # refuse what does not fit a flank
        bound = problem.settings(corner_of_bounds)
        for part in chain(*problem.meshes):
            assert part.mesh.teeth is not None
            check_pair(part.modified_pair(bound), path=part.mesh.pair, paths=part.mesh.teeth.paths)
    recorded = {
        **{"vary": dict(options.vary), "mesh": options.mesh, "torque": torque, "objectives": list(objectives)},
        **{"factors": list(loads), "samples": options.samples, "slices": options.slices, "corner": options.corner},
        "misalignment": options.misalignment,
        **({"speeds": speeds or None, "speed_points": options.points} if dynamic else {}),
    }
    drawn = _drawn_candidate(problem, flanks)
    # the record of the search; more generations are the same one gone on with
    record = recorded | {"seed": options.seed, "population": options.population}
    model = json.dumps(dict(train.document), sort_keys=True, default=str)
    told = progress or (lambda _: None)
    folder, resume = options.folder if options.resume is None else options.resume, options.resume is not None
    with run_folder(folder, model, verb="relief", options=record, resume=resume) as (_, kept):
        result = genetic_search(
            problem,
            len(variables),
            len(objectives),
            options,
            start=drawn,
            kept=kept.part("generations"),
            progress=lambda done: told(_SEARCHED * done),
        )
    if not result.best.size:
        raise ModelError("no candidate could be computed", path="vary", given=dict(options.vary))
    solved = verified(problem, result, pick=options.pick, drawn=drawn)
    if not result.stopped:
        told(_VERIFIED)
    changes = overrides_of(solved.settings, flanks)
    if isinstance(drive.source, Train):
        after = load(dict(train.document), changes)
    else:
        assert not isinstance(drive.source, System)
        after = load(drive.source, {**(drive.overrides or {}), **changes})
    search = {name: getattr(options, name) for name in ("population", "generations", "seed")}
    labelled = dataset(
        {
            **_solutions(solved, result, flanks),
            **_before_and_after(solved, (train, after)),
        },
        coords={
            "variable": [one.name for one in variables],
            "objective": list(objectives),
            "solution": np.arange(len(solved.candidates)),
            "state": ["before", "after"],
            "relieved_mesh": [mesh_name(helices) for helices in meshes],
            **({} if problem.speeds is None else {"speed": problem.speeds}),
        },
        verb="relief",
        options=recorded | search,
        warnings=[
            *_warnings(train, after, solved, result, options.generations),
            *unresolved(solved.resolution, options.tolerance),
        ],
        provenance=train_provenance(train),
    )
    labelled.attrs |= {
        "picked": solved.answer,
        "samples": solved.resolution.samples,
        "slices": solved.resolution.slices,
        "tolerance": options.tolerance,
        "estimated_error": float(solved.resolution.error.max()),
        "overrides": json.dumps(changes),
        "relieved_model": json.dumps(dict(after.document), default=str),
        "stopped": int(result.stopped),
        "method": "GA" if len(objectives) == 1 else "NSGA-II",
    }
    return labelled


# statement of the problem ---------------------------------------------------------------------------------------------


def _check_options(options: ReliefOptions, loads: Sequence[float]) -> None:
    check_tolerance(options.tolerance)
    objectives, torque = options.objectives, options.torque
    if not objectives or len(set(objectives)) != len(objectives):
        raise ModelError("objectives", path="objectives", given=list(objectives), allowed=", ".join(OBJECTIVES))
    values = np.asarray(loads, dtype=float)
    if not values.size or not (np.isfinite(values).all() and (values > 0).all()):
        raise ModelError("relative loads", path="loads", given=list(loads), allowed="above 0")
    if torque is not None and any(name in DYNAMIC for name in objectives):
        raise ModelError(
            "the dynamic force is that of the train at its own torque",
            path="torque",
            given=torque,
            allowed="operation.torque in the model",
        )


def _meshes(train: Train, mesh: str | Sequence[str] | None) -> list[tuple[Mesh, ...]]:
    """Helices of every mesh to optimise, one branch of each pair."""
    if mesh is None:
        branches: dict[str, int | None] = {}
        for one in train.meshes:
            if one.teeth is not None:
                branches.setdefault(one.pair, one.branch)
        if not branches:
            path = f"stages.{train.meshes[0].stage}.face_width"
            raise ModelError("no mesh has a face width, which tooth contact needs", path=path, allowed="of both gears")
        return [
            tuple(one for one in train.meshes if one.pair == pair and one.branch == branch)
            for pair, branch in branches.items()
        ]
    names = [mesh] if isinstance(mesh, str) else list(mesh)
    meshes = [helices_of(train, name) for name in names]
    for name, helices in zip(names, meshes, strict=True):
        if helices[0].teeth is None:
            raise ModelError("has no face width, which tooth contact needs", path="mesh", given=name)
    return list({helices[0].pair: helices for helices in meshes}.values())


def _drawn_candidate(problem: ReliefProblem, flanks: Mapping[str, Flank]) -> Array | None:
    """Candidate (1, v) of the micro-geometry as drawn; None where it is out of bounds or differs between flanks."""
    coordinates = []
    for variable in problem.variables:
        table, _, name = variable.key.partition(".")
        drawn = [getattr(flanks[path], table) for path in variable.paths]
        # a relief that is not drawn has amount 0, and no length or shape
        absent = 0.0 if name == "amount" else None
        values = {getattr(one, name) if name and one is not None else absent if name else one for one in drawn}
        if len(values) > 1:
            return None
        value = values.pop()
        coordinates.append(0.5 if value is None else variable.coordinate(value))
    inside = np.array([0 <= coordinate <= 1 for coordinate in coordinates])
    return np.array([coordinates]) if inside.all() else None


# Dataset -------------------------------------------------------------------------------------------------------------


def _solutions(solved: Finalists, result: SearchResult, flanks: Mapping[str, Flank]) -> Columns:
    """Variables of the solutions (solution, ...), of before and after (objective), and of the evaluations."""
    problem, candidates = solved.problem, solved.candidates
    variables, objectives = problem.variables, problem.objectives
    values = [[one.value(at) for one, at in zip(variables, row, strict=True)] for row in candidates.tolist()]
    numeric = [[one.numeric(value) for one, value in zip(variables, row, strict=True)] for row in values]
    texts = [[one.text(value) for one, value in zip(variables, row, strict=True)] for row in values]
    drawn = objectives_of(problem, [{path: {} for path in flanks}])[0]
    # what each makes least, with the loads that it counts
    loads = ", ".join(f"{factor:g}" for factor in problem.factors)
    meanings = [OBJECTIVES[name][1].replace("over the loads", f"over the loads {loads}") for name in objectives]
    meanings = [text.replace(", loads and", f", loads {loads} and") for text in meanings]
    best_so_far = []
    for generation in range(int(result.generation.max()) + 1):
        upto = np.where(result.generation[:, None] <= generation, result.objectives, np.nan)
        best_so_far.append(np.nanmin(upto, axis=0))
    return {
        "lower_bound": ("variable", np.array([one.low for one in variables])),
        "upper_bound": ("variable", np.array([one.high for one in variables])),
        "solution_value": (("solution", "variable"), np.array(numeric)),
        "solution_text": (("solution", "variable"), np.array(texts, dtype=object)),
        "solution_objective": (("solution", "objective"), solved.objectives),
        "objective_before": ("objective", drawn),
        "objective_after": ("objective", solved.objectives[solved.answer]),
        "objective_meaning": ("objective", np.array(meanings, dtype=object)),
        "objective_unit": ("objective", np.array([OBJECTIVES[name][0] for name in objectives], dtype=object)),
        "evaluated_place": (("evaluation", "variable"), result.candidates[:_MOST_EVALUATIONS]),
        "evaluated_objective": (("evaluation", "objective"), result.objectives[:_MOST_EVALUATIONS]),
        "evaluated_generation": ("evaluation", result.generation[:_MOST_EVALUATIONS]),
        "best_so_far": (("generation", "objective"), np.array(best_so_far)),
    }


def _before_and_after(solved: Finalists, trains: Sequence[Train]) -> Columns:
    """Loaded contact of every mesh before and after, at several loads; of dynamic objectives the mesh forces [N] too.

    trains : before and after.
    """
    problem, cut = solved.problem, solved.resolution
    factors = np.array(sorted({*_MAP_LOADS, *problem.factors.tolist()}))
    options = replace(problem.contact, loads=factors.tolist())
    names = [mesh_name([mesh for mesh, _ in helices]) for helices in problem.loaded]
    results = [
        [solved_pair(train, helices_of(train, name), options, cut=cut, tangents=False) for name in names]
        for train in trains
    ]
    loads = [[_load_along_path(one) for one in meshes] for meshes in results]

    def stacked(values: Callable[[PairContact], Array]) -> Array:
        """Values of each result, (state, relieved_mesh, ...)."""
        return np.array([[values(one) for one in meshes] for meshes in results])

    over = ("state", "relieved_mesh", "load_factor")
    both: list[Mapping[str, FlankSettings]] = [{path: {} for path in solved.settings}, solved.settings]
    curves = [force_curves(problem, one) for one in both] if problem.system is not None else []
    dynamic = {DYNAMIC[name]: (("state", "speed"), np.array([one[name] for one in curves])) for name in DYNAMIC}
    return {
        **(dynamic if curves else {}),
        "load_factor": ("load_factor", factors),
        "mesh_phase": ("mesh_phase", cut.phase),
        "relieved_force": ("relieved_mesh", np.array([one.force for one in results[0]])),
        "relieved_error": ((*over, "mesh_phase"), stacked(lambda one: one.error)),
        "relieved_peak_to_peak": (over, stacked(lambda one: np.ptp(one.error, axis=1))),
        "relieved_largest_load": (
            over,
            stacked(lambda one: np.max([helix.largest_load for helix in one.results], axis=0)),
        ),
        "relieved_place": (("relieved_mesh", "path_point"), np.array([place for place, _ in loads[0]])),
        "relieved_load": (
            ("state", "relieved_mesh", "path_point"),
            np.array([[load for _, load in meshes] for meshes in loads]),
        ),
    }


def _load_along_path(solved: PairContact) -> tuple[Array, Array]:
    """Even places (P,) on the path of contact [base pitches], and the largest load per length over face and helices
    there at the operating load [N/m]; 0 out of contact."""
    columns, _ = flank_columns(solved)
    place = columns["path_place"][1][0]
    even = np.linspace(float(place[0]), float(place[-1]), _PATH_POINTS)
    largest = np.nan_to_num(columns["flank_load_per_length"][1]).max(axis=(0, 1))
    return even, np.asarray(np.interp(even, place, largest))


def _warnings(train: Train, after: Train, solved: Finalists, result: SearchResult, generations: int) -> list[CodedText]:
    """Warnings of the trains, of the search, and of the answer that is picked."""
    messages = [*train.warnings, *(text for text in after.warnings if text not in train.warnings)]
    completed = int(result.generation.max()) + 1
    if result.stopped:
        text = f"stopped after {completed} of {generations} generations: the best so far"
        messages.append(coded("search-stopped", text))
    failed = int((~np.isfinite(result.objectives)).any(axis=1).sum())
    if failed:
        text = f"{failed} of {len(result.objectives)} candidates could not be computed"
        messages.append(coded("points-failed", text))
    for variable, at in zip(solved.problem.variables, solved.candidates[solved.answer], strict=True):
        if not variable.shapes and min(at, 1 - at) < _AT_BOUND:
            side, bound = ("lower", variable.low) if at < 0.5 else ("upper", variable.high)
            best = "the best" if len(solved.candidates) == 1 else "the solution picked"
            beyond = "" if at < 0.5 and bound <= 0 and variable.key != "slope" else "; a better one may lie beyond"
            text = f"{variable.name}: {best} ends at the {side} bound, {bound * 1e6:.6g} µm{beyond}"
            messages.append(coded("at-bound", text))
    return messages


# objective of a candidate that could not be computed: worse than any that could, and finite, as pymoo needs
_PENALTY = 1e30
# Best candidates of a search with one objective that are solved again, each at the cost of a coarse generation.
_FINALISTS = 4
# Most times that phases and slices are chosen anew for a new answer; a third one has not been seen.
_ROUNDS = 3


# search ---------------------------------------------------------------------------------------------------------------


class SearchResult(NamedTuple):
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
    options: ReliefOptions,
    *,
    start: Array | None = None,
    kept: KeptPart | None = None,
    progress: Callable[[float], None] | None = None,
) -> SearchResult:
    """Minimise one objective, or find the Pareto set of several [deb2002].

    Ctrl-C ends the search with the evaluations of the completed generations.

    Parameters
    ----------
    evaluate : candidates (P, v) in the unit cube -> objectives (P, o), nan where one could not be computed.
    variables, objectives : v and o.  options : population P, number of generations, seed; equal seeds give equal
        searches.
    start : (k, v) candidates of the first generation; a Latin hypercube gives the others.
    kept : keeps the evaluations of every generation; those that lie there are not made again.
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : generations that are kept and do not follow from the seed; pymoo not installed.
    """
    kept = kept or RunFolder().part("generations")
    evaluated: list[tuple[Array, Array]] = []
    population, generations, seed = options.population, options.generations, options.seed
    # a Latin hypercube [mckay1979] whose first candidates are replaced by the given ones
    random = np.random.default_rng(seed)
    stratum = np.stack([random.permutation(population) for _ in range(variables)], axis=1)
    first: Array = (stratum + random.random((population, variables))) / population
    if start is not None:
        first[: len(start)] = start[:population]
    algorithm = _algorithm(first, objectives, seed)
    stopped = False
    try:
        for generation in range(generations):
            offspring = algorithm.ask()
            if offspring is None or not len(offspring):
                break  # no candidate left that is not a duplicate
            candidates = np.array(offspring.get("X"), dtype=float)
            if generation in kept.known:
                follows, values = kept.known[generation]
                if not np.array_equal(candidates, follows):
                    raise ModelError(
                        "the run that lies there does not follow from its seed: made by another version of pymoo?",
                        path=str(kept.of.folder),
                        allowed="another folder",
                    )
            else:
                values = np.asarray(evaluate(candidates), dtype=float).reshape(len(candidates), objectives)
                kept.add(generation, (candidates, values))
            evaluated.append((candidates, values))
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


def _algorithm(first: Array, objectives: int, seed: int) -> Any:
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
    problem = Problem(n_var=first.shape[1], n_obj=objectives, xl=np.zeros(first.shape[1]), xu=np.ones(first.shape[1]))
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
    # np.unique sorts by the first objective, then by the next
    ordered, unique = np.unique(values[finite], axis=0, return_index=True)
    free = [not ((ordered <= row).all(axis=1) & (ordered < row).any(axis=1)).any() for row in ordered]
    return np.asarray(finite[unique[np.flatnonzero(free)]], np.int64)


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


def verified(problem: ReliefProblem, result: SearchResult, *, pick: int | None, drawn: Array | None) -> Finalists:
    """Best candidates of a search, solved with phases and slices that hold for the answer among them.

    Parameters
    ----------
    problem : phases and slices that its contact states are kept.
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
            resolution=_resolution(problem, result.candidates[kept[answer]]),
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
        needed = _resolution(problem, candidates[answer])
        if best is not None and needed.samples <= best.samples and needed.slices <= best.slices:
            break
        problem = problem.cut(needed)
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


def _resolution(problem: ReliefProblem, candidate: Array) -> Resolution:
    """The finest that any mesh needs for the flanks of a candidate (v,), with the phases of all meshes."""
    flanks = problem.settings(candidate)
    each = [
        resolution(
            [helix.mesh for helix in helices],
            [helix.modified_pair(flanks) for helix in helices],
            helices[0].force,
            problem.contact,
        )
        for helices in problem.meshes
    ]
    return replace(
        each[0],
        samples=max(cut.samples for cut in each),
        slices=max(cut.slices for cut in each),
        error=np.max([cut.error for cut in each], axis=0),
    )
