"""Rows of a solved response with exact frequencies, and what a sensor that they pass makes of them."""

from __future__ import annotations

from dataclasses import dataclass
from math import lcm

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.faces import faces
from ...system.system import ComplexArray, System
from ..steady.response import Block, Response
from ..steady.waveform import Spectrum, force_spectrum, motion_spectrum
from .place import Place
from .windows import Window

__all__ = ["DIRECTIONS", "Passed", "Rows", "felt", "gathered", "heard"]

DIRECTIONS = ("radial", "tangential", "axial")
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rows:
    """Rows in the axes of the stage: value = Re sum_r amplitude[:, r] exp(2 pi i frequency_r s t).

    step : (R,) whole numbers, frequency = step / unit [Hz].  carrier : the speed of the stage's axes in the same steps.
    shaft : (R,) number of the shaft line, -1 of mesh orders.  point : (R, D) multiples of the tones beside it.
    force : (p, R) of the meshes heard [N].  motion : (6, R) of what the sensor sits on [m, rad].
    """

    unit: int
    carrier: int
    step: NDArray[np.object_]
    shaft: Index
    point: Index
    force: ComplexArray
    motion: ComplexArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Passed:
    """Contributions to the sensor: step = step of row + order * carrier.

    row, order : (C,) which row, moved by how many turns of the carrier.  amplitude : (C,) complex.
    """

    row: Index
    order: Index
    amplitude: ComplexArray


def gathered(ready: Response, block: Block, place: Place) -> Rows:
    """All rows of mesh and shaft orders, one after the other."""
    kinds = (False,) if block.shaft is None else (False, True)
    parts = [_part(ready, block, place, shifted=shifted) for shifted in kinds]
    units = [unit for _, unit, *_ in parts]
    unit = lcm(*units, place.turn.denominator)
    return Rows(
        unit=unit,
        carrier=int(place.turn * unit),
        step=np.concatenate([part[0].ravel() * (unit // part[1]) for part in parts]),
        shaft=np.concatenate([part[2] for part in parts]),
        point=np.concatenate([part[3] for part in parts]),
        force=np.concatenate([part[4] for part in parts], axis=1),
        motion=np.concatenate([part[5] for part in parts], axis=1),
    )


def _part(
    ready: Response, block: Block, place: Place, *, shifted: bool
) -> tuple[NDArray[np.object_], int, Index, Index, ComplexArray, ComplexArray]:
    """Steps, their unit, shaft numbers, points, forces and motion of one kind of rows."""
    steps, unit = ready.steps(block.kept, shifted=shifted)
    force = force_spectrum(ready, block, shifted=shifted)
    total = faces(ready.system.meshes).total(force.amplitude)
    motion = motion_spectrum(ready, block, shifted=shifted)
    lines, points = steps.shape[0], force.points
    moved = np.zeros((6, lines, len(points)), complex)
    moved[:, :, : len(motion.points)] = _six(ready.system, motion, place)
    return (
        steps,
        unit,
        np.repeat(np.arange(lines) if shifted else np.full(1, -1), len(points)),
        np.tile(points, (lines, 1)),
        total[place.meshes, 0].reshape(len(place.meshes), -1),
        moved.reshape(6, -1),
    )


def _six(system: System, motion: Spectrum, place: Place) -> ComplexArray:
    """Mean motion of the bodies the sensor sits on, (6, S, K)."""
    rows = np.zeros((6, len(system.force)))
    for body in place.bodies:
        rows += system.dofs.expand[6 * body : 6 * body + 6] / len(place.bodies)
    moved: ComplexArray = np.tensordot(rows, motion.amplitude[:, 0], axes=1)
    return moved


def heard(rows: Rows, place: Place, window: Window) -> Passed:
    """Mesh forces through the window of planets that pass: [mcfadden1985], [mcnames2002] with any rows and any angles.

    w(psi_n + W t - beta) Re(A_n exp(i w t)) = Re sum_k c_k exp(i k (psi_n - beta)) A_n exp(i (w + k W) t)
    """
    force = place.share[:, None] * rows.force
    away = place.contact - place.angle
    if rows.carrier == 0:
        amplitude, orders = (window.at(away) @ force)[:, None], np.zeros(1, np.int64)
    else:
        reach = len(window.coefficients) - 1
        orders = np.arange(-reach, reach + 1)
        amplitude = (force.T @ np.exp(1j * np.outer(away, orders))) * window.sides
    return _passed(amplitude, orders)


def felt(rows: Rows, place: Place, direction: str, radius: float) -> Passed:
    """Motion at the sensor, of the body it sits on, seen from the housing [m].

    The stage's axes turn by W t, so the sensor stands at b = beta - W t in them: radial x cos b + y sin b, tangential
    -x sin b + y cos b + r rz, axial z + r (rx sin b - ry cos b).

    Raises
    ------
    ModelError : no such direction; a body that turns or tilts there, and no radius.
    """
    x, y, z, rx, ry, rz = rows.motion
    if direction == "radial":
        c, s, still = x, y, np.zeros_like(x)
    elif direction == "tangential":
        c, s, still = y, -x, _arm(radius, rz)
    elif direction == "axial":
        c, s, still = _arm(radius, -ry), _arm(radius, rx), z
    else:
        raise ModelError("no such direction", path="direction", given=direction, allowed=", ".join(DIRECTIONS))
    turn = np.exp(1j * place.angle)
    # c cos b + s sin b with b = beta - W t
    amplitude = np.stack([(c - 1j * s) / 2 * turn, still, (c + 1j * s) / 2 / turn], axis=1)
    return _passed(amplitude, np.array([-1, 0, 1]))


def _arm(radius: float, angle: ComplexArray) -> ComplexArray:
    if not angle.any():
        return angle
    if not radius > 0:
        raise ModelError("the radius at which the sensor sits is needed here", path="radius", allowed="above zero")
    result: ComplexArray = radius * angle
    return result


def _passed(amplitude: ComplexArray, orders: Index) -> Passed:
    row, column = np.nonzero(amplitude)
    return Passed(row=row, order=orders[column], amplitude=amplitude[row, column])
