"""Laws of groups as the integrators take them: one row of numbers a group, and the tangents in the mean system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...system.laws import groups as law
from ...system.system import Array, System
from ..static.tangent import mean_stretch

__all__ = ["Held", "held_laws"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Held:
    """Laws of G groups over R rows.

    numbers : (G, 9) first row, rows, stiffness k, friction F_m, slip start S_1, end of the play S_2, coefficient and
        exponent of what follows, lag; F_m < 0 says that the group is held to its slider by k.
    anchor : (R,) that slider [m].  tangent : (R, R) as the mean system has it [N/m].
    stiffest : (R,) how much stiffer a row may become [N/m].
    warnings : what was simplified.
    """

    numbers: Array
    anchor: Array
    tangent: Array
    stiffest: Array
    warnings: tuple[str, ...]


def held_laws(system: System) -> Held:
    """The laws of a System; Coulomb friction with a memory sticks where the mean load has left its slider."""
    laws = system.laws
    if not system.groups:
        none = np.zeros(0)
        return Held(numbers=np.zeros((0, 9)), anchor=none, tangent=np.zeros((0, 0)), stiffest=none, warnings=())
    stretch = mean_stretch(system)
    tangent = law.tangent(laws, stretch)
    sticks = law.row_owner(laws, laws.memory)
    tangent = np.where(sticks[:, None], np.diag(laws.row_stiffness), tangent)
    anchor = np.where(sticks, stretch - law.force(laws, stretch) / laws.row_stiffness, 0.0)
    rows = [len(group.rows) for group in system.groups]
    numbers = np.stack(
        [
            laws.first.astype(float),
            np.array(rows, dtype=float),
            laws.stiffness,
            np.where(laws.memory, -1.0, laws.friction),
            laws.slip_start,
            laws.slip_start + laws.clearance,
            laws.coefficient,
            laws.exponent,
            np.array([group.lag for group in system.groups]),
        ],
        axis=1,
    )
    names = [group.name for group in system.groups if group.law.memory and group.law.friction]
    note = f"{', '.join(names)}: Coulomb friction sticks: its slider stays where the mean load has put it"
    return Held(
        numbers=numbers,
        anchor=anchor,
        tangent=tangent,
        stiffest=np.maximum(laws.row_stiffness - np.diag(tangent), 0.0),
        warnings=(note,) if names else (),
    )
