"""GMRES on many systems at once against dense solves."""

from __future__ import annotations

import numpy as np
import pytest

from epicyclic.questions.response.balance import gmres


def systems(seed: int, size: int = 30, count: int = 7) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    A = np.eye(size) + 0.6 * rng.standard_normal((count, size, size)) / np.sqrt(size)
    return A, rng.standard_normal((count, size))


@pytest.mark.parametrize("basis", [40, 12])
def test_agrees_with_dense_solves(basis: int) -> None:
    A, b = systems(1)
    x, left, calls = gmres(
        lambda v: np.einsum("pij,pj->pi", A, v), b, target=np.full(7, 1e-10), basis=basis, restarts=40
    )
    expected = np.linalg.solve(A, b[:, :, None])[:, :, 0]
    # residual 1e-10, condition number of these matrices below 1e2
    np.testing.assert_allclose(x, expected, atol=1e-8)
    assert left.max() <= 1e-10
    assert calls > 10


def test_a_system_that_is_not_finite_leaves_the_others_alone() -> None:
    A, b = systems(2)
    A[3] = np.nan
    with np.errstate(all="ignore"):
        x, left, _ = gmres(lambda v: np.einsum("pij,pj->pi", A, v), b, target=np.full(7, 1e-10))
    good = np.arange(7) != 3
    np.testing.assert_allclose(x[good], np.linalg.solve(A[good], b[good][:, :, None])[:, :, 0], atol=1e-8)
    assert np.isnan(left[3])


def test_nothing_on_the_right_gives_nothing() -> None:
    x, left, calls = gmres(lambda v: v, np.zeros((2, 4)), target=np.full(2, 1e-12))
    assert calls == 0
    assert not x.any()
    assert not left.any()


def test_a_singular_system_reports_what_is_left() -> None:
    b = np.array([[1.0, 1.0]])
    _, left, _ = gmres(lambda v: v * np.array([1.0, 0.0]), b, target=np.array([1e-10]))
    assert 1.0 <= left[0] <= np.sqrt(2)  # the second equation cannot be met, and it never gets worse than at the start


def test_unchecked_gives_the_same_solution_by_a_product_less() -> None:
    A, b = systems(3)
    target = 1e-3 * np.linalg.norm(b, axis=1)
    once, twice = (
        gmres(lambda v: np.einsum("pij,pj->pi", A, v), b, target=target, checked=checked) for checked in (False, True)
    )
    np.testing.assert_allclose(once[0], twice[0], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(once[1], twice[1], rtol=1e-9)
    assert (once[1] <= target).all()
    assert once[2] == twice[2] - 1


def test_unchecked_believes_no_singular_system() -> None:
    b = np.array([[1.0, 1.0]])
    _, left, _ = gmres(lambda v: v * np.array([1.0, 0.0]), b, target=np.array([1e-3]), checked=False)
    assert 1.0 <= left[0] <= np.sqrt(2)
