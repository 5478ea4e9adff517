"""The table of an audit in a terminal: one table a drive, remarks numbered below it, and the count of verdicts.

Depends on: terminal; a Dataset of `audit`.
"""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["show_audit", "tally"]

_STYLES = {"reproduced": "green", "under a reading": "yellow", "not reproducible": "red"}
_SHOWN = {"under a reading": "only under a stated reading"}
_REMARKS = {"reading": "reading", "reason": "reason", "because": "tolerance"}


def show_audit(result: xr.Dataset, console: Console) -> None:
    """Print the tables of an audit, what is contradicted, and the count of verdicts of each drive."""
    sources, notes = (json.loads(result.attrs[name]) for name in ("sources", "notes"))
    for drive in dict.fromkeys(map(str, result.drive.values)):
        part = result.isel(row=np.flatnonzero(result.drive.values == drive))
        console.print(f"\n[bold]{escape(drive)}[/bold]  {escape(sources[drive])}", soft_wrap=True)
        if notes[drive].strip():
            console.print(escape(" ".join(notes[drive].split())))
        remarks: dict[str, int] = {}
        console.print(_table(part, remarks))
        for text, number in remarks.items():
            console.print(f"  [bold]{number:2d}[/bold]  {escape(text)}", soft_wrap=True)
    console.print()
    for text in json.loads(result.attrs["warnings"]):
        console.print(f"[bold red]contradicted[/bold red]  {escape(text)}", soft_wrap=True)
    for drive, text in tally(result).items():
        console.print(f"[bold]{escape(drive)}[/bold]  {text}", soft_wrap=True)


def tally(result: xr.Dataset) -> dict[str, str]:
    """Drive -> how many rows have which verdict, and how many are contradicted."""
    texts = {}
    for drive in dict.fromkeys(map(str, result.drive.values)):
        part = result.isel(row=np.flatnonzero(result.drive.values == drive))
        counts = Counter(map(str, part.verdict.values))
        wrong = int(np.sum(part.outcome.values != "holds"))
        texts[drive] = ", ".join([*(f"{counts[verdict]} {verdict}" for verdict in _STYLES), f"{wrong} contradicted"])
    return texts


def _table(part: xr.Dataset, remarks: dict[str, int]) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for name in ("quantity", "place"):
        table.add_column(name, overflow="fold")
    for name in ("published", "ours", "difference"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("verdict", overflow="fold")
    table.add_column("remark", no_wrap=True)
    for at in range(part.sizes["row"]):
        row = {str(name): part[name].values[at] for name in part.data_vars}
        table.add_row(*_cells(row, remarks))
    return table


def _cells(row: dict[str, Any], remarks: dict[str, int]) -> list[str]:
    unit = "" if row["published_unit"] == "1" else f" {row['published_unit']}"
    verdict = str(row["verdict"])
    shown = f"[{_STYLES[verdict]}]{_SHOWN.get(verdict, verdict)}[/]" + (", fitted" if row["fitted"] else "")
    if row["outcome"] != "holds":
        shown += " [bold red](contradicted)[/bold red]"
    texts = [f"{word}: {row[name]}" for name, word in _REMARKS.items() if row[name]]
    numbers = [remarks.setdefault(text, len(remarks) + 1) for text in texts]
    return [
        escape(str(row["quantity"])),
        escape(str(row["place"])),
        escape(str(row["published_text"])) + unit,
        _number(row["ours"], 6),
        _number(row["difference"], 2),
        shown,
        " ".join(map(str, numbers)),
    ]


def _number(value: float, digits: int) -> str:
    return "" if np.isnan(value) else f"{value + 0.0:.{digits}g}"
