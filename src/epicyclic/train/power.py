"""Power flow through couplings, shafts and meshes, and circulating power."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from .kinematics import Gearing, Kinematics, Tie

__all__ = ["PowerPath", "power_flow"]

# Power below this share of the input power is rounding of torques that balance.
_NONE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerPath:
    """Power through one coupling, shaft or pair of members in mesh.

    path : of its table in the model file.  first, second : the members it joins.
    torque : on `second`, all branches and sides together [N m].
    power : into `second` with absolute speeds [W]; of a coupling the power out of `first`.
    circulating : it is part of a cycle of power through couplings and stages.
    """

    path: str
    first: str
    second: str
    torque: float
    power: float
    circulating: bool


def power_flow(kinematics: Kinematics, gearings: Sequence[Gearing], ties: Sequence[Tie]) -> tuple[PowerPath, ...]:
    """Power through every coupling and shaft, then through every pair in mesh; empty without speeds and torques.

    A stage is one node of the power graph: power between its own members is no cycle.  In a statically indeterminate
    loop of gears the torques are those of `Kinematics`.
    """
    speed, mesh, tied = kinematics.speed, kinematics.mesh_torque, kinematics.tie_torque
    if speed is None or mesh is None or tied is None:
        return ()
    scale = sum(value for value in (kinematics.power or {}).values() if value > 0)
    edges = [(_tie_path(tie), tie.a, tie.b, tied[tie.name]) for tie in ties]
    flows = _stage_flows(gearings, mesh, speed)
    for _, a, b, torque in edges:
        flows[a, b] = flows.get((a, b), 0.0) + _watts(torque, speed[b])
    cyclic = _edges_on_cycles(
        (edge if power > 0 else edge[::-1]) for edge, power in flows.items() if abs(power) > _NONE * scale
    )

    def circulates(a: str, b: str) -> bool:
        return (a, b) in cyclic or (b, a) in cyclic

    paths = [(*edge, circulates(edge[1], edge[2])) for edge in edges]
    for g in gearings:
        stage = f"stages/{g.stage}"
        paths.append((g.pair, g.a, g.b, mesh[g.pair], circulates(stage, g.a) and circulates(stage, g.b)))
    return tuple(
        PowerPath(path=path, first=a, second=b, torque=torque, power=_watts(torque, speed[b]), circulating=circulating)
        for path, a, b, torque, circulating in paths
    )


def _tie_path(tie: Tie) -> str:
    """Path of the table of a tie: a coupling, or the gear on a shaft of its stage."""
    return f"stages.{tie.name}" if "." in tie.name else f"couplings.{tie.name}"


def _watts(torque: float, speed: Fraction) -> float:
    return torque * float(speed) * math.tau / 60


def _stage_flows(
    gearings: Sequence[Gearing], mesh: Mapping[str, float], speed: Mapping[str, Fraction]
) -> dict[tuple[str, str], float]:
    """Power from each stage into each of its members, by (stage, member) [W]."""
    flows: dict[tuple[str, str], float] = {}
    for g in gearings:
        on_b = mesh[g.pair]
        on_a = on_b * g.teeth_a / (-g.teeth_b if g.internal else g.teeth_b)
        torques = {g.a: on_a, g.b: on_b} | ({} if g.carrier is None else {g.carrier: -on_a - on_b})
        for member, torque in torques.items():
            edge = (f"stages/{g.stage}", member)
            flows[edge] = flows.get(edge, 0.0) + _watts(torque, speed[member])
    return flows


def _edges_on_cycles(edges: Iterable[tuple[str, str]]) -> set[tuple[str, str]]:
    """Edges (from, to) of a directed graph that lie on a cycle."""
    every = set(edges)
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
