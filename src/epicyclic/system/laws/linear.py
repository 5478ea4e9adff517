"""Linear law with parametric stiffness: f = k(t) <delta> of a flank, k periodic in its mesh tone [kahraman1990].

    k(theta) = k0 (1 + Re sum_l v_l exp(2 pi i l theta)),    theta the phase of the tone [cycles]

A truncated series may dip below zero where the true stiffness is small: k stays above 1e-6 k0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["LEAST", "LinearAt", "LinearLaw"]

Array = NDArray[np.float64]

# Least stiffness of a closed flank per its mean: below any support, and the energy stays convex.
LEAST = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearLaw:
    """Linear flanks.

    stiffness : (c,) mean k0 [N/m].  variation : (c, L) complex, per mean, over the phase of the tone, leads contained.
    tone : (c,) mesh tone of each.
    """

    stiffness: Array
    variation: NDArray[np.complex128]
    tone: NDArray[np.int64]

    def __repr__(self) -> str:
        """One line: number of rows and orders."""
        return f"LinearLaw({len(self.stiffness)} rows, {self.variation.shape[1]} orders)"

    @property
    def stiffest(self) -> Array:
        """Bound of the stiffness (c,) [N/m]: all orders in phase."""
        bound: Array = self.stiffness * (1 + np.abs(self.variation).sum(axis=1))
        return bound

    @property
    def end(self) -> Array:
        """No end (c,): inf [N]."""
        return np.full(self.stiffness.size, np.inf)

    @property
    def load(self) -> Array:
        """Not known (c,): nan [N]; the tangent is the same at every load."""
        return np.full(self.stiffness.size, np.nan)

    def rows(self, chosen: Any) -> LinearLaw:
        """The law of the chosen rows."""
        return replace(self, stiffness=self.stiffness[chosen], variation=self.variation[chosen], tone=self.tone[chosen])

    def at(self, phases: Array) -> LinearAt:
        """Stiffness at phases (P, D) [cycles]."""
        result = np.empty((len(phases), self.stiffness.size))
        orders = np.arange(1, self.variation.shape[1] + 1)
        for tone in np.unique(self.tone):
            mine = self.tone == tone
            wave = np.exp(2j * np.pi * np.outer(phases[:, tone], orders))
            relative = 1 + (wave @ self.variation[mine].T).real
            result[:, mine] = self.stiffness[mine] * np.maximum(relative, LEAST)
        return LinearAt(stiffness=result)

    def lower(self) -> LinearLaw:
        """Itself."""
        return self


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearAt:
    """Linear flanks of stiffness (P, c) [N/m] at P phases."""

    stiffness: Array

    @property
    def touch(self) -> Array:
        """Zero (P, c) [m]."""
        return np.zeros_like(self.stiffness)

    @property
    def kinks(self) -> Array:
        """First touch (P, c, 1) [m]."""
        return self.touch[:, :, None]

    def instants(self, chosen: Any) -> LinearAt:
        """The same at the chosen phases."""
        return LinearAt(stiffness=self.stiffness[chosen])

    def rows(self, chosen: Any) -> LinearAt:
        """The same of the chosen rows."""
        return LinearAt(stiffness=self.stiffness[:, chosen])

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] at gaps delta (..., P, c) [m]."""
        return self.stiffness * np.maximum(delta, 0.0), np.where(delta > 0, self.stiffness, 0.0)

    def energy(self, delta: Array) -> Array:
        """k <delta>^2 / 2, (..., P, c) [J]."""
        energy: Array = self.stiffness * np.maximum(delta, 0.0) ** 2 / 2
        return energy

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        """Whether a row stays closed, or open, over the gaps low .. high (c,) [m]."""
        return (low > 0) | (high <= 0)
