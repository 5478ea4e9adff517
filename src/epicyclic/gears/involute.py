"""The involute function and its inverse, to the last digits also where tan(angle) - angle cancels."""

from __future__ import annotations

from typing import overload

import numpy as np
from numpy.typing import NDArray

__all__ = ["inverse_involute", "involute"]

Array = NDArray[np.float64]

# tan a - a = a^3/3 + 2 a^5/15 + ...; below _SMALL the first omitted term is 3e-18 of the first.
_SERIES = (
    1 / 3,
    2 / 15,
    17 / 315,
    62 / 2835,
    1382 / 155925,
    21844 / 6081075,
    929569 / 638512875,
    6404582 / 10854718875,
)
_SMALL = 0.1


@overload
def involute(angle: float) -> float: ...
@overload
def involute(angle: Array) -> Array: ...
def involute(angle: float | Array) -> float | Array:
    """Involute function inv a = tan a - a [iso21771], by its series where the difference cancels.

    angle : pressure angle, |angle| < pi/2, a float or of shape (...) [rad].  Returns the same shape [rad].
    """
    values = np.asarray(angle, dtype=float)
    square = np.minimum(values**2, _SMALL**2)
    series = values * square * np.polynomial.polynomial.polyval(square, _SERIES)
    return _like(angle, np.where(np.abs(values) < _SMALL, series, np.tan(values) - values))


@overload
def inverse_involute(value: float) -> float: ...
@overload
def inverse_involute(value: Array) -> Array: ...
def inverse_involute(value: float | Array) -> float | Array:
    """Inverse involute function: pressure angle whose involute is `value`, within 1e-14 rad.

    value : a float or of shape (...) [rad]; negative values give negative angles, nan gives nan.  Returns the same
    shape [rad].  Newton's method on the whole array: from a start above or near the root it needs no bracket, and the
    last digits of every working pressure angle are those of this iteration.
    """
    given = np.asarray(value, dtype=float)
    size = np.abs(given)
    root = np.cbrt(3.0 * size)
    # u = tan(angle) solves u - atan u = value: u ~ root + root^3/5 near zero, u < value + pi/2 always.
    tangent = np.minimum(root + root**3 / 5.0, size + 0.5 * np.pi)
    angle = np.arctan(tangent)
    for _ in range(8):
        slope = np.maximum(np.tan(angle) ** 2, np.finfo(float).tiny)
        angle = np.clip(angle - (np.asarray(involute(angle)) - size) / slope, 0.0, 0.5 * np.pi)
    return _like(value, np.copysign(angle, given))


def _like(model: float | Array, values: Array) -> float | Array:
    """Values (...) [rad] as a float where the argument was one."""
    return values if isinstance(model, np.ndarray) else float(values)
