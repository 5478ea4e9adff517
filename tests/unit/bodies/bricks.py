"""A ring of eight-noded bricks, assembled here: a mesh for tests that need no finite-element program."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from epicyclic.bodies.reduced_body import Array, ReducedBody

RADIUS, HEIGHT, WIDTH, DENSITY, YOUNG, POISSON = 0.15, 0.03, 0.04, 7850.0, 2.07e11, 0.3
_SIGNS = np.array([(s, r, z) for s in (-1, 1) for r in (-1, 1) for z in (-1, 1)], float)
_GAUSS = _SIGNS / np.sqrt(3)


def brick_ring(sectors: int) -> ReducedBody:
    """Sparse matrices of 4 nodes a sector, numbered from 1: inside left, inside right, outside left, outside right."""
    angle = 2 * np.pi * np.arange(sectors) / sectors
    section = [(r, z) for r in (-1, 1) for z in (-1, 1)]
    places = np.array(
        [
            ((RADIUS + r * HEIGHT / 2) * np.cos(a), (RADIUS + r * HEIGHT / 2) * np.sin(a), z * WIDTH / 2)
            for a in angle
            for r, z in section
        ]
    )
    count, rows, columns, stiffness, mass = len(places), [], [], [], []
    for sector in range(sectors):
        nodes = np.concatenate([4 * sector + np.arange(4), 4 * ((sector + 1) % sectors) + np.arange(4)])
        k, m = _brick(places[nodes])
        dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        rows.append(np.repeat(dofs, 24))
        columns.append(np.tile(dofs, 24))
        stiffness.append(k.ravel())
        mass.append(m.ravel())
    at = np.concatenate(rows), np.concatenate(columns)
    return ReducedBody(
        M=sparse.coo_array((np.concatenate(mass), at), shape=(3 * count, 3 * count)).tocsr(),
        K=sparse.coo_array((np.concatenate(stiffness), at), shape=(3 * count, 3 * count)).tocsr(),
        node_id=np.arange(1, count + 1),
        node_xyz=places,
        dof_node=np.repeat(np.arange(1, count + 1), 3),
        dof_dir=np.tile([1, 2, 3], count),
    )


def _brick(places: Array) -> tuple[Array, Array]:
    """Stiffness and mass (24, 24) of a brick with two points of Gauss a direction."""
    shear = YOUNG / (2 * (1 + POISSON))
    first = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += first
    stiffness, mass = np.zeros((24, 24)), np.zeros((24, 24))
    for point in _GAUSS:
        factor = 1 + _SIGNS * point
        shape = factor.prod(axis=1) / 8
        local = np.stack([_SIGNS[:, i] * np.delete(factor, i, axis=1).prod(axis=1) / 8 for i in range(3)])
        jacobian = local @ places
        x, y, z = np.linalg.solve(jacobian, local)
        volume = abs(np.linalg.det(jacobian))
        strain = np.zeros((6, 8, 3))
        for row, column, slope in (
            (0, 0, x),
            (1, 1, y),
            (2, 2, z),
            (3, 0, y),
            (3, 1, x),
            (4, 1, z),
            (4, 2, y),
            (5, 0, z),
        ):
            strain[row, :, column] = slope
        strain[5, :, 2] = x
        flat = strain.reshape(6, 24)
        stiffness += volume * flat.T @ law @ flat
        mass += volume * DENSITY * np.kron(np.outer(shape, shape), np.eye(3))
    return stiffness, mass
