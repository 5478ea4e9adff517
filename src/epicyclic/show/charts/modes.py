"""Natural frequencies: as stems, over the speed, along a number of the model; and where the energy of each mode sits.

Stems have the frequency as height, the kind as colour and marker, the multiplicity as a number.  The Campbell diagram
has rays of the mesh orders and where they cross; loci have their crossings and veerings marked.  Strain energy by
connection and kinetic energy by body are two heat maps.
"""

from __future__ import annotations

import json
from typing import Any, NamedTuple

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..series import Array, ModeGroup, engineering, mesh_tones, mode_groups, numbers, summed_shares, texts
from .style import (
    DASHES,
    INK,
    PALE,
    SPEED_TITLE,
    WARNING,
    add_curve,
    add_key,
    add_operating_band,
    beside,
    figure,
    level_legend,
    mode_colour,
    mode_symbol,
    note,
    panels,
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
    drawn = figure("Natural frequencies", x="mode", y="natural frequency [Hz]", height=440)
    top = max((one.frequency for one in found), default=1.0)
    last = found[-1].first if found else 1
    named = _named(found, last, top) if len(found) <= 36 else set()
    for kind in dict.fromkeys(one.kind for one in found):
        _add_stems(drawn, [one for one in found if one.kind == kind], kind, named)
    tones = mesh_tones(check)
    _add_tones(drawn, tones, top)
    drawn.update_xaxes(range=[0.2, last + 0.8], showgrid=False, dtick=1 if last <= 40 else 5)
    drawn.update_yaxes(range=[0, 1.12 * top])
    longest = max((len(f"{stage} mesh 0000 Hz") if len(tones) > 1 else 15 for stage in tones), default=15)
    return drawn.update_layout(margin={"r": beside(longest)}, legend=level_legend(-0.18), showlegend=True)


def _named(found: list[ModeGroup], last: int, top: float) -> set[int]:
    """First modes whose numbers find room above their heads, from the lowest on; `last` modes up to `top` [Hz]."""
    right, up = _NARROW / max(last, 1), 300.0 / (1.12 * top or 1.0)  # [px] a mode and a hertz
    boxes: list[tuple[float, float, float, float]] = []
    named = set()
    for one in found:
        wide, tall = 5.3 * len(engineering(one.frequency)) + 2, 26.0 if one.multiplicity > 1 else 13.0
        x, low = one.first * right, one.frequency * up
        if all(
            abs(x - at) >= (wide + other) / 2 or low >= below + height or below >= low + tall
            for at, below, other, height in boxes
        ):
            boxes.append((x, low, wide, tall))
            named.add(one.first)
    return named


def _add_stems(drawn: go.Figure, own: list[ModeGroup], kind: str, named: set[int]) -> None:
    """Stems of the modes of one kind with their heads, the frequency above those that are named."""
    colour = mode_colour(kind)
    drawn.add_scatter(
        x=[value for one in own for value in (one.first, one.first, None)],
        y=[value for one in own for value in (0.0, one.frequency, None)],
        **{"mode": "lines", "line": {"color": colour, "width": 2}, "legendgroup": kind},
        **{"showlegend": False, "hoverinfo": "skip"},
    )
    words = [engineering(one.frequency) + (f"<br>×{one.multiplicity}" if one.multiplicity > 1 else "") for one in own]
    drawn.add_scatter(
        x=[one.first for one in own],
        y=[one.frequency for one in own],
        mode="markers+text" if named else "markers",
        marker={"color": colour, "symbol": mode_symbol(kind), "size": 10},
        text=[text if one.first in named else "" for one, text in zip(own, words, strict=True)],
        textposition="top center",
        textfont={"size": 9},
        cliponaxis=False,
        name=kind or "mode",
        legendgroup=kind,
        hovertemplate="mode %{x}: %{y:.5g} Hz<extra>" + kind + "</extra>",
    )


def _add_tones(drawn: go.Figure, tones: dict[str, float], top: float) -> None:
    """Mesh frequencies and their harmonics; those left out whose names would lie on another."""
    taken: list[float] = []
    order = [(harmonic, stage) for harmonic in range(1, 6) for stage in tones]
    for harmonic, stage in order:
        hertz = harmonic * tones[stage]
        if hertz > top or any(abs(hertz - other) < 0.06 * top for other in taken):
            continue
        name = f"{stage} mesh" if len(tones) > 1 else "mesh"
        text = f"{harmonic}× {name}" if harmonic > 1 else f"{name} {engineering(hertz)} Hz"
        drawn.add_hline(y=hertz, line={"color": PALE, "width": 1, "dash": "dot"}, layer="below")
        note(drawn, text, xref="paper", x=1.005, xanchor="left", y=hertz, yanchor="middle")
        taken.append(hertz)


def energy_shares(modes: xr.Dataset, *, most: int = 40) -> go.Figure:
    """Strain-energy shares of the connections and kinetic-energy shares of the bodies [%] in every mode.

    Parameters
    ----------
    modes : Dataset of `modes`: strain_energy_share (connection, mode), kinetic_energy_share (body, mode) [1],
        frequency (mode) [Hz].
    most : modes shown at most, the lowest.
    """
    shown = modes.isel(mode=slice(0, most))
    strain, kinetic = (
        summed_shares(texts(shown, dim), shown[f"{name}_energy_share"].transpose(dim, "mode").values)
        for name, dim in (("strain", "connection"), ("kinetic", "body"))
    )
    heights = [len(strain[0]), len(kinetic[0])]
    drawn = panels(
        "Where the energy of each mode sits",
        ["strain energy of the connections", "kinetic energy of the bodies"],
        height=240 + 26 * sum(heights),
        row_heights=[value / sum(heights) for value in heights],
        vertical_spacing=min(0.3, 64 / (100 + 26 * sum(heights))),
        shared_xaxes=True,
    )
    hertz = numbers(shown, "frequency")
    words = [engineering(float(value)) for value in hertz]
    for row, (names, shares) in enumerate((strain, kinetic), start=1):
        percent = np.round(100 * shares, 1)
        drawn.add_heatmap(
            z=percent.tolist(),
            x=list(range(len(hertz))),
            y=names,
            text=[[f"{value:.0f}" if value >= 4.5 else "" for value in values] for values in percent],
            texttemplate="%{text}",
            textfont={"size": 10},
            customdata=[words] * len(names),
            hovertemplate="%{y}: %{z:.1f} %<br>mode at %{customdata} Hz<extra></extra>",
            **{"coloraxis": "coloraxis", "xgap": 1, "ygap": 1, "row": row, "col": 1},
        )
    drawn.update_yaxes(autorange="reversed", showgrid=False)
    ticks = {"tickmode": "array", "tickvals": list(range(len(hertz))), "tickangle": -90}
    drawn.update_xaxes(**ticks, ticktext=[f"{mode}: {text}" for mode, text in enumerate(words, 1)], showgrid=False)
    drawn.update_xaxes(title_text="mode: natural frequency [Hz]", row=2, col=1)
    drawn.update_xaxes(showticklabels=False, row=1, col=1)
    title = {"text": "share [%]", "side": "right", "font": {"size": 13}}
    bar = {"title": title, "thickness": 14, "outlinewidth": 0, "tickfont": {"size": 12}}
    scale = {"colorscale": _SHARE_COLOURS, "cmin": 0, "cmax": 100, "colorbar": bar}
    return drawn.update_layout(coloraxis=scale)


class ResonanceCrossing(NamedTuple):
    """A mesh order meets a natural frequency: relative speed, frequency [Hz], order, stage, mode (from 1)."""

    relative_speed: float
    frequency: float
    order: int
    stage: str
    mode: int


def campbell(data: xr.Dataset, *, orders: int | None = None) -> go.Figure:
    """Campbell diagram: natural frequencies [Hz] over speed [% of the operating speed], rays of mesh orders.

    Parameters
    ----------
    data : Dataset of `campbell`: whirl_frequency (relative_speed, mode) [Hz], mesh_frequency ([stage,] relative_speed).
    orders : mesh orders drawn; where None as many as reach the highest natural frequency, but 3 to 8.
    """
    speed, whirl, rays = _arrays(data)
    percent = 100 * speed
    highest, fastest = float(np.nanmax(whirl, initial=1.0)), max((float(ray.max()) for ray in rays.values()), default=0)
    count = orders or int(np.clip(np.ceil(highest / fastest) if fastest > 0 else 3, 3, 8))
    top = 1.05 * min(highest, 1.3 * count * fastest) if fastest > 0 else 1.05 * highest
    drawn = figure("Campbell diagram", x=SPEED_TITLE, y="frequency [Hz]", height=600)
    if percent[0] <= 100 <= percent[-1]:
        add_operating_band(drawn)
        drawn.add_vline(x=100, line={"color": INK, "width": 1.5})
    kinds = texts(data, "mode_kind") if "mode_kind" in data.variables else [""] * whirl.shape[1]
    for kind in dict.fromkeys(kinds):
        curves = whirl[:, [own == kind for own in kinds]].T
        gap = np.full((len(curves), 1), np.nan)  # between two modes
        x = np.hstack([np.tile(percent, (len(curves), 1)), gap])
        line, words = {"color": mode_colour(kind), "width": 1.8}, f"{kind} modes" if kind else "natural frequencies"
        add_curve(drawn, x, np.hstack([curves, gap]), line=line, name=words, hoverinfo="skip")
    for place, ray in enumerate(rays.values()):
        line = {"color": PALE, "width": 1.3, "dash": DASHES[1 + place % 3]}
        for order in range(1, count + 1):  # as far as the diagram reaches
            within = np.where(order * ray <= 1.2 * top, order * ray, np.nan)
            add_curve(drawn, percent, within, line=line, showlegend=False, hoverinfo="skip")
    _ray_names(drawn, rays, percent, count=count, top=top)
    longest = _mode_names(drawn, whirl[-1], top)
    found = [one for one in crossings(data, orders=count) if one.frequency <= top]
    if found:
        add_curve(
            drawn,
            [100 * one.relative_speed for one in found],
            [one.frequency for one in found],
            mode="markers",
            marker={"symbol": "circle-open", "size": 10, "color": WARNING, "line": {"width": 2}},
            name="a mesh order meets a natural frequency",
            text=[
                f"mode {one.mode} at {engineering(one.frequency)} Hz<br>{one.order}× {one.stage}"
                f"<br>{engineering(100 * one.relative_speed)} % of the operating speed"
                for one in found
            ],
            hoverinfo="text",
        )
    drawn.update_xaxes(range=[float(percent[0]), float(percent[-1])])
    drawn.update_yaxes(range=[0, top])
    return drawn.update_layout(margin={"r": beside(longest), "t": 60}, legend=level_legend(-0.14))


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
        where = {"xref": "paper", "x": 1.005, "xanchor": "left", "y": float(hertz[own[0]]), "yanchor": "middle"}
        note(drawn, words, **where, font={"size": 11, "color": PALE})
        longest = max(longest, len(words))
    return longest


def crossings(data: xr.Dataset, *, orders: int = 3) -> list[ResonanceCrossing]:
    """Where the rays of the mesh orders meet the natural frequencies, between speeds interpolated linearly."""
    speed, whirl, rays = _arrays(data)
    found = []
    for stage, ray in rays.items():
        for order in range(1, orders + 1):
            for mode in range(whirl.shape[1]):
                distance = whirl[:, mode] - order * ray
                for at in np.flatnonzero((distance[:-1] * distance[1:] < 0) | (distance[1:] == 0)):
                    share = distance[at] / (distance[at] - distance[at + 1])
                    met = float(speed[at] + share * (speed[at + 1] - speed[at]))
                    hertz = float(whirl[at, mode] + share * (whirl[at + 1, mode] - whirl[at, mode]))
                    found.append(
                        ResonanceCrossing(relative_speed=met, frequency=hertz, order=order, stage=stage, mode=mode + 1)
                    )
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
    taken: list[tuple[float, float, float]] = []
    wide = float(np.ptp(percent))
    for stage, ray in rays.items():
        for order in range(1, count + 1):
            name = f"{order}× {stage}"
            room = 1.1 * _LETTER * len(name)  # of the width
            for share in (0.95, 0.85, 0.75, 0.65):  # of the way to the end, until there is room
                end = min(float(percent[-1]) - wide * room / 2, float(np.interp(top, order * ray, percent)))
                x = share * end
                y = order * float(np.interp(x, percent, ray))
                if all(abs(x - a) > wide * (room + r) / 2 or abs(y - b) > 1.2 * _LINE * top for a, b, r in taken):
                    note(drawn, name, x=x, y=y, font={"size": 11, "color": INK}, bgcolor="rgba(255,255,255,0.85)")
                    taken.append((x, y, room))
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
    title = f"Natural frequencies over {options['over']}"
    drawn = figure(title, x=f"{options['over']}{unit}", y="frequency [Hz]", height=560)
    kinds = texts(data, "mode_kind")
    multiple = data["multiplicity"].values
    seen: set[str] = set()
    for place, row in enumerate(hertz):
        if row.max() <= 0:
            continue
        kind = kinds[place]
        line = {"color": mode_colour(kind), "width": 2.6 if int(multiple[place]) > 1 else 1.5}
        legend: dict[str, Any] = {"name": f"{kind} mode", "legendgroup": kind, "showlegend": kind not in seen}
        words = f"mode {place + 1}, {kind}: %{{y:.5g}} Hz<extra></extra>"
        add_curve(drawn, x, row, line=line, hovertemplate=words, **legend)
        seen.add(kind)
    top = 1.04 * float(np.nanmax(hertz, initial=1.0))
    for kind in _EVENT_MARKS:
        _mark_events(drawn, data, kind, top)
    if x.min() <= float(options["value"]) <= x.max():
        line = {"color": INK, "width": 1.2, "dash": "dot"}
        drawn.add_vline(x=float(options["value"]), line=line)
        add_key(drawn, "value in the model", line, legendgroup="events")
    wide = x.min() > 0 and x.max() / x.min() > 10
    drawn.update_xaxes(type="log" if wide else "linear", exponentformat="e")
    return drawn.update_yaxes(range=[0, top])


def _mark_events(drawn: go.Figure, data: xr.Dataset, kind: str, top: float) -> None:
    """Crossings or veerings of the loci up to a frequency [Hz]."""
    symbol, colour, words = _EVENT_MARKS[kind]
    frequency, where = numbers(data, "event_frequency"), numbers(data, "event_value")
    chosen = [i for i, text in enumerate(texts(data, "event_kind")) if text == kind and frequency[i] <= top]
    if not chosen:
        return
    gap, index = numbers(data, "event_gap"), numbers(data, "veering_index")
    first, second = texts(data, "event_first"), texts(data, "event_second")
    said = [
        f"modes {first[i]} and {second[i]}"
        + (f": gap {engineering(gap[i])} Hz, index {index[i]:.2f}" if kind == "veering" else "")
        for i in chosen
    ]
    drawn.add_scatter(
        x=[float(where[i]) for i in chosen],
        y=[float(frequency[i]) for i in chosen],
        mode="markers",
        marker={"symbol": symbol, "size": 11, "color": colour, "line": {"width": 2, "color": colour}},
        name=words,
        legendgroup="events",
        text=said,
        hovertemplate=f"{words} at %{{x:.5g}}, %{{y:.5g}} Hz<br>%{{text}}<extra></extra>",
    )
