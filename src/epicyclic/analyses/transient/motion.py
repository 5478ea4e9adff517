"""The equation of motion of a System in time, as plain arrays: first order, teeth that part, speed that varies.

In modal coordinates of the mean system, q = Phi y, Phi^T M Phi = 1:

    y'' = -omega_r^2 y - d_r y' + pulls^T (k0 gaps y - f) - (C + s G) y' - (s^2 Kg + s Cskew + s' E) y + push(t)

so that only what differs from the mean system is multiplied out.  Every phase is counted in tau = integral of s dt.
A flank presses where its gap is above zero, f = k(tau) gap + c gap', and else does nothing; its damper is of the
contact and acts with it.  Modal damping belongs to the mean system and acts always.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.system import Array, ComplexArray, Line, System
from ..modes.basis import mean_modes
from ..static.record import group_gap
from ..static.tangent import linear, mean_stretch, small_motion_tangent
from .program import Program, constant

__all__ = ["Contact", "Motion", "Numbers", "from_modal", "highest_rate", "motion", "to_modal"]

Contact = Literal["unilateral", "linear"]

# Torques balanced in the input leave rounding on a rigid mode, 1e-13 of the sum of magnitudes; a wrong one far more.
_BALANCE = 1e-9
# An operator below this part of the largest eigenvalue is the rounding of its projection.
_ROUNDING = 1e-15


class Numbers(NamedTuple):
    """All arrays of the equation.  n coordinates; F flanks (m loaded, then the far ones); R rows of groups; M = F + R.

    squared, rate : (n,) omega_r^2, d_r.  damp : (n, n) transposed C, G (P, ..).  stiff : transposed Kg, Cskew, E.
    gaps : (n, M).  pulls : (M, n).  linear : (F,) k0 inside omega_r^2.  block : (R, R) tangents inside it.
    mean, drag, opening : (F,) stiffness, damper, backlash.  wave : (2, F, L) variation.
    tone : (F,) index into tones : (D,) [Hz].
    pull : whether flanks pull too.  gap_at : (J,) [Hz] and gap : (2, J, M) errors.  rated : whether e' counts.
    force_at : (Jf,) [Hz] and force : (2, 4, Jf, n) for s^0, s, s^2, s'.
    steady : (n,).  load : (C, n).  spin : (n,) per s'.
    laws : (G, 9), see `LawNumbers`; anchor : (R,).
    time, speed, phase : (K,), level : (K, C) the program.
    """

    squared: Array
    rate: Array
    damp: Array
    stiff: Array
    gaps: Array
    pulls: Array
    linear: Array
    block: Array
    mean: Array
    drag: Array
    opening: Array
    wave: Array
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
    laws: Array
    anchor: Array
    time: Array
    speed: Array
    phase: Array
    level: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawNumbers:
    """Laws of G groups over R rows as the integrators take them: one row of numbers a group.

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """A System ready to be integrated under a program.

    system : with laws, or linear.  shapes : (n, n) Phi.  forces : (n, n) Phi^T.  momenta : (n, n) Phi^T M.
    rigid : (n,) which modes are rigid.  numbers : the equation.  program : what is prescribed.
    law_numbers : of the groups.  warnings : what was simplified.
    """

    system: System
    shapes: Array
    forces: Array
    momenta: Array
    rigid: NDArray[np.bool_]
    numbers: Numbers
    program: Program
    law_numbers: LawNumbers
    warnings: tuple[str, ...]


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
    program : of speed and loads; the operating speed for ever where None (`program.constant` for another).
    contact : ``unilateral``: flanks only push, far flanks behind their backlash, links follow their laws; ``linear``:
        flanks pull as they push and laws are replaced by their tangents, as the steady response has it.
    loads : (C, n) generalised forces that the levels of the program multiply [N, N m]; they come on top of the torques
        of the operating point.
    spin : (n,) forces per s' that balance the inertia of the nominal motion at its ports [N s, N m s].

    Raises
    ------
    ModelError : loads that do not balance along a rigid mode, a missing inertia, an unstable mean system.
    """
    if contact not in ("unilateral", "linear"):
        raise ModelError("no such contact", path="contact", given=contact, allowed="unilateral, linear")
    system.require_inertia()
    given = program or constant()
    mean = linear(system, asks_laws=contact == "unilateral")
    squared, shapes = mean_modes(mean)
    rigid = squared == 0
    lawful = system if contact == "unilateral" else mean
    lawful_rows = law_numbers(lawful)
    loads = np.zeros((0, len(system.force))) if loads is None else np.asarray(loads, dtype=float)
    accelerating = system.spin_up if system.spin_up.size else np.zeros(len(system.force))
    if spin is not None:
        accelerating = accelerating + spin
    numbers = _numbers(lawful, squared, shapes, lawful_rows, given, contact == "linear")
    still = sum((line.force[0].real for line in lawful.lines if line.frequency == 0), lawful.force.copy())
    modal = [_balanced_modal_force(part, shapes, rigid, system) for part in (still, *loads)]
    numbers = numbers._replace(
        steady=shapes.T @ lawful.force,
        load=np.array(modal[1:]).reshape(len(loads), squared.size),
        spin=np.zeros_like(squared) if given.steady else _balanced_modal_force(accelerating, shapes, rigid, system),
        rate=2 * (system.zeta or 0.0) * np.sqrt(squared),
    )
    # what the check has left on a rigid mode is rounding; left in, it would carry the train away
    numbers.steady[rigid] = -(shapes.T @ (still - lawful.force))[rigid]
    return Motion(
        system=lawful,
        shapes=shapes,
        forces=np.ascontiguousarray(shapes.T),
        momenta=shapes.T @ system.M,
        rigid=rigid,
        numbers=numbers,
        program=given,
        law_numbers=lawful_rows,
        warnings=lawful_rows.warnings,
    )


def law_numbers(system: System) -> LawNumbers:
    """The laws of a System as numbers.

    Coulomb friction with a memory sticks where the mean load has left its slider.
    """
    laws = system.laws
    if not system.groups:
        none = np.zeros(0)
        return LawNumbers(numbers=np.zeros((0, 9)), anchor=none, tangent=np.zeros((0, 0)), stiffest=none, warnings=())
    stretch = mean_stretch(system)
    tangent = small_motion_tangent(laws, stretch)
    sticks = laws.rows.spread(laws.memory)
    anchor = np.where(sticks, stretch - laws.force(stretch) / laws.row_stiffness, 0.0)
    rows = [len(group.rows) for group in system.groups]
    known = [law for group in system.groups if (law := group.law.lower()) is not None]
    numbers = np.stack(
        [
            laws.rows.first.astype(float),
            np.array(rows, dtype=float),
            laws.stiffness,
            np.where(laws.memory, -1.0, laws.friction),
            laws.slip_start,
            laws.slip_start + laws.clearance,
            np.array([law.coefficient for law in known]),
            np.array([law.exponent for law in known]),
            np.array([group.lag for group in system.groups]),
        ],
        axis=1,
    )
    names = [group.name for group in system.groups if group.law.memory and group.law.friction]
    note = f"{', '.join(names)}: Coulomb friction sticks: its slider stays where the mean load has put it"
    return LawNumbers(
        numbers=numbers,
        anchor=anchor,
        tangent=tangent,
        stiffest=np.maximum(laws.row_stiffness - np.diag(tangent), 0.0),
        warnings=(note,) if names else (),
    )


def to_modal(moving: Motion, state: Array) -> Array:
    """States (.., 2, n) q [m, rad], q' [m/s, rad/s] to modal y, y'."""
    return state @ moving.momenta.T


def from_modal(moving: Motion, state: Array) -> Array:
    """Modal states (.., 2, n) to q [m, rad], q' [m/s, rad/s]."""
    return state @ moving.shapes.T


def _balanced_modal_force(force: Array, shapes: Array, rigid: NDArray[np.bool_], system: System) -> Array:
    """Modal force (n,) of a load (n,) [N, N m] without the rounding on rigid modes.

    Raises
    ------
    ModelError : more than rounding acts on a rigid mode.
    """
    modal: Array = shapes.T @ force
    size = np.abs(shapes.T) @ np.abs(force)
    wrong = rigid & (np.abs(modal) > _BALANCE * size)
    if wrong.any():
        worst = int(np.argmax(np.where(wrong, np.abs(modal), 0.0)))
        name = system.dofs.names[int(np.argmax(np.abs(shapes[:, worst] * system.dofs.radius)))]
        raise ModelError(
            f"the loads do not balance on the free motion of {name}",
            path="torque",
            given=float(modal[worst] / size[worst]),
            allowed="loads in equilibrium, or one member left to take the balance",
        )
    return np.where(rigid, 0.0, modal)


def _numbers(
    system: System, squared: Array, shapes: Array, lawful_rows: LawNumbers, given: Program, linear: bool
) -> Numbers:
    """The equation without loads, from modes (n,) [rad^2/s^2] and shapes (n, n) of the mean system."""
    meshes, far = system.meshes, system.far_flanks
    own = far.mesh if not linear else far.mesh[:0]
    m, top = len(meshes.name), float(squared.max(initial=0.0))
    rows = np.concatenate([meshes.B, far.B[:, : own.size], system.group_rows], axis=1)
    gaps, pulls = np.ascontiguousarray(shapes.T @ rows), np.ascontiguousarray((shapes.T @ rows).T)
    # a rigid mode strains nothing: what is left is rounding, which would make its own force
    gaps[squared == 0] = 0.0
    pulls[:, squared == 0] = 0.0
    variation = np.concatenate([meshes.variation, far.variation[: own.size]])
    drag = np.concatenate([meshes.damping, meshes.damping[own]])
    gap_at, gap = _gap_lines(system, m, own.size, linear)
    force_at, force = _force_lines(system, shapes)
    empty = np.zeros(0)
    tones = np.array([float(tone) for tone in system.tones]) if system.tones else np.zeros(1)
    return Numbers(
        squared=squared,
        rate=empty,
        damp=_modal_operators([system.C, system.G], shapes, np.sqrt(top)),
        stiff=_without_nominal_motion(
            _modal_operators([system.Kg, system.Cskew, system.euler], shapes, top), system, shapes, squared == 0
        ),
        gaps=gaps,
        pulls=pulls,
        linear=np.concatenate([meshes.stiffness, np.zeros(own.size)]),
        block=lawful_rows.tangent,
        mean=np.concatenate([meshes.stiffness, meshes.stiffness[own]]),
        drag=drag,
        opening=np.concatenate([np.zeros(m), meshes.backlash[own]]),
        wave=np.stack([variation.real, variation.imag]),
        tone=np.concatenate([meshes.tone, meshes.tone[own]]).astype(np.int64),
        tones=tones,
        pull=linear,
        gap_at=gap_at,
        gap=np.stack([gap.real, gap.imag]),
        rated=bool(drag.any() or lawful_rows.numbers[:, 8].any()),
        force_at=force_at,
        force=np.stack([force.real, force.imag]),
        steady=empty,
        load=np.zeros((0, 0)),
        spin=empty,
        laws=lawful_rows.numbers,
        anchor=lawful_rows.anchor,
        time=given.time,
        speed=given.speed,
        phase=given.phase,
        level=given.level,
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


def _gap_lines(system: System, m: int, far: int, linear: bool) -> tuple[Array, ComplexArray]:
    """Frequencies (J,) [Hz] and errors (J, M) [m] of the lines that have any."""
    groups = system.group_rows.shape[1]

    def gaps(line: Line) -> ComplexArray:
        """Errors of all rows (M,) [m]."""
        mine = line.gap if linear else system.flank_gaps(line)
        return np.concatenate([mine[: m + far], group_gap(line, groups)])

    found = [(float(line.frequency), gaps(line)) for line in system.lines]
    found = [(frequency, values) for frequency, values in found if values.any()]
    return np.array([f for f, _ in found]), np.array([v for _, v in found], complex).reshape(
        len(found), m + far + groups
    )


def _force_lines(system: System, shapes: Array) -> tuple[Array, ComplexArray]:
    """Frequencies (J,) [Hz] and modal forces (4, J, n) of the lines that have any.

    Of frequency 0 too, for its s and s^2.
    """
    found = []
    for line in system.lines:
        ramp = line.ramp_force if line.ramp_force.size else np.zeros(len(shapes), complex)
        every = np.concatenate([line.force, ramp[None]])
        if every.any():
            found.append((float(line.frequency), every @ shapes))
    forces = np.array([v for _, v in found], complex).reshape(len(found), 4, len(shapes))
    return np.array([f for f, _ in found]), np.ascontiguousarray(forces.transpose(1, 0, 2))


def highest_rate(moving: Motion) -> float:
    """Upper bound of what moves fastest, stiffest flanks and all dampers counted [rad/s]."""
    N = moving.numbers
    extra = np.concatenate([N.mean * (1 + np.hypot(*N.wave).sum(axis=-1)) - N.linear, moving.law_numbers.stiffest])
    stiff = np.diag(N.squared) + (N.gaps * np.maximum(extra, 0.0)) @ N.pulls
    top = float(np.sqrt(np.max(scipy.linalg.eigvalsh((stiff + stiff.T) / 2), initial=0.0)))
    speed = float(N.speed.max())
    damping = (
        np.diag(N.rate)
        + N.damp[0].T
        + speed * N.damp[1].T
        + (N.gaps[:, : len(N.drag)] * N.drag) @ N.pulls[: len(N.drag)]
    )
    return top + float(np.linalg.norm(damping, 2))
