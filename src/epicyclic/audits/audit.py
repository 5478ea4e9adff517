"""Audit of published numbers: runs of the verbs that an audit file names, and a check of every claim."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from ..errors import ConvergenceError, ModelError
from ..results.dataset import dataset
from ..studies.source import system_of, train_of
from ..verbs.record import keywords, verbs
from .audit_file import Audit, Row, audited_drives, claim_of, read_audit
from .evaluation import converted, evaluate

if TYPE_CHECKING:
    from ..system.system import System
    from ..train.train import Train

__all__ = ["EXTRAS", "HOLDS", "NOT_COMPUTED", "audit"]

HOLDS, CONTRADICTED = "holds", "contradicted"
NOT_COMPUTED = "not computed"
"""Start of the outcome of a row whose run needs a package that is not installed; how to install it follows."""
EXTRAS = {"numba": "fast", "pymoo": "optimise"}
"""Package outside the plain installation -> extra of this package that brings it."""
_ROUNDING = 1e-12  # a difference equal to the tolerance is within it


class _NotInstalledError(Exception):
    """A run needs a package that is not installed; the text says which, and how to install it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    """One row of the table, its list taken apart."""

    drive: str
    row: Row
    quantity: str
    published: float
    ours: float
    outcome: str
    fitted: bool


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
        ("holds", "contradicted", "not computed: ..." where a package is missing, or why nothing came out), because,
        reading, reason, fitted.

    Raises
    ------
    ModelError : no such audit, or something in its file is wrong.
    """
    sources = audited_drives() if names is None else [names] if isinstance(names, str | Path) else list(names)
    found = [read_audit(source) for source in sources]
    total = sum(len(one.runs) for _, one in found) or 1
    done = 0

    def count() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done / total)

    lines = [line for drive, one in found for line in _lines(drive, one, count)]
    return _table(lines, {drive: one for drive, one in found})


def _lines(drive: str, data: Audit, count: Callable[[], None]) -> Iterator[_Line]:
    """Every row of an audit, computed and checked."""
    result_of = _runner(drive, data, count)
    for at, row in enumerate(data.rows):
        yield from _checked(row, at, drive=drive, fitted=data.fitted(row), result_of=result_of)


def _runner(drive: str, data: Audit, count: Callable[[], None]) -> Callable[[str], xr.Dataset]:
    """Runs by name, each computed when first asked for; runs on the same model share its System."""
    results: dict[str, xr.Dataset | ConvergenceError | _NotInstalledError] = {}
    models: dict[tuple[str, bool], Train | System] = {}

    def result_of(name: str) -> xr.Dataset:
        if name not in results:
            try:
                results[name] = _run(data, name, drive, models)
            except (ConvergenceError, _NotInstalledError) as error:
                results[name] = error
            except ModelError as error:
                where = f"runs.{name}.{error.path}" if error.path else f"runs.{name}"
                raise ModelError(error.problem, path=where, allowed=error.allowed) from error
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


def _checked(row: Row, at: int, *, drive: str, fitted: bool, result_of: Callable[[str], xr.Dataset]) -> Iterator[_Line]:
    """One line for each published number of a row."""
    published = row.published if isinstance(row.published, list) else [row.published]
    ours, failure = _ours(row, at, len(published), result_of)
    for place, (given, value) in enumerate(zip(published, ours, strict=True)):
        label = row.labels[place] if row.labels else str(place + 1)
        number = math.nan if isinstance(given, str) else float(given)
        yield _Line(
            drive=drive,
            row=row,
            quantity=row.quantity.replace("{}", label) if isinstance(row.published, list) else row.quantity,
            published=number,
            ours=value,
            outcome=failure or (HOLDS if _holds(row, given, value) else CONTRADICTED),
            fitted=fitted,
        )


def _ours(row: Row, at: int, count: int, result_of: Callable[[str], xr.Dataset]) -> tuple[Sequence[float], str]:
    """Our values (count,) in the unit of the row; nan and the reason where a run gave none."""
    if row.ours is None:
        return [math.nan] * count, ""
    try:
        values = converted(evaluate(row.ours, result_of), row.unit).values
    except ConvergenceError as error:
        return [math.nan] * count, f"no convergence: {error}"
    except _NotInstalledError as error:
        return [math.nan] * count, f"{NOT_COMPUTED}: {error}"
    except ModelError as error:
        if error.path.startswith("runs."):
            raise
        raise ModelError(f"{row.quantity}: {error}", path=f"rows.{at}.ours") from error
    if len(values) != count:
        problem = f"{len(values)} of ours for {count} published"
        raise ModelError(problem, path=f"rows.{at}.ours", given=row.quantity, allowed="as many as are published")
    return [float(value) for value in values], ""


def _holds(row: Row, published: float | str, ours: float) -> bool:
    """Whether our value [unit of the row] is consistent with the verdict."""
    within = _within(row, published, ours)
    if row.verdict == "not reproducible":
        return row.ours is None or (not math.isnan(ours) and within is not True)
    return within is True


def _within(row: Row, published: float | str, ours: float) -> bool | None:
    """Whether ours is within the tolerance or bounds; None where the row has none."""
    if isinstance(published, str):
        claim = claim_of(published)
        if claim is None:
            return None
        return claim.low < ours < claim.high if claim.strict else claim.low <= ours <= claim.high
    tolerance = _tolerance(row, published)
    return None if math.isnan(tolerance) else abs(ours - published) <= tolerance + _ROUNDING * abs(published)


def _tolerance(row: Row, published: float) -> float:
    """Absolute tolerance [unit of the row]; nan where the row has none."""
    if row.tolerance is not None:
        return row.tolerance
    return math.nan if row.relative is None else row.relative * abs(published)


def _table(lines: Sequence[_Line], audits: dict[str, Audit]) -> xr.Dataset:
    """Dataset along `row` of all lines; what is contradicted or not computed is a warning."""
    columns: dict[str, Any] = {
        "drive": [line.drive for line in lines],
        "quantity": [line.quantity for line in lines],
        "place": [line.row.place for line in lines],
        "published": [line.published for line in lines],
        "published_text": [_published_text(line) for line in lines],
        "published_unit": [line.row.unit for line in lines],
        "ours": [line.ours for line in lines],
        "difference": [line.ours - line.published for line in lines],
        "tolerance": [_tolerance(line.row, line.published) for line in lines],
        "verdict": [line.row.verdict for line in lines],
        "outcome": [line.outcome for line in lines],
        "because": [line.row.because for line in lines],
        "reading": [line.row.reading for line in lines],
        "reason": [line.row.reason for line in lines],
        "fitted": [line.fitted for line in lines],
    }
    wrong = [f"{line.drive}: {line.quantity}: {line.outcome}" for line in lines if line.outcome != HOLDS]
    return dataset(
        {name: ("row", np.array(values) if values else np.array([], dtype=str)) for name, values in columns.items()},
        coords={"row": np.arange(len(lines))},
        verb="audit",
        warnings=wrong,
        provenance={
            "title": "Published numbers and ours",
            "sources": json.dumps({drive: data.source for drive, data in audits.items()}),
            "notes": json.dumps({drive: data.notes for drive, data in audits.items()}),
        },
    )


def _published_text(line: _Line) -> str:
    return line.row.published if isinstance(line.row.published, str) else f"{line.published:.10g}"
