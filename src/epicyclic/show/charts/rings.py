"""Rings that bend: their radial deflection about the train."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..bent_rings import deflections
from ..series import ring_deflection, texts
from .renderers import Curve, Layer, Mark, Panel, Trace, chart
from .style import PALE, PALETTE, translucent

_PLACES = 241  # every 1.5 degrees
_INSTANTS = 4096  # of a record, whose range is drawn


def ring_deflections(result: xr.Dataset, check: xr.Dataset | None = None) -> go.Figure:
    """Radial deflection of every ring that bends [µm] over the polar angle [deg]: mean and range over the record.

    Parameters
    ----------
    result : Dataset of `static` or `steady`: displacement (dof, time or mesh_phase) [m].
    check : Dataset of `check`, whose meshes of a ring are marked: gear_b, mesh_direction (mesh) [rad].
    """
    angle = np.linspace(0.0, 2 * np.pi, _PLACES)
    panels = []
    for place, (ring, moved) in enumerate(deflections(result).items()):
        values, out = np.array([*moved.values()]), 1e6 * ring_deflection(list(moved), angle)[0]
        over_record = out @ values[:, :: -(-values.shape[1] // _INSTANTS)]
        colour, degrees = PALETTE[place % len(PALETTE)], np.degrees(angle)
        band: Trace = {"fill": "tonexty", "fillcolor": translucent(colour, 0.22)}
        layers: list[Layer] = [
            Mark(y=0, width=1),
            *(Mark(x=x, colour=PALE, dash="dot") for x in _meshes(check, ring)),
            Curve(degrees, over_record.min(axis=1), width=0, hover=None, colour=colour),
            Curve(degrees, over_record.max(axis=1), width=0, hover=None, colour=colour, look=band),
            Curve(degrees, out @ values.mean(axis=1), name=ring, colour=colour, width=2),
        ]
        panels.append(Panel(layers, y="outward [µm]"))
    look: Trace = {"height": 120 + 240 * len(panels), "gap": 0.2 / max(2, len(panels))}
    return chart("Bending of rings", *panels, x="polar angle from x of the stage [deg]", x_ends=(0.0, 360.0), **look)


def _meshes(check: xr.Dataset | None, ring: str) -> list[float]:
    """Polar angles of the meshes of a ring [deg]."""
    if check is None:
        return []
    own = zip(texts(check, "gear_b", "mesh"), check["mesh_direction"].values.tolist(), strict=True)
    return sorted({round(float(np.degrees(direction)) % 360, 6) for gear, direction in own if gear == ring})
