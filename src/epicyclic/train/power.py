"""Power through couplings, shafts and meshes: what takes which path, and what goes round in a circle."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from .kinematics import Gearing, Kinematics, Tie

__all__ = ["PowerPath", "power_flow"]

# Power beside the input power that counts as none: rounding of torques that balance.
_NONE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerPath:
    """One way that power takes.

    path : of its table in the file.  first, second : the members it joins.
    torque : that it puts on `second`, all branches and sides together [N m].
    power : that it gives to `second`, seen from the housing [W]; through a coupling that is what `first` gives.
    circulating : it is part of a circle of power through couplings and stages.
    """

    path: str
    first: str
    second: str
    torque: float
    power: float
    circulating: bool


def power_flow(kinematics: Kinematics, gearings: Sequence[Gearing], ties: Sequence[Tie]) -> tuple[PowerPath, ...]:
    """Power through every coupling and shaft, then through every pair that meshes; nothing without speeds and torques.

    A stage is one node: what its meshes pass on among its own members is no circle.  Where a loop of gears is
    statically indeterminate the torques of `Kinematics` stand for it.
    """
    speed, mesh, tied = kinematics.speed, kinematics.mesh_torque, kinematics.tie_torque
    if speed is None or mesh is None or tied is None:
        return ()
    scale = sum(value for value in (kinematics.power or {}).values() if value > 0)
    ways = [(_tie_path(tie), tie.a, tie.b, tied[tie.name]) for tie in ties]
    flows = _stage_flows(gearings, mesh, speed)
    for _, a, b, torque in ways:
        flows[a, b] = flows.get((a, b), 0.0) + _watts(torque, speed[b])
    round_ = _circles((way if power > 0 else way[::-1]) for way, power in flows.items() if abs(power) > _NONE * scale)

    def on_circle(a: str, b: str) -> bool:
        return (a, b) in round_ or (b, a) in round_

    found = [(*way, on_circle(way[1], way[2])) for way in ways]
    for g in gearings:
        stage = f"stages/{g.stage}"
        found.append((g.pair, g.a, g.b, mesh[g.pair], on_circle(stage, g.a) and on_circle(stage, g.b)))
    return tuple(
        PowerPath(path=path, first=a, second=b, torque=torque, power=_watts(torque, speed[b]), circulating=circle)
        for path, a, b, torque, circle in found
    )


def _tie_path(tie: Tie) -> str:
    """The table of a tie: a coupling, or the gear that sits on a shaft of its stage."""
    return f"stages.{tie.name}" if "." in tie.name else f"couplings.{tie.name}"


def _watts(torque: float, speed: Fraction) -> float:
    return torque * float(speed) * math.tau / 60


def _stage_flows(
    gearings: Sequence[Gearing], mesh: Mapping[str, float], speed: Mapping[str, Fraction]
) -> dict[tuple[str, str], float]:
    """Power that each stage gives to each of its members, by (stage, member) [W]."""
    flows: dict[tuple[str, str], float] = {}
    for g in gearings:
        on_b = mesh[g.pair]
        on_a = on_b * g.teeth_a / (-g.teeth_b if g.internal else g.teeth_b)
        torques = {g.a: on_a, g.b: on_b} | ({} if g.carrier is None else {g.carrier: -on_a - on_b})
        for member, torque in torques.items():
            way = (f"stages/{g.stage}", member)
            flows[way] = flows.get(way, 0.0) + _watts(torque, speed[member])
    return flows


def _circles(ways: Iterable[tuple[str, str]]) -> set[tuple[str, str]]:
    """The ways (from, to) from whose end one comes back to their beginning."""
    every = set(ways)
    following: dict[str, set[str]] = {}
    for start, end in every:
        following.setdefault(start, set()).add(end)

    def reached(start: str) -> set[str]:
        seen, left = {start}, [start]
        while left:
            fresh = following.get(left.pop(), set()) - seen
            seen |= fresh
            left += fresh
        return seen

    return {(start, end) for start, end in every if start in reached(end)}
