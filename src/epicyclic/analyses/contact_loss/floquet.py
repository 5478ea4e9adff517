"""Floquet stability of a periodic motion with contact loss, and how an unstable one is left [seydel2010].

The variational equation has the tangents of the contact along the motion; its multipliers are those of
`analyses.stability.floquet`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import ModelError
from ...questions.modes.basis import Modal
from ...questions.stability.floquet import (
    BREAKING,
    CIRCLE,
    DIVERGENCE,
    FOLD,
    STABLE,
    Floquet,
    floquet,
    multiplier_kind,
    steps_needed,
)
from ...system.system import Array, ComplexArray
from .problem import Problem, State, evaluate, gap_rows, prolonged

if TYPE_CHECKING:
    from ...questions.response.response import Response
    from .refinement import Refinement

__all__ = [
    "Stability",
    "contact_tangents",
    "floquet_multipliers",
    "floquet_stability",
    "floquet_vector",
    "require_fast_enough",
]


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
    if len(ready.lines.tones) > 1:
        return
    tone = float(ready.lines.tone)
    steps = _least_steps(ready.modal, 1 / (speed * tone), ready.system.meshes.variation)
    if steps > _MOST_STEPS:
        raise ModelError(
            f"a mesh cycle would take {steps:.1e} steps of the highest mode",
            path=path,
            given=f"{speed * tone:.3g} Hz mesh frequency",
            allowed=f"from {speed * tone * steps / _MOST_STEPS:.2g} Hz on",
        )


def floquet_stability(
    refinement: Refinement, given: Problem, harmonics: int, state: State, *, residual: float, backward: bool = False
) -> Stability:
    """Largest Floquet multiplier of a motion with the tangents of the contact, and its kind.

    Near 1 the steps are made three times finer up to thrice, until the circle is further away than the error: the last
    change, of which methods of first order leave half and those of second order an eighth, and the residual of the
    motion where its contact changes, by which its tangents are late.

    Parameters
    ----------
    harmonics : of the problem.  residual : of the motion.
    backward : whether the branch goes back in speed there, between two folds: a real multiplier above 1 is the fold's.
        Elsewhere another branch with less symmetry leaves this one.

    Raises
    ------
    numpy.linalg.LinAlgError : numbers that are not finite.
    """
    steps = _steps(refinement, given, state)
    largest = _largest(_floquet(refinement, given, harmonics, state, steps))
    error = _NEAR_CLOSED if state.unchanging else _NEAR
    for _ in range(_FINER):
        if abs(abs(largest) - 1) > error:
            break
        coarse, steps = largest, _TIMES * steps
        largest = _largest(_floquet(refinement, given, harmonics, state, steps))
        error = abs(abs(largest) - abs(coarse)) + (CIRCLE if state.unchanging else residual)
    return Stability(multiplier=largest, kind=_kind(largest, backward), steps=steps, error=error)


def floquet_multipliers(
    refinement: Refinement, given: Problem, harmonics: int, state: State, *, steps: int | None = None
) -> ComplexArray:
    """All Floquet multipliers (2 n,) of a motion, those of free motions among them.

    Parameters
    ----------
    steps : of a period; None: as many as its stability takes.
    """
    found = _floquet(refinement, given, harmonics, state, steps or _steps(refinement, given, state))
    return found.multipliers


def floquet_vector(refinement: Refinement, given: Problem, harmonics: int, state: State) -> tuple[Array, Array]:
    """The most unstable disturbance of a motion at the first instant: position y and rate y' (n,), of unit energy.

    Raises
    ------
    ValueError : the multipliers came without vectors.
    """
    found = _floquet(refinement, given, harmonics, state, _steps(refinement, given, state), vectors=True)
    if found.position is None or found.rate is None:
        raise ValueError("no vectors were asked for")
    return found.position[:, 0].real, found.rate[:, 0].real


def contact_tangents(
    refinement: Refinement, given: Problem, harmonics: int, state: State, steps: int
) -> tuple[Array, Array | None, Array]:
    """Changes of stiffness and damping of rows over a period (r, steps) [N/m, N s/m], and their gaps (r, n).

    Each is the mean of its step.  A link row with the tangent k and the lag a of its damper has the force
    (1 + a d/dt) k x: the stiffness k + a k' and the damper a k.  Rows that never change their contact or stiffness are
    left out, and the damping altogether where it stays.
    """
    if state.unchanging:
        return _unchanged(given, state, steps)
    fine = refinement.problem(harmonics, cycles=given.cycles, samples=_SAMPLES * steps // given.cycles)
    seen = evaluate(fine, prolonged(given, fine, state.y), state.speed)
    rows = fine.rows

    def mean(values: Array) -> Array:
        """Means (R, steps) over the samples of each step, of values (N, R)."""
        average: Array = values.reshape(steps, _SAMPLES, -1).mean(axis=1).T
        return average

    stiffness = seen.tangent - rows.linear
    if (seen.acting is None or seen.edge is None) and not rows.lag.any():
        used = np.any(stiffness != 0, axis=0)
        return mean(stiffness)[used], None, rows.gaps[used]
    damping = rows.lag * stiffness
    change = np.roll(damping, -1, axis=0) - damping
    stiffness = stiffness + change * (len(change) / _period(given, state))
    if seen.acting is not None and seen.edge is not None:
        # teeth that meet sooner meet their damper sooner: a stiffness for the moment of the meeting
        stiffness[:, : rows.count] += rows.damping * seen.edge
        damping[:, : rows.count] += rows.damping * seen.acting - rows.drag
    used = np.any((stiffness != 0) | (damping != 0), axis=0)
    return mean(stiffness)[used], mean(damping)[used], rows.gaps[used]


def _unchanged(given: Problem, state: State, steps: int) -> tuple[Array, Array, Array]:
    """`contact_tangents` (rows, steps) where contact does not change: a linear system without corners."""
    rows, F = given.rows, given.rows.count
    phases = np.zeros((steps, len(given.grid.counts)))
    phases[:, 0] = given.cycles * np.arange(steps) / steps
    gap = (given.grid.values(gap_rows(given, state.y) - given.error)[:, :F]).mean(axis=0)
    touching = state.touching[0]
    change = np.repeat((state.tangent[0] - rows.linear)[:, None], steps, axis=1)
    # the tangent at each phase is one value over all gaps of the motion: that at its mean is asked
    change[:F] = np.where(touching, rows.at(phases).evaluate(np.broadcast_to(gap, (steps, F)))[1], 0.0).T
    change[:F] -= rows.linear[:F, None]
    damping = rows.lag * (state.tangent[0] - rows.linear)
    damping[:F] += np.where(touching, rows.damping, 0.0) - rows.drag
    used = np.any(change != 0, axis=1) | (damping != 0)
    return change[used], np.repeat(damping[used][:, None], steps, axis=1), rows.gaps[used]


def _floquet(
    refinement: Refinement, given: Problem, harmonics: int, state: State, steps: int, *, vectors: bool = False
) -> Floquet:
    """Multipliers of a motion with so many steps of its period."""
    stiffness, damping, gaps = contact_tangents(refinement, given, harmonics, state, steps)
    if not len(stiffness):
        stiffness, gaps = np.zeros((1, steps)), np.zeros((1, given.modal.squared.size))
        damping = None
    return floquet(
        given.modal,
        stiffness,
        period=_period(given, state),
        frame=state.speed if given.frame_speed == "kinematic" else 1.0,
        damping=damping,
        gaps=gaps,
        vectors=vectors,
    )


def _period(given: Problem, state: State) -> float:
    """Period of a motion [s]."""
    return 2 * np.pi / (float(given.omega[1]) * state.speed)


def _steps(refinement: Refinement, given: Problem, state: State) -> int:
    """Steps of a period, a whole number a mesh cycle; as of the linear system where contact does not change."""
    cycle = _period(given, state) / given.cycles
    least = _least_steps(given.modal, cycle, given.rows.flanks.variation)
    if not state.unchanging:
        least = max(_STEPS, least)
    return given.cycles * _STEP * -(-least // _STEP)


def _least_steps(modal: Modal, cycle: float, variation: ComplexArray) -> int:
    """Steps of a mesh cycle [s] of the linear system; variation : (r, H) of the stiffness."""
    return steps_needed(modal, period=cycle, cycle=cycle, harmonics=variation.shape[1])


def _largest(found: Floquet) -> complex:
    """The largest multiplier, free motions apart; 0 where there is none."""
    own = found.multipliers[~found.free]
    return complex(own[0]) if own.size else 0j


def _kind(largest: complex, backward: bool) -> str:
    """How a motion with this largest multiplier is left, empty where it is stable."""
    kind = multiplier_kind(largest, real=_REAL)
    if kind == DIVERGENCE:
        return FOLD if backward else BREAKING
    return "" if kind == STABLE else kind
