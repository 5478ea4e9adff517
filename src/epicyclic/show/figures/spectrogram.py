"""Spectrum of a mesh force over a speed ramp, with the multiples of the mesh frequency."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import compact, label, texts
from .style import INK, PALE, figure, note
from .summaries import own_tones

__all__ = ["spectrogram"]

# Windows of the spectrogram along the run, how they overlap, and what is shown below the largest amplitude [dB].
_WINDOWS, _OVERLAP, _RANGE = 100, 0.75, 60.0
_ORDERS = 5


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
    place = (
        names.index(mesh)
        if mesh is not None
        else int(np.nanargmax(np.nanmax(force, axis=1) - np.nanmin(force, axis=1)))
    )
    time = np.asarray(result["time"].values, dtype=np.float64)
    signal = np.nan_to_num(force[place] / 1e3)
    size = max(16, min(len(signal), round(len(signal) / (1 + (_WINDOWS - 1) * (1 - _OVERLAP)))))
    frequency, middle, power = windows(
        signal - signal.mean(), fs=1 / (time[1] - time[0]), nperseg=size, noverlap=int(_OVERLAP * size), window="hann",
        scaling="spectrum",
    )  # fmt: skip
    amplitude = np.sqrt(2 * power)
    tone = np.asarray(result["mesh_frequency"].values, dtype=np.float64) * own_tones(result)[place]
    top = min(float(frequency[-1]), (_ORDERS + 0.5) * float(tone.max()))
    level = 20 * np.log10(np.maximum(amplitude[frequency <= top], 1e-30))
    high = float(level.max())
    drawn = figure(
        f"What {label(names[place], stage=False)} carries over time", x="time [s]", y="frequency [Hz]", height=520
    )
    bar = {"title": {"text": "amplitude<br>[kN]", "side": "top"}, **_ticks(high)}
    heat = go.Heatmap(
        x=compact(middle + time[0], digits=6),
        y=compact(frequency[frequency <= top]),
        z=[compact(row, digits=4) for row in np.maximum(level, high - _RANGE)],
        colorscale="Blues",
        zmin=high - _RANGE,
        zmax=high,
        colorbar=bar,
        hovertemplate="%{x:.4g} s, %{y:.4g} Hz<extra></extra>",
    )
    drawn.add_trace(heat)
    ends = [0, len(time) - 1] if len(time) < 2 else np.linspace(0, len(time) - 1, 40).astype(int).tolist()
    for order in range(1, _ORDERS + 1):
        line = {"color": INK, "width": 0.8, "dash": "dot"}
        drawn.add_trace(
            go.Scatter(x=time[ends], y=order * tone[ends], mode="lines", line=line, showlegend=False, hoverinfo="skip")
        )
        name = "mesh frequency" if order == 1 else f"× {order}"
        note(
            drawn,
            name,
            x=float(time[-1]),
            y=order * float(tone[-1]),
            xanchor="right",
            yanchor="bottom",
            font={"size": 11, "color": PALE},
        )
    drawn.update_yaxes(range=[0, top])
    drawn.update_xaxes(range=[float(time[0]), float(time[-1])])
    return drawn


def _ticks(high: float) -> dict[str, list[float] | list[str]]:
    """Ticks at powers of ten of the amplitude, of which the colours show the logarithm."""
    powers = [p for p in range(-9, 10) if high - _RANGE <= 20 * p <= high]
    return {"tickvals": [20.0 * p for p in powers], "ticktext": [f"{10.0**p:g}" for p in powers]}
