"""Mesh forces with teeth that part: the mean over the slow phases, and the band between least and most."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ...results.ties import ranked
from .series import compact, numbers, texts
from .style import PALETTE, WARNING, figure, translucent

__all__ = ["force_envelopes"]

# Meshes drawn: the one of each pair whose force is largest, and at most so many pairs.
_MOST = 4


def force_envelopes(result: xr.Dataset) -> go.Figure:
    """Force of the most loaded mesh of every pair [kN] over its mesh phase [mesh cycles]: mean and band.

    Parameters
    ----------
    result : Dataset of `steady` with contact loss: mesh_force, mesh_force_least, mesh_force_most (mesh, mesh_phase)
        [N], open_share (mesh) [1].
    """
    drawn = figure(
        "Mesh force, mean and range over all shaft phases", x="mesh phase [mesh cycles]", y="force [kN]", height=440
    )
    phase = numbers(result, "mesh_phase", "mesh_phase")
    mean, least, most = (
        1e-3 * result[name].transpose("mesh", "mesh_phase").values
        for name in ("mesh_force", "mesh_force_least", "mesh_force_most")
    )
    names, apart = texts(result, "mesh"), result["open_share"].values
    for place, row in enumerate(_worst(names, most)):
        colour = PALETTE[place % len(PALETTE)]
        share = f", apart {apart[row]:.0%} of the time" if apart[row] > 0 else ""
        look = {"legendgroup": names[row], "hoverinfo": "skip", "mode": "lines", "line": {"width": 0, "color": colour}}
        drawn.add_trace(go.Scatter(x=compact(phase), y=compact(least[row]), showlegend=False, **look))
        drawn.add_trace(
            go.Scatter(
                x=compact(phase),
                y=compact(most[row]),
                fill="tonexty",
                fillcolor=translucent(colour, 0.22),
                showlegend=False,
                **look,
            )
        )
        drawn.add_trace(
            go.Scatter(
                x=compact(phase),
                y=compact(mean[row]),
                mode="lines",
                name=f"{names[row]}{share}",
                legendgroup=names[row],
                line={"color": colour, "width": 2},
            )
        )
    if np.nanmin(least) < 0.15 * np.nanmax(most):
        drawn.add_hline(y=0, line={"color": WARNING, "width": 1.2})
    drawn.update_layout(showlegend=True)
    return drawn


def _worst(names: list[str], most: np.ndarray) -> list[int]:
    """Row of the largest force (m, phases) of each pair: names without branch and side."""
    found: dict[str, int] = {}
    for row in ranked(np.nanmax(most, axis=1)):
        found.setdefault("/".join(names[int(row)].split("/")[:2]), int(row))
    return list(found.values())[:_MOST]
