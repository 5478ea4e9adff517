"""Mesh forces over time, with the mesh frequency where it changes."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, Series, compact, merged, pair_title, pairs, texts, thinned
from .style import DASHES, INK, branch_colour, panels
from .summaries import of_first_stage, ramps

__all__ = ["transient_forces"]

# Samples of a curve: more than pixels across.
_MOST = 3000


def transient_forces(result: xr.Dataset) -> go.Figure:
    """Mesh forces [kN] over time [s], a panel a pair of gears, with the mesh frequency [Hz] below where it changes.

    Parameters
    ----------
    result : Dataset of `transient`: mesh_force (mesh, time) [N], mesh_frequency (time) [Hz].
    """
    time = np.asarray(result["time"].values, dtype=np.float64)
    curves = merged(texts(result, "mesh"), result["mesh_force"].transpose("mesh", "time").values / 1e3, branches=True)
    shown = pairs(curves)
    several = len({stage for stage, _ in shown}) > 1
    names = [pair_title(pair, several) for pair in shown] + (
        [f"mesh frequency{of_first_stage(result)}"] if ramps(result) else []
    )
    drawn = panels(
        "Mesh forces over time", names, height=120 + 240 * len(names), shared_xaxes=True,
        vertical_spacing=min(0.12, 0.5 / len(names)),
    )  # fmt: skip
    for row, pair in enumerate(shown, start=1):
        for one in curves:
            if (one.stage, one.pair) == pair:
                drawn.add_trace(_curve(one, time), row=row, col=1)
        drawn.add_hline(y=0, line={"color": INK, "width": 1}, row=row, col=1)
        drawn.update_yaxes(title_text="force [kN]", row=row, col=1)
    if ramps(result):
        x, y = thinned(time, np.asarray(result["mesh_frequency"].values, dtype=np.float64), most=_MOST)
        line = {"color": INK, "width": 1.6}
        trace = go.Scatter(x=compact(x, digits=7), y=compact(y), mode="lines", line=line, showlegend=False)
        drawn.add_trace(trace, row=len(names), col=1)
        drawn.update_yaxes(title_text="frequency [Hz]", row=len(names), col=1)
    drawn.update_xaxes(title_text="time [s]", row=len(names), col=1)
    _once(drawn)
    return drawn


def _curve(one: Series, time: Array) -> go.Scatter:
    """One curve over time (k,) [s], thinned."""
    x, y = thinned(time, one.values, most=_MOST)
    dash = "solid" if not one.side or one.side.startswith("l") else DASHES[2]
    return go.Scatter(
        x=compact(x, digits=7),
        y=compact(y),
        mode="lines",
        name=one.label,
        legendgroup=one.label,
        line={"color": branch_colour(one.branch), "dash": dash, "width": 1.1},
        hovertemplate=f"{one.label}: %{{y:.4g}} kN at %{{x:.5g}} s<extra></extra>",
    )


def _once(drawn: go.Figure) -> None:
    """Every name once in the legend."""
    seen: set[str] = set()
    for trace in drawn.data:
        if trace.name in seen:
            trace.showlegend = False
        seen.add(trace.name)
