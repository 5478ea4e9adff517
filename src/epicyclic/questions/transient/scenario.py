"""Scenarios as programs: a speed that stays or ramps, torque that ramps, steps or follows a history, in balance.

The nominal motion is prescribed: a load may only strain the train.  The work of a load on a free (rigid) motion has to
be given back at the ports, where torque enters and leaves the train, in the ratio of the kinematics: the sum of torque
times nominal turn is zero.

A run in pieces, whose cuts do not change a bit of it: its folder keeps the numbers that it was begun with, and the
states of whole pieces.  A state is flat here: modal y, y' and the sliders of Coulomb friction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...engine.run_folder import KeptPart, run_folder
from ...errors import ModelError
from ...statics.tangent import linear
from ...system.system import Array, Index, System
from ..modes.eigen import mean_modes
from .equation import Contact, Motion, Steps, motion, program
from .integrators import Tally, adaptive_states, empty_tally, rk4_states

# Work that is rounding, per the sum of the sizes of its terms.
_ROUNDING = 1e-9
# Torques of a history that are all given must balance so far, as those of a model file.
_BALANCE = 1e-6


# --- ports -----------------------------------------------------------------------------------------------------------


class Ports(NamedTuple):
    """Coordinates with torque, and the rigid motions a load must not work on.

    system.  places : coordinates rz with a torque at the operating point.  rigid : (n, r) motions that strain nothing.
    """

    system: System
    places: Index
    rigid: Array


def ports_of(system: System) -> Ports:
    """The ports of a System: where the torques of the operating point act, (p,)."""
    squared, shapes = mean_modes(linear(system, asks_laws=True))
    turns = np.array([direction == "rz" for direction in system.dofs.direction])
    return Ports(system=system, places=np.flatnonzero(turns & (system.force != 0)), rigid=shapes[:, squared == 0])


def driving_ports(ports: Ports) -> Index:
    """The ports (p,) through which power comes in at the operating point; all where no speed is given."""
    system = ports.system
    if not system.body_turns:
        return ports.places
    turn = dict(zip(system.dofs.bodies, system.body_turns, strict=True))
    speed = np.array([float(turn.get(body, 0)) for body in system.dofs.body])
    power = (system.force * speed)[ports.places]
    return np.asarray(ports.places[power > 0])


def balancing_torque(ports: Ports, load: Array, places: Index) -> Array | None:
    """Torques (n,) [N m] at some ports that take the work of a load (n,) off every rigid motion.

    None where they cannot.
    """
    rigid = ports.rigid
    result = np.zeros_like(load)
    if not rigid.shape[1]:
        return result
    work = rigid.T @ load
    size = np.abs(rigid.T) @ np.abs(load)
    if places.size:
        result[places] = np.linalg.lstsq(rigid[places].T, -work, rcond=1e-12)[0]
    left = np.abs(work + rigid.T @ result)
    return None if np.any(left > _ROUNDING * size) else result


def member_coordinates(system: System, name: str) -> Index:
    """The rz coordinates (c,) of a member: ``sun``, ``main.sun``, ``main/sun``, or one half, ``main/sun/left``.

    Raises
    ------
    ModelError : no such member, several of that name, or it cannot turn.
    """
    wanted = name.replace(".", "/").split("/")
    places: dict[tuple[str, ...], set[int]] = {}
    members: set[str] = set()
    for place, (body, direction) in enumerate(zip(system.dofs.body, system.dofs.direction, strict=True)):
        parts = body.split("/")  # stage, member, side
        if direction == "rz" and not any(part.isdigit() for part in parts):
            members.add("/".join(parts[:2]))
            for depth in (0, 1):
                for end in range(depth + 1, len(parts) + 1):
                    if parts[depth:end] == wanted and end >= min(2, len(parts)):
                        places.setdefault(tuple(parts[:2]), set()).add(place)
    if len(places) != 1:
        raise ModelError(
            "no member of that name can turn" if not places else "several members have that name",
            path="torque",
            given=name,
            allowed=", ".join(sorted(members)),
        )
    (coordinates,) = places.values()
    return np.array(sorted(coordinates), dtype=np.int64)


def unit_torque(system: System, index: Index) -> Array:
    """One newton metre on a member, (n,) [N m].

    On its halves as the operating torque is, evenly where there is none.
    """
    load = np.zeros(len(system.force))
    total = system.force[index].sum()
    load[index] = system.force[index] / total if total else 1.0 / index.size
    return load


# --- what happens ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class History:
    """External torque of members over time, linear between the times, held before the first and after the last.

    time : (K,) rising [s].  torque : member -> (K,) [N m], the whole external torque on it.
    where : (K,) what to call each instant in messages.
    """

    time: Array
    torque: Mapping[str, Array]
    where: Sequence[str] = ()


class Scenario(NamedTuple):
    """What happens: from time 0 to `duration` [s].

    speed : relative speeds at the beginning and at the end, a straight line between them.
    ramp : time [s] in which all operating torques grow from zero; 0: they act at once.
    step : factor of all operating torques, and from when [s].  history : instead, torques of members.
    phase : integral of the relative speed before time 0 [s].
    """

    duration: float
    speed: tuple[float, float] = (1.0, 1.0)
    ramp: float = 0.0
    step: tuple[float, float] | None = None
    history: History | None = None
    phase: float = 0.0


def scenario_motion(system: System, scenario: Scenario, *, contact: Contact, step: float) -> Motion:
    """The motion of a System under a scenario.

    Torque is balanced at the ports of the operating point: a history by the members it does not give, the inertia of
    the nominal motion by the members that drive.  A jump of the torque falls on a multiple of `step` [s].

    Raises
    ------
    ModelError : a time or factor out of range, torques that cannot balance.
    """
    from scipy.integrate import trapezoid

    ports = ports_of(system)
    loads, time, level = _loads(ports, scenario, step)
    ends = np.array([0.0, scenario.duration])
    moments = np.concatenate([time, ends[(ends[:, None] != time).all(axis=1)]])
    order = np.argsort(moments, kind="stable")
    levels = np.stack([np.interp(moments, time, column) for column in level.T], axis=1) if level.size else None
    if levels is not None:
        levels[: time.size] = level  # interpolation would lose one side of a jump
        levels = levels[order]
    moments = moments[order]
    speed = np.interp(moments, ends, scenario.speed)
    early = moments <= 0
    before = float(trapezoid(speed[early], moments[early]))  # integral of the speed up to time 0 [s]
    return motion(
        system,
        program=program(moments, speed, levels, phase=scenario.phase - before),
        contact=contact,
        loads=loads,
        spin=_spin(ports, system) if scenario.speed[0] != scenario.speed[1] else None,
    )


def _spin(ports: Ports, system: System) -> Array:
    """Torques (n,) [N m s] at the ports that speed the train up by s' = 1/s.

    Raises
    ------
    ModelError : no torque at the operating point names a member that drives.
    """
    load = system.spin_up if system.spin_up.size else np.zeros(len(system.force))
    for places in (driving_ports(ports), ports.places):
        torque = balancing_torque(ports, load, places)
        if torque is not None:
            return torque
    raise ModelError(
        "a changing speed needs a torque, to know which member drives", path="operation.torque", allowed="a torque"
    )


def _loads(ports: Ports, scenario: Scenario, step: float) -> tuple[Array, Array, Array]:
    """Loads (C, n) [N m] on top of the operating torques, times (K,) [s], levels (K, C) [1].

    Raises
    ------
    ModelError : a time or factor out of range, or what `_history` raises.
    """
    if scenario.history is not None:
        return _history(ports, scenario.history)
    force = ports.system.force
    if scenario.step is not None:
        factor, begin = scenario.step
        if not (np.isfinite(factor) and 0 <= begin <= scenario.duration):
            raise ModelError(
                "the torque step is out of range",
                path="torque_step",
                given=f"{factor:g} at {begin:g} s",
                allowed=f"a factor, and a time between 0 and {scenario.duration:g} s",
            )
        at = round(begin / step) * step
        late = max(scenario.duration, at) + 1.0
        return force[None], np.array([-1.0, at, at, late]), np.array([[0.0], [0.0], [factor - 1], [factor - 1]])
    if scenario.ramp:
        if not 0 < scenario.ramp < np.inf:
            raise ModelError("out of range", path="torque_ramp", given=scenario.ramp, allowed="a time above zero")
        late = max(scenario.duration, scenario.ramp) + 1.0
        return force[None], np.array([0.0, scenario.ramp, late]), np.array([[-1.0], [0.0], [0.0]])
    return np.zeros((0, force.size)), np.array([0.0]), np.zeros((1, 0))


def _history(ports: Ports, history: History) -> tuple[Array, Array, Array]:
    """Unit loads (C, n) [N m] with their reactions, times (K,) [s] and levels (K, C) [N m per N m] of a torque history.

    Raises
    ------
    ModelError : a member in two columns, torques that do not balance, or members that cannot hold the train.
    """
    system = ports.system
    places = {name: member_coordinates(system, name) for name in history.torque}
    driven = np.concatenate(list(places.values()))
    if np.unique(driven).size < driven.size:
        raise ModelError("a member stands in two columns", path="torque", given=", ".join(places))
    units = np.array([unit_torque(system, index) for index in places.values()])
    torque = np.stack([np.asarray(values, dtype=float) for values in history.torque.values()], axis=1)
    operating = np.array([system.force[index].sum() for index in places.values()])
    free = np.setdiff1d(ports.places, driven)
    reactions = [balancing_torque(ports, unit, free) for unit in units]
    if any(reaction is None for reaction in reactions):
        _require_balance(ports, units, torque, history)
        # the least torques on the members given that balance a unit load; they cancel in torques that balance
        reactions = [balancing_torque(ports, unit, driven) for unit in units]
    held = [reaction for reaction in reactions if reaction is not None]
    if len(held) < len(units):
        raise ModelError("no torque at these members can hold the train", path="torque", allowed="members that drive")
    loads = units + np.array(held)
    time, level = np.asarray(history.time, dtype=float), torque - operating
    # held outside, on one more line each
    time = np.concatenate([[min(time[0], 0.0) - 1.0], time, [time[-1] + max(1.0, time[-1])]])
    return loads, time, np.concatenate([level[:1], level, level[-1:]])


def _require_balance(ports: Ports, units: Array, torque: Array, history: History) -> None:
    """Check that given torques (K, C) [N m] of unit loads (C, n) balance at every time, where no port is left over.

    Raises
    ------
    ModelError : they do not; names the instant.
    """
    work = torque @ (units @ ports.rigid)
    size = np.abs(torque) @ np.abs(units @ ports.rigid)
    wrong = np.flatnonzero((np.abs(work) > _BALANCE * size).any(axis=1))
    if wrong.size:
        at = int(wrong[0])
        raise ModelError(
            "the torques do not balance, and no member is left to take what is missing",
            path=history.where[at] if history.where else f"time {float(history.time[at]):g} s",
            given=", ".join(f"{name} {values[at]:g} N m" for name, values in history.torque.items()),
            allowed="torques in the ratio of the speeds, or one member fewer",
        )


Method = Literal["rk4", "dop853", "radau"]
# Steps of a piece, one sample at least, after which the run is kept and the progress bar moves: a fraction of a second.
_STEPS = 40_000
# Numbers of a piece [8 bytes].
_NUMBERS = 500_000


class Begun(NamedTuple):
    """All numbers a run depends on: equation, start (2, n) modal and sliders (R,), and lengths of its plan."""

    moving: Motion
    state: Array
    slider: Array
    step: float
    steps: NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RunPlan:
    """Samples 0 .. count of a run: sample i at i keep step [s].

    step : of fixed-step integration [s].  keep : steps from sample to sample.  count : samples after the first.
    """

    method: Method
    step: float
    keep: int
    count: int

    def times(self, first: int, last: int) -> Array:
        """Times of samples first .. last, (last - first + 1,) [s]."""
        return np.arange(first, last + 1, dtype=np.float64) * (self.keep * self.step)


class RunRecord(NamedTuple):
    """What a run has found.

    moving, plan : as they were run, from the folder where the run was taken up again.
    states : (count + 1, 2, n) modal, and sliders : (count + 1, R) [m]; nan from where the motion is no longer finite.
    tally : of all its steps.
    """

    moving: Motion
    plan: RunPlan
    states: Array
    sliders: Array
    tally: Tally


def run(
    moving: Motion,
    plan: RunPlan,
    state: Array,
    slider: Array,
    *,
    folder: Path | None = None,
    asked: Mapping[str, object] | None = None,
    resume: bool = False,
    progress: Callable[[float], None] | None = None,
) -> RunRecord:
    """A run from a modal state (2, n) and sliders (R,).

    Parameters
    ----------
    folder : keeps whole pieces there; what was done stays when the run is stopped, by whatever it is.
    asked : options that, with the System, say which run it is.
    resume : go on from the last of them.  progress : called with the share done; an exception in it ends the run.

    Raises
    ------
    ModelError : as of `run_folder`.
    """
    begun = Begun(moving=moving, state=state, slider=slider, step=plan.step, steps=np.array([plan.keep, plan.count]))
    options = {"method": plan.method, **(asked or {})}
    with run_folder(folder, begun, verb="transient", options=options, resume=resume, compared="moving.system") as (
        begun,
        kept,
    ):
        keep, count = map(int, begun.steps)
        return _run(begun, replace(plan, step=begun.step, keep=keep, count=count), kept.part("pieces"), progress)


def _run(begun: Begun, plan: RunPlan, kept: KeptPart, progress: Callable[[float], None] | None) -> RunRecord:
    """`run` from its beginning, or from the last piece that is kept."""
    tally = empty_tally(begun.moving)
    begin = np.concatenate([begun.state.ravel(), begun.slider])
    out = np.full((plan.count + 1, begin.size), np.nan)
    out[0], done = begin, 0
    # integrators of variable step begin anew at the end of a piece, wherever a run was cut
    size = max(1, min(_STEPS // plan.keep, _NUMBERS // begin.size))
    for _, (states, flat) in sorted(kept.known.items()):
        out[done + 1 : done + 1 + len(states)] = states
        done, tally = done + len(states), tally.of(flat)
    while done < plan.count and np.isfinite(out[done]).all():
        last, longer = min(plan.count, (done // size + 1) * size), tally.of(tally.flat())
        out[done + 1 : last + 1] = _piece(begun.moving, plan, out[done], done, last, longer)
        kept.add(done // size, (out[done + 1 : last + 1], longer.flat()))
        done, tally = last, longer
        if progress is not None:
            progress(done / plan.count)
    n = begun.state.shape[1]
    states, sliders = out[:, : 2 * n].reshape(-1, 2, n), out[:, 2 * n :]
    return RunRecord(moving=begun.moving, plan=plan, states=states, sliders=sliders, tally=tally)


def _piece(moving: Motion, plan: RunPlan, flat: Array, done: int, last: int, tally: Tally) -> Array:
    """Flat states (last - done, 2 n + R) of samples done + 1 .. last, from that of sample `done` (2 n + R,)."""
    n = moving.numbers.squared.size
    state, slider = flat[: 2 * n].reshape(2, n), flat[2 * n :]
    if plan.method == "rk4":
        steps = Steps(begin=0.0, step=plan.step, first=done * plan.keep, keep=plan.keep, samples=last - done)
        states, sliders = rk4_states(moving, state, slider, steps, tally)
    else:
        times = plan.times(done, last)
        states, sliders = adaptive_states(moving, state, times, slider=slider, method=plan.method, tally=tally)
    return np.concatenate([states.reshape(-1, 2 * n), sliders], axis=1)
