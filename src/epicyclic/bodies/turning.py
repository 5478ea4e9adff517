"""What a body needs to turn: gyroscopic terms of one that turns with its frame, and D of an axisymmetric one.

Of an axisymmetric body the pattern may turn against its material: D is the derivative along the angle.  Held in a frame
of speed Omega, nu = -Omega, its terms are G = 2 nu M D and Kg = nu^2 M D^2.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg
from scipy import sparse
from scipy.spatial import cKDTree

from .checks import elastic_modes
from .reduced_body import Array, Matrix, ReducedBody, refused, rigid_motion

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
