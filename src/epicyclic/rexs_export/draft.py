"""A REXS file while it is put together, and what of a model it does not carry.

Components have attributes in the units of version 1.7, relations and places.  The keys of a model that the file carries
are listed; every other one of a document is named, with the reason.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from ..document.tables import leaves
from ..rexs.file import Attribute, Component, Relation, Value

Attributes = Mapping[str, tuple[Value, str]]
# what programs write for rigid, and every reader takes for it [N/m, N mm/rad]
RIGID = 1e20


@dataclass(frozen=True, slots=True)
class Dropped:
    """Something of a model that the file does not carry.

    path : in the model file.  text : what becomes of it, or why it has no place.
    """

    path: str
    text: str


@dataclass(slots=True)
class Draft:
    """Components and relations in the order in which they are added; ids count from 1.

    dropped : what is not carried, each once.
    """

    components: list[Component] = field(default_factory=list)
    relations: list[Relation] = field(default_factory=list)
    dropped: dict[Dropped, None] = field(default_factory=dict)

    def add(self, kind: str, name: str, attributes: Attributes | None = None) -> int:
        """Add a component, attributes without value left out; its id."""
        number = len(self.components) + 1
        given = {
            key: Attribute(key, value, unit) for key, (value, unit) in (attributes or {}).items() if value is not None
        }
        self.components.append(Component(number, kind, name, given))
        return number

    def relate(self, kind: str, *, order: int | None = None, **roles: int) -> None:
        """Add a relation of components by their roles."""
        self.relations.append(Relation(len(self.relations) + 1, kind, order, tuple(roles.items())))

    def drop(self, path: str, text: str) -> None:
        """Note what is not carried."""
        self.dropped[Dropped(path, text)] = None


def in_unit(value: float, factor: float) -> float:
    """An SI value in a unit, value / factor, without the digits that the division alone leaves.

    Fifteen digits are taken where they say the same number within two units in the last place: 380, not
    380.00000000000006; any other number keeps all of its digits.
    """
    scaled = value / factor + 0.0
    if not math.isfinite(scaled):
        return scaled
    short = float(f"{scaled:.15g}")
    return short if abs(short - scaled) <= 2 * math.ulp(scaled) else scaled


def place(station: float, x: float = 0.0, y: float = 0.0) -> Attributes:
    """Place and axes of a part in the frame of the gear unit: u is z, w is x through planet 1, v is -y [mm].

    The axes are right-handed: u x v = w, as z x (-y) = x.
    """
    return {
        "reference_component_for_position": (1, "none"),
        "support_vector": (tuple(in_unit(value, 1e-3) for value in (station, -y, x)), "mm"),
        "u_axis_vector": ((1.0, 0.0, 0.0), "mm"),
        "w_axis_vector": ((0.0, 0.0, 1.0), "mm"),
    }


_LINK = r"(?:\.[\w-]+)?\.(?:radial|x|y|z|tilt|rx|ry|rz|at|to)"
_CARRIED = re.compile(
    r"format|title|material\.\w+"
    r"|stages\.[\w-]+\.(?:planets|planet_angles|centre_distance|module|helix_angle|pressure_angle|face_width"
    r"|herringbone|gap|split)"
    r"|stages\.[\w-]+\.(?!meshes)[\w-]+\.(?:teeth|module|helix_angle|pressure_angle|face_width|profile_shift|addendum"
    r"|dedendum|tip_diameter|root_diameter|base_radius|mass|inertia|tilt_inertia|hand|kind|on|station|pin_radius|gap"
    r"|split|herringbone|rim|outer_diameter)"
    r"|stages\.[\w-]+\.(?:[\w-]+\.)?material\.\w+"
    rf"|stages\.[\w-]+\.[\w-]+\.(?:support|bearing){_LINK}"
    r"|stages\.[\w-]+\.(?:[\w-]+\.)?flank\.(?:tip_relief\.(?:amount|length|shape)|crown)"
    r"|stages\.[\w-]+\.(?:[\w-]+\.)?flank\.(?:root_relief|end_relief|slope|profile|waves|pitch)(?:\..*)?"
    r"|stages\.[\w-]+\.meshes\.[\w-]+\.(?:stiffness|direction|backlash)(?:\..*)?"
    rf"|bodies\.[\w-]+\.(?:mass|inertia|tilt_inertia|station|support{_LINK})"
    r"|couplings\.[\w-]+\.(?:between|radial|x|y|z|tilt|rx|ry|rz|radius)"
    r"|operation\.(?:held|gravity|(?:speed|torque|power)\..+)"
)
_FOLLOWS = re.compile(r".*\.(?:clearance|exponent|friction|damping|table|load|law)(?:\..*)?")
_REASONS = (
    (r"assumed\..*", "what is assumed is written like what is given"),
    (r"(?:doi|notes)$", "a text of the model file"),
    (r"damping\..*", "the format has no damping of a whole train"),
    (r"tolerance\..*", "distributions of deviations have no place"),
    (r"deviations\..*", "deviations have no place; what they do to the mean load is in K_gamma"),
    (r"loads\..*|operation\.loads.*", "forces on members are not written"),
    (r".*\.bore$", "only the mass that follows from it is written"),
    (r".*\.meshes\.[^.]+\.variation.*", "the file has the mean stiffness"),
    (r".*\.meshes\.[^.]+\.(?:phase|pressure_angle)", "follows from the geometry in the file"),
    (r".*\.(?:neck|shaft)(?:\..*)?$", "one rigid shaft in the file"),
    (r".*\.clocking", "the phase of the second gear of a planet has no place"),
    (r".*\.tip_rounding", "of a tool that the file does not have"),
)


def left_out(document: Mapping[str, object]) -> Iterator[Dropped]:
    """What stands in a document and is not carried, each value with its path; tables of reasons as one entry."""
    seen: dict[str, None] = {}
    for path, _ in leaves({key: value for key, value in document.items()}):
        if _CARRIED.fullmatch(path):
            continue
        short = _short(path)
        if short not in seen:
            seen[short] = None
            yield Dropped(short, _reason(path))


def _short(path: str) -> str:
    """The path; of assumptions, costs and deviations the entry they belong to."""
    if path.startswith("assumed."):
        return "assumed"
    if path.startswith("tolerance.cost."):
        return "tolerance.cost"
    if path.startswith("deviations."):
        return re.sub(r"\.(?:amplitude|phase|order|seed|value|frequency)$", "", path)
    return path


def _reason(path: str) -> str:
    """Why a path is not carried."""
    found = next((text for pattern, text in _REASONS if re.fullmatch(pattern, path)), None)
    if found is not None:
        return found
    return "laws of links have no place" if _FOLLOWS.fullmatch(path) else "no place in the format"
