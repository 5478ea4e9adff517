"""Blend of a linear law and another: the homotopy by which a solver comes from the one to the other.

f = (1 - part) k <delta> + part f_law(delta)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .flank import FlankAt
from .linear import LinearAt

__all__ = ["Blended", "eased"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Blended:
    """A part [0 .. 1] of a law, the rest linear, at P phases."""

    linear: LinearAt
    law: FlankAt
    part: float

    @property
    def touch(self) -> Array:
        """The earlier of both first touches (P, c) [m]."""
        return np.minimum(self.linear.touch, self.law.touch)

    @property
    def kinks(self) -> Array:
        """Kinks of both (P, c, K) [m]."""
        return np.concatenate([self.linear.kinks, self.law.kinks], axis=2)

    def instants(self, chosen: Any) -> Blended:
        """The same at the chosen phases."""
        return replace(self, linear=self.linear.instants(chosen), law=self.law.instants(chosen))

    def rows(self, chosen: Any) -> Blended:
        """The same of the chosen rows."""
        return replace(self, linear=self.linear.rows(chosen), law=self.law.rows(chosen))

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] at gaps delta (..., P, c) [m]."""
        linear, own = self.linear.evaluate(delta), self.law.evaluate(delta)
        force, tangent = ((1 - self.part) * a + self.part * b for a, b in zip(linear, own, strict=True))
        return force, tangent

    def energy(self, delta: Array) -> Array:
        """Energy (..., P, c) [J] at gaps delta [m]."""
        energy: Array = (1 - self.part) * self.linear.energy(delta) + self.part * self.law.energy(delta)
        return energy

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        """Whether both tangents keep one value over the gaps low .. high (c,) [m]."""
        return self.linear.constant(low, high) & self.law.constant(low, high)


def eased(law: FlankAt, mean: Array, part: float) -> FlankAt:
    """A law with a part of its variation and curvature, the rest linear with the mean stiffness (c,) [N/m]."""
    if isinstance(law, LinearAt):
        return LinearAt(stiffness=mean + part * (law.stiffness - mean))
    linear = LinearAt(stiffness=np.broadcast_to(mean, law.touch.shape))
    return Blended(linear=linear, law=law, part=part)
