"""Figures of the page on lin1999-n3, -n4, -n5: the source's natural frequencies, and the three kinds of modes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from common import PUBLISHED, stills

import epicyclic
from epicyclic.show.charts.renderers import figure, mode_colour, panels

PLANETS = range(3, 9)
KINDS = {"rotational": "rotational, simple", "translational": "translational, double", "planet": "planet, N - 3 fold"}


@cache
def modes(planets: int) -> xr.Dataset:
    """Modes of the set with so many planets."""
    return epicyclic.modes("lin1999-n4", overrides={"stages.main.planets": planets})


def distinct(planets: int, kind: str) -> list[float]:
    """Natural frequencies of one kind, each once [Hz]."""
    found = modes(planets)
    return sorted(set(found.frequency.values[found.mode_kind.values == kind].round(3).tolist()) - {0.0})


@cache
def published() -> xr.Dataset:
    """Published frequencies and ours, from the audits [Hz]."""
    table = epicyclic.audit(["lin1999-n3", "lin1999-n4", "lin1999-n5"])
    return table.isel(row=np.flatnonzero((table.published_unit.values == "Hz") & (table.published.values > 0)))


def frequencies() -> go.Figure:
    """Natural frequencies over the number of planets, and the published ones."""
    drawn = figure(
        "Planet modes do not depend on the number of planets; published values for 3, 4 and 5 lie on the curves",
        x="number of planets N",
        y="natural frequency [Hz]",
    )
    for kind, name in KINDS.items():
        columns = [(n, distinct(n, kind)) for n in PLANETS]
        columns = [(n, values) for n, values in columns if values]
        for branch in range(len(columns[0][1])):
            drawn.add_scatter(
                **{
                    "x": [n for n, _ in columns],
                    "y": [values[branch] for _, values in columns],
                    "mode": "lines+markers",
                },
                **{"name": name, "legendgroup": kind, "showlegend": branch == 0, "marker": {"size": 5}},
                line={"color": mode_colour(kind), "width": 2, "dash": "dot" if kind == "planet" else "solid"},
            )
    table = published()
    at = [int(str(drive)[-1]) for drive in table.drive.values]
    drawn.add_scatter(x=at, y=table.published.values, mode="markers", name="published", marker=PUBLISHED)
    drawn.update_yaxes(
        type="log", tickvals=[700, 1000, 1500, 2000, 3000, 5000, 7000, 10000, 15000], exponentformat="none"
    )
    return drawn.update_layout(legend={"y": 0.5, "yanchor": "middle"})


def differences() -> go.Figure:
    """Ours less published, by the number of planets."""
    table = published()
    names = [f"N = {n}" for n in (3, 4, 5)]
    title = "Ours less published: within the rounding of the print but for three values of N = 4"
    drawn = panels(title, names, height=500, columns=3, shared_yaxes=True, horizontal_spacing=0.03)
    for column, n in enumerate((3, 4, 5), start=1):
        part = table.isel(row=np.flatnonzero(table.drive.values == f"lin1999-n{n}"))
        for kind, name in KINDS.items():
            own = part.isel(row=np.flatnonzero([kind in str(text) for text in part.quantity.values]))
            drawn.add_scatter(
                **{"x": own.ours.values, "y": own.difference.values, "mode": "markers", "row": 1, "col": column},
                **{"name": name, "legendgroup": kind, "showlegend": n == 4},
                marker={"color": mode_colour(kind), "size": 9},
            )
        drawn.add_hrect(y0=-0.05, y1=0.05, fillcolor="#E3E7EB", line_width=0, layer="below", row=1, col=column)
    drawn.update_xaxes(type="log", tickvals=[1000, 2000, 5000, 10000], exponentformat="none")
    drawn.update_xaxes(title_text="natural frequency [Hz]", col=2)
    drawn.update_yaxes(title_text="ours less published [Hz]", col=1)
    drawn.add_annotation(
        **{"x": 0.99, "xref": "x domain", "xanchor": "right", "y": 0.05, "yanchor": "bottom", "showarrow": False},
        text="grey: half a digit of the print",
    )
    return drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.16, "yanchor": "top"})


def shapes() -> go.Figure:
    """One mode of each kind, four planets."""
    found = modes(4)
    chosen = {}
    for kind, place in (("rotational", 1), ("translational", 0), ("planet", 0)):
        mode = int(np.flatnonzero(found.mode_kind.values == kind)[place])
        chosen[f"{kind}, {float(found.frequency[mode]):.1f} Hz"] = mode
    title = "Central members turn in rotational modes, shift in translational modes and rest in planet modes"
    return stills(epicyclic.check("lin1999-n4"), found, chosen, title=title)


FIGURES: dict[str, Callable[[], go.Figure]] = {
    "frequencies": frequencies,
    "differences": differences,
    "shapes": shapes,
}
