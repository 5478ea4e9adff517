"""Laws of gaps as the numbers that compiled steps take: flanks linear or tabulated, groups radial or with a slider."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...statics.tangent import mean_stretch, small_motion_tangent
from ...system.flank_laws import LinearLaw, TabulatedLaw, phase_cubics
from ...system.gaps import Flanks
from ...system.group_laws import Laws
from ...system.system import Array, System

__all__ = ["FlankNumbers", "LawNumbers", "flank_numbers", "law_numbers"]

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlankNumbers:
    """Laws of F flanks as the compiled steps take them.

    mean : (F,) [N/m] and wave : (2, F, L) variation of linear rows.  table : (F,) number of the table of a row, -1 of a
        linear one.  lead, sense : (F,) of rows with a table: sigma = sense (cycles + lead).
    tables : (T, 4) first cubic, phases S, loads L and first force of each table.
    cubics : (.., 4) of `phase_cubics`, row (cell 2 L + j) of its table.  forces : (..,) at its knots [N].
    slow : pairs whose law has no such form; the numbers are then of no use.
    """

    mean: Array
    wave: Array
    table: Index
    lead: Array
    sense: Array
    tables: Index
    cubics: Array
    forces: Array
    slow: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawNumbers:
    """Laws of G groups over R rows as the compiled steps take them: one row of numbers a group.

    numbers : (G, 10) first row, rows, stiffness k, friction F_m, slip start S_1, end of the play S_2, coefficient and
        exponent of what follows, lag, clearance; -F_m says that the friction has a memory.
    anchor : (R,) sliders where the mean load has put them [m]; (0,) where no group has a memory.
    tangent : (R, R) as the mean system has it [N/m].  stiffest : (R,) how much stiffer a row may become [N/m].
    slow : names of groups whose law has no such form; the numbers are then of no use.
    """

    numbers: Array
    anchor: Array
    tangent: Array
    stiffest: Array
    slow: tuple[str, ...]


def flank_numbers(given: Flanks, pairs: tuple[str, ...]) -> FlankNumbers:
    """The laws of all flanks as numbers; pairs : (m,) of the mesh rows."""
    F, slow = len(given.mesh), dict[str, None]()
    mean, variation = given.stiffness.copy(), given.variation
    table, lead, sense = np.full(F, -1, np.int64), np.zeros(F), np.ones(F)
    tables, cubics, forces = list[list[int]](), [np.zeros((0, 4))], [np.zeros(0)]
    for part in given.laws:
        law = part.law.lower()
        if isinstance(law, LinearLaw):
            mean[part.rows] = law.stiffness
            more = law.variation.shape[1] - variation.shape[1]
            variation = np.pad(variation, ((0, 0), (0, max(more, 0))))
            variation[part.rows] = np.pad(law.variation, ((0, 0), (0, max(-more, 0))))
        elif isinstance(law, TabulatedLaw):
            table[part.rows], lead[part.rows], sense[part.rows] = len(tables), law.lead, law.sense
            phases, loads = law.gap.shape
            tables.append([sum(map(len, cubics)), phases, loads, sum(map(len, forces))])
            cubics.append(phase_cubics(law).reshape(-1, 4))
            forces.append(law.force)
        else:
            slow |= dict.fromkeys(pairs[int(given.mesh[row])] for row in part.rows)
    return FlankNumbers(
        mean=mean,
        wave=np.stack([variation.real, variation.imag]),
        table=table,
        lead=lead,
        sense=sense,
        tables=np.array(tables, np.int64).reshape(len(tables), 4),
        cubics=np.concatenate(cubics),
        forces=np.concatenate(forces),
        slow=tuple(slow),
    )


def law_numbers(system: System, laws: Laws) -> LawNumbers:
    """The laws of the groups of a System as numbers; sliders of friction with a memory start where the mean load is."""
    if not system.groups:
        none = np.zeros(0)
        return LawNumbers(numbers=np.zeros((0, 10)), anchor=none, tangent=np.zeros((0, 0)), stiffest=none, slow=())
    stretch = mean_stretch(system)
    tangent = small_motion_tangent(laws, stretch, floating=True)
    anchor = np.zeros(0)
    if laws.memory.any():
        anchor = np.where(laws.row_memory, stretch - laws.force(stretch) / laws.row_stiffness, 0.0)
    numbers, slow = np.zeros((len(system.groups), 10)), []
    for row, first, group in zip(numbers, laws.rows.first, system.groups, strict=True):
        law = group.law.lower()
        if law is None:
            slow.append(group.name)
            continue
        friction = -law.friction if law.memory and law.friction > 0 else law.friction
        stop = law.slip_start + law.clearance
        row[:] = (
            *(first, len(group.rows), law.stiffness, friction, law.slip_start, stop),
            *(law.coefficient, law.exponent, group.lag, law.clearance),
        )
    return LawNumbers(
        numbers=numbers,
        anchor=anchor,
        tangent=tangent,
        stiffest=np.maximum(laws.rows.spread(laws.stiffest) - np.diag(tangent), 0.0),
        slow=tuple(slow),
    )
