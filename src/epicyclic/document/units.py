"""Numbers with units at the border: text or bare number -> SI.

The spellings that stand in nearly every file are converted from a table (tested against pint); everything else goes
through pint, which is imported only then.  Which spellings a model file may have says one pattern a kind of
quantity, for the reader and for the JSON Schema.  It is put together from the units of length, force, ... as the
dimension is, so that a text of another dimension cannot match.

Numbers as written in a model file are split into numbers and unit, and written back with other numbers.  Those
without a unit where a quantity with a dimension stands are found, and answered with the likely unit.  A person who
writes `module = 10` means ten millimetres, and SI has ten metres.  A file and `--set` over one ask for the unit.  Zero
and infinity need no unit.  Numbers in tables built in Python are SI without a word.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache, lru_cache
from typing import Any

from ..errors import ModelError

# no \d: to Python it is a digit of any script, to ECMAScript, which JSON Schema follows, an ASCII one
_BLANK = r"\s*"
NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?"
_ZERO = r"[+-]?(?:0+(?:\.0*)?|\.0+)(?:[eE][+-]?[0-9]{1,4})?"
_INF = r"[+]?inf"

_TIMES = r"(?: *[*·] *| +)"
_OVER = " */ *"
_SQUARED = r"(?:\^2|\*\*2|²)"
_CUBED = r"(?:\^3|\*\*3|³)"
_MICRO = "uµμ"  # the letter u, the micro sign and the Greek letter

_LENGTH = f"(?:[kcdm{_MICRO}n]?m|in|inch|ft|thou)"
_AREA = _LENGTH + _SQUARED
_TIME = f"(?:[m{_MICRO}n]?s|min|h)"
_MASS = f"(?:[km{_MICRO}M]?g|t|lb|oz|slug)"
_FORCE = f"(?:[kMGm{_MICRO}]?N|lbf|kip|kgf)"
_ANGLE = f"(?:[m{_MICRO}]?rad|deg|degree|°|arcmin|arcsec|gon|rev|turn)"
_STRESS = "(?:[hkMG]?Pa|bar|psi|ksi)"
_POWER = f"(?:[m{_MICRO}kMG]?W|hp)"
_TORQUE = f"(?:{_FORCE}{_TIMES}{_LENGTH}|{_LENGTH}{_TIMES}{_FORCE})"


def _per(*below: str) -> str:
    """Quotient of what stands before by the product of units: by one after the other, or in brackets."""
    return f"(?:{_OVER}{_OVER.join(below)}|{_OVER}\\( *{_TIMES.join(below)} *\\))"


_PER_WIDTH = f"(?:{_FORCE}(?:{_OVER}{_AREA}|{_per(_LENGTH, _LENGTH)})|{_STRESS})"
_DAMPER = f"{_FORCE}(?:{_TIMES}{_TIME}{_OVER}{_LENGTH}|{_OVER}\\( *{_LENGTH}{_OVER}{_TIME} *\\))"
_TURN_DAMPER = f"{_TORQUE}(?:{_TIMES}{_TIME}{_OVER}{_ANGLE}|{_OVER}\\( *{_ANGLE}{_OVER}{_TIME} *\\))"
_ACCELERATION = f"{_LENGTH}(?:{_OVER}{_TIME}{_SQUARED}|{_per(_TIME, _TIME)})"


@cache
def is_unit_of(unit: str, kind: str) -> bool:
    """Return whether a unit text is one of a kind of quantity in a model file."""
    return re.fullmatch(KINDS[kind].pattern, unit) is not None


def number_pattern(kind: str, *, inf: bool) -> str:
    """Return the pattern of a text with one number of a kind; a text `inf` where infinity may stand."""
    return f"^{_BLANK}{_one(kind, inf=inf)}{_BLANK}$"


def list_pattern(kind: str, *, inf: bool) -> str:
    """Return the pattern of a text with a list: a unit behind the bracket, or in every entry that is not zero."""
    entry = f"{_BLANK}{f'(?:{NUMBER}|{_INF})' if inf else NUMBER}{_BLANK}"
    own = f"{_BLANK}{_one(kind, inf=inf)}{_BLANK}"
    unit = KINDS[kind].pattern
    shared = f"\\[{entry}(?:,{entry})*\\]{_BLANK}{unit}"
    return f"^{_BLANK}(?:{shared}|\\[{own}(?:,{own})*\\]){_BLANK}$" if unit else f"^{_BLANK}{shared}$"


def _one(kind: str, *, inf: bool) -> str:
    """Return the pattern of one number: with its unit, zero, infinity, or of no dimension."""
    unit = KINDS[kind].pattern
    numbers = f"(?:{NUMBER}|{_INF})" if inf else NUMBER
    if not unit:
        return numbers
    if kind == "ratio":
        return f"{numbers}(?:{_BLANK}{unit})?"
    return f"(?:{numbers}{_BLANK}{unit}|{_ZERO}{f'|{_INF}' if inf else ''})"


def finite_float(text: str) -> float:
    """Return a float of a TOML text, infinity of `inf` alone. Raises OverflowError for a number that is none."""
    number = float(text)
    if math.isinf(number) and "inf" not in text:
        raise OverflowError(f"{text} is too large")
    return number


# values ---------------------------------------------------------------------------------------------------------------

PerPlanet = float | tuple[float, ...]  # one value, or one per planet


@dataclass(frozen=True, slots=True)
class Quantity:
    """A value whose key takes two kinds of quantity: one number or one per planet, and the SI unit of its kind."""

    value: PerPlanet
    unit: str


# Least magnitude [SI] of a number that is not 0: the product of a few smaller ones is none in double precision.
_LEAST = 1e-60


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of quantity: name, SI unit, largest magnitude accepted [SI], and spellings to propose.

    pattern : regular expression of the texts of its units; empty where there is no unit.
    """

    name: str
    unit: str
    limit: float
    spellings: str
    pattern: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """What a number may be [SI]: `low` to `high`, `low` excluded if `above`, `high` if `below`; infinity if `inf`."""

    low: float | None = None
    high: float | None = None
    above: bool = False
    below: bool = False
    inf: bool = False

    def __contains__(self, number: float) -> bool:
        """Whether a finite number is within the bounds."""
        if self.low is not None and (number < self.low or (self.above and number == self.low)):
            return False
        return self.high is None or number < self.high or (number == self.high and not self.below)


KINDS: dict[str, Kind] = {
    "ratio": Kind("number", "", 1e12, "", "(?:%|percent|ppm)"),
    "cycles": Kind("phase in mesh cycles", "", 1e6, "", ""),
    "length": Kind("length", "m", 1e4, "m, mm, um", _LENGTH),
    "area": Kind("area", "m^2", 1e8, "m^2, mm^2", _AREA),
    "angle": Kind("angle", "rad", 1e4, "rad, deg", _ANGLE),
    "mass": Kind("mass", "kg", 1e9, "kg, g, t", _MASS),
    "inertia": Kind("moment of inertia", "kg m^2", 1e12, "kg m^2, kg mm^2", f"{_MASS}{_TIMES}{_AREA}"),
    "density": Kind("density", "kg/m^3", 1e6, "kg/m^3, g/cm^3", f"{_MASS}{_OVER}{_LENGTH}{_CUBED}"),
    "pressure": Kind("stress", "Pa", 1e15, "Pa, MPa, GPa", f"(?:{_STRESS}|{_FORCE}{_OVER}{_AREA})"),
    "viscosity": Kind("dynamic viscosity", "Pa s", 1e6, "mPa s, Pa s", f"m?Pa{_TIMES}s"),
    "load_per_length": Kind("load per length", "N/m", 1e12, "N/mm, N/m", f"{_FORCE}{_OVER}{_LENGTH}"),
    "stiffness": Kind("stiffness", "N/m", 1e16, "N/m, N/um, kN/mm", f"{_FORCE}{_OVER}{_LENGTH}"),
    "stiffness_per_width": Kind("stiffness per face width", "N/m^2", 1e16, "N/(mm um), N/m^2", _PER_WIDTH),
    "torsional_stiffness": Kind(
        "torsional stiffness", "N m/rad", 1e18, "N m/rad, kN m/rad", f"{_TORQUE}{_OVER}{_ANGLE}"
    ),
    "rigidity": Kind("torsional rigidity", "N m^2", 1e18, "N m^2, kN m^2", f"{_FORCE}{_TIMES}{_AREA}"),
    "damping": Kind("damping", "N s/m", 1e14, "N s/m", _DAMPER),
    "torsional_damping": Kind("torsional damping", "N m s/rad", 1e16, "N m s/rad", _TURN_DAMPER),
    "force": Kind("force", "N", 1e12, "N, kN, MN", _FORCE),
    "torque": Kind("torque", "N m", 1e13, "N m, kN m, MN m", _TORQUE),
    "power": Kind("power", "W", 1e15, "W, kW, MW", _POWER),
    "speed": Kind("speed", "rad/s", 1e7, "rad/s, rpm, deg/s", f"(?:rpm|{_ANGLE}{_OVER}{_TIME})"),
    "acceleration": Kind("acceleration", "m/s^2", 1e6, "m/s^2", _ACCELERATION),
    "rate": Kind("rate", "1/s", 1e12, "1/s", f"1{_OVER}{_TIME}"),
    "frequency": Kind("frequency", "Hz", 1e7, "Hz, kHz", "[kM]?Hz"),
    "temperature": Kind("temperature difference", "K", 1e4, "K", "K"),
    "time": Kind("time", "s", 1e11, "s, ms, us, min, h", _TIME),
    "unbalance": Kind("unbalance", "kg m", 1e9, "kg m, g mm", f"{_MASS}{_TIMES}{_LENGTH}"),
}

UNKNOWN_UNIT = "unit not known or of another kind of quantity"
# by SI unit the factor of others; every entry equals pint's (tested)
_FACTORS: dict[str, dict[str, float]] = {
    "m": {"mm": 1e-3, "um": 1e-6},
    "rad": {"deg": math.pi / 180},
    "rad/s": {"rpm": math.pi / 30},
    "kg": {"g": 1e-3, "t": 1e3},
    "kg m^2": {"kg mm^2": 1e-6},
    "N": {"kN": 1e3, "MN": 1e6},
    "N m": {"kN m": 1e3, "MN m": 1e6},
    "N m/rad": {"kN m/rad": 1e3},
    "N/m": {"GN/m": 1e9, "kN/mm": 1e6, "MN/m": 1e6, "N/um": 1e6},
    "N/m^2": {"N/(mm um)": 1e9},
    "W": {"kW": 1e3, "MW": 1e6},
    "Pa": {"MPa": 1e6, "GPa": 1e9},
    "Pa s": {"mPa s": 1e-3},
}
COMMON = {kind.unit: (1.0, kind.unit) for kind in KINDS.values() if kind.unit}
COMMON |= {unit: (scale, si) for si, units in _FACTORS.items() for unit, scale in units.items()}
"""Unit -> factor to SI, SI unit."""
_QUANTITY = re.compile(rf"\s*(?P<number>{NUMBER}|[+-]?inf)\s*(?P<unit>.*?)\s*", re.DOTALL)
_LIST = re.compile(r"\s*\[(?P<items>[^\[\]]*)\](?P<unit>[^\[\]]*)")
# a decimal comma, or thousands set apart
_SET_APART = re.compile(r"\s*[+-]?[0-9.]+\s*[,'\u2019\s]\s*(?!1\s*/)[0-9]")
_BLANKS = re.compile(r"[\s*·]+")
# a unit text: words, powers of one digit, products and quotients; nothing pint could be made to compute for long
_UNIT = re.compile(r"(?:[A-Za-zµμ°%²³·]|(?:\^|\*\*)-?\d(?![\d.]|\s*(?:\^|\*\*))|1(?=\s*/)|[*/()\s])+")
_HERTZ = re.compile(r"(?<![A-Za-z])[kMG]?(?:Hz|[hH]ertz)(?![A-Za-z])")
_ANGULAR = re.compile(r"rad|rev|turn|deg|rpm|°|cycle|arc|gon")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wanted:
    """What may stand at a place, with the parameters of `read_quantity`, and the error of what may not."""

    kinds: tuple[str, ...]
    bounds: Bounds
    many: bool
    one: bool
    words: tuple[str, ...]
    listed: bool

    def error(self, problem: str, value: object) -> ModelError:
        """Return the error with the quantities, the range and the form that are allowed."""
        allowed = " or ".join([kind_words(self.kinds), *(f'"{word}"' for word in self.words)])
        if problem in ("out of range", "must be finite") or self.bounds.low is not None:
            bounds, unit, limit = self.bounds, KINDS[self.kinds[0]].unit, KINDS[self.kinds[0]].limit
            low = f"{'>' if bounds.above else '>='} {bounds.low:g}" if bounds.low is not None else f">= {-limit:g}"
            high = f"{'<' if bounds.below else '<='} {bounds.high if bounds.high is not None else limit:g}"
            allowed += f", {low} and {high}{' ' + unit if unit else ''}{' or inf' if bounds.inf else ''}"
        if not self.one:
            return ModelError(problem, given=value, allowed=f"a list of {allowed}")
        if self.many and problem != "an empty list":
            allowed += "; a list gives one value per planet"
        return ModelError(problem, given=value, allowed=allowed)


def read_quantity(
    value: object,
    kinds: tuple[str, ...],
    bounds: Bounds,
    *,
    many: bool = False,
    one: bool = True,
    words: tuple[str, ...] = (),
    listed: bool = False,
) -> float | str | tuple[float, ...] | Quantity:
    """Return the SI value of a number, a text with a unit, or a list of them.

    kinds : names in `KINDS`; a bare number is the first. Two kinds: the result is a `Quantity`.
    many : a list is allowed, of one value per planet unless `one` is not; one : a single value is allowed.
    words : texts kept as they are.
    listed : only units of the patterns of `KINDS`, as in a model file; else any that pint knows.
    Raises ModelError without a path.
    """
    if isinstance(value, str) and value.strip() in words:
        return value.strip()
    wanted = _Wanted(kinds=kinds, bounds=bounds, many=many, one=one, words=words, listed=listed)
    items, shared = split_list(value)
    if items is None and not one:
        raise wanted.error("a list is needed", value)
    if items is not None and not many:
        raise wanted.error("a list where one number stands", value)
    if items == []:
        raise wanted.error("an empty list", value)
    read = [_read_one(item, shared, wanted) for item in ([value] if items is None else items)]
    if len({unit for _, unit in read}) > 1:
        raise wanted.error("mixes kinds of quantity", value)
    numbers = tuple(number for number, _ in read)
    result = numbers if items is not None else numbers[0]
    return Quantity(value=result, unit=read[0][1]) if len(kinds) > 1 else result


def split_list(value: object) -> tuple[list[object] | None, str]:
    """Return the entries of a list (None for a single value) and the unit they share."""
    if isinstance(value, (list, tuple)):
        return list(value), ""
    if isinstance(value, str) and (found := _LIST.fullmatch(value)):
        items = found["items"].strip()
        return [item.strip() for item in items.split(",")] if items else [], found["unit"].strip() or "SI"
    return None, ""


def _read_one(value: object, shared: str, wanted: _Wanted) -> tuple[float, str]:
    """Return one SI number and its SI unit; `shared` is the unit behind a bracketed list."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise wanted.error(f"{_name(value)} where a number stands", value)
    try:
        if isinstance(value, str):
            text = f"{value} {shared}" if shared != "SI" else value
            number, unit = _parse(text, wanted.kinds, listed=wanted.listed, bare=shared == "SI")
        else:
            number, unit = float(value), KINDS[wanted.kinds[0]].unit
    except OverflowError:
        raise wanted.error("too large", value) from None
    except ValueError as error:
        raise wanted.error(str(error), value) from None
    if (problem := _fault(number, unit, wanted.kinds, wanted.bounds)) is not None:
        raise wanted.error(problem, value)
    return number, unit


@lru_cache(maxsize=4096)
def _parse(text: str, kinds: tuple[str, ...], *, listed: bool, bare: bool) -> tuple[float, str]:
    """Return the SI number and SI unit of a text like ``20 N/(mm um)``; without a unit only where `bare`, or zero.

    Raises ValueError with the problem, and OverflowError.
    """
    found = _QUANTITY.fullmatch(text) if len(text) <= 200 else None
    if found is None:
        raise ValueError("not a number with a unit")
    if _SET_APART.match(text):
        raise ValueError("a comma, an apostrophe or a space within the number (1.5 and 1500 are numbers)")
    number, unit = finite_float(found["number"]), found["unit"]
    if not unit:
        if bare or math.isinf(number) or number == 0 or not KINDS[kinds[0]].unit:
            return number, KINDS[kinds[0]].unit
        raise ValueError("a text without a unit")
    if "speed" in kinds and (_HERTZ.search(unit) or not _ANGULAR.search(unit)):
        raise ValueError("revolutions or radians?")
    # what the table answers first: most files need no pint
    for kind in sorted(kinds, key=lambda kind: COMMON.get(unit, (1.0, ""))[1] != KINDS[kind].unit):
        if listed and not is_unit_of(unit, kind):
            continue
        if (scale := to_si(unit, KINDS[kind].unit)) is not None:
            return _scaled(found["number"], scale), KINDS[kind].unit
    # a unit that differs in spaces and capitals alone: ``kN m`` of ``kNm``
    plain, targets = _BLANKS.sub("", unit).casefold(), {KINDS[kind].unit for kind in kinds}
    alike = (known for known, (_, si) in COMMON.items() if si in targets and _BLANKS.sub("", known).casefold() == plain)
    near = next(alike, "")
    raise ValueError(f"{UNKNOWN_UNIT}; did you mean {near!r}?" if near else UNKNOWN_UNIT)


def _scaled(text: str, scale: float) -> float:
    """Return number times scale; powers of ten shift the decimal point: 20 um is 2e-05, not 1.9999999999999998e-05."""
    power = round(math.log10(scale))
    if abs(scale / 10.0**power - 1) < 1e-14:
        return float(Decimal(text).scaleb(power))
    return float(text) * scale


def _fault(number: float, unit: str, kinds: tuple[str, ...], bounds: Bounds) -> str | None:
    """Return what is wrong with a number that is nan, infinite without leave, absurdly large or outside its bounds."""
    limit = next(KINDS[kind].limit for kind in kinds if KINDS[kind].unit == unit)
    if math.isnan(number):
        return "not a number"
    if math.isinf(number):
        return None if bounds.inf and number > 0 else "must be finite"
    if 0 < abs(number) < _LEAST:
        return "out of range, 0 is written as 0"
    return None if abs(number) <= limit and number in bounds else "out of range"


def to_si(unit: str, target: str) -> float | None:
    """Return `factor` to an SI unit, of a unit in the table from there: most files need no pint."""
    scale, base = COMMON.get(unit, (1.0, None))
    return scale if base == target else factor(unit, target)


@cache
def factor(unit: str, target: str) -> float | None:
    """Return the factor from `unit` to the SI unit `target`, None where `unit` is unknown or of another dimension."""
    if len(unit) > 60 or not _UNIT.fullmatch(unit):
        return None
    angular = _ANGULAR.search(unit) is not None  # to pint radians are a pure number
    if not (angular if target in ("rad", "rad/s") else not angular or "rad" in target):
        return None
    registry = _registry()
    text = unit.replace("·", " ").replace("²", "^2").replace("³", "^3")
    try:
        return float(registry.Quantity(1.0, registry.parse_units(text)).to(registry.parse_units(target)).magnitude)
    except Exception:  # pint raises many kinds on bad text: undefined, tokens, dimensions, offsets
        return None


@cache
def _registry() -> Any:
    """Return pint's registry, made once, when a unit is not in the table."""
    import pint

    registry: Any = pint.UnitRegistry()
    registry.define("@alias revolution = rev")
    return registry


def _name(value: object) -> str:
    """Return what a value is, in the words of TOML."""
    if isinstance(value, bool):
        return "true or false"
    if isinstance(value, dict):
        return "a table"
    return "a list" if isinstance(value, (list, tuple)) else f"a {type(value).__name__}"


def kind_words(kinds: tuple[str, ...]) -> str:
    """Return kinds of quantity with spellings of their units, `torque (N m, kN m, MN m) or length (m, mm, um)`."""
    named = (KINDS[kind] for kind in kinds)
    return " or ".join(f"{kind.name} ({kind.spellings})" if kind.unit else kind.name for kind in named)


# numbers as written ---------------------------------------------------------------------------------------------------

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
    if isinstance(value, (list, tuple)):  # whose entries all have one unit
        parts = [part for entry in value if (part := written(entry)) is not None and not part.many]
        if not value or len(parts) < len(value) or len({part.unit for part in parts}) > 1:
            return None
        return Written(values=tuple(part.values[0] for part in parts), unit=parts[0].unit, many=True)
    if not isinstance(value, str):
        return None
    if one := _ONE.fullmatch(value):
        return Written(values=(float(one[1]),), unit=one[2] or "", many=False)
    if many := _MANY.fullmatch(value):
        return Written(values=tuple(float(part) for part in many[1].split(",")), unit=many[2] or "", many=True)
    return None


# numbers without a unit -----------------------------------------------------------------------------------------------

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
    "load_per_length": ((1e5, "N/m"), (0.0, "N/mm")),  # teeth bear some hundreds of N/mm
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

    def look(self, value: object, kinds: tuple[str, ...], ladder: Ladder | None) -> None:
        """Note a bare number. Raises BareNumber where it is strict."""
        if bare_in(value, kinds):
            self.found = True
            if self.strict:
                raise BareNumber(value, kinds, ladder)


def stated(value: float | str, kind: str, path: str, *, bounds: Bounds = _ANY) -> float:
    """Return a number in SI as it is, and a text that a person typed in SI; a text must state its unit.

    path : keyword or option, for an error.  Raises ModelError, also for a number out of bounds.
    """
    try:
        if isinstance(value, str) and _PLAIN.fullmatch(value) and float(value) != 0:
            raise BareNumber(float(value), (kind,), None)
        read = read_quantity(value if isinstance(value, str) else float(value), (kind,), bounds)
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
    zeros = [
        item for item in items if item == 0 or (isinstance(item, str) and _PLAIN.fullmatch(item) and not float(item))
    ]
    if len(items) == len(numbers) + len(zeros):
        few = items if len(items) <= 8 else [*items[:3], "..."]
        return f"[{', '.join(map(shown, few))}] {unit}"
    return f"{shown(numbers[0])} {unit}"


def shown(value: Any) -> str:
    """Return a number with the digits of `repr`, as 1e9 or 750; a text as it is."""
    if isinstance(value, str) or not math.isfinite(value):
        return str(value)
    number = Decimal(repr(value)).normalize()
    return f"{number:e}".replace("e+", "e") if abs(number) >= 1e6 or 0 < abs(number) < 1e-4 else f"{number:f}"
