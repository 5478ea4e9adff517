"""Over speed and a second axis: spectrum of the mesh forces, and stability.

The spectrum has order lines in the plane of speed and frequency, coloured by amplitude.  Stability is Floquet
multipliers and growth rates over speed, and over speed and a second parameter; beside them stand the ranges and
boundaries predicted by averaging.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from numpy.typing import NDArray

from ..series import (
    Array,
    compact,
    engineering,
    has_room,
    kept_apart,
    mode_groups,
    numbers,
    own_tones,
    stability_verdict,
    texts,
)
from .over_speed import abscissa, kind_mark, operating_mark
from .renderers import (
    GRID,
    INK,
    PALE,
    PALETTE,
    WARNING,
    Curve,
    Heat,
    Layer,
    Mark,
    Panel,
    Trace,
    chart,
    level_legend,
    note,
    points,
    translucent,
)

# Drawn at most: lines, and marked resonances.  Amplitudes below this part of the largest are not drawn.
_LINES, _MARKS, _LEAST = 30, 5, 1e-3
# A figure of 620 px on a page: its plot is about 850 by 450 px wide and high, on a narrow page 600.  In parts of it: a
# ring, and a letter of 12 px with the height of a line.
_AREA = (700.0, 450.0)
_RING, _LETTER = (0.03, 0.045), (0.0105, 0.045)
_COLOURS = [[0.0, "#DCE6EE"], [0.35, "#8FC1E3"], [0.6, "#0072B2"], [0.8, "#5B3F8C"], [1.0, "#D55E00"]]


class Ray(NamedTuple):
    """One line: frequency = order x mesh frequency.

    amplitude : (P,) largest of all meshes [N], mesh : (P,) which.  label : of the largest amplitude of all speeds.
    labels : (P,) of that at each speed; lines of several tones may have one frequency, 12 x of one and 8 x of another.
    """

    order: float
    label: str
    amplitude: Array
    mesh: list[str]
    labels: list[str]


class Crest(NamedTuple):
    """A largest amplitude along a ray: at mesh frequency x, frequency y [Hz], amplitude [N]."""

    x: float
    y: float
    amplitude: float
    label: str
    mesh: str


def waterfall(sweep: xr.Dataset, modes: xr.Dataset | None = None, *, mesh: str | None = None) -> go.Figure:
    """Amplitudes of the mesh force [kN] over mesh frequency and frequency [Hz], and the strongest resonances.

    Parameters
    ----------
    sweep : Dataset of `sweep`: mesh_force_order (mesh, order, speed) [N], mesh_force_line (mesh, line, speed) where
        there are lines, line_order (line), mesh_tone (mesh), mesh_frequency (speed) [Hz].
    modes : Dataset of `modes`, whose frequencies (mode) are drawn as lines.
    mesh : the mesh shown, the largest amplitude of all where not said.
    """
    x, unit = abscissa(sweep)
    every = rays(sweep if mesh is None else sweep.sel(mesh=[mesh]))
    top = max((float(np.nanmax(ray.amplitude, initial=0.0)) for ray in every), default=0.0)
    strong = sorted(every, key=lambda ray: -float(np.nanmax(ray.amplitude, initial=0.0)))[:_LINES]
    shown = [ray for ray in strong if float(np.nanmax(ray.amplitude, initial=0.0)) > _LEAST * top]
    # the axis ends above the natural frequencies, or what is strong
    loud = [float(np.max(ray.order * x[ray.amplitude > 0.03 * top], initial=0.0)) for ray in shown]
    groups = mode_groups(modes) if modes is not None else []
    reach, above = max([1.0, *loud]), 1.15 * max((one.frequency for one in groups), default=np.inf)
    highest = 1.08 * min(reach, above)
    strongest = crests(shown, x, modes, highest=highest)
    layers: list[Layer] = [curve for ray in shown for curve in _ray_curves(ray, x, top, highest)]
    layers += [kind_mark(one.kind, y=one.frequency, alpha=0.6) for one in groups if 0 < one.frequency <= highest]
    if strongest:
        at = ([one.x for one in strongest], [one.y for one in strongest])
        ring: Trace = {"symbol": "circle-open", "outline": 2, "colour": INK, "hover": "%{text}"}
        said = [f"{one.label}, {one.mesh}" for one in strongest]
        layers.append(points(*at, 16, name="strongest resonances", text=said, **ring))
    run = (float(x.min()), float(x.max())) if len(x) else None
    panel = Panel([*layers, *operating_mark(sweep, x)], x=unit, y="frequency [Hz]", x_ends=run, y_ends=(0, highest))
    title = "Order spectrum of the mesh forces over speed" + (f": {mesh}" if mesh else "")
    layout: Trace = {"margin": {"r": 130, "t": 70}, "legend": level_legend(-0.14), "showlegend": True}
    drawn = chart(title, panel, height=620, coloraxis=_scale(top), **layout)
    _name_crests(drawn, strongest, x, highest)
    return drawn


def rays(sweep: xr.Dataset) -> list[Ray]:
    """Every line of the spectrum over the largest of the meshes, lines of one frequency as one, orders rising."""
    names = texts(sweep, "mesh")
    found: dict[float, list[tuple[str, str, Array]]] = {}
    for order, label, rows, meshes in _lines(sweep):
        own = found.setdefault(round(order, 9), [])
        own += [(label, names[mesh], row) for mesh, row in zip(meshes, rows, strict=True)]
    return [_ray(order, same) for order, same in sorted(found.items())]


def _ray(order: float, same: list[tuple[str, str, Array]]) -> Ray:
    """Lines of one order, their label, mesh and amplitude (P,) [N]: the largest of them at every speed."""
    values = np.stack([amplitude for *_, amplitude in same])
    best = np.where(np.isnan(values), -1.0, values).argmax(axis=0)
    amplitude = values[best, np.arange(values.shape[1])]
    labels, mesh = [same[i][0] for i in best], [same[i][1] for i in best]
    strongest = int(np.nan_to_num(amplitude, nan=-1.0).argmax()) if labels else 0
    label = labels[strongest] if labels else same[0][0]
    return Ray(order=order, label=label, amplitude=amplitude, mesh=mesh, labels=labels)


def _lines(sweep: xr.Dataset) -> Iterator[tuple[float, str, Array, NDArray[np.int64]]]:
    """Order, label, amplitudes (k, P) and which meshes they are of (k,), line by line."""
    if "mesh_force_order" in sweep.variables:
        values = sweep["mesh_force_order"].transpose("order", "mesh", "speed").values
        tones = own_tones(sweep)
        stages = [name.split("/")[0] for name in texts(sweep, "mesh")]
        for tone in dict.fromkeys(tones.tolist()):
            own = np.flatnonzero(tones == tone)
            where = f" {stages[own[0]]}" if len(set(tones.tolist())) > 1 else ""
            for order, rows in zip(numbers(sweep, "order"), values, strict=True):
                yield order * tone, f"{order:g}×{where} mesh", rows[own], own
    if "mesh_force_line" in sweep.variables:
        values = sweep["mesh_force_line"].transpose("line", "mesh", "speed").values
        for order, label, rows in zip(numbers(sweep, "line_order"), texts(sweep, "line"), values, strict=True):
            # a multiple of one mesh frequency that a mesh of another has is named as that of its own meshes
            yield order, re.sub(r"^\+(\d+) ((?:\S+ )?mesh)$", r"\1× \2", label), rows, np.arange(len(rows))


def crests(shown: list[Ray], x: Array, modes: xr.Dataset | None = None, *, highest: float | None = None) -> list[Crest]:
    """The strongest local maxima along the rays over mesh frequency x (P,) [Hz], the strongest first.

    Where rings would lie on each other the strongest has it.

    modes : Dataset of `modes`; only maxima within 5 % of a natural frequency count then.
    highest : end of the axis of frequencies [Hz]; maxima beyond it are left out.
    """
    natural = np.array([one.frequency for one in mode_groups(modes)]) if modes is not None else None
    found = []
    rank = np.argsort(x)
    for ray in shown:
        values = np.nan_to_num(ray.amplitude[rank], nan=0.0)
        inner = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1
        for place in rank[inner]:
            at, value = float(x[place]), float(ray.amplitude[place])
            if natural is None or np.any(np.abs(natural - ray.order * at) < 0.05 * natural):
                found.append(Crest(at, ray.order * at, value, ray.labels[place], ray.mesh[place]))
    within = [one for one in found if highest is None or one.y <= highest]
    wide, tall = float(np.ptp(x)) if len(x) else 0.0, highest or max((one.y for one in within), default=0.0)
    kept: list[Crest] = []
    for one in sorted(within, key=lambda crest: -crest.amplitude):
        covered = any(abs(one.x - it.x) < _RING[0] * wide and abs(one.y - it.y) < _RING[1] * tall for it in kept)
        if len(kept) < _MARKS and not covered:
            kept.append(one)
    return kept


def _ray_curves(ray: Ray, x: Array, top: float, highest: float) -> list[Curve]:
    """A thin line along x (P,) [Hz], and marks where there is something, larger and darker with the amplitude."""
    ends = np.array([x.min(), x.max()])
    line = Curve(ends, ray.order * ends, colour=GRID, width=1, hover=None)
    there = [i for i in np.argsort(x) if ray.amplitude[i] > _LEAST * top and ray.order * x[i] <= highest]
    if not there:
        return [line]
    size = np.log10(ray.amplitude[there] / (_LEAST * top)) / -np.log10(_LEAST)
    colours = compact(np.log10(ray.amplitude[there] / 1e3), digits=4)
    marker = {"color": colours, "coloraxis": "coloraxis", "line": {"width": 0}}
    hover = "%{customdata[2]}: %{customdata[0]} kN, %{customdata[1]}<br>%{y:.5g} Hz at %{x:.5g} Hz"
    data = [[engineering(float(ray.amplitude[i]) / 1e3), ray.mesh[i], ray.labels[i]] for i in there]
    look = {"marker": marker, "customdata": data}
    return [line, points(x[there], ray.order * x[there], compact(2 + 7 * size, digits=2), hover=hover, look=look)]


def _scale(top: float) -> dict[str, object]:
    """Colours of the logarithm of the amplitude, ticks in kN."""
    high = np.log10(top / 1e3) if top > 0 else 0.0
    low = high + np.log10(_LEAST)
    # 1, 2, 5 of every decade; 1 alone where these are too many
    decades = range(int(np.floor(low)), int(np.ceil(high)) + 1)
    fine = [step * 10.0**decade for decade in decades for step in (1, 2, 5)]
    ticks = [tick for tick in fine if low <= np.log10(tick) <= high]
    if len(ticks) > 10:
        ticks = [tick for tick in ticks if np.isclose(np.log10(tick) % 1, 0)]
    bar = {"title": {"text": "amplitude [kN]", "side": "right"}, "len": 0.9, "thickness": 14}
    bar["tickvals"] = [float(np.log10(tick)) for tick in ticks]
    bar["ticktext"] = [engineering(tick) for tick in ticks]
    return {"colorscale": _COLOURS, "cmin": float(low), "cmax": float(high), "colorbar": bar}


def _name_crests(drawn: go.Figure, shown: list[Crest], x: Array, highest: float) -> None:
    """Names of the strongest resonances within x (P,) [Hz], each at a place of its own."""
    words = [f"{_short(one.label)}: {engineering(one.amplitude / 1e3, 3)} kN" for one in shown]
    rings = [((one.x - float(x.min())) / max(float(np.ptp(x)), 1e-300), one.y / highest) for one in shown]
    for one, text, (right, up) in zip(shown, words, label_places(rings, [len(text) for text in words]), strict=True):
        arrow = {"ax": right * _AREA[0], "ay": -up * _AREA[1], "showarrow": True, "standoff": 8}
        look = {"arrowhead": 0, "arrowwidth": 1, "arrowcolor": PALE, "bgcolor": "rgba(255,255,255,0.75)"}
        anchors = {"xanchor": "center", "yanchor": "middle", "font": {"size": 12, "color": INK}}
        note(drawn, text, x=one.x, y=one.y, **arrow, **look, **anchors)


def label_places(rings: list[tuple[float, float]], letters: list[int]) -> list[tuple[float, float]]:
    """Where names of rings stand, off the other names and all rings: middle of each less that of its ring.

    Parameters
    ----------
    rings : place (right, up) of each in parts of the plot.  letters : of each name.
    """
    taken = [(right, up, *_RING) for right, up in rings]
    found = []
    for (right, up), count in zip(rings, letters, strict=True):
        wide, tall = count * _LETTER[0], _LETTER[1]
        reach = wide / 2 + _RING[0] / 2 + 0.01
        rises = [sign * step for step in range(1, 7) for sign in (-1, 1)]
        ways = [(side * reach, rise * tall * 1.2) for rise in rises for side in (1, -1, 0)]
        ends = ((1 - wide) / 2, (1 - tall) / 2)
        inside = [way for way in ways if abs(right + way[0] - 0.5) <= ends[0] and abs(up + way[1] - 0.5) <= ends[1]]
        free = [(dx, dy) for dx, dy in inside if has_room((right + dx, up + dy, wide, tall), taken)]
        way = (free or inside or ways)[0]
        found.append(way)
        taken.append((right + way[0], up + way[1], wide, tall))
    return found


def _short(label: str) -> str:
    """A label that fits beside a mark: causes cut to their ends."""
    cause, _, rest = label.partition(" ")
    if "." not in cause:
        return label
    return ".".join(cause.rstrip(";").split(".")[-2:]) + (f" {rest}" if rest and ";" not in label else "")


# kind of instability: colour and what it means
_KINDS = {
    "quasi-periodic": (PALETTE[1], "quasi-periodic: two modes together"),
    "period doubling": (PALETTE[3], "period doubling: half mesh orders"),
    "divergence": (PALETTE[6], "divergence: mesh orders"),
}
_LABELS = 8
_CURVES = 24
# part of the colour bar below zero
_DECAYS = 0.08


def _named(order: np.ndarray, centre: Array, distance: float, x: Array) -> list[int]:
    """The first few places in order (r,) whose centres (r,) stand `distance` apart within x (P,), all [Hz]."""
    return kept_apart(centre, [i for i in order if x.min() <= centre[i] <= x.max()], distance, _LABELS)


def stability_over_speed(result: xr.Dataset) -> go.Figure:
    """Largest Floquet multiplier [1] and growth rate [1/s] over mesh frequency [Hz], unstable speeds in colour.

    Ranges predicted by averaging are bands.

    Parameters
    ----------
    result : Dataset of `stability` without a second parameter: largest_multiplier, growth_rate, instability,
        taking_part, mesh_frequency (speed), resonance_low, resonance_high, resonance_growth (resonance).
    """
    x = numbers(result, "mesh_frequency")
    rank = np.argsort(x)
    kind, taking = (np.array(texts(result, name))[rank] for name in ("instability", "taking_part"))
    panels = []
    limits = (("largest_multiplier", "largest |μ| [-]", 1.0), ("growth_rate", "growth rate [1/s]", 0.0))
    for variable, words, limit in limits:
        values = numbers(result, variable)[rank]
        layers: list[Layer] = [Curve(x[rank], values, colour=PALE, width=1.6), Mark(y=limit, dash="dash")]
        for name, (colour, meaning) in _KINDS.items():
            at = kind == name
            look: Trace = {"colour": colour, "text": taking[at], "hover": "%{x:.5g} Hz: %{y:.4g}<br>%{text}"}
            layers += [points(x[rank][at], values[at], name=meaning, **look)] if at.any() else []
        panels.append(Panel(layers, y=words))
    layout: Trace = {"x": "mesh frequency [Hz]", "marks": _bands(result), "gap": 0.06, "showlegend": True}
    drawn = chart(stability_verdict(kind, "speeds"), *panels, height=560, **layout)
    _name_bands(drawn, result, x)
    return drawn


def _bands(result: xr.Dataset) -> list[Mark]:
    """Predicted ranges as bands behind."""
    low, high = (numbers(result, f"resonance_{name}") for name in ("low", "high"))
    look: Trace = {"colour": translucent(WARNING, 0.10), "name": "predicted (averaging)"}
    return [Mark(x=float(one), to=float(other), **look) for one, other in zip(low, high, strict=True)]


def _name_bands(drawn: go.Figure, result: xr.Dataset, x: Array) -> None:
    """Names of the fastest growing of the predicted ranges, within x (P,) [Hz], which is the abscissa then."""
    rate = numbers(result, "resonance_growth")
    if not rate.size:
        return
    names, centre = texts(result, "resonance"), numbers(result, "resonance_centre")
    drawn.update_xaxes(range=[float(x.min()), float(x.max())])
    for place in _named(np.argsort(-rate), centre, (x.max() - x.min()) / 14, x):
        where = {"xref": "x", "yref": "y domain", "xanchor": "left", "yanchor": "bottom"}
        note(drawn, names[place], x=centre[place], y=1.0, textangle=-25, **where)


def stability_map(result: xr.Dataset) -> go.Figure:
    """Growth rate [1/s] over mesh frequency [Hz] and a parameter, with predicted boundaries as lines.

    Parameters
    ----------
    result : Dataset of `stability` with a second parameter: growth_rate, instability (value, speed),
        mesh_frequency (speed) [Hz], resonance_low, resonance_high (value, resonance) [Hz].
    """
    x, name = numbers(result, "mesh_frequency"), str(result.attrs.get("over", "value"))
    unit = str(result["value"].attrs.get("units", ""))
    texted = result["value"].dtype.kind not in "fiu"
    y = np.arange(result.sizes["value"], dtype=float) if texted else numbers(result, "value")
    rate = result["growth_rate"].transpose("value", "speed").values
    kind = result["instability"].transpose("value", "speed").values.astype(str)
    ordinate = f"{name} [{unit}]" if unit else name
    layers = [_cells(x, y, rate, np.isin(kind, list(_KINDS))), *_boundaries(result, y)]
    ticks = {"tickvals": list(y), "ticktext": texts(result, "value")} if texted else {}
    ends: Trace = {"x_ends": (float(x.min()), float(x.max()))}
    ends |= {"y_ends": (float(y.min()), float(y.max()))} if len(y) > 1 else {}
    axes: Trace = {"x_axis": {"showgrid": False}, "y_axis": {"showgrid": False, **ticks}}
    panel = Panel(layers, x="mesh frequency [Hz]", y=ordinate, **ends, **axes)
    verdict = stability_verdict(kind, "points")
    drawn = chart(verdict, panel, height=520, showlegend=True, legend=level_legend(-0.18))
    _name_boundaries(drawn, result, y)
    return drawn


def _cells(x: Array, y: Array, rate: Array, grows: np.ndarray) -> Heat:
    """Growth rate (values, P) [1/s] over x (P,) [Hz] and y (values,): pale where it decays, blank where it failed."""
    top = float(np.max(rate[grows], initial=0.0)) or 1.0
    shown = np.where(np.isfinite(rate), np.where(grows, rate, -_DECAYS * top), np.nan)
    edge = _DECAYS / (1 + _DECAYS)
    colours = [[0, "#E4EEF7"], [edge, "#E4EEF7"], [edge, "#FDE3C8"], [0.5 + edge / 2, PALETTE[1]], [1, "#7A1F00"]]
    bar = {
        "title": {"text": "growth rate [1/s]", "side": "right"},
        "tickvals": [-_DECAYS * top / 2, top / 4, top / 2, top],
        "ticktext": ["decays", *(engineering(value * top, 3) for value in (0.25, 0.5, 1.0))],
        "len": 0.9,
    }
    look: Trace = {"zmin": -_DECAYS * top, "zmax": top, "colorscale": colours, "colorbar": bar}
    look["customdata"] = [compact(row) for row in rate]
    hover = "%{x:.5g} Hz, %{y:.4g}: %{customdata:.4g} 1/s"
    return Heat(x, y, shown, digits=(7, 5), hover=hover, look=look)


def _ranges(result: xr.Dataset) -> tuple[Array, Array, NDArray[np.int64]]:
    """Both ends (value, resonance) [Hz] of every predicted range, and which are the widest."""
    low, high = (result[f"resonance_{name}"].transpose("value", "resonance").values for name in ("low", "high"))
    return low, high, np.argsort(-np.nansum(high - low, axis=0), kind="stable")[:_CURVES]


def _boundaries(result: xr.Dataset, y: Array) -> list[Curve]:
    """Both ends [Hz] of every predicted range over the parameter y (values,), one line that turns where it closes."""
    low, high, order = _ranges(result)
    names, curves = texts(result, "resonance"), []
    for place, one in enumerate(order):
        look: Trace = {"colour": INK, "width": 1.3, "dash": "solid" if place < _LABELS else "dot", "digits": (7, 7)}
        xs, ys = _outline(low[:, one], high[:, one], y)
        hover = f"{names[one]}: %{{x:.5g}} Hz"
        curves.append(Curve(xs, ys, name="predicted boundary (averaging)", hover=hover, **look))
    return curves


def _name_boundaries(drawn: go.Figure, result: xr.Dataset, y: Array) -> None:
    """Names of the widest predicted ranges, at the top of the map or where the range closes below it."""
    low, high, order = _ranges(result)
    x, names = numbers(result, "mesh_frequency"), texts(result, "resonance")
    centre = np.nanmean((low + high) / 2, axis=0) if len(names) else np.zeros(0)
    for one in _named(order, centre, (x.max() - x.min()) / 10, x):
        inside = np.flatnonzero(np.isfinite(low[:, one]))
        closes = inside[-1] < len(y) - 1 and inside.size > 1
        font = {"size": 12, "color": INK if closes else PALE}
        note(drawn, names[one], x=centre[one], y=float(y[inside[-1]]), yanchor="bottom", font=font)


def _outline(low: Array, high: Array, y: Array) -> tuple[Array, Array]:
    """Up the lower and down the upper ends (values,) [Hz] of each run of values at which a range is open."""
    open_, ends = np.isfinite(low), [np.zeros((2, 0))]
    for run in np.split(np.arange(len(y)), np.flatnonzero(open_[1:] != open_[:-1]) + 1):
        if open_[run[0]]:
            # an edge of the map is no end of the range: the line begins and ends there
            way = 1 if run[0] == 0 and run[-1] < len(y) - 1 else -1
            down, up = (np.array([end[run], y[run]]) for end in (low, high))
            ends += [down[:, ::way], up[:, ::-way], np.full((2, 1), np.nan)]
    xs, ys = np.hstack(ends)
    return xs, ys
