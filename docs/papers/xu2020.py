"""Figures of the page on xu2020: the source's figures 5 to 10 redrawn in kind, and what neck and slide do."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from common import PUBLISHED
from numpy.typing import NDArray

import epicyclic
from epicyclic.show.charts.over_time import modulation
from epicyclic.show.charts.renderers import DASHES, INK, PALETTE, WARNING, figure, note, panels, translucent

Array = NDArray[np.float64]
Changes = Mapping[str, Any]

NECK = "stages.main.sun.neck"
NECKS = (5.2e7, 4.9e7, 4.6e7, 4.3e7, 4.0e7)  # K_1 .. K_5 [N m^2]
HELD: Changes = {"stages.main.sun.support.z": "inf", "stages.main.planet.bearing.z": "inf"}
# one gap in all left sun meshes, fitted to the printed loads 880 and 850 N/mm at K_1
FITTED: Changes = {
    **HELD,
    "operation.torque.sun.right": None,
    "operation.torque.sun.left": "balance",
    "deviations.meshes.sun-planet.left.gap": "43.7 um",
}
# the axial support of the sun, which is not printed, fitted to -10.2 and +10.6 % for 1 mm; no gap
SOFT: Changes = {
    "operation.torque.sun.right": None,
    "operation.torque.sun.left": "balance",
    "stages.main.sun.support.z": "7.2e6 N/m",
}
CASES: Mapping[str, Changes] = {
    "sun floats axially": {},
    "held axially, load leaves right": HELD,
    "held axially, load leaves left, fitted gap": FITTED,
    "fitted axial support, load leaves left": SOFT,
}
SIDES = ("left", "right")
SLIDES = (0.0, 0.06, 0.5, 1.0)  # [mm]; the source has 0, 0.5 and 1
RIGID: Changes = {
    f"stages.main.{member}.neck.{key}": None
    for member, keys in {
        "sun": ("torsional_rigidity", "radial", "z"),
        "planet": ("diameter", "bore"),
        "ring": ("radial", "z", "rz"),
        "carrier": ("radial", "z", "rz"),
    }.items()
    for key in keys
}
FREQUENCY = np.concatenate(
    [np.arange(27.0, 1300.0, 12.0), np.arange(1300.0, 1500.0, 5.0), np.arange(1500.0, 5001.0, 20.0)]
)


def rigidity(value: float) -> Changes:
    """The neck's G I_p [N m^2], its other stiffnesses held."""
    return {f"{NECK}.torsional_rigidity": value}


def solid(value: float) -> Changes:
    """A solid neck whose diameter gives G I_p [N m^2], with the bending stiffness that goes with it."""
    diameter = (32 * value / (np.pi * 206e9 / 2.6)) ** 0.25
    held = dict.fromkeys((f"{NECK}.{key}" for key in ("torsional_rigidity", "radial", "z")), None)
    return {**held, f"{NECK}.diameter": diameter}


@cache
def _loads(changes: str) -> tuple[float, float]:
    result = epicyclic.static("xu2020", overrides=json.loads(changes), cycles=1, samples=8)
    force = result.mesh_force.mean("time")
    names = [name for name in force.mesh.values.tolist() if "sun-planet" in name]
    left, right = (float(force.sel(mesh=[n for n in names if n.endswith(side)]).mean()) for side in SIDES)
    return left, right


def loads(*changes: Changes) -> tuple[float, float]:
    """Mean force of a left and of a right sun mesh at rest, gaps that open and all [N]."""
    return _loads(json.dumps({key: value for change in changes for key, value in change.items()}))


def share(*changes: Changes) -> float:
    """Part of the load that the left half carries."""
    left, right = loads(*changes)
    return left / (left + right)


def fig5() -> go.Figure:
    """Mesh stiffness over a cycle, as the phase of eq. (11) has it, and force per nominal approach over the neck."""
    names = ["k(t) of sun mesh 1; the twist is a phase", "force of a half, relative to K_1; the twist is a gap"]
    title = "The twist shifts the stiffness by 0.003 cycles, which no one sees; what it can change is the load"
    drawn = panels(title, names, height=500, columns=2, horizontal_spacing=0.12)
    for place, (value, lag) in enumerate(((NECKS[0], 0.00217), (NECKS[-1], 0.00282))):
        result = epicyclic.stiffness("xu2020", overrides={"stages.main.stagger": lag}, samples=128)
        for side, dash in zip(SIDES, DASHES, strict=False):
            history = result.mesh_stiffness.sel(mesh=f"main/sun-planet/1/{side}").values * 1e-9
            line = {"color": PALETTE[place], "dash": dash, "width": 2}
            label = f"{side}, K_{5 if place else 1} = {value * 1e-7:.1f}e7 N m2"
            drawn.add_scatter(x=result.mesh_phase.values, y=history.round(5), name=label, line=line, row=1, col=1)
    for (name, case), colour in zip(CASES.items(), PALETTE[2:], strict=False):
        base = loads(case, rigidity(NECKS[0]))
        change = np.array([loads(case, rigidity(value)) for value in NECKS]) / base - 1
        for at, (side, dash) in enumerate(zip(SIDES, DASHES, strict=False)):
            line = {"color": colour, "dash": dash, "width": 2}
            text = {"name": f"{name}: {side}", "mode": "lines", "line": line}
            drawn.add_scatter(x=np.array(NECKS) * 1e-7, y=100 * change[:, at], row=1, col=2, **text)
    points = {"x": [4.0, 4.0], "y": [9.79, -11.23], "name": "published, largest stiffness", "mode": "markers"}
    drawn.add_scatter(row=1, col=2, marker=PUBLISHED, **points)
    drawn.update_xaxes(title_text="mesh cycle [-]", row=1, col=1)
    drawn.update_yaxes(title_text="mesh stiffness [1e9 N/m]", row=1, col=1)
    drawn.update_xaxes(title_text="G I_p of the neck [1e7 N m2]", autorange="reversed", row=1, col=2)
    drawn.update_yaxes(title_text="change [%]", row=1, col=2)
    return drawn.update_layout(legend={"orientation": "h", "x": 0, "y": -0.2, "yanchor": "top"}, margin={"b": 150})


def fig6() -> go.Figure:
    """Stiffness of a left and of a right mesh over a cycle, the sun in its place and slid by 1 mm."""
    title = "A slide of 1 mm leaves the mesh stiffness as it is: the planet's face stays inside the sun's"
    drawn = panels(title, [f"{side} sun mesh 1" for side in SIDES], height=440, columns=2, horizontal_spacing=0.1)
    for column, (side, change) in enumerate(zip(SIDES, (-6.3e7, 1.11e8), strict=True), start=1):
        for value, dash, width in ((0.0, "solid", 4.0), (1.0, "dash", 1.8)):
            result = epicyclic.stiffness("xu2020", overrides={**HELD, **slid(value)}, samples=128)
            x, y = result.mesh_phase.values, result.mesh_stiffness.sel(mesh=f"main/sun-planet/1/{side}").values * 1e-9
            line = {"color": PALETTE[round(value)], "dash": dash, "width": width}
            name = {"name": f"slide of {value:g} mm, sun and planets held axially", "showlegend": column == 1}
            drawn.add_scatter(x=x, y=y.round(5), mode="lines", line=line, **name, row=1, col=column)
        mark = {"x": [float(x[y.argmax()])], "y": [float(y.max() + change * 1e-9)], "marker": PUBLISHED}
        name = {"name": "published change of the largest, -0.063 and +0.111, from ours", "showlegend": column == 1}
        drawn.add_scatter(**mark, **name, mode="markers", row=1, col=column)
    drawn.update_xaxes(title_text="mesh cycle [-]")
    drawn.update_yaxes(range=[2.1, 4.5]).update_yaxes(title_text="mesh stiffness [1e9 N/m]", col=1)
    return drawn.update_layout(legend={"orientation": "h", "x": 0, "y": -0.2, "yanchor": "top"}, margin={"b": 110})


def slide() -> go.Figure:
    """Load of the halves over the slide of the sun."""
    places = np.linspace(-0.5, 1.0, 61)
    drawn = figure(
        "Load over the slide, by axial support: 7.2e6 N/m a half is fitted to the printed change of load",
        x="slide of the sun to the right [mm]",
        y="mean force of a mesh [kN]",
    )
    for (name, case), colour in zip(CASES.items(), PALETTE[2:], strict=False):
        values = np.array([loads(case, {"deviations.sun.position.z": float(value) * 1e-3}) for value in places]) * 1e-3
        for at, (side, dash) in enumerate(zip(SIDES, DASHES, strict=False)):
            line = {"color": colour, "dash": dash, "width": 2.2}
            drawn.add_scatter(x=places, y=values[:, at].round(3), name=f"{name}: {side}", mode="lines", line=line)
    left, right = loads(FITTED)
    printed = {"x": [1.0, 1.0], "y": [left * 790 / 880 * 1e-3, right * 940 / 850 * 1e-3]}
    drawn.add_scatter(
        **printed, mode="markers", marker=PUBLISHED, name="Figure 8: largest unit loads at 1 mm per those at 0"
    )
    legend = {"orientation": "h", "x": 0, "y": -0.2, "yanchor": "top"}
    return drawn.update_layout(legend=legend, margin={"b": 150}, height=500)


def neck() -> go.Figure:
    """Share of the left half over the neck's torsional rigidity."""
    values = np.geomspace(1e6, 1e10, 41)
    drawn = figure(
        "Share of the left half over the neck: one half whatever the neck where the sun floats",
        x="G I_p of the neck [N m2]",
        y="left share of the load [-]",
    )
    for (name, case), colour in zip(CASES.items(), PALETTE[2:], strict=False):
        shares = [round(share(case, rigidity(float(value))), 5) for value in values]
        drawn.add_scatter(x=values, y=shares, name=name, mode="lines", line={"color": colour, "width": 2.5})
    points = {"x": [5.2e7, 4.0e7], "y": [880 / 1730, 940 / 1720]}
    drawn.add_scatter(**points, name="published, from the largest unit loads", mode="markers", marker=PUBLISHED)
    drawn.add_vrect(x0=4.0e7, x1=5.2e7, line={"width": 0}, fillcolor=translucent(INK, 0.08))
    note(drawn, "K_5 .. K_1", x=np.log10(4.6e7), y=0.97, yref="paper")
    drawn.update_xaxes(type="log", dtick=1, exponentformat="power", separatethousands=False)
    drawn.update_yaxes(range=[0, 1])
    return drawn.update_layout(legend={"x": 0.98, "xanchor": "right", "y": 0.98})


def factor(changes: Changes, frequency: float, side: str) -> tuple[Array, Array, float]:
    """Load factor of eq. (24) of sun mesh 1 over one mesh cycle: phase, 4 F / sum F, and the least force [N]."""
    speed = frequency / (95 * 17.3 / 60)
    result = epicyclic.sharing("xu2020", overrides=changes, relative_speed=speed, stored_cycles=1, samples=128)
    names = [f"main/sun-planet/{planet}/{side}" for planet in range(1, 5)]
    history: Array = result.load_sharing_history.sel(mesh=names[0]).values
    return np.arange(history.size) / history.size, history, float(result.mesh_force.sel(mesh=names).min())


def parted_factor() -> tuple[Array, Array]:
    """The same at 1440 Hz with teeth that part, sun floating: a motion that is not stable."""
    result = epicyclic.steady("xu2020", relative_speed=1440.0 / (95 * 17.3 / 60), contact_loss=True)
    force = result.mesh_force.sel(mesh=[f"main/sun-planet/{planet}/left" for planet in range(1, 5)])
    share = 4 * force.isel(mesh=0) / force.sum("mesh")
    return result.mesh_phase.values, share.values


def fig7() -> go.Figure:
    """Load factor among the planets over a mesh cycle."""
    panel = {"27 Hz, where the rotor turns at 17.3 rpm": 27.4, "1440 Hz, carrier at 909 rpm": 1440.0}
    title = "Load factor of sun mesh 1: near 1 at running speed; at 1440 Hz the linear teeth pull"
    drawn = panels(title, list(panel), height=500, columns=2, horizontal_spacing=0.1)
    cases: tuple[tuple[str, Changes, str], ...] = (
        ("left, floating", {}, "left"),
        ("left, held axially", HELD, "left"),
        ("right, held axially", HELD, "right"),
        ("planar model (rigid necks)", RIGID, "left"),
    )
    for column, frequency in enumerate(panel.values(), start=1):
        pull = 0.0
        for place, (name, changes, side) in enumerate(cases):
            phase, history, least = factor(changes, frequency, side)
            pull = min(pull, least)
            line = {"color": PALETTE[place], "dash": DASHES[place % 4], "width": 2}
            curve = {"x": phase, "y": history.round(5), "name": name, "line": line, "showlegend": column == 1}
            drawn.add_scatter(**curve, mode="lines", row=1, col=column)
        for value in (1.04, 1.03, 1.09):
            drawn.add_hline(y=value, line={"color": INK, "width": 1, "dash": "dash"}, row=1, col=column)
    phase, history = parted_factor()
    line = {"color": WARNING, "dash": "dot", "width": 2}
    drawn.add_scatter(
        x=phase,
        y=history.round(5),
        name="left, floating, teeth part: not stable",
        mode="lines",
        line=line,
        row=1,
        col=2,
    )
    text = f"lines: linear teeth, pulling with<br>up to {-pull * 1e-3:.0f} kN, which none can"
    note(drawn, text, x=0.98, y=0.97, xref="x2 domain", yref="y2 domain", xanchor="right", yanchor="top")
    drawn.layout.annotations[-1].font.color = WARNING
    text = "dashed: published largest<br>1.03, 1.04, planar 1.09"
    note(drawn, text, x=0.02, y=0.03, xref="x2 domain", yref="y2 domain", xanchor="left")
    drawn.update_xaxes(title_text="mesh cycle [-]")
    drawn.update_yaxes(title_text="4 F / sum F [-]", col=1)
    return drawn.update_layout(legend={"orientation": "h", "x": 0, "y": -0.2, "yanchor": "top"}, margin={"b": 120})


@cache
def _sweep(changes: str, parting: bool) -> xr.Dataset:
    options = {"contact_loss": True, "unstable": "report"} if parting else {}
    return epicyclic.sweep("xu2020", overrides=json.loads(changes), mesh_frequency=FREQUENCY, **options)


def response(*changes: Changes, parting: bool = True) -> xr.Dataset:
    """Response over the mesh frequency, the carrier turning as the mesh frequency says.

    parting : teeth part and meet again, and every point is said to be stable or not; else contact is linear.
    """
    return _sweep(json.dumps({key: value for change in changes for key, value in change.items()}), parting)


def _widened(chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """With their neighbours: a line begins at the last point of the one before it."""
    return np.asarray(chosen | np.roll(chosen, 1) | np.roll(chosen, -1), dtype=bool)


def _curves(drawn: go.Figure, cases: Mapping[str, xr.Dataset]) -> None:
    """RMS of sun mesh 1, left above right, a curve per case: full where it is stable, dots where not.

    A coast-down that meets another motion than the run-up is a thin line of its own.
    """
    for place, (name, result) in enumerate(cases.items()):
        for row, side in enumerate(SIDES, start=1):
            mesh = result.sel(mesh=f"main/sun-planet/1/{side}")
            up, down = (mesh.mesh_force_rms.sel(direction=way).values * 1e-3 for way in ("up", "down"))
            unstable = mesh.branch_instability.values.astype(str) != ""
            other = _widened(~np.isclose(up, down, rtol=0.02))
            parts = (
                (up, ~unstable[0], "solid", 1.8),
                (up, _widened(unstable[0]), "dot", 1.8),
                (down, other & ~unstable[1], "solid", 0.9),
                (down, other & _widened(unstable[1]), "dot", 0.9),
            )
            for number, (force, part, dash, width) in enumerate(parts):
                line = {"color": PALETTE[place], "dash": dash, "width": width}
                shown = {"name": name, "legendgroup": name, "showlegend": row == 2 and number == 0}
                level = np.where(part & (force > 0), force.round(4), np.nan)
                drawn.add_scatter(x=FREQUENCY, y=level, mode="lines", line=line, **shown, row=row, col=1)
    for row in (1, 2):
        for value in (1440, 2500):
            drawn.add_vline(x=value, line={"color": INK, "width": 1, "dash": "dash"}, row=row, col=1)
    drawn.update_yaxes(type="log", title_text="dynamic force, rms [kN]", tickvals=[1, 2, 5, 10, 20, 50, 100, 200, 400])
    drawn.update_xaxes(title_text="mesh frequency [Hz]", row=2, col=1)
    text = "dotted: not stable, no train stays there; thin: coast-down where it differs; dashed lines: 1440 and 2500 Hz"
    note(drawn, text, x=0, y=-0.13, xref="paper", yref="paper", xanchor="left", yanchor="top")
    drawn.layout.annotations[-1].font.color = WARNING
    drawn.update_layout(legend={"x": 1.01, "y": 1}, margin={"b": 90})


@cache
def _unit_loads(changes: str) -> Array:
    """Largest and smallest load per length of contact line of both sides, (2, 2) [N/mm]."""
    result = epicyclic.contact("xu2020", overrides=json.loads(changes), loads=(), slices=20)
    mine = result.sel(torque_factor=1.0, mesh=[f"main/sun-planet/1/{side}" for side in SIDES])
    return np.array([mine.largest_load_per_length.values, mine.smallest_load_per_length.values]) / 1e3


def unit_loads(*changes: Changes) -> Array:
    """The same, changes one over the other."""
    return _unit_loads(json.dumps({key: value for change in changes for key, value in change.items()}))


def fig8() -> go.Figure:
    """Largest and smallest unit load over the neck and over the slide, relative to K_1 without a slide."""
    names = ["softer neck: rigid axially, fitted gap", "slide to the right, K_1: fitted axial support"]
    title = "Unit load on the teeth: each column follows the source under a fitted number that fails the other one"
    drawn = panels(title, names, height=520, columns=2, horizontal_spacing=0.12)
    slides = (0.0, 0.25, 0.5, 0.75, 1.0)
    bases = unit_loads(FITTED), unit_loads(SOFT)
    over = (
        (np.array(NECKS) * 1e-7, np.array([unit_loads(FITTED, rigidity(value)) for value in NECKS])),
        (np.array(slides), np.array([unit_loads(SOFT, {"deviations.sun.position.z": z * 1e-3}) for z in slides])),
    )
    published = ((4.0, ((940, 780), (280, 240))), (1.0, ((790, 940), (250, 280))))
    printed = np.array([[880, 850], [260, 270]])
    for column, ((x, load), (at, changed)) in enumerate(zip(over, published, strict=True), start=1):
        for i, side in enumerate(SIDES):
            for j, (word, dash) in enumerate(zip(("largest", "smallest"), DASHES, strict=False)):
                line = {"color": PALETTE[i], "dash": dash, "width": 2}
                text = {"name": f"{side}, {word}", "showlegend": column == 1, "mode": "lines", "line": line}
                drawn.add_scatter(
                    x=x, y=(100 * (load[:, j, i] / bases[column - 1][j, i] - 1)).round(3), row=1, col=column, **text
                )
                ratio = 100 * (changed[j][i] / printed[j, i] - 1)
                look = {**PUBLISHED, "color": PALETTE[i], "symbol": ("diamond", "diamond-open")[j]}
                drawn.add_scatter(
                    x=[at], y=[ratio], mode="markers", marker=look, name=f"published, {side}, {word}",
                    showlegend=column == 1, row=1, col=column,
                )  # fmt: skip
    for name, case, grey in (("fitted axial support, left", SOFT, "#444444"), ("sun floats, all four", {}, "#999999")):
        rest = unit_loads(case)
        change = [100 * (unit_loads(case, rigidity(value))[0, 0] / rest[0, 0] - 1) for value in NECKS]
        line = {"color": grey, "width": 2.5}
        drawn.add_scatter(x=over[0][0], y=change, mode="lines", line=line, name=name, row=1, col=1)
    drawn.update_xaxes(title_text="G I_p of the neck [1e7 N m2]", autorange="reversed", row=1, col=1)
    drawn.update_xaxes(title_text="slide of the sun [mm]", row=1, col=2)
    drawn.update_yaxes(title_text="change of the load per length [%]", row=1, col=1)
    return drawn.update_layout(legend={"orientation": "h", "x": 0, "y": -0.2, "yanchor": "top"}, margin={"b": 150})


def teeth() -> go.Figure:
    """Load per length over the flanks of sun and planet 1, both sides: the maps a to f of the source's figure 8."""
    slid = {**SOFT, "deviations.sun.position.z": 1e-3}
    cases = {"K_1": FITTED, "K_5": {**FITTED, **rigidity(NECKS[-1])}, "K_1, slid by 1 mm": slid}
    names = [f"main/sun-planet/1/{side}" for side in SIDES]
    loads_of, titles = [], []
    for (name, case), letters in zip(cases.items(), ("ab", "cd", "ef"), strict=True):
        result = epicyclic.contact("xu2020", overrides=dict(case), loads=(), slices=20)
        mine = result.sel(mesh=names, torque_factor=1.0)
        loads_of.append(result["flank_load_per_length"].sel(mesh=names).values / 1e3)
        parts = zip(letters, SIDES, mine["side_share"].values, mine["largest_load_per_length"].values, strict=True)
        titles += [f"{at}) {side}, {name}: {100 * part:.1f} %, {most / 1e3:.0f} N/mm" for at, side, part, most in parts]
    title = "Load over the flanks: share of the side and largest load at a corner of the flank"
    drawn = panels(
        title, titles, height=860, columns=2, shared_yaxes=True, horizontal_spacing=0.05, vertical_spacing=0.09
    )
    scale = [[0, "#F4F8FB"], [0.25, "#B9D7EA"], [0.5, "#56A3D0"], [0.75, "#1F6FA8"], [1, "#0B2E4F"]]
    for row, load in enumerate(loads_of, start=1):
        for i in range(2):
            drawn.add_heatmap(
                x=(result.width.values * 175).round(2),
                y=result.flank_place.values.round(4),
                z=load[i].T.round(0),
                zmin=0,
                zmax=1000,
                colorscale=scale,
                showscale=row == 1 and i == 1,
                colorbar={"title": {"text": "N/mm"}, "thickness": 14},
                row=row,
                col=i + 1,
            )
        drawn.update_yaxes(title_text="place on the path [-]", row=row, col=1)
    drawn.update_xaxes(title_text="along the face from the left end [mm]", row=3)
    return drawn


def slid(value: float) -> Changes:
    """The sun slid to the right [mm]."""
    return {"deviations.sun.position.z": value * 1e-3}


def fig9() -> go.Figure:
    """Response over frequency for five necks."""
    title = "Five solid necks, held axially: teeth part and the main peak leans down to a jump"
    drawn = panels(title, ["left sun mesh", "right sun mesh"], height=640, vertical_spacing=0.1)
    _curves(
        drawn,
        {f"K_{i} = {value * 1e-7:.1f}e7 N m2": response(HELD, solid(value)) for i, value in enumerate(NECKS, start=1)},
    )
    return drawn


def floating() -> go.Figure:
    """Response over frequency for five necks, sun floating."""
    title = "Five solid necks, sun floating axially: the five curves are one, and left is right"
    drawn = panels(title, ["left sun mesh", "right sun mesh"], height=640, vertical_spacing=0.1)
    _curves(
        drawn, {f"K_{i} = {value * 1e-7:.1f}e7 N m2": response(solid(value)) for i, value in enumerate(NECKS, start=1)}
    )
    return drawn


def fig10() -> go.Figure:
    """Response over frequency for the source's slides, also with the softest neck, on the fitted axial support."""
    title = "Slides of the sun on a fitted axial support: the left peak falls, the right one rises, K_5 or not"
    names = ["left sun mesh", "left, main peak", "right sun mesh", "right, main peak"]
    spacing = {"vertical_spacing": 0.1, "horizontal_spacing": 0.08, "column_widths": [0.55, 0.45]}
    drawn = panels(title, names, height=680, columns=2, **spacing)
    cases = {f"{value:g} mm, K_1": response(SOFT, solid(NECKS[0]), slid(value)) for value in (0.0, 0.5, 1.0)}
    _curves(drawn, {**cases, "1 mm, K_5": response(SOFT, solid(NECKS[-1]), slid(1.0))})
    near = (FREQUENCY > 1000) & (FREQUENCY < 1600)
    for trace in drawn.data:
        force = np.array(trace.y, dtype=float)[near]
        row = 1 if trace.xaxis in (None, "x") else 2
        part = go.Scatter(trace).update(x=FREQUENCY[near], y=force, showlegend=False, xaxis=None, yaxis=None)
        drawn.add_trace(part, row=row, col=2)
    drawn.update_yaxes(type="linear", title_text=None, tickvals=None, range=[0, 180], col=2)
    drawn.update_xaxes(title_text="mesh frequency [Hz]", row=2)
    return drawn.update_layout(legend={"orientation": "h", "x": 0, "y": -0.18, "yanchor": "top"}, margin={"b": 120})


def fig10_held() -> go.Figure:
    """Response over frequency for slides, the sun held rigidly."""
    title = "Slides of the sun, rigidly held axially: 1 mm leaves the left sun meshes open"
    drawn = panels(title, ["left sun mesh", "right sun mesh"], height=640, vertical_spacing=0.1)
    _curves(drawn, {f"{value:g} mm, K_1": response(HELD, slid(value)) for value in SLIDES})
    return drawn


def sidebands() -> go.Figure:
    """What an accelerometer at the top of the ring sees, with an eccentric sun and one pin out of place."""
    faults = {"deviations.sun.run_out": "30 um", "deviations.planet.position.y": "[60, 0, 0, 0] um"}
    return modulation(epicyclic.modulation("xu2020", overrides=faults, sensor="90 deg", floor=1e-3))


FIGURES: dict[str, Callable[[], go.Figure]] = {
    "fig5": fig5,
    "fig6": fig6,
    "slide": slide,
    "neck": neck,
    "fig7": fig7,
    "fig8": fig8,
    "teeth": teeth,
    "fig9": fig9,
    "floating": floating,
    "fig10": fig10,
    "fig10-held": fig10_held,
    "sidebands": sidebands,
}
