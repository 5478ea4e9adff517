"""Price and K_gamma of the grades found, of one grade finer or coarser in each entry, and of other targets."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, engineering, numbers, texts
from .style import INK, PALE, PALETTE, WARNING, figure, note
from .tolerance_labels import percent, short_entries

__all__ = ["grade_prices"]

_FINER, _COARSER = PALETTE[2], PALETTE[3]


def grade_prices(result: xr.Dataset) -> go.Figure:
    """K_gamma [1] over the total price: the grades found, their neighbours, the drawing, the cheapest of other targets.

    Parameters
    ----------
    result : Dataset of `allocate`: target, total_price, found_k_gamma, drawn_k_gamma, drawn_price; grade, finer_grade,
        coarser_grade, extra_cost, saving, finer_k_gamma, coarser_k_gamma (tolerance); front_price, front_k_gamma
        (front) [1].
    """
    price, found, target = (float(result[name]) for name in ("total_price", "found_k_gamma", "target"))
    p = percent(float(result.attrs["probability"]))
    title = f"Kγ ≤ {engineering(target)} in {p} of the trains for {engineering(price)}"
    drawn = figure(title, x="total price [-]", y=f"Kγ at {p} [-]", height=480)
    if "front_price" in result:
        x, y = numbers(result, "front_price"), numbers(result, "front_k_gamma")
        step = {"line": {"color": PALE, "width": 1.5, "shape": "hv"}, "marker": {"size": 5, "color": PALE}}
        words = "cheapest for other targets"
        trace = go.Scatter(x=compact(x, digits=7), y=compact(y, digits=6), mode="lines+markers", name=words, **step)
        drawn.add_trace(trace)
    names = short_entries(texts(result, "tolerance"))
    for words, colour, sign, steps in (
        ("one grade finer", _FINER, 1, ("finer_grade", "extra_cost", "finer_k_gamma")),
        ("one grade coarser", _COARSER, -1, ("coarser_grade", "saving", "coarser_k_gamma")),
    ):
        _add_neighbours(drawn, result, names, price, words, colour, sign, steps)
    paid = float(result["drawn_price"]) if "drawn_price" in result else np.nan
    if np.isfinite(paid):
        as_drawn = {"x": [paid], "y": [float(result["drawn_k_gamma"])], "name": "as drawn"}
        drawn.add_trace(go.Scatter(**as_drawn, mode="markers", marker={"symbol": "x", "size": 12, "color": INK}))
    star = {"symbol": "star", "size": 18, "color": PALETTE[1]}
    drawn.add_trace(go.Scatter(x=[price], y=[found], mode="markers", marker=star, name="the grades found"))
    drawn.add_hline(y=target, line={"color": WARNING, "width": 1.5, "dash": "dash"})
    note(drawn, "target", x=1, xref="paper", xanchor="right", y=target, yanchor="bottom", font={"color": WARNING})
    legend = {"orientation": "h", "x": 1, "xanchor": "right", "y": 1.0, "yanchor": "bottom"}
    return drawn.update_layout(showlegend=True, legend=legend, margin={"t": 96})


def _add_neighbours(
    drawn: go.Figure,
    result: xr.Dataset,
    names: list[str],
    price: float,
    words: str,
    colour: str,
    sign: int,
    variables: tuple[str, str, str],
) -> None:
    """Points of one change each, named by their entry; none without a price."""
    grade, change, factor = variables
    steps, values, grades = numbers(result, change), numbers(result, factor), texts(result, grade)
    kept = [i for i in range(len(names)) if np.isfinite(steps[i]) and np.isfinite(values[i])]
    if not kept:
        return
    drawn.add_trace(
        go.Scatter(
            x=[price + sign * float(steps[i]) for i in kept],
            y=compact(values[kept], digits=6),
            **{"mode": "markers+text", "name": words, "marker": {"size": 9, "color": colour}},
            **{
                "text": [names[i] for i in kept],
                "textposition": _sides(price + sign * steps[kept]),
                "textfont": {"size": 11},
            },
            customdata=[f"{grades[i]}: {'+' if sign > 0 else '−'}{engineering(float(steps[i]))}" for i in kept],
            hovertemplate="%{text}, %{customdata}<br>Kγ %{y:.4f}<extra></extra>",
        )
    )


def _sides(prices: Array) -> list[str]:
    """Where the words of points (k,) stand: below and above in turn along the axis, so that neighbours keep apart."""
    rank = np.argsort(np.argsort(prices))
    return ["bottom center" if place % 2 == 0 else "top center" for place in rank]
