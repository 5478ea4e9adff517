"""The answer on resonances: which mesh order meets which mode near operation, and how much force that costs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...questions.modes.campbell import MeshCrossings, tones_of_meshes
from ...questions.response.resonances import BAND
from ...system.system import System
from ...train.train import Train
from .answer import Answer, Level, answer, number, per_cent

__all__ = ["Meeting", "meetings_of", "resonance_answer"]

# A peak above the quietest speed by less than a twentieth is less than loads of a train are known to; from one on the
# force falls to zero once a cycle where the rise is an amplitude: teeth part.  The limits of the verb `modes`.
_LITTLE, _PARTS = 0.05, 1.0
# Distance of a peak of the curve from the speed of its mode, per speed: as far as the curve's own labels look.
_AT_PEAK = 0.03


@dataclass(frozen=True, slots=True, kw_only=True)
class Meeting:
    """A mesh order at a mode.

    mode : number of the mode as of the verb `modes`.  order : mesh order.  stage : whose, "" of a train with one mesh
    frequency.  frequency : [Hz].  speed : per operating speed [1].  away : from the speed that is shown [1].
    label, body : of the mode.
    """

    mode: int
    order: int
    stage: str
    frequency: float
    speed: float
    away: float
    label: str
    body: str


def meetings_of(system: System, modes: Mapping[str, Any], relative_speed: float) -> list[Meeting]:
    """Mesh orders 1 .. 12 that meet a mode which they excite within 20 % of a speed per operating speed [1], speeds
    rising; where it is not known what they excite, all that meet one."""
    tones = tones_of_meshes(system)
    found: MeshCrossings = modes["crossings"]
    found = found.chosen(np.abs(found.relative_speed / relative_speed - 1) <= BAND)
    rows = {int(row["index"]): row for row in modes["rows"]}  # the highest modes of a large train have none
    several = len({name.partition("/")[0] for names in tones.values() for name in names}) > 1
    words = [" and ".join(name if several else name.rpartition("/")[2] for name in names) for names in tones.values()]
    stages = words if len(tones) > 1 else [""]
    return [
        Meeting(
            mode=place + 1,
            order=int(order),
            stage=stages[tone],
            frequency=float(rows[place + 1]["frequency"]),
            speed=float(speed),
            away=float(speed) / relative_speed - 1,
            label=str(rows[place + 1]["label"]),
            body=str(rows[place + 1]["body"]),
        )
        for place, tone, order, speed in zip(
            found.mode.tolist(), found.tone.tolist(), found.order.tolist(), found.relative_speed.tolist(), strict=True
        )
        if place + 1 in rows
    ]


def resonance_answer(
    train: Train, system: System, modes: Mapping[str, Any] | None, sweep: Mapping[str, Any] | None
) -> Answer:
    """The strongest resonance within 20 % of the speed that is shown, of those whose force is known, else the nearest.

    modes, sweep : heads of a frame with their arrays beside, None without.
    """
    if modes is None:
        return answer("resonance", "Not known: the model gives no modes (masses, inertias or supports are missing).")
    if not system.tones or not max(system.tones):
        return answer("resonance", "Not known: no member turns, so no mesh has a frequency (operation.speed).")
    relative = 1.0 if sweep is None else float(sweep["operating"]) * float(sweep["to_relative"])
    met = meetings_of(system, modes, relative)
    band = per_cent(BAND)
    if not met:
        at_rest = int(modes["at_rest"])
        text = f"No mesh order up to the 12th {'excites' if at_rest else 'meets'} a mode within {band} of this speed"
        text += f": {at_rest} meet one that they leave at rest." if at_rest else "."
        return answer("resonance", text, figure=f"> {band}", level="good", evidence="modes")
    nearest = min(met, key=lambda one: abs(one.away))
    if sweep is None:
        text = f"{_words(nearest, None)}; its force is not known without torque and damping{_others(met)}."
        return _answered(text, nearest, "warn", None)
    peaks = _peaks(sweep, met, relative)
    if not peaks:
        text = f"{_words(nearest, sweep)}; no peak stands out{_others(met)}."
        return _answered(text, nearest, "good", sweep)
    rise, one = max(peaks, key=lambda peak: (peak[0], -abs(peak[1].away)))
    if rise < _LITTLE:
        text = f"{_words(nearest, sweep)}; no force rises by {100 * _LITTLE:g} %{_others(met)}."
        return _answered(text, nearest, "good", sweep)
    level: Level = "bad" if rise >= _PARTS else "warn"
    text = f"{_words(one, sweep)}: the force there is {per_cent(rise)} above its least{_others(met)}."
    return _answered(text, one, level, sweep)


def _answered(text: str, one: Meeting, level: Level, sweep: Mapping[str, Any] | None) -> Answer:
    figure, evidence = per_cent(abs(one.away)), "modes" if sweep is None else "sweep"
    speed = None if sweep is None else _rpm(one, sweep)
    return answer("resonance", text, figure=figure, level=level, evidence=evidence, mode=one.mode, speed=speed)


def _rpm(one: Meeting, sweep: Mapping[str, Any]) -> float:
    """Speed of a meeting on the axis of the sweep [rpm]."""
    return one.speed / float(sweep["to_relative"])


def _others(met: list[Meeting]) -> str:
    """How many there are within the band."""
    return "" if len(met) == 1 else f" ({len(met)} within {per_cent(BAND)})"


def _words(one: Meeting, sweep: Mapping[str, Any] | None) -> str:
    """``Mesh order 4 meets mode 9 (sun moves sideways, 812 Hz) at 92 rpm, 8 % below this speed``."""
    of_stage = f" of {one.stage}" if one.stage else ""
    at = "" if sweep is None else f" at {number(_rpm(one, sweep), 4)} rpm,"
    side = "below" if one.away < 0 else "above"
    label = one.label or f"most motion {one.body}"
    return (
        f"Mesh order {one.order}{of_stage} meets mode {one.mode} ({label}, {number(one.frequency, 4)} Hz){at}"
        f" {per_cent(abs(one.away))} {side} this speed"
    )


def _peaks(sweep: Mapping[str, Any], met: list[Meeting], relative: float) -> list[tuple[float, Meeting]]:
    """Rise of every labelled peak within the band over the least of the largest force [1], and the meeting there."""
    force = np.asarray(sweep["y"], dtype=float)
    known = np.isfinite(force).any(axis=0)
    if not known.any():
        return []
    least = float(np.nanmax(force[:, known], axis=0).min())
    found = []
    for peak in sweep.get("peaks", ()):
        speed = float(peak["x"]) * float(sweep["to_relative"])
        near = [one for one in met if one.mode == peak.get("mode") and abs(one.speed / speed - 1) <= _AT_PEAK]
        if near and abs(speed / relative - 1) <= BAND and least > 0:
            rise = float(peak["y"]) / least - 1
            found.append((rise, min(near, key=lambda one: abs(one.speed / speed - 1))))
    return found
