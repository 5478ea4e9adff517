"""Mesh phases on dials, one dial a pair of gears; shaft and mesh frequencies on one axis."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import engineering, merged, numbers, pair_title, pairs, texts
from .style import INK, PALE, branch_colour, figure, panels

__all__ = ["orders", "phases"]


def phases(check: xr.Dataset) -> go.Figure:
    """Phase lead of every mesh on a dial: one turn is one mesh cycle, in the sense of rotation.

    Parameters
    ----------
    check : Dataset of `check`.
    """
    series = merged(texts(check, "mesh"), numbers(check, "phase_lead", "mesh")[:, None])
    dials = pairs(series)
    several = len({stage for stage, _ in dials}) > 1
    columns = min(4, max(1, len(dials)))
    rows = -(-max(1, len(dials)) // columns)
    kinds = [[{"type": "polar"}] * columns for _ in range(rows)]
    names = [pair_title(pair, several) for pair in dials]
    drawn = panels("Phase lead of the meshes", names, height=60 + 300 * rows, columns=columns, specs=kinds)
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


def orders(check: xr.Dataset) -> go.Figure:
    """Shaft and mesh frequencies at the operating point [Hz], with their orders of the mesh frequency.

    Parameters
    ----------
    check : Dataset of `check`.
    """
    names, hertz = _unstaged(texts(check, "order_name")), numbers(check, "order_frequency", "order_name")
    order = numbers(check, "order", "order_name")
    rank = [int(place) for place in np.argsort(-hertz, kind="stable") if hertz[place] > 0]
    labels = [names[place] for place in rank]
    drawn = figure("Shaft and mesh frequencies", x="frequency [Hz]", height=140 + 28 * len(rank))
    stems = [value for place in rank for value in (1e-9, float(hertz[place]), None)]
    rows = [value for name in labels for value in (name, name, None)]
    drawn.add_trace(go.Scatter(x=stems, y=rows, mode="lines", line={"color": "#C5CCD3", "width": 2}, hoverinfo="skip"))
    drawn.add_trace(
        go.Scatter(
            x=[float(hertz[place]) for place in rank],
            y=labels,
            mode="markers+text",
            marker={"size": 11, "color": ["#D55E00" if name.endswith("mesh") else INK for name in labels]},
            text=[f"{engineering(float(hertz[at]))} Hz · order {engineering(float(order[at]))}" for at in rank],
            textposition="middle right",
            cliponaxis=False,
            hoverinfo="skip",
        )
    )
    low, high = (float(hertz[rank].min()), float(hertz[rank].max())) if rank else (1.0, 10.0)
    span = [np.floor(np.log10(low) - 0.1), np.log10(high) + 0.45 * (np.log10(high / low) + 1)]
    drawn.update_xaxes(type="log", range=span, dtick=1)
    drawn.update_yaxes(autorange="reversed", showgrid=False)
    drawn.update_layout(showlegend=False)
    return drawn


def _unstaged(names: list[str]) -> list[str]:
    """``main.sun turning`` -> ``sun turning`` where there is one stage only."""
    stages = {name.split(".")[0] for name in names if "." in name.split(" ")[0]}
    if len(stages) != 1:
        return names
    stage = stages.pop()
    return [name.removeprefix(f"{stage}.").removeprefix(f"{stage} ") for name in names]
