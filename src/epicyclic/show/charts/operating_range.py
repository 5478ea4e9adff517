"""Where in the range of speeds the resonances lie: the largest dynamic factor, the band about operation, what meets."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ...results.ties import EQUAL, ranked
from ..series import Array, compact, engineering, numbers, stage_count, texts
from .style import INK, PALE, PALETTE, WARNING, figure, note, translucent

# Names of resonances stand upright above the curve: so many at most, the strongest, this far apart [% of the width].
_NAMED, _APART = 16, 2.4
# Heights of the curve, of a letter of an upright name, and of what is around the plot [px].
_CURVE, _LETTER, _AROUND = 190, 6.1, 150
# As of the analysis, which marks resonances this close to operation where no band is given.
_BAND = 0.2
_PARTS = 2.0  # K_v of a vibration about the mean that takes the force to zero
_X = f"speed (shaded: operation ± {100 * _BAND:.0f} %) [% of the operating speed]"
Pair = tuple["xr.Dataset | None", "xr.Dataset | None"]


def operating_range(results: Mapping[str, Pair]) -> go.Figure | None:
    """Largest K_v [1] of all meshes over speed [% of operation], resonances on it; None where nothing is known.

    Parameters
    ----------
    results : name of a train -> Datasets of `modes` (resonance_speed, resonance_near, resonance_order,
        resonance_stage, resonance_mode, resonance_own_force (resonance)) and of `sweep` (dynamic_factor (mesh, speed)),
        either may be None.
    """
    known = {name: (m, s) for name, (m, s) in results.items() if _curve(s) is not None or _speeds(m).size}
    if not known:
        return None
    curves = {name: _curve(sweep) for name, (_, sweep) in known.items()}
    rated = any(curve is not None for curve in curves.values())
    drawn = figure("Where in the range of speeds the resonances lie", x=_X, y="largest K_v [-]" * rated)
    band = {"x0": 100 * (1 - _BAND), "x1": 100 * (1 + _BAND), "line_width": 0, "layer": "below"}
    drawn.add_vrect(**band, fillcolor=translucent(PALETTE[0], 0.08))
    single, most = len(known) == 1, 1.0
    longest = max((len(words) for modes, _ in known.values() for words in _words(modes)), default=0)
    strip = 40 * len(known) + _LETTER * longest if single else 40.0 * len(known)
    low = _CURVE / (_CURVE + strip)
    for place, (name, (modes, _)) in enumerate(known.items()):
        colour, curve = PALETTE[place % len(PALETTE)], curves[name]
        if curve is not None:
            most = max(most, float(curve[1].max()))
            drawn.add_trace(_line(curve, "largest K_v of all meshes" if single else name, colour))
        if _speeds(modes).size:
            words = "a mesh order meets a mode" if single else f"{name}: a mesh order meets a mode"
            drawn.add_trace(
                _marks(
                    modes,
                    (0.5 + place) / len(known) if not single else 20 / strip,
                    WARNING if single else colour,
                    words,
                )
            )
            if single:
                _names(drawn, modes, 32 / strip)
    if most >= _PARTS:
        drawn.add_shape(
            **{"type": "line", "x0": 0, "x1": 1, "xref": "paper", "y0": _PARTS, "y1": _PARTS},
            line={"color": WARNING, "width": 1.2, "dash": "dash"},
        )
        where = {"x": 0.005, "xref": "paper", "xanchor": "left", "y": _PARTS, "yanchor": "bottom"}
        note(drawn, f"K_v {_PARTS:g}", **where, font={"size": 12, "color": WARNING})
    drawn.add_vline(x=100, line={"color": INK, "width": 1.5})
    drawn.update_layout(
        height=_CURVE + strip + _AROUND,
        yaxis={"range": [1.0, max(1.02, 1 + 1.08 * (most - 1))], "domain": [0, low], "showticklabels": rated},
        yaxis2={"range": [0, 1], "domain": [low, 1], "visible": False, "fixedrange": True},
        xaxis={"range": _extent(known, curves)},
        legend={"orientation": "h", "x": 0, "xanchor": "left", "y": -60 / (_CURVE + strip), "yanchor": "top"},
    )
    return drawn.update_layout(showlegend=True, margin={"t": 76})


def _line(curve: tuple[Array, Array], words: str, colour: str) -> go.Scatter:
    return go.Scatter(
        **{"x": compact(curve[0]), "y": compact(curve[1], digits=6), "mode": "lines", "name": words},
        line={"color": colour, "width": 2},
        hovertemplate="K_v %{y:.4g} at %{x:.4g} %<extra></extra>",
    )


def _curve(sweep: xr.Dataset | None) -> tuple[Array, Array] | None:
    """Speed [%] and the largest K_v of all meshes there; None without either."""
    if sweep is None or "dynamic_factor" not in sweep.variables or "speed" not in sweep.coords:
        return None
    speed, factor = 100 * numbers(sweep, "speed"), sweep["dynamic_factor"].transpose("mesh", "speed").values
    known = np.isfinite(factor).any(axis=0) & np.isfinite(speed)
    if known.sum() < 2:
        return None
    rank = np.argsort(speed[known])
    return speed[known][rank], np.nanmax(factor[:, known], axis=0)[rank]


def _speeds(modes: xr.Dataset | None) -> Array:
    """Speeds of the resonances [%]."""
    known = modes is not None and "resonance_speed" in modes.variables
    return 100 * numbers(modes, "resonance_speed") if known and modes is not None else np.zeros(0)


def _marks(modes: xr.Dataset | None, height: float, colour: str, words: str) -> go.Scatter:
    """Resonances as strokes in the strip above the curve."""
    assert modes is not None
    speed = _speeds(modes)
    each = [
        f"{one} at {engineering(at)} % of the operating speed" for one, at in zip(_words(modes), speed, strict=True)
    ]
    return go.Scatter(
        x=compact(speed),
        y=[height] * len(speed),
        yaxis="y2",
        mode="markers",
        marker={"symbol": "line-ns-open", "size": 11, "color": colour, "line": {"width": 1.5}},
        name=words,
        text=each,
        hoverinfo="text",
    )


def _words(modes: xr.Dataset | None) -> list[str]:
    """``2× low mesh, mode 5`` of every resonance; the stage where the train has several."""
    if modes is None or not _speeds(modes).size:
        return []
    stage = texts(modes, "resonance_stage")
    several = len(set(stage)) > 1 or stage_count(texts(modes, "connection")) > 1
    columns = (numbers(modes, "resonance_order"), stage, numbers(modes, "resonance_mode"))
    return [
        f"{order:.0f}× {f'{own} ' if several else ''}mesh, mode {mode:.0f}"
        for order, own, mode in zip(*columns, strict=True)
    ]


def _names(drawn: go.Figure, modes: xr.Dataset | None, height: float) -> None:
    """Names of the strongest resonances, upright above their strokes, as many as stand beside each other."""
    assert modes is not None
    speed, words = _speeds(modes), _words(modes)
    force = np.nan_to_num(numbers(modes, "resonance_own_force"), nan=-1.0)
    excited = texts(modes, "resonance_excited", "resonance")
    apart, kept = _APART / 100 * max(float(np.ptp(speed)), 20.0), list[float]()
    for i in ranked(force, equal=EQUAL):
        if excited[i] != "no" and len(kept) < _NAMED and all(abs(speed[i] - other) > apart for other in kept):
            kept.append(float(speed[i]))
            upright = {"textangle": -90, "yref": "y2", "yanchor": "bottom", "font": {"size": 11, "color": PALE}}
            note(drawn, words[i], x=float(speed[i]), y=height, **upright)


def _extent(known: Mapping[str, Pair], curves: Mapping[str, tuple[Array, Array] | None]) -> list[float]:
    ends = [value for curve in curves.values() if curve is not None for value in (curve[0][0], curve[0][-1])]
    ends = ends or [value for modes, _ in known.values() for value in _speeds(modes)]
    return [float(min(*ends, 95.0)), float(max(*ends, 105.0))]
