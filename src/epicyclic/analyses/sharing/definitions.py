"""Load-sharing coefficients by name, gathered over a record piece by piece.

A group is the meshes of one pair and one side, N of them, one per branch; the slices of a mesh are added up first.

    cycle-peak       P_i = peak of mesh i in a mesh cycle, b_i = N P_i / sum_j P_j, coefficient 1 + max |b_i - 1|
                     over the cycles [ren2021, eq. 21-24, with the sum of the peaks as divisor]
    signed-overload  the same without the absolute value: the largest b_i
    simultaneous     largest N F_i(t) / sum_j F_j(t) over the record
    record-peak      N max_t F_i / sum_j max_t F_j
    worst-case       cycle-peak over the whole hunting period
    mean-load, mean-load-turning
                     without mesh-frequency content, of the quasi-static forces at mean mesh stiffness whatever the
                     record (`statics.mean_load`); the first is K_gamma
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...statics.mean_load import MEAN_LOADS
from ...statics.record import MeshGroup
from ...system.system import Array

__all__ = [
    "DEFINITIONS",
    "Extremes",
    "coefficients",
    "cycle_peak_ratio",
    "extremes",
    "instant_ratio",
    "merge_extremes",
]

DEFINITIONS = ("cycle-peak", "simultaneous", "record-peak", "signed-overload", "worst-case", *MEAN_LOADS)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Extremes:
    """Extremes over a piece of record, (m,) each.

    ratio_high, ratio_low : largest and smallest cycle-peak ratio b [1].  simultaneous : largest ratio at one instant
        [1].
    peak, least : largest and smallest force [N].  A ratio to forces that sum to nothing or less is inf.
    """

    ratio_high: Array
    ratio_low: Array
    simultaneous: Array
    peak: Array
    least: Array

    @property
    def cycle_peak(self) -> Array:
        """Coefficient 1 + max |b - 1| over the cycles, (m,) [1] [ren2021, eq. 21-24]."""
        return np.asarray(1.0 + np.maximum(self.ratio_high - 1.0, 1.0 - self.ratio_low))


def extremes(force: Array, members: Sequence[MeshGroup]) -> Extremes:
    """Extremes of a piece of record; force (cycles, m, samples) [N], members : groups of the m meshes."""
    peaks = force.max(axis=2)
    ratio = cycle_peak_ratio(peaks, members)
    together = np.empty(force.shape[1])
    for group in members:
        together[group] = instant_ratio(force[:, group]).max(axis=(0, 2))
    return Extremes(
        ratio_high=ratio.max(axis=0),
        ratio_low=ratio.min(axis=0),
        simultaneous=np.where(np.isnan(together), np.inf, together),
        peak=peaks.max(axis=0),
        least=force.min(axis=(0, 2)),
    )


def merge_extremes(a: Extremes, b: Extremes) -> Extremes:
    """Extremes of two pieces together, (m,) each."""
    return Extremes(
        ratio_high=np.maximum(a.ratio_high, b.ratio_high),
        ratio_low=np.minimum(a.ratio_low, b.ratio_low),
        simultaneous=np.maximum(a.simultaneous, b.simultaneous),
        peak=np.maximum(a.peak, b.peak),
        least=np.minimum(a.least, b.least),
    )


def cycle_peak_ratio(peaks: Array, members: Sequence[MeshGroup]) -> Array:
    """b = N P_i / sum P of each cycle, (cycles, m) [1]; peaks (cycles, m) [N] [ren2021, eq. 21-24].

    Peaks that sum to nothing or less (a linear model pulled open) have no ratio: inf.
    """
    ratio = np.empty_like(peaks)
    for group in members:
        total = peaks[:, group].sum(axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio[:, group] = np.where(total > 0, len(group) * peaks[:, group] / total, np.inf)
    return ratio


def instant_ratio(force: Array) -> Array:
    """N F_i / sum_j F_j at every instant of one group, (..., N, samples) [1]; nan where the sum is not positive."""
    total = force.sum(axis=-2, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares: Array = np.where(total > 0, force.shape[-2] * force / total, np.nan)
    return shares


def coefficients(record: Extremes, worst: Array, mean_load: Array, members: Sequence[MeshGroup]) -> Array:
    """Load-sharing coefficients, (definition, m) [1] in the order of `DEFINITIONS`.

    Parameters
    ----------
    worst : (m,) of the worst case.  mean_load : (2, m) by `MEAN_LOADS`.
    """
    record_peak = cycle_peak_ratio(record.peak[None], members)[0]
    return np.array([record.cycle_peak, record.simultaneous, record_peak, record.ratio_high, worst, *mean_load])
