"""`sensitivity`: what moves a natural frequency or a mesh force most."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...results.ties import largest
from ...show.elements import Company, Drawing, Section, Table, number
from ...show.views import ResultView

if TYPE_CHECKING:
    import xarray as xr


def tables(result: xr.Dataset) -> Sequence[Table]:
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
    found = [Table(title=f"What moves {result.attrs['subject']}", columns=columns)]
    left = {p: why for p, why in json.loads(result.attrs.get("left_out", "{}")).items() if why != "moves nothing"}
    if left:
        found.append(Table(title="Without a derivative", columns={"path": list(left), "why": list(left.values())}))
    return found


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The numbers of the model file that move it most."""
    from ...show.charts.effects import tornado

    words = "What 1 % more of each number of the model does; a bar between two values: a repeated root splits."
    parts = [Drawing(anchor="sensitivity", figure=tornado(result), caption=words)]
    return [Section(anchor="sensitivity", title="Sensitivity", parts=parts)]


def _span(values: np.ndarray) -> str:
    """Least and most of values (k,) as text, one number where they are equal to 1e-6."""
    low, high = float(np.min(values)), float(np.max(values))
    if not np.isfinite(low):
        return ""
    close = abs(high - low) <= 1e-6 * max(abs(low), abs(high))
    return number(low) if close else f"{number(low)} .. {number(high)}"


def _most(row: np.ndarray, names: np.ndarray) -> str:
    """Name of the largest of a row (k,) [%], and how much it is."""
    if not np.isfinite(row).any() or not np.nanmax(np.abs(row)) > 0:
        return ""
    at = largest(np.abs(row))
    return f"{names[at]}: {number(float(row[at]))} %"


VIEWS = (ResultView("sensitivity", 90, tables, sections),)
