"""Load sharing: coefficients as bars about 1, the ratio of each branch and the mesh forces over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, Series, compact, merged, numbers, pair_title, pairs, texts, thinned
from .style import DASHES, INK, WARNING, branch_colour, note, panels

__all__ = ["load_history", "load_sharing", "mesh_forces", "readable", "worst"]


def readable(name: str) -> str:
    """``cycle-peak`` -> ``cycle peak``."""
    return name.replace("_", " ").replace("-", " ")


def load_sharing(sharing: xr.Dataset) -> go.Figure:
    """Load-sharing coefficient of each mesh by every definition, branches that share equally at the line 1.

    Parameters
    ----------
    sharing : Dataset of `sharing`.
    """
    values = sharing["load_sharing"].transpose("mesh", "definition").values
    definitions = [readable(name) for name in texts(sharing, "definition")]
    series = merged(texts(sharing, "mesh"), values)
    groups = pairs(series)
    several = len({stage for stage, _ in groups}) > 1
    names = [pair_title(pair, several) for pair in groups]
    drawn = panels("Load-sharing coefficients", names, height=120 + 230 * len(groups), vertical_spacing=_gap(groups))
    # more numbers than this do not fit on the bars; the table has them
    numbered = len(definitions) * len({one.label for one in series}) <= 20
    low, high = _limits(values)
    shown: set[str] = set()
    for row, pair in enumerate(groups, start=1):
        for one in series:
            if (one.stage, one.pair) == pair:
                drawn.add_trace(_bars(one, definitions, one.label not in shown, numbered), row=row, col=1)
                shown.add(one.label)
        drawn.add_hline(y=1, line={"color": INK, "width": 1.5}, row=row, col=1)
        drawn.update_yaxes(title_text="coefficient [-]", range=[low, high], row=row, col=1)
    drawn.update_layout(barmode="group", bargap=0.25, bargroupgap=0.08)
    drawn.update_xaxes(showgrid=False)
    return drawn


def _gap(groups: Sequence[object]) -> float:
    return 0.3 / max(2, len(groups))


def _limits(values: Array) -> tuple[float, float]:
    """Range of the axis: 1 in it, deviations from 1 to be seen, room for numbers on the bars."""
    finite = values[np.isfinite(values)]
    low, high = min(1.0, float(finite.min(initial=1.0))), max(1.0, float(finite.max(initial=1.0)))
    span = max(high - low, 0.02)
    return low - 0.25 * span, high + 0.3 * span


def _bars(one: Series, definitions: list[str], legend: bool, numbered: bool) -> go.Bar:
    return go.Bar(
        x=definitions,
        y=[value - 1 if value is not None else None for value in compact(one.values, digits=6)],
        base=1,
        name=one.label,
        legendgroup=one.label,
        showlegend=legend,
        marker={
            "color": branch_colour(one.branch),
            "pattern": {"shape": "/" if one.side == "right" else "", "fgcolor": "white", "size": 5},
        },
        text=[f"{value:.3f}" if np.isfinite(value) else "" for value in one.values],
        textposition="outside" if numbered else "none",
        textangle=0,
        textfont={"size": 11},
        cliponaxis=False,
        hovertemplate=f"{one.label}<br>%{{x}}: %{{text}}<extra></extra>",
    )


def load_history(sharing: xr.Dataset) -> go.Figure:
    """Simultaneous load-sharing ratio of each branch over time.

    Parameters
    ----------
    sharing : Dataset of `sharing`.
    """
    drawn = _over_time(sharing, "load_sharing_history", "Load sharing over time", "ratio [-]", 1.0)
    for row in range(1, len(drawn.layout.annotations) + 1):
        drawn.add_hline(y=1, line={"color": INK, "width": 1.2}, row=row, col=1)
    return drawn


def mesh_forces(result: xr.Dataset) -> go.Figure:
    """Mesh force of each branch over time [kN]; a line at 0 where teeth come near to lifting off.

    Parameters
    ----------
    result : Dataset of `sharing`, `static` or `steady`.
    """
    drawn = _over_time(result, "mesh_force", "Mesh forces over time", "force [kN]", 1e-3)
    forces = result["mesh_force"].values
    if forces.size and np.nanmin(forces) < 0.15 * np.nanmax(forces):
        for row in range(1, len(drawn.layout.annotations) + 1):
            drawn.add_hline(y=0, line={"color": WARNING, "width": 1.2}, row=row, col=1)
    lost = [
        name
        for name, value in zip(texts(result, "mesh"), numbers(result, "contact_lost", "mesh"), strict=True)
        if value > 0
    ]
    if lost:
        note(
            drawn,
            f"contact lost in {len(lost)} of {result.sizes['mesh']} meshes",
            xref="paper",
            yref="paper",
            x=1,
            xanchor="right",
            y=1.0,
            yanchor="bottom",
            yshift=24,
            font={"size": 12, "color": WARNING},
        )
    return drawn


def _over_time(result: xr.Dataset, name: str, title: str, unit: str, scale: float) -> go.Figure:
    along = next(str(dim) for dim in result[name].dims if dim != "mesh")
    values = scale * result[name].transpose("mesh", along).values
    time = numbers(result, along, along)
    series = merged(texts(result, "mesh"), values)
    groups = pairs(series)
    several = len({stage for stage, _ in groups}) > 1
    drawn = panels(
        title,
        [pair_title(pair, several) for pair in groups],
        height=120 + 210 * len(groups),
        shared_xaxes=True,
        vertical_spacing=0.2 / max(2, len(groups)),
    )
    shown: set[str] = set()
    for row, pair in enumerate(groups, start=1):
        for one in (one for one in series if (one.stage, one.pair) == pair):
            drawn.add_trace(_curve(one, time, one.label not in shown), row=row, col=1)
            shown.add(one.label)
        drawn.update_yaxes(title_text=unit, row=row, col=1)
    drawn.update_xaxes(title_text=f"time [{_time_unit(result, along)}]", row=len(groups), col=1)
    if len(time) > 1:
        drawn.update_xaxes(range=[float(time[0]), float(time[-1])])
    return drawn


def _time_unit(result: xr.Dataset, along: str) -> str:
    if along != "time":
        return "mesh cycles"
    return str(result["time"].attrs.get("units", "s")) if "time" in result.variables else "samples"


def _curve(one: Series, time: Array, legend: bool) -> go.Scatter:
    x, y = thinned(time, one.values)
    return go.Scatter(
        x=compact(x),
        y=compact(y),
        mode="lines",
        name=one.label,
        legendgroup=one.label,
        showlegend=legend,
        line={"color": branch_colour(one.branch), "width": 1.5, "dash": DASHES[one.side == "right"]},
        hovertemplate=f"{one.label}: %{{y:.4g}} at %{{x:.4g}}<extra></extra>",
    )


def worst(sharing: xr.Dataset) -> list[tuple[str, float, str]]:
    """Largest coefficient by each definition and the mesh that has it."""
    values = sharing["load_sharing"].transpose("definition", "mesh").values
    names = texts(sharing, "mesh")
    found = []
    for definition, row in zip(texts(sharing, "definition"), values, strict=True):
        if np.isfinite(row).any():
            place = int(np.nanargmax(row))
            found.append((readable(definition), float(row[place]), names[place]))
    return found
