"""What the equation of motion is written with: products of one order, laws as numbers, the prescribed speed over time.

Sums of matrix products have one order, whatever number of threads BLAS takes: a run that is continued elsewhere comes
to the same bits only so.  Laws of gaps become the numbers that compiled steps take: flanks linear or tabulated, groups
radial or with a slider.  The program is the prescribed speed, the phase that follows from it, and levels of loads over
time; piecewise linear.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...statics.tangent import mean_stretch, small_motion_tangent
from ...system.flank_laws import LinearLaw, TabulatedLaw, phase_cubics
from ...system.gaps import Flanks
from ...system.link_laws import Laws
from ...system.system import Array, System

Index = NDArray[np.int64]
T = TypeVar("T", np.float64, np.complex128)
# Products a BLAS leaves to one thread: OpenBLAS shares out matrix products from 2.6e5 multiplications on.
_ONE_THREAD = 100_000


# --- products of one order -------------------------------------------------------------------------------------------


def per_instant(values: NDArray[T], matrix: NDArray[T]) -> NDArray[T]:
    """Products (.., k, c) of values (.., k, n) and a matrix (n, c), real or complex, instant by instant.

    NumPy asks BLAS for each of the small products; large ones do without it.
    """
    if values.shape[-2] * matrix.size > _ONE_THREAD:
        result: NDArray[T] = np.einsum("...kn,nc->...kc", values, matrix)
        return result
    result = values @ matrix
    return result


def times(vector: Array, matrix: Array) -> Array:
    """Product (c,) of a vector (n,) and a matrix (n, c), without BLAS: it shares out vector products from 1e4 on."""
    result: Array = np.einsum("n,nc->c", vector, matrix)
    return result


# --- laws as numbers -------------------------------------------------------------------------------------------------


class FlankNumbers(NamedTuple):
    """Laws of F flanks as the compiled steps take them.

    mean : (F,) [N/m] and wave : (2, L, F) variation of linear rows.  table : (F,) number of the table of a row, -1 of a
        linear one.  lead, sense : (F,) of rows with a table: sigma = sense (cycles + lead).
    tables : (T, 4) first cubic, phases S, loads L and first force of each table.
    cubics : (.., 4) of `phase_cubics`, row (cell 2 L + j) of its table.  forces : (..,) at its knots [N].
    """

    mean: Array
    wave: Array
    table: Index
    lead: Array
    sense: Array
    tables: Index
    cubics: Array
    forces: Array


class LawNumbers(NamedTuple):
    """Laws of G groups over R rows as the compiled steps take them: one row of numbers a group.

    numbers : (G, 10) first row, rows, stiffness k, friction F_m, slip start S_1, end of the play S_2, coefficient and
        exponent of what follows, lag, clearance; -F_m says that the friction has a memory.
    anchor : (R,) sliders where the mean load has put them [m]; (0,) where no group has a memory.
    tangent : (R, R) as the mean system has it [N/m].  stiffest : (R,) how much stiffer a row may become [N/m].
    """

    numbers: Array
    anchor: Array
    tangent: Array
    stiffest: Array


def flank_numbers(flanks: Flanks, pairs: tuple[str, ...]) -> tuple[FlankNumbers, tuple[str, ...]]:
    """The laws of all flanks as numbers; pairs : (m,) of the mesh rows.

    And the pairs whose law has no such form: with any, the numbers are of no use.
    """
    F, slow = len(flanks.mesh), dict[str, None]()
    mean, variation = flanks.stiffness.copy(), flanks.variation
    table, lead, sense = np.full(F, -1, np.int64), np.zeros(F), np.ones(F)
    tables, cubics, forces = list[list[int]](), [np.zeros((0, 4))], [np.zeros(0)]
    for lawful in flanks.laws:
        law, rows = lawful.law.lower(), lawful.rows
        if isinstance(law, LinearLaw):
            mean[rows] = law.stiffness
            more = law.variation.shape[1] - variation.shape[1]
            variation = np.pad(variation, ((0, 0), (0, max(more, 0))))
            variation[rows] = np.pad(law.variation, ((0, 0), (0, max(-more, 0))))
        elif isinstance(law, TabulatedLaw):
            table[rows], lead[rows], sense[rows] = len(tables), law.lead, law.sense
            phases, loads = law.gap.shape
            tables.append([sum(map(len, cubics)), phases, loads, sum(map(len, forces))])
            cubics.append(phase_cubics(law).reshape(-1, 4))
            forces.append(law.force)
        else:
            slow |= dict.fromkeys(pairs[int(flanks.mesh[row])] for row in rows)
    numbers = FlankNumbers(
        mean=mean,
        wave=np.stack([variation.real.T, variation.imag.T]),
        table=table,
        lead=lead,
        sense=sense,
        tables=np.array(tables, np.int64).reshape(len(tables), 4),
        cubics=np.concatenate(cubics),
        forces=np.concatenate(forces),
    )
    return numbers, tuple(slow)


def law_numbers(system: System, laws: Laws) -> tuple[LawNumbers, tuple[str, ...]]:
    """The laws of the groups of a System as numbers; sliders of friction with a memory start where the mean load is.

    And the groups whose law has no such form: with any, the numbers are of no use.
    """
    if not system.groups:
        none = np.zeros(0)
        return LawNumbers(numbers=np.zeros((0, 10)), anchor=none, tangent=np.zeros((0, 0)), stiffest=none), ()
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
        row[:6] = first, len(group.rows), law.stiffness, friction, law.slip_start, stop
        row[6:] = law.coefficient, law.exponent, group.lag, law.clearance
    stiffest = np.maximum(laws.rows.spread(laws.stiffest) - np.diag(tangent), 0.0)
    return LawNumbers(numbers=numbers, anchor=anchor, tangent=tangent, stiffest=stiffest), tuple(slow)


# --- prescribed speed and loads over time ----------------------------------------------------------------------------


class Steps(NamedTuple):
    """Fixed steps first .. first + samples keep - 1, of which every `keep`-th end is a sample.

    begin : time of step 0 [s], from which the time of every step is counted: where a run is cut does not change it.
    step : length [s].
    """

    begin: float
    step: float
    first: int
    keep: int
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Program:
    """Lines between knots; two knots at one time are a jump.

    time : (K,) [s], never falling.  speed : (K,) s, speed per operating speed.
    phase : (K,) integral of s dt, the time at the operating speed that every exponential counts in [s].
    level : (K, C) factors of C loads [1].
    """

    time: Array
    speed: Array
    phase: Array
    level: Array

    @property
    def steady(self) -> bool:
        """Whether the speed never changes."""
        return bool(np.all(self.speed == self.speed[0]))


def constant(speed: float = 1.0, *, phase: float = 0.0) -> Program:
    """One speed for ever, no further loads."""
    return program([0.0, 1.0], [speed, speed], phase=phase)


def program(time: ArrayLike, speed: ArrayLike, level: ArrayLike | None = None, *, phase: float = 0.0) -> Program:
    """Knots of the speed s and of load levels; the last line goes on beyond the last knot.

    Parameters
    ----------
    time, speed : (K,) [s], [1].  level : (K, C); none where None.  phase : at the first knot [s].

    Raises
    ------
    ModelError : times that fall or are not finite; a speed that is negative or jumps.
    """
    t, s = np.asarray(time, dtype=float), np.asarray(speed, dtype=float)
    levels = np.zeros((t.size, 0)) if level is None else np.asarray(level, dtype=float)
    first_times, first_speeds = t[:6].tolist(), s[:6].tolist()  # for messages
    if t.size < 2 or not (np.all(np.isfinite(t)) and np.all(np.diff(t) >= 0) and t[-1] > t[-2]):
        raise ModelError("times must be finite and rise", path="time", given=first_times, allowed="two or more")
    if not (np.all(np.isfinite(s)) and np.all(s >= 0)):
        raise ModelError("a relative speed is out of range", path="speed", given=first_speeds, allowed="zero or above")
    if np.any((np.diff(t) == 0) & (np.diff(s) != 0)):
        raise ModelError("the speed cannot jump", path="speed", given=first_speeds, allowed="a ramp")
    if not np.all(np.isfinite(levels)):
        raise ModelError("a load is not a finite number", path="level")
    passed = np.concatenate([[0.0], np.cumsum(np.diff(t) * (s[1:] + s[:-1]) / 2)])
    return Program(time=t, speed=s, phase=phase + passed, level=levels)


def _line_of(prescribed: Program, time: Array) -> tuple[Index, Array, Array]:
    """Knot before each time (T,) [s], time since [s], and the rate of the speed there [1/s]."""
    knots, speed = prescribed.time, prescribed.speed
    at = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, knots.size - 2)
    span = knots[at + 1] - knots[at]
    rise = np.where(span > 0, (speed[at + 1] - speed[at]) / np.where(span > 0, span, 1.0), 0.0)
    return at, time - knots[at], rise


def speed_at(prescribed: Program, time: Array) -> Array:
    """Relative speed s at times (T,) [s], (T,) [1]."""
    at, since, rise = _line_of(prescribed, time)
    speed: Array = prescribed.speed[at] + rise * since
    return speed


def phase_at(prescribed: Program, time: Array) -> Array:
    """Integral of s dt at times (T,) [s], (T,) [s]; exact."""
    at, since, rise = _line_of(prescribed, time)
    phase: Array = prescribed.phase[at] + since * (prescribed.speed[at] + rise * since / 2)
    return phase
