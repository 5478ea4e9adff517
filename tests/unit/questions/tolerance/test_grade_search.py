"""Cheapest grades: against all combinations, where greedy choices and monotonicity fail, and by the closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from statistics import NormalDist

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.questions.tolerance.allocation import (
    DutyGrades,
    GradeColumns,
    allocate_grades,
    allowed_above,
    neighbours,
    not_monotone,
    order_statistic,
)

Array = NDArray[np.float64]


def floating_sun(planets: int) -> Array:
    """Loads that gaps e [in units of F0 / k] of the branches leave: -(I - D D+) e, derived in the docs."""
    angle = 2 * np.pi * np.arange(planets) / planets
    rows = np.column_stack([np.ones(planets), np.cos(angle), np.sin(angle)])
    return np.asarray(rows @ np.linalg.pinv(rows) - np.eye(planets))


def five_planets(spreads: Sequence[Sequence[float]], samples: int = 2000, seed: int = 3) -> GradeColumns:
    """Entries of independent Gaussian gaps at each of five planets, grades with these spreads [F0 / k]."""
    draw = np.random.default_rng(seed).standard_normal((len(spreads), samples, 5))
    loads = draw @ floating_sun(5).T
    change = [np.stack([spread * one for spread in row]) for row, one in zip(spreads, loads, strict=True)]
    return GradeColumns.of(np.ones((samples, 5)), change)


def brute(columns: GradeColumns, prices: Sequence[Sequence[float]], target: float, probability: float) -> float:
    """Least price of all combinations that meet the target, each with its loads summed in full."""
    best = math.inf
    for grades in product(*(range(len(row)) for row in prices)):
        loads = columns.base + sum(one[grade] for one, grade in zip(columns.change, grades, strict=True))
        if np.mean(loads.max(axis=1) <= target) >= probability - 1e-12:
            best = min(best, sum(row[grade] for row, grade in zip(prices, grades, strict=True)))
    return best


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("probability", [0.5, 0.9, 0.99])
def test_the_cheapest_of_all_combinations_is_found_and_proven(seed: int, probability: float) -> None:
    random = np.random.default_rng(seed)
    counts = random.integers(2, 5, size=4)
    spreads = [np.sort(random.uniform(0.01, 0.3, size=count)).tolist() for count in counts]
    prices = [np.sort(random.uniform(0, 10, size=count))[::-1].tolist() for count in counts]
    columns = five_planets(spreads, seed=seed)
    ends = columns.value((0,) * 4, probability), columns.value(tuple(c - 1 for c in counts), probability)
    for share in (0.15, 0.4, 0.8):
        target = ends[0] + share * (ends[1] - ends[0])
        found = allocate_grades(columns, prices, target, probability, most=1000, most_proof=10_000)
        assert found.price == pytest.approx(brute(columns, prices, target, probability), rel=1e-12)
        assert (found.proof, found.bound) == ("samples", found.price)
        assert found.combination is not None
        assert columns.value(found.combination, probability) <= target


def test_prices_that_lead_a_greedy_choice_astray() -> None:
    # one entry saves 10, each of two others 9 with less effect together: greedy takes the 10 and can take nothing more
    columns = five_planets([(0.05, 0.20), (0.05, 0.13), (0.05, 0.13)], samples=4000)
    prices = [(20.0, 10.0), (20.0, 11.0), (20.0, 11.0)]
    one, two = columns.value((1, 0, 0), 0.95), columns.value((0, 1, 1), 0.95)
    target = max(one, two) * (1 + 1e-9)
    found = allocate_grades(columns, prices, target, 0.95, most=100, most_proof=100)
    assert (found.first, found.combination) == ((1, 0, 0), (0, 1, 1))
    assert found.price == brute(columns, prices, target, 0.95) == 42.0


def test_a_coarser_grade_that_helps_is_found_by_the_proof_and_named() -> None:
    # the coarse grade of the second entry takes load off the mesh that the first one loads
    columns = five_planets([(0.10, 0.20)], samples=1000)
    helps = np.stack([0 * columns.change[0][1], -0.8 * columns.change[0][1]])
    both = GradeColumns.of(columns.base, [*columns.change, helps])
    prices = [(9.0, 1.0), (4.0, 3.0)]
    target = both.value((1, 1), 0.99)
    assert both.value((1, 0), 0.99) > target
    found = allocate_grades(both, prices, target, 0.99, most=100, most_proof=100)
    assert (found.combination, found.price, found.proof) == ((1, 1), 4.0, "samples")
    compared, failed = not_monotone(both, prices, [(0, 0), (1, 1)], 0.99)
    assert compared == 4
    assert (1, 0, (1, 1)) in failed


def test_the_bound_in_every_sample_is_below_all_combinations_of_the_part() -> None:
    columns = five_planets([(0.05, 0.1, 0.2), (0.02, 0.1), (0.1, 0.12, 0.3)], samples=500)
    counts = (3, 2, 3)
    target = columns.value((1, 1, 1), 0.9)
    excluded = 0
    for part in product(*(range(-1, count) for count in counts)):
        if columns.meets(part, target, 0.9):
            continue
        excluded += -1 in part
        free = (range(count) if grade < 0 else (grade,) for grade, count in zip(part, counts, strict=True))
        assert all(columns.value(whole, 0.9) > target for whole in product(*free))
    assert excluded  # else the test says nothing


def test_a_target_out_of_reach_gives_nothing_and_a_search_cut_short_says_so() -> None:
    columns = five_planets([(0.1, 0.2)] * 5, samples=1000)
    prices = [(5.0 + 0.1 * i, 1.0 + 0.07 * i) for i in range(5)]
    least = columns.value((0,) * 5, 0.99)
    none = allocate_grades(columns, prices, 0.999 * least, 0.99, most=100, most_proof=1000)
    assert (none.combination, none.price) == (None, math.inf)
    target = columns.value((0, 1, 0, 1, 1), 0.99)
    short = allocate_grades(columns, prices, target, 0.99, most=2)
    whole = allocate_grades(columns, prices, target, 0.99, most=100, most_proof=1000)
    assert short.proof == "open"
    assert short.bound < whole.price <= short.price


def test_without_proof_the_answer_rests_on_monotone_grades() -> None:
    columns = five_planets([(0.1, 0.2), (0.1, 0.3)], samples=500)
    found = allocate_grades(columns, [(3.0, 1.0), (3.0, 1.0)], 10.0, 0.9, most=100)
    assert (found.combination, found.proof) == ((1, 1), "monotone")


def test_one_entry_of_four_planets_follows_the_half_normal_distribution() -> None:
    # four planets, Gaussian gaps: K - 1 = |N(0, sigma / 2)|, so that q99 = 1 + 2.5758 sigma / 2 decides the grade
    deviate = NormalDist().inv_cdf(0.995)
    spreads = np.array([0.04, 0.08, 0.12, 0.16])
    draw = np.random.default_rng(1).standard_normal((200_000, 4)) @ floating_sun(4).T
    columns = GradeColumns.of(np.ones((len(draw), 4)), [np.stack([spread * draw for spread in spreads])])
    for grade, spread in enumerate(spreads):
        expected = 1 + deviate * spread / 2
        assert columns.value((grade,), 0.99) - 1 == pytest.approx(expected - 1, rel=0.02)
        target = 1 + 1.03 * (expected - 1)
        found = allocate_grades(columns, [(8.0, 4.0, 2.0, 1.0)], target, 0.99, most=10, most_proof=10)
        assert found.combination == (grade,)


def test_neighbours_change_one_entry_by_one_grade() -> None:
    assert list(neighbours([(3.0, 2.0, 1.0), (2.0, 1.0)], (1, 0))) == [(0, -1, (0, 0)), (0, 1, (2, 0)), (1, 1, (1, 1))]


def test_the_order_statistic_leaves_as_many_above_as_are_allowed() -> None:
    values = np.random.default_rng(5).permutation(np.arange(1.0, 16385.0))
    for probability in (0.5, 0.9, 0.99, 0.999, 0.9999999):
        value = order_statistic(values, np.full(len(values), 1 / len(values)), probability)
        assert np.mean(values <= value) >= probability or probability > 1 - 1 / len(values)
        assert np.mean(values <= value - 1) < probability
        most = min(len(values) - 1, int(len(values) * allowed_above(probability)))
        assert np.count_nonzero(values > value) == most


def test_over_cases_the_time_above_the_target_counts() -> None:
    slow, fast = (five_planets([(0.05, 0.1, 0.2)] * 3, seed=seed) for seed in (1, 2))
    prices, probability = [(9.0, 4.0, 1.0)] * 3, 0.95
    alone = allocate_grades(slow, prices, 1.2, probability, most=1000, most_proof=1000)
    one = DutyGrades(parts=(slow,), share=(1.0,))
    assert allocate_grades(one, prices, 1.2, probability, most=1000, most_proof=1000) == alone
    duty = DutyGrades(parts=(slow, fast), share=(0.7, 0.3))
    found = allocate_grades(duty, prices, 1.2, probability, most=1000, most_proof=1000)
    best, value = math.inf, {}
    for grades in product(range(3), repeat=3):
        above = []
        for part in (slow, fast):
            loads = part.base + sum(column[grade] for column, grade in zip(part.change, grades, strict=True))
            above.append(loads.max(axis=1))
        if 0.7 * np.mean(above[0] > 1.2) + 0.3 * np.mean(above[1] > 1.2) <= 1 - probability:
            best = min(best, sum(row[grade] for row, grade in zip(prices, grades, strict=True)))
        weight = np.repeat([0.7 / 2000, 0.3 / 2000], 2000)
        value[grades] = np.concatenate(above), weight
    assert (found.price, found.proof) == (best, "samples")
    assert found.combination is not None
    factors, weight = value[found.combination]
    least = duty.value(found.combination, probability)
    assert weight[factors > least].sum() <= 1 - probability + 1e-9 < weight[factors >= least].sum()
    assert weight[factors > least].sum() == pytest.approx(duty.above(found.combination, least, math.inf))
