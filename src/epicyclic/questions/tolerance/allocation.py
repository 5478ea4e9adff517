"""Cheapest grades of a drawing that keep K_gamma below a target in a share of the trains: best-first search, its proof.

A combination is one grade for each entry, (E,) places in its list, which stands from the finest grade to the coarsest.
K_gamma of combinations is on common random numbers: a sum of columns where it is linear, else evaluated one by one.
Over load cases the drawing is one, and a train lies above the target for the share of its time in which it does.
"""

from __future__ import annotations

import heapq
import json
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from itertools import product
from typing import Any, Generic, Literal, NamedTuple, TypeVar, cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.tolerances import Grade, Tolerance
from ...engine.plan import all_uniforms, sampling_plan
from ...engine.source import Duty
from ...engine.workers import one_thread
from ...errors import ModelError
from ...limits import KGammaLimit
from ...options import Progress
from ...results.dataset import dataset
from ...statics.load_map import MEAN_LOADS
from ...system.assembly import train_provenance
from ...train.resolution import costs_of, load
from ...train.train import Train
from ...warning_codes import CodedText, coded
from . import AllocateOptions
from .statistics import CONFIDENCE, Array, Band, weighted_tally
from .tolerance import Columns, pair_limits, piece_of_samples, sampled
from .tolerance_map import ToleranceMap, tolerance_map

Combination = tuple[int, ...]
Proof = Literal["samples", "monotone", "open"]

# place of a grade that is not chosen yet
_FREE = -1
# share of the sum of prices below which two totals are the same: rounding of sums
_SAME = 1e-12
# samples that are counted first: a combination that fails mostly shows it in those with the largest values
_PIECES = (1024, 8192)


def order_statistic(values: Array, weight: Array, probability: float) -> float:
    """Least of the values (S,) that at least a share `probability` of their weights (S,) does not exceed."""
    order = np.argsort(-values, kind="stable")
    above = np.cumsum(weight[order])
    place = int(np.searchsorted(above, allowed_above(probability), side="right"))
    return float(values[order[min(place, len(values) - 1)]])


def allowed_above(probability: float) -> float:
    """Largest share of the samples above a target that is met with a probability."""
    # 0.99 of 16384 samples and its like are not to be rounded up across a whole number
    return 1 - probability + 1e-12


class GradeSet(NamedTuple):
    """Grades that may be bought.

    entry : (e,) their entries in the map.  grades : of each, the finest first.
    """

    entry: tuple[int, ...]
    grades: tuple[tuple[Grade, ...], ...]

    @property
    def prices(self) -> list[list[float]]:
        """Per entry (G_e,), from the finest grade to the coarsest."""
        return [[grade.price for grade in row] for row in self.grades]


class Grades(ABC):
    """Load factors of combinations of grades on one set of samples."""

    __slots__ = ()

    @abstractmethod
    def factors(self, combination: Combination) -> Array:
        """Load factor of every sample (S,) [1]."""

    def weight(self, factors: Array) -> Array:
        """Share of the trains (S,) [1] of each of the load factors (S,)."""
        return np.full(len(factors), 1 / len(factors))

    def value(self, combination: Combination, probability: float) -> float:
        """Load factor that is not exceeded with the probability [1]."""
        return self.quantile(self.factors(combination), probability)

    def quantile(self, factors: Array, probability: float) -> float:
        """The same of load factors (S,)."""
        return order_statistic(factors, self.weight(factors), probability)

    def above(self, combination: Combination, target: float, allowed: float) -> float:
        """Share of the samples above the target [1]; once it is more than what is allowed, at least that."""
        return float(np.mean(self.factors(combination) > target))

    def meets(self, combination: Combination, target: float, probability: float) -> bool:
        """Whether no more samples than the probability leaves lie above the target."""
        allowed = allowed_above(probability)
        return self.above(combination, target, allowed) <= allowed


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GradeColumns(Grades):
    """Load factors that are linear in the errors: on common random numbers a combination costs a sum.

    base : (S, w) load factor of every mesh without the errors of the entries, w meshes.
    change : per entry (G_e, S, w), what each of its grades adds.  least : (E, S, w) the least of them.
    order : (S,) place of every sample among those given.
    """

    base: Array
    change: tuple[Array, ...]
    least: Array
    order: NDArray[np.int64]

    @classmethod
    def of(cls, base: Array, change: Sequence[Array]) -> GradeColumns:
        """Columns with the samples in order of their load factor with the coarsest grades, the largest first."""
        coarsest = (base + sum((grades[-1] for grades in change), np.zeros_like(base))).max(axis=1)
        order = np.argsort(-coarsest, kind="stable")
        kept = tuple(np.ascontiguousarray(grades[:, order]) for grades in change)
        least = np.stack([grades.min(axis=0) for grades in kept]) if kept else np.zeros((0, *base.shape))
        return cls(base=np.ascontiguousarray(base[order]), change=kept, least=least, order=order)

    def factors(self, combination: Combination) -> Array:
        """Load factor of the most loaded mesh (S,), in the order of the columns."""
        return np.asarray(self._loads(combination, slice(None)).max(axis=1))

    def above(self, combination: Combination, target: float, allowed: float) -> float:
        """Share of the samples above the target [1]; once it is more than what is allowed, at least that.

        With free entries: a bound of it.  The bound takes of every free entry the least that any of its grades adds,
        mesh by mesh and sample by sample: no combination lies below it.
        """
        above = start = 0
        for stop in (*_PIECES, len(self.base)):
            above += int(np.count_nonzero(self._loads(combination, slice(start, stop)).max(axis=1) > target))
            if above > allowed * len(self.base):
                break
            start = min(stop, len(self.base))
        return above / len(self.base)

    def _loads(self, part: Combination, rows: slice) -> Array:
        """Loads (rows, w) of a combination, of free entries their least."""
        total = self.base[rows].copy()
        for entry, grade in enumerate(part):
            total += self.least[entry, rows] if grade == _FREE else self.change[entry][grade, rows]
        return total


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledGrades(Grades):
    """Load factors of combinations of grades, each evaluated on the same samples.

    options : which K_gamma, and how contact is solved.  uniform : (S, d).
    values : load factors (S,) of the combinations asked for, each evaluated once.
    """

    drawn: ToleranceMap
    offered: GradeSet
    options: AllocateOptions
    uniform: Array
    values: dict[Combination, Array] = field(default_factory=dict)

    @classmethod
    def of(cls, drawn: ToleranceMap, offered: GradeSet, options: AllocateOptions) -> SampledGrades:
        """With samples as `tolerance` draws them."""
        plan = sampling_plan(options.samples, seed=options.seed)
        uniform = all_uniforms(plan, drawn.dimension_entry.size)
        return cls(drawn=drawn, offered=offered, options=options, uniform=uniform)

    def factors(self, combination: Combination) -> Array:
        """Load factor of every sample (S,) [1], the largest of all pairs; inf where no state was found."""
        if combination not in self.values:
            entries = list(self.drawn.entries)
            for index, row, grade in zip(self.offered.entry, self.offered.grades, combination, strict=True):
                entries[index] = with_grade(entries[index], row[grade])
            self.values[combination] = self.of_entries(entries)
        return self.values[combination]

    def of_entries(self, entries: Sequence[Tolerance]) -> Array:
        """The same of a drawing with other distributions."""
        k = self.drawn.with_entries(entries).evaluate(self.uniform, method=self.options.method).k
        return np.asarray(np.nan_to_num(k[:, MEAN_LOADS.index(self.options.definition)].max(axis=1), nan=np.inf))


Part = TypeVar("Part", bound=Grades)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DutyGrades(Grades, Generic[Part]):
    """Load factors of the same trains in every load case.

    parts : of each case, on as many samples.  share : (c,) of the time [1].
    """

    parts: tuple[Part, ...]
    share: tuple[float, ...]

    def factors(self, combination: Combination) -> Array:
        """Load factor of every sample [1], case by case."""
        return np.concatenate([part.factors(combination) for part in self.parts])

    def weight(self, factors: Array) -> Array:
        """Share of the time of all trains (S,) [1] of each of the load factors (S,), case by case."""
        return np.repeat(np.array(self.share), len(factors) // len(self.share)) * len(self.share) / len(factors)

    def above(self, combination: Combination, target: float, allowed: float) -> float:
        """Share of the time of all trains above the target [1]; once it is more than what is allowed, at least that."""
        above = 0.0
        for part, share in zip(self.parts, self.share, strict=True):
            above += share * part.above(combination, target, (allowed - above) / share)
            if above > allowed:
                break
        return above


def with_grade(entry: Tolerance, grade: Grade) -> Tolerance:
    """The entry with a grade in the place of its own draw; of its common one where it has no other."""
    if entry.own is not None:
        return replace(entry, own=grade.distribution)
    return replace(entry, common=grade.distribution)


def grade_columns(sampled: SampledGrades) -> GradeColumns:
    """Columns of the load sharing at closed contact, by mean-load, in which the errors of the entries are linear.

    What each grade adds is the difference it makes while all other entries with grades are at their means: torques and
    stiffnesses, which are not linear, keep their samples.
    """
    drawn, offered = sampled.drawn, sampled.offered
    loaded = np.concatenate(drawn.group)

    def loads(entries: Sequence[Tolerance], at_mean: Sequence[int]) -> Array:
        scale = np.ones(len(entries))
        scale[list(at_mean)] = 0.0
        load = drawn.with_entries(entries).evaluate(sampled.uniform, scale=scale, method="linear").load[:, 0]
        return np.nan_to_num(load[:, loaded], nan=np.inf)

    base = loads(drawn.entries, offered.entry)
    changes = []
    for index, row in zip(offered.entry, offered.grades, strict=True):
        others = [other for other in offered.entry if other != index]
        change = []
        for grade in row:
            entries = list(drawn.entries)
            entries[index] = with_grade(entries[index], grade)
            with np.errstate(invalid="ignore"):  # a sample without load has no sharing, whatever the grades
                change.append(loads(entries, others) - base)
        changes.append(np.stack(change))
    return GradeColumns.of(base, changes)


def summed_and_evaluated(
    columns: DutyGrades[GradeColumns], sampled: DutyGrades[SampledGrades], combination: Combination
) -> tuple[Array, Array]:
    """Load factor of every sample (S,) [1] by the sum of columns and by an evaluation, case by case."""
    pairs = zip(columns.parts, sampled.parts, strict=True)
    return columns.factors(combination), np.concatenate([part.factors(combination)[own.order] for own, part in pairs])


# search ---------------------------------------------------------------------------------------------------------------


class Allocation(NamedTuple):
    """Grades found.

    combination : None where none was found.  price : its total; inf of None.
    bound : no combination costs less, by `proof`: ``samples`` without any assumption, by enumeration with a bound that
        holds in every sample; ``monotone`` where no finer grade makes it worse; ``open`` where the search ended early.
    first : combination of the greedy search, the first that met the target.  tried : combinations and parts of such.
    """

    combination: Combination | None
    price: float
    bound: float
    proof: Proof
    first: Combination | None
    tried: int


def allocate_grades(
    grades: Grades,
    prices: Sequence[Sequence[float]],
    target: float,
    probability: float,
    *,
    most: int,
    most_proof: int = 0,
) -> Allocation:
    """Grades of least total price whose load factor stays at or below the target with the probability.

    A greedy search gives a first answer.  A best-first search by price improves it, where what fails with the finest
    grades of all free entries is given up: that is right where finer grades never make it worse.  Of linear columns a
    second one, which gives up only what the bound of `GradeColumns.meets` excludes, proves the answer on its
    samples, or finds a better one.

    Parameters
    ----------
    prices : per entry (G_e,), from the finest grade to the coarsest.
    most, most_proof : combinations, and parts of such, that the two best-first searches try at most; the second one is
        for linear columns.
    """

    @cache
    def meets(combination: Combination) -> bool:
        return grades.meets(combination, target, probability)

    def may_meet_monotone(part: Combination) -> bool:
        return meets(tuple(max(grade, 0) for grade in part))

    first = _greedy(grades, prices, meets, probability)
    below = math.inf if first is None else total_price(prices, first)
    better, bound, complete, tried = _best_first(prices, may_meet_monotone, below, most)
    cheapest = better or first
    price = math.inf if cheapest is None else total_price(prices, cheapest)
    proof: Proof = "monotone" if complete else "open"
    if most_proof:
        better, _, complete, more = _best_first(
            prices, lambda part: grades.meets(part, target, probability), price, most_proof
        )
        tried += more
        if better is not None:
            cheapest, price = better, total_price(prices, better)
        if complete:
            bound, proof = price, "samples"
    return Allocation(cheapest, price, min(bound, price), proof, first, tried)


def total_price(prices: Sequence[Sequence[float]], combination: Combination) -> float:
    """Sum of the prices of a combination."""
    return math.fsum(row[grade] for row, grade in zip(prices, combination, strict=True))


def neighbours(prices: Sequence[Sequence[float]], combination: Combination) -> Iterator[tuple[int, int, Combination]]:
    """Entry, step (-1 finer, +1 coarser) and combination of every change of one entry by one grade."""
    for entry, step in product(range(len(combination)), (-1, 1)):
        if 0 <= combination[entry] + step < len(prices[entry]):
            yield entry, step, _with(combination, entry, combination[entry] + step)


def not_monotone(
    grades: Grades, prices: Sequence[Sequence[float]], contexts: Sequence[Combination], probability: float
) -> tuple[int, list[tuple[int, int, Combination]]]:
    """Comparisons of neighbouring grades, and those in which the finer one has the larger load factor.

    Parameters
    ----------
    contexts : grades of the other entries.

    Returns
    -------
    number of comparisons, and (entry, finer grade, context) of each that fails.
    """

    @cache
    def value(combination: Combination) -> float:
        return grades.value(combination, probability)

    compared: dict[tuple[Combination, Combination], tuple[int, int, Combination]] = {}
    for context in contexts:
        for entry, row in enumerate(prices):
            for finer in range(len(row) - 1):
                pair = _with(context, entry, finer), _with(context, entry, finer + 1)
                compared.setdefault(pair, (entry, finer, context))
    failed = [where for (fine, coarse), where in compared.items() if value(fine) > value(coarse)]
    return len(compared), failed


def _with(combination: Combination, entry: int, grade: int) -> Combination:
    return (*combination[:entry], grade, *combination[entry + 1 :])


def _downhill(grades: Grades, prices: Sequence[Sequence[float]], probability: float) -> Iterator[Combination]:
    """From the finest grades, the single change that lowers the load factor most, as long as one does."""
    at: Combination = (0,) * len(prices)
    while True:
        yield at
        value = grades.value(at, probability)
        changed = [combination for _, _, combination in neighbours(prices, at)]
        lowest, at = min(((grades.value(c, probability), c) for c in changed), default=(math.inf, at))
        if lowest >= value:
            return


def _greedy(
    grades: Grades,
    prices: Sequence[Sequence[float]],
    meets: Callable[[Combination], bool],
    probability: float,
) -> Combination | None:
    """From the finest grades, as long as the target is met, the change of one entry that saves most; None: no start.

    Where the finest miss the target, single changes that lower the load factor are followed for a start.
    """
    at = next(filter(meets, _downhill(grades, prices, probability)), None)
    while at is not None:
        cheaper = [
            _with(at, entry, grade)
            for entry, row in enumerate(prices)
            for grade in range(len(row))
            if row[grade] < row[at[entry]]
        ]
        cheapest_first = sorted((total_price(prices, combination), combination) for combination in cheaper)
        better = next((combination for _, combination in cheapest_first if meets(combination)), None)
        if better is None:
            break
        at = better
    return at


def _best_first(
    prices: Sequence[Sequence[float]], may_meet: Callable[[Combination], bool], below: float, most: int
) -> tuple[Combination | None, float, bool, int]:
    """The cheapest combination below a price, by parts of combinations in order of the least price they can have.

    Returns
    -------
    combination or None, price below which there is none, whether the search was complete, parts tried.
    """
    least = [min(row) for row in prices]
    # entries whose prices differ most are chosen first: they decide most of the total
    order = sorted(range(len(prices)), key=lambda entry: -(max(prices[entry]) - least[entry]))
    scale = _SAME * math.fsum(max(map(abs, row)) for row in prices)
    queue: list[tuple[float, int, Combination]] = [(math.fsum(least), 0, (_FREE,) * len(prices))]
    tried = 0
    while queue:
        bound, depth, part = heapq.heappop(queue)
        if bound >= below - scale:
            return None, below, True, tried
        if tried >= most:
            return None, bound, False, tried
        tried += 1
        if not may_meet(part):
            continue
        if -depth == len(prices):
            return part, bound, True, tried
        entry = order[-depth]
        for grade in range(len(prices[entry])):
            child = _with(part, entry, grade)
            total = math.fsum(
                least[other] if place == _FREE else prices[other][place] for other, place in enumerate(child)
            )
            heapq.heappush(queue, (total, depth - 1, child))
    return None, below, True, tried


# parts of combinations that a search by sums tries at most: some ten seconds
_MOST_SUMS = 20_000
# combinations that a search by evaluation tries at most: each takes a tenth of a second at the samples of the default
_MOST_EVALUATED = 400
# samples above the target at least, so that a share of them says something
_LEAST_ABOVE = 8
# rounding of a sum of columns beside an evaluation [1]
_ROUNDING = 1e-9
# rounds in which the target of the search is lowered until the fresh run meets that asked for
_ROUNDS = 6
# of a miss by the fresh run, what the next round's target is lowered by: a little more than the miss
_LOWERED = 1.1
# steps between the finest and the coarsest grades in which the cheapest grades of other targets are followed: finer
# ones cannot be seen; and parts that each of these searches tries, some tenths of a second
_FRONT, _MOST_FRONT = 60, 2_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Problem:
    """Grades on offer, and the samples that tell combinations apart.

    trains : of every load case by its name, "" of one point; what is on offer is the same in all.
    names : paths of the entries with grades.  finest, coarsest : combinations.
    """

    trains: Mapping[str, Train]
    sampled: DutyGrades[SampledGrades]
    limit: KGammaLimit
    options: AllocateOptions

    @property
    def first(self) -> SampledGrades:
        return self.sampled.parts[0]

    @property
    def offered(self) -> GradeSet:
        return self.first.offered

    @property
    def target(self) -> float:
        """Largest K_gamma [1] that is accepted."""
        return self.limit.value

    @property
    def names(self) -> list[str]:
        return [self.first.drawn.entries[index].path for index in self.offered.entry]

    @property
    def table(self) -> dict[str, Any]:
        """`[tolerance]` of the document, with full paths."""
        return dict(cast(Mapping[str, Any], next(iter(self.trains.values())).document["tolerance"]))

    @property
    def finest(self) -> Combination:
        return (0,) * len(self.offered.grades)

    @property
    def coarsest(self) -> Combination:
        return tuple(len(row) - 1 for row in self.offered.grades)


def allocate(source: Train | Duty, options: AllocateOptions, *, progress: Progress | None = None) -> xr.Dataset:
    """Cheapest grades of ``[tolerance.cost]`` with which K_gamma stays at or below a target with a probability.

    Parameters
    ----------
    source : one train; or the trains of load cases, of one drawing, whose time above the target counts together.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : grade, price, and the next finer and coarser grade of every entry with what it costs or saves and the
        K_gamma it gives (tolerance), total price, its bound, K_gamma reached by the fresh run; kind ``allocate``.
        Of load cases also share of the time, K_gamma and the share of the trains above the target of each (case).
        Attribute ``proof``: ``samples``: no combination costs less on the samples; ``monotone``: none does where finer
        grades never raise K_gamma; ``open``: neither.  Attribute ``allocated_model``: the model with the grades.

    Raises
    ------
    ModelError : a wrong model or option, no prices, a target out of reach.
    """
    _check_samples(options.probability, options.samples)
    cases, maps, left_out = _mapped(source)
    trains = [train for train, _ in cases.values()]
    offered = [_offered(drawn, costs_of(train)) for drawn, train in zip(maps, trains, strict=True)]
    _check_offered(maps, offered)
    limits = [one for drawn, train in zip(maps, trains, strict=True) for one in pair_limits(drawn, train, None)]
    limit = min(limits, key=lambda one: one.value)
    if options.target is not None:
        limit = KGammaLimit(value=options.target, source="the option target")
    report = progress or (lambda done: None)
    with one_thread():
        parts = [SampledGrades.of(drawn, own, options) for drawn, own in zip(maps, offered, strict=True)]
        common = DutyGrades(parts=tuple(parts), share=tuple(share for _, share in cases.values()))
        by_case = dict(zip(cases, trains, strict=True))
        problem = _Problem(trains=by_case, sampled=common, limit=limit, options=options)
        report(0.1)
        columns = _columns(problem)
        report(0.5)
        found = _verified(problem, columns, report)
        variables = _variables(problem, found)
        messages = _messages(problem, found)
    result = dataset(
        variables,
        {"tolerance": problem.names, **({} if isinstance(source, Train) else {"case": list(cases)})},
        verb="allocate",
        options={**asdict(options), "target": limit.value},
        provenance=train_provenance(trains[0]),
        warnings=[*left_out, *dict.fromkeys(text for drawn in maps for text in drawn.warnings), *messages],
    )
    result.attrs |= {
        "probability": options.probability,
        "target_source": limit.source,
        "definition": options.definition,
        "samples": len(parts[0].uniform),
        "seed": options.seed,
        "fresh_samples": sampling_plan(options.fresh_samples).samples,
        "fresh_seed": options.seed + 1,
        "confidence": CONFIDENCE,
        "proof": found.choice.proof,
        "tried": found.choice.tried,
        "linear": int(found.grades is columns),
        "allocated_model": json.dumps(_document(source, found.trains), default=str),
    }
    return result


def _mapped(
    source: Train | Duty,
) -> tuple[dict[str, tuple[Train, float]], list[ToleranceMap], list[CodedText]]:
    """Trains of the load cases that share a load, with their shares of the time [1], and their maps; the warnings of
    those that are left out.  A train alone is the case ""."""
    if isinstance(source, Train):
        return {"": (source, 1.0)}, [tolerance_map(source)], []
    trains, maps, left_out, first = dict[str, tuple[Train, float]](), list[ToleranceMap](), list[CodedText](), None
    for name, (drive, share) in source.cases.items():
        try:
            maps.append(tolerance_map(drive.train))
            trains[name] = drive.train, share
        except ModelError as error:
            first = first or error
            left_out.append(coded("case-failed", f"{name} is left out: {error}"))
    if first is not None and not trains:
        raise first
    whole = sum(share for _, share in trains.values())
    return {name: (train, share / whole) for name, (train, share) in trains.items()}, maps, left_out


def _document(source: Train | Duty, trains: Mapping[str, Train]) -> dict[str, Any]:
    """The document of the model with the tolerances of the trains found, and of each load case what its train has."""
    documents = {name: cast(dict[str, Any], dict(train.document)) for name, train in trains.items()}
    first = next(iter(documents.values()))
    if isinstance(source, Train):
        return first
    document = {**source.document, "tolerance": first["tolerance"]}
    own = {name: of_case["cases"][name] for name, of_case in documents.items()}
    return {**document, "cases": {**document["cases"], **own}}


# statement of the problem ---------------------------------------------------------------------------------------------


def _check_samples(probability: float, samples: int) -> None:
    """Refuse samples too few of which lie above a value of the probability."""
    above = (1 - probability) * sampling_plan(samples).samples
    if above < _LEAST_ABOVE * (1 - _ROUNDING):
        least = math.ceil(_LEAST_ABOVE / (1 - probability))
        problem = f"only {above:.2g} samples lie above a value of this probability"
        raise ModelError(problem, path="samples", given=samples, allowed=f"{least} or more")


def _offered(drawn: ToleranceMap, costs: dict[str, Any]) -> GradeSet:
    """Grades of the entries that have prices, the finest first."""
    priced = {index: costs[entry.path] for index, entry in enumerate(drawn.entries) if costs.get(entry.path)}
    if not priced:
        allowed = '"PATH" = { "GRADE" = price, ... } of paths of [tolerance]'
        raise ModelError("no prices are given", path="tolerance.cost", allowed=allowed)
    rows = [tuple(sorted(row, key=lambda grade: (grade.distribution.std, grade.price))) for row in priced.values()]
    return GradeSet(entry=tuple(priced), grades=tuple(rows))


def _check_offered(maps: Sequence[ToleranceMap], offered: Sequence[GradeSet]) -> None:
    """Refuse a price of what is not drawn in every load case, such as the torque of one."""
    paths = [[drawn.entries[index].path for index in own.entry] for drawn, own in zip(maps, offered, strict=True)]
    for other in paths[1:]:
        for path in {*paths[0]} ^ {*other}:
            allowed = "prices of what is drawn in every load case"
            raise ModelError("is not drawn in every load case", path=f"tolerance.cost.{path}", allowed=allowed)


def _columns(problem: _Problem) -> DutyGrades[GradeColumns] | None:
    """Columns where K_gamma is linear in the errors of the entries: by mean-load, of deviations, on closed contact.

    Checked at the finest grades, sample by sample; None where it is not.
    """
    deviations = all(name.startswith("deviations.") for name in problem.names)
    if problem.options.definition != MEAN_LOADS[0] or not deviations or problem.options.method == "static":
        return None
    columns = DutyGrades(parts=tuple(map(grade_columns, problem.sampled.parts)), share=problem.sampled.share)
    sums, exact = summed_and_evaluated(columns, problem.sampled, problem.finest)
    off = np.abs(sums - exact)[exact <= problem.target].max(initial=0.0)
    return columns if off <= _ROUNDING else None


# search and its verification ------------------------------------------------------------------------------------------


class _Verified(NamedTuple):
    """Grades found.  searched : target of the search that found them.  reached, above, trains : of the fresh run.

    reached : over all load cases.  of_case, above : (c,) K_gamma of each and share of the trains above the target.
    grades : columns where K_gamma is linear, else the samples, by which they were found.
    """

    choice: Allocation
    combination: Combination
    grades: DutyGrades[Any]
    searched: float
    reached: Band
    of_case: Array
    above: Array
    trains: Mapping[str, Train]


def _verified(problem: _Problem, columns: DutyGrades[GradeColumns] | None, report: Progress) -> _Verified:
    """Grades whose K_gamma a run with another seed confirms; the target of the search is lowered by what it misses."""
    first: Allocation | None = None
    found: _Verified | None = None
    searched = problem.target
    for round_number in range(_ROUNDS):
        choice, grades = _searched(problem, columns, searched)
        if choice.combination is None:
            break
        first = first or choice
        trains = _with_grades(problem, choice.combination)
        # the bound is that of the target asked for: a lower target costs at least as much
        kept = choice._replace(bound=first.bound, proof=first.proof)
        found = _Verified(kept, choice.combination, grades, searched, *_fresh(problem, trains.values()), trains)
        report(0.6 + 0.4 * (round_number + 1) / _ROUNDS)
        missed = float(found.reached.value.item()) - problem.target
        if missed <= 0:
            break
        searched -= _LOWERED * missed
    if found is None:
        raise _out_of_reach(problem, columns)
    return found


def _searched(
    problem: _Problem, columns: DutyGrades[GradeColumns] | None, target: float
) -> tuple[Allocation, DutyGrades[Any]]:
    """Grades by sums of columns; by evaluation where there are none, or where contact opens and that changes them."""
    prices, p = problem.offered.prices, problem.options.probability
    if columns is not None:
        choice = allocate_grades(columns, prices, target, p, most=_MOST_SUMS, most_proof=_MOST_SUMS)
        # teeth that only push carry less than a sum of columns that pull elsewhere: a sum alone refuses nothing
        met = problem.sampled.meets(choice.combination or problem.finest, target, p)
        sums, exact = summed_and_evaluated(columns, problem.sampled, problem.coarsest)
        opens = ((sums > target) != (exact > target)).any()
        if met == (choice.combination is not None) and not opens:
            return choice, columns
    return allocate_grades(problem.sampled, prices, target, p, most=_MOST_EVALUATED), problem.sampled


def _with_grades(problem: _Problem, combination: Combination) -> dict[str, Train]:
    """The trains of all load cases whose ``[tolerance]`` has the grades of a combination."""
    table = problem.table
    for name, row, grade in zip(problem.names, problem.offered.grades, combination, strict=True):
        stated, text = table[name], row[grade].text
        table[name] = {**stated, _drawn_of(stated): text} if isinstance(stated, dict) else text
    return {name: load({**train.document, "tolerance": table}) for name, train in problem.trains.items()}


def _drawn_of(stated: Mapping[str, Any]) -> str:
    """Which draw of an entry has grades: its own one, its common one where it has no other."""
    return "own" if "own" in stated else "common"


def _fresh(problem: _Problem, trains: Iterable[Train]) -> tuple[Band, Array, Array]:
    """Of a run with a seed of its own: quantile of K_gamma over all load cases with its band, quantile and share above
    the target (c,) of each case."""
    options = problem.options
    plan, definition = sampling_plan(options.fresh_samples, seed=options.seed + 1), MEAN_LOADS.index(options.definition)
    probability, tallies = np.array([options.probability]), []
    for train in trains:
        drawn = tolerance_map(train)
        pieces = (piece_of_samples(drawn, plan, options.method, False, piece) for piece in range(plan.pieces))
        tallies.append(sampled(drawn, plan, pieces)[0].of_train(definition))
    of_case = np.array([tally.quantile_bands(probability).value.item() for tally in tallies])
    above = np.array([tally.exceedance(np.array([problem.target])).value.item() for tally in tallies])
    bands = weighted_tally(tallies, problem.sampled.share).quantile_bands(probability)
    return bands.of(lambda values: values.ravel()[:1]), of_case, above


def _out_of_reach(problem: _Problem, columns: DutyGrades[GradeColumns] | None) -> ModelError:
    """The error of a target that no grades meet, with the best that they reach."""
    prices, p, finest = problem.offered.prices, problem.options.probability, problem.finest
    closed = columns is not None and abs(columns.value(finest, p) - problem.sampled.value(finest, p)) <= _ROUNDING
    grades = columns if columns is not None and closed else problem.sampled
    *_, at = _downhill(grades, prices, p)  # the finest grades where finer is better
    best = grades.value(at, p)
    cheapest = allocate_grades(grades, prices, best, p, most=_MOST_EVALUATED)
    price = min(cheapest.price, total_price(prices, at))
    rest = [entry.path for i, entry in enumerate(problem.first.drawn.entries) if i not in problem.offered.entry]
    if math.isfinite(best):
        least = f"{math.ceil(best * 1e4) / 1e4:g}"
        allowed = f"{least} or more, the least that the grades reach on these samples, for {price:g}"
    else:
        allowed = "tolerances with which fewer of the trains have no solution or no load to share"
    without = f"; {', '.join(rest)} have no prices" if rest else ""
    path = problem.limit.source if problem.limit.source.startswith("limits") else "target"
    words = f"out of reach in {100 * p:g} % of the trains"
    return ModelError(words, path=path, given=problem.target, allowed=allowed + without)


# result ---------------------------------------------------------------------------------------------------------------


def _variables(problem: _Problem, found: _Verified) -> Columns:
    """Variables of the result."""
    prices, p, at, grades = problem.offered.prices, problem.options.probability, found.combination, found.grades
    texts = [[grade.text for grade in row] for row in problem.offered.grades]
    entries = [problem.table[name] for name in problem.names]
    stated = [str(entry[_drawn_of(entry)] if isinstance(entry, dict) else entry) for entry in entries]
    paid = [
        row[grades_of.index(text)] if text in grades_of else math.nan
        for row, grades_of, text in zip(prices, texts, stated, strict=True)
    ]
    # of the drawing as it is, on the samples of the search
    as_drawn = np.concatenate([part.of_entries(part.drawn.entries) for part in problem.sampled.parts])
    variables: Columns = {
        "drawn_grade": ("tolerance", np.array(stated, dtype=object)),
        "drawn_grade_price": ("tolerance", np.array(paid)),
        "grade": ("tolerance", np.array([row[i] for row, i in zip(texts, at, strict=True)], dtype=object)),
        "price": ("tolerance", np.array([row[i] for row, i in zip(prices, at, strict=True)])),
        **_steps(problem, grades, at, texts),
        "target": ((), problem.target),
        "total_price": ((), found.choice.price),
        "price_bound": ((), found.choice.bound),
        "drawn_price": ((), math.fsum(paid)),
        "drawn_k_gamma": ((), problem.sampled.quantile(as_drawn, p)),
        "found_k_gamma": ((), grades.value(at, p)),
        "reached_k_gamma": ((), float(found.reached.value.item())),
        "reached_k_gamma_low": ((), float(found.reached.low.item())),
        "reached_k_gamma_high": ((), float(found.reached.high.item())),
    }
    if "" not in problem.trains:
        own = {"case_share": np.array(problem.sampled.share), "case_k_gamma": found.of_case, "case_above": found.above}
        variables |= {name: ("case", values) for name, values in own.items()}
    if grades is not problem.sampled:  # by evaluation the front would take minutes
        variables |= _front(problem, grades)
    return variables


def _steps(problem: _Problem, grades: Grades, at: Combination, texts: Sequence[Sequence[str]]) -> Columns:
    """The next finer and coarser grade of every entry: what it costs or saves, and K_gamma with it alone changed."""
    prices, count = problem.offered.prices, len(at)
    names = {-1: ("finer_grade", "extra_cost", "finer_k_gamma"), 1: ("coarser_grade", "saving", "coarser_k_gamma")}
    found = {step: (np.full(count, "", object), *np.full((2, count), np.nan)) for step in names}
    for entry, step, other in neighbours(prices, at):
        text, change, value = found[step]
        text[entry] = texts[entry][other[entry]]
        change[entry] = -step * (prices[entry][other[entry]] - prices[entry][at[entry]])
        value[entry] = grades.value(other, problem.options.probability)
    return {name: ("tolerance", own) for step in names for name, own in zip(names[step], found[step], strict=True)}


def _front(problem: _Problem, columns: Grades) -> Columns:
    """Cheapest grades for targets from the coarsest grades down to the finest: price and K_gamma (front,).

    Each target lies just below what the grades of the last one reach, so that none is left out but for small steps.
    """
    prices, p = problem.offered.prices, problem.options.probability
    ends = [columns.value(combination, p) for combination in (problem.finest, problem.coarsest)]
    target, points = max(ends), list[tuple[float, float]]()
    while (choice := allocate_grades(columns, prices, target, p, most=_MOST_FRONT)).combination is not None:
        reached = columns.value(choice.combination, p)
        points.append((choice.price, reached))
        target = min(target, reached) - max(abs(ends[1] - ends[0]) / _FRONT, _ROUNDING)
    price, factor = np.array(points).reshape(-1, 2).T
    return {"front_price": ("front", price), "front_k_gamma": ("front", factor)}


def _messages(problem: _Problem, found: _Verified) -> list[CodedText]:
    """What the user should know: no proof, grades that are not monotone, contact that opens, a target not confirmed."""
    prices, p = problem.offered.prices, problem.options.probability
    messages = []
    compared, failed = not_monotone(found.grades, prices, (problem.finest, found.combination, problem.coarsest), p)
    for entry, grade, _ in failed[:1]:
        words = f"{problem.offered.grades[entry][grade].text} of {problem.names[entry]}"
        text = f"in {len(failed)} of {compared} comparisons a finer grade has the larger K_gamma, first {words}"
        messages.append(coded("grades-not-monotone", text))
    if found.choice.proof == "open":
        text = f"the search ended after {found.choice.tried} combinations: a cheaper one may be left"
        messages.append(coded("search-stopped", text))
    reached = float(found.reached.value.item())
    if reached > problem.target:
        text = f"the fresh run reaches {reached:.5g}, above the target {problem.target:g}: no margin is left"
        messages.append(coded("target-missed", text))
    elif found.searched < problem.target:
        text = f"searched with a target of {found.searched:.5g}, so that the fresh run meets that asked for"
        messages.append(coded("target-tightened", text))
    return messages
