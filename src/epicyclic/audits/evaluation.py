"""Evaluation of the values of an audit file: selection by labels, reduction, arithmetic and units."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..errors import ModelError
from .audit_file import Label, Value

Array = NDArray[np.float64]
_ANGULAR = re.compile(r"(?<![A-Za-z])(rad|rev|turn|deg|rpm|degree|radian)(?![A-Za-z])")


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """Values (k,) and their unit, as text."""

    values: Array
    unit: str


def evaluate(value: Value, result_of: Callable[[str], xr.Dataset]) -> Measured:
    """Values (k,) of a table `ours`, in the order select, reduce, combine, convert, absolute, scale, offset.

    Parameters
    ----------
    value : the table.  result_of : Dataset of a run by its name.

    Raises
    ------
    ModelError : no such variable, label or dimension, several numbers where one is wanted, or units that do not fit.
    """
    if value.run is not None and value.take is not None:
        found = _selected(result_of(value.run), value, value.take)
    elif value.value is not None:
        found = Measured(values=np.array([value.value]), unit=value.unit or "1")
    else:
        found = _combined(value, [evaluate(part, result_of) for part in value.parts])
    if value.unit is not None:
        found = converted(found, value.unit) if _known(found.unit) else Measured(values=found.values, unit=value.unit)
    values = np.abs(found.values) if value.absolute else found.values
    factor, unit = _scale(value.scale, found.unit)
    return Measured(values=values * factor + value.offset, unit=unit)


def converted(number: Measured, unit: str) -> Measured:
    """The same values (k,) in another unit; revolutions and radians per time are not mixed.

    Raises
    ------
    ModelError : a unit that is not known, another kind of quantity, or revolutions against radians.
    """
    if number.unit == unit:
        return number
    registry = _registry()
    try:
        old, new = _parsed(number.unit), _parsed(unit)
        factor = registry.Quantity(1.0, old).to(new).magnitude
    except Exception as error:  # pint raises many kinds on bad text: undefined, tokens, dimensions
        raise ModelError(f"cannot become {unit!r}: {error}", path="unit", given=number.unit) from None
    in_time = "[time]" in registry.Quantity(1.0, old).dimensionality
    if in_time and bool(_ANGULAR.search(number.unit)) != bool(_ANGULAR.search(unit)):
        problem = f"cannot become {unit!r}: revolutions or radians?"
        raise ModelError(problem, path="unit", given=number.unit, allowed="take the frequency in the unit wanted")
    return Measured(values=number.values * factor, unit=unit)


def _selected(result: xr.Dataset, value: Value, name: str) -> Measured:
    """Values (k,) of one variable after selection by labels, ranges and positions, and reduction."""
    kept = result
    if name == "warnings":
        kept = kept.assign({"warnings": ("warning", np.array(json.loads(result.attrs["warnings"]), dtype=str))})
    _variable(kept, name, "take")
    for label, wanted in value.where.items():
        if name == "warnings":
            kept = kept.isel(warning=np.flatnonzero(_matches(kept["warnings"].values, wanted)))
        else:
            kept = _where(kept, label, wanted)
    for label, (low, high) in value.between.items():
        along = _line(kept, label)
        kept = kept.isel({along.dims[0]: np.flatnonzero((along.values >= low) & (along.values <= high))})
    for label, place in value.nearest.items():
        along = _line(kept, label)
        kept = kept.isel({along.dims[0]: [int(np.abs(along.values - place).argmin())]})
    if value.pick is not None:
        kept = _picked(kept, name, value.pick)
    return _reduced(kept, name, value)


def _variable(result: xr.Dataset, name: str, key: str) -> xr.DataArray:
    """Variable of a result; key : of the audit file, for an error."""
    if name not in result.variables:
        allowed = ", ".join(sorted(map(str, result.variables)))
        raise ModelError("no such variable in the result", path=key, given=name, allowed=allowed)
    return result[name]


def _line(result: xr.Dataset, label: str) -> xr.DataArray:
    """A coordinate or variable of one dimension, by which to select."""
    along = _variable(result, label, "where")
    if along.ndim != 1:
        raise ModelError("has not one dimension", path="where", given=f"{label}{along.dims}")
    return along


def _where(result: xr.Dataset, label: str, wanted: Label | list[Label]) -> xr.Dataset:
    """Part of a result whose label is one of those wanted."""
    along = _line(result, label)
    at = np.flatnonzero(_matches(along.values, wanted))
    if not at.size:
        known = ", ".join(dict.fromkeys(str(entry) for entry in along.values[:40]))
        raise ModelError("nothing is left", path=f"where.{label}", given=wanted, allowed=known)
    return result.isel({along.dims[0]: at})


def _matches(labels: NDArray[Any], wanted: Label | list[Label]) -> NDArray[np.bool_]:
    """Which labels (n,) are wanted: texts with * and ?, numbers within rounding, any entry of a list; (n,)."""
    if isinstance(wanted, list):
        found = np.zeros(len(labels), dtype=bool)
        for one in wanted:
            found |= _matches(labels, one)
        return found
    if isinstance(wanted, str):
        return np.array([fnmatchcase(str(label), wanted) for label in labels], dtype=bool)
    if labels.dtype.kind not in "biuf":
        return np.zeros(len(labels), dtype=bool)
    close: NDArray[np.bool_] = np.isclose(labels.astype(np.float64), wanted, rtol=1e-9, atol=1e-12)
    return close


def _picked(result: xr.Dataset, name: str, pick: int | list[int]) -> xr.Dataset:
    """Part of a result at positions in the only dimension of a variable that is longer than 1."""
    dims = [dim for dim in result[name].dims if result.sizes[dim] != 1] or list(result[name].dims)[:1]
    places = [pick] if isinstance(pick, int) else pick
    if len(dims) != 1 or not all(-result.sizes[dims[0]] <= place < result.sizes[dims[0]] for place in places):
        left = dict(zip(result[name].dims, result[name].shape, strict=True))
        raise ModelError("cannot pick", path="pick", given=pick, allowed=f"positions in one dimension of {left}")
    return result.isel({dims[0]: places})


def _reduced(result: xr.Dataset, name: str, value: Value) -> Measured:
    """Values (k,) after the steps of the reduction, of complex values by magnitude; k > 1 only with a step `each`."""
    data = result[name]
    unit = str(data.attrs.get("units", ""))
    if np.iscomplexobj(data.values):
        data = abs(data)
    for step in value.steps:
        words = step.split()
        if len(words) == 2 and words[1] not in data.dims:
            raise ModelError("no such dimension", path="reduce", given=step, allowed=", ".join(map(str, data.dims)))
        if words[0] in ("argmax", "argmin") and value.read is not None:
            data, unit = _read(result, data, value.read, largest=words[0] == "argmax")
        elif words[0] == "count":
            data, unit = xr.DataArray(float(data.size)), "1"
        elif words[0] in _REDUCE:
            dims = list(data.dims) if len(words) == 1 else [words[1]]
            data, unit = _REDUCE[words[0]](data, dims), "1" if words[0] == "ratio" else unit
    many = any(step.startswith("each") for step in value.steps)
    if data.size != 1 and not (many and data.squeeze().ndim == 1):
        left = dict(zip(data.dims, data.shape, strict=True))
        raise ModelError("not one number is left", path="reduce", given=left, allowed="where, pick, or a reduction")
    return Measured(values=np.asarray(data.values, dtype=np.float64).reshape(-1), unit=unit)


def _read(result: xr.Dataset, data: xr.DataArray, name: str, *, largest: bool) -> tuple[xr.DataArray, str]:
    """Value and unit of another variable where this one is largest (smallest)."""
    other, same = xr.broadcast(_variable(result, name, "read"), data)
    if same.size != data.size:
        raise ModelError("has a dimension of its own", path="read", given=name, allowed=", ".join(map(str, data.dims)))
    at = np.nanargmax(same.values) if largest else np.nanargmin(same.values)
    return xr.DataArray(other.values.reshape(-1)[at]), str(result[name].attrs.get("units", ""))


def _first(data: xr.DataArray, dims: list[Any], at: int = 0) -> xr.DataArray:
    return data.isel({dim: at for dim in dims})


_REDUCE: Mapping[str, Callable[[xr.DataArray, list[Any]], xr.DataArray]] = {
    "max": lambda data, dims: data.max(dims, skipna=False),
    "min": lambda data, dims: data.min(dims, skipna=False),
    "mean": lambda data, dims: data.mean(dims, skipna=False),
    "sum": lambda data, dims: data.sum(dims, skipna=False),
    "rms": lambda data, dims: (data**2).mean(dims, skipna=False) ** 0.5,
    "range": lambda data, dims: data.max(dims, skipna=False) - data.min(dims, skipna=False),
    "ratio": lambda data, dims: data.max(dims, skipna=False) / data.min(dims, skipna=False),
    "largest": lambda data, dims: abs(data).max(dims, skipna=False),
    "first": _first,
    "last": lambda data, dims: _first(data, dims, -1),
}


def _combined(value: Value, parts: list[Measured]) -> Measured:
    """Ratio, product, difference, sum, greatest or least of values (k,) of equal length, or of length 1."""
    first = parts[0]
    if value.ratio is not None or value.product is not None:
        over = value.ratio is not None
        values, unit = first.values, f"({first.unit or '1'})"
        for part in parts[1:]:
            values = values / part.values if over else values * part.values
            unit += f"{'/' if over else '*'}({part.unit or '1'})"
        same = over and first.unit == parts[1].unit
        return Measured(values=values, unit="1" if same else unit)
    stack = np.array(np.broadcast_arrays(*[converted(part, first.unit).values for part in parts]))
    if value.difference is not None:
        return Measured(values=stack[0] - stack[1], unit=first.unit)
    if value.sum is not None:
        return Measured(values=stack.sum(axis=0), unit=first.unit)
    return Measured(values=stack.max(axis=0) if value.greatest is not None else stack.min(axis=0), unit=first.unit)


def _scale(scale: float | str, unit: str) -> tuple[float, str]:
    """Factor of a `scale`, and the unit of the product."""
    if not isinstance(scale, str):
        return float(scale), unit
    found = re.fullmatch(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(\S.*)", scale)
    if found is None or not _known(found[2]):
        raise ModelError("not a number with a unit", path="scale", given=scale, allowed='a number, or "0.035 m"')
    return float(found[1]), f"({unit or '1'})*({found[2]})"


def _known(unit: str) -> bool:
    """Whether a unit can be parsed; that of a variable that mixes several cannot."""
    try:
        _parsed(unit)
    except Exception:  # pint raises many kinds on bad text
        return False
    return True


@cache
def _parsed(unit: str) -> Any:
    """Unit of pint; `kg m2` is kg m^2."""
    text = re.sub(r"(?<=[A-Za-z])(?=[2-9])", "^", unit.strip()) or "1"
    return _registry().parse_units("dimensionless" if text == "1" else re.sub(r"\(1\)", "(dimensionless)", text))


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()
