"""Modes that are soft beside the stiffest, and whether motions strain nothing (derived here).

Rounding of a symmetric eigenproblem is n eps of the largest omega^2: a mode 1e6 times slower than the fastest is lost
in it.  With the rows weighted by the roots of stiffness, W = [sqrt(k) b], the mean stiffness
is W W^T, and the singular values of M^-1/2 W are the natural frequencies, right to n eps of the largest omega: twice
the range in powers of ten.
"""

from __future__ import annotations

import math

import numpy as np
import scipy.linalg

from ...system.elimination import REST
from ...system.system import Array, System
from ...warning_codes import CodedText, coded

__all__ = ["NOISE", "SOFT", "all_free", "soft_modes", "spread_warnings"]

# Rounding of omega^2 from the eigenproblem, per largest one.
NOISE = 1e-11
# Below this part of the largest omega^2 the eigenproblem has an elastic mode right to 1e-6 at best.
SOFT = 1e-8
# Strain of a motion per unit row that rounding of the eigenproblem may leave: n eps over the gap to the elastic modes,
# `SOFT` or more.  A mode that a row holds strains it by 1e-3 and more.
_STRAIN = 1e-6
# Relative error of a natural frequency that is worth a warning.
_COARSE = 1e-6


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
    if np.count_nonzero(rest * rest > (REST**2 * size)[:, None] * (size @ (shapes * shapes))):
        return False
    return not np.count_nonzero(strain * strain > (_STRAIN**2 / mass @ (rows * rows))[:, None])


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
