"""Derivative of a force measure Q with respect to every number of the System, from forward and adjoint solutions.

With the residual R = Z X + B p - F of every harmonic (Z dynamic stiffness without meshes, p = k(t) gap + c gap'),
dQ = sum W Re( pull^H dp + press^H dgap - z^H (dZ X + dB p - dF) ), the sum over all harmonics, W their weights; p, gap
and X held in dp, dgap = dB^T X - de and dZ.  No derivative of the modal basis enters: matrices are projected on the
basis of the System as it stands.  Modal damping, M Phi diag(2 zeta w) Phi^T M, changes with M and K; in modal
coordinates dC_ij = 2 zeta (dK_ij + w_i w_j dM_ij) / (w_i + w_j), of repeated roots too.  Derived here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...questions.modes.basis import mean_modes, modal_weights
from ...questions.response.excitation import speed_powers
from ...questions.response.lattice import product
from ...questions.response.response import Block, Response
from ...system.system import Array, ComplexArray
from .adjoint import AdjointPart, harmonic_weights
from .numbers import SystemNumbers, mean_stiffness_change

__all__ = ["Basis", "Gradient", "basis_of", "gradient", "rigid_mode_imbalance"]

Index = NDArray[np.int64]
Values = NDArray[Any]  # complex of any kind
Number = TypeVar("Number", bound=np.inexact)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Basis:
    """Modes of the mean system, Phi^T M Phi = 1.

    omega : (n,) [rad/s].  shapes : (n, n) Phi.  rigid : (n,).  weight : (n,) q = Phi (y / weight).
    """

    omega: Array
    shapes: Array
    rigid: NDArray[np.bool_]
    weight: Array


def basis_of(ready: Response) -> Basis:
    """Modal basis of the modal form of a response."""
    squared, shapes = mean_modes(ready.system)
    rigid = squared == 0
    omega = np.sqrt(squared)
    return Basis(omega=omega, shapes=shapes, rigid=rigid, weight=modal_weights(squared, rigid))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Gradient:
    """dQ/d(number) of U meshes at P speeds [N^2 per unit]; coordinates n are modal (`Basis`).

    M, C, K, mean : (U, P, n, n); `mean` of K + B k B^T, by which modal damping changes.  frame : (P,) factor of G and
    Cskew, squared of Kg.  B : (U, P, n, m).  stiffness, damping : (U, P, m).  variation : (U, P, m, L) complex.
    force : (U, P, n).  zeta : (U, P).  tones : (U, P, D) [1/Hz] and lines : (U, P, R) by frequency [1/Hz].
    line_gap : (U, P, R, m), line_force : (U, P, R, 3, n) complex, dQ = Re(conj(gradient) d number).
    """

    M: Array
    C: Array
    K: Array
    mean: Array
    frame: Array
    B: Array
    stiffness: Array
    damping: Array
    variation: ComplexArray
    force: Array
    zeta: Array
    tones: Array
    lines: Array
    line_gap: ComplexArray
    line_force: ComplexArray

    def along(self, ready: Response, basis: Basis, change: SystemNumbers) -> Array:
        """dQ along a parameter whose change of the numbers is `change`, (U, P) [N^2 per unit]."""
        Phi = basis.shapes

        def modal(matrix: Array) -> Array:
            """Phi^T A Phi of a matrix (n, n)."""
            return Phi.T @ matrix @ Phi

        frame = self.frame
        total = np.zeros(self.zeta.shape)
        for matrix, gradient in (
            (change.K, self.K),
            (mean_stiffness_change(ready.system, change), self.mean),
            (change.M, self.M),
            (change.C, self.C),
        ):
            if matrix.any():
                total += np.einsum("opij,ij->op", gradient, modal(matrix))
        for matrix, gradient, factor in (
            (change.Kg, self.K, frame**2),
            (change.Cskew, self.K, frame),
            (change.G, self.C, frame),
        ):
            if matrix.any():
                total += np.einsum("opij,ij,p->op", gradient, modal(matrix), factor)
        total += np.einsum("opnm,nm->op", self.B, Phi.T @ change.B)
        total += self.stiffness @ change.stiffness + self.damping @ change.damping + self.force @ (Phi.T @ change.force)
        total += self.zeta * float(change.zeta) + self.tones @ change.tones + self.lines @ change.line_frequency
        total += np.einsum("opml,ml->op", self.variation.conj(), change.variation).real
        total += np.einsum("oprm,rm->op", self.line_gap.conj(), change.line_gap).real
        total += np.einsum("oprkn,rkn->op", self.line_force.conj(), change.line_force @ Phi).real
        return np.asarray(total)


def gradient(ready: Response, basis: Basis, block: Block, parts: Sequence[AdjointPart]) -> Gradient:
    """Gradient of Q: sum of the contributions of mesh and shaft orders."""
    found = [_of_part(ready, basis, block, part) for part in parts]
    if len(found) == 1:
        return found[0]
    sums = {f.name: sum(getattr(one, f.name) for one in found) for f in fields(Gradient) if f.name != "frame"}
    return Gradient(frame=found[0].frame, **sums)


def _of_part(ready: Response, basis: Basis, block: Block, part: AdjointPart) -> Gradient:
    """Gradient of the mesh orders or of the shaft orders."""
    system, P = ready.system, block.speed.size
    U, B, J, _ = part.z.shape
    S = B // P
    weight = harmonic_weights(part.kernel)[:, None]
    w = part.solved.frequency[:, :, None]
    x = np.asarray((part.solved.y[:, 0] + 1j * part.solved.y[:, 1]) / basis.weight, complex)
    z = part.z / basis.weight * weight

    def outer(left: Values, right: Values) -> Array:
        """Re sum over harmonics of conj(left) right^T, (U, P, left, right)."""
        a, b = left.reshape(U, P, S * J, -1), right.reshape(-1, P, S * J, right.shape[-1])
        both = np.concatenate([a.real, a.imag], axis=2).swapaxes(2, 3) @ np.concatenate([b.real, b.imag], axis=2)
        return np.asarray(both)

    frame = ready.frame_factor(block.speed)
    K, C = -outer(z, x), -outer(z, 1j * w * x)
    M = outer(z, w**2 * x)
    mean, damped_mass = _modal_damping(basis, system.zeta or 0.0, C)
    pull = (part.pull * weight[:, 0]).transpose(0, 2, 3, 1)  # (U, B, J, m), weights in
    press = (part.press * weight[:, 0]).transpose(0, 2, 3, 1)
    force, gap = part.force.transpose(1, 2, 0), part.gap.transpose(1, 2, 0)
    k, c = system.meshes.stiffness, system.meshes.damping
    through = _sum_over_shafts(np.einsum("objm,bjm->obm", pull.conj(), force - 1j * w * c * gap).real, P)
    truncated = _sum_over_shafts(np.einsum("ombt,mbt->obm", part.truncated_pull.conj(), part.truncated_force).real, P)
    rate = _sum_over_shafts(np.einsum("objm,bjm->obm", pull.conj(), 1j * w * gap).real, P)
    tones, lines = _frequencies(ready, basis, block, part, (x, z, pull))
    line_gap, line_force, steady = _lines(ready, block, part, (press, z))
    return Gradient(
        M=M + damped_mass,
        C=C,
        K=K,
        mean=mean,
        frame=frame,
        B=outer(press, x).swapaxes(2, 3) - outer(z, force),
        stiffness=(through + truncated) / k,
        damping=rate,
        variation=_variation(part, ready, P),
        force=steady,
        zeta=2 * np.einsum("opii,i->op", C, basis.omega),
        tones=tones,
        lines=lines,
        line_gap=line_gap,
        line_force=line_force,
    )


def _sum_over_shafts(values: NDArray[Number], P: int) -> NDArray[Number]:
    """Sums over the shaft lines of each speed, (U, P S, ..) -> (U, P, ..)."""
    summed: NDArray[Number] = values.reshape(values.shape[0], P, -1, *values.shape[2:]).sum(axis=2)
    return summed


def _modal_damping(basis: Basis, zeta: float, C: Array) -> tuple[Array, Array]:
    """Parts of the gradients of K + B k B^T and of M due to modal damping, from that of C (U, P, n, n)."""
    both = np.add.outer(basis.omega, basis.omega)
    # two rigid modes have no modal damping, and keep none while they stay rigid
    share = 2 * zeta * C * np.where(both > 0, 1.0 / np.where(both > 0, both, 1.0), 0.0)
    return share, share * np.multiply.outer(basis.omega, basis.omega)


def _frequencies(
    ready: Response,
    basis: Basis,
    block: Block,
    part: AdjointPart,
    solution: tuple[ComplexArray, ComplexArray, ComplexArray],
) -> tuple[Array, Array]:
    """dQ by the tones (U, P, D) and by the frequency of each shaft line (U, P, R) [1/Hz]."""
    system, (x, z, pull) = ready.system, solution
    P, Phi, w = block.speed.size, basis.shapes, part.solved.frequency[:, :, None]
    frame = ready.frame_factor(block.speed)
    C = Phi.T @ system.C @ Phi + np.diag(2 * (system.zeta or 0.0) * basis.omega)
    turning = np.repeat(frame, w.shape[0] // P)[:, None, None] * (x @ (Phi.T @ system.G @ Phi).T)
    rate = -2 * w * x + 1j * (x @ C.T + turning)
    gap = 1j * system.meshes.damping * part.gap.transpose(1, 2, 0)
    by_row = np.einsum("objm,bjm->obj", pull.conj(), gap).real - np.einsum("objn,bjn->obj", z.conj(), rate).real
    by_row = by_row.reshape(by_row.shape[0], P, -1, by_row.shape[2]) * (2 * np.pi * block.speed)[:, None, None]
    lines = np.zeros((*by_row.shape[:2], len(system.lines)))
    if part.shifted:
        place = {id(line): r for r, line in enumerate(system.lines)}
        for number, shaft in enumerate(ready.lines.shaft):
            lines[:, :, place[id(shaft.members[0][2])]] = by_row[:, :, number].sum(axis=2)
    return by_row.sum(axis=2) @ part.kernel.lattice.points @ _tones(ready), lines


def _tones(ready: Response) -> Array:
    """Incidence of the axes of the lattice on `System.tones`, (D axes, tones)."""
    tones = ready.system.tones
    result = np.zeros((len(ready.lines.tones), len(tones)))
    result[np.arange(len(ready.lines.tones)), [tones.index(tone) for tone in ready.lines.tones]] = 1.0
    return result


def _lines(
    ready: Response, block: Block, part: AdjointPart, adjoint: tuple[ComplexArray, ComplexArray]
) -> tuple[ComplexArray, ComplexArray, Array]:
    """dQ by the errors (U, P, R, m) and forces (U, P, R, 3, n) of every line, and by the constant force (U, P, n)."""
    lines, (press, z) = ready.system.lines, adjoint
    U, P, n, m = z.shape[0], block.speed.size, z.shape[-1], press.shape[-1]
    gaps, forces = np.zeros((U, P, len(lines), m), complex), np.zeros((U, P, len(lines), 3, n), complex)
    steady = np.zeros((U, P, n))
    row = {tuple(point): i for i, point in enumerate(part.kernel.lattice.points.tolist())}
    number = {id(line): r for r, line in enumerate(lines)}
    powers = speed_powers(block.speed)
    if not part.shifted:
        steady = z[:, :, row[(0,) * part.kernel.lattice.tones]].real
        for point, line in ready.lines.mesh:
            force, gap = z[:, :, row[point]], press[:, :, row[point]]
            if not any(point):
                force, gap = force.real.astype(complex), gap.real.astype(complex)
            gaps[:, :, number[id(line)]] -= gap
            forces[:, :, number[id(line)]] += powers[:, :, None] * force[:, :, None]
        return gaps, forces, steady
    S = len(ready.lines.shaft)
    for group, shaft in enumerate(ready.lines.shaft):
        for point, conjugate, line in shaft.members:
            at = row[tuple(-order for order in point) if conjugate else point]
            force, gap = z[:, group::S, at], press[:, group::S, at]
            force, gap = (force.conj(), gap.conj()) if conjugate else (force, gap)
            gaps[:, :, number[id(line)]] -= gap
            forces[:, :, number[id(line)]] += powers[:, :, None] * force[:, :, None]
    return gaps, forces, steady


def _variation(part: AdjointPart, ready: Response, P: int) -> ComplexArray:
    """dQ by the harmonics of every mesh, (U, P, m, L): correlation of pull and gap along the tone of the mesh."""
    meshes, made = ready.system.meshes, part.kernel
    U, m, B, _ = part.pull.shape
    L = meshes.variation.shape[1]
    pull, gap = np.concatenate([part.pull, part.truncated_pull], axis=3), part.gap
    points, known = np.concatenate([made.lattice.points, made.truncated]), made.lattice.points
    if made.lattice.mirrored:  # both a and -a of a real signal, its mean once
        pull, points = _two_sided(pull, points)
        gap, known = _two_sided(gap, known)
    padded = np.concatenate([gap, np.zeros((m, B, 1))], axis=2)
    result = np.zeros((U, P, m, L), complex)
    for axis in range(made.lattice.tones):
        mine = np.flatnonzero(ready.lines.axis == axis)
        mine_pull, mine_gap = pull[:, mine].conj(), padded[mine]
        for order in range(1, L + 1):
            step = np.zeros(points.shape[1], np.int64)
            step[axis] = order
            # of a real signal the harmonic above is the conjugate of that below, each counted for half of every row
            down = np.einsum("omba,mba->obm", mine_pull, mine_gap[:, :, _places(known, points - step)])
            if made.lattice.mirrored:
                total = 2 * down.conj()
            else:
                up = np.einsum("omba,mba->obm", mine_pull, mine_gap[:, :, _places(known, points + step)])
                total = (down.conj() + up) / 2
            result[:, :, mine, order - 1] = _sum_over_shafts(meshes.stiffness[mine] * total, P)
    return result


def _places(known: Index, points: Index) -> Index:
    """Index of each point (K, D) among the known ones (J, D), J where it is none of them."""
    reach = int(max(np.abs(known).max(initial=0), np.abs(points).max(initial=0)))
    powers = (2 * reach + 1) ** np.arange(known.shape[1])
    keys, wanted = known @ powers, points @ powers
    rank = np.argsort(keys)
    found = rank[np.clip(np.searchsorted(keys[rank], wanted), 0, keys.size - 1)]
    return np.asarray(np.where(keys[found] == wanted, found, keys.size), np.int64)


def _two_sided(values: ComplexArray, points: Index) -> tuple[ComplexArray, Index]:
    """One-sided amplitudes (.., K) of a real signal as two-sided ones at a and -a."""
    moving = points.any(axis=1)
    half = np.where(moving, values / 2, values)
    return np.concatenate([half, half[..., moving].conj()], axis=-1), np.concatenate([points, -points[moving]])


def rigid_mode_imbalance(ready: Response, basis: Basis, block: Block, change: SystemNumbers) -> Array:
    """Force that a change leaves on a rigid mode, relative to the forces it brings (P,) [1]: 0 where the mode stays
    free.

    A change that puts a spring on a rigid mode (radii that fit no one centre distance) has no derivative of the
    response.
    """
    solved, system, Phi = block.mesh, ready.system, basis.shapes
    if not basis.rigid.any():
        return np.zeros(block.speed.size)
    frame = ready.frame_factor(block.speed)[:, None]
    q = (solved.y[:, 0, 0] / basis.weight) @ Phi.T
    gap = solved.gap[:, :, 0]
    made = ready.kernel(block.truncation, shifted=False)
    force = (system.meshes.stiffness[:, None] * gap + product(made, solved.gap)[:, :, 0]).T
    still = [r for r, line in enumerate(system.lines) if line.frequency == 0]
    pushed = change.force + change.line_force[still, 0].real.sum(axis=0)
    rigid = Phi[:, basis.rigid]
    residual, size = pushed @ rigid, np.full(block.speed.size, np.abs(pushed).sum())
    terms = ((change.K, q), (change.Kg, frame**2 * q), (change.Cskew, frame * q), (change.B, force))
    for matrix, motion in terms:
        residual = residual - (motion @ matrix.T) @ rigid
        size = size + np.abs(matrix).sum() * np.abs(motion).max(axis=1)
    limit = size[:, None] * np.abs(rigid).max(axis=0)
    return np.asarray((np.abs(residual) / np.where(limit > 0, limit, 1.0)).max(axis=1))
