"""What is joined to what: couplings and bearings between shafts, plates and the casing; which parts turn as one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from .structure import Component
from .units import Number, shown
from .view import View

__all__ = ["RIGID", "Joint", "Parts", "joints_of", "rigid_parts"]

# Stiffness from which on a joint is rigid: "rigid" of the programs is 1e20 N/m and more, real joints stay below 1e13.
RIGID = 1e16
_BEARINGS = (
    "concept_bearing",
    "rolling_bearing_with_catalog_geometry",
    "rolling_bearing_with_detailed_geometry",
    "slide_bearing",
    "hydrodynamic_radial_plain_bearing",
)
_COUPLINGS = ("coupling", "switchable_coupling", "fixed_coupling")
_KINDS = {
    "radial_stiffness": "stiffness",
    "axial_stiffness": "stiffness",
    "bending_stiffness": "torsional_stiffness",
    "rotational_stiffness": "torsional_stiffness",
}


@dataclass(frozen=True, slots=True)
class Joint:
    """A bearing or coupling between two parts.

    id : of its component.  inner, outer : ids of the parts.  bearing : turns freely about its axis.
    radial, axial, tilt, turn : stiffness, None where not given; infinite where rigid, 0 where it holds nothing.
    """

    id: int
    inner: int
    outer: int
    bearing: bool
    radial: Number | None
    axial: Number | None
    tilt: Number | None
    turn: Number | None

    @property
    def rigid(self) -> bool:
        """Whether it lets nothing move."""
        return not self.bearing and all(
            n is None or n.si >= RIGID for n in (self.radial, self.axial, self.tilt, self.turn)
        )

    @property
    def holds_turn(self) -> bool:
        """Whether a torque passes through it."""
        return not self.bearing and (self.turn is None or self.turn.si > 0)

    def other(self, part: int) -> int:
        """The part at its other side."""
        return self.outer if part == self.inner else self.inner


def joints_of(view: View) -> list[Joint]:
    """Bearings and couplings of a file, engaged ones, by id. Raises ModelError for a stiffness without its unit."""
    found = []
    for relation in view.relations("side", "coupling", "connection"):
        joint, inner, outer = relation.part("assembly"), relation.part("inner_part"), relation.part("outer_part")
        if joint is None or inner is None or outer is None:
            sides = [part for role, part in relation.refs if role not in ("assembly", "coupling", "connection")]
            joint = joint if joint is not None else relation.part("coupling") or relation.part("connection")
            if joint is None or len(sides) != 2:
                for part in [joint] if joint is not None else []:
                    view.lose(part, "side", "not between two parts")
                continue
            inner, outer = sides
        if _engaged(view, view.components[joint]):
            found.append(_joint(view, view.components[joint], inner, outer))
    return sorted(found, key=lambda one: one.id)


def _engaged(view: View, component: Component) -> bool:
    """Whether a coupling is engaged in the gear that is shifted."""
    if component.type != "switchable_coupling":
        return True
    value = view.value(component.id, "is_engaged")
    if isinstance(value, tuple):
        units = view.of_type("gear_unit")
        shifted = view.value(units[0].id, "gear_shift_index") if units else 1
        index = int(shifted) - 1 if isinstance(shifted, (int, float)) and 1 <= shifted <= len(value) else 0
        value = value[index] if value else None
    if value is None:
        view.assume(component.id, "is_engaged", "", "not said whether it is engaged: taken as engaged")
    if value is False:
        view.lose(component.id, "is_engaged", "a coupling that is not engaged")
    return value is not False


def _joint(view: View, component: Component, inner: int, outer: int) -> Joint:
    """A joint with its stiffnesses; what a bearing does not take up is 0."""
    bearing = component.type in _BEARINGS
    stiffness = {name: view.number(component.id, name, kind) for name, kind in _KINDS.items()}
    radial, axial = stiffness["radial_stiffness"], stiffness["axial_stiffness"]
    if bearing:
        if radial is None:
            radial = _at_operating_point(view, component)
        if view.value(component.id, "radial_force_absorption") is False:
            radial = Number(0.0, "0")
        absorbed = view.value(component.id, "axial_force_absorption")
        if absorbed == "no_direction":
            axial = Number(0.0, "0")
        elif isinstance(absorbed, str) and absorbed != "both_directions" and (axial is None or axial.si > 0):
            reason = f"{absorbed}: holds in both directions"
            view.assume(component.id, "axial_force_absorption", "", reason)
    return Joint(
        component.id,
        inner,
        outer,
        bearing,
        radial,
        axial,
        stiffness["bending_stiffness"],
        stiffness["rotational_stiffness"],
    )


def _at_operating_point(view: View, component: Component) -> Number | None:
    """Radial stiffness of a bearing from that at its operating point: the mean of both directions."""
    both = [
        view.number(component.id, f"operating_point_stiffness_f_{axis}_d_{axis}", "stiffness") for axis in ("v", "w")
    ]
    given = [number.si for number in both if number is not None]
    if not given:
        return None
    mean = sum(given) / len(given)
    view.assume(component.id, "operating_point_stiffness", "", "mean of both radial directions, without cross terms")
    return Number(mean, f"{shown(mean)} N/m")


@dataclass(slots=True)
class Parts:
    """Which parts are one: a union of sets of ids."""

    _above: dict[int, int] = field(default_factory=dict)

    def root(self, part: int) -> int:
        """The part that stands for all that are one with this."""
        path = []
        while (above := self._above.get(part, part)) != part:
            path.append(part)
            part = above
        for one in path:
            self._above[one] = part
        return part

    def join(self, parts: Iterable[int]) -> None:
        """Make parts one; the least id stands for them."""
        roots = sorted({self.root(part) for part in parts})
        for one in roots[1:]:
            self._above[one] = roots[0]

    def one(self, a: int, b: int) -> bool:
        """Whether two parts are one."""
        return self.root(a) == self.root(b)


def rigid_parts(view: View, joints: Iterable[Joint]) -> Parts:
    """The parts that move as one: what is assembled in a planet carrier, a gear and its shaft, rigid joints."""
    parts = Parts()
    for carrier in view.of_type("planet_carrier"):
        parts.join([carrier.id, *view.parts(carrier.id, "shaft", "side_plate")])
    for shaft in view.of_type("shaft"):
        parts.join([shaft.id, *view.parts(shaft.id, "cylindrical_gear", "ring_gear", "sleeve")])
    for joint in joints:
        if joint.rigid:
            parts.join([joint.inner, joint.outer])
    return parts
