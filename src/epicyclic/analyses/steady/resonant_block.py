"""A dense block of the balance: the coordinates near a resonance that mesh stiffness couples, solved together.

With two mesh frequencies hundreds of combinations lie near some natural frequency, each coupled to the next along the
axis of a tone.  D^-1 alone then leaves GMRES hundreds of outlying eigenvalues.  The block holds these coordinates with
their couplings by the varying mesh stiffness, factorised; all others keep D^-1.  Derived here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ...questions.modes.basis import Modal
from ...system.system import Array, ComplexArray, System
from .kernel import Kernel

__all__ = ["resonant_block"]

Index = NDArray[np.int64]

# Coordinates in the block: those that the variation moves by more than this part of themselves at once.  On two
# planetary stages (30 coordinates, 1273 lattice points) 0.3 takes 46 products where D^-1 alone takes 780; 0.1 takes 35
# with a block twice as large.
_GAIN = 0.3
# Coordinates at most, complex ones: factors of 72 MB, made in 2 s.
_MOST = 1500


def resonant_block(system: System, modal: Modal, kernel: Kernel, frequency: Array) -> Callable[[Array], Array] | None:
    """Preconditioner (1 + D^-1 coupling)^-1 on the resonant coordinates of one point, 1 on the others.

    frequency : (J,) of every harmonic [rad/s].

    Returns
    -------
    A function (1, 2 J n) -> (1, 2 J n) of the preconditioned rows of the balance; None where no coordinate is resonant.
    """
    waves = [_waves(system, modal, axis.meshes) for axis in kernel.axes]
    inverse = _inverse(modal, frequency)
    # the largest coupling of a coordinate to itself at another harmonic is what the next harmonic takes up
    size = np.sqrt(sum(np.max(np.abs(np.einsum("lrr->lr", wave)) ** 2, axis=0) for wave in waves))
    gain = size * np.abs(inverse)
    if kernel.lattice.mirrored:
        gain[0] = 0.0  # the mean is never resonant, and real
    order = np.argsort(-gain, axis=None, kind="stable")[:_MOST]
    order = order[gain.ravel()[order] > _GAIN]
    if not order.size:
        return None
    point, mode = np.unravel_index(order, gain.shape)
    near = inverse[point, mode][:, None]
    direct = near * _couplings(waves, kernel.lattice.points[point], mode, sign=1) + np.eye(order.size)
    folded = near * _couplings(waves, kernel.lattice.points[point], mode, sign=-1) * kernel.lattice.mirrored
    rows = np.block(
        [
            [direct.real + folded.real, folded.imag - direct.imag],
            [direct.imag + folded.imag, direct.real - folded.real],
        ]
    )
    factors = scipy.linalg.lu_factor(rows, overwrite_a=True)
    place = np.concatenate([order, frequency.size * len(modal.squared) + order])

    def solve(x: Array) -> Array:
        """The block solved, (1, 2 J n)."""
        out = x.copy()
        out[0, place] = scipy.linalg.lu_solve(factors, x[0, place])
        return out

    return solve


def _inverse(modal: Modal, frequency: Array) -> ComplexArray:
    """1/D at frequencies (J,) [rad/s], (J, n) [s^2/rad^2]; 0 where D is 0."""
    w = frequency[:, None]
    D = modal.squared - w**2 + 1j * w * modal.damping
    inverse: ComplexArray = np.divide(1.0, D, out=np.zeros_like(D), where=D != 0)
    return inverse


def _waves(system: System, modal: Modal, meshes: Index) -> ComplexArray:
    """Couplings of coordinates by each harmonic -L .. L of the stiffness of `meshes` (m_j,), (2 L + 1, n, n)."""
    half = system.meshes.stiffness[meshes, None] * system.meshes.variation[meshes] / 2
    series = np.concatenate([half[:, ::-1].conj(), np.zeros((len(meshes), 1)), half], axis=1)
    pulls, gaps = modal.pulls[meshes], modal.gaps[meshes]
    waves: ComplexArray = np.array([(pulls.T * wave) @ gaps for wave in series.T])
    return waves


def _couplings(waves: list[ComplexArray], points: Index, mode: Index, *, sign: int) -> ComplexArray:
    """Couplings (S, S) of coordinates at lattice points (S, D) in modes (S,), by the harmonics a - sign b.

    sign : 1, or -1 of a real signal, where the conjugate of b counts.
    """
    found = np.zeros((len(points), len(points)), complex)
    for axis, wave in enumerate(waves):
        reach = len(wave) // 2
        step = points[:, None, axis] - sign * points[None, :, axis]
        coupled = np.abs(step) <= reach
        for other in range(points.shape[1]):
            if other != axis:
                coupled &= points[:, None, other] == sign * points[None, :, other]
        a, b = np.nonzero(coupled)
        found[a, b] += wave[step[a, b] + reach, mode[a], mode[b]]
    return found
