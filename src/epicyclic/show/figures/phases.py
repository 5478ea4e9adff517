"""Mesh phases on dials, one dial a pair of gears; shaft and mesh frequencies on one axis."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import engineering, merged, numbers, pair_title, pairs, texts
from .style import PALE, branch_colour, panels

__all__ = ["phases"]


def phases(check: xr.Dataset) -> go.Figure:
    """Phase lead of every mesh [mesh cycles] on a dial a pair of gears: one turn is one mesh cycle.

    Parameters
    ----------
    check : Dataset of `check`: phase_lead (mesh) [mesh cycles].
    """
    series = merged(texts(check, "mesh"), numbers(check, "phase_lead", "mesh")[:, None])
    dials = pairs(series)
    several = len({stage for stage, _ in dials}) > 1
    columns = min(4, max(1, len(dials)))
    rows = -(-max(1, len(dials)) // columns)
    kinds = [[{"type": "polar"}] * columns for _ in range(rows)]
    names = [pair_title(pair, several) for pair in dials]
    # ticks left and right of neighbours keep apart on a narrow page too
    apart = {"horizontal_spacing": 0.24 / columns, "specs": kinds}
    drawn = panels("Phase lead of the meshes", names, height=60 + 300 * rows, columns=columns, **apart)
    for place, pair in enumerate(dials):
        own = [one for one in series if (one.stage, one.pair) == pair]
        for trace in _hands([(one.label, one.branch, float(one.values[0])) for one in own]):
            drawn.add_trace(trace, row=place // columns + 1, col=place % columns + 1)
    tick = {"tickvals": [0, 90, 180, 270], "ticktext": ["0", "¼", "½", "¾"], "rotation": 90, "direction": "clockwise"}
    drawn.update_polars(
        angularaxis={**tick, "gridcolor": "#D5DAE0", "linecolor": PALE},
        radialaxis={"visible": False, "range": [0, 1.25]},
        bgcolor="white",
    )
    drawn.update_annotations(yshift=22)
    drawn.update_layout(showlegend=False, margin={"t": 96, "b": 40})
    return drawn


def _hands(found: list[tuple[str, int, float]]) -> list[go.Scatterpolar]:
    """One hand a branch; hands that point the same way are shortened one after the other, so that all are seen."""
    traces, seen = [], list[float]()
    for label, branch, lead in found:
        if not np.isfinite(lead):
            continue
        same = sum(abs((lead - other + 0.5) % 1 - 0.5) < 0.02 for other in seen)
        seen.append(lead)
        length = 1.0 - 0.27 * same
        colour = branch_colour(branch)
        traces.append(
            go.Scatterpolar(
                theta=[0, 360 * lead],
                r=[0, length],
                mode="lines+markers+text",
                text=["", str(branch) if branch else ""],
                textposition="middle center",
                textfont={"color": "white", "size": 12},
                line={"color": colour, "width": 2.5},
                marker={"size": [0, 20], "color": colour, "opacity": 1},
                hoverinfo="text",
                hovertext=f"{label}: lead {engineering(lead)} mesh cycles",
                cliponaxis=False,
                name=label,
            )
        )
    return traces
