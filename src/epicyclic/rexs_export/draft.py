"""A REXS file while it is put together: components with attributes in the units of version 1.7, relations, places."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ..rexs.file import Attribute, Component, Relation, Value
from ..rexs.members import Inertia
from ..train.train import Body, GearData, Train

Attributes = Mapping[str, tuple[Value, str]]
# what programs write for rigid, and every reader takes for it [N/m, N mm/rad]
RIGID = 1e20
# unit of version 1.7 in SI
_FACTORS = {
    **{"mm": 1e-3, "mum": 1e-6, "deg": math.pi / 180, "N / m": 1.0, "N mm / rad": 1e-3, "N / (mm mum)": 1e9},
    **{"kg / dm^3": 1e3, "N / mm^2": 1e6, "none": 1.0},
}


@dataclass(frozen=True, slots=True)
class Dropped:
    """Something of a model that the file does not carry.

    path : in the model file.  text : what becomes of it, or why it has no place.
    """

    path: str
    text: str


Key = tuple[str, str | None]
"""A gear: name of its body, and left or right of a herringbone gear in one body, else None."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GearPart:
    """One helix of a gear.

    key, body, gear.  hand : +1 right, -1 left, 0 spur.  station : its middle [m].
    """

    key: Key
    body: Body
    gear: GearData
    hand: int
    station: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftPart:
    """Bodies that turn together in one shaft.

    name : member, with its branch.  bodies : the halves of a split member, the gears of a stepped planet, or one.
    gears : from left to right.  whole : mass and inertias, nan where not known.  start : left end [m].
    station : axial place of its tilt inertia [m]: between the halves of a member, else at its first gear.
    number : id of its component, 0 before it is added.
    """

    name: str
    bodies: tuple[Body, ...]
    gears: tuple[GearPart, ...]
    whole: Inertia
    start: float
    station: float
    number: int = 0

    @property
    def first(self) -> Body:
        """The body whose place is that of the shaft."""
        return self.bodies[0]


@dataclass(slots=True)
class Draft:
    """The file of a train: components and relations in the order in which they are added; ids count from 1.

    dropped : what is not carried, each once.  unit, casing : ids.  stages : id by name, of planetary ones.
    carriers : id of the planet carrier by member.  materials : id by values.  shafts : by body.
    pins : id by planet body.  gears : id by helix.
    """

    train: Train
    components: list[Component] = field(default_factory=list)
    relations: list[Relation] = field(default_factory=list)
    dropped: dict[Dropped, None] = field(default_factory=dict)
    unit: int = 0
    casing: int = 0
    stages: dict[str, int] = field(default_factory=dict)
    carriers: dict[str, int] = field(default_factory=dict)
    materials: dict[object, int] = field(default_factory=dict)
    shafts: dict[str, ShaftPart] = field(default_factory=dict)
    pins: dict[str, int] = field(default_factory=dict)
    gears: dict[Key, int] = field(default_factory=dict)

    @property
    def central_shafts(self) -> list[ShaftPart]:
        """The shafts that are in no branch, each once, in their order."""
        return [shaft for body, shaft in self.shafts.items() if shaft.first.branch is None and shaft.first.name == body]

    def add(self, kind: str, name: str, attributes: Attributes | None = None) -> int:
        """Add a component, attributes without value left out; its id."""
        number = len(self.components) + 1
        stated = {
            key: Attribute(key, value, unit) for key, (value, unit) in (attributes or {}).items() if value is not None
        }
        self.components.append(Component(number, kind, name, stated))
        return number

    def relate(self, kind: str, *, order: int | None = None, **roles: int) -> None:
        """Add a relation of components by their roles."""
        self.relations.append(Relation(len(self.relations) + 1, kind, order, tuple(roles.items())))

    def drop(self, path: str, text: str) -> None:
        """Note what is not carried."""
        self.dropped[Dropped(path, text)] = None


def in_unit(value: float, unit: str) -> tuple[float, str]:
    """An SI value in a unit of the file, without the digits that the division alone leaves, and the unit.

    Fifteen digits are taken where they say the same number within two units in the last place: 380, not
    380.00000000000006; any other number keeps all of its digits.
    """
    scaled = value / _FACTORS[unit] + 0.0
    if not math.isfinite(scaled):
        return scaled, unit
    short = float(f"{scaled:.15g}")
    return short if abs(short - scaled) <= 2 * math.ulp(scaled) else scaled, unit


def place(station: float, x: float = 0.0, y: float = 0.0) -> Attributes:
    """Place and axes of a part in the frame of the gear unit: u is z, w is x through planet 1, v is -y [mm].

    The axes are right-handed: u x v = w, as z x (-y) = x.
    """
    return {
        "reference_component_for_position": (1, "none"),
        "support_vector": (tuple(in_unit(value, "mm")[0] for value in (station, -y, x)), "mm"),
        "u_axis_vector": ((1.0, 0.0, 0.0), "mm"),
        "w_axis_vector": ((0.0, 0.0, 1.0), "mm"),
    }
