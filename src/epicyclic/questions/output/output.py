"""A gearbox at one of its shafts: stiffness over torque, hysteresis, lost motion, kinematic error, reflected inertia.

The other shafts are locked, by another operation of the model.  Torque over angle is taken through both flanks, one
cycle of the torque at several places of the mesh cycle.  The torque goes 0, +T, -T, +T in steps at each of which the
train is in equilibrium, with far flanks, play and laws.  Where a law has a memory the steps follow each other, else
each stands by itself and both branches are one.  What a cycle dissipates is the work of the sliders, F_m |ds| summed:
the area of the loop without the error of its steps.

Zero torque is left out: with play the angle is not unique there.  Angles count from mid-backlash.

The kinematic error of a shaft is its rotation less that which the ratio makes of the driving shaft, over its turns.
The train turns slowly under a share of the rated torque, all torques of the operation in that proportion: flanks open
and close where the deviations are larger than what yields.  The record is the common period of all lines, as far as it
goes; amplitudes at the exact orders of the shaft are those of least squares.  The row of rotations is that of
`system.signal_rows`, whose lag is positive; the error is its negative.

Stiffnesses and lost motion are read from the middle line of the loop of `hysteresis`: the tangent dT/dphi at every
torque; between 50 and 100 % of the rated torque the secant, and the slope of least squares.  Lost motion is the angle
at +share less that at -share of the rated torque, the backlash the same at a share so small that hardly anything
yields.

Of a drawing with tolerances the same of many trains: locked ones are solved together, with flanks and play; trains that
turn one by one, so that they are few.

Every shaft of a train that turns feels the whole: the kinetic energy of the rigid motion of the operation, E = sum (J
w^2 + m r_c^2 w_c^2) / 2 with the speeds of Willis, is that of the inertia 2 E / w^2 on a shaft that turns with w.
Derived here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.cases import at_case
from ...document.document import read
from ...document.schema import collect, reference
from ...document.tables import value_at
from ...engine.plan import all_uniforms, sampling_plan
from ...engine.points import attempt
from ...engine.workers import each
from ...errors import ModelError
from ...results.dataset import dataset
from ...statics.record import Record, RecordExcitation, excitation, excitation_of, record_of, turn_fraction
from ...statics.signals import Columns, error_ranges, largest_lines, line_label, near_lines
from ...statics.static import HeldTrain, balanced, ends_of_travel, held_train, quasi_static, settled, zero_warnings
from ...system.assembly import assemble, train_provenance
from ...system.system import Array, System
from ...train.kinematics import motions
from ...train.resolution import load
from ...train.train import Train, bodies_named, stage_axis
from ...warning_codes import CodedText, coded
from ..tolerance.tolerance_map import tolerance_map
from . import OutputOptions

# Tables of a document that speak of its operation, and keys of that which a locked train keeps.
_OF_OPERATION, _KEPT = ("assumed", "case", "cases", "loads", "operation", "tolerance"), ("open", "gravity")
# Paths of tolerances that are of the operation, and what their table has beside paths that are drawn.
_NOT_DRAWN = ("operation.", "cases.", "cost")
# Power below this share of the largest is rounding.
_NONE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputShaft:
    """A shaft of a train.

    name : member.  held : members that do not turn.  torque : rated, in the sense of the operation [N m].
    rated_by : `rated` of the option, `operation.rated` of the file, or the torque of `operation`.
    """

    name: str
    held: tuple[str, ...]
    torque: float
    rated_by: str


def ports(train: Train) -> list[str]:
    """Members at which torque enters or leaves; of a train without torques all central ones that nothing couples."""
    kinematics = train.kinematics
    loaded = [*kinematics.held, *kinematics.stated, *kinematics.reacting]
    if kinematics.torque is None:
        coupled = {name for tie in kinematics.ties for name in (tie.a, tie.b)}
        loaded += [name for name in central(train) if name not in coupled]
    return list(dict.fromkeys(loaded))


def central(train: Train) -> list[str]:
    """Members whose axis no carrier takes along."""
    return list(dict.fromkeys(body.member for body in train.bodies if body.branch is None))


def output_shaft(train: Train, shaft: str | None, held: Sequence[str] | None, rated: float | None) -> OutputShaft:
    """The shaft that is asked for, or the output of the train, with what is locked and its rated torque.

    Raises
    ------
    ModelError : no such member, a planet; no one output; a shaft that is locked or cannot turn, others that leave the
        train free; no rated torque.
    """
    known, kinematics = collect(train.document), train.kinematics
    name = _output(train) if shaft is None else reference(shaft, known, path="shaft", sides=False)
    others = [reference(one, known, path="held", sides=False) for one in held or ()]
    for path, one in [("shaft", name), *(("held", other) for other in others)]:
        if one not in central(train):
            allowed = ", ".join(central(train))
            raise ModelError("turns about an axis of its own, which is carried", path=path, given=one, allowed=allowed)
    if name in others:
        raise ModelError("is the shaft that is seen", path="held", given=name, allowed="other shafts")
    still = dict.fromkeys(one for one in kinematics.held if one != name)
    locked = still | dict.fromkeys(one for one in (ports(train) if held is None else others) if one != name)
    _check_locked(train, name, list(still), list(locked))
    torque, rated_by = _rated(train, name, rated)
    return OutputShaft(name=name, held=tuple(locked), torque=torque, rated_by=rated_by)


def _output(train: Train) -> str:
    """The one member that power leaves by, of a locked train the one that is loaded."""
    kinematics, power = train.kinematics, train.kinematics.power or {}
    least = -_NONE * max(map(abs, power.values()), default=0.0)
    found = kinematics.stated if kinematics.locked else [name for name, value in power.items() if value < least]
    if len(found) != 1:
        free = [name for name in ports(train) if name not in kinematics.held]
        if kinematics.torque is None:
            allowed = f"a torque of a member, or shaft = one of {', '.join(free or central(train))}, and rated"
            raise ModelError("no torque says which shaft is the output", path="operation.torque", allowed=allowed)
        what = "power leaves by several shafts" if found else "no power says which shaft is the output"
        raise ModelError(what, path="shaft", allowed=f"one of {', '.join(found or free or central(train))}")
    return found[0]


def _check_locked(train: Train, shaft: str, still: Sequence[str], held: Sequence[str]) -> None:
    """Refuse a shaft that cannot turn beside what the file holds, and held members that leave the train free."""
    before, free = motions(train.kinematics, still), motions(train.kinematics, held)
    if before and not any(motion[shaft] for motion in before.values()):
        by = ", ".join(still) or "none"
        raise ModelError(f"cannot turn: held are {by}", path="shaft", given=shaft, allowed="a shaft that turns")
    if free:
        moving = [name for name in ports(train) if any(motion[name] for motion in free.values())]
        allowed = f"also {' or '.join([name for name in moving if name != shaft] or free)}"
        raise ModelError(f"leaves {shaft} free to turn", path="held", given=", ".join(held) or "none", allowed=allowed)


def _rated(train: Train, shaft: str, rated: float | None) -> tuple[float, str]:
    """Rated torque [N m] with the sign of the operation, and where it comes from.

    Raises
    ------
    ModelError : neither option, nor file, nor operation has one.
    """
    of_operation = (train.kinematics.torque or {}).get(shaft, 0.0)
    sense = -1.0 if of_operation < 0 else 1.0
    if rated is not None:
        return sense * rated, "rated"
    document: Any = train.document
    stated = at_case(read(document).model).operation.rated
    if shaft in stated:
        return sense * stated[shaft], "operation.rated"
    if not of_operation:
        allowed = f"rated, operation.rated.{shaft}, or a torque of operation"
        raise ModelError(f"{shaft} has no rated torque", path="rated", allowed=allowed)
    return of_operation, "operation"


def locked_train(train: Train, shaft: OutputShaft) -> Train:
    """The same drawing, of its load case, with the other shafts held and the rated torque at the shaft.

    Raises
    ------
    ModelError : it is refused by the model.
    """
    document: dict[str, Any] = {name: table for name, table in train.document.items() if name not in _OF_OPERATION}
    case = value_at(train.document, ("cases", str(train.document.get("case") or ""))) or {}
    both = [value_at(train.document, ("operation",)) or {}, case]
    operation = {name: table[name] for table in both for name in _KEPT if name in table}
    loads = {**(train.document.get("loads") or {}), **(case.get("loads") or {})}  # type: ignore[dict-item]
    locked = {"held": list(shaft.held), "torque": {shaft.name: shaft.torque}}
    stated: dict[str, Any] = value_at(train.document, ("tolerance",)) or {}
    drawn = {path: entry for path, entry in stated.items() if not path.startswith(_NOT_DRAWN)}
    return load({**document, "operation": {**operation, **locked}, "loads": loads, "tolerance": drawn})


# Torques between the least one and the first of the even steps, and the least per least share that is read.
_FINE, _LEAST = 6, 0.25
_DIGITS = 12  # of relative torques: two that differ by rounding are one
RANGE = (0.5, 1.0)
"""Torques per rated torque between which secant and least squares are taken."""
_STILL = 1e-12  # turning per unit of the shaft's coordinate that is none


class Loop(NamedTuple):
    """Torque over angle at P places of the mesh cycle.

    torque : (m,) rising from -rated to rated, without zero [N m].  rising, falling : (P, m) angle [rad].
    energy : (P,) of a cycle [J].  play : free travel of the shaft [rad]; nan where no backlash is known.
    """

    torque: Array
    rising: Array
    falling: Array
    energy: Array
    play: float

    @property
    def middle(self) -> Array:
        """Middle line of both branches (P, m) [rad]."""
        return np.asarray((self.rising + self.falling) / 2)

    def lost_motion(self, share: float) -> Array:
        """Angle at a share of the rated torque less that at its negative, on the middle line, (P,) [rad].

        nan where no backlash is known: senses then have zeros of their own.
        """
        ends = share * self.torque[-1] * np.array([-1.0, 1.0])
        return np.array([np.diff(np.interp(ends, self.torque, line))[0] for line in self.middle]) + 0.0 * self.play

    def stiffness(self, low: float, high: float, sense: float) -> tuple[Array, Array]:
        """Secant and least squares between two shares of the rated torque, both solved, in one sense (P,) [N m/rad]."""
        share = sense * self.torque / self.torque[-1]
        inside = (share >= low * (1 - _STILL)) & (share <= high * (1 + _STILL))
        torque, angle = self.torque[inside], self.middle[:, inside]
        secant = np.ptp(torque) / (angle[:, -1] - angle[:, 0])
        return secant, np.asarray(1 / np.polynomial.polynomial.polyfit(torque, angle.T, 1)[1])

    def tangent(self) -> Array:
        """Stiffness dT/dphi of the middle line at every torque, by differences on its own side of zero (P, m)."""
        half = self.torque.size // 2
        sides = (slice(0, half), slice(half, None))
        slopes = [np.gradient(self.middle[:, side], self.torque[side], axis=1) for side in sides]
        return np.asarray(1 / np.concatenate(slopes, axis=1))


def relative_torques(points: int, shares: Sequence[float]) -> Array:
    """Torques per rated torque, rising to 1: even steps, shares at which angles are read, and fine ones below."""
    even = np.arange(1, points + 1) / points
    fine = np.geomspace(_LEAST * min(shares), even[0], _FINE)
    return np.unique(np.round(np.concatenate([fine, even, shares, [0.5]]), _DIGITS))


def hysteresis(system: System, reverse: System | None, phases: int, relative: Array) -> Loop:
    """Torque over angle of a locked train whose one loaded shaft takes a cycle of its torque.

    Parameters
    ----------
    system : with the rated torque at its shaft.  reverse : with its negative, where a mesh has no backlash and so no
        far flank: angles then count from first touch in each sense.  phases : P places.
    relative : (k,) torques per rated torque, as of `relative_torques`.

    Raises
    ------
    ModelError : the shaft cannot turn; a load that nothing holds; a law with a memory beside a mesh without backlash.
    ConvergenceError : no equilibrium.
    """

    def at(train: System, torque: Array) -> Loop:
        return loop_at(held_train(train), excitation(train, Fraction(1), np.arange(phases), phases), torque)

    size = abs(rated_of(system)) * relative
    if reverse is None:
        return at(system, both_senses(size))
    if system.laws.memory.any():
        pair = system.meshes.pair[int(np.argmax(np.isinf(system.meshes.backlash)))]
        allowed = "a length; friction with a history goes through both flanks"
        raise ModelError("is missing", path=f"{pair}.backlash", allowed=allowed)
    back, ahead = (reverse, system) if rated_of(system) > 0 else (system, reverse)
    low, high = at(back, -size[::-1]), at(ahead, size)
    angle = np.concatenate([low.rising, high.rising], axis=1)
    return Loop(torque=both_senses(size), rising=angle, falling=angle, energy=low.energy, play=np.nan)


def loop_at(held: HeldTrain, here: RecordExcitation, torque: Array) -> Loop:
    """Torque over angle at P instants whose excitation has the rated torque, at torques (m,) [N m]; errors as above."""
    shaft = _shaft_turn(held.system)
    base = here._replace(force=here.force - rated_of(held.system) * shaft)
    balanced(held, base.force + torque[-1] * shaft)
    solve = _with_memory if held.laws.memory.any() else _each_by_itself
    displacement, energy = solve(held, base, shaft, torque)
    angle, play = (displacement @ shaft).swapaxes(1, 2), np.nan
    if np.isfinite(held.system.meshes.backlash).all():
        ahead, back = ends_of_travel(held, shaft[None])[0]
        angle, play = angle - (ahead + back) / 2, ahead - back
    return Loop(torque=torque, rising=angle[-1], falling=angle[0], energy=energy, play=play)


def both_senses(size: Array) -> Array:
    """Torques of both senses, rising, of sizes (k,)."""
    return np.concatenate([-size[::-1], size])


def rated_of(system: System) -> float:
    """Torque at the loaded shaft [N m]."""
    return float(sum((system.locked or {}).values()))


def _shaft_turn(system: System) -> Array:
    """Angle of the loaded shaft per displacement, (n,): also the force of a unit torque on it.

    Raises
    ------
    ModelError : it cannot turn.
    """
    torque = np.array([(system.locked or {}).get(name, 0.0) for name in system.dofs.bodies])
    turn: Array = torque / torque.sum() @ system.dofs.rigid[5::6]
    if not np.abs(turn).max() > _STILL:
        raise ModelError(
            "cannot turn: it is rigid with what is held", path="shaft", given=", ".join(system.locked or ())
        )
    return turn


def _each_by_itself(held: HeldTrain, base: RecordExcitation, shaft: Array, grid: Array) -> tuple[Array, Array]:
    """Displacements (1, m, P, n) of both branches, which are one, and no energy (P,)."""
    phases = len(base.force)
    here = base.at(np.tile(np.arange(phases), grid.size))
    state = settled(held, here._replace(force=here.force + np.repeat(grid, phases)[:, None] * shaft))
    return state.displacement.reshape(1, grid.size, phases, -1), np.zeros(phases)


def _with_memory(held: HeldTrain, base: RecordExcitation, shaft: Array, grid: Array) -> tuple[Array, Array]:
    """Displacements (2, m, P, n) of the falling and the rising branch, and what the sliders dissipate (P,) [J]."""
    laws, half = held.laws, grid.size // 2
    slider, start = np.zeros((len(base.force), laws.rows.owner.size)), None
    friction = np.where(laws.memory, laws.friction, 0.0)
    displacement, work = list[Array](), list[Array]()
    for torque in np.concatenate([grid[half:], grid[-2::-1], grid[1:]]):
        state = settled(held, base._replace(force=base.force + torque * shaft), anchor=slider, start=start)
        after = laws.slide(state.group_stretch, slider)
        displacement.append(state.displacement)
        work.append(laws.rows.size(after - slider) @ friction)
        slider, start = after, state.approach
    end = half - 1 + grid.size  # of the falling branch, the first of the rising one
    return np.array([displacement[half - 1 : end][::-1], displacement[end - 1 :]]), np.sum(work[half:], axis=0)


# Instants per cycle of the fastest mesh or line, the most of a record, and part of the displacements that is rounding.
_SAMPLES, _MOST, _ROUNDING = 12, 2**14, 1e-9


def kinematic_error(train: Train, shaft: OutputShaft, share: float) -> tuple[Columns, list[CodedText]]:
    """Columns of the kinematic error of a shaft under a share of its rated torque, and warnings of a record cut short.

    Raises
    ------
    ModelError : no speed or torque of the shaft, it is what drives; a load that nothing holds.
    ConvergenceError : no equilibrium.
    """
    system, record, error, rounding = _turned(train, shaft, share, _MOST)
    said = list[CodedText]()
    if record.count < record.period and np.ptp(error) > rounding:
        text = f"kinematic error over {record.count} {record.name}, the {record.period_name} has {record.period}"
        said.append(coded("short-record", f"{text}: phases that are not met may add to its range"))
    frequency, amplitude = _lines(system, record, error, rounding)
    return {
        "kinematic_error": ("shaft_turn", error),
        "kinematic_error_peak_to_peak": ((), _range(system, shaft.name, record, error)),
        "kinematic_error_order": ("shaft_order", amplitude),
        "shaft_turn": ("shaft_turn", np.arange(error.size) / record.samples),
        "shaft_order": ("shaft_order", np.array([float(one / record.unit) for one in frequency])),
        "shaft_order_cause": ("shaft_order", np.array([line_label(system, one) for one in frequency], dtype=object)),
    }, said


def _turned(train: Train, shaft: OutputShaft, share: float, most: int) -> tuple[System, Record, Array, float]:
    """The train as it turns slowly, the record, the error over it (T,) [rad] and amplitude that is rounding.

    most : instants of the record, unless a turn has more.
    """
    kinematics = train.kinematics
    torque = (kinematics.torque or {}).get(shaft.name, 0.0)
    if not (torque and (kinematics.speed or {}).get(shaft.name)):
        raise ModelError(f"no speed and torque of {shaft.name} in operation")
    factor = abs(share * shaft.torque / torque)
    torques = {name: factor * value for name, value in train.torques.items()}
    system = assemble(replace(train, torques=torques, ripples=()))  # it turns slowly and evenly
    row = next((i for i, name in enumerate(system.errors.shaft) if name.startswith(f"{shaft.name} by ")), None)
    if row is None:
        raise ModelError(f"{shaft.name} is what drives")
    column = system.errors.B[:, 2 * len(system.errors.mesh) + row]
    record = _record(system, bodies_named(shaft.name, train.bodies)[0].name, most)
    displacement = np.concatenate([piece.state.displacement for piece in quasi_static(held_train(system), record)])
    rounding = _ROUNDING * float(np.abs(displacement).max(axis=0) @ np.abs(column))
    return system, record, -(displacement - displacement.mean(axis=0)) @ column, rounding


def _record(system: System, body: str, most: int) -> Record:
    """The common period of all lines in turns of a body, as far as it goes."""
    turn = abs(system.body_turns[system.dofs.bodies.index(body)])
    fastest = max([*system.tones, *(line.frequency for line in system.lines)], default=0)
    if not fastest:
        raise ModelError("members turn as one, and no deviation turns against another")
    samples = math.ceil(_SAMPLES * fastest / turn)  # whole mesh cycles: what is too fast for them stays a mesh order
    return record_of(system, cycles=None, turns=None, of=body, samples=samples, most=max(most, samples))


def _range(system: System, shaft: str, record: Record, error: Array) -> float:
    """Largest range within a turn of a shaft of an error (T,) [rad] over a record."""
    part = "" if record.count % record.period == 0 else "record"
    return float(error_ranges(system, error[None], record.count / record.unit, part)[f"turn of {shaft}"][0])


def _lines(system: System, record: Record, error: Array, rounding: float) -> tuple[list[Fraction], Array]:
    """Exact frequencies (F,) of the lines of an error (T,) [rad] over a record, and amplitudes by least squares.

    Of a record that is cut short the lines lie between the steps of its spectrum; what no line explains stays at them.
    """
    length, frequencies, rest = record.count / record.unit, list[Fraction](), error
    coefficients = np.zeros(0, complex)
    for _ in range(2):  # lines that the leakage of larger ones hides are seen in what these leave
        size = np.abs(np.fft.rfft(rest)) * (2 / error.size)
        steps = largest_lines(np.where(size > rounding, size, 0.0)[None]).tolist()
        found = [one for step in steps for one in near_lines(system, step / length, 1 / (2 * length))]
        frequencies = sorted({*frequencies, *found})
        turns = [turn_fraction(one / record.unit / record.samples, record.index) for one in frequencies]
        waves = np.exp(2j * np.pi * np.array(turns).reshape(len(turns), error.size).T)
        fitted = np.linalg.lstsq(np.hstack([waves.real, -waves.imag]), error, rcond=None)[0]
        coefficients = fitted[: len(turns)] + 1j * fitted[len(turns) :]
        rest = error - (waves @ coefficients).real
    amplitude = np.abs(coefficients) * (np.array(frequencies) > 0)  # the mean of a part of the period is no order
    kept = largest_lines(np.where(amplitude > rounding, amplitude, 0.0)[None])
    return [frequencies[place] for place in kept], amplitude[kept]


_AT_ONCE = 512  # trains whose torques are solved at once
_TURNING, _INSTANTS = 64, 2**11  # trains that turn, and instants of each unless a turn has more
PROBABILITIES = (0.5, 0.95, 0.99)
"""Of the quantiles of a distribution."""
STATISTICS = ("mean", "least", "most")
"""Over the places of the mesh cycle at which a train may be locked."""


def output(train: Train, options: OutputOptions, *, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """What a user of a gearbox measures at one of its shafts.

    Friction of the teeth is not in the loop.

    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : angle_rising, angle_falling (mesh_phase, shaft_torque) [rad]; shaft_tangent_stiffness (over_phases,
        shaft_torque), shaft_secant_stiffness, shaft_fitted_stiffness (over_phases) [N m/rad]; lost_motion,
        shaft_backlash (over_phases) [rad], nan where a mesh has no backlash; hysteresis_energy (over_phases) [J];
        rated_torque [N m] and shaft_play [rad] (); reflected_inertia [kg m^2] and starting_torque [N m] (port).  Of a
        drawing with tolerances NAME_mean () and NAME_quantile (probability) of lost_motion, shaft_backlash,
        shaft_secant_stiffness and the range of kinematic_error, this of 64 trains over a turn or some; of a train that
        turns kinematic_error (shaft_turn), kinematic_error_peak_to_peak (), kinematic_error_order (shaft_order) [rad].
        Attributes ``shaft``, ``locked_shafts``.

    Raises
    ------
    ModelError : as of `output_shaft`; a load that nothing holds; shares of which that of the backlash is the larger.
    ConvergenceError : no equilibrium.
    """
    shares = (options.share, options.backlash_share)
    if options.backlash_share >= options.share:
        allowed = f"below share, {options.share:g}"
        raise ModelError("out of range", path="backlash_share", given=options.backlash_share, allowed=allowed)
    shaft = output_shaft(train, options.shaft, options.held, options.rated)
    locked = locked_train(train, shaft)
    system, shafts = assemble(locked), list(dict.fromkeys([shaft.name, *ports(train)]))
    endless = bool(np.isinf(system.meshes.backlash).any())
    reverse = assemble(locked_train(train, replace(shaft, torque=-shaft.torque))) if endless else None
    tell = progress or (lambda _: None)
    loop = hysteresis(system, reverse, options.phases, relative_torques(options.points, shares))
    columns = _loop_columns(loop, options, np.sign(shaft.torque))
    warnings = [*system.warnings, *zero_warnings(system)]
    tell(0.3)
    turning = attempt(lambda share: kinematic_error(train, shaft, share), options.share)
    turned, cut_short = turning.value or ({}, [])
    drawn = dict[str, Array]()
    if locked.document.get("tolerance") and not endless:
        values, said = sampled_loops(locked, shares, options.samples, options.seed)
        names = ("lost_motion", "shaft_backlash", "shaft_secant_stiffness")
        drawn, warnings = dict(zip(names, values.T, strict=True)), [*warnings, *said]
    if locked.document.get("tolerance") and turned:
        drawn["kinematic_error"] = sampled_kinematic_error(train, shaft, options.share, options.seed)
    tell(0.95)
    for name, values in drawn.items():
        columns[f"{name}_mean"] = ((), np.nanmean(values))
        columns[f"{name}_quantile"] = ("probability", np.nanquantile(values, PROBABILITIES))
        if failed := int(np.isnan(values).sum()):
            text = f"{failed} of {values.size} trains of the tolerances have no equilibrium, and count nowhere"
            warnings.append(coded("points-failed", text))
    start = attempt(lambda friction: starting_torque(train, shafts, friction), options.friction)
    columns |= turned | {
        "rated_torque": ((), abs(shaft.torque)),
        "reflected_inertia": ("port", reflected_inertia(train, shafts)),
        "starting_torque": ("port", np.full(len(shafts), np.nan) if start.value is None else start.value),
    }
    return dataset(
        columns,
        {"over_phases": list(STATISTICS), "port": shafts, "probability": list(PROBABILITIES)},
        verb="output",
        options=asdict(options),
        provenance={
            **train_provenance(train),
            "shaft": shaft.name,
            "locked_shafts": ", ".join(shaft.held),
            "rated_by": shaft.rated_by,
            "rated_sense": "negative" if shaft.torque < 0 else "positive",
            "starting_torque_reason": start.reason,
            "kinematic_error_reason": turning.reason,
        },
        warnings=list(dict.fromkeys([*warnings, *cut_short])),
    )


def _loop_columns(loop: Loop, options: OutputOptions, sense: float) -> Columns:
    """Columns of torque over angle; sense : of the rated torque."""
    secant, fitted = loop.stiffness(*RANGE, sense)
    each = {
        "shaft_secant_stiffness": secant,
        "shaft_fitted_stiffness": fitted,
        "lost_motion": loop.lost_motion(options.share),
        "shaft_backlash": loop.lost_motion(options.backlash_share),
        "hysteresis_energy": loop.energy,
    }
    curve = ("mesh_phase", "shaft_torque")
    return {
        "shaft_torque": ("shaft_torque", loop.torque),
        "mesh_phase": ("mesh_phase", np.arange(options.phases) / options.phases),
        "angle_rising": (curve, loop.rising),
        "angle_falling": (curve, loop.falling),
        "shaft_tangent_stiffness": (("over_phases", "shaft_torque"), over_phases(loop.tangent())),
        **{name: ("over_phases", over_phases(values)) for name, values in each.items()},
        "shaft_play": ((), loop.play),
    }


def over_phases(values: Array) -> Array:
    """Mean, least and most (3, ...) of values (P, ...)."""
    return np.stack([values.mean(axis=0), values.min(axis=0), values.max(axis=0)])


# --- many trains of one drawing ---------------------------------------------------------------------------------------


def sampled_loops(
    train: Train, shares: Sequence[float], samples: int, seed: int
) -> tuple[Array, tuple[CodedText, ...]]:
    """Lost motion at shares of the rated torque [rad] and secant stiffness [N m/rad] of S locked trains, (S, k + 1).

    With them warnings.  nan of one without equilibrium.  At mean mesh stiffness; stiffnesses of links stay at their
    mean.

    train : locked, with the rated torque at the shaft.  shares : (k,).
    samples : at least so many, a power of two.

    Raises
    ------
    ModelError : a tolerance that is refused.
    """
    drawn = tolerance_map(train, laws=True)
    assert drawn.laws is not None
    held, plan = drawn.laws.held, sampling_plan(samples, seed=seed)
    system, d = held.system, drawn.dimension_entry.size
    u = all_uniforms(plan, d)
    factors, varied = drawn.factors(u, np.ones(len(drawn.entries)).tolist())
    values, _ = drawn.laws.excitation.values(factors)
    stiffness = np.tile(system.meshes.stiffness, (len(u), 1))
    of_mesh = drawn.rows < stiffness.shape[1]
    stiffness[:, drawn.rows[of_mesh]] = varied[:, of_mesh]
    here = excitation_of(system, values, np.zeros((len(u), max(1, len(system.tones)))), stiffness=stiffness)
    torque, sense = both_senses(abs(rated_of(system)) * np.unique([*shares, *RANGE])), np.sign(rated_of(system))
    own = drawn.own_trains(u, drawn.laws, np.ones(len(drawn.entries)).tolist())
    pieces = np.array_split(np.arange(len(u)), len(u) if own else -(-len(u) // _AT_ONCE))

    def loops(at: NDArray[np.int64]) -> Loop:
        """Loops of samples; of one by itself where each has laws of its own."""
        train = own(int(at[0])) if own else held
        if train is None:
            raise ModelError("clearances that are drawn are not allowed", path="tolerance")
        return loop_at(train, here.at(at), torque)

    def lost(piece: NDArray[np.int64]) -> Array:
        """Numbers of a piece; a sample without equilibrium does not stop the others."""
        found = attempt(loops, piece)
        if found.value is not None or piece.size == 1:
            if (loop := found.value) is None:
                return np.full((1, len(shares) + 1), np.nan)
            return np.array([*(loop.lost_motion(share) for share in shares), loop.stiffness(*RANGE, sense)[0]]).T
        return np.concatenate([lost(half) for half in np.array_split(piece, 2)])

    return np.concatenate([lost(piece) for piece in pieces]), drawn.warnings


def sampled_kinematic_error(train: Train, shaft: OutputShaft, share: float, seed: int) -> Array:
    """Largest range within a turn of the kinematic error of 64 trains (S,) [rad]; nan of one without equilibrium.

    Raises
    ------
    ModelError : a tolerance that is refused.
    """
    drawn, plan = tolerance_map(train), sampling_plan(_TURNING, seed=seed)
    u = all_uniforms(plan, drawn.dimension_entry.size)[:_TURNING]
    return np.array(each(partial(_error_of_one, train, shaft, share), [drawn.overrides(row) for row in u]))


def _error_of_one(train: Train, shaft: OutputShaft, share: float, overrides: dict[str, object]) -> float:
    """Range of the kinematic error of the train that overrides make [rad]."""
    found = attempt(lambda one: _turned(one, shaft, share, _INSTANTS), load(dict(train.document), overrides=overrides))
    return np.nan if found.value is None else _range(found.value[0], shaft.name, *found.value[1:3])


# --- shafts of a train that turns -------------------------------------------------------------------------------------


def reflected_inertia(train: Train, shafts: Sequence[str]) -> Array:
    """Inertia of the whole train on each shaft (s,) [kg m^2], nan of one that stands, and where the motion is open.

    The motion is that of the operation; without speeds that of a train with one freedom.
    """
    speed = _speeds(train)
    twice = math.fsum(_inertia_times_square(train, speed)) if speed else math.nan
    return np.array([twice / speed[name] ** 2 if speed.get(name) else math.nan for name in shafts])


def _speeds(train: Train) -> Mapping[str, float]:
    """Speed of every member, of any size; none where nothing turns, or several freedoms have no speeds."""
    kinematics = train.kinematics
    if kinematics.speed is not None and any(kinematics.speed.values()):
        return {name: float(value) for name, value in kinematics.speed.items()}
    if len(kinematics.freedoms) != 1:
        return {}
    return {name: float(row[kinematics.freedoms[0]]) for name, row in kinematics.ratio.items()}


def _inertia_times_square(train: Train, speed: Mapping[str, float]) -> Iterator[float]:
    """Twice the kinetic energy of every body, speeds in their unit."""
    member = {body.name: body.member for body in train.bodies}
    for body in train.bodies:
        if spin := speed[body.member]:
            yield body.inertia * spin**2
        if body.carried_by is not None and (orbit := speed[member[body.carried_by]]):
            radius = math.dist(body.centre, stage_axis(body.frame, train.bodies))
            yield body.mass * (radius * orbit) ** 2


def starting_torque(train: Train, shafts: Sequence[str], friction: float | None) -> Array:
    """Torque at each shaft (s,) that overcomes the friction of the teeth at the operation [N m]; nan of one at rest.

    It is the loss that `efficiency` finds per speed of the shaft.  friction : coefficient.

    Raises
    ------
    ModelError : no friction; a train of which `efficiency` has no loss.
    """
    if friction is None:
        raise ModelError("no friction of the teeth is given")
    from ..flanks import EfficiencyOptions
    from ..flanks.efficiency import efficiency

    loss = float(efficiency(train, EfficiencyOptions(friction=friction)).power_loss)
    speed = np.array([abs(float((train.kinematics.speed or {})[name])) * math.tau / 60 for name in shafts])
    return np.asarray(np.divide(loss, speed, where=speed > 0, out=np.full(len(shafts), math.nan)))
