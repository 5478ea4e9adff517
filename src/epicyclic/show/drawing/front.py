"""The train from the front, to scale: every gear with its true teeth in mesh, circles, names, senses of rotation."""

from __future__ import annotations

import cmath
import math
from collections.abc import Collection, Iterable, Sequence
from typing import TypedDict

import numpy as np

from ..series import engineering
from .bodies import (
    Area,
    Contour,
    DrawnShape,
    DrawnTrain,
    Mating,
    Part,
    Stroke,
    Symbol,
    Text,
    circle,
    one_per_place,
    pitch_radius,
    polygon,
    rotations,
    stages,
    tooth_path,
)

_ORDER = {"carrier": 0, "ring": 1, "body": 2, "gear": 3, "planet": 4, "sun": 5}


def front_parts(train: DrawnTrain, *, behind: bool = False) -> list[Part]:
    """Bodies of the front view.

    Parameters
    ----------
    behind : also those behind an equal one, which a mode shape moves out from there.
    """
    with_gears = stages(train.parts)
    return [part for part in (train.parts if behind else one_per_place(train.parts)) if part.stage in with_gears]


def _back_to_front(found: Iterable[Part]) -> list[Part]:
    return sorted(found, key=lambda one: (_ORDER.get(one.kind, 2), -one.outer))


def front_shapes(train: DrawnTrain, found: Sequence[Part]) -> list[DrawnShape]:
    """Bodies with their teeth in mesh, their circles, the pitch points, and the housing of what is held.

    Parameters
    ----------
    found : bodies that are drawn, as `front_parts` gives them.
    """
    turned = rotations({part.name: part.form for part in found if part.form is not None}, train.meshes)
    shapes = [shape for part in _back_to_front(found) for shape in _body(part, turned.get(part.name, 0.0), found)]
    carriers = [(part, pins) for part in found if (pins := _pins(part, found))]
    hidden = [Stroke(**_of(part, "hidden edge"), contours=(_arms(part, pins),)) for part, pins in carriers]
    return [*shapes, *hidden, *_circles(train, found), *_pitch_points(train, found), *_held(train, found)]


def front_notes(train: DrawnTrain, found: Sequence[Part]) -> list[DrawnShape]:
    """What a picture that stands still says besides: lines of action, senses of rotation, names."""
    return [*_actions(train, found), *_senses(found), *_names(train, found)]


def front_centres(found: Sequence[Part], floating: Collection[str]) -> list[DrawnShape]:
    """What a picture that turns says in the gears: numbers of planets, names of other gears, and which of them float.

    Of several on one axis the front one; a ring that floats has its marks on its rim, where they hide no teeth.
    """
    shapes: list[DrawnShape] = []
    for part in found:
        if part.form and part.form.internal and part.name in floating:
            rim = 1e3 * (part.outer - part.form.root_radius)
            places = (cmath.rect(1e3 * part.outer - rim / 2, angle) for angle in (-0.25 * math.pi, 0.75 * math.pi))
            shapes += [Symbol(**_of(part, "floats on the rim", at=part.centre + place), room=rim) for place in places]
    within = {part.centre: part for part in _back_to_front(found) if part.form and not part.form.internal}
    for part in within.values():
        assert part.form is not None
        room = 1e3 * part.form.root_radius
        if part.branch:
            shapes.append(Text(**_of(part, "number"), text=str(part.branch), room=room))
        else:
            shapes.append(Symbol(**_of(part, "floats" if part.name in floating else "centre"), room=room))
            shapes.append(Text(**_of(part, "name"), text=part.short, room=room))
    several = stages(found) if len(stages(found)) > 1 else []
    for stage in several:
        own = [part for part in found if part.stage == stage]
        top = own[0].offset + 1j * max(part.y + part.outer for part in own)
        shapes.append(Text(role="stage", text=stage, at=1e3 * top))
    return shapes


class _Placed(TypedDict):
    """What a shape of a body says of it."""

    role: str
    kind: str
    body: str
    at: complex


def _of(part: Part, role: str, *, at: complex | None = None) -> _Placed:
    """A role of a body, at its centre where not said otherwise."""
    return {"role": role, "kind": part.kind, "body": part.name, "at": part.centre if at is None else at}


def _pins(part: Part, found: Iterable[Part]) -> list[Part]:
    return [other for other in found if other.carried_by == part.name]


def _body(part: Part, turn: float, found: Sequence[Part]) -> list[DrawnShape]:
    """A body, and the stroke on one of its teeth by which its turning is seen; a ring lies between rim and teeth."""
    teeth = f"{part.form.teeth} teeth" if part.form else ""
    speed = f"{engineering(part.speed)} rpm" if np.isfinite(part.speed) else ""
    mass = f"{engineering(part.mass)} kg" if np.isfinite(part.mass) and part.mass > 0 else ""
    hover = "<br>".join(text for text in (f"<b>{part.short}</b>", teeth, speed, mass) if text)
    rim = circle(1e3 * part.outer)
    if part.form is None:
        pins = _pins(part, found)
        return [Area(**_of(part, "body"), contours=(_arms(part, pins) if pins else rim,), hover=hover)]
    internal, root = part.form.internal, 1e3 * part.form.root_radius
    contours = (rim, tooth_path(part.form)) if internal else (tooth_path(part.form),)
    stroke = polygon(root, 1e3 * part.outer) if internal else polygon(0.74 * root, 0.93 * root)
    area = Area(**_of(part, "body"), contours=contours, turn=turn, hover=hover)
    return [area, Stroke(**_of(part, "turning"), contours=(stroke,), turn=turn)]


def _arms(part: Part, pins: Sequence[Part]) -> Contour:
    """Outline of a carrier: a plate whose lobes hold the pins."""
    angle = np.linspace(0, 2 * math.pi, 121)
    reach = np.full(angle.shape, 0.62 * part.outer)
    for pin in pins:
        away = np.angle(np.exp(1j * (angle - math.atan2(pin.y, pin.x))))
        reach = np.maximum(reach, part.outer * (0.62 + 0.38 * np.exp(-((away / 0.42) ** 4))))
    return polygon(*(1e3 * reach * np.exp(1j * angle)))


def _circles(train: DrawnTrain, found: Sequence[Part]) -> list[Stroke]:
    """Pitch circles of every gear, one for each mesh that works at another angle; else its reference circle."""
    radii: dict[str, set[float]] = {}
    gears = {part.name: part for part in found if part.form is not None}
    for one in train.meshes:
        for name in {one.a, one.b} & gears.keys():
            radii.setdefault(name, set()).add(round(1e3 * pitch_radius(gears[name], one), 6))
    own = {name: sorted(radii.get(name, ())) or [1e3 * pitch_radius(part)] for name, part in gears.items()}
    return [Stroke(**_of(gears[name], "pitch circle"), contours=tuple(map(circle, each))) for name, each in own.items()]


def _pitch_points(train: DrawnTrain, found: Sequence[Part]) -> list[Symbol]:
    """Where teeth meet, meshes at one place together; it goes around with the planet that stands in it."""
    place = {part.name: part for part in found}
    meshes: dict[tuple[str, complex], list[Mating]] = {}
    for one in train.meshes:
        if one.a in place and one.b in place:
            at = _pitch_point(one, place[one.a])
            meshes.setdefault((place[one.a].stage, complex(round(at.real, 3), round(at.imag, 3))), []).append(one)
    marks = []
    for (_, at), own in meshes.items():
        pair = [place[own[0].b], place[own[0].a]]
        carried = next((part for part in pair if part.branch), pair[1])
        room = 5 * min(2e3 * pitch_radius(part) / part.form.teeth for part in pair if part.form)
        names = tuple(one.name for one in own)
        marks.append(Symbol(role="mesh", body=carried.name, meshes=names, at=at, room=room))
    return marks


def _pitch_point(mating: Mating, a: Part) -> complex:
    """Where the pitch circles of a mesh touch [mm]."""
    return a.centre + cmath.rect(1e3 * pitch_radius(a, mating), mating.direction)


def _held(train: DrawnTrain, found: Sequence[Part]) -> list[Stroke]:
    """Strokes of the housing around a held ring, within another held gear, at the hub of a held carrier."""
    shapes: list[Stroke] = []
    for part in found:
        if part.name not in train.still or part.branch or not (part.form or _pins(part, found)):
            continue
        ring = part.form is not None and part.form.internal
        radius = part.outer if ring else 0.88 * part.form.root_radius if part.form else 0.16 * part.outer
        deep = 0.03 * part.outer * (1 if ring else -1)
        end = cmath.rect(radius + deep, 1.6 * deep / radius)
        stroke = polygon(1e3 * radius, 1e3 * end, times=72 if ring else 16)
        role = "held" if part.form else "held hub"
        shapes.append(Stroke(**_of(part, role), contours=(stroke, circle(1e3 * radius))))
    return shapes


def _actions(train: DrawnTrain, found: Sequence[Part]) -> list[Stroke]:
    """Stroke of action of every mesh through its pitch point, where the working angle is known."""
    place, shapes = {part.name: part for part in found}, []
    for one in train.meshes:
        a, b = place.get(one.a), place.get(one.b)
        if a and b and a.form and b.form and np.isfinite(one.pressure_angle):
            normal = cmath.rect(1.0, one.direction + one.flank * (math.pi / 2 - one.pressure_angle))
            reach = 420 * min(a.form.reference_radius, b.form.reference_radius) * normal
            shapes.append(Stroke(role="line of action", at=_pitch_point(one, a), contours=(polygon(-reach, reach),)))
    return shapes


def _senses(found: Sequence[Part]) -> list[DrawnShape]:
    """Arc arrows of the absolute speeds, one for all gears that turn alike on one axis."""
    arcs: list[DrawnShape] = []
    heads: list[DrawnShape] = []
    for part in {(one.centre, one.speed, one.form is not None and one.form.internal): one for one in found}.values():
        if part.form is None or not np.isfinite(part.speed) or part.speed == 0:
            continue
        rim, half = (part.form.root_radius + part.outer) / 2, 16 if part.form.internal else 38
        radius = 1e3 * (rim if part.form.internal else 0.72 * part.form.root_radius)
        sense = 1 if part.speed > 0 else -1
        angles = np.radians(90 + sense * np.linspace(-half, half, 20))
        arc = polygon(*(radius * np.exp(1j * angles)))
        arcs.append(Stroke(role="sense of rotation", at=part.centre, contours=(arc,)))
        heads.append(Symbol(role="arrow head", at=part.centre + arc.points[-1], turn=angles[-1] + sense * math.pi / 2))
    return [*arcs, *heads]


def _names(train: DrawnTrain, found: Sequence[Part]) -> list[Text]:
    """Names in the gears, one for all on one axis; that of a ring above and that of a carrier below the stage.

    Where there are several stages each has its own name on top.
    """
    several, still = len(stages(found)) > 1, train.still
    low, high = front_ends(found)
    shown = 780.0 / (1e-9 + 1.08 * (high - low))  # [px/m] of a figure of 900 px that its width limits
    shown = min(shown, 440.0 / (2.36 * max((part.radius + part.outer for part in found), default=1.0)))
    shapes: list[Text] = []
    outside: dict[tuple[str, str], list[Part]] = {(stage, "bottom"): [] for stage in stages(found)} if several else {}
    axes: dict[complex, list[Part]] = {}
    for part in found:
        if part.form is None or part.form.internal:
            outside.setdefault((part.stage, "bottom" if part.form else "top"), []).append(part)
        else:
            axes.setdefault(complex(round(part.centre.real, 6), round(part.centre.imag, 6)), []).append(part)
    for centre, own in axes.items():
        room = 1.7 * max(part.form.root_radius for part in own if part.form) * shown
        text, size = _fitting(own, still, room)
        shapes.append(Text(role="name", text=text, size=size, at=centre))
    for (stage, anchor), own in outside.items():
        reach = max(other.radius + other.outer for other in found if other.stage == stage)
        height = (1 if anchor == "bottom" else -1) * 1.05 * reach
        head = [f"<b>{stage}</b>"] if several and anchor == "bottom" else []
        text = "<br>".join([*head, *(_name(part, still) for part in own)])
        middle = next(part.offset for part in found if part.stage == stage) + (own[0].x if own else 0.0)
        shapes.append(Text(role="name", text=text, at=1e3 * complex(middle, height), anchor=("center", anchor)))
    return shapes


def _fitting(own: Sequence[Part], still: Collection[str], room: float) -> tuple[str, int]:
    """Name and teeth of the gears on one axis in the largest type that so many pixels hold, else the branch alone."""
    names = [_name(part, still) for part in own]
    whole = names[0] if len(own) == 1 else "<br>".join(name.replace("<br>", ", ") for name in names)
    tried = [whole, "<br>".join(part.short for part in own), str(own[0].branch or own[0].short)]
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


def front_ends(found: Sequence[Part]) -> tuple[float, float]:
    """Of the front view along x [m]."""
    low = min((part.offset - part.radius - part.outer for part in found), default=-1.0)
    return low, max((part.offset + part.radius + part.outer for part in found), default=1.0)
