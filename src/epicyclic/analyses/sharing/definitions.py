"""Load-sharing coefficients by name, gathered over a record piece by piece.

A group is the meshes of one pair and one side, N of them, one per branch; the slices of a mesh are added up first.

    cycle-peak       P_i = peak of mesh i in a mesh cycle, b_i = N P_i / sum_j P_j, coefficient 1 + max |b_i - 1|
                     over the cycles [ren2021, eq. 21-24, with the sum of the peaks as divisor]
    signed-overload  the same without the absolute value: the largest b_i
    simultaneous     largest N F_i(t) / sum_j F_j(t) over the record
    record-peak      N max_t F_i / sum_j max_t F_j
    worst-case       cycle-peak over the whole hunting period
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import lcm

import numpy as np
from numpy.typing import NDArray

from ...system.faces import faces
from ...system.system import Array, MeshRows

__all__ = [
    "DEFINITIONS",
    "Group",
    "Tally",
    "coefficients",
    "cycle_ratio",
    "groups",
    "merge",
    "samples_per_cycle",
    "simultaneous",
    "tally",
]

DEFINITIONS = ("cycle-peak", "simultaneous", "record-peak", "signed-overload", "worst-case")

Group = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tally:
    """Extremes over a piece of record, (m,) each.

    ratio_high, ratio_low : largest and smallest cycle-peak ratio b.  simultaneous : largest ratio at one instant.
    peak, least : largest and smallest force [N].  A ratio to forces that sum to nothing or less is inf.
    """

    ratio_high: Array
    ratio_low: Array
    simultaneous: Array
    peak: Array
    least: Array


def groups(meshes: MeshRows) -> list[Group]:
    """Indices of the meshes (slices of one counted once) of each pair and side, in order of first appearance."""
    keys = [(meshes.pair[i], meshes.side[i]) for i in faces(meshes).first.tolist()]
    return [np.array([i for i, other in enumerate(keys) if other == key]) for key in dict.fromkeys(keys)]


def samples_per_cycle(meshes: MeshRows, chosen: Group, least: int) -> int:
    """Samples of a mesh cycle that equal branches whose meshes are equally out of phase are seen alike with.

    The smallest number, `least` or above, that the branches of every group of the meshes `chosen` divide.
    """
    wanted = set(chosen.tolist())
    unit = lcm(*(len(group) for group in groups(meshes) if int(group[0]) in wanted))
    return -(-least // unit) * unit


def tally(force: Array, members: Sequence[Group]) -> Tally:
    """Extremes of a piece of record; force (cycles, m, samples) [N]."""
    peaks = force.max(axis=2)
    ratio = cycle_ratio(peaks, members)
    together = np.empty(force.shape[1])
    for group in members:
        together[group] = simultaneous(force[:, group]).max(axis=(0, 2))
    return Tally(
        ratio_high=ratio.max(axis=0),
        ratio_low=ratio.min(axis=0),
        simultaneous=np.where(np.isnan(together), np.inf, together),
        peak=peaks.max(axis=0),
        least=force.min(axis=(0, 2)),
    )


def merge(a: Tally, b: Tally) -> Tally:
    """Extremes of two pieces together."""
    return Tally(
        ratio_high=np.maximum(a.ratio_high, b.ratio_high),
        ratio_low=np.minimum(a.ratio_low, b.ratio_low),
        simultaneous=np.maximum(a.simultaneous, b.simultaneous),
        peak=np.maximum(a.peak, b.peak),
        least=np.minimum(a.least, b.least),
    )


def cycle_ratio(peaks: Array, members: Sequence[Group]) -> Array:
    """b = N P_i / sum P of each cycle, (cycles, m); peaks (cycles, m) [N].

    Peaks that sum to nothing or less (a linear model pulled open) have no ratio: inf.
    """
    ratio = np.empty_like(peaks)
    for group in members:
        total = peaks[:, group].sum(axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio[:, group] = np.where(total > 0, len(group) * peaks[:, group] / total, np.inf)
    return ratio


def simultaneous(force: Array) -> Array:
    """N F_i / sum_j F_j at every instant of one group, (..., N, samples); nan where the sum is not positive."""
    total = force.sum(axis=-2, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares: Array = np.where(total > 0, force.shape[-2] * force / total, np.nan)
    return shares


def coefficients(record: Tally, worst: Array, members: Sequence[Group]) -> Array:
    """Load-sharing coefficients, (definition, m) in the order of `DEFINITIONS`; worst (m,) of the worst case."""
    cycle_peak = 1.0 + np.maximum(record.ratio_high - 1.0, 1.0 - record.ratio_low)
    record_peak = cycle_ratio(record.peak[None], members)[0]
    return np.array([cycle_peak, record.simultaneous, record_peak, record.ratio_high, worst])
