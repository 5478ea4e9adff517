"""Torques and power of a train whose meshes lose a share of the power they roll.  Derived here.

A mesh takes its losses from its rolling power, with velocities in the frame of its carrier.  Of the share f the gear
that drives there puts in P, and (1 - f) P goes on: the torque on a, lossless T_a, becomes T_a / (1 - f) where a drives
and (1 - f) T_a where b does, for one torque on b; the carrier takes what balances both.  Speeds are those of
`Kinematics`.  Which gear drives follows from the torques, so that the directions are found by iteration: those that
follow from the torques they give are consistent.  Where none are, the train is self-locking.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..teeth.loss_factor import touches_always
from .connections import Mesh
from .kinematics import Gearing, Kinematics

__all__ = ["LossyFlow", "MeshPower", "lossy_flow", "require_contact", "require_flow"]

Array = NDArray[np.float64]
Directions = tuple[int, ...]

# Power below this share of the largest power is rounding of torques that balance: nothing drives there.
_NONE = 1e-11
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
    ModelError : such a train.
    """
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
        raise ModelError(
            "is missing: the contact lines of helical teeth need it",
            path=f"stages.{mesh.name.split('/')[0]}.face_width",
            allowed="of one helix [m]",
        )
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
        found = balance.solved(directions)
        if found is not None and balance.directions(found) == directions:
            return balance.flow(found, directions)
    return None


def _candidates(balance: _Balance, start: Directions) -> list[Directions]:
    """Directions to try: those the iteration reaches from the lossless ones, then all others, nearest to them first."""
    reached, now = [start], start
    for _ in range(_STEPS):
        found = balance.solved(now)
        now = start if found is None else balance.directions(found)
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

    members : (n,).  ends : members whose torque follows.  speed : (n,) [rad/s].
    share : (p,) of the power of each pair that friction takes [1].  relative : (p,) speed of b in the frame of the
    carrier [rad/s].  given : (n,) torques kept [N m].  lossless : (E + m,) solution without losses, of meshes torque
    per tooth [N m].  kept : members whose stated torque is kept.
    """

    kinematics: Kinematics
    share: Array
    members: tuple[str, ...]
    ends: tuple[str, ...]
    speed: Array
    relative: Array
    given: Array
    lossless: Array
    kept: tuple[str, ...]

    @classmethod
    def of(cls, kinematics: Kinematics, share: Mapping[str, float]) -> _Balance:
        members, torque = tuple(kinematics.ratio), kinematics.torque or {}
        kept = _kept(kinematics, members)
        following = dict.fromkeys((*kinematics.reacting, *kinematics.stated))
        ends = tuple(name for name in following if name not in kept)
        speed = kinematics.speed or {}
        inner = [
            *((kinematics.mesh_torque or {})[g.pair] / _teeth_b(g) for g in kinematics.gearings),
            *(-(kinematics.tie_torque or {})[tie.name] for tie in kinematics.ties),
        ]
        return cls(
            kinematics=kinematics,
            share=np.array([share[g.pair] for g in kinematics.gearings]),
            members=members,
            ends=ends,
            speed=np.array([float(speed[name]) * math.tau / 60 for name in members]),
            relative=_relative(kinematics),
            given=np.array([torque[name] if name in kept else 0.0 for name in members]),
            lossless=np.array([*(torque[name] for name in ends), *inner]),
            kept=kept,
        )

    def rolled(self, found: Array) -> Array:
        """Rolling power into b of every pair (p,) [W]."""
        teeth = np.array([_teeth_b(g) for g in self.kinematics.gearings])
        per_tooth = found[len(self.ends) : len(self.ends) + len(teeth)]
        return np.asarray(per_tooth * teeth * self.relative)

    def directions(self, found: Array) -> Directions:
        """Direction of the rolling power of every pair: 1 where a drives b, -1 where b drives a, 0 where none rolls."""
        power = self.rolled(found)
        torque = np.concatenate([self.given, found[: len(self.ends)]])
        scale = max(float(np.abs(power).max(initial=0.0)), float(np.abs(torque).max() * np.abs(self.speed).max()))
        return tuple(int(np.sign(value)) if abs(value) > _NONE * scale else 0 for value in power)

    def solved(self, directions: Directions) -> Array | None:
        """Torques (E + m,) nearest to the lossless ones that balance, None where none do."""
        matrix = _columns(self.kinematics, self.members, self.ends, directions, self.share)
        size = np.abs(matrix).max(axis=0)  # torques of meshes count as those on the larger gear
        rest = -self.given - matrix @ self.lossless
        change = np.linalg.lstsq(matrix / size, rest, rcond=1e-12)[0] / size
        found = self.lossless + change
        left = np.abs(matrix @ found + self.given).max()
        return found if left <= _BALANCED * np.abs(self.lossless * size).max(initial=0.0) else None

    def flow(self, found: Array, directions: Directions) -> LossyFlow:
        """The result of consistent directions."""
        torque = dict(zip(self.members, self.given.tolist(), strict=True))
        torque |= dict(zip(self.ends, found[: len(self.ends)].tolist(), strict=True))
        speed = dict(zip(self.members, self.speed.tolist(), strict=True))
        into_b = self.rolled(found)
        meshes: dict[str, MeshPower] = {}
        for i, g in enumerate(self.kinematics.gearings):
            through, left, sign = abs(float(into_b[i])), 1 - float(self.share[i]), directions[i]
            # where a drives, what comes to b is what is left; where b drives, it is what b puts in
            rolling = through / left if sign > 0 else through if sign < 0 else 0.0
            meshes[g.pair] = MeshPower(
                driver={1: g.a, -1: g.b, 0: ""}[sign],
                rolling=rolling,
                loss=float(self.share[i]) * rolling,
                torque=float(found[len(self.ends) + i]) * _teeth_b(g),
            )
        rank = np.linalg.matrix_rank(_lossless_columns(self.kinematics, self.members, self.ends), tol=1e-9)
        return LossyFlow(
            torque=torque,
            power={name: torque[name] * speed[name] for name in self.members},
            meshes=meshes,
            kept=self.kept,
            released=tuple(name for name in self.kinematics.stated if name not in self.kept),
            indeterminate=bool(rank < len(self.lossless)),
        )


def _columns(
    kinematics: Kinematics, members: Sequence[str], ends: Sequence[str], directions: Directions, share: Array
) -> Array:
    """B (n, E + m): torque on every member [N m] per torque of every end, mesh (per tooth) and tie.

    directions, share : of the power of every pair.
    """
    place = {name: i for i, name in enumerate(members)}
    columns: list[dict[str, float]] = [{name: 1.0} for name in ends]
    for g, sign, lost in zip(kinematics.gearings, directions, share, strict=True):
        on_a, on_b = g.teeth_a * (1 - lost) ** -sign, float(_teeth_b(g))
        column = {g.a: on_a, g.b: on_b}
        if g.carrier is not None:
            column[g.carrier] = column.get(g.carrier, 0.0) - on_a - on_b
        columns.append(column)
    columns += [{tie.a: 1.0, tie.b: -1.0} for tie in kinematics.ties]
    matrix = np.zeros((len(members), len(columns)))
    for at, column in enumerate(columns):
        for name, value in column.items():
            matrix[place[name], at] = value
    return matrix


def _lossless_columns(kinematics: Kinematics, members: Sequence[str], ends: Sequence[str]) -> Array:
    """The columns of `_columns` without losses, each per its largest entry [1]."""
    count = len(kinematics.gearings)
    matrix = _columns(kinematics, members, ends, (0,) * count, np.zeros(count))
    return np.asarray(matrix / np.abs(matrix).max(axis=0))


def _teeth_b(g: Gearing) -> int:
    """Teeth of b, negative of a ring: torques on a and b are in the ratio of teeth_a to this."""
    return -g.teeth_b if g.internal else g.teeth_b


def _relative(kinematics: Kinematics) -> Array:
    """Speed of b in the frame of the carrier of every pair (p,) [rad/s]; exact zeros stay zero."""
    speed = kinematics.speed or {}
    frames = [speed[g.carrier] if g.carrier is not None else 0 for g in kinematics.gearings]
    both = zip(kinematics.gearings, frames, strict=True)
    return np.array([float(speed[g.b] - frame) * math.tau / 60 for g, frame in both])


def _kept(kinematics: Kinematics, members: Sequence[str]) -> tuple[str, ...]:
    """Stated members whose torques do not follow from one another, those with the largest power into the train first.

    A torque is free to be kept while the balance without losses does not fix it by those kept before.
    """
    torque, power = kinematics.torque or {}, kinematics.power or {}
    ends = tuple(dict.fromkeys((*kinematics.stated, *kinematics.reacting)))
    free = _null_space(_lossless_columns(kinematics, members, ends))
    kept: list[str] = []
    for name in sorted(kinematics.stated, key=lambda name: -power.get(name, 0.0)):
        row = free[ends.index(name)]
        if torque.get(name) is None or np.linalg.norm(row) < 1e-9:
            continue
        kept.append(name)
        free = free @ _null_space(row[None])
    return tuple(kept)


def _null_space(matrix: Array) -> Array:
    """Orthonormal basis (n, k) of the null space of a matrix (m, n) [1]."""
    _, size, vectors = np.linalg.svd(matrix)
    rank = int((size > 1e-10 * size.max(initial=1.0)).sum())
    return np.asarray(vectors[rank:].T)
