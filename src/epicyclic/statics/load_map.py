"""Loads of many samples: mean loads and planet loads, and their map.

Load sharing without mesh-frequency content: `mean-load` and `mean-load-turning`, of many samples at once.

    mean-load          per pair and side the largest N F_i / sum F, F averaged over the hunting period
    mean-load-turning  the largest of that over the hunting period, F then the mean of a mesh cycle

F is the quasi-static force at mean mesh stiffness, a sum of slow waves.  While contact stays, what turns averages out
of the first, and the second is a largest value over the phases of the waves: of independent ones by amplitude, of tied
ones on a grid.

Waves turn at exact frequencies.  Two whose ratio p : q is of small integers meet in few relative phases only; the
others come as close to every combination as 1 - cos(pi / |(p, q)|) of an amplitude, which is below 1 %: they are taken
as independent.  Tied ones have one common phase t and orders n, Re sum a exp(j n t).  Derived here.

Quasi-static excitation of every contact as a linear function of deviations, at mean mesh stiffness.

`load_map`, of a train without laws, maps deviations to stretches:

    g(theta) = torque g_T + g_0 + sum_c x_c Re(column_c exp(i theta_c)),    force of a closed row = k g

Rows are the loaded flanks of the mesh rows, the far flanks where backlash is finite, and links whose stiffness varies
between samples.  The stretch g = B'q - e of a row is that of the train with all loaded flanks closed; a row whose
stiffness is kappa instead of k0, open ones with kappa = 0, has y = (k0 - kappa) g and g = g_closed + S y, with S of
`equilibrium`.  This is exact and needs the rows alone that differ; derived here.  Lines at mesh orders
are left out: their phase is that of the mesh cycle, whose mean this is.

`law_map`, of a train with laws (play, rolling elements and splines of links, tables of meshes), maps deviations to
errors and forces.  Each sample at each phase is then an instant of the batched equilibrium of `statics.equilibrium`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from math import gcd, hypot, lcm

import numpy as np
from numpy.typing import NDArray

from ..errors import ConvergenceError, ModelError
from ..system.system import Array, ComplexArray, Faces, Line, System, elastic_rows, faces
from .equilibrium import Compliance, Values, compliance, imbalance, require_balance
from .record import (
    MeshGroup,
    RecordExcitation,
    excitation_of,
    force_at_rest,
    line_excitation,
    parallel_meshes,
    still_excitation,
)
from .static import HeldTrain, held_train, settled

MEAN_LOADS = ("mean-load", "mean-load-turning")

SlowPhases = tuple[tuple[tuple[int, int], ...], ...]
"""Sets of tied waves, each a tuple of (place among the G frequencies, order of their common phase)."""

# |(p, q)| from which two waves count as independent: 1 - cos(pi / 23) is 0.9 %.
_TIED = 23.0
# Largest order of tied waves that a grid resolves; beyond it even three waves come within 4 % of every combination.
_MOST_ORDER = 256
# Grid points in the shortest wave; the best points of so many waves are then refined by Newton steps.
_POINTS, _PEAKS, _SEARCH_STEPS = 8, 4, 4
# Complex numbers of one piece of the grid.
_PIECE = 500_000
# A sum of forces that turns by less than this part of itself is constant: rounding.
_CONSTANT = 1e-12
# Dinkelbach steps, each quadratic; more than six are never seen.
_STEPS = 12


def slow_phases(frequency: Sequence[Fraction]) -> SlowPhases:
    """Sets of waves with one common phase each, of exact frequencies (G,) above zero [Hz]."""
    sets: list[list[int]] = []
    for place, f in enumerate(frequency):
        tied = [waves for waves in sets if any(_tied(f, frequency[other]) for other in waves)]
        joined = sorted([place, *(other for waves in tied for other in waves)])
        if max(_orders([frequency[i] for i in joined])) > _MOST_ORDER:
            joined, tied = [place], []  # too many common phases to resolve: alone
        sets = [waves for waves in sets if waves not in tied] + [joined]
    return tuple(tuple(zip(waves, _orders([frequency[i] for i in waves]), strict=True)) for waves in sorted(sets))


def _tied(a: Fraction, b: Fraction) -> bool:
    """Whether two frequencies are as small integers."""
    ratio = a / b
    return hypot(ratio.numerator, ratio.denominator) < _TIED


def _orders(frequency: Sequence[Fraction]) -> tuple[int, ...]:
    """Orders of exact frequencies, multiples of their greatest common frequency."""
    unit = lcm(*(f.denominator for f in frequency))
    whole = [int(f * unit) for f in frequency]
    common = gcd(*whole)
    return tuple(n // common for n in whole)


def largest_sum(phases: SlowPhases, amplitude: ComplexArray) -> Array:
    """Largest Re sum a exp(j theta) (...) over the phases, of amplitudes a (G, ...)."""
    tied = tuple(waves for waves in phases if len(waves) > 1)
    alone = np.abs(amplitude[[waves[0][0] for waves in phases if len(waves) == 1]]).sum(axis=0)
    if not tied:
        return np.asarray(alone)
    places = [place for waves in tied for place, _ in waves]
    return np.asarray(alone + _summed(amplitude[places], units_of_largest(tied, amplitude)[places]))


def units_of_largest(phases: SlowPhases, amplitude: ComplexArray) -> ComplexArray:
    """Units u = exp(j theta) (G, ...) at which Re sum a u is largest, of amplitudes a (G, ...)."""
    unit = np.empty_like(amplitude)
    for waves in phases:
        places = [place for place, _ in waves]
        if len(waves) == 1:
            a = amplitude[places[0]]
            size = np.abs(a)
            with np.errstate(divide="ignore", invalid="ignore"):
                unit[places[0]] = np.where(size > 0, a.conj() / size, 1.0)
        else:
            orders = np.array([order for _, order in waves])
            t = _common_phase(amplitude[places].reshape(len(waves), -1), orders)
            unit[places] = np.exp(1j * np.multiply.outer(orders, t)).reshape(amplitude[places].shape)
    return unit


def _common_phase(amplitude: ComplexArray, orders: NDArray[np.int64]) -> Array:
    """Common phase t (P,) [rad] of the largest Re sum a exp(j n t), amplitudes (g, P)."""
    count = int(_POINTS * orders.max())
    grid = 2 * np.pi * np.arange(count) / count
    wave = np.exp(1j * np.multiply.outer(orders, grid))
    table = np.concatenate([wave.real, -wave.imag])
    step = max(1, _PIECE // count)
    phases = [np.zeros(0)]
    for i in range(0, amplitude.shape[1], step):
        a = amplitude[:, i : i + step]
        peaks = _highest(np.vstack([a.real, a.imag]).T @ table, int(orders.max()))
        phases.append(_refined(a, grid[peaks].T, orders))
    return np.concatenate(phases)


def _refined(amplitude: ComplexArray, t: Array, orders: NDArray[np.int64]) -> Array:
    """Best phase (P,) [rad] of those that Newton steps reach from grid points t (peaks, P), amplitudes (g, P)."""
    a, n = amplitude[:, None], orders[:, None, None]
    most = np.pi / (_POINTS * orders.max())
    for _ in range(_SEARCH_STEPS):
        value = a * np.exp(1j * n * t)
        slope, bend = -(n * value.imag).sum(axis=0), -(n**2 * value.real).sum(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            move = np.where(bend < 0, -slope / bend, 0.0)
        t = t + np.clip(move, -most, most)
    best = np.argmax((a * np.exp(1j * n * t)).real.sum(axis=0), axis=0)
    return np.asarray(t[best, np.arange(t.shape[1])])


def _highest(values: Array, waves: int) -> NDArray[np.int64]:
    """Places (P, peaks) of the largest values (P, T) in different ones of the `waves` equal parts of the grid."""
    peaks = min(_PEAKS, waves)
    parts = values.reshape(len(values), waves, -1)
    inside = parts.argmax(axis=2)
    most = np.take_along_axis(parts, inside[:, :, None], axis=2)[:, :, 0]
    highest = np.argpartition(most, waves - peaks, axis=1)[:, waves - peaks :]
    return np.asarray(highest * parts.shape[2] + np.take_along_axis(inside, highest, axis=1))


def phase_points(phases: SlowPhases, count: int) -> ComplexArray:
    """Units exp(j theta) (count, G) that fill the phases evenly, a lattice; one point where nothing turns.

    Forces of open contact are periodic in each phase, of which lattices average all waves but few exactly.
    """
    if not phases:
        return np.ones((1, 0), complex)
    of, order, _ = _waves(phases)
    return np.asarray(np.exp(1j * order * (2 * np.pi * _lattice(count, len(phases))[:, of])))


def phase_steps(phases: SlowPhases, rounds: int) -> Array:
    """Turns (rounds, G, D) [rad] of the waves by steps of unit length in D fixed random directions of the phases.

    Along an edge few directions lead upwards, fewer the more phases there are: D is 4 of one, 16 of three.  A set of
    tied waves steps by the wave of its highest order.
    """
    count = 2 ** (min(len(phases), 4) + 1)
    step = np.random.default_rng(1).normal(size=(rounds, len(phases), count))
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    of, order, highest = _waves(phases)
    return np.asarray((order / highest)[:, None] * step[:, of])


def _waves(phases: SlowPhases) -> NDArray[np.int64]:
    """Set, order, and highest order of its set, (3, G), of every wave."""
    waves = sorted((i, at, order, max(n for _, n in tied)) for at, tied in enumerate(phases) for i, order in tied)
    return np.array(waves, np.int64).reshape(-1, 4).T[1:]


@lru_cache(maxsize=32)
def _lattice(count: int, dimensions: int) -> Array:
    """Points (count, d) in [0, 1) of the lattice i (1, a, a^2, ..) / count whose a has the least P_2 error.

    P_2 is the mean over the points of the product of 1 + 2 pi^2 B_2(x): the error in waves that fall with the square
    of their orders.
    """
    index = np.arange(count)[:, None]

    def points(a: int) -> Array:
        """Points of one lattice."""
        return np.asarray(np.mod(index * np.array([pow(a, j, count) for j in range(dimensions)]) / count, 1.0))

    def error(a: int) -> float:
        """P_2 of one lattice, and 1."""
        x = points(a)
        return float(np.prod(1 + 2 * np.pi**2 * (x * x - x + 1 / 6), axis=1).mean())

    return np.mod(points(min(range(1, count // 2), key=error)) + 0.5 / count, 1.0)


def closed_loads(force: Array, wave: ComplexArray, members: Sequence[MeshGroup], phases: SlowPhases) -> Array:
    """N F_i / sum F (2, S, w) [1] while contact stays, by `MEAN_LOADS`; inf where the sum may be zero or less.

    Parameters
    ----------
    force : (S, w) what stands still [N].  wave : (G, S, w) amplitudes of what turns [N].
    """
    loads = np.empty((2, *force.shape))
    for group in members:
        loads[..., group] = len(group) * np.array(_closed_shares(force[:, group], wave[:, :, group], phases))
    return loads


def _closed_shares(still: Array, turning: ComplexArray, phases: SlowPhases) -> tuple[Array, Array]:
    """F_i / sum F (S, N) without what turns, and the largest over the slow phases, both turning.

    Dinkelbach's iteration: the largest of F_i - lambda sum F over the phases gives the next lambda, which rises to the
    largest ratio.

    still : (S, N) [N].  turning : (G, S, N) [N].
    """
    total, swing = still.sum(axis=1, keepdims=True), turning.sum(axis=2, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = share = np.where(total > 0, still / total, np.inf)
        if not len(turning):
            return mean, mean
        if not np.any(np.abs(swing) > _CONSTANT * np.abs(total)):
            return mean, np.where(total > 0, (still + largest_sum(phases, turning)) / total, np.inf)
        least = total - largest_sum(phases, -swing)
        for _ in range(_STEPS):
            unit = units_of_largest(phases, turning - share * swing)
            ratio = (still + _summed(turning, unit)) / (total + _summed(np.broadcast_to(swing, turning.shape), unit))
            higher = np.maximum(share, ratio)
            if np.all(higher <= share * (1 + _CONSTANT)):
                break
            share = higher
    return mean, np.where(least > 0, share, np.inf)


def _summed(wave: ComplexArray, unit: ComplexArray) -> Array:
    """Re sum a u over the G waves of (G, ...), (...)."""
    return np.asarray(np.einsum("g...,g...", wave.real, unit.real) - np.einsum("g...,g...", wave.imag, unit.imag))


def least_forces(force: Array, wave: ComplexArray, phases: SlowPhases) -> Array:
    """Least force (S, w) [N] over the slow phases, of forces (S, w) and waves (G, S, w) [N]."""
    if not len(wave):
        return force
    return force - largest_sum(phases, -wave)


def falls_below(force: Array, wave: ComplexArray, phases: SlowPhases, limit: Array) -> NDArray[np.bool_]:
    """Samples (S,) of which any value (S, M) is below a limit (S, 1) at some slow phases, of waves (G, S, M)."""
    below: NDArray[np.bool_] = (force - np.abs(wave).sum(axis=0) < limit).any(axis=1)
    if any(len(waves) > 1 for waves in phases) and below.any():  # tied waves reach less
        at = np.flatnonzero(below)
        below[at] = (least_forces(force[at], wave[:, at], phases) < limit[at]).any(axis=1)
    return below


# Columns of a line that is left out, of one that stands still, and from 0 on of the turning frequencies.
_LEFT_OUT, _STILL = -2, -1
# Phases of the mesh cycle over which the force of a table is averaged; tables follow some twelve orders, whose aliases
# in the mean begin at this one.
_MESH_PHASES = 16


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineMap:
    """Q numbers that follow the lines of a System and columns beside them, in the unit of the numbers.

    still, torque : (Q,) what stands still without the torques, and what they add.
    frequency : (G,) of what turns, exact [Hz].  turning : (G, Q) amplitudes that the System holds.
    column : (C, Q) complex, per unit of each column.  column_line : (C,) place of its frequency in `frequency`,
        -1 where it stands still, -2 where it is at a mesh order and left out.
    """

    still: Array
    torque: Array
    frequency: tuple[Fraction, ...]
    turning: ComplexArray
    column: ComplexArray
    column_line: NDArray[np.int64]

    def values(self, factors: Array, torque: float | Array = 1.0) -> tuple[Array, ComplexArray]:
        """What stands still (S, Q) and amplitudes of what turns (G, S, Q) of samples.

        Parameters
        ----------
        factors : (S, C) on the columns.  torque : factor on the torques, one or (S,).
        """
        S = len(factors)
        standing = self.column_line == _STILL
        still = self.still + np.multiply.outer(np.broadcast_to(torque, S), self.torque)
        still += factors[:, standing] @ self.column[standing].real
        turning = np.empty((len(self.frequency), S, self.still.size), complex)
        for f in range(len(self.frequency)):
            together = self.column_line == f
            wave = factors[:, together] @ self.column[together].view(float)  # parts side by side: all stays real
            turning[f] = wave.view(complex) + self.turning[f]
        return still, turning


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadMap:
    """Stretches of M rows: m loaded flanks, c far flanks, l links whose stiffness varies.

    flexible : the train seen from these rows, loaded flanks and links closed.
    mesh_count, far : m; (c,) mesh row of each far flank.  far_stiffness : (c,) of one that presses [N/m].
    stretch : of the M rows [m].  left : (1,) largest force on a body that these leave [N], of sizes of factors.
    face, group, pair : whole meshes (w,), groups of them that share a load (g,) and their names.
    """

    flexible: Compliance
    mesh_count: int
    far: NDArray[np.int64]
    far_stiffness: Array
    stretch: LineMap
    left: LineMap
    face: Faces
    group: tuple[MeshGroup, ...]
    pair: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawMap:
    """Excitation of a train with laws as a linear function of its deviations.

    held : with mean mesh stiffness, seen from its rows.
    excitation : of the errors of loaded flanks (m), rows of groups (R), far flanks (c) [m] and the force (n) [N, N m].
    """

    held: HeldTrain
    excitation: LineMap


def at_mesh_order(system: System, line: Line) -> bool:
    """Whether a line is at a multiple of any mesh frequency."""
    return any((line.frequency / tone).denominator == 1 for tone in system.tones)


def line_map(
    system: System,
    columns: Sequence[Line],
    value: Callable[[Line], ComplexArray],
    *,
    constant: Array,
    torque: Array,
) -> LineMap:
    """Numbers (Q,) that are linear in lines, of the lines of a System and of columns.

    Parameters
    ----------
    value : line -> (Q,).  constant : (Q,) without any line or torque.  torque : (Q,) of the torques.
    """
    lines, base = (*system.lines, *columns), len(system.lines)
    turns = {line.frequency for line in lines if line.frequency and not at_mesh_order(system, line)}
    places = {frequency: i for i, frequency in enumerate(sorted(turns))}
    place = np.array(
        [places.get(line.frequency, _LEFT_OUT) if line.frequency else _STILL for line in lines], dtype=np.int64
    )
    amplitudes = np.array([value(line) for line in lines], complex).reshape(len(lines), constant.size)
    turning = np.zeros((len(places), constant.size), complex)
    for i, amplitude in zip(place[:base].tolist(), amplitudes[:base], strict=True):
        if i >= 0:
            turning[i] += amplitude
    return LineMap(
        still=constant + amplitudes[:base][place[:base] == _STILL].real.sum(axis=0),
        torque=torque,
        frequency=tuple(places),
        turning=turning,
        column=amplitudes[base:],
        column_line=place[base:],
    )


def load_map(system: System, columns: Sequence[Line] = (), *, links: NDArray[np.int64] | None = None) -> LoadMap:
    """The map of a System without laws, whose own lines and torques are the base.

    Parameters
    ----------
    columns : lines per unit of what varies between samples.
    links : rows of `System.links` whose stiffness varies between samples.

    Raises
    ------
    ModelError : a load that nothing balances.
    """
    varying = np.zeros(0, np.int64) if links is None else links
    meshes, far = system.meshes, system.far_flanks
    m, c = len(meshes.name), far.mesh.size
    flexible = _flexible(system, varying)
    require_balance(flexible.free, system.force[None], system)
    opening = np.zeros(flexible.stiffness.size)
    opening[: m + c] = system.flank_opening
    constant = _closed(flexible, opening, np.zeros_like(system.force))
    torque = _closed(flexible, np.zeros_like(opening), system.force)

    @functools.cache
    def solved(line: Line) -> tuple[ComplexArray, ComplexArray]:
        """Stretch and what it leaves of one line. Raises ModelError for a load that nothing balances."""
        force = force_at_rest(system, line)
        require_balance(flexible.free, np.array([force.real, force.imag]), system)
        # errors of links that vary are gaps of rows here, no forces
        link_gap = line.link_gap[varying]
        force = force - system.links.B[:, varying] @ (system.links.stiffness[varying] * link_gap)
        return _closed(flexible, np.concatenate([system.flank_gaps(line)[: m + c], link_gap]), force)

    # of each group its pair, and side where it has one
    groups, face = parallel_meshes(meshes), faces(meshes)
    names = [f"{meshes.pair[row]}.{meshes.side[row]}" for row in face.first[[group[0] for group in groups]].tolist()]
    return LoadMap(
        flexible=flexible,
        mesh_count=m,
        far=far.mesh,
        far_stiffness=meshes.stiffness[far.mesh],
        stretch=line_map(system, columns, lambda line: solved(line)[0], constant=constant[0], torque=torque[0]),
        left=line_map(system, columns, lambda line: solved(line)[1], constant=constant[1], torque=torque[1]),
        face=face,
        group=tuple(groups),
        pair=tuple(name.removeprefix("stages.").removesuffix(".") for name in names),
    )


def _flexible(system: System, links: NDArray[np.int64]) -> Compliance:
    """The train seen from its flanks and the links that vary, which are then rows and no part of K."""
    meshes, far = system.meshes, system.far_flanks
    train = held_train(system)
    if not links.size and not system.groups:
        return train.whole
    k_far = train.whole.stiffness[len(meshes.name) : len(meshes.name) + far.mesh.size]
    rows = np.hstack([meshes.B, far.B, system.links.B[:, links]])
    stiffness = np.concatenate([meshes.stiffness, k_far, system.links.stiffness[links]])
    return compliance(elastic_rows(system, links), rows, stiffness)


def _closed(flexible: Compliance, gap: Values, force: Values) -> tuple[Values, Values]:
    """Stretch (M,) [m] of all rows where each has its stiffness of `flexible`, and the force it leaves on a body (1,).

    gap : (M,) [m].  force : (n,) [N, N m].
    """
    pull = flexible.stiffness * gap
    stretch: Values = flexible.gap_of_force @ force + flexible.to_mesh @ pull - gap
    return stretch, imbalance(flexible, force[None], pull[None], (flexible.stiffness * stretch)[None])[0]


def law_map(system: System, columns: Sequence[Line] = (), *, tables: bool = False) -> LawMap:
    """The excitation of a System with laws.

    Parameters
    ----------
    columns : lines per unit of what varies between samples.  tables : whether those of meshes are asked; else their
        tangents, as linear analyses take them.
    """
    meshes, far = system.meshes, system.far
    even_meshes = replace(meshes, variation=np.zeros_like(meshes.variation), laws=meshes.laws if tables else ())
    even_far = far and replace(far, variation=np.zeros_like(far.variation), laws=far.laws if tables else ())
    still = still_excitation(system)
    torque = np.where(np.arange(still.size) < still.size - len(system.force), 0.0, still)
    return LawMap(
        held=held_train(replace(system, meshes=even_meshes, far=even_far)),
        excitation=line_map(
            system, columns, lambda line: line_excitation(system, line), constant=still - torque, torque=torque
        ),
    )


def law_forces(laws: LawMap, values: Array, stiffness: Array | None) -> tuple[Array, NDArray[np.bool_]]:
    """Forces of the mesh rows (T, m) [N], negative on far flanks, of meshes with a table their mean over a mesh cycle.

    With them whether each was found (T,).

    Parameters
    ----------
    values : (T, m + R + c + n) excitation.  stiffness : (T, m) of the mesh rows without a table; None: the mean.
    """
    system, T = laws.held.system, len(values)
    phases = _mesh_phases(system)
    force, found = np.zeros((T, len(system.meshes.name))), np.ones(T, bool)
    for phase in phases:
        here = excitation_of(system, values, np.tile(phase, (T, 1)), stiffness=stiffness)
        net, known = _settled(laws.held, here)
        force += net / len(phases)
        found &= known
    return force, found


def _mesh_phases(system: System) -> Array:
    """Phases (P, tones) of the mesh frequencies [turns]; one where no mesh has a table."""
    count = max(1, len(system.tones))
    if not system.meshes.laws:
        return np.zeros((1, count))
    # several tones: a lattice that fills all combinations evenly
    step = np.mod(np.cumprod(np.r_[1, np.full(count - 1, 5)]), _MESH_PHASES)
    return np.asarray(np.mod(np.outer(np.arange(_MESH_PHASES) / _MESH_PHASES, step), 1.0))


def _settled(held: HeldTrain, here: RecordExcitation) -> tuple[Array, NDArray[np.bool_]]:
    """Net forces (T, m) [N] at T instants and whether each was found; one without does not stop the others."""
    T = len(here.gap)
    try:
        return held.net_force(settled(held, here)), np.ones(T, bool)
    except (ModelError, ConvergenceError):
        if T == 1:
            return np.full((1, here.stiffness.shape[1]), np.nan), np.zeros(1, bool)
        halves = [_settled(held, here.at(half)) for half in np.array_split(np.arange(T), 2)]
        return np.concatenate([net for net, _ in halves]), np.concatenate([found for _, found in halves])
