"""Natural frequencies and shapes: symmetric eigenproblem at standstill, quadratic with gyroscopic terms and damping.

The quadratic problem is (mu^2 M + mu (C + s G) + K + s^2 Kg + s Cskew) phi = 0 with mean meshes in C and K and
q ~ phi exp(mu t).  It is solved by linearisation to a state matrix [tisseur2001].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ...errors import ModelError
from ...statics.tangent import linear
from ...system.system import Array, ComplexArray, System
from .basis import mean_modes

__all__ = ["Modes", "Whirl", "damping_ratios", "eigen", "neutral_basis", "whirl"]

# An eigenvalue of the state matrix, or its imaginary part, is rounding below this part of the largest; 20 Hz beside
# 20 kHz is 1e-3.
_ZERO = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Modes:
    """Undamped modes of the mean system at standstill.

    omega_squared : (n,) rising [rad^2/s^2], rigid modes exactly 0.
    vectors : (n, n) columns with vectors^T M vectors = 1; rz coordinates in rad.
    """

    omega_squared: Array
    vectors: Array

    @property
    def omega(self) -> Array:
        """Natural angular frequencies, (n,) [rad/s]."""
        return np.sqrt(self.omega_squared)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Whirl:
    """Modes with gyroscopic terms or damping, one of each conjugate pair.

    mu : (n,) complex eigenvalues [1/s], frequency rising; 0 for rigid modes; of two real ones the slower decaying.
    vectors : (n, n) complex, unit kinetic norm (vector^H M vector = 1).
    """

    mu: ComplexArray
    vectors: ComplexArray


def eigen(system: System) -> Modes:
    """All modes of the undamped mean system at standstill, repeated roots included.

    Returns
    -------
    Modes with omega^2 (n,) [rad^2/s^2] and shapes (n, n); links with laws enter by their tangents.

    Raises
    ------
    ModelError : a mass or inertia is missing, or the mean system is statically unstable.
    """
    system.require_inertia()
    squared, vectors = mean_modes(linear(system, asks_laws=True))
    return Modes(omega_squared=squared, vectors=vectors)


def damping_ratios(system: System, modes: Modes) -> Array:
    """Damping ratio of each undamped mode: the modal ratio plus phi^T C phi / (2 omega), mesh dampers in C.

    Off-diagonal terms of the modal damping matrix are left out; `whirl` has them.

    Returns
    -------
    (n,) [1]; nan for rigid modes, and everywhere where no damping is given.
    """
    if not system.damped:
        return np.full(len(modes.omega_squared), np.nan)
    vectors, meshes = modes.vectors, system.meshes
    gaps = meshes.B.T @ vectors
    power = np.einsum("im,ij,jm->m", vectors, system.C, vectors) + meshes.damping @ gaps**2
    elastic = modes.omega_squared > 0
    omega = np.where(elastic, modes.omega, 1.0)
    return np.where(elastic, (system.zeta or 0.0) + power / (2 * omega), np.nan)


def whirl(system: System, *, relative_speed: float, damped: bool = False, modes: Modes | None = None) -> Whirl:
    """Eigenvalues [1/s] and complex shapes (n, n) at a speed, from the state matrix in modal coordinates.

    Positions of neutral motions (rigid rotation) enter no force.  They are left out of the state: their double zero is
    a defective eigenvalue that rounding would scatter to 1e-8 of the largest, and becomes a simple one.

    Parameters
    ----------
    relative_speed : s, speed per operating speed [1].  damped : with C, Cskew and modal damping.
    modes : of `eigen`, where already at hand.

    Raises
    ------
    ModelError : damping is asked for and none is given, or what `eigen` raises.
    """
    if damped and not system.damped:
        raise ModelError("damped modes need damping, and none is given", path="damping", allowed="modal, mesh, ...")
    system = linear(system, asks_laws=True)
    modes = eigen(system) if modes is None else modes
    C, K = _modal_matrices(system, modes, relative_speed, damped)
    Q, neutral = neutral_basis(K, np.flatnonzero(modes.omega_squared == 0))
    scale = float(np.max(modes.omega, initial=0.0)) or 1.0
    mu, p = _state_modes(Q.T @ C @ Q / scale, Q.T @ K @ Q / scale**2, neutral)
    vectors = modes.vectors @ (Q @ p)
    norm = np.sqrt(np.einsum("im,ij,jm->m", vectors.conj(), system.M, vectors).real)
    order = np.lexsort((np.abs(mu.real), mu.imag))
    return Whirl(mu=scale * mu[order], vectors=(vectors / norm)[:, order])


def _modal_matrices(system: System, modes: Modes, s: float, damped: bool) -> tuple[Array, Array]:
    """Rate matrix [1/s] and position matrix [1/s^2] at relative speed s in the modal coordinates of `modes`,
    (n, n) each.
    """
    Phi = modes.vectors
    C = s * (Phi.T @ system.G @ Phi)
    K = np.diag(modes.omega_squared) + s**2 * (Phi.T @ system.Kg @ Phi)
    if damped:
        B = system.meshes.B
        dampers = system.C + (B * system.meshes.damping) @ B.T
        C = C + Phi.T @ dampers @ Phi + np.diag(2 * (system.zeta or 0.0) * modes.omega)
        K = K + s * (Phi.T @ system.Cskew @ Phi)
    return C, K


def neutral_basis(K: Array, rigid: np.ndarray) -> tuple[Array, int]:
    """Orthogonal coordinates Q (n, n) whose first `count` directions meet no stiffness: K Q[:, :count] = 0.

    Parameters
    ----------
    K : (n, n) position matrix in modal coordinates [1/s^2].  rigid : indices (r,) of the rigid modes.

    Returns
    -------
    (Q, count); count is less than r where centrifugal or skew terms hold a rigid motion.
    """
    n = len(K)
    if not rigid.size:
        return np.eye(n), 0
    columns = K[:, rigid]
    _, sizes, directions = np.linalg.svd(columns)
    # the columns hold only s^2 Kg and s Cskew (their omega^2 is 0): rounding is measured on those
    scale = float(np.max(np.abs(K - np.diag(np.diag(K))), initial=0.0)) + float(np.max(np.abs(columns), initial=0.0))
    count = int(np.sum(sizes <= _ZERO * scale)) if scale > 0 else rigid.size
    Q = np.zeros((n, n))
    Q[rigid, : rigid.size] = directions[::-1].T
    rest = np.setdiff1d(np.arange(n), rigid)
    Q[rest, np.arange(rigid.size, n)] = 1.0
    return Q, count


def _state_modes(C: Array, K: Array, r: int) -> tuple[ComplexArray, ComplexArray]:
    """One eigenpair (n,), (n, n) per mode of p'' + C p' + K p = 0 [tisseur2001].

    Parameters
    ----------
    C, K : (n, n), time scaled so that |mu| is about 1 at most.  r : leading coordinates that are neutral, left out of
        the positions of the state.
    """
    n = len(C)
    k = n - r
    A = np.zeros((2 * k + r, 2 * k + r))
    A[:k, k : 2 * k] = np.eye(k)
    A[k : 2 * k] = -np.hstack([K[r:, r:], C[r:, r:], C[r:, :r]])
    A[2 * k :] = -np.hstack([K[:r, r:], C[:r, r:], C[:r, :r]])
    mu, states = scipy.linalg.eig(A)
    mu = np.where(np.abs(mu) <= _ZERO * np.max(np.abs(mu), initial=0.0), 0.0, mu)
    with np.errstate(divide="ignore", invalid="ignore"):
        p = np.vstack([states[2 * k :] / mu, states[:k]])
    chosen, slow = _one_of_each_pair(mu, r)
    p[:, slow] = 0.0
    p[:, slow] = np.eye(n)[:, :r]
    mu = mu.astype(complex)
    mu[slow] = 0.0
    mu.imag[np.abs(mu.imag) <= _ZERO * np.max(np.abs(mu), initial=0.0)] = 0.0
    return mu[chosen], p[:, chosen]


def _one_of_each_pair(mu: ComplexArray, r: int) -> tuple[np.ndarray, np.ndarray]:
    """Indices (n,) of one eigenvalue per mode, and among them the r that stand for the neutral motions.

    Each neutral motion has one zero left out of the state; the r slowest real eigenvalues are the partners of these.

    Parameters
    ----------
    mu : (2n - r,) eigenvalues of the state matrix.
    """
    # equal real eigenvalues come as a pair whose imaginary part is rounding
    turning = np.abs(mu.imag) > _ZERO * np.max(np.abs(mu), initial=0.0)
    oscillating = np.flatnonzero(turning & (mu.imag > 0))
    real = np.flatnonzero(~turning)
    real = real[np.argsort(np.abs(mu[real]), kind="stable")]
    slow, rest = real[:r], real[r:]
    pairs = rest[: len(rest) // 2 * 2].reshape(-1, 2)
    slower = np.where(mu[pairs[:, 0]].real >= mu[pairs[:, 1]].real, pairs[:, 0], pairs[:, 1])
    return np.concatenate([slow, slower, oscillating]), slow
