"""Deviations of ISO class 6, offered where a model gives none: the rule of `epicyclic new`, under `[assumed]`."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...document.writer import quantity_text
from ...teeth.grades import run_out_width
from ...train.bodies import Body
from ...train.train import Train

__all__ = ["class_six"]

_GRADE = 6  # ISO 1328-1 class of ground planetary gears
_PIN = 20e-6  # [m] what the pin of planet 1 is off, tangentially
# Least sizes that the formulas of ISO 1328-1 cover [m].
_DIAMETER, _MODULE = 5e-3, 0.5e-3


def class_six(train: Train) -> Mapping[str, object]:
    """Overrides: half the run-out F_rT of class 6 on every gear, the pin of planet 1 of each stage 20 um off.

    The paths of what is assumed stand beside, under ``assumed``, with their reason.  A gear without module is left out.
    """
    values: dict[str, object] = {}
    reasons: dict[str, object] = {}
    several = len(train.planets) > 1
    gears: dict[str, Body] = {}
    for body in train.bodies:
        if body.gear is not None and body.frame in train.planets:
            gears.setdefault(body.member, body)
    for member, body in gears.items():
        path = f"deviations.{member if several else member.rpartition('.')[2]}"
        radius, module = (0.0, 0.0) if body.gear is None else (body.gear.reference_radius, body.gear.module)
        if not (module > 0 and math.isfinite(radius) and radius > 0):
            continue
        width = run_out_width(max(2 * radius, _DIAMETER), max(module, _MODULE), _GRADE)
        _put(values, reasons, f"{path}.run_out", quantity_text(round(width / 2, 7), "length"), _run_out_reason())
    for stage, count in train.planets.items():
        carried = next((m for m, body in gears.items() if body.frame == stage and body.carried_by is not None), None)
        if carried is None or count < 2:
            continue
        path = f"deviations.{carried if several else carried.rpartition('.')[2]}.position.y"
        zeros = ", 0" * (count - 1)
        reason = "one pin, that of planet 1, stands 20 um off along the circle of pins"
        _put(values, reasons, path, f"[{_PIN * 1e6:g}{zeros}] um", reason)
    return {**values, **reasons}


def _run_out_reason() -> str:
    return f"half of the run-out F_rT of class {_GRADE} of ISO 1328-1:2013"


def _put(values: dict[str, object], reasons: dict[str, object], path: str, value: object, reason: str) -> None:
    values[path] = value
    reasons[f'assumed."{path}"'] = reason
