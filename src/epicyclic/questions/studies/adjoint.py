"""Numbers of a System that a parameter may change, and mesh-force measures with their adjoint solutions; derived here.

Numbers stand side by side: their values, derivatives and weighted sums.

A measure is Q = sum |amplitude|^2 / 2 over rows of one whole mesh: all frequencies above 0 (mean square), or one mesh
order.  Its adjoint solves A* z = dQ/dX, after which any derivative is a sum over harmonics, see `gradient`.

The adjoint of the harmonic-balance operator is the same operator of another modal form, so that one solver does both:
with weights 2 on the mean of a real signal and 1 on every other harmonic (its power, doubled), <x, y> =
sum W Re(x^H y), a product with k(t) is its own adjoint, i w G of a skew G too, dampers change sign and everything else
is transposed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...errors import ConvergenceError, ModelError
from ...system.system import Array, ComplexArray, Index, System, faces
from ..modes.eigen import Modal, modal_weights
from ..response.balance import Batch, HarmonicSolution, solve
from ..response.lattice import Gather, Kernel, product, to_complex, to_real
from ..response.response import Block, Response
from ..response.spectra import force_signal, force_spectrum, mesh_axis, whole_mesh_signal

# Doubles of one batch of adjoint harmonics; larger than the forward one, whose own arrays are not held beside it.
_BATCH = 120_000


class SystemNumbers(NamedTuple):
    """Values, or derivatives with respect to one parameter, of the arrays of a System without laws, in its units.

    M, C, G, K, Kg, Cskew : (n, n).  B : (n, m).  stiffness, damping : (m,).  variation : (m, L) complex.
    force : (n,).  zeta : ().  tones : (D,) [Hz].
    line_frequency : (R,) [Hz].  line_gap : (R, m) complex.  line_force : (R, 3, n) complex.
    """

    M: Array
    C: Array
    G: Array
    K: Array
    Kg: Array
    Cskew: Array
    B: Array
    stiffness: Array
    variation: ComplexArray
    damping: Array
    force: Array
    zeta: Array
    tones: Array
    line_frequency: Array
    line_gap: ComplexArray
    line_force: ComplexArray


class ForceMeasure(NamedTuple):
    """Q of every whole mesh, (w, P) [N^2], and dQ/d(amplitude) of every row of its spectra.

    mesh : (m, P, J + T), shaft : (m, P S, J + T) complex [N], weighted dQ = Re(conj(seed) d amplitude); harmonics kept,
    then truncated.
    """

    square: Array
    mesh: ComplexArray
    shaft: ComplexArray | None


class AdjointPart(NamedTuple):
    """Adjoint solutions of mesh orders or of shaft orders, of U meshes at B = P S points.

    kernel, solved : of the forward solution.  shifted : whether of shaft orders.
    force : (m, B, J) and truncated_force : (m, B, T) forward mesh forces [N].  gap : (m, B, J) [m].
    z : (U, B, J, n) complex, energy-weighted modal.
    pull : (U, m, B, J) total dQ/d(mesh force), harmonic weights taken out.
    press : (U, m, B, J) dQ/d(gap), likewise.  truncated_pull : (U, m, B, T) dQ/d(mesh force) of truncated harmonics.
    """

    kernel: Kernel
    solved: HarmonicSolution
    shifted: bool
    force: ComplexArray
    truncated_force: ComplexArray
    gap: ComplexArray
    z: ComplexArray
    pull: ComplexArray
    press: ComplexArray
    truncated_pull: ComplexArray


def numbers(system: System) -> SystemNumbers:
    """Numbers of a System."""
    meshes, lines = system.meshes, system.lines
    n, m = meshes.B.shape
    return SystemNumbers(
        **{name: getattr(system, name) for name in ("M", "C", "G", "K", "Kg", "Cskew", "force")},
        B=meshes.B,
        stiffness=meshes.stiffness,
        variation=meshes.variation,
        damping=meshes.damping,
        zeta=np.array(system.zeta or 0.0),
        tones=np.array([float(tone) for tone in system.tones]),
        line_frequency=np.array([float(line.frequency) for line in lines]),
        line_gap=np.array([line.gap for line in lines], complex).reshape(-1, m),
        line_force=np.array([line.force for line in lines], complex).reshape(-1, 3, n),
    )


def combined(weights: Sequence[float], terms: Sequence[SystemNumbers]) -> SystemNumbers:
    """Weighted sum of several.

    Raises
    ------
    ModelError : they are not of one shape: something appeared, vanished or was renumbered between them.
    """
    totals = []
    for arrays in zip(*terms, strict=True):
        if len({array.shape for array in arrays}) > 1:
            raise ModelError("moves, meshes or lines of excitation appear or vanish here: no derivative")
        totals.append(np.asarray(sum(weight * array for weight, array in zip(weights, arrays, strict=True))))
    return SystemNumbers(*totals)


def mean_stiffness_change(system: System, change: SystemNumbers) -> Array:
    """Derivative of K + B k B^T, (n, n) [N/m per unit]."""
    B, k = system.meshes.B, system.meshes.stiffness
    mixed = (change.B * k) @ B.T
    return change.K + mixed + mixed.T + (B * change.stiffness) @ B.T


def measure(ready: Response, block: Block, *, harmonic: int | None) -> ForceMeasure:
    """Q of every whole mesh and its derivative with respect to every amplitude.

    Parameters
    ----------
    harmonic : a mesh order, of each mesh's own tone; None: all frequencies above 0, of mesh and shaft orders,
        amplitudes of exactly equal frequency added first.
    """
    face, P = faces(ready.system.meshes), block.speed.size
    signal = whole_mesh_signal(force_signal(ready, block), face)
    values, kept = signal.values, signal.orders.points.shape[0]
    if harmonic is None:
        # amplitudes of the whole line of each harmonic, 0 for the mean
        lines = signal.line_frequencies
        whole = values
        if lines.coincident:
            whole = lines.merged(values)[:, :, lines.line]
            whole = np.where(lines.negative, whole.conj(), whole)
        seed = np.where(lines.constant, 0.0, whole)
    else:
        # points that are this multiple of each mesh's tone and of no other, (w, K)
        points, axis = signal.orders.points, mesh_axis(ready)
        measured = np.zeros((axis.size, points.shape[1]), np.int64)
        measured[np.arange(axis.size), axis] = harmonic
        alike = (points[None] == measured[:, None]).all(axis=2)
        seed = np.zeros_like(values)
        seed[:, :, :kept] = np.where(alike[:, None], values[:, :, :kept], 0.0)
    square = (seed.conj() * values).real.sum(axis=2) / 2
    rows = seed[face.row]
    shaft = None
    if signal.lines is not None:
        shaft = rows[:, :, kept:].reshape(len(rows), P * signal.lines.amplitude.shape[2], -1)
    return ForceMeasure(square=square, mesh=rows[:, :, :kept], shaft=shaft)


def adjoint_parts(
    ready: Response, adjoint_modal: Modal, block: Block, measured: ForceMeasure, *, meshes: Index, tolerance: float
) -> Iterator[tuple[Index, tuple[AdjointPart, ...]]]:
    """Adjoint solutions of the measured whole meshes, some at a time: (which of them, parts of mesh and shaft orders).

    Parameters
    ----------
    adjoint_modal : `adjoint_form` of the modal form.  meshes : indices (O,) of whole meshes.
    tolerance : relative residual of the adjoint solution [1].

    Raises
    ------
    ConvergenceError : an adjoint solution does not come within 100 times that.
    """
    largest = max(solved.y.size for solved in (block.mesh, block.shaft) if solved is not None)
    count = max(1, _BATCH // largest)
    for start in range(0, meshes.size, count):
        some = meshes[start : start + count]
        parts = [_part(ready, adjoint_modal, block, block.mesh, measured.mesh, some, tolerance)]
        if block.shaft is not None and measured.shaft is not None:
            parts.append(_part(ready, adjoint_modal, block, block.shaft, measured.shaft, some, tolerance))
        yield some, tuple(parts)


def _part(
    ready: Response,
    adjoint_modal: Modal,
    block: Block,
    solved: HarmonicSolution,
    seed: ComplexArray,
    some: Index,
    tolerance: float,
) -> AdjointPart:
    """Adjoint solutions of the meshes `some` (U,) for the seed (m, P S, J + T) of mesh or shaft orders."""
    shifted = solved is block.shaft
    made, meshes = ready.kernel(block.truncation, shifted=shifted), ready.system.meshes
    forward = force_spectrum(ready, block, shifted=shifted).amplitude.reshape(*seed.shape)
    J, U = len(made.lattice.points), some.size
    own = faces(meshes).row == some[:, None]
    seeds = np.where(own[:, :, None, None], seed[None], 0.0)  # (U, m, B, J + T)
    weight = harmonic_weights(made)
    kept = np.asarray(seeds[..., :J] / weight, complex)
    truncated_pull: ComplexArray = seeds[..., J:]
    rate = 1j * meshes.damping[:, None, None] * solved.frequency
    truncated_force = to_complex(truncated_product_adjoint(made, to_real(_flat(truncated_pull))))
    truncated_force = _of_measures(truncated_force, U) / weight

    def to_gap(pull: ComplexArray) -> ComplexArray:
        """dQ/d(gap) (U, m, B, J) of dQ/d(mesh force) (U, m, B, J)."""
        varying = _of_measures(to_complex(product(made, to_real(_flat(pull)))), U)
        return meshes.stiffness[:, None, None] * pull + varying - rate * pull + truncated_force

    # A* z = B press, one system for every mesh and point
    B, press = len(solved.frequency), to_gap(kept)
    rows = Batch(
        frequency=np.tile(solved.frequency, (U, 1)),
        truncated_frequency=np.zeros((U * B, len(made.truncated))),
        frame=np.tile(np.repeat(ready.frame_factor(block.speed), B // block.speed.size), U),
        error=np.zeros((len(meshes.B.T), U * B, J), complex),
        force=np.einsum("nm,ombj->objn", meshes.B, press).reshape(U * B, J, -1),
    )
    # forces of the adjoint on truncated harmonics are no residual
    bare = replace(made, truncated=made.truncated[:0])
    answer = solve(ready.system, adjoint_modal, bare, rows, tolerance=tolerance)
    if not np.all(answer.residual <= 100 * tolerance):
        raise ConvergenceError(f"the adjoint solution has a relative residual of {answer.residual.max():.3g}")
    z = (answer.y[:, 0] + 1j * answer.y[:, 1]).reshape(U, B, J, -1)
    pull = kept - _of_measures(to_complex(answer.gap), U)
    return AdjointPart(
        kernel=made,
        solved=solved,
        shifted=shifted,
        force=forward[..., :J],
        truncated_force=forward[..., J:],
        gap=to_complex(solved.gap),
        z=z,
        pull=pull,
        press=to_gap(pull),
        truncated_pull=truncated_pull,
    )


def _flat(values: ComplexArray) -> ComplexArray:
    """(U, m, B, K) -> (m, U B, K)."""
    U, m, B, K = values.shape
    return values.transpose(1, 0, 2, 3).reshape(m, U * B, K)


def _of_measures(values: ComplexArray, U: int) -> ComplexArray:
    """(m, U B, K) -> (U, m, B, K), the inverse of `_flat`."""
    return values.reshape(len(values), U, -1, values.shape[-1]).transpose(1, 0, 2, 3)


def adjoint_form(modal: Modal) -> Modal:
    """Modal form whose harmonic-balance operator is the adjoint.

    Of factors i w of both signs, C^T and G^T change sign; the energy weights of forces and motions change places.
    """
    weight = modal_weights(modal.squared, modal.rigid) ** 2
    coupling = {
        name: np.ascontiguousarray((-1.0 if name in ("C", "G") else 1.0) * matrix.T * weight / weight[:, None])
        for name, matrix in modal.coupling.items()
    }
    return replace(modal, damping=-modal.damping, coupling=coupling)


def harmonic_weights(kernel: Kernel) -> Array:
    """Weight W of every harmonic kept, (J,): 2 for the mean of a real signal, else 1."""
    return np.where(kernel.lattice.mirrored & ~kernel.lattice.points.any(axis=1), 2.0, 1.0)


def truncated_product_adjoint(kernel: Kernel, force: Array) -> Array:
    """Transpose of `truncated_product`, unweighted: truncated harmonics (m, P, 2 T) to harmonics kept (m, P, 2 J)."""
    if len(kernel.axes) == 1:
        return np.asarray(np.matmul(force, kernel.axes[0].truncated.own_matrix.transpose(0, 2, 1)))
    out = np.zeros((*force.shape[:2], 2 * len(kernel.lattice.points)))
    for meshes, _, to in kernel.axes:
        m, P, wide, size = len(meshes), force.shape[1], to.line_matrix.shape[2], out.shape[2]
        first = to.own_matrix.shape[2]
        slots = _scattered(force[meshes], to.back, first + to.lines.place.shape[0] * wide)
        own = slots[:, :, :first] @ to.own_matrix.transpose(0, 2, 1)
        lines = slots[:, :, first:].reshape(m, -1, wide) @ to.line_matrix.transpose(0, 2, 1)
        out[meshes] += _scattered(own, to.own, size) + _scattered(lines.reshape(m, P, -1), to.lines, size)
    return out


def _scattered(rows: Array, gather: Gather, size: int) -> Array:
    """Transpose of a gather: rows (m, P, ..) put back into `size` columns; the padding column falls away."""
    out = np.zeros((*rows.shape[:2], size + 1))
    out[:, :, gather.place.ravel()] = rows * gather.sign.ravel()  # a column is gathered once, but for the padding
    return out[:, :, :size]
