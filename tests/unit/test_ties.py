"""The rule that breaks ties: of values that agree to a billionth the first leads."""

from __future__ import annotations

import numpy as np
import pytest

from epicyclic.ties import descending, largest


@pytest.mark.parametrize("rounding", [0.0, 1e-12, -1e-12])
def test_rounding_names_nothing(rounding: float) -> None:
    values = np.array([1.0, 5.0, 5.0 * (1 + rounding), np.nan, 2.0, 2.0 * (1 - rounding)])
    assert largest(values) == 1
    assert descending(values).tolist() == [1, 2, 4, 5, 0, 3]


def test_what_differs_leads() -> None:
    assert largest([[1.0, 2.0], [2.0 + 1e-6, 0.0]]) == 2
    assert descending([1.0, 1.0 + 1e-6, -3.0, 1.0]).tolist() == [1, 0, 3, 2]
    assert largest([-2.0, -1.0, -1.0 - 1e-12]) == 1


def test_values_that_are_not_known() -> None:
    assert largest([np.nan, np.nan]) == 0
    assert largest([np.nan, 1.0, np.inf]) == 2
