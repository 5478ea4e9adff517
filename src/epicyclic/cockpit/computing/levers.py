"""The levers of a train: about seven numbers of its model that are worth a slider, by what they move.

A lever is found among the numbers that the model has (errors, supports, load, speed, design), tried at another value,
and ranked by what K_gamma and the natural frequencies make of it; every kind has its places, so that seven levers are
not seven run-outs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...bearings.rolling_bearing import dynamic_rating
from ...document.document import file_text, parse_text
from ...document.schema import case_states
from ...document.tables import PlainTable, leaves, split_path, value_at
from ...document.units import Written, factor, written
from ...engine.points import outcomes
from ...errors import ConvergenceError, ModelError
from ...questions.modes.eigen import mean_modes
from ...results.dataset import largest
from ...statics.sample_loads import mean_loads
from ...statics.tangent import linear
from ...system.assembly import assemble
from ...train.resolution import load
from ...train.train import Train
from ..state.frames import largest_known, member_name, per_cent
from .answers import in_short

# A soft support that is still felt, per mesh stiffness: where a floating sun is first held.
_SOFT = 0.03


@dataclass(frozen=True, slots=True, kw_only=True)
class Lever:
    """A number of the model file, and its slider once that is made.

    kind : pin, run_out, sun, support, clearance, rating, load, speed, rim or design.  path : of the override.
    label : in words.
    value : in `unit`, "" of a plain number; of a candidate 0 where the model has none, inf where it is rigid.
    log : whether the slider is logarithmic.  usual : a usual value in `unit`, of a support.
    entry, count : place from 0 and number of entries, where the value is one entry of a list at the path; None of a
        single number.  others : all entries of the list, in `unit`.
    least, most, step : of the slider, in `unit`.  why : what it does to this train.
    """

    kind: str
    path: str
    label: str
    value: float
    unit: str
    log: bool = False
    usual: float = 0.0
    entry: int | None = None
    count: int | None = None
    others: tuple[float, ...] = ()
    least: float = 0.0
    most: float = 0.0
    step: float = 0.0
    why: str = ""

    def scaled(self, si: float) -> float:
        """A value in SI in the unit of the lever."""
        return si / _si_of(self.unit)

    def written(self) -> object:
        """Value of the override."""
        if self.entry is None:
            return Written(values=(self.value,), unit=self.unit, many=False).text((self.value,))
        values = (*self.others[: self.entry], self.value, *self.others[self.entry + 1 :])
        return Written(values=values, unit=self.unit, many=True).text(values)


class _Model:
    """A train with its document and its texts: the model file and what is laid over it say how a number is written."""

    def __init__(self, train: Train, tables: PlainTable, overrides: Mapping[str, object]) -> None:
        self.train, self.tables, self.overrides = train, tables, overrides
        self.document = dict(leaves(dict(train.document)))
        self.several = len(train.planets) > 1
        self.members: dict[str, Any] = {}
        for body in train.bodies:
            self.members.setdefault(body.member, body)

    def path_of(self, full: str) -> str:
        """The path at which the file or an override states a value, else the short one."""
        paths = list(dict.fromkeys([in_short(self.train, full, self.document), full, full.removesuffix(".amplitude")]))
        if full.endswith(".radial"):
            paths.append(f"{full.removesuffix('.radial')}.x")
        for path in paths:
            if path in self.overrides or written(value_at(self.tables, split_path(path, path=path))) is not None:
                return path
        return paths[0].removesuffix(".amplitude")

    def number(self, full: str) -> Written | None:
        """Number of the document at a full path; a radial stiffness is that along x."""
        names = (full, f"{full.removesuffix('.radial')}.x") if full.endswith(".radial") else (full,)
        numbers = (written(self.document.get(name)) for name in names)
        return next((number for number in numbers if number is not None), None)

    def candidates(self) -> list[Lever]:
        """Candidates in the order of the page; errors of a train without load part nothing."""
        loaded = any((self.train.kinematics.torque or {}).values())
        errors = [*self.pins(), *self.run_outs()] if loaded else []
        return [*errors, *self.supports(), *self.bearings(), *self.operation(), *self.rims(), *self.design()]

    def lever(
        self,
        kind: str,
        full: str,
        label: str,
        number: Written | None,
        *,
        unit: str = "",
        value: float = 0.0,
        **more: Any,
    ) -> Lever:
        """A candidate at a full path; unit, value : where the model states none."""
        if number is not None:
            unit, value = number.unit or unit, number.values[more.get("entry", 0)]
        return Lever(kind=kind, path=self.path_of(full), label=label, unit=unit, value=value, **more)

    def pins(self) -> Iterator[Lever]:
        """Tangential position of the pin that stands farthest off, else of that of planet 1."""
        for member, body in self.members.items():
            if body.kind != "planet" or body.carried_by is None or body.gear is None:
                continue
            count = self.train.planets.get(body.frame, 1)
            full = f"deviations.{member}.position.y"
            number = self.number(full)
            values = number.values if number is not None and number.many else (0.0,) * count
            if (number is not None and not number.many) or len(values) != count or count < 2:
                continue
            entry = max(range(count), key=lambda i: (abs(values[i]), -i))
            label = f"pin of {member_name(self.train, member)} {entry + 1}, tangential"
            yield self.lever("pin", full, label, number, unit="um", entry=entry, count=count, others=tuple(values))

    def run_outs(self) -> Iterator[Lever]:
        """Run-out of every member about the axis that turns; of planets where the file has one."""
        speeds = self.train.kinematics.speed or {}
        for member, body in self.members.items():
            full = f"deviations.{member}.run_out.amplitude"
            number = self.number(full)
            if number is not None and number.many:
                continue
            if body.frame not in self.train.planets or (number is None and not (speeds.get(member) and body.gear)):
                continue
            if number is None and body.kind == "planet":
                continue
            label = f"run-out of the {member_name(self.train, member)}{'s' if body.kind == 'planet' else ''}"
            yield self.lever("run_out", full, label, number, unit="um")

    def supports(self) -> Iterator[Lever]:
        """Radial stiffness of suns, whether they float or not, and of what has a finite one."""
        stiffness = {mesh.stage: mesh.stiffness for mesh in reversed(self.train.meshes)}  # of the first mesh
        for member, body in self.members.items():
            sun = body.kind == "sun" and body.gear is not None
            for table in ("support", "bearing"):
                full = f"stages.{member}.{table}.radial"
                number = self.number(full)
                if body.frame not in stiffness or (number is not None and number.many):
                    continue
                kind = "sun" if sun and table == "support" else "support"
                label = (
                    f"{table} of the {member_name(self.train, member)}{'s' if body.kind == 'planet' else ''}, radial"
                )
                lever = self.lever(kind, full, label, number, unit="N/m", value=math.inf, log=True)
                if kind == "sun" or 0 < lever.value < math.inf:
                    yield replace(lever, usual=float(f"{lever.scaled(_SOFT * stiffness[body.frame]):.2g}"))

    def bearings(self) -> Iterator[Lever]:
        """Internal clearance and rating of rolling bearings that are stated by their parts, those of planets first."""
        rolling = {link.path: link for link in reversed(self.train.links) if link.rolling is not None}
        for path, link in sorted(rolling.items(), key=lambda item: item[1].kind != "bearing"):
            _, stage, member, *name = path.split(".")
            label = f"{' '.join(name)} of the {member_name(self.train, f'{stage}.{member}')}"
            label += "s" if link.kind == "bearing" else ""
            clearance, rating = (link.rolling.clearance, dynamic_rating(link.rolling)) if link.rolling else (0.0, 0.0)
            ratings = {
                "clearance": ("internal_clearance", "um", 1e6 * clearance),
                "rating": ("rating", "kN", 1e-3 * rating),
            }
            for kind, (key, unit, value) in ratings.items():
                number = self.number(f"{path}.{key}")
                if number is None or not number.many:
                    words = f"{label}, {key.replace('_', ' ')}"
                    yield self.lever(kind, f"{path}.{key}", words, number, unit=unit, value=value)

    def operation(self) -> Iterator[Lever]:
        """Torques, powers and speeds that the file states, of the case that is computed where it states them."""
        of_case = f"cases.{self.document.get('case') or None}"
        stated = {full.split(".")[2] for full in self.document if full.startswith(f"{of_case}.")}
        for table, kind in (("torque", "load"), ("power", "load"), ("speed", "speed")):
            place = f"{of_case if case_states(table, stated) else 'operation'}.{table}."
            for full, value in self.document.items():
                number = written(value)
                if not full.startswith(place) or number is None or number.many or not number.values[0]:
                    continue
                member = full.removeprefix(place)
                nominal = f"operation.{table}.{member}"
                short = in_short(self.train, nominal, self.document).removeprefix(f"operation.{table}.")
                label = f"{table} of the {(member if self.several else short).replace('.', ' ')}"
                yield self.lever(kind, full, label, number)

    def rims(self) -> Iterator[Lever]:
        """Rim, or outer diameter, of every ring that bends, where its section follows from it."""
        for member, body in self.members.items():
            for key, words in (("rim", "rim"), ("outer_diameter", "outer diameter")) if body.elastic else ():
                number = self.number(f"stages.{member}.{key}")
                if number is not None and f"stages.{member}.elastic.bending" not in self.document:
                    label = f"{words} of the {member_name(self.train, member)}"
                    yield self.lever("rim", f"stages.{member}.{key}", label, number)

    def design(self) -> Iterator[Lever]:
        """Helix angle, module, face width, masses, damping and mesh stiffnesses that the file states."""
        words = {"helix_angle": "helix angle", "module": "module", "face_width": "face width"}
        for full, value in self.document.items():
            parts, number = full.split("."), written(value)
            if number is None or number.many or not number.values[0]:
                continue
            stage = f" of {parts[1]}" if self.several and len(parts) > 1 else ""
            if full == "damping.modal":
                label, log = "damping of every mode", False
            elif parts[0] == "stages" and len(parts) == 3 and parts[2] in words:
                label, log = words[parts[2]] + stage, False
            elif parts[0] == "stages" and len(parts) == 4 and parts[3] == "mass":
                label, log = f"mass of the {member_name(self.train, f'{parts[1]}.{parts[2]}')}", False
            elif parts[0] == "stages" and parts[2] == "meshes" and parts[-1] == "stiffness" and len(parts) == 5:
                label, log = f"stiffness of {parts[3]}{stage}", True
            else:
                continue
            yield self.lever("design", full, label, number, log=log)


def _si_of(unit: str) -> float:
    """SI value of one of a unit."""
    factors = (factor(unit, target) for target in ("m", "N/m", "rad", "N m", "W", "N/m^2", "N") if unit)
    return next(filter(None, factors), 1.0)


# Natural frequencies that are compared: the lowest, which operation meets.
_MODES = 12
# A change below this is none [1].
_NONE = 5e-4
# Weight of a relative change of a frequency beside one of K_gamma: sharing is what the page is opened for.
_FREQUENCY = 0.3


class Figures(NamedTuple):
    """Figures of a train.

    k_gamma, k_turning : largest mean-load coefficient, and while turning [1]; nan without load.
    frequency : (n,) lowest elastic natural frequencies [Hz].
    """

    k_gamma: float
    k_turning: float
    frequency: NDArray[np.float64]


class Effect(NamedTuple):
    """What a change does, in words, and its size for ranking [1]."""

    words: str
    size: float


def figures_of(train: Train) -> Figures:
    """Figures of a train; what cannot be computed is nan or empty.

    Raises
    ------
    ModelError : the train cannot be assembled.
    """
    system = assemble(train)
    k_gamma = k_turning = float("nan")
    with suppress(ModelError, ConvergenceError):
        k_gamma, k_turning = (largest_known(np.asarray(k)) for k in mean_loads(system)[:2])
    frequency = np.zeros(0)
    with suppress(ModelError, np.linalg.LinAlgError):
        squared, _ = mean_modes(linear(system))
        frequency = np.sqrt(squared[squared > 0])[:_MODES] / (2 * np.pi)
    return Figures(k_gamma, k_turning, frequency)


def effect_of(now: Figures, then: Figures, where: str) -> Effect:
    """What a change does; where : the changed value in words."""
    words, size = [], 0.0
    for name, before, after in zip(("K_gamma", "K_gamma while turning"), now[:2], then[:2], strict=True):
        change = after - before
        if np.isfinite(change) and abs(change) > _NONE:
            words.append(f"{name} {before:.3f} → {after:.3f}")
            size = max(size, abs(change))
    count = min(len(now.frequency), len(then.frequency))
    if count:
        moved = then.frequency[:count] / now.frequency[:count] - 1
        most = largest(np.abs(moved))
        if abs(moved[most]) > _NONE:
            words.append(f"moves a mode of {now.frequency[most]:.0f} Hz by {per_cent(float(moved[most]))}")
            size = max(size, _FREQUENCY * abs(float(moved[most])))
    return Effect(f"{where}: {'; '.join(words[:2])}" if words else "", size)


# Levers that one screen shows beside their number boxes.
_MOST = 7
# Beside them those of rolling bearings that are stated by their parts, and the rim of a ring that bends.
_BESIDE = ("clearance", "rating", "rim")
_FROM_NONE = ("pin", "run_out", "clearance")
# Candidates that are tried, 20 ms each of a small train: a model opens meanwhile.  Those that are left move nothing
# known.  A number and no time, so that a model has the same levers whatever else the machine does.
_TRIALS = 12
# What needs no trial, and its size for ranking: small, that none of them takes the place of what moves the sharing.
_KNOWN = {
    "load": Effect("mesh forces follow it one to one", 2e-3),
    "speed": Effect("mesh frequencies follow it one to one", 2e-3),
    "damping": Effect("the height of the resonances", 1e-3),
    "rating": Effect("L10r of the bearing follows its third power, of rollers the fourth", 1e-3),
}
# Range of a lever per its value; errors begin at none at all.  Range of a stiffness per its power of ten: softness is
# what is sought, and beyond ten times a support is as good as rigid.
_LEAST, _MOST_TIMES = 0.1, 4.0
_SOFTEST, _STIFFEST = 0.01, 10.0
# Steps of a slider over its range: about a pixel each.
_STEPS = 100
# Least range of an error [m]: that of a coarse gear of usual size, which a good drawing would not show.
_ERROR = 60e-6
# Halvings of the way from an end that gives no model to the value: a thirtieth of it is left then.
_TRIES = 5
# Bounds beyond which no gear is built: helix [deg], damping of a mode [1].
_HELIX, _DAMPING = 40.0, 0.2


def levers_of(source: PlainTable | Path, overrides: Mapping[str, object]) -> tuple[Lever, ...]:
    """Levers of a model in the order of the page, at most seven, and beside them two of bearings and a rim that bends.

    Raises
    ------
    ModelError : the model is wrong.
    """
    train = load(source, dict(overrides))
    tables = parse_text(file_text(source), str(source)) if isinstance(source, Path) else source
    candidates = _Model(train, tables, overrides).candidates()
    effects = _effects(source, overrides, train, candidates)
    ranked = sorted(range(len(candidates)), key=lambda i: (-effects[i].size, i))
    chosen = list({candidates[i].kind: i for i in reversed(ranked)}.values())  # the first of each kind
    # the places that are left go to those that move most
    beside = sum(candidates[i].kind in _BESIDE for i in chosen)
    moving = [i for i in ranked if candidates[i].kind not in _BESIDE and i not in chosen and effects[i].size > 0]
    chosen += moving[: _MOST + beside - len(chosen)]
    levers = []
    for i in sorted(chosen):
        lever = _lever(candidates[i], effects[i])
        # of geometry alone an end may contradict the rest of the drawing
        if lever.path.startswith("stages") and not lever.log:
            lever = _that_loads(source, overrides, lever)
        levers.append(lever)
    return tuple(levers)


def levers_at(source: PlainTable | Path, overrides: Mapping[str, object]) -> tuple[Lever, ...]:
    """Levers of a model file at the case that overrides name, whatever else they move: a page that is opened again has
    the same ones.  Where the file alone is no model, those of the file with its overrides.

    Raises
    ------
    ModelError : the model cannot be read.
    """
    try:
        return levers_of(source, {path: case for path, case in overrides.items() if path == "case"})
    except ModelError:
        return levers_of(source, overrides)


def _that_loads(source: PlainTable | Path, overrides: Mapping[str, object], lever: Lever) -> Lever:
    """A lever whose ends give models, drawn in where the rest of the drawing does not follow, as a rim of a module."""
    ends = []
    for end in (lever.least, lever.most):
        for _ in range(_TRIES):
            try:
                load(source, {**overrides, lever.path: f"{end:.6g} {lever.unit}" if lever.unit else end})
                break
            except ModelError:  # half the way to the value, a whole step
                steps = (lever.value - end) / 2 / lever.step
                end = _clean(end + math.copysign(math.ceil(abs(steps) - 1e-9), steps) * lever.step)
        ends.append(end)
    return replace(lever, least=min(ends[0], lever.value), most=max(ends[1], lever.value))


def _effects(
    source: PlainTable | Path, overrides: Mapping[str, object], train: Train, candidates: list[Lever]
) -> list[Effect]:
    """What every candidate moves; those that are not tried move nothing that is known."""
    kinds = ["damping" if candidate.path.startswith("damping") else candidate.kind for candidate in candidates]
    effects = {i: _KNOWN[kind] for i, kind in enumerate(kinds) if kind in _KNOWN}
    now = figures_of(train)
    turns = [i for i in _in_turn(candidates) if i not in effects][:_TRIALS]
    trials = [replace(candidates[i], value=_tried(candidates[i])) for i in turns]

    def figures_with(lever: Lever) -> Figures:
        return figures_of(load(source, {**overrides, lever.path: lever.written()}))

    found = outcomes(figures_with, trials, workers=False, failing=(ModelError, ConvergenceError, ArithmeticError))
    for i, lever, then in zip(turns, trials, found, strict=True):
        if then.value is not None:
            value = f"{lever.value:.0f}" if 1e3 <= abs(lever.value) < 1e6 else f"{lever.value:.3g}"
            effects[i] = effect_of(now, then.value, f"at {value} {lever.unit}".strip())
    return [effects.get(i, Effect("", 0.0)) for i in range(len(candidates))]


def _in_turn(candidates: list[Lever]) -> list[int]:
    """Places of the candidates, one of each kind in turn, so that their number costs no kind its best."""
    kinds = [candidate.kind for candidate in candidates]
    return sorted(range(len(kinds)), key=lambda i: (kinds[:i].count(kinds[i]), i))


def _tried(candidate: Lever) -> float:
    """Another value of a candidate: twice, of an error without a value a usual one, of design a tenth more."""
    if candidate.kind in _FROM_NONE:
        return 2 * candidate.value if candidate.value else candidate.scaled(_ERROR / 3)
    if candidate.kind == "sun" and not 0 < candidate.value < math.inf:
        return candidate.usual
    return candidate.value * (1.1 if candidate.kind in ("design", "rim") else 2.0)


def _lever(candidate: Lever, effect: Effect) -> Lever:
    value, why, step = candidate.value, effect.words, 0.0
    least, most = sorted(_range(candidate))  # a torque may be negative
    if not candidate.log:  # ends are whole steps: 1, 2, 5, 10 .. times a power of ten
        width = (most - least) / _STEPS
        power = 10.0 ** math.floor(math.log10(width)) if width > 0 else 1.0
        step = max(digit for digit in (1.0, 2.0, 5.0) if digit * power <= width * (1 + 1e-9)) * power
        least, most = math.floor(least / step + 1e-9) * step, math.ceil(most / step - 1e-9) * step
        least = least if least > 0 or value < 0 or candidate.kind in _FROM_NONE else step
    if candidate.kind == "sun" and not 0 < value < math.inf:
        why = ", ".join(filter(None, ["the sun floats now" if value == 0 else "rigid now", why]))
        value = value if value == 0 else most
    return replace(candidate, value=_clean(value), least=_clean(least), most=_clean(most), step=_clean(step), why=why)


def _range(candidate: Lever) -> tuple[float, float]:
    """Ends of a slider in the unit of the candidate."""
    value = candidate.value
    if candidate.kind in _FROM_NONE:
        return min(0.0, _MOST_TIMES * value), max(_MOST_TIMES * abs(value), candidate.scaled(_ERROR))
    if candidate.log:
        middle = value if 0 < value < math.inf else candidate.usual
        power = 10.0 ** round(math.log10(middle))
        return power * _SOFTEST, power * _STIFFEST
    if candidate.path.endswith("helix_angle"):
        return _LEAST * value, min(_MOST_TIMES * value, candidate.scaled(math.radians(_HELIX)))
    if candidate.path.startswith("damping"):
        return _LEAST * value, min(_MOST_TIMES * value, max(_DAMPING, value))
    if candidate.kind in ("design", "rating", "rim"):
        return 0.5 * value, 2 * value
    return _LEAST * value, _MOST_TIMES * value


def _clean(value: float) -> float:
    return float(f"{value:.9g}")
