"""The record: instants counted in exact fractions of a mesh cycle, and what the excitation lines are at them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from math import lcm

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.laws.tabulated import Curves, curves_at
from ...system.system import Array, ComplexArray, Line, System

__all__ = [
    "Excitation",
    "Record",
    "excitation",
    "hunting_cycles",
    "mesh_cycles",
    "mesh_stiffness",
    "positive",
    "record_of",
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

    stiffness : (T, m) of the meshes [N/m].  gap : (T, m + R) of the meshes and the rows of groups [m].
    link_gap : (T, p).  force : (T, n) generalised force at rest.  curves : laws of the tabulated meshes.
    """

    stiffness: Array
    gap: Array
    link_gap: Array
    force: Array
    curves: Curves | None = None

    def at(self, chosen: NDArray[np.int64]) -> Excitation:
        """The same at some of the instants."""
        return Excitation(
            stiffness=self.stiffness[chosen],
            gap=self.gap[chosen],
            link_gap=self.link_gap[chosen],
            force=self.force[chosen],
            curves=None if self.curves is None else self.curves.at(chosen),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """Instants i / (samples unit), i = 0 .. count samples - 1.

    unit : frequency of what is counted, exact [Hz].  name : what that is, ``mesh cycles``.
    count : units of the record.  samples : instants per unit.
    period : units after which all lines and mesh stiffnesses are as they were.
    """

    unit: Fraction
    name: str
    count: int
    samples: int
    period: int

    @property
    def instants(self) -> int:
        """Number of instants."""
        return self.count * self.samples

    @property
    def notes(self) -> list[str]:
        """A warning where the record is shorter than the period."""
        if self.count >= self.period:
            return []
        what = "hunting period" if self.name == "mesh cycles" else "common period"
        return [f"record of {self.count} {self.name} is shorter than the {what} of {self.period}"]


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


def record_of(
    system: System,
    *,
    cycles: int | None,
    turns: int | None,
    of: str | None,
    samples: int,
    most: int,
    slow: bool = False,
) -> Record:
    """The record that is asked for; the common period, as far as `most` instants go, where no length is.

    Parameters
    ----------
    cycles : mesh cycles of the first mesh.  turns : turns of the body `of`; `of` alone asks for its common period.
    samples : instants per mesh cycle or turn.  most : instants that may be chosen.
    slow : where nothing changes within a mesh cycle, count in cycles of the fastest line instead.

    Raises
    ------
    ModelError : a number that is none, both lengths, a body that does not turn.
    """
    if cycles is not None and (turns is not None or of is not None):
        raise ModelError("a record has one length", path="cycles, turns", allowed="cycles, or turns of a body")
    unit, name = reference_tone(system), "mesh cycles"
    if turns is not None or of is not None:
        unit, name = _turning(system, of), f"turns of {of}"
    elif slow and cycles is None and (fastest := _slow_line(system)):
        unit, name = fastest, "cycles of the fastest error"
    varying = np.any(system.meshes.variation != 0, axis=1)
    tones = [system.tones[i] for i in np.unique(system.meshes.tone[varying])] if system.tones else []
    period = hunting_cycles([f / unit for f in (*(line.frequency for line in system.lines), *tones)])
    length = cycles if turns is None else turns
    count = positive("cycles" if turns is None else "turns", length, min(period, max(1, most // samples)))
    return Record(unit=unit, name=name, count=count, samples=samples, period=period)


def _turning(system: System, body: str | None) -> Fraction:
    """Turns per second of a body, exact."""
    known = {name: abs(turn) for name, turn in zip(system.dofs.bodies, system.body_turns, strict=False) if turn}
    body = None if body is None else body.replace(".", "/")
    if body is None or body not in known:
        raise ModelError(
            "turns are counted of a body that turns",
            path="of",
            given=body,
            allowed=", ".join(known) or "a train's speed",
        )
    return known[body]


def _slow_line(system: System) -> Fraction | None:
    """Frequency of the fastest line, where mesh stiffnesses are constant and no line reaches a mesh frequency."""
    fastest = max((line.frequency for line in system.lines), default=Fraction(0))
    constant = not np.any(system.meshes.variation)
    return fastest if constant and system.tones and 0 < fastest < min(system.tones) else None


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


def mesh_cycles(system: System, tone: Fraction, index: NDArray[np.int64], samples: int) -> Array:
    """Time at instants index / (samples tone), in cycles of each mesh row, whole ones taken off, (T, m)."""
    ratios = [other / tone for other in system.tones] or [Fraction(1)]
    phases = np.array([turns(ratio / samples, index) for ratio in ratios])
    return np.asarray(phases[system.meshes.tone].T)


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
    R = sum(len(group.rows) for group in system.groups)
    lines = system.lines
    waves = np.empty((T, len(lines)), dtype=complex)
    for column, line in enumerate(lines):
        waves[:, column] = np.exp(2j * np.pi * turns(line.frequency / tone / samples, index))

    def total(parts: list[NDArray[np.complex128]], width: int) -> Array:
        values: Array = (waves @ np.array(parts).reshape(len(lines), width)).real
        return values

    return Excitation(
        stiffness=mesh_stiffness(system, tone, index, samples),
        gap=np.hstack([total([line.gap for line in lines], m), total([_group_gap(line, R) for line in lines], R)]),
        link_gap=total([line.link_gap for line in lines], p),
        force=system.force + total([line.force[0] for line in lines], len(system.force)),
        curves=curves_at(system.meshes.tables, mesh_cycles(system, tone, index, samples)),
    )


def _group_gap(line: Line, rows: int) -> ComplexArray:
    """Errors of the rows of groups; a line that says none has none."""
    return line.group_gap if line.group_gap.size else np.zeros(rows, dtype=complex)
