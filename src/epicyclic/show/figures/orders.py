"""Shaft and mesh frequencies on one axis."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import engineering, numbers, texts
from .style import INK, figure

__all__ = ["orders"]


def orders(check: xr.Dataset) -> go.Figure:
    """Shaft and mesh frequencies [Hz] at the operating point, with their orders of the mesh frequency.

    Parameters
    ----------
    check : Dataset of `check`: order_frequency [Hz], order (order_name) [1].
    """
    names, hertz = _unstaged(texts(check, "order_name")), numbers(check, "order_frequency", "order_name")
    order = numbers(check, "order", "order_name")
    rank = [int(place) for place in np.argsort(-hertz, kind="stable") if hertz[place] > 0]
    labels = [names[place] for place in rank]
    drawn = figure("Shaft and mesh frequencies", x="frequency [Hz]", height=140 + 28 * len(rank))
    stems = [value for place in rank for value in (1e-9, float(hertz[place]), None)]
    rows = [value for name in labels for value in (name, name, None)]
    drawn.add_trace(go.Scatter(x=stems, y=rows, mode="lines", line={"color": "#C5CCD3", "width": 2}, hoverinfo="skip"))
    drawn.add_trace(
        go.Scatter(
            x=[float(hertz[place]) for place in rank],
            y=labels,
            mode="markers+text",
            marker={"size": 11, "color": ["#D55E00" if name.endswith("mesh") else INK for name in labels]},
            text=[f"{engineering(float(hertz[at]))} Hz · order {engineering(float(order[at]))}" for at in rank],
            textposition="middle right",
            cliponaxis=False,
            hoverinfo="skip",
        )
    )
    low, high = (float(hertz[rank].min()), float(hertz[rank].max())) if rank else (1.0, 10.0)
    span = [np.floor(np.log10(low) - 0.1), np.log10(high) + 0.45 * (np.log10(high / low) + 1)]
    drawn.update_xaxes(type="log", range=span, dtick=1)
    drawn.update_yaxes(autorange="reversed", showgrid=False)
    drawn.update_layout(showlegend=False)
    return drawn


def _unstaged(names: list[str]) -> list[str]:
    """``main.sun turning`` -> ``sun turning`` where there is one stage only."""
    stages = {name.split(".")[0] for name in names if "." in name.split(" ")[0]}
    if len(stages) != 1:
        return names
    stage = stages.pop()
    return [name.removeprefix(f"{stage}.").removeprefix(f"{stage} ") for name in names]
