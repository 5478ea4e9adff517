"""Stability of a motion of two mesh tones: growth of disturbances along the path through both phases (derived here).

The tangents of the laws are quasi-periodic, so no period has multipliers.  The variational equation is that of
`analyses.stability.floquet`, its kicks taken from the laws at the phases of both tones.  A block of disturbances goes
through windows of whole cycles of the first tone, after which the second tone is nearly where it began, mostly
within 1/50 of a cycle.  Each window is then nearly a period, the Ritz values of the block are nearly its multipliers,
and their mean over windows is the growth along the path.  Where the tones have a short common period, a window holds it
a whole number of times, and the Ritz values are Floquet multipliers.

Shapes: R rows, T samples, S steps, N states, k disturbances.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...questions.stability.floquet import VariationalFlow, steps_needed, variational_flow
from ...system.system import Array, ComplexArray
from .problem import Problem, State, gap_rows

__all__ = ["Growth", "Tangents", "quasi_periodic_growth", "tangents_along", "window_cycles"]

# Cycles of the first tone in a window, least and most: few enough that a growth of 2 a cycle is far from overflow,
# enough that most of what decays is gone and that the phase of the second tone mostly recurs within 1/50.
_LEAST, _MOST = 16, 48
# Steps of the faster mesh cycle in which contact changes, as of one tone, and samples of the contact in a step.
_STEPS, _SAMPLES = 48, 4
# Disturbances side by side: the slowest pairs of a train that decay alike.
_BLOCK = 8
# Windows run: at least one to leave the transient; at most, for states near to 1.  A growth within `_NEAR` of 1 is run
# until its error is below `_ERROR` and below its distance from 1.
_WINDOWS, _NEAR, _ERROR = 12, 0.03, 5e-4
# Doubles of a matrix over the samples of some cycles and all rows, of which ten are alive at a time.
_VALUES = 4_000_000
# Samples in one product with the lattice points: bounds the memory of a (samples, 2 J) matrix.
_BATCH = 2048


class Growth(NamedTuple):
    """Growth of the worst disturbance a cycle of the first tone [1].

    error : of it, as the windows show.  steps : of a cycle.  cycles : run.
    """

    rate: float
    error: float
    steps: int
    cycles: int


class Tangents(NamedTuple):
    """Changes of stiffness [N/m] and damping [N s/m] of rows at steps (R, S), damping None where it stays."""

    stiffness: Array
    damping: Array | None


def quasi_periodic_growth(given: Problem, state: State, tones: tuple[Fraction, ...]) -> Growth:
    """Largest growth of a disturbance of a motion a cycle of the first tone, free motions apart.

    Parameters
    ----------
    tones : (2,) exact mesh frequencies at the operating speed [Hz].

    Raises
    ------
    numpy.linalg.LinAlgError : numbers that are not finite.
    """
    window, period = window_cycles(tones[1] / tones[0])
    cycle = 2 * np.pi / (float(given.tones[0]) * state.speed)
    steps = _steps(given, state, cycle)
    turns, size = float(tones[1] / tones[0]), _cycles_at_once(given, steps)
    first = tangents_along(given, state, 0.0, min(size, window), steps, turns)
    # rows that change later do so somewhere on the grid
    used = np.any(first.stiffness != 0, axis=1) | np.any(state.tangent != given.rows.linear, axis=0)
    if first.damping is not None:
        used |= np.any(first.damping != 0, axis=1)
    kept = _rows(first, used)
    flow = variational_flow(
        given.modal,
        kept.stiffness.mean(axis=1),
        step=cycle / steps,
        frame=state.speed if given.frame_speed == "kinematic" else 1.0,
        damping=None if kept.damping is None else kept.damping.mean(axis=1),
        gaps=given.rows.gaps[used],
    )
    block, rates = _start(flow.size), list[float]()
    whole = period and flow.size <= _BLOCK
    while True:
        after = block
        for begin in range(0, window, size):
            start, count = (0 if period else len(rates) * window) + begin, min(size, window - begin)
            if size < window or (rates and not period):
                kept = _rows(tangents_along(given, state, start, count, steps, turns), used)
            after = flow.propagated(after, kept.stiffness, kept.damping)
        if not np.isfinite(after).all():
            raise np.linalg.LinAlgError("a disturbance over a window is not finite")
        found, left = _rate(flow, block, after, window)
        rates.append(found)
        rate, error = _summed(rates, left, period=period)
        least = min(_ERROR, abs(rate - 1))
        if whole or len(rates) == _WINDOWS or (len(rates) > 1 and (error < least or abs(rate - 1) > _NEAR + error)):
            return Growth(rate=rate, error=error, steps=steps, cycles=len(rates) * window)
        block = np.linalg.qr(after)[0]


def _cycles_at_once(given: Problem, steps: int) -> int:
    """Cycles of the first tone whose tangents are made at once, so that a matrix over their samples stays small."""
    return max(1, _VALUES // (steps * _SAMPLES * len(given.rows.linear)))


def _summed(rates: list[float], left: float, *, period: bool) -> tuple[float, float]:
    """Growth a cycle by the windows so far, the first one a transient, and its error; left : residual of the last.

    Windows of whole periods repeat, the last is the best of them.  Others are a mean along the path.
    """
    if period or len(rates) < 3:
        return rates[-1], left if len(rates) < 2 else max(left, abs(rates[-1] - rates[-2]))
    known = np.log(np.maximum(rates[1:], np.finfo(float).tiny))
    mean, later = float(np.exp(known.mean())), float(np.exp(known[len(known) // 2 :].mean()))
    return mean, max(left / len(known), abs(mean - later))


def window_cycles(ratio: Fraction) -> tuple[int, bool]:
    """Cycles of the first tone in a window, and whether the second tone turns a whole number of times in them.

    Parameters
    ----------
    ratio : of the second mesh frequency to the first.
    """
    if ratio.denominator <= _MOST:
        return ratio.denominator * -(-_LEAST // ratio.denominator), True
    return min(range(_LEAST, _MOST + 1), key=lambda count: abs(count * ratio - round(count * ratio))), False


def _steps(given: Problem, state: State, cycle: float) -> int:
    """Steps of a cycle of the first tone: as of a linear system, and more where contact changes."""
    shortest = 2 * np.pi / (float(given.tones.max()) * state.speed)
    top = given.rows.flanks.variation.shape[1]
    least = steps_needed(given.modal, period=cycle, cycle=shortest, harmonics=top)
    return least if state.unchanging else max(least, int(np.ceil(_STEPS * cycle / shortest)))


def _start(size: int) -> Array:
    """A block of disturbances (N, k) of no preferred direction, the same every time."""
    noise = np.random.default_rng(0).standard_normal((size, min(size, _BLOCK)))
    return np.linalg.qr(noise)[0]


def _rate(flow: VariationalFlow, block: Array, after: Array, cycles: int) -> tuple[float, float]:
    """Largest growth a cycle by the Ritz values of a block (N, k) and what a window makes of it, and its error."""
    mu, vectors = np.linalg.eig(block.T @ after)
    own = np.ones(mu.size, bool)
    own[np.argsort(np.abs(mu - 1), kind="stable")[: flow.conserved]] = False
    if not own.any():
        return 0.0, 0.0
    largest = int(np.flatnonzero(own)[np.argmax(np.abs(mu[own]))])
    size, vector = float(np.abs(mu[largest])), vectors[:, largest]
    if size == 0:
        return 0.0, 0.0
    left: ComplexArray = after @ vector - mu[largest] * (block @ vector)
    rate = size ** (1 / cycles)
    return rate, rate * float(np.linalg.norm(left)) / (size * cycles)


def _rows(tangents: Tangents, used: NDArray[np.bool_]) -> Tangents:
    """The same of some rows."""
    damping = tangents.damping
    return Tangents(tangents.stiffness[used], None if damping is None else damping[used])


def tangents_along(given: Problem, state: State, start: float, cycles: int, steps: int, turns: float) -> Tangents:
    """`floquet.contact_tangents` (R, cycles steps) from the laws at the phases of both tones, of all R rows.

    A sample in which contact opens or closes counts for the part in which it is closed, the gap continued linearly.

    Parameters
    ----------
    start : cycles of the first tone before.  cycles : of the first tone.  steps : of each.
    turns : cycles of the second tone per cycle of the first.
    """
    count = cycles * steps * _SAMPLES
    first = start + np.arange(count + 1) / (steps * _SAMPLES)
    phases = np.stack([first, turns * first], axis=1)
    rows, time = given.rows, 2 * np.pi / (float(given.tones[0]) * state.speed * steps * _SAMPLES)
    F, delta = rows.count, _gaps_at(given, state, phases)
    tangent, acting, edge = _flanks(given, phases, delta[:, :F], time)
    stiffness = np.zeros_like(delta)
    stiffness[:, :F] = tangent
    if rows.links is not None:
        stiffness[:, F:] = rows.links.evaluate(delta[:, F : F + rows.links.rows.size])[1]
    stiffness -= rows.linear
    if not (rows.lag.any() or rows.damping.any()):
        return Tangents(_means(stiffness[:-1]), None)
    damping = rows.lag * stiffness
    whole = stiffness[:-1] + np.diff(damping, axis=0) / time
    damping = damping[:-1]
    # teeth that meet sooner meet their damper sooner: a stiffness for the moment of the meeting
    whole[:, :F] += rows.damping * edge[:-1]
    damping[:, :F] += rows.damping * acting[:-1] - rows.drag
    return Tangents(_means(whole), _means(damping))


def _means(values: Array) -> Array:
    """Means (R, S) over the samples of each step, of values (T, R)."""
    average: Array = values.reshape(-1, _SAMPLES, values.shape[1]).mean(axis=1).T
    return average


def _gaps_at(given: Problem, state: State, phases: Array) -> Array:
    """Gaps delta (T, R) [m] of a motion at phases (T, D) of the tones [cycles]."""
    opened, found = gap_rows(given, state.y) - given.error, list[Array]()
    for part in np.array_split(phases, -(-len(phases) // _BATCH)):
        wave = np.ones((len(part), len(given.grid.points)), complex)
        for phase, orders in zip(part.T, given.grid.points.T, strict=True):
            # one exponential an order of a tone, not one a lattice point
            own, place = np.unique(orders, return_inverse=True)
            wave *= np.exp(2j * np.pi * np.outer(phase, own))[:, place]
        found.append(np.concatenate([wave.real, -wave.imag], axis=1) @ opened)
    return np.concatenate(found)


def _flanks(given: Problem, phases: Array, delta: Array, time: float) -> tuple[Array, Array, Array]:
    """Tangents (T, F) [N/m] of flanks at gaps delta (T, F) [m] `time` [s] apart, with acting and edge as of `State`."""
    laws = given.rows.at(phases)
    closed = delta - laws.touch
    travel = np.abs(np.gradient(closed, axis=0))
    place = np.divide(closed, travel, out=np.full_like(closed, np.inf), where=travel > 0)
    inside = np.abs(place) < 0.5
    acting = np.where(inside, 0.5 + np.where(inside, place, 0.0), (closed > 0).astype(float))
    # the mean gap of the part of a sample that is closed
    pressed = delta + np.where(inside, acting * travel / 2 - closed, 0.0)
    rate = np.gradient(delta, axis=0) / time
    edge = np.where(inside, np.divide(rate, travel, out=np.zeros_like(travel), where=travel > 0), 0.0)
    return acting * laws.evaluate(pressed)[1], acting, edge
