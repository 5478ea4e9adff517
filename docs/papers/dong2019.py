"""Figures of the page on dong2019: figures 5 to 17 and 19 of the source redrawn in kind, printed numbers as markers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from common import PUBLISHED
from numpy.typing import NDArray

import epicyclic
from epicyclic.show.charts.renderers import DASHES, INK, PALE, PALETTE, figure, panels

Array = NDArray[np.float64]
Overrides = Mapping[str, Any]

N = 5
SHARE = "share J of a star [-]"
SYSTEM = "load-sharing coefficient J [-]"
# eqs. (14), (15), (19) as printed
PRINTED_SIGN: Overrides = {
    "deviations.ring.position.phase": "180.25 deg",
    "deviations.ring.run_out.phase": "180.25 deg",
    "deviations.ring.bearing_run_out.phase": "0.25 deg",
}
FIXED_SUN: Overrides = {"stages.main.sun.support.radial": "inf"}
FIXED_RING: Overrides = {"stages.main.ring.support.radial": "inf"}
EXCHANGED: Overrides = {
    "stages.main.sun.support.radial": "9.31e6 N/m",
    "stages.main.ring.support.radial": "1.78e7 N/m",
}
TEST_TORQUES = (200, 245, 285, 325, 370)
THEORY = (1.012, 1.010, 1.008, 1.007, 1.006)
TEST = (1.121, 1.074, 1.072, 1.077, 1.062)
TORQUE = 220e3 / (6800 / 60 * 2 * np.pi)  # of the sun [N m]


def only(errors: Overrides) -> dict[str, Any]:
    """These errors and no others."""
    return {"deviations": "", **{f"deviations.{name}": value for name, value in errors.items()}}


def vector(um: float, phase: float = 0.25, start: str = "own") -> dict[str, Any]:
    """A vector error [um], [deg]."""
    return {"amplitude": um * 1e-6, "phase": f"{phase} deg", "from": start}


def static(overrides: Overrides, turns: int, samples: int = 24) -> xr.Dataset:
    """Equilibrium over turns of the sun, so many instants each."""
    return epicyclic.static("dong2019", overrides=dict(overrides), turns=turns, of="main/sun", samples=samples)


def shares(result: xr.Dataset) -> Array:
    """Share of each star over time, (N, T)."""
    force = result.mesh_force.values[:N]
    ratio: Array = N * force / force.sum(axis=0)
    return ratio


def largest(overrides: Overrides, turns: int = 1, samples: int = 120) -> float:
    """J of the system over turns of the sun."""
    return float(shares(static(overrides, turns, samples)).max())


def turns_of_sun(result: xr.Dataset) -> Array:
    """Time in turns of the sun."""
    count: Array = result.time.values * 6800 / 60
    return count


def stars(drawn: go.Figure, time: Array, values: Array, *, row: int, col: int = 1, legend: bool = False) -> None:
    """A curve for each star."""
    for star, curve in enumerate(values):
        trace = {"x": time.round(4), "y": curve.round(6), "mode": "lines", "name": f"star {star + 1}"}
        line = {"color": PALETTE[star], "width": 1.6}
        group = {"legendgroup": f"star {star}", "showlegend": legend}
        drawn.add_trace(go.Scatter(**trace, line=line, **group), row=row, col=col)


def line(drawn: go.Figure, x: Any, y: Any, name: str, place: int, **options: Any) -> None:
    """One curve of several."""
    where = {key: options.pop(key) for key in ("row", "col") if key in options}
    style = {"color": PALETTE[place], "dash": DASHES[place % len(DASHES)], "width": 2.4}
    drawn.add_trace(go.Scatter(x=x, y=y, mode="lines", name=name, line=style, **options), **where)


def printed(drawn: go.Figure, x: Any, y: Any, name: str = "published", **options: Any) -> None:
    """Published values as markers."""
    where = {key: options.pop(key) for key in ("row", "col") if key in options}
    drawn.add_trace(go.Scatter(x=x, y=y, mode="markers", name=name, marker=dict(PUBLISHED), **options), **where)


ONE = only({"sun.run_out": vector(6)})
SUN_THREE = only({"sun.position": vector(6), "sun.run_out": vector(6), "sun.bearing_run_out": vector(6, 180.25)})


def fig5() -> go.Figure:
    """Force of the spline over the float of the sun, from equilibria over 33 turns with all errors."""
    title = "The law of the spline, Fig. 5: up to the friction force, slip over the clearance, then the shaft again"
    drawn = figure(title, x="float of the sun [um]", y="force of the spline [N]")
    for place, clearance in enumerate((4.0, 8.0, 20.0)):
        result = static({**PRINTED_SIGN, **spline(clearance, {"force": 63.9})}, 33, 16)
        stretch, force = result.group_stretch.values[0] * 1e6, result.group_force.values[0]
        order = np.argsort(stretch)
        line(drawn, stretch[order].round(3), force[order].round(2), f"clearance {clearance:g} um", place)
    drawn.add_hline(y=63.9, line={"color": INK, "width": 1, "dash": "dot"})
    drawn.add_annotation(
        text="F_m = 63.9 N, fitted to Fig. 15", x=0, y=63.9, yshift=10, showarrow=False, xanchor="left"
    )
    return drawn.update_layout(legend={"x": 0.02, "y": 0.98})


def fig6() -> go.Figure:
    """Share of each star with all errors, a panel each: sign of the ring's errors as printed, and put right."""
    published = (1.023, 1.036, 1.028, 1.030, 1.025)
    names = [f"star {star}" for star in range(1, N + 1)]
    title = "All errors of 6 um: the largest of all is the printed 1.036 with the printed sign; single stars differ"
    drawn = panels(title, names, height=820, vertical_spacing=0.045, shared_xaxes=True)
    cases = {"sign of the ring's errors as printed": PRINTED_SIGN, "equations put right": {}}
    for place, (name, overrides) in enumerate(cases.items()):
        result = static(overrides, 33)
        time, curves = turns_of_sun(result), shares(result)
        for row, curve in enumerate(curves, start=1):
            width = {"color": PALETTE[place], "width": 1.7 if place == 0 else 1.0}
            group = {"legendgroup": name, "showlegend": row == 1, "name": name}
            trace = go.Scatter(x=time.round(3), y=curve.round(4), mode="lines", line=width, **group)
            drawn.add_trace(trace, row=row, col=1)
    for row, value in enumerate(published, start=1):
        trace = {"x": [0, 33], "y": [value] * 2, "mode": "lines", "name": "published largest of the star"}
        dash = {"color": INK, "width": 1.6, "dash": "dash"}
        drawn.add_trace(go.Scatter(**trace, line=dash, legendgroup="p", showlegend=row == 1), row=row, col=1)
    drawn.update_yaxes(range=[0.95, 1.05], title_text="J [-]")
    drawn.update_xaxes(range=[0, 33])
    drawn.update_xaxes(title_text="turns of the sun", row=N, col=1)
    return drawn.update_layout(legend={"orientation": "h", "y": -0.08, "x": 0.5, "xanchor": "center"})


def fig7() -> go.Figure:
    """Torque of each star at both of its gears."""
    result = static({}, 11)
    title = "Torque the sun gives to each star, and star gear II to the ring: one shape, as the shaft is in equilibrium"
    drawn = panels(
        title, ["T_spI of the sun", "T_pIIr of star gear II"], height=520, vertical_spacing=0.12, shared_xaxes=True
    )
    for row, radii in enumerate((1.0, 22 / 24), start=1):
        force = result.mesh_force.values[N * (row - 1) : N * row]
        ratio = N * force / force.sum(axis=0)
        stars(drawn, turns_of_sun(result), ratio * TORQUE / N * radii, row=row, legend=row == 1)
    drawn.update_yaxes(title_text="torque [N m]")
    drawn.update_xaxes(title_text="turns of the sun", row=2, col=1)
    return drawn


def fig8() -> go.Figure:
    """Share of each star with one eccentricity at a time."""
    cases = {
        "E_s of the sun": ("sun", "own"),
        "E_pI of star gears I": ("star1", "stage"),
        "E_pII of star gears II": ("star2", "stage"),
        "E_r of the ring": ("ring", "own"),
    }
    title = "One eccentricity of 6 um at a time: all four do the same, in the second stage 3 % less"
    drawn = panels(title, list(cases), height=560, columns=2, vertical_spacing=0.14, horizontal_spacing=0.08)
    for place, (member, start) in enumerate(cases.values()):
        where = {"row": place // 2 + 1, "col": place % 2 + 1}
        result = static(only({f"{member}.run_out": vector(6, start=start)}), 3, 48)
        stars(drawn, turns_of_sun(result), shares(result), legend=place == 0, **where)
    drawn.update_yaxes(range=[0.99, 1.01])
    drawn.update_yaxes(title_text=SHARE, col=1)
    drawn.update_xaxes(title_text="turns of the sun", row=2)
    return drawn


def eccentricities() -> go.Figure:
    """Figs. 9 to 11: J over one eccentricity."""
    sizes = np.arange(0, 51, 2.5)
    names = ["Fig. 9: sun, ring", "Fig. 10: star gears I", "Fig. 11: star gears II"]
    title = "J rises in a straight line with a single eccentricity; a dip takes an opposing error that turns along"
    drawn = panels(title, names, height=440, columns=3, horizontal_spacing=0.06, shared_yaxes=True)
    for place, (member, start, col) in enumerate(
        (("sun", "own", 1), ("ring", "own", 1), ("star1", "stage", 2), ("star2", "stage", 3))
    ):
        turns = 3 if member == "ring" else 1
        values = [largest(only({f"{member}.run_out": vector(size, start=start)}), turns) for size in sizes]
        name = member if col == 1 else "these gears alone"
        line(drawn, sizes, values, name, min(place, 2), row=1, col=col, showlegend=place < 3)
    # an eccentric journal moves the gear the other way
    against = {
        "6 um of the shaft against it": (vector(6, 0.25, "stage"), 6),
        "34 um of the other gear against it": (vector(34, 180.25, "stage"), 34),
    }
    for place, (name, (error, um)) in enumerate(against.items(), start=4):
        for member, other, col in (("star1", "star2", 2), ("star2", "star1", 3)):
            path = "star1.bearing_run_out" if um == 6 else f"{other}.run_out"
            cases = [only({f"{member}.run_out": vector(size, start="stage"), path: error}) for size in sizes]
            line(drawn, sizes, [largest(case) for case in cases], name, place, row=1, col=col, showlegend=col == 2)
    for col in (2, 3):
        drawn.add_vline(x=25, line={"color": INK, "width": 1.2, "dash": "dash"}, row=1, col=col)
    drawn.add_annotation(
        text="published<br>dip of gear 4", x=26, y=1.066, showarrow=False, xanchor="left", align="left", row=1, col=2
    )
    drawn.update_xaxes(title_text="eccentricity [um]")
    drawn.update_yaxes(title_text=SYSTEM, col=1)
    return drawn.update_layout(legend={"orientation": "h", "y": -0.2, "x": 0.5, "xanchor": "center"})


def assembly() -> go.Figure:
    """Figs. 12 to 14: share of each star over one assembly error."""
    sizes = np.array([0, 6, 12, 25, 50])
    cases = {
        "Fig. 12: sun": ("sun.position", "own"),
        "Fig. 12: ring": ("ring.position", "own"),
        "Fig. 13: star gears I": ("star1.run_out", "stage"),
        "Fig. 14: star gears II": ("star2.run_out", "stage"),
    }
    title = "J of each star over one assembly error that stands still: straight lines, their order is its direction"
    drawn = panels(title, list(cases), height=560, columns=2, vertical_spacing=0.14, horizontal_spacing=0.08)
    for place, (name, start) in enumerate(cases.values()):
        # a star gear alone is displaced as its run-out does at t = 0
        found = [
            epicyclic.static("dong2019", overrides=only({name: vector(size, start=start)}), cycles=1, samples=1)
            for size in sizes.tolist()
        ]
        values = np.concatenate([shares(result) for result in found], axis=1)
        stars(drawn, sizes, values, row=place // 2 + 1, col=place % 2 + 1, legend=place == 0)
    drawn.update_yaxes(range=[0.93, 1.07])
    drawn.update_yaxes(title_text=SHARE, col=1)
    drawn.update_xaxes(title_text="assembly error [um]", row=2)
    return drawn


def table2() -> go.Figure:
    """Table 2: J of one assembly error, over every direction it can have."""
    cases = {
        "A_s, sun": ("sun.position", "own", 1.006),
        "A_pI, star gears I": ("star1.run_out", "stage", 1.008),
        "A_pII, star gears II": ("star2.run_out", "stage", 1.016),
        "A_r, ring": ("ring.position", "own", 1.018),
    }
    title = "6 um of one assembly error in any direction: two numbers of Table 2 can be had, two cannot"
    drawn = figure(title, y=SYSTEM)
    for place, (label, (name, start, value)) in enumerate(cases.items()):
        reached = [
            shares(
                epicyclic.static("dong2019", overrides=only({name: vector(6, angle, start)}), cycles=1, samples=1)
            ).max()
            for angle in range(0, 72, 3)
        ]
        low, high = min(reached), max(reached)
        bar = {"base": low, "width": 0.35, "marker": {"color": PALETTE[0]}, "name": "ours, over all directions"}
        drawn.add_bar(x=[label], y=[high - low], showlegend=place == 0, **bar)
        printed(drawn, [label], [value], showlegend=place == 0)
    drawn.update_yaxes(range=[1, 1.02])
    return drawn.update_layout(legend={"x": 0.02, "y": 0.98})


def fig15() -> go.Figure:
    """J over the clearance of the spline."""
    title = (
        "J falls with the clearance of the spline until the slip is long enough; how far, the friction force decides"
    )
    drawn = figure(title, x="radial clearance of the spline [um]", y=SYSTEM)
    sizes = np.array([0, 2, 4, 6, 8, 10, 12, 14, 16, 17, 18, 19, 20, 25, 30])
    cases = {
        "F_m = 63.9 N, fitted to 1.013": {"force": 63.9},
        "F_m = 100 N": {"force": 100.0},
        "F_m = 150 N": {"force": 150.0},
        "F_m = 1545 N, 0.1 T over 20 mm": {"coefficient": 0.1, "radius": 0.02},
    }
    for place, (name, friction) in enumerate(cases.items()):
        line(drawn, sizes, [afloat(size, friction) for size in sizes], name, place)
    coulomb = [afloat(size, {"force": 63.9, "law": "coulomb"}) for size in (5, 10, 20)]
    marker = {"color": PALETTE[0], "size": 8, "symbol": "x"}
    drawn.add_scatter(x=[5, 10, 20], y=coulomb, mode="markers", marker=marker, name="63.9 N, friction with a history")
    text = "printed, for a gap that is large enough: 1.013"
    drawn.add_hline(y=1.013, line={"color": INK, "width": 1.2, "dash": "dash"})
    drawn.add_annotation(text=text, x=30, y=1.013, yshift=-10, showarrow=False, xanchor="right")
    return drawn.update_layout(
        legend={"x": 0.02, "y": 0.02, "yanchor": "bottom", "title": {"text": "errors as in Fig. 6"}}
    )


def afloat(clearance: float, friction: Overrides) -> float:
    """J over the common period with all errors and a spline."""
    return largest({**PRINTED_SIGN, **spline(float(clearance), friction)}, 363, 16)


def spline(clearance: float, friction: Overrides) -> dict[str, Any]:
    """Clearance [um] and friction of the sun's spline."""
    path = "stages.main.sun.support"
    return {f"{path}.clearance": clearance * 1e-6, f"{path}.friction": dict(friction)}


def fig16() -> go.Figure:
    """Share of the star with the largest peak over time for five ways to read errors, supports and what is held."""
    cases: dict[str, Overrides] = {
        "one error, as printed, both afloat: 1.008": ONE,
        "one error, as printed, sun rigid: 1.012": {**ONE, **FIXED_SUN},
        "one error, exchanged (fitted), sun rigid: 1.023": {**ONE, **EXCHANGED, **FIXED_SUN},
        "sun's three, as printed, sun on its spline shaft: 1.023": SUN_THREE,
        "sun's three, as printed, the ring rigid too: 1.065": {**SUN_THREE, **FIXED_RING},
    }
    title = "Two ways to 1.023 of Fig. 16: the sun's three errors, or K_w and K_r exchanged; 1.058 by neither"
    drawn = figure(title, x="turns of the sun", y="share J of the star with the largest peak [-]")
    for place, (name, held) in enumerate(cases.items()):
        result = static(held, 2, 48)
        curves = shares(result)
        peak = curves.max(axis=1)
        star = int(np.argmax(peak > peak.max() - 1e-4))  # alike but for the sampling: the first
        line(drawn, turns_of_sun(result).round(4), curves[star].round(6), name, place)
    printed(drawn, [2.04] * 3, [1.058, 1.023, 1.008], "published J: neither floats, ring floats, both float")
    drawn.update_xaxes(range=[0, 2.1])
    drawn.update_yaxes(range=[0.93, 1.14])
    return drawn.update_layout(legend={"x": 0.02, "y": 0.98})


def fig17() -> go.Figure:
    """Path of the centres of sun and ring."""
    result = static({}, 11, 96)
    names = ["sun", "ring"]
    title = "Paths of the floating centres with all errors, 11 turns of the sun"
    drawn = panels(title, names, height=500, columns=2, horizontal_spacing=0.1)
    for col, member in enumerate(names, start=1):
        x, y = (result.displacement.sel(dof=f"main/{member}/{axis}").values * 1e6 for axis in "xy")
        style = {"color": PALETTE[col - 1], "width": 1.2}
        trace = go.Scatter(x=x.round(4), y=y.round(4), mode="lines", line=style, showlegend=False)
        drawn.add_trace(trace, row=1, col=col)
        axis = drawn.get_subplot(1, col).xaxis.plotly_name.replace("axis", "")
        drawn.update_yaxes(scaleanchor=axis, row=1, col=col)
    drawn.update_xaxes(title_text="x [um]")
    drawn.update_yaxes(title_text="y [um]", col=1)
    return drawn


def fig19() -> go.Figure:
    """J over torque."""
    torque = np.linspace(180, 390, 22)
    errors = only({"sun.run_out": vector(6)})
    title = "One error of 6 um gives all five values of Fig. 19, with the torque read as the input's"
    drawn = figure(title, x="torque [N m]", y=SYSTEM)
    readings: Sequence[tuple[str, float]] = (
        ("torque of the sun", 1.0),
        ("torque of the ring, as the text says", 124 / 363),
    )
    for place, (name, ratio) in enumerate(readings):
        values = [largest({**errors, "operation.torque.sun": float(value * ratio)}) for value in torque]
        line(drawn, torque, values, name, place)
    printed(drawn, TEST_TORQUES, THEORY, "published, theory")
    test = {**PUBLISHED, "symbol": "square", "color": PALE}
    drawn.add_scatter(x=TEST_TORQUES, y=TEST, mode="markers", marker=test, name="published, test")
    return drawn.update_layout(legend={"x": 0.98, "xanchor": "right", "y": 0.98})


FIGURES: dict[str, Callable[[], go.Figure]] = {
    "fig5": fig5,
    "fig6": fig6,
    "fig7": fig7,
    "fig8": fig8,
    "fig9-11": eccentricities,
    "fig12-14": assembly,
    "table2": table2,
    "fig15": fig15,
    "fig16": fig16,
    "fig17": fig17,
    "fig19": fig19,
}
