"""The five answers of the page, those on load sharing first; changes that move a resonance away; what fails in a model.

The planet that carries most, what a floating sun buys and the error that hurts most propose an override as a person
writes it: half of a tolerance, or the deviations of ISO class 6 where a model gives none, the rule of `epicyclic new`,
under `[assumed]`.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...document.cases import of_another_point
from ...document.deviations import narrowed_text
from ...document.tables import PAIRS, leaves, value_at
from ...document.units import factor, written
from ...document.writer import quantity_text
from ...errors import ModelError
from ...limits import NO_MATTER, RESONANCE_BAND, ResonanceVerdict, limit_in_short
from ...questions.modes.campbell import MeshCrossings, tones_of_meshes
from ...questions.studies import DetuneOptions
from ...questions.studies.detune import NearResonance, detune, met_at, strongest
from ...results.dataset import EQUAL
from ...statics.equilibrium import compliance_of
from ...statics.record import unheld_warnings
from ...system.structure import pairs_without_flanks
from ...system.system import System
from ...system.tooth_pairs import mean_force, pair_of, tooth_warnings
from ...teeth.geometry import FLANK_GRADES, SIZE_GRADES, run_out_width
from ...train.train import Body, Train
from ...warning_codes import WARNING_CODES, CodedText, code_of, coded
from ..state.frames import (
    LEVELS,
    MINUS,
    Answer,
    Level,
    OfferedChange,
    SpeedAxis,
    force_unit,
    like_modes,
    listed,
    mode_shapes,
    number,
    ordinal,
    per_cent,
    signed_per_cent,
)

if TYPE_CHECKING:
    import xarray as xr

# Tables whose second key may be left out where the train has one stage.
_STAGED = ("deviations", "operation.speed", "operation.torque", "operation.power")


def in_short(train: Train, path: str, document: Mapping[str, object] | None = None) -> str:
    """A full path as the model file writes it of one stage: without its name, ``run_out`` for ``run_out.amplitude``.

    One value must have one path, or two overrides of it would contradict each other.
    """
    document = dict(leaves(dict(train.document))) if document is None else document
    head, _, last = path.rpartition(".")
    if last == "amplitude" and [p for p in document if p.startswith(f"{head}.")] == [path]:
        path = head
    if len(train.planets) == 1:
        (stage,) = train.planets
        for table in _STAGED:
            if path.startswith(f"{table}.{stage}."):
                return f"{table}.{path.removeprefix(f'{table}.{stage}.')}"
    return path


def scaled(train: Train, path: str, factor: float) -> dict[str, object]:
    """Overrides that multiply every number at a path and below it, but for phases; empty where there is none.

    The path may leave out the name of the stage.
    """
    document = dict(leaves(dict(train.document)))
    overrides: dict[str, object] = {}
    for leaf, value in document.items():
        short = in_short(train, leaf, document)
        is_at_path = any(f"{name}.".startswith(f"{path}.") for name in (leaf, short))
        number = written(value) if is_at_path and leaf.rpartition(".")[2] != "phase" else None
        if number is not None and not number.whole and any(number.values):
            overrides[short] = number.text(tuple(float(f"{factor * value:.6g}") for value in number.values))
    return overrides


_CLASS = 6  # ISO 1328-1 class of ground planetary gears
_PIN = 20e-6  # [m] what the pin of planet 1 is off, tangentially
# Least sizes that the formulas of ISO 1328-1 cover [m].
_DIAMETER, _MODULE = 5e-3, 0.5e-3


def class_six(train: Train) -> Mapping[str, object]:
    """Overrides: half the run-out F_rT of class 6 on every gear, the pin of planet 1 of each stage 20 um off.

    The paths of what is assumed stand beside, under ``assumed``, with their reason.  A gear without module is left out.
    """
    values: dict[str, object] = {}
    reasons: dict[str, object] = {}
    gears: dict[str, Body] = {}
    for body in train.bodies:
        if body.gear is not None and body.frame in train.planets:
            gears.setdefault(body.member, body)
    for member, body in gears.items():
        gear = body.gear
        if gear is None or not (gear.module > 0 and 0 < gear.reference_radius < math.inf):
            continue
        path = in_short(train, f"deviations.{member}.run_out")
        width = run_out_width(max(2 * gear.reference_radius, _DIAMETER), max(gear.module, _MODULE), _CLASS)
        values[path] = quantity_text(round(width / 2, 7), "length")
        reasons[f'assumed."{path}"'] = f"half of the run-out F_rT of class {_CLASS} of ISO 1328-1:2013"
    for stage, count in train.planets.items():
        carried = next((m for m, body in gears.items() if body.frame == stage and body.carried_by is not None), None)
        if carried is None or count < 2:
            continue
        path = in_short(train, f"deviations.{carried}.position.y")
        values[path] = f"[{_PIN * 1e6:g}{', 0' * (count - 1)}] um"
        reasons[f'assumed."{path}"'] = "one pin, that of planet 1, stands 20 um off along the circle of pins"
    return {**values, **reasons}


_GRADE_OF = re.compile(r"\s*grade\s*\((.*?(?:IT|:\d{4}\s+))(\d+)(\s*,.*)\)\s*", re.DOTALL)
# Grades finer that halve a tolerance: of ISO 1328-1 exactly (a step is the root of 2), of ISO 286-1 nearly.
_FINER = 2


def halved_text(text: str) -> str | None:
    """A distribution with half its spread about the same mean, a grade two steps finer; None where there is none, as
    below the finest grade of a standard."""
    grade = _GRADE_OF.fullmatch(text)
    if grade is None:
        half = narrowed_text(text, 0.5)
        return None if half == text else half
    finer, known = int(grade[2]) - _FINER, SIZE_GRADES if grade[1].endswith("IT") else FLANK_GRADES
    return f"grade({grade[1]}{finer}{grade[3]})" if finer in known else None


def halved_tolerance(train: Train, entry: str) -> dict[str, object]:
    """Override that halves an entry of `[tolerance]`; empty where its form has no half.

    entry : path of the entry, with `` common`` or `` own`` behind it where the result tells them apart.
    """
    table = train.document.get("tolerance")
    if not isinstance(table, Mapping):
        return {}
    path, _, part = entry.partition(" ")
    value = table.get(path)
    where = f'tolerance."{in_short(train, path)}"'
    if isinstance(value, str):
        half = halved_text(value)
        return {} if half is None else {where: half}
    if isinstance(value, Mapping):
        texts = {key: value.get(key) for key in ((part,) if part else ("own", "common"))}
        halves = {key: half for key, text in texts.items() if isinstance(text, str) and (half := halved_text(text))}
        return {where: {**value, **halves}} if halves else {}
    return {}


Part = Mapping[str, Any] | None

# A K_gamma this close to 1 is 1; a change of it below this is none (half a unit of the last digit shown).
_ONE, _NO_CHANGE = 5e-7, 5e-4
# Coefficients this close to the largest are the same: planets that symmetry loads alike differ by rounding alone.
_TIED = 1e-6
# Share of the excess of K_gamma that makes an error worth a word, and worth a warning [%].
_WORTH, _MOST = 1.0, 50.0
# Branch in the label of a mesh: "sun, planet 2 left", "sun, star1 5".
_BRANCH = re.compile(r"\b(\w+) (\d+)\b")
_MANY = {"planet": "planets", "branch": "branches"}
_HALVE = "Halve this deviation"
_NOTHING_TO_DO = " Nothing to do as drawn: K_gamma {value:.3f} is below its limit {limit:g}"
_ASSUME = "Assume ISO class 6 deviations"


def planet_answer(train: Train, sharing: Mapping[str, Any] | None, errors: Mapping[str, Any] | None) -> Answer:
    """The branch with the largest coefficient, by the definition mean-load; while turning where all are equal."""
    if sharing is None:
        return Answer("planet", _no_load(train))
    value = np.asarray(sharing["coefficient"], dtype=float)
    if not np.isfinite(value).any():
        return Answer("planet", "Not known: no mesh carries load.")
    largest, turning = float(np.nanmax(value)), float(sharing.get("k_gamma_turning") or np.nan)
    planets, verdict = max(train.planets.values(), default=1), sharing["verdict"]
    limit, level = limit_of(verdict["limit"], verdict["source"]), "good" if verdict["passes"] else "bad"
    against = f" Limit {verdict['limit']:g}: {limit['words']}."
    judged: dict[str, Any] = {
        "figure": f"{verdict['value']:.3f}",
        "level": level,
        "limit": limit,
        "evidence": "sharing",
    }
    if largest <= 1 + _ONE and not has_deviations(train):
        judged["level"], none = "none", "No deviations are given:"
        if train.document.get("tolerance"):
            text = f"{none} as drawn all {planets} planets carry the same. Compute: within the tolerances."
            return Answer("planet", text, job="tolerance", **judged)
        text = f"{none} all {planets} planets carry the same; class 6 of ISO 1328-1 may be assumed."
        return Answer("planet", text, apply=class_six(train), apply_label=_ASSUME, **judged)
    if largest <= 1 + _ONE:
        while_turning = np.asarray(sharing.get("turning", value), dtype=float)
        peak = ""
        if turning > 1 + _ONE and np.isfinite(while_turning).any():
            whom = carrying(sharing["rows"], while_turning, f"up to {turning:.3f}")
            peak = f"; while turning {whom[:1].lower()}{whom[1:]}"
        text = f"All planets carry the same mean load: nothing that stands still parts it{peak}.{against}"
        return Answer("planet", text, **judged)
    text = carrying(sharing["rows"], value, f"{largest:.3f}") + ", mean-load K_gamma"
    if turning > largest + _NO_CHANGE:
        text += f" ({turning:.3f} while turning)"
    if errors is not None and (first := errors["rows"][0])["share"] > _WORTH:
        much = "most" if first["share"] >= _MOST else f"{first['share']:.0f} %"
        text += f"; {much} of what is above 1 from {first['label']}"
    return Answer("planet", f"{text}.{against}", **judged)


def limit_of(value: float, source: str) -> dict[str, object]:
    """The limit of an answer.  source : of the limit, as of `KGammaLimit`."""
    words, path = limit_in_short(source)
    return {"value": value, "words": words, "source": source, "path": path}


# Paths of the model file that an answer follows from.
_POINT = r"(operation|cases\.[\w-]+)\."
_SHARED = rf"deviations|{_POINT}(torque|power)|loads|stages\..*(support|bearing|stiffness|planets)|couplings"
_RESTS_ON = {
    "resonance": rf"damping|stages|bodies|couplings|{_POINT}speed",
    **dict.fromkeys(("planet", "float", "error"), _SHARED),
    "tolerance": f"tolerance|{_SHARED}",
    "relief": rf"{_POINT}(torque|power)|stages\..*(module|face_width|helix_angle|relief|flank|stiffness|rim|bore)",
}


_HOLDS = ("support", "bearing")


def assumed_of(train: Train, key: str) -> dict[str, str]:
    """Reasons by path of the assumed values that the answer of a key rests on, or the job on tolerances."""
    acts, assumed = re.compile(_RESTS_ON[key]), {}
    for path, reason in train.assumed.items():
        if acts.match(path) and not of_another_point(train.document, path):
            table, _, last = path.rpartition(".")
            pair = next((pair for pair, keys in PAIRS.items() if last in keys and table.endswith(_HOLDS)), last)
            assumed[f"{table}.{pair}".removeprefix(".")] = reason  # x and y as the file writes them, radial
    return assumed


def carrying(rows: Sequence[Mapping[str, Any]], value: NDArray[np.float64], much: str) -> str:
    """``Planets 2, 3 carry 1.034 of their fair share at sun-planet``: the branches that carry most, and at which pair
    of gears where they have another one."""
    tied = [row for row, factor in zip(rows, value, strict=True) if factor >= np.nanmax(value) - _TIED]
    sides: dict[tuple[str, int, str], set[str]] = {}  # by word, branch and stage
    for row in tied:
        word, branch, side, of = _seat(str(row["label"]))
        sides.setdefault((word, branch, of), set()).add(side)
    branches: dict[tuple[str, str, str], list[int]] = {}  # a branch that carries as much on both sides needs no side
    for (word, branch, of), on_sides in sides.items():
        branches.setdefault((word, "".join(on_sides) if len(on_sides) == 1 else "", of), []).append(branch)
    subjects = []
    for (word, side, of), numbers in branches.items():
        subject = word if len(numbers) == 1 else _MANY.get(word, word)
        if any(numbers):
            subject += f" {listed(numbers)}"
        subjects.append(f"{subject}{side}{of}")
    whom = " and ".join(subjects)
    carry, their = ("carries", "its") if len(sides) == 1 else ("carry", "their")
    pairs = dict.fromkeys(str(row["pair"]) for row in tied)
    seats = {(word, of) for word, _, of in sides}
    theirs = {str(row["pair"]) for row in rows if _seat(str(row["label"]))[::3] in seats}
    at = "" if set(pairs) == theirs else f" at {' and '.join(pairs)}"
    return f"{whom[:1].upper()}{whom[1:]} {carry} {much} of {their} fair share{at}"


def _seat(label: str) -> tuple[str, int, str, str]:
    """Of the label of a mesh: what its branch is called and its number, 0 where it has none; its side; its stage."""
    stage, colon, rest = label.partition(": ") if ": " in label else ("", "", label)
    branch = _BRANCH.search(rest)
    if branch is None:
        return f"mesh {label}", 0, "", ""
    side = next((f" {word}" for word in ("left", "right") if label.endswith(word)), "")
    word = "planet" if branch[1] == "planet" else "branch"
    return word, int(branch[2]), side, f" of {stage}" if colon else ""


def has_deviations(train: Train) -> bool:
    """Whether anything deviates from the drawing: a member, a mesh or a pin that is not where or as it should be."""
    return any(np.any(item.vector) for item in train.displacements) or any(item.amplitude for item in train.mesh_errors)


def float_answer(train: Train, sharing: Part, twin: Part) -> Answer:
    """Both K_gamma of the train beside those of the same train with a floating sun, or with a supported one, and what
    becomes of its resonance."""
    if not any(body.kind == "sun" and body.gear is not None for body in train.bodies):
        return Answer("float", "The train has no sun that could float.")
    if sharing is None:
        return Answer("float", _no_load(train))
    if twin is None:
        return Answer("float", "The sun has no radial support of its own to take away, or nothing else holds it.")
    now, then = float(sharing["k_gamma"]), float(twin["k_gamma"])
    of_stage = f" of {twin['stage']}" if len(train.planets) > 1 else ""
    resonance = f" {twin['resonance']}" if twin.get("resonance") else ""
    if not has_deviations(train) and now <= 1 + _ONE:
        text = "Nothing yet in load sharing: without deviations the planets share equally, floating sun or not."
        return Answer("float", text + resonance, figure=f"{now:.3f}", then=f"{then:.3f}", evidence="sharing")
    turning = float(sharing["k_gamma_turning"]), float(twin["k_gamma_turning"])
    change = f"mean-load K_gamma {_change(now, then)}, turning K_gamma {_change(*turning)}"
    figure, after = _both(now, then)
    judged: dict[str, Any] = {"figure": figure, "level": "good", "evidence": "sharing"}
    if twin["value"] != 0:
        text = f"The sun{of_stage} floats already. With a rigid support: {change}.{resonance}"
        return Answer("float", text, **judged)
    text, verdict = f"With a floating sun{of_stage}: {change}.{resonance}", sharing["verdict"]
    if verdict["passes"]:
        text += f"{_NOTHING_TO_DO.format(**verdict)}."
    elif now - then >= _NO_CHANGE:
        judged |= {"level": "warn", "apply": {twin["path"]: twin["value"]}, "apply_label": "Let the sun float"}
    return Answer("float", text, then=after, **judged)


def _change(now: float, then: float) -> str:
    """How a K_gamma changes, with its sign: ``falls from 1.034 to 1.000``."""
    first, last = _both(now, then)
    if first == last:
        return f"stays {first}"
    return f"{'rises' if then > now else 'falls'} from {first} to {last}"


def _both(now: float, then: float) -> tuple[str, str]:
    """Two K_gamma that are told beside each other, with a fourth decimal where both are nearly 1."""
    digits = 4 if max(now, then) < 1.01 else 3
    return f"{now:.{digits}f}", f"{then:.{digits}f}"


def error_answer(train: Train, sharing: Mapping[str, Any] | None, errors: Mapping[str, Any] | None) -> Answer:
    """The deviation without which K_gamma falls most; where the drawing has tolerances a job says their shares."""
    job = "tolerance" if train.document.get("tolerance") and sharing is not None else None
    if sharing is None:
        return Answer("error", _no_load(train))
    answer = partial(Answer, "error", evidence="errors", job=job)
    if not has_deviations(train):
        text = "No deviations are given: no error costs anything; class 6 of ISO 1328-1 may be assumed."
        return answer(text, figure="0 %", apply=class_six(train), apply_label=_ASSUME)
    if errors is None:
        return answer(
            "No deviation parts the load: all of them follow the mesh frequency, which is no part of K_gamma."
        )
    rows: Sequence[Mapping[str, Any]] = errors["rows"]
    first, verdict = rows[0], sharing["verdict"]
    of = "while turning" if "turning" in errors["of"] else "mean-load"
    fails, nothing = verdict is not None and not verdict["passes"], ""
    if verdict is not None and not fails:
        nothing = _NOTHING_TO_DO.format(**verdict) + ("; the job tells of 99 % of the trains." if job else ".")
    if first["share"] > _WORTH and not errors["k_gamma"] - 1 < _NO_CHANGE:
        share, without, name = first["share"], first["without"], first["label"]
        then = f"; {without:.3f} without it" if np.isfinite(without) else ""
        text = f"{name[:1].upper()}{name[1:]}: {share:.0f} % of K_gamma\u00a0-\u00a01 ({of}){then}.{nothing}"
        level: Level = "warn" if share >= _MOST and fails else "good"
        # what only the turning train feels would not lower the K_gamma that is held against the limit
        values = scaled(train, first["path"], 0.5) if fails and of == "mean-load" else {}
        return answer(text, figure=f"{share:.0f} %", level=level, apply=values, apply_label=_HALVE)
    # no deviation parts the mean load: the one that costs most while the train turns
    first = max(rows, key=lambda row: float(row["turning"]))
    share, most = first["turning"], ""
    if share > _WORTH:
        most = f"; while turning the largest part has the {first['label']}, {share:.0f} %"
    text = f"No single deviation changes K_gamma ({of}) by {number(_WORTH)} % of what it is above 1{most}.{nothing}"
    return answer(text, figure=f"{share if most else 0:.0f} %", level="good")


def _no_load(train: Train) -> str:
    """Why there is no load to share."""
    if not train.kinematics.torque or not any(train.kinematics.torque.values()):
        return "Not known: no torque loads the teeth (operation.torque)."
    return "Not known: the load has no equilibrium in this model."


# checks ---------------------------------------------------------------------------------------------------------------

# Codes of trains that cannot be built or do not run; all others are warnings.
_FAILS = frozenset(
    {
        *("not-assembled", "ring-too-small", "planets-collide", "tips-in-roots", "contact-ratio-below-one"),
        *("shafts-not-alike", "centre-distances-differ", "not-solvable", "no-tooth-contact", "load-not-held"),
    }
)
_PATH = re.compile(r"\b(?:stages|operation|deviations|bodies|couplings|loads|damping|tolerance)(?:\.[\w-]+)+")


def checks_of(train: Train, system: System) -> list[dict[str, str]]:
    """Warnings of the train, its teeth and its equations; those that fail first.

    level : ``bad`` where the train cannot be built or solved, else ``warn``.  code : of `warning_codes`, or "".
    text : without its code.  path : of the model file, "" where the text names none.  cure : what helps.
    """
    teeth: list[CodedText] = []
    first = {mesh.pair: mesh for mesh in reversed(train.meshes) if mesh.teeth is not None}
    for mesh in first.values():  # the first mesh of every pair
        try:
            teeth += tooth_warnings(pair_of(train, mesh), mesh)
        except ModelError as error:
            if error.path != "operation.torque":
                teeth.append(coded("no-tooth-contact", str(error)))
    warnings = [*train.warnings, *teeth, *unheld_warnings(system, compliance_of(system).free)]
    checks = []
    for text in dict.fromkeys(warnings):
        code = code_of(text) or ""
        plain = text.removesuffix(f" [{code}]") if code else str(text)
        path, cure = _PATH.search(plain), WARNING_CODES[code].cure if code else ""
        level = "bad" if code in _FAILS else "warn"
        checks.append({"level": level, "code": code, "text": plain, "path": path[0] if path else "", "cure": cure})
    return sorted(checks, key=lambda check: check["level"] != "bad")


# resonances and relief ------------------------------------------------------------------------------------------------


def meetings_of(system: System, modes: Mapping[str, Any], relative_speed: float) -> list[NearResonance]:
    """Mesh orders 1 .. 12 that meet a mode which they excite within 20 % of a speed per operating speed [1], speeds
    rising; where it is not known what they excite, all that meet one."""
    tones = tones_of_meshes(system)
    crossings: MeshCrossings = modes["crossings"]
    near = np.abs(crossings.relative_speed / relative_speed - 1) <= RESONANCE_BAND
    # the highest modes of a large train have no row
    frequency = {int(row["index"]) - 1: float(row["frequency"]) for row in modes["rows"]}
    near &= np.isin(crossings.mode, list(frequency))
    several = len({name.partition("/")[0] for names in tones.values() for name in names}) > 1
    words = [" and ".join(name if several else name.rpartition("/")[2] for name in names) for names in tones.values()]
    stages = words if len(tones) > 1 else [""]
    return met_at(crossings.chosen(near), modes["force_ratio"][near], frequency, stages, relative_speed)


def resonance_answer(
    train: Train,
    system: System,
    modes: Mapping[str, Any] | None,
    sweep: Mapping[str, Any] | None,
    changes: Sequence[OfferedChange] = (),
) -> Answer:
    """The strongest resonance within 20 % of the speed that is shown, where no force is known the nearest.

    modes, sweep : heads of a frame with their arrays beside, None without.  changes : that move it away, where known.
    """
    if modes is None:
        return Answer("resonance", "Not known: the model gives no modes (masses, inertias or supports are missing).")
    if not system.tones or not max(system.tones):
        return Answer("resonance", "Not known: no member turns, so no mesh has a frequency (operation.speed).")
    to_rpm = None if sweep is None else 1 / float(sweep["to_relative"])  # on the axis of the sweep
    relative = 1.0 if sweep is None else float(sweep["operating"]) * float(sweep["to_relative"])
    met, band = meetings_of(system, modes, relative), per_cent(RESONANCE_BAND)
    if not met:
        at_rest = int(modes["at_rest"])
        text = f"No mesh order up to the 12th {'excites' if at_rest else 'meets'} a mode within {band} of this speed"
        text += f": {at_rest} meet one that they leave at rest." if at_rest else "."
        return Answer("resonance", text, figure=f"> {band}", level="good", evidence="modes")
    level: Level = "warn"
    force = "its force is not known without torque and damping"
    meeting = strongest(met)
    row = next(row for row in modes["rows"] if row["index"] == meeting.mode + 1)
    label = row["label"] or f"most motion {row['body']}"
    if np.isfinite(meeting.force_ratio):
        verdict = ResonanceVerdict(meeting.force_ratio)
        level, force = LEVELS[verdict.tone], f"the mode's force is {verdict.text}"
    others = "" if len(met) == 1 else f" ({len(met)} within {band})"
    return Answer(
        "resonance",
        f"{_words(meeting, label, to_rpm)}; {force}{others}.",
        figure=per_cent(abs(meeting.away)),
        level=level,
        evidence="modes" if sweep is None else "sweep",
        mode=meeting.mode + 1,
        speed=None if to_rpm is None else to_rpm * meeting.speed,
        mark=marked(meeting, to_rpm),
        changes=() if level == "good" else changes,
        # a job is of the operating speed
        job=None if level == "good" or relative != 1 or is_quick(train, system) else "detune",
    )


def marked(meeting: NearResonance, to_rpm: float | None) -> str:
    """A resonance in few words: ``4th order, 92 rpm, -8 %``.  to_rpm : operating speed [rpm], None where unknown."""
    return f"{_order(meeting)}, {_place(meeting, to_rpm)}"


def _order(meeting: NearResonance) -> str:
    return f"{ordinal(meeting.order)} order" + (f" of {meeting.stage}" if meeting.stage else "")


def _place(meeting: NearResonance, to_rpm: float | None) -> str:
    """``92 rpm, -8 %``."""
    at = "" if to_rpm is None else f"{number(to_rpm * meeting.speed, 4)} rpm, "
    return f"{at}{signed_per_cent(meeting.away)}"


def resonance_shift(
    trains: Sequence[tuple[System, Mapping[str, Any]]], relative_speed: float, to_rpm: float | None
) -> str:
    """A sentence on what becomes of the strongest resonance near the speed that is shown where a train is its twin.

    Parameters
    ----------
    trains : the train and its twin with their modes, as of `resonance_answer`.  relative_speed : that is shown, per
        operating speed [1].  to_rpm : the operating speed [rpm].
    """
    now, then = (meetings_of(*train, relative_speed) for train in trains)
    band = per_cent(RESONANCE_BAND)
    if not then:
        goes = f" ({marked(strongest(now), to_rpm)} now)" if now else " either way"
        return f"No resonance within {band}{' then' if now else ''}{goes}."
    last = strongest(then)
    place = marked(last, to_rpm)
    before, after = (mode_shapes([], m["rows"], m) for _, m in trains)
    like, frequency = like_modes(before, after), dict(zip(after.number, after.frequency, strict=True))

    def is_last(meeting: NearResonance) -> bool:
        mode = like[meeting.mode + 1][0]
        same = mode is not None and math.isclose(frequency[mode], last.hertz, rel_tol=EQUAL)
        return same and (meeting.order, meeting.stage) == (last.order, last.stage)

    if now and is_last(strongest(now)):
        first, place = _place(strongest(now), to_rpm), _place(last, to_rpm)
        moves = f"{first} \u2192 {place}" if first != place else f"{place}, as now"
        return f"Resonance, {_order(last)}: {moves}."
    known = math.isfinite(last.force_ratio)
    force = f"; the mode's force is {ResonanceVerdict(last.force_ratio).text}" if known else ""
    which = "The strongest resonance is then another" if any(map(is_last, now)) else f"A new resonance within {band}"
    return f"{which}: {place}{force}."


def _words(meeting: NearResonance, label: str, to_rpm: float | None) -> str:
    """``Mesh order 4 meets mode 9 (sun moves sideways, 812 Hz) at 92 rpm, 8 % below this speed``."""
    of_stage = f" of {meeting.stage}" if meeting.stage else ""
    at = "" if to_rpm is None else f" at {number(to_rpm * meeting.speed, 4)} rpm,"
    side = "below" if meeting.away < 0 else "above"
    return (
        f"Mesh order {meeting.order}{of_stage} meets mode {meeting.mode + 1} ({label}, "
        f"{number(meeting.hertz, 4)} Hz){at} {per_cent(abs(meeting.away))} {side} this speed"
    )


# A drawn relief within this part of the estimate needs no word: the estimate is no better.
_WITHIN = 0.4
# A deflection below this needs no relief [m]: grinding does not hold it.
_LITTLE_GAP = 2e-6


class ReliefEstimate(NamedTuple):
    """First estimate of the tip relief of one pair of gears.

    pair : path in the model file.  amount : deflection of a single pair of teeth at the operating load [m].
    module : normal, of the pair [m].  load : mean mesh force in words.
    """

    pair: str
    amount: float
    module: float
    load: str


def relief_estimate(train: Train) -> ReliefEstimate | None:
    """The largest deflection F/(c' b) of a single pair of teeth under the mean mesh force, of all pairs of gears with
    teeth; None where none is loaded.

    c' b follows from the mean mesh stiffness of the model by c_gamma = c' (0.75 eps_alpha + 0.25) [iso6336].
    """
    estimates: dict[str, ReliefEstimate] = {}
    gear = {body.name: body.gear for body in train.bodies}
    for mesh in train.meshes:
        first = gear[mesh.a]
        if mesh.pair in estimates or mesh.teeth is None or first is None or not mesh.stiffness > 0:
            continue
        single = mesh.stiffness / (0.75 * float(mesh.contact_ratio) + 0.25)
        force = mean_force(train, mesh)
        amount = force / single
        if 0 < amount < math.inf:
            unit, scale = force_unit(force)
            load = f"{number(scale * force)} {unit}{' a helix' if mesh.side else ''}"
            estimates[mesh.pair] = ReliefEstimate(pair=mesh.pair, amount=amount, module=first.module, load=load)
    return max(estimates.values(), key=lambda estimate: estimate.amount, default=None)


FOLLOW = "Let the curve follow"
"""Label of what makes the curve over speed count the relief that is drawn."""


def follow_overrides(train: Train) -> dict[str, object]:
    """Overrides with which the mesh stiffness follows the flanks that are drawn; empty where it does."""
    document = dict(train.document)
    overrides: dict[str, object] = {}
    for pair in pairs_without_flanks(train):
        overrides[f"{pair}.stiffness"] = "contact"
        if value_at(document, f"{pair}.variation".split(".")) is not None:  # of it the curve would take the form
            overrides[f"{pair}.variation"] = None
    return overrides


def curve_note(train: Train) -> str:
    """Why the curve over speed does not follow the flanks that are drawn; "" where it does."""
    pairs = " and ".join(pair.rpartition(".")[2] for pair in pairs_without_flanks(train))
    return f"without the relief: the stiffness of {pairs} is not from contact" if pairs else ""


def uncounted(train: Train) -> str:
    """The same as a sentence of an answer."""
    note = curve_note(train)
    return f" Forces over speed are {note}." if note else ""


def drawn_relief(train: Train) -> float:
    """Largest tip relief of the model file [m], a bare number is SI; 0 without one."""
    amounts = (value for path, value in leaves(dict(train.document)) if path.endswith("tip_relief.amount"))
    lengths = [length for length in map(written, amounts) if length is not None]
    scales = ((factor(length.unit, "m") if length.unit else 1.0) or 0.0 for length in lengths)
    return max([0.0, *(max(length.values) * scale for length, scale in zip(lengths, scales, strict=True))])


def relief_answer(train: Train) -> Answer:
    """The estimate of the pair that bends most, beside what is drawn; the job searches for the least error."""
    if not any(mesh.teeth is not None for mesh in train.meshes):
        text = "Not known: no gear has a face width, so no flank can be relieved (stages.STAGE.face_width)."
        return Answer("relief", text)
    largest = relief_estimate(train)
    if largest is None:
        return Answer("relief", "Not known: no torque loads the teeth (operation.torque).")
    drawn, um = drawn_relief(train), number(1e6 * largest.amount, 2)
    pair, follow = largest.pair.rpartition(".")[2], follow_overrides(train)
    estimate = f"first estimate F/(c' b) for {largest.load} at operating load"
    if drawn:
        level: Level = "good" if abs(drawn / largest.amount - 1) <= _WITHIN else "warn"
        figure = f"{number(1e6 * drawn)} µm"
        text = f"{figure} is drawn; a {estimate} is {um} µm at the tips of {pair}.{uncounted(train)}"
    else:
        level = "warn" if largest.amount > _LITTLE_GAP else "good"
        figure = "0 µm"
        text = f"About {um} µm at the tips of {pair}: {estimate}; none is drawn."
    return Answer(
        "relief",
        text,
        figure=figure,
        then=f"≈ {um} µm",
        level=level,
        apply=follow,
        apply_label=FOLLOW,
        evidence="relief",
        job="relief",
    )


def answers_of(
    train: Train, system: System, told: Mapping[str, Part], changes: Sequence[OfferedChange] = ()
) -> tuple[Answer, ...]:
    """The five answers, within 3 ms.

    Parameters
    ----------
    told : parts of a frame as `computing.compute` makes them, heads with their arrays beside by short names: modes,
        sharing, twin, sweep, errors, those that there are.
    changes : that move the resonance of the first answer away.
    """
    sharing, errors = told.get("sharing"), told.get("errors")
    found = (
        resonance_answer(train, system, told.get("modes"), told.get("sweep"), changes),
        planet_answer(train, sharing, errors),
        float_answer(train, sharing, told.get("twin")),
        error_answer(train, sharing, errors),
        relief_answer(train),
    )
    return tuple(replace(answer, assumed=assumed_of(train, answer.key)) for answer in found)


# --- changes that move the resonance of the answer away, as the page offers them: those of the verb `detune` ----------

# Changes that a line of the page has room for.
_MOST_CHANGES = 3
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
    return tuple(offered[:_MOST_CHANGES])
