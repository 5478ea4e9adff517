"""`audit`: published numbers beside ours, a table a drive, remarks numbered below it, and the count of verdicts."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Section, Styled, Table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ORDER", "sections", "tables", "tally"]

ORDER = 170
_TONES = {"reproduced": "good", "under a reading": "caution", "not reproducible": "bad"}
_SHOWN = {"under a reading": "only under a stated reading"}
_NOT_COMPUTED = "not computed"
_REMARKS = {"reading": "reading", "reason": "reason", "because": "tolerance"}


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Every published number of each drive beside ours; then how many rows of each drive have which verdict."""
    sources, notes = (json.loads(result.attrs[name]) for name in ("sources", "notes"))
    found = [_rows(part, f"{drive}: {sources[drive]}", notes[drive]) for drive, part in _drives(result)]
    counts = [(drive, _counts(part)) for drive, part in _drives(result)]
    columns: dict[str, Any] = {"drive": [drive for drive, _ in counts]}
    kinds = dict.fromkeys(kind for _, count in counts for kind in count)
    columns |= {kind: [count.get(kind, 0) for _, count in counts] for kind in kinds}
    return [*found, Table(title="Verdicts", columns=columns)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The tables."""
    return [Section(anchor="audit", title="Published numbers beside ours", parts=tables(result))]


def tally(result: xr.Dataset) -> dict[str, str]:
    """Drive -> how many rows have which verdict, are contradicted, and are not computed where there are such."""
    return {
        drive: ", ".join(f"{count} {verdict}" for verdict, count in _counts(part).items())
        for drive, part in _drives(result)
    }


def _drives(result: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    for drive in dict.fromkeys(map(str, result.drive.values)):
        yield drive, result.isel(row=np.flatnonzero(result.drive.values == drive))


def _counts(part: xr.Dataset) -> dict[str, int]:
    outcomes = [str(outcome) for outcome in part.outcome.values]
    missing = [outcome.startswith(_NOT_COMPUTED) for outcome in outcomes]
    counts = Counter(str(verdict) for verdict, absent in zip(part.verdict.values, missing, strict=True) if not absent)
    wrong = sum(outcome != "holds" and not absent for outcome, absent in zip(outcomes, missing, strict=True))
    found = {verdict: counts[verdict] for verdict in _TONES} | {"contradicted": wrong}
    return found | ({_NOT_COMPUTED: sum(missing)} if any(missing) else {})


def _rows(part: xr.Dataset, title: str, note: str) -> Table:
    rows = [{str(name): part[name].values[at] for name in part.data_vars} for at in range(part.sizes["row"])]
    remarks: dict[str, int] = {}
    columns: dict[str, Any] = {
        "quantity": [str(row["quantity"]) for row in rows],
        "place": [str(row["place"]) for row in rows],
        "published": [str(row["published_text"]) + _unit(str(row["published_unit"])) for row in rows],
        "ours": [float(row["ours"]) for row in rows],
        "difference": [float(f"{row['difference']:.2g}") for row in rows],
        "verdict": [_verdict(row) for row in rows],
        "remark": [_remarks(row, remarks) for row in rows],
    }
    return Table(title=title, columns=columns, lead=" ".join(note.split()), notes=tuple(remarks))


def _unit(text: str) -> str:
    return "" if text == "1" else f" {text}"


def _verdict(row: dict[str, Any]) -> Styled:
    verdict = str(row["verdict"])
    text = _SHOWN.get(verdict, verdict) + (", fitted" if row["fitted"] else "")
    if str(row["outcome"]).startswith(_NOT_COMPUTED):
        return Styled(text=f"{text} ({_NOT_COMPUTED})", tone="caution")
    if row["outcome"] != "holds":
        return Styled(text=f"{text} (contradicted)", tone="bad")
    return Styled(text=text, tone=_TONES[verdict])


def _remarks(row: dict[str, Any], remarks: dict[str, int]) -> str:
    """Numbers of the remarks of a row; a remark has one number wherever it comes."""
    texts = [f"{word}: {row[name]}" for name, word in _REMARKS.items() if row[name]]
    return " ".join(str(remarks.setdefault(text, len(remarks) + 1)) for text in texts)
