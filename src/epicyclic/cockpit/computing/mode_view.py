"""Modes of a train as the page lists and animates them: frequencies, shapes, labels, and the orders that meet them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...questions.modes.basis import mean_modes
from ...questions.modes.campbell import OPERATION, MeshCrossings, mesh_crossings, tones_of_meshes
from ...questions.modes.eigen import classify_modes, normalisation
from ...questions.response.resonances import BAND, excited_modes
from ...results.ties import largest, ranked
from ...statics.tangent import linear
from ...system.system import Array, System
from ...train.train import Train
from .names import SpeedAxis, member_words, ordinal, rounded

__all__ = ["ModeView", "mode_view"]

# A list of more modes is read by nobody, and their shapes would be most of the message.
_MOST = 60
# Share of the kinetic energy from which a member is named beside the one that moves most, and share of the largest
# motion of a branch from which a branch takes part.
_NAMED, _TAKES_PART = 0.25, 0.3
# Motions in words, of one body and of several: x, y, z, tilt, rotation.
_ALL = (("slides along the axis", "slide along the axis"), ("tilts", "tilt"), ("rotates", "rotate"))
_CENTRAL = (("moves sideways", "move sideways"),) * 2 + _ALL
_CARRIED = (("moves radially", "move radially"), ("moves tangentially", "move tangentially"), *_ALL)
_ROTATES = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModeView:
    """Elastic modes, at most 60, the lowest first.

    number : (m,) of each among all modes of the verb `modes`, from 1.  frequency : (m,) [Hz].
    shape : (m, nb, 6) x, y, z and rx, ry, rz times the pitch radius, in the axes of the stage, largest component 1.
    label : what moves.  kind : rotational, translational, planet or mixed.  body : the one that moves most.
    damping : (m,) damping ratio [1], nan where not given.  crossings : speeds at which mesh orders meet them, of all
    modes; within 20 % of the speed that is shown those of orders that excite the mode, or where that is not known.
    at_rest : how many others there are.
    """

    number: NDArray[np.int64]
    frequency: Array
    shape: Array
    label: tuple[str, ...]
    kind: tuple[str, ...]
    body: tuple[str, ...]
    crossings: MeshCrossings
    at_rest: int
    tones: Mapping[Fraction, Sequence[str]]

    @property
    def of_number(self) -> dict[int, int]:
        """Place of a mode in the list by its number."""
        return {int(number): place for place, number in enumerate(self.number)}

    def rows(self, axis: SpeedAxis | None, relative_speed: float, stages: int) -> list[dict[str, Any]]:
        """``head["modes"]`` of a frame, at a speed per operating speed [1]."""
        met = self._met(axis, relative_speed, stages)
        return [
            {
                "index": int(self.number[i]),
                "frequency": float(self.frequency[i]),
                "label": self.label[i],
                "body": self.body[i],
                "kind": self.kind[i],
                "met_by": met.get(int(self.number[i]), ""),
            }
            for i in range(len(self.frequency))
        ]

    def _met(self, axis: SpeedAxis | None, relative_speed: float, stages: int) -> dict[int, str]:
        """Number of a mode -> the order that meets it nearest to a speed, within 20 % of that."""
        found, nearest = self.crossings, dict[int, tuple[float, str]]()
        tones = list(self.tones.items())
        for mode, count, tone, order, speed in zip(
            found.mode, found.count, found.tone, found.order, found.relative_speed, strict=True
        ):
            away = abs(speed / relative_speed - 1)
            if away > BAND or axis is None:
                continue
            where = f" of {' and '.join(tones[tone][1])}" if stages > 1 else ""
            text = f"{ordinal(int(order))} mesh order{where} at {rounded(speed * axis[1])} rpm"
            for number in range(int(mode) + 1, int(mode + count) + 1):
                if number not in nearest or away < nearest[number][0]:
                    nearest[number] = away, text
        return {number: text for number, (_, text) in nearest.items()}


def mode_view(
    train: Train,
    system: System,
    labels: Mapping[str, str],
    *,
    relative_speed: float = 1.0,
    compiled: bool | None = None,
) -> ModeView:
    """Elastic modes of the undamped mean system at standstill.

    Parameters
    ----------
    labels : of the bodies.  relative_speed : that is shown, per operating speed [1].  compiled : as of `sweep`.

    Raises
    ------
    ModelError : a mass or inertia is missing, or the mean system is statically unstable.
    """
    system = linear(system)
    squared, vectors = mean_modes(system)
    kinds = classify_modes(system, squared, vectors)
    elastic = np.flatnonzero(squared > 0)[:_MOST]
    own = kinds.vectors[:, elastic]
    own = own * normalisation(own, system.dofs.radius)
    nb = len(system.dofs.bodies)
    full = (system.dofs.expand @ own).reshape(nb, 6, -1).transpose(2, 0, 1)
    label, body = _labels(train, system, full, labels)
    frequency = np.sqrt(squared) / (2 * np.pi)
    tones = tones_of_meshes(system)
    crossings, at_rest = _crossings(system, frequency, np.real(kinds.vectors), relative_speed, compiled)
    return ModeView(
        number=elastic + 1,
        frequency=frequency[elastic],
        shape=_drawn(train, full),
        label=label,
        kind=tuple(kinds.kind[i] for i in elastic),
        body=body,
        crossings=crossings,
        at_rest=at_rest,
        tones=tones,
    )


def _crossings(
    system: System, frequency: Array, shapes: Array, relative_speed: float, compiled: bool | None
) -> tuple[MeshCrossings, int]:
    """Crossings about operation and within the band about a speed, there without those whose order leaves the mode at
    rest; and how many these are.

    frequency : (n,) of all modes [Hz].  shapes : (n, n).
    """
    low = min(OPERATION[0], (1 - BAND) * relative_speed)
    high = max(OPERATION[1], (1 + BAND) * relative_speed)
    found = mesh_crossings(frequency, [float(tone) for tone in tones_of_meshes(system)], low=low, high=high)
    near = np.abs(found.relative_speed / relative_speed - 1) <= BAND
    kept = np.ones(len(found.mode), dtype=bool)
    kept[near] = excited_modes(system, found.chosen(near), shapes, compiled=compiled) != "no"
    return found.chosen(kept), int((~kept).sum())


def _pitch_radii(train: Train) -> Array:
    """Radius of every body by which its rotation is drawn (nb,) [m]: pitch circle, of a carrier that of its pins."""
    pins = {body.carried_by: float(np.hypot(*body.centre)) for body in train.bodies if body.carried_by}
    own = [body.gear.reference_radius if body.gear is not None else pins.get(body.name, 0.0) for body in train.bodies]
    some = max(own, default=0.0) or 1.0
    return np.array([radius if np.isfinite(radius) and radius > 0 else 0.25 * some for radius in own])


def _drawn(train: Train, full: Array) -> Array:
    """Shapes (m, nb, 6) in the axes of the stage, rotations as lengths, largest component 1.

    full : (m, nb, 6) in each body's own axes [m, rad].
    """
    angle = np.array([body.angle for body in train.bodies])
    cosine, sine = np.cos(angle), np.sin(angle)
    shape = np.empty_like(full)
    for x, y in ((0, 1), (3, 4)):
        shape[..., x] = cosine * full[..., x] - sine * full[..., y]
        shape[..., y] = sine * full[..., x] + cosine * full[..., y]
    shape[..., 2], shape[..., 5] = full[..., 2], full[..., 5]
    shape[..., 3:] *= _pitch_radii(train)[:, None]
    largest = np.abs(shape).max(axis=(1, 2), initial=0.0)
    result: Array = shape / np.where(largest > 0, largest, 1.0)[:, None, None]
    return result


def _labels(
    train: Train, system: System, full: Array, labels: Mapping[str, str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What moves in each mode, and the body that moves most, by kinetic energy; of shapes (m, nb, 6)."""
    energy = full**2 * (system.body_mass if system.body_mass.shape == full.shape[1:] else 1.0)
    total = energy.sum(axis=(1, 2), keepdims=True)
    energy = energy / np.where(total > 0, total, 1.0)
    members = list(dict.fromkeys(body.member for body in train.bodies))
    place = np.array([members.index(body.member) for body in train.bodies])
    member_sum = (place == np.arange(len(members))[:, None]).astype(float)
    by_member = np.einsum("kb,mbd->mkd", member_sum, energy)
    motions = np.stack(
        [by_member[..., 0], by_member[..., 1], by_member[..., 2], by_member[..., 3:5].sum(axis=2), by_member[..., 5]],
        axis=2,
    )
    # a member about the axis has no radial and tangential of its own
    central = np.array([all(b.branch is None for b in train.bodies if b.member == member) for member in members])
    motions[:, central, 0] += motions[:, central, 1]
    motions[:, central, 1] = 0.0
    pairs, of_body = _member_pairs(train), energy.sum(axis=2)
    words = [_sentence(_Movement(train, members, central, motions[i], of_body[i]), pairs) for i in range(len(full))]
    names = [labels[body.name] for body in train.bodies]
    return tuple(words), tuple(names[largest(one)] for one in of_body)


def _member_pairs(train: Train) -> set[frozenset[str]]:
    """Members that mesh."""
    member = {body.name: body.member for body in train.bodies}
    return {frozenset((member[mesh.a], member[mesh.b])) for mesh in train.meshes}


@dataclass(frozen=True, slots=True, eq=False)
class _Movement:
    """Shares of the kinetic energy of one mode.

    central : (members,) which turn about the axis.  shares : (members, motions).  of_body : (nb,).
    """

    train: Train
    members: Sequence[str]
    central: NDArray[np.bool_]
    shares: Array
    of_body: Array

    def motion(self, member: int) -> int:
        """The motion with most of the energy of a member."""
        return largest(self.shares[member])

    def verb(self, member: int) -> str:
        """That motion in words."""
        one, many = (_CENTRAL if self.central[member] else _CARRIED)[self.motion(member)]
        return many if self.subject(member)[1] else one

    def subject(self, member: int) -> tuple[str, bool]:
        """A member in words, its branches numbered where not all take part; and whether it is several bodies."""
        name = self.members[member]
        branches: dict[int, float] = {}
        for energy, body in zip(self.of_body, self.train.bodies, strict=True):
            if body.member == name and body.branch is not None:
                branches[body.branch] = branches.get(body.branch, 0.0) + float(energy)
        # energies are squares of motions
        least = _TAKES_PART**2 * max(branches.values(), default=0.0)
        moving = sorted(branch for branch, value in branches.items() if value >= least)
        return member_words(self.train, name, moving), len(moving) > 1


def _sentence(moved: _Movement, meshing: set[frozenset[str]]) -> str:
    """What moves in one mode: the member with most kinetic energy, and one beside it with a quarter or more."""
    shares = moved.shares.sum(axis=1)
    first, *others = (int(i) for i in ranked(shares)[:2])
    text = f"{moved.subject(first)[0]} {moved.verb(first)}"
    for other in others:
        if shares[other] < _NAMED:
            continue
        subject = moved.subject(other)[0]
        if moved.motion(other) != moved.motion(first):
            text += f", {subject} {moved.verb(other)}"
        else:
            turning = moved.motion(first) == _ROTATES
            against = turning and frozenset((moved.members[first], moved.members[other])) in meshing
            text += f" {'against' if against else 'with'} the {subject}"
    return text
