"""Mesh-force measures of a solved block and their adjoint solutions.

A measure is Q = sum |amplitude|^2 / 2 over rows of one whole mesh: all that moves (mean square), or one mesh order.
Its adjoint solves A* z = dQ/dX, after which any derivative is a sum over rows, see `gradient`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError
from ...system.faces import faces
from ...system.system import Array, ComplexArray
from ..modes.basis import Modal
from ..steady.balance import Rows, Solved, solve
from ..steady.comb import Comb
from ..steady.kernel import Kernel, product
from ..steady.response import Block, Response
from ..steady.waveform import complex_rows, force_signal, force_spectrum, mesh_axis, whole
from .transpose import row_weights, tail_adjoint

__all__ = ["Measure", "Part", "adjoint_parts", "measure", "stacked"]

Index = NDArray[np.int64]
# Doubles of one batch of adjoint rows; larger than the forward one, whose own arrays are not held beside it.
_BATCH = 120_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Measure:
    """Q of every whole mesh, (w, P) [N^2], and dQ/d(amplitude) of every row of its spectra.

    mesh, shaft : (m, P S, J + T) complex, weighted dQ = Re(conj(seed) d amplitude); rows kept, then dropped.
    """

    square: Array
    mesh: ComplexArray
    shaft: ComplexArray | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """Adjoint solutions of mesh orders or of shaft orders.

    kernel, solved : of the forward solution.  shifted : whether of shaft orders.
    force : (m, B, J) and beyond : (m, B, T) forward mesh forces; gap : (m, B, J).
    z : (U, B, J, n) complex, energy-weighted modal.
    pull : (U, m, B, J) dQ/d(mesh force) in all, row weights taken out.
    press : (U, m, B, J) dQ/d(gap), likewise.  tail : (U, m, B, T) dQ/d(mesh force) of the rows dropped.
    """

    kernel: Kernel
    solved: Solved
    shifted: bool
    force: ComplexArray
    beyond: ComplexArray
    gap: ComplexArray
    z: ComplexArray
    pull: ComplexArray
    press: ComplexArray
    tail: ComplexArray


def measure(ready: Response, block: Block, *, harmonic: int | None) -> Measure:
    """Q of every whole mesh and its derivative with respect to every amplitude.

    Parameters
    ----------
    harmonic : a mesh order, of each mesh's own tone; None: all that moves, of mesh and shaft orders, amplitudes of
        exactly equal frequency added first.
    """
    face, P = faces(ready.system.meshes), block.speed.size
    signal = whole(force_signal(ready, block), face)
    values, kept = signal.values, signal.orders.points.shape[0]
    if harmonic is None:
        seed = _moving(signal.comb, values)
    else:
        at = _own_order(signal.orders.points, mesh_axis(ready), harmonic)
        seed = np.zeros_like(values)
        seed[:, :, :kept] = np.where(at[:, None], values[:, :, :kept], 0.0)
    square = (seed.conj() * values).real.sum(axis=2) / 2
    rows = seed[face.row]
    shaft = None
    if signal.lines is not None:
        S = signal.lines.amplitude.shape[2]
        shaft = rows[:, :, kept:].reshape(len(rows), P * S, -1)
    return Measure(square=square, mesh=rows[:, :, :kept], shaft=shaft)


def _moving(comb: Comb, values: ComplexArray) -> ComplexArray:
    """What every row adds to its line, without the mean."""
    if comb.merged:
        lines = comb.folded(values)[:, :, comb.line]
        values = np.where(comb.backwards, lines.conj(), lines)
    return np.where(comb.still, 0.0, values)


def _own_order(points: Index, axis: Index, harmonic: int) -> NDArray[np.bool_]:
    """(w, K) rows that are this multiple of each mesh's tone and of no other."""
    wanted = np.zeros((axis.size, points.shape[1]), np.int64)
    wanted[np.arange(axis.size), axis] = harmonic
    return np.asarray((points[None] == wanted[:, None]).all(axis=2), bool)


def adjoint_parts(
    ready: Response, turned: Modal, block: Block, wanted: Measure, *, meshes: Index, tolerance: float
) -> Iterator[tuple[Index, tuple[Part, ...]]]:
    """Adjoint solutions of the wanted whole meshes, some at a time: (which of them, parts of mesh and shaft orders).

    Parameters
    ----------
    turned : `transpose.adjoint` of the modal form.  tolerance : relative residual of the adjoint solution.

    Raises
    ------
    ConvergenceError : an adjoint solution does not come within 100 times that.
    """
    largest = max(solved.y.size for solved in (block.mesh, block.shaft) if solved is not None)
    count = max(1, _BATCH // largest)
    for start in range(0, meshes.size, count):
        some = meshes[start : start + count]
        parts = [_part(ready, turned, block, block.mesh, wanted.mesh, some, tolerance)]
        if block.shaft is not None and wanted.shaft is not None:
            parts.append(_part(ready, turned, block, block.shaft, wanted.shaft, some, tolerance))
        yield some, tuple(parts)


def _part(
    ready: Response, turned: Modal, block: Block, solved: Solved, seed: ComplexArray, some: Index, tolerance: float
) -> Part:
    shifted = solved is block.shaft
    made, meshes = ready.kernel(block.kept, shifted=shifted), ready.system.meshes
    forward = force_spectrum(ready, block, shifted=shifted).amplitude.reshape(*seed.shape)
    J, U = len(made.lattice.points), some.size
    mine = faces(meshes).row == some[:, None]
    own = np.where(mine[:, :, None, None], seed[None], 0.0)  # (U, m, B, J + T)
    weight = row_weights(made)
    kept = np.asarray(own[..., :J] / weight, complex)
    tail: ComplexArray = own[..., J:]
    rate = 1j * meshes.damping[:, None, None] * solved.frequency
    beyond = complex_rows(tail_adjoint(made, stacked(_flat(tail)))).reshape(len(meshes.name), U, -1, J)
    beyond = beyond.transpose(1, 0, 2, 3) / weight

    def to_gap(pull: ComplexArray) -> ComplexArray:
        varying = complex_rows(product(made, stacked(_flat(pull)))).reshape(len(meshes.name), U, -1, J)
        result: ComplexArray = (
            meshes.stiffness[:, None, None] * pull + varying.transpose(1, 0, 2, 3) - rate * pull + beyond
        )
        return result

    found = _solve(ready, turned, block, made, solved, to_gap(kept), tolerance)
    B = solved.frequency.shape[0]
    z = (found.y[:, 0] + 1j * found.y[:, 1]).reshape(U, B, J, -1)
    pull = kept - complex_rows(found.gap).reshape(-1, U, B, J).transpose(1, 0, 2, 3)
    return Part(
        kernel=made,
        solved=solved,
        shifted=shifted,
        force=forward[..., :J],
        beyond=forward[..., J:],
        gap=complex_rows(solved.gap),
        z=z,
        pull=pull,
        press=to_gap(pull),
        tail=tail,
    )


def _solve(
    ready: Response,
    turned: Modal,
    block: Block,
    made: Kernel,
    solved: Solved,
    press: ComplexArray,
    tolerance: float,
) -> Solved:
    """A* z = B press, one system for every output and point."""
    U, m, B, J = press.shape
    force = np.einsum("nm,ombj->objn", ready.system.meshes.B, press).reshape(U * B, J, -1)
    frame = block.speed if ready.frame_speed == "kinematic" else np.ones_like(block.speed)
    rows = Rows(
        frequency=np.tile(solved.frequency, (U, 1)),
        beyond=np.zeros((U * B, len(made.dropped))),
        frame=np.tile(np.repeat(frame, B // block.speed.size), U),
        error=np.zeros((m, U * B, J), complex),
        force=force,
    )
    # what the adjoint puts on dropped rows is no residual of anything
    bare = replace(made, dropped=made.dropped[:0])
    found = solve(ready.system, turned, bare, rows, tolerance=tolerance)
    if not np.all(found.residual <= 100 * tolerance):
        raise ConvergenceError(f"the adjoint solution has a relative residual of {found.residual.max():.3g}")
    return found


def _flat(values: ComplexArray) -> ComplexArray:
    """(U, m, B, K) -> (m, U B, K)."""
    U, m, B, K = values.shape
    return values.transpose(1, 0, 2, 3).reshape(m, U * B, K)


def stacked(values: ComplexArray) -> Array:
    """Real and imaginary parts side by side along the last axis."""
    return np.concatenate([values.real, values.imag], axis=-1)
