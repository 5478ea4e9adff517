"""Bodies and meshes of a stage: where bodies are, what they weigh, and how their teeth meet.

Bodies that are joined rigidly in tilt, also by two bearings at a distance, are one group; a mesh between groups is cut
into slices.  Meshes have flank, phase lead, stiffness and its variation, branch by branch and side by side.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from operator import add
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..document.schema import MemberTable, ModelFile
from ..document.schema_fields import ForceTableOf, LinkTable
from ..document.units import Quantity
from ..errors import ModelError, in_mm
from ..teeth.mesh_stiffness import ToothPair, face_average
from .centres import StageShape
from .elastic_bodies import ring_of
from .gears import half_station
from .kinematics import Kinematics, merged, spread, tones
from .mesh_laws import MeshLaw, MeshSide, mesh_law, tooth_pair
from .phasing import StagePhases, ToothedGear, ToothMesh, chain_signs, flank_of_torque, shift_of, stage_leads, staggered
from .stages import GearPair, Plan, density_of, gear_below, member_material, sides_of, stated, stated_value
from .train import (
    HOUSING,
    MASS_UNITS,
    NAN,
    Body,
    Frame,
    GearData,
    Link,
    Mesh,
    MeshSlice,
    Number,
    ResolutionLog,
    bodies_named,
    of_branch,
    per_branch,
    turns_of,
)

# A mesh of stiffness k and face width b in n equal slices, each a row at its middle, has about mid-face the tilt
# stiffness k b^2/12 (1 - 1/n^2): the least n at which it is right to 1 %.
SLICES = 10
_SPRINGS = {"rx": "y", "ry": "x"}  # tilt -> direction of the springs that hold it at a distance


def held_by_distance(tables: Sequence[LinkTable], branch: int | None) -> set[str]:
    """Tilts (rx, ry) that the bearings of one site hold by their places: two or more with springs at different `at`.

    Springs k_i along y at the places z_i hold rx with sum k_i z_i^2 about z = 0, springs along x hold ry.

    branch : of the site (1 ..), for stiffnesses per planet.
    """
    return {
        tilt
        for tilt, spring in _SPRINGS.items()
        if len({table.at or 0.0 for table in tables if _presses(table, spring, branch)}) > 1
    }


def _presses(table: LinkTable, spring: str, branch: int | None) -> bool:
    """Whether a table has a stiffness along x or y [N/m], of one planet, that is not 0, or parts that press."""
    stated = getattr(table, spring)
    if stated is None:
        return spring in table.directions()
    return isinstance(stated, ForceTableOf) or of_branch(stated, branch) != 0.0


def tilt_groups(bodies: Sequence[Body], links: Sequence[Link], misaligned: Collection[str] = ()) -> dict[str, str]:
    """Group of every body, by name: bodies of one group cannot tilt against each other; "" is that of the frames.

    Links of the same two bodies count together, so that two rigid bearings at a distance join them in tilt.  Bodies
    that only a loop over further bodies joins rigidly stand apart.

    misaligned : names of bodies whose seats are tilted, which join them to nothing here.
    """
    joined: dict[tuple[str, str], list[Link]] = {}
    for link in links:
        if seated(link) not in misaligned:
            joined.setdefault((link.first, link.second or ""), []).append(link)
    rigid = [ends for ends, between in joined.items() if _rigid(between)]
    return merged({body.name: body.name for body in bodies} | {"": ""}, rigid)  # "" sorts first


def seated(link: Link) -> str:
    """Body whose seat a link is; "" of a joint between bodies."""
    if link.kind == "bearing":
        return link.second or link.first
    return {"support": link.first, "shaft": link.second or ""}.get(link.kind, "")


def _rigid(links: Sequence[Link]) -> bool:
    """Whether the rigid directions of links between two bodies leave no tilt of one against the other."""
    if any(math.isinf(link.stiffness[3]) and math.isinf(link.stiffness[4]) for link in links):
        return True
    rows = [link_row(link, d, (0.0, 0.0, 0.0)) for link in links for d in range(6) if math.isinf(link.stiffness[d])]
    if len(rows) < 2:
        return False
    tilts = np.eye(6)[3:5]
    return bool(np.linalg.matrix_rank(np.array(rows)) == np.linalg.matrix_rank(np.array([*rows, *tilts])))


def link_row(link: Link, direction: int, origin: tuple[float, float, float]) -> NDArray[np.float64]:
    """Row [n, r x n] of a direction of a link, or [0, n] of an angle, about an origin [m] of its frame, (6,)."""
    cosine, sine = math.cos(link.angle), math.sin(link.angle)
    normal = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])[direction % 3]
    if direction >= 3:
        return np.concatenate([np.zeros(3), normal])
    return np.concatenate([normal, np.cross(np.subtract((*link.centre, link.station), origin), normal)])


# bodies ---------------------------------------------------------------------------------------------------------------

# Least bore per pitch circle: a body held on less has, in double precision, no stiffness about it.
_BORE = 1e-3


def body_name(stage: str, member: str, branch: int | None = None, side: str | None = None) -> str:
    """Name of a body, ``stage/member[/branch][/side]``."""
    return "/".join(str(part) for part in (stage, member, branch, side) if part is not None)


def member_bodies(plan: Plan, member: str, branch: int | None) -> dict[str | None, str]:
    """Names of the bodies of a member (of one branch, counted from 1), by side."""
    return {side: body_name(plan.name, member, branch, side) for side in sides_of(plan, member)}


def piece_of(plan: Plan, member: str, number: int | None, side: str | None) -> str:
    """Name of the body of a member (of one branch, counted from 1) on one side; of a split one without a side left."""
    half = (side or "left") if plan.split(member) else None
    return body_name(plan.name, member, None if plan.central(member) else number, half)


def member_centre(body: Body, model: ModelFile) -> float:
    """Axial place of the centre of a body's member [m], from which places in the file count: of halves the middle."""
    if body.side is None:
        return body.station
    stage, name = body.member.split(".")
    return model.stages[stage].members[name].station or 0.0


def frames_of(plans: tuple[Plan, ...]) -> tuple[Frame, ...]:
    """The frame of every stage, and the housing."""
    stages = tuple(Frame(name=p.name, carrier=p.carrier and f"{p.name}.{p.carrier}") for p in plans)
    return (*stages, Frame(name=HOUSING))


def bodies_of_stage(shape: StageShape, model: ModelFile, log: ResolutionLog) -> Iterator[Body]:
    """All bodies of a stage: central members in file order, then the planets branch by branch."""
    plan = shape.plan
    for name in plan.stage.members:
        if plan.central(name):
            yield from _member(shape, name, None, model, log)
    for branch in range(plan.branches):
        for name in shape.pin:
            yield from _member(shape, name, branch, model, log)


def free_bodies(model: ModelFile, log: ResolutionLog) -> Iterator[Body]:
    """Bodies of the file's `[bodies]`; keys that are not stated are 0."""
    for name, body in model.bodies.items():
        given = {key: getattr(body, key) for key in (*MASS_UNITS, "station")}
        for key, value in given.items():
            origin = "default" if value is None else "given"
            log.note(f"bodies.{name}.{key}", value or 0.0, MASS_UNITS.get(key, "m"), origin)
        values: dict[str, Any] = {key: value or 0.0 for key, value in given.items()}
        yield Body(name=name, member=name, kind="body", frame=body.frame or HOUSING, **values)


def _member(shape: StageShape, name: str, branch: int | None, model: ModelFile, log: ResolutionLog) -> Iterator[Body]:
    """Bodies of one member, by side; of a planet gear those of one branch (0 ..)."""
    plan, member = shape.plan, shape.plan.stage.members[name]
    path, number = plan.member_path(name), None if branch is None else branch + 1
    if name not in plan.gears:
        log.note(f"{path}.split", plan.split(name), "", "default" if member.split is None else "given")
    if name == plan.carrier:
        log.note(f"{path}.pin_radius", shape.pin_radius, "m", "geometry" if member.pin_radius is None else "given")
    radius = shape.gear(name).base_radius if name in plan.gears else shape.pin_radius
    for side, body in member_bodies(plan, name, number).items():
        gear = shape.gears[name][side] if name in plan.gears else None
        rim = _radii(member, gear)[0] if gear is not None and gear.internal else NAN
        masses = _masses(plan, name, side, gear, radius, model)
        ring = None
        if member.elastic is not None and gear is not None:
            of_rim, material = (rim, _width(gear, side)), member_material(plan, name, model)
            ring = ring_of(member.elastic, f"{path}.elastic", gear, of_rim, masses["mass"], material, log)
        if not branch:
            _log_masses(plan, name, side, masses, log)
        yield Body(
            name=body,
            member=f"{plan.name}.{name}",
            kind=member.kind,
            frame=plan.name,
            carried_by=None if number is None or plan.carrier is None else piece_of(plan, plan.carrier, None, side),
            branch=number,
            side=side,
            centre=shape.place(name, branch or 0) if name in plan.gears else (0.0, 0.0),
            station=half_station(plan, name, side),
            angle=shape.polar(name, branch or 0) if name in plan.gears else 0.0,
            **masses,
            reference_radius=radius if math.isfinite(radius) else 1.0,
            outer_radius=rim if math.isfinite(rim) else None,
            gear=gear,
            elastic=ring,
        )


# mass and inertia ---------------------------------------------------------------------------------------------------


def _masses(
    plan: Plan, name: str, side: str | None, gear: GearData | None, radius: float, model: ModelFile
) -> dict[str, Any]:
    """Mass [kg] and inertias [kg m^2] of one body by key: stated, else of the solid of the gear; nan where not known.

    A hollow cylinder: m = rho pi (r_o^2 - r_i^2) l, J_p = m (r_o^2 + r_i^2)/2, J_d = J_p/2 + m l^2/12.

    Raises
    ------
    ModelError : a bore or outer diameter that leaves no solid beside the pitch circle.
    """
    member = plan.stage.members[name]
    mass, inertia, tilt = (_stated_inertia(plan, name, side, key, radius) for key in MASS_UNITS)
    outer, inner = _radii(member, gear)
    width = _width(gear, side)
    if inner >= outer:
        key = "outer_diameter" if gear is not None and gear.internal else "bore"
        limit = f"{'above' if key != 'bore' else 'below'} {(gear.reference_radius if gear else NAN) * 2e3:.6g} mm"
        path = f"{plan.member_path(name)}.{key}"
        given = in_mm(getattr(member, key) or 0.0)
        raise ModelError("leaves no solid beside the pitch circle", path=path, given=given, allowed=limit)
    if 0 < inner < _BORE * outer and not (gear is not None and gear.internal):
        raise ModelError(
            "is no bore of a gear",
            path=f"{plan.member_path(name)}.bore",
            given=in_mm(member.bore or 0.0),
            allowed=f"0, or from {2e3 * _BORE * outer:.2g} mm, a thousandth of the pitch circle",
        )
    if mass is None:
        mass = density_of(member_material(plan, name, model)) * math.pi * (outer**2 - inner**2) * width
    if inertia is None:
        inertia = 0.5 * mass * (outer**2 + inner**2)
    if tilt is None:
        tilt = inertia / 2 + mass * width**2 / 12
    return {"mass": mass, "inertia": inertia, "tilt_inertia": tilt}


def _width(gear: GearData | None, side: str | None) -> float:
    """Width of the solid of a gear or of one half of it [m], nan where it is not known."""
    # the gap counts, to one half its half
    return NAN if gear is None else gear.whole_width + (0.0 if side is None else gear.gap / 2)


def _stated_inertia(plan: Plan, name: str, side: str | None, key: str, radius: float) -> float | None:
    """Stated mass [kg] or inertia [kg m^2] of a body; an inertia in kg is J/r^2 at `radius` [m]."""
    value = stated_value(plan.member_levels(name, side), key, None)
    if isinstance(value, Quantity):
        assert isinstance(value.value, float)  # the schema takes no list here
        value = value.value * (radius**2 if value.unit == "kg" else 1.0)
    return None if value is None else float(value)


def _radii(member: MemberTable, gear: GearData | None) -> tuple[float, float]:
    """Outer and inner radius of the solid of a gear [m]: to its pitch circle, of a ring from its pitch circle."""
    if gear is None:
        return NAN, NAN
    if not gear.internal:
        return gear.reference_radius, (member.bore or 0.0) / 2
    if member.outer_diameter is not None:
        return member.outer_diameter / 2, gear.reference_radius
    return (NAN if member.rim is None else gear.root_radius + member.rim), gear.reference_radius


def _log_masses(plan: Plan, name: str, side: str | None, masses: Mapping[str, float], log: ResolutionLog) -> None:
    """Log mass and inertias; of a half at the path of the member, or of the side where that states its own."""
    member, path = plan.stage.members[name], plan.member_path(name)
    tables = [table for table in (member.left, member.right) if table is not None]
    by_side = side is not None and any(
        getattr(table, key) is not None for table in tables for key in (*MASS_UNITS, "face_width")
    )
    for key, value in masses.items():
        where = f"{path}.{side}.{key}" if by_side else f"{path}.{key}"
        source = stated(plan.member_levels(name, side), key)
        origin = "geometry" if source is None else "given" if source.path == where else f"as {name}"
        log.note(where, value, MASS_UNITS[key], origin if math.isfinite(value) else "missing")


# places ---------------------------------------------------------------------------------------------------------------


def coaxial(bodies: Sequence[Body], model: ModelFile) -> list[Body]:
    """Move stages on fixed axes, and bodies, so that what a coupling joins has one axis.

    A stage with a carrier stays around the origin; so does the first stage. What a loop of couplings leaves apart
    stays apart.
    """
    group = {body.name: body.frame if "." in body.member else body.name for body in bodies}
    fixed = [name for name, stage in model.stages.items() if any(m.kind == "carrier" for m in stage.members.values())]
    joined = [[bodies_named(end, bodies)[0] for end in table.between] for table in model.couplings.values()]
    joints = [
        (group[a.name], group[b.name], complex(*a.centre) - complex(*b.centre))
        for a, b in (*joined, *(ends[::-1] for ends in joined))
    ]
    offset = spread(dict.fromkeys([*fixed, next(iter(model.stages))], 0j), joints, add)
    by = {name: offset.get(start, 0j) for name, start in group.items()}
    return [
        replace(body, centre=(body.centre[0] + by[body.name].real, body.centre[1] + by[body.name].imag))
        if by[body.name]
        else body
        for body in bodies
    ]


# meshes ---------------------------------------------------------------------------------------------------------------

SHORT = 10**4  # a phase in the file this near to a fraction of small numbers is that fraction


def meshes_of_stage(
    shape: StageShape,
    model: ModelFile,
    kinematics: Kinematics,
    tilting: Mapping[str, str],
    log: ResolutionLog,
) -> list[Mesh]:
    """All meshes of a stage.

    tilting : group of every body, see `tilt_groups`.

    Raises
    ------
    ModelError : a stiffness that cannot be computed from what is given.
    """
    plan = shape.plan
    gears = list(_toothed(plan, shape))
    flanks = _flanks(plan, gears, kinematics)
    sense = _sun_sense(plan, kinematics)
    toothed = _tooth_meshes(shape, flanks)
    phases = stage_leads(gears, toothed, sense=sense)
    _check_assembly(plan, phases, log)
    _check_shafts(plan, gears, toothed, log)
    for name, turns in phases.clocking.items():
        origin = "given" if isinstance(plan.gears[name].clocking, tuple) else "geometry"
        log.note(f"{plan.member_path(name)}.clocking", [math.tau * float(turn) for turn in turns], "rad", origin)
    meshes: list[Mesh] = []
    named = tones(kinematics.gearings, kinematics.ratio)
    for p, meeting in zip(plan.pairs, toothed, strict=True):
        # c of gear a in this mesh [pitches], see `teeth.geometry`
        shift = shift_of(meeting, next(gear for gear in gears if gear.name == p.a))
        count = _slice_count(plan, p, shape.meshes[p.name].width, tilting, log)
        for side in shape.meshes[p.name].width:
            at = MeshSide(shape, p, side, model, kinematics.mesh_torque, log)
            teeth = tooth_pair(at)
            hand = -shape.gear(p.a).hand if side == "right" else shape.gear(p.a).hand
            signs = hand, flanks[p.name], phases.sense[p.name]
            law = mesh_law(at, teeth=teeth, lean=flanks[p.name] * hand)
            leads = _leads(plan, p, side, phases, sense, math.prod(signs) * _axial_pitches(shape, p, side), log)
            for branch in range(plan.branches_of(p)):
                mesh = _mesh(at, branch, law, signs, leads[branch], named[p.path], teeth)
                slices = _slices_of(mesh, count, law.narrow)
                meshes.append(replace(mesh, tooth_shift=2 * shift, slices=slices))
    return sorted(meshes, key=lambda mesh: ([p.path for p in plan.pairs].index(mesh.pair), mesh.branch or 0))


def _mesh(
    at: MeshSide,
    branch: int,
    law: MeshLaw,
    signs: tuple[int, int, int],
    lead: Number,
    tone: str,
    teeth: ToothPair | None,
) -> Mesh:
    """Mesh of one branch (0 ..) and side, without slices and the shift of its teeth.

    signs : hand of gear a on this side, flank d and sense D (docs/conventions.md, rows and phases).
    tone : stage whose mesh frequency it follows.
    """
    shape, p, side = at.shape, at.pair, at.side
    plan, meshing, (hand, flank, sense) = shape.plan, at.meshing, signs
    a, b = shape.gear(p.a), shape.gear(p.b)
    number = branch + 1 if plan.branches and not (plan.central(p.a) and plan.central(p.b)) else None
    direction = shape.directions[p.name][branch]
    turns = float(direction if isinstance(direction, (int, float, Fraction)) else direction.value)
    cosine = math.cos(meshing.working_angle)
    return Mesh(
        name=body_name(plan.name, p.name, number, side),
        pair=p.path,
        stage=tone,
        branch=number,
        side=side,
        a=piece_of(plan, p.a, number, side),
        b=piece_of(plan, p.b, number, side),
        internal=p.internal,
        direction=math.tau * turns,
        pressure_angle=meshing.working_angle,
        base_helix=a.base_helix,
        hand=hand,
        flank=flank,
        station=meshing.station[side],
        width=at.width,
        radius_a=a.base_radius / cosine,
        radius_b=b.base_radius / cosine,
        stiffness=law.stiffness[branch],
        variation=law.variation,
        lead=lead,
        sense=sense,
        damping=at.value("damping", 0.0),
        backlash=at.value("backlash", math.inf),
        contact_ratio=meshing.contact_ratio,
        limits=meshing.limits,
        teeth=teeth,
        table=law.table,
        overlap_ratio=at.overlap,
    )


# flanks, senses, leads -----------------------------------------------------------------------------------------------


def _toothed(plan: Plan, shape: StageShape) -> Iterator[ToothedGear]:
    """The gears of a stage as the phasing of the train takes them."""
    for name, member in plan.gears.items():
        stated = None if isinstance(member.clocking, str) else member.clocking
        yield ToothedGear(
            name=name,
            teeth=member.teeth or 0,
            internal=member.kind == "ring",
            central=plan.central(name),
            profile_shift=shape.gear(name).profile_shift,
            on=gear_below(member),
            clocking=None if stated is None else tuple(map(turns_of, per_branch(stated, len(plan.angles)))),
        )


def _tooth_meshes(shape: StageShape, flanks: Mapping[str, int]) -> list[ToothMesh]:
    """The pairs of a stage as the phasing of the train takes them."""
    return [
        ToothMesh(
            pair=p.name,
            a=p.a,
            b=p.b,
            directions=shape.directions[p.name],
            flank=flanks[p.name],
            normal_angle=shape.gear(p.a).pressure_angle,
            transverse_angle=shape.gear(p.a).transverse_angle,
            working_angle=shape.meshes[p.name].tooth_angle,
        )
        for p in shape.plan.pairs
    ]


def _flanks(plan: Plan, gears: Sequence[ToothedGear], kinematics: Kinematics) -> dict[str, int]:
    """Flank d of every pair: from the torque it passes; without torques +1 at the first central gear."""
    torques = {p.name: (kinematics.mesh_torque or {}).get(p.path, 0.0) for p in plan.pairs}
    largest = max(abs(torque) for torque in torques.values())
    if largest == 0.0:
        signs = chain_signs(gears, [(p.a, p.b) for p in plan.pairs], 1)
        return {p.name: sign for p, sign in zip(plan.pairs, signs, strict=True)}
    return {p.name: flank_of_torque(torques[p.name], internal=p.internal) for p in plan.pairs}


def _sun_sense(plan: Plan, kinematics: Kinematics) -> int:
    """Sign of the first gear's speed relative to the carrier; without speeds, of the first freedom turning positive.

    Of a locked train the sense in which the first gear drives its mate: both senses of a torque are alike, mirrored.
    """
    gear = f"{plan.name}.{plan.pairs[0].a}"
    if kinematics.locked:
        first = next(g for g in kinematics.gearings if g.pair == plan.pairs[0].path)
        return -1 if (kinematics.mesh_torque or {}).get(first.pair, 0.0) * first.signed_b > 0 else 1
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
    plan, teeth = shape.plan, shape.gear(p.a)
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
        values = per_branch(given.value, len(plan.angles))
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
    log.coded("not-assembled", f"{plan.path}: {problem}")


def _check_shafts(plan: Plan, gears: Sequence[ToothedGear], meshes: Sequence[ToothMesh], log: ResolutionLog) -> None:
    """Warn where stepped shafts clocked as their places demand cannot all be alike."""
    stepped = [gear.name for gear in gears if gear.on is not None and not gear.central and gear.clocking is None]
    if not stepped:
        return
    alike = (Fraction(0),) * len(plan.angles)
    clocked = [replace(gear, clocking=alike) if gear.name in stepped else gear for gear in gears]
    if not stage_leads(clocked, meshes, sense=1).assembles:
        text = f"{plan.path}: identical shafts of {', '.join(stepped)} do not fit all branches;"
        log.coded("shafts-not-alike", f"{text} each is clocked as its place demands")


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
    ends = [(piece_of(plan, p.a, i, side), piece_of(plan, p.b, i, side)) for i in numbers for side in width]
    tilts, unknown = any(tilting[a] != tilting[b] for a, b in ends), any(map(math.isnan, width.values()))
    if given is not None:
        log.note(path, given)
        if given == 1 and tilts:
            log.coded(
                "tilt-without-slices",
                f"{path}: 1, but {p.a} and {p.b} may tilt against each other: a mesh of one row has no stiffness "
                f"against tilt and shows no load along the face; left out, it is {SLICES}",
            )
        if given > 1 and unknown:
            problem = "is missing: slices of a mesh need it"
            raise ModelError(problem, path=f"{plan.path}.face_width", given=f"slices = {given}", allowed="m")
        return given
    if not tilts:
        return 1
    if unknown:
        text = f"{plan.path}.face_width: is missing; without it the mesh {p.name} is one row, which has no stiffness"
        log.coded("tilt-without-slices", f"{text} against tilt, although {p.a} and {p.b} may tilt against each other")
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
