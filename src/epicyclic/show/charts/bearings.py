"""Rolling bearings: loads of their elements around the load zone."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ...results.dataset import first_largest, largest
from ..series import texts
from .renderers import Curve, Panel, chart
from .style import PALETTE


def load_zones(result: xr.Dataset) -> go.Figure:
    """Loads of the elements [kN] over their angle from the one that bears most, in the case that loads it most.

    Parameters
    ----------
    result : Dataset of `life`: element_load, element_angle (bearing, case, element); of `static` without cases.
    """
    result = result if "case" in result.dims else result[["element_load", "element_angle"]].expand_dims(case=[""])
    load = result["element_load"].transpose("bearing", "case", "element").values / 1e3
    angle = np.degrees(result["element_angle"].transpose("bearing", "case", "element").values)
    curves, cases = [], texts(result, "case")
    for place, name in enumerate(texts(result, "bearing")):
        case = first_largest(np.fmax.reduce(load[place], axis=1))[0]
        most = largest(load[place, case])
        turn = (angle[place, case] - angle[place, case, most] + 180) % 360 - 180
        order = np.argsort(turn, kind="stable")
        curves.append(
            Curve(
                turn[order],
                load[place, case][order],
                name=name + (f", {cases[case]}" if len(cases) > 1 else ""),
                points=6,
                width=1.2,
                colour=PALETTE[place % len(PALETTE)],
            )
        )
    return chart("Load zones", Panel(curves, x="angle from the most loaded element [deg]", y="load of an element [kN]"))
