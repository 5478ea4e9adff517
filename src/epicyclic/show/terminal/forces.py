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
    if "dynamic_factor" in result:
        columns["K_v"] = list(result.dynamic_factor.values)
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
    """Largest values over the speeds, and where: mesh forces, lateral bearing forces, accelerations."""
    frequency = result.mesh_frequency.values.ravel()
    status = result.status.values.astype(str)
    points = dict(zip(*np.unique(status, return_counts=True), strict=True))
    title = f"{len(frequency)} speeds, {number(frequency.min())} to {number(frequency.max())} Hz"
    meshes = _largest(result, "mesh", "mesh_force_rms", "largest rms [N]")
    meshes["largest force [N]"] = _largest(result, "mesh", "mesh_force_peak", "force")["force"]
    meshes |= _largest(result, "mesh", "dynamic_factor", "largest K_v", at="K_v at [Hz]")
    tables = [table(f"Dynamic mesh forces, {title}", meshes)]
    if "bearing_force_peak" in result:
        bearings = _largest(result, "bearing", "bearing_force_peak", "largest [N]")
        bearings["largest dynamic rms [N]"] = _largest(result, "bearing", "bearing_force_rms", "rms")["rms"]
        tables.append(table("Radial forces in bearings, supports and couplings", _loaded(bearings, "largest [N]")))
    if "body_acceleration_rms" in result:
        bodies = _largest(result, "body", "body_acceleration_rms", "largest rms [m/s2]")
        tables.append(table("Accelerations of the bodies' centres", _loaded(bodies, "largest rms [m/s2]")))
    counts: dict[str, Any] = {"status": list(map(str, points)), "points": [int(count) for count in points.values()]}
    return [*tables, table("Points", counts)]


def _largest(
    result: xr.Dataset, dim: str, variable: str, heading: str, at: str = "at mesh frequency [Hz]"
) -> dict[str, Any]:
    """Names, largest value of a variable over the speeds, and where it is; nothing where no speed has one."""
    values = result[variable].transpose(dim, "speed").values
    known = np.isfinite(values).any(axis=1)
    place = np.where(np.isfinite(values), values, -np.inf).argmax(axis=1)
    frequency = result.mesh_frequency.values.ravel()
    return {
        dim: list(map(str, result[dim].values)),
        heading: list(np.where(known, values[range(len(values)), place], np.nan)),
        at: list(np.where(known, frequency[place], np.nan)),
    }


def _loaded(columns: dict[str, Any], heading: str) -> dict[str, Any]:
    """The rows of a table whose value is more than rounding, 1e-9 of the largest."""
    values = np.nan_to_num(np.array(columns[heading], dtype=float))
    shown = np.flatnonzero(values > 1e-9 * values.max(initial=0.0))
    return {name: [column[i] for i in shown] for name, column in columns.items()}


def steady_tables(result: xr.Dataset) -> list[Table]:
    tables = [_forces(result)]
    if "bearing_force_peak" in result:
        bearings: dict[str, Any] = {
            "bearing": list(map(str, result.bearing.values)),
            "mean [N]": list(result.bearing_force_mean.values),
            "dynamic rms [N]": list(result.bearing_force_rms.values),
            "largest [N]": list(result.bearing_force_peak.values),
        }
        tables.append(table("Radial forces in bearings, supports and couplings", _loaded(bearings, "largest [N]")))
    if result.sizes.get("line"):
        columns: dict[str, Any] = {
            "cause": list(map(str, result.line.values)),
            "frequency [Hz]": list(result.line_frequency.values),
            "largest amplitude of a mesh force [N]": list(result.line_amplitude.max("mesh").values),
        }
        tables.append(table("Shaft frequencies", columns))
    return tables


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
