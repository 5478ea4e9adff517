"""Results: labelled Datasets with units, long names and provenance; saved to and reopened from netCDF.

One table says what every variable means; analyses only hand over arrays.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from ..arguments import checked
from ..errors import ModelError
from ..input_files import read_text
from ..warning_codes import CodedText
from .files import has_seal, package_version, require_contained, seal, sealed_file, whole_file
from .tables_out import save_csv, save_xlsx
from .variables import OF_KIND, VARIABLES

SUFFIXES = (".nc", ".json", ".csv", ".xlsx")
"""Files a result is written to; it is reopened from the first two."""

# entries of a JSON file: those of `Dataset.to_dict()`, and its digest
_ENTRIES, _DIGEST = {"coords", "attrs", "dims", "data_vars"}, "sha256"
# stands for infinity until the text is made: no text of a result has this character
_INFINITE = "\0infinity"
# 200 million numbers, as many as a run may hold, in 20 characters each
_MAX_JSON = 4_000_000_000


def dataset(
    variables: Mapping[str, tuple[Sequence[str] | str, Any]],
    coords: Mapping[Hashable, Any] | None = None,
    *,
    verb: str,
    options: Mapping[str, Any] | None = None,
    provenance: Mapping[str, str] | None = None,
    warnings: Sequence[CodedText] = (),
    units: Mapping[str, str] | None = None,
) -> xr.Dataset:
    """Make a Dataset whose variables carry unit and long name from `variables.OF_KIND`, else `variables.VARIABLES`.

    Parameters
    ----------
    variables : name -> (dims, values).  coords : as of xarray; known names get their unit too.
    verb : the analysis.  options : its options, stored as JSON.  provenance : attributes of the System.
    warnings : physical warnings, stored as JSON in the attribute ``warnings``.
    units : unit of a variable where it differs from the table (an rz row in a mixed array, say).

    Raises
    ------
    KeyError : a variable is missing from the table.
    """
    result = xr.Dataset(dict(variables), coords={name: _index(name, values) for name, values in (coords or {}).items()})
    for name in result.variables:
        entry = OF_KIND.get((verb, str(name))) or VARIABLES.get(str(name))
        if entry is None and name in variables:
            raise KeyError(f"{name} has no entry in variables.VARIABLES")
        if entry is not None:
            unit = (units or {}).get(str(name), entry[0])
            result[name].attrs.update({"units": unit, "long_name": entry[1]})
    result.attrs.update(
        {
            "verb": verb,
            "package": "epicyclic",
            "version": package_version(),
            "options": json.dumps(dict(options or {}), default=str),
            "warnings": json.dumps(list(warnings)),
            **dict(provenance or {}),
        }
    )
    return result


def _index(name: Hashable, values: Any) -> Any:
    """A list or array of labels as a pandas index: xarray then does not try whether it is one of pint's arrays, which
    would import pint, half a second, for nothing."""
    if isinstance(values, tuple) and len(values) == 2 and values[0] == name:
        values = values[1]
    if isinstance(values, tuple) or np.ndim(values) != 1:
        return values
    array = np.asarray(values)
    return pd.Index(array.astype(object) if array.dtype.kind in "UO" else array, name=name)


@checked
def to_json(result: xr.Dataset) -> str:
    """`Dataset.to_dict()` as JSON; read back with ``xarray.Dataset.from_dict(json.loads(text))``.

    Complex variables have a trailing ``part`` dimension (real, imaginary), as in a saved file.  JSON has neither nan
    nor infinity: nan is ``null``, which `load_result` reads as nan, and infinity ``1e999``, which readers take for it.
    The last entry, ``sha256``, is the digest of the text without it.
    """
    flat = _real(result)
    table = flat.to_dict()
    for name, values in flat.variables.items():
        entry = table["coords" if name in flat.coords else "data_vars"][name]
        entry["attrs"] = _finite(entry["attrs"])
        if values.dtype.kind == "O" or (values.dtype.kind == "f" and not np.isfinite(values.values).all()):
            entry["data"] = _finite(entry["data"])
    text = _text({**table, "attrs": _finite(table["attrs"])})
    return f'{text[:-1]}, "{_DIGEST}": "{_digest(text)}"}}'


def _finite(value: Any) -> Any:
    """A table, list or number with None for nan and a mark for infinity."""
    if isinstance(value, dict):
        return {name: _finite(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    if isinstance(value, float | np.floating) and not math.isfinite(value):
        return None if math.isnan(value) else _INFINITE if value > 0 else f"-{_INFINITE}"
    return value


def _text(table: Any) -> str:
    """JSON of what `_finite` gave."""

    def plain(value: object) -> object:
        return value.item() if isinstance(value, np.generic) else str(value)

    text = json.dumps(table, default=plain, allow_nan=False)
    return re.sub(rf'"(-?){re.escape(json.dumps(_INFINITE)[1:-1])}"', r"\g<1>1e999", text)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


@checked
def save_result(result: xr.Dataset, path: str | Path) -> Path:
    """Write a Dataset by the suffix of the file, as ``-o`` does.

    ``.nc`` netCDF-4 and ``.json`` `Dataset.to_dict()` reopen with `load_result`; ``.csv`` in long form and ``.xlsx``
    are for other programs (`tables_out`).  Complex variables of the first two become a trailing ``part`` dimension
    (real, imaginary).  The file appears whole or not at all; one that reopens ends with a digest of what is in it.

    Raises
    ------
    ModelError : another suffix, too much for a workbook, or the file cannot be written.
    """
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in SUFFIXES:
        allowed = f"{' or '.join(SUFFIXES)}; .html by write_report"
        raise ModelError("no such kind of result file", path="path", given=target.name, allowed=allowed)
    if kind == ".csv":
        return save_csv(result, target)
    if kind == ".xlsx":
        return save_xlsx(result, target)
    if kind == ".json":
        content = (to_json(result) + "\n").encode()
    else:
        flat = _real(result)
        for name, values in result.variables.items():
            if values.dtype == bool:
                flat[name] = (values.dims, values.values.astype(np.int8), {**values.attrs, "boolean": "1"})
        # made in memory first: HDF5 kills the interpreter where its disk is full
        image = flat.to_netcdf(engine="h5netcdf")
        content = bytes(image) + seal(image)
    with whole_file(target) as file:
        file.write(content)
    return target


def _real(result: xr.Dataset) -> xr.Dataset:
    """A copy without complex numbers: real and imaginary part along a trailing dimension ``part``."""
    flat = result.copy()
    for name in list(flat.variables):
        values = flat[name]
        if np.iscomplexobj(values.values):
            split = np.stack([values.values.real, values.values.imag], axis=-1)
            flat[name] = ((*values.dims, "part"), split, {**values.attrs, "complex": "1"})
    return flat


@checked
def load_result(path: str | Path) -> xr.Dataset:
    """Reopen what `save_result` wrote, equal to the Dataset that was saved.

    Raises
    ------
    ModelError : no such file, no result, a damaged one, or one whose data lie in other files.
    """
    flat = _from_json(path) if Path(path).suffix.lower() == ".json" else _from_netcdf(path)
    result = flat.copy()
    try:
        # complex numbers and truth values again
        for name in list(flat.variables):
            dims, values, attrs = flat[name].dims, flat[name].values, dict(flat[name].attrs)
            if attrs.pop("complex", None):
                whole = np.empty(values.shape[:-1], dtype=np.complex128)
                whole.real, whole.imag = values[..., 0], values[..., 1]  # a product with 1j makes nan of infinity
                result[name] = (dims[:-1], whole, attrs)
            elif attrs.pop("boolean", None):
                result[name] = (dims, values.astype(bool), attrs)
    except Exception as error:  # a mark of a complex variable on one that is none
        raise ModelError(f"not a result file: {error}", path=str(path)) from error
    return result


def has_digest(path: str | Path) -> bool:
    """Whether a result file that `load_result` takes is as the package wrote it, and of no other program."""
    content = Path(path).read_bytes()
    return _DIGEST.encode() in content if Path(path).suffix.lower() == ".json" else has_seal(content)


def _from_netcdf(path: str | Path) -> xr.Dataset:
    with sealed_file(path) as file:
        # a file of an earlier version has no digest: whatever a library meets in a damaged one is the file's fault
        try:
            require_contained(file)
            with xr.open_dataset(file, engine="h5netcdf") as opened:
                return opened.load()
        except ModelError as error:
            raise ModelError(error.problem, path=str(path), allowed=error.allowed) from None
        except Exception as error:
            raise ModelError(f"not a result file: {error}", path=str(path)) from error


def _from_json(path: str | Path) -> xr.Dataset:
    if not Path(path).exists():
        raise ModelError("no such file", path=str(path))
    text = read_text(path, most=_MAX_JSON)
    try:
        table = json.loads(text)
        if not isinstance(table, dict) or not isinstance(table.get("data_vars"), dict) or not table["data_vars"]:
            raise ValueError("no data_vars")
        digest = table.pop(_DIGEST, None)  # a file of an earlier version has none
        with_nan = {**table, "attrs": _with_nan(table["attrs"])}
        for group in ("coords", "data_vars"):
            with_nan[group] = {
                name: {**entry, "attrs": _with_nan(entry["attrs"]), "data": _numbers(entry["data"])}
                for name, entry in table[group].items()
            }
        result = xr.Dataset.from_dict(with_nan)
    except Exception as error:  # whatever xarray meets in a table that is no Dataset
        raise ModelError(f"not a result file: {error}", path=str(path)) from error
    # of the content, however another program lays it out
    damaged = digest is not None and digest not in (_digest(_text(_finite(table))), _digest(json.dumps(table)))
    if damaged or set(table) - _ENTRIES:
        raise ModelError("not a result file: damaged, its content is other than was written", path=str(path))
    return result


def _with_nan(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes with nan for null."""
    return {key: math.nan if value is None else value for key, value in attributes.items()}


def _numbers(data: Any) -> Any:
    """Data of a variable, with nan for null."""
    array = np.array(data, dtype=object) if isinstance(data, list) else data
    if array is None:
        return math.nan
    if not isinstance(array, np.ndarray) or not (array == None).any():  # noqa: E711
        return data
    return array.astype(np.float64)
