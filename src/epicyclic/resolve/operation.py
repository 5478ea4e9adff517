"""What turns and what loads the train: kinematics, torques on bodies, loads, gravity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from ..document.schema import ModelFile
from ..errors import ModelError
from ..train.bodies import Body
from ..train.kinematics import Gearing, Kinematics, Tie, solve_kinematics
from ..train.train import Load
from .bodies import member_centre
from .plan import Plan, gear_below
from .resolution_log import ResolutionLog

__all__ = ["body_torques", "external_loads", "gearings_of", "gravity_of", "kinematics_of", "member_of", "ties_of"]


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
        powers[member_of(name, model)] = powers.get(member_of(name, model), 0.0) + power
        log.note(f"operation.power.{name}", power, "W")
    for name, speed in operation.speed.items():
        log.note(f"operation.speed.{name}", speed, "rad/s")
    return solve_kinematics(
        members=members,
        gearings=gearings_of(plans),
        ties=ties_of(model, plans),
        held=list(dict.fromkeys(member_of(name, model) for name in operation.held)),
        speeds={member_of(name, model): _rpm(speed) for name, speed in operation.speed.items()},
        torques=torques,
        powers=powers,
        balance=balance,
        carriers={plan.name: _carrier(plan) for plan in plans},
        ends=[name for name in members if name not in planets],
    )


def _carrier(plan: Plan) -> str | None:
    """Full path of the carrier of a stage, None where the axes stand in the housing."""
    return None if plan.carrier is None else f"{plan.name}.{plan.carrier}"


def _rpm(speed: float) -> Fraction:
    """An angular speed [rad/s] as an exact number of revolutions per minute."""
    return Fraction(speed * 30 / math.pi).limit_denominator(10**6)


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
    found: dict[str, float] = {}
    for member, torque in kinematics.torque.items():
        own = [body for body in bodies if body.member == member]
        if member in kinematics.held or torque == 0.0 or not own:
            continue
        shares = _sided_torques(member, model, torque)
        if shares and own[0].side is None:
            raise ModelError(
                "names a side of a member in one piece",
                path=f"operation.torque.{member}",
                allowed="the member, or split",
            )
        for body in own:
            value = shares.get(body.side, 0.0) if shares else torque / len(own)
            if value:
                found[body.name] = value
    return found


def _sided_torques(member: str, model: ModelFile, torque: float) -> dict[str | None, float]:
    """Torque of each half [N m] where the file names sides: as stated, the rest at the balancing half or halved."""
    operation = model.operation
    sided = {s: operation.torque.get(f"{member}.{s}", operation.power.get(f"{member}.{s}")) for s in ("left", "right")}
    if all(value is None for value in sided.values()):
        return {}
    given = {s: operation.torque.get(f"{member}.{s}") for s in ("left", "right")}
    found: dict[str | None, float] = {s: v for s, v in given.items() if isinstance(v, float)}
    takers = [s for s, v in sided.items() if v is not None and s not in found]
    rest = torque - sum(found.values())
    takers = takers or (["left", "right"] if member in operation.torque else [])
    for side in takers:
        found[side] = found.get(side, 0.0) + rest / len(takers)
    return found


def external_loads(model: ModelFile, bodies: Sequence[Body]) -> list[Load]:
    """The file's loads: on a split member half on each half, on a planet gear the same on every planet."""
    found = []
    for name, table in model.loads.items():
        parts = table.on.split(".")
        own = [b for b in bodies if b.member == ".".join(parts[:2]) and (len(parts) < 3 or b.side == parts[2])]
        share = 0.5 if len(parts) < 3 and any(b.side for b in own) else 1.0
        force, moment = ((v.x * share, v.y * share, v.z * share) for v in (table.force, table.moment))
        for body in own:
            found.append(
                Load(
                    path=f"loads.{name}",
                    body=body.name,
                    force=force,
                    moment=moment,
                    station=member_centre(body) + table.at,
                    turns=table.frame == "member",
                )
            )
    return found


def gravity_of(model: ModelFile, log: ResolutionLog) -> tuple[float, float, float]:
    """Acceleration of gravity in housing axes [m/s^2]."""
    if model.operation.gravity is None:
        return 0.0, 0.0, 0.0
    log.note("operation.gravity", list(model.operation.gravity), "m/s^2")
    x, y, z = model.operation.gravity
    return x, y, z
