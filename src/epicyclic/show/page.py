"""Tables, figures and findings as HTML; figures and plotly.js go into a page compressed."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from .charts.style import template
from .elements import Details, Drawing, FigureText, Finding, Part, Section, Table, number, shown_columns
from .series import engineering

# of zlib: the largest block, plotly.js, takes 0.15 s, half of level 9, and is half a per cent larger
_LEVEL = 6
# Letters from which the text of a cell is a sentence: names of meshes and energies have fewer.
_SENTENCE = 44
_CODE = re.compile(r"^(.*) \[([a-z][a-z0-9-]*)\]$", re.DOTALL)
_WORDS = {"good": "passes", "caution": "look at", "bad": "fails", "": "note"}
_MARKS = {"good": "✓", "caution": "!", "bad": "✗", "": "·"}


def resource(name: str) -> str:
    """Text of a file beside this module."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def packed(text: str) -> str:
    """A text compressed (zlib), in base64; a page unpacks it by itself, without a server."""
    return base64.b64encode(zlib.compress(text.encode("utf-8"), _LEVEL)).decode("ascii")


def plotly_blob() -> str:
    """plotly.js, packed."""
    return packed(get_plotlyjs())


class Page:
    """Parts of sections as HTML; an anchor that comes again gets a number.  figures : what the page's script draws."""

    def __init__(self) -> None:
        self.figures: dict[str, Any] = {}
        self._seen: Counter[str] = Counter()

    def anchor(self, name: str) -> str:
        self._seen[name] += 1
        return name if self._seen[name] == 1 else f"{name}-{self._seen[name]}"

    def html(self, parts: Iterable[Part]) -> str:
        return "".join(map(self._part, parts))

    def figure_text(self) -> str:
        """All figures as one JSON text, the template that they share once."""
        figures = ",".join(f"{json.dumps(anchor)}:{text}" for anchor, text in self.figures.items())
        return f'{{"template":{json.dumps(_look())},"figures":{{{figures}}}}}'

    def _part(self, part: Part) -> str:
        if isinstance(part, Table):
            return html_table(part)
        if isinstance(part, Drawing):
            return self._figure(part)
        if isinstance(part, Details):
            return f"<details><summary>{escape(part.summary)}</summary>{self.html(part.parts)}</details>"
        return f"<pre>{escape(part.text)}</pre>"

    def _figure(self, part: Drawing) -> str:
        """Room for a figure, which the script of the page draws when it is first seen."""
        anchor = self.anchor(f"figure-{part.anchor}")
        figure = part.figure if isinstance(part.figure, FigureText) else _figure_text(part.figure)
        self.figures[anchor] = figure.json
        words = f"<figcaption>{escape(part.caption)}</figcaption>" if part.caption else ""
        style = f"height:{figure.height:g}px"
        return f'<figure><div id="{anchor}" class="plotly-graph-div" style="{style}"></div>{words}</figure>'


def printed(section: Section) -> Section:
    """A section whose figures are text: what a worker sends fast, since figures are checked anew when unpickled."""
    return replace(section, parts=[_printed(part) for part in section.parts])


def _printed(part: Part) -> Part:
    if isinstance(part, Drawing) and not isinstance(part.figure, FigureText):
        return replace(part, figure=_figure_text(part.figure))
    return replace(part, parts=[_printed(one) for one in part.parts]) if isinstance(part, Details) else part


@cache
def _look() -> Any:
    """The template that all figures of a page share."""
    return template().to_plotly_json()


def _figure_text(figure: go.Figure) -> FigureText:
    """A figure as JSON, without its template where that is the one of the page."""
    look = figure.layout.template
    height = figure.layout.height or 420
    if look.to_plotly_json() != _look():
        return FigureText(json=figure.to_json(validate=False), height=height)
    figure.layout.template = None
    text = figure.to_json(validate=False)
    figure.layout.template = look
    return FigureText(json=text, height=height)


def html_table(table: Table) -> str:
    """A table as HTML: the heading of a column of numbers and its cells to the right."""
    columns = shown_columns(table, lambda value: _cell(value, table))
    heads = "".join(f'<th scope="col"{_numeric(numeric)}>{escape(name)}</th>' for name, numeric, _ in columns)
    kinds = [_numeric(numeric) or _long(cells) for _, numeric, cells in columns]
    rows = zip(*(cells for _, _, cells in columns), strict=True)
    body = "".join(
        "<tr>" + "".join(f"<td{kind}>{_toned(*cell)}</td>" for kind, cell in zip(kinds, row, strict=True)) + "</tr>"
        for row in rows
    )
    title = f"<caption>{escape(table.title)}</caption>" if table.title else ""
    lead = f'<p class="lead">{escape(table.lead)}</p>' if table.lead else ""
    notes = "".join(f"<li>{escape(text)}</li>" for text in table.notes)
    # tabindex: what scrolls must be reached by keyboard
    return (
        f'{lead}<div class="table" tabindex="0"><table>{title}<thead><tr>{heads}</tr></thead><tbody>{body}</tbody>'
        "</table></div>" + (f"<ol>{notes}</ol>" if notes else "")
    )


def finding_list(findings: Iterable[Finding], anchors: Iterable[str]) -> str:
    """What passes, what does not, what to change, as a list; links to those anchors that the page has."""
    known = set(anchors)
    items = []
    for one in findings:
        link = f' <a href="#{escape(one.anchor)}">more</a>' if one.anchor in known else ""
        change = f'<span class="change">{escape(one.change)}</span>' if one.change else ""
        items.append(
            f'<li class="{one.tone or "plain"}"><b class="mark" title="{_WORDS[one.tone]}">{_MARKS[one.tone]}</b>'
            f'<div><span class="verdict">{_WORDS[one.tone]}</span> {escape(one.text)}{link}{change}</div></li>'
        )
    return f'<ul class="findings">{"".join(items)}</ul>' if items else ""


def html_warning(text: str) -> str:
    """A warning; its code, where it ends in one, says how to ask for more."""
    match = _CODE.match(text)
    if match is None:
        return escape(text)
    words, code = match.groups()
    return f'{escape(words)} <code title="epicyclic explain {code}">{code}</code>'


def _cell(value: object, table: Table) -> str:
    """A cell that is no text: a number as the table wants it, else as in a terminal."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        return number(value)
    if table.decimals is not None:
        return f"{value:.{table.decimals}f}" if np.isfinite(value) else ""
    return engineering(float(value), table.digits)


def _numeric(numeric: bool) -> str:
    return ' class="number"' if numeric else ""


def _long(cells: Sequence[tuple[str, str]]) -> str:
    """A column of sentences may break over lines; one of names may not."""
    return ' class="long"' if any(len(text) > _SENTENCE for text, _ in cells) else ""


def _toned(text: str, tone: str) -> str:
    return f'<span class="{tone}">{escape(text)}</span>' if tone else escape(text)
