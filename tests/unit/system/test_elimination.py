"""Rigid connections by elimination: exact, whatever the order and redundancy of the rows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from epicyclic.system.system import eliminate


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 10**6), rows=st.integers(1, 6), extra=st.integers(1, 6))
def test_reduced_coordinates_satisfy_the_constraints(seed: int, rows: int, extra: int) -> None:
    rng = np.random.default_rng(seed)
    size = rows + extra
    A = rng.integers(-2, 3, (rows, size)).astype(float)
    A[rng.random((rows, size)) < 0.4] = 0.0
    T, S, kept = eliminate(A, rng.integers(0, size, rows))
    rank = np.linalg.matrix_rank(A)
    assert T.shape == (size, size - rank)
    assert kept.size == size - rank
    # small integers: a few operations of order one
    assert A @ T == pytest.approx(np.zeros((rows, size - rank)), abs=1e-10)
    if rank == rows:
        assert A @ S == pytest.approx(np.eye(rows), abs=1e-9)
    assert T[kept] == pytest.approx(np.eye(size - rank), abs=1e-10)


def test_the_coordinate_asked_for_is_the_one_eliminated() -> None:
    T, S, kept = eliminate(np.array([[2.0, 0.0, -1.0]]), np.array([2]))
    assert kept.tolist() == [0, 1]
    assert T[2].tolist() == [2.0, 0.0]
    assert S[:, 0].tolist() == [0.0, 0.0, -1.0]


def test_rows_that_fix_one_coordinate_at_a_time_cascade() -> None:
    A = np.array([[0.0, 1.0, -1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [-1.0, 1.0, 0.0, 0.0]])
    T, S, kept = eliminate(A, np.array([2, 0, 1]))
    assert kept.tolist() == [3]
    assert np.abs(A @ T).max() == 0.0
    assert pytest.approx(np.eye(3)) == A @ S
