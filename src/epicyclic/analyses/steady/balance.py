"""Harmonic balance without forming a matrix: linear contact, any mesh frequencies, many speeds at once.

In energy-weighted modal coordinates every row of frequency w reads D y + coupling + pulls^T {(k(t) - k0) gap(t)} = b,
D = omega_r^2 - w^2 + i w d_r.  D^-1 is the preconditioner; products with k(t) are exact convolutions of the harmonics
(no aliasing, any number of them), applied as small matrices that all speeds share.

Layout: a batch of P points holds y as (P, 2, J, n): real and imaginary parts of J rows.  Rows are points a of a lattice
of the mesh frequencies f (a real signal, x = Re sum X_a exp(i a . w t), one of a and -a), or all points around a shaft
frequency w_s (x = Re[exp(i w_s t) sum Y_a exp(i a . w t)]), which is exact for any real w_s.  One mesh frequency is a
lattice of one axis, the orders 0..H or -H..H.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...system.system import Array, ComplexArray, System
from ..modes.basis import Modal
from .condensed import Shared
from .gmres import gmres
from .kernel import Kernel, product, tail

__all__ = ["Guess", "Rows", "Solved", "left_over", "solve"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rows:
    """A batch of P points.

    frequency : (P, J) angular frequency of every row; beyond : (P, T) of every row dropped [rad/s].
    frame : (P,) factor of G and Cskew, squared of Kg.
    error : (m, P, J) complex [m].  force : (P, J, n) complex [N].
    """

    frequency: Array
    beyond: Array
    frame: Array
    error: ComplexArray
    force: ComplexArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solved:
    """Solution of a batch.

    y : (P, 2, J, n).  gap : (m, P, 2 J) B^T q - e [m].  frequency : (P, J) [rad/s].
    residual : (P,) of the rows kept, dropped : (P, D + 1) of the rows dropped, by their kind; both relative to the
    dynamic part, whose size is scale (P,).
    """

    y: Array
    gap: Array
    frequency: Array
    residual: Array
    dropped: Array
    scale: Array
    calls: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Guess:
    """A solution with fewer rows to start from: y (P, 2, J, n) with zeros in the others, scale (P,) of `Solved`."""

    y: Array
    scale: Array


def solve(
    system: System,
    modal: Modal,
    kernel: Kernel,
    rows: Rows,
    *,
    tolerance: float,
    guess: Guess | None = None,
    shared: Shared | None = None,
) -> Solved:
    """Solve one batch; residuals are reported, never judged.

    Parameters
    ----------
    tolerance : residual wanted, relative to the dynamic part of the response in the energy norm [1].
    shared : what `touched` made of the same arguments: solve by numba, which must be there.
    """
    error = _split(rows.error)
    right = _right(system, modal, kernel, rows, error)
    if shared is None:
        y, residual, scale, calls = _batched(modal, kernel, rows, right, guess, tolerance=tolerance)
        gap = _gaps(modal, y) - error
        dropped = _dropped(modal, kernel, rows, gap)
    else:
        from .compiled_truncation import dropped_size

        y, residual, scale, calls = _side_by_side(modal, kernel, rows, right, guess, tolerance=tolerance, shared=shared)
        gap = _gaps(modal, y) - error
        dropped = np.outer(dropped_size(shared, rows.beyond, gap), [1.0, 0.0])
    return Solved(
        y=y,
        gap=gap,
        frequency=rows.frequency,
        residual=residual,
        dropped=dropped / scale[:, None],
        scale=scale,
        calls=calls,
    )


def _batched(
    modal: Modal, kernel: Kernel, rows: Rows, right: Array, guess: Guess | None, *, tolerance: float
) -> tuple[Array, Array, Array, int]:
    """All points at once: (y, residual and scale (P,), operator calls)."""
    inverse = _inverse(modal, rows.frequency)
    couple = _coupling(modal, kernel, rows)
    shape = right.shape

    def apply(x: Array) -> Array:
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
    rows: Rows,
    right: Array,
    guess: Guess | None,
    *,
    tolerance: float,
    shared: Shared,
) -> tuple[Array, Array, Array, int]:
    """As `_batched`, compiled; the points that single precision does not bring there go on in double."""
    from .compiled import solve_points

    start = None if guess is None else (guess.y, guess.scale)
    y, residual, scale, calls = solve_points(
        shared, rows.frequency, rows.frame, right, start=start, tolerance=tolerance, mean=kernel.lattice.mirrored
    )
    hard = np.flatnonzero(residual > tolerance)
    if hard.size:
        some = Rows(
            frequency=rows.frequency[hard],
            beyond=rows.beyond[hard],
            frame=rows.frame[hard],
            error=rows.error[:, hard],
            force=rows.force[hard],
        )
        known = Guess(y=y[hard], scale=scale[hard])
        y[hard], residual[hard], _, more = _batched(modal, kernel, some, right[hard], known, tolerance=tolerance)
        calls += more
    return y, residual, scale, calls


def _inverse(modal: Modal, frequency: Array) -> tuple[Array, Array]:
    """1/D as (P, 1, J, n) factors of y and of its rotated copy (-im, re); 0 for the mean of a rigid mode."""
    w = frequency[:, :, None]
    real, imag = modal.squared - w**2, w * modal.damping
    size = real**2 + imag**2
    size[size == 0] = np.inf
    turn = imag / size
    return (real / size)[:, None], np.stack([turn, -turn], axis=1)


def _times(factor: tuple[Array, Array], y: Array) -> Array:
    out = factor[0] * y
    out += factor[1] * y[:, ::-1]
    return out


def _gaps(modal: Modal, y: Array) -> Array:
    P, _, J, n = y.shape
    return (modal.gaps @ y.reshape(-1, n).T).reshape(-1, P, 2 * J)


def _pull(modal: Modal, force: Array) -> Array:
    """Mesh forces (m, P, 2 J) on the modal rows, (P, 2, J, n)."""
    m, P, J2 = force.shape
    return (force.reshape(m, -1).T @ modal.pulls).reshape(P, 2, J2 // 2, -1)


def _coupling(modal: Modal, kernel: Kernel, rows: Rows) -> Callable[[Array], Array]:
    """Everything off the diagonal: the varying part of the meshes, G, Kg, Cskew and the rest of the dampers."""
    frame, (m, n) = rows.frame[:, None], modal.gaps.shape
    factors = {"G": frame * rows.frequency, "C": rows.frequency, "Kg": frame**2, "Cskew": frame}
    matrix = np.concatenate([modal.pulls, *modal.coupling.values()])
    P, J = rows.frequency.shape
    parts = np.empty((P, 2, J, len(matrix)))  # made once: the pages of a fresh one would cost as much as filling it

    def couple(y: Array) -> Array:
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


def _right(system: System, modal: Modal, kernel: Kernel, rows: Rows, error: Array) -> Array:
    """External forces plus pulls^T (k(t) e + c e')."""
    P, J, n = rows.force.shape
    force = np.zeros((P, 2, J, n))
    driven = np.flatnonzero(rows.force.any(axis=(0, 2)))
    for part, values in enumerate((rows.force.real, rows.force.imag)):
        force[:, part, driven] = values[:, driven] @ modal.forces.T
    if not error.any():
        return force
    meshes = system.meshes
    pulled = meshes.stiffness[:, None, None] * error + product(kernel, error)
    if meshes.damping.any():
        rate = meshes.damping[:, None, None] * rows.frequency
        pulled[:, :, :J] -= rate * error[:, :, J:]
        pulled[:, :, J:] += rate * error[:, :, :J]
    result: Array = force + _pull(modal, pulled)
    return result


def _scale(first: Array, start: Array, *, mean: bool) -> Array:
    """Size of the dynamic part (P,): the first guess without its mean, and the first correction; never quite 0."""
    total = np.einsum("pcjn,pcjn->p", first, first)
    still = np.einsum("pn,pn->p", first[:, 0, 0], first[:, 0, 0]) if mean else 0.0
    dynamic = np.maximum(total - still, 0.0) + np.einsum("pn,pn->p", start, start)
    # a train with no excitation has no dynamic part; 1e-6 of the static one keeps the target above rounding
    scale: Array = np.sqrt(np.maximum(dynamic, 1e-12 * total))
    return np.where(scale == 0, 1.0, scale)


def _dropped(modal: Modal, kernel: Kernel, rows: Rows, gap: Array) -> Array:
    """Size of what the forces put on the rows dropped (P, D + 1), by kind: the exact residual beyond the rows kept."""
    if not len(kernel.dropped):
        return np.zeros((gap.shape[1], kernel.lattice.tones + 1))
    y = left_over(modal, kernel, rows.beyond, gap)
    squares = np.einsum("pcjn,pcjn->pj", y, y)
    kinds = np.arange(kernel.lattice.tones + 1)
    size: Array = np.sqrt(squares @ (kernel.kind[:, None] == kinds))
    return size


def left_over(modal: Modal, kernel: Kernel, beyond: Array, gap: Array) -> Array:
    """What the forces put on the rows dropped, as their response alone, (P, 2, T, n); beyond : (P, T) [rad/s]."""
    return _times(_inverse(modal, beyond), _pull(modal, tail(kernel, gap)))


def _split(rows: ComplexArray) -> Array:
    return np.concatenate([rows.real, rows.imag], axis=-1)
