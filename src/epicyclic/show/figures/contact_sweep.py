"""Sweep with contact loss: run-up and coast-down, unstable branches dashed, folds marked, how long teeth are apart."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from numpy.typing import NDArray

from ...results.ties import largest
from .series import Array, compact, texts
from .style import INK, PALE, PALETTE, WARNING, panels
from .summaries import of_first_stage

__all__ = ["contact_sweep"]

# the run-up wide and pale, so that the coast-down over it hides it nowhere
_LOOK = {"up": ("#F2B184", 5.0, "triangle-up", "run-up"), "down": (PALETTE[0], 1.3, "triangle-down", "coast-down")}


def contact_sweep(sweep: xr.Dataset, *, mesh: str | None = None) -> go.Figure:
    """RMS of the dynamic force of one mesh [kN] over mesh frequency [Hz], its branches, and the part of time apart [%].

    Branches are solid where stable and dashed where not, rings are folds; large marks are motions
    in place of an unstable one.

    Parameters
    ----------
    sweep : Dataset of `contact_sweep`: mesh_force_rms (direction, mesh, speed) [N], contact_open (direction, mesh,
        speed), motion (direction, speed), path_frequency, path_instability, path_part (path), path_force_rms (mesh,
        path) [N], fold_frequency (fold) [Hz].
    mesh : name; the one with the largest force where None.
    """
    name = mesh or _loudest(sweep)
    drawn = panels(
        f"Mesh force with contact loss, {name}",
        ["RMS of the dynamic mesh force", "teeth apart"],
        height=640,
        shared_xaxes=True,
        vertical_spacing=0.12,
        row_heights=[0.7, 0.3],
    )
    _branches(drawn, sweep, name)
    rank = np.argsort(sweep["mesh_frequency"].values, kind="stable")
    x = np.asarray(sweep["mesh_frequency"].values, dtype=np.float64)[rank]
    for direction in map(str, sweep["direction"].values):
        part = sweep.sel(direction=direction, mesh=name)
        _direction(drawn, part, direction, x, rank)
    _folds(drawn, sweep, name)
    drawn.update_yaxes(title_text="force [kN]", rangemode="tozero", row=1, col=1)
    drawn.update_yaxes(title_text="time [%]", rangemode="tozero", row=2, col=1)
    drawn.update_xaxes(
        title_text=f"mesh frequency{of_first_stage(sweep)} [Hz]", range=[float(x.min()), float(x.max())], row=2, col=1
    )
    return drawn


def _loudest(sweep: xr.Dataset) -> str:
    level = np.nan_to_num(sweep["mesh_force_rms"].max(("direction", "speed")).values)
    return str(sweep["mesh"].values[largest(level)])


def _branches(drawn: go.Figure, sweep: xr.Dataset, name: str) -> None:
    """The whole way: a line where it is stable, dashes where not."""
    x, part = np.asarray(sweep["path_frequency"].values, dtype=np.float64), sweep["path_part"].values
    y = np.asarray(sweep["path_force_rms"].sel(mesh=name).values, dtype=np.float64) / 1e3
    kind = np.array(texts(sweep, "path_instability"), dtype=object)
    unstable = ~np.isin(kind, ("stable", ""))
    shown: set[bool] = set()
    for first, last in _runs(unstable, part):
        dashed = bool(unstable[first])
        end = min(last + 1, len(x) - 1) if last + 1 < len(x) and part[last + 1] - part[last] in (0, 1) else last
        label = "unstable branch" if dashed else "branch"
        drawn.add_trace(
            go.Scatter(
                x=compact(x[first : end + 1]),
                y=compact(y[first : end + 1]),
                mode="lines",
                name=label,
                legendgroup=label,
                showlegend=dashed not in shown,
                line={"color": WARNING if dashed else PALE, "dash": "dash" if dashed else "solid", "width": 2},
                text=[str(text) for text in kind[first : end + 1]],
                hovertemplate="%{y:.4g} kN at %{x:.6g} Hz, %{text}<extra></extra>",
            ),
            row=1,
            col=1,
        )
        shown.add(dashed)


def _runs(unstable: NDArray[np.bool_], part: NDArray[np.int64]) -> list[tuple[int, int]]:
    """First and last places of runs of one kind (P,), not across a break of the branch."""
    if not len(unstable):
        return []
    cut = (unstable[1:] != unstable[:-1]) | (np.abs(np.diff(part)) > 1)
    edges = [0, *(np.flatnonzero(cut) + 1).tolist(), len(unstable)]
    return [(first, last - 1) for first, last in pairwise(edges)]


def _direction(drawn: go.Figure, part: xr.Dataset, direction: str, x: Array, rank: NDArray[np.int64]) -> None:
    """The motions of one sweep direction over mesh frequency (P,) [Hz]: force above, part of time apart below."""
    colour, width, symbol, label = _LOOK[direction]
    motion = np.array(texts(part, "motion"), dtype=object)[rank]
    own = np.isin(motion, ("symmetry broken", "period 2", "integrated"))
    rows = (np.asarray(part["mesh_force_rms"].values) / 1e3, 100 * np.asarray(part["contact_open"].values))
    for row, values in enumerate(rows, start=1):
        drawn.add_trace(
            go.Scatter(
                x=compact(x),
                y=compact(values[rank]),
                mode="lines+markers" if row == 1 else "lines",
                name=label,
                legendgroup=label,
                showlegend=row == 1,
                line={"color": colour, "width": width},
                marker={
                    "symbol": symbol,
                    "size": np.where(own, 9 if direction == "up" else 6, 0).tolist(),
                    "color": colour,
                },
                text=[str(text) for text in motion],
                hovertemplate=f"{label}: %{{y:.4g}} at %{{x:.6g}} Hz, %{{text}}<extra></extra>",
            ),
            row=row,
            col=1,
        )


def _folds(drawn: go.Figure, sweep: xr.Dataset, name: str) -> None:
    """Where a branch turns back or on."""
    if not sweep.sizes.get("fold"):
        return
    x = np.asarray(sweep["path_frequency"].values, dtype=np.float64)
    at = [int(np.argmin(np.abs(x - fold))) for fold in sweep["fold_frequency"].values]
    y = np.asarray(sweep["path_force_rms"].sel(mesh=name).values, dtype=np.float64)[at] / 1e3
    drawn.add_trace(
        go.Scatter(
            x=compact(x[at]),
            y=compact(y),
            mode="markers",
            name="fold",
            marker={"symbol": "circle-open", "size": 11, "color": INK, "line": {"width": 2}},
            hovertemplate="fold at %{x:.6g} Hz<extra></extra>",
        ),
        row=1,
        col=1,
    )
