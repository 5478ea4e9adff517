"""What figures over speed share: the abscissa, natural frequencies, the operating point, speeds without a solution."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, numbers, texts
from .style import INK, WARNING, lines_across, mode_colour, translucent
from .summaries import mode_groups

__all__ = ["abscissa", "mark_failed", "mark_natural", "mark_operating"]


def abscissa(sweep: xr.Dataset) -> tuple[Array, str]:
    """Mesh frequency of the first stage [Hz], or speed [%], and the title of the axis."""
    if "mesh_frequency" in sweep.variables:
        tones = sweep["mesh_frequency"]
        first = tones.isel(stage=0) if "stage" in tones.dims else tones
        return np.asarray(first.values, dtype=np.float64), "mesh frequency [Hz]"
    return 100 * numbers(sweep, "speed"), "speed [% of the operating speed]"


def mark_failed(drawn: go.Figure, sweep: xr.Dataset, x: Array) -> None:
    """Points that did not converge, as crosses on the axis x (speed,) [Hz]."""
    bad = [place for place, status in enumerate(texts(sweep, "status", "speed")) if status not in ("ok", "")]
    if bad:
        look = {"symbol": "x", "size": 9, "color": WARNING}
        at = [float(x[place]) for place in bad]
        points = go.Scatter(
            x=at,
            y=[0.0] * len(at),
            mode="markers",
            marker=look,
            name="no convergence",
            cliponaxis=False,
            legendgroup="marks",
        )
        drawn.add_trace(points)


def mark_natural(drawn: go.Figure, modes: xr.Dataset | None, x: Array) -> None:
    """Natural frequencies within x (speed,) [Hz], as lines behind the curves, in the colour of their kind."""
    if modes is None or not len(x):
        return
    inside = [one for one in mode_groups(modes) if float(x.min()) <= one.frequency <= float(x.max())]
    looks = {
        kind: {"color": translucent(mode_colour(kind), 0.75), "width": 1.1, "dash": "dot"}
        for kind in dict.fromkeys(one.kind for one in inside)
    }
    lines_across(drawn, [(one.frequency, {"line": looks[one.kind], "layer": "below"}) for one in inside])
    for kind, line in looks.items():
        key = go.Scatter(x=[None], y=[None], mode="lines", line=line, name=f"{kind} mode", legendgroup="marks")
        drawn.add_trace(key)


def mark_operating(drawn: go.Figure, sweep: xr.Dataset, x: Array) -> None:
    """The operating speed, where it lies within x (speed,) [Hz], as a line."""
    speed = numbers(sweep, "speed", "speed")
    if not len(speed) or not speed.min() <= 1 <= speed.max():
        return
    rank = np.argsort(speed)
    at = float(np.interp(1.0, speed[rank], x[rank]))
    line = {"color": INK, "width": 1.5}
    lines_across(drawn, [(at, {"line": line})])
    key = go.Scatter(x=[None], y=[None], mode="lines", line=line, name="operating point", legendgroup="marks")
    drawn.add_trace(key)
