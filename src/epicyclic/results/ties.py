"""Ranks of values that rounding alone tells apart: the first in order counts, on any machine."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["EQUAL", "first_largest", "ranked"]

# Responses are solved to 3e-5 of their dynamic part; values that differ by less than this share are equal.
EQUAL = 1e-4


def ranked(values: ArrayLike, *, equal: float = EQUAL) -> NDArray[np.int64]:
    """Places of values (n,), the largest first, nan last; of values equal to the largest of them the first leads.

    equal : share [1] of the largest magnitude of a run of equal values within which they are.
    """
    given = np.nan_to_num(np.asarray(values, dtype=float), nan=-np.inf)
    order = np.argsort(-given, kind="stable")
    found: list[int] = []
    run: list[int] = []
    for place in order.tolist():
        if run and not given[place] >= given[run[0]] - equal * abs(given[run[0]]):
            found += sorted(run)
            run = []
        run.append(place)
    return np.array(found + sorted(run), dtype=np.int64)


def first_largest(values: ArrayLike, *, equal: float = EQUAL) -> tuple[int, ...]:
    """Place of the largest of values of any shape that are not nan, in row-major order the first of equal ones.

    ValueError where none is known, as of numpy.nanargmax.
    """
    given = np.asarray(values, dtype=float)
    most = float(given.flat[int(np.nanargmax(given))])
    with np.errstate(invalid="ignore"):
        place = int(np.argmax(given >= most - equal * abs(most)))
    return tuple(int(one) for one in np.unravel_index(place, given.shape))
