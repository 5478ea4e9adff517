"""The record: instants counted in exact fractions of a mesh cycle, and what the excitation lines are at them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from math import lcm

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..system.system import Array, System

__all__ = [
    "Excitation",
    "excitation",
    "hunting_cycles",
    "mesh_stiffness",
    "positive",
    "reference_tone",
    "stiffness_at",
    "turns",
]

# product of two numbers below this stays exact in int64
_EXACT = 2**31
# least stiffness of a closed mesh per its mean
_LEAST = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Excitation:
    """Stiffness, errors and load at T instants.

    stiffness, gap : (T, m) of the meshes [N/m], [m].  link_gap : (T, p).  force : (T, n) generalised force at rest.
    """

    stiffness: Array
    gap: Array
    link_gap: Array
    force: Array


def positive(name: str, value: int | None, default: int) -> int:
    """A count of at least one, or the default where it is None.

    Raises
    ------
    ModelError : not a whole number of at least 1.
    """
    if value is None:
        return default
    if isinstance(value, bool) or int(value) != value or value < 1:
        raise ModelError("must be a whole number of at least 1", path=name, given=value, allowed=">= 1")
    return int(value)


def reference_tone(system: System) -> Fraction:
    """Frequency the record is counted in: of the first mesh [Hz]; 1 Hz (time in cycles) where no speed is given."""
    if not system.tones or not len(system.meshes.tone):
        return Fraction(1)
    return system.tones[int(system.meshes.tone[0])]


def turns(ratio: Fraction, index: NDArray[np.int64]) -> Array:
    """Fractional part of ratio * index, in [0, 1), exact before the last division where int64 allows it."""
    q = ratio.denominator
    p = ratio.numerator % q
    if q < _EXACT and int(np.max(np.abs(index), initial=0)) < _EXACT:
        exact: Array = (index * p % q) / q
        return exact
    rounded: Array = np.mod(float(Fraction(p, q)) * index, 1.0)
    return rounded


def hunting_cycles(ratios: Iterable[Fraction]) -> int:
    """Mesh cycles after which every line returns to its phase; ratios : line frequency per mesh frequency, exact."""
    return lcm(*(ratio.denominator for ratio in ratios))


def mesh_stiffness(system: System, tone: Fraction, index: NDArray[np.int64], samples: int) -> Array:
    """k_m at instants index / (samples tone), (T, m) [N/m], positive."""
    ratios = [other / tone for other in system.tones] or [Fraction(1)]
    return stiffness_at(system, np.array([turns(ratio / samples, index) for ratio in ratios]).T)


def stiffness_at(system: System, phases: Array) -> Array:
    """k_m at phases (T, tones) of every mesh frequency [turns], (T, m) [N/m], positive."""
    meshes = system.meshes
    result = np.empty((len(phases), len(meshes.stiffness)))
    harmonics = np.arange(1, meshes.variation.shape[1] + 1)
    for number in np.unique(meshes.tone):
        waves = np.exp(2j * np.pi * np.outer(phases[:, number], harmonics))
        columns = meshes.tone == number
        relative = 1.0 + (waves @ meshes.variation[columns].T).real
        # a truncated series may dip below zero where the true stiffness is near zero
        result[:, columns] = meshes.stiffness[columns] * np.maximum(relative, _LEAST)
    return result


def excitation(system: System, tone: Fraction, index: NDArray[np.int64], samples: int) -> Excitation:
    """What acts on the train at rest at instants index / (samples tone) of the operating speed.

    Of a line's force the part at rest counts (``force[0]``); what grows with speed is inertia.
    """
    T, m, p = len(index), len(system.meshes.name), len(system.links.name)
    lines = system.lines
    waves = np.empty((T, len(lines)), dtype=complex)
    for column, line in enumerate(lines):
        waves[:, column] = np.exp(2j * np.pi * turns(line.frequency / tone / samples, index))

    def total(parts: list[NDArray[np.complex128]], width: int) -> Array:
        values: Array = (waves @ np.array(parts).reshape(len(lines), width)).real
        return values

    return Excitation(
        stiffness=mesh_stiffness(system, tone, index, samples),
        gap=total([line.gap for line in lines], m),
        link_gap=total([line.link_gap for line in lines], p),
        force=system.force + total([line.force[0] for line in lines], len(system.force)),
    )
