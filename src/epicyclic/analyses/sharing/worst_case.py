"""The worst cycle-peak coefficient over the hunting period, without evaluating every cycle of it; derived here.

Lines whose denominators (tooth numbers, mostly) share no factor take all combinations of their phases, by the
Chinese remainder theorem; the period is the product of such blocks.  A grid over the blocks, refined by a pattern
search at each mesh's best point, evaluates phases that do occur and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import gcd, lcm

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array
from ..static.record import MeshGroup, turn_fraction
from .definitions import cycle_peak_ratio

__all__ = ["Source", "independent_blocks", "worst_case"]

Source = Callable[[Array], Array]
"""Line phases (cycles, L) [turns] -> mesh forces (cycles, m, samples) [N]."""

_CHUNK = 256


def worst_case(
    source: Source, ratios: Sequence[Fraction], members: Sequence[MeshGroup], *, meshes: int, points: int = 4096
) -> tuple[Array, bool]:
    """Largest 1 + |b - 1| of each mesh over the hunting period.

    Parameters
    ----------
    source : mesh forces (cycles, m, samples) [N] of cycles with given line phases (cycles, L) [turns].
    ratios : (L,) of the lines, exact.  members : groups of the m meshes.  meshes : m.  points : size of the grid.

    Returns
    -------
    ((m,) coefficients [1], whether every cycle of the period was evaluated).
    """
    parts = independent_blocks(ratios)
    sizes = [lcm(*(ratios[i].denominator for i in part)) for part in parts]
    counts = _grid_counts(sizes, points)
    axes = [
        np.array([i * size // count for i in range(count)], dtype=object)
        for size, count in zip(sizes, counts, strict=True)
    ]
    grid = np.array(np.meshgrid(*axes, indexing="ij"), dtype=object).reshape(len(sizes), -1).T

    def score(places: NDArray[np.object_]) -> Array:
        """Coefficients at places (points, blocks) of the phases, (points, m) [1]."""
        return _coefficient_of(source, _phases_at(ratios, parts, sizes, places), members)

    values = score(grid) if len(sizes) else _coefficient_of(source, np.zeros((1, len(ratios))), members)
    best = values.max(axis=0)
    if counts == sizes:
        return best, True
    here = grid[values.argmax(axis=0)]
    steps = [max(1, size // count // 2) for size, count in zip(sizes, counts, strict=True)]
    return _pattern_search(score, here, best, steps, meshes), False


def independent_blocks(ratios: Sequence[Fraction]) -> list[list[int]]:
    """Indices of lines tied by common factors of their denominators; blocks are independent of each other."""
    result: list[tuple[int, list[int]]] = []
    for i, ratio in enumerate(ratios):
        if ratio.denominator == 1:
            continue
        size, members = ratio.denominator, [i]
        free = []
        for other, indices in result:
            if gcd(other, ratio.denominator) > 1:
                size, members = lcm(size, other), indices + members
            else:
                free.append((other, indices))
        result = [*free, (size, members)]
    return [members for _, members in result]


def _grid_counts(sizes: Sequence[int], points: int) -> list[int]:
    """Grid points of each block: all of it where the product stays within `points`, the large ones thinned first."""
    counts = list(sizes)
    room = points
    order = sorted(range(len(sizes)), key=lambda i: sizes[i])
    for done, i in enumerate(order):
        share = max(2, int(room ** (1.0 / (len(order) - done)) + 1e-9))
        counts[i] = min(sizes[i], share)
        room = max(1, room // counts[i])
    return counts


def _phases_at(
    ratios: Sequence[Fraction], parts: Sequence[Sequence[int]], sizes: Sequence[int], places: NDArray[np.object_]
) -> Array:
    """Line phases (points, L) [turns] at places (points, blocks) along each block.

    Counted in phases of its finest line.
    """
    result = np.zeros((len(places), len(ratios)))
    for column, (part, size) in enumerate(zip(parts, sizes, strict=True)):
        finest = max((ratios[i] for i in part), key=lambda ratio: ratio.denominator)
        stride = pow(finest.numerator, -1, size) if gcd(finest.numerator, size) == 1 else 1
        cycles = (places[:, column] * stride) % size
        for i in part:
            q = ratios[i].denominator
            result[:, i] = (
                turn_fraction(ratios[i], (cycles % q).astype(np.int64))
                if q < 2**31
                else _large_turn_fraction(ratios[i], cycles)
            )
    return result


def _large_turn_fraction(ratio: Fraction, cycles: NDArray[np.object_]) -> Array:
    """`turn_fraction` of cycles (points,) [turns] for denominators beyond int64, in Python integers."""
    return np.array([int(c) * ratio.numerator % ratio.denominator / ratio.denominator for c in cycles])


def _coefficient_of(source: Source, phases: Array, members: Sequence[MeshGroup]) -> Array:
    """Coefficients 1 + |b - 1| of cycles with given phases (points, L) [turns], (points, m) [1]."""
    pieces = [source(phases[i : i + _CHUNK]).max(axis=2) for i in range(0, len(phases), _CHUNK)]
    coefficient: Array = 1.0 + np.abs(cycle_peak_ratio(np.concatenate(pieces), members) - 1.0)
    return coefficient


def _pattern_search(
    score: Callable[[NDArray[np.object_]], Array],
    here: NDArray[np.object_],
    best: Array,
    steps: list[int],
    meshes: int,
) -> Array:
    """Largest coefficients (m,) [1] by pattern search from each mesh's best grid point (m, blocks).

    The better neighbour is taken, else the step is halved, down to one.  Places are integers: no continuous optimiser
    applies.
    """
    best, blocks_ = best.copy(), len(steps)
    every = np.arange(meshes)
    while True:
        moves = np.zeros((2 * blocks_, blocks_), dtype=object)
        for b, step in enumerate(steps):
            moves[2 * b, b], moves[2 * b + 1, b] = step, -step
        places = here[:, None, :] + moves[None]
        values = score(places.reshape(-1, blocks_)).reshape(meshes, 2 * blocks_, meshes)[every, :, every]
        choice = values.argmax(axis=1)
        better = values[every, choice] > best * (1 + 1e-12)
        here[better] = places[every, choice][better]
        best = np.where(better, values[every, choice], best)
        if not better.any():
            if max(steps) == 1:
                return best
            steps = [max(1, step // 2) for step in steps]
