"""Mode shapes that move: front view, and beside it a side view where bodies also move along or tilt about the axis.

Frames hold half a swing of each mode (a full turn of phase where shapes are complex); playing them forth and back
is the motion.  Displacements are exaggerated, all bodies of one mode by one factor.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from numpy.typing import NDArray

from ..drawing.bodies import Part, faces, one_per_place, parts
from ..series import Array, bent_rows, compact, engineering, numbers, ring_deflection, texts
from .renderers import INK, PALE, figure, kind_colour, note, translucent, wide_height

_STEPS = 8  # from one turning point to the other
_SWINGS = 6  # played when a mode is chosen
_REACH = 0.26  # largest displacement drawn, of the smallest gear's radius
_FRAME_TIME = 50  # [ms]
_FINE = 96  # corners of a circle that bends
_ROUND = np.linspace(0.0, 2 * math.pi, _FINE, endpoint=False)
_BYTES = 1_400_000  # of all frames, before they are compressed; one point takes about 13


class Sketch(NamedTuple):
    """One body as lines in one view: points about its centre [m], a gap (nan) after each stroke.

    body : its row in the displacements.  view : front (x, y) or side (z, y).
    at : where its centre stands on the page.  closed : whether its lines bound an area.
    bends : motion (k, e) of its points per coordinate by which the body bends, e = 0 of a rigid one.
    """

    body: int
    kind: str
    view: str
    at: complex
    points: NDArray[np.complex128]
    closed: bool
    bends: NDArray[np.complex128]


def mode_shapes(check: xr.Dataset, modes: xr.Dataset, *, most: int = 30) -> go.Figure:
    """Animated mode shapes, exaggerated: a slider chooses the mode, which then swings; a button plays all of them.

    Parameters
    ----------
    check : Dataset of `check`: what `parts.parts` reads (body), (gear).
    modes : Dataset of `modes`: full_shape (body, direction, mode), shape (dof, mode) of bodies that bend, frequency
        [Hz], mode_kind (mode).
    most : modes shown at most.
    """
    known = texts(modes, "body")
    found = [part for part in parts(check) if part.name in set(known)]
    bends = _bends(modes)
    swings = [_swing(shape, known, found, bends) for shape in np.moveaxis(_shapes(modes, most), 2, 0)]
    sketches = _sketches(found, bends, axial=_axial(swings))
    swings = swings[: _affordable(sketches, swings)]
    hertz, kinds = numbers(modes, "frequency"), texts(modes, "mode_kind", "mode")
    first = next((place for place in range(len(swings)) if hertz[place] > 1e-3), 0)
    drawn = figure("Mode shapes, exaggerated", height=640)
    drawn.add_traces(_traces(sketches, np.zeros(swings[0].shape), ghost=True))
    ghosts = len(drawn.data)
    drawn.add_traces(_traces(sketches, _phase(swings[first], 0.0)))
    moving = list(range(ghosts, len(drawn.data)))
    drawn.frames = [
        {
            "name": f"{mode}.{step}",
            "data": _traces(sketches, _phase(swing, phase), data_only=True),
            "traces": moving,
            "layout": {"sliders": [{"active": mode}]},
        }
        for mode, swing in enumerate(swings)
        for step, phase in enumerate(_phases(swing))
    ]
    _frame(drawn, sketches)
    titles = [f"mode {i + 1}: {engineering(float(hertz[i]))} Hz, {kinds[i]}" for i in range(len(swings))]
    _controls(drawn, titles, [np.iscomplexobj(swing) for swing in swings], first)
    return drawn


def _shapes(modes: xr.Dataset, most: int) -> NDArray[Any]:
    """Shapes (body, 6 + e, mode): x .. rz of every body, and behind them the coordinates by which it bends."""
    values: NDArray[Any] = np.asarray(modes["full_shape"].transpose("body", "direction", "mode").values)[:, :, :most]
    names, bends = texts(modes, "body"), _bends(modes)
    if bends:
        shape = modes["shape"].transpose("dof", "mode").values[:, :most]
        bent = np.zeros((len(names), max(map(len, bends.values())), values.shape[2]), shape.dtype)
        for body, rows in bends.items():
            bent[names.index(body), : len(rows)] = shape[list(rows.values())]
        values = np.concatenate([values, bent], axis=1)
    # a shape that is real up to rounding swings, it does not whirl
    return values if float(np.abs(values.imag).max(initial=0.0)) >= 1e-9 else np.asarray(values.real)


def _bends(modes: xr.Dataset) -> Mapping[str, Mapping[str, int]]:
    """Body that bends -> name a2, b2, .. of each coordinate by which it does and its row among the coordinates."""
    return bent_rows(texts(modes, "dof")) if "shape" in modes.variables else {}


def _swing(
    shape: NDArray[Any], bodies: Sequence[str], found: Sequence[Part], bends: Mapping[str, Mapping[str, int]]
) -> NDArray[Any]:
    """Displacements (body, 6 + e) in stage axes, torsion [rad], scaled so that the largest one is well visible."""
    place = {name: row for row, name in enumerate(bodies)}
    swing = np.array([shape[place[part.name]] for part in found])
    swing[:, 3:5] *= np.array([part.outer for part in found])[:, None]
    largest = float(np.abs(swing[:, :6]).max(initial=0.0))
    for move, part in zip(swing, found, strict=True):
        own = tuple(bends.get(part.name, ()))
        bent = np.linalg.norm(ring_deflection(own, _ROUND) @ move[6 : 6 + len(own)], axis=0)
        largest = max(largest, float(bent.max()))
    largest = largest or 1.0
    smallest = min((part.form.reference_radius for part in found if part.form), default=1.0)
    swing = swing * (_REACH * smallest / largest)
    swing[:, 3:5] /= np.array([part.outer for part in found])[:, None]
    swing[:, 5] /= [part.reach for part in found]
    cos, sin = (function([part.angle for part in found]) for function in (np.cos, np.sin))
    for first, second in ((0, 1), (3, 4)):
        x, y = swing[:, first].copy(), swing[:, second].copy()
        swing[:, first], swing[:, second] = cos * x - sin * y, sin * x + cos * y
    return swing


def _axial(swings: Sequence[NDArray[Any]]) -> bool:
    """Whether any mode (bodies, 6 + e) moves along or tilts about the axis."""
    largest = max((float(np.abs(swing[:, :3]).max(initial=0.0)) for swing in swings), default=0.0)
    return any(float(np.abs(swing[:, 2:5]).max(initial=0.0)) > 1e-6 * largest for swing in swings)


def _affordable(sketches: Sequence[Sketch], swings: Sequence[NDArray[Any]]) -> int:
    """Number of modes (bodies, 6 + e) whose frames stay within the size of a page that is passed on by mail."""
    points = sum(len(sketch.points) for sketch in sketches)
    frames = max((len(_phases(swing)) for swing in swings), default=1)
    return max(6, _BYTES // (13 * points * frames))


def _phase(swing: NDArray[Any], phase: float) -> Array:
    """Displacements (bodies, 6 + e) at one phase [rad] of a swing."""
    return np.asarray((swing * np.exp(1j * phase)).real, dtype=np.float64)


def _phases(swing: NDArray[Any]) -> Array:
    """Phases (frames,) [rad] of half a swing, or of a turn where the shape (bodies, 6 + e) is complex."""
    turning = np.iscomplexobj(swing)
    return math.pi * np.arange(2 * _STEPS if turning else _STEPS + 1) / _STEPS


def _order(mode: int, turning: bool, swings: int) -> list[str]:
    """Names of the frames of one mode in the order in which they are played."""
    steps = list(range(2 * _STEPS)) if turning else [*range(_STEPS), *range(_STEPS, 0, -1)]
    return [f"{mode}.{step}" for step in steps] * swings + [f"{mode}.0"]


def _sketches(found: Sequence[Part], bends: Mapping[str, Mapping[str, int]], *, axial: bool) -> list[Sketch]:
    place, sketches = {part.name: row for row, part in enumerate(found)}, list[Sketch]()
    for part in one_per_place(found):
        at, closed = complex(part.x + part.offset, part.y), part.form is None or not part.form.internal
        own = tuple(bends.get(part.name, ()))
        points = _front(part, found, _FINE if own else None)
        out, along = ring_deflection(own, np.angle(points))
        bent = np.exp(1j * np.angle(points))[:, None] * (out + 1j * along)
        sketches.append(Sketch(place[part.name], part.kind, "front", at, points, closed, bent))
    if not axial:
        return sketches
    right = max(part.offset + part.radius + part.outer for part in found)
    left = min(part.station - _half(part) for part in found)
    shift = right + 0.35 * max(part.radius + part.outer for part in found) - left
    for part in found:
        at, corner = complex(part.station + shift, part.y), complex(_half(part), part.outer)
        box = _strokes([np.array([-corner, corner.conjugate(), corner, -corner.conjugate(), -corner])])
        sketches.append(Sketch(place[part.name], part.kind, "side", at, box, True, np.zeros((len(box), 0), complex)))
    return sketches


def _strokes(pieces: Sequence[NDArray[np.complex128]]) -> NDArray[np.complex128]:
    """Lines (k,) [m] one after the other, a gap after each."""
    gap = np.array([complex(math.nan, math.nan)])
    return np.concatenate([part for piece in pieces for part in (piece, gap)])


def _front(part: Part, found: Sequence[Part], corners: int | None) -> NDArray[np.complex128]:
    """A gear as its reference circle with a cross, a ring with marks on its rim, a carrier as arms to its pins.

    corners : of the circle, where they are not the usual ones.
    """
    pins = [complex(pin.x, pin.y) for pin in one_per_place(found) if pin.carried_by == part.name]
    if pins:
        rim = sorted(pins, key=lambda pin: math.atan2(pin.imag, pin.real))
        return _strokes([np.array([*rim, rim[0]]), *[np.array([0j, pin]) for pin in pins]])
    ring = part.form is not None and part.form.internal
    radius = part.form.reference_radius if part.form else part.outer
    points = corners or (48 if ring else 36)  # corners that a circle shows at 400 px: none
    circle = radius * np.exp(2j * math.pi * np.arange(points + 1) / points)
    count, ends = (12, [radius, part.outer]) if ring else (4, [0.0, radius])
    marks = [np.exp(2j * math.pi * k / count) * np.array(ends, dtype=np.complex128) for k in range(count)]
    return _strokes([circle, *marks])


def _half(part: Part) -> float:
    """Half the axial length of a body [m]."""
    if part.form is None:
        return 0.08 * part.outer
    extent = faces(part)
    return (extent[-1][1] - extent[0][0]) / 2


def _traces(
    sketches: Sequence[Sketch], moved: Array, *, ghost: bool = False, data_only: bool = False
) -> list[dict[str, Any]]:
    """One trace a kind of body in both views, moved (bodies, 6 + e) [m, rad]; of a frame the coordinates alone."""
    groups = dict.fromkeys((sketch.kind, sketch.closed) for sketch in sketches)
    traces = []
    for kind, closed in groups:
        own = [one for one in sketches if (one.kind, one.closed) == (kind, closed)]
        points = np.concatenate([_moved(sketch, moved[sketch.body]) for sketch in own])
        colour = kind_colour(kind)
        look = {
            "mode": "lines",
            "line": {"color": "#C5CCD3" if ghost else colour, "width": 1 if ghost else 2},
            "fill": "toself" if closed and not ghost else "none",
            "fillcolor": translucent(colour, 0.10),
            "name": kind,
            "legendgroup": kind,
            "showlegend": not ghost and own[0].view == "front",
            "hoverinfo": "skip",
        }
        x, y = compact(1e3 * points.real, digits=4), compact(1e3 * points.imag, digits=4)
        traces.append({"type": "scatter", "x": x, "y": y, **({} if data_only else look)})
    return traces


def _moved(sketch: Sketch, move: Array) -> NDArray[np.complex128]:
    """Front: x + iy, bent, and turned by rz.  Side, seen from -x: z + iy, where a tilt rx > 0 turns y towards z."""
    front = sketch.view == "front"
    turn = np.exp(1j * (move[5] if front else -move[3]))
    bent = sketch.points + sketch.bends @ move[6 : 6 + sketch.bends.shape[1]]
    moved: NDArray[np.complex128] = sketch.at + complex(move[0] if front else move[2], move[1]) + bent * turn
    return moved


def _frame(drawn: go.Figure, sketches: Sequence[Sketch]) -> None:
    """Room for the motion, no ticks (lengths are exaggerated), the views named."""
    ends = {
        view: np.concatenate([one.at + one.points for one in sketches if one.view == view])
        for view in dict.fromkeys(one.view for one in sketches)
    }
    every = np.concatenate(list(ends.values()))
    across, tall = 1e3 * np.nanmax(every.real) - 1e3 * np.nanmin(every.real), 1e3 * np.nanmax(np.abs(every.imag))
    margin = 0.05 * across
    axis = {"showgrid": False, "showticklabels": False, "ticks": "", "showline": False}
    low, high = 1e3 * float(np.nanmin(every.real)) - margin, 1e3 * float(np.nanmax(every.real)) + margin
    drawn.update_layout(height=wide_height(high - low, 2.32 * tall))
    drawn.update_xaxes(range=[low, high], **axis)
    drawn.update_yaxes(range=[-1.12 * tall, 1.2 * tall], scaleanchor="x", **axis)
    for view, points in ends.items() if len(ends) > 1 else ():
        middle = 5e2 * float(np.nanmin(points.real) + np.nanmax(points.real))
        words = {"front": "front view", "side": "side view, z to the right"}[view]
        note(drawn, words, x=middle, y=1.2 * tall, yanchor="top", xanchor="center")


def _controls(drawn: go.Figure, names: Sequence[str], turning: Sequence[bool], first: int) -> None:
    timing = {"mode": "immediate", "frame": {"duration": _FRAME_TIME, "redraw": True}, "transition": {"duration": 0}}
    still = {"mode": "immediate", "frame": {"duration": 0, "redraw": True}, "transition": {"duration": 0}}
    steps = [
        {"label": name, "method": "animate", "args": [_order(mode, turning[mode], _SWINGS), timing]}
        for mode, name in enumerate(names)
    ]
    everything = [frame for mode in range(len(names)) for frame in _order(mode, turning[mode], 2)]
    buttons = [
        {"label": "▶ Play all", "method": "animate", "args": [everything, timing]},
        {"label": "■ Stop", "method": "animate", "args": [[None], still]},
    ]
    slider = {
        "active": first,
        "steps": steps,
        **{"x": 0.22, "len": 0.78, "xanchor": "left", "y": 0, "yanchor": "top", "pad": {"t": 12, "b": 0}},
        **{"font": {"color": "rgba(0,0,0,0)", "size": 1}, "ticklen": 4, "tickcolor": PALE},
        "currentvalue": {"font": {"size": 15, "color": INK}, "xanchor": "left", "offset": 8},
    }
    menu = {
        **{"type": "buttons", "direction": "right", "buttons": buttons, "showactive": False},
        **{"x": 0, "xanchor": "left", "y": 0, "yanchor": "top", "pad": {"t": 22}},
    }
    drawn.update_layout(sliders=[slider], updatemenus=[menu], margin={"l": 16, "b": 96})
