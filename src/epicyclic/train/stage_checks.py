"""Checks of a stage, and what turns and loads the train.

What a stage cannot be, and what is doubtful about it: room for the planets, one centre distance for all meshes.

What turns and what loads the train: kinematics, torques on bodies, loads, gravity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations, product

import numpy as np

from ..document.schema import SIDES, ModelFile
from ..errors import ModelError
from ..teeth import geometry
from ..warning_codes import coded
from .bodies import Body
from .centres import StageShape
from .gears import half_station, width_of
from .kinematics import Gearing, Kinematics, Tie, solve_kinematics
from .phasing import disc_gaps
from .stage_bodies import member_centre
from .stages import GearPair, Plan, gear_below
from .train import Load, ResolutionLog

# Tooth heights of rim outside the root circle.  From there on the rim-thickness factor of [iso6336], part 3, is 1 for
# external teeth: the rim then carries like a solid body.  Quoted from memory; for internal teeth the same part sets the
# limit at 3.5 modules as far as remembered, 1.6 tooth heights, so what is warned of here is thin by either.
THIN_RIM = 1.2
ONE_DISTANCE = 1e-6  # relative; distances computed twice agree to rounding, printed radii do not


def check_stage(shape: StageShape, log: ResolutionLog) -> None:
    """Check one stage: gears that overlap, rings, and whether the distances of all meshes agree.

    Raises
    ------
    ModelError : planets collide, gears in one plane overlap without meshing, a ring smaller than what turns in it;
        warnings instead where radii are given.
    """
    plan = shape.plan
    given = any(m.base_radius is not None or m.pin_radius is not None for m in plan.stage.members.values())
    for p in plan.pairs:
        if p.internal:
            _check_ring(shape, p, given, log)
    _check_rims(shape, log)
    _check_neighbours(shape, given, log)
    _check_distances(shape, log)


def _complain(problem: str, path: str, given: bool, log: ResolutionLog, *, code: str, value: str, allowed: str) -> None:
    """Raise ModelError, or warn where stated radii allow what teeth and module do not."""
    if given:
        log.warn(coded(code, f"{path}: {problem} ({value})"))
    else:
        raise ModelError(problem, path=path, given=value, allowed=allowed)


def _check_ring(shape: StageShape, p: GearPair, given: bool, log: ResolutionLog) -> None:
    """Check that a planet has room in its ring: roots clear of tips."""
    planet, ring = (next(iter(shape.gears[name].values())) for name in (p.a, p.b))
    room = geometry.radial_clearance(_axes(shape, p), planet.tip_radius, ring.root_radius, internal=True)
    if room < -planet.module:
        _complain(
            f"the ring is smaller than {p.a}, which turns in it",
            f"{shape.plan.member_path(p.b)}.teeth",
            given,
            log,
            code="ring-too-small",
            value=str(ring.teeth),
            allowed=f"a root radius above {(ring.root_radius - room) * 1e3:.4g} mm; "
            f"it is {ring.root_radius * 1e3:.4g} mm",
        )
    elif room < 0:
        log.warn(
            coded("tips-in-roots", f"{p.path}: the tips of {p.a} reach {-room * 1e3:.3g} mm into the roots of {p.b}")
        )


def _check_rims(shape: StageShape, log: ResolutionLog) -> None:
    """Warn of a ring that is too thin to keep its shape."""
    for name, member in shape.plan.gears.items():
        gear = next(iter(shape.gears[name].values()))
        height = gear.root_radius - gear.tip_radius
        rim = member.rim if member.outer_diameter is None else member.outer_diameter / 2 - gear.root_radius
        if rim is not None and rim < THIN_RIM * height:
            key = "rim" if member.outer_diameter is None else "outer_diameter"
            log.warn(
                coded(
                    "thin-rim",
                    f"{shape.plan.member_path(name)}.{key}: the rim is {max(rim, 0.0) / height:.3g} tooth heights "
                    f"thick, below {THIN_RIM:g} it bends between the planets; it is computed as rigid",
                )
            )


def _axes(shape: StageShape, p: GearPair) -> float:
    """Distance between the axes of a pair [m]."""
    return math.dist(shape.place(p.a, 0), shape.place(p.b, 0))


def _check_neighbours(shape: StageShape, given: bool, log: ResolutionLog) -> None:
    """Tip circles of external gears that neither mesh nor share a shaft must not overlap in one plane.

    Gears of one plane: the file states where one of them stands along the axis and their faces overlap, or both are
    planet gears that lie beside each other.  Where no axial place is stated, two suns of a chain of meshes show that
    it has several planes (Ravigneaux), and a chain behind a stepped shaft lies in another one; else a doubt is said.
    """
    plan = shape.plan
    gears = [(name, i) for name, m in plan.gears.items() if m.kind != "ring" for i in _branches(plan, name)]
    tips = [next(iter(shape.gears[name].values())).tip_radius for name, _ in gears]
    gaps = disc_gaps(np.array([shape.place(name, i) for name, i in gears]).reshape(-1, 2), np.array(tips))
    told: set[tuple[str, str]] = set()
    for (i, (a, branch_a)), (j, (b, branch_b)) in combinations(enumerate(gears), 2):
        same = branch_a == branch_b or plan.central(a) or plan.central(b)
        if gaps[i, j] >= 0 or (a, b) in told or (same and _joined(plan, a, b)) or _apart(plan, a, b):
            continue
        told.add((a, b))
        beside = not plan.central(a) and not plan.central(b) and (a == b or (plan.axis[a], plan.axis[b]) == (a, b))
        text = (
            f"{_numbered(plan, a, branch_a)} and {_numbered(plan, b, branch_b)} overlap by {-gaps[i, j] * 1e3:.4g} mm"
        )
        _say_overlap(shape, given, log, pair=(a, b), beside=beside, text=text)
        if beside:
            return


def _branches(plan: Plan, gear: str) -> range:
    return range(1 if plan.central(gear) else plan.branches)


def _numbered(plan: Plan, gear: str, branch: int) -> str:
    return gear if plan.central(gear) else f"{gear} {branch + 1}"


def _joined(plan: Plan, a: str, b: str) -> bool:
    """Whether two gears of one branch mesh or turn as one."""
    return plan.axis[a] == plan.axis[b] or any({p.a, p.b} == {a, b} for p in plan.pairs)


def _apart(plan: Plan, a: str, b: str) -> bool:
    """Whether the stated axial places keep two gears in different planes."""

    def faces(gear: str) -> list[tuple[float, float]]:
        """Axial ends of its faces [m]; a width that is not stated is none."""
        sides = SIDES if plan.two_sided(gear) else (None,)
        places = [(half_station(plan, gear, side), (width_of(plan, gear, side) or 0.0) / 2) for side in sides]
        return [(at - half, at + half) for at, half in places]

    pairs = list(product(faces(a), faces(b)))
    return all(x != y and (x[1] <= y[0] or y[1] <= x[0]) for x, y in pairs)


def _say_overlap(
    shape: StageShape, given: bool, log: ResolutionLog, *, pair: tuple[str, str], beside: bool, text: str
) -> None:
    """Refuse two gears that overlap in one plane; warn where the file does not say that it is one."""
    plan = shape.plan
    if beside:
        _complain(
            "planets collide",
            f"{plan.path}.planets" if plan.stage.planet_angles is None else f"{plan.path}.planet_angles",
            given,
            log,
            code="planets-collide",
            value=f"{plan.branches}; {text}",
            allowed="fewer planets, or smaller ones",
        )
        return
    stated = [name for name in pair if plan.stage.members[name].station is not None]
    suns = [name for name, m in plan.gears.items() if m.kind == "sun" and plan.chains[name] == plan.chains[pair[0]]]
    if stated:
        _complain(
            "gears overlap without meshing",
            f"{plan.member_path(stated[0])}.station",
            given,
            log,
            code="gears-overlap",
            value=text,
            allowed="axial places that keep their faces apart, or other teeth",
        )
    elif plan.chains[pair[0]] == plan.chains[pair[1]] and len(suns) < 2:
        log.warn(
            coded(
                "gears-overlap",
                f"{plan.path}: {text} without meshing; station of each says whether they stand in different planes",
            )
        )


def _check_distances(shape: StageShape, log: ResolutionLog) -> None:
    """Warn where the radii and working angles of the meshes fit no single place of the axes."""
    plan, differs, texts = shape.plan, False, []
    for p in plan.pairs:
        a, b = shape.teeth[p.a].base_radius, shape.teeth[p.b].base_radius
        by_teeth = (b - a if p.internal else b + a) / math.cos(shape.meshes[p.name].working_angle)
        between = _axes(shape, p)
        differs |= abs(by_teeth - between) > ONE_DISTANCE * between
        texts.append(f"{p.name} {by_teeth * 1e3:.6g} mm (axes {between * 1e3:.6g} mm)")
    if differs:
        log.warn(
            coded(
                "centre-distances-differ",
                f"{plan.path}: centre distances differ, base radii and working angles fit no single one: "
                f"{', '.join(texts)}; turning as a whole then stresses the teeth",
            )
        )


def member_of(reference: str, model: ModelFile) -> str:
    """Member of a reference without its side."""
    return reference if reference in model.bodies else ".".join(reference.split(".")[:2])


def gearings_of(plans: Sequence[Plan]) -> tuple[Gearing, ...]:
    """Every pair of members that mesh, for the kinematics."""
    return tuple(
        Gearing(
            pair=p.path,
            stage=plan.name,
            a=f"{plan.name}.{p.a}",
            b=f"{plan.name}.{p.b}",
            teeth_a=plan.gears[p.a].teeth or 0,
            teeth_b=plan.gears[p.b].teeth or 0,
            internal=p.internal,
            carrier=_carrier(plan) if not (plan.central(p.a) and plan.central(p.b)) else None,
        )
        for plan in plans
        for p in plan.pairs
    )


def kinematics_of(model: ModelFile, plans: Sequence[Plan], log: ResolutionLog) -> Kinematics:
    """Solve speeds and torques.

    Raises
    ------
    ModelError : speeds or torques that are too few, too many or contradicting.
    """
    operation = model.operation
    members = [f"{plan.name}.{name}" for plan in plans for name in plan.stage.members] + list(model.bodies)
    planets = {f"{plan.name}.{name}" for plan in plans for name in plan.gears if not plan.central(name)}
    torques: dict[str, float] = {}
    balance: list[str] = []
    for name, value in operation.torque.items():
        member = member_of(name, model)
        log.note(f"operation.torque.{name}", value, "N m")
        if isinstance(value, str):
            balance.append(member)
        else:
            torques[member] = torques.get(member, 0.0) + value
    powers: dict[str, float] = {}
    for name, power in operation.power.items():
        member = member_of(name, model)
        powers[member] = powers.get(member, 0.0) + power
        log.note(f"operation.power.{name}", power, "W")
    speeds: dict[str, Fraction] = {}  # exact, in revolutions per minute
    for name, speed in operation.speed.items():
        speeds[member_of(name, model)] = Fraction(speed * 30 / math.pi).limit_denominator(10**6)
        log.note(f"operation.speed.{name}", speed, "rad/s")
    return solve_kinematics(
        members=members,
        gearings=gearings_of(plans),
        ties=ties_of(model, plans),
        held=list(dict.fromkeys(member_of(name, model) for name in operation.held)),
        speeds=speeds,
        torques=torques,
        powers=powers,
        balance=balance,
        carriers={plan.name: _carrier(plan) for plan in plans},
        ends=[name for name in members if name not in planets],
    )


def _carrier(plan: Plan) -> str | None:
    """Full path of the carrier of a stage, None where the axes stand in the housing."""
    return None if plan.carrier is None else f"{plan.name}.{plan.carrier}"


def ties_of(model: ModelFile, plans: Sequence[Plan]) -> tuple[Tie, ...]:
    """Every coupling and shaft that makes two members turn together, for the kinematics."""
    shafts = [
        Tie(name=f"{plan.name}.{name}", a=f"{plan.name}.{below}", b=f"{plan.name}.{name}")
        for plan in plans
        for name, member in plan.gears.items()
        if (below := gear_below(member)) is not None
    ]
    joined = [
        Tie(name=name, a=member_of(table.between[0], model), b=member_of(table.between[1], model))
        for name, table in model.couplings.items()
        if table.rz is None or table.rz.value != 0.0
    ]
    return (*shafts, *(tie for tie in joined if tie.a != tie.b))


def body_torques(model: ModelFile, kinematics: Kinematics, bodies: Sequence[Body]) -> dict[str, float]:
    """External torque on each body that carries one [N m]: on a split member half each, unless a side is named."""
    if kinematics.torque is None:
        return {}
    torques: dict[str, float] = {}
    for member, torque in kinematics.torque.items():
        pieces = [body for body in bodies if body.member == member]
        if member in kinematics.held or not pieces:
            continue
        shares = _sided_torques(member, model, kinematics)
        if shares and pieces[0].side is None:
            key = "torque" if any(f"{member}.{side}" in model.operation.torque for side in SIDES) else "power"
            raise ModelError(
                "names a side of a member in one piece",
                path=f"operation.{key}.{member}",
                allowed="the member, or split",
            )
        for body in pieces:
            value = shares.get(body.side, 0.0) if shares else torque / len(pieces)
            if value:
                torques[body.name] = value
    return torques


def _sided_torques(member: str, model: ModelFile, kinematics: Kinematics) -> dict[str | None, float]:
    """Torque of each half [N m] where the file names sides: as stated, the rest at the balancing half or halved."""
    operation = model.operation
    torques = {s: operation.torque[f"{member}.{s}"] for s in SIDES if f"{member}.{s}" in operation.torque}
    powers = {s: operation.power[f"{member}.{s}"] for s in SIDES if f"{member}.{s}" in operation.power}
    if not torques and not powers:
        return {}
    halves: dict[str | None, float] = {s: v for s, v in torques.items() if isinstance(v, float)}
    omega = float((kinematics.speed or {}).get(member, 0)) * math.pi / 30
    halves |= {s: power / omega for s, power in powers.items() if omega}
    takers = [s for s in torques if s not in halves]
    rest = (kinematics.torque or {})[member] - sum(halves.values())
    takers = takers or (["left", "right"] if member in operation.torque else [])
    for side in takers:
        halves[side] = halves.get(side, 0.0) + rest / len(takers)
    return halves


def external_loads(model: ModelFile, bodies: Sequence[Body]) -> list[Load]:
    """The file's loads: on a split member half on each half, on a planet gear the same on every planet."""
    loads = []
    for name, table in model.loads.items():
        parts = table.on.split(".")
        pieces = [b for b in bodies if b.member == ".".join(parts[:2]) and (len(parts) < 3 or b.side == parts[2])]
        share = 0.5 if len(parts) < 3 and any(b.side for b in pieces) else 1.0
        force, moment = ((v.x * share, v.y * share, v.z * share) for v in (table.force, table.moment))
        for body in pieces:
            loads.append(
                Load(
                    path=f"loads.{name}",
                    body=body.name,
                    force=force,
                    moment=moment,
                    station=member_centre(body, model) + table.at,
                    turns=table.frame == "member",
                )
            )
    return loads


def gravity_of(model: ModelFile, log: ResolutionLog) -> tuple[float, float, float]:
    """Acceleration of gravity in housing axes [m/s^2]."""
    if model.operation.gravity is None:
        return 0.0, 0.0, 0.0
    log.note("operation.gravity", list(model.operation.gravity), "m/s^2")
    x, y, z = model.operation.gravity
    return x, y, z
