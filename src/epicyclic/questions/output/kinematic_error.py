"""Kinematic error of a shaft: its rotation less that which the ratio makes of the driving shaft, over its turns.

The train turns slowly under a share of the rated torque, all torques of the operation in that proportion: flanks open
and close where the deviations are larger than what yields.  The record is the common period of all lines, as far as it
goes; amplitudes at the exact orders of the shaft are those of least squares.  The row of rotations is that of
`system.signal_rows`, whose lag is positive; the error is its negative.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np

from ...errors import ModelError
from ...statics.record import Record, record_of, turn_fraction
from ...statics.static import held_train, quasi_static
from ...statics.transmission_error import Columns, error_ranges, largest_lines, line_label, near_lines
from ...system.assembly import assemble
from ...system.system import Array, System
from ...train.train import Train, bodies_named
from ...warning_codes import CodedText, coded
from .locked_train import OutputShaft

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
    return _columns(system, shaft.name, record, error, rounding), said


def error_range(train: Train, shaft: OutputShaft, share: float, most: int) -> float:
    """Largest range within a turn of the kinematic error [rad]; as of `kinematic_error`, without its orders.

    most : instants of the record, unless a turn has more.
    """
    system, record, error, _ = _turned(train, shaft, share, most)
    return _range(system, shaft.name, record, error)


def _turned(train: Train, shaft: OutputShaft, share: float, most: int) -> tuple[System, Record, Array, float]:
    """The train as it turns slowly, the record, the error over it (T,) [rad] and amplitude that is rounding."""
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


def _columns(system: System, shaft: str, record: Record, error: Array, rounding: float) -> Columns:
    """Error (T,) [rad] over a record, its range and orders; rounding : amplitude that is none."""
    frequency, amplitude = _lines(system, record, error, rounding)
    return {
        "kinematic_error": ("shaft_turn", error),
        "kinematic_error_peak_to_peak": ((), _range(system, shaft, record, error)),
        "kinematic_error_order": ("shaft_order", amplitude),
        "shaft_turn": ("shaft_turn", np.arange(error.size) / record.samples),
        "shaft_order": ("shaft_order", np.array([float(one / record.unit) for one in frequency])),
        "shaft_order_cause": ("shaft_order", np.array([line_label(system, one) for one in frequency], dtype=object)),
    }


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
