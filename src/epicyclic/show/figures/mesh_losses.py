"""Power lost in the meshes of each pair, as bars."""

from __future__ import annotations

import plotly.graph_objects as go
import xarray as xr

from .series import engineering, numbers, texts
from .style import PALETTE, figure
from .summaries import losses_of_pairs

__all__ = ["mesh_losses"]


def mesh_losses(result: xr.Dataset) -> go.Figure:
    """Power lost in all meshes of each pair [W or kW], with its share of the power into the train [%].

    Parameters
    ----------
    result : Dataset of `efficiency`: mesh_power_loss (mesh) [W], power_in () [W].
    """
    rows = losses_of_pairs(texts(result, "mesh"), numbers(result, "mesh_power_loss"))
    kilo = max((loss for _, _, loss in rows), default=0.0) >= 1e4
    factor, unit = (1e-3, "kW") if kilo else (1.0, "W")
    into = float(result["power_in"])
    stages = list(dict.fromkeys(stage for stage, _, _ in rows))
    drawn = figure(
        "Power lost in the meshes, all branches and sides", x=f"power loss [{unit}]", height=150 + 38 * len(rows)
    )
    labels = [f"{stage} {pair}" if len(stages) > 1 else pair for stage, pair, _ in rows]
    losses = [loss for _, _, loss in rows]
    drawn.add_trace(
        go.Bar(
            x=[float(loss * factor) for loss in losses][::-1],
            y=labels[::-1],
            orientation="h",
            marker={"color": [PALETTE[stages.index(stage) % len(PALETTE)] for stage, _, _ in rows][::-1]},
            text=[f"{engineering(loss * factor)} {unit}, {engineering(100 * loss / into, 3)} %" for loss in losses][
                ::-1
            ],
            textposition="outside",
            cliponaxis=False,
            hovertemplate="%{y}: %{text} of the power into the train<extra></extra>",
        )
    )
    # room for the numbers outside the bars
    drawn.update_xaxes(range=[0.0, 1.35 * factor * max(losses, default=0.0) or 1.0])
    drawn.update_yaxes(showgrid=False)
    drawn.update_layout(bargap=0.35)
    return drawn
