"""Figures of the page on yue2014-i, -ii, -iii: the source's tables 2 and 5 beside ours, and the modes drawn."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from common import stills
from numpy.typing import NDArray

import epicyclic
from epicyclic.show.charts.renderers import INK, PALE, PALETTE, figure, mode_colour, note, panels
from epicyclic.system.tooth_pairs import pair_of
from epicyclic.teeth.form import Flank, Relief
from epicyclic.teeth.loaded_contact import microgeometry_contact
from epicyclic.teeth.segments import contact_segments

Array = NDArray[np.float64]

CASES = {"i": "I, carrier held", "ii": "II, ring held", "iii": "III, sun held"}
SYMBOLS = {"theoretical": "diamond-open", "simulated": "triangle-up-open", "experimental": "x-thin"}
KINDS = {"translational": ("common", "ours, double"), "rotational": ("simple", "ours, simple")}
MESHES = ("sun-p", "p-d", "d-ring")
BODIES = ("sun", "p", "d", "ring", "carrier")
SCALE = [[0.0, "#FFFFFF"], [0.15, "#DCE9F5"], [0.4, "#8FBCE0"], [0.7, "#3B86C2"], [1.0, "#0B4F86"]]
FREQUENCY = "natural frequency [rad/s]"


@cache
def modes(case: str) -> xr.Dataset:
    """Modes of one case."""
    return epicyclic.modes(f"yue2014-{case}")


@cache
def published(case: str) -> xr.Dataset:
    """What is printed of one case, and ours, from its audit."""
    return epicyclic.audit(f"yue2014-{case}")


def distinct(case: str) -> list[int]:
    """Elastic modes, the first of each double one, 0 the first mode."""
    found = modes(case)
    kinds = found.mode_kind.values.tolist()
    return [k for k in range(1, len(kinds)) if kinds[k] == "rotational" or kinds[: k + 1].count("translational") % 2]


def table2() -> go.Figure:
    """Natural frequencies of the three cases, printed and ours."""
    title = "Three double values common to all cases, three simple: the source's structure, not its values"
    drawn = panels(title, list(CASES.values()), height=520, columns=3, shared_yaxes=True, horizontal_spacing=0.02)
    for column, case in enumerate(CASES, start=1):
        table = published(case)
        for kind, (word, name) in KINDS.items():
            rows = _frequencies(table, f"theoretical natural frequency, {word}")
            filled = {
                "symbol": "square" if kind == "translational" else "circle",
                "size": 11,
                "color": mode_colour(kind),
            }
            _points(drawn, rows.ours.values, _orders(rows), column, name, filled)
        for source, symbol in SYMBOLS.items():
            rows = _frequencies(table, f"{source} natural frequency")
            hollow = {"symbol": symbol, "size": 9, "color": INK, "line": {"width": 1.8, "color": INK}}
            _points(drawn, rows.published.values, _orders(rows), column, f"printed, {source}", hollow)
    drawn.update_xaxes(title_text="order in Table 2", dtick=1, range=[0.4, 6.6], showgrid=False)
    drawn.update_yaxes(range=[0, 10_400])
    drawn.update_yaxes(title_text=FREQUENCY, col=1)
    return drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.16, "yanchor": "top"})


def _frequencies(table: xr.Dataset, start: str) -> xr.Dataset:
    return table.isel(row=np.flatnonzero([str(text).startswith(start) for text in table.quantity.values]))


def _orders(rows: xr.Dataset) -> list[int]:
    return [int(str(text).rpartition(" ")[2]) for text in rows.quantity.values]


def _points(
    drawn: go.Figure, values: Sequence[float], orders: Sequence[int], column: int, name: str, look: Mapping[str, object]
) -> None:
    drawn.add_scatter(
        **{"x": orders, "y": values, "mode": "markers", "marker": look, "name": name, "legendgroup": name},
        **{"showlegend": column == 1, "row": 1, "col": column},
    )


def bounds() -> go.Figure:
    """The common natural frequencies over the support of the sun, and why the printed ones are not among them."""
    stiffness = np.geomspace(1e4, 1e10, 49)
    found = [
        epicyclic.modes("yue2014-i", overrides={"stages.main.sun.support.radial": float(value)}) for value in stiffness
    ]
    double = np.array([one.angular_frequency.values[one.mode_kind.values == "translational"][::2] for one in found])
    title = "Second common value below 8022 rad/s, third above, however the sun is held: 6559 is no third"
    drawn = figure(title, x="lateral support stiffness of the sun [N/m]", y=FREQUENCY, height=500)
    for place in range(3):
        line = {"color": mode_colour("translational"), "width": 2.5}
        drawn.add_scatter(x=stiffness, y=double[:, place], line=line, name="ours, double", showlegend=place == 0)
    rows = _frequencies(published("i"), "theoretical natural frequency, common")
    look = {"symbol": SYMBOLS["theoretical"], "size": 11, "color": INK, "line": {"width": 2}}
    drawn.add_scatter(x=[3.2e6] * 3, y=rows.published.values, mode="markers", marker=look, name="printed, theoretical")
    for level in (4629, 8022):
        drawn.add_hline(y=level, line={"color": PALE, "width": 1.2, "dash": "dash"})
        words = f"{level}: p and d between a sun and a ring at rest"
        note(drawn, words, x=0.01, xref="x domain", xanchor="left", y=np.log10(level), yanchor="top")
    for text, level in (("1295", 1295), ("6456, 6559", 6508)):
        where = {"x": np.log10(3.9e6), "xanchor": "left", "y": np.log10(level), "yanchor": "middle"}
        note(drawn, text, font={"size": 12, "color": INK}, **where)
    drawn.update_xaxes(type="log", dtick=1, exponentformat="power", separatethousands=False)
    drawn.update_yaxes(
        type="log",
        range=[np.log10(900), np.log10(25_000)],
        tickvals=[1000, 2000, 5000, 10_000, 20_000],
    )
    return drawn.update_layout(legend={"x": 0.02, "y": 0.98})


def shares(case: str) -> tuple[Array, Array]:
    """Strain energy by mesh (3, 6) and kinetic energy by member (5, 6), branches added up."""
    found = modes(case).isel(mode=distinct(case))
    strain, kinetic = found.strain_energy_share, found.kinetic_energy_share
    mesh = [[f"main/{name}/{i}" for i in (1, 2, 3)] for name in MESHES]
    body = [[f"main/{name}/{i}" for i in (1, 2, 3)] if name in ("p", "d") else [f"main/{name}"] for name in BODIES]
    return (
        np.array([strain.sel(connection=own).sum("connection").values for own in mesh]),
        np.array([kinetic.sel(body=own).sum("body").values for own in body]),
    )


def keys(case: str) -> list[tuple[str, list[str]]]:
    """Table 5: key element and key components of each order."""
    elements, components = [], []
    for quantity, text in zip(published(case).quantity.values, published(case).published_text.values, strict=True):
        if found := re.match(r"order \d: strain-energy share of the (\S+) meshes", str(quantity)):
            elements.append(found[1])
        elif re.match(r"order \d: share of kinetic energy", str(quantity)):
            components.append(str(text).split(", "))
    return list(zip(elements, components, strict=True))


def table5() -> go.Figure:
    """Where the energy of each mode sits, and what the source calls key elements and key components."""
    title = "Share of the energy of each mode [%], ours; framed: key elements and key components of Table 5"
    names = [*(f"strain, {name}" for name in MESHES), *(f"kinetic, {name}" for name in BODIES)]
    drawn = panels(title, list(CASES.values()), height=460, columns=3, shared_yaxes=True, horizontal_spacing=0.02)
    for column, case in enumerate(CASES, start=1):
        percent = 100 * np.vstack(shares(case))
        omega = modes(case).angular_frequency.values[distinct(case)]
        drawn.add_heatmap(
            **{"z": percent.round(1), "x": list(range(6)), "y": names, "coloraxis": "coloraxis", "xgap": 1, "ygap": 1},
            text=[[f"{value:.0f}" if value >= 0.5 else "" for value in row] for row in percent],
            **{"texttemplate": "%{text}", "textfont": {"size": 12}, "row": 1, "col": column},
        )
        for order, (element, components) in enumerate(keys(case)):
            rows = [MESHES.index(element), *(3 + BODIES.index(name) for name in components)]
            for row in rows:
                box = {"x0": order - 0.46, "x1": order + 0.46, "y0": row - 0.44, "y1": row + 0.44}
                drawn.add_shape(type="rect", line={"color": PALETTE[1], "width": 2.5}, **box, row=1, col=column)
        ticks = [f"{order + 1}<br>{value:.0f}" for order, value in enumerate(omega)]
        drawn.update_xaxes(tickvals=list(range(6)), ticktext=ticks, showgrid=False, row=1, col=column)
        drawn.add_hline(y=2.5, line={"color": INK, "width": 1}, row=1, col=column)
    drawn.update_xaxes(title_text="order, natural frequency [rad/s]")
    drawn.update_yaxes(autorange="reversed", showgrid=False)
    bar = {"thickness": 12, "outlinewidth": 0, "title": {"text": "%"}}
    return drawn.update_layout(coloraxis={"colorscale": SCALE, "cmin": 0, "cmax": 100, "colorbar": bar})


def _bars(title: str, names: Sequence[str], values: Array, y: str) -> go.Figure:
    """A panel for each natural frequency of case I, a bar for each name; values (names, 6)."""
    omega = modes("i").angular_frequency.values[distinct("i")]
    kinds = modes("i").mode_kind.values[distinct("i")]
    words = [
        f"order {order + 1}, {value:.0f} rad/s, {'double' if kind == 'translational' else 'simple'}"
        for order, (value, kind) in enumerate(zip(omega, kinds, strict=True))
    ]
    drawn = panels(title, words, height=480, columns=3, shared_yaxes=True, vertical_spacing=0.16)
    for order in range(6):
        where = {"row": order // 3 + 1, "col": order % 3 + 1}
        bar = {"x": list(names), "y": values[:, order].round(4), "marker": {"color": mode_colour(str(kinds[order]))}}
        drawn.add_bar(**bar, showlegend=False, **where)
    drawn.update_yaxes(range=[0, 1.05])
    return drawn.update_yaxes(title_text=y, col=1)


def fig6() -> go.Figure:
    """Power of the dampers of the meshes at each natural frequency: c of every mesh is 1/21000 s of its k."""
    strain = shares("i")[0]
    title = "Fig. 6 in kind: power of the mesh dampers, case I, three branches together; the source has no scale"
    return _bars(title, MESHES, strain / strain.sum(axis=0), "share of the power [-]")


def fig7() -> go.Figure:
    """Amplitude of every member at each natural frequency, root mean square over branches and over a double mode."""
    found = modes("i").full_shape
    kinds = modes("i").mode_kind.values
    values = np.zeros((len(BODIES) + 1, 6))
    for order, mode in enumerate(distinct("i")):
        both = [mode, mode + 1] if kinds[mode] == "translational" else [mode]
        for place, name in enumerate(BODIES):
            own = [f"main/{name}/{i}" for i in (1, 2, 3)] if name in ("p", "d") else [f"main/{name}"]
            turning = found.isel(mode=both).sel(body=own, direction="rz").values
            values[place, order] = np.sqrt(np.mean(turning**2))
        aside = found.isel(mode=both).sel(body="main/sun", direction=["x", "y"]).values
        values[-1, order] = np.sqrt(np.sum(aside**2) / len(both))
    title = "Fig. 7 in kind: rotations at the base circle and the sun's float, case I; the largest of each mode is 1"
    drawn = _bars(title, (*BODIES, "sun<br>aside"), values / values.max(axis=0), "amplitude [-]")
    return drawn.update_xaxes(tickangle=0, tickfont={"size": 10})


def _panel(case: str, mode: int) -> str:
    found = modes(case)
    kind = "double" if found.mode_kind.values[mode] == "translational" else "simple"
    return f"{float(found.angular_frequency[mode]):.0f} rad/s, {kind}"


def shapes(case: str, kind: str, title: str) -> Callable[[], go.Figure]:
    """The modes of one kind, of each double one the first."""

    def draw() -> go.Figure:
        kinds = modes(case).mode_kind.values
        chosen = {_panel(case, mode): mode for mode in distinct(case) if kinds[mode] == kind}
        return stills(epicyclic.check(f"yue2014-{case}"), modes(case), chosen, title=title)

    return draw


TEETH = {"mesh": "p-d", "torque": "43 N m"}
PRINTED = (32.534, 2.4983)  # um, mm
VARY = {"tip_relief.amount": "0.02..0.08 mm", "tip_relief.length": "0.001..2.6 mm"}
# what is searched: name, what varies, colour
SEARCHES = {
    "within the printed bounds": (VARY, PALETTE[0]),
    "amount free": ({**VARY, "tip_relief.amount": "0..0.08 mm"}, PALETTE[2]),
}


@cache
def relieved(name: str) -> xr.Dataset:
    """The best relief of both gears."""
    return epicyclic.relief("yue2014-i", vary=SEARCHES[name][0], samples=256, **TEETH)


def flanks(amount: float, length: float) -> dict[str, dict[str, str]]:
    """Tip relief of both gears [um, mm] as overrides."""
    relief = {"amount": f"{amount} um", "length": f"{length} mm"}
    return {f"stages.main.{gear}.flank.tip_relief": relief for gear in ("p", "d")}


def relief_error() -> go.Figure:
    """Transmission error of the p-d pair as drawn, with the relief printed and with that found."""
    drawn = figure(
        "At 43 N m the printed relief is too much; one of the size of the deflection takes most away",
        x="time [mesh cycles]",
        y="loaded transmission error [µm]",
        height=460,
    )
    options = {**TEETH, "samples": 256, "loads": [1.0]}
    curves = [("as drawn", epicyclic.contact("yue2014-i", **options).transmission_error.values, INK)]
    printed = epicyclic.contact("yue2014-i", overrides=flanks(*PRINTED), **options)
    curves.append(("printed optimum, both gears", printed.transmission_error.values, PALETTE[1]))
    for name, (_, colour) in SEARCHES.items():
        found = relieved(name)
        error = found.relieved_error.sel(state="after").isel(relieved_mesh=0).sel(load_factor=1.0).values
        curves.append((f"{name}: {', '.join(map(str, found.solution_text.values[0]))}", error, colour))
    phase = np.arange(257) / 256
    for name, error, colour in curves:
        whole = np.append(error, error[0]) * 1e6
        label = f"{name}, {np.ptp(whole):.2f} µm"
        drawn.add_scatter(x=phase, y=whole.round(4), mode="lines", line={"color": colour, "width": 2.2}, name=label)
    drawn.update_xaxes(range=[0, 1])
    drawn.update_yaxes(rangemode="tozero")
    return drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.2, "yanchor": "top"})


def relief_map() -> go.Figure:
    """Peak to peak over amount and length of linear relief of both tips."""
    train = epicyclic.load("yue2014-i")
    mesh = next(mesh for mesh in train.meshes if mesh.name == "main/p-d/1")
    pair = pair_of(train, mesh, slices=1)
    amount, length = np.linspace(0, 40e-6, 61), np.linspace(0.04e-3, 2.6e-3, 65)
    shapes = [Flank(tip_relief=Relief(amount=float(d), length=float(h))) for h in length for d in amount]
    force = float(relieved("amount free").relieved_force[0])
    found = microgeometry_contact(
        contact_segments(pair, np.arange(256) / 256), [replace(pair, flank_a=one, flank_b=one) for one in shapes], force
    )
    swing = np.ptp(found.approach[:, 0], axis=1).reshape(len(length), len(amount)) * 1e6
    title = "Peak to peak of the transmission error over the relief of both tips: the bounds miss the valley"
    drawn = figure(title, x="amount of relief [µm]", y="length of relief, from the tip [mm]", height=520)
    drawn.add_contour(
        **{"x": amount * 1e6, "y": length * 1e3, "z": swing.round(3), "colorscale": SCALE, "ncontours": 24},
        colorbar={"thickness": 12, "outlinewidth": 0, "title": {"text": "µm"}},
        line={"width": 0.5, "color": "white"},
    )
    box = {"x0": 20, "x1": 40, "y0": 0.0001, "y1": 2.6}
    drawn.add_shape(type="rect", line={"color": PALETTE[1], "width": 2, "dash": "dash"}, **box)
    note(drawn, "printed bounds, up to 80 µm", x=30, y=0.1, font={"size": 12, "color": PALETTE[1]})
    drawn.add_hline(y=2.463, line={"color": INK, "width": 1.2, "dash": "dot"})
    note(drawn, "one pair begins to bear alone", x=13, y=2.463, yanchor="bottom", font={"size": 12, "color": INK})
    points = [("printed optimum", *PRINTED, PALETTE[1], "x")]
    for name, (_, colour) in SEARCHES.items():
        values = relieved(name).solution_value.values[0]
        points.append((f"best, {name}", values[0] * 1e6, values[1] * 1e3, colour, "star"))
    for name, x, y, colour, symbol in points:
        look = {"symbol": symbol, "size": 14, "color": colour, "line": {"width": 1, "color": "white"}}
        drawn.add_scatter(x=[x], y=[y], mode="markers", marker=look, name=name)
    drawn.update_xaxes(range=[0, 40])
    return drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.18, "yanchor": "top"})


FIGURES: dict[str, Callable[[], go.Figure]] = {
    "table2": table2,
    "bounds": bounds,
    "table5": table5,
    "fig6": fig6,
    "fig7": fig7,
    "shapes-double": shapes(
        "i", "translational", "Double modes, the same in all cases: the sun floats, no central member turns"
    ),
    "shapes-i": shapes("i", "rotational", "Simple modes of case I: all branches move alike, sun and ring turn"),
    "shapes-ii": shapes("ii", "rotational", "Simple modes of case II: sun and carrier turn"),
    "shapes-iii": shapes("iii", "rotational", "Simple modes of case III: carrier and ring turn"),
    "relief-error": relief_error,
    "relief-map": relief_map,
}
