"""Loci of natural frequencies along a number of the model, crossings and veerings marked."""

from __future__ import annotations

import json

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, engineering, numbers, texts
from .style import INK, WARNING, figure, mode_colour

__all__ = ["loci"]

_MARKS = {"crossing": ("circle-open", INK, "crossing"), "veering": ("diamond", WARNING, "veering")}


def loci(data: xr.Dataset, *, most: int = 24) -> go.Figure:
    """Natural frequencies [Hz] over a number of the model file, a curve a mode in the colour of its kind.

    Parameters
    ----------
    data : Dataset of `track`: frequency (mode, parameter) [Hz], mode_kind, multiplicity (mode), event_kind,
        event_value, event_frequency, event_gap, veering_index, event_first, event_second (event).
    most : loci shown at most, the lowest.
    """
    options = json.loads(str(data.attrs["options"]))
    unit = f" [{options['unit']}]" if options["unit"] else ""
    x = numbers(data, "parameter")
    hertz = data["frequency"].transpose("mode", "parameter").values[:most]
    drawn = figure(
        f"Natural frequencies over {options['over']}", x=f"{options['over']}{unit}", y="frequency [Hz]", height=560
    )
    kinds = texts(data, "mode_kind")
    multiple = data["multiplicity"].values
    seen: set[str] = set()
    for place, row in enumerate(hertz):
        if row.max() <= 0:
            continue
        kind = kinds[place]
        drawn.add_trace(_locus(x, row, place + 1, kind, int(multiple[place]), kind not in seen))
        seen.add(kind)
    top = 1.04 * float(np.nanmax(hertz, initial=1.0))
    for kind in _MARKS:
        if trace := _marks(data, kind, top):
            drawn.add_trace(trace)
    wide = x.min() > 0 and x.max() / x.min() > 10
    if x.min() <= float(options["value"]) <= x.max():
        line = {"color": INK, "width": 1.2, "dash": "dot"}
        drawn.add_vline(x=float(options["value"]), line=line)
        drawn.add_trace(
            go.Scatter(x=[None], y=[None], mode="lines", line=line, name="value in the model", legendgroup="events")
        )
    drawn.update_xaxes(type="log" if wide else "linear", exponentformat="e")
    drawn.update_yaxes(range=[0, top])
    return drawn


def _locus(x: np.ndarray, row: np.ndarray, mode: int, kind: str, multiplicity: int, first: bool) -> go.Scatter:
    """Frequencies (P,) [Hz] of one mode along the parameter (P,)."""
    return go.Scatter(
        x=compact(x),
        y=compact(row),
        mode="lines",
        line={"color": mode_colour(kind), "width": 2.6 if multiplicity > 1 else 1.5},
        name=f"{kind} mode",
        legendgroup=kind,
        showlegend=first,
        hovertemplate=f"mode {mode}, {kind}: %{{y:.5g}} Hz<extra></extra>",
    )


def _marks(data: xr.Dataset, kind: str, top: float) -> go.Scatter | None:
    symbol, colour, words = _MARKS[kind]
    frequency, where = numbers(data, "event_frequency"), numbers(data, "event_value")
    chosen = [i for i, text in enumerate(texts(data, "event_kind")) if text == kind and frequency[i] <= top]
    if not chosen:
        return None
    gap, index = numbers(data, "event_gap"), numbers(data, "veering_index")
    first, second = texts(data, "event_first"), texts(data, "event_second")
    said = [
        f"modes {first[i]} and {second[i]}"
        + (f": gap {engineering(gap[i])} Hz, index {index[i]:.2f}" if kind == "veering" else "")
        for i in chosen
    ]
    return go.Scatter(
        x=[float(where[i]) for i in chosen],
        y=[float(frequency[i]) for i in chosen],
        mode="markers",
        marker={"symbol": symbol, "size": 11, "color": colour, "line": {"width": 2, "color": colour}},
        name=words,
        legendgroup="events",
        text=said,
        hovertemplate=f"{words} at %{{x:.5g}}, %{{y:.5g}} Hz<br>%{{text}}<extra></extra>",
    )
