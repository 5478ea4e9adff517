"""Signal of an accelerometer beside the ring, as lines of exact frequency, each with its label, family and causes.

A line stands at  sum_j l_j f_j + f_shaft + k f_carrier: mesh orders, a shaft line in the axes of the stage, and the
shift by planets that pass the sensor.  With even planets that are alike only sidebands with l z + k a multiple of N
survive, z the teeth of the ring, N the planets: asymmetric about the mesh orders, which vanish themselves, where z / N
is not whole [mcfadden1985].  Uneven or unlike planets bring the others [inalpolat2009].
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...errors import ModelError
from ...statics.record import parallel_meshes
from ...statics.static import rounding_of
from ...system.system import Array, ComplexArray, Line, System, faces
from ...warning_codes import CodedText, coded
from ..response.measures import TOLERANCE, dynamic_factor, force_extremes, mean, solve_speed
from ..response.response import Block, Response
from ..response.spectra import LineExcitation, Shaft, force_signal, mesh_axis, whole_mesh_signal
from ..response.steady import tension_warnings
from . import ModulationOptions
from .spectrum import (
    ACCELERATION,
    LineSource,
    SensorLines,
    SensorPosition,
    StageSpectrum,
    Transfer,
    Window,
    merged_lines,
    mesh_stages,
    named_window,
    own_signal,
    sensor_motion,
    sensor_position,
    stage_spectrum,
    synthesised_signal,
    windowed_forces,
)

MESH, PASSING, MEAN = "mesh", "planets passing", "mean load passing"
UNEVEN, UNLIKE = "uneven planets", "unlike planets"
_MESHING = "tooth meshing"
_FAULT_FREE = "fault-free: planets passing"
_UNEVEN_CAUSE = "fault-free asymmetry: planet angles, mesh phases"
# Highest number of samples of the signal: 2^20 doubles are 8 MB.
_MAX_SAMPLES = 2**20
_FEWEST = 2048
# Deviations count as the cause of a line that changes by more than this share without them.
_REPORTED = 0.5


# --- labels of lines -------------------------------------------------------------------------------------------------


class Origin(NamedTuple):
    """Frequency = sum_j mesh_j f_j + sign f_shaft + carrier |f_carrier|.  shaft : its index, -1 without."""

    mesh: tuple[int, ...]
    shaft: int
    sign: int
    carrier: int


@dataclass(frozen=True, kw_only=True)
class LineLabels:
    """Labels of the lines of one System at one sensor position."""

    system: System
    lines: LineExcitation
    position: SensorPosition

    @property
    def own(self) -> int:
        """Axis of the tone of the stage."""
        return int(self.lines.axis[self.position.meshes[0]])

    def label(self, origin: Origin) -> str:
        """Label of a line: ``2 x mesh + sun run-out - 3 x carrier``."""
        names = self.lines.names(self.system)
        terms = [(count, f"{abs(count)} x {names[j]}") for j, count in enumerate(origin.mesh)]
        if origin.shaft >= 0:
            terms.append((origin.sign, self.shaft_names[origin.shaft]))
        terms.append((origin.carrier, f"{abs(origin.carrier)} x carrier"))
        text = ""
        for count, name in sorted(terms, key=lambda term: term[0] < 0):
            if count:
                text += (" + " if count > 0 else " - ") + name
        return text.removeprefix(" + ").strip()

    def family(self, origin: Origin, *, faulty: bool) -> str:
        """Family of a line, the one word for its cause.  faulty : the line is hardly there without deviations."""
        if origin.shaft >= 0:
            return self.shaft_names[origin.shaft]
        meshes = len(self.lines.mesh_tones)
        for j, count in enumerate(origin.mesh):
            if count and j != self.own:
                return f"{self.lines.names(self.system)[j]}{' of another stage' if j < meshes else ''}"
        order = origin.mesh[self.own]
        if self._passes(origin):
            return MEAN if order == 0 else PASSING if origin.carrier else MESH
        return UNLIKE if faulty or self.position.even else UNEVEN

    def causes(self, origins: Sequence[Origin], *, faulty: bool) -> str:
        """Causes of a line with paths in the file, the largest part first.  faulty : as of `family`."""
        paths: list[str] = []
        for origin in origins:
            of_shaft = origin.shaft >= 0
            paths += self.lines.shaft[origin.shaft].causes if of_shaft else self._causes(origin, faulty=faulty)
        return "; ".join(dict.fromkeys(paths))

    def origin(self, spectrum: StageSpectrum, part: LineSource) -> Origin:
        """Origin of a source of a line."""
        sign = -1 if part.negative else 1
        turn = (spectrum.carrier > 0) - (spectrum.carrier < 0)
        return Origin(
            mesh=tuple(sign * int(count) for count in spectrum.point[part.row]),
            shaft=int(spectrum.shaft[part.row]),
            sign=sign,
            carrier=sign * turn * part.order,
        )

    @cached_property
    def shaft_names(self) -> list[str]:
        """Names of the shaft lines from paths and exact orders: ``sun run-out``, ``3 x sun pitch``."""
        words = (dict.fromkeys(self._shaft_word(shaft, path) for path in shaft.causes) for shaft in self.lines.shaft)
        return [" & ".join(each) or "shaft" for each in words]

    def _causes(self, origin: Origin, *, faulty: bool) -> list[str]:
        """Causes of one origin at mesh orders."""
        family, at_order = self.family(origin, faulty=faulty), self._at_order(origin.mesh)
        standing = self._at_order((0,) * len(origin.mesh))
        faults = [path for path in standing if path.startswith("deviations.")] if faulty else []
        if family == UNLIKE:
            return [*faults, *at_order] or ["planets that differ"]
        first = _UNEVEN_CAUSE if family == UNEVEN else _FAULT_FREE if origin.carrier else _MESHING
        return [first, *at_order, *faults]

    def _at_order(self, mesh: tuple[int, ...]) -> list[str]:
        """Paths of the lines at a mesh order, or at 0, of either sign."""
        mirrored = tuple(-count for count in mesh)
        return [cause for point, line in self.lines.mesh if point in (mesh, mirrored) for cause in line.causes]

    def _passes(self, origin: Origin) -> bool:
        """Whether a line of mesh orders survives with even planets that are alike [mcfadden1985]."""
        count, teeth = len(self.position.spacing), self.position.teeth
        if self.position.turn == 0:
            return True
        if teeth is None:
            return origin.carrier % count == 0
        forwards = 1 if self.position.turn > 0 else -1
        # planet n meshes z_ring psi_n / 2 pi cycles earlier, the other way round where the ring's teeth come forwards
        return (-origin.mesh[self.own] * teeth + forwards * origin.carrier) % count == 0

    def _shaft_word(self, shaft: Shaft, path: str) -> str:
        """``deviations.main.sun.run_out`` -> ``sun run-out``, with the order where it is not the first."""
        stages = tuple(dict.fromkeys(mesh_stages(self.system)))
        parts = path.split(".")[1:]
        member = ".".join(parts[:2]) if parts[:1] and parts[0] in stages else parts[0] if parts else path
        if len(stages) == 1:
            parts = parts[1:] if parts[:1] == [stages[0]] else parts
        words = " ".join(parts).replace("run_out", "run-out").replace("_", " ") or path
        order = self._order(shaft.frequency, member)
        return words if order in (None, 1) else f"{order} x {words}"

    def _order(self, frequency: Fraction, member: str) -> int | None:
        """Turns of a member in the axes of the stage in one period, None where they are no whole number."""
        name = member.replace(".", "/")
        for body, turns in zip(self.system.dofs.bodies, self.system.body_turns, strict=True):
            if body == name or body.startswith(f"{name}/"):
                relative = turns - self.system.stage_turns.get(name.split("/")[0], Fraction(0))
                order = abs(frequency / relative) if relative else Fraction(0)
                return int(order) if order.denominator == 1 and order else None
        return None


def is_fault_free(causes: Sequence[str]) -> bool:
    """Whether a line of excitation belongs to the train as drawn: tooth form and loads, no other deviations."""
    return not causes or any(not cause.startswith("deviations.") or _is_profile(cause) for cause in causes)


def _is_profile(path: str) -> bool:
    """Whether a path is that of a profile error; an error that turns with a member has a name of the user's."""
    return path.split(".")[-1] == "profile" and ".errors." not in path


# --- the signal ------------------------------------------------------------------------------------------------------


class _Sensor(NamedTuple):
    """What the sensor sees through, and the options."""

    position: SensorPosition
    window: Window
    transfer: Transfer | None
    options: ModulationOptions


class _SensorSignal(NamedTuple):
    """Signal at the sensor by lines.

    frequency : (L,) at this speed [Hz].  signal : (L,) in `unit`.  acceleration : (L,) of the body under it [m/s2].
    window : (L,) the signal through the window, where that of a sensor of the model stands beside it; else none.
    """

    spectrum: StageSpectrum
    lines: SensorLines
    frequency: Array
    signal: ComplexArray
    acceleration: ComplexArray
    unit: str
    window: ComplexArray | None = None


def modulation(system: System, options: ModulationOptions) -> xr.Dataset:
    """Vibration at a fixed place beside the ring: its lines by family and cause, and its signal over time.

    Every mesh force with the ring passes a window over the angle between its planet and the sensor, left and right
    helix together, then the transfer path [mcfadden1985] [inalpolat2009].  Without a transfer path the signal is a
    force [N], and the acceleration of the ring as a rigid body stands beside it; a path in m/s2/N makes it an
    acceleration and adds that of the ring.  The steady state of means is left out: the signal has no mean.

    The signal of a sensor of the model is its own: strain or acceleration of the ring there, or the force of a bolt.
    What the window makes of the mesh forces stands beside it, and `window_difference` says how much they differ.

    Raises
    ------
    ModelError : as of `sensor_position`, `named_window` and `steady`; numbers out of range.
    ConvergenceError : as of `steady`.
    """
    window, transfer, relative_speed = options.window, options.transfer, options.relative_speed
    assert not isinstance(window, Path)
    assert not isinstance(transfer, str | Path)
    position = _position(system, options)
    if isinstance(window, str):
        window = named_window(window, planets=len(position.branches), width=options.width)
    sensor = _Sensor(position, window, transfer, options)
    if options.radius is not None and not (math.isfinite(options.radius) and options.radius > 0):
        raise ModelError("out of range", path="radius", given=options.radius, allowed="above zero")
    if not 0 <= options.floor < 1:
        raise ModelError("out of range", path="floor", given=options.floor, allowed="0 or more, below 1")
    ready, block = solve_speed(system, relative_speed, TOLERANCE)
    at_sensor = _sensor_signal(ready, block, sensor)
    healthy = _fault_free(system, sensor)
    listed = _listed(at_sensor, options.floor)
    duration = _duration(system, position, options.turns) / relative_speed
    count = _samples(at_sensor.frequency[listed], duration, options.samples)
    signal = synthesised_signal(at_sensor.frequency[listed], at_sensor.signal[listed], duration, count)
    return _labelled(ready, block, sensor, at_sensor, listed=listed, healthy=healthy, signal=(duration, signal))


def _position(system: System, options: ModulationOptions) -> SensorPosition:
    """Position of the sensor: of an angle, or of a sensor of the model on what stands in the housing.

    Raises
    ------
    ModelError : as of `sensor_position`; a sensor of rotation or torque, or one beside a stage, body or radius.
    """
    asked: dict[str, Any] = {"stage": options.stage, "body": options.body}
    placed = partial(sensor_position, system, through_planet=options.through_planet)
    if not isinstance(options.sensor, str):
        return placed(angle=options.sensor, **asked)
    sensors, beside = system.sensors, {**asked, "radius": options.radius}
    known = [name for name, kind in zip(sensors.name, sensors.kind, strict=True) if kind not in ("angle", "torque")]
    if options.sensor not in known:
        allowed = ", ".join(known) or "an angle, or a sensor of strain, acceleration or force in the model"
        problem = "no such sensor of strain, acceleration or force"
        raise ModelError(problem, path="sensor", given=options.sensor, allowed=allowed)
    for path, value in beside.items():
        if value is not None:
            raise ModelError(f"is that of the sensor {options.sensor}", path=path, given=value, allowed="nothing")
    i = sensors.name.index(options.sensor)
    body = sensors.bodies[i][0]
    try:
        position = placed(stage=body.split("/")[0], body=body, angle=float(sensors.angle[i]))
    except ModelError as error:  # it names the body, which nobody gave
        raise ModelError(error.problem, path="sensor", given=options.sensor, allowed=error.allowed) from None
    return replace(position, sensor=i)


def _recorded(system: System, sensor: _Sensor) -> dict[str, Any]:
    """Options as the result has them, what they stand for in place of names and of what was not given."""
    names = "relative_speed stage body sensor direction window width transfer through_planet mean_load floor turns"
    return {name: getattr(sensor.options, name) for name in names.split()} | {
        "stage": sensor.position.stage,
        "body": _where(system, sensor.position),
        "window": sensor.window.name,
        "transfer": "none" if sensor.transfer is None else sensor.transfer.unit,
    }


def _sensor_signal(ready: Response, block: Block, sensor: _Sensor) -> _SensorSignal:
    """Lines at the sensor of a solved block (P = 1)."""
    (position, window, transfer, options), speed = sensor, float(block.speed[0])
    spectrum = stage_spectrum(ready, block, position)
    sensors, own = ready.system.sensors, position.sensor
    # of strain and force the mean load that passes is the most
    if not (options.mean_load or (own >= 0 and sensors.kind[own] != "acceleration")):
        spectrum = replace(spectrum, force=np.where(spectrum.step == 0, 0.0, spectrum.force))
        if own >= 0:
            spectrum = replace(spectrum, motion=np.where(spectrum.step == 0, 0.0, spectrum.motion))
    through_window = windowed_forces(spectrum, position, window)
    if own >= 0:
        lines = merged_lines(spectrum, own_signal(spectrum, sensors.rows[own]), through_window)
    else:
        radius = _radius(ready.system, position) if options.radius is None else options.radius
        motion = sensor_motion(spectrum, position, options.direction, radius)
        lines = merged_lines(spectrum, through_window, motion)
    frequency = speed * np.array([float(exact) for exact in lines.frequency])
    path = 1.0 if transfer is None else transfer.at(frequency)
    if own >= 0:
        signal = lines.force * (speed**2 if sensors.kind[own] == "acceleration" else 1.0)
        acceleration = np.where(sensors.kind[own] == "acceleration", signal, np.nan)
        return _SensorSignal(spectrum, lines, frequency, signal, acceleration, sensors.unit[own], lines.motion * path)
    acceleration = -((2 * np.pi * frequency) ** 2) * lines.motion
    accelerates = transfer is not None and transfer.unit == ACCELERATION
    signal = lines.force * path + (acceleration if accelerates else 0.0)
    return _SensorSignal(spectrum, lines, frequency, signal, acceleration, "m/s2" if accelerates else "N")


def _window_fit(at_sensor: _SensorSignal) -> tuple[float, float]:
    """Factor by which the sizes of the window's lines come nearest to those of the sensor, and the RMS left [1].

    Least squares over all lines: with a, b the sizes, the factor is a.b / b.b and what is left sqrt(1 - (a.b)^2/(a.a
    b.b)) of the sensor's: 0 of equal proportions, 1 where no line is in both.
    """
    a, b = np.abs(at_sensor.signal), np.abs(at_sensor.window) if at_sensor.window is not None else np.zeros(0)
    if not (a.any() and b.any()):
        return 0.0, 1.0
    factor = float(a @ b / (b @ b))
    return factor, float(np.linalg.norm(a - factor * b) / np.linalg.norm(a))


def _radius(system: System, position: SensorPosition) -> float:
    """Reference radius of the body under the sensor [m], 0 where it cannot turn."""
    names = {system.dofs.bodies[body] for body in position.bodies}
    spectrum = zip(system.dofs.body, system.dofs.direction, system.dofs.radius, strict=True)
    return next((float(R) for body, direction, R in spectrum if body in names and direction == "rz"), 0.0)


def _fault_free(system: System, sensor: _Sensor) -> dict[Fraction, complex]:
    """Signal of the same train without manufacturing deviations, by exact frequency [Hz at s = 1]."""
    lines = tuple(_drawn_part(line) for line in system.lines if is_fault_free(line.causes))
    ready, block = solve_speed(replace(system, lines=lines), sensor.options.relative_speed, TOLERANCE)
    at_sensor = _sensor_signal(ready, block, sensor)
    return dict(zip(at_sensor.lines.frequency, at_sensor.signal.tolist(), strict=True))


def _drawn_part(line: Line) -> Line:
    """A line of the centrifugal load without the deviations in it: no gaps, loads that grow with the speed alone."""
    drawn = [cause for cause in line.causes if not cause.startswith("deviations.")]
    if not 0 < len(drawn) < len(line.causes) or not all(cause.endswith(".mass") for cause in drawn):
        return line
    return replace(
        line,
        gap=np.zeros_like(line.gap),
        link_gap=np.zeros_like(line.link_gap),
        group_gap=np.zeros_like(line.group_gap),
        far_gap=np.zeros_like(line.far_gap),
        force=line.force * np.array([[0.0], [0.0], [1.0]]),
    )


def _listed(at_sensor: _SensorSignal, floor: float) -> NDArray[np.int64]:
    """Indices of the lines above the floor in the signal; of a floor of 0 all, motion without signal too."""
    size = np.abs(at_sensor.signal)
    return np.flatnonzero((size >= floor * size.max(initial=0.0)) & ((size > 0) | (floor == 0)))


def _duration(system: System, position: SensorPosition, turns: int) -> float:
    """Length of the signal at the operating speed [s]."""
    speeds = zip(system.dofs.bodies, system.body_turns, strict=True)
    fastest = max(abs(turn) for name, turn in speeds if name.split("/")[0] == position.stage)
    return float(turns / (abs(position.turn) or fastest))


def _samples(frequency: Array, duration: float, samples: int | None) -> int:
    """Number of samples: 2.56 a cycle of the highest line, as analysers take them, to the next power of two.

    frequency : (L,) [Hz].  duration : [s].

    Raises
    ------
    ModelError : too few for the highest line, or too many.
    """
    highest = float(frequency.max(initial=0.0)) * duration
    enough = max(_FEWEST, 1 << math.ceil(math.log2(max(2.56 * highest, 1.0))))
    wanted = enough if samples is None else samples
    if not max(1, 2 * highest) < wanted <= _MAX_SAMPLES:
        raise ModelError(
            f"{wanted} samples: the signal needs more than {2 * highest:.0f}, and there may be {_MAX_SAMPLES}",
            path="samples",
            given=samples,
            allowed="fewer turns, a higher floor, or another number",
        )
    return wanted


def _where(system: System, position: SensorPosition) -> str:
    """Names of the bodies under the sensor."""
    return ", ".join(system.dofs.bodies[body] for body in position.bodies) or "housing"


def _labelled(
    ready: Response,
    block: Block,
    sensor: _Sensor,
    at_sensor: _SensorSignal,
    *,
    listed: NDArray[np.int64],
    healthy: dict[Fraction, complex],
    signal: tuple[float, Array],
) -> xr.Dataset:
    """Dataset of the listed lines (indices `listed`), and the signal (duration [s], samples)."""
    from ...results.dataset import dataset

    position, system, speed = sensor.position, ready.system, float(block.speed[0])
    labels = LineLabels(system=system, lines=ready.lines, position=position)
    origins = [[labels.origin(at_sensor.spectrum, part) for part in at_sensor.lines.parts[i]] for i in listed]
    frequency = [at_sensor.lines.frequency[i] for i in listed]
    without = np.array([healthy.get(exact, 0j) for exact in frequency])
    faulty = np.abs(at_sensor.signal[listed] - without) > _REPORTED * np.abs(at_sensor.signal[listed])
    duration, values = signal
    unit = at_sensor.unit
    angle = np.linspace(-np.pi, np.pi, 721)
    causes = [labels.causes(sources, faulty=bad) for sources, bad in zip(origins, faulty, strict=True)]
    family = [labels.family(sources[0], faulty=bad) for sources, bad in zip(origins, faulty, strict=True)]
    beside: dict[str, Any] = {}
    if at_sensor.window is not None:
        factor, left = _window_fit(at_sensor)
        beside = {"window_amplitude": ("line", factor * at_sensor.window[listed]), "window_difference": ((), left)}
    result = dataset(
        {
            **beside,
            "line_frequency": ("line", at_sensor.frequency[listed]),
            "exact_frequency": ("line", np.array([str(exact) for exact in frequency], dtype=object)),
            "mesh_order": ("line", np.array([float(exact / ready.lines.tones[labels.own]) for exact in frequency])),
            "carrier_order": ("line", np.array([float(exact / abs(position.turn or 1)) for exact in frequency])),
            "signal_amplitude": ("line", at_sensor.signal[listed]),
            "fault_free_amplitude": ("line", without),
            "sensor_acceleration": ("line", at_sensor.acceleration[listed]),
            "family": ("line", np.array(family, dtype=object)),
            "causes": ("line", np.array(causes, dtype=object)),
            "signal": ("sample_time", values),
            "passage": ("planet", _passages(position, speed)),
            "window_gain": ("window_angle", sensor.window.at(angle)),
        },
        {
            "line": np.array([labels.label(sources[0]) for sources in origins], dtype=object),
            "sample_time": np.arange(values.size) * (duration / values.size),
            "planet": list(position.branches),
            "window_angle": angle,
        },
        verb="modulation",
        options={**_recorded(system, sensor), "samples": values.size, "harmonics": block.harmonics},
        provenance=system.provenance,
        warnings=[*system.warnings, *_warnings(ready, block, sensor, at_sensor)],
        units={name: unit for name in ("signal", "signal_amplitude", "fault_free_amplitude", "window_amplitude")},
    )
    result.attrs.update(
        stage=position.stage,
        sensor_body=_where(system, position),
        carrier_frequency=speed * abs(float(position.turn)),
        stage_mesh_frequency=speed * float(ready.lines.tones[labels.own]),
        common_period=str(_period(frequency)),
        power_kept=float(_power(at_sensor.signal[listed]) / (_power(at_sensor.signal) or 1.0)),
    )
    return result


def _power(amplitude: ComplexArray) -> float:
    """Mean square of a signal of amplitudes (L,)."""
    return float((np.abs(amplitude) ** 2).sum() / 2)


def _period(frequency: list[Fraction]) -> Fraction:
    """Common period of all lines at the operating speed, exact [s]."""
    if not frequency:
        return Fraction(0)
    unit = math.lcm(*(exact.denominator for exact in frequency))
    return Fraction(unit, math.gcd(*(int(exact * unit) for exact in frequency)))


def _passages(position: SensorPosition, speed: float) -> Array:
    """First time at which each planet passes the sensor, (N,) [s], nan where none does."""
    if position.turn == 0:
        return np.full(len(position.branches), np.nan)
    turn = speed * float(position.turn)
    ahead = (position.angle - position.spacing) / (2 * np.pi) * np.sign(turn) % 1.0
    return np.asarray(ahead / abs(turn))


def _warnings(ready: Response, block: Block, sensor: _Sensor, at_sensor: _SensorSignal) -> list[CodedText]:
    """Warnings: teeth that pull, a window cut short, lines outside the transfer function."""
    system, rows = ready.system, force_signal(ready, block)
    every = whole_mesh_signal(rows, faces(system.meshes))
    most = force_extremes(every, axis=mesh_axis(ready))[1]
    factor = dynamic_factor(most, mean(every), parallel_meshes(system.meshes), rounding_of(system))
    notes = tension_warnings(system, force_extremes(rows, axis=ready.lines.axis)[0], factor)
    window, transfer = sensor.window, sensor.transfer
    if window.remainder > 1e-2:
        last = len(window.coefficients) - 1
        text = f"the window is cut at {last} harmonics: {window.remainder:.1%} of it left out"
        notes.append(coded("window-cut", text))
    if transfer is not None:
        outside = ~transfer.covers(at_sensor.frequency)
        through = at_sensor.lines.force if at_sensor.window is None else at_sensor.lines.motion
        lost, whole = _power(through[outside]), _power(through)
        if lost > 1e-6 * whole:
            text = (
                f"the transfer path is given from {transfer.frequency[0]:g} to {transfer.frequency[-1]:g} Hz: "
                f"lines outside are left out, {lost / whole:.2%} of the mean square of the force"
            )
            notes.append(coded("transfer-range", text))
    return notes
