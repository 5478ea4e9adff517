"""Where the energy of each mode sits: strain energy by connection, kinetic energy by body, as two heat maps."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, engineering, numbers, texts
from .style import panels
from .summaries import summed_shares

__all__ = ["energy_shares"]

_SCALE = [[0.0, "#FFFFFF"], [0.15, "#DCE9F5"], [0.4, "#8FBCE0"], [0.7, "#3B86C2"], [1.0, "#0B4F86"]]


def energy_shares(modes: xr.Dataset, *, most: int = 40) -> go.Figure:
    """Strain-energy shares of the connections and kinetic-energy shares of the bodies [%] in every mode.

    Parameters
    ----------
    modes : Dataset of `modes`: strain_energy_share (connection, mode), kinetic_energy_share (body, mode) [1],
        frequency (mode) [Hz].
    most : modes shown at most, the lowest.
    """
    shown = modes.isel(mode=slice(0, most))
    strain = summed_shares(
        texts(shown, "connection"), shown["strain_energy_share"].transpose("connection", "mode").values
    )
    kinetic = summed_shares(texts(shown, "body"), shown["kinetic_energy_share"].transpose("body", "mode").values)
    heights = [len(strain[0]), len(kinetic[0])]
    drawn = panels(
        "Where the energy of each mode sits",
        ["strain energy of the connections", "kinetic energy of the bodies"],
        height=240 + 26 * sum(heights),
        row_heights=[value / sum(heights) for value in heights],
        vertical_spacing=min(0.3, 64 / (100 + 26 * sum(heights))),
        shared_xaxes=True,
    )
    hertz = numbers(shown, "frequency")
    for row, (names, shares) in enumerate((strain, kinetic), start=1):
        drawn.add_trace(_map(names, shares, hertz), row=row, col=1)
    drawn.update_yaxes(autorange="reversed", showgrid=False)
    ticks = [f"{place + 1}: {engineering(float(value))}" for place, value in enumerate(hertz)]
    drawn.update_xaxes(
        tickmode="array", tickvals=list(range(len(hertz))), ticktext=ticks, tickangle=-90, showgrid=False
    )
    drawn.update_xaxes(title_text="mode: natural frequency [Hz]", row=2, col=1)
    drawn.update_xaxes(showticklabels=False, row=1, col=1)
    title = {"text": "share [%]", "side": "right", "font": {"size": 13}}
    bar = {"title": title, "thickness": 14, "outlinewidth": 0, "tickfont": {"size": 12}}
    drawn.update_layout(coloraxis={"colorscale": _SCALE, "cmin": 0, "cmax": 100, "colorbar": bar})
    return drawn


def _map(names: list[str], shares: Array, hertz: Array) -> go.Heatmap:
    """Heat map of shares (g, modes) [1] in percent over the modes, whose frequencies (modes,) [Hz] are named."""
    percent = np.round(100 * shares, 1)
    words = [[f"{value:.0f}" if value >= 4.5 else "" for value in row] for row in percent]
    return go.Heatmap(
        z=percent.tolist(),
        x=list(range(len(hertz))),
        y=names,
        text=words,
        texttemplate="%{text}",
        textfont={"size": 10},
        customdata=[[engineering(float(value)) for value in hertz]] * len(names),
        hovertemplate="%{y}: %{z:.1f} %<br>mode at %{customdata} Hz<extra></extra>",
        coloraxis="coloraxis",
        xgap=1,
        ygap=1,
    )
