"""Cheapest grades that keep a load factor below a target in a share of samples: best-first search, and what it proves.

A combination is one grade for each entry, (E,) places in its list, which stands from the finest grade to the coarsest.
K_gamma of combinations is on common random numbers: a sum of columns where it is linear, else evaluated one by one.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ...document.tolerances import Grade, Tolerance
from ...engine.sampling import piece_uniforms, sampling_plan
from ...statics.load_map import MEAN_LOADS
from ...statics.sample_loads import ContactMethod
from .tolerance_map import ToleranceMap

Array = NDArray[np.float64]
Combination = tuple[int, ...]
Proof = Literal["samples", "monotone", "open"]

# place of a grade that is not chosen yet
_FREE = -1
# share of the sum of prices below which two totals are the same: rounding of sums
_SAME = 1e-12
# samples that are counted first: a combination that fails mostly shows it in those with the largest values
_PIECES = (1024, 8192)


def order_statistic(values: Array, probability: float) -> float:
    """Least of the values (S,) that at least a share `probability` of them does not exceed."""
    place = len(values) - 1 - allowed_above(len(values), probability)
    return float(np.partition(values, place)[place])


def allowed_above(samples: int, probability: float) -> int:
    """Largest number of samples above a target that is met with a probability; below one sample: none."""
    # 1e-9: 0.99 * 16384 and its like are not to be rounded up across a whole number
    return min(samples - 1, samples - math.ceil(probability * samples - 1e-9))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GradeSet:
    """Grades that may be bought.

    entry : (e,) their entries in the map.  grades : of each, the finest first.
    """

    entry: tuple[int, ...]
    grades: tuple[tuple[Grade, ...], ...]

    @property
    def prices(self) -> list[list[float]]:
        """Per entry (G_e,), from the finest grade to the coarsest."""
        return [[grade.price for grade in row] for row in self.grades]


class Grades(Protocol):
    """Load factor of combinations of grades on one set of samples."""

    def value(self, combination: Combination, probability: float) -> float:
        """Load factor that is not exceeded with the probability [1]."""
        ...

    def meets(self, combination: Combination, target: float, probability: float) -> bool:
        """Whether no more samples than the probability leaves lie above the target."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GradeColumns:
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

    def value(self, combination: Combination, probability: float) -> float:
        """Load factor that is not exceeded with the probability [1]."""
        return order_statistic(self.factors(combination), probability)

    def meets(self, combination: Combination, target: float, probability: float) -> bool:
        """Whether no more samples than the probability leaves lie above the target."""
        return self.may_meet(combination, target, probability)

    def may_meet(self, part: Combination, target: float, probability: float) -> bool:
        """Whether a bound leaves it open that some choice of the free entries meets the target.

        The bound takes of every free entry the least that any of its grades adds, mesh by mesh and sample by sample:
        no combination lies below it.  Of a whole combination the answer is exact.
        """
        allowed, above, start = allowed_above(len(self.base), probability), 0, 0
        for stop in (*_PIECES, len(self.base)):
            above += int(np.count_nonzero(self._loads(part, slice(start, stop)).max(axis=1) > target))
            if above > allowed:
                return False
            start = min(stop, len(self.base))
        return True

    def _loads(self, part: Combination, rows: slice) -> Array:
        """Loads (rows, w) of a combination, of free entries their least."""
        total = self.base[rows].copy()
        for entry, grade in enumerate(part):
            total += self.least[entry, rows] if grade == _FREE else self.change[entry][grade, rows]
        return total


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledGrades:
    """Load factors of combinations of grades, each evaluated on the same samples.

    uniform : (S, d).  values : load factors (S,) of the combinations asked for, each evaluated once.
    """

    drawn: ToleranceMap
    offered: GradeSet
    uniform: Array
    definition: str
    method: ContactMethod
    values: dict[Combination, Array] = field(default_factory=dict)

    @classmethod
    def of(
        cls, drawn: ToleranceMap, offered: GradeSet, *, samples: int, seed: int, definition: str, method: ContactMethod
    ) -> SampledGrades:
        """With samples as `tolerance` draws them."""
        plan = sampling_plan(samples, seed=seed)
        d, rows = drawn.dimension_entry.size, plan.together * plan.rows
        pieces = [piece_uniforms(plan, piece, d)[:rows] for piece in range(plan.pieces)]
        return cls(drawn=drawn, offered=offered, uniform=np.concatenate(pieces), definition=definition, method=method)

    def factors(self, combination: Combination) -> Array:
        """Load factor of every sample (S,) [1], the largest of all pairs; inf where no state was found."""
        if combination not in self.values:
            entries = list(self.drawn.entries)
            for index, row, grade in zip(self.offered.entry, self.offered.grades, combination, strict=True):
                entries[index] = with_grade(entries[index], row[grade])
            k = self.drawn.with_entries(entries).evaluate(self.uniform, method=self.method).k
            largest = k[:, MEAN_LOADS.index(self.definition)].max(axis=1)
            self.values[combination] = np.nan_to_num(largest, nan=np.inf)
        return self.values[combination]

    def value(self, combination: Combination, probability: float) -> float:
        """Load factor that is not exceeded with the probability [1]."""
        return order_statistic(self.factors(combination), probability)

    def meets(self, combination: Combination, target: float, probability: float) -> bool:
        """Whether no more samples than the probability leaves lie above the target."""
        above = int(np.count_nonzero(self.factors(combination) > target))
        return above <= allowed_above(len(self.uniform), probability)


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


def differing(columns: GradeColumns, sampled: SampledGrades, combination: Combination, target: float) -> int:
    """Samples that the sum of columns and an evaluation put on different sides of a target."""
    exact = _in_order(columns, sampled, combination)
    return int(np.count_nonzero((columns.factors(combination) > target) != (exact > target)))


def largest_difference(columns: GradeColumns, sampled: SampledGrades, combination: Combination, below: float) -> float:
    """Largest difference of the two [1] among samples whose evaluated load factor is at most `below`."""
    exact = _in_order(columns, sampled, combination)
    return float(np.abs(columns.factors(combination) - exact)[exact <= below].max(initial=0.0))


def _in_order(columns: GradeColumns, sampled: SampledGrades, combination: Combination) -> Array:
    return np.asarray(sampled.factors(combination)[columns.order])


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
    second one, which gives up only what the bound of `GradeColumns.may_meet` excludes, proves the answer on its
    samples, or finds a better one.

    Parameters
    ----------
    prices : per entry (G_e,), from the finest grade to the coarsest.
    most, most_proof : combinations, and parts of such, that the two best-first searches try at most.
    """

    def meets(combination: Combination) -> bool:
        if combination not in known:
            known[combination] = grades.meets(combination, target, probability)
        return known[combination]

    def may_meet_monotone(part: Combination) -> bool:
        return meets(tuple(max(grade, 0) for grade in part))

    known: dict[Combination, bool] = {}
    first = _greedy(grades, prices, meets, target, probability)
    below = math.inf if first is None else total_price(prices, first)
    better, bound, complete, tried = _best_first(prices, may_meet_monotone, below, most)
    cheapest = better or first
    price = math.inf if cheapest is None else total_price(prices, cheapest)
    proof: Proof = "monotone" if complete else "open"
    if isinstance(grades, GradeColumns) and most_proof:
        columns = grades
        better, _, complete, more = _best_first(
            prices, lambda part: columns.may_meet(part, target, probability), price, most_proof
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
    known: dict[Combination, float] = {}

    def value(combination: Combination) -> float:
        if combination not in known:
            known[combination] = grades.value(combination, probability)
        return known[combination]

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


def _greedy(
    grades: Grades,
    prices: Sequence[Sequence[float]],
    meets: Callable[[Combination], bool],
    target: float,
    probability: float,
) -> Combination | None:
    """From the finest grades, as long as the target is met, the change of one entry that saves most; None: no start.

    Where the finest miss the target, single changes that lower the load factor are followed for a start.
    """
    at: Combination = (0,) * len(prices)
    value = math.nan
    while not meets(at):
        value = grades.value(at, probability) if math.isnan(value) else value
        changed = [combination for _, _, combination in neighbours(prices, at)]
        lowest, lowest_at = min(((grades.value(c, probability), c) for c in changed), default=(math.inf, at))
        if lowest >= value:
            return None
        at, value = lowest_at, lowest
    while True:
        cheaper = [
            _with(at, entry, grade)
            for entry, row in enumerate(prices)
            for grade in range(len(row))
            if row[grade] < row[at[entry]]
        ]
        cheapest_first = sorted((total_price(prices, combination), combination) for combination in cheaper)
        better = next((combination for _, combination in cheapest_first if meets(combination)), None)
        if better is None:
            return at
        at = better


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
