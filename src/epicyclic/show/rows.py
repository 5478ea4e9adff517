"""Rows that tables of several kinds of result share: mesh forces, largest values over speed, counts of a status."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .elements import Table
from .figures.series import engineering
from .figures.summaries import of_first_stage, own_tones

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "columns_of",
    "extent",
    "force_table",
    "largest_heading",
    "largest_over_speed",
    "loaded",
    "named_columns",
    "relative_speed",
    "speed_range_of",
    "status_table",
]


def named_columns(headings: tuple[str, ...], rows: list[tuple[Any, ...]]) -> dict[str, list[Any]]:
    """Columns of rows of equal length."""
    return {heading: [row[i] for row in rows] for i, heading in enumerate(headings)}


def columns_of(result: xr.Dataset, dim: str, names: Mapping[str, tuple[str, float]]) -> dict[str, Any]:
    """Columns of a table over `dim`: variable -> (heading, factor from SI to the heading's unit)."""
    columns: dict[str, Any] = {dim: list(map(str, result[dim].values))}
    for name, (heading, factor) in names.items():
        if name in result:
            values = result[name].values
            columns[heading] = list(values * factor) if values.dtype.kind == "f" else [_plain(one) for one in values]
    return columns


def _plain(value: Any) -> Any:
    if isinstance(value, bool | np.bool_):
        return "yes" if value else ""
    return str(value) if isinstance(value, str) else value


def force_table(result: xr.Dataset) -> Table:
    """Mean, least and most of every mesh force [N], of mesh_force(mesh, ...), and what else is known of each mesh."""
    force = result.mesh_force.transpose("mesh", ...).values.reshape(result.sizes["mesh"], -1)
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "mean [N]": list(force.mean(axis=1)),
        "least [N]": list(_over_phases(result, "mesh_force_least", force).min(axis=1)),
        "most [N]": list(_over_phases(result, "mesh_force_most", force).max(axis=1)),
    }
    further = {
        "mesh_force_bound": "bound over all phases [N]",
        "dynamic_factor": "K_v",
        "face_load_factor": "largest per mean along the face",
        "dynamic_face_load_factor": "largest at any time per mean",
        "open_share": "apart, share of time",
        "far_share": "on the far flank, share of time",
    }
    columns |= {heading: list(result[name].values) for name, heading in further.items() if name in result}
    if "contact_lost" in result:
        columns["contact lost"] = ["yes" if lost else "no" for lost in result.contact_lost.values]
    return Table(title="Mesh forces along the tooth normal", columns=columns)


def _over_phases(result: xr.Dataset, name: str, force: NDArray[np.float64]) -> NDArray[np.float64]:
    """Extremes of the forces over the phases of the other lines too, where the result has them, (mesh, ..) [N]."""
    if name not in result:
        return force
    values: NDArray[np.float64] = result[name].transpose("mesh", ...).values.reshape(result.sizes["mesh"], -1)
    return values


def largest_heading(result: xr.Dataset) -> str:
    """Heading of the largest radial forces: of several mesh frequencies they are a bound."""
    name = str(result["bearing_force_peak"].attrs.get("long_name", ""))
    return "largest, a bound [N]" if name.startswith("bound") else "largest [N]"


def largest_over_speed(
    result: xr.Dataset, dim: str, variable: str, heading: str, at: str = "at mesh frequency{of} [Hz]"
) -> dict[str, Any]:
    """Names, largest value of a variable (dim, speed) over the speeds, and where it is; nan where no speed has one.

    Where: the mesh's own frequency [Hz], of other things that of the first stage, which then takes the place of {of}.
    """
    values = result[variable].transpose(dim, "speed").values
    known = np.isfinite(values).any(axis=1)
    place = np.where(np.isfinite(values), values, -np.inf).argmax(axis=1)
    frequency = result.mesh_frequency.values.ravel()
    if dim == "mesh":
        own, of = own_tones(result), " of its stage" if of_first_stage(result) else ""
    else:  # of what belongs to no mesh
        own, of = np.ones(len(values)), of_first_stage(result)
    return {
        dim: list(map(str, result[dim].values)),
        heading: list(np.where(known, values[range(len(values)), place], np.nan)),
        at.format(of=of): list(np.where(known, own * frequency[place], np.nan)),
    }


def relative_speed(result: xr.Dataset) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Speeds (P,) per operating speed [1] of a sweep; nan where it does not say."""
    if "speed" not in result.coords:
        return np.full(result.sizes["speed"], np.nan)
    return np.asarray(result["speed"].values, dtype=np.float64)


def speed_range_of(result: xr.Dataset) -> str:
    """The range that a sweep was asked for, ``operation`` or ``modes``; "" of speeds given."""
    return str(json.loads(str(result.attrs.get("options", "{}"))).get("speed_range") or "")


def extent(result: xr.Dataset) -> str:
    """Range of the speeds of a sweep: mesh frequencies, and per cent of the operating speed."""
    hertz, speed = result["mesh_frequency"].values, 100 * relative_speed(result)
    share = f", {engineering(speed.min())} to {engineering(speed.max())} % of operation" if len(speed) else ""
    shown = share if np.isfinite(speed).all() else ""
    of = of_first_stage(result)
    return f"{engineering(hertz.min(), 6)} to {engineering(hertz.max(), 6)} Hz{of and f' mesh frequency{of}'}{shown}"


def loaded(columns: dict[str, Any], heading: str) -> dict[str, Any]:
    """The rows of a table whose value is more than rounding, 1e-9 of the largest."""
    values = np.nan_to_num(np.array(columns[heading], dtype=float))
    shown = np.flatnonzero(values > 1e-9 * values.max(initial=0.0))
    return {name: [column[i] for i in shown] for name, column in columns.items()}


def status_table(result: xr.Dataset) -> Table:
    """How many points have which status, of status with any dims."""
    names, counts = np.unique(result.status.values.astype(str), return_counts=True)
    return Table(title="Points", columns={"status": list(map(str, names)), "points": [int(one) for one in counts]})
