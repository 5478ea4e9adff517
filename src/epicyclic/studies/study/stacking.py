"""Results of many points as one Dataset: joined on their labels, with nothing where a point has no such label."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from ...errors import ModelError

__all__ = ["MOST_NUMBERS", "stacked", "unfolded"]

MOST_NUMBERS = 200_000_000
"""Numbers of a result, as many as a run may hold."""


def stacked(results: Sequence[xr.Dataset | None]) -> xr.Dataset:
    """Results along the new first dimension `point`.

    Labels of texts and whole numbers are joined: a point has nan, or an empty text, at those that it does not have.
    Coordinates of floating point, or with a label twice, that are not the same at every point are no labels to join
    on: they become a variable NAME_of_point, and the dimension counts.

    Raises
    ------
    ModelError : too many numbers.
    """
    places = [place for place, one in enumerate(results) if one is not None]
    found = [one for one in results if one is not None]
    if not found:
        return xr.Dataset(coords={"point": np.arange(len(results))})
    most = len(results) * max(sum(variable.size for variable in one.variables.values()) for one in found)
    if most > MOST_NUMBERS:
        allowed = f'keep = ["NAME", ...] with the variables that are wanted; at most {MOST_NUMBERS} numbers'
        raise ModelError("too many numbers to be held in one result", path="keep", given=most, allowed=allowed)
    coordinates = {name for one in found for name in one.coords if name not in one.dims}
    labelled = _with_labels([one.reset_coords() for one in found])
    fills = _fills(labelled)
    whole = xr.concat(
        labelled,
        dim=pd.Index(places, name="point"),
        data_vars="all",
        coords="minimal",
        compat="override",
        join="outer",
        fill_value=fills,
        combine_attrs="override",
    ).reindex(point=np.arange(len(results)), fill_value=fills)
    whole = whole.assign({name: _numbers(whole[name]) for name in whole.data_vars})
    return whole.set_coords([name for name in coordinates if name in whole]).transpose("point", ...)


def _with_labels(found: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Results whose dimensions all have labels that can be joined."""
    made = list(found)
    for dim in dict.fromkeys(dim for one in found for dim in one.dims):
        having = [one for one in found if dim in one.dims]
        indexes = [one.get_index(dim) for one in having]
        if all(index.equals(indexes[0]) for index in indexes[1:]) and len(having) == len(found):
            continue
        kinds = {index.dtype.kind for index in indexes}
        counts = "f" in kinds or "c" in kinds or not all(index.is_unique for index in indexes)
        made = [_counted(one, dim) if counts or dim not in one.coords else one for one in made]
    return made


def _counted(one: xr.Dataset, dim: Hashable) -> xr.Dataset:
    """A result whose dimension counts, its labels, if any, as a variable beside it."""
    if dim not in one.dims:
        return one
    counted = one.drop_vars(str(dim), errors="ignore").assign_coords({dim: np.arange(one.sizes[dim])})
    return (
        counted.assign({f"{dim}_of_point": ((dim,), one[dim].values, one[dim].attrs)}) if dim in one.coords else counted
    )


def _fills(found: Sequence[xr.Dataset]) -> dict[Hashable, Any]:
    """What stands where a point has nothing, by the kind of the variable: an empty text, else nan."""
    kinds = {name: variable.dtype.kind for one in found for name, variable in one.variables.items()}
    fills: dict[Hashable, Any] = {}
    for name, kind in kinds.items():
        fills[name] = "" if kind in "OU" else complex(np.nan, np.nan) if kind == "c" else np.nan
    return fills


def _numbers(variable: xr.DataArray) -> xr.DataArray:
    """A variable that is an array of texts or of numbers: truth values beside nan are numbers."""
    if variable.dtype.kind != "O" or any(isinstance(value, str) for value in variable.values.ravel()):
        return variable
    return variable.astype(float)


def unfolded(whole: xr.Dataset, dims: Sequence[str], shape: Sequence[int]) -> xr.Dataset:
    """The dimension `point` of all points as the dimensions of a study, the last one first."""

    def variable(one: xr.DataArray) -> tuple[tuple[Hashable, ...], Any, Mapping[Any, Any]]:
        if "point" not in one.dims:
            return one.dims, one.values, one.attrs
        return (*dims, *one.dims[1:]), one.values.reshape(*shape, *one.shape[1:]), one.attrs

    coords = {name: variable(one) for name, one in whole.coords.items() if name != "point"}
    return xr.Dataset({name: variable(one) for name, one in whole.data_vars.items()}, coords=coords)
