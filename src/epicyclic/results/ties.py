"""Ties in a result are broken by a rule, on any machine: of values that rounding alone tells apart the first leads.

Branches that carry the same load differ by the rounding of one processor's kernels, 1e-15 to 1e-12 of the load; what an
engineer tells apart stands in the fourth digit.  Between the two no name may hang on the last bit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Responses are solved to 3e-5 of their dynamic part; values that differ by less than this share are equal.
EQUAL = 1e-4
# Share within which values of a direct solution are equal.
_ROUNDING = 1e-9


def ranked(values: ArrayLike, *, equal: float = _ROUNDING) -> NDArray[np.int64]:
    """Places of values (n,), the largest first, nan last; of values equal to the largest of them the first leads.

    Values below 1e-9 of the largest magnitude are 0, as tables show them: a mode at rest has the force of rounding.

    equal : share [1] of the largest magnitude of a run of equal values within which they are.
    """
    raw = np.asarray(values, dtype=float)
    known = np.nan_to_num(raw, nan=-np.inf)
    known[np.abs(known) <= _ROUNDING * np.abs(raw[np.isfinite(raw)]).max(initial=0.0)] = 0.0
    order: list[int] = []
    run: list[int] = []
    for index in np.argsort(-known, kind="stable").tolist():
        if run and not known[index] >= known[run[0]] - equal * abs(known[run[0]]):
            order += sorted(run)
            run = []
        run.append(index)
    return np.array(order + sorted(run), dtype=np.int64)


def largest(values: ArrayLike, *, equal: float = _ROUNDING) -> int:
    """Place of the largest of values (any shape) in row-major order, nan below every number, of equal ones the first.

    0 where none is known.
    """
    known = np.nan_to_num(np.ravel(np.asarray(values, dtype=float)), nan=-np.inf, posinf=np.inf, neginf=-np.inf)
    most = known.max(initial=-np.inf)
    return int(np.argmax(known >= most - equal * abs(most))) if np.isfinite(most) else int(np.argmax(known == most))


def first_largest(values: ArrayLike, *, equal: float = EQUAL) -> tuple[int, ...]:
    """Indices of the largest of values of any shape, as of `largest`.

    ValueError where none is known, as of numpy.nanargmax.
    """
    array = np.asarray(values, dtype=float)
    if np.isnan(array).all():
        raise ValueError("no value is known")
    return tuple(int(index) for index in np.unravel_index(largest(array, equal=equal), array.shape))
