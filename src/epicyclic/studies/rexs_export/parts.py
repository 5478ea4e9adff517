"""Shafts of a train: bodies that one shaft of a REXS file stands for, with its gears, mass and place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ...train.bodies import Body, Mesh
from ...train.train import Train
from .draft import Draft

__all__ = ["GearPart", "Key", "ShaftPart", "shafts_of"]

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
