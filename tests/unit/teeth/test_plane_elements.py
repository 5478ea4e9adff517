"""Nine-noded plane-strain elements against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from epicyclic.teeth.root_stress import edge_values, grid_cells, merged_nodes, stiffness_matrix

Array = NDArray[np.float64]
NU = 0.3


def test_constant_strain_is_exact_on_skewed_cells() -> None:
    rows, columns = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 5), indexing="ij")
    points = np.stack([columns + 0.3 * rows**2, rows + 0.2 * rows * columns], axis=-1).reshape(-1, 2)
    # sides straight between their ends: the middles of the cells halfway, as those of an isoparametric patch test
    grid = points.reshape(7, 5, 2)
    grid[1::2] = 0.5 * (grid[:-1:2] + grid[2::2])
    grid[:, 1::2] = 0.5 * (grid[:, :-1:2] + grid[:, 2::2])
    points = grid.reshape(-1, 2)
    K = stiffness_matrix(points, grid_cells(np.arange(35).reshape(7, 5)), NU)
    strain = np.array([[2e-3, 1e-3], [-3e-3, 4e-3]])
    moved = (points @ strain.T).ravel()
    force = np.asarray(K @ moved).reshape(7, 5, 2)
    assert np.abs(force[1:-1, 1:-1]).max() < 1e-15
    # and the energy is that of the stress in plane strain
    symmetric = 0.5 * (strain + strain.T)
    stress = (symmetric + NU / (1 - 2 * NU) * np.trace(symmetric) * np.eye(2)) / (1 + NU)
    outline = np.concatenate([grid[0, ::2], grid[2::2, -1], grid[-1, -3::-2], grid[-3:0:-2, 0]])
    x, y = outline.T
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert moved @ (K @ moved) == pytest.approx(area * np.sum(stress * symmetric), rel=1e-12)


def test_ring_in_torsion() -> None:
    # held inside, a couple along the outer circle: u = T/(4 pi G) (1/r_i^2 - 1/r^2) r
    inner, outer = 0.5, 1.0
    angle, radius = np.meshgrid(np.linspace(0, 2 * np.pi, 81), np.linspace(inner, outer, 17))
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).reshape(-1, 2)
    points, number = merged_nodes(points, 1e-9)
    grid = number.reshape(17, 81)
    assert len(points) == 17 * 80
    K = stiffness_matrix(points, grid_cells(grid), NU)
    force = np.zeros((len(points), 2))
    gauss, weight = np.polynomial.legendre.leggauss(3)
    value, slope = edge_values(gauss)
    for k in range(0, 80, 2):
        edge = grid[-1, k : k + 3]
        at, along = value @ points[edge], slope @ points[edge]
        turned = np.stack([-at[:, 1], at[:, 0]], axis=1)
        force[edge] += np.einsum("qa,qx,q->ax", value, turned, np.hypot(*along.T) * weight)
    torque = float(np.sum(points[:, 0] * force[:, 1] - points[:, 1] * force[:, 0]))
    free = np.setdiff1d(np.arange(2 * len(points)), (2 * grid[0][:, None] + np.arange(2)).ravel())
    moved = np.zeros(2 * len(points))
    moved[free] = spsolve(K[np.ix_(free, free)], force.ravel()[free])
    G = 1 / (2 * (1 + NU))
    expected = torque / (4 * math.pi * G) * (inner**-2 - outer**-2) * outer
    assert moved[2 * grid[-1, 0] + 1] == pytest.approx(expected, rel=1e-4)


def test_nodes_where_three_grids_meet_are_one() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1e-9], [2.0, 0.0], [1.0 + 1e-9, 0.0], [0.0, 0.0]])
    kept, number = merged_nodes(points, 1e-6)
    assert number.tolist() == [0, 1, 1, 2, 1, 0]
    assert kept.tolist() == [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]
