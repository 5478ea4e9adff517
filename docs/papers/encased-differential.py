"""Figures of the page on encased-differential: its two tables as curves, the power paths, the load of single meshes.

Run by itself, it prints what the page says of random draws of the phases.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from common import PUBLISHED
from numpy.typing import NDArray

import epicyclic
from epicyclic.show.charts.renderers import PALE, PALETTE, branch_colour, figure, kind_colour, note, panels, translucent

Array = NDArray[np.float64]
Changes = dict[str, Any]
Errors = Callable[[float, float], Changes]

DRIVE = "encased-differential"
STAGES: Mapping[str, int] = {"differential": 3, "encased": 5}
PAIRS = ("sun-planet", "planet-ring")
SYMBOLS = ("B_p", "B_m")
CYCLES = 2000
DRAWS = 12
RUN_OUT, MESH = (0.0, 10.0, 20.0, 30.0, 40.0), (0.0, 4.0, 8.0, 12.0, 16.0)
# run-out at 8 um of mesh error; the first of a curve: mesh errors alone
BY_RUN_OUT = ((1.2905, 1.2915, 1.2918, 1.2920, 1.2923), (1.0072, 1.0802, 1.1442, 1.1980, 1.2455))
# mesh error at 20 um of run-out; the first of a curve: run-out alone
BY_MESH = ((1.0233, 1.1452, 1.2918, 1.4376, 1.5820), (1.1457, 1.1440, 1.1442, 1.1443, 1.1445))


def _vector(amplitude: float, phases: Sequence[float]) -> Changes:
    return {"amplitude": f"{amplitude:g} um", "phase": f"{[round(float(phase), 2) for phase in phases]} deg"}


def _errors(run_out: Mapping[str, Changes], mesh: Mapping[str, Changes | str]) -> Changes:
    """All errors of the drive replaced: run-outs by member, profile errors by mesh pair."""
    found: Changes = {f"deviations.{member}.run_out": value for member, value in run_out.items()}
    found.update({f"deviations.{pair.replace('/', '.meshes.')}.profile": value for pair, value in mesh.items()})
    return {"deviations": "", **found}


def _run_outs(amplitude: float, planets: Mapping[str, Sequence[float]], centre: float = 0.0) -> dict[str, Changes]:
    found = {}
    for stage, phases in planets.items():
        centres: Changes = {"amplitude": f"{amplitude:g} um", "phase": f"{centre:g} deg"}
        found.update({f"{stage}.sun": centres, f"{stage}.ring": centres, f"{stage}.planet": _vector(amplitude, phases)})
    return found


def alike(run_out: float, mesh: float) -> Changes:
    """Equal run-out phases, teeth alike: errors phased as the mesh is."""
    teeth = {f"{stage}/{pair}": f"{mesh:g} um" for stage in STAGES for pair in PAIRS}
    return _errors(_run_outs(run_out, {stage: [0.0] * count for stage, count in STAGES.items()}), teeth)


def spaced(run_out: float, mesh: float) -> Changes:
    """Planet run-outs out of step by their place, stars by twice their place; mesh errors by their place."""
    turns = {stage: 360 * np.arange(count) / count for stage, count in STAGES.items()}
    planets = {"differential": turns["differential"], "encased": 2 * turns["encased"] % 360}
    signs = dict(zip(PAIRS, (1, -1), strict=True))
    teeth = {f"{stage}/{pair}": _vector(mesh, signs[pair] * turns[stage] % 360) for stage in STAGES for pair in PAIRS}
    return _errors(_run_outs(run_out, planets), teeth)


def fitted(run_out: float, mesh: float) -> Changes:
    """All phases 0 but one star's and one ring error's, fitted to 1.1457 and 1.2905, each with its error alone."""
    planets = {"differential": [0.0] * 3, "encased": [31.84, 0, 0, 0, 0]}
    teeth = {f"{stage}/{pair}": _vector(mesh, [0.0] * count) for stage, count in STAGES.items() for pair in PAIRS}
    teeth["differential/planet-ring"] = _vector(mesh, [58.37, 0, 0])
    return _errors(_run_outs(run_out, planets), teeth)


def drawn_at_random(seed: int) -> Errors:
    """Every phase drawn at random, the same for every amplitude."""
    phases = 360 * np.random.default_rng(seed).random((2, 3, 5))

    def errors(run_out: float, mesh: float) -> Changes:
        counts = list(STAGES.items())
        planets = {stage: phases[at, 0, :count] for at, (stage, count) in enumerate(counts)}
        teeth = {
            f"{stage}/{pair}": _vector(mesh, phases[at, 1 + place, :count])
            for at, (stage, count) in enumerate(counts)
            for place, pair in enumerate(PAIRS)
        }
        return _errors(_run_outs(run_out, planets), teeth)

    return errors


READINGS: Mapping[str, Errors] = {"teeth and planets alike": alike, "out of step by place": spaced, "fitted": fitted}


@cache
def _coefficients(changes: str, method: str) -> tuple[float, float]:
    result = epicyclic.sharing(DRIVE, overrides=json.loads(changes), method=method, cycles=CYCLES, stored_cycles=1)
    found = result.load_sharing.sel(definition="cycle-peak")
    p, m = (float(found[[str(name).startswith(stage) for name in found.mesh.values]].max()) for stage in STAGES)
    return p, m


def coefficients(changes: Changes, method: str = "superposition") -> tuple[float, float]:
    """B_p and B_m by the printed definition."""
    return _coefficients(json.dumps(changes), method)


def draws(count: int = 40) -> dict[str, Array]:
    """B_p and B_m (count, 2) over random draws of the phases: run-out of 20 um alone, mesh errors of 8 um alone."""
    mean = epicyclic.check(DRIVE).mean_mesh_stiffness
    soft = {
        f"stages.{stage}.meshes.{pair}.stiffness": 0.3 * float(mean.sel(mesh=f"{stage}/{pair}/1/left"))
        for stage in STAGES
        for pair in PAIRS
    }
    cases: Mapping[str, tuple[float, float, Changes]] = {
        "run-out": (20.0, 0.0, {}),
        "mesh errors": (0.0, 8.0, {}),
        "mesh errors, 0.3 of the mesh stiffness": (0.0, 8.0, soft),
    }
    return {
        name: np.array([coefficients({**drawn_at_random(seed)(run_out, mesh), **changes}) for seed in range(count)])
        for name, (run_out, mesh, changes) in cases.items()
    }


def _over(points: Sequence[tuple[float, float]], errors: Errors, method: str = "superposition") -> Array:
    return np.array([coefficients(errors(*point), method) for point in points])


def _against(
    x: Sequence[float],
    points: Sequence[tuple[float, float]],
    published: tuple[Sequence[float], Sequence[float]],
    title: str,
    label: str,
) -> go.Figure:
    """B_p and B_m over an amplitude: bands of random phases, readings exact and by superposition, published points."""
    drawn = panels(title, [f"{symbol}, {stage} stage" for symbol, stage in zip(SYMBOLS, STAGES, strict=True)],
                   height=520, columns=2, horizontal_spacing=0.1)  # fmt: skip
    cloud = np.array([_over(points, drawn_at_random(seed)) for seed in range(DRAWS)])
    curves = {
        (name, method): _over(points, errors, method)
        for name, errors in READINGS.items()
        for method in ("superposition", "steady")
    }
    for at in range(2):
        low, high = cloud[:, :, at].min(axis=0), cloud[:, :, at].max(axis=0)
        shown = {"row": 1, "col": at + 1}
        band = {"x": [*x, *x[::-1]], "y": [*low.round(4), *high[::-1].round(4)], "fill": "toself", "mode": "lines"}
        look = {
            "line": {"width": 0},
            "fillcolor": translucent(PALE, 0.18),
            "name": f"{DRAWS} random draws of all phases",
        }
        drawn.add_scatter(**band, **look, showlegend=at == 0, **shown)
        for (name, method), values in curves.items():
            colour = PALETTE[list(READINGS).index(name)]
            exact = method == "steady"
            line = {"color": colour, "width": 1.6 if exact else 2.4, "dash": "dot" if exact else "solid"}
            text = "dotted: exact" if exact else name
            legend = at == 0 and (not exact or name == next(iter(READINGS)))
            curve = {"x": x, "y": values[:, at].round(4), "line": line, "mode": "lines", "name": text}
            drawn.add_scatter(**curve, showlegend=legend, **shown)
        marks = {"x": x, "y": published[at], "mode": "markers", "marker": PUBLISHED, "name": "published"}
        drawn.add_scatter(**marks, showlegend=at == 0, **shown)
    drawn.update_xaxes(title_text=label)
    drawn.update_yaxes(title_text="cycle-peak coefficient [-]", col=1)
    return drawn.update_layout(legend={"orientation": "h", "x": 0, "y": -0.2, "yanchor": "top"}, margin={"b": 140})


def run_out() -> go.Figure:
    """B_p and B_m over the run-out, 8 um of mesh error; at 0 mesh errors alone."""
    title = "Run-out from 0 to 40 um, mesh errors 8 um: the phases that are not printed decide"
    points = [(value, 8.0) for value in RUN_OUT]
    return _against(RUN_OUT, points, BY_RUN_OUT, title, "run-out [um]")


def mesh() -> go.Figure:
    """B_p and B_m over the mesh error, 20 um of run-out; at 0 run-out alone."""
    title = "Mesh error from 0 to 16 um, run-out 20 um: B_p bends by the printed definition, in print it does not"
    points = [(20.0, value) for value in MESH]
    drawn = _against(MESH, points, BY_MESH, title, "mesh-frequency error [um]")
    return drawn.update_yaxes(range=[0.97, 2.0], row=1)


def power() -> go.Figure:
    """Power from input to output, by path."""
    check = epicyclic.check(DRIVE)
    flow = {
        str(name): float(value) * 1e-6 for name, value in zip(check.path.values, check.path_power.values, strict=True)
    }
    carrier, encased = flow["couplings.carrier-output"], flow["couplings.f2-output"]
    total = carrier + encased
    names = {
        f"input<br>{total:.2f} MW": "body",
        "differential stage<br>3 planets": "planet",
        f"ring and couplings g1, f1<br>{encased:.2f} MW, {100 * encased / total:.1f} %": "ring",
        "encased stage<br>5 stars": "planet",
        f"carrier<br>{carrier:.2f} MW, {100 * carrier / total:.1f} %": "carrier",
        f"output<br>{total:.2f} MW": "body",
    }
    ways = [(0, 1, total, "sun"), (1, 2, encased, "ring"), (2, 3, encased, "ring"), (1, 4, carrier, "carrier"),
            (3, 5, encased, "ring"), (4, 5, carrier, "carrier")]  # fmt: skip
    node = {
        "label": list(names),
        "color": [kind_colour(kind) for kind in names.values()],
        "x": [0.01, 0.22, 0.45, 0.7, 0.55, 0.98],
        "y": [0.45, 0.45, 0.3, 0.3, 0.85, 0.45],
        "pad": 30,
        "thickness": 16,
        "line": {"width": 0},
    }
    link = {
        "source": [way[0] for way in ways],
        "target": [way[1] for way in ways],
        "value": [round(way[2], 5) for way in ways],
        "color": [translucent(kind_colour(way[3]), 0.35) for way in ways],
    }
    drawn = figure("Both paths carry power forward: nothing circulates", height=420)
    drawn.add_trace(go.Sankey(node=node, link=link, arrangement="fixed", textfont={"size": 13}))
    drawn.update_xaxes(visible=False).update_yaxes(visible=False)
    return drawn.update_layout(margin={"l": 30, "r": 30, "t": 60, "b": 40})


def _loads() -> xr.Dataset:
    """Forces of the drive as its file has it, 300 mesh cycles of the differential stage."""
    return epicyclic.sharing(DRIVE, cycles=300, stored_cycles=300, samples=32)


def _peaks(result: xr.Dataset, stage: str, frequency: float) -> tuple[Array, Array]:
    """Time [s] and N P_i / sum P of every mesh cycle of the sun meshes, (N, cycles)."""
    names = [f"{stage}/sun-planet/{branch}/left" for branch in range(1, STAGES[stage] + 1)]
    force = result.mesh_force.sel(mesh=names).transpose("mesh", "time").values
    cycle = np.floor(result.time.values * frequency + 1e-9).astype(int)
    whole = [np.flatnonzero(cycle == at) for at in range(int(cycle[-1]))]
    peaks = np.array([force[:, mine].max(axis=1) for mine in whole]).T
    return (np.arange(len(whole)) + 0.5) / frequency, len(names) * peaks / peaks.sum(axis=0)


def history() -> go.Figure:
    """Share of every planet and star in each mesh cycle, over time; and forces over four mesh cycles."""
    result, check = _loads(), epicyclic.check(DRIVE)
    tone = dict(zip(check.stage.values.tolist(), check.mesh_frequency.values.tolist(), strict=True))
    title = "Errors of the model file: load of the planets at mesh frequency, of the stars at 14 Hz"
    names = ["forces of the sun meshes, left helix, differential stage", "share of each planet in each mesh cycle",
             "share of each star in each mesh cycle"]  # fmt: skip
    drawn = panels(title, names, height=780, vertical_spacing=0.13)
    few = result.isel(time=slice(0, 6 * 32))
    for branch in range(1, 4):
        force = few.mesh_force.sel(mesh=f"differential/sun-planet/{branch}/left").values * 1e-3
        line = {"color": branch_colour(branch), "width": 2}
        time = (few.time.values * 1e3).round(5)
        drawn.add_scatter(x=time, y=force.round(3), line=line, mode="lines", showlegend=False, row=1, col=1)
    for row, stage in enumerate(STAGES, start=2):
        time, shares = _peaks(result, stage, tone[stage])
        for branch, values in enumerate(shares, start=1):
            line = {"color": branch_colour(branch), "width": 1.6, "shape": "hvh"}
            text = {"name": f"planet or star {branch}", "showlegend": row == 3}
            curve = {"x": (time * 1e3).round(4), "y": values.round(5), "line": line, "mode": "lines"}
            drawn.add_scatter(**curve, **text, row=row, col=1)
    drawn.update_xaxes(title_text="time [ms]")
    drawn.update_yaxes(title_text="force [kN]", range=[-480, 540], row=1)
    for row in (2, 3):
        drawn.update_yaxes(title_text="b [-]", row=row)
    note(drawn, "below 0 the linear model pulls", x=0.995, y=0.03, xref="x domain", yref="y domain", xanchor="right")
    return drawn


FIGURES: dict[str, Callable[[], go.Figure]] = {"run-out": run_out, "mesh": mesh, "power": power, "history": history}

if __name__ == "__main__":
    for case, found in draws().items():
        (p_low, m_low), (p_high, m_high) = np.quantile(found, (0.1, 0.9), axis=0)
        print(f"{case}, 10 to 90 %: B_p {p_low:.2f} to {p_high:.2f}, B_m {m_low:.2f} to {m_high:.2f};", end=" ")
        print(f"B_p is the larger in {np.sum(found[:, 0] > found[:, 1])} of {len(found)}")
