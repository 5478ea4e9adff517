"""Places where a body is held, and the reduction of a whole mesh to them (Craig and Bampton)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from .checks import lowest_modes
from .reduced_body import Array, Index, Matrix, ReducedBody, refused, rigid_motion, rigid_rows

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
