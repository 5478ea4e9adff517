"""K_gamma of the train over one thing at a time: spread of a tolerance, torque, support stiffness, number of planets.

All points take the same uniforms (common random numbers), so that differences of quantiles are those of the drawing and
not of the draw.  Values are those of the first definition.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.sampling import SamplingPlan, scramble_uniforms
from ...errors import ConvergenceError, ModelError
from ...statics.sample_loads import ContactMethod
from .sample_map import SampleMap
from .statistics import system_value

__all__ = [
    "PLANETS",
    "SCALES",
    "SUPPORT_SCALES",
    "TORQUE_SCALES",
    "PlanetCurve",
    "ScaleCurves",
    "planet_curve",
    "scale_curves",
    "support_curves",
    "support_tolerance",
    "torque_curve",
]

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
