"""Stability: Floquet multipliers and growth rates over speed, and over speed and a second parameter.

Beside them stand the ranges and boundaries predicted by averaging.
"""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import Array, compact, engineering, numbers, stability_verdict, texts
from .style import INK, PALE, PALETTE, WARNING, figure, note, panels, translucent

# kind of instability: colour and what it means
_KINDS = {
    "quasi-periodic": (PALETTE[1], "quasi-periodic: two modes together"),
    "period doubling": (PALETTE[3], "period doubling: half mesh orders"),
    "divergence": (PALETTE[6], "divergence: mesh orders"),
}
_LABELS = 8
_CURVES = 24
# part of the colour bar below zero
_DECAYS = 0.08


def _apart(order: np.ndarray, centre: Array, distance: float, x: Array) -> list[int]:
    """The first few places in order (r,) whose centres (r,) stand `distance` apart within x (P,), all [Hz]."""
    kept: list[int] = []
    for place in order:
        inside = x.min() <= centre[place] <= x.max()
        if inside and all(abs(centre[place] - centre[other]) > distance for other in kept):
            kept.append(int(place))
    return kept[:_LABELS]


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
    for name, (colour, words) in _KINDS.items():
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
    for place in _apart(np.argsort(-rate), centre, (x.max() - x.min()) / 14, x):
        where = {"xref": "x", "yref": "y domain", "xanchor": "left", "yanchor": "bottom"}
        note(drawn, names[place], x=centre[place], y=1.0, textangle=-25, **where)


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
    grows = np.isin(kind, list(_KINDS))
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
        line = {"color": INK, "width": 1.3, "dash": "solid" if place < _LABELS else "dot"}
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
    for one in _apart(order, centre, (x.max() - x.min()) / 10, x):
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
