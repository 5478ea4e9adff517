"""The gearbox at its output: torque over angle, as a bench with the other shafts locked draws it."""

from __future__ import annotations

import json

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import ARCMIN, engineering
from .renderers import Curve, Mark, Panel, Stems, chart, points
from .style import INK, PALETTE

_SECANT = (0.5, 1.0)  # torques per rated torque


def torque_over_angle(result: xr.Dataset) -> go.Figure:
    """Loop of the torque [N m] over the angle [arcmin], mean over the places of the mesh cycle.

    Marked are the rated torque, the share at which lost motion is read, the lost motion and the secant.

    result : Dataset of `output`: angle_rising, angle_falling (mesh_phase, shaft_torque), lost_motion,
        shaft_secant_stiffness (over_phases), rated_torque; in its options the share.
    """
    torque, share = result["shaft_torque"].values, float(json.loads(result.attrs["options"])["share"])
    rated = float(result["rated_torque"])
    rising, falling = (ARCMIN * result[f"angle_{way}"].mean("mesh_phase").values for way in ("rising", "falling"))
    middle, one = (rising + falling) / 2, np.allclose(rising, falling, rtol=1e-9)
    ends = np.array([-share, share]) * rated
    lost = np.interp(ends, torque, middle)
    secant = np.array(_SECANT) * (-rated if result.attrs["rated_sense"] == "negative" else rated)
    size = ARCMIN * float(result["lost_motion"].sel(over_phases="mean"))
    known = [] if np.isnan(size) else [f"lost motion {engineering(size)} arcmin"]
    apart = [] if known else [np.searchsorted(torque, 0)]  # without backlash no play joins the two senses
    drawn, rise, fall = (np.insert(values, apart, np.nan) for values in (torque, rising, falling))
    layers = [
        *([] if one else [Curve(fall, drawn, name="falling", colour=PALETTE[1])]),
        Curve(rise, drawn, name="both branches" if one else "rising", colour=PALETTE[0]),
        Curve(np.interp(secant, torque, middle), secant, name="secant, 50 to 100 %", colour=INK, dash="dash"),
        *(points(lost, ends, 8, name=words, colour=PALETTE[3]) for words in known),
        *(Mark(y=end, dash="dot", name=f"{100 * share:.3g} % of the rated torque") for end in ends),
        *(Mark(y=sense * rated, width=0.8, name="rated torque") for sense in (-1, 1)),
    ]
    title = f"Torque over angle at {result.attrs['shaft']}, locked {result.attrs['locked_shafts']}"
    return chart(title, Panel(layers, x="angle [arcmin]", y="torque [N m]"), height=520)


def kinematic_error(result: xr.Dataset) -> go.Figure:
    """Kinematic error [arcmin] over the turns of the shaft, and its orders.

    result : Dataset of `output`: kinematic_error (shaft_turn), kinematic_error_order (shaft_order).
    """
    wave = Curve(result["shaft_turn"].values, ARCMIN * result["kinematic_error"].values, colour=PALETTE[0])
    order, size = result["shaft_order"].values, ARCMIN * result["kinematic_error_order"].values
    words = [f"order {engineering(one)}: {engineering(part)} arcmin" for one, part in zip(order, size, strict=True)]
    over = Panel([wave], x="turns of the shaft [1]", y="error [arcmin]")
    orders = Panel([Stems(order, size, text=words, points=6, colour=PALETTE[0])], x="order [1]", y="amplitude [arcmin]")
    return chart(f"Kinematic error of {result.attrs['shaft']}", over, orders, height=560, gap=0.2)
