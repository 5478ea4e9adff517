"""Load spectra: hours over torque and speed, and ranges of the torque over the cycles that have them."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import engineering
from .renderers import Curve, Heat, Panel, chart

_POINTS = 800  # of a curve


def hours_over_torque(result: xr.Dataset) -> go.Figure:
    """Hours in every bin of torque [kN m] and speed [rpm], on a logarithmic scale; a bin without time is empty.

    result : Dataset of `spectrum`: case_hours, case_damage, torque_bin, speed_bin (case), torque_edge [N m], speed_edge
        [rpm].
    """
    edges = {name: result[f"{name}_edge"].values for name in ("torque", "speed")}
    at = (result["torque_bin"].values, result["speed_bin"].values)
    rows = np.full((len(edges["torque"]) - 1, len(edges["speed"]) - 1), np.nan)
    words = np.full(rows.shape, "", dtype=object)
    hours, damage = result["case_hours"].values, result["case_damage"].values
    rows[at] = np.log10(hours)
    words[at] = [f"{engineering(one)} h, {part:.1%} of the damage" for one, part in zip(hours, damage, strict=True)]
    ticks = np.arange(np.floor(np.nanmin(rows)), np.ceil(np.nanmax(rows)) + 1)
    bar = {"title": {"text": "hours [h]"}, "tickvals": ticks.tolist(), "ticktext": [f"{10.0**one:g}" for one in ticks]}
    look = {"colorscale": "YlOrBr", "colorbar": bar, "customdata": words.tolist()}
    heat = Heat(edges["speed"], edges["torque"] / 1e3, rows, hover="%{customdata}", look=look)
    return chart("Hours over torque and speed", Panel([heat], x="speed [rpm]", y="torque [kN m]"), height=460)


def ranges_over_cycles(result: xr.Dataset) -> go.Figure:
    """Range of the torque [kN m] over the number of cycles that have it or a larger one.

    result : Dataset of `spectrum`: cycle_range, largest first, cycle_count (cycle).
    """
    count, size = np.cumsum(result["cycle_count"].values), result["cycle_range"].values / 1e3
    at = np.unique(np.geomspace(1, len(size), _POINTS).astype(np.int64)) - 1  # as the axis is, so that rare ones stay
    log = {"type": "log", "exponentformat": "power"}
    panel = Panel([Curve(count[at], size[at], shape="vh")], x="cycles [1]", y="range [kN m]", x_axis=log)
    return chart("Ranges of the torque by rainflow", panel)
