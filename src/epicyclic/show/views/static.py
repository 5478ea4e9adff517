"""`static`: mesh forces at rest, and what twists under a torque: necks, shafts, couplings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Drawing, Section, Table
from ..rows import force_table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ORDER", "sections", "tables"]

ORDER = 50


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Mesh forces [N]; torque [N m] and twist [µrad] of the links that carry a torque."""
    force = result.link_force.transpose("link_row", "time").values
    twist = result.link_deflection.transpose("link_row", "time").values
    largest = float(np.abs(force).max(initial=0.0))
    rows = [i for i, name in enumerate(result.link_row.values) if str(name).endswith("/rz")]
    # a torque below 1e-9 of the largest force is rounding
    torsion = [i for i in rows if np.abs(force[i]).max() > 1e-9 * largest]
    columns: dict[str, Any] = {
        "link": [str(result.link_row.values[i]).removesuffix("/rz") for i in torsion],
        "mean torque [N m]": [float(force[i].mean()) for i in torsion],
        "mean twist [µrad]": [float(twist[i].mean()) * 1e6 for i in torsion],
        "most [µrad]": [float(np.abs(twist[i]).max()) * 1e6 for i in torsion],
    }
    title = "Torsion of supports, necks, shafts and couplings"
    return [force_table(result), *([Table(title=title, columns=columns)] if torsion else [])]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Mesh forces over the record."""
    from ..figures.mesh_forces import mesh_forces

    parts = [Drawing(anchor="static-forces", figure=mesh_forces(result))] if "mesh_force" in result.variables else []
    return [Section(anchor="static", title="Static forces", parts=parts)]
