"""Saved results beside each other: the largest difference of every variable that all have."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from ...results.ties import EQUAL, largest

__all__ = ["VariableDifference", "variable_differences"]


@dataclass(frozen=True, slots=True, kw_only=True)
class VariableDifference:
    """Largest difference of one variable between the first result and each other one.

    Per result, the first one's own entries nan and "": difference, and the values of the first and of the other there.
    place : labels of the place.  points : how many values are compared.
    """

    name: str
    unit: str
    meaning: str
    difference: tuple[float, ...]
    first: tuple[float, ...]
    other: tuple[float, ...]
    place: tuple[str, ...]
    points: int


def variable_differences(results: Sequence[xr.Dataset]) -> tuple[VariableDifference, ...]:
    """Differences of all numbers that every result has, the largest for its size first.

    Values are compared where the labels of their dims agree; of complex numbers the difference is that of the complex
    values.  Variables of different dims, or without any label in common, are left out.
    """
    found = []
    for name in results[0].data_vars:
        if "bin" in results[0][name].dims:  # counts of a histogram: its quantiles say what moved
            continue
        if all(name in one.data_vars and one[name].dims == results[0][name].dims for one in results):
            entry = _differences(str(name), [one[name] for one in results])
            if entry is not None:
                found.append(entry)
    return tuple(sorted(found, key=lambda entry: -_relative(entry)))


def _differences(name: str, variables: Sequence[xr.DataArray]) -> VariableDifference | None:
    """Differences of one variable; None where there are no numbers to compare."""
    if any(one.dtype.kind not in "ifcub" for one in variables):
        return None
    columns: list[tuple[float, float, float, str]] = [(math.nan, math.nan, math.nan, "")]
    points = 0
    for other in variables[1:]:
        try:
            a, b = xr.align(variables[0], other, join="inner")
        except ValueError:  # dims without labels, of another length; labels that stand twice
            return None
        if a.shape != b.shape or not a.size:
            return None
        first, second = (np.asarray(one.values).astype(complex) for one in (a, b))
        with np.errstate(invalid="ignore"):  # both infinite: no difference is known
            size = np.abs(second - first)
        if not np.isfinite(size).any():
            return None
        place = np.unravel_index(largest(np.where(np.isfinite(size), size, np.nan), equal=EQUAL), size.shape)
        columns.append((float(size[place]), _shown(first[place]), _shown(second[place]), _label(a, place)))
        points = int(np.isfinite(size).sum())
    difference, own, others, places = zip(*columns, strict=True)
    attrs = variables[0].attrs
    return VariableDifference(
        name=name,
        unit=str(attrs.get("units", "")),
        meaning=str(attrs.get("long_name", "")),
        difference=difference,
        first=own,
        other=others,
        place=places,
        points=points,
    )


def _shown(value: complex) -> float:
    """A real number as it is, the size of a complex one."""
    return float(value.real) if value.imag == 0 else float(abs(value))


def _label(values: xr.DataArray, place: Sequence[np.integer]) -> str:
    """Labels of one place, or its number where a dim has none."""
    parts = []
    for dim, at in zip(values.dims, place, strict=True):
        label = values[dim].values[at] if dim in values.coords else int(at)
        parts.append(f"{dim} {label:.6g}" if isinstance(label, float) else f"{dim} {label}")
    return ", ".join(parts)


def _relative(entry: VariableDifference) -> float:
    """Largest difference per largest value there [1]."""
    rows = zip(entry.difference[1:], entry.first[1:], entry.other[1:], strict=True)
    return max(d / max(abs(a), abs(b), 1e-300) if d else 0.0 for d, a, b in rows)
