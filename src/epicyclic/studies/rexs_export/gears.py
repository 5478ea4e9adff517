"""Gears of a train as components of a REXS file: teeth, diameters, flanks with their modifications, material."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...document.units import Bounds, read_quantity
from ...errors import ModelError
from ...teeth.flank import PLAIN, Flank
from ...train.bodies import Body, GearData
from ...train.train import Train
from .draft import Attributes, Draft, in_unit, place
from .parts import GearPart, Key, ShaftPart

__all__ = ["DEG", "add_gears", "material_of"]

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
