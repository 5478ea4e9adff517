"""Growth rate over speed and a second parameter, with the boundaries of averaging."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .instability import KINDS, LABELS, apart
from .series import Array, compact, engineering, numbers, texts
from .style import INK, PALE, PALETTE, figure, note
from .summaries import stability_verdict

__all__ = ["stability_map"]

_CURVES = 24
# part of the colour bar below zero
_DECAYS = 0.08


def stability_map(result: xr.Dataset) -> go.Figure:
    """Growth rate [1/s] over mesh frequency [Hz] and a parameter, with predicted boundaries as lines.

    Parameters
    ----------
    result : Dataset of `stability` with a second parameter: growth_rate, instability (value, speed),
        mesh_frequency (speed) [Hz], resonance_low, resonance_high (value, resonance) [Hz].
    """
    x, name = numbers(result, "mesh_frequency"), str(result.attrs.get("over", "value"))
    unit = str(result["value"].attrs.get("units", ""))
    texted = result["value"].dtype.kind not in "fiu"
    y = np.arange(result.sizes["value"], dtype=float) if texted else numbers(result, "value")
    rate = result["growth_rate"].transpose("value", "speed").values
    kind = result["instability"].transpose("value", "speed").values.astype(str)
    grows = np.isin(kind, list(KINDS))
    drawn = figure(
        stability_verdict(kind, "points"), x="mesh frequency [Hz]", y=f"{name} [{unit}]" if unit else name, height=520
    )
    drawn.add_trace(_cells(x, y, rate, grows))
    _boundaries(drawn, result, y)
    if texted:
        drawn.update_yaxes(tickvals=list(y), ticktext=texts(result, "value"))
    drawn.update_xaxes(range=[float(x.min()), float(x.max())], showgrid=False)
    drawn.update_yaxes(range=[float(y.min()), float(y.max())] if len(y) > 1 else None, showgrid=False)
    return drawn.update_layout(showlegend=True, legend={"y": -0.18, "yanchor": "top", "orientation": "h", "x": 0})


def _cells(x: Array, y: Array, rate: Array, grows: np.ndarray) -> go.Heatmap:
    """Growth rate (values, P) [1/s] over x (P,) [Hz] and y (values,): pale where it decays, blank where it failed."""
    top = float(np.max(rate[grows], initial=0.0)) or 1.0
    shown = np.where(np.isfinite(rate), np.where(grows, rate, -_DECAYS * top), np.nan)
    edge = _DECAYS / (1 + _DECAYS)
    return go.Heatmap(
        x=compact(x, digits=7),
        y=compact(y, digits=7),
        z=[compact(row) for row in shown],
        customdata=[compact(row) for row in rate],
        zmin=-_DECAYS * top,
        zmax=top,
        colorscale=[[0, "#E4EEF7"], [edge, "#E4EEF7"], [edge, "#FDE3C8"], [0.5 + edge / 2, PALETTE[1]], [1, "#7A1F00"]],
        colorbar={
            "title": {"text": "growth rate [1/s]", "side": "right"},
            "tickvals": [-_DECAYS * top / 2, top / 4, top / 2, top],
            "ticktext": ["decays", *(engineering(value * top, 3) for value in (0.25, 0.5, 1.0))],
            "len": 0.9,
        },
        hovertemplate="%{x:.5g} Hz, %{y:.4g}: %{customdata:.4g} 1/s<extra></extra>",
    )


def _boundaries(drawn: go.Figure, result: xr.Dataset, y: Array) -> None:
    """Both ends [Hz] of every predicted range over the parameter y (values,), one line that turns where it closes."""
    low, high = (result[f"resonance_{name}"].transpose("value", "resonance").values for name in ("low", "high"))
    names = texts(result, "resonance")
    order = np.argsort(-np.nansum(high - low, axis=0), kind="stable")[:_CURVES]
    for place, one in enumerate(order):
        open_ = np.isfinite(low[:, one])
        line = {"color": INK, "width": 1.3, "dash": "solid" if place < LABELS else "dot"}
        xs, ys = _outline(low[:, one], high[:, one], y, open_)
        drawn.add_trace(
            go.Scatter(
                x=compact(xs, digits=7),
                y=compact(ys, digits=7),
                mode="lines",
                line=line,
                name="predicted boundary (averaging)",
                legendgroup="boundary",
                showlegend=place == 0,
                hovertemplate=f"{names[one]}: %{{x:.5g}} Hz<extra></extra>",
            )
        )
    x = numbers(result, "mesh_frequency")
    centre = np.nanmean((low + high) / 2, axis=0) if len(names) else np.zeros(0)
    for one in apart(order, centre, (x.max() - x.min()) / 10, x):
        inside = np.flatnonzero(np.isfinite(low[:, one]))
        # at the top of the map, unless the range closes below it
        closes = inside[-1] < len(y) - 1 and inside.size > 1
        at = float(y[inside[-1]])
        note(
            drawn,
            names[one],
            x=centre[one],
            y=at,
            yanchor="bottom",
            font={"size": 12, "color": INK if closes else PALE},
        )


def _outline(low: Array, high: Array, y: Array, open_: np.ndarray) -> tuple[Array, Array]:
    """Up the lower and down the upper ends (values,) [Hz] of each run of values at which a range is open."""
    xs: list[float] = []
    ys: list[float] = []
    runs = np.split(np.arange(len(y)), np.flatnonzero(open_[1:] != open_[:-1]) + 1)
    for run in runs:
        if not open_[run[0]]:
            continue
        # an edge of the map is no end of the range
        first, last = run[0] == 0, run[-1] == len(y) - 1
        down, up = (low[run], y[run]), (high[run], y[run])
        if first and not last:
            parts = (down, (up[0][::-1], up[1][::-1]))
        else:
            parts = ((down[0][::-1], down[1][::-1]), up)
        xs += [*parts[0][0], *parts[1][0], np.nan]
        ys += [*parts[0][1], *parts[1][1], np.nan]
    return np.array(xs), np.array(ys)
