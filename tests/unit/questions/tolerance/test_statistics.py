"""Statistics of tolerance samples against closed forms (floating sun, Gaussian pins) and against sorted samples."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from floating_sun import FloatingSun
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from epicyclic.engine.plan import Sampler, piece_uniforms, sampling_plan
from epicyclic.questions.tolerance.statistics import (
    BINS,
    FAILED,
    SampleTally,
    bin_edges,
    bin_index,
    coarse_edges,
    coarse_index,
    fraction_below,
    occupied,
    packed,
    piece_statistics,
    probabilities_of,
    quantiles,
    unpacked,
)

Array = NDArray[np.float64]


@functools.cache
def tally_of(
    samples: int, *, count: int = 4, spread: float = 1.0, seed: int = 1, sampler: Sampler = "sobol", meshes: bool = True
) -> SampleTally:
    """Samples of a floating sun; one definition without meshes where the test needs no more: most of the work."""
    plan, drawn = sampling_plan(samples, seed=seed, sampler=sampler), FloatingSun(count, spread)
    tally = SampleTally(plan=plan, definitions=2 if meshes else 1, groups=1, meshes=count if meshes else 0)
    for piece in range(plan.pieces):
        values = drawn.evaluate(piece_uniforms(plan, piece, count))
        if not meshes:
            values = values._replace(k=values.k[:, :1], load=values.load[:, :1, :0], least=values.least[:, :0])
        tally.add(piece, piece_statistics(values, plan, piece))
    return tally


def excess_of_four(probability: float) -> float:
    """Quantile of K - 1 of four planets with sigma k / F0 = 1: half a half-normal."""
    return float(0.5 * ndtri((1 + probability) / 2))


def test_bins_hold_their_values() -> None:
    rng = np.random.default_rng(3)
    values = 1 + rng.choice([-1, 1], 20_000) * 10.0 ** rng.uniform(-11, 3.5, 20_000)
    values = np.concatenate([values, [1.0, -np.inf, np.inf, 2.0, 0.0]])
    index, edges = bin_index(values), bin_edges()
    assert edges.size == BINS + 1
    assert (np.diff(edges) > 0).all()
    assert index.dtype == np.int32
    # rounding of the logarithm may move a value that stands at an edge by one bin
    inside = (edges[index] <= values) & (values <= edges[index + 1])
    assert inside.mean() > 0.9999
    near = np.abs(np.searchsorted(edges, values, side="right") - 1 - index)
    assert near[np.isfinite(values)].max() <= 1
    assert bin_index(np.array([np.nan])) == FAILED
    inner = edges[1:-1]
    assert np.max(np.diff(inner) / np.maximum(np.abs(inner[1:] - 1), 2e-9)) <= 1.001e-4 or np.isclose(
        np.max(np.diff(inner) / np.maximum(np.abs(inner[1:] - 1), 2e-9)), 1.0
    )


def test_histograms_are_packed_and_unpacked() -> None:
    index = bin_index(1 + np.random.default_rng(1).standard_normal((3, 500)))
    assert np.array_equal(unpacked(packed(index)), np.sort(index))


def test_coarse_bins_hold_the_fine_ones() -> None:
    edges, coarse = bin_edges(), coarse_edges()
    index = np.arange(BINS, dtype=np.int32)
    assert (coarse[coarse_index(index)] <= edges[:-1]).all()
    assert (coarse[coarse_index(index) + 1] >= edges[1:]).all()


def test_quantiles_of_the_histogram_are_those_of_the_samples() -> None:
    tally = tally_of(2**14)
    plan, drawn = tally.plan, FloatingSun(4)
    k = np.concatenate([drawn.evaluate(piece_uniforms(plan, i, 4)).k[:, 0, 0] for i in range(plan.pieces)])
    probability = probabilities_of(plan.samples)
    below = np.sort(k)[np.ceil(probability * k.size).astype(int) - 1]
    found = tally.quantile_bands(probability).value
    # linear within a bin and between samples: within a bin of the samples beside it
    above = np.sort(k)[np.minimum(np.ceil(probability * k.size).astype(int), k.size - 1)]
    for quantity in (0, 1):  # of the pair and of the train, which is the same here
        excess = found[0, quantity] - 1
        assert (excess >= (below - 1) * (1 - 1e-4)).all()
        assert (excess <= (above - 1) * (1 + 1e-4)).all()
    mean, spread = tally.mean_and_deviation()
    assert mean[0, 0] == pytest.approx(k.mean(), rel=1e-13)
    assert spread[0, 0] == pytest.approx(k.std(ddof=1), rel=1e-10)


@pytest.mark.parametrize(
    ("count", "mean", "deviation", "expected"),
    [
        (4, 0.399, 0.302, (0.337, 0.980, 1.288)),
        (5, 0.741, 0.391, (0.694, 1.456, 1.816)),
        (6, 0.924, 0.417, (0.877, 1.682, 2.071)),
        (7, 1.060, 0.430, (1.012, 1.843, 2.253)),
    ],
)
def test_gaussian_pins(count: int, mean: float, deviation: float, expected: tuple[float, ...]) -> None:
    tally = tally_of(2**16, count=count, meshes=False)
    band = tally.quantile_bands(np.array([0.5, 0.95, 0.99]))
    half = (band.high - band.low)[0, 1] / 2
    assert np.abs(band.value[0, 1] - 1 - expected) == pytest.approx(0, abs=2 * half.max() + 5e-4)
    found, spread = tally.mean_and_deviation()
    assert (found[0, -1] - 1, spread[0, -1]) == pytest.approx((mean, deviation), abs=2e-3)


@pytest.mark.parametrize("sampler", ["sobol", "random"])
def test_bands_hold_the_true_quantile_as_often_as_they_say(sampler: Sampler) -> None:
    probability = np.array([0.5, 0.95, 0.99])
    true = 1 + np.array([excess_of_four(p) for p in probability])
    held = []
    limits = 1 + np.array([0.15, 0.5, 1.0])
    exceeded = 2 * ndtr(-2 * (limits - 1))
    for seed in range(40):
        tally = tally_of(2**11, seed=seed, sampler=sampler, meshes=False)
        band, above = tally.quantile_bands(probability), tally.exceedance(limits)
        held.append((band.low[0, 0] <= true) & (true <= band.high[0, 0]))
        held.append((above.low[0, 0] <= exceeded) & (exceeded <= above.high[0, 0]))
    # 240 bands of 95 %: 12 misses expected, and those of one draw go together
    assert 0.90 <= np.mean(held) <= 0.99


@pytest.mark.parametrize(("sampler", "fastest", "slowest"), [("sobol", -0.75, -0.45), ("random", -0.56, -0.44)])
def test_bands_shrink_with_the_root_of_the_samples(sampler: Sampler, fastest: float, slowest: float) -> None:
    sizes = [2**10, 2**12, 2**14]
    widths, errors = [], []
    true = 1 + excess_of_four(0.95)
    for size in sizes:
        bands = [
            tally_of(size, seed=seed, sampler=sampler, meshes=False).quantile_bands(np.array([0.95]))
            for seed in range(4)
        ]
        widths.append(np.mean([band.high[0, 0, 0] - band.low[0, 0, 0] for band in bands]))
        errors.append(max(abs(band.value[0, 0, 0] - true) / (band.high[0, 0, 0] - band.low[0, 0, 0]) for band in bands))
    exponent = np.polyfit(np.log(sizes), np.log(widths), 1)[0]
    assert fastest <= exponent <= slowest
    assert max(errors) < 1.0  # none is off by two half widths


def test_sobol_bands_are_narrower_than_random_ones() -> None:
    probability = np.array([0.5, 0.95])
    width = [
        np.mean([np.ptp([band.low[0, 0], band.high[0, 0]], axis=0) for band in bands])
        for bands in (
            [tally_of(2**14, seed=seed, sampler=sampler, meshes=False).quantile_bands(probability) for seed in range(4)]
            for sampler in ("sobol", "random")
        )
    ]
    assert 1.2 < width[1] / width[0] < 3.0


def test_separation_of_four_planets() -> None:
    tally = tally_of(2**15, spread=1.25)
    band = tally.separation()
    expected = 2 * ndtr(-2 / 1.25)
    assert band.low[-1] <= expected <= band.high[-1]
    assert band.high[-1] - band.low[-1] < 4 * math.sqrt(expected * (1 - expected) / 2**15)  # of independent samples
    assert band.value[:-1] == pytest.approx(expected / 2, abs=2e-3)  # each mesh at one of both signs


def test_exceedance() -> None:
    limits = np.array([1.0, 1.15, 1.5, 2.0, 5.0])
    expected = 2 * ndtr(-2 * (limits - 1))
    band = tally_of(2**14).exceedance(limits)
    assert band.value.shape == (2, 2, 5)
    assert np.abs(band.value[0, 0] - expected).max() < 3 * math.sqrt(0.25 / 2**14)
    # never seen: what so many independent samples leave possible
    assert band.value[0, 0, -1] == 0
    assert band.high[0, 0, -1] == pytest.approx(1 - 0.025 ** (1 / 2**14), rel=1e-6)


def test_worst_samples_are_ordered_by_value_and_number() -> None:
    tally = tally_of(2**14)
    plan, drawn = tally.plan, FloatingSun(4)
    k = np.concatenate([drawn.evaluate(piece_uniforms(plan, i, 4)).k[:, 0, 0] for i in range(plan.pieces)])
    value, number = tally.worst()
    assert np.array_equal(number, np.lexsort((np.arange(k.size), -k))[:10])
    assert np.array_equal(value, k[number])


def test_ties_of_the_worst_go_to_the_first() -> None:
    tally = tally_of(2**14, spread=0.0)
    value, number = tally.worst()
    assert number.tolist() == list(range(10))
    assert value == pytest.approx(1.0, abs=1e-12)


def test_loads_of_equal_meshes_without_errors_are_one() -> None:
    tally = tally_of(2**14, spread=0.0)
    band = tally.quantile_bands(probabilities_of(2**14))
    for values in (band.value, band.low, band.high):
        assert values == pytest.approx(1.0, abs=1e-9)


def test_failed_samples_count_nowhere() -> None:
    plan, drawn = sampling_plan(2**13), FloatingSun(4)
    values = drawn.evaluate(piece_uniforms(plan, 0, 4))
    values.failed[::4] = True
    values.k[::4] = values.load[::4] = np.nan
    tally = SampleTally(plan=plan, definitions=2, groups=1, meshes=4)
    tally.add(0, piece_statistics(values, plan, 0))
    assert (tally.failed, tally.done) == (2048, 8192)
    left = values.k[~values.failed, 0, 0]
    found, spread = tally.mean_and_deviation()
    assert (found[0, 0], spread[0, 0]) == pytest.approx((left.mean(), left.std(ddof=1)), rel=1e-10)
    assert tally.quantile_bands(np.array([0.5])).value[0, 0, 0] == pytest.approx(np.median(left), rel=1e-3)
    assert int(tally.histogram()[1].sum()) == 2 * 2 * 6144


def test_the_histogram_shown_holds_every_sample() -> None:
    tally = tally_of(2**14)
    edges, counts = tally.histogram()
    assert counts.shape == (2, 2, edges.size - 1)
    assert (counts.sum(axis=-1) == 2**14).all()
    middle = (edges[:-1] + edges[1:]) / 2
    assert np.sum(middle * counts[0, 0]) / 2**14 == pytest.approx(1.399, abs=0.01)


def test_probabilities_follow_the_number_of_samples() -> None:
    assert probabilities_of(256).tolist() == [0.5, 0.9, 0.95]
    assert probabilities_of(1024).tolist() == [0.5, 0.9, 0.95, 0.99]
    assert probabilities_of(8192).tolist() == [0.5, 0.9, 0.95, 0.99, 0.999]


def test_fractions_and_quantiles_are_inverse() -> None:
    counts = np.zeros(BINS, np.int64)
    np.add.at(counts, bin_index(1 + np.abs(np.random.default_rng(0).standard_normal(5000))), 1)
    probability = np.array([0.01, 0.3, 0.77, 0.999])
    value = quantiles(occupied(counts, bin_edges()), probability)
    assert fraction_below(counts[None], bin_edges(), value)[0] == pytest.approx(probability, abs=1e-9)
    assert math.isnan(quantiles(occupied(np.zeros(BINS, np.int64), bin_edges()), np.array([0.5]))[0])
