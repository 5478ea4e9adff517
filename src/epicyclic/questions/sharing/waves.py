"""Mesh forces over a record as a mesh-order part and a few slow shaft lines, exact at every instant; derived here.

    F_m(c, theta) = mean_m(theta) + Re sum_s A_ms(theta) exp(2 pi i ratio_s c),    t = (c + theta) / f_mesh

with the cycle number c and the phase theta in the cycle.  A record of many cycles is then one matrix product.

The worst cycle-peak coefficient over the hunting period is found without evaluating every cycle of it; derived here.
Lines whose denominators (tooth numbers, mostly) share no factor take all combinations of their phases, by the Chinese
remainder theorem; the period is the product of such blocks.  A grid over the blocks, refined by a pattern search at
each mesh's best point, evaluates phases that do occur and nothing else.  Within a block of tied lines no phase moves
alone: the search goes by the numbers of cycles after which all phases of the block recur most closely, and by their
multiples.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import gcd, lcm
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...statics.equilibrium import Compliance, Values, closed_approach, closed_force, require_balance, require_forces
from ...statics.record import MeshGroup, mesh_stiffness, turn_fraction
from ...statics.static import HeldTrain
from ...system.gaps import flanks
from ...system.system import Array, ComplexArray, System
from .definitions import cycle_peak_ratio

if TYPE_CHECKING:
    from ..response.periodic import Periodic


Source = Callable[[Array], Array]
"""Line phases (cycles, L) [turns] -> mesh forces (cycles, m, samples) [N]."""

# Cycles evaluated at once.
_CHUNK = 256
# Cycles of a block among which close recurrences are looked for, and how many are taken for each of its lines.
_LOOKED, _RECURRENCES = 200_000, 3
# Farthest that a phase moves in one step of the search [turns].
_FAR = 0.25


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waves:
    """Mesh forces of a whole record.

    mean : (m, Nt) [N].  ratios : (L,) line frequency per mesh frequency, exact.
    amplitude : (L, m, Nt) complex [N], the turning of the line within the cycle included.
    """

    mean: Array
    ratios: tuple[Fraction, ...]
    amplitude: ComplexArray

    @property
    def samples(self) -> int:
        """Instants per mesh cycle."""
        return int(self.mean.shape[1])

    def subset(self, meshes: NDArray[np.int64]) -> Waves:
        """The same of some of the meshes (m_j,)."""
        return replace(self, mean=self.mean[meshes], amplitude=self.amplitude[:, meshes])


def periodic_waves(solution: Periodic) -> Waves:
    """Waves of the periodic response, forces (m, Nt) [N]; lines off the mesh orders keep their exact frequency."""
    ratios = tuple(line.frequency / solution.tone for line in solution.lines)
    m, Nt = solution.force.shape
    amplitude = np.zeros((len(ratios), m, Nt), dtype=complex)
    for s, (ratio, line) in enumerate(zip(ratios, solution.lines, strict=True)):
        amplitude[s] = line.force * np.exp(2j * np.pi * float(ratio) * solution.theta)
    return Waves(mean=np.asarray(solution.force), ratios=ratios, amplitude=amplitude)


def static_waves(system: System, flexible: Compliance, tone: Fraction, samples: int) -> Waves:
    """Waves (m, Nt) [N] of the static solution with all meshes closed: at each phase it is linear in the lines.

    Raises
    ------
    ModelError : a load works on a free motion.
    ConvergenceError : forces on a body do not balance.
    """
    k = mesh_stiffness(system, tone, np.arange(samples), samples)
    require_balance(flexible.free, system.force[None], system)
    for line in system.lines:
        require_balance(flexible.free, np.array([line.force[0].real, line.force[0].imag]), system)

    left, size = np.zeros(samples), np.zeros(samples)

    def solved(gap: Values, load: Values) -> Values:
        """Forces (Nt, m) [N] under errors (Nt, m) [m] and loads (Nt, n) [N, N m]."""
        force, missed, largest = closed_force(flexible, k, gap, load)
        np.add(left, missed, out=left)
        if load.any():
            np.maximum(size, largest, out=size)
        return force

    waves = _summed(system, tone, samples, solved, [line.gap for line in system.lines], np.zeros(k.shape[1]))
    if size.any():
        require_forces(left, size)
    return waves


def far_waves(system: System, held: HeldTrain, tone: Fraction, samples: int) -> Waves | None:
    """Waves of how far the far flanks reach beyond first touch with all loaded flanks closed, (c, Nt) [m].

    None where there are none, or where none touches at any phases of the lines.
    """
    far = system.far_flanks
    c, m = far.mesh.size, len(system.meshes.name)
    if held.both is None:
        return None
    k = np.hstack([mesh_stiffness(system, tone, np.arange(samples), samples), np.zeros((samples, c))])
    flexible = held.both
    phases = np.zeros((samples, max(1, len(system.tones))))
    if tone in system.tones:
        phases[:, system.tones.index(tone)] = np.arange(samples) / samples
    touch = flanks(system).at(phases).touch[:, m:]

    def solved(gap: Values, load: Values) -> Values:
        """Gaps (Nt, c) [m] of the far flanks under errors (Nt, m + c) [m] and loads (Nt, n) [N, N m]."""
        reach: Values = closed_approach(flexible, k, gap, load @ flexible.gap_of_force.T)[:, m:] - gap[:, m:]
        return reach

    opening = np.concatenate([np.zeros(m), system.meshes.backlash[far.mesh]])
    gaps = _summed(system, tone, samples, solved, [system.flank_gaps(line) for line in system.lines], opening)
    reach = replace(gaps, mean=gaps.mean - touch.T)
    return reach if np.any(force_bound(reach) > 0) else None


def _summed(
    system: System,
    tone: Fraction,
    samples: int,
    solved: Callable[[Values, Values], Values],
    gaps: Sequence[ComplexArray],
    still: Array,
) -> Waves:
    """Waves of what is linear in errors and loads: solved (errors (Nt, r), loads (Nt, n)) -> (Nt, ..).

    Parameters
    ----------
    gaps : errors (r,) of every line [m].  still : (r,) further constant errors [m].
    """
    theta = np.arange(samples) / samples
    mean = solved(np.tile(still, (samples, 1)), np.tile(system.force, (samples, 1)))
    ratios, amplitude = [], []
    for line, gap in zip(system.lines, gaps, strict=True):
        ratio = line.frequency / tone
        turning = np.exp(2j * np.pi * float(ratio) * theta)[:, None]
        value = solved(turning * gap, turning * line.force[0])
        if ratio.denominator == 1:
            mean = mean + value.real
        else:
            ratios.append(ratio)
            amplitude.append(value.T)
    shape = (len(ratios), *mean.T.shape)
    return Waves(mean=mean.T, ratios=tuple(ratios), amplitude=np.array(amplitude, dtype=complex).reshape(shape))


def cycle_forces(waves: Waves, phases: Array) -> Array:
    """Mesh forces (cycles, m, Nt) [N] in cycles that start with given line phases (cycles, L) [turns]."""
    m, Nt = waves.mean.shape
    flat = waves.amplitude.reshape(len(waves.ratios), m * Nt)
    angle = 2 * np.pi * phases
    turning = np.hstack([np.cos(angle), -np.sin(angle)])
    return (turning @ np.vstack([flat.real, flat.imag])).reshape(-1, m, Nt) + waves.mean


def line_phases(ratios: Sequence[Fraction], cycles: NDArray[np.int64]) -> Array:
    """Phase of each line at the start of each cycle, (cycles, L) [turns], exact."""
    return np.array([turn_fraction(ratio, cycles) for ratio in ratios]).reshape(len(ratios), len(cycles)).T


def force_bound(waves: Waves) -> Array:
    """Upper bound of the mesh forces over all shaft phases: max over the cycle of mean + sum |A|, (m,) [N].

    Phases are discrete and may be tied by common factors of tooth numbers, so it need not be reached.
    """
    largest: Array = np.max(waves.mean + np.sum(np.abs(waves.amplitude), axis=0), axis=1)
    return largest


# --- worst case over the hunting period ------------------------------------------------------------------------------


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
    single = [max(1, size // count // 2) for size, count in zip(sizes, counts, strict=True)]
    levels = _levels([_recurrences(ratios, part, size) for part, size in zip(parts, sizes, strict=True)], single)
    return _pattern_search(score, here, best, levels, meshes), False


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


def _stride(ratios: Sequence[Fraction], part: Sequence[int], size: int) -> int:
    """Cycles in which the finest line of a block advances by its smallest phase, 1 where there is no such number."""
    finest = max((ratios[i] for i in part), key=lambda ratio: ratio.denominator)
    return pow(finest.numerator, -1, size) if gcd(finest.numerator, size) == 1 else 1


def _recurrences(ratios: Sequence[Fraction], part: Sequence[int], size: int) -> list[tuple[int, float]]:
    """Steps along a block after which the phases of its tied lines recur most closely, and by how much [turns]."""
    alike = {ratios[i].denominator for i in part}
    if len(alike) == 1 or size > _LOOKED:
        return [(1, 1 / max(alike))]
    steps = np.arange(1, size // 2 + 1)
    cycles = steps.astype(object) * _stride(ratios, part, size) % size
    moved = np.zeros(len(steps))
    for i in part:
        turns = turn_fraction(ratios[i], (cycles % ratios[i].denominator).astype(np.int64))
        moved = np.maximum(moved, np.abs(turns - np.rint(turns)))
    nearest = np.argsort(moved, kind="stable")[: _RECURRENCES * len(alike)]
    return [(int(steps[i]), float(moved[i])) for i in nearest]


def _levels(recurrences: Sequence[Sequence[tuple[int, float]]], first: Sequence[int]) -> list[NDArray[np.object_]]:
    """Moves (K, blocks) of the pattern search, each way, the longest first.

    recurrences : of each block.  first : longest step of a block of one line.
    """
    blocks = len(recurrences)
    steps = [
        (block, step, longest if len(own) == 1 else max(1, int(_FAR / moved)))
        for block, (own, longest) in enumerate(zip(recurrences, first, strict=True))
        for step, moved in own
    ]
    found = []
    for level in range(max(far for _, _, far in steps).bit_length())[::-1]:
        moves = np.zeros((2 * len(steps), blocks), dtype=object)
        for row, (block, step, far) in enumerate(steps):
            moves[2 * row, block] = step * min(2**level, far)
            moves[2 * row + 1, block] = -moves[2 * row, block]
        found.append(moves)
    return found


def _phases_at(
    ratios: Sequence[Fraction], parts: Sequence[Sequence[int]], sizes: Sequence[int], places: NDArray[np.object_]
) -> Array:
    """Line phases (points, L) [turns] at places (points, blocks) along each block.

    Counted in phases of its finest line.
    """
    result = np.zeros((len(places), len(ratios)))
    for column, (part, size) in enumerate(zip(parts, sizes, strict=True)):
        cycles = (places[:, column] * _stride(ratios, part, size)) % size
        for i in part:
            p, q = ratios[i].numerator, ratios[i].denominator
            if q < 2**31:
                result[:, i] = turn_fraction(ratios[i], (cycles % q).astype(np.int64))
            else:  # products beyond int64, in Python's integers
                result[:, i] = [int(cycle) * p % q / q for cycle in cycles]
    return result


def _coefficient_of(source: Source, phases: Array, members: Sequence[MeshGroup]) -> Array:
    """Coefficients 1 + |b - 1| of cycles with given phases (points, L) [turns], (points, m) [1]."""
    pieces = [source(phases[i : i + _CHUNK]).max(axis=2) for i in range(0, len(phases), _CHUNK)]
    coefficient: Array = 1.0 + np.abs(cycle_peak_ratio(np.concatenate(pieces), members) - 1.0)
    return coefficient


def _pattern_search(
    score: Callable[[NDArray[np.object_]], Array],
    here: NDArray[np.object_],
    best: Array,
    levels: Sequence[NDArray[np.object_]],
    meshes: int,
) -> Array:
    """Largest coefficients (m,) [1] by pattern search from each mesh's best grid point (m, blocks).

    The best neighbour is taken while one is better, then the next level of moves (K, blocks).  Places are integers: no
    continuous optimiser applies.
    """
    best, blocks = best.copy(), here.shape[1]
    every = np.arange(meshes)
    for moves in levels:
        while True:
            places = here[:, None, :] + moves[None]
            values = score(places.reshape(-1, blocks)).reshape(meshes, len(moves), meshes)[every, :, every]
            choice = values.argmax(axis=1)
            better = values[every, choice] > best * (1 + 1e-12)
            here[better] = places[every, choice][better]
            best = np.where(better, values[every, choice], best)
            if not better.any():
                break
    return best
