"""Tables of what a model is: check, modes, Campbell diagram, mesh stiffness."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

if TYPE_CHECKING:
    import xarray as xr

from .tables import columns_of, number, table

__all__ = ["campbell_tables", "check_tables", "modes_tables", "stiffness_tables"]

_DEGREES = 180 / np.pi


def check_tables(result: xr.Dataset) -> list[Table]:
    bodies = {
        "kind": ("kind", 1),
        "speed": ("speed [rpm]", 1),
        "torque": ("torque [N m]", 1),
        "power": ("power [kW]", 1e-3),
        "mass": ("mass [kg]", 1),
        "inertia": ("inertia [kg m2]", 1),
        "station": ("station [mm]", 1e3),
        "axes_angle": ("angle [deg]", _DEGREES),
    }
    gears = {
        "teeth": ("teeth", 1),
        "reference_radius": ("reference radius [mm]", 1e3),
        "base_radius": ("base radius [mm]", 1e3),
        "tip_radius": ("tip radius [mm]", 1e3),
        "root_radius": ("root radius [mm]", 1e3),
        "face_width": ("face width [mm]", 1e3),
        "profile_shift": ("shift", 1),
        "helix_angle": ("helix [deg]", _DEGREES),
    }
    meshes = {
        "phase_lead": ("lead [cycles]", 1),
        "working_pressure_angle": ("working angle [deg]", _DEGREES),
        "contact_ratio": ("contact ratio", 1),
        "overlap_ratio": ("overlap ratio", 1),
        "mean_mesh_stiffness": ("mean stiffness [N/um]", 1e-6),
    }
    stages = {
        "planets": ("branches", 1),
        "mesh_frequency": ("mesh frequency [Hz]", 1),
        "centre_distance": ("centre distance [mm]", 1e3),
        "hunting_period": ("hunting period [cycles]", 1),
    }
    tables = [
        table("Stages", columns_of(result, "stage", stages)),
        table("Bodies", columns_of(result, "body", bodies)),
        table("Gears", columns_of(result, "gear", gears)),
        table("Meshes", columns_of(result, "mesh", meshes)),
    ]
    if result.sizes.get("order_name"):
        orders = {"order_frequency": ("frequency [Hz]", 1), "order": ("mesh orders", 1)}
        tables.append(table("Shaft and mesh frequencies", columns_of(result, "order_name", orders)))
    if any(str(path).startswith("couplings.") for path in result.path.values):
        paths = {
            "path_from": ("from", 1),
            "path_to": ("to", 1),
            "path_torque": ("torque [N m]", 1),
            "path_power": ("power [kW]", 1e-3),
            "path_share": ("share of the input [%]", 100),
            "path_circulating": ("circulates", 1),
        }
        tables.append(
            table("Power paths (from first to second, seen from the housing)", columns_of(result, "path", paths))
        )
    return [*tables, _links(result), *_values(result)]


def _links(result: xr.Dataset) -> Table:
    stiffness = np.atleast_2d(result.link_stiffness.values)
    units = {"x": "N/m", "y": "N/m", "z": "N/m", "rx": "N m/rad", "ry": "N m/rad", "rz": "N m/rad"}
    columns: dict[str, Any] = {"link": list(map(str, result.link.values))}
    for at, direction in enumerate(result.direction.values):
        columns[f"{direction} [{units[str(direction)]}]"] = list(stiffness[:, at]) if len(columns["link"]) else []
    return table("Supports, bearings, couplings (inf = rigid)", columns)


def _values(result: xr.Dataset) -> list[Table]:
    assumed = json.loads(result.attrs.get("assumed", "{}"))
    values = json.loads(result.attrs.get("values", "[]"))
    tables = []
    if assumed:
        tables.append(table("Assumed", {"path": list(assumed), "why": [str(reason) for reason in assumed.values()]}))
    if values:
        shown = [number(value) if not isinstance(value, str) else value for _, value, _, _ in values]
        columns = {
            "path": [path for path, *_ in values],
            "value": shown,
            "unit": [unit for _, _, unit, _ in values],
            "from": [origin for *_, origin in values],
        }
        tables.append(table("Every value and where it came from", columns))
    return tables


def modes_tables(result: xr.Dataset) -> list[Table]:
    columns: dict[str, Any] = {
        "mode": list(map(int, result.mode.values)),
        "frequency [Hz]": list(result.frequency.values),
        "kind": list(map(str, result.mode_kind.values)),
        "multiplicity": list(map(int, result.multiplicity.values)),
        "damping ratio": list(result.damping_ratio.values),
        "most strain energy in": _largest(result.strain_energy_share, "connection"),
        "most kinetic energy in": _largest(result.kinetic_energy_share, "body"),
    }
    return [table("Modes", columns)]


def _largest(share: xr.DataArray, dim: str) -> list[str]:
    values = share.transpose(dim, "mode").values
    names = share[dim].values
    texts = []
    for column in values.T:
        if not np.isfinite(column).any():
            texts.append("")
            continue
        at = int(np.nanargmax(column))
        texts.append(f"{names[at]} {column[at]:.0%}")
    return texts


def campbell_tables(result: xr.Dataset) -> list[Table]:
    speeds = result.relative_speed.values
    frequency = result.whirl_frequency.transpose("mode", "relative_speed").values
    picked = np.unique(np.linspace(0, len(speeds) - 1, 5).round().astype(int))
    columns: dict[str, Any] = {"mode": list(map(int, result.mode.values))}
    for at in picked:
        columns[f"{speeds[at]:.3g} x speed [Hz]"] = list(frequency[:, at])
    return [table("Natural frequencies over speed", columns)]


def stiffness_tables(result: xr.Dataset) -> list[Table]:
    history = result.mesh_stiffness.transpose("mesh", "mesh_phase").values * 1e-6
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "mean [N/um]": list(result.mean_mesh_stiffness.values * 1e-6),
        "least [N/um]": list(history.min(axis=1)),
        "most [N/um]": list(history.max(axis=1)),
    }
    return [table("Mesh stiffness along the tooth normal", columns)]
