"""Harmonic balance without forming a matrix: linear contact, one mesh frequency, many speeds at once.

In energy-weighted modal coordinates every row of frequency w reads D y + coupling + pulls^T {(k(t) - k0) gap(t)} = b,
D = omega_r^2 - w^2 + i w d_r.  D^-1 is the preconditioner; products with k(t) are exact convolutions of the harmonics
(no aliasing, any number of them), applied as one small matrix a mesh that all speeds share.

Layout: a batch of P points holds y as (P, 2, J, n): real and imaginary parts of J rows.  Rows are the mesh orders 0..H
(a real signal, x = Re sum X_h exp(i h w t)), or -H..H around a shaft frequency w_s
(x = Re[exp(i w_s t) sum Y_j exp(i j w t)]), which is exact for any real w_s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..system.system import Array, ComplexArray, System
from .basis import Modal
from .gmres import gmres

__all__ = ["Kernel", "Rows", "Solved", "envelope", "kernel", "solve"]

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Kernel:
    """Products with k_m(t) - k0_m for rows at given orders.

    orders : (J,) mesh orders of the rows; shifted : they stand around a shaft frequency.
    product : (m, 2 J, 2 J), tail : (m, 2 J, 2 T): gap rows (..., 2 J) @ them = rows of the force [N/m].
    dropped : (T,) orders the product reaches beyond the rows.
    """

    orders: Array
    shifted: bool
    product: Array
    tail: Array
    dropped: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rows:
    """A batch of P points.

    omega : (P,) angular mesh frequency [rad/s]; shift : (P,) angular shaft frequency, 0 at mesh orders.
    frame : (P,) factor of G and Cskew, squared of Kg.
    error : (m, P, J) complex [m].  force : (P, J, n) complex [N].
    """

    omega: Array
    shift: Array
    frame: Array
    error: ComplexArray
    force: ComplexArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solved:
    """Solution of a batch.

    y : (P, 2, J, n).  gap : (m, P, 2 J) B^T q - e [m].  frequency : (P, J) [rad/s].
    residual : (P,) of the rows kept, dropped : (P,) of the rows dropped, both relative to the dynamic part.
    """

    y: Array
    gap: Array
    frequency: Array
    residual: Array
    dropped: Array
    calls: int


def kernel(system: System, harmonics: int, *, shifted: bool) -> Kernel:
    """Convolution matrices for mesh orders 0..H, or -H..H where `shifted`."""
    meshes = system.meshes
    L = meshes.variation.shape[1]
    reach = 2 * harmonics + L
    half = meshes.stiffness[:, None] * meshes.variation / 2
    series = np.zeros((half.shape[0], 2 * reach + 1), complex)
    series[:, reach + 1 : reach + 1 + L] = half
    series[:, reach - L : reach] = half[:, ::-1].conj()
    upper = np.arange(harmonics + 1, harmonics + L + 1)
    rows = np.arange(-harmonics if shifted else 0, harmonics + 1)
    dropped = np.concatenate([-upper[::-1], upper]) if shifted else upper
    return Kernel(
        orders=rows.astype(float),
        shifted=shifted,
        product=_convolution(series, rows, rows, mirrored=not shifted),
        tail=_convolution(series, rows, dropped, mirrored=not shifted),
        dropped=dropped.astype(float),
    )


def _convolution(series: ComplexArray, given: Index, wanted: Index, *, mirrored: bool) -> Array:
    """Real form (m, 2 J_given, 2 J_wanted) of p_h = sum_j kappa_(h-j) d_j + kappa_(h+j) conj(d_j), kappa two-sided.

    Of a real signal (`mirrored`) row 0 is half of that and real.
    """
    centre = series.shape[1] // 2
    direct = series[:, centre + wanted[None, :] - given[:, None]]
    folded = series[:, centre + wanted[None, :] + given[:, None]] if mirrored else np.zeros_like(direct)
    real = np.concatenate([direct.real + folded.real, folded.imag - direct.imag], axis=1)
    imag = np.concatenate([direct.imag + folded.imag, direct.real - folded.real], axis=1)
    if mirrored:
        real[:, :, wanted == 0] /= 2
        imag[:, :, wanted == 0] = 0
        imag[:, given.size + np.flatnonzero(given == 0)] = real[:, given.size + np.flatnonzero(given == 0)] = 0
    return np.ascontiguousarray(np.concatenate([real, imag], axis=2))


def solve(system: System, modal: Modal, kernel: Kernel, rows: Rows, *, tolerance: float) -> Solved:
    """Solve one batch; residuals are reported, never judged.

    Parameters
    ----------
    tolerance : residual wanted, relative to the dynamic part of the response in the energy norm [1].
    """
    frequency = rows.shift[:, None] + rows.omega[:, None] * kernel.orders
    inverse = _inverse(modal, frequency)
    error = _split(rows.error)
    right = _right(system, modal, kernel, rows, frequency=frequency, error=error)
    couple = _coupling(modal, kernel, rows, frequency)
    shape = right.shape

    def apply(x: Array) -> Array:
        return x + _times(inverse, couple(x.reshape(shape))).reshape(x.shape)

    first = _times(inverse, right)
    start = -_times(inverse, couple(first)).reshape(shape[0], -1)
    scale = _scale(first, start, shifted=kernel.shifted)
    step, left, calls = gmres(apply, start, target=tolerance * scale)
    y = first + step.reshape(shape)
    gap = _gaps(modal, y) - error
    return Solved(
        y=y,
        gap=gap,
        frequency=frequency,
        residual=left / scale,
        dropped=_dropped(modal, kernel, rows, gap) / scale,
        calls=calls,
    )


def envelope(kernel: Kernel, rows: Array, theta: Array) -> Array:
    """Rows (..., 2 J) at mesh phases theta (Nt,): (..., Nt) of a real signal, (..., 2 Nt) re, im of a shifted one."""
    angle = 2 * np.pi * kernel.orders[:, None] * theta
    real = np.concatenate([np.cos(angle), -np.sin(angle)])
    wave = real if not kernel.shifted else np.hstack([real, np.concatenate([np.sin(angle), np.cos(angle)])])
    values: Array = rows @ wave
    return values


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


def _coupling(modal: Modal, kernel: Kernel, rows: Rows, frequency: Array) -> Callable[[Array], Array]:
    """Everything off the diagonal: the varying part of the meshes, G, Kg, Cskew and the rest of the dampers."""
    frame = rows.frame[:, None]
    still = np.ones_like(frequency)
    factors = {"G": frame * frequency, "C": frequency, "Kg": frame**2 * still, "Cskew": frame * still}
    terms = []
    for name, matrix in modal.coupling.items():
        rotates = name in ("G", "C")
        factor = factors[name][:, None, :, None]
        terms.append((matrix, np.concatenate([-factor, factor], axis=1) if rotates else factor, rotates))

    def couple(y: Array) -> Array:
        out = _pull(modal, np.matmul(_gaps(modal, y), kernel.product))
        for matrix, factor, rotates in terms:
            part = (y.reshape(-1, y.shape[3]) @ matrix).reshape(y.shape)
            out += factor * (part[:, ::-1] if rotates else part)
        return out

    return couple


def _right(system: System, modal: Modal, kernel: Kernel, rows: Rows, *, frequency: Array, error: Array) -> Array:
    """External forces plus pulls^T (k(t) e + c e')."""
    force = np.stack([rows.force.real, rows.force.imag], axis=1) @ modal.forces.T
    if not error.any():
        return force
    meshes = system.meshes
    pulled = meshes.stiffness[:, None, None] * error + np.matmul(error, kernel.product)
    if meshes.damping.any():
        rate = meshes.damping[:, None, None] * frequency
        J = frequency.shape[1]
        pulled[:, :, :J] -= rate * error[:, :, J:]
        pulled[:, :, J:] += rate * error[:, :, :J]
    result: Array = force + _pull(modal, pulled)
    return result


def _scale(first: Array, start: Array, *, shifted: bool) -> Array:
    """Size of the dynamic part (P,): the first guess without its mean, and the first correction; never quite 0."""
    total = np.einsum("pcjn,pcjn->p", first, first)
    mean = 0.0 if shifted else np.einsum("pn,pn->p", first[:, 0, 0], first[:, 0, 0])
    dynamic = np.maximum(total - mean, 0.0) + np.einsum("pn,pn->p", start, start)
    # a train with no excitation has no dynamic part; 1e-6 of the static one keeps the target above rounding
    scale: Array = np.sqrt(np.maximum(dynamic, 1e-12 * total))
    return np.where(scale == 0, 1.0, scale)


def _dropped(modal: Modal, kernel: Kernel, rows: Rows, gap: Array) -> Array:
    """Size of what the forces put on the rows dropped (P,): the exact residual beyond the last harmonic."""
    if not kernel.dropped.size:
        return np.zeros(gap.shape[1])
    frequency = rows.shift[:, None] + rows.omega[:, None] * kernel.dropped
    y = _times(_inverse(modal, frequency), _pull(modal, np.matmul(gap, kernel.tail)))
    size: Array = np.sqrt(np.einsum("pcjn,pcjn->p", y, y))
    return size


def _split(rows: ComplexArray) -> Array:
    return np.concatenate([rows.real, rows.imag], axis=-1)
