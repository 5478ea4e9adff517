"""Force of one pair of gears, tabulated over the gap and the phase of the mesh cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .series import ComplexArray

__all__ = ["ContactTable"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactTable:
    """Contact of a helix over S places of a mesh cycle and L loads, the first of them zero.

    load : the operating one [N].  stiffness : mean tangent there [N/m].  variation : (12,) relative series over sigma.
    missing : (13,) complex one-sided amplitudes of e over sigma, the mean first [m].
    force : (L,) [N].  gap : (S, L) d - e at sigma = 0, 1/S, ...; in the first column where the teeth first touch [m].
    slope : (S, L) dF/dd [N/m].
    """

    load: float
    stiffness: float
    variation: ComplexArray
    missing: ComplexArray
    force: Array
    gap: Array
    slope: Array
