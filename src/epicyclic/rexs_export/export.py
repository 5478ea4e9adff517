"""A train as a REXS file of version 1.7, with the list of what the format does not carry."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from ..arguments import checked
from ..engine.source import Overrides, Source, train_of
from ..errors import ModelError
from ..input_files import as_output, outputs_apart
from ..results.files import package_version, whole_file
from ..rexs.file import RexsFile
from ..rexs.members import Inertia, SolidSection, inertia_of
from ..rexs.writing import encoding_of, rexs_bytes
from ..train.train import Train
from .components import (
    Key,
    ShaftPart,
    add_gears,
    add_joints,
    add_loads,
    add_meshes,
    gravity_of,
    material_of,
    mesh_load_factors,
    shafts_of,
    speed_of,
)
from .draft import Attributes, Draft, Dropped, in_unit, left_out, place

VERSION = "1.7"
_NO_DATE = datetime(1970, 1, 1, tzinfo=UTC)


@dataclass(frozen=True, slots=True)
class RexsExport:
    """A train as a REXS file.

    file : its components and relations.  dropped : what of the model it does not carry, with the reasons.
    """

    file: RexsFile
    dropped: tuple[Dropped, ...]


@checked
def write_rexs(source: Source, path: str | Path, *, overrides: Overrides | None = None) -> RexsExport:
    """Write a train as a REXS file of version 1.7, whole or not at all.

    The same model gives the same bytes: its date is that of the model file, or 1970-01-01 of a model without a file.

    Parameters
    ----------
    source : model file, name of a ready drive, nested tables, or a Train.
    path : ``.rexs`` (XML), ``.rexsj`` (JSON) or ``.rexsz`` (zip of the XML), also ``.rexs.xml`` and so on.
    overrides : values by path in the model file.

    Raises
    ------
    ModelError : the model is wrong; planets that mesh with each other; gears that do not fit their places; a file that
        cannot be written, or is the source.
    """
    encoding = encoding_of(path)
    with outputs_apart():
        as_output(Path(path))
        train = train_of(source, overrides=overrides)
    found = rexs_of(train, date=_date(source))
    stem = Path(path).name.split(".rexs")[0]
    raw = rexs_bytes(found.file, encoding, name=f"{stem}.rexs")
    with whole_file(path) as opened:
        opened.write(raw)
    return found


def _date(source: Source) -> str:
    """Date of a model file; that of no file where there is none: no clock is read."""
    when = _NO_DATE
    try:
        if isinstance(source, (str, Path)) and Path(source).is_file():
            when = datetime.fromtimestamp(int(os.stat(source).st_mtime), tz=UTC)
    except (OSError, ValueError, OverflowError):
        when = _NO_DATE
    return when.isoformat()


def rexs_of(train: Train, *, date: str = _NO_DATE.isoformat()) -> RexsExport:
    """A train as a REXS file, and what of it the format does not carry.

    Parameters
    ----------
    train : resolved train with at least one stage.
    date : of the file, as ISO 8601 writes it.

    Raises
    ------
    ModelError : planets that mesh with each other; gears that do not fit their places.
    """
    _check(train)
    draft = Draft()
    unit = draft.add("gear_unit", train.title, {**place(0.0), "number_of_gears": (1, "none"),
                     "gear_shift_index": (1, "none"), **gravity_of(train)})  # fmt: skip
    casing = draft.add("gear_casing", "casing")
    draft.relate("assembly", assembly=unit, part=casing)
    materials: dict[object, int] = {}
    # gears on parallel axes mesh in a cylindrical_stage of no planetary stage
    epicyclic = {body.member.split(".")[0] for body in train.bodies if body.kind == "planet"}
    stages = {name: draft.add("planetary_stage", name) for name in train.planets if name in epicyclic}
    for name in train.planets:
        if name not in epicyclic:
            draft.drop(
                f"stages.{name}", "written as cylindrical_stage; `epicyclic import` reads planetary stages alone"
            )
    for number in stages.values():
        draft.relate("assembly", assembly=unit, part=number)
    carriers = _carriers(train, draft, stages)
    shafts: dict[str, tuple[ShaftPart, int]] = {}
    gears: dict[Key, int] = {}
    pins: dict[str, int] = {}
    for shaft in shafts_of(train, draft):
        number = _shaft(train, draft, shaft, unit, material_of(train, draft, shaft.first, materials))
        shafts |= {body.name: (shaft, number) for body in shaft.bodies}
        _in_stage(draft, shaft, number, stages, carriers, pins)
        gears |= add_gears(train, draft, shaft, number, materials)
    add_joints(train, draft, shafts, pins, casing)
    add_meshes(train, draft, stages, unit, gears, mesh_load_factors(train, draft))
    add_loads(train, draft, shafts)
    file = RexsFile(
        version=VERSION,
        application="epicyclic",
        application_version=package_version(),
        date=date,
        components=tuple(draft.components),
        relations=tuple(draft.relations),
    )
    dropped = dict.fromkeys([*draft.dropped, *left_out(train.document)])
    return RexsExport(file, tuple(dropped))


def _check(train: Train) -> None:
    """Raise ModelError for what would be read as another train."""
    bodies = {body.name: body for body in train.bodies}
    for mesh in train.meshes:
        if bodies[mesh.a].kind == bodies[mesh.b].kind == "planet":
            problem = "planets that mesh with each other: the format has no place for which of them is in which branch"
            raise ModelError(problem, path=mesh.pair, allowed="planets that mesh with sun and ring")
        distance = math.dist(bodies[mesh.a].centre, bodies[mesh.b].centre)
        worked = mesh.radius_b - mesh.radius_a if mesh.internal else mesh.radius_a + mesh.radius_b
        # far above rounding, far below any tolerance of a centre distance
        if abs(distance - worked) > 1e-6 * distance:
            problem = f"gears that do not fit their places: they work at a centre distance of {worked * 1e3:.7g} mm"
            given = f"{distance * 1e3:.7g} mm"
            raise ModelError(
                problem, path=f"{mesh.pair}.centre_distance", given=given, allowed="one geometry of all gears"
            )


def _carriers(train: Train, draft: Draft, stages: Mapping[str, int]) -> dict[str, int]:
    """Add the planet carrier of each stage that has one; by member."""
    found: dict[str, int] = {}
    for body in train.bodies:
        stage = body.member.split(".")[0]
        if body.kind == "carrier" and body.member not in found and stage in stages:
            found[body.member] = draft.add("planet_carrier", body.member)
            draft.relate("assembly", assembly=stages[stage], part=found[body.member])
    return found


def _shaft(train: Train, draft: Draft, shaft: ShaftPart, unit: int, material: int) -> int:
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


def _in_stage(
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
