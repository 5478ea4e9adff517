"""The mean system as a state that flows: one step of it exactly, and what a change of the meshes does to it.

Mass-normalised modal coordinates x (q = Phi x) with rates u = x'.  The state is (y, u), y = weight x, whose square is
twice the energy.  Positions of neutral motions (free rotation) enter nowhere and are left out: what is left has no
defective double multiplier at 1 that rounding would scatter to 1e-8.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...system.system import Array
from ..modes.basis import Modal
from ..modes.eigen import neutral_basis

__all__ = ["State", "state", "weights"]

# A constant of the motion is one if what would change it is rounding beside the matrices' own size.
_CONSERVED = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class State:
    """z' = generator z less what changed meshes push.

    generator : (k + n, k + n) of z = (y (k,), u (n,)) [1/s].
    gaps : (m, k) gap of y [m].  rows : (m, n) B^T Phi: gap rate of u, and transposed the push of mesh forces on u.
    turn : (n, n) orthogonal, x = turn (x_neutral, x_rest).  weight : (n,) in the order of the turned coordinates.
    neutral : positions left out, n - k of them, each a multiplier 1.  conserved : multipliers 1 among the others.
    """

    generator: Array
    gaps: Array
    rows: Array
    turn: Array
    weight: Array
    neutral: int
    conserved: int


def weights(modal: Modal) -> Array:
    """y / x of every mode, (n,) [rad/s]: its natural frequency, of a rigid mode the lowest elastic one."""
    omega = np.sqrt(modal.squared)
    lowest = np.min(omega[~modal.rigid], initial=1.0 if modal.rigid.all() else np.inf)
    return np.where(modal.rigid, lowest, omega)


def state(modal: Modal, *, frame: float, stiffness: Array, damping: Array, gaps: Array | None = None) -> State:
    """The mean system with other mean meshes.

    Parameters
    ----------
    frame : factor of G and Cskew, squared of Kg.
    stiffness, damping : (m,) mean of each mesh less what `modal` holds [N/m], [N s/m].
    gaps : (m, n) gap of y of those rows; the meshes of `modal` where None.
    """
    weight = weights(modal)
    rows = (modal.gaps if gaps is None else gaps) * weight
    C, K = _matrices(modal, frame, weight)
    C += (rows.T * damping) @ rows
    K += (rows.T * stiffness) @ rows
    turn, neutral, conserved = np.eye(len(weight)), 0, 0
    rigid = np.flatnonzero(modal.rigid)
    if rigid.size:
        turn, neutral = neutral_basis(K, rigid)
        C, K, rows, weight = turn.T @ C @ turn, turn.T @ K @ turn, rows @ turn, (turn**2).T @ weight
        conserved = _conserved(K, C, rigid.size, neutral)
    n, k = len(weight), len(weight) - neutral
    generator = np.zeros((k + n, k + n))
    generator[:k, k + neutral :] = np.diag(weight[neutral:])
    generator[k:, :k] = -K[:, neutral:] / weight[neutral:]
    generator[k:, k:] = -C
    return State(
        generator=generator,
        gaps=np.ascontiguousarray(rows[:, neutral:] / weight[neutral:]),
        rows=rows,
        turn=turn,
        weight=weight,
        neutral=neutral,
        conserved=conserved,
    )


def _matrices(modal: Modal, frame: float, weight: Array) -> tuple[Array, Array]:
    """Rate and position matrices of the mean system in mass-normalised modal coordinates, (n, n) each."""
    C, K = np.diag(modal.damping), np.diag(modal.squared)
    for name, factor, target in (("G", frame, C), ("C", 1.0, C), ("Kg", frame**2, K), ("Cskew", frame, K)):
        if name in modal.coupling:
            target += factor * modal.coupling[name].T * weight / weight[:, None]
    return C, K


def _conserved(K: Array, C: Array, rigid: int, neutral: int) -> int:
    """Momenta of the `rigid` first coordinates that nothing changes: no position, and no rate of a neutral motion."""
    tiny = np.finfo(float).tiny
    held = K[:rigid] / max(float(np.abs(K - np.diag(np.diag(K))).max(initial=0.0)), tiny)
    dragged = C[:rigid, :neutral] / max(float(np.abs(C).max(initial=0.0)), tiny)
    changed = np.linalg.svd(np.concatenate([held, dragged], axis=1), compute_uv=False)
    return rigid - int(np.sum(changed > _CONSERVED))
