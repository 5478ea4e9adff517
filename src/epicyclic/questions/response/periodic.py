"""Steady response at one speed over the cycle of a mesh frequency: mesh orders, and an envelope for each other line.

For comparison with it plain harmonic superposition: every frequency alone on the mean system.  With dbar the mean gap,
K xbar = F, and dk the varying part of a mesh stiffness,

    Z(w) X = sum of (k0 + i w c) e B - dk dbar B,    force = k0 (dbar + dX) + dk dbar + c dX'

that is, products of varying stiffness and varying gap are left out.  This is the mean system with the errors
e - dbar dk / (k0 + i w c), so that one solver serves both (derived here).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from ...errors import ConvergenceError, ModelError
from ...statics.record import samples_per_cycle
from ...system.system import Array, ComplexArray, Line, System, faces
from .measures import force_extremes
from .response import Block, Response, require_stable_mean, respond, response
from .waveform import (
    Spectrum,
    alias_free_samples,
    envelopes,
    force_signal,
    force_spectrum,
    mesh_axis,
    motion_spectrum,
    tone_waveform,
    whole_mesh_signal,
)

TOLERANCE = 1e-8
# A residual above this is refused, whatever tolerance was asked for.
_ACCEPTED = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShaftLine:
    """Response at frequencies that are no multiples of the tone of its `Periodic`.

    frequency : exact [Hz at the operating speed].  causes : paths in the file; of another mesh frequency its stages.
    force : (m, Nt) A_s(theta) [N]; it adds Re(A_s(theta) exp(2 pi i s f t)) to the mesh force at relative speed s.
    displacement : (n, Nt) the same of every coordinate [m, rad].
    Lines whose frequencies differ by, or add to, a multiple of the mesh frequency stand together in one.
    """

    frequency: Fraction
    causes: tuple[str, ...]
    force: ComplexArray
    displacement: ComplexArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Periodic:
    """Steady response over the phase of one mesh frequency.

    tone : that mesh frequency [Hz at the operating speed].  relative_speed : s, speed per operating speed.
    theta : (Nt,) mesh phase, (tone s t) mod 1.
    force : (m, Nt) mesh force at multiples of the tone with its mean, k(t) (B^T q - e) + c d/dt(B^T q - e) [N].
    displacement : (n, Nt) [m, rad].  lines : all other frequencies, of shafts and of other tones.
    harmonics : kept.  residual : relative, truncation included.
    bound : (w,) largest force of every whole mesh over all relative phases of tones and lines, as of `steady` [N]; None
        with one tone, where it is the largest of force and lines.
    """

    tone: Fraction
    relative_speed: float
    theta: Array
    force: Array
    displacement: Array
    lines: tuple[ShaftLine, ...]
    harmonics: int
    residual: float
    bound: Array | None = None


def periodic(
    system: System, *, relative_speed: float = 1.0, samples: int | None = None, tolerance: float = TOLERANCE
) -> Periodic:
    """Steady response of the linear-contact system at one speed, over the mesh cycle of the first mesh.

    Parameters
    ----------
    relative_speed : speed per operating speed, above zero.
    samples : of a mesh cycle; None takes as many as the harmonics need, 64 at least, in a multiple of the branches.
    tolerance : relative residual of the harmonics kept; the truncation is below 30 times that.  Lines of other tones
        that add up to less than it are left out.

    Raises
    ------
    ModelError : no damping, no mesh frequency, torques out of balance, or an option out of range.
    ConvergenceError : no solution; the speed lies on the edge of a parametric instability.
    """
    ready, block = solve_speed(system, relative_speed, tolerance)
    return _over_phase(ready, block, 0, samples, tolerance)


def periodic_by_tone(
    system: System, *, relative_speed: float = 1.0, samples: int | None = None, tolerance: float = TOLERANCE
) -> tuple[Periodic, ...]:
    """The steady response once over the mesh cycle of each tone, that of the first mesh first; as `periodic`."""
    ready, block = solve_speed(system, relative_speed, tolerance)
    return tuple(_over_phase(ready, block, axis, samples, tolerance) for axis in range(len(ready.lines.tones)))


def _over_phase(ready: Response, block: Block, axis: int, samples: int | None, tolerance: float) -> Periodic:
    """A solved block (P = 1) over the phase of the tone of one axis."""
    harmonics, meshes, tones = block.truncation[axis], ready.system.meshes, mesh_axis(ready)
    if samples is None:
        least = max(64, alias_free_samples(ready, harmonics))
        samples = samples_per_cycle(meshes, np.flatnonzero(tones == axis), least)
    theta = np.arange(checked_samples(samples)) / samples
    force, motion = force_spectrum(ready, block, shifted=False), motion_spectrum(ready, block, shifted=False)
    lines = _other_lines(ready, force, motion, axis, theta)
    if block.shaft is not None:
        shaft_force, shaft_motion = (find(ready, block, shifted=True) for find in (force_spectrum, motion_spectrum))
        lines += _other_lines(ready, shaft_force, shaft_motion, axis, theta)
    bound = None
    if len(ready.lines.tones) > 1:
        every = whole_mesh_signal(force_signal(ready, block), faces(meshes))
        bound = force_extremes(every, axis=tones)[1][:, 0]
    return Periodic(
        tone=ready.lines.tones[axis],
        relative_speed=float(block.speed[0]),
        theta=theta,
        force=tone_waveform(force, axis, theta)[:, 0, 0].real,
        displacement=tone_waveform(motion, axis, theta)[:, 0, 0].real,
        lines=tuple(_significant(ready, lines, tolerance)),
        harmonics=harmonics,
        residual=float(block.residual[0]),
        bound=bound,
    )


def _other_lines(ready: Response, force: Spectrum, motion: Spectrum, axis: int, theta: Array) -> list[ShaftLine]:
    """All harmonics but the multiples of one tone, a line for each combination of the others and each shaft line.

    theta : (Nt,) phase of the tone [cycles].
    """
    pushed, moved = envelopes(force, axis, theta), envelopes(motion, axis, theta)
    known = {(s, *rest): i for i, (s, rest) in enumerate(zip(moved.shaft.tolist(), moved.rests.tolist(), strict=True))}
    stages = list(zip(ready.lines.axis.tolist(), ready.system.meshes.stage, strict=True))
    lines = []
    for i, (s, rest) in enumerate(zip(pushed.shaft.tolist(), pushed.rests.tolist(), strict=True)):
        frequency = sum((a * tone for a, tone in zip(rest, ready.lines.tones, strict=True)), Fraction(0))
        if s >= 0:
            shaft = ready.lines.shaft[s]
            frequency, causes = frequency + shaft.frequency, shaft.causes
        else:
            causes = tuple(dict.fromkeys(f"{stage} mesh" for tone, stage in stages if rest[tone]))
        force_wave, wave = pushed.values[:, 0, i], np.zeros((moved.values.shape[0], theta.size), complex)
        if (s, *rest) in known:
            wave = moved.values[:, 0, known[s, *rest]]
        if frequency < 0:  # Re z = Re conj z
            frequency, force_wave, wave = -frequency, force_wave.conj(), wave.conj()
        lines.append(ShaftLine(frequency=frequency, causes=causes, force=force_wave, displacement=wave))
    return lines


def _significant(ready: Response, lines: list[ShaftLine], tolerance: float) -> list[ShaftLine]:
    """The lines without the smallest ones, as long as these add up to less than the tolerance in every signal."""
    if len(ready.lines.tones) == 1 or not lines:
        return lines
    radius = ready.system.dofs.radius[:, None]
    force = np.array([np.abs(line.force).max(axis=1) for line in lines])
    moved = np.array([np.abs(radius * line.displacement).max(axis=1) for line in lines])
    size = np.zeros(len(lines))
    for signal in (force, moved):
        size = np.maximum(size, (signal / max(float(signal.max()), np.finfo(float).tiny)).max(axis=1))
    order = np.argsort(size)
    needless = set(order[np.cumsum(size[order]) < tolerance].tolist())
    return [line for i, line in enumerate(lines) if i not in needless]


def solve_speed(system: System, relative_speed: float, tolerance: float) -> tuple[Response, Block]:
    """Solve one speed; arguments and errors as of `periodic`."""
    if not (math.isfinite(relative_speed) and relative_speed > 0):
        raise ModelError("out of range", path="relative_speed", given=relative_speed, allowed="a number above zero")
    if not 0 < tolerance < 1:
        raise ModelError("out of range", path="tolerance", given=tolerance, allowed="between 0 and 1")
    ready = response(system)
    require_stable_mean(ready, float(relative_speed))
    block = next(respond(ready, np.array([float(relative_speed)]), tolerance=tolerance))
    if not block.residual[0] <= max(_ACCEPTED, 100 * tolerance):
        frequency = float(ready.lines.tone) * relative_speed
        raise ConvergenceError(
            f"no periodic response found at {frequency:.6g} Hz mesh frequency (residual {block.residual[0]:.2g}): "
            "try a slightly different speed or more damping"
        )
    if block.uncertainty[0] > _ACCEPTED:
        raise ConvergenceError(
            f"at {float(ready.lines.tone) * relative_speed:.6g} Hz mesh frequency a resonance is so sharp that double "
            "precision cannot tell the response: try a slightly different speed or more damping"
        )
    return ready, block


def checked_samples(samples: int) -> int:
    """A number of samples, one at least.

    Raises
    ------
    ModelError : it is below one.
    """
    if samples < 1:
        raise ModelError("out of range", path="samples", given=samples, allowed="1 or more")
    return samples


def superposed(system: System, relative_speed: float) -> System:
    """The System of constant mesh stiffness whose steady response is the superposition at one relative speed.

    Raises
    ------
    ModelError, ConvergenceError : as of `periodic`, for the mean.
    """
    meshes = system.meshes
    static = replace(system, meshes=replace(meshes, variation=np.zeros((len(meshes.name), 0), complex)))
    mean = periodic(
        replace(static, lines=tuple(line for line in system.lines if line.frequency == 0)),
        relative_speed=relative_speed,
    )
    gap = mean.force.mean(axis=1) / meshes.stiffness
    extra: dict[Fraction, ComplexArray] = {}
    for number in np.unique(meshes.tone):
        rows = meshes.tone == number
        for order in range(1, meshes.variation.shape[1] + 1):
            frequency = system.tones[number] * order
            omega = 2 * np.pi * float(frequency) * relative_speed
            # the error that acts as this harmonic of dk dbar
            force = meshes.stiffness * meshes.variation[:, order - 1] * gap
            error = -force / (meshes.stiffness + 1j * omega * meshes.damping)
            extra[frequency] = extra.get(frequency, np.zeros(len(gap), complex)) + np.where(rows, error, 0.0)
    lines = [replace(line, gap=line.gap + extra.get(line.frequency, 0.0)) for line in system.lines]
    known = {line.frequency for line in lines}
    no_link_error, no_force = np.zeros(len(system.links.name), complex), np.zeros((3, len(system.force)), complex)
    lines += [
        Line(frequency=frequency, gap=error, link_gap=no_link_error, force=no_force, causes=("mesh stiffness",))
        for frequency, error in extra.items()
        if frequency not in known and error.any()
    ]
    return replace(static, lines=tuple(sorted(lines, key=lambda line: line.frequency)))
