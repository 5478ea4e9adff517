"""Motions that strain nothing, by the rank of the rows, and modes that are soft beside the stiffest (derived here).

Rounding of a symmetric eigenproblem is n eps of the largest omega^2: a mode 1e6 times slower than the fastest is lost
in it, and no size of an eigenvalue tells it from a rigid one.  Kinematics does: a rigid motion strains no mesh and no
link, whatever their stiffness.  With the rows weighted by the roots of stiffness, W = [sqrt(k) b], the mean stiffness
is W W^T, and the singular values of M^-1/2 W are the natural frequencies, right to n eps of the largest omega: twice
the range in powers of ten.
"""

from __future__ import annotations

import math

import numpy as np
import scipy.linalg

from ...system.system import Array, System
from ...warning_codes import CodedText, coded

__all__ = ["NOISE", "SOFT", "all_free", "free_motions", "soft_modes", "spread_warnings", "stiffness_rows"]

# Rounding of omega^2 from the eigenproblem, per largest one.
NOISE = 1e-11
# Below this part of the largest omega^2 the eigenproblem has an elastic mode right to 1e-6 at best.
SOFT = 1e-8
# Singular values of rows of unit length that are zero: rounding of rows is 1e-15, and radii printed to eight digits fit
# one centre distance to 1e-8; rows that hold a motion on purpose have 1e-3 (a narrow face against tilt) and more.
_RANK = 1e-8
# Strain of a motion per unit row that rounding of the eigenproblem may leave: n eps over the gap to the elastic modes,
# `SOFT` or more.  A mode that a row holds strains it by 1e-3 and more.
_STRAIN = 1e-6
# What K has beside its links, per geometric mean of its diagonal: rounding of the sum.
_REST = 1e-12
# Relative error of a natural frequency that is worth a warning.
_COARSE = 1e-6


def stiffness_rows(system: System) -> Array | None:
    """Rows W (n, R) [sqrt(N/m)] with W W^T the mean stiffness: meshes, links, and what else K holds.

    None where a part of it is negative.
    """
    links, meshes = system.links, system.meshes
    linear = np.isfinite(links.stiffness) & (links.stiffness != 0)
    if np.any(links.stiffness[linear] < 0) or np.any(meshes.stiffness < 0):
        return None
    held = links.B[:, linear] * np.sqrt(links.stiffness[linear])
    rest = system.K - held @ held.T
    size = np.sqrt(np.maximum(np.diag(system.K), 0.0))
    rest[np.abs(rest) <= _REST * np.outer(size, size)] = 0.0
    further = _factor((rest + rest.T) / 2)
    if further is None:
        return None
    rows: Array = np.concatenate([meshes.B * np.sqrt(meshes.stiffness), held, further], axis=1)
    return rows


def all_free(system: System, shapes: Array) -> bool:
    """Whether mass-normalised shapes (n, r) strain no row, where that shows without a decomposition of the rows.

    False also where M is not diagonal, or what K holds beside links strains: `free_motions` has the answer.
    """
    mass, links, meshes = system.M.diagonal(), system.links, system.meshes
    if np.count_nonzero(system.M) > mass.size:
        return False
    held, stiffness, driven = links.B, links.stiffness, meshes.B
    # columns are chosen only where some are left out: the copy takes as long as the products
    if np.count_nonzero(stiffness) < stiffness.size or not math.isfinite(stiffness @ stiffness):
        linear = np.isfinite(stiffness) & (stiffness != 0)
        held, stiffness = held[:, linear], stiffness[linear]
    if np.count_nonzero(meshes.stiffness) < meshes.stiffness.size:
        driven = driven[:, meshes.stiffness != 0]
    rows = np.concatenate([driven, held], axis=1)
    strain = rows.T @ shapes
    rest = system.K @ shapes - held @ (stiffness[:, None] * strain[driven.shape[1] :])
    size = system.K.diagonal()
    if np.count_nonzero(rest * rest > (_REST**2 * size)[:, None] * (size @ (shapes * shapes))):
        return False
    return not np.count_nonzero(strain * strain > (_STRAIN**2 / mass @ (rows * rows))[:, None])


def _factor(matrix: Array) -> Array | None:
    """F (n, r) with F F^T a symmetric matrix (n, n) without negative eigenvalues; None where it has some."""
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    if not matrix.any():
        return np.zeros((len(matrix), 0))
    scale = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    limit = _REST * len(values) * float(np.abs(values).max())
    if values[0] < -limit:
        return None
    kept = values > limit
    factor: Array = scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])
    return factor


def free_motions(rows: Array) -> tuple[Array, Array]:
    """Orthonormal bases of the motions that strain no row, (n, r), and of the others, (n, n - r).

    rows : (n, R) in coordinates of unit mass; their lengths do not count.
    """
    length = np.linalg.norm(rows, axis=0)
    left, size, _ = np.linalg.svd(rows[:, length > 0] / length[length > 0])
    rank = int(np.count_nonzero(size > _RANK * float(size.max(initial=0.0))))
    return left[:, rank:], left[:, :rank]


def soft_modes(rows: Array, free: Array, rest: Array) -> tuple[Array, Array]:
    """omega^2 (n,) [rad^2/s^2], rising, those of free motions exactly 0, and orthonormal motions (n, n).

    rows : (n, R) W in coordinates of unit mass [1/s].  free, rest : of `free_motions`.
    """
    motions, omega, _ = scipy.linalg.svd(rest.T @ rows, full_matrices=False)
    squared = np.concatenate([np.zeros(free.shape[1]), omega[::-1] ** 2])
    return squared, np.concatenate([free, rest @ motions[:, ::-1]], axis=1)


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
