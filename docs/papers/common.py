"""What several pages draw alike: still mode shapes side by side, and the marker of published values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import plotly.graph_objects as go
import xarray as xr

from epicyclic.show.charts.mode_shapes import mode_shapes
from epicyclic.show.charts.renderers import INK, panels

__all__ = ["PUBLISHED", "stills"]

PUBLISHED: Mapping[str, Any] = {
    "color": "white",
    "size": 10,
    "symbol": "diamond",
    "line": {"width": 2, "color": INK},
}


def stills(
    check: xr.Dataset, modes: xr.Dataset, chosen: Mapping[str, int], *, title: str, columns: int = 3, height: int = 500
) -> go.Figure:
    """Mode shapes at their turning point over the train at rest.

    Parameters
    ----------
    check, modes : Datasets of `check` and `modes`.  chosen : title of the panel -> mode, 0 the first.
    """
    moving = mode_shapes(check, modes.isel(mode=list(chosen.values())), most=len(chosen))
    frames = {frame.name: frame for frame in moving.frames}
    drawn = panels(title, list(chosen), height=height, columns=columns, horizontal_spacing=0.02, vertical_spacing=0.08)
    ghosts = moving.data[: -len(moving.frames[0].data)]
    shapes = moving.data[-len(moving.frames[0].data) :]
    for place in range(len(chosen)):
        where = {"row": place // columns + 1, "col": place % columns + 1}
        for trace in ghosts:
            drawn.add_trace(trace, **where)
        for trace, swung in zip(shapes, frames[f"{place}.0"].data, strict=True):
            still = go.Scatter(trace).update(x=swung.x, y=swung.y, showlegend=place == 0)
            drawn.add_trace(still, **where)
        axis = drawn.get_subplot(**where).xaxis.plotly_name.replace("axis", "")
        drawn.update_yaxes(scaleanchor=axis, constrain="domain", **where)
    quiet = {"showgrid": False, "showticklabels": False, "ticks": "", "showline": False}
    drawn.update_xaxes(range=list(moving.layout.xaxis.range), constrain="domain", **quiet)
    drawn.update_yaxes(range=list(moving.layout.yaxis.range), **quiet)
    return drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.02, "yanchor": "top"})
