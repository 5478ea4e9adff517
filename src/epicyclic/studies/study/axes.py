"""What a study varies: an entry of its job file to values that overrides or options of a verb take."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...model.bare_numbers import Probe, bare_in, likely_text, typed
from ...model.distributions import VECTORS, Distribution
from ...model.document import Document, read
from ...model.names import collect
from ...model.units import KINDS, Bounds, Quantity, read_quantity
from ...model.validation import quantity_at

__all__ = ["OPTIONS", "Variation", "axis_of", "drawn", "is_range", "quantity_kinds"]

OPTIONS = "options."
"""Begin of a path that is an option of the verb."""
_RANGE = {"from", "to", "points", "scale"}
_ALLOWED_RANGE = '{ from = "1e6 N/m", to = "1e8 N/m", points = 9, scale = "log" }'
_SCALES = ("linear", "log")
# a dimension that no result could hold
_MOST_POINTS = 1_000_000
_TEXT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-zµμ°%].*?)?\s*")
# Uniform numbers keep this far from 0 and 1, where a normal distribution is infinite: half a step of Sobol's 32 bits.
_EDGE = 2.0**-33


@dataclass(frozen=True, slots=True, kw_only=True)
class Variation:
    """One path of a job and its values.

    path : override path, or `options.` and an option of the verb.  values : in the order of the points.
    labels : (P,) float where all values are single numbers, else texts.  unit : of the numbers, as written, else SI.
    """

    path: str
    values: tuple[Any, ...]
    labels: NDArray[Any]
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class _Place:
    """Where an entry stands, and what may stand there.

    where : path in the job file.  kinds : of quantities, () where no number stands.  written : by a person in a file.
    """

    where: str
    path: str
    kinds: tuple[str, ...]
    whole: bool
    written: bool


def quantity_kinds(document: Document, path: str, folder: Path | None) -> tuple[tuple[str, ...], bool]:
    """Kinds of quantity that may stand at a path of a model, () where none may, and whether it is a count."""
    if path.startswith(OPTIONS):
        return (), False
    try:
        probe = quantity_at(document.data, path, collect(document.data), folder)
    except ModelError:
        return (), False
    assert isinstance(probe, Probe)
    return probe.kinds, bool(getattr(probe, "whole", False))


def is_range(value: object) -> bool:
    """Whether a table is a range and no table of further paths."""
    return isinstance(value, Mapping) and "from" in value and set(value) <= _RANGE


def axis_of(document: Document, folder: Path | None, where: str, path: str, given: object, written: bool) -> Variation:
    """Variation of a list of values, or of a range.

    Parameters
    ----------
    folder : of the model.  where : path in the job file, for errors.  written : numbers there must state their units.

    Raises
    ------
    ModelError : neither; an end without a unit; a value that cannot stand at the path.
    """
    kinds, whole = quantity_kinds(document, path, folder)
    place = _Place(where=where, path=path, kinds=kinds, whole=whole, written=written)
    if is_range(given):
        assert isinstance(given, Mapping)
        values = _range(place, given)
    elif isinstance(given, Sequence) and not isinstance(given, str) and given:
        values = [typed(value) if written and not path.startswith(OPTIONS) else value for value in given]
    else:
        raise ModelError("not values", path=where, given=given, allowed=f'["5 um", "10 um"], or {_ALLOWED_RANGE}')
    _check_values(document, place, values)
    labels, unit = _labels(place, values, given)
    return Variation(path=path, values=tuple(values), labels=labels, unit=unit)


def _range(place: _Place, given: Mapping[str, Any]) -> list[Any]:
    """Values of a range."""
    count = given.get("points")
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= _MOST_POINTS:
        where = f"{place.where}.points"
        raise ModelError("not a number of points", path=where, given=count, allowed=f"1 to {_MOST_POINTS}")
    shares = np.linspace(0.0, 1.0, count)
    return _between(place, given, shares)


def _between(place: _Place, given: Mapping[str, Any], shares: NDArray[np.float64]) -> list[Any]:
    """Values at shares of the way from one end of a range to the other."""
    if "to" not in given:
        raise ModelError("missing", path=f"{place.where}.to", allowed=_ALLOWED_RANGE)
    scale = given.get("scale", "linear")
    if scale not in _SCALES:
        raise ModelError("no such scale", path=f"{place.where}.scale", given=scale, allowed=" or ".join(_SCALES))
    first, unit = _end(place, "from", given["from"])
    last, other = _end(place, "to", given["to"])
    for end, number in (("from", first), ("to", last)):
        if not np.isfinite(number):
            where = f"{place.where}.{end}"
            raise ModelError("no end of a range", path=where, given=given[end], allowed="finite, or a list of values")
    if unit != other:
        raise ModelError("ends of two units", path=place.where, given=dict(given), allowed="one unit")
    if scale == "log":
        if not (first > 0 and last > 0):
            raise ModelError("a log scale to zero or below", path=place.where, given=dict(given), allowed="above 0")
        numbers = np.exp(np.log(first) + shares * (np.log(last) - np.log(first)))
    else:
        numbers = first + shares * (last - first)
    # the ends are what was written, not rounded by a logarithm
    numbers = np.where(shares == 0.0, first, np.where(shares == 1.0, last, numbers))
    found = [float(number) for number in numbers]
    counts = all(isinstance(given[end], int) for end in ("from", "to")) and all(one == round(one) for one in found)
    if place.whole or counts:
        return [round(number) for number in found]
    return [f"{number!r} {unit}" for number in found] if unit and not place.kinds else found


def _end(place: _Place, end: str, value: Any) -> tuple[float, str]:
    """Number and unit of an end of a range: SI where the quantity is known, else as written."""
    where = f"{place.where}.{end}"
    if place.kinds:
        return _number(place, value, where)
    found = _TEXT.fullmatch(value) if isinstance(value, str) else None
    if found is not None:
        return float(found[1]), found[2] or ""
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise ModelError("not a number", path=where, given=value, allowed=_ALLOWED_RANGE)
    return float(value), ""


def _number(place: _Place, value: Any, where: str) -> tuple[float, str]:
    """SI number and SI unit of a value."""
    if place.written and bare_in(value, place.kinds):
        likely = likely_text(value, place.kinds, None)
        raise ModelError(f'a number without a unit: "{likely}"?', path=where, given=value)
    try:
        found = read_quantity(value, place.kinds, Bounds(inf=True))
    except ModelError as error:
        raise ModelError(error.problem, path=where, given=value, allowed=error.allowed) from None
    number, unit = (found.value, found.unit) if isinstance(found, Quantity) else (found, KINDS[place.kinds[0]].unit)
    assert isinstance(number, float)
    return number, unit


def _check_values(document: Document, place: _Place, values: Sequence[Any]) -> None:
    """Refuse a path at which none of the values can stand; a value that is wrong alone fails at its points."""
    if place.path.startswith(OPTIONS):
        return
    error: ModelError | None = None
    for value in dict.fromkeys(map(str, (values[0], values[-1], values[len(values) // 2]))):
        one = next(found for found in values if str(found) == value)
        try:
            read(document.data, {place.path: one})
            return
        except ModelError as found:
            error = error or found
    assert error is not None
    # an error elsewhere comes of the other values of the point, which may mend it
    if error.path.startswith(place.path) or place.path.startswith(error.path) or not error.path:
        raise ModelError(error.problem, path=place.where, given=values[0], allowed=error.allowed)


def _labels(place: _Place, values: Sequence[Any], given: Any) -> tuple[NDArray[Any], str]:
    """Labels of values: numbers with their unit where all are single numbers, else texts.

    The unit is the one in which all values, or both ends of a range, were written, else that of SI.
    """
    if place.kinds and not any(isinstance(value, bool) for value in values):
        with suppress(ModelError, AssertionError):
            numbers = [_number(place, value, place.where) for value in values]
            if len({unit for _, unit in numbers}) == 1:
                return _as_written(place, np.array([number for number, _ in numbers]), numbers[0][1], given)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        unit = KINDS[place.kinds[0]].unit if place.kinds else ""
        return np.array([float(value) for value in values]), unit
    if not place.kinds and (unit := _unit_of(values)):
        return np.array([float(found[1]) for value in values if (found := _TEXT.fullmatch(value))]), unit
    return np.array([_text(value) for value in values], dtype=object), ""


def _as_written(place: _Place, numbers: NDArray[np.float64], unit: str, given: Any) -> tuple[NDArray[np.float64], str]:
    """SI numbers in the unit of all that is given, without the rounding of the conversion there and back."""
    written = _unit_of([given["from"], given["to"]] if is_range(given) else given)
    if not written or written == unit:
        return numbers, unit
    size, _ = _number(place, f"1 {written}", place.where)
    return np.array([float(f"{number / size:.15g}") for number in numbers]), written


def _unit_of(values: Sequence[Any]) -> str:
    """The one unit of all texts of a number with a unit, empty where there is none."""
    found = [_TEXT.fullmatch(value) if isinstance(value, str) else None for value in values]
    units = {one[2] if one else None for one in found}
    return (units.pop() or "") if len(units) == 1 else ""


def _text(value: Any) -> str:
    """A value as text: a list whose entries have one unit as a person writes it, ``[20, 0, 0] um``."""
    if isinstance(value, str) or not isinstance(value, Sequence):
        return str(value)
    if unit := _unit_of(value):
        return f"[{', '.join(found[1] for one in value if (found := _TEXT.fullmatch(one)))}] {unit}"
    return f"[{', '.join(map(str, value))}]"


def drawn(
    document: Document,
    folder: Path | None,
    where: str,
    path: str,
    given: object,
    u: NDArray[np.float64],
    written: bool,
    distribution: Distribution | None,
) -> list[Variation]:
    """Axes of draws: of a distribution (two of a vector), of a range, or of a list each value of which is as likely.

    Parameters
    ----------
    u : (P, 2) uniform numbers; the second is of vectors.  distribution : that the text is.  Others as of `axis_of`.

    Raises
    ------
    ModelError : none of these.
    """
    u = np.clip(u, _EDGE, 1.0 - _EDGE)
    kinds, whole = quantity_kinds(document, path, folder)
    place = _Place(where=where, path=path, kinds=kinds, whole=whole, written=written)
    if distribution is not None:
        vector = distribution.kind in VECTORS
        values = np.asarray(distribution.quantile(u if vector else u[:, :1]))
        parts = [(f"{path}.x", values.real), (f"{path}.y", values.imag)] if vector else [(path, values)]
        unit = "m" if vector and not kinds else KINDS[kinds[0]].unit if kinds else ""
        return [
            Variation(path=name, values=tuple(map(float, numbers)), labels=np.array(numbers, float), unit=unit)
            for name, numbers in parts
        ]
    if is_range(given):
        assert isinstance(given, Mapping)
        found = _between(place, given, u[:, 0])
    elif isinstance(given, Sequence) and not isinstance(given, str) and given:
        found = [given[int(number * len(given))] for number in u[:, 0]]
        found = [typed(value) if written and not path.startswith(OPTIONS) else value for value in found]
    else:
        allowed = f'"normal(0, 12 um)", {_ALLOWED_RANGE.replace(" points = 9,", "")}, or a list to choose from'
        raise ModelError("not a distribution", path=where, given=given, allowed=allowed)
    _check_values(document, place, found)
    labels, unit = _labels(place, found, given)
    return [Variation(path=path, values=tuple(found), labels=labels, unit=unit)]
