"""What a search for micro-geometry may change: bounds read, places in a unit cube to flanks, flanks to overrides."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..gears.flank import Flank, Relief

__all__ = [
    "KEYS",
    "Setting",
    "Variable",
    "applied",
    "lead_varies",
    "length_text",
    "overrides_of",
    "settings_of",
    "variables_of",
]

Array = NDArray[np.float64]
Value = float | str
Setting = Mapping[str, Value]
"""What is set on one flank: its keys -> values in SI, or a shape."""

_TABLES = ("tip_relief", "root_relief", "end_relief")
_SHAPES = ("linear", "parabolic")
# key -> resolution [m]: amounts to the nanometre, lengths to the micrometre, as a drawing can say them
_STEPS = {f"{table}.{name}": step for table in _TABLES for name, step in (("amount", -9), ("length", -6))}
_STEPS |= {"crown": -9, "slope": -9}
KEYS = (*_STEPS, *(f"{table}.shape" for table in _TABLES))
"""Keys of a flank that may vary."""

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_RANGE = re.compile(rf"\s*({_NUMBER})\s*([A-Za-zµ].*?)?\s*\.\.\s*({_NUMBER})\s*([A-Za-zµ].*?)\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """One thing that varies, alike on one flank or on several.

    name : as asked for, ``p.tip_relief.amount``.  key : of the flank.  paths : of the flanks in the model file.
    low, high : bounds [m], in whole steps; of shapes 0 and the number of them.  shapes : those to choose from.
    """

    name: str
    key: str
    paths: tuple[str, ...]
    low: float
    high: float
    shapes: tuple[str, ...] = ()

    def value(self, place: float) -> Value:
        """Value at a place 0..1 between the bounds: in whole steps, or a shape."""
        if self.shapes:
            return self.shapes[min(int(place * len(self.shapes)), len(self.shapes) - 1)]
        scale = 10.0 ** -_STEPS[self.key]
        steps = round((self.low + place * (self.high - self.low)) * scale)
        low, high = round(self.low * scale), round(self.high * scale)
        return float(Decimal(min(max(steps, low), high)).scaleb(_STEPS[self.key]))

    def place(self, value: Value) -> float:
        """Place 0..1 of a value; outside that where it is out of bounds."""
        if self.shapes:
            return (self.shapes.index(str(value)) + 0.5) / len(self.shapes) if value in self.shapes else math.nan
        return (float(value) - self.low) / (self.high - self.low)

    def number(self, value: Value) -> float:
        """A value as a number [m], a shape as its position."""
        return float(self.shapes.index(str(value))) if self.shapes else float(value)


def variables_of(
    vary: Mapping[str, object], flanks: Mapping[str, Flank]
) -> tuple[tuple[Variable, ...], dict[str, dict[str, Value]]]:
    """Read what varies, and what is set to one value.

    Parameters
    ----------
    vary : ``[GEAR.]KEY`` -> ``"0..40 um"``, (low, high) in m, one value, or shapes.  Without a gear it holds for all
        flanks alike.  flanks : by their path in the model file, as drawn.

    Returns
    -------
    Variables, and settings by path of the flank.

    Raises
    ------
    ModelError : no such key or gear, empty bounds, no or another unit, given twice, a relief without length or amount.
    """
    found: list[Variable] = []
    fixed: dict[str, dict[str, Value]] = {path: {} for path in flanks}
    for name, given in vary.items():
        paths, key = _addressed(str(name), tuple(flanks))
        for path in paths:
            twice = key in fixed[path] or any(key == one.key and path in one.paths for one in found)
            if twice:
                raise ModelError(f"given twice for {path}", path=f"vary {name}")
        read = _read(given, key, f"vary {name}")
        if isinstance(read, tuple):
            found.append(_variable(str(name).strip(), key, paths, read))
        else:
            for path in paths:
                fixed[path][key] = read
    if not found:
        raise ModelError("nothing to vary", path="vary", given=dict(vary), allowed='tip_relief.amount = "0..40 um"')
    _check_complete(found, fixed, flanks)
    return tuple(found), fixed


def _variable(name: str, key: str, paths: tuple[str, ...], read: tuple[Value, ...]) -> Variable:
    if key in _STEPS:
        low, high = (float(value) for value in read)
        return Variable(name=name, key=key, paths=paths, low=low, high=high)
    return Variable(name=name, key=key, paths=paths, low=0.0, high=len(read), shapes=tuple(map(str, read)))


def _addressed(name: str, paths: Sequence[str]) -> tuple[tuple[str, ...], str]:
    """Flanks that a name means, and the key of the flank."""
    text = name.strip()
    key = next((key for key in KEYS if text == key or text.endswith(f".{key}")), None)
    if key is None:
        raise ModelError("no such thing to vary", path="vary", given=name, allowed=", ".join(KEYS))
    gear = text[: -len(key)].rstrip(".").removeprefix("stages.").removesuffix(".flank")
    meant = tuple(path for path in paths if not gear or gear in _names(path))
    if not meant:
        allowed = ", ".join(sorted({sorted(_names(path), key=len)[0] for path in paths}))
        raise ModelError("no such gear in the meshes looked at", path=f"vary {name}", given=gear, allowed=allowed)
    return meant, key


def _names(path: str) -> set[str]:
    """What the gear of a flank is called: p, main.p; of one side p.left, main.p.left too."""
    stage, gear, *side = path.removeprefix("stages.").removesuffix(".flank").split(".")
    return {gear, f"{stage}.{gear}", ".".join([gear, *side]), ".".join([stage, gear, *side])}


def _read(given: object, key: str, path: str) -> Value | tuple[Value, ...]:
    """One value, or bounds, or shapes."""
    if key not in _STEPS:
        return _shapes(given, path)
    if isinstance(given, str) and ".." in given:
        found = _RANGE.fullmatch(given)
        if found is None:
            raise ModelError("not a range with a unit", path=path, given=given, allowed='"0..40 um"')
        first, one, last, other = found.groups()
        return _bounds(_metres(f"{first} {one or other}", path), _metres(f"{last} {other}", path), key, path, given)
    if _is_pair(given):
        return _bounds(_metres(given[0], path), _metres(given[1], path), key, path, given)
    return _least(_metres(given, path), key, path)


def _is_pair(given: object) -> TypeGuard[Sequence[object]]:
    return isinstance(given, (tuple, list)) and len(given) == 2


def _metres(given: object, path: str) -> float:
    from ..model.units import Bounds, read_quantity

    try:
        value = read_quantity(given, ("length",), Bounds())
    except ModelError as error:
        raise ModelError(error.problem, path=path, given=given, allowed=error.allowed) from None
    assert isinstance(value, float)
    return value


def _bounds(low: float, high: float, key: str, path: str, given: object) -> tuple[float, float]:
    step = _STEPS[key]
    first, last = (math.ceil(low * 10.0**-step - 1e-6), math.floor(high * 10.0**-step + 1e-6))
    if key.endswith("length"):
        first = max(first, 1)  # a relief of no length is none: the shortest is a step long
    if not first < last:
        problem = "empty bounds" if low >= high else f"bounds nearer than {10.0**step:g} m"
        raise ModelError(problem, path=path, given=given, allowed="low .. high")
    _least(low, key, path)
    return float(Decimal(first).scaleb(step)), float(Decimal(last).scaleb(step))


def _least(value: float, key: str, path: str) -> float:
    if value < 0 and key != "slope":
        raise ModelError("takes material off", path=path, given=value, allowed="0 or more")
    return value


def _shapes(given: object, path: str) -> Value | tuple[Value, ...]:
    words = [part.strip() for part in given.split(",")] if isinstance(given, str) else given
    if not isinstance(words, (list, tuple)) or not words or any(word not in _SHAPES for word in words):
        raise ModelError("no such shape", path=path, given=given, allowed=", ".join(_SHAPES))
    return str(words[0]) if len(words) == 1 else tuple(dict.fromkeys(map(str, words)))


def _check_complete(found: Sequence[Variable], fixed: Mapping[str, Setting], flanks: Mapping[str, Flank]) -> None:
    """A relief that is touched needs amount and length, drawn or given."""
    for path, flank in flanks.items():
        keys = {one.key: one.name for one in found if path in one.paths} | {key: key for key in fixed[path]}
        for table in _TABLES:
            mine = [key for key in keys if key.startswith(table)]
            if not mine or getattr(flank, table) is not None:
                continue
            for name in ("amount", "length"):
                if f"{table}.{name}" not in keys:
                    problem = f"{path}.{table} has no {name}, neither drawn nor given"
                    raise ModelError(problem, path=f"vary {keys[mine[0]]}", allowed=f"{table}.{name} beside it")


def lead_varies(variables: Sequence[Variable], fixed: Mapping[str, Setting]) -> bool:
    """Whether anything along the face is set."""
    keys = [*(one.key for one in variables), *(key for table in fixed.values() for key in table)]
    return any(key.startswith(("end_relief", "crown", "slope")) for key in keys)


def settings_of(
    variables: Sequence[Variable], fixed: Mapping[str, Setting], place: Array
) -> dict[str, dict[str, Value]]:
    """What one place (v,) in the unit cube sets, by path of the flank."""
    settings = {path: dict(values) for path, values in fixed.items()}
    for variable, at in zip(variables, place.tolist(), strict=True):
        for path in variable.paths:
            settings[path][variable.key] = variable.value(at)
    return settings


def applied(flank: Flank, setting: Setting) -> Flank:
    """A flank with what is set on it."""
    changes: dict[str, object] = {key: setting[key] for key in ("crown", "slope") if key in setting}
    for table in _TABLES:
        new = {key.split(".")[1]: value for key, value in setting.items() if key.startswith(f"{table}.")}
        if new:
            old = getattr(flank, table) or Relief(amount=0.0, length=0.0)
            changes[table] = replace(old, **new)
    return replace(flank, **changes)  # type: ignore[arg-type]


def overrides_of(settings: Mapping[str, Setting], flanks: Mapping[str, Flank]) -> dict[str, str]:
    """Settings as overrides of the model file; of a relief that is touched all keys, as some may stand elsewhere."""
    overrides: dict[str, str] = {}
    for path, setting in settings.items():
        flank = applied(flanks[path], setting)
        for table in _TABLES:
            if any(key.startswith(f"{table}.") for key in setting):
                relief = getattr(flank, table)
                overrides[f"{path}.{table}.amount"] = length_text(relief.amount, -6)
                overrides[f"{path}.{table}.length"] = length_text(relief.length, -3)
                overrides[f"{path}.{table}.shape"] = relief.shape
        for key in ("crown", "slope"):
            if key in setting:
                overrides[f"{path}.{key}"] = length_text(getattr(flank, key), -6)
    return overrides


def length_text(value: float, power: int) -> str:
    """A length that is read back to the bit, in um (power -6) or mm (-3)."""
    unit = {-6: "um", -3: "mm"}[power]
    return f"{Decimal(repr(value)).scaleb(-power).normalize():f} {unit}"
