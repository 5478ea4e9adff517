"""The equation of motion of a System in time, as plain arrays: teeth that part, speed that varies.

In modal coordinates of the mean system, q = Phi y, Phi^T M Phi = 1:

    y'' = -omega_r^2 y - d_r y' + pulls^T (k0 gaps y - f) - (C + s G) y' - (s^2 Kg + s Cskew + s' E) y + push(t)

so that only what differs from the mean system is multiplied out.  Every phase is counted in tau = integral of s dt.
The forces f are those of the laws (`system.flank_laws`, `system.link_laws`).  A damper of a mesh is of the contact and
acts where its law presses, f = law(gap) + c gap'.  Modal damping belongs to the mean system and acts always.  Sliders
of Coulomb friction are part of the state: fixed within a step, they move at its end (`integrators`).

Sums of matrix products have one order, whatever number of threads BLAS takes: a run that is continued elsewhere comes
to the same bits only so.  Laws of gaps become the numbers that compiled steps take: flanks linear or tabulated, groups
radial or with a slider.  The program is the prescribed speed, the phase that follows from it, and levels of loads over
time; piecewise linear.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, TypeVar

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...statics.record import group_gap, require_free_balance
from ...statics.tangent import linear, mean_stretch, small_motion_tangent
from ...system.flank_laws import LEAST, LinearLaw, TabulatedLaw, phase_cubics
from ...system.gaps import Flanks, flanks
from ...system.link_laws import ContactSetLaw, Laws
from ...system.system import Array, ComplexArray, Index, System, faces
from ...warning_codes import CodedText, coded
from ..modes.eigen import mean_modes

T = TypeVar("T", np.float64, np.complex128)
# Products a BLAS leaves to one thread: OpenBLAS shares out matrix products from 2.6e5 multiplications on.
_ONE_THREAD = 100_000


# --- products of one order -------------------------------------------------------------------------------------------


def per_instant(values: NDArray[T], matrix: NDArray[T]) -> NDArray[T]:
    """Products (.., k, c) of values (.., k, n) and a matrix (n, c), real or complex, instant by instant.

    NumPy asks BLAS for each of the small products; large ones do without it.
    """
    large = values.shape[-2] * matrix.size > _ONE_THREAD
    return np.einsum("...kn,nc->...kc", values, matrix) if large else values @ matrix


def times(vector: Array, matrix: Array) -> Array:
    """Product (c,) of a vector (n,) and a matrix (n, c), without BLAS: it shares out vector products from 1e4 on."""
    return np.asarray(np.einsum("n,nc->c", vector, matrix))


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

    numbers : (G, 12) first row, rows, stiffness k, friction F_m, slip start S_1, end of the play S_2, coefficient and
        exponent of what follows, lag, clearance; -F_m says that the friction has a memory; first contact and contacts
        of a set, of which exponent and lag alone count.
    contacts : (.., 7) normals on the rows of a group, as many as it has [1, m], gap [m] and coefficient [N/m^p].
    anchor : (R,) sliders where the mean load has put them [m]; (0,) where no group has a memory.
    tangent : (R, R) as the mean system has it [N/m].  stiffest : (R,) how much stiffer a row may become [N/m].
    """

    numbers: Array
    contacts: Array
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
        # in one order of memory whatever their size: each order is a form that steps are compiled for
        wave=np.ascontiguousarray(np.stack([variation.real.T, variation.imag.T])),
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
        empty = np.zeros((0, 12)), np.zeros((0, 7)), none, np.zeros((0, 0)), none
        return LawNumbers(*empty), ()
    stretch = mean_stretch(system)
    tangent = small_motion_tangent(laws, stretch, floating=True)
    anchor = np.zeros(0)
    if laws.memory.any():
        anchor = np.where(laws.row_memory, stretch - laws.force(stretch) / laws.row_stiffness, 0.0)
    numbers, slow = np.zeros((len(system.groups), 12)), []
    contacts = [np.zeros((0, 7))]
    for row, first, group in zip(numbers, laws.rows.first, system.groups, strict=True):
        law, r = group.law.lower(), len(group.rows)
        if law is None:
            slow.append(group.name)
            continue
        if isinstance(law, ContactSetLaw):
            of, count = law.contacts, len(law.gap)
            row[[0, 1, 7, 8, 10, 11]] = first, r, law.exponent, group.lag, sum(map(len, contacts)), count
            contacts.append(np.column_stack([of.normals, np.zeros((count, 5 - r)), of.gap, of.coefficient]))
            continue
        friction = -law.friction if law.memory and law.friction > 0 else law.friction
        stop = law.slip_start + law.clearance
        row[:6] = first, r, law.stiffness, friction, law.slip_start, stop
        row[6:10] = law.coefficient, law.exponent, group.lag, law.clearance
    stiffest = np.maximum(laws.row_stiffest - np.diag(tangent), 0.0)
    return LawNumbers(numbers, np.concatenate(contacts), anchor, tangent, stiffest), tuple(slow)


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


class Program(NamedTuple):
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
    return prescribed.speed[at] + rise * since


def phase_at(prescribed: Program, time: Array) -> Array:
    """Integral of s dt at times (T,) [s], (T,) [s]; exact."""
    at, since, rise = _line_of(prescribed, time)
    return prescribed.phase[at] + since * (prescribed.speed[at] + rise * since / 2)


Contact = Literal["unilateral", "linear"]

# An operator below this part of the largest eigenvalue is the rounding of its projection.
_ROUNDING = 1e-15
# Squared frequencies apart by this part are one mode of alike bodies; a body moves in it that has this part of the
# energy of the body that has most.
_ALIKE, _MOVING = 1e-3, 0.1


class Numbers(NamedTuple):
    """All arrays of the equation.  n coordinates; F flanks (m loaded, then the far ones); R rows of groups; M = F + R.

    squared, rate : (n,) omega_r^2, d_r.  damp : (n, n) transposed C, G (P, ..).  stiff : transposed Kg, Cskew, E.
    wave_at : (Q,) [Hz] and wave : (2, Q, n, n) transposed, of links that pass a body.
    gaps : (n, M).  pulls : (M, n).  linear : (F,) k0 inside omega_r^2; the tangents of `link` are inside it too.
    flank, link : laws of flanks and groups.  program : of speed and loads.
    drag, opening : (F,) damper, backlash.  tone : (F,) index into tones : (D,) [Hz].
    least : least stiffness of a linear row per its mean.  pull : whether flanks are linear and pull too.
    gap_at : (J,) [Hz] and gap : (2, J, M) errors.  rated : whether e' counts.
    force_at : (Jf,) [Hz] and force : (2, 4, Jf, n) for s^0, s, s^2, s'.
    steady : (n,).  load : (C, n).  spin : (n,) per s'.
    whole : (F,) whole mesh of every flank.  loaded : number m of loaded flanks, which are the first ones.
    """

    squared: Array
    rate: Array
    damp: Array
    stiff: Array
    wave_at: Array
    wave: Array
    gaps: Array
    pulls: Array
    linear: Array
    flank: FlankNumbers
    link: LawNumbers
    program: Program
    drag: Array
    opening: Array
    least: float
    tone: NDArray[np.int64]
    tones: Array
    pull: bool
    gap_at: Array
    gap: Array
    rated: bool
    force_at: Array
    force: Array
    steady: Array
    load: Array
    spin: Array
    whole: NDArray[np.int64]
    loaded: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """A System ready to be integrated under a program.

    system : with laws, or linear.  shapes : (n, n) Phi.  momenta : (n, n) Phi^T M.
    rigid : (n,) which modes are rigid.  rows : (n, M) of all flanks and groups.
    flanks : of all rows that press, without far ones where linear.  laws : of the groups.
    numbers : the equation.  compiled : whether these hold all laws; else it is integrated with NumPy.
    program : what is prescribed.  warnings : what was simplified.
    """

    system: System
    shapes: Array
    momenta: Array
    rigid: NDArray[np.bool_]
    rows: Array
    flanks: Flanks
    laws: Laws
    numbers: Numbers
    compiled: bool
    program: Program
    warnings: tuple[CodedText, ...]


def motion(
    system: System,
    *,
    program: Program | None = None,
    contact: Contact = "unilateral",
    loads: Array | None = None,
    spin: Array | None = None,
) -> Motion:
    """The equation of motion of a System in time.

    Parameters
    ----------
    program : of speed and loads; the operating speed for ever where None (`constant` for another).
    contact : ``unilateral``: flanks only push, far flanks behind their backlash, links follow their laws; ``linear``:
        flanks pull as they push and laws are replaced by their tangents, as the steady response has it.
    loads : (C, n) generalised forces that the levels of the program multiply [N, N m]; they come on top of the torques
        of the operating point.
    spin : (n,) forces per s' that balance the inertia of the nominal motion at its ports [N s, N m s].

    Raises
    ------
    ModelError : loads that do not balance along a rigid mode, a missing inertia, an unstable mean system.
    """
    system.require_inertia()
    program, unilateral = program or constant(), contact == "unilateral"
    mean = linear(system, asks_laws=unilateral, floating=unilateral)
    squared, shapes = mean_modes(mean)
    rigid = squared == 0
    lawful = system if unilateral else mean
    laws, pressing = lawful.laws, flanks(lawful, far=unilateral)
    flank_rows, slow_pairs = flank_numbers(pressing, system.meshes.pair)
    lawful_rows, slow_groups = law_numbers(lawful, laws)
    loads = np.zeros((0, len(system.force))) if loads is None else np.asarray(loads, dtype=float)
    accelerating = system.spin_up if system.spin_up.size else np.zeros(len(system.force))
    if spin is not None:
        accelerating = accelerating + spin
    rows = np.concatenate([pressing.B, lawful.group_rows], axis=1)
    still = sum((line.force[0].real for line in lawful.lines if line.frequency == 0), lawful.force.copy())
    modal = [_balanced_modal_force(load, shapes, rigid, system) for load in (still, *loads)]
    steady = shapes.T @ lawful.force
    # what the check has left on a rigid mode is rounding; left in, it would carry the train away
    steady[rigid] = -(shapes.T @ (still - lawful.force))[rigid]
    turned = np.zeros_like(squared) if program.steady else _balanced_modal_force(accelerating, shapes, rigid, system)
    numbers = _numbers(
        lawful,
        (squared, shapes),
        (pressing, flank_rows, lawful_rows, rows),
        (steady, np.array(modal[1:]).reshape(len(loads), squared.size), turned),
        program,
        linear=not unilateral,
    )
    slow = (*slow_pairs, *slow_groups)
    text = f"{', '.join(slow)}: a law without a compiled form: integrated with NumPy, some 30 times slower"
    return Motion(
        system=lawful,
        shapes=shapes,
        momenta=shapes.T @ system.M,
        rigid=rigid,
        rows=rows,
        flanks=pressing,
        laws=laws,
        numbers=numbers,
        compiled=not slow,
        program=program,
        warnings=(coded("slow-law", text),) if slow else (),
    )


def in_modes_of_its_speed(moving: Motion) -> Motion:
    """The same motion at a constant speed in coordinates that its centripetal terms do not couple: cheaper steps.

    Rigid modes stay.  The motion itself where its stiffness is not symmetric, or couples rigid modes, at that speed.
    """
    N, rigid = moving.numbers, moving.rigid
    speed = float(N.program.speed[0])
    if not moving.program.steady or N.wave_at.size or N.stiff[1].any() or not N.stiff[0].any():
        return moving
    if N.stiff[0][rigid].any() or N.stiff[0][:, rigid].any():
        return moving
    elastic, turn = np.flatnonzero(~rigid), np.eye(rigid.size)
    stiff = (np.diag(N.squared) + speed**2 * N.stiff[0])[np.ix_(elastic, elastic)]
    squared = np.zeros(rigid.size)
    squared[elastic], turn[np.ix_(elastic, elastic)] = scipy.linalg.eigh((stiff + stiff.T) / 2)
    rates = np.diag(N.rate) + N.damp[0] + speed * N.damp[1]
    numbers = N._replace(
        squared=squared,
        rate=np.zeros_like(N.rate),
        damp=np.ascontiguousarray(np.stack([turn.T @ rates @ turn, np.zeros_like(rates)])),
        stiff=np.zeros_like(N.stiff),
        gaps=np.ascontiguousarray(turn.T @ N.gaps),
        pulls=np.ascontiguousarray(N.pulls @ turn),
        force=np.ascontiguousarray(N.force @ turn),
        steady=N.steady @ turn,
        load=np.ascontiguousarray(N.load @ turn),
        spin=N.spin @ turn,
    )
    return replace(
        moving,
        shapes=moving.shapes @ turn,
        momenta=turn.T @ moving.momenta,
        numbers=numbers,
    )


def to_modal(moving: Motion, state: Array) -> Array:
    """States (.., 2, n) q [m, rad], q' [m/s, rad/s] to modal y, y'."""
    return per_instant(state, moving.momenta.T)


def from_modal(moving: Motion, state: Array) -> Array:
    """Modal states (.., 2, n) to q [m, rad], q' [m/s, rad/s]."""
    return per_instant(state, moving.shapes.T)


def phases_at(moving: Motion, tau: Array) -> Array:
    """Phases (T, D) of the mesh tones [cycles] at integrals tau (T,) of the relative speed [s]."""
    return np.multiply.outer(tau, moving.numbers.tones)


def tangent_series(moving: Motion, tau: Array) -> Array:
    """Stiffness (T, F) [N/m] of flanks that pull as they press: the series as it is, as linear response has it.

    tau : (T,) integral of the relative speed [s].
    """
    N = moving.numbers
    angle = 2 * np.pi * np.multiply.outer(tau, N.tones)[:, N.tone]
    k = np.ones(angle.shape)
    for order, (cosine, sine) in enumerate(zip(*N.flank.wave, strict=True), start=1):
        k += cosine * np.cos(order * angle) - sine * np.sin(order * angle)
    return N.flank.mean * k


def _balanced_modal_force(force: Array, shapes: Array, rigid: NDArray[np.bool_], system: System) -> Array:
    """Modal force (n,) of a load (n,) [N, N m] without the rounding on rigid modes.

    Raises
    ------
    ModelError : more than rounding acts on a rigid mode.
    """
    cure = "loads in equilibrium, or one member left to take the balance"
    require_free_balance(shapes[:, rigid], force, system, path="torque", cure=cure)
    return np.where(rigid, 0.0, shapes.T @ force)


def _numbers(
    system: System,
    modes: tuple[Array, Array],
    laws: tuple[Flanks, FlankNumbers, LawNumbers, Array],
    loads: tuple[Array, Array, Array],
    program: Program,
    *,
    linear: bool,
) -> Numbers:
    """The equation, from modes (n,) [rad^2/s^2] and shapes (n, n) of the mean system.

    laws : flanks, these and groups as numbers, and the rows (n, M) of both.  loads : steady, load and spin.
    """
    (squared, shapes), (pressing, flank_rows, lawful_rows, rows), (steady, load, spin) = modes, laws, loads
    m, top = len(system.meshes.name), float(squared.max(initial=0.0))
    gaps, pulls = np.ascontiguousarray(shapes.T @ rows), np.ascontiguousarray((shapes.T @ rows).T)
    # a rigid mode strains nothing: what is left is rounding, which would make its own force
    gaps[squared == 0] = 0.0
    pulls[:, squared == 0] = 0.0
    gap_at, gap = _gap_lines(system, len(pressing.mesh), linear)
    force_at, force = _force_lines(system, shapes)
    tones = np.array([float(tone) for tone in system.tones]) if system.tones else np.zeros(1)
    wave_at, wave = _passing_waves(system, shapes, squared == 0)
    stiff = _modal_operators([system.Kg, system.Cskew, system.euler], shapes, top)
    return Numbers(
        squared=squared.copy(),  # the modes are read-only, which is another type to the compiler
        rate=2 * (system.zeta or 0.0) * np.sqrt(squared),
        damp=_modal_operators([system.C, system.G], shapes, np.sqrt(top)),
        stiff=_without_nominal_motion(stiff, system, shapes, squared == 0),
        wave_at=wave_at,
        wave=wave,
        gaps=gaps,
        pulls=pulls,
        linear=pressing.linear,
        flank=flank_rows,
        link=lawful_rows,
        program=program,
        drag=pressing.damping,
        opening=pressing.opening,
        least=-np.inf if linear else LEAST,
        tone=pressing.tone,
        tones=tones,
        pull=linear,
        gap_at=gap_at,
        gap=np.stack([gap.real, gap.imag]),
        rated=bool(pressing.damping.any() or any(group.lag for group in system.groups)),
        force_at=force_at,
        force=np.stack([force.real, force.imag]),
        steady=steady,
        load=load,
        spin=spin,
        whole=faces(system.meshes).row[pressing.mesh],
        loaded=m,
    )


def _modal_operators(matrices: list[Array], shapes: Array, scale: float) -> Array:
    """Modal operators, transposed, (P, n, n); entries below rounding of `scale` are zero."""
    n = len(shapes)
    result = np.zeros((len(matrices), n, n))
    for target, matrix in zip(result, matrices, strict=True):
        if matrix.any():
            modal = shapes.T @ matrix @ shapes
            target[:] = np.where(np.abs(modal) > _ROUNDING * scale, modal, 0.0).T
    return result


def _passing_waves(system: System, shapes: Array, rigid: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Frequencies (Q,) [Hz] and modal operators (2, Q, n, n), real and imaginary parts, of links that pass a body."""
    n, passing = len(shapes), system.passing
    if passing is None:
        return np.zeros(0), np.zeros((2, 0, n, n))
    rows, frequency, waves = shapes.T @ passing.B, list[float](), list[ComplexArray]()
    rows[rigid] = 0.0  # a rigid mode strains nothing
    for place, tone in enumerate(passing.tones):
        own = passing.tone == place
        for order in np.flatnonzero(passing.wave[own].any(axis=0)).tolist():
            frequency.append(float((order + 1) * tone))
            waves.append((rows[:, own] * passing.wave[own, order]) @ rows[:, own].T)
    values = np.array(waves)
    return np.array(frequency), np.ascontiguousarray(np.stack([values.real, values.imag]))


def _without_nominal_motion(stiff: Array, system: System, shapes: Array, rigid: NDArray[np.bool_]) -> Array:
    """Operators (P, n, n) whose Euler terms leave the nominal motion alone: what drives the train follows its inertia.

    Displaced bodies change the inertia of the whole by a part of 1e-5 or so; with a torque that does not follow it the
    train would run away from its prescribed speed, slowly and for ever.
    """
    if not system.spin_up.size:
        return stiff
    along = np.where(rigid, shapes.T @ system.spin_up, 0.0)
    size = np.linalg.norm(along)
    if size > 0:
        stiff[2] -= np.outer(stiff[2] @ along, along) / size**2
    return stiff


def _gap_lines(system: System, count: int, linear: bool) -> tuple[Array, ComplexArray]:
    """Frequencies (J,) [Hz] and errors (J, M) [m] of the lines that have any; count : of the flanks."""
    groups = system.group_rows.shape[1]
    frequency, errors = [], []
    for line in system.lines:
        of_flanks = line.gap if linear else system.flank_gaps(line)
        error = np.concatenate([of_flanks[:count], group_gap(line, groups)])
        if error.any():
            frequency.append(float(line.frequency))
            errors.append(error)
    return np.array(frequency), np.array(errors, complex).reshape(len(errors), count + groups)


def _force_lines(system: System, shapes: Array) -> tuple[Array, ComplexArray]:
    """Frequencies (J,) [Hz] and modal forces (4, J, n) of the lines that have any.

    Of frequency 0 too, for its s and s^2.
    """
    frequency, forces = [], []
    for line in system.lines:
        ramp = line.ramp_force if line.ramp_force.size else np.zeros(len(shapes), complex)
        powers = np.concatenate([line.force, ramp[None]])
        if powers.any():
            frequency.append(float(line.frequency))
            forces.append(powers @ shapes)
    modal = np.array(forces, complex).reshape(len(forces), 4, len(shapes))
    return np.array(frequency), np.ascontiguousarray(modal.transpose(1, 0, 2))


def highest_rate(moving: Motion) -> float:
    """Upper bound of what moves fastest, stiffest flanks and all dampers counted [rad/s]."""
    N = moving.numbers
    top = float(np.sqrt(np.max(scipy.linalg.eigvalsh(_stiffest(moving)), initial=0.0)))
    speed = float(N.program.speed.max())
    F = N.drag.size
    damping = np.diag(N.rate) + N.damp[0].T + speed * N.damp[1].T + (N.gaps[:, :F] * N.drag) @ N.pulls[:F]
    return top + float(np.linalg.norm(damping, 2))


def fastest_mode(moving: Motion) -> tuple[float, tuple[str, ...]]:
    """Frequency [Hz] of the fastest mode, stiffest flanks counted, and the bodies that move most in it.

    Modes of one frequency count together, and bodies by their part of the kinetic energy, so that neither a direction
    nor one of several alike bodies is chosen by rounding.
    """
    squared, vectors = scipy.linalg.eigh(_stiffest(moving))
    modes = vectors[:, squared >= (1 - _ALIKE) * squared[-1]]
    part = ((moving.shapes @ modes) * (moving.momenta.T @ modes)).sum(axis=1)
    of = moving.system.dofs.body
    energy = {body: sum(value for value, name in zip(part, of, strict=True) if name == body) for body in of}
    most = max(energy.values())
    frequency = float(np.sqrt(max(squared[-1], 0.0))) / (2 * np.pi)
    return frequency, tuple(body for body, value in energy.items() if value > _MOVING * most)


def _stiffest(moving: Motion) -> Array:
    """Stiffness (n, n) of the modes with the stiffest flanks and links that can press [1/s^2]."""
    N = moving.numbers
    extra = np.concatenate([moving.flanks.stiffest - N.linear, N.link.stiffest])
    stiff = np.diag(N.squared) + (N.gaps * np.maximum(extra, 0.0)) @ N.pulls
    stiff += np.eye(len(stiff)) * sum(np.linalg.norm(wave, 2) for wave in N.wave[0] + 1j * N.wave[1])
    return np.asarray((stiff + stiff.T) / 2)
