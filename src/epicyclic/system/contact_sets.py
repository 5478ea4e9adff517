"""Law of a bearing that carries axial load or tilt: contacts between its rings, each a power of its own approach.

With the motion q (r,) of the inner ring against the outer one, at most x, y, z [m], rx, ry [rad], contact j of normal
n_j, gap g_j and coefficient c_j has the energy c_j <n_j . q - g_j>^(p + 1) / (p + 1), convex in q, so that

    F(q) = sum_j c_j <n_j . q - g_j>^p n_j        K(q) = sum_j p c_j <n_j . q - g_j>^(p - 1) n_j n_j'

K is symmetric and has no negative eigenvalue.  The contacts are fixed in the frame of the link and evenly spread about
its axis: an integral over rolling elements, without what varies as these pass by.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Contacts:
    """E contacts over r rows as arrays.

    normals : n (E, r) [1, m].  gap : g (E,) [m].  coefficient : c (E,) [N/m^p].  exponent : p, 1 or more.
    """

    normals: Array
    gap: Array
    coefficient: Array
    exponent: float

    def approach(self, q: Array) -> Array:
        """How far each contact is pressed (..., E) [m], negative where it is open, at motions q (..., r) [m, rad]."""
        approach: Array = q @ self.normals.T - self.gap
        return approach

    def energy(self, q: Array) -> Array:
        """(...) [J] at motions q (..., r) [m, rad]."""
        p = self.exponent
        energy: Array = np.maximum(self.approach(q), 0.0) ** (p + 1) @ self.coefficient / (p + 1)
        return energy

    def force(self, q: Array) -> Array:
        """(..., r) [N, N m] at motions q (..., r) [m, rad], the gradient of the energy."""
        force: Array = (self.coefficient * np.maximum(self.approach(q), 0.0) ** self.exponent) @ self.normals
        return force

    def tangent(self, q: Array) -> Array:
        """Derivative of the force (..., r, r) [N/m, N/rad, N m/rad] at motions q (..., r) [m, rad]."""
        approach, p = self.approach(q), self.exponent
        slope = np.where(approach >= 0, p * self.coefficient * np.maximum(approach, 0.0) ** (p - 1), 0.0)
        return self.summed(slope)

    def summed(self, slope: Array) -> Array:
        """Sum of slopes (..., E) [N/m] times n n' (..., r, r)."""
        r = self.normals.shape[1]
        dyads = (self.normals[:, :, None] * self.normals[:, None, :]).reshape(-1, r * r)
        total: Array = (slope @ dyads).reshape(*slope.shape[:-1], r, r)
        return total


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactSetLaw:
    """Contacts of one link as its law, over r rows.

    normals : E tuples n (r,) [1, m].  gap : g (E,) [m].  coefficient : c (E,) [N/m^p].  exponent : p, 1 or more.
    load : sum of the contact forces at which all contacts, equally pressed, have the nominal stiffness [N].
    """

    normals: tuple[tuple[float, ...], ...] = field(repr=False)
    gap: tuple[float, ...] = field(repr=False)
    coefficient: tuple[float, ...] = field(repr=False)
    exponent: float
    load: float
    # the same of every set, and so no fields
    kind = "contact set"
    slip_start = 0.0
    friction = 0.0
    memory = False
    end = math.inf

    @property
    def contacts(self) -> Contacts:
        """The contacts as arrays."""
        return Contacts(
            normals=np.array(self.normals),
            gap=np.array(self.gap),
            coefficient=np.array(self.coefficient),
            exponent=self.exponent,
        )

    @property
    def nominal(self) -> Array:
        """Tangent (r, r) [N/m, N/rad, N m/rad] of all contacts, equally pressed to forces of the sum `load`."""
        contacts, p = self.contacts, self.exponent
        approach = (self.load / contacts.coefficient.sum()) ** (1 / p)
        return contacts.summed(p * contacts.coefficient * approach ** (p - 1))

    @property
    def stiffness(self) -> Array:
        """Of each row in the mean system before it is linearised, (r,) [N/m, N m/rad]."""
        return np.diag(self.nominal)

    @property
    def stiffest(self) -> Array:
        """Slopes of the rows for step lengths, (r,) [N/m, N m/rad].

        Forces of one sum are stiffest, summed over directions, where they are equal: slopes are concave in the force.
        """
        return self.stiffness

    @property
    def clearance(self) -> float:
        """Least gap [m], 0 where a contact is pressed at rest."""
        return max(0.0, min(self.gap))

    def lower(self) -> ContactSetLaw:
        """Itself: compiled integrators know it."""
        return self
