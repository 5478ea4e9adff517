"""Stress in the tooth roots of both gears of a loaded contact, by an influence function of finite elements.

The influence function is the stress along the fillets of the teeth of a gear under a load on a flank.  One pitch of the
normal section, from a tooth space to the next, is meshed once: tooth, fillets and the body down to where it is held, in
plane strain as the compliance of the teeth.  The elements are Lagrange's biquadratic ones of nine nodes on structured
grids, with Gauss' rule of 3 x 3 points.  Young's modulus is 1: stresses under given forces do not depend on it,
displacements are inverse to it.  Inner nodes are condensed into those of both sides.  All pitches of the gear are
equal, so that the discrete Fourier transform over them separates the whole gear into single pitches with a phase
between their sides: the answer is that of the whole gear, every tooth of it meshed.  A helical tooth is that of its
virtual gear, the number of teeth rounded to close the circle.

On a free surface the stress along it is the whole stress, E/(1 - nu^2) times the strain along it.  The strain is taken
at Gauss' two points of each edge, where that of a quadratic element is exact to one order more [barlow1976].  Bending,
compression, notch and neighbouring teeth are all in it, and nothing is fitted.  The method is derived here.

Along the path of contact and over the face every slice of a tooth is a plane tooth with the influence function of its
gear; the forces on all teeth act on it together.  Along the face a force reaches the root as it bends the tooth: with
the kernel G of `compliance`, whose integral is 1, so that an even load has the plane stress.  Derived here:

    stress_jk = sum over teeth j', slices k' of G(k, k') P_j'k' I(place on the fillet; radius_j'k', j' - j)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import splu

from .form import GearForm, Outline, tooth_outline
from .gear_pair import ContactPair, meshed_teeth
from .segments import cell_coupling

Array = NDArray[np.float64]
Index = NDArray[np.int64]

REACH = 4
"""Pitches over which a load reaches fillets, as of `compliance.NEIGHBOURS`; teeth in contact together are nearer."""
_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(3)
# Elements along a flank, along a fillet down to the corner and on to the middle of the space, across a tooth, down the
# body.  Twice as many everywhere move the largest stress by less than 0.3 % (docs/theory/contact.md, Root stress).
_FLANK, _FILLET, _SPACE, _ACROSS, _BODY = 12, 10, 8, 14, 12
# The cross line between tooth and body stands where the fillet leans by this much, so that it divides the angle between
# flank and floor of the space about evenly.
_CORNER = math.radians(45)
# Half the width of the pressure on the flank [modules], and points of it: the elements resolve it, Hertz's is narrower.
# Beyond it the contact itself stresses no surface, below it the surface is compressed.
_PRESSED, _PRESSURES = 0.1, 24
# Nearest load to the end of the flank [modules]; a nearer one counts as there.  Its pressure would reach the fillet,
# whose stress is then that of contact.  A load further up stresses the root more.
_NEAREST = 0.25
_LOADS = 14  # radii of the load, Chebyshev's; a cubic spline between them is exact to 0.1 %
_POINTS = 48  # of each fillet, evenly along it: the largest of a smooth maximum within 0.1 %
# Singular values below this part of the largest are below what the elements are exact to.
_RANK = 1e-4
_EDGE = np.array([-1.0, 1.0]) / math.sqrt(3.0)
# Numbers held at a time, 32 MB: far below what the compliance of a contact takes.
_HELD = 4_000_000


# finite elements -----------------------------------------------------------------------------------------------------


def grid_cells(numbers: Index) -> Index:
    """Cells (m, 9) of a grid of node numbers (2 a + 1, 2 b + 1), nodes of a cell row by row."""
    rows, columns = numbers.shape
    at = [numbers[i : rows - 2 + i : 2, j : columns - 2 + j : 2].ravel() for i in range(3) for j in range(3)]
    return np.stack(at, axis=1)


def merged_nodes(points: Array, apart: float) -> tuple[Array, Index]:
    """Points (k, 2) of which no two are nearer than `apart`, and the number (n,) among them of each of (n, 2) [m]."""
    from scipy.spatial import cKDTree  # heavy, and needed where grids meet alone

    target = np.arange(len(points))
    for i, j in sorted(cKDTree(points).query_pairs(apart)):
        target[j] = target[i]
    kept, number = np.unique(target, return_inverse=True)
    return points[kept], number.astype(np.int64)


def edge_values(place: Array) -> tuple[Array, Array]:
    """Shape functions of an edge of three nodes and their derivatives, (..., 3) each, at places (...) in -1 .. 1."""
    t = np.asarray(place, dtype=float)
    value = np.stack([0.5 * t * (t - 1), 1 - t**2, 0.5 * t * (t + 1)], axis=-1)
    slope = np.stack([t - 0.5, -2 * t, t + 0.5], axis=-1)
    return value, slope


def stiffness_matrix(points: Array, cells: Index, poisson: float) -> sparse.csc_matrix:
    """Stiffness (2 n, 2 n) of unit thickness in plane strain with E = 1; unknowns x and y of each node in turn [1].

    points : (n, 2) [m].  cells : (m, 9) of `grid_cells`.  poisson : [1].
    """
    value, slope = edge_values(_GAUSS)
    # shape functions are products of those of an edge, rows first
    by_row = np.einsum("ai,bj->abij", slope, value).reshape(9, 9)
    by_column = np.einsum("ai,bj->abij", value, slope).reshape(9, 9)
    local = np.stack([by_row, by_column])  # (direction, Gauss point, node)
    weight = np.outer(_WEIGHTS, _WEIGHTS).ravel()
    jacobian = np.einsum("dgn,mnx->mgdx", local, points[cells])
    size = jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0]
    gradient = np.linalg.solve(jacobian, np.broadcast_to(local.transpose(1, 0, 2), (*jacobian.shape[:2], 2, 9)))
    factor = 1 / ((1 + poisson) * (1 - 2 * poisson))
    D = factor * np.array([[1 - poisson, poisson, 0], [poisson, 1 - poisson, 0], [0, 0, 0.5 - poisson]])
    B = np.zeros((*jacobian.shape[:2], 3, 18))
    B[..., 0, 0::2] = B[..., 2, 1::2] = gradient[..., 0, :]
    B[..., 1, 1::2] = B[..., 2, 0::2] = gradient[..., 1, :]
    of_cells = np.einsum("mgai,ab,mgbj,mg->mij", B, D, B, np.abs(size) * weight, optimize=True)
    freedom = (2 * cells[:, :, None] + np.arange(2)).reshape(len(cells), 18)
    row, column = np.repeat(freedom, 18, axis=1).ravel(), np.tile(freedom, (1, 18)).ravel()
    count = 2 * len(points)
    return sparse.csc_matrix((of_cells.ravel(), (row, column)), shape=(count, count))


# influence function --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RootInfluence:
    """Stress along both fillets of a tooth per load per length of contact line on a flank of it or of another tooth.

    The loaded flank of every tooth is that of its first fillet.

    points : (P,) length along a fillet, from the end of the flank to the middle of the tooth space [m].
    lean : (P,) angle of the tangent of the fillet there against the middle line of the tooth [rad].
    shape : (2, P, R) of R modes of stress along both fillets [1].  table : spline over the radius of the load on the
        gear itself [m] -> (2 REACH + 1, R) amounts of the modes per load [1/m], of a load on the tooth itself in the
        middle, on teeth ahead (clockwise, on the side that the loaded flanks face) after it.
    limits : least and largest radius of the load [m]; beyond them the value at the end.
    """

    points: Array
    lean: Array
    shape: Array
    table: CubicSpline
    limits: tuple[float, float]

    def amounts(self, radius: ArrayLike) -> Array:
        """Amounts of the modes (..., 2 REACH + 1, R) [1/m] of loads at radii (...) [m]."""
        amounts = self.table(np.clip(radius, *self.limits))
        return np.asarray(amounts).reshape(*np.shape(radius), 2 * REACH + 1, -1)


def fillet_stress(influence: RootInfluence, radius: ArrayLike, *, ahead: int = 0) -> Array:
    """Stress (..., 2, P) [1/m] along the fillets of a tooth per load per length at radii (...) [m].

    First the fillet of the loaded flank, positive in tension.  ahead : pitches by which the loaded tooth is ahead.
    """
    return np.asarray(np.einsum("spm,...m->...sp", influence.shape, influence.amounts(radius)[..., REACH + ahead, :]))


@lru_cache(maxsize=32)
def root_influence(gear: GearForm, *, path: str = "", refined: int = 1) -> RootInfluence:
    """Influence function of the stress in the tooth roots of a gear.

    path : of the gear in the model file, for the message.  refined : factor of the number of elements each way.

    Raises
    ------
    ModelError : pointed or undercut teeth, no body under them (see `outline.tooth_outline`).
    """
    outline = tooth_outline(gear, path=path)
    held = gear.bore * outline.root / gear.root
    mesh = _pitch_mesh(outline, held, refined)
    inward = 1.0 if outline.internal else -1.0
    low, high = sorted((outline.form_radius - inward * _NEAREST * gear.module, outline.tip))
    radius = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(np.pi * (np.arange(_LOADS) + 0.5) / _LOADS)
    radius = np.concatenate([[low], radius, [high]])
    force = np.stack([_normal_load(mesh, outline, float(r), _PRESSED * gear.module) for r in radius], axis=1)
    raw, place, lean = _gear_stress(mesh, force, gear.poisson, max(3, round(gear.virtual_teeth)))
    points = (np.arange(_POINTS) + 0.5) / _POINTS * mesh.length
    even = CubicSpline(place, raw, axis=2)(points)  # (tooth, fillet, P, load)
    modes = even.transpose(1, 2, 3, 0).reshape(2 * _POINTS, -1)
    left, size, right = np.linalg.svd(modes, full_matrices=False)
    kept = int((size > _RANK * size[0]).sum())
    amounts = (size[:kept, None] * right[:kept]).reshape(kept, len(radius), -1).transpose(1, 2, 0)
    knots = radius - gear.to_virtual
    return RootInfluence(
        points=points,
        lean=np.interp(points, place, lean),
        shape=left[:, :kept].reshape(2, _POINTS, kept),
        table=CubicSpline(knots, amounts.reshape(len(radius), -1)),
        limits=(float(knots[0]), float(knots[-1])),
    )


# mesh of one pitch ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _PitchMesh:
    """Mesh of one pitch, tooth along +y.

    points : (n, 2) [m].  cells : (m, 9).  left, right : nodes of the sides, outside in.  held : nodes at rest.
    flank : nodes of the right flank, tip to fillet.  fillets : (2, 2 e + 1) nodes of both fillets, right and left.
    length : of a fillet [m].
    """

    points: Array
    cells: Index
    left: Index
    right: Index
    held: Index
    flank: Index
    fillets: Index
    length: float


def _pitch_mesh(outline: Outline, held: float, refined: int) -> _PitchMesh:
    """Mesh of the tooth down to a cross line at its fillets, and of the body from there to the radius `held` [m]."""
    line = np.column_stack([outline.x, outline.radius * np.cos(outline.psi)])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    corner = outline.form + int(np.searchsorted(outline.slope[outline.form :], _CORNER))
    corner = min(corner, len(along) - 2)
    flank, fillet, space, across, body = (refined * n for n in (_FLANK, _FILLET, _SPACE, _ACROSS, _BODY))
    first = along[outline.form]
    down = np.concatenate(
        [
            _middles(first * (1 - _growing(flank, first, (along[corner] - first) / fillet)[::-1])),
            _middles(np.linspace(first, along[corner], fillet + 1))[1:],
        ]
    )
    floor = _middles(np.linspace(along[corner], along[-1], space + 1))

    def at(marks: Array) -> Array:
        return np.column_stack([np.interp(marks, along, line[:, axis]) for axis in (0, 1)])

    side, bottom = at(down), at(floor)
    # fine below the surface, where the notch raises the stress
    steps = _growing(across // 2, line[corner, 0], (along[corner] - first) / fillet)
    columns = _middles(np.concatenate([steps - 1, 1 - steps[-2::-1]]))
    tooth = np.stack([side[:, None, 0] * columns, np.broadcast_to(side[:, None, 1], (len(side), len(columns)))], -1)
    tip = np.sqrt(outline.tip**2 - (side[0, 0] * columns) ** 2) - side[0, 1]
    tooth[..., 1] += tip * np.maximum(0.0, 1 - down / down[2 * flank])[:, None] ** 2
    top = np.concatenate([bottom[:0:-1] * [-1, 1], tooth[-1], bottom[1:]])
    start, angle = np.hypot(*top.T), np.arctan2(top[:, 0], top[:, 1])
    even = angle[-1] * np.linspace(-1, 1, len(angle))
    grade = _middles(_growing(body, abs(held - start.min()), (along[-1] - along[corner]) / space))
    share = np.minimum(1.0, 2 * grade)[:, None]
    radius, theta = start + grade[:, None] * (held - start), (1 - share) * angle + share * (0.3 * angle + 0.7 * even)
    ring = np.stack([radius * np.sin(theta), radius * np.cos(theta)], axis=-1)
    points, number = merged_nodes(np.concatenate([tooth.reshape(-1, 2), ring.reshape(-1, 2)]), 1e-9 * outline.tip)
    upper = number[: tooth.size // 2].reshape(tooth.shape[:2])
    lower = number[tooth.size // 2 :].reshape(ring.shape[:2])
    count, reach = 2 * flank, len(bottom) - 1
    return _PitchMesh(
        points=points,
        cells=np.concatenate([grid_cells(upper), grid_cells(lower)]),
        left=lower[:-1, 0],
        right=lower[:-1, -1],
        held=lower[-1],
        flank=upper[: count + 1, -1],
        fillets=np.stack(
            [
                np.concatenate([upper[count:, -1], lower[0, -reach:]]),
                np.concatenate([upper[count:, 0], lower[0, reach - 1 :: -1]]),
            ]
        ),
        length=float(along[-1] - first),
    )


def _growing(count: int, length: float, first: float) -> Array:
    """Shares (count + 1,) of a length [m], 0 to 1, elements growing or shrinking evenly from the first [m]."""
    from scipy.optimize import brentq

    power = np.arange(count)

    def missing(ratio: float) -> float:
        return float(first * (ratio**power).sum() - length)

    ratio = brentq(missing, 0.2, 5.0) if missing(0.2) < 0 < missing(5.0) else 1.0
    ends = np.concatenate([[0.0], np.cumsum(ratio**power)])
    return np.asarray(ends / ends[-1])


def _middles(ends: Array) -> Array:
    """Ends of elements with the middle of each between them."""
    places = np.empty(2 * len(ends) - 1)
    places[::2], places[1::2] = ends, 0.5 * (ends[1:] + ends[:-1])
    return places


def _normal_load(mesh: _PitchMesh, outline: Outline, radius: float, half: float) -> Array:
    """Nodal forces (2 n,) of 1 N per length along the normal of the right flank at a radius of the virtual gear [m].

    half : half the width of its elliptic pressure [m].
    """
    nodes = np.concatenate([mesh.flank, mesh.fillets[0, 1:]])
    line = mesh.points[nodes]
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    sense = 1.0 if outline.internal else -1.0
    count = len(mesh.flank)
    centre = float(np.interp(sense * radius, sense * np.hypot(*line[:count].T), along[:count]))
    angle = (np.arange(_PRESSURES) + 0.5) * np.pi / _PRESSURES
    share = np.sin(angle) ** 2 / np.sum(np.sin(angle) ** 2)
    # at the tip the pressure stays on the flank
    place = np.interp(np.maximum(centre - half * np.cos(angle), 0.0), along, np.arange(len(nodes), dtype=float))
    first = np.minimum(2 * (place // 2).astype(np.int64), len(nodes) - 3)
    value = share[:, None] * edge_values(place - first - 1.0)[0]
    gamma = float(outline.flank_angle(np.array([radius]))[1][0])
    force = np.zeros((len(mesh.points), 2))
    at = nodes[first[:, None] + np.arange(3)]
    np.add.at(force, at, value[..., None] * np.array([-math.cos(gamma), sense * math.sin(gamma)]))
    return force.ravel()


# the whole gear ------------------------------------------------------------------------------------------------------


def _gear_stress(mesh: _PitchMesh, force: Array, poisson: float, teeth: int) -> tuple[Array, Array, Array]:
    """Stress along both fillets per load, (2 REACH + 1, 2, p, loads) [1/m], at lengths (p,) [m] and leans (p,) [rad].

    force : (2 n, loads) on one tooth.  teeth : of the gear, all in the answer.
    """
    strain, place, lean = _fillet_strain(mesh)
    axes = _side_axes(mesh)
    K = (axes.T @ stiffness_matrix(mesh.points, mesh.cells, poisson) @ axes).tocsc()
    stress = (strain @ axes) / (1 - poisson**2)
    m = 2 * len(mesh.left)
    sides = np.concatenate([_freedoms(mesh.left), _freedoms(mesh.right)])
    inner = np.setdiff1d(np.arange(K.shape[0]), np.concatenate([sides, _freedoms(mesh.held)]))
    coupled = K[np.ix_(inner, sides)]
    solved = splu(K[np.ix_(inner, inner)].tocsc()).solve(np.column_stack([coupled.toarray(), force[inner]]))
    by_side, by_load = solved[:, : 2 * m], solved[:, 2 * m :]
    S = K[np.ix_(sides, sides)].toarray() - coupled.T @ by_side
    f = -(coupled.T @ by_load)
    # right side of a pitch = left side of the next one clockwise
    phase = 2 * np.pi * np.arange(teeth) / teeth
    e = np.exp(1j * phase)[:, None, None]
    whole = S[:m, :m] + S[m:, m:] + e * S[:m, m:] + S[m:, :m] / e
    moved = np.linalg.solve(whole, f[:m] + f[m:] / e)
    to_stress = stress[:, sides].toarray() - stress[:, inner] @ by_side
    stresses = []
    for tooth in range(REACH, -REACH - 1, -1):  # number, clockwise from the loaded one: the load is so many behind
        turned = np.exp(1j * phase * tooth)[:, None, None]
        left, right = ((moved * turn).mean(axis=0).real for turn in (turned, turned * e))
        stresses.append(to_stress @ np.concatenate([left, right]))
    stresses[REACH] += stress[:, inner] @ by_load
    return np.array(stresses).reshape(2 * REACH + 1, 2, len(place), -1), place, lean


def _freedoms(nodes: Index) -> Index:
    return (2 * nodes[:, None] + np.arange(2)).ravel()


def _side_axes(mesh: _PitchMesh) -> sparse.csr_matrix:
    """Rotation (2 n, 2 n) of the unknowns of both sides to radial and tangential ones."""
    turn = sparse.identity(2 * len(mesh.points), format="lil")
    for node in np.concatenate([mesh.left, mesh.right]):
        sin, cos = mesh.points[node] / np.hypot(*mesh.points[node])
        turn[2 * node : 2 * node + 2, 2 * node : 2 * node + 2] = [[sin, cos], [cos, -sin]]
    return turn.tocsr()


def _fillet_strain(mesh: _PitchMesh) -> tuple[sparse.csr_matrix, Array, Array]:
    """Strain along the fillets from the motion of the nodes, (2 p, 2 n) [1/m], at lengths (p,) [m], leans (p,) [rad].

    At Gauss' two points of every edge.
    """
    slope = edge_values(_EDGE)[1]
    edges = np.stack([mesh.fillets[:, k : k + 3] for k in range(0, mesh.fillets.shape[1] - 2, 2)], axis=1)
    tangent = np.einsum("qa,feax->feqx", slope, mesh.points[edges])
    size = np.hypot(tangent[..., 0], tangent[..., 1])
    unit = tangent / size[..., None]
    value = np.einsum("qa,feq,feqx->feqax", slope, 1 / size, unit)
    count = edges.shape[1] * 2
    row = np.broadcast_to(np.arange(2 * count).reshape(2, -1, 2)[..., None, None], value.shape)
    column = np.broadcast_to((2 * edges[..., None] + np.arange(2))[:, :, None], value.shape)
    shape = (2 * count, 2 * len(mesh.points))
    strain = sparse.csr_matrix((value.ravel(), (row.ravel(), column.ravel())), shape=shape)
    length = 2 * size[0].mean(axis=1)  # of each edge: dx/dt over t = -1 .. 1
    start = np.concatenate([[0.0], np.cumsum(length)[:-1]])
    place = (start[:, None] + 0.5 * (1 + _EDGE) * length[:, None]).ravel()
    lean = np.arctan2(np.abs(unit[0, ..., 0]), np.abs(unit[0, ..., 1])).ravel()
    return strain, place, lean


# stress of a loaded contact ------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RootStress:
    """Stress in the roots of one gear: F loads, T phases, J teeth, K slices of the face.

    tension : (F, T, J, K) largest along the fillet below the loaded flank [Pa].  compression : (F, T, J, K) least along
    the fillet of the other flank, compression negative [Pa].  lean : (F,) angle of the tangent of the fillet against
    the middle line of the tooth where the tension is largest [rad].
    """

    tension: Array
    compression: Array
    lean: Array


def pair_influences(pair: ContactPair) -> tuple[RootInfluence, RootInfluence]:
    """Influence functions of both gears of a pair as drawn.

    Raises
    ------
    ModelError : as of `root_influence`.
    """
    mesh = meshed_teeth(pair)
    return root_influence(mesh.a.gear), root_influence(mesh.b.gear)


def root_stress(
    pair: ContactPair, sigma: Array, force: Array, influences: tuple[RootInfluence, RootInfluence]
) -> tuple[RootStress, RootStress]:
    """Stress in the tooth roots of both gears.

    Parameters
    ----------
    sigma : (T, J, K) places on the path of contact of the slices of each tooth pair [base pitches], the pairs in the
        order in which they rise.  force : (F, T, J, K) on them along the normal [N].
    """
    plane = pair.plane
    on = np.clip(sigma, *plane.limits)
    first = _of_gear(pair, plane.radius_a(on), force, influences[0], 1)
    return first, _of_gear(pair, plane.radius_b(on), force, influences[1], -1)


def _of_gear(pair: ContactPair, radius: Array, force: Array, influence: RootInfluence, sense: int) -> RootStress:
    """Stress of one gear; radius : (T, J, K) of the loads [m].

    sense : 1 of gear a, -1 of gear b, where the next pair is one tooth behind.
    """
    plane = pair.plane
    tooth, face = (pair.tooth_a, plane.face_a) if sense > 0 else (pair.tooth_b, plane.face_b)
    # load per length on each slice per force on another (K, K) [1/m], along the tooth
    coupling = cell_coupling(plane, tooth, face, force.shape[-1])
    tension, compression = np.empty(force.shape), np.empty(force.shape)
    lean, most = np.zeros(len(force)), np.full(len(force), -np.inf)
    right, left = influence.shape
    # as many phases at a time as the numbers held allow
    each = math.prod(radius.shape[1:]) * max(right.shape[0], (2 * REACH + 1) * right.shape[1])
    step = max(1, _HELD // each)
    for begin in range(0, len(radius), step):
        phases = slice(begin, begin + step)
        amounts = influence.amounts(radius[phases])
        for i, load in enumerate(force[:, phases]):
            modes = coupling @ _on_teeth(amounts, load, sense)  # (t, J, K, R)
            along = modes @ right.T
            tension[i, phases] = along.max(axis=-1)
            compression[i, phases] = (modes @ left.T).min(axis=-1)
            place = int(along.argmax())
            if along.flat[place] > most[i]:
                most[i], lean[i] = along.flat[place], influence.lean[place % right.shape[0]]
    return RootStress(tension=tension, compression=compression, lean=lean)


def _on_teeth(amounts: Array, load: Array, sense: int) -> Array:
    """Amounts (t, J, K, R) [1/m N] of the modes of every tooth from the loads (t, J, K) [N] on all of them.

    amounts : (t, J, K, 2 REACH + 1, R) per load [1/m].
    """
    J = load.shape[1]
    on_teeth = np.zeros((*load.shape, amounts.shape[-1]))
    for moved in range(J):
        for loaded in range(max(0, moved - REACH), min(J, moved + REACH + 1)):
            ahead = REACH + sense * (loaded - moved)
            on_teeth[:, moved] += load[:, loaded, :, None] * amounts[:, loaded, :, ahead]
    return on_teeth
