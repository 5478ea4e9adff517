"""What buys what: variance shares of K_gamma, what a tenth less spread takes off it, and its quantiles over one thing.

Variance shares, of each entry of the drawing, are by pick and freeze.  Curves are over the spread of a tolerance, the
torque, a support stiffness and the number of planets, the others as drawn.  All points take the same uniforms (common
random numbers), so that differences of quantiles are those of the drawing and not of the draw.  Shares, and what a
tenth less takes off, are of as many samples in every study from 8192 on: one seed ranks the tolerances in one order.

Estimates of the ranking are of independent scrambles of one low-discrepancy sequence.  Their bands are by the jackknife
over the scrambles: an estimate of all of them, and one without each, between which Student's t holds.  Nothing is
clipped: shares below 0 or above 1 are what the samples gave, and their bands say how far from it the share may be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from ...engine.plan import PIECE, SamplingPlan, all_uniforms, scramble_uniforms
from ...engine.points import outcomes
from ...errors import ConvergenceError, ModelError
from ...statics.load_map import MEAN_LOADS
from ...statics.sample_loads import ContactMethod
from ...train.resolution import load
from ...train.train import Train
from ...warning_codes import CodedText, coded
from .statistics import CONFIDENCE, Array, Band, with_system
from .tolerance_map import ToleranceMap, tolerance_map

SCALES = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0)
"""Factors on the spread of a tolerance."""
TORQUE_SCALES = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0)
"""Factors on the load."""
SUPPORT_SCALES = (0.001, 0.01, 0.1, 1.0, 10.0, 100.0, 1000.0)
"""Factors on a support stiffness: from a member that floats to one that is held."""
PLANETS = (3, 4, 5, 6, 7)
"""Numbers of planets."""

NARROWED = 0.9
"""Factor on the spread of a tolerance that a tenth less makes of it."""
# Ranks about a quantile that its change is read from: half as many on each side as lie beyond it, of a middle quantile
# a fiftieth of all; part of them whose mean is the quantile.  A single rank would follow a single sample.
_BESIDE, _MOST_BESIDE, _NEAREST = 0.5, 0.02, 0.25
# Change that is rounding of load factors about 1.
_ROUNDING = 1e-12
# largest factor on a support stiffness: above those of the curve, because uniform numbers end below 1
_SUPPORT_RANGE = 2 * SUPPORT_SCALES[-1]
# samples beyond a quantile of a curve, or of a change; common random numbers make the curve smooth, not right
_LEAST_BEYOND = 8
# rows of an evaluation at least: 10 samples beyond the 99 % quantile
_LEAST = 2**10
# share of the samples of the study that curves may take together
_SHARE = 0.25
# scrambles between which bands of the ranking are estimated, and all their samples at most
_SCRAMBLES, _RANKED = 16, 2**13
# samples that tell whether an entry moves K_gamma, and the change that is none: six decimals of a load ratio are far
# below what any test rig or drawing tells apart, and far above the rounding of stiff trains
_TOLD, _NO_CHANGE = 2**5, 1e-6


@dataclass(slots=True, kw_only=True, eq=False)
class EffectColumns:
    """Variables and coordinates of the effects, what was left out and why.

    samples : of each point of a curve.  ranked : of shares, and of what a tenth less takes off.
    """

    columns: dict[str, tuple[Any, Any]] = field(default_factory=dict)
    coords: dict[Any, Any] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    samples: int = 0
    ranked: int = 0


class _Common(NamedTuple):
    """What all points of the curves have in common.

    plan : of one scramble, whose rows every point takes.  probability : (P,) of the quantiles.
    step : called after each evaluation.
    """

    plan: SamplingPlan
    probability: Array
    method: ContactMethod
    step: Callable[[], None]

    def uniforms(self, dimensions: int) -> Array:
        """Uniforms (rows, dimensions) of every point."""
        return scramble_uniforms(self.plan, 0, dimensions)

    def factors(self, drawn: ToleranceMap, u: Array, *, scale: Array | None = None, torque: float = 1.0) -> Array:
        """Load factors (S, D, g + 1) of the samples."""
        factor = with_system(drawn.evaluate(u, scale=scale, torque=torque, method=self.method).k)
        self.step()
        return factor

    def quantiles(self, drawn: ToleranceMap, u: Array, *, scale: Array | None = None, torque: float = 1.0) -> Array:
        """Quantiles of every group and of the train last, (D, g + 1, P), failed samples left out."""
        factor = self.factors(drawn, u, scale=scale, torque=torque)
        known = factor[~np.isnan(factor).any(axis=(1, 2))]
        if not len(known):
            return np.full((*factor.shape[1:], self.probability.size), np.nan)
        quantiles = np.quantile(known, self.probability, axis=0, method="hazen")
        # a quantile with hardly a sample beyond it is none
        quantiles[(1 - self.probability) * len(known) < _LEAST_BEYOND] = np.nan
        return np.moveaxis(quantiles, 0, -1)


def effects_of(
    train: Train,
    drawn: ToleranceMap,
    plan: SamplingPlan,
    chosen: str,
    *,
    method: ContactMethod,
    probability: Array,
    progress: Callable[[float], None] | None = None,
) -> EffectColumns:
    """Shares, slopes and curves of a train with its map.

    Parameters
    ----------
    plan : of the study, whose samples say how many each evaluation takes here.  chosen : ``none``, ``shares``, ``all``.
    probability : (P,) of the quantiles.  progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : the map refuses an evaluation.
    """
    if chosen == "none":
        return EffectColumns()
    entries = len(drawn.entries)
    few = _few(plan, entries * len(SCALES) + len(TORQUE_SCALES))
    ranked = _ranked_plan(plan, slow=method == "static" or (drawn.lawful and method != "linear"))
    supports = _supports(train) if chosen == "all" else {}
    points = entries * (len(SCALES) - 1) + 1 + len(TORQUE_SCALES) + len(supports) * len(SUPPORT_SCALES)
    points += len(PLANETS) if chosen == "all" else 0
    weight = max(1, ranked.samples // few.rows)  # an evaluation of the ranking takes as long as so many of a curve
    points += (2 * entries + 3) * weight
    done = 0

    def step(weight: int = 1) -> None:
        nonlocal done
        done += weight
        if progress is not None:
            progress(min(1.0, done / points))

    common = _Common(plan=few, probability=probability, method=method, step=step)
    effects = EffectColumns(samples=few.rows, ranked=ranked.samples)
    large = common._replace(step=partial(step, weight))
    _add_shares(effects, drawn, ranked, large)
    _add_tenths(effects, drawn, ranked, large)
    nominal = _add_spreads(effects, drawn, common)
    _add_torques(effects, drawn, common)
    if chosen == "all":
        _add_supports(effects, train, supports, common)
        _add_planets(effects, train, nominal, common)
    else:
        effects.left_out |= dict.fromkeys(("k_gamma_by_support", "k_gamma_by_planets"), "by default from 65536 samples")
    step(points)  # a number of planets that is known or refused takes none
    return effects


def without_effect(drawn: ToleranceMap, plan: SamplingPlan, *, method: ContactMethod) -> list[CodedText]:
    """Warnings of entries whose spread moves K_gamma by nothing: the same samples, once with that entry at its mean.

    Entries that move the largest load while turning, but not its mean, are told apart.  Those of which the map has told
    are left out.

    Raises
    ------
    ModelError : the map refuses an evaluation.
    """
    few = SamplingPlan(samples=_TOLD, scrambles=1, rows=_TOLD, seed=plan.seed, sampler=plan.sampler)
    u = scramble_uniforms(few, 0, drawn.dimension_entry.size)
    whole = drawn.evaluate(u, method=method).k
    idle: list[str] = []
    averaged: list[str] = []
    for i, entry in enumerate(drawn.entries):
        if entry.path in drawn.unmoved:
            continue
        scale = np.ones(len(drawn.entries))
        scale[i] = 0.0
        at_mean = drawn.evaluate(u, scale=scale, method=method).k
        same = np.asarray(np.isclose(at_mean, whole, rtol=0, atol=_NO_CHANGE, equal_nan=True).all(axis=(0, 2)))
        if same.all():
            idle.append(entry.path)
        elif same[MEAN_LOADS.index("mean-load")]:
            averaged.append(entry.path)
    by_nothing = f"K_gamma by less than {_NO_CHANGE:g} in each of {_TOLD} trains"
    words = {
        f"has no effect: moves {by_nothing}": idle,
        f"moves {by_nothing}, what turns averages out; the largest load while turning follows": averaged,
    }
    return [
        coded("tolerance-without-effect", f"tolerance of {', '.join(paths)} {text}")
        for text, paths in words.items()
        if paths
    ]


def _few(plan: SamplingPlan, evaluations: int) -> SamplingPlan:
    """Plan of one evaluation of several that together take a share of the samples of a study."""
    wanted = max(1, int(_SHARE * plan.samples / max(1, evaluations)))
    rows = min(PIECE, max(_LEAST, 1 << (wanted.bit_length() - 1)))
    return SamplingPlan(samples=rows, scrambles=1, rows=rows, seed=plan.seed, sampler="sobol")


def _ranked_plan(plan: SamplingPlan, *, slow: bool) -> SamplingPlan:
    """Plan of the ranking, alike for all studies but small ones; slow : whether every sample is solved for."""
    samples = min(_LEAST if slow else _RANKED, max(_LEAST, plan.samples))
    rows = samples // _SCRAMBLES
    return SamplingPlan(samples=samples, scrambles=_SCRAMBLES, rows=rows, seed=plan.seed, sampler="sobol")


# the ranking ----------------------------------------------------------------------------------------------------------


def _add_shares(effects: EffectColumns, drawn: ToleranceMap, plan: SamplingPlan, common: _Common) -> None:
    """Variance shares of K_gamma by drawing entry; correlated entries share one number."""
    paths = [entry.path for entry in drawn.entries]
    group = np.arange(len(paths))
    for correlation in drawn.correlations:
        members = np.isin(paths, correlation.paths)
        group[members] = group[members].min()
        together = ", ".join(correlation.paths)
        effects.left_out[f"sobol_first, {together}"] = "correlated: the shares of all of them together"
    _, group = np.unique(group, return_inverse=True)

    def evaluated(u: Array) -> Array:
        return common.factors(drawn, u)[:, :, :-1]

    shares = variance_shares(evaluated, group[drawn.dimension_entry], plan, groups=int(group.max()) + 1)
    over = ("definition", "pair", "tolerance")
    for name, band in (("sobol_first", shares.first), ("sobol_total", shares.total)):
        effects.columns |= band.of(lambda ends: ends[..., group]).columns(name, over)
    effects.coords["tolerance"] = paths


def _add_tenths(effects: EffectColumns, drawn: ToleranceMap, plan: SamplingPlan, common: _Common) -> None:
    """Change of the quantiles of the pairs and of the train with a tenth less of each spread, and the slopes of it."""
    u, entries = all_uniforms(plan, drawn.dimension_entry.size), len(drawn.entries)
    nominal = common.factors(drawn, u)
    found = [
        quantile_changes(nominal, common.factors(drawn, u, scale=scale), common.probability, plan.scrambles)
        for scale in np.where(np.eye(entries, dtype=bool), NARROWED, 1.0)
    ]
    # (definition, pairs and train, probability, tolerance)
    every = Band(*(np.stack(ends, axis=-1) for ends in zip(*found, strict=True)))
    pairs, train = every.of(lambda ends: ends[:, :-1]), every.of(lambda ends: ends[:, -1])
    over = ("definition", "pair", "probability", "tolerance")
    draws = [(entry.own, entry.common) for entry in drawn.entries]
    deviation = np.array([math.hypot(*(draw.std for draw in both if draw is not None)) for both in draws])
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(deviation > 0, pairs.value / ((NARROWED - 1) * deviation), np.nan)
    effects.columns |= {
        **pairs.columns("tenth_less", over),
        **train.columns("system_tenth_less", (over[0], *over[2:])),
        "quantile_slope": (over, slope),
        "tolerance_deviation": ("tolerance", deviation),
        "tolerance_unit": ("tolerance", np.array([entry.unit for entry in drawn.entries], dtype=object)),
    }


# curves ---------------------------------------------------------------------------------------------------------------


def _add_spreads(effects: EffectColumns, drawn: ToleranceMap, common: _Common) -> Array:
    """Quantiles of the train over the spread of each tolerance; those as drawn (P,), returned."""
    u = common.uniforms(drawn.dimension_entry.size)
    nominal: Array = common.quantiles(drawn, u)[0, -1]

    def quantiles(own: NDArray[np.bool_], factor: float) -> Array:
        """Quantiles (P,) of the train with a factor on the spread of one entry."""
        scale = np.where(own, factor, 1.0)
        return nominal if factor == 1.0 else np.asarray(common.quantiles(drawn, u, scale=scale)[0, -1])

    curve = [[quantiles(own, factor) for factor in SCALES] for own in np.eye(len(drawn.entries), dtype=bool)]
    effects.columns["k_gamma_by_scale"] = (("tolerance", "scale", "probability"), np.array(curve))
    effects.coords["scale"] = np.array(SCALES)
    return nominal


def _add_torques(effects: EffectColumns, drawn: ToleranceMap, common: _Common) -> None:
    """Quantiles of the train over the torque."""
    u = common.uniforms(drawn.dimension_entry.size)
    curve = [common.quantiles(drawn, u, torque=factor)[0, -1] for factor in TORQUE_SCALES]
    effects.columns["k_gamma_by_torque"] = (("torque_scale", "probability"), np.array(curve))
    effects.coords["torque_scale"] = np.array(TORQUE_SCALES)


def _supports(train: Train) -> dict[str, float]:
    """Path -> lateral stiffness [N/m] of the elastic supports of central members, alike in both directions."""
    stiffness = {}
    for link in train.links:
        x, y = link.stiffness[:2]
        if link.kind == "support" and link.path.startswith("stages.") and x == y and 0 < x < np.inf:
            if not any(path.startswith(link.path) for path in _toleranced(train)):
                stiffness[f"{link.path}.radial"] = float(x)
    return stiffness


def _toleranced(train: Train) -> Mapping[str, object]:
    table = train.document.get("tolerance", {})
    return table if isinstance(table, dict) else {}


def _add_supports(effects: EffectColumns, train: Train, supports: Mapping[str, float], common: _Common) -> None:
    """Quantiles of the train over one support stiffness after the other, by one map in which they all are drawn.

    The uniform number of a stiffness is its factor per `_SUPPORT_RANGE`.
    """
    name = "k_gamma_by_support"
    if not supports:
        effects.left_out[name] = "no central member has an elastic support without tolerance"
        return
    ranges = {path: f"uniform(0 N/m, {_SUPPORT_RANGE * nominal!r} N/m)" for path, nominal in supports.items()}
    curve = np.full((len(supports), len(SUPPORT_SCALES), common.probability.size), np.nan)
    try:
        drawn = tolerance_map(load({**train.document, "tolerance": {**_toleranced(train), **ranges}}))
        paths = [entry.path for entry in drawn.entries]
        dimensions = [drawn.dimension_entry == paths.index(path) for path in supports]
        others = ~np.any(dimensions, axis=0)
        u = np.full((common.plan.rows, others.size), 1.0 / _SUPPORT_RANGE)
        u[:, others] = common.uniforms(int(others.sum()))
        for number, varied in enumerate(dimensions):
            for i, factor in enumerate(SUPPORT_SCALES):
                at = np.where(varied, factor / _SUPPORT_RANGE, u)
                curve[number, i] = common.quantiles(drawn, at)[0, -1]
    except (ModelError, ConvergenceError) as error:
        effects.left_out[name] = str(error)
        return
    effects.columns |= {
        name: (("support", "support_scale", "probability"), curve),
        "support_stiffness": (("support", "support_scale"), np.outer(list(supports.values()), SUPPORT_SCALES)),
    }
    effects.coords |= {"support": list(supports), "support_scale": np.array(SUPPORT_SCALES)}


def _add_planets(effects: EffectColumns, train: Train, nominal: Array, common: _Common) -> None:
    """Quantiles of the train over the number of planets, the torque held; nominal : (P,) of the number in the file."""
    name = "k_gamma_by_planets"
    stages = train.document.get("stages", {})
    assert isinstance(stages, dict)
    counted = [stage for stage, table in stages.items() if "planets" in table]
    if len(counted) != 1:
        effects.left_out[name] = "several stages have planets" if counted else "planets stand at given angles"
        return

    def quantiles(planets: int) -> Array:
        """Quantiles (P,) of the train with a number of planets."""
        if planets == train.planets[counted[0]]:
            return nominal
        drawn = tolerance_map(load(dict(train.document), {f"stages.{counted[0]}.planets": planets}))
        return np.asarray(common.quantiles(drawn, common.uniforms(drawn.dimension_entry.size))[0, -1])

    found = outcomes(quantiles, PLANETS, workers=False)
    unknown = np.full(common.probability.size, np.nan)
    curve = np.array([unknown if outcome.value is None else outcome.value for outcome in found])
    reasons = zip(PLANETS, (outcome.reason for outcome in found), strict=True)
    effects.left_out |= {f"{name}, {planets}": reason for planets, reason in reasons if reason}
    effects.columns[name] = (("planets", "probability"), curve)
    effects.coords["planets"] = np.array(PLANETS)


# estimates of the ranking ---------------------------------------------------------------------------------------------


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
    uniforms = all_uniforms(plan, 2 * group.size)
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
