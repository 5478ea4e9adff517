"""One quantity of every mesh over time: a panel a pair of gears, a curve a branch."""

from __future__ import annotations

import plotly.graph_objects as go
import xarray as xr

from .series import Array, Series, compact, merged, numbers, pair_title, pairs, texts, thinned
from .style import DASHES, branch_colour, panels

__all__ = ["over_time"]


def over_time(result: xr.Dataset, name: str, title: str, unit: str, scale: float) -> go.Figure:
    """One quantity of every mesh over time, a panel a pair of gears, a curve a branch.

    Parameters
    ----------
    result : Dataset with a variable `name` (mesh, time or mesh_phase).
    title : of the figure.  unit : title of the ordinate, with its unit.  scale : factor from SI to that unit.
    """
    along = next(str(dim) for dim in result[name].dims if dim != "mesh")
    values = scale * result[name].transpose("mesh", along).values
    time = numbers(result, along, along)
    series = merged(texts(result, "mesh"), values, branches=True)
    groups = pairs(series)
    several = len({stage for stage, _ in groups}) > 1
    drawn = panels(
        title,
        [pair_title(pair, several) for pair in groups],
        height=120 + 210 * len(groups),
        shared_xaxes=True,
        vertical_spacing=0.2 / max(2, len(groups)),
    )
    shown: set[str] = set()
    for row, pair in enumerate(groups, start=1):
        for one in (one for one in series if (one.stage, one.pair) == pair):
            drawn.add_trace(_curve(one, time, one.label not in shown), row=row, col=1)
            shown.add(one.label)
        drawn.update_yaxes(title_text=unit, row=row, col=1)
    drawn.update_xaxes(title_text=f"time [{_time_unit(result, along)}]", row=len(groups), col=1)
    if len(time) > 1:
        drawn.update_xaxes(range=[float(time[0]), float(time[-1])])
    return drawn


def _time_unit(result: xr.Dataset, along: str) -> str:
    if along != "time":
        return "mesh cycles"
    return str(result["time"].attrs.get("units", "s")) if "time" in result.variables else "samples"


def _curve(one: Series, time: Array, legend: bool) -> go.Scatter:
    """One curve over time (k,) [s or mesh cycles], thinned."""
    x, y = thinned(time, one.values)
    return go.Scatter(
        x=compact(x),
        y=compact(y),
        mode="lines",
        name=one.label,
        legendgroup=one.label,
        showlegend=legend,
        line={"color": branch_colour(one.branch), "width": 1.5, "dash": DASHES[one.side == "right"]},
        hovertemplate=f"{one.label}: %{{y:.4g}} at %{{x:.4g}}<extra></extra>",
    )
