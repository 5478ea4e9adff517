"""Design variables of micro-geometry: bounds read, points of the unit cube to flank settings, settings to overrides.

Amounts are whole nanometres and lengths whole micrometres, so that a model file says exactly what was computed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...teeth.flank import Flank, Relief

__all__ = [
    "KEYS",
    "DesignVariable",
    "FlankSettings",
    "length_text",
    "modified_flank",
    "overrides_of",
    "read_variables",
    "settings_of",
    "varies_along_face",
]

Array = NDArray[np.float64]
Value = float | str
FlankSettings = Mapping[str, Value]
"""Settings of one flank: keys of `KEYS` -> lengths [m], or a shape."""

_TABLES = ("tip_relief", "root_relief", "end_relief")
_SHAPES = ("linear", "parabolic")
# key -> power of ten of its resolution [m]
_RESOLUTION = {f"{table}.{name}": power for table in _TABLES for name, power in (("amount", -9), ("length", -6))}
_RESOLUTION |= {"crown": -9, "slope": -9}
KEYS = (*_RESOLUTION, *(f"{table}.shape" for table in _TABLES))
"""Keys of a flank that may vary."""

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_RANGE = re.compile(rf"\s*({_NUMBER})\s*([A-Za-zµ].*?)?\s*\.\.\s*({_NUMBER})\s*([A-Za-zµ].*?)\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignVariable:
    """One key of one flank, or of several flanks alike, between bounds.

    name : as given by the user, ``p.tip_relief.amount``.  key : of the flank.
    paths : of the flanks in the model file.
    low, high : bounds [m], multiples of the resolution; of a shape 0 and the number of shapes.
    shapes : alternatives of a shape key, else empty.
    """

    name: str
    key: str
    paths: tuple[str, ...]
    low: float
    high: float
    shapes: tuple[str, ...] = ()

    def value(self, coordinate: float) -> Value:
        """Value at a unit-cube coordinate 0..1: a length [m] rounded to the resolution, or a shape."""
        if self.shapes:
            return self.shapes[min(int(coordinate * len(self.shapes)), len(self.shapes) - 1)]
        scale = 10.0 ** -_RESOLUTION[self.key]
        steps = round((self.low + coordinate * (self.high - self.low)) * scale)
        low, high = round(self.low * scale), round(self.high * scale)
        return float(Decimal(min(max(steps, low), high)).scaleb(_RESOLUTION[self.key]))

    def coordinate(self, value: Value) -> float:
        """Unit-cube coordinate of a value; outside 0..1, or nan of a shape, where the value is out of bounds."""
        if self.shapes:
            return (self.shapes.index(str(value)) + 0.5) / len(self.shapes) if value in self.shapes else math.nan
        return (float(value) - self.low) / (self.high - self.low)

    def numeric(self, value: Value) -> float:
        """Length [m], or index of a shape."""
        return float(self.shapes.index(str(value))) if self.shapes else float(value)


def read_variables(
    vary: Mapping[str, object], flanks: Mapping[str, Flank]
) -> tuple[tuple[DesignVariable, ...], dict[str, dict[str, Value]]]:
    """Design variables, and the settings that are fixed to one value.

    Parameters
    ----------
    vary : ``[GEAR.]KEY`` -> ``"0..40 um"``, (low, high) [m], one value, or shapes; without a gear it holds for all
        flanks alike.
    flanks : path in the model file -> flank as drawn.

    Returns
    -------
    Variables in the order of `vary`, and fixed settings by path of the flank.

    Raises
    ------
    ModelError : unknown key or gear, empty bounds, missing or other unit, a key given twice, a relief without length
        or amount.
    """
    variables: list[DesignVariable] = []
    fixed: dict[str, dict[str, Value]] = {path: {} for path in flanks}
    for name, given in vary.items():
        paths, key = _flanks_and_key(str(name), tuple(flanks))
        for path in paths:
            twice = key in fixed[path] or any(key == one.key and path in one.paths for one in variables)
            if twice:
                raise ModelError(f"given twice for {path}", path=f"vary {name}")
        value = _read(given, key, f"vary {name}")
        if isinstance(value, tuple):
            variables.append(_variable(str(name).strip(), key, paths, value))
        else:
            for path in paths:
                fixed[path][key] = value
    if not variables:
        raise ModelError("nothing to vary", path="vary", given=dict(vary), allowed='tip_relief.amount = "0..40 um"')
    _require_complete(variables, fixed, flanks)
    return tuple(variables), fixed


def _variable(name: str, key: str, paths: tuple[str, ...], bounds: tuple[Value, ...]) -> DesignVariable:
    if key in _RESOLUTION:
        low, high = (float(value) for value in bounds)
        return DesignVariable(name=name, key=key, paths=paths, low=low, high=high)
    return DesignVariable(name=name, key=key, paths=paths, low=0.0, high=len(bounds), shapes=tuple(map(str, bounds)))


def _flanks_and_key(name: str, paths: Sequence[str]) -> tuple[tuple[str, ...], str]:
    """Paths of the flanks that ``[GEAR.]KEY`` names, and the key of the flank."""
    text = name.strip()
    key = next((key for key in KEYS if text == key or text.endswith(f".{key}")), None)
    if key is None:
        raise ModelError("no such thing to vary", path="vary", given=name, allowed=", ".join(KEYS))
    gear = text[: -len(key)].rstrip(".").removeprefix("stages.").removesuffix(".flank")
    named = tuple(path for path in paths if not gear or gear in _gear_names(path))
    if not named:
        allowed = ", ".join(sorted({sorted(_gear_names(path), key=len)[0] for path in paths}))
        raise ModelError("no such gear in the meshes looked at", path=f"vary {name}", given=gear, allowed=allowed)
    return named, key


def _gear_names(path: str) -> set[str]:
    """Names of the gear of a flank: p, main.p; of one side p.left, main.p.left too."""
    stage, gear, *side = path.removeprefix("stages.").removesuffix(".flank").split(".")
    return {gear, f"{stage}.{gear}", ".".join([gear, *side]), ".".join([stage, gear, *side])}


def _read(given: object, key: str, path: str) -> Value | tuple[Value, ...]:
    """One value, bounds [m], or shapes."""
    if key not in _RESOLUTION:
        return _shapes(given, path)
    if isinstance(given, str) and ".." in given:
        match = _RANGE.fullmatch(given)
        if match is None:
            raise ModelError("not a range with a unit", path=path, given=given, allowed='"0..40 um"')
        first, one, last, other = match.groups()
        return _bounds(_metres(f"{first} {one or other}", path), _metres(f"{last} {other}", path), key, path, given)
    if _is_pair(given):
        return _bounds(_metres(given[0], path), _metres(given[1], path), key, path, given)
    return _removing(_metres(given, path), key, path)


def _is_pair(given: object) -> TypeGuard[Sequence[object]]:
    return isinstance(given, (tuple, list)) and len(given) == 2


def _metres(given: object, path: str) -> float:
    """Length in SI [m] of a number, or of a text with its unit."""
    from ...document.units import Bounds, read_quantity

    try:
        value = read_quantity(given, ("length",), Bounds())
    except ModelError as error:
        raise ModelError(error.problem, path=path, given=given, allowed=error.allowed) from None
    assert isinstance(value, float)
    return value


def _bounds(low: float, high: float, key: str, path: str, given: object) -> tuple[float, float]:
    """Bounds [m] drawn in to multiples of the resolution."""
    power = _RESOLUTION[key]
    # 1e-6 of a step: a bound on a multiple must not be lost to rounding
    first, last = (math.ceil(low * 10.0**-power - 1e-6), math.floor(high * 10.0**-power + 1e-6))
    if key.endswith("length"):
        first = max(first, 1)  # a relief of zero length is none: the shortest is one step long
    if not first < last:
        problem = "empty bounds" if low >= high else f"bounds nearer than {10.0**power:g} m"
        raise ModelError(problem, path=path, given=given, allowed="low .. high")
    _removing(low, key, path)
    return float(Decimal(first).scaleb(power)), float(Decimal(last).scaleb(power))


def _removing(value: float, key: str, path: str) -> float:
    """The value, refused where it would add material; a slope may have either sign."""
    if value < 0 and key != "slope":
        raise ModelError("takes material off", path=path, given=value, allowed="0 or more")
    return value


def _shapes(given: object, path: str) -> Value | tuple[Value, ...]:
    names = [part.strip() for part in given.split(",")] if isinstance(given, str) else given
    if not isinstance(names, (list, tuple)) or not names or any(name not in _SHAPES for name in names):
        raise ModelError("no such shape", path=path, given=given, allowed=", ".join(_SHAPES))
    return str(names[0]) if len(names) == 1 else tuple(dict.fromkeys(map(str, names)))


def _require_complete(
    variables: Sequence[DesignVariable], fixed: Mapping[str, FlankSettings], flanks: Mapping[str, Flank]
) -> None:
    """Refuse a changed relief whose amount or length is neither drawn nor given."""
    for path, flank in flanks.items():
        keys = {one.key: one.name for one in variables if path in one.paths} | {key: key for key in fixed[path]}
        for table in _TABLES:
            changed = [key for key in keys if key.startswith(table)]
            if not changed or getattr(flank, table) is not None:
                continue
            for name in ("amount", "length"):
                if f"{table}.{name}" not in keys:
                    problem = f"{path}.{table} has no {name}, neither drawn nor given"
                    raise ModelError(problem, path=f"vary {keys[changed[0]]}", allowed=f"{table}.{name} beside it")


def varies_along_face(variables: Sequence[DesignVariable], fixed: Mapping[str, FlankSettings]) -> bool:
    """Whether a variable or a fixed setting is a lead modification: end relief, crown or slope."""
    keys = [*(one.key for one in variables), *(key for settings in fixed.values() for key in settings)]
    return any(key.startswith(("end_relief", "crown", "slope")) for key in keys)


def settings_of(
    variables: Sequence[DesignVariable], fixed: Mapping[str, FlankSettings], candidate: Array
) -> dict[str, dict[str, Value]]:
    """Settings of one candidate (v,) in the unit cube, by path of the flank; fixed ones included."""
    settings = {path: dict(values) for path, values in fixed.items()}
    for variable, coordinate in zip(variables, candidate.tolist(), strict=True):
        for path in variable.paths:
            settings[path][variable.key] = variable.value(coordinate)
    return settings


def modified_flank(flank: Flank, settings: FlankSettings) -> Flank:
    """Flank with settings in place of what is drawn."""
    changes: dict[str, object] = {key: settings[key] for key in ("crown", "slope") if key in settings}
    for table in _TABLES:
        new = {key.split(".")[1]: value for key, value in settings.items() if key.startswith(f"{table}.")}
        if new:
            old = getattr(flank, table) or Relief(amount=0.0, length=0.0)
            changes[table] = replace(old, **new)
    return replace(flank, **changes)  # type: ignore[arg-type]


def overrides_of(settings: Mapping[str, FlankSettings], flanks: Mapping[str, Flank]) -> dict[str, str]:
    """Settings as overrides of the model file; of a changed relief all keys, as some may be drawn on another side."""
    overrides: dict[str, str] = {}
    for path, values in settings.items():
        flank = modified_flank(flanks[path], values)
        for table in _TABLES:
            if any(key.startswith(f"{table}.") for key in values):
                relief = getattr(flank, table)
                overrides[f"{path}.{table}.amount"] = length_text(relief.amount, -6)
                overrides[f"{path}.{table}.length"] = length_text(relief.length, -3)
                overrides[f"{path}.{table}.shape"] = relief.shape
        for key in ("crown", "slope"):
            if key in values:
                overrides[f"{path}.{key}"] = length_text(getattr(flank, key), -6)
    return overrides


def length_text(value: float, power: int) -> str:
    """Length [m] as a text in um (power -6) or mm (-3) that is read back exactly."""
    unit = {-6: "um", -3: "mm"}[power]
    return f"{Decimal(repr(value)).scaleb(-power).normalize():f} {unit}"
