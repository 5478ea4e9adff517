"""Results: labelled Datasets with units, long names and provenance; saved to and reopened from netCDF; and as tables.

One table says what every variable means; analyses only hand over arrays.

For other programs a result is written as `.csv`, one row a value, and `.xlsx`, one sheet a group of equal dims.  Both
hold every number to the last bit and every text as text: none of it is taken for a formula.

Ties are broken by a rule, on any machine: of values that rounding alone tells apart the first leads.  Branches that
carry the same load differ by the rounding of one processor's kernels, 1e-15 to 1e-12 of the load; what an engineer
tells apart stands in the fourth digit.  Between the two no name may hang on the last bit.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from ..user_input import checked, read_text
from ..warning_codes import CodedText
from .files import has_seal, package_version, require_contained, seal, sealed_file, whole_file
from .variables import OF_KIND, VARIABLES

# Responses are solved to 3e-5 of their dynamic part; values that differ by less than this share are equal.
EQUAL = 1e-4
# Share within which values of a direct solution are equal.
_ROUNDING = 1e-9


def ranked(values: ArrayLike, *, equal: float = _ROUNDING) -> NDArray[np.int64]:
    """Places of values (n,), the largest first, nan last; of values equal to the largest of them the first leads.

    Values below 1e-9 of the largest magnitude are 0, as tables show them: a mode at rest has the force of rounding.

    equal : share [1] of the largest magnitude of a run of equal values within which they are.
    """
    raw = np.asarray(values, dtype=float)
    known = np.nan_to_num(raw, nan=-np.inf)
    known[np.abs(known) <= _ROUNDING * np.abs(raw[np.isfinite(raw)]).max(initial=0.0)] = 0.0
    order: list[int] = []
    run: list[int] = []
    for index in np.argsort(-known, kind="stable").tolist():
        if run and not known[index] >= known[run[0]] - equal * abs(known[run[0]]):
            order += sorted(run)
            run = []
        run.append(index)
    return np.array(order + sorted(run), dtype=np.int64)


def largest(values: ArrayLike, *, equal: float = _ROUNDING) -> int:
    """Place of the largest of values (any shape) in row-major order, nan below every number, of equal ones the first.

    0 where none is known.
    """
    known = np.ravel(np.asarray(values, dtype=float))
    most = float(np.fmax.reduce(known, initial=-np.inf))
    return int(np.argmax(known >= most - equal * abs(most))) if math.isfinite(most) else int(np.argmax(known == most))


def first_largest(values: ArrayLike) -> tuple[int, ...]:
    """Indices of the largest of values of any shape, as of `largest`.

    ValueError where none is known, as of numpy.nanargmax.
    """
    array = np.asarray(values, dtype=float)
    if np.isnan(array).all():
        raise ValueError("no value is known")
    return tuple(int(index) for index in np.unravel_index(largest(array, equal=EQUAL), array.shape))


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
    for name, variable in result.variables.items():
        entry = OF_KIND.get((verb, str(name))) or VARIABLES.get(str(name))
        if entry is None and name in variables:
            raise KeyError(f"{name} has no entry in variables.VARIABLES")
        if entry is not None:
            unit = (units or {}).get(str(name), entry[0])
            variable.attrs.update({"units": unit, "long_name": entry[1]})
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


_OF_CASES = ("case", "case_duration", "case_share", "case_status", "case_reason")


def cases_of(result: xr.Dataset) -> dict[str, xr.Dataset]:
    """Case -> its own result, of a result over the cases of a model; a case that failed is not among them."""
    found = {}
    for name, attributes in json.loads(result.attrs["cases"]).items():
        one = result.sel(case=name).drop_vars([str(key) for key in result.variables if str(key) in _OF_CASES])
        for dim in one.dims:  # labels that other cases alone have
            if (own := f"{dim}_of_point") in one:
                one = one.isel({dim: np.flatnonzero(one[own].notnull())})
                one = one.assign_coords({dim: one[own]}).drop_vars(own)
            elif known := [array.notnull() for array in one.values() if dim in array.dims and array.dtype.kind in "fc"]:
                own_labels = [array.any([other for other in array.dims if other != dim]).values for array in known]
                one = one.isel({dim: np.logical_or.reduce(own_labels)})
        one = one.drop_vars(set(one.coords) - set(attributes.pop("labels")))
        whole = {key: kind for key, kind in attributes.pop("whole_numbers").items() if not one[key].isnull().any()}
        shared = {key: value for key, value in result.attrs.items() if key not in ("of", "cases")}
        found[name] = one.assign({key: one[key].astype(kind) for key, kind in whole.items()})
        found[name].attrs = {**shared, **attributes}
    return found


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
    are for other programs.  Complex variables of the first two become a trailing ``part`` dimension
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
    if kind in (".csv", ".xlsx"):
        return (save_csv if kind == ".csv" else save_xlsx)(result, target)
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
                name: {**entry, "attrs": _with_nan(entry["attrs"]), "data": _numbers(entry, table.get("dims", {}))}
                for name, entry in table[group].items()
            }
        result = xr.Dataset.from_dict(with_nan)
    except Exception as error:  # whatever xarray meets in a table that is no Dataset
        raise ModelError(f"not a result file: {error}", path=str(path)) from error
    # of the content, however another program lays it out
    damaged = digest is not None and digest != _digest(_text(_finite(table))) and digest != _digest(json.dumps(table))
    if damaged or set(table) - _ENTRIES:
        raise ModelError("not a result file: damaged, its content is other than was written", path=str(path))
    return result


def _with_nan(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes with nan for null."""
    return {key: math.nan if value is None else value for key, value in attributes.items()}


def _numbers(entry: Mapping[str, Any], sizes: Mapping[str, int]) -> Any:
    """Data of a variable, with nan for null; sizes : by dimension, of which lists without numbers tell the first."""
    data = entry["data"]
    array = np.array(data, dtype=object)
    if not array.size and array.ndim < len(entry["dims"]):
        return np.zeros([sizes[name] for name in entry["dims"]])
    return array.astype(np.float64) if (array == None).any() else data  # noqa: E711


# Where a spreadsheet begins a text with one of these it may take it for a formula; the apostrophe itself is among them,
# so that taking one away from the front of every text gives the text back.
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "'")
# Rows and columns of a sheet, and characters of a cell, by the file format (ECMA-376; Excel refuses more).
_ROWS, _COLUMNS, _CHARACTERS = 1_048_576, 16_384, 32_767
_NAME = 31  # characters of the name of a sheet
CELLS_OF_XLSX = 10_000_000
"""Most cells of one `.xlsx`: two minutes of work, and more than a spreadsheet opens with patience."""
# Characters that XML cannot hold; of a carriage return it makes a line feed.
_NO_XML = re.compile(r"[\x00-\x08\x0b-\x1f\ud800-\udfff\ufffe\uffff]")
_WIDEST, _NARROWEST = 48, 9  # widths of columns [characters]
_HEAD = ("variable", "type", "unit")
_TAIL = ("value", "imaginary", "text")
_LONG = 500  # characters of an attribute from which it stands last in the first sheet, as the model file does


# --- long form -------------------------------------------------------------------------------------------------------


def save_csv(result: xr.Dataset, path: str | Path) -> Path:
    """Write a result as CSV in long form; whole or not at all.

    One row a value: ``variable, type, unit``, a column for each dim of the result, ``value, imaginary, text``.  A dim
    has the label of its coordinate, or its place from 0, and nothing where the variable does not have that dim.
    Numbers stand in ``value``, truth values as 1 and 0, of complex numbers the imaginary part in ``imaginary``; texts
    and times in ``text``.  Attributes (title, options, warnings, model) are rows of the type ``attribute``.  A text
    that begins with one of = + - @ ' or a control character has an apostrophe before it.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    with whole_file(path) as file:
        for piece in csv_pieces(result):
            file.write(piece.encode("utf-8", "backslashreplace"))
    return Path(path)


def csv_pieces(result: xr.Dataset) -> Iterator[str]:
    """The text of `save_csv` in pieces, lines that end with a line feed; numbers in the fewest digits that are exact.

    ``pandas.read_csv(FILE, float_precision="round_trip")`` reads them to the bit.
    """
    dims = list(result.sizes)
    yield ",".join([*_HEAD, *(_quoted(str(dim)) for dim in dims), *_TAIL]) + "\n"
    labels: dict[Hashable, list[str]] = {}
    for dim, size in result.sizes.items():
        values = result.variables[dim].values.tolist() if dim in result.variables else range(size)
        labels[dim] = [_quoted(repr(value) if isinstance(value, int | float) else str(value)) for value in values]
    for name in result.variables:
        variable = result.variables[name]
        variable = variable.transpose(*_dims(variable, result))
        before = f"{_quoted(str(name))},{_kind(variable)},{_quoted(str(variable.attrs.get('units', '')))},"
        places = product(*(labels[dim] if dim in variable.dims else [""] for dim in dims))
        lines = [
            f"{before}{','.join(place)}{',' if dims else ''}{cells}\n"
            for place, cells in zip(places, _csv_values(variable.values.ravel()), strict=True)
        ]
        yield "".join(lines)
    empty = "," * (len(dims) + 2)
    for name, value in result.attrs.items():
        yield f"{_quoted(str(name))},attribute,,{empty}{_quoted(_text_of(value))}\n"


def _dims(variable: xr.Variable, result: xr.Dataset) -> tuple[str, ...]:
    """Dims of a variable in the order of the result's."""
    return tuple(str(dim) for dim in result.sizes if dim in variable.dims)


def _kind(variable: xr.Variable) -> str:
    """Word of a variable's type."""
    words = {"f": "float", "i": "integer", "u": "integer", "b": "truth", "c": "complex", "M": "time"}
    return words.get(variable.dtype.kind, "text")


def _csv_values(values: np.ndarray[Any, Any]) -> list[str]:
    """The last three cells of every value: number, imaginary part, text."""
    kind = values.dtype.kind
    if kind == "c":
        parts = zip(values.real.tolist(), values.imag.tolist(), strict=True)
        return [f"{real!r},{imaginary!r}," for real, imaginary in parts]
    if kind in "fiu":
        return [f"{value!r},," for value in values.tolist()]
    if kind == "b":
        return [f"{value:d},," for value in values.tolist()]
    if kind == "M":
        return [f",,{value}" for value in np.datetime_as_string(values).tolist()]
    return [f",,{_quoted(_text_of(value))}" for value in values.tolist()]


def _quoted(text: str) -> str:
    """A text as a cell of a line, with an apostrophe where a spreadsheet could take it for a formula."""
    if text.startswith(_FORMULA):
        text = f"'{text}"
    if any(sign in text for sign in ',"\n\r'):
        return '"' + text.replace('"', '""') + '"'
    return text


def _text_of(value: Any) -> str:
    """An attribute or an entry of texts as text."""
    if value is None:
        return ""
    if isinstance(value, np.ndarray | list | tuple):
        return json.dumps(np.asarray(value).tolist(), default=str)
    return str(value)


# --- sheets ----------------------------------------------------------------------------------------------------------


class _Sheet(NamedTuple):
    """One sheet: the variables of equal dims, a row for each point of them.

    title : unique name of the sheet.  dims.  head, widths : of all columns, those of the dims first.
    names : of the variables.  rows : makes the rows when they are written.
    """

    title: str
    dims: tuple[str, ...]
    head: tuple[str, ...]
    widths: tuple[int, ...]
    names: tuple[str, ...]
    rows: Callable[[], Iterator[tuple[Any, ...]]]


def save_xlsx(result: xr.Dataset, path: str | Path) -> Path:
    """Write a result as a workbook; whole or not at all.

    The first sheet, ``about``, says what it is: title, verb, version, options, warnings, every sheet with its dims in
    full, and every variable with its sheet, unit and meaning; the model file at its end.  Then a sheet for each group
    of variables of equal dims, a row for each of their points: labels of the dims, then a column a variable with its
    unit in the heading, of complex ones two.  nan is an empty cell, infinity the text ``inf``.  Texts are texts,
    whatever they begin with.  A group of more rows than a sheet has goes on in a further one.

    Raises
    ------
    ModelError : more than `CELLS_OF_XLSX` cells, a text that no cell can hold, or the file cannot be written.
    """
    cells = cells_of(result)
    if cells > CELLS_OF_XLSX:
        problem = f"{cells} cells are too many for a workbook"
        raise ModelError(problem, path=str(path), allowed=f"at most {CELLS_OF_XLSX}, or .nc, .json or .csv")
    columns = [variable.values.ravel() for variable in result.variables.values() if _kind(variable) == "text"]
    longest = max((len(_text_of(text)) for values in columns for text in values.tolist()), default=0)
    if longest > _CHARACTERS:
        problem = f"a text of {longest} characters is too long for a cell"
        raise ModelError(problem, path=str(path), allowed=f"{_CHARACTERS}, or .nc, .json or .csv")
    with whole_file(path) as file:
        _write_book(result, file)
    return Path(path)


def _write_book(result: xr.Dataset, file: BinaryIO) -> None:
    """The workbook of `save_xlsx`."""
    from openpyxl import Workbook

    sheets = _sheets(result)
    book = Workbook(write_only=True)
    try:
        book.properties.creator = "epicyclic"
        book.properties.title = _xml(str(result.attrs.get("title", "")))
        _write_sheet(book, "about", ("what", "", "", "", ""), (24, 40, 14, 10, 60), _about(result, sheets), frozen=1)
        for sheet in sheets:
            frozen = len(sheet.dims) + 1 if sheet.names else 1
            _write_sheet(book, sheet.title, sheet.head, sheet.widths, sheet.rows(), frozen=frozen)
        book.save(file)
    except BaseException:
        for started in book.worksheets:  # else each of them complains when it is thrown away
            with suppress(Exception):
                started.close()
        raise


def cells_of(result: xr.Dataset) -> int:
    """Number of cells of a result in a workbook; a hundred thousand take a second, on a busy machine three."""
    columns: dict[tuple[str, ...], int] = {}
    for name, variable in result.variables.items():
        dims = _dims(variable, result)
        parts = 0 if dims == (str(name),) else 2 if variable.dtype.kind == "c" else 1
        columns[dims] = columns.get(dims, len(dims)) + parts
    points = {dims: math.prod(result.sizes[dim] for dim in dims) for dims in columns}
    return sum(count * points[dims] for dims, count in columns.items() if count > len(dims))


def _sheets(result: xr.Dataset) -> list[_Sheet]:
    """The groups of equal dims as sheets, those with fewer dims first."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for name, variable in result.variables.items():
        dims = _dims(variable, result)
        # a label of a dim stands in the column of the dim
        groups.setdefault(dims, []).extend(() if dims == (str(name),) else (str(name),))
    taken = {"about", "history"}  # the second is a name that Excel keeps for itself
    sheets: list[_Sheet] = []
    for dims, names in sorted(groups.items(), key=lambda item: len(item[0])):
        if names or (dims and not any(dims[0] in other for other in groups if other != dims)):
            sheets += _group(result, dims, names, taken)
    return sheets


def _group(result: xr.Dataset, dims: tuple[str, ...], names: list[str], taken: set[str]) -> list[_Sheet]:
    """Sheets of one group: several where it has more rows or columns than one holds."""
    # labels of the dims as cells; places from 0 where a dim has no coordinate
    coordinates = result.variables
    labels = [_cells(coordinates[dim].values) if dim in coordinates else list(range(result.sizes[dim])) for dim in dims]
    heads = [_heading(dim, coordinates[dim].attrs.get("units", "") if dim in coordinates else "") for dim in dims]
    columns: list[tuple[str, str, Any]] = []  # variable, heading, values
    for name in names:
        unit = result.variables[name].attrs.get("units", "")
        values = result.variables[name].transpose(*dims).values.ravel()
        parts = {" real": values.real, " imaginary": values.imag} if values.dtype.kind == "c" else {"": values}
        columns += [(name, _heading(f"{name}{part}", unit), cells) for part, cells in parts.items()]
    sizes = [len(entries) for entries in labels]
    room = _COLUMNS - len(dims)
    count, most = math.prod(sizes), _ROWS - 1
    sheets = []
    for left in range(0, max(len(columns), 1), room):
        shown = columns[left : left + room]
        head = (*heads, *(heading for _, heading, _ in shown))
        widths = tuple(map(_width, head, [*labels, *(values for _, _, values in shown)]))
        own = tuple(dict.fromkeys(name for name, _, _ in shown))
        for first in range(0, max(count, 1), most):
            title = _title(_short(dims) or "numbers", taken)
            rows = partial(_rows, labels, sizes, shown, first, min(first + most, count))
            sheets.append(_Sheet(title=title, dims=dims, head=head, widths=widths, names=own, rows=rows))
    return sheets


def _rows(
    labels: list[list[Any]], sizes: list[int], columns: list[tuple[str, str, Any]], first: int, last: int
) -> Iterator[tuple[Any, ...]]:
    """Rows of a group from one of its points to another: labels of the dims, then the values."""
    indices = np.unravel_index(np.arange(first, last), sizes) if sizes else ()
    keys = [[entries[i] for i in places] for entries, places in zip(labels, indices, strict=True)]
    cells = [_cells(values[first:last]) for _, _, values in columns]
    return zip(*keys, *cells, strict=True)


def _cells(values: np.ndarray[Any, Any]) -> list[Any]:
    """Values as cells: nothing for nan, a text for infinity."""
    kind = values.dtype.kind
    if kind == "M":
        return [None if text == "NaT" else text for text in np.datetime_as_string(values).tolist()]
    plain: list[Any] = values.tolist()
    if kind == "f":
        return [number if math.isfinite(number) else None if math.isnan(number) else str(number) for number in plain]
    return plain if kind in "iub" else list(map(_text_of, plain))


def _heading(name: str, unit: object) -> str:
    return f"{name} [{unit}]" if str(unit) not in ("", "1") else name


def _width(heading: str, column: Any) -> int:
    """Width of a column: of its heading, and of its first texts where it holds texts."""
    texts = [len(value) for value in column[:200] if isinstance(value, str)]
    return min(_WIDEST, max(_NARROWEST, len(heading) + 2, *texts))


def _short(dims: Sequence[str]) -> str:
    """Dims as the name of a sheet: in full, else the last words of their paths, else these cut alike, ``~`` at the cut.

    The full dims stand in the contents of the first sheet and head the columns.
    """
    full = " x ".join(dims)
    last = [dim.rsplit(".", 1)[-1] for dim in dims]
    if len(full) <= _NAME or len(" x ".join(last)) <= _NAME:
        return full if len(full) <= _NAME else " x ".join(last)
    room = max(2, (_NAME - 3 * (len(dims) - 1)) // len(dims))
    return " x ".join(word if len(word) <= room else f"{word[: room - 1]}~" for word in last)


def _title(wanted: str, taken: set[str]) -> str:
    """A name for a sheet: 31 characters without ``[]:*?/\\``, unlike any other."""
    plain = re.sub(r"[\[\]:*?/\\]", " ", _xml(wanted)).strip("' ") or "sheet"
    title, number = plain[:_NAME].strip("' "), 1
    while title.lower() in taken:
        number += 1
        title = f"{plain[: _NAME - 2 - len(str(number))].strip()} {number}"
    taken.add(title.lower())
    return title


def _about(result: xr.Dataset, sheets: Sequence[_Sheet]) -> Iterator[tuple[Any, ...]]:
    """Rows of the first sheet."""
    texts = {name: _text_of(value) for name, value in result.attrs.items()}
    first = [name for name in ("title", "verb", "package", "version", "options", "warnings") if name in texts]
    last = [name for name in texts if name not in first]
    for name in (*first, *(name for name in last if len(texts[name]) <= _LONG)):
        entries = [texts[name]]
        if name == "warnings":
            # a list in JSON
            with suppress(json.JSONDecodeError):
                warnings = json.loads(str(result.attrs[name]))
                entries = [str(entry) for entry in warnings] if isinstance(warnings, list) else entries
        yield from ((_xml(name) if not place else "", text) for place, text in enumerate(entries or ["none"]))
    yield ()
    yield ("sheet", "a row for each of", "columns")
    yield from ((sheet.title, " x ".join(sheet.dims) or "(one row)", len(sheet.head)) for sheet in sheets)
    yield ()
    yield ("variable", "sheet", "unit", "type", "meaning")
    home = {name: sheet.title for sheet in reversed(sheets) for name in (*sheet.dims, *sheet.names)}
    for key, variable in result.variables.items():
        name = str(key)
        unit, words = (str(variable.attrs.get(word, "")) for word in ("units", "long_name"))
        yield (name, home.get(name, ""), unit, _kind(variable), words)
    for name in (name for name in last if len(texts[name]) > _LONG):
        yield ()
        pieces = [texts[name][at : at + _CHARACTERS] for at in range(0, len(texts[name]), _CHARACTERS)]
        yield from ((name if not place else "", piece) for place, piece in enumerate(pieces))


def _write_sheet(
    book: Any, title: str, head: Sequence[str], widths: Sequence[int], rows: Iterator[tuple[Any, ...]], *, frozen: int
) -> None:
    """Append a sheet; its heading stands still, and so do the columns before the one numbered `frozen`."""
    from openpyxl.cell import WriteOnlyCell
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    sheet = book.create_sheet(title)
    sheet.freeze_panes = f"{get_column_letter(frozen)}2"
    for place, width in enumerate(widths, start=1):
        sheet.column_dimensions[get_column_letter(place)].width = width

    heading = []
    for name in head:
        cell = WriteOnlyCell(sheet, _xml(name))
        cell.data_type, cell.font = "s", Font(bold=True)
        heading.append(cell)
    sheet.append(heading)
    for row in rows:
        sheet.append([_cell(sheet, value) for value in row])


def _cell(sheet: Any, value: Any) -> Any:
    """A value as openpyxl takes it: that writes numbers in 16 digits, so one that needs 17 goes as the text of one."""
    from openpyxl.cell import WriteOnlyCell

    if isinstance(value, str):
        text = _xml(value)
        if not text.startswith((*_FORMULA, "#")):
            return text
        cell = WriteOnlyCell(sheet, text)
        cell.data_type, cell.quotePrefix = "s", True  # else = begins a formula, at the latest when it is edited
        return cell
    if value is None or isinstance(value, bool) or (float(f"{value:.16g}") == value and str(value) != "-0.0"):
        return value
    cell = WriteOnlyCell(sheet, repr(value))
    cell.data_type = "n"
    return cell


def _xml(text: str) -> str:
    """A text without characters that XML cannot hold: they are spelt out."""
    return _NO_XML.sub(lambda match: f"\\x{ord(match[0]):02x}", text)
