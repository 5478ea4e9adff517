"""Gears and meshes of a train as components of a REXS file.

Gears: teeth, diameters, flanks with their modifications, material.  Meshes, as cylindrical stages: places, stiffness
per face width, K_gamma, backlash.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..document.units import Bounds, read_quantity
from ..errors import ConvergenceError, ModelError
from ..questions.sharing.definitions import known_mean_loads
from ..system.assembly import assemble
from ..system.system import faces
from ..teeth.flank import PLAIN, Flank
from ..train.bodies import Body, GearData, Mesh
from ..train.train import Train
from .draft import Attributes, Draft, in_unit, place
from .shafts import GearPart, Key, ShaftPart

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
