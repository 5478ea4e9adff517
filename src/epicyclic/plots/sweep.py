"""Speed sweep: RMS and peak of the mesh forces over mesh frequency, natural frequencies and operating point marked."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .frequencies import groups
from .series import Array, Series, compact, merged, numbers, texts
from .style import DASHES, INK, WARNING, branch_colour, mode_colour, panels, translucent

__all__ = ["speed_sweep"]


def speed_sweep(sweep: xr.Dataset, modes: xr.Dataset | None = None) -> go.Figure:
    """RMS of the dynamic mesh force and largest mesh force [kN] over mesh frequency [Hz].

    Parameters
    ----------
    sweep : Dataset of `sweep`.  modes : Dataset of `modes`, whose frequencies are drawn as lines.
    """
    x, unit = _abscissa(sweep)
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
        values = sweep[name].transpose("mesh", "speed").values[:, rank] / 1e3
        for one in merged(texts(sweep, "mesh"), values):
            drawn.add_trace(_curve(one, x[rank], kinds, row == 1), row=row, col=1)
        drawn.update_yaxes(title_text="force [kN]", rangemode="tozero", row=row, col=1)
    drawn.update_xaxes(title_text=unit, row=len(shown), col=1)
    if len(x):
        drawn.update_xaxes(range=[float(x.min()), float(x.max())])
    _failed(drawn, sweep, x)
    _natural(drawn, modes, x)
    _operating(drawn, sweep, x)
    return drawn


_PANELS = (("mesh_force_rms", "RMS of the dynamic mesh force"), ("mesh_force_peak", "largest mesh force"))


def _abscissa(sweep: xr.Dataset) -> tuple[Array, str]:
    if "mesh_frequency" in sweep.variables:
        tones = sweep["mesh_frequency"]
        first = tones.isel(stage=0) if "stage" in tones.dims else tones
        return np.asarray(first.values, dtype=np.float64), "mesh frequency [Hz]"
    return 100 * numbers(sweep, "speed"), "speed [% of the operating speed]"


def _curve(one: Series, x: Array, kinds: list[str], legend: bool) -> go.Scatter:
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
        hovertemplate=f"{name}: %{{y:.4g}} kN at %{{x:.4g}} Hz<extra></extra>",
    )


def _failed(drawn: go.Figure, sweep: xr.Dataset, x: Array) -> None:
    """Points that did not converge, as crosses on the axis."""
    bad = [place for place, status in enumerate(texts(sweep, "status", "speed")) if status not in ("ok", "")]
    if bad:
        look = {"symbol": "x", "size": 9, "color": WARNING}
        at = [float(x[place]) for place in bad]
        points = go.Scatter(
            x=at,
            y=[0.0] * len(at),
            mode="markers",
            marker=look,
            name="no convergence",
            cliponaxis=False,
            legendgroup="marks",
        )
        drawn.add_trace(points, row=1, col=1)


def _natural(drawn: go.Figure, modes: xr.Dataset | None, x: Array) -> None:
    """Natural frequencies in range, as lines behind the curves, in the colour of their kind."""
    if modes is None or not len(x):
        return
    seen: set[str] = set()
    for one in groups(modes):
        if not float(x.min()) <= one.frequency <= float(x.max()):
            continue
        colour = translucent(mode_colour(one.kind), 0.75)
        line = {"color": colour, "width": 1.1, "dash": "dot"}
        drawn.add_vline(x=one.frequency, line=line, layer="below", row="all", col="all")
        if one.kind not in seen:
            key = go.Scatter(x=[None], y=[None], mode="lines", line=line, name=f"{one.kind} mode", legendgroup="marks")
            drawn.add_trace(key, row=1, col=1)
            seen.add(one.kind)


def _operating(drawn: go.Figure, sweep: xr.Dataset, x: Array) -> None:
    speed = numbers(sweep, "speed", "speed")
    if not len(speed) or not speed.min() <= 1 <= speed.max():
        return
    rank = np.argsort(speed)
    at = float(np.interp(1.0, speed[rank], x[rank]))
    line = {"color": INK, "width": 1.5}
    drawn.add_vline(x=at, line=line, row="all", col="all")
    key = go.Scatter(x=[None], y=[None], mode="lines", line=line, name="operating point", legendgroup="marks")
    drawn.add_trace(key, row=1, col=1)
