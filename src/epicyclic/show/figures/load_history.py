"""Load-sharing ratio of each branch over time."""

from __future__ import annotations

import plotly.graph_objects as go
import xarray as xr

from .over_time import over_time
from .style import INK

__all__ = ["load_history"]


def load_history(sharing: xr.Dataset) -> go.Figure:
    """Simultaneous load-sharing ratio of each branch [1] over time, a panel a pair of gears.

    Parameters
    ----------
    sharing : Dataset of `sharing`: load_sharing_history (mesh, time) [1].
    """
    drawn = over_time(sharing, "load_sharing_history", "Load sharing over time", "ratio [-]", 1.0)
    for row in range(1, len(drawn.layout.annotations) + 1):
        drawn.add_hline(y=1, line={"color": INK, "width": 1.2}, row=row, col=1)
    return drawn
