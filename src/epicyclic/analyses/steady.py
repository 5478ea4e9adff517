"""The periodic response at one speed: mesh orders over a mesh cycle, and one envelope for each shaft frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ConvergenceError, ModelError
from ..system.system import Array, ComplexArray, System
from .response import Block, Response, respond, response
from .waveform import (
    displacements,
    mesh_forces,
    peak,
    samples_needed,
    shaft_displacements,
    shaft_forces,
    shaft_power,
)

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Periodic", "ShaftLine", "periodic", "steady"]

_TOLERANCE = 1e-8
# Beyond this a residual is no answer, whatever tolerance was asked for.
_ACCEPTED = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShaftLine:
    """Response to excitation at a frequency that is no mesh order.

    frequency : exact [Hz at the operating speed].  causes : paths in the file.
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
    """A periodic response.

    tone : mesh frequency [Hz at the operating speed]; relative_speed : s, speed per operating speed.
    theta : (Nt,) mesh phase, (tone s t) mod 1.
    force : (m, Nt) mesh force at mesh orders with its mean, k(t) (B^T q - e) + c d/dt(...) [N].
    displacement : (n, Nt) [m, rad].  lines : shaft frequencies.
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
    """Periodic response of the linear-contact system at one speed.

    Parameters
    ----------
    relative_speed : speed per operating speed, above zero.
    samples : of a mesh cycle; None takes as many as the harmonics need, 64 at least.
    tolerance : relative residual of the harmonics kept; those dropped are below 100 times that.

    Raises
    ------
    ModelError : no damping, no or several mesh frequencies, torques out of balance, or an option out of range.
    ConvergenceError : no solution; the speed lies on the edge of a parametric instability.
    """
    ready, block = _solved(system, relative_speed, tolerance)
    count = max(64, samples_needed(ready, block.harmonics)) if samples is None else _counted(samples)
    theta = np.arange(count) / count
    force, coordinates = shaft_forces(ready, block, theta)[:, 0], shaft_displacements(ready, block, theta)[:, 0]
    return Periodic(
        tone=ready.lines.tone,
        relative_speed=float(relative_speed),
        theta=theta,
        force=mesh_forces(ready, block, theta)[:, 0],
        displacement=displacements(ready, block, theta)[:, 0],
        lines=tuple(
            ShaftLine(frequency=shaft.frequency, causes=shaft.causes, force=force[:, i], displacement=coordinates[:, i])
            for i, shaft in enumerate(ready.lines.shaft)
        ),
        harmonics=block.harmonics,
        residual=float(block.residual[0]),
    )


def steady(system: System, *, relative_speed: float = 1.0, samples: int = 64) -> xr.Dataset:
    """Periodic response at one speed as a Dataset: forces and displacements over the mesh phase, harmonics, lines.

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
    system = ready.system
    fine = np.arange(count := max(256, 4 * samples_needed(ready, block.harmonics))) / count
    force, radius = mesh_forces(ready, block, fine)[:, 0], system.dofs.radius[:, None]
    lines = shaft_forces(ready, block, fine)[:, 0]
    reach = np.abs(lines).sum(axis=1)
    mean_square = force.var(axis=1) + shaft_power(ready, lines, fine)
    low = -peak(reach - force)
    shown = samples_needed(ready, block.harmonics) // 2 + 1
    frequencies = [float(shaft.frequency) * relative_speed for shaft in ready.lines.shaft]
    return dataset(
        {
            "mesh_force": (("mesh", "mesh_phase"), mesh_forces(ready, block, theta)[:, 0]),
            "displacement": (("dof", "mesh_phase"), radius * displacements(ready, block, theta)[:, 0]),
            "mesh_force_harmonic": (("mesh", "harmonic"), _harmonics(force, shown)),
            "displacement_harmonic": (
                ("dof", "harmonic"),
                _harmonics(radius * displacements(ready, block, fine)[:, 0], shown),
            ),
            "mesh_force_rms": ("mesh", np.sqrt(np.maximum(mean_square, 0.0))),
            "mesh_force_bound": ("mesh", peak(force + reach)),
            "mesh_force_minimum": ("mesh", low),
            "line_force": (("mesh", "line", "mesh_phase"), shaft_forces(ready, block, theta)[:, 0]),
            "line_amplitude": (("mesh", "line"), np.abs(lines).max(axis=2)),
            "line_frequency": ("line", np.array(frequencies)),
            "residual": ((), block.residual[0]),
        },
        {
            "mesh": list(system.meshes.name),
            "dof": list(system.dofs.names),
            "mesh_phase": theta,
            "harmonic": np.arange(shown),
            "line": np.array(["; ".join(shaft.causes) for shaft in ready.lines.shaft], dtype=object),
            "mesh_frequency": float(ready.lines.tone) * relative_speed,
        },
        verb="steady",
        options={"relative_speed": relative_speed, "samples": samples, "harmonics": block.harmonics},
        provenance=system.provenance,
        warnings=[*system.warnings, *tension(system, low[:, None])],
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


def _harmonics(values: Array, count: int) -> ComplexArray:
    """One-sided harmonics 0..count - 1 of samples over one cycle: value = Re sum harmonic_h exp(2 pi i h theta)."""
    spectrum: ComplexArray = np.fft.rfft(values, axis=-1)[..., :count] / values.shape[-1]
    spectrum[..., 1:] *= 2
    return spectrum
