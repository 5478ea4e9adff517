"""Phases of a mesh cycle: evenly spaced, and at the corners of contact; means and harmonics between them.

The state of contact has a kink, of spur teeth a jump, where the end of a contact line passes a corner of the flank.
Between corners it is smooth, so that the extremes over the cycle converge with the second order in the distance of the
phases once the corners are among them; a jump is taken from both sides.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import spherical_jn

from .line_load import averaging_length
from .lines import PlaneOfAction

__all__ = ["corner_phases", "cycle_harmonics", "cycle_mean", "graded_phases"]

Array = NDArray[np.float64]

# Distance of the two sides of a jump [base pitches]: far above the rounding of a place on the path, far below any
# distance that matters.
_SIDE = 1e-9


def corner_phases(plane: PlaneOfAction) -> Array:
    """Places sigma in [0, 1) of one pair of teeth at mid-face, at which a contact line passes a corner of the flank.

    Of helical teeth also those at which a line that begins or ends at a corner has the length over which loads are
    averaged, where their mean is largest; of spur teeth both sides of the jumps.
    """
    low, high = plane.limits
    if plane.per_pitch == 0:
        return np.mod([low - _SIDE, low + _SIDE, high - _SIDE, high + _SIDE], 1.0)
    ends = np.array(plane.face) * plane.per_pitch
    part = averaging_length(plane) * math.cos(plane.base_helix) * abs(plane.per_pitch)
    passed = [limit - end for limit in (low, high) for end in ends]
    return np.mod([*passed, low - ends.max() + part, high - ends.min() - part], 1.0)


def graded_phases(corners: ArrayLike, count: int) -> Array:
    """Phases (T,) of a cycle, rising from 0: `count` even ones and the corners (C,), each once."""
    phase = np.unique(np.concatenate([np.arange(count) / count, np.mod(np.asarray(corners, dtype=float), 1.0)]))
    apart = np.diff(phase, append=phase[0] + 1.0)
    return np.asarray(phase[apart > 0.1 * _SIDE])


def _pieces(values: Array, phase: Array) -> tuple[Array, Array, Array, Array]:
    """Lengths (T,) and middles (T,) of the pieces of a cycle, means and differences (..., T) of their end values."""
    length = np.diff(phase, append=phase[0] + 1.0)
    following = np.roll(values, -1, axis=-1)
    return length, phase + 0.5 * length, 0.5 * (values + following), following - values


def cycle_mean(values: Array, phase: Array) -> Array:
    """Mean over the cycle (...) of values (..., T) at rising phases (T,), linear between them, in their unit."""
    length, _, mean, _ = _pieces(values, phase)
    return np.asarray(mean @ length)


def cycle_harmonics(values: Array, phase: Array, count: int) -> NDArray[np.complex128]:
    """One-sided complex amplitudes c_l (..., count + 1) as of `loaded_contact.harmonics`, of uneven phases (T,).

    Those of the values linear between the phases, exactly (derived here): a piece of length h about m adds
    h exp(-i w m) [mean j_0(w h/2) - i/2 difference j_1(w h/2)], w = 2 pi l.
    """
    length, middle, mean, difference = _pieces(values, phase)
    order = np.arange(count + 1)
    angle = np.pi * np.outer(order, length)
    turn = length * np.exp(-2j * np.pi * np.outer(order, middle))
    even, odd = turn * spherical_jn(0, angle), turn * spherical_jn(1, angle)
    found = mean @ even.T - 0.5j * (difference @ odd.T)
    found[..., 1:] *= 2
    return np.asarray(found, dtype=np.complex128)
