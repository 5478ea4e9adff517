"""A table cut for a width: no name, number or unit is broken; wide ones in parts, long ones by head and largest."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ..results.ties import largest
from .elements import Table, number, shown_columns
from .wrapped import glued, longest_word, wrapped

__all__ = ["GAP", "CutTable", "TextColumn", "laid_out"]

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


@dataclass(frozen=True, slots=True, kw_only=True)
class TextColumn:
    """One column as it is drawn.

    heading : its lines.  numeric : stands to the right.  cells : (lines, tone) of every row.  width : of the terminal.
    """

    heading: Sequence[str]
    numeric: bool
    cells: Sequence[tuple[Sequence[str], str]]
    width: int


@dataclass(frozen=True, slots=True, kw_only=True)
class CutTable:
    """A table for one width.  parts : columns of each, names of the rows in all.  more : what is left out, in words."""

    parts: Sequence[Sequence[TextColumn]]
    more: Sequence[str]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Texts:
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
    head = _HEAD
    found = set(range(head))
    bad = [row for one in columns for row, (_, tone) in enumerate(one.cells) if tone == "bad"]
    largest = [_largest(table.columns[one.heading]) for one in reversed(columns) if one.numeric]
    room = _ROWS - head - _LARGEST
    found |= set(bad[:room])
    beyond = [row for row in dict.fromkeys(largest) if row is not None and row not in found]
    return sorted(found | set(beyond[:_LARGEST]))


def _largest(values: Sequence[object]) -> int | None:
    """Row of the largest magnitude of a column that varies; None where there is none."""
    sizes = np.array([_size(value) for value in values])
    known = sizes[np.isfinite(sizes)]
    if not known.size or known.min() == known.max():
        return None
    return largest(np.where(np.isfinite(sizes), sizes, -1.0))


def _size(value: object) -> float:
    is_number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    return abs(float(value)) if is_number else np.nan  # type: ignore[arg-type]


def _keys(columns: Sequence[_Texts], room: int) -> list[_Texts]:
    """Columns that stand first in every part: those of text until no two rows have the same, or one of numbers.

    Row numbers take their place where they do not tell the rows apart, or leave no room beside them.
    """
    for count in range(1, len(columns) + 1):
        names = list(zip(*([text for text, _ in one.cells] for one in columns[:count]), strict=True))
        if len(set(names)) == len(names):
            if _total(columns[:count]) <= room:
                return list(columns[:count])
            break
        if columns[count - 1].numeric:
            break
    rows = [(str(row), "") for row in range(1, len(columns[0].cells) + 1)]
    return [_texts("row", True, rows)]


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
    return [_column(one, size) for one, size in zip(columns, widths, strict=True)]


def _column(one: _Texts, width: int) -> TextColumn:
    cells = [(_lines([text], width, one.numeric), tone) for text, tone in one.cells]
    return TextColumn(heading=wrapped(one.heading, width), numeric=one.numeric, cells=cells, width=width)


def _lines(texts: Iterable[str], width: int, numeric: bool) -> list[str]:
    return [line for text in texts for line in ([text] if numeric or len(text) <= width else wrapped(text, width))]
