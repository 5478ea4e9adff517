"""Preconditioner of the balance where links pass a body: the system solved at each phase of their tone, held still.

Along the axis of that tone the varying stiffness is a product with K(phi) at every phase phi.  Where the tone is slow
beside the others the points of a line of the lattice have nearly one frequency w, so that

    x(phi) = (K(phi) + i w C + .. - w^2 M)^-1 f(phi)

solves the whole line: a transform, one matrix a phase, and a transform back.  The shift of the frequencies along the
line is what GMRES has left to do.  It is also well conditioned where the links are stiff beside what they hold, where
the mean stiffness is none of any instant.  Derived here.

Harmonic balance without forming a matrix: linear contact, any mesh frequencies, many speeds at once; by GMRES.

In energy-weighted modal coordinates every harmonic of frequency w reads
D y + coupling + pulls^T {(k(t) - k0) gap(t)} = b, D = omega_r^2 - w^2 + i w d_r.  D^-1 is the preconditioner of GMRES
[saad1986]; products with k(t) are exact convolutions of the harmonics (no aliasing), applied as small matrices that all
speeds share.  Where GMRES stalls, `resonant_block`
preconditions it once more; where damping is light, `sharpened` says how well the answer is determined.  Derived here
from the equation of motion of docs/design.md; signs and phases are those of docs/conventions.md.

Layout: a batch of P points holds y as (P, 2, J, n): real and imaginary parts of J harmonics in n coordinates.
Harmonics are points a of a lattice of the mesh frequencies f (a real signal, x = Re sum X_a exp(i a . w t), one of a
and -a), or all points around a shaft frequency w_s (x = Re[exp(i w_s t) sum Y_a exp(i a . w t)]), exact for any real
w_s.  One mesh frequency is a lattice of one axis, the orders 0..H or -H..H.

The resonant block is dense: the coordinates near a resonance that mesh stiffness couples, solved together.  With two
mesh frequencies hundreds of combinations lie near some natural frequency, each coupled to the next along the axis of a
tone; D^-1 alone then leaves GMRES hundreds of outlying eigenvalues.  The block holds these coordinates with their
couplings by the varying mesh stiffness, factorised; all others keep D^-1.  Derived here.

Many linear systems are solved at once: one array, one operator call an iteration.

A residual r of the balance A y = b is an error A^-1 r, which a sharp resonance amplifies.  The amplification is found
by solving for a unit force on the coordinates that are near resonance.  Besides r, double precision itself perturbs A:
a natural frequency is known to about eps max(omega^2), so that a resonance narrower than that has no number.
Derived here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ...system.system import Array, ComplexArray, Index, System, VaryingRows
from ..modes.eigen import Modal
from .lattice import Kernel, bundle, product, stiffness_series, to_complex, to_real, truncated_product

# Matrices of all lines and phases at most [complex numbers]: half a gigabyte.
_MOST_SOLVED = 30_000_000


def phase_block(
    system: System, modal: Modal, kernel: Kernel, frequency: Array, frame: float
) -> Callable[[Array], Array]:
    """Preconditioner (1 + D^-1 coupling)^-1 of one point by the phases of the tone of links that pass a body.

    frequency : (J,) of every harmonic [rad/s].  frame : factor of G and Cskew, squared of Kg.

    Returns
    -------
    A function (1, 2 J n) -> (1, 2 J n) of the preconditioned rows of the balance.
    """
    axis = next(j for j, one in enumerate(kernel.axes) if one.meshes.size and one.meshes[0] >= len(system.meshes.name))
    take, sign, centre = _lines(kernel, axis, frequency)
    J, n, (count, width) = frequency.size, modal.squared.size, take.shape
    lines = min(count, max(1, _MOST_SOLVED // (width * n * n)))
    inverse = _inverses(system, modal, kernel.axes[axis].meshes, centre[:lines], width, frame)
    turn = np.exp(2j * np.pi * np.outer(np.arange(width), np.arange(width) - width // 2) / width)
    kept, at = take[:lines] < J, take[:lines]
    D = modal.squared - frequency[:, None] ** 2 + 1j * frequency[:, None] * modal.damping
    D[:, modal.rigid] = 1.0

    def solve(x: Array) -> Array:
        """All lines solved phase by phase, (1, 2 J n)."""
        parts = x.reshape(2, J, n)
        value = np.concatenate([(parts[0] + 1j * parts[1]) * D, np.zeros((1, n))])
        line = value[at]
        np.conjugate(line, out=line, where=(sign[:lines] < 0)[:, :, None])
        if kernel.lattice.mirrored:
            line[0, width // 2] *= 2.0  # the mean, beside the halves of both sides
        solved = np.matmul(inverse, (turn @ line)[..., None])[..., 0]
        line = (turn.conj().T / width) @ solved
        np.conjugate(line, out=line, where=(sign[:lines] < 0)[:, :, None])
        if kernel.lattice.mirrored:
            line[0, width // 2] = line[0, width // 2].real / 2
        out = parts[0] + 1j * parts[1]
        out[at[kept]] = line[kept]
        return np.stack([out.real, out.imag]).reshape(1, -1)

    return solve


def _lines(kernel: Kernel, axis: int, frequency: Array) -> tuple[Index, Index, Array]:
    """Points (lines, W) along an axis, J where none is kept, their signs, and the frequency at order 0 [rad/s]."""
    lattice, several = kernel.lattice, bundle(kernel.lattice, axis)
    J, own = len(lattice.points), lattice.own[axis]
    if lattice.mirrored:
        own = np.concatenate([own[:0:-1], own])
    reach, wide = own.size // 2, several.take.shape[1] // 2
    half = max(reach, wide)
    take = np.full((1 + several.several, 2 * half + 1), J, dtype=np.int64)
    sign = np.ones_like(take)
    take[0, half - reach : half + reach + 1] = own
    sign[0, :half] = -1 if lattice.mirrored else 1
    take[1:, half - wide : half + wide + 1] = several.take[: several.several]
    sign[1:, half - wide : half + wide + 1] = several.mirror[: several.several]
    first = np.argmax(take < J, axis=1)
    row, step = np.arange(len(take)), frequency[own[-1]] - frequency[own[-2]]
    centre = sign[row, first] * frequency[take[row, first]] - (first - half) * step
    return take, sign, centre


def _inverses(system: System, modal: Modal, rows: Index, centre: Array, width: int, frame: float) -> ComplexArray:
    """(lines, W, n, n) inverses at each phase of the tone and the frequencies (lines,) of order 0 [rad/s].

    Rigid modes stay apart: what they do hangs on the frequency alone.
    """
    varying = system.varying
    L = varying.wave.shape[1]
    series, phase = stiffness_series(varying, rows, L, reach=L), 2j * np.pi * np.arange(width) / width
    change = (series @ np.exp(np.outer(np.arange(-L, L + 1), phase))).real
    pulls, gaps = modal.pulls[rows], modal.gaps[rows]
    stiffness = np.einsum("rn,rp,rm->pnm", pulls, change, gaps, optimize=True)
    stiffness += np.diag(modal.squared)
    rate = np.diag(modal.damping).astype(float)
    for name, factor, target in (
        ("G", frame, rate),
        ("C", 1.0, rate),
        ("Kg", frame**2, stiffness),
        ("Cskew", frame, stiffness),
    ):
        if name in modal.coupling:
            target += factor * modal.coupling[name].T
    apart = modal.rigid | modal.rigid[:, None]
    made = np.empty((len(centre), width, *rate.shape), complex)
    for line, w in zip(made, centre.tolist(), strict=True):
        matrix = np.where(apart, np.eye(len(rate)), stiffness + 1j * w * rate - w**2 * np.eye(len(rate)))
        line[:] = np.linalg.inv(matrix)
    return made


_TINY = 1e-300
# Least |D| of the preconditioner, per omega_r^2.  At a resonance of the mean system without damping D is 0 although the
# varying stiffness and the gyroscopic terms leave the system regular: 1/D would make the right side, and with it the
# scale of residuals, as large as one likes.  D stays above this from a damping ratio of 5e-5 on.
FLOOR = 1e-4
# Damping ratio below which a resonance is asked: above, it amplifies a residual less than 5000 times, and the
# tolerances hold.
_LIGHT = 1e-4
# Distance from a natural frequency, of omega^2, below which a harmonic may be resonant: gyroscopic and varying terms
# shift the resonances of the mean system by a few per cent.
_NEAR = 0.1
# Residual of the solution for the amplification: its size is wanted, not its digits.
_PROBE = 1e-2
# Refinements at most; each gains at least three digits or none.
_ROUNDS = 3
# Vectors before a restart, and where links pass a body, of which shorter cycles stall.
_BASIS, _LONG = 60, 200


def gmres(
    apply: Callable[[Array], Array],
    right: Array,
    *,
    target: Array,
    basis: int = _BASIS,
    restarts: int = 6,
    checked: bool = True,
) -> tuple[Array, Array, int]:
    """Solve A_p x_p = b_p for every p, from x = 0, until |b_p - A_p x_p| <= target_p, by restarted GMRES [saad1986].

    Parameters
    ----------
    apply : (P, N) -> (P, N), the operator of every system; it must not mix systems.
    right : (P, N).  target : (P,) absolute residual wanted, in the unit of `right`.
    basis : vectors before a restart.  restarts : largest number of cycles.
    checked : False takes the residual from the Arnoldi relation, for targets of a few digits: an operator call less.

    Returns
    -------
    (x (P, N), true residual norm (P,), of the relation where that is not checked, operator calls).  A system whose
    numbers are not finite ends with a residual that is not finite and leaves the others unchanged.
    """
    x = np.zeros_like(right)
    residual, norm = right, _norm(right)
    calls = 0
    for _ in range(restarts):
        if not (norm > target).any():
            break
        step, rest, used = _cycle(apply, residual, norm, target=target, basis=basis)
        trial = x + step
        if not checked and (rest <= target).all():
            return trial, rest, calls + used
        left = right - apply(trial)
        calls += used + 1
        last, new = norm, _norm(left)
        # a singular system may come out worse than it went in: keep what it had (not finite is kept, to be seen)
        worse = (new >= last)[:, None]
        x, residual, norm = np.where(worse, x, trial), np.where(worse, residual, left), np.where(new >= last, last, new)
        if not ((norm > target) & (norm < 0.9 * last)).any():
            break
    return x, norm, calls


def _cycle(
    apply: Callable[[Array], Array], residual: Array, norm: Array, *, target: Array, basis: int
) -> tuple[Array, Array, int]:
    """One Arnoldi cycle with classical Gram-Schmidt from a residual (P, N) of given norm (P,).

    Of the vector n with n H = 0, n_1 = 1, the least residual is norm / |n| (derived here).  Returns (step (P, N), its
    residual norm (P,) by the Arnoldi relation, vectors used).
    """
    P, N = residual.shape
    V = np.empty((basis + 1, P, N), residual.dtype)
    V[0] = residual / np.maximum(norm, _TINY)[:, None]
    H, null, square = np.zeros((P, basis + 1, basis)), np.ones((P, basis + 1)), np.ones(P)
    with np.errstate(over="ignore", invalid="ignore"):  # where the vectors of a system end, its residual is zero
        for k in range(basis):
            known, w = V[: k + 1].transpose(1, 0, 2), apply(V[k])
            along = np.matmul(known, w[:, :, None])[:, :, 0]
            w = w - np.matmul(along[:, None, :], known)[:, 0]
            left = np.maximum(_norm(w), _TINY)
            V[k + 1] = w / left[:, None]
            H[:, : k + 1, k], H[:, k + 1, k] = along, left
            null[:, k + 1] = last = np.einsum("pi,pi->p", null[:, : k + 1], along) / -left
            square += last * last
            if not (norm > 0.5 * target * np.sqrt(square)).any():
                break
    Q, R = np.linalg.qr(H[:, : k + 2, : k + 1])
    R += np.eye(k + 1) * (R == 0)
    y = np.linalg.solve(R, norm[:, None, None] * Q[:, :1].transpose(0, 2, 1))
    step: Array = np.matmul(y.transpose(0, 2, 1).astype(V.dtype), V[: k + 1].transpose(1, 0, 2))[:, 0]
    rest = -np.matmul(H[:, : k + 2, : k + 1], y)[:, :, 0]
    rest[:, 0] += norm
    return step, _norm(rest), k + 1


def _norm(x: Array) -> Array:
    """Euclidean norm of every row, (P, N) to (P,)."""
    return np.asarray(np.sqrt(np.einsum("pn,pn->p", x, x)))


def near_sharp_resonance(modal: Modal, frequency: Array) -> NDArray[np.bool_]:
    """Points (P,) with a harmonic near the natural frequency of a mode of light damping.

    frequency : (P, J) [rad/s].
    """
    light = _lightly_damped(modal)
    if not np.any(light):
        return np.zeros(len(frequency), dtype=bool)
    squared = modal.squared[light]
    return np.asarray(np.any(np.abs(squared - frequency[:, :, None] ** 2) < _NEAR * squared, axis=(1, 2)))


def sharpened(
    modal: Modal,
    rows: Callable[[Array], Array],
    right: Array,
    y: Array,
    frequency: Array,
    *,
    mean: bool,
    tolerance: float,
) -> tuple[Array, float, float]:
    """Solution of one point refined until its error is below the tolerance, or as far as double precision goes.

    Parameters
    ----------
    rows : (1, 2 J n) -> (1, 2 J n), the preconditioned operator.  right : (1, 2 J n), its right side.
    y : (1, 2, J, n) solution so far.  frequency : (J,) [rad/s].  mean : whether harmonic 0 is a mean.
    tolerance : error wanted, relative to the dynamic part [1].

    Returns
    -------
    (y (1, 2, J, n), norm of its residual, bound of its relative error; inf where the resonance cannot be resolved).
    """
    shape, y = y.shape, y.reshape(1, -1)
    amplification, noise = _amplification(modal, rows, frequency)
    dynamic, left = 1.0, np.inf
    for _ in range(_ROUNDS + 1):
        residual = right - rows(y)
        left = float(np.linalg.norm(residual))
        moving = y.reshape(shape)[:, :, 1:] if mean else y
        dynamic = float(np.linalg.norm(moving)) or 1.0
        wanted = tolerance * dynamic / amplification
        if left <= wanted or not np.isfinite(amplification):
            break
        step, rest, _ = gmres(rows, residual, target=np.array([0.5 * wanted]))
        if not rest[0] < left:
            break
        y = y + step
    error = amplification * (left / dynamic + noise)
    return y.reshape(shape), left, error if np.isfinite(error) else np.inf


def _amplification(modal: Modal, rows: Callable[[Array], Array], frequency: Array) -> tuple[float, float]:
    """Largest error per residual [1], and the part of y that rounding of natural frequencies leaves as a residual [1].

    inf where the resonance is narrower than rounding.
    """
    distance = np.abs(modal.squared - frequency[:, None] ** 2)
    near = (distance < _NEAR * modal.squared) & _lightly_damped(modal)
    # the signs are fixed and without pattern, so that the unit forces do not cancel along a resonant motion
    signs = np.random.default_rng(1).choice([-1.0, 1.0], size=(2, *near.shape))
    force = np.where(near, signs, 0.0).reshape(1, -1)
    answer, left, _ = gmres(rows, force, target=np.array([_PROBE]))
    # rounding of omega^2 against the least that P, floored, can be
    least = np.min(np.where(near, np.maximum(distance, FLOOR * modal.squared), np.inf))
    noise = np.finfo(float).eps * float(modal.squared.max(initial=0.0)) / float(least)
    if not left[0] <= _PROBE:
        return np.inf, noise
    return max(1.0, float(np.linalg.norm(answer))), noise


def _lightly_damped(modal: Modal) -> NDArray[np.bool_]:
    """Elastic modes (n,) whose damping ratio is so small that their resonance is asked."""
    return (modal.damping**2 < 4 * _LIGHT**2 * modal.squared) & ~modal.rigid


# Products with D^-1 alone, where tones are several, before the block takes over.
_TRIAL = 16
# Coordinates in the block: those that the variation moves by more than this part of themselves at once.  On a planetary
# and a helical stage (53 coordinates, 1285 lattice points) 0.3 takes 94 to 132 products, 0.2 takes 61 to 78 with blocks
# up to twice as large.
_GAIN = 0.2
# Coordinates at most, complex ones: factors of 36 or, of a real signal, 72 MB.
_MOST = 1500


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
    residual : (P,) of the harmonics kept.  truncation_residual : (P, D + 1) of the truncated ones, by their kind.
    Both are relative to the dynamic part, whose size is scale (P,).  calls : of the operator.
    uncertainty : (P,) bound of the relative error of y near a resonance of light damping, 0 elsewhere.
    truncated_force : (m, P, 2 T) of the meshes on the truncated harmonics [N]; None: not made.
    """

    y: Array
    gap: Array
    frequency: Array
    residual: Array
    truncation_residual: Array
    scale: Array
    calls: int
    uncertainty: Array
    truncated_force: Array | None = None


Record = TypeVar("Record", Batch, HarmonicSolution)


def at_points(record: Record, points: NDArray[np.bool_] | list[int]) -> Record:
    """Some of the P points of a batch or of its solution; arrays of meshes have these in front."""
    values: dict[str, Any] = {one.name: getattr(record, one.name) for one in fields(record)}
    of_meshes = ("error", "gap", "truncated_force")
    some: dict[str, Any] = {
        name: value[:, points] if name in of_meshes else value[points]
        for name, value in values.items()
        if isinstance(value, np.ndarray)
    }
    return replace(record, **some)


Guess = tuple[Array, Array]
"""Initial guess of a solution with fewer harmonics: y (P, 2, J, n), zero in those that are new, and its scale (P,)."""


class _Balance(NamedTuple):
    """Rows (D + coupling) y = right of a batch of P points, right (P, 2, J, n).

    tolerance : residual wanted, relative to the dynamic part of the response in the energy norm [1].
    """

    system: System
    modal: Modal
    kernel: Kernel
    batch: Batch
    right: Array
    tolerance: float

    def of(self, points: list[int]) -> _Balance:
        """Some of the points."""
        return self._replace(batch=at_points(self.batch, points), right=self.right[points])

    def preconditioned(self) -> tuple[Array, Callable[..., Array]]:
        """Rows preconditioned by P, D or its floor: P^-1 right (P, 2 J n) and P^-1 (D + coupling)."""
        kept = _kept(self.modal, self.batch.frequency)
        inverse = diagonal_inverse(self.modal, self.batch.frequency, kept)
        couple, shape = _coupling(self.modal, self.kernel, self.batch), self.right.shape
        # D / P is 1 but where D is below its floor
        share = 1.0 if kept is None else np.repeat(kept[:, None], 2, axis=1).reshape(shape[0], -1)

        def apply(x: Array, *, less: bool = False) -> Array:
            """P^-1 (D + coupling) x, (P, 2 J n); less : x less that, without the rounding of their difference."""
            coupled = diagonal_product(inverse, couple(x.reshape(shape))).reshape(x.shape)
            return (1.0 - share) * x - coupled if less else share * x + coupled

        return diagonal_product(inverse, self.right).reshape(shape[0], -1), apply


def solve(
    system: System,
    modal: Modal,
    kernel: Kernel,
    batch: Batch,
    *,
    tolerance: float,
    guess: Guess | None = None,
) -> HarmonicSolution:
    """Solve one batch of P points; residuals are returned, not tested.

    Parameters
    ----------
    tolerance : residual wanted, relative to the dynamic part of the response in the energy norm [1].
    """
    error = to_real(batch.error)
    right = _right(system, modal, kernel, batch, error)
    balance = _Balance(system, modal, kernel, batch, right, tolerance)
    y, residual, scale, calls = _batched(balance, guess)
    uncertainty = _sharpen(balance, y, residual, scale)
    P, _, J, n = y.shape
    m, gap = len(error), (modal.gaps @ y.reshape(-1, n).T).reshape(-1, P, 2 * J)
    gap[:m] -= error
    # without errors sums of rows tell how large the response to them is; the last solution alone needs the force of all
    whole = bool(error.any()) or kernel.joined is kernel.axes
    rows = slice(None) if whole else kernel.distinct
    truncated_force = truncated_product(kernel, gap[rows], joined=not whole) if len(kernel.truncated) else None
    truncation_residual = _truncation_residual(modal.pulls[rows], modal, kernel, batch, truncated_force)
    return HarmonicSolution(
        y=y,
        gap=gap[:m],
        frequency=batch.frequency,
        residual=residual,
        truncation_residual=truncation_residual / scale[:, None],
        scale=scale,
        calls=calls,
        uncertainty=uncertainty,
        truncated_force=truncated_force[:m] if whole and truncated_force is not None else None,
    )


def _batched(balance: _Balance, start: Guess | None) -> tuple[Array, Array, Array, int]:
    """All P points at once by NumPy; those where GMRES stalls once more, one by one, with a resonant block.

    start : None starts from the diagonal alone.

    Returns
    -------
    (y (P, 2, J, n), residual (P,) relative to the scale, scale (P,), operator calls).
    """
    first, apply = balance.preconditioned()
    shape, lattice, tolerance = balance.right.shape, balance.kernel.lattice, balance.tolerance
    if start is None:
        y = first
        step = apply(first, less=True)
        scale = _scale(first.reshape(shape), step, mean=lattice.mirrored)
    else:
        y, scale = start[0].reshape(len(first), -1), start[1]
        step = first - apply(y)
    several = lattice.tones > 1
    trial = partial(gmres, basis=_TRIAL, restarts=1) if several else gmres
    change, left, calls = trial(apply, step, target=tolerance * scale)
    y = y + change
    stalled = np.isfinite(left) & (left > tolerance * scale) & several
    for p in np.flatnonzero(stalled).tolist():
        right, rows = balance.of([p]).preconditioned()
        target = tolerance * scale[[p]]
        block, basis = _block(balance, p, rows)
        step = right - rows(y[[p]])
        more, rest, used = gmres(lambda x: rows(block(x)), step, target=target, basis=basis)  # noqa: B023
        calls += used
        if rest[0] < left[p]:
            y[p], left[p] = y[p] + block(more)[0], rest[0]
    return y.reshape(shape), left / scale, scale, calls


def _block(balance: _Balance, p: int, rows: Callable[[Array], Array]) -> tuple[Callable[[Array], Array], int]:
    """Preconditioner of one point where D^-1 alone stalls, and vectors of GMRES before a restart.

    rows : product of the preconditioned balance.  Where links pass a body, the phases of their tone come first and the
    resonant coordinates solve what these leave: 5 to 25 products where either alone takes 100 to 200.
    """
    system, modal, kernel, batch = balance.system, balance.modal, balance.kernel, balance.batch
    resonant = resonant_block(system, modal, kernel, batch.frequency[p]) or np.asarray
    if system.passing is None:
        return resonant, _BASIS
    phases = phase_block(system, modal, kernel, batch.frequency[p], float(batch.frame[p]))

    def both(x: Array) -> Array:
        near = phases(x)
        return near + resonant(x - rows(near))

    return both, _LONG


def _sharpen(balance: _Balance, y: Array, residual: Array, scale: Array) -> Array:
    """Refine y (P, 2, J, n) and residual (P,) in place near a resonance of light damping; the uncertainty (P,)."""
    modal, frequency, mean = balance.modal, balance.batch.frequency, balance.kernel.lattice.mirrored
    uncertainty = np.zeros(len(y))
    for p in np.flatnonzero(near_sharp_resonance(modal, frequency) & np.isfinite(residual)).tolist():
        right, rows = balance.of([p]).preconditioned()
        refined, left, uncertainty[p] = sharpened(
            modal, rows, right, y[[p]], frequency[p], mean=mean, tolerance=balance.tolerance
        )
        y[p], residual[p] = refined[0], left / scale[p]
    return uncertainty


def _kept(modal: Modal, frequency: Array) -> Array | None:
    """|D| / P at frequencies (P, J) [rad/s], (P, J, n): 1 but where D is below its floor; None where it nowhere is."""
    w = frequency[:, :, None]
    real, imag, floor = modal.squared - w**2, w * modal.damping, FLOOR * modal.squared
    if not np.any(real**2 + imag**2 < (2 * floor) ** 2):
        return None
    size = np.hypot(real, imag)
    low = size < floor
    return np.where(low, size / np.where(low, floor, 1.0), 1.0) if np.any(low) else None


def diagonal_inverse(modal: Modal, frequency: Array, kept: Array | None = None) -> tuple[Array, Array]:
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


def diagonal_product(factor: tuple[Array, Array], y: Array) -> Array:
    """D^-1 y, factors of `diagonal_inverse` applied to y (P, 2, J, n); of one point without the first axis."""
    out = factor[0] * y
    out += factor[1] * y[..., ::-1, :, :]
    return out


def _pull(pulls: Array, force: Array) -> Array:
    """Mesh forces (m, P, 2 J) [N] on the modal coordinates, (P, 2, J, n), by their pulls (m, n)."""
    m, P, J2 = force.shape
    return (force.reshape(m, -1).T @ pulls).reshape(P, 2, J2 // 2, -1)


def _coupling(modal: Modal, kernel: Kernel, batch: Batch) -> Callable[[Array], Array]:
    """Operator of everything off the diagonal: varying mesh stiffness, G, Kg, Cskew and the off-diagonal dampers.

    Maps y (P, 2, J, n) to generalized forces of the same shape.
    """
    frame, n, names = batch.frame[:, None], modal.squared.size, list(modal.coupling)
    factors = {"G": frame * batch.frequency, "C": batch.frequency, "Kg": frame**2, "Cskew": frame}
    gaps, pulls = modal.gaps[kernel.distinct], modal.pulls[kernel.distinct]
    matrix = np.concatenate(list(modal.coupling.values())) if names else np.zeros((0, n))
    P, J = batch.frequency.shape
    # made once: the pages of a fresh one would cost as much as filling it
    side_by_side = np.empty((P, 2, J, len(matrix)))

    def couple(y: Array) -> Array:
        """Off-diagonal forces of y, (P, 2, J, n)."""
        gap = (gaps @ y.reshape(-1, n).T).reshape(-1, P, 2 * J)
        force = product(kernel, gap, joined=True)
        result: Array = force.reshape(len(force), -1).T @ pulls
        # one product of everything side by side: y scaled, turned by i where a rate counts
        for number, name in enumerate(names):
            scaled, factor = side_by_side[..., number * n : (number + 1) * n], factors[name][:, :, None]
            if name in ("G", "C"):
                np.multiply(y[:, 1], -factor, out=scaled[:, 0])
                np.multiply(y[:, 0], factor, out=scaled[:, 1])
            else:
                np.multiply(y, factor[:, None], out=scaled)
        if names:
            result += side_by_side.reshape(-1, len(matrix)) @ matrix
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
    return force + _pull(modal.pulls[: len(error)], pulled)


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


def _truncation_residual(pulls: Array, modal: Modal, kernel: Kernel, batch: Batch, force: Array | None) -> Array:
    """Size of the response to forces on the truncated harmonics, by kind, (P, D + 1): the exact residual beyond those
    kept.

    pulls, force : (r, n) of mesh rows, and (r, P, 2 T) of them on these harmonics [N]; None where there are none.
    """
    if force is None:
        return np.zeros((len(batch.frequency), kernel.lattice.tones + 1))
    # |y| = |force| / |D|: both parts of y need not be told apart
    w, pulled = batch.truncated_frequency[:, :, None], _pull(pulls, force)
    held = (modal.squared - w**2) ** 2 + (w * modal.damping) ** 2
    held[held == 0] = np.inf
    squares = ((pulled[:, 0] ** 2 + pulled[:, 1] ** 2) / held).sum(axis=2)
    kinds = np.arange(kernel.lattice.tones + 1)
    return np.asarray(np.sqrt(squares @ (kernel.truncated_kind[:, None] == kinds)))


def resonant_block(system: System, modal: Modal, kernel: Kernel, frequency: Array) -> Callable[[Array], Array] | None:
    """Preconditioner (1 + D^-1 coupling)^-1 on the resonant coordinates of one point, 1 on the others.

    frequency : (J,) of every harmonic [rad/s].

    Returns
    -------
    A function (1, 2 J n) -> (1, 2 J n) of the preconditioned rows of the balance; None where no coordinate is resonant.
    """
    waves = [_waves(system.varying, modal, axis.meshes) for axis in kernel.axes]
    w = frequency[:, None]
    D = modal.squared - w**2 + 1j * w * modal.damping
    inverse = np.divide(1.0, D, out=np.zeros_like(D), where=D != 0)
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
    rows = near * _couplings(waves, kernel.lattice.points[point], mode, sign=1) + np.eye(order.size)
    real = kernel.lattice.mirrored  # where the conjugate of an amplitude counts, parts are solved, else amplitudes
    if real:
        folded = near * _couplings(waves, kernel.lattice.points[point], mode, sign=-1)
        rows = np.block(
            [[rows.real + folded.real, folded.imag - rows.imag], [rows.imag + folded.imag, rows.real - folded.real]]
        )
    factors = scipy.linalg.lu_factor(rows, overwrite_a=True)
    both = np.concatenate([order, frequency.size * len(modal.squared) + order])

    def solve(x: Array) -> Array:
        """The block solved, (1, 2 J n)."""
        out, near = x.copy(), x[0, both]
        solved = scipy.linalg.lu_solve(factors, near if real else to_complex(near))
        out[0, both] = solved if real else to_real(solved)
        return out

    return solve


def _waves(rows: VaryingRows, modal: Modal, meshes: Index) -> ComplexArray:
    """Couplings of coordinates by each harmonic -L .. L of the stiffness of rows `meshes` (m_j,), (2 L + 1, n, n)."""
    L = rows.wave.shape[1]
    series = stiffness_series(rows, meshes, L, reach=L)
    pulls, gaps = modal.pulls[meshes], modal.gaps[meshes]
    return np.array([(pulls.T * wave) @ gaps for wave in series.T])


def _couplings(waves: list[ComplexArray], points: Index, mode: Index, *, sign: int) -> ComplexArray:
    """Couplings (S, S) of coordinates at lattice points (S, D) in modes (S,), by the harmonics a - sign b.

    sign : 1, or -1 of a real signal, where the conjugate of b counts.
    """
    couplings = np.zeros((len(points), len(points)), complex)
    for axis, wave in enumerate(waves):
        reach = len(wave) // 2
        step = points[:, None, axis] - sign * points[None, :, axis]
        coupled = np.abs(step) <= reach
        for other in range(points.shape[1]):
            if other != axis:
                coupled &= points[:, None, other] == sign * points[None, :, other]
        a, b = np.nonzero(coupled)
        couplings[a, b] += wave[step[a, b] + reach, mode[a], mode[b]]
    return couplings
