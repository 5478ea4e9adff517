"""K_gamma of combinations of grades on common random numbers: as columns where it is linear, else one by one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...document.tolerances import Grade, Tolerance
from ...engine.sampling import piece_uniforms, sampling_plan
from ...statics.mean_load import MEAN_LOADS
from ...statics.sample_loads import ContactMethod
from .columns import ToleranceMap
from .grade_search import Combination, GradeColumns, allowed_above, order_statistic

__all__ = ["GradeSet", "SampledGrades", "differing", "grade_columns", "graded", "largest_difference"]

Array = NDArray[np.float64]


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledGrades:
    """Load factors of combinations, each evaluated on the same samples.

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
            graded_map = graded(self.drawn, self.offered, combination)
            found = graded_map.evaluate(self.uniform, method=self.method).k[:, MEAN_LOADS.index(self.definition)]
            self.values[combination] = np.nan_to_num(found.max(axis=1), nan=np.inf)
        return self.values[combination]

    def value(self, combination: Combination, probability: float) -> float:
        """Load factor that is not exceeded with the probability [1]."""
        return order_statistic(self.factors(combination), probability)

    def meets(self, combination: Combination, target: float, probability: float) -> bool:
        """Whether no more samples than the probability leaves lie above the target."""
        above = int(np.count_nonzero(self.factors(combination) > target))
        return above <= allowed_above(len(self.uniform), probability)


def graded(drawn: ToleranceMap, offered: GradeSet, combination: Combination) -> ToleranceMap:
    """The map with the distributions of a combination in the place of those drawn."""
    entries = list(drawn.entries)
    for place, row, grade in zip(offered.entry, offered.grades, combination, strict=True):
        entries[place] = with_grade(entries[place], row[grade])
    return drawn.with_entries(entries)


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
    loaded = np.concatenate(sampled.drawn.group)

    def loads(entries: Sequence[Tolerance], still: Sequence[int]) -> Array:
        scale = np.ones(len(entries))
        scale[list(still)] = 0.0
        found = drawn.with_entries(entries).evaluate(sampled.uniform, scale=scale, method="linear").load[:, 0]
        return np.nan_to_num(found[:, loaded], nan=np.inf)

    base = loads(drawn.entries, offered.entry)
    change = []
    for place, row in zip(offered.entry, offered.grades, strict=True):
        others = [other for other in offered.entry if other != place]
        found = []
        for grade in row:
            entries = list(drawn.entries)
            entries[place] = with_grade(entries[place], grade)
            with np.errstate(invalid="ignore"):  # a sample without load has no sharing, whatever the grades
                found.append(loads(entries, others) - base)
        change.append(np.stack(found))
    return GradeColumns.of(base, change)


def differing(columns: GradeColumns, sampled: SampledGrades, combination: Combination, target: float) -> int:
    """Samples that the sum of columns and an evaluation put on different sides of a target."""
    return int(
        np.count_nonzero((columns.factors(combination) > target) != (_in_order(columns, sampled, combination) > target))
    )


def largest_difference(columns: GradeColumns, sampled: SampledGrades, combination: Combination, below: float) -> float:
    """Largest difference of the two [1] among samples whose evaluated load factor is at most `below`."""
    exact = _in_order(columns, sampled, combination)
    found = np.abs(columns.factors(combination) - exact)[exact <= below]
    return float(found.max(initial=0.0))


def _in_order(columns: GradeColumns, sampled: SampledGrades, combination: Combination) -> Array:
    return np.asarray(sampled.factors(combination)[columns.order])
