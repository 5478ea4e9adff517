"""Exact linear algebra against its defining properties."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from epicyclic.train.kinematics import least_norm, null_space

ENTRY = st.integers(-3, 3).map(Fraction)


@st.composite
def matrices(draw: st.DrawFn) -> list[list[Fraction]]:
    rows, columns = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    return draw(st.lists(st.lists(ENTRY, min_size=columns, max_size=columns), min_size=rows, max_size=rows))


def times(matrix: list[list[Fraction]], vector: list[Fraction]) -> list[Fraction]:
    return [sum((a * x for a, x in zip(row, vector, strict=True)), Fraction(0)) for row in matrix]


@given(matrices())
@settings(max_examples=100, deadline=None)
def test_null_space_is_the_whole_null_space(matrix: list[list[Fraction]]) -> None:
    columns = len(matrix[0])
    vectors = null_space(matrix, range(columns))
    rank = np.linalg.matrix_rank(np.array(matrix, dtype=float))
    assert len(vectors) == columns - rank
    for free, vector in vectors.items():
        assert not any(times(matrix, vector))
        assert [vector[j] for j in vectors] == [Fraction(int(j == free)) for j in vectors]


@given(matrices(), st.data())
@settings(max_examples=100, deadline=None)
def test_least_norm_equals_the_pseudoinverse(matrix: list[list[Fraction]], data: st.DataObject) -> None:
    hidden = data.draw(st.lists(ENTRY, min_size=len(matrix[0]), max_size=len(matrix[0])))
    right = times(matrix, hidden)
    found = least_norm(matrix, right)
    assert found is not None
    assert times(matrix, found) == right
    expected = np.linalg.pinv(np.array(matrix, dtype=float)) @ np.array(right, dtype=float)
    # pinv of small integers: condition below 1e4, hence rounding of 1e-11
    np.testing.assert_allclose(np.array(found, dtype=float), expected, atol=1e-10)


def test_a_contradiction_has_no_solution() -> None:
    one = Fraction(1)
    assert least_norm([[one], [one]], [one, 2 * one]) is None
    assert least_norm([], []) == []


def test_later_unknowns_become_free_first() -> None:
    rows = [[Fraction(2), Fraction(-1)]]
    assert null_space(rows, [0, 1]) == {1: [Fraction(1, 2), Fraction(1)]}
    assert null_space(rows, [1, 0]) == {0: [Fraction(1), Fraction(2)]}
