"""Transmission errors as results show them: ranges over periods with the lines that make them, and over speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..results.dataset import ranked
from .elements import Table, largest_over_speed
from .series import ARCMIN, texts

if TYPE_CHECKING:
    import xarray as xr

ARCSEC = 60 * ARCMIN
# kind -> what the rows are, unit shown, factor from SI, words
KINDS = {
    "rotation": ("mesh", "µm", 1e6, "rotation of the gears"),
    "approach": ("mesh", "µm", 1e6, "approach with moving centres"),
    "shaft": ("shaft", "arcsec", ARCSEC, "shaft to shaft"),
}
# Lines named in a table.
_NAMED = 3


def error_tables(result: xr.Dataset) -> Sequence[Table]:
    """Ranges of transmission errors over their periods and their largest lines, or the largest range over speed.

    Of meshes that with the largest range of its pair [µm]; of shafts all [arcsec].
    """
    tables = []
    for title, kinds in (("meshes", ("rotation", "approach")), ("shafts", ("shaft",))):
        columns: dict[str, list[Any]] = {}
        for kind in kinds:
            for heading, cells in _columns(result, kind).items():
                columns.setdefault(heading, []).extend(cells)
        if columns:
            tables.append(Table(title=f"Transmission error of {title}", columns=columns, digits=4))
    return tables


def _columns(result: xr.Dataset, kind: str) -> dict[str, list[Any]]:
    """Rows of one kind of error, none of a result without."""
    dim, unit, scale, words = KINDS[kind]
    name = f"transmission_error_{kind}"
    if f"{name}_range" in result.variables:
        spans = scale * result[f"{name}_range"].transpose(dim, "period").values
        columns: dict[str, list[Any]] = {dim: texts(result, dim)}
        columns |= {f"{one} [{unit}]": list(spans[:, i]) for i, one in enumerate(texts(result, "period"))}
        if result.sizes["error_line"]:
            columns[f"largest lines, amplitude [{unit}]"] = _lines(result, f"{name}_line", dim, scale)
        rank = spans[:, -1]
    elif f"{name}_peak_to_peak" in result.variables and result[f"{name}_peak_to_peak"].dims == (dim, "speed"):
        heading = f"largest peak to peak [{unit}]"
        columns = largest_over_speed(result, dim, f"{name}_peak_to_peak", heading)
        columns[heading] = [scale * value for value in columns[heading]]
        rank = np.nan_to_num(columns[heading])
    elif f"{name}_peak_to_peak" in result.variables and result[f"{name}_peak_to_peak"].dims == (dim,):
        rank = scale * result[f"{name}_peak_to_peak"].values
        columns = {dim: texts(result, dim), f"peak to peak [{unit}]": list(rank)}
    else:
        return {}
    if kind == "shaft" and "wind_up" in result.variables:
        columns["mean wind-up [arcsec]"] = list(ARCSEC * result["wind_up"].values)
    if dim == "mesh":
        pairs = [tuple(name.split("/")[:2]) for name in columns["mesh"]]
        best = {pairs[place]: place for place in ranked(rank)[::-1]}
        columns = {heading: [cells[place] for place in sorted(best.values())] for heading, cells in columns.items()}
        columns["by"] = [words] * len(best)
    return columns


def _lines(result: xr.Dataset, name: str, dim: str, scale: float) -> list[str]:
    """The largest lines of every row, in words."""
    labels, words = texts(result, "error_line"), []
    for row in scale * result[name].transpose(dim, "error_line").values:
        most = [int(place) for place in np.argsort(-row, kind="stable")[:_NAMED] if row[place] > 0]
        words.append("; ".join(f"{labels[place]} {row[place]:.3g}" for place in most))
    return words
