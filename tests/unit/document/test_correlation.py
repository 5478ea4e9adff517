"""`[tolerance.correlation]`: the copula gives the correlations that are asked for; others are refused."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats

from epicyclic.document.document import read
from epicyclic.document.tolerances import Correlations
from epicyclic.errors import ModelError
from epicyclic.train.resolution import correlations_of, load, tolerances_of

PLAIN = read("ren2021", {"tolerance": None}).data
X, Y, R, SUN = (
    f"deviations.main.{name}" for name in ("planet.position.x", "planet.position.y", "planet.run_out.x", "sun.run_out")
)
ENTRIES = {path: "normal(0, 1 um)" for path in (X, Y, R, SUN)} | {"deviations.main.ring.run_out": "disc(4 um)"}


def correlated(table: object) -> tuple[Correlations, ...]:
    return correlations_of(load(PLAIN, {"tolerance": ENTRIES | {"correlation": table}}))


def test_none_where_none_is_stated() -> None:
    assert correlations_of(load(PLAIN)) == ()
    assert correlations_of(load(PLAIN, {"tolerance": ENTRIES})) == ()


def test_draws_have_the_correlation_and_keep_their_distribution() -> None:
    (group,) = correlated({X: {Y: 0.6, R: -0.5}, "deviations.planet.position.y": {"deviations.planet.run_out.x": -0.2}})
    assert group.paths == (X, Y, R)
    assert group.count == 3
    assert_allclose(group.matrix, [[1, 0.6, -0.5], [0.6, 1, -0.2], [-0.5, -0.2, 1]])
    first = {X: 0, Y: 4, R: 7}
    u = stats.qmc.Sobol(10, rng=1).random(2**12) * (1 - 2e-9) + 1e-9
    mixed = group.applied(u, first)
    assert_allclose(mixed[:, 3], u[:, 3])  # of no correlated entry
    normal = stats.norm.ppf(mixed)
    found = np.corrcoef(normal.T)
    for planet in range(3):
        columns = [first[path] + planet for path in group.paths]
        assert_allclose(found[np.ix_(columns, columns)], group.matrix, atol=0.01)
        for column in columns:
            assert stats.kstest(mixed[:, column], "uniform").statistic < 0.01
    assert_allclose(found[0, [1, 2, 5, 6, 8, 9]], 0, atol=0.02)  # of other planets


def test_groups_hang_together() -> None:
    table = {X: {Y: 0.5}}
    assert [group.paths for group in correlated(table)] == [(X, Y)]
    joined = correlated({X: {Y: 0.5}, R: {Y: 0.1}})
    assert [sorted(group.paths) for group in joined] == [[X, Y, R]]
    assert {entry.path for entry in tolerances_of(load(PLAIN, {"tolerance": ENTRIES | {"correlation": table}}))} == set(
        ENTRIES
    )


@pytest.mark.parametrize(
    ("table", "problem", "allowed"),
    [
        (3, "not a table", "OTHER PATH"),
        ({X: 3}, "not a table", "OTHER PATH"),
        ({X: {}}, "not a table", "OTHER PATH"),
        ({X: {Y: 1}}, "not a correlation", "between -1 and 1"),
        ({X: {Y: -1.5}}, "not a correlation", "between -1 and 1"),
        ({X: {Y: "0.5"}}, "not a correlation", "between -1 and 1"),
        ({X: {Y: True}}, "not a correlation", "between -1 and 1"),
        ({X: {X: 0.5}}, "with itself", "two entries"),
        ({X: {Y: 0.5}, Y: {X: 0.4}}, "given twice", "one of the two"),
        ({X: {SUN: 0.5}}, "3 and 1 draws", "same number"),
        ({X: {"deviations.main.ring.run_out": 0.5}}, "is not normal", "normal"),
        ({X: {"deviations.main.planet.position.z": 0.5}}, "no tolerance at", X),
        ({"deviations.main.planet.position.z": {X: 0.5}}, "no tolerance at", X),
        ({X: {Y: 0.9, R: -0.9}, Y: {R: 0.9}}, "not positive definite (least eigenvalue -0.8)", "smaller"),
        ({X: {Y: 0.9999999}}, "not positive definite", "smaller"),
    ],
)
def test_what_is_no_correlation(table: object, problem: str, allowed: str) -> None:
    with pytest.raises(ModelError) as error:
        correlated(table)
    assert error.value.path.startswith("tolerance.correlation")
    assert problem in error.value.problem
    assert allowed in error.value.allowed


def test_nan_is_refused_before() -> None:
    with pytest.raises(ModelError, match="not a number"):
        correlated({X: {Y: float("nan")}})
