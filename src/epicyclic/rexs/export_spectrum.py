"""Load cases of a model as the load spectrum of a REXS file, each with its time, speeds and torques, and with the load
factors of its meshes where they are computed.

The ids are those of the schema of REXS 1.7 as FVA publishes it: `operating_time` and `operating_time_fraction` of the
gear unit, the factors of `cylindrical_stage` by ISO 6336:2019, `torque` (with sign) and `number_of_load_cycles` of
`cylindrical_stage_gear_data`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from ..document.cases import at_case
from ..document.document import read
from ..document.schema import CaseTable
from ..engine.source import train_of
from ..errors import ModelError
from ..train.train import Train
from .export_components import Draft, Values, attributes_of, load_of, speed_of
from .file import Component, LoadCase
from .table import CASE_NAME

if TYPE_CHECKING:
    import xarray as xr

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
