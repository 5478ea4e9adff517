"""Spellings of units in a file of format 2: one pattern a kind of quantity, for the reader and for the JSON Schema.

A pattern is put together from the units of length, force, ... as the dimension is, so that a text of another dimension
cannot match.  The factor to SI is that of `units`.
"""

from __future__ import annotations

import re
from functools import cache

__all__ = ["UNIT_PATTERNS", "is_unit_of", "list_pattern", "number_pattern"]

# no \d: to Python it is a digit of any script, to ECMAScript, which JSON Schema follows, an ASCII one
_BLANK = r"\s*"
_DIGITS = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?"
_NUMBER = f"[+-]?{_DIGITS}"
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


UNIT_PATTERNS: dict[str, str] = {
    "ratio": "(?:%|percent|ppm)",
    "cycles": "",
    "length": _LENGTH,
    "angle": _ANGLE,
    "mass": _MASS,
    "inertia": f"{_MASS}{_TIMES}{_AREA}",
    "density": f"{_MASS}{_OVER}{_LENGTH}{_CUBED}",
    "pressure": f"(?:{_STRESS}|{_FORCE}{_OVER}{_AREA})",
    "viscosity": f"m?Pa{_TIMES}s",
    "stiffness": f"{_FORCE}{_OVER}{_LENGTH}",
    "stiffness_per_width": f"(?:{_FORCE}(?:{_OVER}{_AREA}|{_per(_LENGTH, _LENGTH)})|{_STRESS})",
    "torsional_stiffness": f"{_TORQUE}{_OVER}{_ANGLE}",
    "rigidity": f"{_FORCE}{_TIMES}{_AREA}",
    "damping": f"{_FORCE}(?:{_TIMES}{_TIME}{_OVER}{_LENGTH}|{_OVER}\\( *{_LENGTH}{_OVER}{_TIME} *\\))",
    "torsional_damping": f"{_TORQUE}(?:{_TIMES}{_TIME}{_OVER}{_ANGLE}|{_OVER}\\( *{_ANGLE}{_OVER}{_TIME} *\\))",
    "force": _FORCE,
    "torque": _TORQUE,
    "power": _POWER,
    "speed": f"(?:rpm|{_ANGLE}{_OVER}{_TIME})",
    "acceleration": f"{_LENGTH}(?:{_OVER}{_TIME}{_SQUARED}|{_per(_TIME, _TIME)})",
    "rate": f"1{_OVER}{_TIME}",
    "time": _TIME,
    "unbalance": f"{_MASS}{_TIMES}{_LENGTH}",
}
"""Regular expression of the unit texts of each kind of quantity; empty where there is no unit."""


@cache
def is_unit_of(unit: str, kind: str) -> bool:
    """Return whether a unit text is one of a kind of quantity in a file of format 2."""
    return re.fullmatch(UNIT_PATTERNS[kind], unit) is not None


def number_pattern(kind: str, *, inf: bool) -> str:
    """Return the pattern of a text with one number of a kind; a text `inf` where infinity may stand."""
    return f"^{_BLANK}{_one(kind, inf=inf)}{_BLANK}$"


def list_pattern(kind: str, *, inf: bool) -> str:
    """Return the pattern of a text with a list: a unit behind the bracket, or in every entry that is not zero."""
    item = f"{_BLANK}{_NUMBER}{_BLANK}" if not inf else f"{_BLANK}(?:{_NUMBER}|{_INF}){_BLANK}"
    own = f"{_BLANK}{_one(kind, inf=inf)}{_BLANK}"
    unit = UNIT_PATTERNS[kind]
    shared = f"\\[{item}(?:,{item})*\\]{_BLANK}{unit}"
    return f"^{_BLANK}(?:{shared}|\\[{own}(?:,{own})*\\]){_BLANK}$" if unit else f"^{_BLANK}{shared}$"


def _one(kind: str, *, inf: bool) -> str:
    """Return the pattern of one number: with its unit, zero, infinity, or of no dimension."""
    unit = UNIT_PATTERNS[kind]
    numbers = f"(?:{_NUMBER}|{_INF})" if inf else _NUMBER
    if not unit:
        return numbers
    if kind == "ratio":
        return f"{numbers}(?:{_BLANK}{unit})?"
    return f"(?:{numbers}{_BLANK}{unit}|{_ZERO}{f'|{_INF}' if inf else ''})"
