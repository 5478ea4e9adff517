"""Tornado: what a change of one percent of each number moves a frequency or a mesh force by, most at the top."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, engineering, numbers, texts
from .style import INK, figure, note

__all__ = ["tornado"]

_UP, _DOWN = "#D55E00", "#0072B2"


def tornado(data: xr.Dataset, *, most: int = 20) -> go.Figure:
    """Change of a frequency or force per 1 % more of each number [%], the strongest first, as bars about zero.

    A bar between two values is a repeated root that splits.

    Parameters
    ----------
    data : Dataset of `sensitivity`: sensitivity (path, mode or mesh) [1], ranked_by (mode or mesh), parameter_value,
        parameter_unit (path).
    most : bars at most; numbers below a thousandth of the strongest are left out.
    """
    low, high = _spans(data)
    size = np.maximum(np.abs(low), np.abs(high))
    strong: list[int] = np.flatnonzero(size > 1e-3 * float(np.nanmax(size, initial=0.0)))[:most].tolist()
    names = [_name(texts(data, "path")[i], data, i) for i in strong]
    drawn = figure(
        f"What moves {data.attrs.get('subject', 'it')}",
        x="change of it per 1 % more of the number [%]",
        height=150 + 26 * max(len(names), 1),
    )
    for colour, words, positive in ((_UP, "raises it", True), (_DOWN, "lowers it", False)):
        chosen = [(name, i) for name, i in zip(names, strong, strict=True) if (high[i] + low[i] >= 0) == positive]
        if chosen:
            drawn.add_trace(_bars(chosen, low, high, colour, words))
    if not names:
        note(drawn, "nothing moves it", x=0.5, xref="paper", y=0.5, yref="paper")
    drawn.add_vline(x=0, line={"color": INK, "width": 1.2})
    drawn.update_yaxes(categoryorder="array", categoryarray=names[::-1], showgrid=False)
    reach = 1.28 * float(np.nanmax(size, initial=0.0)) or 1.0
    drawn.update_xaxes(range=[-reach if np.nanmin(low, initial=0.0) < 0 else -0.05 * reach, reach])
    legend = {"orientation": "h", "x": 1, "xanchor": "right", "y": 1.0, "yanchor": "bottom"}
    return drawn.update_layout(barmode="overlay", bargap=0.3, legend=legend, margin={"t": 84})


def _spans(data: xr.Dataset) -> tuple[Array, Array]:
    """Least and most percent per percent of every path; from 0 where it is one value."""
    dim = "mode" if "mode" in data.sizes else "mesh"
    chosen = np.flatnonzero(data["ranked_by"].values.astype(bool))
    values = data["sensitivity"].transpose("path", dim).values[:, chosen]
    return np.asarray(values.min(axis=1)), np.asarray(values.max(axis=1))


def _bars(chosen: list[tuple[str, int]], low: Array, high: Array, colour: str, words: str) -> go.Bar:
    """Bars of one sign, from the least to the most (paths,) [% per %]."""
    ends = [(float(low[i]), float(high[i])) for _, i in chosen]
    one = [abs(b - a) <= 1e-6 * max(abs(a), abs(b)) for a, b in ends]
    base = [0.0 if same else a for (a, _), same in zip(ends, one, strict=True)]
    return go.Bar(
        x=[b - start for (_, b), start in zip(ends, base, strict=True)],
        base=base,
        y=[name for name, _ in chosen],
        orientation="h",
        marker={"color": colour},
        name=words,
        text=[_words(a, b, same) for (a, b), same in zip(ends, one, strict=True)],
        textposition="outside",
        cliponaxis=False,
        hovertemplate="%{y}: %{text} % per 1 %<extra></extra>",
    )


def _words(low: float, high: float, same: bool) -> str:
    if same:
        return f"{'+' if high > 0 else '−'}{engineering(abs(high))}"
    return f"{engineering(low)} … {engineering(high)}"


def _name(path: str, data: xr.Dataset, place: int) -> str:
    """The path without its table, and its value: ``main.sun.mass = 750 kg``."""
    head, _, rest = path.partition(".")
    short = rest if head in ("stages", "bodies") else path
    value = engineering(float(numbers(data, "parameter_value")[place]))
    return f"{short} = {value} {texts(data, 'parameter_unit')[place]}".rstrip()
