"""Loaded teeth: transmission error, load over flank and face, stress in the roots, sliding and losses, relief.

Of one pair the error over mesh cycle and load (Harris map), the stiffness of the contact, the load over the flank with
the contact lines of one instant and the stress along the path of contact; of a train the load along the faces of all
meshes, and K_gamma and K_Hbeta over the torque.  Of relief its search, as the Pareto set or the objective over the
generations, and transmission error, load and dynamic force before and after it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import (
    READ_IN,
    Array,
    by_pair_and_side,
    engineering,
    losses_of_pairs,
    numbers,
    pair_names,
    short_names,
    texts,
)
from .renderers import (
    DASHES,
    FROM_ZERO,
    INK,
    PALE,
    PALETTE,
    Bars,
    Curve,
    Heat,
    Layer,
    Mark,
    Panel,
    Trace,
    chart,
    cycled,
    level_bars,
    points,
    tint,
)

# Lowest load pale, highest dark, even in lightness, for the colour-blind too.
_LOAD_COLOURS = [[0.0, "#FFF7EC"], [0.25, "#FDD8A8"], [0.5, "#E8924A"], [0.75, "#B4531A"], [1.0, "#4A1D05"]]
# Compression blue, tension red, none white.
_STRESS_COLOURS = [[0.0, "#2166AC"], [0.5, "#FFFFFF"], [1.0, "#B2182B"]]
# Specific sliding beyond this is near a base tangent point, where it has no bound: the curve leaves the panel there.
_STEEPEST = 3.0


def contact_curves(result: xr.Dataset) -> go.Figure:
    """Loaded transmission error [um] over the mesh cycle, its peak to peak over load (Harris map), stiffness [N/um].

    Parameters
    ----------
    result : Dataset of `contact` of a mesh: loaded_transmission_error (torque_factor, mesh_phase) [m],
        transmission_error_peak_to_peak, mesh_load (torque_factor) [m, N], transmission_error_harmonic (torque_factor,
        harmonic) [m], tangent_stiffness, secant_stiffness (torque_factor, mesh, mesh_phase) [N/m]; attribute force [N],
        the operating load.
    """
    force, levels = float(result.attrs["force"]), result["mesh_load"].values
    over_load = {"peak to peak": result["transmission_error_peak_to_peak"].values}
    over_load |= {f"order {k}": np.abs(result["transmission_error_harmonic"].values[:, k]) for k in (1, 2, 3)}
    curves: list[Layer] = [Mark(x=force / 1e3, colour=PALETTE[1], dash="dot")]
    for i, (name, values) in enumerate(over_load.items()):
        look: Trace = {"colour": PALETTE[i - 1], "width": 1.5} if i else {"colour": INK, "width": 2}
        curves.append(Curve(levels / 1e3, values * 1e6, name=name, points=6, dash=DASHES[i], **look))
    titles = (
        "loaded transmission error less its mean (Harris map): darker, more load",
        "peak to peak and mesh orders over the load",
        "stiffness of one helix over the mesh cycle at the operating load",
    )
    errors, stiffness = _errors(result, force, levels), _stiffness(result, int(np.argmin(np.abs(levels - force))))
    cycle: Trace = {"x": "time [mesh cycles]", "x_ends": (0, 1)}
    return chart(
        f"Teeth in contact, {result.attrs['mesh']}",
        Panel(errors, title=titles[0], y="error [µm]", **cycle),
        Panel(curves, title=titles[1], x="mesh force of one helix [kN]", y="error [µm]", y_axis=FROM_ZERO),
        Panel(stiffness, title=titles[2], y="stiffness [N/µm]", **cycle),
        height=1020,
        gap=0.1,
    )


def _errors(result: xr.Dataset, force: float, levels: Array) -> list[Curve]:
    """Transmission error over the mesh cycle at every load (torque_factor,) [N], the darker the more."""
    from scipy.integrate import trapezoid

    phase, curves = np.append(result["mesh_phase"].values, 1.0), []
    for i, load in enumerate(levels):
        error = _closed(result["loaded_transmission_error"].values[i] * 1e6)
        now = bool(np.isclose(load, force))
        colour = PALETTE[1] if now else tint(INK, 0.85 * (1 - (i + 1) / len(levels)))
        name = f"{engineering(load / 1e3)} kN" + (", operation" if now else "")
        error = error - trapezoid(error, phase)
        curves.append(Curve(phase, error, name=name, colour=colour, width=2.6 if now else 1.3))
    return curves


def _stiffness(result: xr.Dataset, now: int) -> list[Curve]:
    """Tangent and secant stiffness over the mesh cycle at one load; of helices that are alike once."""
    phase = np.append(result["mesh_phase"].values, 1.0)
    values = result["tangent_stiffness"].values[now]
    alike = len(values) == 1 or bool(np.allclose(values[0], values[1], rtol=1e-4))
    sides = ["both helices" if len(values) > 1 else "helix"] if alike else texts(result, "side")
    curves = []
    for i, side in enumerate(sides):
        for kind, dash in (("tangent", "solid"), ("secant", "dash")):
            values = _closed(result[f"{kind}_stiffness"].values[now, i] / 1e6)
            curves.append(Curve(phase, values, name=f"{kind}, {side}", dash=dash, colour=PALETTE[i]))
    return curves


def _closed(values: Array) -> Array:
    """Values (..., k) over a mesh cycle with the first at its end once more."""
    return np.append(values, values[..., :1], axis=-1)


def _flank(result: xr.Dataset, side: int, place: Array, values: Array, unit: str, **look: Any) -> Heat:
    """Values (width, place) over the face [mm] and the path of contact [base pitches]; look: of the scale."""
    hover = f"%{{x:.4g}} mm from the left end<br>path %{{y:.3f}}<br>%{{z:.4g}} {unit}"
    bar = {"title": {"text": unit}, "thickness": 14, **look.pop("colorbar", {})}
    return Heat(_face(result, side), place, values.T, hover=hover, look={**look, "colorbar": bar})


def _face(result: xr.Dataset, side: int) -> Array:
    """Places along the face of a helix [mm]."""
    return np.asarray(result["width"].values * float(result["shared_face"].values[side]) * 1e3)


def contact_map(result: xr.Dataset) -> go.Figure:
    """Load per length [N/mm] over the flank of one tooth, a panel a helix, with the contact lines of one instant.

    Abscissa: place along the face [mm]; ordinate: path of contact from the pitch point [base pitches].

    Parameters
    ----------
    result : Dataset of `contact` of a mesh: flank_load_per_length (mesh, width, flank_place) [N/m], path_place (mesh,
        flank_place) [base pitches], width (width) [1], side (mesh), shared_face (mesh) [m], line_place (mesh, ...,
        width) [base pitches]; attributes force [N], mesh, gear_a, gear_b.
    """
    sides = texts(result, "side")
    load = result["flank_load_per_length"].transpose("mesh", "width", "flank_place").values / 1e3
    places = result["path_place"].values
    scale = {"zmin": 0.0, "zmax": float(np.nanmax(load)), "colorscale": _LOAD_COLOURS}
    line: Trace = {"colour": "#D55E00", "width": 1.6, "hover": None}
    shown = []
    for i, side in enumerate(sides):
        lines = [Curve(_face(result, i), places, **line) for places in result["line_place"].values[i]]
        heat = _flank(result, i, places[i], load[i], "N/mm", **scale, showscale=i == len(sides) - 1)
        title = f"{side}: largest {engineering(float(np.nanmax(load[i])))} N/mm"
        shown.append(Panel([heat, *lines], title=title, x="along the face from the left end [mm]"))
    first, second = str(result.attrs["gear_a"]), str(result.attrs["gear_b"])
    path = f"path of contact [base pitches]<br>tip of {second} below, of {first} above"
    force = engineering(float(result.attrs["force"]) / 1e3)
    title = f"Load over the flank, {result.attrs['mesh']}, {force} kN a helix; orange: contact lines at one instant"
    return chart(title, *shown, y=path, height=460, columns=len(sides), gap=0.05)


def root_stress(result: xr.Dataset) -> go.Figure:
    """Stress in the roots [MPa] over the place of a tooth on the path of contact, and a panel a gear and helix of it
    over the face.

    Upper panel: largest over the face, below the loaded flank (tension) and below the far flank (compression, dashed).

    Parameters
    ----------
    result : Dataset of `contact` of a mesh: root_stress, far_root_stress (mesh, mesh_gear, width, tooth_place) [Pa],
        tooth_place [base pitches], side (mesh), shared_face (mesh) [m]; attributes mesh, gear_a, gear_b.
    """
    sides, gears = texts(result, "side"), [str(result.attrs[f"gear_{one}"]) for one in texts(result, "mesh_gear")]
    panel = [(i, j) for i in range(len(sides)) for j in range(len(gears))]
    over = ("mesh", "mesh_gear", "width", "tooth_place")
    tension = result["root_stress"].transpose(*over).values / 1e6
    compression = result["far_root_stress"].transpose(*over).values / 1e6
    place, most = result["tooth_place"].values, float(np.abs(tension).max())
    scale = {"zmin": -most, "zmax": most, "colorscale": _STRESS_COLOURS, "colorbar": {"len": 0.38, "y": 0.18}}
    curves, maps = [], []
    for number, (i, j) in enumerate(panel):
        look: Trace = {"name": f"{gears[j]}, {sides[i]}", "colour": PALETTE[number % len(PALETTE)]}
        curves.append(Curve(place, tension[i, j].max(axis=0), **look))
        curves.append(Curve(place, compression[i, j].min(axis=0), dash="dash", **look))
        heat = _flank(result, i, place, tension[i, j], "MPa", **scale, showscale=number == len(panel) - 1)
        # two lines: four panels stand side by side on a page of 900 px
        title = f"{gears[j]}, {sides[i]}<br>up to {engineering(float(tension[i, j].max()))} MPa"
        words = "" if number else "place of the tooth [base pitches]"
        maps.append(Panel([heat], title=title, x="along the face [mm]", y=words))
    title = "largest over the face; dashed: compression below the far flank"
    largest = Panel(curves, title=title, x="place of the tooth on the path of contact [base pitches]", y="stress [MPa]")
    specs = [[{"colspan": len(panel)}, *[None] * (len(panel) - 1)], [{} for _ in panel]]
    layout: Trace = {"columns": len(panel), "gap": 0.05, "space": {"specs": specs, "vertical_spacing": 0.16}}
    return chart(f"Stress in the tooth roots, {result.attrs['mesh']}", largest, *maps, height=760, **layout)


def face_loads(result: xr.Dataset) -> go.Figure:
    """Load per face width [N/mm] along the faces at the operating torque, a panel a pair and side, a curve a branch.

    Parameters
    ----------
    result : Dataset of `contact` of a train: face_load (torque_factor, mesh, width) [N/m], face_load_factor
        (torque_factor, mesh) [1], width (width) [1].
    """
    now = int(np.argmin(np.abs(result["torque_factor"].values - 1.0)))
    groups = by_pair_and_side(texts(result, "mesh"))
    columns = 2 if any(side for _, side in groups) else 1
    factor = result["face_load_factor"].values[now]
    width, load = result["width"].values, result["face_load"].values[now] / 1e3
    shown = []
    for (pair, side), meshes in groups.items():
        names = [f"branch {i + 1}" for i in range(len(meshes))] if len(meshes) > 1 else ["mesh"]
        curves = [Curve(width, load[mesh], name=names[i], **cycled(i, 1)) for i, mesh in enumerate(meshes)]
        title = f"{pair} {side}".strip() + f": K<sub>Hβ</sub> up to {engineering(float(factor[meshes].max()))}"
        axes: Trace = {"x": "place along the face, left to right [1]", "x_ends": (0, 1), "y_axis": FROM_ZERO}
        shown.append(Panel(curves, title=title, **axes))
    rows = -(-len(groups) // columns)
    layout: Trace = {"columns": columns, "height": 120 + 300 * rows, "space": {"vertical_spacing": 0.28 / rows}}
    return chart("Load along the faces, mean over the record", *shown, y="load per width [N/mm]", **layout)


def load_factors(result: xr.Dataset) -> go.Figure:
    """K_gamma of every pair and the largest K_Hbeta of every pair and side [1] over the relative torque [1].

    Parameters
    ----------
    result : Dataset of `contact` of a train: branch_load_factor (torque_factor, mesh_pair), face_load_factor
        (torque_factor, mesh) [1].
    """
    torque, factor = result["torque_factor"].values, result["face_load_factor"].values
    between = pair_names(texts(result, "mesh_pair"))
    sides = by_pair_and_side(texts(result, "mesh"))
    curves = [*result["branch_load_factor"].values.T, *(factor[:, meshes].max(axis=1) for meshes in sides.values())]
    names = [*between, *(f"{pair} {side}".strip() for pair, side in sides)]
    named = enumerate(zip(names, curves, strict=True))
    layers = [Curve(torque, curve, name=name, points=6, **cycled(i, 1)) for i, (name, curve) in named]
    axes: Trace = {"x": "torque per operating torque [1]", "y": "factor [1]", "x_axis": FROM_ZERO}
    return chart(
        "Load factors over the torque",
        Panel(layers[: len(between)], "between branches, K<sub>γ</sub>", **axes),
        Panel(layers[len(between) :], "along the face, K<sub>Hβ</sub>, largest of the branches", **axes),
        height=620,
        gap=0.16,
    )


def sliding(result: xr.Dataset) -> go.Figure:
    """Sliding speed [m/s], specific sliding [1] and load [1] of every pair over the path of contact [base pitches].

    Parameters
    ----------
    result : Dataset of `efficiency`: contact_place, sliding_speed, specific_sliding_a, specific_sliding_b, path_load
        (mesh_pair, flank_place).
    """
    specific = ("specific_sliding_a", "specific_sliding_b")
    least = min(float(np.nanmin(_within(result[name].values))) for name in specific)

    def curves(variable: str, dash: str = "") -> list[Curve]:
        values = _within(result[variable].values) if dash else result[variable].values
        rows = zip(result["contact_place"].values, values, pair_names(texts(result, "mesh_pair")), strict=True)
        look = {"dash": dash} if dash else {}
        return [Curve(place, row, name=name, **{**cycled(i), **look}) for i, (place, row, name) in enumerate(rows)]

    both = [*curves(specific[0], "solid"), *curves(specific[1], "dot")]
    ends = (1.1 * max(least, -_STEEPEST), 1.2)
    title = "specific sliding of the first gear; of the second, dotted"
    return chart(
        "Sliding and load along the path of contact",
        Panel(curves("sliding_speed"), "sliding speed, first gear less second", y="sliding speed [m/s]"),
        Panel(both, title, y="specific sliding [1]", y_ends=ends),
        Panel(curves("path_load"), "mesh force per base pitch and mesh force", y="load [1]", y_axis=FROM_ZERO),
        x="place from the pitch point [base pitches]",
        height=820,
        gap=0.07,
    )


def _within(values: Array) -> Array:
    """Specific sliding [1] of any shape, nan far outside the panel."""
    return np.where(np.abs(values) <= 2 * _STEEPEST, values, np.nan)


def mesh_losses(result: xr.Dataset) -> go.Figure:
    """Power lost in all meshes of each pair [W or kW], with its share of the power into the train [%].

    Parameters
    ----------
    result : Dataset of `efficiency`: mesh_power_loss (mesh) [W], power_in () [W].
    """
    rows = losses_of_pairs(texts(result, "mesh"), numbers(result, "mesh_power_loss"))
    kilo = max((loss for _, _, loss in rows), default=0.0) >= 1e4
    factor, unit = (1e-3, "kW") if kilo else (1.0, "W")
    into = float(result["power_in"])
    stages = list(dict.fromkeys(stage for stage, _, _ in rows))
    rows = rows[::-1]
    losses = [float(loss * factor) for _, _, loss in rows]
    names = [f"{stage} {pair}" if len(stages) > 1 else pair for stage, pair, _ in rows]
    colours = [PALETTE[stages.index(stage) % len(PALETTE)] for stage, _, _ in rows]
    text = [f"{engineering(loss * factor)} {unit}, {engineering(100 * loss / into, 3)} %" for _, _, loss in rows]
    hover = "%{y}: %{text} of the power into the train"
    bars = Bars(names, losses, level=True, colour=colours, text=text, hover=hover)
    title = "Power lost in the meshes, all branches and sides"
    return level_bars(title, names[::-1], Panel([bars], x=f"power loss [{unit}]"), row=38, room=0.35)


# what objectives are drawn in: factor from SI, unit
_READ = {unit: (factor, words.replace("um", "µm")) for unit, (factor, words) in READ_IN.items()}
_NAMES = {
    "lte": "peak to peak of the transmission error",
    "load": "largest load per length",
    "force_rms": "RMS of the dynamic mesh force",
    "force_peak": "largest mesh force",
}
_ERROR = "loaded transmission error less its mean, operating load"
_HARRIS = "its peak to peak over the load (Harris map)"
_ALONG = "largest load per length along the path of contact, operating load"
_RMS = "RMS of the dynamic mesh force, largest of the meshes looked at"
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
    """Two objectives of all candidates, the Pareto set, the drawing and the answer."""
    count = result.sizes["solution"]
    title = f"{count} solutions that no other beats, of {result.sizes['evaluation']} candidates"
    x, y = (_scaled(result, "evaluated_objective", at) for at in (0, 1))
    kept = slice(None, None, max(1, len(x) // _CLOUD))
    generation = result["evaluated_generation"].values[kept]
    dots = {"color": generation, "colorscale": [[0, "#E3E7EB"], [1, "#66727F"]], "showscale": False}
    cloud = points(x[kept], y[kept], 4, name="candidates, later ones darker", hover=None, look={"marker": dots})
    front = [_scaled(result, "solution_objective", at) for at in (0, 1)]
    names = texts(result, "variable")
    words = [
        f"solution {i}<br>" + "<br>".join(f"{name}: {value}" for name, value in zip(names, row, strict=True))
        for i, row in enumerate(result["solution_text"].values)
    ]
    look: Trace = {"colour": PALETTE[0], "width": 1.6 if result.sizes["objective"] == 2 else 0, "shape": "hv"}
    look |= {"points": 8, "text": words, "hover": "%{text}<br>%{x:.4g}, %{y:.4g}"}
    solutions = Curve(front[0], front[1], name="Pareto set", **look)
    picked = int(result.attrs["picked"])
    before = [float(_scaled(result, "objective_before", at)) for at in (0, 1)]
    drawn = points(before[:1], before[1:], 12, name="as drawn", symbol="x", colour=INK, digits=(9, 9))
    star: Trace = {"symbol": "star", "colour": _AFTER, "digits": (9, 9)}
    chosen = points(front[0][[picked]], front[1][[picked]], 16, name="the answer", **star)
    # the Pareto set and what is drawn; poor candidates may lie far outside
    ends = []
    for values, at in zip(front, before, strict=True):
        low, high = min(float(values.min()), at), max(float(values.max()), at)
        room = 0.12 * (high - low) or 0.1 * abs(high) or 1.0
        ends.append((low - room, high + room))
    layers = [cloud, solutions, drawn, chosen]
    panel = Panel(layers, x=_title(result, 0), y=_title(result, 1), x_ends=ends[0], y_ends=ends[1])
    return chart(title, panel, height=540)


def _progress(result: xr.Dataset) -> go.Figure:
    """The objective of all candidates and its best, over the generations."""
    best = _scaled(result, "best_so_far", 0)
    answer = ", ".join(map(str, result["solution_text"].values[int(result.attrs["picked"])]))
    before, after = float(_scaled(result, "objective_before", 0)), float(_scaled(result, "objective_after", 0))
    unit = _READ[texts(result, "objective_unit")[0]][1]
    title = f"{engineering(before)} {unit} as drawn, {engineering(after)} {unit} with {answer}"
    x, y = result["evaluated_generation"].values, _scaled(result, "evaluated_objective", 0)
    kept = slice(None, None, max(1, len(x) // _CLOUD))
    candidates = points(x[kept], y[kept], 3, name="candidates", colour=tint(PALETTE[0], 0.55))
    steps = Curve(range(len(best)), best, name="best so far", colour=_AFTER, width=2.4, shape="hv")
    layers = [candidates, steps, Mark(y=before, dash="dash")]
    ends = (0, 1.6 * max(before, float(best.max())))
    return chart(title, Panel(layers, x="generation", y=_title(result, 0), y_ends=ends))


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
    meshes = short_names(texts(result, "relieved_mesh"))
    factors = result["load_factor"].values
    now = int(np.argmin(np.abs(factors - 1.0)))
    error = result["relieved_error"].values[:, :, now] * 1e6
    phase = np.append(result["mesh_phase"].values, 1.0)
    errors, harris, along = list[Layer](), list[Layer](), list[Layer]()
    for j, mesh in enumerate(meshes):
        errors += _states(phase, _closed(error[:, j] - error[:, j].mean(axis=1, keepdims=True)), mesh, j)
        load = factors * float(result["relieved_force"].values[j]) / 1e3
        harris += _states(load, result["relieved_peak_to_peak"].values[:, j] * 1e6, mesh, j)
        harris += [Mark(x=load[now], width=1, dash="dot")]
        along += _states(result["relieved_place"].values[j], result["relieved_load"].values[:, j] / 1e3, mesh, j)
    shown = [Panel(errors, _ERROR, x="time [mesh cycles]", y="error [µm]")]
    shown.append(Panel(harris, _HARRIS, x="mesh force of one helix [kN]", y="error [µm]", y_axis=FROM_ZERO))
    x = "path of contact from the pitch point [base pitches]"
    shown.append(Panel(along, _ALONG, x=x, y="load per length [N/mm]", y_axis=FROM_ZERO))
    if "mesh_force_rms" in result:
        forces = _states(result["speed"].values, result["mesh_force_rms"].values, "", 0)
        x = "speed relative to the operating one [1]"
        shown.append(Panel(forces, _RMS, x=x, y="force [N]", y_axis=FROM_ZERO))
    return chart("Before (grey) and after (orange) relief", *shown, height=330 * len(shown), gap=0.08)


def _states(x: Array, values: Array, mesh: str, number: int) -> list[Curve]:
    """Both states (2, k) of one mesh over x (k,): a colour for the state, a dash for the mesh."""
    curves = []
    for i, (state, colour) in enumerate((("before", _BEFORE), ("after", _AFTER))):
        look: Trace = {"colour": colour, "width": 1.6 + 0.8 * i, "dash": DASHES[number % len(DASHES)]}
        name = ", ".join(text for text in (mesh, state) if text)
        curves.append(Curve(x, values[i], name=name, key=bool(mesh), **look))
    return curves
