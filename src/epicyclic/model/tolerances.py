"""`[tolerance]`: distributions of numbers of the file, `normal(mean, deviation)` or `uniform(low, high)`."""

from __future__ import annotations

import re
from pathlib import Path

from ..errors import ModelError
from .bare_numbers import Probe, bare_in, likely_text
from .names import Names
from .tables import PlainTable
from .units import KINDS, Bounds, Quantity, read_quantity
from .validation import LISTED, quantity_at

__all__ = ["check_tolerance"]

_FORM = '"normal(mean, deviation)" or "uniform(low, high)"'
_DISTRIBUTION = re.compile(
    r"\s*(normal|uniform)\(([^(),]{1,40}(?:\([^(),]{1,20}\))?),([^(),]{1,40}(?:\([^(),]{1,20}\))?)\)\s*"
)
_NUMBER = re.compile(r"\s*[+-]?[0-9.]+(?:[eE][+-]?[0-9]{1,4})?\s*")


def check_tolerance(data: PlainTable, names: Names, folder: Path | None) -> list[str]:
    """Return warnings of numbers without a unit in a file of format 1.

    Raises ModelError for a tolerance that is no distribution, whose path is neither given nor could be, or whose two
    values are of another quantity than what stands there, or of a spread below zero.
    """
    table = data.get("tolerance")
    warnings: list[str] = []
    for path, text in table.items() if isinstance(table, dict) else ():
        warnings += _check(data, path, text, names, folder)
    return warnings


def _check(data: PlainTable, path: str, text: object, names: Names, folder: Path | None) -> list[str]:
    """Return the warnings of one tolerance. Raises ModelError."""
    where = f"tolerance.{path}"
    found = _DISTRIBUTION.fullmatch(text) if isinstance(text, str) else None
    if found is None:
        raise ModelError("not a distribution", path=where, given=text, allowed=_FORM)
    try:
        quantity = quantity_at(data, path, names, folder)
    except ModelError as error:
        allowed = "a path a number can stand at"
        raise ModelError(f"no such path ({error.problem})", path=where, given=text, allowed=allowed) from None
    warnings: list[str] = []
    kinds = quantity.kinds
    values = [_value(part, quantity, data, where, text, warnings) for part in found.groups()[1:]]
    (first, unit), (second, other) = values
    if unit and other and unit != other:
        allowed = " or ".join(KINDS[kind].unit for kind in kinds)
        raise ModelError("mixes kinds of quantity", path=where, given=text, allowed=f"both in {allowed}")
    if found[1] == "normal" and second < 0:
        raise ModelError("a deviation below zero", path=where, given=text, allowed="normal(mean, deviation >= 0)")
    if found[1] == "uniform" and second < first:
        raise ModelError("its ends are in the wrong order", path=where, given=text, allowed="uniform(low, high >= low)")
    return warnings


def _value(
    part: str, quantity: Probe, data: PlainTable, where: str, text: object, warnings: list[str]
) -> tuple[float, str]:
    """Return one value in SI and its SI unit, no unit of zero; warnings are added. Raises ModelError."""
    kinds = quantity.kinds
    bare = float(part) if _NUMBER.fullmatch(part) and part.count(".") < 2 else None
    listed = data.get("format") != 1
    if bare is not None and bare_in(bare, kinds):
        likely = likely_text(bare, kinds, quantity.ladder)
        if data.get("format", LISTED) >= LISTED:
            raise ModelError(f'a number without a unit: "{likely}"?', path=where, given=text, allowed=_words(kinds))
        warnings.append(f'{where} = {text}: {part.strip()} has no unit, read in {KINDS[kinds[0]].unit}; "{likely}"?')
    try:
        read = read_quantity(part if bare is None else bare, kinds, Bounds(), listed=listed)
    except ModelError as error:
        raise ModelError(error.problem, path=where, given=text, allowed=_words(kinds)) from None
    if isinstance(read, Quantity):
        assert isinstance(read.value, float)
        return read.value, read.unit if read.value or bare is None else ""
    assert isinstance(read, float)
    return read, KINDS[kinds[0]].unit


def _words(kinds: tuple[str, ...]) -> str:
    """Return what the two values may be."""
    return " or ".join(f"{KINDS[k].name}{f' ({KINDS[k].spellings})' if KINDS[k].unit else ''}" for k in kinds)
