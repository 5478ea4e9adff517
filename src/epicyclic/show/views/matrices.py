"""`matrices`: sizes of the matrices, names and units of their rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..elements import Company, Section, Table

if TYPE_CHECKING:
    import xarray as xr

ORDER = 890
_MATRICES = ("M", "C", "G", "K", "B", "L", "T", "F", "excitation", "gap_error")


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Every matrix with its size, every coordinate with its unit, meshes and ports with their numbers."""
    names = [name for name in _MATRICES if name in result.variables]
    sizes: dict[str, Any] = {
        "matrix": names,
        "rows": [result[name].shape[0] for name in names],
        "columns": [result[name].shape[1] for name in names],
        "meaning": [str(result[name].attrs.get("long_name", "")) for name in names],
    }
    coordinates: dict[str, Any] = {
        "row": list(range(1, result.sizes["dof"] + 1)),
        "coordinate": [str(name) for name in result["dof"].values],
        "unit": [str(unit) for unit in result["coordinate_unit"].values],
        "load": [str(unit) for unit in result["load_unit"].values],
    }
    meshes: dict[str, Any] = {
        "mesh row": [str(name) for name in result["mesh_row"].values],
        "mean stiffness [N/m]": list(result["mesh_stiffness"].values),
        "damping [N s/m]": list(result["mesh_damping"].values),
    }
    ports: dict[str, Any] = {
        "port": [str(name) for name in result["port"].values],
        "operating torque [N m]": list(result["port_torque"].values),
    }
    lead = "M q'' + (C + G) q' + K q = F u + B (k e + c e') + load"
    return [
        Table(title="Mean linear system", columns=sizes, lead=lead),
        Table(title="Coordinates", columns=coordinates),
        Table(title="Meshes", columns=meshes),
        Table(title="Ports", columns=ports),
    ]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The tables."""
    return [Section(anchor="matrices", title="Mean linear system", parts=tables(result))]
