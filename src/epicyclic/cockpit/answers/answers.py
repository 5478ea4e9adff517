"""The five answers of the page, those on resonances and tip relief here; and what fails in a model, with its code."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ...document.tables import leaves
from ...document.units import factor
from ...document.written_numbers import written
from ...errors import ModelError
from ...questions.modes.campbell import MeshCrossings, tones_of_meshes
from ...questions.response.sweep_table import BAND
from ...statics.equilibrium import compliance_of
from ...statics.record import unheld_warnings
from ...system.system import System
from ...system.tooth_pairs import mean_force, pair_of, tooth_warnings
from ...train.train import Train
from ...warning_codes import WARNING_CODES, CodedText, code_of, coded
from .sharing_answers import error_answer, float_answer, planet_answer
from .words import Answer, Level, number, per_cent

# Codes of trains that cannot be built or do not run; all others are warnings.
_FAILS = frozenset(
    {
        *("not-assembled", "ring-too-small", "planets-collide", "tips-in-roots", "contact-ratio-below-one"),
        *("shafts-not-alike", "centre-distances-differ", "not-solvable", "no-tooth-contact", "load-not-held"),
    }
)
_PATH = re.compile(r"\b(?:stages|operation|deviations|bodies|couplings|loads|damping|tolerance)(?:\.[\w-]+)+")


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelCheck:
    """One line of the checks.

    level : ``bad`` where the train cannot be built or solved, else ``warn``.  code : of `warning_codes`, or "".
    text : without its code.  path : of the model file, "" where the text names none.  cure : what helps.
    """

    level: Literal["bad", "warn"]
    code: str
    text: str
    path: str
    cure: str


def checks_of(train: Train, system: System) -> tuple[ModelCheck, ...]:
    """Warnings of the train, its teeth and its equations; those that fail first."""
    teeth: list[CodedText] = []
    first = {mesh.pair: mesh for mesh in reversed(train.meshes) if mesh.teeth is not None}
    for mesh in first.values():  # the first mesh of every pair
        try:
            teeth += tooth_warnings(pair_of(train, mesh), mesh)
        except ModelError as error:
            if error.path != "operation.torque":
                teeth.append(coded("no-tooth-contact", str(error)))
    warnings = [*train.warnings, *teeth, *unheld_warnings(system, compliance_of(system).free)]
    checks = [_check(text) for text in dict.fromkeys(warnings)]
    return tuple(sorted(checks, key=lambda check: check.level != "bad"))


def _check(text: CodedText) -> ModelCheck:
    code = code_of(text) or ""
    plain = text.removesuffix(f" [{code}]") if code else str(text)
    path = _PATH.search(plain)
    return ModelCheck(
        level="bad" if code in _FAILS else "warn",
        code=code,
        text=plain,
        path=path[0] if path else "",
        cure=WARNING_CODES[code].cure if code else "",
    )


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
    label : of the mode.
    """

    mode: int
    order: int
    stage: str
    frequency: float
    speed: float
    away: float
    label: str


def meetings_of(system: System, modes: Mapping[str, Any], relative_speed: float) -> list[Meeting]:
    """Mesh orders 1 .. 12 that meet a mode which they excite within 20 % of a speed per operating speed [1], speeds
    rising; where it is not known what they excite, all that meet one."""
    tones = tones_of_meshes(system)
    crossings: MeshCrossings = modes["crossings"]
    crossings = crossings.chosen(np.abs(crossings.relative_speed / relative_speed - 1) <= BAND)
    rows = {int(row["index"]): row for row in modes["rows"]}  # the highest modes of a large train have none
    several = len({name.partition("/")[0] for names in tones.values() for name in names}) > 1
    words = [" and ".join(name if several else name.rpartition("/")[2] for name in names) for names in tones.values()]
    stages = words if len(tones) > 1 else [""]
    columns = (crossings.mode, crossings.tone, crossings.order, crossings.relative_speed)
    meetings = []
    for mode, tone, order, speed in zip(*(column.tolist() for column in columns), strict=True):
        if (row := rows.get(mode + 1)) is not None:
            meeting = Meeting(
                mode=mode + 1,
                order=int(order),
                stage=stages[tone],
                frequency=float(row["frequency"]),
                speed=float(speed),
                away=float(speed) / relative_speed - 1,
                label=str(row["label"]) or f"most motion {row['body']}",
            )
            meetings.append(meeting)
    return meetings


def resonance_answer(
    train: Train, system: System, modes: Mapping[str, Any] | None, sweep: Mapping[str, Any] | None
) -> Answer:
    """The strongest resonance within 20 % of the speed that is shown, of those whose force is known, else the nearest.

    modes, sweep : heads of a frame with their arrays beside, None without.
    """
    if modes is None:
        return Answer("resonance", "Not known: the model gives no modes (masses, inertias or supports are missing).")
    if not system.tones or not max(system.tones):
        return Answer("resonance", "Not known: no member turns, so no mesh has a frequency (operation.speed).")
    relative = 1.0 if sweep is None else float(sweep["operating"]) * float(sweep["to_relative"])
    met = meetings_of(system, modes, relative)
    if not met:
        at_rest, band = int(modes["at_rest"]), per_cent(BAND)
        text = f"No mesh order up to the 12th {'excites' if at_rest else 'meets'} a mode within {band} of this speed"
        text += f": {at_rest} meet one that they leave at rest." if at_rest else "."
        return Answer("resonance", text, figure=f"> {band}", level="good", evidence="modes")
    nearest = min(met, key=lambda meeting: abs(meeting.away))
    peaks = [] if sweep is None else _peaks(sweep, met, relative)
    rise, strongest = max(peaks, key=lambda peak: (peak[0], -abs(peak[1].away)), default=(0.0, nearest))
    meeting = nearest
    level: Level = "good"
    if sweep is None:
        level, force = "warn", "; its force is not known without torque and damping"
    elif not peaks:
        force = "; no peak stands out"
    elif rise < _LITTLE:
        force = f"; no force rises by {100 * _LITTLE:g} %"
    else:
        meeting, level = strongest, "bad" if rise >= _PARTS else "warn"
        force = f": the force there is {per_cent(rise)} above its least"
    speed = None if sweep is None else meeting.speed / float(sweep["to_relative"])  # on the axis of the sweep [rpm]
    others = "" if len(met) == 1 else f" ({len(met)} within {per_cent(BAND)})"
    return Answer(
        "resonance",
        f"{_words(meeting, speed)}{force}{others}.",
        figure=per_cent(abs(meeting.away)),
        level=level,
        evidence="modes" if sweep is None else "sweep",
        mode=meeting.mode,
        speed=speed,
    )


def _words(meeting: Meeting, rpm: float | None) -> str:
    """``Mesh order 4 meets mode 9 (sun moves sideways, 812 Hz) at 92 rpm, 8 % below this speed``."""
    of_stage = f" of {meeting.stage}" if meeting.stage else ""
    at = "" if rpm is None else f" at {number(rpm, 4)} rpm,"
    side = "below" if meeting.away < 0 else "above"
    return (
        f"Mesh order {meeting.order}{of_stage} meets mode {meeting.mode} ({meeting.label}, "
        f"{number(meeting.frequency, 4)} Hz){at} {per_cent(abs(meeting.away))} {side} this speed"
    )


def _peaks(sweep: Mapping[str, Any], met: list[Meeting], relative: float) -> list[tuple[float, Meeting]]:
    """Rise of every labelled peak within the band over the least of the largest force [1], and the meeting there."""
    force = np.asarray(sweep["y"], dtype=float)
    known = np.isfinite(force).any(axis=0)
    if not known.any():
        return []
    least = float(np.nanmax(force[:, known], axis=0).min())
    peaks = []
    for peak in sweep.get("peaks", ()):
        speed = float(peak["x"]) * float(sweep["to_relative"])
        at_peak = [(abs(meeting.speed / speed - 1), meeting) for meeting in met if meeting.mode == peak.get("mode")]
        away, nearest = min(at_peak, key=lambda pair: pair[0], default=(math.inf, None))
        if nearest is not None and away <= _AT_PEAK and abs(speed / relative - 1) <= BAND and least > 0:
            peaks.append((float(peak["y"]) / least - 1, nearest))
    return peaks


# A drawn relief within this part of the estimate needs no word: the estimate is no better.
_WITHIN = 0.4
# A deflection below this needs no relief [m]: grinding does not hold it.
_LITTLE_GAP = 2e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class ReliefEstimate:
    """First estimate of the tip relief of one pair of gears.

    pair : path in the model file.  amount : deflection of a single pair of teeth at the operating load [m].
    module : normal, of the pair [m].  counted : whether the stiffness of the pair knows its relief.
    """

    pair: str
    amount: float
    module: float
    counted: bool


def estimates_of(train: Train) -> list[ReliefEstimate]:
    """The deflection F/(c' b) of a single pair of teeth under the mean mesh force, for every pair of gears with teeth.

    c' b follows from the mean mesh stiffness of the model by c_gamma = c' (0.75 eps_alpha + 0.25) [iso6336].
    """
    estimates: dict[str, ReliefEstimate] = {}
    gear = {body.name: body.gear for body in train.bodies}
    for mesh in train.meshes:
        first = gear[mesh.a]
        if mesh.pair in estimates or mesh.teeth is None or first is None or not mesh.stiffness > 0:
            continue
        single = mesh.stiffness / (0.75 * float(mesh.contact_ratio) + 0.25)
        amount = mean_force(train, mesh) / single
        if math.isfinite(amount) and amount > 0:
            counted = mesh.table is not None
            estimates[mesh.pair] = ReliefEstimate(pair=mesh.pair, amount=amount, module=first.module, counted=counted)
    return list(estimates.values())


def drawn_relief(train: Train) -> float:
    """Largest tip relief of the model file [m], a bare number is SI; 0 without one."""
    largest = 0.0
    for path, value in leaves(dict(train.document)):
        length = written(value) if path.endswith("tip_relief.amount") else None
        if length is not None:
            scale = factor(length.unit, "m") if length.unit else 1.0
            largest = max(largest, max(length.values) * (scale or 0.0))
    return largest


def relief_answer(train: Train) -> Answer:
    """The estimate of the pair that bends most, beside what is drawn; the job searches for the least error."""
    if not any(mesh.teeth is not None for mesh in train.meshes):
        text = "Not known: no gear has a face width, so no flank can be relieved (stages.STAGE.face_width)."
        return Answer("relief", text)
    estimates = estimates_of(train)
    if not estimates:
        return Answer("relief", "Not known: no torque loads the teeth (operation.torque).")
    largest = max(estimates, key=lambda estimate: estimate.amount)
    drawn, um = drawn_relief(train), number(1e6 * largest.amount, 2)
    pair = largest.pair.rpartition(".")[2]
    counts = "" if largest.counted else f' Forces and K_v count it with {largest.pair}.stiffness = "contact" alone.'
    if drawn:
        level: Level = "good" if abs(drawn / largest.amount - 1) <= _WITHIN else "warn"
        figure = f"{number(1e6 * drawn)} µm"
        text = f"is drawn; a first estimate F/(c' b) at operating load is {um} µm at the tips of {pair}.{counts}"
    else:
        level = "warn" if largest.amount > _LITTLE_GAP else "good"
        figure = f"≈ {um} µm"
        text = f"About {um} µm at the tips of {pair}: first estimate F/(c' b) at operating load; none is drawn."
        text += counts if level == "warn" else ""
    return Answer("relief", text, figure=figure, level=level, evidence="relief", job="relief")


Part = Mapping[str, Any] | None


def answers_of(
    train: Train,
    system: System,
    *,
    modes: Part = None,
    sharing: Part = None,
    twin: Part = None,
    sweep: Part = None,
    errors: Part = None,
) -> tuple[Answer, ...]:
    """The five answers, within 3 ms.

    Parameters
    ----------
    modes, sharing, twin, sweep, errors : parts of a frame as `computing.compute` makes them, heads with their arrays
        beside by short names; None where there are none.
    """
    return (
        resonance_answer(train, system, modes, sweep),
        planet_answer(train, sharing, errors),
        float_answer(train, sharing, twin),
        error_answer(train, sharing, errors),
        relief_answer(train),
    )
