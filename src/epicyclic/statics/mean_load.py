"""Load sharing without mesh-frequency content: `mean-load` and `mean-load-turning`, of many samples at once.

    mean-load          per pair and side the largest N F_i / sum F, F averaged over the hunting period
    mean-load-turning  the largest of that over the hunting period, F then the mean of a mesh cycle

F is the quasi-static force at mean mesh stiffness.  While contact stays, what turns averages out of the first.

Largest value of a sum of slow waves over their phases: independent ones by amplitude, tied ones on a grid.

Waves turn at exact frequencies.  Two whose ratio p : q is of small integers meet in few relative phases only; the
others come as close to every combination as 1 - cos(pi / |(p, q)|) of an amplitude, which is below 1 %: they are taken
as independent.  Tied ones have one common phase t and orders n, Re sum a exp(j n t).  Derived here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import gcd, hypot, lcm

import numpy as np
from numpy.typing import NDArray

from ..system.system import Array, ComplexArray
from .record import MeshGroup

# |(p, q)| from which two waves count as independent: 1 - cos(pi / 23) is 0.9 %.
_TIED = 23.0
# Largest order of tied waves that a grid resolves; beyond it even three waves come within 4 % of every combination.
_MOST_ORDER = 256
# Grid points in the shortest wave; the best points of so many waves are then refined by Newton steps.
_POINTS, _PEAKS, _SEARCH_STEPS = 8, 4, 4
# Complex numbers of one piece of the grid.
_PIECE = 500_000


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowPhases:
    """Sets of tied waves, each a tuple of (place among the G frequencies, order of their common phase)."""

    sets: tuple[tuple[tuple[int, int], ...], ...]


def slow_phases(frequency: Sequence[Fraction]) -> SlowPhases:
    """Sets of waves with one common phase each, of exact frequencies (G,) above zero [Hz]."""
    sets: list[list[int]] = []
    for place, own in enumerate(frequency):
        tied = [part for part in sets if any(_tied(own, frequency[other]) for other in part)]
        joined = sorted([place, *(other for part in tied for other in part)])
        if max(_orders([frequency[i] for i in joined])) > _MOST_ORDER:
            # too many common phases to resolve: with the one set that it is tied to most closely, or alone
            joined, tied = [place], []
        sets = [part for part in sets if part not in tied] + [joined]
    return SlowPhases(
        sets=tuple(tuple(zip(part, _orders([frequency[i] for i in part]), strict=True)) for part in sorted(sets))
    )


def any_tied(phases: SlowPhases) -> bool:
    """Whether any two waves have one common phase."""
    return any(len(part) > 1 for part in phases.sets)


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
    found = np.zeros(amplitude.shape[1:])
    for part in phases.sets:
        places = [place for place, _ in part]
        if len(part) == 1:
            found += np.abs(amplitude[places[0]])
        else:
            orders = np.array([order for _, order in part])
            a = amplitude[places].reshape(len(part), -1)
            unit = np.exp(1j * np.multiply.outer(orders, _common_phase(a, orders)))
            found += (a * unit).real.sum(axis=0).reshape(found.shape)
    return found


def units_of_largest(phases: SlowPhases, amplitude: ComplexArray) -> ComplexArray:
    """Units u = exp(j theta) (G, ...) at which Re sum a u is largest, of amplitudes a (G, ...)."""
    unit = np.empty_like(amplitude)
    for part in phases.sets:
        places = [place for place, _ in part]
        if len(part) == 1:
            a = amplitude[places[0]]
            size = np.abs(a)
            with np.errstate(divide="ignore", invalid="ignore"):
                unit[places[0]] = np.where(size > 0, a.conj() / size, 1.0)
        else:
            orders = np.array([order for _, order in part])
            t = _common_phase(amplitude[places].reshape(len(part), -1), orders)
            unit[places] = np.exp(1j * np.multiply.outer(orders, t)).reshape(amplitude[places].shape)
    return unit


def _common_phase(amplitude: ComplexArray, orders: NDArray[np.int64]) -> Array:
    """Common phase t (P,) [rad] of the largest Re sum a exp(j n t), amplitudes (g, P)."""
    count = int(_POINTS * orders.max())
    grid = 2 * np.pi * np.arange(count) / count
    wave = np.exp(1j * np.multiply.outer(orders, grid))
    table = np.concatenate([wave.real, -wave.imag])
    step = max(1, _PIECE // count)
    pieces = [amplitude[:, i : i + step] for i in range(0, amplitude.shape[1], step)]
    found = [
        _refined(a, grid[_highest(np.vstack([a.real, a.imag]).T @ table, int(orders.max()))].T, orders) for a in pieces
    ]
    return np.concatenate([np.zeros(0), *found])


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
    found: Array = t[best, np.arange(t.shape[1])]
    return found


def _highest(values: Array, waves: int) -> NDArray[np.int64]:
    """Places (P, peaks) of the largest values (P, T) in different ones of the `waves` equal parts of the grid."""
    peaks = min(_PEAKS, waves)
    parts = values.reshape(len(values), waves, -1)
    inside = parts.argmax(axis=2)
    most = np.take_along_axis(parts, inside[:, :, None], axis=2)[:, :, 0]
    place = np.argpartition(most, waves - peaks, axis=1)[:, waves - peaks :]
    chosen: NDArray[np.int64] = place * parts.shape[2] + np.take_along_axis(inside, place, axis=1)
    return chosen


def phase_points(phases: SlowPhases, count: int) -> ComplexArray:
    """Units exp(j theta) (count, G) that fill the phases evenly, a lattice; one point where nothing turns.

    Forces of open contact are periodic in each phase, of which lattices average all waves but few exactly.
    """
    sets = phases.sets
    if not sets:
        return np.ones((1, 0), complex)
    t = 2 * np.pi * _lattice(count, len(sets))
    unit = np.empty((count, sum(map(len, sets))), complex)
    for column, part in enumerate(sets):
        for place, order in part:
            unit[:, place] = np.exp(1j * order * t[:, column])
    return unit


def phase_steps(phases: SlowPhases, rounds: int) -> Array:
    """Turns (rounds, G, D) [rad] of the waves by steps of unit length in D fixed random directions of the phases.

    Along an edge few directions lead upwards, fewer the more phases there are: D is 4 of one, 16 of three.  A set of
    tied waves steps by the wave of its highest order.
    """
    sets = phases.sets
    count = 2 ** (min(len(sets), 4) + 1)
    step = np.random.default_rng(1).normal(size=(rounds, len(sets), count))
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    turn = np.empty((rounds, sum(map(len, sets)), count))
    for column, part in enumerate(sets):
        highest = max(order for _, order in part)
        for place, order in part:
            turn[:, place] = order / highest * step[:, column]
    return turn


@lru_cache(maxsize=32)
def _lattice(count: int, dimensions: int) -> Array:
    """Points (count, d) in [0, 1) of the lattice i (1, a, a^2, ..) / count whose a has the least P_2 error.

    P_2 is the mean over the points of the product of 1 + 2 pi^2 B_2(x): the error in waves that fall with the square
    of their orders.
    """
    index = np.arange(count)[:, None]

    def points(a: int) -> Array:
        """Points of one lattice."""
        found: Array = np.mod(index * np.array([pow(a, j, count) for j in range(dimensions)]) / count, 1.0)
        return found

    def error(a: int) -> float:
        """P_2 of one lattice, and 1."""
        x = points(a)
        return float(np.prod(1 + 2 * np.pi**2 * (x * x - x + 1 / 6), axis=1).mean())

    return np.mod(points(min(range(1, count // 2), key=error)) + 0.5 / count, 1.0)


MEAN_LOADS = ("mean-load", "mean-load-turning")
# A sum of forces that turns by less than this part of itself is constant: rounding.
_CONSTANT = 1e-12
# Dinkelbach steps, each quadratic; more than six are never seen.
_STEPS = 12


def closed_loads(force: Array, wave: ComplexArray, members: Sequence[MeshGroup], phases: SlowPhases) -> Array:
    """N F_i / sum F (2, S, w) [1] while contact stays, by `MEAN_LOADS`; inf where the sum may be zero or less.

    Parameters
    ----------
    force : (S, w) what stands still [N].  wave : (G, S, w) amplitudes of what turns [N].
    """
    loads = np.empty((2, *force.shape))
    for group in members:
        own, turning = force[:, group], wave[:, :, group]
        total, swing = own.sum(axis=1, keepdims=True), turning.sum(axis=2, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(total > 0, own / total, np.inf)
        loads[0][:, group] = len(group) * share
        loads[1][:, group] = len(group) * _largest_share(share, total, own, (turning, swing), phases)
    return loads


def _largest_share(
    share: Array, total: Array, own: Array, waves: tuple[ComplexArray, ComplexArray], phases: SlowPhases
) -> Array:
    """Largest F_i / sum F (S, N) over the slow phases, both turning: Dinkelbach's iteration.

    The largest of F_i - lambda sum F over the phases gives the next lambda, which rises to the largest ratio.

    share : (S, N) without what turns.  total : (S, 1) and own : (S, N) [N].  waves : of own (G, S, N), of total
    (G, S, 1) [N].
    """
    turning, swing = waves
    if not len(turning):
        return share
    with np.errstate(divide="ignore", invalid="ignore"):
        if not np.any(np.abs(swing) > _CONSTANT * np.abs(total)):
            return np.where(total > 0, (own + largest_sum(phases, turning)) / total, np.inf)
        least = total - largest_sum(phases, -swing)
        for _ in range(_STEPS):
            unit = units_of_largest(phases, turning - share * swing)
            found = (own + _summed(turning, unit)) / (total + _summed(np.broadcast_to(swing, turning.shape), unit))
            higher = np.maximum(share, found)
            if np.all(higher <= share * (1 + _CONSTANT)):
                break
            share = higher
    return np.where(least > 0, share, np.inf)


def _summed(wave: ComplexArray, unit: ComplexArray) -> Array:
    """Re sum a u over the G waves of (G, S, N), (S, N)."""
    result: Array = np.einsum("gsn,gsn->sn", wave.real, unit.real) - np.einsum("gsn,gsn->sn", wave.imag, unit.imag)
    return result


def least_forces(force: Array, wave: ComplexArray, phases: SlowPhases) -> Array:
    """Least force (S, w) [N] over the slow phases, of forces (S, w) and waves (G, S, w) [N]."""
    if not len(wave):
        return force
    return force - largest_sum(phases, -wave)


def falls_below(force: Array, wave: ComplexArray, phases: SlowPhases, limit: Array) -> NDArray[np.bool_]:
    """Samples (S,) of which any value (S, M) is below a limit (S, 1) at some slow phases, of waves (G, S, M)."""
    below: NDArray[np.bool_] = (force - np.abs(wave).sum(axis=0) < limit).any(axis=1)
    if any_tied(phases) and below.any():  # tied waves reach less
        at = np.flatnonzero(below)
        below[at] = (least_forces(force[at], wave[:, at], phases) < limit[at]).any(axis=1)
    return below


def loads_at_phases(force: Array, mean: Array, members: Sequence[MeshGroup]) -> Array:
    """N F_i / sum F (2, S, w) [1] by `MEAN_LOADS`; inf where the sum is zero or less.

    Parameters
    ----------
    force : (S, T, w) at T slow phases, the worst among them [N].  mean : (S, w) over all slow phases [N].
    """
    return np.stack([shares(mean[:, None], members)[:, 0], shares(force, members).max(axis=1)])


def shares(force: Array, members: Sequence[MeshGroup]) -> Array:
    """N F_i / sum F (S, T, w) [1] of forces (S, T, w) [N]; inf where the sum is zero or less."""
    found = np.empty_like(force)
    for group in members:
        own = force[:, :, group]
        total = own.sum(axis=2, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            found[:, :, group] = np.where(total > 0, len(group) * own / total, np.inf)
    return found


def largest_of_groups(loads: Array, members: Sequence[MeshGroup]) -> Array:
    """Coefficient of every group (..., g) from loads of the meshes (..., w) [1]."""
    return np.stack([loads[..., group].max(axis=-1) for group in members], axis=-1)
