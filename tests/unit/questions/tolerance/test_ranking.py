"""Bands of shares and of what a tenth less takes off, where both are known; places that bands tell apart."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ndtri

import epicyclic
from epicyclic.cockpit.computing.job_kinds import JOBS
from epicyclic.engine.plan import Sampler, SamplingPlan, scramble_uniforms
from epicyclic.questions.tolerance import ToleranceOptions, effects
from epicyclic.questions.tolerance.effects import NARROWED, places, quantile_changes, variance_shares
from epicyclic.questions.tolerance.statistics import Band

Array = NDArray[np.float64]
SEEDS = 240
PLAN = SamplingPlan(samples=2**10, scrambles=16, rows=2**6, seed=1, sampler="sobol")
# numbers of the function of Sobol, its product of (|4 u - 2| + a) / (1 + a): shares have a closed form
A = np.array([0.0, 1.0, 4.5, 9.0])


def covered(bands: list[Band], truth: Array) -> Array:
    """Share of the bands that hold the truth, each entry by itself."""
    return np.asarray(np.mean([(band.low <= truth) & (truth <= band.high) for band in bands], axis=0))


def within_its_own_error(share: Array) -> bool:
    """Whether shares of `SEEDS` bands are 95 % but for three deviations of their binomial number."""
    return bool(np.all(np.abs(share - 0.95) <= 3 * math.sqrt(0.95 * 0.05 / SEEDS)))


def plans(sampler: Sampler) -> list[SamplingPlan]:
    return [replace(PLAN, seed=seed, sampler=sampler) for seed in range(SEEDS)]


@pytest.mark.parametrize("sampler", ["sobol", "random"])
def test_bands_of_shares_hold_the_shares_of_a_product(sampler: Sampler) -> None:
    part = 1 / (3 * (1 + A) ** 2)
    whole = np.prod(1 + part) - 1
    first, total = part / whole, part * np.prod(1 + part) / (1 + part) / whole

    def product(u: Array) -> Array:
        return np.asarray(np.prod((np.abs(4 * u - 2) + A) / (1 + A), axis=1))

    found = [variance_shares(product, np.arange(4), plan, groups=4) for plan in plans(sampler)]
    assert total.sum() > 1.05
    assert within_its_own_error(covered([one.first for one in found], first))
    assert within_its_own_error(covered([one.total for one in found], total))


@pytest.mark.parametrize("spread", [(1.0,), (1.0, 0.7), (1.0, 3.0)])
def test_bands_of_a_tenth_less_hold_the_change_of_a_quantile(spread: tuple[float, ...]) -> None:
    """K - 1 is the size of a normal number, as of four planets: of its variance a part shrinks, or all of it."""
    plan, weights = replace(PLAN, rows=2**9, samples=2**13), np.array(spread)
    narrowed = weights * np.where(np.arange(len(spread)) == 0, NARROWED, 1.0)
    p = np.array([0.5, 0.99])
    truth = ndtri((1 + p) / 2) * (np.hypot.reduce(narrowed) - np.hypot.reduce(weights))
    found = []
    for seed in range(SEEDS):
        own = replace(plan, seed=seed, sampler="random")
        x = ndtri(np.concatenate([scramble_uniforms(own, i, len(spread)) for i in range(own.scrambles)]))
        before, after = (1 + np.abs(x @ size) for size in (weights, narrowed))
        found.append(quantile_changes(before, after, p, own.scrambles))
    assert within_its_own_error(covered(found, truth))


def test_quantiles_with_few_samples_beyond_have_no_change_and_failed_samples_count_nowhere() -> None:
    u = np.concatenate([scramble_uniforms(PLAN, i, 1) for i in range(PLAN.scrambles)])[:, 0]
    whole = quantile_changes(u, 0.9 * u, np.array([0.5, 0.99, 0.999]), PLAN.scrambles)
    assert whole.value[:2] == pytest.approx([-0.05, -0.099], abs=2e-3)
    assert np.isnan(whole.value[2])
    assert np.isnan(whole.low[2])
    rounding = quantile_changes(u, u * (1 + 1e-16), np.array([0.5]), PLAN.scrambles)
    assert [float(ends[0]) for ends in (rounding.value, rounding.low, rounding.high)] == [0, 0, 0]
    some = np.where(np.arange(len(u)) % 7 == 0, np.nan, u)
    assert quantile_changes(some, 0.9 * u, np.array([0.5]), PLAN.scrambles).value == pytest.approx([-0.05], abs=5e-3)


def test_shares_are_given_as_they_are_estimated() -> None:
    """One group has all of the variance: of few samples its estimate is more or less, and its band holds all."""
    few = replace(PLAN, samples=2**9, rows=2**5, sampler="random")
    found = [
        variance_shares(lambda u: ndtri(u[:, 0]), np.zeros(1, int), replace(few, seed=i), groups=1) for i in range(8)
    ]
    values = np.array([one.total.value[0] for one in found])
    assert values.max() > 1 > values.min()
    assert np.mean([one.total.low[0] <= 1 <= one.total.high[0] for one in found]) > 0.5


def test_entries_whose_bands_overlap_are_tied() -> None:
    value = np.array([-1.0, -3.0, 0.0, -2.5, np.nan, -0.4])
    half = np.array([0.2, 0.4, 0.0, 0.2, np.nan, 0.3])
    first, last = places(Band(value=value, low=value - half, high=value + half))
    assert first.tolist() == [3, 1, 5, 1, 5, 4]
    assert last.tolist() == [3, 2, 6, 2, 6, 4]


@pytest.mark.parametrize("drive", ["ren2021", "wind-stage", "wind-five", "industrial-stage"])
def test_page_and_command_rank_alike_at_their_own_numbers_of_samples(
    drive: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As any two numbers of samples do above that of the ranking, which is an eighth of what it is."""
    job, command = JOBS["tolerance"].defaults["samples"], ToleranceOptions().samples
    assert effects._RANKED < job < command
    monkeypatch.setattr(effects, "_RANKED", effects._RANKED // 8)
    page, printed = (epicyclic.tolerance(drive, samples=samples, effects="shares") for samples in (2**13, 2**14))
    for name in ("system_tenth_less", "tenth_less_place", "tenth_less_last_place", "sobol_total_high"):
        np.testing.assert_array_equal(page[name].values, printed[name].values)
    assert page.attrs["ranking_samples"] == printed.attrs["ranking_samples"] == effects._RANKED
    changed = page.system_tenth_less.sel(definition="mean-load", probability=0.99).values
    assert np.all(np.diff(changed[np.argsort(page.tenth_less_place.values, kind="stable")].round(12)) >= -1e-3)
    assert page.tenth_less_place.values[np.argmin(changed)] == 1


def test_what_a_tenth_less_takes_off_is_what_the_narrower_drawing_has() -> None:
    """The drawing with that spread a tenth smaller, sampled by itself."""
    drawn = epicyclic.tolerance("wind-five", samples=2**15, effects="shares")
    narrow = {'tolerance."deviations.planet.position"': "disc(63 um)"}
    then = epicyclic.tolerance("wind-five", samples=2**15, effects="none", overrides=narrow)
    at = {"definition": "mean-load", "probability": 0.99}
    change = float(then.system_k_gamma_quantile.sel(at) - drawn.system_k_gamma_quantile.sel(at))
    entry = list(drawn.tolerance.values).index("deviations.main.planet.position")
    low, high = (float(drawn[f"system_tenth_less_{end}"].sel(at)[entry]) for end in ("low", "high"))
    assert low - 2e-4 <= change <= high + 2e-4  # the two runs have bands of their own
