"""Variance shares by pick and freeze: how much of the variance of a scalar each group of uniforms brings.

Of two independent points of a low-discrepancy sequence, a and b, the uniforms of one group at a time are exchanged:
E + 2 evaluations give the first-order and total shares of E groups.  First order by Saltelli's estimator with centred
values [saltelli2010], total by Jansen's [jansen1999].

Integer histograms of load ratios with fixed edges, fine enough that quantiles are read from them.

Bins stand in logarithmic steps of |x - 1|, on both sides of 1: relative width `WIDTH` from 1e-9 to 1e3.  A quantile
read from them is off by at most `WIDTH` of |x - 1|.  Counts are integers, so that they add up to the same in any order.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ...engine.sampling import SamplingPlan, scramble_uniforms

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shares:
    """Shares of the variance, each (..., E) [1]; nan where there is no variance.

    first : of a group alone.  total : of a group with all its interactions.  Both lie in 0..1: an estimate beyond, by
    the samples it has, is the end.  Totals of several groups add up to more than 1 where they interact.
    """

    first: Array
    total: Array


def variance_shares(
    evaluate: Callable[[Array], Array], group: NDArray[np.int64], plan: SamplingPlan, *, groups: int
) -> Shares:
    """Shares of groups of uniforms in the variance of scalars.

    Parameters
    ----------
    evaluate : (S, d) uniforms -> (S, ...) scalars; rows with nan are left out.
    group : (d,) group of each uniform, from 0.  groups : number of groups E.
    plan : of one scramble's rows and seed.
    """
    drawn = scramble_uniforms(plan, 0, 2 * group.size)
    first, second = drawn[:, : group.size], drawn[:, group.size :]
    exchanged = [np.where(group == one, second, first) for one in range(groups)]
    values = np.stack([evaluate(u) for u in (first, second, *exchanged)])
    known = np.isfinite(values).all(axis=tuple(i for i in range(values.ndim) if i != 1))
    values = values[:, known]
    if not values.shape[1]:
        empty = np.full((*values.shape[2:], len(exchanged)), np.nan)
        return Shares(first=empty, total=empty)
    centre = values[:2].mean(axis=(0, 1))
    variance = np.square(values[:2] - centre).mean(axis=(0, 1))
    a, b, mixed = values[0], values[1] - centre, values[2:]
    # less than rounding of the values themselves is none
    nothing = variance <= (1e-12 * np.abs(centre)) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        own = (b * (mixed - a)).mean(axis=1) / variance
        total = np.square(mixed - a).mean(axis=1) / (2 * variance)
    own, total = (np.where(nothing, np.nan, np.clip(one, 0.0, 1.0)) for one in (own, total))
    return Shares(first=np.moveaxis(own, 0, -1), total=np.moveaxis(total, 0, -1))


Counts = NDArray[np.int64]
Index = NDArray[np.int32]

WIDTH = 1e-4
"""Relative width of a bin in x - 1: the error of a quantile that is read from the histogram."""

# |x - 1| below the first is the rounding of equal loads; above the second a pair hardly carries its sum at all
LEAST_EXCESS, _MOST = 1e-9, 1e3
_HALF = math.ceil(math.log(_MOST / LEAST_EXCESS) / WIDTH)
# fine bins of one of the coarse histograms, by which batches differ: a band is known to some per cent at best
_COARSE = 32

BINS = 2 * _HALF + 3
"""Bins: one below all, `_HALF` of x < 1, one about 1, `_HALF` of x > 1, one above all."""
FAILED = BINS
"""Index of a sample without value."""
COARSE_BINS = -(-BINS // _COARSE)
"""Bins of the coarse histogram: each holds 32 of the fine ones."""


def bin_index(values: Array) -> Index:
    """Bin of every value, int32 of the same shape; `FAILED` of nan."""
    distance = np.asarray(values, dtype=float) - 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        step = np.floor(np.log(np.abs(distance) / LEAST_EXCESS) / WIDTH)
        step = np.clip(step, -1, _HALF) + 1
        index = _HALF + 1 + np.sign(distance) * step
    return np.where(np.isnan(distance), FAILED, index).astype(np.int32)


@cache
def bin_edges() -> Array:
    """Edges of the bins, (BINS + 1,), the outer ones infinite; not to be written to."""
    distance = LEAST_EXCESS * np.exp(WIDTH * np.arange(_HALF + 1))
    edges = np.concatenate([[-np.inf], 1.0 - distance[::-1], 1.0 + distance, [np.inf]])
    edges.flags.writeable = False
    return edges


def coarse_index(index: Index) -> Index:
    """Coarse bin of fine ones."""
    return np.asarray(index // _COARSE, dtype=np.int32)


@cache
def coarse_edges() -> Array:
    """Edges of the coarse bins, (COARSE_BINS + 1,)."""
    edges = bin_edges()
    return np.append(edges[:-1:_COARSE], edges[-1])


def packed(index: Index) -> Index:
    """Sorted differences of indices along the last axis: a histogram of few counts, which a store compresses well."""
    return np.asarray(np.diff(np.sort(index, axis=-1), axis=-1, prepend=np.int32(0)), dtype=np.int32)


def unpacked(differences: Index) -> Index:
    """Sorted indices of what `packed` made."""
    return np.asarray(np.cumsum(differences, axis=-1, dtype=np.int32))


def occupied(counts: Counts, edges: Array) -> tuple[Counts, Array, Array]:
    """Counts (n,), lower and upper edges (n,) of the bins of one histogram that hold something."""
    used = np.flatnonzero(counts)
    return counts[used], edges[used], edges[used + 1]


def quantiles(bins: tuple[Counts, Array, Array], probability: Array) -> Array:
    """Quantiles of one histogram, linear within its bins, of the shape of `probability`; nan of an empty one.

    Parameters
    ----------
    bins : as of `occupied`.  probability : 0..1.
    """
    counts, lower, upper = bins
    if not counts.size:
        return np.full(np.shape(probability), np.nan)
    cumulated = np.cumsum(counts)
    rank = np.asarray(probability, dtype=float) * cumulated[-1]
    place = np.minimum(np.searchsorted(cumulated, rank, side="left"), counts.size - 1)
    low, high = lower[place], upper[place]
    share = 1.0 - (cumulated[place] - rank) / counts[place]
    bounded = np.isfinite(low) & np.isfinite(high)
    with np.errstate(invalid="ignore"):
        inside = low + share * (high - low)
    return np.asarray(np.where(bounded, inside, np.where(np.isfinite(low), high, low)))


def fraction_below(counts: Counts, edges: Array, value: Array) -> Array:
    """Fraction of each histogram below values, linear within the bins; nan of an empty one.

    Parameters
    ----------
    counts : (B, bins).  edges : (bins + 1,).  value : (P,), finite or infinite.

    Returns
    -------
    (B, P) [1].
    """
    used = np.flatnonzero(counts.any(axis=0))  # few of very many
    held = counts[:, used]
    cumulated = np.concatenate([np.zeros((len(counts), 1)), np.cumsum(held, axis=1)], axis=1)
    place = np.clip(np.searchsorted(edges, value, side="right") - 1, 0, len(edges) - 2)
    before = np.searchsorted(used, place)
    there = np.append(used, -1)[before] == place
    own = np.where(there, np.append(held, np.zeros((len(held), 1)), axis=1)[:, before], 0)
    low, high = edges[place], edges[place + 1]
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(np.isfinite(low) & np.isfinite(high), (value - low) / (high - low), value == np.inf)
        return np.asarray((cumulated[:, before] + share * own) / cumulated[:, -1:])


def display_histogram(counts: Counts, edges: Array, shown: Array) -> Counts:
    """Counts of one histogram in a few bins, (s,); shown : (s + 1,) edges, each one of `edges`; the outer ones hold all
    beyond."""
    place = np.searchsorted(edges, shown[1:-1])
    cumulated = np.concatenate([[0], np.cumsum(counts)])
    inner = cumulated[place]
    return np.diff(np.concatenate([[0], inner, cumulated[-1:]]))
