"""Sensors of a steady response: their lines at exact frequencies, also of material that turns against its frame.

A row that turns, Re(C exp(i k phi)) . q, makes of the line f of q the lines f + k nu and f - k nu, nu the speed of the
material against its frame, with half of C and of its conjugate.  Derived here.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any

import numpy as np

from ...statics.sensors import sensor_labels
from ...statics.transmission_error import Columns
from ...system.system import Array, ComplexArray
from .lattice import Integers, line_frequencies
from .response import Block, Response
from .spectra import force_signal, link_signal, row_signal

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
