"""Harmonic balance without forming a matrix: linear contact, any mesh frequencies, many speeds at once.

In energy-weighted modal coordinates every harmonic of frequency w reads D y + coupling + pulls^T {(k(t) - k0) gap(t)} =
b,
D = omega_r^2 - w^2 + i w d_r.  D^-1 is the preconditioner of GMRES [saad1986]; products with k(t) are exact
convolutions
of the harmonics (no aliasing), applied as small matrices that all speeds share.  Derived here from the equation of
motion of docs/design.md; signs and phases are those of docs/conventions.md.

Layout: a batch of P points holds y as (P, 2, J, n): real and imaginary parts of J harmonics in n coordinates.
Harmonics are points a of a lattice of the mesh frequencies f (a real signal, x = Re sum X_a exp(i a . w t), one of a
and
-a), or all points around a shaft frequency w_s (x = Re[exp(i w_s t) sum Y_a exp(i a . w t)]), exact for any real w_s.
One mesh frequency is a lattice of one axis, the orders 0..H or -H..H.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...system.system import Array, ComplexArray, System
from ..modes.basis import Modal
from .condensed import CondensedOperators
from .gmres import gmres
from .kernel import Kernel, product, to_real, truncated_product

__all__ = ["Batch", "Guess", "HarmonicSolution", "solve", "truncated_response"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Batch:
    """Excitation of a batch of P points.

    frequency : (P, J) of every harmonic; truncated_frequency : (P, T) of every truncated harmonic [rad/s].
    frame : (P,) factor of G and Cskew, squared of Kg [1].
    error : (m, P, J) complex [m].  force : (P, J, n) complex [N, N m].
    """

    frequency: Array
    truncated_frequency: Array
    frame: Array
    error: ComplexArray
    force: ComplexArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HarmonicSolution:
    """Solution of a batch.

    y : (P, 2, J, n) energy-weighted modal.  gap : (m, P, 2 J) B^T q - e [m].  frequency : (P, J) [rad/s].
    residual : (P,) of the harmonics kept.  truncation_residual : (P, D + 1) of the truncated ones, by their kind.  Both
        are
    relative to the dynamic part, whose size is scale (P,).  calls : of the operator.
    """

    y: Array
    gap: Array
    frequency: Array
    residual: Array
    truncation_residual: Array
    scale: Array
    calls: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Guess:
    """Initial guess from a solution with fewer harmonics.

    y : (P, 2, J, n), zero in the harmonics that are new.  scale : (P,) of `HarmonicSolution`.
    """

    y: Array
    scale: Array


def solve(
    system: System,
    modal: Modal,
    kernel: Kernel,
    batch: Batch,
    *,
    tolerance: float,
    guess: Guess | None = None,
    operators: CondensedOperators | None = None,
) -> HarmonicSolution:
    """Solve one batch of P points; residuals are returned, not tested.

    Parameters
    ----------
    tolerance : residual wanted, relative to the dynamic part of the response in the energy norm [1].
    operators : `condensed_operators` of the same arguments: solve by numba, which must be installed.
    """
    error = to_real(batch.error)
    right = _right(system, modal, kernel, batch, error)
    if operators is None:
        y, residual, scale, calls = _batched(modal, kernel, batch, right, guess, tolerance=tolerance)
        gap = _gaps(modal, y) - error
        truncation_residual = _truncation_residual(modal, kernel, batch, gap)
    else:
        from .compiled import truncation_size

        y, residual, scale, calls = _side_by_side(
            modal, kernel, batch, right, guess, tolerance=tolerance, operators=operators
        )
        gap = _gaps(modal, y) - error
        truncation_residual = np.outer(truncation_size(operators, batch.truncated_frequency, gap), [1.0, 0.0])
    return HarmonicSolution(
        y=y,
        gap=gap,
        frequency=batch.frequency,
        residual=residual,
        truncation_residual=truncation_residual / scale[:, None],
        scale=scale,
        calls=calls,
    )


def _batched(
    modal: Modal, kernel: Kernel, batch: Batch, right: Array, guess: Guess | None, *, tolerance: float
) -> tuple[Array, Array, Array, int]:
    """All P points at once by NumPy.

    Returns
    -------
    (y (P, 2, J, n), residual (P,) relative to the scale, scale (P,), operator calls).
    """
    inverse = _inverse(modal, batch.frequency)
    couple = _coupling(modal, kernel, batch)
    shape = right.shape

    def apply(x: Array) -> Array:
        """x + D^-1 coupling x, (P, 2 J n)."""
        return x + _times(inverse, couple(x.reshape(shape))).reshape(x.shape)

    first = _times(inverse, right)
    if guess is None:
        start = -_times(inverse, couple(first)).reshape(shape[0], -1)
        scale = _scale(first, start, mean=kernel.lattice.mirrored)
    else:
        start = first.reshape(shape[0], -1) - apply(guess.y.reshape(shape[0], -1))
        first, scale = guess.y, guess.scale
    step, left, calls = gmres(apply, start, target=tolerance * scale)
    return first + step.reshape(shape), left / scale, scale, calls


def _side_by_side(
    modal: Modal,
    kernel: Kernel,
    batch: Batch,
    right: Array,
    guess: Guess | None,
    *,
    tolerance: float,
    operators: CondensedOperators,
) -> tuple[Array, Array, Array, int]:
    """As `_batched`, compiled; points above the tolerance after single precision go on in double precision by NumPy."""
    from .compiled import solve_points

    start = None if guess is None else (guess.y, guess.scale)
    y, residual, scale, calls = solve_points(
        operators, batch.frequency, batch.frame, right, start=start, tolerance=tolerance, mean=kernel.lattice.mirrored
    )
    unconverged = np.flatnonzero(residual > tolerance)
    if unconverged.size:
        remaining = Batch(
            frequency=batch.frequency[unconverged],
            truncated_frequency=batch.truncated_frequency[unconverged],
            frame=batch.frame[unconverged],
            error=batch.error[:, unconverged],
            force=batch.force[unconverged],
        )
        initial = Guess(y=y[unconverged], scale=scale[unconverged])
        y[unconverged], residual[unconverged], _, more = _batched(
            modal, kernel, remaining, right[unconverged], initial, tolerance=tolerance
        )
        calls += more
    return y, residual, scale, calls


def _inverse(modal: Modal, frequency: Array) -> tuple[Array, Array]:
    """1/D at frequencies (P, J) [rad/s], 0 for the mean of a rigid mode.

    Returns
    -------
    Factors of y, (P, 1, J, n), and of its rotated copy (-im, re), (P, 2, J, n) [s^2/rad^2].
    """
    w = frequency[:, :, None]
    real, imag = modal.squared - w**2, w * modal.damping
    size = real**2 + imag**2
    size[size == 0] = np.inf
    turn = imag / size
    return (real / size)[:, None], np.stack([turn, -turn], axis=1)


def _times(factor: tuple[Array, Array], y: Array) -> Array:
    """D^-1 y, factors of `_inverse` applied to y (P, 2, J, n)."""
    out = factor[0] * y
    out += factor[1] * y[:, ::-1]
    return out


def _gaps(modal: Modal, y: Array) -> Array:
    """Mesh gaps B^T q (m, P, 2 J) [m] of y (P, 2, J, n), errors left out."""
    P, _, J, n = y.shape
    return (modal.gaps @ y.reshape(-1, n).T).reshape(-1, P, 2 * J)


def _pull(modal: Modal, force: Array) -> Array:
    """Mesh forces (m, P, 2 J) [N] on the modal coordinates, (P, 2, J, n)."""
    m, P, J2 = force.shape
    return (force.reshape(m, -1).T @ modal.pulls).reshape(P, 2, J2 // 2, -1)


def _coupling(modal: Modal, kernel: Kernel, batch: Batch) -> Callable[[Array], Array]:
    """Operator of everything off the diagonal: varying mesh stiffness, G, Kg, Cskew and the off-diagonal dampers.

    Maps y (P, 2, J, n) to generalized forces of the same shape.
    """
    frame, (m, n) = batch.frame[:, None], modal.gaps.shape
    factors = {"G": frame * batch.frequency, "C": batch.frequency, "Kg": frame**2, "Cskew": frame}
    matrix = np.concatenate([modal.pulls, *modal.coupling.values()])
    P, J = batch.frequency.shape
    parts = np.empty((P, 2, J, len(matrix)))  # made once: the pages of a fresh one would cost as much as filling it

    def couple(y: Array) -> Array:
        """Off-diagonal forces of y, (P, 2, J, n)."""
        # one product of everything side by side: forces of the meshes, then y scaled, turned by i where a rate counts
        force = product(kernel, _gaps(modal, y))
        parts[..., :m] = force.reshape(m, P, 2, J).transpose(1, 2, 3, 0)
        for place, name in enumerate(modal.coupling):
            part, factor = parts[..., m + place * n : m + (place + 1) * n], factors[name][:, :, None]
            if name in ("G", "C"):
                np.multiply(y[:, 1], -factor, out=part[:, 0])
                np.multiply(y[:, 0], factor, out=part[:, 1])
            else:
                np.multiply(y, factor[:, None], out=part)
        result: Array = (parts.reshape(-1, len(matrix)) @ matrix).reshape(y.shape)
        return result

    return couple


def _right(system: System, modal: Modal, kernel: Kernel, batch: Batch, error: Array) -> Array:
    """Right-hand side (P, 2, J, n): external forces plus pulls^T (k(t) e + c e'), error e (m, P, 2 J) [m]."""
    P, J, n = batch.force.shape
    force = np.zeros((P, 2, J, n))
    driven = np.flatnonzero(batch.force.any(axis=(0, 2)))
    for part, values in enumerate((batch.force.real, batch.force.imag)):
        force[:, part, driven] = values[:, driven] @ modal.forces.T
    if not error.any():
        return force
    meshes = system.meshes
    pulled = meshes.stiffness[:, None, None] * error + product(kernel, error)
    if meshes.damping.any():
        rate = meshes.damping[:, None, None] * batch.frequency
        pulled[:, :, :J] -= rate * error[:, :, J:]
        pulled[:, :, J:] += rate * error[:, :, :J]
    result: Array = force + _pull(modal, pulled)
    return result


def _scale(first: Array, start: Array, *, mean: bool) -> Array:
    """Size of the dynamic part (P,): the first guess without its mean, and the first correction; never 0.

    first, start : (P, 2, J, n) and (P, 2 J n).  mean : whether harmonic 0 is a mean.
    """
    total = np.einsum("pcjn,pcjn->p", first, first)
    still = np.einsum("pn,pn->p", first[:, 0, 0], first[:, 0, 0]) if mean else 0.0
    dynamic = np.maximum(total - still, 0.0) + np.einsum("pn,pn->p", start, start)
    # a train with no excitation has no dynamic part; 1e-6 of the static one keeps the target above rounding
    scale: Array = np.sqrt(np.maximum(dynamic, 1e-12 * total))
    return np.where(scale == 0, 1.0, scale)


def _truncation_residual(modal: Modal, kernel: Kernel, batch: Batch, gap: Array) -> Array:
    """Size of the response to forces on the truncated harmonics, by kind, (P, D + 1): the exact residual beyond those
    kept.

    gap : (m, P, 2 J) [m].
    """
    if not len(kernel.truncated):
        return np.zeros((gap.shape[1], kernel.lattice.tones + 1))
    y = truncated_response(modal, kernel, batch.truncated_frequency, gap)
    squares = np.einsum("pcjn,pcjn->pj", y, y)
    kinds = np.arange(kernel.lattice.tones + 1)
    size: Array = np.sqrt(squares @ (kernel.truncated_kind[:, None] == kinds))
    return size


def truncated_response(modal: Modal, kernel: Kernel, truncated_frequency: Array, gap: Array) -> Array:
    """Uncoupled response to the mesh forces on the truncated harmonics, (P, 2, T, n).

    truncated_frequency : (P, T) [rad/s].  gap : (m, P, 2 J) [m].
    """
    return _times(_inverse(modal, truncated_frequency), _pull(modal, truncated_product(kernel, gap)))
