"""Integer histograms of load ratios with fixed edges, fine enough that quantiles are read from them.

Bins stand in logarithmic steps of |x - 1|, on both sides of 1: relative width `WIDTH` from 1e-9 to 1e3.  A quantile
read from them is off by at most `WIDTH` of |x - 1|.  Counts are integers, so that they add up to the same in any order.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
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
