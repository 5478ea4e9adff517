"""Teeth in contact: load over the flank with contact lines; transmission error, Harris map and stiffness."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, engineering, texts
from .style import DASHES, INK, PALETTE, panels, tint

__all__ = ["contact_curves", "contact_map"]

# Lowest load pale, highest dark, even in lightness, for the colour-blind too.
_SCALE = [[0.0, "#F4F8FB"], [0.25, "#B9D7EA"], [0.5, "#56A3D0"], [0.75, "#1F6FA8"], [1.0, "#0B2E4F"]]


def contact_map(result: xr.Dataset) -> go.Figure:
    """Load per length [N/mm] over the flank of one tooth, a panel a helix, with the contact lines of one instant.

    Parameters
    ----------
    result : Dataset of `contact`.
    """
    sides = texts(result, "side")
    load = result["flank_load_per_length"].transpose("side", "width", "path_place").values / 1e3
    names = [f"{side}: largest {engineering(float(np.nanmax(load[i])))} N/mm" for i, side in enumerate(sides)]
    force = engineering(float(result.attrs["force"]) / 1e3)
    title = f"Load over the flank, {result.attrs['mesh']}, {force} kN a helix; orange: contact lines at one instant"
    drawn = panels(title, names, height=460, columns=len(sides), shared_yaxes=True, horizontal_spacing=0.05)
    top = float(np.nanmax(load))
    for i in range(len(sides)):
        face = result["width"].values * float(result["shared_face"].values[i]) * 1e3
        drawn.add_trace(
            go.Heatmap(
                x=compact(face),
                y=compact(result["path_place"].values),
                z=[compact(row, digits=4) for row in load[i].T],
                zmin=0.0,
                zmax=top,
                colorscale=_SCALE,
                showscale=i == len(sides) - 1,
                colorbar={"title": {"text": "N/mm"}, "thickness": 14},
                hovertemplate="%{x:.4g} mm from the left end<br>path %{y:.3f}<br>%{z:.4g} N/mm<extra></extra>",
            ),
            row=1,
            col=i + 1,
        )
        for line in result["line_place"].values[i]:
            look = {"color": "#D55E00", "width": 1.6}
            drawn.add_trace(
                go.Scatter(
                    x=compact(face), y=compact(line), mode="lines", line=look, showlegend=False, hoverinfo="skip"
                ),
                row=1,
                col=i + 1,
            )
        drawn.update_xaxes(title_text="along the face from the left end [mm]", row=1, col=i + 1)
    first, second = str(result.attrs["gear_a"]), str(result.attrs["gear_b"])
    drawn.update_yaxes(
        title_text=f"path of contact [base pitches]: tip of {second} below, of {first} above", row=1, col=1
    )
    return drawn


def contact_curves(result: xr.Dataset) -> go.Figure:
    """Loaded transmission error over the mesh cycle, its peak to peak over the load (Harris map), and stiffness.

    Parameters
    ----------
    result : Dataset of `contact`.
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
    force = float(result.attrs["force"])
    levels = result["mesh_load"].values
    phase = np.append(result["mesh_phase"].values, 1.0)
    for i, load in enumerate(levels):
        error = result["loaded_transmission_error"].values[i] * 1e6
        error = np.append(error, error[0]) - error.mean()
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
