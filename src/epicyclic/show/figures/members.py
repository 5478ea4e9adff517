"""Speed, external torque and power of every member, as bars about zero."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import engineering
from .style import PALE, kind_colour, panels
from .summaries import members_of

__all__ = ["members"]


def member_label(name: str, several: bool) -> str:
    """``main.sun`` -> ``sun``, ``main sun`` where there are several stages."""
    return name.replace(".", " ") if several else name.split(".")[-1]


def members(check: xr.Dataset) -> go.Figure:
    """Speed [rpm], external torque [N m or kN m] and power into the train [kW] of every member, as bars about zero.

    Parameters
    ----------
    check : Dataset of `check`: member, kind, speed [rpm], torque [N m], power [W] (body).
    """
    found = members_of(check)
    several = len({one.name.split(".")[0] for one in found}) > 1
    labels = [member_label(one.name, several) for one in found][::-1]
    kilo = max((abs(one.torque) for one in found if np.isfinite(one.torque)), default=0.0) >= 1e4
    columns = [
        ("speed [rpm]", [one.speed for one in found]),
        (f"external torque [{'kN m' if kilo else 'N m'}]", [one.torque / (1e3 if kilo else 1) for one in found]),
        ("power into the train [kW]", [one.power / 1e3 for one in found]),
    ]
    drawn = panels(
        "Speed, torque and power of the members",
        [name for name, _ in columns],
        height=150 + 34 * len(found),
        columns=3,
        shared_yaxes=True,
        horizontal_spacing=0.04,
    )
    colours = [kind_colour(one.kind) for one in found][::-1]
    for place, (name, values) in enumerate(columns):
        drawn.add_trace(_bars(values[::-1], labels, colours, name), row=1, col=place + 1)
        drawn.update_xaxes(range=_range(values), zeroline=True, zerolinecolor=PALE, row=1, col=place + 1)
    drawn.update_layout(showlegend=False, bargap=0.35)
    drawn.update_yaxes(showgrid=False)
    return drawn


def _bars(values: list[float], labels: list[str], colours: list[str], name: str) -> go.Bar:
    words = [engineering(value).replace("-", "\u2212") if np.isfinite(value) else "not given" for value in values]
    return go.Bar(
        x=[float(value) if np.isfinite(value) else 0.0 for value in values],
        y=labels,
        orientation="h",
        marker={"color": colours},
        text=words,
        textposition="outside",
        cliponaxis=False,
        hovertemplate="%{y}: %{text}<extra>" + name + "</extra>",
    )


def _range(values: list[float]) -> list[float]:
    """Range of an axis with room for the numbers outside the bars."""
    finite = [value for value in values if np.isfinite(value)]
    low, high = min([0.0, *finite]), max([0.0, *finite])
    span = high - low or 1.0
    return [low - (0.3 * span if low < 0 else 0.03 * span), high + 0.3 * span]
