"""A train as components of a REXS file, in the units of version 1.7: shafts, gears, what holds and drives them, meshes.

One shaft stands for bodies that turn together, with its gears, mass and place.  Supports, bearings and couplings are
bearings and couplings of the file; speeds and external torques stand on the shafts.

Gears: teeth, diameters, flanks with their modifications, material.  Meshes, as cylindrical stages: places, stiffness
per face width, K_gamma, backlash.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from ..document.cases import at_case
from ..document.document import read
from ..document.tables import value_at
from ..document.units import Bounds, read_quantity
from ..errors import ConvergenceError, ModelError
from ..questions.sharing.definitions import known_mean_loads
from ..system.assembly import assemble
from ..system.system import faces
from ..teeth.form import PLAIN, Flank
from ..train.train import Body, GearData, Link, Mesh, Train
from .file import QUANTITIES, RELATIONS, ROW, Attribute, Component, Relation, Value, in_unit, rows_of, values_of
from .members import Inertia, SolidSection, inertia_of
from .stages import STIFFNESSES, Parts, grouped

Values = Mapping[str, Value]
"""Id of an attribute -> value in SI; None where it is not written."""


def attributes_of(values: Values) -> dict[str, Attribute]:
    """Attributes of values in SI, in the units of version 1.7."""
    given = ((key, value, ROW[key].unit) for key, value in values.items() if value is not None)
    return {
        key: Attribute(key, in_unit(value, unit) if isinstance(value, float) else value, unit)
        for key, value, unit in given
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

    @property
    def helix(self) -> float:
        """Helix angle, right-handed positive [rad]."""
        return self.hand * self.gear.helix_angle


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

    def add(self, kind: str, name: str, values: Values | None = None, *, within: int | None = None) -> int:
        """Add a component, in the units of its attributes; its id.  within : assembly that it is a part of."""
        number = len(self.components) + 1
        self.components.append(Component(number, kind, name, attributes_of(values or {})))
        if within is not None:
            self.relate("assembly", within, number)
        return number

    def relate(self, kind: str, *parts: int) -> None:
        """Add a relation of components in the roles of its type."""
        roles = tuple(zip(RELATIONS[kind], parts, strict=True))
        self.relations.append(Relation(len(self.relations) + 1, kind, None, roles))

    def drop(self, path: str, text: str) -> None:
        """Note what is not carried."""
        self.dropped[Dropped(path, text)] = None


def place(station: float, x: float = 0.0, y: float = 0.0) -> Values:
    """Place and axes of a part in the frame of the gear unit: u is z, w is x through planet 1, v is -y.

    The axes are right-handed: u x v = w, as z x (-y) = x.
    """
    return {
        "reference_component_for_position": 1,
        "support_vector": tuple(in_unit(value, ROW["support_vector"].unit) for value in (station, -y, x)),
        "u_axis_vector": (1.0, 0.0, 0.0),
        "w_axis_vector": (0.0, 0.0, 1.0),
    }


# shafts ---------------------------------------------------------------------------------------------------------------


def add_shafts(draft: Draft) -> None:
    """Add the shafts of the train with what is on them, in the order of its bodies."""
    flanks: dict[str, Flank] = {}
    for mesh in draft.train.meshes:
        if mesh.teeth is not None:
            for body, flank in ((mesh.a, mesh.teeth.flank_a), (mesh.b, mesh.teeth.flank_b)):
                if flank != PLAIN:
                    flanks.setdefault(body, flank)
    for drawn in _shafts_of(draft):
        shaft = _added_shaft(draft, drawn)
        draft.shafts |= {body.name: shaft for body in shaft.bodies}
        _relate_to_stage(draft, shaft)
        for gear in shaft.gears:
            draft.gears[gear.key] = _added_gear(draft, shaft, gear, flanks.get(gear.body.name, PLAIN))


def _shafts_of(draft: Draft) -> list[ShaftPart]:
    """The shafts of a train, in the order of its bodies; what is taken together is noted."""
    train = draft.train
    joined = Parts[str]()
    for link in train.links:
        if link.kind in ("shaft", "neck") and link.second is not None:
            joined.join([link.first, link.second])
            if any(math.isfinite(value) for value in link.stiffness):
                draft.drop(link.path, f"elastic {link.kind}: one rigid shaft in the file")
    by_half: dict[tuple[str, int | None], str] = {}
    for body in train.bodies:
        if body.side is None:
            continue
        first = by_half.setdefault((body.member, body.branch), body.name)
        if joined.root(first) != joined.root(body.name):
            joined.join([first, body.name])
            draft.drop(f"stages.{body.member}.split", "halves without a neck: one rigid shaft in the file")
    groups: dict[str, list[Body]] = {}
    for body in train.bodies:
        groups.setdefault(joined.root(body.name), []).append(body)
    for bodies in groups.values():
        for other in bodies:
            if other.member != bodies[0].member:
                draft.drop(f"stages.{other.member}.mass", f"one mass in the file, with that of {bodies[0].member}")
    # mates outside have opposite hands, a ring that of its planet
    hands: dict[Key, int] = {}
    for mesh in train.meshes:
        hands.setdefault((mesh.a, mesh.side), mesh.hand)
        hands.setdefault((mesh.b, mesh.side), mesh.hand if mesh.internal else -mesh.hand)
    return [_shaft(tuple(bodies), hands) for bodies in groups.values()]


def _shaft(bodies: tuple[Body, ...], hands: Mapping[Key, int]) -> ShaftPart:
    first = bodies[0]
    gears = tuple(sorted((g for body in bodies for g in _gears(body, hands)), key=lambda gear: gear.station))
    halves = [body.station for body in bodies if body.member == first.member and body.shaft_of is None]
    station = math.fsum(halves) / len(halves)
    return ShaftPart(
        name=first.member if first.branch is None else f"{first.member} {first.branch}",
        bodies=bodies,
        gears=gears,
        whole=Inertia(
            mass=math.fsum(body.mass for body in bodies),
            polar=math.fsum(body.inertia for body in bodies),
            tilt=math.fsum(b.tilt_inertia + b.mass * (b.station - station) ** 2 for b in bodies),
        ),
        start=min((g.station - (g.gear.face_width or 0.0) / 2 for g in gears), default=station),
        station=station,
    )


def _gears(body: Body, hands: Mapping[Key, int]) -> list[GearPart]:
    """The helices of a body."""
    gear = body.gear
    if gear is None:
        return []
    apart, hand = ((gear.face_width or 0.0) + gear.gap) / 2, hands.get((body.name, None), gear.hand)
    sides = [("left", apart, hand), ("right", -apart, -hand)] if gear.herringbone else [(body.side, 0.0, hand)]
    return [
        GearPart(key=(body.name, side), body=body, gear=gear, hand=hands.get((body.name, side), own),
                 station=body.station - off)
        for side, off, own in sides
    ]  # fmt: skip


def _added_shaft(draft: Draft, shaft: ShaftPart) -> ShaftPart:
    """The shaft with its id, added with its place, speed, material, rim and what the rim leaves of its mass."""
    material = _material(draft, shaft.first)
    placed: dict[str, Value] = {**place(shaft.start, *shaft.first.centre)}
    if shaft.first.branch is None:
        placed |= speed_of(draft.train, shaft.first.member)
    number = draft.add("shaft", shaft.name, placed, within=draft.unit)
    draft.relate("reference", number, material)
    for body in shaft.bodies:
        if not (math.isfinite(body.mass) and math.isfinite(body.inertia)):
            where = f"stages.{body.member}" if "." in body.member else f"bodies.{body.member}"
            draft.drop(f"{where}.mass", "not in the model: the file has none either")
    left = _beside_rim(draft, shaft, number, material)
    if math.isfinite(left.polar) and max(left.mass, left.polar, left.tilt if math.isfinite(left.tilt) else 0.0) > 0:
        values = {"u_coordinate_on_shaft": shaft.station - shaft.start, **values_of("additional_mass", left)}
        draft.add("additional_mass", f"{shaft.name} mass", values, within=number)
    return replace(shaft, number=number)


def _beside_rim(draft: Draft, shaft: ShaftPart, number: int, material: int) -> Inertia:
    """Add the rim of a ring, from its pitch circle out, as a section of its shaft; mass and inertias that it leaves.

    Where these would be negative or are not known, no section is written, which is noted: all is left.
    """
    outer, gear, whole = shaft.first.outer_radius, shaft.first.gear, shaft.whole
    if outer is None or gear is None:
        return whole
    length = max(g.station for g in shaft.gears) + (gear.face_width or 0.0) / 2 - shaft.start
    density = draft.components[material - 1].attributes["density"].value
    assert isinstance(density, float)
    outside, inside = 2 * outer, 2 * gear.reference_radius
    rim = SolidSection(shaft.start - shaft.station, length, (outside, outside), (inside, inside), 1e3 * density)
    solid = inertia_of([rim])
    pairs = ((whole.mass, solid.mass), (whole.polar, solid.polar), (whole.tilt, solid.tilt))
    # beside rounding
    rest = [0.0 if abs(stated - of_rim) <= 1e-9 * stated else stated - of_rim for stated, of_rim in pairs]
    if not all(value >= 0 for value in rest):
        reason = "more than the mass and inertias stated: these alone are written"
        draft.drop(f"stages.{shaft.first.member}.rim", reason)
        return whole
    diameters = {f"{side}_diameter": d for side, d in (("outer", outside), ("inner", inside))}
    ends = {f"{side}_{end}": d for side, d in diameters.items() for end in ("begin", "end")}
    section = {"u_coordinate_on_shaft": 0.0, "length": length, **ends}
    draft.add("shaft_section", f"{shaft.name} rim", section, within=number)
    return Inertia(*rest)


def add_carriers(draft: Draft) -> None:
    """Add the planet carrier of each stage that has one."""
    for body in draft.train.bodies:
        stage = draft.stages.get(body.member.split(".")[0])
        if body.kind == "carrier" and body.member not in draft.carriers and stage is not None:
            draft.carriers[body.member] = draft.add("planet_carrier", body.member, within=stage)


def _relate_to_stage(draft: Draft, shaft: ShaftPart) -> None:
    """Relate a shaft to its stage; a planet that a carrier carries gets its pin."""
    body = shaft.first
    name = body.member.split(".")[0]
    stage = draft.stages.get(name)
    if stage is None:
        return
    if body.kind == "planet":
        draft.relate("planet_shaft", stage, shaft.number)
        if body.carried_by is not None:
            pin = draft.add("shaft", f"{shaft.name} pin", place(shaft.start, *body.centre))
            draft.relate("planet_pin", stage, pin)
            carrier = next(number for member, number in draft.carriers.items() if member.split(".")[0] == name)
            draft.relate("assembly", carrier, pin)
            draft.pins |= {planet.name: pin for planet in shaft.bodies}
    elif body.member in draft.carriers:
        draft.relate("planet_carrier_shaft", stage, shaft.number)
        draft.relate("assembly", draft.carriers[body.member], shaft.number)
    else:
        draft.relate("central_shaft", stage, shaft.number)


# joints ---------------------------------------------------------------------------------------------------------------


def add_joints(draft: Draft) -> None:
    """Add a bearing or coupling for each link of the train; rigid ones where the file would say nothing.

    These are bearings of central members without a support, and couplings of held ones that none holds.
    """
    kinematics = draft.train.kinematics
    supported: set[str] = set()
    turned: set[str] = set()
    for link in draft.train.links:
        first = draft.shafts[link.first]
        second = None if link.second is None else draft.shafts[link.second]
        outer = draft.casing if second is None else second.number
        if first.number == outer:
            continue
        inner, turn = first.number, link.stiffness[5]
        if link.kind != "coupling":
            supported.add(first.name if second is None or link.kind == "support" else second.name)
        if link.kind == "bearing":
            inner, turn = first.number if link.second is None else draft.pins[link.second], 0.0
        elif link.kind != "coupling":
            if turn > 0 and first.first.member not in kinematics.held:
                reason = "would hold the member in the file, and the model does not hold it: left free"
                draft.drop(f"{link.path}.rz", reason)
                turn = 0.0
            if turn > 0:
                turned.add(first.name)
            if first.first.centre != link.centre:
                reason = "a support off the axis: written there, read back as one on the axis"
                draft.drop(f"{link.path}.radius", reason)
        _add_joint(draft, link, inner=inner, outer=outer, turn=turn)
    for shaft in draft.central_shafts:
        member = shaft.first.member
        held = member in kinematics.held and shaft.name not in turned
        if held or shaft.name not in supported:
            along, turn = 0.0 if shaft.name in supported else math.inf, math.inf if held else 0.0
            link = Link(
                name=f"{member} {'held' if held else 'bearing'}", path=f"stages.{member}.support", kind="support",
                first=shaft.first.name, second=None, station=shaft.station,
                stiffness=(along, along, along, along, along, turn),
            )  # fmt: skip
            _add_joint(draft, link, inner=shaft.number, outer=draft.casing, turn=turn)


def _add_joint(draft: Draft, link: Link, *, inner: int, outer: int, turn: float) -> None:
    """Add one joint: a bearing where it turns freely, else a coupling."""
    if link.contacts is not None:
        force = f"contact forces of {link.contacts.load / 1e3:.4g} kN in sum, alike all round"
        draft.drop(link.path, f"law of its parts: the stiffness under {force} is written")
    elif link.rolling is not None and (curve := dict(link.curves).get(0)) is not None:
        force = f"a radial force of {curve.force[-1] / 2e3:.4g} kN"
        draft.drop(link.path, f"law of its parts: the stiffness at {force} is written")
    radial, tilt = _mean(draft, link, 0, 1, "x and y"), _mean(draft, link, 3, 4, "rx and ry")
    axial = link.stiffness[2]
    held = zip((row.id for row in STIFFNESSES), (radial, axial, tilt, turn), strict=True)
    values: dict[str, Value] = {**place(link.station, *link.centre), **dict(held)}
    bearing = turn == 0 and link.kind != "coupling"
    if bearing:
        del values["rotational_stiffness"]
        values["radial_force_absorption"] = radial > 0
        values["axial_force_absorption"] = "both_directions" if axial > 0 else "no_direction"
    joint = draft.add("concept_bearing" if bearing else "coupling", link.name, values)
    draft.relate("side", joint, inner, outer)


def _mean(draft: Draft, link: Link, a: int, b: int, names: str) -> float:
    """Stiffness across both directions, the mean where they differ: the file has one."""
    first, second = link.stiffness[a], link.stiffness[b]
    if math.isclose(first, second):
        return first
    draft.drop(link.path, f"{names} differ ({first:.6g}, {second:.6g} in SI): the file has one, their mean")
    return (first + second) / 2


# loads ----------------------------------------------------------------------------------------------------------------


def speed_of(train: Train, member: str) -> Values:
    """Speed of a central member, and whether the operation states it; nothing where speeds are not known."""
    speeds = train.kinematics.speed
    if speeds is None or member not in speeds:
        return {}
    return {"rotational_speed": float(speeds[member]), "defines_speed": member in _stated_speeds(train)}


@lru_cache(maxsize=2)
def _stated_speeds(train: Train) -> frozenset[str]:
    """Members whose speed the operation states."""
    return frozenset(at_case(read(dict(train.document)).model).operation.speed if train.document else ())


def load_of(train: Train, member: str) -> Values:
    """External torque of a central member, and whether it is stated or balances; nothing of other members."""
    kinematics = train.kinematics
    if kinematics.torque is None or member not in {*kinematics.stated, *kinematics.reacting} - {*kinematics.held}:
        return {}
    return {"torque_around_u_axis": float(kinematics.torque[member]), "defines_torque": member in kinematics.stated}


def add_loads(draft: Draft) -> None:
    """Add the external torques of members that are not held: those stated define, those that balance follow."""
    done: set[str] = set()
    for shaft in draft.central_shafts:
        member = shaft.first.member
        load = load_of(draft.train, member)
        if load and member not in done:
            done.add(member)
            place = {"transmits_torque": True, "u_coordinate_on_shaft": shaft.station - shaft.start}
            draft.add("external_load", f"{member} torque", {**load, **place}, within=shaft.number)


def gravity_of(train: Train) -> Values:
    """Gravity in the axes of the gear unit: u is z, v is -y, w is x."""
    x, y, z = train.gravity
    size = (x * x + y * y + z * z) ** 0.5
    if size == 0:
        return {"account_for_gravity": False}
    down = {f"direction_vector_gravity_{axis}": g for axis, g in zip("uvw", (z, -y, x), strict=True)}
    directions = {key: g / size + 0.0 for key, g in down.items()}
    return {"account_for_gravity": True, "gravitational_acceleration": size, **directions}


# gears ----------------------------------------------------------------------------------------------------------------


def _added_gear(draft: Draft, shaft: ShaftPart, part: GearPart, flank: Flank) -> int:
    """Add one gear, its flanks and what belongs to them; its id."""
    body, gear = part.body, part.gear
    path = f"stages.{body.member}"
    name = shaft.name if part.key[1] is None else f"{shaft.name} {part.key[1]}"
    values = {
        **place(part.station, *body.centre),
        "u_coordinate_on_shaft": part.station - shaft.start,
        **values_of("cylindrical_gear", part),
    }
    kind = "ring_gear" if gear.internal else "cylindrical_gear"
    number = draft.add(kind, name, values, within=shaft.number)
    draft.relate("reference", number, _material(draft, body))
    base = gear.nominal_base
    # the bound is far above rounding and far below any tolerance of a base circle
    if abs(gear.base_radius - base) > 1e-6 * base:
        text = f"{gear.base_radius * 1e3:.6g} mm; in the file it follows from teeth and module: {base * 1e3:.6g} mm"
        draft.drop(f"{path}.base_radius", text)
    if gear.face_width is None:
        draft.drop(f"{path}.face_width", "not in the model: the file has none either, and no mesh stiffness")
    profile = values_of("cylindrical_gear_flank", gear)
    left, right = (draft.add("cylindrical_gear_flank", f"{name} {end} flank", profile) for end in ("left", "right"))
    draft.relate("flank", number, left, right)
    _add_modifications(draft, flank, gear, path, (left, right))
    return number


def _add_modifications(draft: Draft, flank: Flank, gear: GearData, path: str, sides: tuple[int, int]) -> None:
    """Add tip relief and crowning to both flanks; the rest is noted."""
    added: list[int] = []
    if flank.tip_relief is not None:
        start = gear.tip_radius + (1 if gear.internal else -1) * flank.tip_relief.length
        relief = values_of("tip_relief", flank.tip_relief, {"tip_relief_datum_diameter": 2 * start})
        added.append(draft.add("tip_relief", "tip relief", relief))
    if flank.crown:
        added.append(draft.add("helix_crowning", "crowning", values_of("helix_crowning", flank)))
    for side in sides:
        for modification in added:
            draft.relate("reference", side, modification)
    for name in ("root_relief", "end_relief", "slope", "profile", "waves", "pitch"):
        if getattr(flank, name):
            draft.drop(f"{path}.flank.{name}", "of modifications, tip relief and crowning are carried")


def _material(draft: Draft, body: Body) -> int:
    """Id of the material of a body, added where it is a new one: its own table, else the stage's, else the file's."""
    stage, _, member = body.member.rpartition(".")
    paths = [["stages", stage, member, "material"], ["stages", stage, "material"]] if stage else []
    levels = [value_at(draft.train.document, path) for path in (*paths, ["material"])]
    values: dict[str, float] = {}
    for row in rows_of("material"):
        value = next(
            (level[row.key] for level in levels if isinstance(level, Mapping) and row.key in level), row.default
        )
        number = read_quantity(value, (QUANTITIES[row.unit],), Bounds())
        if not isinstance(number, (int, float)):
            raise ModelError("not a number", path="material", given=value)
        values[row.id] = float(number)
    stated = tuple(values.items())
    if stated not in draft.materials:
        draft.materials[stated] = draft.add("material", f"material {len(draft.materials) + 1}", values)
    return draft.materials[stated]


# meshes ---------------------------------------------------------------------------------------------------------------

_FACTOR = "mesh_load_factor_iso_6336_2019"
_STIFFNESS = rows_of("cylindrical_stage", "stiffness")[0].id


def _mesh_load_factors(draft: Draft) -> dict[str, float]:
    """K_gamma of each mesh: the largest of its pair and side, by the definition `mean-load` (docs/theory/sharing.md).

    The definition is that of ISO 6336: mean load of the heaviest branch over the nominal one, without vibration.  It is
    that of the deviations the model states; where it states none, or it has no value, nothing is returned and the
    reason is noted.
    """
    train = draft.train
    stated = bool(train.displacements) or any(error.cause != "contact" for error in train.mesh_errors)
    if not stated or not train.torques:
        why = "deviations" if not stated else "torque"
        draft.drop("K_gamma", f"the model states no {why}: {_FACTOR} is not written")
        return {}
    try:
        system = assemble(train)
        values, notes = known_mean_loads(system)
        names = [str(name) for name in faces(system.meshes).name]
    except (ModelError, ConvergenceError) as error:
        draft.drop("K_gamma", f"{_FACTOR} is not written: {error}")
        return {}
    for note in notes:
        draft.drop("K_gamma", f"{_FACTOR} is not written: {note}")
    loads = dict(zip(names, (float(v) for v in values[0]), strict=True))
    groups = grouped(((mesh.pair, mesh.side), mesh.name) for mesh in train.meshes)
    largest = {members: float(np.max([loads.get(name, math.nan) for name in members])) for members in groups.values()}
    return {name: value for members, value in largest.items() for name in members if math.isfinite(value)}


def add_meshes(draft: Draft) -> None:
    """Add each mesh as a cylindrical stage of its planetary stage, or of the unit, with the data of its gears in it."""
    bodies = {body.name: body for body in draft.train.bodies}
    factors = _mesh_load_factors(draft)
    for mesh in draft.train.meshes:
        a, b = bodies[mesh.a], bodies[mesh.b]
        gears = [draft.gears.get((body, mesh.side)) or draft.gears[(body, None)] for body in (mesh.a, mesh.b)]
        stage = draft.add("cylindrical_stage", mesh.name, _mesh(draft, mesh, a, b, factors.get(mesh.name)))
        draft.relate("assembly", draft.stages.get(a.member.split(".")[0], draft.unit), stage)
        draft.relate("stage", stage, *gears)
        driving = _driver(draft.train, mesh, a, b)
        for name, gear in zip("ab", gears, strict=True):
            values = {"is_driving_gear": driving == name} if driving else {}
            data = draft.add("cylindrical_stage_gear_data", f"{mesh.name} gear {gear}", values)
            draft.relate("stage_gear_data", stage, gear, data)


def _mesh(draft: Draft, mesh: Mesh, a: Body, b: Body, factor: float | None) -> Values:
    """Values of a mesh; factor : its K_gamma."""
    planet = a if a.branch is not None else b
    polar = math.atan2(planet.centre[1], planet.centre[0])
    # about -u, from the axis of the first gear to the second: out to the planet, or back from beyond it to the ring
    turned = ((math.pi if mesh.internal else 0.0) - polar) % math.tau
    stiffness = None
    if math.isfinite(mesh.width):
        # along the normal -> in the transverse plane (docs/conventions.md), per width
        stiffness = mesh.stiffness * math.cos(mesh.base_helix) ** 2 / mesh.width
        if mesh.table is not None:
            reason = "a table over the load: its mean tangent at the operating load is written"
            draft.drop(f"{mesh.pair}.stiffness", reason)
    else:
        draft.drop(f"{mesh.pair}.stiffness", f"{_STIFFNESS} is per face width, which the model does not give")
    given = {
        "center_distance": math.hypot(b.centre[0] - a.centre[0], b.centre[1] - a.centre[1]),
        "rotating_angle_around_neg_u_axis": turned,
        _STIFFNESS: stiffness,
        _FACTOR: factor,
    }
    return values_of("cylindrical_stage", mesh, given)


def _driver(train: Train, mesh: Mesh, a: Body, b: Body) -> str:
    """Which gear drives, "a" or "b", by the power through the mesh seen from the carrier; "" where there is none."""
    kinematics = train.kinematics
    power = (kinematics.mesh_torque or {}).get(mesh.pair, 0.0) * float(kinematics.against(b.member, b.frame))
    return "" if power == 0 or not math.isfinite(power) else "a" if power > 0 else "b"
