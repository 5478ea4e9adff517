"""Quantities of every mesh over time or mesh cycle, a panel a pair of gears, a curve a branch; and what a sensor sees.

Of teeth that part the mean over the slow phases stands in the band between least and most.  Over a speed ramp the mesh
frequency stands below, and the spectrum of a mesh force has the multiples of that frequency.  Of a sensor beside the
ring the signal over a turn of the carrier, its lines by family, and those of the mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ...results.dataset import ranked
from ..elements import SENSOR_UNITS
from ..series import (
    ARCSEC,
    Array,
    by_panel,
    engineering,
    kept_apart,
    label,
    merged,
    numbers,
    of_first_stage,
    own_tones,
    ramps,
    texts,
    thinned,
)
from .renderers import (
    INK,
    PALE,
    PALETTE,
    WARNING,
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
    note,
    pair_panels,
    points,
)

# Meshes drawn: the one of each pair whose force is largest, and at most so many pairs.
_MOST_PAIRS = 4
# Samples of a curve: more than pixels across.
_MOST_SAMPLES = 3000
# Windows of the spectrogram along the run, how they overlap, and what is shown below the largest amplitude [dB].
_WINDOWS, _OVERLAP, _RANGE = 100, 0.75, 60.0
_ORDERS = 5
# Lines of a sensor drawn: from this part of its largest on.
_SEEN = 1e-3
_QUANTITIES = {"1": "strain", "m/s2": "acceleration", "rad": "rotation", "N m": "torque", "N": "force"}


def over_time(
    result: xr.Dataset,
    name: str,
    title: str,
    unit: str,
    scale: float,
    *,
    marks: Sequence[Mark] = (),
    below: Sequence[Panel] = (),
) -> go.Figure:
    """One quantity of every mesh over time, a panel a pair of gears, a curve a branch.

    Parameters
    ----------
    result : Dataset with a variable `name` (mesh, time or mesh_phase).
    title : of the figure.  unit : title of the ordinate, with its unit.  scale : factor from SI to that unit.
    marks : through every panel.  below : further panels.
    """
    along = next(str(dim) for dim in result[name].dims if dim != "mesh")
    values = scale * result[name].transpose("mesh", along).values
    time = numbers(result, along, along)
    shown = pair_panels(by_panel(merged(texts(result, "mesh"), values, branches=True)), time, unit, width=1.5)
    shown += below
    unit_of_time = "mesh cycles"
    if along == "time":
        unit_of_time = str(result["time"].attrs.get("units", "s")) if "time" in result.variables else "samples"
    look: Trace = {"height": 120 + 210 * len(shown), "gap": 0.2 / max(2, len(shown))}
    ends = (float(time[0]), float(time[-1])) if len(time) > 1 else None
    return chart(title, *shown, x=f"time [{unit_of_time}]", x_ends=ends, marks=marks, **look)


def mesh_forces(result: xr.Dataset) -> go.Figure:
    """Mesh force of each branch [kN] over time, a panel a pair of gears, a line at 0 where that is near.

    Parameters
    ----------
    result : Dataset of `sharing`, `static` or `steady`: mesh_force (mesh, time or mesh_phase) [N], contact_lost (mesh).
    """
    forces = result["mesh_force"].values
    near = forces.size and np.nanmin(forces) < 0.15 * np.nanmax(forces)
    marks = [Mark(y=0, colour=WARNING)] if near else []
    title = "Mesh forces, mean over shaft phases" if "mesh_force_most" in result.variables else "Mesh forces over time"
    drawn = over_time(result, "mesh_force", title, "force [kN]", 1e-3, marks=marks)
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
    phase = numbers(result, "mesh_phase", "mesh_phase")
    least, most, mean = (
        1e-3 * result[f"mesh_force{end}"].transpose("mesh", "mesh_phase").values for end in ("_least", "_most", "")
    )
    names, apart = texts(result, "mesh"), result["open_share"].values
    worst: dict[str, int] = {}  # pair of gears -> its mesh with the largest force
    for row in ranked(np.nanmax(most, axis=1)).tolist():
        worst.setdefault("/".join(names[row].split("/")[:2]), row)
    layers: list[Layer] = [Mark(y=0, colour=WARNING)] if np.nanmin(least) < 0.15 * np.nanmax(most) else []
    for place, row in enumerate([*worst.values()][:_MOST_PAIRS]):
        name = names[row] + (f", apart {apart[row]:.0%} of the time" if apart[row] > 0 else "")
        look: Trace = {"colour": PALETTE[place % len(PALETTE)], "group": names[row]}
        layers += band(phase, (least[row], most[row], mean[row]), name, **look)
    panel = Panel(layers, y="force [kN]")
    title = "Mesh force, mean and range over all shaft phases"
    return chart(title, panel, x="mesh phase [mesh cycles]", height=440, showlegend=True)


def transient_forces(result: xr.Dataset) -> go.Figure:
    """Mesh forces [kN] over time [s], a panel a pair of gears, with the mesh frequency [Hz] below where it changes.

    Parameters
    ----------
    result : Dataset of `transient`: mesh_force (mesh, time) [N], mesh_frequency (time) [Hz].
    """
    time = np.asarray(result["time"].values, dtype=np.float64)
    curves = merged(texts(result, "mesh"), result["mesh_force"].transpose("mesh", "time").values / 1e3, branches=True)
    look: Trace = {"most": _MOST_SAMPLES, "width": 1.1, "digits": (7, 5)}
    forces = pair_panels(by_panel(curves), time, "force [kN]", **look)
    shown = [replace(panel, layers=[*panel.layers, Mark(y=0, width=1)]) for panel in forces]
    if ramps(result):
        x, y = thinned(time, numbers(result, "mesh_frequency"), most=_MOST_SAMPLES)
        title = f"mesh frequency{of_first_stage(result)}"
        shown.append(Panel([Curve(x, y, colour=INK, width=1.6, digits=(7, 5))], title=title, y="frequency [Hz]"))
    layout: Trace = {"height": 120 + 240 * len(shown), "gap": min(0.12, 0.5 / len(shown))}
    return chart("Mesh forces over time", *shown, x="time [s]", **layout)


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
    # ticks at powers of ten of the amplitude, of which the colours show the logarithm
    powers = [p for p in range(-9, 10) if high - _RANGE <= 20 * p <= high]
    ticks = {"tickvals": [20.0 * p for p in powers], "ticktext": [f"{10.0**p:g}" for p in powers]}
    bar = {"title": {"text": "amplitude<br>[kN]", "side": "top"}, **ticks}
    scale = {"colorscale": "Blues", "zmin": high - _RANGE, "zmax": high, "colorbar": bar}
    shown = np.maximum(level, high - _RANGE)
    layers: list[Layer] = [Heat(middle + time[0], frequency[frequency <= top], shown, digits=(6, 4), look=scale)]
    ends = [0, len(time) - 1] if len(time) < 2 else np.linspace(0, len(time) - 1, 40).astype(int).tolist()
    look: Trace = {"colour": INK, "width": 0.8, "dash": "dot", "hover": None, "digits": (9, 9)}
    layers += [Curve(time[ends], order * tone[ends], **look) for order in range(1, _ORDERS + 1)]
    run = (float(time[0]), float(time[-1]))
    panel = Panel(layers, x="time [s]", y="frequency [Hz]", x_ends=run, y_ends=(0, top))
    drawn = chart(f"What {label(names[place], stage=False)} carries over time", panel, height=520)
    for order in range(1, _ORDERS + 1):
        where = {"x": float(time[-1]), "y": order * float(tone[-1]), "xanchor": "right", "yanchor": "bottom"}
        note(drawn, "mesh frequency" if order == 1 else f"× {order}", **where, font={"size": 11, "color": PALE})
    return drawn


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
    level, fault_free = (_level(result, name) for name in ("signal_amplitude", "fault_free_amplitude"))
    shown: list[int] = np.flatnonzero(level > -_DECIBELS).tolist()
    there = [i for i in shown if fault_free[i] > -_DECIBELS]
    hertz, title = numbers(result, "line_frequency"), "frequency [Hz]"
    x = hertz
    if carrier > 0:
        x, title = numbers(result, "carrier_order"), "frequency per speed of the carrier [1]"
    label, cause = texts(result, "line"), texts(result, "causes")
    lines: list[Layer] = []
    for family, colour in _colours(result).items():
        own = [i for i in shown if str(result["family"].values[i]) == family]
        words = [f"{label[i]}, {engineering(float(hertz[i]))} Hz<br>{cause[i].replace('; ', '<br>')}" for i in own]
        look: Trace = {"colour": colour, "width": 1.8, "points": 5, "hover": "%{text}<br>%{y:.1f} dB"}
        at, heads = [round(float(x[i]), 6) for i in own], [round(float(level[i]), 2) for i in own]
        lines += [Stems(at, heads, foot=-_DECIBELS, name=family, text=words, **look)] if own else []
    # rings at the level that each line has in the train as drawn
    ring: Trace = {"symbol": "circle-open", "colour": PALE, "hover": None, "digits": (17, 17)}
    lines.append(points(np.round(x[there], 6), np.round(fault_free[there], 2), 9, name="without deviations", **ring))
    names = [
        "signal over one turn of the carrier: dotted, a planet under the sensor" if carrier > 0 else "signal",
        "lines: what is there without any fault in black, greys and pale blue; ○ the line without deviations",
        "round the mesh frequency",
    ]
    axes: Trace = {"x": title, "y": "level re largest [dB]", "y_ends": (-_DECIBELS, 8)}
    centre, reach = _mesh_tone(result, carrier)
    where = {"y": 1, "yref": "y3 domain", "xanchor": "left", "yanchor": "top"}
    tone: Trace = {"words": f"mesh {engineering(centre)}", "where": where, "dash": "dot", "below": True}
    mesh = Mark(x=centre, colour=PALE, width=1, **tone)
    drawn = chart(
        "Vibration at a fixed place beside the ring",
        _signal(result, carrier, names[0]),
        Panel(lines, title=names[1], **axes),
        Panel([*lines, mesh], title=names[2], x_ends=(centre - reach, centre + reach), **axes),
        height=980,
        gap=0.09,
    )
    inside = [i for i in shown if abs(x[i] - centre) < reach]
    loudest = sorted(inside, key=lambda i: -level[i])[: 2 * _NAMED]
    for i in kept_apart(x, loudest, 0.11 * reach, _NAMED):
        short = label[i].removeprefix("1 x mesh ").replace(" x ", "×").replace("- ", "\u2212").replace("+ ", "+")
        note(drawn, short, x=float(x[i]), y=float(level[i]), xref="x3", yref="y3", yanchor="bottom", yshift=4)
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
    largest = float(np.abs(result["signal_amplitude"].values).max(initial=0.0)) or 1.0
    return np.asarray(20 * np.log10(np.maximum(np.abs(result[name].values) / largest, 1e-12)))


def _signal(result: xr.Dataset, carrier: float, title: str) -> Panel:
    """The signal over a turn of the carrier [Hz], or over time where that stands still, and planets passing."""
    time, values = numbers(result, "sample_time"), numbers(result, "signal")
    if carrier:
        time = time * carrier
        values, time = values[time <= 1.0], time[time <= 1.0]
    unit, scale = SENSOR_UNITS[str(result["signal"].attrs["units"])]
    values = scale * values
    time, values = thinned(time, values, most=2000)
    layers: list[Layer] = [Curve(time, values, colour=INK, width=1.1, digits=(6, 5))]
    where = {"y": 1, "yref": "y domain", "xanchor": "left", "yanchor": "top", "xshift": 3}
    for planet, passage in zip(result["planet"].values, result["passage"].values, strict=True):
        if np.isfinite(passage):
            look: Trace = {"colour": branch_colour(int(planet)), "width": 1.6, "dash": "dot"}
            layers.append(Mark(x=float(passage) * carrier % 1.0, words=f"planet {planet}", where=where, **look))
    return Panel(layers, title=title, x="turns of the carrier [1]" if carrier else "time [s]", y=f"signal [{unit}]")


def _mesh_tone(result: xr.Dataset, carrier: float) -> tuple[float, float]:
    """The mesh frequency, and how far round it lines are shown; per speed of the carrier [Hz] where that turns."""
    mesh = float(result.attrs["stage_mesh_frequency"])
    centre = mesh / carrier if carrier else mesh
    return centre, min(3.5 * result.sizes["planet"] if carrier else 0.5 * mesh, centre)


def transmission_errors(result: xr.Dataset) -> go.Figure:
    """Transmission error by rotation of each branch [µm] over time, a panel a pair of gears; of shafts below [arcsec].

    Parameters
    ----------
    result : Dataset of `static` or `steady`: transmission_error_rotation (mesh, time or mesh_phase) [m] and, of shafts,
        transmission_error_shaft (shaft, ..) [rad].
    """
    below = []
    if "transmission_error_shaft" in result.variables:
        along = next(str(dim) for dim in result["transmission_error_shaft"].dims if dim != "shaft")
        waves = ARCSEC * result["transmission_error_shaft"].transpose("shaft", along).values
        time, curves = numbers(result, along, along), []
        for place, name in enumerate(texts(result, "shaft")):
            x, y = thinned(time, waves[place], most=_MOST_SAMPLES)
            curves.append(Curve(x, y, name=name, colour=PALETTE[place % len(PALETTE)], width=1.5))
        below = [Panel(curves, title="shaft to shaft", y="lag of the driven shaft [arcsec]")]
    title = "Transmission error" + (", multiples of the mesh frequency" if "mesh_phase" in result.dims else "")
    words = "lag of the driven gear [µm]"
    return over_time(result, "transmission_error_rotation", title, words, 1e6, below=below)


def sensors(result: xr.Dataset) -> go.Figure:
    """Signals of the sensors, a panel a unit: over time, as lines over frequency [Hz], or their RMS over speed.

    Parameters
    ----------
    result : Dataset of `static`, `steady`, `sweep` or `transient`: sensor_unit (sensor), and sensor_signal (sensor,
        time), sensor_amplitude (sensor, sensor_line) with sensor_line_frequency, or sensor_rms (sensor, speed) with
        mesh_frequency.
    """
    names, units = texts(result, "sensor"), texts(result, "sensor_unit", "sensor")
    if "sensor_signal" in result.variables:
        values, x = result["sensor_signal"].transpose("sensor", "time").values, numbers(result, "time", "time")
        title, axis = "Sensors over time", f"time [{result['time'].attrs.get('units', 's')}]"
    elif "sensor_amplitude" in result.variables:
        values = np.abs(result["sensor_amplitude"].transpose("sensor", "sensor_line").values)
        x, title, axis = numbers(result, "sensor_line_frequency"), "Lines of the sensors", "frequency [Hz]"
    else:
        values, x = result["sensor_rms"].transpose("sensor", "speed").values, numbers(result, "mesh_frequency")
        title, axis = "RMS of the sensors over speed", "mesh frequency [Hz]"
    rank, shown = np.argsort(x, kind="stable"), []
    for unit, (as_shown, scale) in SENSOR_UNITS.items():
        layers: list[Layer] = []
        for i in (i for i, own in enumerate(units) if own == unit):
            look: Trace = {"name": names[i], "colour": PALETTE[i % len(PALETTE)]}
            at, own = x[rank], scale * values[i][rank]
            if "sensor_amplitude" in result.variables:
                there = np.flatnonzero((own > _SEEN * own.max(initial=0.0)) & (at > 0))
                said = [f"{names[i]}: {own[k]:.4g} {as_shown} at {engineering(float(at[k]))} Hz" for k in there]
                layers.append(Stems(at[there], own[there], width=1.5, points=4, text=said, **look))
            else:
                layers.append(Curve(*thinned(at, own, most=_MOST_SAMPLES), width=1.5, **look))
        if layers:
            shown.append(Panel(layers, y=f"{_QUANTITIES[unit]} [{as_shown}]"))
    return chart(title, *shown, x=axis, height=140 + 230 * len(shown), gap=0.2 / max(2, len(shown)))
