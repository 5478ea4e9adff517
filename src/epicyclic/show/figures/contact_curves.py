"""Loaded transmission error over mesh cycle and load (Harris map), and stiffness of the tooth contact."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, engineering, texts
from .style import DASHES, INK, PALETTE, panels, tint

__all__ = ["contact_curves"]


def contact_curves(result: xr.Dataset) -> go.Figure:
    """Loaded transmission error [um] over the mesh cycle, its peak to peak over load (Harris map), stiffness [N/um].

    Parameters
    ----------
    result : Dataset of `contact`: loaded_transmission_error (mesh_load, mesh_phase) [m],
        transmission_error_peak_to_peak (mesh_load) [m], transmission_error_harmonic (mesh_load, harmonic) [m],
        tangent_stiffness, secant_stiffness (side, mesh_load, mesh_phase) [N/m]; attribute force [N], the operating
        load.
    """
    names = [
        "loaded transmission error less its mean (Harris map): darker, more load",
        "peak to peak and mesh orders over the load",
        "stiffness of one helix over the mesh cycle at the operating load",
    ]
    drawn = panels(f"Teeth in contact, {result.attrs['mesh']}", names, height=1020, vertical_spacing=0.1)
    _errors(drawn, result)
    _over_load(drawn, result)
    _stiffness(drawn, result)
    return drawn


def _errors(drawn: go.Figure, result: xr.Dataset) -> None:
    from scipy.integrate import trapezoid

    force = float(result.attrs["force"])
    levels = result["mesh_load"].values
    phase = np.append(result["mesh_phase"].values, 1.0)
    for i, load in enumerate(levels):
        error = result["loaded_transmission_error"].values[i] * 1e6
        error = np.append(error, error[0])
        error = error - trapezoid(error, phase)
        now = bool(np.isclose(load, force))
        colour = PALETTE[1] if now else tint(INK, 0.85 * (1 - (i + 1) / len(levels)))
        name = f"{engineering(load / 1e3)} kN" + (", operation" if now else "")
        look = {"color": colour, "width": 2.6 if now else 1.3}
        drawn.add_trace(
            go.Scatter(x=compact(phase), y=compact(error), mode="lines", line=look, name=name), row=1, col=1
        )
    drawn.update_xaxes(title_text="time [mesh cycles]", range=[0, 1], row=1, col=1)
    drawn.update_yaxes(title_text="error [µm]", row=1, col=1)


def _over_load(drawn: go.Figure, result: xr.Dataset) -> None:
    load = compact(result["mesh_load"].values / 1e3)
    curves = {"peak to peak": result["transmission_error_peak_to_peak"].values}
    curves |= {f"order {k}": np.abs(result["transmission_error_harmonic"].values[:, k]) for k in (1, 2, 3)}
    for i, (name, values) in enumerate(curves.items()):
        look = {"color": INK if i == 0 else PALETTE[i - 1], "width": 2 if i == 0 else 1.5, "dash": DASHES[i]}
        drawn.add_trace(
            go.Scatter(x=load, y=compact(values * 1e6), mode="lines+markers", line=look, name=name), row=2, col=1
        )
    operating = float(result.attrs["force"]) / 1e3
    drawn.add_vline(x=operating, line={"color": PALETTE[1], "width": 1.2, "dash": "dot"}, row=2, col=1)
    drawn.update_xaxes(title_text="mesh force of one helix [kN]", row=2, col=1)
    drawn.update_yaxes(title_text="error [µm]", rangemode="tozero", row=2, col=1)


def _stiffness(drawn: go.Figure, result: xr.Dataset) -> None:
    now = int(np.argmin(np.abs(result["mesh_load"].values - float(result.attrs["force"]))))
    phase = compact(np.append(result["mesh_phase"].values, 1.0))
    values = result["tangent_stiffness"].values[:, now]
    alike = len(values) == 1 or bool(np.allclose(values[0], values[1], rtol=1e-4))
    sides = ["both helices" if len(values) > 1 else "helix"] if alike else texts(result, "side")
    for i, side in enumerate(sides):
        for kind, dash in (("tangent", "solid"), ("secant", "dash")):
            values = result[f"{kind}_stiffness"].values[i, now] / 1e6
            look = {"color": PALETTE[i], "width": 1.8, "dash": dash}
            closed = compact(np.append(values, values[0]))
            drawn.add_trace(
                go.Scatter(x=phase, y=closed, mode="lines", line=look, name=f"{kind}, {side}"), row=3, col=1
            )
    drawn.update_xaxes(title_text="time [mesh cycles]", range=[0, 1], row=3, col=1)
    drawn.update_yaxes(title_text="stiffness [N/µm]", row=3, col=1)
