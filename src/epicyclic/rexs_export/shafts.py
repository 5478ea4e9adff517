"""Shafts of a train in a REXS file, with what holds and drives them.

One shaft stands for bodies that turn together, with its gears, mass and place.  Supports, bearings and couplings are
bearings and couplings of the file; speeds and external torques stand on the shafts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..document.tables import value_at
from ..rexs.file import Value
from ..train.bodies import Body, Link, Mesh
from ..train.train import Train
from .draft import RIGID, Attributes, Draft, in_unit, place

Key = tuple[str, str | None]
"""A gear: name of its body, and left or right of a herringbone gear in one body, else None."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GearPart:
    """One helix of a gear.

    key, body.  hand : +1 right, -1 left, 0 spur.  station : its middle [m].
    """

    key: Key
    body: Body
    hand: int
    station: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftPart:
    """Bodies that turn together in one shaft.

    name : member, with its branch.  bodies : the halves of a split member, the gears of a stepped planet, or one.
    gears : from left to right.  mass [kg], inertia, tilt_inertia [kg m^2], nan where not known.  start : left end [m].
    """

    name: str
    bodies: tuple[Body, ...]
    gears: tuple[GearPart, ...]
    mass: float
    inertia: float
    tilt_inertia: float
    start: float

    @property
    def first(self) -> Body:
        """The body whose place is that of the shaft."""
        return self.bodies[0]

    @property
    def station(self) -> float:
        """Axial place of its tilt inertia [m]: between the halves of a member, else at its first gear."""
        return _middle(self.bodies)


def _middle(bodies: tuple[Body, ...]) -> float:
    """Axial place between the halves of a member, else of the first body [m]."""
    first = bodies[0]
    alike = [body.station for body in bodies if body.member == first.member]
    return math.fsum(alike) / len(alike)


def shafts_of(train: Train, draft: Draft) -> tuple[ShaftPart, ...]:
    """The shafts of a train, in the order of its bodies; what is taken together is noted."""
    above = {body.name: body.name for body in train.bodies}

    def root(name: str) -> str:
        while above[name] != name:
            name = above[name]
        return name

    for link in train.links:
        if link.kind in ("shaft", "neck") and link.second is not None:
            a, b = root(link.first), root(link.second)
            above[b] = a
            if any(math.isfinite(value) for value in link.stiffness):
                draft.drop(link.path, f"elastic {link.kind}: one rigid shaft in the file")
    by_half: dict[tuple[str, int | None], str] = {}
    for body in train.bodies:
        if body.side is None:
            continue
        first = by_half.setdefault((body.member, body.branch), body.name)
        if root(first) != root(body.name):
            above[root(body.name)] = root(first)
            draft.drop(f"stages.{body.member}.split", "halves without a neck: one rigid shaft in the file")
    groups: dict[str, list[Body]] = {}
    for body in train.bodies:
        groups.setdefault(root(body.name), []).append(body)
    for bodies in groups.values():
        for other in bodies:
            if other.member != bodies[0].member:
                draft.drop(f"stages.{other.member}.mass", f"one mass in the file, with that of {bodies[0].member}")
    hands = _hands(train.meshes)
    return tuple(_shaft(tuple(bodies), hands) for bodies in groups.values())


def _hands(meshes: tuple[Mesh, ...]) -> Mapping[Key, int]:
    """Hand of each helix, from its meshes: mates outside have opposite hands, a ring that of its planet."""
    found: dict[Key, int] = {}
    for mesh in meshes:
        found.setdefault((mesh.a, mesh.side), mesh.hand)
        found.setdefault((mesh.b, mesh.side), mesh.hand if mesh.internal else -mesh.hand)
    return found


def _gears(body: Body, hands: Mapping[Key, int]) -> list[GearPart]:
    """The helices of a body."""
    gear = body.gear
    if gear is None:
        return []
    if not gear.herringbone:
        hand = hands.get((body.name, body.side), hands.get((body.name, None), gear.hand))
        return [GearPart(key=(body.name, body.side), body=body, hand=hand, station=body.station)]
    apart = ((gear.face_width or 0.0) + gear.gap) / 2
    return [
        GearPart(key=(body.name, side), body=body, hand=hands.get((body.name, side), sign * gear.hand),
                 station=body.station + way * apart)
        for side, sign, way in (("left", 1, -1), ("right", -1, 1))
    ]  # fmt: skip


def _shaft(bodies: tuple[Body, ...], hands: Mapping[Key, int]) -> ShaftPart:
    gears = tuple(sorted((g for body in bodies for g in _gears(body, hands)), key=lambda gear: gear.station))
    middle, first = _middle(bodies), bodies[0]
    name = first.member if first.branch is None else f"{first.member} {first.branch}"
    ends = [gear.station - ((gear.body.gear.face_width if gear.body.gear else None) or 0.0) / 2 for gear in gears]
    return ShaftPart(
        name=name,
        bodies=bodies,
        gears=gears,
        mass=math.fsum(body.mass for body in bodies),
        inertia=math.fsum(body.inertia for body in bodies),
        tilt_inertia=math.fsum(b.tilt_inertia + b.mass * (b.station - middle) ** 2 for b in bodies),
        start=min(ends, default=middle),
    )


_LEFT_OUT = (
    ("clearance", lambda link: link.clearance > 0, "play"),
    ("exponent", lambda link: link.exponent != 1, "the stiffness at its load is written, not its law"),
    ("friction", lambda link: bool(link.friction), "friction"),
    ("damping", lambda link: any(link.damping), "damping"),
    ("table", lambda link: bool(link.curves), "the nominal stiffness is written, not the table"),
)


def add_joints(
    train: Train, draft: Draft, shafts: Mapping[str, tuple[ShaftPart, int]], pins: Mapping[str, int], casing: int
) -> None:
    """Add a bearing or coupling for each link of a train.

    shafts : body -> its shaft and the id of that.  pins : planet body -> id of its pin.  casing : id of the casing.
    """
    supported: set[str] = set()
    turned: set[str] = set()
    for link in train.links:
        first, number = shafts[link.first]
        second = casing if link.second is None else shafts[link.second][1]
        if number == second:
            continue
        for key, present, text in _LEFT_OUT:
            if present(link):
                draft.drop(f"{link.path}.{key}", text)
        if link.kind == "coupling":
            _joint(draft, link, inner=number, outer=second, turn=link.stiffness[5])
            continue
        carried = first if link.second is None or link.kind == "support" else shafts[link.second][0]
        supported.add(carried.name)
        if link.kind == "bearing":
            at = casing if link.second is None else pins[link.second]
            inner, outer = (number, at) if link.second is None else (at, second)
            _joint(draft, link, inner=inner, outer=outer, turn=0.0)
            continue
        held = first.first.member in train.kinematics.held
        turn = link.stiffness[5]
        if turn > 0 and not held:
            draft.drop(
                f"{link.path}.rz", "would hold the member in the file, and the model does not hold it: left free"
            )
            turn = 0.0
        if turn > 0:
            turned.add(first.name)
        if first.first.centre != link.centre:
            draft.drop(f"{link.path}.radius", "a support off the axis: written there, read back as one on the axis")
        _joint(draft, link, inner=number, outer=second, turn=turn)
    _missing(train, draft, shafts, supported, turned, casing)


def _missing(
    train: Train,
    draft: Draft,
    shafts: Mapping[str, tuple[ShaftPart, int]],
    supported: set[str],
    turned: set[str],
    casing: int,
) -> None:
    """Add rigid bearings of central members without a support, and rigid couplings of held ones that none holds."""
    done: set[int] = set()
    for shaft, number in shafts.values():
        member = shaft.first.member
        if number in done or shaft.first.branch is not None:
            continue
        done.add(number)
        held = member in train.kinematics.held and shaft.name not in turned
        if held or shaft.name not in supported:
            along = 0.0 if shaft.name in supported else math.inf
            stiffness = (along, along, along, along, along, math.inf if held else 0.0)
            link = Link(
                name=f"{member} {'held' if held else 'bearing'}", path=f"stages.{member}.support", kind="support",
                first=shaft.first.name, second=None, station=shaft.station, stiffness=stiffness,
            )  # fmt: skip
            _joint(draft, link, inner=number, outer=casing, turn=stiffness[5])


def _joint(draft: Draft, link: Link, *, inner: int, outer: int, turn: float) -> None:
    """Add one joint: a bearing where it turns freely, else a coupling."""
    radial = _mean(draft, link, 0, 1, "x and y")
    tilt = _mean(draft, link, 3, 4, "rx and ry")
    axial = link.stiffness[2]
    bearing = turn == 0 and link.kind != "coupling"
    attributes: dict[str, tuple[Value, str]] = {
        **place(link.station, *link.centre),
        "radial_stiffness": (_stiff(radial, 1.0), "N / m"),
        "axial_stiffness": (_stiff(axial, 1.0), "N / m"),
        "bending_stiffness": (_stiff(tilt, 1e-3), "N mm / rad"),
    }
    if bearing:
        attributes["radial_force_absorption"] = (radial > 0, "none")
        attributes["axial_force_absorption"] = ("both_directions" if axial > 0 else "no_direction", "none")
    else:
        attributes["rotational_stiffness"] = (_stiff(turn, 1e-3), "N mm / rad")
    joint = draft.add("concept_bearing" if bearing else "coupling", link.name, attributes)
    draft.relate("side", assembly=joint, inner_part=inner, outer_part=outer)


def _mean(draft: Draft, link: Link, a: int, b: int, names: str) -> float:
    """Stiffness across both directions, the mean where they differ: the file has one."""
    first, second = link.stiffness[a], link.stiffness[b]
    if first == second:
        return first
    draft.drop(link.path, f"{names} differ ({first:.6g}, {second:.6g} in SI): the file has one, their mean")
    return (first + second) / 2


def _stiff(value: float, factor: float) -> float:
    """A stiffness in its unit, infinite as programs write rigid."""
    return RIGID if math.isinf(value) else in_unit(value, factor)


def speed_of(train: Train, shaft: ShaftPart) -> Attributes:
    """Speed of a central shaft, with whether the model states it."""
    speeds, member = train.kinematics.speed, shaft.first.member
    if speeds is None or shaft.first.branch is not None or member not in speeds:
        return {}
    defines = value_at(train.document, ["operation", "speed", *member.split(".")]) is not None
    return {"rotational_speed": (float(speeds[member]), "1 / min"), "defines_speed": (defines, "none")}


def add_loads(train: Train, draft: Draft, shafts: Mapping[str, tuple[ShaftPart, int]]) -> None:
    """Add the external torques of members that are not held: those stated define, those that balance follow."""
    kinematics = train.kinematics
    if kinematics.torque is None:
        return
    done: set[str] = set()
    for shaft, number in shafts.values():
        member = shaft.first.member
        if member in done or member in kinematics.held or shaft.first.branch is not None:
            continue
        done.add(member)
        if member not in kinematics.stated and member not in kinematics.reacting:
            continue
        attributes: Attributes = {
            "torque_around_u_axis": (float(kinematics.torque[member]), "N m"),
            "transmits_torque": (True, "none"),
            "defines_torque": (member in kinematics.stated, "none"),
            "u_coordinate_on_shaft": (in_unit(shaft.station - shaft.start, 1e-3), "mm"),
        }
        load = draft.add("external_load", f"{member} torque", attributes)
        draft.relate("assembly", assembly=number, part=load)


def gravity_of(train: Train) -> Attributes:
    """Gravity in the axes of the gear unit: u is z, v is -y, w is x."""
    x, y, z = train.gravity
    size = (x * x + y * y + z * z) ** 0.5
    if size == 0:
        return {"account_for_gravity": (False, "none")}
    return {
        "account_for_gravity": (True, "none"),
        "gravitational_acceleration": (size, "m / s^2"),
        "direction_vector_gravity_u": (z / size, "none"),
        "direction_vector_gravity_v": (-y / size + 0.0, "none"),
        "direction_vector_gravity_w": (x / size, "none"),
    }
