"""Campbell diagram: natural frequencies over speed, rays of the mesh orders, and where they cross."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, engineering, numbers, texts
from .style import DASHES, INK, PALE, PALETTE, WARNING, beside, figure, mode_colour, note, translucent

__all__ = ["ResonanceCrossing", "campbell", "crossings"]

# Width of a letter of 12 px in parts of a plot of 800 px.
_LETTER = 0.0085
# Height of a line of text of 11 px, 16 px, in parts of a plot of 400 px.
_LINE = 0.042
# As of `modes`: resonances this close to the operating speed are near it.
_BAND = 0.2
_X = f"speed (shaded: operation ± {100 * _BAND:.0f} %) [% of the operating speed]"


@dataclass(frozen=True, slots=True, kw_only=True)
class ResonanceCrossing:
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
    drawn = figure("Campbell diagram", x=_X, y="frequency [Hz]", height=600)
    if percent[0] <= 100 <= percent[-1]:
        band = {"x0": 100 * (1 - _BAND), "x1": 100 * (1 + _BAND), "line_width": 0, "layer": "below"}
        drawn.add_vrect(**band, fillcolor=translucent(PALETTE[0], 0.08))
        drawn.add_vline(x=100, line={"color": INK, "width": 1.5})
    kinds = _kinds(data, whirl.shape[1])
    for kind in dict.fromkeys(kinds):
        x, y = _lines(percent, whirl[:, [own == kind for own in kinds]])
        line, words = {"color": mode_colour(kind), "width": 1.8}, f"{kind} modes" if kind else "natural frequencies"
        drawn.add_trace(go.Scatter(x=x, y=y, mode="lines", line=line, name=words, hoverinfo="skip"))
    for place, ray in enumerate(rays.values()):
        for order in range(1, count + 1):
            _ray(drawn, percent, order * ray, DASHES[1 + place % 3], top)
    _ray_names(drawn, rays, percent, count=count, top=top)
    longest = _mode_names(drawn, whirl[-1], top)
    found = [one for one in crossings(data, orders=count) if one.frequency <= top]
    if found:
        drawn.add_trace(_marks(found))
    drawn.update_xaxes(range=[float(percent[0]), float(percent[-1])])
    drawn.update_yaxes(range=[0, top])
    legend = {"orientation": "h", "x": 0, "xanchor": "left", "y": -0.14, "yanchor": "top"}
    return drawn.update_layout(margin={"r": beside(longest), "t": 60}, legend=legend)


def _kinds(data: xr.Dataset, count: int) -> list[str]:
    """Kind of each mode; empty words where the result says none."""
    return texts(data, "mode_kind") if "mode_kind" in data.variables else [""] * count


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


def _lines(percent: Array, whirl: Array) -> tuple[list[float | None], list[float | None]]:
    """All natural frequencies (P, modes) [Hz] over speed (P,) [%] as one trace, a gap between two modes."""
    gap = np.full((whirl.shape[1], 1), np.nan)
    x = np.hstack([np.tile(percent, (whirl.shape[1], 1)), gap])
    return compact(x), compact(np.hstack([whirl.T, gap]))


def _ray(drawn: go.Figure, percent: Array, ray: Array, dash: str, top: float) -> None:
    """One ray of a mesh order (P,) [Hz] over speed (P,) [%], as far as the diagram reaches."""
    line = {"color": PALE, "width": 1.3, "dash": dash}
    shown = np.where(ray <= 1.2 * top, ray, np.nan)
    drawn.add_trace(
        go.Scatter(x=compact(percent), y=compact(shown), mode="lines", line=line, showlegend=False, hoverinfo="skip")
    )


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


def _marks(found: list[ResonanceCrossing]) -> go.Scatter:
    words = [
        f"mode {one.mode} at {engineering(one.frequency)} Hz<br>{one.order}× {one.stage}"
        f"<br>{engineering(100 * one.relative_speed)} % of the operating speed"
        for one in found
    ]
    return go.Scatter(
        x=compact(np.array([100 * one.relative_speed for one in found])),
        y=compact(np.array([one.frequency for one in found])),
        mode="markers",
        marker={"symbol": "circle-open", "size": 10, "color": WARNING, "line": {"width": 2}},
        name="a mesh order meets a natural frequency",
        text=words,
        hoverinfo="text",
    )
