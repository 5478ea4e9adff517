"""Results for people in a terminal: title, warnings, tables with units; names and what they are."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rich.cells import cell_len
from rich.console import Console
from rich.markup import escape
from rich.text import Text

from ..warning_codes import code_of
from .elements import Table
from .layout import GAP, TextColumn, laid_out
from .views import brief_of, tables_of
from .wrapped import wrapped

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "show",
    "show_pairs",
    "show_table",
    "show_warnings",
    "stderr_console",
    "stdout_console",
    "warnings_of",
]

# columns in which a table of numbers can be read at all
_LEAST_WIDTH = 40
_STYLES = {"good": "green", "caution": "yellow", "bad": "red"}
# signs that do not break over a line of a page, as they are typed
_PLAIN = str.maketrans("\u00a0\u2011", " -")


class _Console(Console):
    """A console that leaves a reader who has seen enough to the command; rich would end it with status 1."""

    def on_broken_pipe(self) -> None:
        """Raise the error again."""
        raise BrokenPipeError


def stdout_console() -> Console:
    """The console for results: of COLUMNS, else as wide as the terminal, or 160 columns in a pipe."""
    console = _Console(highlight=False)
    columns = os.environ.get("COLUMNS", "")
    if columns.isdecimal() and 0 < int(columns[:9]):
        return _Console(highlight=False, width=max(int(columns[:9]), _LEAST_WIDTH))
    width = shutil.get_terminal_size().columns if console.is_terminal else 160
    return _Console(highlight=False, width=width)


def stderr_console() -> Console:
    """The console for warnings beside results that go elsewhere."""
    return _Console(highlight=False, stderr=True)


def show(result: xr.Dataset, console: Console, *, whole: bool = False) -> None:
    """Print a result of any kind: title, warnings, then its tables.

    Parameters
    ----------
    whole : all tables with all rows, also those that a brief view leaves out.
    """
    title, doi = str(result.attrs.get("title", "")), str(result.attrs.get("doi") or "")
    beside = f"  doi {doi}" if doi else ""
    if len(title + beside) <= console.width:
        console.print(Text(title, style="bold"), Text(beside), sep="", soft_wrap=True)
    else:
        _print_lines(wrapped(title, console.width), console, style="bold")
        _print_lines([beside] if doi else (), console)
    show_warnings(warnings_of(result), console)
    for table in tables_of(result) if whole else brief_of(result):
        show_table(table, console, whole=whole)


def show_table(table: Table, console: Console, *, whole: bool = False) -> None:
    """Print a table below an empty line: title, lead, parts as wide as the console, what is left out, notes."""
    width = console.width
    # who reads a pipe looks for something, and must find every row
    found = laid_out(table, width, whole=whole or not console.is_terminal)
    console.print()
    _print_lines(wrapped(table.title, width) if table.title else (), console, style="bold")
    _print_lines(wrapped(table.lead, width) if table.lead else (), console)
    for place, part in enumerate(found.parts):
        if place:
            console.print()
        _print_part(part, console)
    _print_lines([line for text in found.more for line in wrapped(text, width, later="    ")], console, style="dim")
    for place, text in enumerate(table.notes, start=1):
        _print_lines(wrapped(text, width, first=f"{place:4}  ", later="      "), console)


def _print_lines(lines: Sequence[str], console: Console, style: str = "") -> None:
    for line in lines:
        console.print(line, markup=False, style=style, soft_wrap=True)


def _print_part(part: Sequence[TextColumn], console: Console) -> None:
    """Print a part of a table; its lines are broken already, and are the same with every version of rich."""
    height = max(len(one.heading) for one in part)
    for line in range(-height, 0):
        row = [(one.heading[line] if len(one.heading) >= -line else "", "") for one in part]
        console.print(_row(part, row, "bold"), soft_wrap=True)
    console.print(Text("─" * (sum(one.width for one in part) + GAP * (len(part) - 1))), soft_wrap=True)
    for cells in zip(*(one.cells for one in part), strict=True):
        for line in range(max(len(lines) for lines, _ in cells)):
            row = [(lines[line] if line < len(lines) else "", tone) for lines, tone in cells]
            console.print(_row(part, row), soft_wrap=True)


def _row(part: Sequence[TextColumn], row: Sequence[tuple[str, str]], style: str = "") -> Text:
    """One line of a part, numbers to the right."""
    drawn = Text(style=style)
    for place, (one, (text, tone)) in enumerate(zip(part, row, strict=True)):
        space = " " * max(one.width - cell_len(text), 0)
        drawn.append(" " * GAP if place else "")
        drawn.append(space if one.numeric else "")
        drawn.append(text, style=_STYLES.get(tone, ""))
        drawn.append("" if one.numeric else space)
    drawn.rstrip()
    return drawn


def show_warnings(texts: Sequence[str], console: Console) -> None:
    """Print warnings as a list below their number; their codes dimmed, lines broken in a terminal alone."""
    if not texts:
        return
    console.print(_counted(len(texts)), style="yellow", markup=False, highlight=False)
    for text in texts:
        code = code_of(text)
        lines = wrapped(text, console.width, first="  - ", later="    ") if console.is_terminal else [f"  - {text}"]
        for line in lines:
            drawn = Text(line)
            if code:
                drawn.highlight_regex(rf"\[{re.escape(code)}\]$", "dim")
            console.print(drawn, soft_wrap=True, highlight=False)


def _counted(number: int) -> str:
    """Head of a list of warnings: ``1 warning:``, ``3 warnings:``."""
    return f"{number} warning{'s' if number != 1 else ''}:"


def warnings_of(result: xr.Dataset) -> list[str]:
    """The physical warnings of a result."""
    return [str(text) for text in json.loads(result.attrs.get("warnings", "[]"))]


def show_pairs(pairs: Mapping[str, str], console: Console) -> None:
    """Print names and what they are, one a line."""
    width = max(map(len, pairs), default=0)
    for name, text in pairs.items():
        console.print(f"[bold]{escape(name.translate(_PLAIN)):{width}}[/bold]  {escape(text)}", soft_wrap=True)
