"""What figures over speed share: the abscissa, natural frequencies, the operating point, speeds without a solution."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ...results.ties import EQUAL, ranked
from .series import Array, numbers, texts
from .style import INK, WARNING, lines_across, mode_colour, note, translucent
from .summaries import mode_groups, of_first_stage

__all__ = ["abscissa", "mark_failed", "mark_modes", "mark_operating"]

# Resonances named in a figure: more names would lie on each other.
_RESONANCES = 8
# Mesh frequency per that at operation up to which a range is about operation.
_ABOUT = 2.0


def abscissa(sweep: xr.Dataset) -> tuple[Array, str]:
    """Mesh frequency of the first stage [Hz], or speed [%], and the title of the axis."""
    if "mesh_frequency" in sweep.variables:
        tones = sweep["mesh_frequency"]
        first = tones.isel(stage=0) if "stage" in tones.dims else tones
        return np.asarray(first.values, dtype=np.float64), f"mesh frequency{of_first_stage(sweep)} [Hz]"
    return 100 * numbers(sweep, "speed"), "speed [% of the operating speed]"


def mark_failed(drawn: go.Figure, sweep: xr.Dataset, x: Array) -> None:
    """Points that did not converge, as crosses on the axis x (speed,) [Hz]."""
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
        drawn.add_trace(points)


def mark_modes(drawn: go.Figure, modes: xr.Dataset | None, sweep: xr.Dataset, x: Array) -> None:
    """What of the modes lies within x (speed,) [Hz], as lines behind the curves.

    Over a range about operation the speeds at which mesh orders meet modes, where they are known, else natural
    frequencies.
    """
    if modes is None or not len(x):
        return
    if modes.sizes.get("resonance", 0) and x.max() <= _ABOUT * _operating_frequency(sweep, x):
        _mark_resonances(drawn, modes, sweep, x)
    else:
        _mark_natural(drawn, modes, x)


def _mark_natural(drawn: go.Figure, modes: xr.Dataset, x: Array) -> None:
    """Natural frequencies within x (speed,) [Hz], in the colour of their kind."""
    inside = [one for one in mode_groups(modes) if float(x.min()) <= one.frequency <= float(x.max())]
    _kind_lines(drawn, [(one.frequency, one.kind) for one in inside], "{} mode")


def _mark_resonances(drawn: go.Figure, modes: xr.Dataset, sweep: xr.Dataset, x: Array) -> None:
    """Strongest speeds within x (speed,) [Hz] at which a mesh order meets a mode, as lines named by order and mode."""
    tone = _operating_frequency(sweep, x)
    force = np.nan_to_num(numbers(modes, "resonance_own_force"), nan=0.0)
    at, kinds = tone * numbers(modes, "resonance_speed"), texts(modes, "resonance_kind")
    inside = (force > 0) & (at >= x.min()) & (at <= x.max())
    inside &= np.array([one != "no" for one in texts(modes, "resonance_excited", "resonance")], dtype=bool)
    shown = [int(place) for place in ranked(force, equal=EQUAL) if inside[place]][:_RESONANCES]
    _kind_lines(drawn, [(float(at[place]), kinds[place]) for place in shown], "resonance, {} mode")
    several, stages = len(set(texts(modes, "resonance_stage"))) > 1, texts(modes, "resonance_stage")
    taken: list[float] = []
    for place in shown:
        if any(abs(at[place] - other) < 0.05 * np.ptp(x) for other in taken):
            continue
        taken.append(float(at[place]))
        order = f"{int(modes['resonance_order'].values[place])}×{f' {stages[place]}' if several else ''}"
        words = f"{order}, mode {int(modes['resonance_mode'].values[place])}"
        # on the side that has room, over the curves on a ground of their own
        side = 8 if at[place] < x.min() + 0.02 * np.ptp(x) else -8
        note(
            drawn,
            words,
            x=float(at[place]),
            **{"yref": "y domain", "y": 0.02, "yanchor": "bottom", "textangle": -90, "xshift": side},
            **{"bgcolor": "rgba(255,255,255,0.8)", "borderpad": 0},
        )


def _operating_frequency(sweep: xr.Dataset, x: Array) -> float:
    """Abscissa of the operating speed, of x (speed,) [Hz] in proportion to the speed."""
    speed = numbers(sweep, "speed", "speed")
    known = np.isfinite(speed) & (speed > 0)
    return float(np.median(x[known] / speed[known])) if known.any() else np.nan


def _kind_lines(drawn: go.Figure, lines: list[tuple[float, str]], name: str) -> None:
    """Dotted lines at abscissas, in the colours of kinds of modes, each kind once in the legend."""
    looks = {
        kind: {"color": translucent(mode_colour(kind), 0.75), "width": 1.1, "dash": "dot"}
        for kind in dict.fromkeys(kind for _, kind in lines)
    }
    lines_across(drawn, [(at, {"line": looks[kind], "layer": "below"}) for at, kind in lines])
    for kind, line in looks.items():
        key = go.Scatter(x=[None], y=[None], mode="lines", line=line, name=name.format(kind), legendgroup="marks")
        drawn.add_trace(key)


def mark_operating(drawn: go.Figure, sweep: xr.Dataset, x: Array) -> None:
    """The operating speed, where it lies within x (speed,) [Hz], as a line."""
    speed = numbers(sweep, "speed", "speed")
    if not len(speed) or not speed.min() <= 1 <= speed.max():
        return
    rank = np.argsort(speed)
    at = float(np.interp(1.0, speed[rank], x[rank]))
    line = {"color": INK, "width": 1.5}
    lines_across(drawn, [(at, {"line": line})])
    key = go.Scatter(x=[None], y=[None], mode="lines", line=line, name="operating point", legendgroup="marks")
    drawn.add_trace(key)
