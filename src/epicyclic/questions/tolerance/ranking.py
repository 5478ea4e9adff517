"""Which tolerance counts: shares in the variance of K_gamma, what a tenth less spread takes off its quantiles, places.

All estimates are of independent scrambles of one low-discrepancy sequence.  Their bands are by the jackknife over the
scrambles: an estimate of all of them, and one without each, between which Student's t holds.  Nothing is clipped:
shares below 0 or above 1 are what the samples gave, and their bands say how far from it the share may be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from ...engine.plan import SamplingPlan, scramble_uniforms
from .statistics import CONFIDENCE, Band

Array = NDArray[np.float64]

NARROWED = 0.9
"""Factor on the spread of a tolerance that a tenth less makes of it."""
# Ranks about a quantile that its change is read from: half as many on each side as lie beyond it, of a middle quantile
# a fiftieth of all; part of them whose mean is the quantile.  A single rank would follow a single sample.
_BESIDE, _MOST_BESIDE, _NEAREST = 0.5, 0.02, 0.25
# Samples beyond a quantile of which a change is given, and the change that is rounding of load factors about 1.
_LEAST_BEYOND, _ROUNDING = 8, 1e-12


class Shares(NamedTuple):
    """Shares of the variance, each (..., E) [1]; nan where there is no variance.

    first : of a group alone.  total : of a group with all its interactions; totals of groups that interact overlap and
    add up to more than 1.
    """

    first: Band
    total: Band


def jackknife(whole: Array, without: Array) -> Band:
    """Band of an estimate of R independent blocks; whole : (...) of all of them.  without : (R, ...) of all but one."""
    blocks = len(without)
    if blocks < 2:
        unknown = np.full(np.shape(whole), np.nan)
        return Band(whole, unknown, unknown)
    spread = np.sqrt((blocks - 1) * without.var(axis=0))
    half = stdtrit(blocks - 1, 1 - (1 - CONFIDENCE) / 2) * spread
    return Band(whole, whole - half, whole + half)


def variance_shares(
    evaluate: Callable[[Array], Array], group: NDArray[np.int64], plan: SamplingPlan, *, groups: int
) -> Shares:
    """Shares of groups of uniforms in the variance of scalars, by pick and freeze, with 95 % bands.

    Of two independent points of a low-discrepancy sequence, a and b, the uniforms of one group at a time are exchanged:
    E + 2 evaluations give the shares of E groups.  First order by Saltelli's estimator with centred values
    [saltelli2010], total by Jansen's [jansen1999].

    Parameters
    ----------
    evaluate : (S, d) uniforms -> (S, ...) scalars; rows with nan are left out.
    group : (d,) group of each uniform, from 0.  groups : number of groups E.
    plan : of the scrambles.
    """
    uniforms = np.concatenate([scramble_uniforms(plan, i, 2 * group.size) for i in range(plan.scrambles)])
    first, second = uniforms[:, : group.size], uniforms[:, group.size :]
    exchanged = [np.where(group == number, second, first) for number in range(groups)]
    values = np.stack([evaluate(u) for u in (first, second, *exchanged)])
    known = np.isfinite(values).all(axis=tuple(i for i in range(values.ndim) if i != 1))
    if not known.any():
        empty = np.full((*values.shape[2:], groups), np.nan)
        return Shares(Band(empty, empty, empty), Band(empty, empty, empty))
    centre = values[:2, known].mean(axis=(0, 1))
    values = np.where(known.reshape(-1, *[1] * (values.ndim - 2)), values - centre, 0.0)
    a, b, change = values[0], values[1], np.moveaxis(values[2:] - values[0], 0, -1)

    def summed(terms: Array) -> Array:
        """Sums over each scramble (R, ...)."""
        return np.asarray(terms.reshape(plan.scrambles, plan.rows, *terms.shape[1:]).sum(axis=1))

    count = summed(known.astype(float)).reshape(-1, *[1] * (change.ndim - 1))
    of_both = [summed(terms)[..., None] for terms in (a + b, a**2 + b**2)]
    of_change = [summed(terms) for terms in (change, b[..., None] * change, change**2)]
    sums = [count, *of_both, *of_change]
    totals = [terms.sum(axis=0) for terms in sums]
    whole = _shares(totals)
    without = _shares([total - terms for total, terms in zip(totals, sums, strict=True)])
    # less than rounding of the values themselves is no variance
    nothing = np.square(values[:2]).sum(axis=(0, 1)) / known.sum() <= 2 * (1e-12 * np.abs(centre)) ** 2
    bands = [
        jackknife(np.where(nothing[..., None], np.nan, one), rest) for one, rest in zip(whole, without, strict=True)
    ]
    return Shares(*bands)


def _shares(sums: Sequence[Array]) -> tuple[Array, Array]:
    """First-order and total shares of sums: samples, a + b, a^2 + b^2, change, b times the change, its square."""
    count, both, square, change, product, size = sums
    with np.errstate(divide="ignore", invalid="ignore"):  # no variance, or one scramble and none beside it
        mean = both / (2 * count)
        variance = square / (2 * count) - mean**2
        return (product - mean * change) / count / variance, size / (2 * count) / variance


def quantile_changes(before: Array, after: Array, probability: Array, scrambles: int) -> Band:
    """Change of quantiles between two results of the same samples, (..., P), with 95 % bands.

    Of ranks about the quantile the distances between the two ordered results are fitted by a line over the first of
    them, which is read at the quantile: where all values are stretched about one point the line has no bias.

    Parameters
    ----------
    before, after : (S, ...) of the scrambles one behind the other; rows with nan are left out.  probability : (P,).
    """
    rows = np.isfinite(before) & np.isfinite(after)
    known = rows.all(axis=tuple(range(1, rows.ndim)))
    shape = (*before.shape[1:], probability.size)
    if not known.any():
        return jackknife(np.full(shape, np.nan), np.full((scrambles, *shape), np.nan))
    block = np.repeat(np.arange(scrambles), len(before) // scrambles)[known]
    first, second = (values[known].reshape(len(block), -1).T for values in (before, after))
    told = (1 - probability) * len(block) >= _LEAST_BEYOND
    orders = [np.argsort(values, axis=1, kind="stable") for values in (first, second)]
    ordered = [np.take_along_axis(values, order, axis=1) for values, order in zip((first, second), orders, strict=True)]
    blocks = [block[order] for order in orders]

    def left_out(i: int) -> Array:
        before, after = (values[of != i].reshape(len(values), -1) for values, of in zip(ordered, blocks, strict=True))
        return _changes(before, after, probability, told)

    whole = _changes(ordered[0], ordered[1], probability, told).reshape(shape)
    return jackknife(whole, np.array([left_out(i).reshape(shape) for i in range(scrambles)]))


def _changes(before: Array, after: Array, probability: Array, told: NDArray[np.bool_]) -> Array:
    """Changes of quantiles (Q, P) from values in their order, (Q, S) each; nan of those that are not told."""
    count = before.shape[1]
    changes = np.full((len(before), probability.size), np.nan)
    for i in np.flatnonzero(told):
        p = float(probability[i])
        beside = min(_BESIDE * (1 - p), _MOST_BESIDE)
        ranks, nearest = (
            slice(math.floor((p - width) * count), math.ceil((p + width) * count))
            for width in (beside, _NEAREST * beside)
        )
        x, distance = before[:, ranks], after[:, ranks] - before[:, ranks]
        middle = x.mean(axis=1, keepdims=True)
        spread = np.square(x - middle).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.where(spread > 0, ((x - middle) * distance).sum(axis=1) / spread, 0.0)
        change = distance.mean(axis=1) + slope * (before[:, nearest].mean(axis=1) - middle[:, 0])
        changes[:, i] = np.where(np.abs(change) < _ROUNDING, 0.0, change)
    return changes


def places(band: Band) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last place (E,), from 1, of entries by their change, the largest fall first.

    Entries whose bands overlap that of the first of them are tied and have the same places.  An unknown change is none.
    """
    value, low, high = map(np.nan_to_num, band)
    order = np.argsort(value, kind="stable")
    first, last = np.zeros(len(value), np.int64), np.zeros(len(value), np.int64)
    start = 0
    while start < len(order):
        together = 1
        while start + together < len(order) and low[order[start + together]] <= high[order[start]]:
            together += 1
        tied = order[start : start + together]
        first[tied], last[tied] = start + 1, start + together
        start += together
    return first, last
