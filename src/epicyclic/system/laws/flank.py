"""Protocol of flank laws: force over one gap, at a phase of the mesh cycle.

A flank law holds c rows of one kind.  `at` fixes the phases, which is the expensive part and is kept by the caller;
`evaluate` is then asked for forces at gaps, once a Newton step or integrator stage.  A law only pushes: at gaps up to
`touch` its force is zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["FlankAt", "FlankLaw", "LawRows"]

Array = NDArray[np.float64]


class FlankAt(Protocol):
    """Laws of c rows at P phases.  Gaps delta are (..., P, c) [m]: leading axes are other phases, speeds or cases."""

    @property
    def touch(self) -> Array:
        """Gap at which the force begins (P, c) [m]; a row presses where delta > touch."""
        ...

    @property
    def kinks(self) -> Array:
        """Gaps at which the tangent jumps (P, c, K) [m]."""
        ...

    def instants(self, chosen: Any) -> FlankAt:
        """The same at the chosen ones of the P phases."""
        ...

    def rows(self, chosen: Any) -> FlankAt:
        """The same of the chosen ones of the c rows."""
        ...

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] at gaps delta (..., P, c) [m], each (..., P, c)."""
        ...

    def energy(self, delta: Array) -> Array:
        """Energy (..., P, c) [J] at gaps delta [m], zero at `touch`; its slope is the force."""
        ...

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        """Whether the tangent of each row keeps one value at every phase (c,) over the gaps low .. high (c,) [m]."""
        ...


class FlankLaw(Protocol):
    """Law of c rows; row j follows the phase of mesh tone `tone[j]`."""

    @property
    def stiffest(self) -> Array:
        """Bound of the tangent (c,) [N/m], for step lengths and line searches."""
        ...

    @property
    def end(self) -> Array:
        """Largest force (c,) [N] that the data of the law hold, inf where they are a formula; behind it the law goes on
        along its last tangent."""
        ...

    @property
    def load(self) -> Array:
        """Force (c,) [N] at which the tangents that linear analyses use were taken, nan where it is not known."""
        ...

    def rows(self, chosen: Any) -> FlankLaw:
        """The law of the chosen ones of the c rows."""
        ...

    def at(self, phases: Array) -> FlankAt:
        """The law at P phases; phases : (P, D) of all mesh tones [cycles]."""
        ...

    def lower(self) -> FlankLaw | None:
        """The same law as one that compiled integrators know (linear, tabulated), None where there is none.

        A law without one is integrated with NumPy.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawRows:
    """A law and the numbers (c,) of its rows among all."""

    law: FlankLaw
    rows: NDArray[np.int64]

    def __repr__(self) -> str:
        """One line: the law and how many rows follow it."""
        return f"LawRows({self.law!r} of {len(self.rows)} rows)"
