"""Load per length of contact line, as the mean over a stated length of the line.

A line that begins at a corner of an unmodified flank bears on a tooth that is not yet deflected.  As its length goes to
zero, its load per length rises to what the line contact alone needs for the whole approach, under a force of zero: a
value at a point grows with every refinement.  The line contact [weber1953] is plane between the flank and the middle of
the tooth, a depth of almost a module, and has no meaning over shorter lengths.  The mean over a length of that size is
what the theory can state, and it converges (derived here).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .lines import ContactLines, PlaneOfAction

__all__ = ["END_PART", "LineWindows", "averaging_length", "largest_part_mean", "line_windows"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]


END_PART = 0.1
"""Part of a face over which the largest load per width is a mean [1].  At an end that is not relieved the load per
width grows with the logarithm of the slices; over a tenth of the face it changes by 4e-4 from 20 slices to 80."""


def largest_part_mean(force: Array) -> Array:
    """Largest force per slice (...) [N], as the mean over any `END_PART` of the face, of forces (..., K) of K slices.

    With fewer slices than parts it is that of the largest slice.  A load that is linear over the face, 1 + a at its
    end, gives 1 + 0.9 a.
    """
    count = force.shape[-1]
    edges = np.arange(count + 1) / count
    # the mean is linear between places where either end of the window is at the edge of a slice
    begin = np.unique(np.clip(np.concatenate([edges, edges - END_PART]), 0.0, 1.0 - END_PART))
    summed = np.concatenate([np.zeros((*force.shape[:-1], 1)), np.cumsum(force, axis=-1)], axis=-1)

    def up_to(place: Array) -> Array:
        at = np.minimum((place * count).astype(np.int64), count - 1)
        return np.asarray(summed[..., at] + (place * count - at) * force[..., at])

    part = up_to(begin + END_PART) - up_to(begin)
    return np.asarray(part.max(axis=-1) / (END_PART * count))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineWindows:
    """A window on the contact line about every segment, moved to lie within the line.

    length : of all windows along the line [m].  sigma : (T, J, K) place of their middles [base pitches].
    first, last : (T, J, K) slices in which they begin and end.  before, within : (T, J, K) shares of the forces of
    these slices that lie before the beginning, and before the end [1].
    """

    length: float
    sigma: Array
    first: Index
    last: Index
    before: Array
    within: Array

    def mean(self, force: Array) -> Array:
        """Mean load per length (..., T, J, K) [N/m] of forces on the segments (..., T, J, K) [N]."""
        summed = np.cumsum(force, axis=-1) - force

        def up_to(slices: Index, share: Array) -> Array:
            at = np.broadcast_to(slices, force.shape)
            return np.take_along_axis(summed, at, -1) + share * np.take_along_axis(force, at, -1)

        return np.asarray((up_to(self.last, self.within) - up_to(self.first, self.before)) / self.length)


def averaging_length(plane: PlaneOfAction) -> float:
    """Length of contact line over which loads are averaged [m]: normal base pitch over pi, m_n cos alpha_n.

    At most the width of the face.
    """
    slant = math.cos(plane.base_helix)
    return min(plane.base_pitch * slant / math.pi, plane.width / slant)


def line_windows(plane: PlaneOfAction, lines: ContactLines) -> LineWindows:
    """Windows of `averaging_length` on contact lines; a shorter line is averaged over that length all the same."""
    slant, length = math.cos(plane.base_helix), averaging_length(plane)
    touched = lines.length > 0
    half = 0.5 * lines.length * slant
    start, end = lines.zeta - half, lines.zeta + half
    left = np.where(touched, start, np.inf).min(axis=2, keepdims=True)
    right = np.where(touched, end, -np.inf).max(axis=2, keepdims=True)
    reach = np.minimum(0.5 * length * slant, 0.5 * np.maximum(right - left, 0.0))
    with np.errstate(invalid="ignore"):
        middle = np.where(touched, np.clip(lines.zeta, left + reach, right - reach), lines.zeta)
    reach = np.where(touched, reach, 0.0)

    def located(place: Array) -> tuple[Index, Array]:
        """Slice of each place (T, J, K) [m], and share of its part that lies before the place."""
        slices = np.clip(np.floor((place - plane.face[0]) / lines.span).astype(np.int64), 0, lines.zeta.shape[2] - 1)
        begin, size = np.take_along_axis(start, slices, 2), np.take_along_axis(2 * half, slices, 2)
        share = (place - begin) / np.where(size > 0, size, 1.0)
        return slices, np.clip(np.where(size > 0, share, 0.0), 0.0, 1.0)

    first, before = located(middle - reach)
    last, within = located(middle + reach)
    sigma = lines.sigma + (middle - lines.zeta) * plane.per_pitch
    return LineWindows(length=length, sigma=sigma, first=first, last=last, before=before, within=within)
