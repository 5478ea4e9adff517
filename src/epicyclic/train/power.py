"""Power flow through couplings, shafts, meshes and pins, and circulating power.  Derived here.

Seen from the housing a mesh transmits the power of its force at the pitch point, where both gears have one velocity.
With M the moment of the force on gear b about the stage axis, T_b that about the own axis of b, and a carrier that
turns at w_c, this is

    P = w_c M + (w_b - w_c) T_b

`coupling power` w_c M, as if the stage turned as a block, and `rolling power` (w_b - w_c) T_b, which the teeth transmit
by rolling and to which their losses are in proportion.  M is T_b where b turns about the stage axis, -T_a where a does;
between two planets it follows from the place of their axes.  What the forces on a planet do at its centre goes through
its pin into the carrier.  The power into every member then sums to zero with its external power.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from .bodies import Body
from .connections import Mesh
from .kinematics import Gearing, Kinematics, Tie

__all__ = ["PowerPath", "planet_arms", "power_flow"]

# Power below this share of the input power is rounding of torques that balance.
_NONE = 1e-9

Edge = tuple[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerPath:
    """Power through one coupling, shaft, pair of members in mesh, or all pins of a planet.

    path : of its table in the model file.  first, second : the members it joins.
    torque : on `second`, all branches and sides together [N m]: about its own axis, of a pin about that of the carrier.
    power : into `second`, out of `first`, with velocities in the housing [W].
    rolling : of a mesh, its part with velocities in the frame of the carrier [W]; nan of couplings, shafts and pins.
    circulating : it lies on a closed path of power.
    """

    path: str
    first: str
    second: str
    torque: float
    power: float
    rolling: float
    circulating: bool


def power_flow(
    kinematics: Kinematics,
    gearings: Sequence[Gearing],
    ties: Sequence[Tie],
    *,
    planets: Collection[str] = (),
    arms: Mapping[str, float] | None = None,
) -> tuple[PowerPath, ...]:
    """Power through every coupling and shaft, every pair in mesh and the pins; empty without speeds and torques.

    A path circulates where it lies on a closed path of power through members; one that carries more than the whole
    input always does.  The planets of a stage that mesh or stand on one shaft count as one member there: power that
    goes out through one pin and back through another of the same carrier loads nothing but that carrier.
    In a statically indeterminate loop of gears the torques are those of `Kinematics`.

    Parameters
    ----------
    planets : members whose axes a carrier carries, or that stand in the housing in its place.
    arms : of each pair of two planets (its path) M / T_b [1], see `planet_arms`; read where their carrier turns.
    """
    speed, mesh, tied = kinematics.speed, kinematics.mesh_torque, kinematics.tie_torque
    if speed is None or mesh is None or tied is None:
        return ()
    central = _central_moments(gearings, mesh, planets, arms or {})
    at_pin = _pin_moments(gearings, mesh, planets, central)
    carriers = _carriers(gearings, ties, planets)
    below = {tie.b: tie.a for tie in ties if tie.a in planets and tie.b in planets}
    paths = [_tie(tie, tied[tie.name], speed, at_pin, below, carriers) for tie in ties]
    for g in gearings:
        torque, still = mesh[g.pair], speed[g.carrier] if g.carrier is not None else Fraction(0)
        rolling = _watts(torque, speed[g.b] - still)
        paths.append((g.pair, g.a, g.b, torque, _watts(central[g.pair], still) + rolling, rolling))
    for planet, carrier in carriers.items():
        if planet not in below:
            moment = sum(at_pin.get(name, 0.0) for name in (planet, *_above(planet, below)))
            path = f"stages.{planet}.bearing"
            paths.append((path, planet, carrier, moment, _watts(moment, speed[carrier]), math.nan))
    scale = sum(value for value in (kinematics.power or {}).values() if value > 0)
    circulating = _circulating(
        [(a, b, power if abs(power) > _NONE * scale else 0.0) for _, a, b, _, power, _ in paths],
        _one_member(gearings, ties, planets),
    )
    return tuple(
        PowerPath(path=path, first=a, second=b, torque=torque, power=power, rolling=rolling, circulating=circulates)
        for (path, a, b, torque, power, rolling), circulates in zip(paths, circulating, strict=True)
    )


def planet_arms(meshes: Iterable[Mesh], bodies: Iterable[Body]) -> dict[str, float]:
    """M / T_b of every pair of two planets: moment of the tooth force about the stage axis over that about b's [1].

    meshes, bodies : of the train; the same ratio holds on every branch.
    """
    by_name = {body.name: body for body in bodies}
    arms: dict[str, float] = {}
    for mesh in meshes:
        a, b = by_name[mesh.a], by_name[mesh.b]
        if mesh.pair in arms or a.carried_by is None or b.carried_by is None:
            continue
        e = np.exp(1j * mesh.direction)
        normal = (math.sin(mesh.pressure_angle) + 1j * mesh.flank * math.cos(mesh.pressure_angle)) * e
        pitch = complex(*a.centre) + mesh.radius_a * e
        arms[mesh.pair] = float((pitch.conjugate() * normal).imag) / float(
            ((pitch - complex(*b.centre)).conjugate() * normal).imag
        )
    return arms


def _watts(torque: float, speed: Fraction) -> float:
    return torque * float(speed) * math.tau / 60


def _on_a(g: Gearing, on_b: float) -> float:
    """Torque of a pair on its member a [N m] from that on b: the forces are opposite, the pitch velocities equal."""
    return on_b * g.teeth_a / (-g.teeth_b if g.internal else g.teeth_b)


def _central_moments(
    gearings: Iterable[Gearing], mesh: Mapping[str, float], planets: Collection[str], arms: Mapping[str, float]
) -> dict[str, float]:
    """Moment about the stage axis of the force of each pair on its member b [N m]."""

    def moment(g: Gearing) -> float:
        on_b = mesh[g.pair]
        if g.b not in planets:
            return on_b
        return -_on_a(g, on_b) if g.a not in planets else arms.get(g.pair, 1.0) * on_b

    return {g.pair: moment(g) for g in gearings}


def _pin_moments(
    gearings: Iterable[Gearing], mesh: Mapping[str, float], planets: Collection[str], central: Mapping[str, float]
) -> dict[str, float]:
    """Moment about the stage axis of the tooth forces on each planet, moved to its centre [N m]."""
    found: dict[str, float] = {}
    for g in gearings:
        on_b = mesh[g.pair]
        for member, moment in ((g.a, -central[g.pair] - _on_a(g, on_b)), (g.b, central[g.pair] - on_b)):
            if member in planets:
                found[member] = found.get(member, 0.0) + moment
    return found


def _carriers(gearings: Iterable[Gearing], ties: Iterable[Tie], planets: Collection[str]) -> dict[str, str]:
    """Carrier of every planet that has one, those on a shaft without an own mesh included."""
    found = {m: g.carrier for g in gearings if g.carrier is not None for m in (g.a, g.b) if m in planets}
    for tie in ties:
        for member, other in ((tie.a, tie.b), (tie.b, tie.a)):
            if member in planets and other in found:
                found.setdefault(member, found[other])
    return found


def _above(planet: str, below: Mapping[str, str]) -> list[str]:
    """Planets that stand on the shaft of a planet, directly or on one another."""
    return [name for name, under in below.items() if under == planet for name in (name, *_above(name, below))]


def _tie(
    tie: Tie,
    torque: float,
    speed: Mapping[str, Fraction],
    at_pin: Mapping[str, float],
    below: Mapping[str, str],
    carriers: Mapping[str, str],
) -> tuple[str, str, str, float, float, float]:
    """Path of a coupling, or of a shaft of planets: the shaft also carries the tooth forces beyond it to the pin."""
    power = _watts(torque, speed[tie.b])
    if tie.b in below and tie.b in carriers:
        beyond = sum(at_pin.get(name, 0.0) for name in (tie.b, *_above(tie.b, below)))
        power -= _watts(beyond, speed[carriers[tie.b]])
    path = f"stages.{tie.name}" if "." in tie.name else f"couplings.{tie.name}"
    return path, tie.a, tie.b, torque, power, math.nan


def _one_member(gearings: Iterable[Gearing], ties: Iterable[Tie], planets: Collection[str]) -> dict[str, str]:
    """Name that stands for every planet: one for those that mesh with each other or stand on one shaft."""
    name = {planet: planet for planet in planets}
    for a, b in [*((g.a, g.b) for g in gearings), *((tie.a, tie.b) for tie in ties)]:
        if a in name and b in name:
            old, new = name[b], name[a]
            name = {planet: new if one == old else one for planet, one in name.items()}
    return name


def _circulating(paths: Sequence[tuple[str, str, float]], one: Mapping[str, str]) -> list[bool]:
    """Whether each path (from, to, power) lies on a closed path of power; `one` names members that count as one."""
    net: dict[Edge, float] = {}
    for a, b, power in paths:
        edge = (one.get(a, a), one.get(b, b))
        net[edge] = net.get(edge, 0.0) + power
    outer = _edges_on_cycles(_directed(net.items()))
    inside = [(a, b) for a, b, _ in paths if one.get(a, a) == one.get(b, b)]

    def outside(a: str, b: str, power: float) -> bool:
        """Whether it is one of the closed paths between members that count as one, in their sense."""
        return any((one.get(s, s), one.get(t, t)) in outer for s, t in _directed([((a, b), power)]))

    # a path inside such a member circulates where it closes one of the outer ones
    closed = [(a, b, power) for a, b, power in paths if outside(a, b, power) or (a, b) in inside]
    through = _edges_on_cycles(_directed(((a, b), power) for a, b, power in closed)) if outer else set()
    return [
        outside(a, b, power) or ((a, b) in inside and bool(through & set(_directed([((a, b), power)]))))
        for a, b, power in paths
    ]


def _directed(flows: Iterable[tuple[Edge, float]]) -> list[Edge]:
    """Edges turned the way their power goes; those without power, and from a member to itself, left out."""
    return [edge if power > 0 else edge[::-1] for edge, power in flows if power and edge[0] != edge[1]]


def _edges_on_cycles(edges: Iterable[Edge]) -> set[Edge]:
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
