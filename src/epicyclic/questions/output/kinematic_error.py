"""Kinematic error of a shaft: its rotation less that which the ratio makes of the driving shaft, over its turns.

The train turns slowly under a share of the rated torque, all torques of the operation in that proportion: flanks open
and close where the deviations are larger than what yields.  The record is the common period of all lines where that is
not too long, so that orders are exact.  The row of rotations is that of `system.transmission_rows`, whose lag is
positive; the error is its negative.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...errors import ConvergenceError, ModelError
from ...statics.record import Record, record_of
from ...statics.static import held_train, quasi_static
from ...statics.transmission_error import error_ranges
from ...system.assembly import assemble
from ...system.system import Array, System
from ...train.train import Train, bodies_named
from ...warning_codes import CodedText
from .locked_train import OutputShaft

# Instants per cycle of the fastest mesh or line, the most of a record, and lines that are listed at most.
_SAMPLES, _MOST, _LINES = 8, 2**14, 24
# Part of the largest line that is listed, and part of the displacements that is rounding.
_SMALL, _ROUNDING = 1e-3, 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KinematicError:
    """Kinematic error of a shaft.

    turn, error : (T,) turns of the shaft and error without its mean [rad].  peak_to_peak : largest within a turn [rad].
    order, amplitude : (F,) orders of the shaft, rising, and amplitudes [rad].  warnings : of a record cut short.
    """

    turn: Array
    error: Array
    peak_to_peak: float
    order: Array
    amplitude: Array
    warnings: tuple[CodedText, ...]


def kinematic_error(train: Train, shaft: OutputShaft, share: float) -> KinematicError | str:
    """Kinematic error of a shaft under a share of its rated torque, or why there is none."""
    kinematics = train.kinematics
    if kinematics.speed is None or not kinematics.speed[shaft.name]:
        return f"{shaft.name} does not turn in operation"
    torque = (kinematics.torque or {}).get(shaft.name, 0.0)
    if not torque:
        return f"no torque of operation at {shaft.name}"
    factor = abs(share * shaft.torque / torque)
    system = assemble(replace(train, torques={name: factor * value for name, value in train.torques.items()}))
    row = next((i for i, name in enumerate(system.errors.shaft) if name.startswith(f"{shaft.name} by ")), None)
    if row is None:
        return f"{shaft.name} is what drives"
    column = system.errors.B[:, 2 * len(system.errors.mesh) + row]
    try:
        record = _record(system, bodies_named(shaft.name, train.bodies)[0].name)
        pieces = list(quasi_static(held_train(system), record))
    except (ModelError, ConvergenceError) as error:
        return str(error)
    displacement = np.concatenate([piece.state.displacement for piece in pieces])
    rounding = _ROUNDING * float(np.abs(displacement).max(axis=0) @ np.abs(column))
    return _seen(system, shaft.name, record, -(displacement - displacement.mean(axis=0)) @ column, rounding)


def _record(system: System, body: str) -> Record:
    """The common period of all lines in turns of a body, as far as it goes."""
    turn = abs(system.body_turns[system.dofs.bodies.index(body)])
    fastest = max([*system.tones, *(line.frequency for line in system.lines)])
    samples = 1 << int(np.ceil(np.log2(_SAMPLES * float(fastest / turn))))
    return record_of(system, cycles=None, turns=None, of=body, samples=samples, most=max(_MOST, samples))


def _seen(system: System, shaft: str, record: Record, error: Array, rounding: float) -> KinematicError:
    """Ranges and orders of an error (T,) [rad] over a record; rounding : amplitude that is none."""
    whole = record.count % record.period == 0
    ranges = error_ranges(system, error[None], record.count / record.unit, whole=whole)
    amplitude = np.abs(np.fft.rfft(error)) * (2 / error.size)
    largest = np.sort(np.argsort(-amplitude, kind="stable")[:_LINES])
    listed = largest[amplitude[largest] > max(_SMALL * amplitude.max(), rounding)]
    return KinematicError(
        turn=np.arange(error.size) / record.samples,
        error=error,
        peak_to_peak=float(ranges[f"turn of {shaft}"][0]),
        order=listed / record.count,
        amplitude=amplitude[listed],
        warnings=tuple(record.warnings(error.min(keepdims=True), error.max(keepdims=True))),
    )
