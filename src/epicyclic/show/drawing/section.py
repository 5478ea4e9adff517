"""The train from the side: axial section, gears to scale, helices, shafts, couplings, supports, what is held."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise, product

import numpy as np

from ..series import engineering, grouped, split_name
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
    faces,
    pitch_radius,
    polygon,
)
from .section_layout import (
    AIR,
    BODY,
    LANE,
    PLATE,
    SEGMENT,
    SIDES,
    Column,
    Coupling,
    Ends,
    Group,
    Seat,
    SectionLayout,
    SectionLink,
    text_width,
)

_DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
_UNITS = ("N/m", "N/m", "N/m", "N m/rad", "N m/rad", "N m/rad")


def section_shapes(train: DrawnTrain, layout: SectionLayout) -> list[DrawnShape]:
    """Section through the axis and branch 1: bodies cut, shafts, couplings, meshes, bearings, supports, the housing.

    Parameters
    ----------
    layout : of this train.
    """
    shapes: list[DrawnShape] = [shape for seat in layout.seats for shape in _shafts(seat)]
    shapes += _couplings(layout)
    for column in layout.columns:
        shapes += [shape for seat in layout.seats if seat.column is column for shape in _body(seat)]
        shapes += _pins(column, layout)
    return [*shapes, *_meshes(train.meshes, layout), *_supports(layout)]


def _boxes(
    seat: Seat, along: Ends, radii: Ends, role: str, *, signs: Iterable[int] = (), body: Part | None = None
) -> list[Area]:
    """A box above the axis, below it, or both where the group turns about the axis.

    Parameters
    ----------
    along, radii : ends [m].  signs : 1 above, -1 below, else as the group stands.  body : of the group, which it is a
        part of; the first where not said.
    """
    part = body or seat.group.first
    pivot = _pivot(seat, part)
    kind, hover = seat.group.kind, _describe(seat.group)
    boxes = [_box(along, (sign * radii[0], sign * radii[1]), pivot) for sign in signs or seat.signs]
    return [Area(role=role, kind=kind, body=part.name, at=pivot, hover=hover, contours=(box,)) for box in boxes]


def _pivot(seat: Seat, part: Part) -> complex:
    """Centre of a body in the plane of the section [mm]."""
    return _mm(part.station + seat.column.shift, seat.group.half * part.radius)


def _at_end(group: Group, side: str) -> Part:
    """The body of a group that its shaft on a side belongs to."""
    return group.bodies[0 if side == "left" else -1]


def _mm(z: float, r: float) -> complex:
    """A place [m] in the plane of the section [mm]."""
    return 1e3 * complex(z, r)


def _box(along: Ends, radii: Ends, origin: complex = 0j) -> Contour:
    """A box between ends [m], about an origin [mm]."""
    (left, right), (low, high) = along, radii
    corners = (_mm(left, low), _mm(right, low), _mm(right, high), _mm(left, high))
    return polygon(*(corner - origin for corner in corners))


def _strokes(role: str, lines: Iterable[Sequence[complex]]) -> list[Stroke]:
    """Lines through places [mm]."""
    contours = tuple(polygon(*line) for line in lines)
    return [Stroke(role=role, contours=contours)] if contours else []


def _describe(group: Group) -> str:
    """What a pointer over a body says."""
    first = group.first
    teeth = f"<br>{first.form.teeth} teeth" if first.form else ""
    wide = f"<br>face width {engineering(1e3 * first.width)} mm" if first.form else ""
    mass = f"<br>{engineering(first.mass)} kg" if np.isfinite(first.mass) and first.mass > 0 else ""
    held = "<br>held" if group.held else ""
    return f"<b>{first.short}</b>{teeth}{wide}{mass}{held}"


def _shafts(seat: Seat) -> list[Area]:
    """Shafts of the members about the axis; a gear on an axis of its own has one through it."""
    group, column, layout = seat
    found = []
    if not group.first.branch and not seat.central:
        around = (group.first.radius - layout.length(LANE / 2), group.first.radius + layout.length(LANE / 2))
        stations = [link.station for link in layout.links if link.first in {part.name for part in group.bodies}]
        reach = [station + column.shift + way * layout.length(12) for station in stations for way in (-1, 1)]
        reach += [seat.beyond(side, SEGMENT) for side in SIDES]
        found += _boxes(seat, (min(reach), max(reach)), around, "shaft", signs=(1,))
    for side in [] if column.lone else seat.sides:
        start = column.edge(side) if group.first.form else layout.cheek(column, side)[0]
        if group.internal:
            start = seat.disc(side)[0]
        found += _boxes(seat, (start, seat.end(side)), seat.shaft(side), "shaft", body=_at_end(group, side))
    return found


def _body(seat: Seat) -> list[DrawnShape]:
    """A gear, a carrier, or a body without teeth, which is a disc."""
    if seat.group.first.form is not None:
        return _gear(seat)
    if seat.carried:
        return list(_carrier(seat))
    half, middle = seat.layout.length(BODY / 2), seat.group.first.station + seat.column.shift
    return list(_boxes(seat, (middle - half, middle + half), (seat.base, seat.height), "cut"))


def _gear(seat: Seat) -> list[DrawnShape]:
    """Faces with three tooth traces on each, what joins them, and the disc that carries a turning ring."""
    group, shift = seat.group, seat.column.shift
    low = seat.base if not group.internal and seat.central else group.low
    shapes: list[DrawnShape] = []
    for one, other in pairwise(group.faces):
        if web := _web(seat, low):
            shapes += _boxes(seat, (one[1] + shift, other[0] + shift), web, "shaft")
    for body in group.bodies:
        for left, right, hand in faces(body):
            along, radii = (left + shift, right + shift), (low, group.high)
            shapes += _boxes(seat, along, radii, "cut", body=body)
            shapes += _tooth_traces(seat, body, along, radii, hand) if hand else []
    for side in seat.sides if group.internal else ():
        plate, body = seat.disc(side), _at_end(group, side)
        assert body.form is not None
        rim = (body.form.root_radius, group.high)
        shapes += _boxes(seat, (seat.column.edge(side), plate[1]), rim, "cut", body=body)
        shapes += _boxes(seat, plate, (seat.shaft(side)[0], group.high), "cut", body=body)
    return shapes


def _tooth_traces(seat: Seat, body: Part, along: Ends, radii: Ends, hand: int) -> list[Stroke]:
    """Three teeth on the side of a face [m] that looks at the viewer: of a right hand they fall to the right."""
    (left, right), tall, pivot = along, radii[1] - radii[0], _pivot(seat, body)
    slope = -hand * math.tan(seat.group.first.helix_angle)
    reach = min(0.40 * (right - left), 0.12 * tall / max(abs(slope), 1e-9)) * complex(1, slope)
    middles = [complex((left + right) / 2, radii[0] + share * tall) for share in (0.2, 0.5, 0.8)]
    ends = [[middle - reach, middle + reach] for middle in middles]
    lines = [[[_mm(end.real, sign * end.imag) - pivot for end in line] for line in ends] for sign in seat.signs]
    contours = [tuple(polygon(*line) for line in own) for own in lines]
    return [Stroke(role="helix", kind=seat.group.kind, body=body.name, at=pivot, contours=own) for own in contours]


def _web(seat: Seat, low: float) -> Ends | None:
    """What joins two helices: the body of one gear, a neck between two, nothing between two that are apart."""
    group, middle = seat.group, seat.group.first.radius
    thick = 0.82 if len(group.bodies) == 1 else 0.5
    names = {part.name for part in group.bodies}
    if len(group.bodies) > 1 and not any({link.first, link.second} <= names for link in seat.layout.links):
        return None
    if group.internal:
        return group.high - thick * (group.high - group.low), group.high
    if seat.central:
        return low, max(low, thick * group.high)
    return max(0.0, middle - thick * (middle - group.low)), middle + thick * (group.high - middle)


def _carrier(seat: Seat) -> list[Area]:
    """A cheek on either side of the planets, down to its shaft where it has one there."""
    group, column, layout = seat
    shapes = []
    for side in SIDES:
        stack = column.stacks[side]
        floor = layout.lane(column.passing + len(stack))[0] + layout.length(AIR)
        for sign in seat.signs:
            radii = [pin.first.radius for pin in seat.carried if pin.half == sign]
            radii = radii or [pin.first.radius for pin in seat.carried]
            low = seat.shaft(side)[0] if group.key in stack else max(floor, 0.5 * radii[0])
            top = max(radii) + max(layout.length(2 * PLATE), 0.12 * radii[0])
            along = layout.cheek(column, side)
            shapes += _boxes(seat, along, (low, top), "cut", signs=(sign,), body=_at_end(group, side))
    return shapes


def _pins(column: Column, layout: SectionLayout) -> list[Area]:
    """Pins of planets: from cheek to cheek of their carrier, or from wall to wall of the housing."""
    shapes = []
    carriers = {part.name: group for group in column.groups for part in group.bodies}
    pins = [group for group in column.groups if group.first.branch]
    for radius, half, carrier in sorted({(pin.first.radius, pin.half, pin.first.carried_by) for pin in pins}):
        held = carrier in carriers
        left, right = (layout.cheek(column, side)[0 if held else 1] for side in SIDES)
        thick = layout.length(0.5 * LANE)
        radii = (half * radius - thick, half * radius + thick)
        if held:
            shapes += _boxes(Seat(carriers[carrier], column, layout), (left, right), radii, "cut", signs=(1,))
        else:
            shapes.append(Area(role="pin of the housing", contours=(_box((left, right), radii),)))
    return shapes


def _meshes(meshes: Sequence[Mating], layout: SectionLayout) -> list[Stroke]:
    """A line along the face at the pitch point of every mesh in the plane, for all branches; of two planets of a branch
    beside the plane, at the distance of their pitch point from the axis.
    """
    where = layout.seat_of
    parts = (split_name(one.name) for one in meshes)
    alike = grouped(((stage, pair, side) for stage, pair, _, side in parts), meshes)
    shapes = []
    for (_, _, side), branches in alike.items():
        drawn = [one for one in branches if one.a in where and one.b in where]
        if not drawn:
            continue
        one, names = drawn[0], tuple(branch.name for branch in branches)
        a, b = where[one.a].group, where[one.b].group
        pairs = product((a.low, a.high), (b.low, b.high))
        apart, level = min((abs(mine - other), (mine + other) / 2) for mine, other in pairs)
        beside = bool(a.first.branch and b.first.branch) or apart > 0.2 * max(a.high, b.high)
        if beside:
            level = abs(complex(a.first.x, a.first.y) + cmath.rect(pitch_radius(a.first, one), one.direction))
        halves = sorted(set(where[one.a].signs) & set(where[one.b].signs)) or [1]
        shift = where[one.a].column.shift
        for left, right in _common(one, a, b, side):
            lines = [polygon(_mm(left + shift, sign * level), _mm(right + shift, sign * level)) for sign in halves]
            role = "mesh beside" if beside else "mesh"
            shapes += [Stroke(role=role, meshes=names, contours=(line,)) for line in lines]
    return sorted(shapes, key=lambda shape: shape.role)


def _common(mating: Mating, a: Group, b: Group, side: str) -> list[Ends]:
    """Where the faces of two gears lie over each other [m]: of a mesh of one side of two double ones that side's."""
    of_a, of_b = (
        sorted(face for part in group.bodies if part.name == name for face in faces(part))
        for group, name in ((a, mating.a), (b, mating.b))
    )
    over = {(max(one[0], two[0]), min(one[1], two[1])) for one, two in product(of_a, of_b)}
    spans = sorted(span for span in over if span[1] > span[0])
    return {"left": spans[:1], "right": spans[-1:]}.get(side, spans) if len(spans) > 1 else spans


def _couplings(layout: SectionLayout) -> list[DrawnShape]:
    """Shaft ends with facing flanges, and what is elastic between them; shafts that pass a stage."""
    seats = {seat.group.key: seat for seat in layout.seats}
    shapes: list[DrawnShape] = []
    gaps: list[list[complex]] = []
    for one in layout.couplings:
        left, right = seats[one.left], seats[one.right]
        before = layout.columns[layout.columns.index(right.column) - 1]
        start, stop = left.end("right"), right.end("left")
        lanes = [layout.lane(number) for number in _levels(one, left, right)]
        passed = layout.beyond(before, "right", before.rooms["right"])
        bound = start if before is left.column else max(start, passed)
        middle, air, flange = (bound + stop) / 2, layout.length(3), layout.length(4)
        words = _spring(next(link for link in layout.links if link.name == one.name))
        signs = (1, -1) if layout.both else (1,)
        ours, theirs = _at_end(left.group, "right"), _at_end(right.group, "left")
        first = lanes[0] if one.lane < 0 else lanes[1]
        shapes += _boxes(left, (start, middle - air), first, "shaft", signs=signs, body=ours)
        shapes += _boxes(right, (middle + air, stop), lanes[2], "shaft", signs=signs, body=theirs)
        if one.lane >= 0 and lanes[0] != lanes[1]:
            step = (min(lanes[0][0], lanes[1][0]), max(lanes[0][1], lanes[1][1]))
            shapes += _boxes(left, (start - flange, start), step, "shaft", signs=signs, body=ours)
        reach = (min(lanes[1][0], lanes[2][0]), max(lanes[1][1], lanes[2][1]) + layout.length(7))
        for sign in signs:
            radii = (sign * reach[0], sign * reach[1])
            for near, far in ((middle - air - flange, middle - air), (middle + air, middle + air + flange)):
                shapes.append(Area(role="flange", hover=words, contours=(_box((near, far), radii),)))
            gaps.append([_mm(middle, radius) for radius in radii])
    return [*shapes, *_strokes("couplings", gaps)]


def _levels(one: Coupling, left: Seat, right: Seat) -> tuple[int, int, int]:
    """Lanes where a coupling begins, runs and ends; a lone body takes a shaft where it comes."""
    begin, end = left.lane("right"), right.lane("left")
    run = one.lane if one.lane >= 0 else end if left.column.lone and not right.column.lone else begin
    return run if left.column.lone else begin, run, run if right.column.lone else end


def _supports(layout: SectionLayout) -> list[DrawnShape]:
    """Bearings and supports where they stand, and the housing that they, pins and held members stand in."""
    where = layout.seat_of
    marks: dict[Ends, list[SectionLink]] = {}
    walls: set[tuple[float, float, str]] = set()
    stems: list[tuple[complex, complex]] = []
    for link in layout.links:
        ends = [where[name] for name in (link.first, link.second) if name in where]
        if link.kind not in ("support", "bearing") or not ends or not (link.radial or link.axial or link.turning):
            continue
        seat = next((one for one in ends if one.group.first.branch), ends[0])
        group = seat.group
        for sign in seat.signs:
            z, r = _place(link, seat)
            fixed = not link.second and (group.held or link.turning) and not group.first.branch
            if group.internal:
                top = group.high + layout.length(20)
                walls.add((round(z, 9), sign * top, "up" if sign > 0 else "down"))
                stems.append((_mm(z, sign * group.high), _mm(z, sign * top)))
                r = group.high + layout.length(10)
            if fixed and not group.internal and seat.sides and not seat.column.lone:
                side = seat.sides[0]
                walls.add((round(seat.end(side), 9), sign * seat.shaft(side)[1] / 2, side))
            if not (fixed and group.internal) and (link.radial or link.axial):
                marks.setdefault((round(z, 9), sign * r), []).append(link)
    for group, column, _ in layout.seats:  # pins of planets that no carrier holds stand in the housing
        if group.first.branch and not group.first.carried_by:
            ends_of = [(round(layout.cheek(column, side)[1], 9), side) for side in SIDES]
            walls |= {(end, group.half * group.first.radius, side) for end, side in ends_of}
    return [
        *_strokes("stem", dict.fromkeys(stems)),
        *_strokes("housing", [line for wall in sorted(walls) for line in _wall(*wall, layout)]),
        *_marked(marks),
    ]


def _place(link: SectionLink, seat: Seat) -> Ends:
    """Place of a support or bearing [m]: its station; of one in the middle of its member, the shaft that shows."""
    group, column, layout = seat
    station = link.station if np.isfinite(link.station) else group.first.station
    among = column.low <= station <= column.high
    z = station + column.shift
    if group.first.branch:
        return z, group.first.radius
    if group.internal:
        return z, group.high
    if not seat.central:
        return seat.beyond("left", 0.5 * SEGMENT) if among else z, group.first.radius
    if column.lone or not seat.sides:
        return z, seat.base + layout.length(LANE if column.lone else LANE / 2)
    side = "right" if "right" in seat.sides and station > (column.low + column.high) / 2 else seat.sides[0]
    out = layout.length(SEGMENT / 2 if not group.held else 0.7 * SEGMENT)
    shown = seat.end(side) + (-out if side == "right" else out)
    return shown if among else z, sum(seat.shaft(side)) / 2


def _marked(marks: Mapping[tuple[float, float], Sequence[SectionLink]]) -> list[DrawnShape]:
    """Marks of supports and bearings, elastic or rigid, and of those that hold axially; places [m]."""
    rigid = {
        at: all(math.isinf(max(link.stiffness[:2])) for link in links)
        for at, links in marks.items()
        if any(link.radial for link in links)
    }
    words = {at: "<br>".join(map(_spring, links)) for at, links in marks.items()}
    order = sorted(rigid, key=lambda at: rigid[at])
    seats = [Symbol(role="rigid" if rigid[at] else "elastic", at=_mm(*at), hover=words[at]) for at in order]
    axial = [at for at, links in marks.items() if any(link.axial for link in links)]
    return [*seats, *(Symbol(role="axial", at=_mm(*at)) for at in axial)]


def _wall(at: float, height: float, way: str, layout: SectionLayout) -> list[list[complex]]:
    """The housing at a place [m]: a line with oblique strokes ``left`` or ``right`` of it, ``up`` or ``down``."""
    half, deep = layout.length(10), layout.length(5) * (1 if way in ("up", "right") else -1)
    strokes = [((0.0, one), (deep, one - abs(deep))) for one in np.linspace(-half, half, 5)]
    # of an upright wall; the others are these with their axes exchanged
    turned = 1 if way in ("left", "right") else -1
    return [[_mm(at, height) + _mm(*end[::turned]) for end in ends] for ends in (((0.0, -half), (0.0, half)), *strokes)]


def _spring(link: SectionLink) -> str:
    """The stiffness of a link (6,) [N/m, N m/rad] in words."""
    rows = [
        f"{direction}: {'rigid' if np.isinf(value) else f'{engineering(float(value))} {unit}'}"
        for direction, unit, value in zip(_DIRECTIONS, _UNITS, link.stiffness, strict=True)
        if value > 0
    ]
    return "<br>".join([f"<b>{link.name}</b>", *rows])


def section_names(layout: SectionLayout) -> list[Text]:
    """Names in the gears where they fit, else beside them; of rings and lone bodies above, with the stage's name."""
    several = sum(not column.lone for column in layout.columns) > 1
    found: list[Text] = []
    for column in layout.columns:
        seats = {seat.group.key: seat for seat in layout.seats if seat.column is column}
        found += [_name(seat) for seat in seats.values() if column.lone or not seat.group.internal]
        if not column.lone:
            found += _rings(f"<b>{column.place}</b>" if several else "", column, layout)
            found += [one for side in SIDES for key in column.stacks[side] for one in _port(seats[key], side)]
    return found


def _rings(title: str, column: Column, layout: SectionLayout) -> list[Text]:
    """Names of the rings above them, each over its own where they have room side by side; the name of the stage."""
    rings = [group for group in column.groups if group.internal]
    texts = [group.word + (" (held)" if group.held else "") for group in rings]
    middles = [(group.faces[0][0] + group.faces[-1][1]) / 2 + column.shift for group in rings]
    if len(rings) > 1:
        places = sorted(zip(middles, texts, strict=True))
        room = [
            (far - near) * layout.scale - (text_width(one) + text_width(other)) / 2
            for (near, one), (far, other) in pairwise(places)
        ]
        if min(room) < AIR:
            middles, texts = [sum(middles) / len(middles)], [", ".join(texts)]
    if title and len(texts) == 1:
        texts = [f"{title}<br>{texts[0]}"]
    elif title or not texts:
        middles, texts = [*middles, column.middle], [*texts, title]
    found = []
    for middle, text in zip(middles, texts, strict=True):
        lift = (46 if len(texts) > 1 and text == title else 30) if rings else 4
        if text:
            at = _mm(middle, column.top)
            found.append(Text(role="name", text=text, at=at, anchor=("center", "bottom"), shift=(0, lift)))
    return found


def _power(group: Group) -> str:
    size, way = abs(group.power), "in" if group.power > 0 else "out"
    return f"{engineering(size / 1e6)} MW {way}" if size >= 1e6 else f"{engineering(size / 1e3)} kW {way}"


def _name(seat: Seat) -> Text:
    group, column, layout = seat
    if column.lone:
        words = group.word + (f"<br>{_power(group)}" if group.power else "")
        at = _mm(column.middle, seat.height)
        return Text(role="name", text=words, at=at, anchor=("center", "bottom"), shift=(0, 3))
    words = group.word + (" (held)" if group.held else "")
    if group.first.form is None:
        pins = seat.carried
        level = pins[0].half * 1.05 * pins[0].first.radius if pins else seat.height
        side, towards = ("left", "right") if _crowded(column, "right") else ("right", "left")
        at = _mm(seat.beyond(side, 2.0 * PLATE), level)
        return Text(role="name", text=words, at=at, anchor=(towards, "middle"))
    names = {part.name for part in group.bodies}
    held = any(link.radial for link in layout.links if link.kind == "support" and link.first in names)
    if not group.first.branch and not held:
        words += ", floats"
    left, right = (one + column.shift for one in (group.faces[0][0], group.faces[-1][1]))
    top = group.high
    low = group.first.radius + layout.length(8) if group.first.radius > 1e-9 else seat.base
    wide, tall = (right - left) * layout.scale, (top - low) * layout.scale
    middle, level = (left + right) / 2, group.half * (low + top) / 2
    broken = words.replace(", ", "<br>").replace(" (", "<br>(")
    for text, size in ((words, 12), (broken, 12), (words, 10), (broken, 10)):
        long, high = text_width(text) * size / 12 + 4, 1.25 * size * (text.count("<br>") + 1) + 3
        level_fits, upright_fits = long <= wide and high <= tall, long <= tall and high <= wide
        if level_fits or upright_fits:
            at, upright = _mm(middle, level), not level_fits
            return Text(role="name", text=text, at=at, size=size, upright=upright, backing=group.kind)
    discs = {side for side in SIDES if _crowded(column, side)}
    side = "right" if "left" in discs and "right" not in discs else "left"
    beside = seat.beyond(side, (4.5 * PLATE if side in discs else 1.8 * PLATE) if group.first.branch else 4)
    anchor = ("right" if side == "left" else "left", "middle")
    return Text(role="name", text=words, at=_mm(beside, level), anchor=anchor, backing="white")


def _crowded(column: Column, side: str) -> bool:
    """Whether the disc of a ring stands on that side of the gears."""
    return any(group.internal and side in column.sides_of(group) for group in column.groups)


def _port(seat: Seat, side: str) -> list[Text]:
    """Power at the end of a shaft, with the way it goes."""
    group, column, layout = seat
    if not group.power or any(group.key in (one.left, one.right) for one in layout.couplings):
        return []
    low, high = seat.shaft(side)
    arrow = "←" if (group.power > 0) == (side == "right") else "→"
    words = f"{arrow} {_power(group)}" if side == "right" else f"{_power(group)} {arrow}"
    towards, shift = ("left", 6) if side == "right" else ("right", -6)
    at = seat.end(side)
    # above where another shaft comes out of this one
    level, up = (high, "bottom") if column.stacks[side].index(group.key) else ((low + high) / 2, "middle")
    return [Text(role="name", text=words, at=_mm(at, level), anchor=(towards, up), shift=(shift, 0), backing="white")]
