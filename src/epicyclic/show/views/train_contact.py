"""`train-contact`: tooth contact of all meshes at once, in the equilibrium of the train."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Drawing, Section, Table

if TYPE_CHECKING:
    import xarray as xr

ORDER = 160


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Meshes at the operating torque, then K_gamma and the largest K_Hbeta over the torque."""
    return [_meshes(result), _torques(result)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Load along every face, and load factors over the torque."""
    from ..charts.flanks import face_loads, load_factors

    parts = [
        Drawing(anchor="faces", figure=face_loads(result)),
        Drawing(anchor="factors", figure=load_factors(result)),
    ]
    return [Section(anchor="train_contact", title="Teeth in contact in the train", parts=parts)]


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
    if "largest_root_stress" in at:
        columns |= {
            f"root stress {gear} [MPa]": list(at.largest_root_stress.sel(mesh_gear=gear).values / 1e6)
            for gear in map(str, at.mesh_gear.values)
        }
    return Table(title="Tooth contact in the train, at the operating torque", columns=columns)


def _torques(result: xr.Dataset) -> Table:
    full = [str(pair).split(".") for pair in result.mesh_pair.values]  # stages.main.meshes.sun-planet
    one_stage = len({parts[1] for parts in full}) == 1
    pairs = [parts[-1] if one_stage else f"{parts[1]} {parts[-1]}" for parts in full]
    columns: dict[str, Any] = {
        "torque per operating": list(result.torque_factor.values),
        **{f"K_gamma {pair}": list(result.branch_load_factor.values[:, i]) for i, pair in enumerate(pairs)},
        "largest K_Hbeta": list(result.face_load_factor.values.max(axis=1)),
        "largest load [N/mm]": list(result.largest_load_per_length.values.max(axis=1) / 1e3),
    }
    return Table(title="Load factors over the torque", columns=columns)
