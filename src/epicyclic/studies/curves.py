"""One-parameter studies: a number over a value in the model file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from ..errors import ConvergenceError, ModelError
from ..results.dataset import dataset

if TYPE_CHECKING:
    from ..system.system import System

__all__ = ["largest_sharing", "vary"]


def largest_sharing(system: System) -> float:
    """Load-sharing coefficient of the train [1] by the first definition of `sharing` (peak per mesh cycle)."""
    from ..analyses.sharing.sharing import sharing

    return float(sharing(system).system_load_sharing[0])


def vary(
    source: str | Path | Mapping[str, Any],
    path_values: Mapping[str, Sequence[Any]],
    *,
    quantity: Callable[[System], float] = largest_sharing,
    overrides: Mapping[str, Any] | None = None,
    unit: str = "1",
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Compute one number over values in the model file; several paths go through their values together.

    A point that fails holds nan and says why in ``status``; the others go on.

    Parameters
    ----------
    source, overrides : as of `load`; the model file the values are laid over.
    path_values : path in the file -> its value at each point.
    quantity : called with the System of each point; unit : of what it returns.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : quantity(point), status(point) ("ok" or the message), and the values as coordinates named by their paths.

    Raises
    ------
    ModelError : no path, or not the same number of values for every path.
    """
    counts = {path: len(values) for path, values in path_values.items()}
    if len(set(counts.values())) != 1:
        raise ModelError("needs the same number of values for each path", path="path_values", given=counts)
    count = next(iter(counts.values()))
    found, status = np.full(count, np.nan), np.full(count, "ok", dtype=object)
    for point in range(count):
        here = {path: values[point] for path, values in path_values.items()}
        try:
            found[point] = _at(source, {**(overrides or {}), **here}, quantity)
        except (ModelError, ConvergenceError) as error:
            status[point] = str(error)
        if progress is not None:
            progress((point + 1) / count)
    return dataset(
        {"quantity": ("point", found), "status": ("point", status)},
        coords={"point": np.arange(count), **{path: ("point", list(values)) for path, values in path_values.items()}},
        verb="vary",
        options={"paths": list(path_values), "overrides": dict(overrides or {})},
        units={"quantity": unit},
        warnings=[f"{int(np.sum(status != 'ok'))} of {count} points failed"] if np.any(status != "ok") else (),
    )


def _at(
    source: str | Path | Mapping[str, Any], overrides: Mapping[str, Any], quantity: Callable[[System], float]
) -> float:
    from ..assemble import assemble
    from ..resolve import load

    return float(quantity(assemble(load(source, overrides=overrides))))
