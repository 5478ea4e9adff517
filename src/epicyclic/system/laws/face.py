"""Protocol of meshes in tooth contact along the face: each is one convex potential of three rows.

The teeth of a mesh stay straight against each other, so that the approach of any place of its plane of action is

    w(zeta, s) = c1 w1 + c2 w2 + c3 w3,   c1 + c2 + c3 = 1

of its rows at both ends of the face, and at one place off the pitch point along the line of action.  The distribution
of load in between is internal to the law, which returns the force of each row, its derivative and the energy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["ROWS", "FaceContact", "FaceForce", "FaceLaw"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

ROWS = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceForce:
    """Forces of g meshes at t instants.

    force : (t, g, 3) of the rows [N].  tangent : (t, g, 3, 3) its derivative [N/m], symmetric.  energy : (t, g) [J].
    residual : (t, g) of the contact conditions [1].  state : (t, g, n) start of a later call [m].
    """

    force: Array
    tangent: Array
    energy: Array
    residual: Array
    state: Array


class FaceContact(Protocol):
    """Tooth contact of some meshes at T instants."""

    def press(self, rows: Array, instants: Index, start: Array | None) -> FaceForce:
        """Forces at given approaches.

        rows : (t, g, 3) approach of every row, positive closes it [m].  instants : (t,) among the T.
        start : state of a near call, at the same instants.
        """
        ...


class FaceLaw(Protocol):
    """Law of some equal meshes of a train."""

    @property
    def meshes(self) -> Sequence[int]:
        """Numbers (g,) among the whole meshes of the System, which have three rows each."""
        ...

    def at(self, cycles: Array) -> FaceContact:
        """Contact at times (T, g) counted in cycles of each mesh [mesh cycles]."""
        ...
