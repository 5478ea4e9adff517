"""Minimum of a convex function along lines, in batches: its slope rises, with kinks at known places.

The root of the slope is bracketed between kinks by bisection over their order, then found by regula falsi with the
Illinois modification [dowell1971].  SciPy's root finders of the oldest supported version take one function at a time;
a batch asks the laws of thousands of instants at once.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..errors import ConvergenceError
from ..system.system import Array

Slope = Callable[[Array, NDArray[np.int64]], Array]
"""(lengths (t,), instants (t,) of the batch) -> slope at those lengths."""

# Slope at the place found, per slope at the start: a longer search changes the next Newton step by less than that.
_SLOPE_TOLERANCE = 1e-3
# Doublings of an interval without upper end; halvings of one that secants do not close.
_DOUBLINGS, _HALVINGS = 200, 100


def line_minimum(slope: Slope, kinks: Array, start: Array) -> Array:
    """Length (T,) of least value along each line of a batch.

    Between kinks the slope is near linear, so that the secant through two points is exact for a piecewise quadratic.

    Parameters
    ----------
    slope : rising function.  kinks : (T, J) candidate places in any order; only those above zero and finite count.
    start : (T,) slope at zero, negative.

    Raises
    ------
    ConvergenceError : the slope stays negative however far one goes.
    """
    count, J = kinks.shape
    here = np.arange(count, dtype=np.int64)
    places = np.sort(np.where(np.isfinite(kinks) & (kinks > 0), kinks, np.inf), axis=1)
    known = np.sum(np.isfinite(places), axis=1)
    before, after = np.full(count, -1), known.copy()
    low, high = np.zeros(count), np.full(count, np.inf)
    slope_low, slope_high = start.copy(), np.full(count, np.inf)
    for _ in range(J.bit_length() + 1):
        open_ = after - before > 1
        if not open_.any():
            break
        middle = np.clip((before + after) // 2, 0, max(J - 1, 0))
        place = np.where(open_, places[here, middle], low)
        value = slope(place, here)
        falling, rising = open_ & (value <= 0), open_ & (value > 0)
        before, after = np.where(falling, middle, before), np.where(rising, middle, after)
        low, slope_low = np.where(falling, place, low), np.where(falling, value, slope_low)
        high, slope_high = np.where(rising, place, high), np.where(rising, value, slope_high)
    high, slope_high = _bracketed(slope, low, high, slope_high)
    return _regula_falsi(slope, (low, slope_low), (high, slope_high), -_SLOPE_TOLERANCE * start)


def _bracketed(slope: Slope, low: Array, high: Array, slope_high: Array) -> tuple[Array, Array]:
    """Upper ends (T,) of all intervals and the slopes there, which are positive; open intervals are doubled."""
    high, slope_high = high.copy(), slope_high.copy()
    length = np.maximum(low, 1.0)
    for _ in range(_DOUBLINGS):
        endless = np.flatnonzero(~np.isfinite(high)).astype(np.int64)
        if not endless.size:
            return high, slope_high
        place = low[endless] + length[endless]
        value = slope(place, endless)
        rises = value > 0
        high[endless[rises]], slope_high[endless[rises]] = place[rises], value[rises]
        length[endless] *= 2
    raise ConvergenceError("the energy falls without end along a motion; something holds too weakly or not at all")


def _regula_falsi(slope: Slope, lower: tuple[Array, Array], upper: tuple[Array, Array], level: Array) -> Array:
    """A place (T,) inside each interval where the slope is within `level` (T,) of zero.

    Illinois method [dowell1971].
    """
    (low, slope_low), (high, slope_high) = lower, upper
    place = low.copy()
    todo = np.flatnonzero(-slope_low > level).astype(np.int64)
    # an end that stays is given half its slope (Illinois), so that both ends move
    side = np.zeros(len(low), dtype=np.int64)
    for _ in range(_HALVINGS):
        if not todo.size:
            break
        a, b, fa, fb = low[todo], high[todo], slope_low[todo], slope_high[todo]
        trial = a - fa * (b - a) / (fb - fa)
        value = slope(trial, todo)
        place[todo] = trial
        falls = value <= 0
        low[todo[falls]], slope_low[todo[falls]] = trial[falls], value[falls]
        high[todo[~falls]], slope_high[todo[~falls]] = trial[~falls], value[~falls]
        stale = np.where(falls, 1, -1)
        again = stale == side[todo]
        slope_high[todo[again & falls]] /= 2
        slope_low[todo[again & ~falls]] /= 2
        side[todo] = stale
        narrow = high[todo] - low[todo] <= 4 * np.finfo(float).eps * high[todo]
        todo = todo[(np.abs(value) > level[todo]) & ~narrow]
    return place
