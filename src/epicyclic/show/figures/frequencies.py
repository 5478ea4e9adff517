"""Natural frequencies as stems: height the frequency, colour and marker the kind, a number the multiplicity."""

from __future__ import annotations

import plotly.graph_objects as go
import xarray as xr

from .series import engineering
from .style import PALE, beside, figure, mode_colour, mode_symbol, note
from .summaries import ModeGroup, mesh_tones, mode_groups

__all__ = ["frequencies"]

# Width of the plot on the narrowest page that names must have room on, 900 px with the names of tones beside it.
_NARROW = 590.0  # [px]


def frequencies(modes: xr.Dataset, check: xr.Dataset | None = None) -> go.Figure:
    """Natural frequencies [Hz] as stems over the number of the mode, with kind and multiplicity.

    Parameters
    ----------
    modes : Dataset of `modes`: frequency [Hz], mode_kind, multiplicity (mode).
    check : Dataset of `check`: mesh_frequency (stage) [Hz].
    """
    found = mode_groups(modes)
    drawn = figure("Natural frequencies", x="mode", y="natural frequency [Hz]", height=440)
    top = max((one.frequency for one in found), default=1.0)
    last = found[-1].first if found else 1
    named = _named(found, last, top) if len(found) <= 36 else set()
    for kind in dict.fromkeys(one.kind for one in found):
        own = [one for one in found if one.kind == kind]
        drawn.add_traces(_stems(own, kind, named))
    _tones(drawn, mesh_tones(check), top)
    drawn.update_xaxes(range=[0.2, last + 0.8], showgrid=False, dtick=1 if last <= 40 else 5)
    drawn.update_yaxes(range=[0, 1.12 * top])
    legend = {"orientation": "h", "x": 0, "xanchor": "left", "y": -0.18, "yanchor": "top"}
    tones = mesh_tones(check)
    longest = max((len(f"{stage} mesh 0000 Hz") if len(tones) > 1 else 15 for stage in tones), default=15)
    return drawn.update_layout(margin={"r": beside(longest)}, legend=legend, showlegend=True)


def _named(found: list[ModeGroup], last: int, top: float) -> set[int]:
    """First modes whose numbers find room above their heads, from the lowest on; `last` modes up to `top` [Hz]."""
    right, up = _NARROW / max(last, 1), 300.0 / (1.12 * top or 1.0)  # [px] a mode and a hertz
    boxes: list[tuple[float, float, float, float]] = []
    named = set()
    for one in found:
        wide, tall = 5.3 * len(engineering(one.frequency)) + 2, 26.0 if one.multiplicity > 1 else 13.0
        x, low = one.first * right, one.frequency * up
        if all(
            abs(x - at) >= (wide + other) / 2 or low >= below + height or below >= low + tall
            for at, below, other, height in boxes
        ):
            boxes.append((x, low, wide, tall))
            named.add(one.first)
    return named


def _stems(own: list[ModeGroup], kind: str, named: set[int]) -> list[go.Scatter]:
    colour = mode_colour(kind)
    stems = go.Scatter(
        x=[value for one in own for value in (one.first, one.first, None)],
        y=[value for one in own for value in (0.0, one.frequency, None)],
        mode="lines",
        line={"color": colour, "width": 2},
        legendgroup=kind,
        showlegend=False,
        hoverinfo="skip",
    )
    text = [
        engineering(one.frequency) + (f"<br>×{one.multiplicity}" if one.multiplicity > 1 else "")
        if one.first in named
        else ""
        for one in own
    ]
    heads = go.Scatter(
        x=[one.first for one in own],
        y=[one.frequency for one in own],
        mode="markers+text" if named else "markers",
        marker={"color": colour, "symbol": mode_symbol(kind), "size": 10},
        text=text,
        textposition="top center",
        textfont={"size": 9},
        cliponaxis=False,
        name=kind or "mode",
        legendgroup=kind,
        hovertemplate="mode %{x}: %{y:.5g} Hz<extra>" + kind + "</extra>",
    )
    return [stems, heads]


def _tones(drawn: go.Figure, tones: dict[str, float], top: float) -> None:
    """Mesh frequencies and their harmonics; those left out whose names would lie on another."""
    taken: list[float] = []
    order = [(harmonic, stage) for harmonic in range(1, 6) for stage in tones]
    for harmonic, stage in order:
        hertz = harmonic * tones[stage]
        if hertz > top or any(abs(hertz - other) < 0.06 * top for other in taken):
            continue
        name = f"{stage} mesh" if len(tones) > 1 else "mesh"
        text = f"{harmonic}× {name}" if harmonic > 1 else f"{name} {engineering(hertz)} Hz"
        drawn.add_hline(y=hertz, line={"color": PALE, "width": 1, "dash": "dot"}, layer="below")
        note(drawn, text, xref="paper", x=1.005, xanchor="left", y=hertz, yanchor="middle")
        taken.append(hertz)
