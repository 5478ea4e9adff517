"""K_gamma of the train over one thing at a time: spread of a tolerance, torque, support stiffness, number of planets.

All points take the same uniforms (common random numbers), so that differences of quantiles are those of the drawing and
not of the draw.  Values are those of the first definition.

What buys what: variance shares, slopes and curves of one study, on so few samples that they cost less than it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.sampling import PIECE, SamplingPlan, scramble_uniforms
from ...errors import ConvergenceError, ModelError
from ...statics.mean_load import MEAN_LOADS
from ...statics.sample_loads import ContactMethod
from ...train.resolution import load
from ...train.train import Train
from ...warning_codes import CodedText, coded
from .columns import SampleMap, tolerance_map
from .shares import variance_shares
from .statistics import system_value

Array = NDArray[np.float64]
MapOf = Callable[[Mapping[str, object]], SampleMap]
Step = Callable[[], None]

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

# scales whose difference gives the slope at 1: wide, because the noise of a quantile falls with the step, while the
# curvature of the root of a sum of squares costs 1 % here
_BELOW, _ABOVE = SCALES.index(0.75), SCALES.index(1.25)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ScaleCurves:
    """Quantiles over the spread of each of E tolerances.

    system : (E, scales, P) of the train.  slope : (D, g, P, E) by the factor on the spread, at 1.
    """

    system: Array
    slope: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanetCurve:
    """Quantiles over the number of planets, (n, P), and why points are missing: number -> reason."""

    value: Array
    left_out: Mapping[int, str]


def scale_curves(
    samples: SampleMap, plan: SamplingPlan, probability: Array, *, method: ContactMethod, step: Step
) -> ScaleCurves:
    """Quantiles over the spread of each tolerance, the others as drawn; plan : of one scramble's rows."""
    u = scramble_uniforms(plan, 0, samples.dimension_entry.size)
    count = len(samples.entries)
    nominal = _quantiles(samples.evaluate(u, method=method).k, probability)
    step()
    found = np.empty((count, len(SCALES), *nominal.shape))
    for entry in range(count):
        for place, factor in enumerate(SCALES):
            if factor == 1.0:
                found[entry, place] = nominal
                continue
            scale = np.ones(count)
            scale[entry] = factor
            found[entry, place] = _quantiles(samples.evaluate(u, scale=scale, method=method).k, probability)
            step()
    slope = (found[:, _ABOVE] - found[:, _BELOW]) / (SCALES[_ABOVE] - SCALES[_BELOW])
    return ScaleCurves(system=found[:, :, 0, -1], slope=np.moveaxis(slope[:, :, :-1], 0, -1))


def torque_curve(
    samples: SampleMap, plan: SamplingPlan, probability: Array, *, method: ContactMethod, step: Step
) -> Array:
    """Quantiles of the train over the torque, (torques, P)."""
    u = scramble_uniforms(plan, 0, samples.dimension_entry.size)
    found = []
    for factor in TORQUE_SCALES:
        found.append(_system_quantiles(samples.evaluate(u, torque=factor, method=method).k, probability))
        step()
    return np.array(found)


def support_curves(
    samples: SampleMap,
    paths: Sequence[str],
    plan: SamplingPlan,
    probability: Array,
    *,
    method: ContactMethod,
    step: Step,
) -> Array:
    """Quantiles of the train over one support stiffness after the other, (supports, scales, P).

    Parameters
    ----------
    samples : map of the train with a tolerance `support_tolerance` of each of the paths, behind its own.
    """
    names = [entry.path for entry in samples.entries]
    place = {path: names.index(path) for path in paths}
    drawn = ~np.isin(samples.dimension_entry, list(place.values()))
    u = np.full((plan.rows, drawn.size), 1.0 / _SUPPORT_RANGE)
    u[:, drawn] = scramble_uniforms(plan, 0, int(drawn.sum()))
    found = np.full((len(paths), len(SUPPORT_SCALES), probability.size), np.nan)
    for number, path in enumerate(paths):
        own = samples.dimension_entry == place[path]
        for column, factor in enumerate(SUPPORT_SCALES):
            varied = np.where(own, factor / _SUPPORT_RANGE, u)
            found[number, column] = _system_quantiles(samples.evaluate(varied, method=method).k, probability)
            step()
    return found


def support_tolerance(stiffness: float) -> str:
    """Distribution whose uniform number is a factor on a stiffness [N/m], per `_SUPPORT_RANGE`."""
    return f"uniform(0 N/m, {_SUPPORT_RANGE * stiffness!r} N/m)"


def planet_curve(
    map_of: MapOf,
    path: str,
    plan: SamplingPlan,
    probability: Array,
    *,
    method: ContactMethod,
    step: Step,
    nominal: Mapping[int, Array],
) -> PlanetCurve:
    """Quantiles of the train over the number of planets, the torque held.

    Parameters
    ----------
    map_of : overrides -> map of the model with them.  path : of the number of planets.
    nominal : number -> quantiles (P,) that are known.
    """
    found = np.full((len(PLANETS), probability.size), np.nan)
    left_out = {}
    for place, number in enumerate(PLANETS):
        try:
            if number in nominal:
                found[place] = nominal[number]
                continue
            samples = map_of({path: number})
            u = scramble_uniforms(plan, 0, samples.dimension_entry.size)
            found[place] = _system_quantiles(samples.evaluate(u, method=method).k, probability)
        except (ModelError, ConvergenceError) as error:
            left_out[number] = str(error)
        finally:
            step()
    return PlanetCurve(value=found, left_out=left_out)


def _quantiles(k: Array, probability: Array) -> Array:
    """Quantiles of every group and of the train last, (D, g + 1, P), failed samples left out; k : (S, D, g)."""
    all_ = np.concatenate([k, system_value(k)[..., None]], axis=2)
    known = all_[~np.isnan(all_).any(axis=(1, 2))]
    if not len(known):
        return np.full((*all_.shape[1:], probability.size), np.nan)
    found = np.quantile(known, probability, axis=0, method="hazen")
    # a quantile with hardly a sample beyond it is none
    found[(1 - probability) * len(known) < _LEAST_BEYOND] = np.nan
    return np.moveaxis(found, 0, -1)


# samples beyond a quantile of a curve; common random numbers make the curve smooth, not right
_LEAST_BEYOND = 8


def _system_quantiles(k: Array, probability: Array) -> Array:
    """Quantiles of the train by the first definition, (P,)."""
    return np.asarray(_quantiles(k[:, :1], probability)[0, -1])


# rows of an evaluation at least: 10 samples beyond the 99 % quantile
_LEAST = 2**10
# share of the samples of the study that variance shares, and that curves may take together
_SHARE = 0.25
# samples that tell whether an entry moves K_gamma, and the change that is none: six decimals of a load ratio are far
# below what any test rig or drawing tells apart, and far above the rounding of stiff trains
_TOLD, _NO_CHANGE = 2**5, 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EffectColumns:
    """Variables and coordinates of the effects, what was left out and why, and samples of each evaluation."""

    columns: Mapping[str, tuple[Any, Any]] = field(default_factory=dict)
    coords: Mapping[Any, Any] = field(default_factory=dict)
    left_out: Mapping[str, str] = field(default_factory=dict)
    samples: int = 0


def effects_of(
    train: Train,
    drawn: SampleMap,
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
    count = len(drawn.entries)
    few = _few(plan, count * len(SCALES) + len(TORQUE_SCALES))
    supports = _supports(train) if chosen == "all" else {}
    evaluations = count * (len(SCALES) - 1) + 1 + len(TORQUE_SCALES) + len(supports) * len(SUPPORT_SCALES)
    step = _counter(progress, evaluations + (len(PLANETS) if chosen == "all" else 0))
    columns, coords, left_out = _shares(drawn, plan, method)
    curves = scale_curves(drawn, few, probability, method=method, step=step)
    deviation = np.array([_deviation(one) for one in drawn.entries])
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(deviation > 0, curves.slope / deviation, np.nan)
    columns |= {
        "quantile_slope": (("definition", "pair", "probability", "tolerance"), slope),
        "tolerance_deviation": ("tolerance", deviation),
        "tolerance_unit": ("tolerance", np.array([one.unit for one in drawn.entries], dtype=object)),
        "k_gamma_by_scale": (("tolerance", "scale", "probability"), curves.system),
        "k_gamma_by_torque": (
            ("torque_scale", "probability"),
            torque_curve(drawn, few, probability, method=method, step=step),
        ),
    }
    coords |= {"scale": np.array(SCALES), "torque_scale": np.array(TORQUE_SCALES)}
    if chosen == "all":
        nominal = curves.system[0, SCALES.index(1.0)]
        for more in (
            _supports_columns(train, supports, few, probability, method, step),
            _planets_columns(train, nominal, few, probability, method, step),
        ):
            columns, coords, left_out = columns | more[0], coords | more[1], left_out | more[2]
    else:
        left_out |= dict.fromkeys(("k_gamma_by_support", "k_gamma_by_planets"), "by default from 65536 samples")
    return EffectColumns(columns=columns, coords=coords, left_out=left_out, samples=few.rows)


def without_effect(drawn: SampleMap, plan: SamplingPlan, *, method: ContactMethod) -> list[CodedText]:
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
    still: list[str] = []
    averaged: list[str] = []
    for place, entry in enumerate(drawn.entries):
        if entry.path in drawn.unmoved:
            continue
        scale = np.ones(len(drawn.entries))
        scale[place] = 0.0
        at_mean = drawn.evaluate(u, scale=scale, method=method).k
        same = np.asarray(np.isclose(at_mean, whole, rtol=0, atol=_NO_CHANGE, equal_nan=True).all(axis=(0, 2)))
        if same.all():
            still.append(entry.path)
        elif same[MEAN_LOADS.index("mean-load")]:
            averaged.append(entry.path)
    by_nothing = f"K_gamma by less than {_NO_CHANGE:g} in each of {_TOLD} trains"
    words = {
        f"has no effect: moves {by_nothing}": still,
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


def _counter(progress: Callable[[float], None] | None, of: int) -> Callable[[], None]:
    """Function that reports one step more of so many."""
    done = 0

    def step() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(min(1.0, done / of))

    return step


def _shares(
    drawn: SampleMap, plan: SamplingPlan, method: ContactMethod
) -> tuple[dict[str, Any], dict[Any, Any], dict[str, str]]:
    """Variance shares of K_gamma by drawing entry; correlated entries share one number."""
    paths = [one.path for one in drawn.entries]
    group = np.arange(len(paths))
    left_out = {}
    for one in drawn.correlations:
        members = np.isin(paths, one.paths)
        group[members] = group[members].min()
        left_out[f"sobol_first, {', '.join(one.paths)}"] = "correlated: the shares of all of them together"
    _, group = np.unique(group, return_inverse=True)
    count = int(group.max()) + 1
    found = variance_shares(
        lambda u: drawn.evaluate(u, method=method).k,
        group[drawn.dimension_entry],
        _few(plan, count + 2),
        groups=count,
    )
    over = ("definition", "pair", "tolerance")
    columns = {"sobol_first": (over, found.first[..., group]), "sobol_total": (over, found.total[..., group])}
    return columns, {"tolerance": paths}, left_out


def _deviation(entry: Any) -> float:
    """Standard deviation of a drawing entry, own and common draws together, in SI."""
    return math.hypot(*(one.std for one in (entry.own, entry.common) if one is not None))


def _supports(train: Train) -> dict[str, float]:
    """Path -> lateral stiffness [N/m] of the elastic supports of central members, alike in both directions."""
    varied = {str(path) for path in _toleranced(train)}
    found = {}
    for link in train.links:
        path, (x, y) = f"{link.path}.radial", link.stiffness[:2]
        if link.kind == "support" and link.path.startswith("stages.") and x == y and 0 < x < np.inf:
            if not any(one.startswith(link.path) for one in varied):
                found[path] = float(x)
    return found


def _toleranced(train: Train) -> Mapping[str, object]:
    table = train.document.get("tolerance", {})
    return table if isinstance(table, dict) else {}


def _supports_columns(
    train: Train,
    supports: Mapping[str, float],
    plan: SamplingPlan,
    probability: Array,
    method: ContactMethod,
    step: Callable[[], None],
) -> tuple[dict[str, Any], dict[Any, Any], dict[str, str]]:
    """Curves over support stiffness, with one map in which they all vary."""
    name = "k_gamma_by_support"
    if not supports:
        return {}, {}, {name: "no central member has an elastic support without tolerance"}
    ranges = {path: support_tolerance(stiffness) for path, stiffness in supports.items()}
    try:
        samples = tolerance_map(load({**train.document, "tolerance": {**_toleranced(train), **ranges}}))
        curves = support_curves(samples, list(supports), plan, probability, method=method, step=step)
    except (ModelError, ConvergenceError) as error:
        return {}, {}, {name: str(error)}
    columns = {
        name: (("support", "support_scale", "probability"), curves),
        "support_stiffness": (("support", "support_scale"), np.outer(list(supports.values()), SUPPORT_SCALES)),
    }
    return columns, {"support": list(supports), "support_scale": np.array(SUPPORT_SCALES)}, {}


def _planets_columns(
    train: Train,
    nominal: Array,
    plan: SamplingPlan,
    probability: Array,
    method: ContactMethod,
    step: Callable[[], None],
) -> tuple[dict[str, Any], dict[Any, Any], dict[str, str]]:
    """Curve over the number of planets, with a map of each number; nominal : (P,) quantiles of that of the file."""
    try:
        path = _planets_path(train)
    except ModelError as error:
        return {}, {}, {"k_gamma_by_planets": error.problem}
    known = {train.planets[path.split(".")[1]]: nominal}
    map_of = partial(_map_of, train)
    curve = planet_curve(map_of, path, plan, probability, method=method, step=step, nominal=known)
    left_out = {f"k_gamma_by_planets, {number}": reason for number, reason in curve.left_out.items()}
    columns = {"k_gamma_by_planets": (("planets", "probability"), curve.value)}
    return columns, {"planets": np.array(PLANETS)}, left_out


def _map_of(train: Train, overrides: Mapping[str, object]) -> SampleMap:
    return tolerance_map(load(dict(train.document), dict(overrides)))


def _planets_path(train: Train) -> str:
    """Path of the one number of planets of a file.

    Raises
    ------
    ModelError : there is none, or more than one.
    """
    stages = train.document.get("stages", {})
    assert isinstance(stages, dict)
    paths = [f"stages.{name}.planets" for name, stage in stages.items() if "planets" in stage]
    if len(paths) != 1:
        words = "planets stand at given angles" if not paths else "several stages have planets"
        raise ModelError(words, path="stages")
    return paths[0]
