"""Initial states of a run: rest, or the equilibrium at one instant."""

from __future__ import annotations

import numpy as np

from ...errors import ConvergenceError, ModelError
from ...statics.equilibrium import compliance, equilibrium
from ...system.elimination import elastic_rows
from ...system.system import Array
from .motion import Motion, from_modal, phases_at, to_modal
from .program import phase_at
from .right_hand_side import InstantTerms, acceleration, group_gaps, instant_terms

__all__ = ["at_equilibrium", "at_rest"]

# Newton steps; each either changes the set of flanks in contact or is the last, and splines need a few more.
_STEPS = 40
# Residual acceleration per the largest term of it: rounding of sums over all modes is 1e-13.
_TOLERANCE = 1e-11
# Singular values below this part of the largest belong to motions that nothing holds.
_FREE = 1e-12
# Halvings of a Newton step that does not make the residual smaller: curved laws want a few.
_HALVINGS = 8


def at_rest(moving: Motion) -> Array:
    """Nothing displaced, nothing moving relative to the nominal motion, (2, n) [m, rad], [m/s, rad/s]."""
    return np.zeros((2, moving.numbers.squared.size))


def at_equilibrium(moving: Motion, *, start: float = 0.0, slider: Array | None = None) -> Array:
    """The state (2, n) in which nothing moves and nothing accelerates at one instant, centrifugal terms included.

    The static equilibrium of what is loaded then is the first guess; Newton steps add what depends on the speed.
    Dampers act through the rate of the errors.  Motions that nothing holds are left alone.

    Parameters
    ----------
    start : the instant [s].  slider : (R,) of Coulomb friction before it [m]; where the mean load has put them where
        None.

    Raises
    ------
    ModelError, ConvergenceError : there is no such state, or it was not found.
    """
    N, at = moving.numbers, instant_terms(moving, start, start)
    before = N.anchor if slider is None else slider
    y = _first_guess(moving, at, start, before)
    still, left = np.zeros_like(y), _residual(moving, at, y, before)
    F = N.drag.size
    for _ in range(_STEPS):
        stretch = np.abs(y @ N.gaps)
        size = np.abs(at.push) + N.squared * np.abs(y) + (N.linear * stretch[:F]) @ np.abs(N.pulls[:F])
        if np.all(np.abs(left) <= _TOLERANCE * (size + np.max(size, initial=0.0))):
            return from_modal(moving, np.stack([y, still]))
        scale = _scale(moving)
        step, length = _newton_step(moving, at, y, left, before), 1.0
        trial = _residual(moving, at, y + step, before)
        for _ in range(_HALVINGS):
            if np.linalg.norm(scale * trial) < np.linalg.norm(scale * left):
                break
            length /= 2
            trial = _residual(moving, at, y + length * step, before)
        else:  # a kink: the whole step finds the other side
            length, trial = 1.0, _residual(moving, at, y + step, before)
        y, left = y + length * step, trial
    raise ConvergenceError("no equilibrium found to start from: start from rest, or from a state")


def _residual(moving: Motion, at: InstantTerms, y: Array, slider: Array) -> Array:
    """Acceleration (n,) of a state that does not move, without motions that nothing holds."""
    left = acceleration(moving, at, y, np.zeros_like(y), slider)
    left[moving.rigid] = 0.0  # nothing holds these, and the loads balance on them
    return left


def _scale(moving: Motion) -> Array:
    """Modal displacement per root of the strain energy (n,)."""
    squared = moving.numbers.squared
    scale: Array = 1.0 / np.sqrt(np.where(squared > 0, squared, max(float(squared.max(initial=0.0)), 1.0)))
    return scale


def _first_guess(moving: Motion, at: InstantTerms, start: float, slider: Array) -> Array:
    """Modal coordinates (n,) of the static equilibrium under the load of an instant; those of closed meshes if none."""
    N, m = moving.numbers, len(moving.system.meshes.name)
    if N.pull:
        return np.zeros(N.squared.size)
    load = np.asarray(np.linalg.solve(moving.shapes.T, at.push), dtype=np.float64)
    phases = phases_at(moving, phase_at(moving.program, np.array([start])))
    stiffness = np.concatenate([moving.flanks.linear, moving.laws.row_stiffness])
    try:
        found = equilibrium(
            compliance(elastic_rows(moving.system), moving.rows, stiffness),
            stiffness=moving.flanks.tangent.at(phases).stiffness[:, :m],
            gap=at.error[None],
            force=load[None],
            flanks=at.flanks,
            laws=moving.laws,
            anchor=slider[None] if slider.size else None,
        )
    except ModelError:  # without what depends on the speed the load may part bodies that it holds together
        return np.zeros(N.squared.size)
    state: Array = to_modal(moving, found.displacement[:1])[0]
    return state


def _newton_step(moving: Motion, at: InstantTerms, y: Array, left: Array, slider: Array) -> Array:
    """A Newton step (n,) with the tangents of the laws.

    From the acceleration `left` (n,).
    """
    N = moving.numbers
    F, s = N.drag.size, at.speed
    stretch = y @ N.gaps
    tangent = np.zeros((stretch.size, stretch.size))
    tangent[:F, :F] = np.diag(at.k if N.pull else at.flanks.evaluate((stretch - at.error)[None, :F])[1][0])
    if stretch.size > F:
        tangent[F:, F:] = moving.laws.tangent(group_gaps(moving, at, y), slider if slider.size else None)
    mean = np.zeros_like(tangent)
    mean[:F, :F] = np.diag(N.linear)
    mean[F:, F:] = N.block
    stiff = np.diag(N.squared) + (N.gaps @ (tangent - mean) @ N.pulls).T
    stiff += (s * s * N.stiff[0] + s * N.stiff[1] + at.rise * N.stiff[2]).T
    scale = _scale(moving)
    step: Array = scale * np.linalg.lstsq(scale[:, None] * stiff * scale, scale * left, rcond=_FREE)[0]
    return step
