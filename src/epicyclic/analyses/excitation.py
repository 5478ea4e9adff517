"""What drives the periodic response: the exact lines of a System, sorted into mesh orders and shaft orders."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..errors import ModelError
from ..system.system import Array, ComplexArray, Line, System
from .basis import Modal

__all__ = ["Excitation", "Shaft", "excitation", "mesh_rows", "shaft_rows"]

# Torques balanced in the input leave rounding on a rigid mode, 1e-13 of the sum of magnitudes; a wrong one far more.
_BALANCE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shaft:
    """Lines that the mesh orders couple: their frequencies are order * tone + frequency, or order * tone - frequency.

    frequency : of the lowest of them [Hz] at the operating speed.
    members : (order, whether the second form holds, so that its conjugate counts, line).
    """

    frequency: Fraction
    members: tuple[tuple[int, bool, Line], ...]

    @property
    def causes(self) -> tuple[str, ...]:
        """Paths in the file that put something into any of the lines, once each."""
        return tuple(dict.fromkeys(cause for _, _, line in self.members for cause in line.causes))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Excitation:
    """Lines by kind.

    tone : mesh frequency [Hz] at the operating speed.
    mesh : (order, line) of each line at an integer multiple of the tone, 0 included.  shaft : the others, grouped.
    """

    tone: Fraction
    mesh: tuple[tuple[int, Line], ...]
    shaft: tuple[Shaft, ...]

    @property
    def highest(self) -> int:
        """Highest mesh order that a line stands on."""
        orders = [order for order, _ in self.mesh]
        return max(orders + [abs(order) for shaft in self.shaft for order, _, _ in shaft.members], default=0)


def excitation(system: System, modal: Modal) -> Excitation:
    """Sort the lines, and refuse a System that has no periodic response.

    Raises
    ------
    ModelError : no damping; no mesh frequency; several different mesh frequencies; torques that do not balance.
    """
    if not system.damped:
        raise ModelError(
            "no damping is given, so the response never settles",
            path="damping",
            allowed='e.g. damping = { modal = "3 %" }',
        )
    tone = _tone(system)
    multiples = [(line.frequency / tone, line) for line in system.lines]
    _balanced(system, modal)
    return Excitation(
        tone=tone,
        mesh=tuple((int(multiple), line) for multiple, line in multiples if multiple.denominator == 1),
        shaft=_grouped(tone, [line for multiple, line in multiples if multiple.denominator != 1]),
    )


def _grouped(tone: Fraction, lines: list[Line]) -> tuple[Shaft, ...]:
    """Shaft lines that differ by, or add to, a multiple of the tone respond together: one solve, one phase."""
    groups: dict[Fraction, list[Line]] = {}
    for line in sorted(lines, key=lambda line: line.frequency):
        rest = line.frequency % tone
        groups.setdefault(min(rest, tone - rest), []).append(line)
    shafts = []
    for members in groups.values():
        base = members[0].frequency
        placed = [((line.frequency - base) / tone, (line.frequency + base) / tone, line) for line in members]
        shafts.append(
            Shaft(
                frequency=base,
                members=tuple(
                    (int(less), False, line) if less.denominator == 1 else (int(more), True, line)
                    for less, more, line in placed
                ),
            )
        )
    return tuple(shafts)


def _tone(system: System) -> Fraction:
    tones = sorted({system.tones[i] for i in system.meshes.tone}) if system.tones else []
    if not tones or tones[0] <= 0:
        raise ModelError(
            "the response needs a mesh frequency above zero", path="operation.speed", allowed="the speed of one member"
        )
    if len(tones) > 1:
        listed = ", ".join(f"{float(tone):.6g} Hz" for tone in tones)
        raise ModelError(
            f"coupled stages with different mesh frequencies ({listed}) have no common period, and a periodic "
            "response exists for one mesh frequency only; static analysis works"
        )
    tone: Fraction = tones[0]
    return tone


def _balanced(system: System, modal: Modal) -> None:
    """Torques must do no work on a rigid mode: nothing would hold the train in place."""
    mean = system.force + sum((line.force[0].real for line in system.lines if line.frequency == 0), np.zeros(1))
    shapes = modal.shapes[:, modal.rigid]
    work, size = np.abs(shapes.T @ mean), np.abs(shapes.T) @ np.abs(mean)
    if np.any(work > _BALANCE * size):
        worst = int(np.argmax(work / np.where(size > 0, size, 1.0)))
        name = system.dofs.names[int(np.argmax(np.abs(shapes[:, worst] * system.dofs.radius)))]
        raise ModelError(
            f"the external torques and forces do not balance on the free motion of {name}: "
            f"{work[worst] / size[worst]:.3g} of them is left over "
            "(given radii that fit no one centre distance do this too)",
            path="operation.torque",
        )


def mesh_rows(system: System, lines: Excitation, speed: Array, *, harmonics: int) -> tuple[ComplexArray, ComplexArray]:
    """Errors (m, P, H + 1) [m] and forces (P, H + 1, n) [N] at mesh orders 0..H, for relative speeds (P,)."""
    error = np.zeros((len(system.meshes.name), speed.size, harmonics + 1), complex)
    force = np.zeros((speed.size, harmonics + 1, system.force.size), complex)
    force[:, 0] = system.force
    for order, line in lines.mesh:
        error[:, :, order] += line.gap[:, None]
        force[:, order] += _line_force(line, speed)
    error[:, :, 0], force[:, 0] = error[:, :, 0].real, force[:, 0].real
    return error, force


def shaft_rows(system: System, lines: Excitation, speed: Array, *, harmonics: int) -> tuple[ComplexArray, ComplexArray]:
    """Errors (m, P S, 2 H + 1) and forces (P S, 2 H + 1, n) of every shaft group at every speed (speeds outermost)."""
    count = len(lines.shaft)
    error = np.zeros((len(system.meshes.name), speed.size * count, 2 * harmonics + 1), complex)
    force = np.zeros((speed.size * count, 2 * harmonics + 1, system.force.size), complex)
    for place, shaft in enumerate(lines.shaft):
        for order, conjugate, line in shaft.members:
            # order * tone - frequency stands at -order around +frequency once conjugated
            row = harmonics + (-order if conjugate else order)
            gap, push = line.gap[:, None], _line_force(line, speed)
            error[:, place::count, row] += gap.conj() if conjugate else gap
            force[place::count, row] += push.conj() if conjugate else push
    return error, force


def _line_force(line: Line, speed: Array) -> ComplexArray:
    powers = np.stack([np.ones_like(speed), speed, speed**2], axis=1)
    force: ComplexArray = powers @ line.force
    return force
