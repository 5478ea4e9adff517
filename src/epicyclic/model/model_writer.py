"""A model document as a file of format 2: numbers in SI with the units a drawing has, that load to the same bits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from decimal import Decimal
from typing import Any

from .bare_numbers import shown
from .names import collect
from .shorthand import expand
from .tables import PlainTable, clean
from .tolerances import rewritten
from .toml_writer import to_toml
from .units import COMMON, KINDS, Bounds, Quantity, read_quantity
from .validation import LISTED, bare_places, quantity_at, unlisted_paths

__all__ = ["model_text", "quantity_text", "unit_text", "with_units"]

_MOST = 10_000  # from there on a number with its unit is no longer short
# units tried in this order: the first in which a number lies between 1 and _MOST; SI where none does
_DRAWN = {
    "m": ("mm", "um"),
    "N/m": ("N/m",),
    "N": ("N", "kN"),
    "Pa": ("GPa", "MPa"),
    "N m": ("N m", "kN m"),
    "W": ("W", "kW", "MW"),
}
_ANGLES = ("deg", "rpm")  # no power of ten: only where a short number in them has the same bits


def model_text(data: Mapping[str, Any]) -> str:
    """Return a model document as TOML of format 2.

    Numbers without a unit get one; reading the text gives the same bits. Raises ModelError for a document that is none.
    """
    return to_toml(with_units(data))


def with_units(data: Mapping[str, Any]) -> PlainTable:
    """Return a model document as format 2: the same with a unit at every number of a quantity with a dimension."""
    plain: PlainTable = clean(data) | {"format": LISTED}
    names = collect(plain)
    expanded = expand(plain, names)
    if data.get("format") == 1 and isinstance(expanded.get("tolerance"), dict):
        table = rewritten(expanded | {"format": 1}, quantity_text)
        expanded = expanded | {"tolerance": table}
    for place in bare_places(expanded, names, None):
        expanded = _replaced(expanded, place.path.split("."), place.error.kinds, unit_text)
    for path in unlisted_paths(expanded, names):  # texts of a file of format 1
        kinds = quantity_at(expanded, path, names, None).kinds
        expanded = _replaced(expanded, path.split("."), kinds, _rewritten)
    return expanded


def _replaced(
    table: PlainTable, path: list[str], kinds: tuple[str, ...], write: Callable[[Any, tuple[str, ...]], Any]
) -> PlainTable:
    """Return a table with the value at a path written anew."""
    first, *rest = path
    value = table[first]
    return {**table, first: _replaced(value, rest, kinds, write) if rest else write(value, kinds)}


def _rewritten(value: Any, kinds: tuple[str, ...]) -> Any:
    """Return texts with units of any spelling in units of format 2."""
    if isinstance(value, list):
        return [_rewritten(entry, kinds) for entry in value]
    if not isinstance(value, str):
        return value
    read = read_quantity(value, kinds, Bounds(inf=True), many=True)
    kind = next((k for k in kinds if isinstance(read, Quantity) and KINDS[k].unit == read.unit), kinds[0])
    numbers = read.value if isinstance(read, Quantity) else read
    return _list(list(numbers), kind) if isinstance(numbers, tuple) else quantity_text(float(numbers), kind)


def unit_text(value: Any, kinds: tuple[str, ...]) -> Any:
    """Return a value as a text with its unit; of a list of numbers as one text."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return quantity_text(float(value), kinds[0])
    if isinstance(value, str):  # a list without a unit behind the bracket
        return f"{value} {KINDS[kinds[0]].unit}"
    if all(isinstance(entry, (int, float)) for entry in value):
        return _list([float(entry) for entry in value], kinds[0])
    return [entry if isinstance(entry, str) and "[" not in entry else unit_text(entry, kinds) for entry in value]


def quantity_text(value: float, kind: str) -> str:
    """Return one number in SI with the unit in which it is short, and from which it is read with the same bits."""
    for unit in _DRAWN.get(KINDS[kind].unit, ()):
        number = _moved(value, unit)
        if 1 <= abs(number) < _MOST and _reads(text := f"{number:f}", unit, kind, value):
            return f"{text} {unit}"
    for unit in _ANGLES:
        if COMMON[unit][1] == KINDS[kind].unit and _reads(text := f"{value / COMMON[unit][0]:.10g}", unit, kind, value):
            return f"{text} {unit}"
    return f"{shown(value)} {KINDS[kind].unit}"


def _list(values: list[float], kind: str) -> str:
    """Return numbers as a list with one unit."""
    size = max(map(abs, values))
    for unit in _DRAWN.get(KINDS[kind].unit, ()):
        texts = [shown(float(_moved(value, unit))) for value in values]
        same = all(_reads(text, unit, kind, value) for text, value in zip(texts, values, strict=True))
        if same and 1 <= abs(_moved(size, unit)) < _MOST:
            return f"[{', '.join(texts)}] {unit}"
    return f"[{', '.join(map(shown, values))}] {KINDS[kind].unit}"


def _moved(value: float, unit: str) -> Decimal:
    """Return the number of a value in SI in a unit that is a power of ten of it: no digit changes."""
    return (Decimal(repr(value)) / Decimal(repr(COMMON[unit][0]))).normalize()


def _reads(text: str, unit: str, kind: str, value: float) -> bool:
    """Return whether a text with a unit is read as a value to the bit."""
    return read_quantity(f"{text} {unit}", (kind,), Bounds(inf=True)) == value
