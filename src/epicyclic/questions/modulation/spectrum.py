"""Spectrum in the axes of the stage, and the lines it gives at a fixed sensor that the planets pass."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.system import Array, ComplexArray, System, faces
from ..response.response import Block, Response
from ..response.waveform import Spectrum, force_spectrum, motion_spectrum
from .path import SensorPosition, Window

DIRECTIONS = ("radial", "tangential", "axial")
Index = NDArray[np.int64]
# A contribution below this share of the largest of its line is not reported among its origins.
_REPORTED = 1e-2
# Lines summed at once when a signal is synthesised.
_AT_ONCE = 2048


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StageSpectrum:
    """Spectrum in the axes of the stage: value = Re sum_r amplitude[:, r] exp(2 pi i frequency_r s t), R harmonics.

    step : (R,) whole numbers, frequency = step / unit [Hz].  carrier : the speed of the stage's axes in the same steps.
    shaft : (R,) index of the shaft line, -1 of mesh orders.  point : (R, D) multiples of the tones beside it.
    force : (p, R) of the meshes in the window [N].  motion : (6, R) of the bodies under the sensor [m, rad].
    """

    unit: int
    carrier: int
    step: NDArray[np.object_]
    shaft: Index
    point: Index
    force: ComplexArray
    motion: ComplexArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorContributions:
    """Contributions to the sensor: step = step of the harmonic + order * carrier.

    row, order : (C,) index of the harmonic, and turns of the carrier by which it is shifted.
    amplitude : (C,) complex [N or m].
    """

    row: Index
    order: Index
    amplitude: ComplexArray


def stage_spectrum(ready: Response, block: Block, position: SensorPosition) -> StageSpectrum:
    """Spectrum of a solved block (P = 1): mesh orders, then shaft orders."""
    kinds = (False,) if block.shaft is None else (False, True)
    parts = [_part(ready, block, position, shifted=shifted) for shifted in kinds]
    units = [unit for _, unit, *_ in parts]
    unit = lcm(*units, position.turn.denominator)
    return StageSpectrum(
        unit=unit,
        carrier=int(position.turn * unit),
        step=np.concatenate([part[0].ravel() * (unit // part[1]) for part in parts]),
        shaft=np.concatenate([part[2] for part in parts]),
        point=np.concatenate([part[3] for part in parts]),
        force=np.concatenate([part[4] for part in parts], axis=1),
        motion=np.concatenate([part[5] for part in parts], axis=1),
    )


def _part(
    ready: Response, block: Block, position: SensorPosition, *, shifted: bool
) -> tuple[NDArray[np.object_], int, Index, Index, ComplexArray, ComplexArray]:
    """Steps (S, K), their unit, shaft indices (S K,), points (S K, D), forces (p, S K) [N] and motion (6, S K) [m,
    rad].

    shifted : of the shaft orders.
    """
    steps, unit = ready.exact_frequencies(block.truncation, shifted=shifted)
    force = force_spectrum(ready, block, shifted=shifted)
    total = faces(ready.system.meshes).total(force.amplitude)
    motion = motion_spectrum(ready, block, shifted=shifted)
    lines, points = steps.shape[0], force.points
    moved = np.zeros((6, lines, len(points)), complex)
    moved[:, :, : len(motion.points)] = _body_motion(ready.system, motion, position)
    return (
        steps,
        unit,
        np.repeat(np.arange(lines) if shifted else np.full(1, -1), len(points)),
        np.tile(points, (lines, 1)),
        total[position.meshes, 0].reshape(len(position.meshes), -1),
        moved.reshape(6, -1),
    )


def _body_motion(system: System, motion: Spectrum, position: SensorPosition) -> ComplexArray:
    """Mean motion of the bodies under the sensor, (6, S, K) [m, rad]."""
    expand = np.zeros((6, len(system.force)))
    for body in position.bodies:
        expand += system.dofs.expand[6 * body : 6 * body + 6] / len(position.bodies)
    moved: ComplexArray = np.tensordot(expand, motion.amplitude[:, 0], axes=1)
    return moved


def windowed_forces(spectrum: StageSpectrum, position: SensorPosition, window: Window) -> SensorContributions:
    """Mesh forces [N] through the window of planets that pass [mcfadden1985] [mcnames2002], any frequencies and angles.

    w(psi_n + W t - beta) Re(A_n exp(i w t)) = Re sum_k c_k exp(i k (psi_n - beta)) A_n exp(i (w + k W) t)
    """
    force = position.share[:, None] * spectrum.force
    away = position.contact - position.angle
    if spectrum.carrier == 0:
        amplitude, orders = (window.at(away) @ force)[:, None], np.zeros(1, np.int64)
    else:
        reach = len(window.coefficients) - 1
        orders = np.arange(-reach, reach + 1)
        amplitude = (force.T @ np.exp(1j * np.outer(away, orders))) * window.sides
    return _contributions(amplitude, orders)


def sensor_motion(
    spectrum: StageSpectrum, position: SensorPosition, direction: str, radius: float
) -> SensorContributions:
    """Motion at the sensor, of the body it sits on, seen from the housing [m].

    The stage's axes turn by W t, so the sensor stands at b = beta - W t in them: radial x cos b + y sin b, tangential
    -x sin b + y cos b + r rz, axial z + r (rx sin b - ry cos b).  Derived from docs/conventions.md, axes.

    Parameters
    ----------
    direction : radial, tangential or axial.  radius : of the sensor from the axis [m].

    Raises
    ------
    ModelError : no such direction; a body that turns or tilts there, and no radius.
    """
    x, y, z, rx, ry, rz = spectrum.motion
    if direction == "radial":
        c, s, still = x, y, np.zeros_like(x)
    elif direction == "tangential":
        c, s, still = y, -x, _arm(radius, rz)
    elif direction == "axial":
        c, s, still = _arm(radius, -ry), _arm(radius, rx), z
    else:
        raise ModelError("no such direction", path="direction", given=direction, allowed=", ".join(DIRECTIONS))
    turn = np.exp(1j * position.angle)
    # c cos b + s sin b with b = beta - W t
    amplitude = np.stack([(c - 1j * s) / 2 * turn, still, (c + 1j * s) / 2 / turn], axis=1)
    return _contributions(amplitude, np.array([-1, 0, 1]))


def _arm(radius: float, angle: ComplexArray) -> ComplexArray:
    """Displacement radius * angle (R,) [m].

    Raises
    ------
    ModelError : an angle without a radius.
    """
    if not angle.any():
        return angle
    if not radius > 0:
        raise ModelError("the radius at which the sensor sits is needed here", path="radius", allowed="above zero")
    result: ComplexArray = radius * angle
    return result


def _contributions(amplitude: ComplexArray, orders: Index) -> SensorContributions:
    """Contributions that are not zero, amplitude (R, orders)."""
    row, column = np.nonzero(amplitude)
    return SensorContributions(row=row, order=orders[column], amplitude=amplitude[row, column])


class LineSource(NamedTuple):
    """A harmonic (row), shifted by `order` turns of the carrier.  negative : its conjugate."""

    row: int
    order: int
    negative: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorLines:
    """Lines at the sensor, frequencies rising, all above 0: value = Re sum_l amplitude_l exp(2 pi i frequency_l s t).

    frequency : exact [Hz at s = 1].  force : (L,) complex, of the meshes [N].  motion : (L,) complex, of the body [m].
    parts : sources of each line, the largest first, one of each shaft line that matters.
    """

    frequency: tuple[Fraction, ...]
    force: ComplexArray
    motion: ComplexArray
    parts: tuple[tuple[LineSource, ...], ...]


def merged_lines(spectrum: StageSpectrum, force: SensorContributions, motion: SensorContributions) -> SensorLines:
    """Merge contributions of equal frequency, compared exactly and added as complex numbers, without frequency 0."""
    row, order = np.concatenate([force.row, motion.row]), np.concatenate([force.order, motion.order])
    amplitude = np.concatenate([force.amplitude, motion.amplitude])
    at = spectrum.step[row] + order.astype(object) * spectrum.carrier
    moves = (at != 0).astype(bool)
    row, order, amplitude, at = row[moves], order[moves], amplitude[moves], _fitting_integers(at[moves])
    of_motion = (np.arange(moves.size) >= force.row.size)[moves]
    negative = np.asarray(at < 0, bool)
    step, line = np.unique(np.abs(at), return_inverse=True)
    value = np.where(negative, amplitude.conj(), amplitude)
    sums = np.zeros((2, step.size), complex)
    np.add.at(sums, (of_motion.astype(int), line), value)
    # a contribution of the motion names a line only where no force does
    size = np.where(of_motion, -1.0 / (1.0 + np.abs(amplitude)), np.abs(amplitude))
    rank = np.lexsort((-size, line))
    largest = size[rank[np.flatnonzero(np.diff(line[rank], prepend=-1))]]
    reported = rank[(size[rank] >= _REPORTED * largest[line[rank]]) | (size[rank] == largest[line[rank]])]
    return SensorLines(
        frequency=tuple(Fraction(int(count), spectrum.unit) for count in step),
        force=sums[0],
        motion=sums[1],
        parts=_parts(
            step.size,
            line[reported],
            spectrum.shaft[row[reported]],
            map(LineSource, row[reported].tolist(), order[reported].tolist(), negative[reported].tolist()),
        ),
    )


def _fitting_integers(at: NDArray[np.object_]) -> NDArray[np.object_] | Index:
    """Whole numbers (C,) as 64-bit integers where they fit: these are sorted much faster."""
    fits = at.size == 0 or max(at.max(), -at.min()) < 2**62
    return at.astype(np.int64) if fits else at


def _parts(count: int, line: Index, shaft: Index, parts: Iterable[LineSource]) -> tuple[tuple[LineSource, ...], ...]:
    """First source of each shaft line in each of `count` lines; line, shaft : (C,) index of line and shaft line."""
    sources: list[dict[int, LineSource]] = [{} for _ in range(count)]
    for number, of_shaft, source in zip(line.tolist(), shaft.tolist(), parts, strict=True):
        sources[number].setdefault(of_shaft, source)
    return tuple(tuple(by_shaft.values()) for by_shaft in sources)


def synthesised_signal(frequency: Array, amplitude: ComplexArray, duration: float, samples: int) -> Array:
    """Re sum_l amplitude_l exp(2 pi i frequency_l t) at `samples` even instants of a duration [s], the end left out.

    frequency : (L,) [Hz].  amplitude : (L,) complex.  Returns (samples,).
    Instants are a start and a step after it, exp(i w (t_a + t_b)) a product: few exponentials and one matrix product.
    """
    steps = max(1, int(np.sqrt(samples)))
    starts = -(-samples // steps)
    result = np.zeros((starts, steps))
    turn = 2j * np.pi * frequency * (duration / samples)
    for first in range(0, frequency.size, _AT_ONCE):
        lines = slice(first, first + _AT_ONCE)
        coarse = np.exp(np.outer(np.arange(starts) * steps, turn[lines]))
        fine = amplitude[lines, None] * np.exp(np.outer(turn[lines], np.arange(steps)))
        result += coarse.real @ fine.real - coarse.imag @ fine.imag
    values: Array = result.ravel()[:samples]
    return values
