"""Results for people in a terminal: title, warnings, tables with units; names and what they are."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table as RichTable

from .elements import Table, number, shown_columns
from .views import tables_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["rich_table", "show", "show_pairs", "stdout_console", "warnings_of"]

_STYLES = {"good": "green", "caution": "yellow", "bad": "red"}
# signs that do not break over a line of a page, as they are typed
_PLAIN = str.maketrans("\u00a0\u2011", " -")


class _Console(Console):
    """A console that leaves a reader who has seen enough to the command; rich would end it with status 1."""

    def on_broken_pipe(self) -> None:
        """Raise the error again."""
        raise BrokenPipeError


def stdout_console() -> Console:
    """The console for results: as wide as the terminal, or 160 columns in a pipe."""
    console = _Console(highlight=False)
    return console if console.is_terminal else _Console(highlight=False, width=160)


def show(result: xr.Dataset, console: Console) -> None:
    """Print a result of any kind: title, warnings, then its tables."""
    title, doi = result.attrs.get("title", ""), result.attrs.get("doi")
    if title or doi:
        console.print(f"[bold]{escape(title)}[/bold]" + (f"  doi {escape(doi)}" if doi else ""))
    for warning in warnings_of(result):
        console.print(f"[yellow]warning:[/yellow] {escape(warning)}", soft_wrap=True)
    for table in tables_of(result):
        console.print()
        # a title in the table would wrap at its width, which is less where columns are few
        console.print(f"[bold]{escape(table.title)}[/bold]", soft_wrap=True)
        if table.lead:
            console.print(escape(table.lead), soft_wrap=True)
        console.print(rich_table(table))
        if table.notes:
            console.print(_notes(table.notes))


def _notes(notes: Sequence[str]) -> RichTable:
    """Numbered notes, whose lines begin below each other."""
    drawn = RichTable.grid(padding=(0, 2))
    drawn.add_column(justify="right", min_width=4, no_wrap=True)
    drawn.add_column(overflow="fold")
    for place, text in enumerate(notes, start=1):
        drawn.add_row(f"[bold]{place}[/bold]", escape(text))
    return drawn


def rich_table(table: Table) -> RichTable:
    """A table as rich draws it, without its title."""
    drawn = RichTable(box=SIMPLE_HEAD, pad_edge=False)
    columns = shown_columns(table, number)
    for heading, numeric, _ in columns:
        drawn.add_column(escape(heading), justify="right" if numeric else "left", overflow="fold")
    for row in zip(*(cells for _, _, cells in columns), strict=True):
        drawn.add_row(*(_cell(text, tone) for text, tone in row))
    return drawn


def _cell(text: str, tone: str) -> str:
    return f"[{_STYLES[tone]}]{escape(text)}[/]" if tone else escape(text)


def warnings_of(result: xr.Dataset) -> list[str]:
    """The physical warnings of a result."""
    return [str(text) for text in json.loads(result.attrs.get("warnings", "[]"))]


def show_pairs(pairs: Mapping[str, str], console: Console) -> None:
    """Print names and what they are, one a line."""
    width = max(map(len, pairs), default=0)
    for name, text in pairs.items():
        console.print(f"[bold]{escape(name.translate(_PLAIN)):{width}}[/bold]  {escape(text)}", soft_wrap=True)
