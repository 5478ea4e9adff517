"""Search of a relief: the Pareto set, or the objective over the generations."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, engineering, texts
from .style import INK, PALETTE, figure, tint

__all__ = ["relief_search"]

# what objectives are drawn in: factor from SI, unit
_READ = {"m": (1e6, "µm"), "N/m": (1e-3, "N/mm"), "N": (1.0, "N")}
_NAMES = {
    "lte": "peak to peak of the transmission error",
    "load": "largest load per length",
    "force_rms": "RMS of the dynamic mesh force",
    "force_peak": "largest mesh force",
}
_CLOUD = 4000
_AFTER = PALETTE[1]


def relief_search(result: xr.Dataset) -> go.Figure:
    """The Pareto set over the first two objectives with every candidate, or the best over the generations.

    Parameters
    ----------
    result : Dataset of `relief`: evaluated_objective (evaluation, objective), evaluated_generation (evaluation),
        solution_objective (solution, objective), best_so_far (generation, objective), objective_before,
        objective_after (objective); lengths are drawn in [um], loads per length in [N/mm].
    """
    return _front(result) if result.sizes["objective"] > 1 else _progress(result)


def _scaled(result: xr.Dataset, name: str, at: int) -> Array:
    return np.asarray(result[name].values[..., at] * _READ[texts(result, "objective_unit")[at]][0])


def _title(result: xr.Dataset, at: int) -> str:
    name = texts(result, "objective")[at]
    return f"{_NAMES[name]} [{_READ[texts(result, 'objective_unit')[at]][1]}]"


def _front(result: xr.Dataset) -> go.Figure:
    count = result.sizes["solution"]
    title = f"{count} solutions that no other beats, of {result.sizes['evaluation']} candidates"
    drawn = figure(title, x=_title(result, 0), y=_title(result, 1), height=540)
    x, y = (_scaled(result, "evaluated_objective", at) for at in (0, 1))
    kept = slice(None, None, max(1, len(x) // _CLOUD))
    generation = result["evaluated_generation"].values[kept]
    look = {"size": 4, "color": generation, "colorscale": [[0, "#E3E7EB"], [1, "#66727F"]], "showscale": False}
    cloud = {"mode": "markers", "marker": look, "name": "candidates, later ones darker", "hoverinfo": "skip"}
    drawn.add_trace(go.Scatter(x=compact(x[kept]), y=compact(y[kept]), **cloud))
    front = [_scaled(result, "solution_objective", at) for at in (0, 1)]
    names = texts(result, "variable")
    words = [
        f"solution {i}<br>" + "<br>".join(f"{name}: {value}" for name, value in zip(names, row, strict=True))
        for i, row in enumerate(result["solution_text"].values)
    ]
    line = {"color": PALETTE[0], "width": 1.6, "shape": "hv"}
    drawn.add_trace(
        go.Scatter(
            **{"x": compact(front[0]), "y": compact(front[1]), "mode": "lines+markers", "name": "Pareto set"},
            **{"line": line if result.sizes["objective"] == 2 else {**line, "width": 0}},
            **{"marker": {"color": PALETTE[0], "size": 8}, "text": words},
            hovertemplate="%{text}<br>%{x:.4g}, %{y:.4g}<extra></extra>",
        )
    )
    picked = int(result.attrs["picked"])
    before = [float(_scaled(result, "objective_before", at)) for at in (0, 1)]
    for name, place, look in (
        ("as drawn", before, {"symbol": "x", "size": 12, "color": INK}),
        ("the answer", [front[0][picked], front[1][picked]], {"symbol": "star", "size": 16, "color": _AFTER}),
    ):
        drawn.add_trace(go.Scatter(x=[place[0]], y=[place[1]], mode="markers", marker=look, name=name))
    _view(drawn, front, before)
    return drawn


def _view(drawn: go.Figure, front: list[Array], before: list[float]) -> None:
    """Show the Pareto set (solutions,) of two objectives and what is drawn; poor candidates may lie far outside."""
    for values, at, update in zip(front, before, (drawn.update_xaxes, drawn.update_yaxes), strict=True):
        low, high = min(float(values.min()), at), max(float(values.max()), at)
        room = 0.12 * (high - low) or 0.1 * abs(high) or 1.0
        update(range=[low - room, high + room])


def _progress(result: xr.Dataset) -> go.Figure:
    best = _scaled(result, "best_so_far", 0)
    picked = int(result.attrs["picked"])
    found = ", ".join(map(str, result["solution_text"].values[picked]))
    before, after = float(_scaled(result, "objective_before", 0)), float(_scaled(result, "objective_after", 0))
    unit = _READ[texts(result, "objective_unit")[0]][1]
    title = f"{engineering(before)} {unit} as drawn, {engineering(after)} {unit} with {found}"
    drawn = figure(title, x="generation", y=_title(result, 0), height=420)
    x, y = result["evaluated_generation"].values, _scaled(result, "evaluated_objective", 0)
    kept = slice(None, None, max(1, len(x) // _CLOUD))
    dots = {"size": 3, "color": tint(PALETTE[0], 0.55)}
    drawn.add_trace(go.Scatter(x=compact(x[kept]), y=compact(y[kept]), mode="markers", marker=dots, name="candidates"))
    line = {"color": _AFTER, "width": 2.4, "shape": "hv"}
    drawn.add_trace(go.Scatter(x=list(range(len(best))), y=compact(best), mode="lines", line=line, name="best so far"))
    drawn.add_hline(y=before, line={"color": INK, "width": 1.2, "dash": "dash"})
    top = max(before, float(best.max()))
    return drawn.update_yaxes(range=[0, 1.6 * top])
