"""Meshes: flank, phase lead, stiffness and its variation, branch by branch and side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..document.schema import ModelFile
from ..errors import ModelError
from ..teeth.geometry import shift_term
from ..teeth.mesh_stiffness import ToothPair, face_average
from ..warning_codes import coded
from .bodies import Mesh, MeshSlice
from .centres import StageShape
from .flanks import tooth_pair
from .kinematics import Kinematics
from .mesh_laws import MeshLaw, mesh_law, overlap_of
from .phasing import StagePhases, ToothedGear, ToothMesh, chain_flanks, flank_of_torque, stage_leads, staggered
from .stage_bodies import SLICES, body_name, member_bodies
from .stages import GearPair, Plan, gear_below, stated, stated_value
from .train import Number, ResolutionLog, per_branch, turns_of

SHORT = 10**4  # a phase in the file this near to a fraction of small numbers is that fraction


def meshes_of_stage(
    shape: StageShape,
    model: ModelFile,
    kinematics: Kinematics,
    tones: Mapping[str, str],
    tilting: Mapping[str, str],
    log: ResolutionLog,
) -> list[Mesh]:
    """All meshes of a stage.

    tones : mesh frequency each pair follows, by its path.  tilting : group of every body, see `tilt_groups`.

    Raises
    ------
    ModelError : a stiffness that cannot be computed from what is given.
    """
    plan = shape.plan
    gears = _toothed(plan, shape)
    flanks = _flanks(plan, gears, kinematics)
    sense = _sun_sense(plan, kinematics)
    toothed = _tooth_meshes(shape, flanks)
    phases = stage_leads(gears, toothed, sense=sense)
    _check_assembly(plan, phases, log)
    _check_shafts(plan, gears, toothed, log)
    for name, turns in phases.clocking.items():
        origin = "given" if isinstance(plan.gears[name].clocking, tuple) else "geometry"
        angles = [math.tau * float(turn) for turn in turns]
        log.note(f"{plan.member_path(name)}.clocking", angles, "rad", origin)
    meshes: list[Mesh] = []
    for p in plan.pairs:
        count = _slice_count(plan, p, shape.meshes[p.name].width, tilting, log)
        for side in shape.meshes[p.name].width:
            teeth = tooth_pair(shape, p, side, model, log)
            lean = flanks[p.name] * _hand(shape, p, side)
            law = mesh_law(shape, p, side, model, kinematics.mesh_torque, log, teeth=teeth, lean=lean)
            signs = flanks[p.name], phases.sense[p.name]
            advance = signs[0] * signs[1] * _hand(shape, p, side) * _axial_pitches(shape, p, side)
            leads = _leads(plan, p, side, phases, sense, advance, log)
            for branch in range(plan.branches_of(p)):
                mesh = _mesh(shape, p, side, branch, law, signs, lead=leads[branch], tone=tones[p.path], teeth=teeth)
                meshes.append(replace(mesh, slices=_slices_of(mesh, count, law.narrow)))
    return sorted(meshes, key=lambda mesh: ([p.path for p in plan.pairs].index(mesh.pair), mesh.branch or 0))


def _mesh(
    shape: StageShape,
    p: GearPair,
    side: str | None,
    branch: int,
    law: MeshLaw,
    signs: tuple[int, int],
    *,
    lead: Number,
    tone: str,
    teeth: ToothPair | None,
) -> Mesh:
    """Mesh of one branch (0 ..) and side, without slices.

    signs : flank d and sense D (docs/conventions.md, rows and phases).  tone : stage whose mesh frequency it follows.
    """
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
        stage=tone,
        branch=number,
        side=side,
        a=_body(plan, p.a, number, side),
        b=_body(plan, p.b, number, side),
        internal=p.internal,
        direction=math.tau * turns,
        pressure_angle=meshing.working_angle,
        base_helix=a.base_helix,
        hand=_hand(shape, p, side),
        flank=signs[0],
        station=meshing.station[side],
        width=width,
        radius_a=a.base_radius / cosine,
        radius_b=b.base_radius / cosine,
        stiffness=law.stiffness[branch],
        variation=law.variation,
        lead=lead,
        sense=signs[1],
        damping=law.damping,
        backlash=law.backlash,
        tooth_shift=2 * _shift(shape, p),
        contact_ratio=meshing.contact_ratio,
        limits=meshing.limits,
        teeth=teeth,
        table=law.table,
        overlap_ratio=overlap_of(meshing, shape, p, width),
    )


def _hand(shape: StageShape, p: GearPair, side: str | None) -> int:
    """Hand of gear a on a side."""
    hand = shape.teeth[p.a].hand
    return -hand if side == "right" else hand


def _shift(shape: StageShape, p: GearPair) -> float:
    """c of gear a in this mesh [pitches], see `teeth.geometry`."""
    return shift_term(
        teeth=shape.plan.gears[p.a].teeth or 0,
        profile_shift=next(iter(shape.gears[p.a].values())).profile_shift,
        normal_angle=shape.teeth[p.a].pressure_angle,
        transverse_angle=shape.teeth[p.a].transverse_angle,
        working_angle=shape.meshes[p.name].tooth_angle,
    )


def _body(plan: Plan, member: str, number: int | None, side: str | None) -> str:
    """Name of the body that carries a gear of one branch (1 ..) on one side."""
    bodies = member_bodies(plan, member, None if plan.central(member) else number)
    return bodies[side] if side in bodies else bodies[None]


# flanks, senses, leads -----------------------------------------------------------------------------------------------


def _toothed(plan: Plan, shape: StageShape) -> list[ToothedGear]:
    """The gears of a stage as the phasing of the train takes them."""
    gears = []
    for name, member in plan.gears.items():
        fit = member.clocking is None or isinstance(member.clocking, str)
        angles = () if fit else per_branch(member.clocking, len(plan.angles), f"{plan.member_path(name)}.clocking")  # type: ignore[arg-type]
        gears.append(
            ToothedGear(
                name=name,
                teeth=member.teeth or 0,
                internal=member.kind == "ring",
                central=plan.central(name),
                profile_shift=next(iter(shape.gears[name].values())).profile_shift,
                on=gear_below(member),
                clocking=None if fit else tuple(turns_of(angle) for angle in angles),
            )
        )
    return gears


def _tooth_meshes(shape: StageShape, flanks: Mapping[str, int]) -> list[ToothMesh]:
    """The pairs of a stage as the phasing of the train takes them."""
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


def _flanks(plan: Plan, gears: Sequence[ToothedGear], kinematics: Kinematics) -> dict[str, int]:
    """Flank d of every pair: from the torque it passes; without torques +1 at the first central gear."""
    torques = {p.name: (kinematics.mesh_torque or {}).get(p.path, 0.0) for p in plan.pairs}
    largest = max(abs(torque) for torque in torques.values())
    if largest == 0.0:
        signs = chain_flanks(gears, [(p.a, p.b) for p in plan.pairs], 1)
        return {p.name: sign for p, sign in zip(plan.pairs, signs, strict=True)}
    return {p.name: flank_of_torque(torques[p.name], internal=p.internal) for p in plan.pairs}


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


def _axial_pitches(shape: StageShape, p: GearPair, side: str | None) -> float:
    """Axial pitches from the plane of the first mesh of the chain, in which its phases are taken, to that of a pair."""
    plan, teeth = shape.plan, shape.teeth[p.a]
    first = next(q for q in plan.pairs if plan.chains[q.a] == plan.chains[p.a])
    apart = shape.meshes[p.name].station[side] - shape.meshes[first.name].station[side]
    return apart * math.sin(teeth.helix_angle) / (math.pi * teeth.module)


def _leads(
    plan: Plan, p: GearPair, side: str | None, phases: StagePhases, sense: int, advance: float, log: ResolutionLog
) -> tuple[Number, ...]:
    """Lead of every branch: given as `phase`, else from teeth and angles; staggered on the right unless given there.

    advance : by the helix, of a mesh off the plane of the phases [mesh cycles].
    """
    path = f"{p.path}.{side}.phase" if side else f"{p.path}.phase"
    given = stated(p.levels(side), "phase")
    leads = phases.lead[p.name]
    if advance:
        leads = tuple((float(lead) + advance) % 1 for lead in leads)
    if given is not None:
        values = per_branch(given.value, len(plan.angles), given.path)
        leads = tuple(_fraction(value) % 1 for value in values)
        log.note(given.path, [float(lead) for lead in leads], "cycles")
        if given.level == "side":
            return leads
    stagger = stated_value(plan.levels(p.a), "stagger", 0.0)
    if side == "right" and stagger:
        leads = tuple(staggered(lead, _fraction(stagger), sense) for lead in leads)
    if given is None:
        log.note(path, [float(lead) for lead in leads], "cycles", "geometry")
    return leads


def _fraction(value: float) -> Number:
    """Phase [cycles] as an exact fraction where it is one of small numbers."""
    exact = Fraction(value).limit_denominator(SHORT)
    return exact if abs(float(exact) - value) < 1e-12 else value


def _check_assembly(plan: Plan, phases: StagePhases, log: ResolutionLog) -> None:
    """Warn of planet angles at which the teeth do not meet, with the nearest angles at which they do."""
    if phases.assembles:
        return
    given, nearest = (
        ", ".join("none" if turn is None else f"{float(turn) * 360:.6g}" for turn in turns)
        for turns in (plan.angles, phases.nearest_angles)
    )
    problem = (
        f"planets at {given} deg cannot be assembled, the teeth do not meet; nearest angles {nearest} deg"
        if phases.closes
        else f"a branch cannot be assembled at any angle, the meshes around a loop within it miss each other by "
        f"{abs(float(phases.mismatch[0])):.3g} pitch; other teeth, or pin radii, close it"
    )
    log.warn(coded("not-assembled", f"{plan.path}: {problem}"))


def _check_shafts(plan: Plan, gears: Sequence[ToothedGear], meshes: Sequence[ToothMesh], log: ResolutionLog) -> None:
    """Warn where stepped shafts clocked as their places demand cannot all be alike."""
    stepped = [gear.name for gear in gears if gear.on is not None and not gear.central and gear.clocking is None]
    if not stepped:
        return
    alike = (Fraction(0),) * len(plan.angles)
    clocked = [replace(gear, clocking=alike) if gear.name in stepped else gear for gear in gears]
    if not stage_leads(clocked, meshes, sense=1).assembles:
        log.warn(
            coded(
                "shafts-not-alike",
                f"{plan.path}: identical shafts of {', '.join(stepped)} do not fit all branches; "
                "each is clocked as its place demands",
            )
        )


# slices ---------------------------------------------------------------------------------------------------------------


def _slice_count(
    plan: Plan, p: GearPair, width: Mapping[str | None, float], tilting: Mapping[str, str], log: ResolutionLog
) -> int:
    """Slices of each helix of a pair: given, else `SLICES` where bodies of it may tilt against each other, else 1.

    width : of the helices, by side [m].  tilting : as of `meshes_of_stage`.

    Raises
    ------
    ModelError : a mesh is to be cut whose face width is not known.
    """
    given, path = p.keys.slices, f"{p.path}.slices"
    numbers = range(1, plan.branches + 1) or (None,)
    ends = [(_body(plan, p.a, i, side), _body(plan, p.b, i, side)) for i in numbers for side in width]
    tilts, unknown = any(tilting[a] != tilting[b] for a, b in ends), any(map(math.isnan, width.values()))
    if given is not None:
        log.note(path, given)
        if given == 1 and tilts:
            log.warn(
                coded(
                    "tilt-without-slices",
                    f"{path}: 1, but {p.a} and {p.b} may tilt against each other: a mesh of one row has no stiffness "
                    f"against tilt and shows no load along the face; left out, it is {SLICES}",
                )
            )
        if given > 1 and unknown:
            raise ModelError(
                "is missing: slices of a mesh need it",
                path=f"{plan.path}.face_width",
                given=f"slices = {given}",
                allowed="m",
            )
        return given
    if not tilts:
        return 1
    if unknown:
        log.warn(
            coded(
                "tilt-without-slices",
                f"{plan.path}.face_width: is missing; without it the mesh {p.name} is one row, which has no stiffness "
                f"against tilt, although {p.a} and {p.b} may tilt against each other",
            )
        )
        return 1
    log.note(path, SLICES, "", "default")
    return SLICES


def _slices_of(mesh: Mesh, count: int, narrow: NDArray[np.complex128] | None) -> tuple[MeshSlice, ...]:
    """The slices of a mesh, left to right; none for a count of 1.

    The helix brings a slice at zeta from mid-face into contact at sigma + d h zeta/p_x, and zeta/p_x is zeta times the
    overlap ratio per face width.  A series computed from the teeth adds up to the whole exactly, because
    sinc(l eps/n) times the sum of their phases is n sinc(l eps).  A series that the file gives is that of the whole
    mesh: every slice follows it in step, since shifted it would no longer add up to what is given.

    narrow : the series of a slice without width, as computed; None: a given one.
    """
    if count == 1:
        return ()
    middles = (np.arange(count) + 0.5) / count - 0.5
    shift = np.zeros(count)
    variation: NDArray[np.complex128] = mesh.variation
    if narrow is not None and mesh.hand:
        shift = mesh.sense * mesh.flank * mesh.hand * mesh.overlap_ratio * middles
        variation = face_average(narrow, mesh.overlap_ratio / count)
    return tuple(
        MeshSlice(
            station=mesh.station + mesh.width * z, lead=mesh.lead + turn if turn else mesh.lead, variation=variation
        )
        for z, turn in zip(middles.tolist(), shift.tolist(), strict=True)
    )
