"""Quantities of every mesh over time or mesh cycle, a panel a pair of gears, a curve a branch; and what a sensor sees.

Of teeth that part the mean over the slow phases stands in the band between least and most.  Over a speed ramp the mesh
frequency stands below, and the spectrum of a mesh force has the multiples of that frequency.  Of a sensor beside the
ring the signal over a turn of the carrier, its lines by family, and those of the mesh.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ...results.dataset import ranked
from ..series import (
    Array,
    by_panel,
    compact,
    engineering,
    label,
    merged,
    numbers,
    of_first_stage,
    own_tones,
    ramps,
    texts,
    thinned,
)
from .style import (
    DASHES,
    INK,
    PALE,
    PALETTE,
    WARNING,
    add_curve,
    axis_titles,
    branch_colour,
    entry,
    figure,
    note,
    panels,
    translucent,
)

# Meshes drawn: the one of each pair whose force is largest, and at most so many pairs.
_MOST_PAIRS = 4
# Samples of a curve: more than pixels across.
_MOST_SAMPLES = 3000
# Windows of the spectrogram along the run, how they overlap, and what is shown below the largest amplitude [dB].
_WINDOWS, _OVERLAP, _RANGE = 100, 0.75, 60.0
_ORDERS = 5


def over_time(result: xr.Dataset, name: str, title: str, unit: str, scale: float) -> go.Figure:
    """One quantity of every mesh over time, a panel a pair of gears, a curve a branch.

    Parameters
    ----------
    result : Dataset with a variable `name` (mesh, time or mesh_phase).
    title : of the figure.  unit : title of the ordinate, with its unit.  scale : factor from SI to that unit.
    """
    along = next(str(dim) for dim in result[name].dims if dim != "mesh")
    values = scale * result[name].transpose("mesh", along).values
    time = numbers(result, along, along)
    groups = by_panel(merged(texts(result, "mesh"), values, branches=True))
    space: dict[str, Any] = {"shared_xaxes": True, "vertical_spacing": 0.2 / max(2, len(groups))}
    drawn = panels(title, list(groups), height=120 + 210 * len(groups), **space)
    shown: set[str] = set()
    for row, series in enumerate(groups.values(), start=1):
        for one in series:
            add_curve(
                drawn,
                *thinned(time, one.values),
                panel=row,
                **entry(one.label, first=one.label not in shown),
                line={"color": branch_colour(one.branch), "width": 1.5, "dash": DASHES[one.side == "right"]},
                hovertemplate=f"{one.label}: %{{y:.4g}} at %{{x:.4g}}<extra></extra>",
            )
            shown.add(one.label)
        drawn.update_yaxes(title_text=unit, row=row, col=1)
    unit_of_time = "mesh cycles"
    if along == "time":
        unit_of_time = str(result["time"].attrs.get("units", "s")) if "time" in result.variables else "samples"
    drawn.update_xaxes(title_text=f"time [{unit_of_time}]", row=len(groups), col=1)
    if len(time) > 1:
        drawn.update_xaxes(range=[float(time[0]), float(time[-1])])
    return drawn


def mesh_forces(result: xr.Dataset) -> go.Figure:
    """Mesh force of each branch [kN] over time, a panel a pair of gears, a line at 0 where that is near.

    Parameters
    ----------
    result : Dataset of `sharing`, `static` or `steady`: mesh_force (mesh, time or mesh_phase) [N], contact_lost (mesh).
    """
    drawn = over_time(result, "mesh_force", "Mesh forces over time", "force [kN]", 1e-3)
    forces = result["mesh_force"].values
    if forces.size and np.nanmin(forces) < 0.15 * np.nanmax(forces):
        for row in range(1, len(drawn.layout.annotations) + 1):
            drawn.add_hline(y=0, line={"color": WARNING, "width": 1.2}, row=row, col=1)
    lost = int(np.sum(numbers(result, "contact_lost", "mesh") > 0))
    if lost:
        where = {"xref": "paper", "yref": "paper", "x": 1, "xanchor": "right", "y": 1.0, "yanchor": "bottom"}
        words = f"contact lost in {lost} of {result.sizes['mesh']} meshes"
        note(drawn, words, **where, yshift=24, font={"size": 12, "color": WARNING})
    return drawn


def force_envelopes(result: xr.Dataset) -> go.Figure:
    """Force of the most loaded mesh of every pair [kN] over its mesh phase [mesh cycles]: mean and band.

    Parameters
    ----------
    result : Dataset of `steady` with contact loss: mesh_force, mesh_force_least, mesh_force_most (mesh, mesh_phase)
        [N], open_share (mesh) [1].
    """
    title = "Mesh force, mean and range over all shaft phases"
    drawn = figure(title, x="mesh phase [mesh cycles]", y="force [kN]", height=440)
    phase = numbers(result, "mesh_phase", "mesh_phase")
    mean, least, most = (
        1e-3 * result[name].transpose("mesh", "mesh_phase").values
        for name in ("mesh_force", "mesh_force_least", "mesh_force_most")
    )
    names, apart = texts(result, "mesh"), result["open_share"].values
    worst: dict[str, int] = {}  # pair of gears -> its mesh with the largest force
    for row in ranked(np.nanmax(most, axis=1)).tolist():
        worst.setdefault("/".join(names[row].split("/")[:2]), row)
    for place, row in enumerate([*worst.values()][:_MOST_PAIRS]):
        colour = PALETTE[place % len(PALETTE)]
        share = f", apart {apart[row]:.0%} of the time" if apart[row] > 0 else ""
        edge: dict[str, Any] = {"hoverinfo": "skip", "showlegend": False, "line": {"width": 0, "color": colour}}
        fill: dict[str, Any] = {"fill": "tonexty", "fillcolor": translucent(colour, 0.22)}
        add_curve(drawn, phase, least[row], legendgroup=names[row], **edge)
        add_curve(drawn, phase, most[row], legendgroup=names[row], **edge, **fill)
        line = {"color": colour, "width": 2}
        add_curve(drawn, phase, mean[row], name=f"{names[row]}{share}", legendgroup=names[row], line=line)
    if np.nanmin(least) < 0.15 * np.nanmax(most):
        drawn.add_hline(y=0, line={"color": WARNING, "width": 1.2})
    return drawn.update_layout(showlegend=True)


def transient_forces(result: xr.Dataset) -> go.Figure:
    """Mesh forces [kN] over time [s], a panel a pair of gears, with the mesh frequency [Hz] below where it changes.

    Parameters
    ----------
    result : Dataset of `transient`: mesh_force (mesh, time) [N], mesh_frequency (time) [Hz].
    """
    time = np.asarray(result["time"].values, dtype=np.float64)
    curves = merged(texts(result, "mesh"), result["mesh_force"].transpose("mesh", "time").values / 1e3, branches=True)
    groups, ramp = by_panel(curves), ramps(result)
    names = [*groups, *([f"mesh frequency{of_first_stage(result)}"] if ramp else [])]
    space: dict[str, Any] = {"shared_xaxes": True, "vertical_spacing": min(0.12, 0.5 / len(names))}
    drawn = panels("Mesh forces over time", names, height=120 + 240 * len(names), **space)
    seen: set[str] = set()
    for row, series in enumerate(groups.values(), start=1):
        for one in series:
            dash = "solid" if not one.side or one.side.startswith("l") else DASHES[2]
            add_curve(
                drawn,
                *thinned(time, one.values, most=_MOST_SAMPLES),
                panel=row,
                digits=(7, 5),
                name=one.label,
                legendgroup=one.label,
                showlegend=False if one.label in seen else None,
                line={"color": branch_colour(one.branch), "dash": dash, "width": 1.1},
                hovertemplate=f"{one.label}: %{{y:.4g}} kN at %{{x:.5g}} s<extra></extra>",
            )
            seen.add(one.label)
        drawn.add_hline(y=0, line={"color": INK, "width": 1}, row=row, col=1)
        drawn.update_yaxes(title_text="force [kN]", row=row, col=1)
    if ramp:
        curve = thinned(time, np.asarray(result["mesh_frequency"].values, dtype=np.float64), most=_MOST_SAMPLES)
        line = {"color": INK, "width": 1.6}
        add_curve(drawn, *curve, panel=len(names), digits=(7, 5), line=line, showlegend=False)
        drawn.update_yaxes(title_text="frequency [Hz]", row=len(names), col=1)
    drawn.update_xaxes(title_text="time [s]", row=len(names), col=1)
    return drawn


def spectrogram(result: xr.Dataset, mesh: str | None = None) -> go.Figure:
    """Amplitude of a mesh force [kN, logarithmic] over time [s] and frequency [Hz], with mesh orders.

    Where a horizontal band is crossed by an order and lights up, a natural frequency is passed.

    Parameters
    ----------
    result : Dataset of `transient`: mesh_force (mesh, time) [N], mesh_frequency (time) [Hz], mesh_tone (mesh).
    mesh : its name; that with the largest swing where not said.
    """
    from scipy.signal import spectrogram as windows

    names, force = texts(result, "mesh"), result["mesh_force"].transpose("mesh", "time").values
    swing = np.nanmax(force, axis=1) - np.nanmin(force, axis=1)
    place = int(np.nanargmax(swing)) if mesh is None else names.index(mesh)
    time = np.asarray(result["time"].values, dtype=np.float64)
    signal = np.nan_to_num(force[place] / 1e3)
    size = max(16, min(len(signal), round(len(signal) / (1 + (_WINDOWS - 1) * (1 - _OVERLAP)))))
    signal, overlap = signal - signal.mean(), int(_OVERLAP * size)
    options = {"nperseg": size, "noverlap": overlap, "window": "hann", "scaling": "spectrum"}
    frequency, middle, power = windows(signal, fs=1 / (time[1] - time[0]), **options)
    amplitude = np.sqrt(2 * power)
    tone = np.asarray(result["mesh_frequency"].values, dtype=np.float64) * own_tones(result)[place]
    top = min(float(frequency[-1]), (_ORDERS + 0.5) * float(tone.max()))
    level = 20 * np.log10(np.maximum(amplitude[frequency <= top], 1e-30))
    high = float(level.max())
    title = f"What {label(names[place], stage=False)} carries over time"
    drawn = figure(title, x="time [s]", y="frequency [Hz]", height=520)
    # ticks at powers of ten of the amplitude, of which the colours show the logarithm
    powers = [p for p in range(-9, 10) if high - _RANGE <= 20 * p <= high]
    ticks = {"tickvals": [20.0 * p for p in powers], "ticktext": [f"{10.0**p:g}" for p in powers]}
    drawn.add_heatmap(
        x=compact(middle + time[0], digits=6),
        y=compact(frequency[frequency <= top]),
        z=[compact(row, digits=4) for row in np.maximum(level, high - _RANGE)],
        colorscale="Blues",
        zmin=high - _RANGE,
        zmax=high,
        colorbar={"title": {"text": "amplitude<br>[kN]", "side": "top"}, **ticks},
        hovertemplate="%{x:.4g} s, %{y:.4g} Hz<extra></extra>",
    )
    ends = [0, len(time) - 1] if len(time) < 2 else np.linspace(0, len(time) - 1, 40).astype(int).tolist()
    line = {"color": INK, "width": 0.8, "dash": "dot"}
    for order in range(1, _ORDERS + 1):
        look: dict[str, Any] = {"mode": "lines", "line": line, "showlegend": False, "hoverinfo": "skip"}
        drawn.add_scatter(x=time[ends], y=order * tone[ends], **look)
        where = {"x": float(time[-1]), "y": order * float(tone[-1]), "xanchor": "right", "yanchor": "bottom"}
        words = "mesh frequency" if order == 1 else f"× {order}"
        note(drawn, words, **where, font={"size": 11, "color": PALE})
    drawn.update_yaxes(range=[0, top])
    return drawn.update_xaxes(range=[float(time[0]), float(time[-1])])


_FAULT_FREE = {
    "mesh": "#1F2933",
    "planets passing": "#7A7A7A",
    "uneven planets": "#56B4E9",
    "mean load passing": "#C5CCD3",
}
_OTHERS = tuple(colour for colour in PALETTE if colour not in _FAULT_FREE.values())
# Lines this far below the largest are not drawn: they would hide the others.
_DECIBELS = 80.0
_NAMED = 6


def modulation(result: xr.Dataset) -> go.Figure:
    """Vibration beside the ring: signal over a turn of the carrier, and its lines [dB re largest] over their order.

    The third panel shows the lines round the mesh frequency.  Lines are coloured by family, rings are the lines of the
    train without deviations.

    Parameters
    ----------
    result : Dataset of `modulation`: signal (sample_time), signal_amplitude, fault_free_amplitude, line_frequency [Hz],
        carrier_order, family, causes (line), passage (planet) [s]; attributes carrier_frequency, stage_mesh_frequency
        [Hz].
    """
    carrier = float(result.attrs["carrier_frequency"])
    names = [
        "signal over one turn of the carrier: dotted, a planet under the sensor" if carrier > 0 else "signal",
        "lines: what is there without any fault in black, greys and pale blue; ○ the line without deviations",
        "round the mesh frequency",
    ]
    drawn = panels("Vibration at a fixed place beside the ring", names, height=980, vertical_spacing=0.09)
    _signal(drawn, result, carrier)
    level, fault_free = (_level(result, name) for name in ("signal_amplitude", "fault_free_amplitude"))
    shown: list[int] = np.flatnonzero(level > -_DECIBELS).tolist()
    there = [i for i in shown if fault_free[i] > -_DECIBELS]
    variable, title = "line_frequency", "frequency [Hz]"
    if carrier > 0:
        variable, title = "carrier_order", "frequency per speed of the carrier [1]"
    x = np.asarray(result[variable].values, float)
    rings = {"color": PALE, "size": 9, "symbol": "circle-open"}
    label, cause, hertz = texts(result, "line"), texts(result, "causes"), result["line_frequency"].values
    for row in (2, 3):
        for family, colour in _colours(result).items():
            lines = [i for i in shown if str(result["family"].values[i]) == family]
            if not lines:
                continue
            # from the bottom up to the level of each line
            at, heads = [float(x[i]) for i in lines], [round(float(level[i]), 2) for i in lines]
            drawn.add_scatter(
                x=[value for place in at for value in (place, place, None)],
                y=[value for head in heads for value in (-_DECIBELS, head, None)],
                **{"mode": "lines", "line": {"color": colour, "width": 1.8}, "legendgroup": family},
                **{"showlegend": False, "hoverinfo": "skip", "row": row, "col": 1},
            )
            words = [
                f"{label[i]}, {engineering(float(hertz[i]))} Hz<br>{cause[i].replace('; ', '<br>')}" for i in lines
            ]
            drawn.add_scatter(
                x=[round(place, 6) for place in at],
                y=heads,
                **{"mode": "markers", "marker": {"color": colour, "size": 5}, "name": family, "legendgroup": family},
                text=words,
                hovertemplate="%{text}<br>%{y:.1f} dB<extra></extra>",
                **{"showlegend": row == 2, "row": row, "col": 1},
            )
        # rings at the level that each line has in the train as drawn
        drawn.add_scatter(
            x=[round(float(x[i]), 6) for i in there],
            y=[round(float(fault_free[i]), 2) for i in there],
            mode="markers",
            marker=rings,
            name="without deviations",
            legendgroup="without",
            showlegend=row == 2,
            hoverinfo="skip",
            row=row,
            col=1,
        )
        axis_titles(drawn, title, "level re largest [dB]", row=row)
        drawn.update_yaxes(range=[-_DECIBELS, 8], row=row, col=1)
    _zoom(drawn, result, shown, x, level)
    return drawn


def _colours(result: xr.Dataset) -> dict[str, str]:
    """A colour for each family, the loudest first."""
    family = texts(result, "family", "line")
    rank = ranked(np.abs(result["signal_amplitude"].values))
    names = list(dict.fromkeys(family[i] for i in rank))
    others = [name for name in names if name not in _FAULT_FREE]
    return {name: _FAULT_FREE.get(name) or _OTHERS[others.index(name) % len(_OTHERS)] for name in names}


def _level(result: xr.Dataset, name: str) -> Array:
    """Decibels of the largest line of the signal; what is not there far below."""
    size = np.abs(result[name].values)
    largest = float(np.abs(result["signal_amplitude"].values).max(initial=0.0)) or 1.0
    level: Array = 20 * np.log10(np.maximum(size / largest, 1e-12))
    return level


def _signal(drawn: go.Figure, result: xr.Dataset, carrier: float) -> None:
    """The signal over a turn of the carrier [Hz], or over time where that stands still, and planets passing."""
    time = np.asarray(result["sample_time"].values, float)
    values = np.asarray(result["signal"].values, float)
    if carrier:
        time = time * carrier
        values, time = values[time <= 1.0], time[time <= 1.0]
    line = {"color": INK, "width": 1.1}
    x, y = thinned(time, values, most=2000)
    add_curve(drawn, x, y, panel=1, digits=(6, 5), line=line, name="signal", showlegend=False)
    unit = str(result["signal"].attrs["units"]).replace("s2", "s²")
    axis_titles(drawn, "turns of the carrier [1]" if carrier else "time [s]", f"signal [{unit}]", row=1)
    where = {"xref": "x", "y": 1, "yref": "y domain", "xanchor": "left", "yanchor": "top", "xshift": 3}
    for planet, passage in zip(result["planet"].values, result["passage"].values, strict=True):
        if np.isfinite(passage):
            at = float(passage) * carrier % 1.0
            drawn.add_vline(x=at, line={"color": branch_colour(int(planet)), "width": 1.6, "dash": "dot"}, row=1, col=1)
            note(drawn, f"planet {planet}", x=at, **where)


def _zoom(drawn: go.Figure, result: xr.Dataset, shown: list[int], x: Array, level: Array) -> None:
    """The third panel: lines x (lines,) round the mesh frequency, the highest of `level` (lines,) [dB] named."""
    mesh = float(result.attrs["stage_mesh_frequency"])
    carrier = float(result.attrs["carrier_frequency"])
    centre = mesh / carrier if carrier else mesh
    reach = 3.5 * result.sizes["planet"] if carrier else 0.5 * mesh
    reach = min(reach, centre)
    drawn.update_xaxes(range=[centre - reach, centre + reach], row=3, col=1)
    inside = [i for i in shown if abs(x[i] - centre) < reach]
    label = texts(result, "line")
    drawn.add_vline(x=centre, line={"color": PALE, "width": 1, "dash": "dot"}, layer="below", row=3, col=1)
    where = {"xref": "x3", "y": 1, "yref": "y3 domain", "xanchor": "left", "yanchor": "top"}
    note(drawn, f"mesh {engineering(centre)}", x=centre, **where)
    named: list[float] = []
    for i in sorted(inside, key=lambda i: -level[i])[: 2 * _NAMED]:
        if len(named) == _NAMED or any(abs(x[i] - other) < 0.11 * reach for other in named):
            continue
        text = label[i].removeprefix("1 x mesh ").replace(" x ", "×").replace("- ", "\u2212").replace("+ ", "+")
        note(drawn, text, x=float(x[i]), y=float(level[i]), xref="x3", yref="y3", yanchor="bottom", yshift=4)
        named.append(float(x[i]))
