"""A reduced body as coordinates of a train: its free elastic modes beside the six of its mean motion.

Modes of the free body are orthogonal to its rigid motions, so that mass and inertia stay those of a rigid body.  The
motion of a point is that of the interface there, u + theta x (P - P_i); of nodes that are kept each, u + G (P - P_i)
with the gradient G of their displacements as far as they tell it.  An axisymmetric body, one with D, has an interface
all round: at the angle psi its motion is Phi exp(psi D) in axes turned as much.  Derived here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
import scipy.linalg

from ..errors import ModelError
from .checks import BodyFacts
from .elastic_body import Array, ElasticBody, Springs, about_z
from .reduced_body import ReducedBody, dense, rigid_motion, rigid_rows
from .reduction import Interface, interface_shape, node_rows

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
