"""Mesh forces over time."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .over_time import over_time
from .series import numbers, texts
from .style import WARNING, note

__all__ = ["mesh_forces"]


def mesh_forces(result: xr.Dataset) -> go.Figure:
    """Mesh force of each branch [kN] over time, a panel a pair of gears, a line at 0 where that is near.

    Parameters
    ----------
    result : Dataset of `sharing`, `static` or `steady`: mesh_force (mesh, time or mesh_phase) [N], contact_lost (mesh).
    """
    drawn = over_time(result, "mesh_force", "Mesh forces over time", "force [kN]", 1e-3)
    forces = result["mesh_force"].values
    if forces.size and np.nanmin(forces) < 0.15 * np.nanmax(forces):
        for row in range(1, len(drawn.layout.annotations) + 1):
            drawn.add_hline(y=0, line={"color": WARNING, "width": 1.2}, row=row, col=1)
    lost = [
        name
        for name, value in zip(texts(result, "mesh"), numbers(result, "contact_lost", "mesh"), strict=True)
        if value > 0
    ]
    if lost:
        note(
            drawn,
            f"contact lost in {len(lost)} of {result.sizes['mesh']} meshes",
            xref="paper",
            yref="paper",
            x=1,
            xanchor="right",
            y=1.0,
            yanchor="bottom",
            yshift=24,
            font={"size": 12, "color": WARNING},
        )
    return drawn
