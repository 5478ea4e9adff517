"""Signals of a motion: transmission errors of meshes and shafts, and sensors.

The rows are those of `system.signal_rows`.  Ranges and orders of errors are exact sums of lines (derived here); sensors
over time follow from displacements and forces.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..system.system import Array, ComplexArray, ErrorRows, SensorRows, System
from .record import Record, turn_fraction

# Samples per cycle of the highest order of a waveform, and the most of one.
_SAMPLES, _MOST = 32, 2**20
# Lines listed at most, the least part of a row that one makes, and rows that are rounding per the largest.
_LINES, _SMALL, _ROUNDING = 24, 1e-3, 1e-9
# Part of the largest line of a row below which a line is left out of ranges.
_NEGLIGIBLE = 1e-6


Columns = dict[str, tuple[Sequence[str] | str, Any]]


def error_waves(errors: ErrorRows, waves: Array, along: str) -> Columns:
    """Variables of the errors' waveforms (k, N) over a dimension; of shafts the mean, the wind-up, is apart."""
    columns: Columns = {}
    for kind, (dim, values) in errors.by_kind(waves).items():
        if kind == "shaft":
            mean = values.mean(axis=1, keepdims=True, where=np.isfinite(values))
            columns["wind_up"], values = (dim, mean[:, 0]), values - mean
        columns[f"transmission_error_{kind}"] = ((dim, along), values)
    return columns


def record_errors(system: System, displacement: Array, record: Record) -> tuple[Columns, dict[Hashable, Any]]:
    """Variables and coordinates of the errors over a record of displacements (T, n) [m, rad].

    The common period of all lines alone shows what they are; a range over less is named after the length of the record.
    """
    if not system.errors.mesh:
        return {}, {}
    waves, length = (displacement @ system.error_rows).T, record.count / record.unit
    part = "" if record.count % record.period == 0 else f"{record.count} {record.name}"
    # what changes sign from instant to instant is left out: it stands for orders beyond, too
    amplitude = np.fft.rfft(waves, axis=1)[:, 1 : 1 if part else (len(displacement) + 1) // 2] * (2 / len(displacement))
    frequency = [(step + 1) / length for step in range(amplitude.shape[1])]
    ranges, labels = range_columns(system, error_ranges(system, waves, length, part), frequency, amplitude)
    return {**error_waves(system.errors, waves, "time"), **ranges}, labels


def run_errors(system: System, displacement: Array) -> Columns:
    """Variables of the errors over time and their ranges, of displacements (n, T) [m, rad]."""
    waves = system.error_rows.T @ displacement
    with np.errstate(invalid="ignore"):
        spans = np.fmax.reduce(waves, axis=1) - np.fmin.reduce(waves, axis=1)
    return {**error_waves(system.errors, waves, "time"), **peaks_to_peaks(system.errors, spans)}


def peaks_to_peaks(errors: ErrorRows, spans: Array) -> dict[str, tuple[str, Array]]:
    """Dimension and values by the names of the variables, of the ranges (k, ..) of errors; nothing without errors."""
    return {f"transmission_error_{kind}_peak_to_peak": part for kind, part in errors.by_kind(spans).items()}


def range_columns(
    system: System, ranges: dict[str, Array], frequency: Sequence[Fraction], amplitude: ComplexArray
) -> tuple[Columns, dict[Hashable, Any]]:
    """Variables and coordinates of the ranges (k,) of errors over periods, and of their largest lines (k, F).

    frequency : (F,) of the lines, exact [Hz at the operating speed].
    """
    errors, shown = system.errors, largest_lines(np.abs(amplitude))
    lines = [frequency[place] for place in shown]
    spans = np.stack(list(ranges.values()), axis=1)
    columns: Columns = {}
    for suffix, dim, values in (("range", "period", spans), ("line", "error_line", np.abs(amplitude[:, shown]))):
        for kind, (row, part) in errors.by_kind(values).items():
            columns[f"transmission_error_{kind}_{suffix}"] = ((row, dim), part)
    return columns, {
        "period": list(ranges),
        "error_line": np.array([line_label(system, line) for line in lines], dtype=object),
        "error_line_frequency": ("error_line", np.array([float(line) for line in lines])),
        **({"shaft": list(errors.shaft)} if errors.shaft else {}),
    }


def error_ranges(
    system: System, wave: Array, period: Fraction, part: str = "", spectrum: ComplexArray | None = None
) -> dict[str, Array]:
    """Ranges (k,) of errors over mesh cycles, turns of shafts and the common period, by their names.

    ``mesh cycle``: of the multiples of a mesh frequency alone, which every cycle repeats; of the common period alone,
    as shaft lines leak into a part of it.  ``turn``: the largest range within any one turn of a shaft.

    Parameters
    ----------
    wave : (k, N) over a period or a record.  period : its length, exact [s at the operating speed].  part : name of a
        record that is not the common period of all lines.  spectrum : (k, N // 2 + 1) of the waves, where it is known.
    """
    if spectrum is None and not part:
        spectrum = np.fft.rfft(wave, axis=1)
    ranges: dict[str, Array] = {}
    for name, tone in _mesh_cycles(system).items():
        if spectrum is not None and (cycles := tone * period).denominator == 1 and 2 * cycles < wave.shape[1]:
            orders = np.zeros_like(spectrum)
            orders[:, :: int(cycles)] = spectrum[:, :: int(cycles)]
            ranges[name] = np.ptp(np.fft.irfft(orders, wave.shape[1], axis=1), axis=1)
    turns = {f"turn of {shaft}": abs(turn * period) for shaft, turn in system.errors.turn.items() if turn}
    shares = {name: float(1 / count) for name, count in turns.items() if not part or count >= 1}
    ranges |= zip(shares, _largest_ranges(wave, list(shares.values()), periodic=not part), strict=True)
    return {**ranges, part or "common period": np.ptp(wave, axis=1)}


def ranges_of_lines(
    system: System, amplitude: ComplexArray, frequency: Sequence[Fraction], bound: Array
) -> dict[str, Array]:
    """`error_ranges` of sums of lines; where their common period is too long of mesh cycles, and over all phases.

    Parameters
    ----------
    amplitude : (k, F) complex, value = Re sum_f amplitude_f exp(2 pi i frequency_f t).  frequency : (F,) exact, from 0
        [Hz at the operating speed].  bound : (k,) ranges over all phases.
    """
    size = np.abs(amplitude)
    kept = np.flatnonzero((size > _NEGLIGIBLE * size.max(axis=1, initial=0.0, keepdims=True)).any(axis=0)).tolist()
    amplitude, frequency = amplitude[:, kept], [frequency[place] for place in kept]
    whole = _common_period(amplitude, frequency)
    if whole is not None:
        wave, length, spectrum = whole
        return error_ranges(system, wave, length, spectrum=spectrum)
    ranges: dict[str, Array] = {}
    for name, tone in _mesh_cycles(system).items():
        own = [place for place, one in enumerate(frequency) if (one / tone).denominator == 1]
        cycle = _common_period(amplitude[:, own], [frequency[place] for place in own])
        ranges |= {} if cycle is None else {name: np.ptp(cycle[0], axis=1)}
    return {**ranges, "all phases": bound}


def _common_period(
    amplitude: ComplexArray, frequency: Sequence[Fraction]
) -> tuple[Array, Fraction, ComplexArray] | None:
    """Waveforms (k, N) of lines over their common period, its length [s], spectrum; None where that is too long."""
    unit = math.lcm(*(one.denominator for one in frequency))
    steps = [int(one * unit) for one in frequency]
    base = math.gcd(*steps)
    orders = [step // (base or 1) for step in steps]
    if not base or max(orders) * _SAMPLES > _MOST:
        return None
    count = max(1024, 1 << (max(orders) * _SAMPLES - 1).bit_length())
    spectrum = np.zeros((len(amplitude), count // 2 + 1), complex)
    spectrum[:, np.array(orders)] = amplitude * (count / 2)
    spectrum[:, 0] = 0.0  # the mean is in no range
    return np.fft.irfft(spectrum, count, axis=1), Fraction(unit, base), spectrum


def _mesh_cycles(system: System) -> dict[str, Fraction]:
    """Mesh frequency [Hz] of every mesh cycle by its name, of several those of their stages."""
    tones = _stage_tones(system)
    return {"mesh cycle" if len(tones) == 1 else f"mesh cycle of {stage}": tone for stage, tone in tones.items()}


def _stage_tones(system: System) -> dict[str, Fraction]:
    """Mesh frequency [Hz] of every stage, those that are equal once; 1 Hz, a mesh cycle, without speeds."""
    if not system.tones:
        return {"": Fraction(1)}
    tones: dict[Fraction, str] = {}
    for tone, stage in zip(system.meshes.tone, system.meshes.stage, strict=True):
        tones.setdefault(system.tones[tone], stage)
    return {stage: tone for tone, stage in tones.items()}


def _largest_ranges(wave: Array, shares: Sequence[float], *, periodic: bool) -> Array:
    """Largest ranges of waveforms (k, N) within windows of shares of their length, (s, k); of a record, inside it."""
    N = wave.shape[1]
    sizes = [math.ceil(share * N) + 1 for share in shares]
    longest = N + min(max(sizes, default=1) - 1, N) if periodic else N
    ranges, rooms = np.zeros((len(sizes), len(wave))), np.empty((3, 2, longest))

    def of_two(high: Array, low: Array, step: int, room: Array) -> Array:
        """Highest and lowest of two windows a step apart, (2, ..), in a place for them: new memory takes longer."""
        count = high.size - step
        np.maximum(high[:count], high[step:], out=room[0, :count])
        np.minimum(low[:count], low[step:], out=room[1, :count])
        return room[:, :count]

    for row, one in enumerate(wave):  # one by one: they are long
        high = low = np.concatenate([one, one[: longest - N]])
        width = 1
        for place in np.argsort(sizes, kind="stable").tolist():
            most = min(sizes[place], longest)
            while 2 * width <= most:
                high, low = of_two(high, low, width, rooms[width.bit_length() % 2])
                width *= 2
            above, below = of_two(high, low, most - width, rooms[2])
            ranges[place, row] = np.subtract(above, below, out=above).max()
    return ranges


def largest_lines(amplitude: Array) -> NDArray[np.int64]:
    """The lines (F,) with the largest parts of the rows (k, F), in their order."""
    largest = amplitude.max(axis=1, initial=0.0)
    rows = largest > _ROUNDING * largest.max(initial=0.0)
    part = (amplitude[rows] / largest[rows, None]).max(axis=0, initial=0.0)
    most = np.sort(np.argsort(-part, kind="stable")[:_LINES])
    return np.asarray(most[part[most] >= _SMALL])


def near_lines(system: System, frequency: Fraction, within: Fraction) -> list[Fraction]:
    """Mesh orders and lines near a frequency, those of the lowest mesh order; the frequency itself where there is none.

    frequency, within : exact [Hz at the operating speed].
    """
    shifts = [Fraction(0), *(sense * line.frequency for line in system.lines for sense in (1, -1))]
    near = dict[Fraction, int]()
    for tone in _stage_tones(system).values():
        for shift in shifts:
            order = round((frequency - shift) / tone)
            if abs(order * tone + shift - frequency) <= within:
                near.setdefault(order * tone + shift, abs(order))
    lowest = min(near.values(), default=0)
    return [one for one, order in near.items() if order == lowest] or [frequency]


def line_label(system: System, frequency: Fraction) -> str:
    """Mesh order, or what makes a shaft line (the file, links that pass) and the mesh orders that shift it."""
    tones, passing = _stage_tones(system), system.passing
    beside = [(line.frequency, "; ".join(line.causes)) for line in system.lines if line.frequency]
    if passing is not None:
        turns = {link: passing.tones[tone] for link, tone in zip(passing.link, passing.tone, strict=True)}
        orders = range(1, passing.wave.shape[1] + 1)
        beside += [(k * turn, f"{k} x {link} passing") for link, turn in turns.items() for k in orders]
    for stage, tone in tones.items():
        if (frequency / tone).denominator == 1:
            return f"{frequency / tone} x {stage} mesh".replace("  ", " ")
    for stage, tone in tones.items():
        for shift, causes in beside:
            for sense in (1, -1):
                order = (frequency - sense * shift) / tone
                if order.denominator == 1:
                    return f"{order} x {stage} mesh {'+' if sense > 0 else '-'} ({causes})" if order else causes
    return f"{float(frequency / next(iter(tones.values()))):.5g} x mesh"


def sensor_labels(sensors: SensorRows, chosen: list[int] | None = None) -> tuple[Columns, dict[Hashable, Any]]:
    """Variables that say what sensors are, all or those chosen, and their coordinate; nothing without sensors."""
    chosen = list(range(len(sensors.name))) if chosen is None else chosen
    if not chosen:
        return {}, {}
    kinds = {"sensor_kind": sensors.kind, "sensor_unit": sensors.unit, "sensor_direction": sensors.direction}
    columns: Columns = {name: ("sensor", np.array([of[i] for i in chosen], object)) for name, of in kinds.items()}
    return columns, {"sensor": [sensors.name[i] for i in chosen]}


def record_sensors(
    system: System, record: Record, displacement: Array, mesh: Array, link: Array
) -> tuple[Columns, dict[Hashable, Any]]:
    """Signals of a train that turns slowly, over a record; nothing accelerates there, so accelerations are left out.

    displacement : (T, n) [m, rad].  mesh : (T, m) of the mesh rows, link : (p, T) [N, N m].
    """
    sensors = system.sensors
    chosen = [i for i, kind in enumerate(sensors.kind) if kind != "acceleration"]
    if not chosen:
        return {}, {}
    phase = np.array([turn_fraction(turn / record.unit / record.samples, record.index) for turn in sensors.turn])
    signal = sensors.mesh @ mesh.T + sensors.link @ link + motion_signals(sensors, phase, displacement[:, None])
    columns, labels = sensor_labels(sensors, chosen)
    return {**columns, "sensor_signal": (("sensor", "time"), signal[chosen])}, labels


def motion_signals(
    sensors: SensorRows, phase: Array, states: Array, speed: Array | None = None, rate: Array | None = None
) -> Array:
    """Signals (s, T) that displacements make; those of torques, and without speed those of accelerations, are 0.

    Parameters
    ----------
    phase : (s, T) turns of the material.  states : (T, 3, n) q, q', q'', or (T, 1, n) q alone.
    speed, rate : (T,) relative speed s [1] and s' [1/s].
    """
    signal = np.zeros((len(sensors.name), len(states)))
    order = np.arange(sensors.rows.shape[2])
    for i, (kind, rows) in enumerate(zip(sensors.kind, sensors.rows, strict=True)):
        wave = np.exp(2j * np.pi * np.outer(phase[i], order))
        if kind != "acceleration":
            signal[i] = (wave * (states[:, 0] @ rows[0].T)).sum(axis=1).real
        elif speed is not None and rate is not None:
            turning = 2j * np.pi * float(sensors.turn[i]) * order
            s, ramp = speed[:, None], rate[:, None]
            q = states[:, None] @ rows.transpose(0, 2, 1)  # (T, 3 of rows, 3 of states, K + 1)
            by_frame = s**2 * q[:, 0, 0] + s * (q[:, 1, 1] + s * turning * q[:, 1, 0]) + ramp / 2 * q[:, 1, 0]
            own = q[:, 2, 2] + 2 * s * turning * q[:, 2, 1] + (s**2 * turning**2 + ramp * turning) * q[:, 2, 0]
            signal[i] = (wave * (by_frame + own)).sum(axis=1).real
    return signal
