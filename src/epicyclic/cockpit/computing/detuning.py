"""Changes that move the resonance of the answer away, as the page offers them: those of the verb `detune`."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from ...limits import NO_MATTER, RESONANCE_BAND
from ...questions.studies import DetuneOptions
from ...system.system import System
from ...train.train import Train
from ..state.frames import MINUS, Answer, OfferedChange, SpeedAxis, number, per_cent, signed_per_cent

if TYPE_CHECKING:
    import xarray as xr

# Changes that a line of the page has room for.
_MOST = 3
# Part of the force of the resonance that a change may leave in the band to be worth a button.
_LESS = 0.8
# Motions of a train whose changes are computed with a state at rest, within half a second; of others a job does it.
_QUICK = 60


def is_quick(train: Train, system: System) -> bool:
    """Whether the changes of a train are computed with every state at rest: none needs tooth contact anew."""
    return len(system.M) <= _QUICK and len(system.tones) == 1 and not any(mesh.table for mesh in train.meshes)


def offered_of(
    train: Train, axis: SpeedAxis | None, answer: Answer, relative_speed: float, *, told: Callable[[float], None]
) -> tuple[OfferedChange, ...]:
    """Changes that move the resonance of an answer away; told : called between two of them, and may raise."""
    from ...questions.studies.detune import detune

    result = detune(train, DetuneOptions(mode=answer.mode, relative_speed=relative_speed), progress=told)
    return changes_of(result, axis)


def changes_of(result: xr.Dataset, axis: SpeedAxis | None) -> tuple[OfferedChange, ...]:
    """The first changes of a result that leave clearly less in the band, or where that is not known move out of it."""
    found = json.loads(result.attrs["resonance"])
    now = math.nan if found.get("force_ratio") is None else float(found["force_ratio"])
    offered = []
    names = ("moved_speed", "moved_away", "left_force_ratio", "change_note", "change_overrides")
    columns = (result[name].values.tolist() for name in ("change", *names))
    for label, speed, away, left, note, overrides in zip(*columns, strict=True):
        out = abs(away) >= RESONANCE_BAND * (1 - 1e-9)
        if not overrides or not (left < _LESS * now or (out and not left >= now)):
            continue
        rpm = None if axis is None else speed * axis[1]
        at = "" if rpm is None else f" {number(rpm, 4)} rpm,"
        rest_in_band = f", {per_cent(left)} left" if left >= NO_MATTER else ""
        result_text = f"{at} {signed_per_cent(away)}{rest_in_band}".strip()
        rest = f"strongest resonance left within {per_cent(RESONANCE_BAND)}: {per_cent(left)} of the mean force"
        why = "; ".join(filter(None, [rest if math.isfinite(left) else "", str(note)]))
        name = str(label).replace(" -", f" {MINUS}")
        offered.append(OfferedChange(name, result_text, why, json.loads(overrides), rpm))
    return tuple(offered[:_MOST])
