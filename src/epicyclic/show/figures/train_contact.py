"""Teeth of a whole train in contact: load along every face, and load factors over the torque."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, engineering, texts
from .style import DASHES, PALETTE, panels

__all__ = ["face_loads", "load_factors"]


def face_loads(result: xr.Dataset) -> go.Figure:
    """Load per face width [N/mm] along the faces at the operating torque, a panel a pair and side.

    Parameters
    ----------
    result : Dataset of `train_contact`.
    """
    now = _now(result)
    groups = _groups(texts(result, "mesh"))
    columns = 2 if any(side for _, side in groups) else 1
    factor = result["face_load_factor"].values[now]
    names = [
        f"{pair} {side}".strip() + f": K<sub>Hβ</sub> up to {engineering(float(factor[meshes].max()))}"
        for (pair, side), meshes in groups.items()
    ]
    rows = -(-len(groups) // columns)
    drawn = panels(
        "Load along the faces, mean over the record",
        names,
        height=120 + 300 * rows,
        columns=columns,
        shared_yaxes=True,
        vertical_spacing=0.28 / rows,
    )
    width, load = result["width"].values, result["face_load"].values[now] / 1e3
    for place, meshes in enumerate(groups.values()):
        row, column = place // columns + 1, place % columns + 1
        for i, mesh in enumerate(meshes):
            line = {"color": PALETTE[i % len(PALETTE)], "width": 1.8, "dash": DASHES[i % len(DASHES)]}
            name = f"branch {i + 1}" if len(meshes) > 1 else "mesh"
            drawn.add_trace(
                go.Scatter(
                    x=compact(width),
                    y=compact(load[mesh]),
                    mode="lines",
                    line=line,
                    name=name,
                    legendgroup=name,
                    showlegend=place == 0,
                ),
                row=row,
                col=column,
            )
        drawn.update_xaxes(title_text="place along the face, left to right [1]", range=[0, 1], row=row, col=column)
        drawn.update_yaxes(rangemode="tozero", row=row, col=column)
        if column == 1:
            drawn.update_yaxes(title_text="load per width [N/mm]", row=row, col=column)
    return drawn


def load_factors(result: xr.Dataset) -> go.Figure:
    """K_gamma of every pair and the largest K_Hbeta of every pair and side, over the torque.

    Parameters
    ----------
    result : Dataset of `train_contact`.
    """
    drawn = panels(
        "Load factors over the torque",
        ["between branches, K<sub>γ</sub>", "along the face, K<sub>Hβ</sub>, largest of the branches"],
        height=620,
        vertical_spacing=0.16,
    )
    torque = compact(result["torque_factor"].values)
    curves = [
        (1, str(pair).split(".")[-1], result["branch_load_factor"].values[:, i])
        for i, pair in enumerate(result["mesh_pair"].values)
    ]
    factor = result["face_load_factor"].values
    curves += [
        (2, f"{pair} {side}".strip(), factor[:, meshes].max(axis=1))
        for (pair, side), meshes in _groups(texts(result, "mesh")).items()
    ]
    for i, (row, name, values) in enumerate(curves):
        line = {"color": PALETTE[i % len(PALETTE)], "width": 1.8, "dash": DASHES[i % len(DASHES)]}
        drawn.add_trace(
            go.Scatter(x=torque, y=compact(values), mode="lines+markers", line=line, name=name), row=row, col=1
        )
    for row in (1, 2):
        drawn.update_xaxes(title_text="torque per operating torque [1]", rangemode="tozero", row=row, col=1)
        drawn.update_yaxes(title_text="factor [1]", row=row, col=1)
    return drawn


def _now(result: xr.Dataset) -> int:
    return int(np.argmin(np.abs(result["torque_factor"].values - 1.0)))


def _groups(names: list[str]) -> dict[tuple[str, str], list[int]]:
    """Meshes of each pair and side, by their names ``stage/pair/branch/side``."""
    found: dict[tuple[str, str], list[int]] = {}
    for i, name in enumerate(names):
        stage, pair, *rest = name.split("/")
        side = rest[-1] if rest and not rest[-1].isdigit() else ""
        found.setdefault((f"{stage}/{pair}", side), []).append(i)
    return found
