"""Speed sweep: RMS and peak of the mesh forces over mesh frequency, natural frequencies and operating point marked."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, Series, compact, merged, texts
from .speeds import abscissa, mark_failed, mark_natural, mark_operating
from .style import DASHES, branch_colour, panels

__all__ = ["speed_sweep"]


def speed_sweep(sweep: xr.Dataset, modes: xr.Dataset | None = None) -> go.Figure:
    """RMS of the dynamic mesh force, largest mesh force [kN] and dynamic factor K_v [1] over mesh frequency [Hz].

    Natural frequencies and the operating point are lines; speeds without a solution are crosses.

    Parameters
    ----------
    sweep : Dataset of `sweep`: mesh_force_rms, mesh_force_peak [N], dynamic_factor (mesh, speed), mesh_frequency,
        status (speed).
    modes : Dataset of `modes`: frequency, mode_kind, multiplicity (mode).
    """
    x, unit = abscissa(sweep)
    rank = np.argsort(x)
    shown = [(name, title) for name, title in _PANELS if name in sweep.variables]
    drawn = panels(
        "Mesh forces over speed",
        [title for _, title in shown],
        height=140 + 250 * len(shown),
        shared_xaxes=True,
        vertical_spacing=0.12,
    )
    kinds = list(dict.fromkeys(str(name).split("/")[1] for name in sweep["mesh"].values if "/" in str(name)))
    for row, (name, _) in enumerate(shown, start=1):
        ratio = name == "dynamic_factor"
        values = sweep[name].transpose("mesh", "speed").values[:, rank] / (1.0 if ratio else 1e3)
        for one in merged(texts(sweep, "mesh"), values):
            drawn.add_trace(_curve(one, x[rank], kinds, row == 1, "" if ratio else " kN"), row=row, col=1)
        drawn.update_yaxes(
            title_text="K_v [-]" if ratio else "force [kN]", rangemode="normal" if ratio else "tozero", row=row, col=1
        )
    drawn.update_xaxes(title_text=unit, row=len(shown), col=1)
    if len(x):
        drawn.update_xaxes(range=[float(x.min()), float(x.max())])
    mark_failed(drawn, sweep, x)
    mark_natural(drawn, modes, x)
    mark_operating(drawn, sweep, x)
    return drawn


_PANELS = (
    ("mesh_force_rms", "RMS of the dynamic mesh force"),
    ("mesh_force_peak", "largest mesh force"),
    ("dynamic_factor", "dynamic factor, largest per mean mesh force"),
)


def _curve(one: Series, x: Array, kinds: list[str], legend: bool, unit: str) -> go.Scatter:
    """One curve over mesh frequency x (P,) [Hz]."""
    dash = DASHES[kinds.index(one.pair) % len(DASHES)] if one.pair in kinds else "solid"
    side = one.label.split(" ", 2)[-1] if one.label.startswith("branch") and one.label.count(" ") > 1 else ""
    name = " ".join(word for word in (one.pair, str(one.branch or ""), side) if word)
    return go.Scatter(
        x=compact(x),
        y=compact(one.values),
        mode="lines",
        name=name,
        legendgroup=name,
        showlegend=legend,
        line={"color": branch_colour(one.branch), "dash": dash, "width": 1.7},
        hovertemplate=f"{name}: %{{y:.4g}}{unit} at %{{x:.4g}} Hz<extra></extra>",
    )
