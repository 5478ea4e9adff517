"""Derivatives of natural frequencies in closed form; repeated roots as the set into which their eigenspace splits.

At standstill w' = phi^T (K' - w^2 M') phi / (2 w) [fox1968].  Of a repeated root the derivatives along a parameter are
the eigenvalues of that form projected on its eigenspace: they belong to the group, not to single modes.
At a speed, undamped, the problem is Hermitian in i w, so the left vector is the right one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg

from ...questions.modes.eigen import Modes, Whirl, repeated_roots
from ...system.system import Array, ComplexArray, System
from .numbers import SystemNumbers, mean_stiffness_change

__all__ = ["frequency_derivatives", "whirl_derivatives"]

# Stiffness change of a rigid mode: rounding of the change itself where the mode stays free; 1e-3 of a spring on it.
_FREE = 1e-9


def frequency_derivatives(system: System, modes: Modes, changes: Sequence[SystemNumbers]) -> Array:
    """Derivatives of the natural frequencies of the mean system at standstill, undamped [fox1968].

    Parameters
    ----------
    modes : of `eigen`.  changes : of the System along each parameter.

    Returns
    -------
    (changes, modes) [Hz per unit of the parameter]; those of a repeated root rising.  Of a rigid mode 0 where the
    mode stays free, nan where it does not (the frequency then rises as a root, with infinite slope).
    """
    result = np.empty((len(changes), len(modes.omega_squared)))
    for row, change in zip(result, changes, strict=True):
        row[:] = _one(modes, mean_stiffness_change(system, change), change.M)
    return result


def _one(modes: Modes, dK: Array, dM: Array) -> Array:
    """Derivatives (modes,) [Hz per unit] for changes of stiffness and mass (n, n)."""
    result = np.zeros(len(modes.omega_squared))
    stiffness, mass = (modes.vectors.T @ change @ modes.vectors for change in (dK, dM))
    for group in repeated_roots(modes.omega_squared):
        squared = float(modes.omega_squared[group].mean())
        form = stiffness[group, group] - squared * mass[group, group]
        split = np.linalg.eigvalsh((form + form.T) / 2)
        if squared > 0:
            result[group] = split / (4 * np.pi * np.sqrt(squared))
        else:
            limit = _FREE * float(np.abs(stiffness).max(initial=0.0))
            result[group] = np.where(np.abs(split) <= limit, 0.0, np.nan)
    return result


def whirl_derivatives(
    system: System, modes: Whirl, changes: Sequence[SystemNumbers], *, relative_speed: float
) -> Array:
    """Derivatives of the undamped frequencies at a speed, gyroscopic and centripetal terms included.

    M q'' + s G q' + (K + s^2 Kg) q = 0 with G skew: mu' = -phi^H (mu^2 M' + mu s G' + K' + s^2 Kg') phi /
    phi^H (2 mu M + s G) phi; of a repeated root the eigenvalues of that pair of forms.

    Parameters
    ----------
    modes : of `whirl`, undamped.  relative_speed : s, of the same [1].

    Returns
    -------
    (changes, modes) [Hz per unit]; nan where mu is 0 or not imaginary (an unstable train).
    """
    result = np.full((len(changes), len(modes.mu)), np.nan)
    for row, change in zip(result, changes, strict=True):
        dK = mean_stiffness_change(system, change) + relative_speed**2 * change.Kg
        for group in repeated_roots(modes.mu):
            mu, V = complex(modes.mu[group].mean()), modes.vectors[:, group]
            if mu.imag > 0 and abs(mu.real) <= 1e-6 * mu.imag:
                row[group] = _split(system, change, dK, relative_speed, (1j * mu.imag, V))
    return result


def _split(system: System, change: SystemNumbers, dK: Array, s: float, pair: tuple[complex, ComplexArray]) -> Array:
    """Derivatives (g,) [Hz per unit] of a group of g equal roots, pair : (i omega, vectors (n, g)); s : relative
    speed.
    """
    mu, V = pair
    above = V.conj().T @ (mu**2 * change.M + mu * s * change.G + dK) @ V
    below = V.conj().T @ (2 * mu * system.M + s * system.G) @ V
    # i times `below` is Hermitian and so is `above`: a pair of forms with real eigenvalues
    roots = scipy.linalg.eigvals(above, -1j * below)
    return np.asarray(np.sort(roots.real)) / (2 * np.pi)
