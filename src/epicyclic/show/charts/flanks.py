"""Loaded teeth: transmission error, load over flank and face, stress in the roots, sliding and losses, relief.

Of one pair the error over mesh cycle and load (Harris map), the stiffness of the contact, the load over the flank with
the contact lines of one instant and the stress along the path of contact; of a train the load along the faces of all
meshes, and K_gamma and K_Hbeta over the torque.  Of relief its search, as the Pareto set or the objective over the
generations, and transmission error, load and dynamic force before and after it.
"""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import (
    Array,
    by_pair_and_side,
    compact,
    engineering,
    losses_of_pairs,
    numbers,
    pair_title,
    short_names,
    texts,
)
from .style import DASHES, INK, PALE, PALETTE, figure, panels, tint

# Lowest load pale, highest dark, even in lightness, for the colour-blind too.
_LOAD_COLOURS = [[0.0, "#F4F8FB"], [0.25, "#B9D7EA"], [0.5, "#56A3D0"], [0.75, "#1F6FA8"], [1.0, "#0B2E4F"]]
# Compression blue, tension red, none white.
_STRESS_COLOURS = [[0.0, "#2166AC"], [0.5, "#FFFFFF"], [1.0, "#B2182B"]]
# Specific sliding beyond this is near a base tangent point, where it has no bound: the curve leaves the panel there.
_STEEPEST = 3.0


def contact_curves(result: xr.Dataset) -> go.Figure:
    """Loaded transmission error [um] over the mesh cycle, its peak to peak over load (Harris map), stiffness [N/um].

    Parameters
    ----------
    result : Dataset of `contact`: loaded_transmission_error (mesh_load, mesh_phase) [m],
        transmission_error_peak_to_peak (mesh_load) [m], transmission_error_harmonic (mesh_load, harmonic) [m],
        tangent_stiffness, secant_stiffness (side, mesh_load, mesh_phase) [N/m]; attribute force [N], the operating
        load.
    """
    names = [
        "loaded transmission error less its mean (Harris map): darker, more load",
        "peak to peak and mesh orders over the load",
        "stiffness of one helix over the mesh cycle at the operating load",
    ]
    drawn = panels(f"Teeth in contact, {result.attrs['mesh']}", names, height=1020, vertical_spacing=0.1)
    _errors(drawn, result)
    _over_load(drawn, result)
    _stiffness(drawn, result)
    return drawn


def _errors(drawn: go.Figure, result: xr.Dataset) -> None:
    from scipy.integrate import trapezoid

    force = float(result.attrs["force"])
    levels = result["mesh_load"].values
    phase = np.append(result["mesh_phase"].values, 1.0)
    for i, load in enumerate(levels):
        error = result["loaded_transmission_error"].values[i] * 1e6
        error = np.append(error, error[0])
        error = error - trapezoid(error, phase)
        now = bool(np.isclose(load, force))
        colour = PALETTE[1] if now else tint(INK, 0.85 * (1 - (i + 1) / len(levels)))
        name = f"{engineering(load / 1e3)} kN" + (", operation" if now else "")
        look = {"color": colour, "width": 2.6 if now else 1.3}
        drawn.add_trace(
            go.Scatter(x=compact(phase), y=compact(error), mode="lines", line=look, name=name), row=1, col=1
        )
    drawn.update_xaxes(title_text="time [mesh cycles]", range=[0, 1], row=1, col=1)
    drawn.update_yaxes(title_text="error [µm]", row=1, col=1)


def _over_load(drawn: go.Figure, result: xr.Dataset) -> None:
    load = compact(result["mesh_load"].values / 1e3)
    curves = {"peak to peak": result["transmission_error_peak_to_peak"].values}
    curves |= {f"order {k}": np.abs(result["transmission_error_harmonic"].values[:, k]) for k in (1, 2, 3)}
    for i, (name, values) in enumerate(curves.items()):
        look = {"color": INK if i == 0 else PALETTE[i - 1], "width": 2 if i == 0 else 1.5, "dash": DASHES[i]}
        drawn.add_trace(
            go.Scatter(x=load, y=compact(values * 1e6), mode="lines+markers", line=look, name=name), row=2, col=1
        )
    operating = float(result.attrs["force"]) / 1e3
    drawn.add_vline(x=operating, line={"color": PALETTE[1], "width": 1.2, "dash": "dot"}, row=2, col=1)
    drawn.update_xaxes(title_text="mesh force of one helix [kN]", row=2, col=1)
    drawn.update_yaxes(title_text="error [µm]", rangemode="tozero", row=2, col=1)


def _stiffness(drawn: go.Figure, result: xr.Dataset) -> None:
    now = int(np.argmin(np.abs(result["mesh_load"].values - float(result.attrs["force"]))))
    phase = compact(np.append(result["mesh_phase"].values, 1.0))
    values = result["tangent_stiffness"].values[:, now]
    alike = len(values) == 1 or bool(np.allclose(values[0], values[1], rtol=1e-4))
    sides = ["both helices" if len(values) > 1 else "helix"] if alike else texts(result, "side")
    for i, side in enumerate(sides):
        for kind, dash in (("tangent", "solid"), ("secant", "dash")):
            values = result[f"{kind}_stiffness"].values[i, now] / 1e6
            look = {"color": PALETTE[i], "width": 1.8, "dash": dash}
            closed = compact(np.append(values, values[0]))
            drawn.add_trace(
                go.Scatter(x=phase, y=closed, mode="lines", line=look, name=f"{kind}, {side}"), row=3, col=1
            )
    drawn.update_xaxes(title_text="time [mesh cycles]", range=[0, 1], row=3, col=1)
    drawn.update_yaxes(title_text="stiffness [N/µm]", row=3, col=1)


def contact_map(result: xr.Dataset) -> go.Figure:
    """Load per length [N/mm] over the flank of one tooth, a panel a helix, with the contact lines of one instant.

    Abscissa: place along the face [mm]; ordinate: path of contact from the pitch point [base pitches].

    Parameters
    ----------
    result : Dataset of `contact`: flank_load_per_length (side, width, path_place) [N/m], width (width) [1],
        shared_face (side) [m], line_place (side, ..., width) [base pitches]; attributes force [N], mesh, gear_a,
        gear_b.
    """
    sides = texts(result, "side")
    load = result["flank_load_per_length"].transpose("side", "width", "path_place").values / 1e3
    names = [f"{side}: largest {engineering(float(np.nanmax(load[i])))} N/mm" for i, side in enumerate(sides)]
    force = engineering(float(result.attrs["force"]) / 1e3)
    title = f"Load over the flank, {result.attrs['mesh']}, {force} kN a helix; orange: contact lines at one instant"
    drawn = panels(title, names, height=460, columns=len(sides), shared_yaxes=True, horizontal_spacing=0.05)
    top = float(np.nanmax(load))
    for i in range(len(sides)):
        face = result["width"].values * float(result["shared_face"].values[i]) * 1e3
        drawn.add_trace(
            go.Heatmap(
                x=compact(face),
                y=compact(result["path_place"].values),
                z=[compact(row, digits=4) for row in load[i].T],
                zmin=0.0,
                zmax=top,
                colorscale=_LOAD_COLOURS,
                showscale=i == len(sides) - 1,
                colorbar={"title": {"text": "N/mm"}, "thickness": 14},
                hovertemplate="%{x:.4g} mm from the left end<br>path %{y:.3f}<br>%{z:.4g} N/mm<extra></extra>",
            ),
            row=1,
            col=i + 1,
        )
        for line in result["line_place"].values[i]:
            look = {"color": "#D55E00", "width": 1.6}
            drawn.add_trace(
                go.Scatter(
                    x=compact(face), y=compact(line), mode="lines", line=look, showlegend=False, hoverinfo="skip"
                ),
                row=1,
                col=i + 1,
            )
        drawn.update_xaxes(title_text="along the face from the left end [mm]", row=1, col=i + 1)
    first, second = str(result.attrs["gear_a"]), str(result.attrs["gear_b"])
    drawn.update_yaxes(
        title_text=f"path of contact [base pitches]<br>tip of {second} below, of {first} above", row=1, col=1
    )
    return drawn


def root_stress(result: xr.Dataset) -> go.Figure:
    """Stress in the roots [MPa] over the place of a tooth on the path of contact, and a panel a gear and helix of it
    over the face.

    Upper panel: largest over the face, below the loaded flank (tension) and below the far flank (compression, dashed).

    Parameters
    ----------
    result : Dataset of `contact`: root_stress, far_root_stress (side, mesh_gear, width, tooth_place) [Pa], tooth_place
        [base pitches], shared_face (side) [m]; attributes mesh, gear_a, gear_b.
    """
    sides, gears = texts(result, "side"), [str(result.attrs[f"gear_{one}"]) for one in texts(result, "mesh_gear")]
    panel = [(i, j) for i in range(len(sides)) for j in range(len(gears))]
    over = ("side", "mesh_gear", "width", "tooth_place")
    tension = result["root_stress"].transpose(*over).values / 1e6
    compression = result["far_root_stress"].transpose(*over).values / 1e6
    # two lines: four panels stand side by side on a page of 900 px
    names = [f"{gears[j]}, {sides[i]}<br>up to {engineering(float(tension[i, j].max()))} MPa" for i, j in panel]
    drawn = panels(
        f"Stress in the tooth roots, {result.attrs['mesh']}",
        ["largest over the face; dashed: compression below the far flank", *names],
        height=760,
        specs=[[{"colspan": len(panel)}, *[None] * (len(panel) - 1)], [{} for _ in panel]],
        columns=len(panel),
        vertical_spacing=0.16,
        horizontal_spacing=0.05,
    )
    place, most = compact(result["tooth_place"].values), float(np.abs(tension).max())
    for number, (i, j) in enumerate(panel):
        look = {"color": PALETTE[number % len(PALETTE)], "width": 1.8}
        label = f"{gears[j]}, {sides[i]}"
        for values, dash in ((tension[i, j].max(axis=0), "solid"), (compression[i, j].min(axis=0), "dash")):
            line = {**look, "dash": dash}
            drawn.add_trace(
                go.Scatter(
                    **{"x": place, "y": compact(values), "mode": "lines", "line": line, "name": label},
                    **{"legendgroup": label, "showlegend": dash == "solid"},
                ),
                row=1,
                col=1,
            )
        drawn.add_trace(
            go.Heatmap(
                x=compact(result["width"].values * float(result["shared_face"].values[i]) * 1e3),
                y=place,
                z=[compact(row, digits=4) for row in tension[i, j].T],
                zmin=-most,
                zmax=most,
                colorscale=_STRESS_COLOURS,
                showscale=number == len(panel) - 1,
                colorbar={"title": {"text": "MPa"}, "thickness": 14, "len": 0.38, "y": 0.18},
                hovertemplate="%{x:.4g} mm from the left end<br>path %{y:.3f}<br>%{z:.4g} MPa<extra></extra>",
            ),
            row=2,
            col=number + 1,
        )
        drawn.update_xaxes(title_text="along the face [mm]", row=2, col=number + 1)
    drawn.update_xaxes(title_text="place of the tooth on the path of contact [base pitches]", row=1, col=1)
    drawn.update_yaxes(title_text="stress [MPa]", row=1, col=1)
    drawn.update_yaxes(title_text="place of the tooth [base pitches]", row=2, col=1)
    return drawn


def face_loads(result: xr.Dataset) -> go.Figure:
    """Load per face width [N/mm] along the faces at the operating torque, a panel a pair and side, a curve a branch.

    Parameters
    ----------
    result : Dataset of `train_contact`: face_load (torque_factor, mesh, width) [N/m], face_load_factor
        (torque_factor, mesh) [1], width (width) [1].
    """
    now = int(np.argmin(np.abs(result["torque_factor"].values - 1.0)))
    groups = by_pair_and_side(texts(result, "mesh"))
    columns = 2 if any(side for _, side in groups) else 1
    factor = result["face_load_factor"].values[now]
    names = [
        f"{pair} {side}".strip() + f": K<sub>Hβ</sub> up to {engineering(float(factor[meshes].max()))}"
        for (pair, side), meshes in groups.items()
    ]
    rows = -(-len(groups) // columns)
    drawn = panels(
        "Load along the faces, mean over the record",
        names,
        height=120 + 300 * rows,
        columns=columns,
        shared_yaxes=True,
        vertical_spacing=0.28 / rows,
    )
    width, load = result["width"].values, result["face_load"].values[now] / 1e3
    for place, meshes in enumerate(groups.values()):
        row, column = place // columns + 1, place % columns + 1
        for i, mesh in enumerate(meshes):
            line = {"color": PALETTE[i % len(PALETTE)], "width": 1.8, "dash": DASHES[i % len(DASHES)]}
            name = f"branch {i + 1}" if len(meshes) > 1 else "mesh"
            drawn.add_trace(
                go.Scatter(
                    x=compact(width),
                    y=compact(load[mesh]),
                    mode="lines",
                    line=line,
                    name=name,
                    legendgroup=name,
                    showlegend=place == 0,
                ),
                row=row,
                col=column,
            )
        drawn.update_xaxes(title_text="place along the face, left to right [1]", range=[0, 1], row=row, col=column)
        drawn.update_yaxes(rangemode="tozero", row=row, col=column)
        if column == 1:
            drawn.update_yaxes(title_text="load per width [N/mm]", row=row, col=column)
    return drawn


def load_factors(result: xr.Dataset) -> go.Figure:
    """K_gamma of every pair and the largest K_Hbeta of every pair and side [1] over the relative torque [1].

    Parameters
    ----------
    result : Dataset of `train_contact`: branch_load_factor (torque_factor, mesh_pair), face_load_factor
        (torque_factor, mesh) [1].
    """
    drawn = panels(
        "Load factors over the torque",
        ["between branches, K<sub>γ</sub>", "along the face, K<sub>Hβ</sub>, largest of the branches"],
        height=620,
        vertical_spacing=0.16,
    )
    torque = compact(result["torque_factor"].values)
    curves = [
        (1, str(pair).split(".")[-1], result["branch_load_factor"].values[:, i])
        for i, pair in enumerate(result["mesh_pair"].values)
    ]
    factor = result["face_load_factor"].values
    curves += [
        (2, f"{pair} {side}".strip(), factor[:, meshes].max(axis=1))
        for (pair, side), meshes in by_pair_and_side(texts(result, "mesh")).items()
    ]
    for i, (row, name, values) in enumerate(curves):
        line = {"color": PALETTE[i % len(PALETTE)], "width": 1.8, "dash": DASHES[i % len(DASHES)]}
        drawn.add_trace(
            go.Scatter(x=torque, y=compact(values), mode="lines+markers", line=line, name=name), row=row, col=1
        )
    for row in (1, 2):
        drawn.update_xaxes(title_text="torque per operating torque [1]", rangemode="tozero", row=row, col=1)
        drawn.update_yaxes(title_text="factor [1]", row=row, col=1)
    return drawn


def sliding(result: xr.Dataset) -> go.Figure:
    """Sliding speed [m/s], specific sliding [1] and load [1] of every pair over the path of contact [base pitches].

    Parameters
    ----------
    result : Dataset of `efficiency`: contact_place, sliding_speed, specific_sliding_a, specific_sliding_b, path_load
        (mesh_pair, flank_place).
    """
    names = [str(name).split(".") for name in result["mesh_pair"].values]  # stages.main.meshes.sun-planet
    several = len({parts[1] for parts in names}) > 1
    drawn = panels(
        "Sliding and load along the path of contact",
        [
            "sliding speed, first gear less second",
            "specific sliding of the first gear; of the second, dotted",
            "mesh force per base pitch and mesh force",
        ],
        height=820,
        shared_xaxes=True,
        vertical_spacing=0.07,
    )
    place = result["contact_place"].values
    rows = [(1, "sliding_speed", "solid"), (2, "specific_sliding_a", "solid"), (2, "specific_sliding_b", "dot")]
    for row, variable, dash in [*rows, (3, "path_load", "solid")]:
        values = result[variable].values
        for i, parts in enumerate(names):
            line = {"color": PALETTE[i % len(PALETTE)], "width": 1.8}
            name = pair_title((parts[1], parts[-1]), several)
            drawn.add_trace(
                go.Scatter(
                    x=compact(place[i]),
                    y=compact(_within(values[i]) if row == 2 else values[i]),
                    mode="lines",
                    line={**line, "dash": dash if row == 2 else DASHES[i // len(PALETTE) % len(DASHES)]},
                    name=name,
                    legendgroup=name,
                    showlegend=row == 1,
                ),
                row=row,
                col=1,
            )
    for row, title in enumerate(("sliding speed [m/s]", "specific sliding [1]", "load [1]"), start=1):
        drawn.update_yaxes(title_text=title, row=row, col=1)
    least = min(float(np.nanmin(_within(result[name].values))) for name in ("specific_sliding_a", "specific_sliding_b"))
    drawn.update_yaxes(range=[1.1 * max(least, -_STEEPEST), 1.2], row=2, col=1)
    drawn.update_yaxes(rangemode="tozero", row=3, col=1)
    drawn.update_xaxes(title_text="place from the pitch point [base pitches]", row=3, col=1)
    return drawn


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
    drawn = figure(
        "Power lost in the meshes, all branches and sides", x=f"power loss [{unit}]", height=150 + 38 * len(rows)
    )
    labels = [f"{stage} {pair}" if len(stages) > 1 else pair for stage, pair, _ in rows]
    losses = [loss for _, _, loss in rows]
    drawn.add_trace(
        go.Bar(
            x=[float(loss * factor) for loss in losses][::-1],
            y=labels[::-1],
            orientation="h",
            marker={"color": [PALETTE[stages.index(stage) % len(PALETTE)] for stage, _, _ in rows][::-1]},
            text=[f"{engineering(loss * factor)} {unit}, {engineering(100 * loss / into, 3)} %" for loss in losses][
                ::-1
            ],
            textposition="outside",
            cliponaxis=False,
            hovertemplate="%{y}: %{text} of the power into the train<extra></extra>",
        )
    )
    # room for the numbers outside the bars
    drawn.update_xaxes(range=[0.0, 1.35 * factor * max(losses, default=0.0) or 1.0])
    drawn.update_yaxes(showgrid=False)
    drawn.update_layout(bargap=0.35)
    return drawn


# what objectives are drawn in: factor from SI, unit
_READ = {"m": (1e6, "µm"), "N/m": (1e-3, "N/mm"), "N": (1.0, "N")}
_NAMES = {
    "lte": "peak to peak of the transmission error",
    "load": "largest load per length",
    "force_rms": "RMS of the dynamic mesh force",
    "force_peak": "largest mesh force",
}
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
    count = result.sizes["solution"]
    title = f"{count} solutions that no other beats, of {result.sizes['evaluation']} candidates"
    drawn = figure(title, x=_title(result, 0), y=_title(result, 1), height=540)
    x, y = (_scaled(result, "evaluated_objective", at) for at in (0, 1))
    kept = slice(None, None, max(1, len(x) // _CLOUD))
    generation = result["evaluated_generation"].values[kept]
    look = {"size": 4, "color": generation, "colorscale": [[0, "#E3E7EB"], [1, "#66727F"]], "showscale": False}
    cloud = {"mode": "markers", "marker": look, "name": "candidates, later ones darker", "hoverinfo": "skip"}
    drawn.add_trace(go.Scatter(x=compact(x[kept]), y=compact(y[kept]), **cloud))
    front = [_scaled(result, "solution_objective", at) for at in (0, 1)]
    names = texts(result, "variable")
    words = [
        f"solution {i}<br>" + "<br>".join(f"{name}: {value}" for name, value in zip(names, row, strict=True))
        for i, row in enumerate(result["solution_text"].values)
    ]
    line = {"color": PALETTE[0], "width": 1.6, "shape": "hv"}
    drawn.add_trace(
        go.Scatter(
            **{"x": compact(front[0]), "y": compact(front[1]), "mode": "lines+markers", "name": "Pareto set"},
            **{"line": line if result.sizes["objective"] == 2 else {**line, "width": 0}},
            **{"marker": {"color": PALETTE[0], "size": 8}, "text": words},
            hovertemplate="%{text}<br>%{x:.4g}, %{y:.4g}<extra></extra>",
        )
    )
    picked = int(result.attrs["picked"])
    before = [float(_scaled(result, "objective_before", at)) for at in (0, 1)]
    for name, place, look in (
        ("as drawn", before, {"symbol": "x", "size": 12, "color": INK}),
        ("the answer", [front[0][picked], front[1][picked]], {"symbol": "star", "size": 16, "color": _AFTER}),
    ):
        drawn.add_trace(go.Scatter(x=[place[0]], y=[place[1]], mode="markers", marker=look, name=name))
    _view(drawn, front, before)
    return drawn


def _view(drawn: go.Figure, front: list[Array], before: list[float]) -> None:
    """Show the Pareto set (solutions,) of two objectives and what is drawn; poor candidates may lie far outside."""
    for values, at, update in zip(front, before, (drawn.update_xaxes, drawn.update_yaxes), strict=True):
        low, high = min(float(values.min()), at), max(float(values.max()), at)
        room = 0.12 * (high - low) or 0.1 * abs(high) or 1.0
        update(range=[low - room, high + room])


def _progress(result: xr.Dataset) -> go.Figure:
    best = _scaled(result, "best_so_far", 0)
    picked = int(result.attrs["picked"])
    found = ", ".join(map(str, result["solution_text"].values[picked]))
    before, after = float(_scaled(result, "objective_before", 0)), float(_scaled(result, "objective_after", 0))
    unit = _READ[texts(result, "objective_unit")[0]][1]
    title = f"{engineering(before)} {unit} as drawn, {engineering(after)} {unit} with {found}"
    drawn = figure(title, x="generation", y=_title(result, 0), height=420)
    x, y = result["evaluated_generation"].values, _scaled(result, "evaluated_objective", 0)
    kept = slice(None, None, max(1, len(x) // _CLOUD))
    dots = {"size": 3, "color": tint(PALETTE[0], 0.55)}
    drawn.add_trace(go.Scatter(x=compact(x[kept]), y=compact(y[kept]), mode="markers", marker=dots, name="candidates"))
    line = {"color": _AFTER, "width": 2.4, "shape": "hv"}
    drawn.add_trace(go.Scatter(x=list(range(len(best))), y=compact(best), mode="lines", line=line, name="best so far"))
    drawn.add_hline(y=before, line={"color": INK, "width": 1.2, "dash": "dash"})
    top = max(before, float(best.max()))
    return drawn.update_yaxes(range=[0, 1.6 * top])


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
    names = [
        "loaded transmission error less its mean, operating load",
        "its peak to peak over the load (Harris map)",
        "largest load per length along the path of contact, operating load",
    ]
    if "mesh_force_rms" in result:
        names.append("RMS of the dynamic mesh force, largest of the meshes looked at")
    drawn = panels("Before (grey) and after (orange) relief", names, height=330 * len(names), vertical_spacing=0.08)
    meshes = short_names(texts(result, "relieved_mesh"))
    factors = result["load_factor"].values
    now = int(np.argmin(np.abs(factors - 1.0)))
    error = result["relieved_error"].values[:, :, now] * 1e6
    phase = np.append(result["mesh_phase"].values, 1.0)
    for j, mesh in enumerate(meshes):
        shown = error[:, j] - error[:, j].mean(axis=1, keepdims=True)
        _pair(drawn, phase, np.append(shown, shown[:, :1], axis=1), mesh, j, row=1)
        load = factors * float(result["relieved_force"].values[j]) / 1e3
        _pair(drawn, load, result["relieved_peak_to_peak"].values[:, j] * 1e6, mesh, j, row=2)
        drawn.add_vline(x=load[now], line={"color": INK, "width": 1, "dash": "dot"}, row=2, col=1)
        _pair(drawn, result["relieved_place"].values[j], result["relieved_load"].values[:, j] / 1e3, mesh, j, row=3)
    titles = [
        ("time [mesh cycles]", "error [µm]"),
        ("mesh force of one helix [kN]", "error [µm]"),
        ("path of contact from the pitch point [base pitches]", "load per length [N/mm]"),
    ]
    if "mesh_force_rms" in result:
        _pair(drawn, result["speed"].values, result["mesh_force_rms"].values, "", 0, row=4)
        titles.append(("speed relative to the operating one [1]", "force [N]"))
    for row, (x, y) in enumerate(titles, start=1):
        drawn.update_xaxes(title_text=x, row=row, col=1)
        drawn.update_yaxes(title_text=y, row=row, col=1, rangemode="normal" if row == 1 else "tozero")
    return drawn


def _pair(drawn: go.Figure, x: Array, values: Array, mesh: str, number: int, *, row: int) -> None:
    """Both states (2, k) of one mesh over x (k,): a colour for the state, a dash for the mesh."""
    for i, (state, colour) in enumerate((("before", _BEFORE), ("after", _AFTER))):
        look = {"color": colour, "width": 1.6 + 0.8 * i, "dash": DASHES[number % len(DASHES)]}
        name = ", ".join(text for text in (mesh, state) if text)
        trace = {"x": compact(x), "y": compact(values[i]), "mode": "lines", "line": look, "name": name}
        drawn.add_trace(go.Scatter(**trace, legendgroup=name, showlegend=row == 1), row=row, col=1)
