"""What figures and tables of tolerances share: short names of drawing entries, per cent, histograms on even bins."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from ..results.ties import EQUAL, largest
from .series import Array, texts

DRAWN = (0.5, 0.95, 0.99)
"""Probabilities of figures and key figures."""

_TABLES = ("deviations", "stages", "operation", "meshes")


def percent(probability: float) -> str:
    """A probability as per cent: ``99.9 %``."""
    return f"{100 * probability:.10g}\u00a0%"


def short_entries(paths: Sequence[str]) -> list[str]:
    """Drawing entries in short: without table and kind of branch, without their stage where all are of one."""
    rows = [path.split(".") for path in paths]
    stages = {_stage(row) for row in rows}
    dropped = {*_TABLES, *(stages if len(stages) == 1 else ())}
    return [" ".join(word for word in row if word not in dropped).replace("_", "-") for row in rows]


def _stage(row: Sequence[str]) -> str:
    """``main`` of ``deviations.main.planet.position`` and of ``operation.torque.main.carrier``."""
    return row[2] if row[0] == "operation" and len(row) > 3 else row[1] if len(row) > 1 else row[0]


def pair_labels(names: Sequence[str]) -> list[str]:
    """Groups of meshes, pair and side: ``main.meshes.sun-planet.left`` -> ``sun-planet L``; stages where several."""
    rows = [name.split(".") for name in names]
    several = len({row[0] for row in rows}) > 1
    found = []
    for stage, *rest in rows:
        words = [word for word in rest if word != "meshes"] or [stage]
        words = [word[0].upper() if word in ("left", "right") else word for word in words]
        found.append(" ".join([stage, *words] if several and rest else words))
    return found


def scattering_pair(one: xr.Dataset) -> int:
    """Place of the pair whose K_gamma scatters most, of equal ones the first; 0 where the scatter is not known."""
    return largest(one["k_gamma_std"].values, equal=EQUAL) if "k_gamma_std" in one else 0


def micrometres(result: xr.Dataset) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Entries (tolerance,) whose spread is a length, so that a slope per micrometre means something."""
    return np.array([unit == "m" for unit in texts(result, "tolerance_unit", "tolerance")], dtype=bool)


def of_definition(result: xr.Dataset, definition: str = "") -> xr.Dataset:
    """A result of one definition, `mean-load` where not said, else the first; as it is without such a dimension."""
    if "definition" not in result.dims:
        return result
    names = texts(result, "definition")
    wanted = definition or "mean-load"
    return result.isel(definition=names.index(wanted) if wanted in names else 0)


def system_quantiles(result: xr.Dataset, probabilities: Sequence[float] = DRAWN) -> dict[float, float]:
    """K_gamma of the train that is not exceeded with each of the probabilities that the result has."""
    given = np.asarray(result["probability"].values, dtype=np.float64)
    values = of_definition(result)["system_k_gamma_quantile"].values
    pairs = {float(p): float(values[i]) for p in probabilities for i in np.flatnonzero(np.isclose(given, p))}
    return {p: value for p, value in pairs.items() if np.isfinite(value)}


def even_bins(edges: Array, counts: Array, low: float, high: float, bins: int) -> tuple[Array, Array]:
    """A histogram on even bins, counts shared out by width where a bin is cut.

    Parameters
    ----------
    edges : (b + 1,) of the bins.  counts : (b,).  low, high, bins : of the even bins, k.

    Returns
    -------
    centres (k,), share of all counts in each (k,) [1].
    """
    summed = np.concatenate([[0.0], np.cumsum(counts)])
    places = np.linspace(low, high, bins + 1)
    share = np.diff(np.interp(places, edges, summed)) / max(float(summed[-1]), 1.0)
    return (places[1:] + places[:-1]) / 2, np.asarray(share)
