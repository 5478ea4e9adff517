"""The path from the teeth to the sensor as a function of frequency: gain and phase, from a table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...system.system import Array, ComplexArray

__all__ = ["ACCELERATION", "Transfer", "transfer_of_table"]

ACCELERATION = "m/s2/N"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Transfer:
    """Signal per force.  frequency : (k,) rising [Hz].  gain : (k,).  phase : (k,) unwrapped [rad].
    unit : ``1``, the signal stays a force; ``m/s2/N``, it becomes an acceleration."""

    frequency: Array
    gain: Array
    phase: Array
    unit: str

    def at(self, frequency: Array) -> ComplexArray:
        """Values at frequencies [Hz], gain and phase straight between those given; 0 outside the table."""
        size = np.interp(frequency, self.frequency, self.gain, left=0.0, right=0.0)
        value: ComplexArray = size * np.exp(1j * np.interp(frequency, self.frequency, self.phase))
        return value

    def covers(self, frequency: Array) -> NDArray[np.bool_]:
        """Whether each frequency lies within the table."""
        return np.asarray((frequency >= self.frequency[0]) & (frequency <= self.frequency[-1]), bool)


def transfer_of_table(frequency: ArrayLike, gain: ArrayLike, phase: ArrayLike = 0.0, *, unit: str = "1") -> Transfer:
    """A transfer path from columns of a measured or computed frequency response.

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
