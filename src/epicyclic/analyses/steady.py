"""The steady response at one speed: mesh orders over a mesh cycle, and one envelope for each other frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConvergenceError, ModelError
from ..system.system import Array, ComplexArray, System
from .extremes import force_extremes
from .response import Block, Response, respond, response
from .waveform import (
    Spectrum,
    envelopes,
    force_spectrum,
    mean_square,
    motion_spectrum,
    on_torus,
    own_waves,
    samples_needed,
)

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Periodic", "ShaftLine", "periodic", "periodic_by_tone", "steady"]

_TOLERANCE = 1e-8
# Beyond this a residual is no answer, whatever tolerance was asked for.
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
    """A steady response, told over the phase of one mesh frequency.

    tone : that mesh frequency [Hz at the operating speed]; relative_speed : s, speed per operating speed.
    theta : (Nt,) mesh phase, (tone s t) mod 1.
    force : (m, Nt) mesh force at multiples of the tone with its mean, k(t) (B^T q - e) + c d/dt(...) [N].
    displacement : (n, Nt) [m, rad].  lines : all other frequencies, of shafts and of other tones.
    harmonics : kept; residual : relative, with the harmonics dropped.
    """

    tone: Fraction
    relative_speed: float
    theta: Array
    force: Array
    displacement: Array
    lines: tuple[ShaftLine, ...]
    harmonics: int
    residual: float


def periodic(
    system: System, *, relative_speed: float = 1.0, samples: int | None = None, tolerance: float = _TOLERANCE
) -> Periodic:
    """Steady response of the linear-contact system at one speed, over the mesh cycle of the first mesh.

    Parameters
    ----------
    relative_speed : speed per operating speed, above zero.
    samples : of a mesh cycle; None takes as many as the harmonics need, 64 at least.
    tolerance : relative residual of the harmonics kept; those dropped are below 100 times that.  Lines of other tones
        that add up to less than it are left out.

    Raises
    ------
    ModelError : no damping, no mesh frequency, torques out of balance, or an option out of range.
    ConvergenceError : no solution; the speed lies on the edge of a parametric instability.
    """
    ready, block = _solved(system, relative_speed, tolerance)
    return _told(ready, block, 0, samples, tolerance)


def periodic_by_tone(
    system: System, *, relative_speed: float = 1.0, samples: int | None = None, tolerance: float = _TOLERANCE
) -> tuple[Periodic, ...]:
    """The same response told once over the mesh cycle of each tone, that of the first mesh first; as `periodic`."""
    ready, block = _solved(system, relative_speed, tolerance)
    return tuple(_told(ready, block, axis, samples, tolerance) for axis in range(len(ready.lines.tones)))


def _told(ready: Response, block: Block, axis: int, samples: int | None, tolerance: float) -> Periodic:
    harmonics = block.kept[axis]
    count = max(64, samples_needed(ready, harmonics)) if samples is None else _counted(samples)
    theta = np.arange(count) / count
    force, motion = force_spectrum(ready, block, shifted=False), motion_spectrum(ready, block, shifted=False)
    lines = _other_lines(ready, force, motion, axis, theta)
    if block.shaft is not None:
        shafts = [find(ready, block, shifted=True) for find in (force_spectrum, motion_spectrum)]
        lines += _other_lines(ready, *shafts, axis, theta)
    return Periodic(
        tone=ready.lines.tones[axis],
        relative_speed=float(block.speed[0]),
        theta=theta,
        force=own_waves(force, axis, theta)[:, 0, 0].real,
        displacement=own_waves(motion, axis, theta)[:, 0, 0].real,
        lines=tuple(_relevant(ready, lines, tolerance)),
        harmonics=harmonics,
        residual=float(block.residual[0]),
    )


def _other_lines(ready: Response, force: Spectrum, motion: Spectrum, axis: int, theta: Array) -> list[ShaftLine]:
    """Everything but the multiples of one tone, a line for each combination of the others and each shaft line."""
    pushed, moved = envelopes(force, axis, theta), envelopes(motion, axis, theta)
    known = {(s, *rest): i for i, (s, rest) in enumerate(zip(moved.shaft.tolist(), moved.rests.tolist(), strict=True))}
    lines = []
    for i, (s, rest) in enumerate(zip(pushed.shaft.tolist(), pushed.rests.tolist(), strict=True)):
        at = known.get((s, *rest))
        still = np.zeros((moved.values.shape[0], theta.size), complex)
        shaft = ready.lines.shaft[s] if s >= 0 else None
        combined = sum((a * tone for a, tone in zip(rest, ready.lines.tones, strict=True)), Fraction(0))
        lines.append(
            _forwards(
                combined + (shaft.frequency if shaft is not None else 0),
                shaft.causes if shaft is not None else _stages(ready, rest),
                pushed.values[:, 0, i],
                still if at is None else moved.values[:, 0, at],
            )
        )
    return lines


def _forwards(frequency: Fraction, causes: tuple[str, ...], force: ComplexArray, moved: ComplexArray) -> ShaftLine:
    """A line of positive frequency: Re z = Re conj z."""
    if frequency < 0:
        frequency, force, moved = -frequency, force.conj(), moved.conj()
    return ShaftLine(frequency=frequency, causes=causes, force=force, displacement=moved)


def _stages(ready: Response, orders: Sequence[int]) -> tuple[str, ...]:
    """``<stage> mesh`` of every tone in a combination."""
    stages = zip(ready.lines.axis.tolist(), ready.system.meshes.stage, strict=True)
    return tuple(dict.fromkeys(f"{stage} mesh" for axis, stage in stages if orders[axis]))


def _relevant(ready: Response, lines: list[ShaftLine], tolerance: float) -> list[ShaftLine]:
    """The lines without the smallest ones, as long as these add up to less than the tolerance in every signal."""
    if len(ready.lines.tones) == 1 or not lines:
        return lines
    radius = ready.system.dofs.radius[:, None]
    force = np.array([np.abs(line.force).max(axis=1) for line in lines])
    moved = np.array([np.abs(radius * line.displacement).max(axis=1) for line in lines])
    size = np.zeros(len(lines))
    for part in (force, moved):
        size = np.maximum(size, (part / max(float(part.max()), np.finfo(float).tiny)).max(axis=1))
    order = np.argsort(size)
    needless = set(order[np.cumsum(size[order]) < tolerance].tolist())
    return [line for i, line in enumerate(lines) if i not in needless]


def steady(system: System, *, relative_speed: float = 1.0, samples: int = 64) -> xr.Dataset:
    """Steady response at one speed as a Dataset: forces and displacements over the mesh phase, harmonics, lines.

    With several mesh frequencies a mesh force over the mesh phase is its part at multiples of the mesh's own tone, a
    displacement that at multiples of the first mesh's; ``combination_force`` and ``combination_displacement`` hold
    every multiple and combination of them, and RMS, bound and minimum count them all.

    Parameters
    ----------
    relative_speed : speed per operating speed, above zero.  samples : of the mesh phase in the result.

    Raises
    ------
    ModelError, ConvergenceError : as of `periodic`.
    """
    from ..results import dataset

    theta = np.arange(_counted(samples)) / samples
    ready, block = _solved(system, relative_speed, _TOLERANCE)
    force, motion = force_spectrum(ready, block, shifted=False), motion_spectrum(ready, block, shifted=False)
    shafts = None if block.shaft is None else force_spectrum(ready, block, shifted=True)
    low, high = force_extremes(ready, block, force, shafts)
    radius = system.dofs.radius[:, None]
    square = mean_square(ready, block, [force] if shafts is None else [force, shafts])
    combined, labels = _combinations(ready, force, motion, relative_speed)
    return dataset(
        {
            "mesh_force": (("mesh", "mesh_phase"), _by_mesh(ready, force, theta)[:, 0].real),
            "displacement": (("dof", "mesh_phase"), radius * own_waves(motion, 0, theta)[:, 0, 0].real),
            "mesh_force_harmonic": (("mesh", "harmonic"), _harmonics(ready, force, block.harmonics)),
            "displacement_harmonic": (("dof", "harmonic"), radius * _orders(motion, 0, block.harmonics)),
            **combined,
            "mesh_force_rms": ("mesh", np.sqrt(square[:, 0])),
            "mesh_force_bound": ("mesh", high[:, 0]),
            "mesh_force_minimum": ("mesh", low[:, 0]),
            **_line_variables(ready, block, shafts, theta),
            "residual": ((), block.residual[0]),
        },
        {
            "mesh": list(system.meshes.name),
            "dof": list(system.dofs.names),
            "mesh_phase": theta,
            "harmonic": np.arange(block.harmonics + _length(ready) + 1),
            **labels,
            "line": np.array(["; ".join(shaft.causes) for shaft in ready.lines.shaft], dtype=object),
            "mesh_frequency": float(ready.lines.tone) * relative_speed,
        },
        verb="steady",
        options={"relative_speed": relative_speed, "samples": samples, "harmonics": block.harmonics},
        provenance=system.provenance,
        warnings=[*system.warnings, *tension(system, low)],
    )


def tension(system: System, lowest: Array) -> list[str]:
    """A warning where the linear model pulls on teeth; lowest : (m, P) smallest force at every point [N]."""
    pulled = np.nan_to_num(lowest, nan=np.inf) < 0
    if not pulled.any():
        return []
    names = [name for name, row in zip(system.meshes.name, pulled, strict=True) if row.any()]
    listed = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
    points = int(pulled.any(axis=0).sum())
    where = f" at {points} of {pulled.shape[1]} speeds" if pulled.shape[1] > 1 else ""
    return [f"tensile mesh force in the linear model{where}: the teeth of {listed} would separate"]


def _solved(system: System, relative_speed: float, tolerance: float) -> tuple[Response, Block]:
    if not (math.isfinite(relative_speed) and relative_speed > 0):
        raise ModelError("out of range", path="relative_speed", given=relative_speed, allowed="a number above zero")
    if not 0 < tolerance < 1:
        raise ModelError("out of range", path="tolerance", given=tolerance, allowed="between 0 and 1")
    ready = response(system)
    block = next(respond(ready, np.array([float(relative_speed)]), tolerance=tolerance))
    if not block.residual[0] <= max(_ACCEPTED, 100 * tolerance):
        frequency = float(ready.lines.tone) * relative_speed
        raise ConvergenceError(
            f"no periodic response found at {frequency:.6g} Hz mesh frequency (residual {block.residual[0]:.2g}): "
            "try a slightly different speed or more damping"
        )
    return ready, block


def _counted(samples: int) -> int:
    if samples < 1:
        raise ModelError("out of range", path="samples", given=samples, allowed="1 or more")
    return samples


def _length(ready: Response) -> int:
    return int(ready.system.meshes.variation.shape[1])


def _by_mesh(ready: Response, spectrum: Spectrum, theta: Array) -> NDArray[np.inexact]:
    """Multiples of each mesh's own tone over its phase, (m, S, Nt)."""
    waves = [own_waves(spectrum, axis, theta)[:, 0] for axis in range(len(ready.lines.tones))]
    result: NDArray[np.inexact] = np.array(waves)[ready.lines.axis, np.arange(len(ready.lines.axis))]
    return result


def _orders(spectrum: Spectrum, axis: int, harmonics: int) -> ComplexArray:
    """One-sided harmonics 0..H of one tone, (rows, H + 1): value = Re sum harmonic_h exp(2 pi i h theta)."""
    own = np.count_nonzero(np.delete(spectrum.points, axis, axis=1), axis=1) == 0
    orders = spectrum.points[:, axis]
    result = np.zeros((spectrum.amplitude.shape[0], harmonics + 1), complex)
    known = own & (orders <= harmonics)
    result[:, orders[known]] = spectrum.amplitude[:, 0, 0, known]
    return result


def _harmonics(ready: Response, force: Spectrum, kept: int) -> ComplexArray:
    """Harmonics of each mesh force in its own tone, (m, H + L + 1)."""
    every = [_orders(force, axis, kept + _length(ready)) for axis in range(len(ready.lines.tones))]
    result: ComplexArray = np.array(every)[ready.lines.axis, np.arange(len(ready.lines.axis))]
    return result


def _combinations(
    ready: Response, force: Spectrum, motion: Spectrum, speed: float
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Amplitudes of all lattice points kept where there are several tones: variables and coordinates."""
    tones = ready.lines.tones
    if len(tones) == 1:
        return {}, {}
    points = motion.points
    frequency = [float(sum((a * f for a, f in zip(point, tones, strict=True)), Fraction(0))) for point in points.tolist()]
    stages = [next(n for n, j in zip(ready.system.meshes.stage, ready.lines.axis, strict=True) if j == t) for t in range(len(tones))]
    names = [" ".join(f"{a:+d} {stage}" for a, stage in zip(p, stages, strict=True) if a) or "mean" for p in points.tolist()]
    radius = ready.system.dofs.radius[:, None]
    return {
        "combination_force": (("mesh", "combination"), force.amplitude[:, 0, 0, : len(points)]),
        "combination_displacement": (("dof", "combination"), radius * motion.amplitude[:, 0, 0]),
        "combination_frequency": ("combination", speed * np.array(frequency)),
    }, {"combination": np.array(names, dtype=object)}


def _line_variables(ready: Response, block: Block, shafts: Spectrum | None, theta: Array) -> dict[str, Any]:
    """Shaft lines: envelopes over each mesh's own phase, and largest amplitudes over all phases."""
    m, count = len(ready.system.meshes.name), len(ready.lines.shaft)
    speed = float(block.speed[0])
    force, largest = np.zeros((m, count, theta.size), complex), np.zeros((m, count))
    if shafts is not None:
        force = _by_mesh(ready, shafts, theta)
        grid = [max(128 if len(ready.lines.tones) == 1 else 32, samples_needed(ready, H)) for H in block.kept[:-1]]
        values = np.abs(on_torus(shafts, grid, block.kept[-1])[:, 0])
        largest = values.reshape(m, count, -1).max(axis=2)
    return {
        "line_force": (("mesh", "line", "mesh_phase"), force),
        "line_amplitude": (("mesh", "line"), largest),
        "line_frequency": ("line", np.array([float(shaft.frequency) * speed for shaft in ready.lines.shaft])),
    }
