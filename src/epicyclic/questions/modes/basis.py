"""The modal basis of the undamped mean system at standstill, shared by modes, load sharing and response.

Rounding of a symmetric eigenproblem is n eps of the largest omega^2: a mode 1e6 times slower than the fastest is lost
in it.  With the rows weighted by the roots of stiffness, W = [sqrt(k) b], the mean stiffness
is W W^T, and the singular values of M^-1/2 W are the natural frequencies, right to n eps of the largest omega: twice
the range in powers of ten.  So modes that are soft beside the stiffest are found (derived here).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.linalg.lapack import dsygvd

from ...errors import ModelError
from ...system.system import REST, Array, System, free_motions, stiffness_rows
from ...warning_codes import CodedText, coded

# Rounding of omega^2 from the eigenproblem, per largest one.
NOISE = 1e-11
# Below this part of the largest omega^2 the eigenproblem has an elastic mode right to 1e-6 at best.
SOFT = 1e-8
# Strain of a motion per unit row that rounding of the eigenproblem may leave: n eps over the gap to the elastic modes,
# `SOFT` or more.  A mode that a row holds strains it by 1e-3 and more.
_STRAIN = 1e-6
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
    gaps : (m, n) B^T shapes: mesh gap of y.  pulls : (m, n) weight * Phi^T B, transposed: force of a mesh on y rows.
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
    if not soft or (soft == small and _all_free(system, shapes[:, :small])):
        return squared, shapes
    rows = stiffness_rows(system)
    if rows is None:
        return squared, shapes
    root = np.linalg.cholesky((system.M + system.M.T) / 2)
    scaled = scipy.linalg.solve_triangular(root, rows, lower=True)
    free, rest = free_motions(scaled)
    if free.shape[1] == small == soft:
        return squared, shapes
    motions, omega, _ = scipy.linalg.svd(rest.T @ scaled, full_matrices=False)
    motions = np.concatenate([free, rest @ motions[:, ::-1]], axis=1)
    squared = np.concatenate([np.zeros(free.shape[1]), omega[::-1] ** 2])
    return squared, scipy.linalg.solve_triangular(root.T, motions, lower=False)


def _eigenpairs(system: System) -> tuple[Array, Array]:
    """Squares (n,) [rad^2/s^2], rising, and mass-normalised shapes (n, n), by the LAPACK driver of `scipy.linalg.eigh`.

    For the few coordinates of a stage the checks of `eigh`, made here on sums, take as long as the solution.

    Raises
    ------
    ModelError : a matrix that is not finite, M not positive definite.
    """
    stiffness, mass = system.mean_stiffness, system.M
    if not mass.size:
        return np.zeros(0), np.zeros((0, 0))
    if not math.isfinite(stiffness.sum() + mass.sum()):
        raise ModelError("the mass or stiffness matrix holds a number that is not finite")
    # transposed, which changes nothing in a symmetric matrix, they are in the order of LAPACK
    squared, shapes, info = dsygvd(
        (stiffness + stiffness.T).T / 2, ((mass + mass.T) / 2).T, overwrite_a=1, overwrite_b=1
    )
    if not info:
        return squared, shapes
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


def _all_free(system: System, shapes: Array) -> bool:
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
    B = system.meshes.B
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
