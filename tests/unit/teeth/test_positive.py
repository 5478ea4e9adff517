"""Products and solutions with many positive definite matrices: as those of numpy, a few at a time or one by one."""

from __future__ import annotations

import numpy as np
import pytest

from epicyclic.teeth.contact_solver import products, scaled_solution, solved

INDEX = np.array([2, 0, 0, 1, 2])


def matrices(count: int, n: int) -> np.ndarray:
    random = np.random.default_rng(5).normal(size=(count, n, n))
    return random @ random.transpose(0, 2, 1) + np.eye(n)


@pytest.mark.parametrize("entries", [1, 2 * 49, 10**6])
def test_rows_that_share_matrices(entries: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("epicyclic.teeth.contact_solver._ENTRIES", entries)
    C, random = matrices(3, 7), np.random.default_rng(6)
    vector, right = random.normal(size=(5, 7)), random.normal(size=(5, 7, 2))
    root = random.uniform(0.1, 2.0, size=(5, 7))
    root[1, 2:5], root[4] = 0.0, 0.0  # some that bear nothing, and a phase out of contact
    before = C.copy()
    assert products(C, INDEX, vector) == pytest.approx(np.einsum("tij,tj->ti", C[INDEX], vector), rel=1e-12)
    whole = root[:, :, None] * C[INDEX] * root[:, None, :] + np.eye(7)
    assert scaled_solution(C, INDEX, root, right) == pytest.approx(np.linalg.solve(whole, right), rel=1e-11)
    assert (before == C).all()  # that of the mesh is not the one overwritten


def test_a_matrix_that_is_not_positive_is_solved_all_the_same() -> None:
    C = matrices(2, 4)
    C[1, 3, 3] = -1.0
    right = np.arange(16.0).reshape(2, 4, 2)
    assert solved(C.copy(), right) == pytest.approx(np.linalg.solve(C, right), rel=1e-11)
