"""A Train as a notebook shows it: the front view of every stage by pitch circles, to scale, and its key numbers."""

from __future__ import annotations

import math
from fractions import Fraction
from html import escape
from typing import TYPE_CHECKING

from .bodies import Body

if TYPE_CHECKING:
    from .train import Train

__all__ = ["driving_member", "train_html"]

_WIDTH, _HEIGHT, _LABEL = 680.0, 300.0, 11  # of the drawing and of its letters [px]
_FILL = {"sun": "#f2b134", "planet": "#6ea8d8", "ring": "none"}


def driving_member(train: Train) -> str | None:
    """Member that the most power enters by; without power the first freedom, None where nothing can turn."""
    kinematics = train.kinematics
    power = {name: value for name, value in (kinematics.power or {}).items() if value > 0}
    if power:
        return max(power, key=lambda name: power[name])
    return next(iter(kinematics.freedoms), None)


def train_html(train: Train) -> str:
    """Front views and tables of a train as one well-formed HTML element, without scripts and outside references."""
    return (
        f"<div><p><b>{escape(train.title)}</b></p>{_front_views(train)}"
        f"{_table(['member', 'teeth', 'speed [rpm]', 'torque [N m]', 'power [kW]'], _members(train))}"
        f"{_table(['mesh frequency', '[Hz]', 'per turn of ' + _first(train)], _frequencies(train))}"
        f"<p>{escape(_counts(train))}</p></div>"
    )


def _counts(train: Train) -> str:
    slices = sum(len(mesh.slices) for mesh in train.meshes)
    cut = f" ({slices} slices)" if slices else ""
    return f"{len(train.bodies)} bodies, {len(train.meshes)} meshes{cut}, {len(train.links)} links"


def _members(train: Train) -> list[list[str]]:
    """One row a member: teeth, speed [rpm], external torque [N m] and power [kW], empty where not known."""
    kinematics, teeth = train.kinematics, {b.member: b.gear.teeth for b in train.bodies if b.gear is not None}
    speed, torque, power = kinematics.speed or {}, kinematics.torque or {}, kinematics.power or {}
    return [
        [
            member + (" (held)" if member in kinematics.held else ""),
            str(teeth.get(member, "")),
            _number(speed.get(member)),
            _number(torque.get(member) or None),
            _number(1e-3 * power[member] if power.get(member) else None),
        ]
        for member in dict.fromkeys(body.member for body in train.bodies)
    ]


def _frequencies(train: Train) -> list[list[str]]:
    rate, order = train.kinematics.mesh_frequency or {}, train.kinematics.mesh_order
    return [[tone, _number(rate.get(tone)), _number(order.get(tone))] for tone in dict.fromkeys([*rate, *order])]


def _first(train: Train) -> str:
    return next(iter(train.kinematics.freedoms), "")


def _number(value: float | Fraction | None) -> str:
    """Four digits; empty for what is not known or not finite."""
    return f"{float(f'{float(value):.5g}'):.10g}" if value is not None and math.isfinite(value) else ""


def _table(head: list[str], rows: list[list[str]]) -> str:
    if not rows:
        return ""
    cells = [f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows]
    return f"<table><tr>{''.join(f'<th>{escape(cell)}</th>' for cell in head)}</tr>{''.join(cells)}</table>"


# front views ---------------------------------------------------------------------------------------------------------


def _front_views(train: Train) -> str:
    """One SVG with a view of every stage from the right end, side by side, all to one scale."""
    radius = _pitch_radii(train)
    stages = {stage: [b for b in train.bodies if b.frame == stage and b.name in radius] for stage in train.planets}
    reach = {
        stage: max(math.hypot(*b.centre) + radius[b.name] for b in gears) for stage, gears in stages.items() if gears
    }
    if not reach:
        return ""
    scale = min(_WIDTH / (2.1 * sum(reach.values())), _HEIGHT / (2 * max(reach.values())))
    height = 2 * scale * max(reach.values()) + 5 * _LABEL
    drawn, left = [], 4.0
    for stage, size in reach.items():
        middle = left + scale * size, 0.5 * height - _LABEL
        drawn.append(_stage(train, stage, stages[stage], radius, middle, scale))
        left += 2.1 * scale * size
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + 4:.0f}" height="{height:.0f}" '
        f'font-family="sans-serif" font-size="{_LABEL}" text-anchor="middle" stroke="currentColor" '
        f'fill="none">{"".join(drawn)}</svg>'
    )


def _pitch_radii(train: Train) -> dict[str, float]:
    """Working pitch radius of every gear in its first mesh, else its reference radius [m]."""
    found: dict[str, float] = {}
    for mesh in train.meshes:
        found.setdefault(mesh.a, mesh.radius_a)
        found.setdefault(mesh.b, mesh.radius_b)
    for body in train.bodies:
        if body.gear is not None:
            found.setdefault(body.name, body.gear.reference_radius)
    return {name: radius for name, radius in found.items() if math.isfinite(radius)}


def _stage(
    train: Train, stage: str, gears: list[Body], radius: dict[str, float], middle: tuple[float, float], scale: float
) -> str:
    """Pitch circles of a stage about its axis at `middle` [px], largest first; scale [px/m]."""
    parts, texts, seen, labels = list[str](), list[str](), set[tuple[str, int | None]](), dict[tuple[int, int], int]()
    for body in sorted(gears, key=lambda one: -radius[one.name]):
        if (body.member, body.branch) in seen:  # the halves of a herringbone gear stand behind each other
            continue
        seen.add((body.member, body.branch))
        x, y, r = middle[0] + scale * body.centre[0], middle[1] - scale * body.centre[1], scale * radius[body.name]
        internal = body.gear is not None and body.gear.internal
        parts.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" fill="{_FILL.get(body.kind, "#9bc49b")}" '
            f'fill-opacity="0.35"><title>{escape(_tooltip(train, body, radius[body.name]))}</title></circle>'
        )
        below = labels.get((round(x), round(y)), 0) if not internal else 0
        if not internal:
            labels[round(x), round(y)] = below + 1
        texts.append(_text(_label(body, r), x, y - r - 3 if internal else y + 4 + below * (_LABEL + 1)))
    pins = {math.hypot(*body.centre) for body in gears if body.branch is not None}
    parts += [
        f'<circle cx="{middle[0]:.1f}" cy="{middle[1]:.1f}" r="{scale * pin:.1f}" stroke-dasharray="4 3" '
        f'stroke-opacity="0.5"><title>pin circle, radius {pin * 1e3:.5g} mm</title></circle>'
        for pin in sorted(pins)
        if pin > 0
    ]
    bottom = middle[1] + scale * max(math.hypot(*b.centre) + radius[b.name] for b in gears) + 1.5 * _LABEL
    return "".join([*parts, *texts, _text(stage, middle[0], bottom)])


def _label(body: Body, size: float) -> str:
    """Member and branch; of a small circle [px] the branch alone."""
    member = body.member.rpartition(".")[2]
    if body.branch is None:
        return member
    return f"{member} {body.branch}" if 2 * size > 0.6 * _LABEL * (len(member) + 2) else str(body.branch)


def _tooltip(train: Train, body: Body, radius: float) -> str:
    teeth = "" if body.gear is None else f", {body.gear.teeth} teeth"
    turns = _number((train.kinematics.speed or {}).get(body.member))
    return f"{body.name}{teeth}, pitch radius {radius * 1e3:.5g} mm{f', {turns} rpm' if turns else ''}"


def _text(text: str, x: float, y: float) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="currentColor" stroke="none">{escape(text)}</text>'
