"""Forces over speed: of meshes, of bearings, and of meshes whose teeth part; where in the range the resonances lie.

All share the abscissa and the marks of natural frequencies, the operating point and speeds without a solution.  With
contact loss there are run-up and coast-down, unstable branches dashed, folds, and how long teeth are apart.  The range
of speeds has the largest dynamic factor, the band about operation, and what meets.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from numpy.typing import NDArray

from ...results.dataset import EQUAL, largest, ranked
from ..series import (
    Array,
    Series,
    compact,
    engineering,
    merged,
    mode_groups,
    numbers,
    of_first_stage,
    spans,
    stage_count,
    texts,
)
from .style import (
    DASHES,
    INK,
    PALE,
    PALETTE,
    SPEED_TITLE,
    WARNING,
    add_curve,
    add_key,
    add_operating_band,
    branch_colour,
    entry,
    figure,
    level_legend,
    lines_across,
    mode_colour,
    note,
    panels,
    translucent,
)

# Resonances named in a figure: more names would lie on each other.
_RESONANCES = 8
# Mesh frequency per that at operation up to which a range is about operation.
_ABOUT = 2.0
_MESH_PANELS = (
    ("mesh_force_rms", "RMS of the dynamic mesh force"),
    ("mesh_force_peak", "largest mesh force"),
    ("dynamic_factor", "dynamic factor, largest per mean mesh force"),
)
_BEARING_PANELS = (
    ("bearing_force_peak", "largest radial force"),
    ("bearing_force_rms", "RMS of the dynamic radial force"),
)
_FORCE = {"title_text": "force [kN]", "rangemode": "tozero"}
# the run-up wide and pale, so that the coast-down over it hides it nowhere
_LOOK = {"up": ("#F2B184", 5.0, "triangle-up", "run-up"), "down": (PALETTE[0], 1.3, "triangle-down", "coast-down")}


def abscissa(sweep: xr.Dataset) -> tuple[Array, str]:
    """Mesh frequency of the first stage [Hz], or speed [%], and the title of the axis."""
    if "mesh_frequency" in sweep.variables:
        tones = sweep["mesh_frequency"]
        first = tones.isel(stage=0) if "stage" in tones.dims else tones
        return np.asarray(first.values, dtype=np.float64), f"mesh frequency{of_first_stage(sweep)} [Hz]"
    return 100 * numbers(sweep, "speed"), "speed [% of the operating speed]"


def mark_modes(drawn: go.Figure, modes: xr.Dataset | None, sweep: xr.Dataset, x: Array) -> None:
    """What of the modes lies within x (speed,) [Hz], as lines behind the curves.

    Over a range about operation the speeds at which mesh orders meet modes, where they are known, else natural
    frequencies.
    """
    if modes is None or not len(x):
        return
    if modes.sizes.get("resonance", 0) and x.max() <= _ABOUT * _operating_frequency(sweep, x):
        _mark_resonances(drawn, modes, sweep, x)
    else:
        natural = [one for one in mode_groups(modes) if float(x.min()) <= one.frequency <= float(x.max())]
        kind_lines(drawn, [(one.frequency, one.kind) for one in natural], "{} mode", legendgroup="marks")


def _mark_resonances(drawn: go.Figure, modes: xr.Dataset, sweep: xr.Dataset, x: Array) -> None:
    """Strongest speeds within x (speed,) [Hz] at which a mesh order meets a mode, as lines named by order and mode."""
    tone = _operating_frequency(sweep, x)
    force = np.nan_to_num(numbers(modes, "resonance_force_ratio"), nan=0.0)
    at, kinds = tone * numbers(modes, "resonance_speed"), texts(modes, "resonance_kind")
    inside = (force > 0) & (at >= x.min()) & (at <= x.max())
    inside &= np.array([one != "no" for one in texts(modes, "resonance_excited", "resonance")], dtype=bool)
    shown = [int(place) for place in ranked(force, equal=EQUAL) if inside[place]][:_RESONANCES]
    kind_lines(drawn, [(float(at[place]), kinds[place]) for place in shown], "resonance, {} mode", legendgroup="marks")
    stages = texts(modes, "resonance_stage")
    several = len(set(stages)) > 1
    taken: list[float] = []
    for place in shown:
        if any(abs(at[place] - other) < 0.05 * np.ptp(x) for other in taken):
            continue
        taken.append(float(at[place]))
        order = f"{int(modes['resonance_order'].values[place])}×{f' {stages[place]}' if several else ''}"
        words = f"{order}, mode {int(modes['resonance_mode'].values[place])}"
        # on the side that has room, over the curves on a ground of their own
        side = 8 if at[place] < x.min() + 0.02 * np.ptp(x) else -8
        where = {"yref": "y domain", "y": 0.02, "yanchor": "bottom", "textangle": -90, "xshift": side}
        note(drawn, words, x=float(at[place]), **where, bgcolor="rgba(255,255,255,0.8)", borderpad=0)


def _operating_frequency(sweep: xr.Dataset, x: Array) -> float:
    """Abscissa of the operating speed, of x (speed,) [Hz] in proportion to the speed."""
    speed = numbers(sweep, "speed", "speed")
    known = np.isfinite(speed) & (speed > 0)
    return float(np.median(x[known] / speed[known])) if known.any() else np.nan


def kind_lines(
    drawn: go.Figure, lines: list[tuple[float, str]], name: str, *, along: str = "x", alpha: float = 0.75, **look: Any
) -> None:
    """Dotted lines at places along an axis, in the colours of kinds of modes, each kind once in the legend.

    lines : place and kind of the mode.  name : in the legend, with {} for the kind.  look : of that entry.
    """
    looks = {
        kind: {"color": translucent(mode_colour(kind), alpha), "width": 1.1, "dash": "dot"}
        for kind in dict.fromkeys(kind for _, kind in lines)
    }
    lines_across(drawn, [(at, {"line": looks[kind], "layer": "below"}) for at, kind in lines], along=along)
    for kind, line in looks.items():
        add_key(drawn, name.format(kind), line, **look)


def mark_operating(drawn: go.Figure, sweep: xr.Dataset, x: Array) -> None:
    """The operating speed, where it lies within x (speed,) [Hz], as a line."""
    speed = numbers(sweep, "speed", "speed")
    if not len(speed) or not speed.min() <= 1 <= speed.max():
        return
    rank = np.argsort(speed)
    at = float(np.interp(1.0, speed[rank], x[rank]))
    line = {"color": INK, "width": 1.5}
    lines_across(drawn, [(at, {"line": line})])
    add_key(drawn, "operating point", line, legendgroup="marks")


def _finished(drawn: go.Figure, sweep: xr.Dataset, modes: xr.Dataset | None, x: Array) -> go.Figure:
    """The figure over x (speed,) [Hz] with its range and all marks."""
    if len(x):
        drawn.update_xaxes(range=[float(x.min()), float(x.max())])
    bad = [place for place, status in enumerate(texts(sweep, "status", "speed")) if status not in ("ok", "")]
    if bad:
        look = {"symbol": "x", "size": 9, "color": WARNING}
        legend = {"name": "no convergence", "legendgroup": "marks"}
        at = [float(x[place]) for place in bad]
        drawn.add_scatter(x=at, y=[0.0] * len(at), mode="markers", marker=look, cliponaxis=False, **legend)
    mark_modes(drawn, modes, sweep, x)
    mark_operating(drawn, sweep, x)
    return drawn


def speed_sweep(sweep: xr.Dataset, modes: xr.Dataset | None = None) -> go.Figure:
    """RMS of the dynamic mesh force, largest mesh force [kN] and dynamic factor K_v [1] over mesh frequency [Hz].

    Natural frequencies and the operating point are lines; speeds without a solution are crosses.

    Parameters
    ----------
    sweep : Dataset of `sweep`: mesh_force_rms, mesh_force_peak [N], dynamic_factor (mesh, speed), mesh_frequency,
        status (speed).
    modes : Dataset of `modes`: frequency, mode_kind, multiplicity (mode).
    """
    x, unit = abscissa(sweep)
    rank = np.argsort(x)
    shown = [(name, title) for name, title in _MESH_PANELS if name in sweep.variables]
    space: dict[str, Any] = {"shared_xaxes": True, "vertical_spacing": 0.12}
    drawn = panels("Mesh forces over speed", [title for _, title in shown], height=140 + 250 * len(shown), **space)
    names = texts(sweep, "mesh")
    kinds = list(dict.fromkeys(name.split("/")[1] for name in names if "/" in name))
    several = stage_count(names) > 1
    rows = [sweep[name].transpose("mesh", "speed").values[:, rank] for name, _ in shown]
    scales = [float(np.nanmax(np.abs(values), initial=0.0)) or 1.0 for values in rows]
    # curves are equal where they are so in every panel
    curves = np.hstack([values / scale for values, scale in zip(rows, scales, strict=True)])
    groups = merged(names, curves, branches=True)
    for row, ((variable, _), scale) in enumerate(zip(shown, scales, strict=True), start=1):
        ratio = variable == "dynamic_factor"
        for one in groups:
            values = scale * one.values[(row - 1) * len(x) : row * len(x)] / (1.0 if ratio else 1e3)
            name = _mesh_name(one, several)
            dash = DASHES[kinds.index(one.pair) % len(DASHES)] if one.pair in kinds else "solid"
            add_curve(
                drawn,
                x[rank],
                values,
                panel=row,
                digits=(5, 7),  # a K_v of 1.01 varies in its fourth place
                line={"color": branch_colour(one.branch), "dash": dash, "width": 1.7},
                hovertemplate=f"{name}: %{{y:.4g}}{'' if ratio else ' kN'} at %{{x:.4g}} Hz<extra></extra>",
                **entry(name, first=row == 1),
            )
        look = {"title_text": "K_v [-]", "rangemode": "normal"} if ratio else _FORCE
        drawn.update_yaxes(**look, row=row, col=1)
    drawn.update_xaxes(title_text=unit, row=len(shown), col=1)
    return _finished(drawn, sweep, modes, x)


def _mesh_name(one: Series, several: bool) -> str:
    """Name of the curves of a mesh, or of equal meshes; several : the train has stages to name."""
    side = one.note.strip() or one.side[:1].upper()
    branches = spans(one.equal) if one.branch else ""
    equal = "alike" if len(one.equal) > 1 else ""
    return " ".join(word for word in (one.stage if several else "", one.pair, branches, side, equal) if word)


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
        [title + bound * (name == "bearing_force_peak") * " (a bound)" for name, title in _BEARING_PANELS],
        height=640,
        shared_xaxes=True,
        vertical_spacing=0.12,
    )
    curves = [sweep[name].transpose("bearing", "speed").values[:, rank] for name, _ in _BEARING_PANELS]
    for place, (name, forces) in enumerate(_merged(texts(sweep, "bearing"), np.stack(curves, axis=1) / 1e3)):
        line = {"color": PALETTE[place % len(PALETTE)], "dash": DASHES[place // len(PALETTE) % 4], "width": 1.7}
        words = f"{name}: %{{y:.4g}} kN at %{{x:.4g}} Hz<extra></extra>"
        for row, force in enumerate(forces, start=1):
            legend = entry(name, first=row == 1)
            add_curve(drawn, x[rank], force, panel=row, line=line, hovertemplate=words, **legend)
    drawn.update_yaxes(**_FORCE)
    drawn.update_xaxes(title_text=unit, row=2, col=1)
    return _finished(drawn, sweep, modes, x)


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
    level = np.nan_to_num(sweep["mesh_force_rms"].max(("direction", "speed")).values)
    name = mesh or str(sweep["mesh"].values[largest(level)])
    drawn = panels(
        f"Mesh force with contact loss, {name}",
        ["RMS of the dynamic mesh force", "teeth apart"],
        height=640,
        shared_xaxes=True,
        vertical_spacing=0.12,
        row_heights=[0.7, 0.3],
    )
    path = np.asarray(sweep["path_frequency"].values, dtype=np.float64)
    force = np.asarray(sweep["path_force_rms"].sel(mesh=name).values, dtype=np.float64) / 1e3
    _branches(drawn, sweep, path, force)
    rank = np.argsort(sweep["mesh_frequency"].values, kind="stable")
    x = np.asarray(sweep["mesh_frequency"].values, dtype=np.float64)[rank]
    for direction in map(str, sweep["direction"].values):
        _direction(drawn, sweep.sel(direction=direction, mesh=name), direction, x, rank)
    if sweep.sizes.get("fold"):  # where a branch turns back or on
        at = [int(np.argmin(np.abs(path - fold))) for fold in sweep["fold_frequency"].values]
        ring = {"symbol": "circle-open", "size": 11, "color": INK, "line": {"width": 2}}
        words = "fold at %{x:.6g} Hz<extra></extra>"
        add_curve(drawn, path[at], force[at], panel=1, mode="markers", name="fold", marker=ring, hovertemplate=words)
    drawn.update_yaxes(**_FORCE, row=1, col=1)
    drawn.update_yaxes(title_text="time [%]", rangemode="tozero", row=2, col=1)
    title = f"mesh frequency{of_first_stage(sweep)} [Hz]"
    return drawn.update_xaxes(title_text=title, range=[float(x.min()), float(x.max())], row=2, col=1)


def _branches(drawn: go.Figure, sweep: xr.Dataset, x: Array, y: Array) -> None:
    """The whole way y [kN] over x (path,) [Hz]: a line where it is stable, dashes where not."""
    part, kind = sweep["path_part"].values, np.array(texts(sweep, "path_instability"), dtype=object)
    unstable = ~np.isin(kind, ("stable", ""))
    shown: set[bool] = set()
    # runs of one kind, not across a break of the branch
    cut = np.flatnonzero((unstable[1:] != unstable[:-1]) | (np.abs(np.diff(part)) > 1))
    for run in np.split(np.arange(len(unstable)), cut + 1) if len(unstable) else ():
        first, last = int(run[0]), int(run[-1])
        dashed = bool(unstable[first])
        end = min(last + 1, len(x) - 1) if last + 1 < len(x) and part[last + 1] - part[last] in (0, 1) else last
        label = "unstable branch" if dashed else "branch"
        add_curve(
            drawn,
            x[first : end + 1],
            y[first : end + 1],
            panel=1,
            line={"color": WARNING if dashed else PALE, "dash": "dash" if dashed else "solid", "width": 2},
            text=[str(text) for text in kind[first : end + 1]],
            hovertemplate="%{y:.4g} kN at %{x:.6g} Hz, %{text}<extra></extra>",
            **entry(label, first=dashed not in shown),
        )
        shown.add(dashed)


def _direction(drawn: go.Figure, part: xr.Dataset, direction: str, x: Array, rank: NDArray[np.int64]) -> None:
    """The motions of one sweep direction over mesh frequency (P,) [Hz]: force above, part of time apart below."""
    colour, width, symbol, label = _LOOK[direction]
    motion = np.array(texts(part, "motion"), dtype=object)[rank]
    own = np.isin(motion, ("symmetry broken", "period 2", "integrated"))
    rows = (np.asarray(part["mesh_force_rms"].values) / 1e3, 100 * np.asarray(part["contact_open"].values))
    sizes = np.where(own, 9 if direction == "up" else 6, 0).tolist()
    for row, values in enumerate(rows, start=1):
        add_curve(
            drawn,
            x,
            values[rank],
            panel=row,
            mode="lines+markers" if row == 1 else "lines",
            line={"color": colour, "width": width},
            marker={"symbol": symbol, "size": sizes, "color": colour},
            text=[str(text) for text in motion],
            hovertemplate=f"{label}: %{{y:.4g}} at %{{x:.6g}} Hz, %{{text}}<extra></extra>",
            **entry(label, first=row == 1),
        )


# Names of resonances stand upright above the curve: so many at most, the strongest, this far apart [% of the width].
_NAMED, _APART = 16, 2.4
# Heights of the curve, of a letter of an upright name, and of what is around the plot [px].
_CURVE, _LETTER, _AROUND = 190, 6.1, 150
_PARTS = 2.0  # K_v of a vibration about the mean that takes the force to zero
Pair = tuple["xr.Dataset | None", "xr.Dataset | None"]


def operating_range(results: Mapping[str, Pair]) -> go.Figure | None:
    """Largest K_v [1] of all meshes over speed [% of operation], resonances on it; None where nothing is known.

    Parameters
    ----------
    results : name of a train -> Datasets of `modes` (resonance_speed, resonance_near, resonance_order,
        resonance_stage, resonance_mode, resonance_force_ratio (resonance)) and of `sweep` (dynamic_factor (mesh,
        speed)), either may be None.
    """
    known = {name: (m, s) for name, (m, s) in results.items() if _curve(s) is not None or _speeds(m).size}
    if not known:
        return None
    curves = {name: _curve(sweep) for name, (_, sweep) in known.items()}
    rated = any(curve is not None for curve in curves.values())
    drawn = figure("Where in the range of speeds the resonances lie", x=SPEED_TITLE, y="largest K_v [-]" * rated)
    add_operating_band(drawn)
    single, most = len(known) == 1, 1.0
    longest = max((len(words) for modes, _ in known.values() for words in _words(modes)), default=0)
    strip = 40 * len(known) + _LETTER * longest if single else 40.0 * len(known)
    low = _CURVE / (_CURVE + strip)
    for place, (name, (modes, _)) in enumerate(known.items()):
        colour, curve, speed = PALETTE[place % len(PALETTE)], curves[name], _speeds(modes)
        if curve is not None:
            most = max(most, float(curve[1].max()))
            line, words = {"color": colour, "width": 2}, "K_v %{y:.4g} at %{x:.4g} %<extra></extra>"
            title = "largest K_v of all meshes" if single else name
            add_curve(drawn, *curve, digits=(5, 6), line=line, name=title, hovertemplate=words)
        if modes is None or not speed.size:
            continue
        height = (0.5 + place) / len(known) if not single else 20 / strip
        stroke = {"symbol": "line-ns-open", "size": 11, "color": WARNING if single else colour, "line": {"width": 1.5}}
        drawn.add_scatter(
            x=compact(speed),
            y=[height] * len(speed),
            **{"yaxis": "y2", "mode": "markers", "marker": stroke, "hoverinfo": "text"},
            name="a mesh order meets a mode" if single else f"{name}: a mesh order meets a mode",
            text=[
                f"{words} at {engineering(at)} % of the operating speed"
                for words, at in zip(_words(modes), speed, strict=True)
            ],
        )
        if single:
            _names(drawn, modes, 32 / strip)
    if most >= _PARTS:
        across = {"x0": 0, "x1": 1, "xref": "paper", "y0": _PARTS, "y1": _PARTS}
        drawn.add_shape(type="line", **across, line={"color": WARNING, "width": 1.2, "dash": "dash"})
        where = {"x": 0.005, "xref": "paper", "xanchor": "left", "y": _PARTS, "yanchor": "bottom"}
        note(drawn, f"K_v {_PARTS:g}", **where, font={"size": 12, "color": WARNING})
    drawn.add_vline(x=100, line={"color": INK, "width": 1.5})
    ends = [value for curve in curves.values() if curve is not None for value in (curve[0][0], curve[0][-1])]
    ends = ends or [value for modes, _ in known.values() for value in _speeds(modes)]
    drawn.update_layout(
        height=_CURVE + strip + _AROUND,
        yaxis={"range": [1.0, max(1.02, 1 + 1.08 * (most - 1))], "domain": [0, low], "showticklabels": rated},
        yaxis2={"range": [0, 1], "domain": [low, 1], "visible": False, "fixedrange": True},
        xaxis={"range": [float(min(*ends, 95.0)), float(max(*ends, 105.0))]},
        legend=level_legend(-60 / (_CURVE + strip)),
    )
    return drawn.update_layout(showlegend=True, margin={"t": 76})


def _curve(sweep: xr.Dataset | None) -> tuple[Array, Array] | None:
    """Speed [%] and the largest K_v of all meshes there; None without either."""
    if sweep is None or "dynamic_factor" not in sweep.variables or "speed" not in sweep.coords:
        return None
    speed, factor = 100 * numbers(sweep, "speed"), sweep["dynamic_factor"].transpose("mesh", "speed").values
    known = np.isfinite(factor).any(axis=0) & np.isfinite(speed)
    if known.sum() < 2:
        return None
    rank = np.argsort(speed[known])
    return speed[known][rank], np.nanmax(factor[:, known], axis=0)[rank]


def _speeds(modes: xr.Dataset | None) -> Array:
    """Speeds of the resonances [%]."""
    if modes is None or "resonance_speed" not in modes.variables:
        return np.zeros(0)
    return 100 * numbers(modes, "resonance_speed")


def _words(modes: xr.Dataset | None) -> list[str]:
    """``2× low mesh, mode 5`` of every resonance; the stage where the train has several."""
    if modes is None or not _speeds(modes).size:
        return []
    stage = texts(modes, "resonance_stage")
    several = len(set(stage)) > 1 or stage_count(texts(modes, "connection")) > 1
    columns = (numbers(modes, "resonance_order"), stage, numbers(modes, "resonance_mode"))
    return [
        f"{order:.0f}× {f'{own} ' if several else ''}mesh, mode {mode:.0f}"
        for order, own, mode in zip(*columns, strict=True)
    ]


def _names(drawn: go.Figure, modes: xr.Dataset, height: float) -> None:
    """Names of the strongest resonances, upright above their strokes, as many as stand beside each other."""
    speed, words = _speeds(modes), _words(modes)
    force = np.nan_to_num(numbers(modes, "resonance_force_ratio"), nan=-1.0)
    excited = texts(modes, "resonance_excited", "resonance")
    apart, kept = _APART / 100 * max(float(np.ptp(speed)), 20.0), list[float]()
    for i in ranked(force, equal=EQUAL):
        if excited[i] != "no" and len(kept) < _NAMED and all(abs(speed[i] - other) > apart for other in kept):
            kept.append(float(speed[i]))
            upright = {"textangle": -90, "yref": "y2", "yanchor": "bottom", "font": {"size": 11, "color": PALE}}
            note(drawn, words[i], x=float(speed[i]), y=height, **upright)
