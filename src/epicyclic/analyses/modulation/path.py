"""Path from a mesh to the sensor: the window of a passing planet and the transfer function behind it.

A window is the gain of a planet over the angle between it and the sensor, as a Fourier series:

    w(phi) = Re(c_0 + 2 sum_k c_k exp(i k phi)),  phi = angle of the planet's contact less that of the sensor

A Hann window over 2 pi / N passes one planet at a time [inalpolat2009]; one over a whole turn, ``cos2``, falls smoothly
to the far side of the ring [mcfadden1985].  The transfer function is a table of gain and phase over frequency.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...system.system import Array, ComplexArray

__all__ = [
    "ACCELERATION",
    "Transfer",
    "Window",
    "named_window",
    "tabulated_transfer",
    "tabulated_window",
]

WORDS = "hann, gaussian, cos2, cos4, ..., constant, or a table of angles and gains"
# A window is cut where what is left of it is 1e-8 of its mean square (1e-4 of a line), at the latest at 240 harmonics.
_REMAINDER, _MAX_HARMONICS, _LONG = 1e-8, 240, 4096
_HIGHEST_POWER = 200


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Window:
    """Window as a Fourier series.

    name : for people.  coefficients : (K + 1,) complex c_0 .. c_K, two-sided, c_0 real [1].
    remainder : RMS of the harmonics left out per RMS of the window [1].
    """

    name: str
    coefficients: ComplexArray
    remainder: float = 0.0

    @property
    def sides(self) -> ComplexArray:
        """Coefficients c_-K .. c_K, (2 K + 1,)."""
        both: ComplexArray = np.concatenate([self.coefficients[:0:-1].conj(), self.coefficients])
        return both

    def at(self, angle: ArrayLike) -> Array:
        """Gain at angles [rad], of their shape."""
        phi = np.asarray(angle, dtype=float)[..., None]
        orders = np.arange(1, len(self.coefficients))
        wave = (self.coefficients[1:] * np.exp(1j * orders * phi)).real.sum(axis=-1)
        gain: Array = self.coefficients[0].real + 2 * wave
        return gain


def named_window(word: str, *, planets: int, width: float | None = None) -> Window:
    """Window by name, with gain 1 under the sensor.

    Parameters
    ----------
    word : ``hann``; ``gaussian``; ``cos2``, ``cos4``, ...: cos^n(phi/2); ``constant``.
    planets : N, for the default widths.  width : of ``hann`` from zero to zero, default 2 pi / N; of ``gaussian`` the
        standard deviation, default pi / (2 N) [rad].

    Raises
    ------
    ModelError : no such window; a width out of range or where there is none.
    """
    power = re.fullmatch(r"cos(\d{1,3})", word)
    if word not in ("hann", "gaussian", "constant") and not power:
        raise ModelError("no such window", path="window", given=word, allowed=WORDS)
    if width is not None:
        if word not in ("hann", "gaussian"):
            raise ModelError(f"a window {word} has no width", path="width", given=width, allowed="hann, gaussian")
        if not 0 < width <= 2 * math.pi:
            raise ModelError("out of range", path="width", given=width, allowed="above 0, up to one turn")
    if word == "constant":
        return Window(name=word, coefficients=np.ones(1, complex))
    if power:
        return _cosine_power(word, int(power[1]))
    orders = np.arange(_LONG + 1.0)
    if word == "gaussian":
        sigma = math.pi / (2 * planets) if width is None else width
        return _cut(word, sigma / math.sqrt(2 * math.pi) * np.exp(-((orders * sigma) ** 2) / 2))
    return _cut(word, _hann(orders, (2 * math.pi / planets if width is None else width) / 2))


def tabulated_window(angle: ArrayLike, gain: ArrayLike) -> Window:
    """Window through given gains, linear between them, round the whole turn.

    Parameters
    ----------
    angle : (k,) rising, within one turn [rad].  gain : (k,) none negative, not all zero [1].

    Raises
    ------
    ModelError : empty or unequal columns, a number that is not finite, negative gains, angles that do not rise.
    """
    phi, value = np.atleast_1d(np.asarray(angle, float)), np.atleast_1d(np.asarray(gain, float))
    if not phi.size or phi.shape != value.shape or phi.ndim != 1:
        raise ModelError(
            "needs as many gains as angles, one at least", path="window", given=f"{phi.size}, {value.size}"
        )
    if not (np.isfinite(phi).all() and np.isfinite(value).all()):
        raise ModelError("holds a number that is not finite", path="window")
    if (value < 0).any() or not value.any():
        raise ModelError(
            "gains of a table are not negative, and not all zero",
            path="window",
            given=float(value.min()),
            allowed=">= 0",
        )
    if (np.diff(phi) <= 0).any() or phi[-1] - phi[0] >= 2 * math.pi:
        raise ModelError("angles must rise and stay within one turn", path="window", given=phi.tolist())
    return _cut("table", _piecewise(phi, value, np.arange(_LONG + 1.0)))


def _cosine_power(word: str, power: int) -> Window:
    """Window cos^2p(phi/2) = 4^-p sum_k binomial(2p, p + k) exp(i k phi).

    Raises
    ------
    ModelError : the power is odd or too large.
    """
    if power < 2 or power % 2 or power > _HIGHEST_POWER:
        raise ModelError(
            "the power must be even", path="window", given=word, allowed=f"cos2, cos4 .. cos{_HIGHEST_POWER}"
        )
    half = power // 2
    values = [math.comb(power, half + k) / 4**half for k in range(half + 1)]
    return Window(name=word, coefficients=np.array(values, complex))


def _hann(orders: Array, half: float) -> Array:
    """Fourier coefficients of orders (K,) of cos^2(pi phi / 2 half) for |phi| < half [rad]."""
    edge = math.pi / half
    parts = (np.sinc(half * shift / math.pi) for shift in (orders, orders - edge, orders + edge))
    centre, below, above = parts
    result: Array = half / (2 * math.pi) * (centre + (below + above) / 2)
    return result


def _piecewise(phi: Array, value: Array, orders: Array) -> ComplexArray:
    """Fourier coefficients of orders (K,) of the straight lines through (phi, value), both (k,).

    The second derivative of the lines is the jumps of their slope.
    """
    result = np.zeros(orders.size, complex)
    step = np.diff(phi, append=phi[0] + 2 * math.pi)
    following = np.roll(value, -1)
    result[0] = ((value + following) / 2 * step).sum() / (2 * math.pi)
    slope = (following - value) / step
    jump = slope - np.roll(slope, 1)
    result[1:] = -(np.exp(-1j * np.outer(orders[1:], phi)) @ jump) / (2 * math.pi * orders[1:] ** 2)
    return result


def _cut(name: str, values: Array | ComplexArray) -> Window:
    """Window of the leading coefficients `values` (K + 1,): the remainder is 1e-8 of the mean square, or 240 are
    left.
    """
    power = np.abs(values) ** 2 * np.where(np.arange(len(values)) > 0, 2.0, 1.0)
    left = np.append(np.cumsum(power[::-1])[::-1], 0.0)[1:]  # behind each harmonic
    enough = np.flatnonzero(left <= _REMAINDER * power.sum())
    last = min(int(enough[0]), _MAX_HARMONICS)
    return Window(
        name=name,
        coefficients=np.asarray(values[: last + 1], complex),
        remainder=math.sqrt(float(left[last] / power.sum())),
    )


ACCELERATION = "m/s2/N"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Transfer:
    """Transfer function, signal per force.

    frequency : (k,) rising [Hz].  gain : (k,).  phase : (k,) unwrapped [rad].
    unit : ``1``, the signal stays a force; ``m/s2/N``, it becomes an acceleration.
    """

    frequency: Array
    gain: Array
    phase: Array
    unit: str

    def at(self, frequency: Array) -> ComplexArray:
        """Complex gain at frequencies [Hz], of their shape; gain and phase linear in the table, 0 outside."""
        size = np.interp(frequency, self.frequency, self.gain, left=0.0, right=0.0)
        value: ComplexArray = size * np.exp(1j * np.interp(frequency, self.frequency, self.phase))
        return value

    def covers(self, frequency: Array) -> NDArray[np.bool_]:
        """Whether each frequency [Hz] lies within the table, of their shape."""
        return np.asarray((frequency >= self.frequency[0]) & (frequency <= self.frequency[-1]), bool)


def tabulated_transfer(frequency: ArrayLike, gain: ArrayLike, phase: ArrayLike = 0.0, *, unit: str = "1") -> Transfer:
    """Transfer function from columns of a measured or computed frequency response.

    Parameters
    ----------
    frequency : (k,) rising, not negative [Hz].  gain : (k,) not negative.  phase : (k,) or one [rad].
    unit : of the gain, ``1`` or ``m/s2/N``.

    Raises
    ------
    ModelError : fewer than two rows, unequal columns, numbers out of range or not finite, an unknown unit.
    """
    if unit not in ("1", ACCELERATION):
        raise ModelError("no such unit of a transfer path", path="transfer", given=unit, allowed=f"1, {ACCELERATION}")
    f, size = np.atleast_1d(np.asarray(frequency, float)), np.atleast_1d(np.asarray(gain, float))
    if f.size < 2 or f.shape != size.shape or f.ndim != 1 or np.size(phase) not in (1, f.size):
        raise ModelError("needs two rows or more, and columns of one length", path="transfer", given=f"{f.size} rows")
    angle = np.broadcast_to(np.asarray(phase, float).ravel(), f.shape)
    if not all(np.isfinite(column).all() for column in (f, size, angle)):
        raise ModelError("holds a number that is not finite", path="transfer")
    if f[0] < 0 or (np.diff(f) <= 0).any() or (size < 0).any():
        raise ModelError("frequencies must rise from 0 or more, and gains are not negative", path="transfer")
    return Transfer(frequency=f, gain=size, phase=np.unwrap(angle), unit=unit)
