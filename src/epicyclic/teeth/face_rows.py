"""Contact of a pair of gears as one convex potential of the approaches of three rows of its plane of action.

The approach of a segment is linear over the plane: w = c . y, with y the approaches at both ends of the face and at one
place along the line of action.  The loads P >= 0 of the segments maximise (derived here)

    Phi(y) = (c y - g) . P - P . C P/2 - sum int u_i dP_i

so that c' P is the gradient of Phi, and c' (C + du/dP)^-1 c over the loaded segments its derivative.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import gear_pair
from .contact_solver import ContactSolution, products, scaled_solution, solve_hertzian, solve_linear, solved
from .segments import ContactSegments

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RowStations:
    """Stations of the three rows [m]: left and right along the face from the middle of the mesh, and along the path.

    The first two are at the pitch point, the third at the middle of the mesh.
    """

    left: float
    right: float
    along: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RowResponse:
    """Response of three rows at t phases.

    force : (t, 3) of the rows [N].  tangent : (t, 3, 3) [N/m].  energy : (t,) [J].  segment : (t, n) forces of the
    segments [N].  own : (t, n) approach of the line contacts themselves [m].  residual : (t,) [1].
    """

    force: Array
    tangent: Array
    energy: Array
    segment: Array
    own: Array
    residual: Array


def row_weights(segments: ContactSegments, at: RowStations) -> Array:
    """Weights c of the rows for every segment, (T, n, 3) [1]; the sum over the rows is 1."""
    along = np.take_along_axis(segments.lines.sigma.reshape(len(segments.index), -1), segments.index, axis=1)
    third = along * segments.pair.plane.base_pitch / at.along
    right = (segments.zeta - at.left - third * (0.0 - at.left)) / (at.right - at.left)
    return np.stack([1.0 - right - third, right, third], axis=-1)


def row_response(
    segments: ContactSegments, weight: Array, rows: Array, phases: Index, *, start: Array | None = None
) -> RowResponse:
    """Forces, tangent and energy of the segments at given approaches of the rows.

    Parameters
    ----------
    weight : (T, n, 3) as of `row_weights`.  rows : (t, 3) approaches [m] at phases (t,).  start : (t, n) own approaches
        of a near call [m].
    """
    c, valid = weight[phases], segments.valid[phases]
    gap = np.where(valid, segments.gap[phases] - np.matmul(c, rows[:, :, None])[:, :, 0], 0.0)
    zero = np.zeros(len(phases))
    if segments.line is None:
        found = solve_linear(segments.compliance, gap, valid, None, approach=zero, phase=phases)
        return _response(segments, c, found, None, phases)
    found = solve_hertzian(
        segments.compliance,
        gap,
        valid,
        None,
        lambda u, i: segments.law(u, phases[i]),
        approach=zero,
        start=start,
        phase=phases,
    )
    own = -gap - products(segments.compliance, phases, found.force)
    return _response(segments, c, found, own, phases)


def _response(
    segments: ContactSegments, c: Array, found: ContactSolution, own: Array | None, phases: Index
) -> RowResponse:
    """Forces, tangent and energy of the rows from the solution of the segments.

    c : (t, n, 3) [1].  own : (t, n) own approaches [m], None with a linear law.  phases : (t,).
    """
    P, on = found.force, found.active
    shared = 0.5 * (P * products(segments.compliance, phases, P)).sum(axis=1)
    if own is None:
        matrix = np.where(on[:, :, None] & on[:, None, :], segments.compliance[phases], np.eye(on.shape[1]))
        held = np.where(on[:, :, None], c, 0.0)
        tangent = np.matmul(held.transpose(0, 2, 1), solved(matrix, held))
        energy, state = shared, np.zeros_like(P)
    else:
        root = np.sqrt(np.where(on, segments.law(own, phases)[1], 0.0))
        held = root[:, :, None] * c
        tangent = np.matmul(held.transpose(0, 2, 1), scaled_solution(segments.compliance, phases, root, held))
        energy, state = shared + _own_energy(segments, P, own, phases), own
    return RowResponse(
        force=np.matmul(c.transpose(0, 2, 1), P[:, :, None])[:, :, 0],
        tangent=tangent,
        energy=energy,
        segment=P,
        own=state,
        residual=found.residual,
    )


def _own_energy(segments: ContactSegments, force: Array, own: Array, phases: Index) -> Array:
    """Energy sum P u - int u dP of the line contacts themselves, (t,) [J]; force : (t, n) [N], own : (t, n) [m]."""
    contact, length = segments.contact, segments.length[phases]
    line = gear_pair.LineContact(A=contact.A, B=contact.B[phases], radius=contact.radius[phases])
    p = np.where(force > 0, force / length, 1.0)
    complement = line.A * p**2 * ((line.B - np.log(p)) / 2 + 0.25)
    return np.asarray(np.where(force > 0, force * own - length * complement, 0.0).sum(axis=1))
