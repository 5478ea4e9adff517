"""Price and K_gamma of the grades found, of one grade finer or coarser in each entry, and of other targets."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, engineering, numbers, texts
from .style import INK, PALE, PALETTE, WARNING, figure, note
from .tolerance_labels import percent, short_entries

__all__ = ["grade_prices"]

# Room for the points on a page of 900 px, and where names may stand against them, nearest first [px].
_WIDE, _TALL, _NEAR = 700.0, 300.0, 15.0
_SHIFTS = (-15.0, 15.0, -30.0, 30.0, -46.0, 46.0, -62.0, 62.0)
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
    said: list[tuple[float, float, str]] = []
    for words, colour, sign, steps in (
        ("one grade finer", _FINER, 1, ("finer_grade", "extra_cost", "finer_k_gamma")),
        ("one grade coarser", _COARSER, -1, ("coarser_grade", "saving", "coarser_k_gamma")),
    ):
        said += _add_neighbours(drawn, result, names, price, words, colour, sign, steps)
    paid = float(result["drawn_price"]) if "drawn_price" in result else np.nan
    if np.isfinite(paid):
        as_drawn = {"x": [paid], "y": [float(result["drawn_k_gamma"])], "name": "as drawn"}
        drawn.add_trace(go.Scatter(**as_drawn, mode="markers", marker={"symbol": "x", "size": 12, "color": INK}))
    star = {"symbol": "star", "size": 18, "color": PALETTE[1]}
    drawn.add_trace(go.Scatter(x=[price], y=[found], mode="markers", marker=star, name="the grades found"))
    drawn.add_hline(y=target, line={"color": WARNING, "width": 1.5, "dash": "dash"})
    note(drawn, "target", x=1, xref="paper", xanchor="right", y=target, yanchor="bottom", font={"color": WARNING})
    _name_points(drawn, said, target)
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
) -> list[tuple[float, float, str]]:
    """Points of one change each, none without a price; their prices, factors and the names of their entries."""
    grade, change, factor = variables
    steps, values, grades = numbers(result, change), numbers(result, factor), texts(result, grade)
    kept = [i for i in range(len(names)) if np.isfinite(steps[i]) and np.isfinite(values[i])]
    if not kept:
        return []
    drawn.add_trace(
        go.Scatter(
            x=[price + sign * float(steps[i]) for i in kept],
            y=compact(values[kept], digits=6),
            **{"mode": "markers", "name": words, "marker": {"size": 9, "color": colour}},
            text=[names[i] for i in kept],
            customdata=[f"{grades[i]}: {'+' if sign > 0 else '−'}{engineering(float(steps[i]))}" for i in kept],
            hovertemplate="%{text}, %{customdata}<br>Kγ %{y:.4f}<extra></extra>",
        )
    )
    return [(price + sign * float(steps[i]), float(values[i]), names[i]) for i in kept]


def _name_points(drawn: go.Figure, said: list[tuple[float, float, str]], target: float) -> None:
    """Names below or above their points, as near as neither the line of the target nor another name or point is met."""
    every = [(float(x), float(y)) for trace in drawn.data for x, y in zip(trace.x, trace.y, strict=True)]
    xs, ys = [x for x, _ in every], [*(y for _, y in every), target]
    right, up = _WIDE / (max(xs) - min(xs) or 1.0), _TALL / (max(ys) - min(ys) or 1.0)  # [px] a price and a factor
    boxes = [(x * right, y * up, 10.0, 10.0) for x, y in every]
    line = (0.5 * (min(xs) + max(xs)) * right, target * up, 4 * _WIDE, 6.0)
    for x, y, name in sorted(said):
        own = (6.2 * len(name), 14.0)
        free = (
            shift
            for shift in _SHIFTS
            if not any(_meet((x * right, y * up + shift, *own), other) for other in [*boxes, line])
        )
        shift = next(free, _SHIFTS[0])
        boxes.append((x * right, y * up + shift, *own))
        arrow = {"showarrow": abs(shift) > _NEAR, "arrowhead": 0, "arrowwidth": 1, "arrowcolor": PALE, "ax": 0}
        where = {"ay": -shift} if abs(shift) > _NEAR else {"yshift": shift}
        note(drawn, name, x=x, y=y, font={"size": 11, "color": INK}, **arrow, **where)


def _meet(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    """Whether two boxes (middle x, y, width, height) [px] lie over each other."""
    return abs(one[0] - other[0]) < (one[2] + other[2]) / 2 and abs(one[1] - other[1]) < (one[3] + other[3]) / 2
