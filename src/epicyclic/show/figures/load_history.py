"""Load-sharing ratio of each branch over time."""

from __future__ import annotations

import plotly.graph_objects as go
import xarray as xr

from .over_time import over_time
from .style import INK, note

__all__ = ["load_history"]

# Ratios that differ from 1 by less are one line at 1, which says so: they would be drawn over a range of nothing.
_EVEN, _AROUND = 1e-5, 0.01


def load_history(sharing: xr.Dataset) -> go.Figure:
    """Simultaneous load-sharing ratio of each branch [1] over time, a panel a pair of gears.

    Parameters
    ----------
    sharing : Dataset of `sharing`: load_sharing_history (mesh, time) [1].
    """
    drawn = over_time(sharing, "load_sharing_history", "Load sharing over time", "ratio [-]", 1.0)
    for row in range(1, len(drawn.layout.annotations) + 1):
        drawn.add_hline(y=1, line={"color": INK, "width": 1.2}, layer="below", row=row, col=1)
        axis = "y" if row == 1 else f"y{row}"
        values = [value for trace in drawn.data if trace.yaxis == axis for value in trace.y if value is not None]
        if values and max(abs(value - 1) for value in values) < _EVEN:
            drawn.update_yaxes(range=[1 - _AROUND, 1 + _AROUND], row=row, col=1)
            where = {"xref": "x domain" if row == 1 else f"x{row} domain", "yref": f"{axis} domain"}
            note(drawn, "every branch carries its share", x=0.5, y=0.85, xanchor="center", **where)
    return drawn
