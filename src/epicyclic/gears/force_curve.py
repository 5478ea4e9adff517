"""Measured or computed force over deflection: rising cubics through given points, and tables of several phases.

A curve is zero up to first touch, then a monotone cubic through its points [fritsch1980]; behind the last point it goes
on along its last tangent.  Two points give a straight line, exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .series import evaluate_series, table_series
from .stiffness import DEFAULT_HARMONICS
from .tooth_pair import ContactTable

__all__ = ["ForceCurve", "force_curve", "given_table"]

Array = NDArray[np.float64]

# Least last slope per last secant: the three-point slope of data that flatten may be zero, and a law that goes on along
# a last tangent of zero holds no load more.
_LAST = 0.5
# Force of a table at common loads less that of the curves it is made from, per largest force, at the probes: below
# 1e-4 everywhere, less than any measurement.
_ACCURACY = 5e-5
# Loads of a table to begin with: as many as of tabulated tooth contact.
_LOADS = 20
# Forces nearer to each other than this part of the largest are one load: rounding of one number.
_SAME = 1e-12
# Forces up to this part of the last one are no touch: what an FE run returns of teeth apart.
_APART = 1e-9
# Series and errors below this part are rounding of a straight line.
_ROUNDING = 1e-12
# Newton steps or halvings until a place in a cell is found to rounding.
_SEARCH, _PLACE = 60, 1e-14
# Places within a cell at which a table is compared with its curves.
_PROBES = np.array([0.1, 0.3, 0.5, 0.7, 0.9])


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceCurve:
    """Force over deflection from first touch on.

    deflection : (L,) rising, of first touch first [m, rad].  force : (L,) rising, 0 first [N, N m].
    slope : (L,) there [N/m, N m/rad].
    """

    deflection: tuple[float, ...]
    force: tuple[float, ...]
    slope: tuple[float, ...]

    def __repr__(self) -> str:
        """One line: points, last deflection and force."""
        return f"ForceCurve({len(self.force)} points up to {self.deflection[-1]:.4g}, {self.force[-1]:.4g})"

    @property
    def stiffness(self) -> float:
        """Slope at half of the last force [N/m, N m/rad]."""
        return float(self.inverse([self.force[-1] / 2])[1][0])

    def scaled(self, *, deflection: float = 1.0, force: float = 1.0) -> ForceCurve:
        """The curve with deflections and forces times two factors above zero."""
        return ForceCurve(
            deflection=tuple(value * deflection for value in self.deflection),
            force=tuple(value * force for value in self.force),
            slope=tuple(value * (force / deflection) for value in self.slope),
        )

    def at(self, deflection: Array) -> Array:
        """Force [N, N m] at deflections (...) [m, rad]."""
        x, f, k = (np.array(values) for values in (self.deflection, self.force, self.slope))
        cell = np.clip(np.searchsorted(x, deflection, side="right") - 1, 0, len(x) - 2)
        h = x[cell + 1] - x[cell]
        t = np.clip((deflection - x[cell]) / h, 0.0, 1.0)
        force = _hermite(t, h, f[cell], f[cell + 1], k[cell], k[cell + 1])[0]
        return np.asarray(force + k[-1] * np.maximum(deflection - x[-1], 0.0))

    def inverse(self, force: ArrayLike) -> tuple[Array, Array]:
        """Deflection [m, rad] and slope [N/m, N m/rad] at forces (P,) from 0 up, each (P,)."""
        given = np.asarray(force, dtype=float)
        x, f, k = (np.array(values) for values in (self.deflection, self.force, self.slope))
        cell = np.clip(np.searchsorted(f, given, side="right") - 1, 0, len(f) - 2)
        h, f0, f1, k0, k1 = x[cell + 1] - x[cell], f[cell], f[cell + 1], k[cell], k[cell + 1]
        low, high = np.zeros_like(given), np.ones_like(given)
        t = np.clip((given - f0) / (f1 - f0), 0.0, 1.0)
        for _ in range(_SEARCH):
            value, rate = _hermite(t, h, f0, f1, k0, k1)
            low, high = np.where(value < given, t, low), np.where(value < given, high, t)
            trial = t - (value - given) / np.where(rate > 0, h * rate, 1.0)
            trial = np.where((rate > 0) & (trial >= low) & (trial <= high), trial, (low + high) / 2)
            change, t = np.abs(trial - t).max(initial=0.0), trial
            if change <= _PLACE:
                break
        t = np.where(given <= f0, 0.0, np.where(given >= f1, 1.0, t))
        slope = np.where(given >= f[-1], k[-1], _hermite(t, h, f0, f1, k0, k1)[1])
        return x[cell] + t * h + np.maximum(given - f[-1], 0.0) / k[-1], slope


def force_curve(deflection: Sequence[float], force: Sequence[float]) -> ForceCurve:
    """Curve through points whose forces are zero at first and rise from the last zero on.

    Parameters
    ----------
    deflection : (L,) rising [m, rad].  force : (L,) [N, N m].
    """
    from scipy.interpolate import PchipInterpolator  # half a second, for tables alone

    touch = sum(value <= _APART * force[-1] for value in force) - 1
    x, f = np.array(deflection[touch:], dtype=float), np.array((0.0, *force[touch + 1 :]))
    slope = PchipInterpolator(x, f).derivative()(x)
    slope[-1] = max(slope[-1], _LAST * (f[-1] - f[-2]) / (x[-1] - x[-2]))
    return ForceCurve(deflection=tuple(x.tolist()), force=tuple(f.tolist()), slope=tuple(slope.tolist()))


@lru_cache(maxsize=64)
def given_table(curves: tuple[ForceCurve, ...], load: float) -> ContactTable:
    """Table of a mesh from its curves at S phases sigma = 0, 1/S, ... of the mesh cycle; kept, as sides share it.

    The tangent at the load and the error e = d - F/k that belongs to it are those of `tooth_contact.table`.

    Parameters
    ----------
    load : operating load [N].
    """
    places, tangents = np.array([curve.inverse([load]) for curve in curves])[:, :, 0].T
    mean, series = table_series(tangents)
    series = np.where(np.abs(series) > _ROUNDING, series, 0.0)[: DEFAULT_HARMONICS if np.any(series) else 0]
    sigma = np.arange(len(curves)) / len(curves)
    # a truncated series may dip below the least of the tangents it is made of
    linear = mean * np.maximum(evaluate_series(series, sigma), tangents.min() / mean)
    rest = places - load / linear
    rest = np.where(np.abs(rest) > _ROUNDING * places.max(), rest, 0.0)
    count = min(len(series), (len(curves) - 1) // 2)
    error = 2 * np.fft.rfft(rest)[: count + 1] / len(curves)
    error[0] /= 2
    forces = _common_forces(curves, load)
    gap, slope = (np.array(values) for values in zip(*(curve.inverse(forces) for curve in curves), strict=True))
    wave = np.exp(2j * np.pi * np.outer(sigma, np.arange(len(error))))
    return ContactTable(
        load=load,
        stiffness=mean,
        variation=series,
        error=error,
        force=forces,
        gap=gap - (wave @ error).real[:, None],
        slope=slope,
        last=min(curve.force[-1] for curve in curves),
    )


def _common_forces(curves: Sequence[ForceCurve], load: float) -> Array:
    """Loads (L,) [N] at which all curves together make a table; forces between them are right to `_ACCURACY`.

    load : operating load [N], one of them, unless all curves have the same forces.

    A cubic cut at a load stays itself, so that all forces of all curves make an exact table; a few of them to begin
    with, and then one more in every cell that misses a curve.
    """
    if all(curve.force == curves[0].force for curve in curves):
        return np.array(curves[0].force)
    given = np.concatenate([curve.force for curve in curves])
    every: Array = np.unique([*given, min(load, given.max())])
    every = every[np.concatenate([[True], np.diff(every) > _SAME * every[-1]])]
    first = np.linspace(0, len(every) - 1, _LOADS + 1).astype(int)
    chosen = np.unique([*first, np.argmin(np.abs(every - load))])
    while True:
        missed = np.max([_deviations(curve, every[chosen]) for curve in curves], axis=0)
        wide = (missed > _ACCURACY * every[-1]) & (np.diff(chosen) > 1)
        if not wide.any():
            return np.asarray(every[chosen])
        chosen = np.unique(np.concatenate([chosen, ((chosen[:-1] + chosen[1:]) // 2)[wide]]))


def _deviations(curve: ForceCurve, forces: Array) -> Array:
    """Largest force (L - 1,) [N] by which cubics between loads (L,) miss a curve whose points they have."""
    x, k = curve.inverse(forces)
    h = np.diff(x)
    probed = _hermite(_PROBES[:, None], h, forces[:-1], forces[1:], k[:-1], k[1:])[0]
    return np.asarray(np.abs(probed - curve.at(x[:-1] + _PROBES[:, None] * h)).max(axis=0))


def _hermite(t: Array, h: Array, f0: Array, f1: Array, k0: Array, k1: Array) -> tuple[Array, Array]:
    """Cubic of given ends and slopes over a cell of width h, at 0 <= t <= 1, and its slope."""
    rest = 1 - t
    value = f0 * (1 + 2 * t) * rest**2 + f1 * t**2 * (3 - 2 * t) + h * (k0 * t * rest**2 - k1 * t**2 * rest)
    rate = 6 * t * rest * (f1 - f0) / h + k0 * rest * (1 - 3 * t) + k1 * t * (3 * t - 2)
    return value, rate
