"""Which tolerance moves K_gamma: its quantiles over the spread of every drawing entry."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .k_gamma_curves import ACROSS, add_curves, drawn_at, finished, k_gamma_panels, probabilities
from .series import numbers, texts
from .style import note
from .tolerance_labels import short_entries

__all__ = ["k_gamma_by_tolerance"]

# most tolerances in panels: the others move less
_MOST = 9
# share of the largest rise below which a tolerance has no panel
_FLAT = 0.02


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
    moving = [i for i in order if rise[i] > _FLAT * rise[order[0]]] or order[:1]
    drawn = k_gamma_panels(f"Which tolerance moves Kγ: {entries[order[0]]} most", [entries[i] for i in moving])
    for panel, entry in enumerate(moving):
        add_curves(drawn, result, scale, values[entry], panel)
        drawn_at(drawn, 1.0, panel)
        if panel + ACROSS >= len(moving):
            row, column = divmod(panel, ACROSS)
            drawn.update_xaxes(title_text="spread per that drawn [-]", row=row + 1, col=column + 1)
    flat = [entry for i, entry in enumerate(entries) if i not in moving]
    if flat:
        where = {"x": 0, "xref": "paper", "y": 0, "yref": "paper", "yanchor": "top", "yshift": -62}
        note(drawn, f"hardly any effect: {', '.join(flat)}", **where)
        drawn.update_layout(margin={"b": 96})
    return finished(drawn, len(moving))
