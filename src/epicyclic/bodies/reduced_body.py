"""A body by matrices: what it is, its rigid motions, its units.

A body has coordinates q.  A coordinate is the displacement or rotation of a node, or a mode without place.  Body axes
have z along the axis of the gear; nodes stand where they are undeformed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ..errors import ModelError

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Matrix: TypeAlias = Any  # an Array, a csr_array of scipy, or None where there is none

# of the masses [kg] and lengths [m] of a file
UNITS = {"kg m s": (1.0, 1.0), "t mm s": (1e3, 1e-3)}
MAX_BYTES, MAX_DENSE, MAX_DOFS = 1 << 29, 3000, 200_000
UNIT_WORDS = ", ".join(f'"{one}"' for one in UNITS)
MATRICES = ("M", "K", "C", "G1", "KG1", "D")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReducedBody:
    """A body in n coordinates, SI: M q'' + (C + s G1) q' + (K + s^2 KG1) q = forces, s its speed [rad/s].

    M, K : (n, n), symmetric; dense, or sparse where a whole mesh is meant.
    C, G1, KG1 : (n, n) damping, gyroscopic terms per rad/s, stiffness per (rad/s)^2.
    D : (n, n) derivative along the angle of an axisymmetric body: its pattern turned back by psi is exp(psi D) q.
    node_id : (k,); node_xyz : (k, 3) [m].
    dof_node, dof_dir : (n,) node and direction of each coordinate: 1 to 3 x, y, z [m], 4 to 6 about them [rad], 0 a
        mode, whose mass is 1.
    shape_node, shape_dir, shape : (r,), (r,), (r, n) motion of nodes that are no coordinates.
    mass [kg], centre (3,) [m], inertia (3, 3) about it [kg m^2] : what is expected.
    units : of the file that was read.
    """

    M: Matrix
    K: Matrix
    C: Matrix = None
    G1: Matrix = None
    KG1: Matrix = None
    D: Array | None = None
    node_id: Index
    node_xyz: Array
    dof_node: Index
    dof_dir: Index
    shape_node: Index | None = None
    shape_dir: Index | None = None
    shape: Array | None = None
    mass: float | None = None
    centre: Array | None = None
    inertia: Array | None = None
    source: str = ""
    units: str = "kg m s"

    @property
    def modal(self) -> NDArray[np.bool_]:
        """(n,) which coordinates are modes."""
        return np.equal(self.dof_dir, 0)

    def places(self, nodes: Index) -> Array:
        """(m, 3) coordinates of nodes [m]; KeyError of one that is not there."""
        at = {int(node): i for i, node in enumerate(self.node_id)}
        return self.node_xyz[[at[int(node)] for node in nodes]].reshape(-1, 3)


def rigid_rows(places: Array, directions: Index, point: Array | None = None) -> Array:
    """Rows (m, 6): what directions 1 to 6 at places (m, 3) [m] see of the motion x y z, rx ry rz of a point (3,)."""
    x, y, z = (places - (0.0 if point is None else point)).T
    zero, row = np.zeros_like(x), np.arange(len(places))
    cross = np.array([[zero, z, -y], [-z, zero, x], [y, -x, zero]]).transpose(2, 0, 1)  # rotation to displacement
    block = np.tile(np.eye(6), (len(places), 1, 1))
    block[:, :3, 3:] = cross
    return block[row, directions - 1]


def rigid_motion(body: ReducedBody) -> Array:
    """Motions (n, 6) of the coordinates as the body moves rigidly: x y z, rx ry rz about the origin.

    Modes follow from the stiffness, which is not strained, and from the shape of nodes.
    """
    modal = body.modal
    motion = np.zeros((len(modal), 6))
    motion[~modal] = rigid_rows(body.places(body.dof_node[~modal]), body.dof_dir[~modal])
    if not modal.any():
        return motion
    own = dense(body.K[modal])
    size = np.abs(own).max(initial=0.0) or 1.0
    strained, wanted = own[:, modal] / size, -own @ motion / size
    if body.shape is not None and body.shape_node is not None and body.shape_dir is not None:
        seen = rigid_rows(body.places(body.shape_node), body.shape_dir) - body.shape @ motion
        strained, wanted = np.vstack([strained, body.shape[:, modal]]), np.vstack([wanted, seen])
    motion[modal] = np.linalg.lstsq(strained, wanted, rcond=None)[0]
    return motion


def refused(where: str, name: str, problem: str, allowed: str, **given: object) -> ModelError:
    """What is wrong with something in a file."""
    return ModelError(problem, path=f"{where}: {name}", allowed=allowed, **given)


# --- units -----------------------------------------------------------------------------------------------------------


def in_si(body: ReducedBody, where: str) -> ReducedBody:
    """A body whose matrices, places and mass are in `body.units`, in SI.

    Raises
    ------
    ModelError : units that are not known, at `where`: units.
    """
    if body.units not in UNITS:
        raise refused(where, "units", "not known, and never guessed", UNIT_WORDS, given=body.units)
    mass, length = UNITS[body.units]
    if (mass, length) == (1.0, 1.0):
        return body
    energy = mass * length**2
    size = np.array([energy**0.5, *[length] * 3, *[1.0] * 3])  # of a coordinate, by its direction
    own = size[body.dof_dir]
    found: dict[str, Any] = {name: scaled(getattr(body, name), energy / own, 1 / own) for name in MATRICES[:-1]}
    if body.shape is not None:
        found["shape"] = scaled(body.shape, size[body.shape_dir], 1 / own)
    found |= {"D": scaled(body.D, own, 1 / own), "node_xyz": body.node_xyz * length}
    for name, factor in (("mass", mass), ("centre", length), ("inertia", energy)):
        value = getattr(body, name)
        found[name] = None if value is None else value * factor
    return replace(body, **found)


def dense(matrix: Matrix) -> Array:
    """A matrix as an array."""
    return np.asarray(matrix.toarray() if sparse.issparse(matrix) else matrix, float)


def scaled(matrix: Matrix, rows: Array, columns: Array) -> Matrix:
    """A matrix, or None, with its rows and columns multiplied."""
    if sparse.issparse(matrix):
        return (sparse.diags_array(rows) @ matrix @ sparse.diags_array(columns)).tocsr()
    return None if matrix is None else matrix * np.outer(rows, columns)
