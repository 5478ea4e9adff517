"""Ripple of torque and imposed motion at the shafts of a train, as components of exact frequency.

A component is A cos(order theta + phase) with theta the angle that a shaft has turned, or A cos(2 pi f t + phase).  A
table of N equally spaced torques over n whole turns is the sum of its discrete Fourier series, orders k / n up to
k = N / 2, which passes through every point.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np

from ..document.schema import ModelFile
from ..document.schema_fields import RippleTable
from ..errors import ModelError
from .kinematics import Kinematics
from .train import DIRECTIONS, Body, Link, ResolutionLog, Ripple

# Angles of a table may be off by this part of their step, as printed; a torque of a table below this share of the
# largest is rounding of the transform; a mean off the torque of the operation by this share of the largest is told.
_EVEN, _NONE, _MEAN = 1e-3, 1e-12, 0.01
_ABOUT_THE_AXIS = tuple(math.inf if direction == "rz" else 0.0 for direction in DIRECTIONS)
_UNITS = {"frequency": "Hz", "torque": "N m", "angle": "rad", "speed": "rad/s", "phase": "rad"}


def resolve_ripples(
    model: ModelFile, bodies: Sequence[Body], kinematics: Kinematics, log: ResolutionLog
) -> tuple[list[Ripple], list[Link]]:
    """Components of all ripples, on a split member half on each half, and the rigid links of prescribed shafts.

    Without speeds, and of a locked train, all are left out with a warning.

    Raises
    ------
    ModelError : a held member, a planet gear, a shaft that stands still, torque and motion at one shaft, a table that
        is not equally spaced over whole turns.
    """
    ripples, links, prescribed = list[Ripple](), list[Link](), list[str]()
    stated = {name: parts for name, parts in model.operation.ripple.items() if parts}
    where = f"{model.operation_path('ripple')}.ripple"
    if stated and (kinematics.speed is None or kinematics.locked):
        why = "the train is locked" if kinematics.locked else "no speed is given (operation.speed)"
        log.coded("ripple-without-speed", f"{why}: left out is the ripple of {', '.join(stated)}")
        stated = {}
    for member, parts in stated.items():
        path, pieces = f"{where}.{member}", [body for body in bodies if body.member == member]
        if member in kinematics.held:
            problem, allowed = "is held: a torque there goes into the ground", "a member that turns"
            raise ModelError(problem, path=path, given=member, allowed=allowed)
        if pieces[0].branch is not None:
            raise ModelError("is a planet gear", path=path, given=member, allowed="a central member or body")
        moved = [name for name, part in parts.items() if part.angle is not None or part.speed is not None]
        prescribed += [member] if moved else []
        if len(prescribed) > len(kinematics.freedoms):
            problem = f"the motion of {' and '.join(prescribed)} is imposed, and no torque passes from one to the other"
            raise ModelError(problem, path=path, allowed="one imposed motion for each freedom, torques at other shafts")
        if moved and len(moved) < len(parts):
            problem = "prescribes the motion of a shaft with a torque ripple"
            raise ModelError(problem, path=f"{path}.{moved[0]}", allowed="torques alone, or angles and speeds alone")
        prescribing = {body.name: f"{body.name}/prescribed" for body in pieces if moved}
        if not moved:
            _warn_of_inertia(model, member, kinematics, log)
        for name, part in parts.items():
            for key, value in part.model_dump(exclude_none=True, exclude={"angles", "torques"}).items():
                log.note(f"{path}.{name}.{key}", str(value) if key == "order" else value, _UNITS.get(key, ""))
            ripples += [
                Ripple(
                    path=f"{path}.{name}",
                    body=body.name,
                    link=prescribing.get(body.name, ""),
                    amplitude=amplitude if moved else amplitude / len(pieces),
                    frequency=frequency,
                    follows=part.frequency is None,
                )
                for frequency, amplitude in _waves(part, member, f"{path}.{name}", kinematics, log)
                for body in pieces
            ]
        links += [
            Link(name=name, path=path, kind="support", first=body, second=None, stiffness=_ABOUT_THE_AXIS)
            for body, name in prescribing.items()
        ]
    return ripples, links


def _waves(
    part: RippleTable, member: str, path: str, kinematics: Kinematics, log: ResolutionLog
) -> Iterator[tuple[Fraction, complex]]:
    """Signed frequency [Hz] and complex amplitude [N m, rad] of every wave of a component. Raises ModelError."""
    shaft = part.of or member
    turn = Fraction((kinematics.speed or {}).get(shaft, 0)) / 60
    if not turn and part.frequency is None:
        where, allowed = f"{path}.{'order' if part.order else 'angles'}", "of = a member that turns, or frequency"
        raise ModelError(f"{shaft} stands still, no turn of it counts", path=where, allowed=allowed)
    if part.angles is None:
        frequency = (part.order or 0) * turn or Fraction(part.frequency or 0.0).limit_denominator(10**6)
        amplitude = part.torque or part.angle or (part.speed or 0.0) / (1j * math.tau * float(frequency))
        yield frequency, complex(amplitude * np.exp(1j * (part.phase or 0.0)))
        return
    turns, values = _even_table(part, path)
    torque = 0.0 if kinematics.torque is None else kinematics.torque[member]
    mean, largest = values.mean(), np.abs(values).max()
    if abs(mean) > _NONE * largest and abs(mean - torque) > _MEAN * largest:
        text = f"{path}: the mean of its torques is {mean:.5g} N m, the torque of {member} {torque:.5g} N m"
        log.coded("ripple-mean", f"{text}, which counts")
    harmonics = np.fft.rfft(values)[1:] * (2 / values.size)
    if values.size % 2 == 0:
        harmonics[-1] /= 2
    for k, harmonic in enumerate(harmonics.tolist(), start=1):
        if abs(harmonic) > _NONE * largest:
            order = Fraction(k, turns)
            yield order * turn, complex(harmonic * np.exp(-1j * float(order) * part.angles[0]))


def _even_table(part: RippleTable, path: str) -> tuple[int, np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """Whole turns and torques (N,) [N m] of a table, one that repeats at the end left out. Raises ModelError."""
    angles, values = np.array(part.angles), np.array(part.torques)
    step = (angles[-1] - angles[0]) / (angles.size - 1)
    even = step > 0 and np.all(np.abs(angles - angles[0] - step * np.arange(angles.size)) <= _EVEN * step)
    for count in (angles.size, angles.size - 1):
        turns = round(count * step / (2 * math.pi))
        if even and turns and abs(count * step - 2 * math.pi * turns) <= _EVEN * step:
            if count < angles.size and abs(values[-1] - values[0]) > _EVEN * np.abs(values).max():
                problem = "does not return to its first torque after whole turns"
                raise ModelError(problem, path=f"{path}.torques", given=values[-1], allowed=f"{values[0]:g} N m")
            return turns, values[:count]
    allowed = "equal steps over whole turns: 0, 10, ..., 350 deg"
    raise ModelError("no equally spaced angles of whole turns", path=f"{path}.angles", allowed=allowed)


def _warn_of_inertia(model: ModelFile, member: str, kinematics: Kinematics, log: ResolutionLog) -> None:
    """Warn where the inertia at a shaft with a torque ripple is that of its gear alone."""
    stage, _, name = member.rpartition(".")
    table = model.stages[stage].members[name] if stage else model.bodies[member]
    halves = (getattr(table, side, None) for side in ("left", "right"))
    if any(one is not None and one.inertia is not None for one in (table, *halves)):
        return
    others = {end for tie in kinematics.ties if member in (tie.a, tie.b) for end in (tie.a, tie.b)} - {member}
    if not any(end in model.bodies and model.bodies[end].inertia for end in others):
        text = f"the inertia of the machine at {member} is not given: its torque ripple acts on that of the gear alone"
        log.coded("ripple-without-inertia", text)
