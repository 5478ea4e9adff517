"""Which tolerance moves K_gamma: its quantiles over the spread of every drawing entry."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .k_gamma_curves import ACROSS, add_curves, drawn_at, finished, k_gamma_panels, probabilities
from .series import numbers, texts
from .tolerance_labels import short_entries

__all__ = ["k_gamma_by_tolerance"]

# most tolerances in panels: the others move less
_MOST = 9


def k_gamma_by_tolerance(result: xr.Dataset) -> go.Figure:
    """K_gamma [1] over the scale of every tolerance, the steepest first.

    Parameters
    ----------
    result : Dataset of `tolerance`: k_gamma_by_scale (tolerance, scale, probability) [1].
    """
    values = result["k_gamma_by_scale"].transpose("tolerance", "scale", "probability").values
    entries, scale = short_entries(texts(result, "tolerance")), numbers(result, "scale")
    last = probabilities(result)[-1][0]
    rise = np.nan_to_num(values[:, -1, last] - values[:, 0, last])
    order = np.argsort(-rise, kind="stable")[:_MOST].tolist()
    drawn = k_gamma_panels(f"Which tolerance moves Kγ: {entries[order[0]]} most", [entries[i] for i in order])
    for panel, entry in enumerate(order):
        add_curves(drawn, result, scale, values[entry], panel)
        drawn_at(drawn, 1.0, panel)
        if panel + ACROSS >= len(order):
            row, column = divmod(panel, ACROSS)
            drawn.update_xaxes(title_text="spread per that drawn [-]", row=row + 1, col=column + 1)
    return finished(drawn, len(order))
