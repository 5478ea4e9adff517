"""Load over the flank of one tooth, with the contact lines of one instant."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, engineering, texts
from .style import panels

__all__ = ["contact_map"]

# Lowest load pale, highest dark, even in lightness, for the colour-blind too.
_SCALE = [[0.0, "#F4F8FB"], [0.25, "#B9D7EA"], [0.5, "#56A3D0"], [0.75, "#1F6FA8"], [1.0, "#0B2E4F"]]


def contact_map(result: xr.Dataset) -> go.Figure:
    """Load per length [N/mm] over the flank of one tooth, a panel a helix, with the contact lines of one instant.

    Abscissa: place along the face [mm]; ordinate: path of contact from the pitch point [base pitches].

    Parameters
    ----------
    result : Dataset of `contact`: flank_load_per_length (side, width, path_place) [N/m], width (width) [1],
        shared_face (side) [m], line_place (side, ..., width) [base pitches]; attributes force [N], mesh, gear_a,
        gear_b.
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
        title_text=f"path of contact [base pitches]<br>tip of {second} below, of {first} above", row=1, col=1
    )
    return drawn
