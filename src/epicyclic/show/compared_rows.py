"""Rows of a comparison: quantities that trains or results have, and how much each differs from the first; no plotly."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..results.ties import largest
from .figures.series import engineering, texts

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ComparedRow", "compared_rows", "letters", "percent", "shown"]

# Relative change that is none: rounding of eigenvalues and of linear solves.
_SAME = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedRow:
    """One quantity of all trains.

    group : modes, sharing, ...  name : of the quantity.  unit : of `value`, one a train, nan where there is none.
    note : of each train, behind the value.  first : what each is compared with, the first value where empty.
    """

    group: str
    name: str
    unit: str
    value: tuple[float, ...]
    note: tuple[str, ...] = ()
    first: tuple[float, ...] = ()

    @property
    def change(self) -> tuple[float, ...]:
        """Change from the first train [%], nan where it is not known or from 0."""
        first = self.first or (self.value[0],) * len(self.value)
        return tuple(100 * (b - a) / abs(a) if a else math.nan for a, b in zip(first, self.value, strict=True))

    @property
    def largest(self) -> float:
        """Size of the largest change [%]; 0 where nothing changes."""
        known = [abs(one) for one in self.change if math.isfinite(one)]
        return max(known) if known and max(known) > 100 * _SAME else 0.0


def letters(result: xr.Dataset) -> tuple[str, ...]:
    """Letters of the trains, A the first."""
    return tuple(chr(ord("A") + i) for i in range(result.sizes["train"]))


def percent(value: float) -> str:
    """A change in per cent with its sign; empty where it is not known, = where it is none."""
    if not math.isfinite(value):
        return ""
    return "=" if abs(value) <= 100 * _SAME else f"{value:+.3g} %"


def compared_rows(result: xr.Dataset) -> list[ComparedRow]:
    """Rows of a Dataset of kind `compare`, those that no train has left out; variables of results, or effects."""
    rows = (
        _variables(result) if "largest_difference" in result else [*_speeds(result), *_modes(result), *_loads(result)]
    )
    return [row for row in rows if np.isfinite(row.value).any()]


def _speeds(result: xr.Dataset) -> Iterator[ComparedRow]:
    """Ratio, speeds that differ, mesh frequencies."""
    yield ComparedRow(
        group="speeds", name="ratio, driving to driven", unit="", value=_numbers(result["transmission_ratio"].values)
    )
    for name, values in zip(texts(result, "member"), result["speed"].values, strict=True):
        row = ComparedRow(group="speeds", name=f"speed of {name}", unit="rpm", value=_numbers(values))
        if not np.isfinite(values).all() or row.largest:
            yield row
    several = result.sizes["stage"] > 1
    for name, values in zip(texts(result, "stage"), result["mesh_frequency"].values, strict=True):
        words = f"mesh frequency of {name}" if several else "mesh frequency"
        yield ComparedRow(group="speeds", name=words, unit="Hz", value=_numbers(values))


def _modes(result: xr.Dataset) -> Iterator[ComparedRow]:
    """Elastic natural frequencies, equal ones once, with the modal assurance where it is low."""
    if "frequency" not in result:
        return
    seen = set()
    values, kinds, shared = (result[name].values for name in ("frequency", "mode_kind", "modal_assurance"))
    for mode, row, kind, criterion in zip(result["mode"].values, values, kinds, shared, strict=True):
        key = tuple(f"{value:.6g}" for value in row)
        if not row[0] > 0 or key in seen:
            continue
        seen.add(key)
        note = tuple("" if not np.isfinite(one) or one > 0.95 else f"MAC {one:.2f}" for one in criterion)
        name = f"natural frequency {mode}, {kind[0]}"
        yield ComparedRow(group="modes", name=name, unit="Hz", value=_numbers(row), note=note)


def _loads(result: xr.Dataset) -> Iterator[ComparedRow]:
    """K_gamma with its mesh; the largest mean and largest mesh force, of one stage each where there are several."""
    note = tuple(texts(result, "worst_mesh"))
    yield ComparedRow(group="sharing", name="K_gamma", unit="", value=_numbers(result["k_gamma"].values), note=note)
    method = next((str(one) for one in result["force_method"].values if one), "")
    at = {"steady": "dynamic", "static": "at rest"}.get(method, "")
    for name, words in (
        ("mesh_force_mean", "largest mean mesh force"),
        ("mesh_force_peak", f"largest mesh force, {at}"),
    ):
        values = result[name].values
        if values.size and np.isfinite(values).any():
            largest = [np.nanmax(column) if np.isfinite(column).any() else math.nan for column in values.T]
            yield ComparedRow(group="forces", name=words, unit="kN", value=_numbers(np.array(largest) / 1e3))


def _variables(result: xr.Dataset) -> Iterator[ComparedRow]:
    """Values of saved results where they differ most from the first."""
    for i, name in enumerate(texts(result, "variable")):
        first, other = result["first_value"].values[i], result["other_value"].values[i]
        places = tuple(map(str, result["difference_place"].values[i]))
        worst = largest(result["largest_difference"].values[i])
        value = (float(first[worst]), *(float(one) for one in other[1:]))
        against = (float(first[worst]), *(float(one) for one in first[1:]))
        unit = str(result["variable_unit"].values[i])
        unit = "" if unit == "1" else unit
        yield ComparedRow(group="variable", name=name, unit=unit, value=value, note=places, first=against)


def _numbers(values: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    return tuple(float(one) for one in values)


def shown(value: float, unit: str) -> str:
    """A value with its unit; empty where there is none."""
    return "" if not math.isfinite(value) else f"{engineering(value, 4)} {unit}".rstrip()
