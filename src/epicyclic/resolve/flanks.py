"""Flanks: micro-geometry and what shapes the teeth of both gears of a mesh, for tooth contact."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from ..errors import ModelError
from ..gears import geometry
from ..gears.flank import PLAIN, Flank, Relief, Wave, check_flank
from ..gears.tooth_pair import ToothPair
from ..model import schema_flank
from ..model.schema import ModelFile
from ..tooth_contact.lines import Plane
from .bodies import half_station
from .centres import StageShape
from .gears import width_of
from .ledger import Ledger
from .plan import Pair, Plan
from .tooth_forms import tooth_form

__all__ = ["tooth_pair"]


def tooth_pair(shape: StageShape, p: Pair, side: str | None, model: ModelFile, ledger: Ledger) -> ToothPair | None:
    """The teeth of one side of a pair; None without a face width of either gear.

    Raises
    ------
    ModelError : micro-geometry that is not complete or does not fit the flank.
    """
    plan = shape.plan
    widths = width_of(plan, p.a, side), width_of(plan, p.b, side)
    flanks = _flank(plan, p.a, side, ledger), _flank(plan, p.b, side, ledger)
    if widths[0] is None or widths[1] is None:
        return None
    a, b, meshing = shape.teeth[p.a], shape.teeth[p.b], shape.meshes[p.name]
    unnoted = Ledger(assumed={})  # what stands for a body that is not said is noted where a stiffness needs it
    places = half_station(plan, p.a, side), half_station(plan, p.b, side)
    apart = (places[0] - places[1]) / 2
    teeth = ToothPair(
        form_a=tooth_form(shape, p.a, model, unnoted),
        form_b=tooth_form(shape, p.b, model, unnoted),
        base_a=a.nominal_base,
        base_b=b.nominal_base,
        pressure_angle=meshing.tooth_angle,
        base_pitch=geometry.base_pitch(a.module, a.pressure_angle, a.helix_angle),
        limits=meshing.limits,
        face_a=(apart - widths[0] / 2, apart + widths[0] / 2),
        face_b=(-apart - widths[1] / 2, -apart + widths[1] / 2),
        flank_a=flanks[0],
        flank_b=flanks[1],
        paths=(_path(plan, p.a, side), _path(plan, p.b, side)),
    )
    _check(teeth, p.internal)
    return teeth


def _check(teeth: ToothPair, internal: bool) -> None:
    plane = Plane(
        base_a=teeth.base_a,
        base_b=teeth.base_b,
        internal=internal,
        pressure_angle=teeth.pressure_angle,
        base_pitch=teeth.base_pitch,
        limits=teeth.limits,
        face_a=teeth.face_a,
        face_b=teeth.face_b,
    )
    for flank, radius, face, form, path in (
        (teeth.flank_a, plane.radius_a, teeth.face_a, teeth.form_a, teeth.paths[0]),
        (teeth.flank_b, plane.radius_b, teeth.face_b, teeth.form_b, teeth.paths[1]),
    ):
        if flank != PLAIN:
            height = abs(float(radius(teeth.limits[1]) - radius(teeth.limits[0])))
            check_flank(flank, height=height, width=face[1] - face[0], teeth=form.teeth, path=path)


# micro-geometry ------------------------------------------------------------------------------------------------------


def _flank(plan: Plan, name: str, side: str | None, ledger: Ledger) -> Flank:
    """Micro-geometry of one helix of a gear: every entry from its side, else the gear, else the stage."""
    said, paths = _said(plan, name, side)
    for key in ("crown", "slope"):
        if key in paths:
            ledger.note(f"{paths[key]}.{key}", getattr(said, key), "m")
    wave = said.wave

    def relief(key: str) -> Relief | None:
        table = getattr(said, key)
        return None if table is None else _relief(table, f"{paths[key]}.{key}", ledger)

    return Flank(
        tip_relief=relief("tip_relief"),
        root_relief=relief("root_relief"),
        end_relief=relief("end_relief"),
        crown=said.crown or 0.0,
        slope=said.slope or 0.0,
        profile=() if said.profile is None else _profile(said.profile, f"{paths['profile']}.profile"),
        waves=() if wave is None else (Wave(amplitude=wave.amplitude, order=wave.order, phase=wave.phase),),
    )


def _said(plan: Plan, name: str, side: str | None) -> tuple[schema_flank.Flank, dict[str, str]]:
    """Entries of the micro-geometry of a gear, and the path of the flank that says each of them."""
    member = plan.stage.members[name]
    half = getattr(member, side) if side else None
    tables: Sequence[tuple[str, schema_flank.Flank | None]] = (
        (f"{plan.path}.flank", plan.stage.flank),
        (f"{plan.member_path(name)}.flank", member.flank),
        (f"{plan.member_path(name)}.{side}.flank", None if half is None else half.flank),
    )
    found, paths = schema_flank.Flank(), dict[str, str]()
    for path, table in tables:
        entries = (
            {}
            if table is None
            else {k: v for k in schema_flank.Flank.model_fields if (v := getattr(table, k)) is not None}
        )
        found = found.model_copy(update=entries)
        paths |= dict.fromkeys(entries, path)
    return found, paths


def _path(plan: Plan, name: str, side: str | None) -> str:
    """The flank of a gear in the file, of a side where that says its own."""
    half = getattr(plan.stage.members[name], side) if side else None
    own = half is not None and half.flank is not None
    return f"{plan.member_path(name)}.{side}.flank" if own else f"{plan.member_path(name)}.flank"


def _relief(table: schema_flank.Relief, path: str, ledger: Ledger) -> Relief:
    for key in ("amount", "length"):
        if getattr(table, key) is None:
            raise ModelError("is missing", path=f"{path}.{key}", allowed="a length")
        ledger.note(f"{path}.{key}", getattr(table, key), "m")
    ledger.note(f"{path}.shape", table.shape)
    return Relief(amount=table.amount or 0.0, length=table.length or 0.0, shape=table.shape)


def _profile(table: schema_flank.Profile, path: str) -> tuple[tuple[float, float], ...]:
    if len(table.below_tip) != len(table.missing) or any(b <= a for a, b in pairwise(table.below_tip)):
        raise ModelError(
            "heights must rise, one for each deviation",
            path=path,
            given=f"{len(table.below_tip)}, {len(table.missing)}",
        )
    return tuple(zip(table.below_tip, table.missing, strict=True))
