"""Campbell diagram: natural frequencies over speed, rays of the mesh orders, and where they cross."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, engineering, numbers, texts
from .style import DASHES, INK, PALE, WARNING, beside, figure, note

__all__ = ["ResonanceCrossing", "campbell", "crossings"]

# Width of a letter of 12 px in parts of a plot of 800 px.
_LETTER = 0.0085


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
    drawn = figure("Campbell diagram", x="speed [% of the operating speed]", y="frequency [Hz]", height=520)
    x, y = _lines(percent, whirl)
    line = {"color": "#0072B2", "width": 1.8}
    drawn.add_trace(go.Scatter(x=x, y=y, mode="lines", line=line, name="natural frequencies", hoverinfo="skip"))
    for place, ray in enumerate(rays.values()):
        for order in range(1, count + 1):
            _ray(drawn, percent, order * ray, DASHES[1 + place % 3], top)
    _ray_names(drawn, rays, percent, count=count, top=top)
    found = [one for one in crossings(data, orders=count) if one.frequency <= top]
    if found:
        drawn.add_trace(_marks(found))
    if percent[0] <= 100 <= percent[-1]:
        drawn.add_vline(x=100, line={"color": INK, "width": 1.5})
        note(drawn, "operating<br>speed", x=100, yref="paper", y=1.0, yanchor="bottom", font={"size": 12, "color": INK})
    drawn.update_xaxes(range=[float(percent[0]), float(percent[-1])])
    drawn.update_yaxes(range=[0, top])
    legend = {"orientation": "h", "x": 0, "xanchor": "left", "y": -0.16, "yanchor": "top"}
    longest = max((len(f"{count}× {stage}") for stage in rays), default=0)
    return drawn.update_layout(margin={"r": beside(longest), "t": 84}, legend=legend)


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
    """Names of the rays (P,) [Hz] where they leave the diagram over speed (P,) [%], at its right edge or its top.

    Those are left out that would lie on another.
    """
    right: list[float] = []
    above = [100.0]  # the name of the operating speed
    wide = float(np.ptp(percent))
    for stage, ray in rays.items():
        for order in range(1, count + 1):
            name, end = f"{order}× {stage}", float(order * ray[-1])
            if end <= top and all(abs(end - other) > 0.045 * top for other in right):
                note(drawn, name, xref="paper", x=1.005, xanchor="left", y=end, yanchor="middle")
                right.append(end)
            elif end > top:
                at = float(np.interp(top, order * ray, percent))
                room = 1.15 * _LETTER * len(name) * wide
                if all(abs(at - other) > room for other in above) and at - percent[0] > room / 2:
                    note(drawn, name, x=at, yref="paper", y=1.0, yanchor="bottom", xanchor="center")
                    above.append(at)


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
