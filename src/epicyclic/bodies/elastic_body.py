"""A body that bends: coordinates beside its six, and what they are to matrices and rows.

A body brings a shape matrix Phi(P), the displacement of its point P per coordinate; a row of a gap along n is
n . Phi(P).  A rigid body is Phi = [1, -r x].  An axisymmetric body has constant matrices at any speed.  Seen from a
frame against which it turns at nu, d/dt of its material is d/dt + nu D with a matrix D that turns its patterns; M D is
antisymmetric.  From M, G_m (of the spin w) and K_m of the material follow

    G = G_m + 2 nu M D      Kg = K_m + nu G_m D + nu^2 M D^2      ramps E = nu' M D + w' G_m/(2 w)      C q' + nu C D q

Derived here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def about_z(vectors: Array, angle: Array | float) -> Array:
    """Vectors (r, 3) turned about z by an angle [rad] each."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = vectors.T
    return np.stack([c * x - s * y, s * x + c * y, z], axis=1)


class Springs(NamedTuple):
    """Springs of a body that bends: rows (p, 6 + e) of its coordinates, stiffness (p,) [N/m], and names (p,)."""

    rows: Array
    stiffness: Array
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElasticBody:
    """Coordinates e by which a body bends, beside x y z rx ry rz of its mean motion; matrices are of all 6 + e.

    names : (e,) of the coordinates [m].  mass : M, its block of the six is that of the file and zero here.
    springs : those whose energy is the strain energy.  foundation : those of a uniform one in the housing.
    damping : C of the material (6 + e, 6 + e), its block of the six zero.
    turn : D (6 + e, 6 + e).  waves : its highest number of waves; None of a body that turns with its frame, without D.
    spin, spin_stiffness : G_m per spin w [kg] and K_m per w^2 [kg], their blocks of the six zero.
    spin_load : (6 + e,) load of the spin per w^2 [kg m].
    shape : of points (R, 3) from its centre, in its axes [m], displacement along x, y, z and rotation about them
        per coordinate, (R, 6, e).
    cyclic : of a body that is not axisymmetric `turned`.
    """

    names: tuple[str, ...]
    mass: Array
    springs: Springs
    foundation: Springs
    damping: Array
    turn: Array
    waves: int | None
    spin: Array
    spin_stiffness: Array
    spin_load: Array
    shape: Callable[[Array], Array]
    cyclic: Callable[[float], Array | None] | None = None

    def turned(self, angle: float) -> Array | None:
        """Operator (e, e) that turns the pattern of the body by an angle [rad]; None where that is another body."""
        if self.cyclic is not None:
            return self.cyclic(angle)
        from scipy.linalg import expm

        return np.asarray(expm(-angle * self.turn[6:, 6:]))

    def __repr__(self) -> str:
        """One line: number of coordinates."""
        return f"ElasticBody({len(self.names)} coordinates)"

    def gyroscopic(self, frame_speed: float, spin: float) -> Array:
        """G in a frame of speed Omega of a body of absolute speed w, both [rad/s]."""
        return spin * self.spin + 2 * (spin - frame_speed) * self.mass @ self.turn

    def centrifugal(self, frame_speed: float, spin: float) -> Array:
        """Kg; arguments as of `gyroscopic`."""
        nu, D = spin - frame_speed, self.turn
        return spin**2 * self.spin_stiffness + nu * spin * self.spin @ D + nu**2 * self.mass @ D @ D

    def euler(self, frame_speed: float, spin: float) -> Array:
        """E, the stiffness-like terms per relative acceleration; arguments as of `gyroscopic`."""
        return (spin - frame_speed) * self.mass @ self.turn + spin / 2 * self.spin
