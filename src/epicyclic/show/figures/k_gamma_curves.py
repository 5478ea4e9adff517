"""Panels of K_gamma at 50, 95 and 99 % over one number each, side by side at one scale."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, numbers
from .style import INK, PALETTE, panels
from .tolerance_labels import DRAWN, percent

__all__ = ["ACROSS", "add_curves", "drawn_at", "finished", "k_gamma_panels", "probabilities"]

ACROSS = 3
"""Panels side by side."""

_COLOURS = dict(zip(DRAWN, (PALETTE[2], PALETTE[0], PALETTE[1]), strict=True))


def k_gamma_panels(title: str, names: list[str]) -> go.Figure:
    """An empty figure with a panel for each name."""
    columns = min(ACROSS, max(len(names), 1))
    rows = -(-len(names) // columns)
    gap = {"vertical_spacing": min(0.3, 90 / (110 + 240 * rows)), "horizontal_spacing": 0.05}
    return panels(title, names, height=150 + 240 * rows, columns=columns, shared_yaxes="all", **gap)


def probabilities(result: xr.Dataset) -> list[tuple[int, float]]:
    """Place and value of the probabilities that are drawn; all of a result without those."""
    given = numbers(result, "probability")
    found = [(int(i), p) for p in DRAWN for i in np.flatnonzero(np.isclose(given, p))]
    return found or [(i, float(p)) for i, p in enumerate(given)]


def add_curves(drawn: go.Figure, result: xr.Dataset, x: Array, values: Array, panel: int) -> None:
    """One curve a probability in a panel, counted from 0.

    Parameters
    ----------
    x : (k,).  values : K_gamma (k, probability) [1]; nan where it was not computed.
    """
    row, column = divmod(panel, ACROSS)
    for place, (i, p) in enumerate(probabilities(result)):
        known = np.isfinite(values[:, i])
        colour = _COLOURS.get(p, PALETTE[(3 + place) % len(PALETTE)])
        drawn.add_trace(
            go.Scatter(
                **{"x": compact(x[known], digits=7), "y": compact(values[known, i], digits=6), "mode": "lines+markers"},
                **{"name": percent(p), "legendgroup": percent(p), "showlegend": panel == 0},
                **{"line": {"color": colour, "width": 2}, "marker": {"size": 5}},
                hovertemplate=f"{percent(p)}: Kγ %{{y:.3f}} at %{{x}}<extra></extra>",
            ),
            row=row + 1,
            col=column + 1,
        )


def drawn_at(drawn: go.Figure, x: float, panel: int) -> None:
    """A line at the value of the model in a panel, counted from 0."""
    row, column = divmod(panel, ACROSS)
    drawn.add_vline(x=x, line={"color": INK, "width": 1, "dash": "dot"}, row=row + 1, col=column + 1)


def finished(drawn: go.Figure, count: int) -> go.Figure:
    """The figure with the titles of its axes of K_gamma, numbers on every panel's own, and its legend."""
    for row in range(-(-count // ACROSS)):
        drawn.update_yaxes(title_text="Kγ [-]", row=row + 1, col=1)
    drawn.update_xaxes(showticklabels=True)
    legend = {"orientation": "h", "x": 1, "xanchor": "right", "y": 0.99, "yanchor": "top", "yref": "container"}
    return drawn.update_layout(showlegend=True, legend=legend, margin={**drawn.layout.margin.to_plotly_json(), "t": 84})
