"""Initial states of a run: rest, or the equilibrium at one instant."""

from __future__ import annotations

import numpy as np

from ...errors import ConvergenceError, ModelError
from ...system.system import Array
from ..static.equilibrium import compliance_of, equilibrium
from ..static.tangent import small_motion_tangent
from .motion import Motion, from_modal, to_modal
from .right_hand_side import InstantTerms, acceleration, instant_terms

__all__ = ["at_equilibrium", "at_rest"]

# Newton steps; each either changes the set of flanks in contact or is the last, and splines need a few more.
_STEPS = 40
# Residual acceleration per the largest term of it: rounding of sums over all modes is 1e-13.
_TOLERANCE = 1e-11
# Singular values below this part of the largest belong to motions that nothing holds.
_FREE = 1e-12


def at_rest(moving: Motion) -> Array:
    """Nothing displaced, nothing moving relative to the nominal motion, (2, n) [m, rad], [m/s, rad/s]."""
    return np.zeros((2, moving.numbers.squared.size))


def at_equilibrium(moving: Motion, *, start: float = 0.0) -> Array:
    """The state (2, n) in which nothing moves and nothing accelerates at one instant, centrifugal terms included.

    The static equilibrium of what is loaded then is the first guess; Newton steps add what depends on the speed.
    Dampers act through the rate of the errors.  Motions that nothing holds are left alone.

    Raises
    ------
    ModelError, ConvergenceError : there is no such state, or it was not found.
    """
    N, at = moving.numbers, instant_terms(moving.numbers, start, start)
    y = _first_guess(moving, at)
    still = np.zeros_like(y)
    for _ in range(_STEPS):
        left = acceleration(N, at, y, still)
        stretch = np.abs(y @ N.gaps)
        size = (
            np.abs(at.push)
            + N.squared * np.abs(y)
            + (N.linear * stretch[: N.mean.size]) @ np.abs(N.pulls[: N.mean.size])
        )
        left[moving.rigid] = 0.0  # nothing holds these, and the loads balance on them
        if np.all(np.abs(left) <= _TOLERANCE * (size + np.max(size, initial=0.0))):
            return from_modal(moving, np.stack([y, still]))
        y = y + _newton_step(moving, at, y, left)
    raise ConvergenceError("no equilibrium found to start from: start from rest, or from a state")


def _first_guess(moving: Motion, at: InstantTerms) -> Array:
    """Modal coordinates (n,) of the static equilibrium under the load of an instant; those of closed meshes if none."""
    system, N = moving.system, moving.numbers
    m, F = len(system.meshes.name), N.mean.size
    if N.pull:
        return np.zeros(N.squared.size)
    load = np.asarray(np.linalg.solve(moving.shapes.T, at.push), dtype=np.float64)
    gap = np.concatenate([at.error[:m], at.error[F:]])
    try:
        found = equilibrium(
            compliance_of(system),
            stiffness=np.maximum(at.k[:m], 1e-6 * N.mean[:m])[None],
            gap=gap[None],
            force=load[None],
            laws=system.laws,
        )
    except ModelError:  # the load drives bodies onto far flanks, which the static solution does not know
        return np.zeros(N.squared.size)
    state: Array = to_modal(moving, found.displacement[0])
    return state


def _newton_step(moving: Motion, at: InstantTerms, y: Array, left: Array) -> Array:
    """A Newton step (n,) with the tangents of the flanks in contact and of the laws.

    From the acceleration `left` (n,).
    """
    N = moving.numbers
    F, s = N.mean.size, at.speed
    stretch = y @ N.gaps
    in_contact = N.pull | (stretch[:F] > at.error[:F])
    tangent = np.zeros((stretch.size, stretch.size))
    tangent[:F, :F] = np.diag(np.where(in_contact, at.k, 0.0))
    if stretch.size > F:
        tangent[F:, F:] = small_motion_tangent(moving.system.laws, stretch[F:] - at.error[F:])
    mean = np.zeros_like(tangent)
    mean[:F, :F] = np.diag(N.linear)
    mean[F:, F:] = N.block
    stiff = np.diag(N.squared) + (N.gaps @ (tangent - mean) @ N.pulls).T
    stiff += (s * s * N.stiff[0] + s * N.stiff[1] + at.rise * N.stiff[2]).T
    scale = 1.0 / np.sqrt(np.where(N.squared > 0, N.squared, max(float(N.squared.max(initial=0.0)), 1.0)))
    step: Array = scale * np.linalg.lstsq(scale[:, None] * stiff * scale, scale * left, rcond=_FREE)[0]
    return step
