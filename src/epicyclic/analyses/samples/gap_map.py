"""Feedback of the gaps of chosen rows on their own laws, at one speed, solved once for the nominal train.

With factors a on the laws of R rows (meshes k(t) as a whole, links), d their gaps and d0 those of the nominal train,

    d + T (a - 1) d = d0,        T = (gaps for forces on the rows) (force of a nominal row for its gap)

with parametric, gyroscopic and centripetal terms in T (derived here).  Gaps are weighted by the root of the mean
stiffness of their row, so that one norm, a root of energy, serves meshes, translations and rotations.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.system import Array, ComplexArray
from ..steady.balance import truncated_response
from ..steady.excitation import link_errors, mesh_order_excitation, shaft_order_excitation
from ..steady.kernel import Kernel, product, to_real
from ..steady.lattice import Lattice
from ..steady.response import Response, Truncation
from .columns import UnitLoads, solve_columns

__all__ = ["GapMap", "gap_map"]

# Doubles of the map: 1 GB.
_MOST = 125_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GapMap:
    """Mesh orders, or one shaft group, of R = m + l rows with J harmonics each: N = 2 J R weighted numbers.

    weight : (R,) root of the mean stiffness [N/m, N m/rad].  nominal : (N,) d0.  feedback : (N, N) T transposed.
    truncated_basis : of each kind of truncated harmonic, (2 J m, r): |a d @ basis| is the truncation residual there.
    frequency : (J,) [rad/s].  scale : of the nominal solution.  dynamic : size of d0 without its mean.
    meshes : m, the first rows.
    """

    weight: Array
    nominal: Array
    feedback: Array
    truncated_basis: tuple[Array, ...]
    frequency: Array
    scale: float
    dynamic: float
    meshes: int


def gap_map(
    ready: Response,
    truncation: Truncation,
    speed: float,
    links: NDArray[np.int64],
    *,
    shaft: int | None,
    tolerance: float,
) -> GapMap:
    """Solve the nominal train, and a unit force on every row at every harmonic.

    Parameters
    ----------
    speed : relative.  links : (l,) link rows beside the meshes.  shaft : index of the shaft group, None of mesh orders.
    tolerance : relative residual [1].

    Raises
    ------
    ModelError : more than 1 GB would be needed.
    """
    system, shifted = ready.system, shaft is not None
    kernel = ready.kernel(truncation, shifted=shifted)
    J, m = len(kernel.lattice.points), len(system.meshes.name)
    B = np.concatenate([system.meshes.B, system.links.B[:, links]], axis=1)
    if (2 * J * B.shape[1]) ** 2 > _MOST:
        raise ModelError(
            f"{B.shape[1]} rows of {J} harmonics would need more than 1 GB", path="links", allowed="fewer of them"
        )
    stiffness = np.concatenate([system.meshes.stiffness, system.links.stiffness[links]])
    weight = np.sqrt(stiffness)
    read = B.T @ ready.modal.shapes
    read[:m] = ready.modal.gaps
    error, force = _nominal(ready, speed, kernel.lattice, shaft)
    errors = np.concatenate([error[:, 0], link_errors(system, ready.lines, kernel.lattice, shaft=shaft)[links]])
    loads = UnitLoads(error=error, force=force, shaft=shaft)
    nominal = solve_columns(ready, truncation, speed, loads, tolerance=tolerance)
    gap = _row_gaps(read, nominal.y)[:, 0] - to_real(errors)
    feedback = np.empty((len(weight), 2 * J, len(weight), 2 * J))
    laws = _law_matrices(kernel, stiffness, J, m)
    for place, column in enumerate(B.T):
        unit = UnitLoads(
            error=np.zeros((m, 2 * J, J), complex), force=_unit_forces(column, J, mirrored=not shifted), shaft=shaft
        )
        gaps = _row_gaps(read, solve_columns(ready, truncation, speed, unit, tolerance=tolerance).y)
        scaled = gaps * (weight / weight[place])[:, None, None]
        feedback[place] = np.einsum("ib,rbj->irj", laws[place], scaled)
    at, truncated_frequency = (values[shaft or 0] * speed for values in ready.frequency(truncation, shifted=shifted))
    return GapMap(
        weight=weight,
        nominal=(gap * weight[:, None]).ravel(),
        feedback=feedback.reshape(gap.size, gap.size),
        truncated_basis=_truncated_basis(ready, kernel, truncated_frequency, weight[:m], J),
        frequency=at,
        scale=float(nominal.scale[0]),
        dynamic=float(np.linalg.norm((gap * weight[:, None])[:, 0 if shifted else 1 :])),
        meshes=m,
    )


def _nominal(ready: Response, speed: float, lattice: Lattice, shaft: int | None) -> tuple[ComplexArray, ComplexArray]:
    """Errors of the meshes (m, 1, J) [m] and forces (1, J, n) [N, N m] of the nominal train."""
    if shaft is None:
        return mesh_order_excitation(ready.system, ready.lines, np.array([speed]), lattice)
    lines = replace(ready.lines, shaft=(ready.lines.shaft[shaft],))
    return shaft_order_excitation(ready.system, lines, np.array([speed]), lattice)


def _row_gaps(read: Array, y: Array) -> Array:
    """Gaps (R, P, 2 J) [m, rad] of solutions (P, 2, J, n); read : (R, n)."""
    P, _, J, n = y.shape
    gaps: Array = (read @ y.reshape(-1, n).T).reshape(-1, P, 2 * J)
    return gaps


def _unit_forces(column: Array, J: int, *, mirrored: bool) -> ComplexArray:
    """Force along a row (n,) at every harmonic, real then imaginary, (2 J, J, n); a mean has no imaginary part."""
    force = np.zeros((2 * J, J, column.size), complex)
    at = np.arange(J)
    force[at, at], force[J + at, at] = column, 1j * column
    if mirrored:
        force[J, 0] = 0.0
    return force


def _law_matrices(kernel: Kernel, stiffness: Array, J: int, m: int) -> Array:
    """Forces of nominal rows for their gaps as matrices (R, 2 J, 2 J) [N/m]: gap @ law; stiffness : (R,)."""
    unit = np.eye(2 * J)
    laws = stiffness[:, None, None] * unit
    laws[:m] += product(kernel, np.broadcast_to(unit, (m, 2 * J, 2 * J)))
    return laws


def _truncated_basis(ready: Response, kernel: Kernel, frequency: Array, weight: Array, J: int) -> tuple[Array, ...]:
    """Truncated harmonics that unit gaps of every mesh excite, by kind, with no more columns than independent rows.

    frequency : (T,) [rad/s].  weight : (m,) of the mesh gaps.
    """
    m = weight.size
    gaps = np.zeros((m, m, 2 * J, 2 * J))
    gaps[np.arange(m), np.arange(m)] = np.eye(2 * J) / weight[:, None, None]
    at = np.tile(frequency, (m * 2 * J, 1))
    y = truncated_response(ready.modal, kernel, at, gaps.reshape(m, -1, 2 * J))
    found = []
    for kind in range(kernel.lattice.tones + 1):
        part = y[:, :, kernel.truncated_kind == kind].reshape(len(y), -1)
        found.append(np.linalg.qr(part.T).R.T if part.shape[1] > part.shape[0] else part)
    return tuple(found)
