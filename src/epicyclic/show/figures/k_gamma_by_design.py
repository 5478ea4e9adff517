"""K_gamma over what is no tolerance: torque, float and number of planets."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .k_gamma_curves import ACROSS, add_curves, drawn_at, finished, k_gamma_panels
from .series import Array, numbers, texts
from .tolerance_labels import short_entries

__all__ = ["k_gamma_by_design"]

# ratio of the ends of an axis from which on it is logarithmic
_DECADES = 30


def k_gamma_by_design(result: xr.Dataset) -> go.Figure:
    """K_gamma [1] over torque, stiffness of each support (float) and number of planets, whichever the result has.

    Parameters
    ----------
    result : Dataset of `tolerance`: k_gamma_by_torque (torque_scale, probability), k_gamma_by_support (support,
        support_scale, probability), support_stiffness (support, support_scale) [N/m], k_gamma_by_planets (planets,
        probability) [1].
    """
    shown = list(_curves(result))
    drawn = k_gamma_panels("Kγ over torque, float and planets", [title for title, *_ in shown])
    for panel, (_, words, x, values, own) in enumerate(shown):
        row, column = divmod(panel, ACROSS)
        add_curves(drawn, result, x, values, panel)
        drawn.update_xaxes(title_text=words, row=row + 1, col=column + 1)
        if np.isfinite(own):
            drawn_at(drawn, own, panel)
        if len(x) > 1 and x.min() > 0 and x.max() / x.min() >= _DECADES:
            look = {"type": "log", "dtick": 1, "exponentformat": "power", "tickfont": {"size": 11}}
            drawn.update_xaxes(**look, row=row + 1, col=column + 1)
        elif words == "planets [-]":
            drawn.update_xaxes(dtick=1, row=row + 1, col=column + 1)
    return finished(drawn, len(shown))


def _curves(result: xr.Dataset) -> Iterator[tuple[str, str, Array, Array, float]]:
    """Title, title of the axis, x (k,), K_gamma (k, probability) and the model's own x, nan where not marked."""
    if "k_gamma_by_torque" in result:
        values = result["k_gamma_by_torque"].transpose("torque_scale", "probability").values
        yield "torque", "torque per operating torque [-]", numbers(result, "torque_scale"), values, 1.0
    if "k_gamma_by_support" in result:
        own = int(np.argmin(np.abs(np.log(numbers(result, "support_scale")))))
        values = result["k_gamma_by_support"].transpose("support", "support_scale", "probability").values
        stiffness = result["support_stiffness"].transpose("support", "support_scale").values
        for name, x, curve in zip(_supports(texts(result, "support")), stiffness, values, strict=True):
            yield f"support of {name}", "stiffness [N/m]", x, curve, float(x[own])
    if "k_gamma_by_planets" in result:
        values = result["k_gamma_by_planets"].transpose("planets", "probability").values
        known = np.isfinite(values).any(axis=1)
        yield "number of planets", "planets [-]", numbers(result, "planets")[known], values[known], np.nan


def _supports(paths: list[str]) -> list[str]:
    """``stages.main.sun.support.radial`` -> ``sun``."""
    return [name.removesuffix(" radial").removesuffix(" support") for name in short_entries(paths)]
