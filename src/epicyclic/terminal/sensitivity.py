"""Tables of what moves a frequency or a mesh force."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from .tables import number, table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["sensitivity_tables"]


def sensitivity_tables(result: xr.Dataset) -> list[Table]:
    """Paths ranked; of a repeated root the least and the most of the set into which it splits."""
    dim = "mode" if "mode" in result.sizes else "mesh"
    chosen = np.flatnonzero(result.ranked_by.values.astype(bool))
    relative = result.sensitivity.transpose("path", dim).values
    derivative = result.derivative.transpose("path", dim).values
    columns: dict[str, Any] = {
        "path": list(map(str, result.path.values)),
        "value": [
            f"{number(value)} {unit}".strip()
            for value, unit in zip(result.parameter_value.values, result.parameter_unit.values, strict=True)
        ],
        "1 % moves it by [%]": [_span(row[chosen]) for row in relative],
        f"derivative [{'Hz' if dim == 'mode' else 'N'} per unit]": [_span(row[chosen]) for row in derivative],
        f"most it moves, {dim}": [_most(row, result[dim].values) for row in relative],
    }
    if any(str(text) != "ok" for text in result.status.values):
        columns["status"] = list(map(str, result.status.values))
    tables = [table(_title(result, dim, chosen), columns)]
    left = {p: why for p, why in json.loads(result.attrs.get("left_out", "{}")).items() if why != "moves nothing"}
    if left:
        tables.append(table("Without a derivative", {"path": list(left), "why": list(left.values())}))
    return tables


def _title(result: xr.Dataset, dim: str, chosen: np.ndarray) -> str:
    names = [str(result[dim].values[i]) for i in chosen]
    if dim == "mode":
        first = int(chosen[0])
        modes = f"mode {names[0]}" if len(names) == 1 else f"modes {names[0]} to {names[-1]}, one root"
        return (
            f"What moves {modes}, {number(float(result.frequency.values[first]))} Hz, {result.mode_kind.values[first]}"
        )
    options = json.loads(str(result.attrs["options"]))
    name, words = "mesh_force_rms", "the RMS of the dynamic mesh force"
    if "mesh_force_amplitude" in result:
        name, words = "mesh_force_amplitude", f"mesh order {options['harmonic']} of the mesh force"
    force = number(float(result[name].values[chosen[0]]))
    return f"What moves {words} of {names[0]}, {force} N at a mesh frequency of {number(options['mesh_frequency'])} Hz"


def _span(values: np.ndarray) -> str:
    low, high = float(np.min(values)), float(np.max(values))
    if not np.isfinite(low):
        return ""
    close = abs(high - low) <= 1e-6 * max(abs(low), abs(high))
    return number(low) if close else f"{number(low)} .. {number(high)}"


def _most(row: np.ndarray, names: np.ndarray) -> str:
    if not np.isfinite(row).any() or not np.nanmax(np.abs(row)) > 0:
        return ""
    at = int(np.nanargmax(np.abs(row)))
    return f"{names[at]}: {number(float(row[at]))} %"
