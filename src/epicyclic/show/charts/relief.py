"""Relief: its search, as the Pareto set or the objective over the generations, and what it does.

Transmission error, load and dynamic force stand before and after it.
"""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import Array, compact, engineering, short_names, texts
from .style import DASHES, INK, PALE, PALETTE, figure, panels, tint

# what objectives are drawn in: factor from SI, unit
_READ = {"m": (1e6, "µm"), "N/m": (1e-3, "N/mm"), "N": (1.0, "N")}
_NAMES = {
    "lte": "peak to peak of the transmission error",
    "load": "largest load per length",
    "force_rms": "RMS of the dynamic mesh force",
    "force_peak": "largest mesh force",
}
_CLOUD = 4000
_BEFORE, _AFTER = PALE, PALETTE[1]


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


def relief_effect(result: xr.Dataset) -> go.Figure:
    """Transmission error [um], Harris map, load along the path [N/mm], dynamic force [N]: before and after relief.

    Parameters
    ----------
    result : Dataset of `relief`: relieved_error (state, relieved_mesh, load_factor, mesh_phase) [m],
        relieved_peak_to_peak (state, relieved_mesh, load_factor) [m], relieved_load (state, relieved_mesh, place)
        [N/m],
        relieved_place (relieved_mesh, place) [base pitches], relieved_force (relieved_mesh) [N];
        mesh_force_rms (state, speed) [N].
    """
    names = [
        "loaded transmission error less its mean, operating load",
        "its peak to peak over the load (Harris map)",
        "largest load per length along the path of contact, operating load",
    ]
    if "mesh_force_rms" in result:
        names.append("RMS of the dynamic mesh force, largest of the meshes looked at")
    drawn = panels("Before (grey) and after (orange) relief", names, height=330 * len(names), vertical_spacing=0.08)
    meshes = short_names(texts(result, "relieved_mesh"))
    factors = result["load_factor"].values
    now = int(np.argmin(np.abs(factors - 1.0)))
    error = result["relieved_error"].values[:, :, now] * 1e6
    phase = np.append(result["mesh_phase"].values, 1.0)
    for j, mesh in enumerate(meshes):
        shown = error[:, j] - error[:, j].mean(axis=1, keepdims=True)
        _pair(drawn, phase, np.append(shown, shown[:, :1], axis=1), mesh, j, row=1)
        load = factors * float(result["relieved_force"].values[j]) / 1e3
        _pair(drawn, load, result["relieved_peak_to_peak"].values[:, j] * 1e6, mesh, j, row=2)
        drawn.add_vline(x=load[now], line={"color": INK, "width": 1, "dash": "dot"}, row=2, col=1)
        _pair(drawn, result["relieved_place"].values[j], result["relieved_load"].values[:, j] / 1e3, mesh, j, row=3)
    titles = [
        ("time [mesh cycles]", "error [µm]"),
        ("mesh force of one helix [kN]", "error [µm]"),
        ("path of contact from the pitch point [base pitches]", "load per length [N/mm]"),
    ]
    if "mesh_force_rms" in result:
        _pair(drawn, result["speed"].values, result["mesh_force_rms"].values, "", 0, row=4)
        titles.append(("speed relative to the operating one [1]", "force [N]"))
    for row, (x, y) in enumerate(titles, start=1):
        drawn.update_xaxes(title_text=x, row=row, col=1)
        drawn.update_yaxes(title_text=y, row=row, col=1, rangemode="normal" if row == 1 else "tozero")
    return drawn


def _pair(drawn: go.Figure, x: Array, values: Array, mesh: str, number: int, *, row: int) -> None:
    """Both states (2, k) of one mesh over x (k,): a colour for the state, a dash for the mesh."""
    for i, (state, colour) in enumerate((("before", _BEFORE), ("after", _AFTER))):
        look = {"color": colour, "width": 1.6 + 0.8 * i, "dash": DASHES[number % len(DASHES)]}
        name = ", ".join(text for text in (mesh, state) if text)
        trace = {"x": compact(x), "y": compact(values[i]), "mode": "lines", "line": look, "name": name}
        drawn.add_trace(go.Scatter(**trace, legendgroup=name, showlegend=row == 1), row=row, col=1)
