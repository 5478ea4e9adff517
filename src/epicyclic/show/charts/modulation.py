"""What a sensor beside the ring sees: signal over a turn of the carrier, lines by family, and those of the mesh."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from numpy.typing import NDArray

from ...results.ties import ranked
from ..series import Array, compact, engineering, texts, thinned
from .style import INK, PALE, PALETTE, branch_colour, note, panels

Index = NDArray[np.int64]
_FAULT_FREE = {
    "mesh": "#1F2933",
    "planets passing": "#7A7A7A",
    "uneven planets": "#56B4E9",
    "mean load passing": "#C5CCD3",
}
_OTHERS = tuple(colour for colour in PALETTE if colour not in _FAULT_FREE.values())
# Lines this far below the largest are not drawn: they would hide the others.
_DECIBELS = 80.0
_NAMED = 6


def modulation(result: xr.Dataset) -> go.Figure:
    """Vibration beside the ring: signal over a turn of the carrier, and its lines [dB re largest] over their order.

    The third panel shows the lines round the mesh frequency.  Lines are coloured by family, rings are the lines of the
    train without deviations.

    Parameters
    ----------
    result : Dataset of `modulation`: signal (sample_time), signal_amplitude, fault_free_amplitude, line_frequency [Hz],
        carrier_order, family, causes (line), passage (planet) [s]; attributes carrier_frequency, stage_mesh_frequency
        [Hz].
    """
    unit = str(result["signal"].attrs["units"]).replace("s2", "s²")
    names = [
        "signal over one turn of the carrier: dotted, a planet under the sensor" if _turning(result) else "signal",
        "lines: what is there without any fault in black, greys and pale blue; ○ the line without deviations",
        "round the mesh frequency",
    ]
    drawn = panels("Vibration at a fixed place beside the ring", names, height=980, vertical_spacing=0.09)
    _signal(drawn, result, unit)
    colours = _colours(result)
    level = _level(result, "signal_amplitude")
    shown = np.flatnonzero(level > -_DECIBELS)
    x, title = _abscissa(result)
    for row in (2, 3):
        for family, colour in colours.items():
            mine = np.array([i for i in shown if str(result["family"].values[i]) == family], dtype=int)
            _stems(drawn, result, mine, x, level, colour=colour, family=family, row=row)
        _without(drawn, result, shown, x, row)
        drawn.update_xaxes(title_text=title, row=row, col=1)
        drawn.update_yaxes(title_text="level re largest [dB]", range=[-_DECIBELS, 8], row=row, col=1)
    _zoom(drawn, result, shown, x, level)
    return drawn


def _turning(result: xr.Dataset) -> bool:
    return float(result.attrs["carrier_frequency"]) > 0


def _colours(result: xr.Dataset) -> dict[str, str]:
    """A colour for each family, the loudest first."""
    family = texts(result, "family", "line")
    rank = ranked(np.abs(result["signal_amplitude"].values))
    names = list(dict.fromkeys(family[i] for i in rank))
    others = [name for name in names if name not in _FAULT_FREE]
    return {name: _FAULT_FREE.get(name) or _OTHERS[others.index(name) % len(_OTHERS)] for name in names}


def _level(result: xr.Dataset, name: str) -> Array:
    """Decibels of the largest line of the signal; what is not there far below."""
    size = np.abs(result[name].values)
    largest = float(np.abs(result["signal_amplitude"].values).max(initial=0.0)) or 1.0
    level: Array = 20 * np.log10(np.maximum(size / largest, 1e-12))
    return level


def _abscissa(result: xr.Dataset) -> tuple[Array, str]:
    if _turning(result):
        return np.asarray(result["carrier_order"].values, float), "frequency per speed of the carrier [1]"
    return np.asarray(result["line_frequency"].values, float), "frequency [Hz]"


def _signal(drawn: go.Figure, result: xr.Dataset, unit: str) -> None:
    carrier = float(result.attrs["carrier_frequency"])
    time = np.asarray(result["sample_time"].values, float)
    values = np.asarray(result["signal"].values, float)
    if carrier:
        time = time * carrier
        values, time = values[time <= 1.0], time[time <= 1.0]
    x, y = thinned(time, values, most=2000)
    line = {"color": INK, "width": 1.1}
    drawn.add_trace(
        go.Scatter(x=compact(x, digits=6), y=compact(y), mode="lines", line=line, name="signal", showlegend=False),
        row=1,
        col=1,
    )
    drawn.update_xaxes(title_text="turns of the carrier [1]" if carrier else "time [s]", row=1, col=1)
    drawn.update_yaxes(title_text=f"signal [{unit}]", row=1, col=1)
    for planet, passage in zip(result["planet"].values, result["passage"].values, strict=True):
        if np.isfinite(passage):
            at = float(passage) * carrier % 1.0
            drawn.add_vline(x=at, line={"color": branch_colour(int(planet)), "width": 1.6, "dash": "dot"}, row=1, col=1)
            note(
                drawn, f"planet {planet}", x=at, xref="x", y=1, yref="y domain", xanchor="left", yanchor="top", xshift=3
            )


def _stems(
    drawn: go.Figure,
    result: xr.Dataset,
    lines: Index,
    x: Array,
    level: Array,
    *,
    colour: str,
    family: str,
    row: int,
) -> None:
    """Lines of one family at x (lines,), from the bottom up to their level (lines,) [dB]."""
    if not len(lines):
        return
    floor = -_DECIBELS
    stems = [value for i in lines for value in (float(x[i]), float(x[i]), None)]
    tops = [value for i in lines for value in (floor, round(float(level[i]), 2), None)]
    label, cause = texts(result, "line"), texts(result, "causes")
    hertz = result["line_frequency"].values
    look = {"color": colour, "width": 1.8}
    drawn.add_trace(
        go.Scatter(x=stems, y=tops, mode="lines", line=look, legendgroup=family, showlegend=False, hoverinfo="skip"),
        row=row,
        col=1,
    )
    drawn.add_trace(
        go.Scatter(
            x=[round(float(x[i]), 6) for i in lines],
            y=[round(float(level[i]), 2) for i in lines],
            mode="markers",
            marker={"color": colour, "size": 5},
            name=family,
            legendgroup=family,
            showlegend=row == 2,
            text=[f"{label[i]}, {engineering(float(hertz[i]))} Hz<br>{cause[i].replace('; ', '<br>')}" for i in lines],
            hovertemplate="%{text}<br>%{y:.1f} dB<extra></extra>",
        ),
        row=row,
        col=1,
    )


def _without(drawn: go.Figure, result: xr.Dataset, shown: Index, x: Array, row: int) -> None:
    """Rings at x (lines,) and the level [dB] that each line has in the train as drawn."""
    level = _level(result, "fault_free_amplitude")
    there = [i for i in shown if level[i] > -_DECIBELS]
    drawn.add_trace(
        go.Scatter(
            x=[round(float(x[i]), 6) for i in there],
            y=[round(float(level[i]), 2) for i in there],
            mode="markers",
            marker={"color": PALE, "size": 9, "symbol": "circle-open"},
            name="without deviations",
            legendgroup="without",
            showlegend=row == 2,
            hoverinfo="skip",
        ),
        row=row,
        col=1,
    )


def _zoom(drawn: go.Figure, result: xr.Dataset, shown: Index, x: Array, level: Array) -> None:
    """The third panel: lines x (lines,) round the mesh frequency, the highest of `level` (lines,) [dB] named."""
    mesh = float(result.attrs["stage_mesh_frequency"])
    carrier = float(result.attrs["carrier_frequency"])
    centre = mesh / carrier if carrier else mesh
    reach = 3.5 * result.sizes["planet"] if carrier else 0.5 * mesh
    reach = min(reach, centre)
    drawn.update_xaxes(range=[centre - reach, centre + reach], row=3, col=1)
    inside = [i for i in shown if abs(x[i] - centre) < reach]
    label = texts(result, "line")
    drawn.add_vline(x=centre, line={"color": PALE, "width": 1, "dash": "dot"}, layer="below", row=3, col=1)
    note(
        drawn, f"mesh {engineering(centre)}", x=centre, xref="x3", y=1, yref="y3 domain", xanchor="left", yanchor="top"
    )
    named: list[float] = []
    for i in sorted(inside, key=lambda i: -level[i])[: 2 * _NAMED]:
        if len(named) == _NAMED or any(abs(x[i] - other) < 0.11 * reach for other in named):
            continue
        text = label[i].removeprefix("1 x mesh ").replace(" x ", "×").replace("- ", "\u2212").replace("+ ", "+")
        note(drawn, text, x=float(x[i]), y=float(level[i]), xref="x3", yref="y3", yanchor="bottom", yshift=4)
        named.append(float(x[i]))
