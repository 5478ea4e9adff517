"""Which drawing entry the scatter of K_gamma comes from, and what a micrometre of each costs."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, numbers, texts
from .style import PALETTE, panels, tint
from .tolerance_labels import micrometres, of_definition, pair_labels, percent, scattering_pair, short_entries

__all__ = ["tolerance_shares"]

_TOTAL, _FIRST, _SLOPE = tint(PALETTE[0], 0.55), PALETTE[0], PALETTE[1]


def tolerance_shares(result: xr.Dataset) -> go.Figure:
    """Total and first-order variance shares of every entry [%], and slopes of a quantile over its spread [1/um].

    Parameters
    ----------
    result : Dataset of `tolerance`: sobol_first, sobol_total (definition, pair, tolerance) [1], quantile_slope
        (definition, pair, probability, tolerance) [1/m].  Shown is the pair with the largest spread; estimates below
        zero are drawn as zero.
    """
    one = of_definition(result)
    pair = scattering_pair(one)
    first, total = (one[name].transpose("pair", "tolerance").values[pair] for name in ("sobol_first", "sobol_total"))
    order = np.argsort(np.nan_to_num(total), kind="stable")
    names = [short_entries(texts(one, "tolerance"))[i] for i in order]
    probability, slope = _slopes(one, pair)
    where = pair_labels(texts(one, "pair"))[pair]
    slope = np.where(micrometres(one), slope, np.nan)
    drawn = panels(
        f"Scatter of Kγ comes most from {names[-1]} ({where})",
        ["share of the variance", f"change of Kγ at {percent(probability)}"],
        height=190 + 46 * len(names),
        columns=2,
        shared_yaxes=True,
        horizontal_spacing=0.06,
    )
    alone, whole = np.maximum(first, 0), np.maximum(total, 0)
    for values, colour, words in ((whole, _TOTAL, "with interactions (total)"), (alone, _FIRST, "alone (first order)")):
        drawn.add_trace(_bars(names, 100 * values[order], colour, words, "%"), row=1, col=1)
    words = "slope per µm of standard deviation"
    drawn.add_trace(_bars(names, 1e-6 * slope[order], _SLOPE, words, "per µm"), row=1, col=2)
    drawn.update_xaxes(title_text="share [%]", row=1, col=1)
    drawn.update_xaxes(title_text="Kγ per µm of standard deviation [1/µm]", row=1, col=2)
    drawn.update_yaxes(showgrid=False)
    room = (1.18 * 100 * float(np.nanmax(total, initial=0.01)), 1.3e-6 * float(np.nanmax(slope, initial=0.0)) or 1.0)
    for column, high in enumerate(room, start=1):
        drawn.update_xaxes(range=[0, high], row=1, col=column)
    legend = {"orientation": "h", "x": 1, "xanchor": "right", "y": 0.01, "yanchor": "bottom", "yref": "container"}
    return drawn.update_layout(barmode="group", bargap=0.3, legend=legend, margin={"t": 84, "b": 92})


def _slopes(one: xr.Dataset, pair: int) -> tuple[float, Array]:
    """Largest probability up to 0.99 that has slopes, and the slopes (tolerance,) [1/m]."""
    given = numbers(one, "probability")
    values = one["quantile_slope"].transpose("pair", "probability", "tolerance").values[pair]
    known = [i for i, p in enumerate(given) if p <= 0.99 + 1e-9 and np.isfinite(values[i]).any()]
    at = max(known, key=lambda i: float(given[i])) if known else 0
    return float(given[at]), np.asarray(values[at], dtype=np.float64)


def _bars(names: list[str], values: Array, colour: str, words: str, unit: str) -> go.Bar:
    return go.Bar(
        **{"y": names, "x": compact(values), "orientation": "h", "name": words, "marker": {"color": colour}},
        text=[_number(float(value)) for value in values],
        textposition="outside",
        cliponaxis=False,
        hovertemplate=f"%{{y}}, {words}: %{{text}} {unit}<extra></extra>",
    )


def _number(value: float) -> str:
    """Two digits; nothing of what is not known, 0 of what is less than a hundred thousandth."""
    return "" if np.isnan(value) else "0" if abs(value) < 1e-5 else f"{value:.0f}" if value >= 10 else f"{value:.2g}"
