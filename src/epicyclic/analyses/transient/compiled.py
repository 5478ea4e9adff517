"""The equation of motion compiled with numba, and classical Runge-Kutta steps [hairer1993, sec. II.1] over it.

Sums run in one order whatever the machine has, so that a run continued from its last state is the run, bit by bit.
A compiled caller kept on disk does not notice a change in another file: all compiled functions stand here.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from ...system.system import Array
from .motion import Numbers

__all__ = ["advance"]

_jit = numba.njit(cache=True, error_model="numpy")
TURN = 2 * np.pi


@_jit
def _instant_terms(
    N: Numbers, t: float, middle: float, k: Array, e: Array, de: Array, push: Array
) -> tuple[float, float]:
    """Fill in k (F,) [N/m], errors e (M,) [m], rates de (M,) [m/s], modal force push (n,); returns s and s'."""
    low = min(max(int(np.searchsorted(N.time, middle, side="right")) - 1, 0), N.time.size - 2)
    span, since = N.time[low + 1] - N.time[low], t - N.time[low]
    rise = (N.speed[low + 1] - N.speed[low]) / span
    s = N.speed[low] + rise * since
    tau = N.phase[low] + since * (N.speed[low] + rise * since / 2)
    n, F, L = push.size, N.mean.size, N.wave.shape[2]
    for f in range(F):
        angle = TURN * tau * N.tones[N.tone[f]]
        c1, s1 = np.cos(angle), np.sin(angle)
        c, w, total = c1, s1, 1.0
        for order in range(L):
            total += N.wave[0, f, order] * c - N.wave[1, f, order] * w
            c, w = c * c1 - w * s1, c * s1 + w * c1
        k[f] = N.mean[f] * total
    e[:] = 0.0
    de[:] = 0.0
    e[:F] = N.opening
    for j in range(N.gap_at.size):
        angle, turn = TURN * N.gap_at[j] * tau, TURN * N.gap_at[j] * s
        c, w = np.cos(angle), np.sin(angle)
        for r in range(e.size):
            e[r] += c * N.gap[0, j, r] - w * N.gap[1, j, r]
        if N.rated:
            for r in range(e.size):
                de[r] -= turn * (w * N.gap[0, j, r] + c * N.gap[1, j, r])
    for i in range(n):
        push[i] = N.steady[i] + rise * N.spin[i]
    for j in range(N.load.shape[0]):
        level = N.level[low, j] + (N.level[low + 1, j] - N.level[low, j]) * (since / span)
        for i in range(n):
            push[i] += level * N.load[j, i]
    for j in range(N.force_at.size):
        angle = TURN * N.force_at[j] * tau
        c, w = np.cos(angle), np.sin(angle)
        power = 1.0
        for p in range(4):
            if p == 3:
                power = rise
            if power != 0.0:
                for i in range(n):
                    push[i] += power * (c * N.force[0, p, j, i] - w * N.force[1, p, j, i])
            power *= s
    return s, rise


@_jit
def _operators(N: Numbers, s: float, rise: float, stiff: Array, damp: Array) -> None:
    """Fill in the speed-dependent operators (n, n) of position and rate, transposed."""
    n = N.squared.size
    for i in range(n):
        for j in range(n):
            stiff[i, j] = s * s * N.stiff[0, i, j] + s * N.stiff[1, i, j] + rise * N.stiff[2, i, j]
            damp[i, j] = N.damp[0, i, j] + s * N.damp[1, i, j]


@_jit
def _groups(N: Numbers, x: Array, u: Array, e: Array, de: Array, r: Array) -> None:
    """Add the forces of the law groups to the row residuals r (M,) [N]; stretch x [m] and rate u [m/s], (M,)."""
    F = N.mean.size
    for g in range(N.laws.shape[0]):
        first, count = F + int(N.laws[g, 0]), int(N.laws[g, 1])
        k, friction, lag = N.laws[g, 2], N.laws[g, 3], N.laws[g, 8]
        rho, radial = 0.0, 0.0
        for i in range(first, first + count):
            rho += (x[i] - e[i]) ** 2
            radial += (x[i] - e[i]) * (u[i] - de[i])
        rho = np.sqrt(rho)
        value, slope = min(k * rho, friction), k if rho < N.laws[g, 4] else 0.0
        beyond = rho - N.laws[g, 5]
        if beyond >= 0.0:
            value += N.laws[g, 6] * beyond ** N.laws[g, 7]
            slope += N.laws[g, 6] * N.laws[g, 7] * beyond ** (N.laws[g, 7] - 1.0)
        secant = value / rho if rho > 0.0 else slope
        for i in range(first, first + count):
            gap, speed = x[i] - e[i], u[i] - de[i]
            if friction < 0.0:
                force = k * (gap - N.anchor[i - F]) + lag * k * speed
            else:
                along = radial / (rho * rho) * gap if rho > 0.0 else 0.0
                force = secant * gap + lag * (slope * along + secant * (speed - along))
            total = 0.0
            for j in range(N.block.shape[0]):
                total += N.block[i - F, j] * x[F + j]
            r[i] = total - force


@_jit
def _slope(
    N: Numbers, k: Array, e: Array, de: Array, push: Array, stiff: Array, damp: Array,
    turning: bool, y: Array, v: Array, x: Array, u: Array, r: Array, a: Array,
) -> None:  # fmt: skip
    """Fill in y'' a (n,) of the state y, v (n,); x, u, r (M,) are work space."""
    n, M, F = y.size, e.size, N.mean.size
    x[:] = 0.0
    u[:] = 0.0
    for j in range(n):
        for i in range(M):
            x[i] += N.gaps[j, i] * y[j]
    if N.rated:
        for j in range(n):
            for i in range(M):
                u[i] += N.gaps[j, i] * v[j]
    for i in range(F):
        gap = x[i] - e[i]
        force = 0.0
        if N.pull or gap > 0.0:
            force = k[i] * gap + N.drag[i] * (u[i] - de[i])
        r[i] = N.linear[i] * x[i] - force
    if M > F:
        _groups(N, x, u, e, de, r)
    for i in range(n):
        a[i] = push[i] - N.squared[i] * y[i] - N.rate[i] * v[i]
    for j in range(M):
        for i in range(n):
            a[i] += N.pulls[j, i] * r[j]
    if turning:
        for j in range(n):
            for i in range(n):
                a[i] -= damp[j, i] * v[j] + stiff[j, i] * y[j]


@_jit
def _run(N: Numbers, y: Array, v: Array, first: int, begin: float, step: float, keep: int, out: Array) -> int:
    """Step through all samples of out (samples, 2, n), changing y, v (n,) in place; the number of finite samples."""
    n, M, F = y.size, N.gaps.shape[1], N.mean.size
    k, e, de, push = np.empty(F), np.empty(M), np.empty(M), np.empty(n)
    x, u, r = np.empty(M), np.empty(M), np.empty(M)
    stiff, damp = np.zeros((n, n)), np.zeros((n, n))
    y1, v1, a = np.empty(n), np.empty(n), np.empty(n)
    dy, dv = np.empty(n), np.empty(n)
    turning = bool(np.any(N.stiff) or np.any(N.damp))
    varying = bool(np.any(N.speed != N.speed[0]))
    if turning:
        _operators(N, N.speed[0], 0.0, stiff, damp)
    varying = varying and turning
    for sample in range(out.shape[0]):
        for sub in range(keep):
            index = first + sample * keep + sub
            t = begin + index * step
            middle, end = begin + (index + 0.5) * step, begin + (index + 1) * step
            for stage in range(4):
                if stage == 0 or stage == 1 or stage == 3:
                    at = t if stage == 0 else (middle if stage == 1 else end)
                    s, rise = _instant_terms(N, at, middle, k, e, de, push)
                    if varying:
                        _operators(N, s, rise, stiff, damp)
                if stage == 0:
                    for i in range(n):
                        y1[i], v1[i] = y[i], v[i]
                    weight = 1.0
                else:
                    reach = step if stage == 3 else 0.5 * step
                    weight = 1.0 if stage == 3 else 2.0
                    for i in range(n):
                        # the slope of y at a stage is the v of the stage before
                        vi = v1[i]
                        y1[i], v1[i] = y[i] + reach * vi, v[i] + reach * a[i]
                _slope(N, k, e, de, push, stiff, damp, turning, y1, v1, x, u, r, a)
                for i in range(n):
                    if stage == 0:
                        dy[i], dv[i] = v1[i], a[i]
                    else:
                        dy[i] += weight * v1[i]
                        dv[i] += weight * a[i]
            for i in range(n):
                y[i] += step / 6.0 * dy[i]
                v[i] += step / 6.0 * dv[i]
        total = 0.0
        for i in range(n):
            out[sample, 0, i], out[sample, 1, i] = y[i], v[i]
            total += y[i] + v[i]
        if not np.isfinite(total):
            return sample
    return len(out)


def advance(N: Numbers, state: Array, *, first: int, begin: float, step: float, keep: int, samples: int) -> Array:
    """States (samples, 2, n) after every `keep` steps from the state (2, n) at step `first`; nan once not finite.

    begin : time of step 0 [s].  step : [s].
    """
    out = np.full((samples, 2, N.squared.size), np.nan)
    run: Any = _run
    done = run(N, state[0].copy(), state[1].copy(), first, begin, step, keep, out)
    out[done:] = np.nan
    return out
