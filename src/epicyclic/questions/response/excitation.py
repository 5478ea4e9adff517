"""Excitation of the steady response: the exact lines of a System, sorted into mesh orders and shaft orders."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...statics.record import contradicting_radii, unheld, unheld_error
from ...system.system import Array, ComplexArray, Line, System
from ..modes.eigen import Modal
from .lattice import Lattice, Point

# Torques balanced in the input leave rounding on a rigid mode, 1e-13 of the sum of magnitudes; a wrong one far more.
_BALANCE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shaft:
    """Lines that the mesh orders couple: their frequencies are a . f + frequency, or a . f - frequency.

    frequency : of the lowest of them [Hz] at the operating speed.
    members : (lattice point a, whether the second form holds, so that the conjugate counts, line).
    """

    frequency: Fraction
    members: tuple[tuple[Point, bool, Line], ...]

    @property
    def causes(self) -> tuple[str, ...]:
        """Paths of the model file that contribute to any of the lines, once each."""
        return tuple(dict.fromkeys(cause for _, _, line in self.members for cause in line.causes))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineExcitation:
    """Lines by kind.

    tones : (D,) mesh frequencies [Hz] at the operating speed, that of the first mesh first.
    axis : (m,) index of the tone of each mesh row.
    mesh : (lattice point, line) of each line at an integer multiple of a tone, 0 included.  shaft : the others,
        grouped.
    """

    tones: tuple[Fraction, ...]
    axis: NDArray[np.int64]
    mesh: tuple[tuple[Point, Line], ...]
    shaft: tuple[Shaft, ...]

    @property
    def tone(self) -> Fraction:
        """Mesh frequency of the first mesh [Hz] at the operating speed."""
        return self.tones[0]

    def stages(self, system: System) -> list[str]:
        """Stage of each tone, that of its first mesh, (D,)."""
        axes = self.axis.tolist()
        return [system.meshes.stage[axes.index(axis)] for axis in range(len(self.tones))]

    def solved_together(self, *, shifted: bool) -> list[list[tuple[Point, bool, Line]]]:
        """Groups of lines that share a solution: one of all mesh orders, or (`shifted`) one a shaft frequency.

        A line is (lattice point, whether its conjugate stands there, line): a . f - frequency, conjugated, is at -a
        around +frequency.
        """
        if not shifted:
            return [[(point, False, line) for point, line in self.mesh]]
        return [
            [(tuple(-a for a in point) if minus else point, minus, line) for point, minus, line in shaft.members]
            for shaft in self.shaft
        ]

    @property
    def highest(self) -> tuple[int, ...]:
        """Highest order of each tone at which a line stands, (D,)."""
        points = [point for point, _ in self.mesh]
        points += [point for shaft in self.shaft for point, _, _ in shaft.members]
        return tuple(max((abs(point[j]) for point in points), default=0) for j in range(len(self.tones)))


def excitation(system: System, modal: Modal) -> LineExcitation:
    """Sort the lines of a System into mesh orders and shaft orders; refuse a System without a steady response.

    Raises
    ------
    ModelError : no damping, or all of it zero; no mesh frequency; torques that do not balance.
    """
    require_damping(system)
    tones = mesh_tones(system)
    points = [(_multiple(tones, line.frequency), line) for line in system.lines]
    _require_balance(system, modal)
    return LineExcitation(
        tones=tones,
        axis=np.array([tones.index(system.tones[i]) for i in system.meshes.tone], dtype=np.int64),
        mesh=tuple((point, line) for point, line in points if point is not None),
        shaft=_grouped(tones, [line for point, line in points if point is None]),
    )


def require_damping(system: System) -> None:
    """Raise ModelError where nothing damps: no damping is given, or all of it is zero."""
    if not (system.zeta or np.any(system.C) or np.any(system.meshes.damping)):
        problem = "only zero damping is given" if system.damped else "no damping is given"
        raise ModelError(
            f"{problem}, so the response never settles",
            path="damping",
            allowed='e.g. damping = { modal = "3 %" }',
        )


def mesh_tones(system: System) -> tuple[Fraction, ...]:
    """Mesh frequencies that meshes follow [Hz] at the operating speed, that of the first mesh first.

    Raises
    ------
    ModelError : there is none, or one is zero.
    """
    tones = tuple(dict.fromkeys(system.tones[i] for i in system.meshes.tone)) if system.tones else ()
    if not tones or min(tones) <= 0:
        turns = any(system.body_turns)
        reason = ": the members of each stage turn as one" if turns else ""
        allowed = "members that turn against each other" if turns else "the speed of one member"
        raise ModelError(
            f"the response needs a mesh frequency above zero{reason}", path="operation.speed", allowed=allowed
        )
    return tones


def _multiple(tones: tuple[Fraction, ...], frequency: Fraction) -> Point | None:
    """Lattice point of least order at a multiple of one tone [Hz], None where the frequency is no multiple."""
    orders = [(frequency / tone, j) for j, tone in enumerate(tones)]
    whole = [(abs(order), int(order), j) for order, j in orders if order.denominator == 1]
    if not whole:
        return None
    _, order, axis = min(whole)
    return tuple(order if j == axis else 0 for j in range(len(tones)))


def _grouped(tones: tuple[Fraction, ...], lines: list[Line]) -> tuple[Shaft, ...]:
    """Group shaft lines that differ by, or add to, a multiple of a tone: they share one solution and one phase."""
    groups: dict[Fraction, list[tuple[Point, bool, Line]]] = {}
    for line in sorted(lines, key=lambda line: line.frequency):
        for base, members in groups.items():
            less, more = _multiple(tones, line.frequency - base), _multiple(tones, line.frequency + base)
            if less is not None or more is not None:
                members.append((less, False, line) if less is not None else (more or (), True, line))
                break
        else:
            groups[line.frequency] = [((0,) * len(tones), False, line)]
    return tuple(Shaft(frequency=base, members=tuple(members)) for base, members in groups.items())


def _require_balance(system: System, modal: Modal) -> None:
    """Refuse mean forces that work on a rigid mode: nothing would hold the train in place.

    Raises
    ------
    ModelError : the work on a rigid mode is more than rounding.
    """
    mean = system.force + sum((line.force[0].real for line in system.lines if line.frequency == 0), np.zeros(1))
    shapes = modal.shapes[:, modal.rigid]
    work, size = np.abs(shapes.T @ mean), np.abs(shapes.T) @ np.abs(mean)
    if np.any(work > _BALANCE * size):
        if coordinates := unheld(shapes, mean, system.dofs.names):
            raise unheld_error(coordinates)
        worst = int(np.argmax(work / np.where(size > 0, size, 1.0)))
        name = system.dofs.names[int(np.argmax(np.abs(shapes[:, worst] * system.dofs.radius)))]
        raise ModelError(
            f"the external torques and forces do not balance on the free motion of {name}: "
            f"{work[worst] / size[worst]:.3g} of them is left over",
            path="operation.torque",
            allowed="; ".join(filter(None, ("loads in equilibrium", contradicting_radii(system)))),
        )


def line_excitation(
    system: System, lines: LineExcitation, speed: Array, lattice: Lattice
) -> tuple[ComplexArray, ComplexArray]:
    """Errors (m, P S, J) [m] and forces (P S, J, n) [N, N m] at the points of a lattice, speeds outermost.

    Of a mirrored lattice those of the mesh orders, S = 1, constant loads included; else of every shaft group.
    speed : (P,) relative to the operating speed.
    """
    groups, index = lines.solved_together(shifted=not lattice.mirrored), _point_index(lattice)
    count, J = len(groups), len(lattice.points)
    error = np.zeros((len(system.meshes.name), speed.size * count, J), complex)
    force = np.zeros((speed.size * count, J, system.force.size), complex)
    if lattice.mirrored:
        force[:, 0] = system.force
    for number, members in enumerate(groups):
        for point, conjugate, line in members:
            gap, push = line.gap[:, None], speed_powers(speed) @ line.force
            error[:, number::count, index[point]] += gap.conj() if conjugate else gap
            force[number::count, index[point]] += push.conj() if conjugate else push
    if lattice.mirrored:
        error[:, :, 0], force[:, 0] = error[:, :, 0].real, force[:, 0].real
    return error, force


def link_errors(system: System, lines: LineExcitation, lattice: Lattice) -> ComplexArray:
    """Errors of the link rows at the points of a lattice, (p, S, J) [m, rad], S as of `line_excitation`.

    No speed changes them.
    """
    groups, index = lines.solved_together(shifted=not lattice.mirrored), _point_index(lattice)
    error = np.zeros((len(system.links.name), len(groups), len(lattice.points)), complex)
    for number, members in enumerate(groups):
        for point, conjugate, line in members:
            error[:, number, index[point]] += line.link_gap.conj() if conjugate else line.link_gap
    if lattice.mirrored:
        error[:, :, 0] = error[:, :, 0].real
    return error


def speed_powers(speed: Array) -> Array:
    """1, s and s^2 of relative speeds (P,), (P, 3): factors of the three parts of the force of a `Line`."""
    return np.stack([np.ones_like(speed), speed, speed**2], axis=1)


def _point_index(lattice: Lattice) -> dict[Point, int]:
    """Index of a point among the points of a lattice."""
    return {tuple(point): i for i, point in enumerate(lattice.points.tolist())}
