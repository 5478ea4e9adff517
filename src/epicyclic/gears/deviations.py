"""Deviations from nominal, as complex amplitudes: a real deviation is Re(amplitude exp(2 pi i f t)).

Positive scalar deviations are missing material: they open the gap.
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
    """Complex amplitude at +order x f_mesh of a profile error of one mesh [m].

    ``identical``: all tooth pairs alike, e = E cos(2 pi l sigma), sigma = +-(f t + lead); so the error follows the
    phase of its mesh, and the cosine does not feel the sense.  A number [rad]: e = E cos(2 pi l f t + phase), whatever
    the mesh phase (given angles, or those of `random_phases`).

    amplitude E [m]; order l >= 1; lead [mesh cycles], exact where rational.
    """
    if phase == "identical":
        return amplitude * mesh_phasor(order, lead)
    return complex(amplitude * np.exp(1j * phase))


def random_phases(count: int, seed: int) -> Array:
    """Phases (count,) uniform in [0, 2 pi) [rad], one per mesh, the same for the same seed."""
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, count)


def tooth_phase(teeth: int, mesh_direction: float, gear_angle: float) -> float:
    """Tooth phase tau of a gear at a mesh, in pitches [1]: integer k where tooth k + 1 carries at the pitch point.

    Teeth are numbered counter-clockwise seen from the right end; tooth 1 is the one whose loaded flank crosses the
    body's x axis.  mesh_direction : polar angle of the pitch point from the gear's centre; gear_angle : polar angle
    of the gear's x axis [rad].  A gear at gear_angle = g0 + w t has tau = tooth_phase(z, direction, g0) - z w t / 2 pi.
    """
    return teeth * (mesh_direction - gear_angle) / (2.0 * np.pi)


def pitch_lines(
    deviations: Sequence[float] | Array, *, highest_order: int | None = None
) -> tuple[NDArray[np.int64], ComplexArray]:
    """Shaft orders j (J,) and amplitudes c_j (J,) [m] of a gear's measured pitch deviations as a gap.

    e(tau) = Re sum_j c_j exp(2 pi i j tau / z), period z pitches, equals deviation k + 1 at tau = k and goes linearly
    from tooth to tooth: the load passes from pair to pair, so a mesh feels the mean of the pairs in contact weighted
    by their share, for which the hat weights 1 - |tau - k| stand.  Then c_j = (2/z) DFT_j sinc^2(j/z), c_0 the mean,
    and orders that are multiples of z (the mesh frequency) vanish.

    deviations : (z,) cumulative, tooth 1 first, positive = material missing on the driven flank [m].
    highest_order : default z - 1, all below the mesh frequency; those above are at most a twentieth of the
    deviation each.  The caller puts in tau(t) = tau_0 + rate t of `tooth_phase`.
    """
    samples = np.asarray(deviations, dtype=float)
    teeth = samples.size
    order = np.arange(0, teeth if highest_order is None else highest_order + 1)
    weight = np.sinc(order / teeth) ** 2 * np.where(order == 0, 1.0, 2.0) / teeth
    return order, np.asarray(weight * np.fft.fft(samples)[order % teeth], dtype=np.complex128)
