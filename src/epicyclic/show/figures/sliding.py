"""Sliding and load of the teeth along the path of contact."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, pair_title
from .style import DASHES, PALETTE, panels

__all__ = ["sliding"]

# Specific sliding beyond this is near a base tangent point, where it has no bound: the curve leaves the panel there.
_MOST = 3.0


def sliding(result: xr.Dataset) -> go.Figure:
    """Sliding speed [m/s], specific sliding [1] and load [1] of every pair over the path of contact [base pitches].

    Parameters
    ----------
    result : Dataset of `efficiency`: contact_place, sliding_speed, specific_sliding_a, specific_sliding_b, path_load
        (mesh_pair, flank_place).
    """
    names = [str(name).split(".") for name in result["mesh_pair"].values]  # stages.main.meshes.sun-planet
    several = len({parts[1] for parts in names}) > 1
    drawn = panels(
        "Sliding and load along the path of contact",
        [
            "sliding speed, first gear less second",
            "specific sliding of the first gear; of the second, dotted",
            "mesh force per base pitch and mesh force",
        ],
        height=820,
        shared_xaxes=True,
        vertical_spacing=0.07,
    )
    place = result["contact_place"].values
    rows = [(1, "sliding_speed", "solid"), (2, "specific_sliding_a", "solid"), (2, "specific_sliding_b", "dot")]
    for row, variable, dash in [*rows, (3, "path_load", "solid")]:
        values = result[variable].values
        for i, parts in enumerate(names):
            line = {"color": PALETTE[i % len(PALETTE)], "width": 1.8}
            name = pair_title((parts[1], parts[-1]), several)
            drawn.add_trace(
                go.Scatter(
                    x=compact(place[i]),
                    y=compact(_within(values[i]) if row == 2 else values[i]),
                    mode="lines",
                    line={**line, "dash": dash if row == 2 else DASHES[i // len(PALETTE) % len(DASHES)]},
                    name=name,
                    legendgroup=name,
                    showlegend=row == 1,
                ),
                row=row,
                col=1,
            )
    for row, title in enumerate(("sliding speed [m/s]", "specific sliding [1]", "load [1]"), start=1):
        drawn.update_yaxes(title_text=title, row=row, col=1)
    least = min(float(np.nanmin(_within(result[name].values))) for name in ("specific_sliding_a", "specific_sliding_b"))
    drawn.update_yaxes(range=[1.1 * max(least, -_MOST), 1.2], row=2, col=1)
    drawn.update_yaxes(rangemode="tozero", row=3, col=1)
    drawn.update_xaxes(title_text="place from the pitch point [base pitches]", row=3, col=1)
    return drawn


def _within(values: Array) -> Array:
    """Specific sliding [1] of any shape, nan far outside the panel."""
    return np.where(np.abs(values) <= 2 * _MOST, values, np.nan)
