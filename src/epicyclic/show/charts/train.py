"""A train by itself: speed and power of its members, frequencies, mesh phases and stiffnesses.

Speed, external torque and power of every member are bars about zero; shaft and mesh frequencies stand on one axis; mesh
phases on dials, one a pair of gears; mesh stiffness over one mesh cycle, one panel a pair, one curve a branch.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import (
    Series,
    by_panel,
    engineering,
    members_of,
    merged,
    numbers,
    texts,
)
from .style import DASHES, INK, OUTSIDE, PALE, add_curve, branch_colour, entry, figure, kind_colour, panels


def members(check: xr.Dataset) -> go.Figure:
    """Speed [rpm], external torque [N m or kN m] and power into the train [kW] of every member, as bars about zero.

    Parameters
    ----------
    check : Dataset of `check`: member, kind, speed [rpm], torque [N m], power [W] (body).
    """
    found = members_of(check)
    several = len({one.name.split(".")[0] for one in found}) > 1
    found = found[::-1]  # plotly draws the first bar lowest
    kilo = max((abs(one.torque) for one in found if np.isfinite(one.torque)), default=0.0) >= 1e4
    columns = {
        "speed [rpm]": [one.speed for one in found],
        f"external torque [{'kN m' if kilo else 'N m'}]": [one.torque / (1e3 if kilo else 1) for one in found],
        "power into the train [kW]": [one.power / 1e3 for one in found],
    }
    title, space = "Speed, torque and power of the members", {"shared_yaxes": True, "horizontal_spacing": 0.04}
    drawn = panels(title, list(columns), height=150 + 34 * len(found), columns=3, **space)
    for column, (name, values) in enumerate(columns.items(), start=1):
        known = [np.isfinite(value) for value in values]
        words = [engineering(value).replace("-", "\u2212") for value in values]
        drawn.add_bar(
            x=[float(value) if there else 0.0 for value, there in zip(values, known, strict=True)],
            y=[one.name.replace(".", " ") if several else one.name.split(".")[-1] for one in found],
            orientation="h",
            marker={"color": [kind_colour(one.kind) for one in found]},
            text=[text if there else "not given" for text, there in zip(words, known, strict=True)],
            hovertemplate="%{y}: %{text}<extra>" + name + "</extra>",
            **OUTSIDE,
            row=1,
            col=column,
        )
        # room for the numbers outside the bars
        finite = [value for value, there in zip(values, known, strict=True) if there]
        low, high = min([0.0, *finite]), max([0.0, *finite])
        span = high - low or 1.0
        ends = [low - (0.3 * span if low < 0 else 0.03 * span), high + 0.3 * span]
        drawn.update_xaxes(range=ends, zeroline=True, zerolinecolor=PALE, row=1, col=column)
    drawn.update_layout(showlegend=False, bargap=0.35)
    return drawn.update_yaxes(showgrid=False)


def orders(check: xr.Dataset) -> go.Figure:
    """Shaft and mesh frequencies [Hz] at the operating point, with their orders of the mesh frequency.

    Parameters
    ----------
    check : Dataset of `check`: order_frequency [Hz], order (order_name) [1].
    """
    names, hertz = _unstaged(texts(check, "order_name")), numbers(check, "order_frequency", "order_name")
    order = numbers(check, "order", "order_name")
    rank = [place for place in np.argsort(-hertz, kind="stable").tolist() if hertz[place] > 0]
    labels, tones = [names[place] for place in rank], [float(hertz[place]) for place in rank]
    drawn = figure("Shaft and mesh frequencies", x="frequency [Hz]", height=140 + 28 * len(rank))
    stems = [value for tone in tones for value in (1e-9, tone, None)]
    rows = [value for name in labels for value in (name, name, None)]
    drawn.add_scatter(x=stems, y=rows, mode="lines", line={"color": "#C5CCD3", "width": 2}, hoverinfo="skip")
    drawn.add_scatter(
        x=tones,
        y=labels,
        mode="markers+text",
        marker={"size": 11, "color": ["#D55E00" if name.endswith("mesh") else INK for name in labels]},
        text=[f"{engineering(float(hertz[at]))} Hz · order {engineering(float(order[at]))}" for at in rank],
        textposition="middle right",
        cliponaxis=False,
        hoverinfo="skip",
    )
    low, high = (min(tones), max(tones)) if rank else (1.0, 10.0)
    span = [np.floor(np.log10(low) - 0.1), np.log10(high) + 0.45 * (np.log10(high / low) + 1)]
    drawn.update_xaxes(type="log", range=span, dtick=1)
    drawn.update_yaxes(autorange="reversed", showgrid=False)
    return drawn.update_layout(showlegend=False)


def _unstaged(names: list[str]) -> list[str]:
    """``main.sun turning`` -> ``sun turning`` where there is one stage only."""
    stages = {name.split(".")[0] for name in names if "." in name.split(" ")[0]}
    if len(stages) != 1:
        return names
    stage = stages.pop()
    return [name.removeprefix(f"{stage}.").removeprefix(f"{stage} ") for name in names]


def phases(check: xr.Dataset) -> go.Figure:
    """Phase lead of every mesh [mesh cycles] on a dial a pair of gears: one turn is one mesh cycle.

    Parameters
    ----------
    check : Dataset of `check`: phase_lead (mesh) [mesh cycles].
    """
    dials = by_panel(merged(texts(check, "mesh"), numbers(check, "phase_lead", "mesh")[:, None]))
    columns = min(4, max(1, len(dials)))
    rows = -(-max(1, len(dials)) // columns)
    kinds = [[{"type": "polar"}] * columns for _ in range(rows)]
    # ticks left and right of neighbours keep apart on a narrow page too
    apart: dict[str, Any] = {"horizontal_spacing": 0.24 / columns, "specs": kinds}
    drawn = panels("Phase lead of the meshes", list(dials), height=60 + 300 * rows, columns=columns, **apart)
    for place, series in enumerate(dials.values()):
        _add_hands(drawn, series, place // columns + 1, place % columns + 1)
    tick = {"tickvals": [0, 90, 180, 270], "ticktext": ["0", "¼", "½", "¾"], "rotation": 90, "direction": "clockwise"}
    drawn.update_polars(
        angularaxis={**tick, "gridcolor": "#D5DAE0", "linecolor": PALE},
        radialaxis={"visible": False, "range": [0, 1.25]},
        bgcolor="white",
    )
    drawn.update_annotations(yshift=22)
    drawn.update_layout(showlegend=False, margin={"t": 96, "b": 40})
    return drawn


def _add_hands(drawn: go.Figure, series: list[Series], row: int, column: int) -> None:
    """One hand a branch; hands that point the same way are shortened one after the other, so that all are seen."""
    seen = list[float]()
    for one in series:
        lead = float(one.values[0])
        if not np.isfinite(lead):
            continue
        same = sum(abs((lead - other + 0.5) % 1 - 0.5) < 0.02 for other in seen)
        seen.append(lead)
        colour = branch_colour(one.branch)
        drawn.add_scatterpolar(
            theta=[0, 360 * lead],
            r=[0, 1.0 - 0.27 * same],
            mode="lines+markers+text",
            text=["", str(one.branch) if one.branch else ""],
            textposition="middle center",
            textfont={"color": "white", "size": 12},
            line={"color": colour, "width": 2.5},
            marker={"size": [0, 20], "color": colour, "opacity": 1},
            hoverinfo="text",
            hovertext=f"{one.label}: lead {engineering(lead)} mesh cycles",
            cliponaxis=False,
            name=one.label,
            row=row,
            col=column,
        )


SERIES = "As it is computed with: a Fourier series. Ripples beside a bend are where the series ends, not of the teeth."
"""Caption of `mesh_stiffness`."""


def mesh_stiffness(stiffness: xr.Dataset) -> go.Figure:
    """Mesh stiffness along the tooth normal [N/um] over one mesh cycle, a panel a pair of gears, a curve a branch,
    equal branches one.

    Parameters
    ----------
    stiffness : Dataset of `stiffness`: mesh_stiffness (mesh, mesh_phase) [N/m].
    """
    values = stiffness["mesh_stiffness"].transpose("mesh", "mesh_phase").values
    phase = numbers(stiffness, "mesh_phase")
    closed = len(phase) > 1 and phase[-1] < 1 - 1e-9 and abs(phase[0]) < 1e-9
    if closed:
        phase, values = np.append(phase, 1.0), np.append(values, values[:, :1], axis=1)
    groups = by_panel(merged(texts(stiffness, "mesh"), values, branches=True))
    names = []
    for title, series in groups.items():
        means = [float(np.mean(one.values[:-1] if closed else one.values)) / 1e6 for one in series]
        names.append(f"{title}, mean {engineering(float(np.mean(means)))} N/µm")
    space: dict[str, Any] = {"shared_xaxes": True, "vertical_spacing": 0.28 / max(2, len(groups))}
    drawn = panels("Mesh stiffness over a mesh cycle", names, height=110 + 230 * len(groups), **space)
    shown: set[str] = set()
    for row, series in enumerate(groups.values(), start=1):
        for one in series:
            line = {"color": branch_colour(one.branch), "dash": DASHES[one.side == "right"], "width": 2}
            legend = entry(one.label, first=one.label not in shown)
            add_curve(drawn, phase, one.values / 1e6, panel=row, line=line, **legend)
            shown.add(one.label)
        drawn.update_yaxes(title_text="stiffness [N/µm]", row=row, col=1)
    drawn.update_xaxes(range=[0, 1])
    drawn.update_xaxes(title_text="time [mesh cycles]", row=len(groups), col=1)
    return drawn.update_layout(hovermode="x unified")
