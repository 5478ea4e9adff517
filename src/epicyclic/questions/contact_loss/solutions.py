"""Solutions with contact loss: the harmonics they take, whether they are stable, how an unstable one is left.

A balance takes as many harmonics, samples and cycles as its motion needs: it is refined until the residual seen with
twice the harmonics and samples is small [krack2019].  Each problem is made once; what has been found of the Floquet
stability of a solution stands with it.

Stability is that of the variational equation, which has the tangents of the contact along the motion [seydel2010].  Of
a periodic motion it has the Floquet multipliers of `questions.stability.floquet`.

With two mesh tones the tangents of the laws are quasi-periodic, so no period has multipliers: disturbances grow along
the path through both phases (derived here).  The kicks are taken from the laws at the phases of both tones.  A block of
disturbances goes through windows of whole cycles of the first tone, after which the second tone is nearly where it
began, mostly within 1/50 of a cycle.  Each window is then nearly a period, the Ritz values of the block are nearly its
multipliers, and their mean over windows is the growth along the path.  Where the tones have a short common period, a
window holds it a whole number of times, and the Ritz values are Floquet multipliers.

A motion has the symmetry of its train where, turned by one branch and shifted in time, it is itself (derived here).  A
stage whose branches are alike, their mesh phases whole parts of a cycle apart, is itself when turned by one branch and
shifted by such a part.  Each of its motions then has an image that is a motion too, and a motion with less symmetry is
another one than its image.  Which shift is the train's is decided by the balance: at the wrong one the image is no
motion, and neither is any where the branches differ.

Shapes: R rows, T samples, S steps, N states, k disturbances.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.system import Array, ComplexArray, Symmetry
from ..modes.eigen import Modal
from ..response.response import Response
from ..stability.floquet import (
    BREAKING,
    CIRCLE,
    DIVERGENCE,
    FOLD,
    STABLE,
    Floquet,
    VariationalFlow,
    floquet,
    multiplier_kind,
    steps_needed,
    variational_flow,
)
from .continuation import NewtonResult, linear_start, solve
from .problem import Problem, State, dynamic_size, evaluate, gap_rows, lift_idle, mesh_problem, prolonged
from .rows import GapRows

# Steps of a mesh cycle in which contact changes; so many times as many, as often, while the circle is within the error.
_STEPS, _TIMES, _FINER = 48, 3, 3
# Error of a multiplier with the first steps: with contact that stays; with teeth that part 0.08 at a fold where they
# meet sharply, 0.06 elsewhere.
_NEAR_CLOSED, _NEAR = 0.03, 0.15
# Steps of a mesh cycle that are too many: beyond, one stability takes minutes and gigabytes.
_MOST_STEPS = 1_000_000
# Steps come in multiples of this, so that the grids of their samples are few.
_STEP = 24
# Samples of the contact in each step: its tangent is their mean.
_SAMPLES = 8
# A multiplier is real when its angle from the real axis is below this; a pair that meets there does so as a root.
_REAL = 1e-2
# Cycles of the first tone in a window, least and most: few enough that a growth of 2 a cycle is far from overflow,
# enough that most of what decays is gone and that the phase of the second tone mostly recurs within 1/50.
_LEAST, _MOST = 16, 48
# Steps of the faster mesh cycle in which contact changes, as of one tone, and samples of the contact in a step.
_TORUS_STEPS, _TORUS_SAMPLES = 48, 4
# Disturbances side by side: the slowest pairs of a train that decay alike.
_BLOCK = 8
# Windows run: at least one to leave the transient; at most, for states near to 1.  A growth within `_NEAR` of 1 is run
# until its error is below `_ERROR` and below its distance from 1.
_WINDOWS, _NEAR_UNIT_GROWTH, _ERROR = 12, 0.03, 5e-4
# Doubles of a matrix over the samples of some cycles and all rows, of which ten are alive at a time.
_VALUES = 4_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Stability:
    """How a small disturbance of a motion goes on.

    multiplier : the largest of the period, free motions apart; with two mesh tones the growth a cycle of the first.
    steps : of a period, or of a cycle of the first tone.
    error : of the size of the multiplier, as finer steps and the residual of the motion show it.
    kind : empty where stable, or how the motion is left, as of `stability.floquet`, a divergence as one of its two
        forms; ``growth`` with two mesh tones.
    """

    multiplier: complex
    kind: str
    steps: int
    error: float

    @property
    def stable(self) -> bool:
        """Whether every disturbance dies out, by the best estimate of the multiplier."""
        return not self.kind

    @property
    def decided(self) -> bool:
        """Whether the multiplier is further from the circle than its error."""
        return abs(abs(self.multiplier) - 1) > self.error


def require_fast_enough(ready: Response, speed: float, path: str) -> None:
    """Refuse a relative speed at which the multipliers of a mesh cycle would take too many steps.

    path : keyword or option of the speed, for the error.

    Raises
    ------
    ModelError : a speed that is too low.
    """
    steps, tone = too_many_steps(ready, speed), float(ready.lines.tone)
    if steps and len(ready.lines.tones) == 1:
        raise ModelError(
            f"a mesh cycle would take {steps:.1e} steps of the highest mode",
            path=path,
            given=f"{speed * tone:.3g} Hz mesh frequency",
            allowed=f'from {speed * tone * steps / _MOST_STEPS:.2g} Hz on, or unstable = "ignore"',
        )


def too_many_steps(ready: Response, speed: float) -> int:
    """Steps of a mesh cycle that multipliers would take at a relative speed, where these are too many; else 0."""
    steps = _least_steps(ready.modal, 1 / (speed * float(ready.lines.tone)), ready.system.meshes.variation)
    return steps if steps > _MOST_STEPS else 0


def floquet_stability(refinement: Refinement, at: Solution) -> Stability:
    """Largest Floquet multiplier of a motion with the tangents of the contact, and its kind.

    Near 1 the steps are made three times finer up to thrice, until the circle is further away than the error: the last
    change, of which methods of first order leave half and those of second order an eighth, and the residual of the
    motion where its contact changes, by which its tangents are late.

    Where the branch goes back in speed, between two folds, a real multiplier above 1 is the fold's.  Elsewhere another
    branch with less symmetry leaves this one.

    Raises
    ------
    numpy.linalg.LinAlgError : numbers that are not finite.
    """
    steps, unchanging = _steps(at.balance, at.state), at.state.unchanging
    largest = _floquet(refinement, at, steps).largest
    error = _NEAR_CLOSED if unchanging else _NEAR
    for _ in range(_FINER):
        if abs(abs(largest) - 1) > error:
            break
        coarse, steps = largest, _TIMES * steps
        largest = _floquet(refinement, at, steps).largest
        error = abs(abs(largest) - abs(coarse)) + (CIRCLE if unchanging else at.residual)
    kind = multiplier_kind(largest, real=_REAL)
    if kind == DIVERGENCE:
        kind = FOLD if at.backward else BREAKING
    return Stability(multiplier=largest, kind="" if kind == STABLE else kind, steps=steps, error=error)


def floquet_multipliers(refinement: Refinement, at: Solution, *, steps: int | None = None) -> ComplexArray:
    """All Floquet multipliers (2 n,) of a motion, those of free motions among them.

    Parameters
    ----------
    steps : of a period; None: as many as its stability takes.
    """
    return _floquet(refinement, at, steps or _steps(at.balance, at.state)).multipliers


def floquet_vector(refinement: Refinement, at: Solution) -> tuple[Array, Array]:
    """The most unstable disturbance of a motion at the first instant: position y and rate y' (n,), of unit energy."""
    solved = _floquet(refinement, at, _steps(at.balance, at.state), vectors=True)
    assert solved.position is not None
    assert solved.rate is not None
    return solved.position[:, 0].real, solved.rate[:, 0].real


class Tangents(NamedTuple):
    """Changes of stiffness [N/m] and damping [N s/m] of rows at steps (R, S), damping None where it stays."""

    stiffness: Array
    damping: Array | None

    @property
    def changing(self) -> NDArray[np.bool_]:
        """Rows (R,) with any change."""
        damping = np.zeros(1) if self.damping is None else self.damping
        return np.asarray(np.any((self.stiffness != 0) | (damping != 0), axis=1))

    def of(self, rows: NDArray[np.bool_]) -> Tangents:
        """The same of some rows (R,)."""
        return Tangents(self.stiffness[rows], None if self.damping is None else self.damping[rows])


def contact_tangents(refinement: Refinement, at: Solution, steps: int) -> Tangents:
    """Changes of all rows over a period, each the mean of its step, from the balance on finer samples."""
    balance, state = at.balance, at.state
    if state.unchanging:
        return _unchanged(balance, state, steps)
    fine = refinement.problem(at.harmonics, cycles=balance.cycles, samples=_SAMPLES * steps // balance.cycles)
    seen = evaluate(fine, prolonged(balance, fine, state.y), state.speed)
    change = seen.tangent - fine.rows.linear
    time = _period(balance, state) / len(change)
    return _step_means(fine.rows, np.append(change, change[:1], axis=0), seen.acting, seen.edge, time, steps)


def _step_means(
    rows: GapRows, change: Array, acting: Array | None, edge: Array | None, time: float, steps: int
) -> Tangents:
    """Means over steps of changes of the stiffness (T + 1, R) [N/m] at samples `time` [s] apart, the last one the end.

    A link row with the tangent k and the lag a of its damper has the force (1 + a d/dt) k x: the stiffness k + a k' and
    the damper a k.

    acting, edge : (T, F) as of `State`, None without dampers.
    """
    if acting is None and not rows.lag.any():
        return Tangents(_means(change[:-1], steps), None)
    damping = rows.lag * change
    stiffness = change[:-1] + np.diff(damping, axis=0) / time
    damping = damping[:-1]
    if acting is not None and edge is not None:
        # teeth that meet sooner meet their damper sooner: a stiffness for the moment of the meeting
        stiffness[:, : rows.count] += rows.damping * edge
        damping[:, : rows.count] += rows.damping * acting - rows.drag
    return Tangents(_means(stiffness, steps), _means(damping, steps))


def _means(values: Array, steps: int) -> Array:
    """Means (R, S) over the samples of each step, of values (T, R)."""
    return np.asarray(values.reshape(steps, len(values) // steps, -1).mean(axis=1).T)


def _unchanged(balance: Problem, state: State, steps: int) -> Tangents:
    """`contact_tangents` (rows, steps) where contact does not change: a linear system without corners."""
    rows, F = balance.rows, balance.rows.count
    phases = np.zeros((steps, len(balance.grid.counts)))
    phases[:, 0] = balance.cycles * np.arange(steps) / steps
    gap = (balance.grid.values(gap_rows(balance, state.y) - balance.error)[:, :F]).mean(axis=0)
    laws, delta = rows.at(phases), np.tile(gap, (steps, 1))
    lift_idle(delta, delta - laws.touch)
    touching = state.touching[0]
    change = np.repeat((state.tangent[0] - rows.linear)[:, None], steps, axis=1)
    # the tangent at each phase is one value over all gaps of the motion: that at its mean is asked
    change[:F] = np.where(touching, laws.evaluate(delta)[1], 0.0).T
    change[:F] -= rows.linear[:F, None]
    damping = rows.lag * (state.tangent[0] - rows.linear)
    damping[:F] += np.where(touching, rows.damping, 0.0) - rows.drag
    return Tangents(change, np.repeat(damping[:, None], steps, axis=1))


def _floquet(refinement: Refinement, at: Solution, steps: int, *, vectors: bool = False) -> Floquet:
    """Multipliers of a motion with so many steps of its period."""
    balance, state = at.balance, at.state
    tangents = contact_tangents(refinement, at, steps)
    used = tangents.changing
    used[0] |= not used.any()
    changes = tangents.of(used)
    return floquet(
        balance.modal,
        changes.stiffness,
        period=_period(balance, state),
        frame=state.speed if balance.frame_speed == "kinematic" else 1.0,
        damping=changes.damping,
        gaps=balance.rows.gaps[used],
        vectors=vectors,
    )


def _period(balance: Problem, state: State) -> float:
    """Period of a motion [s]."""
    return 2 * np.pi / (float(balance.omega[1]) * state.speed)


def _steps(balance: Problem, state: State) -> int:
    """Steps of a period, a whole number a mesh cycle; as of the linear system where contact does not change."""
    cycle = _period(balance, state) / balance.cycles
    least = _least_steps(balance.modal, cycle, balance.rows.flanks.variation)
    if not state.unchanging:
        least = max(_STEPS, least)
    return balance.cycles * _STEP * -(-least // _STEP)


def _least_steps(modal: Modal, cycle: float, variation: ComplexArray) -> int:
    """Steps of a mesh cycle [s] of the linear system; variation : (r, H) of the stiffness."""
    return steps_needed(modal, period=cycle, cycle=cycle, harmonics=variation.shape[1])


# --- two mesh tones ---------------------------------------------------------------------------------------------------


def quasi_periodic_growth(balance: Problem, state: State, tones: tuple[Fraction, ...]) -> Stability:
    """Largest growth of a disturbance of a motion a cycle of the first tone, free motions apart.

    Parameters
    ----------
    tones : (2,) exact mesh frequencies at the operating speed [Hz].

    Raises
    ------
    numpy.linalg.LinAlgError : numbers that are not finite.
    """
    window, period = window_cycles(tones[1] / tones[0])
    cycle = 2 * np.pi / (float(balance.tones[0]) * state.speed)
    # as of a linear system, and more where contact changes
    shortest = 2 * np.pi / (float(balance.tones.max()) * state.speed)
    harmonics = balance.rows.flanks.variation.shape[1]
    steps = steps_needed(balance.modal, period=cycle, cycle=shortest, harmonics=harmonics)
    if not state.unchanging:
        steps = max(steps, int(np.ceil(_TORUS_STEPS * cycle / shortest)))
    # cycles of the first tone whose tangents are made at once, so that a matrix over their samples stays small
    size = max(1, _VALUES // (steps * _TORUS_SAMPLES * len(balance.rows.linear)))
    turns = float(tones[1] / tones[0])
    first = tangents_along(balance, state, 0.0, min(size, window), steps, turns)
    # rows that change later do so somewhere on the grid
    used = first.changing | np.any(state.tangent != balance.rows.linear, axis=0)
    kept = first.of(used)
    flow = variational_flow(
        balance.modal,
        kept.stiffness.mean(axis=1),
        step=cycle / steps,
        frame=state.speed if balance.frame_speed == "kinematic" else 1.0,
        damping=None if kept.damping is None else kept.damping.mean(axis=1),
        gaps=balance.rows.gaps[used],
    )
    # disturbances of no preferred direction, the same every time
    noise = np.random.default_rng(0).standard_normal((flow.size, min(flow.size, _BLOCK)))
    block, rates = np.linalg.qr(noise)[0], list[float]()
    whole = period and flow.size <= _BLOCK
    while True:
        after = block
        for begin in range(0, window, size):
            start, count = (0 if period else len(rates) * window) + begin, min(size, window - begin)
            if size < window or (rates and not period):
                kept = tangents_along(balance, state, start, count, steps, turns).of(used)
            after = flow.propagated(after, kept.stiffness, kept.damping)
        if not np.isfinite(after).all():
            raise np.linalg.LinAlgError("a disturbance over a window is not finite")
        last, left = _rate(flow, block, after, window)
        rates.append(last)
        rate, error = _summed(rates, left, period=period)
        least = min(_ERROR, abs(rate - 1))
        if (
            whole
            or len(rates) == _WINDOWS
            or (len(rates) > 1 and (error < least or abs(rate - 1) > _NEAR_UNIT_GROWTH + error))
        ):
            kind = GROWTH if rate > 1 + CIRCLE else ""
            return Stability(multiplier=complex(rate), kind=kind, steps=steps, error=error)
        block = np.linalg.qr(after)[0]


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


def _rate(flow: VariationalFlow, block: Array, after: Array, cycles: int) -> tuple[float, float]:
    """Largest growth a cycle by the Ritz values of a block (N, k) and what a window makes of it, and its error."""
    mu, vectors = np.linalg.eig(block.T @ after)
    bound = np.ones(mu.size, bool)
    bound[np.argsort(np.abs(mu - 1), kind="stable")[: flow.mean.conserved]] = False
    if not bound.any():
        return 0.0, 0.0
    largest = int(np.flatnonzero(bound)[np.argmax(np.abs(mu[bound]))])
    size, vector = float(np.abs(mu[largest])), vectors[:, largest]
    if size == 0:
        return 0.0, 0.0
    left: ComplexArray = after @ vector - mu[largest] * (block @ vector)
    rate = size ** (1 / cycles)
    return rate, rate * float(np.linalg.norm(left)) / (size * cycles)


def tangents_along(balance: Problem, state: State, start: float, cycles: int, steps: int, turns: float) -> Tangents:
    """`contact_tangents` (R, cycles steps) from the laws at the phases of both tones, of all R rows.

    A sample in which contact opens or closes counts for the part in which it is closed, the gap continued linearly.

    Parameters
    ----------
    start : cycles of the first tone before.  cycles : of the first tone.  steps : of each.
    turns : cycles of the second tone per cycle of the first.
    """
    count = cycles * steps * _TORUS_SAMPLES
    first = start + np.arange(count + 1) / (steps * _TORUS_SAMPLES)
    phases = np.stack([first, turns * first], axis=1)
    rows, time = balance.rows, 2 * np.pi / (float(balance.tones[0]) * state.speed * steps * _TORUS_SAMPLES)
    F, delta = rows.count, balance.grid.at(phases, gap_rows(balance, state.y) - balance.error)
    tangent, acting, edge = _flanks(balance, phases, delta[:, :F], time)
    stiffness = np.zeros_like(delta)
    stiffness[:, :F] = tangent
    if rows.links is not None:
        stiffness[:, F:] = rows.links.evaluate(delta[:, F : F + rows.links.rows.size])[1]
    damped, change = bool(rows.damping.any()), stiffness - rows.linear
    return _step_means(
        rows, change, acting[:-1] if damped else None, edge[:-1] if damped else None, time, cycles * steps
    )


def _flanks(balance: Problem, phases: Array, delta: Array, time: float) -> tuple[Array, Array, Array]:
    """Tangents (T, F) [N/m] of flanks at gaps delta (T, F) [m] `time` [s] apart, with acting and edge as of `State`."""
    laws = balance.rows.at(phases)
    closed = delta - laws.touch
    lift_idle(delta, closed)
    travel = np.abs(np.gradient(closed, axis=0))
    place = np.divide(closed, travel, out=np.full_like(closed, np.inf), where=travel > 0)
    inside = np.abs(place) < 0.5
    acting = np.where(inside, 0.5 + np.where(inside, place, 0.0), (closed > 0).astype(float))
    # the mean gap of the part of a sample that is closed
    pressed = delta + np.where(inside, acting * travel / 2 - closed, 0.0)
    rate = np.gradient(delta, axis=0) / time
    edge = np.where(inside, np.divide(rate, travel, out=np.zeros_like(travel), where=travel > 0), 0.0)
    return acting * laws.evaluate(pressed)[1], acting, edge


# Numbers of harmonics tried in turn.
HARMONICS = (8, 12, 16, 24, 32, 48)
# Residual seen with twice the harmonics and samples at which there are enough of them: RMS right to about as much.
ACCURACY = 3e-4
# Samples of a mesh cycle per harmonic: of one mesh frequency, and of each of two, whose grid is their product.
_HARMONIC_SAMPLES = {1: 16, 2: 4}
# Parts of the varying load in turn, where neither Newton's method nor a start from closed flanks works.
_LOADS = (0.25, 0.5, 0.75, 0.9, 1.0)
# Two motions are the same within this part of their dynamic size: far above what is left of a residual.
_SAME = 1e-3

GROWTH = "growth"
"""How a motion of two mesh tones that is not stable is left: its growth has a size and no angle."""
Kind = Literal["periodic", "symmetry broken", "period 2"]
"""What sort of motion, as the variable ``motion`` of a sweep has it."""

ProblemSize = tuple[tuple[int, ...], int, int, int]
"""Harmonics of each mesh tone, order of the combinations, cycles and samples of a problem."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Refinement:
    """The problems of one System with one or two mesh frequencies.

    cross : order of the combinations kept.  problems : those made so far.
    stability : of states, and whether their branch goes back in speed, as far as asked for.
    """

    ready: Response
    cross: int = 10
    problems: dict[ProblemSize, Problem] = field(default_factory=dict)
    stability: dict[tuple[State, bool], Stability] = field(default_factory=dict)

    def problem(self, harmonics: int, *, cycles: int = 1, samples: int = 0) -> Problem:
        """The balance with so many harmonics of each mesh frequency.

        Parameters
        ----------
        samples : of a mesh cycle, 0 the usual number.
        """
        tones = len(self.ready.lines.tones)
        return self.lattice((harmonics,) * tones, self.cross, cycles, samples or self.samples(harmonics))

    def lattice(self, harmonics: tuple[int, ...], cross: int, cycles: int, samples: int) -> Problem:
        """The balance with so many harmonics of each mesh frequency, combinations and samples."""
        key = (harmonics, cross, cycles, samples)
        if key not in self.problems:
            self.problems[key] = mesh_problem(
                self.ready, harmonics=harmonics, cross=cross, samples=samples, cycles=cycles
            )
        return self.problems[key]

    def size_of(self, value: object) -> ProblemSize | None:
        """Size of a problem of this refinement, None of anything else: how a run that is stopped refers to it."""
        return next((size for size, problem in self.problems.items() if problem is value), None)

    def samples(self, harmonics: int) -> int:
        """The usual number of samples of a mesh cycle."""
        return harmonics * _HARMONIC_SAMPLES[len(self.ready.lines.tones)]

    def residual(self, balance: Problem, state: State, harmonics: int) -> float:
        """Residual of a solution seen with twice the harmonics and samples, relative to its dynamic size.

        It holds what is dropped, and what the sampling of contacts that open and close has cost.
        """
        fine = self.problem(2 * harmonics, cycles=balance.cycles)
        seen = evaluate(fine, prolonged(balance, fine, state.y), state.speed)
        return seen.norm / dynamic_size(state.y)


def harmonics_for(harmonics: int) -> int:
    """The least of `HARMONICS` that is at least so many, the last one where none is."""
    return next((count for count in HARMONICS if count >= harmonics), HARMONICS[-1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """A periodic motion with the balance that it solves.

    state : with so many harmonics.  residual : with twice as many.  kind : what sort of motion.
    stability : None where not asked for.  backward : whether its branch goes back in speed there.
    """

    balance: Problem
    harmonics: int
    state: State
    residual: float
    kind: Kind = "periodic"
    stability: Stability | None = None
    backward: bool = False

    @property
    def stable(self) -> bool:
        """Whether it is known to be stable."""
        return self.stability is not None and self.stability.stable


def solution(
    refinement: Refinement,
    start: Array,
    speed: float,
    *,
    balance: Problem,
    harmonics: int,
    fixed: bool = False,
    kind: Kind = "periodic",
    backward: bool = False,
) -> Solution | None:
    """The motion that Newton's method reaches from a start, refined until it has harmonics enough; None where it fails.

    Parameters
    ----------
    start : (2, J, n) on the points of `balance`, which has so many harmonics.  fixed : keep that number.
    """
    at: Solution | None = None
    for count in (harmonics, *(() if fixed else (finer for finer in HARMONICS if finer > harmonics))):
        if at is not None:
            if at.residual <= ACCURACY:
                break
            balance = refinement.problem(count, cycles=at.balance.cycles)
            start = prolonged(at.balance, balance, at.state.y)
        solved = solve(balance, start, speed)
        if not solved.converged:
            break
        residual = refinement.residual(balance, solved.state, count)
        at = Solution(
            balance=balance, harmonics=count, state=solved.state, residual=residual, kind=kind, backward=backward
        )
    return at


def with_stability(refinement: Refinement, at: Solution) -> Solution:
    """The same with its stability, computed once: by Floquet multipliers, or as growth with two mesh frequencies."""
    if at.stability is not None:
        return at
    key, tones = (at.state, at.backward), refinement.ready.lines.tones
    if key not in refinement.stability:
        one_tone = len(tones) == 1
        refinement.stability[key] = (
            floquet_stability(refinement, at) if one_tone else quasi_periodic_growth(at.balance, at.state, tones)
        )
    return replace(at, stability=refinement.stability[key])


def distinct(first: Solution, second: Solution) -> bool:
    """Whether two motions of one speed differ, also after a shift by whole mesh cycles."""
    return distance(first, second) > _SAME


def distance(first: Solution, second: Solution) -> float:
    """Least difference of two motions over shifts by whole mesh cycles, per dynamic size of the larger one."""
    a, b = (first, second) if len(first.balance.omega) >= len(second.balance.omega) else (second, first)
    y = prolonged(b.balance, a.balance, b.state.y)
    orders = a.balance.grid.points.sum(axis=1)
    distances = []
    for shift in range(a.balance.cycles):
        turn = np.exp(2j * np.pi * orders * shift / a.balance.cycles)[:, None]
        moved = (y[0] + 1j * y[1]) * turn - (a.state.y[0] + 1j * a.state.y[1])
        distances.append(float(np.linalg.norm(moved)))
    return min(distances) / max(dynamic_size(a.state.y), dynamic_size(y))


def load_continuation(refinement: Refinement, speed: float, *, harmonics: int) -> NewtonResult:
    """A solution from closed flanks, or by continuation in the load: the varying load brought up in parts.

    Stiffness variation, errors, dynamic forces and curvature of the laws are scaled together; mean loads stay.
    """
    balance = refinement.problem(harmonics)
    solved = solve(balance, linear_start(balance, speed), speed)
    if solved.converged:
        return solved
    rows, J = balance.rows, len(balance.omega)
    mean = np.concatenate([rows.flanks.stiffness, rows.linear[rows.count :]])
    for part in _LOADS:
        error, force = balance.error.copy(), balance.force.copy()
        error[np.r_[1:J, J + 1 : 2 * J]] *= part
        force[:, :, 1:] *= part
        eased = replace(
            balance,
            rows=rows if rows.links is None else replace(rows, links=replace(rows.links, part=part)),
            error=error,
            force=force,
            laws=balance.laws.eased(rows.flanks.stiffness, part),
            tangent=mean + part * (balance.tangent - mean),
        )
        solved = solve(eased, solved.state.y if part > _LOADS[0] else linear_start(eased, speed), speed)
        if not solved.converged:
            break
    return solved


# --- symmetry ---------------------------------------------------------------------------------------------------------


def symmetry_is_broken(refinement: Refinement, at: Solution) -> bool:
    """Whether a motion of whole mesh cycles has less symmetry than a stage of its train.

    An image counts as a motion where its residual is at most `ACCURACY` above that of the motion, by as much as they
    are known, and as another one where the two are `distinct`, as any two motions.
    """
    for symmetry in refinement.ready.system.symmetries:
        if not symmetry.holds or symmetry.branches < 2:
            continue
        images = list(_images(refinement, at, symmetry))
        if all(distinct(at, image) for image in images) and any(
            refinement.residual(at.balance, image.state, at.harmonics) <= at.residual + ACCURACY for image in images
        ):
            return True
    return False


def _images(refinement: Refinement, at: Solution, symmetry: Symmetry) -> Iterator[Solution]:
    """A motion turned by one branch, at every shift of its stage's tone by a whole part of a cycle.

    Of the states only y is that of the image.
    """
    balance, meshes = at.balance, refinement.ready.system.meshes
    tones = {int(tone) for tone, stage in zip(meshes.tone, meshes.stage, strict=True) if stage == symmetry.stage}
    # turning by one branch, of modal coordinates (n, n)
    shapes = refinement.ready.modal.shapes
    turn = np.asarray(np.linalg.solve(shapes, symmetry.operator @ shapes), np.float64)
    turned = at.state.y @ turn.T
    turned[:, 0, balance.modal.rigid] = 0.0
    for part in range(symmetry.branches):
        cycles = part * balance.grid.points[:, sorted(tones)].sum(axis=1)
        shift = np.exp(2j * np.pi * cycles / symmetry.branches)[:, None]
        moved = (turned[0] + 1j * turned[1]) * shift
        yield replace(at, state=replace(at.state, y=np.stack([moved.real, moved.imag])))
