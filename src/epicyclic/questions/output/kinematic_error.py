"""Kinematic error of a shaft: its rotation less that which the ratio makes of the driving shaft, over its turns.

The train turns slowly under a share of the rated torque, all torques of the operation in that proportion: flanks open
and close where the deviations are larger than what yields.  The record is the common period of all lines where that is
not too long, so that orders are exact.  The row of rotations is that of `system.transmission_rows`, whose lag is
positive; the error is its negative.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...errors import ModelError
from ...statics.record import Record, record_of
from ...statics.static import held_train, quasi_static
from ...statics.transmission_error import Columns, error_ranges, largest_lines, line_label
from ...system.assembly import assemble
from ...system.system import Array, System
from ...train.train import Train, bodies_named
from ...warning_codes import CodedText
from .locked_train import OutputShaft

# Instants per cycle of the fastest mesh or line, the most of a record, and part of the displacements that is rounding.
_SAMPLES, _MOST, _ROUNDING = 12, 2**14, 1e-9


def kinematic_error(
    train: Train, shaft: OutputShaft, share: float, *, most: int = _MOST
) -> tuple[Columns, list[CodedText]]:
    """Columns of the kinematic error of a shaft under a share of its rated torque, and warnings of a record cut short.

    most : instants of the record, unless a turn has more.

    Raises
    ------
    ModelError : no speed or torque of the shaft, it is what drives; a load that nothing holds.
    ConvergenceError : no equilibrium.
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
    error = -(displacement - displacement.mean(axis=0)) @ column
    said = record.warnings(error.min(keepdims=True), error.max(keepdims=True))
    return _columns(system, shaft.name, record, error, rounding), said


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
    part = "" if record.count % record.period == 0 else "record"
    ranges = error_ranges(system, error[None], record.count / record.unit, part)
    amplitude = np.abs(np.fft.rfft(error)) * (2 / error.size)
    listed = largest_lines(np.where(amplitude > rounding, amplitude, 0.0)[None])
    causes = [line_label(system, int(step) * record.unit / record.count) for step in listed]
    return {
        "kinematic_error": ("shaft_turn", error),
        "kinematic_error_peak_to_peak": ((), ranges[f"turn of {shaft}"][0]),
        "kinematic_error_order": ("shaft_order", amplitude[listed]),
        "shaft_turn": ("shaft_turn", np.arange(error.size) / record.samples),
        "shaft_order": ("shaft_order", listed / record.count),
        "shaft_order_cause": ("shaft_order", np.array(causes, dtype=object)),
    }
