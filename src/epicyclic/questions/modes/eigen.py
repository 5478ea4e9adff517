"""Natural frequencies, shapes and kinds of modes of the mean system, and its modal basis at standstill.

At standstill a symmetric eigenproblem, with gyroscopic terms and damping a quadratic one,
(mu^2 M + mu (C + s G) + K + s^2 Kg + s Cskew) phi = 0 with mean meshes in C and K and q ~ phi exp(mu t), solved by
linearisation to a state matrix [tisseur2001].

Kinds, multiplicities and one fixed basis in every repeated eigenspace come from cyclic symmetry alone: a symmetry R
(R^N = 1, commuting with M and K) splits every eigenspace.  Eigenvalue 1 of R is a rotational mode, exp(+-2 pi i/N) a
translational one, any other a planet mode [lin1999].  A mode in which nothing but the bending of rings has kinetic
energy and no mesh is strained is a ring mode, whatever the symmetry.

Rounding of a symmetric eigenproblem is n eps of the largest omega^2: a mode 1e6 times slower than the fastest is lost
in it.  With the rows weighted by the roots of stiffness, W = [sqrt(k) b], the mean stiffness
is W W^T, and the singular values of M^-1/2 W are the natural frequencies, right to n eps of the largest omega: twice
the range in powers of ten.  So modes that are soft beside the stiffest are found (derived here).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ...errors import ModelError
from ...statics.tangent import linear
from ...system.system import Array, ComplexArray, Symmetry, System, free_motions, stiffness_rows
from ...warning_codes import CodedText, coded

# Rounding of omega^2 from the eigenproblem, per largest one.
NOISE = 1e-11
# Below this part of the largest omega^2 the eigenproblem has an elastic mode right to 1e-6 at best.
SOFT = 1e-8
# Relative error of a natural frequency that is worth a warning.
_COARSE = 1e-6
# Squared frequencies above are of no train [rad^2/s^2]; products of shapes with so little mass are no numbers.
_HIGHEST = 1e40


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Modal:
    """A System in energy-weighted modal coordinates y = weight * x, q = Phi x; what no speed changes.

    The weight makes |y| the root of the strain energy, so that one residual norm serves soft and stiff modes alike.
    squared : (n,) omega_r^2 [rad^2/s^2], 0 of a rigid mode.  rigid : (n,) bool.
    shapes : (n, n) Phi / weight: q = shapes @ y.  forces : (n, n) weight * Phi^T: y-row force = forces @ F.
    gaps : (v, n) B^T shapes: gap of y of `System.varying`, the meshes first.  pulls : (v, n) weight * Phi^T B,
        transposed: force of such a row on y rows.
    damping : (n,) 2 zeta_r omega_r plus the modal diagonal of the given dampers [1/s].
    coupling : transposed (n, n) operators G, Kg, Cskew and the off-diagonal part of C; absent where they are zero.
    """

    squared: Array
    rigid: NDArray[np.bool_]
    shapes: Array
    forces: Array
    gaps: Array
    pulls: Array
    damping: Array
    coupling: dict[str, Array]


@lru_cache(maxsize=4)  # one analysis after the other asks of the same train
def mean_modes(system: System) -> tuple[Array, Array]:
    """Squared natural frequencies and mass-normalised shapes of the undamped mean system at standstill.

    Parameters
    ----------
    system : gives M and the stiffness K + B k B^T with mean meshes, both (n, n).

    A mode is rigid where it strains no row, whatever its size (`free_motions`).

    Returns
    -------
    (omega^2 (n,) [rad^2/s^2], rising, rigid modes exactly 0; Phi (n, n) with Phi^T M Phi = 1).

    Raises
    ------
    ModelError : a mass or inertia is missing, a coordinate has none, or next to none; the mean stiffness has a negative
        eigenvalue.
    """
    system.require_inertia()
    squared, shapes = _eigenpairs(system)
    # both ends of the rising squares bound all of them; a shape that is not finite makes the sum so
    largest = max(abs(float(squared[0])), abs(float(squared[-1]))) if squared.size else 0.0
    if not (math.isfinite(shapes.sum()) and largest < _HIGHEST):
        lightest = system.dofs.names[int(np.argmin(np.diag(system.M)))]
        raise ModelError(f"masses and stiffnesses are too far apart for modes; least mass or inertia on {lightest}")
    if squared.size and squared[0] < -NOISE * largest:
        raise ModelError("the mean stiffness has a negative eigenvalue: the train is statically unstable")
    small, soft = (int(squared.searchsorted(share * largest, side="right")) for share in (NOISE, SOFT))
    squared[:small] = 0.0
    rows = stiffness_rows(system) if soft else None
    if rows is None:
        return _read_only(squared, shapes)
    root = np.linalg.cholesky((system.M + system.M.T) / 2)
    scaled = scipy.linalg.solve_triangular(root, rows, lower=True)
    free, rest = free_motions(scaled)
    if free.shape[1] == small == soft:
        return _read_only(squared, shapes)
    motions, omega, _ = scipy.linalg.svd(rest.T @ scaled, full_matrices=False)
    motions = np.concatenate([free, rest @ motions[:, ::-1]], axis=1)
    squared = np.concatenate([np.zeros(free.shape[1]), omega[::-1] ** 2])
    return _read_only(squared, scipy.linalg.solve_triangular(root.T, motions, lower=False))


def _read_only(squared: Array, shapes: Array) -> tuple[Array, Array]:
    squared.flags.writeable = shapes.flags.writeable = False
    return squared, shapes


def _eigenpairs(system: System) -> tuple[Array, Array]:
    """Squares (n,) [rad^2/s^2], rising, and mass-normalised shapes (n, n).

    Raises
    ------
    ModelError : a matrix that is not finite, M not positive definite.
    """
    stiffness, mass = system.mean_stiffness, system.M
    if not mass.size:
        return np.zeros(0), np.zeros((0, 0))
    try:
        squared, shapes = scipy.linalg.eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
        return squared, shapes
    except np.linalg.LinAlgError:
        pass
    except ValueError as error:
        raise ModelError("the mass or stiffness matrix holds a number that is not finite") from error
    massless = [i for i, mass in enumerate(np.diag(system.M).tolist()) if not mass > 0]
    if not massless:
        raise ModelError("the mass matrix is not positive definite")
    # the first coordinate without mass or inertia gives the path
    body, direction = system.dofs.body[massless[0]], system.dofs.direction[massless[0]]
    key = {"x": "mass", "y": "mass", "z": "mass", "rz": "inertia"}.get(direction, "tilt_inertia")
    member = f"stages.{'.'.join(body.split('/')[:2])}" if "/" in body else f"bodies.{body}"
    names = ", ".join(system.dofs.names[i] for i in massless)
    problem = f"the mass matrix is not positive definite, no mass or inertia on {names}"
    raise ModelError(problem, path=f"{member}.{key}", allowed="above zero")


def spread_warnings(squared: Array) -> list[CodedText]:
    """Warning where natural frequencies are so far apart that the lowest are not right to 1e-6.

    squared : (n,) omega^2 [rad^2/s^2].
    """
    omega = np.sqrt(squared)
    error = omega.size * np.finfo(float).eps * float(omega.max(initial=0.0)) / np.where(omega > 0, omega, np.inf)
    coarse = error > _COARSE
    if not np.any(coarse):
        return []
    return [
        coded(
            "frequencies-rounded",
            f"{np.count_nonzero(coarse)} natural frequencies up to {omega[coarse].max() / (2 * np.pi):.3g} Hz stand "
            f"beside {omega.max() / (2 * np.pi):.3g} Hz: double precision has them right to "
            f"{error.max():.1g} of themselves",
        )
    ]


def modal_weights(squared: Array, rigid: NDArray[np.bool_]) -> Array:
    """Scale y / x of each modal coordinate: its natural frequency, of a rigid mode the lowest elastic one.

    Parameters
    ----------
    squared : (n,) omega^2 [rad^2/s^2].  rigid : (n,) which modes are rigid.

    Returns
    -------
    (n,) [rad/s]; 1 where every mode is rigid.
    """
    omega = np.sqrt(squared)
    lowest = np.min(omega[~rigid], initial=1.0 if rigid.all() else np.inf)
    return np.where(rigid, lowest, omega)


def modal_form(system: System) -> Modal:
    """A System in energy-weighted modal coordinates, see `Modal`; derived here.

    Raises
    ------
    ModelError : as of `mean_modes`.
    """
    squared, modes = mean_modes(system)
    rigid = squared == 0
    omega = np.sqrt(squared)
    weight = modal_weights(squared, rigid)
    shapes, forces = modes / weight, weight[:, None] * modes.T
    B = system.varying.B
    gaps, pulls = B.T @ shapes, (forces @ B).T
    # A rigid mode strains no mesh: what is left is rounding, which 1/omega^2 of a slow shaft order would blow up.
    gaps[:, rigid] = pulls[:, rigid] = 0.0
    C = forces @ system.mean_damping @ shapes
    diagonal = np.diag(C).copy()
    np.fill_diagonal(C, 0.0)
    matrices = {"G": system.G, "Kg": system.Kg, "Cskew": system.Cskew}
    coupling = {name: np.ascontiguousarray((forces @ A @ shapes).T) for name, A in matrices.items() if A.any()}
    if np.abs(C).max(initial=0.0) > 1e-12 * np.abs(diagonal).max(initial=0.0):
        coupling["C"] = np.ascontiguousarray(C.T)
    return Modal(
        squared=squared,
        rigid=rigid,
        shapes=shapes,
        forces=forces,
        gaps=np.ascontiguousarray(gaps),
        pulls=np.ascontiguousarray(pulls),
        damping=2 * (system.zeta or 0.0) * omega + diagonal,
        coupling=coupling,
    )


Shapes = NDArray[np.inexact]  # real or complex

# Roots that symmetry makes equal are split by rounding (1e-12 of the largest omega^2) and by the asymmetry that still
# counts as symmetry (1e-9 of an entry); designs that merely come close differ by 1e-5 and more.
_SAME, _ROUNDING = 1e-7, 1e-11
# Components equal by symmetry differ by rounding; the first of those this close to the largest is taken.
_TIE = 1e-6

_KINDS, _RING = ("rotational", "translational", "planet", "ring"), 3
# Part of its energies that a mode of rings alone has elsewhere: rounding.
_ELSEWHERE = 1e-9
# An eigenvalue of the state matrix, or its imaginary part, is rounding below this part of the largest; 20 Hz beside
# 20 kHz is 1e-3.
_ZERO = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Modes:
    """Undamped modes of the mean system at standstill.

    omega_squared : (n,) rising [rad^2/s^2], rigid modes exactly 0.
    vectors : (n, n) columns with vectors^T M vectors = 1; rz coordinates in rad.
    """

    omega_squared: Array
    vectors: Array

    @property
    def omega(self) -> Array:
        """Natural angular frequencies, (n,) [rad/s]."""
        return np.sqrt(self.omega_squared)


class Whirl(NamedTuple):
    """Modes with gyroscopic terms or damping, one of each conjugate pair.

    mu : (n,) complex eigenvalues [1/s], frequency rising; 0 for rigid modes; of two real ones the slower decaying.
    vectors : (n, n) complex, unit kinetic norm (vector^H M vector = 1).
    """

    mu: ComplexArray
    vectors: ComplexArray


class ClassifiedModes(NamedTuple):
    """Modes with their kinds.

    vectors : (n, modes) real or complex, M-orthonormal within each repeated root, canonical basis.
    kind : (modes,) rotational, translational, planet, ring or mixed.
    multiplicity : (modes,) modes of this kind at this frequency.
    """

    vectors: Shapes
    kind: tuple[str, ...]
    multiplicity: NDArray[np.int64]


def eigen(system: System) -> Modes:
    """All modes of the undamped mean system at standstill, repeated roots included.

    Returns
    -------
    Modes with omega^2 (n,) [rad^2/s^2] and shapes (n, n); links with laws enter by their tangents.

    Raises
    ------
    ModelError : a mass or inertia is missing, or the mean system is statically unstable.
    """
    system.require_inertia()
    squared, vectors = mean_modes(linear(system, asks_laws=True))
    return Modes(omega_squared=squared, vectors=vectors)


def frequencies_of_bodies(system: System) -> Array:
    """Natural frequencies above zero [Hz], rising, of modes in which bodies move more than they bend.

    system : linear.  What speeds are computed to: waves of a ring reach far beyond all that meshes excite.
    """
    squared, shapes = mean_modes(system)
    bent = np.isin(system.dofs.direction, ("x", "y", "z", "rx", "ry", "rz"), invert=True)
    share = np.einsum("im,ij,jm->m", shapes[bent], system.M[np.ix_(bent, bent)], shapes[bent])
    return np.asarray(np.sqrt(squared[(squared > 0) & (share < 0.5)]) / (2 * np.pi))


def damping_ratios(system: System, modes: Modes) -> Array:
    """Damping ratio of each undamped mode: the modal ratio plus phi^T C phi / (2 omega), mesh dampers in C.

    Off-diagonal terms of the modal damping matrix are left out; `whirl` has them.

    Returns
    -------
    (n,) [1]; nan for rigid modes, and everywhere where no damping is given.
    """
    if not system.damped:
        return np.full(len(modes.omega_squared), np.nan)
    vectors, meshes = modes.vectors, system.meshes
    gaps = meshes.B.T @ vectors
    power = np.einsum("im,ij,jm->m", vectors, system.C, vectors) + meshes.damping @ gaps**2
    elastic = modes.omega_squared > 0
    omega = np.where(elastic, modes.omega, 1.0)
    return np.where(elastic, (system.zeta or 0.0) + power / (2 * omega), np.nan)


def whirl(system: System, *, relative_speed: float, damped: bool = False, modes: Modes | None = None) -> Whirl:
    """Eigenvalues [1/s] and complex shapes (n, n) at a speed, from the state matrix in modal coordinates.

    Positions of neutral motions (rigid rotation) enter no force.  They are left out of the state: their double zero is
    a defective eigenvalue that rounding would scatter to 1e-8 of the largest, and becomes a simple one.

    Parameters
    ----------
    relative_speed : s, speed per operating speed [1].  damped : with C, Cskew and modal damping.
    modes : of `eigen`, where already at hand.

    Raises
    ------
    ModelError : damping is asked for and none is given, or what `eigen` raises.
    """
    if damped and not system.damped:
        raise ModelError("damped modes need damping, and none is given", path="damping", allowed="modal, mesh, ...")
    system = linear(system, asks_laws=True)
    modes = eigen(system) if modes is None else modes
    Phi, s = modes.vectors, relative_speed
    C = s * (Phi.T @ system.G @ Phi)
    K = np.diag(modes.omega_squared) + s**2 * (Phi.T @ system.Kg @ Phi)
    if damped:
        C = C + Phi.T @ system.mean_damping @ Phi + np.diag(2 * (system.zeta or 0.0) * modes.omega)
        K = K + s * (Phi.T @ system.Cskew @ Phi)
    Q, neutral = neutral_basis(K, np.flatnonzero(modes.omega_squared == 0))
    scale = float(np.max(modes.omega, initial=0.0)) or 1.0
    mu, p = _state_modes(Q.T @ C @ Q / scale, Q.T @ K @ Q / scale**2, neutral)
    vectors = Phi @ (Q @ p)
    norm = np.sqrt(np.einsum("im,ij,jm->m", vectors.conj(), system.M, vectors).real)
    order = np.lexsort((np.abs(mu.real), mu.imag))
    return Whirl(mu=scale * mu[order], vectors=(vectors / norm)[:, order])


def neutral_basis(K: Array, rigid: np.ndarray) -> tuple[Array, int]:
    """Orthogonal coordinates Q (n, n) whose first `count` directions meet no stiffness: K Q[:, :count] = 0.

    Parameters
    ----------
    K : (n, n) position matrix in modal coordinates [1/s^2].  rigid : indices (r,) of the rigid modes.

    Returns
    -------
    (Q, count); count is less than r where centrifugal or skew terms hold a rigid motion.
    """
    n = len(K)
    if not rigid.size:
        return np.eye(n), 0
    columns = K[:, rigid]
    _, sizes, directions = np.linalg.svd(columns)
    # the columns hold only s^2 Kg and s Cskew (their omega^2 is 0): rounding is measured on those
    scale = float(np.max(np.abs(K - np.diag(np.diag(K))), initial=0.0)) + float(np.max(np.abs(columns), initial=0.0))
    count = int(np.sum(sizes <= _ZERO * scale)) if scale > 0 else rigid.size
    Q = np.zeros((n, n))
    Q[rigid, : rigid.size] = directions[::-1].T
    rest = np.setdiff1d(np.arange(n), rigid)
    Q[rest, np.arange(rigid.size, n)] = 1.0
    return Q, count


def _state_modes(C: Array, K: Array, r: int) -> tuple[ComplexArray, ComplexArray]:
    """One eigenpair (n,), (n, n) per mode of p'' + C p' + K p = 0 [tisseur2001].

    Parameters
    ----------
    C, K : (n, n), time scaled so that |mu| is about 1 at most.  r : leading coordinates that are neutral, left out of
        the positions of the state.
    """
    n = len(C)
    k = n - r
    A = np.zeros((2 * k + r, 2 * k + r))
    A[:k, k : 2 * k] = np.eye(k)
    A[k : 2 * k] = -np.hstack([K[r:, r:], C[r:, r:], C[r:, :r]])
    A[2 * k :] = -np.hstack([K[:r, r:], C[:r, r:], C[:r, :r]])
    mu, states = scipy.linalg.eig(A)
    mu = np.where(np.abs(mu) <= _ZERO * np.max(np.abs(mu), initial=0.0), 0.0, mu)
    with np.errstate(divide="ignore", invalid="ignore"):
        p = np.vstack([states[2 * k :] / mu, states[:k]])
    chosen, slow = _one_of_each_pair(mu, r)
    p[:, slow] = 0.0
    p[:, slow] = np.eye(n)[:, :r]
    mu = mu.astype(complex)
    mu[slow] = 0.0
    mu.imag[np.abs(mu.imag) <= _ZERO * np.max(np.abs(mu), initial=0.0)] = 0.0
    return mu[chosen], p[:, chosen]


def _one_of_each_pair(mu: ComplexArray, r: int) -> tuple[np.ndarray, np.ndarray]:
    """Indices (n,) of one eigenvalue per mode, and among them the r that stand for the neutral motions.

    Each neutral motion has one zero left out of the state; the r slowest real eigenvalues are the partners of these.

    Parameters
    ----------
    mu : (2n - r,) eigenvalues of the state matrix.
    """
    # equal real eigenvalues come as a pair whose imaginary part is rounding
    turning = np.abs(mu.imag) > _ZERO * np.max(np.abs(mu), initial=0.0)
    oscillating = np.flatnonzero(turning & (mu.imag > 0))
    real = np.flatnonzero(~turning)
    real = real[np.argsort(np.abs(mu[real]), kind="stable")]
    slow, rest = real[:r], real[r:]
    pairs = rest[: len(rest) // 2 * 2].reshape(-1, 2)
    slower = np.where(mu[pairs[:, 0]].real >= mu[pairs[:, 1]].real, pairs[:, 0], pairs[:, 1])
    return np.concatenate([slow, slower, oscillating]), slow


def classify_modes(system: System, values: Shapes, vectors: Shapes) -> ClassifiedModes:
    """Classify modes by the cyclic symmetries that hold, and fix the basis in repeated eigenspaces [lin1999].

    Parameters
    ----------
    values : (modes,) omega^2 [rad^2/s^2] or complex eigenvalues [1/s], in order.  vectors : (n, modes), unit in M.
    """
    stages = set(system.meshes.stage)
    holding = [symmetry for symmetry in system.symmetries if symmetry.holds and symmetry.branches > 1]
    whole = bool(stages) and stages <= {symmetry.stage for symmetry in holding}
    projectors = _kind_projectors(holding, len(system.M)) if holding else []
    result = np.array(vectors)
    kinds: list[str] = []
    counts: list[int] = []
    for cluster in _without_defective(system.M, repeated_roots(values), result):
        spaces = _rings_apart(system, _split_by_kind(system.M, projectors, result[:, cluster]))
        result[:, cluster] = np.hstack([canonical_basis(space, system.M) for _, space in spaces])
        for kind, space in spaces:
            # invariance under all symmetries is rotational only where every stage has one
            name = "mixed" if kind < 0 or (kind == 0 and not whole) else _KINDS[kind]
            kinds += [name] * space.shape[1]
            counts += [space.shape[1]] * space.shape[1]
    return ClassifiedModes(vectors=result, kind=tuple(kinds), multiplicity=np.array(counts, dtype=np.int64))


def repeated_roots(values: Shapes) -> list[slice]:
    """Runs of neighbouring values (modes,) that are equal within rounding, as slices that cover all.

    Values in order.
    """
    size = np.abs(values)
    largest = float(np.max(size, initial=0.0))
    # soft modes come from singular values, whose rounding is a part of omega, not of omega^2
    rounding = np.where(size[1:] > SOFT * largest, _ROUNDING * largest, _ROUNDING * np.sqrt(size[1:] * largest))
    limit = _SAME * size[1:] + rounding
    parted = (np.abs(np.diff(values)) > limit) | ((size[1:] == 0) != (size[:-1] == 0))
    ends = [0, *(np.flatnonzero(parted) + 1).tolist(), len(values)]
    return [slice(a, b) for a, b in pairwise(ends) if b > a]


def canonical_basis(vectors: Shapes, M: Array) -> Shapes:
    """An orthonormal basis (n, k) that depends on the space alone: pivoted Cholesky factor of its projector.

    Derived here.

    Each vector is the space's image of one coordinate, the one with most kinetic energy in what is left of the space
    (ties: the first), so rounding in the eigensolver cannot turn the basis.

    Parameters
    ----------
    vectors : (n, k) real or complex, M-orthonormal.  M : (n, n).
    """
    if vectors.shape[1] == 1:
        return vectors
    left = np.sqrt(np.abs(np.diag(M)))[:, None] * vectors
    directions = []
    for _ in range(vectors.shape[1]):
        energy = np.sum(np.abs(left) ** 2, axis=1)
        pivot = int(np.argmax(energy >= (1 - _TIE) * energy.max()))
        direction = left[pivot].conj() / np.linalg.norm(left[pivot])
        directions.append(direction)
        left = left - np.outer(left @ direction, direction.conj())
    return np.asarray(vectors @ np.array(directions).T)


def normalisation(vectors: Shapes, radius: Array) -> Shapes:
    """Factor (modes,) that makes the largest component of each shape 1, torsion as u = R rz.

    Of components within 1e-6 of the largest the first counts, so that the sign does not hang on rounding.

    Parameters
    ----------
    vectors : (n, modes).  radius : (n,) R of rz coordinates, else 1 [m].
    """
    shapes = vectors * radius[:, None]
    size = np.abs(shapes)
    first = np.argmax(size >= (1 - _TIE) * size.max(axis=0), axis=0)
    return np.asarray(1.0 / shapes[first, np.arange(shapes.shape[1])])


def _kind_projectors(symmetries: Sequence[Symmetry], n: int) -> list[Array]:
    """Projectors (n, n) on rotational (1 for all stages), translational (for some stage) and planet modes."""
    rotational, rest = np.eye(n), np.eye(n)
    for symmetry in symmetries:
        rotational = rotational @ _rotation_projector(symmetry, 0)
        rest = rest @ (np.eye(n) - _rotation_projector(symmetry, 1))
    return [rotational, np.eye(n) - rest, rest - rotational]


def _rotation_projector(symmetry: Symmetry, k: int) -> Array:
    """Projector (n, n) on the eigenvalues exp(+-2 pi i k/N) of the operator: a mean over its N powers."""
    N = symmetry.branches
    fold = 1 if 2 * k % N == 0 else 2
    total, power = np.zeros_like(symmetry.operator), np.eye(len(symmetry.operator))
    for j in range(N):
        total = total + fold * np.cos(2 * np.pi * j * k / N) / N * power
        power = symmetry.operator @ power
    return total


def _without_defective(M: Array, runs: list[slice], vectors: Shapes) -> list[slice]:
    """Clusters with as many independent vectors as roots; a defective one (free body in turning axes) in singles.

    Parameters
    ----------
    M : (n, n).  runs : slices of the columns of `vectors` (n, modes).
    """
    clusters: list[slice] = []
    for run in runs:
        V = vectors[:, run]
        if np.iscomplexobj(V) and np.linalg.eigvalsh(V.conj().T @ M @ V)[0] < _TIE:
            clusters += [slice(i, i + 1) for i in range(run.start, run.stop)]
        else:
            clusters.append(run)
    return clusters


def _split_by_kind(M: Array, projectors: list[Array], vectors: Shapes) -> list[tuple[int, Shapes]]:
    """An eigenspace (n, k) by kinds, in fixed order: (kind, M-orthonormal basis (n, j)); kind -1 without symmetry.

    Roots of different kinds that coincide by accident are separated.
    """
    k = vectors.shape[1]
    if k > 1 and np.iscomplexobj(vectors):  # real ones are M-orthonormal as they come
        L = np.linalg.cholesky(vectors.conj().T @ M @ vectors)
        vectors = vectors @ np.linalg.inv(L).conj().T
    if not projectors:
        return [(-1, vectors)]
    # the projectors restricted to the space, (k, k) each
    weights = [vectors.conj().T @ M @ (P @ vectors) for P in projectors]
    if k == 1:
        return [(int(np.argmax([w[0, 0].real for w in weights])), vectors)]
    counts = [round(float(np.trace(w).real)) for w in weights]
    if k in counts:
        return [(counts.index(k), vectors)]
    spaces: list[tuple[int, Shapes]] = []
    done = np.zeros((k, 0))
    for kind, weight in enumerate(weights):
        count = min(counts[kind], k - done.shape[1]) if kind < 2 else k - done.shape[1]
        if count <= 0:
            continue
        outside = np.eye(k) - done @ done.conj().T
        _, basis = np.linalg.eigh(outside @ ((weight + weight.conj().T) / 2) @ outside + (outside - np.eye(k)))
        spaces.append((kind, vectors @ basis[:, -count:]))
        done = np.hstack([done, basis[:, -count:]])
    return spaces


def _rings_apart(system: System, spaces: list[tuple[int, Shapes]]) -> list[tuple[int, Shapes]]:
    """Spaces by kind, as of `_split_by_kind`, with the modes of rings alone parted from them as the kind `_RING`."""
    dofs, meshes = system.dofs, system.meshes
    rings = {b for (_, b), internal in zip(meshes.ends, meshes.internal, strict=True) if internal}
    bends = np.concatenate([np.full(len(names), dofs.bodies[i] in rings) for i, names in dofs.elastic] or [np.zeros(0)])
    if not bends.any():
        return spaces
    at = dofs.rigid.shape[0] + np.flatnonzero(bends)
    bent, mass = dofs.expand[at], system.bent_mass[np.ix_(at, at)]
    strained = np.sqrt(meshes.stiffness)[:, None] * meshes.B.T
    parted = []
    for kind, space in spaces:
        total = float(np.einsum("ik,ij,jk->", space.conj(), system.mean_stiffness, space).real) / space.shape[1]
        if not total > 0:  # a rigid motion
            parted.append((kind, space))
            continue
        own, teeth = bent @ space, strained @ space / math.sqrt(total)
        energy, basis = np.linalg.eigh(np.eye(space.shape[1]) - own.conj().T @ mass @ own + teeth.conj().T @ teeth)
        alone = energy < _ELSEWHERE
        for name, chosen in ((_RING, alone), (kind, ~alone)):
            if chosen.any():
                parted.append((name, space @ basis[:, chosen]))
    return parted
