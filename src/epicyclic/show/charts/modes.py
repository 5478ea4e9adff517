"""Natural frequencies: as stems, over the speed, along a number of the model; and where the energy of each mode sits.

Stems have the frequency as height, the kind as colour and marker, the multiplicity as a number.  The Campbell diagram
has rays of the mesh orders and where they cross; loci have their crossings and veerings marked.  Strain energy by
connection and kinetic energy by body are two heat maps.
"""

from __future__ import annotations

import json
from itertools import product
from typing import NamedTuple

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import (
    Array,
    Box,
    ModeGroup,
    engineering,
    grouped,
    has_room,
    kept_apart,
    mesh_tones,
    mode_groups,
    numbers,
    summed_shares,
    texts,
)
from .renderers import (
    BESIDE,
    DASHES,
    INK,
    OPERATING_BAND,
    PALE,
    SPEED_TITLE,
    WARNING,
    Curve,
    Heat,
    Layer,
    Mark,
    Panel,
    Stems,
    Trace,
    beside,
    chart,
    level_legend,
    mode_colour,
    mode_symbol,
    note,
    points,
)

# Width of the plot on the narrowest page that names must have room on, 900 px with the names of tones beside it.
_NARROW = 590.0  # [px]
_SHARE_COLOURS = [[0.0, "#FFFFFF"], [0.15, "#DCE9F5"], [0.4, "#8FBCE0"], [0.7, "#3B86C2"], [1.0, "#0B4F86"]]
# Width of a letter of 12 px in parts of a plot of 800 px.
_LETTER = 0.0085
# Height of a line of text of 11 px, 16 px, in parts of a plot of 400 px.
_LINE = 0.042
_EVENT_MARKS = {"crossing": ("circle-open", INK, "crossing"), "veering": ("diamond", WARNING, "veering")}


def frequencies(modes: xr.Dataset, check: xr.Dataset | None = None) -> go.Figure:
    """Natural frequencies [Hz] as stems over the number of the mode, with kind and multiplicity.

    Parameters
    ----------
    modes : Dataset of `modes`: frequency [Hz], mode_kind, multiplicity (mode).
    check : Dataset of `check`: mesh_frequency (stage) [Hz].
    """
    found = mode_groups(modes)
    top = max((one.frequency for one in found), default=1.0)
    last = found[-1].first if found else 1
    named = _named(found, last, top) if len(found) <= 36 else set()
    kinds = grouped((one.kind for one in found), found)
    stems: list[Layer] = [_stems(own, kind, named) for kind, own in kinds.items()]
    tones = mesh_tones(check)
    longest = max((len(f"{stage} mesh 0000 Hz") if len(tones) > 1 else 15 for stage in tones), default=15)
    panel = Panel(
        [*stems, *_tones(tones, top)],
        x="mode",
        y="natural frequency [Hz]",
        x_ends=(0.2, last + 0.8),
        y_ends=(0, 1.12 * top),
        x_axis={"showgrid": False, "dtick": 1 if last <= 40 else 5},
    )
    layout: Trace = {"margin": {"r": beside(longest)}, "legend": level_legend(-0.18), "showlegend": True}
    return chart("Natural frequencies", panel, height=440, **layout)


def _named(found: list[ModeGroup], last: int, top: float) -> set[int]:
    """First modes whose numbers find room above their heads, from the lowest on; `last` modes up to `top` [Hz]."""
    right, up = _NARROW / max(last, 1), 300.0 / (1.12 * top or 1.0)  # [px] a mode and a hertz
    boxes: list[Box] = []
    named = set()
    for one in found:
        wide, tall = 5.3 * len(engineering(one.frequency)) + 2, 26.0 if one.multiplicity > 1 else 13.0
        box = (one.first * right, one.frequency * up + tall / 2, wide, tall)
        if has_room(box, boxes):
            boxes.append(box)
            named.add(one.first)
    return named


def _stems(own: list[ModeGroup], kind: str, named: set[int]) -> Stems:
    """Stems of the modes of one kind with their heads, the frequency above those that are named."""
    words = [engineering(one.frequency) + (f"<br>×{one.multiplicity}" if one.multiplicity > 1 else "") for one in own]
    above = {"textposition": "top center", "textfont": {"size": 9}, "cliponaxis": False}
    return Stems(
        [one.first for one in own],
        [one.frequency for one in own],
        name=kind or "mode",
        group=kind,
        colour=mode_colour(kind),
        width=2,
        points=10,
        symbol=mode_symbol(kind),
        text=[text if one.first in named else "" for one, text in zip(own, words, strict=True)],
        hover=f"mode %{{x}}: %{{y:.5g}} Hz<extra>{kind}</extra>",
        look={"mode": "markers+text" if named else "markers", **above},
    )


def _tones(tones: dict[str, float], top: float) -> list[Mark]:
    """Mesh frequencies and their harmonics; those left out whose names would lie on another."""
    every = [(harmonic, stage, harmonic * tones[stage]) for harmonic in range(1, 6) for stage in tones]
    within, marks = [one for one in every if one[2] <= top], []
    for place in kept_apart([hertz for *_, hertz in within], range(len(within)), 0.06 * top):
        harmonic, stage, hertz = within[place]
        name = f"{stage} mesh" if len(tones) > 1 else "mesh"
        words = f"{harmonic}× {name}" if harmonic > 1 else f"{name} {engineering(hertz)} Hz"
        look: Trace = {"colour": PALE, "width": 1, "dash": "dot", "below": True}
        marks.append(Mark(y=hertz, words=words, where={**BESIDE, "y": hertz}, **look))
    return marks


def energy_shares(modes: xr.Dataset) -> go.Figure:
    """Strain-energy shares of the connections and kinetic-energy shares of the bodies [%] in the 40 lowest modes.

    Parameters
    ----------
    modes : Dataset of `modes`: strain_energy_share (connection, mode), kinetic_energy_share (body, mode) [1],
        frequency (mode) [Hz].
    """
    shown = modes.isel(mode=slice(0, 40))
    strain, kinetic = (
        summed_shares(texts(shown, dim), shown[f"{name}_energy_share"].transpose(dim, "mode").values)
        for name, dim in (("strain", "connection"), ("kinetic", "body"))
    )
    hertz = [engineering(float(value)) for value in numbers(shown, "frequency")]
    named = {"text": "share [%]", "side": "right", "font": {"size": 13}}
    bar = {"title": named, "thickness": 14, "outlinewidth": 0, "tickfont": {"size": 12}}
    scale = {"colorscale": _SHARE_COLOURS, "cmin": 0, "cmax": 100, "colorbar": bar}
    ticks: Trace = {"tickmode": "array", "tickvals": list(range(len(hertz))), "tickangle": -90, "showgrid": False}
    ticks["ticktext"] = [f"{mode}: {text}" for mode, text in enumerate(hertz, 1)]
    maps = list[Panel]()
    energies = {"strain energy of the connections": strain, "kinetic energy of the bodies": kinetic}
    for words, (names, shares) in energies.items():
        percent = np.round(100 * shares, 1)
        look: Trace = {"texttemplate": "%{text}", "textfont": {"size": 10}, "coloraxis": "coloraxis"}
        look |= {"xgap": 1, "ygap": 1, "customdata": [hertz] * len(names)}
        said = [[f"{value:.0f}" if value >= 4.5 else "" for value in values] for values in percent]
        hover = "%{y}: %{z:.1f} %<br>mode at %{customdata} Hz"
        heat = Heat(range(len(hertz)), names, percent, text=said, hover=hover, look=look)
        x_axis = {**ticks, "showticklabels": bool(maps)}
        maps.append(Panel([heat], title=words, x_axis=x_axis, y_axis={"autorange": "reversed", "showgrid": False}))
    count = len(strain[0]) + len(kinetic[0])
    space = {"row_heights": [len(strain[0]) / count, len(kinetic[0]) / count]}
    layout: Trace = {"height": 240 + 26 * count, "gap": min(0.3, 64 / (100 + 26 * count)), "coloraxis": scale}
    title = "Where the energy of each mode sits"
    return chart(title, *maps, x="mode: natural frequency [Hz]", space=space, **layout)


class ResonanceCrossing(NamedTuple):
    """A mesh order meets a natural frequency: relative speed, frequency [Hz], order, stage, mode (from 1)."""

    relative_speed: float
    frequency: float
    order: int
    stage: str
    mode: int


def campbell(data: xr.Dataset) -> go.Figure:
    """Campbell diagram: natural frequencies [Hz] over speed [% of the operating speed], rays of mesh orders.

    Parameters
    ----------
    data : Dataset of `campbell`: whirl_frequency (relative_speed, mode) [Hz], mesh_frequency ([stage,] relative_speed).
        Mesh orders are drawn that reach the highest natural frequency, but 3 to 8.
    """
    speed, whirl, rays = _arrays(data)
    percent = 100 * speed
    highest, fastest = float(np.nanmax(whirl, initial=1.0)), max((float(ray.max()) for ray in rays.values()), default=0)
    count = int(np.clip(np.ceil(highest / fastest) if fastest > 0 else 3, 3, 8))
    top = 1.05 * min(highest, 1.3 * count * fastest) if fastest > 0 else 1.05 * highest
    layers: list[Layer] = [OPERATING_BAND, Mark(x=100, width=1.5)] if percent[0] <= 100 <= percent[-1] else []
    kinds = texts(data, "mode_kind") if "mode_kind" in data.variables else [""] * whirl.shape[1]
    for kind in dict.fromkeys(kinds):
        curves = whirl[:, [own == kind for own in kinds]].T
        gap = np.full((len(curves), 1), np.nan)  # between two modes
        x = np.hstack([np.tile(percent, (len(curves), 1)), gap])
        words = f"{kind} modes" if kind else "natural frequencies"
        layers.append(Curve(x, np.hstack([curves, gap]), name=words, colour=mode_colour(kind), hover=None))
    for place, ray in enumerate(rays.values()):
        for order in range(1, count + 1):  # as far as the diagram reaches
            within = np.where(order * ray <= 1.2 * top, order * ray, np.nan)
            layers.append(Curve(percent, within, colour=PALE, width=1.3, dash=DASHES[1 + place % 3], hover=None))
    found = [one for one in crossings(data, orders=count) if one.frequency <= top]
    said = [
        f"mode {one.mode} at {engineering(one.frequency)} Hz<br>{one.order}× {one.stage}"
        f"<br>{engineering(100 * one.relative_speed)} % of the operating speed"
        for one in found
    ]
    if found:
        at = ([100 * one.relative_speed for one in found], [one.frequency for one in found])
        ring: Trace = {"symbol": "circle-open", "outline": 2, "colour": WARNING, "text": said, "hover": "%{text}"}
        layers.append(points(*at, 10, name="a mesh order meets a natural frequency", **ring))
    run = (float(percent[0]), float(percent[-1]))
    panel = Panel(layers, x=SPEED_TITLE, y="frequency [Hz]", x_ends=run, y_ends=(0, top))
    drawn = chart("Campbell diagram", panel, height=600, legend=level_legend(-0.14))
    _ray_names(drawn, rays, percent, count=count, top=top)
    return drawn.update_layout(margin={"r": beside(_mode_names(drawn, whirl[-1], top)), "t": 60})


def _mode_names(drawn: go.Figure, hertz: Array, top: float) -> int:
    """Modes and their frequencies (modes,) [Hz] at full speed beside the diagram; letters of the longest name.

    Modes closer than a line of text share one: the first and the last of them.
    """
    groups: list[list[int]] = []
    for mode in np.argsort(hertz):
        if not 0 < hertz[mode] <= top:
            continue
        if groups and hertz[mode] - hertz[groups[-1][0]] < _LINE * top:
            groups[-1].append(int(mode))
        else:
            groups.append([int(mode)])
    longest = 0
    for own in groups:
        ends = sorted({own[0] + 1, own[-1] + 1})
        words = f"mode{'s' if len(ends) > 1 else ''} {'–'.join(map(str, ends))}: {engineering(float(hertz[own[0]]))} Hz"
        note(drawn, words, **BESIDE, y=float(hertz[own[0]]), font={"size": 11, "color": PALE})
        longest = max(longest, len(words))
    return longest


def crossings(data: xr.Dataset, *, orders: int = 3) -> list[ResonanceCrossing]:
    """Where the rays of the mesh orders meet the natural frequencies, between speeds interpolated linearly."""
    speed, whirl, rays = _arrays(data)
    found = []
    for (stage, ray), order, mode in product(rays.items(), range(1, orders + 1), range(whirl.shape[1])):
        distance = whirl[:, mode] - order * ray
        for at in np.flatnonzero((distance[:-1] * distance[1:] < 0) | (distance[1:] == 0)):
            share = distance[at] / (distance[at] - distance[at + 1])
            met = float(speed[at] + share * (speed[at + 1] - speed[at]))
            hertz = float(whirl[at, mode] + share * (whirl[at + 1, mode] - whirl[at, mode]))
            found.append(ResonanceCrossing(met, hertz, order, stage, mode + 1))
    return found


def _arrays(data: xr.Dataset) -> tuple[Array, Array, dict[str, Array]]:
    speed = numbers(data, "relative_speed")
    rank = np.argsort(speed)
    whirl = data["whirl_frequency"].transpose("relative_speed", "mode").values[rank]
    if "mesh_frequency" not in data.variables:
        return speed[rank], whirl, {}
    tones = data["mesh_frequency"]
    if "stage" not in tones.dims:
        return speed[rank], whirl, {"mesh": tones.values[rank]}
    values = tones.transpose("stage", "relative_speed").values[:, rank]
    names = texts(data, "stage")
    rays = {f"{name} mesh" if len(names) > 1 else "mesh": row for name, row in zip(names, values, strict=True)}
    return speed[rank], whirl, rays


def _ray_names(drawn: go.Figure, rays: dict[str, Array], percent: Array, *, count: int, top: float) -> None:
    """Names of the rays (P,) [Hz] on them, near where they leave the diagram over speed (P,) [%].

    Those are left out that would lie on another.
    """
    taken: list[Box] = []
    wide, tall = float(np.ptp(percent)), 1.2 * _LINE * top
    for stage, ray in rays.items():
        for order in range(1, count + 1):
            name = f"{order}× {stage}"
            across = 1.1 * _LETTER * len(name) * wide
            end = min(float(percent[-1]) - across / 2, float(np.interp(top, order * ray, percent)))
            for x in (share * end for share in (0.95, 0.85, 0.75, 0.65)):  # of the way to the end, until there is room
                y = order * float(np.interp(x, percent, ray))
                if has_room((x, y, across, tall), taken):
                    note(drawn, name, x=x, y=y, font={"size": 11, "color": INK}, bgcolor="rgba(255,255,255,0.85)")
                    taken.append((x, y, across, tall))
                    break


def loci(data: xr.Dataset, *, most: int = 24) -> go.Figure:
    """Natural frequencies [Hz] over a number of the model file, a curve a mode in the colour of its kind.

    Parameters
    ----------
    data : Dataset of `track`: frequency (mode, parameter) [Hz], mode_kind, multiplicity (mode), event_kind,
        event_value, event_frequency, event_gap, veering_index, event_first, event_second (event).
    most : loci shown at most, the lowest.
    """
    options = json.loads(str(data.attrs["options"]))
    unit = f" [{options['unit']}]" if options["unit"] else ""
    x = numbers(data, "parameter")
    hertz = data["frequency"].transpose("mode", "parameter").values[:most]
    kinds, multiple = texts(data, "mode_kind"), data["multiplicity"].values
    layers: list[Layer] = []
    for place, row in enumerate(hertz):
        if row.max() > 0:
            look: Trace = {"colour": mode_colour(kinds[place]), "width": 2.6 if multiple[place] > 1 else 1.5}
            hover = f"mode {place + 1}, {kinds[place]}: %{{y:.5g}} Hz"
            layers.append(Curve(x, row, name=f"{kinds[place]} mode", hover=hover, **look))
    top = 1.04 * float(np.nanmax(hertz, initial=1.0))
    layers += [mark for kind in _EVENT_MARKS for mark in _events(data, kind, top)]
    if x.min() <= float(options["value"]) <= x.max():
        layers.append(Mark(x=float(options["value"]), dash="dot", name="value in the model", group="events"))
    wide = x.min() > 0 and x.max() / x.min() > 10
    axis = {"type": "log" if wide else "linear", "exponentformat": "e"}
    panel = Panel(layers, x=f"{options['over']}{unit}", y="frequency [Hz]", x_axis=axis, y_ends=(0, top))
    return chart(f"Natural frequencies over {options['over']}", panel, height=560)


def _events(data: xr.Dataset, kind: str, top: float) -> list[Curve]:
    """Crossings or veerings of the loci up to a frequency [Hz]."""
    symbol, colour, words = _EVENT_MARKS[kind]
    frequency, where = numbers(data, "event_frequency"), numbers(data, "event_value")
    chosen = [i for i, text in enumerate(texts(data, "event_kind")) if text == kind and frequency[i] <= top]
    gap, index = numbers(data, "event_gap"), numbers(data, "veering_index")
    first, second = texts(data, "event_first"), texts(data, "event_second")
    said = [
        f"modes {first[i]} and {second[i]}"
        + (f": gap {engineering(gap[i])} Hz, index {index[i]:.2f}" if kind == "veering" else "")
        for i in chosen
    ]
    look: Trace = {"symbol": symbol, "colour": colour, "look": {"marker": {"line": {"width": 2, "color": colour}}}}
    look |= {"text": said, "hover": f"{words} at %{{x:.5g}}, %{{y:.5g}} Hz<br>%{{text}}", "digits": (9, 9)}
    return [points(where[chosen], frequency[chosen], 11, name=words, group="events", **look)] if chosen else []
