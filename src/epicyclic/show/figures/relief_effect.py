"""Transmission error, load and dynamic force before and after relief."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, short_names, texts
from .style import DASHES, INK, PALE, PALETTE, panels

__all__ = ["relief_effect"]

_BEFORE, _AFTER = PALE, PALETTE[1]


def relief_effect(result: xr.Dataset) -> go.Figure:
    """Transmission error [um], Harris map, load along the path [N/mm], dynamic force [N]: before and after relief.

    Parameters
    ----------
    result : Dataset of `relief`: relieved_error (state, relieved_mesh, load_factor, mesh_phase) [m],
        relieved_peak_to_peak (state, relieved_mesh, load_factor) [m], relieved_load (state, relieved_mesh, place)
        [N/m],
        relieved_place (relieved_mesh, place) [base pitches], relieved_force (relieved_mesh) [N];
        mesh_force_rms (state, speed) [N].
    """
    names = [
        "loaded transmission error less its mean, operating load",
        "its peak to peak over the load (Harris map)",
        "largest load per length along the path of contact, operating load",
    ]
    if "mesh_force_rms" in result:
        names.append("RMS of the dynamic mesh force, largest of the meshes looked at")
    drawn = panels("Before (grey) and after (orange) relief", names, height=330 * len(names), vertical_spacing=0.08)
    meshes = short_names(texts(result, "relieved_mesh"))
    factors = result["load_factor"].values
    now = int(np.argmin(np.abs(factors - 1.0)))
    error = result["relieved_error"].values[:, :, now] * 1e6
    phase = np.append(result["mesh_phase"].values, 1.0)
    for j, mesh in enumerate(meshes):
        shown = error[:, j] - error[:, j].mean(axis=1, keepdims=True)
        _pair(drawn, phase, np.append(shown, shown[:, :1], axis=1), mesh, j, row=1)
        load = factors * float(result["relieved_force"].values[j]) / 1e3
        _pair(drawn, load, result["relieved_peak_to_peak"].values[:, j] * 1e6, mesh, j, row=2)
        drawn.add_vline(x=load[now], line={"color": INK, "width": 1, "dash": "dot"}, row=2, col=1)
        _pair(drawn, result["relieved_place"].values[j], result["relieved_load"].values[:, j] / 1e3, mesh, j, row=3)
    titles = [
        ("time [mesh cycles]", "error [µm]"),
        ("mesh force of one helix [kN]", "error [µm]"),
        ("path of contact from the pitch point [base pitches]", "load per length [N/mm]"),
    ]
    if "mesh_force_rms" in result:
        _pair(drawn, result["speed"].values, result["mesh_force_rms"].values, "", 0, row=4)
        titles.append(("speed relative to the operating one [1]", "force [N]"))
    for row, (x, y) in enumerate(titles, start=1):
        drawn.update_xaxes(title_text=x, row=row, col=1)
        drawn.update_yaxes(title_text=y, row=row, col=1, rangemode="normal" if row == 1 else "tozero")
    return drawn


def _pair(drawn: go.Figure, x: Array, values: Array, mesh: str, number: int, *, row: int) -> None:
    """Both states (2, k) of one mesh over x (k,): a colour for the state, a dash for the mesh."""
    for i, (state, colour) in enumerate((("before", _BEFORE), ("after", _AFTER))):
        look = {"color": colour, "width": 1.6 + 0.8 * i, "dash": DASHES[number % len(DASHES)]}
        name = ", ".join(text for text in (mesh, state) if text)
        trace = {"x": compact(x), "y": compact(values[i]), "mode": "lines", "line": look, "name": name}
        drawn.add_trace(go.Scatter(**trace, legendgroup=name, showlegend=row == 1), row=row, col=1)
