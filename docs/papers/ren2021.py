"""Figures of the page on ren2021: the source's figures 9 to 12 redrawn in kind, and its three numbers beside ours.

Printed signs are the errors of the meshes as eq. (20) states them: `printed`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from common import PUBLISHED
from numpy.typing import NDArray

import epicyclic
from epicyclic.show.charts.renderers import DASHES, INK, PALETTE, figure, note, panels

Array = NDArray[np.float64]

ON_CARRIER = {"operation.torque.sun": "28.75 kN m"}  # 100 kN m on the carrier
IDEAL: dict[str, Any] = {
    **{f"deviations.{member}.run_out": 0 for member in ("sun", "planet", "ring", "carrier")},
    "deviations.meshes": "",
}
ECCENTRIC_SUN = {**IDEAL, "deviations.sun.run_out": "20 um"}
ECCENTRIC_PLANET = {**IDEAL, "deviations.planet.run_out": "[20, 0, 0] um"}
PROFILE = {f"deviations.meshes.{pair}.profile": "20 um" for pair in ("sun-planet", "planet-ring")}
EXCHANGED = {"stages.main.sun.support.radial": "1e10 N/m", "stages.main.ring.support.radial": "1e9 N/m"}
LSC = "load-sharing coefficient LSC [-]"
AT_REST: dict[str, Any] = {"method": "static", "cycles": 23}
NORMAL = {"amplitude": "20 um", "from": "normal"}
TANGENTIAL = {"amplitude": f"{20 * np.cos(np.radians(21.8802)):.4f} um", "phase": "-90 deg"}  # (15)
# by member and pair; a positive e of (3) closes the gap
MESH_ERRORS: dict[tuple[str, str], dict[str, str]] = {
    ("sun", "sun-planet"): {**NORMAL, "sense": "closes"},
    ("planet", "sun-planet"): NORMAL,
    ("planet", "planet-ring"): {**NORMAL, "sense": "closes"},
    ("ring", "planet-ring"): NORMAL,
    ("carrier", "sun-planet"): {**TANGENTIAL, "sense": "closes"},
    ("carrier", "planet-ring"): TANGENTIAL,
}


def printed(*members: str, **changes: str) -> dict[str, Any]:
    """Errors of some members with the printed signs, in place of all deviations; changes : keys of each error."""
    errors = {
        f"deviations.meshes.{pair}.errors.{member}": {"turns_with": member, **error, **changes}
        for (member, pair), error in MESH_ERRORS.items()
        if member in members
    }
    return {"deviations": None, **errors}


PRINTED: dict[str, dict[str, Any]] = {
    "sun": printed("sun"),
    "planet": printed("planet", amplitude="[20, 0, 0] um"),
    "planets": printed("planet"),
    "ring": printed("ring"),
    "carrier": printed("carrier"),
    "profile": {"deviations": None, **PROFILE},
    "sun + ring": printed("sun", "ring"),
    "all": {**printed("sun", "planet", "ring", "carrier"), **PROFILE},
}


def lsc(overrides: dict[str, Any], **options: Any) -> float:
    """LSC of eq. (24) over the hunting period, from the steady vibration."""
    result = epicyclic.sharing("ren2021", overrides=overrides, **options)
    return float(result.system_load_sharing.sel(definition="cycle-peak"))


def support(member: str, stiffness: float) -> dict[str, Any]:
    """A lateral support [N/m]."""
    return {f"stages.main.{member}.support.radial": stiffness}


@cache
def cycle_ratios(errors: str, side: str, cycles: int) -> Array:
    """b of eq. (21) of the three sun meshes of one side, (3, cycles); errors : which of the cases."""
    overrides = {"all": {}, "sun": ECCENTRIC_SUN, "planet": ECCENTRIC_PLANET}[errors]
    options = {"cycles": cycles, "stored_cycles": cycles}
    result = epicyclic.sharing("ren2021", overrides={**overrides, **ON_CARRIER}, **options)
    return cycle_peaks(result, side, cycles)


@cache
def printed_ratios(errors: str, side: str, cycles: int) -> Array:
    """The same with the printed signs and the supports of sun and ring exchanged, at rest."""
    options: dict[str, Any] = {"method": "static", "cycles": cycles, "stored_cycles": cycles}
    result = epicyclic.sharing("ren2021", overrides={**PRINTED[errors], **ON_CARRIER, **EXCHANGED}, **options)
    return cycle_peaks(result, side, cycles)


def cycle_peaks(result: xr.Dataset, side: str, cycles: int) -> Array:
    """N P_i / sum P of every mesh cycle, from stored forces."""
    force = result.mesh_force.sel(mesh=[f"main/sun-planet/{branch}/{side}" for branch in (1, 2, 3)])
    peaks: Array = force.transpose("mesh", "time").values.reshape(3, cycles, -1).max(axis=2)
    return 3 * peaks / peaks.sum(axis=0)


def fig9() -> go.Figure:
    """LSC over the eccentricity of the carrier, with and without floating members."""
    eccentricity = np.arange(0, 101, 20)
    stiff, soft = 1e10, 1e8
    cases = {
        "no member floats (1e10 N/m)": (stiff, stiff),
        "as in Table 2 (1e9 N/m)": (1e9, 1e9),
        "sun floats (1e8 N/m)": (soft, stiff),
        "sun and carrier float": (soft, soft),
        "sun floats freely (0 N/m)": (0.0, stiff),
    }
    drawn = figure(
        "LSC rises with the carrier's eccentricity, the less the softer the supports",
        y=LSC,
        x="carrier eccentricity [um]",
    )
    for (name, (sun, carrier)), colour, dash in zip(cases.items(), PALETTE, (*DASHES, "longdash"), strict=False):
        base = {**ON_CARRIER, **support("sun", sun), **support("carrier", carrier)}
        values = [lsc({**base, "deviations.carrier.run_out": f"{value} um"}) for value in eccentricity]
        line = {"color": colour, "dash": dash, "width": 2.5}
        drawn.add_scatter(x=eccentricity, y=values, name=name, line=line, marker={"size": 7}, mode="lines+markers")
    note(
        drawn,
        "other errors 20 um; 100 kN m on the carrier<br>with eq. (15), (16) as printed all curves would be flat",
        **{
            "x": 0.02,
            "y": 0.98,
            "xref": "paper",
            "yref": "paper",
            "xanchor": "left",
            "yanchor": "top",
            "align": "left",
        },
    )
    return drawn.update_layout(legend={"x": 0.02, "y": 0.84})


def _history(drawn: go.Figure, ratios: Array, *, row: int, dashed: bool = False, legend: bool = True) -> None:
    time = (np.arange(ratios.shape[1]) + 0.5) / 27.3125
    for branch, values in enumerate(ratios):
        line = {"color": PALETTE[branch], "width": 2, "dash": "dot" if dashed else "solid", "shape": "hvh"}
        name = f"planet {branch + 1}" + (", printed signs" if dashed else "")
        trace = go.Scatter(x=time, y=values.round(5), mode="lines", line=line, name=name, showlegend=legend)
        drawn.add_trace(trace, row=row, col=1)


def _published(drawn: go.Figure, value: float, text: str, *, row: int) -> None:
    for level in (value, 2 - value):
        drawn.add_hline(y=level, line={"color": INK, "width": 1.2, "dash": "dash"}, row=row, col=1)
    drawn.add_annotation(text=text, showarrow=False, font={"size": 12, "color": INK}, align="left", row=row, col=1)
    drawn.layout.annotations[-1].update(xref="paper", x=1.01, xanchor="left", y=value)


def fig10() -> go.Figure:
    """Ratio of each planet in each mesh cycle, all errors; left over right."""
    title = "All errors of 20 um: the share of each planet over 57 mesh cycles, left and right alike"
    drawn = panels(title, ["sun meshes, left helix", "sun meshes, right helix"], height=500, vertical_spacing=0.14)
    for row, side in enumerate(("left", "right"), start=1):
        _history(drawn, cycle_ratios("all", side, 57), row=row, legend=row == 1)
        _published(drawn, 1.15, "published<br>LSC 1.15", row=row)
    drawn.update_yaxes(title_text="b of eq. (21) [-]", range=[0.7, 1.35])
    drawn.update_xaxes(title_text="time [s]", row=2, col=1)
    return drawn.update_layout(legend={"y": 0.5, "yanchor": "middle"})


def fig11() -> go.Figure:
    """Ratio of each planet in each mesh cycle, one error at a time."""
    title = "One error of 20 um at a time: only with the printed signs does the planet less than the sun"
    names = ["eccentric sun, right helix", "eccentric planet 1, right helix"]
    drawn = panels(title, names, height=500, vertical_spacing=0.14)
    for row, (case, value) in enumerate((("sun", "1.10"), ("planet", "1.043")), start=1):
        _history(drawn, cycle_ratios(case, "right", 57), row=row, legend=row == 1)
        _history(drawn, printed_ratios(case, "right", 57), row=row, dashed=True, legend=row == 1)
        _published(drawn, float(value), f"published<br>LSC {value}", row=row)
    drawn.update_yaxes(title_text="b of eq. (21) [-]", range=[0.87, 1.14])
    drawn.update_xaxes(title_text="time [s]", row=2, col=1)
    return drawn.update_layout(legend={"y": 0.5, "yanchor": "middle"})


def fig12() -> go.Figure:
    """LSC over the lateral support stiffness of one member at a time: as drawn, and as the source may have computed."""
    title = "LSC over support stiffness: sun below ring at the stiff end needs Table 2 exchanged, whatever the signs"
    names = [
        "errors put right, Table 2 as printed",
        "printed signs, sun and ring of Table 2 exchanged (at rest, 23 cycles)",
    ]
    drawn = panels(title, names, height=640, vertical_spacing=0.13)
    cases: Sequence[tuple[dict[str, Any], dict[str, Any], dict[str, float]]] = (
        (ON_CARRIER, {}, {"carrier": 1e9, "ring": 1e10, "sun": 1e9}),
        ({**PRINTED["all"], **ON_CARRIER, **EXCHANGED}, AT_REST, {"carrier": 1e9, "ring": 1e9, "sun": 1e10}),
    )
    stiffness = np.geomspace(1e7, 6e10, 16)
    for row, (base, options, table) in enumerate(cases, start=1):
        for place, (member, value) in enumerate(table.items()):
            values = [lsc({**base, **support(member, float(k))}, **options) for k in stiffness]
            line = {"color": PALETTE[place], "width": 2.5}
            one = {"row": row, "col": 1}
            drawn.add_scatter(x=stiffness, y=values, name=member, mode="lines", line=line, showlegend=row == 1, **one)
            at = {"x": [value], "y": [lsc({**base, **support(member, value)}, **options)]}
            marker = {"color": PALETTE[place], "size": 10}
            drawn.add_scatter(**at, mode="markers", showlegend=False, marker=marker, **one)
        drawn.add_vline(x=1.5e10, line={"color": INK, "width": 1.2, "dash": "dash"}, row=row, col=1)
    drawn.add_annotation(
        **{"x": np.log10(1.5e10), "y": 1.01, "yref": "y", "xref": "x", "xanchor": "right", "showarrow": False},
        text="saturated from 1.5e10 N/m on, says the source ",
    )
    drawn.update_yaxes(title_text=LSC)
    drawn.update_xaxes(type="log", dtick=1, exponentformat="power", separatethousands=False)
    text = "lateral support stiffness of one member, others as in Table 2 [N/m]"
    drawn.update_xaxes(title_text=text, row=2, col=1)
    return drawn.update_layout(legend={"x": 0.02, "y": 0.98, "title": {"text": "dots: Table 2"}})


def errors() -> go.Figure:
    """LSC of each error and of some together, for both readings of the torque and the printed signs, and published."""
    cases: dict[str, tuple[str, dict[str, Any]]] = {
        "sun": ("sun", ECCENTRIC_SUN),
        "planet 1": ("planet", ECCENTRIC_PLANET),
        "planets 1-3<br>in phase": ("planets", {**IDEAL, "deviations.planet.run_out": "20 um"}),
        "ring": ("ring", {**IDEAL, "deviations.ring.run_out": "20 um"}),
        "carrier": ("carrier", {**IDEAL, "deviations.carrier.run_out": "20 um"}),
        "profile": (
            "profile",
            {**{key: value for key, value in IDEAL.items() if key != "deviations.meshes"}, **PROFILE},
        ),
        "sun + ring": ("sun + ring", {**ECCENTRIC_SUN, "deviations.ring.run_out": "20 um"}),
        "all": ("all", {}),
    }
    published = {"sun": 1.10, "planet 1": 1.043, "all": 1.15}
    title = "20 um of each error: two of three published values take the printed signs and Table 2 exchanged"
    drawn = figure(title, y=LSC)
    exchanged = {**ON_CARRIER, **EXCHANGED}
    bars = {
        "errors put right, 100 kN m on the sun": [lsc(right) for _, right in cases.values()],
        "errors put right, 100 kN m on the carrier": [lsc({**right, **ON_CARRIER}) for _, right in cases.values()],
        "printed signs, on the carrier, Table 2 exchanged (fitted)": [
            lsc({**PRINTED[name], **exchanged}, **AT_REST) for name, _ in cases.values()
        ],
    }
    for place, (name, values) in enumerate(bars.items()):
        bar = {"base": 1, "marker": {"color": PALETTE[place]}, "name": name}
        text = {"text": [f"{value:.3f}" for value in values], "textposition": "outside", "textfont": {"size": 9}}
        drawn.add_bar(x=list(cases), y=[value - 1 for value in values], **bar, **text)
    points = {"x": list(published), "y": list(published.values()), "name": "published"}
    drawn.add_scatter(**points, mode="markers", marker=PUBLISHED)
    drawn.add_hline(y=1, line={"color": INK, "width": 1.5})
    drawn.update_xaxes(showgrid=False)
    drawn.update_yaxes(range=[0.98, 1.32])
    return drawn.update_layout(barmode="group", bargap=0.2, legend={"x": 0.02, "y": 0.98})


FIGURES: dict[str, Callable[[], go.Figure]] = {
    "fig9": fig9,
    "fig10": fig10,
    "fig11": fig11,
    "fig12": fig12,
    "errors": errors,
}
