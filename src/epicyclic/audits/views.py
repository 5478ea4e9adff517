"""`audit`: published numbers beside ours, a table a drive, remarks numbered below it, and the count of verdicts.

Below a row stand the readings of the source that were tried for it, each with its number.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..show.elements import Company, Section, Styled, Table
from ..show.views import ResultView

if TYPE_CHECKING:
    import xarray as xr

_TONES = {"reproduced": "good", "under a reading": "caution", "not reproducible": "bad", "not compared": "caution"}
_CONTRADICTED, _BY_HAND, _HAND_CALCULATIONS = "contradicted", "hand calculation", "hand calculations"
_SHOWN = {"under a reading": "only under a stated reading"}
_NOT_COMPUTED, _WRONG = "not computed", "wrong"
_REMARKS = {"reading": "reading", "reason": "reason", "because": "tolerance", "nothing_to_try": "nothing to try"}
_KINDS = ("hand calculations of ours", "zeros", "counts", "inequalities", "other numbers, inputs among them")
_ATTEMPT = "attempt_"  # start of the names of what was tried for the rows


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Every published number of each drive beside ours; then how many rows of each drive have which verdict."""
    sources, notes = (json.loads(result.attrs[name]) for name in ("sources", "notes"))
    found = [_rows(part, f"{drive}: {sources[drive]}", notes[drive]) for drive, part in _drives(result)]
    counts = [(drive, _counts(part)) for drive, part in _drives(result)]
    columns: dict[str, Any] = {"drive": [drive for drive, _ in counts]}
    kinds = dict.fromkeys(kind for _, count in counts for kind in count)
    columns |= {kind: [count.get(kind, 0) for _, count in counts] for kind in kinds}
    return [*found, Table(title="Verdicts", columns=columns, lead=_what_agrees(result))]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The tables."""
    return [Section(anchor="audit", title="Published numbers beside ours", parts=tables(result))]


def tally(result: xr.Dataset) -> dict[str, str]:
    """Drive -> how many numbers of its source have which verdict, or are contradicted, each counted once.

    Those not computed for want of a package, wrong ones and our own hand calculations are counted where there are such.
    """
    return {
        drive: ", ".join(f"{count} {verdict}" for verdict, count in _counts(part).items())
        for drive, part in _drives(result)
    }


def _what_agrees(result: xr.Dataset) -> str:
    """Of what kind the rows are that agree: a zero, a count or an inequality says less than a value.

    A row is a zero by what is published, a count by a tolerance of 0.
    """
    rows = _records(result, "row")
    agree = [row for row in rows if row["outcome"] == "holds" and row["verdict"] == "reproduced"]
    kinds = Counter(
        "hand calculations of ours"
        if row.get("origin") == _BY_HAND
        else "inequalities"
        if np.isnan(row.get("published", np.nan))
        else "zeros"
        if row["published"] == 0
        else "counts"
        if row["tolerance"] == 0
        else "other numbers, inputs among them"
        for row in agree
    )
    words = ", ".join(f"{kinds[kind]} {kind}" for kind in _KINDS)
    return f"{len(agree)} of {len(rows)} rows agree without a reading: {words}." if agree else ""


def _drives(result: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Part of the table of each drive; what was tried for the rows is that of all drives."""
    for drive in dict.fromkeys(map(str, result.drive.values)):
        yield drive, result.isel(row=np.flatnonzero(result.drive.values == drive))


def _counts(part: xr.Dataset) -> dict[str, int]:
    """Kind -> number of rows; every row is of one kind."""
    kinds = Counter(_kind(row) for row in _records(part, "row"))
    always = {kind: kinds[kind] for kind in (*_TONES, _CONTRADICTED)}
    return always | {kind: kinds[kind] for kind in (_NOT_COMPUTED, _WRONG, _HAND_CALCULATIONS) if kinds[kind]}


def _kind(row: dict[str, Any]) -> str:
    """What a row is counted as."""
    for kind in (_NOT_COMPUTED, _WRONG):
        if str(row["outcome"]).startswith(kind):
            return kind
    if row["outcome"] != "holds":
        return _CONTRADICTED
    return _HAND_CALCULATIONS if row.get("origin") == _BY_HAND else str(row["verdict"])


def _records(part: xr.Dataset, along: str) -> list[dict[str, Any]]:
    """Rows of the variables along a dimension, by name; empty where the result has no such dimension."""
    names = [name for name in part.variables if part[name].dims == (along,)]
    return [{str(name): part[name].values[at] for name in names} for at in range(part.sizes.get(along, 0))]


def _rows(part: xr.Dataset, title: str, note: str) -> Table:
    """Table of a drive: every row, and below it what was tried."""
    remarks: dict[str, int] = {}
    # an attempt by the names of a row
    attempts = [{name.removeprefix(_ATTEMPT): v for name, v in one.items()} for one in _records(part, "attempt")]
    lines = []
    for at, row in zip(part["row"].values, _records(part, "row"), strict=True):
        tried = [attempt for attempt in attempts if attempt["row"] == at]
        lines.append(_cells(row, tried, remarks))
        lines += [_attempt_cells(attempt, row, remarks) for attempt in tried]
    names = ("quantity", "place", "published", "ours", "difference", "verdict", "remark")
    columns = {name: [line[at] for line in lines] for at, name in enumerate(names)}
    return Table(title=title, columns=columns, lead=" ".join(note.split()), notes=tuple(remarks))


def _cells(row: dict[str, Any], tried: Sequence[dict[str, Any]], remarks: dict[str, int]) -> tuple[Any, ...]:
    """Cells of a row; tried : what was tried for it, whose texts stand below."""
    unit = "" if row["published_unit"] == "1" else f" {row['published_unit']}"
    texts = {name: row.get(name, "") for name in _REMARKS if not (tried and name == "reading")}
    return (
        str(row["quantity"]),
        str(row["place"]),
        f"{row['published_text']}{unit}",
        float(row["ours"]),
        float(f"{row['difference']:.2g}"),
        _verdict(row, len(tried)),
        _remarks(texts, remarks),
    )


def _attempt_cells(attempt: dict[str, Any], row: dict[str, Any], remarks: dict[str, int]) -> tuple[Any, ...]:
    """Cells of an attempt below its row; it has the remarks that the row has not."""
    texts = {name: attempt[name] for name in ("reason", "because") if attempt[name] != row[name]}
    outcome = str(attempt["outcome"]) + (", fitted" if attempt["fitted"] else "")
    tone = "good" if attempt["outcome"] == "within" else "caution"
    return (
        f"- {attempt['reading']}",
        "",
        "",
        float(attempt["ours"]),
        float(f"{attempt['difference']:.2g}"),
        Styled(text=outcome, tone=tone),
        _remarks(texts, remarks),
    )


def _verdict(row: dict[str, Any], tried: int) -> Styled:
    """Words of the verdict; tried : number of readings tried."""
    verdict = str(row["verdict"])
    text = _SHOWN.get(verdict, verdict) + (", fitted" if row["fitted"] else "")
    if row.get("origin") == _BY_HAND:
        text = f"agrees with our {_BY_HAND}" if verdict == "reproduced" else f"{text}, our {_BY_HAND}"
    if row.get("published_as"):
        text += f": {row['published_as']}"
    if verdict == "not reproducible" and tried:
        text += f": {tried} readings tried"
    if str(row["outcome"]).startswith(_NOT_COMPUTED):
        return Styled(text=f"{text} ({_NOT_COMPUTED})", tone="caution")
    if str(row["outcome"]).startswith(_WRONG):
        return Styled(text=f"{text} ({_WRONG})".strip(), tone="bad")
    if row["outcome"] != "holds":
        return Styled(text=f"{text} (contradicted)", tone="bad")
    return Styled(text=text, tone=_TONES[verdict])


def _remarks(texts: dict[str, Any], remarks: dict[str, int]) -> str:
    """Numbers of the remarks on a row, from texts by name; a remark has one number wherever it comes."""
    said = [f"{_REMARKS[name]}: {text}" for name, text in texts.items() if text]
    return " ".join(str(remarks.setdefault(text, len(remarks) + 1)) for text in said)


VIEWS = (ResultView("audit", 170, tables, sections),)
