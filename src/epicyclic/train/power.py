"""Power flow through couplings, shafts, meshes and pins, and circulating power; torques and power with losses.

Seen from the housing a mesh transmits the power of its force at the pitch point, where both gears have one velocity.
With M the moment of the force on gear b about the stage axis, T_b that about the own axis of b, and a carrier that
turns at w_c, this is

    P = w_c M + (w_b - w_c) T_b

`coupling power` w_c M, as if the stage turned as a block, and `rolling power` (w_b - w_c) T_b, which the teeth transmit
by rolling and to which their losses are in proportion.  M is T_b where b turns about the stage axis, -T_a where a does;
between two planets it follows from the place of their axes.  What the forces on a planet do at its centre goes through
its pin into the carrier.  The power into every member then sums to zero with its external power.

A mesh takes its losses from its rolling power.  Of the share f the gear that drives there puts in P, and (1 - f) P goes
on: the torque on a, lossless T_a, becomes T_a / (1 - f) where a drives and (1 - f) T_a where b does, for one torque on
b; the carrier takes what balances both.  Speeds are those of `Kinematics`.  Which gear drives follows from the torques,
so that the directions are found by iteration: those that follow from the torques they give are consistent.  Where none
are, the train is self-locking.  All of it is derived here.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError, needs_turning
from ..teeth.path_of_contact import touches_always
from .kinematics import Gearing, Kinematics, Tie, merged, watts

if TYPE_CHECKING:
    from .train import Body, Mesh

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
    kinematics: Kinematics, *, planets: Collection[str] = (), arms: Mapping[str, float] | None = None
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
    gearings, ties = kinematics.gearings, kinematics.ties
    central, at_pin = _axis_moments(gearings, mesh, planets, arms or {})
    carriers = _carriers(gearings, ties, planets)
    below = {tie.b: tie.a for tie in ties if tie.a in planets and tie.b in planets}

    def at_pins(planet: str) -> float:
        """Moment of the tooth forces on a planet and on those that stand on its shaft [N m]."""
        return sum(at_pin.get(name, 0.0) for name in (planet, *_above(planet, below)))

    paths = []
    for tie in ties:
        power = watts(tied[tie.name], speed[tie.b])
        if tie.b in below and tie.b in carriers:  # a shaft of planets carries the tooth forces beyond it to the pin
            power -= watts(at_pins(tie.b), speed[carriers[tie.b]])
        path = f"stages.{tie.name}" if "." in tie.name else f"couplings.{tie.name}"
        paths.append((path, tie.a, tie.b, tied[tie.name], power, math.nan))
    for g in gearings:
        torque, still = mesh[g.pair], speed[g.carrier] if g.carrier is not None else Fraction(0)
        rolling = watts(torque, speed[g.b] - still)
        paths.append((g.pair, g.a, g.b, torque, watts(central[g.pair], still) + rolling, rolling))
    for planet, carrier in carriers.items():
        if planet not in below:
            path, moment = f"stages.{planet}.bearing", at_pins(planet)
            paths.append((path, planet, carrier, moment, watts(moment, speed[carrier]), math.nan))
    scale = sum(value for value in (kinematics.power or {}).values() if value > 0)
    flows = [(a, b, power if abs(power) > _NONE * scale else 0.0) for _, a, b, _, power, _ in paths]
    # planets that mesh with each other or stand on one shaft count as one
    within = [(a, b) for a, b, _ in flows if a in planets and b in planets]
    circulating = _circulating(flows, merged({planet: planet for planet in planets}, within))
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


def _axis_moments(
    gearings: Iterable[Gearing], mesh: Mapping[str, float], planets: Collection[str], arms: Mapping[str, float]
) -> tuple[dict[str, float], dict[str, float]]:
    """Moments about the stage axis [N m]: of the force of each pair on its b, and of the tooth forces on each planet,
    moved to its centre."""
    central: dict[str, float] = {}
    at_pin: dict[str, float] = {}
    for g in gearings:
        on_b = mesh[g.pair]
        on_a = on_b * g.teeth_a / g.signed_b  # the forces are opposite, the pitch velocities equal
        if g.b not in planets:
            moment = on_b
        else:
            moment = -on_a if g.a not in planets else arms.get(g.pair, 1.0) * on_b
        central[g.pair] = moment
        for member, at_centre in ((g.a, -moment - on_a), (g.b, moment - on_b)):
            if member in planets:
                at_pin[member] = at_pin.get(member, 0.0) + at_centre
    return central, at_pin


def _carriers(gearings: Iterable[Gearing], ties: Iterable[Tie], planets: Collection[str]) -> dict[str, str]:
    """Carrier of every planet that has one, those on a shaft without an own mesh included."""
    carriers = {m: g.carrier for g in gearings if g.carrier is not None for m in (g.a, g.b) if m in planets}
    for tie in ties:
        for member, other in ((tie.a, tie.b), (tie.b, tie.a)):
            if member in planets and other in carriers:
                carriers.setdefault(member, carriers[other])
    return carriers


def _above(planet: str, below: Mapping[str, str]) -> list[str]:
    """Planets that stand on the shaft of a planet, directly or on one another."""
    return [name for name, under in below.items() if under == planet for name in (name, *_above(name, below))]


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
    """Edges (from, to) of a directed graph that lie on a cycle: those whose start is reached from their end."""
    every = set(edges)
    at = {name: i for i, name in enumerate({name for edge in every for name in edge})}
    reached = np.eye(len(at))
    for start, end in every:
        reached[at[start], at[end]] = 1.0
    for _ in range(len(at).bit_length()):  # each product doubles the number of steps
        reached = np.minimum(reached @ reached, 1.0)
    return {(start, end) for start, end in every if reached[at[end], at[start]]}


# losses ---------------------------------------------------------------------------------------------------------------

Array = NDArray[np.float64]
Directions = tuple[int, ...]

# Power below this share of the largest power is rounding of torques that balance: nothing drives there.
_NO_LOSS = 1e-11
# Residual of the balance beyond which torques are none, per largest torque: rounding is far below.
_BALANCED = 1e-9
# Directions are searched one by one where the iteration ends in a circle: of 12 pairs 4096 small systems, a second.
_MOST_SEARCHED = 12
# Steps of the iteration: each pair turns once or so; a circle is found before.
_STEPS = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshPower:
    """Power that one pair rolls, all branches and sides together.

    driver : member that drives in the frame of the carrier; empty where nothing rolls.
    rolling : power that it puts into the mesh [W].  loss : what the friction takes [W].
    torque : on the second member of the pair [N m].
    """

    driver: str
    rolling: float
    loss: float
    torque: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LossyFlow:
    """Torques and power of a train with losses in its meshes.

    torque : external torque on each member [N m].  power : external power into each member [W].
    meshes : of each pair, by its path.
    kept : members whose stated torque is kept.  released : those whose stated torque follows, as the losses need it.
    indeterminate : whether the balance leaves torques open; they are then those nearest to the lossless ones.
    """

    torque: Mapping[str, float]
    power: Mapping[str, float]
    meshes: Mapping[str, MeshPower]
    kept: tuple[str, ...]
    released: tuple[str, ...]
    indeterminate: bool


def require_flow(kinematics: Kinematics) -> None:
    """Refuse a train that states no speed or torque, or through which no power flows.

    Raises
    ------
    ModelError : such a train, or one that is locked.
    """
    if kinematics.locked:
        raise needs_turning()
    if kinematics.speed is None:
        raise ModelError("the speed of one member is missing", path="operation.speed", allowed="e.g. 1500 rpm")
    if kinematics.torque is None:
        raise ModelError("no torque loads the teeth", path="operation.torque", allowed="a torque of a member")
    if not any(value > 0 for value in (kinematics.power or {}).values()):
        raise ModelError("no power flows", path="operation.torque", allowed="torque and speed of one member")


def require_contact(mesh: Mesh) -> None:
    """Refuse a mesh whose contact lines are not known, or of which none touches at some instant.

    Raises
    ------
    ModelError : such a mesh.
    """
    if math.isnan(mesh.overlap_ratio):
        problem = "is missing: the contact lines of helical teeth need it"
        raise ModelError(problem, path=f"stages.{mesh.name.split('/')[0]}.face_width", allowed="of one helix [m]")
    if not touches_always(mesh.limits, mesh.overlap_ratio):
        ratio = f"contact ratio {mesh.limits[1] - mesh.limits[0]:.4g}"
        raise ModelError("the teeth do not keep contact", path=mesh.pair, given=ratio, allowed="1 or more")


def lossy_flow(kinematics: Kinematics, share: Mapping[str, float]) -> LossyFlow | None:
    """Torques and power with losses, None where no directions of power are consistent: the train is self-locking.

    A stated torque or power is kept, what balances takes the losses.  Where all are stated, the driving ones are kept
    as far as the balance allows, the largest power first.

    Parameters
    ----------
    kinematics : with speeds and torques.
    share : of each pair, by its path: share of its rolling power that friction takes, 0 <= f < 1 [1].
    """
    balance = _Balance.of(kinematics, share)
    start = balance.directions(balance.lossless)
    for directions in _candidates(balance, start):
        torques = balance.solved(directions)
        if torques is not None and balance.directions(torques) == directions:
            return balance.flow(torques, directions)
    return None


def _candidates(balance: _Balance, start: Directions) -> list[Directions]:
    """Directions to try: those the iteration reaches from the lossless ones, then all others, nearest to them first."""
    reached, now = [start], start
    for _ in range(_STEPS):
        torques = balance.solved(now)
        now = start if torques is None else balance.directions(torques)
        if now in reached:
            break
        reached.append(now)
    rolls = [i for i, sign in enumerate(start) if sign]
    if len(rolls) > _MOST_SEARCHED:
        return reached[::-1]
    turned = [set(some) for count in range(len(rolls) + 1) for some in itertools.combinations(rolls, count)]
    every = [tuple(-sign if i in some else sign for i, sign in enumerate(start)) for some in turned]
    return list(dict.fromkeys([*reached[::-1], *every]))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Balance:
    """Balance of torques of all members with losses: B x = -given, x the torques of E ends and of m meshes and ties.

    Of the n members in the order of `Kinematics.ratio`.  ends : members whose torque follows.  speed : (n,) [rad/s].
    share : (p,) of the power of each pair that friction takes [1].  relative : (p,) speed of b in the frame of the
    carrier [rad/s].  given : (n,) torques kept [N m].  lossless : (E + m,) solution without losses, of meshes torque
    per tooth [N m].  kept : members whose stated torque is kept.
    """

    kinematics: Kinematics
    share: Array
    ends: tuple[str, ...]
    speed: Array
    relative: Array
    given: Array
    lossless: Array
    kept: tuple[str, ...]

    @classmethod
    def of(cls, kinematics: Kinematics, share: Mapping[str, float]) -> _Balance:
        members, torque = kinematics.ratio, kinematics.torque or {}
        kept = tuple(_kept(kinematics))
        following = dict.fromkeys((*kinematics.reacting, *kinematics.stated))
        ends = tuple(name for name in following if name not in kept)
        speed = kinematics.speed or {}
        frames = [speed[g.carrier] if g.carrier is not None else 0 for g in kinematics.gearings]
        relative = [speed[g.b] - frame for g, frame in zip(kinematics.gearings, frames, strict=True)]  # exact
        inner = [
            *((kinematics.mesh_torque or {})[g.pair] / g.signed_b for g in kinematics.gearings),
            *(-(kinematics.tie_torque or {})[tie.name] for tie in kinematics.ties),
        ]
        return cls(
            kinematics=kinematics,
            share=np.array([share[g.pair] for g in kinematics.gearings]),
            ends=ends,
            speed=np.array([float(speed[name]) * math.tau / 60 for name in members]),
            relative=np.array([float(turn) * math.tau / 60 for turn in relative]),
            given=np.array([torque[name] if name in kept else 0.0 for name in members]),
            lossless=np.array([*(torque[name] for name in ends), *inner]),
            kept=kept,
        )

    def rolled(self, torques: Array) -> Array:
        """Rolling power into b of every pair (p,) [W]."""
        teeth = np.array([g.signed_b for g in self.kinematics.gearings])
        per_tooth = torques[len(self.ends) : len(self.ends) + len(teeth)]
        return np.asarray(per_tooth * teeth * self.relative)

    def directions(self, torques: Array) -> Directions:
        """Direction of the rolling power of every pair: 1 where a drives b, -1 where b drives a, 0 where none rolls."""
        power = self.rolled(torques)
        torque = np.concatenate([self.given, torques[: len(self.ends)]])
        scale = max(float(np.abs(power).max(initial=0.0)), float(np.abs(torque).max() * np.abs(self.speed).max()))
        return tuple(int(np.sign(value)) if abs(value) > _NO_LOSS * scale else 0 for value in power)

    def solved(self, directions: Directions) -> Array | None:
        """Torques (E + m,) nearest to the lossless ones that balance, None where none do."""
        matrix = _columns(self.kinematics, self.ends, directions, self.share)
        size = np.abs(matrix).max(axis=0)  # torques of meshes count as those on the larger gear
        rest = -self.given - matrix @ self.lossless
        change = np.linalg.lstsq(matrix / size, rest, rcond=1e-12)[0] / size
        torques = self.lossless + change
        left = np.abs(matrix @ torques + self.given).max()
        return torques if left <= _BALANCED * np.abs(self.lossless * size).max(initial=0.0) else None

    def flow(self, torques: Array, directions: Directions) -> LossyFlow:
        """The result of consistent directions."""
        torque = dict(zip(self.kinematics.ratio, self.given.tolist(), strict=True))
        torque |= dict(zip(self.ends, torques[: len(self.ends)].tolist(), strict=True))
        speed = zip(self.kinematics.ratio, self.speed.tolist(), strict=True)
        into_b = self.rolled(torques)
        meshes: dict[str, MeshPower] = {}
        for i, g in enumerate(self.kinematics.gearings):
            through, left, sign = abs(float(into_b[i])), 1 - float(self.share[i]), directions[i]
            # where a drives, what comes to b is what is left; where b drives, it is what b puts in
            rolling = through / left if sign > 0 else through if sign < 0 else 0.0
            meshes[g.pair] = MeshPower(
                driver={1: g.a, -1: g.b, 0: ""}[sign],
                rolling=rolling,
                loss=float(self.share[i]) * rolling,
                torque=float(torques[len(self.ends) + i]) * g.signed_b,
            )
        rank = np.linalg.matrix_rank(_lossless_columns(self.kinematics, self.ends), tol=1e-9)
        return LossyFlow(
            torque=torque,
            power={name: torque[name] * omega for name, omega in speed},
            meshes=meshes,
            kept=self.kept,
            released=tuple(name for name in self.kinematics.stated if name not in self.kept),
            indeterminate=bool(rank < len(self.lossless)),
        )


def _columns(kinematics: Kinematics, ends: Sequence[str], directions: Directions, share: Array) -> Array:
    """B (n, E + m): torque on every member [N m] per torque of every end, mesh (per tooth) and tie.

    directions, share : of the power of every pair.
    """
    index = {name: i for i, name in enumerate(kinematics.ratio)}
    columns: list[dict[str, float]] = [{name: 1.0} for name in ends]
    lossy = zip(kinematics.gearings, directions, share, strict=True)
    columns += [g.equation((1 - float(lost)) ** -sign) for g, sign, lost in lossy]
    columns += [{tie.a: 1.0, tie.b: -1.0} for tie in kinematics.ties]
    matrix = np.zeros((len(index), len(columns)))
    for at, column in enumerate(columns):
        for name, value in column.items():
            matrix[index[name], at] = value
    return matrix


def _lossless_columns(kinematics: Kinematics, ends: Sequence[str]) -> Array:
    """The columns of `_columns` without losses, each per its largest entry [1]."""
    count = len(kinematics.gearings)
    matrix = _columns(kinematics, ends, (0,) * count, np.zeros(count))
    return np.asarray(matrix / np.abs(matrix).max(axis=0))


def _kept(kinematics: Kinematics) -> Iterator[str]:
    """Stated members whose torques do not follow from one another, those with the largest power into the train first.

    A torque is free to be kept while the balance without losses does not fix it by those kept before.
    """
    from scipy.linalg import null_space

    torque, power = kinematics.torque or {}, kinematics.power or {}
    ends = tuple(dict.fromkeys((*kinematics.stated, *kinematics.reacting)))
    free = null_space(_lossless_columns(kinematics, ends), rcond=1e-10)
    for name in sorted(kinematics.stated, key=lambda name: -power.get(name, 0.0)):
        row = free[ends.index(name)]
        if torque.get(name) is None or np.linalg.norm(row) < 1e-9:
            continue
        yield name
        free = free @ null_space(row[None], rcond=1e-10)
