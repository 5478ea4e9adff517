"""What buys what: variance shares of K_gamma, what a tenth less spread takes off it, and its quantiles over one thing.

Variance shares, of each entry of the drawing, are by pick and freeze.  Curves are over the spread of a tolerance, the
torque, a support stiffness and the number of planets, the others as drawn.  All points take the same uniforms (common
random numbers), so that differences of quantiles are those of the drawing and not of the draw.  Shares, and what a
tenth less takes off, are of as many samples in every study from 8192 on: one seed ranks the tolerances in one order.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...engine.plan import PIECE, SamplingPlan, scramble_uniforms
from ...engine.points import outcomes
from ...errors import ConvergenceError, ModelError
from ...statics.load_map import MEAN_LOADS
from ...statics.sample_loads import ContactMethod
from ...train.resolution import load
from ...train.train import Train
from ...warning_codes import CodedText, coded
from .ranking import NARROWED, quantile_changes, variance_shares
from .statistics import Band, with_system
from .tolerance_map import ToleranceMap, tolerance_map

Array = NDArray[np.float64]

SCALES = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0)
"""Factors on the spread of a tolerance."""
TORQUE_SCALES = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0)
"""Factors on the load."""
SUPPORT_SCALES = (0.001, 0.01, 0.1, 1.0, 10.0, 100.0, 1000.0)
"""Factors on a support stiffness: from a member that floats to one that is held."""
PLANETS = (3, 4, 5, 6, 7)
"""Numbers of planets."""

# largest factor on a support stiffness: above those of the curve, because uniform numbers end below 1
_SUPPORT_RANGE = 2 * SUPPORT_SCALES[-1]
# samples beyond a quantile of a curve; common random numbers make the curve smooth, not right
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
    d, entries = drawn.dimension_entry.size, len(drawn.entries)
    u = np.concatenate([scramble_uniforms(plan, i, d) for i in range(plan.scrambles)])
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
