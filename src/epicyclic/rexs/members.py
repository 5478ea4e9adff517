"""Members of the stages of a REXS file: their parts, where they are, what they weigh.

Masses and inertias of shafts, plates and gear bodies follow from their sections, solids of revolution; they are derived
here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import ModelError
from .file import HELIX, ROW, Component, Number, rows_of, shown
from .stages import Joint, Parts, StageParts, Table, Vector, View, grouped, joints_of, planetary_stages, rigid_parts

_STEEL = ROW["density"].default
BODY_NAME = re.compile(r"[a-z][a-z0-9_-]{0,40}")
_AXIAL = math.cos(math.radians(0.1))  # axes that differ by more are not parallel


@dataclass(frozen=True, slots=True, eq=False)
class StageMember:
    """A member of a stage, equal to itself alone.

    gears : its gear, of a planet one a branch; empty for a carrier.  parts : ids of its own shafts and plates.
    centre : of its teeth or planets, of a planet that of branch 1; None where the file gives no place.
    """

    stage: StageParts
    name: str
    kind: str
    gears: tuple[int, ...]
    parts: tuple[int, ...]
    centre: Vector | None

    @property
    def full_name(self) -> str:
        """Its name with that of its stage."""
        return f"{self.stage.name}.{self.name}"

    @property
    def path(self) -> str:
        """Its table in the model file."""
        return f"stages.{self.full_name}"


@dataclass(frozen=True, slots=True, kw_only=True)
class GearUnit:
    """A gear unit, understood: stages, members, joints, the axis that becomes z.

    axis : direction of z.  still : parts that stand for the casing and what is rigid in it.
    turning : part that stands for all that are one -> central members among them.
    loose : the same -> shafts and plates that are no member's own.  free : the same -> names of those between members.
    beside : the same -> joints that end there.
    """

    view: View
    stages: tuple[StageParts, ...]
    joints: tuple[Joint, ...]
    rigid: Parts[int]
    members: tuple[StageMember, ...]
    axis: Vector
    still: frozenset[int]
    turning: Mapping[int, tuple[StageMember, ...]]
    loose: Mapping[int, Sequence[int]]
    free: Mapping[int, str]
    beside: Mapping[int, Sequence[Joint]]
    facts: Mapping[int, GearFacts]

    @property
    def central(self) -> list[StageMember]:
        """Members that are not planets."""
        return [member for member in self.members if member.kind != "planet"]

    def in_housing(self, parts: Iterable[int]) -> bool:
        """Whether one of some parts stands still with the casing."""
        return any(self.rigid.root(part) in self.still for part in parts)

    def held(self, member: StageMember) -> bool:
        """Whether a member is rigidly in the casing."""
        return self.in_housing(member.parts)

    def at(self, part: int) -> tuple[StageMember, ...]:
        """Central members that a part is rigidly joined to."""
        return self.turning.get(self.rigid.root(part), ())

    def joints_at(self, parts: Sequence[int]) -> list[Joint]:
        """Joints that end at some parts, by id."""
        roots = dict.fromkeys(self.rigid.root(part) for part in parts)
        joints = {joint.id: joint for root in roots for joint in self.beside.get(root, ())}
        return [joints[key] for key in sorted(joints)]

    def sharing(self, member: StageMember) -> tuple[StageMember, ...]:
        """Central members on the same rigid shaft, itself included."""
        sharing = dict.fromkeys(m for part in member.parts for m in self.at(part))
        return tuple(m for m in self.members if m in sharing) or (member,)


def unit_of(view: View) -> GearUnit:
    """The gear unit of a file.

    Raises
    ------
    ModelError : as of `planetary_stages`, gears without teeth or module, axes that are not parallel.
    """
    stages = planetary_stages(view)
    joints = tuple(joints_of(view))
    rigid = rigid_parts(view, joints)
    members = tuple(member for stage in stages for member in _members(view, stage))
    facts = {gear: gear_facts(view, gear) for member in members for gear in member.gears}
    axis = _axis(view, members)
    owned = {part for member in members for part in member.parts}
    own = [(rigid.root(part), m) for m in members if m.kind != "planet" for part in m.parts]
    loose = [(rigid.root(part.id), part.id) for part in view.of_type("shaft", "side_plate") if part.id not in owned]
    unit = GearUnit(
        view=view,
        stages=stages,
        joints=joints,
        rigid=rigid,
        members=members,
        axis=axis,
        still=frozenset(rigid.root(component.id) for component in view.of_type("gear_casing")),
        turning=grouped(own),
        loose=grouped(loose),
        free={},
        beside=grouped((rigid.root(part), joint) for joint in joints for part in joint.ends),
        facts=facts,
    )
    return replace(unit, free=_free_bodies(unit))


def _free_bodies(unit: GearUnit) -> dict[int, str]:
    """Names of the shafts between members: those that turn with a member by couplings of finite stiffness."""
    free: dict[int, str] = {}
    taken = {"housing", *(stage.name for stage in unit.stages)}
    reached = list(unit.turning)
    while reached:
        here = reached.pop()
        for joint in unit.beside.get(here, ()):
            inner, outer = (unit.rigid.root(part) for part in joint.ends)
            root = outer if inner == here else inner
            known = root in free or root in unit.turning or root in unit.still
            if not joint.holds_turn or joint.rigid or known or root not in unit.loose:
                continue
            name = unit.view.components[unit.loose[root][0]].name
            if not BODY_NAME.fullmatch(name) or name in taken:
                name = f"shaft{unit.loose[root][0]}"
            taken.add(name)
            free[root] = name
            reached.append(root)
    return free


def _members(view: View, stage: StageParts) -> list[StageMember]:
    """Members of one stage."""
    shafts = tuple(branch.shaft for branch in stage.branches)
    members = []
    for name, gear in stage.gears.items():
        gears: tuple[int, ...] = (gear,)
        shaft = view.shaft_of(gear)
        parts: tuple[int, ...] = (gear,) if shaft is None else (shaft, gear)
        if name in stage.planets:
            gears, parts = tuple(branch.gears[stage.planets.index(name)] for branch in stage.branches), shafts
            shaft = shafts[0]
        # its centre, between the halves of a herringbone gear
        centre, twin = view.gear_place(gear, shaft), stage.twins.get(gear)
        other = None if twin is None else view.gear_place(twin, shaft)
        if centre is not None and other is not None:
            centre = (centre + other) / 2
        members.append(StageMember(stage, name, name.rstrip("0123456789"), gears, parts, centre))
    carrier = () if stage.carrier is None else (stage.carrier, *view.parts(stage.carrier, "shaft", "side_plate"))
    parts = tuple(dict.fromkeys((*view.joined("planet_carrier_shaft", stage.id), *carrier)))
    if parts:
        members.append(StageMember(stage, "carrier", "carrier", (), parts, members[len(stage.central)].centre))
    return members


def _axis(view: View, members: Sequence[StageMember]) -> Vector:
    """Direction of z: the u axis of the first gear. Raises ModelError where another axis is not parallel to it."""
    parts = (p for m in members for p in (*m.gears, *(p for p in m.parts if view.components[p].type == "shaft")))
    frames = {part: frame for part in parts if (frame := view.frame(part)) is not None}
    axis = next((frame.u for frame in frames.values()), np.array([1.0, 0.0, 0.0]))
    for part, frame in frames.items():
        if abs(axis @ frame.u) < _AXIAL:
            direction = [round(x, 6) for x in frame.u.tolist()]
            path = f"component {view.label(part)}, u_axis_vector"
            raise ModelError("an axis that is not parallel to that of the train", path=path, given=direction)
    return axis


# gears ----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class GearFacts:
    """What other parts need to know of a gear.

    id : of the component.  teeth : positive.  module : normal [m].  helix : signed, right positive [rad].
    width : face width [m], nan where not given.  tip : tip diameter [m], nan where not given.  internal : a ring.
    """

    id: int
    teeth: int
    module: float
    helix: float
    width: float
    tip: float
    internal: bool

    @property
    def reference(self) -> float:
        """Reference diameter [m]."""
        return self.module * self.teeth / math.cos(self.helix)


def gear_facts(view: View, gear: int) -> GearFacts:
    """What a gear is. Raises ModelError where teeth or module are missing or none that a gear has."""
    component = view.components[gear]
    where = f"component {view.label(gear)}"
    teeth = view.value(gear, "number_of_teeth")
    if isinstance(teeth, bool) or not isinstance(teeth, (int, float)) or not 3 <= abs(teeth) <= 5000 or teeth % 1:
        problem = "missing" if teeth is None else "not a number of teeth"
        raise ModelError(problem, path=f"{where}, number_of_teeth", given=teeth, allowed="a whole number, 3 to 5000")
    if teeth < 0 and component.type != "ring_gear":  # a sign that some programs give internal teeth, and no others
        allowed = "a positive number, or a component of type ring_gear"
        raise ModelError("negative, of external teeth", path=f"{where}, number_of_teeth", given=teeth, allowed=allowed)
    module = normal_module(view, gear)
    helix = view.number(gear, HELIX)
    if helix is not None and not abs(helix.si) < math.pi / 3:
        raise ModelError("out of range", path=f"{where}, {HELIX}", given=helix.text, allowed="-60 deg to 60 deg")
    return GearFacts(
        id=gear,
        teeth=abs(int(teeth)),
        module=module.si,
        helix=helix.si if helix is not None else 0.0,
        width=view.si(gear, "face_width", math.nan),
        tip=abs(view.si(gear, "tip_diameter", math.nan)),
        internal=component.type == "ring_gear",
    )


def normal_module(view: View, gear: int) -> Number:
    """Normal module of a gear, from the transverse one where only that is given."""
    normal = view.number(gear, "normal_module")
    path = f"component {view.label(gear)}, normal_module"
    if normal is None:
        transverse = view.number(gear, "transverse_module")
        if transverse is None:
            raise ModelError("missing", path=path, allowed="a module in mm")
        value = transverse.si * math.cos(view.si(gear, HELIX))
        normal = Number(value, f"{value!r} m")
    if not 1e-5 <= normal.si <= 10:
        raise ModelError("out of range", path=path, given=normal.text, allowed="0.01 mm to 10 m")
    return normal


def material_of(view: View, component: int) -> Component | None:
    """Material of a component, None where it refers to none."""
    return next((material for material in view.referenced(component) if material.type == "material"), None)


# masses ---------------------------------------------------------------------------------------------------------------


def mass_table(unit: GearUnit, member: StageMember, pin_radius: float) -> Table:
    """Mass and inertias of a member from gear body and sections of shafts and plates; bore or outer diameter.

    Nothing where the file has no sections: the model then takes the gear as solid.

    pin_radius : distance of the planet axes from that of the stage [m].
    """
    own = list(member.parts)
    if not unit.held(member) and unit.sharing(member)[0] == member:  # and what is rigidly joined and no member's own
        own += dict.fromkeys(other for part in member.parts for other in unit.loose.get(unit.rigid.root(part), ()))
    parts = [part for part in own if unit.view.components[part].type in ("shaft", "side_plate")]
    if member.kind == "planet":
        parts = [member.parts[0]]
        for shaft in member.parts[1:]:
            if _stretches(unit, shaft) != _stretches(unit, parts[0]):
                reason = f"sections differ from those of {parts[0]}, which count for all planets"
                unit.view.lose(shaft, "shaft_section", reason)
    sections = [section for part in parts for section in _sections(unit, part, member.centre, member)]
    extra = _additional(unit.view, parts)
    table: Table = {}
    if member.kind == "carrier":
        if not sections:
            return _cheeks(unit, member, pin_radius)
    else:
        body, table = _gear_body(unit, member, sections)
        if not sections and not extra.mass:
            return table
        if sections:  # a shaft without sections is lumped: its additional masses are all of it
            sections = [*sections, *body]
    mass, stated = _stated(sections, extra)
    if mass > 0:
        table |= stated
        ids = ", ".join(map(str, parts))
        name, words = ("sections", "sections") if sections else ("additional_mass", "additional masses")
        unit.view.read(parts[0], name, f"{member.path}.mass", f"{mass:.6g} kg, from the {words} of {ids}")
    return table


def body_tables(unit: GearUnit) -> Table:
    """Shafts between members as bodies of their own, with mass and inertia."""
    tables: Table = {}
    for root, name in unit.free.items():
        parts = unit.loose[root]
        centre = unit.view.place(parts[0])
        sections = [section for part in parts for section in _sections(unit, part, centre)]
        mass, tables[name] = _stated(sections, _additional(unit.view, parts))
        source = "sections" if sections else "additional_mass"
        for part in parts:
            unit.view.read(part, source, f"bodies.{name}", f"{mass:.6g} kg, a body between members")
        for joint in unit.joints_at(parts):
            if joint.bearing:
                unit.view.lose(joint.id, "stiffness", f"bearings of a shaft between members, {name}, are not read")
    return tables


def is_lumped(unit: GearUnit, shaft: int) -> bool:
    """Whether a shaft has no sections but additional masses, which are then all of its mass."""
    return not _stretches(unit, shaft) and bool(unit.view.parts(shaft, "additional_mass"))


def _density(unit: GearUnit, part: int) -> float:
    """Density of a part [kg/m^3], that of steel where its material does not say it."""
    material = material_of(unit.view, part)
    density = None if material is None else unit.view.number(material.id, "density")
    if density is None or not density.si > 0:
        unit.view.assume(part, "density", "", f"no density given: steel, {_STEEL:g} kg/m^3")
        return _STEEL
    return density.si


def _sections(
    unit: GearUnit, part: int, centre: Vector | None, member: StageMember | None = None
) -> list[SolidSection]:
    """Sections of a shaft or plate about the axis of what it belongs to; member : whose it is, of none a body."""
    stretches = _stretches(unit, part)
    if not stretches:
        return []
    frame = unit.view.frame(part)
    off = 0.0
    if frame and centre is not None and member and member.kind == "carrier":  # pins stand off the axis of the stage
        middle = unit.view.gear_place(next(iter(member.stage.central.values())))
        if middle is not None:
            apart = frame.place - middle
            off = math.sqrt(max(float(apart @ apart - (apart @ unit.axis) ** 2), 0.0))
    density = _density(unit, part)
    forward = frame is None or frame.u @ unit.axis >= 0
    if frame is not None and centre is not None:
        base = float((frame.place - centre) @ unit.axis)
    else:  # nowhere: its middle at the centre of the member
        middle_of_all = (min(s.start for s in stretches) + max(s.start + s.length for s in stretches)) / 2
        base = -middle_of_all if forward else middle_of_all
    stretches = [replace(stretch, density=density, off_axis=off) for stretch in stretches]
    if forward:
        return [replace(s, start=base + s.start) for s in stretches]
    return [replace(s, start=base - s.start - s.length, outer=s.outer[::-1], inner=s.inner[::-1]) for s in stretches]


def _stretches(unit: GearUnit, part: int) -> list[SolidSection]:
    """Sections of a shaft along its u axis, each behind the one before where its place is not given; or a plate."""
    view = unit.view
    plate = view.components[part].type == "side_plate"
    stretches: list[SolidSection] = []
    end = 0.0
    for source in [part] if plate else view.parts(part, "shaft_section"):
        length = view.si(source, "length")
        start = view.number(source, "u_coordinate_on_shaft")
        outer, inner = (_diameters(view, source, f"{side}_diameter", plate) for side in ("outer", "inner"))
        if length <= 0 or outer is None:
            if view.components[source].attributes:
                view.lose(source, "length, outer_diameter", "a section without length or diameter has no mass")
            continue
        at = start.si if start is not None else end
        end = at + length
        stretches.append(SolidSection(at, length, outer, inner or (0.0, 0.0), 0.0))
    return stretches


def _diameters(view: View, source: int, name: str, plate: bool) -> tuple[float, float] | None:
    """Diameters at both ends [m]; the one that is given where only one is."""
    diameters = [view.number(source, end) for end in ([name] if plate else [f"{name}_begin", f"{name}_end"])]
    values = [abs(number.si) for number in diameters if number is not None]
    return (values[0], values[-1]) if values else None


def _gear_body(
    unit: GearUnit, member: StageMember, sections: Sequence[SolidSection]
) -> tuple[list[SolidSection], Table]:
    """The gear between its shaft and its reference circle, and its bore or outer diameter."""
    facts = unit.facts[member.gears[0]]
    count = 2 if facts.id in member.stage.twins else 1
    under = [s for s in sections if s.start <= 1e-9 and s.start + s.length >= -1e-9]
    table: Table = {}
    width = facts.width * count
    if facts.internal:
        bound = min((min(s.inner) for s in under), default=0.0)
        outside = max((max(s.outer) for s in under), default=0.0)
        if outside > facts.reference:
            table["outer_diameter"] = f"{outside * 1e3:.9g} mm"
        else:
            table["rim"] = f"{3.5 * facts.module * 1e3:.9g} mm"
            reason = "no outer diameter in the file: a rim of 3.5 modules, as usual"
            unit.view.assume(facts.id, "rim", f"{member.path}.rim", reason)
        outer, inner = bound, facts.reference
    else:
        outer, inner = facts.reference, max((max(s.outer) for s in under), default=0.0)
        bore = min((min(s.inner) for s in under), default=0.0)
        if 0 < bore < facts.reference:
            table["bore"] = f"{bore * 1e3:.9g} mm"
    if not outer > inner or math.isnan(width):
        return [], table
    return [SolidSection(-width / 2, width, (outer, outer), (inner, inner), _density(unit, facts.id))], table


def _additional(view: View, shafts: Iterable[int]) -> Inertia:
    """Additional masses on shafts, together."""
    total = Inertia(0.0, 0.0, 0.0)
    for part in (part for shaft in shafts for part in view.parts(shaft, "additional_mass")):
        mass, polar, tilt = (
            view.mean(part, (row for row in rows_of("additional_mass") if row.of == of)) or 0.0
            for of in ("mass", "polar", "tilt")
        )
        total += Inertia(mass, polar, tilt)
    return total


def _cheeks(unit: GearUnit, member: StageMember, pin_radius: float) -> Table:
    """A carrier whose file has no plates: two steel discs of a quarter of the face width to beyond the pins."""
    extra = _additional(unit.view, member.parts)
    if extra.mass:
        return _stated([], extra)[1]
    planet = unit.facts[member.stage.branches[0].gears[0]]
    width = planet.width if not math.isnan(planet.width) else 10 * planet.module
    outer = 2 * pin_radius + planet.reference / 2
    reason = "no plates in the file: two steel discs of a quarter of the face width, to half a planet beyond the pins"
    for key in ("mass", "inertia", "tilt_inertia"):
        unit.view.assume(member.parts[0], key, f"{member.path}.{key}", reason)
    discs = [
        SolidSection(start, width / 4, (outer, outer), (0.0, 0.0), _STEEL) for start in (width / 2, -3 * width / 4)
    ]
    return _stated(discs, extra)[1]


def _stated(sections: Sequence[SolidSection], extra: Inertia) -> tuple[float, Table]:
    """Mass [kg] of sections and additional masses; with the inertias as texts of a model file.

    Nine digits of what is integrated, all digits of what additional masses alone state.
    """
    total = inertia_of(sections) + extra
    write = (lambda value: f"{value:.9g}") if sections else shown
    table: Table = {"mass": f"{write(total.mass)} kg", "inertia": f"{write(total.polar)} kg m^2"}
    # not stated: the model asks for it where a member tilts
    if sections or extra.tilt:
        table["tilt_inertia"] = f"{write(total.tilt)} kg m^2"
    return total.mass, table


# solids of revolution -------------------------------------------------------------------------------------------------

# Gauss points and weights of order 3 on [0, 1]: exact for polynomials of degree 5; those here have degree 4
_POINTS = tuple((0.5 + 0.5 * x, w / 18) for x, w in ((-math.sqrt(0.6), 5), (0.0, 8), (math.sqrt(0.6), 5)))


@dataclass(frozen=True, slots=True)
class SolidSection:
    """A hollow cone about an axis parallel to z.

    start, length : along z from the centre of the member [m].  outer, inner : diameters at both ends [m].
    density : [kg/m^3].  off_axis : distance of its axis from that of the member [m].
    """

    start: float
    length: float
    outer: tuple[float, float]
    inner: tuple[float, float]
    density: float
    off_axis: float = 0.0


@dataclass(frozen=True, slots=True)
class Inertia:
    """mass [kg]; about z and about a diameter through the centre of the member [kg m^2]."""

    mass: float
    polar: float
    tilt: float

    def __add__(self, other: Inertia) -> Inertia:
        return Inertia(self.mass + other.mass, self.polar + other.polar, self.tilt + other.tilt)


def inertia_of(sections: Iterable[SolidSection]) -> Inertia:
    """Mass and inertias of sections together; those off the axis stand evenly around it."""
    total = Inertia(0.0, 0.0, 0.0)
    for section in sections:
        for share, weight in _POINTS:
            z = section.start + share * section.length
            outer, inner = ((a + (b - a) * share) / 2 for a, b in (section.outer, section.inner))
            slab = section.density * section.length * weight * math.pi
            area, second = outer**2 - inner**2, (outer**4 - inner**4) / 2
            # evenly around the axis, each stands on average for half of its distance squared
            tilt = second / 2 + area * (z**2 + section.off_axis**2 / 2)
            total += Inertia(slab * area, slab * (second + area * section.off_axis**2), slab * tilt)
    return total
