"""Load factors K_gamma and K_Hbeta over the torque."""

from __future__ import annotations

import plotly.graph_objects as go
import xarray as xr

from .series import compact, texts
from .style import DASHES, PALETTE, panels
from .summaries import by_pair_and_side

__all__ = ["load_factors"]


def load_factors(result: xr.Dataset) -> go.Figure:
    """K_gamma of every pair and the largest K_Hbeta of every pair and side [1] over the relative torque [1].

    Parameters
    ----------
    result : Dataset of `train_contact`: branch_load_factor (torque_factor, mesh_pair), face_load_factor
        (torque_factor, mesh) [1].
    """
    drawn = panels(
        "Load factors over the torque",
        ["between branches, K<sub>γ</sub>", "along the face, K<sub>Hβ</sub>, largest of the branches"],
        height=620,
        vertical_spacing=0.16,
    )
    torque = compact(result["torque_factor"].values)
    curves = [
        (1, str(pair).split(".")[-1], result["branch_load_factor"].values[:, i])
        for i, pair in enumerate(result["mesh_pair"].values)
    ]
    factor = result["face_load_factor"].values
    curves += [
        (2, f"{pair} {side}".strip(), factor[:, meshes].max(axis=1))
        for (pair, side), meshes in by_pair_and_side(texts(result, "mesh")).items()
    ]
    for i, (row, name, values) in enumerate(curves):
        line = {"color": PALETTE[i % len(PALETTE)], "width": 1.8, "dash": DASHES[i % len(DASHES)]}
        drawn.add_trace(
            go.Scatter(x=torque, y=compact(values), mode="lines+markers", line=line, name=name), row=row, col=1
        )
    for row in (1, 2):
        drawn.update_xaxes(title_text="torque per operating torque [1]", rangemode="tozero", row=row, col=1)
        drawn.update_yaxes(title_text="factor [1]", row=row, col=1)
    return drawn
