"""Plain harmonic superposition: every frequency alone on the mean system, for comparison with the full solution.

With dbar the mean gap, K xbar = F, and dk the varying part of a mesh stiffness,

    Z(w) X = sum of (k0 + i w c) e B - dk dbar B,    force = k0 (dbar + dX) + dk dbar + c dX'

that is, products of varying stiffness and varying gap are left out.  This is the mean system with the errors
e - dbar dk / (k0 + i w c), so that one solver serves both (derived here).
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from ...system.system import Array, ComplexArray, Line, System
from .periodic import periodic

__all__ = ["superposed"]


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
    gaps = {line.frequency: line.gap for line in system.lines}
    extra: dict[Fraction, ComplexArray] = {}
    for number in np.unique(meshes.tone):
        mine = meshes.tone == number
        for order in range(1, meshes.variation.shape[1] + 1):
            frequency = system.tones[number] * order
            part = _error(system, gap, order, 2 * np.pi * float(frequency) * relative_speed)
            extra[frequency] = extra.get(frequency, np.zeros(len(gap), complex)) + np.where(mine, part, 0.0)
    known = tuple(replace(line, gap=line.gap + extra.get(line.frequency, 0.0)) for line in system.lines)
    fresh = tuple(_line(system, f, value) for f, value in extra.items() if f not in gaps and value.any())
    return replace(static, lines=tuple(sorted(known + fresh, key=lambda line: line.frequency)))


def _error(system: System, gap: Array, order: int, omega: float) -> ComplexArray:
    """Error that acts as one harmonic of dk dbar, (m,) [m]; gap : (m,) mean gap [m], omega : [rad/s]."""
    meshes = system.meshes
    force = meshes.stiffness * meshes.variation[:, order - 1] * gap
    error: ComplexArray = -force / (meshes.stiffness + 1j * omega * meshes.damping)
    return error


def _line(system: System, frequency: Fraction, gap: ComplexArray) -> Line:
    """Line of mesh errors `gap` (m,) [m] at a frequency [Hz at the operating speed]."""
    return Line(
        frequency=frequency,
        gap=gap,
        link_gap=np.zeros(len(system.links.name), complex),
        force=np.zeros((3, len(system.force)), complex),
        causes=("mesh stiffness",),
    )
