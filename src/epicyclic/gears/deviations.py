"""Spectral lines of profile and pitch deviations: a deviation is Re(amplitude exp(2 pi i f t)).

A positive deviation is missing material and opens the gap (docs/conventions.md, Forces, stiffness, errors).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .series import mesh_phasor

__all__ = [
    "pitch_lines",
    "profile_amplitude",
    "random_phases",
    "tooth_phase",
]

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def profile_amplitude(
    amplitude: float,
    order: int,
    phase: float | Literal["identical"] = "identical",
    *,
    lead: Fraction | float = 0,
) -> complex:
    """Complex amplitude of the profile error of one mesh at `order` times its mesh frequency [m].

    phase : ``identical`` for teeth that are all alike, e = E cos(2 pi l sigma) with sigma = +-(f t + lead)
    (docs/conventions.md, Phases): the error follows the phase of its mesh, and the cosine is even in the sense.
    A number [rad] gives e = E cos(2 pi l f t + phase) at any mesh phase (given angles, or those of `random_phases`).

    amplitude E [m].  order : l >= 1.  lead : [mesh cycles], exact where rational.
    """
    if phase == "identical":
        return amplitude * mesh_phasor(order, lead)
    return complex(amplitude * np.exp(1j * phase))


def random_phases(count: int, seed: int) -> Array:
    """Phases (count,) uniform in [0, 2 pi) [rad], one a mesh, reproducible by the seed."""
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, count)


def tooth_phase(teeth: int, mesh_direction: float, gear_angle: float) -> float:
    """Tooth phase tau of a gear at a mesh [pitches]: integer k where tooth k + 1 carries at the pitch point.

    Teeth are numbered counter-clockwise as seen from the right end.  The loaded flank of tooth 1 crosses the x axis of
    the body.  mesh_direction : polar angle of the pitch point from the centre of the gear [rad].  gear_angle : polar
    angle of the x axis of the gear [rad].  With gear_angle = g0 + w t the tooth phase is
    tooth_phase(z, direction, g0) - z w t / 2 pi.  Derived here.
    """
    return teeth * (mesh_direction - gear_angle) / (2.0 * np.pi)


def pitch_lines(
    deviations: Sequence[float] | Array, *, highest_order: int | None = None
) -> tuple[NDArray[np.int64], ComplexArray]:
    """Shaft orders j (J,) and amplitudes c_j (J,) [m] of the gap that measured pitch deviations of a gear leave.

    e(tau) = Re sum_j c_j exp(2 pi i j tau / z) has the period of z pitches.  It equals deviation k + 1 at tau = k and
    is linear from tooth to tooth: the error of a mesh is the mean of the tooth pairs in contact weighted by their share
    of the load, and the hat function 1 - |tau - k| stands for that share.  Hence c_j = (2/z) DFT_j sinc^2(j/z), c_0 is
    the mean, and orders that are multiples of z (the mesh frequency) vanish.  Derived here.

    deviations : (z,) cumulative, tooth 1 first, positive = material missing on the driven flank [m].
    highest_order : default z - 1, all below the mesh frequency; each order above is at most a twentieth of the
    deviation.  The caller inserts tau(t) = tau_0 + rate t of `tooth_phase`.
    """
    samples = np.asarray(deviations, dtype=float)
    teeth = samples.size
    order = np.arange(0, teeth if highest_order is None else highest_order + 1)
    weight = np.sinc(order / teeth) ** 2 * np.where(order == 0, 1.0, 2.0) / teeth
    return order, np.asarray(weight * np.fft.fft(samples)[order % teeth], dtype=np.complex128)
