"""Mesh stiffness by loaded contact: a pair tabulated over the place of the contact and the load.

`loaded_contact` yields the approach d(F, sigma).  The linear model at an operating load F_0 has the tangent there,

    f = k(sigma) (d - e(sigma)),   k = dF/dd at F_0,   e = d(F_0, sigma) - F_0/k(sigma)

and so the exact loaded transmission error at F_0 (derived here).  The table holds d - e over all loads beside it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..gears.series import ComplexArray, evaluate_series, table_series
from ..gears.stiffness import DEFAULT_HARMONICS
from ..gears.tooth_pair import ContactTable
from .loaded_contact import harmonics, loaded_contact
from .pair import ContactPair

__all__ = ["contact_table"]

Array = NDArray[np.float64]

# Loads rise as squares, (i / _OPERATING)^2 times the operating load, which is one of them.
_STEPS, _OPERATING = 20, 12


def contact_table(pair: ContactPair, load: float, *, samples: int = 50, count: int = DEFAULT_HARMONICS) -> ContactTable:
    """Tabulate the loaded contact of a pair around an operating load [N].

    samples : phases S of a mesh cycle.  count : orders of the linear model.

    Raises
    ------
    ModelError : a load that is not positive, a phase without solution, and as of `loaded_contact`.
    """
    if not (load > 0 and math.isfinite(load)):
        raise ModelError("is no mesh force to take the stiffness at", given=load, allowed="above 0 N")
    sigma = np.arange(samples) / samples
    force = load * (np.arange(_STEPS + 1) / _OPERATING) ** 2
    found = loaded_contact(pair, force[1:], sigma)
    if (found.status != "").any():
        raise ModelError("tooth contact found no solution", given=str(found.status[found.status != ""][0]))
    tangent = found.tangent
    mean, series = table_series(tangent[_OPERATING - 1])
    series = series[:count]
    linear = mean * evaluate_series(series, sigma)
    error = harmonics(found.approach[_OPERATING - 1] - load / linear, count)
    approach = np.vstack([found.no_load, found.approach]).T - _sampled(error, sigma)[:, None]
    return ContactTable(
        load=load,
        stiffness=mean,
        variation=series,
        error=error,
        force=force,
        gap=approach,
        slope=_slopes(approach, force, tangent.T),
    )


def _sampled(series: ComplexArray, sigma: Array) -> Array:
    """Values (S,) of Re sum_l c_l exp(2 pi i l sigma), l = 0, 1, ..., in the unit of the series (L + 1,)."""
    return np.asarray((np.exp(2j * np.pi * np.outer(sigma, np.arange(len(series)))) @ series).real)


def _slopes(gap: Array, force: Array, tangent: Array) -> Array:
    """Slopes dF/dd (S, L) [N/m] of a rising cubic through the table: the computed tangents, zero at first touch.

    gap : (S, L) [m].  force : (L,) [N].  tangent : (S, L - 1) [N/m].  A tangent above three times the secants beside it
    would make the cubic fall somewhere [fritsch1980].
    """
    secant = np.diff(force) / np.diff(gap, axis=1)
    slope = np.hstack([np.zeros((len(gap), 1)), tangent])
    slope[:, 1:] = np.minimum(slope[:, 1:], 3 * secant)
    slope[:, :-1] = np.minimum(slope[:, :-1], 3 * secant)
    return slope
