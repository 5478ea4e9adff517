"""Tables of what a train does under load: static, steady, sharing, sweep."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

if TYPE_CHECKING:
    import xarray as xr

from .tables import number, table

__all__ = ["any_tables", "sharing_tables", "static_tables", "steady_tables", "sweep_tables"]


def _forces(result: xr.Dataset) -> Table:
    force = result.mesh_force.transpose("mesh", ...).values.reshape(result.sizes["mesh"], -1)
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "mean [N]": list(force.mean(axis=1)),
        "least [N]": list(force.min(axis=1)),
        "most [N]": list(force.max(axis=1)),
    }
    if "mesh_force_bound" in result:
        columns["bound over all shaft phases [N]"] = list(result.mesh_force_bound.values)
    if "face_load_factor" in result:
        columns["largest per mean along the face"] = list(result.face_load_factor.values)
    if "dynamic_face_load_factor" in result:
        columns["largest at any time per mean"] = list(result.dynamic_face_load_factor.values)
    if "open_share" in result:
        columns["apart, share of time"] = list(result.open_share.values)
    if "contact_lost" in result:
        columns["contact lost"] = ["yes" if lost else "no" for lost in result.contact_lost.values]
    return table("Mesh forces along the tooth normal", columns)


def sharing_tables(result: xr.Dataset) -> list[Table]:
    coefficients = result.load_sharing.transpose("mesh", "definition")
    columns: dict[str, Any] = {"mesh": [*map(str, result.mesh.values), "train"]}
    for definition in result.definition.values:
        column = coefficients.sel(definition=definition).values
        columns[str(definition)] = [*column, result.system_load_sharing.sel(definition=definition).item()]
    return [table("Load sharing", columns), _forces(result)]


def sweep_tables(result: xr.Dataset) -> list[Table]:
    frequency = result.mesh_frequency.values.ravel()
    rms = result.mesh_force_rms.transpose("mesh", "speed").values
    peak = result.mesh_force_peak.transpose("mesh", "speed").values
    rows = []
    for mesh, series, top in zip(result.mesh.values, rms, peak, strict=True):
        if np.isfinite(series).any():
            at = int(np.nanargmax(series))
            rows.append((str(mesh), float(series[at]), float(frequency[at]), float(np.nanmax(top))))
    headings = ("mesh", "largest rms [N]", "at mesh frequency [Hz]", "largest force [N]")
    status = result.status.values.astype(str)
    points = dict(zip(*np.unique(status, return_counts=True), strict=True))
    columns = {heading: [row[i] for row in rows] for i, heading in enumerate(headings)}
    title = f"{len(frequency)} speeds, {number(frequency.min())} to {number(frequency.max())} Hz"
    return [
        table(f"Dynamic mesh forces, {title}", columns),
        table("Points", {"status": list(map(str, points)), "points": [int(count) for count in points.values()]}),
    ]


def steady_tables(result: xr.Dataset) -> list[Table]:
    if not result.sizes.get("line"):
        return [_forces(result)]
    columns: dict[str, Any] = {
        "cause": list(map(str, result.line.values)),
        "frequency [Hz]": list(result.line_frequency.values),
        "largest amplitude of a mesh force [N]": list(result.line_amplitude.max("mesh").values),
    }
    return [_forces(result), table("Shaft frequencies", columns)]


def static_tables(result: xr.Dataset) -> list[Table]:
    """Mesh forces, and what twists under a torque: necks, shafts, couplings."""
    force = result.link_force.transpose("link_row", "time").values
    twist = result.link_deflection.transpose("link_row", "time").values
    largest = float(np.abs(force).max(initial=0.0))
    rows = [i for i, name in enumerate(result.link_row.values) if str(name).endswith("/rz")]
    # a torque below 1e-9 of the largest force is rounding
    loaded = [i for i in rows if np.abs(force[i]).max() > 1e-9 * largest]
    columns: dict[str, Any] = {
        "link": [str(result.link_row.values[i]).removesuffix("/rz") for i in loaded],
        "mean torque [N m]": [float(force[i].mean()) for i in loaded],
        "mean twist [urad]": [float(twist[i].mean()) * 1e6 for i in loaded],
        "most [urad]": [float(np.abs(twist[i]).max()) * 1e6 for i in loaded],
    }
    torsion = [table("Torsion of supports, necks, shafts and couplings", columns)] if loaded else []
    return [_forces(result), *torsion]


def any_tables(result: xr.Dataset) -> Sequence[Table]:
    """Tables of a result whose verb has none of its own: its forces, or each variable and its range."""
    if "mesh_force" in result:
        return [_forces(result)]
    names = [str(name) for name, values in result.data_vars.items() if values.dtype.kind == "f"]
    columns: dict[str, Any] = {
        "variable": names,
        "unit": [str(result[name].attrs.get("units", "")) for name in names],
        "least": [float(result[name].min()) for name in names],
        "most": [float(result[name].max()) for name in names],
    }
    return [table("Variables", columns)]
