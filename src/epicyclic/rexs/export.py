"""A train as a REXS file of version 1.7, with the list of what the format does not carry; a file that was read as the
text of a commented model file.

The keys of a model that the file carries are listed; every other one of a document is named, with the reason.

Load cases are written as the load spectrum, each with its time, speeds and torques, and with the load factors of its
meshes where they are computed.  The ids are those of the schema of REXS 1.7 as FVA publishes it: `operating_time` and
`operating_time_fraction` of the gear unit, the factors of `cylindrical_stage` by ISO 6336:2019, `torque` (with sign)
and `number_of_load_cycles` of `cylindrical_stage_gear_data`.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from ..document.cases import at_case
from ..document.document import read
from ..document.schema import CaseTable
from ..document.tables import leaves
from ..document.writer import commented_text
from ..engine.source import Overrides, Source, train_of
from ..errors import ModelError
from ..results.files import package_version, whole_file
from ..train.train import Train
from ..user_input import as_output, checked, outputs_apart
from .encodings import encoding_of, rexs_bytes
from .export_components import (
    Draft,
    Dropped,
    Values,
    add_carriers,
    add_joints,
    add_loads,
    add_meshes,
    add_shafts,
    attributes_of,
    gravity_of,
    load_of,
    place,
    speed_of,
)
from .file import CASE_NAME, SHARED, Component, LoadCase, RexsFile, rows_of

if TYPE_CHECKING:
    from .import_train import RexsImport

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
def write_rexs(source: Source | xr.Dataset, path: str | Path, *, overrides: Overrides | None = None) -> RexsExport:
    """Write a train with its load cases as a REXS file of version 1.7, whole or not at all.

    The same model gives the same bytes: its date is that of the model file, or 1970-01-01 of a model without a file.

    Parameters
    ----------
    source : model file, name of a ready drive, nested tables, a Train; or a result of `load_factors`, whose factors
        and load cycles then stand in the load cases.
    path : ``.rexs`` (XML), ``.rexsj`` (JSON) or ``.rexsz`` (zip of the XML), also ``.rexs.xml`` and so on.
    overrides : values by path in the model file.

    Raises
    ------
    ModelError : the model is wrong; a result of another verb; planets that mesh with each other; gears that do not fit
        their places; a file that cannot be written, or is the source.
    """
    encoding = encoding_of(path)
    factors = source if isinstance(source, xr.Dataset) else None
    if factors is not None:
        if factors.attrs.get("verb") != "load_factors":
            given = factors.attrs.get("verb", "a Dataset")
            raise ModelError("no load factors", path="source", given=given, allowed="a result of load_factors")
        source = json.loads(factors.attrs["model"])
    assert not isinstance(source, xr.Dataset)
    with outputs_apart():
        as_output(Path(path))
        train = train_of(source, overrides=overrides)
    export = rexs_of(train, date=_date(source), factors=factors)
    stem = Path(path).name.split(".rexs")[0]
    raw = rexs_bytes(export.file, encoding, name=f"{stem}.rexs")
    with whole_file(path) as opened:
        opened.write(raw)
    return export


def _date(source: Source) -> str:
    """Date of a model file; that of no file where there is none: no clock is read."""
    with suppress(OSError, ValueError, OverflowError):
        if isinstance(source, (str, Path)) and Path(source).is_file():
            return datetime.fromtimestamp(int(os.stat(source).st_mtime), tz=UTC).isoformat()
    return _NO_DATE.isoformat()


def rexs_of(train: Train, *, date: str = _NO_DATE.isoformat(), factors: xr.Dataset | None = None) -> RexsExport:
    """A train as a REXS file, and what of it the format does not carry.

    Parameters
    ----------
    train : resolved train with at least one stage.
    date : of the file, as ISO 8601 writes it.
    factors : of `load_factors` of the model of the train, along `case`.

    Raises
    ------
    ModelError : planets that mesh with each other; gears that do not fit their places.
    """
    _check(train)
    draft = Draft(train)
    shifts = {"number_of_gears": 1, "gear_shift_index": 1}
    draft.unit = draft.add("gear_unit", train.title, {**place(0.0), **shifts, **gravity_of(train)})
    draft.casing = draft.add("gear_casing", "casing", within=draft.unit)
    # gears on parallel axes mesh in a cylindrical_stage of no planetary stage
    epicyclic = {body.member.split(".")[0] for body in train.bodies if body.kind == "planet"}
    for name in train.planets:
        if name in epicyclic:
            draft.stages[name] = draft.add("planetary_stage", name, within=draft.unit)
        else:
            reason = "written as cylindrical_stage; `epicyclic import` reads planetary stages alone"
            draft.drop(f"stages.{name}", reason)
    add_carriers(draft)
    add_shafts(draft)
    add_joints(draft)
    add_meshes(draft)
    add_loads(draft)
    load_cases, accumulations = spectrum_of(draft, factors)
    file = RexsFile(
        version=VERSION,
        application="epicyclic",
        application_version=package_version(),
        date=date,
        components=tuple(draft.components),
        relations=tuple(draft.relations),
        load_cases=load_cases,
        accumulations=accumulations,
    )
    return RexsExport(file, tuple(dict.fromkeys([*draft.dropped, *left_out(train.document)])))


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
            raise ModelError(
                f"gears that do not fit their places: they work at a centre distance of {worked * 1e3:.7g} mm",
                path=f"{mesh.pair}.centre_distance",
                given=f"{distance * 1e3:.7g} mm",
                allowed="one geometry of all gears",
            )


# load spectrum --------------------------------------------------------------------------------------------------------

_FACTORS = {
    "mesh_load_factor_iso_6336_2019": "k_gamma",
    "dynamic_factor_iso_6336_2019": "dynamic_factor",
    "face_load_factor_contact_stress_iso_6336_2019": "face_load_factor",
    "transverse_load_factor_contact_stress_iso_6336_2019": "accuracy_load_factor",
}
"""Attribute of a cylindrical stage -> variable of `load_factors` (case, mesh)."""
_OF_GEAR = {"torque": "pair_torque", "number_of_load_cycles": "load_cycles"}
"""Attribute of the data of a gear in a stage -> variable of `load_factors` (case, mesh_pair, mesh_gear)."""
_NO_PLACE = {
    "flank_cycles": "of both flanks apart: the file has the cycles of each load case",
    "flank_equivalent_torque": "follows from the load cases by the exponent of the rating",
    "transverse_load_factor": "of contact, by eps_alpha: the file has that of deviations, as ISO 6336 defines it",
    "direct_load_factor": "no place in the format",
    "largest_load_per_length": "no place in the format",
    "largest_pressure": "of contact, no contact stress of ISO 6336",
    "largest_root_stress": "of contact, no root stress of ISO 6336",
}
"""Variable of `load_factors` -> why it is not written."""


def spectrum_of(draft: Draft, factors: xr.Dataset | None) -> tuple[tuple[LoadCase, ...], tuple[Component, ...]]:
    """Load cases of the model of a draft, and what they sum to; what is not carried is noted.

    factors : of `load_factors`, along `case`; the operation of a model without cases is one load case then.

    Returns
    -------
    load cases, with ids from 1 in the order of the model; accumulation: the whole operating time, where it is known.
    """
    cases = dict(read(dict(draft.train.document)).model.cases) if draft.train.document else {}
    trains = {name: _train_at(draft, name) for name in cases}
    if factors is not None:
        trains = trains or {"operation": draft.train}
        for name in sorted(_NO_PLACE.keys() & factors.variables.keys()):
            draft.drop(f"load_factors.{name}", _NO_PLACE[name])
    whole = math.fsum(case.duration or 0.0 for case in cases.values())
    found = list[LoadCase]()
    for name, train in trains.items():
        if train is not None:
            own = factors.sel(case=name) if factors is not None and name in factors.case.values else None
            time = {**_time(cases[name], whole), CASE_NAME: name} if name in cases else {}
            found.append(LoadCase(len(found) + 1, tuple(_components(draft, time, train, own))))
    return tuple(found), (_over(draft, draft.unit, {"operating_time": whole}),) if whole else ()


def _train_at(draft: Draft, name: str) -> Train | None:
    """The train at a load case; None, which is noted, where the file cannot say what the case is."""
    try:
        train = train_of(dict(draft.train.document), overrides={"case": name})
    except ModelError as error:
        draft.drop(f"cases.{name}", f"not written, as it is not determined: {error}")
        return None
    operation = [at_case(read(dict(one.document)).model).operation for one in (train, draft.train)]
    if len({(frozenset(one.held), frozenset(one.open)) for one in operation}) > 1:
        draft.drop(f"cases.{name}", "not written: couplings and held members of a load case have no place")
        return None
    return train


def _time(case: CaseTable, whole: float) -> Values:
    """Time of a load case, and its share of the time that all cases sum to; None of what the model does not say."""
    share = case.duration / whole if case.duration and whole else case.share
    return {"operating_time": case.duration, "operating_time_fraction": share}


def _components(draft: Draft, time: Values, train: Train, factors: xr.Dataset | None) -> Iterator[Component]:
    """Components of a load case that say more than, or other than, those of the file."""
    yield _over(draft, draft.unit, time)
    loads = {one.name: one.id for one in draft.components if one.type == "external_load"}
    for shaft in draft.central_shafts:
        member = shaft.first.member
        yield _over(draft, shaft.number, speed_of(train, member))
        if (load := load_of(train, member)) and (number := loads.pop(f"{member} torque", 0)):
            yield _over(draft, number, load)
    if factors is not None:
        yield from _factor_components(draft, factors)


def _factor_components(draft: Draft, factors: xr.Dataset) -> Iterator[Component]:
    """Load factors of every mesh of a case, and torque and load cycles of a tooth of its gears in all of their pair."""
    pairs = {mesh.name: mesh.pair for mesh in draft.train.meshes}
    stages = {one.id: one.name for one in draft.components if one.type == "cylindrical_stage"}
    for stage, name in stages.items():
        of_mesh = factors.sel(mesh=name)
        unknown = str(of_mesh.face_load_basis.item()).startswith("not")
        yield _over(draft, stage, _finite(of_mesh, _FACTORS, "face_load_factor" if unknown else ""))
        # as `add_meshes` adds them, the data of both gears follow their stage
        for number, gear in enumerate("ab", start=stage + 1):
            yield _over(draft, number, _finite(factors.sel(mesh_pair=pairs[name], mesh_gear=gear), _OF_GEAR))


def _finite(found: xr.Dataset, names: Mapping[str, str], without: str = "") -> Values:
    """Values by attribute, of the variables that there are and are finite."""
    values = {key: float(found[name]) for key, name in names.items() if name in found and name != without}
    return {key: value for key, value in values.items() if math.isfinite(value)}


def _over(draft: Draft, number: int, values: Values) -> Component:
    """What stands in place of, or beside, the attributes of a component."""
    return replace(draft.components[number - 1], attributes=attributes_of(values))


# what is left out -----------------------------------------------------------------------------------------------------

_LINK = r"(?:\.[\w-]+)?\.(?:radial|x|y|z|tilt|rx|ry|rz|at|to)"
_OF_GEARS = "|".join(row.key for kind in ("gear", "gear_flank") for row in rows_of(f"cylindrical_{kind}") if row.key)
_CARRIED = re.compile(
    r"format|title|material\.\w+"
    rf"|stages\.[\w-]+\.(?:planets|planet_angles|centre_distance|herringbone|gap|split|{'|'.join(SHARED)})"
    rf"|stages\.[\w-]+\.(?!meshes)[\w-]+\.(?:{_OF_GEARS}|dedendum|base_radius|mass|inertia|tilt_inertia|hand|kind|on"
    r"|station|pin_radius|gap|split|herringbone|rim|outer_diameter)"
    r"|stages\.[\w-]+\.(?:[\w-]+\.)?material\.\w+"
    rf"|stages\.[\w-]+\.[\w-]+\.(?:support|bearing){_LINK}"
    r"|stages\.[\w-]+\.(?:[\w-]+\.)?flank\.(?:tip_relief\.(?:amount|length|shape)|crown)"
    r"|stages\.[\w-]+\.(?:[\w-]+\.)?flank\.(?:root_relief|end_relief|slope|profile|waves|pitch)(?:\..*)?"
    r"|stages\.[\w-]+\.meshes\.[\w-]+\.(?:stiffness|direction|backlash)(?:\..*)?"
    rf"|bodies\.[\w-]+\.(?:mass|inertia|tilt_inertia|station|support{_LINK})"
    r"|couplings\.[\w-]+\.(?:between|radial|x|y|z|tilt|rx|ry|rz|radius)"
    r"|operation\.(?:held|gravity|(?:speed|torque|power)\..+)"
    r"|case|cases\.[\w-]+\.(?:duration|share|(?:speed|torque|power)\..+)"
)
# assumptions, costs and deviations as the entry they belong to
_ENTRY = re.compile(
    r"^(assumed|tolerance\.cost)\..*|^(deviations\b.*)\.(?:amplitude|phase|order|seed|value|frequency)$"
)
_REASONS = (
    (r"assumed\..*", "what is assumed is written like what is given"),
    (r"(?:doi|notes)$", "a text of the model file"),
    (r"damping\..*", "the format has no damping of a whole train"),
    (r"tolerance\..*", "distributions of deviations have no place"),
    (r"deviations\..*", "deviations have no place; what they do to the mean load is in K_gamma"),
    (r"sensors\..*", "sensors are not written"),
    (r"(?:cases\.[\w-]+\.)?loads\..*|operation\.loads.*", "forces on members are not written"),
    (r".*\.internal_clearance(?:\..*)?", "play has no place"),
    (r".*\.shaft_sections\..*", "one rigid shaft in the file"),
    (r".*\.bore$", "only the mass that follows from it is written"),
    (r".*\.meshes\.[^.]+\.variation.*", "the file has the mean stiffness"),
    (r".*\.meshes\.[^.]+\.(?:phase|pressure_angle)", "follows from the geometry in the file"),
    (r".*\.(?:neck|shaft)(?:\..*)?$", "one rigid shaft in the file"),
    (r".*\.clocking", "the phase of the second gear of a planet has no place"),
    (r".*\.tip_rounding", "of a tool that the file does not have"),
    (r".*\.clearance(?:\..*)?", "play has no place"),
    (r".*\.exponent(?:\..*)?", "the stiffness at its load is written, not its law"),
    (r".*\.table(?:\..*)?", "the nominal stiffness is written, not the table"),
    (r".*\.(?:friction|damping|load|law)(?:\..*)?", "laws of links have no place"),
)


def left_out(document: Mapping[str, object]) -> Iterator[Dropped]:
    """What stands in a document and is not carried, each value with its path; tables of reasons as one entry."""
    seen: set[str] = set()
    for path, _ in leaves(dict(document)):
        if _CARRIED.fullmatch(path):
            continue
        entry = _ENTRY.sub(r"\1\2", path)
        if entry not in seen:
            seen.add(entry)
            reasons = (text for pattern, text in _REASONS if re.fullmatch(pattern, path))
            yield Dropped(entry, next(reasons, "no place in the format"))


def rexs_model_text(model: RexsImport, file: str) -> str:
    """A model file with the ids of the components it comes from.

    file : name of the REXS file, told in the head.
    """
    date = f", of {model.file.date}" if model.file.date else ""
    head = (
        f"From the REXS file {Path(file).name}{date}.",
        f"{len(model.read)} values read, {len(model.assumed)} assumed, {len(model.dropped)} dropped: the numbers in",
        "brackets are ids of components of that file; [assumed] at the end has what it does not say.",
        *model.warnings,
    )
    return commented_text(model.document, head=head, comments=model.comments)
