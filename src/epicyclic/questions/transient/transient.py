"""The motion of a train over time as a labelled Dataset, with the forces of flanks, meshes, links and groups."""

from __future__ import annotations

import math
from collections.abc import Hashable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ...engine.plan import MOST_NUMBERS, require_memory, require_time
from ...errors import ModelError
from ...machine_code import numba_available
from ...options import Progress
from ...statics.record import link_factor, reference_tone
from ...statics.signals import motion_signals, run_errors, sensor_labels
from ...system.gaps import groups_past_the_end, net_force, past_the_end
from ...system.system import Array, ComplexArray, System, faces
from ...warning_codes import CodedText, coded
from . import TransientOptions
from .equation import (
    Contact,
    Motion,
    fastest_mode,
    from_modal,
    per_instant,
    phase_at,
    phases_at,
    speed_at,
    tangent_series,
    to_modal,
)
from .integrators import (
    APART,
    FAR,
    IMPACTS,
    LEAST,
    LEAST_AT,
    MOST,
    MOST_AT,
    acceleration,
    at_equilibrium,
    at_rest,
    instant_terms,
    starting_slider,
    steps_for,
)
from .scenario import Method, RunPlan, RunRecord, Scenario, run, scenario_motion

if TYPE_CHECKING:
    import xarray as xr

Start = Literal["equilibrium", "rest"]

_CYCLES = 100
# Time of a Runge-Kutta step of one coordinate, as measured on trains of 30 [s], and how many times that it takes
# without compiled steps.
_STEP_TIME, _SLOWER = 3e-7, 30.0
# Longest run [s]: one with a folder can be stopped and resumed, and a longer one is a slip in a speed or a time; one
# without a folder is lost when it is stopped, and a longer one is mostly a slip in a mass or a stiffness.
_RESUMED, _LONGEST = 30 * 86_400.0, 3600.0
# Instants whose forces are worked out at a time: a table of a law holds two numbers a row, load and instant.
_BLOCK = 1024
# Last part of a run, over which its links have a mean.
_LAST = 0.2


# --- forces from states ----------------------------------------------------------------------------------------------


def mesh_force(moving: Motion, times: Array, states: Array) -> Array:
    """Force of every mesh row, (m, T) [N]: on the loaded flank positive, on the far one negative.

    Parameters
    ----------
    times : (T,) [s].  states : (T, 2, n) q [m, rad], q' [m/s, rad/s] as `integrate` returns them.
    """
    return mesh_total(moving, flank_force(moving, times, states))


def mesh_total(moving: Motion, force: Array) -> Array:
    """Force of every mesh row (m, T) [N], far flanks counted against loaded ones, from those of all flanks (F, T)."""
    return net_force(force.T, moving.flanks.mesh[len(moving.system.meshes.name) :]).T


def flank_force(moving: Motion, times: Array, states: Array) -> Array:
    """Force of every flank, loaded ones first, (F, T) [N]; times (T,) [s], states (T, 2, n)."""
    parts = [_pressed(moving, times[i : i + _BLOCK], states[i : i + _BLOCK]) for i in range(0, len(times), _BLOCK)]
    return np.concatenate([np.zeros((0, moving.numbers.drag.size)), *parts]).T


def _pressed(moving: Motion, times: Array, states: Array) -> Array:
    """Force of every flank (T, F) [N]."""
    N = moving.numbers
    F, speed, tau = N.drag.size, speed_at(moving.program, times), phase_at(moving.program, times)
    error, rate = _line_sum(N.gap_at, N.gap[0, :, :F] + 1j * N.gap[1, :, :F], speed, tau)
    moves = per_instant(states, moving.rows[:, :F])
    gap, laws = moves[:, 0] - error - N.opening, moving.flanks.at(phases_at(moving, tau))
    if N.pull:
        force, pressed = tangent_series(moving, tau) * gap, np.ones_like(gap, dtype=bool)
    else:
        force, pressed = laws.evaluate(gap)[0], gap > laws.touch
    if N.drag.any():
        force += np.where(pressed, N.drag * (moves[:, 1] - rate), 0.0)
    return force


def _line_sum(frequency: Array, amplitude: ComplexArray, speed: Array, tau: Array) -> tuple[Array, Array]:
    """Re sum a exp(2 pi i f tau) and its rate, (T, rows), for amplitudes a (J, rows) at frequencies (J,) [Hz]."""
    wave = np.exp(2j * np.pi * np.multiply.outer(tau, frequency))
    both = np.stack([wave, 2j * np.pi * frequency * speed[:, None] * wave], axis=1)
    sums = np.real(per_instant(both, amplitude))
    return sums[:, 0], sums[:, 1]


def link_force(moving: Motion, times: Array, states: Array) -> Array:
    """Force k (B^T q - e) + c d/dt(...) + s skew B^T q + preload of every linear link row, (p, T) [N, N m]."""
    links, lines = moving.system.links, moving.system.lines
    frequency = np.array([float(line.frequency) for line in lines])
    error = np.array([line.link_gap for line in lines], complex).reshape(len(lines), len(links.name))
    speed, tau = speed_at(moving.program, times), phase_at(moving.program, times)
    e, rate = _line_sum(frequency, error, speed, tau)
    moves = per_instant(states, links.B)
    force: Array = links.stiffness * (moves[:, 0] - e) + links.damping * (moves[:, 1] - rate)
    if links.skew.size:
        force += speed[:, None] * per_instant(moves, links.skew.T)[:, 0]
    if links.preload.size:
        force += links.preload
    return force.T


def group_stretch(moving: Motion, times: Array, states: Array) -> Array:
    """Stretch less error of every row of the groups, (T, R) [m]."""
    N, F = moving.numbers, moving.numbers.drag.size
    speed, tau = speed_at(moving.program, times), phase_at(moving.program, times)
    error, _ = _line_sum(N.gap_at, N.gap[0, :, F:] + 1j * N.gap[1, :, F:], speed, tau)
    return per_instant(states, moving.rows[:, F:])[:, 0] - error


def group_force(moving: Motion, times: Array, states: Array, sliders: Array) -> Array:
    """Size of the force of every group, its dampers left out, (G, T) [N].

    Parameters
    ----------
    sliders : (T, R) of Coulomb friction [m], no columns without a memory.
    """
    force = moving.laws.force(group_stretch(moving, times, states), sliders if sliders.size else None)
    return moving.laws.rows.size(force).T


def sensor_signal(moving: Motion, times: Array, modal: Array, sliders: Array, mesh: Array, link: Array) -> Array:
    """Signals of the sensors (s, T); their accelerations are those of the equation of motion at each instant.

    Parameters
    ----------
    modal : (T, 2, n).  sliders : (T, R) [m].  mesh : (m, T) of mesh rows [N].  link : (p, T) of link rows [N, N m].
    """
    sensors, program = moving.system.sensors, moving.program
    states, rate = from_modal(moving, modal), np.zeros(len(times))
    if "acceleration" in sensors.kind:
        second = np.empty_like(modal[:, 0])
        for i, (t, (y, v), slider) in enumerate(zip(times.tolist(), modal, sliders, strict=True)):
            at = instant_terms(moving, t, t)
            second[i], rate[i] = acceleration(moving, at, y, v, slider if slider.size else None), at.rise
        states = np.concatenate([states, from_modal(moving, second[:, None])], axis=1)
    phase = np.outer([float(turn) for turn in sensors.turn], phase_at(program, times))
    own = sensors.mesh @ mesh + sensors.link_weights(len(link)) @ link
    return own + motion_signals(sensors, phase, states, speed_at(program, times), rate)


# --- the run ---------------------------------------------------------------------------------------------------------


def transient(system: System, options: TransientOptions, *, progress: Progress | None = None) -> xr.Dataset:
    """Mesh forces and displacements over time, from any start, through ramps of speed and torque; teeth may part.

    The speed is prescribed, and the coordinates are small motions about it.  All phases are counted in the angle
    turned, so that meshes and shafts stay in step while the speed changes; inertia of the nominal motion, Euler and
    Coriolis terms included.  Torques stay in balance: see `scenario.scenario_motion`.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : an option out of range, no mesh frequency, torques out of balance, a result too large.
    ConvergenceError : no equilibrium to start from.
    """
    tone = float(reference_tone(system)) if system.tones and len(system.meshes.tone) else 0.0
    if tone <= 0:
        problem = "motion in time needs a mesh frequency above zero"
        raise ModelError(problem, path="operation.speed", allowed="the speed of one member")
    start, history = options.initial, options.history
    contact, method, samples, decimate = options.contact, options.method, options.samples, options.decimate
    end: Any = start if hasattr(start, "attrs") else None
    speed = _speeds(options.mesh_frequency, tone)
    system.require_scaling(np.array(speed))
    scenario = Scenario(
        duration=_duration(options, speed, tone),
        speed=speed,
        ramp=options.torque_ramp or 0.0,
        step=options.torque_step,
        history=history,
        phase=float(end["end_phase"]) if end is not None and "end_phase" in end else 0.0,
    )
    if sum(given is not None for given in (options.torque_ramp, options.torque_step, history)) > 1:
        raise ModelError("give one of torque_ramp, torque_step and history", path="torque")
    fine = 1.0 / (samples * tone * max(speed))
    moving, plan = _planned(system, scenario, contact, method, fine, decimate)
    _check_time(moving, plan, most=_LONGEST if options.folder is None else _RESUMED)
    state = to_modal(moving, _state(moving, start))
    record = run(
        moving,
        plan,
        state,
        starting_slider(moving, state, slider=None if end is None else _end_slider(moving, end)),
        folder=None if options.folder is None else Path(options.folder),
        asked={**_asked(scenario, start), "contact": contact, "samples": samples, "decimate": decimate},
        resume=options.resume,
        progress=progress,
    )
    recorded: dict[str, Any] = {
        "duration": scenario.duration, "mesh_frequency": [value * tone for value in speed], "contact": contact,
        "method": method, "samples": samples, "decimate": decimate, "step": record.plan.step,
        "start": start if isinstance(start, str) else "state",
        **({"torque_ramp": options.torque_ramp} if options.torque_ramp else {}),
        **({"torque_step": list(options.torque_step)} if options.torque_step else {}),
        **({"history": list(history.torque)} if history else {}),
    }  # fmt: skip
    return _labelled(record, tone, recorded)


def _asked(scenario: Scenario, start: Any) -> dict[str, object]:
    """Scenario and start as they were asked for, of numbers that no rounding of the model has touched."""
    asked: dict[str, object] = {
        "duration": scenario.duration, "speed": scenario.speed, "ramp": scenario.ramp, "step": scenario.step,
        "phase": scenario.phase,
    }  # fmt: skip
    if scenario.history is not None:
        asked["time"] = np.asarray(scenario.history.time, dtype=float)
        asked |= {f"torque {name}": np.asarray(v, dtype=float) for name, v in scenario.history.torque.items()}
    if isinstance(start, str):
        asked["start"] = start
    elif hasattr(start, "attrs"):
        names = [name for name in ("end_displacement", "end_velocity", "end_slider") if name in start]
        asked |= {f"start {name}": np.asarray(start[name].values) for name in names}
    else:
        asked["start"] = np.asarray(start, dtype=float)
    return asked


def _speeds(mesh_frequency: float | tuple[float, float] | None, tone: float) -> tuple[float, float]:
    """Relative speeds [1] at the beginning and at the end.

    Raises
    ------
    ModelError : not one or two frequencies from 0 Hz.
    """
    ends = np.atleast_1d(np.asarray(tone if mesh_frequency is None else mesh_frequency, dtype=float))
    if ends.size not in (1, 2) or not (np.all(np.isfinite(ends)) and np.all(ends >= 0) and np.any(ends > 0)):
        raise ModelError(
            "out of range", path="mesh_frequency", given=str(mesh_frequency), allowed="one or two frequencies from 0 Hz"
        )
    return float(ends[0] / tone), float(ends[-1] / tone)


def _duration(options: TransientOptions, speed: tuple[float, float], tone: float) -> float:
    """Length of the run [s]; mesh cycles are counted at the mean speed."""
    duration, cycles, history = options.duration, options.cycles, options.history
    if duration is not None and cycles is not None:
        raise ModelError("give duration or cycles, not both", path="duration")
    if duration is None and cycles is None and history is not None:
        duration = float(history.time[-1])
    length = (_CYCLES if cycles is None else cycles) / (tone * sum(speed) / 2) if duration is None else duration
    if not (math.isfinite(length) and length > 0):
        raise ModelError("out of range", path="duration", given=length, allowed="a time above zero")
    return length


def _planned(
    system: System, scenario: Scenario, contact: Contact, method: Method, fine: float, decimate: int
) -> tuple[Motion, RunPlan]:
    """The motion and the plan of its run; samples every `fine` seconds or less, every `decimate`-th kept."""
    width = len(faces(system.meshes).name) + 3 * len(system.force) + len(system.links.name) + 2
    # so many that the last one falls on the end
    instants = scenario.duration / fine
    if decimate > max(1.0, instants):
        raise ModelError(
            f"keeps none of {instants:.0f} instants but the ends", path="decimate", given=decimate,
            allowed=f"1 to {max(1.0, instants):.0f}",
        )  # fmt: skip
    count = max(1, math.ceil(scenario.duration / (fine * decimate) * (1 - 1e-12)))
    fine = scenario.duration / (count * decimate)
    require_memory(
        (count + 1) * width,
        path="decimate",
        given=decimate,
        allowed=f"{math.ceil(decimate * (count + 1) * width / MOST_NUMBERS)} or more, or a shorter run",
    )
    trial = scenario_motion(system, scenario, contact=contact, step=fine)
    steps = steps_for(trial, fine)
    moving = trial if scenario.step is None else scenario_motion(system, scenario, contact=contact, step=fine / steps)
    return moving, RunPlan(method=method, step=fine / steps, keep=steps * decimate, count=count)


def _check_time(moving: Motion, plan: RunPlan, *, most: float) -> None:
    """Refuse a run of more than `most` seconds; the fastest mode sets the steps, those of ``radau`` excepted.

    Raises
    ------
    ModelError : it would take longer; names the fastest mode and its bodies.
    """
    steps = plan.count * (1 if plan.method == "radau" else plan.keep)
    compiled = plan.method == "rk4" and moving.compiled and numba_available()
    frequency, bodies = fastest_mode(moving)
    length = plan.step * plan.keep * plan.count
    require_time(
        _STEP_TIME * (1.0 if compiled else _SLOWER) * steps * len(moving.system.force),
        most,
        path="duration",
        given=f"{length:g} s in {steps:.3g} steps, of the fastest mode at {frequency:.4g} Hz ({', '.join(bodies)})",
        allowed="a shorter run, fewer samples, a higher mesh frequency, or a slower mode"
        + (f"; up to {_RESUMED / 86_400:.0f} days with a folder to resume from" if most < _RESUMED else ""),
    )


def _state(moving: Motion, start: Any) -> Array:
    """The state (2, n) q [m, rad], q' [m/s, rad/s] to begin with.

    Raises
    ------
    ModelError : no such start, a result of another train, or an array that is no state.
    """
    if isinstance(start, str):
        if start not in ("equilibrium", "rest"):
            allowed = "equilibrium, rest, (2, n), a result"
            raise ModelError("no such state", path="initial", given=start, allowed=allowed)
        return at_equilibrium(moving) if start == "equilibrium" else at_rest(moving)
    dofs = moving.system.dofs
    if hasattr(start, "attrs"):
        if "end_displacement" not in start or list(map(str, start["dof"].values)) != list(dofs.names):
            raise ModelError("is not a transient of this train", path="initial", allowed="a result of `transient`")
        state = np.stack([start["end_displacement"].values, start["end_velocity"].values]) / dofs.radius
    else:
        state = np.asarray(start)
    numbers = np.can_cast(state.dtype, float, "same_kind")
    if not numbers or state.shape != (2, len(dofs.names)) or not np.isfinite(state).all():
        allowed = f"(2, {len(dofs.names)}) finite numbers"
        raise ModelError("not a state", path="initial", given=str(state.shape), allowed=allowed)
    return state.astype(float)


def _end_slider(moving: Motion, end: xr.Dataset) -> Array | None:
    """Sliders (R,) [m] where a result that is the start has left them, None where it or this train has none.

    Raises
    ------
    ModelError : another number of them.
    """
    if "end_slider" not in end or not moving.numbers.link.anchor.size:
        return None
    slider: Array = np.asarray(end["end_slider"].values, dtype=float)
    if slider.shape != moving.numbers.link.anchor.shape:
        raise ModelError(
            "has sliders of other links than this train",
            path="initial",
            given=f"{slider.size} rows",
            allowed=f"{moving.numbers.link.anchor.size} rows, or a start without them",
        )
    return slider


# --- the record ------------------------------------------------------------------------------------------------------


def _labelled(record: RunRecord, tone: float, options: dict[str, Any]) -> xr.Dataset:
    """The labelled result of a run; tone : of the first mesh at the operating speed [Hz]."""
    from ...results.dataset import dataset

    moving, plan = record.moving, record.plan
    system, face, times = moving.system, faces(moving.system.meshes), plan.times(0, plan.count)
    mesh, displacement, link, group = list[Array](), list[Array](), list[Array](), list[Array]()
    sensed = list[Array]()
    lost = record.tally.flank[: len(system.meshes.name), 1] > 0
    largest = record.tally.flank[:, 0].copy()
    for first in range(0, len(times), _BLOCK):
        block = slice(first, first + _BLOCK)
        at, states = times[block], from_modal(moving, record.states[block])
        with np.errstate(over="ignore", invalid="ignore"):
            flanks = _pressed(moving, at, states).T
            by_row = mesh_total(moving, flanks)
            mesh.append(face.total(by_row))
            lost |= (flanks[: lost.size] <= 0).any(axis=1)
            largest = np.fmax(largest, np.fmax.reduce(flanks, axis=1, initial=0.0))
            link.append(link_force(moving, at, states))
            if system.sensors.name:
                sliders = record.sliders[block]
                sensed.append(sensor_signal(moving, at, record.states[block], sliders, by_row, link[-1]))
            if system.groups:
                group.append(group_force(moving, at, states, record.sliders[block]))
        displacement.append((states[:, 0] * system.dofs.radius).T)
    speed = speed_at(moving.program, times)
    finite = np.isfinite(record.states).all(axis=(1, 2))
    end = int(np.flatnonzero(finite)[-1])
    last = from_modal(moving, record.states[end]) * system.dofs.radius
    status = "ok" if finite.all() else f"not finite after {times[end]:.6g} s"
    unilateral = options["contact"] == "unilateral"
    notes = _notes(system, face.name, face.any(lost), unilateral, status)
    notes += past_the_end(system, moving.flanks, largest) if unilateral else []
    variables: dict[str, Any] = {}
    coords: dict[Hashable, Any] = {}
    if system.groups:
        forces = np.concatenate(group, axis=1)
        notes += groups_past_the_end(system, np.fmax.reduce(forces, axis=1, initial=0.0)) if unilateral else []
        variables["group_force"] = (("group", "time"), forces)
        coords["group"] = [group.name for group in system.groups]
    if sensed:
        described, labels = sensor_labels(system.sensors)
        variables |= {**described, "sensor_signal": (("sensor", "time"), np.concatenate(sensed, axis=1))}
        coords |= labels
    if record.sliders.shape[1]:
        variables["end_slider"] = ("group_row", record.sliders[end])
        coords["group_row"] = [row for group in system.groups for row in group.rows]
    force, motion = np.concatenate(mesh, axis=1), np.concatenate(displacement, axis=1)
    errors = run_errors(system, motion / system.dofs.radius[:, None])
    tones = np.array([float(mesh_tone) for mesh_tone in system.tones])[system.meshes.tone]
    of_links = np.concatenate(link, axis=1)
    with np.errstate(over="ignore", invalid="ignore"):
        late = of_links[:, times >= times[-1] * (1 - _LAST)]
        factor = link_factor(np.abs(late).max(axis=1, initial=0.0), late.mean(axis=1))
    result = dataset(
        {
            "mesh_force": (("mesh", "time"), force),
            **_over_all_steps(record, times, force, apart=unilateral),
            "displacement": (("dof", "time"), motion),
            **errors,
            "link_force": (("link_row", "time"), of_links),
            "link_force_factor": ("link_row", factor),
            **variables,
            "relative_speed": ("time", speed),
            "contact_lost": ("mesh", face.any(lost)),
            "end_displacement": ("dof", last[0]),
            "end_velocity": ("dof", last[1]),
            "end_phase": ((), float(phase_at(moving.program, times[-1:])[0])),
            "status": ((), status),
        },
        {
            "mesh": list(face.name),
            "dof": list(system.dofs.names),
            "link_row": list(system.links.name),
            **({"shaft": list(system.errors.shaft)} if system.errors.shaft else {}),
            **coords,
            "time": times,
            "mesh_frequency": ("time", speed * tone),
            "mesh_tone": ("mesh", (tones / tones[0])[face.first]),
        },
        verb="transient",
        options=options,
        provenance=system.provenance,
        warnings=[*system.warnings, *moving.warnings, *notes],
    )
    result["time"].attrs.update({"units": "s", "long_name": "time of the samples kept"})
    return result


def _over_all_steps(record: RunRecord, times: Array, force: Array, *, apart: bool) -> dict[str, Any]:
    """Extremes of the mesh forces and what became of the contact, over all steps and the samples kept.

    Parameters
    ----------
    times : (T,) [s] and force : (w, T) [N] of the samples, of which the last one is the end of the last step.
    apart : whether teeth part.
    """
    mesh = record.tally.mesh
    least, most = mesh[:, LEAST].copy(), mesh[:, MOST].copy()
    at_least, at_most = mesh[:, LEAST_AT].copy(), mesh[:, MOST_AT].copy()
    lowest, highest = np.nan_to_num(force, nan=np.inf), np.nan_to_num(force, nan=-np.inf)
    low, high = lowest.argmin(axis=1), highest.argmax(axis=1)
    rows = np.arange(len(force))
    less, more = lowest[rows, low] < least, highest[rows, high] > most
    least[less], at_least[less] = lowest[rows, low][less], times[low][less]
    most[more], at_most[more] = highest[rows, high][more], times[high][more]
    finite = np.isfinite(record.states).all(axis=(1, 2))
    length = float(times[np.flatnonzero(finite)[-1]]) or 1.0
    contact = {
        "open_share": ("mesh", np.minimum(mesh[:, APART] / length, 1.0)),
        "far_share": ("mesh", np.minimum(mesh[:, FAR] / length, 1.0)),
        "impacts": ("mesh", mesh[:, IMPACTS].astype(np.int64)),
    }
    return {
        "mesh_force_peak": ("mesh", most),
        "mesh_force_peak_time": ("mesh", at_most),
        "mesh_force_minimum": ("mesh", least),
        "mesh_force_minimum_time": ("mesh", at_least),
        **(contact if apart else {}),
    }


def _notes(system: System, names: tuple[str, ...], lost: np.ndarray, unilateral: bool, status: str) -> list[CodedText]:
    """Warnings of a run; lost : (w,) meshes that opened or, in the linear model, pulled."""
    notes: list[CodedText] = []
    if not system.damped:
        notes.append(coded("no-damping", "nothing is damped: what a start or a step sets moving never dies away"))
    which = ", ".join(name for name, open_ in zip(names, lost, strict=True) if open_)
    pairs, backlash = system.meshes.pair, system.meshes.backlash
    endless = dict.fromkeys(pair for pair, gap in zip(pairs, backlash, strict=True) if np.isinf(gap))
    if which and not unilateral:
        notes.append(coded("tension-in-teeth", f"tensile mesh force in the linear model: {which}"))
    elif which:
        notes.append(coded("contact-lost", f"contact lost in {which}"))
        if endless:
            where = "" if len(endless) == len(set(pairs)) else f" of {', '.join(endless)}"
            text = f"no backlash{where} is given: the far flanks are taken as never touching"
            notes.append(coded("no-backlash", text))
    if status != "ok":
        text = f"the motion grows without bound, {status}: unstable at this speed, or the step is too long"
        notes.append(coded("motion-unbounded", text))
    return notes
