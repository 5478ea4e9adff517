"""Kinds of modes, multiplicities, and one fixed basis in every repeated eigenspace, from cyclic symmetry alone.

A symmetry R (R^N = 1, commuting with M and K) splits every eigenspace: eigenvalue 1 of R is a rotational mode,
exp(+-2 pi i/N) a translational one, any other a planet mode [lin1999].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, Symmetry, System
from .free_motions import SOFT

__all__ = ["ClassifiedModes", "canonical_basis", "classify_modes", "normalisation", "repeated_roots"]

Shapes = NDArray[np.inexact]  # real or complex

# Roots that symmetry makes equal are split by rounding (1e-12 of the largest omega^2) and by the asymmetry that still
# counts as symmetry (1e-9 of an entry); designs that merely come close differ by 1e-5 and more.
_SAME, _ROUNDING = 1e-7, 1e-11
# Components equal by symmetry differ by rounding; the first of those this close to the largest is taken.
_TIE = 1e-6

_KINDS = ("rotational", "translational", "planet")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ClassifiedModes:
    """Modes with their kinds.

    vectors : (n, modes) real or complex, M-orthonormal within each repeated root, canonical basis.
    kind : (modes,) rotational, translational, planet or mixed.
    multiplicity : (modes,) modes of this kind at this frequency.
    """

    vectors: Shapes
    kind: tuple[str, ...]
    multiplicity: NDArray[np.int64]


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
        parts = _split_by_kind(system.M, projectors, result[:, cluster])
        result[:, cluster] = np.hstack([canonical_basis(part, system.M) for _, part in parts])
        for kind, part in parts:
            kinds += [_kind_name(kind, whole)] * part.shape[1]
            counts += [part.shape[1]] * part.shape[1]
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
    basis: Shapes = vectors @ np.array(directions).T
    return basis


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
    factor: Shapes = 1.0 / shapes[first, np.arange(shapes.shape[1])]
    return factor


def _kind_name(kind: int, whole: bool) -> str:
    """Name of a kind by its number; invariance under all symmetries is rotational only where every stage has one."""
    if kind < 0 or (kind == 0 and not whole):
        return "mixed"
    return _KINDS[kind]


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
    result: list[slice] = []
    for run in runs:
        V = vectors[:, run]
        if np.iscomplexobj(V) and np.linalg.eigvalsh(V.conj().T @ M @ V)[0] < _TIE:
            result += [slice(i, i + 1) for i in range(run.start, run.stop)]
        else:
            result.append(run)
    return result


def _split_by_kind(M: Array, projectors: list[Array], vectors: Shapes) -> list[tuple[int, Shapes]]:
    """An eigenspace (n, k) as parts (kind, M-orthonormal basis (n, j)); kind -1 without symmetry.

    Roots of different kinds that coincide by accident are separated here.
    """
    if vectors.shape[1] > 1 and np.iscomplexobj(vectors):  # real ones are M-orthonormal as they come
        L = np.linalg.cholesky(vectors.conj().T @ M @ vectors)
        vectors = vectors @ np.linalg.inv(L).conj().T
    if not projectors:
        return [(-1, vectors)]
    weights = [vectors.conj().T @ M @ (P @ vectors) for P in projectors]
    if vectors.shape[1] == 1:
        return [(int(np.argmax([w[0, 0].real for w in weights])), vectors)]
    return _split_by_projectors(vectors, weights)


def _split_by_projectors(vectors: Shapes, weights: list[Shapes]) -> list[tuple[int, Shapes]]:
    """Split (n, k) by eigenvectors of the projectors restricted to the space, `weights` (k, k) each.

    Kinds in fixed order.
    """
    k = vectors.shape[1]
    counts = [round(float(np.trace(w).real)) for w in weights]
    if k in counts:
        return [(counts.index(k), vectors)]
    parts: list[tuple[int, Shapes]] = []
    done = np.zeros((k, 0))
    for kind, weight in enumerate(weights):
        count = min(counts[kind], k - done.shape[1]) if kind < 2 else k - done.shape[1]
        if count <= 0:
            continue
        outside = np.eye(k) - done @ done.conj().T
        _, basis = np.linalg.eigh(outside @ ((weight + weight.conj().T) / 2) @ outside + (outside - np.eye(k)))
        parts.append((kind, vectors @ basis[:, -count:]))
        done = np.hstack([done, basis[:, -count:]])
    return parts
