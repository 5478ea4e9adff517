"""Floquet multiplier and growth rate over speed, with the ranges predicted by averaging."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .instability import KINDS, apart
from .series import Array, compact, numbers, texts
from .style import INK, PALE, WARNING, note, panels, translucent
from .summaries import stability_verdict

__all__ = ["stability_over_speed"]


def stability_over_speed(result: xr.Dataset) -> go.Figure:
    """Largest Floquet multiplier [1] and growth rate [1/s] over mesh frequency [Hz], unstable speeds in colour.

    Ranges predicted by averaging are bands.

    Parameters
    ----------
    result : Dataset of `stability` without a second parameter: largest_multiplier, growth_rate, instability,
        taking_part, mesh_frequency (speed), resonance_low, resonance_high, resonance_growth (resonance).
    """
    x = numbers(result, "mesh_frequency")
    rank = np.argsort(x)
    kind = np.array(texts(result, "instability"))[rank]
    shown = (("largest_multiplier", "largest |μ| [-]", 1.0), ("growth_rate", "growth rate [1/s]", 0.0))
    drawn = panels(stability_verdict(kind, "speeds"), ("", ""), height=560, shared_xaxes=True, vertical_spacing=0.06)
    for row, (name, words, limit) in enumerate(shown, start=1):
        values = numbers(result, name)[rank]
        curve = go.Scatter(
            x=compact(x[rank]), y=compact(values), mode="lines", line={"color": PALE, "width": 1.6}, showlegend=False
        )
        drawn.add_trace(curve, row=row, col=1)
        _marks(drawn, result, x[rank], values, kind, rank, row)
        drawn.add_hline(y=limit, line={"color": INK, "width": 1.2, "dash": "dash"}, row=row, col=1)
        drawn.update_yaxes(title_text=words, row=row, col=1)
    drawn.update_xaxes(title_text="mesh frequency [Hz]", row=2, col=1)
    _bands(drawn, result, x)
    return drawn.update_layout(showlegend=True)


def _marks(
    drawn: go.Figure, result: xr.Dataset, x: Array, values: Array, kind: np.ndarray, rank: np.ndarray, row: int
) -> None:
    """Unstable speeds x (P,) [Hz] at their values (P,), a colour for each kind."""
    taking = np.array(texts(result, "taking_part"))[rank]
    for name, (colour, words) in KINDS.items():
        at = kind == name
        if at.any():
            points = go.Scatter(
                x=compact(x[at]),
                y=compact(values[at]),
                mode="markers",
                marker={"color": colour, "size": 6},
                name=words,
                legendgroup=name,
                showlegend=row == 1,
                customdata=taking[at],
                hovertemplate="%{x:.5g} Hz: %{y:.4g}<br>%{customdata}<extra></extra>",
            )
            drawn.add_trace(points, row=row, col=1)


def _bands(drawn: go.Figure, result: xr.Dataset, x: Array) -> None:
    """Predicted ranges within x (P,) [Hz] as bands behind, the fastest ones named."""
    low, high, rate = (numbers(result, f"resonance_{name}") for name in ("low", "high", "growth"))
    if not low.size:
        return
    fill = translucent(WARNING, 0.10)
    for one, other in zip(low, high, strict=True):
        drawn.add_vrect(x0=one, x1=other, fillcolor=fill, line_width=0, layer="below", row="all", col="all")
    key = {"color": fill, "size": 12, "symbol": "square"}
    drawn.add_trace(
        go.Scatter(x=[None], y=[None], mode="markers", marker=key, name="predicted (averaging)"), row=1, col=1
    )
    names, centre = texts(result, "resonance"), numbers(result, "resonance_centre")
    drawn.update_xaxes(range=[float(x.min()), float(x.max())])
    for place in apart(np.argsort(-rate), centre, (x.max() - x.min()) / 14, x):
        where = {"xref": "x", "yref": "y domain", "xanchor": "left", "yanchor": "bottom"}
        note(drawn, names[place], x=centre[place], y=1.0, textangle=-25, **where)
