"""Audit of published numbers: runs of the verbs that an audit file names, and a check of every claim.

A value is selected by labels, reduced, combined and converted.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..engine.source import system_of, train_of
from ..errors import ConvergenceError, ModelError
from ..results.dataset import dataset
from ..user_input import checked
from ..verbs.record import keywords, verbs
from ..warning_codes import coded
from .audit_file import (
    AS_PRINTED,
    Attempt,
    Audit,
    AuditFile,
    Label,
    Row,
    Value,
    attempts,
    audited_drives,
    claim_of,
    named,
    read_audit,
)

if TYPE_CHECKING:
    from ..system.system import System
    from ..train.train import Train

HOLDS, CONTRADICTED = "holds", "contradicted"
_WITHIN, _OUTSIDE = "within", "outside"
_SHOWN, _NO_NUMBER = "shown", "no number"
NOT_COMPUTED = "not computed"
"""Start of the outcome of a row whose run needs a package that is not installed; how to install it follows."""
WRONG = "wrong"
"""Start of the outcome of a row that cannot be read, or whose run or number is refused; the message follows."""
EXTRAS = {"numba": "fast", "pymoo": "optimise"}
"""Package outside the plain installation -> extra of this package that brings it."""
_ROUNDING = 1e-12  # a difference equal to the tolerance is within it


class _NotInstalledError(Exception):
    """A run needs a package that is not installed; the text says which, and how to install it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Tried:
    """An attempt and its numbers [unit of the row], one for each published; nan where there is none.

    missing : why a run gave none, "" where it gave one.  error : why the row or its run is wrong, or None.
    within : whether each is within the tolerance or bounds; None where there are none, or no number.
    """

    attempt: Attempt
    ours: Sequence[float]
    missing: str = ""
    error: ModelError | None = None
    within: Sequence[bool | None]
    fitted: bool

    @property
    def failure(self) -> str:
        """Why there is no number; "" where there is one, or none was asked for."""
        return self.missing if self.error is None else f"{WRONG}: {self.error}"

    @property
    def holds(self) -> bool:
        """Whether the whole list of numbers comes out."""
        return all(one is True for one in self.within)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    """One row of the table, its list taken apart.

    at : place in the list.  shown : the attempt whose number stands in the row.
    tried : all attempts, where the row has readings.
    """

    drive: str
    row: Row
    quantity: str
    published: float
    at: int
    shown: _Tried
    tried: Sequence[_Tried]
    outcome: str

    @property
    def ours(self) -> float:
        return self.shown.ours[self.at]


@checked
def audit(
    names: str | Path | Sequence[str | Path] | None = None, *, progress: Callable[[float], None] | None = None
) -> xr.Dataset:
    """Compute every published number of one, several or (None) all ready drives and check what is claimed of it.

    Parameters
    ----------
    names : ready drives, or paths of audit files.  progress : called with the share done, 0..1.

    Returns
    -------
    Dataset along ``row``: drive, quantity, place, published (nan where it is not one number), published_text,
        published_unit, ours, difference (ours - published), tolerance (all three in published_unit), verdict, outcome
        ("holds", "contradicted", "not computed: ..." where a package is missing, "wrong: ..." where the row or its run
        is refused, or why nothing came out), because, reading, reason, fitted, published_as, origin, nothing_to_try;
        ours to fitted are those of the reading shown.
        Along ``attempt``, every number tried for a row with readings: attempt_row (label of ``row``), attempt_reading,
        attempt_ours, attempt_difference, attempt_tolerance, attempt_because, attempt_reason, attempt_fitted,
        attempt_outcome ("within", "outside", "shown" where nothing is to be checked, or why there is no number).

    Raises
    ------
    ModelError : no such audit, something in its file beside single rows is wrong, or all of its rows are.
    """
    sources = audited_drives() if names is None else [names] if isinstance(names, str | Path) else list(names)
    found = [read_audit(source) for source in sources]
    total = sum(len(one.audit.runs) for one in found) or 1
    done = 0

    def count() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done / total)

    lines = [line for one in found for line in _lines(one, count)]
    errors = [line.shown.error for line in lines]
    if errors and (first := errors[0]) is not None and None not in errors:
        raise first  # nothing is left of the audit
    return _table(lines, {one.drive: one.audit for one in found})


def _lines(file: AuditFile, count: Callable[[], None]) -> Iterator[_Line]:
    """Every row of an audit in the order of the file, computed and checked; of one that cannot be read why."""
    result_of = _runner(file.drive, file.audit, count)
    good, wrong = dict(zip(file.places, file.audit.rows, strict=True)), {one.at: one for one in file.wrong}
    for at in sorted({*good, *wrong}):
        if at in good:
            yield from _checked(good[at], at, file=file, result_of=result_of)
            continue
        row, error = wrong[at].row, wrong[at].error
        shown = _Tried(attempt=attempts(row)[0], ours=[math.nan], error=error, within=[None], fitted=False)
        words = {"drive": file.drive, "quantity": row.quantity, "outcome": shown.failure}
        yield _Line(row=row, published=math.nan, at=0, shown=shown, tried=(), **words)


def _runner(drive: str, data: Audit, count: Callable[[], None]) -> Callable[[str], xr.Dataset]:
    """Runs by name, each computed when first asked for; runs on the same model share its System."""
    results: dict[str, xr.Dataset | ConvergenceError | ModelError | _NotInstalledError] = {}
    models: dict[tuple[str, bool], Train | System] = {}

    def result_of(name: str) -> xr.Dataset:
        if name not in results:
            try:
                results[name] = _run(data, name, drive, models)
            except (ConvergenceError, _NotInstalledError) as error:
                results[name] = error
            except ModelError as error:
                where = f"runs.{name}.{error.path}" if error.path else f"runs.{name}"
                results[name] = error.at(where)
            count()
        found = results[name]
        if isinstance(found, Exception):
            raise found
        return found

    return result_of


def _run(data: Audit, name: str, drive: str, models: dict[tuple[str, bool], Train | System]) -> xr.Dataset:
    """Dataset of a run by its name; models : Trains and Systems loaded before, by drive, overrides and kind."""
    run = data.resolved(name)
    if run.needs is not None and find_spec(run.needs) is None:
        wanted = f"'epicyclic[{EXTRAS[run.needs]}]'" if run.needs in EXTRAS else run.needs
        raise _NotInstalledError(f"{run.needs} is not installed; pip install {wanted}")
    verb = verbs()[run.verb or ""]
    key = json.dumps([run.drive or drive, run.set], sort_keys=True, default=str), verb.drawing
    if key not in models:
        models[key] = (train_of if verb.drawing else system_of)(run.drive or drive, overrides=run.set or None)
    try:
        return verb.run(models[key], **run.options)
    except TypeError as error:
        if "keyword argument" not in str(error):
            raise
        raise ModelError(f"unknown option: {error}", path="options", allowed=", ".join(keywords(verb.run))) from None


def _checked(row: Row, at: int, *, file: AuditFile, result_of: Callable[[str], xr.Dataset]) -> Iterator[_Line]:
    """One line for each published number of a row."""
    published = row.published if isinstance(row.published, list) else [row.published]
    tried = [_tried(one, row, at, published, file, result_of) for one in attempts(row)]
    shown = next((one for one in tried if one.attempt.ours is not None), tried[0])
    if row.verdict == "under a reading" and row.readings:  # the best reading, one without a fitted value before
        shown = max(tried, key=lambda one: (one.holds, not one.fitted, one.within.count(True)))
    for place, given in enumerate(published):
        label = row.labels[place] if row.labels else str(place + 1)
        yield _Line(
            drive=file.drive,
            row=row,
            quantity=row.quantity.replace("{}", label) if isinstance(row.published, list) else row.quantity,
            published=math.nan if isinstance(given, str) else float(given),
            at=place,
            shown=shown,
            tried=tried if row.readings else (),
            outcome=_outcome(row, tried, shown, place),
        )


def _tried(
    attempt: Attempt,
    row: Row,
    at: int,
    published: Sequence[float | str],
    file: AuditFile,
    result_of: Callable[[str], xr.Dataset],
) -> _Tried:
    """An attempt computed and compared with each published number."""
    ours: Sequence[float] = [math.nan] * len(published)
    missing, wrong = "", None
    try:
        ours = _ours(attempt, row, at, len(published), result_of)
    except ConvergenceError as error:
        missing = f"no convergence: {error}"
    except _NotInstalledError as error:
        missing = f"{NOT_COMPUTED}: {error}"
    except ModelError as error:
        wrong = named(error, file.file)
    within = [_within(attempt, given, value) for given, value in zip(published, ours, strict=True)]
    fitted = file.audit.fitted(attempt)
    return _Tried(attempt=attempt, ours=ours, missing=missing, error=wrong, within=within, fitted=fitted)


def _ours(attempt: Attempt, row: Row, at: int, count: int, result_of: Callable[[str], xr.Dataset]) -> Sequence[float]:
    """Our values (count,) in the unit of the row; nan where none is asked for.

    Raises
    ------
    ModelError : what a run refuses, or what ours asks of its result.
    """
    if attempt.ours is None:
        return [math.nan] * count
    try:
        values = converted(evaluate(attempt.ours, result_of), row.unit).values
    except ModelError as error:
        if error.path.startswith("runs."):
            raise
        raise ModelError(f"{row.quantity}: {error}", path=f"rows.{at}.ours") from error
    if len(values) != count:
        problem = f"{len(values)} of ours for {count} published"
        raise ModelError(problem, path=f"rows.{at}.ours", given=row.quantity, allowed="as many as are published")
    return [float(value) for value in values]


def _outcome(row: Row, tried: Sequence[_Tried], shown: _Tried, place: int) -> str:
    """Whether the numbers are consistent with the verdict, at one place of the list; or why there are none."""
    if refused := [one.failure for one in tried if one.error is not None]:
        return refused[0]  # a reading that is wrong supports no verdict
    if not row.readings or row.verdict == "reproduced":
        holds = row.verdict == "not compared" or shown.within[place] is True
        if row.verdict == "not reproducible":
            holds = row.ours is None or (not math.isnan(shown.ours[place]) and shown.within[place] is not True)
        return shown.failure or (HOLDS if holds else CONTRADICTED)
    plain = row.ours is not None and not row.reading and tried[0].holds
    if row.verdict == "not reproducible":
        return CONTRADICTED if any(one.holds for one in tried) else HOLDS
    if shown.holds:
        return CONTRADICTED if plain else HOLDS  # what needs no reading is reproduced
    absent = [one.failure for one in tried if one.failure.startswith(NOT_COMPUTED)]
    return absent[0] if absent else shown.failure or (HOLDS if shown.within[place] else CONTRADICTED)


def _within(attempt: Attempt, published: float | str, ours: float) -> bool | None:
    """Whether ours [unit of the row] is within the tolerance or bounds; None where there are none, or no number."""
    if math.isnan(ours):
        return None
    if isinstance(published, str):
        claim = claim_of(published)
        if claim is None:
            return None
        return claim.low < ours < claim.high if claim.strict else claim.low <= ours <= claim.high
    tolerance = _tolerance(attempt, published)
    return None if math.isnan(tolerance) else abs(ours - published) <= tolerance + _ROUNDING * abs(published)


def _tolerance(attempt: Attempt, published: float) -> float:
    """Absolute tolerance [unit of the row]; nan where there is none."""
    if attempt.tolerance is not None:
        return attempt.tolerance
    return math.nan if attempt.relative is None else attempt.relative * abs(published)


def _table(lines: Sequence[_Line], audits: dict[str, Audit]) -> xr.Dataset:
    """Dataset along `row` of all lines and `attempt` of all that was tried; what does not hold is a warning."""
    columns: dict[str, Any] = {
        "drive": [line.drive for line in lines],
        "quantity": [line.quantity for line in lines],
        "place": [line.row.place for line in lines],
        "published": [line.published for line in lines],
        "published_text": [
            line.row.published if isinstance(line.row.published, str) else f"{line.published:.10g}" for line in lines
        ],
        "published_unit": [line.row.unit for line in lines],
        "ours": [line.ours for line in lines],
        "difference": [line.ours - line.published for line in lines],
        "tolerance": [_tolerance(line.shown.attempt, line.published) for line in lines],
        "verdict": [line.row.verdict for line in lines],
        "outcome": [line.outcome for line in lines],
        "because": [line.shown.attempt.because for line in lines],
        "reading": [_reading(line) for line in lines],
        "reason": [line.row.reason for line in lines],
        "fitted": [line.shown.fitted for line in lines],
        "published_as": [line.row.published_as or "" for line in lines],
        "origin": [line.row.origin for line in lines],
        "nothing_to_try": [line.row.nothing_to_try for line in lines],
    }
    tried = [(at, line, one) for at, line in enumerate(lines) for one in line.tried]
    ours = [one.ours[line.at] for _, line, one in tried]
    of_attempts: dict[str, tuple[list[Any], type]] = {
        "row": ([at for at, _, _ in tried], int),
        "reading": ([one.attempt.reading for _, _, one in tried], str),
        "ours": (ours, float),
        "difference": ([value - line.published for value, (_, line, _) in zip(ours, tried, strict=True)], float),
        "tolerance": ([_tolerance(one.attempt, line.published) for _, line, one in tried], float),
        "because": ([one.attempt.because for _, _, one in tried], str),
        "reason": ([one.attempt.reason for _, _, one in tried], str),
        "fitted": ([one.fitted for _, _, one in tried], bool),
        "outcome": ([_attempt_outcome(one, line.at) for _, line, one in tried], str),
    }
    wrong = [line for line in lines if line.outcome != HOLDS]
    return dataset(
        {name: ("row", np.array(values) if values else np.array([], dtype=str)) for name, values in columns.items()}
        | {f"attempt_{name}": ("attempt", np.array(values, kind)) for name, (values, kind) in of_attempts.items()},
        coords={"row": np.arange(len(lines)), "attempt": np.arange(len(tried))},
        verb="audit",
        warnings=[coded("audit-differs", f"{line.drive}: {line.quantity}: {line.outcome}") for line in wrong],
        provenance={
            "title": "Published numbers and ours",
            "sources": json.dumps({drive: data.source for drive, data in audits.items()}),
            "notes": json.dumps({drive: data.notes for drive, data in audits.items()}),
        },
    )


def _attempt_outcome(tried: _Tried, place: int) -> str:
    """How one number of an attempt compares with the published one."""
    if tried.failure or tried.attempt.ours is None:
        return tried.failure or _NO_NUMBER
    within = tried.within[place]
    return _SHOWN if within is None else _WITHIN if within else _OUTSIDE


def _reading(line: _Line) -> str:
    """Text of the reading whose number stands in the row; none where that needs no reading."""
    return line.row.reading if line.shown.attempt.reading == AS_PRINTED else line.shown.attempt.reading


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
        found: NDArray[np.bool_] = np.any([np.zeros(len(labels)), *(_matches(labels, one) for one in wanted)], axis=0)
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


_REDUCE: Mapping[str, Callable[[xr.DataArray, list[Any]], xr.DataArray]] = {
    "max": lambda data, dims: data.max(dims, skipna=False),
    "min": lambda data, dims: data.min(dims, skipna=False),
    "mean": lambda data, dims: data.mean(dims, skipna=False),
    "sum": lambda data, dims: data.sum(dims, skipna=False),
    "rms": lambda data, dims: (data**2).mean(dims, skipna=False) ** 0.5,
    "range": lambda data, dims: data.max(dims, skipna=False) - data.min(dims, skipna=False),
    "ratio": lambda data, dims: data.max(dims, skipna=False) / data.min(dims, skipna=False),
    "largest": lambda data, dims: abs(data).max(dims, skipna=False),
    "first": lambda data, dims: data.isel(dict.fromkeys(dims, 0)),
    "last": lambda data, dims: data.isel(dict.fromkeys(dims, -1)),
}


_COMBINE = {
    "ratio": np.divide,
    "product": np.multiply,
    "difference": np.subtract,
    "sum": np.add,
    "greatest": np.maximum,
    "least": np.minimum,
}


def _combined(value: Value, parts: list[Measured]) -> Measured:
    """Ratio, product, difference, sum, greatest or least of values (k,) of equal length, or of length 1."""
    form, unit = next(form for form in _COMBINE if getattr(value, form) is not None), parts[0].unit
    if form not in ("ratio", "product"):
        parts = [converted(part, unit) for part in parts]
    elif form == "ratio" and unit == parts[1].unit:
        unit = "1"
    else:
        unit = ("/" if form == "ratio" else "*").join(f"({part.unit or '1'})" for part in parts)
    stack = np.array(np.broadcast_arrays(*(part.values for part in parts)))
    return Measured(values=_COMBINE[form].reduce(stack), unit=unit)


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
