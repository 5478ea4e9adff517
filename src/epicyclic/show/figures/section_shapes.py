"""Boxes of an axial section, and the places about a column that they share: lanes of shafts, cheeks, discs, ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from .section_layout import BODY, LANE, PLATE, SEGMENT, Column, Group, SectionLayout
from .series import Array, compact, engineering
from .style import kind_colour, tint

__all__ = [
    "appearance",
    "base_of",
    "beyond",
    "box",
    "boxes",
    "cheek",
    "disc",
    "edge_of",
    "end_of",
    "lane_of",
    "lane_radii",
    "signs",
    "trace",
    "where_of",
]


def where_of(layout: SectionLayout) -> dict[str, tuple[Group, Column]]:
    """Body -> its group and column."""
    return {part.name: (group, column) for column in layout.columns for group in column.groups for part in group.bodies}


def trace(z: Sequence[float] | Array, r: Sequence[float] | Array, options: Mapping[str, Any]) -> go.Scatter:
    """A line through z, r (k,) [m], drawn in [mm]."""
    plain = {"mode": "lines", "hoverinfo": "skip", "showlegend": False}
    return go.Scatter(x=compact(1e3 * np.asarray(z)), y=compact(1e3 * np.asarray(r)), **{**plain, **options})


def box(along: tuple[float, float], radii: tuple[float, float], look: Mapping[str, Any]) -> go.Scatter:
    (left, right), (low, high) = along, radii
    return trace([left, right, right, left, left], [low, low, high, high, low], look)


def boxes(
    along: tuple[float, float], radii: tuple[float, float], group: Group, layout: SectionLayout, look: Mapping[str, Any]
) -> list[go.Scatter]:
    """A box above the axis, below it, or both where the group turns about the axis."""
    return [box(along, (sign * radii[0], sign * radii[1]), look) for sign in signs(group, layout)]


def signs(group: Group, layout: SectionLayout) -> tuple[int, ...]:
    if group.first.branch:
        return (group.half,)
    return (1, -1) if layout.both and group.first.radius < 1e-9 else (1,)


def appearance(group: Group, white: float = 0.62) -> dict[str, Any]:
    """Opaque in a tint of its colour, and what a pointer over it says."""
    colour, first = kind_colour(group.kind), group.first
    teeth = f"<br>{first.form.teeth} teeth" if first.form else ""
    wide = f"<br>face width {engineering(1e3 * first.width)} mm" if first.form else ""
    mass = f"<br>{engineering(first.mass)} kg" if np.isfinite(first.mass) and first.mass > 0 else ""
    held = "<br>held" if group.held else ""
    return {
        "line": {"color": colour, "width": 1.3},
        "fill": "toself",
        "fillcolor": tint(colour, white),
        "hoverinfo": "text",
        "hoveron": "fills",
        "text": f"<b>{first.short}</b>{teeth}{wide}{mass}{held}",
    }


def lane_radii(number: int, layout: SectionLayout) -> tuple[float, float]:
    """Radii of a shaft [m]; that in lane 0 is solid."""
    return layout.length(LANE * number + 1.0) if number else 0.0, layout.length(LANE * (number + 1) - 1.0)


def lane_of(group: Group, column: Column, side: str) -> int:
    """Lane of its shaft on a side; a lone body stands on the shafts that pass under it."""
    stack = column.left if side == "left" else column.right
    return column.passing + (stack.index(group.key) if group.key in stack and not column.lone else 0)


def base_of(group: Group, column: Column, layout: SectionLayout) -> float:
    """Inner radius of a member about the axis [m]."""
    sides = [side for side, stack in (("left", column.left), ("right", column.right)) if group.key in stack]
    number = min((lane_of(group, column, side) for side in sides), default=column.passing)
    return lane_radii(number, layout)[0]


def edge_of(column: Column, side: str) -> float:
    return (column.low if side == "left" else column.high) + column.shift


def beyond(column: Column, side: str, pixels: float, layout: SectionLayout) -> float:
    """Place so many pixels beyond the gears [m]."""
    return edge_of(column, side) + (-1 if side == "left" else 1) * layout.length(pixels)


def end_of(group: Group, column: Column, side: str, layout: SectionLayout) -> float:
    """End of its shaft: the nearer the axis, the further out [m]."""
    if column.lone:
        return beyond(column, side, BODY / 2, layout)
    stack = column.left if side == "left" else column.right
    return beyond(column, side, 4 * PLATE + SEGMENT * (len(stack) - stack.index(group.key)), layout)


def cheek(column: Column, side: str, layout: SectionLayout) -> tuple[float, float]:
    """Axial ends of a carrier's cheek [m]."""
    return beyond(column, side, 0.4 * PLATE, layout), beyond(column, side, 1.4 * PLATE, layout)


def disc(column: Column, side: str, layout: SectionLayout) -> tuple[float, float]:
    """Axial ends of the disc that carries a turning ring [m]."""
    return beyond(column, side, 2.2 * PLATE, layout), beyond(column, side, 3.2 * PLATE, layout)
