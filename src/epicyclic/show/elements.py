"""What a view is made of: tables, figures, sections; `console` draws them in a terminal, `report` in a page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import plotly.graph_objects as go


@dataclass(frozen=True, slots=True, kw_only=True)
class Styled:
    """Text of a cell that is good, for caution or bad.  tone : ``good``, ``caution``, ``bad``, or empty."""

    text: str
    tone: str = ""

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Named columns of equal length, the one source of a terminal's and a page's table.

    columns : heading with its unit -> cells, numbers in the unit of the heading; nan is an empty cell.  Columns with
        nothing in them are not shown, columns without text stand to the right.
    lead : a sentence above, notes : numbered sentences below.
    digits : significant digits of numbers in a page; decimals : their decimal places instead.
    """

    title: str
    columns: Mapping[str, Sequence[Any]]
    lead: str = ""
    notes: tuple[str, ...] = ()
    digits: int = 5
    decimals: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureText:
    """A figure as the page takes it.  json : without the template of the page.  height : in px."""

    json: str
    height: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawing:
    """A figure.  anchor : its id in the page, without ``figure-``.  caption : how to read it."""

    anchor: str
    figure: go.Figure | FigureText
    caption: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Listing:
    """Text as it stands, in a type of equal widths."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Details:
    """Parts that are folded away until asked for.  summary : what is clicked on."""

    summary: str
    parts: Sequence[Part]


Part = Table | Drawing | Listing | Details


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """One part of the report.  anchor : its id.  title : its heading, and its entry in the list of contents."""

    anchor: str
    title: str
    parts: Sequence[Part]


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A sentence of the first page of a report: what passes, what does not, and what would change it.

    tone : ``good`` passes, ``caution`` is to be looked at, ``bad`` fails, empty is for knowing.  text : one sentence
    with its number and its limit, where there is one.  change : what to do.  anchor : of the section that says more.
    """

    tone: str
    text: str
    change: str = ""
    anchor: str = ""


KeyFigure = tuple[str, str]  # a value with its unit, and what it is
Company = Mapping[str, Any]  # kind of result -> the first Dataset of that kind in the report


# Part of the largest number of a column below which another is rounding.
_ROUNDING = 1e-9


def number(value: Any) -> str:
    """A cell as text: six significant digits, nothing for nan."""
    if isinstance(value, float | np.floating):
        return "" if np.isnan(value) else f"{value + 0.0:.6g}"  # + 0.0: no negative zero
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(number, value))}]"
    return str(value)


def listed(values: Iterable[float]) -> str:
    """Numbers in a row, five significant digits each."""
    return ", ".join(f"{value:.5g}" for value in values)


def _without_rounding(values: Sequence[Any]) -> Sequence[Any]:
    """Cells of a column, 0 in place of numbers that are the rounding of its largest."""
    real = [isinstance(value, float | np.floating) and bool(np.isfinite(value)) for value in values]
    least = _ROUNDING * max((abs(value) for value, known in zip(values, real, strict=True) if known), default=0.0)
    return [0.0 if known and abs(value) < least else value for value, known in zip(values, real, strict=True)]


def shown_columns(table: Table, text: Callable[[Any], str]) -> list[tuple[str, bool, list[tuple[str, str]]]]:
    """Heading, whether it holds numbers alone, and (text, tone) of every cell, of the columns that hold something.

    Parameters
    ----------
    text : how a cell that is no text is written.
    """
    found = []
    for heading, values in table.columns.items():
        if "[" in heading:  # numbers of one unit; others stand beside each other with units of their own
            values = _without_rounding(values)
        cells = [(str(value) if isinstance(value, str | Styled) else text(value), _tone(value)) for value in values]
        if cells and not any(words for words, _ in cells):
            continue
        numeric = not any(isinstance(value, str | Styled) for value in values)
        found.append((heading, numeric, cells))
    return found


def _tone(value: Any) -> str:
    return value.tone if isinstance(value, Styled) else ""
