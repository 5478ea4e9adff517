"""Spectrum at a fixed sensor that the planets pass: its lines, the window of a passing planet, the transfer function.

A window is the gain of a planet over the angle between it and the sensor, as a Fourier series:

    w(phi) = Re(c_0 + 2 sum_k c_k exp(i k phi)),  phi = angle of the planet's contact less that of the sensor

A Hann window over 2 pi / N passes one planet at a time [inalpolat2009]; one over a whole turn, ``cos2``, falls smoothly
to the far side of the ring [mcfadden1985].  The transfer function is a table of gain and phase over frequency.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...system.system import Array, ComplexArray, Index, System, faces
from ..response.response import Block, Response
from ..response.spectra import Spectrum, force_spectrum, motion_spectrum

HOUSING = "housing"
# Planets count as evenly spaced within this angle [turns]: angles go through degrees and radians.
_EVEN = 1e-9
WORDS = "hann, gaussian, cos2, cos4, ..., constant, or a table of angles and gains"
# A window is cut where what is left of it is 1e-8 of its mean square (1e-4 of a line), at the latest at 240 harmonics.
_REMAINDER, _MAX_HARMONICS, _LONG = 1e-8, 240, 4096
_HIGHEST_POWER = 200
ACCELERATION = "m/s2/N"


# --- the sensor ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True, eq=False)
class SensorPosition:
    """A sensor and the meshes that pass it.

    stage : of the meshes.  bodies : indices of the bodies under the sensor, none on the housing.
    turn : speed of the stage's axes, exact [rev/s at s = 1].  angle : of the sensor, seen from the housing [rad].
    meshes : (p,) whole meshes in the window.  share : (p,) of their force [1].  contact : (p,) angle in the stage axes
        [rad].
    branches : (N,) of these meshes.  spacing : (N,) angles of the branches [rad].
    teeth : of the ring, with the sign of the direction in which they pass the planets; None where they do not, or are
        no whole number.  others : the same of all central gears at the same mesh frequency, where they are.
    sensor : number of that of the model whose rows count in place of the motion of the bodies; -1: none.
    """

    stage: str
    bodies: tuple[int, ...]
    turn: Fraction
    angle: float
    meshes: NDArray[np.int64]
    share: Array
    contact: Array
    branches: tuple[int, ...]
    spacing: Array
    teeth: int | None
    others: tuple[int, ...] = ()
    sensor: int = -1

    @cached_property
    def even(self) -> bool:
        """Whether the planets are evenly spaced, and in step with all central gears as they are with the ring."""
        count = len(self.spacing)
        gaps = np.diff(np.sort(self.spacing / (2 * math.pi) % 1.0))
        in_step = self.teeth is None or not any((teeth - self.teeth) % count for teeth in self.others)
        return in_step and bool(np.all(np.abs(gaps - 1 / count) < _EVEN))


def sensor_position(
    system: System, *, stage: str | None, body: str | None, angle: float, through_planet: float = 0.0
) -> SensorPosition:
    """Find the meshes of a stage that pass a sensor.

    Parameters
    ----------
    stage : None: the first one whose ring stands still.  body : under the sensor, a body or member of the stage
        that does not turn, or ``housing``; None: the ring.  angle : in the axes of the housing, which are those of the
        stage at t = 0 [rad].  through_planet : share of the other meshes of a branch that its planet passes on [1].

    Raises
    ------
    ModelError : no speeds; no such stage or body; no ring; a body that turns.
    """
    if not system.body_turns or not system.meshes.ends:
        raise ModelError(
            "what passes a sensor needs a speed", path="operation.speed", allowed="the speed of one member"
        )
    stage = _stage(system, stage)
    first = faces(system.meshes).first
    homes = mesh_stages(system)
    rings = [w for w, row in enumerate(first) if homes[row] == stage and system.meshes.internal[row]]
    if not rings:
        raise ModelError("this stage has no ring for its planets to pass along", path="stage", given=stage)
    bodies = _bodies(system, stage, body, [system.meshes.ends[first[w]][1] for w in rings])
    passing = [w for w in rings if system.meshes.ends[first[w]][1] in bodies] or rings
    angles = {system.meshes.branch[first[w]]: float(system.meshes.direction[first[w]]) for w in passing}
    others = []
    if through_planet:  # the meshes of these branches that are no ring meshes
        not_rings = [(w, row) for w, row in enumerate(first) if w not in rings and homes[row] == stage]
        others = [w for w, row in not_rings if system.meshes.branch[row] in angles]
    meshes = np.array([*passing, *others], np.int64)
    return SensorPosition(
        stage=stage,
        bodies=tuple(system.dofs.bodies.index(name) for name in bodies),
        turn=system.stage_turns[stage],
        angle=angle,
        meshes=meshes,
        share=np.array([1.0] * len(passing) + [through_planet] * len(others)),
        contact=np.array([angles[system.meshes.branch[first[w]]] for w in meshes]),
        branches=tuple(angles),
        spacing=np.array(list(angles.values())),
        teeth=_teeth(system, int(first[passing[0]]), 1),
        others=_central(system, stage, int(first[passing[0]])),
    )


def mesh_stages(system: System) -> tuple[str, ...]:
    """Stage of each mesh row; a stage whose gears turn at two mesh frequencies has two labels in `MeshRows`."""
    return tuple(name.split("/")[0] for name in system.meshes.name)


def _stage(system: System, stage: str | None) -> str:
    """Name of the stage.

    Raises
    ------
    ModelError : no such stage.
    """
    homes = mesh_stages(system)
    known = tuple(dict.fromkeys(homes))
    if stage is not None:
        if stage not in known:
            raise ModelError("no such stage", path="stage", given=stage, allowed=", ".join(known))
        return stage
    turns = _body_turns(system)
    rows = zip(homes, system.meshes.internal, system.meshes.ends, strict=True)
    return next((name for name, internal, ends in rows if internal and turns[ends[1]] == 0), known[0])


def _body_turns(system: System) -> dict[str, Fraction]:
    """Absolute speed of every body, exact [rev/s at s = 1]."""
    return dict(zip(system.dofs.bodies, system.body_turns, strict=True))


def _bodies(system: System, stage: str, body: str | None, rings: list[str]) -> tuple[str, ...]:
    """Names of the bodies under the sensor; both halves of a member that is split.

    Raises
    ------
    ModelError : no such central body, or it turns.
    """
    if body == HOUSING:
        return ()
    central = [name for name in system.dofs.bodies if name.split("/")[0] == stage and not _branched(name)]
    named = rings if body is None else [name for name in central if name == body or name.startswith(f"{body}/")]
    wanted = tuple(dict.fromkeys(named))
    turns = _body_turns(system)
    still = [name for name in central if turns[name] == 0]
    if not wanted:
        raise ModelError("no such central body", path="body", given=body, allowed=", ".join([*still, HOUSING]))
    if any(turns[name] for name in wanted):
        raise ModelError(
            f"{wanted[0]} turns at {float(60 * turns[wanted[0]]):.6g} rpm: no sensor stands still on it",
            path="body",
            given=body or wanted[0],
            allowed=", ".join([*still, HOUSING]),
        )
    return wanted


def _branched(name: str) -> bool:
    """Whether a body belongs to a branch."""
    return any(part.isdigit() for part in name.split("/"))


def _teeth(system: System, row: int, end: int) -> int | None:
    """Teeth of one end of a mesh from its mesh frequency, negative where they pass the planets clockwise."""
    turns = _body_turns(system)
    passing = turns[system.meshes.ends[row][end]] - system.stage_turns[mesh_stages(system)[row]]
    teeth = system.tones[system.meshes.tone[row]] / passing if passing and system.tones else Fraction(1, 2)
    return int(teeth) if teeth.denominator == 1 else None


def _central(system: System, stage: str, ring: int) -> tuple[int, ...]:
    """Teeth of every central gear of a stage that turns at the mesh frequency of a ring mesh."""
    meshes, homes = system.meshes, mesh_stages(system)
    gears = [
        _teeth(system, row, end)
        for row, ends in enumerate(meshes.ends)
        for end, name in enumerate(ends)
        if homes[row] == stage and meshes.tone[row] == meshes.tone[ring] and not _branched(name)
    ]
    return tuple(dict.fromkeys(teeth for teeth in gears if teeth is not None))


# --- windows ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Window:
    """Window as a Fourier series.

    name : for people.  coefficients : (K + 1,) complex c_0 .. c_K, two-sided, c_0 real [1].
    remainder : RMS of the harmonics left out per RMS of the window [1].
    """

    name: str
    coefficients: ComplexArray
    remainder: float = 0.0

    @property
    def sides(self) -> ComplexArray:
        """Coefficients c_-K .. c_K, (2 K + 1,)."""
        return np.concatenate([self.coefficients[:0:-1].conj(), self.coefficients])

    def at(self, angle: ArrayLike) -> Array:
        """Gain at angles [rad], of their shape."""
        phi = np.asarray(angle, dtype=float)[..., None]
        orders = np.arange(1, len(self.coefficients))
        wave = (self.coefficients[1:] * np.exp(1j * orders * phi)).real.sum(axis=-1)
        return np.asarray(self.coefficients[0].real + 2 * wave)


def named_window(word: str, *, planets: int, width: float | None = None) -> Window:
    """Window by name, with gain 1 under the sensor.

    Parameters
    ----------
    word : ``hann``; ``gaussian``; ``cos2``, ``cos4``, ...: cos^n(phi/2); ``constant``.
    planets : N, for the default widths.  width : of ``hann`` from zero to zero, default 2 pi / N; of ``gaussian`` the
        standard deviation, default pi / (2 N) [rad].

    Raises
    ------
    ModelError : no such window; a width out of range or where there is none.
    """
    power = re.fullmatch(r"cos(\d{1,3})", word)
    if word not in ("hann", "gaussian", "constant") and not power:
        raise ModelError("no such window", path="window", given=word, allowed=WORDS)
    if width is not None:
        if word not in ("hann", "gaussian"):
            raise ModelError(f"a window {word} has no width", path="width", given=width, allowed="hann, gaussian")
        if not 0 < width <= 2 * math.pi:
            raise ModelError("out of range", path="width", given=width, allowed="above 0, up to one turn")
    if word == "constant":
        return Window(name=word, coefficients=np.ones(1, complex))
    if power:
        return _cosine_power(word, int(power[1]))
    orders = np.arange(_LONG + 1.0)
    if word == "gaussian":
        sigma = math.pi / (2 * planets) if width is None else width
        return _cut(word, sigma / math.sqrt(2 * math.pi) * np.exp(-((orders * sigma) ** 2) / 2))
    return _cut(word, _hann(orders, (2 * math.pi / planets if width is None else width) / 2))


def tabulated_window(angle: ArrayLike, gain: ArrayLike) -> Window:
    """Window through given gains, linear between them, round the whole turn.

    Parameters
    ----------
    angle : (k,) rising, within one turn [rad].  gain : (k,) none negative, not all zero [1].

    Raises
    ------
    ModelError : empty or unequal columns, a number that is not finite, negative gains, angles that do not rise.
    """
    phi, value = np.atleast_1d(np.asarray(angle, float)), np.atleast_1d(np.asarray(gain, float))
    if not phi.size or phi.shape != value.shape or phi.ndim != 1:
        problem = "needs as many gains as angles, one at least"
        raise ModelError(problem, path="window", given=f"{phi.size}, {value.size}")
    if not (np.isfinite(phi).all() and np.isfinite(value).all()):
        raise ModelError("holds a number that is not finite", path="window")
    if (value < 0).any() or not value.any():
        problem = "gains of a table are not negative, and not all zero"
        raise ModelError(problem, path="window", given=float(value.min()), allowed=">= 0")
    if (np.diff(phi) <= 0).any() or phi[-1] - phi[0] >= 2 * math.pi:
        raise ModelError("angles must rise and stay within one turn", path="window", given=phi.tolist())
    return _cut("table", _piecewise(phi, value, np.arange(_LONG + 1.0)))


def _cosine_power(word: str, power: int) -> Window:
    """Window cos^2p(phi/2) = 4^-p sum_k binomial(2p, p + k) exp(i k phi).

    Raises
    ------
    ModelError : the power is odd or too large.
    """
    if power < 2 or power % 2 or power > _HIGHEST_POWER:
        allowed = f"cos2, cos4 .. cos{_HIGHEST_POWER}"
        raise ModelError("the power must be even", path="window", given=word, allowed=allowed)
    half = power // 2
    values = [math.comb(power, half + k) / 4**half for k in range(half + 1)]
    return Window(name=word, coefficients=np.array(values, complex))


def _hann(orders: Array, half: float) -> Array:
    """Fourier coefficients of orders (K,) of cos^2(pi phi / 2 half) for |phi| < half [rad]."""
    edge = math.pi / half
    centre, below, above = (np.sinc(half * order / math.pi) for order in (orders, orders - edge, orders + edge))
    return half / (2 * math.pi) * (centre + (below + above) / 2)


def _piecewise(phi: Array, value: Array, orders: Array) -> ComplexArray:
    """Fourier coefficients of orders (K,) of the straight lines through (phi, value), both (k,).

    The second derivative of the lines is the jumps of their slope.
    """
    result = np.zeros(orders.size, complex)
    step = np.diff(phi, append=phi[0] + 2 * math.pi)
    following = np.roll(value, -1)
    result[0] = ((value + following) / 2 * step).sum() / (2 * math.pi)
    slope = (following - value) / step
    jump = slope - np.roll(slope, 1)
    result[1:] = -(np.exp(-1j * np.outer(orders[1:], phi)) @ jump) / (2 * math.pi * orders[1:] ** 2)
    return result


def _cut(name: str, values: Array | ComplexArray) -> Window:
    """Window of the leading coefficients `values` (K + 1,), as many as `_REMAINDER` asks, or the most there may be."""
    power = np.abs(values) ** 2 * np.where(np.arange(len(values)) > 0, 2.0, 1.0)
    left = np.append(np.cumsum(power[::-1])[::-1], 0.0)[1:]  # behind each harmonic
    last = min(int(np.flatnonzero(left <= _REMAINDER * power.sum())[0]), _MAX_HARMONICS)
    return Window(
        name=name,
        coefficients=np.asarray(values[: last + 1], complex),
        remainder=math.sqrt(float(left[last] / power.sum())),
    )


# --- transfer functions ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Transfer:
    """Transfer function, signal per force.

    frequency : (k,) rising [Hz].  gain : (k,).  phase : (k,) unwrapped [rad].
    unit : ``1``, the signal stays a force; ``m/s2/N``, it becomes an acceleration.
    """

    frequency: Array
    gain: Array
    phase: Array
    unit: str

    def at(self, frequency: Array) -> ComplexArray:
        """Complex gain at frequencies [Hz], of their shape; gain and phase linear in the table, 0 outside."""
        size = np.interp(frequency, self.frequency, self.gain, left=0.0, right=0.0)
        return np.asarray(size * np.exp(1j * np.interp(frequency, self.frequency, self.phase)))

    def covers(self, frequency: Array) -> NDArray[np.bool_]:
        """Whether each frequency [Hz] lies within the table, of their shape."""
        return np.asarray((frequency >= self.frequency[0]) & (frequency <= self.frequency[-1]), bool)


def tabulated_transfer(frequency: ArrayLike, gain: ArrayLike, phase: ArrayLike = 0.0, *, unit: str = "1") -> Transfer:
    """Transfer function from columns of a measured or computed frequency response.

    Parameters
    ----------
    frequency : (k,) rising, not negative [Hz].  gain : (k,) not negative.  phase : (k,) or one [rad].
    unit : of the gain, ``1`` or ``m/s2/N``.

    Raises
    ------
    ModelError : fewer than two rows, unequal columns, numbers out of range or not finite, an unknown unit.
    """
    if unit not in ("1", ACCELERATION):
        raise ModelError("no such unit of a transfer path", path="transfer", given=unit, allowed=f"1, {ACCELERATION}")
    f, size = np.atleast_1d(np.asarray(frequency, float)), np.atleast_1d(np.asarray(gain, float))
    if f.size < 2 or f.shape != size.shape or f.ndim != 1 or np.size(phase) not in (1, f.size):
        raise ModelError("needs two rows or more, and columns of one length", path="transfer", given=f"{f.size} rows")
    angle = np.broadcast_to(np.asarray(phase, float).ravel(), f.shape)
    if not all(np.isfinite(column).all() for column in (f, size, angle)):
        raise ModelError("holds a number that is not finite", path="transfer")
    if f[0] < 0 or (np.diff(f) <= 0).any() or (size < 0).any():
        raise ModelError("frequencies must rise from 0 or more, and gains are not negative", path="transfer")
    return Transfer(frequency=f, gain=size, phase=np.unwrap(angle), unit=unit)


# A contribution below this share of the largest of its line is not reported among its origins.
_REPORTED = 1e-2
# Lines summed at once when a signal is synthesised.
_AT_ONCE = 2048


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StageSpectrum:
    """Spectrum in the axes of the stage: value = Re sum_r amplitude[:, r] exp(2 pi i frequency_r s t), R harmonics.

    step : (R,) whole numbers, frequency = step / unit [Hz].  carrier : the speed of the stage's axes in the same steps.
    shaft : (R,) index of the shaft line, -1 of mesh orders.  point : (R, D) multiples of the tones beside it.
    force : (p, R) of the meshes in the window [N].  motion : (6, R) of the bodies under the sensor [m, rad], or (r, R)
        of the rows of a sensor of the model, real and imaginary parts.
    """

    unit: int
    carrier: int
    step: NDArray[np.object_]
    shaft: Index
    point: Index
    force: ComplexArray
    motion: ComplexArray


class SensorContributions(NamedTuple):
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
    joined = {name: np.concatenate([part[name] for part in parts], axis=-1) for name in parts[0]}
    own = ready.exact_frequencies(block.truncation, shifted=False)[1]  # the unit of both kinds
    unit = math.lcm(own, position.turn.denominator)
    joined |= {"step": joined["step"] * (unit // own), "point": joined["point"].T}
    return StageSpectrum(unit=unit, carrier=int(position.turn * unit), **joined)


def _part(ready: Response, block: Block, position: SensorPosition, *, shifted: bool) -> dict[str, NDArray[Any]]:
    """Fields of `StageSpectrum`, steps in the unit of `Response.exact_frequencies`, points (D, R).

    shifted : of the shaft orders.
    """
    steps, _ = ready.exact_frequencies(block.truncation, shifted=shifted)
    force = force_spectrum(ready, block, shifted=shifted)
    total = faces(ready.system.meshes).total(force.amplitude)
    motion = motion_spectrum(ready, block, shifted=shifted)
    lines, points = steps.shape[0], force.points
    own = _body_motion(ready.system, motion, position)
    moved = np.zeros((len(own), lines, len(points)), complex)
    moved[:, :, : len(motion.points)] = own
    return {
        "step": steps.ravel(),
        "shaft": np.repeat(np.arange(lines) if shifted else np.full(1, -1), len(points)),
        "point": np.tile(points, (lines, 1)).T,
        "force": total[position.meshes, 0].reshape(len(position.meshes), -1),
        "motion": moved.reshape(len(own), -1),
    }


def _body_motion(system: System, motion: Spectrum, position: SensorPosition) -> ComplexArray:
    """Mean motion of the bodies under the sensor, (6, S, K) [m, rad], or the rows of one of the model, (r, S, K)."""
    expand = np.zeros((6, len(system.force)))
    if position.sensor >= 0:
        rows = system.sensors.rows[position.sensor].reshape(-1, len(system.force))
        expand = np.stack([rows.real, rows.imag], axis=1).reshape(-1, rows.shape[1])
    for body in position.bodies if position.sensor < 0 else ():
        expand += system.dofs.rigid[6 * body : 6 * body + 6] / len(position.bodies)
    return np.tensordot(expand, motion.amplitude[:, 0], axes=1)


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
    ModelError : a body that turns or tilts there, and no radius.
    """
    x, y, z, rx, ry, rz = spectrum.motion
    if direction == "radial":
        c, s, still = x, y, np.zeros_like(x)
    elif direction == "tangential":
        c, s, still = y, -x, _arm(radius, rz)
    else:
        c, s, still = _arm(radius, -ry), _arm(radius, rx), z
    turn = np.exp(1j * position.angle)
    # c cos b + s sin b with b = beta - W t
    amplitude = np.stack([(c - 1j * s) / 2 * turn, still, (c + 1j * s) / 2 / turn], axis=1)
    return _contributions(amplitude, np.array([-1, 0, 1]))


def own_signal(spectrum: StageSpectrum, rows: ComplexArray) -> SensorContributions:
    """Signal of a sensor of the model on what stands in the housing, at the operating speed [1, m/s2].

    rows : (3, K + 1, n) of `SensorRows`, whose real and imaginary parts are the motion of the spectrum.
    """
    count = rows.shape[1]
    parts = spectrum.motion.reshape(3, count, 2, -1)
    orders = np.arange(1 - count, count)
    amplitude = np.zeros((spectrum.step.size, orders.size), complex)
    for column, order in enumerate(orders.tolist()):  # the material turns backwards in the axes of the stage
        k, sense = abs(order), -1 if order > 0 else 1
        value = (parts[:, k, 0] + 1j * sense * parts[:, k, 1]) / (2 if k else 1)
        omega = 2 * np.pi * ((spectrum.step + order * spectrum.carrier) / spectrum.unit).astype(float)
        amplitude[:, column] = value[0] + 1j * omega * value[1] - omega**2 * value[2]
    return _contributions(amplitude, orders)


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
    return radius * angle


def _contributions(amplitude: ComplexArray, orders: Index) -> SensorContributions:
    """Contributions that are not zero, amplitude (R, orders)."""
    row, column = np.nonzero(amplitude)
    return SensorContributions(row=row, order=orders[column], amplitude=amplitude[row, column])


class LineSource(NamedTuple):
    """A harmonic (row), shifted by `order` turns of the carrier.  negative : its conjugate."""

    row: int
    order: int
    negative: bool


class SensorLines(NamedTuple):
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
    return result.ravel()[:samples]
