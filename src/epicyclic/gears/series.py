"""Relative Fourier series over a mesh cycle: complex coefficients v_l (L,) over the place sigma of the contact.

sigma counts base pitches from the pitch point at mid-face and has the period 1 (docs/conventions.md, Phases):

    value(sigma) = mean (1 + Re sum_l v_l exp(2 pi i l sigma)),    l = 1 .. L.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError

__all__ = ["ComplexArray", "evaluate_series", "fourier_series", "mesh_phasor", "series_in_time", "table_series"]

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def fourier_series(cosine: Sequence[float], sine: Sequence[float] = ()) -> ComplexArray:
    """Coefficients v_l = a_l - i b_l (L,) of sum_l a_l cos(2 pi l sigma) + b_l sin(2 pi l sigma) [1].

    cosine, sine : relative to the mean, from l = 1; the shorter is padded with zeros.
    """
    series = np.zeros(max(len(cosine), len(sine)), dtype=np.complex128)
    series[: len(cosine)] += np.asarray(cosine, dtype=float)
    series[: len(sine)] -= 1j * np.asarray(sine, dtype=float)
    return series


def table_series(values: Sequence[float] | Array) -> tuple[float, ComplexArray]:
    """Mean of equally spaced samples over one mesh cycle, and their relative Fourier coefficients.

    values : (n,) at sigma = 0, 1/n, ... (the end of the cycle is not repeated).  Returns the mean [unit of values]
    and v (n//2,) [1] of the interpolating trigonometric polynomial.

    Raises
    ------
    ModelError : no samples, or a mean that is not positive.
    """
    samples = np.asarray(values, dtype=float)
    if samples.size == 0 or not samples.mean() > 0.0:
        raise ModelError("a table over one mesh cycle needs a positive mean", given=list(samples))
    spectrum = np.fft.rfft(samples) / samples.size
    mean, series = float(spectrum[0].real), 2.0 * spectrum[1:]
    if samples.size % 2 == 0:
        series[-1] *= 0.5  # the highest order of an even table has no partner at the negative side
    return mean, np.asarray(series / mean, dtype=np.complex128)


def evaluate_series(coefficients: ArrayLike, sigma: ArrayLike) -> Array:
    """Value 1 + Re sum_l v_l exp(2 pi i l sigma) [1] of coefficients (L,) at sigma (...) [base pitches]."""
    series = np.asarray(coefficients, dtype=np.complex128)
    angle = 2j * np.pi * np.asarray(sigma, dtype=float)[..., np.newaxis] * np.arange(1, series.size + 1)
    return np.asarray(1.0 + (np.exp(angle) @ series).real)


def series_in_time(coefficients: ArrayLike, *, lead: Fraction | float, sense: int) -> ComplexArray:
    """Coefficients w_l (L,) over time, value = mean (1 + Re sum_l w_l exp(2 pi i l f t)) [1].

    With sigma = sense (f t + lead) (docs/conventions.md, Phases), w_l = v_l exp(2 pi i l lead), v_l conjugated where
    sense is -1.  coefficients : (L,) over sigma.  lead : [mesh cycles], exact where rational.  sense : D = +1 or -1.
    """
    series = np.asarray(coefficients, dtype=np.complex128)
    orders = range(1, series.size + 1)
    if isinstance(lead, Fraction):  # integers: fractions reduce what is divided here once
        numerator, denominator = lead.numerator, lead.denominator
        cycles = [order * numerator % denominator / denominator for order in orders]
    else:
        cycles = [order * lead % 1 for order in orders]
    return np.asarray((series if sense > 0 else series.conj()) * np.exp(2j * np.pi * np.array(cycles)))


def mesh_phasor(order: int, lead: Fraction | float) -> complex:
    """Phasor exp(2 pi i order lead) [1], whole cycles removed before rounding; lead [mesh cycles]."""
    return complex(np.exp(2j * np.pi * float(order * lead % 1)))
