"""Forces over speed: of meshes, of bearings, and of meshes whose teeth part; where in the range the resonances lie.

All share the abscissa and the marks of natural frequencies, the operating point and speeds without a solution.  With
contact loss there are run-up and coast-down, unstable branches dashed, folds, and how long teeth are apart.  The range
of speeds has the largest dynamic factor, the band about operation, and what meets.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from numpy.typing import NDArray

from ...results.dataset import EQUAL, largest, ranked
from ..elements import ERROR_KINDS
from ..series import (
    Array,
    Series,
    engineering,
    kept_apart,
    merged,
    mode_groups,
    numbers,
    of_first_stage,
    spans,
    stage_count,
    texts,
)
from .renderers import (
    DASHES,
    FROM_ZERO,
    INK,
    OPERATING_BAND,
    PALE,
    PALETTE,
    SPEED_TITLE,
    WARNING,
    Curve,
    Layer,
    Mark,
    Panel,
    Trace,
    branch_colour,
    chart,
    cycled,
    level_legend,
    mode_colour,
    note,
    points,
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
_FORCE: Mapping[str, Any] = {"y": "force [kN]", "y_axis": FROM_ZERO}
# the run-up wide and pale, so that the coast-down over it hides it nowhere
_LOOK = {"up": ("#F2B184", 5.0, "triangle-up", "run-up"), "down": (PALETTE[0], 1.3, "triangle-down", "coast-down")}


def abscissa(sweep: xr.Dataset) -> tuple[Array, str]:
    """Mesh frequency of the first stage [Hz], or speed [%], and the title of the axis."""
    if "mesh_frequency" in sweep.variables:
        tones = sweep["mesh_frequency"]
        first = tones.isel(stage=0) if "stage" in tones.dims else tones
        return np.asarray(first.values, dtype=np.float64), f"mesh frequency{of_first_stage(sweep)} [Hz]"
    return 100 * numbers(sweep, "speed"), "speed [% of the operating speed]"


def mode_marks(modes: xr.Dataset | None, sweep: xr.Dataset, x: Array) -> list[Mark]:
    """What of the modes lies within x (speed,) [Hz], as lines behind the curves.

    Over a range about operation the speeds at which mesh orders meet modes, where they are known, else natural
    frequencies.
    """
    if modes is None or not len(x):
        return []
    tone = _operating_frequency(sweep, x)
    if modes.sizes.get("resonance", 0) and x.max() <= _ABOUT * tone:
        return _resonance_marks(modes, tone, x)
    natural = [one for one in mode_groups(modes) if float(x.min()) <= one.frequency <= float(x.max())]
    return [kind_mark(one.kind, x=one.frequency, group="marks") for one in natural]


def kind_mark(kind: str, name: str = "{} mode", *, alpha: float = 0.75, **where: Any) -> Mark:
    """A dotted line in the colour of a kind of mode; name : in the legend, with {} for the kind.  where : of `Mark`."""
    look: Trace = {"colour": translucent(mode_colour(kind), alpha), "width": 1.1, "dash": "dot", "below": True}
    return Mark(name=name.format(kind), **look, **where)


def _resonance_marks(modes: xr.Dataset, tone: float, x: Array) -> list[Mark]:
    """Strongest speeds within x (speed,) at which a mesh order meets a mode, named by order and mode; all [Hz]."""
    force = np.nan_to_num(numbers(modes, "resonance_force_ratio"), nan=0.0)
    at, kinds = tone * numbers(modes, "resonance_speed"), texts(modes, "resonance_kind")
    inside = (force > 0) & (at >= x.min()) & (at <= x.max())
    inside &= np.array([one != "no" for one in texts(modes, "resonance_excited", "resonance")], dtype=bool)
    shown = [int(place) for place in ranked(force, equal=EQUAL) if inside[place]][:_RESONANCES]
    named = kept_apart(at, shown, 0.05 * float(np.ptp(x)))
    words, marks = _words(modes, "{}×{}, mode {}"), []
    for place in shown:
        # on the side that has room, over the curves on a ground of their own
        side = 8 if at[place] < x.min() + 0.02 * np.ptp(x) else -8
        where = {"yref": "y domain", "y": 0.02, "yanchor": "bottom", "textangle": -90, "xshift": side}
        where |= {"bgcolor": "rgba(255,255,255,0.8)", "borderpad": 0}
        said = words[place] if place in named else ""
        look: Trace = {"group": "marks", "words": said, "where": where}
        marks.append(kind_mark(kinds[place], "resonance, {} mode", x=float(at[place]), **look))
    return marks


def _operating_frequency(sweep: xr.Dataset, x: Array) -> float:
    """Abscissa of the operating speed, of x (speed,) [Hz] in proportion to the speed."""
    speed = numbers(sweep, "speed", "speed")
    known = np.isfinite(speed) & (speed > 0)
    return float(np.median(x[known] / speed[known])) if known.any() else np.nan


def operating_mark(sweep: xr.Dataset, x: Array) -> list[Mark]:
    """The operating speed, where it lies within x (speed,) [Hz], as a line."""
    speed = numbers(sweep, "speed", "speed")
    rank = np.argsort(speed)
    within = len(speed) and speed.min() <= 1 <= speed.max()
    at = float(np.interp(1.0, speed[rank], x[rank])) if within else np.nan
    return [Mark(x=at, width=1.5, name="operating point", group="marks")] if np.isfinite(at) else []


Row = tuple[Trace, list[tuple[Array, Trace]]]
"""Look of a panel, and its curves (speed,) with theirs."""


def _over_speed(title: str, rows: list[Row], sweep: xr.Dataset, modes: xr.Dataset | None, height: float) -> go.Figure:
    """Panels over mesh frequency with its range, modes and operating point, and crosses where nothing was found."""
    x, unit = abscissa(sweep)
    rank = np.argsort(x)
    shown = [Panel([Curve(x[rank], y[rank], width=1.7, **look) for y, look in own], **axes) for axes, own in rows]
    bad = [place for place, status in enumerate(texts(sweep, "status", "speed")) if status not in ("ok", "")]
    look: Trace = {"symbol": "x", "colour": WARNING, "group": "marks", "look": {"cliponaxis": False}}
    crosses = [points(x[bad], np.zeros(len(bad)), 9, name="no convergence", digits=(9, 9), **look)] if bad else []
    shown = [replace(shown[0], layers=[*shown[0].layers, *crosses]), *shown[1:]]
    marks = [*mode_marks(modes, sweep, x), *operating_mark(sweep, x)]
    ends = (float(x.min()), float(x.max())) if len(x) else None
    return chart(title, *shown, x=unit, x_ends=ends, marks=marks, height=height, gap=0.12)


def speed_sweep(sweep: xr.Dataset, modes: xr.Dataset | None = None) -> go.Figure:
    """RMS of the dynamic mesh force, largest mesh force [kN] and dynamic factor K_v [1] over mesh frequency [Hz].

    Natural frequencies and the operating point are lines; speeds without a solution are crosses.

    Parameters
    ----------
    sweep : Dataset of `sweep`: mesh_force_rms, mesh_force_peak [N], dynamic_factor (mesh, speed), mesh_frequency,
        status (speed).
    modes : Dataset of `modes`: frequency, mode_kind, multiplicity (mode).
    """
    names, several = texts(sweep, "mesh"), stage_count(texts(sweep, "mesh")) > 1
    kinds = list(dict.fromkeys(name.split("/")[1] for name in names if "/" in name))
    titles = {name: title for name, title in _MESH_PANELS if name in sweep.variables}
    rows = [sweep[name].transpose("mesh", "speed").values for name in titles]
    scales = [float(np.nanmax(np.abs(values), initial=0.0)) or 1.0 for values in rows]
    # curves are equal where they are so in every panel
    curves = np.hstack([values / scale for values, scale in zip(rows, scales, strict=True)])
    groups, shown = merged(names, curves, branches=True), list[Row]()
    for row, (variable, title) in enumerate(titles.items()):
        ratio = variable == "dynamic_factor"
        unit, curves_of = scales[row] / (1.0 if ratio else 1e3), list[tuple[Array, Trace]]()
        for one in groups:
            dash = DASHES[kinds.index(one.pair) % len(DASHES)] if one.pair in kinds else "solid"
            look: Trace = {"name": _mesh_name(one, several), "colour": branch_colour(one.branch), "dash": dash}
            # a K_v of 1.01 varies in its fourth place
            curves_of.append((unit * np.split(one.values, len(rows))[row], {**look, "digits": (5, 7)}))
        shown.append(({"title": title, **({"y": "K_v [-]"} if ratio else _FORCE)}, curves_of))
    return _over_speed("Mesh forces over speed", shown, sweep, modes, 140 + 250 * len(shown))


def error_sweep(sweep: xr.Dataset, modes: xr.Dataset | None = None) -> go.Figure:
    """Peak to peak of the transmission errors over mesh frequency [Hz]: of meshes [µm], of shafts [arcsec].

    Parameters
    ----------
    sweep : Dataset of `sweep`: transmission_error_KIND_peak_to_peak (mesh or shaft, speed), mesh_frequency, status
        (speed).
    modes : Dataset of `modes`: frequency, mode_kind, multiplicity (mode).
    """
    shown = list[Row]()
    for kind, (dim, unit, scale, title) in ERROR_KINDS.items():
        name = f"transmission_error_{kind}_peak_to_peak"
        if name in sweep.variables:
            links = _merged(texts(sweep, dim), scale * sweep[name].transpose(dim, "speed").values[:, None])
            own = enumerate(links, start=(len(PALETTE) - 1) * (dim == "shaft"))  # one colour a thing
            axes: Trace = {"title": title, "y": f"peak to peak [{unit}]", "y_axis": FROM_ZERO}
            shown.append((axes, [(wave[0], {"name": name, **cycled(i)}) for i, (name, wave) in own]))
    return _over_speed("Transmission error over speed", shown, sweep, modes, 140 + 250 * len(shown))


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
    bound = str(sweep["bearing_force_peak"].attrs.get("long_name", "")).startswith("bound")
    curves = [sweep[name].transpose("bearing", "speed").values for name, _ in _BEARING_PANELS]
    links = _merged(texts(sweep, "bearing"), np.stack(curves, axis=1) / 1e3)
    shown = list[Row]()
    for row, (variable, title) in enumerate(_BEARING_PANELS):
        title += " (a bound)" if bound and variable == "bearing_force_peak" else ""
        own = [(force[row], {"name": name, **cycled(i)}) for i, (name, force) in enumerate(links)]
        shown.append(({"title": title, **_FORCE}, own))
    return _over_speed("Bearing and pin forces over speed", shown, sweep, modes, 640)


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
    path = numbers(sweep, "path_frequency")
    force = np.asarray(sweep["path_force_rms"].sel(mesh=name).values, dtype=np.float64) / 1e3
    rank = np.argsort(sweep["mesh_frequency"].values, kind="stable")
    x = numbers(sweep, "mesh_frequency")[rank]
    forces, apart = _branches(sweep, path, force), list[Curve]()
    for direction in map(str, sweep["direction"].values):
        part = sweep.sel(direction=direction, mesh=name)
        above, below = _direction(part, direction, x, rank)
        forces, apart = [*forces, above], [*apart, below]
    if sweep.sizes.get("fold"):  # where a branch turns back or on
        at = [int(np.argmin(np.abs(path - fold))) for fold in sweep["fold_frequency"].values]
        ring: Trace = {"symbol": "circle-open", "outline": 2, "colour": INK}
        forces.append(points(path[at], force[at], 11, name="fold", hover="fold at %{x:.6g} Hz", **ring))
    return chart(
        f"Mesh force with contact loss, {name}",
        Panel(forces, title="RMS of the dynamic mesh force", **_FORCE),
        Panel(apart, title="teeth apart", y="time [%]", y_axis=FROM_ZERO),
        x=f"mesh frequency{of_first_stage(sweep)} [Hz]",
        x_ends=(float(x.min()), float(x.max())),
        height=640,
        gap=0.12,
        space={"row_heights": [0.7, 0.3]},
    )


def _branches(sweep: xr.Dataset, x: Array, y: Array) -> list[Curve]:
    """The whole way y [kN] over x (path,) [Hz]: a line where it is stable, dashes where not."""
    part, kind = sweep["path_part"].values, np.array(texts(sweep, "path_instability"), dtype=object)
    unstable, curves = ~np.isin(kind, ("stable", "")), []
    # runs of one kind, not across a break of the branch
    cut = np.flatnonzero((unstable[1:] != unstable[:-1]) | (np.abs(np.diff(part)) > 1))
    for run in np.split(np.arange(len(unstable)), cut + 1) if len(unstable) else ():
        first, last = int(run[0]), int(run[-1])
        end = last + 1 if last + 1 < len(x) and part[last + 1] - part[last] in (0, 1) else last
        look: Trace = {"name": "branch", "colour": PALE}
        if unstable[first]:
            look = {"name": "unstable branch", "colour": WARNING, "dash": "dash"}
        own = slice(first, end + 1)
        hover = "%{y:.4g} kN at %{x:.6g} Hz, %{text}"
        curves.append(Curve(x[own], y[own], width=2, text=[str(text) for text in kind[own]], hover=hover, **look))
    return curves


def _direction(part: xr.Dataset, direction: str, x: Array, rank: NDArray[np.int64]) -> tuple[Curve, Curve]:
    """The motions of one sweep direction over mesh frequency (P,) [Hz]: force, and part of time apart."""
    colour, width, symbol, label = _LOOK[direction]
    motion = np.array(texts(part, "motion"), dtype=object)[rank]
    own = np.isin(motion, ("symmetry broken", "period 2", "integrated"))
    marks: Trace = {"symbol": symbol, "points": np.where(own, 9 if direction == "up" else 6, 0).tolist()}
    look: Trace = {"name": label, "colour": colour, "width": width, "text": [str(text) for text in motion]}
    look["hover"] = f"{label}: %{{y:.4g}} at %{{x:.6g}} Hz, %{{text}}"
    force, apart = numbers(part, "mesh_force_rms")[rank] / 1e3, 100 * numbers(part, "contact_open")[rank]
    return Curve(x, force, **look, **marks), Curve(x, apart, **look)


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
    single, most = len(known) == 1, 1.0
    longest = max((len(words) for modes, _ in known.values() for words in _words(modes)), default=0)
    strip = 40 * len(known) + _LETTER * longest if single else 40.0 * len(known)
    room = _CURVE if rated else 12.0  # of the curves; without one nothing but the axis
    low = room / (room + strip)
    layers: list[Layer] = [OPERATING_BAND, Mark(x=100, width=1.5)]
    for place, (name, (modes, _)) in enumerate(known.items()):
        colour, curve, speed = PALETTE[place % len(PALETTE)], curves[name], _speeds(modes)
        if curve is not None:
            most = max(most, float(curve[1].max()))
            look: Trace = {"width": 2, "digits": (5, 6), "hover": "K_v %{y:.4g} at %{x:.4g} %"}
            title = "largest K_v of all meshes" if single else name
            layers.append(Curve(curve[0], curve[1], name=title, colour=colour, **look))
        if speed.size:
            where = [f" at {engineering(at)} % of the operating speed" for at in speed]
            look = {"text": [*map(str.__add__, _words(modes), where)], "hover": "%{text}", "look": {"yaxis": "y2"}}
            title = "a mesh order meets a mode" if single else f"{name}: a mesh order meets a mode"
            height = np.full(len(speed), 20 / strip if single else (0.5 + place) / len(known))
            stroke: Trace = {"symbol": "line-ns-open", "outline": 1.5, "colour": WARNING if single else colour}
            layers.append(points(speed, height, 11, name=title, **stroke, **look))
    if most >= _PARTS:
        place_of = {"x": 0.005, "xref": "paper", "xanchor": "left", "yanchor": "bottom"}
        look = {"words": f"K_v {_PARTS:g}", "where": {**place_of, "font": {"size": 12, "color": WARNING}}}
        layers.append(Mark(y=_PARTS, colour=WARNING, dash="dash", **look))
    ends = [value for curve in curves.values() if curve is not None for value in (curve[0][0], curve[0][-1])]
    ends = ends or [value for modes, _ in known.values() for value in _speeds(modes)]
    panel = Panel(
        layers,
        x=SPEED_TITLE,
        y="largest K_v [-]" if rated else "",
        x_ends=(float(min(*ends, 95.0)), float(max(*ends, 105.0))),
        y_ends=(1.0, max(1.02, 1 + 1.08 * (most - 1))),
        y_axis={"domain": [0, low], "showticklabels": rated},
    )
    strokes = {"range": [0, 1], "domain": [low, 1], "visible": False, "fixedrange": True}
    layout: Trace = {"legend": level_legend(-60 / (room + strip)), "showlegend": True, "margin": {"t": 76}}
    title = "Where in the range of speeds the resonances lie"
    drawn = chart(title, panel, height=room + strip + _AROUND, yaxis2=strokes, **layout)
    if single:
        _names(drawn, next(iter(known.values()))[0], 32 / strip)
    return drawn


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


def _words(modes: xr.Dataset | None, form: str = "{}×{} mesh, mode {}") -> list[str]:
    """``2× low mesh, mode 5`` of every resonance; the stage where the train has several."""
    if modes is None or not _speeds(modes).size:
        return []
    stage = texts(modes, "resonance_stage")
    several = len(set(stage)) > 1 or stage_count(texts(modes, "connection")) > 1
    columns = (numbers(modes, "resonance_order"), stage, numbers(modes, "resonance_mode"))
    return [
        form.format(f"{order:.0f}", f" {own}" if several else "", f"{mode:.0f}")
        for order, own, mode in zip(*columns, strict=True)
    ]


def _names(drawn: go.Figure, modes: xr.Dataset | None, height: float) -> None:
    """Names of the strongest resonances, upright above their strokes, as many as stand beside each other."""
    speed, words = _speeds(modes), _words(modes)
    if modes is None or not speed.size:
        return
    force = np.nan_to_num(numbers(modes, "resonance_force_ratio"), nan=-1.0)
    excited = texts(modes, "resonance_excited", "resonance")
    strongest = [i for i in ranked(force, equal=EQUAL) if excited[i] != "no"]
    for i in kept_apart(speed, strongest, _APART / 100 * max(float(np.ptp(speed)), 20.0), _NAMED):
        upright = {"textangle": -90, "yref": "y2", "yanchor": "bottom", "font": {"size": 11, "color": PALE}}
        note(drawn, words[i], x=float(speed[i]), y=height, **upright)
