"""Results for people in a terminal: title, warnings, tables with units; names and what they are.

Prose is laid in lines of a width, in which words, and numbers with their units, stay whole.  A table is cut for it so
that no name, number or unit is broken: wide ones in parts, long ones by head and largest.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from rich.cells import cell_len
from rich.console import Console
from rich.markup import escape
from rich.text import Text

from ..results.dataset import largest
from ..warning_codes import code_of
from .elements import Table, number, shown_columns
from .views import brief_of, findings_of, tables_of

_GLUE = "\u00a0"  # a space at which no line ends; textwrap breaks at the spaces of ASCII alone
_UNIT = r"(?:%|rpm|deg|(?:[kMGmuµn])?(?:Hz|N|W|m|g|Pa|s|rad|J|V)(?:[/^·*²³][^\s,;]*)?|(?:N|kN|MN) m(?:/rad)?)"
_NUMBER = re.compile(rf"(?<=\d) (?={_UNIT}(?:[\s,;.:)\]]|$))")
_MOMENT = re.compile(r"(?<=\d[ \u00a0]N|[ \u00a0][kM]N) (?=m\b)")
_BRACKET = re.compile(r"\[[^\[\]]{1,24}\]")


def glued(text: str) -> str:
    """Text whose spaces between a number and its unit, and inside a short bracket, end no line."""
    text = _MOMENT.sub(_GLUE, _NUMBER.sub(_GLUE, text))
    return _BRACKET.sub(lambda found: found[0].replace(" ", _GLUE), text)


def longest_word(text: str) -> int:
    """Letters of the longest piece of a glued text at which no line may end."""
    return max(map(len, text.split(" ")), default=0)


def wrapped(text: str, width: int, *, first: str = "", later: str = "") -> list[str]:
    """Lines of at most a width; a word that is longer stands whole on a line of its own.

    Parameters
    ----------
    width : letters of a line.  first, later : what the first line and the others begin with.
    """
    found: list[str] = []
    for place, line in enumerate(text.splitlines() or [""]):
        begin = later if place else first
        room = max(width, len(begin) + 1)
        wrapper = textwrap.TextWrapper(room, begin, later, break_long_words=False, break_on_hyphens=False)
        lines = wrapper.wrap(glued(line))
        found += lines or [begin.rstrip()]
    return [line.replace(_GLUE, " ") for line in found]


GAP = 2
"""Columns of the terminal between two columns of a table."""
# A cell of text up to this is a name and stays on one line: the longest paths of the ready drives have some forty
# letters. A longer one is prose, which is read well from 30 letters a line on.
_NAME, _PROSE = 44, 30
# Parts of one table: what is wider is taken from a file.
_PARTS = 4
# A table is cut when it has more rows than a screen and a half. What is left is a screen.
_ROWS, _HEAD, _LARGEST = 60, 30, 8
_MORE = "--json or -o file.csv"


class TextColumn(NamedTuple):
    """One column as it is drawn.

    heading : its lines.  numeric : stands to the right.  cells : (lines, tone) of every row.  width : of the terminal.
    """

    heading: Sequence[str]
    numeric: bool
    cells: Sequence[tuple[Sequence[str], str]]
    width: int


class CutTable(NamedTuple):
    """A table for one width.  parts : columns of each, names of the rows in all.  more : what is left out, in words."""

    parts: Sequence[Sequence[TextColumn]]
    more: Sequence[str]


class _Texts(NamedTuple):
    """A column before it has a width.  least, most : widths at which words, and cells, stay whole."""

    heading: str
    numeric: bool
    cells: list[tuple[str, str]]
    least: int
    most: int


def laid_out(table: Table, width: int, *, whole: bool = False) -> CutTable:
    """Columns of a table in parts of at most a width.

    Parameters
    ----------
    width : columns of the terminal.  whole : all rows, whatever their number.

    Returns
    -------
    CutTable : a part begins with the columns that name the rows.  Of more than 60 rows the first, those with something
        bad, and those with the largest number of a column.
    """
    columns = [_texts(*column) for column in shown_columns(table, number)]
    if not columns:
        return CutTable(parts=(), more=())
    rows = len(columns[0].cells)
    kept = list(range(rows)) if whole or rows <= _ROWS else _kept_rows(table, columns, rows)
    columns = [_texts(one.heading, one.numeric, [one.cells[row] for row in kept]) for one in columns]
    parts, left = _parts(columns, width)
    more = [f"... {rows - len(kept)} more: {_MORE}"] if len(kept) < rows else []
    if left:
        more.append(f"... {len(left)} more columns ({', '.join(one.heading for one in left)}): {_MORE}")
    return CutTable(parts=[_drawn(part, width) for part in parts], more=more)


def _texts(heading: str, numeric: bool, cells: list[tuple[str, str]]) -> _Texts:
    lengths = [len(text) for text, _ in cells]
    longest = max(lengths, default=0)
    words = max((longest_word(glued(text)) for text, _ in cells), default=0)
    least = longest if numeric or longest <= _NAME else max(words, _PROSE)
    head = longest_word(glued(heading))
    # where there is room a heading takes two lines, else as many as it has words
    two = next(width for width in range(head, len(heading) + 2) if len(wrapped(heading, width)) <= 2)
    return _Texts(heading=heading, numeric=numeric, cells=cells, least=max(least, head), most=max(longest, two))


def _kept_rows(table: Table, columns: Sequence[_Texts], rows: int) -> list[int]:
    """The first rows; those with something bad; of every column of numbers the row of its largest, the last first."""
    found = set(range(_HEAD))
    bad = [row for one in columns for row, (_, tone) in enumerate(one.cells) if tone == "bad"]
    largest = [_largest(table.columns[one.heading]) for one in reversed(columns) if one.numeric]
    found |= set(bad[: _ROWS - _HEAD - _LARGEST])
    beyond = [row for row in dict.fromkeys(largest) if row is not None and row not in found]
    return sorted(found | set(beyond[:_LARGEST]))


def _largest(values: Sequence[Any]) -> int | None:
    """Row of the largest magnitude of a column that varies; None where there is none."""
    numbers = [isinstance(value, int | float | np.number) and not isinstance(value, bool) for value in values]
    sizes = np.array([abs(float(value)) if real else np.nan for value, real in zip(values, numbers, strict=True)])
    known = sizes[np.isfinite(sizes)]
    if not known.size or known.min() == known.max():
        return None
    return largest(np.where(np.isfinite(sizes), sizes, -1.0))


def _keys(columns: Sequence[_Texts], room: int) -> list[_Texts]:
    """Columns that stand first in every part: those of text until no two rows have the same, or one of numbers.

    Row numbers take their place where they do not tell the rows apart, or leave no room beside them.
    """
    for count in range(1, len(columns) + 1):
        first = list(columns[:count])
        names = list(zip(*([text for text, _ in one.cells] for one in first), strict=True))
        if len(set(names)) == len(names) and _total(first) <= room:
            return first
        if len(set(names)) == len(names) or first[-1].numeric:
            break
    return [_texts("row", True, [(str(row), "") for row in range(1, len(columns[0].cells) + 1)])]


def _parts(columns: list[_Texts], width: int) -> tuple[list[list[_Texts]], list[_Texts]]:
    """Columns by part, and those that have no place in the parts."""
    if _total(columns) <= width:
        return [columns], []
    keys = _keys(columns, width - GAP - max(one.least for one in columns[1:]) if columns[1:] else width)
    rest = [one for one in columns if not any(one is key for key in keys)]
    parts: list[list[_Texts]] = []
    for place, one in enumerate(rest):
        if parts and _total([*parts[-1], one]) <= width:
            parts[-1].append(one)
        elif len(parts) == _PARTS:
            return parts, rest[place:]
        else:
            parts.append([*keys, one])
    return parts or [columns], []


def _total(columns: Sequence[_Texts]) -> int:
    return sum(one.least for one in columns) + GAP * (len(columns) - 1)


def _drawn(columns: Sequence[_Texts], width: int) -> list[TextColumn]:
    """Columns with their widths: each as wide as its words need, prose shares what is left."""
    widths = [one.least for one in columns]
    spare = width - sum(widths) - GAP * (len(columns) - 1)
    for place in sorted(range(len(columns)), key=lambda place: columns[place].most - columns[place].least):
        more = min(columns[place].most - widths[place], max(spare, 0))
        widths[place] += more
        spare -= more
    drawn = []
    for one, size in zip(columns, widths, strict=True):
        texts = [[text] if one.numeric or len(text) <= size else wrapped(text, size) for text, _ in one.cells]
        cells = [(lines, tone) for lines, (_, tone) in zip(texts, one.cells, strict=True)]
        drawn.append(TextColumn(wrapped(one.heading, size), one.numeric, cells, size))
    return drawn


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
    console, columns = _Console(highlight=False), os.environ.get("COLUMNS", "")
    console.width = shutil.get_terminal_size().columns if console.is_terminal else 160
    if columns.isdecimal() and 0 < int(columns[:9]):
        console.width = max(int(columns[:9]), _LEAST_WIDTH)
    return console


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
    # of the warnings above a report makes findings too
    found = [finding for finding in findings_of({"": result}) if finding.anchor != "warnings"]
    if found:
        console.print()
    for finding in found:
        words = " ".join(filter(None, (finding.text, finding.change))).translate(_PLAIN)
        _print_lines(wrapped(words, console.width), console, style=_STYLES.get(finding.tone, ""))


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
    head = f"{len(texts)} warning{'s' if len(texts) != 1 else ''}:"
    console.print(head, style="yellow", markup=False, highlight=False)
    for text in texts:
        code = code_of(text)
        lines = wrapped(text, console.width, first="  - ", later="    ") if console.is_terminal else [f"  - {text}"]
        for line in lines:
            drawn = Text(line)
            if code:
                drawn.highlight_regex(rf"\[{re.escape(code)}\]$", "dim")
            console.print(drawn, soft_wrap=True, highlight=False)


def warnings_of(result: xr.Dataset) -> list[str]:
    """The physical warnings of a result."""
    return [str(text) for text in json.loads(result.attrs.get("warnings", "[]"))]


def show_pairs(pairs: Mapping[str, str], console: Console) -> None:
    """Print names and what they are, one a line."""
    width = max(map(len, pairs), default=0)
    for name, text in pairs.items():
        console.print(f"[bold]{escape(name.translate(_PLAIN)):{width}}[/bold]  {escape(text)}", soft_wrap=True)
