"""Tables of `contact --train`: every mesh at the operating torque, and what changes with the torque."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

if TYPE_CHECKING:
    import xarray as xr

from .tables import table

__all__ = ["train_contact_tables"]


def train_contact_tables(result: xr.Dataset) -> list[Table]:
    """Meshes at the operating torque, then K_gamma and the largest K_Hbeta over the torque."""
    return [_meshes(result), _torques(result)]


def _meshes(result: xr.Dataset) -> Table:
    at = result.isel(torque_factor=int(np.argmin(np.abs(result.torque_factor.values - 1.0))))
    columns: dict[str, Any] = {
        "mesh": [str(name) for name in at.mesh.values],
        "mean force [N]": list(at.mesh_force.mean("time").values),
        "least [N]": list(at.mesh_force.min("time").values),
        "largest [N]": list(at.mesh_force.max("time").values),
        "K_Hbeta": list(at.face_load_factor.values),
        "share of its side": list(at.side_share.values),
        "largest load [N/mm]": list(at.largest_load_per_length.values / 1e3),
    }
    return table("Tooth contact in the train, at the operating torque", columns)


def _torques(result: xr.Dataset) -> Table:
    pairs = [str(pair).split(".")[-1] for pair in result.mesh_pair.values]
    columns: dict[str, Any] = {
        "torque per operating": list(result.torque_factor.values),
        **{f"K_gamma {pair}": list(result.branch_load_factor.values[:, i]) for i, pair in enumerate(pairs)},
        "largest K_Hbeta": list(result.face_load_factor.values.max(axis=1)),
        "largest load [N/mm]": list(result.largest_load_per_length.values.max(axis=1) / 1e3),
    }
    return table("Load factors over the torque", columns)
