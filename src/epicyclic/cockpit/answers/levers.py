"""The levers of a train: about seven numbers of its model that are worth a slider, by what they move.

A lever is found among the numbers that the model has, tried at another value, and ranked by what K_gamma and the
natural frequencies make of it; every kind has its places, so that seven levers are not seven run-outs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from ...document.document import file_text, parse_text
from ...document.tables import PlainTable
from ...errors import ConvergenceError, ModelError
from ...train.resolution import load
from ...train.train import Train
from .lever_candidates import Candidate, candidates_of
from .lever_effects import Effect, effect_of, figures_of

__all__ = ["ModelLever", "levers_of"]

# Levers that one screen shows beside their number boxes, and how many of each kind are taken first.
_MOST = 7
_PLACES = {"pin": 1, "run_out": 1, "sun": 1, "support": 1, "load": 1, "speed": 1, "design": 1}
# Candidates that are tried, 20 ms each of a small train: a model opens meanwhile.  Those that are left move nothing
# known.  A number and no time, so that a model has the same levers whatever else the machine does.
_TRIALS = 12
# What needs no trial, and its size for ranking: small, that none of them takes the place of what moves the sharing.
_KNOWN = {
    "load": Effect(words="mesh forces follow it one to one", size=2e-3),
    "speed": Effect(words="mesh frequencies follow it one to one", size=2e-3),
    "damping": Effect(words="the height of the resonances", size=1e-3),
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


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelLever:
    """One slider.

    path : of the override.  label : in words.  value, least, most, step : in `unit`, "" of a plain number.
    integer : whether whole numbers alone are allowed.  log : whether the slider is logarithmic.
    why : what it does to this train.  entry, count : place from 0 and number of entries, where the value is one entry
        of a list at the path; None of a single number.
    """

    path: str
    label: str
    value: float
    unit: str
    least: float
    most: float
    step: float
    integer: bool = False
    log: bool = False
    why: str = ""
    entry: int | None = None
    count: int | None = None


def levers_of(source: PlainTable | Path, overrides: Mapping[str, object]) -> tuple[ModelLever, ...]:
    """Levers of a model, at most seven, in the order of the page: errors, supports, load, design.

    Raises
    ------
    ModelError : the model is wrong.
    """
    train = load(source, dict(overrides))
    tables = parse_text(file_text(source), str(source)) if isinstance(source, Path) else source
    found = candidates_of(train, tables, overrides)
    effects = _effects(source, overrides, train, found)
    ranked = sorted(range(len(found)), key=lambda i: (-effects[i].size, i))
    chosen: list[int] = []
    places = dict(_PLACES)
    for i in ranked:
        if places.get(found[i].kind, 0) > 0:
            places[found[i].kind] -= 1
            chosen.append(i)
    # places that no candidate takes go to those that move most
    for i in ranked:
        if len(chosen) >= _MOST:
            break
        if i not in chosen and effects[i].size > 0:
            chosen.append(i)
    levers = (_lever(found[i], effects[i]) for i in sorted(chosen))
    # of geometry alone an end may contradict the rest of the drawing
    return tuple(one if one.log or not _is_drawn(one) else _that_loads(source, overrides, one) for one in levers)


def _is_drawn(lever: ModelLever) -> bool:
    return lever.path.startswith("stages")


def _that_loads(source: PlainTable | Path, overrides: Mapping[str, object], lever: ModelLever) -> ModelLever:
    """A lever whose ends give models, drawn in where the rest of the drawing does not follow, as a rim of a module."""
    ends = []
    for end in (lever.least, lever.most):
        for _ in range(_TRIES):
            if _loads(source, {**overrides, lever.path: f"{end:.6g} {lever.unit}" if lever.unit else end}):
                break
            end = _half_way(end, lever)
        ends.append(end)
    return replace(lever, least=min(ends[0], lever.value), most=max(ends[1], lever.value))


def _half_way(end: float, lever: ModelLever) -> float:
    """Half the way from an end to the value, a whole step."""
    if lever.log or not lever.step:
        return lever.value
    steps = (lever.value - end) / 2 / lever.step
    return _clean(end + math.copysign(math.ceil(abs(steps) - 1e-9), steps) * lever.step)


def _loads(source: PlainTable | Path, overrides: Mapping[str, object]) -> bool:
    try:
        load(source, overrides)
    except ModelError:
        return False
    return True


def _effects(
    source: PlainTable | Path, overrides: Mapping[str, object], train: Train, found: list[Candidate]
) -> list[Effect]:
    """What every candidate moves; those that are not tried move nothing that is known."""
    result = {i: _KNOWN[_known(one)] for i, one in enumerate(found) if _known(one) in _KNOWN}
    now = figures_of(train)
    nothing = Effect(words="", size=0.0)
    for i in [i for i in _in_turn(found) if i not in result][:_TRIALS]:
        one = replace(found[i], value=_tried(found[i]))
        try:
            then = figures_of(load(source, {**overrides, one.path: one.written()}))
        except (ModelError, ConvergenceError, ArithmeticError):
            continue
        result[i] = effect_of(now, then, f"at {_short(one.value)} {one.unit}".strip())
    return [result.get(i, nothing) for i in range(len(found))]


def _known(one: Candidate) -> str:
    return "damping" if one.path.startswith("damping") else one.kind


def _in_turn(found: list[Candidate]) -> list[int]:
    """Places of the candidates, one of each kind in turn, so that their number costs no kind its best."""
    seen: dict[str, int] = {}
    rounds = []
    for i, one in enumerate(found):
        rounds.append((seen.get(one.kind, 0), i))
        seen[one.kind] = seen.get(one.kind, 0) + 1
    return [i for _, i in sorted(rounds)]


def _tried(one: Candidate) -> float:
    """Another value of a candidate: twice, of an error without a value a usual one, of design a tenth more."""
    if one.kind in ("pin", "run_out"):
        return 2 * one.value if one.value else one.scaled(_ERROR / 3)
    if one.kind == "sun" and not 0 < one.value < math.inf:
        return one.usual
    return one.value * (1.1 if one.kind == "design" else 2.0)


def _lever(one: Candidate, effect: Effect) -> ModelLever:
    value, least, most = one.value, *_range(one)
    step = _nice((most - least) / _STEPS)
    if not one.log:
        least, most = math.floor(least / step + 1e-9) * step, math.ceil(most / step - 1e-9) * step
        least = least if least > 0 or one.kind in ("pin", "run_out") else step
    why = effect.words
    if one.kind == "sun" and not 0 < value < math.inf:
        why = ", ".join(filter(None, ["the sun floats now" if value == 0 else "rigid now", why]))
        value = value if value == 0 else most
    return ModelLever(
        path=one.path,
        label=one.label,
        value=_clean(value),
        unit=one.unit,
        least=_clean(least),
        most=_clean(most),
        step=0.0 if one.log else _clean(step),
        log=one.log,
        why=why,
        entry=one.entry,
        count=one.count,
    )


def _range(one: Candidate) -> tuple[float, float]:
    """Ends of a slider in the unit of the candidate."""
    value = one.value
    if one.kind in ("pin", "run_out"):
        return 0.0, max(_MOST_TIMES * abs(value), one.scaled(_ERROR))
    if one.log:
        middle = value if 0 < value < math.inf else one.usual
        power = 10.0 ** round(math.log10(middle))
        return power * _SOFTEST, power * _STIFFEST
    if one.path.endswith("helix_angle"):
        return _LEAST * value, min(_MOST_TIMES * value, one.scaled(math.radians(_HELIX)))
    if one.path.startswith("damping"):
        return _LEAST * value, min(_MOST_TIMES * value, max(_DAMPING, value))
    if one.kind == "design":
        return 0.5 * value, 2 * value
    return _LEAST * value, _MOST_TIMES * value


def _nice(value: float) -> float:
    """The next of 1, 2, 5, 10 .. times a power of ten at or below a value."""
    power = 10.0 ** math.floor(math.log10(value)) if value > 0 else 1.0
    return max(one for one in (1.0, 2.0, 5.0) if one * power <= value * (1 + 1e-9)) * power


def _clean(value: float) -> float:
    return float(f"{value:.9g}")


def _short(value: float) -> str:
    return f"{value:.3g}" if not 1e3 <= abs(value) < 1e6 else f"{value:.0f}"
