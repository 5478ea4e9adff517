"""A train by itself: speed and power of its members, frequencies, mesh phases and stiffnesses; its bearings, its loads
over time, and the gearbox at its output.

Speed, external torque and power of every member are bars about zero; shaft and mesh frequencies stand on one axis; mesh
phases on dials, one a pair of gears; mesh stiffness over one mesh cycle, one panel a pair, one curve a branch.  Loads
of rolling elements stand around the load zone; hours over torque and speed, and ranges of the torque over the cycles
that have them.  At the output torque stands over angle as a bench with the other shafts locked draws it.

Rings that bend: their radial deflection about the train.
"""

from __future__ import annotations

import json

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..part_tables import deflections
from ..series import (
    ARCMIN,
    Series,
    by_panel,
    engineering,
    members_of,
    merged,
    numbers,
    ring_deflection,
    texts,
    zones_of,
)
from .renderers import (
    INK,
    PALE,
    PALETTE,
    Bars,
    Curve,
    Heat,
    Layer,
    Mark,
    Panel,
    Stems,
    Trace,
    band,
    branch_colour,
    chart,
    kind_colour,
    level_bars,
    pair_panels,
    panels,
    points,
)


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


def load_zones(result: xr.Dataset) -> go.Figure:
    """Loads of the elements [kN] over their angle from the one that bears most, in the case that loads it most.

    Parameters
    ----------
    result : Dataset of `life`: element_load, element_angle (bearing, case, element).
    """
    curves = [
        Curve(angle, load, name=name, points=6, width=1.2, colour=PALETTE[place % len(PALETTE)])
        for place, (name, (angle, load)) in enumerate(zones_of(result).items())
    ]
    return chart("Load zones", Panel(curves, x="angle from the most loaded element [deg]", y="load of an element [kN]"))


_POINTS = 800  # of a curve


def hours_over_torque(result: xr.Dataset) -> go.Figure:
    """Hours in every bin of torque [kN m] and speed [rpm], on a logarithmic scale; a bin without time is empty.

    result : Dataset of `spectrum`: case_hours, case_damage, torque_bin, speed_bin (case), torque_edge [N m], speed_edge
        [rpm].
    """
    edges = {name: result[f"{name}_edge"].values for name in ("torque", "speed")}
    at = (result["torque_bin"].values, result["speed_bin"].values)
    rows = np.full((len(edges["torque"]) - 1, len(edges["speed"]) - 1), np.nan)
    words = np.full(rows.shape, "", dtype=object)
    hours, damage = result["case_hours"].values, result["case_damage"].values
    rows[at] = np.log10(hours)
    words[at] = [f"{engineering(one)} h, {part:.1%} of the damage" for one, part in zip(hours, damage, strict=True)]
    ticks = np.arange(np.floor(np.nanmin(rows)), np.ceil(np.nanmax(rows)) + 1)
    bar = {"title": {"text": "hours [h]"}, "tickvals": ticks.tolist(), "ticktext": [f"{10.0**one:g}" for one in ticks]}
    look = {"colorscale": "YlOrBr", "colorbar": bar, "customdata": words.tolist()}
    heat = Heat(edges["speed"], edges["torque"] / 1e3, rows, hover="%{customdata}", look=look)
    return chart("Hours over torque and speed", Panel([heat], x="speed [rpm]", y="torque [kN m]"), height=460)


def ranges_over_cycles(result: xr.Dataset) -> go.Figure:
    """Range of the torque [kN m] over the number of cycles that have it or a larger one.

    result : Dataset of `spectrum`: cycle_range, largest first, cycle_count (cycle).
    """
    count, size = np.cumsum(result["cycle_count"].values), result["cycle_range"].values / 1e3
    at = np.unique(np.geomspace(1, len(size), _POINTS).astype(np.int64)) - 1  # as the axis is, so that rare ones stay
    log = {"type": "log", "exponentformat": "power"}
    panel = Panel([Curve(count[at], size[at], shape="vh")], x="cycles [1]", y="range [kN m]", x_axis=log)
    return chart("Ranges of the torque by rainflow", panel)


_SECANT = (0.5, 1.0)  # torques per rated torque


def torque_over_angle(result: xr.Dataset) -> go.Figure:
    """Loop of the torque [N m] over the angle [arcmin], mean over the places of the mesh cycle.

    Marked are the rated torque, the share at which lost motion is read, the lost motion and the secant.

    result : Dataset of `output`: angle_rising, angle_falling (mesh_phase, shaft_torque), lost_motion,
        shaft_secant_stiffness (over_phases), rated_torque; in its options the share.
    """
    torque, share = result["shaft_torque"].values, float(json.loads(result.attrs["options"])["share"])
    rated = float(result["rated_torque"])
    rising, falling = (ARCMIN * result[f"angle_{way}"].mean("mesh_phase").values for way in ("rising", "falling"))
    middle, one = (rising + falling) / 2, np.allclose(rising, falling, rtol=1e-9)
    ends = np.array([-share, share]) * rated
    lost = np.interp(ends, torque, middle)
    secant = np.array(_SECANT) * (-rated if result.attrs["rated_sense"] == "negative" else rated)
    size = ARCMIN * float(result["lost_motion"].sel(over_phases="mean"))
    known = [] if np.isnan(size) else [f"lost motion {engineering(size)} arcmin"]
    apart = [] if known else [np.searchsorted(torque, 0)]  # without backlash no play joins the two senses
    drawn, rise, fall = (np.insert(values, apart, np.nan) for values in (torque, rising, falling))
    layers = [
        *([] if one else [Curve(fall, drawn, name="falling", colour=PALETTE[1])]),
        Curve(rise, drawn, name="both branches" if one else "rising", colour=PALETTE[0]),
        Curve(np.interp(secant, torque, middle), secant, name="secant, 50 to 100 %", colour=INK, dash="dash"),
        *(points(lost, ends, 8, name=words, colour=PALETTE[3]) for words in known),
        *(Mark(y=end, dash="dot", name=f"{100 * share:.3g} % of the rated torque") for end in ends),
        *(Mark(y=sense * rated, width=0.8, name="rated torque") for sense in (-1, 1)),
    ]
    title = f"Torque over angle at {result.attrs['shaft']}, locked {result.attrs['locked_shafts']}"
    return chart(title, Panel(layers, x="angle [arcmin]", y="torque [N m]"), height=520)


def kinematic_error(result: xr.Dataset) -> go.Figure:
    """Kinematic error [arcmin] over the turns of the shaft, and its orders.

    result : Dataset of `output`: kinematic_error (shaft_turn), kinematic_error_order (shaft_order).
    """
    wave = Curve(result["shaft_turn"].values, ARCMIN * result["kinematic_error"].values, colour=PALETTE[0])
    order, size = result["shaft_order"].values, ARCMIN * result["kinematic_error_order"].values
    words = [f"order {engineering(one)}: {engineering(part)} arcmin" for one, part in zip(order, size, strict=True)]
    over = Panel([wave], x="turns of the shaft [1]", y="error [arcmin]")
    orders = Panel([Stems(order, size, text=words, points=6, colour=PALETTE[0])], x="order [1]", y="amplitude [arcmin]")
    return chart(f"Kinematic error of {result.attrs['shaft']}", over, orders, height=560, gap=0.2)


_PLACES = 241  # every 1.5 degrees
_INSTANTS = 4096  # of a record, whose range is drawn


def ring_deflections(result: xr.Dataset, check: xr.Dataset | None = None) -> go.Figure:
    """Radial deflection of every ring that bends [µm] over the polar angle [deg]: mean and range over the record.

    Parameters
    ----------
    result : Dataset of `static` or `steady`: displacement (dof, time or mesh_phase) [m].
    check : Dataset of `check`, whose meshes of a ring are marked: gear_b, mesh_direction (mesh) [rad].
    """
    angle = np.linspace(0.0, 2 * np.pi, _PLACES)
    panels = []
    for place, (ring, moved) in enumerate(deflections(result).items()):
        values, out = np.array([*moved.values()]), 1e6 * ring_deflection(list(moved), angle)[0]
        over_record = out @ values[:, :: -(-values.shape[1] // _INSTANTS)]
        rows = over_record.min(axis=1), over_record.max(axis=1), out @ values.mean(axis=1)
        layers: list[Layer] = [
            Mark(y=0, width=1),
            *(Mark(x=x, colour=PALE, dash="dot") for x in _meshes(check, ring)),
            *band(np.degrees(angle), rows, ring, colour=PALETTE[place % len(PALETTE)]),
        ]
        panels.append(Panel(layers, y="outward [µm]"))
    look: Trace = {"height": 120 + 240 * len(panels), "gap": 0.2 / max(2, len(panels))}
    return chart("Bending of rings", *panels, x="polar angle from x of the stage [deg]", x_ends=(0.0, 360.0), **look)


def _meshes(check: xr.Dataset | None, ring: str) -> list[float]:
    """Polar angles of the meshes of a ring [deg]."""
    if check is None:
        return []
    own = zip(texts(check, "gear_b", "mesh"), check["mesh_direction"].values.tolist(), strict=True)
    return sorted({round(float(np.degrees(direction)) % 360, 6) for gear, direction in own if gear == ring})
