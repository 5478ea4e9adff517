"""Tables of what moves a frequency or a mesh force."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from .tables import number, table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["sensitivity_tables", "track_tables"]


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
    tables = [table(f"What moves {result.attrs['subject']}", columns)]
    left = {p: why for p, why in json.loads(result.attrs.get("left_out", "{}")).items() if why != "moves nothing"}
    if left:
        tables.append(table("Without a derivative", {"path": list(left), "why": list(left.values())}))
    return tables


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


def track_tables(result: xr.Dataset) -> list[Table]:
    """Where loci meet, and the frequencies at a few values."""
    options = json.loads(str(result.attrs["options"]))
    over = f"{options['over']} [{options['unit']}]" if options["unit"] else options["over"]
    veers = result.event_kind.values == "veering"
    events: dict[str, Any] = {
        "what": list(map(str, result.event_kind.values)),
        "at": list(result.event_value.values),
        "frequency [Hz]": list(result.event_frequency.values),
        "modes": list(map(str, result.event_first.values)),
        "and modes": list(map(str, result.event_second.values)),
        "gap [Hz]": list(np.where(veers, result.event_gap.values, np.nan)),
        "coupling factor": list(np.where(veers, result.coupling_factor.values, 0.0)),
        "veering index": list(np.where(veers, result.veering_index.values, 0.0)),
    }
    values = result.parameter.values
    picked = np.unique(np.linspace(0, values.size - 1, 5).round().astype(int))
    columns: dict[str, Any] = {
        "mode": list(map(int, result.mode.values)),
        "kind": list(map(str, result.mode_kind.values)),
        "multiplicity": list(map(int, result.multiplicity.values)),
    }
    frequency = result.frequency.transpose("mode", "parameter").values
    for at in picked:
        columns[f"at {values[at]:.4g} [Hz]"] = list(frequency[:, at])
    met = [table(f"Where modes meet along {over}", events)] if result.sizes.get("event") else []
    return [*met, table(f"Natural frequencies over {over}, modes followed from the first value", columns)]
