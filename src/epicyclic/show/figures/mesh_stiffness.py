"""Mesh stiffness over one mesh cycle, one panel a pair of gears, one curve a branch."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, Series, compact, engineering, merged, numbers, pair_title, pairs, texts
from .style import DASHES, branch_colour, panels

__all__ = ["mesh_stiffness"]


def mesh_stiffness(stiffness: xr.Dataset) -> go.Figure:
    """Mesh stiffness along the tooth normal [N/um] over one mesh cycle, a panel a pair of gears, a curve a branch,
    equal branches one.

    Parameters
    ----------
    stiffness : Dataset of `stiffness`: mesh_stiffness (mesh, mesh_phase) [N/m].
    """
    values = stiffness["mesh_stiffness"].transpose("mesh", "mesh_phase").values
    phase = numbers(stiffness, "mesh_phase")
    series = merged(texts(stiffness, "mesh"), values, branches=True)
    groups = pairs(series)
    several = len({stage for stage, _ in groups}) > 1
    names = [f"{pair_title(pair, several)}, {_mean(series, pair)}" for pair in groups]
    drawn = panels(
        "Mesh stiffness over a mesh cycle",
        names,
        height=110 + 230 * len(groups),
        shared_xaxes=True,
        vertical_spacing=0.28 / max(2, len(groups)),
    )
    shown: set[str] = set()
    for row, pair in enumerate(groups, start=1):
        own = [one for one in series if (one.stage, one.pair) == pair]
        for one in own:
            drawn.add_trace(_curve(one, phase, one.label not in shown), row=row, col=1)
            shown.add(one.label)
        drawn.update_yaxes(title_text="stiffness [N/µm]", row=row, col=1)
    drawn.update_xaxes(range=[0, 1])
    drawn.update_xaxes(title_text="time [mesh cycles]", row=len(groups), col=1)
    drawn.update_layout(hovermode="x unified")
    return drawn


def _mean(series: list[Series], pair: tuple[str, str]) -> str:
    means = [float(np.mean(one.values)) / 1e6 for one in series if (one.stage, one.pair) == pair]
    return f"mean {engineering(float(np.mean(means)))} N/µm"


def _curve(one: Series, phase: Array, legend: bool) -> go.Scatter:
    """A curve over the phase (P,) [mesh cycles]."""
    closed = len(phase) > 1 and phase[-1] < 1 - 1e-9 and abs(phase[0]) < 1e-9
    x = np.append(phase, 1.0) if closed else phase
    y = np.append(one.values, one.values[0]) if closed else one.values
    dash = DASHES[one.side == "right"]
    return go.Scatter(
        x=compact(x),
        y=compact(y / 1e6),
        mode="lines",
        name=one.label,
        legendgroup=one.label,
        showlegend=legend,
        line={"color": branch_colour(one.branch), "dash": dash, "width": 2},
    )
