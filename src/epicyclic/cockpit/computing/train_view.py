"""The train as the page draws it from the front and in axial section, turning; its operation in numbers."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any, NamedTuple

from ...questions.check.check import drawing
from ...show.drawing.bodies import Part, faces, parts, turns
from ...show.drawing.section_layout import BODY, PLATE, SectionLayout, layout_of
from ...train.train import Body, Mesh, Train

# Torques below this part of the largest are rounding of a member that carries none.
_NONE = 1e-9


def operation_head(train: Train, *, relative_speed: float = 1.0) -> dict[str, Any]:
    """``head["state"]`` without its time: ratio of the fastest to the slowest port, speeds [rpm] and torques [kN m].

    Parameters
    ----------
    relative_speed : speed per operating speed [1], which the speeds follow.
    """
    speed, torque = train.kinematics.speed or {}, train.kinematics.torque or {}
    several = len(train.planets) > 1
    carried = {body.member for body in train.bodies if body.branch is not None}

    def name(member: str) -> str:
        stage, _, word = member.rpartition(".")
        return f"{stage} {word}" if several and stage else word

    largest = max((abs(value) for value in torque.values()), default=0.0)
    loaded = {member: value for member, value in torque.items() if abs(value) > _NONE * largest}
    unit, scale = ("kN m", 1e-3) if largest >= 1e3 else ("N m", 1.0)
    ports = [abs(float(speed[member])) for member in loaded if speed.get(member)]
    return {
        "ratio": max(ports) / min(ports) if len(ports) > 1 and math.isfinite(max(ports)) else None,
        "speeds": [
            [name(member), relative_speed * float(value), "rpm"]
            for member, value in speed.items()
            if member not in carried and member in {body.member for body in train.bodies if body.kind != "body"}
        ],
        "torques": [[name(member), scale * value, unit] for member, value in loaded.items()],
        "relative_speed": relative_speed,
    }


# Drawings of the last trains that were asked for: the geometry stays while most levers move, and takes some 10 ms.
_KEPT = 8
# A radial support below this is none [N/m]; the softest gear coupling is a hundred thousand times stiffer.
_FLOATS = 1.0


class _Drawing(NamedTuple):
    """Places of the bodies of a train, of the figures of the report."""

    part: Mapping[str, Part]
    turn: Mapping[str, float]
    layout: SectionLayout
    shift: Mapping[str, float]


_drawings: OrderedDict[str, _Drawing] = OrderedDict()


def train_head(
    train: Train, labels: Mapping[str, str], mesh_labels: Mapping[str, str], *, relative_speed: float = 1.0
) -> dict[str, Any]:
    """``head["train"]``: every body, mesh and link with its place [mm] and speed [rad/s].

    Parameters
    ----------
    labels : of the bodies.  mesh_labels : of the meshes.  relative_speed : speed per operating speed [1].
    """
    drawn = _drawing(train)
    rate = train.kinematics.mesh_frequency or {}
    stages = []
    for stage in train.planets:
        x = next((_mm(part.offset) for part in drawn.part.values() if part.stage == stage), 0.0)
        frequency = None if rate.get(stage) is None else relative_speed * float(rate[stage])
        stages.append({"name": stage, "x": x, "mesh_frequency": frequency})
    number = {body.name: i for i, body in enumerate(train.bodies)}
    return {
        "title": train.title,
        "stages": stages,
        "bodies": [_body(train, body, drawn, labels[body.name], relative_speed) for body in train.bodies],
        "meshes": [
            {
                "name": mesh.name,
                "label": mesh_labels[mesh.name],
                "bodies": [number[mesh.a], number[mesh.b]],
                **_contact(drawn, mesh),
                "pair": mesh.pair.rpartition(".")[2],
                "branch": (mesh.branch or 1) - 1,
                "side": mesh.side or "",
            }
            for mesh in train.meshes
        ],
        "links": [
            {
                "body": link.first,
                "to": link.second,
                "z": _mm(link.station + drawn.shift[link.first]),
                "kind": link.kind,
                "label": link.name,
            }
            for link in train.links
        ],
    }


def _drawing(train: Train) -> _Drawing:
    """The drawing of a train, kept while its geometry stays."""
    key = _geometry(train)
    if key in _drawings:
        _drawings.move_to_end(key)
        return _drawings[key]
    table = drawing(train)
    shapes, layout = parts(table), layout_of(table)
    column = {column.place: column.shift for column in layout.columns}
    _drawings[key] = _Drawing(
        part={part.name: part for part in shapes},
        turn=turns(table, shapes),
        layout=layout,
        shift={part.name: column[part.place] for part in shapes},
    )
    while len(_drawings) > _KEPT:
        _drawings.popitem(last=False)
    return _drawings[key]


def _geometry(train: Train) -> str:
    """What the drawing of a train depends on, as a text: numbers that are not given are equal to each other there."""
    speed, torque = train.kinematics.speed or {}, train.kinematics.torque or {}
    bodies = [
        (
            *(body.name, body.member, body.kind, body.frame, body.carried_by, body.branch, body.side, body.centre),
            *(body.station, body.angle, body.outer_radius, body.gear),
            *(_sign(float(speed.get(body.member, math.nan))), _sign(torque.get(body.member, 0.0))),
            # the size of a plain body is that of an equal disc
            body.inertia / body.mass if body.gear is None and body.mass else 0.0,
        )
        for body in train.bodies
    ]
    meshes = [
        (mesh.name, mesh.a, mesh.b, mesh.direction, mesh.pressure_angle, mesh.flank, mesh.lead) for mesh in train.meshes
    ]
    links = [
        (
            *(link.name, link.kind, link.first, link.second, link.station),
            *(_sign(k) + math.isinf(k) for k in link.stiffness),
        )
        for link in train.links
    ]
    return repr((bodies, meshes, links))


def _sign(value: float) -> int:
    """-1, 0 or 1; 0 of what is not a number."""
    return (value > 0) - (value < 0)


def _mm(value: float) -> float:
    """A length in [mm], rounded to what a screen shows."""
    return round(1e3 * value, 4)


def _body(train: Train, body: Body, drawn: _Drawing, label: str, relative_speed: float) -> dict[str, Any]:
    """One body of the drawing."""
    part, kinematics = drawn.part[body.name], train.kinematics
    form = part.form
    shown = _faces(drawn, part)
    rpm = (kinematics.speed or {}).get(body.member)
    carrier_rpm = (kinematics.frame_speed or {}).get(body.frame) if body.carried_by else None
    supports = [link for link in train.links if link.kind == "support" and link.first == body.name]
    central = body.gear is not None and body.branch is None
    return {
        "name": body.name,
        "label": label,
        "kind": _kind(body),
        "stage": part.place if part.kind == "body" else part.stage,
        "number": body.branch,
        "side": body.side or "",
        "teeth": form.teeth if form else None,
        "x": _mm(part.x + part.offset),
        "y": _mm(part.y),
        "z": [min(low for low, _, _ in shown), max(high for _, high, _ in shown)],
        "faces": shown,
        "pitch": None if form is None else _mm(_pitch(train, body.name, form.reference_radius)),
        "tip": None if form is None else _mm(form.tip_radius),
        "root": None if form is None else _mm(form.root_radius),
        "outer": _mm(part.outer),
        "internal": bool(form and form.internal),
        "hand": {1: "right", -1: "left"}.get(part.hand, "") if form else "",
        "turn": round(drawn.turn.get(body.name, 0.0), 6),
        "speed": 0.0 if rpm is None else relative_speed * float(rpm) * math.pi / 30,
        # of the centre of a carried body about the axis of its stage
        "orbit": 0.0 if carrier_rpm is None else relative_speed * (float(carrier_rpm) * math.pi / 30),
        # nothing but meshes holds it radially
        "floating": central and bool(supports) and all(max(link.stiffness[:2]) <= _FLOATS for link in supports),
        "held": body.member in kinematics.held,
        "pins": [other.name for other in train.bodies if other.carried_by == body.name],
    }


def _kind(body: Body) -> str:
    """Kind of a body among those that are drawn: a gear of no member of a stage is a sun or ring by its teeth."""
    if body.kind in ("sun", "planet", "ring", "carrier"):
        return body.kind
    if body.gear is None:
        return "shaft"
    if body.branch is not None:
        return "planet"
    return "ring" if body.gear.internal else "sun"


def _pitch(train: Train, name: str, otherwise: float) -> float:
    """Working pitch radius of a gear in its first mesh [m]."""
    for mesh in train.meshes:
        if name in (mesh.a, mesh.b):
            radius = mesh.radius_a if name == mesh.a else mesh.radius_b
            return radius if math.isfinite(radius) else otherwise
    return otherwise


def _faces(drawn: _Drawing, part: Part) -> list[list[Any]]:
    """Axial extent of each helix and its hand; of a carrier from cheek to cheek, of a plain body its disc [mm]."""
    shift = drawn.shift[part.name]
    if part.form is not None:
        return [
            [_mm(low + shift), _mm(high + shift), {1: "right", -1: "left"}.get(hand, "")]
            for low, high, hand in faces(part)
        ]
    pins = [other for other in drawn.part.values() if other.carried_by == part.name]
    ends = [end for pin in pins for low, high, _ in faces(pin) for end in (low, high)]
    beside = drawn.layout.length(2 * PLATE if ends else BODY / 2)
    low, high = (min(ends), max(ends)) if ends else (part.station, part.station)
    # halves of a split carrier end at the middle, where they meet
    left = low if ends and part.side == "right" else low - beside
    right = high if ends and part.side == "left" else high + beside
    return [[_mm(left + shift), _mm(right + shift), ""]]


def _contact(drawn: _Drawing, mesh: Mesh) -> dict[str, Any]:
    """Pitch point of a mesh and its axial extent [mm]: the common face, where none is known the narrower one drawn."""
    part = drawn.part[mesh.a]
    radius = mesh.radius_a if math.isfinite(mesh.radius_a) else part.form.reference_radius if part.form else 0.0
    drawn_width = min(part.width, drawn.part[mesh.b].width)
    half, shift = (mesh.width if math.isfinite(mesh.width) else drawn_width) / 2, drawn.shift[mesh.a]
    return {
        "x": _mm(part.x + part.offset + radius * math.cos(mesh.direction)),
        "y": _mm(part.y + radius * math.sin(mesh.direction)),
        "z": [_mm(mesh.station - half + shift), _mm(mesh.station + half + shift)],
    }
