"""The same equation by scipy's integrators, which choose their steps from an estimated error."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.integrate import solve_ivp

from ...system.system import Array
from .motion import Motion, Numbers
from .right_hand_side import acceleration, drive

__all__ = ["TOLERANCE", "Adaptive", "scale_of", "stride"]

Adaptive = Literal["dop853", "radau"]
TOLERANCE = 1e-8
_NAME = {"dop853": "DOP853", "radau": "Radau"}
# Absolute tolerance per relative one, in the scale of a mode: of modes that hardly move.
_FLOOR = 1e-3


def scale_of(moving: Motion) -> Array:
    """Size of modal coordinates and rates, (2, n): what the load at the start gives the mode it moves most."""
    N = moving.numbers
    at = drive(N, float(N.time[0]), float(N.time[0]))
    F = N.mean.size
    push = np.abs(at.push) + np.abs((at.k * np.abs(at.error[:F])) @ np.abs(N.pulls[:F]))
    elastic = N.squared > 0
    lowest = np.min(N.squared[elastic]) if elastic.any() else 1.0
    omega = np.sqrt(np.where(elastic, N.squared, lowest))
    rate = max(float(np.max(push / omega, initial=0.0)), 1e-12)
    return np.stack([rate / omega, np.full(omega.size, rate)])


def stride(
    N: Numbers, state: Array, times: Array, *, method: Adaptive, scale: Array, tolerance: float = TOLERANCE
) -> Array:
    """Modal states (len(times) - 1, 2, n) at times[1:] from the one at times[0]; nan from where it fails.

    Integration begins anew at times[0] and at every jump of the program.
    """
    n, out = N.squared.size, []
    jumps = N.time[:-1][np.diff(N.time) == 0]
    bounds = [times[0], *np.unique(jumps[(jumps > times[0]) & (jumps < times[-1])]), times[-1]]
    y = state.ravel()
    for low, high in pairwise(bounds):
        before = np.nextafter(high, low)  # what holds up to the jump, not behind it

        def slope(t: float, flat: Array, last: float = before) -> Array:
            return np.concatenate([flat[n:], acceleration(N, drive(N, t, min(t, last)), flat[:n], flat[n:])])

        wanted = times[(times > low) & (times <= high)]
        moments = wanted if wanted.size and wanted[-1] == high else np.append(wanted, high)
        with np.errstate(over="ignore", invalid="ignore"):
            found = solve_ivp(
                slope,
                (low, high),
                y,
                method=_NAME[method],
                t_eval=moments,
                rtol=tolerance,
                atol=tolerance * _FLOOR * scale.ravel(),
            )
        block = np.full((moments.size, 2 * n), np.nan)
        block[: found.y.shape[1]] = found.y.T
        y = block[-1]
        out.append(block[: wanted.size])
        if not np.isfinite(y).all():
            out.append(np.full((times.size - 1 - sum(map(len, out)), 2 * n), np.nan))
            break
    return np.concatenate(out).reshape(-1, 2, n)
