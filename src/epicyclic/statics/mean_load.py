"""Load sharing without mesh-frequency content: `mean-load` and `mean-load-turning`, of many samples at once.

    mean-load          per pair and side the largest N F_i / sum F, F averaged over the hunting period
    mean-load-turning  the largest of that over the hunting period, F then the mean of a mesh cycle

F is the quasi-static force at mean mesh stiffness, a sum of slow waves.  While contact stays, what turns averages out
of the first, and the second is a largest value over the phases of the waves: of independent ones by amplitude, of tied
ones on a grid.

Waves turn at exact frequencies.  Two whose ratio p : q is of small integers meet in few relative phases only; the
others come as close to every combination as 1 - cos(pi / |(p, q)|) of an amplitude, which is below 1 %: they are taken
as independent.  Tied ones have one common phase t and orders n, Re sum a exp(j n t).  Derived here.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from math import gcd, hypot, lcm

import numpy as np
from numpy.typing import NDArray

from ..system.system import Array, ComplexArray
from .record import MeshGroup

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
    largest = np.zeros(amplitude.shape[1:])
    for waves in phases:
        places = [place for place, _ in waves]
        if len(waves) == 1:
            largest += np.abs(amplitude[places[0]])
        else:
            orders = np.array([order for _, order in waves])
            a = amplitude[places].reshape(len(waves), -1)
            unit = np.exp(1j * np.multiply.outer(orders, _common_phase(a, orders)))
            largest += (a * unit).real.sum(axis=0).reshape(largest.shape)
    return largest


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
    phase: Array = t[best, np.arange(t.shape[1])]
    return phase


def _highest(values: Array, waves: int) -> NDArray[np.int64]:
    """Places (P, peaks) of the largest values (P, T) in different ones of the `waves` equal parts of the grid."""
    peaks = min(_PEAKS, waves)
    parts = values.reshape(len(values), waves, -1)
    inside = parts.argmax(axis=2)
    most = np.take_along_axis(parts, inside[:, :, None], axis=2)[:, :, 0]
    highest = np.argpartition(most, waves - peaks, axis=1)[:, waves - peaks :]
    places: NDArray[np.int64] = highest * parts.shape[2] + np.take_along_axis(inside, highest, axis=1)
    return places


def phase_points(phases: SlowPhases, count: int) -> ComplexArray:
    """Units exp(j theta) (count, G) that fill the phases evenly, a lattice; one point where nothing turns.

    Forces of open contact are periodic in each phase, of which lattices average all waves but few exactly.
    """
    if not phases:
        return np.ones((1, 0), complex)
    t = 2 * np.pi * _lattice(count, len(phases))
    unit = np.empty((count, sum(map(len, phases))), complex)
    for column, waves in enumerate(phases):
        for place, order in waves:
            unit[:, place] = np.exp(1j * order * t[:, column])
    return unit


def phase_steps(phases: SlowPhases, rounds: int) -> Array:
    """Turns (rounds, G, D) [rad] of the waves by steps of unit length in D fixed random directions of the phases.

    Along an edge few directions lead upwards, fewer the more phases there are: D is 4 of one, 16 of three.  A set of
    tied waves steps by the wave of its highest order.
    """
    count = 2 ** (min(len(phases), 4) + 1)
    step = np.random.default_rng(1).normal(size=(rounds, len(phases), count))
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    turn = np.empty((rounds, sum(map(len, phases)), count))
    for column, waves in enumerate(phases):
        highest = max(order for _, order in waves)
        for place, order in waves:
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
        lattice: Array = np.mod(index * np.array([pow(a, j, count) for j in range(dimensions)]) / count, 1.0)
        return lattice

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
        still, turning = force[:, group], wave[:, :, group]
        mean, largest = _closed_shares(still, turning, phases)
        loads[0][:, group] = len(group) * mean
        loads[1][:, group] = len(group) * largest
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
    if any(len(waves) > 1 for waves in phases) and below.any():  # tied waves reach less
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
    share = np.empty_like(force)
    for group in members:
        total = force[:, :, group].sum(axis=2, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            share[:, :, group] = np.where(total > 0, len(group) * force[:, :, group] / total, np.inf)
    return share
