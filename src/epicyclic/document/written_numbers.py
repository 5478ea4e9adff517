"""Numbers as written in a model file: split into numbers and unit, and written back with other numbers.

Those without a unit where a quantity with a dimension stands are found, and answered with the likely unit.  A person
who writes `module = 10` means ten millimetres, and SI has ten metres.  A file and `--set` over one ask for the unit.
Zero and infinity need no unit.  Numbers in tables built in Python are SI without a word.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any

from ..errors import ModelError
from .units import KINDS, NUMBER, Bounds, kind_words, read_quantity, split_list

_ONE = re.compile(rf"\s*({NUMBER})\s*([^\d\s\[,].*?)?\s*")
_MANY = re.compile(rf"\s*\[\s*({NUMBER}(?:\s*,\s*{NUMBER})*)\s*\]\s*([^\d\s\[,].*?)?\s*")


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


_PLAIN = re.compile(rf"\s*{NUMBER}\s*")

_ANY = Bounds()

# the smallest number that is likely meant in a unit, falling, by kind; any other kind in its SI unit
Ladder = tuple[tuple[float, str], ...]
LIKELY: dict[str, Ladder] = {
    "length": ((1.0, "mm"), (0.0, "m")),  # drawings are in mm; below 1 it can only be m
    "angle": ((1.6, "deg"), (0.0, "rad")),  # angles of gears in rad are below pi/2
    "density": ((100.0, "kg/m^3"), (0.0, "g/cm^3")),
    "pressure": ((1e8, "Pa"), (1e4, "MPa"), (0.0, "GPa")),  # Young's modulus: 2.1e11, 2.1e5, 210
    "viscosity": ((1.0, "mPa s"), (0.0, "Pa s")),  # oils in gears have 3 to 300 mPa s
    "stiffness": ((1e5, "N/m"), (0.0, "N/um")),
    "torsional_stiffness": ((1e4, "N m/rad"), (0.0, "kN m/rad")),
    "power": ((1e4, "W"), (10.0, "kW"), (0.0, "MW")),
    "speed": ((30.0, "rpm"), (0.0, "rad/s")),  # 30 rad/s are 286 rpm: who types 100 means rpm
}
# of errors, reliefs and plays, which drawings have in um
SMALL: Ladder = ((1.0, "um"), (1e-3, "mm"), (0.0, "m"))
# of a mesh, 10 to 30 N/(mm um) per face width [iso6336]
MESH: Ladder = ((1e5, "N/m"), (100.0, "N/um"), (0.0, "N/(mm um)"))


class TypedFloat(float):
    """A number that a person typed without a unit, `--set PATH=0.3`."""


class TypedInt(int):
    """A whole number that a person typed without a unit, `--set PATH=3`."""


class TypedList(str):
    """A list in quotes that a person typed, `--set PATH="[1, 2]"`, whose unit may be missing."""


def typed(value: object) -> object:
    """Return a value of the command line with its numbers marked as typed by a person."""
    if isinstance(value, str) and "[" in value:
        return TypedList(value)
    if isinstance(value, dict):
        return {name: typed(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return [typed(entry) for entry in value]
    if isinstance(value, float):
        return TypedFloat(value)
    return TypedInt(value) if isinstance(value, int) and not isinstance(value, bool) else value


def is_typed(value: object) -> bool:
    """Return whether a person typed any number in a value without a unit."""
    if isinstance(value, dict):
        return any(map(is_typed, value.values()))
    if isinstance(value, (list, tuple)):
        return any(map(is_typed, value))
    return isinstance(value, (TypedFloat, TypedInt, TypedList))


class BareNumber(ModelError):
    """A number without a unit where a quantity with a dimension stands.

    kinds : names in `units.KINDS` of what may stand there.  likely : the value with the unit that is likely meant.
    """

    def __init__(self, value: object, kinds: tuple[str, ...], ladder: Ladder | None) -> None:
        self.kinds, self.likely = kinds, likely_text(value, kinds, ladder)
        super().__init__(f'a number without a unit: "{self.likely}"?', given=value, allowed=kind_words(kinds))


class Probe(ModelError):
    """Answer to the question which quantity stands at a place.

    kinds : names in `units.KINDS`.  ladder : the units a bare number likely means.  bounds : what it may be [SI].
    many : one value per planet may stand there.  whole : it is a count.  lists : only a list may stand there.
    """

    def __init__(
        self,
        kinds: tuple[str, ...],
        ladder: Ladder | None = None,
        *,
        bounds: Bounds = _ANY,
        many: bool = False,
        whole: bool = False,
        lists: bool = False,
    ) -> None:
        self.kinds, self.ladder, self.bounds = kinds, ladder, bounds
        self.many, self.whole, self.lists = many, whole, lists
        super().__init__("asked for")


class _Asked(float):
    """The value that asks which quantity stands in its place."""


ASKED = _Asked(1.0)


@dataclass(slots=True, kw_only=True)
class Reading:
    """Context of one validation.

    strict : a bare number is an error.  found : set where a bare number was met.
    """

    strict: bool = False
    found: bool = field(default=False, init=False)

    def look(
        self,
        value: object,
        kinds: tuple[str, ...],
        ladder: Ladder | None,
        *,
        bounds: Bounds,
        many: bool,
        lists: bool,
    ) -> None:
        """Note a bare number. Raises BareNumber where it is strict, Probe where the place is asked for."""
        if value is ASKED:
            raise Probe(kinds, ladder, bounds=bounds, many=many, lists=lists)
        if bare_in(value, kinds):
            self.found = True
            if self.strict:
                raise BareNumber(value, kinds, ladder)


def stated(value: float | str, kind: str, path: str, *, bounds: Bounds = _ANY) -> float:
    """Return a number in SI as it is, and a text that a person typed in SI; a text must state its unit.

    path : keyword or option, for an error.  Raises ModelError.
    """
    if not isinstance(value, str):
        return float(value)
    if _PLAIN.fullmatch(value) and float(value) != 0:
        bare = BareNumber(float(value), (kind,), None)
        raise ModelError(bare.problem, path=path, given=value, allowed=bare.allowed)
    try:
        read = read_quantity(value, (kind,), bounds)
    except ModelError as error:
        raise ModelError(error.problem, path=path, given=value, allowed=error.allowed) from None
    assert isinstance(read, float)
    return read


def bare_in(value: object, kinds: tuple[str, ...]) -> tuple[float, ...]:
    """Return the finite numbers other than zero that stand without a unit in a value, or in the list it is."""
    if not KINDS[kinds[0]].unit:
        return ()
    items, shared = split_list(value)
    if items is None:
        return (float(value),) if _is_bare(value) else ()  # type: ignore[arg-type]
    texts = shared == "SI"  # "[1, 2]" without a unit behind the bracket
    return tuple(float(v) for v in items if _is_bare(v, texts=texts))  # type: ignore[arg-type]


def _is_bare(value: object, *, texts: bool = False) -> bool:
    if isinstance(value, str):
        return texts and _PLAIN.fullmatch(value) is not None and float(value) != 0
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) < 1e308 and value != 0  # an integer may be too large to be a float; nan and inf have other errors


def likely_text(value: object, kinds: tuple[str, ...], ladder: Ladder | None) -> str:
    """Return a bare number, or a list with some, as a text with the unit that its size makes likely."""
    numbers = bare_in(value, kinds)
    ladder = ladder or LIKELY.get(kinds[0], ((0.0, KINDS[kinds[0]].unit),))
    size = max(map(abs, numbers), default=0.0)
    unit = next(unit for least, unit in ladder if size >= least)
    items, _ = split_list(value)
    if items is None:
        return f"{shown(value)} {unit}"
    if len(items) == len(numbers) + sum(_is_zero(item) for item in items):
        few = items if len(items) <= 8 else [*items[:3], "..."]
        return f"[{', '.join(map(shown, few))}] {unit}"
    return f"{shown(numbers[0])} {unit}"


def _is_zero(value: object) -> bool:
    return value == 0 or (isinstance(value, str) and _PLAIN.fullmatch(value) is not None and float(value) == 0)


def shown(value: Any) -> str:
    """Return a number with the digits of `repr`, as 1e9 or 750; a text as it is."""
    if isinstance(value, str) or not math.isfinite(value):
        return str(value)
    number = Decimal(repr(value)).normalize()
    return f"{number:e}".replace("e+", "e") if abs(number) >= 1e6 or 0 < abs(number) < 1e-4 else f"{number:f}"
