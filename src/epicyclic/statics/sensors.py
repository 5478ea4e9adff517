"""Signals of sensors over time, from displacements and forces; the rows are those of `system.signal_rows`."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np

from ..system.system import Array, SensorRows, System
from .record import Record, turn_fraction
from .transmission_error import Columns


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
