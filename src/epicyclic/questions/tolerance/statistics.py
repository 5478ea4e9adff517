"""Statistics of a tolerance study: integer histograms of pieces of samples, quantiles and their bands.

Bins stand in logarithmic steps of |x - 1|, on both sides of 1: relative width `WIDTH` from 1e-9 to 1e3.  A quantile
read from them is off by at most `WIDTH` of |x - 1|.  Counts are integers, so that they add up to the same in any order.

A piece leaves integer histograms, integer counts, sums and its worst samples.  Integers add up to the same in any
order; sums are added in the order of the pieces; worst samples are ordered by value and number.  Memory does not grow
with the number of samples.

Bands (95 %) of scrambles: Student's t over batches of scrambles, of the share of samples below the quantile, read back
through the distribution [woodruff1952].  Contact that opens gathers samples at the largest load there can be, which
a bin would spread over its width: of the highest bin the mean and the largest value say where its samples lie.
Bands of independent samples: order statistics (derived here).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtrik, betaincinv, stdtrit

from ...engine.plan import SamplingPlan, sample_number
from ...statics.sample_loads import SampleLoads

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
    counts : (B, bins), the outer ones without an end.  edges : (bins + 1,).  value : (P,), finite or infinite.

    Returns
    -------
    (B, P) [1].
    """
    cumulated = np.cumsum(counts, axis=1)
    below = np.array([np.interp(value, edges[1:-1], row[:-1], left=0.0) for row in cumulated])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(value == np.inf, cumulated[:, -1:], below) / cumulated[:, -1:]


def display_histogram(counts: Counts, edges: Array, shown: Array) -> Counts:
    """Counts of one histogram in a few bins, (s,); shown : (s + 1,) edges, each one of `edges`; the outer ones hold all
    beyond."""
    place = np.searchsorted(edges, shown[1:-1])
    cumulated = np.concatenate([[0], np.cumsum(counts)])
    return np.diff(np.concatenate([[0], cumulated[place], cumulated[-1:]]))


CONFIDENCE = 0.95
"""Confidence of every band."""

# Batches of scrambles between which bands are estimated: more say hardly more of their spread, and cost memory.
_BATCHES = 32
# Probabilities of quantiles, each given where so many samples lie beyond it that its band means something.
_PROBABILITIES, _BEYOND = (0.5, 0.9, 0.95, 0.99, 0.999), 8
# Worst samples kept.
_WORST = 10
# Sums of scrambles that are held before they are added up.
_HELD = 1024
# Bins of a histogram that is shown.
_SHOWN = 200


class Band(NamedTuple):
    """An estimate with the ends of its band of confidence, arrays of one shape."""

    value: Array
    low: Array
    high: Array

    def of(self, part: Callable[[Array], Array]) -> Band:
        """A part of it, or another form."""
        return Band(*map(part, self))

    def columns(self, name: str, dims: tuple[str, ...]) -> dict[str, tuple[Any, Any]]:
        """Variables of an estimate over dimensions, the ends of its band beside it."""
        return {name + end: (dims, values) for end, values in zip(("", "_low", "_high"), self, strict=True)}


def with_system(k: Array) -> Array:
    """Load factors of the groups and, last, of the train: the largest of them, (S, D, g + 1) [1]; k : (S, D, g)."""
    return np.concatenate([k, k.max(axis=2, keepdims=True)], axis=2)


def probabilities_of(samples: int) -> Array:
    """Probabilities of which so many samples give a quantile."""
    return np.array([p for p in _PROBABILITIES if samples * (1 - p) >= _BEYOND or p == _PROBABILITIES[0]])


def piece_statistics(values: SampleLoads, plan: SamplingPlan, piece: int) -> dict[str, NDArray[Any]]:
    """What a piece leaves, arrays of fixed shapes, s scrambles a piece, Q = g + 1 + w quantities (groups, the train,
    meshes).

    Returns
    -------
    bins : (s, D, Q, rows) int32, packed histograms.  top : (D Q, 3) number of the highest bin that holds any, the sum
    of x - 1 in it and the largest x - 1.  sum, square : (s, D, g + 1) of K - 1 and its square.
    apart : (s, w + 1) int64, samples with an open mesh, and with any.  open, failed : (s,) int64.
    worst, worst_sample : (10,) largest K of the first definition, and the numbers of their samples.
    """
    count = plan.together * plan.rows
    scrambled = (plan.together, plan.rows)
    failed = values.failed[:count]
    factor = np.where(failed[:, None, None], np.nan, with_system(values.k[:count]))
    load = np.where(failed[:, None, None], np.nan, values.load[:count])
    quantity = np.concatenate([factor, load], axis=2).reshape(count, -1)
    index = bin_index(quantity)
    top = _top(index, quantity)
    index = index.reshape(*scrambled, *factor.shape[1:2], -1)
    excess = np.where(np.isnan(factor), 0.0, factor - 1.0).reshape(*scrambled, *factor.shape[1:])
    apart = (values.least[:count] <= 0) & ~failed[:, None]
    apart = np.concatenate([apart, apart.any(axis=1, keepdims=True)], axis=1)
    worst, number = _worst(factor[:, 0, -1], sample_number(plan, piece))
    return {
        "bins": packed(np.ascontiguousarray(index.transpose(0, 2, 3, 1))),
        "top": top,
        "sum": excess.sum(axis=1),
        "square": np.square(excess).sum(axis=1),
        "apart": apart.reshape(*scrambled, -1).sum(axis=1, dtype=np.int64),
        "open": (values.open[:count] & ~failed).reshape(scrambled).sum(axis=1, dtype=np.int64),
        "failed": failed.reshape(scrambled).sum(axis=1, dtype=np.int64),
        "worst": worst,
        "worst_sample": number,
    }


def _top(index: NDArray[np.int32], values: Array) -> Array:
    """Highest bin that holds any of the values (S, Q), the sum of x - 1 in it and the largest, (Q, 3); -1 of none."""
    known = np.where(index < BINS, index, -1)
    highest = known.max(axis=0, initial=-1)
    inside = (known == highest) & (highest >= 0)
    excess = np.where(inside, values - 1.0, 0.0)
    largest = np.where(inside, values - 1.0, -np.inf).max(axis=0, initial=-np.inf)
    return np.stack([highest.astype(float), excess.sum(axis=0), largest], axis=1)


def _worst(value: Array, number: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """Largest values and the numbers of their samples, (10,) each: -inf and -1 where there are fewer."""
    value = np.append(np.where(np.isnan(value), -np.inf, value), np.full(_WORST, -np.inf))
    number = np.append(number, np.full(_WORST, -1, np.int64))
    number = np.where(np.isneginf(value), -1, number)
    order = np.lexsort((number, -value))[:_WORST]
    return value[order], number[order]


class SampleTally:
    """All pieces together, added one after the other.

    plan : of the samples.  definitions, groups, meshes : D, g, w.  done : samples added.
    open : of them, those in which contact opens or a link plays.  failed : those without a solution, which count
    nowhere else.
    """

    def __init__(self, *, plan: SamplingPlan, definitions: int, groups: int, meshes: int) -> None:
        self.plan, self.definitions, self.groups, self.meshes = plan, definitions, groups, meshes
        self.done = self.open = self.failed = 0
        batches, quantities = min(plan.scrambles, _BATCHES), definitions * (groups + 1 + meshes)
        # untouched pages of these take no memory: loads fill a small part of the bins
        number = np.int32 if plan.samples < 2**31 else np.int64
        self._fine: NDArray[Any] = np.zeros((quantities, BINS), number)
        self._coarse: NDArray[Any] = np.zeros((batches, quantities, COARSE_BINS), number)
        self._top: Array = np.tile([-1.0, 0.0, -np.inf], (quantities, 1))
        self._size, self._apart = np.zeros(batches, np.int64), np.zeros((batches, meshes + 1), np.int64)
        self._sums: list[Array] = []
        self._worst = np.full(_WORST, -np.inf), np.full(_WORST, -1, np.int64)

    def add(self, piece: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Add what a piece left; pieces come in their order."""
        for scramble in range(self.plan.together):
            batch = (piece * self.plan.together + scramble) % len(self._size)
            index = unpacked(arrays["bins"][scramble].reshape(len(self._fine), -1))
            _add(self._fine, index, BINS)
            _add(self._coarse[batch], coarse_index(index), COARSE_BINS)
            failed = int(arrays["failed"][scramble])
            self._size[batch] += self.plan.rows - failed
            self._apart[batch] += arrays["apart"][scramble]
            self.open += int(arrays["open"][scramble])
            self.failed += failed
            self.done += self.plan.rows
        top = arrays["top"]
        higher, same = top[:, 0] > self._top[:, 0], top[:, 0] == self._top[:, 0]
        both = np.array([self._top[:, 1] + top[:, 1], np.maximum(self._top[:, 2], top[:, 2])]).T
        self._top = np.where(higher[:, None], top, self._top)
        self._top[same, 1:] = both[same]
        # one by one: a sum of numpy depends on how its array lies in memory
        self._sums += list(np.stack([arrays["sum"], arrays["square"]], axis=1))
        if len(self._sums) >= _HELD:
            self._sums = [self._summed()]
        value, number = self._worst
        self._worst = _worst(np.append(value, arrays["worst"]), np.append(number, arrays["worst_sample"]))

    def _summed(self) -> Array:
        """Sums of K - 1 and its square, (2, D, g + 1), each rounded once."""
        stacked = np.array(self._sums)
        flat = [math.fsum(column) for column in stacked.reshape(len(stacked), -1).T.tolist()]
        return np.array(flat).reshape(stacked.shape[1:])

    def mean_and_deviation(self) -> tuple[Array, Array]:
        """Mean and standard deviation of K, (D, g + 1) [1] each, the train last; nan without samples."""
        count = self.done - self.failed
        if not count:
            empty = np.full((self.definitions, self.groups + 1), np.nan)
            return empty, empty
        total, square = self._summed()
        mean = total / count
        with np.errstate(invalid="ignore"):  # a pair without load in one sample has an infinite mean and no deviation
            spread = np.sqrt(np.maximum(square / count - mean**2, 0.0) * (count / max(count - 1, 1)))
        return 1.0 + mean, spread

    def quantile_bands(self, probability: Array) -> Band:
        """Quantiles of every quantity, (D, Q, P) [1]."""
        edges, coarse = bin_edges(), coarse_edges()
        band = np.empty((3, len(self._fine), probability.size))
        for quantity, counts in enumerate(self._fine):
            bins = self._with_top(quantity, occupied(counts, edges))
            value = quantiles(bins, probability)
            below = fraction_below(self._coarse[:, quantity], coarse, value)
            low, high = self._probability_band(probability, below)
            band[:, quantity] = value, quantiles(bins, low), quantiles(bins, high)
        value, low, high = band.reshape(3, self.definitions, -1, probability.size)
        return Band(value, np.minimum(low, value), np.maximum(high, value))

    def _with_top(self, quantity: int, bins: tuple[Counts, Array, Array]) -> tuple[Counts, Array, Array]:
        """Occupied bins of a quantity, the highest only as wide as its mean and its largest value have it."""
        counts, lower, upper = bins
        if not counts.size or not np.isfinite(upper[-1]):
            return bins
        _, total, largest = self._top[quantity]
        lower, upper = lower.copy(), upper.copy()
        lower[-1] = max(lower[-1], 1.0 + min(2 * total / counts[-1] - largest, largest))
        upper[-1] = 1.0 + largest
        return counts, lower, upper

    def _probability_band(self, probability: Array, below: Array) -> tuple[Array, Array]:
        """Probabilities whose quantiles are the ends of a band, (P,) each.

        below : (batches, P), share of the samples of each batch below the quantile.
        """
        count = max(self.done - self.failed, 1)
        tail = (1 - CONFIDENCE) / 2
        if self.plan.sampler == "random":
            # ranks between which the quantile of the population lies: numbers of a binomial distribution
            low = bdtrik(tail, count, probability) / count
            high = (bdtrik(1 - tail, count, probability) + 1) / count
        else:
            half = _half_width(below)
            low, high = probability - half, probability + half
        return np.clip(np.nan_to_num(low), 0.0, 1.0), np.clip(np.nan_to_num(high, nan=1.0), 0.0, 1.0)

    def exceedance(self, limits: Array) -> Band:
        """Probability that K is above each limit, (D, g + 1, L) [1], the train last."""
        edges, coarse = bin_edges(), coarse_edges()
        # equal shares are 1 up to rounding, which does not exceed a limit of 1
        limits = np.where(np.abs(limits - 1.0) <= LEAST_EXCESS, edges[BINS // 2 + 1], limits)
        values, batches = [], []
        quantities = np.arange(len(self._fine)).reshape(self.definitions, -1)
        for quantity in quantities[:, : self.groups + 1].ravel():
            # as many as gather at the largest value do not exceed a limit that stands there
            read = np.where(limits >= 1.0 + self._top[quantity, 2] - LEAST_EXCESS, np.inf, limits)
            values.append(1.0 - fraction_below(self._fine[quantity][None], edges, read)[0])
            batches.append(1.0 - fraction_below(self._coarse[:, quantity], coarse, read))
        shape = self.definitions, self.groups + 1, len(limits)
        value, batch = np.array(values), np.array(batches).transpose(1, 0, 2)
        return self._share_band(value.reshape(shape), batch.reshape(len(batch), *shape))

    def separation(self) -> Band:
        """Probability that a mesh is open at some instant, (w + 1,) [1], any mesh last."""
        with np.errstate(invalid="ignore", divide="ignore"):
            batch = self._apart / self._size[:, None]
            value = self._apart.sum(axis=0) / self._size.sum()
        return self._share_band(value, batch)

    def _share_band(self, value: Array, batch: Array) -> Band:
        """Band of a share of the samples; batch : (batches, ...) of each batch.

        Where no sample is seen the batches have no spread, and the band of independent samples says what is possible.
        """
        count = max(self.done - self.failed, 1)
        tail = (1 - CONFIDENCE) / 2
        seen = np.rint(value * count)
        exact_low = np.where(seen > 0, betaincinv(np.maximum(seen, 1), count - seen + 1, tail), 0.0)
        exact_high = np.where(seen < count, betaincinv(seen + 1, np.maximum(count - seen, 1), 1 - tail), 1.0)
        if self.plan.sampler == "random":
            return Band(value, exact_low, exact_high)
        half = _half_width(batch)
        low, high = np.clip(value - half, 0.0, 1.0), np.clip(value + half, 0.0, 1.0)
        sure = half == 0
        return Band(value, np.where(sure, exact_low, low), np.where(sure, exact_high, high))

    def histogram(self) -> tuple[Array, Counts]:
        """Edges (b + 1,) of even bins from the least to the largest K, and counts (D, g + 1, b), the train last."""
        edges = bin_edges()
        fine = self._fine.reshape(self.definitions, -1, BINS)[:, : self.groups + 1]
        used = np.flatnonzero(fine.sum(axis=(0, 1)))
        low, high = (1.0, 1.0) if not used.size else (edges[max(used[0], 1)], edges[min(used[-1] + 1, BINS - 1)])
        even = np.linspace(low, high, _SHOWN + 1)
        shown = np.unique(edges[np.clip(np.searchsorted(edges, even), 1, BINS - 1)])
        if shown.size < 2:
            shown = edges[BINS // 2 : BINS // 2 + 2]
        return shown, np.array([[display_histogram(counts, edges, shown) for counts in rows] for rows in fine])

    def of_train(self, definition: int) -> SampleTally:
        """What of it is of K of the train by one definition."""
        at = definition * (self.groups + 1 + self.meshes) + self.groups
        part = SampleTally(plan=self.plan, definitions=1, groups=0, meshes=0)
        part._fine, part._coarse, part._top = self._fine[[at]], self._coarse[:, [at]], self._top[[at]]
        part.done, part.failed = self.done, self.failed
        return part

    def worst(self) -> tuple[Array, NDArray[np.int64]]:
        """Largest K of the train by the first definition, and the numbers of their samples, the worst first."""
        value, number = self._worst
        known = number >= 0
        return value[known], number[known]


def weighted_tally(tallies: Sequence[SampleTally], share: Sequence[float]) -> SampleTally:
    """The tallies (c,) of one quantity with as many samples each, by their shares (c,) of the time [1]."""
    whole = SampleTally(plan=tallies[0].plan, definitions=1, groups=0, meshes=0)
    whole._fine = np.einsum("c,cqb->qb", share, [tally._fine for tally in tallies])
    whole._coarse = np.einsum("c,cnqb->nqb", share, [tally._coarse for tally in tallies])
    tops = np.array([tally._top[0] for tally in tallies])
    weight = np.where(tops[:, 0] == tops[:, 0].max(), share, 0.0)  # of those that reach the highest bin
    whole._top = np.array([[tops[:, 0].max(), weight @ tops[:, 1], tops[weight > 0, 2].max()]])
    whole.done = min(tally.done for tally in tallies)
    whole.failed = max(tally.failed for tally in tallies)
    return whole


def _add(counts: NDArray[Any], index: NDArray[np.int32], bins: int) -> None:
    """Count sorted indices of each quantity, (Q, rows), in its histogram, (Q, bins); others than bins are left out."""
    flat = (index + np.arange(len(index), dtype=np.int64)[:, None] * bins)[index < bins]
    first = np.flatnonzero(np.diff(flat, prepend=-1))
    counts.reshape(-1)[flat[first]] += np.diff(first, append=flat.size).astype(counts.dtype)


def _half_width(batch: Array) -> Array:
    """Half width of Student's band of the mean of batches (B, ...)."""
    count = len(batch)
    t = stdtrit(count - 1, 1 - (1 - CONFIDENCE) / 2)
    return np.asarray(t * batch.std(axis=0, ddof=1) / math.sqrt(count))
