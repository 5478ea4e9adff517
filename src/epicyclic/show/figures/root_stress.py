"""Stress in the tooth roots along the path of contact, and over the face."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, engineering, texts
from .style import PALETTE, panels

__all__ = ["root_stress"]

# Compression blue, tension red, none white.
_SCALE = [[0.0, "#2166AC"], [0.5, "#FFFFFF"], [1.0, "#B2182B"]]


def root_stress(result: xr.Dataset) -> go.Figure:
    """Stress in the roots [MPa] over the place of a tooth on the path of contact, and a panel a gear and helix of it
    over the face.

    Upper panel: largest over the face, below the loaded flank (tension) and below the far flank (compression, dashed).

    Parameters
    ----------
    result : Dataset of `contact`: root_stress, far_root_stress (side, mesh_gear, width, tooth_place) [Pa], tooth_place
        [base pitches], shared_face (side) [m]; attributes mesh, gear_a, gear_b.
    """
    sides, gears = texts(result, "side"), [str(result.attrs[f"gear_{one}"]) for one in texts(result, "mesh_gear")]
    panel = [(i, j) for i in range(len(sides)) for j in range(len(gears))]
    over = ("side", "mesh_gear", "width", "tooth_place")
    tension = result["root_stress"].transpose(*over).values / 1e6
    compression = result["far_root_stress"].transpose(*over).values / 1e6
    # two lines: four panels stand side by side on a page of 900 px
    names = [f"{gears[j]}, {sides[i]}<br>up to {engineering(float(tension[i, j].max()))} MPa" for i, j in panel]
    drawn = panels(
        f"Stress in the tooth roots, {result.attrs['mesh']}",
        ["largest over the face; dashed: compression below the far flank", *names],
        height=760,
        specs=[[{"colspan": len(panel)}, *[None] * (len(panel) - 1)], [{} for _ in panel]],
        columns=len(panel),
        vertical_spacing=0.16,
        horizontal_spacing=0.05,
    )
    place, most = compact(result["tooth_place"].values), float(np.abs(tension).max())
    for number, (i, j) in enumerate(panel):
        look = {"color": PALETTE[number % len(PALETTE)], "width": 1.8}
        label = f"{gears[j]}, {sides[i]}"
        for values, dash in ((tension[i, j].max(axis=0), "solid"), (compression[i, j].min(axis=0), "dash")):
            line = {**look, "dash": dash}
            drawn.add_trace(
                go.Scatter(
                    **{"x": place, "y": compact(values), "mode": "lines", "line": line, "name": label},
                    **{"legendgroup": label, "showlegend": dash == "solid"},
                ),
                row=1,
                col=1,
            )
        drawn.add_trace(
            go.Heatmap(
                x=compact(result["width"].values * float(result["shared_face"].values[i]) * 1e3),
                y=place,
                z=[compact(row, digits=4) for row in tension[i, j].T],
                zmin=-most,
                zmax=most,
                colorscale=_SCALE,
                showscale=number == len(panel) - 1,
                colorbar={"title": {"text": "MPa"}, "thickness": 14, "len": 0.38, "y": 0.18},
                hovertemplate="%{x:.4g} mm from the left end<br>path %{y:.3f}<br>%{z:.4g} MPa<extra></extra>",
            ),
            row=2,
            col=number + 1,
        )
        drawn.update_xaxes(title_text="along the face [mm]", row=2, col=number + 1)
    drawn.update_xaxes(title_text="place of the tooth on the path of contact [base pitches]", row=1, col=1)
    drawn.update_yaxes(title_text="stress [MPa]", row=1, col=1)
    drawn.update_yaxes(title_text="place of the tooth [base pitches]", row=2, col=1)
    return drawn
