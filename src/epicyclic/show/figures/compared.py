"""Trains beside each other: how much every quantity differs from that of the first, most at the top."""

from __future__ import annotations

import math

import plotly.graph_objects as go
import xarray as xr

from ..compared_rows import ComparedRow, compared_rows, letters, percent, shown
from .series import texts
from .style import INK, PALETTE, figure, note

__all__ = ["compared"]

# Rows of the figure: what stands below moves less than those.
_MOST = 14
# A frequency that moves by less than this share of what moves most is a bar of no visible length.
_NOTABLE = 0.01


def compared(data: xr.Dataset, *, most: int = _MOST) -> go.Figure:
    """Change of ratio, natural frequencies, load sharing and mesh forces from the first train [%], as bars about it.

    Parameters
    ----------
    data : Dataset of `compare`.  most : quantities at most; those that do not change are left out.
    """
    rows = _strongest(compared_rows(data), most)
    names, signs = texts(data, "train"), letters(data)
    drawn = figure(_title(rows, names, data), x=f"change from {signs[0]} [%]", height=170 + 34 * max(len(rows), 1))
    for place in range(len(names) - 1, 0, -1):  # plotly draws the first trace of a group lowest
        drawn.add_trace(_bars(rows, place, f"{signs[place]}  {_short(names[place])}"))
    if not rows:
        note(drawn, "nothing changes", x=0.5, xref="paper", y=0.5, yref="paper")
    drawn.add_vline(x=0, line={"color": INK, "width": 1.4})
    labels = [_label(row, signs[0]) for row in rows]
    drawn.update_yaxes(categoryorder="array", categoryarray=labels[::-1], showgrid=False)
    known = [one for row in rows for one in row.change if math.isfinite(one)]
    low, high = min([0.0, *known]), max([0.0, *known])
    room = 0.4 * ((high - low) or 1.0)  # for the figures beside the bars
    drawn.update_xaxes(range=[low - (room if low < 0 else 0.04 * room), high + (room if high > 0 else 0.04 * room)])
    legend = {
        "orientation": "h",
        "x": 0,
        "xref": "container",
        "xanchor": "left",
        "y": 0,
        "yref": "container",
        "traceorder": "reversed",
    }
    margin = {"t": 64, "b": 92 + 18 * (len(names) // 4)}
    return drawn.update_layout(
        barmode="group", bargap=0.28, showlegend=True, legend={**legend, "yanchor": "bottom"}, margin=margin
    )


def _strongest(rows: list[ComparedRow], most: int) -> list[ComparedRow]:
    """Rows that change, most at the top; of many frequencies or variables those with a notable part of the largest."""
    changed = sorted((row for row in rows if row.largest), key=lambda row: -row.largest)
    least = _NOTABLE * (changed[0].largest if changed else 0.0)
    return [row for row in changed if row.group not in ("modes", "variable") or row.largest >= least][:most]


def _title(rows: list[ComparedRow], names: list[str], data: xr.Dataset) -> str:
    """The strongest change in words."""
    if not rows:
        return "Nothing changes"
    change = rows[0].change
    place = max(range(1, len(names)), key=lambda i: abs(change[i]) if math.isfinite(change[i]) else -1.0)
    return f"{letters(data)[place]}: {rows[0].name} {percent(change[place])}, the largest change from A"


def _bars(rows: list[ComparedRow], place: int, name: str) -> go.Bar:
    """Bars of one train."""
    return go.Bar(
        x=[row.change[place] if math.isfinite(row.change[place]) else None for row in rows],
        y=[_label(row, "A") for row in rows],
        orientation="h",
        name=name,
        marker={"color": PALETTE[(place - 1) % len(PALETTE)]},
        text=[_words(row, place) for row in rows],
        textposition="outside",
        cliponaxis=False,
        hovertemplate="%{y}: %{text}<extra></extra>",
    )


def _words(row: ComparedRow, place: int) -> str:
    return f"{percent(row.change[place])}  {shown(row.value[place], row.unit)}".strip()


def _label(row: ComparedRow, sign: str) -> str:
    """Name of a row with the value of the first train."""
    return f"{row.name}<br>{sign} = {shown(row.value[0], row.unit)}"


def _short(name: str) -> str:
    """A name without the table of stages, cut where it is long."""
    short = name.replace("stages.", "")
    return short if len(short) <= 60 else f"{short[:57]}..."
