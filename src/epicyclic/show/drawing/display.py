"""The display list of a train: plain shapes in [mm] that the report and the page paint alike.  No plotly.

A shape has a role, by which a painter chooses its look, and points x + iy about a place of its own, turned about it: a
painter that moves a body moves and turns the shapes that name it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """A line through points (k,) [mm], drawn so many times around its origin; without points a circle of a radius."""

    points: Points
    times: int = 1
    radius: float = 0.0


def polygon(*points: complex, times: int = 1) -> Contour:
    """A contour through points [mm], so many times around its origin."""
    return Contour(np.array(points, dtype=np.complex128), times=times)


def circle(radius: float) -> Contour:
    """A circle about the origin; radius [mm]."""
    return Contour(np.zeros(0, dtype=np.complex128), radius=radius)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrawnShape:
    """What all shapes have: what it is, and where [mm, rad].

    kind : of its body, for its colour.  body : with which it moves.  meshes : by name, whose force colours it.
    hover : what is said under a pointer.  room : radius in which a symbol or text has to fit [mm].
    """

    role: str
    kind: str = ""
    body: str = ""
    meshes: tuple[str, ...] = ()
    at: complex = 0j
    turn: float = 0.0
    hover: str = ""
    room: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Area(DrawnShape):
    """Filled between its contours, even and odd, each of which is one closed line."""

    contours: tuple[Contour, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stroke(DrawnShape):
    """Lines, one for each time of each contour."""

    contours: tuple[Contour, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Symbol(DrawnShape):
    """A symbol of a size on the screen, as its role has it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Text(DrawnShape):
    """A text of so many pixels, at its place by `anchor` (across, up), moved by `shift` [px].

    upright : written upwards.  backing : ``white``, or the kind of body in whose tint it stands.
    """

    text: str
    size: float = 12
    anchor: tuple[str, str] = ("center", "middle")
    shift: tuple[float, float] = (0.0, 0.0)
    upright: bool = False
    backing: str = ""


def lines_of(shape: Area | Stroke) -> list[Points]:
    """Lines of a shape where it stands, each (k,) [mm]; of an area one closed line for each contour."""
    found: list[Points] = []
    for one in shape.contours:
        points = one.points if one.points.size else one.radius * np.exp(1j * np.linspace(0, 2 * math.pi, 121))
        turns = np.exp(1j * (shape.turn + 2 * math.pi * np.arange(one.times) / one.times))
        lines = shape.at + turns[:, None] * points
        found += [np.append(lines, lines[0, 0])] if isinstance(shape, Area) else list(lines)
    return found


def bounds(shapes: Sequence[DrawnShape]) -> list[float]:
    """Ends of a display list without its texts [mm]: x0, x1, y0, y1."""
    symbols = np.array([shape.at for shape in shapes if isinstance(shape, Symbol)], dtype=np.complex128)
    lines = (line for shape in shapes if isinstance(shape, Area | Stroke) for line in lines_of(shape))
    points = np.concatenate([symbols, *lines])
    if not points.size:
        return [-1.0, 1.0, -1.0, 1.0]
    ends = (points.real.min(), points.real.max(), points.imag.min(), points.imag.max())
    return [round(float(end), 3) for end in ends]


def plain(shapes: Iterable[DrawnShape], bodies: Mapping[str, int], meshes: Mapping[str, int]) -> dict[str, Any]:
    """A display list as JSON: ``contours``, each once, and ``shapes``, which name those they are made of by number.

    A contour is ``[times, radius, x, y, x, y, ...]``.

    Parameters
    ----------
    bodies, meshes : number of each by name.
    """
    known: dict[tuple[float, ...], int] = {}
    rows = []
    for shape in shapes:
        row: dict[str, Any] = {"type": type(shape).__name__.lower(), "role": shape.role, "kind": shape.kind}
        row["at"] = [round(shape.at.real, 3), round(shape.at.imag, 3), round(shape.turn, 6)]
        row |= {"body": bodies[shape.body]} if shape.body else {}
        row |= {"meshes": [meshes[name] for name in shape.meshes]} if shape.meshes else {}
        row |= {"room": round(shape.room, 3)} if shape.room else {}
        row |= {"text": shape.text} if isinstance(shape, Text) else {}
        if isinstance(shape, Area | Stroke):
            row["contours"] = [known.setdefault(_numbers(one), len(known)) for one in shape.contours]
        rows.append(row)
    return {"contours": [list(one) for one in known], "shapes": rows}


def _numbers(contour: Contour) -> tuple[float, ...]:
    """A contour as numbers, lengths to a micrometre."""
    ends = [end for point in contour.points.tolist() for end in (point.real, point.imag)]
    return (contour.times, round(contour.radius, 3), *(round(end, 3) + 0.0 for end in ends))  # without -0.0
