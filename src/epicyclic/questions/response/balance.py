"""Condensed operators of the compiled solver: frame and damper matrices on the few coordinates where they act.

A dense block of the balance: the coordinates near a resonance that mesh stiffness couples, solved together.

With two mesh frequencies hundreds of combinations lie near some natural frequency, each coupled to the next along the
axis of a tone.  D^-1 alone then leaves GMRES hundreds of outlying eigenvalues.  The block holds these coordinates with
their couplings by the varying mesh stiffness, factorised; all others keep D^-1.  Derived here.

Harmonic balance without forming a matrix: linear contact, any mesh frequencies, many speeds at once.

In energy-weighted modal coordinates every harmonic of frequency w reads D y + coupling + pulls^T {(k(t) - k0) gap(t)} =
b,
D = omega_r^2 - w^2 + i w d_r.  D^-1 is the preconditioner of GMRES [saad1986]; products with k(t) are exact
convolutions
of the harmonics (no aliasing), applied as small matrices that all speeds share.  Where GMRES stalls, `resonant_block`
preconditions it once more; where damping is light, `sharpness` says how well the answer is determined.  Derived here
from the equation of motion of docs/design.md; signs and phases are those of docs/conventions.md.

Layout: a batch of P points holds y as (P, 2, J, n): real and imaginary parts of J harmonics in n coordinates.
Harmonics are points a of a lattice of the mesh frequencies f (a real signal, x = Re sum X_a exp(i a . w t), one of a
and
-a), or all points around a shaft frequency w_s (x = Re[exp(i w_s t) sum Y_a exp(i a . w t)]), exact for any real w_s.
One mesh frequency is a lattice of one axis, the orders 0..H or -H..H.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray, System
from ..modes.basis import Modal
from .gmres import FLOOR, gmres, near_sharp_resonance, sharpened
from .lattice import Kernel, product, to_real, truncated_product

Index = NDArray[np.int64]


class CondensedOperators(NamedTuple):
    """Operators that all points of a batch share, of one mesh frequency.

    read : (m + r, n) gaps of the meshes, then the r coordinates condensed to, of y.  push : (n, m + r) forces there on
        y.
    own : (m, 2 J, 2 J) products with k(t) - k0, force = own @ gap [N/m].  tail : (m, 2 J, 2 T), gap @ tail = force.
    row, column : (e,) indices 0 .. m + r of entries.  stiff : (2, e) of Kg and Cskew.  rate : (2, e) of G and C.
    diagonal : (n,) modal diagonal of the dampers [1/s]: `damping` holds it, and the entries of C hold it again.
    squared [rad^2/s^2], damping [1/s] : (n,) of `Modal`.
    """

    read: Array
    push: Array
    own: Array
    tail: Array
    row: Index
    column: Index
    stiff: Array
    rate: Array
    diagonal: Array
    squared: Array
    damping: Array


class Workspace(NamedTuple):
    """Arrays for one group of speeds side by side, 8 lanes: H = 8 J, X = 2 H, K Krylov vectors.

    values, forces : (m + r, X).  work : (n, X).
    stiffness_factor : (2, H) frame^2 and frame, of Kg and Cskew.  rate_factor : (2, H) w frame and w, of G and C
        [rad/s].
    inverse : (2, n, H) 1/D.  vectors : (K + 1, n, X).  rows : (K, X).  triangle : (K, K, 8).  rotations : (2, K, 8).
    projected : (K + 1, 8) right side.  along : (K + 2, 8).  used : (8,) vectors of each lane.
    """

    values: Array
    forces: Array
    work: Array
    stiffness_factor: Array
    rate_factor: Array
    inverse: Array
    vectors: Array
    rows: Array
    triangle: Array
    rotations: Array
    projected: Array
    along: Array
    used: Index


def workspace(operators: CondensedOperators, J: int, *, lanes: int, basis: int) -> Workspace:
    """Workspace for J harmonics and `basis` Krylov vectors, in the precision of the operators."""
    (c, n), half, kind = operators.read.shape, J * lanes, operators.read.dtype
    return Workspace(
        values=np.empty((c, 2 * half), kind),
        forces=np.empty((c, 2 * half), kind),
        work=np.empty((n, 2 * half), kind),
        stiffness_factor=np.empty((2, half), kind),
        rate_factor=np.empty((2, half), kind),
        inverse=np.empty((2, n, half), kind),
        vectors=np.empty((basis + 1, n, 2 * half), kind),
        rows=np.empty((basis + 1, 2 * half), kind),
        triangle=np.empty((basis, basis, lanes)),
        rotations=np.empty((2, basis, lanes)),
        projected=np.empty((basis + 1, lanes)),
        along=np.empty((basis + 2, lanes)),
        used=np.empty(lanes, np.int64),
    )


def condensed_operators(system: System, modal: Modal, kernel: Kernel) -> CondensedOperators:
    """Condense G, Kg, Cskew and the dampers to the coordinates where they act, of one mesh frequency.

    Derived here: the modal operator of `balance` as read, entries and push; equal up to rounding.
    """
    m, rest = len(system.meshes.name), "C" in modal.coupling
    C = system.C if rest else np.zeros_like(system.C)
    matrices = (system.Kg, system.Cskew, system.G, C)
    acting = sum((matrix != 0 for matrix in matrices), np.zeros(C.shape, dtype=bool))
    where = np.flatnonzero(acting.any(axis=0) | acting.any(axis=1))
    row, column = np.nonzero(acting[np.ix_(where, where)])
    entries = np.array([matrix[where[row], where[column]] for matrix in matrices])
    if rest:
        # a mesh damper acts between its gap and its force
        entries = np.hstack([entries, np.array([0.0, 0.0, 0.0, 1.0])[:, None] * system.meshes.damping])
        row, column = (np.concatenate([at + m, np.arange(m)]) for at in (row, column))
    else:
        row, column = row + m, column + m
    omega = np.sqrt(modal.squared)
    return CondensedOperators(
        read=np.concatenate([modal.gaps, modal.shapes[where]]),
        push=np.concatenate([modal.pulls.T, modal.forces[:, where]], axis=1),
        own=np.ascontiguousarray(kernel.axes[0].own_product.swapaxes(1, 2)),
        tail=kernel.axes[0].own_tail,
        row=row,
        column=column,
        stiff=entries[:2],
        rate=entries[2:],
        diagonal=modal.damping - 2 * (system.zeta or 0.0) * omega if rest else np.zeros(omega.size),
        squared=modal.squared,
        damping=modal.damping,
    )


# Coordinates in the block: those that the variation moves by more than this part of themselves at once.  On two
# planetary stages (30 coordinates, 1273 lattice points) 0.3 takes 46 products where D^-1 alone takes 780; 0.1 takes 35
# with a block twice as large.
_GAIN = 0.3
# Coordinates at most, complex ones: factors of 72 MB, made in 2 s.
_MOST = 1500


def resonant_block(system: System, modal: Modal, kernel: Kernel, frequency: Array) -> Callable[[Array], Array] | None:
    """Preconditioner (1 + D^-1 coupling)^-1 on the resonant coordinates of one point, 1 on the others.

    frequency : (J,) of every harmonic [rad/s].

    Returns
    -------
    A function (1, 2 J n) -> (1, 2 J n) of the preconditioned rows of the balance; None where no coordinate is resonant.
    """
    waves = [_waves(system, modal, axis.meshes) for axis in kernel.axes]
    inverse = _receptance(modal, frequency)
    # the largest coupling of a coordinate to itself at another harmonic is what the next harmonic takes up
    size = np.sqrt(sum(np.max(np.abs(np.einsum("lrr->lr", wave)) ** 2, axis=0) for wave in waves))
    gain = size * np.abs(inverse)
    if kernel.lattice.mirrored:
        gain[0] = 0.0  # the mean is never resonant, and real
    order = np.argsort(-gain, axis=None, kind="stable")[:_MOST]
    order = order[gain.ravel()[order] > _GAIN]
    if not order.size:
        return None
    point, mode = np.unravel_index(order, gain.shape)
    near = inverse[point, mode][:, None]
    direct = near * _couplings(waves, kernel.lattice.points[point], mode, sign=1) + np.eye(order.size)
    folded = near * _couplings(waves, kernel.lattice.points[point], mode, sign=-1) * kernel.lattice.mirrored
    rows = np.block(
        [
            [direct.real + folded.real, folded.imag - direct.imag],
            [direct.imag + folded.imag, direct.real - folded.real],
        ]
    )
    factors = scipy.linalg.lu_factor(rows, overwrite_a=True)
    place = np.concatenate([order, frequency.size * len(modal.squared) + order])

    def solve(x: Array) -> Array:
        """The block solved, (1, 2 J n)."""
        out = x.copy()
        out[0, place] = scipy.linalg.lu_solve(factors, x[0, place])
        return out

    return solve


def _receptance(modal: Modal, frequency: Array) -> ComplexArray:
    """1/D at frequencies (J,) [rad/s], (J, n) [s^2/rad^2]; 0 where D is 0."""
    w = frequency[:, None]
    D = modal.squared - w**2 + 1j * w * modal.damping
    inverse: ComplexArray = np.divide(1.0, D, out=np.zeros_like(D), where=D != 0)
    return inverse


def _waves(system: System, modal: Modal, meshes: Index) -> ComplexArray:
    """Couplings of coordinates by each harmonic -L .. L of the stiffness of `meshes` (m_j,), (2 L + 1, n, n)."""
    half = system.meshes.stiffness[meshes, None] * system.meshes.variation[meshes] / 2
    series = np.concatenate([half[:, ::-1].conj(), np.zeros((len(meshes), 1)), half], axis=1)
    pulls, gaps = modal.pulls[meshes], modal.gaps[meshes]
    waves: ComplexArray = np.array([(pulls.T * wave) @ gaps for wave in series.T])
    return waves


def _couplings(waves: list[ComplexArray], points: Index, mode: Index, *, sign: int) -> ComplexArray:
    """Couplings (S, S) of coordinates at lattice points (S, D) in modes (S,), by the harmonics a - sign b.

    sign : 1, or -1 of a real signal, where the conjugate of b counts.
    """
    found = np.zeros((len(points), len(points)), complex)
    for axis, wave in enumerate(waves):
        reach = len(wave) // 2
        step = points[:, None, axis] - sign * points[None, :, axis]
        coupled = np.abs(step) <= reach
        for other in range(points.shape[1]):
            if other != axis:
                coupled &= points[:, None, other] == sign * points[None, :, other]
        a, b = np.nonzero(coupled)
        found[a, b] += wave[step[a, b] + reach, mode[a], mode[b]]
    return found


_TINY = 1e-300
# Cycles of GMRES with D^-1: a tone alone converges in one or two, with several tones the block takes over after two.
_RESTARTS, _FIRST = 6, 2


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
    uncertainty : (P,) bound of the relative error of y near a resonance of light damping, 0 elsewhere; empty: not made.
    truncated_force : (m, P, 2 T) of the meshes on the truncated harmonics [N]; None: not made.
    """

    y: Array
    gap: Array
    frequency: Array
    residual: Array
    truncation_residual: Array
    scale: Array
    calls: int
    uncertainty: Array = field(default_factory=lambda: np.zeros(0))
    truncated_force: Array | None = None


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
    start = None if guess is None else (guess.y, guess.scale)
    if operators is None:
        y, residual, scale, calls = _batched(system, modal, kernel, batch, right, start, tolerance=tolerance)
        y, residual, uncertainty = _judged(modal, kernel, batch, right, (y, residual, scale), tolerance=tolerance)
        gap = _gaps(modal, y) - error
        truncated_force = truncated_product(kernel, gap) if len(kernel.truncated) else None
        truncation_residual = _truncation_residual(modal, kernel, batch, truncated_force)
    else:
        from .compiled import truncation_size

        y, residual, scale, calls = _side_by_side(
            system, modal, kernel, batch, right, start, tolerance=tolerance, operators=operators
        )
        y, residual, uncertainty = _judged(modal, kernel, batch, right, (y, residual, scale), tolerance=tolerance)
        gap = _gaps(modal, y) - error
        truncated_force = None
        truncation_residual = np.outer(truncation_size(operators, batch.truncated_frequency, gap), [1.0, 0.0])
    return HarmonicSolution(
        y=y,
        gap=gap,
        frequency=batch.frequency,
        residual=residual,
        truncation_residual=truncation_residual / scale[:, None],
        scale=scale,
        calls=calls,
        uncertainty=uncertainty,
        truncated_force=truncated_force,
    )


def _batched(
    system: System,
    modal: Modal,
    kernel: Kernel,
    batch: Batch,
    right: Array,
    start: tuple[Array, Array] | None,
    *,
    tolerance: float,
) -> tuple[Array, Array, Array, int]:
    """All P points at once by NumPy; those where GMRES stalls once more, one by one, with a resonant block.

    start : solution to start from (P, 2, J, n) and its scale (P,); None starts from the diagonal alone.

    Returns
    -------
    (y (P, 2, J, n), residual (P,) relative to the scale, scale (P,), operator calls).
    """
    first, apply = _rows(modal, kernel, batch, right)
    P = len(first)
    if start is None:
        y = first
        step = apply(first, less=True)
        scale = _scale(first.reshape(right.shape), step, mean=kernel.lattice.mirrored)
    else:
        y, scale = start[0].reshape(P, -1), start[1]
        step = first - apply(y)
    several = kernel.lattice.tones > 1
    change, left, calls = gmres(apply, step, target=tolerance * scale, restarts=_FIRST if several else _RESTARTS)
    y = y + change
    stalled = np.isfinite(left) & (left > tolerance * scale) & several
    for p in np.flatnonzero(stalled).tolist():
        again = resonant_block(system, modal, kernel, batch.frequency[p])
        if again is not None:
            mine, rows = _rows(modal, kernel, _points(batch, [p]), right[[p]])
            target = tolerance * scale[[p]]
            more, rest, used = gmres(lambda x: rows(again(x)), mine - rows(y[[p]]), target=target)  # noqa: B023
            calls += used
            if rest[0] < left[p]:
                y[p], left[p] = y[p] + again(more)[0], rest[0]
    return y.reshape(right.shape), left / scale, scale, calls


def _judged(
    modal: Modal,
    kernel: Kernel,
    batch: Batch,
    right: Array,
    solved: tuple[Array, Array, Array],
    *,
    tolerance: float,
) -> tuple[Array, Array, Array]:
    """Solution (P, 2, J, n), residual (P,) and uncertainty (P,), points near a resonance of light damping refined.

    solved : y, residual and scale.
    """
    y, residual, scale = solved
    uncertainty = np.zeros(len(y))
    for p in np.flatnonzero(near_sharp_resonance(modal, batch.frequency) & np.isfinite(residual)).tolist():
        mine, rows = _rows(modal, kernel, _points(batch, [p]), right[[p]])
        found, left, uncertainty[p] = sharpened(
            modal, rows, mine, y[[p]], batch.frequency[p], mean=kernel.lattice.mirrored, tolerance=tolerance
        )
        y[p], residual[p] = found[0], left / scale[p]
    return y, residual, uncertainty


def _rows(modal: Modal, kernel: Kernel, batch: Batch, right: Array) -> tuple[Array, Callable[..., Array]]:
    """Rows of the balance preconditioned by P, D or its floor: P^-1 right (P, 2 J n) and P^-1 (D + coupling)."""
    kept = _kept(modal, batch.frequency)
    inverse = _inverse(modal, batch.frequency, kept)
    couple, shape = _coupling(modal, kernel, batch), right.shape
    # D / P is 1 but where D is below its floor
    part = 1.0 if kept is None else np.repeat(kept[:, None], 2, axis=1).reshape(shape[0], -1)

    def apply(x: Array, *, less: bool = False) -> Array:
        """P^-1 (D + coupling) x, (P, 2 J n); less : x less that, without the rounding of their difference."""
        coupled = _times(inverse, couple(x.reshape(shape))).reshape(x.shape)
        result: Array = (1.0 - part) * x - coupled if less else part * x + coupled
        return result

    return _times(inverse, right).reshape(shape[0], -1), apply


def _points(batch: Batch, which: Index | list[int]) -> Batch:
    """Some points of a batch."""
    return Batch(
        frequency=batch.frequency[which],
        truncated_frequency=batch.truncated_frequency[which],
        frame=batch.frame[which],
        error=batch.error[:, which],
        force=batch.force[which],
    )


def _side_by_side(
    system: System,
    modal: Modal,
    kernel: Kernel,
    batch: Batch,
    right: Array,
    start: tuple[Array, Array] | None,
    *,
    tolerance: float,
    operators: CondensedOperators,
) -> tuple[Array, Array, Array, int]:
    """As `_batched`, compiled; points above the tolerance after single precision go on in double precision by NumPy.

    So do points with a D below its floor, from the start: compiled, D has none.
    """
    from .compiled import solve_points

    y, residual, scale, calls = solve_points(
        operators, batch.frequency, batch.frame, right, start=start, tolerance=tolerance, mean=kernel.lattice.mirrored
    )
    kept = _kept(modal, batch.frequency)
    floored = np.zeros(len(y), dtype=bool) if kept is None else np.any(kept < 1, axis=(1, 2))
    for which in (np.flatnonzero(floored), np.flatnonzero(~floored & (residual > tolerance))):
        if which.size:
            given = start if floored[which[0]] else (y, scale)
            initial = None if given is None else (given[0][which], given[1][which])
            y[which], residual[which], scale[which], more = _batched(
                system, modal, kernel, _points(batch, which), right[which], initial, tolerance=tolerance
            )
            calls += more
    return y, residual, scale, calls


def _kept(modal: Modal, frequency: Array) -> Array | None:
    """|D| / P at frequencies (P, J) [rad/s], (P, J, n): 1 but where D is below its floor; None where it nowhere is."""
    w = frequency[:, :, None]
    real, imag, floor = modal.squared - w**2, w * modal.damping, FLOOR * modal.squared
    if not np.any(real**2 + imag**2 < (2 * floor) ** 2):
        return None
    size = np.hypot(real, imag)
    low = size < floor
    return np.where(low, size / np.where(low, floor, 1.0), 1.0) if np.any(low) else None


def _inverse(modal: Modal, frequency: Array, kept: Array | None = None) -> tuple[Array, Array]:
    """1/P at frequencies (P, J) [rad/s], 0 for the mean of a rigid mode.

    kept : |D| / P of `_kept`; None: P = D.

    Returns
    -------
    Factors of y, (P, 1, J, n), and of its rotated copy (-im, re), (P, 2, J, n) [s^2/rad^2].
    """
    w = frequency[:, :, None]
    real, imag = modal.squared - w**2, w * modal.damping
    size = real**2 + imag**2
    size[size == 0] = np.inf
    along, turn = real / size, imag / size
    if kept is not None:
        along, turn = np.where(kept > 0, along * kept, 1 / np.maximum(FLOOR * modal.squared, _TINY)), turn * kept
    return along[:, None], np.stack([turn, -turn], axis=1)


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
    frame, n, names = batch.frame[:, None], modal.squared.size, list(modal.coupling)
    factors = {"G": frame * batch.frequency, "C": batch.frequency, "Kg": frame**2, "Cskew": frame}
    gaps, pulls = modal.gaps[kernel.distinct], modal.pulls[kernel.distinct]
    matrix = np.concatenate(list(modal.coupling.values())) if names else np.zeros((0, n))
    P, J = batch.frequency.shape
    parts = np.empty((P, 2, J, len(matrix)))  # made once: the pages of a fresh one would cost as much as filling it

    def couple(y: Array) -> Array:
        """Off-diagonal forces of y, (P, 2, J, n)."""
        gap = (gaps @ y.reshape(-1, n).T).reshape(-1, P, 2 * J)
        force = product(kernel, gap, joined=True)
        result: Array = force.reshape(len(force), -1).T @ pulls
        # one product of everything side by side: y scaled, turned by i where a rate counts
        for place, name in enumerate(names):
            part, factor = parts[..., place * n : (place + 1) * n], factors[name][:, :, None]
            if name in ("G", "C"):
                np.multiply(y[:, 1], -factor, out=part[:, 0])
                np.multiply(y[:, 0], factor, out=part[:, 1])
            else:
                np.multiply(y, factor[:, None], out=part)
        if names:
            result += parts.reshape(-1, len(matrix)) @ matrix
        return result.reshape(y.shape)

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


def _truncation_residual(modal: Modal, kernel: Kernel, batch: Batch, force: Array | None) -> Array:
    """Size of the response to forces on the truncated harmonics, by kind, (P, D + 1): the exact residual beyond those
    kept.

    force : (m, P, 2 T) of the meshes on them [N]; None where there are none.
    """
    if force is None:
        return np.zeros((len(batch.frequency), kernel.lattice.tones + 1))
    # |y| = |force| / |D|: both parts of y need not be told apart
    w, pulled = batch.truncated_frequency[:, :, None], _pull(modal, force)
    held = (modal.squared - w**2) ** 2 + (w * modal.damping) ** 2
    held[held == 0] = np.inf
    squares = ((pulled[:, 0] ** 2 + pulled[:, 1] ** 2) / held).sum(axis=2)
    kinds = np.arange(kernel.lattice.tones + 1)
    size: Array = np.sqrt(squares @ (kernel.truncated_kind[:, None] == kinds))
    return size


def truncated_response(modal: Modal, kernel: Kernel, truncated_frequency: Array, gap: Array) -> Array:
    """Uncoupled response to the mesh forces on the truncated harmonics, (P, 2, T, n).

    truncated_frequency : (P, T) [rad/s].  gap : (m, P, 2 J) [m].
    """
    return _times(_inverse(modal, truncated_frequency), _pull(modal, truncated_product(kernel, gap)))
