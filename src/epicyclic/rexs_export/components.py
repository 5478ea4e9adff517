"""A train as components of a REXS file: shafts, gears, what holds and drives them, meshes.

One shaft stands for bodies that turn together, with its gears, mass and place.  Supports, bearings and couplings are
bearings and couplings of the file; speeds and external torques stand on the shafts.

Gears: teeth, diameters, flanks with their modifications, material.  Meshes, as cylindrical stages: places, stiffness
per face width, K_gamma, backlash.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..document.tables import value_at
from ..document.units import Bounds, read_quantity
from ..errors import ConvergenceError, ModelError
from ..questions.sharing.definitions import known_mean_loads
from ..rexs.file import Value
from ..rexs.members import Inertia, SolidSection, inertia_of
from ..system.assembly import assemble
from ..system.system import faces
from ..teeth.flank import PLAIN, Flank
from ..train.bodies import Body, GearData, Link, Mesh
from ..train.train import Train
from .draft import RIGID, Attributes, Draft, GearPart, Key, ShaftPart, in_unit, middle, place

# shafts ---------------------------------------------------------------------------------------------------------------


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
    centre, first = middle(bodies), bodies[0]
    name = first.member if first.branch is None else f"{first.member} {first.branch}"
    ends = [gear.station - ((gear.body.gear.face_width if gear.body.gear else None) or 0.0) / 2 for gear in gears]
    return ShaftPart(
        name=name,
        bodies=bodies,
        gears=gears,
        mass=math.fsum(body.mass for body in bodies),
        inertia=math.fsum(body.inertia for body in bodies),
        tilt_inertia=math.fsum(b.tilt_inertia + b.mass * (b.station - centre) ** 2 for b in bodies),
        start=min(ends, default=centre),
    )


def add_carriers(train: Train, draft: Draft, stages: Mapping[str, int]) -> dict[str, int]:
    """Add the planet carrier of each stage that has one; by member."""
    found: dict[str, int] = {}
    for body in train.bodies:
        stage = body.member.split(".")[0]
        if body.kind == "carrier" and body.member not in found and stage in stages:
            found[body.member] = draft.add("planet_carrier", body.member)
            draft.relate("assembly", assembly=stages[stage], part=found[body.member])
    return found


def add_shaft(train: Train, draft: Draft, shaft: ShaftPart, unit: int, material: int) -> int:
    """Add a shaft with its place, speed, material, rim and what the rim leaves of its mass; its id."""
    attributes: Attributes = {**place(shaft.start, *shaft.first.centre), **speed_of(train, shaft)}
    number = draft.add("shaft", shaft.name, attributes)
    draft.relate("assembly", assembly=unit, part=number)
    draft.relate("reference", origin=number, referenced=material)
    for body in shaft.bodies:
        if not (math.isfinite(body.mass) and math.isfinite(body.inertia)):
            where = f"stages.{body.member}" if "." in body.member else f"bodies.{body.member}"
            draft.drop(f"{where}.mass", "not in the model: the file has none either")
    whole = Inertia(shaft.mass, shaft.inertia, shaft.tilt_inertia)
    left = _beside_rim(draft, shaft, number, material, whole)
    tilt = left.tilt if math.isfinite(left.tilt) else None
    if math.isfinite(left.polar) and max(left.mass, left.polar, tilt or 0.0) > 0:
        mass: Attributes = {
            "u_coordinate_on_shaft": (in_unit(shaft.station - shaft.start, 1e-3), "mm"),
            "mass": (left.mass, "kg"),
            "moment_of_inertia_u_axis": (left.polar, "kg m^2"),
            "moment_of_inertia_v_axis": (tilt, "kg m^2"),
            "moment_of_inertia_w_axis": (tilt, "kg m^2"),
        }
        draft.relate("assembly", assembly=number, part=draft.add("additional_mass", f"{shaft.name} mass", mass))
    return number


def _beside_rim(draft: Draft, shaft: ShaftPart, number: int, material: int, whole: Inertia) -> Inertia:
    """Add the rim of a ring, from its pitch circle out, as a section of its shaft; mass and inertias that it leaves.

    Where these would be negative or are not known, no section is written, which is noted: all is left.
    """
    outer, gear = shaft.first.outer_radius, shaft.first.gear
    if outer is None or gear is None:
        return whole
    length = max(g.station for g in shaft.gears) + (gear.face_width or 0.0) / 2 - shaft.start
    density = draft.components[material - 1].attributes["density"].value
    assert isinstance(density, float)
    diameters = (2 * outer, 2 * outer), (2 * gear.reference_radius, 2 * gear.reference_radius)
    solid = inertia_of([SolidSection(shaft.start - shaft.station, length, *diameters, 1e3 * density)])
    pairs = ((whole.mass, solid.mass), (whole.polar, solid.polar), (whole.tilt, solid.tilt))
    rest = [0.0 if abs(all_ - own) <= 1e-9 * all_ else all_ - own for all_, own in pairs]  # beside rounding
    if not all(value >= 0 for value in rest):
        draft.drop(
            f"stages.{shaft.first.member}.rim", "more than the mass and inertias stated: these alone are written"
        )
        return whole
    section: Attributes = {"u_coordinate_on_shaft": (0.0, "mm"), "length": (in_unit(length, 1e-3), "mm")}
    for name, (diameter, _) in zip(("outer_diameter", "inner_diameter"), diameters, strict=True):
        section = {**section, **{f"{name}_{end}": (in_unit(diameter, 1e-3), "mm") for end in ("begin", "end")}}
    draft.relate("assembly", assembly=number, part=draft.add("shaft_section", f"{shaft.name} rim", section))
    return Inertia(*rest)


def add_to_stage(
    draft: Draft,
    shaft: ShaftPart,
    number: int,
    stages: Mapping[str, int],
    carriers: Mapping[str, int],
    pins: dict[str, int],
) -> None:
    """Relate a shaft to its stage; a planet that a carrier carries gets its pin."""
    body = shaft.first
    stage = stages.get(body.member.split(".")[0])
    if stage is None:
        return
    if body.kind == "planet":
        draft.relate("planet_shaft", planetary_stage=stage, shaft=number)
        if body.carried_by is not None:
            pin = draft.add("shaft", f"{shaft.name} pin", place(shaft.start, *body.centre))
            draft.relate("planet_pin", planetary_stage=stage, shaft=pin)
            name = body.member.split(".")[0]
            carrier = next(number for member, number in carriers.items() if member.split(".")[0] == name)
            draft.relate("assembly", assembly=carrier, part=pin)
            pins |= {one.name: pin for one in shaft.bodies}
    elif body.member in carriers:
        draft.relate("planet_carrier_shaft", planetary_stage=stage, shaft=number)
        draft.relate("assembly", assembly=carriers[body.member], part=number)
    else:
        draft.relate("central_shaft", planetary_stage=stage, shaft=number)


# joints ---------------------------------------------------------------------------------------------------------------

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


# speeds and loads -----------------------------------------------------------------------------------------------------


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


# gears ----------------------------------------------------------------------------------------------------------------

DEG = math.pi / 180
_MATERIAL = (
    ("density", "density", "density", 1e3, "kg / dm^3", 7850.0),
    ("youngs_modulus", "elastic_modulus", "pressure", 1e6, "N / mm^2", 206e9),
    ("poisson_ratio", "poisson_ratio", "ratio", 1.0, "none", 0.3),
)


def add_gears(
    train: Train, draft: Draft, shaft: ShaftPart, number: int, materials: dict[object, int]
) -> dict[Key, int]:
    """Add the gears of a shaft with flanks and material; their ids."""
    flanks = _flanks(train)
    return {gear.key: _gear(train, draft, shaft, gear, number, flanks, materials) for gear in shaft.gears}


def _flanks(train: Train) -> Mapping[str, Flank]:
    """Micro-geometry of each body that has some."""
    found: dict[str, Flank] = {}
    for mesh in train.meshes:
        if mesh.teeth is not None:
            for body, flank in ((mesh.a, mesh.teeth.flank_a), (mesh.b, mesh.teeth.flank_b)):
                if flank != PLAIN:
                    found.setdefault(body, flank)
    return found


def _gear(
    train: Train,
    draft: Draft,
    shaft: ShaftPart,
    part: GearPart,
    number: int,
    flanks: Mapping[str, Flank],
    materials: dict[object, int],
) -> int:
    """Add one gear, its flanks and what belongs to them; its id."""
    body, gear = part.body, part.body.gear
    assert gear is not None
    path = f"stages.{body.member}"
    side = "" if part.key[1] is None else f" {part.key[1]}"
    width = None if gear.face_width is None else in_unit(gear.face_width, 1e-3)
    attributes: Attributes = {
        **place(part.station, *body.centre),
        "u_coordinate_on_shaft": (in_unit(part.station - shaft.start, 1e-3), "mm"),
        "number_of_teeth": (gear.teeth, "none"),
        "normal_module": (in_unit(gear.module, 1e-3), "mm"),
        "helix_angle_reference_diameter": (in_unit(part.hand * gear.helix_angle, DEG), "deg"),
        "face_width": (width, "mm"),
        "tip_diameter": (in_unit(2 * gear.tip_radius, 1e-3), "mm"),
        "root_diameter": (in_unit(2 * gear.root_radius, 1e-3), "mm"),
    }
    kind = "ring_gear" if gear.internal else "cylindrical_gear"
    found = draft.add(kind, f"{shaft.name}{side}", attributes)
    draft.relate("assembly", assembly=number, part=found)
    draft.relate("reference", origin=found, referenced=material_of(train, draft, body, materials))
    _check_form(draft, gear, path)
    profile: Attributes = {
        "normal_pressure_angle": (in_unit(gear.pressure_angle, DEG), "deg"),
        "addendum_modification_coefficient": (gear.profile_shift, "none"),
    }
    sides = [
        draft.add("cylindrical_gear_flank", f"{shaft.name}{side} {end} flank", profile) for end in ("left", "right")
    ]
    draft.relate("flank", gear=found, left=sides[0], right=sides[1])
    _modifications(draft, flanks.get(body.name, PLAIN), gear, path, sides)
    return found


def _check_form(draft: Draft, gear: GearData, path: str) -> None:
    """Note a base radius that teeth, module and angles do not give, and a face width that is missing."""
    transverse = math.atan(math.tan(gear.pressure_angle) / math.cos(gear.helix_angle))
    base = gear.module * gear.teeth / math.cos(gear.helix_angle) * math.cos(transverse) / 2
    # the bound is far above rounding and far below any tolerance of a base circle
    if abs(gear.base_radius - base) > 1e-6 * base:
        text = f"{gear.base_radius * 1e3:.6g} mm; in the file it follows from teeth and module: {base * 1e3:.6g} mm"
        draft.drop(f"{path}.base_radius", text)
    if gear.face_width is None:
        draft.drop(f"{path}.face_width", "not in the model: the file has none either, and no mesh stiffness")


def _modifications(draft: Draft, flank: Flank, gear: GearData, path: str, sides: list[int]) -> None:
    """Add tip relief and crowning to both flanks; the rest is noted."""
    added: list[int] = []
    if flank.tip_relief is not None:
        inward = 1 if gear.internal else -1
        attributes: Attributes = {
            "tip_relief_depth": (in_unit(flank.tip_relief.amount, 1e-6), "mum"),
            "tip_relief_datum_diameter": (
                in_unit(2 * (gear.tip_radius + inward * flank.tip_relief.length), 1e-3),
                "mm",
            ),
            "shape_of_relief": (flank.tip_relief.shape, "none"),
        }
        added.append(draft.add("tip_relief", "tip relief", attributes))
    if flank.crown:
        crown: Attributes = {
            f"helix_crowning_amount_{end}_face": (in_unit(flank.crown, 1e-6), "mum") for end in ("datum", "non_datum")
        }
        added.append(draft.add("helix_crowning", "crowning", crown))
    for side in sides:
        for one in added:
            draft.relate("reference", origin=side, referenced=one)
    for name in ("root_relief", "end_relief", "slope", "profile", "waves", "pitch"):
        if getattr(flank, name):
            draft.drop(f"{path}.flank.{name}", "of modifications, tip relief and crowning are carried")


def material_of(train: Train, draft: Draft, body: Body, materials: dict[object, int]) -> int:
    """Id of the material of a body, added where it is a new one: its own table, else the stage's, else the file's."""
    stage, _, member = body.member.rpartition(".")
    stages = _table(train.document.get("stages"))
    levels = [_table(train.document.get("material"))]
    if stage:
        levels = [
            _table(_table(_table(stages.get(stage)).get(member)).get("material")),
            _table(_table(stages.get(stage)).get("material")),
            *levels,
        ]
    values: dict[str, tuple[float, str]] = {}
    for key, name, kind, factor, unit, default in _MATERIAL:
        given = next((level[key] for level in levels if key in level), default)
        values[name] = (in_unit(_number(given, kind), factor), unit)
    if (found := tuple(values.items())) not in materials:
        materials[found] = draft.add("material", f"material {len(materials) + 1}", values)
    return materials[found]


def _table(value: object) -> Mapping[str, object]:
    return value if isinstance(value, Mapping) else {}


def _number(value: object, kind: str) -> float:
    """A number of the document in SI. Raises ModelError where it is none, which the document has checked before."""
    read = read_quantity(value, (kind,), Bounds())
    if not isinstance(read, (int, float)):
        raise ModelError("not a number", path="material", given=value)
    return float(read)


# meshes ---------------------------------------------------------------------------------------------------------------

_FACTOR = "mesh_load_factor_iso_6336_2019"
_STIFFNESS = "mean_mesh_stiffness_for_transverse_load_iso_6336_2019"


def mesh_load_factors(train: Train, draft: Draft) -> dict[str, float]:
    """K_gamma of each mesh: the largest of its pair and side, by the definition `mean-load` (docs/theory/sharing.md).

    The definition is that of ISO 6336: mean load of the heaviest branch over the nominal one, without vibration.  It is
    that of the deviations the model states; where it states none, or it has no value, nothing is returned and the
    reason is noted.
    """
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
    found = dict(zip(names, (float(v) for v in values[0]), strict=True))
    groups: dict[tuple[str, str | None], list[str]] = {}
    for mesh in train.meshes:
        groups.setdefault((mesh.pair, mesh.side), []).append(mesh.name)
    factors: dict[str, float] = {}
    for members in groups.values():
        largest = float(np.max([found.get(name, math.nan) for name in members]))
        if math.isfinite(largest):
            factors |= dict.fromkeys(members, largest)
    return factors


def add_meshes(
    train: Train,
    draft: Draft,
    stages: Mapping[str, int],
    unit: int,
    gears: Mapping[Key, int],
    factors: Mapping[str, float],
) -> None:
    """Add each mesh as a cylindrical stage of its planetary stage, or of the unit, with the data of its gears in it.

    stages : stage -> id of the planetary stage.  unit : id of the gear unit.  gears : ids of the helices.
    factors : K_gamma by mesh.
    """
    bodies = {body.name: body for body in train.bodies}
    for mesh in train.meshes:
        a, b = bodies[mesh.a], bodies[mesh.b]
        ends = [_helix(gears, mesh.a, mesh.side), _helix(gears, mesh.b, mesh.side)]
        found = draft.add("cylindrical_stage", mesh.name, _attributes(draft, mesh, a, b, factors))
        draft.relate("assembly", assembly=stages.get(a.member.split(".")[0], unit), part=found)
        draft.relate("stage", stage=found, gear_1=ends[0], gear_2=ends[1])
        driving = _driver(train, mesh, a, b)
        for end, drives in zip(ends, (driving == "a", driving == "b"), strict=True):
            attributes: Attributes = {"is_driving_gear": (drives, "none")} if driving else {}
            data = draft.add("cylindrical_stage_gear_data", f"{mesh.name} gear {end}", attributes)
            draft.relate("stage_gear_data", stage=found, gear=end, stage_gear_data=data)


def _helix(gears: Mapping[Key, int], body: str, side: str | None) -> int:
    """Id of the helix of a body on a side."""
    return gears[(body, side)] if (body, side) in gears else gears[(body, None)]


def _attributes(draft: Draft, mesh: Mesh, a: Body, b: Body, factors: Mapping[str, float]) -> Attributes:
    """Attributes of a mesh."""
    distance = math.hypot(b.centre[0] - a.centre[0], b.centre[1] - a.centre[1])
    planet = a if a.branch is not None else b
    polar = math.degrees(math.atan2(planet.centre[1], planet.centre[0]))
    # about -u, from the axis of the first gear to the second: out to the planet, or back from beyond it to the ring
    turned = ((180.0 if mesh.internal else 0.0) - polar) % 360
    attributes: Attributes = {
        "center_distance": (in_unit(distance, 1e-3), "mm"),
        "rotating_angle_around_neg_u_axis": (in_unit(turned, 1.0), "deg"),
        "working_transverse_pressure_angle": (in_unit(mesh.pressure_angle, DEG), "deg"),
    }
    if math.isfinite(mesh.contact_ratio):
        attributes = {**attributes, "transverse_contact_ratio": (mesh.contact_ratio, "none")}
    if math.isfinite(mesh.overlap_ratio):
        attributes = {**attributes, "overlap_ratio": (mesh.overlap_ratio, "none")}
    if math.isfinite(mesh.width):
        # along the normal -> in the transverse plane (docs/conventions.md), per width
        per_width = mesh.stiffness * math.cos(mesh.base_helix) ** 2 / mesh.width
        attributes = {
            **attributes,
            "common_face_width": (in_unit(mesh.width, 1e-3), "mm"),
            _STIFFNESS: (in_unit(per_width, 1e9), "N / (mm mum)"),
        }
        if mesh.table is not None:
            draft.drop(
                f"{mesh.pair}.stiffness", "a table over the load: its mean tangent at the operating load is written"
            )
    else:
        draft.drop(f"{mesh.pair}.stiffness", f"{_STIFFNESS} is per face width, which the model does not give")
    if math.isfinite(mesh.backlash):
        gap = in_unit(mesh.backlash, 1e-3)
        limits: Attributes = {"minimum_normal_backlash": (gap, "mm"), "maximum_normal_backlash": (gap, "mm")}
        attributes = {**attributes, **limits}
    if mesh.name in factors:
        attributes = {**attributes, _FACTOR: (factors[mesh.name], "none")}
    return attributes


def _driver(train: Train, mesh: Mesh, a: Body, b: Body) -> str:
    """Which gear drives, "a" or "b", by the power through the mesh seen from the carrier; "" where there is none."""
    kinematics = train.kinematics
    if kinematics.speed is None or kinematics.mesh_torque is None or kinematics.frame_speed is None:
        return ""
    torque = kinematics.mesh_torque.get(mesh.pair, 0.0)
    power = torque * float(kinematics.speed[b.member] - kinematics.frame_speed[b.frame])
    return "" if power == 0 or not math.isfinite(power) else "a" if power > 0 else "b"
