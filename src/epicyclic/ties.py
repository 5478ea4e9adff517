"""Ties in a result are broken by a rule: of values that agree to a billionth, the first in the order given leads.

Branches that carry the same load differ by the rounding of one processor's kernels, some 1e-15 to 1e-12 of the load;
what an engineer tells apart stands in the fourth digit.  Between the two no name may hang on the last bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["descending", "largest"]

_TIE = 1e-9


def largest(values: Any, tie: float = _TIE) -> int:
    """Flat index of the largest of values (any shape), equal within `tie` of it; nan is below every number; else 0."""
    flat = np.ravel(np.asarray(values, dtype=float))
    known = np.isfinite(flat)
    if np.any(flat == np.inf) or not known.any():
        return int(np.argmax(flat == np.inf))
    least = flat[known].max() - tie * np.abs(flat[known]).max()
    return int(np.argmax(known & (flat >= least)))


def descending(values: Any) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Indices (n,) of values (n,), the largest first; nan as 0 behind the positive, equals in the order given."""
    flat = np.nan_to_num(np.asarray(values, dtype=float))
    order = np.argsort(-flat, kind="stable")
    falling = flat[order]
    ranks, leader = np.zeros(len(flat), dtype=int), 0
    for place in range(1, len(flat)):  # a group is what agrees with its largest, so it cannot grow without bound
        if falling[leader] - falling[place] > _TIE * abs(falling[leader]):
            leader = place
        ranks[place] = leader
    return order[np.lexsort((order, ranks))]
