"""The rule that breaks ties: of values that agree to a billionth the first leads."""

from __future__ import annotations

import numpy as np
import pytest

from epicyclic.results.dataset import first_largest, largest, ranked


@pytest.mark.parametrize("rounding", [0.0, 1e-12, -1e-12])
def test_rounding_names_nothing(rounding: float) -> None:
    values = np.array([1.0, 5.0, 5.0 * (1 + rounding), np.nan, 2.0, 2.0 * (1 - rounding)])
    assert largest(values) == 1
    assert ranked(values).tolist() == [1, 2, 4, 5, 0, 3]


def test_what_differs_leads() -> None:
    assert largest([[1.0, 2.0], [2.0 + 1e-6, 0.0]]) == 2
    assert ranked([1.0, 1.0 + 1e-6, -3.0, 1.0]).tolist() == [1, 0, 3, 2]
    assert largest([-2.0, -1.0, -1.0 - 1e-12]) == 1


def test_values_that_are_not_known() -> None:
    assert largest([np.nan, np.nan]) == 0
    assert largest([np.nan, 1.0, np.inf]) == 2


def test_indices_of_the_largest() -> None:
    assert first_largest([[1.0, np.nan], [3.0, 3.0 * (1 + 1e-6)]]) == (1, 0)
    assert first_largest([[1.0, np.nan], [3.0, 3.0 * (1 + 1e-3)]]) == (1, 1)
    with pytest.raises(ValueError, match="known"):
        first_largest([np.nan])


def test_values_that_rounding_alone_makes_are_ranked_by_place() -> None:
    """Modes that no order excites have forces of 1e-13 N beside one of 10 N, in an order of each kernel."""
    assert ranked([1e-13, 10.0, 7e-13, np.nan, -2e-13, 0.0], equal=1e-4).tolist() == [1, 0, 2, 4, 5, 3]
    assert ranked([1e-13, 7e-13, np.nan, np.inf]).tolist() == [3, 1, 0, 2]
