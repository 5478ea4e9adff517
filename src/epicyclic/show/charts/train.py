"""A train by itself: speed and power of its members, frequencies, mesh phases and stiffnesses.

Speed, external torque and power of every member are bars about zero; shaft and mesh frequencies stand on one axis; mesh
phases on dials, one a pair of gears; mesh stiffness over one mesh cycle, one panel a pair, one curve a branch.
"""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import Series, by_panel, engineering, members_of, merged, numbers, texts
from .renderers import Bars, Panel, Stems, Trace, chart, level_bars, pair_panels
from .style import INK, PALE, branch_colour, kind_colour, panels


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
    names = [one.name.replace(".", " ") if several else one.name.split(".")[-1] for one in found]
    colours, shown = [kind_colour(one.kind) for one in found], []
    for title, values in columns.items():
        words = [engineering(one).replace("-", "\u2212") if np.isfinite(one) else "not given" for one in values]
        hover = f"%{{y}}: %{{text}}<extra>{title}</extra>"
        lengths = np.nan_to_num(values).tolist()
        shown.append(Panel([Bars(names, lengths, level=True, colour=colours, text=words, hover=hover)], title=title))
    return level_bars("Speed, torque and power of the members", names[::-1], *shown)


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
    text = [f"{engineering(float(hertz[at]))} Hz · order {engineering(float(order[at]))}" for at in rank]
    heads = {"color": ["#D55E00" if name.endswith("mesh") else INK for name in labels]}
    look = {"mode": "markers+text", "textposition": "middle right", "cliponaxis": False, "marker": heads}
    strokes: Trace = {"foot": 1e-9, "level": True, "colour": "#C5CCD3", "width": 2, "points": 11}
    stems = Stems(tones, labels, **strokes, text=text, hover=None, look=look)
    low, high = (min(tones), max(tones)) if rank else (1.0, 10.0)
    span = (np.floor(np.log10(low) - 0.1), np.log10(high) + 0.45 * (np.log10(high / low) + 1))
    y_axis = {"autorange": "reversed", "showgrid": False}
    panel = Panel([stems], x="frequency [Hz]", x_ends=span, x_axis={"type": "log", "dtick": 1}, y_axis=y_axis)
    return chart("Shaft and mesh frequencies", panel, height=140 + 28 * len(rank))


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
    apart: Trace = {"horizontal_spacing": 0.24 / columns, "specs": kinds}
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
    values = stiffness["mesh_stiffness"].transpose("mesh", "mesh_phase").values / 1e6
    phase = numbers(stiffness, "mesh_phase")
    closed = len(phase) > 1 and phase[-1] < 1 - 1e-9 and abs(phase[0]) < 1e-9
    if closed:
        phase, values = np.append(phase, 1.0), np.append(values, values[:, :1], axis=1)
    shown = {}
    for title, series in by_panel(merged(texts(stiffness, "mesh"), values, branches=True)).items():
        mean = np.mean([np.mean(one.values[:-1] if closed else one.values) for one in series])
        shown[f"{title}, mean {engineering(float(mean))} N/µm"] = series
    curves = pair_panels(shown, phase, "stiffness [N/µm]", width=2)
    look: Trace = {"gap": 0.28 / max(2, len(shown)), "height": 110 + 230 * len(shown), "hovermode": "x unified"}
    return chart("Mesh stiffness over a mesh cycle", *curves, x="time [mesh cycles]", x_ends=(0, 1), **look)
