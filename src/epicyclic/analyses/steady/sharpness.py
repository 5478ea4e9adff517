"""How well a response near a resonance of light damping is determined, and its refinement as far as numbers allow.

A residual r of the balance A y = b is an error A^-1 r, which a sharp resonance amplifies.  The amplification is found
by solving for a unit force on the coordinates that are near resonance.  Besides r, double precision itself perturbs A:
a natural frequency is known to about eps max(omega^2), so that a resonance narrower than that has no number.
Derived here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...questions.modes.basis import Modal
from ...system.system import Array
from .gmres import gmres

__all__ = ["FLOOR", "near_sharp_resonance", "sharpened"]

# Least |D| of the preconditioner, per omega_r^2.  At a resonance of the mean system without damping D is 0 although the
# varying stiffness and the gyroscopic terms leave the system regular: 1/D would make the right side, and with it the
# scale of residuals, as large as one likes.  D stays above this from a damping ratio of 5e-5 on.
FLOOR = 1e-4
# Damping ratio below which a resonance is asked: above, it amplifies a residual less than 5000 times, and the
# tolerances hold.
_LIGHT = 1e-4
# Distance from a natural frequency, of omega^2, below which a harmonic may be resonant: gyroscopic and varying terms
# shift the resonances of the mean system by a few per cent.
_NEAR = 0.1
# Residual of the solution for the amplification: its size is wanted, not its digits.
_PROBE = 1e-2
# Refinements at most; each gains at least three digits or none.
_ROUNDS = 3


def near_sharp_resonance(modal: Modal, frequency: Array) -> NDArray[np.bool_]:
    """Points (P,) with a harmonic near the natural frequency of a mode of light damping.

    frequency : (P, J) [rad/s].
    """
    light = (modal.damping**2 < 4 * _LIGHT**2 * modal.squared) & ~modal.rigid
    if not np.any(light):
        return np.zeros(len(frequency), dtype=bool)
    squared = modal.squared[light]
    near: NDArray[np.bool_] = np.any(np.abs(squared - frequency[:, :, None] ** 2) < _NEAR * squared, axis=(1, 2))
    return near


def sharpened(
    modal: Modal,
    rows: Callable[[Array], Array],
    right: Array,
    y: Array,
    frequency: Array,
    *,
    mean: bool,
    tolerance: float,
) -> tuple[Array, float, float]:
    """Solution of one point refined until its error is below the tolerance, or as far as double precision goes.

    Parameters
    ----------
    rows : (1, 2 J n) -> (1, 2 J n), the preconditioned operator.  right : (1, 2 J n), its right side.
    y : (1, 2, J, n) solution so far.  frequency : (J,) [rad/s].  mean : whether harmonic 0 is a mean.
    tolerance : error wanted, relative to the dynamic part [1].

    Returns
    -------
    (y (1, 2, J, n), norm of its residual, bound of its relative error; inf where the resonance cannot be resolved).
    """
    shape, y = y.shape, y.reshape(1, -1)
    amplification, noise = _amplification(modal, rows, frequency)
    dynamic, left = 1.0, np.inf
    for _ in range(_ROUNDS + 1):
        residual = right - rows(y)
        left = float(np.linalg.norm(residual))
        moving = y.reshape(shape)[:, :, 1:] if mean else y
        dynamic = float(np.linalg.norm(moving)) or 1.0
        wanted = tolerance * dynamic / amplification
        if left <= wanted or not np.isfinite(amplification):
            break
        step, rest, _ = gmres(rows, residual, target=np.array([0.5 * wanted]))
        if not rest[0] < left:
            break
        y = y + step
    error = amplification * (left / dynamic + noise)
    return y.reshape(shape), left, error if np.isfinite(error) else np.inf


def _amplification(modal: Modal, rows: Callable[[Array], Array], frequency: Array) -> tuple[float, float]:
    """Largest error per residual [1], and the part of y that rounding of natural frequencies leaves as a residual [1].

    inf where the resonance is narrower than rounding.
    """
    distance = np.abs(modal.squared - frequency[:, None] ** 2)
    near = (distance < _NEAR * modal.squared) & (modal.damping**2 < 4 * _LIGHT**2 * modal.squared) & ~modal.rigid
    # the signs are fixed and without pattern, so that the unit forces do not cancel along a resonant motion
    signs = np.random.default_rng(1).choice([-1.0, 1.0], size=(2, *near.shape))
    force = np.where(near, signs, 0.0).reshape(1, -1)
    answer, left, _ = gmres(rows, force, target=np.array([_PROBE]))
    # rounding of omega^2 against the least that P, floored, can be
    least = np.min(np.where(near, np.maximum(distance, FLOOR * modal.squared), np.inf))
    noise = np.finfo(float).eps * float(modal.squared.max(initial=0.0)) / float(least)
    if not left[0] <= _PROBE:
        return np.inf, noise
    return max(1.0, float(np.linalg.norm(answer))), noise
