"""Static equilibrium with unilateral meshes: the least energy, by Newton steps with an exact line search, in batches.

    E(q) = q'Kq/2 - F'q + sum_m k_m <B'q - e>_m^2 / 2

Everything is condensed to the meshes.  With H = K + B diag(k0) B' (all meshes closed), A = H^+ B, S = B'A and the pull
p = k0 w - f of each mesh, q = H^+ F + A p, w = B'q, and the residual in mesh forces is r = p - k0 w + k <w - e>.
Motions that neither strain a link nor close a mesh (rigid rotation, an unsupported float) drop out with the
pseudo-inverse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConvergenceError, ModelError
from ..system.system import Array

Values = NDArray[Any]  # real or complex

__all__ = ["Compliance", "Equilibrium", "closed_force", "compliance", "equilibrium", "require_balance"]

# Eigenvalues of the matrix scaled to a unit diagonal: rounding is 1e-15, the softest support met is 1e-7 of a mesh.
_FREE = 1e-12
# Load along a free motion, per the sum of the sizes of its terms; torques that balance do so to rounding.
_BALANCE = 1e-9
# Stiffness an open mesh keeps in the Newton matrix (not in the forces), so that a body whose meshes are all open does
# not make it singular; 1e-9 of a mesh is below any support, so the steps stay Newton steps.
_OPEN = 1e-9
# Rounding of the residual, per mesh and per its largest term.
_ROUNDING = 1e-15
# Drop of the residual that lets a full Newton step stand.
_DROP = 0.1
# Energy slope that counts as none; rounding of the difference it comes from is 1e-15.
_FLAT = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Compliance:
    """The train seen from its meshes.

    stiffness : (m,) k0 [N/m].  inverse : (n, n) H^+.  to_body : (n, m) A.  to_mesh : (m, m) S [m/N].
    gap_of_force : (m, n) B'H^+.  free : (n, r) unit motions without any stiffness.
    """

    stiffness: Array
    inverse: Array
    to_body: Array
    to_mesh: Array
    gap_of_force: Array
    free: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Equilibrium:
    """Static state at T instants.

    displacement : (T, n), without any part along free motions.  mesh_force : (T, m) [N], >= 0.
    iterations : (T,) Newton steps taken.
    """

    displacement: Array
    mesh_force: Array
    iterations: np.ndarray


def compliance(K: Array, B: Array, stiffness: Array) -> Compliance:
    """Compliance of the train with all meshes closed; K (n, n), B (n, m), stiffness (m,) mean [N/m]."""
    H = K + (B * stiffness) @ B.T
    diagonal = np.diag(H)
    scale: Array = 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(scale[:, None] * ((H + H.T) / 2) * scale)
    stiff = values > _FREE * max(float(np.max(values, initial=0.0)), 1.0)
    held = scale[:, None] * vectors[:, stiff]
    inverse = (held / values[stiff]) @ held.T
    free = scale[:, None] * vectors[:, ~stiff]
    return Compliance(
        stiffness=stiffness,
        inverse=inverse,
        to_body=inverse @ B,
        to_mesh=B.T @ inverse @ B,
        gap_of_force=B.T @ inverse,
        free=free / np.maximum(np.linalg.norm(free, axis=0), np.finfo(float).tiny),
    )


def require_balance(free: Array, force: Array, names: Sequence[str]) -> None:
    """Check that no load (T, n) works on a free motion (n, r).

    Raises
    ------
    ModelError : one does; names the coordinate that contributes most.
    """
    work = force @ free
    size = np.abs(force) @ np.abs(free)
    if not np.any(np.abs(work) > _BALANCE * size):
        return
    instant, motion = np.unravel_index(int(np.argmax(np.abs(work) - _BALANCE * size)), work.shape)
    worst = int(np.argmax(np.abs(force[instant] * free[:, motion])))
    raise ModelError(
        "the load does not balance along a motion that nothing holds",
        path=names[worst],
        given=float(force[instant, worst]),
        allowed="loads in equilibrium, or a support",
    )


def closed_force(flexible: Compliance, stiffness: Array, gap: Values, free_gap: Values) -> Values:
    """Mesh forces with all meshes closed, tension allowed.

    Parameters
    ----------
    stiffness : (T, m) [N/m].  gap : (..., T, m) errors e [m], real or complex.  free_gap : (..., T, m) B'H^+ F [m].
    """
    pull = _closed_pull(flexible, stiffness, gap, free_gap)
    force: Values = flexible.stiffness * (free_gap + pull @ flexible.to_mesh) - pull
    return force


def _closed_pull(flexible: Compliance, stiffness: Array, gap: Values, free_gap: Values) -> Values:
    """p = k0 w - k (w - e) with w = B'H^+ F + S p, (..., T, m)."""
    soft = flexible.stiffness - stiffness
    matrix = np.eye(len(flexible.stiffness)) - soft[:, :, None] * flexible.to_mesh
    right = soft * free_gap + stiffness * gap
    pull: Values = np.linalg.solve(matrix, right[..., None])[..., 0]
    return pull


def equilibrium(
    flexible: Compliance,
    *,
    stiffness: Array,
    gap: Array,
    force: Array,
    start: Array | None = None,
    tolerance: float = 1e-10,
    max_iterations: int = 60,
) -> Equilibrium:
    """Equilibrium at T instants, meshes pulling nothing.

    Parameters
    ----------
    stiffness, gap : (T, m) k_m [N/m] and e_m [m].  force : (T, n) load.
    start : (T, m) approach B'q to start from [m]; all meshes closed where None.
    tolerance : of the mesh-force residual, relative to the largest mesh force.

    Raises
    ------
    ModelError : the load drives bodies apart and nothing holds them.
    ConvergenceError : not converged in `max_iterations`.
    """
    k0, S = flexible.stiffness, flexible.to_mesh
    free_gap = force @ flexible.gap_of_force.T
    if start is None:
        pull = _closed_pull(flexible, stiffness, gap, free_gap)
    else:
        pull = k0 * start - stiffness * np.maximum(start - gap, 0.0)
    iterations = np.zeros(len(gap), dtype=np.int64)
    open_points = np.arange(len(gap))
    for _ in range(max_iterations + 1):
        state = (pull[open_points], free_gap[open_points], stiffness[open_points], gap[open_points])
        residual, limit = _residual(S, k0, *state, tolerance)
        unfinished = np.max(np.abs(residual), axis=1, initial=0.0) > limit
        open_points = open_points[unfinished]
        if not open_points.size:
            return _finished(flexible, pull, free_gap, stiffness, gap, force, iterations)
        if iterations[open_points[0]] >= max_iterations:
            break
        pull[open_points] += _step(S, k0, residual[unfinished], *(part[unfinished] for part in state))
        iterations[open_points] += 1
    raise ConvergenceError(
        f"no static equilibrium after {max_iterations} steps at {open_points.size} of {len(gap)} instants; "
        "check that supports and meshes can carry the load"
    )


def _residual(
    S: Array, k0: Array, pull: Array, free_gap: Array, k: Array, gap: Array, tolerance: float = 0.0
) -> tuple[Array, Array]:
    """r = p - k0 w + k <w - e> (T, m) and what of it may stay (T,) [N]: a part of the largest force, and rounding."""
    w = free_gap + pull @ S
    contact = k * np.maximum(w - gap, 0.0)
    terms = np.max(np.maximum(np.abs(pull), k0 * (np.abs(w) + np.abs(gap))), axis=1, initial=np.finfo(float).tiny)
    limit = tolerance * np.max(contact, axis=1, initial=0.0) + _ROUNDING * len(k0) * terms
    return pull - k0 * w + contact, limit


def _step(S: Array, k0: Array, residual: Array, pull: Array, free_gap: Array, k: Array, gap: Array) -> Array:
    """Newton step of the pull times the length that makes the energy least along it, (T, m)."""
    opening = free_gap + pull @ S - gap
    tangent = np.where(opening > 0, k, _OPEN * k0)
    matrix = np.eye(len(k0)) - (k0 - tangent)[:, :, None] * S
    direction = -np.linalg.solve(matrix, residual[:, :, None])[:, :, 0]
    closing = direction @ S
    length = _least_energy(
        closing,
        opening,
        k,
        np.sum(closing * (residual - k * np.maximum(opening, 0.0)), axis=1),
        np.sum(closing * (direction - k0 * closing), axis=1),
        np.sum(k0 * closing**2, axis=1),
    )
    after, _ = _residual(S, k0, pull + direction, free_gap, k, gap)
    better = np.max(np.abs(after), axis=1) <= _DROP * np.max(np.abs(residual), axis=1)
    # Along a motion that nothing holds the energy is flat to rounding and its least place is noise: where the full step
    # already solves the forces and is no longer than twice the best, it stands.
    length = np.where(better & (length > 0.5), 1.0, length)
    return length[:, None] * direction


def _least_energy(closing: Array, opening: Array, k: Array, slope: Array, curvature: Array, scale: Array) -> Array:
    """Length (T,) of least energy along a direction, exact: the slope is piecewise linear and rising, a kink per mesh.

    slope(a) = slope + curvature a + sum k closing <opening + a closing>.  It satisfies any Armijo condition and is also
    safe in flat directions, where a full step would be far too long.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        kinks = np.where(closing != 0, -opening / closing, -1.0)
    kinks = np.where(np.isfinite(kinks) & (kinks > 0), kinks, 0.0)
    contact = np.maximum(opening[:, None, :] + kinks[:, :, None] * closing[:, None, :], 0.0)
    slopes = slope[:, None] + curvature[:, None] * kinks + np.einsum("tm,tjm->tj", k * closing, contact)
    at_zero = slope + np.sum(k * closing * np.maximum(opening, 0.0), axis=1)
    falling = slopes <= 0
    low = np.max(np.where(falling, kinks, 0.0), axis=1, initial=0.0)
    slope_low = np.max(np.where(falling & (kinks == low[:, None]), slopes, -np.inf), axis=1, initial=-np.inf)
    slope_low = np.where(low > 0, slope_low, at_zero)
    high = np.min(np.where(~falling & (kinks > low[:, None]), kinks, np.inf), axis=1, initial=np.inf)
    slope_high = np.min(np.where(kinks == high[:, None], slopes, np.inf), axis=1, initial=np.inf)
    final = curvature + np.sum(k * np.maximum(closing, 0.0) * closing, axis=1)
    bounded = np.isfinite(high)
    if np.any(~bounded & (final <= _FLAT * scale) & (slope_low < 0)):
        raise ModelError(
            "the load drives meshing bodies apart and nothing holds them",
            path="operation.torque",
            allowed="torques that press the meshes, or supports that hold every body",
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = -slope_low * (high - low) / (slope_high - slope_low)
        beyond = -slope_low / final
    step: Array = low + np.where(bounded, inside, beyond)
    # a slope that is not falling at the start is rounding at the solution: a plain Newton step
    return np.where(np.isfinite(step) & (at_zero < 0), np.maximum(step, 0.0), 1.0)


def _finished(
    flexible: Compliance, pull: Array, free_gap: Array, k: Array, gap: Array, force: Array, iterations: np.ndarray
) -> Equilibrium:
    contact = k * np.maximum(free_gap + pull @ flexible.to_mesh - gap, 0.0)
    displacement = force @ flexible.inverse + pull @ flexible.to_body.T
    return Equilibrium(displacement=displacement, mesh_force=contact, iterations=iterations)
