"""K_gamma over what is no tolerance: torque, float and number of planets."""

from __future__ import annotations

import plotly.graph_objects as go
import xarray as xr

from .k_gamma_curves import add_curves, drawn_at, finished, k_gamma_panels
from .series import numbers

__all__ = ["k_gamma_by_design"]

_PANELS = {
    "k_gamma_by_torque": ("torque_scale", "torque", "torque per operating torque [-]"),
    "k_gamma_by_support": ("support_scale", "support stiffness", "stiffness per that of the model [-]"),
    "k_gamma_by_planets": ("planets", "number of planets", "planets [-]"),
}
# ratio of the ends of an axis from which on it is logarithmic
_DECADES = 30


def k_gamma_by_design(result: xr.Dataset) -> go.Figure:
    """K_gamma [1] over torque, support stiffness (float) and number of planets, whichever the result has.

    Parameters
    ----------
    result : Dataset of `tolerance`: k_gamma_by_torque (torque_scale, probability), k_gamma_by_support (support_scale,
        probability), k_gamma_by_planets (planets, probability) [1].
    """
    shown = {name: words for name, words in _PANELS.items() if name in result}
    drawn = k_gamma_panels("Kγ over torque, float and planets", [title for _, title, _ in shown.values()])
    for panel, (name, (dim, _, words)) in enumerate(shown.items()):
        x = numbers(result, dim)
        add_curves(drawn, result, x, result[name].transpose(dim, "probability").values, panel)
        drawn.update_xaxes(title_text=words, row=1, col=panel + 1)
        if dim == "planets":
            drawn.update_xaxes(dtick=1, row=1, col=panel + 1)
            continue
        drawn_at(drawn, 1.0, panel)
        if len(x) > 1 and x.min() > 0 and x.max() / x.min() >= _DECADES:
            drawn.update_xaxes(type="log", dtick=1, exponentformat="power", row=1, col=panel + 1)
    return finished(drawn, len(shown))
