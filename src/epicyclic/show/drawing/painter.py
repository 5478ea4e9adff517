"""Display lists painted by plotly: the two figures of the train, from the front and in axial section."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..charts.renderers import INK, PALE, WARNING, figure, kind_colour, note, tint, wide_height
from ..series import compact, engineering, numbers, texts
from .bodies import Area, DrawnShape, Part, Points, Stroke, Symbol, Text, drawn_train, lines_of, polygon, stages
from .front import front_ends, front_notes, front_parts, front_shapes
from .section import section_names, section_shapes
from .section_layout import MARGIN, WIDE, SectionLayout, layout_of

# Share of white in the fill, width of the edge [px].
_AREAS = {
    "body": (0.78, 1.2),
    "cut": (0.62, 1.3),
    "shaft": (0.75, 1.3),
    "pin of the housing": (0.8, 1.0),
    "flange": (0.0, 1.0),
}
# Of roles that are not painted None: the page's own, and what a name says here.
_LINES: Mapping[str, Mapping[str, Any] | None] = {
    "turning": None,
    "held hub": None,
    "mesh beside": None,
    "hidden edge": {"line": {"color": tint(PALE, 0.45), "width": 1, "dash": "dash"}},  # faint: names stand over it
    "pitch circle": {"line": {"color": PALE, "width": 1, "dash": "dashdot"}, "name": "pitch circles"},
    "line of action": {"line": {"color": WARNING, "width": 1.6}, "name": "lines of action", "legendgroup": "action"},
    "held": {"line": {"color": INK, "width": 1.2}, "name": "held", "legendrank": 1001},
    "sense of rotation": {
        **{"line": {"color": INK, "width": 1.8}, "name": "sense of rotation"},
        **{"legendgroup": "sense", "legendrank": 1002},
    },
    "helix": {"line": {"width": 1}},
    "mesh": {"line": {"color": WARNING, "width": 3}, "name": "meshes"},
    "couplings": {"line": {"color": INK, "width": 2, "dash": "dot"}, "name": "couplings"},
    "stem": {"line": {"color": INK, "width": 1.6}},
    "housing": {"line": {"color": INK, "width": 1.3}, "name": "housing"},
    "axis": {"line": {"color": PALE, "width": 1.2, "dash": "longdashdot"}},
    "scale bar": {"line": {"color": INK, "width": 1.6}},
}
_SEAT = {"size": 11, "line": {"width": 1.4, "color": INK}}
_MARKS: Mapping[str, Mapping[str, Any]] = {
    "mesh": {"marker": {"color": WARNING, "size": 5}, "legendgroup": "action"},
    "arrow head": {"marker": {"symbol": "arrow", "size": 11, "color": INK}, "legendgroup": "sense"},
    "elastic": {"marker": {"symbol": "square-x-open", "color": INK, **_SEAT}, "name": "elastic support or bearing"},
    "rigid": {"marker": {"symbol": "square-x", "color": "#9AA5B1", **_SEAT}, "name": "rigid support or bearing"},
    "axial": {
        "marker": {"symbol": "line-ns-open", "size": 13, "color": INK, "line": {"width": 1.8, "color": INK}},
        "name": "holds axially",
    },
}
_BARS = 9.0  # of what holds axially, from the middle of its bearing [px]


def train_front(check: xr.Dataset) -> go.Figure:
    """Front view of every stage to scale [mm], seen from the right end (counter-clockwise positive), teeth in mesh.

    Parameters
    ----------
    check : Dataset of `check`: what `drawn_train` reads.
    """
    train = drawn_train(check)
    found = front_parts(train)
    apart = "; stages side by side, not as they stand" if len(stages(found)) > 1 else ""
    drawn = figure(f"Front view, to scale{apart}", x="x [mm]", y="y [mm]", height=620)
    paint(drawn, [*front_shapes(train, found), *front_notes(train, found)])
    _frame_front(drawn, found)
    return drawn


def train_section(check: xr.Dataset) -> go.Figure:
    """Axial section [mm] through the axis and branch 1, branches turned into the plane, stages in series.

    Gears end at their pitch circles, face widths and radii to scale; shafts, couplings and what lies between the
    stages are a scheme.  A half section, or both halves where a branch has planets on two axes.

    Parameters
    ----------
    check : Dataset of `check`: what `drawn_train` and `section_layout.layout_of` read.
    """
    train = drawn_train(check)
    layout = layout_of(check, train)
    # whether every gear has its face width from the model
    given = "gear" not in check.dims or bool(np.isfinite(numbers(check, "face_width", "gear")).all())
    title = "Axial section, gears to scale" if given else "Axial section, radii to scale (face widths are not given)"
    several = len({part.split("/")[0] for part in texts(check, "gear")}) > 1
    drawn = figure(
        title + "; stages in series, what lies between is a scheme" * several, y="distance from the axis [mm]"
    )
    paint(drawn, [*section_shapes(train, layout), *section_names(layout)], pixel=1e3 * layout.length(1))
    _frame_section(drawn, layout)
    return drawn


def paint(drawn: go.Figure, shapes: Sequence[DrawnShape], *, pixel: float = 1.0) -> None:
    """Paint a display list; lines and marks of one role that follow each other are one trace.

    Parameters
    ----------
    pixel : size of a pixel [mm].
    """
    for (kind, role, body_kind), own in groupby(
        shapes, lambda one: (type(one), one.role, one.kind if one.role == "helix" else "")
    ):
        PAINTERS[kind](drawn, role, body_kind, list(own), pixel)


def _areas(drawn: go.Figure, role: str, _: str, own: Sequence[Area], pixel: float) -> None:
    """Opaque in a tint of the colour of its kind; of one with a hole the edges stand apart from the fill."""
    white, width = _AREAS[role]
    for shape in own:
        colour = kind_colour(shape.kind) if shape.kind else INK
        hover = {"hoverinfo": "text", "hoveron": "fills", "text": shape.hover} if shape.hover else {}
        filled = {"fill": "toself", "fillcolor": tint(colour, white), **hover}
        edge = {"line": {"color": colour, "width": width}}
        first, *further = lines_of(shape)
        if not further:
            drawn.add_trace(_trace(first, {**edge, **filled}))
            continue
        band = np.concatenate([first, *(line[::-1] for line in further)])
        drawn.add_trace(_trace(band, {**filled, "line": {"width": 0, "color": colour}}))
        drawn.add_traces([_trace(line, edge) for line in (first, *further)])


def _lines(drawn: go.Figure, role: str, kind: str, own: Sequence[Stroke], pixel: float) -> None:
    look = _LINES[role]
    if look is None:
        return
    line = {"color": kind_colour(kind), **look["line"]} if kind else look["line"]
    gap = np.array([complex(math.nan, math.nan)])
    pieces = [points for shape in own for stroke in lines_of(shape) for points in (stroke, gap)]
    drawn.add_trace(_trace(np.concatenate(pieces), {**look, "line": line, "showlegend": "name" in look}))


def _marks(drawn: go.Figure, role: str, _: str, own: Sequence[Symbol], pixel: float) -> None:
    look = _MARKS[role]
    at = np.array([shape.at for shape in own])
    if role == "axial":  # a bar on either side
        at = (at[:, None] + _BARS * pixel * np.array([-1, 1])).ravel()
    marker = look["marker"]
    if role == "arrow head":  # plotly turns clockwise from upright
        marker = {**marker, "angle": compact([90 - math.degrees(shape.turn) for shape in own])}
    hover = {"hoverinfo": "text", "text": [shape.hover for shape in own]} if own[0].hover else {}
    drawn.add_trace(_trace(at, {**look, **hover, "marker": marker, "mode": "markers", "showlegend": "name" in look}))


def _texts(drawn: go.Figure, role: str, _: str, own: Sequence[Text], pixel: float) -> None:
    for shape in own:
        (across, up), (right, lift) = shape.anchor, shape.shift
        look: dict[str, Any] = {"xanchor": across, "yanchor": up, "font": {"size": shape.size, "color": INK}}
        look |= {"xshift": right} if right else {}
        look |= {"yshift": lift} if lift else {}
        look |= {"textangle": -90} if shape.upright else {}
        if shape.backing == "white":
            look["bgcolor"] = "white"
        elif shape.backing:
            look |= {"bgcolor": tint(kind_colour(shape.backing), _AREAS["cut"][0]), "borderpad": 1}
        note(drawn, shape.text, x=round(shape.at.real, 3), y=round(shape.at.imag, 3), **look)


PAINTERS: Mapping[type[DrawnShape], Callable[..., None]] = {Area: _areas, Stroke: _lines, Symbol: _marks, Text: _texts}


def _trace(points: Points, options: Mapping[str, Any]) -> go.Scatter:
    """A line through points x + iy (k,) [mm]."""
    plain = {"mode": "lines", "hoverinfo": "skip", "showlegend": False}
    return go.Scatter(x=compact(points.real), y=compact(points.imag), **{**plain, **options})


def _frame_front(drawn: go.Figure, found: Sequence[Part]) -> None:
    low, high = front_ends(found)
    tall = max((part.radius + part.outer for part in found), default=1.0)
    drawn.update_xaxes(range=[1.04e3 * low, 1.04e3 * high], constrain="domain", showgrid=False)
    rings = Counter(part.stage for part in found if part.form is not None and part.form.internal)
    lines = max(rings.values(), default=1) + (len(stages(found)) > 1)
    above = 1.18 + 0.09 * max(lines - 1, 0)  # a line of text for each further ring, and for the name of the stage
    drawn.update_yaxes(range=[-1.18e3 * tall, above * 1e3 * tall], scaleanchor="x", constrain="domain", showgrid=False)
    if len(stages(found)) > 1:
        drawn.update_layout(height=wide_height(high - low, 2.36 * tall))
    drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.13, "yanchor": "top"})


def _frame_section(drawn: go.Figure, layout: SectionLayout) -> None:
    """Axis, scale bar, and a range in which everything has room."""
    first, last = layout.columns[0], layout.columns[-1]
    low = 1e3 * layout.beyond(first, "left", first.rooms["left"] + MARGIN)
    high = 1e3 * layout.beyond(last, "right", last.rooms["right"] + MARGIN)
    pixel = 1e3 * layout.length(1)
    top = 1e3 * layout.top + 66 * pixel
    bottom = -top if layout.both else -44 * pixel
    longest = 0.16 * (high - low)  # the bar is the next smaller 1, 2 or 5 times a power of ten
    power = 10.0 ** math.floor(math.log10(longest))
    bar = next(step * power for step in (5.0, 2.0, 1.0) if step * power <= longest * (1 + 1e-9))
    start = complex(low, bottom + 14 * pixel)
    ends = (4j * pixel, 0, bar, bar + 4j * pixel)
    paint(
        drawn,
        [
            Stroke(role="axis", contours=(polygon(low, high),)),
            Stroke(role="scale bar", at=start, contours=(polygon(*ends),)),
            Text(role="name", text=f"{engineering(bar)} mm", at=start + bar, anchor=("left", "middle"), shift=(6, 0)),
        ],
    )
    quiet = {"showgrid": False, "showticklabels": False, "ticks": "", "showline": False, "constrain": "domain"}
    drawn.update_xaxes(range=[low, high], **quiet)
    drawn.update_yaxes(range=[bottom, top], scaleanchor="x", constrain="domain", showgrid=False)
    shrunk = min(1.0, 1e3 * WIDE / ((high - low) * layout.scale))  # a crowded series does not fit as it was laid out
    drawn.update_layout(height=round((top - bottom) / pixel * shrunk + 130))
    drawn.update_layout(legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.03, "yanchor": "top"})
