"""Derivatives of natural frequencies in closed form, of mesh-force measures by one adjoint solution a mesh and speed.

At standstill w' = phi^T (K' - w^2 M') phi / (2 w) [fox1968].  Of a repeated root the derivatives along a parameter are
the eigenvalues of that form projected on its eigenspace: they belong to the group, not to single modes.
At a speed, undamped, the problem is Hermitian in i w, so the left vector is the right one.

The derivative of a force measure Q with respect to every number of the System follows from forward and adjoint
solutions.  With the residual R = Z X + B p - F of every harmonic (Z dynamic stiffness without meshes,
p = k(t) gap + c gap'),
dQ = sum W Re( pull^H dp + press^H dgap - z^H (dZ X + dB p - dF) ), the sum over all harmonics, W their weights; p, gap
and X held in dp, dgap = dB^T X - de and dZ.  No derivative of the modal basis enters: matrices are projected on the
basis of the System as it stands.  Modal damping, M Phi diag(2 zeta w) Phi^T M, changes with M and K; in modal
coordinates dC_ij = 2 zeta (dK_ij + w_i w_j dM_ij) / (w_i + w_j), of repeated roots too.  Derived here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, TypeVar

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...system.system import Array, ComplexArray, Index, System, faces
from ..modes.eigen import Modes, Whirl, mean_modes, modal_weights, repeated_roots
from ..response.lattice import product
from ..response.response import Block, Response, respond, response
from ..response.spectra import speed_powers
from .adjoint import (
    AdjointPart,
    SystemNumbers,
    adjoint_form,
    adjoint_parts,
    harmonic_weights,
    mean_stiffness_change,
    measure,
)

Values = NDArray[Any]  # complex of any kind
Number = TypeVar("Number", bound=np.inexact)
# Stiffness change of a rigid mode: rounding of the change itself where the mode stays free; 1e-3 of a spring on it.
_FREE_STIFFNESS = 1e-9
# Relative residual asked for: the truncation may be 30 times that, and errs a derivative by some 10 times more.
_TOLERANCE = 1e-10
# The adjoint solution has no truncation, and its residual counts once.
_ADJOINT = 100.0
# Imbalance on a rigid mode: rounding and the error of the difference quotient of a change; 1e-3 of a spring on it.
_FREE_FORCE = 1e-6


class Basis(NamedTuple):
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

        frame, mean = self.frame, mean_stiffness_change(ready.system, change)
        total = np.zeros(self.zeta.shape)
        still = (change.K, self.K), (mean, self.mean), (change.M, self.M), (change.C, self.C)
        for matrix, gradient in still:
            if matrix.any():
                total += np.einsum("opij,ij->op", gradient, modal(matrix))
        turning = (change.Kg, self.K, frame**2), (change.Cskew, self.K, frame), (change.G, self.C, frame)
        for matrix, gradient, factor in turning:
            if matrix.any():
                total += np.einsum("opij,ij,p->op", gradient, modal(matrix), factor)
        total += np.einsum("opnm,nm->op", self.B, Phi.T @ change.B)
        total += self.stiffness @ change.stiffness + self.damping @ change.damping + self.force @ (Phi.T @ change.force)
        total += self.zeta * float(change.zeta) + self.tones @ change.tones + self.lines @ change.line_frequency
        total += np.einsum("opml,ml->op", self.variation.conj(), change.variation).real
        total += np.einsum("oprm,rm->op", self.line_gap.conj(), change.line_gap).real
        total += np.einsum("oprkn,rkn->op", self.line_force.conj(), change.line_force @ Phi).real
        return np.asarray(total)


class ForceDerivatives(NamedTuple):
    """Values and derivatives of one measure of the forces of w whole meshes at P speeds.

    value : (w, P) [N].
    derivative : (changes, w, P) [N per unit]; nan where the value is 0, or where `constrained`.
    constrained : (changes,) whether the change puts a spring on a rigid mode, so that there is no derivative.
    """

    value: Array
    derivative: Array
    constrained: NDArray[np.bool_]


def gradient(ready: Response, basis: Basis, block: Block, parts: Sequence[AdjointPart]) -> Gradient:
    """Gradient of Q: sum of the contributions of mesh and shaft orders."""
    terms = [_of_part(ready, basis, block, part) for part in parts]
    if len(terms) == 1:
        return terms[0]
    sums = {f.name: sum(getattr(term, f.name) for term in terms) for f in fields(Gradient) if f.name != "frame"}
    return Gradient(frame=terms[0].frame, **sums)


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
    # modal damping changes with K + B k B^T and with M; two rigid modes have none, and keep none while they stay rigid
    both = np.add.outer(basis.omega, basis.omega)
    mean = 2 * (system.zeta or 0.0) * C * np.where(both > 0, 1.0 / np.where(both > 0, both, 1.0), 0.0)
    pull = (part.pull * weight[:, 0]).transpose(0, 2, 3, 1)  # (U, B, J, m), weights in
    press = (part.press * weight[:, 0]).transpose(0, 2, 3, 1)
    force, gap = part.force.transpose(1, 2, 0), part.gap.transpose(1, 2, 0)
    k, c = system.meshes.stiffness, system.meshes.damping
    through = _sum_over_shafts(np.einsum("objm,bjm->obm", pull.conj(), force - 1j * w * c * gap).real, P)
    truncated = _sum_over_shafts(np.einsum("ombt,mbt->obm", part.truncated_pull.conj(), part.truncated_force).real, P)
    rate = _sum_over_shafts(np.einsum("objm,bjm->obm", pull.conj(), 1j * w * gap).real, P)
    tones, lines = _frequencies(ready, basis, block, part, (x, z, pull))
    line_gap, line_force, steady = _lines(ready, block, part, press, z)
    return Gradient(
        M=M + mean * np.multiply.outer(basis.omega, basis.omega),
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
    return np.asarray(values.reshape(values.shape[0], P, -1, *values.shape[2:]).sum(axis=2))


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
        number = {id(line): r for r, line in enumerate(system.lines)}
        for group, shaft in enumerate(ready.lines.shaft):
            lines[:, :, number[id(shaft.members[0][2])]] = by_row[:, :, group].sum(axis=2)
    # incidence of the axes of the lattice on the tones of the System, (D axes, tones)
    axes = np.zeros((len(ready.lines.tones), len(system.tones)))
    axes[np.arange(len(axes)), [system.tones.index(tone) for tone in ready.lines.tones]] = 1.0
    return by_row.sum(axis=2) @ part.kernel.lattice.points @ axes, lines


def _lines(
    ready: Response, block: Block, part: AdjointPart, press: ComplexArray, z: ComplexArray
) -> tuple[ComplexArray, ComplexArray, Array]:
    """dQ by the errors (U, P, R, m) and forces (U, P, R, 3, n) of every line, and by the constant force (U, P, n)."""
    lines = ready.system.lines
    U, P, n, m = z.shape[0], block.speed.size, z.shape[-1], press.shape[-1]
    gaps, forces = np.zeros((U, P, len(lines), m), complex), np.zeros((U, P, len(lines), 3, n), complex)
    row = {tuple(point): i for i, point in enumerate(part.kernel.lattice.points.tolist())}
    number = {id(line): r for r, line in enumerate(lines)}
    groups, powers = ready.lines.solved_together(shifted=part.shifted), speed_powers(block.speed)
    steady = np.zeros((U, P, n)) if part.shifted else z[:, :, row[(0,) * part.kernel.lattice.tones]].real
    for group, members in enumerate(groups):
        for point, conjugate, line in members:
            force, gap = (adjoint[:, group :: len(groups), row[point]] for adjoint in (z, press))
            if conjugate:
                force, gap = force.conj(), gap.conj()
            elif not part.shifted and not any(point):
                force, gap = force.real.astype(complex), gap.real.astype(complex)
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
        rows = np.flatnonzero(ready.lines.axis == axis)
        pull_rows, gap_rows = pull[:, rows].conj(), padded[rows]
        for order in range(1, L + 1):
            step = np.zeros(points.shape[1], np.int64)
            step[axis] = order
            # of a real signal the harmonic above is the conjugate of that below, each counted for half of every row
            down = np.einsum("omba,mba->obm", pull_rows, gap_rows[:, :, _point_index(known, points - step)])
            if made.lattice.mirrored:
                total = 2 * down.conj()
            else:
                up = np.einsum("omba,mba->obm", pull_rows, gap_rows[:, :, _point_index(known, points + step)])
                total = (down.conj() + up) / 2
            result[:, :, rows, order - 1] = _sum_over_shafts(meshes.stiffness[rows] * total, P)
    return result


def _point_index(known: Index, points: Index) -> Index:
    """Index of each point (K, D) among the known ones (J, D), J where it is none of them."""
    reach = int(max(np.abs(known).max(initial=0), np.abs(points).max(initial=0)))
    powers = (2 * reach + 1) ** np.arange(known.shape[1])
    keys, wanted = known @ powers, points @ powers
    rank = np.argsort(keys)
    nearest = rank[np.clip(np.searchsorted(keys[rank], wanted), 0, keys.size - 1)]
    return np.asarray(np.where(keys[nearest] == wanted, nearest, keys.size), np.int64)


def _two_sided(values: ComplexArray, points: Index) -> tuple[ComplexArray, Index]:
    """One-sided amplitudes (.., K) of a real signal as two-sided ones at a and -a."""
    moving = points.any(axis=1)
    half = np.where(moving, values / 2, values)
    return np.concatenate([half, half[..., moving].conj()], axis=-1), np.concatenate([points, -points[moving]])


def rigid_mode_imbalance(ready: Response, basis: Basis, block: Block, change: SystemNumbers) -> Array:
    """Force that a change leaves on a rigid mode, per force that it brings (P,) [1]: 0 where the mode stays free.

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


def frequency_derivatives(system: System, modes: Modes, changes: Sequence[SystemNumbers]) -> Array:
    """Derivatives of the natural frequencies of the mean system at standstill, undamped [fox1968].

    Parameters
    ----------
    modes : of `eigen`.  changes : of the System along each parameter.

    Returns
    -------
    (changes, modes) [Hz per unit of the parameter]; those of a repeated root rising.  Of a rigid mode 0 where the
    mode stays free, nan where it does not (the frequency then rises as a root, with infinite slope).
    """
    result = np.empty((len(changes), len(modes.omega_squared)))
    for row, change in zip(result, changes, strict=True):
        matrices = mean_stiffness_change(system, change), change.M
        stiffness, mass = (modes.vectors.T @ matrix @ modes.vectors for matrix in matrices)
        for group in repeated_roots(modes.omega_squared):
            squared = float(modes.omega_squared[group].mean())
            form = stiffness[group, group] - squared * mass[group, group]
            split = np.linalg.eigvalsh((form + form.T) / 2)
            if squared > 0:
                row[group] = split / (4 * np.pi * np.sqrt(squared))
            else:
                limit = _FREE_STIFFNESS * float(np.abs(stiffness).max(initial=0.0))
                row[group] = np.where(np.abs(split) <= limit, 0.0, np.nan)
    return result


def whirl_derivatives(
    system: System, modes: Whirl, changes: Sequence[SystemNumbers], *, relative_speed: float
) -> Array:
    """Derivatives of the undamped frequencies at a speed, gyroscopic and centripetal terms included.

    M q'' + s G q' + (K + s^2 Kg) q = 0 with G skew: mu' = -phi^H (mu^2 M' + mu s G' + K' + s^2 Kg') phi /
    phi^H (2 mu M + s G) phi; of a repeated root the eigenvalues of that pair of forms.

    Parameters
    ----------
    modes : of `whirl`, undamped.  relative_speed : s, of the same [1].

    Returns
    -------
    (changes, modes) [Hz per unit]; nan where mu is 0 or not imaginary (an unstable train).
    """
    result, s = np.full((len(changes), len(modes.mu)), np.nan), relative_speed
    for row, change in zip(result, changes, strict=True):
        dK = mean_stiffness_change(system, change) + s**2 * change.Kg
        for group in repeated_roots(modes.mu):
            root, V = complex(modes.mu[group].mean()), modes.vectors[:, group]
            if not (root.imag > 0 and abs(root.real) <= 1e-6 * root.imag):
                continue
            mu = 1j * root.imag
            above = V.conj().T @ (mu**2 * change.M + mu * s * change.G + dK) @ V
            below = V.conj().T @ (2 * mu * system.M + s * system.G) @ V
            # i times `below` is Hermitian and so is `above`: a pair of forms with real eigenvalues
            row[group] = np.sort(scipy.linalg.eigvals(above, -1j * below).real) / (2 * np.pi)
    return result


def force_derivatives(
    system: System,
    changes: Sequence[SystemNumbers],
    *,
    relative_speed: ArrayLike = 1.0,
    harmonic: int | None = None,
    tolerance: float = _TOLERANCE,
) -> ForceDerivatives:
    """RMS of the dynamic mesh force, or the amplitude of one mesh order, and its derivatives along changes.

    Adjoint of the harmonic balance, derived here (module docstrings of `adjoint` and `gradient`).

    Parameters
    ----------
    system : without laws of links (`statics.tangent.linear`), as the changes are.
    changes : derivatives of the System's numbers along each parameter.
    relative_speed : (P,) speeds per operating speed, held while the parameters change.
    harmonic : amplitude of this mesh order instead of the RMS of all frequencies above 0.
    tolerance : relative residual [1].

    Raises
    ------
    ModelError : no damping, no mesh frequency, a speed not above zero, frequencies that part from each other.
    ConvergenceError : an adjoint solution does not converge.
    """
    if system.passing is not None:
        problem = "links pass a body: their stiffness varies beside that of the meshes, no derivative"
        raise ModelError(problem, path=system.passing.link[0], allowed="a study, which changes the value itself")
    ready, meshes = response(system), np.arange(len(faces(system.meshes).name))
    speed = np.atleast_1d(np.asarray(relative_speed, dtype=float))
    if not speed.size or not np.all(np.isfinite(speed) & (speed > 0)):
        raise ModelError("speeds must be finite and above zero", path="relative_speed", given=relative_speed)
    value = np.full((meshes.size, speed.size), np.nan)
    derivative = np.full((len(changes), *value.shape), np.nan)
    constrained = np.zeros(len(changes), bool)
    basis = basis_of(ready)
    # the measure is sqrt(Q), or of an amplitude sqrt(2 Q); its slope over Q is nan where Q is 0
    factor = 1.0 if harmonic is None else 2.0
    adjoint_modal = adjoint_form(ready.modal)
    for block in respond(ready, speed, tolerance=tolerance, shaft_orders=harmonic is None):
        for number, change in enumerate(changes):
            _check_frequencies(ready, block, change)
            constrained[number] |= bool(np.any(rigid_mode_imbalance(ready, basis, block, change) > _FREE_FORCE))
        known = measure(ready, block, harmonic=harmonic)
        for some, parts in adjoint_parts(
            ready, adjoint_modal, block, known, meshes=meshes, tolerance=_ADJOINT * tolerance
        ):
            place = np.ix_(some, block.index)
            size = np.sqrt(factor * known.square[some])
            slope = np.where(size > 0, factor / (2 * np.where(size > 0, size, 1.0)), np.nan)
            value[place] = size
            slopes = gradient(ready, basis, block, parts)
            for number, change in enumerate(changes):
                derivative[number][place] = slope * slopes.along(ready, basis, change)
    derivative[constrained] = np.nan
    return ForceDerivatives(value, derivative, constrained)


def _check_frequencies(ready: Response, block: Block, change: SystemNumbers) -> None:
    """Refuse a change that parts frequencies which the solution adds up, or solves together.

    Raises
    ------
    ModelError : coinciding frequencies part as the speed changes.
    """
    if not change.tones.any() and not change.line_frequency.any():
        return
    system = ready.system
    known = np.array([float(f) for f in (*system.tones, *(line.frequency for line in system.lines))])
    moved = np.concatenate([change.tones, change.line_frequency])
    share = moved[known > 0] / known[known > 0]
    limit = 1e-7 * float(np.abs(share).max(initial=0.0))  # difference quotients of exact frequencies
    if np.ptp(share) <= limit:
        return
    number = {id(line): r for r, line in enumerate(system.lines)}
    axes = np.array([change.tones[system.tones.index(tone)] for tone in ready.lines.tones])
    off = [change.line_frequency[number[id(line)]] - np.dot(point, axes) for point, line in ready.lines.mesh]
    for shaft in ready.lines.shaft:
        base = change.line_frequency[number[id(shaft.members[0][2])]]
        off += [
            change.line_frequency[number[id(line)]] - np.dot(point, axes) + (base if conjugate else -base)
            for point, conjugate, line in shaft.members
        ]
    merged = ready.line_frequencies(block.truncation, shafts=block.shaft is not None, truncated=True).coincident
    if merged or np.abs(off).max(initial=0.0) > limit * float(known.max(initial=0.0)):
        raise ModelError("frequencies that meet at this speed part when it changes: no derivative")
