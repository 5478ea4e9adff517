"""Contributions of equal frequency become one line: compared exactly, added as complex numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray
from .rows import Passed, Rows

__all__ = ["Lines", "Part", "lines_of", "synthesised"]

Index = NDArray[np.int64]
# What adds less than this of the largest part of a line is not told among its origins.
_TOLD = 1e-2
# Lines summed at once when a signal is written out.
_AT_ONCE = 2048


class Part(NamedTuple):
    """Which row, moved by how many turns of the carrier; backwards : its conjugate."""

    row: int
    order: int
    backwards: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lines:
    """Lines at the sensor, frequencies rising, all above 0: value = Re sum_l amplitude_l exp(2 pi i frequency_l s t).

    frequency : exact [Hz at s = 1].  force : (L,) complex, of the meshes heard [N].  motion : (L,) of the body [m].
    parts : of each what it is made of, the largest part first, one of each shaft line that matters.
    """

    frequency: tuple[Fraction, ...]
    force: ComplexArray
    motion: ComplexArray
    parts: tuple[tuple[Part, ...], ...]


def lines_of(rows: Rows, force: Passed, motion: Passed) -> Lines:
    """Merge what a sensor hears and feels; what stands still is left out."""
    row, order = np.concatenate([force.row, motion.row]), np.concatenate([force.order, motion.order])
    amplitude = np.concatenate([force.amplitude, motion.amplitude])
    at = rows.step[row] + order.astype(object) * rows.carrier
    moves = (at != 0).astype(bool)
    row, order, amplitude, at = row[moves], order[moves], amplitude[moves], _small(at[moves])
    felt = (np.arange(moves.size) >= force.row.size)[moves]
    backwards = np.asarray(at < 0, bool)
    step, line = np.unique(np.abs(at), return_inverse=True)
    value = np.where(backwards, amplitude.conj(), amplitude)
    sums = np.zeros((2, step.size), complex)
    np.add.at(sums, (felt.astype(int), line), value)
    # a part of the motion names a line only where no force does
    size = np.where(felt, -1.0 / (1.0 + np.abs(amplitude)), np.abs(amplitude))
    rank = np.lexsort((-size, line))
    largest = size[rank[np.flatnonzero(np.diff(line[rank], prepend=-1))]]
    told = rank[(size[rank] >= _TOLD * largest[line[rank]]) | (size[rank] == largest[line[rank]])]
    return Lines(
        frequency=tuple(Fraction(int(one), rows.unit) for one in step),
        force=sums[0],
        motion=sums[1],
        parts=_parts(
            step.size,
            line[told],
            rows.shaft[row[told]],
            map(Part, row[told].tolist(), order[told].tolist(), backwards[told].tolist()),
        ),
    )


def _small(at: NDArray[np.object_]) -> NDArray[np.object_] | Index:
    """Whole numbers that fit are sorted much faster as such."""
    fits = at.size == 0 or max(at.max(), -at.min()) < 2**62
    return at.astype(np.int64) if fits else at


def _parts(count: int, line: Index, shaft: Index, parts: Iterable[Part]) -> tuple[tuple[Part, ...], ...]:
    """The first part of each shaft line in each of `count` lines."""
    found: list[dict[int, Part]] = [{} for _ in range(count)]
    for where, number, part in zip(line.tolist(), shaft.tolist(), parts, strict=True):
        found[where].setdefault(number, part)
    return tuple(tuple(one.values()) for one in found)


def synthesised(frequency: Array, amplitude: ComplexArray, duration: float, samples: int) -> Array:
    """Re sum_l amplitude_l exp(2 pi i frequency_l t) at `samples` even instants of a duration [s], the end left out.

    Instants are a start and a step after it, exp(i w (t_a + t_b)) a product: few exponentials and one matrix product.
    """
    steps = max(1, int(np.sqrt(samples)))
    starts = -(-samples // steps)
    result = np.zeros((starts, steps))
    turn = 2j * np.pi * frequency * (duration / samples)
    for first in range(0, frequency.size, _AT_ONCE):
        mine = slice(first, first + _AT_ONCE)
        coarse = np.exp(np.outer(np.arange(starts) * steps, turn[mine]))
        fine = amplitude[mine, None] * np.exp(np.outer(turn[mine], np.arange(steps)))
        result += coarse.real @ fine.real - coarse.imag @ fine.imag
    values: Array = result.ravel()[:samples]
    return values
