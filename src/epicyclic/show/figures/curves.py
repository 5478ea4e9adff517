"""Plain curves: one quantity against one parameter, as studies give it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go
from numpy.typing import ArrayLike

from .series import compact
from .style import DASHES, INK, PALETTE, figure

__all__ = ["curves"]


def curves(
    x: ArrayLike,
    ys: Mapping[str, ArrayLike],
    *,
    title: str,
    x_title: str,
    y_title: str,
    log_x: bool = False,
    reference: float | None = None,
) -> go.Figure:
    """Curves over one parameter.

    Parameters
    ----------
    x : (k,).  ys : label -> (k,).  x_title, y_title : with units.  log_x : logarithmic axis.
    reference : a value of y that has a meaning (1 for equal load sharing), drawn as a line.
    """
    drawn = figure(title, x=x_title, y=y_title, height=400)
    at = compact(np.asarray(x, dtype=np.float64), digits=7)
    for place, (name, y) in enumerate(ys.items()):
        look = {"color": PALETTE[place % len(PALETTE)], "dash": DASHES[place // len(PALETTE) % 4], "width": 2}
        values = compact(np.asarray(y, dtype=np.float64), digits=6)
        mode = "lines+markers" if len(at) <= 60 else "lines"
        drawn.add_trace(go.Scatter(x=at, y=values, mode=mode, name=name, line=look, marker={"size": 6}))
    if reference is not None:
        drawn.add_hline(y=reference, line={"color": INK, "width": 1.2, "dash": "dash"})
    if log_x:
        drawn.update_xaxes(type="log", dtick=1, exponentformat="power", separatethousands=False)
    drawn.update_layout(showlegend=True)
    return drawn
