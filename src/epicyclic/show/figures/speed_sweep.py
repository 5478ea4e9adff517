"""Speed sweep: RMS and peak of the mesh forces over mesh frequency, natural frequencies and operating point marked."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, Series, compact, merged, spans, stage_count, texts
from .speeds import abscissa, mark_failed, mark_modes, mark_operating
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
    names = texts(sweep, "mesh")
    kinds = list(dict.fromkeys(name.split("/")[1] for name in names if "/" in name))
    several = stage_count(names) > 1
    rows = [sweep[name].transpose("mesh", "speed").values[:, rank] for name, _ in shown]
    scales = [float(np.nanmax(np.abs(values), initial=0.0)) or 1.0 for values in rows]
    # curves are equal where they are so in every panel
    groups = merged(
        names, np.hstack([values / scale for values, scale in zip(rows, scales, strict=True)]), branches=True
    )
    for row, ((name, _), scale) in enumerate(zip(shown, scales, strict=True), start=1):
        ratio = name == "dynamic_factor"
        for one in groups:
            own = scale * one.values[(row - 1) * len(x) : row * len(x)] / (1.0 if ratio else 1e3)
            look = _look(one, kinds, several)
            drawn.add_trace(_curve(own, x[rank], look, row == 1, "" if ratio else " kN"), row=row, col=1)
        drawn.update_yaxes(
            title_text="K_v [-]" if ratio else "force [kN]", rangemode="normal" if ratio else "tozero", row=row, col=1
        )
    drawn.update_xaxes(title_text=unit, row=len(shown), col=1)
    if len(x):
        drawn.update_xaxes(range=[float(x.min()), float(x.max())])
    mark_failed(drawn, sweep, x)
    mark_modes(drawn, modes, sweep, x)
    mark_operating(drawn, sweep, x)
    return drawn


_PANELS = (
    ("mesh_force_rms", "RMS of the dynamic mesh force"),
    ("mesh_force_peak", "largest mesh force"),
    ("dynamic_factor", "dynamic factor, largest per mean mesh force"),
)


def _look(one: Series, kinds: list[str], several: bool) -> tuple[str, dict[str, object]]:
    """Name and line of the curves of a mesh, or of equal meshes; several : the train has stages to name."""
    side = one.note.strip() or one.side[:1].upper()
    branches = spans(one.equal) if one.branch else ""
    equal = "alike" if len(one.equal) > 1 else ""
    name = " ".join(word for word in (one.stage if several else "", one.pair, branches, side, equal) if word)
    dash = DASHES[kinds.index(one.pair) % len(DASHES)] if one.pair in kinds else "solid"
    return name, {"color": branch_colour(one.branch), "dash": dash, "width": 1.7}


def _curve(values: Array, x: Array, look: tuple[str, dict[str, object]], legend: bool, unit: str) -> go.Scatter:
    """One curve (P,) over mesh frequency x (P,) [Hz]."""
    name, line = look
    return go.Scatter(
        x=compact(x),
        y=compact(values, digits=7),  # a K_v of 1.01 varies in its fourth place
        mode="lines",
        name=name,
        legendgroup=name,
        showlegend=legend,
        line=line,
        hovertemplate=f"{name}: %{{y:.4g}}{unit} at %{{x:.4g}} Hz<extra></extra>",
    )
