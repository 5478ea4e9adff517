"""How often which mesh-load factor K_gamma occurs in trains made by the drawing."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, numbers, short_names, texts
from .style import INK, PALE, PALETTE, WARNING, figure, note, tint
from .tolerance_labels import even_bins, of_definition, percent, system_quantiles

__all__ = ["k_gamma_histogram"]

_BINS = 90
_TURNING = "mean-load-turning"


def k_gamma_histogram(result: xr.Dataset) -> go.Figure:
    """Shares of the samples over K_gamma [1], its percentiles, and lines that the user gave.

    Parameters
    ----------
    result : Dataset of `tolerance`: histogram (definition, pair, bin), bin_edge (bin or edge), system_k_gamma_quantile
        (definition, probability) [1]; reference_k_gamma (reference) [1] if any.
    """
    quantiles = system_quantiles(result)
    references = (
        dict(zip(texts(result, "reference"), numbers(result, "reference_k_gamma"), strict=True))
        if ("reference_k_gamma" in result)
        else {}
    )
    drawn = figure(_title(quantiles), x="mesh-load factor Kγ [-]", y="share of the samples per bin [%]", height=440)
    low, high = _range(result, [*quantiles.values(), *references.values()])
    one = of_definition(result)
    for place, (name, counts) in enumerate(_distinct(one).items()):
        colour = PALETTE[place % len(PALETTE)]
        x, y = even_bins(_edges(result), counts, low, high, _BINS)
        drawn.add_trace(
            go.Bar(
                **{"x": compact(x, digits=6), "y": compact(100 * y), "width": (high - low) / _BINS, "name": name},
                marker={"color": tint(colour, 0.25 + 0.3 * (place > 0)), "line": {"width": 0}},
                hovertemplate=f"{name}<br>Kγ %{{x:.3f}}: %{{y:.2f}} %<extra></extra>",
            )
        )
    if _TURNING in texts(result, "definition"):
        _add_turning(drawn, result, low, high)
    _add_lines(drawn, quantiles, references)
    drawn.update_xaxes(range=[low, high])
    legend = {"orientation": "h", "x": 1, "xanchor": "right", "y": -0.2, "yanchor": "top"}
    return drawn.update_layout(barmode="overlay", bargap=0, legend=legend, showlegend=True, margin={"t": 110})


def _title(quantiles: dict[float, float]) -> str:
    words = [f"{value:.3f} in {percent(p)}" for p, value in quantiles.items() if p > 0.5]
    return f"Kγ stays below {' and below '.join(words)} of the trains" if words else "Mesh-load factor Kγ"


def _edges(result: xr.Dataset) -> Array:
    """Edges of the bins (b + 1,); lower ones alone are closed by a last bin as wide as the one before."""
    edges = numbers(result, "bin_edge")
    if len(edges) == result.sizes["bin"]:
        edges = np.append(edges, 2 * edges[-1] - edges[-2])
    return edges


def _distinct(one: xr.Dataset) -> dict[str, Array]:
    """Name -> counts (b,) of the pairs; pairs with the same counts are one."""
    names = short_names(texts(one, "pair"))
    found: dict[bytes, tuple[list[str], Array]] = {}
    for name, counts in zip(names, one["histogram"].transpose("pair", "bin").values, strict=True):
        found.setdefault(counts.tobytes(), ([], np.asarray(counts, dtype=np.float64)))[0].append(name)
    return {", ".join(words): counts for words, counts in found.values()}


def _range(result: xr.Dataset, shown: list[float]) -> tuple[float, float]:
    """Values between which the samples lie but for a thousandth, and what is marked; room at both sides."""
    edges, counts = _edges(result), of_definition(result)["histogram"].transpose("pair", "bin").values.sum(axis=0)
    summed = np.cumsum(counts) / max(int(counts.sum()), 1)
    first, last = (int(np.searchsorted(summed, share)) for share in (0.0005, 0.9995))
    low, high = float(edges[first]), float(edges[min(last + 1, len(edges) - 1)])
    low, high = min([low, *shown]), max([high, *shown])
    room = 0.04 * max(high - low, 1e-6)
    return low - room, high + room


def _add_turning(drawn: go.Figure, result: xr.Dataset, low: float, high: float) -> None:
    """The largest over the hunting period as an outline, where it is another distribution."""
    still, turning = _distinct(of_definition(result)), _distinct(of_definition(result, _TURNING))
    for place, (name, counts) in enumerate(turning.items()):
        if any(np.array_equal(counts, other) for other in still.values()):
            continue
        x, y = even_bins(_edges(result), counts, low, high, _BINS)
        line = {"color": PALETTE[place % len(PALETTE)], "width": 1.6, "dash": "dot", "shape": "hvh"}
        words = f"{name}, largest while turning"
        trace = go.Scatter(x=compact(x, digits=6), y=compact(100 * y), mode="lines", line=line, name=words)
        drawn.add_trace(trace)


def _add_lines(drawn: go.Figure, quantiles: dict[float, float], references: dict[str, float]) -> None:
    """Percentiles and lines of the user, each with its words at a height of its own above the panel."""
    for place, (p, value) in enumerate(sorted(quantiles.items())):
        drawn.add_vline(x=value, line={"color": INK, "width": 1.6})
        _word(drawn, value, f"{percent(p)}: {value:.3f}", 1.0 + 0.06 * (place % 2), INK)
    for name, value in references.items():
        drawn.add_vline(x=value, line={"color": WARNING, "width": 1.6, "dash": "dash"})
        _word(drawn, value, f"{name}: {value:.3g}", 1.12, WARNING)
    if references:
        note(drawn, "dashed: as given by the user", x=0, xref="paper", y=-0.2, yref="paper", font={"color": PALE})


def _word(drawn: go.Figure, x: float, text: str, y: float, colour: str) -> None:
    where = {"x": x, "xref": "x", "y": y, "yref": "paper", "yanchor": "bottom", "font": {"size": 12, "color": colour}}
    note(drawn, text, **where)
