"""Meshes: flank, phase lead, stiffness and its variation, branch by branch and side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...gears import stiffness as teeth_stiffness
from ...train.connections import Mesh
from ...train.kinematics import Kinematics
from ...train.phasing import StagePhases, ToothedGear, ToothMesh, chain_flanks, flank_of_torque, stage_leads, staggered
from ..schema import Material, MeshSide, ModelFile, Quantity, Variation
from .bodies import body_name, half_station, member_bodies
from .centres import MeshShape, StageShape
from .ledger import Ledger, Number, per_branch, turns_of
from .plan import Pair, Plan
from .slices import require_width, slices_of

__all__ = ["meshes_of_stage"]

NORMAL_RANGE = (10e9, 30e9)  # stiffness per face width of steel teeth, transverse [N/m^2]
STEEL_MODULUS = 206e9
SHORT = 10**4  # a phase in the file this near to a fraction of small numbers is that fraction


@dataclass(frozen=True, slots=True, kw_only=True)
class _Law:
    """Stiffness of one side of a pair: per branch along the tooth normal [N/m], and its relative series over sigma.

    limits : sigma of first and last contact where the series is that of contact lines, else None.
    """

    stiffness: tuple[float, ...]
    variation: NDArray[np.complex128]
    limits: tuple[float, float] | None
    damping: float
    backlash: float


def meshes_of_stage(
    shape: StageShape,
    model: ModelFile,
    kinematics: Kinematics,
    tones: Mapping[str, str],
    ledger: Ledger,
) -> list[Mesh]:
    """All meshes of a stage.

    tones : mesh frequency each pair follows, by its path.

    Raises
    ------
    ModelError : a stiffness that cannot be computed from what is given.
    """
    plan = shape.plan
    flanks = _flanks(plan, kinematics)
    sense = _sun_sense(plan, kinematics)
    gears, toothed = _toothed(plan, shape), _tooth_meshes(shape, flanks)
    phases = stage_leads(gears, toothed, sense=sense)
    _check_assembly(plan, phases, ledger)
    _check_shafts(plan, gears, toothed, ledger)
    for name, turns in phases.clocking.items():
        origin = "given" if isinstance(plan.gears[name].clocking, tuple) else "geometry"
        angles = [math.tau * float(turn) for turn in turns]
        ledger.note(f"{plan.member_path(name)}.clocking", angles, "rad", origin)
    found: list[Mesh] = []
    for p in plan.pairs:
        if p.keys.slices is not None:
            ledger.note(f"{p.path}.slices", p.keys.slices)
        for side in shape.meshes[p.name].width:
            law = _law(shape, p, side, model, ledger)
            leads = _leads(plan, p, side, phases, sense, ledger)
            width, count = shape.meshes[p.name].width[side], p.keys.slices or 1
            require_width(width, count, plan.path)
            for branch in range(len(plan.angles)):
                mesh = _mesh(shape, p, side, branch, law, (flanks[p.name], phases.sense[p.name]))
                mesh = replace(mesh, lead=leads[branch], stage=tones[p.path])
                found.append(replace(mesh, slices=slices_of(mesh, count, width, law.limits)))
    return sorted(found, key=lambda mesh: ([p.path for p in plan.pairs].index(mesh.pair), mesh.branch or 0))


def _mesh(shape: StageShape, p: Pair, side: str | None, branch: int, law: _Law, signs: tuple[int, int]) -> Mesh:
    plan, meshing = shape.plan, shape.meshes[p.name]
    a, b = shape.teeth[p.a], shape.teeth[p.b]
    number = branch + 1 if plan.branches and not (plan.central(p.a) and plan.central(p.b)) else None
    direction = shape.directions[p.name][branch]
    turns = float(direction if isinstance(direction, (int, float, Fraction)) else direction.value)
    width = meshing.width[side]
    cosine = math.cos(meshing.working_angle)
    return Mesh(
        name=body_name(plan.name, p.name, number, side),
        pair=p.path,
        stage=plan.name,
        branch=number,
        side=side,
        a=_body(plan, p.a, number, side),
        b=_body(plan, p.b, number, side),
        internal=p.internal,
        direction=math.tau * turns,
        pressure_angle=meshing.working_angle,
        base_helix=a.base_helix,
        hand=-a.hand if side == "right" else a.hand,
        flank=signs[0],
        station=(half_station(plan, p.a, side) + half_station(plan, p.b, side)) / 2,
        radius_a=a.base_radius / cosine,
        radius_b=b.base_radius / cosine,
        stiffness=law.stiffness[branch],
        variation=law.variation,
        sense=signs[1],
        damping=law.damping,
        backlash=law.backlash,
        contact_ratio=meshing.contact_ratio,
        overlap_ratio=_overlap(meshing, shape, p, width),
    )


def _overlap(meshing: MeshShape, shape: StageShape, p: Pair, width: float) -> float:
    first = next(iter(meshing.width.values()))
    return (
        meshing.overlap_ratio
        if width == first or not shape.teeth[p.a].helix_angle
        else (meshing.overlap_ratio * width / first)
    )


def _body(plan: Plan, member: str, number: int | None, side: str | None) -> str:
    own = member_bodies(plan, member, None if plan.central(member) else number)
    return own[side] if side in own else own[None]


# flanks, senses, leads -----------------------------------------------------------------------------------------------


def _toothed(plan: Plan, shape: StageShape) -> list[ToothedGear]:
    found = []
    for name, member in plan.gears.items():
        fit = member.clocking is None or isinstance(member.clocking, str)
        angles = () if fit else per_branch(member.clocking, len(plan.angles), f"{plan.member_path(name)}.clocking")  # type: ignore[arg-type]
        found.append(
            ToothedGear(
                name=name,
                teeth=member.teeth or 0,
                internal=member.kind == "ring",
                central=plan.central(name),
                profile_shift=next(iter(shape.gears[name].values())).profile_shift,
                on=None if member.on is None else member.on.split(".")[-1],
                clocking=None if fit else tuple(turns_of(angle) for angle in angles),
            )
        )
    return found


def _tooth_meshes(shape: StageShape, flanks: Mapping[str, int]) -> list[ToothMesh]:
    return [
        ToothMesh(
            pair=p.name,
            a=p.a,
            b=p.b,
            directions=shape.directions[p.name],
            flank=flanks[p.name],
            normal_angle=shape.teeth[p.a].pressure_angle,
            transverse_angle=shape.teeth[p.a].transverse_angle,
            working_angle=shape.meshes[p.name].tooth_angle,
        )
        for p in shape.plan.pairs
    ]


def _flanks(plan: Plan, kinematics: Kinematics) -> dict[str, int]:
    """Flank d of every pair: from the torque it passes; without torques +1 at the first central gear."""
    torques = {p.name: (kinematics.mesh_torque or {}).get(p.path, 0.0) for p in plan.pairs}
    largest = max(abs(torque) for torque in torques.values())
    if largest == 0.0:
        gears = [
            ToothedGear(name=n, teeth=m.teeth or 0, internal=m.kind == "ring", central=plan.central(n), on=_on(m.on))
            for n, m in plan.gears.items()
        ]
        signs = chain_flanks(gears, [(p.a, p.b) for p in plan.pairs], 1)
        return {p.name: sign for p, sign in zip(plan.pairs, signs, strict=True)}
    return {p.name: flank_of_torque(torques[p.name], internal=p.internal) for p in plan.pairs}


def _on(reference: str | None) -> str | None:
    return None if reference is None else reference.split(".")[-1]


def _sun_sense(plan: Plan, kinematics: Kinematics) -> int:
    """Sign of the first gear's speed relative to the carrier; without speeds, of the first freedom turning positive."""
    gear = f"{plan.name}.{plan.pairs[0].a}"
    carrier = None if plan.carrier is None else f"{plan.name}.{plan.carrier}"
    if kinematics.speed is not None:
        relative = kinematics.speed[gear] - (kinematics.speed[carrier] if carrier else 0)
        return -1 if relative < 0 else 1
    for freedom in kinematics.freedoms:
        relative = kinematics.ratio[gear][freedom] - (kinematics.ratio[carrier][freedom] if carrier else 0)
        if relative:
            return -1 if relative < 0 else 1
    return 1


def _leads(
    plan: Plan, p: Pair, side: str | None, phases: StagePhases, sense: int, ledger: Ledger
) -> tuple[Number, ...]:
    """Lead of every branch: given as `phase`, else from teeth and angles, staggered on the right."""
    table = _said(p, side, "phase")
    path = f"{p.path}.{side}.phase" if side else f"{p.path}.phase"
    if table is not None:
        values = per_branch(table.phase, len(plan.angles), path)
        leads = tuple(_fraction(value) % 1 for value in values)
        ledger.note(f"{p.path}.phase" if table is p.keys else path, [float(lead) for lead in leads], "cycles")
        if table is p.keys:
            return leads
    else:
        leads = phases.lead[p.name]
        stagger = plan.gears[p.a].stagger if plan.gears[p.a].stagger is not None else plan.stage.stagger
        if side == "right" and stagger:
            leads = tuple(staggered(lead, _fraction(stagger), sense) for lead in leads)
        ledger.note(path, [float(lead) for lead in leads], "cycles", "geometry")
    return leads


def _fraction(value: float) -> Number:
    exact = Fraction(value).limit_denominator(SHORT)
    return exact if abs(float(exact) - value) < 1e-12 else value


def _check_assembly(plan: Plan, phases: StagePhases, ledger: Ledger) -> None:
    if phases.assembles:
        return
    given, nearest = (
        ", ".join(f"{float(turn) * 360:.6g}" for turn in turns) for turns in (plan.angles, phases.nearest_angles)
    )
    ledger.warn(
        f"{plan.path}: planets at {given} deg cannot be assembled, the teeth do not meet; nearest angles {nearest} deg"
    )


def _check_shafts(plan: Plan, gears: Sequence[ToothedGear], meshes: Sequence[ToothMesh], ledger: Ledger) -> None:
    """Warn where stepped shafts clocked as their places demand cannot all be alike."""
    stepped = [gear.name for gear in gears if gear.on is not None and not gear.central and gear.clocking is None]
    if not stepped:
        return
    alike = (Fraction(0),) * len(plan.angles)
    clocked = [replace(gear, clocking=alike) if gear.name in stepped else gear for gear in gears]
    if not stage_leads(clocked, meshes, sense=1).assembles:
        ledger.warn(
            f"{plan.path}: identical shafts of {', '.join(stepped)} do not fit all branches; "
            "each is clocked as its place demands"
        )


# stiffness -----------------------------------------------------------------------------------------------------------


def _said(p: Pair, side: str | None, key: str) -> MeshSide | None:
    """The table that says `key` of a side of a pair: the side's, else the mesh's, else None."""
    tables: Sequence[MeshSide | None] = (getattr(p.keys, side) if side else None, p.keys)
    return next((t for t in tables if t is not None and getattr(t, key) is not None), None)


def _law(shape: StageShape, p: Pair, side: str | None, model: ModelFile, ledger: Ledger) -> _Law:
    plan, width = shape.plan, shape.meshes[p.name].width[side]
    table = _said(p, side, "stiffness")
    value = "iso6336" if table is None else table.stiffness
    path = f"{p.path}.{side}.stiffness" if table is not None and table is not p.keys else f"{p.path}.stiffness"
    count = len(plan.angles)
    if isinstance(value, Quantity):
        stiffness = per_branch(_normal(shape, p, side, value, path), count, path)
        computed = False
    else:
        stiffness = (_computed(shape, p, str(value), width, path, model, ledger),) * count
        computed = True
    note = stiffness[0] if len(set(stiffness)) == 1 else list(stiffness)
    by_side = len(set(shape.meshes[p.name].width.values())) > 1 or table not in (None, p.keys)
    where = f"{p.path}.{side}.stiffness" if side and by_side else f"{p.path}.stiffness"
    ledger.note(where, note, "N/m", f"{value or 'iso6336'}" if computed else "given")
    _check_range(shape, p, width, stiffness, ledger)
    damping, backlash = _said(p, side, "damping"), _said(p, side, "backlash")
    variation, limits = _variation(shape, p, side, computed, ledger)
    return _Law(
        stiffness=stiffness,
        variation=variation,
        limits=limits,
        damping=damping.damping or 0.0 if damping is not None else 0.0,
        backlash=math.inf if backlash is None or backlash.backlash is None else backlash.backlash,
    )


def _normal(shape: StageShape, p: Pair, side: str | None, given: Quantity, path: str) -> float | tuple[float, ...]:
    """A given stiffness along the tooth normal of one helix [N/m]."""
    factor = 1.0
    if given.unit == "N/m^2":
        factor = _needed_width(shape, p, side, path)
    direction = _said(p, side, "direction")
    if direction is not None and direction.direction == "transverse":
        factor /= math.cos(shape.teeth[p.a].base_helix) ** 2
    if isinstance(given.value, tuple):
        return tuple(value * factor for value in given.value)
    return given.value * factor


def _needed_width(shape: StageShape, p: Pair, side: str | None, path: str) -> float:
    width = shape.meshes[p.name].width[side]
    if math.isnan(width):
        raise ModelError(
            "is missing: the mesh stiffness needs it",
            path=f"{shape.plan.path}.face_width",
            allowed=f"a face width of the stage or of {p.a} and {p.b}, or {path} in N/m",
        )
    return width


def _computed(
    shape: StageShape, p: Pair, method: str, width: float, path: str, model: ModelFile, ledger: Ledger
) -> float:
    """Mean stiffness along the tooth normal of one helix by a named method [N/m]."""
    if method != "iso6336":
        raise ModelError(
            f"the method '{method}' is not available in this version",
            path=path,
            given=method,
            allowed="iso6336, or a stiffness in N/m or N/(mm um)",
        )
    if math.isnan(width):
        _needed_width(shape, p, next(iter(shape.meshes[p.name].width)), path)
    a, b = shape.teeth[p.a], shape.teeth[p.b]
    first, second = next(iter(shape.gears[p.a].values())), next(iter(shape.gears[p.b].values()))
    single, limits = teeth_stiffness.iso6336_single_stiffness(
        a.teeth,
        b.teeth,
        a.pressure_angle,
        a.helix_angle,
        internal=p.internal,
        shift_a=first.profile_shift,
        shift_b=second.profile_shift,
        dedendum_a=first.dedendum,
        dedendum_b=second.dedendum,
        youngs_modulus_a=_modulus(shape.plan, p.a, model),
        youngs_modulus_b=_modulus(shape.plan, p.b, model),
    )
    mean, more = teeth_stiffness.iso6336_mesh_stiffness(single, shape.meshes[p.name].contact_ratio)
    for text in (*limits, *more):
        ledger.warn(f"{path}: {text}")
    return teeth_stiffness.normal_from_transverse(mean * width, a.base_helix)


def _modulus(plan: Plan, gear: str, model: ModelFile) -> float:
    tables: tuple[Material | None, ...] = (plan.gears[gear].material, plan.stage.material, model.material)
    said = (t.youngs_modulus for t in tables if t is not None)
    return next((value for value in said if value is not None), STEEL_MODULUS)


def _check_range(shape: StageShape, p: Pair, width: float, stiffness: Sequence[float], ledger: Ledger) -> None:
    if math.isnan(width):
        return
    for value in sorted(set(stiffness)):
        per_width = value * math.cos(shape.teeth[p.a].base_helix) ** 2 / width
        if not NORMAL_RANGE[0] <= per_width <= NORMAL_RANGE[1]:
            ledger.warn(f"{p.path}.stiffness: {per_width / 1e9:.3g} N/(mm um) of face width, steel teeth have 10 .. 30")


def _variation(
    shape: StageShape, p: Pair, side: str | None, computed: bool, ledger: Ledger
) -> tuple[NDArray[np.complex128], tuple[float, float] | None]:
    """Relative Fourier coefficients over sigma, (L,), and the limits of the contact lines they come from, if any."""
    table, meshing = _said(p, side, "variation"), shape.meshes[p.name]
    said: Variation | None = None if table is None else table.variation
    form = ("contact-lines" if computed else "none") if said is None else said.form
    if form in ("none", "contact-lines"):
        ledger.note(f"{p.path}.variation", form, "", "default" if said is None else "given")
    if form == "contact-lines":
        overlap = _overlap(meshing, shape, p, meshing.width[side])
        if math.isnan(overlap):
            _needed_width(shape, p, side, f"{p.path}.stiffness")
        if meshing.contact_ratio <= 0:
            raise ModelError("the teeth do not touch: contact ratio below 0", path=p.path)
        return teeth_stiffness.contact_line_series(meshing.limits, overlap), meshing.limits
    if said is None or form == "none":
        return np.zeros(0, complex), None
    if form == "values":
        return teeth_stiffness.table_series(said.values)[1], None
    return teeth_stiffness.fourier_series(said.cosine, said.sine), None
