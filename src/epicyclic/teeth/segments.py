"""Segments of the contact lines of a pair, and their contact as a potential of three rows.

Displacement along the normal of a segment i under forces P_k of all segments in mesh:

    own approach u_i(P_i/l_i) of the two flanks [weber1953]
    + sum over both gears: [b_ik + r_ik] G(zeta_i, zeta_k) P_k + s P_k/L

b is the compliance of the tooth itself, (b_i b_k)^1/2 along one tooth, none between two.  r is the compliance of the
gear body, cross terms between teeth included, without the winding s that all teeth share over the length L of the face.
G couples places along the face.  With b, r and G the compliance is symmetric positive definite.  Derived here.

A segment is a whole slice of the face, or the part of one that is on the path of contact.  Along the face the
deflection is known as means over even cells, several to a slice.  The parabola with the means of a cell and of its
neighbours gives the mean over any part of the cell, to third order in its width (derived here).  With the weights W of
that mean, W C W' is the compliance between parts: W takes displacement to the parts and, transposed, their loads to
the cells with the same work, resultant and moment.  It is as positive as C, and exact for whole slices.

Their contact is one convex potential of the approaches of three rows of the plane of action.  The approach of a segment
is linear over the plane: w = c . y, with y the approaches at both ends of the face and at one
place along the line of action.  The loads P >= 0 of the segments maximise (derived here)

    Phi(y) = (c y - g) . P - P . C P/2 - sum int u_i dP_i

so that c' P is the gradient of Phi, and c' (C + du/dP)^-1 c over the loaded segments its derivative.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import gear_pair
from .compliance import columns_of_teeth, face_coupling
from .contact_solver import ContactSolution, products, scaled_solution, solve_hertzian, solve_linear, solved
from .form import lead_modification, profile_modification
from .gear_pair import ContactPair, ElasticTooth, check_pair
from .path_of_contact import Array, ContactLines, Index, PlaneOfAction, contact_lines, corner_reach, tip_separation

CELLS = 4  # of each slice
# a shorter part, in cells, is as good as a point: its own length would round
_POINT = 1e-9
# Corner contact is considered up to this separation of tip and flank, in modules of the base pitch: far above the
# deflection of teeth.
_CORNER = 0.02
# Largest load of a line that an estimate starts from, of the one at which the approach is largest: there the stiffness
# is without bound and Newton's method does not move; half is above what any tooth bears.
_OF_LARGEST = 0.5


# parts of slices -----------------------------------------------------------------------------------------------------


def part_weights(middle: Array, length: Array, count: int) -> Array:
    """Weights (..., C) [1] of the means over C cells in the mean over a part of the face.

    Parameters
    ----------
    middle, length : (...) of the part, from the left end of the face, in widths of a cell [1].  count : C.
    """
    half = 0.5 * np.maximum(length, _POINT)
    middle = np.clip(middle, half, count - half)
    cell = np.arange(count, dtype=float)
    start = np.maximum((middle - half)[..., None], cell)
    end = np.minimum((middle + half)[..., None], cell + 1)
    share = np.maximum(end - start, 0.0)
    offset = np.where(share > 0, 0.5 * (start + end) - cell - 0.5, 0.0)
    share = share / share.sum(axis=-1, keepdims=True)
    return _of_cells(share, offset, np.maximum(end - start, 0.0))


def _of_cells(share: Array, offset: Array, length: Array) -> Array:
    """Weights of the cells and their neighbours.

    share : (..., C) of the part in each cell [1].  offset, length : (..., C) of the middle of that piece from the
    middle of the cell, and its length, in widths of a cell [1].
    """
    curved = 0.5 * (offset**2 + (length**2 - 1.0) / 12)
    weight = share * (1.0 - 2.0 * curved)
    before, behind = share * (curved - 0.5 * offset), share * (curved + 0.5 * offset)
    # at a free end the curvature vanishes (`compliance`): the cell beyond continues the slope of the last two
    weight[..., :-1] += before[..., 1:]
    weight[..., 0] += 2 * before[..., 0]
    weight[..., 1] -= before[..., 0]
    weight[..., 1:] += behind[..., :-1]
    weight[..., -1] += 2 * behind[..., -1]
    weight[..., -2] -= behind[..., -1]
    return weight


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceParts:
    """Parts of K slices at T phases, n in each: nearly all are whole slices, so few differ.

    slices : K.  weight : (R, C) of the cells in every different part [1], the K whole slices first.  row : (T, n) of
    each part among those.  column : (T, m) indices among the n of the parts that are cut, padded with n.
    """

    slices: int
    weight: Array
    row: Index
    column: Index


def face_parts(slices: int, place: Index, middle: Array, length: Array) -> FaceParts:
    """Parts of the slices of a face.

    Parameters
    ----------
    slices : K.  place : (T, n) slice of each part.  middle, length : (T, n) of the part, from the left end of the face,
        in widths of a cell [1]; a length of zero is none, and counts as a whole slice.
    """
    cells = slices * CELLS
    cut = (length > 0) & (length < CELLS - _POINT)
    edge = CELLS * (np.arange(slices) + 0.5)
    middles, lengths = np.append(edge, middle[cut]), np.append(np.full(slices, float(CELLS)), length[cut])
    row = place.astype(np.int64)
    row[cut] = slices + np.arange(int(cut.sum()))
    most = int(cut.sum(axis=1).max(initial=0))
    column = np.argsort(~cut, axis=1, kind="stable")[:, :most]
    column = np.where(np.take_along_axis(cut, column, axis=1), column, place.shape[1])
    return FaceParts(slices=slices, weight=part_weights(middles, lengths, cells), row=row, column=column)


def between_parts(coupling: Array, parts: FaceParts) -> Iterator[Array]:
    """Coupling (n, n) between the parts of each phase in turn, W C W' of that between cells (C, C), in its unit."""
    K, n = parts.slices, parts.row.shape[1]
    moved = parts.weight @ coupling
    # of every different part with the whole slices, which are nearly all
    sliced = moved @ parts.weight[:K].T
    for row, column in zip(parts.row, parts.column, strict=True):
        between = np.take(sliced[row], np.minimum(row, K - 1), axis=1)
        at = column[column < n]
        if at.size:
            between[:, at] = between[at].T
            between[np.ix_(at, at)] = moved[row[at]] @ parts.weight[row[at]].T
        yield between


# segments ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactSegments:
    """Segments on the path of contact at T phases, n at most in one of them; entries outside `valid` are padding.

    sigma : (T,) of the phases [base pitches].  lines : all segments, (T, J, K).  index : (T, n) of a segment among
    those J K.  valid : (T, n).  zeta, length : (T, n) [m].  gap : (T, n) initial gap, material missing [m].
    compliance : (T, n, n) shared between segments [m/N]; with a linear contact law the whole of it.  line : line
    contact of every segment, None where it is linear.  contact : line contact of every segment, for pressures.
    """

    pair: ContactPair
    sigma: Array
    lines: ContactLines
    index: Index
    valid: NDArray[np.bool_]
    zeta: Array
    length: Array
    gap: Array
    compliance: Array
    line: gear_pair.LineContact | None
    contact: gear_pair.LineContact

    @property
    def no_load(self) -> Array:
        """Approach at first touch, (T,) [m]."""
        return np.asarray(np.where(self.valid, self.gap, np.inf).min(axis=1))

    def law(self, approach: Array, phases: Index) -> tuple[Array, Array]:
        """Force (t, n) [N] and slope (t, n) [N/m] of the line contacts at own approaches (t, n) [m], phases (t,)."""
        p, slope = gear_pair.load(self.contact.at(phases), approach)
        return p * self.length[phases], slope * self.length[phases]

    def own_approach(self, force: Array, phases: Index) -> Array:
        """Own approach (t, n) [m] of the line contacts under forces (t, n) > 0 [N] at phases (t,): inverse of `law`.

        Beyond half the load per length at which that of [weber1953] is largest it is that of the half.
        """
        line = self.contact.at(phases)
        most = _OF_LARGEST * gear_pair.largest_load(line)
        return gear_pair.approach(line, np.minimum(force / self.length[phases], most))

    def spread(self, values: Array) -> Array:
        """Values (..., T, n) of the segments spread over all lines, (..., T, J, K); 0 elsewhere."""
        shape = self.lines.length.shape
        flat = np.zeros((*values.shape[:-1], shape[1] * shape[2] + 1))
        at = np.where(self.valid, self.index, shape[1] * shape[2])
        np.put_along_axis(flat, np.broadcast_to(at, values.shape), np.where(self.valid, values, 0.0), axis=-1)
        return flat[..., :-1].reshape(*values.shape[:-1], shape[1], shape[2])


def _at_segments(index: Index, values: Array) -> Array:
    """Values (T, J, K) on all lines at the segments of an index (T, n), (T, n)."""
    return np.take_along_axis(values.reshape(len(index), -1), index, axis=1)


def contact_segments(pair: ContactPair, sigma: ArrayLike) -> ContactSegments:
    """Segments of a pair at places (T,) of one pair of teeth at mid-face [base pitches].

    Raises
    ------
    ModelError : what cannot be built or does not mesh, see `check_pair`.
    """
    check_pair(pair)
    beyond = corner_reach(pair.plane, _CORNER * pair.plane.base_pitch / math.pi) if pair.corner else (0.0, 0.0)
    lines = contact_lines(pair.plane, sigma, pair.slices, beyond=beyond)
    # segments on the path of contact, padded to their largest number in a phase
    touched = (lines.length > 0).reshape(len(lines.length), -1)
    most = max(1, int(touched.sum(axis=1).max()))
    index = np.argsort(~touched, axis=1, kind="stable")[:, :most]
    valid = np.take_along_axis(touched, index, axis=1)

    place, zeta = _at_segments(index, lines.sigma), _at_segments(index, lines.zeta)
    length = np.where(valid, _at_segments(index, lines.length), 1.0)
    contact = _contact(pair, place)
    compliance = _shared_compliance(pair, lines, index, place)
    if pair.linear_at is not None:
        n = index.shape[1]
        secant = contact.A * (contact.B - math.log(pair.linear_at))
        compliance[:, np.arange(n), np.arange(n)] += secant / length
    return ContactSegments(
        pair=pair,
        sigma=np.atleast_1d(np.asarray(sigma, dtype=float)),
        lines=lines,
        index=index,
        valid=valid,
        zeta=zeta,
        length=length,
        gap=np.where(valid, _at_segments(index, initial_gap(pair, lines)), 0.0),
        compliance=compliance,
        line=contact if pair.linear_at is None else None,
        contact=contact,
    )


def microgeometry_gaps(segments: ContactSegments, pairs: Sequence[ContactPair]) -> Array:
    """Initial gaps (S, T, n) [m] at the places of segments, of pairs (S,) that differ in these alone: micro-geometry,
    misalignment, given gaps.

    Raises
    ------
    ModelError : as of `check_pair`.
    """
    lines, index = segments.lines, segments.index
    number = np.take_along_axis(lines.pair, index // lines.length.shape[2], axis=1)
    sigma, zeta = _at_segments(index, lines.sigma), _at_segments(index, lines.zeta)
    places = _places(segments.pair.plane, sigma, zeta, number)
    gaps = np.empty((len(pairs), *segments.gap.shape))
    for i, pair in enumerate(pairs):
        check_pair(pair)
        gaps[i] = np.where(segments.valid, _gap_at(pair, places), 0.0)
    return gaps


def _contact(pair: ContactPair, place: Array) -> gear_pair.LineContact:
    """Line contact at places (T, n) on the path of contact [base pitches] [weber1953]."""
    plane = pair.plane
    on = np.clip(place, *plane.limits)
    return gear_pair.line_contact(
        plane.curvature_radius(on),
        pair.tooth_a.depth(plane.radius_a(on)),
        pair.tooth_b.depth(plane.radius_b(on)),
        youngs_modulus=pair.youngs_modulus,
        poisson=pair.poisson,
    )


def _shared_compliance(pair: ContactPair, lines: ContactLines, index: Index, place: Array) -> Array:
    """Shared compliance of tooth, body and twist between segments, (T, n, n) [m/N]; place : (T, n) [base pitches]."""
    plane, count = pair.plane, lines.length.shape[2]
    slant = math.cos(plane.base_helix)
    on = np.clip(place, *plane.limits)
    tooth = index // count
    # parts of the slices that are on the path, in cells of the face
    cell = lines.span / CELLS
    zeta, length = _at_segments(index, lines.zeta), _at_segments(index, lines.length) * slant
    parts = face_parts(count, index % count, (zeta - lines.centre[0] + 0.5 * lines.span) / cell, length / cell)
    whole = np.zeros((*index.shape, index.shape[1]))
    for gear, face, radius, number in (
        (pair.tooth_a, plane.face_a, plane.radius_a(on), tooth),
        (pair.tooth_b, plane.face_b, plane.radius_b(on), tooth.max() - tooth),
    ):
        kernel = cell_coupling(plane, gear, face, count * CELLS)
        left, right = _plane_factors(gear, radius, number)
        for t, coupled in enumerate(between_parts(kernel, parts)):  # by phases: (n, n) stays in the cache
            plane_compliance = left[t] @ right[t].T
            plane_compliance -= gear.shared
            coupled *= plane_compliance
            whole[t] += coupled
        whole += gear.shared * slant / (face[1] - face[0])
    twist = _twisted(pair, plane.cells(count * CELLS))
    if twist is not None:
        for matrix, coupled in zip(whole, between_parts(twist, parts), strict=True):
            matrix += coupled
    return whole


def cell_coupling(plane: PlaneOfAction, gear: ElasticTooth, face: tuple[float, float], count: int) -> Array:
    """Coupling of even cells of the common face through one gear, along its teeth, (count, count) [1/m].

    face : left and right end of the face of the gear itself [m].
    """
    slant = math.cos(plane.base_helix)
    width, middle = (face[1] - face[0]) / slant, (plane.cells(count) - 0.5 * (face[0] + face[1])) / slant
    return face_coupling(middle, width, gear.face_decay(width), np.full(count, plane.width / count / slant))


def _plane_factors(gear: ElasticTooth, radius: Array, tooth: Index) -> tuple[Array, Array]:
    """Compliance of tooth and body in one plane with the winding, A B' (T, n, n) [m^2/N], in factors A, B (T, n, r).

    radius : (T, n) of the segments [m].  tooth : (T, n) as of `body_factors`.
    """
    loads, roots = gear.body_factors(radius, tooth)
    moved = loads @ roots
    # at the root of a ring no tooth remains between the load and the body
    beam = np.sqrt(np.maximum(gear.bending(radius) - (moved * loads).sum(axis=2), 0.0))
    own = columns_of_teeth(beam[..., None], tooth)
    return np.concatenate([moved, own], axis=2), np.concatenate([loads, own], axis=2)


def _twisted(pair: ContactPair, centre: Array) -> Array | None:
    """Compliance of cells of the face by the twist of both bodies, (C, C) [m/N]; None where both are rigid."""
    plane, whole = pair.plane, None
    for torsion, face, base in (
        (pair.torsion_a, plane.face_a, plane.base_a),
        (pair.torsion_b, plane.face_b, plane.base_b),
    ):
        if torsion is None:
            continue
        away = centre - face[0] if torsion.end == "left" else face[1] - centre
        lever = (base * math.cos(plane.base_helix)) ** 2 / torsion.rigidity
        twist = lever * np.minimum(away[:, None], away[None, :])
        whole = twist if whole is None else whole + twist
    return whole


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Places:
    """Places on the flanks, of any shape (...): what every micro-geometry of a pair needs of them.

    sigma : on the path of contact [base pitches].  zeta : along the face [m].  number : of the pair of teeth.
    heights : below the tip and above the root of each gear [m].
    """

    sigma: Array
    zeta: Array
    number: Index
    heights: tuple[tuple[Array, Array], tuple[Array, Array]]


def _places(plane: PlaneOfAction, sigma: Array, zeta: Array, number: Index) -> _Places:
    on = np.clip(sigma, *plane.limits)
    low, high = plane.limits
    a, b = plane.radius_a(on), plane.radius_b(on)
    return _Places(
        sigma=sigma,
        zeta=zeta,
        number=number,
        heights=(
            (np.abs(a - plane.radius_a(high)), np.abs(a - plane.radius_a(low))),
            (np.abs(b - plane.radius_b(low)), np.abs(b - plane.radius_b(high))),
        ),
    )


def initial_gap(pair: ContactPair, lines: ContactLines) -> Array:
    """Initial gap between the flanks (T, J, K) [m]: micro-geometry of both, misalignment, given gaps, corner."""
    number = np.broadcast_to(lines.pair[:, :, None], lines.sigma.shape)
    return _gap_at(pair, _places(pair.plane, lines.sigma, lines.zeta, number))


def _gap_at(pair: ContactPair, at: _Places) -> Array:
    """Initial gap (...) [m] at places, as of `initial_gap`."""
    plane = pair.plane
    total = pair.misalignment * at.zeta
    if pair.corner:
        total = total + tip_separation(plane, at.sigma)
    if pair.gap:
        total = total + np.interp(at.zeta, *np.array(pair.gap).T)
    if pair.pair_gaps:
        total = total + np.array(pair.pair_gaps)[np.clip(at.number - pair.first_pair, 0, len(pair.pair_gaps) - 1)]
    if pair.waves:
        sigma = at.sigma + at.number - plane.per_pitch * at.zeta  # of the phase, at mid-face
        for wave in pair.waves:
            total = total + wave.amplitude * np.cos(2 * np.pi * wave.order * sigma + wave.phase)
    for flank, gear in ((pair.flank_a, 0), (pair.flank_b, 1)):
        below_tip, above_root = at.heights[gear]
        total = total + profile_modification(flank, below_tip=below_tip, above_root=above_root, sigma=at.sigma)
        total = total + lead_modification(flank, at.zeta, (plane.face_a, plane.face_b)[gear])
        if flank.pitch:
            total = total + np.asarray(flank.pitch)[at.number % pair.teeth[gear]]
    return np.asarray(total)


# potential of three rows ---------------------------------------------------------------------------------------------


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
    along = _at_segments(segments.index, segments.lines.sigma)
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
    model = (segments.compliance, gap, valid, None)
    if segments.line is None:
        return _response(segments, c, solve_linear(*model, approach=zero, phase=phases), None, phases)
    solution = solve_hertzian(*model, lambda u, i: segments.law(u, phases[i]), approach=zero, start=start, phase=phases)
    own = -gap - products(segments.compliance, phases, solution.force)
    return _response(segments, c, solution, own, phases)


def _response(
    segments: ContactSegments, c: Array, solution: ContactSolution, own: Array | None, phases: Index
) -> RowResponse:
    """Forces, tangent and energy of the rows from the solution of the segments.

    c : (t, n, 3) [1].  own : (t, n) own approaches [m], None with a linear law.  phases : (t,).
    """
    P, on = solution.force, solution.active
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
        residual=solution.residual,
    )


def _own_energy(segments: ContactSegments, force: Array, own: Array, phases: Index) -> Array:
    """Energy sum P u - int u dP of the line contacts themselves, (t,) [J]; force : (t, n) [N], own : (t, n) [m]."""
    line, length = segments.contact.at(phases), segments.length[phases]
    p = np.where(force > 0, force / length, 1.0)
    complement = line.A * p**2 * ((line.B - np.log(p)) / 2 + 0.25)
    return np.asarray(np.where(force > 0, force * own - length * complement, 0.0).sum(axis=1))
