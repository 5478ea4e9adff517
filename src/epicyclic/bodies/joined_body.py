"""A reduced body in a train: its reduction to interfaces, what it needs to turn, its coordinates.

Interfaces are the places where a body is held; a whole mesh is reduced to them (Craig and Bampton).  A body that turns
with its frame needs gyroscopic terms.  Of an axisymmetric one the pattern may turn against its material: D is the
derivative along the angle.  Held in a frame of speed Omega, nu = -Omega, its terms are G = 2 nu M D and Kg = nu^2 M
D^2.

Coordinates of the train are the free elastic modes beside the six of the mean motion.  Modes of the free body are
orthogonal to its rigid motions, so that mass and inertia stay those of a rigid body.  The motion of a point is that of
the interface there, u + theta x (P - P_i); of nodes that are kept each, u + G (P - P_i) with the gradient G of their
displacements as far as they tell it.  An axisymmetric body, one with D, has an interface all round: at the angle psi
its motion is Phi exp(psi D) in axes turned as much.  Derived here.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import scipy.linalg
from scipy import sparse
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from ..errors import ModelError
from .elastic_body import ElasticBody, Springs, about_z
from .reduced_body import (
    Array,
    BodyFacts,
    Index,
    Matrix,
    ReducedBody,
    dense,
    elastic_modes,
    lowest_modes,
    refused,
    rigid_motion,
    rigid_rows,
)

_SEEN = 1e-9  # of the largest singular value


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Interface:
    """Nodes that share the force at a point: by an average, stiff against each other, or kept each for itself.

    point : (3,) [m]; None is the mean of the nodes.
    """

    name: str
    nodes: tuple[int, ...]
    point: Array | None = None
    spider: Literal["average", "rigid", "nodes"] = "average"

    def place(self, body: ReducedBody) -> Array:
        """The point, (3,) [m]."""
        nodes = body.places(np.array(self.nodes)) if self.point is None else np.atleast_2d(self.point)
        return np.asarray(nodes.mean(axis=0))


def interface_shape(body: ReducedBody, interface: Interface, where: str) -> Array:
    """Motion (6, n) of the point of an interface, x y z [m], rx ry rz [rad], in the coordinates of its body.

    The mean motion of the nodes by least squares; a load at the point reaches them as its transpose says.  What the
    nodes do not see, as the rotation about the line on which all stand, is zero.

    Raises
    ------
    ModelError : no such nodes in the body.
    """
    directions, places, rows = node_rows(body, interface, where)
    seen = rigid_rows(places, directions, interface.place(body))
    # rotations as displacements at the distance of the nodes
    reach = np.linalg.norm(places - places.mean(axis=0), axis=1).max() or 1.0
    weight, size = np.where(directions > 3, reach, 1.0), np.array([1.0, 1.0, 1.0, reach, reach, reach])
    mean = np.linalg.pinv(weight[:, None] * seen / size, rcond=_SEEN) * weight / size[:, None]
    shape: Array = mean @ rows
    return shape


def node_rows(body: ReducedBody, interface: Interface, where: str) -> tuple[Index, Array, Matrix]:
    """Directions (m,), places (m, 3) and rows (m, n) of what the nodes of an interface do."""
    for one in interface.nodes:
        if one not in body.node_id:
            raise refused(where, interface.name, "no such node in the body", "its nodes", given=one)
    own = np.flatnonzero(np.isin(body.dof_node, interface.nodes) & ~body.modal)
    rows = sparse.eye_array(len(body.dof_dir), format="csr")[own]
    node, direction = body.dof_node[own], body.dof_dir[own]
    if body.shape is not None and body.shape_node is not None and body.shape_dir is not None:
        also = np.flatnonzero(np.isin(body.shape_node, interface.nodes))
        rows = sparse.vstack([rows, sparse.csr_array(body.shape[also])]).tocsr()
        node = np.concatenate([node, body.shape_node[also]])
        direction = np.concatenate([direction, body.shape_dir[also]])
    if not len(node):
        raise refused(where, interface.name, "no nodes with coordinates", "nodes of the body")
    return direction, body.places(node), rows


# --- reduction -------------------------------------------------------------------------------------------------------


def reduced(
    body: ReducedBody, interfaces: Sequence[Interface], modes: int, where: str
) -> tuple[ReducedBody, tuple[Interface, ...]]:
    """A body in the coordinates of its interfaces and of modes with these held, and the interfaces as they are there.

    body : dense or sparse matrices, coordinates at nodes.  modes : how many.
    Points of averages and rigid spiders become nodes of six coordinates, with the least numbers that are free, in the
    order of the interfaces; nodes that are kept keep theirs.  G1, KG1 and C are reduced with the same shapes.

    Raises
    ------
    ModelError : interfaces that do not hold the body, share nodes or stand on a line; more modes than there are.
    """
    names, nodes = ", ".join(one.name for one in interfaces), [node for one in interfaces for node in one.nodes]
    if body.D is not None or body.shape is not None:
        raise refused(where, names, "reduced already: D and shape would be lost", "the mesh of the body")
    if len(set(nodes)) < len(nodes):
        raise refused(where, names, "a node in two interfaces", "each node once")
    kept = {node for one in interfaces if one.spider == "nodes" for node in one.nodes}
    free = (number for number in itertools.count(1) if number not in kept)
    there = tuple(one if one.spider == "nodes" else _at_point(body, one, next(free), where) for one in interfaces)
    rows, columns, dofs = zip(*(_held(body, *pair, where) for pair in zip(interfaces, there, strict=True)), strict=True)
    constraint, motion = sparse.vstack(rows).tocsr(), sparse.block_diag(columns).tocsr()
    count, most = len(body.dof_dir), len(body.dof_dir) - constraint.shape[0]
    if np.linalg.matrix_rank(constraint @ rigid_motion(body)) < 6:
        raise refused(where, names, "the interfaces do not hold the body", "nodes that are not on one line")
    if not 0 <= modes <= most:
        raise refused(where, "modes", "not so many modes", f"0 to {most}", given=modes)
    # K u + A' l = f, A u = E q is solved as one, with A in the size of K
    size = float(np.abs(body.K.diagonal()).mean())
    saddle = [[sparse.csr_array(body.K), size * constraint.T], [size * constraint, None]]
    solve = splu(sparse.block_array(saddle, format="csc")).solve
    shapes = solve(np.vstack([np.zeros((count, motion.shape[1])), size * motion.toarray()]))[:count]
    squares, rest = np.empty(0), np.zeros(constraint.shape[0])
    if modes:
        squares, inner = lowest_modes(body, modes, lambda load: solve(np.append(load, rest))[:count])
        shapes = np.hstack([shapes, inner])
    found: dict[str, Any] = {
        name: None if getattr(body, name) is None else shapes.T @ (getattr(body, name) @ shapes)
        for name in ("M", "K", "C", "G1", "KG1")
    }
    held = motion.shape[1]  # these blocks are so but for rounding
    found["K"][:held, held:] = found["K"][held:, :held] = 0.0
    found["K"][held:, held:], found["M"][held:, held:] = np.diag(squares), np.eye(modes)
    dof_node, dof_dir = np.hstack([*dofs, [range(1, modes + 1), [0] * modes]]).astype(np.int64)
    xyz = np.vstack([one.place(body) if one.spider != "nodes" else body.places(np.array(one.nodes)) for one in there])
    ids = np.hstack([one.nodes for one in there])
    return replace(body, **found, node_id=ids, node_xyz=xyz, dof_node=dof_node, dof_dir=dof_dir), there


def _at_point(body: ReducedBody, interface: Interface, number: int, where: str) -> Interface:
    """The interface of a spider as it is after the reduction: one node at its point."""
    node_rows(body, interface, where)
    return replace(interface, nodes=(number,), point=interface.place(body), spider="average")


def _held(body: ReducedBody, interface: Interface, there: Interface, where: str) -> tuple[Matrix, Matrix, Index]:
    """A (m, n) and E (m, k) of A u = E q, and node and direction (2, k) of q."""
    directions, places, rows = node_rows(body, interface, where)
    own = np.isin(body.dof_node, interface.nodes) & ~body.modal
    if interface.spider == "nodes":
        return rows, sparse.eye_array(len(directions)), np.stack([body.dof_node[own], directions])
    dofs = np.stack([np.repeat(there.nodes, 6), np.arange(1, 7)])
    if interface.spider == "rigid":
        return rows, sparse.csr_array(rigid_rows(places, directions, there.point)), dofs
    shape = interface_shape(body, interface, where)
    if np.linalg.matrix_rank(shape) < 6:
        allowed = "nodes off one line, or each node kept"
        raise refused(where, interface.name, "the average does not see all rotations", allowed)
    return sparse.csr_array(shape), sparse.eye_array(6), dofs


# turning --------------------------------------------------------------------------------------------------------------

_CYCLIC, _WAVES, _PLACE = 1e-8, 1e-6, 1e-6


def turning_with_frame(body: ReducedBody, where: str) -> ReducedBody:
    """A body with G1 and KG1 of one that turns with its frame about z: M S + S M and S M S, S u = z x u of each node.

    Stress of the spin is not in KG1.

    Raises
    ------
    ModelError : coordinates other than displacements of nodes; a node without x or y.
    """
    if np.any((body.dof_dir < 1) | (body.dof_dir > 3)):
        allowed = "displacements of nodes, as of solid elements; or G1 and KG1 in the file"
        raise refused(where, "dof_dir", "rotations or modes", allowed)
    at = {one: i for i, one in enumerate(zip(body.dof_node.tolist(), body.dof_dir.tolist(), strict=True))}
    count, nodes = len(body.dof_dir), [node for node, direction in at if direction < 3]
    try:
        x, y = (np.array([at[node, axis] for node in dict.fromkeys(nodes)]) for axis in (1, 2))
    except KeyError as error:
        raise refused(where, "dof_node", "a node without x or y", "both", given=error.args[0][0]) from None
    turn = sparse.csr_array((np.ones(len(x)), (y, x)), shape=(count, count))
    turn = (turn - turn.T).tocsr()
    carried = body.M @ turn
    return replace(body, G1=carried - carried.T, KG1=turn @ carried)


def axisymmetric(body: ReducedBody, sectors: int, modes: int, nodes: tuple[int, ...], where: str) -> ReducedBody:
    """An axisymmetric body in its free modes, with D, and the motion of some of its nodes.

    sectors : equal ones of the mesh about z, more than twice the waves of the highest mode.  modes : rigid and elastic
    ones; one fewer where the last is half of a pair.

    Raises
    ------
    ModelError : a mesh or matrices that a turn by one sector changes; modes that it does not leave among themselves;
        too few sectors.
    """
    shift = sector_shift(body, sectors, where)
    for name in ("K", "M"):
        matrix = getattr(body, name)
        off = sparse.linalg.norm(sparse.csr_array(shift.T @ matrix @ shift - matrix))
        if off > _CYCLIC * sparse.linalg.norm(sparse.csr_array(matrix)):
            problem = f"a turn by one of {sectors} sectors changes the matrix"
            raise refused(where, name, problem, f"less than {_CYCLIC:g} of its norm")
    rigid = rigid_motion(body)
    squares, elastic = elastic_modes(body, rigid, modes - 6, where)
    rigid = rigid @ np.linalg.inv(np.linalg.cholesky(rigid.T @ (body.M @ rigid))).T
    shapes, squares = np.hstack([rigid, elastic]), np.append(np.zeros(6), squares)
    turn = shapes.T @ (body.M @ (shift @ shapes))
    if np.linalg.norm(turn.T @ turn - np.eye(len(turn)), 2) > _WAVES:
        shapes, squares, turn = shapes[:, :-1], squares[:-1], turn[:-1, :-1]
    own = np.flatnonzero(np.isin(body.dof_node, nodes))
    return replace(
        body,
        C=None,
        G1=None,
        KG1=None,
        M=np.eye(len(squares)),
        K=np.diag(squares),
        D=_derivative(turn, sectors, where),
        node_id=np.array(nodes),
        node_xyz=body.places(np.array(nodes)),
        dof_node=np.arange(1, len(squares) + 1),
        dof_dir=np.zeros(len(squares), np.int64),
        shape_node=body.dof_node[own],
        shape_dir=body.dof_dir[own],
        shape=shapes[own],
    )


def sector_shift(body: ReducedBody, sectors: int, where: str) -> Matrix:
    """P (n, n): the field of displacements turned by one sector about z."""
    angle = 2 * np.pi / sectors
    rotation = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
    away, image = cKDTree(body.node_xyz).query(body.node_xyz @ rotation.T)
    if away.max() > _PLACE * np.abs(body.node_xyz).max() or len(np.unique(image)) < len(image):
        given = int(body.node_id[away.argmax()])
        problem = f"no node where a turn by one of {sectors} sectors takes it"
        raise refused(where, "node_xyz", problem, "a mesh of equal sectors about z", given=given)
    at = {one: i for i, one in enumerate(zip(body.dof_node.tolist(), body.dof_dir.tolist(), strict=True))}
    target = dict(zip(body.node_id.tolist(), body.node_id[image].tolist(), strict=True))
    try:
        entries = [
            (rotation[to, of], at[target[node], 3 * block + to + 1], column)
            for (node, direction), column in at.items()
            for block, of in [divmod(direction - 1, 3)]
            for to in ([2] if of == 2 else [0, 1])
        ]
    except KeyError:
        allowed = "nodes with the same directions, x and y together"
        raise refused(where, "dof_dir", "a turn takes a direction where none is", allowed) from None
    value, row, column = map(np.array, zip(*entries, strict=True))
    return sparse.csr_array((value, (row, column)), shape=(len(at), len(at)))


def _derivative(turn: Array, sectors: int, where: str) -> Array:
    """D of modes that one sector turns by a matrix (m, m): antisymmetric, its eigenvalues i times whole waves."""
    if np.linalg.norm(turn.T @ turn - np.eye(len(turn)), 2) > _WAVES:
        raise refused(where, "modes", "the modes are not closed under a turn by a sector", "another number")
    waves = np.abs(np.angle(np.linalg.eigvals(turn))) * sectors / (2 * np.pi)
    if 2 * np.round(waves).max() >= sectors:
        given, allowed = f"{waves.max():.0f} waves", f"less than {sectors / 2:g}, half of the sectors"
        raise refused(where, "modes", "modes with more waves than the sectors tell apart", allowed, given=given)
    off = np.abs(waves - np.round(waves)).max()
    if off > _WAVES:
        raise refused(where, "modes", "no whole number of waves", f"{_WAVES:g}", given=f"{off:.2g} off")
    found = -np.real(scipy.linalg.logm(turn)) * sectors / (2 * np.pi)
    return np.asarray(0.5 * (found - found.T))


# coordinates of a train -----------------------------------------------------------------------------------------------

_NEAR = 5e-2  # distance of a point from its interface, of the size of the body
_MASSLESS = 1e-12  # share of the largest eigenvalue of M, scaled to a unit diagonal
_SAME = 1e-6  # of frequencies, places and motions that symmetry makes equal
_JOINED = 1e-3  # of a damper between mean motion and modes, by the geometric mean of the dampers of both
_ROUND = 1e-3  # of moments of inertia and the centre of mass of a body about its axis


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InterfaceShape:
    """Shape of a body by its interfaces.

    names : (i,).  points : (i, 3) from the centre of mass [m].  shapes : (i, 6, e) motion of each per coordinate.
    strains : (i, 3, 3, e) gradient of the displacement beside that of the rotation [1/m].
    turn : D (e, e) of an axisymmetric body.  reach : distance within which a point belongs to an interface [m].
    """

    names: tuple[str, ...]
    points: Array
    shapes: Array
    strains: Array
    turn: Array | None
    reach: float

    def nearest(self, point: Array) -> tuple[int, float, float]:
        """Interface of a point (3,), its distance [m], and the angle by which it is turned against that."""
        points, turned = self.points, np.zeros(len(self.points))
        if self.turn is not None:
            turned = np.arctan2(point[1], point[0]) - np.arctan2(points[:, 1], points[:, 0])
            points = about_z(points, turned)
        away = np.linalg.norm(points - point, axis=1)
        i = int(np.argmin(away))
        return i, float(away[i]), float(turned[i])

    def turned(self, groups: Sequence[slice], size: Array, angle: float) -> Array | None:
        """Operator (e, e) that turns the motion of the interfaces by an angle [rad]; None where they do not close.

        groups : coordinates of one frequency each, among which it stays.  size : (e,) roots of the modal masses.
        """
        images = about_z(self.points, angle)
        at = [int(np.argmin(np.linalg.norm(self.points - image, axis=1))) for image in images]
        if max(np.linalg.norm(self.points[at] - images, axis=1)) > _SAME * np.abs(self.points).max():
            return None
        moved = np.zeros_like(self.shapes)
        for i, image in enumerate(at):
            moved[image] = _turned(self.shapes[i], angle)
        seen, wanted = (motion.reshape(-1, len(size)) / size for motion in (self.shapes, moved))
        R, least = np.eye(len(size)), _SAME * np.abs(seen).max()
        for own in groups:
            left, share, right = np.linalg.svd(seen[:, own].T @ wanted[:, own])
            if share.min() > least**2:  # else a mode that no interface sees stays as it is
                R[own, own] = left @ right
            if np.abs(seen[:, own] @ R[own, own] - wanted[:, own]).max() > least:
                return None
        return R * size / size[:, None]

    def __call__(self, points: Array) -> Array:
        """Motion (R, 6, e) of points (R, 3) from the centre of mass [m]; zero where there is no interface."""
        result = np.zeros((len(points), 6, self.shapes.shape[2]))
        for row, point in zip(result, points, strict=True):
            i, away, angle = self.nearest(point)
            if away > self.reach:
                continue
            turned = np.eye(result.shape[2]) if self.turn is None else scipy.linalg.expm(angle * self.turn)
            # in the axes of the interface, from it
            off = about_z(point[None], -angle)[0] - self.points[i]
            motion = self.shapes[i] @ turned
            motion[:3] += np.cross(motion[3:], off[:, None], axis=0) + off @ self.strains[i] @ turned
            row[:] = _turned(motion, angle)
        return result


def _turned(motion: Array, angle: float) -> Array:
    """The motion (6, e) of a point turned about z by an angle [rad]."""
    return np.concatenate([about_z(part.T, angle).T for part in (motion[:3], motion[3:])])


def joined_body(body: ReducedBody, facts: BodyFacts, interfaces: Sequence[Interface], where: str) -> ElasticBody:
    """A reduced body as coordinates of a train, `e1`, `e2`, .. [m]: modes whose largest motion of a node is 1.

    Raises
    ------
    ModelError : a coordinate without mass; a body that is not round about its axis; dampers to the ground.
    """
    _require_round(facts, where)
    T, shapes = rigid_motion(body), [dense(interface_shape(body, one, where)) for one in interfaces]
    squares, modes = _free_modes(body, where)
    seen = np.array([shape @ modes for shape in shapes])
    modes = modes / np.maximum(np.abs(seen[:, :3]).max(axis=(0, 1)), 1e-3 * np.abs(modes).max(axis=0))
    # rigid motions about the origin: translations, by which those about the centre differ, couple with no mode
    basis, M, size = np.hstack([T, modes]), dense(body.M), 6 + modes.shape[1]
    inertia = np.einsum("ie,ij,je->e", modes, M, modes)
    turn, zero = np.zeros((size, size)), np.zeros((size, size))
    spin, spin_stiffness, damping = (
        zero.copy() if matrix is None else basis.T @ dense(matrix) @ basis for matrix in (body.G1, body.KG1, body.C)
    )
    _require_own_damping(damping, where)
    for term in (spin, spin_stiffness, damping):  # of mean motions they are those of a rigid body, or none
        term[:6, :6] = 0.0
    if body.D is not None:
        turn[6:, 6:] = (modes.T @ M @ body.D @ modes) / inertia[:, None]
        turn[0, 1], turn[1, 0], turn[3, 4], turn[4, 3] = 1.0, -1.0, 1.0, -1.0
    names = tuple(f"e{i}" for i in range(1, len(inertia) + 1))
    shape = InterfaceShape(
        names=tuple(one.name for one in interfaces),
        points=np.array([one.place(body) for one in interfaces]) - facts.centre,
        shapes=np.array([shape @ modes for shape in shapes]),
        strains=np.array([_strain(body, *of, where) @ modes for of in zip(interfaces, shapes, strict=True)]),
        turn=turn[6:, 6:] if body.D is not None else None,
        reach=_NEAR * float(np.abs(body.node_xyz).max()),
    )
    ends = np.flatnonzero(np.diff(squares) > _SAME * squares[1:]) + 1
    groups = [slice(a, b) for a, b in pairwise([0, *ends.tolist(), len(squares)])]
    return ElasticBody(
        names=names,
        mass=np.diag(np.append(np.zeros(6), inertia)),
        springs=Springs(np.eye(size)[6:], squares * inertia, names),
        foundation=Springs(np.zeros((0, size)), np.zeros(0), ()),
        damping=damping,
        turn=turn,
        waves=None if body.D is None else round(float(np.abs(np.linalg.eigvals(turn[6:, 6:]).imag).max())),
        spin=spin,
        spin_stiffness=spin_stiffness,
        spin_load=np.zeros(size),
        shape=shape,
        cyclic=None if body.D is not None else partial(shape.turned, groups, np.sqrt(inertia)),
    )


def _strain(body: ReducedBody, interface: Interface, shape: Array, where: str) -> Array:
    """Gradient of the displacements of nodes beside that of their mean rotation, d u_i/d x_j at (j, i, n) [1/m].

    Zero of spiders, and along directions in which the nodes have no extent.
    """
    found = np.zeros((3, 3, len(body.dof_dir)))
    if interface.spider != "nodes":
        return found
    directions, places, rows = node_rows(body, interface, where)
    point = interface.place(body)
    left = dense(rows) - rigid_rows(places, directions, point) @ shape
    for i in range(3):
        own = directions == i + 1
        found[:, i] = np.linalg.pinv(places[own] - point, rcond=1e-9) @ left[own]
    return found


def _free_modes(body: ReducedBody, where: str) -> tuple[Array, Array]:
    """Squared frequencies (e,) [1/s^2] and elastic modes (n, e) of a free body, all of them."""
    M, K = dense(body.M), dense(body.K)
    scale = 1 / np.sqrt(np.maximum(np.diag(M), np.finfo(float).tiny))
    if np.linalg.eigvalsh(M * np.outer(scale, scale))[0] < _MASSLESS:
        allowed = "mass on every coordinate, as a reduction with modes gives it"
        raise ModelError("coordinates without mass cannot join a train", path=f"{where}: M", allowed=allowed)
    squares, modes = scipy.linalg.eigh(K, M)
    return squares[6:], modes[:, 6:]


def _require_own_damping(damping: Array, where: str) -> None:
    """Refuse dampers that join mean motion and bending, as those to the ground do; of C ~ M and C ~ K none does."""
    size = np.sqrt(np.abs(np.diag(damping)))
    mean, bent = size[:6].max(), size[6:].max(initial=0.0)
    if np.abs(damping[:6, 6:]).max(initial=0.0) > _JOINED * bent * max(mean, 1e-6 * bent):  # rounding of C ~ K
        allowed = "damping of the material, as proportional to K and M"
        raise ModelError("dampers of the mean motion that bend the body", path=f"{where}: C", allowed=allowed)


def _require_round(facts: BodyFacts, where: str) -> None:
    """Refuse a body whose centre of mass is off its axis, or whose inertia is not that of a round body."""
    radius = np.sqrt(np.trace(facts.inertia) / facts.mass)
    off = np.hypot(*facts.centre[:2]) / radius
    if off > _ROUND:
        given = f"x {1e3 * facts.centre[0]:.4g} mm, y {1e3 * facts.centre[1]:.4g} mm"
        raise ModelError("centre of mass off the axis", path=f"{where}: M", given=given, allowed="on the z axis")
    uneven = facts.inertia - np.diag(np.diag(facts.inertia))
    uneven[0, 0] = facts.inertia[0, 0] - facts.inertia[1, 1]
    if np.abs(uneven).max() > _ROUND * np.trace(facts.inertia):
        given = ", ".join(f"{value:.4g}" for value in np.diag(facts.inertia))
        allowed = "equal moments of inertia about x and y, no products"
        raise ModelError("not round about the axis", path=f"{where}: M", given=f"{given} kg m^2", allowed=allowed)
