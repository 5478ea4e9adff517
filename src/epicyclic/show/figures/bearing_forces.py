"""Radial forces in bearings, supports and couplings over speed."""

from __future__ import annotations

from itertools import product

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from .series import Array, compact, texts
from .speeds import abscissa, mark_failed, mark_modes, mark_operating
from .style import DASHES, PALETTE, panels

__all__ = ["bearing_forces"]

_PANELS = (
    ("bearing_force_peak", "largest radial force"),
    ("bearing_force_rms", "RMS of the dynamic radial force"),
)


def bearing_forces(sweep: xr.Dataset, modes: xr.Dataset | None = None) -> go.Figure:
    """Radial force of every bearing, support and coupling over speed: largest and dynamic RMS [kN].

    Links whose curves coincide share one; natural frequencies and the operating point are lines.

    Parameters
    ----------
    sweep : Dataset of `sweep`: bearing_force_peak, bearing_force_rms (bearing, speed) [N], mesh_frequency (speed) [Hz],
        status (speed).
    modes : Dataset of `modes`: frequency, mode_kind, multiplicity (mode).
    """
    x, unit = abscissa(sweep)
    rank = np.argsort(x)
    bound = str(sweep["bearing_force_peak"].attrs.get("long_name", "")).startswith("bound")
    drawn = panels(
        "Bearing and pin forces over speed",
        [title + bound * (name == "bearing_force_peak") * " (a bound)" for name, title in _PANELS],
        height=640,
        shared_xaxes=True,
        vertical_spacing=0.12,
    )
    values = np.stack([sweep[name].transpose("bearing", "speed").values[:, rank] for name, _ in _PANELS], axis=1) / 1e3
    for place, (name, forces) in enumerate(_merged(texts(sweep, "bearing"), values)):
        line = {"color": PALETTE[place % len(PALETTE)], "dash": DASHES[place // len(PALETTE) % 4], "width": 1.7}
        for row, force in enumerate(forces, start=1):
            curve = go.Scatter(
                x=compact(x[rank]),
                y=compact(force),
                mode="lines",
                name=name,
                legendgroup=name,
                showlegend=row == 1,
                line=line,
                hovertemplate=f"{name}: %{{y:.4g}} kN at %{{x:.4g}} Hz<extra></extra>",
            )
            drawn.add_trace(curve, row=row, col=1)
    drawn.update_yaxes(title_text="force [kN]", rangemode="tozero")
    drawn.update_xaxes(title_text=unit, row=2, col=1)
    if len(x):
        drawn.update_xaxes(range=[float(x.min()), float(x.max())])
    mark_failed(drawn, sweep, x)
    mark_modes(drawn, modes, sweep, x)
    mark_operating(drawn, sweep, x)
    return drawn


def _merged(names: list[str], values: Array) -> list[tuple[str, Array]]:
    """Curves (k, 2, P) of bearings by short name, those that coincide as one; forces that are rounding left out."""
    largest = float(np.nanmax(values, initial=0.0))
    several = len({name.split("/")[0] for name in names}) > 1
    kept: list[tuple[list[str], Array]] = []
    for name, curves in zip(names, values, strict=True):
        if not float(np.nanmax(curves, initial=0.0)) > 1e-6 * largest:
            continue
        short = name if several else name.split("/", 1)[-1]
        same = [found for found, other in kept if _coincide(other, curves, values)]
        if same:
            same[0].append(short)
        else:
            kept.append(([short], curves))
    return [(_together(found), curves) for found, curves in kept]


def _coincide(one: Array, other: Array, values: Array) -> bool:
    """Whether two pairs of curves (2, P) are closer than a line is wide, in each panel of all curves (k, 2, P)."""
    return all(
        np.allclose(a, b, rtol=0, atol=1e-3 * float(np.nanmax(panel, initial=0.0)), equal_nan=True)
        for a, b, panel in zip(one, other, values.swapaxes(0, 1), strict=True)
    )


def _together(names: list[str]) -> str:
    """One name of several: ``planet/1/bearing``, ``planet/2/bearing`` read ``planet 1, 2 bearing``."""
    parts = [tuple(name.split("/")) for name in names]
    if len({len(part) for part in parts}) == 1:
        columns = [list(dict.fromkeys(column)) for column in zip(*parts, strict=True)]
        if len(set(product(*columns))) == len(parts):
            return " ".join(", ".join(column) for column in columns)
    more = f" and {len(parts) - 1} more" if len(parts) > 1 else ""
    return " ".join(parts[0]) + more
