"""How often which mesh-load factor K_gamma occurs in trains made by the drawing."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, numbers, texts
from .style import INK, PALETTE, WARNING, figure, note, tint
from .tolerance_labels import even_bins, of_definition, percent, system_quantiles

__all__ = ["k_gamma_histogram"]

_BINS = 90
_TURNING = "mean-load-turning"
# heights above the panel of words on lines, in turn: neighbours do not cover each other
_HEIGHTS = (1.0, 1.075, 1.15)


def k_gamma_histogram(result: xr.Dataset) -> go.Figure:
    """Shares of the samples over K_gamma of the train [1], its percentiles, and lines that the user gave.

    Parameters
    ----------
    result : Dataset of `tolerance`: system_histogram (definition, bin), bin_edge (edge), system_k_gamma_quantile
        (definition, probability) [1]; reference_k_gamma (reference) [1] if any.
    """
    quantiles, references = system_quantiles(result), _references(result)
    drawn = figure(_title(quantiles), x="mesh-load factor Kγ [-]", y="share of the trains per bin [%]", height=460)
    counts = of_definition(result)["system_histogram"].values
    marked = [*quantiles.values(), *references.values()]
    low, high = _range(result, counts, marked)
    turns = _TURNING in texts(result, "definition")
    if turns:
        also = _range(result, of_definition(result, _TURNING)["system_histogram"].values, marked)
        low, high = min(low, also[0]), max(high, also[1])
    limits = {f"limit {value:g}": value for value in numbers(result, "limit").tolist() if low < value < high}
    x, y = even_bins(numbers(result, "bin_edge"), counts, low, high, _BINS)
    bars = {"x": compact(x, digits=6), "y": compact(100 * y), "width": (high - low) / _BINS}
    look = {"color": tint(PALETTE[0], 0.35), "line": {"width": 0}}
    words = "Kγ %{x:.3f}: %{y:.2f} %<extra></extra>"
    drawn.add_trace(go.Bar(**bars, name="Kγ, mean load", marker=look, hovertemplate=words))
    if turns:
        _add_turning(drawn, result, counts, low, high)
    _add_lines(drawn, quantiles, references, limits)
    drawn.update_xaxes(range=[low, high])
    drawn.update_yaxes(rangemode="tozero")
    legend = {"orientation": "h", "x": 1, "xanchor": "right", "y": -0.17, "yanchor": "top"}
    return drawn.update_layout(bargap=0, legend=legend, showlegend=True, margin={"t": 118, "b": 80})


def _title(quantiles: dict[float, float]) -> str:
    words = [f"{value:.3f} in {percent(p)}" for p, value in quantiles.items() if p > 0.5]
    return f"Kγ stays below {' and below '.join(words)} of the trains" if words else "Mesh-load factor Kγ"


def _references(result: xr.Dataset) -> dict[str, float]:
    if "reference_k_gamma" not in result:
        return {}
    return dict(zip(texts(result, "reference"), numbers(result, "reference_k_gamma").tolist(), strict=True))


def _range(result: xr.Dataset, counts: Array, shown: list[float]) -> tuple[float, float]:
    """Values between which the samples lie but for a thousandth, and what is marked; room at both sides."""
    edges, summed = numbers(result, "bin_edge"), np.cumsum(counts) / max(int(counts.sum()), 1)
    first, last = (int(np.searchsorted(summed, share)) for share in (0.0005, 0.9995))
    low = min([float(edges[first]), *shown])
    high = max([float(edges[min(last + 1, len(edges) - 1)]), *shown])
    room = 0.04 * max(high - low, 1e-6)
    return low - room, high + room


def _add_turning(drawn: go.Figure, result: xr.Dataset, still: Array, low: float, high: float) -> None:
    """The largest over the hunting period as an outline, where it is another distribution."""
    counts = of_definition(result, _TURNING)["system_histogram"].values
    if np.array_equal(counts, still):
        return
    x, y = even_bins(numbers(result, "bin_edge"), counts, low, high, _BINS)
    line = {"color": PALETTE[1], "width": 1.6, "shape": "hvh"}
    trace = {"x": compact(x, digits=6), "y": compact(100 * y), "mode": "lines", "line": line}
    drawn.add_trace(go.Scatter(**trace, name="largest while turning", hoverinfo="skip"))


def _add_lines(
    drawn: go.Figure, quantiles: dict[float, float], references: dict[str, float], limits: dict[str, float]
) -> None:
    """Percentiles and lines of the user, each with its words above the panel."""
    lines = [(value, f"{percent(p)}: {value:.3f}", INK, "solid") for p, value in quantiles.items()]
    lines += [(value, f"{name}: {value:.4g}", WARNING, "dash") for name, value in references.items()]
    lines += [(value, name, WARNING, "dot") for name, value in limits.items()]
    for place, (x, words, colour, dash) in enumerate(sorted(lines)):
        drawn.add_vline(x=x, line={"color": colour, "width": 1.6, "dash": dash})
        where = {"x": x, "xref": "x", "y": _HEIGHTS[place % len(_HEIGHTS)], "yref": "paper", "yanchor": "bottom"}
        note(drawn, words, **where, font={"size": 12, "color": colour})
