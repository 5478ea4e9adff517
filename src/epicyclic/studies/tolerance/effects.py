"""What buys what: variance shares, slopes and curves of one study, on so few samples that they cost less than it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
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
from .columns import tolerance_map
from .curves import (
    PLANETS,
    SCALES,
    SUPPORT_SCALES,
    TORQUE_SCALES,
    planet_curve,
    scale_curves,
    support_curves,
    support_tolerance,
    torque_curve,
)
from .sample_map import SampleMap
from .shares import variance_shares

__all__ = ["EffectColumns", "effects_of", "without_effect"]

Array = NDArray[np.float64]

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
