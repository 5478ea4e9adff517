"""Numbers as written in a model file: split into numbers and unit, and written back with other numbers."""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["Written", "written"]

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,4})?"
_ONE = re.compile(rf"\s*({_NUMBER})\s*([^\d\s\[,].*?)?\s*")
_MANY = re.compile(rf"\s*\[\s*({_NUMBER}(?:\s*,\s*{_NUMBER})*)\s*\]\s*([^\d\s\[,].*?)?\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Written:
    """One number or a list, with the unit it is written in ("" for a bare number, which is SI).

    values : the numbers in that unit.  many : whether a list stands there.  whole : whether it is an integer.
    """

    values: tuple[float, ...]
    unit: str
    many: bool
    whole: bool = False

    def text(self, values: tuple[float, ...]) -> object:
        """Value of the file for other numbers in the same unit: a list where there are several."""
        plain = [float(value) for value in values]  # repr of a number of numpy is no TOML
        if len(plain) == 1 and not self.many:
            return f"{plain[0]!r} {self.unit}" if self.unit else plain[0]
        return f"[{', '.join(map(repr, plain))}] {self.unit}" if self.unit else plain


def written(value: object) -> Written | None:
    """Numbers and unit of a value of the file; None where it is no finite number or list of numbers."""
    if isinstance(value, bool):
        return None
    if isinstance(value, (int, float)):
        return Written(values=(float(value),), unit="", many=False, whole=isinstance(value, int))
    if isinstance(value, (list, tuple)):
        return _listed(list(value))
    if not isinstance(value, str):
        return None
    if one := _ONE.fullmatch(value):
        return Written(values=(float(one[1]),), unit=one[2] or "", many=False)
    if many := _MANY.fullmatch(value):
        return Written(values=tuple(float(part) for part in many[1].split(",")), unit=many[2] or "", many=True)
    return None


def _listed(entries: list[object]) -> Written | None:
    """Numbers of a list whose entries all have one unit; None for any other list."""
    parts = [written(entry) for entry in entries]
    found = [part for part in parts if part is not None and not part.many]
    if not entries or len(found) < len(entries) or len({part.unit for part in found}) > 1:
        return None
    return Written(values=tuple(part.values[0] for part in found), unit=found[0].unit, many=True)
