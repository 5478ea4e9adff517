"""A lever over one entry of a list of the model file: its number, and the list with another one."""

from __future__ import annotations

import math

from ...document.units import factor
from ...document.written_numbers import Written, written

__all__ = ["entry_of", "with_entry"]


def entry_of(value: object, unit: str, entry: int) -> float | None:
    """Entry from 0 of a value as written, in a unit; 0 of a value that is missing, None of what is no number.

    One number stands for every entry.
    """
    if value is None:
        return 0.0
    found = written(value)
    if found is None or (found.many and entry >= len(found.values)):
        return None
    number = found.values[entry if found.many else 0]
    scale = 1.0 if found.unit == unit or not number else factor(found.unit, unit) if found.unit and unit else None
    return None if scale is None or not math.isfinite(number * scale) else number * scale


def with_entry(value: object, unit: str, entry: int, count: int, number: float) -> object:
    """Override of a list of `count` entries, with one of them, from 0, another number in the unit."""
    values = [entry_of(value, unit, place) or 0.0 for place in range(count)]
    values[entry] = number
    return Written(values=tuple(values), unit=unit, many=True).text(tuple(float(f"{one:.9g}") for one in values))
