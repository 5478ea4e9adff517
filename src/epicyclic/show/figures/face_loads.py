"""Load along the faces of all meshes of a train."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, engineering, texts
from .style import DASHES, PALETTE, panels
from .summaries import by_pair_and_side

__all__ = ["face_loads"]


def face_loads(result: xr.Dataset) -> go.Figure:
    """Load per face width [N/mm] along the faces at the operating torque, a panel a pair and side, a curve a branch.

    Parameters
    ----------
    result : Dataset of `train_contact`: face_load (torque_factor, mesh, width) [N/m], face_load_factor
        (torque_factor, mesh) [1], width (width) [1].
    """
    now = _now(result)
    groups = by_pair_and_side(texts(result, "mesh"))
    columns = 2 if any(side for _, side in groups) else 1
    factor = result["face_load_factor"].values[now]
    names = [
        f"{pair} {side}".strip() + f": K<sub>Hβ</sub> up to {engineering(float(factor[meshes].max()))}"
        for (pair, side), meshes in groups.items()
    ]
    rows = -(-len(groups) // columns)
    drawn = panels(
        "Load along the faces, mean over the record",
        names,
        height=120 + 300 * rows,
        columns=columns,
        shared_yaxes=True,
        vertical_spacing=0.28 / rows,
    )
    width, load = result["width"].values, result["face_load"].values[now] / 1e3
    for place, meshes in enumerate(groups.values()):
        row, column = place // columns + 1, place % columns + 1
        for i, mesh in enumerate(meshes):
            line = {"color": PALETTE[i % len(PALETTE)], "width": 1.8, "dash": DASHES[i % len(DASHES)]}
            name = f"branch {i + 1}" if len(meshes) > 1 else "mesh"
            drawn.add_trace(
                go.Scatter(
                    x=compact(width),
                    y=compact(load[mesh]),
                    mode="lines",
                    line=line,
                    name=name,
                    legendgroup=name,
                    showlegend=place == 0,
                ),
                row=row,
                col=column,
            )
        drawn.update_xaxes(title_text="place along the face, left to right [1]", range=[0, 1], row=row, col=column)
        drawn.update_yaxes(rangemode="tozero", row=row, col=column)
        if column == 1:
            drawn.update_yaxes(title_text="load per width [N/mm]", row=row, col=column)
    return drawn


def _now(result: xr.Dataset) -> int:
    return int(np.argmin(np.abs(result["torque_factor"].values - 1.0)))
