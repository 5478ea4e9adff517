"""The train from the front, to scale: every gear with its true teeth in mesh, circles, names, senses of rotation."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..charts.style import INK, PALE, WARNING, figure, kind_colour, tint, wide_height
from ..series import Array, compact, engineering, numbers, texts
from .bodies import Mating, Part, matings, one_per_place, outline, parts, stages, turns

_ORDER = {"carrier": 0, "ring": 1, "body": 2, "gear": 3, "planet": 4, "sun": 5}


def train_front(check: xr.Dataset) -> go.Figure:
    """Front view of every stage to scale [mm], seen from the right end (counter-clockwise positive), teeth in mesh.

    Parameters
    ----------
    check : Dataset of `check`: what `parts.parts` and `parts.matings` read (body), (gear), (mesh).
    """
    found = [part for part in one_per_place(parts(check)) if part.stage in stages(parts(check))]
    turned = turns(check, found)
    apart = "; stages side by side, not as they stand" if len(stages(found)) > 1 else ""
    drawn = figure(f"Front view, to scale{apart}", x="x [mm]", y="y [mm]", height=620)
    for part in sorted(found, key=lambda one: (_ORDER.get(one.kind, 2), -one.outer)):
        for trace in _body(part, turned.get(part.name, 0.0), found):
            drawn.add_trace(trace)
    drawn.add_traces([_circles(check, found), *_hidden(found), *_actions(check, found)])
    drawn.add_traces([*_held(check, found), *_senses(found), *_names(check, found)])
    _frame(drawn, found)
    return drawn


def _circle(x: float, y: float, radius: float, points: int = 121) -> tuple[Array, Array]:
    angle = np.linspace(0, 2 * math.pi, points)
    return x + radius * np.cos(angle), y + radius * np.sin(angle)


def _line(x: Array, y: Array, options: Mapping[str, Any]) -> go.Scatter:
    """A line through x, y (k,) [m], drawn in [mm]."""
    plain = {"mode": "lines", "hoverinfo": "skip", "showlegend": False}
    return go.Scatter(x=compact(1e3 * x), y=compact(1e3 * y), **{**plain, **options})


def _describe(part: Part) -> str:
    teeth = f"{part.form.teeth} teeth" if part.form else ""
    speed = f"{engineering(part.speed)} rpm" if np.isfinite(part.speed) else ""
    mass = f"{engineering(part.mass)} kg" if np.isfinite(part.mass) and part.mass > 0 else ""
    return "<br>".join(text for text in (f"<b>{part.short}</b>", teeth, speed, mass) if text)


def _body(part: Part, turn: float, found: Sequence[Part]) -> list[go.Scatter]:
    """Opaque in a tint of its colour, the carrier behind the gears with its hidden edges dashed over them."""
    colour, x, y = kind_colour(part.kind), part.x + part.offset, part.y
    line = {"line": {"color": colour, "width": 1.2}}
    filled = {"fillcolor": tint(colour, 0.78), "fill": "toself", "hoverinfo": "text", "text": _describe(part)}
    look = {**line, **filled, "hoveron": "fills"}
    if part.form is None:
        pins = [other for other in found if other.carried_by == part.name]
        return [_line(*(_arms(part, pins) if pins else _circle(x, y, part.outer)), look)]
    teeth = outline(part.form, turn)
    edge = (teeth[0] + x, teeth[1] + y)
    if not part.form.internal:
        return [_line(*edge, look)]
    rim = _circle(x, y, part.outer)
    band = np.concatenate([rim[0], edge[0][::-1]]), np.concatenate([rim[1], edge[1][::-1]])
    return [_line(*band, {**look, "line": {"width": 0, "color": colour}}), _line(*edge, line), _line(*rim, line)]


def _hidden(found: Sequence[Part]) -> list[go.Scatter]:
    carriers = [(part, [pin for pin in found if pin.carried_by == part.name]) for part in found]
    pieces = [_arms(part, pins) for part, pins in carriers if pins]
    look = {"line": {"color": tint(PALE, 0.45), "width": 1, "dash": "dash"}}  # faint: names stand over it
    return [_line(*_joined(pieces), look)] if pieces else []


def _arms(part: Part, pins: Sequence[Part]) -> tuple[Array, Array]:
    """Outline of a carrier: a plate whose lobes hold the pins."""
    angle = np.linspace(0, 2 * math.pi, 361)
    reach = np.full(angle.shape, 0.62 * part.outer)
    for pin in pins:
        away = np.angle(np.exp(1j * (angle - math.atan2(pin.y, pin.x))))
        reach = np.maximum(reach, part.outer * (0.62 + 0.38 * np.exp(-((away / 0.42) ** 4))))
    return part.x + part.offset + reach * np.cos(angle), part.y + reach * np.sin(angle)


def _joined(pieces: Sequence[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Lines (k,) [m] as one, a gap after each."""
    gap = np.array([np.nan])
    empty = np.zeros(0)
    return (
        np.concatenate([part for x, _ in pieces for part in (x, gap)] or [empty]),
        np.concatenate([part for _, y in pieces for part in (y, gap)] or [empty]),
    )


def _circles(check: xr.Dataset, found: Sequence[Part]) -> go.Scatter:
    """Pitch circles of every gear, one for each mesh that works at another angle; else its reference circle."""
    angles: dict[str, set[float]] = {}
    for one in matings(check):
        for name in (one.a, one.b):
            if np.isfinite(one.pressure_angle):
                angles.setdefault(name, set()).add(round(one.pressure_angle, 6))
    pieces = []
    for part in found:
        if part.form is not None:
            radii = [part.form.base_radius / math.cos(angle) for angle in sorted(angles.get(part.name, ()))]
            for radius in radii or [part.form.reference_radius]:
                pieces.append(_circle(part.x + part.offset, part.y, radius, 73))
    line = {"color": PALE, "width": 1, "dash": "dashdot"}
    return _line(*_joined(pieces), {"name": "pitch circles", "showlegend": True, "line": line})


def _still(check: xr.Dataset) -> set[str]:
    """Bodies that do not turn: without speed, or held by the housing about their axis."""
    speed = numbers(check, "speed", "body")
    found = {name for name, value in zip(texts(check, "body"), speed, strict=True) if value == 0}
    if "link" in check.dims:
        rigid = np.isinf(check["link_stiffness"].sel(direction="rz").values)
        ends = zip(texts(check, "link_first"), texts(check, "link_second"), rigid, strict=True)
        found |= {first for first, second, fixed in ends if fixed and not second}
    return found


def _held(check: xr.Dataset, found: Sequence[Part]) -> list[go.Scatter]:
    """Strokes of the housing around a held ring, within another held gear."""
    still, pieces = _still(check), []
    for part in found:
        if part.name in still and part.form is not None and not part.branch:
            radius = part.outer if part.form.internal else 0.88 * part.form.root_radius
            deep = 0.03 * part.outer
            count = 48 if part.form.internal else 16
            for angle in 2 * math.pi * np.arange(count) / count:
                outwards = deep if part.form.internal else -deep
                ends = np.array([radius, radius + outwards])
                both = np.array([angle, angle + 1.6 * outwards / radius])
                pieces.append((part.x + part.offset + ends * np.cos(both), part.y + ends * np.sin(both)))
            pieces.append(_circle(part.x + part.offset, part.y, radius))
    line = {"line": {"color": INK, "width": 1.2}, "name": "held", "showlegend": True}
    return [_line(*_joined(pieces), line)] if pieces else []


def _actions(check: xr.Dataset, found: Sequence[Part]) -> list[go.Scatter]:
    """Line of action of every mesh through its pitch point, where the working angle is known."""
    place = {part.name: part for part in found}
    pairs = [(mating, place.get(mating.a), place.get(mating.b)) for mating in matings(check)]
    pieces = [_action(one, a, b) for one, a, b in pairs if a and b and np.isfinite(one.pressure_angle)]
    if not pieces:
        return []
    x, y = (np.array([piece[axis].mean() for piece in pieces]) for axis in (0, 1))
    group = {"legendgroup": "action"}
    line = {"line": {"color": WARNING, "width": 1.6}, "name": "lines of action", "showlegend": True}
    marks = {"mode": "markers", "marker": {"color": WARNING, "size": 5}}
    return [_line(*_joined(pieces), {**group, **line}), _line(x, y, {**group, **marks})]


def _action(mating: Mating, a: Part, b: Part) -> tuple[Array, Array]:
    assert a.form is not None
    assert b.form is not None
    e = np.array([math.cos(mating.direction), math.sin(mating.direction)])
    t = np.array([-e[1], e[0]])
    pitch = np.array([a.x + a.offset, a.y]) + a.form.base_radius / math.cos(mating.pressure_angle) * e
    normal = math.sin(mating.pressure_angle) * e + mating.flank * math.cos(mating.pressure_angle) * t
    reach = 0.42 * min(a.form.reference_radius, b.form.reference_radius)
    ends = np.stack([pitch - reach * normal, pitch + reach * normal])
    return ends[:, 0], ends[:, 1]


def _senses(found: Sequence[Part]) -> list[go.Scatter]:
    """Arc arrows of the absolute speeds, one for all gears that turn alike on one axis."""
    arcs, heads = [], []
    for part in {
        (one.x + one.offset, one.y, one.speed, one.form is not None and one.form.internal): one for one in found
    }.values():
        if part.form is None or not np.isfinite(part.speed) or part.speed == 0:
            continue
        rim = (part.form.root_radius + part.outer) / 2
        radius = rim if part.form.internal else 0.72 * part.form.root_radius
        half = 16 if part.form.internal else 38
        angles = np.radians(np.linspace(90 - half, 90 + half, 20))
        path = angles if part.speed > 0 else angles[::-1]
        x, y = part.x + part.offset + radius * np.cos(path), part.y + radius * np.sin(path)
        arcs.append((x, y))
        along = math.degrees(path[-1]) + (90 if part.speed > 0 else -90)
        heads.append((x[-1], y[-1], 90 - along))
    if not arcs:
        return []
    at = np.array(heads)
    head = {"mode": "markers", "marker": {"symbol": "arrow", "size": 11, "color": INK, "angle": compact(at[:, 2])}}
    arc = {"line": {"color": INK, "width": 1.8}, "name": "sense of rotation", "showlegend": True}
    group = {"legendgroup": "sense"}
    return [_line(*_joined(arcs), {**arc, **group}), _line(at[:, 0], at[:, 1], {**head, **group})]


def _names(check: xr.Dataset, found: Sequence[Part]) -> list[go.Scatter]:
    """Names in the gears, one for all on one axis; that of a ring above and that of a carrier below the stage.

    Where there are several stages each has its own name on top.
    """
    several = len(stages(found)) > 1
    still = _still(check)
    low, high = _ends(found)
    shown = 780.0 / (1e-9 + 1.08 * (high - low))  # [px/m] of a figure of 900 px that its width limits
    shown = min(shown, 440.0 / (2.36 * max((part.radius + part.outer for part in found), default=1.0)))
    rows: dict[tuple[int, str], list[tuple[float, float, str]]] = {}
    outside: dict[tuple[str, str], list[Part]] = {(stage, "top"): [] for stage in stages(found)} if several else {}
    axes: dict[tuple[float, float], list[Part]] = {}
    for part in found:
        if part.form is None or part.form.internal:
            outside.setdefault((part.stage, "top" if part.form else "bottom"), []).append(part)
        else:
            axes.setdefault((round(part.x + part.offset, 9), round(part.y, 9)), []).append(part)
    for (x, y), own in axes.items():
        room = 1.7 * max(part.form.root_radius for part in own if part.form) * shown
        text, size = _fitting(own, still, room)
        rows.setdefault((size, "middle center"), []).append((x, y, text))
    for (stage, side), own in outside.items():
        reach = max(other.radius + other.outer for other in found if other.stage == stage)
        height = (1 if side == "top" else -1) * 1.05 * reach
        head = [f"<b>{stage}</b>"] if several and side == "top" else []
        text = "<br>".join([*head, *(_name(part, still) for part in own)])
        middle = next(part.offset for part in found if part.stage == stage)
        rows.setdefault((12, f"{side} center"), []).append((own[0].x + middle if own else middle, height, text))
    return [
        _line(
            np.array([x for x, _, _ in own]),
            np.array([y for _, y, _ in own]),
            {
                "mode": "text",
                "text": [text for _, _, text in own],
                "textposition": place,
                "textfont": {"size": size, "color": INK},
            },
        )
        for (size, place), own in rows.items()
    ]


def _fitting(own: Sequence[Part], still: Collection[str], room: float) -> tuple[str, int]:
    """Name and teeth of the gears on one axis in the largest type that so many pixels hold, else the branch alone."""
    tried = [
        _name(own[0], still)
        if len(own) == 1
        else "<br>".join(_name(part, still).replace("<br>", ", ") for part in own),
        "<br>".join(part.short for part in own),
        str(own[0].branch or own[0].short),
    ]
    for text in tried:
        wide = max(len(line) for line in text.split("<br>"))
        for size in (12, 11, 10, 9):
            if 0.56 * size * wide <= room and 1.3 * size * (text.count("<br>") + 1) <= room:
                return text, size
    return tried[-1], 9


def _name(part: Part, still: Collection[str]) -> str:
    teeth = f"z = {part.form.teeth}" if part.form else ""
    if part.form is not None and not part.form.internal:
        held = ", held" if part.name in still and not part.branch else ""
        return f"{part.short}<br>{teeth}{held}"
    turning = f"{engineering(abs(part.speed))} rpm {'↺' if part.speed > 0 else '↻'}"
    speed = "held" if part.name in still else turning if np.isfinite(part.speed) else ""
    return ", ".join(text for text in (part.short, teeth, speed) if text)


def _ends(found: Sequence[Part]) -> tuple[float, float]:
    """Of the drawing along x [m]."""
    low = min((part.offset - part.radius - part.outer for part in found), default=-1.0)
    return low, max((part.offset + part.radius + part.outer for part in found), default=1.0)


def _frame(drawn: go.Figure, found: Sequence[Part]) -> None:
    low, high = _ends(found)
    tall = max((part.radius + part.outer for part in found), default=1.0)
    drawn.update_xaxes(range=[1.04e3 * low, 1.04e3 * high], constrain="domain", showgrid=False)
    rings = Counter(part.stage for part in found if part.form is not None and part.form.internal)
    lines = max(rings.values(), default=1) + (len(stages(found)) > 1)
    above = 1.18 + 0.09 * max(lines - 1, 0)  # a line of text for each further ring, and for the name of the stage
    drawn.update_yaxes(range=[-1.18e3 * tall, above * 1e3 * tall], scaleanchor="x", constrain="domain", showgrid=False)
    if len(stages(found)) > 1:
        drawn.update_layout(height=wide_height(high - low, 2.36 * tall))
    drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.13, "yanchor": "top"})
