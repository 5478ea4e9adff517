"""Variance shares by pick and freeze: how much of the variance of a scalar each group of uniforms brings.

Of two independent points of a low-discrepancy sequence, a and b, the uniforms of one group at a time are exchanged:
E + 2 evaluations give the first-order and total shares of E groups.  First order by Saltelli's estimator with centred
values [saltelli2010], total by Jansen's [jansen1999].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.sampling import SamplingPlan, scramble_uniforms

__all__ = ["Shares", "variance_shares"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shares:
    """Shares of the variance, each (..., E) [1]; nan where there is no variance.

    first : of a group alone.  total : of a group with all its interactions.  Both lie in 0..1: an estimate beyond, by
    the samples it has, is the end.  Totals of several groups add up to more than 1 where they interact.
    """

    first: Array
    total: Array


def variance_shares(
    evaluate: Callable[[Array], Array], group: NDArray[np.int64], plan: SamplingPlan, *, groups: int
) -> Shares:
    """Shares of groups of uniforms in the variance of scalars.

    Parameters
    ----------
    evaluate : (S, d) uniforms -> (S, ...) scalars; rows with nan are left out.
    group : (d,) group of each uniform, from 0.  groups : number of groups E.
    plan : of one scramble's rows and seed.
    """
    drawn = scramble_uniforms(plan, 0, 2 * group.size)
    first, second = drawn[:, : group.size], drawn[:, group.size :]
    exchanged = [np.where(group == one, second, first) for one in range(groups)]
    values = np.stack([evaluate(u) for u in (first, second, *exchanged)])
    known = np.isfinite(values).all(axis=tuple(i for i in range(values.ndim) if i != 1))
    values = values[:, known]
    if not values.shape[1]:
        empty = np.full((*values.shape[2:], len(exchanged)), np.nan)
        return Shares(first=empty, total=empty)
    centre = values[:2].mean(axis=(0, 1))
    variance = np.square(values[:2] - centre).mean(axis=(0, 1))
    a, b, mixed = values[0], values[1] - centre, values[2:]
    # less than rounding of the values themselves is none
    nothing = variance <= (1e-12 * np.abs(centre)) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        own = (b * (mixed - a)).mean(axis=1) / variance
        total = np.square(mixed - a).mean(axis=1) / (2 * variance)
    own, total = (np.where(nothing, np.nan, np.clip(one, 0.0, 1.0)) for one in (own, total))
    return Shares(first=np.moveaxis(own, 0, -1), total=np.moveaxis(total, 0, -1))
