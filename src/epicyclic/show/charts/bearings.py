"""Rolling bearings: loads of their elements around the load zone."""

from __future__ import annotations

import plotly.graph_objects as go
import xarray as xr

from ..series import zones_of
from .renderers import Curve, Panel, chart
from .style import PALETTE


def load_zones(result: xr.Dataset) -> go.Figure:
    """Loads of the elements [kN] over their angle from the one that bears most, in the case that loads it most.

    Parameters
    ----------
    result : Dataset of `life`: element_load, element_angle (bearing, case, element).
    """
    curves = [
        Curve(angle, load, name=name, points=6, width=1.2, colour=PALETTE[place % len(PALETTE)])
        for place, (name, (angle, load)) in enumerate(zones_of(result).items())
    ]
    return chart("Load zones", Panel(curves, x="angle from the most loaded element [deg]", y="load of an element [kN]"))
