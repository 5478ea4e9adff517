"""Steady response at one speed and over a range of speeds as labelled Datasets: linear contact, shaft orders, sensors.

Lines of a sensor stand at exact frequencies, also of material that turns against its frame.  A row that turns,
Re(C exp(i k phi)) . q, makes of the line f of q the lines f + k nu and f - k nu, nu the speed of the material against
its frame, with half of C and of its conjugate.  Derived here.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from math import lcm
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.plan import MOST_NUMBERS, require_memory
from ...engine.run_folder import RunFolder
from ...engine.workers import each, import_results
from ...statics.record import Record, idle_warnings, parallel_meshes, turn_fraction
from ...statics.signals import Columns, error_waves, range_columns, ranges_of_lines, sensor_labels
from ...statics.static import rounding_of
from ...statics.tangent import linear, turn_warnings
from ...system.system import Array, ComplexArray, System, faces
from ...warning_codes import CodedText, coded
from . import SteadyOptions, SweepOptions
from .lattice import Integers, line_frequencies, on_axis
from .measures import (
    TOLERANCE,
    Layout,
    dynamic_factor,
    force_extremes,
    link_measures,
    mean,
    mean_square,
    order_harmonics,
    ranges,
    solve_speed,
    superposed,
    sweep_measures,
)
from .response import (
    MEAN_UNSTABLE,
    NO_SPEED,
    Block,
    Response,
    Truncation,
    instability_warnings,
    respond_part,
    response,
    response_parts,
    unstable_speeds,
)
from .spectra import (
    Spectrum,
    alias_free_samples,
    combinations,
    error_signal,
    force_signal,
    lateral_pairs,
    link_labels,
    link_signal,
    mesh_axis,
    motion_signal,
    row_signal,
    tone_waveform,
    torus_waveform,
    whole_mesh_signal,
)
from .sweep_table import ROWS, SweepTable, empty_table, speeds_of, sweep_dataset, with_bounds_named

# Part of the largest line of a sensor that is rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorSpectrum:
    """Lines of s sensors at P speeds: value = Re sum_f amplitude[.., f] exp(2 pi i frequency_f s t).

    step : (F,) whole numbers, rising from 0, frequency = step / unit, exact [Hz at s = 1].  amplitude : (s, P, F).
    """

    step: Integers
    unit: int
    amplitude: ComplexArray

    @property
    def frequency(self) -> list[Fraction]:
        """Exact frequencies (F,) [Hz at the operating speed]."""
        return [Fraction(int(step), self.unit) for step in self.step]

    @property
    def measures(self) -> dict[str, Array]:
        """Mean over all time, and RMS of what varies, (s, P)."""
        power = (np.abs(self.amplitude[..., self.step != 0]) ** 2).sum(axis=-1)
        mean = self.amplitude[..., self.step == 0].real.sum(axis=-1)
        return {"sensor_mean": mean, "sensor_rms": np.sqrt(power / 2)}

    def order(self, tone: Fraction, orders: int) -> Array:
        """Amplitude (s, orders, P) of all lines nearer to each multiple of a tone than to others, as root of the sum
        of squares: sidebands among them."""
        near = np.array([round(one / tone) for one in self.frequency], int)
        power = np.abs(self.amplitude) ** 2
        sums = [power[..., near == order].sum(axis=-1) for order in range(1, orders + 1)]
        return np.asarray(np.sqrt(np.stack(sums, axis=1)))


def sensor_spectrum(ready: Response, block: Block) -> SensorSpectrum:
    """Lines of all sensors of a solved block; what is rounding beside the largest of its sensor is left out."""
    sensors = ready.system.sensors
    unit = lcm(*(turn.denominator for turn in sensors.turn))
    found = [_lines(ready, block, i, unit) for i in range(len(sensors.name))]
    unit = lcm(*(own for _, own, _ in found))
    steps = [step * (unit // own) for step, own, _ in found]
    every = np.unique(np.concatenate([np.zeros(1, object), *steps]))
    amplitude = np.zeros((len(found), block.speed.size, every.size), complex)
    for i, (step, (_, _, values)) in enumerate(zip(steps, found, strict=True)):
        amplitude[i][:, np.searchsorted(every, step)] = values
    with np.errstate(invalid="ignore"):
        size = np.abs(amplitude)
        amplitude[size <= _ROUNDING * size.max(axis=(1, 2), keepdims=True)] = 0.0
    amplitude[..., 0].imag = 0.0
    kept = np.flatnonzero(amplitude.any(axis=(0, 1)))
    return SensorSpectrum(step=every[kept], unit=unit, amplitude=amplitude[..., kept])


def _lines(ready: Response, block: Block, i: int, unit: int) -> tuple[Integers, int, ComplexArray]:
    """Steps (F,), their unit and amplitudes (P, F) of one sensor; unit : of all speeds of material."""
    system, sensors = ready.system, ready.system.sensors
    if sensors.kind[i] == "torque":
        weight = sensors.link_weights(len(system.links.name))[i]
        forces = link_signal(ready, block) if weight.any() else force_signal(ready, block)
        lines, weight = forces.line_frequencies, weight if weight.any() else sensors.mesh[i]
        return lines.distinct, lines.unit, lines.merged(np.tensordot(weight, forces.values, axes=1))
    rows = sensors.rows[i]
    used = [(j, k) for j, k in zip(*np.nonzero(rows.any(axis=2)), strict=True)]
    if not used:  # a direction in which the body does not move
        return np.zeros(1, object), unit, np.zeros((block.speed.size, 1), complex)
    parts = np.array([part for j, k in used for part in (rows[j, k].real, rows[j, k].imag)])
    signal = row_signal(ready, block, parts.reshape(-1, system.force.size).T, strains=sensors.kind[i] == "strain")
    lines, values = signal.line_frequencies, signal.values
    whole = lcm(lines.unit, unit)
    step = lines.distinct[lines.line] * np.where(lines.negative, -1, 1) * (whole // lines.unit)
    turn = int(sensors.turn[i] * whole)
    at, amplitude = [np.zeros(0, object)], [np.zeros((block.speed.size, 0), complex)]
    for (j, k), real, imaginary in zip(used, values[::2], values[1::2], strict=True):
        for sense in (1, -1) if k else (0,):
            own = (real + 1j * sense * imaginary) / (2 if k else 1)
            at.append(step + sense * int(k) * turn)
            amplitude.append(own * (2j * np.pi * (at[-1] / whole).astype(float)) ** j)
    scale = block.speed[:, None] ** (2 if sensors.kind[i] == "acceleration" else 0)
    merged = line_frequencies(np.concatenate(at), whole)
    return merged.distinct, whole, merged.merged(np.concatenate(amplitude, axis=1)) * scale


def sensor_columns(ready: Response, block: Block) -> tuple[Columns, dict[Hashable, Any]]:
    """Variables and coordinates of the sensors of one solved speed; nothing without sensors."""
    sensors = ready.system.sensors
    if not sensors.name:
        return {}, {}
    spectrum, tone = sensor_spectrum(ready, block), ready.lines.tone
    columns, labels = sensor_labels(sensors)
    frequency = spectrum.frequency
    return {
        **columns,
        **{name: ("sensor", values[:, 0]) for name, values in spectrum.measures.items()},
        "sensor_amplitude": (("sensor", "sensor_line"), spectrum.amplitude[:, 0]),
        "sensor_line_frequency": ("sensor_line", float(block.speed[0]) * np.array([float(one) for one in frequency])),
        "sensor_line_order": ("sensor_line", np.array([float(one / tone) for one in frequency])),
    }, {**labels, "sensor_line": [str(one) for one in frequency]}


def sensor_measures(ready: Response, block: Block, orders: int) -> dict[str, Array]:
    """Measures of the sensors at solved speeds: (s, P), and (s, orders, P) of orders of the first mesh frequency."""
    spectrum = sensor_spectrum(ready, block)
    return {**spectrum.measures, "sensor_order": spectrum.order(ready.lines.tone, orders)}


# Largest residual of a speed, per tolerance.
_ACCEPTED = 100.0


def steady(system: System, options: SteadyOptions) -> xr.Dataset:
    """Steady response at one speed as a Dataset: forces and displacements over the mesh phase, harmonics, lines.

    With several mesh frequencies a mesh force over the mesh phase is its part at multiples of the mesh's own tone, a
    displacement that at multiples of the first mesh's; ``combination_force`` and ``combination_displacement`` hold
    every multiple and combination of them, and RMS, bound and minimum count them all.

    With the method ``superposition`` every frequency is alone on the mean system, see `superposed`.

    Returns
    -------
    Variables and units of docs/theory/response.md: forces [N, N m], displacements [m].

    Raises
    ------
    ModelError, ConvergenceError : as of `periodic`.
    """
    from ...results.dataset import dataset

    relative_speed, samples, method = options.relative_speed, options.samples, options.method
    # complex signals of the meshes, displacements and links at all samples at once
    width = 4 * (len(system.dofs.names) + len(system.meshes.name) + len(system.links.name))
    most = f"at most {MOST_NUMBERS // width}"
    require_memory(float(samples) * width, path="samples", given=samples, allowed=most)
    theta = np.arange(samples) / samples
    of_turn = turn_warnings(system)
    ready, block = solve_speed(
        system if method == "exact" else superposed(linear(system), relative_speed), relative_speed, TOLERANCE
    )
    system = ready.system
    face, axis = faces(system.meshes), mesh_axis(ready)
    rows, moved = force_signal(ready, block), motion_signal(ready, block)
    every, motion = whole_mesh_signal(rows, face), moved.orders
    force, shafts = every.orders, every.lines
    low, high = force_extremes(every, axis=axis)
    lowest = force_extremes(rows, axis=ready.lines.axis)[0] if face.cut.any() else low
    factor = dynamic_factor(high, mean(every), parallel_meshes(system.meshes), rounding_of(system))
    radius = system.dofs.radius[:, None]
    top = block.harmonics + system.meshes.variation.shape[1]
    combined, labels = _combinations(ready, force, motion, relative_speed)
    links, link_labels = _link_variables(ready, block, theta, top)
    errors, error_labels = _error_variables(ready, block, theta)
    sensors, sensor_names = sensor_columns(ready, block)
    result = dataset(
        {
            "mesh_force": (("mesh", "mesh_phase"), _by_mesh(ready, force, theta)[:, 0].real),
            "displacement": (("dof", "mesh_phase"), radius * tone_waveform(motion, 0, theta)[:, 0, 0].real),
            "mesh_force_harmonic": (
                ("mesh", "harmonic"),
                _own_tone(ready, [_orders(force, tone, top) for tone in range(len(ready.lines.tones))]),
            ),
            "displacement_harmonic": (("dof", "harmonic"), radius * _orders(motion, 0, top)),
            **combined,
            "mesh_force_rms": ("mesh", np.sqrt(mean_square(every)[:, 0])),
            "mesh_force_bound": ("mesh", high[:, 0]),
            "mesh_force_minimum": ("mesh", low[:, 0]),
            "dynamic_factor": ("mesh", factor[:, 0]),
            **links,
            **errors,
            **sensors,
            **_line_variables(ready, block, shafts, theta),
            "residual": ((), block.residual[0]),
        },
        {
            "mesh": list(face.name),
            "dof": list(system.dofs.names),
            **link_labels,
            **error_labels,
            **sensor_names,
            "mesh_phase": theta,
            "harmonic": np.arange(top + 1),
            **labels,
            "line": np.array(["; ".join(shaft.causes) for shaft in ready.lines.shaft], dtype=object),
            "mesh_frequency": float(ready.lines.tone) * relative_speed,
        },
        verb="steady",
        options={"method": method, "relative_speed": relative_speed, "samples": samples, "harmonics": block.harmonics},
        provenance=system.provenance,
        warnings=[
            *system.warnings,
            *of_turn,
            *tension_warnings(system, lowest, factor),
            *factor_warnings(system, factor),
        ],
    )
    return with_bounds_named(result, len(ready.lines.tones))


def link_row_forces(system: System, record: Record) -> dict[str, Array]:
    """Force (T,) [N, N m] of every row of the links at the instants of a record, at the operating speed, by its name.

    Links with a law are linear about the mean load; their forces are given along the rows of the law again.

    Raises
    ------
    ModelError, ConvergenceError : as of `periodic`.
    """
    ready, block = solve_speed(system, 1.0, TOLERANCE)
    signal, links, own = link_signal(ready, block), ready.system.links, len(system.links.name)
    lines, step = signal.line_frequencies, record.unit * record.samples
    turns = [turn_fraction(Fraction(int(line), lines.unit) / step, record.index) for line in lines.distinct]
    force = (lines.merged(signal.values)[:, 0] @ np.exp(2j * np.pi * np.array(turns))).real
    rows = dict(zip(links.name[:own], force[:own], strict=True))
    for group in system.groups:
        of = [i for i in range(own, len(links.name)) if links.link[i] == group.name]
        axes = np.linalg.lstsq(group.B, links.B[:, of], rcond=None)[0]
        rows |= dict(zip(group.rows, axes @ force[of], strict=True))
    return rows


def _link_variables(
    ready: Response, block: Block, theta: Array, top: int
) -> tuple[dict[str, Any], dict[Hashable, Any]]:
    """Variables and coordinates of links: forces at multiples of the first mesh frequency, measures of all frequencies.

    theta : (Nt,) mesh phase.  top : highest harmonic.
    """
    labels = link_labels(ready.system)
    if not labels:
        return {}, {}
    links = link_signal(ready, block)
    variables: dict[str, Any] = {
        "link_force": (("link_row", "mesh_phase"), tone_waveform(links.orders, 0, theta)[:, 0, 0].real),
        "link_force_harmonic": (("link_row", "harmonic"), _orders(links.orders, 0, top)),
    }
    measures = link_measures(links, lateral_pairs(ready.system), ready.system.links.turn)
    variables |= {name: (ROWS[name], values[:, 0]) for name, values in measures.items() if values.size}
    return variables, {**labels}


def _error_variables(ready: Response, block: Block, theta: Array) -> tuple[dict[str, Any], dict[Hashable, Any]]:
    """Variables and coordinates of the transmission errors: multiples of the first mesh frequency, ranges, lines.

    Where the common period is too long for its waveform the range is that over all phases.

    theta : (Nt,) mesh phase.
    """
    system = ready.system
    if not system.errors.mesh:
        return {}, {}
    signal = error_signal(ready, block)
    lines, span = signal.line_frequencies, ranges(signal)
    amplitude = lines.merged(signal.values)[:, 0]
    frequency = [Fraction(int(step), lines.unit) for step in lines.distinct]
    spans = ranges_of_lines(system, amplitude, frequency, (span.high - span.low)[:, 0])
    varying = [place for place, one in enumerate(frequency) if one]
    columns, labels = range_columns(system, spans, [frequency[i] for i in varying], amplitude[:, varying])
    labels["error_line_frequency"] = ("error_line", labels["error_line_frequency"][1] * float(block.speed[0]))
    waves = tone_waveform(signal.orders, 0, theta)[:, 0, 0].real
    return {**error_waves(system.errors, waves, "mesh_phase"), **columns}, labels


def tension_warnings(system: System, lowest: Array, factor: Array) -> list[CodedText]:
    """Warning where the linear model pulls on teeth that carry load, or on any where none do.

    lowest : smallest force of every mesh row at every speed, (rows, P) [N].  factor : K_v of the meshes (m, P) [1].
    """
    carried = _with_factor(system, factor) if np.isfinite(factor).any() else np.ones(len(factor), dtype=bool)
    pulled = (np.nan_to_num(lowest, nan=np.inf) < 0) & carried[faces(system.meshes).row, None]
    if not pulled.any():
        return []
    names = [name for name, row in zip(system.meshes.name, pulled, strict=True) if row.any()]
    listed = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
    points = int(pulled.any(axis=0).sum())
    where = f" at {points} of {pulled.shape[1]} speeds" if pulled.shape[1] > 1 else ""
    return [
        coded(
            "tension-in-teeth", f"tensile mesh force in the linear model{where}: the teeth of {listed} would separate"
        )
    ]


def factor_warnings(system: System, factor: Array) -> list[CodedText]:
    """A warning of the pairs of gears without a K_v (m, P) at any speed, where another pair has one."""
    loaded = _with_factor(system, factor)
    return idle_warnings(faces(system.meshes).name, loaded, "dynamic factor K_v") if loaded.any() else []


def _with_factor(system: System, factor: Array) -> NDArray[np.bool_]:
    """Meshes (m,) of pairs of gears that have a K_v (m, P) at any speed."""
    known = np.asarray(np.isfinite(factor).any(axis=1))
    loaded = np.zeros_like(known)
    for group in parallel_meshes(system.meshes):
        loaded[group] = known[group].any()
    return loaded


def _by_mesh(ready: Response, spectrum: Spectrum, theta: Array) -> NDArray[Any]:
    """Multiples of each mesh's own tone over its phase theta (Nt,), (m, S, Nt)."""
    return _own_tone(ready, [tone_waveform(spectrum, axis, theta)[:, 0] for axis in range(len(ready.lines.tones))])


def _orders(spectrum: Spectrum, axis: int, top: int) -> ComplexArray:
    """One-sided harmonics 0 .. top of one tone, (rows, top + 1): value = Re sum harmonic_h exp(2 pi i h theta)."""
    orders = spectrum.points[:, axis]
    result = np.zeros((spectrum.amplitude.shape[0], top + 1), complex)
    known = on_axis(spectrum.points, axis) & (orders <= top)
    result[:, orders[known]] = spectrum.amplitude[:, 0, 0, known]
    return result


def _own_tone(ready: Response, by_axis: list[NDArray[Any]]) -> NDArray[Any]:
    """Of arrays (m, ..) of every tone the rows of each mesh's own tone, (m, ..)."""
    axis = mesh_axis(ready)
    return np.array(by_axis)[axis, np.arange(len(axis))]


def _combinations(
    ready: Response, force: Spectrum, motion: Spectrum, speed: float
) -> tuple[dict[str, Any], dict[Hashable, Any]]:
    """Amplitudes of all lattice points kept where there are several tones: variables and coordinates."""
    tones = ready.lines.tones
    if len(tones) == 1:
        return {}, {}
    labels, frequency = combinations(motion.points, ready.lines.stages(ready.system), tones, speed)
    radius = ready.system.dofs.radius[:, None]
    return {
        "combination_force": (("mesh", "combination"), force.amplitude[:, 0, 0, : len(labels)]),
        "combination_displacement": (("dof", "combination"), radius * motion.amplitude[:, 0, 0]),
        "combination_frequency": ("combination", frequency),
    }, {"combination": labels}


def _line_variables(ready: Response, block: Block, shafts: Spectrum | None, theta: Array) -> dict[str, Any]:
    """Shaft lines: envelopes over each mesh's own phase theta (Nt,), and largest amplitudes over all phases [N]."""
    m, count = len(mesh_axis(ready)), len(ready.lines.shaft)
    speed = float(block.speed[0])
    force, largest = np.zeros((m, count, theta.size), complex), np.zeros((m, count))
    if shafts is not None:
        force = _by_mesh(ready, shafts, theta)
        *harmonics, cross = block.truncation
        least = 128 if len(harmonics) == 1 else 32
        grid = [max(least, alias_free_samples(ready, H)) for H in harmonics]
        values = np.abs(torus_waveform(shafts, grid, cross)[:, 0])
        largest = values.reshape(m, count, -1).max(axis=2)
    return {
        "line_force": (("mesh", "line", "mesh_phase"), force),
        "line_amplitude": (("mesh", "line"), largest),
        "line_frequency": ("line", np.array([float(shaft.frequency) * speed for shaft in ready.lines.shaft])),
    }


def sweep(
    system: System,
    options: SweepOptions,
    *,
    progress: Callable[[int, int], None] | None = None,
    kept: RunFolder | None = None,
) -> xr.Dataset:
    """Mesh forces, bearing forces and motion over speed for linear contact, as docs/theory/response.md defines.

    With shaft orders the RMS is that of all time (Parseval), and the peak and the minimum are bounds over all
    relative phases, max over theta of f0 + sum |A_s|: teeth meet at discrete phases, so a bound may lie up to
    1 - cos(pi/z) of a line above what is reached, and with common tooth factors further.  Amplitudes likewise.
    Several mesh frequencies take all combinations of their phases too; the amplitude then adds the range of each.

    Parameters
    ----------
    progress : called with (points done, points) after every chunk; an exception in it ends the sweep.
    kept : keeps the speeds that are done.

    Raises
    ------
    ModelError : no damping, no mesh frequency, torques out of balance, or an option out of range.
    A single speed that fails holds nan, and ``status`` says why.
    """
    ready = response(system, frame_speed=options.frame_speed)
    speed = speeds_of(ready, options)
    table = solved_table(ready, speed, options, progress=progress, kept=kept)
    warnings = [*ready.system.warnings, *([] if options.forces_alone else turn_warnings(system))]
    warnings += instability_warnings(ready, speed[table.status == MEAN_UNSTABLE])
    if lost := int((~np.isin(table.status, ("ok", MEAN_UNSTABLE, NO_SPEED))).sum()):  # the balance did not converge
        where = f"at {lost} of {speed.size} speeds: see status; the largest values are those of the others"
        warnings.append(coded("no-motion-found", f"no motion was found {where}"))
    warnings += tension_warnings(ready.system, table.minimum_force, table.values["dynamic_factor"])
    warnings += factor_warnings(ready.system, table.values["dynamic_factor"])
    return sweep_dataset(table, ready, speed, options, warnings)


def solved_table(
    ready: Response,
    speed: Array,
    options: SweepOptions,
    *,
    progress: Callable[[int, int], None] | None = None,
    kept: RunFolder | None = None,
) -> SweepTable:
    """The filled table of a sweep over relative speeds (P,); progress, kept : as of `sweep`."""
    orders, shafts, harmonics = options.orders, options.shaft_orders, options.forces_alone
    table = empty_table(ready, speed.size, orders=orders, shafts=shafts, harmonics=harmonics)
    usable = np.isfinite(speed) & (speed > 0)
    table.status[~usable] = NO_SPEED
    unstable = np.zeros(speed.size, dtype=bool)
    unstable[usable] = unstable_speeds(ready, speed[usable])
    table.status[unstable] = MEAN_UNSTABLE
    usable &= ~unstable
    solved, done = np.flatnonzero(usable), int((~usable).sum())

    def fill(_: int, blocks: list[_Measured]) -> None:
        """Write the blocks of one part into the table."""
        nonlocal done
        for block in blocks:
            block.fill(table, solved[block.index])
            done += block.index.size
            if progress is not None:
                progress(done, speed.size)

    parts = response_parts(ready, speed[usable], shaft_orders=options.shaft_orders)
    work = partial(_measured, ready, speed[usable], table.layout, options)
    each(work, parts, arrived=fill, kept=None if kept is None else kept.part("speeds"), meanwhile=import_results)
    return table


@dataclass(frozen=True, slots=True, eq=False)
class _Measured:
    """Measures of one block of speeds.

    values : by name, speeds last, not finite where nothing was found.
    minimum : smallest force of every mesh row (m, P) [N].
    The other fields as of `Block`.
    """

    index: NDArray[np.int64]
    truncation: Truncation
    values: dict[str, NDArray[Any]]
    minimum: Array
    residual: Array
    status: list[str]

    def fill(self, table: SweepTable, index: NDArray[np.int64]) -> None:
        """Write the measures at the speeds `index` (P,), nan where they did not converge."""
        good = np.array([text == "ok" for text in self.status])
        for name in self.values.keys() & table.values.keys():
            table.values[name][..., index] = np.where(good, self.values[name], np.nan)
        table.minimum_force[:, index] = np.where(good, self.minimum, np.nan)
        table.values["residual"][index] = self.residual
        *harmonics, table.cross_order[index] = self.truncation
        table.harmonics[index] = max(harmonics)
        table.status[index] = self.status


def _measured(
    ready: Response,
    speed: Array,
    layout: Layout,
    options: SweepOptions,
    part: tuple[NDArray[np.int64], Truncation],
) -> list[_Measured]:
    """Measures of one part of the speeds (P,), block by block."""
    blocks = respond_part(ready, speed, part, tolerance=options.tolerance, shaft_orders=options.shaft_orders)
    return [_block_measures(ready, block, layout, options) for block in blocks]


def _block_measures(ready: Response, block: Block, layout: Layout, options: SweepOptions) -> _Measured:
    """Measures of one block, of the mesh forces alone where only these are asked for."""
    accepted, forces_alone = _ACCEPTED * options.tolerance, options.forces_alone
    face = faces(ready.system.meshes)
    rows, motion = force_signal(ready, block), motion_signal(ready, block)
    with np.errstate(all="ignore"):  # a point that overflows is not finite, beside the others
        values: dict[str, NDArray[Any]] = {
            **sweep_measures(
                layout,
                speed=block.speed,
                force=whole_mesh_signal(rows, face),
                motion=None if forces_alone else motion,
                links=link_signal(ready, block) if ready.system.links.name and not forces_alone else None,
                errors=error_signal(ready, block) if ready.system.errors.mesh and not forces_alone else None,
            )
        }
        if ready.system.sensors.name and not forces_alone:
            values |= sensor_measures(ready, block, layout.orders)
        if forces_alone:
            first = np.zeros(len(layout.radius), dtype=np.int64)
            harmonics = order_harmonics(motion, first, layout.orders)
            values["displacement_harmonic"] = layout.radius[:, None, None] * harmonics
    status = []
    for residual, uncertainty in zip(block.residual, block.uncertainty, strict=True):
        if not np.isfinite(residual):
            status.append("not finite")
        elif residual > accepted:
            status.append("not converged")
        else:
            status.append("ok" if uncertainty <= accepted else "resonance too sharp for double precision")
    minimum = force_extremes(rows, axis=ready.lines.axis)[0] if face.cut.any() else values["mesh_force_minimum"]
    return _Measured(block.index, block.truncation, values, minimum, block.residual, status)
